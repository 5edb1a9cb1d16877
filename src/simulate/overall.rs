//! Progress of a whole run: which share of it is done, and how long the rest will take.
//!
//! The plan foretells what each phase costs on a slow device. What phases took until now tells how fast this one
//! is; phases whose results are there already take no time and tell nothing.

use super::inputs::Inputs;
use super::plan::plan;
use super::project::Project;
use crate::error::Result;
use crate::progress::{Progress, Whole};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Seconds of work before which the rest is guesswork.
const ENOUGH: f64 = 1.0;

/// Tells a run's progress as that of the whole.
pub(super) struct Overall<'a> {
    inner: &'a dyn Progress,
    /// Names of phases and the seconds foretold; empty if nobody wants to know.
    phases: Vec<(String, f64)>,
    state: Mutex<State>,
}

struct State {
    /// Foretold seconds of the phases before this one.
    before: f64,
    /// Of this one.
    phase: f64,
    fraction: f64,
    since: Instant,
    /// Work done in this run: foretold and real seconds.
    foretold: f64,
    real: f64,
}

impl State {
    fn begin(&mut self, seconds: f64, now: Instant) {
        self.before += self.phase;
        (self.phase, self.fraction, self.since) = (seconds, 0.0, now);
    }

    fn update(&mut self, fraction: f64, now: Instant) {
        let step = fraction - self.fraction;
        let took = now.duration_since(self.since).as_secs_f64();
        // What an earlier run did comes at once.
        if step > 0.0 && took > 0.0 {
            self.foretold += step * self.phase;
            self.real += took;
        }
        (self.fraction, self.since) = (self.fraction.max(fraction), now);
    }

    fn whole(&self, total: f64) -> Whole {
        let done = (self.before + self.phase * self.fraction).min(total);
        let known = self.real >= ENOUGH && self.foretold > 0.0 && self.phase > 0.0;
        Whole { share: done / total, seconds_left: known.then(|| (total - done) * self.real / self.foretold) }
    }
}

impl<'a> Overall<'a> {
    /// # Errors
    /// As [`plan`].
    pub fn new(inner: &'a dyn Progress, project: &Project, inputs: &Inputs) -> Result<Self> {
        let costs = if inner.shows_whole() { plan(project, inputs)?.costs } else { Vec::new() };
        let phases = costs.into_iter().map(|phase| (phase.name, phase.slow_seconds)).collect();
        let state = State { before: 0.0, phase: 0.0, fraction: 0.0, since: Instant::now(), foretold: 0.0, real: 0.0 };
        Ok(Self { inner, phases, state: Mutex::new(state) })
    }

    fn total(&self) -> f64 {
        self.phases.iter().map(|p| p.1).sum()
    }
}

impl Progress for Overall<'_> {
    fn update(&self, stage: &str, fraction: f64) {
        let total = self.total();
        if !(total > 0.0) {
            return self.inner.update(stage, fraction);
        }
        let whole = {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            state.update(fraction.clamp(0.0, 1.0), Instant::now());
            state.whole(total)
        };
        self.inner.update_of_whole(stage, fraction, whole);
    }

    fn begin(&self, phase: &str) {
        let seconds = self.phases.iter().find(|(name, _)| name == phase).map_or(0.0, |p| p.1);
        self.state.lock().unwrap_or_else(PoisonError::into_inner).begin(seconds, Instant::now());
    }

    fn stop_requested(&self) -> bool {
        self.inner.stop_requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_rest_is_foretold_by_the_speed_of_what_was_computed_now() {
        let start = Instant::now();
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        let mut state = State { before: 0.0, phase: 0.0, fraction: 0.0, since: start, foretold: 0.0, real: 0.0 };
        // Of phases of 10, 20 and 70 s the first is there already.
        state.begin(10.0, at(0.0));
        state.begin(20.0, at(0.0));
        assert_eq!(state.whole(100.0), Whole { share: 0.1, seconds_left: None });
        // Half of the second took 5 s: this device is twice as fast.
        state.update(0.25, at(2.5));
        state.update(0.5, at(5.0));
        assert_eq!(state.whole(100.0), Whole { share: 0.2, seconds_left: Some(40.0) });
        state.update(1.0, at(10.0));
        state.begin(70.0, at(10.0));
        assert_eq!(state.whole(100.0), Whole { share: 0.3, seconds_left: Some(35.0) });
        // A phase that nobody foretold.
        state.begin(0.0, at(45.0));
        assert_eq!(state.whole(100.0), Whole { share: 1.0, seconds_left: None });
    }
}
