//! Named metrics of a run, or of a result folder, with what noise makes of them.

mod judge;
pub(crate) mod outlook;
mod samples;
mod tables;

pub use self::judge::{GroupFacts, judge, judge_all};
pub use self::samples::{Row, Samples, SensorSample};
pub use self::tables::SensorTable;
pub(crate) use self::tables::*;
