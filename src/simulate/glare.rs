//! Glare of a project's views over the year: `[glare]`.
//!
//! | method | Ev | sources |
//! |---|---|---|
//! | `image` | the picture's | pixels of the picture |
//! | `edgps` | a sensor at the eye | pixels of a picture that shows the windows alone |
//! | `dgps` | a sensor at the eye | none |
//! | `imageless` | a sensor at the eye | patches of the sky, by the light they send to it directly |
//!
//! The standard error of `imageless` is that of Ev alone; the patches' own noise is left out.
//! V and D are shared by all states of the façade, V of a view with its pictures.

use super::fingerprint::Fingerprint;
use super::glare_noise::{Eye, MatrixNoise};
use super::glare_output::{self, Hour, ViewYear};
use super::glare_section::{GlareMethod, GlareSection};
use super::inputs::Inputs;
use super::multiply::{Factor, lit_columns, product, select_columns};
use super::pictures::PictureView;
use super::presets::{image_options, rounds, view_options};
use super::project::Project;
use super::results::multiply;
use super::rounds::{Part, average};
use super::store::Store;
use super::views::{ViewJob, ViewSection};
use crate::error::{Error, Result, Warnings};
use crate::glare::geometry::{PixelGeometry, ViewFrame};
use crate::glare::imageless::{Patch, PatchSources};
use crate::glare::{Analyser, Threshold, index};
use crate::gpu::Device;
use crate::kernels::glare::{Batches, HourNoise, PixelSource, Stack, StackOptions, Year, for_device, year};
use crate::kernels::image_matrix::ImageOptions;
use crate::kernels::product::Multiplier;
use crate::kernels::trace::{TraceStatistics, TracedMatrix};
use crate::kernels::view_matrix;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::progress::Progress;
use crate::scene::Window;
use crate::scene::points::Sensor;
use crate::units::ILLUMINANCE_WEIGHTS;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;
use std::time::Instant;

/// What glare a run computed, for `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct GlareSummary {
    /// Method of `[glare]`.
    pub method: String,
    /// Views.
    pub views: usize,
    /// States of the façade.
    pub states: usize,
    /// Hours with light, each computed per view and state.
    pub hours: usize,
    /// What found the glare pixels; absent without pictures.
    pub detector: Option<String>,
    /// Seconds for all hours of all views and states, without V and D.
    pub seconds: f64,
}

/// What the glare of a project is computed from.
pub struct GlareJob<'a> {
    /// Device that traces and, if it is faster, multiplies.
    pub device: &'a Device,
    /// The project.
    pub project: &'a Project,
    /// Its files.
    pub inputs: &'a Inputs,
    /// Where results go.
    pub store: &'a Store,
    /// Progress.
    pub progress: &'a dyn Progress,
    /// D of each window.
    pub daylight: &'a [Matrix<f32>],
    /// The part of D without diffuse reflection.
    pub daylight_direct: &'a [Matrix<f32>],
    /// Standard errors of D.
    pub daylight_error: &'a [Matrix<f32>],
    /// S.
    pub sky: &'a Matrix<f32>,
    /// What determines the view matrices, but for the view: `kind` of matrix to fingerprint.
    pub view_inputs: &'a dyn Fn(&str) -> Fingerprint,
}

/// One state of the façade.
struct State<'a> {
    /// Empty if there is only one.
    name: String,
    transmissions: Vec<&'a Matrix<f64>>,
    /// T·D·S of the lit hours.
    coefficients: Matrix<f32>,
    /// The same of the direct part of D, `[bin][patch]`, where it is needed: T·D.
    direct: Matrix<f64>,
}

impl GlareJob<'_> {
    /// Computes and writes everything.
    ///
    /// # Errors
    /// Views without directions, failures of device and file system, and when stopped.
    pub fn run(
        &self,
        section: &GlareSection,
        multiplier: &dyn Multiplier,
        statistics: &mut TraceStatistics,
        warnings: &mut Warnings,
    ) -> Result<GlareSummary> {
        let hours = lit_columns(self.sky);
        let sky = select_columns(self.sky, &hours);
        let eyes = if section.method == GlareMethod::Image { None } else { Some(self.eyes(statistics)?) };
        if section.method == GlareMethod::Edgps {
            for view in &self.project.views {
                self.windows_only(view).matrix(self.windows_only_inputs(view)?, statistics)?;
            }
        }
        let clock = Instant::now();
        let states = self.states(multiplier, &sky)?;
        let pictured = matches!(section.method, GlareMethod::Image | GlareMethod::Edgps);
        let detector = if pictured { Some(for_device(self.device)?) } else { None };
        let mut years = Vec::new();
        for (number, view) in self.project.views.iter().enumerate() {
            let stage = Part::of(self.progress, number, self.project.views.len());
            let eye = eyes.as_ref().map(|eyes| EyeRow {
                total: eyes.total.row(number),
                direct: eyes.direct.row(number),
                standard_error: eyes.standard_error.row(number),
            });
            let found = match (&detector, &eye) {
                (Some(detector), _) => {
                    let analyser = analyser(section, view)?;
                    analyser.doubts().into_iter().for_each(|doubt| warnings.push(doubt.file(&view.file)));
                    self.pictured(section, view, analyser, &**detector, eye, &states, &sky, &stage)?
                }
                (None, Some(eye)) => {
                    stage.update("glare", 0.0);
                    states.iter().map(|state| self.without_pictures(section, view, eye, state, &sky)).collect::<Result<_>>()?
                }
                (None, None) => return Err(Error::new("a method without pictures needs the eyes")),
            };
            for (state, lit) in states.iter().zip(found) {
                years.push(self.whole_year(view, state, &hours, lit, section));
            }
        }
        let seconds = clock.elapsed().as_secs_f64();
        glare_output::write(self.store, section, &self.inputs.weather.records, &years, self.progress, warnings)?;
        Ok(GlareSummary {
            method: section.method.name().to_string(),
            views: self.project.views.len(),
            states: states.len(),
            hours: hours.len(),
            detector: detector.map(|d| d.description()),
            seconds,
        })
    }

    fn windows(&self) -> Vec<Window> {
        self.inputs.windows.iter().map(|w| w.window.clone()).collect()
    }

    /// T·D·S of every state.
    fn states(&self, multiplier: &dyn Multiplier, sky: &Matrix<f32>) -> Result<Vec<State<'_>>> {
        let windows = &self.inputs.windows;
        let named: Vec<String> =
            windows.iter().find(|w| !w.states.is_empty()).map_or_else(|| vec![String::new()], |w| unique_names(&w.states));
        let imageless = self.project.glare.as_ref().is_some_and(|g| g.method == GlareMethod::Imageless);
        named
            .into_iter()
            .enumerate()
            .map(|(number, name)| {
                let transmissions: Vec<&Matrix<f64>> =
                    windows.iter().map(|w| w.states.get(number).map_or(&w.transmission, |(_, t)| t)).collect();
                let together = |daylight: &[Matrix<f32>]| {
                    let data = transmissions.iter().zip(daylight).flat_map(|(t, d)| multiply(t, d).into_data()).collect();
                    Matrix::from_data(self.inputs.bins(), sky.rows(), 3, data)
                };
                let factors = vec![
                    Factor { name: "T·D".into(), matrix: together(self.daylight)?.map(|v| v as f32) },
                    Factor { name: "S".into(), matrix: sky.clone() },
                ];
                let coefficients = product(multiplier, factors, None)?;
                let direct = if imageless { together(self.daylight_direct)? } else { Matrix::zeros(0, 0, 3) };
                Ok(State { name, transmissions, coefficients, direct })
            })
            .collect()
    }

    /// View matrix of sensors at the views' points that face as the views look.
    fn eyes(&self, statistics: &mut TraceStatistics) -> Result<TracedMatrix> {
        let sensors = self.project.views.iter().map(eye).collect::<Result<Vec<_>>>()?;
        let rounds = rounds(self.project);
        let mut inputs = (self.view_inputs)("V of eyes");
        inputs.add(&sensors).add(&view_options(self.project, 0)).add(&rounds);
        let shape = (sensors.len(), self.inputs.bins(), 3);
        let load = |suffix: &str| self.store.load(&format!("glare_eyes{suffix}"), inputs, shape);
        if let (Some(total), Some(direct), Some(standard_error)) = (load(""), load("_direct"), load("_standard_error")) {
            return Ok(TracedMatrix { total, direct, standard_error, batches: Vec::new(), statistics: TraceStatistics::default() });
        }
        let windows = self.windows();
        let traced = average(rounds, self.progress, |round, progress| {
            let options = view_options(self.project, round);
            view_matrix::compute(self.device, &self.inputs.scene, &windows, &sensors, &options, progress)
        })?;
        statistics.paths += traced.statistics.paths;
        statistics.segments += traced.statistics.segments;
        let about = "view matrix of the views' eyes, rows views, columns the windows' bins";
        self.store.save("glare_eyes_direct", &traced.direct, inputs, about)?;
        self.store.save("glare_eyes_standard_error", &traced.standard_error, inputs, about)?;
        self.store.save("glare_eyes", &traced.total, inputs, about)?;
        Ok(traced)
    }

    /// The view as a picture of the windows alone.
    fn windows_only(&self, view: &ViewSection) -> WindowsOnly<'_> {
        WindowsOnly { job: self, view: ViewSection { name: windows_only_name(view), ..view.clone() }, windows: self.windows() }
    }

    fn windows_only_options(&self) -> ImageOptions {
        ImageOptions { bounces: Some(0), ..image_options(self.project) }
    }

    fn windows_only_inputs(&self, view: &ViewSection) -> Result<Fingerprint> {
        Ok(*(self.view_inputs)("V of pictures").add(&view.raster()?).add(&self.windows_only_options()))
    }

    /// Lit hours of one view from its view matrix, for every state.
    #[allow(clippy::too_many_arguments, reason = "what a view shares with the others")]
    fn pictured(
        &self,
        section: &GlareSection,
        view: &ViewSection,
        analyser: Arc<Analyser>,
        detector: &dyn crate::kernels::glare::Detector,
        eye: Option<EyeRow<'_>>,
        states: &[State<'_>],
        sky: &Matrix<f32>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Hour>>> {
        let name = if eye.is_some() { windows_only_name(view) } else { view.name.clone() };
        let matrix = self.store.matrix_path(&format!("V_{name}"));
        let mut source = PictureView::open(&matrix.display().to_string(), None)?;
        let options = StackOptions { veil: section.veil, ..StackOptions::default() };
        let stack = Stack::new(analyser, vec![&mut source as &mut dyn PixelSource], options)?;
        let batches = Batches::new(&stack, &read_matrix(&self.store.matrix_path(&format!("V_{name}_batches")))?.matrix)?;
        let mut all = Vec::new();
        for (number, state) in states.iter().enumerate() {
            let given = eye.map(|eye| illuminance(eye.total, &state.coefficients));
            let noise = self.noise(state, sky, eye);
            let rights = [&state.coefficients];
            let request = Year { illuminance: given.as_deref(), batches: Some(&batches), noise: Some(&noise), ..Year::new(&rights) };
            let stage = Part::of(progress, number, states.len());
            let found = year(detector, &stack, &request, &stage)?;
            all.push(
                found
                    .into_iter()
                    .map(|h| Hour {
                        dgp: h.indices.dgp,
                        standard_error: h.standard_error,
                        illuminance: h.vertical_illuminance,
                        sources: h.sources,
                    })
                    .collect(),
            );
        }
        Ok(all)
    }

    fn noise<'n>(&'n self, state: &'n State<'_>, sky: &'n Matrix<f32>, eye: Option<EyeRow<'n>>) -> MatrixNoise<'n> {
        let eye = eye.map(|e| Eye { values: e.total, standard_error: e.standard_error });
        MatrixNoise::new(self.inputs, &state.transmissions, self.daylight_error, sky, &state.coefficients, eye)
    }

    /// Lit hours of one view and state without pictures.
    fn without_pictures(
        &self,
        section: &GlareSection,
        view: &ViewSection,
        eye: &EyeRow<'_>,
        state: &State<'_>,
        sky: &Matrix<f32>,
    ) -> Result<Vec<Hour>> {
        let lux = illuminance(eye.total, &state.coefficients);
        let noise = self.noise(state, sky, Some(*eye));
        let none = vec![0.0; self.inputs.bins() * 3];
        let model = section.settings.dgp;
        let sources = match section.method {
            GlareMethod::Imageless => Some(self.patch_sources(section, view, eye, state)?),
            _ => None,
        };
        (0..sky.cols())
            .into_par_iter()
            .map(|hour| {
                let ev = lux[hour];
                let (dgp, slope, count) = match &sources {
                    None => (index::dgps(ev), index::dgps(1.0) - index::dgps(0.0), 0),
                    Some(sources) => {
                        let (sum, count) = sources.contrast(hour, sky, &section.settings);
                        (model.dgp(ev, sum), model.slopes(ev, sum)[0], count)
                    }
                };
                let slope = if dgp < 1.0 && slope.is_finite() { slope } else { 0.0 };
                let variance = noise.variance(hour, &none, slope);
                Ok(Hour { dgp, standard_error: variance.sqrt().min(1.0), illuminance: ev, sources: count })
            })
            .collect()
    }

    fn patch_sources(&self, section: &GlareSection, view: &ViewSection, eye: &EyeRow<'_>, state: &State<'_>) -> Result<EyeAndPatches> {
        let sky = self.project.method.sky;
        let camera = view.raster()?.camera().view().to_owned();
        let frame = ViewFrame::new(camera.direction.to_array(), camera.up.to_array()).map_err(|e| e.file(&view.file))?;
        // The ground is no source of glare, as in dcglare.
        let patches: Vec<Patch> = (0..sky.len())
            .map(|p| Patch { direction: sky.centre(p).to_array(), solid_angle: if p == 0 { 0.0 } else { sky.solid_angle(p) } })
            .collect();
        // Direct coefficient of each patch at the eye.
        let direct = (0..sky.len())
            .map(|p| {
                let mut sum = [0.0; 3];
                for bin in 0..self.inputs.bins() {
                    for c in 0..3 {
                        sum[c] += f64::from(eye.direct[bin * 3 + c]) * state.direct.at(bin, p)[c];
                    }
                }
                sum
            })
            .collect();
        Ok(EyeAndPatches { sources: PatchSources::new(&frame, &patches, section.settings.position_index), direct })
    }

    /// All hours of the weather file from those with light.
    fn whole_year(&self, view: &ViewSection, state: &State<'_>, lit: &[usize], found: Vec<Hour>, section: &GlareSection) -> ViewYear {
        let dark = match section.method {
            GlareMethod::Dgps => index::dgps(0.0),
            _ => section.settings.dgp.dgp(0.0, 0.0),
        };
        let dark = Hour { dgp: dark, standard_error: 0.0, illuminance: 0.0, sources: 0 };
        let mut hours = vec![dark; self.sky.cols()];
        let mut is_lit = vec![false; self.sky.cols()];
        for (&hour, glare) in lit.iter().zip(found) {
            hours[hour] = glare;
            is_lit[hour] = true;
        }
        ViewYear { view: view.name.clone(), state: state.name.clone(), hours, is_lit }
    }
}

/// A view's row of the eyes' view matrix.
#[derive(Clone, Copy)]
struct EyeRow<'a> {
    total: &'a [f32],
    direct: &'a [f32],
    standard_error: &'a [f32],
}

/// Patches as sources of one view, and what each sends to the eye directly.
struct EyeAndPatches {
    sources: PatchSources,
    direct: Vec<[f64; 3]>,
}

impl EyeAndPatches {
    /// DGP's contrast sum and the number of sources.
    fn contrast(&self, hour: usize, sky: &Matrix<f32>, settings: &crate::glare::Settings) -> (f64, usize) {
        let lux: Vec<f64> = self
            .direct
            .iter()
            .enumerate()
            .map(|(p, d)| (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * d[c] * f64::from(sky.at(p, hour)[c])).sum())
            .collect();
        let threshold = match settings.threshold {
            Threshold::Fixed(l) => l,
            // Refused when the section is read.
            Threshold::TimesAverage(_) | Threshold::TimesTask(_) => f64::INFINITY,
        };
        (self.sources.contrast_sum(&lux, threshold, &settings.dgp), self.sources.count(&lux, threshold))
    }
}

/// Computes the view matrix of the windows alone.
struct WindowsOnly<'a> {
    job: &'a GlareJob<'a>,
    view: ViewSection,
    windows: Vec<Window>,
}

impl WindowsOnly<'_> {
    fn matrix(&self, inputs: Fingerprint, statistics: &mut TraceStatistics) -> Result<()> {
        let job = ViewJob {
            device: self.job.device,
            scene: &self.job.inputs.scene,
            windows: &self.windows,
            view: &self.view,
            options: self.job.windows_only_options(),
            store: self.job.store,
            progress: self.job.progress,
        };
        job.matrix(inputs, statistics).map(|_| ())
    }
}

fn analyser(section: &GlareSection, view: &ViewSection) -> Result<Arc<Analyser>> {
    let geometry = PixelGeometry::new(&view.raster()?).map_err(|e| e.file(&view.file))?;
    Ok(Arc::new(Analyser::new(Arc::new(geometry), section.settings.clone())?))
}

fn windows_only_name(view: &ViewSection) -> String {
    format!("{}_windows", view.name)
}

/// The sensor at a view's eye.
fn eye(view: &ViewSection) -> Result<Sensor> {
    let found = view.view()?;
    let camera = found.camera().map_err(|e| e.file(&view.file))?;
    Ok(Sensor { position: found.point, direction: camera.direction, line: 1 })
}

/// Illuminance in every hour from a row `[bin][rgb]` of V, lx.
fn illuminance(row: &[f32], coefficients: &Matrix<f32>) -> Vec<f64> {
    let mut lux = vec![0.0; coefficients.cols()];
    for (bin, v) in row.as_chunks::<3>().0.iter().enumerate() {
        for (lux, light) in lux.iter_mut().zip(coefficients.row(bin).as_chunks::<3>().0) {
            *lux += (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * f64::from(v[c]) * f64::from(light[c])).sum::<f64>();
        }
    }
    lux
}

/// The states' names, numbered where files in different folders have the same.
fn unique_names(states: &[(String, Matrix<f64>)]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (name, _) in states {
        let mut unique = if name.is_empty() { "state".to_string() } else { name.clone() };
        let mut number = 2;
        while names.contains(&unique) {
            unique = format!("{name}-{number}");
            number += 1;
        }
        names.push(unique);
    }
    names
}
