//! What deciding asks of the groups of windows and sensors.

use crate::error::Error;
use crate::simulate::context::Context;

/// A fault of what is asked for a group, with its place in the project.
pub(super) fn fault_of(context: &Context<'_>, group: usize, error: Error) -> Error {
    context.project.control.of_group(group).map_or(error.clone(), |c| c.place.of(error))
}

/// Rows of the sensors of each group that face up, but of this one.
pub(super) fn plans(context: &Context<'_>, without: Option<&str>) -> Vec<Vec<usize>> {
    let mut first = 0;
    let mut found = Vec::new();
    for group in &context.inputs.sensors {
        let rows = group.sensors.iter().enumerate().filter(|(_, s)| s.faces_up()).map(|(i, _)| first + i);
        found.push(if without == Some(group.name.as_str()) { Vec::new() } else { rows.collect() });
        first += group.sensors.len();
    }
    found.retain(|rows| !rows.is_empty());
    found
}
