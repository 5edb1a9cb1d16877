//! `lucarne bsdf …`: chooses the verb; each verb has its own module.

mod check;
mod convert;
mod diff;
mod fit;
mod generate;
mod info;
mod interpolate;
mod isotropic;
mod layer;
mod peaks;
mod plot;

use clap::Subcommand;
use lucarne::bins::{AngleBasis, KlemsBasis};
use lucarne::bsdf::{self, Block, Bsdf, interpolant, scans};
use lucarne::{Error, Result, Warnings};
use std::path::Path;
use std::process::ExitCode;

/// Arguments of `lucarne bsdf`.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Fit(fit::Args),
    Generate(Box<generate::Args>),
    Info(info::Args),
    Check(check::Args),
    Isotropic(isotropic::Args),
    Layer(layer::Args),
    Plot(plot::Args),
    Interpolate(interpolate::Args),
    Convert(convert::Args),
    Diff(diff::Args),
    Peaks(peaks::Args),
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    match args.verb {
        Verb::Fit(args) => fit::run(&args, warnings),
        Verb::Generate(args) => generate::run(&args, warnings),
        Verb::Info(args) => info::run(&args, warnings),
        Verb::Check(args) => check::run(&args, warnings),
        Verb::Isotropic(args) => isotropic::run(&args, warnings),
        Verb::Layer(args) => layer::run(&args, warnings),
        Verb::Plot(args) => plot::run(&args, warnings),
        Verb::Interpolate(args) => interpolate::run(&args, warnings),
        Verb::Convert(args) => convert::run(&args, warnings),
        Verb::Diff(args) => diff::run(&args, warnings),
        Verb::Peaks(args) => peaks::run(&args, warnings),
    }
}

/// The command that made a file, for its comment.
fn made_by() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("Created by: lucarne {}", arguments.join(" "))
}

/// A file of scattering data; of an interpolant, or of measurements in one table, the Klems matrix that they give.
fn read_any(path: &Path, warnings: &mut Warnings) -> Result<Bsdf> {
    let found = if interpolant::is_interpolant(path) {
        interpolant::read(path, warnings)?
    } else if scans::is_scan(path) {
        let scans = scans::read(&[path.to_path_buf()], &scans::Options::default(), warnings)?;
        interpolant::fit(&scans, &interpolant::FitOptions::default(), warnings).map_err(|e| e.file(path))?
    } else {
        return bsdf::read(path, warnings);
    };
    let basis = AngleBasis::from(KlemsBasis::Full);
    let mut bsdf = Bsdf { name: found.name.clone(), manufacturer: found.manufacturer.clone(), ..Bsdf::default() };
    *bsdf.visible.slot(found.component) = Some(Block::Klems(interpolant::to_klems(&found, &basis, &basis)));
    Ok(bsdf)
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
