//! A sun's picture in few bytes: what of it grows with pixels and suns.
//!
//! | part | bytes | kept to |
//! |---|---|---|
//! | numbers of pixels, those of the disc for themselves | some per run of neighbours | exactly |
//! | radiance | 4 per pixel | 0.2 % of the pixel's largest channel, or 2⁻⁴⁰ of the picture's |
//! | standard errors | 1 per pixel for each kind that there is | 4.5 %, and 2·10⁻⁸ of the pixel's luminance |
//! | discs | 32 each | exactly |
//! | [`SharedNoise`] | 5 per batch of a block, at most | 0.4 % of the block's greatest deviation |
//!
//! Radiance is rounded to the nearest, so that over many pixels nothing is lost or gained.

use crate::kernels::glare::SharedNoise;
use crate::kernels::sun_matrix::pixels::{SeenDisc, SparsePicture, SunPicture};
use crate::units::ILLUMINANCE_WEIGHTS;

/// Bits of a channel.
const MANTISSA: u32 = 9;
const MOST: f64 = 511.0;
/// Most halvings of the picture's scale.
const MOST_SHIFT: i32 = 31;
/// Steps of an error per doubling, and the code of an error as large as the luminance.
const STEPS: f64 = 8.0;
const UNITY: f64 = 207.0;

/// Far more batches than anybody asks for.
const MOST_BATCHES: usize = 1 << 12;

/// The bytes of a picture.
pub(super) fn encode(picture: &SunPicture) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(64 + picture.pixels.len() * 6);
    let kinds = [&picture.errors, &picture.shared_errors].map(|errors| errors.iter().any(|e| *e > 0.0));
    bytes.push(u8::from(kinds[0]) | u8::from(kinds[1]) << 1);
    let (codes, steps) = encode_pixels(&picture.pixels, &mut bytes);
    for (errors, _) in [&picture.errors, &picture.shared_errors].into_iter().zip(kinds).filter(|(_, there)| *there) {
        bytes.extend(codes.iter().zip(errors).map(|(code, error)| error_code(f64::from(*error), luminance(colour(*code, &steps)))));
    }
    encode_pixels(&picture.disc_pixels, &mut bytes);
    write_number(&mut bytes, picture.discs.len() as u64);
    bytes.extend(picture.discs.iter().flat_map(numbers_of).flat_map(f32::to_le_bytes));
    encode_shared(&picture.shared, &mut bytes);
    bytes
}

/// The picture of these bytes, of a view with so many pixels; nothing if they are damaged.
pub(super) fn decode(bytes: &[u8], view: usize) -> Option<SunPicture> {
    let mut rest = bytes;
    let [kinds] = take::<1>(&mut rest)?;
    let pixels = decode_pixels(&mut rest, view)?;
    let ratios: Vec<f64> = (0..256).map(ratio).collect();
    let mut errors = |there: bool| {
        if !there {
            return Some(vec![0.0; pixels.len()]);
        }
        let found = rest.get(..pixels.len())?.iter().zip(&pixels).map(|(code, p)| (ratios[usize::from(*code)] * luminance(p.1)) as f32);
        rest = rest.get(pixels.len()..)?;
        Some(found.collect())
    };
    let (own, shared_errors) = (errors(kinds & 1 > 0)?, errors(kinds & 2 > 0)?);
    let disc_pixels = decode_pixels(&mut rest, view)?;
    let discs = (0..read_number(&mut rest)?).map(|_| decode_disc(&mut rest)).collect::<Option<Vec<_>>>()?;
    let shared = decode_shared(&mut rest)?;
    rest.is_empty().then_some(SunPicture { pixels, discs, disc_pixels, errors: own, shared_errors, shared })
}

/// Numbers and radiances of pixels. Returns the radiances' codes and steps.
fn encode_pixels(pixels: &SparsePicture, bytes: &mut Vec<u8>) -> (Vec<u32>, Steps) {
    let runs: Vec<&[(u32, [f32; 3])]> = pixels.chunk_by(|a, b| a.0.checked_add(1) == Some(b.0)).collect();
    write_number(bytes, pixels.len() as u64);
    write_number(bytes, runs.len() as u64);
    let mut next = 0;
    for run in runs {
        write_number(bytes, u64::from(run[0].0 - next));
        write_number(bytes, run.len() as u64);
        next = run[0].0 + run.len() as u32;
    }
    let greatest = pixels.iter().flat_map(|(_, v)| v).copied().fold(0.0, f32::max);
    let scale = exponent(f64::from(greatest));
    bytes.extend((scale as i16).to_le_bytes());
    let codes: Vec<u32> = pixels.iter().map(|(_, value)| colour_code(*value, scale)).collect();
    codes.iter().for_each(|code| bytes.extend(code.to_le_bytes()));
    (codes, steps(scale))
}

fn decode_pixels(rest: &mut &[u8], view: usize) -> Option<SparsePicture> {
    let count = usize::try_from(read_number(rest)?).ok().filter(|n| *n <= view)?;
    let mut numbers: Vec<u32> = Vec::with_capacity(count);
    let mut next = 0u64;
    for _ in 0..read_number(rest)? {
        let first = next.checked_add(read_number(rest)?)?;
        next = first.checked_add(read_number(rest)?).filter(|n| *n <= view as u64)?;
        numbers.extend(first as u32..next as u32);
        if numbers.len() > count {
            return None;
        }
    }
    let scale = i32::from(i16::from_le_bytes(take(rest)?));
    let steps = steps(scale);
    let codes = rest.get(..count.checked_mul(4)?)?.as_chunks().0;
    *rest = &rest[count * 4..];
    let values = codes.iter().map(|code| colour(u32::from_le_bytes(*code), &steps));
    (numbers.len() == count).then(|| numbers.into_iter().zip(values).collect())
}

/// Numbers of a disc.
const OF_DISC: usize = 8;

fn numbers_of(disc: &SeenDisc) -> [f32; OF_DISC] {
    let SeenDisc { direction: [x, y, z], solid_angle, radiance: [r, g, b], error } = *disc;
    [x, y, z, solid_angle, r, g, b, error]
}

fn decode_disc(rest: &mut &[u8]) -> Option<SeenDisc> {
    let mut numbers = [0.0; OF_DISC];
    for number in &mut numbers {
        *number = f32::from_le_bytes(take(rest)?);
    }
    let [x, y, z, solid_angle, r, g, b, error] = numbers;
    let sound = numbers.iter().all(|v| v.is_finite()) && numbers[3..].iter().all(|v| *v >= 0.0);
    sound.then_some(SeenDisc { direction: [x, y, z], solid_angle, radiance: [r, g, b], error })
}

fn luminance(value: [f32; 3]) -> f64 {
    (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * f64::from(value[c])).sum()
}

/// The least exponent at which a value rounds to no more than the greatest code.
fn exponent(greatest: f64) -> i32 {
    if !(greatest > 0.0 && greatest.is_finite()) {
        return 0;
    }
    let least = greatest.log2().floor() as i32 + 1;
    least + i32::from((greatest / unit(least)).round() > MOST)
}

/// Value of a step of the mantissa.
fn unit(exponent: i32) -> f64 {
    f64::from(exponent - MANTISSA as i32).exp2()
}

/// Channels in 9 bits each and their common shift in 5, after Ward's shared exponent.
fn colour_code(value: [f32; 3], scale: i32) -> u32 {
    let value = value.map(|v| f64::from(v.max(0.0)));
    let own = exponent(value.into_iter().fold(0.0, f64::max));
    let shift = (scale - own).clamp(0, MOST_SHIFT);
    let step = unit(scale - shift);
    let [r, g, b] = value.map(|v| (v / step).round().min(MOST) as u32);
    r | g << MANTISSA | b << (2 * MANTISSA) | (shift as u32) << (3 * MANTISSA)
}

/// Values of a step of the mantissa at all shifts.
type Steps = [f64; MOST_SHIFT as usize + 1];

fn steps(scale: i32) -> Steps {
    std::array::from_fn(|shift| unit(scale - shift as i32))
}

fn colour(code: u32, steps: &Steps) -> [f32; 3] {
    let step = steps[(code >> (3 * MANTISSA)) as usize];
    [0, 1, 2].map(|c| (f64::from((code >> (c * MANTISSA)) & 0x1ff) * step).min(f64::from(f32::MAX)) as f32)
}

fn error_code(error: f64, luminance: f64) -> u8 {
    if !(error > 0.0 && luminance > 0.0) {
        return 0;
    }
    (UNITY + STEPS * (error / luminance).log2()).round().clamp(1.0, 255.0) as u8
}

fn ratio(code: usize) -> f64 {
    if code == 0 { 0.0 } else { ((code as f64 - UNITY) / STEPS).exp2() }
}

fn encode_shared(shared: &SharedNoise, bytes: &mut Vec<u8>) {
    write_number(bytes, shared.batches as u64);
    write_number(bytes, shared.rows.len() as u64);
    let mut next = 0;
    for (number, row) in &shared.rows {
        write_number(bytes, u64::from(number - next));
        next = number + 1;
        let greatest = row.iter().fold(0.0f32, |most, v| most.max(v.abs()));
        bytes.extend(greatest.to_le_bytes());
        bytes.extend(row.iter().map(|v| (f64::from(*v) / f64::from(greatest) * 127.0).round() as i8 as u8));
    }
}

fn decode_shared(rest: &mut &[u8]) -> Option<SharedNoise> {
    let batches = usize::try_from(read_number(rest)?).ok().filter(|n| *n <= MOST_BATCHES)?;
    let mut rows = Vec::new();
    let mut next = 0u32;
    for _ in 0..read_number(rest)? {
        let number = next.checked_add(u32::try_from(read_number(rest)?).ok()?)?;
        next = number.checked_add(1)?;
        let step = f32::from_le_bytes(take(rest)?) / 127.0;
        let row = rest.get(..batches)?;
        *rest = &rest[batches..];
        rows.push((number, row.iter().map(|v| f32::from(*v as i8) * step).collect()));
    }
    Some(SharedNoise { batches, rows })
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, others) = rest.split_first_chunk()?;
    *rest = others;
    Some(*first)
}

/// Seven bits a byte, the lowest first.
fn write_number(bytes: &mut Vec<u8>, mut number: u64) {
    while number > 127 {
        bytes.push(number as u8 | 128);
        number >>= 7;
    }
    bytes.push(number as u8);
}

fn read_number(rest: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for place in 0..9 {
        let [byte] = take::<1>(rest)?;
        number |= u64::from(byte & 127) << (7 * place);
        if byte < 128 {
            return Some(number);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::reference::Random;

    const VIEW: usize = 5000;

    fn picture(seed: u64) -> SunPicture {
        let mut random = Random(seed);
        let mut pixels: Vec<(u32, [f32; 3])> = Vec::new();
        for pixel in 0..VIEW as u32 {
            if pixel % 900 < 700 && random.next() < 0.98 {
                // A room over five decades, and a disc.
                let scale = if pixel == 77 { 1.0 } else { 1e-9 * 10f64.powf(5.0 * random.next()) };
                pixels.push((pixel, [1.0, 0.7 + 0.3 * random.next(), random.next()].map(|v| (v * scale) as f32)));
            }
        }
        let error = |(_, v): &(u32, [f32; 3]), random: &mut Random| (luminance(*v) * 10f64.powf(-4.0 * random.next())) as f32;
        let errors = pixels.iter().map(|p| error(p, &mut random)).collect();
        let shared_errors = pixels.iter().map(|p| if p.0 % 3 == 0 { 0.0 } else { error(p, &mut random) }).collect();
        let rows = [0u32, 1, 7, 300, 1024].map(|n| (n, (0..4).map(|_| (random.next() - 0.5) as f32).collect())).to_vec();
        let disc = |x: f32| SeenDisc { direction: [x, 0.8, 0.0], solid_angle: 6.7e-5 * x, radiance: [0.7, x, 0.5], error: 0.01 };
        let disc_pixels = vec![(76, [0.1, 0.2, 0.3]), (78, [0.4, 0.5, 0.6])];
        SunPicture {
            pixels,
            discs: vec![disc(0.6), disc(0.3)],
            disc_pixels,
            errors,
            shared_errors,
            shared: SharedNoise { batches: 4, rows },
        }
    }

    #[test]
    fn a_picture_is_kept_as_well_as_stated() {
        let wanted = picture(4);
        let bytes = encode(&wanted);
        let found = decode(&bytes, VIEW).unwrap();
        let per_pixel = bytes.len() as f64 / wanted.pixels.len() as f64;
        println!("{per_pixel:.2} bytes per pixel");
        assert!(per_pixel < 6.3, "{per_pixel}");
        let (mut sums, mut worst) = ([0.0; 2], 0.0f64);
        assert_eq!(found.pixels.len(), wanted.pixels.len());
        for (i, (a, b)) in wanted.pixels.iter().zip(&found.pixels).enumerate() {
            assert_eq!(a.0, b.0);
            let most = a.1.into_iter().fold(0.0, f32::max);
            (0..3).for_each(|c| worst = worst.max(f64::from((a.1[c] - b.1[c]).abs() / most)));
            if most < 1.0 {
                sums = [sums[0] + luminance(a.1), sums[1] + luminance(b.1)];
            }
            for (a, b) in [(wanted.errors[i], found.errors[i]), (wanted.shared_errors[i], found.shared_errors[i])] {
                assert!((a - b).abs() <= 0.05 * a, "{i}: {a} {b}");
            }
        }
        println!("values within {worst:.5}, their sum {:.6}", sums[1] / sums[0]);
        assert!(worst <= 1.0 / 512.0 * 1.0001, "{worst}");
        // A bias would be as large as single errors; they even out over thousands of pixels.
        assert!((sums[1] / sums[0] - 1.0).abs() < 1e-4, "{sums:?}");
        for ((n, a), (m, b)) in wanted.shared.rows.iter().zip(&found.shared.rows) {
            assert!(n == m && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.004 * 0.5));
        }
        assert_eq!(found.shared.rows.len(), 5);
        assert_eq!(found.discs, wanted.discs);
        for (a, b) in found.disc_pixels.iter().zip(&wanted.disc_pixels) {
            assert!(a.0 == b.0 && (0..3).all(|c| (a.1[c] - b.1[c]).abs() < 0.002 * b.1[2]));
        }
        assert_eq!(
            found.clone().with_disc().len(),
            found.pixels.len() + 2 - found.pixels.iter().filter(|p| [76, 78].contains(&p.0)).count()
        );
        // What was kept is kept exactly from then on.
        assert!(decode(&encode(&found), VIEW).unwrap().pixels == found.pixels);
    }

    #[test]
    fn extremes_and_nothing_survive() {
        let of = |values: &[[f32; 3]]| {
            let pixels: Vec<_> = (3u32..).zip(values.iter().copied()).collect();
            let picture =
                SunPicture { errors: vec![0.0; pixels.len()], shared_errors: vec![0.0; pixels.len()], pixels, ..SunPicture::default() };
            decode(&encode(&picture), 10).unwrap().pixels.into_iter().map(|p| p.1).collect::<Vec<_>>()
        };
        assert!(of(&[]).is_empty());
        assert_eq!(of(&[[0.0; 3]]), [[0.0; 3]]);
        for value in [f32::MAX, 511.5, 511.4, 1.0, 0.999_99, 1e-30, f32::MIN_POSITIVE] {
            let found = of(&[[value, value / 2.0, -value]])[0];
            assert!((found[0] / value - 1.0).abs() <= 1.0 / 512.0 && (found[1] / value - 0.5).abs() <= 1.0 / 512.0, "{value:e} {found:?}");
            assert_eq!(found[2], 0.0);
        }
        // Far below the brightest pixel little is left, but never more than stated.
        let found = of(&[[1.0; 3], [1e-13; 3]]);
        assert!(found[1][0] <= 5e-13);
    }

    #[test]
    fn damaged_bytes_are_found() {
        let bytes = encode(&picture(9));
        for end in (0..bytes.len()).step_by(7) {
            assert!(decode(&bytes[..end], VIEW).is_none(), "cut off at {end}");
        }
        assert!(decode(&[&bytes[..], &[0]].concat(), VIEW).is_none(), "too long");
        assert!(decode(&bytes, 4000).is_none(), "pixels that the view has not");
        let mut random = Random(1);
        for _ in 0..2000 {
            let mut other = bytes.clone();
            for _ in 0..3 {
                let at = ((random.next() * 60.0) as usize).min(other.len() - 1);
                other[at] = (random.next() * 256.0) as u8;
            }
            if let Some(found) = decode(&other, VIEW) {
                assert!(found.pixels.iter().all(|p| (p.0 as usize) < VIEW) && found.pixels.is_sorted_by(|a, b| a.0 < b.0));
            }
        }
    }
}
