//! One run of a project: weather to S, windows and scene to V and D, their product to illuminance,
//! pictures and glare.

use super::context::{Context, Ledger};
use super::inputs::suns::SunCensus;
use super::inputs::{Differences, Inputs, reach};
use super::light::{Daylight, Light, Skies};
use super::overall::Overall;
use super::phases::sampled::{keep_transmissions, sampled};
use super::phases::sky::sky;
use super::project::Project;
use super::results::annual;
use super::results::control::decide;
use super::results::glare::{GlareJob, GlareSummary};
use super::results::mirrored;
use super::results::sensors::{self, SensorSummary};
use super::results::states;
use super::results::suns::TracedSuns;
use super::results::uncertainty::EstimatedError;
use super::results::views::{self, Made, ViewSummary};
use super::sampling::estimate::Estimate;
use super::store::Store;
use super::summary::{DeviceSummary, GroupSummary, Summary};
use crate::control;
use crate::error::{Error, Result, Warnings};
use crate::gpu::Device;
use crate::kernels::product;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::metrics::Year;
use crate::progress::Progress;
use std::path::Path;
use std::time::Instant;

/// Computes a project and writes its results into the folder `out`:
///
/// | file | content |
/// |---|---|
/// | `matrices/S.mtx` | sky matrix, rows patches (ground first), columns hours, RGB |
/// | `matrices/V_SENSORS.mtx` | view matrix, rows sensors, columns the bins of all parts of all windows in the project's order |
/// | `matrices/T_WINDOW.mtx` | transmission, rows outgoing bins, columns incident bins; `T_WINDOW@STATE.mtx` of windows that move |
/// | `matrices/D_WINDOW.mtx` | daylight matrix, rows the bins of the window's parts, columns patches |
/// | `matrices/*_direct.mtx`, `*_standard_error.mtx` | the part without diffuse reflection; the standard error of each entry |
/// | `matrices/Sds.mtx` | five phases: the sun's share of S |
/// | `matrices/replicates_*.mtx` | the independent estimates that V and D are the means of |
/// | `matrices/C_SENSORS.mtx`, `suns.rad` | five phases: sun matrix, columns the suns that were traced, listed in `suns.rad` |
/// | `matrices/DC_SENSORS.mtx` | two phases: daylight coefficients V·T·D; direct: C, with `_direct` and `_standard_error`, in place of V |
/// | `illuminance/terms/SENSORS_*.mtx` | five phases: `three_phase` V·T·D·S, `direct` Vd·T·Dd·Sds, `sun` Cds·Ssun, lux; direct: `whole` C·S, `direct` Cd·Sds, `sun` Cds·Ssun, the light that rooms reflect of the suns in both (see [`light`](super::light)) |
/// | `illuminance/SENSORS.mtx`, `.csv` | lux, rows sensors, columns time steps (transposed in the table, which marks sensors without light) |
/// | `illuminance/SENSORS_standard_error.mtx`, `.csv` | its standard error, lux |
/// | `illuminance/SENSORS_annual.csv` | mean, daylight autonomy, useful daylight, daylight factor and what else metrics count of each sensor, with their standard errors |
/// | `illuminance/states/GROUP/STATE/SENSORS.mtx`, `SENSORS_direct.mtx` | of windows with states: what each group sends in each, and its direct sunlight of traced suns; `illuminance/states/SENSORS.mtx`: the windows without states. The light of any combination is the sum over the groups |
/// | `control/schedule.csv` | the state of each group in every time step, as `[control]` reads it |
/// | `control/reasons.csv`, `signals.csv`, `values.csv` | where the run decides: why each group is in its state, what rules looked at, what each state is worth of optimal ones |
/// | `metrics/metrics.csv` | named metrics of each group and of all, with error, class, doubts |
/// | `metrics/hours.csv`, `SENSORS_sensors.csv` | time steps with the diffuse illuminance outdoors and which schedules count them; where sensors are and face |
/// | `illuminance/SENSORS_moments.csv` | named moments: mean, least and most lux of each, and daylight factors |
/// | `irradiance/SENSORS_monthly.csv` | sums of each month, kWh/m² |
/// | `illuminance/SENSORS_sky.csv` | direct: sky view factor, and hours of the weather's direct sun in which any of its disc is seen |
/// | `irradiance/` | in place of `illuminance/` for `quantity = "irradiance"`, W/m²; `SENSORS_annual.csv` has means and sums in kWh/m² |
/// | `matrices/V_VIEW.mtx` | view matrix of a picture, rows pixels from the top left |
/// | `images/VIEW/img_%04d.hdr` | pictures of the hours asked for, by hour of the year; of shorter steps with two digits more, the minute |
/// | `glare/VIEW.csv`, `.png`, `.svg` | DGP of every hour with its standard error; carpet plot |
/// | `glare/annual.csv`, `undecided.csv`, `METHOD.dgp` | annual glare of all views, in hours whatever the length of a step; steps whose class the noise leaves open (95 %); DGP, rows views, columns time steps |
/// | `summary.json` | [`Summary`] |
///
/// Matrices of an earlier run into the same folder are used again if all their inputs are the same,
/// so that a run that was stopped goes on where it was.
///
/// # Errors
/// A folder that cannot be written to, failures of the device, no sensor that light can reach (one that
/// none can reach has 0 lx and a warning), or when stopped by `progress`.
pub fn run(
    device: &Device,
    project: &Project,
    inputs: &Inputs,
    out: &Path,
    progress: &dyn Progress,
    warnings: &mut Warnings,
) -> Result<Summary> {
    let store = Store::of(out, project.output.quantity)?;
    compute(&context(device, project, inputs, &store, progress), warnings)
}

/// What a run works with.
pub(super) fn context<'a>(
    device: &'a Device,
    project: &'a Project,
    inputs: &'a Inputs,
    store: &'a Store,
    progress: &'a dyn Progress,
) -> Context<'a> {
    Context { device, project, choice: inputs.choice(project), inputs, scene: inputs.scene_fingerprint(), store, progress }
}

/// Measures a stage.
fn timed<T>(seconds: &mut f64, stage: impl FnOnce() -> Result<T>) -> Result<T> {
    let clock = Instant::now();
    let done = stage()?;
    *seconds = clock.elapsed().as_secs_f64();
    Ok(done)
}

/// The run, from the sky to the summary.
pub(super) fn compute(context: &Context<'_>, warnings: &mut Warnings) -> Result<Summary> {
    let overall = Overall::new(context.progress, context.project, context.inputs)?;
    let context = &Context { progress: &overall, ..*context };
    let start = Instant::now();
    let mut ledger = Ledger::default();
    let (inputs, progress) = (context.inputs, context.progress);
    let counting = inputs.counting(context.project)?;

    let clock = Instant::now();
    progress.begin("S");
    let sky = sky(context, &mut ledger)?;
    ledger.seconds.sky = clock.elapsed().as_secs_f64();

    let sampled = sampled(context, &mut ledger, &sky)?;
    let daylight: Vec<Matrix<f32>> = sampled.daylight.iter().map(Estimate::total).collect();
    let daylight_direct: Vec<Matrix<f32>> = sampled.daylight.iter().map(Estimate::direct).collect();

    let dark = reach::check(inputs, &sampled.view.total(), context.choice.direct, warnings)?;

    let skies = Skies { whole: sky, sun: sampled.sun.clone() };
    let multiplier = product::for_device(context.device)?;
    let multiplier = multiplier.as_ref();
    let at_windows = Daylight { total: &daylight, direct: &daylight_direct };
    let hours = Light::hours_of(&skies);
    let before = Made { multiplier, sampled: &sampled, skies: &skies, light: &hours, at_sensors: &hours, suns: None };
    let mut decision = decide(context, &counting, &before, at_windows, &mut ledger)?;
    // From here on the façade is as decided.
    let decided = decision.as_ref().map(|d| inputs.with_schedule(d.schedule.clone()));
    let inputs = decided.as_ref().unwrap_or(inputs);
    let context = &Context { inputs, ..*context };
    keep_transmissions(context, &sampled)?;

    let clock = Instant::now();
    progress.begin("Cds of sensors");
    let suns = TracedSuns::trace(context, &mut ledger, warnings)?;
    ledger.seconds.suns = clock.elapsed().as_secs_f64();

    let clock = Instant::now();
    context.check_stop()?;
    progress.begin("illuminance");
    progress.update("product", 0.0);
    let from_sky = sampled.sees_sky.then(|| Light::of_sky(&skies, Differences::NeverNegative));
    let from_windows = match &from_sky {
        // No receiver needs it.
        Some(_) if daylight.is_empty() => None,
        _ => Some(Light::of_facade(inputs, at_windows, multiplier, &skies)?),
    };
    let (Some(at_sensors), Some(light)) = (from_sky.as_ref().or(from_windows.as_ref()), from_windows.as_ref().or(from_sky.as_ref())) else {
        unreachable!("light comes from the sky, or from windows");
    };
    let made = Made { multiplier, sampled: &sampled, skies: &skies, light, at_sensors, suns: suns.as_ref() };
    if context.choice.phases == 2 {
        sensors::write_coefficients(context, &made)?;
    }
    let lux = sensors::light_at_sensors(context, &made)?;
    if sampled.sees_sky && suns.is_some() {
        mirrored::warn(&sampled.view.total(), &sampled.view.mean_replaced(), &skies, &lux, warnings);
    }
    ledger.seconds.product = clock.elapsed().as_secs_f64();

    let errors = timed(&mut ledger.seconds.error_estimate, || {
        sensors::errors(context, &counting, &made, &lux, decision.as_ref().and_then(|d| d.blinds.as_ref()))
    })?;

    let clock = Instant::now();
    let (groups, metrics) = sensors::write(context, &counting, &lux, &errors, &dark, decision.as_ref().and_then(|d| d.blinds.as_ref()))?;
    sensors::write_sky(context, &made)?;
    states::write(context, &made, at_windows, decision.as_mut().and_then(|d| d.light.take()), &mut ledger)?;
    write_schedule(context)?;
    let control = decision.as_ref().map(|d| d.write(context, &counting, warnings)).transpose()?;
    let pictures = views::pictures(context, &mut ledger, &made, warnings)?;
    ledger.seconds.write = clock.elapsed().as_secs_f64();

    let clock = Instant::now();
    let glare = match &context.project.glare {
        None => None,
        Some(section) => {
            let daylight_error: Vec<Matrix<f32>> = sampled.daylight.iter().map(Estimate::standard_error).collect();
            let job = GlareJob {
                context: *context,
                made,
                daylight: &daylight,
                daylight_direct: &daylight_direct,
                daylight_error: &daylight_error,
            };
            let mut statistics = TraceStatistics::default();
            let summary = job.run(section, &mut statistics, warnings)?;
            ledger.statistics.add(statistics);
            Some(summary)
        }
    };
    ledger.seconds.glare = clock.elapsed().as_secs_f64();
    ledger.seconds.total = start.elapsed().as_secs_f64();
    warn_of_error(context.project, &errors, warnings);
    context.store.warn_of_damage(warnings);
    let census = suns.as_ref().map(|suns| suns.set().census.clone());
    let summary = Summary {
        metrics,
        control,
        ..summary(context, &ledger, multiplier.description(), groups, pictures, glare, errors.estimated, census, warnings)
    };
    summary.write(&context.store.summary_path())?;
    context.store.remove_units();
    Ok(summary)
}

/// Writes the state of each group of windows in every time step, as a schedule that a project can name.
fn write_schedule(context: &Context<'_>) -> Result<()> {
    let inputs = context.inputs;
    if inputs.facade.groups().is_empty() {
        return Ok(());
    }
    control::write(&context.store.schedule_path()?, &inputs.facade, &Year::of(&inputs.weather), &inputs.schedule)
}

/// A result that misses what was asked for says so.
fn warn_of_error(project: &Project, errors: &annual::YearErrors, warnings: &mut Warnings) {
    let Some(error) = errors.estimated.filter(|e| e.target_met == Some(false)) else { return };
    let target = 100.0 * error.target.unwrap_or_default();
    let message = format!(
        "the standard error of a year's light is {:.2} % at the worst sensor, more than the {target:.2} % of {}",
        100.0 * error.annual_largest,
        project.quality.name()
    );
    let quality = &project.quality;
    let help = match (quality.time_limit, quality.target_error) {
        (Some(_), _) => "give it more time, or leave time_limit out".to_string(),
        (None, Some(_)) => {
            "the suns, which are sampled once, leave more than that; preset = \"final\" gives them the most samples".to_string()
        }
        _ => format!("write target_error = {} in place of the preset to sample until it is met", error.target.unwrap_or_default()),
    };
    warnings.push(Error::new(message).file(&project.file).field("quality").help(help));
}

#[allow(clippy::too_many_arguments, reason = "the parts of the summary")]
fn summary(
    context: &Context<'_>,
    ledger: &Ledger,
    product: String,
    sensors: Vec<SensorSummary>,
    views: Vec<ViewSummary>,
    glare: Option<GlareSummary>,
    estimated_error: Option<EstimatedError>,
    suns: Option<SunCensus>,
    warnings: &Warnings,
) -> Summary {
    let (project, inputs, rays) = (context.project, context.inputs, ledger.statistics.segments);
    let (windows, matrices_are_given) = Summary::of_windows(inputs, context.choice.phases);
    Summary {
        program: format!("lucarne {}", env!("CARGO_PKG_VERSION")),
        project: crate::files::relative(context.store.folder(), &project.file),
        device: DeviceSummary::of(context.device),
        preset: project.quality.preset.name().to_string(),
        quality: project.quality.name(),
        seed: project.quality.seed,
        phases: context.choice.phases,
        sensors_method: context.choice.formula().to_string(),
        quantity: project.output.quantity.name().to_string(),
        phases_because: context.choice.why.to_string(),
        suns,
        sky_subdivision: context.sky().subdivision(),
        bounces: project.method.bounces,
        weather: project.weather.describe(&inputs.weather),
        hours: inputs.weather.steps().hours(inputs.weather.records.len()),
        time_steps: inputs.weather.records.len(),
        windows,
        groups: GroupSummary::of(inputs, context.choice.phases),
        glass_left: inputs.glass_left.clone(),
        matrices_are_given,
        sensors,
        metrics: Vec::new(),
        control: None,
        views,
        glare,
        matrices: ledger.matrices.clone(),
        product,
        seconds: ledger.seconds,
        paths: ledger.statistics.paths,
        rays,
        rays_per_second: (rays > 0 && ledger.traced_seconds > 0.0).then(|| rays as f64 / ledger.traced_seconds),
        estimated_error,
        warnings: warnings.iter().map(ToString::to_string).collect(),
    }
}

/// Makes a run model everything, needed or not: D by rays where a quadrature would do, suns behind every
/// window, all channels, shaders for every kind of material. Results are the same within the bound
/// that the plan states for each omission; a check for those who doubt them.
pub fn without_pruning(project: &mut Project, inputs: &mut Inputs) {
    project.quality.prune = false;
    inputs.scene.unpruned = true;
}
