//! What the phases of a run cost: rays as the kernels count them, products, and seconds on a slow device.
//!
//! The counts follow the kernels' loops; what depends on chance (how long paths live) comes from a few walks
//! through the scene. A test holds them to what a run counts.

use super::lives::Lives;
use super::presets::{
    coefficient_options, daylight_options, image_options, pane_options, rounds, sun_options, sun_picture_options, view_options,
};
use crate::error::Result;
use crate::kernels::coefficients::SURFACE_RAYS;
use crate::kernels::daylight_matrix::unobstructed;
use crate::kernels::sun_matrix::SunOptions;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::inputs::{Inputs, ProjectWindow};
use crate::simulate::project::Project;
use crate::simulate::project::glare::GlareMethod;
use crate::simulate::project::views::{ImageHours, ViewSection};
use serde::Serialize;

/// Bytes of an RGB value.
const RGB: usize = 12;
/// Segments of a path of D: it leaves after one or two surfaces outside.
const DAYLIGHT_SEGMENTS: f64 = 2.2;
/// Rays counted for each of the light paths of V.
const LIGHT_PATH_SEGMENTS: f64 = 1.5;
/// Rays outside for each light path of a sun: most take one, the others a path and the rays to the sun from it.
const SUN_START_SEGMENTS: f64 = 1.5;
/// Rays of C for each path of a sensor's own, those outside windows included.
const COEFFICIENT_SEGMENTS: f64 = 4.4;
/// Rays of V for each path that looks for near surfaces and mirrors.
const NEAR_SEGMENTS: f64 = 1.2;
/// Rays to a sun, as counted behind slats: for each point on its disc asked for, and for each path.
struct ToSun {
    per_point: f64,
    per_path: f64,
}
const SENSOR_TO_SUN: ToSun = ToSun { per_point: 0.13, per_path: 0.35 };
/// The same through panes alone, which scatter nothing: the second is once per batch.
const SENSOR_TO_BARE_SUN: ToSun = ToSun { per_point: 0.115, per_path: 1.3 };
const PIXEL_TO_SUN: ToSun = ToSun { per_point: 0.036, per_path: 0.29 };

impl ToSun {
    fn rays(&self, points: u32, paths: u32) -> f64 {
        self.per_point * f64::from(points) + self.per_path * f64::from(paths)
    }
}

/// Seconds of Mesa's llvmpipe on two cores of 2020: the slowest device that is likely to be met. Measured
/// with the shipped projects, kernels compiled before.
mod slow {
    /// A ray of each phase.
    pub(super) const VIEW_RAY: f64 = 0.3e-6;
    pub(super) const DAYLIGHT_RAY: f64 = 0.55e-6;
    pub(super) const COEFFICIENT_RAY: f64 = 0.55e-6;
    pub(super) const SUN_RAY: f64 = 0.6e-6;
    pub(super) const SUN_PIXEL_RAY: f64 = 1.6e-6;
    /// A sun that shines through a cell of a pane to a sensor or pixel: the scattering function between them.
    pub(super) const PANE_ENTRY: f64 = 0.12e-6;
    /// An entry of a picture's row in a batch: once, and per light path of its bin.
    pub(super) const PIXEL_ENTRY: [f64; 2] = [0.3e-6, 0.02e-6];
    /// An entry of S.
    pub(super) const SKY: f64 = 26e-9;
    /// A multiplication and addition of a product.
    pub(super) const PRODUCT: f64 = 0.06e-9;
    /// An hour with light, whatever its picture.
    pub(super) const GLARE_HOUR: f64 = 0.15e-3;
    /// Share of a picture's tiles that may reach the threshold in such an hour: the others are left out.
    pub(super) const GLARE_TILES: f64 = 0.25;
    /// A pixel of an hour with light: the sources that it belongs to.
    pub(super) const GLARE_PIXEL: f64 = 10e-9;
    /// An entry of D in an hour, whose noise is in that of its glare.
    pub(super) const GLARE_NOISE: f64 = 0.8e-9;
    /// A written picture's pixel.
    pub(super) const PICTURE_PIXEL: f64 = 0.2e-6;
    /// Kernels and tables of a phase.
    pub(super) const START: f64 = 0.3;
}

/// A phase with its size and cost.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhasePlan {
    /// `V`, `D`, `Cds`, `S` with the name of what it belongs to.
    pub name: String,
    /// Rows and what they are.
    pub rows: (usize, &'static str),
    /// Columns and what they are.
    pub columns: (usize, &'static str),
    /// Of the matrix, bytes.
    pub bytes: usize,
    /// Rays, roughly.
    pub rays: f64,
    /// Seconds on a slow device (software Vulkan on two cores), roughly.
    pub slow_seconds: f64,
}

impl PhasePlan {
    fn new(name: String, rows: (usize, &'static str), columns: (usize, &'static str)) -> Self {
        Self { name, rows, columns, bytes: rows.0 * columns.0 * RGB, rays: 0.0, slow_seconds: 0.0 }
    }

    fn traced(self, rays: f64, seconds_each: f64) -> Self {
        let start = if rays > 0.0 { slow::START } else { 0.0 };
        Self { rays, slow_seconds: start + rays * seconds_each, ..self }
    }

    fn worked(self, seconds: f64) -> Self {
        Self { slow_seconds: self.slow_seconds + seconds, ..self }
    }
}

/// Rays of D of a window, if it is traced.
pub(super) fn daylight_rays(project: &Project, inputs: &Inputs, window: usize) -> f64 {
    let o = daylight_options(project, inputs, window, 0);
    let bins = inputs.windows[window].bins();
    f64::from(rounds(project)) * f64::from(o.batches) * f64::from(o.paths) * bins as f64 * DAYLIGHT_SEGMENTS
}

/// Rays of V of so many sensors.
fn view_rays(project: &Project, inputs: &Inputs, sensors: usize) -> f64 {
    let (o, bins, sensors) = (view_options(project, inputs, 0), inputs.bins() as f64, sensors as f64);
    let lives = Lives::new(inputs, o.bounces, o.roulette_weight);
    let paths = bins * f64::from(o.light_paths) * f64::from(o.batches);
    let connections = sensors * bins * f64::from(o.batches) * f64::from(o.visibility_rays) * lives.most_vertices(paths);
    let own = sensors * f64::from(o.batches) * (f64::from(o.direct_samples) + NEAR_SEGMENTS * f64::from(o.near_samples));
    f64::from(rounds(project)) * (own + connections + paths * LIGHT_PATH_SEGMENTS)
}

/// Rays of C of so many sensors: as V's, and outside each window the paths on to the sky.
fn coefficient_rays(project: &Project, inputs: &Inputs, sensors: usize) -> f64 {
    let (o, bins, sensors) = (coefficient_options(project, 0), inputs.bins() as f64, sensors as f64);
    let lives = Lives::new(inputs, o.bounces, o.roulette_weight);
    let paths = bins * f64::from(o.light_paths) * f64::from(o.batches);
    let connections = sensors * bins * f64::from(o.batches) * f64::from(o.visibility_rays) * lives.most_vertices(paths);
    let own = if inputs.windows.is_empty() {
        // Until roulette ends them.
        f64::from(o.near_samples) * (1.0 + (lives.certain() + 1.0 / (1.0 - lives.kept)).min(lives.most()))
    } else {
        f64::from(o.direct_samples) * (1.0 + DAYLIGHT_SEGMENTS) + COEFFICIENT_SEGMENTS * f64::from(o.near_samples)
    };
    let all = own * sensors * f64::from(o.batches) + connections + paths * (LIGHT_PATH_SEGMENTS + DAYLIGHT_SEGMENTS);
    f64::from(rounds(project)) * all
}

/// Rays of the view matrix of a picture that shows so many pixels.
fn picture_rays(project: &Project, inputs: &Inputs, pixels: usize, windows_only: bool) -> f64 {
    let o = image_options(project, inputs, inputs.choice(project).phases);
    if windows_only {
        return pixels as f64 * f64::from(o.subpixels);
    }
    let samples =
        f64::from(o.window_samples.div_ceil(o.traced_every)) + f64::from(o.visibility_rays) + NEAR_SEGMENTS * f64::from(o.near_samples);
    pixels as f64 * (f64::from(o.subpixels) + f64::from(o.batches) * samples)
}

/// Rays of suns in the picture of so many pixels.
fn sun_picture_rays(project: &Project, inputs: &Inputs, pixels: usize, suns: usize) -> f64 {
    let o = sun_picture_options(project);
    let pairs = |batches: u32| (pixels * suns) as f64 * f64::from(batches);
    let mut rays = 0.0;
    if inputs.any_window(|w| w.shade.is_some()) {
        let s = o.slats;
        rays += pairs(s.batches) * PIXEL_TO_SUN.rays(s.disc_samples, s.paths);
    }
    if inputs.any_window(|w| w.pane.is_some()) {
        // Rays to the cells serve all suns.
        let p = o.panes;
        rays += pixels as f64 * f64::from(p.batches) * f64::from(p.cells) + pairs(p.batches) * PIXEL_TO_SUN.rays(p.disc_samples, 0);
    }
    rays
}

/// All phases in the order of their computation. `lit`: time steps that are not night.
pub(super) fn costs(project: &Project, inputs: &Inputs, suns: Option<&SunSet>, lit: usize) -> Result<Vec<PhasePlan>> {
    let (bins, patches, steps) = (inputs.bins(), inputs.sky(project).len(), inputs.weather.records.len());
    // Five phases also need the sky without sun, and the sun alone.
    let skies = if suns.is_some() { 3.0 } else { 1.0 };
    let sky = PhasePlan::new("S".into(), (patches, "patches"), (steps, "steps")).worked(skies * (patches * steps) as f64 * slow::SKY);
    let mut all = vec![sky];
    let count: usize = inputs.sensors.iter().map(|g| g.sensors.len()).sum();
    let direct = inputs.choice(project).direct;
    if count > 0 && direct {
        let phase = PhasePlan::new("DC of sensors".into(), (count, "sensors"), (patches, "patches"));
        all.push(phase.traced(coefficient_rays(project, inputs, count), slow::COEFFICIENT_RAY));
    } else if count > 0 {
        let phase = PhasePlan::new("V of sensors".into(), (count, "sensors"), (bins, "bins"));
        all.push(phase.traced(view_rays(project, inputs, count), slow::VIEW_RAY));
    }
    let factored = if direct && project.views.is_empty() { &[][..] } else { &inputs.windows[..] };
    for (i, window) in factored.iter().enumerate() {
        let own = window.bins();
        let known = project.quality.prune && unobstructed::nothing_before(&inputs.scene, &window.window);
        let rays = if known || window.daylight.is_some() { 0.0 } else { daylight_rays(project, inputs, i) };
        let phase = PhasePlan::new(format!("D of {}", window.name), (own, "bins"), (patches, "patches"));
        all.push(phase.traced(rays, slow::DAYLIGHT_RAY));
    }
    if let Some(suns) = suns
        && count > 0
    {
        let needed = suns.census.needed;
        let phase = PhasePlan::new("Cds of sensors".into(), (count, "sensors"), (needed, "suns"));
        let scattered = pane_entries(inputs, &pane_options(project), count, needed) * slow::PANE_ENTRY;
        all.push(phase.traced(sun_rays(project, inputs, count, needed), slow::SUN_RAY).worked(scattered));
    }
    if count > 0 {
        // All replicates of the errors are multiplied as the result is; five phases have three skies.
        let terms = (1 + view_options(project, inputs, 0).batches) as f64 * if suns.is_some() { 2.0 } else { 1.0 };
        let work = 3.0 * count as f64 * (patches * lit) as f64 * terms;
        let phase = PhasePlan::new("illuminance".into(), (count, "sensors"), (steps, "steps"));
        all.push(phase.worked(work * slow::PRODUCT));
    }
    all.extend(state_costs(project, inputs, suns, count, lit));
    let before = all.len();
    for view in &project.views {
        all.extend(view_costs(project, inputs, view, suns, lit)?);
    }
    // What control asks of glare is as much for each state as the year of the façade as it moves.
    let asked = inputs.glare_of_states(project)?;
    let of = |view: &usize| format!("glare of {}", project.views[*view].name);
    let each: f64 =
        asked.views.iter().filter_map(|v| all.iter().find(|p| p.name == of(v))).map(|p| p.slow_seconds / p.rows.0.max(1) as f64).sum();
    if !asked.views.is_empty() {
        let phase = PhasePlan::new("glare of states".into(), (asked.states.len(), "states"), (lit, "steps"));
        all.insert(before, phase.worked(asked.states.len() as f64 * each));
    }
    Ok(all)
}

/// What the states of the façade add for sensors: the light of each, and its suns.
fn state_costs(project: &Project, inputs: &Inputs, suns: Option<&SunSet>, sensors: usize, lit: usize) -> Vec<PhasePlan> {
    let groups = inputs.facade.groups();
    let states: usize = groups.iter().map(|g| g.states.len()).sum();
    if sensors == 0 || groups.iter().all(|g| g.states.len() < 2) {
        return Vec::new();
    }
    let mut all = Vec::new();
    if let Some(suns) = suns {
        let needed = suns.census.needed;
        // Each thing that suns pass has all suns, but the one that is traced above.
        let ways = inputs.ways_of_suns();
        let more = if inputs.moves() { ways.saturating_sub(1) } else { ways } as f64;
        let phase = PhasePlan::new("Cds of states".into(), (sensors, "sensors"), (ways * needed, "suns"));
        let scattered = pane_entries(inputs, &pane_options(project), sensors, needed) * slow::PANE_ENTRY;
        all.push(phase.traced(more * sun_rays(project, inputs, sensors, needed), slow::SUN_RAY).worked(more * scattered));
    }
    let bins = inputs.bins() as f64 * if suns.is_some() { 2.0 } else { 1.0 };
    let work = 3.0 * bins / groups.len() as f64 * (states * sensors * lit) as f64;
    let phase = PhasePlan::new("light of states".into(), (states * sensors, "sensors"), (inputs.weather.records.len(), "steps"));
    all.push(phase.worked(work * slow::PRODUCT));
    all
}

/// Rays of Cds of sensors.
fn sun_rays(project: &Project, inputs: &Inputs, sensors: usize, suns: usize) -> f64 {
    let o = sun_options(project);
    let pairs = (sensors * suns) as f64;
    let mut rays = 0.0;
    if inputs.any_window(|w| w.shade.is_some()) || inputs.choice(project).direct {
        // Panes alone scatter nothing.
        let scatters = inputs.any_window(|w| w.shade.is_some() && w.glass.is_none());
        let each = if scatters { SENSOR_TO_SUN.rays(o.disc_samples, o.paths) } else { SENSOR_TO_BARE_SUN.rays(o.disc_samples, 1) };
        rays += pairs * f64::from(o.batches) * each;
    }
    let lights = coefficient_options(project, 0);
    if let Some(own) = lights.sun_paths.filter(|_| inputs.choice(project).direct) {
        // Light paths of the suns, each with a ray or a path outside; rays to the lights of four vertices together.
        let lives = Lives::new(inputs, lights.bounces, lights.roulette_weight);
        let paths = suns as f64 * f64::from(lights.batches) * f64::from(own);
        let gathered = (lives.most_vertices(paths) / 4.0).ceil();
        rays += paths * (LIGHT_PATH_SEGMENTS + SUN_START_SEGMENTS);
        rays += pairs * f64::from(lights.batches) * f64::from(lights.visibility_rays) * gathered;
        // Surfaces of each sensor's own, and rays from them.
        rays += (sensors as f64 * f64::from(lights.sun_sets) * COEFFICIENT_SEGMENTS * f64::from(own) + pairs * f64::from(SURFACE_RAYS))
            * f64::from(lights.batches);
    }
    if inputs.any_window(|w| w.pane.is_some()) {
        let p = pane_options(project);
        rays += sensors as f64 * f64::from(p.batches) * f64::from(p.cells)
            + pairs * f64::from(p.batches) * SENSOR_TO_SUN.rays(p.disc_samples, 0);
    }
    rays
}

/// Values of scattering functions between suns, cells of panes, and so many sensors or pixels.
fn pane_entries(inputs: &Inputs, options: &SunOptions, receivers: usize, suns: usize) -> f64 {
    let has_pane = inputs.any_window(|w| w.pane.is_some());
    let cells = f64::from(options.batches) * f64::from(options.cells);
    if has_pane { (receivers * suns) as f64 * cells } else { 0.0 }
}

/// Phases of one view: its matrix, its suns, its pictures, its glare.
fn view_costs(project: &Project, inputs: &Inputs, view: &ViewSection, suns: Option<&SunSet>, lit: usize) -> Result<Vec<PhasePlan>> {
    let mut all = Vec::new();
    let (raster, bins) = (view.raster()?, inputs.bins());
    let (pixels, name) = (raster.len(), &view.name);
    let seen = (0..pixels).filter(|p| raster.is_seen(p % raster.width(), p / raster.width())).count();
    let steps = inputs.weather.steps();
    let pictured = match &project.images.hours {
        ImageHours::None => Vec::new(),
        ImageHours::Daylight => (0..lit).collect(),
        ImageHours::Chosen(hours) => steps.of_hours(hours).unwrap_or_default(),
    };
    let method = project.glare.as_ref().map(|g| g.method);
    if method.is_none_or(|m| m == GlareMethod::Image) || !pictured.is_empty() {
        let rays = if view.given.view.is_some() { 0.0 } else { picture_rays(project, inputs, seen, false) };
        let phase = PhasePlan::new(format!("V of {name}"), (pixels, "pixels"), (bins, "bins"));
        let o = image_options(project, inputs, inputs.choice(project).phases);
        let [once, per_path] = slow::PIXEL_ENTRY;
        let entry = if rays > 0.0 { f64::from(o.batches) * (once + per_path * f64::from(o.light_paths)) } else { 0.0 };
        all.push(phase.traced(rays, 0.0).worked((seen * bins) as f64 * entry));
    }
    if method == Some(GlareMethod::Edgps) {
        let phase = PhasePlan::new(format!("V of {name}, windows"), (pixels, "pixels"), (bins, "bins"));
        all.push(phase.traced(picture_rays(project, inputs, seen, true), slow::DAYLIGHT_RAY));
    }
    if method.is_some_and(|m| m != GlareMethod::Image) {
        let phase = PhasePlan::new(format!("V of {name}, eye"), (1, "eye"), (bins, "bins"));
        all.push(phase.traced(view_rays(project, inputs, 1), slow::VIEW_RAY));
    }
    let has_pictures = method.is_some_and(GlareMethod::has_pictures);
    if let Some(suns) = suns.filter(|_| inputs.any_window(ProjectWindow::is_sunny))
        && (has_pictures || !pictured.is_empty() || project.images.components)
    {
        // Glare needs all of them.
        let needed = if has_pictures || project.images.components {
            suns.census.needed
        } else {
            let mut some: Vec<usize> = pictured.iter().filter_map(|&step| Some((*suns.hours.get(step)?)?.0)).collect();
            some.sort_unstable();
            some.dedup();
            some.len()
        };
        let traced = view.given.sun.is_none();
        let rays = if traced { sun_picture_rays(project, inputs, seen, needed) } else { 0.0 };
        let entries = if traced { pane_entries(inputs, &sun_picture_options(project).panes, seen, needed) } else { 0.0 };
        let phase = PhasePlan::new(format!("suns of {name}"), (pixels, "pixels"), (needed, "suns"));
        all.push(phase.traced(rays, slow::SUN_PIXEL_RAY).worked(entries * slow::PANE_ENTRY));
    }
    let columns = if suns.is_some() { 2 * bins } else { bins };
    let products = 3.0 * (seen * columns) as f64 * slow::PRODUCT;
    if !pictured.is_empty() {
        let phase = PhasePlan::new(format!("pictures of {name}"), (pixels, "pixels"), (pictured.len(), "steps"));
        all.push(phase.worked(pictured.len() as f64 * (products + pixels as f64 * slow::PICTURE_PIXEL)));
    }
    if has_pictures {
        let alone = inputs.states_alone(project).len();
        let states = alone + usize::from(project.control.is_given || alone == 0);
        let noise = (bins * inputs.sky(project).len()) as f64 * slow::GLARE_NOISE;
        let each = slow::GLARE_HOUR + slow::GLARE_TILES * (products + seen as f64 * slow::GLARE_PIXEL) + noise;
        let phase = PhasePlan::new(format!("glare of {name}"), (states, "states"), (lit, "steps"));
        all.push(phase.worked((states * lit) as f64 * each));
    }
    Ok(all)
}
