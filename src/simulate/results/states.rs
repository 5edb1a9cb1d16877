//! What each group of windows sends to the sensors in each of its states, in every hour: the light of any combination of
//! states, also of combinations that no schedule has, is the sum over the groups.
//!
//! V·T of all states stand one below the other and are multiplied with D·S of the group at once: V and D are the same.

use super::illuminance::{illuminance, luminous};
use super::views::Made;
use crate::control::State;
use crate::error::Result;
use crate::kernels::sun_matrix::SunMatrix;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::simulate::context::{Context, Ledger};
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::inputs::windows::WindowState;
use crate::simulate::inputs::{ProjectWindow, split};
use crate::simulate::light::{Daylight, multiply, without_sun};
use crate::simulate::multiply::{Factor, product, select_columns};
use crate::simulate::phases::facade_suns::{through_group, through_rest};
use crate::simulate::store::write_stored;
use rayon::prelude::*;
use std::time::Instant;

/// Memory for the products of states that are multiplied together, bytes.
const BATCH_MEMORY: usize = 1 << 29;

/// What windows send to all sensors in one state.
#[derive(Debug, Clone, PartialEq)]
pub struct LightOfState {
    /// Illuminance `[sensor][step]`, lx; W/m² of irradiance.
    pub lux: Matrix<f32>,
    /// The part of it that comes directly from traced suns; nothing where none are traced.
    pub sun: Option<Matrix<f32>>,
}

/// What all windows send to all sensors, in every state.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct StateLight {
    /// `[group][state]`, in the order of the façade's groups and their states.
    pub groups: Vec<Vec<LightOfState>>,
    /// Of the windows that have no states, if there are any.
    pub rest: Option<LightOfState>,
}

impl StateLight {
    /// The light of all groups in each of their states, for what decides between them.
    ///
    /// # Errors
    /// As [`each_state`].
    pub fn new(context: &Context<'_>, made: &Made<'_>, daylight: Daylight<'_>, ledger: &mut Ledger) -> Result<Self> {
        let clock = Instant::now();
        let mut all = Self { groups: vec![Vec::new(); context.inputs.facade.groups().len()], rest: None };
        let statistics = each_state(context, made, daylight, &mut |whose, light| {
            match whose {
                Some((group, _)) => all.groups[group].push(light),
                None => all.rest = Some(light),
            }
            Ok(())
        })?;
        ledger.count(statistics, clock);
        Ok(all)
    }

    /// What these groups send in their states, and the windows without any.
    pub fn parts<'a>(&'a self, states: impl Iterator<Item = (usize, State)> + 'a) -> impl Iterator<Item = &'a LightOfState> {
        states.map(|(group, state)| &self.groups[group][usize::from(state)]).chain(&self.rest)
    }
}

/// Whose light it is: number of group and state, or nothing for the windows without states.
pub(crate) type Whose = Option<(usize, State)>;

/// Shows the light of every state of every group, then that of the windows without states; gives what was traced for it.
///
/// # Errors
/// Failures of device and file system and of `show`, or when stopped.
pub(crate) fn each_state(
    context: &Context<'_>,
    made: &Made<'_>,
    daylight: Daylight<'_>,
    show: &mut dyn FnMut(Whose, LightOfState) -> Result<()>,
) -> Result<TraceStatistics> {
    let inputs = context.inputs;
    let mut statistics = TraceStatistics::default();
    let suns = (context.choice.phases == 5).then(|| inputs.sun_set_of_states(context.project)).transpose()?;
    let sensors = &inputs.sensors;
    for (group, named) in inputs.facade.groups().iter().enumerate() {
        let windows = inputs.windows_of_group(group);
        let rows = inputs.all_sensors().len() * made.at_sensors.hours.len() * size_of::<f32>();
        let batch = (BATCH_MEMORY / rows.max(1)).max(1);
        let states: Vec<State> = (0..named.states.len()).map(|s| s as State).collect();
        for batch in states.chunks(batch) {
            context.check_stop()?;
            let of = |state: &State| -> Vec<Shown<'_>> {
                windows.iter().map(|w| Shown::of_state(&inputs.windows[*w].states[usize::from(*state)])).collect()
            };
            let shown: Vec<Vec<Shown<'_>>> = batch.iter().map(of).collect();
            let light = behind_windows(context, made, daylight, &windows, &shown)?;
            for (&state, lux) in batch.iter().zip(light) {
                let part = match &suns {
                    Some(suns) => through_group(context, sensors, suns, group, state)?.map(|(part, _)| (part, suns)),
                    None => None,
                };
                part.iter().for_each(|(part, _)| statistics.add(part.statistics));
                show(Some((group, state)), with_suns(lux, part))?;
            }
        }
    }
    let windows = inputs.windows_without_states();
    if !windows.is_empty() {
        let shown: Vec<Shown<'_>> = windows.iter().map(|w| Shown::of_window(&inputs.windows[*w])).collect();
        let light = behind_windows(context, made, daylight, &windows, &[shown])?.remove(0);
        let part = match &suns {
            Some(suns) => through_rest(context, sensors, suns)?.map(|(part, _)| (part, suns)),
            None => None,
        };
        part.iter().for_each(|(part, _)| statistics.add(part.statistics));
        show(None, with_suns(light, part))?;
    }
    Ok(statistics)
}

/// A window as the formula has it.
#[derive(Clone, Copy)]
struct Shown<'a> {
    transmission: &'a Matrix<f64>,
    is_sunny: bool,
}

impl<'a> Shown<'a> {
    fn of_state(state: &'a WindowState) -> Self {
        Self { transmission: &state.transmission, is_sunny: state.is_sunny() }
    }

    fn of_window(window: &'a ProjectWindow) -> Self {
        Self { transmission: &window.transmission, is_sunny: window.is_sunny() }
    }
}

/// `[(V − Vd)·T | Vd·T]·[D·S ; D·S − Dd·Sds]` of some windows, where no sun is traced `[V·T | 0]`, for each of some states
/// `[state][window]`: lux `[sensor][step]` without traced suns.
fn behind_windows(
    context: &Context<'_>,
    made: &Made<'_>,
    daylight: Daylight<'_>,
    windows: &[usize],
    states: &[Vec<Shown<'_>>],
) -> Result<Vec<Matrix<f32>>> {
    let (inputs, light, multiplier) = (context.inputs, made.at_sensors, made.multiplier);
    let differences = inputs.differences();
    let (total, direct) = (made.sampled.view.total(), made.sampled.view.mean_replaced());
    let sun = made.skies.sun.as_ref().filter(|_| states.iter().flatten().any(|s| s.is_sunny));
    let before = |d: &Matrix<f32>, sky: &Matrix<f32>| {
        let sky = Factor { name: "S".into(), matrix: select_columns(sky, &light.hours) };
        product(multiplier, vec![Factor { name: "D".into(), matrix: d.clone() }, sky], None)
    };
    let hours = light.hours.len();
    // Rows: the light before each window, or that and it without the sun.
    let mut right = Vec::new();
    for &window in windows {
        let all = before(&daylight.total[window], &made.skies.whole)?;
        right.extend(match sun {
            Some(sun) => without_sun(all, &before(&daylight.direct[window], sun)?, differences).into_data(),
            None => all.into_data(),
        });
    }
    let rows = right.len() / (3 * hours).max(1);
    let right = Matrix::from_data(rows, hours, 3, right)?;
    let first_bin = |window: usize| inputs.windows[..window].iter().map(ProjectWindow::bins).sum::<usize>();
    let columns = |of: &Matrix<f32>, window: usize| {
        let bins: Vec<usize> = (first_bin(window)..first_bin(window) + inputs.windows[window].bins()).collect();
        select_columns(of, &bins)
    };
    let views: Vec<(Matrix<f32>, Matrix<f32>)> = windows.iter().map(|w| (columns(&total, *w), columns(&direct, *w))).collect();
    let sensors = total.rows();
    let mut left = Vec::with_capacity(states.len() * sensors * rows * 3);
    for shown in states {
        // Of each window `[sensor][bin before it]`, by halves if the sun is taken out.
        let mut parts: Vec<Matrix<f64>> = Vec::new();
        for ((view, seen), shown) in views.iter().zip(shown) {
            let through = |v: &Matrix<f32>| pass_back(v, shown.transmission);
            match (sun, shown.is_sunny) {
                (None, _) => parts.push(through(view)),
                (Some(_), false) => parts.extend([through(view), Matrix::zeros(sensors, view.cols(), 3)]),
                (Some(_), true) => {
                    let rest = view.data().iter().zip(seen.data()).map(|(t, d)| differences.of(*t, *d)).collect();
                    parts.extend([through(&Matrix::from_data(sensors, view.cols(), 3, rest)?), through(seen)]);
                }
            }
        }
        for sensor in 0..sensors {
            parts.iter().for_each(|part| left.extend(part.row(sensor).iter().map(|v| *v as f32)));
        }
    }
    let left = Matrix::from_data(states.len() * sensors, rows, 3, left)?;
    let lux = illuminance(multiplier, &left, &right)?;
    let of_state = |data: &[f32]| Ok(light.over_the_year(&Matrix::from_data(sensors, hours, 1, data.to_vec())?));
    if lux.data().is_empty() {
        return Ok(vec![Matrix::zeros(sensors, light.all_hours, 1); states.len()]);
    }
    lux.data().chunks(sensors * hours).map(of_state).collect()
}

/// V·T of a window, part by part.
fn pass_back(view: &Matrix<f32>, transmission: &Matrix<f64>) -> Matrix<f64> {
    let bins = transmission.rows();
    if view.cols() == bins {
        return multiply(view, transmission);
    }
    let mut all = Matrix::zeros(view.rows(), view.cols(), 3);
    for first in (0..view.cols()).step_by(bins.max(1)) {
        let part = multiply(&select_columns(view, &(first..first + bins).collect::<Vec<_>>()), transmission);
        for row in 0..view.rows() {
            for bin in 0..bins {
                all.at_mut(row, first + bin).copy_from_slice(part.at(row, bin));
            }
        }
    }
    all
}

/// Adds what the suns send.
fn with_suns(mut lux: Matrix<f32>, part: Option<(SunMatrix, &SunSet)>) -> LightOfState {
    let Some((matrix, suns)) = part else { return LightOfState { lux, sun: None } };
    let light = |of: &Matrix<f32>| {
        let mut lux = Matrix::zeros(of.rows(), suns.hours.len(), 1);
        lux.data_mut().par_chunks_mut(suns.hours.len().max(1)).enumerate().for_each(|(sensor, row)| {
            for (value, hour) in row.iter_mut().zip(&suns.hours) {
                *value = hour.map_or(0.0, |(sun, radiance)| (luminous(of.at(sensor, sun)) * radiance) as f32);
            }
        });
        lux
    };
    lux.data_mut().iter_mut().zip(light(&matrix.total).data()).for_each(|(lux, sun)| *lux = (*lux + sun).max(0.0));
    LightOfState { lux, sun: Some(light(&matrix.direct)) }
}

/// Writes the light of all states: `illuminance/states/GROUP/STATE/SENSORS.mtx`, and `SENSORS_direct.mtx` with what of it
/// comes directly from traced suns; that of windows without states into `illuminance/states`. `known`: where it was needed
/// before.
///
/// # Errors
/// As [`each_state`].
pub(crate) fn write(
    context: &Context<'_>,
    made: &Made<'_>,
    daylight: Daylight<'_>,
    known: Option<StateLight>,
    ledger: &mut Ledger,
) -> Result<()> {
    let inputs = context.inputs;
    context.store.remove_states();
    if inputs.sensors.is_empty() || inputs.facade.groups().iter().all(|g| g.states.len() < 2) {
        return Ok(());
    }
    match known {
        Some(all) => {
            for (group, states) in all.groups.into_iter().enumerate() {
                for (state, light) in states.into_iter().enumerate() {
                    write_state(context, Some((group, state as State)), &light)?;
                }
            }
            all.rest.iter().try_for_each(|light| write_state(context, None, light))?;
        }
        None => {
            let clock = Instant::now();
            context.progress.begin("Cds of states");
            let statistics = each_state(context, made, daylight, &mut |whose, light| write_state(context, whose, &light))?;
            ledger.count(statistics, clock);
        }
    }
    context.progress.begin("light of states");
    Ok(())
}

fn write_state(context: &Context<'_>, whose: Whose, light: &LightOfState) -> Result<()> {
    let (inputs, unit) = (context.inputs, context.project.output.quantity.unit());
    let named = whose.map(|(group, state)| {
        let group = &inputs.facade.groups()[group];
        (group.name.as_str(), group.states[usize::from(state)].as_str())
    });
    let of = named.map_or_else(|| "windows without states".to_string(), |(group, state)| format!("windows '{group}' in state '{state}'"));
    let folder = context.store.states_folder(named)?;
    for (part, suffix, what) in [(Some(&light.lux), "", "light"), (light.sun.as_ref(), "_direct", "direct sunlight")] {
        let Some(part) = part else { continue };
        for (sensors, rows) in inputs.sensors.iter().zip(split(part, &inputs.sensors)) {
            let about = format!("{what} at {} by {of} in {unit}, rows sensors, columns time steps", sensors.name);
            write_stored(&folder.join(format!("{}{suffix}.mtx", sensors.name)), &rows, &about)?;
        }
    }
    Ok(())
}
