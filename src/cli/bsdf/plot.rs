//! `lucarne bsdf plot`.

use glam::DVec3;
use lucarne::bins::AngleBasis;
use lucarne::bsdf::{Block, Blocks};
use lucarne::image::hemisphere::{Content, Hemisphere, HemispherePlot, Patch};
use lucarne::image::palette::{Palette, Scale};
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// Hemisphere plots of where light goes: transmission and reflection of either side, PNG or SVG.
///
/// Each disc shows all directions in which light leaves, for one direction from which it comes.
/// Both are directions of TRAVEL in the window's frame (φ from the right, counter-clockwise, for
/// somebody inside who looks out): what passes straight, and what is mirrored, stays at the mark.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  lucarne bsdf plot film.xml -o film.png\n  lucarne bsdf plot blinds.xml --incident 40,270 --linear -o blinds.svg"
)]
pub struct Args {
    /// XML file; or an interpolant (.sir), as the Klems matrix that it gives.
    file: PathBuf,
    /// Direction in which the incident light travels: θ,φ in degrees; φ 270 is downwards.
    #[arg(long, value_delimiter = ',', num_args = 1, default_value = "40,270")]
    incident: Vec<f64>,
    /// Band: visible or solar.
    #[arg(long, default_value = "visible")]
    band: String,
    /// Linear instead of logarithmic colours.
    #[arg(long)]
    linear: bool,
    /// Decades of a logarithmic scale.
    #[arg(long, default_value_t = 4.0)]
    decades: f64,
    /// Largest value of the scale, 1/sr; the largest value shown if absent.
    #[arg(long)]
    max: Option<f64>,
    /// Palette: viridis, cividis, hot, gray, …
    #[arg(long, default_value = "viridis")]
    palette: String,
    /// Pixels per unit of the drawing (PNG).
    #[arg(long, default_value_t = 2.0)]
    scale: f64,
    /// PNG or SVG file to write.
    #[arg(short, long)]
    output: PathBuf,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let [theta, phi] = args.incident[..] else {
        return Err(Error::new("two angles are needed: θ,φ").field("--incident").help("for instance --incident 40,270"));
    };
    if !(0.0..=90.0).contains(&theta) || !phi.is_finite() {
        return Err(Error::new(format!("θ = {theta}° is not within 0…90°")).field("--incident"));
    }
    let mut file = super::read_any(&args.file, warnings)?;
    let blocks: Blocks = file
        .band_mut(&args.band)
        .map(std::mem::take)
        .filter(|b| !b.is_empty())
        .ok_or_else(|| Error::new(format!("the file has no {} data", args.band)).field("--band").file(&args.file))?;
    let incident = direction(theta, phi);
    let largest = blocks.iter().map(|(_, b)| largest_value(b, incident)).fold(0.0, f64::max);
    let top = args.max.unwrap_or(if largest > 0.0 { largest } else { 1.0 });
    let scale = if args.linear { Scale::linear(0.0, top) } else { Scale::logarithmic(top, args.decades) };
    let functions: Vec<_> = blocks
        .iter()
        .map(|(component, block)| (component, block, move |t: f64, p: f64| block.evaluate(direction(t, p), incident)))
        .collect();
    let hemispheres = functions
        .iter()
        .map(|(component, block, function)| Hemisphere {
            title: format!("{}: {:.3} of the light", component.xml_name(), block.direct_hemispherical(incident)),
            content: match block {
                Block::Klems(m) => Content::Patches(patches(m.outgoing(), |o| m.at(o, m.incident().bin_of(incident)))),
                Block::Tree(_) => Content::Function(function),
            },
            mark: Some([theta, phi]),
        })
        .collect();
    let name = if file.name.is_empty() { args.file.display().to_string() } else { file.name.clone() };
    let plot = HemispherePlot {
        hemispheres,
        columns: 2,
        title: format!("{name}: light travelling along θ {theta}°, φ {phi}°"),
        label: "1/sr".into(),
        palette: Palette::from_name(&args.palette)?,
        scale: scale.map_err(|e| e.field("--max"))?,
    };
    plot.draw()?.write(&args.output, args.scale)?;
    Ok(ExitCode::SUCCESS)
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin, cos) = theta.to_radians().sin_cos();
    let (y, x) = phi.to_radians().sin_cos();
    DVec3::new(sin * x, sin * y, cos)
}

fn largest_value(block: &Block, incident: DVec3) -> f64 {
    match block {
        Block::Klems(m) => (0..m.outgoing().len()).map(|o| m.at(o, m.incident().bin_of(incident))).fold(0.0, f64::max),
        Block::Tree(_) => {
            let n = 128;
            let at = |k: usize| {
                let (u, v) = (((k / n) as f64 + 0.5) / n as f64, ((k % n) as f64 + 0.5) / n as f64);
                let [x, y] = lucarne::bins::shirley_chiu::disk_from_square(u, v);
                block.evaluate(DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()), incident)
            };
            (0..n * n).map(at).fold(0.0, f64::max)
        }
    }
}

fn patches(basis: &AngleBasis, value: impl Fn(usize) -> f64) -> Vec<Patch> {
    (0..basis.len())
        .map(|bin| {
            let (ring, position) = basis.ring_of(bin);
            let width = 360.0 / ring.bins as f64;
            let from = (position as f64 - 0.5) * width;
            Patch { theta: [ring.theta_min, ring.theta_max], phi: [from, from + width], value: value(bin) }
        })
        .collect()
}
