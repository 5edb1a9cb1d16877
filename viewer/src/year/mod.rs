//! The Year panel: a carpet of the year, the hour's picture, sky and façade.

mod carpet;
mod dome;
mod hour;
pub mod model;
mod panel;
pub mod scrub;
mod side;
mod states;

pub use panel::YearPanel;
