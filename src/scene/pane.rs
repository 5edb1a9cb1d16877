//! Radiance's material `glass`: one pane with Fresnel reflection at both faces; and the rise of reflection of
//! other smooth surfaces towards grazing incidence.

/// Squared roughness up to which surfaces are smooth.
pub(crate) const SMOOTH_ROUGHNESS2: f64 = 1e-6;

/// Specular fraction from which Radiance applies its Fresnel approximation to smooth surfaces (FRESTHRESH).
pub(crate) const FRESNEL_THRESHOLD: f64 = 0.018;

/// See [`smooth_fresnel`].
pub(crate) const FRESNEL_DECAY: f64 = 5.85;

/// Radiance's approximation to Fresnel's law for smooth surfaces: what they add to their specular
/// reflection at this cosine of incidence, as a share of the rest. 0 at normal incidence.
pub(crate) fn smooth_fresnel(cosine: f64) -> f64 {
    (-FRESNEL_DECAY * cosine).exp() - (-FRESNEL_DECAY).exp()
}

/// Transmittance and reflectance of a pane at an angle of incidence: Fresnel's equations by angles, then
/// the sum over all internal reflections, both polarisations averaged. `transmissivity` is that of the
/// material for one pass at normal incidence.
pub(crate) fn glass_pane(transmissivity: [f64; 3], refraction_index: f64, cosine: f64) -> ([f64; 3], [f64; 3]) {
    let sin_in = (1.0 - cosine * cosine).max(0.0).sqrt();
    let cos_out = (1.0 - (sin_in / refraction_index).powi(2)).sqrt();
    let rs = ((cosine - refraction_index * cos_out) / (cosine + refraction_index * cos_out)).powi(2);
    let rp = ((refraction_index * cosine - cos_out) / (refraction_index * cosine + cos_out)).powi(2);
    let pass = transmissivity.map(|t| t.powf(1.0 / cos_out));
    let mix = |f: &dyn Fn(f64, f64) -> f64| pass.map(|d| (f(rs, d) + f(rp, d)) / 2.0);
    let t = mix(&|r, d| (1.0 - r).powi(2) * d / (1.0 - (r * d).powi(2)));
    let r = mix(&|r, d| r + (1.0 - r).powi(2) * r * d * d / (1.0 - (r * d).powi(2)));
    (t, r)
}

/// The transmissivity of a pane of this transmittance at normal incidence: the root of
/// T r² t² + (1 − r)² t − T = 0 with the faces' reflectance r. More than 1 if there is no such pane.
pub(crate) fn transmissivity(transmittance: f64, refraction_index: f64) -> f64 {
    let r = ((refraction_index - 1.0) / (refraction_index + 1.0)).powi(2);
    let passed = (1.0 - r).powi(2);
    // The other form of the root, which does not lose digits where r is small.
    2.0 * transmittance / (passed + (passed * passed + 4.0 * (transmittance * r).powi(2)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transmissivity_and_transmittance_belong_together() {
        for refraction_index in [1.0, 1.3, 1.52, 2.0] {
            for t in [0.0, 0.3, 0.88, 1.0] {
                let transmittance = glass_pane([t; 3], refraction_index, 1.0).0[0];
                assert!((transmissivity(transmittance, refraction_index) - t).abs() < 1e-12);
            }
        }
        // Radiance's manual: transmissivity 0.96 of a pane of transmittance 0.88.
        assert!((transmissivity(0.88, 1.52) - 0.96).abs() < 2e-3);
    }
}
