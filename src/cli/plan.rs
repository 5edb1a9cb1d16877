//! `lucarne plan`: what a run will do.

use lucarne::simulate::plan::plan;
use lucarne::simulate::{Inputs, Project};
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
    let project = Project::read(&args.project)?;
    let inputs = Inputs::read(&project, warnings)?;
    let plan = plan(&project, &inputs)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&plan).map_err(|e| Error::new(e.to_string()))?);
    } else {
        println!("{plan}");
    }
    Ok(ExitCode::SUCCESS)
}
