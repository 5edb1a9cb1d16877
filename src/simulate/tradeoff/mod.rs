//! Error against time: one setting after the other is changed, and the results are compared with a
//! reference that nothing is saved on.
//!
//! | column | meaning |
//! |---|---|
//! | `seconds` | wall clock of S, V, D, Cds and their product, without reading and writing |
//! | `illuminance_error` | distance of hourly illuminances from the reference's at a sensor, root mean square over that of the reference; median over the sensors |
//! | `annual_error` | distance of the year's sum, relative; median over the sensors |
//! | `glare_seconds` | S, D, the pictures' V, and the glare of all hours |
//! | `dgp_error` | distance of DGP in lit hours, root mean square over all views |

mod knobs;
mod parts;
mod report;

pub use knobs::{Knob, knobs};
pub use report::{Choice, front, recommended, write};

use self::knobs::{finest, rebase};
use self::parts::{Named, Wide};
use crate::bins::ReinhartSky;
use crate::error::{Error, Result, Warnings};
use crate::files::journal::Journal;
use crate::gpu::Device;
use crate::kernels::product::Multiplier;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::progress::{Progress, Silent};
use crate::simulate::inputs::Inputs;
use crate::simulate::inputs::parts::divide_anew;
use crate::simulate::light::multiply;
use crate::simulate::project::method::Phases;
use crate::simulate::project::method::SunScheme;
use crate::simulate::project::{Parts, Project};
use crate::simulate::results::illuminance::illuminance as lux_of;
use crate::simulate::run::run;
use crate::simulate::sampling::rounds::Part;
use crate::simulate::store::fingerprint::Fingerprint;
use crate::sky::{SkyOptions, sky_matrix};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the reference, and of its folder.
const REFERENCE: &str = "reference";

/// What is asked of a setting that is recommended.
pub const TARGET: f64 = 0.02;
/// DGP's, absolute: a tenth of the distance between two classes of glare.
pub const DGP_TARGET: f64 = 0.005;

/// One setting's time and error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// `lucarne` or another program.
    pub program: String,
    /// What was changed.
    pub knob: String,
    /// To what.
    pub value: String,
    /// Seconds for illuminance, and its errors; nothing where the setting does not touch it.
    pub illuminance: Option<Measured>,
    /// Seconds for glare, and the error of DGP.
    pub glare: Option<(f64, f64)>,
}

/// Time and errors of illuminance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Seconds.
    pub seconds: f64,
    /// Hourly error.
    pub hourly: f64,
    /// Annual error.
    pub annual: f64,
}

/// What a run came to.
struct Outcome {
    lux: Matrix<f32>,
    dgp: Option<Matrix<f32>>,
    seconds: f64,
    glare_seconds: f64,
}

/// A project, and the device that runs it.
pub struct Sweep<'a> {
    /// Where the kernels run.
    pub device: &'a Device,
    /// The project as it is; its own setting is the middle of the sweep.
    pub project: &'a Project,
    /// Its files.
    pub inputs: &'a Inputs,
    /// Where everything is written.
    pub folder: &'a Path,
    /// Settings to try.
    pub knobs: Vec<Knob>,
}

impl Sweep<'_> {
    /// Runs the reference and every setting; `others` are measured against the same reference, given
    /// the reference's illuminance. The files of each run are removed after it. What was measured before a stop is
    /// not measured again: the folder keeps it until all is done.
    ///
    /// # Errors
    /// Failures of a run, of the file system, or when stopped.
    pub fn run(
        &self,
        progress: &dyn Progress,
        warnings: &mut Warnings,
        others: &mut dyn FnMut(&Reference<'_>, &dyn Progress) -> Result<Vec<Point>>,
    ) -> Result<Vec<Point>> {
        self.check()?;
        // Shares of the time, roughly: the reference counts as many.
        const REFERENCE_PARTS: usize = 6;
        let count = self.knobs.len() + REFERENCE_PARTS + 2;
        let kept = Journal::open(&self.folder.join("points.units"), &self.fingerprint().to_string());
        let (project, inputs) = self.reference()?;
        // Nobody measures its time: it goes on where it was stopped.
        let stage = Wide(progress, 0, REFERENCE_PARTS, count);
        let reference = self.outcome(&project, &inputs, &self.folder.join(REFERENCE), &Named(&stage, REFERENCE), warnings)?;
        // The driver compiles shaders when they are first used: not on the first setting's time.
        let (project, inputs) = self.changed(Knob::Samples(1.0 / 64.0))?;
        self.measured_run(&project, &inputs, "warming up", &Wide(progress, REFERENCE_PARTS, 1, count), warnings)?;
        let mut points = Vec::new();
        for (i, &knob) in self.knobs.iter().enumerate() {
            let part = Part::of(progress, REFERENCE_PARTS + 1 + i, count);
            points.extend(remembered(&kept, &format!("{:?}", knob), &mut || Ok(vec![self.point(knob, &reference, &part, warnings)?]))?);
        }
        let project = self.plain()?;
        let shown = Reference { lux: &reference.lux, project: &project };
        points.extend(remembered(&kept, "other programs", &mut || others(&shown, &Part::of(progress, count - 1, count)))?);
        kept.finish();
        gone(&self.folder.join(REFERENCE))?;
        Ok(points)
    }

    /// Settings are judged by illuminance and DGP, under skies that are made as each setting asks.
    fn check(&self) -> Result<()> {
        let fault = |text: &str, field: &str, help: &str| Err(Error::new(text).file(&self.project.file).field(field).help(help));
        if self.project.output.quantity.is_solar() {
            return fault(
                "settings are compared by illuminance, not by irradiance",
                "output.quantity",
                "take 'quantity' out for the comparison",
            );
        }
        if self.inputs.moves() {
            let help = "name one state of each group in [control] for the comparison";
            return fault("settings are compared in one state of the façade, but its windows move", "control", help);
        }
        if self.inputs.weather.given.is_some() {
            let help = "give the weather file that the sky was made of";
            return fault("settings of the sky cannot be compared under a sky made elsewhere", "weather.sky_matrix", help);
        }
        Ok(())
    }

    /// What the points depend on.
    fn fingerprint(&self) -> Fingerprint {
        let mut all = *Fingerprint::new("tradeoff").add(self.project).add_all_of(self.inputs.scene_fingerprint());
        all.add(&self.inputs.weather.records).add(&self.inputs.all_sensors()).add(&self.device.summary().name);
        for window in &self.inputs.windows {
            all.add(&window.transmission.data());
        }
        *all.add(&self.knobs)
    }

    fn point(&self, knob: Knob, reference: &Outcome, progress: &dyn Progress, warnings: &mut Warnings) -> Result<Point> {
        let (project, inputs) = self.changed(knob)?;
        let (name, value) = knob.names();
        let found = self.measured_run(&project, &inputs, &format!("{name} {value}"), progress, warnings)?;
        let measured = (!knob.is_for_pictures() && found.lux.rows() > 0).then(|| {
            let (hourly, annual) = distance(&found.lux, &reference.lux);
            Measured { seconds: found.seconds, hourly, annual }
        });
        let glare = found.dgp.as_ref().zip(reference.dgp.as_ref()).map(|(found_dgp, dgp)| {
            let squares: f64 = found_dgp.data().iter().zip(dgp.data()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            let lit = found.lux.cols().min(dgp.cols()).max(1) as f64 * dgp.rows().max(1) as f64;
            (found.glare_seconds, (squares / lit).sqrt())
        });
        Ok(Point { program: "lucarne".into(), knob: name.into(), value, illuminance: measured, glare })
    }

    /// A run from its beginning, for its time, whose files are removed after it.
    fn measured_run(
        &self,
        project: &Project,
        inputs: &Inputs,
        name: &str,
        progress: &dyn Progress,
        warnings: &mut Warnings,
    ) -> Result<Outcome> {
        let folder = self.folder.join("run");
        gone(&folder)?;
        let found = self.outcome(project, inputs, &folder, &Named(progress, name), warnings);
        gone(&folder)?;
        found
    }

    /// The project with nothing saved on, and with other random numbers.
    fn reference(&self) -> Result<(Project, Inputs)> {
        let mut project = self.plain()?;
        // A third of the noise of the best setting: it adds 6 % to the error that is found.
        let most = self.knobs.iter().map(|k| if let Knob::Samples(scale) = k { *scale } else { 1.0 / 16.0 }).fold(0.25, f64::max);
        project.quality.scale = 8.0 * most;
        project.quality.seed = project.quality.seed.wrapping_add(0x5eed);
        project.method.bounces = None;
        if self.inputs.choice(&project).phases == 5 {
            project.method.take_suns(SunScheme::HOURLY);
        }
        for view in &mut project.views {
            view.resolution = view.resolution.map(|n| n * 2);
        }
        let mut inputs = self.inputs.clone();
        // As fine as the finest that it is compared with.
        if let Some(most) = self.knobs.iter().filter_map(|k| if let Knob::Parts(n) = k { Some(*n) } else { None }).max() {
            divide_anew(&project, &mut inputs, Parts::Number(most))?;
        }
        Ok((project, inputs))
    }

    /// The project at standard quality, without pictures for people.
    fn plain(&self) -> Result<Project> {
        let mut project = self.project.clone();
        project.method.sky = Some(ReinhartSky::new(finest(&project, self.inputs))?);
        let seed = project.quality.seed;
        project.quality = crate::simulate::project::QualitySection { seed, ..Default::default() };
        project.images.hours = crate::simulate::project::views::ImageHours::None;
        if project.glare.is_none() {
            project.views.clear();
        }
        Ok(project)
    }

    fn changed(&self, knob: Knob) -> Result<(Project, Inputs)> {
        let (mut project, mut inputs) = (self.plain()?, self.inputs.clone());
        match knob {
            Knob::Samples(scale) => project.quality.scale = scale,
            Knob::Bounces(n) => project.method.bounces = Some(n),
            Knob::Sky(n, scale) => {
                project.method.sky = Some(ReinhartSky::new(n)?);
                project.quality.scale = scale;
            }
            Knob::Picture(scale) => {
                for view in &mut project.views {
                    view.resolution = view.resolution.map(|n| ((n as f64 * scale) as usize).max(8));
                }
            }
            Knob::ThreePhase => project.method.phases = Phases::Three,
            Knob::Suns(n) => project.method.take_suns(SunScheme::Patches(ReinhartSky::new(n)?)),
            Knob::HourlySuns => project.method.take_suns(SunScheme::HOURLY),
            Knob::Basis(basis) => rebase(&mut inputs, &project, &basis.into())?,
            Knob::Parts(n) => divide_anew(&project, &mut inputs, Parts::Number(n))?,
        }
        Ok((project, inputs))
    }

    fn outcome(
        &self,
        project: &Project,
        inputs: &Inputs,
        folder: &Path,
        progress: &dyn Progress,
        warnings: &mut Warnings,
    ) -> Result<Outcome> {
        // Every run would repeat the project's warnings.
        let mut own = Warnings::new();
        let result = run(self.device, project, inputs, folder, progress, &mut own).and_then(|summary| {
            let mut parts = Vec::new();
            for group in &inputs.sensors {
                parts.extend(read_matrix(&folder.join(format!("illuminance/{}.mtx", group.name)))?.matrix.into_data());
            }
            let hours = inputs.weather.records.len();
            let lux = Matrix::from_data(parts.len() / hours.max(1), hours, 1, parts)?;
            let dgp = match &summary.glare {
                Some(glare) if glare.states == 1 => Some(read_matrix(&folder.join(format!("glare/{}.dgp", glare.method)))?.matrix),
                _ => None,
            };
            let s = summary.seconds;
            let pictured: f64 = summary
                .matrices
                .iter()
                .filter(|m| project.views.iter().any(|v| m.name == format!("V_{}", v.name)))
                .map(|m| m.seconds)
                .sum();
            Ok(Outcome {
                lux,
                dgp,
                seconds: s.sky + s.view + s.daylight + s.suns + s.product,
                glare_seconds: s.sky + s.daylight + pictured + s.glare,
            })
        });
        if warnings.is_empty() {
            own.iter().filter(|w| !w.message().contains("standard error")).for_each(|w| warnings.push(w.clone()));
        }
        result
    }
}

/// Removes a folder, if it is there.
fn gone(folder: &Path) -> Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io(folder, &e)),
        _ => Ok(()),
    }
}

/// Points that an earlier sweep has measured, or those that `measure` gives.
fn remembered(kept: &Journal, name: &str, measure: &mut dyn FnMut() -> Result<Vec<Point>>) -> Result<Vec<Point>> {
    let fault = |e: serde_json::Error| Error::new(format!("points of a sweep cannot be kept: {e}"));
    let bytes = kept.unit(name, &mut || serde_json::to_vec(&measure()?).map_err(fault))?;
    serde_json::from_slice(&bytes).map_err(fault)
}

/// What other programs are measured against.
pub struct Reference<'a> {
    lux: &'a Matrix<f32>,
    /// The project as all settings have it that do not change the sky.
    pub project: &'a Project,
}

impl Reference<'_> {
    /// Hourly and annual error of illuminances `[sensor][hour]`.
    pub fn distance(&self, lux: &Matrix<f32>) -> (f64, f64) {
        distance(lux, self.lux)
    }
}

/// Illuminance of all sensors, lx, from V and D of each window as another program made them, with this
/// project's T and S.
///
/// # Errors
/// Matrices that do not fit, failures of the multiplier's device.
pub fn illuminance(
    project: &Project,
    inputs: &Inputs,
    matrices: &[(Matrix<f32>, Matrix<f32>)],
    multiplier: &dyn Multiplier,
) -> Result<Matrix<f32>> {
    let ground_reflectance = [project.weather.ground_albedo; 3];
    let options = SkyOptions { subdivision: inputs.sky(project).subdivision(), ground_reflectance, ..SkyOptions::default() };
    let sky = sky_matrix(&inputs.weather, &options, &Silent)?;
    let mut lux: Option<Matrix<f32>> = None;
    for (window, (v, d)) in inputs.windows.iter().zip(matrices) {
        let t = &window.transmission;
        if (v.cols(), d.rows(), d.cols(), v.components(), d.components()) != (t.rows(), t.cols(), sky.rows(), 3, 3) {
            return Err(Error::new(format!(
                "the matrices of window '{}' do not fit: V {} x {}, D {} x {}",
                window.name,
                v.rows(),
                v.cols(),
                d.rows(),
                d.cols()
            )));
        }
        let part = lux_of(multiplier, &multiply(v, &multiply(t, d)), &sky)?;
        match &mut lux {
            None => lux = Some(part),
            Some(sum) => sum.data_mut().iter_mut().zip(part.data()).for_each(|(s, p)| *s += p),
        }
    }
    lux.ok_or_else(|| Error::new("there is no window"))
}

/// Medians over the sensors of the root mean square distance of the hours and of that of the sums,
/// relative to the reference.
fn distance(found: &Matrix<f32>, reference: &Matrix<f32>) -> (f64, f64) {
    let (mut hourly, mut annual) = (Vec::new(), Vec::new());
    for sensor in 0..reference.rows().min(found.rows()) {
        let (mut squares, mut of, mut sum, mut wanted) = (0.0, 0.0, 0.0, 0.0);
        for (a, b) in found.row(sensor).iter().zip(reference.row(sensor)) {
            let (a, b) = (f64::from(*a), f64::from(*b));
            squares += (a - b).powi(2);
            of += b * b;
            sum += a;
            wanted += b;
        }
        if of > 0.0 {
            hourly.push((squares / of).sqrt());
            annual.push((sum / wanted - 1.0).abs());
        }
    }
    let median = |mut v: Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v.get(v.len() / 2).copied().unwrap_or(0.0)
    };
    (median(hourly), median(annual))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_relative_to_the_reference() {
        let reference = Matrix::from_data(1, 2, 1, vec![3.0f32, 4.0]).unwrap();
        let found = Matrix::from_data(1, 2, 1, vec![3.0f32, 4.5]).unwrap();
        let (hourly, annual) = distance(&found, &reference);
        assert!((hourly - 0.1).abs() < 1e-12 && (annual - 0.5 / 7.0).abs() < 1e-12);
    }
}
