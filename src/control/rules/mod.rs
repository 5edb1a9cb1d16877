//! Rules: which state a group takes, from what it is like outdoors and indoors.
//!
//! ```text
//! rule       = clause { ";" clause }
//! clause     = STATE "if" condition [ "for" MINUTES ] [ "until" condition ]
//!            | "else" STATE
//!            | "keep" MINUTES
//! condition  = [ "not" ] comparison { ("and" | "or") condition }, with parentheses
//! comparison = signal (">" | ">=" | "<" | "<=") NUMBER [ unit ]
//!            | signal "between" NUMBER [ unit ] "and" NUMBER [ unit ]
//!            | "occupied"
//! ```
//!
//! Names of states, groups, sensors and views stand as words or in quotes. [`Signal`] lists what can be compared,
//! [`operate()`] says how a year is decided.

mod condition;
mod operate;
mod parse;
mod signal;
mod words;

pub use condition::{Condition, Limit};
pub use operate::{Decided, Operation, Oscillation, Values, operate};
pub use parse::{Clause, Rule};
pub use signal::{Known, Reading, Signal, Statistic};
