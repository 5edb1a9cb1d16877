//! The five-phase method: `I = V·T·D·S − Vd·T·Dd·Sds + Cds·Ssun`.
//!
//! Of windows with a shade the direct sun is taken out of the three-phase product (Vd·T·Dd·Sds: what
//! comes straight from the sun's patches through the window to the receiver) and put back in sharply
//! (Cds·Ssun: the sun traced through the shade's real geometry). Vd and Dd come from the same rays as
//! V and D and are never larger, so the first two terms are evaluated together as
//! `V·T·D·Ssky + (V·T·D − Vd·T·Dd)·Sds` with `S = Ssky + Sds`: no cancellation, nothing negative.
//! Windows without shade stay as in three phases.

use super::fingerprint::Fingerprint;
use super::import;
use super::inputs::{Inputs, ProjectWindow, SensorGroup};
use super::multiply;
use super::presets::{pane_options, sun_options};
use super::project::Project;
use super::results::{self, Addition};
use super::run::split;
use super::shade::{self, Shade, black_model};
use super::store::{Store, software};
use super::suns::{SunCensus, SunSet};
use crate::error::{Error, Result, Warnings};
use crate::gpu::Device;
use crate::kernels::product::Multiplier;
use crate::kernels::sun_matrix::geometry::{Openings, SunMatrix, compute};
use crate::kernels::sun_matrix::pane::{self, PaneBsdf};
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::matrix::file::{Format, write_matrix};
use crate::progress::Progress;
use crate::scene::Window;
use crate::scene::points::Sensor;
use crate::sky::{SkyOptions, sky_matrix};
use crate::units::ILLUMINANCE_WEIGHTS;
use glam::DVec3;
use rayon::prelude::*;

/// What the sun phase is computed from.
pub struct Phase<'a> {
    /// Device that traces.
    pub device: &'a Device,
    /// Method and quality.
    pub project: &'a Project,
    /// Scene, windows with their shades, sensors, weather.
    pub inputs: &'a Inputs,
    /// Where results go.
    pub store: &'a Store,
    /// Progress.
    pub progress: &'a dyn Progress,
}

/// The terms of five phases that three have not.
pub struct FivePhase<'a> {
    inputs: &'a Inputs,
    store: &'a Store,
    suns: SunSet,
    matrix: SunMatrix,
    /// Suns whose numbers differ by a multiple of this have scattered errors in common.
    error_sets: usize,
    /// V, Vd, D or Dd were made elsewhere: their noise is not shared, and the difference can be negative.
    imported: bool,
    /// S without the sun's patches, and the sun's patches alone; nothing if there is no sun.
    skies: Option<(Matrix<f32>, Matrix<f32>)>,
    /// T·Dd of windows whose sun is traced, zeros for all others; rows as V's columns.
    transmitted_direct: Matrix<f64>,
    /// Illuminance of Vd·T·Dd·Sds and Cds·Ssun once they are known, `[sensor][hour]`, lx.
    direct_and_sun: std::sync::OnceLock<(Matrix<f32>, Matrix<f32>)>,
}

/// Windows whose sun is traced, with the corners of their shades.
pub fn shaded_windows(inputs: &Inputs) -> Vec<(Window, Vec<DVec3>)> {
    inputs.windows.iter().filter_map(|w| Some((w.window.clone(), w.shade.as_ref()?.corners()))).collect()
}

/// Windows whose sun is traced through scattering data.
pub fn pane_windows(inputs: &Inputs) -> Vec<(Window, PaneBsdf)> {
    inputs.windows.iter().filter_map(|w| Some((w.window.clone(), w.pane.clone()?))).collect()
}

/// Windows through which suns are traced, by their shade or their scattering data.
pub fn sunny_windows(inputs: &Inputs) -> impl Iterator<Item = &Window> {
    inputs.windows.iter().filter(|w| is_sunny(w)).map(|w| &w.window)
}

/// The suns of a project.
///
/// # Errors
/// As [`SunSet::new`].
pub fn sun_set(project: &Project, inputs: &Inputs) -> Result<SunSet> {
    // Without windows no sun is taken for unreachable.
    let windows: Vec<Window> = if project.quality.prune { sunny_windows(inputs).cloned().collect() } else { Vec::new() };
    SunSet::new(&inputs.weather, project.method.suns, &windows)
}

/// The shades of all windows.
pub fn shades(inputs: &Inputs) -> impl Iterator<Item = &Shade> {
    inputs.windows.iter().filter_map(|w| w.shade.as_ref())
}

impl<'a> Phase<'a> {
    /// Suns, their matrix (or the one of an earlier run) and the skies with and without sun. Returns
    /// the work done, if any was.
    ///
    /// # Errors
    /// Failures of device and file system, or when stopped.
    pub fn compute(
        &self,
        fingerprint: Fingerprint,
        daylight_direct: &[Matrix<f32>],
        warnings: &mut Warnings,
    ) -> Result<(FivePhase<'a>, Option<TraceStatistics>)> {
        let (project, inputs) = (self.project, self.inputs);
        let suns = sun_set(project, inputs)?;
        shade::warn_of_mirrors(shades(inputs), warnings);
        let (matrix, traced) = self.sun_matrix(fingerprint, &inputs.sensors, &suns)?;
        self.write_suns(&suns)?;
        let statistics = traced.then_some(matrix.statistics);
        let skies = (suns.census.hours > 0.0 || suns.census.hours_below_horizon > 0.0).then(|| self.skies()).transpose()?;
        let transmissions: Vec<&Matrix<f64>> = inputs.windows.iter().map(|w| &w.transmission).collect();
        let transmitted_direct = transmitted_where(inputs, &transmissions, daylight_direct, &is_sunny)?;
        let five = FivePhase {
            inputs,
            store: self.store,
            suns,
            matrix,
            // Through panes all suns share their cells.
            error_sets: if inputs.windows.iter().any(|w| w.pane.is_some()) { 1 } else { sun_options(project).path_sets as usize },
            imported: inputs.windows.iter().any(|w| w.daylight.is_some()) || inputs.sensors.iter().any(|g| g.view.is_some()),
            skies,
            transmitted_direct,
            direct_and_sun: std::sync::OnceLock::new(),
        };
        Ok((five, statistics))
    }

    /// Sun matrix of these sensors, kept per group as `C_GROUP`, or that of an earlier run, and whether
    /// it was traced now. `fingerprint`: what rays can meet.
    ///
    /// # Errors
    /// Failures of device and file system, or when stopped.
    pub fn sun_matrix(&self, mut fingerprint: Fingerprint, groups: &[SensorGroup], suns: &SunSet) -> Result<(SunMatrix, bool)> {
        let (project, inputs) = (self.project, self.inputs);
        let shaded = shaded_windows(inputs);
        let panes = pane_windows(inputs);
        let sensors: Vec<Sensor> = groups.iter().flat_map(|g| &g.sensors).copied().collect();
        let options = sun_options(project);
        fingerprint.add(&sensors).add(&options).add(&suns.suns);
        for (window, corners) in &shaded {
            fingerprint.add(&(&window.triangles, &window.frame)).add(corners);
        }
        for (window, _) in &panes {
            fingerprint.add(&(&window.triangles, &window.frame)).add(&pane_options(project));
        }
        add_scattering_data(project, &mut fingerprint)?;
        for shade in shades(inputs) {
            fingerprint.add(&shade.scene.materials).add(&shade.scene.triangles.iter().map(|t| t.material).collect::<Vec<_>>());
        }
        let files = groups.iter().map(|g| (g.name.as_str(), g.sun.as_deref(), g.sensors.len()));
        if let Some(given) = import::sun_matrices(files, suns)? {
            self.keep(&given, groups, *Fingerprint::new("C imported").add(&given.total.data()))?;
            self.write_suns(suns)?;
            return Ok((given, false));
        }
        if let Some(matrix) = self.kept(fingerprint, groups, suns.suns.len()) {
            return Ok((matrix, false));
        }
        let scene = black_model(&inputs.scene, shades(inputs));
        let mut matrix = if shaded.is_empty() {
            SunMatrix::zeros(sensors.len(), suns.suns.len())
        } else {
            compute(self.device, &scene, Openings::Shaded(&shaded), &sensors, &suns.suns, &options, self.progress)?
        };
        if !panes.is_empty() && !suns.suns.is_empty() && !sensors.is_empty() {
            let through = pane::compute(self.device, &scene, &panes, &sensors, &suns.suns, &pane_options(project), self.progress)?;
            matrix.add(&through.total, &through.standard_error, through.statistics);
        }
        self.keep(&matrix, groups, fingerprint)?;
        Ok((matrix, true))
    }

    fn skies(&self) -> Result<(Matrix<f32>, Matrix<f32>)> {
        let options = SkyOptions { subdivision: self.project.method.sky.subdivision(), ..SkyOptions::default() };
        let weather = &self.inputs.weather;
        let sky = sky_matrix(weather, &SkyOptions { sun: false, ..options.clone() }, self.progress)?;
        let options = SkyOptions { sky: false, ..options };
        let sun = sky_matrix(weather, &options, self.progress)?;
        let inputs = *Fingerprint::new("Sds").add(weather).add(&options);
        self.store.save("Sds", &sun, inputs, "sky matrix of the sun alone, as gendaymtx -d, rows patches, columns hours")?;
        Ok((sky, sun))
    }

    const PARTS: [&'static str; 4] = ["", "_direct", "_direct_standard_error", "_scattered_standard_error"];

    fn keep(&self, matrix: &SunMatrix, groups: &[SensorGroup], inputs: Fingerprint) -> Result<()> {
        let all = [&matrix.total, &matrix.direct, &matrix.direct_error, &matrix.scattered_error];
        for (suffix, part) in Self::PARTS.iter().zip(all) {
            for (group, rows) in groups.iter().zip(split(part, groups)) {
                let about = "sun matrix, rows sensors, columns the suns of suns.rad";
                self.store.save(&format!("C_{}{suffix}", group.name), &rows, inputs, about)?;
            }
        }
        Ok(())
    }

    fn kept(&self, inputs: Fingerprint, groups: &[SensorGroup], suns: usize) -> Option<SunMatrix> {
        let together = |suffix: &str| {
            let (mut data, mut rows) = (Vec::new(), 0);
            for group in groups {
                let part = self.store.load(&format!("C_{}{suffix}", group.name), inputs, (group.sensors.len(), suns, 3))?;
                rows += part.rows();
                data.extend(part.into_data());
            }
            Matrix::from_data(rows, suns, 3, data).ok()
        };
        let [total, direct, direct_error, scattered_error] = Self::PARTS.map(together);
        let statistics = TraceStatistics::default();
        Some(SunMatrix { total: total?, direct: direct?, direct_error: direct_error?, scattered_error: scattered_error?, statistics })
    }

    /// The suns in the order of Cds's columns, as a scene file for `rcontrib -M`.
    fn write_suns(&self, suns: &SunSet) -> Result<()> {
        let path = self.store.suns_path();
        crate::files::write_atomically(&path, |out| {
            for (column, sun) in suns.columns.iter().zip(&suns.suns) {
                let (d, angle) = (sun.direction, 2.0 * sun.radius.to_degrees());
                writeln!(out, "void light sol{column} 0 0 3 1 1 1\nsol{column} source sun{column} 0 0 4 {} {} {} {angle}", d.x, d.y, d.z)
                    .map_err(|e| Error::io(&path, &e))?;
            }
            Ok(())
        })
    }
}

/// Adds the files of scattering data that suns are traced through.
///
/// # Errors
/// A file that cannot be read any more.
pub fn add_scattering_data(project: &Project, fingerprint: &mut Fingerprint) -> Result<()> {
    for file in project.windows.iter().filter_map(|w| w.tensor_tree.as_deref()) {
        fingerprint.add(&crate::files::read(file)?);
    }
    Ok(())
}

/// Whether a window's sun is traced.
pub fn is_sunny(window: &ProjectWindow) -> bool {
    window.shade.is_some() || window.pane.is_some()
}

/// T·Dd of the windows that count, zeros for all others; rows as V's columns.
///
/// # Errors
/// Matrices of different skies.
pub fn transmitted_where(
    inputs: &Inputs,
    transmissions: &[&Matrix<f64>],
    daylight_direct: &[Matrix<f32>],
    counts: &dyn Fn(&ProjectWindow) -> bool,
) -> Result<Matrix<f64>> {
    let columns = daylight_direct.first().map_or(0, Matrix::cols);
    let mut data = Vec::new();
    for ((window, transmission), d) in inputs.windows.iter().zip(transmissions).zip(daylight_direct) {
        if counts(window) {
            data.extend(results::multiply(transmission, d).into_data());
        } else {
            data.resize(data.len() + window.window.basis.len() * columns * 3, 0.0);
        }
    }
    Matrix::from_data(inputs.bins(), columns, 3, data)
}

/// Right factor of V − Vd beside Vd: V·TDS − Vd·TDdSds = (V − Vd)·TDS + Vd·(TDS − TDdSds), nothing
/// negative. `three` is TDS, `sun` TDdSds, both `[bin][hour]`.
///
/// # Panics
/// If their shapes differ.
pub fn without_sun_patches(three: &Matrix<f32>, sun: &Matrix<f32>) -> Matrix<f32> {
    assert_eq!((three.rows(), three.cols()), (sun.rows(), sun.cols()), "coefficients of the same bins and hours");
    let rest = three.data().iter().zip(sun.data()).map(|(all, sun)| (all - sun).max(0.0));
    let data = three.data().iter().copied().chain(rest).collect();
    Matrix::from_data(2 * three.rows(), three.cols(), 3, data).expect("twice the rows")
}

/// Luminous value of an RGB value.
pub fn luminous(v: &[f32]) -> f64 {
    v.iter().zip(ILLUMINANCE_WEIGHTS).map(|(v, w)| f64::from(*v) * w).sum()
}

impl FivePhase<'_> {
    /// The suns and their hours.
    pub fn suns(&self) -> &SunSet {
        &self.suns
    }

    /// T·Dd·Sds of some hours, `[bin][hour]`, from T·Dd (see [`transmitted_where`]): what comes straight
    /// from the sun's patches to the windows whose sun is traced. Nothing if there is no sun.
    ///
    /// # Errors
    /// Failures of the multiplier's device.
    pub fn sun_at_windows(
        &self,
        multiplier: &dyn Multiplier,
        transmitted_direct: &Matrix<f64>,
        hours: &[usize],
    ) -> Result<Option<Matrix<f32>>> {
        let Some((_, sun_only)) = &self.skies else { return Ok(None) };
        let factors = vec![
            multiply::Factor { name: "T·Dd".into(), matrix: transmitted_direct.map(|v| v as f32) },
            multiply::Factor { name: "Sds".into(), matrix: multiply::select_columns(sun_only, hours) },
        ];
        multiply::product(multiplier, factors, None).map(Some)
    }

    /// S without the sun, and Sds alone; nothing if there is no sun.
    pub fn skies(&self) -> Option<&(Matrix<f32>, Matrix<f32>)> {
        self.skies.as_ref()
    }

    /// Suns traced and left out.
    pub fn census(&self) -> &SunCensus {
        &self.suns.census
    }

    /// Illuminance in lux, `[sensor][hour]`, from the coefficients V·T·D and the straight view matrix
    /// Vd. Writes the three terms into files.
    ///
    /// # Errors
    /// Failures of the multiplier's device and of the file system.
    pub fn illuminance(
        &self,
        multiplier: &dyn Multiplier,
        coefficients: Matrix<f64>,
        view_direct: &Matrix<f32>,
        sky: &Matrix<f32>,
    ) -> Result<Matrix<f32>> {
        let three_phase = results::illuminance(multiplier, coefficients.clone(), sky)?;
        let Some((sky_only, sun_only)) = &self.skies else {
            // No sun at all: exactly the three phases.
            let none = Matrix::zeros(three_phase.rows(), three_phase.cols(), 1);
            self.write_terms([&three_phase, &none, &none])?;
            return Ok(three_phase);
        };
        let direct = results::multiply(view_direct, &self.transmitted_direct);
        // Rounding aside Vd·T·Dd never exceeds V·T·D, unless they were made apart.
        let least = if self.imported { f64::NEG_INFINITY } else { 0.0 };
        let rest: Vec<f64> = coefficients.data().iter().zip(direct.data()).map(|(all, direct)| (all - direct).max(least)).collect();
        let rest = Matrix::from_data(direct.rows(), direct.cols(), 3, rest)?;
        let direct = results::illuminance(multiplier, direct, sun_only)?;
        let sun = self.sun_illuminance();
        let mut lux = results::illuminance(multiplier, coefficients, sky_only)?;
        let rest = results::illuminance(multiplier, rest, sun_only)?;
        lux.data_mut()
            .par_iter_mut()
            .zip(rest.data().par_iter().zip(sun.data()))
            .for_each(|(lux, (rest, sun))| *lux = (*lux + rest + sun).max(0.0));
        self.write_terms([&three_phase, &direct, &sun])?;
        let _ = self.direct_and_sun.set((direct, sun));
        Ok(lux)
    }

    /// Cds·Ssun, lux `[sensor][hour]`: one product per hour with sun.
    fn sun_illuminance(&self) -> Matrix<f32> {
        let hours = &self.suns.hours;
        let mut lux = Matrix::zeros(self.matrix.total.rows(), hours.len(), 1);
        if hours.is_empty() {
            return lux;
        }
        lux.data_mut().par_chunks_mut(hours.len()).enumerate().for_each(|(sensor, row)| {
            for (value, hour) in row.iter_mut().zip(hours) {
                if let Some((sun, radiance)) = hour {
                    *value = (luminous(self.matrix.total.at(sensor, *sun)) * radiance) as f32;
                }
            }
        });
        lux
    }

    fn write_terms(&self, terms: [&Matrix<f32>; 3]) -> Result<()> {
        let about = [("three_phase", "V·T·D·S"), ("direct", "Vd·T·Dd·Sds"), ("sun", "Cds·Ssun")];
        for ((name, formula), term) in about.iter().zip(terms) {
            for (group, part) in self.inputs.sensors.iter().zip(split(term, &self.inputs.sensors)) {
                let header = [software(), format!("CONTENT={formula} of {} in lux, rows sensors, columns hours", group.name)];
                write_matrix(Some(&self.store.term_path(&group.name, name)?), &part, Format::Float, &header)?;
            }
        }
        Ok(())
    }

    /// The two new terms and their variance. Errors of different suns are independent in the straight
    /// part, one and the same in the scattered one for suns of one set. The direct term needs no error of its own: V's and
    /// D's, multiplied with the whole sky, bound that of the difference of the first two terms, which
    /// share their rays.
    pub fn addition(&self) -> Box<Addition<'_>> {
        // Over the year a sun counts with its radiance of all hours.
        let mut yearly = vec![0.0; self.suns.suns.len()];
        for (sun, radiance) in self.suns.hours.iter().flatten() {
            yearly[*sun] += radiance;
        }
        Box::new(move |sensor, hour| {
            let Some((direct, sun)) = self.direct_and_sun.get() else { return (0.0, 0.0) };
            let errors = |s: usize| (luminous(self.matrix.direct_error.at(sensor, s)), luminous(self.matrix.scattered_error.at(sensor, s)));
            match hour {
                Some(hour) => {
                    let value = f64::from(sun.at(sensor, hour)[0]) - f64::from(direct.at(sensor, hour)[0]);
                    let variance = self.suns.hours[hour].map_or(0.0, |(s, radiance)| {
                        let (straight, scattered) = errors(s);
                        (straight * radiance).powi(2) + (scattered * radiance).powi(2)
                    });
                    (value, variance)
                }
                None => {
                    let sum = |m: &Matrix<f32>| m.row(sensor).iter().map(|v| f64::from(*v)).sum::<f64>();
                    let (mut straight, mut scattered) = (0.0, vec![0.0; self.error_sets]);
                    for (s, radiance) in yearly.iter().enumerate() {
                        let (a, b) = errors(s);
                        straight += (a * radiance).powi(2);
                        scattered[s % self.error_sets] += b * radiance;
                    }
                    (sum(sun) - sum(direct), straight + scattered.iter().map(|b| b * b).sum::<f64>())
                }
            }
        })
    }
}
