//! `lucarne tradeoff`: error against time.

mod radiance;

use super::progress::Terminal;
use lucarne::gpu::Device;
use lucarne::simulate::tradeoff::{Choice, Point, Sweep, TARGET, knobs, write};
use lucarne::simulate::{Inputs, Project};
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// Sweeps samples, bounces, basis, parts of windows, sky, picture size and method of a project; writes error against
/// time, the front of the best settings, and one that is recommended.
///
/// Where Radiance's rfluxmtx is found on PATH, its error and time are measured beside, on the same
/// room, with the same BSDFs and sky, against the same reference.
#[derive(clap::Args)]
pub struct Args {
    /// Project file
    project: PathBuf,

    /// Folder for tradeoff.csv, .png and .svg
    #[arg(short = 'o', value_name = "FOLDER", default_value = "tradeoff")]
    output: PathBuf,

    /// Only these: samples, bounces, basis, parts, sky, picture, method (default: all that make sense)
    #[arg(long, value_name = "KNOB,…", value_delimiter = ',')]
    only: Vec<String>,

    /// Leave Radiance out
    #[arg(long)]
    no_radiance: bool,

    /// Device: a number of `lucarne devices`, or part of a name (default: LUCARNE_DEVICE, else the best)
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
}

const FAMILIES: [&str; 7] = ["samples", "bounces", "basis", "parts", "sky", "picture", "method"];

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    if let Some(unknown) = args.only.iter().find(|k| !FAMILIES.contains(&k.as_str())) {
        return Err(Error::new(format!("'{unknown}' cannot be swept"))
            .field("--only")
            .help(format!("choose among {}", FAMILIES.join(", "))));
    }
    let project = Project::read(&args.project)?;
    let inputs = Inputs::read(&project, warnings)?;
    if inputs.sensors.is_empty() && project.glare.is_none() {
        return Err(Error::new("there is nothing whose error could be measured: no sensors and no [glare]").file(&args.project));
    }
    let mut all = knobs(&project, &inputs);
    // Samples are always there: the scale of everything else.
    all.retain(|k| k.names().0 == "samples" || args.only.is_empty() || args.only.iter().any(|o| o == k.names().0));
    std::fs::create_dir_all(&args.output).map_err(|e| Error::io(&args.output, &e))?;
    let device = Device::open(args.device.as_deref())?;
    let terminal = Terminal::new();
    let sweep = Sweep { device: &device, project: &project, inputs: &inputs, folder: &args.output, knobs: all };
    let programs = if args.no_radiance { None } else { radiance::Programs::find() };
    let beside = programs.is_some();
    let points = sweep.run(&terminal, warnings, &mut |reference, progress| match &programs {
        Some(programs) if !inputs.sensors.is_empty() => programs.measure(&inputs, &args.output.join("radiance"), reference, progress),
        _ => Ok(Vec::new()),
    })?;
    terminal.finish();
    let name = project.folder().file_name().map_or_else(|| "project".into(), |n| n.to_string_lossy().into_owned());
    let choice = write(&args.output, &name, &points)?;
    report(&points, &choice);
    if !beside && !args.no_radiance {
        println!("Radiance is not on PATH: without its curve");
    }
    println!("{}", args.output.join("tradeoff.png").display());
    Ok(ExitCode::SUCCESS)
}

fn report(points: &[Point], choice: &Choice) {
    println!("{:<10} {:<10} {:<14} {:>9} {:>9} {:>9}   {:>9} {:>9}", "", "", "", "seconds", "hourly", "annual", "seconds", "DGP");
    for (i, p) in points.iter().enumerate() {
        let lux = p.illuminance.map_or_else(
            || format!("{:>9} {:>9} {:>9}", "", "", ""),
            |m| format!("{:>9.2} {:>7.2} % {:>7.2} %", m.seconds, 100.0 * m.hourly, 100.0 * m.annual),
        );
        let glare = p.glare.map_or_else(String::new, |(s, e)| format!("{s:>9.2} {e:>9.5}"));
        let marks = [
            (choice.front.contains(&i), "front"),
            (choice.recommended == Some(i), "recommended"),
            (choice.glare_recommended == Some(i), "recommended for glare"),
        ];
        let marks: Vec<&str> = marks.iter().filter(|(yes, _)| *yes).map(|(_, m)| *m).collect();
        println!("{:<10} {:<10} {:<14} {lux}   {glare}  {}", p.program, p.knob, p.value, marks.join(", "));
    }
    if let Some(p) = choice.recommended.map(|i| &points[i]) {
        let error = p.illuminance.map_or(0.0, |m| m.hourly);
        let good = if error <= TARGET { "the fastest within" } else { "the best there is, though not within" };
        println!("recommended: {} {}, {good} {:.0} % of an hour's illuminance", p.knob, p.value, 100.0 * TARGET);
    }
}
