//! Surfaces of a scene in the same place.

use crate::error::{Error, Warnings};
use crate::scene::{Scene, info};

/// Names surfaces of different materials with the same corners: which of them a ray meets is left to chance.
pub(super) fn warn(scene: &Scene, warnings: &mut Warnings) {
    if let (count, Some([first, second])) = info::contradictions(scene) {
        let more = if count > 1 { format!(" ({count} such pairs)") } else { String::new() };
        let text = format!(
            "surface '{}' has the same corners as '{}' ({}:{}), but another material: which of them counts is left to chance{more}",
            second.name,
            first.name,
            first.file.display(),
            first.line
        );
        let help = "remove one of them, or set them a little apart; lucarne scene info FILE counts them";
        warnings.push(Error::new(text).file(&second.file).line(second.line).help(help));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::rooms::Builder;
    use crate::scene::SurfaceOrigin;

    #[test]
    fn doubled_surfaces_of_other_materials_are_named_and_of_the_same_not() {
        let told = |second: f64| {
            let mut b = Builder::default();
            let (wall, other) = (b.grey(0.5), b.grey(second));
            let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            b.quad(corners, wall);
            let mut turned = corners;
            turned.reverse();
            b.quad(turned, other);
            // Beside it.
            b.quad(corners.map(|[x, y, z]| [x + 1.0, y, z]), other);
            for (i, t) in b.scene.triangles.iter_mut().enumerate() {
                t.surface = i as u32 / 2;
            }
            b.scene.surfaces = (0..3).map(|i| SurfaceOrigin { name: format!("s{i}"), file: "room.rad".into(), line: i }).collect();
            let mut warnings = Warnings::new();
            warn(&b.scene, &mut warnings);
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(told(0.5), Vec::<String>::new());
        let found = told(0.8);
        assert!(found.len() == 1 && found[0].contains("has the same corners") && found[0].contains("left to chance"), "{found:?}");
    }
}
