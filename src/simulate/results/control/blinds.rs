//! LM-83's blinds: in every hour the groups close in the order that brings the share of sensors with more than 1000 lx of
//! direct sun to 2 % or less.

use super::super::states::StateLight;
use super::super::suns::TracedSuns;
use super::groups::{fault_of, plans};
use crate::control::{Schedule, State};
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::metrics::blinds::{self, Group};
use crate::simulate::context::Context;
use crate::simulate::inputs::ProjectWindow;
use crate::simulate::inputs::counting::Counting;
use crate::simulate::project::control::Asked;

/// What LM-83's blinds did.
pub(crate) struct Operated {
    /// Steps in which more than 2 % of some sensors stay in the sun, rising.
    pub remaining: Vec<usize>,
    /// The suns with the blinds open, at all sensors: what ASE counts.
    pub open_suns: TracedSuns,
    /// Whether all windows have such blinds.
    pub all: bool,
    /// Windows that are not of clear glass with their blinds open.
    pub covered: Vec<String>,
}

/// Moves the blinds of the groups that LM-83 decides, where there are any: a group is closed where it closes for the sensors
/// of any plan.
pub(super) fn lm83_blinds(
    context: &Context<'_>,
    counting: &Counting,
    light: &StateLight,
    schedule: &mut Schedule,
) -> Result<Option<Operated>> {
    let inputs = context.inputs;
    let asked = |c: &crate::simulate::project::control::GroupControl| match c.asked {
        Asked::Lm83 { open, closed } => Some((c.group, open, closed)),
        _ => None,
    };
    let moving: Vec<(usize, State, State)> = context.project.control.groups.iter().filter_map(asked).collect();
    let Some((first, ..)) = moving.first() else { return Ok(None) };
    if context.choice.phases != 5 {
        return Err(fault_of(
            context,
            *first,
            Error::new("LM-83's blinds close for direct sun, but no sun is traced")
                .help("write phases = 5, and give the windows' states glass, a shade or a tensor_tree that the sun is traced through"),
        ));
    }
    let plans = plans(context, None);
    if plans.is_empty() {
        return Err(fault_of(
            context,
            *first,
            Error::new("LM-83's blinds look at sensors that face up, and there are none").help("add [[sensors]] of the work plane"),
        ));
    }
    let is_moving = |g: usize| moving.iter().any(|(group, ..)| *group == g);
    let steps = schedule.steps();
    let mut states: Vec<Vec<State>> = (0..schedule.groups()).map(|g| schedule.of_group(g).to_vec()).collect();
    let mut remaining: Vec<usize> = Vec::new();
    for rows in &plans {
        let fixed = sun_of_others(light, rows, schedule, &is_moving);
        let sun = |group: usize, state: State| rows_of(light.groups[group][usize::from(state)].sun.as_ref(), rows, steps);
        let own: Vec<[Matrix<f32>; 2]> = moving.iter().map(|(g, open, closed)| [sun(*g, *open), sun(*g, *closed)]).collect();
        let groups: Vec<Group<'_>> = own.iter().map(|[open, closed]| Group { open, closed }).collect();
        let found = blinds::operate(&groups, Some(&fixed), &counting.lm83);
        for ((group, _, closed), is_closed) in moving.iter().zip(&found.closed) {
            (0..steps).filter(|s| is_closed[*s]).for_each(|s| states[*group][s] = *closed);
        }
        remaining.extend(found.remaining);
    }
    remaining.sort_unstable();
    remaining.dedup();
    let open = inputs.with_schedule(schedule.clone());
    let open_suns = TracedSuns::apart(&Context { inputs: &open, ..*context }, inputs.sun_set_of_states(context.project)?)?;
    *schedule = Schedule::new(&inputs.facade, steps, states)?;
    let all = inputs.windows.iter().all(|w| w.group.is_some_and(is_moving));
    let is_covered = |w: &&ProjectWindow| {
        let open = moving.iter().find(|(g, ..)| w.group == Some(*g)).map(|(_, open, _)| usize::from(*open));
        open.and_then(|open| w.states.get(open)).is_none_or(|state| state.glass.is_none())
    };
    let covered = inputs.windows.iter().filter(is_covered).map(|w| w.name.clone()).collect();
    Ok(Some(Operated { remaining, open_suns, all, covered }))
}

/// These rows; of nothing zeros.
fn rows_of(of: Option<&Matrix<f32>>, rows: &[usize], steps: usize) -> Matrix<f32> {
    let data = match of {
        Some(of) => rows.iter().flat_map(|row| of.row(*row)).copied().collect(),
        None => vec![0.0; rows.len() * steps],
    };
    Matrix::from_data(rows.len(), steps, 1, data).expect("whole rows")
}

/// The sun on some sensors that does not come by the blinds that move.
fn sun_of_others(light: &StateLight, rows: &[usize], schedule: &Schedule, is_moving: &dyn Fn(usize) -> bool) -> Matrix<f32> {
    let mut sum = rows_of(light.rest.as_ref().and_then(|r| r.sun.as_ref()), rows, schedule.steps());
    for group in (0..schedule.groups()).filter(|g| !is_moving(*g)) {
        for (step, state) in schedule.of_group(group).iter().enumerate() {
            let Some(sun) = &light.groups[group][usize::from(*state)].sun else { continue };
            rows.iter().enumerate().for_each(|(i, row)| sum.at_mut(i, step)[0] += sun.at(*row, step)[0]);
        }
    }
    sum
}
