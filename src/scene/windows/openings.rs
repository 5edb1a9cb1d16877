//! Makes the windows of a scene openings of it: see the [conventions](super).

use super::covering::Base;
use super::{IN_PLANE, LITTLE, ONE_PANE, PARALLEL_DEG, part, percent};
use crate::error::{Error, Result, Warnings};
use crate::limits;
use crate::scene::{MaterialKind, Scene, SurfaceOrigin, Triangle, Window};
use glam::DVec3;
use std::collections::BTreeMap;

/// What hides part of a window from nearer than this share of its size was hardly meant to.
const NEAR: f64 = 5e-3;
/// Share of a window from which such a surface is named.
const NEAR_SHARE: f64 = 0.01;
/// A surface that hides a window from nearer than this share of its size, almost all of it, is named.
const CLOSE: f64 = 0.2;
/// Share of the window from which it does.
const ALMOST_ALL: f64 = 0.95;
/// Surfaces that are named one by one; the others are counted.
const MOST_NAMED: usize = 20;

/// A cut takes as long as so many looks.
const CUT: usize = 16;

/// A triangle of a window, front into the room.
pub(super) struct Opening {
    pub(super) base: Base,
    window: usize,
    /// Root of the window's area.
    pub(super) size: f64,
}

/// How much of a window a surface covers, m².
#[derive(Default)]
struct Cover {
    in_plane: f64,
    /// Just before or behind the plane.
    near: f64,
    /// The same, up to some more.
    close: f64,
    /// Distance from the plane of what is nearest, positive inside.
    distance: f64,
    /// What it is made of.
    kind: Option<MaterialKind>,
}

impl Scene {
    /// Tells the scene all windows of the building. Surfaces in their planes are cut out where they cover a
    /// window; warnings name these and such as hide a window from close by.
    ///
    /// # Errors
    /// Windows that lie in the same place, or behind each other by less than a tenth of their size.
    pub fn set_windows(&mut self, windows: &[Window], warnings: &mut Warnings) -> Result<()> {
        refuse_overlaps(windows)?;
        let covers = self.cut_out(windows)?;
        self.warn(windows, &covers, warnings);
        self.windows = windows.to_vec();
        Ok(())
    }

    fn cut_out(&mut self, windows: &[Window]) -> Result<BTreeMap<u32, BTreeMap<usize, Cover>>> {
        let openings = openings(windows);
        let mut pairs = Pairs::default();
        let parallel = PARALLEL_DEG.to_radians().cos();
        let mut covers: BTreeMap<u32, BTreeMap<usize, Cover>> = BTreeMap::new();
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for triangle in &self.triangles {
            if self.materials[triangle.material.0 as usize].kind == MaterialKind::Void {
                triangles.push(*triangle);
                continue;
            }
            let mut parts = vec![triangle.vertices];
            pairs.add(openings.len())?;
            for opening in openings.iter().filter(|o| o.base.overlap(&triangle.vertices, CLOSE * o.size).is_some()) {
                let cut = |part: [DVec3; 3]| {
                    let Some(found) = opening.base.overlap(&part, CLOSE * opening.size) else { return vec![part] };
                    let [low, high] = found.depth;
                    let distance = if low.abs() > high.abs() { low } else { high };
                    let cover = covers.entry(triangle.surface).or_default().entry(opening.window).or_default();
                    cover.kind = Some(self.materials[triangle.material.0 as usize].kind);
                    if distance.abs() <= IN_PLANE * opening.size {
                        cover.in_plane += found.area;
                        return found.rest;
                    }
                    if found.cosine.abs() > parallel {
                        let is_nearest = cover.close == 0.0 || distance.abs() < cover.distance.abs();
                        cover.distance = if is_nearest { distance } else { cover.distance };
                        cover.close += found.area;
                        cover.near += if distance.abs() <= NEAR * opening.size { found.area } else { 0.0 };
                    }
                    vec![part]
                };
                // A wall with thousands of openings falls into thousands of parts.
                pairs.add(CUT * parts.len())?;
                parts = parts.into_iter().flat_map(cut).collect();
            }
            triangles.extend(parts.into_iter().map(|vertices| Triangle { vertices, ..*triangle }));
        }
        self.triangles = triangles;
        Ok(covers)
    }

    fn warn(&self, windows: &[Window], covers: &BTreeMap<u32, BTreeMap<usize, Cover>>, warnings: &mut Warnings) {
        let mut named = 0;
        for (surface, by_window) in covers {
            // One warning for each kind of fault.
            let mut faults: BTreeMap<Fault, Vec<(String, String)>> = BTreeMap::new();
            for (fault, how) in by_window.iter().filter_map(|(&w, cover)| Self::told_of(&windows[w], cover)) {
                faults.entry(fault).or_default().push(how);
            }
            for (fault, places) in faults {
                named += 1;
                if named <= MOST_NAMED {
                    let more = if places.len() > 3 { format!(" and {} more", places.len() - 3) } else { String::new() };
                    let (list, shares): (Vec<String>, Vec<String>) = places.into_iter().take(3).unzip();
                    let message = format!("it covers {}{more}{}", list.join(", "), fault.consequence());
                    let warning = Error::new(message).help(format!("it covers {}; {}", shares.join(", "), fault.help()));
                    let origin = self.surfaces.get(*surface as usize);
                    warnings.push(origin.map_or_else(|| warning.clone(), |o| at(warning.clone(), o)));
                }
            }
        }
        if named > MOST_NAMED {
            let message = format!("{} more surfaces cover windows in or close to their planes", named - MOST_NAMED);
            warnings.push(Error::new(message).help("cut the openings out of the walls"));
        }
    }

    /// What is told of a surface that covers a window, if anything, and the share that it covers.
    fn told_of(window: &Window, cover: &Cover) -> Option<(Fault, (String, String))> {
        let area = window.area();
        let told = |covered: f64, place: String| {
            let (origin, share) = (&window.origin, (covered / area).min(1.0));
            let window = format!("window '{}' ({}:{})", window.name, origin.file.display(), origin.line);
            (format!("{} {window} {place}", part(share)), percent(share))
        };
        if cover.in_plane > LITTLE * area {
            let fault = if matches!(cover.kind, Some(MaterialKind::Glass { .. })) { Fault::OwnPane } else { Fault::InPlane };
            return Some((fault, told(cover.in_plane, "in its plane".into())));
        }
        let hides = if cover.near > NEAR_SHARE * area {
            cover.near
        } else if cover.close > ALMOST_ALL * area {
            cover.close
        } else {
            return None;
        };
        let fault = match cover.kind {
            Some(MaterialKind::Glass { .. } | MaterialKind::Trans { .. } | MaterialKind::Lobes(_)) => Fault::Filters,
            _ => Fault::Hides,
        };
        let side = if cover.distance > 0.0 { "inside" } else { "outside" };
        Some((fault, told(hides, format!("from {:.4} {side} its plane", cover.distance.abs()))))
    }
}

#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Fault {
    InPlane,
    OwnPane,
    Hides,
    Filters,
}

impl Fault {
    fn consequence(&self) -> &'static str {
        match self {
            Self::InPlane => "; light passes there as if nothing were in the plane",
            Self::Hides => ": no light passes there",
            Self::OwnPane => "; the window's own glazing counts in its place",
            Self::Filters => ": its transmittance counts beside that of the window's glazing",
        }
    }

    fn help(&self) -> &'static str {
        match self {
            Self::InPlane => {
                "cut the opening out of the wall; panes and frames in the window's plane belong into its glazing or its polygon's outline"
            }
            Self::OwnPane => "right if it is the pane of the window; with glass = \"scene\" in its [[window]] it counts as it is",
            Self::Hides => "if it is the wall, cut the opening out of it; if it is meant, all is well",
            Self::Filters => "if it is the pane of the window, take it out of the scene; if it is another one, all is well",
        }
    }
}

fn at(error: Error, origin: &SurfaceOrigin) -> Error {
    error.file(&origin.file).line(origin.line).field(format!("surface '{}'", origin.name))
}

/// Counts pairs that are looked at.
#[derive(Default)]
struct Pairs(usize);

impl Pairs {
    fn add(&mut self, more: usize) -> Result<()> {
        self.0 = self.0.saturating_add(more);
        if self.0 <= limits::COVERING_PAIRS {
            return Ok(());
        }
        Err(limits::exceeded("windows and surfaces are", limits::COVERING_PAIRS, "pairs, each of which may cover the other")
            .help("join the openings of a façade into fewer and larger polygons, cut them out of the walls, or simplify the scene"))
    }
}

pub(super) fn openings(windows: &[Window]) -> Vec<Opening> {
    let opening = |(number, window): (usize, &Window)| {
        let size = window.area().sqrt();
        window
            .triangles
            .iter()
            .filter_map(move |t| Some(Opening { base: Base::new(&into_room(t, window))?, window: number, size }))
            .collect::<Vec<_>>()
    };
    windows.iter().enumerate().flat_map(opening).collect()
}

/// The triangle with its front into the room, whatever the order of the file's corners.
fn into_room(triangle: &[DVec3; 3], window: &Window) -> [DVec3; 3] {
    let [a, b, c] = *triangle;
    if (b - a).cross(c - a).dot(window.frame.z) > 0.0 { [a, b, c] } else { [a, c, b] }
}

/// Windows in the same place, or one behind the other.
fn refuse_overlaps(windows: &[Window]) -> Result<()> {
    let (mut pairs, mut before) = (Pairs::default(), 0usize);
    for window in windows {
        pairs.add(before.saturating_mul(window.triangles.len()))?;
        before += window.triangles.len();
    }
    let parallel = PARALLEL_DEG.to_radians().cos();
    for (i, first) in windows.iter().enumerate() {
        let bases: Vec<Base> = openings(std::slice::from_ref(first)).into_iter().map(|o| o.base).collect();
        for second in &windows[i + 1..] {
            let least = first.area().min(second.area());
            let size = least.sqrt();
            let pairs = bases.iter().flat_map(|base| second.triangles.iter().map(move |t| (base, t)));
            let (mut area, mut depth) = (0.0, 0.0f64);
            for overlap in pairs.filter_map(|(base, t)| base.overlap(t, ONE_PANE * size)).filter(|o| o.cosine.abs() > parallel) {
                area += overlap.area;
                depth = overlap.depth.iter().fold(depth, |most, d| most.max(d.abs()));
            }
            if area > LITTLE * least {
                let place = if depth <= IN_PLANE * size { "in the same place as".to_string() } else { format!("{depth:.3} from") };
                let message = format!(
                    "{} it lies {place} window '{}' ({}:{}); two windows cannot cover each other",
                    part(area / second.area()),
                    first.name,
                    first.origin.file.display(),
                    first.origin.line
                );
                return Err(Error::new(message)
                    .file(&second.origin.file)
                    .line(second.origin.line)
                    .field(format!("window '{}'", second.name))
                    .help("draw each opening once, by one polygon of one window; the panes of its glazing belong into the BSDF"));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_pairs_than_can_be_looked_at_are_refused() {
        let mut pairs = Pairs::default();
        pairs.add(limits::COVERING_PAIRS).unwrap();
        let error = pairs.add(1).unwrap_err().to_string();
        assert!(error.contains("join the openings of a façade"), "{error}");
        assert!(Pairs(1).add(usize::MAX).is_err());
    }
}
