//! `lucarne bsdf info`.

use lucarne::bsdf::{self, Blocks, Bsdf, TransmissionSource, interpolant, scans};
use lucarne::{Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// What a BSDF file holds: basis, blocks, transmittance and reflectance of either side.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  lucarne bsdf info clear.xml")]
pub struct Args {
    /// XML file of WINDOW, genBSDF or wrapBSDF; interpolant (.sir); or measurements of a goniophotometer.
    file: PathBuf,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    if interpolant::is_interpolant(&args.file) {
        print!("{}", super::fit::describe(&interpolant::read(&args.file, warnings)?));
        return Ok(ExitCode::SUCCESS);
    }
    if scans::is_scan(&args.file) {
        print!("{}", super::fit::describe_scans(&args.file, warnings)?);
        return Ok(ExitCode::SUCCESS);
    }
    let bsdf = bsdf::read(&args.file, warnings)?;
    print!("{}", describe(&bsdf));
    Ok(ExitCode::SUCCESS)
}

/// The text of `lucarne bsdf info`.
fn describe(bsdf: &Bsdf) -> String {
    let or_none = |s: &str| if s.is_empty() { "(none)".to_string() } else { s.to_string() };
    let mut text = format!("name          {}\nmanufacturer  {}\n", or_none(&bsdf.name), or_none(&bsdf.manufacturer));
    if !bsdf.device_type.is_empty() {
        text += &format!("device type   {}\n", bsdf.device_type);
    }
    for (what, length) in [("thickness", bsdf.thickness), ("width", bsdf.width), ("height", bsdf.height)] {
        if let Some(metres) = length {
            text += &format!("{what:<13} {} mm\n", (metres * 1e6).round() / 1e3);
        }
    }
    if let Some(geometry) = &bsdf.geometry {
        text += &format!("geometry      {} ({} bytes)\n", geometry.format, geometry.text.len());
    }
    for (name, blocks) in bsdf.bands().into_iter().filter(|(_, blocks)| !blocks.is_empty()) {
        text += &describe_band(name, blocks);
    }
    if !bsdf.skipped.is_empty() {
        text += &format!("not read      {}\n", bsdf.skipped.join(", "));
    }
    text += "\nFront is WINDOW's: light from the outside; Radiance calls the room side front.\n";
    text += &match bsdf::transmission_source(bsdf) {
        Ok(TransmissionSource::Front) => "A simulation uses Visible / Transmission Front.\n".to_string(),
        Ok(TransmissionSource::BackReversed) => {
            "A simulation uses Visible / Transmission Back, reversed by reciprocity, because Front is missing.\n".to_string()
        }
        Err(e) => format!("A simulation cannot use this file: {}.\n", e.message()),
    };
    text
}

fn describe_band(name: &str, blocks: &Blocks) -> String {
    let angles = [0.0, 20.0, 40.0, 60.0];
    let mut text = format!("\n{name:<19} hemispherical   direct-hemispherical at 0, 20, 40, 60 degrees (mean over azimuth)\n");
    for (component, block) in blocks.iter() {
        text += &format!("{:<19} {:>13.4}  ", component.xml_name(), block.hemispherical());
        for angle in angles {
            text += &format!(" {:>7.4}", block.direct_hemispherical_at(angle));
        }
        text += &format!("   {}\n", block.describe());
    }
    text
}
