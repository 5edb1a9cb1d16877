//! `lucarne bsdf fit`.

use glam::DVec3;
use lucarne::bsdf::interpolant::{self, FitOptions, Interpolant, Symmetry};
use lucarne::bsdf::scans;
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// From goniophotometer scans to an interpolant: scattering for any two directions.
///
/// Reads text files of one incident direction each, as Radiance's pabopto2bsdf does, or CSV files of θ_in, φ_in, θ_out,
/// φ_out and value. Writes Radiance's .sir, which bsdf2ttree and bsdf2klems read, with a part of its own after it.
/// One component at a time: transmission and reflection of either side are put together by `lucarne bsdf convert`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  lucarne bsdf fit scans/*.dat --symmetry bilateral -o fabric.sir\n  \
    lucarne bsdf fit -t --only reflection sphere.csv -o outside.sir\n  lucarne bsdf convert fabric.sir outside.sir --to t4:6 --reduce 97 -o fabric.xml")]
pub struct Args {
    /// Measurements of one component: light from one side that leaves on one side.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// isotropic, quadrilateral, bilateral, up (turned by 180°) or anisotropic; by the incident azimuths if absent.
    #[arg(short, long)]
    symmetry: Option<String>,
    /// The sample's front, from which θ counts, faces the outside; without it the room.
    #[arg(short = 't', long)]
    reversed: bool,
    /// Uses only these samples of files with both: transmission or reflection.
    #[arg(long)]
    only: Option<String>,
    /// Leaves out samples closer than so many degrees to the sample's plane.
    #[arg(short, long, default_value_t = 0.0)]
    grazing: f64,
    /// Samples on a plane to within this share become one lobe.
    #[arg(long, default_value_t = FitOptions::default().tolerance)]
    tolerance: f64,
    /// Most lobes per incident direction.
    #[arg(long, default_value_t = FitOptions::default().lobes)]
    lobes: usize,
    /// Threads; all cores if absent.
    #[arg(short = 'n', long)]
    threads: Option<usize>,
    /// File to write.
    #[arg(short, long)]
    output: PathBuf,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let transmitted = match args.only.as_deref() {
        None => None,
        Some("transmission") => Some(true),
        Some("reflection") => Some(false),
        Some(other) => return Err(Error::new(format!("'{other}' is neither transmission nor reflection")).field("--only")),
    };
    let within = |name: &str, value: f64, most: f64| {
        if (0.0..=most).contains(&value) {
            Ok(())
        } else {
            Err(Error::new(format!("{value} is not within 0…{most}")).field(name.to_string()))
        }
    };
    within("--grazing", args.grazing, 45.0)?;
    within("--tolerance", args.tolerance, 1.0)?;
    if !(10..=8192).contains(&args.lobes) {
        return Err(Error::new(format!("{} is not within 10…8192", args.lobes)).field("--lobes"));
    }
    if let Some(threads) = args.threads {
        // Fails only if there are threads already; then these are used.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.min(1024)).build_global();
    }
    let symmetry = args.symmetry.as_deref().map(Symmetry::by_name).transpose().map_err(|e| e.field("--symmetry"))?;
    let scans = scans::read(&args.files, &scans::Options { reversed: args.reversed, transmitted, grazing: args.grazing }, warnings)?;
    let fitted = interpolant::fit(&scans, &FitOptions { symmetry, tolerance: args.tolerance, lobes: args.lobes }, warnings)?;
    interpolant::write(&args.output, &fitted, &super::made_by())?;
    eprint!("{}", describe(&fitted));
    Ok(ExitCode::SUCCESS)
}

/// The text of `lucarne bsdf info` for an interpolant.
pub fn describe(interpolant: &Interpolant) -> String {
    let name = if interpolant.name.is_empty() { "(none)" } else { &interpolant.name };
    let mut text = format!(
        "name          {name}\ncomponent     {}\nsymmetry      {}\nlobes         {} in {} incident directions\n",
        interpolant.component.xml_name(),
        interpolant.symmetry.name(),
        interpolant.lobes(),
        interpolant.distributions.len()
    );
    for note in &interpolant.notes {
        text += &format!("measured      {note}\n");
    }
    text += "\nlight travels along     direct-hemispherical   peak at (travel)    DSF, 1/sr   width\n";
    for theta in (0..6).map(|k| 15.0 * f64::from(k)) {
        let (s, c) = f64::to_radians(theta).sin_cos();
        let light = DVec3::new(0.0, -s, c);
        let peak = interpolant::peak(interpolant, light);
        let phi = peak.direction.y.atan2(peak.direction.x).to_degrees().rem_euclid(360.0);
        let beyond = if theta > interpolant.last_theta() + 0.5 { "  beyond the measured directions" } else { "" };
        text += &format!(
            "θ {theta:>4.0}°  φ 270° {:>19.5} {:>14} θ {:>4.1}°  φ {phi:>3.0}° {:>12.4} {:>6.1}°{beyond}\n",
            interpolant.direct_hemispherical(light),
            "",
            peak.direction.z.clamp(-1.0, 1.0).acos().to_degrees(),
            peak.value,
            peak.width
        );
    }
    text
}

/// The text of `lucarne bsdf info` for measurements.
pub fn describe_scans(path: &std::path::Path, warnings: &mut Warnings) -> Result<String> {
    let mut text = String::from("component              θ      φ (travel)  samples    light     largest DSF   noise\n");
    for (what, transmitted) in [("transmission", true), ("reflection", false)] {
        let options = scans::Options { transmitted: Some(transmitted), ..scans::Options::default() };
        let Ok(found) = scans::read_one(path, &options, warnings) else { continue };
        for scan in found {
            text += &format!(
                "{what:<14} {:>9.1}° {:>9.1}° {:>12} {:>9.5} {:>13.4} {:>9.1e}\n",
                scan.theta(),
                scan.phi(),
                scan.samples,
                scan.grid.integral(),
                scan.largest.0,
                scan.noise()
            );
        }
    }
    if text.lines().count() == 1 {
        scans::read_one(path, &scans::Options::default(), warnings)?;
    }
    Ok(text)
}
