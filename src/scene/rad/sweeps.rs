//! `genprism`, `gensurf`, `genrev` and `genworm`: the same surfaces as Radiance's programs print.

use super::expression::Definitions;
use super::generators::{Faces, Generator, Numbers};
use super::types::Surface;
use crate::error::{Error, Result};
use crate::limits::{self, GENERATED_SURFACES};
use glam::{DVec2, DVec3};

/// Radiance's FTINY: what is smaller is zero.
const TINY: f64 = 1e-6;

/// The material and name that every generator starts with.
fn faces(words: &[String], numbers: &Numbers) -> Result<Faces> {
    let [material, name, ..] = words else { return Err(numbers.error(format!("{} lacks its material and name", numbers.command))) };
    Ok(Faces { material: material.clone(), name: name.clone(), inward: false, objects: Vec::new() })
}

/// Understands the words after `genprism`: `material name N x1 y1 … xN yN [-l x y z] [-c] [-e]`.
///
/// # Errors
/// Missing or bad numbers, vertices from files, rounded edges.
pub(super) fn genprism(words: &[String]) -> Result<Generator> {
    let usage = "genprism material name N x1 y1 … xN yN [-l x y z] [-c] [-e]";
    let mut numbers = Numbers { command: "genprism", usage, words, position: 2 };
    let mut faces = faces(words, &numbers)?;
    if let Some(file) = words.get(2).filter(|w| w.parse::<f64>().is_err()) {
        let text = format!("genprism takes its corners from '{}', which is not read here", super::syntax::shortened(file));
        return Err(Error::new(text).help("run the command once yourself and name its output, or write the corners behind their number"));
    }
    let count = numbers.next("the number of corners")?;
    if !(3.0..=GENERATED_SURFACES as f64).contains(&count) || count.fract() != 0.0 {
        return Err(numbers.error(format!("{count} corners make no prism")));
    }
    let corners: Vec<DVec2> =
        (0..count as usize).map(|_| Ok(DVec2::new(numbers.next("a corner's x")?, numbers.next("a corner's y")?))).collect::<Result<_>>()?;
    let (mut along, mut ends, mut closed) = (DVec3::Z, true, false);
    while let Some(option) = numbers.word() {
        match option {
            "-l" => along = DVec3::new(numbers.next("x of -l")?, numbers.next("y of -l")?, numbers.next("z of -l")?),
            "-e" => ends = !ends,
            "-c" => closed = !closed,
            "-r" if numbers.next("the radius after -r")? <= TINY => {}
            "-r" => {
                return Err(Error::new("rounded edges (-r) of genprism are not known here")
                    .help("leave -r out, or run the command once yourself and name its output"));
            }
            other => return Err(numbers.error(format!("genprism has no option '{}'", super::syntax::shortened(other)))),
        }
    }
    if along.z.abs() <= TINY {
        return Err(numbers.error(format!("the prism's length {} {} {} has no z", along.x, along.y, along.z)));
    }
    let bottom: Vec<DVec3> = corners.iter().map(|c| c.extend(0.0)).collect();
    if ends {
        faces.polygon("b", &bottom);
        faces.polygon("t", &bottom.iter().rev().map(|c| *c + along).collect::<Vec<_>>());
    }
    for i in 0..bottom.len() - usize::from(closed) {
        let (a, b) = (bottom[i], bottom[(i + 1) % bottom.len()]);
        faces.polygon(&(i + 1).to_string(), &[a, a + along, b + along, b]);
    }
    Ok(Generator { objects: faces.objects })
}

/// The formulas of a generator, and the options `-e` and `-s` behind them.
fn formulas<const N: usize>(numbers: &mut Numbers, parameters: &[&str]) -> Result<(Definitions, [String; N], usize)> {
    let mut own = Definitions::default();
    let mut texts: [String; N] = std::array::from_fn(|_| String::new());
    for text in &mut texts {
        *text = numbers.word().ok_or_else(|| numbers.error(format!("{} lacks a formula", numbers.command)))?.to_string();
    }
    let after = numbers.position;
    // The counts stand between the formulas and the options.
    numbers.position += if numbers.command == "gensurf" { 2 } else { 1 };
    while let Some(option) = numbers.word() {
        match option {
            "-e" => {
                let text = numbers.word().ok_or_else(|| numbers.error("-e lacks its definitions".to_string()))?;
                own.add(text)?;
            }
            // Only how bumps are to be smoothed.
            "-s" if numbers.command != "genworm" => {}
            "-f" => {
                return Err(Error::new("function files (-f) are not read here")
                    .help("write their definitions after -e, or run the command once yourself and name its output"));
            }
            other => return Err(numbers.error(format!("{} has no option '{}' here", numbers.command, super::syntax::shortened(other)))),
        }
    }
    numbers.position = after;
    for (k, text) in texts.iter().enumerate() {
        own.function(&hidden(k), parameters, text)?;
    }
    Ok((own, texts, after))
}

/// A name that no file can define.
fn hidden(k: usize) -> String {
    format!("#{k}")
}

/// A count of segments, which may be a formula.
fn segments(numbers: &mut Numbers, own: &Definitions) -> Result<usize> {
    let text = numbers.word().ok_or_else(|| numbers.error(format!("{} lacks its number of segments", numbers.command)))?;
    let count = own.value(text, &|_, _| None)?.map_or(0.0, |v| (v + 0.5).floor());
    if !(1.0..=GENERATED_SURFACES as f64).contains(&count) {
        return Err(numbers.error(format!("'{}' is no number of segments", super::syntax::shortened(text))));
    }
    Ok(count as usize)
}

/// The values of all formulas.
fn values<const N: usize>(own: &Definitions, texts: &[String; N], at: &[f64]) -> Result<[f64; N]> {
    let mut values = [0.0; N];
    for (k, value) in values.iter_mut().enumerate() {
        *value = own.call(&hidden(k), at)?.filter(|v| v.is_finite()).ok_or_else(|| {
            Error::new(format!("'{}' has no value at {at:?}", super::syntax::shortened(&texts[k])))
                .help("formulas have numbers, names that -e defines, + - * / ^ and Radiance's functions; data files are not read here: run the command once yourself and name its output")
        })?;
    }
    Ok(values)
}

/// Understands the words after `gensurf`: `material name x(s,t) y(s,t) z(s,t) m n [-e definitions] [-s]`.
///
/// # Errors
/// What is no formula, data and function files, Wavefront output.
pub(super) fn gensurf(words: &[String]) -> Result<Generator> {
    let usage = "gensurf material name 'x(s,t)' 'y(s,t)' 'z(s,t)' m n [-e definitions] [-s]";
    let mut numbers = Numbers { command: "gensurf", usage, words, position: 2 };
    let mut faces = faces(words, &numbers)?;
    let (own, texts, _) = formulas::<3>(&mut numbers, &["s", "t"])?;
    let (m, n) = (segments(&mut numbers, &own)?, segments(&mut numbers, &own)?);
    if m.saturating_mul(n) > GENERATED_SURFACES {
        return Err(limits::exceeded("this gensurf makes", GENERATED_SURFACES, "surfaces").help("use fewer steps"));
    }
    let row = |i: usize| -> Result<Vec<Option<DVec3>>> {
        let point = |j: usize| {
            let at = [i as f64 / m as f64, j as f64 / n as f64];
            // Holes are where a function `valid` of the user is not positive.
            if own.call("valid", &at)?.is_some_and(|v| v <= 0.0) {
                return Ok(None);
            }
            Ok(Some(DVec3::from_array(values(&own, &texts, &at)?)))
        };
        (0..=n).map(point).collect()
    };
    let mut near = row(0)?;
    for i in 1..=m {
        let far = row(i)?;
        for j in 0..n {
            let mut turned = j % 2 == 1;
            if near[j].is_none() || far[j + 1].is_none() {
                turned = true;
            } else if far[j].is_none() || near[j + 1].is_none() {
                turned = false;
            }
            if turned {
                square(&mut faces, [near[j], far[j], near[j + 1], far[j + 1]]);
            } else {
                square(&mut faces, [far[j], far[j + 1], near[j], near[j + 1]]);
            }
        }
        near = far;
    }
    Ok(Generator { objects: faces.objects })
}

/// Four corners as a quadrilateral if they lie in a plane, else as triangles about the diagonal of the middle two.
fn square(faces: &mut Faces, [a, b, c, d]: [Option<DVec3>; 4]) {
    let normal = |p: Option<DVec3>, q: Option<DVec3>, r: Option<DVec3>| (q? - p?).cross(r? - p?).try_normalize();
    let (first, second) = (normal(a, b, c), normal(d, c, b));
    let mut put = |corners: &[Option<DVec3>]| {
        let corners: Vec<DVec3> = corners.iter().flatten().copied().collect();
        let name = (faces.objects.len() + 1).to_string();
        faces.polygon(&name, &corners);
    };
    if let (Some(u), Some(v)) = (first, second)
        && u.dot(v) >= 1.0 - TINY * TINY
    {
        return put(&[a, b, d, c]);
    }
    if first.is_some() {
        put(&[a, b, c]);
    }
    if second.is_some() {
        put(&[c, b, d]);
    }
}

/// Understands the words after `genrev`: `material name z(t) r(t) segments [-e definitions] [-s]`.
///
/// # Errors
/// What is no formula, function files.
pub(super) fn genrev(words: &[String]) -> Result<Generator> {
    let usage = "genrev material name 'z(t)' 'r(t)' segments [-e definitions] [-s]";
    let mut numbers = Numbers { command: "genrev", usage, words, position: 2 };
    let mut faces = faces(words, &numbers)?;
    let (own, texts, _) = formulas::<2>(&mut numbers, &["t"])?;
    let count = segments(&mut numbers, &own)?;
    let at = |i: usize| values(&own, &texts, &[i as f64 / count as f64]);
    let [mut z0, mut r0] = at(0)?;
    for i in 1..=count {
        let [z, r] = at(i)?;
        let (rises, falls) = (z > z0 + TINY, z < z0 - TINY);
        let (opens, closes) = (r > r0 + TINY, r < r0 - TINY);
        let name = i.to_string();
        let ends = [0.0, 0.0, z0, 0.0, 0.0, z];
        if opens || closes {
            if rises || falls {
                faces.object(&name, if falls { Surface::Cup } else { Surface::Cone }, [&ends[..], &[r0, r]].concat());
            } else {
                faces.object(&name, Surface::Ring, vec![0.0, 0.0, z, 0.0, 0.0, if closes { 1.0 } else { -1.0 }, r0, r]);
            }
        } else if rises || falls {
            faces.object(&name, if falls { Surface::Tube } else { Surface::Cylinder }, [&ends[..], &[r]].concat());
        }
        (z0, r0) = (z, r);
    }
    Ok(Generator { objects: faces.objects })
}

/// Understands the words after `genworm`: `material name x(t) y(t) z(t) r(t) segments [-e definitions]`.
///
/// # Errors
/// What is no formula, function files.
pub(super) fn genworm(words: &[String]) -> Result<Generator> {
    let usage = "genworm material name 'x(t)' 'y(t)' 'z(t)' 'r(t)' segments [-e definitions]";
    let mut numbers = Numbers { command: "genworm", usage, words, position: 2 };
    let mut faces = faces(words, &numbers)?;
    let (own, texts, _) = formulas::<4>(&mut numbers, &["t"])?;
    let count = segments(&mut numbers, &own)?;
    let mut last: Option<(DVec3, f64)> = None;
    for i in 0..=count {
        let [x, y, z, r] = values(&own, &texts, &[i as f64 / count as f64])?;
        let p = DVec3::new(x, y, z);
        if let Some((q, r0)) = last {
            let name = format!("c{i}");
            if (r0 - r).abs() <= TINY {
                faces.object(&name, Surface::Cylinder, [&q.to_array()[..], &p.to_array(), &[r]].concat());
            } else {
                // The cone that touches both spheres.
                let slope = (r0 - r) / (p - q).length_squared();
                let (from, to) = (q + (p - q) * (slope * r0), p + (p - q) * (slope * r));
                let narrowed = (1.0 - (r0 - r) * slope).max(0.0).sqrt();
                faces.object(&name, Surface::Cone, [&from.to_array()[..], &to.to_array(), &[narrowed * r0, narrowed * r]].concat());
            }
        }
        faces.object(&format!("s{i}"), Surface::Sphere, vec![x, y, z, r]);
        last = Some((p, r));
    }
    Ok(Generator { objects: faces.objects })
}
