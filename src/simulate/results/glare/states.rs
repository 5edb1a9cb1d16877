//! The façades whose glare is computed: as it moves, and its states alone.

use super::{GlareJob, State as Facade, analyser};
use crate::control::State;
use crate::error::{Error, Result};
use crate::kernels::glare::for_device;
use crate::kernels::trace::TraceStatistics;
use crate::simulate::context::Context;
use crate::simulate::inputs::{Inputs, SensorGroup};
use crate::simulate::light::{Daylight, Light};
use crate::simulate::phases::facade_suns::FacadeSuns;
use crate::simulate::phases::sun::SunEntry;
use crate::simulate::project::glare::{GlareMethod, GlareSection};
use crate::simulate::project::views::ViewSection;
use std::borrow::Cow;

impl GlareJob<'_> {
    /// DGP of some views with the façade in each of these states for ever, `[view][states][step]`, for what decides between
    /// them. V of pictures of everything must be there.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn dgp_of_states(
        &self,
        section: &GlareSection,
        views: &[usize],
        states: &[Vec<State>],
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<Vec<Vec<f64>>>> {
        let (inputs, project) = (self.context.inputs, self.context.project);
        let lit = self.lit_hours();
        let eyes = if section.method == GlareMethod::Image { None } else { Some(self.eyes(statistics)?) };
        let facade = |states: &Vec<State>| {
            let names = states.iter().zip(inputs.facade.groups()).map(|(state, group)| group.states[usize::from(*state)].as_str());
            (format!("control@{}", names.collect::<Vec<_>>().join("@")), Cow::Owned(inputs.in_states(states)))
        };
        let states = self.states_of(states.iter().map(facade).collect(), eyes.is_some(), statistics)?;
        let detector = if section.method.has_pictures() { Some(for_device(self.context.device)?) } else { None };
        let mut all = Vec::new();
        for &number in views {
            let view = &project.views[number];
            let found = match (&detector, &eyes) {
                (Some(detector), eyes) => {
                    if eyes.is_some() {
                        self.windows_only(view, statistics)?;
                    }
                    let eyes = eyes.as_ref().map(|eyes| (eyes, number));
                    let progress = (&mut *statistics, self.context.progress);
                    self.pictured(section, view, analyser(section, view)?, &**detector, eyes, &states, &lit, progress)?
                }
                (None, Some(eyes)) => self.without_pictures(section, view, (eyes, number), &states, &lit, statistics)?,
                (None, None) => return Err(Error::new("a method without pictures needs the eyes")),
            };
            let of_states = states
                .iter()
                .zip(found)
                .map(|(state, found)| self.whole_year(view, state, &lit.hours, found, section).hours.iter().map(|hour| hour.dgp).collect());
            all.push(of_states.collect());
        }
        Ok(all)
    }

    /// The façade as it moves, and each of its states alone; without `[control]` these are all, if there are any.
    fn facades(&self) -> Vec<(String, Cow<'_, Inputs>)> {
        let (inputs, project) = (self.context.inputs, self.context.project);
        let alone = inputs.states_alone(project);
        let moving = (project.control.is_given || alone.is_empty()).then_some((String::new(), Cow::Borrowed(inputs)));
        let alone = alone.into_iter().map(|(name, states)| (name, Cow::Owned(inputs.in_states(&states))));
        moving.into_iter().chain(alone).collect()
    }

    /// What every state of the façade lets in.
    pub(super) fn states(&self, has_eyes: bool, statistics: &mut TraceStatistics) -> Result<Vec<Facade<'_>>> {
        self.states_of(self.facades(), has_eyes, statistics)
    }

    fn states_of<'f>(
        &'f self,
        facades: Vec<(String, Cow<'f, Inputs>)>,
        has_eyes: bool,
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<Facade<'f>>> {
        let project = self.context.project;
        let daylight = Daylight { total: self.daylight, direct: self.daylight_direct };
        let mut states = Vec::new();
        for (name, inputs) in facades {
            let light = Light::of_facade(&inputs, daylight, self.made.multiplier, self.made.skies)?;
            let suns = match self.made.suns {
                Some(traced) if name.is_empty() => Some(traced.facade.clone()),
                _ if self.context.choice.phases == 5 => Some(FacadeSuns::new(&inputs, project)?),
                _ => None,
            };
            let mut state = Facade { name, inputs, light, suns, eye_suns: None };
            if let (true, Some(suns), Some(_)) = (has_eyes, &state.suns, &self.made.skies.sun) {
                let sensors = project.views.iter().map(ViewSection::eye).collect::<Result<Vec<_>>>()?;
                let group = SensorGroup { name: "glare_eyes".into(), file: project.file.clone(), sensors, view: None, sun: None };
                let context = Context { inputs: &state.inputs, ..self.context };
                let (matrix, traced) = suns.matrix(&context, &[group], SunEntry::Windows, &state.behind())?;
                if traced {
                    statistics.add(matrix.statistics);
                }
                state.eye_suns = Some(matrix);
            }
            states.push(state);
        }
        // Pictures are split for all of them, or for none.
        if states.iter().any(|s| s.light.is_split()) {
            states.iter_mut().for_each(|s| s.light.split());
        }
        Ok(states)
    }
}
