//! Discomfort glare of hemispherical pictures, and of a year of them.
//!
//! The steps are separate so that another implementation (a fused one on the device) can share each:
//! [`geometry`] is computed once per view; [`detect`] chooses the glare pixels of a luminance image;
//! [`sources`] groups them, a pure function of the pixels and the geometry; the sun's [`disc`] joins
//! them where it is known; [`index`] turns the vertical illuminance and the sources into DGP, UGR and
//! the others. [`Analyser`] runs them in turn.
//!
//! Written from the published formulas (cited where they stand) and from the observed behaviour of
//! evalglare 3.06. Known differences from evalglare:
//! - Glare pixels within the search radius of one another are always one source. evalglare's search
//!   sometimes misses a lone pixel in the same row.
//! - Pixels behind the viewer never count, whatever the projection.
//! - An index without meaning (UGR and UGP of a picture that is a source all over) is [`UNDEFINED`].
//!
//! Two more peculiarities of evalglare are kept unless [`Convention::Exact`] is chosen, since they
//! decide whether results agree with those of other projects.

pub mod annual;
pub mod check;
pub mod detect;
pub mod disc;
pub mod geometry;
pub(crate) mod imageless;
pub mod index;
pub(crate) mod position;
pub mod sources;
pub mod statistics;
pub mod veil;

use crate::error::{Error, Result};
use std::sync::Arc;

pub use annual::{CLASS_LIMITS, GlareClass};
pub use detect::{TaskArea, Threshold};
pub use disc::Disc;
pub use geometry::PixelGeometry;
pub(crate) use geometry::{Totals, ViewFrame};
pub(crate) use index::Indices;
pub use index::UNDEFINED;
pub use index::{Background, DgpModel};
pub use position::{FieldOfView, PositionIndex};
pub(crate) use sources::Neighbourhood;
pub use sources::Source;

/// What to look for in a picture and how to judge it. The default is evalglare's.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Luminance above which a pixel belongs to a glare source.
    pub threshold: Threshold,
    /// Area the viewer works at; only [`Threshold::TimesTask`] needs it.
    pub task: Option<TaskArea>,
    /// Twice the angle up to which two glare pixels are one source, rad (evalglare's `-r`).
    pub search_radius: f64,
    /// Luminance from which pixels are taken out of their source to form their own, cd/m²; `None`
    /// leaves sources whole.
    pub peak_limit: Option<f64>,
    /// Part of the view in which sources are looked for. Vertical illuminance and average
    /// luminance are always those of the whole view.
    pub field_of_view: FieldOfView,
    /// Position index.
    pub position_index: PositionIndex,
    /// How positions in the view are measured.
    pub convention: Convention,
    /// DGP's constants and low-light correction.
    pub dgp: DgpModel,
    /// Definition of the background luminance.
    pub background: Background,
}

/// Luminance from which pixels form sources of their own, or are spread by a veil, unless a caller says
/// otherwise, cd/m²: evalglare's.
pub const PEAK_LIMIT: f64 = 50_000.0;

impl Default for Settings {
    fn default() -> Self {
        Self {
            threshold: Threshold::default(),
            task: None,
            search_radius: 0.2,
            peak_limit: Some(PEAK_LIMIT),
            field_of_view: FieldOfView::Whole,
            position_index: PositionIndex::Guth,
            convention: Convention::Evalglare,
            dgp: DgpModel::default(),
            background: Background::default(),
        }
    }
}

/// How positions in the view are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Convention {
    /// As evalglare 3.06. A source stands at the pixel whose column and row (from the bottom) are its
    /// centroid's cut to integers: half a pixel too far left and down on average, so that a
    /// mirrored picture gives slightly different results. The angle τ from upwards is measured to
    /// the view's up vector even where that is not across the view direction, so that sources above
    /// a tilted view have a position index as if they stood aside (DGP differs by up to 0.005).
    #[default]
    Evalglare,
    /// A source stands at its centroid's direction; τ is measured around the view direction.
    Exact,
}

impl Convention {
    /// The axes that angles are measured from.
    pub fn frame(self, geometry: &PixelGeometry) -> ViewFrame {
        match self {
            Self::Evalglare => geometry.frame,
            Self::Exact => geometry.frame.squared(),
        }
    }
}

/// Glare of one picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Glare {
    /// Illuminance at the eye, on the plane across the view direction, lx.
    pub vertical_illuminance: f64,
    /// The part of it that comes from the sources, lx.
    pub direct_illuminance: f64,
    /// Mean luminance weighted by solid angle, cd/m².
    pub average_luminance: f64,
    /// Background luminance, cd/m².
    pub background_luminance: f64,
    /// Luminance of the task area, cd/m², if there is one.
    pub task_luminance: Option<f64>,
    /// Luminance above which a pixel counted as glare, cd/m².
    pub threshold: f64,
    /// The glare sources, in the order of their first pixel; then peaks, then discs.
    pub sources: Vec<Source>,
    /// The indices.
    pub indices: Indices,
}

/// Pixels of a picture that are brighter than the threshold.
#[derive(Debug, Clone, Copy)]
pub struct GlarePixels<'a> {
    /// Numbers, ascending, of pixels in which sources are looked for (`Analyser::searched`).
    pub pixels: &'a [u32],
    /// Their luminances, cd/m².
    pub luminance: &'a [f32],
}

/// Analyses pictures of one view. Everything that depends on the view alone is computed once.
#[derive(Debug, Clone)]
pub struct Analyser {
    geometry: Arc<PixelGeometry>,
    settings: Settings,
    neighbourhood: Neighbourhood,
    /// Pixels in which sources are looked for.
    searched: Vec<bool>,
    task_pixels: Vec<u32>,
    /// Centre of the task area and the cosine of its half opening angle.
    task_cap: Option<([f64; 3], f64)>,
}

impl Analyser {
    /// Prepares the analysis of pictures with this geometry.
    ///
    /// # Errors
    /// Settings out of range, a task area outside the picture or without pixels.
    pub fn new(geometry: Arc<PixelGeometry>, settings: Settings) -> Result<Self> {
        check_settings(&settings)?;
        let neighbourhood = Neighbourhood::new(&geometry, settings.search_radius);
        let frame = settings.convention.frame(&geometry);
        let searched = (0..geometry.pixel_count())
            .map(|i| geometry.is_inside(i) && settings.field_of_view.contains(&frame, geometry.directions[i]))
            .collect();
        let task_pixels = match &settings.task {
            Some(task) => task.pixels(&geometry)?,
            None => Vec::new(),
        };
        let task_cap = settings.task.as_ref().map(|task| task.cap(&geometry)).transpose()?;
        Ok(Self { geometry, settings, neighbourhood, searched, task_pixels, task_cap })
    }

    /// The geometry given.
    pub fn geometry(&self) -> &PixelGeometry {
        &self.geometry
    }

    /// The settings given.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Pixels of the task area, ascending; empty without one.
    pub fn task_pixels(&self) -> &[u32] {
        &self.task_pixels
    }

    /// Glare of a luminance image, cd/m², one value per pixel, row 0 on top. `vertical_illuminance`
    /// (lx) replaces the picture's own in DGP alone, as evalglare's `-i` does: with the picture of
    /// the direct light only this is eDGPs.
    ///
    /// # Errors
    /// If the image does not fit the geometry, a luminance is negative or not finite (see
    /// [`detect::luminance`]), or the given illuminance is.
    pub fn analyse(&self, luminance: &[f32], vertical_illuminance: Option<f64>) -> Result<Glare> {
        self.analyse_with_discs(luminance, &[], vertical_illuminance)
    }

    /// As [`Self::analyse`], of a picture in whose pixels these discs are missing. They light the eye and are
    /// sources of their own if they are brighter than the threshold, whatever the settings say of peaks.
    ///
    /// # Errors
    /// As [`Self::analyse`], and for discs that are not finite.
    pub fn analyse_with_discs(&self, luminance: &[f32], discs: &[Disc], vertical_illuminance: Option<f64>) -> Result<Glare> {
        disc::check(discs)?;
        let geometry = &*self.geometry;
        if luminance.len() != geometry.pixel_count() {
            return Err(Error::new(format!(
                "{} luminances do not fit the view's {} × {} pixels",
                luminance.len(),
                geometry.width,
                geometry.height
            )));
        }
        if let Some(ev) = vertical_illuminance
            && !(ev.is_finite() && ev >= 0.0)
        {
            return Err(Error::new(format!("the vertical illuminance {ev} lx is not a finite number from 0")));
        }
        let mut totals = geometry.totals(luminance)?;
        let mut task_luminance = self.settings.task.is_some().then(|| geometry.mean_luminance(luminance, &self.task_pixels));
        self.add_discs(discs, &mut totals, &mut task_luminance);
        let threshold = self.settings.threshold.luminance(totals.average_luminance, task_luminance);
        let pixels = detect::glare_pixels(luminance, &self.searched, threshold);
        let values: Vec<f32> = pixels.iter().map(|&p| luminance[p as usize]).collect();
        let found = GlarePixels { pixels: &pixels, luminance: &values };
        Ok(self.judge(&totals, task_luminance, found, discs, vertical_illuminance))
    }

    /// Glare from what a picture was reduced to elsewhere (on the device): its sums, which hold the discs
    /// (`Self::add_discs`), its glare pixels and the discs. The same numbers give the same result as
    /// [`Self::analyse_with_discs`], bit for bit.
    ///
    /// # Panics
    /// If there is not one luminance per pixel, or a pixel is none of the view.
    pub fn judge(
        &self,
        totals: &Totals,
        task_luminance: Option<f64>,
        found: GlarePixels<'_>,
        discs: &[Disc],
        vertical_illuminance: Option<f64>,
    ) -> Glare {
        assert_eq!(found.pixels.len(), found.luminance.len(), "one luminance per pixel");
        let threshold = self.settings.threshold.luminance(totals.average_luminance, task_luminance);
        let mut sources = sources::find(found.pixels, found.luminance, &self.geometry, &self.neighbourhood, &self.settings);
        let frame = self.settings.convention.frame(&self.geometry);
        let shine = discs.iter().filter(|d| d.is_source(&frame, threshold, &self.settings));
        sources.extend(shine.map(|d| d.source(&frame, &self.settings)));
        index::judge(totals, task_luminance, threshold, sources, vertical_illuminance, &self.settings)
    }

    /// What is suspicious about the view and the settings: a view that lacks part of the hemisphere,
    /// pixels too far apart to be joined.
    pub fn doubts(&self) -> Vec<Error> {
        let mut doubts = Vec::new();
        let coverage = self.geometry.hemisphere_coverage();
        if coverage < 0.98 {
            doubts.push(
                Error::new(format!(
                    "the view covers {:.1} % of the hemisphere (weighted by the cosine): vertical illuminance and DGP lack the rest",
                    100.0 * coverage
                ))
                .help("use a fisheye of 180°; if the picture is one, say so: `-vta -vh 180 -vv 180`; or give the illuminance with -i"),
            );
        }
        if self.settings.search_radius / 2.0 < self.geometry.pixel_pitch() {
            doubts.push(
                Error::new(format!(
                    "the search radius of {} rad joins no pixels: they are {:.4} rad apart",
                    self.settings.search_radius,
                    self.geometry.pixel_pitch()
                ))
                .help("use larger pictures or a larger -r; the radius is a full angle, pixels up to half of it apart are joined"),
            );
        }
        doubts
    }

    /// Whether sources are looked for in each pixel: inside the view and the field of view.
    pub(crate) fn searched(&self) -> &[bool] {
        &self.searched
    }

    /// Position index of each pixel; 0 outside the view.
    pub fn position_indices(&self) -> Vec<f64> {
        let frame = self.settings.convention.frame(&self.geometry);
        let of = |i: usize| self.settings.position_index.of(&frame, self.geometry.directions[i]);
        (0..self.geometry.pixel_count()).map(|i| if self.geometry.is_inside(i) { of(i) } else { 0.0 }).collect()
    }
}

fn check_settings(settings: &Settings) -> Result<()> {
    let bad = |field: &str, message: String| Err(Error::new(message).field(field));
    let r = settings.search_radius;
    if !(0.0..=std::f64::consts::TAU).contains(&r) {
        return bad("search radius", format!("{r} is not an angle between 0 and 2π rad"));
    }
    if let Some(limit) = settings.peak_limit
        && !(limit.is_finite() && limit > 0.0)
    {
        return bad("peak limit", format!("{limit} is not a luminance above 0 cd/m²"));
    }
    settings.threshold.check(settings.task.is_some())?;
    settings.dgp.check()
}

#[cfg(test)]
mod disc_tests;
#[cfg(test)]
mod tests;
