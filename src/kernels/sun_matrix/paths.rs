//! Light that surfaces scatter, by paths of each receiver's own: every vertex of a path sends a ray to every
//! sun (next-event estimation), so that the paths serve all suns.

use super::direct::mirrored;
use super::result::Hits;
use super::tracer::{STRUCTS, SunTracer, SunVertex, Tile};
use crate::error::Result;
use crate::gpu::{Buffer, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::trace::{self, TraceStatistics, stream_seed};
use glam::Mat3;
use std::f32::consts::FRAC_1_PI;

gpu_struct! {
    /// Parameters of `sun_matrix/paths`.
    pub(crate) struct SunPathParams {
        seed: u32,
        receivers: u32,
        paths: u32,
        batches: u32,
        window_count: u32,
        most_vertices: u32,
        roulette_weight: f32,
        batch_stride: u32,
        path_sets: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

gpu_struct! {
    /// Parameters of `sun_matrix/scattered`.
    pub(crate) struct ScatteredParams {
        seed: u32,
        lists: u32,
        /// Suns of each set: numbers `set`, `set + stride` …
        suns: u32,
        stride: u32,
        all_suns: u32,
        components: u32,
        /// Slots per path, which ends with its first vertex without material.
        path_slots: u32,
        /// Whether neighbours take neighbouring lists, not suns.
        lists_first: u32,
        /// Columns of the matrix that takes a direction to the sun to that of its image.
        image_x: [f32; 3],
        /// Openings that light of an image must pass.
        window_count: u32,
        image_y: [f32; 3],
        gates: u32,
        image_z: [f32; 3],
        /// Radiance of the brightest surface by the irradiance of the sun: what paths without a vertex count with.
        brightest: f32,
    }
}

gpu_struct! {
    /// Paths that a receiver, or a point, gets light from.
    pub(crate) struct VertexList {
        /// Its first vertex; paths follow each other.
        pub first: u32,
        pub paths: u32,
        /// Number of its first sun.
        pub first_sun: u32,
        /// These choose its random numbers: lists of one stream share them out.
        pub stream: u32,
        pub index: u32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
    }
}

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<Shader> {
    vec![PATHS, SCATTERED]
}

const PATHS: Shader = trace::shader("sun_matrix/paths", &[STRUCTS, &[SunPathParams::DECLARED]]);
const SCATTERED: Shader = trace::shader("sun_matrix/scattered", &[STRUCTS, &[ScatteredParams::DECLARED, VertexList::DECLARED]]);

/// What lists of paths gather: `[list][value][sun of its set]`.
pub(super) struct Gathered {
    /// Components, then paths that found light, that would, what all would bring, and the sum of its squares.
    pub values: Vec<f32>,
    pub components: usize,
    pub suns: usize,
}

impl Gathered {
    /// Values of a list.
    pub fn list(&self, list: usize) -> &[f32] {
        let size = (self.components + 4) * self.suns;
        &self.values[list * size..][..size]
    }
}

/// How paths lie in memory, and for which suns they are.
#[derive(Clone, Copy)]
pub(super) struct Lists {
    /// Slots of a path.
    pub path_slots: usize,
    /// Suns of a set, and from one to the next.
    pub suns: usize,
    pub stride: usize,
    pub seed: u32,
    /// Whether neighbours take neighbouring lists.
    pub lists_first: bool,
}

/// What every list brings of its suns, or of their images.
pub(super) fn gather(
    tracer: &SunTracer<'_>,
    lists: &[VertexList],
    vertices: &Buffer,
    how: Lists,
    image: Option<&Mat3>,
    statistics: &mut TraceStatistics,
) -> Result<Gathered> {
    let device = tracer.device;
    let components = tracer.components();
    let sums = device.zeros::<f32>("scattered light of suns", lists.len() * how.suns * (components + 4))?;
    let [image_x, image_y, image_z] = image.copied().unwrap_or_default().to_cols_array_2d();
    let params = ScatteredParams {
        seed: how.seed,
        lists: lists.len() as u32,
        suns: how.suns as u32,
        stride: how.stride as u32,
        all_suns: tracer.sun_count as u32,
        components: components as u32,
        path_slots: how.path_slots as u32,
        lists_first: u32::from(how.lists_first),
        image_x,
        window_count: tracer.window_count,
        image_y,
        gates: tracer.gate_count,
        image_z,
        brightest: tracer.brightest * FRAC_1_PI,
    };
    let params = device.uniform("scattered light of suns", &params)?;
    let list_buffer = device.upload("lists of vertices", lists)?;
    let own = [
        ("params", &params),
        ("lists", &list_buffer),
        ("vertices", vertices),
        ("suns", &tracer.suns),
        ("gates", &tracer.gates),
        ("sums", &sums),
    ];
    let kernel = tracer.kernel(&SCATTERED, &mirrored(image))?;
    tracer.run(&kernel, &own, (how.suns * lists.len()) as u64, statistics)?;
    Ok(Gathered { values: device.read_finite(&sums)?, components, suns: how.suns })
}

/// Paths of all sets from these receivers, `[batch][receiver][set][path][vertex]`; only those vertices that are seen
/// reflected in panes, or all.
pub(super) fn start(tracer: &SunTracer<'_>, tile: &Tile<'_>, reflected_only: bool, statistics: &mut TraceStatistics) -> Result<Buffer> {
    let (o, device, count) = (&tracer.options, tracer.device, tile.count());
    let started = o.batches as usize * count * (o.paths * o.path_sets) as usize;
    let vertices = device.zeros::<SunVertex>("vertices that see suns", started * o.most_vertices() as usize)?;
    let params = SunPathParams {
        seed: stream_seed(o.seed, 0, 0x7375_6e70),
        receivers: count as u32,
        paths: o.paths,
        batches: o.batches,
        window_count: tracer.window_count,
        most_vertices: o.most_vertices(),
        roulette_weight: o.roulette_weight,
        batch_stride: tile.batch_stride,
        path_sets: o.path_sets,
        ..SunPathParams::default()
    };
    let params = device.uniform("paths to suns", &params)?;
    let own = [("params", &params), ("receivers", tile.receivers), ("vertices", &vertices)];
    let kernel = Kernel::new(device, &PATHS, &[("REFLECTED_ONLY", f64::from(u8::from(reflected_only)))])?;
    tracer.run(&kernel, &own, started as u64, statistics)?;
    Ok(vertices)
}

/// What receivers get of every sun by their paths.
pub(super) struct Scattered {
    /// `[batch][receiver][sun]`, rgb, sr.
    pub light: Vec<[f32; 3]>,
    /// `[receiver][sun]`, of all batches.
    pub hits: Vec<Hits>,
}

/// Light that surfaces scatter to the receivers, by paths of their own.
pub(super) fn light(tracer: &SunTracer<'_>, tile: &Tile<'_>, statistics: &mut TraceStatistics) -> Result<Scattered> {
    let (o, count, suns) = (&tracer.options, tile.count(), tracer.sun_count);
    let (batches, sets, slots) = (o.batches as usize, o.path_sets as usize, o.most_vertices() as usize);
    let mut found = Scattered { light: vec![[0.0; 3]; batches * count * suns], hits: vec![Hits::default(); count * suns] };
    let vertices = start(tracer, tile, false, statistics)?;
    // Groups of a batch's, a receiver's and a set's paths, in chunks.
    let chunks = (o.paths).div_ceil(tracer.most_paths);
    let list = |i: usize| {
        let (group, first_path) = (i / chunks as usize, i as u32 % chunks * tracer.most_paths);
        let (cell, set) = (group / sets, group % sets);
        VertexList {
            first: ((group * o.paths as usize + first_path as usize) * slots) as u32,
            paths: (o.paths - first_path).min(tracer.most_paths),
            first_sun: set as u32,
            stream: stream_seed(tile.numbers[cell % count], (cell / count) as u32, 0x7375_6e6c),
            index: first_path,
            ..VertexList::default()
        }
    };
    let lists: Vec<VertexList> = (0..batches * count * sets * chunks as usize).map(list).collect();
    let seed = stream_seed(o.seed, 0, 0x7375_6e67);
    let how = Lists { path_slots: slots, suns: suns.div_ceil(sets), stride: sets, seed, lists_first: tile.batch_stride > 0 };
    let mut open = vec![[0.0; 2]; count * suns];
    for image in std::iter::once(None).chain(tracer.images.iter().map(Some)) {
        let gathered = gather(tracer, &lists, &vertices, how, image, statistics)?;
        for (i, list) in lists.iter().enumerate() {
            let (values, cell) = (gathered.list(i), i / chunks as usize / sets);
            for (k, sun) in (list.first_sun as usize..suns).step_by(sets).enumerate() {
                let value = |v: usize| values[v * how.suns + k];
                let sum = &mut found.light[cell * suns + sun];
                (0..3).for_each(|c| sum[c] += value(if gathered.components == 1 { 0 } else { c }));
                let n = gathered.components;
                let hits = &mut found.hits[cell % count * suns + sun];
                hits.found += f64::from(value(n));
                hits.looks += f64::from(value(n + 1));
                hits.light += (0..n).map(|c| f64::from(value(c))).fold(0.0, f64::max);
                let open = &mut open[cell % count * suns + sun];
                *open = [open[0] + f64::from(value(n + 2)), open[1] + f64::from(value(n + 3))];
            }
        }
    }
    for (hits, [open, squares]) in found.hits.iter_mut().zip(open) {
        hits.unseen = if open > 0.0 { squares / open } else { 0.0 };
    }
    Ok(found)
}
