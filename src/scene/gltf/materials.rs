//! From glTF's metallic-roughness model to the field's materials.
//!
//! | glTF | here |
//! |---|---|
//! | emissive colour × strength > 0 (cd/m², `KHR_materials_emissive_strength`) | glow, radiance = luminance / 179 |
//! | transmission 1, roughness ≤ 0.05, not metallic | glass: base colour is the transmittance at normal incidence, refraction index by `KHR_materials_ior` (1.5 by default) |
//! | transmission > 0 otherwise | trans: colour = base colour, transmissivity = transmission, transmitted specularity 1, with the roughness |
//! | `alphaMode: MASK` and alpha below `alphaCutoff` | nothing: the surface is not there, with a warning |
//! | alpha < 1 with `alphaMode: BLEND` | glass of transmittance 1 − alpha in all colours, with a warning |
//! | metallic ≥ 0.5 | metal: colour = base colour, specularity 1 |
//! | otherwise | plastic: colour = base colour, specularity = ((n−1)/(n+1))², 0.04 by default |
//!
//! Radiance's roughness (RMS slope of the facets) is glTF's roughness squared. Above
//! `ROUGHEST_SPECULAR` a surface reflects diffusely only: Ward's model is made for small slopes.
//! Colours are taken as Radiance's RGB. Textures are left out with a warning, holes and opacity that a texture
//! would give included (the surface is whole then), as are metallic values between 0 and
//! 1, which are rounded.

use crate::error::{Error, Result, Warnings};
use crate::scene::MaterialKind;
use crate::units::LUMINOUS_EFFICACY;
use gltf::material::AlphaMode;

/// RMS slope above which specular reflection is taken as diffuse.
pub(crate) const ROUGHEST_SPECULAR: f64 = 0.3;

/// glTF roughness up to which transmission counts as clear.
const CLEAR_ROUGHNESS: f64 = 0.05;

/// The material a glTF material stands for, by the table above.
///
/// # Errors
/// Factors that are not finite or out of range.
pub(crate) fn kind(material: &gltf::Material, warnings: &mut Warnings) -> Result<MaterialKind> {
    let mut warn = |message: String, help: &str| warnings.push(Error::new(message).help(help));
    let exactly = "write the exact material into the extras: \"radiance\": \"void plastic wall 0 0 5 .5 .5 .5 0 0\"";
    let pbr = material.pbr_metallic_roughness();
    let transmission = material.transmission();
    let textured = pbr.base_color_texture().is_some()
        || pbr.metallic_roughness_texture().is_some()
        || material.emissive_texture().is_some()
        || transmission.as_ref().is_some_and(|t| t.transmission_texture().is_some());
    if textured {
        warn("its textures are left out: only the constant factors are used".into(), exactly);
    }
    if pbr.base_color_texture().is_some() && material.alpha_mode() != AlphaMode::Opaque {
        let what = if material.alpha_mode() == AlphaMode::Mask { "alpha mask" } else { "opacity" };
        warn(
            format!("its {what}, which a picture gives, is left out: the surface has no holes"),
            "cut the holes into the mesh, or give a material that passes as much light in the extras: \"radiance\": \"void trans …\"",
        );
    }
    let [red, green, blue, alpha] = pbr.base_color_factor().map(decimal);
    let color = [red, green, blue];
    let metallic = decimal(pbr.metallic_factor());
    let gltf_roughness = decimal(pbr.roughness_factor());
    let transmitted = transmission.map_or(0.0, |t| decimal(t.transmission_factor()));
    let index = material.ior().map_or(1.5, decimal);
    for (name, value) in [
        ("red", red),
        ("green", green),
        ("blue", blue),
        ("alpha", alpha),
        ("metallic", metallic),
        ("roughness", gltf_roughness),
        ("transmission", transmitted),
    ] {
        if !(0.0..=1.0).contains(&value) {
            return Err(Error::new(format!("its {name} factor is {value}")).help("factors lie between 0 and 1"));
        }
    }
    if !(index >= 1.0 && index.is_finite()) {
        return Err(Error::new(format!("its refraction index is {index}")).help("an index is 1 or more"));
    }
    let strength = material.emissive_strength().map_or(1.0, decimal);
    let emitted = material.emissive_factor().map(|c| decimal(c) * strength / LUMINOUS_EFFICACY);
    if emitted.iter().any(|v| !(*v >= 0.0 && v.is_finite())) {
        return Err(Error::new("its emission is negative or not finite").help("correct the emissive factor and strength"));
    }
    if emitted.iter().any(|v| *v > 0.0) {
        return Ok(MaterialKind::Glow { radiance: emitted, max_radius: 0.0 });
    }
    let metal = metallic >= 0.5;
    if metallic > 0.0 && metallic < 1.0 {
        warn(format!("its metallic factor {metallic} is taken as {}", if metal { 1 } else { 0 }), exactly);
    }
    if material.alpha_mode() == AlphaMode::Blend && alpha < 1.0 && transmitted == 0.0 {
        warn(format!("its opacity {alpha} is taken for a pane that transmits {:.3}", 1.0 - alpha), exactly);
        return Ok(pane([1.0 - alpha; 3], index));
    }
    if material.alpha_mode() == AlphaMode::Mask && alpha < decimal(material.alpha_cutoff().unwrap_or(0.5)) {
        warn(format!("its opacity {alpha} is below the cutoff of its alpha mask: the surface is left out"), exactly);
        return Ok(MaterialKind::Void);
    }
    let roughness = gltf_roughness * gltf_roughness;
    let specular_at_normal = ((index - 1.0) / (index + 1.0)).powi(2);
    if transmitted > 0.0 && !metal {
        if transmitted == 1.0 && gltf_roughness <= CLEAR_ROUGHNESS {
            return Ok(pane(color, index));
        }
        return Ok(MaterialKind::Trans {
            color,
            specularity: specular_at_normal,
            roughness,
            transmissivity: transmitted,
            transmitted_specularity: 1.0,
        });
    }
    let specular = roughness <= ROUGHEST_SPECULAR;
    let roughness = if specular { roughness } else { 0.0 };
    Ok(if metal {
        MaterialKind::Metal { color, specularity: if specular { 1.0 } else { 0.0 }, roughness }
    } else {
        MaterialKind::Plastic { color, specularity: if specular { specular_at_normal } else { 0.0 }, roughness }
    })
}

/// Glass of a transmittance at normal incidence, reflections between its faces included.
fn pane(transmittance: [f64; 3], index: f64) -> MaterialKind {
    // T = (1−r)² t / (1 − r² t²), solved for the transmissivity t.
    let r = ((index - 1.0) / (index + 1.0)).powi(2);
    let transmissivity = transmittance.map(|t| {
        let through = (1.0 - r).powi(2);
        if r * t == 0.0 {
            return (t / through).min(1.0);
        }
        (((through * through + 4.0 * (r * t).powi(2)).sqrt() - through) / (2.0 * r * r * t)).min(1.0)
    });
    MaterialKind::Glass { transmissivity, refraction_index: index }
}

/// The decimal number a 32-bit float was written as: 0.8, not 0.800000011920929.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::NAN)
}
