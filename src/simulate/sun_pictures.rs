//! Suns in the pictures of a project: for every sun that the hours asked for need, a sparse picture
//! on disk, from which the pictures of the hours take what they show. The sun's disc is kept beside it,
//! for glare; of an eye without a picture it is all.

use super::fingerprint::Fingerprint;
use super::five_phase::{pane_windows, shaded_windows, shades};
use super::inputs::Inputs;
use super::picture_sets;
use super::presets::sun_picture_options;
use super::project::Project;
use super::rounds::Part;
use super::shade::{add, black_model};
use super::store::Store;
use super::sun_coding::{decode, encode};
use super::suns::SunSet;
use super::views::ViewSection;
use crate::camera::{Camera, Raster};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::kernels::sun_matrix::Sun;
use crate::kernels::sun_matrix::pixels::{self, Models, SparsePicture, SunPicture};
use crate::kernels::trace::TraceStatistics;
use crate::progress::Progress;
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// First bytes of a file of sparse pictures. Then, little endian: the inputs' fingerprint with its
/// length; the hours with their number, each its sun (from 1, 0 for none; u32) and radiance (f64);
/// the view's number of pixels; the pictures with their number, each its sun, length in bytes, and these
/// bytes ([`sun_coding`](super::sun_coding)).
const MAGIC: &[u8; 8] = b"LUCSUNS5";
/// Bytes of an hour.
const HOUR: usize = 12;
/// Memory for the pictures of suns that are traced together, bytes; each pixel may take this much.
const GROUP_BYTES: usize = 1 << 28;
const PIXEL_BYTES: usize = 64;
/// Most suns that are traced together.
const MOST_SUNS: usize = 256;

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

/// For whom suns are traced.
pub enum Shown {
    /// All that they do to a picture.
    Picture(Raster),
    /// Their discs, for an eye.
    Discs(Camera),
}

impl Shown {
    fn pixels(&self) -> usize {
        match self {
            Self::Picture(raster) => raster.len(),
            Self::Discs(_) => 0,
        }
    }
}

/// What they are computed from.
pub struct SunPictureJob<'a> {
    /// Device that traces.
    pub device: &'a Device,
    /// Method and quality.
    pub project: &'a Project,
    /// Scene, windows with their shades.
    pub inputs: &'a Inputs,
    /// Suns of the year.
    pub suns: &'a SunSet,
    /// Where results go.
    pub store: &'a Store,
    /// Progress.
    pub progress: &'a dyn Progress,
}

impl SunPictureJob<'_> {
    /// Pictures of all suns that `hours` need, or those of an earlier run if their inputs are the same.
    ///
    /// # Errors
    /// Failures of device and file system, or when stopped.
    pub fn compute(
        &self,
        view: &ViewSection,
        shown: &Shown,
        hours: &[usize],
        mut inputs: Fingerprint,
        statistics: &mut TraceStatistics,
    ) -> Result<SunPictures> {
        let mut needed: Vec<usize> = hours.iter().filter_map(|&h| Some((*self.suns.hours.get(h)?)?.0)).collect();
        needed.sort_unstable();
        needed.dedup();
        let options = sun_picture_options(self.project);
        let name = match shown {
            Shown::Picture(raster) => {
                inputs.add(raster);
                view.name.clone()
            }
            Shown::Discs(camera) => {
                inputs.add(camera);
                format!("{}_eye", view.name)
            }
        };
        inputs.add(&options).add(&self.suns.suns).add(&self.suns.hours);
        let path = self.store.sun_pictures_path(&name);
        if let (Shown::Picture(raster), Some(given)) = (shown, &view.given.sun) {
            let pictures = picture_sets::SunsGiven::open(given, self.suns, raster)?;
            self.write(&path, "imported", [raster.len(), needed.len()], &mut |out, fault| {
                needed.iter().try_for_each(|&number| write_picture(out, number, &pictures.read(number)?).map_err(fault))
            })?;
            return SunPictures::open(&path).map(|kept| kept.pictures);
        }
        let fits = |path: &Path| {
            SunPictures::open(path)
                .is_ok_and(|kept| kept.inputs == inputs.to_string() && needed.iter().all(|n| kept.pictures.places.contains_key(n)))
        };
        if self.store.has(&path, &fits) {
            return SunPictures::open(&path).map(|kept| kept.pictures);
        }
        let lit = {
            let mut lit = self.inputs.scene.clone();
            shades(self.inputs).for_each(|s| add(&mut lit, &s.scene));
            lit
        };
        let black = black_model(&self.inputs.scene, shades(self.inputs));
        let shaded = shaded_windows(self.inputs);
        let panes = pane_windows(self.inputs);
        let first_shade = self.inputs.scene.materials.len() as u32;
        let models = Models { lit: &lit, black: &black, first_shade, shaded: &shaded, panes: &panes };
        let group = (GROUP_BYTES / (shown.pixels() * PIXEL_BYTES).max(1)).clamp(1, MOST_SUNS);
        self.write(&path, &inputs.to_string(), [shown.pixels(), needed.len()], &mut |out, fault| {
            for (part, numbers) in needed.chunks(group).enumerate() {
                let suns: Vec<Sun> = numbers.iter().map(|&n| self.suns.suns[n]).collect();
                let stage = Part::of(self.progress, part, needed.len().div_ceil(group));
                let pictures = match shown {
                    Shown::Picture(raster) => pixels::compute(self.device, &models, raster, &suns, &options, &stage, statistics)?,
                    Shown::Discs(camera) => {
                        stage.update("the sun's disc at the eye", 0.0);
                        pixels::discs_at_eye(self.device, &models, camera, &suns, &options, statistics)?
                    }
                };
                numbers.iter().zip(pictures).try_for_each(|(number, picture)| write_picture(out, *number, &picture).map_err(fault))?;
            }
            Ok(())
        })?;
        SunPictures::open(&path).map(|kept| kept.pictures)
    }

    /// Writes a file of the pictures that `pictures` writes.
    #[allow(clippy::type_complexity, reason = "one function")]
    fn write(
        &self,
        path: &Path,
        inputs: &str,
        [pixels, suns]: [usize; 2],
        pictures: &mut dyn FnMut(&mut dyn Write, &dyn Fn(std::io::Error) -> Error) -> Result<()>,
    ) -> Result<()> {
        crate::files::write_atomically(path, |out| {
            let fault = |e: std::io::Error| Error::io(path, &e);
            write_head(out, inputs, &self.suns.hours, [pixels, suns]).map_err(fault)?;
            pictures(out, &fault)
        })
    }
}

fn write_head(out: &mut dyn Write, inputs: &str, hours: &[Option<(usize, f64)>], [pixels, pictures]: [usize; 2]) -> std::io::Result<()> {
    out.write_all(MAGIC)?;
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

fn write_picture(out: &mut dyn Write, number: usize, picture: &SunPicture) -> std::io::Result<()> {
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
pub struct Kept {
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
    pub fn open(path: &Path) -> Result<Kept> {
        let fault = |e: std::io::Error| Error::io(path, &e);
        let file = std::fs::File::open(path).map_err(fault)?;
        let end = file.metadata().map_err(fault)?.len();
        let mut words = Words { file: std::io::BufReader::new(file), position: 0, end };
        if words.bytes(MAGIC.len() as u64).ok().as_deref() != Some(MAGIC) {
            return Err(Error::new("this is no file of suns' pictures").file(path).help("delete it: it will be computed again"));
        }
        let (inputs, hours, pixels, places) = Self::read_places(&mut words).map_err(fault)?;
        let file = std::fs::File::open(path).map_err(fault)?;
        let inputs = String::from_utf8_lossy(&inputs).into_owned();
        Ok(Kept { inputs, pictures: Self { path: path.to_path_buf(), file: Mutex::new(file), places, hours, pixels } })
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
