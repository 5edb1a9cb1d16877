//! The five-phase method: suns through real slats against Radiance's results (reference data beside
//! the repository; its absence is said), and whole projects through the library.

#[path = "../device/mod.rs"]
mod device;

use device::device;
use lucarne::bins::ReinhartSky;
use lucarne::gpu::Device;
use lucarne::kernels::sun_matrix::Sun;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::scene::points::{Sensor, read_points};
use lucarne::simulate::{Inputs, Project, Summary, run};
use lucarne::simulate::{inputs::suns::SunSet, project::method::SunScheme};
use lucarne::weather::Weather;
use lucarne::{Result, Warnings};
use std::path::{Path, PathBuf};

#[path = "../../src/testing.rs"]
mod testing;
use testing::{measured, percent, percents, short};

mod faults;
mod imports;
mod panes;
mod pictures;
mod projects;
mod slats;

fn at(m: &Matrix<f32>, row: usize, column: usize) -> f64 {
    f64::from(m.at(row, column)[0])
}

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");

/// A project in the shipped room with blinds, over the given hours of weather, at draft quality.
fn blinds(folder: &Path, weather: &str, shade: &str, method: &str) -> Result<(Summary, PathBuf)> {
    blinds_with(folder, weather, &format!("{SCENES}/blinds/blind.xml"), shade, method)
}

/// The same with another BSDF.
fn blinds_with(folder: &Path, weather: &str, bsdf: &str, shade: &str, method: &str) -> Result<(Summary, PathBuf)> {
    let header = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
    std::fs::write(folder.join("w.wea"), format!("{header}{weather}")).unwrap();
    let scene = format!("{SCENES}/blinds");
    let text = format!(
        "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"{scene}/room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"{scene}/window.rad\"\n\
         bsdf = \"{bsdf}\"\n{shade}\n[[sensors]]\nname = \"room\"\npoints = \"{scene}/points.txt\"\n[method]\nsky_subdivision = 1\n{method}\n[quality]\npreset = \"draft\"\n"
    );
    // Pictures are compared with sensors, both with little noise.
    let text = if method.contains("[images]") { text.replace("\"draft\"", "\"standard\"") } else { text };
    let file = folder.join("project.toml");
    std::fs::write(&file, text).unwrap();
    let project = Project::read(&file)?;
    let mut warnings = Warnings::new();
    let inputs = Inputs::read(&project, &mut warnings)?;
    let out = folder.join("out");
    let device = Device::shared()?;
    let summary = run(&device, &project, &inputs, &out, &Silent, &mut warnings)?;
    Ok((summary, out))
}

fn day(direct: f64) -> String {
    (0..24).map(|h| format!("1 15 {h}.5 {direct} {}\n", if (8..17).contains(&h) { 120 } else { 0 })).collect()
}

fn shade() -> String {
    format!("shade = \"{SCENES}/blinds/blinds.rad\"")
}

fn values(out: &Path, name: &str) -> Vec<f32> {
    read_matrix(&out.join("illuminance").join(name)).unwrap().matrix.into_data()
}
