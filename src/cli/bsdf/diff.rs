//! `lucarne bsdf diff`.

use lucarne::bins::AngleBasis;
use lucarne::bsdf::difference::{Comparison, compare};
use lucarne::{Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// How two BSDF files differ, component by component; interpolants (.sir) as the Klems matrices that they give.
///
/// Exit code 0: equal within the tolerance. 1: different.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  lucarne bsdf diff measured.xml simulated.xml --tolerance 0.01")]
pub struct Args {
    /// First file; its basis is used.
    first: PathBuf,
    /// Second file.
    second: PathBuf,
    /// Accepted difference of hemispherical values and (per sr) of single values.
    #[arg(long, default_value_t = 1e-6)]
    tolerance: f64,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let (first, second) = (super::read_any(&args.first, warnings)?, super::read_any(&args.second, warnings)?);
    let mut agree = true;
    for difference in compare(&first, &second) {
        agree &= difference.result.agrees(args.tolerance);
        let place = format!("{} {}", difference.band, difference.component.xml_name());
        match &difference.result {
            Comparison::OnlyFirst => println!("{place:<28} only in {}", args.first.display()),
            Comparison::OnlySecond => println!("{place:<28} only in {}", args.second.display()),
            Comparison::Both { hemispherical: [a, b], direct_hemispherical, largest, rms, resampled, incident, outgoing } => {
                println!(
                    "{place:<28} hemispherical {a:.5} {b:.5} ({:+.2e}){}",
                    b - a,
                    if *resampled { "; compared over a common basis" } else { "" }
                );
                let (value, out, inc) = largest;
                println!(
                    "{:28} RMS {rms:.3e}/sr, largest {value:.3e}/sr from {} to {}",
                    "",
                    angles(incident, *inc),
                    angles(outgoing, *out)
                );
                let (value, bin) = direct_hemispherical;
                println!("{:28} direct-hemispherical by at most {value:.3e}, from {}", "", angles(incident, *bin));
            }
        }
    }
    println!("{}", if agree { "equal within the tolerance" } else { "different" });
    Ok(if agree { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn angles(basis: &AngleBasis, bin: usize) -> String {
    let c = basis.centre(bin);
    let (ring, _) = basis.ring_of(bin);
    let phi = c.y.atan2(c.x).to_degrees().rem_euclid(360.0);
    format!("bin {bin} (θ {}-{}°, φ {phi:.0}°)", ring.theta_min, ring.theta_max)
}
