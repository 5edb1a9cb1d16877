//! Glare of views without pictures: the light at the eye, and the patches of the sky that it sees.

use super::eyes::{Eye, ImagelessSources, frame_of};
use super::sunlight::SunLight;
use super::tables::Hour;
use super::{GlareJob, Lit, State};
use crate::error::Result;
use crate::glare::geometry::ViewFrame;
use crate::glare::{Disc, index};
use crate::kernels::glare::{Additions, HourNoise};
use crate::kernels::trace::TraceStatistics;
use crate::simulate::phases::sun_pixels::{Shown, sun_pictures};
use crate::simulate::project::glare::{GlareMethod, GlareSection};
use crate::simulate::project::views::ViewSection;
use rayon::prelude::*;

impl GlareJob<'_> {
    /// Lit hours of one view without pictures, for every state.
    pub(super) fn without_pictures(
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
        let suns = self.made.suns.filter(|_| wanted && states.iter().any(|s| s.light.is_split()));
        let shown = Shown::Discs(camera);
        let suns = suns.map(|suns| sun_pictures(&self.context, &suns.set, view, &shown, &lit.hours, statistics)).transpose()?;
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
        let windows = self.context.inputs.windows.iter().flat_map(|w| &w.parts);
        ImagelessSources::new(frame, eye, windows, self.context.sky(), &state.direct, state.traced.as_ref(), &section.settings)
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
        let lux = eye.illuminance(&state.light);
        let noise = self.noise(state, lit, Some(*eye));
        let none = vec![0.0; self.context.inputs.bins() * 3];
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
}
