//! `lucarne bsdf convert`.

use lucarne::bins::AngleBasis;
use lucarne::bsdf::resample::{loss, to_klems, to_tree};
use lucarne::bsdf::{self, Block, Bsdf, iea21, interpolant};
use lucarne::{Error, Result, Warnings};
use std::path::PathBuf;
use std::process::ExitCode;

/// Changes the basis: Klems full, half, quarter or tensor tree, without losing energy.
///
/// Values become means over the new bins or cells, weighted by projected solid angle. What that
/// costs (energy, peak, RMS) is said on standard error.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  lucarne bsdf convert film.xml --to t4:5 -o film_t4.xml          # tensor tree, 2^5 cells per side\n  \
    lucarne bsdf convert film_t4.xml --to klems:full -o film.xml\n  lucarne bsdf convert film.xml --to t3:5 -o film_t3.xml          # isotropic\n  \
    lucarne bsdf convert measured/ --to klems:full -o prism.xml     # a folder of IEA 21 files\n  \
    lucarne bsdf convert through.sir back.sir --to t4:6 --reduce 97 -o fabric.xml   # interpolants of `lucarne bsdf fit`"
)]
pub struct Args {
    /// XML file; or transmission measured in the format of IEA Task 21 (Tregenza in, 5°×5° out), a file or
    /// a folder of files; or interpolants (.sir), one per component.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// klems, half, quarter (or klems:full, …), t4:N or t3:N (tensor tree of 2^N cells per side).
    #[arg(long)]
    to: String,
    /// Joins cells of a tree that differ by less than this fraction.
    #[arg(long, default_value_t = 0.0)]
    join: f64,
    /// Of an interpolant's tree: percentage of values that are joined where they differ least.
    #[arg(long)]
    reduce: Option<f64>,
    /// XML file to write; standard output if absent.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

enum Target {
    Klems(AngleBasis),
    Tree { rank: usize, log2: u32 },
}

fn target(text: &str) -> Result<Target> {
    let wrong = || Error::new(format!("'{text}' is not a basis")).field("--to").help("klems:full, klems:half, klems:quarter, t4:5 or t3:5");
    let text = match text {
        "klems" => "klems:full",
        "half" => "klems:half",
        "quarter" => "klems:quarter",
        other => other,
    };
    let (kind, detail) = text.split_once(':').ok_or_else(wrong)?;
    match kind {
        "klems" => Ok(Target::Klems(super::klems_basis(detail)?)),
        "t3" | "t4" => Ok(Target::Tree { rank: if kind == "t3" { 3 } else { 4 }, log2: detail.parse().map_err(|_| wrong())? }),
        _ => Err(wrong()),
    }
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let target = target(&args.to)?;
    let [file] = &args.files[..] else {
        if let Some(other) = args.files.iter().find(|f| !interpolant::is_interpolant(f)) {
            return Err(Error::new("only interpolants (.sir) are put together").file(other).help("convert one XML file at a time"));
        }
        return of_interpolants(args, &target, warnings);
    };
    if interpolant::is_interpolant(file) {
        return of_interpolants(args, &target, warnings);
    }
    if args.reduce.is_some() {
        return Err(Error::new("only trees of interpolants (.sir) are reduced").field("--reduce").help("use --join"));
    }
    let source = if iea21::is_iea21(file) { iea21::read(file)? } else { bsdf::read(file, warnings)? };
    let mut converted: Bsdf = source.clone();
    let mut report = String::new();
    for (band, blocks) in source.bands() {
        for (component, block) in blocks.iter() {
            let new = match &target {
                Target::Klems(basis) => Block::Klems(to_klems(block, basis, basis)),
                Target::Tree { rank, log2 } => Block::Tree(to_tree(block, *rank, *log2, args.join)?),
            };
            let cost = loss(block, &new);
            report += &format!(
                "{band} {}: hemispherical {:.5} ({:+.1e}), peak × {:.3}, RMS change {:.3}/sr of {:.3}/sr\n",
                component.xml_name(),
                new.hemispherical(),
                cost.hemispherical,
                cost.peak,
                cost.rms,
                cost.rms_of_source
            );
            if let Some(slot) = converted.band_mut(band) {
                *slot.slot(component) = Some(new);
            }
        }
    }
    bsdf::write(args.output.as_deref(), &converted, &super::made_by())?;
    eprint!("{report}");
    Ok(ExitCode::SUCCESS)
}

/// Writes interpolants as one file, and says what each step cost.
fn of_interpolants(args: &Args, target: &Target, warnings: &mut Warnings) -> Result<ExitCode> {
    if args.join != 0.0 {
        return Err(Error::new("cells of an interpolant's tree are joined by --reduce").field("--join"));
    }
    let mut bsdf = Bsdf { device_type: "Other".into(), ..Bsdf::default() };
    let mut report = String::new();
    for path in &args.files {
        let source = interpolant::read(path, warnings)?;
        if bsdf.visible.slot(source.component).is_some() {
            return Err(Error::new(format!("{} comes twice", source.component.xml_name())).file(path));
        }
        let block = match target {
            Target::Klems(_) if args.reduce.is_some() => {
                return Err(Error::new("only trees are reduced").field("--reduce"));
            }
            Target::Klems(basis) => Block::Klems(interpolant::to_klems(&source, basis, basis)),
            Target::Tree { rank, log2 } => {
                if *rank == 3 && source.symmetry != interpolant::Symmetry::Isotropic {
                    warnings.push(
                        Error::new(format!("the sample is {}, a tree of rank 3 is its mean over all azimuths", source.symmetry.name()))
                            .file(path)
                            .help("use t4:N"),
                    );
                }
                Block::Tree(interpolant::to_tree(&source, *rank, *log2, args.reduce.unwrap_or(0.0)).map_err(|e| e.file(path))?)
            }
        };
        report += &cost(&source, &block);
        *bsdf.visible.slot(source.component) = Some(block);
        if bsdf.name.is_empty() {
            (bsdf.name, bsdf.manufacturer) = (source.name.clone(), source.manufacturer.clone());
        }
    }
    bsdf::write(args.output.as_deref(), &bsdf, &super::made_by())?;
    eprint!("{report}");
    Ok(ExitCode::SUCCESS)
}

/// What a tree or matrix keeps of its interpolant, in words.
fn cost(source: &interpolant::Interpolant, block: &Block) -> String {
    // Both hemispherical values by the same directions: the middles of a fine tree's cells.
    const SIDE: usize = 24;
    let at = |k: usize| (k as f64 + 0.5) / SIDE as f64;
    let light = |k: usize| {
        let [x, y] = lucarne::bins::shirley_chiu::disk_from_square(at(k / SIDE), at(k % SIDE));
        glam::DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
    };
    let of_lobes = (0..SIDE * SIDE).map(|k| source.direct_hemispherical(light(k))).sum::<f64>() / (SIDE * SIDE) as f64;
    let mut text = format!(
        "{}: hemispherical {:.5}, of the interpolant {of_lobes:.5} ({:+.2} %); {}\n",
        source.component.xml_name(),
        block.hemispherical(),
        100.0 * (block.hemispherical() / of_lobes.max(1e-30) - 1.0),
        match block {
            Block::Tree(tree) => format!("{}, {} values", block.describe(), tree.len()),
            Block::Klems(_) => block.describe(),
        }
    );
    if !source.component.is_transmission()
        && let Block::Klems(m) = block
    {
        let reversed = m.reversed();
        let (mut difference, mut square) = (0.0, 0.0);
        for (a, b) in m.values().iter().zip(reversed.values()) {
            (difference, square) = (difference + (a - b).powi(2), square + a * a);
        }
        text += &format!(
            "{}: reciprocal to {:.1} % (RMS)\n",
            source.component.xml_name(),
            100.0 * (difference / f64::max(square, 1e-30)).sqrt()
        );
    }
    text
}
