//! Glare of views without pictures: the light at the eye, and the patches of the sky that it sees.

use super::eyes::{Eye, Eyes, ImagelessSources, frame_of};
use super::sunlight::SunLight;
use super::tables::Hour;
use super::{GlareJob, LitHours, State};
use crate::control::State as StateNumber;
use crate::error::Result;
use crate::glare::geometry::ViewFrame;
use crate::glare::{Disc, index};
use crate::kernels::glare::{Additions, HourNoise};
use crate::kernels::trace::TraceStatistics;
use crate::simulate::context::Context;
use crate::simulate::inputs::Inputs;
use crate::simulate::light::{Daylight, WindowLight, transmitted};
use crate::simulate::phases::sun_pixels::{Shown, sun_pictures};
use crate::simulate::project::glare::{GlareMethod, GlareSection};
use crate::simulate::project::views::ViewSection;
use rayon::prelude::*;
use std::collections::BTreeMap;

impl GlareJob<'_> {
    /// Lit hours of one view without pictures, for every state.
    pub(super) fn without_pictures(
        &self,
        section: &GlareSection,
        view: &ViewSection,
        (eyes, number): (&Eyes, usize),
        states: &[State<'_>],
        lit: &LitHours,
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<Vec<Hour>>> {
        let camera = *view.raster()?.camera();
        let wanted = section.method == GlareMethod::Imageless && lit.suns.is_some() && states.iter().any(|s| s.light.is_split());
        let shown = Shown::Discs(camera);
        let frame = frame_of(camera.view()).map_err(|e| e.file(&view.file))?;
        let mut of_state = |state: &State<'_>| {
            let suns = state.suns.as_ref().filter(|_| wanted);
            let context = Context { inputs: &state.inputs, ..self.context };
            let suns = suns.map(|suns| sun_pictures(&context, suns, view, &shown, &lit.hours, &state.behind(), statistics)).transpose()?;
            let suns = suns.map(|pictures| SunLight { pictures, hours: &lit.hours });
            self.year_without_pictures(section, &frame, &state.eye(eyes, number), state, suns.as_ref(), lit)
        };
        states.iter().map(&mut of_state).collect()
    }

    /// Lit hours of a façade: those of each combination of states together, which have their patches in common.
    fn year_without_pictures(
        &self,
        section: &GlareSection,
        frame: &ViewFrame,
        eye: &Eye<'_>,
        state: &State<'_>,
        suns: Option<&SunLight<'_>>,
        lit: &LitHours,
    ) -> Result<Vec<Hour>> {
        if section.method != GlareMethod::Imageless {
            let all: Vec<usize> = (0..lit.hours.len()).collect();
            return self.hours_without_pictures(section, eye, state, None, suns, (lit, &all));
        }
        let schedule = &state.inputs.schedule;
        let mut combinations: BTreeMap<Vec<StateNumber>, Vec<usize>> = BTreeMap::new();
        for (column, hour) in lit.hours.iter().enumerate() {
            combinations.entry(schedule.of_step(*hour)).or_default().push(column);
        }
        let mut year: Vec<Option<Hour>> = vec![None; lit.hours.len()];
        for (states, columns) in combinations {
            let inputs = if state.inputs.moves() { &state.inputs.in_states(&states) } else { &*state.inputs };
            let sources = self.sources(frame, eye, inputs, lit, section)?;
            let found = self.hours_without_pictures(section, eye, state, Some(&sources), suns, (lit, &columns))?;
            columns.iter().zip(found).for_each(|(column, hour)| year[*column] = Some(hour));
        }
        Ok(year.into_iter().flatten().collect())
    }

    /// The sky's patches as sources, seen through windows that do not move.
    fn sources(
        &self,
        frame: &ViewFrame,
        eye: &Eye<'_>,
        inputs: &Inputs,
        lit: &LitHours,
        section: &GlareSection,
    ) -> Result<ImagelessSources> {
        let daylight = Daylight { total: self.daylight, direct: self.daylight_direct };
        let transmissions = inputs.transmissions();
        let lights = WindowLight::of(inputs, &transmissions, daylight);
        let direct_of = |counts: &dyn Fn(usize) -> bool| {
            let passage = |i: usize| counts(i).then(|| (transmissions[i], &self.daylight_direct[i]));
            transmitted(&lights, &(0..inputs.windows.len()).map(passage).collect::<Vec<_>>())
        };
        let direct = direct_of(&|_| true)?;
        let traced = lit.suns.is_some().then(|| direct_of(&|i| inputs.windows[i].is_sunny())).transpose()?;
        let windows = inputs.windows.iter().flat_map(|w| &w.parts);
        Ok(ImagelessSources::new(frame, eye, windows, self.context.sky(), &direct, traced.as_ref(), &section.settings))
    }

    /// These of the lit hours.
    fn hours_without_pictures(
        &self,
        section: &GlareSection,
        eye: &Eye<'_>,
        state: &State<'_>,
        sources: Option<&ImagelessSources>,
        suns: Option<&SunLight<'_>>,
        (lit, columns): (&LitHours, &[usize]),
    ) -> Result<Vec<Hour>> {
        let lux = eye.illuminance(&state.light);
        let noise = self.noise(state, lit, Some(*eye));
        let none = vec![0.0; self.context.inputs.bins() * 3];
        let (settings, model) = (&section.settings, section.settings.dgp);
        let hours = columns.par_iter().map(|&hour| {
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
