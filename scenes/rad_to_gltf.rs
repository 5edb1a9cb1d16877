//! Writes a room of Radiance files as glTF, its windows and sensors marked and its materials exact:
//!
//! ```text
//! cd scenes/office
//! cargo run --release --example rad_to_gltf -- office.gltf materials.rad office.rad \
//!     --window windows/vision.rad --window windows/clerestory.rad --sensors workplane.txt --sensors eyes.txt
//! ```

use lucarne::scene::gltf;
use lucarne::scene::points::SensorGrid;
use lucarne::scene::{points, rad};
use lucarne::{Error, Result, Warnings};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut warnings = Warnings::new();
    let result = run(std::env::args().skip(1), &mut warnings);
    for warning in warnings.iter() {
        eprintln!("warning: {warning}");
    }
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(mut arguments: impl Iterator<Item = String>, warnings: &mut Warnings) -> Result<()> {
    let usage = || Error::new("usage: rad_to_gltf OUTPUT SCENE.rad... [--window FILE]... [--sensors FILE]...");
    let output = arguments.next().ok_or_else(usage)?;
    let here = Path::new("");
    let (mut files, mut windows, mut sensors) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--window" => windows.extend(rad::read_windows(Path::new(&arguments.next().ok_or_else(usage)?), here, warnings)?),
            "--sensors" => {
                let file = PathBuf::from(arguments.next().ok_or_else(usage)?);
                let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                sensors.push(SensorGrid { name, sensors: points::read_points(&file)? });
            }
            _ => files.push(PathBuf::from(argument)),
        }
    }
    let scene = rad::read_scene(&files, here, warnings)?;
    gltf::write(Path::new(&output), &scene, &windows, &sensors)
}
