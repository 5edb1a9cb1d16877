//! Glare of a project's views over the year: `[glare]`.
//!
//! | method | Ev | sources |
//! |---|---|---|
//! | `image` | the picture's | pixels of the picture |
//! | `edgps` | a sensor at the eye | pixels of a picture that shows the windows alone |
//! | `dgps` | a sensor at the eye | none |
//! | `imageless` | a sensor at the eye | patches of the sky, by the light they send to it directly |
//!
//! With five phases the sun's patches, seen straight through a shade, go out of pictures and sensors,
//! and the suns come back as traced, hour by hour. Their discs are sources of their own
//! ([`Disc`]) wherever there are sources, so that DGP does not depend on the size of the pixels.
//! The standard error of `imageless` is that of Ev and of the share of the sun that is seen; the patches'
//! own noise is left out.
//! V and D are shared by all states of the façade, V of a view with its pictures.

use super::fingerprint::Fingerprint;
use super::five_phase::{FivePhase, Phase, is_sunny, luminous, transmitted_where, without_sun_patches};
use super::glare_eyes::{Eye, Eyes, ImagelessSources, frame_of};
use super::glare_noise::{MatrixNoise, SunNoise};
use super::glare_output::{self, Hour, ViewYear};
use super::glare_section::{GlareMethod, GlareSection};
use super::inputs::{Inputs, ProjectWindow, SensorGroup};
use super::multiply::{Factor, lit_columns, product, select_columns};
use super::picture_sets::GivenPictures;
use super::pictures::PictureView;
use super::presets::{image_options, rounds, view_options};
use super::project::Project;
use super::rounds::{Part, average};
use super::store::Store;
use super::sun_pictures::{Shown, SunPictures};
use super::views::{ViewJob, ViewSection};
use crate::error::{Error, Result, Warnings};
use crate::glare::geometry::{PixelGeometry, ViewFrame};
use crate::glare::{Analyser, Disc, index};
use crate::gpu::Device;
use crate::kernels::glare::{
    Added, AddedLight, Additions, Batches, HourNoise, PixelSource, ReadyView, Stack, StackOptions, Year, for_device, year,
};
use crate::kernels::image_matrix::ImageOptions;
use crate::kernels::product::Multiplier;
use crate::kernels::sun_matrix::pixels::SeenDisc;
use crate::kernels::trace::{TraceStatistics, TracedMatrix};
use crate::kernels::view_matrix;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::progress::Progress;
use crate::scene::Window;
use crate::scene::points::Sensor;
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
    /// With five phases.
    pub five: Option<FiveGlare<'a>>,
}

/// What the glare of five phases is computed from beside.
#[derive(Clone, Copy)]
pub struct FiveGlare<'a> {
    /// Suns, and skies with and without them.
    pub terms: &'a FivePhase<'a>,
    /// What determines a sun matrix, but for the receivers.
    pub sun_inputs: Fingerprint,
    /// What the suns of these hours put into the picture of a view, or show its eye.
    #[allow(clippy::type_complexity, reason = "one function")]
    pub sun_pictures: &'a dyn Fn(&ViewSection, &Shown, &[usize], &mut TraceStatistics) -> Result<SunPictures>,
}

impl FiveGlare<'_> {
    /// Sds of some hours, if there is any sun.
    fn sun_patches(&self, hours: &[usize]) -> Option<Matrix<f32>> {
        self.terms.skies().map(|(_, sun)| select_columns(sun, hours))
    }
}

/// One state of the façade.
struct State<'a> {
    /// Empty if there is only one.
    name: String,
    transmissions: Vec<&'a Matrix<f64>>,
    /// T·D·S of the lit hours.
    coefficients: Matrix<f32>,
    /// Right factor of V − Vd beside Vd, for pictures and for eyes, where suns are traced for them.
    for_pictures: Option<Matrix<f32>>,
    for_eyes: Option<Matrix<f32>>,
    /// `[bin][patch]`, where needed: T·Dd of all windows, and of those whose sun is traced.
    direct: Matrix<f64>,
    traced: Option<Matrix<f64>>,
}

impl State<'_> {
    fn of_pictures(&self) -> &Matrix<f32> {
        self.for_pictures.as_ref().unwrap_or(&self.coefficients)
    }

    fn of_eyes(&self) -> &Matrix<f32> {
        self.for_eyes.as_ref().unwrap_or(&self.coefficients)
    }
}

/// The hours that are computed: lit ones.
struct Lit {
    /// Numbers in the year.
    hours: Vec<usize>,
    sky: Matrix<f32>,
    /// Sds, where suns are traced.
    suns: Option<Matrix<f32>>,
}

/// The suns' light in the pictures of a view, or at its eye.
struct SunLight<'a> {
    pictures: SunPictures,
    hours: &'a [usize],
}

impl Additions for SunLight<'_> {
    fn of_hour(&self, hour: usize) -> Result<Added> {
        let lit = self.pictures.sun_picture_with_discs(self.hours[hour])?;
        let errors = lit.errors.iter().zip(&lit.shared_errors);
        let light = |(&(pixel, v), (&error, &shared_error)): (&(u32, [f32; 3]), (&f32, &f32))| AddedLight {
            pixel,
            luminance: luminous(&v) as f32,
            error,
            shared_error,
        };
        let disc = |d: &SeenDisc| Disc {
            direction: d.direction.map(f64::from),
            luminance: luminous(&d.radiance),
            solid_angle: f64::from(d.solid_angle),
            error: f64::from(d.error),
        };
        Ok(Added {
            pixels: lit.pixels.iter().zip(errors).map(light).collect(),
            discs: lit.discs.iter().map(disc).collect(),
            shared: lit.shared,
        })
    }
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
        let suns = self.five.and_then(|five| five.sun_patches(&hours));
        let lit = Lit { sky: select_columns(self.sky, &hours), hours, suns };
        let eyes = if section.method == GlareMethod::Image { None } else { Some(self.eyes(statistics)?) };
        if section.method == GlareMethod::Edgps {
            for view in &self.project.views {
                self.windows_only(view).matrix(self.windows_only_inputs(view)?, statistics)?;
            }
        }
        let clock = Instant::now();
        let states = self.states(multiplier, &lit, section.method)?;
        let pictured = section.method.has_pictures();
        let detector = if pictured { Some(for_device(self.device)?) } else { None };
        let mut years = Vec::new();
        for (number, view) in self.project.views.iter().enumerate() {
            let stage = Part::of(self.progress, number, self.project.views.len());
            let eye = eyes.as_ref().map(|eyes| eyes.of(number));
            let found = match (&detector, &eye) {
                (Some(detector), _) => {
                    let analyser = analyser(section, view)?;
                    analyser.doubts().into_iter().for_each(|doubt| warnings.push(doubt.file(&view.file)));
                    if view.given.sun.is_some() {
                        warnings.push(given_disc(view));
                    }
                    self.pictured(section, view, analyser, &**detector, eye, &states, &lit, (statistics, &stage))?
                }
                (None, Some(eye)) => {
                    stage.update("glare", 0.0);
                    self.without_pictures(section, view, eye, &states, &lit, statistics)?
                }
                (None, None) => return Err(Error::new("a method without pictures needs the eyes")),
            };
            for (state, found) in states.iter().zip(found) {
                years.push(self.whole_year(view, state, &lit.hours, found, section));
            }
        }
        let seconds = clock.elapsed().as_secs_f64();
        glare_output::write(self.store, section, &self.inputs.weather.records, &years, self.progress, warnings)?;
        Ok(GlareSummary {
            method: section.method.name().to_string(),
            views: self.project.views.len(),
            states: states.len(),
            hours: lit.hours.len(),
            detector: detector.map(|d| d.description()),
            seconds,
        })
    }

    fn windows(&self) -> Vec<Window> {
        self.inputs.windows.iter().map(|w| w.window.clone()).collect()
    }

    /// What every state of the façade lets in.
    fn states(&self, multiplier: &dyn Multiplier, lit: &Lit, method: GlareMethod) -> Result<Vec<State<'_>>> {
        let windows = &self.inputs.windows;
        let named: Vec<String> =
            windows.iter().find(|w| !w.states.is_empty()).map_or_else(|| vec![String::new()], |w| unique_names(&w.states));
        named
            .into_iter()
            .enumerate()
            .map(|(number, name)| {
                let transmissions: Vec<&Matrix<f64>> =
                    windows.iter().map(|w| w.states.get(number).map_or(&w.transmission, |(_, t)| t)).collect();
                let together = |daylight: &[Matrix<f32>], counts: &dyn Fn(&ProjectWindow) -> bool| {
                    transmitted_where(self.inputs, &transmissions, daylight, counts)
                };
                let factors = vec![
                    Factor { name: "T·D".into(), matrix: together(self.daylight, &|_| true)?.map(|v| v as f32) },
                    Factor { name: "S".into(), matrix: lit.sky.clone() },
                ];
                let coefficients = product(multiplier, factors, None)?;
                // For whom suns are traced.
                let split = |wanted: bool, counts: &dyn Fn(&ProjectWindow) -> bool| -> Result<Option<Matrix<f32>>> {
                    let Some(five) = self.five.filter(|_| wanted && windows.iter().any(counts)) else { return Ok(None) };
                    let sun = five.terms.sun_at_windows(multiplier, &together(self.daylight_direct, counts)?, &lit.hours)?;
                    Ok(sun.map(|sun| without_sun_patches(&coefficients, &sun)))
                };
                let for_pictures = split(method.has_pictures(), &is_sunny)?;
                let for_eyes = split(method != GlareMethod::Image, &is_sunny)?;
                let imageless = method == GlareMethod::Imageless;
                let direct = if imageless { together(self.daylight_direct, &|_| true)? } else { Matrix::zeros(0, 0, 3) };
                let traced = (imageless && lit.suns.is_some()).then(|| together(self.daylight_direct, &is_sunny)).transpose()?;
                Ok(State { name, transmissions, coefficients, for_pictures, for_eyes, direct, traced })
            })
            .collect()
    }

    /// Matrices of sensors at the views' points that face as the views look.
    fn eyes(&self, statistics: &mut TraceStatistics) -> Result<Eyes<'_>> {
        let view = self.eyes_view(statistics)?;
        let Some(five) = self.five.filter(|five| five.terms.skies().is_some()) else { return Ok(Eyes { view, suns: None }) };
        let sensors = self.project.views.iter().map(eye).collect::<Result<Vec<_>>>()?;
        let group = SensorGroup { name: "glare_eyes".into(), file: self.project.file.clone(), sensors, view: None, sun: None };
        let phase = Phase { device: self.device, project: self.project, inputs: self.inputs, store: self.store, progress: self.progress };
        let (matrix, traced) = phase.sun_matrix(five.sun_inputs, &[group], five.terms.suns())?;
        if traced {
            statistics.paths += matrix.statistics.paths;
            statistics.segments += matrix.statistics.segments;
        }
        Ok(Eyes { view, suns: Some((matrix, five.terms.suns())) })
    }

    fn eyes_view(&self, statistics: &mut TraceStatistics) -> Result<TracedMatrix> {
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
        WindowsOnly {
            job: self,
            view: ViewSection { name: windows_only_name(view), given: GivenPictures::default(), ..view.clone() },
            windows: self.windows(),
        }
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
        eye: Option<Eye<'_>>,
        states: &[State<'_>],
        lit: &Lit,
        (statistics, progress): (&mut TraceStatistics, &dyn Progress),
    ) -> Result<Vec<Vec<Hour>>> {
        let name = if eye.is_some() { windows_only_name(view) } else { view.name.clone() };
        let path = |suffix: &str| self.store.matrix_path(&format!("V_{name}{suffix}"));
        // All states have the same windows with shades.
        let five = self.five.filter(|_| states.iter().any(|s| s.for_pictures.is_some()));
        let shown = Shown::Picture(view.raster()?);
        let suns = five.map(|five| (five.sun_pictures)(view, &shown, &lit.hours, statistics)).transpose()?;
        let suns = suns.map(|pictures| SunLight { pictures, hours: &lit.hours });
        let mut source = match &suns {
            None => PictureView::open(&path("").display().to_string(), None)?,
            Some(_) => PictureView::open_split(&path(""), &path("_direct"))?,
        };
        let options = StackOptions { veil: section.veil, dark_pixels: suns.is_some(), ..StackOptions::default() };
        let stack = Stack::new(analyser, vec![&mut source as &mut dyn PixelSource], options)?;
        let batches = Batches::new(&stack, &read_matrix(&path("_batches"))?.matrix)?;
        let ready = ReadyView::new(detector, &stack)?;
        let mut all = Vec::new();
        for (number, state) in states.iter().enumerate() {
            let given = eye.map(|eye| eye.illuminance(state.of_eyes(), &lit.hours));
            let noise = self.noise(state, lit, eye);
            let rights = [state.of_pictures()];
            let request = Year {
                additions: suns.as_ref().map(|s| s as &dyn Additions),
                illuminance: given.as_deref(),
                batches: Some(&batches),
                noise: Some(&noise),
                ..Year::new(&rights)
            };
            let stage = Part::of(progress, number, states.len());
            let found = year(&ready, &request, &stage)?;
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

    fn noise<'n>(&'n self, state: &'n State<'_>, lit: &'n Lit, eye: Option<Eye<'n>>) -> MatrixNoise<'n> {
        let suns = lit.suns.as_ref().map(|patches| SunNoise {
            patches,
            hours: &lit.hours,
            daylight: self.daylight,
            daylight_direct: self.daylight_direct,
        });
        MatrixNoise::new(self.inputs, &state.transmissions, self.daylight_error, &lit.sky, &state.coefficients, eye, suns)
    }

    /// Lit hours of one view without pictures, for every state.
    fn without_pictures(
        &self,
        section: &GlareSection,
        view: &ViewSection,
        eye: &Eye<'_>,
        states: &[State<'_>],
        lit: &Lit,
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<Vec<Hour>>> {
        let camera = *view.raster()?.camera();
        let wanted = section.method == GlareMethod::Imageless && lit.suns.is_some();
        let suns = self.five.filter(|_| wanted && states.iter().any(|s| s.for_eyes.is_some()));
        let suns = suns.map(|five| (five.sun_pictures)(view, &Shown::Discs(camera), &lit.hours, statistics)).transpose()?;
        let suns = suns.map(|pictures| SunLight { pictures, hours: &lit.hours });
        let frame = frame_of(camera.view()).map_err(|e| e.file(&view.file))?;
        let of_state = |state| {
            let sources = (section.method == GlareMethod::Imageless).then(|| self.sources(&frame, eye, state, section));
            self.hours_without_pictures(section, eye, state, sources.as_ref(), suns.as_ref(), lit)
        };
        states.iter().map(of_state).collect()
    }

    /// The sky's patches as sources.
    fn sources(&self, frame: &ViewFrame, eye: &Eye<'_>, state: &State<'_>, section: &GlareSection) -> ImagelessSources {
        let windows = self.inputs.windows.iter().map(|w| &w.window);
        ImagelessSources::new(frame, eye, windows, self.project.method.sky, &state.direct, state.traced.as_ref(), &section.settings)
    }

    fn hours_without_pictures(
        &self,
        section: &GlareSection,
        eye: &Eye<'_>,
        state: &State<'_>,
        sources: Option<&ImagelessSources>,
        suns: Option<&SunLight<'_>>,
        lit: &Lit,
    ) -> Result<Vec<Hour>> {
        let lux = eye.illuminance(state.of_eyes(), &lit.hours);
        let noise = self.noise(state, lit, Some(*eye));
        let none = vec![0.0; self.inputs.bins() * 3];
        let (settings, model) = (&section.settings, section.settings.dgp);
        let hours = (0..lit.hours.len()).into_par_iter().map(|hour| {
            let ev = lux[hour];
            let discs = suns.map_or_else(|| Ok(Vec::new()), |suns| suns.of_hour(hour).map(|added| added.discs))?;
            let (dgp, [by_illuminance, by_contrast], count) = match sources {
                None => (index::dgps(ev), [index::dgps(1.0) - index::dgps(0.0), 0.0], 0),
                Some(sources) => {
                    let (sum, count) = sources.contrast(hour, &lit.sky, lit.suns.as_ref(), &discs, settings);
                    (model.dgp(ev, sum), model.slopes(ev, sum), count)
                }
            };
            let finite = |slope: f64| if dgp < 1.0 && slope.is_finite() { slope } else { 0.0 };
            let change = |disc: &Disc| {
                let of = |disc: Disc| sources.map_or(0.0, |s| s.contrast_of_discs(&[disc], settings).0);
                finite(by_contrast) * (of(disc.with_more_seen()) - of(*disc))
            };
            let of_discs: f64 = discs.iter().map(|d| change(d).powi(2)).sum();
            let variance = noise.variance(hour, &none, finite(by_illuminance)) + of_discs;
            Ok(Hour { dgp, standard_error: variance.sqrt().min(1.0), illuminance: ev, sources: count })
        });
        hours.collect()
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
            refinement: 1,
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

/// Suns in pictures made elsewhere stand on pixels, whose light no one can tell from a disc's.
fn given_disc(view: &ViewSection) -> Error {
    Error::new(format!(
        "the sun's disc of view '{}' stands on the pixels of the given pictures 'sun', not as a glare source of its own: DGP depends on the size of the pixels",
        view.name
    ))
    .file(&view.file)
    .help("leave 'sun' out of the view to have the sun traced, or take pixels of 0.1° or less")
}

fn windows_only_name(view: &ViewSection) -> String {
    format!("{}_windows", view.name)
}

/// The sensor at a view's eye.
pub(super) fn eye(view: &ViewSection) -> Result<Sensor> {
    let found = view.view()?;
    let camera = found.camera().map_err(|e| e.file(&view.file))?;
    Ok(Sensor { position: found.point, direction: camera.direction, line: 1 })
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
