//! Pictures of a run, and what glare makes of them.

use super::Run;
use crate::error::{Error, Result, Warnings};
use crate::kernels::product;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::simulate::five_phase::{FivePhase, add_scattering_data, is_sunny, transmitted_where};
use crate::simulate::glare::{FiveGlare, GlareJob, GlareSummary};
use crate::simulate::glare_section::GlareMethod;
use crate::simulate::multiply::lit_columns;
use crate::simulate::picture_sets;
use crate::simulate::presets::image_options;
use crate::simulate::summary::{MatrixSummary, ViewSummary};
use crate::simulate::sun_pictures::{SunPictureJob, SunPictures};
use crate::simulate::suns::SunSet;
use crate::simulate::views::{ImageHours, ViewJob, ViewSection};
use std::time::Instant;

/// What the pictures of all views are multiplied from.
pub(super) struct Product<'a> {
    pub multiplier: &'a dyn product::Multiplier,
    pub transmitted: &'a Matrix<f64>,
    pub sky: &'a Matrix<f32>,
}

impl Run<'_> {
    /// View matrices and pictures of all `[[view]]`s.
    pub(super) fn pictures(
        &mut self,
        product: &Product<'_>,
        five: Option<&FivePhase<'_>>,
        daylight_direct: &[Matrix<f32>],
        warnings: &mut Warnings,
    ) -> Result<Vec<ViewSummary>> {
        let Product { multiplier, transmitted, sky } = *product;
        let windows: Vec<_> = self.inputs.windows.iter().map(|w| w.window.clone()).collect();
        let mut summaries = Vec::new();
        // Other ways to glare need no pictures of everything.
        let needless = self.project.glare.as_ref().is_some_and(|g| g.method != GlareMethod::Image);
        if needless && self.project.images.hours == ImageHours::None {
            return Ok(summaries);
        }
        for view in &self.project.views {
            let clock = Instant::now();
            self.check_stop()?;
            let options = image_options(self.project);
            let job = ViewJob {
                device: self.device,
                scene: &self.inputs.scene,
                windows: &windows,
                view,
                options,
                store: self.store,
                progress: self.progress,
            };
            let mut inputs = self.view_fingerprint("V of pictures");
            inputs.add(&view.raster()?).add(&options);
            let mut statistics = TraceStatistics::default();
            let (rows, columns, reused) = job.matrix(inputs, &mut statistics)?;
            let seconds = clock.elapsed().as_secs_f64();
            self.matrices.push(MatrixSummary { name: format!("V_{}", view.name), rows, columns, reused, seconds, rounds: None });
            self.count(statistics, clock);
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
                suns = Some(self.sun_pictures(five.suns(), view, &needed, &mut statistics)?);
                self.count(statistics, clock);
            }
            if components {
                picture_sets::export(self.store, &view.name, five.map(FivePhase::suns).zip(suns.as_ref()))?;
            }
            let transmissions: Vec<&Matrix<f64>> = self.inputs.windows.iter().map(|w| &w.transmission).collect();
            let shaded = transmitted_where(self.inputs, &transmissions, daylight_direct, &is_sunny)?;
            let five = five.zip(suns.as_ref()).map(|(five, suns)| (five, &shaded, suns));
            let pictures = job.pictures(multiplier, transmitted, sky, &hours, five, warnings)?;
            summaries.push(ViewSummary { name: view.name.clone(), pixels: rows, pictures });
        }
        Ok(summaries)
    }

    /// What the suns of these hours put into the pictures of a view.
    fn sun_pictures(&self, suns: &SunSet, view: &ViewSection, hours: &[usize], statistics: &mut TraceStatistics) -> Result<SunPictures> {
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
        job.compute(view, &view.raster()?, hours, inputs, statistics)
    }

    /// Annual glare of all views, if the project asks for it.
    pub(super) fn glare(
        &mut self,
        multiplier: &dyn product::Multiplier,
        [daylight, daylight_direct, daylight_error]: [&[Matrix<f32>]; 3],
        sky: &Matrix<f32>,
        five: Option<&FivePhase<'_>>,
        warnings: &mut Warnings,
    ) -> Result<Option<GlareSummary>> {
        let Some(section) = &self.project.glare else { return Ok(None) };
        let mut statistics = TraceStatistics::default();
        let five = five.map(|terms| (terms, self.scene_fingerprint("C")));
        let pictures = |view: &ViewSection, hours: &[usize], statistics: &mut TraceStatistics| {
            let Some((terms, _)) = &five else { return Err(Error::new("suns are traced by five phases only")) };
            self.sun_pictures(terms.suns(), view, hours, statistics)
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
