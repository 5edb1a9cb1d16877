//! V of all sensors and D of all windows: sampled together, since one stops when the other is good enough,
//! and kept. Where sensors see the sky itself C stands for V, and D is for pictures alone.

use crate::error::Result;
use crate::kernels::coefficients::{self, CoefficientOptions};
use crate::kernels::daylight_matrix::{self, DaylightOptions, unobstructed};
use crate::kernels::trace::{TraceStatistics, TracedMatrix};
use crate::kernels::view_matrix::{self, ViewOptions};
use crate::matrix::Matrix;
use crate::progress::Progress;
use crate::scene::points::Sensor;
use crate::scene::{GlazedWindow, Window};
use crate::simulate::context::{Context, Ledger, Seconds, Traced};
use crate::simulate::inputs::import;
use crate::simulate::inputs::windows::WindowState;
use crate::simulate::inputs::{Inputs, split};
use crate::simulate::phases::sky::sun_alone;
use crate::simulate::plan::presets::{SHARE_OF_SENSORS, SHARE_OF_VIEW, coefficient_options, daylight_options, view_options};
use crate::simulate::project::quality::Stop;
use crate::simulate::sampling::chain::Chain;
use crate::simulate::sampling::estimate::Estimate;
use crate::simulate::sampling::{Judge, Judgement, Source, sample};
use crate::simulate::store::fingerprint::Fingerprint;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The sampled matrices.
pub(crate) struct Sampled {
    /// V of all sensors, or C.
    pub view: Estimate,
    /// Whether it is C.
    pub sees_sky: bool,
    /// D of each window; nothing where no receiver needs it.
    pub daylight: Vec<Estimate>,
    /// Sds, where five phases take the sun out and there is any.
    pub sun: Option<Matrix<f32>>,
}

impl Sampled {
    /// For the errors of the sensors' product with S.
    pub fn chain<'m>(&'m self, inputs: &'m Inputs, sky: &'m Matrix<f32>) -> Chain<'m> {
        let daylight = if self.sees_sky { &[] } else { &self.daylight[..] };
        Chain { inputs, view: &self.view, daylight, sees_sky: self.sees_sky, sky, sun: self.sun.as_ref() }
    }
}

/// What the chain has beside V and D.
struct Fixed<'m> {
    inputs: &'m Inputs,
    sky: &'m Matrix<f32>,
    sun: Option<&'m Matrix<f32>>,
    eyes: Option<&'m Estimate>,
    sees_sky: bool,
}

impl<'m> Fixed<'m> {
    /// Of the sensors, or of the eyes in a project without.
    fn sensors(&self, estimates: &'m [Estimate]) -> Chain<'m> {
        let (inputs, sky, sun, sees_sky) = (self.inputs, self.sky, self.sun, self.sees_sky);
        let (view, daylight) = match self.eyes {
            _ if sees_sky => (&estimates[0], &[][..]),
            Some(eyes) => (eyes, &estimates[1..]),
            None => (&estimates[0], &estimates[1..]),
        };
        Chain { inputs, view, daylight, sees_sky, sky, sun }
    }

    /// Of the eyes beside sensors that need no D: they alone tell how good it must be.
    fn eyes(&self, estimates: &'m [Estimate]) -> Option<Chain<'m>> {
        let view = self.eyes.filter(|_| self.sees_sky)?;
        Some(Chain { inputs: self.inputs, view, daylight: &estimates[1..], sees_sky: false, sky: self.sky, sun: self.sun })
    }
}

/// Of two chains without a matrix in common: each variance in relation to its own light.
fn both(sensors: &Judgement, eyes: &Judgement) -> Judgement {
    let relative = |j: &Judgement| -> Vec<f64> {
        let all: f64 = j.variances.iter().sum();
        j.variances.iter().map(|v| if all > 0.0 { v / all * j.error.powi(2) } else { 0.0 }).collect()
    };
    let variances = relative(sensors).into_iter().chain(relative(eyes).into_iter().skip(1)).collect();
    Judgement { error: sensors.error.max(eyes.error), at_most: sensors.at_most.max(eyes.at_most), variances }
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
    let glazed = inputs.glazed();
    let sensors = inputs.all_sensors();
    let sees_sky = context.choice.direct;
    let stop = project.quality.stop();
    let meter = Meter::default();
    let mut sources = vec![match sees_sky {
        true => coefficient_source(context, &glazed, &sensors, &meter),
        false => view_source(context, &windows, &sensors, &meter)?,
    }];
    if !sees_sky || !project.views.is_empty() {
        sources.extend((0..inputs.windows.len()).map(|i| daylight_source(context, i, &meter)));
    }
    if let Stop::Adaptive { .. } = stop {
        // What is sampled next depends on all of it.
        for source in &mut sources {
            source.inputs.add(&"adaptive").add(&sky.data());
            inputs.add_transmissions(&mut source.inputs);
        }
    }
    let five = context.choice.phases == 5;
    let sun = if five { Some(sun_alone(context)?).filter(|sun| sun.data().iter().any(|v| *v != 0.0)) } else { None };
    let eyes = eyes(context, stop, &windows, &meter)?;
    let fixed = Fixed { inputs, sky, sun: sun.as_ref(), eyes: eyes.as_ref(), sees_sky };
    let judge = |estimates: &[Estimate]| {
        // What the pictures' own noise, or the suns', leaves.
        let with_room = |mut judgement: Judgement, share: f64| {
            judgement.error /= share.sqrt();
            judgement.at_most /= share.sqrt();
            judgement
        };
        let of_sensors = if eyes.is_some() && !sees_sky {
            1.0 - SHARE_OF_VIEW
        } else if five {
            SHARE_OF_SENSORS
        } else {
            1.0
        };
        let sensors = with_room(fixed.sensors(estimates).judge(), of_sensors);
        Ok(match fixed.eyes(estimates) {
            Some(eyes) => both(&sensors, &with_room(eyes.judge(), 1.0 - SHARE_OF_VIEW)),
            None => sensors,
        })
    };
    let squares = |estimates: &[Estimate], source: usize| match fixed.eyes(estimates).filter(|_| source > 0) {
        Some(eyes) => eyes.squares(source),
        None => fixed.sensors(estimates).squares(source),
    };
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
    Ok(Sampled { view, sees_sky, daylight, sun })
}

fn coefficient_source<'a>(context: &Context<'a>, glazed: &'a [GlazedWindow], sensors: &'a [Sensor], meter: &'a Meter) -> Source<'a> {
    let (device, project, inputs, sky) = (context.device, context.project, context.inputs, context.sky());
    let options = move |round| CoefficientOptions { keep_batches: true, ..coefficient_options(project, round) };
    let mut fingerprint = context.scene_fingerprint("C of the sky");
    fingerprint.add(&sensors).add(&sky).add(&options(0));
    for glazed in glazed {
        fingerprint.add(&(&glazed.window.triangles, glazed.window.frame.z, glazed.pane));
    }
    Source {
        name: "DC".into(),
        inputs: fingerprint,
        shape: (sensors.len(), sky.len()),
        keep_direct: true,
        has_sunlit: options(0).sun_paths.is_some(),
        trace: Box::new(move |round, progress: &dyn Progress| {
            meter.measure(|s| &mut s.view, || coefficients::compute(device, &inputs.scene, glazed, sensors, sky, &options(round), progress))
        }),
        exact: None,
    }
}

fn view_source<'a>(context: &Context<'a>, windows: &'a [Window], sensors: &'a [Sensor], meter: &'a Meter) -> Result<Source<'a>> {
    let (device, project, inputs) = (context.device, context.project, context.inputs);
    let direct = context.choice.phases == 5;
    let options = |round| ViewOptions { keep_batches: true, ..view_options(project, inputs, round) };
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
        has_sunlit: false,
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
    let options = move |round| DaylightOptions { keep_batches: true, ..daylight_options(project, inputs, number, round) };
    let mut fingerprint = context.scene_fingerprint("D");
    for part in &window.parts {
        fingerprint.add(&(&part.triangles, &part.frame, &part.basis));
    }
    fingerprint.add(&sky).add(&options(0)).add(&direct);
    if let Some(given) = &window.daylight {
        given.mark(&mut fingerprint);
    }
    Source {
        name: format!("D_{}", window.name),
        inputs: fingerprint,
        shape: (window.bins(), sky.len()),
        keep_direct: direct,
        has_sunlit: false,
        trace: Box::new(move |round, progress: &dyn Progress| {
            meter.measure(
                |s| &mut s.daylight,
                || daylight_matrix::compute_of_parts(device, &inputs.scene, &window.parts, sky, &options(round), progress),
            )
        }),
        exact: window.daylight.clone().map(Estimate::from).or_else(|| {
            (project.quality.prune && unobstructed::nothing_before(&inputs.scene, &window.window)).then(|| {
                let shares = repeated(unobstructed::compute(&window.window, sky), window.parts.len());
                Estimate::exact(shares.clone(), shares)
            })
        }),
    }
}

/// The rows of a matrix so many times, one below the other.
fn repeated(matrix: Matrix<f32>, times: usize) -> Matrix<f32> {
    let (rows, cols) = (times * matrix.rows(), matrix.cols());
    Matrix::from_data(rows, cols, matrix.components(), matrix.data().repeat(times)).expect("as many rows as values")
}

/// V of the views' eyes, taken for exact, where they alone tell how good D must be: in a project
/// without sensors, or whose sensors need no D. The pictures' view matrices are sampled for themselves.
fn eyes(context: &Context<'_>, stop: Stop, windows: &[Window], meter: &Meter) -> Result<Option<Estimate>> {
    let (project, inputs) = (context.project, context.inputs);
    let by_sensors = !inputs.sensors.is_empty() && !context.choice.direct;
    if !matches!(stop, Stop::Adaptive { .. }) || by_sensors || project.views.is_empty() {
        return Ok(None);
    }
    let sensors = project.views.iter().map(|v| v.eye()).collect::<Result<Vec<_>>>()?;
    let options = view_options(project, inputs, 0);
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
    let (prefix, about) = match context.choice.direct {
        true => ("DC", "daylight coefficients C, rows sensors, columns patches"),
        false => ("V", "view matrix, rows sensors, columns the windows' bins"),
    };
    inputs.add(&view.rounds);
    let total = view.total();
    let parts = [("", total), ("_direct", view.direct()), ("_standard_error", view.standard_error())];
    for (suffix, matrix) in parts {
        for (group, part) in context.inputs.sensors.iter().zip(split(&matrix, &context.inputs.sensors)) {
            let name = format!("{prefix}_{}{suffix}", group.name);
            if !context.store.has_matrix(&name, inputs) {
                context.store.save(&name, &part, inputs, about)?;
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
            context.store.save(&name, &matrix, inputs, "daylight matrix, rows the bins of the window's parts, columns patches")?;
        }
    }
    ledger.note(&name, [total.rows(), total.cols()], !traced, ledger.seconds.daylight, of(daylight));
    Ok(())
}

/// Keeps T of the windows whose D is kept; of a façade that moves, of each state that it is ever in.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn keep_transmissions(context: &Context<'_>, sampled: &Sampled) -> Result<()> {
    for (index, window) in context.inputs.windows.iter().enumerate().take(sampled.daylight.len()) {
        let uses: Vec<(String, &Matrix<f64>)> = match window.group.filter(|_| context.inputs.uses(index).len() > 1) {
            None => vec![(format!("T_{}", window.name), &window.transmission)],
            Some(group) => {
                let of = |s: &WindowState| format!("T_{}@{}", window.name, s.name);
                let used = context.inputs.schedule.used(group);
                used.iter().map(|s| &window.states[usize::from(*s)]).map(|s| (of(s), &s.transmission)).collect()
            }
        };
        for (name, t) in uses {
            let t = t.map(|v| v as f32);
            let inputs = *Fingerprint::new("T").add(&t.data());
            if !context.store.has_matrix(&name, inputs) {
                context.store.save(&name, &t, inputs, "transmission, rows outgoing bins, columns incident bins")?;
            }
        }
    }
    Ok(())
}
