//! Command line: one module per verb. Each verb has an `Args` (clap) and
//! `run(args, warnings) -> Result<ExitCode>`; this module chooses the verb and prints errors.

mod bsdf;
mod devices;
mod falsecolor;
mod glare;
mod keys;
mod matrix;
mod matrix_args;
mod matrix_coefficients;
mod matrix_picture;
mod matrix_sun;
mod metrics;
mod multiply;
pub mod output;
mod plan;
mod progress;
mod report;
mod run;
mod scene;
mod sky;
mod tradeoff;
mod view;
mod viewer;

use clap::{Parser, Subcommand};
use lucarne::simulate::Project;
use lucarne::{Error, ErrorKind, Result, Warnings};
use std::path::Path;
use std::process::ExitCode;

/// Annual daylight and glare simulation of rooms with complex windows, on any GPU.
#[derive(Parser)]
#[command(name = "lucarne", version, about, propagate_version = true, after_help = progress::EXIT_CODES, allow_negative_numbers = true)]
struct Cli {
    /// How progress is shown on standard error
    #[arg(long, global = true, value_enum, value_name = "HOW", default_value = "auto")]
    progress: progress::Shown,

    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// The BSDF bench: look at, check, make and convert scattering data of windows.
    Bsdf(bsdf::Args),
    /// One phase of the matrix methods: view matrix V or daylight matrix D (as rfluxmtx).
    Matrix(matrix::Args),
    /// What scene files hold, and what looks wrong with them.
    Scene(scene::Args),
    /// Sky matrix from a weather file (as gendaymtx).
    Sky(sky::Args),
    /// Product of matrices V·T·D·S (as dctimestep).
    Multiply(multiply::Args),
    /// Luminance as colours with a legend, from a picture (as falsecolor).
    Falsecolor(falsecolor::Args),
    /// Discomfort glare of pictures: DGP, UGR and others (as evalglare).
    Glare(Box<glare::Args>),
    /// GPU devices of this machine, the preferred one first.
    ///
    /// Any device will do that has WebGPU's default limits: 8 storage buffers and 256 invocations a workgroup, 16 KiB of
    /// its memory, bindings of 128 MiB. Neither 64-bit numbers nor subgroups are needed. A scene is one binding: about
    /// two million triangles fit 128 MiB, and more where a device binds more. LUCARNE_LIMITS=webgpu holds any device
    /// to these limits; results keep their bits.
    Devices(devices::Args),
    /// All keys of a project file, with their values and defaults.
    Keys(keys::Args),
    /// What a run of a project will do, and what it leaves out.
    Plan(plan::Args),
    /// A whole project: a year of illuminance from a project.toml.
    Run(run::Args),
    /// Named metrics of a finished result folder again, with other hours: nothing is traced.
    Metrics(metrics::Args),
    /// A page of results to read, print and send: plan, heat maps, glare, errors.
    Report(report::Args),
    /// Error against time: which settings of a project are worth their time.
    Tradeoff(tradeoff::Args),
    /// Look at results, BSDFs and pictures in a window.
    View(viewer::Args),
}

pub fn main() -> ExitCode {
    let arguments = radiance_style_arguments(std::env::args_os());
    let cli = Cli::parse_from(arguments);
    progress::show_as(cli.progress);
    let mut warnings = Warnings::new();
    let result: Result<ExitCode> = match cli.verb {
        Verb::Bsdf(args) => bsdf::run(args, &mut warnings),
        Verb::Matrix(args) => matrix::run(args, &mut warnings),
        Verb::Scene(args) => scene::run(args, &mut warnings),
        Verb::Sky(args) => sky::run(args, &mut warnings),
        Verb::Multiply(args) => multiply::run(args, &mut warnings),
        Verb::Falsecolor(args) => falsecolor::run(args, &mut warnings),
        Verb::Plan(args) => plan::run(args, &mut warnings),
        Verb::Run(args) => run::run(args, &mut warnings),
        Verb::Metrics(args) => metrics::run(&args),
        Verb::Report(args) => report::run(&args),
        Verb::Tradeoff(args) => tradeoff::run(args, &mut warnings),
        Verb::Glare(args) => glare::run(*args, &mut warnings),
        Verb::Keys(args) => keys::run(args, &mut warnings),
        Verb::Devices(args) => devices::run(args, &mut warnings),
        Verb::View(args) => viewer::run(args),
    };
    show(&mut warnings);
    match result {
        Ok(code) => code,
        // Who read the output has had enough of it (`| head`).
        Err(error) if error.kind() == ErrorKind::Closed => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lucarne: error: {error}");
            progress::failure(&error)
        }
    }
}

/// The project of a project file, or of a Honeybee model with its weather.
fn project(file: &Path, weather: Option<&Path>, folder: Option<&Path>) -> Result<Project> {
    let is_model = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("hbjson") || e.eq_ignore_ascii_case("hbpkl"));
    match (is_model, weather) {
        (true, Some(weather)) => Project::of_model(file, weather, folder),
        (true, None) => Err(Error::new("a model has no weather").file(file).help("add --weather city.epw (or .wea)")),
        (false, Some(_)) => {
            Err(Error::new("--weather goes with a Honeybee model; a project file names its own").file(file).help("take --weather out"))
        }
        (false, None) => Project::read(file),
    }
}

/// Prints the warnings that have not been printed yet.
fn show(warnings: &mut Warnings) {
    for warning in warnings.take_new() {
        eprintln!("lucarne: warning: {warning}");
    }
}

/// Lets Radiance's single-dash words (`-ab 4`, `-vta`, `-of`) pass through clap, which knows only
/// `--ab`: a single dash followed by two or more letters becomes a double dash. `-O0`, `-5` and
/// single letters stay as they are.
fn radiance_style_arguments(arguments: impl Iterator<Item = std::ffi::OsString>) -> Vec<std::ffi::OsString> {
    arguments
        .map(|a| match a.to_str() {
            // genBSDF's tensor trees; other letters with a number behind are short options with a value.
            Some("-t3" | "-t4") => format!("-{}", a.to_string_lossy()).into(),
            Some(s) if s.len() > 2 && s.starts_with('-') && s[1..].chars().take(2).all(|c| c.is_ascii_alphabetic()) => {
                format!("-{s}").into()
            }
            _ => a,
        })
        .collect()
}
