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

// Sample `index` of the stream `seed` in [0, 1)⁴: Sobol's sequence, Owen-scrambled, evenly spread in
// all four dimensions together (direction numbers of Joe and Kuo 2008).
fn sample_four(index: u32, seed: u32) -> vec4<f32> {
    var third = 0u;
    var fourth = 0u;
    // Direction numbers of this bit and the next ones.
    var a = vec2<u32>(0x80000000u, 0xc0000000u);
    var b = vec3<u32>(0x80000000u, 0xc0000000u, 0x20000000u);
    for (var rest = index; rest != 0u; rest >>= 1u) {
        if (rest & 1u) != 0u {
            third ^= a.x;
            fourth ^= b.x;
        }
        a = vec2<u32>(a.y, a.y ^ a.x ^ (a.x >> 2u));
        b = vec3<u32>(b.y, b.z, b.y ^ b.x ^ (b.x >> 3u));
    }
    let reversed = vec4<u32>(index, sobol_second_reversed(index), reverseBits(third), reverseBits(fourth));
    return vec4<f32>(
        unit_f32(reverseBits(owen_scramble_reversed(reversed.x, hash_combine(seed, 1u)))),
        unit_f32(reverseBits(owen_scramble_reversed(reversed.y, hash_combine(seed, 2u)))),
        unit_f32(reverseBits(owen_scramble_reversed(reversed.z, hash_combine(seed, 3u)))),
        unit_f32(reverseBits(owen_scramble_reversed(reversed.w, hash_combine(seed, 4u)))),
    );
}
