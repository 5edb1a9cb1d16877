//! What is seen through the windows, and when the sun stands in them: geometry alone, without blinds.

use super::Inputs;
use crate::bvh::Caster;
use crate::metrics::view_out::{Layers, ViewOut};
use crate::scene::{MaterialKind, Window};
use crate::weather::Weather;
use crate::weather::sun::position;
use glam::DVec3;
use rayon::prelude::*;

/// Of rays from an eye, degrees: between those of neighbouring azimuths and of neighbouring altitudes, and the steepest.
const AZIMUTH_STEP: f64 = 0.5;
const ALTITUDE_STEP: f64 = 2.0;
const STEEPEST: f64 = 60.0;
/// What leaves the model less than this below the horizon is landscape far away, degrees; farther below it is ground.
const LANDSCAPE_DEG: f64 = 5.0;
/// What stands nearer to a window than this is no layer of the view, m: parts of the building itself, or a wall.
const NO_LAYER: f64 = 6.0;
/// Surfaces that are steeper than this are no ground: cosine.
const LEVEL_GROUND: f64 = 0.9;
/// EN 17037, height of the eyes of people who sit, and of the reference point of sunlight above the floor and above the
/// sill, m.
pub(crate) const EYE_HEIGHT: f64 = 1.2;
const ABOVE_SILL: f64 = 0.3;
/// Nearer surfaces belong to the window, relative to its size: its frame in the same plane.
const AT_WINDOW: f64 = 1e-4;
/// Minutes of a day.
const MINUTES: usize = 24 * 60;

/// What rays from inside and out meet.
pub(crate) struct Outlook<'a> {
    solid: Option<Caster>,
    /// Whether each surface is level.
    level: Vec<bool>,
    openings: Caster,
    /// Which window each triangle of the openings is of.
    window_of: Vec<usize>,
    windows: Vec<(&'a Window, bool)>,
}

/// What an eye sees, and through which windows.
pub(crate) struct Seen {
    /// As the standard counts it.
    pub view: ViewOut,
    /// Whether it sees out by each window, blurred or not.
    pub windows: Vec<bool>,
}

/// Where a ray ends that has left by a window.
enum Meets {
    Sky,
    Landscape,
    Ground,
    Obstacle,
}

impl<'a> Outlook<'a> {
    /// Nothing without windows. Panes of the scene are clear; blinds are not there.
    pub(crate) fn new(inputs: &'a Inputs) -> Option<Self> {
        let scene = &inputs.scene;
        let kind = |t: &&crate::scene::Triangle| scene.materials[t.material.0 as usize].kind;
        let solid: Vec<_> =
            scene.triangles.iter().filter(|t| !matches!(kind(t), MaterialKind::Void | MaterialKind::Glass { .. })).collect();
        let windows: Vec<(&Window, bool)> =
            inputs.windows.iter().enumerate().map(|(i, w)| (&w.window, inputs.is_seen_through(i))).collect();
        Some(Self {
            level: solid.iter().map(|t| t.normal().z.abs() > LEVEL_GROUND).collect(),
            solid: Caster::new(solid.iter().map(|t| t.vertices).collect()),
            openings: Caster::new(windows.iter().flat_map(|(w, _)| w.triangles.clone()).collect())?,
            window_of: windows.iter().enumerate().flat_map(|(i, (w, _))| vec![i; w.triangles.len()]).collect(),
            windows,
        })
    }

    fn met(&self, origin: DVec3, direction: DVec3, least: f64) -> Option<(f64, usize)> {
        self.solid.as_ref().and_then(|s| s.nearest(origin, direction, least))
    }

    /// Height of what is below a point.
    pub(crate) fn floor_below(&self, point: DVec3) -> Option<f64> {
        // Sensors of grids stand above the middle of rooms, where the edges of the floor's triangles are: a millimetre beside.
        self.met(point + DVec3::new(0.37e-3, 0.61e-3, 0.0), -DVec3::Z, 1e-6).map(|(d, _)| point.z - d)
    }

    /// The window by which a ray leaves the room, and its distance.
    fn leaves(&self, eye: DVec3, direction: DVec3) -> Option<(usize, f64)> {
        let (distance, triangle) = self.openings.nearest(eye, direction, 0.0)?;
        let window = self.window_of[triangle];
        let (w, _) = self.windows[window];
        let inside = direction.dot(w.frame.z) < 0.0;
        let hidden = || self.met(eye, direction, 1e-6).is_some_and(|(d, _)| d < distance - AT_WINDOW * w.area().sqrt());
        (inside && !hidden()).then_some((window, distance))
    }

    /// What a ray meets behind a window at a point, and how far from there, square to the window.
    fn beyond(&self, window: usize, point: DVec3, direction: DVec3, altitude_deg: f64) -> (Meets, f64) {
        let w = self.windows[window].0;
        let least = AT_WINDOW * w.area().sqrt();
        let solid = self.met(point, direction, least);
        let square = |d: f64| -d * direction.dot(w.frame.z);
        let built = |d: f64| (if square(d) < NO_LAYER { Meets::Obstacle } else { Meets::Landscape }, square(d));
        // Windows of other rooms are walls from outside.
        let pane = self.openings.nearest(point, direction, least).filter(|(d, _)| solid.is_none_or(|(s, _)| *d < s));
        match (pane, solid) {
            (Some((d, _)), _) => built(d),
            (None, Some((d, number))) if self.level[number] && direction.z < 0.0 => (Meets::Ground, square(d)),
            (None, Some((d, _))) => built(d),
            (None, None) if altitude_deg > 0.0 => (Meets::Sky, f64::INFINITY),
            (None, None) if altitude_deg > -LANDSCAPE_DEG => (Meets::Landscape, f64::INFINITY),
            (None, None) => (Meets::Ground, f64::INFINITY),
        }
    }

    /// What an eye sees. The distance is the median over the azimuths in which it sees out, of each by the ray nearest to the
    /// horizon; ground does not stand opposite.
    pub(crate) fn seen_from(&self, eye: DVec3) -> Seen {
        let mut seen = Seen { view: ViewOut::default(), windows: vec![false; self.windows.len()] };
        let mut layers = vec![Layers::default(); self.windows.len()];
        let mut distances = Vec::new();
        let columns = (360.0 / AZIMUTH_STEP) as usize;
        let rows = (STEEPEST / ALTITUDE_STEP) as i32;
        for column in 0..columns {
            let (sin, cos) = ((column as f64 + 0.5) * AZIMUTH_STEP).to_radians().sin_cos();
            let mut nearest: Option<(i32, f64)> = None;
            for row in -rows..=rows {
                let altitude = f64::from(row) * ALTITUDE_STEP;
                let (up, along) = altitude.to_radians().sin_cos();
                let direction = DVec3::new(along * sin, along * cos, up);
                let Some((window, distance)) = self.leaves(eye, direction) else { continue };
                seen.windows[window] = true;
                if !self.windows[window].1 {
                    continue;
                }
                let (meets, beyond) = self.beyond(window, eye + distance * direction, direction, altitude);
                let opposite = if matches!(meets, Meets::Ground) { f64::INFINITY } else { beyond };
                match meets {
                    Meets::Sky => layers[window].sky = true,
                    Meets::Landscape => layers[window].landscape = true,
                    Meets::Ground => layers[window].ground = true,
                    Meets::Obstacle => {}
                }
                if nearest.is_none_or(|(other, _)| row.abs() < other.abs()) {
                    nearest = Some((row, opposite));
                }
            }
            distances.extend(nearest.map(|(_, d)| d));
        }
        distances.sort_by(f64::total_cmp);
        let best = layers.into_iter().max_by_key(|l| (l.level(), u8::from(l.sky) + u8::from(l.ground))).unwrap_or_default();
        seen.view = ViewOut {
            sight_deg: distances.len() as f64 * AZIMUTH_STEP,
            distance_m: distances.get(distances.len() / 2).copied().unwrap_or_default(),
            layers: best,
        };
        seen
    }

    /// EN 17037's reference point of a window: on its surface, in the middle of its width, 1.2 m above the floor and at least
    /// 0.3 m above the sill. Nothing if the window ends below; of a horizontal one its middle.
    fn reference_point(&self, window: usize, floor: f64) -> Option<DVec3> {
        let (w, _) = self.windows[window];
        let corners = || w.triangles.iter().flatten();
        if w.frame.z.z.abs() > LEVEL_GROUND {
            let area = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a).length();
            let middle: DVec3 = w.triangles.iter().map(|t| area(t) * (t[0] + t[1] + t[2]) / 3.0).sum();
            return Some(middle / w.triangles.iter().map(area).sum::<f64>());
        }
        let sill = corners().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let height = (floor + EYE_HEIGHT).max(sill + ABOVE_SILL);
        let across = DVec3::Z.cross(w.frame.z).normalize();
        // Where the triangles cross this height, along the width.
        let mut pieces: Vec<(f64, f64, DVec3, DVec3)> = w.triangles.iter().filter_map(|t| cut(t, height, across)).collect();
        pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut joined: Vec<(f64, f64, DVec3, DVec3)> = Vec::new();
        for piece in pieces {
            match joined.last_mut() {
                Some(last) if piece.0 <= last.1 + 1e-6 => {
                    if piece.1 > last.1 {
                        (last.1, last.3) = (piece.1, piece.3);
                    }
                }
                _ => joined.push(piece),
            }
        }
        let widest = joined.into_iter().max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
        Some((widest.2 + widest.3) / 2.0)
    }

    /// Minutes of a day in which the sun, at least `altitude` degrees high under a cloudless sky, stands in each window's
    /// reference point, `[window][minute]`; nothing for windows without one.
    pub(crate) fn minutes_of_sun(
        &self,
        weather: &Weather,
        day_of_year: u16,
        altitude: f64,
        floor: f64,
        windows: &[usize],
    ) -> Vec<Option<Vec<bool>>> {
        let sun = |minute: usize| {
            let hour = (minute as f64 + 0.5) / 60.0;
            let mut sun = position(weather.latitude, weather.longitude, weather.time_zone, day_of_year, hour);
            sun.azimuth -= weather.north.to_radians();
            (sun.altitude.to_degrees() >= altitude).then(|| sun.direction())
        };
        let of = |&window: &usize| {
            let point = self.reference_point(window, floor)?;
            let (w, _) = self.windows[window];
            let least = AT_WINDOW * w.area().sqrt();
            let free = |direction: DVec3| {
                direction.dot(w.frame.z) < 0.0
                    && self.met(point, direction, least).is_none()
                    && self.openings.nearest(point, direction, least).is_none()
            };
            Some((0..MINUTES).map(|m| sun(m).is_some_and(free)).collect())
        };
        windows.par_iter().map(of).collect()
    }
}

/// Where a triangle crosses a height: from and to along a direction, and these points.
fn cut(triangle: &[DVec3; 3], height: f64, across: DVec3) -> Option<(f64, f64, DVec3, DVec3)> {
    let mut points = Vec::new();
    for i in 0..3 {
        let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
        if (a.z - height) * (b.z - height) <= 0.0 && a.z != b.z {
            points.push(a + (b - a) * ((height - a.z) / (b.z - a.z)));
        }
    }
    let along = |p: &DVec3| p.dot(across);
    let low = points.iter().copied().min_by(|a, b| along(a).total_cmp(&along(b)))?;
    let high = points.iter().copied().max_by(|a, b| along(a).total_cmp(&along(b)))?;
    Some((along(&low), along(&high), low, high))
}

#[cfg(test)]
mod tests;
