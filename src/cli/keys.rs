//! `lucarne keys`: every key of a project file, with its values and its default.

use lucarne::simulate::project::keys;
use lucarne::{Error, Result, Warnings};
use std::process::ExitCode;

/// Options.
#[derive(clap::Args)]
pub struct Args {
    /// Only this section (weather, window, …)
    section: Option<String>,
}

/// Prints the reference as a page of Markdown.
pub fn run(args: Args, _warnings: &mut Warnings) -> Result<ExitCode> {
    match args.section {
        None => print!("{}", keys::page()),
        Some(name) => match keys::SECTIONS.iter().find(|s| s.name == name) {
            Some(section) => print!("{}", section.page()),
            None => {
                let known: Vec<&str> = keys::SECTIONS.iter().map(|s| s.name).collect();
                return Err(Error::new(format!("there is no section '{name}'")).help(format!("choose one of {}", known.join(", "))));
            }
        },
    }
    Ok(ExitCode::SUCCESS)
}
