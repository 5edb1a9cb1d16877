//! BSDF of a sample from its geometry, as genBSDF: all four components at once.
//!
//! ```text
//! Sample ── tables ──▶ device: paths (analog, one record each)            ──┐
//!                      device: direct paths + chains with fans of rays    ──┴▶ batch ──▶ Table ──▶ Bsdf
//! ```
//!
//! Light starts uniformly on the face of the sample's box, uniformly in the projected solid angle
//! of an incident cell. Entry `f[outgoing][incident]` is the share of it that leaves in the outgoing
//! cell over that cell's projected solid angle: the mean BTDF or BRDF over both cells, 1/sr.
//! As in genBSDF, light that leaves over the sides of a box counts with the hemisphere of its
//! direction, wherever it leaves; a repeating sample has no sides.

mod chains;
mod directions;
pub mod mgf;
mod output;
mod paths;
mod sample;
mod table;
#[cfg(test)]
mod tests;

pub use directions::Directions;
pub use sample::Sample;
pub use table::Table;

use crate::error::{Error, Result, Warnings};
use crate::gpu::Device;
use crate::gpu_struct;
use crate::kernels::trace::{MATERIAL_SURFACE, ROULETTE_WEIGHT, TraceScene, TraceTables};
use crate::progress::{Progress, cancelled};
use crate::units::BRIGHTNESS_WEIGHTS;
use glam::Vec3;

gpu_struct! {
    /// Parameters of the kernels in `shaders/bsdf`.
    pub(crate) struct GenerationParams {
        /// The box in the tracer's units; light starts on its faces of low and high z.
        low: [f32; 3],
        seed: u32,
        high: [f32; 3],
        /// First sample of this dispatch, and samples in it.
        first_sample: u32,
        /// Weights of red, green and blue in the luminance.
        luminance: [f32; 3],
        samples: u32,
        /// First incident cell of this dispatch, counted over both sides.
        first_cell: u32,
        /// Incident cells of this dispatch.
        cells: u32,
        /// Cells of one side, incident and outgoing.
        in_cells: u32,
        out_cells: u32,
        /// Most diffuse reflections of a path.
        most_bounces: u32,
        /// Weight below which Russian roulette decides.
        roulette_weight: f32,
        /// Fixed-point units of 1.
        unit: f32,
        /// Chains that the buffers hold.
        capacity: u32,
        /// Sides of triangles that scatter diffusely.
        diffuse_count: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

/// How light is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// [`Chains`](Self::Chains) where they are exact and useful, else [`Paths`](Self::Paths).
    #[default]
    Best,
    /// One path per sample from the face of the box until it leaves. Works for everything.
    Paths,
    /// Paths without diffuse reflections; these by chains with fans of rays, each of which serves all
    /// entries. Exact for materials without rough specular parts, whose reflection this program
    /// models without exact reciprocity.
    Chains,
}

/// How much to sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GenerationOptions {
    /// Samples per incident cell (Radiance's `-c`).
    pub samples: u32,
    /// Independent repetitions into which they are divided; their spread gives the standard error.
    /// At least 2.
    pub batches: u32,
    /// Radiance's `-ab`: most diffuse reflections of a path; `None` does not truncate.
    pub bounces: Option<u32>,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Path weight below which Russian roulette decides (Radiance's `-lw`).
    pub roulette_weight: f32,
    /// Whether to average each entry with that of the light's way back (Helmholtz reciprocity).
    pub average_reciprocal: bool,
    /// How light is followed.
    pub method: Method,
}

impl Default for GenerationOptions {
    fn default() -> Self {
        Self {
            samples: 8192,
            batches: 8,
            bounces: None,
            seed: 1,
            roulette_weight: ROULETTE_WEIGHT,
            average_reciprocal: false,
            method: Method::Best,
        }
    }
}

/// What one generation did.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GenerationStatistics {
    /// Paths and rays started (and finished).
    pub paths: u64,
    /// Segments traced.
    pub segments: u64,
    /// Paths that ended on the back of a mirror, which absorbs.
    pub mirror_backs: u64,
}

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<crate::gpu::Shader> {
    let mut all = vec![paths::PATHS];
    all.extend(chains::registered());
    all
}

/// What the kernels of one generation share.
struct Job<'a> {
    device: &'a Device,
    options: &'a GenerationOptions,
    directions: Directions,
    tables: TraceTables,
    scene: TraceScene,
    low: Vec3,
    high: Vec3,
    repeats: [bool; 2],
}

impl Job<'_> {
    /// Parameters that do not depend on the dispatch.
    fn params(&self) -> GenerationParams {
        GenerationParams {
            low: self.low.to_array(),
            seed: 0,
            high: self.high.to_array(),
            first_sample: 0,
            luminance: BRIGHTNESS_WEIGHTS.map(|w| w as f32),
            samples: 0,
            first_cell: 0,
            cells: 0,
            in_cells: self.directions.incident() as u32,
            out_cells: self.directions.outgoing() as u32,
            most_bounces: self.options.bounces.unwrap_or(u32::MAX),
            roulette_weight: self.options.roulette_weight,
            unit: 1.0,
            capacity: 0,
            diffuse_count: 0,
            padding0: 0,
            padding1: 0,
            padding2: 0,
        }
    }

    /// Whether chains give the exact BSDF, and faster than paths.
    fn suits_chains(&self, sample: &Sample) -> bool {
        let used = |m: u32| &self.tables.materials[m as usize];
        let rough = self
            .tables
            .triangle_materials
            .iter()
            .map(|&m| used(m))
            .any(|m| m.kind == MATERIAL_SURFACE && !m.is_smooth() && (m.specular != [0.0; 3] || m.specular_transmitted != [0.0; 3]));
        // Slices have one azimuth, from which reflections stray.
        let stray = matches!(self.directions, Directions::Tree3(_)) && self.tables.features.specular;
        !rough && !stray && sample.fills_its_box()
    }

    /// Values of the `override` constants that all kernels have.
    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("DIRECTIONS", f64::from(self.directions.code())),
            ("SIDE", self.directions.side() as f64),
            ("REPEAT_X", f64::from(u8::from(self.repeats[0]))),
            ("REPEAT_Y", f64::from(u8::from(self.repeats[1]))),
        ]
    }
}

/// Generates the BSDF of `sample`, going on from `table` where it already has batches (made with the
/// same sample and options). `keep` is called with the table after each batch.
///
/// # Errors
/// If the device fails or loses paths, when stopped by `progress`, or whatever `keep` returns.
pub fn generate(
    device: &Device,
    sample: &Sample,
    table: &mut Table,
    options: &GenerationOptions,
    progress: &dyn Progress,
    warnings: &mut Warnings,
    keep: &mut dyn FnMut(&Table) -> Result<()>,
) -> Result<GenerationStatistics> {
    if options.batches < 2 || options.samples < options.batches {
        return Err(Error::new("at least two batches of at least one sample are needed").field("-c"));
    }
    let directions = table.directions();
    let (tables, [low, high]) = sample.tables(directions.basis())?;
    let scene = tables.upload(device)?;
    let job = Job { device, options, directions, tables, scene, low, high, repeats: sample.repeats };
    let mut surfaces = chains::Surfaces::of(&job, sample.own_triangles(&job.tables));
    let by_chains = match options.method {
        Method::Paths => false,
        Method::Chains => true,
        Method::Best => job.suits_chains(sample),
    };
    let direct_only = by_chains;
    let samples = options.samples.div_ceil(options.batches);
    let mut statistics = GenerationStatistics::default();
    let by_chains = by_chains && !surfaces.is_empty() && options.bounces != Some(0);
    if by_chains {
        surfaces.distribute(&job, options.samples, &mut statistics)?;
    }
    let mut batch = vec![0.0f32; directions.entries()];
    while table.batches() < options.batches {
        let number = table.batches();
        let at = |fraction: f64| (f64::from(number) + fraction) / f64::from(options.batches);
        let report = |fraction: f64| {
            progress.update("BSDF", at(fraction));
            if progress.stop_requested() { Err(cancelled()) } else { Ok(()) }
        };
        batch.fill(0.0);
        let share = if by_chains { 0.5 } else { 1.0 };
        paths::add(&job, number, samples, !direct_only, &mut batch, &mut statistics, &|f| report(f * share))?;
        if by_chains {
            chains::add(&job, &surfaces, number, samples, &mut batch, &mut statistics, &|f| report(share + f * (1.0 - share)))?;
        }
        if options.average_reciprocal {
            table::average_reciprocal(directions, &mut batch);
        }
        table.add(&batch);
        keep(table)?;
    }
    progress.update("BSDF", 1.0);
    explain(&job, table, &statistics, warnings);
    explain_edges(sample, warnings);
    Ok(statistics)
}

/// Depth of a box over its smaller side from which its sides spoil the result: light that leaves there
/// counts with the hemisphere of its direction.
const DEEP: f64 = 0.1;

/// Warns of a sample that is small for its depth.
fn explain_edges(sample: &Sample, warnings: &mut Warnings) {
    let size = sample.high - sample.low;
    let side = (0..2).filter(|axis| !sample.repeats[*axis]).map(|axis| size[axis]).fold(f64::INFINITY, f64::min);
    if size.z > DEEP * side {
        warnings.push(
            Error::new(format!(
                "the box is {:.0} % as deep as it is wide or high: much light leaves over its sides",
                100.0 * size.z / side
            ))
            .field("geometry")
            .help("give a larger sample, or one period of an endless one with --periodic; otherwise the result is not reciprocal"),
        );
    }
}

/// Warns of what is probably not meant.
fn explain(job: &Job, table: &Table, statistics: &GenerationStatistics, warnings: &mut Warnings) {
    use crate::bsdf::Component::{ReflectionBack, ReflectionFront, TransmissionBack, TransmissionFront};
    let at = |message: String| Error::new(message).field("geometry");
    let [through, back] = [TransmissionFront, TransmissionBack].map(|c| table.hemispherical(c));
    if through <= 0.0 && back <= 0.0 {
        warnings.push(at("the device has no opening: no light passes it at all".into()).help(
            "an opaque device is right as it is; else look for a surface that closes the whole box, or a box (-dim) smaller than a single slat",
        ));
    }
    if statistics.mirror_backs > statistics.paths / 50 {
        warnings.push(
            at(format!(
                "{:.0} % of the light ends on the back of mirrors, which reflect on their front only",
                100.0 * statistics.mirror_backs as f64 / statistics.paths as f64
            ))
            .help("if the slats are inside out, turn their surfaces around (xform -I), or use metal, which reflects on both sides"),
        );
    }
    let [front, room] = [ReflectionFront, ReflectionBack].map(|c| table.hemispherical(c));
    for (sum, side) in [(through + front, "outside"), (back + room, "room")] {
        if sum > 1.005 && job.tables.features.grey {
            warnings.push(at(format!(
                "{:.1} % of the light from the {side} comes out again: a material reflects more than it receives",
                100.0 * sum
            )));
        }
    }
}
