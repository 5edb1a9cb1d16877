//! `lucarne view`: starts the viewer, a program of its own beside this one.

use lucarne::{Error, Result};
use std::ffi::OsString;
use std::process::ExitCode;

/// Opens result folders, BSDFs, pictures and matrices in the viewer.
///
/// All arguments are the viewer's; `lucarne view --help` shows them.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    /// Files, folders and options of lucarne-viewer.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "FILE")]
    arguments: Vec<OsString>,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let here = std::env::current_exe().map_err(|e| Error::io("lucarne", &e))?;
    let viewer = here.with_file_name(format!("lucarne-viewer{}", std::env::consts::EXE_SUFFIX));
    if !viewer.exists() {
        return Err(Error::new("the viewer is not built")
            .file(&viewer)
            .help("run 'make viewer', or: cargo build --release -p lucarne-viewer"));
    }
    let status = std::process::Command::new(&viewer).args(args.arguments).status().map_err(|e| Error::io(&viewer, &e))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
