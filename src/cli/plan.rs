//! `lucarne plan`: what a run will do.

use lucarne::simulate::Plan;
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// What a run of a project.toml will model, what it leaves out and what it costs. Computes nothing.
#[derive(clap::Args)]
pub struct Args {
    /// Project file, or a Honeybee model (.hbjson)
    project: PathBuf,

    /// Weather of a Honeybee model given in place of a project file, EPW or WEA
    #[arg(long, value_name = "WEATHER")]
    weather: Option<PathBuf>,

    /// For programs
    #[arg(long)]
    json: bool,
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let plan = Plan::new(super::project(&args.project, args.weather.as_deref(), None)?, warnings)?.outline()?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&plan).map_err(|e| Error::new(e.to_string()))?);
    } else {
        println!("{plan}");
    }
    Ok(ExitCode::SUCCESS)
}
