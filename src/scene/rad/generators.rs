//! `genbox` and `genblinds`: the same surfaces as Radiance's programs print.

use super::syntax::Object;
use super::types::{ObjectType, Surface};
use crate::error::{Error, Result};
use crate::limits::{self, GENERATED_SURFACES};
use crate::scene::shapes::SPHERE_SEGMENTS;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// `genblinds` approximates curved slats by flat strips of at most this arc.
const SLAT_ARC_DEG: f64 = 3.0;

/// Surfaces made by a generator.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Generator {
    /// Its surfaces; their lines are to be set by the caller.
    pub objects: Vec<Object>,
}

impl Generator {
    /// Understands the words after `genbox`: `material name xsize ysize zsize [-i] [-b bevel | -r
    /// round [-n segments] [-s]]`.
    ///
    /// Rounded boxes consist of faces, cylinders and spheres; with `-i` only of the quarter
    /// cylinders and eighths of spheres that face the inside. `-n` and `-s` are accepted and
    /// without effect, since this program has its own fineness ([`SPHERE_SEGMENTS`]).
    ///
    /// # Errors
    /// Missing or bad numbers, unknown options, a bevel that does not fit.
    pub(super) fn genbox(words: &[String]) -> Result<Self> {
        let usage = "genbox material name xsize ysize zsize [-i] [-b bevel | -r round]";
        let mut numbers = Numbers { command: "genbox", usage, words, position: 2 };
        let size = DVec3::new(numbers.next("xsize")?, numbers.next("ysize")?, numbers.next("zsize")?);
        let (mut inward, mut round, mut inset) = (false, false, 0.0);
        while let Some(option) = numbers.word() {
            match option {
                "-i" => inward = true,
                "-s" => {}
                "-n" => {
                    numbers.next("the number after -n")?;
                }
                "-b" | "-r" => {
                    round = option == "-r";
                    inset = numbers.next(if round { "round" } else { "bevel" })?;
                }
                "-o" => {
                    return Err(Error::new("genbox -o makes a Wavefront file, which a scene file cannot hold").help("leave -o out"));
                }
                other => return Err(numbers.error(format!("genbox has no option '{other}'"))),
            }
        }
        if size.min_element() <= 0.0 {
            return Err(numbers.error(format!("the sizes {} {} {} must be positive", size.x, size.y, size.z)));
        }
        if inset < 0.0 || 2.0 * inset > size.min_element() {
            return Err(numbers.error(format!("a bevel or rounding of {inset} does not fit the box")));
        }
        let mut faces = Faces { material: words[0].clone(), name: words[1].clone(), inward, objects: Vec::new() };
        if inset == 0.0 {
            plain_box(&mut faces, size);
        } else {
            beveled_box(&mut faces, size, inset, round);
        }
        Ok(Self { objects: faces.objects })
    }

    /// Understands the words after `genblinds`: `material name depth width height nslats angle
    /// [+r | -r radius]`. Slats lie along X (depth) and Y (width), stacked along Z; a positive angle
    /// raises their +X edge; `+r` curves them upward.
    ///
    /// # Errors
    /// Missing or bad numbers, unknown options, a radius below half the depth.
    pub(super) fn genblinds(words: &[String]) -> Result<Self> {
        let usage = "genblinds material name depth width height nslats angle [+r | -r radius]";
        let mut numbers = Numbers { command: "genblinds", usage, words, position: 2 };
        let [depth, width, height] = [numbers.next("depth")?, numbers.next("width")?, numbers.next("height")?];
        let slats = numbers.next("nslats")?;
        let angle = numbers.next("angle")?;
        let mut radius = 0.0;
        while let Some(option) = numbers.word() {
            radius = match option {
                "+r" => numbers.next("the radius after +r")?,
                "-r" => -numbers.next("the radius after -r")?,
                other => return Err(numbers.error(format!("genblinds has no option '{other}'"))),
            };
        }
        if !(1.0..=GENERATED_SURFACES as f64).contains(&slats) {
            return Err(numbers.error(format!("nslats is {slats}; it must be between 1 and {GENERATED_SURFACES}")));
        }
        if radius != 0.0 && 2.0 * radius.abs() < depth.abs() {
            return Err(numbers.error(format!("slats of depth {depth} cannot have a radius of curvature of {}", radius.abs())));
        }
        let slats = slats as usize;
        let profile = slat_profile(depth, radius);
        if slats.saturating_mul(profile.len() - 1) > GENERATED_SURFACES {
            return Err(limits::exceeded("this genblinds makes", GENERATED_SURFACES, "surfaces").help("use fewer or flat slats"));
        }
        let (sin, cos) = angle.to_radians().sin_cos();
        let mut faces = Faces { material: words[0].clone(), name: words[1].clone(), inward: false, objects: Vec::new() };
        for slat in 0..slats {
            let base = height * (slat as f64 + 0.5) / slats as f64;
            let place = |[x, z]: [f64; 2], y: f64| DVec3::new(x * cos - z * sin, y, base + x * sin + z * cos);
            for (strip, ends) in profile.windows(2).enumerate() {
                let corners = [place(ends[0], 0.0), place(ends[0], width), place(ends[1], width), place(ends[1], 0.0)];
                faces.polygon(&format!("{}.{strip}", slat + 1), &corners);
            }
        }
        Ok(Self { objects: faces.objects })
    }
}

/// Cross-section of a slat from its edge at the origin to (depth, 0), as (along depth, up).
fn slat_profile(depth: f64, radius: f64) -> Vec<[f64; 2]> {
    if radius == 0.0 {
        return vec![[0.0, 0.0], [depth, 0.0]];
    }
    let half = (depth / (2.0 * radius.abs())).clamp(-1.0, 1.0).asin();
    let strips = ((2.0 * half.abs()).to_degrees() / SLAT_ARC_DEG - 1e-9).ceil().max(1.0) as usize;
    let up = radius.signum();
    (0..=strips)
        .map(|i| match i {
            // The edges are exact, so that they meet whatever the slats are attached to.
            0 => [0.0, 0.0],
            _ if i == strips => [depth, 0.0],
            _ => {
                let angle = half * (2.0 * i as f64 / strips as f64 - 1.0);
                [depth / 2.0 + radius.abs() * angle.sin(), up * radius.abs() * (angle.cos() - half.cos())]
            }
        })
        .collect()
}

/// Corners by their bits x = 1, y = 2, z = 4, as in the names Radiance gives the faces.
const BOX_FACES: [[usize; 4]; 6] = [[1, 5, 4, 0], [4, 6, 2, 0], [2, 3, 1, 0], [3, 2, 6, 7], [5, 1, 3, 7], [6, 4, 5, 7]];

fn plain_box(faces: &mut Faces, size: DVec3) {
    for corners in BOX_FACES {
        let name: String = corners.iter().map(usize::to_string).collect();
        let points = corners.map(|c| size * DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64));
        // Reflected in the box's centre the same corners turn the other way: how Radiance inverts.
        let points = if faces.inward { points.map(|p| size - p) } else { points };
        faces.polygon(&name, &points);
    }
}

/// Faces, edges and corners of a box cut back by `inset`.
fn beveled_box(faces: &mut Faces, size: DVec3, inset: f64, round: bool) {
    // Signs −1, 0, 1 per axis say where a piece lies: one sign is a face, two an edge, three a corner.
    let centre = |signs: [i32; 3]| DVec3::from_array([0, 1, 2].map(|a| if signs[a] < 0 { inset } else { size[a] - inset }));
    for code in 0..27 {
        let signs = [code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1];
        let fixed: Vec<usize> = (0..3).filter(|&a| signs[a] != 0).collect();
        let free: Vec<usize> = (0..3).filter(|&a| signs[a] == 0).collect();
        let outward = DVec3::from_array(signs.map(f64::from));
        let with = |choices: &[i32]| {
            let mut s = signs;
            for (&axis, &choice) in free.iter().zip(choices) {
                s[axis] = choice;
            }
            centre(s)
        };
        let reach = |axis: usize| {
            let mut v = DVec3::ZERO;
            v[axis] = f64::from(signs[axis]) * inset;
            v
        };
        let name = format!("piece{code}");
        match fixed.len() {
            1 => {
                let shift = reach(fixed[0]);
                let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(|c| with(&c) + shift);
                faces.facing(&name, &corners, outward);
            }
            2 => {
                let (start, end) = (with(&[-1]), with(&[1]));
                let (u, v) = (reach(fixed[0]), reach(fixed[1]));
                if round && !faces.inward {
                    faces.object(&name, Surface::Cylinder, [start.to_array().as_slice(), &end.to_array(), &[inset]].concat());
                } else {
                    // As many as at the spheres, so that no gap stays open between them.
                    let strips = if round { SPHERE_SEGMENTS / 4 } else { 1 };
                    for i in 0..strips {
                        let [a, b] = [i, i + 1].map(|i| quarter(u, v, i, strips));
                        faces.facing(&format!("{name}.{i}"), &[start + a, end + a, end + b, start + b], outward);
                    }
                }
            }
            3 => {
                let middle = centre(signs);
                let [u, v, w] = [0, 1, 2].map(reach);
                if !round {
                    faces.facing(&name, &[middle + u, middle + v, middle + w], outward);
                } else if !faces.inward {
                    faces.object(&name, Surface::Sphere, [middle.to_array().as_slice(), &[inset]].concat());
                } else {
                    let n = SPHERE_SEGMENTS / 4;
                    for i in 0..n {
                        for j in 0..n {
                            let at = |i: usize, j: usize| middle + quarter(quarter(u, v, j, n), w, i, n);
                            let mut corners = vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                            corners.truncate(if i + 1 == n { 3 } else { 4 });
                            faces.facing(&format!("{name}.{i}.{j}"), &corners, outward);
                        }
                    }
                }
            }
            _ => {}
        }
    }
}

/// The point `i`/`n` of the way along the quarter ellipse from `u` to `v`.
fn quarter(u: DVec3, v: DVec3, i: usize, n: usize) -> DVec3 {
    match i {
        0 => u,
        _ if i == n => v,
        _ => {
            let (sin, cos) = (FRAC_PI_2 * i as f64 / n as f64).sin_cos();
            u * cos + v * sin
        }
    }
}

pub(super) struct Faces {
    pub material: String,
    pub name: String,
    pub inward: bool,
    pub objects: Vec<Object>,
}

impl Faces {
    pub(super) fn object(&mut self, suffix: &str, surface: Surface, reals: Vec<f64>) {
        self.objects.push(Object {
            modifier: self.material.clone(),
            kind: ObjectType::Surface(surface),
            name: format!("{}.{suffix}", self.name),
            strings: Vec::new(),
            reals,
            line: 0,
        });
    }

    pub(super) fn polygon(&mut self, suffix: &str, corners: &[DVec3]) {
        self.object(suffix, Surface::Polygon, corners.iter().flat_map(|c| c.to_array()).collect());
    }

    /// A polygon whose front is towards `outward`, or away from it for inward boxes.
    fn facing(&mut self, suffix: &str, corners: &[DVec3], outward: DVec3) {
        let faces_outward = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(outward) > 0.0;
        if faces_outward == self.inward {
            let reversed: Vec<DVec3> = corners.iter().rev().copied().collect();
            self.polygon(suffix, &reversed);
        } else {
            self.polygon(suffix, corners);
        }
    }
}

pub(super) struct Numbers<'a> {
    pub command: &'static str,
    pub usage: &'static str,
    pub words: &'a [String],
    pub position: usize,
}

impl<'a> Numbers<'a> {
    pub(super) fn word(&mut self) -> Option<&'a str> {
        self.position += 1;
        self.words.get(self.position - 1).map(String::as_str)
    }

    pub(super) fn next(&mut self, what: &str) -> Result<f64> {
        let word = self.word().ok_or_else(|| self.error(format!("{} lacks {what}", self.command)))?;
        word.parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| self.error(format!("{what} of {} is '{}', not a number", self.command, super::syntax::shortened(word))))
    }

    pub(super) fn error(&self, message: String) -> Error {
        Error::new(message).help(format!("usage: {}", self.usage))
    }
}
