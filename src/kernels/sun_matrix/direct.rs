//! Direct light of suns, and of their images in flat mirrors. Most pairs of a receiver and a sun do not see
//! each other: those that may are listed first, so that their rays go side by side and nothing else does.

use super::pane::tables::PaneSun;
use super::tracer::{STRUCTS, SunRecord, SunTracer, Tile};
use crate::error::Result;
use crate::gpu::{Buffer, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{self, TraceStatistics, stream_seed};
use glam::{Mat3, Vec3};

gpu_struct! {
    /// Parameters of `sun_matrix/candidates` and `sun_matrix/direct`.
    pub(crate) struct PairParams {
        seed: u32,
        /// Per batch.
        receivers: u32,
        suns: u32,
        batches: u32,
        /// Openings, as `may_come_in` takes them.
        window_count: u32,
        gates: u32,
        /// Points of the disc per receiver and batch.
        disc_samples: u32,
        /// Points of the disc's rim that are looked at where all other points agree: whatever covers a part of
        /// the disc from one side is seen at its rim first.
        rim: u32,
        /// Columns of the matrix that takes a direction to the sun to that of its image.
        image_x: [f32; 3],
        /// Receivers from one batch to the next; 0 if all batches share them.
        batch_stride: u32,
        image_y: [f32; 3],
        /// Pairs that are listed.
        pairs: u32,
        image_z: [f32; 3],
        padding0: u32,
    }
}

gpu_struct! {
    /// A receiver and a sun.
    pub(crate) struct Pair {
        /// Number of the receiver: [batch][receiver].
        cell: u32,
        sun: u32,
    }
}

/// Points of a disc's rim.
const RIM: u32 = 4;

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<Shader> {
    vec![CANDIDATES, DIRECT]
}

const CANDIDATES: Shader = trace::shader("sun_matrix/candidates", &[STRUCTS, &[PairParams::DECLARED, Pair::DECLARED]]);
const DIRECT: Shader = trace::shader("sun_matrix/direct", &[STRUCTS, &[PairParams::DECLARED, Pair::DECLARED, PaneSun::DECLARED]]);

/// What receivers get directly from every sun and its images: `[batch][receiver][sun]`, rgb, sr, and the variance
/// that it may have by the number of points seen.
pub(super) fn light(tracer: &SunTracer<'_>, tile: &Tile<'_>, statistics: &mut TraceStatistics) -> Result<Vec<[f32; 4]>> {
    let (device, o, count) = (tracer.device, &tracer.options, tile.count());
    let all = o.batches as usize * count * tracer.sun_count;
    let mut light = vec![[0.0; 4]; all];
    if all == 0 || tracer.panes.as_ref().is_some_and(|p| !p.is_clear) {
        return Ok(light);
    }
    for image in std::iter::once(None).chain(tracer.images.iter().map(Some)) {
        let mut params = PairParams {
            seed: stream_seed(o.seed, 0, 0x7375_6e67),
            receivers: count as u32,
            suns: tracer.sun_count as u32,
            batches: o.batches,
            disc_samples: o.disc_samples,
            // A pixel's batches have surface points of their own: their spread is its error.
            rim: if tile.batch_stride == 0 { RIM } else { 0 },
            batch_stride: tile.batch_stride,
            ..params(tracer, image)
        };
        let listed = device.zeros::<Pair>("pairs of receivers and suns", all)?;
        let number = device.zeros::<u32>("number of pairs", 1)?;
        let uniform = device.uniform("pairs", &params)?;
        let kernel = tracer.kernel(&CANDIDATES, &mirrored(image))?;
        let own = [
            ("params", &uniform),
            ("receivers", tile.receivers),
            ("suns", &tracer.suns),
            ("gates", &tracer.gates),
            ("candidates", &listed),
            ("candidate_count", &number),
        ];
        tracer.run(&kernel, &own, all as u64, statistics)?;
        params.pairs = device.read::<u32>(&number)?[0];
        if params.pairs == 0 {
            continue;
        }
        let found = of_pairs(tracer, &params, [tile.receivers, &tracer.suns, &listed], image, statistics)?;
        // In any order, but each once.
        for (pair, found) in device.read::<Pair>(&listed)?.iter().zip(&found) {
            let sum = &mut light[pair.cell as usize * tracer.sun_count + pair.sun as usize];
            (0..4).for_each(|c| sum[c] += found[c]);
        }
    }
    Ok(light)
}

/// A ray from an eye.
#[derive(Clone, Copy)]
pub(super) struct EyeRay {
    /// In the tracer's coordinates.
    pub origin: [f32; 3],
    /// Where the sun stands, and where it is looked for: the same, or in a mirror.
    pub sun: Vec3,
    pub direction: Vec3,
}

/// What share of a sun's light, or of its image's, arrives along each ray.
pub(super) fn at_rays(
    tracer: &SunTracer<'_>,
    rays: &[EyeRay],
    image: Option<&Mat3>,
    statistics: &mut TraceStatistics,
) -> Result<Vec<[f32; 3]>> {
    // As the irradiance of a plane across the nearest axis by a point of solid angle 1.
    let axis = |ray: &EyeRay| {
        let size = ray.direction.abs();
        let axis = if size.x >= size.y.max(size.z) { 0 } else { 1 + usize::from(size.z > size.y) };
        let mut normal = Vec3::ZERO;
        normal[axis] = ray.direction[axis].signum();
        normal
    };
    let receivers: Vec<Receiver> =
        rays.iter().map(|r| Receiver { position: r.origin, normal: axis(r).to_array(), ..Receiver::default() }).collect();
    let point = |r: &EyeRay| SunRecord { direction: r.sun.to_array(), solid_angle: 1.0, ..SunRecord::default() };
    let suns: Vec<SunRecord> = rays.iter().map(point).collect();
    let pairs: Vec<Pair> = (0..rays.len() as u32).map(|i| Pair { cell: i, sun: i }).collect();
    let n = rays.len() as u32;
    let params = PairParams { receivers: n, suns: n, batches: 1, disc_samples: 1, pairs: n, ..params(tracer, image) };
    let device = tracer.device;
    let [receivers, suns] = [device.upload("eyes", &receivers)?, device.upload("points of suns", &suns)?];
    let found = of_pairs(tracer, &params, [&receivers, &suns, &device.upload("rays to suns", &pairs)?], image, statistics)?;
    Ok(found.iter().zip(rays).map(|(f, ray)| std::array::from_fn(|c| f[c] / ray.direction.abs().max_element())).collect())
}

fn params(tracer: &SunTracer<'_>, image: Option<&Mat3>) -> PairParams {
    let [image_x, image_y, image_z] = image.copied().unwrap_or_default().to_cols_array_2d();
    PairParams { window_count: tracer.window_count, gates: tracer.gate_count, image_x, image_y, image_z, ..PairParams::default() }
}

pub(super) fn mirrored(image: Option<&Mat3>) -> [(&'static str, f64); 1] {
    [("MIRRORED", f64::from(u8::from(image.is_some())))]
}

/// Light of the listed pairs of these receivers and suns, and its doubt.
fn of_pairs(
    tracer: &SunTracer<'_>,
    params: &PairParams,
    [receivers, suns, pairs]: [&Buffer; 3],
    image: Option<&Mat3>,
    statistics: &mut TraceStatistics,
) -> Result<Vec<[f32; 4]>> {
    let device = tracer.device;
    let [mirrored] = mirrored(image);
    let kernel = tracer.kernel(&DIRECT, &[mirrored, ("THROUGH_PANES", f64::from(u8::from(tracer.panes.is_some())))])?;
    let light = device.zeros::<[f32; 4]>("light of suns", params.pairs as usize)?;
    let uniform = device.uniform("pairs", params)?;
    let own = [
        ("params", &uniform),
        ("receivers", receivers),
        ("suns", suns),
        ("gates", &tracer.gates),
        ("pairs", pairs),
        ("pane_suns", &tracer.pane_suns),
        ("light", &light),
    ];
    tracer.run(&kernel, &own, u64::from(params.pairs), statistics)?;
    let found = device.read::<[f32; 4]>(&light)?;
    Ok(found)
}
