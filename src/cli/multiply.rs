//! `lucarne multiply`.
use lucarne::{Result, Warnings};
use std::process::ExitCode;

/// Options.
#[derive(clap::Args)]
pub struct Args {}

pub fn run(_args: Args, _warnings: &mut Warnings) -> Result<ExitCode> {
    Err(lucarne::Error::new("not built yet"))
}
