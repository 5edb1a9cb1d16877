//! V of all sensors and D of all windows: sampled together, since one stops when the other is good enough,
//! and kept.

use crate::error::Result;
use crate::kernels::daylight_matrix::{self, DaylightOptions, unobstructed};
use crate::kernels::trace::{TraceStatistics, TracedMatrix};
use crate::kernels::view_matrix::{self, ViewOptions};
use crate::matrix::Matrix;
use crate::progress::Progress;
use crate::scene::Window;
use crate::scene::points::Sensor;
use crate::simulate::context::{Context, Ledger, Seconds, Traced};
use crate::simulate::inputs::import;
use crate::simulate::inputs::{Inputs, split};
use crate::simulate::phases::sky::sun_alone;
use crate::simulate::plan::presets::{SHARE_OF_SENSORS, SHARE_OF_VIEW, daylight_options, view_options};
use crate::simulate::project::quality::Stop;
use crate::simulate::sampling::chain::Chain;
use crate::simulate::sampling::estimate::Estimate;
use crate::simulate::sampling::{Judge, Source, sample};
use crate::simulate::store::fingerprint::Fingerprint;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The sampled matrices.
pub(crate) struct Sampled {
    /// V of all sensors.
    pub view: Estimate,
    /// D of each window.
    pub daylight: Vec<Estimate>,
    /// Sds, where five phases take the sun out and there is any.
    pub sun: Option<Matrix<f32>>,
}

impl Sampled {
    /// For the errors of its product with S.
    pub fn chain<'m>(&'m self, inputs: &'m Inputs, sky: &'m Matrix<f32>) -> Chain<'m> {
        Chain { inputs, view: &self.view, daylight: &self.daylight, sky, sun: self.sun.as_ref() }
    }
}

/// What the chain has beside V and D.
struct Fixed<'m> {
    inputs: &'m Inputs,
    sky: &'m Matrix<f32>,
    sun: Option<&'m Matrix<f32>>,
    eyes: Option<&'m Estimate>,
}

/// What the rounds of all sources took together.
#[derive(Default)]
struct Meter(Mutex<(TraceStatistics, Seconds)>);

impl Meter {
    fn measure(&self, stage: fn(&mut Seconds) -> &mut f64, trace: impl FnOnce() -> Result<TracedMatrix>) -> Result<TracedMatrix> {
        let clock = Instant::now();
        let traced = trace()?;
        let mut spent = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        spent.0.add(traced.statistics);
        *stage(&mut spent.1) += clock.elapsed().as_secs_f64();
        Ok(traced)
    }
}

/// V of all groups and D of all windows, sampled as `[quality]` asks.
///
/// # Errors
/// Failures of tracing and of the file system, or when stopped.
pub(crate) fn sampled(context: &Context<'_>, ledger: &mut Ledger, sky: &Matrix<f32>) -> Result<Sampled> {
    context.check_stop()?;
    let (project, inputs) = (context.project, context.inputs);
    let windows = inputs.geometry();
    let sensors = inputs.all_sensors();
    let stop = project.quality.stop();
    let meter = Meter::default();
    let mut sources = vec![view_source(context, &windows, &sensors, &meter)?];
    sources.extend((0..inputs.windows.len()).map(|i| daylight_source(context, i, &meter)));
    if let Stop::Adaptive { .. } = stop {
        // What is sampled next depends on all of it.
        for source in &mut sources {
            source.inputs.add(&"adaptive").add(&sky.data());
            for window in &inputs.windows {
                source.inputs.add(&window.transmission.data());
            }
        }
    }
    let five = context.choice.phases == 5;
    let sun = if five { Some(sun_alone(context)?).filter(|sun| sun.data().iter().any(|v| *v != 0.0)) } else { None };
    let eyes = eyes(context, stop, &windows, &meter)?;
    fn chain_of<'m>(fixed: &Fixed<'m>, estimates: &'m [Estimate]) -> Chain<'m> {
        let view = fixed.eyes.unwrap_or(&estimates[0]);
        Chain { inputs: fixed.inputs, view, daylight: &estimates[1..], sky: fixed.sky, sun: fixed.sun }
    }
    let fixed = Fixed { inputs, sky, sun: sun.as_ref(), eyes: eyes.as_ref() };
    let judge = |estimates: &[Estimate]| {
        let mut judgement = chain_of(&fixed, estimates).judge();
        let room = if eyes.is_some() {
            // What the pictures' own noise leaves.
            (1.0 - SHARE_OF_VIEW).sqrt()
        } else if five {
            // Room for the suns' own error.
            SHARE_OF_SENSORS.sqrt()
        } else {
            1.0
        };
        judgement.error /= room;
        judgement.at_most /= room;
        Ok(judgement)
    };
    let squares = |estimates: &[Estimate], source: usize| chain_of(&fixed, estimates).squares(source);
    let judge = Judge { judge: &judge, squares: &squares };
    let (mut estimates, traced) = sample(&sources, stop, context.store, context.progress, &judge)?;
    let fingerprints: Vec<Fingerprint> = sources.iter().map(|s| s.inputs).collect();
    drop(sources);
    let (statistics, spent) = meter.0.into_inner().unwrap_or_else(PoisonError::into_inner);
    ledger.statistics.add(statistics);
    ledger.traced_seconds += spent.view + spent.daylight;
    (ledger.seconds.view, ledger.seconds.daylight) = (spent.view, spent.daylight);
    let daylight = estimates.split_off(1);
    let view = estimates.remove(0);
    keep_view(context, ledger, &view, fingerprints[0], traced[0])?;
    for (i, d) in daylight.iter().enumerate() {
        keep_daylight(context, ledger, i, d, fingerprints[i + 1], traced[i + 1])?;
    }
    Ok(Sampled { view, daylight, sun })
}

fn view_source<'a>(context: &Context<'a>, windows: &'a [Window], sensors: &'a [Sensor], meter: &'a Meter) -> Result<Source<'a>> {
    let (device, project, inputs) = (context.device, context.project, context.inputs);
    let direct = context.choice.phases == 5;
    let options = |round| ViewOptions { keep_batches: true, ..view_options(project, round) };
    let mut fingerprint = context.view_fingerprint("V");
    fingerprint.add(&sensors).add(&options(0)).add(&direct);
    let given = import::view(inputs.sensors.iter().map(|g| (g.name.as_str(), g.view.as_ref())), inputs.bins())?;
    if let Some(given) = &given {
        given.mark(&mut fingerprint);
    }
    let none = || Matrix::zeros(0, inputs.bins(), 3);
    Ok(Source {
        name: "V".into(),
        inputs: fingerprint,
        shape: (sensors.len(), inputs.bins()),
        keep_direct: direct,
        trace: Box::new(move |round, progress: &dyn Progress| {
            meter.measure(|s| &mut s.view, || view_matrix::compute(device, &inputs.scene, windows, sensors, &options(round), progress))
        }),
        exact: sensors.is_empty().then(|| Estimate::exact(none(), none())).or_else(|| given.map(Estimate::from)),
    })
}

fn daylight_source<'a>(context: &Context<'a>, number: usize, meter: &'a Meter) -> Source<'a> {
    let (device, project, inputs) = (context.device, context.project, context.inputs);
    let window = &inputs.windows[number];
    let sky = context.sky();
    let direct = context.choice.phases == 5;
    let options = move |round| DaylightOptions { keep_batches: true, ..daylight_options(project, number, round) };
    let mut fingerprint = context.scene_fingerprint("D");
    fingerprint.add(&(&window.window.triangles, &window.window.frame, &window.window.basis)).add(&sky).add(&options(0)).add(&direct);
    if let Some(given) = &window.daylight {
        given.mark(&mut fingerprint);
    }
    Source {
        name: format!("D_{}", window.name),
        inputs: fingerprint,
        shape: (window.window.basis.len(), sky.len()),
        keep_direct: direct,
        trace: Box::new(move |round, progress: &dyn Progress| {
            meter.measure(
                |s| &mut s.daylight,
                || daylight_matrix::compute(device, &inputs.scene, &window.window, sky, &options(round), progress),
            )
        }),
        exact: window.daylight.clone().map(Estimate::from).or_else(|| {
            (project.quality.prune && unobstructed::nothing_before(&inputs.scene, &window.window)).then(|| {
                let shares = unobstructed::compute(&window.window, sky);
                Estimate::exact(shares.clone(), shares)
            })
        }),
    }
}

/// V of the views' eyes, taken for exact, where they alone tell how good D must be: in a project
/// without sensors. The pictures' view matrices are sampled for themselves.
fn eyes(context: &Context<'_>, stop: Stop, windows: &[Window], meter: &Meter) -> Result<Option<Estimate>> {
    let (project, inputs) = (context.project, context.inputs);
    if !matches!(stop, Stop::Adaptive { .. }) || !inputs.sensors.is_empty() || project.views.is_empty() {
        return Ok(None);
    }
    let sensors = project.views.iter().map(|v| v.eye()).collect::<Result<Vec<_>>>()?;
    let options = view_options(project, 0);
    let trace = || view_matrix::compute(context.device, &inputs.scene, windows, &sensors, &options, context.progress);
    let traced = meter.measure(|s| &mut s.view, trace)?;
    Ok(Some(Estimate::exact(traced.total, traced.direct)))
}

fn of(estimate: &Estimate) -> Traced {
    Traced { rounds: estimate.rounds, rays: estimate.rays }
}

fn keep_view(context: &Context<'_>, ledger: &mut Ledger, view: &Estimate, mut inputs: Fingerprint, traced: bool) -> Result<()> {
    if context.inputs.sensors.is_empty() {
        return Ok(());
    }
    inputs.add(&view.rounds);
    let total = view.total();
    let parts = [("", total), ("_direct", view.direct()), ("_standard_error", view.standard_error())];
    for (suffix, matrix) in parts {
        for (group, part) in context.inputs.sensors.iter().zip(split(&matrix, &context.inputs.sensors)) {
            let name = format!("V_{}{suffix}", group.name);
            if !context.store.has_matrix(&name, inputs) {
                context.store.save(&name, &part, inputs, "view matrix, rows sensors, columns the windows' bins")?;
            }
            if suffix.is_empty() {
                ledger.note(&name, [part.rows(), part.cols()], !traced, ledger.seconds.view, of(view));
            }
        }
    }
    Ok(())
}

fn keep_daylight(
    context: &Context<'_>,
    ledger: &mut Ledger,
    index: usize,
    daylight: &Estimate,
    mut inputs: Fingerprint,
    traced: bool,
) -> Result<()> {
    let window = &context.inputs.windows[index];
    let name = format!("D_{}", window.name);
    inputs.add(&daylight.rounds);
    let total = daylight.total();
    let parts = [("_direct", daylight.direct()), ("_standard_error", daylight.standard_error()), ("", total.clone())];
    for (suffix, matrix) in parts {
        let name = format!("{name}{suffix}");
        if !context.store.has_matrix(&name, inputs) {
            context.store.save(&name, &matrix, inputs, "daylight matrix, rows the window's bins, columns patches")?;
        }
    }
    let t = window.transmission.map(|v| v as f32);
    let transmission_inputs = *Fingerprint::new("T").add(&t.data());
    let t_name = format!("T_{}", window.name);
    if !context.store.has_matrix(&t_name, transmission_inputs) {
        context.store.save(&t_name, &t, transmission_inputs, "transmission, rows outgoing bins, columns incident bins")?;
    }
    ledger.note(&name, [total.rows(), total.cols()], !traced, ledger.seconds.daylight, of(daylight));
    Ok(())
}
