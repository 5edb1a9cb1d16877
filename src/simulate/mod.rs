//! From a project to its results: what the command line and the viewer both call.
//!
//! ```text
//! project   what is asked for: project.toml, section by section; opens no other file
//! store     the output folder: matrices that remember what they were computed from
//! inputs    what is there: weather, scene, windows with their T, sensors, shades, suns
//! light     the one formula, I = [V − Vd | Vd]·[X ; X − Xsun] + Cds·Ssun
//! sampling  rounds of sampling: which matrix gets the next one, when to stop
//! plan      what will be modelled and what it costs
//! phases    S, D, V, Cds: each reused or traced, and kept
//! results   illuminance, pictures and glare with their errors
//! run       the story from the sky to the summary
//! rooms, tradeoff    many runs
//! ```
//!
//! Imports go upwards in this list only (`tests/architecture.rs` holds it).

pub mod context;
pub mod inputs;
pub mod light;
pub mod multiply;
pub mod phases;
pub mod plan;
pub mod project;
pub mod results;
pub mod rooms;
mod run;
pub mod sampling;
pub mod store;
mod summary;
pub mod tradeoff;

pub use context::{MatrixSummary, Seconds};
pub use inputs::Inputs;
pub use project::Project;
pub use results::glare::GlareSummary;
pub use results::sensors::SensorSummary;
pub use results::uncertainty::EstimatedError;
pub use results::views::ViewSummary;
pub use run::{run, without_pruning};
pub use store::fingerprint::Fingerprint;
pub use summary::{DeviceSummary, Summary};
