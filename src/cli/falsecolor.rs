//! `lucarne falsecolor`: luminance as colours with a legend.

use lucarne::image::falsecolor::{Contours, FalseColor};
use lucarne::image::{self, Picture, palette::Palette};
use lucarne::units::LUMINOUS_EFFICACY;
use lucarne::{Error, Result, Warnings};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Options, most of them those of Radiance's falsecolor.
#[derive(clap::Args)]
pub struct Args {
    /// Picture to colour (.hdr or .exr).
    #[arg(required_unless_present_any = ["input", "over"])]
    picture: Option<PathBuf>,
    /// The same, as an option.
    #[arg(short = 'i', value_name = "PICTURE", conflicts_with = "picture")]
    input: Option<PathBuf>,
    /// Picture to draw contours over (default: the picture itself).
    #[arg(short = 'p', value_name = "PICTURE")]
    background: Option<PathBuf>,
    /// Picture to colour and to draw contours over, as -i and -p together.
    #[arg(long = "ip", value_name = "PICTURE", conflicts_with_all = ["picture", "input", "background"])]
    over: Option<PathBuf>,
    /// Result: .png or .svg.
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    output: PathBuf,
    /// Upper end of the scale, or 'auto'.
    #[arg(short = 's', long, default_value = "auto")]
    scale: String,
    /// Logarithmic scale of so many decades.
    #[arg(long, value_name = "DECADES")]
    log: Option<f64>,
    /// Factor from radiance to the numbers of the legend.
    #[arg(short = 'm', long, default_value_t = LUMINOUS_EFFICACY)]
    multiplier: f64,
    /// Text above the legend.
    #[arg(short = 'l', long, default_value = "cd/m²")]
    label: String,
    /// Number of steps of legend and contours.
    #[arg(short = 'n', long)]
    steps: Option<usize>,
    /// viridis, cividis, gray, or Radiance's def, spec, pm3d, hot.
    #[arg(long, visible_alias = "pal", default_value = "viridis")]
    palette: String,
    /// Contour lines.
    #[arg(long, group = "contours")]
    cl: bool,
    /// Contour bands.
    #[arg(long, group = "contours")]
    cb: bool,
    /// One colour per step.
    #[arg(long, group = "contours")]
    cp: bool,
    /// Mark the darkest and the brightest pixel.
    #[arg(short = 'e', long)]
    extrema: bool,
    /// Leave the legend away.
    #[arg(long)]
    no_legend: bool,
    /// Pixels of the result per pixel of the picture (default: enlarge small pictures).
    #[arg(long)]
    zoom: Option<usize>,
}

pub fn run(args: Args, _warnings: &mut Warnings) -> Result<ExitCode> {
    let maximum = match args.scale.as_str() {
        // Radiance takes any word that begins with an a.
        word if word.starts_with(['a', 'A']) => None,
        word => {
            Some(word.parse().map_err(|_| Error::new(format!("'{word}' is no number")).field("--scale").help("give a number or 'auto'"))?)
        }
    };
    let options = FalseColor {
        palette: Palette::from_name(&args.palette)?,
        maximum,
        decades: args.log,
        multiplier: args.multiplier,
        label: args.label,
        steps: args.steps,
        contours: match (args.cl, args.cb, args.cp) {
            (true, _, _) => Contours::Lines,
            (_, true, _) => Contours::Bands,
            (_, _, true) => Contours::Posterize,
            _ => Contours::None,
        },
        legend: !args.no_legend,
        extrema: args.extrema,
        zoom: args.zoom,
    };
    // One of the three is present, or clap would have stopped.
    let path = args.picture.or(args.input).or(args.over).unwrap_or_default();
    let picture = image::read(&path)?;
    let background = args.background.as_deref().map(|p: &Path| -> Result<Picture> { image::read(p) }).transpose()?;
    let drawing = options.draw(&picture, background.as_ref()).map_err(|e| e.file(&path))?;
    drawing.write(&args.output, 1.0)?;
    Ok(ExitCode::SUCCESS)
}
