//! Suns in the pictures of a project: for every sun that the hours asked for need, a sparse picture
//! on disk, from which the pictures of the hours take what they show.

use super::fingerprint::Fingerprint;
use super::five_phase::{shaded_windows, shades};
use super::inputs::Inputs;
use super::presets::sun_picture_options;
use super::project::Project;
use super::shade::{add, black_model};
use super::store::Store;
use super::suns::SunSet;
use crate::camera::Raster;
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::kernels::sun_matrix::Sun;
use crate::kernels::sun_matrix::pixels::{self, Models, SparsePicture};
use crate::kernels::trace::TraceStatistics;
use crate::progress::Progress;
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// First bytes of a file of sparse pictures.
const MAGIC: &[u8; 8] = b"LUCSUNS1";
/// Bytes of an entry: number of the pixel, radiance of three channels.
const ENTRY: usize = 16;
/// Memory for the pictures of suns that are traced together, bytes; each pixel may take this much.
const GROUP_BYTES: usize = 1 << 28;
const PIXEL_BYTES: usize = 64;

/// The suns' pictures of one view.
pub struct SunPictures {
    path: PathBuf,
    file: Mutex<std::fs::File>,
    /// Number of the sun in the set → first byte and entries.
    places: BTreeMap<usize, (u64, usize)>,
    /// Per hour: sun and radiance.
    hours: Vec<Option<(usize, f64)>>,
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
        view: &str,
        raster: &Raster,
        hours: &[usize],
        mut inputs: Fingerprint,
        statistics: &mut TraceStatistics,
    ) -> Result<SunPictures> {
        let mut needed: Vec<usize> = hours.iter().filter_map(|&h| Some((*self.suns.hours.get(h)?)?.0)).collect();
        needed.sort_unstable();
        needed.dedup();
        let options = sun_picture_options(self.project);
        let suns: Vec<Sun> = needed.iter().map(|&n| self.suns.suns[n]).collect();
        inputs.add(raster).add(&options).add(&suns);
        let path = self.store.sun_pictures_path(view);
        let places = match kept(&path, &inputs.to_string(), &needed) {
            Some(places) => places,
            None => {
                let lit = {
                    let mut lit = self.inputs.scene.clone();
                    shades(self.inputs).for_each(|s| add(&mut lit, &s.scene));
                    lit
                };
                let black = black_model(&self.inputs.scene, shades(self.inputs));
                let shaded = shaded_windows(self.inputs);
                let first_shade = self.inputs.scene.materials.len() as u32;
                let models = Models { lit: &lit, black: &black, first_shade, shaded: &shaded };
                let group = (GROUP_BYTES / (raster.len() * PIXEL_BYTES)).clamp(1, 256);
                let mut places = BTreeMap::new();
                crate::files::write_atomically(&path, |out| {
                    let fault = |e: std::io::Error| Error::io(&path, &e);
                    out.write_all(MAGIC).map_err(fault)?;
                    out.write_all(inputs.to_string().as_bytes()).map_err(fault)?;
                    out.write_all(&(needed.len() as u64).to_le_bytes()).map_err(fault)?;
                    let mut position = (MAGIC.len() + inputs.to_string().len() + 8) as u64;
                    for (numbers, suns) in needed.chunks(group).zip(suns.chunks(group)) {
                        let pictures = pixels::compute(self.device, &models, raster, suns, &options, self.progress, statistics)?;
                        for (number, picture) in numbers.iter().zip(pictures) {
                            write_picture(out, *number, &picture).map_err(fault)?;
                            places.insert(*number, (position + 16, picture.len()));
                            position += 16 + (picture.len() * ENTRY) as u64;
                        }
                    }
                    Ok(())
                })?;
                places
            }
        };
        let file = std::fs::File::open(&path).map_err(|e| Error::io(&path, &e))?;
        Ok(SunPictures { path, file: Mutex::new(file), places, hours: self.suns.hours.clone() })
    }
}

fn write_picture(out: &mut dyn Write, number: usize, picture: &SparsePicture) -> std::io::Result<()> {
    out.write_all(&(number as u64).to_le_bytes())?;
    out.write_all(&(picture.len() as u64).to_le_bytes())?;
    let mut bytes = Vec::with_capacity(picture.len() * ENTRY);
    for (pixel, value) in picture {
        bytes.extend(pixel.to_le_bytes());
        value.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    out.write_all(&bytes)
}

/// Where the pictures lie in a file of the same inputs and suns.
fn kept(path: &Path, inputs: &str, needed: &[usize]) -> Option<BTreeMap<usize, (u64, usize)>> {
    let mut file = std::fs::File::open(path).ok()?;
    let end = file.metadata().ok()?.len();
    let mut head = vec![0u8; MAGIC.len() + inputs.len()];
    file.read_exact(&mut head).ok()?;
    if head != [MAGIC.as_slice(), inputs.as_bytes()].concat() {
        return None;
    }
    let mut word = || -> Option<u64> {
        let mut bytes = [0u8; 8];
        file.read_exact(&mut bytes).ok()?;
        Some(u64::from_le_bytes(bytes))
    };
    if word()? != needed.len() as u64 {
        return None;
    }
    let mut places = BTreeMap::new();
    let mut position = head.len() as u64 + 8;
    let mut file = std::fs::File::open(path).ok()?;
    for &number in needed {
        file.seek(SeekFrom::Start(position)).ok()?;
        let mut bytes = [0u8; 16];
        file.read_exact(&mut bytes).ok()?;
        let (found, entries) = bytes.split_at(8);
        let entries = u64::from_le_bytes(entries.try_into().ok()?);
        if u64::from_le_bytes(found.try_into().ok()?) != number as u64 {
            return None;
        }
        places.insert(number, (position + 16, usize::try_from(entries).ok()?));
        position = position.checked_add(16)?.checked_add(entries.checked_mul(ENTRY as u64)?)?;
    }
    (position == end).then_some(places)
}

impl SunPictures {
    /// What the sun adds to the picture of an hour (number of the year from 0): pixels in rising order
    /// and RGB radiance, W/m²sr. Empty without sun.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn sun_picture(&self, hour: usize) -> Result<SparsePicture> {
        let Some((sun, radiance)) = self.hours.get(hour).copied().flatten() else { return Ok(Vec::new()) };
        let Some(&(start, entries)) = self.places.get(&sun) else {
            return Err(Error::new(format!("the sun of hour {hour} was not traced")).file(&self.path));
        };
        let mut bytes = vec![0u8; entries * ENTRY];
        {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut bytes)).map_err(|e| Error::io(&self.path, &e))?;
        }
        let word = |entry: &[u8], i: usize| [entry[4 * i], entry[4 * i + 1], entry[4 * i + 2], entry[4 * i + 3]];
        let entry = |e: &[u8]| {
            let value = std::array::from_fn(|c| (f64::from(f32::from_le_bytes(word(e, c + 1))) * radiance) as f32);
            (u32::from_le_bytes(word(e, 0)), value)
        };
        Ok(bytes.chunks_exact(ENTRY).map(entry).collect())
    }
}
