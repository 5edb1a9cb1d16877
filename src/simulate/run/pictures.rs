//! Pictures of a run. Where a target error is given, a view is sampled again if the light at its eye
//! turns out to be known less well.

use super::Run;
use crate::error::{Error, Result, Warnings};
use crate::kernels::product::Multiplier;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::scene::Window;
use crate::simulate::estimate::Estimate;
use crate::simulate::fingerprint::Fingerprint;
use crate::simulate::five_phase::{FivePhase, add_scattering_data, is_sunny, transmitted_where};
use crate::simulate::glare::{FiveGlare, GlareJob, GlareSummary};
use crate::simulate::glare_section::GlareMethod;
use crate::simulate::multiply::lit_columns;
use crate::simulate::picture_sets;
use crate::simulate::presets::image_options;
use crate::simulate::summary::{MatrixSummary, ViewSummary};
use crate::simulate::sun_pictures::{Shown, SunPictureJob, SunPictures};
use crate::simulate::suns::SunSet;
use crate::simulate::uncertainty::Chain;
use crate::simulate::views::{ImageHours, ViewJob, ViewSection};
use std::time::Instant;

/// Share of the target's square that the noise of a picture's view matrix may take; the rest is D's.
pub(super) const SHARE_OF_VIEW: f64 = 0.64;
/// Samples for a target, as a multiple of the standard ones, at most.
const MOST_SAMPLES: f64 = 16.0;

/// What the pictures of all views are multiplied from.
pub(super) struct ProductOfPictures<'a> {
    pub multiplier: &'a dyn Multiplier,
    pub transmitted: &'a Matrix<f64>,
    pub sky: &'a Matrix<f32>,
    /// D of each window, with its noise.
    pub daylight: &'a [Estimate],
}

/// Relative standard error of a year's light at the eye of a view.
#[derive(Debug, Clone, Copy)]
struct EyeError {
    /// By the noise of the picture's view matrix.
    view: f64,
    /// By that and D's.
    all: f64,
}

impl Run<'_> {
    /// View matrices and pictures of all `[[view]]`s.
    pub(super) fn pictures(
        &mut self,
        product: &ProductOfPictures<'_>,
        five: Option<&FivePhase<'_>>,
        daylight_direct: &[Matrix<f32>],
        warnings: &mut Warnings,
    ) -> Result<Vec<ViewSummary>> {
        let ProductOfPictures { multiplier, transmitted, sky, .. } = *product;
        let windows: Vec<_> = self.inputs.windows.iter().map(|w| w.window.clone()).collect();
        let mut summaries = Vec::new();
        // Other ways to glare need no pictures of everything.
        let needless = self.project.glare.as_ref().is_some_and(|g| g.method != GlareMethod::Image);
        if needless && self.project.images.hours == ImageHours::None {
            return Ok(summaries);
        }
        // What sampling for a target depends on.
        let asked = self.project.quality.target_error.map(|target| {
            let mut asked = Fingerprint::new("sampled for a target");
            asked.add(&target).add(&product.sky.data()).add(&product.transmitted.data());
            asked.to_string()
        });
        for view in &self.project.views {
            let eye_error = self.view_matrix(product, view, &windows, asked.as_deref())?;
            self.warn_of_view(view, eye_error, warnings);
            let hours = self.project.images.hours.chosen(sky)?;
            let components = self.project.images.components;
            let mut suns = None;
            if let Some(five) = five
                && self.inputs.windows.iter().any(is_sunny)
                && (!hours.is_empty() || components)
            {
                let clock = Instant::now();
                let mut statistics = TraceStatistics::default();
                // The suns of all hours at once, if glare or their pictures will need them.
                let glare = self.project.glare.as_ref().is_some_and(|g| g.method.has_pictures());
                let needed = if glare || components { lit_columns(sky) } else { hours.clone() };
                suns = Some(self.sun_pictures(five.suns(), view, &Shown::Picture(view.raster()?), &needed, &mut statistics)?);
                self.count(statistics, clock);
            }
            if components {
                picture_sets::export(self.store, &view.name, five.map(FivePhase::suns).zip(suns.as_ref()))?;
            }
            let transmissions: Vec<&Matrix<f64>> = self.inputs.windows.iter().map(|w| &w.transmission).collect();
            let shaded = transmitted_where(self.inputs, &transmissions, daylight_direct, &is_sunny)?;
            let five = five.zip(suns.as_ref()).map(|(five, suns)| (five, &shaded, suns));
            let job = self.view_job(view, &windows, 1);
            let pictures = job.pictures(multiplier, transmitted, sky, &hours, five, warnings)?;
            let pixels = view.raster()?.len();
            summaries.push(ViewSummary { name: view.name.clone(), pixels, pictures, eye_error: eye_error.map(|e| e.all) });
        }
        Ok(summaries)
    }

    fn view_job<'j>(&'j self, view: &'j ViewSection, windows: &'j [Window], refinement: u32) -> ViewJob<'j> {
        let (device, scene, store, progress) = (self.device, &self.inputs.scene, self.store, self.progress);
        ViewJob { device, scene, windows, view, options: image_options(self.project), refinement, store, progress }
    }

    /// The view matrix, good enough for the target if there is one, and how well the light at the eye is
    /// known; nothing for a view without directions.
    fn view_matrix(
        &mut self,
        product: &ProductOfPictures<'_>,
        view: &ViewSection,
        windows: &[Window],
        asked: Option<&str>,
    ) -> Result<Option<EyeError>> {
        let clock = Instant::now();
        self.check_stop()?;
        let mut inputs = self.view_fingerprint("V of pictures");
        inputs.add(&view.raster()?).add(&image_options(self.project));
        let target = self.project.quality.target_error;
        let refined = *inputs.clone().add(&asked);
        let mut statistics = TraceStatistics::default();
        let job = self.view_job(view, windows, 1);
        let (rows, columns, reused, error) = match job.kept(refined)? {
            Some((rows, columns)) if target.is_some() => (rows, columns, true, self.eye_error(product, &job)?),
            _ => {
                let (rows, columns, reused) = job.matrix(inputs, &mut statistics)?;
                let error = self.eye_error(product, &job)?;
                let allowed = target.map(|t| t * SHARE_OF_VIEW.sqrt());
                match (error, allowed) {
                    (Some(error), Some(allowed)) if error.view > allowed => {
                        // A quarter more: the error is itself known from a few batches only.
                        let more = (1.25 * (error.view / allowed).powi(2)).ceil().min(MOST_SAMPLES);
                        let job = self.view_job(view, windows, more as u32);
                        let (rows, columns, reused) = job.matrix(refined, &mut statistics)?;
                        (rows, columns, reused, self.eye_error(product, &job)?)
                    }
                    (error, _) => (rows, columns, reused, error),
                }
            }
        };
        let seconds = clock.elapsed().as_secs_f64();
        self.matrices.push(MatrixSummary { name: format!("V_{}", view.name), rows, columns, reused, seconds, rounds: None });
        self.count(statistics, clock);
        Ok(error)
    }

    /// How well a year's light at the eye is known, from the batches of the view matrix and of D. Suns
    /// that five phases trace are left out.
    fn eye_error(&self, product: &ProductOfPictures<'_>, job: &ViewJob<'_>) -> Result<Option<EyeError>> {
        let path = job.batches_path();
        if !path.is_file() {
            return Ok(None);
        }
        let sums = read_matrix(&path)?.matrix;
        let batches = job.options.batches as usize;
        // The first row of each batch is that of the light at the eye.
        let rows = sums.rows() / batches;
        let row = |batch: usize| Matrix::from_data(1, sums.cols(), 3, sums.row(batch * rows).to_vec());
        let replicates = (0..batches).map(row).collect::<Result<Vec<_>>>()?;
        let view = Estimate { straight: Vec::new(), replicates, rounds: 1, rays: 0 };
        let chain = Chain { inputs: self.inputs, view: &view, daylight: product.daylight, sky: product.sky, sun: None };
        let Some(year) = chain.annual().into_iter().next().filter(|y| y.value > 0.0) else { return Ok(None) };
        let relative = |variance: f64| variance.sqrt() / year.value;
        Ok(Some(EyeError { view: relative(year.by_source[0]), all: relative(year.by_source.iter().sum()) }))
    }

    fn warn_of_view(&self, view: &ViewSection, error: Option<EyeError>, warnings: &mut Warnings) {
        let (Some(error), Some(target)) = (error, self.project.quality.target_error) else { return };
        if error.all > target {
            let message = format!(
                "the standard error of a year's light at the eye of view '{}' is {:.2} %, more than the target error of {:.2} %",
                view.name,
                100.0 * error.all,
                100.0 * target
            );
            let help = match self.project.quality.time_limit {
                Some(_) => "give it more time, or leave time_limit out",
                None => "the target is finer than pictures are sampled for; take a larger one",
            };
            warnings.push(Error::new(message).file(&self.project.file).field("quality").help(help));
        }
    }

    /// What the suns of these hours put into the pictures of a view.
    fn sun_pictures(
        &self,
        suns: &SunSet,
        view: &ViewSection,
        shown: &Shown,
        hours: &[usize],
        statistics: &mut TraceStatistics,
    ) -> Result<SunPictures> {
        let job = SunPictureJob {
            device: self.device,
            project: self.project,
            inputs: self.inputs,
            suns,
            store: self.store,
            progress: self.progress,
        };
        let mut inputs = self.scene_fingerprint("C of pictures");
        for window in &self.inputs.windows {
            inputs.add(&(&window.window.triangles, &window.window.frame)).add(&window.shade);
        }
        add_scattering_data(self.project, &mut inputs)?;
        job.compute(view, shown, hours, inputs, statistics)
    }

    /// Annual glare of all views, if the project asks for it.
    pub(super) fn glare(
        &mut self,
        multiplier: &dyn Multiplier,
        [daylight, daylight_direct, daylight_error]: [&[Matrix<f32>]; 3],
        sky: &Matrix<f32>,
        five: Option<&FivePhase<'_>>,
        warnings: &mut Warnings,
    ) -> Result<Option<GlareSummary>> {
        let Some(section) = &self.project.glare else { return Ok(None) };
        let mut statistics = TraceStatistics::default();
        let five = five.map(|terms| (terms, self.scene_fingerprint("C")));
        let pictures = |view: &ViewSection, shown: &Shown, hours: &[usize], statistics: &mut TraceStatistics| {
            let Some((terms, _)) = &five else { return Err(Error::new("suns are traced by five phases only")) };
            self.sun_pictures(terms.suns(), view, shown, hours, statistics)
        };
        let job = GlareJob {
            device: self.device,
            project: self.project,
            inputs: self.inputs,
            store: self.store,
            progress: self.progress,
            daylight,
            daylight_direct,
            daylight_error,
            sky,
            view_inputs: &|kind| self.view_fingerprint(kind),
            five: five.map(|(terms, sun_inputs)| FiveGlare { terms, sun_inputs, sun_pictures: &pictures }),
        };
        let summary = job.run(section, multiplier, &mut statistics, warnings)?;
        self.statistics.add(statistics);
        Ok(Some(summary))
    }
}
