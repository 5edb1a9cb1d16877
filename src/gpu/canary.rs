//! Learns at run time what a driver does not tell.

use super::{Device, Kernel, Shader};
use crate::error::Result;

crate::gpu_struct! {
    /// Parameters of `diagnostic/loop_limit`.
    pub(crate) struct LoopLimitParams {
        /// Iterations asked for.
        pub iterations: u32,
    }
}

/// Counts its iterations.
pub(super) const LOOP_LIMIT: Shader = Shader::new("diagnostic/loop_limit", &[&[LoopLimitParams::DECLARED]]);

/// Iterations the probe asks for: well beyond any limit a kernel could meet by accident.
const PROBED: u32 = 1 << 20;

impl Device {
    /// After how many iterations this device silently ends the loops of an invocation (all its loops
    /// together); `None` if it went through a million. Mesa's lavapipe stops after 65,535; there
    /// is no error, results are just too small. Kernels keep below by putting samples into the
    /// grid, and count what they finish. Measured once per device.
    ///
    /// # Errors
    /// Failures of the device.
    pub fn loop_limit(&self) -> Result<Option<u32>> {
        if let Some(limit) = self.0.loop_limit.get() {
            return Ok(*limit);
        }
        let done = self.iterations_done(PROBED)?;
        Ok(*self.0.loop_limit.get_or_init(|| (done < PROBED).then_some(done)))
    }

    fn iterations_done(&self, iterations: u32) -> Result<u32> {
        let kernel = Kernel::new(self, &LOOP_LIMIT, &[])?;
        let params = self.uniform("loop limit parameters", &LoopLimitParams { iterations })?;
        let counted = self.upload("loop limit count", &[u32::MAX; 2])?;
        let group = kernel.bind(&[("params", &params), ("counted", &counted)])?;
        self.dispatch(&kernel, &group, [1, 1, 1])?;
        Ok(self.read::<u32>(&counted)?[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_loops_finish_and_the_limit_is_known() {
        let Some(device) = Device::for_tests("loop limit") else { return };
        for n in [0, 1, 1000, 60_000] {
            assert_eq!(device.iterations_done(n).unwrap(), n);
        }
        let limit = device.loop_limit().unwrap();
        if let Some(limit) = limit {
            assert!((60_000..PROBED).contains(&limit), "{limit}");
            assert_eq!(device.iterations_done(limit).unwrap(), limit);
            assert!(device.iterations_done(limit + 10).unwrap() < limit + 10);
        }
        if device.summary().name.contains("llvmpipe") {
            eprintln!("loop limit of {}: {limit:?}", device.summary().name);
        }
    }
}
