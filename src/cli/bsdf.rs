//! `lucarne bsdf …`: chooses the verb; each verb has its own module.

mod check;
mod convert;
mod diff;
mod generate;
mod info;
mod interpolate;
mod isotropic;
mod layer;
mod plot;

use clap::Subcommand;
use lucarne::bins::{AngleBasis, KlemsBasis};
use lucarne::{Error, Result, Warnings};
use std::process::ExitCode;

/// Arguments of `lucarne bsdf`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Generate(Box<generate::Args>),
    Info(info::Args),
    Check(check::Args),
    Isotropic(isotropic::Args),
    Layer(layer::Args),
    Plot(plot::Args),
    Interpolate(interpolate::Args),
    Convert(convert::Args),
    Diff(diff::Args),
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    match args.verb {
        Verb::Generate(args) => generate::run(&args, warnings),
        Verb::Info(args) => info::run(&args, warnings),
        Verb::Check(args) => check::run(&args, warnings),
        Verb::Isotropic(args) => isotropic::run(&args, warnings),
        Verb::Layer(args) => layer::run(&args, warnings),
        Verb::Plot(args) => plot::run(&args, warnings),
        Verb::Interpolate(args) => interpolate::run(&args, warnings),
        Verb::Convert(args) => convert::run(&args, warnings),
        Verb::Diff(args) => diff::run(&args, warnings),
    }
}

/// The command that made a file, for its comment.
fn made_by() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("Created by: lucarne {}", arguments.join(" "))
}

/// `full`, `half` or `quarter`.
fn klems_basis(name: &str) -> Result<AngleBasis> {
    let basis = match name.to_ascii_lowercase().as_str() {
        "full" => KlemsBasis::Full,
        "half" => KlemsBasis::Half,
        "quarter" => KlemsBasis::Quarter,
        _ => return Err(Error::new(format!("unknown Klems basis '{name}'")).help("full, half and quarter are known")),
    };
    Ok(basis.into())
}
