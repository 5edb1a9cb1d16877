//! Smooth surfaces in which no rays are aimed at windows' images: curved ones, and those of many planes.

use crate::error::{Error, Warnings};
use crate::kernels::trace::planes::{self, MOST_PLANES};
use crate::scene::{Scene, Window};
use std::collections::BTreeMap;

/// Warns of smooth surfaces in which images of the windows are left to chance, once for each of their materials.
pub fn warn(scene: &Scene, windows: &[Window], warnings: &mut Warnings) {
    let mut of_material = BTreeMap::<u32, Vec<usize>>::new();
    for i in planes::left_out(scene, windows) {
        of_material.entry(scene.triangles[i].material.0).or_default().push(i);
    }
    for (material, triangles) in of_material {
        let name = &scene.materials[material as usize].name;
        let mut warning = Error::new(format!(
            "smooth surfaces lie in more than {MOST_PLANES} planes: in {} triangles of material '{name}' no rays are aimed at the windows' images",
            triangles.len()
        ))
        .help(
            "what they reflect is found by chance, and its error is stated: if it matters, ask for a smaller target_error; \
             if not, make them rough, or leave their specularity out",
        );
        if let Some(surface) = scene.surfaces.get(scene.triangles[triangles[0]].surface as usize) {
            warning = warning.file(&surface.file).line(surface.line);
        }
        warnings.push(warning);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::rooms::{Builder, asymmetric};
    use crate::scene::MaterialKind;

    #[test]
    fn a_ball_of_smooth_metal_is_warned_of_and_a_box_of_it_is_not() {
        let (scene, window) = asymmetric();
        let warned = |kind: MaterialKind, facets: u32| {
            let mut b = Builder { scene: scene.clone() };
            let material = b.material(kind);
            for i in 0..facets {
                let (x, tilt) = (f64::from(i) * 0.01, f64::from(i) * 0.02);
                b.quad([[x, 3.0, 1.0], [x + 0.01, 3.0, 1.0 + tilt], [x + 0.01, 3.1, 1.0 + tilt], [x, 3.1, 1.0]], material);
            }
            let mut warnings = Warnings::new();
            warn(&b.scene, std::slice::from_ref(&window), &mut warnings);
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let metal = |roughness: f64| MaterialKind::Metal { color: [0.7; 3], specularity: 0.9, roughness };
        let found = warned(metal(0.0), 100);
        // Of two triangles each, 64 have rays.
        assert!(found.len() == 1 && found[0].contains("72 triangles of material 'm3'"), "{found:?}");
        assert!(warned(metal(0.0), MOST_PLANES as u32).is_empty());
        assert!(warned(metal(0.1), 100).is_empty() && warned(MaterialKind::Void, 100).is_empty());
    }
}
