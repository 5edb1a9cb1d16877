//! `lucarne plan`: what a run will do.

use lucarne::simulate::{Plan, Project};
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// What a run of a project.toml will model, what it leaves out and what it costs. Computes nothing.
#[derive(clap::Args)]
pub struct Args {
    /// Project file
    project: PathBuf,

    /// For programs
    #[arg(long)]
    json: bool,
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let plan = Plan::new(Project::read(&args.project)?, warnings)?.outline()?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&plan).map_err(|e| Error::new(e.to_string()))?);
    } else {
        println!("{plan}");
    }
    Ok(ExitCode::SUCCESS)
}
