//! The best states of the groups that are optimal, together.

use super::super::states::{LightOfState, StateLight};
use super::glare::DgpOfStates;
use super::groups::{fault_of, plans};
use crate::control::optimum::{self, Aim, Lights, Limit, Marginal, Optimum, Problem};
use crate::control::{Facade, Schedule, State};
use crate::error::{Error, Result};
use crate::metrics::{glare, lm83};
use crate::simulate::context::Context;
use crate::simulate::inputs::counting::Counting;
use crate::simulate::inputs::glare_states::combinations;
use crate::simulate::project::control::Asked;
use crate::simulate::project::optimal::{OptimalSection, Wanted};

/// What is best.
pub(crate) struct Best {
    /// The groups that are optimal, in the order of the façade.
    pub groups: Vec<usize>,
    /// What was found.
    pub optimum: Optimum,
    /// What states and groups are worth; nothing of fewest moves.
    pub worth: Vec<Marginal>,
}

/// Light of the groups that are optimal; the others as they are set. Channels: illuminance of the sensors of the plan and
/// of the eyes, and where it counts the direct sun on the plan.
struct GroupLights<'a> {
    light: &'a StateLight,
    schedule: &'a Schedule,
    groups: &'a [usize],
    /// Rows of the sensors of the plan, then of the eyes.
    rows: Vec<usize>,
    /// How many of them are of the plan.
    plan: usize,
    has_sun: bool,
    /// The views whose DGP is limited, and all combinations of the groups.
    glare: &'a DgpOfStates,
    views: Vec<usize>,
    combinations: Vec<Vec<State>>,
}

impl GroupLights<'_> {
    fn channels(&self) -> usize {
        self.rows.len() + if self.has_sun { self.plan } else { 0 }
    }

    fn add(&self, of: &LightOfState, step: usize, values: &mut [f64]) {
        let (lux, sun) = values.split_at_mut(self.rows.len());
        lux.iter_mut().zip(&self.rows).for_each(|(value, row)| *value += f64::from(of.lux.at(*row, step)[0]).max(0.0));
        if let Some(of) = &of.sun {
            sun.iter_mut().zip(&self.rows).for_each(|(value, row)| *value += f64::from(of.at(*row, step)[0]));
        }
    }
}

impl Lights for GroupLights<'_> {
    fn fill(&self, step: usize, values: &mut [f64]) {
        values.fill(0.0);
        let wholes = values.len() - self.combinations.len() * self.views.len();
        let (sums, wholes) = values.split_at_mut(wholes);
        let (fixed, moving) = sums.split_at_mut(self.channels());
        let others = (0..self.schedule.groups()).filter(|g| !self.groups.contains(g)).map(|g| (g, self.schedule.at(g, step)));
        self.light.parts(others).for_each(|part| self.add(part, step, fixed));
        let states = self.groups.iter().flat_map(|g| &self.light.groups[*g]);
        states.zip(moving.chunks_mut(self.channels())).for_each(|(state, place)| self.add(state, step, place));
        for (own, place) in self.combinations.iter().zip(wholes.chunks_mut(self.views.len().max(1))) {
            let mut all = self.schedule.of_step(step);
            self.groups.iter().zip(own).for_each(|(group, state)| all[*group] = *state);
            place.iter_mut().zip(&self.views).for_each(|(value, view)| *value = self.glare.of(*view, step, &all));
        }
    }
}

/// Finds the best states of the groups that are optimal, where there are any.
pub(super) fn best_states(
    context: &Context<'_>,
    counting: &Counting,
    light: &StateLight,
    glare: &DgpOfStates,
    schedule: &mut Schedule,
) -> Result<Option<Best>> {
    let (control, facade) = (&context.project.control, &context.inputs.facade);
    let is_optimal = |g: &usize| control.of_group(*g).is_some_and(|c| c.asked == Asked::Optimal);
    let groups: Vec<usize> = (0..facade.groups().len()).filter(is_optimal).collect();
    let Some(first) = groups.first() else { return Ok(None) };
    let section = &control.optimal;
    let fault = |message: &str, help: &str| fault_of(context, *first, Error::new(message).help(help));
    let plan: Vec<usize> = plans(context, section.eyes.as_deref()).concat();
    if plan.is_empty() {
        return Err(fault("no sensor faces up: nothing tells how bright it is", "add [[sensors]] of the work plane"));
    }
    let has_sun = section.sunlit.is_some();
    if has_sun && context.choice.phases != 5 {
        return Err(fault(
            "'sunlit' of [optimal] looks at direct sun, but no sun is traced",
            "write phases = 5 with states that the sun is traced through, or take 'sunlit' out",
        ));
    }
    let eyes = eyes(context, section);
    let mut limits = limits(section, plan.len(), eyes.len());
    let views: Vec<usize> = (0..context.project.views.len()).filter(|v| section.looks_from(&context.project.views[*v].name)).collect();
    limits.extend(section.dgp.iter().flat_map(|limit| (0..views.len()).map(|number| Limit::Whole { number, limit: *limit })));
    let (sensors, rows) = (plan.len(), [plan, eyes].concat());
    let states: Vec<Vec<State>> = groups.iter().map(|g| (0..facade.groups()[*g].states.len() as State).collect()).collect();
    let combinations = if views.is_empty() { Vec::new() } else { combinations(&states).unwrap_or_default() };
    let wholes = views.len();
    let lights = GroupLights { light, schedule, groups: &groups, rows, plan: sensors, has_sun, glare, views, combinations };
    let own = Facade::new(groups.iter().map(|g| facade.groups()[*g].clone()).collect())?;
    let problem = Problem {
        states: own.groups().iter().map(|g| g.states.len()).collect(),
        sensors,
        channels: lights.channels(),
        wholes,
        limits,
        aim: match section.aim {
            Wanted::Daylight | Wanted::Moves => Aim::Daylight,
            Wanted::Lighting => Aim::Lighting { target: section.target, least: section.least_power },
        },
        most_visits: Problem::EXACT,
    };
    let steps = schedule.steps();
    let optimum = match section.aim {
        Wanted::Moves => optimum::fewest_moves(&problem, &own, &lights, steps).map_err(|e| fault_of(context, *first, e))?,
        _ => optimum::optimum(&problem, &own, &lights, steps)?,
    };
    context.check_stop()?;
    // What a state is worth is told of the best of each step.
    let worth = match section.aim {
        Wanted::Moves => Vec::new(),
        _ => optimum::marginal(&problem, &own, &lights, &optimum, &counting.occupied.mask(steps)),
    };
    let states = (0..facade.groups().len()).map(|g| match groups.iter().position(|own| *own == g) {
        Some(own) => optimum.schedule.of_group(own).to_vec(),
        None => schedule.of_group(g).to_vec(),
    });
    *schedule = Schedule::new(facade, steps, states.collect())?;
    Ok(Some(Best { groups, optimum, worth }))
}

/// Rows of the sensors at eyes.
fn eyes(context: &Context<'_>, section: &OptimalSection) -> Vec<usize> {
    let mut first = 0;
    for group in &context.inputs.sensors {
        if section.eyes.as_deref() == Some(group.name.as_str()) {
            return (first..first + group.sensors.len()).collect();
        }
        first += group.sensors.len();
    }
    Vec::new()
}

fn limits(section: &OptimalSection, plan: usize, eyes: usize) -> Vec<Limit> {
    let mut limits: Vec<Limit> =
        (plan..plan + eyes).map(|channel| Limit::Most { channel, limit: glare::vertical_lux(section.dgps) }).collect();
    limits.extend(section.most.map(|above| Limit::Share { channels: 0..plan, above, share: 0.0 }));
    let sun = plan + eyes..2 * plan + eyes;
    limits.extend(section.sunlit.map(|share| Limit::Share { channels: sun, above: lm83::SUN_LX, share }));
    limits
}
