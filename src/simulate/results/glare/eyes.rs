//! Eyes: sensors where the views are, for the ways to glare that take Ev from a sensor.

use crate::bins::ReinhartSky;
use crate::error::Result;
use crate::glare::geometry::ViewFrame;
use crate::glare::imageless::{Patch, PatchSources};
use crate::glare::{Settings, Threshold};
use crate::kernels::sun_matrix::geometry::SunMatrix;
use crate::kernels::trace::TracedMatrix;
use crate::matrix::Matrix;
use crate::simulate::inputs::Differences;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::light::Light;
use crate::simulate::results::illuminance::luminous;
use crate::units::ILLUMINANCE_WEIGHTS;

/// View matrix of all views' eyes and, with five phases, their sun matrix.
pub struct Eyes<'a> {
    /// V, Vd and V's standard error.
    pub view: TracedMatrix,
    /// Cds and its suns.
    pub suns: Option<(SunMatrix, &'a SunSet)>,
}

/// One of them.
#[derive(Clone, Copy)]
pub struct Eye<'a> {
    /// Row of V, `[bin][rgb]`.
    pub total: &'a [f32],
    /// Row of Vd.
    pub direct: &'a [f32],
    /// Standard errors of `total`.
    pub standard_error: &'a [f32],
    suns: Option<(&'a SunMatrix, &'a SunSet, usize)>,
}

/// What a traced sun gives an eye in an hour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SunAtEye {
    /// Number of the sun.
    pub sun: usize,
    /// Illuminance, lx.
    pub total: f64,
    /// The part straight from the disc, lx.
    pub direct: f64,
    /// Variance of `total`, lx².
    pub variance: f64,
}

impl Eyes<'_> {
    /// The eye of the `number`-th view.
    pub fn of(&self, number: usize) -> Eye<'_> {
        Eye {
            total: self.view.total.row(number),
            direct: self.view.direct.row(number),
            standard_error: self.view.standard_error.row(number),
            suns: self.suns.as_ref().map(|(matrix, set)| (matrix, *set, number)),
        }
    }
}

impl Eye<'_> {
    /// What the traced sun gives in an hour of the year; nothing without one.
    pub fn sun(&self, hour: usize) -> Option<SunAtEye> {
        let (matrix, set, row) = self.suns?;
        let (sun, radiance) = set.hours.get(hour).copied().flatten()?;
        let of = |m: &Matrix<f32>| luminous(m.at(row, sun)) * radiance;
        let variance = of(&matrix.direct_error).powi(2) + of(&matrix.scattered_error).powi(2);
        Some(SunAtEye { sun, total: of(&matrix.total), direct: of(&matrix.direct), variance })
    }

    /// Illuminance in the lit hours, lx.
    pub fn illuminance(&self, light: &Light) -> Vec<f64> {
        let matrix = |row: &[f32]| Matrix::from_data(1, row.len() / 3, 3, row.to_vec()).expect("a row of RGB values");
        let row = light.receivers(&matrix(self.total), &matrix(self.direct), Differences::NeverNegative);
        let mut lux = vec![0.0; light.right.cols()];
        for (bin, v) in row.data().as_chunks::<3>().0.iter().enumerate() {
            for (lux, light) in lux.iter_mut().zip(light.right.row(bin).as_chunks::<3>().0) {
                *lux += (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * f64::from(v[c]) * f64::from(light[c])).sum::<f64>();
            }
        }
        if light.is_split() {
            for (lux, &hour) in lux.iter_mut().zip(&light.hours) {
                *lux += self.sun(hour).map_or(0.0, |s| s.total);
            }
        }
        lux
    }
}

/// Patches of the sky, and suns, as sources of one view, and what each sends to the eye directly.
pub struct ImagelessSources {
    sources: PatchSources,
    /// Vd·T·Dd of each patch.
    direct: Vec<[f64; 3]>,
    /// The part of it through windows whose sun is traced; empty without.
    traced: Vec<[f64; 3]>,
    suns: usize,
}

impl ImagelessSources {
    /// Sources for an eye. `direct`: T·Dd of all windows, `traced`: of those whose sun is traced, if any
    /// are; their suns are sources of their own, in place of the sun in the patches.
    pub fn new(
        frame: &ViewFrame,
        eye: &Eye<'_>,
        sky: ReinhartSky,
        direct: &Matrix<f64>,
        traced: Option<&Matrix<f64>>,
        settings: &Settings,
    ) -> Self {
        // The ground is no source of glare, as in dcglare.
        let mut patches: Vec<Patch> = (0..sky.len())
            .map(|p| Patch { direction: sky.centre(p).to_array(), solid_angle: if p == 0 { 0.0 } else { sky.solid_angle(p) } })
            .collect();
        let suns = eye.suns.filter(|_| traced.is_some()).map_or(&[][..], |(_, set, _)| &set.suns);
        patches.extend(suns.iter().map(|s| Patch { direction: s.direction.to_array(), solid_angle: s.solid_angle() }));
        let at_eye = |light: &Matrix<f64>| -> Vec<[f64; 3]> {
            let of = |p: usize, c: usize| (0..light.rows()).map(|bin| f64::from(eye.direct[bin * 3 + c]) * light.at(bin, p)[c]).sum();
            (0..sky.len()).map(|p| std::array::from_fn(|c| of(p, c))).collect()
        };
        Self {
            sources: PatchSources::new(frame, &patches, settings.position_index),
            direct: at_eye(direct),
            traced: traced.map(at_eye).unwrap_or_default(),
            suns: suns.len(),
        }
    }

    /// DGP's contrast sum and the number of sources in a column of S (and of Sds, where suns are traced).
    pub fn contrast(
        &self,
        column: usize,
        sky: &Matrix<f32>,
        sun_patches: Option<&Matrix<f32>>,
        sun: Option<SunAtEye>,
        settings: &Settings,
    ) -> (f64, usize) {
        let lux = |d: &[f64; 3], s: &[f32]| -> f64 { (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * d[c] * f64::from(s[c])).sum() };
        let mut all: Vec<f64> = self.direct.iter().enumerate().map(|(p, d)| lux(d, sky.at(p, column))).collect();
        if let Some(suns) = sun_patches {
            let taken = self.traced.iter().enumerate().map(|(p, d)| lux(d, suns.at(p, column)));
            all.iter_mut().zip(taken).for_each(|(all, taken)| *all = (*all - taken).max(0.0));
        }
        let patches = all.len();
        all.resize(patches + self.suns, 0.0);
        if let Some(SunAtEye { sun, direct, .. }) = sun
            && sun < self.suns
        {
            all[patches + sun] = direct;
        }
        let threshold = match settings.threshold {
            Threshold::Fixed(l) => l,
            // Refused when the section is read.
            Threshold::TimesAverage(_) | Threshold::TimesTask(_) => f64::INFINITY,
        };
        (self.sources.contrast_sum(&all, threshold, &settings.dgp), self.sources.count(&all, threshold))
    }
}

/// The direction a view looks in and where its up is.
///
/// # Errors
/// A view straight up or down.
pub fn frame_of(camera: &crate::camera::View) -> Result<ViewFrame> {
    ViewFrame::new(camera.direction.to_array(), camera.up.to_array())
}
