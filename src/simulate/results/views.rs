//! Pictures of a run: the view matrices of all views and their hourly pictures. Where a target error is
//! given, a view is sampled again if the light at its eye turns out to be known less well.

use super::pictures::{Addition, Output, PictureView, Request, write_pictures};
use super::suns::TracedSuns;
use crate::error::{Error, Result, Warnings};
use crate::gpu::DEFAULT_MEMORY;
use crate::image::series::Pattern;
use crate::kernels::product::Multiplier;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::scene::Window;
use crate::simulate::context::{Context, Ledger, Traced};
use crate::simulate::light::{Light, Skies};
use crate::simulate::multiply::lit_columns;
use crate::simulate::phases::picture_sets;
use crate::simulate::phases::pixels::ViewJob;
use crate::simulate::phases::sampled::Sampled;
use crate::simulate::phases::sun_pixels::{Shown, sun_pictures};
use crate::simulate::plan::presets::{SHARE_OF_VIEW, image_options};
use crate::simulate::project::glare::GlareMethod;
use crate::simulate::project::views::{ImageHours, ViewSection};
use crate::simulate::sampling::chain::Chain;
use crate::simulate::sampling::estimate::Estimate;
use crate::simulate::store::fingerprint::Fingerprint;
use crate::simulate::store::software;
use crate::simulate::store::sun_pictures::SunPictures;
use crate::weather::Steps;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::time::Instant;

/// Samples for a target, as a multiple of the standard ones, at most.
const MOST_SAMPLES: f64 = 16.0;

/// What a run has made before its pictures.
#[derive(Clone, Copy)]
pub struct Made<'a> {
    /// Multiplies.
    pub multiplier: &'a dyn Multiplier,
    /// V and D with their noise.
    pub sampled: &'a Sampled,
    /// S and Sds of the year.
    pub skies: &'a Skies,
    /// What the windows send into the room in every hour of the year.
    pub light: &'a Light,
    /// What the columns of the sensors' coefficients send: the same, or the sky's patches.
    pub at_sensors: &'a Light,
    /// The suns of five phases.
    pub suns: Option<&'a TracedSuns>,
}

/// One view.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewSummary {
    /// Its name.
    pub name: String,
    /// Pixels of its pictures.
    pub pixels: usize,
    /// Pictures written.
    pub pictures: usize,
    /// Relative standard error of a year's light at the eye, traced suns left out; absent for views
    /// without directions.
    pub eye_error: Option<f64>,
}

/// Relative standard error of a year's light at the eye of a view.
#[derive(Debug, Clone, Copy)]
struct EyeError {
    /// By the noise of the picture's view matrix.
    view: f64,
    /// By that and D's.
    all: f64,
}

/// View matrices and pictures of all `[[view]]`s.
///
/// # Errors
/// Views that cannot be, hours that the weather does not have, failures of device and file system, or when
/// stopped.
pub(crate) fn pictures(context: &Context<'_>, ledger: &mut Ledger, made: &Made<'_>, warnings: &mut Warnings) -> Result<Vec<ViewSummary>> {
    let project = context.project;
    let windows = context.inputs.geometry();
    let mut summaries = Vec::new();
    // Other ways to glare need no pictures of everything.
    let needless = project.glare.as_ref().is_some_and(|g| g.method != GlareMethod::Image);
    if needless && project.images.hours == ImageHours::None {
        return Ok(summaries);
    }
    let sky = &made.skies.whole;
    let steps = context.inputs.weather.steps();
    let asked = asked(context, made);
    for view in &project.views {
        context.progress.begin(&format!("V of {}", view.name));
        let eye_error = view_matrix(context, ledger, made, view, &windows, asked.as_deref())?;
        warn_of_view(context, view, eye_error, warnings);
        let hours = project.images.hours.chosen(&steps, &lit_columns(sky))?;
        let components = project.images.components;
        let mut suns = None;
        if let Some(traced) = made.suns
            && (0..context.inputs.windows.len()).any(|w| context.inputs.is_sunny(w))
            && (!hours.is_empty() || components)
        {
            let clock = Instant::now();
            context.progress.begin(&format!("suns of {}", view.name));
            let mut statistics = TraceStatistics::default();
            // The suns of all hours at once, if glare or their pictures will need them.
            let glare = project.glare.as_ref().is_some_and(|g| g.method.has_pictures());
            let needed = if glare || components { lit_columns(sky) } else { hours.clone() };
            let found = sun_pictures(context, &traced.facade, view, &Shown::Picture(view.raster()?), &needed, "", &mut statistics)?;
            let (seconds, rays) = (clock.elapsed().as_secs_f64(), statistics.segments);
            ledger.seconds.sun_pictures += seconds;
            let size = [view.raster()?.len(), found.suns().count()];
            ledger.note(&format!("suns_{}", view.name), size, rays == 0, seconds, Traced { rounds: 0, rays });
            suns = Some(found);
            ledger.count(statistics, clock);
        }
        if components {
            picture_sets::export(context.store, &view.name, made.suns.map(TracedSuns::set).zip(suns.as_ref()))?;
        }
        let job = view_job(context, view, &windows, 1);
        context.progress.begin(&format!("pictures of {}", view.name));
        let pictures = write(&job, made, &hours, &steps, suns.as_ref(), warnings)?;
        let pixels = view.raster()?.len();
        summaries.push(ViewSummary { name: view.name.clone(), pixels, pictures, eye_error: eye_error.map(|e| e.all) });
    }
    Ok(summaries)
}

/// What sampling for a target depends on.
fn asked(context: &Context<'_>, made: &Made<'_>) -> Option<String> {
    context.project.quality.target_error.map(|target| {
        let mut asked = Fingerprint::new("sampled for a target");
        asked.add(&target).add(&made.skies.whole.data());
        made.sampled.daylight.iter().for_each(|d| {
            asked.add(&d.total().data());
        });
        context.inputs.add_transmissions(&mut asked);
        asked.to_string()
    })
}

/// Makes and keeps the view matrix of a view, before its pictures are asked for.
///
/// # Errors
/// As [`pictures`].
pub(crate) fn make_matrix(context: &Context<'_>, ledger: &mut Ledger, made: &Made<'_>, view: &ViewSection) -> Result<()> {
    context.progress.begin(&format!("V of {}", view.name));
    view_matrix(context, ledger, made, view, &context.inputs.geometry(), asked(context, made).as_deref()).map(|_| ())
}

fn view_job<'a>(context: &Context<'a>, view: &'a ViewSection, windows: &'a [Window], refinement: u32) -> ViewJob<'a> {
    ViewJob { context: *context, windows, view, options: image_options(context.project, context.inputs, context.choice.phases), refinement }
}

/// Writes `images/NAME/img_%04d.hdr`, numbered by hour of the year ([`Steps::number`]), from the stored view
/// matrix, and with five phases the suns' pictures. `hours` are numbers of time steps. Returns how many.
fn write(
    job: &ViewJob<'_>,
    made: &Made<'_>,
    hours: &[usize],
    steps: &Steps,
    suns: Option<&SunPictures>,
    warnings: &mut Warnings,
) -> Result<usize> {
    if hours.is_empty() {
        return Ok(0);
    }
    let store = job.context.store;
    let folder = store.image_folder(&job.view.name)?;
    let matrix = store.matrix_path(&format!("V_{}", job.view.name));
    let mut view = if made.light.is_split() {
        PictureView::open_split(&matrix, &job.direct_path())?
    } else {
        PictureView::open_matrix(&matrix, None)?
    };
    let coefficients = made.light.of_hours(hours);
    let numbers: Vec<usize> = hours.iter().map(|&step| steps.number(step)).collect();
    let step_of: HashMap<usize, usize> = numbers.iter().copied().zip(hours.iter().copied()).collect();
    let sun_picture = |number: usize| suns.map_or_else(|| Ok(Vec::new()), |suns| suns.sun_picture(step_of[&number]));
    let addition: Option<&Addition<'_>> = if suns.is_some() { Some(&sun_picture) } else { None };
    let output = Output::Hdr(Pattern::inside(&folder, "img_%04d.hdr")?);
    let header = [software()];
    let request = Request {
        coefficients: &coefficients,
        hours: &numbers,
        output: &output,
        header: &header,
        memory: DEFAULT_MEMORY,
        addition,
        finished: None,
    };
    write_pictures(made.multiplier, &mut view, &request, job.context.progress, warnings)?;
    Ok(hours.len())
}

/// The view matrix, good enough for the target if there is one, and how well the light at the eye is
/// known; nothing for a view without directions.
fn view_matrix(
    context: &Context<'_>,
    ledger: &mut Ledger,
    made: &Made<'_>,
    view: &ViewSection,
    windows: &[Window],
    asked: Option<&str>,
) -> Result<Option<EyeError>> {
    let clock = Instant::now();
    context.check_stop()?;
    let mut inputs = context.view_fingerprint("V of pictures");
    inputs.add(&view.raster()?).add(&image_options(context.project, context.inputs, context.choice.phases));
    let target = context.project.quality.target_error;
    let refined = *inputs.clone().add(&asked);
    let mut statistics = TraceStatistics::default();
    let job = view_job(context, view, windows, 1);
    let (rows, columns, reused, error) = match job.kept(refined)? {
        Some((rows, columns)) if target.is_some() => (rows, columns, true, eye_error(context, made, &job)?),
        _ => {
            let (rows, columns, reused) = job.matrix(inputs, &mut statistics)?;
            let error = eye_error(context, made, &job)?;
            let allowed = target.map(|t| t * SHARE_OF_VIEW.sqrt());
            match (error, allowed) {
                (Some(error), Some(allowed)) if error.view > allowed => {
                    // A quarter more: the error is itself known from a few batches only.
                    let more = (1.25 * (error.view / allowed).powi(2)).ceil().min(MOST_SAMPLES);
                    let job = view_job(context, view, windows, more as u32);
                    let (rows, columns, reused) = job.matrix(refined, &mut statistics)?;
                    (rows, columns, reused, eye_error(context, made, &job)?)
                }
                (error, _) => (rows, columns, reused, error),
            }
        }
    };
    let seconds = clock.elapsed().as_secs_f64();
    ledger.note(&format!("V_{}", view.name), [rows, columns], reused, seconds, Traced { rounds: 0, rays: statistics.segments });
    ledger.count(statistics, clock);
    Ok(error)
}

/// How well a year's light at the eye is known, from the batches of the view matrix and of D. Suns
/// that five phases trace are left out.
fn eye_error(context: &Context<'_>, made: &Made<'_>, job: &ViewJob<'_>) -> Result<Option<EyeError>> {
    let path = job.batches_path();
    if !path.is_file() {
        return Ok(None);
    }
    let sums = read_matrix(&path)?.matrix;
    let batches = job.options.batches as usize;
    // The first row of each batch is that of the light at the eye.
    let rows = sums.rows() / batches;
    let row = |batch: usize| Matrix::from_data(1, sums.cols(), 3, sums.row(batch * rows).to_vec());
    let replicates = (0..batches).map(row).collect::<Result<Vec<_>>>()?;
    let view = Estimate { replicates, rounds: 1, ..Estimate::none() };
    let chain =
        Chain { inputs: context.inputs, view: &view, daylight: &made.sampled.daylight, sees_sky: false, sky: &made.skies.whole, sun: None };
    let Some(year) = chain.annual().into_iter().next().filter(|y| y.value > 0.0) else { return Ok(None) };
    let relative = |variance: f64| variance.sqrt() / year.value;
    // What rounds know beyond the replicates is about the sensors, or about all eyes.
    let parts = year.by_replicates_of_source;
    Ok(Some(EyeError { view: relative(parts[0]), all: relative(parts.iter().sum()) }))
}

fn warn_of_view(context: &Context<'_>, view: &ViewSection, error: Option<EyeError>, warnings: &mut Warnings) {
    let (Some(error), Some(target)) = (error, context.project.quality.target_error) else { return };
    if error.all > target {
        let message = format!(
            "the standard error of a year's light at the eye of view '{}' is {:.2} %, more than the target error of {:.2} %",
            view.name,
            100.0 * error.all,
            100.0 * target
        );
        let help = match context.project.quality.time_limit {
            Some(_) => "give it more time, or leave time_limit out",
            None => "the target is finer than pictures are sampled for; take a larger one",
        };
        warnings.push(Error::new(message).file(&context.project.file).field("quality").help(help));
    }
}
