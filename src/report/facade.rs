//! The states of the façade: what they are, how long each holds, and when.

use super::parts::{Figure, Part, Section, Table, percent};
use super::sensors::days;
use crate::error::Result;
use crate::image::carpet::{Carpet, Class, Coloring};
use crate::image::drawing::Drawing;
use crate::image::palette::{CLASS_COLORS, Color, Palette, short_number};
use crate::simulate::Results;
use crate::simulate::results::control::{ControlSummary, StateValue};
use crate::simulate::summary::GroupSummary;
use crate::weather::Days;

/// States of all groups of windows.
pub(super) fn section(results: &Results) -> Result<Section> {
    let groups = &results.year.summary.groups;
    let mut parts = Vec::new();
    let mut table = Table::new("states", "States of the windows", &["group", "state", "made of", "its sun", "hours", "share"]);
    for group in groups {
        let all: f64 = group.states.iter().map(|s| s.hours).sum();
        table.rows.extend(group.states.iter().map(|state| {
            vec![
                group.name.clone(),
                state.name.clone(),
                state.glazing.clone(),
                if state.sun_is_traced { "traced" } else { "in the sky's patches" }.into(),
                short_number(state.hours),
                percent(state.hours / all.max(f64::MIN_POSITIVE)),
            ]
        }));
    }
    if table.rows.is_empty() {
        parts.push(Part::Text("The windows have one state.".into()));
    } else {
        parts.push(Part::Table(table));
    }
    parts.extend(results.year.summary.control.iter().flat_map(decided));
    let moving = groups.iter().filter(|g| g.states.iter().filter(|s| s.hours > 0.0).count() > 1);
    let mut figures = Vec::new();
    for group in moving {
        parts.push(Part::Text(format!("Windows {} of group {} move {} times.", group.windows.join(", "), group.name, group.moves)));
        if let Some(days) = days(results) {
            let states = results.year.states_of(&group.name)?;
            figures.push(Figure {
                name: format!("states_{}", group.name),
                label: format!("State of {} at every hour of the year", group.name),
                caption: String::new(),
                drawing: carpet(&days, group, &states)?,
            });
        }
    }
    if !figures.is_empty() {
        parts.push(Part::Figures(figures));
    }
    Ok(Section { title: "States of the façade", parts })
}

/// How the run decided states, and what came of it.
fn decided(control: &ControlSummary) -> Vec<Part> {
    let mut table = Table::new("control", "What decided the states", &["group", "decided by", "rule", "moves back and forth"]);
    table.rows.extend(control.groups.iter().map(|group| {
        let by = match group.by.as_str() {
            "lm-83" => "LM-83's blinds",
            "optimal" => "the best of each step",
            other => other,
        };
        vec![
            group.name.clone(),
            by.into(),
            group.rule.clone(),
            group.oscillating_moves.map_or_else(|| "no".into(), |n| format!("{n} times")),
        ]
    }));
    let mut parts = vec![Part::Table(table)];
    if let Some(hours) = control.lm83_hours_above {
        let covered = if control.lm83_blinds { "" } else { " Not all windows have such blinds." };
        parts.push(Part::Text(format!(
            "LM-83's blinds leave more than 2 % of the sensors with over 1000 lx of direct sun in {} h.{covered}",
            short_number(hours)
        )));
    }
    if let (Some(hours), Some(lost)) = (control.optimal_hours_above, control.optimal_may_be_lost) {
        let exact = if lost > 0.0 { format!("the search lost {} at most", short_number(lost)) } else { "the search is exact".into() };
        parts.push(Part::Text(format!("No combination of states meets the limits in {} h; {exact}.", short_number(hours))));
    }
    if !control.values.is_empty() {
        let mut table =
            Table::new("values", "What a state is worth", &["group", "without", "lost in the mean", "more hours above the limits"]);
        let of = |v: &StateValue| vec![v.group.clone(), v.without().into(), short_number(v.lost), short_number(v.more_hours_above)];
        table.rows.extend(control.values.iter().map(of));
        parts.push(Part::Table(table));
    }
    parts
}

/// The state of a group by step, a colour each.
fn carpet(days: &Days, group: &GroupSummary, states: &[usize]) -> Result<Drawing> {
    let values: Vec<f64> = days.steps.iter().map(|step| step.map_or(f64::NAN, |step| states[step] as f64)).collect();
    let color = |number: usize| -> Color {
        match group.states.len() <= CLASS_COLORS.len() {
            true => CLASS_COLORS[number],
            false => Palette::Viridis.color(number as f64 / (group.states.len() - 1) as f64),
        }
    };
    let class = |(number, name): (usize, &String)| Class { name: name.clone(), limit: number as f64 + 0.5, color: color(number) };
    let names: Vec<String> = group.states.iter().map(|s| s.name.clone()).collect();
    Carpet {
        values: &values,
        steps_per_day: days.per_day,
        first_day: days.first,
        leap: days.leap,
        title: format!("State of {}", group.name),
        label: "share of all hours".into(),
        coloring: Coloring::Classes(names.iter().enumerate().map(class).collect()),
        missing: days.steps.contains(&None).then(|| "not in the weather file".into()),
        shares: true,
    }
    .draw()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::results::control::DecidedGroup;
    use crate::simulate::summary::StateSummary;

    #[test]
    fn what_decided_is_told() {
        let group = DecidedGroup { name: "south".into(), by: "rule".into(), rule: "shut if time > 12".into(), oscillating_moves: Some(6) };
        let value = StateValue { group: "south".into(), state: String::new(), lost: 12.5, more_hours_above: 3.0 };
        let control = ControlSummary { groups: vec![group], lm83_hours_above: Some(7.0), values: vec![value], ..Default::default() };
        let parts = decided(&control);
        let told = format!("{parts:?}");
        for words in ["shut if time > 12", "6 times", "in 7 h. Not all windows", "all but the first state", "12.5"] {
            assert!(told.contains(words), "no '{words}' in {told}");
        }
    }

    #[test]
    fn a_carpet_has_a_colour_for_every_state() {
        for count in [2usize, 9] {
            let states = (0..count).map(|i| StateSummary { name: format!("state {i}"), ..Default::default() }).collect();
            let group = GroupSummary { name: "south".into(), states, ..Default::default() };
            let days = Days { first: 0, leap: false, per_day: 24, steps: (0..48).map(Some).collect() };
            let by_step: Vec<usize> = (0..48).map(|s| s % count).collect();
            let svg = carpet(&days, &group, &by_step).unwrap().svg().unwrap();
            assert!((0..count).all(|i| svg.contains(&format!("state {i}"))), "{svg}");
        }
    }
}
