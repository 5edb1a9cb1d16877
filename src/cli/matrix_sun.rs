//! `lucarne matrix sun`: the sun matrix Cds.

use super::progress::Terminal;
use lucarne::bins::ReinhartSky;
use lucarne::gpu::Device;
use lucarne::kernels::sun_matrix::{Openings, Sun, SunOptions, compute};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, write_matrix};
use lucarne::scene::{read_scene, read_sensors, read_windows};
use lucarne::simulate::{inputs::suns::SunSet, project::method::SunScheme};
use lucarne::weather::Weather;
use lucarne::{Error, Result, Warnings};
use std::path::{Path, PathBuf};

/// Arguments of `lucarne matrix sun`.
#[derive(clap::Args)]
pub struct SunArgs {
    /// Radiance scene files, materials first; slats and panes that the sun shines through among them
    #[arg(required = true, value_name = "SCENE.rad")]
    scene: Vec<PathBuf>,

    /// Sensors: a file of `x y z dx dy dz` lines
    #[arg(long, value_name = "FILE")]
    points: PathBuf,

    /// Radiance file of `source` suns: one column each, in their order
    #[arg(long, value_name = "SUNS.rad", required_unless_present = "weather", conflicts_with_all = ["weather", "subdivision"])]
    suns: Option<PathBuf>,

    /// Suns at the centres of the patches of Reinhart's MF:N (a column for each, 0 the ground)
    #[arg(short = 'm', value_name = "N", requires = "weather")]
    subdivision: Option<usize>,

    /// Weather file: only suns that occur in it are traced, the columns of all others are zero
    #[arg(long, value_name = "FILE")]
    weather: Option<PathBuf>,

    /// With --weather and without -m: a column for each real position of the sun
    #[arg(long, requires = "weather", conflicts_with = "subdivision")]
    hourly: bool,

    /// Window surface; only light through its polygons counts (otherwise wherever the scene is open). Windows
    /// absorb light that meets them from outside
    #[arg(long, value_name = "WINDOW.rad")]
    window: Vec<PathBuf>,

    /// Most diffuse bounces; 0 is direct light only
    #[arg(long = "ab", value_name = "N", default_value_t = 0)]
    bounces: u32,

    /// Suns are points at the centres of their discs
    #[arg(long)]
    point_suns: bool,

    /// Points of each sun's disc per batch
    #[arg(long, value_name = "N", default_value_t = SunOptions::default().disc_samples)]
    disc_samples: u32,

    /// Paths to scattering surfaces per sensor and batch, shared by all suns
    #[arg(short = 'c', value_name = "N", default_value_t = SunOptions::default().paths)]
    paths: u32,

    /// Independent repetitions, whose spread is the standard error
    #[arg(long, value_name = "N", default_value_t = SunOptions::default().batches)]
    batches: u32,

    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u32,

    /// Matrix file; standard output if absent
    #[arg(short = 'o', value_name = "FILE")]
    output: Option<PathBuf>,

    /// Also write the standard error of each entry
    #[arg(long, value_name = "FILE")]
    standard_error: Option<PathBuf>,

    /// Write numbers as text
    #[arg(long = "oa", conflicts_with = "double")]
    ascii: bool,

    /// Write 64-bit numbers
    #[arg(long = "od")]
    double: bool,

    /// Device: index or part of its name (see `lucarne devices`)
    #[arg(long)]
    device: Option<String>,
}

/// The suns to trace, and the column of each among all.
struct Suns {
    suns: Vec<Sun>,
    columns: Vec<usize>,
    all_columns: usize,
}

/// Runs the verb.
pub fn run(args: &SunArgs, warnings: &mut Warnings) -> Result<()> {
    let here = Path::new(".");
    let mut scene = read_scene(&args.scene, here, warnings)?;
    let sensors = read_sensors(&args.points, None, warnings)?;
    let mut windows = Vec::new();
    for file in &args.window {
        windows.extend(read_windows(file, here, warnings)?);
    }
    scene.set_windows(&windows, warnings)?;
    let chosen = match (&args.suns, &args.weather) {
        (Some(file), _) => from_file(file, warnings)?,
        (None, Some(weather)) => from_weather(args, weather, &windows, warnings)?,
        (None, None) => return Err(Error::new("no suns are named").field("--suns").help("give --suns FILE, or --weather FILE with -m 6")),
    };
    let suns: Vec<Sun> = chosen.suns.iter().map(|s| if args.point_suns { s.as_point() } else { *s }).collect();
    let options = SunOptions {
        disc_samples: if args.point_suns { 1 } else { args.disc_samples },
        paths: args.paths,
        bounces: Some(args.bounces),
        batches: args.batches,
        seed: args.seed,
        ..SunOptions::default()
    };
    let openings = if windows.is_empty() { Openings::Anywhere } else { Openings::Windows(&windows) };
    let device = Device::open(args.device.as_deref())?;
    let terminal = Terminal::new();
    let found = compute(&device, &scene, openings, &sensors, &suns, &options, &terminal)?;
    terminal.finish();
    let format = match (args.ascii, args.double) {
        (true, _) => Format::Ascii,
        (_, true) => Format::Double,
        _ => Format::Float,
    };
    let header = vec![std::env::args().collect::<Vec<_>>().join(" "), format!("SOFTWARE= Lucarne {}", env!("CARGO_PKG_VERSION"))];
    if let Some(file) = &args.standard_error {
        write_matrix(Some(file), &spread(&found.standard_error(), &chosen), format, &header)?;
    }
    write_matrix(args.output.as_deref().filter(|p| *p != Path::new("-")), &spread(&found.total, &chosen), format, &header)
}

fn from_file(file: &Path, warnings: &mut Warnings) -> Result<Suns> {
    let scene = read_scene(&[file.to_path_buf()], Path::new("."), warnings)?;
    if scene.sources.is_empty() {
        return Err(Error::new("there is no sun in this file")
            .file(file)
            .help("write each as: void light sol 0 0 3 1 1 1, then sol source sun 0 0 4 dx dy dz 0.533"));
    }
    let mut suns = Vec::new();
    for source in &scene.sources {
        if !(0.0..=90.0).contains(&source.angle) {
            return Err(Error::new(format!("source '{}' of {}° is no sun", source.name, source.angle))
                .file(file)
                .help("a sun is a disc of at most 90°; the real one has 0.533"));
        }
        suns.push(Sun { direction: source.direction, radius: (source.angle / 2.0).to_radians() });
    }
    Ok(Suns { columns: (0..suns.len()).collect(), all_columns: suns.len(), suns })
}

fn from_weather(args: &SunArgs, weather: &Path, windows: &[lucarne::scene::Window], warnings: &mut Warnings) -> Result<Suns> {
    let weather = Weather::read(weather, warnings)?;
    let scheme = if args.hourly {
        SunScheme::HOURLY
    } else {
        let subdivision = args.subdivision.unwrap_or(SunScheme::DEFAULT_SUBDIVISION);
        SunScheme::Patches(ReinhartSky::new(subdivision).map_err(|e| e.field("-m"))?)
    };
    let set = SunSet::new(&weather, scheme, windows)?;
    let c = &set.census;
    eprintln!(
        "lucarne: {} of {} suns ({}): {} never occur, {} are behind every window",
        c.needed, c.all, c.scheme, c.never, c.behind_windows
    );
    Ok(Suns { suns: set.suns, columns: set.columns, all_columns: set.all_columns })
}

/// The matrix with all columns, those of suns left out zero.
fn spread(matrix: &Matrix<f32>, suns: &Suns) -> Matrix<f32> {
    if suns.columns.len() == suns.all_columns {
        return matrix.clone();
    }
    let mut all = Matrix::zeros(matrix.rows(), suns.all_columns, 3);
    for row in 0..matrix.rows() {
        for (i, &column) in suns.columns.iter().enumerate() {
            all.at_mut(row, column).copy_from_slice(matrix.at(row, i));
        }
    }
    all
}
