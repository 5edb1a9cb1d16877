//! Suns in the pictures of a project: for every sun that the hours asked for need, a sparse picture
//! on disk, from which the pictures of the hours take what they show.

use super::picture_sets;
use super::sun::add_scattering_data;
use crate::camera::{Camera, Raster};
use crate::error::{Error, Result};
use crate::kernels::sun_matrix::Sun;
use crate::kernels::sun_matrix::pixels::{self, Models};
use crate::kernels::trace::TraceStatistics;
use crate::progress::Progress;
use crate::simulate::context::Context;
use crate::simulate::inputs::shade::{add, black_model};
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::plan::presets::sun_picture_options;
use crate::simulate::project::views::ViewSection;
use crate::simulate::sampling::rounds::Part;
use crate::simulate::store::sun_pictures::{SunPictures, write_head, write_picture};
use std::io::Write;
use std::path::Path;

/// Memory for the pictures of suns that are traced together, bytes; each pixel may take this much.
const GROUP_BYTES: usize = 1 << 28;
const PIXEL_BYTES: usize = 64;

/// Most suns that are traced together.
const MOST_SUNS: usize = 256;

/// For whom suns are traced.
pub(crate) enum Shown {
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

/// Pictures of all suns that `hours` need, or those of an earlier run if their inputs are the same.
///
/// # Errors
/// Failures of device and file system, or when stopped.
pub(crate) fn sun_pictures(
    context: &Context<'_>,
    suns: &SunSet,
    view: &ViewSection,
    shown: &Shown,
    hours: &[usize],
    statistics: &mut TraceStatistics,
) -> Result<SunPictures> {
    let mut inputs = context.scene_fingerprint("C of pictures");
    for window in &context.inputs.windows {
        inputs.add(&(&window.window.triangles, &window.window.frame)).add(&window.shade);
    }
    add_scattering_data(context, &mut inputs)?;
    let mut needed: Vec<usize> = hours.iter().filter_map(|&h| Some((*suns.hours.get(h)?)?.0)).collect();
    needed.sort_unstable();
    needed.dedup();
    let options = sun_picture_options(context.project);
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
    inputs.add(&options).add(&suns.suns).add(&suns.hours);
    let path = context.store.sun_pictures_path(&name);
    if let (Shown::Picture(raster), Some(given)) = (shown, &view.given.sun) {
        let pictures = picture_sets::SunsGiven::open(given, suns, raster)?;
        write(&path, suns, "imported", [raster.len(), needed.len()], &mut |out, fault| {
            needed.iter().try_for_each(|&number| write_picture(out, number, &pictures.read(number)?).map_err(fault))
        })?;
        return SunPictures::open(&path).map(|kept| kept.pictures);
    }
    let fits = |path: &Path| {
        SunPictures::open(path).is_ok_and(|kept| kept.inputs == inputs.to_string() && needed.iter().all(|n| kept.pictures.has(*n)))
    };
    if context.store.has(&path, &fits) {
        return SunPictures::open(&path).map(|kept| kept.pictures);
    }
    let lit = {
        let mut lit = context.inputs.scene.clone();
        context.inputs.shades().for_each(|s| add(&mut lit, &s.scene));
        lit
    };
    let black = black_model(&context.inputs.scene, context.inputs.shades());
    let shaded = context.inputs.shaded_windows();
    let panes = context.inputs.pane_windows();
    let first_shade = context.inputs.scene.materials.len() as u32;
    let models = Models { lit: &lit, black: &black, first_shade, shaded: &shaded, panes: &panes };
    let group = (GROUP_BYTES / (shown.pixels() * PIXEL_BYTES).max(1)).clamp(1, MOST_SUNS);
    let kept = context.store.stage(&format!("C_{name}"), *inputs.clone().add(&needed), context.progress);
    write(&path, suns, &inputs.to_string(), [shown.pixels(), needed.len()], &mut |out, fault| {
        for (part, numbers) in needed.chunks(group).enumerate() {
            let traced: Vec<Sun> = numbers.iter().map(|&n| suns.suns[n]).collect();
            let stage = Part::of(context.progress, part, needed.len().div_ceil(group));
            let bytes = kept.unit(&format!("suns {numbers:?}"), &mut || {
                let pictures = match shown {
                    Shown::Picture(raster) => pixels::compute(context.device, &models, raster, &traced, &options, &stage, statistics)?,
                    Shown::Discs(camera) => {
                        stage.update("the sun's disc at the eye", 0.0);
                        pixels::discs_at_eye(context.device, &models, camera, &traced, &options, statistics)?
                    }
                };
                let mut bytes = Vec::new();
                let each = |(number, picture): (&usize, _)| write_picture(&mut bytes, *number, &picture).map_err(fault);
                numbers.iter().zip(pictures).try_for_each(each)?;
                Ok(bytes)
            })?;
            out.write_all(&bytes).map_err(fault)?;
        }
        Ok(())
    })?;
    kept.finish();
    SunPictures::open(&path).map(|kept| kept.pictures)
}

/// Writes a file of the pictures that `pictures` writes.
#[allow(clippy::type_complexity, reason = "one function")]
fn write(
    path: &Path,
    all: &SunSet,
    inputs: &str,
    [pixels, suns]: [usize; 2],
    pictures: &mut dyn FnMut(&mut dyn Write, &dyn Fn(std::io::Error) -> Error) -> Result<()>,
) -> Result<()> {
    crate::files::seal::write_sealed(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        write_head(out, inputs, &all.hours, [pixels, suns]).map_err(fault)?;
        pictures(out, &fault)
    })
}
