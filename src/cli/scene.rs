//! `lucarne scene`: what scene files hold.

use lucarne::scene::info::SceneInfo;
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// Look at scene files before anything is computed.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    /// Triangles, materials with area and reflectance, windows, sensors, extent; and what looks wrong: open edges
    /// (leaks), surfaces that face opposite ways, doubled surfaces, lengths that look like millimetres.
    Info(InfoArgs),
}

#[derive(clap::Args)]
struct InfoArgs {
    /// Scene files, read as one scene: .rad (materials first), .obj, .gltf, .glb, .hbjson
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,

    /// For programs
    #[arg(long)]
    json: bool,
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let Verb::Info(args) = args.verb;
    let info = SceneInfo::read(&args.files, warnings)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&info).map_err(|e| Error::new(e.to_string()))?);
    } else {
        print!("{info}");
    }
    Ok(ExitCode::SUCCESS)
}
