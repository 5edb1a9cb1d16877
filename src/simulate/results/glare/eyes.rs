//! Eyes: sensors where the views are, for the ways to glare that take Ev from a sensor.

use crate::bins::ReinhartSky;
use crate::error::Result;
use crate::glare::geometry::ViewFrame;
use crate::glare::imageless::{Patch, PatchSources};
use crate::glare::{Disc, Settings, Threshold, disc};
use crate::kernels::sun_matrix::SunMatrix;
use crate::kernels::trace::TracedMatrix;
use crate::matrix::Matrix;
use crate::scene::Window;
use crate::simulate::inputs::Differences;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::light::Light;
use crate::simulate::results::illuminance::luminous;
use crate::units::ILLUMINANCE_WEIGHTS;
use glam::DVec3;

/// View matrix of all views' eyes.
pub(crate) struct Eyes {
    /// V, Vd and V's standard error.
    pub view: TracedMatrix,
}

/// One of them.
#[derive(Clone, Copy)]
pub(crate) struct Eye<'a> {
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
pub(crate) struct SunAtEye {
    /// Illuminance, lx.
    pub total: f64,
    /// Variance of `total`, lx².
    pub variance: f64,
}

impl Eyes {
    /// The eye of the `number`-th view, with five phases with Cds of all eyes and its suns.
    pub(crate) fn of<'e>(&'e self, number: usize, suns: Option<(&'e SunMatrix, &'e SunSet)>) -> Eye<'e> {
        Eye {
            total: self.view.total.row(number),
            direct: self.view.direct.row(number),
            standard_error: self.view.standard_error.row(number),
            suns: suns.map(|(matrix, set)| (matrix, set, number)),
        }
    }
}

impl Eye<'_> {
    /// What the traced sun gives in an hour of the year; nothing without one.
    pub(crate) fn sun(&self, hour: usize) -> Option<SunAtEye> {
        let (matrix, set, row) = self.suns?;
        let (sun, radiance) = set.hours.get(hour).copied().flatten()?;
        let of = |m: &Matrix<f32>| luminous(m.at(row, sun)) * radiance;
        let variance = of(&matrix.own_error).powi(2) + of(&matrix.shared_error).powi(2);
        Some(SunAtEye { total: of(&matrix.total), variance })
    }

    /// Illuminance in the lit hours, lx.
    pub(crate) fn illuminance(&self, light: &Light) -> Vec<f64> {
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

/// Parts of a patch along each side.
const PARTS: usize = 8;
/// Points of a bin along each side.
const POINTS: usize = 16;

/// Patches of the sky as sources of one view, and what each shows of the sky's radiance.
pub(crate) struct ImagelessSources {
    frame: ViewFrame,
    sources: PatchSources,
    /// Radiance of each patch per radiance of the sky there.
    direct: Vec<[f64; 3]>,
    /// The part of it through windows whose sun is traced; empty without.
    traced: Vec<[f64; 3]>,
}

impl ImagelessSources {
    /// Sources for an eye. `direct`: T·Dd of all windows, `traced`: of those whose sun is traced, if any
    /// are; their suns are sources of their own, in place of the sun in the patches.
    ///
    /// A patch's light leaves the windows in bins that are larger than it. How much of the light of a bin is
    /// seen is the share of the bin before the eye that windows fill: V's entry over the bin's projected
    /// solid angle there. So a patch near the eye's plane, whose own cosine is next to nothing, is no brighter
    /// than the sky.
    pub(crate) fn new<'w>(
        frame: &ViewFrame,
        eye: &Eye<'_>,
        windows: impl Iterator<Item = &'w Window>,
        sky: ReinhartSky,
        direct: &Matrix<f64>,
        traced: Option<&Matrix<f64>>,
        settings: &Settings,
    ) -> Self {
        let parts =
            |p: usize| (0..PARTS * PARTS).map(move |i| sky.direction(p, middle(i % PARTS, PARTS), middle(i / PARTS, PARTS)).to_array());
        // The ground is no source of glare, as in dcglare.
        let patch = |p: usize| Patch { parts: parts(p).collect(), solid_angle: if p == 0 { 0.0 } else { sky.solid_angle(p) } };
        let patches: Vec<Patch> = (0..sky.len()).map(patch).collect();
        let seen = seen_of_bins(frame, eye.direct, windows);
        let shown = |light: &Matrix<f64>| -> Vec<[f64; 3]> {
            let of = |p: usize, c: usize| (0..light.rows()).map(|bin| seen[bin][c] * light.at(bin, p)[c]).sum::<f64>() / sky.solid_angle(p);
            (0..sky.len()).map(|p| std::array::from_fn(|c| of(p, c))).collect()
        };
        Self {
            frame: *frame,
            sources: PatchSources::new(frame, &patches, settings),
            direct: shown(direct),
            traced: traced.map(shown).unwrap_or_default(),
        }
    }

    /// DGP's contrast sum and the number of sources in a column of S (and of Sds, where suns are traced) with
    /// the sun's discs.
    pub(crate) fn contrast(
        &self,
        column: usize,
        sky: &Matrix<f32>,
        sun_patches: Option<&Matrix<f32>>,
        discs: &[Disc],
        settings: &Settings,
    ) -> (f64, usize) {
        let luminance = |d: &[f64; 3], s: &[f32]| -> f64 { (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * d[c] * f64::from(s[c])).sum() };
        let mut all: Vec<f64> = self.direct.iter().enumerate().map(|(p, d)| luminance(d, sky.at(p, column))).collect();
        if let Some(suns) = sun_patches {
            let taken = self.traced.iter().enumerate().map(|(p, d)| luminance(d, suns.at(p, column)));
            all.iter_mut().zip(taken).for_each(|(all, taken)| *all = (*all - taken).max(0.0));
        }
        let threshold = fixed_threshold(settings);
        let (of_discs, count) = self.contrast_of_discs(discs, settings);
        (self.sources.contrast_sum(&all, threshold, &settings.dgp) + of_discs, self.sources.count(&all, threshold) + count)
    }

    /// The discs' part of it.
    pub(crate) fn contrast_of_discs(&self, discs: &[Disc], settings: &Settings) -> (f64, usize) {
        disc::contrast(discs, &self.frame, fixed_threshold(settings), settings)
    }
}

/// The threshold without a picture's averages, cd/m².
fn fixed_threshold(settings: &Settings) -> f64 {
    match settings.threshold {
        Threshold::Fixed(l) => l,
        // Refused when the section is read.
        Threshold::TimesAverage(_) | Threshold::TimesTask(_) => f64::INFINITY,
    }
}

fn middle(i: usize, of: usize) -> f64 {
    (i as f64 + 0.5) / of as f64
}

/// Solid angle of each bin times the share of it, before the eye, that windows fill: Vd over the bin's
/// projected solid angle before the eye. `direct` `[bin][rgb]`: Vd of the bins of all windows in turn.
fn seen_of_bins<'w>(frame: &ViewFrame, direct: &[f32], windows: impl Iterator<Item = &'w Window>) -> Vec<[f64; 3]> {
    let ahead = DVec3::from_array(frame.forward);
    let of_bin = |window: &Window, bin: usize| {
        let basis = &window.basis;
        let part = basis.projected_solid_angle(bin) / (POINTS * POINTS) as f64;
        let points = (0..POINTS * POINTS).map(|i| basis.direction(bin, middle(i % POINTS, POINTS), middle(i / POINTS, POINTS)));
        // Light goes into the room, the eye looks out.
        let before: f64 = points.map(|d| part / d.z.max(1e-6) * (-window.frame.to_world(d)).dot(ahead).max(0.0)).sum();
        (basis.solid_angle(bin), before)
    };
    let bins = windows.flat_map(|w| (0..w.basis.len()).map(move |bin| of_bin(w, bin)));
    let share = |v: f32, before: f64| if before > 0.0 { (f64::from(v) / before).clamp(0.0, 1.0) } else { 0.0 };
    bins.zip(direct.as_chunks::<3>().0).map(|((solid_angle, before), v)| v.map(|v| solid_angle * share(v, before))).collect()
}

/// The direction a view looks in and where its up is.
///
/// # Errors
/// A view straight up or down.
pub(crate) fn frame_of(camera: &crate::camera::View) -> Result<ViewFrame> {
    ViewFrame::new(camera.direction.to_array(), camera.up.to_array())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::{Frame, KlemsBasis};
    use crate::scene::SurfaceOrigin;

    fn south() -> Window {
        let frame = Frame::new(DVec3::Y, DVec3::Z).unwrap();
        let corner = [[-1.0, 0.0], [1.0, 0.0], [1.0, 2.0], [-1.0, 2.0]].map(|[x, z]| DVec3::new(x, 0.0, z));
        let triangles = vec![[corner[0], corner[2], corner[1]], [corner[0], corner[3], corner[2]]];
        let origin = SurfaceOrigin { name: "south".into(), file: "south.rad".into(), line: 1 };
        Window { name: "south".into(), triangles, frame, basis: KlemsBasis::Full.into(), origin }
    }

    /// Vd of an eye behind a window without end, by points of the hemisphere before the eye.
    fn endless(window: &Window, ahead: DVec3) -> Vec<f32> {
        const N: usize = 1200;
        let mut view = vec![0.0f64; window.basis.len()];
        for (i, j) in (0..N * N).map(|k| (k % N, k / N)) {
            let (z, phi) = (2.0 * middle(i, N) - 1.0, std::f64::consts::TAU * middle(j, N));
            let d = DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z);
            if d.dot(window.frame.z) < 0.0 && d.dot(ahead) > 0.0 {
                view[window.basis.bin_of(window.frame.to_local(-d))] += d.dot(ahead) * 2.0 * std::f64::consts::TAU / (N * N) as f64;
            }
        }
        view.into_iter().flat_map(|v| [v as f32; 3]).collect()
    }

    /// Behind a window of endless width each bin is seen whole, however the eye is turned; in the plane of
    /// the eye, where the bin's own cosine vanishes, too.
    #[test]
    fn bins_of_an_endless_window_are_seen_whole_from_any_side() {
        let window = south();
        for ahead in [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [1.0, -0.02, 0.0], [1.0, 0.02, 0.0], [0.0, 0.0, 1.0], [0.5, 0.4, 0.3]] {
            let up = if ahead[2] == 1.0 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
            let frame = ViewFrame::new(ahead, up).unwrap();
            let direct = endless(&window, DVec3::from_array(frame.forward));
            let seen = seen_of_bins(&frame, &direct, std::iter::once(&window));
            for (bin, seen) in seen.iter().enumerate() {
                let (whole, v) = (window.basis.solid_angle(bin), direct[bin * 3]);
                let share = seen[1] / whole;
                // Slivers of bins are known to the width of the points only.
                assert!(share <= 1.0 && (f64::from(v) < 0.01 * whole || share > 0.94), "{ahead:?}, bin {bin}: {share} of {whole}, V {v}");
            }
        }
    }

    /// The patches of a uniform sky behind a clear window have the sky's luminance, along the façade too.
    #[test]
    fn patches_seen_along_the_facade_are_no_brighter_than_the_sky() {
        let (window, sky) = (south(), ReinhartSky::new(2).unwrap());
        // What leaves the window in a bin is the mean of the sky in it.
        let mut direct = Matrix::<f64>::zeros(window.basis.len(), sky.len(), 3);
        for (bin, i) in (0..window.basis.len()).flat_map(|b| (0..1024).map(move |i| (b, i))) {
            let out = -window.frame.to_world(window.basis.direction(bin, middle(i % 32, 32), middle(i / 32, 32)));
            direct.at_mut(bin, sky.bin_of(out)).iter_mut().for_each(|v| *v += 1.0 / 1024.0);
        }
        for ahead in [[1.0, 0.0, 0.0], [1.0, -0.02, 0.0], [1.0, 0.02, 0.0], [-1.0, 1e-17, 0.0], [0.0, -1.0, 0.0], [0.6, -0.8, 0.0]] {
            let frame = ViewFrame::new(ahead, [0.0, 0.0, 1.0]).unwrap();
            let row = endless(&window, DVec3::from_array(frame.forward));
            let eye = Eye { total: &row, direct: &row, standard_error: &row, suns: None };
            let settings = Settings::default();
            let sources = ImagelessSources::new(&frame, &eye, std::iter::once(&window), sky, &direct, None, &settings);
            let bright: Vec<f64> = sources.direct[1..].iter().map(|l| l[1]).collect();
            let seen: Vec<f64> = (1..sky.len())
                .filter(|&p| sky.centre(p).dot(DVec3::from_array(frame.forward)) > 0.3 && sky.centre(p).y < -0.3)
                .map(|p| bright[p - 1])
                .collect();
            let mean = seen.iter().sum::<f64>() / seen.len() as f64;
            // Bins are not as large as patches: single ones differ.
            println!("{ahead:?}: {mean:.3} on average, greatest {:.3}", bright.iter().fold(0.0f64, |a, &b| a.max(b)));
            assert!((mean - 1.0).abs() < 0.1 && bright.iter().all(|l| *l < 2.0), "{ahead:?}: {mean} {bright:?}");
        }
    }
}
