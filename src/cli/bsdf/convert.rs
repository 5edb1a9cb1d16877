//! `lucarne bsdf convert`.

use lucarne::bins::AngleBasis;
use lucarne::bsdf::resample::{loss, to_klems, to_tree};
use lucarne::bsdf::{self, Block, Bsdf, iea21};
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
    lucarne bsdf convert measured/ --to klems:full -o prism.xml     # a folder of IEA 21 files"
)]
pub struct Args {
    /// XML file; or transmission measured in the format of IEA Task 21 (Tregenza in, 5°×5° out), a file or
    /// a folder of files.
    file: PathBuf,
    /// klems:full, klems:half, klems:quarter, t4:N or t3:N (tensor tree of 2^N cells per side).
    #[arg(long)]
    to: String,
    /// Joins cells of a tree that differ by less than this fraction.
    #[arg(long, default_value_t = 0.0)]
    join: f64,
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
    let (kind, detail) = text.split_once(':').ok_or_else(wrong)?;
    match kind {
        "klems" => Ok(Target::Klems(super::klems_basis(detail)?)),
        "t3" | "t4" => Ok(Target::Tree { rank: if kind == "t3" { 3 } else { 4 }, log2: detail.parse().map_err(|_| wrong())? }),
        _ => Err(wrong()),
    }
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let target = target(&args.to)?;
    let source = if iea21::is_iea21(&args.file) { iea21::read(&args.file)? } else { bsdf::read(&args.file, warnings)? };
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
