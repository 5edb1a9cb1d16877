//! `lucarne glare`: discomfort glare of pictures, as CSV.

mod kept;
mod tables;

use super::progress;
use super::view::ViewOptions;
use clap::ValueEnum;
use kept::{AnalysedPictures, Lines};
use lucarne::camera::{Raster, View};
use lucarne::files;
use lucarne::glare::statistics::Part;
use lucarne::glare::{
    self, Analyser, Background, Convention, DgpModel, FieldOfView, Glare, PixelGeometry, PositionIndex, Settings, TaskArea, Threshold,
};
use lucarne::image::{self, Picture, exr};
use lucarne::units::SUN_DIAMETER_DEG;
use lucarne::{Error, Result, Warnings};
use rayon::prelude::*;
use std::collections::HashMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use tables::{HEADER, Measured, PART_HEADER, SOURCE_HEADER, part_line, picture_line, quoted, source_lines};

/// Options; single letters mean what they mean in evalglare.
#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// Pictures: .hdr (RGBE) or .exr (each part of it), radiance in W/m²sr.
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// After the pictures' lines, a second table with a line per source.
    #[arg(short = 'd', long = "detail")]
    detail: bool,
    /// Threshold of glare: above 100 a luminance in cd/m², up to 100 a multiple of the task's
    /// luminance or, without a task, of the average. Default 2000 cd/m², with a task 5 times its luminance.
    #[arg(short = 'b', value_name = "THRESHOLD")]
    threshold: Option<f64>,
    /// Search radius, rad: pixels up to half of it apart are one source.
    #[arg(short = 'r', value_name = "RADIANS", default_value_t = 0.2)]
    search_radius: f64,
    /// Task area: pixel of its centre (from the left, from the bottom) and full opening angle, rad.
    #[arg(short = 't', num_args = 3, value_names = ["X", "Y", "RADIANS"], conflicts_with = "coloured_task")]
    task: Option<Vec<f64>>,
    /// The same, shown bluish in the check picture.
    #[arg(short = 'T', num_args = 3, value_names = ["X", "Y", "RADIANS"])]
    coloured_task: Option<Vec<f64>>,
    /// Extract peaks (the default).
    #[arg(short = 'y', conflicts_with = "no_peaks")]
    peaks: bool,
    /// Luminance from which pixels form sources of their own, cd/m².
    #[arg(short = 'Y', value_name = "LUMINANCE", default_value_t = glare::PEAK_LIMIT)]
    peak_limit: f64,
    /// Do not extract peaks.
    #[arg(short = 'x')]
    no_peaks: bool,
    /// Look for sources only in the field of view after Guth: 1 of both eyes together, 2 seen by both.
    #[arg(short = 'G', value_name = "TYPE", value_parser = clap::value_parser!(u8).range(1..=2))]
    field_of_view: Option<u8>,
    /// Statistics of the luminance in a band up to this angle above and below the middle row, rad.
    #[arg(short = 'B', value_name = "RADIANS")]
    band: Option<f64>,
    /// Statistics of a round zone: pixel of its centre (from the left, from the bottom) and full opening
    /// angle, rad. Sources are not parted at its border.
    #[arg(short = 'l', num_args = 3, value_names = ["X", "Y", "RADIANS"], conflicts_with = "two_zones")]
    zone: Option<Vec<f64>>,
    /// The same of a zone and of the ring around it.
    #[arg(short = 'L', num_args = 4, value_names = ["X", "Y", "INNER", "OUTER"])]
    two_zones: Option<Vec<f64>>,
    /// Only the vertical illuminance, lx, a line per picture.
    #[arg(short = 'V', conflicts_with_all = ["detail", "check_picture", "band", "zone", "two_zones"])]
    illuminance_only: bool,
    /// Write a picture with the sources coloured (one input picture only).
    #[arg(short = 'c', value_name = "PICTURE")]
    check_picture: Option<PathBuf>,
    /// Vertical illuminance for DGP, lx, instead of the picture's own (with a picture of the direct
    /// light only: eDGPs).
    #[arg(short = 'i', value_name = "LUX")]
    illuminance: Option<f64>,
    /// Low-light correction of DGP: l+ on, l- off.
    #[arg(short = 'C', value_name = "l+|l-", default_value = "l-", allow_hyphen_values = true)]
    low_light: String,
    /// Position index: 0 Guth, 1 Kim, 2 Guth with Iwata's below the line of sight.
    #[arg(short = 'P', value_name = "MODEL", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=2))]
    position_index: u8,
    /// Background luminance: 0 (Ev - Edir)/pi, 1 mean of what is no source, 2 Ev/pi.
    #[arg(short = 'q', value_name = "MODE", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=2))]
    background: u8,
    /// DGP's exponents and constants a1 a2 a3 a4 a5 c1 c2 c3.
    #[arg(short = 'w', num_args = 8, value_name = "NUMBER", conflicts_with = "constants")]
    weights: Option<Vec<f64>>,
    /// DGP's constants: those of today's evalglare (0.092, 0.159) or of the paper of 2006 (0.0918, 0.16).
    #[arg(long, value_enum, default_value_t = Constants::Evalglare)]
    constants: Constants,
    /// How positions are measured: as evalglare, which cuts a source's place to whole pixels and
    /// tilts the position index with the view, or exactly.
    #[arg(long, value_enum, default_value_t = Positions::Evalglare)]
    positions: Positions,
    /// Spread pixels from the peak limit on by a Gaussian of this full width at half maximum,
    /// degrees (without a number, of the sun: 0.533), before the analysis, as a camera or the eye does.
    #[arg(long, value_name = "DEGREES", num_args = 0..=1, require_equals = true)]
    peak_veil: Option<Option<f64>>,
    /// Write the tables into a file; the same command, run again after it was stopped, goes on where it was.
    #[arg(short = 'o', long = "output", value_name = "FILE.csv")]
    output: Option<PathBuf>,
    #[command(flatten)]
    view: ViewOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Constants {
    Evalglare,
    Original,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Positions {
    Evalglare,
    Exact,
}

/// One picture: a file, or one part of a file.
struct Job {
    path: PathBuf,
    /// Number and name of the part, in a file of several.
    part: Option<(usize, String)>,
}

impl Job {
    /// The pictures of a file. A file that cannot be read is one, so that its fault shows later.
    fn of_file(path: &Path) -> Vec<Self> {
        let whole = || vec![Self { path: path.to_path_buf(), part: None }];
        match exr::parts(path).ok().filter(|parts| image::is_exr(path) && parts.len() > 1) {
            None => whole(),
            Some(parts) => {
                let name = |i: usize, name: Option<String>| name.unwrap_or_else(|| i.to_string());
                let jobs = parts.into_iter().enumerate();
                jobs.map(|(i, part)| Self { path: path.to_path_buf(), part: Some((i, name(i, part.name))) }).collect()
            }
        }
    }

    fn read(&self) -> Result<Picture> {
        match &self.part {
            None => image::read(&self.path),
            Some((index, _)) => exr::read_part(&self.path, *index),
        }
    }

    /// What tables and messages call it: `file`, or `file:part`.
    fn name(&self) -> String {
        let part = self.part.as_ref().map_or(String::new(), |(_, name)| format!(":{name}"));
        format!("{}{part}", self.path.display())
    }
}

/// Analyses pictures and prints the tables. Pictures at fault are reported; the others' results stay.
pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let settings = settings(&args)?;
    let jobs: Vec<Job> = args.images.iter().flat_map(|path| Job::of_file(path)).collect();
    if args.check_picture.is_some() && jobs.len() > 1 {
        return Err(Error::new("a check picture can be written of one picture only").field("-c").help("give one picture, or leave out -c"));
    }
    let views = Mutex::new(HashMap::new());
    let kept = args.output.as_deref().map(AnalysedPictures::open);
    let header = if args.illuminance_only { String::new() } else { format!("{HEADER}\n") };
    let mut all = Lines::default();
    // A few pictures at a time bound the memory; results come in the order of the arguments.
    for some in jobs.chunks(2 * rayon::current_num_threads()) {
        let earlier = kept.as_ref().map(|kept| kept.known(some)).transpose()?.flatten();
        let lines = match earlier {
            Some(lines) => lines,
            None => {
                if args.output.is_some() && progress::stop_asked() {
                    return Err(lucarne::progress::cancelled());
                }
                let lines = lines(some, jobs.len() == 1, &args, &settings, &views, warnings)?;
                kept.as_ref().map_or(Ok(()), |kept| kept.add(some, &lines))?;
                lines
            }
        };
        // Nothing is printed if the only picture is at fault.
        if kept.is_none() && !lines.table.is_empty() {
            let first = if all.table.is_empty() { header.as_str() } else { "" };
            print(&format!("{first}{}", lines.table))?;
        }
        all.append(lines);
    }
    let mut rest = String::new();
    if args.detail {
        rest += &format!("\n{SOURCE_HEADER}\n{}", all.sources);
    }
    if !all.parts.is_empty() {
        rest += &format!("\n{PART_HEADER}\n{}", all.parts);
    }
    match (&args.output, kept) {
        (Some(path), Some(kept)) => {
            files::write_atomically(path, |out| {
                [header.as_str(), &all.table, &rest].iter().try_for_each(|t| out.write_all(t.as_bytes())).map_err(|e| Error::io(path, &e))
            })?;
            kept.finish();
        }
        _ => print(&rest)?,
    }
    if all.failed > 0 {
        return Err(Error::new(format!("{} of {} pictures could not be analysed", all.failed, jobs.len())));
    }
    Ok(ExitCode::SUCCESS)
}

/// Analyses some pictures. A fault of one that is not alone is told, and counted.
fn lines(some: &[Job], alone: bool, args: &Args, settings: &Settings, views: &Views, warnings: &mut Warnings) -> Result<Lines> {
    let results: Vec<(Result<(Glare, Vec<Measured>)>, Warnings)> = some
        .par_iter()
        .map(|job| {
            let mut warnings = Warnings::new();
            (analyse(job, args, settings, views, &mut warnings).map_err(|e| e.file(job.name())), warnings)
        })
        .collect();
    let mut lines = Lines::default();
    for (job, (result, noted)) in some.iter().zip(results) {
        noted.iter().for_each(|w| warnings.push(w.clone()));
        match result {
            Ok((glare, _)) if args.illuminance_only => lines.table += &format!("{:.6}\n", glare.vertical_illuminance),
            Ok((glare, measured)) => {
                if glare.vertical_illuminance < 380.0 || glare.indices.dgp < 0.2 {
                    warnings.push(
                        Error::new("some pictures have less than 380 lx at the eye or a DGP below 0.2, for which DGP was not made")
                            .help("judge such scenes by contrast measures, or add -C l+"),
                    );
                }
                let name = quoted(&job.name());
                lines.table += &picture_line(&name, &glare);
                source_lines(&name, &glare, settings, &mut lines.sources);
                measured.iter().for_each(|m| part_line(&name, m, &mut lines.parts));
            }
            Err(error) if alone => return Err(error),
            Err(error) => {
                lines.failed += 1;
                eprintln!("lucarne: error: {error}");
            }
        }
    }
    Ok(lines)
}

/// Writes to standard output, which may be closed.
fn print(text: &str) -> Result<()> {
    std::io::stdout().write_all(text.as_bytes()).map_err(|e| Error::io("standard output", &e))
}

fn write(path: &Path, picture: &Picture, warnings: &mut Warnings) -> Result<()> {
    if image::is_exr(path) {
        let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
        return exr::write(path, picture, options, warnings);
    }
    image::hdr::write(path, picture)
}

fn settings(args: &Args) -> Result<Settings> {
    let task = args.task.as_ref().or(args.coloured_task.as_ref()).map(|v| TaskArea { x: v[0], y: v[1], opening_angle: v[2] });
    let low_light_correction = match args.low_light.as_str() {
        "l+" => true,
        "l-" | "0" => false,
        other => {
            return Err(Error::new(format!("'{other}' is no correction")).field("-C").help("l+ for the low-light correction, l- for none"));
        }
    };
    let dgp = match (&args.weights, args.constants) {
        (Some(w), _) => DgpModel { exponents: [w[0], w[1], w[2], w[3], w[4]], constants: [w[5], w[6], w[7]], low_light_correction },
        (None, Constants::Evalglare) => DgpModel { low_light_correction, ..DgpModel::EVALGLARE },
        (None, Constants::Original) => DgpModel { low_light_correction, ..DgpModel::ORIGINAL },
    };
    Ok(Settings {
        threshold: Threshold::from_option(args.threshold, task.is_some()),
        task,
        search_radius: args.search_radius,
        peak_limit: (!args.no_peaks).then_some(args.peak_limit),
        field_of_view: match args.field_of_view {
            None => FieldOfView::Whole,
            Some(1) => FieldOfView::Total,
            Some(_) => FieldOfView::Binocular,
        },
        position_index: [PositionIndex::Guth, PositionIndex::Kim, PositionIndex::GuthIwata][usize::from(args.position_index)],
        convention: match args.positions {
            Positions::Evalglare => Convention::Evalglare,
            Positions::Exact => Convention::Exact,
        },
        dgp,
        background: [Background::Illuminance, Background::MeanLuminance, Background::WholeIlluminance][usize::from(args.background)],
    })
}

/// Analysers by view, size and pixels; pictures of one series share theirs.
type Views = Mutex<HashMap<(String, usize, usize), Arc<Analyser>>>;

fn analyse(job: &Job, args: &Args, settings: &Settings, views: &Views, warnings: &mut Warnings) -> Result<(Glare, Vec<Measured>)> {
    let picture = job.read()?;
    let view = args.view.view_of_picture(picture.view.as_deref())?;
    let key = (view.to_options(), picture.width, picture.height);
    let analyser = {
        let mut views = views.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        match views.get(&key) {
            Some(analyser) => analyser.clone(),
            None => {
                let analyser = Arc::new(analyser(&view, &picture, settings, &job.name(), warnings)?);
                views.insert(key, analyser.clone());
                analyser
            }
        }
    };
    let mut faults = Warnings::new();
    let mut luminance = glare::detect::luminance(&picture.pixels, picture.width, &mut faults);
    faults.iter().for_each(|w| warnings.push(w.clone().file(job.name())));
    if let Some(width) = args.peak_veil {
        let width = width.unwrap_or(SUN_DIAMETER_DEG);
        glare::veil::spread_peaks(&mut luminance, analyser.geometry(), args.peak_limit, width)?;
    }
    let glare = analyser.analyse(&luminance, args.illuminance)?;
    // A veil has its own width.
    if args.peak_veil.is_none()
        && let Some(doubt) = analyser.doubt_of_coarse_sun(&luminance, &glare, args.illuminance)
    {
        warnings.push(doubt.file(job.name()));
    }
    if let Some(check) = &args.check_picture {
        let mut coloured = glare::check::check_picture(&analyser, &luminance, &glare, args.coloured_task.is_some())?;
        coloured.view = Some(view.to_options());
        write(check, &coloured, warnings)?;
    }
    let measure = |(name, option, part): (&'static str, &'static str, Part)| {
        let found = part.statistics(analyser.geometry(), &luminance).map_err(|e| e.field(option))?;
        Ok(found.map(|statistics| Measured { name, statistics }))
    };
    let measured = parts(args).into_iter().filter_map(|p| measure(p).transpose()).collect::<Result<_>>()?;
    Ok((glare, measured))
}

/// What is to be measured: its name in the table, its option.
fn parts(args: &Args) -> Vec<(&'static str, &'static str, Part)> {
    let area = |v: &[f64], opening_angle: f64| TaskArea { x: v[0], y: v[1], opening_angle };
    let mut parts: Vec<_> = args.band.iter().map(|&angle| ("band", "-B", Part::Band(angle))).collect();
    parts.extend(args.zone.iter().map(|v| ("zone 1", "-l", Part::Zone(area(v, v[2])))));
    if let Some(v) = &args.two_zones {
        parts.push(("zone 1", "-L", Part::Zone(area(v, v[2]))));
        parts.push(("zone 2", "-L", Part::Ring(v[2], area(v, v[3]))));
    }
    parts
}

fn analyser(view: &View, picture: &Picture, settings: &Settings, name: &str, warnings: &mut Warnings) -> Result<Analyser> {
    let camera = view.camera()?;
    let geometry = PixelGeometry::new(&Raster::new(camera, picture.width, picture.height)?)?;
    let squareness = picture.height as f64 / picture.width as f64 / camera.aspect();
    if (squareness - 1.0).abs() > 0.02 {
        warnings.push(
            Error::new(format!(
                "pixels are not square: {} × {} pixels for a view of {} by {} degrees",
                picture.width, picture.height, view.horizontal, view.vertical
            ))
            .file(name)
            .help("if the picture was cropped, say the angles that are left with -vh and -vv"),
        );
    }
    let analyser = Analyser::new(Arc::new(geometry), settings.clone())?;
    analyser.doubts().into_iter().for_each(|doubt| warnings.push(doubt.file(name)));
    Ok(analyser)
}
