//! `lucarne run`: a whole project.

use super::progress::Terminal;
use lucarne::gpu::Device;
use lucarne::simulate::rooms::{Room, run_rooms};
use lucarne::simulate::{Plan, Summary, without_pruning};
use lucarne::{Error, Result, Warnings};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Computes a year of illuminance, pictures and glare for the project in a project.toml, or for
/// several rooms, each in its project file; or for a Honeybee model:
/// lucarne run model.hbjson --weather city.epw -o out
///
/// A project file is TOML; its sections and keys stand in the documentation of lucarne::simulate::project, what is
/// behind them in the guide (cargo doc --open). A window of ordinary glass is glass = 0.65, its visible transmittance.
#[derive(clap::Args)]
pub struct Args {
    /// Project files, or one Honeybee model (.hbjson); of several each has its results in a folder of its name, and matrices of the
    /// same inputs are computed once
    #[arg(required = true, value_name = "PROJECT")]
    projects: Vec<PathBuf>,

    /// Weather of a Honeybee model given in place of a project file, EPW or WEA. All its apertures, modifiers and
    /// sensor grids are taken; FOLDER/project.toml is written, to which sections like [quality], [glare] may be added
    #[arg(long, value_name = "WEATHER")]
    weather: Option<PathBuf>,

    /// Folder for the results; matrices already there are used again if their inputs are the same
    #[arg(short = 'o', value_name = "FOLDER", default_value = "out")]
    output: PathBuf,

    /// Device: a number of `lucarne devices`, or part of a name (default: LUCARNE_DEVICE, else the best)
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,

    /// Memory that matrices and tables may take at a time, as 512M or 4G: less makes smaller tiles, and changes no result
    /// (default: half of what is free)
    #[arg(long, value_name = "SIZE")]
    memory: Option<String>,

    /// Model also what `lucarne plan` would leave out: a check that it changes nothing
    #[arg(long)]
    no_prune: bool,
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    if let Some(memory) = &args.memory {
        lucarne::gpu::allow_memory(super::multiply::parse_memory(memory)?);
    }
    // All files first: a slip in one of them should not wait for a device, nor a doubt for the results.
    let (device, terminal) = (|| Device::open(args.device.as_deref()), Terminal::new());
    if let [file] = &args.projects[..] {
        let mut plan = Plan::new(super::project(file, args.weather.as_deref(), Some(&args.output))?, warnings)?;
        if args.no_prune {
            plan = plan.without_pruning();
        }
        super::show(warnings);
        let summary = plan.write(&device()?, &args.output, &terminal, warnings)?;
        terminal.finish();
        report(&args.output, &summary);
        return Ok(ExitCode::SUCCESS);
    }
    if args.weather.is_some() {
        return Err(Error::new("--weather goes with one Honeybee model").help("give project files without it, or one .hbjson file"));
    }
    let mut rooms = Room::read_all(&args.projects, warnings)?;
    if args.no_prune {
        rooms.iter_mut().for_each(|room| without_pruning(&mut room.project, &mut room.inputs));
    }
    super::show(warnings);
    let summaries = run_rooms(&device()?, &rooms, &args.output, &terminal, warnings)?;
    terminal.finish();
    for (room, summary) in rooms.iter().zip(&summaries) {
        report(&args.output.join(&room.name), summary);
    }
    let annual = args.output.join("glare/annual.csv");
    if rooms.iter().any(|r| r.project.glare.is_some()) {
        println!("{}: all {} rooms", annual.display(), rooms.len());
    }
    Ok(ExitCode::SUCCESS)
}

fn report(output: &Path, summary: &Summary) {
    for sensors in &summary.sensors {
        let file = output.join(&summary.quantity).join(format!("{}.mtx", sensors.name));
        let mean = match (sensors.mean_illuminance_lx, sensors.mean_irradiance_w_m2) {
            (Some(lux), _) => format!("{lux:.0} lx"),
            (None, watts) => format!("{:.1} W/m²", watts.unwrap_or_default()),
        };
        println!("{}: {} sensors, {} hours, mean {mean}", file.display(), sensors.count, summary.hours);
        if let Some(share) = sensors.mean_daylight_factor {
            println!("  mean daylight factor {:.2} %", 100.0 * share);
        }
        super::metrics::print(&sensors.metrics);
    }
    super::metrics::print(&summary.metrics);
    for view in &summary.views {
        let place = match view.pictures {
            0 => output.join("matrices").join(format!("V_{}.mtx", view.name)),
            _ => output.join("images").join(&view.name),
        };
        let error = view.eye_error.map_or(String::new(), |e| format!(", standard error {:.2} % of a year at the eye", 100.0 * e));
        println!("{}: {} pixels, {} pictures{error}", place.display(), view.pixels, view.pictures);
    }
    if let Some(glare) = &summary.glare {
        let states = if glare.states > 1 { format!(", {} states of the façade", glare.states) } else { String::new() };
        let place = output.join("glare/annual.csv");
        println!("{}: {} views{states}, {} hours with light, method {}", place.display(), glare.views, glare.hours, glare.method);
        super::metrics::print(&glare.metrics);
    }
    if let Some(e) = summary.estimated_error {
        let met = match (e.target, e.target_met) {
            (Some(target), Some(true)) => format!(" (target {:.1} %: met)", 100.0 * target),
            (Some(target), _) => format!(" (target {:.1} %: NOT met)", 100.0 * target),
            _ => String::new(),
        };
        println!(
            "standard error: {:.2} % of a year at the worst sensor{met}, {:.2} % at the median one; {:.2} % of a single hour (median)",
            100.0 * e.annual_largest,
            100.0 * e.annual_median,
            100.0 * e.hourly_median
        );
    }
    for window in summary.windows.iter().filter(|w| w.parts.is_doubtful()) {
        println!("window {}: {}", window.name, window.parts.because);
    }
    let rate = summary.rays_per_second.map(|r| format!(", {:.1} million rays/s", r / 1e6)).unwrap_or_default();
    println!("{:.1} s on {}{rate}", summary.seconds.total, summary.device.name);
}
