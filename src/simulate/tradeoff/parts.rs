//! Progress of one of many runs.

use crate::progress::Progress;

/// Some parts of a whole at once: first, how many, of how many.
pub(super) struct Wide<'a>(pub &'a dyn Progress, pub usize, pub usize, pub usize);

impl Progress for Wide<'_> {
    fn update(&self, stage: &str, fraction: f64) {
        self.0.update(stage, (self.1 as f64 + fraction.clamp(0.0, 1.0) * self.2 as f64) / self.3 as f64);
    }

    fn stop_requested(&self) -> bool {
        self.0.stop_requested()
    }
}

/// Names the setting in front of every stage. Stages of a run follow each other without end; that they
/// go on is all that is told.
pub(super) struct Named<'a>(pub &'a dyn Progress, pub &'a str);

impl Progress for Named<'_> {
    fn update(&self, stage: &str, fraction: f64) {
        self.0.update(&format!("{}: {stage}", self.1), fraction);
    }

    fn stop_requested(&self) -> bool {
        self.0.stop_requested()
    }
}
