//! What the presets of `[quality]` mean in samples.

use crate::kernels::coefficients::CoefficientOptions;
use crate::kernels::coefficients::LEAST_SUN_PATHS;
use crate::kernels::daylight_matrix::DaylightOptions;
use crate::kernels::image_matrix::ImageOptions;
use crate::kernels::sun_matrix::SunOptions;
use crate::kernels::sun_matrix::pixels::PixelOptions;
use crate::kernels::view_matrix::MOST_LIGHT_PATHS;
use crate::kernels::view_matrix::ViewOptions;
use crate::simulate::inputs::Inputs;
use crate::simulate::project::quality::Stop;
use crate::simulate::project::{Preset, Project, QualitySection};

/// Share of the target's square that the noise of a picture's view matrix may take; the rest is D's.
pub(crate) const SHARE_OF_VIEW: f64 = 0.64;
/// Share of the target's square that the noise of V and D may take at sensors; the rest is the suns'.
pub(crate) const SHARE_OF_SENSORS: f64 = 0.64;

/// How often a matrix that is not sampled adaptively is traced anew, with other random numbers, and
/// averaged. Errors fall with the square root, memory stays what it was.
pub(crate) fn rounds(project: &Project) -> u32 {
    match project.quality.stop() {
        Stop::Rounds(rounds) => rounds,
        Stop::Adaptive { .. } => 1,
    }
}

/// Samples of one round: the kernels' defaults, a quarter of them for a draft.
fn samples(standard: u32, quality: &QualitySection) -> u32 {
    let samples = match quality.preset {
        Preset::Draft => standard / 4,
        Preset::Standard | Preset::Final => standard,
    };
    ((f64::from(samples) * quality.scale.min(1.0)) as u32).max(1)
}

/// Paths of each bin where a bin's paths are shared among so many parts of a window: the rays of all parts
/// together stay nearly as many as those of the whole.
fn shared(paths: u32, parts: usize, least: u32) -> u32 {
    (paths >> parts.max(1).ilog2()).max(least.min(paths))
}

/// Light paths of a bin of a part, and paths of D, at least.
const LEAST_LIGHT_PATHS: u32 = 8;
const LEAST_DAYLIGHT_PATHS: u32 = 32;

/// A near radius as a multiple of the size of a part, where the standard one is that of the size of a window.
fn near_radius(standard: f32, parts: usize) -> f32 {
    standard * (parts as f32).sqrt()
}

/// A seed for each use: every window and every round has random numbers of its own, so that their
/// errors are independent.
fn seed(project: &Project, window: usize, round: u32) -> u32 {
    // Weyl's sequence with the golden ratio: distinct for all small numbers.
    project.quality.seed.wrapping_add((window as u32).wrapping_mul(0x9e37_79b9)).wrapping_add(round.wrapping_mul(0x85eb_ca6b))
}

/// Sampling of V.
pub(crate) fn view_options(project: &Project, inputs: &Inputs, round: u32) -> ViewOptions {
    let standard = ViewOptions::default();
    let (quality, parts) = (&project.quality, inputs.mean_parts());
    ViewOptions {
        bounces: project.method.bounces,
        light_paths: shared(samples(standard.light_paths, quality), parts, LEAST_LIGHT_PATHS),
        visibility_rays: shared(standard.visibility_rays, parts, 1),
        near_radius: near_radius(standard.near_radius, parts),
        direct_samples: samples(standard.direct_samples, quality),
        near_samples: samples(standard.near_samples, quality),
        seed: seed(project, 0, round),
        first_round: round == 0,
        ..standard
    }
}

/// Sampling of the daylight coefficients C. Without windows there are no light paths that sensors share, and each gets
/// more of its own.
pub(crate) fn coefficient_options(project: &Project, round: u32) -> CoefficientOptions {
    let standard = CoefficientOptions::default();
    let quality = &project.quality;
    let own = if project.windows.is_empty() { 4 } else { 1 };
    CoefficientOptions {
        bounces: project.method.bounces,
        light_paths: samples(standard.light_paths, quality),
        direct_samples: samples(own * standard.direct_samples, quality),
        near_samples: samples(own * standard.near_samples, quality),
        seed: seed(project, 0, round),
        first_round: round == 0,
        sun_paths: sun_paths(project),
        // Surfaces cost little beside the rays from them, and what few of them get wrong goes through the year.
        sun_sets: 4 * sun_options(project).path_sets,
        ..standard
    }
}

/// Light paths of each sun, and batch, into rooms behind glass, and paths of each sensor to surfaces in the sun. As
/// [`sun_options`], whatever the rounds.
fn sun_paths(project: &Project) -> Option<u32> {
    let paths = match project.quality.preset {
        Preset::Draft => 32,
        Preset::Standard => 128,
        Preset::Final => 256,
    };
    let reflects = project.method.bounces.is_none_or(|b| b > 1);
    reflects.then(|| ((f64::from(paths) * sun_scale(project)) as u32).clamp(LEAST_SUN_PATHS, MOST_LIGHT_PATHS))
}

/// Sampling of D of the `window`-th window.
pub(crate) fn daylight_options(project: &Project, inputs: &Inputs, window: usize, round: u32) -> DaylightOptions {
    let standard = DaylightOptions::default();
    let parts = inputs.windows.get(window).map_or(1, |w| w.parts.len());
    DaylightOptions {
        bounces: project.method.bounces,
        paths: shared(samples(standard.paths, &project.quality), parts, LEAST_DAYLIGHT_PATHS),
        seed: seed(project, window, round),
        first_round: round == 0,
        ..standard
    }
}

/// Sampling of the view matrix of a picture.
pub(crate) fn image_options(project: &Project, inputs: &Inputs, phases: u32) -> ImageOptions {
    let standard = ImageOptions::default();
    let (light_paths, batches) = match project.quality.preset {
        Preset::Draft => (standard.light_paths / 2, standard.batches),
        Preset::Standard => (standard.light_paths, standard.batches),
        Preset::Final => (standard.light_paths * 4, standard.batches * 2),
    };
    // Above 1 as for the final quality.
    let scale = project.quality.scale;
    let light_paths = ((f64::from(light_paths) * scale.min(4.0)) as u32).max(1);
    let light_paths = shared(light_paths, inputs.mean_parts(), LEAST_LIGHT_PATHS);
    let batches = if scale > 1.0 { batches * 2 } else { batches };
    let few = |n: u32| ((f64::from(n) * scale.min(1.0)).ceil() as u32).max(1);
    let (window_samples, near_samples) = (few(standard.window_samples), few(standard.near_samples));
    ImageOptions {
        bounces: project.method.bounces,
        light_paths,
        batches,
        window_samples,
        near_samples,
        seed: seed(project, 0, 0),
        direct: phases == 5,
        near_radius: near_radius(standard.near_radius, inputs.mean_parts()),
        ..standard
    }
}

/// Sampling of suns through panes of scattering data.
pub(crate) fn pane_options(project: &Project) -> SunOptions {
    let standard = SunOptions::default();
    let cells = match project.quality.preset {
        Preset::Draft => standard.cells / 4,
        Preset::Standard => standard.cells,
        Preset::Final => standard.cells * 4,
    };
    SunOptions { cells, seed: seed(project, 0, 0), ..standard }
}

/// Sampling of suns in pictures: every pixel has a surface point per batch.
pub(crate) fn sun_picture_options(project: &Project) -> PixelOptions {
    let (batches, paths, cells) = match project.quality.preset {
        Preset::Draft => (2, 2, 16),
        Preset::Standard => (4, 4, 32),
        Preset::Final => (8, 8, 128),
    };
    let seed = seed(project, 0, 0);
    PixelOptions {
        slats: SunOptions { batches, disc_samples: 4, paths, path_sets: 1, seed, ..SunOptions::default() },
        // Neighbouring pixels even out what a pixel lacks.
        panes: SunOptions { batches, disc_samples: 4, cells, part_angle: 0.2, seed, ..SunOptions::default() },
    }
}

/// Sampling of the sun matrix of sensors. A single computation, whatever the preset: it costs little
/// beside V and D. A disc half hidden by slats makes most of an eye's light: 64 points leave 2…6 % of
/// it uncertain, 512 less than 1 %.
pub(crate) fn sun_options(project: &Project) -> SunOptions {
    let standard = SunOptions::default();
    let (disc_samples, paths) = match project.quality.preset {
        Preset::Draft => (standard.disc_samples, standard.paths / 2),
        Preset::Standard => (standard.disc_samples * 8, standard.paths * 8),
        Preset::Final => (standard.disc_samples * 32, standard.paths * 32),
    };
    let scaled = |n: u32| ((f64::from(n) * sun_scale(project)) as u32).max(1);
    SunOptions { disc_samples: scaled(disc_samples), paths: scaled(paths), seed: seed(project, 0, 0), ..standard }
}

/// Suns are sampled once, so as much as the target asks for: standard samples leave about 1.2 % of a
/// year in the shipped room with blinds, of which a target below 2 % gets three fifths.
fn sun_scale(project: &Project) -> f64 {
    const MOST: f64 = 16.0;
    let quality = &project.quality;
    quality.target_error.map_or(quality.scale, |target| (0.02 / target).powi(2).max(1.0)).min(MOST)
}
