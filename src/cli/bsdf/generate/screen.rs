//! Perforated screens and woven shades by WINDOW's model: computed, not traced.

use super::parametric::{Parameters, required};
use super::{Args, made_by};
use lucarne::bins::AngleBasis;
use lucarne::bsdf::screen::{Openings, Screen};
use lucarne::bsdf::{self, Blocks, Bsdf, Component};
use lucarne::kernels::bsdf_generation::Directions;
use lucarne::{Error, Result};
use std::process::ExitCode;

impl Args {
    /// The screen of `--perforated` or `--woven`, and its thickness in metres.
    pub fn screen(&self) -> Result<Option<(Screen, f64)>> {
        let read = |text: &str, woven: bool| -> Result<(Screen, f64)> {
            let known: &[&str] = if woven {
                &["diameter", "spacing", "reflectance", "transmittance"]
            } else {
                &["diameter", "width", "height", "spacing", "spacing_x", "spacing_y", "thickness", "reflectance", "transmittance"]
            };
            let given = Parameters::parse(text, known)?;
            let both = given.length("spacing")?;
            let spacing = |key: &str| required(given.length(key)?.or(both), "spacing");
            let thickness = given.length("thickness")?.unwrap_or(0.0);
            let openings = match (woven, given.length("diameter")?) {
                (true, diameter) => Openings::Woven { diameter: required(diameter, "diameter")?, spacing: required(both, "spacing")? },
                (false, Some(diameter)) => Openings::Round { diameter, spacing: [spacing("spacing_x")?, spacing("spacing_y")?], thickness },
                (false, None) => {
                    let size = [required(given.length("width")?, "diameter")?, required(given.length("height")?, "height")?];
                    Openings::Rectangular { size, spacing: [spacing("spacing_x")?, spacing("spacing_y")?], thickness }
                }
            };
            let (reflectance, transmittance) =
                (required(given.share("reflectance")?, "reflectance")?, given.share("transmittance")?.unwrap_or(0.0));
            let thickness = if let Openings::Woven { diameter, .. } = openings { 2.0 * diameter } else { thickness };
            Ok((Screen { openings, reflectance, transmittance }, thickness))
        };
        match (&self.perforated, &self.woven) {
            (Some(text), _) => read(text, false).map_err(|e| e.field("--perforated")).map(Some),
            (_, Some(text)) => read(text, true).map_err(|e| e.field("--woven")).map(Some),
            _ => Ok(None),
        }
    }

    /// Writes a screen's file: nothing is traced.
    pub fn write_screen(&self, (screen, thickness): &(Screen, f64), directions: Directions, leave_out: [bool; 2]) -> Result<ExitCode> {
        let Directions::Klems(basis) = directions else {
            return Err(
                Error::new("screens by WINDOW's model are matrices").help("make a matrix first, then a tree with lucarne bsdf convert")
            );
        };
        if self.geometry || self.standard_error.is_some() {
            return Err(Error::new("screens by WINDOW's model have neither geometry nor standard errors")
                .help("leave out --geometry and --standard-error"));
        }
        let mut all = screen.blocks(&AngleBasis::from(basis))?;
        for component in Component::ALL.into_iter().filter(|c| leave_out[usize::from(!c.is_front())]) {
            *all.slot(component) = None;
        }
        let kind = if self.woven.is_some() { "Woven Shade" } else { "Perforated Screen" };
        let bsdf = Bsdf {
            name: self.name.clone().unwrap_or_else(|| kind.to_lowercase()),
            manufacturer: self.manufacturer.clone(),
            device_type: kind.into(),
            thickness: Some(*thickness),
            properties: vec![("PermeabilityFactor".into(), format!("{:.6}", screen.openness()))],
            solar: if self.solar { all.clone() } else { Blocks::default() },
            visible: all,
            ..Bsdf::default()
        };
        bsdf::write(self.output.as_deref(), &bsdf, &made_by())?;
        Ok(ExitCode::SUCCESS)
    }
}
