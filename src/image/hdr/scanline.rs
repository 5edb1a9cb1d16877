//! One scanline: shared-exponent pixels and their run-length codes.
//!
//! Three codings are in use (Radiance's `color.c`): flat (four bytes per pixel), old (a pixel
//! 1,1,1,n repeats the one before n times, n shifted by 8 bits for each such pixel in a row) and
//! new (2, 2 and the width, then the four components one after the other in runs and literals).

use super::input::Input;
use crate::error::{Error, Result};
use std::io::Read;

/// Narrower scanlines are written flat, as Radiance does.
const MIN_ENCODED: usize = 17;
/// Wider scanlines cannot be encoded: the width has 15 bits.
const MAX_ENCODED: usize = 0x7fff;
/// Shortest run worth a code of its own.
const MIN_RUN: usize = 4;

/// Exponent byte of 2⁰ (Radiance's `COLXS`).
const EXPONENT_BIAS: i32 = 128;

/// Largest magnitude Radiance encodes as black.
const BLACK_LIMIT: f32 = 1e-32;

/// Mantissas and common exponent of a colour. Mantissas are cut, not rounded; negative components
/// become 0, as in Radiance.
///
/// # Errors
/// If a component is not finite, or too large (2¹²⁷) for the exponent.
#[inline]
pub fn to_rgbe(color: [f32; 3]) -> Result<[u8; 4]> {
    let [r, g, b] = color;
    let largest = r.max(g).max(b);
    if !(r + g + b).is_finite() || largest >= LARGEST {
        check_range(color)?;
    }
    if largest <= BLACK_LIMIT {
        return Ok([0; 4]);
    }
    // `largest` is a normal number, 0.5·2^e ≤ largest < 2^e.
    let e = ((largest.to_bits() >> 23) & 0xff) as i32 - 126;
    let scale = f32::from_bits(((8 - e + 127) as u32) << 23);
    // The cast saturates at 0 for negative components; a power of two loses no bits.
    Ok([(r * scale) as u8, (g * scale) as u8, (b * scale) as u8, (e + EXPONENT_BIAS) as u8])
}

/// 2¹²⁷, the first value beyond the exponent byte.
const LARGEST: f32 = f32::from_bits(254 << 23);

#[cold]
fn check_range(color: [f32; 3]) -> Result<()> {
    if let Some(c) = color.iter().find(|c| !c.is_finite()) {
        return Err(
            Error::new(format!("a pixel has the value {c}")).help("a picture cannot hold it; look for the computation it comes from")
        );
    }
    if color.iter().any(|&c| c >= LARGEST) {
        return Err(Error::new(format!("a pixel of {color:?} is too large for RGBE")));
    }
    Ok(())
}

/// Colour of a pixel: (mantissa + ½) · 2^(exponent − 136), exponent 0 is black. The ½ undoes the
/// bias of cutting.
#[inline]
pub fn from_rgbe([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    let scale = HALF_STEP[usize::from(e)];
    [r, g, b].map(|m| (2 * u32::from(m) + 1) as f32 * scale)
}

/// 2^(e − 137), half a mantissa step, for each exponent byte e > 0; the smallest ten are denormal.
const HALF_STEP: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut e = 1;
    while e < 256 {
        table[e] = f32::from_bits(if e > 10 { (e as u32 - 10) << 23 } else { 1 << (e + 12) });
        e += 1;
    }
    table
};

/// Appends a scanline to `out`, byte for byte as Radiance writes it. `planes` is a buffer to reuse.
pub(super) fn encode(pixels: &[[u8; 4]], planes: &mut Vec<u8>, out: &mut Vec<u8>) {
    let width = pixels.len();
    if !(MIN_ENCODED..=MAX_ENCODED).contains(&width) {
        out.extend_from_slice(pixels.as_flattened());
        return;
    }
    out.extend_from_slice(&[2, 2, (width >> 8) as u8, width as u8]);
    planes.resize(4 * width, 0);
    let (red, rest) = planes.split_at_mut(width);
    let (green, rest) = rest.split_at_mut(width);
    let (blue, exponent) = rest.split_at_mut(width);
    for ((((pixel, r), g), b), e) in pixels.iter().zip(red).zip(green).zip(blue).zip(exponent) {
        [*r, *g, *b, *e] = *pixel;
    }
    for plane in planes.chunks_exact(width) {
        encode_plane(plane, out);
    }
}

fn encode_plane(plane: &[u8], out: &mut Vec<u8>) {
    let mut at = 0;
    while at < plane.len() {
        let run_start = next_run(plane, at);
        let before = &plane[at..run_start];
        if (2..MIN_RUN).contains(&before.len()) && before.iter().all(|&b| b == before[0]) {
            out.extend_from_slice(&[128 + before.len() as u8, before[0]]);
        } else {
            for literals in before.chunks(128) {
                out.push(literals.len() as u8);
                out.extend_from_slice(literals);
            }
        }
        at = run_start;
        if at < plane.len() {
            let limit = (at + 127).min(plane.len());
            let run = plane[at..limit].iter().take_while(|&&b| b == plane[at]).count();
            out.extend_from_slice(&[128 + run as u8, plane[at]]);
            at += run;
        }
    }
}

/// First place from `at` on where [`MIN_RUN`] bytes are equal, or the end.
fn next_run(plane: &[u8], mut at: usize) -> usize {
    // From the last pair backwards: a difference there rules out all windows that hold both bytes.
    while let Some(&[a, b, c, d]) = plane.get(at..at + MIN_RUN).and_then(|w| w.first_chunk()) {
        if c != d {
            at += 3;
        } else if b != c {
            at += 2;
        } else if a != b {
            at += 1;
        } else {
            return at;
        }
    }
    plane.len()
}

/// Reads a scanline in any of the three codings.
pub(super) fn decode(input: &mut Input<impl Read>, pixels: &mut [[u8; 4]]) -> Result<()> {
    let mut first = [0; 4];
    if !input.fill(&mut first)? {
        return Err(truncated(input));
    }
    // Valid pixels have a mantissa of at least 128, so that these bytes are no pixel.
    if first[0] == 2 && first[1] == 2 && first[2] < 128 {
        let width = usize::from(first[2]) << 8 | usize::from(first[3]);
        if width != pixels.len() {
            return Err(damaged(input, format!("it is encoded for {width} pixels instead of {}", pixels.len())));
        }
        decode_planes(input, pixels)
    } else {
        decode_old(input, first, pixels)
    }
}

fn decode_planes(input: &mut Input<impl Read>, pixels: &mut [[u8; 4]]) -> Result<()> {
    let width = pixels.len();
    let mut literals = [0; 128];
    for component in 0..4 {
        let mut at = 0;
        while at < width {
            let code = usize::from(input.byte()?.ok_or_else(|| truncated(input))?);
            let (count, is_run) = if code > 128 { (code - 128, true) } else { (code, false) };
            if count == 0 || at + count > width {
                return Err(damaged(input, format!("a code of {count} pixels at pixel {at} does not fit {width} pixels")));
            }
            let target = &mut pixels[at..at + count];
            if is_run {
                let value = input.byte()?.ok_or_else(|| truncated(input))?;
                target.iter_mut().for_each(|p| p[component] = value);
            } else {
                if !input.fill(&mut literals[..count])? {
                    return Err(truncated(input));
                }
                target.iter_mut().zip(literals).for_each(|(p, v)| p[component] = v);
            }
            at += count;
        }
    }
    Ok(())
}

fn decode_old(input: &mut Input<impl Read>, first: [u8; 4], pixels: &mut [[u8; 4]]) -> Result<()> {
    let width = pixels.len();
    let mut at = 0;
    let mut shift = 0;
    let mut pixel = first;
    loop {
        if pixel[..3] == [1, 1, 1] {
            let count = usize::from(pixel[3]).checked_shl(shift).unwrap_or(usize::MAX);
            if at == 0 {
                return Err(damaged(input, "it starts with a repetition".into()));
            }
            if shift > 24 || count > width - at {
                return Err(damaged(input, format!("a repetition at pixel {at} does not fit {width} pixels")));
            }
            let repeated = pixels[at - 1];
            pixels[at..at + count].fill(repeated);
            at += count;
            shift += 8;
        } else {
            pixels[at] = pixel;
            at += 1;
            shift = 0;
        }
        if at == width {
            return Ok(());
        }
        if !input.fill(&mut pixel)? {
            return Err(truncated(input));
        }
    }
}

fn truncated(input: &Input<impl Read>) -> Error {
    Error::new(format!("the file ends at byte {} in the middle of the scanline", input.offset()))
        .help("the file is truncated; make or copy it again")
}

fn damaged(input: &Input<impl Read>, what: String) -> Error {
    Error::new(format!("the scanline is damaged before byte {}: {what}", input.offset())).help("the file is damaged; make or copy it again")
}
