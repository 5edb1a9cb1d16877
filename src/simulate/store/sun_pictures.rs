//! The file of sparse pictures of the suns of a view, `matrices/C_VIEW.suns`. The sun's disc is kept beside
//! its picture, for glare; of an eye without a picture (`C_VIEW_eye.suns`) it is all.

use super::sun_coding::{decode, encode};
use crate::error::{Error, Result};
use crate::files::seal;
use crate::kernels::sun_matrix::pixels::{SparsePicture, SunPicture};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// First bytes of a file of sparse pictures. Then the line of its checksum and, little endian: the inputs'
/// fingerprint with its length; the hours with their number, each its sun (from 1, 0 for none; u32) and radiance (f64);
/// the view's number of pixels; the pictures with their number, each its sun, length in bytes, and these
/// bytes ([`sun_coding`](super::sun_coding)).
const MAGIC: &[u8; 8] = b"LUCSUNS6";
/// Bytes of an hour.
const HOUR: usize = 12;
/// The suns' pictures of one view.
pub struct SunPictures {
    path: PathBuf,
    file: Mutex<std::fs::File>,
    /// By the number of the sun in the set.
    places: BTreeMap<usize, Place>,
    /// Per hour: sun and radiance.
    hours: Vec<Option<(usize, f64)>>,
    /// Of the view.
    pixels: usize,
}

/// Where a sun's picture is in the file.
#[derive(Debug, Clone, Copy)]
struct Place {
    start: u64,
    bytes: usize,
}

/// Writes what stands before the pictures.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_head(
    out: &mut dyn Write,
    inputs: &str,
    hours: &[Option<(usize, f64)>],
    [pixels, pictures]: [usize; 2],
) -> std::io::Result<()> {
    out.write_all(MAGIC)?;
    writeln!(out, "{}", seal::line())?;
    out.write_all(&(inputs.len() as u64).to_le_bytes())?;
    out.write_all(inputs.as_bytes())?;
    out.write_all(&(hours.len() as u64).to_le_bytes())?;
    let mut bytes = Vec::with_capacity(hours.len() * HOUR);
    for hour in hours {
        let (sun, radiance) = hour.map_or((0, 0.0), |(sun, radiance)| (sun as u32 + 1, radiance));
        bytes.extend(sun.to_le_bytes());
        bytes.extend(radiance.to_le_bytes());
    }
    out.write_all(&bytes)?;
    out.write_all(&(pixels as u64).to_le_bytes())?;
    out.write_all(&(pictures as u64).to_le_bytes())
}

/// Writes the picture of the sun of this number.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_picture(out: &mut dyn Write, number: usize, picture: &SunPicture) -> std::io::Result<()> {
    let bytes = encode(picture);
    out.write_all(&(number as u64).to_le_bytes())?;
    out.write_all(&(bytes.len() as u64).to_le_bytes())?;
    out.write_all(&bytes)
}

/// Little-endian numbers of a file whose length is known, so that no length in it is believed blindly.
struct Words {
    file: std::io::BufReader<std::fs::File>,
    position: u64,
    end: u64,
}

impl Words {
    fn bytes(&mut self, count: u64) -> std::io::Result<Vec<u8>> {
        let rest = self.end - self.position;
        let length = usize::try_from(count).ok().filter(|_| count <= rest).ok_or(std::io::ErrorKind::UnexpectedEof)?;
        let mut bytes = vec![0u8; length];
        self.file.read_exact(&mut bytes)?;
        self.position += count;
        Ok(bytes)
    }

    fn number(&mut self) -> std::io::Result<u64> {
        Ok(self.bytes(8)?.iter().rev().fold(0, |sum, &b| sum << 8 | u64::from(b)))
    }

    fn skip(&mut self, count: u64) -> std::io::Result<()> {
        if count > self.end - self.position {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        self.position += count;
        self.file.seek(SeekFrom::Start(self.position)).map(|_| ())
    }
}

/// A file of suns' pictures with what it was computed from.
pub struct StoredSunPictures {
    /// Fingerprint of the inputs.
    pub inputs: String,
    /// The pictures.
    pub pictures: SunPictures,
}

impl SunPictures {
    /// Opens the file of an earlier run; of the pictures only their places are read.
    ///
    /// # Errors
    /// A file that cannot be read, is none of suns' pictures, or is cut off.
    pub fn open(path: &Path) -> Result<StoredSunPictures> {
        let fault = |e: std::io::Error| Error::io(path, &e);
        let file = std::fs::File::open(path).map_err(fault)?;
        let end = file.metadata().map_err(fault)?.len();
        let mut words = Words { file: std::io::BufReader::new(file), position: 0, end };
        if words.bytes(MAGIC.len() as u64).ok().as_deref() != Some(MAGIC) {
            return Err(Error::new("this is no file of suns' pictures").file(path).help("delete it: it will be computed again"));
        }
        words.skip(seal::line().len() as u64 + 1).map_err(fault)?;
        let (inputs, hours, pixels, places) = Self::read_places(&mut words).map_err(fault)?;
        let file = std::fs::File::open(path).map_err(fault)?;
        let inputs = String::from_utf8_lossy(&inputs).into_owned();
        Ok(StoredSunPictures { inputs, pictures: Self { path: path.to_path_buf(), file: Mutex::new(file), places, hours, pixels } })
    }

    #[allow(clippy::type_complexity, reason = "the parts of a file")]
    fn read_places(words: &mut Words) -> std::io::Result<(Vec<u8>, Vec<Option<(usize, f64)>>, usize, BTreeMap<usize, Place>)> {
        let length = words.number()?;
        let inputs = words.bytes(length)?;
        let hours = words.number()?.saturating_mul(HOUR as u64);
        let hour = |bytes: &[u8; HOUR]| {
            let [a, b, c, d, radiance @ ..] = *bytes;
            let sun = u32::from_le_bytes([a, b, c, d]).checked_sub(1)?;
            Some((sun as usize, f64::from_le_bytes(radiance)))
        };
        let hours = words.bytes(hours)?.as_chunks::<HOUR>().0.iter().map(hour).collect();
        let pixels = words.number()? as usize;
        let mut places = BTreeMap::new();
        for _ in 0..words.number()? {
            let [number, bytes] = [words.number()?, words.number()?];
            let start = words.position;
            words.skip(bytes)?;
            places.insert(number as usize, Place { start, bytes: bytes as usize });
        }
        Ok((inputs, hours, pixels, places))
    }

    /// Whether the sun of this number has a picture.
    pub fn has(&self, sun: usize) -> bool {
        self.places.contains_key(&sun)
    }

    /// Numbers of the suns that have a picture.
    pub fn suns(&self) -> impl Iterator<Item = usize> {
        self.places.keys().copied()
    }

    /// What the sun adds to the picture of an hour (number of the year from 0), its disc included: pixels in
    /// rising order and RGB radiance, W/m²sr. Empty without sun.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn sun_picture(&self, hour: usize) -> Result<SparsePicture> {
        Ok(self.sun_picture_with_discs(hour)?.with_disc())
    }

    /// The same with the discs apart, as sources of their own, and with standard errors, cd/m² and lx.
    ///
    /// # Errors
    /// As [`sun_picture`](Self::sun_picture).
    pub fn sun_picture_with_discs(&self, hour: usize) -> Result<SunPicture> {
        let Some((sun, radiance)) = self.hours.get(hour).copied().flatten() else { return Ok(SunPicture::default()) };
        if !self.places.contains_key(&sun) {
            return Err(Error::new(format!("the sun of hour {hour} was not traced")).file(&self.path));
        }
        self.picture(sun, radiance)
    }

    /// The picture of a sun of this radiance, W/m²sr; empty if there is none.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn of_sun(&self, sun: usize, radiance: f64) -> Result<SparsePicture> {
        Ok(self.picture(sun, radiance)?.with_disc())
    }

    fn picture(&self, sun: usize, radiance: f64) -> Result<SunPicture> {
        let Some(&Place { start, bytes }) = self.places.get(&sun) else { return Ok(SunPicture::default()) };
        let mut bytes = vec![0u8; bytes];
        {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut bytes)).map_err(|e| Error::io(&self.path, &e))?;
        }
        let damaged = || Error::new("a sun's picture is damaged").file(&self.path).help("delete the file: it will be computed again");
        let mut picture = decode(&bytes, self.pixels).ok_or_else(damaged)?;
        let values = picture.pixels.iter_mut().chain(&mut picture.disc_pixels).flat_map(|(_, value)| value);
        let values = values.chain(picture.discs.iter_mut().flat_map(|disc| &mut disc.radiance));
        let errors = picture.errors.iter_mut().chain(&mut picture.shared_errors);
        values.chain(errors).for_each(|v| *v = (f64::from(*v) * radiance) as f32);
        picture.shared = picture.shared.times(radiance);
        Ok(picture)
    }
}
