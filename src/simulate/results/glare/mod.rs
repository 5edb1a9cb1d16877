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
//! ([`Disc`](crate::glare::Disc)) wherever there are sources, so that DGP does not depend on the size of the pixels.
//! The standard error of `imageless` is that of Ev and of the share of the sun that is seen; the patches'
//! own noise is left out.
//! V and D are shared by all states of the façade, V of a view with its pictures.

pub(crate) mod carpet;
pub(crate) mod eyes;
mod imageless;
mod noise;
pub mod read;
mod spatial;
mod states;
mod sunlight;
mod tables;

use self::eyes::{Eye, Eyes};
use self::noise::{MatrixNoise, SunNoise};
use self::sunlight::SunLight;
use self::tables::{Hour, ViewYear};
use super::pictures::PictureView;
use super::views::Made;
use crate::error::{Error, Result, Warnings};
use crate::glare::geometry::PixelGeometry;
use crate::glare::{Analyser, index};
use crate::kernels::glare::{Additions, Batches, PixelSource, ReadyView, Stack, StackOptions, Year, for_device, year};
use crate::kernels::image_matrix::ImageOptions;
use crate::kernels::sun_matrix::SunMatrix;
use crate::kernels::trace::{TraceStatistics, TracedMatrix};
use crate::kernels::view_matrix;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::metrics::Metric;
use crate::progress::Progress;
use crate::simulate::context::Context;
use crate::simulate::inputs::Inputs;
use crate::simulate::light::Light;
use crate::simulate::multiply::{lit_columns, select_columns};
use crate::simulate::phases::facade_suns::FacadeSuns;
use crate::simulate::phases::pixels::ViewJob;
use crate::simulate::phases::sun_pixels::{Shown, sun_pictures};
use crate::simulate::plan::presets::{daylight_options, image_options, rounds, view_options};
use crate::simulate::project::given::GivenPictures;
use crate::simulate::project::glare::{GlareMethod, GlareSection};
use crate::simulate::project::metrics::Family;
use crate::simulate::project::views::ViewSection;
use crate::simulate::sampling::rounds::{Part, average};
use crate::statistics::student_95;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant;

/// What glare a run computed, for `summary.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GlareSummary {
    /// Method of `[glare]`.
    pub method: String,
    /// Views.
    pub views: usize,
    /// States of the façade.
    pub states: usize,
    /// Hours with light, each computed per view and state.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours: f64,
    /// What found the glare pixels; absent without pictures.
    pub detector: Option<String>,
    /// Seconds for all hours of all views and states, without V and D.
    pub seconds: f64,
    /// sGA, sDG and protection of the views, by state.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub metrics: Vec<Metric>,
}

/// What the glare of a project is computed from.
pub(crate) struct GlareJob<'a> {
    /// The run.
    pub context: Context<'a>,
    /// What it has made before.
    pub made: Made<'a>,
    /// D of each window.
    pub daylight: &'a [Matrix<f32>],
    /// The part of D without diffuse reflection.
    pub daylight_direct: &'a [Matrix<f32>],
    /// Standard errors of D.
    pub daylight_error: &'a [Matrix<f32>],
}

/// The façade as it moves, or in one state for ever.
struct State<'a> {
    /// Empty for the façade as it is.
    name: String,
    inputs: Cow<'a, Inputs>,
    /// What its windows send into the room.
    light: Light,
    /// The suns that are traced through it.
    suns: Option<FacadeSuns>,
    /// Cds of the views' eyes, where methods use them.
    eye_suns: Option<SunMatrix>,
}

impl State<'_> {
    /// What stands behind the names of its files.
    fn behind(&self) -> String {
        if self.name.is_empty() { String::new() } else { format!("@@{}", self.name) }
    }

    /// The eye of the `number`-th view.
    fn eye<'e>(&'e self, eyes: &'e Eyes, number: usize) -> Eye<'e> {
        eyes.of(number, self.eye_suns.as_ref().zip(self.suns.as_ref().map(|s| &s.set)))
    }
}

/// The hours that are computed: lit ones.
struct LitHours {
    /// Numbers in the year.
    hours: Vec<usize>,
    sky: Matrix<f32>,
    /// Sds, where suns are traced.
    suns: Option<Matrix<f32>>,
}

impl GlareJob<'_> {
    /// Computes and writes everything.
    ///
    /// # Errors
    /// Views without directions, failures of device and file system, and when stopped.
    pub fn run(&self, section: &GlareSection, statistics: &mut TraceStatistics, warnings: &mut Warnings) -> Result<GlareSummary> {
        let lit = self.lit_hours();
        let eyes = if section.method == GlareMethod::Image { None } else { Some(self.eyes(statistics)?) };
        if section.method == GlareMethod::Edgps {
            for view in &self.context.project.views {
                self.context.progress.begin(&format!("V of {}, windows", view.name));
                self.windows_only(view, statistics)?;
            }
        }
        let clock = Instant::now();
        let states = self.states(eyes.is_some(), statistics)?;
        let pictured = section.method.has_pictures();
        let detector = if pictured { Some(for_device(self.context.device)?) } else { None };
        let mut years = Vec::new();
        for (number, view) in self.context.project.views.iter().enumerate() {
            let stage = self.context.progress;
            stage.begin(&format!("glare of {}", view.name));
            let found = match (&detector, &eyes) {
                (Some(detector), eyes) => {
                    let analyser = analyser(section, view)?;
                    analyser.doubts().into_iter().for_each(|doubt| warnings.push(doubt.file(&view.file)));
                    if view.given.sun.is_some() {
                        warnings.push(given_disc(view));
                    }
                    let eyes = eyes.as_ref().map(|eyes| (eyes, number));
                    self.pictured(section, view, analyser, &**detector, eyes, &states, &lit, (statistics, stage))?
                }
                (None, Some(eyes)) => {
                    stage.update("glare", 0.0);
                    self.without_pictures(section, view, (eyes, number), &states, &lit, statistics)?
                }
                (None, None) => return Err(Error::new("a method without pictures needs the eyes")),
            };
            for (state, found) in states.iter().zip(found) {
                years.push(self.whole_year(view, state, &lit.hours, found, section));
            }
        }
        let seconds = clock.elapsed().as_secs_f64();
        let weather = &self.context.inputs.weather;
        let steps = weather.steps();
        let lit_hours = steps.hours(lit.hours.len());
        let confidence_95 = student_95(self.freedom(section.method));
        let calendar = tables::Calendar { records: &weather.records, steps, confidence_95 };
        tables::write(self.context.store, section, &calendar, &years, self.context.progress, warnings)?;
        let wanted = self.context.project.metrics.wants(Family::Glare);
        let metrics = if wanted { spatial::metrics(section, &calendar, &years) } else { Vec::new() };
        Ok(GlareSummary {
            method: section.method.name().to_string(),
            views: self.context.project.views.len(),
            states: states.len(),
            hours: lit_hours,
            detector: detector.map(|d| d.description()),
            seconds,
            metrics,
        })
    }

    fn lit_hours(&self) -> LitHours {
        let skies = self.made.skies;
        let hours = lit_columns(&skies.whole);
        let suns = skies.sun.as_ref().map(|sun| select_columns(sun, &hours));
        LitHours { sky: select_columns(&skies.whole, &hours), hours, suns }
    }

    /// Degrees of freedom of the errors: those of the matrix with the fewest independent estimates.
    fn freedom(&self, method: GlareMethod) -> usize {
        let project = self.context.project;
        let eyes = rounds(project) as usize * (view_options(project, self.context.inputs, 0).batches as usize - 1);
        let daylight = daylight_options(project, self.context.inputs, 0, 0).batches as usize - 1;
        let pictures = image_options(self.context.project, self.context.inputs, self.context.choice.phases).batches as usize - 1;
        match method {
            GlareMethod::Image => pictures.min(daylight),
            GlareMethod::Edgps => pictures.min(daylight).min(eyes),
            GlareMethod::Dgps | GlareMethod::Imageless => eyes.min(daylight),
        }
    }

    /// Matrices of sensors at the views' points that face as the views look.
    fn eyes(&self, statistics: &mut TraceStatistics) -> Result<Eyes> {
        Ok(Eyes { view: self.eyes_view(statistics)? })
    }

    fn eyes_view(&self, statistics: &mut TraceStatistics) -> Result<TracedMatrix> {
        let sensors = self.context.project.views.iter().map(ViewSection::eye).collect::<Result<Vec<_>>>()?;
        let rounds = rounds(self.context.project);
        let mut inputs = self.context.view_fingerprint("V of eyes");
        inputs.add(&sensors).add(&view_options(self.context.project, self.context.inputs, 0)).add(&rounds);
        let shape = (sensors.len(), self.context.inputs.bins(), 3);
        let load = |suffix: &str| self.context.store.load(&format!("glare_eyes{suffix}"), inputs, shape);
        if let (Some(total), Some(direct), Some(standard_error)) = (load(""), load("_direct"), load("_standard_error")) {
            return Ok(TracedMatrix { total, direct, standard_error, batches: Vec::new(), statistics: TraceStatistics::default() });
        }
        let windows = self.context.inputs.geometry();
        let traced = average(rounds, self.context.progress, |round, progress| {
            let options = view_options(self.context.project, self.context.inputs, round);
            view_matrix::compute(self.context.device, &self.context.inputs.scene, &windows, &sensors, &options, progress)
        })?;
        statistics.add(traced.statistics);
        let about = "view matrix of the views' eyes, rows views, columns the windows' bins";
        self.context.store.save("glare_eyes_direct", &traced.direct, inputs, about)?;
        self.context.store.save("glare_eyes_standard_error", &traced.standard_error, inputs, about)?;
        self.context.store.save("glare_eyes", &traced.total, inputs, about)?;
        Ok(traced)
    }

    /// Computes the view matrix of a view as a picture of the windows alone.
    fn windows_only(&self, view: &ViewSection, statistics: &mut TraceStatistics) -> Result<()> {
        let options =
            ImageOptions { bounces: Some(0), ..image_options(self.context.project, self.context.inputs, self.context.choice.phases) };
        let inputs = *self.context.view_fingerprint("V of pictures").add(&view.raster()?).add(&options);
        let view = ViewSection { name: windows_only_name(view), given: GivenPictures::default(), ..view.clone() };
        let windows = self.context.inputs.geometry();
        let job = ViewJob { context: self.context, windows: &windows, view: &view, options, refinement: 1 };
        job.matrix(inputs, statistics).map(|_| ())
    }

    /// Lit hours of one view from its view matrix, for every state.
    #[allow(clippy::too_many_arguments, reason = "what a view shares with the others")]
    fn pictured(
        &self,
        section: &GlareSection,
        view: &ViewSection,
        analyser: Arc<Analyser>,
        detector: &dyn crate::kernels::glare::Detector,
        eyes: Option<(&Eyes, usize)>,
        states: &[State<'_>],
        lit: &LitHours,
        (statistics, progress): (&mut TraceStatistics, &dyn Progress),
    ) -> Result<Vec<Vec<Hour>>> {
        let name = if eyes.is_some() { windows_only_name(view) } else { view.name.clone() };
        let path = |suffix: &str| self.context.store.matrix_path(&format!("V_{name}{suffix}"));
        let is_split = states.iter().any(|s| s.light.is_split());
        let shown = Shown::Picture(view.raster()?);
        let mut source = match is_split {
            false => PictureView::open_matrix(&path(""), None)?,
            true => PictureView::open_split(&path(""), &path("_direct"))?,
        };
        let options = StackOptions { veil: section.veil, dark_pixels: is_split, ..StackOptions::default() };
        let stack = Stack::new(analyser, vec![&mut source as &mut dyn PixelSource], options)?;
        let batches = Batches::new(&stack, &read_matrix(&path("_batches"))?.matrix)?;
        let ready = ReadyView::new(detector, &stack)?;
        let mut all = Vec::new();
        for (number, state) in states.iter().enumerate() {
            let suns = state.suns.as_ref().filter(|_| is_split);
            let context = Context { inputs: &state.inputs, ..self.context };
            let suns = suns.map(|suns| sun_pictures(&context, suns, view, &shown, &lit.hours, &state.behind(), statistics)).transpose()?;
            let suns = suns.map(|pictures| SunLight { pictures, hours: &lit.hours });
            let eye = eyes.map(|(eyes, number)| state.eye(eyes, number));
            let given = eye.map(|eye| eye.illuminance(&state.light));
            let noise = self.noise(state, lit, eye);
            let rights = [&state.light.right];
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

    fn noise<'n>(&'n self, state: &'n State<'_>, lit: &'n LitHours, eye: Option<Eye<'n>>) -> MatrixNoise<'n> {
        let suns = lit.suns.as_ref().map(|patches| SunNoise {
            patches,
            hours: &lit.hours,
            daylight: self.daylight,
            daylight_direct: self.daylight_direct,
        });
        MatrixNoise::new(&state.inputs, self.daylight_error, (&lit.sky, &lit.hours), &state.light, eye, suns)
    }

    /// All hours of the weather file from those with light.
    fn whole_year(&self, view: &ViewSection, state: &State<'_>, lit: &[usize], found: Vec<Hour>, section: &GlareSection) -> ViewYear {
        let dark = match section.method {
            GlareMethod::Dgps => index::dgps(0.0),
            _ => section.settings.dgp.dgp(0.0, 0.0),
        };
        let dark = Hour { dgp: dark, standard_error: 0.0, illuminance: 0.0, sources: 0 };
        let mut hours = vec![dark; self.made.skies.whole.cols()];
        let mut is_lit = vec![false; self.made.skies.whole.cols()];
        for (&hour, glare) in lit.iter().zip(found) {
            hours[hour] = glare;
            is_lit[hour] = true;
        }
        ViewYear { view: view.name.clone(), state: state.name.clone(), hours, is_lit }
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
