//! Progress of long work, and the wish to stop it.

use crate::error::{Error, ErrorKind, Result};

/// Receives progress. Implemented by the command line and the viewer; the library never prints.
pub trait Progress: Sync {
    /// Called now and then: what is being done and the finished fraction 0…1 of that stage.
    fn update(&self, stage: &str, fraction: f64);

    /// The same, with what is known of the whole work that the stage is a part of.
    fn update_of_whole(&self, stage: &str, fraction: f64, _whole: Whole) {
        self.update(stage, fraction);
    }

    /// Whether [`update_of_whole`](Self::update_of_whole) makes use of it: to foretell the whole costs some time itself.
    fn shows_whole(&self) -> bool {
        false
    }

    /// A phase of a run begins, by the name that its plan has for it.
    fn begin(&self, _phase: &str) {}

    /// Whether the work should stop at the next safe point. The worker then returns
    /// [`cancelled`] and leaves nothing half-written.
    fn stop_requested(&self) -> bool {
        false
    }

    /// The result of the stage's next unit, in bytes: what `make` gives, or what it gave to an earlier run of the
    /// same work that was stopped, under the same name. Units come in the same order always.
    ///
    /// # Errors
    /// What `make` returns, and failures of the file system.
    fn unit(&self, _name: &str, make: &mut dyn FnMut() -> Result<Vec<u8>>) -> Result<Vec<u8>> {
        make()
    }
}

/// What is known of the whole of some work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whole {
    /// Finished share, 0…1.
    pub share: f64,
    /// Seconds that the rest will take, once that can be told.
    pub seconds_left: Option<f64>,
}

/// Ignores progress and never stops.
pub struct Silent;

impl Progress for Silent {
    fn update(&self, _stage: &str, _fraction: f64) {}
}

/// The error of work that was stopped by its [`Progress`].
pub fn cancelled() -> Error {
    Error::new("stopped on request")
        .of_kind(ErrorKind::Stopped)
        .help("run the same command again to go on where it stopped, where results are kept, or to start anew")
}
