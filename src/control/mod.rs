//! Façades that move: which state each group of windows is in, step by step. Pure functions in f64 over arrays of a year.
//!
//! ```text
//! facade    groups of windows, and the states that each can be in
//! schedule  the state of each group in every time step; hours of use, moves
//! table     schedules as CSV
//! rules     a small language of conditions, and what it makes of a year
//! optimum   the best combination of states in every step
//! ```

mod facade;
pub mod optimum;
pub mod rules;
mod schedule;
mod table;

pub use facade::{Facade, Group, State};
pub use schedule::Schedule;
pub use table::{parse, read, write};
