//! From a project to its results: what the command line and the viewer both call.

mod fingerprint;
mod glare;
mod glare_noise;
mod glare_output;
pub mod glare_section;
pub mod inputs;
pub mod multiply;
pub mod pictures;
mod presets;
pub mod project;
mod results;
mod rounds;
mod run;
mod store;
mod summary;
mod table;
mod view_grid;
pub mod views;

pub use fingerprint::Fingerprint;
pub use glare::GlareSummary;
pub use inputs::Inputs;
pub use project::Project;
pub use results::EstimatedError;
pub use run::run;
pub use summary::{DeviceSummary, MatrixSummary, Seconds, SensorSummary, Summary, ViewSummary};
