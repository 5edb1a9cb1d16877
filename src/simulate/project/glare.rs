//! `[glare]` of a project: which way glare is computed, and evalglare's options by name.
//!
//! ```toml
//! [glare]
//! method = "image"            # "image" | "edgps" | "dgps" | "imageless"
//! constants = "evalglare"     # DGP's: "evalglare" (0.092, 0.159) | "original" (0.0918, 0.16)
//! low_light_correction = false
//! threshold = 2000            # -b: above 100 cd/m², else a multiple of the average (the task's)
//! task = [200, 150, 0.5]      # -t: column, row from the bottom, opening angle (rad)
//! search_radius = 0.2         # -r, rad
//! peaks = true                # -y / -x
//! peak_limit = 50000          # -Y, cd/m²
//! position_index = "guth"     # "guth" | "kim" | "guth_iwata"
//! field_of_view = "whole"     # "whole" | "total" | "binocular" (-G 1, 2)
//! veil = 0.533                # spread of peaks by a Gaussian, full width at half maximum, degrees
//! occupied = [8, 18]          # hours of the day that count, from … to
//! ```
//!
//! The disc of a traced sun is a source of its own with every method that has sources, whatever `peaks` says,
//! if it is brighter than the threshold; a veil spreads it as it spreads pixels.

use super::table::Table;
use crate::error::Result;
use crate::glare::{DgpModel, FieldOfView, PositionIndex, Settings, TaskArea, Threshold};

/// How glare is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GlareMethod {
    /// From pictures of everything, as evalglare does.
    Image,
    /// Sources from pictures of the windows alone, vertical illuminance from a sensor (eDGPs).
    Edgps,
    /// From the vertical illuminance alone (DGPs).
    Dgps,
    /// Patches of the sky as sources, without pictures (as `dcglare`).
    Imageless,
}

impl GlareMethod {
    const NAMES: [(&'static str, Self); 4] =
        [("image", Self::Image), ("edgps", Self::Edgps), ("dgps", Self::Dgps), ("imageless", Self::Imageless)];

    /// Whether glare sources are pixels of pictures.
    pub(crate) fn has_pictures(self) -> bool {
        matches!(self, Self::Image | Self::Edgps)
    }

    /// The word in the project file.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, m)| *m == self).map_or("", |(n, _)| n)
    }
}

/// `[glare]`.
#[derive(Debug, Clone, PartialEq)]
pub struct GlareSection {
    /// How.
    pub method: GlareMethod,
    /// What is glare and how it is judged.
    pub settings: Settings,
    /// Full width at half maximum of the veil, degrees.
    pub veil: Option<f64>,
    /// Hours of the day that count, from (inclusive) and to (exclusive).
    pub occupied: [f64; 2],
}

impl GlareSection {
    pub(super) fn read(table: Option<Table<'_, '_>>) -> Result<Option<Self>> {
        let Some(mut table) = table else { return Ok(None) };
        let method = table.choice("method", &GlareMethod::NAMES)?.unwrap_or(GlareMethod::Image);
        let defaults = Settings::default();
        let models = [("evalglare", DgpModel::EVALGLARE), ("original", DgpModel::ORIGINAL)];
        let model = table.choice("constants", &models)?.unwrap_or_default();
        let low_light_correction = table.boolean("low_light_correction")?.unwrap_or(false);
        let task = match table.numbers("task", 0.0..=1e6)? {
            None => None,
            Some(numbers) => match numbers[..] {
                [x, y, opening_angle] if opening_angle > 0.0 && opening_angle <= std::f64::consts::TAU => {
                    Some(TaskArea { x, y, opening_angle })
                }
                _ => return Err(table.error("task", "a task area is a column, a row from the bottom and an opening angle up to 2π rad")),
            },
        };
        let positive = f64::MIN_POSITIVE..=1e12;
        let threshold = Threshold::from_option(table.number("threshold", positive.clone())?, task.is_some());
        let search_radius = table.number("search_radius", 0.0..=std::f64::consts::TAU)?.unwrap_or(defaults.search_radius);
        let peak_limit = table.number("peak_limit", positive)?.or(defaults.peak_limit);
        let peaks = table.boolean("peaks")?.unwrap_or(true);
        let positions = [("guth", PositionIndex::Guth), ("kim", PositionIndex::Kim), ("guth_iwata", PositionIndex::GuthIwata)];
        let position_index = table.choice("position_index", &positions)?.unwrap_or_default();
        let fields = [("whole", FieldOfView::Whole), ("total", FieldOfView::Total), ("binocular", FieldOfView::Binocular)];
        let field_of_view = table.choice("field_of_view", &fields)?.unwrap_or_default();
        let veil = table.number("veil", 0.01..=20.0)?;
        let occupied = match table.numbers("occupied", 0.0..=24.0)? {
            None => [8.0, 18.0],
            Some(hours) => match hours[..] {
                [from, to] if from < to => [from, to],
                _ => return Err(table.error("occupied", "occupied hours are two rising numbers").help("write occupied = [8, 18]")),
            },
        };
        if method == GlareMethod::Imageless && !matches!(threshold, Threshold::Fixed(_)) {
            return Err(table
                .error("threshold", "without pictures there is no average luminance")
                .help("give the threshold in cd/m², above 100, or choose another method"));
        }
        if veil.is_some() && !matches!(method, GlareMethod::Image | GlareMethod::Edgps) {
            return Err(table.error("veil", "a veil needs pictures").help("choose method = \"image\" or \"edgps\""));
        }
        table.finish()?;
        let settings = Settings {
            threshold,
            task,
            search_radius,
            peak_limit: peak_limit.filter(|_| peaks),
            field_of_view,
            position_index,
            dgp: DgpModel { low_light_correction, ..model },
            ..defaults
        };
        Ok(Some(Self { method, settings, veil, occupied }))
    }
}
