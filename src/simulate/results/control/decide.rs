//! Who decides, and in which order.

use super::best::{Best, best_states};
use super::blinds::{Operated, lm83_blinds};
use super::glare::DgpOfStates;
use super::signals::Signals;
use crate::control::Schedule;
use crate::control::rules::{self, Reading, Signal};
use crate::error::{Error, Result};
use crate::simulate::context::{Context, Ledger};
use crate::simulate::inputs::counting::Counting;
use crate::simulate::light::Daylight;
use crate::simulate::project::control::Asked;
use crate::simulate::results::states::StateLight;
use crate::simulate::results::views::Made;

/// What was decided.
pub(crate) struct Decision {
    /// The states of all groups.
    pub schedule: Schedule,
    /// What rules did.
    pub rules: Option<OfRules>,
    /// What LM-83's blinds did.
    pub blinds: Option<Operated>,
    /// What is best.
    pub best: Option<Best>,
    /// The light of all states, where it was needed.
    pub light: Option<StateLight>,
}

/// What rules did, and what they looked at: a value per step.
pub(crate) struct OfRules {
    pub operation: rules::Operation,
    pub readings: Vec<(usize, Reading, Vec<f64>)>,
}

/// Memory for the light of all states, bytes, if the machine has it.
const MOST_MEMORY: u64 = 8 << 30;

/// Decides the states of the groups that the project leaves to the run; nothing if there are none.
///
/// # Errors
/// Failures of device and file system, what signals need and the project does not have, or when stopped.
pub(crate) fn decide(
    context: &Context<'_>,
    counting: &Counting,
    made: &Made<'_>,
    daylight: Daylight<'_>,
    ledger: &mut Ledger,
) -> Result<Option<Decision>> {
    let (control, inputs) = (&context.project.control, context.inputs);
    let undecided = &inputs.undecided;
    if undecided.is_empty() {
        return Ok(None);
    }
    let of_rules = control.rules();
    let at_sensors = |s: Signal| s.is_indoors() && !matches!(s, Signal::Dgp(_));
    let looks_indoors = of_rules.iter().any(|r| r.readings().iter().any(|r| at_sensors(r.signal)));
    let light = match looks_indoors || control.groups.iter().any(|c| matches!(c.asked, Asked::Lm83 { .. } | Asked::Optimal)) {
        true => Some(light_of_states(context, made, daylight, ledger)?),
        false => None,
    };
    context.check_stop()?;
    // Until they are set.
    let facade = &inputs.facade;
    let states = (0..facade.groups().len()).map(|g| match control.of_group(g).map(|c| &c.asked) {
        Some(Asked::Lm83 { open, .. }) => vec![*open; inputs.schedule.steps()],
        _ if undecided.contains(&g) => vec![0; inputs.schedule.steps()],
        _ => inputs.schedule.of_group(g).to_vec(),
    });
    let mut schedule = Schedule::new(facade, inputs.schedule.steps(), states.collect())?;
    let dgp = DgpOfStates::new(context, made, daylight, ledger)?;
    let rules = if of_rules.is_empty() {
        None
    } else {
        let signals = Signals::new(context, counting, made, daylight, (light.as_ref(), &dgp), &of_rules)?;
        let operation = rules::operate(&of_rules, facade, &counting.year, &schedule, &signals)?;
        let readings = signals.readings(&of_rules, &counting.year, &operation.schedule);
        schedule = operation.schedule.clone();
        Some(OfRules { operation, readings })
    };
    let (mut blinds, mut best) = (None, None);
    if let Some(light) = &light {
        blinds = lm83_blinds(context, counting, light, &mut schedule)?;
        best = best_states(context, counting, light, &dgp, &mut schedule)?;
    }
    Ok(Some(Decision { schedule, rules, blinds, best, light }))
}

fn light_of_states(context: &Context<'_>, made: &Made<'_>, daylight: Daylight<'_>, ledger: &mut Ledger) -> Result<StateLight> {
    let inputs = context.inputs;
    let states: usize = inputs.facade.groups().iter().map(|g| g.states.len()).sum();
    // Light and the direct sun in it.
    let matrices = (states + 1) * if context.choice.phases == 5 { 2 } else { 1 };
    let bytes = (size_of::<f32>() * matrices * inputs.all_sensors().len() * inputs.weather.records.len()) as u64;
    let most = crate::gpu::allowed(MOST_MEMORY);
    if bytes > most {
        let message = format!("the light of {states} states at all sensors takes {} MB, {} MB are allowed", bytes >> 20, most >> 20);
        return Err(Error::new(message)
            .file(&context.project.file)
            .field("control")
            .help("decide the states with fewer sensors or states, then give the table that this writes: control/schedule.csv"));
    }
    context.progress.begin("Cds of states");
    StateLight::new(context, made, daylight, ledger)
}
