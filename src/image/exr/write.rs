//! Writing EXR files.

use super::{Channels, Options, Samples, exr_error};
use crate::error::{Error, Result, Warnings};
use crate::files;
use crate::image::hdr::{PRIMARIES, WHITE};
use crate::image::{Picture, luminance};
use crate::limits::PIXELS;
use crate::units::LUMINOUS_EFFICACY;
use ::exr::block::writer::ChunksWriter as _;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, ChannelDescription, Chromaticities, Compression, LineOrder, SampleType, Text};
use ::exr::meta::{BlockDescription, header::Header};
use half::f16;
use rayon::prelude::*;
use std::path::Path;

/// What all parts of a file share, and their names.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// View as Radiance options.
    pub view: Option<String>,
    /// Other header lines.
    pub header: Vec<String>,
    /// Name of each part, all different; for instance `hour_1929`.
    pub names: Vec<String>,
}

/// Writes one picture.
///
/// # Errors
/// If a pixel is not finite, or writing fails.
pub fn write(path: &Path, picture: &Picture, options: Options, warnings: &mut Warnings) -> Result<()> {
    let parts = Parts {
        width: picture.width,
        height: picture.height,
        view: picture.view.clone(),
        header: picture.header.clone(),
        names: vec!["picture".into()],
    };
    write_parts(path, &parts, options, warnings, |put| put(&picture.pixels))
}

/// Writes a file of several parts one after the other: `produce` calls the given function with the
/// pixels of each part in turn, so that only one of them need be in memory.
///
/// # Errors
/// If names are missing or occur twice, parts are missing, too many or of the wrong size, a pixel
/// is not finite, or writing fails. Nothing is left behind then.
pub fn write_parts(
    path: &Path,
    parts: &Parts,
    options: Options,
    warnings: &mut Warnings,
    produce: impl FnOnce(&mut dyn FnMut(&[[f32; 3]]) -> Result<()>) -> Result<()>,
) -> Result<()> {
    let headers: Vec<Header> = headers(parts, options).map_err(|e| e.file(path))?;
    let mut clipped = 0;
    files::write_seekable_atomically(path, |out| {
        // The crate calls back and knows only its own errors, so ours waits outside.
        let mut ours = Ok(());
        let result = ::exr::block::write(out, headers.iter().cloned().collect(), true, |meta, chunks| {
            let mut next = 0;
            let mut put = |pixels: &[[f32; 3]]| -> Result<()> {
                let Some(name) = parts.names.get(next) else {
                    return Err(Error::new(format!("there are more than {} pictures", parts.names.len())));
                };
                if pixels.len() != parts.width * parts.height {
                    return Err(Error::new(format!("{} pixels are not {} × {}", pixels.len(), parts.width, parts.height)).field(name));
                }
                clipped += check(pixels, parts.width, options).map_err(|e| e.field(name))?;
                let header = &meta.headers[next];
                let blocks: Vec<_> = header.enumerate_ordered_blocks().collect();
                // A few blocks at a time, so that the compressed ones need little memory.
                for group in blocks.chunks(64) {
                    let compressed: Vec<_> = group
                        .par_iter()
                        .map(|(index, tile)| {
                            let place = header.get_absolute_block_pixel_coordinates(tile.location)?;
                            let pixel_position = Vec2(0, place.position.y() as usize);
                            let block = BlockIndex { layer: next, level: Vec2(0, 0), pixel_position, pixel_size: place.size };
                            let block = encode_block(header, block, pixels, parts.width, options);
                            block.compress_to_chunk(&meta.headers).map(|chunk| (*index, chunk))
                        })
                        .collect();
                    for result in compressed {
                        let (index, chunk) = result.map_err(|e| exr_error(path, e))?;
                        chunks.write_chunk(index, chunk).map_err(|e| exr_error(path, e))?;
                    }
                }
                next += 1;
                Ok(())
            };
            ours = produce(&mut put);
            if ours.is_ok() && next < parts.names.len() {
                ours = Err(Error::new(format!("only {next} of {} pictures were written", parts.names.len())));
            }
            if ours.is_err() { Err(::exr::error::Error::Aborted) } else { Ok(()) }
        });
        ours.map_err(|e| e.file(path))?;
        result.map_err(|e| exr_error(path, e))
    })?;
    if clipped > 0 {
        warnings.push(
            Error::new(format!("{clipped} samples above {} do not fit into 16 bits and were stored as that", f16::MAX))
                .file(path)
                .help("write 32-bit samples (float) to keep them"),
        );
    }
    Ok(())
}

fn headers(parts: &Parts, options: Options) -> Result<Vec<Header>> {
    let Parts { width, height, view, header: lines, names } = parts;
    if *width == 0 || *height == 0 || width.checked_mul(*height).is_none_or(|n| n > PIXELS) {
        return Err(Error::new(format!("cannot write a picture of {width} × {height} pixels")));
    }
    if names.is_empty() || names.iter().any(String::is_empty) {
        return Err(Error::new("a file needs at least one part, and each a name"));
    }
    let mut sorted: Vec<_> = names.iter().collect();
    sorted.sort();
    if let Some(pair) = sorted.windows(2).find(|p| p[0] == p[1]) {
        return Err(Error::new(format!("two parts are named '{}'", pair[0])));
    }
    let sample_type = match options.samples {
        Samples::Half => SampleType::F16,
        Samples::Float => SampleType::F32,
    };
    // In alphabetical order, as the format demands.
    let channel_names: &[&str] = match options.channels {
        Channels::Rgb => &["B", "G", "R"],
        Channels::Luminance => &["Y"],
    };
    let point = |[x, y]: [f64; 2]| Vec2(x as f32, y as f32);
    let mut headers = Vec::new();
    for name in names {
        let channels = channel_names.iter().map(|&c| ChannelDescription::new(c, sample_type, false)).collect();
        let mut header = Header::new(text(name)?, (*width, *height), channels).with_encoding(
            Compression::ZIP16,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        );
        header.shared_attributes.chromaticities =
            Some(Chromaticities { red: point(PRIMARIES[0]), green: point(PRIMARIES[1]), blue: point(PRIMARIES[2]), white: point(WHITE) });
        let own = &mut header.own_attributes;
        own.white_luminance = Some(white_luminance(options.channels) as f32);
        own.software_name = Some(text(concat!("lucarne ", env!("CARGO_PKG_VERSION")))?);
        if !lines.is_empty() {
            own.comments = Some(text(&lines.join("\n"))?);
        }
        if let Some(view) = view {
            own.other.insert(text("VIEW")?, AttributeValue::Text(text(view)?));
        }
        headers.push(header);
    }
    Ok(headers)
}

fn white_luminance(channels: Channels) -> f64 {
    match channels {
        Channels::Rgb => LUMINOUS_EFFICACY,
        Channels::Luminance => 1.0,
    }
}

fn text(value: &str) -> Result<Text> {
    Text::new_or_none(value).ok_or_else(|| Error::new(format!("'{value}' has characters that EXR cannot hold")))
}

/// Values of a pixel in the order of the channels.
fn samples(pixel: [f32; 3], channels: Channels) -> [f32; 3] {
    match channels {
        Channels::Rgb => [pixel[2], pixel[1], pixel[0]],
        Channels::Luminance => [luminance(pixel), 0.0, 0.0],
    }
}

/// Number of samples that do not fit; an error for those that no picture should have.
fn check(pixels: &[[f32; 3]], width: usize, options: Options) -> Result<usize> {
    let mut clipped = 0;
    for (i, &pixel) in pixels.iter().enumerate() {
        let values = samples(pixel, options.channels);
        if !(values[0] + values[1] + values[2]).is_finite() && values.iter().any(|v| !v.is_finite()) {
            return Err(Error::new(format!("pixel {}, {} has the value {pixel:?}", i % width, i / width)));
        }
        if options.samples == Samples::Half {
            clipped += values.iter().filter(|v| v.abs() > f16::MAX.to_f32()).count();
        }
    }
    Ok(clipped)
}

fn encode_block(header: &Header, index: BlockIndex, pixels: &[[f32; 3]], width: usize, options: Options) -> UncompressedBlock {
    UncompressedBlock::from_lines(&header.channels, index, |line| {
        let row = &pixels[line.location.position.y() * width..][..width];
        let channel = line.location.channel;
        let value = |x: usize| samples(row[x], options.channels)[channel];
        let limit = f16::MAX.to_f32();
        let result = match options.samples {
            Samples::Half => line.write_samples(|x| f16::from_f32(value(x).clamp(-limit, limit))),
            Samples::Float => line.write_samples(value),
        };
        result.expect("memory takes all bytes");
    })
}
