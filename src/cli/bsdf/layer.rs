//! `lucarne bsdf layer`.

use lucarne::bsdf::layer::{LayerWords, combine, read_layers};
use lucarne::bsdf::{self, Component};
use lucarne::{Result, Warnings};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Combines glass and BSDF layers into a window system (what WINDOW does), Visible and Solar.
///
/// Layers are named from the OUTSIDE to the INSIDE: XML files; glass by name (`glass:clear_3mm`,
/// `glass:clear_6mm`), from spectral data (`glass:FILE`: text of Optics, JSON of the IGSDB) or from values
/// at normal incidence (`glass:tvis=…,rvis=…,tsol=…,rsol=…`, `coated` for low-e); and gaps (`gap=16mm`),
/// which only add to the thickness. `flip:LAYER` turns a layer around. A window's tilt changes its heat
/// transfer, not these values.
///
/// Calculated wavelength by wavelength: Visible with D65 and the eye (ASTM E308), Solar with ASTM E891
/// (NFRC 300). Front means WINDOW's front in all of them: the outside. (Radiance calls the room side front.)
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  lucarne bsdf layer outside.xml gap=16mm glass:clear_6mm -o system.xml\n  \
    lucarne bsdf layer glass:clear_float.dat gap=16mm flip:glass:low_e.dat gap=50mm blind.xml -o system.xml\n  \
    lucarne bsdf layer glass:tvis=.78,rvis=.12,tsol=.42,rsol=.35,coated gap=16mm glass:clear_6mm gap=50mm flip:blind.xml -o system.xml")]
pub struct Args {
    /// Layers and gaps from outside to inside.
    #[arg(required = true)]
    layers: Vec<String>,
    /// Klems basis of the result: full, half or quarter.
    #[arg(long, default_value = "full")]
    basis: String,
    /// XML file to write; standard output if absent.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

pub fn run(args: &Args, warnings: &mut Warnings) -> Result<ExitCode> {
    let basis = super::klems_basis(&args.basis)?;
    let LayerWords { layers, thickness } = read_layers(&args.layers, Path::new(""), warnings)?;
    let mut system = combine(&layers, &basis, warnings)?;
    system.bsdf.thickness = thickness;
    bsdf::write(args.output.as_deref(), &system.bsdf, &super::made_by())?;
    for (k, (band, blocks)) in system.bsdf.bands().into_iter().take(2).enumerate() {
        if blocks.is_empty() {
            continue;
        }
        let short = if band == "Visible" { "vis" } else { "sol" };
        let value = |c: Component, f: &dyn Fn(&bsdf::Block) -> f64| blocks.get(c).map_or(f64::NAN, f);
        let normal = |b: &bsdf::Block| b.direct_hemispherical(glam::DVec3::Z);
        let diffuse = |b: &bsdf::Block| b.hemispherical();
        for (name, f) in [("normal", &normal as &dyn Fn(&bsdf::Block) -> f64), ("diffuse", &diffuse)] {
            eprintln!(
                "{name:<8} T{short} {:.4}  R{short} front {:.4}  R{short} back {:.4}",
                value(Component::TransmissionFront, f),
                value(Component::ReflectionFront, f),
                value(Component::ReflectionBack, f)
            );
        }
        for (n, layer) in system.absorptance[k].iter().enumerate() {
            eprintln!(
                "layer {}  A{short} {:.4} at the normal, {:.4} diffuse (light from outside)",
                n + 1,
                layer.front[0],
                layer.hemispherical[0]
            );
        }
    }
    Ok(ExitCode::SUCCESS)
}
