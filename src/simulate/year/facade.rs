//! What the windows of a result folder let in at any step, as computed or on the way to a second state.

use super::arrays::Year;
use crate::error::{Error, Result};
use crate::kernels::product::Multiplier;
use crate::matrix::Matrix;
use crate::simulate::inputs::Differences;
use crate::simulate::light::{Light, Skies, WindowLight};
use crate::simulate::multiply::{lit_columns, put_columns, select_columns};
use crate::simulate::results::illuminance::illuminance;
use crate::simulate::store::read_stored;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// T, D and Dd of all windows, each in the state that it is in, and the skies of the year.
pub struct Facade {
    windows: Vec<Window>,
    skies: Skies,
    differences: Differences,
}

struct Window {
    /// T of each state that it is ever in, and whether its sun is traced then.
    states: Vec<(Matrix<f64>, bool)>,
    /// Of each time step the number of its state among them; empty if there is one.
    of_step: Vec<usize>,
    /// D, rows the bins of its parts, one part after the other.
    daylight: Matrix<f32>,
    /// Dd, where its sun is traced in any of them.
    direct: Option<Matrix<f32>>,
}

impl Window {
    fn state(&self, step: usize) -> usize {
        self.of_step.get(step).copied().unwrap_or(0)
    }
}

/// The states of a window that moves: names of those that it is ever in, and which of them holds in each time step.
fn moves(year: &Year, group: &str) -> Result<Option<(Vec<String>, Vec<usize>)>> {
    let Some(summary) = year.summary.groups.iter().find(|g| g.name == group) else { return Ok(None) };
    let used: Vec<usize> = (0..summary.states.len()).filter(|i| summary.states[*i].hours > 0.0).collect();
    if used.len() < 2 {
        return Ok(None);
    }
    let own = |state: usize| used.iter().position(|u| *u == state).unwrap_or(0);
    let of_step = year.states_of(group)?.into_iter().map(own).collect();
    Ok(Some((used.iter().map(|i| summary.states[*i].name.clone()).collect(), of_step)))
}

/// A state of the façade: each window as computed, in a second state, or between the two. The sun of
/// the second one comes from the patches of the sky: nothing stands before it that suns were traced through.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FacadeState {
    /// T of the second state of each window that has one; shorter lists have none.
    pub second: Arc<Vec<Option<Matrix<f64>>>>,
    /// How far each window is on its way to it, 0…1.
    pub fractions: Vec<f64>,
}

impl FacadeState {
    /// How much of a window is in its second state.
    pub fn fraction(&self, window: usize) -> f64 {
        let has_second = self.second.get(window).is_some_and(Option::is_some);
        self.fractions.get(window).filter(|_| has_second).map_or(0.0, |f| f.clamp(0.0, 1.0))
    }
}

/// A window in a state: T of all light, and the share of it whose sun is traced.
type Mixed<'a> = (Cow<'a, Matrix<f64>>, Cow<'a, Matrix<f64>>);

impl Facade {
    /// Reads the matrices of all windows and the skies.
    ///
    /// # Errors
    /// Files that cannot be read or do not fit each other.
    pub fn read(year: &Year) -> Result<Self> {
        let read = |name: &str| read_stored(&year.matrix(name)).map(|f| f.matrix);
        let whole = read("S")?;
        let mut windows = Vec::new();
        for window in &year.summary.windows {
            let name = &window.name;
            let daylight = read(&format!("D_{name}"))?;
            let moving = window.group.as_ref().map(|group| moves(year, group)).transpose()?.flatten();
            let (names, of_step) = match moving {
                None => (vec![(format!("T_{name}"), window.sun_is_traced)], Vec::new()),
                Some((states, of_step)) => {
                    let sunny = |state: &String| window.sun_is_traced && !window.states_without_sun.contains(state);
                    (states.iter().map(|state| (format!("T_{name}@{state}"), sunny(state))).collect(), of_step)
                }
            };
            let states = names.iter().map(|(name, sunny)| Ok((read(name)?, *sunny))).collect::<Result<Vec<_>>>()?;
            let direct = window.sun_is_traced.then(|| read(&format!("D_{name}_direct"))).transpose()?;
            let shape = |m: &Matrix<f32>| (m.rows(), m.cols(), m.components());
            let of_parts = |(t, _): &(Matrix<f32>, bool)| {
                daylight.rows() > 0 && daylight.rows().is_multiple_of(t.cols().max(1)) && t.rows() == t.cols() && t.components() == 3
            };
            let wanted = (daylight.rows(), whole.rows(), 3);
            let fits = shape(&daylight) == wanted && direct.as_ref().is_none_or(|d| shape(d) == wanted);
            if !fits || !states.iter().all(of_parts) || whole.components() != 3 {
                return Err(Error::new(format!("the matrices of window '{name}' do not fit each other"))
                    .file(year.folder())
                    .help("run the project again"));
            }
            let states = states.into_iter().map(|(t, sunny)| (t.map(f64::from), sunny)).collect();
            windows.push(Window { states, of_step, daylight, direct });
        }
        let traced = windows.iter().any(|w| w.direct.is_some());
        let sun = if traced { Some(read("Sds")?).filter(|sun| sun.data().iter().any(|v| *v != 0.0)) } else { None };
        let differences = if year.summary.matrices_are_given { Differences::Noisy } else { Differences::NeverNegative };
        Ok(Self { windows, skies: Skies { whole, sun }, differences })
    }

    /// Bins of all windows: columns of the view matrices.
    pub fn bins(&self) -> usize {
        self.windows.iter().map(|w| w.daylight.rows()).sum()
    }

    /// Whether suns are traced, so that the light is split into what they replace and the rest.
    pub fn has_suns(&self) -> bool {
        self.skies.sun.is_some()
    }

    /// How much of the traced suns' light there is: the mean of the windows that have it.
    pub(crate) fn sun_share(&self, state: &FacadeState) -> f64 {
        let sunny = || (0..self.windows.len()).filter(|&i| self.windows[i].direct.is_some());
        sunny().map(|i| 1.0 - state.fraction(i)).sum::<f64>() / sunny().count().max(1) as f64
    }

    /// Each window in its own state, by number, on its way to the second.
    fn mixed<'a>(&'a self, own: &[usize], state: &FacadeState) -> Vec<Mixed<'a>> {
        let of = |(i, window): (usize, &'a Window)| -> Mixed<'a> {
            let (first, fraction) = (&window.states[own[i]].0, state.fraction(i));
            match state.second.get(i).and_then(Option::as_ref) {
                Some(second) if fraction > 0.0 && second.data().len() == first.data().len() => {
                    let mixed = first.data().iter().zip(second.data()).map(|(a, b)| a + (b - a) * fraction).collect();
                    let mixed = Matrix::from_data(first.rows(), first.cols(), 3, mixed).expect("a matrix of the same shape");
                    (Cow::Owned(mixed), Cow::Owned(first.map(|v| v * (1.0 - fraction))))
                }
                _ => (Cow::Borrowed(first), Cow::Borrowed(first)),
            }
        };
        self.windows.iter().enumerate().map(of).collect()
    }

    fn lights<'a>(&'a self, own: &[usize], mixed: &'a [Mixed<'_>]) -> Vec<WindowLight<'a>> {
        let parts = self.windows.iter().zip(own).zip(mixed);
        parts
            .map(|((window, own), (all, first))| WindowLight {
                all: (&**all, &window.daylight),
                sun: window.direct.as_ref().filter(|_| window.states[*own].1).map(|direct| (&**first, direct)),
            })
            .collect()
    }

    /// Number of the state of each window at a step.
    fn states_at(&self, step: usize) -> Vec<usize> {
        self.windows.iter().map(|w| w.state(step)).collect()
    }

    /// What the windows send into the room in all hours.
    fn year(&self, state: &FacadeState, multiplier: &dyn Multiplier) -> Result<Light> {
        let steps = self.skies.whole.cols();
        let mut together: BTreeMap<Vec<usize>, Vec<usize>> = BTreeMap::new();
        (0..steps).for_each(|step| together.entry(self.states_at(step)).or_default().push(step));
        let light =
            |own: &[usize], skies: &Skies| Light::new(&self.lights(own, &self.mixed(own, state)), multiplier, skies, self.differences);
        if together.len() < 2 {
            return light(&self.states_at(0), &self.skies);
        }
        let hours = lit_columns(&self.skies.whole);
        let bins = self.bins();
        let mut all =
            Light { right: Matrix::zeros(if self.has_suns() { 2 * bins } else { bins }, hours.len(), 3), bins, hours, all_hours: steps };
        for (own, steps) in together {
            let of = |sky: &Matrix<f32>| select_columns(sky, &steps);
            let mut part = light(&own, &Skies { whole: of(&self.skies.whole), sun: self.skies.sun.as_ref().map(of) })?;
            if self.has_suns() {
                part.split();
            }
            let place = |lit: &usize| all.hours.binary_search(&steps[*lit]).expect("lit among these steps, lit in the year");
            let columns: Vec<usize> = part.hours.iter().map(place).collect();
            put_columns(&mut all.right, 0, &columns, &part.right, 0..part.right.rows());
        }
        Ok(all)
    }

    /// What the windows send into the room at a step.
    ///
    /// # Errors
    /// Matrices of different skies.
    ///
    /// # Panics
    /// If the year has no such step.
    pub fn light(&self, step: usize, state: &FacadeState) -> Result<Light> {
        let own = self.states_at(step);
        Light::of_hour(&self.lights(&own, &self.mixed(&own, state)), step, &self.skies, self.differences)
    }

    /// Illuminance `[sensor][step]` of a group of sensors, lx.
    ///
    /// # Errors
    /// Files that cannot be read or do not fit.
    pub fn illuminance(&self, year: &Year, group: &str, state: &FacadeState, multiplier: &dyn Multiplier) -> Result<Matrix<f32>> {
        if year.matrix(&format!("DC_{group}_direct")).is_file() && !year.matrix(&format!("V_{group}")).is_file() {
            return Err(Error::new(format!("the light at '{group}' was followed through clear glass as it is, not by bins of windows"))
                .file(year.folder())
                .help("for states of the façade run the project with phases = 5"));
        }
        let light = self.year(state, multiplier)?;
        let total = read_stored(&year.matrix(&format!("V_{group}")))?.matrix;
        if !light.is_split() {
            return Ok(light.over_the_year(&illuminance(multiplier, &total, &light.right)?));
        }
        let direct = read_stored(&year.matrix(&format!("V_{group}_direct")))?.matrix;
        let sun = read_stored(&year.folder().join(format!("illuminance/terms/{group}_sun.mtx")))?.matrix;
        let receivers = light.receivers(&total, &direct, self.differences);
        let mut lux = light.over_the_year(&illuminance(multiplier, &receivers, &light.right)?);
        if (sun.rows(), sun.cols()) != (lux.rows(), lux.cols()) {
            return Err(Error::new(format!("the suns' light at '{group}' does not fit its view matrix"))
                .file(year.folder())
                .help("run the project again"));
        }
        let share = self.sun_share(state) as f32;
        lux.data_mut().iter_mut().zip(sun.data()).for_each(|(lux, sun)| *lux = (*lux + share * sun).max(0.0));
        Ok(lux)
    }
}
