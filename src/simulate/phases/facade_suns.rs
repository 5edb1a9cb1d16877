//! The suns of a façade that may move.
//!
//! A sun that shines in hours of different states counts as several: one for each *combination* of what suns pass in them.
//! So hours, matrices and pictures stand for the façade as it moves, and nothing after them knows of states. Sensors get
//! each group's suns apart, all suns through each thing that its states have: a schedule that changes asks for no rays.
//! A group's sun passes its own shade; the shades of other groups do not stand in its way. Of a façade that never changes
//! all suns are traced together, as if it had but that state.

use super::sun::{SunEntry, sun_matrix};
use crate::control::State;
use crate::error::Result;
use crate::kernels::sun_matrix::SunMatrix;
use crate::matrix::Matrix;
use crate::simulate::context::Context;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::inputs::{Inputs, ProjectWindow, SensorGroup};
use crate::simulate::project::Project;
use std::collections::BTreeMap;

/// The suns of a façade.
#[derive(Debug, Clone)]
pub(crate) struct FacadeSuns {
    /// As if it never moved.
    pub base: SunSet,
    /// Each sun once for each combination in whose hours it shines.
    pub set: SunSet,
    /// States of all groups that suns pass.
    pub combinations: Vec<Vec<State>>,
    /// Of each sun of `set`: its combination, and its number in `base`.
    pub places: Vec<(usize, usize)>,
}

impl FacadeSuns {
    /// # Errors
    /// As [`SunSet::new`].
    pub fn new(inputs: &Inputs, project: &Project) -> Result<Self> {
        Ok(Self::of(inputs, inputs.sun_set(project)?))
    }

    /// Of given suns.
    pub fn of(inputs: &Inputs, base: SunSet) -> Self {
        let (combinations, of_step) = inputs.sun_combinations();
        if combinations.len() < 2 {
            let places = (0..base.suns.len()).map(|sun| (0, sun)).collect();
            return Self { set: base.clone(), base, combinations, places };
        }
        let mut numbers: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for (hour, combination) in base.hours.iter().zip(&of_step) {
            numbers.extend(hour.map(|(sun, _)| ((*combination, sun), 0)));
        }
        numbers.values_mut().enumerate().for_each(|(i, number)| *number = i);
        let places: Vec<(usize, usize)> = numbers.keys().copied().collect();
        let hours = base.hours.iter().zip(&of_step).map(|(hour, c)| hour.map(|(sun, radiance)| (numbers[&(*c, sun)], radiance))).collect();
        let set = SunSet {
            suns: places.iter().map(|(_, sun)| base.suns[*sun]).collect(),
            columns: places.iter().map(|(_, sun)| base.columns[*sun]).collect(),
            hours,
            ..base.clone()
        };
        Self { base, set, combinations, places }
    }

    /// Cds of these sensors, columns the suns of `set`, and whether anything of it was traced now.
    ///
    /// # Errors
    /// Failures of device and file system, or when stopped.
    pub fn matrix(&self, context: &Context<'_>, sensors: &[SensorGroup], way: SunEntry, behind: &str) -> Result<(SunMatrix, bool)> {
        if self.combinations.len() < 2 {
            // What suns pass never changes, though T may.
            let inputs = if context.inputs.moves() { &context.inputs.in_states(&self.combinations[0]) } else { context.inputs };
            return sun_matrix(&Context { inputs, ..*context }, sensors, &self.set, way, behind);
        }
        self.matrix_apart(context, sensors)
    }

    /// The same with each group's suns traced apart, as [`through_group`] keeps them.
    ///
    /// # Errors
    /// As [`matrix`](Self::matrix).
    pub fn matrix_apart(&self, context: &Context<'_>, sensors: &[SensorGroup]) -> Result<(SunMatrix, bool)> {
        let rows = sensors.iter().map(|g| g.sensors.len()).sum();
        let mut all = SunMatrix::zeros(rows, self.places.len());
        let mut traced = false;
        let inputs = context.inputs;
        for group in 0..inputs.facade.groups().len() {
            let mut states: Vec<State> = self.combinations.iter().map(|c| c[group]).collect();
            states.sort_unstable();
            states.dedup();
            for state in states {
                if let Some((part, now)) = through_group(context, sensors, &self.base, group, state)? {
                    self.add(&mut all, &part, |combination| self.combinations[combination][group] == state);
                    traced |= now;
                }
            }
        }
        if let Some((part, now)) = through_rest(context, sensors, &self.base)? {
            self.add(&mut all, &part, |_| true);
            traced |= now;
        }
        Ok((all, traced))
    }

    /// Adds the columns of `base` to those of the combinations that hold.
    fn add(&self, all: &mut SunMatrix, part: &SunMatrix, holds: impl Fn(usize) -> bool) {
        let spread = |of: &Matrix<f32>| {
            let mut wide = Matrix::zeros(of.rows(), self.places.len(), 3);
            for row in 0..of.rows() {
                for (column, (combination, sun)) in self.places.iter().enumerate() {
                    if holds(*combination) {
                        wide.at_mut(row, column).copy_from_slice(of.at(row, *sun));
                    }
                }
            }
            wide
        };
        all.add(&SunMatrix {
            total: spread(&part.total),
            direct: spread(&part.direct),
            own_error: spread(&part.own_error),
            shared_error: spread(&part.shared_error),
            statistics: part.statistics,
        });
    }
}

/// Cds of these sensors and all suns through the windows of a group in one of its states, all others closed; nothing where
/// its sun is not traced.
///
/// # Errors
/// Failures of device and file system, or when stopped.
pub(crate) fn through_group(
    context: &Context<'_>,
    sensors: &[SensorGroup],
    suns: &SunSet,
    group: usize,
    state: State,
) -> Result<Option<(SunMatrix, bool)>> {
    let inputs = context.inputs;
    // States that suns pass alike share what is traced.
    let state = inputs.sun_classes(group)[usize::from(state)];
    let mut states = vec![0; inputs.facade.groups().len()];
    states[group] = state;
    let open = inputs.in_states(&states).with_suns_through(&inputs.windows_of_group(group));
    let named = &inputs.facade.groups()[group];
    traced(context, sensors, suns, &open, &format!("@{}@{}", named.name, named.states[usize::from(state)]))
}

/// The same through all windows without states.
///
/// # Errors
/// As [`through_group`].
pub(crate) fn through_rest(context: &Context<'_>, sensors: &[SensorGroup], suns: &SunSet) -> Result<Option<(SunMatrix, bool)>> {
    let open = context.inputs.with_suns_through(&context.inputs.windows_without_states());
    traced(context, sensors, suns, &open, "@")
}

fn traced(context: &Context<'_>, sensors: &[SensorGroup], suns: &SunSet, open: &Inputs, behind: &str) -> Result<Option<(SunMatrix, bool)>> {
    if !open.windows.iter().any(|w| w.is_sunny()) {
        return Ok(None);
    }
    // What a run without control has traced already.
    let same = |(a, b): (&ProjectWindow, &ProjectWindow)| {
        let inputs = |w: &ProjectWindow| w.pane.as_ref().map(|p| p.inputs);
        a.shade == b.shade && inputs(a) == inputs(b)
    };
    let whole = !context.inputs.moves() && context.inputs.windows.iter().zip(&open.windows).all(same);
    sun_matrix(&Context { inputs: open, ..*context }, sensors, suns, SunEntry::Windows, if whole { "" } else { behind }).map(Some)
}
