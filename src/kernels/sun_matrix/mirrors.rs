//! Images of the sun in flat mirror-like surfaces.
//!
//! A mirror of unit normal n shows a sun of direction d in the direction d − 2(d·n)n, of the same size
//! and radiance but for its reflectance. Two mirrors show each other's images, and so on; parallel ones
//! show no more than the first and, after an even number of reflections, the sun's own direction. So
//! all that flat mirrors of a few orientations do follows from a few matrices, one for each image. The
//! light of an image is looked for where the image stands and counts if the mirrors met on the way are
//! those that make it (`sun_matrix/mirrored`): reflections keep solid angles, so an image counts as a sun
//! does, and nothing is found twice, for each way of the light belongs to one image.

use crate::kernels::trace::SMOOTH_ROUGHNESS2;
use crate::scene::{Material, MaterialKind, Scene};
use glam::{DMat3, DVec3};

/// Orientations that are looked at, at most.
const MOST_ORIENTATIONS: usize = 512;
/// Images traced at most.
const MOST_IMAGES: usize = 48;
/// Reflections of one image at most.
const MOST_REFLECTIONS: usize = 8;
/// Mirrors within this angle are taken for parallel, radians. (The sun's disc is 9.3e-3 wide.)
const PARALLEL: f64 = 4e-4;
/// Mirrors of different orientation must be this far apart, radians, or their images would be mixed up.
const APART: f64 = 2.5e-3;
/// Reflectances below this are of no consequence.
pub(crate) const LITTLE: f64 = 0.02;

/// The images, and what part of the mirrors makes none.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Mirrors {
    /// Each takes the direction to a sun to that of its image.
    pub images: Vec<DMat3>,
    /// All images of up to so many reflections are there; `None`: those of any number.
    pub complete: Option<usize>,
    /// Share of the mirrors' area that is curved too finely for images, or one orientation too many.
    pub left_out: f64,
}

/// Whether a material throws sunlight as a mirror does. Panes, and what else lets light
/// through directly, are not among them, as they are not in Radiance's direct calculation.
pub(crate) fn is_mirror(material: &Material) -> bool {
    match material.kind {
        MaterialKind::Mirror { color } => color.iter().any(|c| *c > LITTLE),
        // What lets light through directly is none.
        kind => kind.lobes().is_some_and(|l| {
            l.roughness * l.roughness <= SMOOTH_ROUGHNESS2
                && l.specular_transmitted == [0.0; 3]
                && l.specular.iter().any(|s| *s > LITTLE)
                && !matches!(kind, MaterialKind::Trans { .. })
        }),
    }
}

impl Mirrors {
    /// Images of the mirrors of a scene.
    pub fn of(scene: &Scene) -> Self {
        let mirror: Vec<bool> = scene.materials.iter().map(is_mirror).collect();
        // Orientations and the area of each.
        let mut found: Vec<(DVec3, f64)> = Vec::new();
        for t in scene.triangles.iter().filter(|t| mirror[t.material.0 as usize]) {
            let [a, b, c] = t.vertices;
            let across = (b - a).cross(c - a);
            let Some(normal) = across.try_normalize() else { continue };
            let area = across.length() / 2.0;
            if let Some((_, sum)) = found.iter_mut().find(|(n, _)| n.cross(normal).length() < PARALLEL) {
                *sum += area;
            } else if found.len() == MOST_ORIENTATIONS {
                // Too many to compare them all: something curved.
                return Self { left_out: 1.0, ..Self::default() };
            } else {
                found.push((normal, area));
            }
        }
        let whole: f64 = found.iter().map(|(_, area)| area).sum();
        if whole <= 0.0 {
            return Self::default();
        }
        let close = |i: usize| found.iter().enumerate().any(|(j, (n, _))| j != i && n.cross(found[i].0).length() < APART);
        let mut orientations: Vec<(DVec3, f64)> = (0..found.len()).filter(|&i| !close(i)).map(|i| found[i]).collect();
        orientations.sort_by(|a, b| b.1.total_cmp(&a.1));
        orientations.truncate(MOST_IMAGES);
        let kept: f64 = orientations.iter().map(|(_, area)| area).sum();
        let reflections: Vec<DMat3> = orientations.iter().map(|(n, _)| reflection(*n)).collect();
        let (images, complete) = images(&reflections);
        Self { images, complete, left_out: (1.0 - kept / whole).max(0.0) }
    }
}

/// The matrix that reflects at a plane of this unit normal.
pub fn reflection(normal: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    DMat3::IDENTITY - outer * 2.0
}

/// Products of one, two … reflections, each matrix once.
fn images(reflections: &[DMat3]) -> (Vec<DMat3>, Option<usize>) {
    let same = |a: &DMat3, b: &DMat3| (*a - *b).to_cols_array().iter().all(|v| v.abs() < 1e-3);
    let mut all: Vec<DMat3> = Vec::new();
    let mut last = vec![DMat3::IDENTITY];
    for level in 0..MOST_REFLECTIONS {
        let mut next: Vec<DMat3> = Vec::new();
        for (image, reflection) in last.iter().flat_map(|i| reflections.iter().map(move |r| (i, r))) {
            // Seen from the receiver: the mirror met first acts last.
            let new = *reflection * *image;
            if !all.iter().chain(&next).any(|known| same(known, &new)) {
                next.push(new);
            }
        }
        if next.is_empty() {
            return (all, None);
        }
        if all.len() + next.len() > MOST_IMAGES && level > 0 {
            return (all, Some(level));
        }
        all.extend(&next);
        last = next;
    }
    (all, Some(MOST_REFLECTIONS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::rooms::Builder;

    fn slats(tilts: &[f64]) -> Mirrors {
        let mut b = Builder::default();
        let mirror = b.material(MaterialKind::Mirror { color: [0.9; 3] });
        let grey = b.grey(0.5);
        for (i, tilt) in tilts.iter().enumerate() {
            let (z, y) = (i as f64, tilt.to_radians().cos());
            let rise = tilt.to_radians().sin();
            b.quad([[0.0, 0.0, z], [1.0, 0.0, z], [1.0, y, z + rise], [0.0, y, z + rise]], mirror);
        }
        b.quad([[0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [1.0, 1.0, 9.3], [0.0, 1.0, 9.3]], grey);
        Mirrors::of(&b.scene)
    }

    #[test]
    fn parallel_slats_have_two_images_and_those_of_two_tilts_the_rest() {
        assert_eq!(slats(&[]), Mirrors::default());
        let flat = slats(&[30.0, 30.0, 30.01]);
        assert_eq!((flat.images.len(), flat.complete, flat.left_out), (2, None, 0.0));
        // One reflection, and two that undo each other.
        let d = DVec3::new(0.3, -0.8, 0.52);
        let n = DVec3::new(0.0, -0.5, 0.75f64.sqrt());
        assert!((flat.images[0] * d - (d - 2.0 * d.dot(n) * n)).length() < 1e-3);
        assert!((flat.images[1] * d - d).length() < 1e-3);
        // Perpendicular mirrors: x, y, both (a half turn), none.
        assert_eq!((slats(&[0.0, 90.0]).images.len(), slats(&[0.0, 90.0]).complete), (4, None));
        // At 60° the images close too: a kaleidoscope of six.
        assert_eq!((slats(&[10.0, 70.0]).images.len(), slats(&[10.0, 70.0]).complete), (6, None));
        // At other angles they never do.
        let two = slats(&[0.0, 50.3]);
        assert!(two.complete.is_some_and(|n| n >= 4) && two.images.len() <= MOST_IMAGES, "{} {:?}", two.images.len(), two.complete);
        assert!(two.images.iter().all(|m| (m.determinant().abs() - 1.0).abs() < 1e-9));
    }

    #[test]
    fn finely_curved_mirrors_are_said_to_be_left_out() {
        let curved = slats(&(0..40).map(|i| 0.08 * f64::from(i)).collect::<Vec<_>>());
        assert!(curved.left_out > 0.99 && curved.images.is_empty(), "{curved:?}");
        let facets = slats(&(0..10).map(|i| 4.0 * f64::from(i)).collect::<Vec<_>>());
        assert_eq!(facets.left_out, 0.0);
        assert!(facets.images.len() >= 10 && facets.complete.is_some(), "{facets:?}");
    }
}
