//! OpenEXR pictures: half or float, RGB or luminance, one picture or one part per hour.
//!
//! RGB is radiance in W/m²sr in Radiance's primaries; the channel Y is luminance in cd/m². The
//! standard attribute `whiteLuminance` says so (179 or 1 cd/m² for the value 1), and reading goes
//! by it. The view is kept as a text attribute `VIEW` of Radiance options, other header lines as
//! `comments`. Data are compressed without loss (ZIP, 16 lines).

use super::Picture;
use super::hdr::{MAX_PIXELS, PRIMARIES, WHITE};
use crate::error::{Error, Result, Warnings};
use crate::files;
use crate::units::LUMINOUS_EFFICACY;
use ::exr::block::reader::ChunksReader as _;
use ::exr::block::writer::ChunksWriter as _;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, ChannelDescription, Chromaticities, Compression, LineOrder, SampleType, Text};
use ::exr::meta::{BlockDescription, header::Header};
use half::f16;
use rayon::prelude::*;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Precision of the stored samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// 16 bits: 0.05 % from 6e-5 to 65504; larger values are stored as 65504, with a warning.
    Half,
    /// 32 bits: exact.
    Float,
}

/// What is stored per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channels {
    /// R, G, B: radiance, W/m²sr.
    Rgb,
    /// Y: luminance, cd/m².
    Luminance,
}

/// How to store pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Precision.
    pub samples: Samples,
    /// Content.
    pub channels: Channels,
}

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

/// What a file says about one of its parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// View as Radiance options.
    pub view: Option<String>,
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
    if *width == 0 || *height == 0 || width.checked_mul(*height).is_none_or(|n| n > MAX_PIXELS) {
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
        Channels::Luminance => [super::luminance(pixel), 0.0, 0.0],
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

fn exr_error(path: &Path, error: ::exr::error::Error) -> Error {
    use ::exr::error::Error as Exr;
    match error {
        Exr::Io(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Error::new("the file is truncated").file(path).help("make or copy it again")
        }
        Exr::Io(e) => Error::io(path, &e),
        Exr::NotSupported(what) => Error::new(format!("this kind of EXR is not supported: {what}")).file(path),
        Exr::Invalid(what) => {
            Error::new(format!("not a valid EXR file: {what}")).file(path).help("the file is damaged or no EXR; make or copy it again")
        }
        Exr::Aborted => Error::new("writing was aborted").file(path),
    }
}

type Reader = ::exr::block::reader::Reader<BufReader<File>>;

fn open(path: &Path) -> Result<Reader> {
    let file = File::open(path).map_err(|e| Error::io(path, &e))?;
    ::exr::block::read(BufReader::new(file), false).map_err(|e| exr_error(path, e))
}

/// Lists the parts of a file.
///
/// # Errors
/// If the file cannot be read or is no EXR.
pub fn parts(path: &Path) -> Result<Vec<Part>> {
    Ok(open(path)?.headers().iter().map(describe).collect())
}

fn describe(header: &Header) -> Part {
    let own = &header.own_attributes;
    let view = own.other.get(&b"VIEW"[..]).and_then(|v| match v {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    });
    Part { name: own.layer_name.as_ref().map(Text::to_string), width: header.layer_size.0, height: header.layer_size.1, view }
}

/// Reads a file of one part; luminance becomes grey radiance.
///
/// # Errors
/// As [`read_part`], and if there are several parts.
pub fn read(path: &Path) -> Result<Picture> {
    let count = open(path)?.headers().len();
    if count != 1 {
        return Err(Error::new(format!("the file has {count} parts")).file(path).help("use a file with one picture"));
    }
    read_part(path, 0)
}

/// Reads one part of a file; luminance becomes grey radiance. Of other channels than R, G, B and Y
/// nothing is read.
///
/// # Errors
/// If the file cannot be read, is damaged or absurdly large, the part does not exist, or it has
/// neither R, G, B nor Y.
pub fn read_part(path: &Path, index: usize) -> Result<Picture> {
    let reader = open(path)?;
    let Some(header) = reader.headers().get(index).cloned() else {
        return Err(Error::new(format!("there is no part {index}; the file has {}", reader.headers().len())).file(path));
    };
    let Part { width, height, view, .. } = describe(&header);
    let bad = |message: String| Err(Error::new(message).file(path));
    if width == 0 || height == 0 || width.checked_mul(height).is_none_or(|n| n > MAX_PIXELS) {
        return bad(format!("a picture of {width} × {height} pixels is not possible"));
    }
    if header.deep {
        return bad("deep pictures are not supported".into());
    }
    let find = |name: &str| header.channels.list.iter().position(|c| c.name.eq(name));
    // Component of the picture for each channel of the file.
    let mut targets = vec![None; header.channels.list.len()];
    let is_grey = match (find("R"), find("G"), find("B"), find("Y")) {
        (Some(r), Some(g), Some(b), _) => {
            (targets[r], targets[g], targets[b]) = (Some(0), Some(1), Some(2));
            false
        }
        (_, _, _, Some(y)) => {
            targets[y] = Some(0);
            true
        }
        _ => return bad("it has neither the channels R, G, B nor Y".into()),
    };
    if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return bad("channels of reduced resolution are not supported".into());
    }
    let factor = header.own_attributes.white_luminance.map_or(1.0, |w| f64::from(w) / LUMINOUS_EFFICACY);
    if !(factor.is_finite() && factor > 0.0) {
        return bad("the attribute whiteLuminance is not positive".into());
    }
    let chunks = reader
        .filter_chunks(false, |_, tile, block| block.layer == index && tile.is_largest_resolution_level())
        .map_err(|e| exr_error(path, e))?;
    let meta = chunks.meta_data().clone();
    let mut pixels = Vec::new();
    let mut filled = 0;
    for chunk in chunks {
        let block = chunk.and_then(|c| UncompressedBlock::decompress_chunk(c, &meta, false)).map_err(|e| exr_error(path, e))?;
        if pixels.is_empty() {
            pixels = vec![[0f32; 3]; width * height];
        }
        let Vec2(right, bottom) = block.index.pixel_position + block.index.pixel_size;
        if right > width || bottom > height {
            return bad("a block lies outside the picture".into());
        }
        filled += block.index.pixel_size.area();
        for line in block.lines(&header.channels) {
            let Some(component) = targets[line.location.channel] else { continue };
            let start = line.location.position.y() * width + line.location.position.x();
            let row = &mut pixels[start..][..line.location.sample_count];
            let mut set = |x: usize, value: f32| row[x][component] = (f64::from(value) * factor) as f32;
            let mut read = || -> ::exr::error::UnitResult {
                match header.channels.list[line.location.channel].sample_type {
                    SampleType::F16 => line.read_samples::<f16>().enumerate().try_for_each(|(x, v)| v.map(|v| set(x, v.to_f32()))),
                    SampleType::F32 => line.read_samples::<f32>().enumerate().try_for_each(|(x, v)| v.map(|v| set(x, v))),
                    SampleType::U32 => line.read_samples::<u32>().enumerate().try_for_each(|(x, v)| v.map(|v| set(x, v as f32))),
                }
            };
            read().map_err(|e| exr_error(path, e))?;
        }
    }
    if filled != width * height {
        return bad(format!("it holds {filled} of {} pixels", width * height));
    }
    if is_grey {
        pixels.iter_mut().for_each(|p| *p = [p[0]; 3]);
    }
    let mut picture = Picture::new(width, height, pixels)?;
    picture.view = view;
    let comments = header.own_attributes.comments.map(|c| c.to_string()).unwrap_or_default();
    picture.header = comments.lines().filter(|l| !l.is_empty()).map(str::to_owned).collect();
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: usize, height: usize, seed: f32) -> Picture {
        let pixels = (0..width * height).map(|i| [(i as f32 * 0.37 + seed).sin().abs() * 50.0, i as f32 * 0.01 + seed, 1e-3]).collect();
        let mut picture = Picture::new(width, height, pixels).unwrap();
        picture.view = Some("-vta -vp 1 2 3 -vh 180 -vv 180".into());
        picture.header = vec!["rpict room.oct".into(), "SOFTWARE= test".into()];
        picture
    }

    const FLOAT_RGB: Options = Options { samples: Samples::Float, channels: Channels::Rgb };

    #[test]
    fn float_is_exact_and_half_within_its_precision() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let original = picture(37, 53, 1.0);
        let mut warnings = Warnings::new();
        write(&path, &original, FLOAT_RGB, &mut warnings).unwrap();
        // whiteLuminance is f32, 179 exactly.
        assert_eq!(read(&path).unwrap(), original);
        assert_eq!(super::super::read(&path).unwrap(), original);

        write(&path, &original, Options { samples: Samples::Half, channels: Channels::Rgb }, &mut warnings).unwrap();
        for (a, b) in read(&path).unwrap().pixels.iter().flatten().zip(original.pixels.iter().flatten()) {
            assert!((a - b).abs() <= b / 2048.0, "{a} {b}");
        }
        for samples in [Samples::Half, Samples::Float] {
            write(&path, &original, Options { samples, channels: Channels::Luminance }, &mut warnings).unwrap();
            let grey = read(&path).unwrap();
            let precision = if samples == Samples::Half { 1.0 / 2048.0 } else { 1e-6 };
            for (a, b) in grey.pixels.iter().zip(&original.pixels) {
                let (a, b) = (super::super::luminance(*a), super::super::luminance(*b));
                assert!((a - b).abs() <= b * precision, "{a} {b}");
            }
        }
        assert!(warnings.is_empty());
    }

    /// The crate's own reader, which goes by names, sees the same colours, and the metadata say what
    /// the numbers are.
    #[test]
    fn other_readers_see_the_same() {
        use ::exr::prelude::{AttributeValue, Text};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let original = picture(7, 5, 1.0);
        write(&path, &original, FLOAT_RGB, &mut Warnings::new()).unwrap();
        let read = ::exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |size, _| vec![[0f32; 3]; size.area()],
            |pixels: &mut Vec<[f32; 3]>, at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * 7 + at.x()] = [r, g, b],
        )
        .unwrap();
        assert_eq!(read.layer_data.channel_data.pixels, original.pixels);
        assert_eq!(read.layer_data.attributes.white_luminance, Some(179.0));
        assert_eq!(read.layer_data.attributes.other[&b"VIEW"[..]], AttributeValue::Text(Text::from(original.view.as_deref().unwrap())));
        assert_eq!(read.attributes.chromaticities.unwrap().green.x(), 0.29);

        write(&path, &original, Options { samples: Samples::Float, channels: Channels::Luminance }, &mut Warnings::new()).unwrap();
        let read = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
        let channel = &read.layer_data.channel_data.list[0];
        assert!(channel.name.eq("Y"));
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(values, original.luminance(), "cd/m²");
    }

    #[test]
    fn too_large_for_half_is_said_and_nan_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut picture = picture(5, 4, 0.0);
        picture.pixels[7] = [1e5, 7e6, 1.0];
        let mut warnings = Warnings::new();
        write(&path, &picture, Options { samples: Samples::Half, channels: Channels::Rgb }, &mut warnings).unwrap();
        assert!(warnings.iter().next().unwrap().to_string().contains("2 samples"));
        assert_eq!(read(&path).unwrap().pixels[7], [65504.0, 65504.0, 1.0]);
        picture.pixels[7][2] = f32::NAN;
        let before = std::fs::read(&path).unwrap();
        let error = write(&path, &picture, FLOAT_RGB, &mut warnings).unwrap_err().to_string();
        assert!(error.contains("pixel 2, 1"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), before, "the old file is untouched");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn parts_are_streamed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("year.exr");
        let hours = [1164, 1929, 7067];
        let parts = Parts {
            width: 40,
            height: 33,
            view: Some("-vtv -vh 60".into()),
            header: Vec::new(),
            names: hours.iter().map(|h| format!("hour_{h}")).collect(),
        };
        let mut warnings = Warnings::new();
        write_parts(&path, &parts, FLOAT_RGB, &mut warnings, |put| hours.iter().try_for_each(|&h| put(&picture(40, 33, h as f32).pixels)))
            .unwrap();
        let listed = super::parts(&path).unwrap();
        assert_eq!(listed[1], Part { name: Some("hour_1929".into()), width: 40, height: 33, view: parts.view.clone() });
        for (i, &h) in hours.iter().enumerate() {
            let read = read_part(&path, i).unwrap();
            assert_eq!(read.pixels, picture(40, 33, h as f32).pixels);
            assert_eq!(read.view, parts.view);
        }
        assert!(read(&path).unwrap_err().to_string().contains("3 parts"));
        assert!(read_part(&path, 3).is_err());

        let fails = |parts: &Parts, count: usize, expected: &str| {
            let path = folder.path().join("bad.exr");
            let result = write_parts(&path, parts, FLOAT_RGB, &mut Warnings::new(), |put| {
                (0..count).try_for_each(|i| put(&picture(40, 33, i as f32).pixels))
            });
            let error = result.unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
            assert!(!path.exists());
        };
        fails(&parts, 2, "only 2 of 3");
        fails(&parts, 4, "more than 3");
        fails(&Parts { width: 41, ..parts.clone() }, 3, "1320 pixels are not 41 × 33");
        fails(&Parts { names: vec!["a".into(), "a".into()], ..parts.clone() }, 2, "named 'a'");
        fails(&Parts { names: Vec::new(), ..parts.clone() }, 0, "at least one part");
    }

    #[test]
    fn damaged_files_are_errors_never_panics() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write(&path, &picture(20, 20, 1.0), FLOAT_RGB, &mut Warnings::new()).unwrap();
        let good = std::fs::read(&path).unwrap();
        for length in (0..good.len()).step_by(7) {
            std::fs::write(&path, &good[..length]).unwrap();
            assert!(read(&path).is_err(), "{length} of {} bytes", good.len());
        }
        let mut state = 12345u64;
        let mut random = |limit: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize % limit
        };
        for _ in 0..300 {
            let mut bytes = good.clone();
            for _ in 0..1 + random(3) {
                let at = random(bytes.len().min(900));
                bytes[at] = random(256) as u8;
            }
            std::fs::write(&path, &bytes).unwrap();
            let _ = read(&path);
            let _ = parts(&path);
        }
        std::fs::write(&path, b"#?RADIANCE\n").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("a.exr"));
    }
}
