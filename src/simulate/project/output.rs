//! `[output]`: what sensors tell.

use super::table::Table;
use crate::error::Result;
use crate::units::LUMINOUS_EFFICACY;

/// What is computed at sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quantity {
    /// Of light, lx.
    #[default]
    Illuminance,
    /// Of the whole solar spectrum, W/m².
    Irradiance,
}

impl Quantity {
    const NAMES: [(&'static str, Self); 2] = [("illuminance", Self::Illuminance), ("irradiance", Self::Irradiance)];

    /// Its word in the project file, and the folder of its results.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, q)| *q == self).map_or("", |(n, _)| n)
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Illuminance => "lx",
            Self::Irradiance => "W/m²",
        }
    }

    /// Whether skies are those of the solar spectrum (`gendaymtx -O1`).
    pub fn is_solar(self) -> bool {
        self == Self::Irradiance
    }

    /// By what a sky's radiances are multiplied so that sums weighted for lux come in this quantity's unit.
    pub(in crate::simulate) fn factor(self) -> f64 {
        match self {
            Self::Illuminance => 1.0,
            Self::Irradiance => 1.0 / LUMINOUS_EFFICACY,
        }
    }
}

/// `[output]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OutputSection {
    /// What sensors tell.
    pub quantity: Quantity,
}

impl OutputSection {
    pub(super) fn read(table: Option<Table<'_, '_>>, pictures: bool) -> Result<Self> {
        let Some(mut table) = table else { return Ok(Self::default()) };
        let quantity = table.choice("quantity", &Quantity::NAMES)?.unwrap_or_default();
        if quantity.is_solar() && pictures {
            return Err(table
                .error("quantity", "pictures and glare are of light: there is no irradiance beside them")
                .help("write a project without [[view]] for the irradiance; 'lucarne run A.toml B.toml' traces what they share once"));
        }
        table.finish()?;
        Ok(Self { quantity })
    }
}
