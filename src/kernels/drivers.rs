//! The kernels' tests again, each in a process of its own: on a second Vulkan driver, and watched by Khronos' validation
//! layer.
//!
//! A selection, for the second driver takes six times as long: what tests the device layer and the shaders' shared
//! functions, and of each kernel the comparison with its definition in 64 bits. All of them:
//! `VK_DRIVER_FILES=/usr/lib/chromium/vk_swiftshader_icd.json cargo test --release --lib kernels::`

use crate::gpu::Device;
use crate::testing;
use std::path::Path;
use std::process::{Command, Output};

const SELECTED: &[&str] = &[
    "gpu::",
    "kernels::drivers::the_device_is_the_one_expected",
    "kernels::bsdf_generation::tests::a_hole_is_the_identity_in_every_basis",
    "kernels::bsdf_generation::tests::a_lambertian_plate_reflects_evenly",
    "kernels::bsdf_scattering::tests::samples_follow_the_function_and_conserve_energy",
    "kernels::bsdf_scattering::tests::values_agree_with_f64_on_ten_thousand_pairs_per_file",
    "kernels::coefficients::tests::a_pane_in_a_black_room_gives_the_integral_of_its_transmittance",
    "kernels::daylight_matrix::tests::a_street_without_symmetry_agrees_with_the_reference_bin_by_bin",
    "kernels::glare::tests::random_images_have_the_same_sources_fused_and_whole",
    "kernels::image_matrix::tests::a_window_seen_directly_is_exact",
    "kernels::image_matrix::tests::pixels_agree_with_the_reference_at_their_surface_points",
    "kernels::product::tests::every_entry_lies_within_the_rounding_bound",
    "kernels::sun_matrix::pane::tests::a_small_even_pane_and_a_clear_one_have_their_analytic_values",
    "kernels::sun_matrix::tests::direct_light_agrees_with_the_reference",
    "kernels::trace::probes::bins",
    "kernels::trace::probes::circle",
    "kernels::trace::probes::material",
    "kernels::trace::probes::random::the_shader_draws_the_same_bits",
    "kernels::trace::probes::rays",
    "kernels::trace::probes::windows",
    "kernels::view_matrix::tests::a_black_room_gives_the_analytic_configuration_factor",
    "kernels::view_matrix::tests::an_asymmetric_room_agrees_with_the_reference_bin_by_bin",
];

/// Says what the device of such a process is called.
const EXPECTED: &str = "LUCARNE_EXPECTED_DEVICE";

/// Runs tests of this program with other variables of the environment. What they measure and skip goes into `folder`.
fn tests_again(tests: &[&str], folder: &Path, environment: &[(&str, &str)]) -> Output {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(tests).args(["--skip", "kernels::drivers::again"]).env("CARGO_TARGET_DIR", folder);
    command.envs(environment.iter().copied()).output().unwrap()
}

/// Checks that as many tests passed as are selected, at least, and none failed.
fn all_passed(output: &Output) -> usize {
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    let line = text.lines().find_map(|line| line.strip_prefix("test result: ok. ")).expect("a line of results");
    let tests = line.split_whitespace().next().and_then(|n| n.parse().ok()).expect("a number of tests");
    assert!(tests >= SELECTED.len(), "{tests}");
    tests
}

#[test]
fn the_device_is_the_one_expected() {
    if let (Ok(name), Some(device)) = (std::env::var(EXPECTED), Device::for_tests("name of the device")) {
        assert!(device.summary().name.contains(&name), "{}", device.summary().name);
    }
}

mod again {
    use super::*;

    #[test]
    fn the_kernels_pass_their_tests_on_a_second_driver() {
        if Device::for_tests("second driver").is_none() {
            return;
        }
        let Some(driver) = testing::swiftshader() else { return };
        let folder = tempfile::tempdir().unwrap();
        let run = tests_again(SELECTED, folder.path(), &[("VK_DRIVER_FILES", driver.to_str().unwrap()), (EXPECTED, "SwiftShader")]);
        let tests = all_passed(&run);
        println!("{tests} tests pass on SwiftShader");
        testing::measured("second-driver", &format!("{tests} of {tests} tests pass"), "all");
    }

    /// What the layer says, by its names of rules.
    fn messages(run: &Output) -> Vec<String> {
        let text = [&run.stdout[..], &run.stderr[..]].map(String::from_utf8_lossy).concat();
        text.lines().filter(|line| line.contains("VUID-") || line.contains("UNASSIGNED-")).map(str::to_string).collect()
    }

    #[test]
    fn the_validation_layer_finds_nothing_wrong_with_what_the_kernels_ask_of_vulkan() {
        if Device::for_tests("validation layer").is_none() || !testing::validation_layer() {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let settings = folder.path().join("vk_layer_settings.txt");
        let watched = |tests: &[&str], more: &str| {
            let text = "khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\nkhronos_validation.log_filename = stdout\n\
                        khronos_validation.report_flags = error,warn\n";
            std::fs::write(&settings, format!("{text}{more}")).unwrap();
            let layer = ("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation");
            tests_again(tests, folder.path(), &[layer, ("VK_LAYER_SETTINGS_PATH", folder.path().to_str().unwrap())])
        };
        // The layer is there and is heard: asked for advice, it has some.
        let advice = watched(&["gpu::canary"], "khronos_validation.enables = VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT\n");
        assert!(!messages(&advice).is_empty(), "{}", String::from_utf8_lossy(&advice.stdout));
        let run = watched(SELECTED, "");
        let (tests, found) = (all_passed(&run), messages(&run));
        assert!(found.is_empty(), "{} messages, the first: {}", found.len(), found[0]);
        println!("{tests} tests, no message");
        testing::measured("validation-layer", &format!("no message in {tests} tests"), "0");
    }
}
