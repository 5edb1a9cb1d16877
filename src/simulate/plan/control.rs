//! What a plan says of the states of the façade.

use crate::control::Group;
use crate::control::rules::Rule;
use crate::metrics::{glare, lm83};
use crate::simulate::inputs::Inputs;
use crate::simulate::project::Project;
use crate::simulate::project::control::Asked;
use crate::simulate::project::optimal::{OptimalSection, Wanted};

/// A line for each group: how many states, and when it is in which, or what decides that.
pub(super) fn lines(project: &Project, inputs: &Inputs) -> Vec<String> {
    let of = |(number, group): (usize, &Group)| {
        let asked = project.control.of_group(number).map(|c| &c.asked).filter(|_| inputs.undecided.contains(&number));
        let how = match asked {
            Some(Asked::Rule(text, rule)) => by_rule(project, inputs, text, rule.as_ref()),
            Some(Asked::Lm83 { open, closed }) => {
                let [open, closed] = [open, closed].map(|s| &group.states[usize::from(*s)]);
                format!(
                    "by LM-83: from '{open}' to '{closed}' while more than {:.0} % of the sensors that face up have over {} lx of direct \
                     sun, 8:00 to 18:00",
                    100.0 * lm83::MAY_BE_IN_SUN,
                    lm83::SUN_LX
                )
            }
            Some(Asked::Optimal) => format!("the best of each step: {}", best(&project.control.optimal)),
            _ => as_given(inputs, number, group),
        };
        format!("group {}: {} states, {how}", group.name, group.states.len())
    };
    inputs.facade.groups().iter().enumerate().map(of).collect()
}

fn as_given(inputs: &Inputs, number: usize, group: &Group) -> String {
    let length = inputs.weather.steps().length;
    let hours = inputs.schedule.hours(number, group.states.len(), length, None);
    let used = group.states.iter().zip(hours).filter(|(_, hours)| *hours > 0.0);
    let used: Vec<String> = used.map(|(state, hours)| format!("'{state}' for {hours} h")).collect();
    let moves = inputs.schedule.moves(number);
    let times = if moves > 0 { format!("moves {moves} times") } else { "never moves".into() };
    format!("in {}, {times}", used.join(", "))
}

fn by_rule(project: &Project, inputs: &Inputs, text: &str, rule: Option<&Rule>) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let indoors = rule.is_some_and(|r| r.readings().iter().any(|r| r.signal.is_indoors()));
    let needs = if indoors { ", which needs the light of all states first" } else { "" };
    // Checked when the inputs were read.
    let occupied = rule.filter(|r| r.asks_for_occupancy()).and_then(|_| inputs.counting(project).ok());
    let occupied = occupied.map_or_else(String::new, |c| format!("; occupied: {}", c.occupied.name));
    format!("by the rule \"{text}\"{needs}{occupied}")
}

fn best(section: &OptimalSection) -> String {
    let aim = match section.aim {
        Wanted::Daylight => "most daylight".to_string(),
        Wanted::Lighting => format!("least power for lights up to {} lx", section.target),
        Wanted::Moves => "fewest moves, then most daylight".into(),
    };
    let eyes =
        section.eyes.iter().map(|eyes| format!("{:.0} lx at the eyes '{eyes}' (DGPs {})", glare::vertical_lux(section.dgps), section.dgps));
    let dgp = section
        .dgp
        .map(|dgp| format!("DGP {dgp} of {}", section.views.as_ref().map_or("all views".into(), |v| format!("'{}'", v.join("', '")))));
    let sunlit = section.sunlit.map(|share| format!("{} % of the sensors in over {} lx of direct sun", 100.0 * share, lm83::SUN_LX));
    let most = section.most.map(|lux| format!("{lux} lx at any sensor that faces up"));
    format!("{aim} with no more than {}", eyes.chain(dgp).chain(sunlit).chain(most).collect::<Vec<_>>().join(", "))
}
