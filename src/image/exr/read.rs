//! Reading EXR files.

use super::exr_error;
use crate::error::{Error, Result};
use crate::image::Picture;
use crate::limits::{EXR_HEADROOM, EXR_PIXELS_PER_BYTE, PIXELS};
use crate::units::LUMINOUS_EFFICACY;
use ::exr::block::UncompressedBlock;
use ::exr::block::reader::ChunksReader as _;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, SampleType, Text};
use ::exr::meta::header::Header;
use half::f16;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

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
    if width == 0 || height == 0 || width.checked_mul(height).is_none_or(|n| n > PIXELS) {
        return bad(format!("a picture of {width} × {height} pixels is not possible"));
    }
    let length = std::fs::metadata(path).map_err(|e| Error::io(path, &e))?.len();
    if (width * height) as u64 > (length + EXR_HEADROOM) * EXR_PIXELS_PER_BYTE {
        return bad(format!("a picture of {width} × {height} pixels cannot be in a file of {length} bytes"));
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
