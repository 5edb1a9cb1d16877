//! What states of the façade cost beside the façade as it moves.

use super::super::presets::pane_options;
use super::{PhasePlan, pane_entries, slow, sun_rays};
use crate::simulate::inputs::Inputs;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::project::Project;

/// What the states of the façade add for sensors: the light of each, and its suns.
pub(super) fn state_costs(project: &Project, inputs: &Inputs, suns: Option<&SunSet>, sensors: usize, lit: usize) -> Vec<PhasePlan> {
    let groups = inputs.facade.groups();
    let states: usize = groups.iter().map(|g| g.states.len()).sum();
    if sensors == 0 || groups.iter().all(|g| g.states.len() < 2) {
        return Vec::new();
    }
    let mut all = Vec::new();
    if let Some(suns) = suns {
        let needed = suns.census.needed;
        // Each thing that suns pass has all suns, but the one that is traced above.
        let ways = inputs.ways_of_suns();
        let more = if inputs.moves() { ways.saturating_sub(1) } else { ways } as f64;
        let phase = PhasePlan::new("Cds of states".into(), (sensors, "sensors"), (ways * needed, "suns"));
        let scattered = pane_entries(inputs, &pane_options(project), sensors, needed) * slow::PANE_ENTRY;
        all.push(phase.traced(more * sun_rays(project, inputs, sensors, needed), slow::SUN_RAY).worked(more * scattered));
    }
    let bins = inputs.bins() as f64 * if suns.is_some() { 2.0 } else { 1.0 };
    let work = 3.0 * bins / groups.len() as f64 * (states * sensors * lit) as f64;
    let phase = PhasePlan::new("light of states".into(), (states * sensors, "sensors"), (inputs.weather.records.len(), "steps"));
    all.push(phase.worked(work * slow::PRODUCT));
    all
}
