//! What the windows of a result folder let in at any step, as computed or on the way to a second state.

use super::arrays::Year;
use crate::error::{Error, Result};
use crate::kernels::product::Multiplier;
use crate::matrix::Matrix;
use crate::simulate::inputs::Differences;
use crate::simulate::light::{Light, Skies, WindowLight};
use crate::simulate::results::illuminance::illuminance;
use crate::simulate::store::read_stored;
use std::borrow::Cow;
use std::sync::Arc;

/// T, D and Dd of all windows, and the skies of the year.
pub struct Facade {
    windows: Vec<Window>,
    skies: Skies,
    differences: Differences,
}

struct Window {
    transmission: Matrix<f64>,
    /// D, rows the bins of its parts, one part after the other.
    daylight: Matrix<f32>,
    /// Dd, where its sun is traced.
    direct: Option<Matrix<f32>>,
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
            let (t, daylight) = (read(&format!("T_{name}"))?, read(&format!("D_{name}"))?);
            let direct = window.sun_is_traced.then(|| read(&format!("D_{name}_direct"))).transpose()?;
            let shape = |m: &Matrix<f32>| (m.rows(), m.cols(), m.components());
            let of_parts = daylight.rows() > 0 && daylight.rows().is_multiple_of(t.cols().max(1)) && t.rows() == t.cols();
            let wanted = (daylight.rows(), whole.rows(), 3);
            let fits = of_parts && shape(&daylight) == wanted && direct.as_ref().is_none_or(|d| shape(d) == wanted);
            if !fits || t.components() != 3 || whole.components() != 3 {
                return Err(Error::new(format!("the matrices of window '{name}' do not fit each other"))
                    .file(year.folder())
                    .help("run the project again"));
            }
            windows.push(Window { transmission: t.map(f64::from), daylight, direct });
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

    fn mixed<'a>(&'a self, state: &FacadeState) -> Vec<Mixed<'a>> {
        let of = |(i, window): (usize, &'a Window)| -> Mixed<'a> {
            let (first, fraction) = (&window.transmission, state.fraction(i));
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

    fn lights<'a>(&'a self, mixed: &'a [Mixed<'_>]) -> Vec<WindowLight<'a>> {
        let parts = self.windows.iter().zip(mixed);
        parts
            .map(|(window, (all, first))| WindowLight {
                all: (&**all, &window.daylight),
                sun: window.direct.as_ref().map(|direct| (&**first, direct)),
            })
            .collect()
    }

    /// What the windows send into the room at a step.
    ///
    /// # Errors
    /// Matrices of different skies.
    ///
    /// # Panics
    /// If the year has no such step.
    pub fn light(&self, step: usize, state: &FacadeState) -> Result<Light> {
        Light::of_hour(&self.lights(&self.mixed(state)), step, &self.skies, self.differences)
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
        let light = Light::new(&self.lights(&self.mixed(state)), multiplier, &self.skies, self.differences)?;
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
