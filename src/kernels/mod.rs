//! One module per kernel: host half and f64 reference.

pub mod bsdf_generation;
pub(crate) mod bsdf_scattering;
pub mod coefficients;
pub mod daylight_matrix;
#[cfg(test)]
mod drivers;
pub mod glare;
pub mod image_matrix;
pub(crate) mod light_paths;
pub mod product;
pub mod sun_matrix;
pub mod trace;
pub mod view_matrix;

/// Every shader in use, for the test that links and validates them.
pub fn registered() -> Vec<crate::gpu::Shader> {
    let mut all = crate::gpu::registered();
    all.extend(image_matrix::registered());
    all.extend(light_paths::registered());
    all.extend(sun_matrix::registered());
    all.extend(view_matrix::registered());
    all.extend(daylight_matrix::registered());
    all.extend(coefficients::registered());
    all.extend(bsdf_generation::registered());
    all.extend(glare::registered());
    all.extend(bsdf_scattering::registered());
    all.extend(product::registered());
    all.extend(trace::probes::registered());
    all
}
