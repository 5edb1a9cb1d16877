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
/// from the room, 180 being its normal. '#' starts a comment. A first line without numbers names
/// the columns, in any order: ",Ts,Td,Rs,Rd". If Rs and Rd are dummy values, --reflectance replaces
/// them: over the angle, absorptance and diffuse reflectance follow the transmittance, and mirror
/// reflection takes the rest.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  lucarne bsdf isotropic table.dat -o film.xml\n  \
    lucarne bsdf isotropic visible.dat --solar solar.dat --name \"film 7\" -o film.xml\n  \
    lucarne bsdf isotropic visible.csv --reflectance .08,.03 --solar solar.csv --solar-reflectance .09,.03 -o film.xml\n  \
    lucarne bsdf isotropic --normal .60,.10,.08,.05 --panes 2 --category 4 -o pane.xml   # Roos model")]
pub struct Args {
    /// Table of visible values.
    #[arg(required_unless_present = "normal")]
    table: Option<PathBuf>,
    /// Table of solar values, written into the same file.
    #[arg(long)]
    solar: Option<PathBuf>,
    /// Visible Rs,Rd at normal incidence in place of those of the table.
    #[arg(long, requires = "table", group = "visible_normal", value_delimiter = ',', num_args = 1)]
    reflectance: Option<Vec<f64>>,
    /// Solar Rs,Rd at normal incidence in place of those of its table.
    #[arg(long, requires = "solar", group = "solar_incidence", value_delimiter = ',', num_args = 1)]
    solar_reflectance: Option<Vec<f64>>,
    /// Instead of a table: Ts,Td,Rs,Rd at normal incidence, extended by the model of Roos et al. 2001.
    #[arg(long, conflicts_with = "table", group = "visible_normal", value_delimiter = ',', num_args = 1)]
    normal: Option<Vec<f64>>,
    /// Visible Rs,Rd at normal incidence from the room, if they differ.
    #[arg(long, requires = "visible_normal", value_delimiter = ',', num_args = 1)]
    back: Option<Vec<f64>>,
    /// Solar Ts,Td,Rs,Rd at normal incidence, written into the same file.
    #[arg(long, requires = "normal", conflicts_with = "solar", group = "solar_incidence", value_delimiter = ',', num_args = 1)]
    solar_normal: Option<Vec<f64>>,
    /// Solar Rs,Rd at normal incidence from the room, if they differ.
    #[arg(long, requires = "solar_incidence", value_delimiter = ',', num_args = 1)]
    solar_back: Option<Vec<f64>>,
    /// Number of panes p of the Roos model; 0 leaves their terms out, as published tables of PDLC films do.
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
    let from_file = |path: &Path, [front, back]: [&Given; 2], warnings: &mut Warnings| -> Result<Blocks> {
        let text = text::read(path, "a table of angular values")?;
        let table = match front.values("Rs,Rd")? {
            None => AngularTable::parse(&text, warnings),
            Some(front) => AngularTable::parse_transmittance(&text, front, back.values("Rs,Rd")?.unwrap_or(front), warnings),
        };
        Ok(table.map_err(|e| e.file(path))?.to_blocks(&basis, warnings))
    };
    let from_normal = |[front, back]: [&Given; 2], warnings: &mut Warnings| -> Result<Blocks> {
        let [ts, td, rs, rd] = front.values("Ts,Td,Rs,Rd")?.unwrap_or_default();
        let front =
            Sample { theta: 0.0, specular_transmittance: ts, diffuse_transmittance: td, specular_reflectance: rs, diffuse_reflectance: rd };
        let back = match back.values("Rs,Rd")? {
            Some([rs, rd]) => Sample { specular_reflectance: rs, diffuse_reflectance: rd, ..front },
            None => front,
        };
        Ok(AngularTable::roos(front, back, args.panes, args.category, warnings)?.to_blocks(&basis, warnings))
    };
    let mut bsdf = Bsdf { name: args.name.clone(), thickness: args.thickness, ..Bsdf::default() };
    let given = |option, list| Given { option, list };
    let back = given("--back", args.back.as_deref());
    bsdf.visible = match &args.table {
        Some(table) => from_file(table, [&given("--reflectance", args.reflectance.as_deref()), &back], warnings)?,
        None => from_normal([&given("--normal", args.normal.as_deref()), &back], warnings)?,
    };
    let back = given("--solar-back", args.solar_back.as_deref());
    if let Some(table) = &args.solar {
        bsdf.solar = from_file(table, [&given("--solar-reflectance", args.solar_reflectance.as_deref()), &back], warnings)?;
    }
    if let Some(normal) = args.solar_normal.as_deref() {
        bsdf.solar = from_normal([&given("--solar-normal", Some(normal)), &back], warnings)?;
    }
    bsdf::write(args.output.as_deref(), &bsdf, &super::made_by())?;
    Ok(ExitCode::SUCCESS)
}

/// An option that takes a list.
struct Given<'a> {
    option: &'static str,
    list: Option<&'a [f64]>,
}

impl Given<'_> {
    /// Its values, exactly as many as the names of a list like `Rs,Rd`.
    fn values<const N: usize>(&self, names: &str) -> Result<Option<[f64; N]>> {
        let Some(list) = self.list else { return Ok(None) };
        <[f64; N]>::try_from(list).map(Some).map_err(|_| {
            Error::new(format!("{N} values are needed, {names}, but there are {}", list.len()))
                .field(self.option)
                .help("separate them by commas, without spaces")
        })
    }
}
