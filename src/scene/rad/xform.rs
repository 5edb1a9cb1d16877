//! Arguments of `xform`: rigid motions, uniform scaling, mirrors and arrays of them.

use crate::error::{Error, Result};
use crate::limits::{self, COPIES};
use glam::{DMat3, DVec3};
use std::rc::Rc;

/// Where and as what an object appears: what a chain of `xform`s does to it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placement {
    /// Rotation, mirrors and scale.
    pub linear: DMat3,
    /// Translation, applied after `linear`.
    pub translation: DVec3,
    /// Scale of lengths, positive.
    pub scale: f64,
    /// Fronts and backs exchanged (`-I`).
    pub inverted: bool,
    /// Modifier of all surfaces (`-m`).
    pub modifier: Option<Rc<str>>,
    /// Put before identifiers of surfaces (`-n`), with its dot.
    pub prefix: String,
}

impl Default for Placement {
    fn default() -> Self {
        Self { linear: DMat3::IDENTITY, translation: DVec3::ZERO, scale: 1.0, inverted: false, modifier: None, prefix: String::new() }
    }
}

impl Placement {
    /// World position of a point.
    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        self.linear * p + self.translation
    }

    /// World direction of a vector (not normalised).
    pub(super) fn vector(&self, v: DVec3) -> DVec3 {
        self.linear * v
    }

    /// Whether a counter-clockwise loop would turn clockwise.
    pub(super) fn is_mirrored(&self) -> bool {
        self.linear.determinant() < 0.0
    }

    /// First `inner`, then `self`.
    pub(super) fn of(&self, inner: &Self) -> Self {
        Self {
            linear: self.linear * inner.linear,
            translation: self.point(inner.translation),
            scale: self.scale * inner.scale,
            inverted: self.inverted != inner.inverted,
            modifier: self.modifier.clone().or_else(|| inner.modifier.clone()),
            prefix: format!("{}{}", self.prefix, inner.prefix),
        }
    }

    /// As often as that, by way of squares: a file may ask for a million repetitions a million times.
    fn repeated(&self, mut times: usize) -> Self {
        let (mut done, mut square) = (Self::default(), self.clone());
        while times > 0 {
            if times % 2 == 1 {
                done = square.of(&done);
            }
            square = square.of(&square);
            times /= 2;
        }
        done
    }
}

/// An understood `xform` command.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Xform {
    placement: Placement,
    name: Option<String>,
    segments: Vec<Segment>,
    /// Input files; none means the preceding stage of the pipeline.
    pub files: Vec<String>,
}

/// Operations under one repetition count.
#[derive(Debug, Clone, PartialEq)]
struct Segment {
    repeat: Repeat,
    step: Placement,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Repeat {
    /// `-i n`: n times.
    Times(usize),
    /// `-a n`: n copies, repeated 0 to n-1 times.
    Array(usize),
}

impl Xform {
    /// Understands the words after `xform`.
    ///
    /// # Errors
    /// Unknown options, missing or bad numbers, too many copies.
    pub(super) fn parse(words: &[String]) -> Result<Self> {
        let mut words = words.iter().map(String::as_str).peekable();
        let mut xform = Self { placement: Placement::default(), name: None, segments: Vec::new(), files: Vec::new() };
        while let Some(&word) = words.peek() {
            match word {
                "-I" => xform.placement.inverted = !xform.placement.inverted,
                // Both only say how commands in the input are to be printed.
                "-e" | "-c" => {}
                "-m" | "-n" => {
                    words.next();
                    let value = *words.peek().ok_or_else(|| Error::new(format!("xform {word} lacks its name")))?;
                    if word == "-m" {
                        xform.placement.modifier = Some(value.into());
                    } else {
                        xform.name = Some(xform.name.map_or_else(|| value.to_string(), |first| format!("{first}.{value}")));
                    }
                }
                _ => break,
            }
            words.next();
        }
        let mut repeat = Repeat::Times(1);
        let mut step = Placement::default();
        let mut copies = 1_usize;
        while let Some(&word) = words.peek() {
            if !word.starts_with('-') || word.len() == 1 {
                break;
            }
            words.next();
            let mut number = || -> Result<f64> {
                let text = words.next().ok_or_else(|| Error::new(format!("xform {word} lacks a number")))?;
                text.parse()
                    .ok()
                    .filter(|v: &f64| v.is_finite())
                    .ok_or_else(|| Error::new(format!("xform {word} needs a number, not '{text}'")))
            };
            let mut operation = Placement::default();
            match word {
                "-t" => operation.translation = DVec3::new(number()?, number()?, number()?),
                "-rx" => operation.linear = rotation(0, number()?),
                "-ry" => operation.linear = rotation(1, number()?),
                "-rz" => operation.linear = rotation(2, number()?),
                "-s" => {
                    let factor = number()?;
                    if factor == 0.0 {
                        return Err(Error::new("xform -s 0 would shrink everything to a point").help("give a scale factor other than 0"));
                    }
                    operation.linear = DMat3::from_diagonal(DVec3::splat(factor));
                    operation.scale = factor.abs();
                }
                "-mx" => operation.linear = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
                "-my" => operation.linear = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)),
                "-mz" => operation.linear = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)),
                "-i" | "-a" => {
                    let text = words.next().ok_or_else(|| Error::new(format!("xform {word} lacks its count")))?;
                    let count: usize = text.parse().ok().filter(|&n| word == "-i" || n > 0).ok_or_else(|| {
                        Error::new(format!(
                            "xform {word} needs a {} whole number, not '{text}'",
                            if word == "-i" { "non-negative" } else { "positive" }
                        ))
                    })?;
                    let limit =
                        || limits::exceeded(&format!("xform {word} {text} asks for"), COPIES, "repetitions").help("use a smaller count");
                    if word == "-a" {
                        copies = copies.checked_mul(count).filter(|&n| n <= COPIES).ok_or_else(limit)?;
                    } else if count > COPIES {
                        return Err(limit());
                    }
                    xform.segments.push(Segment { repeat, step: std::mem::take(&mut step) });
                    repeat = if word == "-i" { Repeat::Times(count) } else { Repeat::Array(count) };
                    continue;
                }
                "-f" => {
                    return Err(Error::new("xform -f (transformations from a file) is not supported")
                        .help("write the transformations into the command"));
                }
                "-I" | "-m" | "-n" | "-e" | "-c" => {
                    return Err(Error::new(format!("xform {word} stands after a transformation"))
                        .help("put -I, -m, -n and -e before the first transformation, as xform itself demands"));
                }
                _ => {
                    return Err(Error::new(format!("xform has no option '{word}'"))
                        .help("the options are -I -m -n -e -c, then -t -rx -ry -rz -s -mx -my -mz -i -a, then files"));
                }
            }
            step = operation.of(&step);
        }
        xform.segments.push(Segment { repeat, step });
        xform.files = words.map(str::to_string).collect();
        Ok(xform)
    }

    /// How many copies it makes: the product of its arrays.
    pub(super) fn count(&self) -> usize {
        self.segments.iter().map(|s| if let Repeat::Array(n) = s.repeat { n } else { 1 }).product()
    }

    /// The copies it makes, in Radiance's order, with their names.
    pub(super) fn copies(&self) -> Vec<Placement> {
        let arrays: Vec<usize> =
            self.segments.iter().filter_map(|s| if let Repeat::Array(n) = s.repeat { Some(n) } else { None }).collect();
        let mut copies = Vec::new();
        let mut indices = vec![0; arrays.len()];
        let fixed: Vec<Placement> =
            self.segments.iter().map(|s| if let Repeat::Times(n) = s.repeat { s.step.repeated(n) } else { Placement::default() }).collect();
        // Powers of each array's step, grown by one multiplication per copy.
        let powers: Vec<Vec<Placement>> = self
            .segments
            .iter()
            .map(|s| match s.repeat {
                Repeat::Array(n) => std::iter::successors(Some(Placement::default()), |p| Some(s.step.of(p))).take(n).collect(),
                Repeat::Times(_) => Vec::new(),
            })
            .collect();
        loop {
            let mut placement = self.placement.clone();
            let mut array = 0;
            for (i, segment) in self.segments.iter().enumerate() {
                let step = match segment.repeat {
                    Repeat::Times(_) => &fixed[i],
                    Repeat::Array(_) => {
                        array += 1;
                        &powers[i][indices[array - 1]]
                    }
                };
                let Placement { modifier, inverted, .. } = placement.clone();
                placement = Placement { modifier, inverted, ..step.of(&placement) };
            }
            let numbers = indices.iter().map(usize::to_string).collect::<Vec<_>>().join(".");
            placement.prefix = match (&self.name, arrays.is_empty()) {
                (None, true) => String::new(),
                (Some(name), true) => format!("{name}."),
                (Some(name), false) => format!("{name}.{numbers}."),
                (None, false) => format!("a{numbers}."),
            };
            copies.push(placement);
            // The last array runs fastest.
            let Some(place) = (0..arrays.len()).rev().find(|&i| indices[i] + 1 < arrays[i]) else {
                return copies;
            };
            indices[place] += 1;
            indices[place + 1..].fill(0);
        }
    }
}

/// Counter-clockwise rotation about an axis; multiples of 90° are exact.
fn rotation(axis: usize, degrees: f64) -> DMat3 {
    let quarter_turns = degrees / 90.0;
    let (sin, cos) = if quarter_turns.fract() == 0.0 {
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarter_turns.rem_euclid(4.0) as usize % 4]
    } else {
        degrees.to_radians().sin_cos()
    };
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut m = DMat3::IDENTITY;
    m.col_mut(a)[a] = cos;
    m.col_mut(a)[b] = sin;
    m.col_mut(b)[a] = -sin;
    m.col_mut(b)[b] = cos;
    m
}
