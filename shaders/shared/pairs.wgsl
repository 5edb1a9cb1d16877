// Pairs of a surface point and a sun: [batch][receiver][sun]. Every batch has receivers of its own,
// points behind the same pixels, and they share out the points of the sun's disc.

import package::generated::{PairParams, Receiver, SunRecord};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::sun::{sun_direction};

@group(0) @binding(6) var<uniform> params: PairParams;
// [batch][receiver]
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(8) var<storage, read> suns: array<SunRecord>;

// A receiver's direction to point `sample` of a disc.
fn pair_direction(receiver: Receiver, sun: SunRecord, batch: u32, sample: u32) -> vec3<f32> {
    let seed = hash_combine(hash_combine(params.seed, receiver.number), sun.number);
    return sun_direction(sun, sample_pair(batch * params.disc_samples + sample, 0u, seed));
}
