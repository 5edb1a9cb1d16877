//! `lucarne matrix`: one phase as a Radiance matrix.

use super::matrix_args::TraceArgs;
use super::matrix_coefficients::{self, CoefficientArgs};
use super::matrix_picture::{Job, PictureArgs};
use super::matrix_sun::{self, SunArgs};
use super::progress::Terminal;
use clap::Subcommand;
use lucarne::bins::ReinhartSky;
use lucarne::gpu::Device;
use lucarne::kernels::daylight_matrix::{self, DaylightOptions};
use lucarne::kernels::image_matrix::ImageOptions;
use lucarne::kernels::trace::WindowSurfaces;
use lucarne::kernels::view_matrix::{self, ViewOptions};
use lucarne::scene::{Scene, Window, read_scene, read_sensors, read_windows};
use lucarne::simulate::inputs::mirrors;
use lucarne::{Error, Result, Warnings};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// One phase of the matrix methods.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    phase: Phase,
}

#[derive(Subcommand)]
enum Phase {
    /// View matrix V: from the windows' bins to sensors [sensor][bin].
    View(ViewArgs),
    /// Daylight matrix D: from the sky's patches to a window's bins [bin][patch], ground first.
    ///
    /// The window absorbs light that surfaces outside send back to it, unless --hole is given. Where other
    /// windows are, which this verb cannot know, the scene has holes, as for rfluxmtx; name them by
    /// --other-window, and they absorb, as all windows of a project do in `lucarne run`.
    Daylight(DaylightArgs),
    /// Sun matrix Cds: from suns through openings, panes and slats to sensors [sensor][sun].
    Sun(Box<SunArgs>),
    /// Daylight coefficients C: from the sky's patches through panes of clear glass to sensors [sensor][patch], ground
    /// first.
    ///
    /// What two-phase `rfluxmtx -I+` or `rcontrib` computes with the panes as `glass` in the scene: no bins of
    /// directions at the windows in between. Times a sky matrix it is irradiance (`dctimestep C.mtx S.mtx`,
    /// `lucarne multiply`). Panes reflect, on either side; light may leave a room and come back.
    Coefficients(Box<CoefficientArgs>),
}

/// What every phase needs.
#[derive(clap::Args)]
struct Common {
    /// Radiance scene files, materials first
    #[arg(required = true, value_name = "SCENE.rad")]
    scene: Vec<PathBuf>,

    /// Window surface with its `#@rfluxmtx` comment; normals point into the room; may be repeated
    #[arg(long, required = true, value_name = "WINDOW.rad")]
    window: Vec<PathBuf>,

    #[command(flatten)]
    trace: TraceArgs,
}

#[derive(clap::Args)]
struct ViewArgs {
    #[command(flatten)]
    common: Common,

    /// Sensors: a file of `x y z dx dy dz` lines
    #[arg(long, required_unless_present = "view", conflicts_with = "view")]
    points: Option<PathBuf>,

    #[command(flatten)]
    picture: PictureArgs,

    /// Light paths per bin and batch (default 256 for sensors, 16 for pictures)
    #[arg(short = 'c', value_name = "N")]
    light_paths: Option<u32>,

    /// Rays to the light paths' vertices, per reflection and batch: from each sensor for each bin
    /// (default 4), from each pixel for all bins (default 8)
    #[arg(long, value_name = "N")]
    visibility_rays: Option<u32>,

    /// Samples of the windows per sensor and batch
    #[arg(long, value_name = "N", default_value_t = ViewOptions::default().direct_samples)]
    direct_samples: u32,

    /// Paths per sensor (default 512) or pixel (default 16) and batch for nearby surfaces and mirrors
    #[arg(long, value_name = "N")]
    near_samples: Option<u32>,

    /// Distance (in window sizes) below which surfaces count as near; more where windows are small and far away
    #[arg(long, value_name = "D")]
    near_radius: Option<f32>,
}

#[derive(clap::Args)]
struct DaylightArgs {
    #[command(flatten)]
    common: Common,

    /// Reinhart subdivision MF:N of the sky, 1 to 6
    #[arg(short = 'm', value_name = "N", default_value_t = 1)]
    subdivision: usize,

    /// Paths per bin and batch
    #[arg(short = 'c', value_name = "N", default_value_t = DaylightOptions::default().paths)]
    paths: u32,

    /// The window is a hole, too, for light that comes back to it, which goes on in the room behind, as for
    /// rfluxmtx
    #[arg(long)]
    hole: bool,

    /// Windows of the same scene that absorb the light that meets them; may be repeated
    #[arg(long, value_name = "WINDOW.rad")]
    other_window: Vec<PathBuf>,
}

pub fn run(args: Args, warnings: &mut Warnings) -> Result<ExitCode> {
    match args.phase {
        Phase::View(args) => view(&args, warnings)?,
        Phase::Daylight(args) => daylight(&args, warnings)?,
        Phase::Sun(args) => matrix_sun::run(&args, warnings)?,
        Phase::Coefficients(args) => matrix_coefficients::run(&args, warnings)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn view(args: &ViewArgs, warnings: &mut Warnings) -> Result<()> {
    let common = &args.common;
    let (scene, windows) = common.read(&[], warnings)?;
    mirrors::warn(&scene, &windows, warnings);
    if let Some(file) = &args.picture.view {
        return picture(args, file, &scene, &windows);
    }
    let sensors = read_sensors(args.points.as_deref().expect("clap asks for points or a view"), None, warnings)?;
    let default = ViewOptions::default();
    let options = ViewOptions {
        bounces: common.trace.bounces,
        light_paths: args.light_paths.unwrap_or(default.light_paths),
        visibility_rays: args.visibility_rays.unwrap_or(default.visibility_rays),
        direct_samples: args.direct_samples,
        near_samples: args.near_samples.unwrap_or(default.near_samples),
        batches: common.trace.batches.unwrap_or(default.batches),
        seed: common.trace.seed,
        roulette_weight: common.trace.roulette_weight,
        near_radius: args.near_radius.unwrap_or(default.near_radius),
        ..default
    };
    let device = Device::open(common.trace.device.as_deref())?;
    let traced = view_matrix::compute(&device, &scene, &windows, &sensors, &options, &Terminal::new())?;
    common.trace.write(&traced)
}

fn picture(args: &ViewArgs, file: &Path, scene: &Scene, windows: &[Window]) -> Result<()> {
    let common = &args.common;
    if common.trace.direct.is_some() || common.trace.standard_error.is_some() || common.trace.ascii || common.trace.double {
        return Err(Error::new("--direct, --standard-error, -oa and -od are for sensors; a picture's view matrix is written as float")
            .help("leave them out, or use --points"));
    }
    let default = ImageOptions::default();
    let options = args.picture.apply(ImageOptions {
        bounces: common.trace.bounces,
        batches: common.trace.batches.unwrap_or(default.batches),
        light_paths: args.light_paths.unwrap_or(default.light_paths),
        visibility_rays: args.visibility_rays.unwrap_or(default.visibility_rays),
        near_samples: args.near_samples.unwrap_or(default.near_samples),
        near_radius: args.near_radius.unwrap_or(default.near_radius),
        roulette_weight: common.trace.roulette_weight,
        seed: common.trace.seed,
        ..default
    });
    let raster = args.picture.raster(file)?;
    let device = Device::open(common.trace.device.as_deref())?;
    let job = Job {
        device: &device,
        scene,
        windows,
        raster: &raster,
        options: &options,
        progress: &Terminal::new(),
        header: common.trace.header(),
    };
    job.run(common.trace.output.as_deref().filter(|p| *p != Path::new("-")))
}

fn daylight(args: &DaylightArgs, warnings: &mut Warnings) -> Result<()> {
    let common = &args.common;
    let (scene, windows) = common.read(&args.other_window, warnings)?;
    let [window] = windows.as_slice() else {
        return Err(Error::new(format!("a daylight matrix belongs to one window, but there are {}", windows.len()))
            .help("run once per window, each with its own --window file"));
    };
    let sky = ReinhartSky::new(args.subdivision).map_err(|e| e.field("-m"))?;
    let options = DaylightOptions {
        bounces: common.trace.bounces,
        paths: args.paths,
        batches: common.trace.batches.unwrap_or(DaylightOptions::default().batches),
        seed: common.trace.seed,
        roulette_weight: common.trace.roulette_weight,
        own_window: if args.hole { WindowSurfaces::Open } else { WindowSurfaces::Absorb },
        ..DaylightOptions::default()
    };
    let device = Device::open(common.trace.device.as_deref())?;
    let traced = daylight_matrix::compute(&device, &scene, window, sky, &options, &Terminal::new())?;
    common.trace.write(&traced)
}

impl Common {
    /// The scene, and the windows that the matrix is for; `others` only absorb.
    fn read(&self, others: &[PathBuf], warnings: &mut Warnings) -> Result<(Scene, Vec<Window>)> {
        let here = Path::new(".");
        let mut scene = read_scene(&self.scene, here, warnings)?;
        let mut read = |files: &[PathBuf]| -> Result<Vec<Window>> {
            let windows = files.iter().map(|file| read_windows(file, here, warnings)).collect::<Result<Vec<_>>>()?;
            Ok(windows.into_iter().flatten().collect())
        };
        let (windows, others) = (read(&self.window)?, read(others)?);
        scene.set_windows(&[windows.as_slice(), &others].concat(), warnings)?;
        Ok((scene, windows))
    }
}
