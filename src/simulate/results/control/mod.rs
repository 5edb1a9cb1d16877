//! States that the run decides: rules, LM-83's blinds, the best of each step.
//!
//! All that they look at is the light of each state of each group alone (`StateLight`), and what is outdoors. Rules
//! decide first, then LM-83's blinds, then the groups that are optimal, together: each sees the groups that are set already
//! (by a table too) as they are, and the others in their first state. Rules that look at light indoors do not stand beside
//! the other two.

mod best;
mod blinds;
mod decide;
mod glare;
mod groups;
mod signals;
mod tables;

pub(crate) use self::blinds::Operated;
pub(crate) use self::decide::decide;
pub use self::tables::{ControlSummary, DecidedGroup, StateValue};
