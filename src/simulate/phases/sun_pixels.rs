//! Suns in the pictures of a project: for every sun that the hours asked for need, a sparse picture
//! on disk, from which the pictures of the hours take what they show.

use super::facade_suns::FacadeSuns;
use super::picture_sets;
use crate::camera::{Camera, Raster};
use crate::error::{Error, Result};
use crate::kernels::sun_matrix::Sun;
use crate::kernels::sun_matrix::pixels::{self, Models};
use crate::kernels::trace::TraceStatistics;
use crate::progress::Progress;
use crate::scene::Scene;
use crate::simulate::context::Context;
use crate::simulate::inputs::Inputs;
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

/// Pictures of all suns that `hours` need, or those of an earlier run if their inputs are the same; `behind` stands behind
/// the name of their file.
///
/// # Errors
/// Failures of device and file system, or when stopped.
pub(crate) fn sun_pictures(
    context: &Context<'_>,
    suns: &FacadeSuns,
    view: &ViewSection,
    shown: &Shown,
    hours: &[usize],
    behind: &str,
    statistics: &mut TraceStatistics,
) -> Result<SunPictures> {
    let mut inputs = context.scene_fingerprint("C of pictures");
    // What suns pass in each combination of states.
    for states in &suns.combinations {
        for window in &context.inputs.windows {
            let state = window.group.map(|group| &window.states[usize::from(states[group])]);
            let (shade, pane) = state.map_or((&window.shade, &window.pane), |s| (&s.shade, &s.pane));
            inputs.add(&(&window.window.triangles, &window.window.frame)).add(shade).add(&pane.as_ref().map(|p| p.inputs));
        }
    }
    let combinations = &suns.combinations;
    let (suns, places) = (&suns.set, &suns.places);
    let mut needed: Vec<usize> = hours.iter().filter_map(|&h| Some((*suns.hours.get(h)?)?.0)).collect();
    needed.sort_unstable();
    needed.dedup();
    let options = sun_picture_options(context.project);
    let name = match shown {
        Shown::Picture(raster) => {
            inputs.add(raster);
            format!("{}{behind}", view.name)
        }
        Shown::Discs(camera) => {
            inputs.add(camera);
            format!("{}_eye{behind}", view.name)
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
    let group = (GROUP_BYTES / (shown.pixels() * PIXEL_BYTES).max(1)).clamp(1, MOST_SUNS);
    let kept = context.store.stage(&format!("C_{name}"), *inputs.clone().add(&needed), context.progress);
    write(&path, suns, &inputs.to_string(), [shown.pixels(), needed.len()], &mut |out, fault| {
        let chunks = || needed.chunk_by(|a, b| places[*a].0 == places[*b].0).flat_map(|alike| alike.chunks(group));
        let mut made: Option<(usize, Scene, Scene, Inputs)> = None;
        for (part, numbers) in chunks().enumerate() {
            let combination = places[numbers[0]].0;
            if made.as_ref().is_none_or(|(of, ..)| *of != combination) {
                let facade = context.inputs.in_states(&combinations[combination]);
                let mut lit = facade.scene.clone();
                facade.shades().for_each(|s| add(&mut lit, &s.scene));
                made = Some((combination, black_model(&facade.scene, facade.shades()), lit, facade));
            }
            let Some((_, black, lit, facade)) = &made else { unreachable!("made above") };
            let (shaded, panes) = (facade.shaded_windows(), facade.pane_windows());
            let first_shade = facade.scene.materials.len() as u32;
            let models = Models { lit, black, first_shade, shaded: &shaded, panes: &panes };
            let traced: Vec<Sun> = numbers.iter().map(|&n| suns.suns[n]).collect();
            let stage = Part::of(context.progress, part, chunks().count());
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
