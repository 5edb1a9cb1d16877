//! The same project on a device held to WebGPU's default limits, and on a second Vulkan driver, SwiftShader.

mod device;
mod small_project;
#[path = "../src/testing.rs"]
mod testing;

use lucarne::matrix::file::read_matrix;
use lucarne::simulate::Results;
use small_project::{PROJECT, lucarne, project, results, text, timeless};
use std::path::Path;

/// Runs a project that is there, with these variables of the environment.
fn run(folder: &Path, text_of_project: &str, out: &str, environment: &[(&str, &Path)]) {
    std::fs::write(folder.join("project.toml"), text_of_project).unwrap();
    let mut command = lucarne(folder, &["run", "project.toml", "-o", out]);
    command.envs(environment.iter().copied());
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn a_device_held_to_the_limits_of_webgpu_gives_the_same_bits() {
    if device::device("limits of WebGPU").is_none() {
        return;
    }
    let [whole, capped] = [&[][..], &[("LUCARNE_LIMITS", Path::new("webgpu"))]].map(|environment| {
        let folder = project();
        run(folder.path(), PROJECT, "out", environment);
        timeless(results(folder.path()))
    });
    assert!(whole.len() > 20, "{}", whole.len());
    // Folders have names of their own; files follow in the same order.
    let same = whole.values().zip(capped.values()).filter(|(a, b)| a == b).count();
    assert_eq!((same, capped.len()), (whole.len(), whole.len()));
}

#[test]
fn unknown_limits_are_an_error_that_names_those_there_are() {
    let folder = project();
    let mut command = lucarne(folder.path(), &["run", "project.toml", "-o", "out"]);
    let output = command.env("LUCARNE_LIMITS", "nonsense").output().unwrap();
    if device::device("limits of devices").is_some() {
        let text = text(&output);
        assert!(!output.status.success() && text.contains("LUCARNE_LIMITS") && text.contains("webgpu"), "{text}");
    }
}

/// Illuminances with standard errors, then DGP with theirs.
fn values(out: &Path) -> [Vec<[f64; 2]>; 2] {
    let matrix = |name: &str| read_matrix(&out.join("illuminance").join(name)).unwrap().matrix.into_data();
    let pairs = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| [f64::from(*a), f64::from(*b)]).collect();
    let year = Results::open(out).unwrap().year;
    let glare = year.glare.iter().flat_map(|g| g.dgp.iter().zip(&g.standard_error).map(|(a, b)| [*a, *b]));
    [pairs(&matrix("room.mtx"), &matrix("room_standard_error.mtx")), glare.collect()]
}

#[test]
fn a_second_driver_gives_results_within_their_errors_in_three_and_five_phases() {
    if device::device("second driver").is_none() {
        return;
    }
    let Some(driver) = testing::swiftshader() else { return };
    for phases in [3, 5] {
        let folder = project();
        let text = if phases == 3 { PROJECT.replace("shade = \"slat.rad\"\n", "") } else { PROJECT.to_string() };
        run(folder.path(), &text, "first", &[]);
        run(folder.path(), &text, "second", &[("VK_DRIVER_FILES", &driver)]);
        let summary = std::fs::read_to_string(folder.path().join("second/summary.json")).unwrap();
        assert!(summary.contains("SwiftShader"), "the other driver was taken");
        for (first, second) in values(&folder.path().join("first")).iter().zip(&values(&folder.path().join("second"))) {
            assert_eq!(first.len(), second.len());
            assert!(first.iter().any(|[value, error]| *value > 0.0 && *error > 0.0), "nothing to compare");
            for ([a, ea], [b, eb]) in first.iter().zip(second) {
                // Hours without a picture have no DGP on either.
                if a.is_nan() && b.is_nan() {
                    continue;
                }
                assert!((a - b).abs() <= 4.0 * ea.hypot(*eb) + 1e-6 * a.abs(), "{phases} phases: {a} ± {ea}, {b} ± {eb}");
            }
        }
    }
}
