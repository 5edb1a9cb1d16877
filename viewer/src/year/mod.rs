//! The Year panel: a carpet of the year, the hour's picture, sky and façade.

mod carpet;
mod dome;
mod hour;
mod lines;
pub mod model;
mod panel;
pub mod scrub;
mod side;
mod states;
mod wish;

pub use panel::YearPanel;
pub use states::YearLux;
