//! Mixtures of two materials in a constant ratio, as one material of their mean.

use super::patterns::constant;
use super::shares::bounded;
use super::syntax::{Object, shortened};
use crate::error::{Error, Result};
use crate::scene::pane::{FRESNEL_THRESHOLD, SMOOTH_ROUGHNESS2, glass_pane, smooth_fresnel};
use crate::scene::{Lobes, MaterialKind};
use std::f64::consts::PI;

/// Specular reflection that may become diffuse where a mixture cannot keep it.
const LITTLE_SPECULAR: f64 = 0.1;

/// The share of the foreground in a `mixfunc`.
///
/// # Errors
/// If it is not constant, or not within 0…1.
pub(super) fn share(object: &Object, formula: &str, function_file: &str, warn: &mut dyn FnMut(Error)) -> Result<f64> {
    let varies = || {
        Error::new(format!("the share '{}' of this mixture varies over the surface or with the view", shortened(formula)))
            .help("write its mean, a number, in place of the function's name; model coarse holes as geometry")
    };
    let share = match constant(object, formula, &|_, _| None)? {
        Some(share) => share,
        None if function_file.rsplit('/').next() == Some("perforate.cal") && ["x_hole", "y_hole", "z_hole"].contains(&formula) => {
            let Some(radius) = object.reals.first().copied().filter(|r| *r >= 0.0) else { return Err(varies()) };
            let share = 1.0 - hole_area(radius);
            warn(
                Error::new(format!("its holes are taken as spread evenly: {:.2} % of the surface is open", 100.0 * (1.0 - share)))
                    .help("model holes as geometry where their pattern matters"),
            );
            share
        }
        None => return Err(varies()),
    };
    if !(0.0..=1.0).contains(&share) {
        return Err(Error::new(format!("the share of its foreground is {share}")).help("give a share between 0 and 1"));
    }
    Ok(share)
}

/// Share of a unit square that lies in a circle about its centre.
fn hole_area(radius: f64) -> f64 {
    let half = 0.5;
    if radius <= half {
        return PI * radius * radius;
    }
    if radius * radius >= 2.0 * half * half {
        return 1.0;
    }
    // Less four segments beyond the sides.
    let segment = radius * radius * (half / radius).acos() - half * (radius * radius - half * half).sqrt();
    PI * radius * radius - 4.0 * segment
}

/// A material that scatters light as `first` with the chance `share`, else as `second`.
///
/// # Errors
/// If no single material does so: sources of light, mirrors, and shiny parts that differ.
pub(super) fn mixed(first: MaterialKind, second: MaterialKind, share: f64, warn: &mut dyn FnMut(Error)) -> Result<MaterialKind> {
    if first == second || share == 1.0 {
        return Ok(first);
    }
    if share == 0.0 {
        return Ok(second);
    }
    let (a, b) = (lobes(&first)?, lobes(&second)?);
    let mean = |x: [f64; 3], y: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| share * x[c] + (1.0 - share) * y[c]) };
    let mut lobes = Lobes {
        diffuse: mean(a.diffuse, b.diffuse),
        diffuse_transmitted: mean(a.diffuse_transmitted, b.diffuse_transmitted),
        specular: mean(a.specular, b.specular),
        specular_transmitted: mean(a.specular_transmitted, b.specular_transmitted),
        roughness: 0.0,
    };
    let transmits = |l: &Lobes| largest(l.specular_transmitted) > 0.0;
    let shiny = |l: &Lobes| largest(l.specular) > 0.0;
    let roughness = |wanted: &dyn Fn(&Lobes) -> bool| -> Option<Option<f64>> {
        match (wanted(&a), wanted(&b)) {
            (false, false) => Some(None),
            (true, false) => Some(Some(a.roughness)),
            (false, true) => Some(Some(b.roughness)),
            (true, true) => (a.roughness == b.roughness).then_some(Some(a.roughness)),
        }
    };
    let Some(through) = roughness(&transmits) else {
        return Err(
            Error::new("the two materials let light through with different roughness").help("give both the same, or use a BSDF file")
        );
    };
    // Panes and polished materials reflect more towards grazing incidence; the rest does not.
    let rises = |l: &Lobes| l.roughness == 0.0 && largest(l.specular) >= FRESNEL_THRESHOLD;
    let same = match (roughness(&shiny), through) {
        (None, _) => None,
        (Some(None), through) => Some(through.unwrap_or(0.0)),
        (Some(Some(shine)), None) => Some(shine),
        (Some(Some(shine)), Some(through)) => (shine == through).then_some(shine),
    };
    match same {
        Some(roughness) => {
            lobes.roughness = roughness;
            if rises(&a) != rises(&b) {
                warn_of_grazing(first, second, share, lobes, warn);
            }
        }
        None if largest(lobes.specular) <= LITTLE_SPECULAR => {
            warn(
                Error::new(format!("its shine, {:.1} % of the light, is taken as diffuse", 100.0 * largest(lobes.specular)))
                    .help("the amount of light is right; a mixture keeps shine only where both materials have the same roughness"),
            );
            lobes.diffuse = std::array::from_fn(|c| lobes.diffuse[c] + lobes.specular[c]);
            lobes.specular = [0.0; 3];
            lobes.roughness = through.unwrap_or(0.0);
        }
        None => {
            return Err(Error::new("the shiny parts of the two materials are of different roughness, which one material cannot have")
                .help("give both the same roughness, model the pattern as geometry, or use a BSDF file"));
        }
    }
    bounded(lobes)
}

fn largest(c: [f64; 3]) -> f64 {
    c[0].max(c[1]).max(c[2])
}

/// The lobes of a material; those of glass at normal incidence.
fn lobes(kind: &MaterialKind) -> Result<Lobes> {
    match *kind {
        MaterialKind::Void => Ok(Lobes { specular_transmitted: [1.0; 3], ..Lobes::default() }),
        MaterialKind::Glass { transmissivity, refraction_index } => {
            let (specular_transmitted, specular) = glass_pane(transmissivity, refraction_index, 1.0);
            Ok(Lobes { specular, specular_transmitted, ..Lobes::default() })
        }
        _ => kind
            .lobes()
            .map(|l| Lobes { roughness: if l.roughness * l.roughness <= SMOOTH_ROUGHNESS2 { 0.0 } else { l.roughness }, ..l })
            .ok_or_else(|| {
                Error::new("a light source or a mirror in a mixture is not known here")
                    .help("use `metal` for the mirror, and leave light sources out")
            }),
    }
}

/// Says what the mean material does to light from all directions, beside what the mixture would.
fn warn_of_grazing(first: MaterialKind, second: MaterialKind, share: f64, lobes: Lobes, warn: &mut dyn FnMut(Error)) {
    let [a, b, got] = [first, second, MaterialKind::Lobes(lobes)].map(|k| hemispherical_transmittance(&k));
    let right = share * a + (1.0 - share) * b;
    warn(
        Error::new(format!("the mixture's reflection towards grazing incidence is that of its mean: it lets {:.2} % of diffuse light through in place of {:.2} %", 100.0 * got, 100.0 * right))
            .help("at normal incidence it is exact; model the pattern as geometry where that is not enough"),
    );
}

/// Share of diffuse light (green) that passes.
fn hemispherical_transmittance(kind: &MaterialKind) -> f64 {
    const STEPS: usize = 200;
    let at = |cosine: f64| match *kind {
        MaterialKind::Glass { transmissivity, refraction_index } => glass_pane(transmissivity, refraction_index, cosine).0[1],
        MaterialKind::Void => 1.0,
        _ => {
            let Some(l) = kind.lobes() else { return 0.0 };
            let rise = if l.roughness == 0.0 && largest(l.specular) >= FRESNEL_THRESHOLD { smooth_fresnel(cosine) } else { 0.0 };
            (l.specular_transmitted[1] + l.diffuse_transmitted[1]) * (1.0 - rise)
        }
    };
    (0..STEPS).map(|i| ((i as f64 + 0.5) / STEPS as f64).sqrt()).map(at).sum::<f64>() / STEPS as f64
}
