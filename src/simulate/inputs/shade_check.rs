//! Whether what the sun is traced through and the BSDF of the same window let through the same light.
//!
//! Rays of the central bin of the window's basis (within 5° of the normal in Klems' full basis) start
//! before the window, evenly over its area, and walk through the shade's panes and slats until they
//! leave: [`RAYS`] of them, on the host. Rough specular parts are mirrored as smooth ones are; where
//! they lead is another matter than whether they pass.

use super::{Inputs, ProjectWindow};
use crate::bvh::Caster;
use crate::error::{Error, Warnings};
use crate::kernels::sun_matrix::pane::PaneBsdf;
use crate::random::Random;
use crate::scene::pane::{glass_pane, transmissivity};
use crate::scene::{MaterialKind, Scene, Window};
use crate::simulate::project::{Filling, Project};
use crate::units::BRIGHTNESS_WEIGHTS;
use glam::DVec3;
use rayon::prelude::*;

/// Rays, in groups that are independent.
const RAYS: usize = 16_384;
const GROUPS: usize = 64;
/// Difference of the transmittances that is worth a warning, relative to the BSDF's.
const ALLOWED: f64 = 0.03;
/// Difference that another reading of the panes must leave at most to be what was meant.
const AGREES: f64 = 0.015;
/// Meetings of a ray with surfaces, at most, and the weight below which it is given up.
const MOST_MEETINGS: usize = 1000;
const LEAST_WEIGHT: f64 = 1e-4;

/// A transmittance with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Transmittance {
    value: f64,
    error: f64,
}

/// Warns of windows whose shade or tensor tree is not that of their BSDF at normal incidence.
pub(super) fn warn(project: &Project, inputs: &Inputs, warnings: &mut Warnings) {
    for window in inputs.windows_in_all_states().iter().filter(|w| w.is_sunny()) {
        // A clear pane is both, and so are the window's own data.
        if window.glass.is_some() || (window.shade.is_none() && passes_own_data(project, window)) {
            continue;
        }
        let bsdf = of_bsdf(window);
        // A window that is opaque to the sky has no ratio.
        if bsdf < 1e-3 {
            continue;
        }
        let (sharp, key) = match (&window.shade, &window.pane) {
            (Some(shade), _) => (of_shade(&shade.scene, &window.window), "shade"),
            (None, Some(pane)) => (of_pane(&pane.data, &window.window), "tensor_tree"),
            (None, None) => continue,
        };
        if !differs(sharp, bsdf) {
            continue;
        }
        let error = if sharp.error > 0.0 { format!(" ± {:.3}", sharp.error) } else { String::new() };
        let doubt = Error::new(format!(
            "the {} of window '{}' passes {:.3}{error} of the light at normal incidence, its BSDF {bsdf:.3}: sun and sky pass different windows",
            key.replace('_', " "),
            window.name,
            sharp.value
        ))
        .file(&project.file)
        .field(format!("window.{key}"));
        let glass = window.shade.as_ref().and_then(|shade| meant_transmittance(&shade.scene, &window.window, bsdf));
        let help = glass.unwrap_or_else(|| {
            "both must describe the same panes and slats: make the BSDF of them with 'lucarne bsdf generate', or correct one of them".into()
        });
        warnings.push(doubt.help(help));
    }
}

fn passes_own_data(project: &Project, window: &ProjectWindow) -> bool {
    let section = project.windows.iter().find(|s| s.is_of(&window.name));
    let section = section.map(|s| s.in_state(usize::from(window.state)));
    section.is_some_and(|s| match &s.tensor_tree {
        Some(data) => data.file.is_none(),
        None => matches!(s.filling, Filling::Layers(_)),
    })
}

/// Beyond what is allowed, and beyond the noise.
fn differs(sharp: Transmittance, bsdf: f64) -> bool {
    (sharp.value - bsdf).abs() > ALLOWED * bsdf + 3.0 * sharp.error
}

fn luminous(c: [f64; 3]) -> f64 {
    c.iter().zip(BRIGHTNESS_WEIGHTS).map(|(v, w)| v * w).sum()
}

fn central_bin(window: &Window) -> usize {
    window.basis.bin_of(DVec3::Z)
}

/// Of the BSDF: all that leaves, of the light of the central bin.
fn of_bsdf(window: &ProjectWindow) -> f64 {
    let (basis, t, bin) = (&window.window.basis, &window.transmission, central_bin(&window.window));
    let passed = |o: usize| luminous([0, 1, 2].map(|c| t.at(o, bin)[c])) * basis.projected_solid_angle(o);
    (0..t.rows()).map(passed).sum::<f64>() / basis.projected_solid_angle(bin)
}

fn of_pane(pane: &PaneBsdf, window: &Window) -> Transmittance {
    const STEPS: usize = 8;
    let (PaneBsdf::Bsdf(scattering) | PaneBsdf::PeakBsdf(scattering)) = pane else {
        return Transmittance { value: 0.0, error: f64::INFINITY };
    };
    let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
    let directions = (0..STEPS * STEPS).map(|k| window.basis.direction(central_bin(window), at(k / STEPS), at(k % STEPS)));
    let sum: f64 = directions.map(|d| scattering.direct_hemispherical(d, true)).sum();
    Transmittance { value: sum / (STEPS * STEPS) as f64, error: 0.0 }
}

/// If taking the numbers of the shade's glass for transmittances makes it agree with the BSDF: what to do.
fn meant_transmittance(shade: &Scene, window: &Window, bsdf: f64) -> Option<String> {
    let mut other = shade.clone();
    let mut example = None;
    for material in &mut other.materials {
        if let MaterialKind::Glass { transmissivity: t, refraction_index } = &mut material.kind {
            let corrected = t.map(|t| transmissivity(t, *refraction_index));
            example.get_or_insert_with(|| {
                (material.name.clone(), luminous(*t), luminous(glass_pane(*t, *refraction_index, 1.0).0), luminous(corrected))
            });
            *t = corrected;
        }
    }
    let (name, given, passes, corrected) = example?;
    let meant = of_shade(&other, window);
    ((meant.value - bsdf).abs() <= AGREES * bsdf + 2.0 * meant.error).then(|| {
        format!(
            "Radiance's glass takes transmissivity, not transmittance: '{name}' of {given:.3} passes {passes:.3}; with {corrected:.3} in its \
             place, which passes {given:.3}, the shade agrees with the BSDF"
        )
    })
}

fn of_shade(shade: &Scene, window: &Window) -> Transmittance {
    let Some(walker) = Walker::new(shade, window) else { return Transmittance { value: 1.0, error: 0.0 } };
    let each = RAYS / GROUPS;
    let groups: Vec<f64> = (0..GROUPS)
        .into_par_iter()
        .map(|group| {
            let mut random = Random(group as u64);
            (0..each).map(|_| walker.passed(&mut random)).sum::<f64>() / each as f64
        })
        .collect();
    let variance = crate::statistics::variance_of_mean(groups.iter().copied());
    Transmittance { value: groups.iter().sum::<f64>() / GROUPS as f64, error: variance.sqrt() }
}

struct Walker<'a> {
    shade: &'a Scene,
    caster: Caster,
    window: &'a Window,
    bin: usize,
    /// How far before the window everything of the shade lies.
    before: f64,
}

impl<'a> Walker<'a> {
    fn new(shade: &'a Scene, window: &'a Window) -> Option<Self> {
        let caster = Caster::new(shade.triangles.iter().map(|t| t.vertices).collect())?;
        let z = |p: &DVec3| window.frame.to_local(*p).z;
        let plane = window.triangles.iter().flatten().map(z).fold(f64::NEG_INFINITY, f64::max);
        let outermost = shade.triangles.iter().flat_map(|t| &t.vertices).map(z).fold(f64::INFINITY, f64::min);
        Some(Self { shade, caster, window, bin: central_bin(window), before: (plane - outermost).max(0.0) + 1e-3 * window.area().sqrt() })
    }

    /// The share of a ray of the central bin that leaves to the room.
    fn passed(&self, random: &mut Random) -> f64 {
        let frame = &self.window.frame;
        let mut direction = frame.to_world(self.window.basis.direction(self.bin, random.next(), random.next()));
        let mut origin = random.point_on(&self.window.triangles) - direction * (self.before / direction.dot(frame.z));
        let mut weight = [1.0; 3];
        for _ in 0..MOST_MEETINGS {
            let Some((distance, number)) = self.caster.nearest(origin, direction, 1e-6 * self.before.max(1e-3)) else {
                return if direction.dot(frame.z) > 0.0 { luminous(weight) } else { 0.0 };
            };
            origin += distance * direction;
            let triangle = &self.shade.triangles[number];
            let [a, b, c] = triangle.vertices;
            let normal = (b - a).cross(c - a).normalize_or(frame.z);
            let Some((next, factor)) = scatter(&self.shade.materials[triangle.material.0 as usize].kind, direction, normal, random) else {
                return 0.0;
            };
            direction = next;
            (0..3).for_each(|c| weight[c] *= factor[c]);
            if luminous(weight) < LEAST_WEIGHT {
                return 0.0;
            }
        }
        0.0
    }
}

/// One lobe of a material at random, with the weight that makes up for the choice.
fn scatter(material: &MaterialKind, incoming: DVec3, normal: DVec3, random: &mut Random) -> Option<(DVec3, [f64; 3])> {
    let front = incoming.dot(normal) < 0.0;
    let facing = if front { normal } else { -normal };
    let cosine = -incoming.dot(facing);
    let mirrored = incoming + facing * (2.0 * cosine);
    let times = |c: [f64; 3], f: f64| c.map(|v| v * f);
    // Diffusely reflected and transmitted, mirrored, straight through.
    let lobes = match *material {
        MaterialKind::Mirror { color } if front => [[0.0; 3], [0.0; 3], color, [0.0; 3]],
        MaterialKind::Glass { transmissivity, refraction_index } => {
            let (t, r) = glass_pane(transmissivity, refraction_index, cosine);
            [[0.0; 3], [0.0; 3], r, t]
        }
        MaterialKind::Void => [[0.0; 3], [0.0; 3], [0.0; 3], [1.0; 3]],
        _ => {
            let l = material.lobes()?;
            [l.diffuse, l.diffuse_transmitted, l.specular, l.specular_transmitted]
        }
    };
    let total: f64 = lobes.iter().map(|l| luminous(*l)).sum();
    let mut pick = random.next() * total;
    let chosen = lobes.iter().position(|l| {
        let mine = pick < luminous(*l);
        pick -= luminous(*l);
        mine
    })?;
    let weight = times(lobes[chosen], total / luminous(lobes[chosen]));
    let direction = match chosen {
        0 => random.cosine_direction(facing),
        1 => random.cosine_direction(-facing),
        2 => mirrored,
        _ => incoming,
    };
    Some((direction, weight))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::kernels::trace::rooms::{Builder, window};

    fn opening() -> Window {
        let corners = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 0.0, 0.0]];
        window(corners, DVec3::Y, DVec3::Z, KlemsBasis::Full)
    }

    fn pane(transmissivity: f64) -> MaterialKind {
        MaterialKind::Glass { transmissivity: [transmissivity; 3], refraction_index: 1.52 }
    }

    /// Panes larger than the opening, one behind the other.
    fn panes(kinds: &[MaterialKind]) -> Scene {
        let mut b = Builder::default();
        for (i, kind) in kinds.iter().enumerate() {
            let y = -0.1 - 0.02 * i as f64;
            let material = b.material(*kind);
            b.quad([[-1.0, y, -1.0], [3.0, y, -1.0], [3.0, y, 2.0], [-1.0, y, 2.0]], material);
        }
        b.scene
    }

    fn close(found: Transmittance, wanted: f64) {
        assert!((found.value - wanted).abs() < 4.0 * found.error + 1e-4 * wanted, "{found:?} {wanted}");
        assert!(found.error < 0.012, "{found:?}");
    }

    #[test]
    fn panes_and_slats_pass_what_formulas_say() {
        // Within 5° of the normal Fresnel's values are those at the normal to 1e-5.
        let (t, r) = glass_pane([0.88; 3], 1.52, 1.0);
        close(of_shade(&panes(&[pane(0.88)]), &opening()), t[0]);
        close(of_shade(&panes(&[pane(0.88), pane(0.88)]), &opening()), t[0] * t[0] / (1.0 - r[0] * r[0]));
        let trans =
            MaterialKind::Trans { color: [0.8; 3], specularity: 0.05, roughness: 0.0, transmissivity: 0.5, transmitted_specularity: 0.2 };
        close(of_shade(&panes(&[trans]), &opening()), 0.8 * 0.5 * 0.95);
        // Black slats over the lower quarter.
        let mut b = Builder::default();
        let black = b.grey(0.0);
        b.quad([[-1.0, -0.1, -1.0], [3.0, -0.1, -1.0], [3.0, -0.1, 0.25], [-1.0, -0.1, 0.25]], black);
        close(of_shade(&b.scene, &opening()), 0.75);
        assert_eq!(of_shade(&Scene::default(), &opening()).value, 1.0);
    }

    #[test]
    fn three_percent_and_the_noise_are_allowed() {
        let sharp = |value, error| Transmittance { value, error };
        assert!(!differs(sharp(0.514, 0.0), 0.5) && differs(sharp(0.516, 0.0), 0.5) && differs(sharp(0.484, 0.0), 0.5));
        assert!(!differs(sharp(0.53, 0.006), 0.5) && differs(sharp(0.54, 0.006), 0.5));
    }

    #[test]
    fn transmittance_given_as_transmissivity_is_told_from_a_wrong_pane() {
        // A double pane of 0.88 each in the BSDF, and 0.88 written into both of the shade's panes.
        let (t, r) = glass_pane([transmissivity(0.88, 1.52); 3], 1.52, 1.0);
        let bsdf = t[0] * t[0] / (1.0 - r[0] * r[0]);
        let shade = panes(&[pane(0.88), pane(0.88)]);
        assert!(differs(of_shade(&shade, &opening()), bsdf));
        let said = meant_transmittance(&shade, &opening(), bsdf).expect("0.88 is a transmittance");
        assert!(said.contains("of 0.880 passes 0.808") && said.contains("0.958"), "{said}");
        assert_eq!(meant_transmittance(&shade, &opening(), 0.5), None, "another pane altogether");
        assert_eq!(meant_transmittance(&panes(&[MaterialKind::Void]), &opening(), 0.5), None, "no glass");
    }
}
