//! `lucarne matrix coefficients`: daylight coefficients of windows of clear glass.

use super::matrix_args::TraceArgs;
use super::progress::Terminal;
use lucarne::bins::ReinhartSky;
use lucarne::gpu::Device;
use lucarne::kernels::coefficients::{self, CoefficientOptions, GlazedWindow, Pane};
use lucarne::scene::{Window, read_scene, read_sensors, read_windows};
use lucarne::{Error, Result, Warnings};
use std::path::{Path, PathBuf};

/// Arguments of `lucarne matrix coefficients`.
#[derive(clap::Args)]
pub struct CoefficientArgs {
    /// Radiance scene files, materials first
    #[arg(required = true, value_name = "SCENE.rad")]
    scene: Vec<PathBuf>,

    /// Panes of the windows: polygons whose normals point into the room, of a material `glass` that the scene or
    /// this file defines; may be repeated. Left out: light comes by holes and from the open sky only
    #[arg(long, value_name = "WINDOW.rad")]
    window: Vec<PathBuf>,

    /// All windows are one pane of this transmittance at normal incidence, whatever their material: one number or
    /// three for red, green and blue
    #[arg(long, value_name = "TAU", num_args = 1..=3, value_delimiter = ',', requires = "window")]
    glass: Vec<f64>,

    /// Sensors: a file of `x y z dx dy dz` lines
    #[arg(long, value_name = "FILE")]
    points: PathBuf,

    /// Reinhart subdivision MF:N of the sky, 1 to 6
    #[arg(short = 'm', value_name = "N", default_value_t = 1)]
    subdivision: usize,

    /// Samples of the windows per sensor and batch
    #[arg(long, value_name = "N", default_value_t = CoefficientOptions::default().direct_samples)]
    direct_samples: u32,

    /// Light paths per directional bin of the windows and batch; 0: paths from the sensors only
    #[arg(short = 'c', value_name = "N", default_value_t = CoefficientOptions::default().light_paths)]
    light_paths: u32,

    /// Rays to the light paths' vertices, per reflection and batch, from each sensor for each bin
    #[arg(long, value_name = "N", default_value_t = CoefficientOptions::default().visibility_rays)]
    visibility_rays: u32,

    /// Paths per sensor and batch for nearby surfaces, mirrors, and light by no window
    #[arg(long, value_name = "N", default_value_t = CoefficientOptions::default().near_samples)]
    near_samples: u32,

    /// Distance (in window sizes) below which surfaces count as near; more where windows are small and far away
    #[arg(long, value_name = "D", default_value_t = CoefficientOptions::default().near_radius)]
    near_radius: f32,

    #[command(flatten)]
    trace: TraceArgs,
}

/// Runs the verb.
pub fn run(args: &CoefficientArgs, warnings: &mut Warnings) -> Result<()> {
    let here = Path::new(".");
    let mut scene = read_scene(&args.scene, here, warnings)?;
    let mut windows = Vec::new();
    for file in &args.window {
        windows.extend(read_windows(file, here, warnings)?);
    }
    scene.set_windows(&windows, warnings)?;
    let sensors = read_sensors(&args.points, None, warnings)?;
    let sky = ReinhartSky::new(args.subdivision).map_err(|e| e.field("-m"))?;
    let glazed = glaze(args, windows)?;
    let trace = &args.trace;
    let default = CoefficientOptions::default();
    let options = CoefficientOptions {
        bounces: trace.bounces,
        direct_samples: args.direct_samples,
        light_paths: args.light_paths,
        visibility_rays: args.visibility_rays,
        near_samples: args.near_samples,
        near_radius: args.near_radius,
        batches: trace.batches.unwrap_or(default.batches),
        seed: trace.seed,
        roulette_weight: trace.roulette_weight,
        ..default
    };
    let device = Device::open(trace.device.as_deref())?;
    let found = coefficients::compute(&device, &scene, &glazed, &sensors, sky, &options, &Terminal::new())?;
    trace.write(&found)
}

/// The panes of the windows: as the command line says, or of the material that each has as a surface.
fn glaze(args: &CoefficientArgs, windows: Vec<Window>) -> Result<Vec<GlazedWindow>> {
    let given = match args.glass[..] {
        [] => None,
        [grey] => Some([grey; 3]),
        [red, green, blue] => Some([red, green, blue]),
        _ => return Err(Error::new("a pane has one transmittance or three").field("--glass")),
    };
    if let Some(transmittance) = given {
        let pane = Pane::of_transmittance(transmittance).map_err(|e| e.field("--glass"))?;
        return Ok(windows.into_iter().map(|window| GlazedWindow { window, pane }).collect());
    }
    // Their warnings were given when they were read for themselves.
    let files = [args.scene.as_slice(), args.window.as_slice()].concat();
    let materials = read_scene(&files, Path::new("."), &mut Warnings::new())?.materials;
    let pane_of = |window: Window| {
        let material = materials.iter().rev().find(|m| m.name == window.name);
        match material.and_then(|m| Pane::of_material(&m.kind)) {
            Some(pane) => Ok(GlazedWindow { window, pane }),
            None => Err(Error::new(format!("the material '{}' of this window is no glass", window.name))
                .file(&window.origin.file)
                .line(window.origin.line)
                .help("define it by `void glass`, or say by --glass 0.65 what the pane transmits at normal incidence")),
        }
    };
    windows.into_iter().map(pane_of).collect()
}
