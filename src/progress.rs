//! Progress of long work, and the wish to stop it.

use crate::error::{Error, ErrorKind};

/// Receives progress. Implemented by the command line and the viewer; the library never prints.
pub trait Progress: Sync {
    /// Called now and then: what is being done and the finished fraction 0…1 of that stage.
    fn update(&self, stage: &str, fraction: f64);

    /// Whether the work should stop at the next safe point. The worker then returns
    /// [`cancelled`] and leaves nothing half-written.
    fn stop_requested(&self) -> bool {
        false
    }
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
