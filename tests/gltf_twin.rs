//! The office as glTF gives the matrices of its `.rad` twin, within Monte-Carlo error.

use lucarne::Warnings;
use lucarne::gpu::Device;
use lucarne::kernels::trace::TracedMatrix;
use lucarne::kernels::view_matrix::{self, ViewOptions};
use lucarne::progress::Silent;
use lucarne::scene::{read_scene, read_sensors, read_windows};
use std::path::{Path, PathBuf};

#[path = "../src/testing.rs"]
mod testing;

fn view_matrix(device: &Device, scene: &[&str], windows: &[&str], sensors: &str, seed: u32) -> TracedMatrix {
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office");
    let mut warnings = Warnings::new();
    let files: Vec<PathBuf> = scene.iter().map(PathBuf::from).collect();
    let scene = read_scene(&files, &office, &mut warnings).unwrap();
    let windows: Vec<_> = windows.iter().flat_map(|w| read_windows(Path::new(w), &office, &mut warnings).unwrap()).collect();
    let sensors: Vec<_> = read_sensors(&office.join(sensors), None, &mut warnings).unwrap().into_iter().step_by(9).collect();
    assert!(warnings.is_empty());
    let options = ViewOptions { bounces: Some(4), light_paths: 64, seed, ..ViewOptions::default() };
    view_matrix::compute(device, &scene, &windows, &sensors, &options, &Silent).unwrap()
}

#[test]
fn the_office_as_gltf_has_the_view_matrix_of_its_rad_twin() {
    let Some(device) = testing::device(Device::open(None), "the office as glTF") else { return };
    let windows = ["windows/vision.rad", "windows/clerestory.rad"];
    let radiance = view_matrix(&device, &["materials.rad", "office.rad"], &windows, "workplane.txt", 1);
    let gltf = view_matrix(&device, &["office.gltf"], &["office.gltf#vision", "office.gltf#clerestory"], "office.gltf#workplane", 2);
    assert_eq!((radiance.total.rows(), radiance.total.cols()), (gltf.total.rows(), gltf.total.cols()));
    // Entries of two independent runs differ by their standard errors; these come from few
    // batches, so that squares in units of them have a mean a little above 1 (ν/(ν−2), 1.17 for
    // two times eight batches).
    let values = radiance.total.data().iter().zip(gltf.total.data());
    let errors = radiance.standard_error.data().iter().zip(gltf.standard_error.data());
    let squares: Vec<f64> = values
        .zip(errors)
        .filter(|(_, (s, t))| **s > 0.0 && **t > 0.0)
        .map(|((a, b), (s, t))| f64::from(a - b).powi(2) / (f64::from(*s).powi(2) + f64::from(*t).powi(2)))
        .collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!(squares.len() > 1000, "{} entries", squares.len());
    assert!((0.7..1.7).contains(&mean), "mean square {mean} of {} entries", squares.len());
    // The whole matrix, too: the sums over all entries.
    let [a, b] = [&radiance, &gltf].map(|m| m.total.data().iter().map(|v| f64::from(*v)).sum::<f64>());
    eprintln!("mean square {mean:.3} of {} entries, sums {a:.5} {b:.5}", squares.len());
    assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
}
