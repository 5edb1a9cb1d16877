//! From a project to its results: what the command line and the viewer both call.

pub mod project;
mod table;

pub use project::Project;
