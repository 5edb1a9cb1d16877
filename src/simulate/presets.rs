//! What the presets of `[quality]` mean in samples.

use super::project::{Preset, Project};
use crate::kernels::daylight_matrix::DaylightOptions;
use crate::kernels::view_matrix::ViewOptions;

/// Samples relative to `standard`: errors fall with the square root.
fn effort(preset: Preset) -> f64 {
    match preset {
        Preset::Draft => 1.0 / 4.0,
        Preset::Standard => 1.0,
        Preset::Final => 16.0,
    }
}

fn samples(standard: u32, preset: Preset) -> u32 {
    ((f64::from(standard) * effort(preset)).round() as u32).max(8)
}

/// Sampling of V.
pub fn view_options(project: &Project) -> ViewOptions {
    let standard = ViewOptions::default();
    let preset = project.quality.preset;
    ViewOptions {
        bounces: project.method.bounces,
        light_paths: samples(standard.light_paths, preset),
        direct_samples: samples(standard.direct_samples, preset),
        near_samples: samples(standard.near_samples, preset),
        seed: project.quality.seed,
        ..standard
    }
}

/// Sampling of D of the `index`-th window. Each window has random numbers of its own, so that the
/// errors of several windows are independent.
pub fn daylight_options(project: &Project, index: usize) -> DaylightOptions {
    let standard = DaylightOptions::default();
    DaylightOptions {
        bounces: project.method.bounces,
        paths: samples(standard.paths, project.quality.preset),
        seed: project.quality.seed.wrapping_add((index as u32).wrapping_mul(0x9e37_79b9)),
        ..standard
    }
}
