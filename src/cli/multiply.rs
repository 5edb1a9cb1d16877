//! `lucarne multiply`: products of matrices, and pictures of many hours.

mod finished;

use super::progress::Terminal;
use clap::ArgAction;
use finished::Finished;
use lucarne::bsdf::{self, transmission_matrix};
use lucarne::image::exr;
use lucarne::image::series::Pattern;
use lucarne::kernels::product::{self, Multiplier, with_components};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, read_matrix, write_matrix};
use lucarne::simulate::multiply::{Factor, check_hours, check_shapes, lit_columns, product as multiply, select_columns, weighted};
use lucarne::simulate::results::pictures::{Output, PictureView, Request, write_pictures};
use lucarne::units::ILLUMINANCE_WEIGHTS;
use lucarne::{Error, Result, Warnings};
use std::path::Path;
use std::process::ExitCode;

/// Product of matrices, V·T·D·S or DC·S, in dctimestep's order of arguments.
///
/// Each factor is a Radiance matrix file, or a BSDF (.xml) in T's place. The last one, the sky
/// matrix, is read from standard input if it is absent or `-`. If V is a set of component pictures
/// (v%03d.hdr) or a view matrix of pixels and the output a picture name (img_%04d.hdr, img_%04d.exr,
/// or year.exr for all hours in one file), the result is one picture per hour whose sky is not
/// black.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    /// V T D [S], or DC [S]
    #[arg(required = true, num_args = 1..=4, value_name = "MATRIX")]
    factors: Vec<String>,

    /// Matrix file, or pattern of picture files; standard output if absent or `-`
    #[arg(short = 'o', value_name = "FILE")]
    output: Option<String>,

    /// One component: illuminance in lux, by Radiance's weights 47.448 119.951 11.601
    #[arg(long)]
    illuminance: bool,

    /// One component: weights of red, green and blue in its place
    #[arg(short = 'c', num_args = 3, value_names = ["R", "G", "B"], allow_negative_numbers = true)]
    weights: Option<Vec<f64>>,

    /// Columns of the sky matrix to compute, counted from 0: `1164,1929` or `8-17` (default: all)
    #[arg(long, value_name = "LIST")]
    hours: Option<String>,

    /// Memory for pictures and their matrices, for instance 512M or 4G (default: 2G, or half of what is free if that is less)
    #[arg(long, value_name = "SIZE")]
    memory: Option<String>,

    /// Width of the pictures, if V's header does not tell
    #[arg(short = 'x', value_name = "PIXELS", requires = "height")]
    width: Option<usize>,

    /// Height of the pictures, if V's header does not tell
    #[arg(short = 'y', value_name = "PIXELS", requires = "width")]
    height: Option<usize>,

    /// EXR pictures with 16-bit samples instead of 32
    #[arg(long)]
    half: bool,

    /// EXR pictures of luminance (cd/m²) instead of RGB radiance
    #[arg(long)]
    luminance: bool,

    /// Write numbers as text (default on standard output)
    #[arg(long = "oa", conflicts_with_all = ["float", "double"])]
    ascii: bool,

    /// Write 32-bit numbers (default in a file)
    #[arg(long = "of", conflicts_with = "double")]
    float: bool,

    /// Write 64-bit numbers
    #[arg(long = "od")]
    double: bool,

    /// Write no header
    #[arg(short = 'h')]
    no_header: bool,

    /// Device: index or part of its name (see `lucarne devices`), or `native` for the processor
    /// without a GPU interface (default: LUCARNE_DEVICE, else a GPU, else native)
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,

    /// Print help
    #[arg(long, action = ArgAction::Help)]
    help: Option<bool>,
}

pub fn run(mut args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    if args.factors.len() % 2 == 1 {
        args.factors.push("-".into());
    }
    if args.factors.iter().filter(|f| *f == "-").count() > 1 {
        return Err(Error::new("standard input can be only one of the matrices").help("name the others as files"));
    }
    let hours = args.hours.as_deref().map(parse_hours).transpose()?;
    let pattern_in = Pattern::is_pattern(&args.factors[0]);
    match &args.output {
        Some(output) if is_picture(output) => pictures(&args, output, hours, warnings)?,
        _ if pattern_in => {
            return Err(Error::new(format!("'{}' is a set of pictures, so the output must be too", args.factors[0]))
                .field("-o")
                .help("write for instance -o img_%04d.hdr"));
        }
        _ => matrices(&args, hours.as_deref(), warnings)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn is_picture(name: &str) -> bool {
    let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    Pattern::is_pattern(name) || ["hdr", "pic", "exr"].contains(&&*ending)
}

fn matrices(args: &Args, hours: Option<&[usize]>, warnings: &mut Warnings) -> Result<()> {
    let multiplier = product::choose(args.device.as_deref())?;
    let mut factors = Vec::new();
    let mut header = vec![super::sky::command_line()];
    for name in &args.factors {
        let (factor, lines) = read_factor(name, warnings)?;
        factors.push(factor);
        // Of the factors' lines the site is worth keeping; dates and commands are not the result's.
        header.extend(lines.into_iter().filter(|l| l.starts_with("LATLONG=")));
    }
    let mut result = multiply(&*multiplier, factors, hours)?;
    let weights = args.weights.as_ref().map(|w| [w[0], w[1], w[2]]).or(args.illuminance.then_some(ILLUMINANCE_WEIGHTS));
    if let Some(weights) = weights {
        result = weighted(&result, weights)?;
    }
    let path = args.output.as_deref().map(Path::new).filter(|p| *p != Path::new("-"));
    let format = match (args.ascii, args.float, args.double) {
        (true, ..) => Format::Ascii,
        (_, true, _) => Format::Float,
        (.., true) => Format::Double,
        _ if path.is_some() => Format::Float,
        _ => Format::Ascii,
    };
    if args.no_header { super::sky::write_without_header(path, &result, format) } else { write_matrix(path, &result, format, &header) }
}

/// A matrix, or the transmission matrix of a BSDF, with the header lines of its file.
fn read_factor(name: &str, warnings: &mut Warnings) -> Result<(Factor, Vec<String>)> {
    let path = Path::new(name);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xml")) {
        let bsdf = bsdf::read(path, warnings)?;
        let matrix = transmission_matrix(&bsdf).map_err(|e| e.file(path))?.map(|v| v as f32);
        return Ok((Factor { name: name.into(), matrix }, Vec::new()));
    }
    let file = read_matrix(path)?;
    let shown = if name == "-" { "standard input" } else { name };
    Ok((Factor { name: shown.into(), matrix: file.matrix }, file.header))
}

fn pictures(args: &Args, output: &str, hours: Option<Vec<usize>>, warnings: &mut Warnings) -> Result<()> {
    if args.illuminance || args.weights.is_some() {
        return Err(Error::new("weights make no sense for RGB pictures").help("for luminance use --luminance with -o img_%04d.exr"));
    }
    let samples = if args.half { exr::Samples::Half } else { exr::Samples::Float };
    let channels = if args.luminance { exr::Channels::Luminance } else { exr::Channels::Rgb };
    let output = Output::parse(output, exr::Options { samples, channels })?;
    if (args.half || args.luminance) && matches!(output, Output::Hdr(_)) {
        return Err(Error::new("Radiance pictures have no such variant").field("--half, --luminance").help("write -o img_%04d.exr"));
    }
    let half = || lucarne::gpu::available().map_or(u64::MAX, |free| free / 2);
    let memory = args.memory.as_deref().map_or_else(|| Ok((2 << 30).min(half())), parse_memory)?;
    let multiplier = product::choose(args.device.as_deref())?;
    let (name, others) = args.factors.split_first().expect("clap demands a factor");
    let mut view = PictureView::open(name, args.width.zip(args.height).map(|(w, h)| [w, h]))?;
    let factors: Vec<Factor> = others.iter().map(|n| read_factor(n, warnings).map(|f| f.0)).collect::<Result<_>>()?;
    let (hours, coefficients) = coefficients(&*multiplier, &view, factors, hours)?;
    let progress = Terminal::new();
    let header = [super::sky::command_line()];
    let finished = Finished::of(args, &output, &header)?;
    let open: Vec<usize> = (0..hours.len()).filter(|&i| !finished.as_ref().is_some_and(|f| f.has(hours[i]))).collect();
    if open.len() < hours.len() {
        eprintln!("going on after {} of {} pictures", hours.len() - open.len(), hours.len());
    }
    let numbers: Vec<usize> = open.iter().map(|&i| hours[i]).collect();
    let request = Request {
        coefficients: &select_columns(&coefficients, &open),
        hours: &numbers,
        output: &output,
        header: &header,
        memory,
        addition: None,
        finished: Some(&|numbers| finished.as_ref().map_or(Ok(()), |f| f.add(numbers))),
    };
    write_pictures(&*multiplier, &mut view, &request, &progress, warnings)?;
    if let Some(finished) = finished {
        finished.end();
    }
    progress.finish();
    println!("{} pictures of {} × {} pixels by the {}", hours.len(), view.width, view.height, multiplier.description());
    Ok(())
}

/// The product of all factors but V, for the hours wanted: those named, else all that are not black.
fn coefficients(
    multiplier: &dyn Multiplier,
    view: &PictureView,
    mut factors: Vec<Factor>,
    hours: Option<Vec<usize>>,
) -> Result<(Vec<usize>, Matrix<f32>)> {
    let mut shapes = vec![(view.name(), view.pixels(), view.bins, 3)];
    shapes.extend(factors.iter().map(|f| (&*f.name, f.matrix.rows(), f.matrix.cols(), f.matrix.components())));
    check_shapes(&shapes)?;
    let sky = factors.last_mut().expect("there is a sky beside V");
    let hours = match hours {
        Some(hours) => {
            check_hours(&hours, &sky.name, sky.matrix.cols()).map_err(|e| e.field("--hours"))?;
            hours
        }
        None => lit_columns(&sky.matrix),
    };
    sky.matrix = select_columns(&sky.matrix, &hours);
    let result = multiply(multiplier, factors, None)?;
    Ok((hours, with_components(&result, 3).into_owned()))
}

/// `1164,1929,8-17`.
fn parse_hours(text: &str) -> Result<Vec<usize>> {
    let bad =
        |part: &str| Error::new(format!("'{part}' is no hour and no range")).field("--hours").help("write for instance 1164,1929 or 8-17");
    let mut hours = Vec::new();
    for part in text.split(',') {
        let number = |s: &str| s.trim().parse::<usize>().map_err(|_| bad(part));
        match part.split_once('-') {
            None => hours.push(number(part)?),
            Some((first, last)) => {
                let (first, last) = (number(first)?, number(last)?);
                if first > last || last - first > 100_000 {
                    return Err(bad(part));
                }
                hours.extend(first..=last);
            }
        }
    }
    Ok(hours)
}

/// `512M`, `4G`, `1.5G`: bytes.
pub(super) fn parse_memory(text: &str) -> Result<u64> {
    let upper = text.trim().to_uppercase();
    let bare = upper.trim_end_matches("IB").trim_end_matches('B');
    let scale = match bare.chars().last() {
        Some('K') => Some(1u64 << 10),
        Some('M') => Some(1 << 20),
        Some('G') => Some(1 << 30),
        Some('T') => Some(1 << 40),
        _ => None,
    };
    let number = scale.and_then(|_| bare[..bare.len() - 1].trim().parse::<f64>().ok());
    let value = scale.zip(number).map(|(s, n)| s as f64 * n).filter(|v| v.is_finite() && *v >= 1.0 && *v < 1e18);
    value
        .map(|v| v as u64)
        .ok_or_else(|| Error::new(format!("'{text}' is no amount of memory")).field("--memory").help("write for instance 512M or 4G"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hours_and_memory_are_read_and_nonsense_is_refused() {
        assert_eq!(parse_hours("1164, 1929,8-11").unwrap(), [1164, 1929, 8, 9, 10, 11]);
        for bad in ["", "a", "3-", "-3", "5-2", "1,,2", "0-99999999"] {
            assert!(parse_hours(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_memory("512M").unwrap(), 512 << 20);
        assert_eq!(parse_memory("1.5 GiB").unwrap(), 3 << 29);
        for bad in ["", "2", "G", "-1G", "nanG", "1e30G", "0M", "12X"] {
            assert!(parse_memory(bad).is_err(), "{bad}");
        }
    }
}
