// Pairs of a receiver and a sun, or its image in flat mirrors.

import package::generated::{PairParams, Receiver, SunRecord};
import package::shared::random::{sample_pair, hash_combine};
import package::sun_matrix::gates::{may_come_in};
import package::sun_matrix::mirrored::{MIRRORED, image_of};
import package::sun_matrix::sun::{sun_direction};

@group(0) @binding(6) var<uniform> params: PairParams;
// [receiver], or [batch][receiver]
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(8) var<storage, read> suns: array<SunRecord>;

fn receiver_of(cell: u32) -> Receiver {
    return receivers[cell / params.receivers * params.batch_stride + cell % params.receivers];
}

fn image() -> mat3x3<f32> {
    return mat3x3<f32>(params.image_x, params.image_y, params.image_z);
}

// Whether light could come to a receiver along a direction.
fn is_open(receiver: Receiver, direction: vec3<f32>) -> bool {
    return dot(direction, receiver.normal) > 0.0 && (MIRRORED || may_come_in(receiver.position, direction, params.gates, params.window_count));
}

fn stream(receiver: Receiver, sun: SunRecord, batch: u32, own: bool) -> u32 {
    let seed = select(params.seed, hash_combine(params.seed, batch), own);
    return hash_combine(hash_combine(seed, receiver.number), sun.number);
}

// A receiver's direction to point `sample` of a disc; from `disc_samples` on, of its rim. Where every batch
// has receivers of its own, points behind a pixel, they share out the points of the disc.
fn pair_direction(receiver: Receiver, sun: SunRecord, batch: u32, sample: u32) -> vec3<f32> {
    if sample >= params.disc_samples {
        let turn = sample_pair(0u, 0x8000u, stream(receiver, sun, batch, true)).x;
        return image_of(sun_direction(sun, vec2<f32>(1.0, (f32(sample - params.disc_samples) + turn) / f32(params.rim))), image());
    }
    let own = params.batch_stride == 0u;
    let first = select(batch * params.disc_samples, 0u, own);
    return image_of(sun_direction(sun, sample_pair(first + sample, 0u, stream(receiver, sun, batch, own))), image());
}
