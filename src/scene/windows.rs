//! Windows: openings between inside and outside, and what light does at them.
//!
//! The same holds for the view matrix, the daylight matrix, the sun matrix and pictures:
//!
//! * **A window gives light to its room only through its own BSDF.** V ends at it, D begins at it.
//! * **All windows absorb** whatever else meets them, as if they were black and opaque: light from outside
//!   that meets another window (of another room, another wing, the other side of the same room) stays there,
//!   and so does light that the room, slats or an overhang send back to a window. Nothing passes through a
//!   building by its windows, and nothing is mirrored by a pane.
//! * **What lies in the plane of a window does not stand before it**: light passes the part of a wall, a
//!   pane or a frame that covers the window in its own plane (within a ten thousandth of the window's size,
//!   the root of its area). That part is cut out of the scene, and a warning names the surface. What lies
//!   farther before or behind the plane is met by light, be it a millimetre.
//! * **Windows do not cover each other.** Where surfaces of one window lie in the same place, the place counts
//!   once; where they lie behind each other by less than a tenth of the window's size, as the two faces of
//!   a pane, the one nearer to the room counts. A warning names both. Two windows that do so are refused.
//!
//! [`Scene::set_windows`](super::Scene::set_windows) sees to it. A scene that was not told of its windows has
//! holes where they are, but for those that a computation is asked for.

mod covering;
pub(crate) mod found;
mod openings;
mod panes;
pub(crate) mod parts;

use super::{SurfaceOrigin, Window};
use crate::bins::{AngleBasis, Frame, KlemsBasis};
use crate::error::{Error, Result, Warnings};
use covering::Base;
use glam::DVec3;
use std::collections::BTreeMap;

/// Surfaces of one window that differ by more than this from their mean normal call for a warning.
const WARN_ANGLE_DEG: f64 = 1.0;
/// What is nearer to the plane of a window than this share of the window's size is in it.
const IN_PLANE: f64 = 1e-4;
/// Windows nearer behind each other than this share of their size are faces of one pane.
const ONE_PANE: f64 = 0.1;
/// Surfaces that differ by less are parallel.
const PARALLEL_DEG: f64 = 5.0;
/// Overlaps of a smaller share are of no consequence.
const LITTLE: f64 = 1e-3;

/// Collects the surfaces of a window and comes to its frame and basis.
pub(super) struct WindowBuilder {
    name: String,
    origin: SurfaceOrigin,
    surfaces: Vec<(SurfaceOrigin, Vec<[DVec3; 3]>)>,
    parameters: Parameters,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Parameters {
    basis: Option<AngleBasis>,
    left_handed: bool,
    up: Option<DVec3>,
}

impl WindowBuilder {
    /// A window without surfaces; `origin` is where it begins.
    pub(super) fn new(name: String, origin: SurfaceOrigin) -> Self {
        Self { name, origin, surfaces: Vec::new(), parameters: Parameters::default() }
    }

    /// Its name.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Adds a surface whose front faces the room.
    pub(super) fn add(&mut self, origin: SurfaceOrigin, triangles: Vec<[DVec3; 3]>) {
        self.surfaces.push((origin, triangles));
    }

    /// Takes in rfluxmtx's parameters, as `h=kf u=+Y`; later ones win.
    ///
    /// # Errors
    /// Unknown parameters and bases that no window has.
    pub(super) fn parameters(&mut self, text: &str) -> Result<()> {
        self.parameters.read(text)
    }

    /// The window.
    ///
    /// # Errors
    /// If it has no area, its surfaces face opposite ways, or its up vector is unusable.
    pub(super) fn finish(self, warnings: &mut Warnings) -> Result<Window> {
        let triangles = self.without_overlaps(warnings);
        let at = |e: Error, o: &SurfaceOrigin| e.file(&o.file).line(o.line).field(format!("window '{}'", self.name));
        let vectors: Vec<DVec3> = self.surfaces.iter().map(|(_, triangles)| triangles.iter().map(area_vector).sum()).collect();
        let total: DVec3 = vectors.iter().sum();
        let areas: f64 = vectors.iter().map(|area| area.length()).sum();
        if areas == 0.0 {
            return Err(at(Error::new("the window has no area").help("give a polygon with an area"), &self.origin));
        }
        // Opposite faces would cancel to a normal that means nothing.
        let normal = total.try_normalize().filter(|_| total.length() > 1e-6 * areas);
        for ((origin, _), area) in self.surfaces.iter().zip(&vectors) {
            let cosine = match (normal, area.try_normalize()) {
                (Some(n), Some(a)) => n.dot(a),
                (None, _) => -1.0,
                (_, None) => continue,
            };
            if cosine <= 0.0 {
                let message = format!("surface '{}' faces away from the other surfaces of the window", origin.name);
                return Err(at(
                    Error::new(message)
                        .help("turn all normals into the room, or give windows of different orientation different modifiers"),
                    origin,
                ));
            }
            if cosine < WARN_ANGLE_DEG.to_radians().cos() {
                let message = format!(
                    "surface '{}' is turned by {:.1}° from the mean of its window; one normal is used for all",
                    origin.name,
                    cosine.acos().to_degrees()
                );
                warnings.push(at(Error::new(message).help("give windows of different orientation different modifiers"), origin));
            }
        }
        let normal = normal.unwrap_or(DVec3::Z);
        let frame = match self.parameters.up {
            Some(up) => Frame::new(normal, up),
            None => Frame::with_default_up(normal),
        };
        let mut frame = frame.map_err(|e| at(e, &self.origin))?;
        if self.parameters.left_handed {
            frame.x = -frame.x;
        }
        let basis = self.parameters.basis.unwrap_or_else(|| KlemsBasis::Full.into());
        Ok(Window { name: self.name, triangles, frame, basis, origin: self.origin })
    }

    /// The triangles, each place once: what lies in the place of earlier ones, or behind others that face the
    /// same way, is left out.
    fn without_overlaps(&self, warnings: &mut Warnings) -> Vec<[DVec3; 3]> {
        let areas: Vec<f64> = self.surfaces.iter().map(|(_, t)| t.iter().map(|t| area_vector(t).length()).sum()).collect();
        let parallel = PARALLEL_DEG.to_radians().cos();
        let neighbours = self.neighbours(&areas);
        // By the number of the surface.
        let mut kept: Vec<Vec<[DVec3; 3]>> = vec![Vec::new(); self.surfaces.len()];
        // By the numbers of the surfaces: area left out of the first because of the second, and how far behind it.
        let mut left_out: BTreeMap<(usize, usize), (f64, f64)> = BTreeMap::new();
        let all = self.surfaces.iter().enumerate().flat_map(|(i, (_, triangles))| triangles.iter().map(move |t| (i, *t)));
        for (number, triangle) in all {
            let mut parts = vec![triangle];
            // First what is in the place of others or behind them, then what others have behind this.
            let mut hide = |cut: &mut Vec<[DVec3; 3]>, own: usize, (by, cover): (usize, &[DVec3; 3]), nearest: f64| {
                let Some(base) = Base::new(cover) else { return };
                let size = areas[own].min(areas[by]).sqrt();
                *cut = std::mem::take(cut)
                    .into_iter()
                    .flat_map(|part| {
                        let found = base.overlap(&part, ONE_PANE * size).filter(|o| o.cosine > parallel && o.depth[1] <= nearest * size);
                        let Some(found) = found else { return vec![part] };
                        let (area, depth) = left_out.entry((own, by)).or_default();
                        *area += found.area;
                        *depth = depth.max(-found.depth[0]);
                        found.rest
                    })
                    .collect();
            };
            let near = |other: usize| ONE_PANE * areas[number].min(areas[other]).sqrt();
            for &other in &neighbours[number] {
                for by in kept[other].iter().filter(|by| can_meet(&triangle, by, near(other))) {
                    hide(&mut parts, number, (other, by), IN_PLANE);
                }
            }
            for part in &parts {
                for &other in &neighbours[number] {
                    // Façades have thousands of openings apart from each other.
                    if kept[other].iter().any(|k| can_meet(part, k, near(other))) {
                        hide(&mut kept[other], other, (number, part), -IN_PLANE);
                    }
                }
            }
            kept[number].extend(parts);
        }
        for ((hidden, by), (area, depth)) in left_out {
            let ((first, _), (second, _)) = (&self.surfaces[hidden], &self.surfaces[by]);
            if area <= LITTLE * areas[hidden].min(areas[by]) {
                continue;
            }
            let (part, share) = (part(area / areas[hidden]), percent(area / areas[hidden]));
            let other = format!("surface '{}' ({}:{})", second.name, second.file.display(), second.line);
            let size = areas[hidden].min(areas[by]).sqrt();
            let message = if depth <= IN_PLANE * size {
                format!("{part} surface '{}' lies in the same place as {other}; it overlaps and counts once", first.name)
            } else {
                format!("{part} surface '{}' lies {depth:.3} behind {other}, which hides it: only this one counts", first.name)
            };
            let help = format!("it is {share}; draw each opening once, by one polygon; the panes of its glazing belong into the BSDF");
            let field = format!("window '{}'", self.name);
            warnings.push(Error::new(message).file(&first.file).line(first.line).field(field).help(help));
        }
        kept.into_iter().flatten().collect()
    }

    /// Of each surface those up to itself that may lie as near to it as panes of one window, in their order.
    fn neighbours(&self, areas: &[f64]) -> Vec<Vec<usize>> {
        let boxes: Vec<(DVec3, DVec3)> = self
            .surfaces
            .iter()
            .zip(areas)
            .map(|((_, triangles), area)| {
                let (near, corners) = (ONE_PANE * area.sqrt(), triangles.as_flattened());
                let limits = |low: DVec3, high: DVec3, c: &DVec3| (low.min(*c), high.max(*c));
                let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
                let (low, high) = corners.iter().fold(none, |(low, high), c| limits(low, high, c));
                (low - near, high + near)
            })
            .collect();
        let (low, high) = boxes.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), b| (l.min(b.0), h.max(b.1)));
        // Along the longest axis they follow each other.
        let axis = (high - low).to_array().into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(axis, _)| axis);
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        order.sort_by(|a, b| boxes[*a].0[axis].total_cmp(&boxes[*b].0[axis]));
        let mut found: Vec<Vec<usize>> = (0..boxes.len()).map(|i| vec![i]).collect();
        for (k, &a) in order.iter().enumerate() {
            for &b in order[k + 1..].iter().take_while(|b| boxes[**b].0[axis] <= boxes[a].1[axis]) {
                if boxes[a].0.cmple(boxes[b].1).all() && boxes[b].0.cmple(boxes[a].1).all() {
                    found[a.max(b)].push(a.min(b));
                }
            }
        }
        found.iter_mut().for_each(|n| n.sort_unstable());
        found
    }
}

/// Whether the boxes of two triangles are nearer to each other than a length along every axis.
fn can_meet(a: &[DVec3; 3], b: &[DVec3; 3], near: f64) -> bool {
    let limits = |t: &[DVec3; 3]| (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
    let ((low, high), (other_low, other_high)) = (limits(a), limits(b));
    (low - near).cmple(other_high).all() && (other_low - near).cmple(high).all()
}

/// Area times unit normal.
fn area_vector([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a) / 2.0
}

fn part(share: f64) -> &'static str {
    if share > 1.0 - LITTLE { "all of" } else { "a part of" }
}

/// A share for people.
fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p >= 9.95 => format!("{p:.0} %"),
        p => format!("{p:.1} %"),
    }
}

impl Parameters {
    /// Takes in the words of a comment; later ones win.
    fn read(&mut self, text: &str) -> Result<()> {
        for word in text.split_whitespace() {
            match word.split_once('=') {
                Some(("h", basis)) => (self.basis, self.left_handed) = hemisphere(basis)?,
                Some(("u", up)) => self.up = Some(direction(up)?),
                // Where rfluxmtx would write the matrix to; here the command line says so.
                Some(("o", _)) => {}
                _ => {
                    return Err(Error::new(format!("'{}' is not a parameter", super::rad::shortened(word)))
                        .help("write h=kf, h=kh, h=kq or h=u for the basis, u=+Y or u=0,0,1 for the up vector, without blanks around ="));
                }
            }
        }
        Ok(())
    }
}

fn hemisphere(text: &str) -> Result<(Option<AngleBasis>, bool)> {
    let left_handed = text.starts_with('-');
    let name = text.strip_prefix(['+', '-']).unwrap_or(text);
    let basis = match name {
        "kf" | "k" | "k1" => KlemsBasis::Full.into(),
        "kh" | "k2" => KlemsBasis::Half.into(),
        "kq" | "k4" => KlemsBasis::Quarter.into(),
        "u" | "1" => AngleBasis::from_rings("Uniform", &[0.0, 90.0], &[1])?,
        _ => {
            return Err(Error::new(format!("h={} is not a basis of windows", super::rad::shortened(text)))
                .help("choose h=kf, h=kh or h=kq (Klems full, half, quarter) or h=u (one bin); r, t and sc are bases of skies"));
        }
    };
    Ok((Some(basis), left_handed))
}

fn direction(text: &str) -> Result<DVec3> {
    let bad = || {
        Error::new(format!("u={} is not a direction", super::rad::shortened(text)))
            .help("write an axis as u=Z, u=+Y, u=-X or three numbers as u=0,0,1")
    };
    let (sign, axis) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    match axis {
        "X" | "x" => return Ok(DVec3::X * sign),
        "Y" | "y" => return Ok(DVec3::Y * sign),
        "Z" | "z" => return Ok(DVec3::Z * sign),
        _ => {}
    }
    let numbers: Vec<f64> =
        text.split(',').map(|t| t.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect::<Option<_>>().ok_or_else(bad)?;
    match numbers[..] {
        [x, y, z] => DVec3::new(x, y, z).try_normalize().ok_or_else(bad),
        _ => Err(bad()),
    }
}

#[cfg(test)]
mod tests;
