//! Metrics with names: pure functions in f64 over arrays of a year, each with its definition, unit and source.
//!
//! ```text
//! year       the time steps that a result has
//! occupancy  which of them count: LM-83, EN 17037, a schedule of one's own
//! sensor     what is counted at one sensor: mean, DA, cDA, UDI, light exposure
//! noise      what noise could make of it: standard errors, and the probability that a class is another
//! lm83       sDA300/50%, ASE1000,250h and what a grid must be for them
//! blinds     LM-83's blinds: which groups of windows close in which hour
//! en17037    daylight provision by both methods, exposure to sunlight, levels
//! view_out   EN 17037: what an eye sees of the outside
//! leed       points of LEED v4.1's daylight credit
//! glare      sGA, sDG and protection over many views
//! metric     one result, for summaries and tables
//! ```
//!
//! Definitions with their sources for who reads results: [`guide::metrics`](crate::guide::metrics).

pub mod blinds;
pub mod en17037;
pub mod glare;
pub mod leed;
pub mod lm83;
mod metric;
mod noise;
mod occupancy;
mod sensor;
pub mod view_out;
mod year;

pub use metric::Metric;
pub use noise::{Decision, Noise, UNDECIDED};
pub use occupancy::{Clock, Occupancy};
pub use sensor::{AUTONOMY_LX, Counted, EXCEEDED_LX, FELL_SHORT_LX};
pub use year::{Step, Year};

/// A value and its standard error, both in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// The share of values that pass; nothing of none.
pub fn share_of<T>(values: &[T], passes: impl Fn(&T) -> bool) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().filter(|v| passes(v)).count() as f64 / values.len() as f64)
}
