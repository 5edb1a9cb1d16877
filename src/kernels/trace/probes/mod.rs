//! Probes: small kernels that run the shaders' shared functions on arrays, so that tests can
//! compare each function with its f64 counterpart.

use super::shader;
use crate::gpu::Shader;
use crate::gpu_struct;
use crate::kernels::daylight_matrix::SkyRow;

#[cfg(test)]
mod bins;
#[cfg(test)]
mod circle;
#[cfg(test)]
mod leaks;
#[cfg(test)]
mod material;
#[cfg(test)]
mod random;
#[cfg(test)]
mod rays;
#[cfg(test)]
mod windows;

gpu_struct! {
    /// Parameters of `diagnostic/probe_random`.
    pub(crate) struct RandomProbeParams {
        seed: u32,
        dimension_pair: u32,
        first: u32,
        count: u32,
    }
}

gpu_struct! {
    /// One question of `diagnostic/probe_material`.
    pub(crate) struct MaterialProbe {
        /// Of the glass.
        transmissivity: [f32; 3],
        index: f32,
        /// Around which diffuse directions are drawn.
        normal: [f32; 3],
        /// Of incidence on the glass.
        cosine: f32,
        random: [f32; 2],
        padding: [u32; 2],
    }
}

gpu_struct! {
    /// Its answer.
    pub(crate) struct MaterialAnswer {
        transmitted: [f32; 3],
        padding0: u32,
        reflected: [f32; 3],
        padding1: u32,
        direction: [f32; 3],
        padding2: u32,
    }
}

gpu_struct! {
    /// Parameters of `diagnostic/probe_bins`.
    pub(crate) struct BinProbeParams {
        count: u32,
        window: u32,
        /// Sky rows with the cap.
        sky_rows: u32,
        row_height: f32,
    }
}

gpu_struct! {
    /// One question of `diagnostic/probe_bins`.
    pub(crate) struct BinProbe {
        direction: [f32; 3],
        /// For the way back: bin within the window and place in it.
        bin: u32,
        random: [f32; 2],
        padding: [u32; 2],
    }
}

gpu_struct! {
    /// Its answer.
    pub(crate) struct BinAnswer {
        /// Inside the bin asked for.
        direction: [f32; 3],
        /// Of the direction asked for.
        window_bin: u32,
        sky_bin: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

gpu_struct! {
    /// Parameters of `diagnostic/probe_windows`.
    pub(crate) struct WindowProbeParams {
        eye: [f32; 3],
        seed: u32,
        count: u32,
        window_count: u32,
        padding: [u32; 2],
    }
}

gpu_struct! {
    /// One answer of `diagnostic/probe_windows`.
    pub(crate) struct WindowAnswer {
        direction: [f32; 3],
        distance: f32,
        point: [f32; 3],
        weight: f32,
        total: f32,
        window: u32,
        padding: [u32; 2],
    }
}

gpu_struct! {
    /// One question of `diagnostic/probe_rays`.
    pub(crate) struct Ray {
        origin: [f32; 3],
        padding0: u32,
        direction: [f32; 3],
        padding1: u32,
    }
}

gpu_struct! {
    /// Its answer.
    pub(crate) struct RayAnswer {
        distance: f32,
        /// Place in the leaves of the BVH.
        triangle: u32,
        barycentric: [f32; 2],
        /// Whether any surface is in the way.
        blocked: u32,
        padding: u32,
    }
}

gpu_struct! {
    /// Parameters of `diagnostic/probe_leaks`.
    pub(crate) struct LeakProbeParams {
        seed: u32,
        chains: u32,
        rays_per_chain: u32,
        triangles: u32,
    }
}

gpu_struct! {
    /// Counts of `diagnostic/probe_leaks`.
    pub(crate) struct LeakCounts: atomic {
        missed: u32,
        from_behind: u32,
        /// Rays that met a front side.
        met: u32,
        padding: u32,
    }
}

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![CIRCLE, RANDOM, MATERIAL, BINS, WINDOWS, RAYS, LEAKS]
}

const CIRCLE: Shader = shader("diagnostic/probe_circle", &[]);
const RANDOM: Shader = shader("diagnostic/probe_random", &[&[RandomProbeParams::DECLARED]]);
const MATERIAL: Shader = shader("diagnostic/probe_material", &[&[MaterialProbe::DECLARED, MaterialAnswer::DECLARED]]);
const BINS: Shader =
    shader("diagnostic/probe_bins", &[&[BinProbeParams::DECLARED, BinProbe::DECLARED, BinAnswer::DECLARED, SkyRow::DECLARED]]);
const WINDOWS: Shader = shader("diagnostic/probe_windows", &[&[WindowProbeParams::DECLARED, WindowAnswer::DECLARED]]);
const RAYS: Shader = shader("diagnostic/probe_rays", &[&[Ray::DECLARED, RayAnswer::DECLARED]]);
const LEAKS: Shader = shader("diagnostic/probe_leaks", &[&[LeakProbeParams::DECLARED, LeakCounts::DECLARED]]);

#[cfg(test)]
use running::run;

#[cfg(test)]
mod running {
    use super::super::{Counters, TraceScene, check_finished};
    use crate::gpu::{Buffer, Device, Kernel, Shader};

    /// Runs a probe on a grid of workgroups with a scene bound. `finishing` is how many invocations
    /// report that they finished, if the probe counts them.
    pub fn run(
        device: &Device,
        shader: &Shader,
        scene: Option<&TraceScene>,
        own: &[(&str, &Buffer)],
        workgroups: [u32; 3],
        finishing: Option<u64>,
    ) {
        let kernel = Kernel::new(device, shader, &[]).unwrap();
        let counters = device.zeros::<Counters>("path counters", 1).unwrap();
        let mut bindings = scene.map_or_else(Vec::new, |s| s.bindings(&[]));
        bindings.extend_from_slice(own);
        bindings.push(("counters", &counters));
        // Probes declare what they use.
        let declared = kernel.declared();
        bindings.retain(|(name, _)| declared.contains(name));
        let bind = kernel.bind(&bindings).unwrap();
        device.dispatch(&kernel, &bind, workgroups).unwrap();
        if let Some(started) = finishing {
            check_finished(&device.read::<Counters>(&counters).unwrap()[0], started, shader.path()).unwrap();
        }
        device.wait().unwrap();
    }
}
