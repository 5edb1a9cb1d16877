//! From a project to its results: what the command line and the viewer both call.

mod fingerprint;
mod five_phase;
mod glare;
mod glare_eyes;
mod glare_noise;
mod glare_output;
pub mod glare_section;
pub mod inputs;
pub mod method;
pub mod multiply;
pub mod pictures;
pub mod plan;
mod presets;
pub mod project;
mod results;
pub mod rooms;
mod rounds;
mod run;
pub mod shade;
mod store;
mod summary;
pub mod sun_pictures;
pub mod suns;
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
