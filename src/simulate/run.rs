//! One run of a project: weather to S, windows and scene to V and D, their product to illuminance.

use super::annual;
use super::estimate::Estimate;
use super::fingerprint::Fingerprint;
use super::five_phase::{FivePhase, Phase};
use super::glare::GlareSummary;
use super::inputs::{Inputs, SensorGroup};
use super::method::Choice;
use super::project::Project;
use super::reach;
use super::results::{self, Content};
use super::store::Store;
use super::summary::{DeviceSummary, MatrixSummary, Seconds, SensorSummary, Summary, ViewSummary};
use super::suns::SunCensus;
use super::uncertainty::EstimatedError;
use crate::error::{Error, Result, Warnings};
use crate::gpu::Device;
use crate::kernels::product;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::sky::{SkyOptions, sky_matrix};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Computes a project and writes its results into the folder `out`:
///
/// | file | content |
/// |---|---|
/// | `matrices/S.mtx` | sky matrix, rows patches (ground first), columns hours, RGB |
/// | `matrices/V_SENSORS.mtx` | view matrix, rows sensors, columns the bins of all windows in the project's order |
/// | `matrices/T_WINDOW.mtx` | transmission, rows outgoing bins, columns incident bins |
/// | `matrices/D_WINDOW.mtx` | daylight matrix, rows bins, columns patches |
/// | `matrices/*_direct.mtx`, `*_standard_error.mtx` | the part without diffuse reflection; the standard error of each entry |
/// | `matrices/Sds.mtx` | five phases: the sun's share of S |
/// | `matrices/replicates_*.mtx` | the independent estimates that V and D are the means of |
/// | `matrices/C_SENSORS.mtx`, `suns.rad` | five phases: sun matrix, columns the suns that were traced, listed in `suns.rad` |
/// | `matrices/DC_SENSORS.mtx` | two phases: daylight coefficients V·T·D |
/// | `illuminance/terms/SENSORS_*.mtx` | five phases: `three_phase` V·T·D·S, `direct` Vd·T·Dd·Sds, `sun` Cds·Ssun, lux |
/// | `illuminance/SENSORS.mtx`, `.csv` | lux, rows sensors, columns time steps (transposed in the table, which marks sensors without light) |
/// | `illuminance/SENSORS_standard_error.mtx`, `.csv` | its standard error, lux |
/// | `illuminance/SENSORS_annual.csv` | mean, daylight autonomy and useful daylight of each sensor with their standard errors |
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
    run_beside(device, project, inputs, (out, Vec::new()), progress, warnings)
}

/// The same, with the folders of other rooms from which matrices of the same inputs are taken over.
pub(super) fn run_beside(
    device: &Device,
    project: &Project,
    inputs: &Inputs,
    (out, others): (&Path, Vec<PathBuf>),
    progress: &dyn Progress,
    warnings: &mut Warnings,
) -> Result<Summary> {
    let start = Instant::now();
    let store = Store::open(out)?.beside(others);
    let mut run = Run {
        device,
        project,
        choice: project.method.choice(&project.windows),
        inputs,
        store: &store,
        progress,
        seconds: Seconds::default(),
        statistics: TraceStatistics::default(),
        traced_seconds: 0.0,
        matrices: Vec::new(),
        product: String::new(),
    };
    run.finish(start, warnings)
}

mod matrices;
mod pictures;

use pictures::ProductOfPictures;

struct Run<'a> {
    device: &'a Device,
    project: &'a Project,
    choice: Choice,
    inputs: &'a Inputs,
    store: &'a Store,
    progress: &'a dyn Progress,
    seconds: Seconds,
    statistics: TraceStatistics,
    traced_seconds: f64,
    matrices: Vec<MatrixSummary>,
    product: String,
}

impl<'a> Run<'a> {
    fn finish(&mut self, start: Instant, warnings: &mut Warnings) -> Result<Summary> {
        let clock = Instant::now();
        let sky = self.sky()?;
        self.seconds.sky = clock.elapsed().as_secs_f64();

        let sampled = self.sampled(&sky)?;
        let daylight: Vec<Matrix<f32>> = sampled.daylight.iter().map(Estimate::total).collect();
        let daylight_direct: Vec<Matrix<f32>> = sampled.daylight.iter().map(Estimate::direct).collect();
        let daylight_error: Vec<Matrix<f32>> = sampled.daylight.iter().map(Estimate::standard_error).collect();
        let view = (sampled.view.total(), sampled.view.direct());
        let dark = reach::check(self.inputs, &view.0, warnings)?;

        let clock = Instant::now();
        let five = self.five_phase(&daylight_direct, warnings)?;
        self.seconds.suns = clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        self.check_stop()?;
        self.progress.update("product", 0.0);
        let transmitted = results::transmitted_daylight(self.inputs, &daylight);
        let coefficients = results::multiply(&view.0, &transmitted);
        let multiplier = product::for_device(self.device)?;
        if self.choice.phases == 2 {
            self.write_coefficients(&coefficients)?;
        }
        let lux = match &five {
            None => results::illuminance(multiplier.as_ref(), coefficients, &sky)?,
            Some(five) => five.illuminance(multiplier.as_ref(), coefficients, &view.1, &sky)?,
        };
        self.product = multiplier.description();
        self.seconds.product = clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        let addition = five.as_ref().map(FivePhase::addition);
        let stage = |fraction: f64| {
            self.progress.update("error estimate", fraction);
            self.check_stop()
        };
        let chain = sampled.chain(self.inputs, &sky);
        let errors = annual::estimate(&chain, multiplier.as_ref(), &lux, addition.as_deref(), self.project.quality.target(), &stage)?;
        self.seconds.error_estimate = clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        let sensors = self.write(&lux, &errors, &dark)?;
        let pictures =
            ProductOfPictures { multiplier: multiplier.as_ref(), transmitted: &transmitted, sky: &sky, daylight: &sampled.daylight };
        let views = self.pictures(&pictures, five.as_ref(), &daylight_direct, warnings)?;
        self.seconds.write = clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        let glare = self.glare(multiplier.as_ref(), [&daylight, &daylight_direct, &daylight_error], &sky, five.as_ref(), warnings)?;
        self.seconds.glare = clock.elapsed().as_secs_f64();
        self.seconds.total = start.elapsed().as_secs_f64();
        let census = five.as_ref().map(|f| f.census().clone());
        self.warn_of_error(&errors, warnings);
        let summary = self.summary(sensors, views, glare, errors.estimated, census, warnings);
        summary.write(&self.store.summary_path())?;
        Ok(summary)
    }

    fn check_stop(&self) -> Result<()> {
        if self.progress.stop_requested() { Err(cancelled()) } else { Ok(()) }
    }

    fn note(&mut self, name: &str, (rows, columns): (usize, usize), reused: bool, seconds: f64, (rounds, rays): (u32, u64)) {
        let rays = if reused { 0 } else { rays };
        let rounds = (rounds > 0).then_some(rounds);
        self.matrices.push(MatrixSummary { name: name.to_string(), rows, columns, reused, seconds, rays, rounds });
    }

    fn sky(&mut self) -> Result<Matrix<f32>> {
        let clock = Instant::now();
        self.check_stop()?;
        let options = SkyOptions { subdivision: self.project.method.sky.subdivision(), ..SkyOptions::default() };
        let weather = &self.inputs.weather;
        let inputs = *Fingerprint::new("S").add(weather).add(&options);
        let shape = (self.project.method.sky.len(), weather.records.len(), 3);
        let kept = self.store.load("S", inputs, shape);
        let reused = kept.is_some();
        let sky = match kept {
            Some(sky) => sky,
            None => {
                let sky = sky_matrix(weather, &options, self.progress)?;
                self.store.save("S", &sky, inputs, "sky matrix, rows patches, columns hours")?;
                sky
            }
        };
        self.note("S", (sky.rows(), sky.cols()), reused, clock.elapsed().as_secs_f64(), (0, 0));
        Ok(sky)
    }

    /// The terms that five phases have beyond three, if there are any.
    fn five_phase(&mut self, daylight_direct: &[Matrix<f32>], warnings: &mut Warnings) -> Result<Option<FivePhase<'a>>> {
        if self.choice.phases != 5 {
            return Ok(None);
        }
        let clock = Instant::now();
        self.check_stop()?;
        let inputs = self.scene_fingerprint("C");
        let phase = Phase { device: self.device, project: self.project, inputs: self.inputs, store: self.store, progress: self.progress };
        let (five, traced) = phase.compute(inputs, daylight_direct, warnings)?;
        for (group, rows) in self.inputs.sensors.iter().map(|g| (g, g.sensors.len())) {
            let seconds = clock.elapsed().as_secs_f64();
            let name = format!("C_{}", group.name);
            self.matrices.push(MatrixSummary {
                name,
                rows,
                columns: five.census().needed,
                reused: traced.is_none(),
                seconds,
                // Of all groups together.
                rays: traced.map_or(0, |t| t.segments),
                rounds: None,
            });
        }
        if let Some(statistics) = traced {
            self.count(statistics, clock);
        }
        Ok(Some(five))
    }

    /// Daylight coefficients of all groups, the one matrix of the two-phase method.
    fn write_coefficients(&self, coefficients: &Matrix<f64>) -> Result<()> {
        let coefficients = coefficients.map(|v| v as f32);
        for (group, part) in self.inputs.sensors.iter().zip(split(&coefficients, &self.inputs.sensors)) {
            let inputs = *Fingerprint::new("DC").add(&part.data());
            self.store.save(&format!("DC_{}", group.name), &part, inputs, "daylight coefficients V·T·D, rows sensors, columns patches")?;
        }
        Ok(())
    }

    /// What rays can meet.
    fn scene_fingerprint(&self, kind: &str) -> Fingerprint {
        let scene = &self.inputs.scene;
        let triangles: Vec<_> = scene.triangles.iter().map(|t| (t.vertices, t.material)).collect();
        let materials: Vec<_> = scene.materials.iter().map(|m| m.kind).collect();
        let device = self.device.summary();
        *Fingerprint::new(kind).add(&triangles).add(&materials).add(&scene.unpruned).add(&device.name).add(&device.driver)
    }

    /// The same with the windows that emit.
    fn view_fingerprint(&self, kind: &str) -> Fingerprint {
        let mut inputs = self.scene_fingerprint(kind);
        for window in self.inputs.windows.iter().map(|w| &w.window) {
            inputs.add(&(&window.triangles, &window.frame, &window.basis));
        }
        inputs
    }

    /// A result that misses what was asked for says so.
    fn warn_of_error(&self, errors: &annual::YearErrors, warnings: &mut Warnings) {
        let Some(error) = errors.estimated.filter(|e| e.target_met == Some(false)) else { return };
        let target = 100.0 * error.target.unwrap_or_default();
        let message = format!(
            "the standard error of a year's light is {:.2} % at the worst sensor, more than the {target:.2} % of {}",
            100.0 * error.annual_largest,
            self.project.quality.name()
        );
        let quality = &self.project.quality;
        let help = match (quality.time_limit, quality.target_error) {
            (Some(_), _) => "give it more time, or leave time_limit out".to_string(),
            (None, Some(_)) => {
                "the suns, which are sampled once, leave more than that; preset = \"final\" gives them the most samples".to_string()
            }
            _ => format!("write target_error = {} in place of the preset to sample until it is met", error.target.unwrap_or_default()),
        };
        warnings.push(Error::new(message).file(&self.project.file).field("quality").help(help));
    }

    fn count(&mut self, statistics: TraceStatistics, clock: Instant) {
        self.statistics.add(statistics);
        self.traced_seconds += clock.elapsed().as_secs_f64();
    }

    fn write(&self, lux: &Matrix<f32>, errors: &annual::YearErrors, dark: &[bool]) -> Result<Vec<SensorSummary>> {
        let groups = &self.inputs.sensors;
        let records = &self.inputs.weather.records;
        let (mut sensors, mut rest) = (Vec::new(), dark);
        let parts = split(lux, groups).into_iter().zip(split(&errors.standard_error, groups));
        for (i, (group, (part, error))) in groups.iter().zip(parts).enumerate() {
            self.progress.update("writing", i as f64 / groups.len() as f64);
            let dark = rest.split_off(..group.sensors.len()).unwrap_or_default();
            results::write_illuminance(self.store, (group, dark), records, &part, Content::Illuminance)?;
            results::write_illuminance(self.store, (group, dark), records, &error, Content::StandardError)?;
            let year = &errors.groups[i];
            annual::write(self.store, (group, dark), year)?;
            sensors.push(SensorSummary {
                name: group.name.clone(),
                count: group.sensors.len(),
                without_light: dark.iter().filter(|d| **d).count(),
                mean_illuminance_lx: year.mean.value,
                mean_illuminance_standard_error_lx: year.mean.standard_error,
                spatial_autonomy: year.spatial_autonomy.value,
                spatial_autonomy_standard_error: year.spatial_autonomy.standard_error,
            });
        }
        Ok(sensors)
    }

    fn summary(
        &self,
        sensors: Vec<SensorSummary>,
        views: Vec<ViewSummary>,
        glare: Option<GlareSummary>,
        estimated_error: Option<EstimatedError>,
        suns: Option<SunCensus>,
        warnings: &Warnings,
    ) -> Summary {
        let (project, rays) = (self.project, self.statistics.segments);
        Summary {
            program: format!("lucarne {}", env!("CARGO_PKG_VERSION")),
            project: crate::files::relative(self.store.folder(), &project.file),
            device: DeviceSummary::of(self.device),
            preset: project.quality.preset.name().to_string(),
            quality: project.quality.name(),
            seed: project.quality.seed,
            phases: self.choice.phases,
            phases_because: self.choice.why.to_string(),
            suns,
            sky_subdivision: project.method.sky.subdivision(),
            bounces: project.method.bounces,
            hours: self.inputs.weather.steps().hours(self.inputs.weather.records.len()),
            time_steps: self.inputs.weather.records.len(),
            sensors,
            views,
            glare,
            matrices: self.matrices.clone(),
            product: self.product.clone(),
            seconds: self.seconds,
            paths: self.statistics.paths,
            rays,
            rays_per_second: (rays > 0 && self.traced_seconds > 0.0).then(|| rays as f64 / self.traced_seconds),
            estimated_error,
            warnings: warnings.iter().map(ToString::to_string).collect(),
        }
    }
}

/// Makes a run model everything, needed or not: D by rays where a quadrature would do, suns behind every
/// window, all channels, shaders for every kind of material. Results are the same within the bound
/// that the plan states for each omission; a check for those who doubt them.
pub fn without_pruning(project: &mut Project, inputs: &mut Inputs) {
    project.quality.prune = false;
    inputs.scene.unpruned = true;
}

/// The rows of each group.
pub(super) fn split(matrix: &Matrix<f32>, groups: &[SensorGroup]) -> Vec<Matrix<f32>> {
    let mut first = 0;
    let values = matrix.cols() * matrix.components();
    groups
        .iter()
        .map(|group| {
            let rows = group.sensors.len();
            let data = matrix.data()[first * values..(first + rows) * values].to_vec();
            first += rows;
            Matrix::from_data(rows, matrix.cols(), matrix.components(), data).expect("a slice of whole rows")
        })
        .collect()
}
