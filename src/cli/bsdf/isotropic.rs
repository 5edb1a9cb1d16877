//! `lucarne bsdf isotropic`.

use lucarne::bsdf::isotropic::{AngularTable, Sample};
use lucarne::bsdf::{self, Blocks, Bsdf};
use lucarne::{Error, Result, Warnings, text};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Klems XML of an isotropic material from direct and diffuse values over the angle (as iso2klems).
///
/// The table has rows of: angle of incidence in degrees, Ts, Td, Rs, Rd (specular and diffuse
/// transmittance and reflectance). 0-90: light from the outside (front); 90-180, optional: light
/// from the room, 180 being its normal. '#' starts a comment.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  lucarne bsdf isotropic table.dat -o film.xml\n  \
    lucarne bsdf isotropic visible.dat --solar solar.dat --name \"film 7\" -o film.xml\n  \
    lucarne bsdf isotropic --normal .60,.10,.08,.05 --panes 2 --category 4 -o pane.xml   # Roos model")]
pub struct Args {
    /// Table of visible values.
    #[arg(required_unless_present = "normal")]
    table: Option<PathBuf>,
    /// Table of solar values, written into the same file.
    #[arg(long)]
    solar: Option<PathBuf>,
    /// Instead of a table: Ts,Td,Rs,Rd at normal incidence, extended by the model of Roos et al. 2001.
    #[arg(long, conflicts_with = "table", value_delimiter = ',', num_args = 1)]
    normal: Option<Vec<f64>>,
    /// Rs,Rd at normal incidence from the room, if they differ.
    #[arg(long, requires = "normal", value_delimiter = ',', num_args = 1)]
    back: Option<Vec<f64>>,
    /// Solar Ts,Td,Rs,Rd at normal incidence, written into the same file.
    #[arg(long, requires = "normal", value_delimiter = ',', num_args = 1)]
    solar_normal: Option<Vec<f64>>,
    /// Number of panes p of the Roos model.
    #[arg(long, default_value_t = 1)]
    panes: u32,
    /// Category q of the Roos model: 4 for uncoated glass.
    #[arg(long, default_value_t = 4.0)]
    category: f64,
    /// Klems basis: full, half or quarter.
    #[arg(long, default_value = "full")]
    basis: String,
    /// Name of the material.
    #[arg(long, default_value = "isotropic material")]
    name: String,
    /// Thickness, m.
    #[arg(long)]
    thickness: Option<f64>,
    /// XML file to write; standard output if absent.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let basis = super::klems_basis(&args.basis)?;
    let from_file = |path: &Path, warnings: &mut Warnings| -> Result<Blocks> {
        let text = text::read(path, "a table of angular values")?;
        let table = AngularTable::parse(&text, warnings).map_err(|e| e.file(path))?;
        Ok(table.to_blocks(&basis, warnings))
    };
    let from_normal = |front: &[f64], warnings: &mut Warnings| -> Result<Blocks> {
        let [ts, td, rs, rd] = front else { return Err(Error::new("four values are needed: Ts,Td,Rs,Rd").field("--normal")) };
        let front = Sample {
            theta: 0.0,
            specular_transmittance: *ts,
            diffuse_transmittance: *td,
            specular_reflectance: *rs,
            diffuse_reflectance: *rd,
        };
        let back = match args.back.as_deref() {
            Some([rs, rd]) => Sample { specular_reflectance: *rs, diffuse_reflectance: *rd, ..front },
            _ => front,
        };
        Ok(AngularTable::roos(front, back, args.panes, args.category, warnings)?.to_blocks(&basis, warnings))
    };
    let mut bsdf = Bsdf { name: args.name.clone(), thickness: args.thickness, ..Bsdf::default() };
    match (&args.table, &args.normal) {
        (Some(table), _) => bsdf.visible = from_file(table, warnings)?,
        (None, Some(normal)) => bsdf.visible = from_normal(normal, warnings)?,
        (None, None) => return Err(Error::new("give a table, or --normal")),
    }
    if let Some(table) = &args.solar {
        bsdf.solar = from_file(table, warnings)?;
    }
    if let Some(normal) = &args.solar_normal {
        bsdf.solar = from_normal(normal, warnings)?;
    }
    bsdf::write(args.output.as_deref(), &bsdf, &super::made_by())?;
    Ok(ExitCode::SUCCESS)
}
