//! `lucarne bsdf generate`: the BSDF of a shade from its geometry (as genBSDF).

mod genbsdf;
mod parametric;
mod screen;
mod store;

use super::made_by;
use crate::cli::progress::Terminal;
use lucarne::bins::KlemsBasis;
use lucarne::bsdf::{self, Blocks, Bsdf, Component, Geometry};
use lucarne::gpu::Device;
use lucarne::kernels::bsdf_generation::{Directions, GenerationOptions, GenerationStatistics, Method, Sample, Table, generate, mgf};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, write_matrix};
use lucarne::scene::gltf::{Options as GltfOptions, UpAxis};
use lucarne::scene::read_scene_with;
use lucarne::{Error, Result, Warnings};
use parametric::{unit, venetian};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use store::Store;

const EXAMPLES: &str = "\
Examples:
  lucarne bsdf generate blinds_device.rad -o blinds.xml
  lucarne bsdf generate -t4 5 blinds_device.rad -o blinds_t4.xml
  lucarne bsdf generate --venetian width=25mm,spacing=20mm,angle=20,reflectance=0.5 -o venetian.xml
  lucarne bsdf generate --perforated diameter=2mm,spacing=4mm,thickness=0.5mm,reflectance=0.6 -o holes.xml
  lucarne bsdf generate --woven diameter=0.5mm,spacing=1mm,reflectance=0.6 -o woven.xml

Position: +Z into the room, +Y up, the device behind z = 0 (glTF: the same). Front is the outside (WINDOW).
Command lines of genBSDF work. Unlike there, both directions are made unless -f or -b leaves one out,
diffuse reflections are not truncated without -ab, and geometry is embedded only with --geometry or +geom.";

/// Generates a BSDF from the geometry of a shade or device.
#[derive(clap::Args, Clone)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Files of the device: Radiance, materials first, or glTF in its own axes (+f, -f, +b, -b as in genBSDF)
    #[arg(value_name = "DEVICE.rad")]
    files: Vec<PathBuf>,

    /// Horizontal slats instead: width, spacing, angle (degrees; positive: ground seen from the room),
    /// reflectance; also rise or curvature (radius), thickness, transmittance, specularity, roughness, and
    /// solar_reflectance, solar_transmittance, which give the file solar data too
    #[arg(long, value_name = "KEY=VALUE,...", conflicts_with = "files")]
    venetian: Option<String>,

    /// Perforated screen by WINDOW's model instead: diameter (or width and height) of the holes, spacing
    /// (or spacing_x and spacing_y), thickness, reflectance, transmittance
    #[arg(long, value_name = "KEY=VALUE,...", conflicts_with_all = ["files", "venetian"])]
    perforated: Option<String>,

    /// Woven shade by WINDOW's model instead: diameter and spacing of the threads, reflectance
    #[arg(long, value_name = "KEY=VALUE,...", conflicts_with_all = ["files", "venetian", "perforated"])]
    woven: Option<String>,

    /// XML file; standard output if absent
    #[arg(short = 'o', value_name = "FILE.xml")]
    output: Option<PathBuf>,

    /// Klems basis: full, half or quarter
    #[arg(long, default_value = "full", value_name = "NAME")]
    basis: String,

    /// Isotropic tensor tree of rank 3 with 2^N cells per side
    #[arg(long = "t3", value_name = "N", conflicts_with = "tree4")]
    tree3: Option<u32>,

    /// Anisotropic tensor tree of rank 4 with 2^N cells per side
    #[arg(long = "t4", value_name = "N")]
    tree4: Option<u32>,

    /// Per cent of the tree's finest parts to join where they vary least; none below 0
    #[arg(short = 't', value_name = "PERCENT", default_value_t = 90.0, allow_negative_numbers = true)]
    cull: f64,

    /// Samples per incident direction
    #[arg(short = 'c', value_name = "N", default_value_t = GenerationOptions::default().samples)]
    samples: u32,

    /// Box from which light starts, instead of the geometry's: xmin xmax ymin ymax zmin zmax
    #[arg(long, num_args = 6, allow_negative_numbers = true, value_names = ["XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"])]
    dim: Option<Vec<f64>>,

    /// The box is one period of an endless device along x, y or xy
    #[arg(long, value_name = "AXES")]
    periodic: Option<String>,

    /// Most diffuse reflections; left out: not truncated
    #[arg(long = "ab", value_name = "N")]
    bounces: Option<u32>,

    /// Weight below which Russian roulette ends paths
    #[arg(long = "lw", value_name = "WEIGHT", default_value_t = GenerationOptions::default().roulette_weight)]
    roulette_weight: f32,

    /// Leave out light from the outside (front)
    #[arg(short = 'f', long = "no-front", alias = "forward", conflicts_with = "no_back")]
    no_front: bool,

    /// Leave out light from the room (back)
    #[arg(short = 'b', long = "no-back", alias = "backward")]
    no_back: bool,

    /// Helmholtz reciprocity: average (light and its way back), keep, or auto: average for trees and
    /// periodic devices, whose light never leaves over the sides of a box
    #[arg(long, default_value = "auto", value_name = "HOW")]
    reciprocity: String,

    /// How light is followed: auto, paths or chains
    #[arg(long, default_value = "auto", value_name = "METHOD")]
    method: String,

    /// Write the data as Solar too: for materials that are as bright in the sun's spectrum
    #[arg(long)]
    solar: bool,

    /// Embed the geometry (MGF) in the file
    #[arg(long)]
    geometry: bool,

    /// Unit of the files' lengths: m, cm, mm, in or ft
    #[arg(long, default_value = "m", value_name = "UNIT")]
    unit: String,

    /// Name of the device in the file
    #[arg(long, value_name = "TEXT")]
    name: Option<String>,

    /// Manufacturer in the file
    #[arg(long, value_name = "TEXT", default_value = "")]
    manufacturer: String,

    /// Also write the standard error of each entry, 1/sr, as a Radiance matrix: the four components of
    /// WINDOW's order below each other, rows outgoing, columns incident
    #[arg(long, value_name = "FILE.mtx")]
    standard_error: Option<PathBuf>,

    /// Independent repetitions, whose spread is the standard error
    #[arg(long, default_value_t = GenerationOptions::default().batches, value_name = "N")]
    batches: u32,

    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u32,

    /// Device: index or part of its name (see `lucarne devices`)
    #[arg(long)]
    device: Option<String>,

    #[command(flatten)]
    genbsdf: genbsdf::GenBsdfOptions,
}

/// How often the sums are kept for going on after an interruption.
const KEEP_EVERY: Duration = Duration::from_secs(20);
/// Most cells per side, as a power of two: the table of sums must fit into memory.
const MOST_TREE4: u32 = 6;
const MOST_TREE3: u32 = 8;

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let args = &genbsdf::translated(args.clone(), warnings)?;
    let directions = args.directions()?;
    let (no_front, no_back) = (args.no_front, args.no_back);
    if no_front && no_back {
        return Err(Error::new("both directions are left out").help("drop -f or -b"));
    }
    if let Some(screen) = args.screen()? {
        return args.write_screen(&screen, directions, [no_front, no_back]);
    }
    let sample = args.sample(warnings)?;
    let options = args.options(directions, &sample)?;
    let metres = unit(&args.unit)?;
    let device = Device::open(args.device.as_deref())?;
    let terminal = Terminal::new();
    let start = Instant::now();
    let mut traced = vec![trace(args, &device, directions, &options, &sample, "", &terminal, warnings)?];
    if let Some(solar) = args.solar_sample(warnings)? {
        traced.push(trace(args, &device, directions, &options, &solar, ".solar", &terminal, warnings)?);
    }
    terminal.finish();
    let (table, solar) = (&traced[0].table, traced.get(1).map(|t| &t.table));
    let bsdf = args.bsdf(&sample, [Some(table), solar], [no_front, no_back], metres);
    let command = made_by();
    bsdf::write(args.output.as_deref(), &bsdf, &command)?;
    if let Some(path) = &args.standard_error {
        write_errors(path, table, &command)?;
    }
    traced.iter().for_each(|t| t.store.remove());
    report(table, &traced[0].statistics, start.elapsed(), &bsdf.visible);
    Ok(ExitCode::SUCCESS)
}

/// A finished table, and where its batches were kept.
struct Traced {
    table: Table,
    statistics: GenerationStatistics,
    store: Store,
}

#[allow(clippy::too_many_arguments, reason = "what the two bands share")]
fn trace(
    args: &Args,
    device: &Device,
    directions: Directions,
    options: &GenerationOptions,
    sample: &Sample,
    suffix: &str,
    terminal: &Terminal,
    warnings: &mut Warnings,
) -> Result<Traced> {
    let store = Store::new(args, directions, options, sample, suffix);
    let mut table = store.load(directions, warnings);
    if table.batches() > 0 {
        eprintln!("going on after {} of {} batches", table.batches(), options.batches);
    }
    let mut kept = Instant::now();
    let found = generate(device, sample, &mut table, options, terminal, warnings, &mut |table| {
        if kept.elapsed() > KEEP_EVERY {
            kept = Instant::now();
            store.save(table)?;
        }
        Ok(())
    });
    // Whatever ended it, finished batches need not be traced again.
    if found.is_err() && table.batches() > 0 {
        store.save(&table)?;
    }
    Ok(Traced { table, statistics: found?, store })
}

impl Args {
    fn directions(&self) -> Result<Directions> {
        let within = |n: u32, most: u32, option: &str| {
            if (1..=most).contains(&n) {
                return Ok(n);
            }
            Err(Error::new(format!("2^{n} cells per side are out of range")).field(option).help(format!("choose 1 to {most}")))
        };
        if self.cull.is_nan() || self.cull >= 100.0 {
            return Err(Error::new(format!("{} is no percentage below 100", self.cull)).field("-t"));
        }
        match (self.tree3, self.tree4) {
            (Some(n), _) => Ok(Directions::Tree3(within(n, MOST_TREE3, "-t3")?)),
            (_, Some(n)) => Ok(Directions::Tree4(within(n, MOST_TREE4, "-t4")?)),
            _ => match self.basis.to_ascii_lowercase().as_str() {
                "full" | "kf" => Ok(Directions::Klems(KlemsBasis::Full)),
                "half" | "kh" => Ok(Directions::Klems(KlemsBasis::Half)),
                "quarter" | "kq" => Ok(Directions::Klems(KlemsBasis::Quarter)),
                other => Err(Error::new(format!("'{other}' is no Klems basis")).field("--basis").help("choose full, half or quarter")),
            },
        }
    }

    fn options(&self, directions: Directions, sample: &Sample) -> Result<GenerationOptions> {
        let average_reciprocal = match self.reciprocity.as_str() {
            "average" => true,
            "keep" => false,
            "auto" => !matches!(directions, Directions::Klems(_)) || sample.repeats == [true, true],
            other => return Err(Error::new(format!("'{other}' is unknown")).field("--reciprocity").help("choose auto, average or keep")),
        };
        let method = match self.method.as_str() {
            "auto" => Method::Best,
            "paths" => Method::Paths,
            "chains" => Method::Chains,
            other => return Err(Error::new(format!("'{other}' is unknown")).field("--method").help("choose auto, paths or chains")),
        };
        Ok(GenerationOptions {
            samples: self.samples,
            batches: self.batches,
            bounces: self.bounces,
            seed: self.seed,
            roulette_weight: self.roulette_weight,
            average_reciprocal,
            method,
        })
    }

    fn sample(&self, warnings: &mut Warnings) -> Result<Sample> {
        if let Some(text) = &self.venetian {
            if self.dim.is_some() || self.periodic.is_some() {
                return Err(Error::new("slats made by --venetian have their own box, which repeats").help("leave out -dim and --periodic"));
            }
            return venetian(text, false, warnings).map_err(|e| e.field("--venetian"));
        }
        if self.files.is_empty() {
            return Err(Error::new("there is no device").help("name its Radiance files, or give --venetian"));
        }
        let repeats = match self.periodic.as_deref() {
            None => [false, false],
            Some("x") => [true, false],
            Some("y") => [false, true],
            Some("xy" | "yx") => [true, true],
            Some(other) => return Err(Error::new(format!("'{other}' names no axes")).field("--periodic").help("choose x, y or xy")),
        };
        // glTF's own axes are those of a device: +Y up, +Z towards who looks at it.
        let axes = GltfOptions { up: UpAxis::Z, scale: 1.0 };
        let scene = read_scene_with(&self.files, Path::new("."), &axes, warnings)?;
        let dim = self.dim.as_deref().and_then(|d| <[f64; 6]>::try_from(d).ok());
        Sample::new(scene, dim, repeats, warnings)
    }

    /// The slats of `--venetian` as the sun sees them, if that is said.
    fn solar_sample(&self, warnings: &mut Warnings) -> Result<Option<Sample>> {
        match self.venetian.as_deref().filter(|text| text.contains("solar_")) {
            Some(_) if self.solar => Err(Error::new("the slats have solar values of their own")
                .field("--solar")
                .help("leave out --solar, or the solar_… values")),
            Some(text) => venetian(text, true, warnings).map(Some).map_err(|e| e.field("--venetian")),
            None => Ok(None),
        }
    }

    fn bsdf(&self, sample: &Sample, tables: [Option<&Table>; 2], leave_out: [bool; 2], metres: f64) -> Bsdf {
        let scale = if self.venetian.is_some() { 1.0 } else { metres };
        let stem = self.files.last().or(self.output.as_ref()).and_then(|p| p.file_stem()).map(|s| s.to_string_lossy().to_string());
        let name = self.name.clone().or(if self.venetian.is_some() { Some("venetian blind".into()) } else { stem });
        let size = sample.high - sample.low;
        let mut bsdf = Bsdf {
            name: name.unwrap_or_default(),
            manufacturer: self.manufacturer.clone(),
            device_type: if self.venetian.is_some() { "Venetian Blind".into() } else { "Other".into() },
            thickness: Some(sample.thickness() * scale),
            width: Some(size.x * scale),
            height: Some(size.y * scale),
            ..Bsdf::default()
        };
        let wanted = |c: &Component| !leave_out[usize::from(!c.is_front())];
        for (blocks, table) in [&mut bsdf.visible, &mut bsdf.solar].into_iter().zip(tables) {
            for component in Component::ALL.into_iter().filter(wanted) {
                *blocks.slot(component) = table.map(|t| t.block(component, self.cull.max(0.0)));
            }
        }
        if self.solar {
            bsdf.solar = bsdf.visible.clone();
        }
        if self.geometry {
            bsdf.geometry = Some(Geometry { format: "MGF".into(), unit: "meter".into(), text: mgf::text(&sample.scene, scale) });
        }
        bsdf
    }
}

fn write_errors(path: &Path, table: &Table, command: &str) -> Result<()> {
    let d = table.directions();
    let mut errors = Matrix::<f32>::zeros(4 * d.outgoing(), d.incident(), 1);
    let rows = Component::ALL.into_iter().flat_map(|c| (0..d.outgoing()).map(move |o| (c, o)));
    for ((component, o), row) in rows.zip(errors.data_mut().chunks_exact_mut(d.incident())) {
        for (i, v) in row.iter_mut().enumerate() {
            *v = table.standard_error(component, o, i) as f32;
        }
    }
    let names = Component::ALL.map(Component::xml_name).join(", ");
    let header = [
        command.to_string(),
        format!("SOFTWARE= Lucarne {}", env!("CARGO_PKG_VERSION")),
        format!("CONTENT= standard errors in 1/sr of {names}"),
    ];
    write_matrix(Some(path), &errors, Format::Float, &header)
}

fn report(table: &Table, statistics: &GenerationStatistics, time: Duration, blocks: &Blocks) {
    for (component, _) in blocks.iter() {
        eprintln!(
            "{:<19} hemispherical {:.4}, standard error of an entry {:.1} % (root mean squares)",
            component.xml_name(),
            table.hemispherical(component),
            100.0 * table.relative_error(component)
        );
    }
    let seconds = time.as_secs_f64().max(1e-9);
    if statistics.paths > 0 {
        eprintln!("{seconds:.1} s, {:.1} million rays/s", statistics.segments as f64 / seconds / 1e6);
    }
}
