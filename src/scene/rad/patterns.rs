//! Patterns: what they make of a material's colour, on the mean.
//!
//! A spectrum becomes RGB as the CIE 1931 observer sees it under light of equal energy; a picture its mean,
//! a function its value where it is constant. What has no mean of its own is refused: a material without
//! its pattern is as bright as the brightest part of it.

use super::expression::Definitions;
use super::syntax::{Object, shortened};
use crate::bsdf::spectrum;
use crate::error::{Error, Result, Warnings};
use crate::image::hdr::{self, Exposure};
use crate::text;
use std::path::{Path, PathBuf};

/// The RGB factor of a pattern; 1 for a texture, which bends normals only.
///
/// # Errors
/// Wrong arguments, files that cannot be read, patterns without a mean.
pub(super) fn factor(object: &Object, file: &Path, base: &Path, warnings: &mut Warnings) -> Result<[f64; 3]> {
    let word = object.kind.word();
    let mut warn = |message: String, help: &str| warnings.push(object.at(Error::new(message).help(help), file));
    match word {
        "texfunc" | "texdata" => {
            warn(format!("this {word} is ignored: the surface is taken as smooth"), "bumps change where light goes, not how much of it");
            Ok([1.0; 3])
        }
        "spectrum" => of_spectrum(&object.reals),
        "specfile" => {
            let [name] = object.strings.as_slice() else {
                return Err(Error::new(format!("{} string arguments do not make a specfile", object.strings.len()))
                    .help("it needs one: the data file"));
            };
            let path = find(name, file, base)?;
            spectrum_file(&path).map_err(|e| e.file(&path))
        }
        "colorpict" => {
            let [red, green, blue, picture, ..] = object.strings.as_slice() else {
                return Err(Error::new(format!("{} string arguments do not make a colorpict", object.strings.len()))
                    .help("it needs: red green blue picture functions u v"));
            };
            let path = find(picture, file, base)?;
            let mean = picture_mean(&path, [red, green, blue])?;
            warn(
                format!("the mean of its picture stands for it: {:.4} {:.4} {:.4}", mean[0], mean[1], mean[2]),
                "where the variation matters, or where only a part of the picture lies on the surface, divide the surface among several materials",
            );
            Ok(mean)
        }
        "brightfunc" => {
            let [formula, ..] = object.strings.as_slice() else { return Err(too_few(object)) };
            constant(object, formula, &|_, _| None)?.map(|v| [v; 3]).ok_or_else(|| no_mean(word))
        }
        "colorfunc" => {
            let [red, green, blue, ..] = object.strings.as_slice() else { return Err(too_few(object)) };
            let channel = |formula: &str| constant(object, formula, &|_, _| None)?.ok_or_else(|| no_mean(word));
            Ok([channel(red)?, channel(green)?, channel(blue)?])
        }
        _ => Err(no_mean(word)),
    }
}

fn too_few(object: &Object) -> Error {
    Error::new(format!("{} string arguments do not make a {}", object.strings.len(), object.kind.word()))
        .help("it needs a formula (three for a colour) and a function file, `.` for none")
}

fn no_mean(word: &str) -> Error {
    Error::new(format!("this {word} varies over the surface, and its mean is not known"))
        .help("leave the pattern out and multiply the material's colour by the pattern's mean")
}

/// The value of a formula of an object's arguments (`A1`, `arg(1)`), constants and what is `given`.
///
/// # Errors
/// What is no formula.
pub(super) fn constant(object: &Object, formula: &str, given: &dyn Fn(&str, &[f64]) -> Option<f64>) -> Result<Option<f64>> {
    let argument = |n: f64| if n == 0.0 { Some(object.reals.len() as f64) } else { object.reals.get((n - 1.0) as usize).copied() };
    let known = |name: &str, arguments: &[f64]| match (name, arguments) {
        ("arg", [n]) if *n >= 0.0 => argument(n.round()),
        ("AC", []) => argument(0.0),
        _ => {
            let number = name.strip_prefix('A').and_then(|n| n.parse::<u32>().ok()).filter(|n| *n > 0 && arguments.is_empty());
            number.map_or_else(|| given(name, arguments), |n| argument(f64::from(n)))
        }
    };
    Ok(Definitions::default().value(formula, &known)?.filter(|v| v.is_finite()))
}

/// A file that a definition names: beside the scene file that names it, or in the working folder.
pub(super) fn find(name: &str, file: &Path, base: &Path) -> Result<PathBuf> {
    let beside = file.parent().unwrap_or(Path::new("")).join(name);
    let working = base.join(name);
    [working, beside.clone()].into_iter().find(|p| p.is_file()).ok_or_else(|| {
        Error::new(format!("its file '{}' does not exist as {}", shortened(name), beside.display()))
            .help("put the file beside the scene file, or correct its name")
    })
}

/// RGB of the arguments of `spectrum`: two limits in nm, then values evenly spread from one to the other.
fn of_spectrum(reals: &[f64]) -> Result<[f64; 3]> {
    let [start, end, values @ ..] = reals else {
        return Err(Error::new(format!("{} real arguments do not make a spectrum", reals.len())).help(SPECTRUM));
    };
    let last = values.len().saturating_sub(1) as f64;
    let nodes: Vec<[f64; 2]> = values.iter().enumerate().map(|(k, v)| [start + (end - start) * k as f64 / last, *v]).collect();
    of_nodes(nodes)
}

const SPECTRUM: &str = "it needs the limits of its range in nm and three values or more";

/// RGB of pairs of wavelength (nm) and value, in order of the wavelength, rising or falling. Linear between
/// them and nothing beyond them, as in Radiance; three values are red, green and blue.
fn of_nodes(mut nodes: Vec<[f64; 2]>) -> Result<[f64; 3]> {
    if nodes.len() < 3 || nodes[0][0] == nodes[nodes.len() - 1][0] {
        return Err(Error::new("this is no spectrum").help(SPECTRUM));
    }
    if nodes[0][0] > nodes[nodes.len() - 1][0] {
        nodes.reverse();
    }
    if nodes.windows(2).any(|p| p[0][0] >= p[1][0]) {
        return Err(Error::new("the wavelengths of the spectrum do not ascend").help(SPECTRUM));
    }
    if let [blue, green, red] = nodes[..] {
        return Ok([red[1], green[1], blue[1]]);
    }
    let value = |nanometres: f64| {
        let above = nodes.partition_point(|n| n[0] <= nanometres);
        if above == nodes.len() {
            return if nodes[above - 1][0] == nanometres { nodes[above - 1][1] } else { 0.0 };
        }
        let Some(below) = above.checked_sub(1) else { return 0.0 };
        let ([x0, v0], [x1, v1]) = (nodes[below], nodes[above]);
        v0 + (v1 - v0) * (nanometres - x0) / (x1 - x0)
    };
    Ok(spectrum::rgb(value))
}

/// RGB of a data file of one dimension: `1`, then `start end n` and n values (`0 0 n`: n wavelengths first).
fn spectrum_file(path: &Path) -> Result<[f64; 3]> {
    let text = text::read(path, "a spectrum")?;
    let mut numbers = Vec::new();
    for (line, words) in text.lines().enumerate() {
        for word in words.split('#').next().unwrap_or_default().split_whitespace() {
            let number = word.parse::<f64>().ok().filter(|v| v.is_finite());
            numbers.push(number.ok_or_else(|| Error::new(format!("'{}' is not a number", shortened(word))).line(line + 1))?);
        }
    }
    let help = "a specfile's data file reads: 1, the limits in nm and the number of values, the values";
    let [dimensions, start, end, count, rest @ ..] = numbers.as_slice() else {
        return Err(Error::new("this is no spectrum").help(help));
    };
    let listed = *start == 0.0 && *end == 0.0;
    let expected = if listed { 2.0 * count } else { *count };
    if *dimensions != 1.0 || expected != rest.len() as f64 {
        return Err(
            Error::new(format!("{} values follow where {expected} are announced in {dimensions} dimensions", rest.len())).help(help)
        );
    }
    if listed {
        let (wavelengths, values) = rest.split_at(rest.len() / 2);
        return of_nodes(wavelengths.iter().zip(values).map(|(w, v)| [*w, *v]).collect());
    }
    of_spectrum(&numbers[1..3].iter().chain(rest).copied().collect::<Vec<f64>>())
}

/// The mean over a picture of three functions of its colour, with the exposure that it has.
fn picture_mean(path: &Path, functions: [&String; 3]) -> Result<[f64; 3]> {
    let picture = hdr::read_with(path, Exposure::Keep)?;
    let definitions = Definitions::default();
    let mut sum = [0.0; 3];
    for pixel in &picture.pixels {
        let color = pixel.map(f64::from);
        for (channel, name) in functions.iter().enumerate() {
            sum[channel] += definitions.call(name, &color)?.ok_or_else(|| {
                Error::new(format!("the function '{}' of the picture's colours is not known", shortened(name)))
                    .help("`red green blue` takes the colours as they are")
            })?;
        }
    }
    let pixels = picture.pixels.len().max(1) as f64;
    Ok(sum.map(|s| s / pixels))
}
