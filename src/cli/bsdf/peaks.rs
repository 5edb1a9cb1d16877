//! `lucarne bsdf peaks`.

use glam::DVec3;
use lucarne::bsdf::evaluate::Scattering;
use lucarne::files::write_atomically;
use lucarne::{Error, Result, Warnings};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

/// Whether Radiance's material aBSDF takes the light that passes undeviated out of a file's data, direction by direction.
///
/// One row per direction in which the light travels: θ and φ (degrees), the present criterion (1 if it finds a peak), the
/// published one of 2021, and of the peak its transmittance, what remains around it (1/sr), and its full width (degrees).
/// Where a window's peak is found in some hours and not in others, its sun and its view change between these hours.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  lucarne bsdf peaks fabric_t4.xml -o peaks.csv")]
pub struct Args {
    /// XML file.
    file: PathBuf,
    /// Step of θ, degrees.
    #[arg(long, default_value_t = 5.0)]
    step: f64,
    /// Step of φ, degrees.
    #[arg(long, default_value_t = 30.0)]
    azimuth_step: f64,
    /// Looks at light from the room in place of light from the outside.
    #[arg(long)]
    from_room: bool,
    /// CSV file to write; standard output if absent.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    for (name, step, most) in [("--step", args.step, 45.0), ("--azimuth-step", args.azimuth_step, 360.0)] {
        if !(0.1..=most).contains(&step) {
            return Err(Error::new(format!("{step}° is not within 0.1…{most}°")).field(name));
        }
    }
    let bsdf = super::read_any(&args.file, warnings)?;
    let scattering = Scattering::checked(&bsdf, warnings).map_err(|e| e.file(&args.file))?;
    let mut text = String::from("theta_deg,phi_deg,peak,published_peak,transmittance,surround_per_sr,width_deg,direct_hemispherical\n");
    let (mut found, mut published, mut all) = (0, 0, 0);
    let steps = |step: f64, end: f64| (0..).map(move |k| f64::from(k) * step).take_while(move |a| *a < end - 1e-9);
    for theta in steps(args.step, 90.0) {
        for phi in steps(args.azimuth_step, if theta == 0.0 { 1e-3 } else { 360.0 }) {
            let ((s, c), (y, x)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
            let light = DVec3::new(s * x, s * y, if args.from_room { -c } else { c });
            let (peak, by_paper) = (scattering.peak(light), scattering.has_published_peak(light));
            all += 1;
            found += usize::from(peak.is_some());
            published += usize::from(by_paper);
            let _ = write!(text, "{theta},{phi},{},{},", u8::from(peak.is_some()), u8::from(by_paper));
            let _ = match peak {
                // The cell's projected solid angle, as a disc.
                Some(p) => write!(
                    text,
                    "{:.6},{:.6},{:.3},",
                    p.transmittance,
                    p.surround,
                    2.0 * (p.cell / c.max(1e-3) / std::f64::consts::PI).sqrt().min(1.0).asin().to_degrees()
                ),
                None => write!(text, "0,,,"),
            };
            let _ = writeln!(text, "{:.6}", scattering.direct_hemispherical(light, true));
        }
    }
    eprintln!("a peak in {found} of {all} directions by the present criterion, in {published} by the published one");
    match &args.output {
        Some(path) => write_atomically(path, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io(path, &e)))?,
        None => print!("{text}"),
    }
    Ok(ExitCode::SUCCESS)
}
