//! Straight sunlight at points behind pixels. Most pairs of a point and a sun do not see each other:
//! those that may are listed first, so that their rays go side by side and nothing else does.

use super::geometry::Gate;
use super::tracer::{SunRecord, SunTracer, SunVertex};
use crate::error::Result;
use crate::gpu::{Buffer, Declared, Device, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{self, TraceStatistics, stream_seed};

gpu_struct! {
    /// Parameters of `trace/sun_candidates` and `trace/sun_straight`.
    pub(crate) struct PairParams {
        seed: u32,
        /// Per batch.
        receivers: u32,
        suns: u32,
        batches: u32,
        /// Openings, as `may_come_in` takes them.
        window_count: u32,
        gates: u32,
        /// Points of the disc per receiver.
        disc_samples: u32,
        /// Pairs that may see each other, where they are listed.
        candidates: u32,
    }
}

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<Shader> {
    vec![CANDIDATES, STRAIGHT]
}

const STRUCTS: &[Declared] = &[PairParams::DECLARED, Receiver::DECLARED, SunRecord::DECLARED, SunVertex::DECLARED, Gate::DECLARED];
const CANDIDATES: Shader = trace::shader("trace/sun_candidates", &[STRUCTS]);
const STRAIGHT: Shader = trace::shader("trace/sun_straight", &[STRUCTS]);

/// The two steps.
pub(super) struct Pairs {
    candidates: Kernel,
    straight: Kernel,
}

impl Pairs {
    /// `constants` are those of kernels that trace rays to suns.
    pub fn new(device: &Device, constants: &[(&str, f64)]) -> Result<Self> {
        Ok(Self { candidates: Kernel::new(device, &CANDIDATES, &[])?, straight: Kernel::new(device, &STRAIGHT, constants)? })
    }

    /// Writes straight light to `sums` (`[batch][receiver][sun][straight rgb, scattered rgb]`). Every
    /// batch has `count` receivers of its own.
    pub fn trace(
        &self,
        tracer: &SunTracer<'_>,
        receivers: &Buffer,
        count: usize,
        sums: &Buffer,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let (device, o) = (tracer.device(), tracer.options());
        let (gates, gate_count) = tracer.gates();
        let (suns, sun_count) = tracer.suns();
        let pairs = o.batches as usize * count * sun_count;
        let mut params = PairParams {
            seed: stream_seed(o.seed, 0, 0x7375_6e67),
            receivers: count as u32,
            suns: sun_count as u32,
            batches: o.batches,
            window_count: tracer.window_count(),
            gates: gate_count,
            disc_samples: o.disc_samples,
            candidates: 0,
        };
        let listed = device.zeros::<u32>("pairs of points and suns", pairs)?;
        let number = device.zeros::<u32>("number of pairs", 1)?;
        let uniform = device.uniform("pairs", &params)?;
        let own = [
            ("params", &uniform),
            ("receivers", receivers),
            ("suns", suns),
            ("gates", gates),
            ("candidates", &listed),
            ("candidate_count", &number),
        ];
        tracer.run(&self.candidates, &own, [(count as u32).div_ceil(64), sun_count as u32, o.batches], pairs as u64, statistics)?;
        params.candidates = device.read::<u32>(&number)?[0];
        if params.candidates == 0 {
            return Ok(());
        }
        let uniform = device.uniform("pairs", &params)?;
        let own =
            [("params", &uniform), ("receivers", receivers), ("suns", suns), ("gates", gates), ("candidates", &listed), ("sums", sums)];
        let groups = device.grid(u64::from(params.candidates).div_ceil(64))?;
        tracer.run(&self.straight, &own, groups, u64::from(params.candidates), statistics)
    }
}
