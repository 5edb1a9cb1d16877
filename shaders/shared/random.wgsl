// Owen-scrambled Sobol points, padded in pairs of dimensions.
//
// A sample is one point of a (0,2)-sequence per pair of dimensions; each pair has its own Owen
// shuffle of the index and Owen scramble of the values (Burley, "Practical Hash-based Owen
// Scrambling", JCGT 2020). Integers only until the last step, so host and device agree bit by bit.

// Mixes the bits of x (bijective).
fn hash_u32(x: u32) -> u32 {
    var h = x;
    h = (h ^ (h >> 16u)) * 0x21f0aaadu;
    h = (h ^ (h >> 15u)) * 0xd35a2d97u;
    return h ^ (h >> 15u);
}

// A seed from two.
fn hash_combine(a: u32, b: u32) -> u32 {
    return hash_u32(a ^ (b * 0x9e3779b9u + 0x85ebca6bu));
}

// Owen scramble of a value whose bits are reversed.
fn owen_scramble_reversed(value: u32, seed: u32) -> u32 {
    var v = value;
    v = v ^ (v * 0x3d20adeau);
    v = v + seed;
    v = v * ((seed >> 16u) | 1u);
    v = v ^ (v * 0x05526c56u);
    v = v ^ (v * 0x53a22864u);
    return v;
}

fn owen_scramble(value: u32, seed: u32) -> u32 {
    return reverseBits(owen_scramble_reversed(reverseBits(value), seed));
}

// Second dimension of the Sobol sequence, bits reversed: Pascal's triangle modulo 2 applied to the
// index.
fn sobol_second_reversed(index: u32) -> u32 {
    var v = index;
    v = v ^ ((v >> 16u) & 0x0000ffffu);
    v = v ^ ((v >> 8u) & 0x00ff00ffu);
    v = v ^ ((v >> 4u) & 0x0f0f0f0fu);
    v = v ^ ((v >> 2u) & 0x33333333u);
    v = v ^ ((v >> 1u) & 0x55555555u);
    return v;
}

// To [0, 1) with 24 bits.
fn unit_f32(bits: u32) -> f32 {
    return f32(bits >> 8u) * 5.9604644775390625e-8;
}

// Pair number `pair` of sample `index` of the stream `seed`, in [0, 1)².
fn sample_pair(index: u32, pair: u32, seed: u32) -> vec2<f32> {
    let stream = hash_combine(seed, pair);
    let shuffled = owen_scramble(index, stream);
    let first = owen_scramble_reversed(shuffled, hash_combine(stream, 1u));
    let second = owen_scramble_reversed(sobol_second_reversed(shuffled), hash_combine(stream, 2u));
    return vec2<f32>(unit_f32(reverseBits(first)), unit_f32(reverseBits(second)));
}
