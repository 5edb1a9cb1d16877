//! Sensors that no light can reach: inside walls, shafts, closed boxes, or outside the room.
//!
//! Before any tracing random walks from each sensor look for a window, through panes and off every surface
//! that reflects at all. That finds closed spaces; what V then says decides.

use super::{Inputs, SensorGroup};
use crate::bvh::Caster;
use crate::error::{Error, Warnings};
use crate::matrix::Matrix;
use crate::random::Random;
use crate::scene::points::Sensor;
use crate::scene::{MaterialKind, Scene, Window};
use glam::DVec3;
use rayon::prelude::*;

/// Walks from a sensor, at most, and reflections of each.
const WALKS: usize = 256;
const STEPS: usize = 32;
/// Surfaces nearer to a window than this part of its size do not hide it: how such are treated is not
/// a matter of walks.
const NEAR_WINDOW: f64 = 0.02;
/// Light far below any that could matter, relative to the brightest sensor; exact zeros are not certain.
const NOTHING: f64 = 1e-9;
/// Sensors that a message names.
const NAMED: usize = 8;

/// Where light comes from.
#[derive(Clone, Copy)]
pub(crate) enum Light<'a> {
    /// From these windows alone.
    Windows(&'a [Window]),
    /// From wherever the scene leaves the sky free; windows are clear.
    Sky,
}

/// Of all sensors, whether no walk finds light.
pub(crate) fn seem_dark(scene: &Scene, light: Light<'_>, sensors: &[Sensor]) -> Vec<bool> {
    let walker = Walker::new(scene, light);
    sensors.par_iter().enumerate().map(|(i, s)| !(0..WALKS).any(|w| walker.finds_window(s, (i * WALKS + w) as u64))).collect()
}

/// Of all sensors, whether they are in a closed space: few walks or none find light. One walk in thousands slips
/// through an edge where surfaces meet, so that where some do, many more are asked.
pub(crate) fn are_enclosed(scene: &Scene, light: Light<'_>, sensors: &[Sensor]) -> Vec<bool> {
    const SLIPS: usize = 2;
    const MORE: usize = 16;
    let walker = Walker::new(scene, light);
    let found = |i: usize, s: &Sensor, walks: usize| (0..walks).filter(|w| walker.finds_window(s, (i * MORE * WALKS + w) as u64)).count();
    sensors.par_iter().enumerate().map(|(i, s)| found(i, s, WALKS) <= SLIPS && found(i, s, MORE * WALKS) <= MORE * SLIPS).collect()
}

struct Walker {
    solid: Option<Caster>,
    kinds: Vec<MaterialKind>,
    front: Vec<DVec3>,
    windows: Option<Caster>,
    /// Whether what meets nothing is light.
    sky: bool,
    /// Normal and size, per triangle of the windows.
    normals: Vec<(DVec3, f64)>,
}

impl Walker {
    fn new(scene: &Scene, light: Light<'_>) -> Self {
        let windows = if let Light::Windows(windows) = light { windows } else { &[] };
        let solid: Vec<_> = scene.triangles.iter().filter(|t| scene.materials[t.material.0 as usize].kind != MaterialKind::Void).collect();
        let panes: Vec<_> = windows.iter().flat_map(|w| w.triangles.iter().map(move |t| (*t, w))).collect();
        Self {
            kinds: solid.iter().map(|t| scene.materials[t.material.0 as usize].kind).collect(),
            solid: Caster::new(solid.iter().map(|t| t.vertices).collect()),
            sky: matches!(light, Light::Sky),
            windows: Caster::new(panes.iter().map(|(t, _)| *t).collect()),
            normals: panes.iter().map(|(_, w)| (w.frame.z, w.area().sqrt())).collect(),
            front: solid.iter().map(|t| t.normal()).collect(),
        }
    }

    fn finds_window(&self, sensor: &Sensor, seed: u64) -> bool {
        let mut random = Random(seed);
        let mut origin = sensor.position;
        let mut direction = random.cosine_direction(sensor.direction.normalize_or(DVec3::Z));
        for _ in 0..STEPS {
            let met = self.solid.as_ref().and_then(|s| s.nearest(origin, direction, 1e-6));
            if let Some((distance, number)) = self.windows.as_ref().and_then(|w| w.nearest(origin, direction, 0.0)) {
                let (normal, size) = self.normals[number];
                if met.is_none_or(|(d, _)| distance <= d + NEAR_WINDOW * size) {
                    // From outside a window is a wall.
                    return direction.dot(normal) < 0.0;
                }
            }
            let Some((distance, number)) = met else { return self.sky };
            let outward = self.front[number];
            let facing = if direction.dot(outward) < 0.0 { outward } else { -outward };
            let mirrored = direction - 2.0 * direction.dot(facing) * facing;
            let lit = |c: [f64; 3]| c.iter().any(|v| *v > 0.0);
            let next = match self.kinds[number] {
                MaterialKind::Plastic { color, specularity, .. } if lit(color) || specularity > 0.0 => random.cosine_direction(facing),
                MaterialKind::Metal { color, .. } if lit(color) => random.cosine_direction(facing),
                MaterialKind::Trans { color, .. } if lit(color) => {
                    let side = if random.next() < 0.5 { facing } else { -facing };
                    random.cosine_direction(side)
                }
                MaterialKind::Lobes(l) => {
                    let chances =
                        [l.diffuse, l.diffuse_transmitted, l.specular, l.specular_transmitted].map(|c| if lit(c) { 1.0 } else { 0.0 });
                    let mut pick = random.next() * chances.iter().sum::<f64>();
                    let chosen = chances.iter().position(|c| {
                        pick -= c;
                        pick < 0.0
                    });
                    match chosen {
                        Some(0) => random.cosine_direction(facing),
                        Some(1) => random.cosine_direction(-facing),
                        Some(2) => mirrored,
                        Some(_) => direction,
                        None => return false,
                    }
                }
                MaterialKind::Glass { .. } => {
                    if random.next() < 0.75 {
                        direction
                    } else {
                        mirrored
                    }
                }
                MaterialKind::Mirror { .. } if direction.dot(outward) < 0.0 => mirrored,
                _ => return false,
            };
            origin += distance * direction;
            direction = next;
        }
        false
    }
}

/// Sensors whose row of V is nothing beside the brightest; nothing at all if all rows are.
pub(crate) fn dark_rows(view: &Matrix<f32>) -> Option<Vec<bool>> {
    let sums: Vec<f64> = (0..view.rows()).map(|row| view.row(row).iter().map(|&v| f64::from(v)).sum()).collect();
    let most = sums.iter().copied().fold(0.0, f64::max);
    (most > 0.0 || sums.is_empty()).then(|| sums.iter().map(|s| *s <= NOTHING * most).collect())
}

/// Names dark sensors, a warning per group. The same sensors give the same text, which is kept once.
pub(crate) fn warn(groups: &[SensorGroup], dark: &[bool], direct: bool, warnings: &mut Warnings) {
    let mut first = 0;
    for group in groups {
        let own = &dark[first..first + group.sensors.len()];
        first += own.len();
        let which: Vec<usize> = (0..own.len()).filter(|i| own[*i]).collect();
        let Some(&one) = which.first() else { continue };
        let name = |i: &usize| {
            let p = group.sensors[*i].position;
            format!("{} (at {} {} {})", i + 1, p.x, p.y, p.z)
        };
        let names: Vec<String> = which.iter().take(NAMED).map(name).collect();
        let more = if which.len() > NAMED { format!(" and {} more", which.len() - NAMED) } else { String::new() };
        let count = format!("{} of {} sensors of '{}'", which.len(), own.len(), group.name);
        warnings.push(
            Error::new(format!("no light {} is found to reach {count}, which count with 0 lx: {}{more}", source(direct), names.join(", ")))
                .file(&group.file)
                .line(group.sensors[one].line)
                .help("are they inside a wall or a piece of furniture, or in a room without a window? Move them or take them out"),
        );
    }
}

fn source(direct: bool) -> &'static str {
    if direct { "of the sky" } else { "of any window" }
}

/// Compares what the walks found with the coefficients of the sensors: V, or C. Returns the dark sensors.
///
/// # Errors
/// If no light reaches any sensor.
pub(crate) fn check(inputs: &Inputs, view: &Matrix<f32>, direct: bool, warnings: &mut Warnings) -> Result<Vec<bool>, Error> {
    let Some(dark) = dark_rows(view) else {
        let group = &inputs.sensors[0];
        let help = if inputs.windows.is_empty() {
            "there is no [[window]], and the scene lets no light in: add one with name, surface and glass = 0.65"
        } else {
            "are the sensors inside a wall, or in a room without a window? Do the windows' normals point into the room?"
        };
        return Err(Error::new(format!("no light {} reaches any sensor", source(direct)))
            .file(&group.file)
            .line(group.sensors.first().map_or(1, |s| s.line))
            .help(help));
    };
    warn(&inputs.sensors, &dark, direct, warnings);
    let brightened = inputs.seem_dark.iter().zip(&dark).filter(|(seemed, dark)| **seemed && !**dark).count();
    if brightened > 0 {
        warnings.push(Error::new(format!(
            "light does reach {brightened} of the sensors that seemed dark before tracing: their results are what was traced"
        )));
    }
    Ok(dark)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::kernels::trace::rooms::{Builder, window};

    fn group(points: &[[f64; 3]]) -> SensorGroup {
        let sensors = points.iter().enumerate().map(|(i, p)| Sensor { position: DVec3::from_array(*p), direction: DVec3::Z, line: i + 1 });
        SensorGroup { name: "grid".into(), file: "grid.txt".into(), sensors: sensors.collect(), view: None, sun: None }
    }

    /// A room of 4 m × 4 m × 3 m with a window in its south wall, and a closed box in it.
    fn room(wall: MaterialKind, inner: MaterialKind) -> (Scene, Window) {
        let mut b = Builder::default();
        let wall = b.material(wall);
        b.room([0.0, 0.0, 0.0], [4.0, 4.0, 3.0], wall, &[]);
        let inner = b.material(inner);
        b.room([2.5, 2.5, 0.0], [3.5, 3.5, 1.5], inner, &[]);
        // In the plane of the uncut wall: how that is treated does not concern sensors.
        let corners = [[1.5, 0.0, 1.0], [1.5, 0.0, 2.0], [2.5, 0.0, 2.0], [2.5, 0.0, 1.0]];
        (b.scene, window(corners, DVec3::Y, DVec3::Z, KlemsBasis::Full))
    }

    #[test]
    fn closed_spaces_are_found_before_tracing() {
        let points = [[1.0, 1.0, 0.8], [3.0, 3.0, 0.8], [3.0, 3.0, 2.0], [9.0, 9.0, 0.8], [2.0, -1.0, 0.8]];
        let grey = |reflectance: f64| MaterialKind::Plastic { color: [reflectance; 3], specularity: 0.0, roughness: 0.0 };
        let (scene, window) = room(grey(0.5), grey(0.5));
        let seen = seem_dark(&scene, Light::Windows(std::slice::from_ref(&window)), &group(&points).sensors);
        assert_eq!(seen, [false, true, false, true, true]);
        // Light enters a box of glass or of frosted glass.
        let glass = MaterialKind::Glass { transmissivity: [0.9; 3], refraction_index: 1.52 };
        let trans =
            MaterialKind::Trans { color: [0.5; 3], specularity: 0.0, roughness: 0.0, transmissivity: 0.5, transmitted_specularity: 0.0 };
        for kind in [glass, trans] {
            let (scene, window) = room(grey(0.5), kind);
            assert_eq!(seem_dark(&scene, Light::Windows(&[window]), &group(&points[..3]).sensors), [false; 3]);
        }
        // A window is seen even if nothing reflects.
        let (scene, window) = room(grey(0.0), grey(0.0));
        assert_eq!(seem_dark(&scene, Light::Windows(&[window]), &group(&[[2.0, 2.0, 0.8], [3.0, 3.0, 0.8]]).sensors), [false, true]);
    }

    #[test]
    fn rows_without_light_are_dark_unless_all_are() {
        let of = |rows: &[f32]| dark_rows(&Matrix::from_data(rows.len(), 1, 1, rows.to_vec()).unwrap());
        assert_eq!(of(&[1.0, 0.0, 1e-12, 1e-3]), Some(vec![false, true, true, false]));
        assert_eq!((of(&[0.0, 0.0]), of(&[])), (None, Some(vec![])));
    }

    #[test]
    fn many_dark_sensors_make_one_line() {
        let points: Vec<[f64; 3]> = (0..20).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let mut warnings = Warnings::new();
        let dark: Vec<bool> = (0..20).map(|i| i > 2).collect();
        warn(&[group(&points)], &dark, false, &mut warnings);
        warn(&[group(&points)], &dark, false, &mut warnings);
        let all: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(all.len(), 1);
        assert!(all[0].starts_with("grid.txt:4: ") && all[0].contains("17 of 20 sensors of 'grid'"), "{}", all[0]);
        assert!(all[0].contains("4 (at 3 0 0), 5 (at 4 0 0)") && all[0].contains("and 9 more"), "{}", all[0]);
    }
}
