//! DGP of views in the states that control chooses between.

use super::super::glare::GlareJob;
use super::super::views::{self, Made};
use crate::control::State;
use crate::error::Result;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::simulate::context::{Context, Ledger};
use crate::simulate::inputs::glare_states::GlareAsked;
use crate::simulate::light::Daylight;
use crate::simulate::project::glare::GlareMethod;
use crate::simulate::sampling::estimate::Estimate;
use std::time::Instant;

/// DGP of views.
#[derive(Default)]
pub(super) struct DgpOfStates {
    asked: GlareAsked,
    /// `[view][combination][step]`.
    dgp: Vec<Vec<Vec<f64>>>,
}

impl DgpOfStates {
    /// DGP of all that rules and optimal groups look at; nothing if they look at none.
    ///
    /// # Errors
    /// Failures of device and file system, or when stopped.
    pub fn new(context: &Context<'_>, made: &Made<'_>, daylight: Daylight<'_>, ledger: &mut Ledger) -> Result<Self> {
        let project = context.project;
        let asked = context.inputs.glare_of_states(project)?;
        let Some(section) = project.glare.as_ref().filter(|_| !asked.views.is_empty()) else { return Ok(Self::default()) };
        if section.method == GlareMethod::Image {
            for view in &asked.views {
                // The run notes it when it comes to it.
                let mut own = Ledger::default();
                views::make_matrix(context, &mut own, made, &project.views[*view])?;
                ledger.statistics.add(own.statistics);
                ledger.traced_seconds += own.traced_seconds;
            }
        }
        context.progress.begin("glare of states");
        let clock = Instant::now();
        let daylight_error: Vec<Matrix<f32>> = made.sampled.daylight.iter().map(Estimate::standard_error).collect();
        let (daylight, daylight_direct) = (daylight.total, daylight.direct);
        let job = GlareJob { context: *context, made: *made, daylight, daylight_direct, daylight_error: &daylight_error };
        let mut statistics = TraceStatistics::default();
        let dgp = job.dgp_of_states(section, &asked.views, &asked.states, &mut statistics)?;
        ledger.count(statistics, clock);
        Ok(Self { asked, dgp })
    }

    /// DGP of a view in a step, with the groups in these states; no number if it was not asked for.
    pub fn of(&self, view: usize, step: usize, states: &[State]) -> f64 {
        let view = self.asked.views.iter().position(|v| *v == view);
        let combination = self.asked.states.binary_search_by(|s| s.as_slice().cmp(states)).ok();
        view.zip(combination).map_or(f64::NAN, |(view, combination)| self.dgp[view][combination][step])
    }
}
