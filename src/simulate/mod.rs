//! From a project to its results: what the command line and the viewer both call.
//!
//! ```text
//! project   what is asked for: project.toml, section by section; of its files only points of views are read
//! store     the output folder: matrices that remember what they were computed from
//! inputs    what is there: weather, scene, windows with their T, sensors, shades, suns
//! light     the one formula, I = [V − Vd | Vd]·[X ; X − Xsun] + Cds·Ssun; V may be C and X the sky itself
//! sampling  rounds of sampling: which matrix gets the next one, when to stop
//! plan      what will be modelled and what it costs
//! phases    S, D, V, Cds: each reused or traced, and kept
//! results   illuminance, pictures and glare with their errors
//! year      what a run gives, and a result folder read back: arrays, pictures, states of the façade
//! run       the story from the sky to the summary
//! ready     a project with all its files, ready to run
//! rooms, tradeoff    many runs
//! ```
//!
//! Imports go upwards in this list only (`tests/architecture.rs` holds it).

pub(crate) mod context;
pub mod inputs;
pub mod light;
pub mod multiply;
mod overall;
pub(crate) mod phases;
pub mod plan;
pub mod project;
mod ready;
pub mod results;
pub mod rooms;
mod run;
pub(crate) mod sampling;
pub(crate) mod store;
pub mod summary;
pub mod tradeoff;
pub mod year;

pub use context::MatrixSummary;
pub use context::Seconds;
pub use inputs::Inputs;
pub use project::Project;
pub use ready::Plan;
pub use results::glare::GlareSummary;
pub use results::sensors::SensorSummary;
pub use results::uncertainty::EstimatedError;
pub use results::views::ViewSummary;
pub use run::{run, without_pruning};
pub use store::fingerprint::Fingerprint;
pub use store::sun_pictures::SunPictures;
pub use summary::Summary;
pub use year::{Results, Year};
