//! All hours of a view, pass by pass.

use super::noise::{Batches, DiscChange, HourNoise, Light, Slopes};
use super::stack::Stack;
use super::{Added, AddedLight, Additions, Detector, GlarePixels, Loaded, Pass, coefficients};
use crate::error::{Error, Result};
use crate::glare::{Disc, Glare, GlarePixels as Found, Indices, PEAK_LIMIT, Totals, detect, disc, veil};
use crate::gpu::{DEFAULT_MEMORY, allowed};
use crate::kernels::product::reference::gamma;
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use rayon::prelude::*;

/// Bytes of a glare pixel on its way, copies included.
const GLARE_PIXEL_BYTES: u64 = 32;
/// Bytes of a pixel with additional light, copies included.
const ADDITION_BYTES: u64 = 48;
/// Most hours in a pass: enough for efficient products.
const MOST_HOURS: usize = 512;
/// Hours of which whole pictures are in memory at a time, where the veil needs them.
const WHOLE_PICTURES: usize = 8;

/// What a year is made from, beside the view's [`Stack`].
pub struct Year<'a> {
    /// Right factors, one per left factor of the stack: `[bin][hour]`, RGB radiance.
    pub rights: &'a [&'a Matrix<f32>],
    /// Light added hour by hour.
    pub additions: Option<&'a dyn Additions>,
    /// Vertical illuminance of each hour (lx) that DGP takes instead of the picture's own.
    pub illuminance: Option<&'a [f64]>,
    /// Independent estimates of the first left factor.
    pub batches: Option<&'a Batches>,
    /// Noise of the right factors.
    pub noise: Option<&'a dyn HourNoise>,
    /// Hours in a pass at most; 0 for as many as are good.
    pub hours_per_pass: usize,
    /// Whether tiles that cannot have glare are left out. The results are the same.
    pub skip: bool,
    /// Memory for glare pixels, bytes.
    pub memory: u64,
}

impl<'a> Year<'a> {
    /// A year of these right factors with nothing else.
    pub fn new(rights: &'a [&'a Matrix<f32>]) -> Self {
        Self {
            rights,
            additions: None,
            illuminance: None,
            batches: None,
            noise: None,
            hours_per_pass: 0,
            skip: true,
            memory: DEFAULT_MEMORY,
        }
    }
}

/// Glare of one hour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HourGlare {
    /// The indices.
    pub indices: Indices,
    /// Standard error of DGP that the noise of the matrices leaves; 0 where none was given.
    pub standard_error: f64,
    /// Vertical illuminance that DGP was made from, lx.
    pub vertical_illuminance: f64,
    /// Mean luminance, cd/m².
    pub average_luminance: f64,
    /// Background luminance, cd/m².
    pub background_luminance: f64,
    /// Luminance above which a pixel was glare, cd/m².
    pub threshold: f64,
    /// Number of glare sources.
    pub sources: usize,
}

/// A view's pixels where the detector wants them, once for all years (states of the façade).
pub struct ReadyView<'a, 's> {
    detector: &'a dyn Detector,
    stack: &'a Stack<'s>,
    /// Nothing if the pixels do not fit the memory: they are loaded for every pass anew.
    loaded: Option<Box<dyn Loaded + 'a>>,
}

impl<'a, 's> ReadyView<'a, 's> {
    /// Loads the pixels.
    ///
    /// # Errors
    /// Memory and other failures of a device.
    pub fn new(detector: &'a dyn Detector, stack: &'a Stack<'s>) -> Result<Self> {
        let loaded = stack.resident().map(|bands| detector.load(stack.bands_of(bands))).transpose()?;
        Ok(Self { detector, stack, loaded })
    }
}

/// Glare of all hours, the columns of the right factors, in their order.
///
/// # Errors
/// Shapes that do not fit, failures of sources and device, and [`cancelled`].
pub fn year(view: &ReadyView<'_, '_>, request: &Year, progress: &dyn Progress) -> Result<Vec<HourGlare>> {
    let stack = view.stack;
    let hours = check(stack, request)?;
    let pixel_bytes = GLARE_PIXEL_BYTES + if request.additions.is_some() { ADDITION_BYTES } else { 0 };
    let per_hour = stack.candidates().max(1) as u64 * pixel_bytes;
    let by_memory = usize::try_from(allowed(request.memory) / per_hour).unwrap_or(usize::MAX).clamp(1, MOST_HOURS);
    let per_pass = if request.hours_per_pass > 0 { by_memory.min(request.hours_per_pass) } else { by_memory };
    let work = Work { view, stack, request };
    let mut results = Vec::with_capacity(hours);
    for first in (0..hours).step_by(per_pass) {
        progress.update("glare", first as f64 / hours as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        results.extend(work.pass(first, per_pass.min(hours - first))?);
    }
    progress.update("glare", 1.0);
    Ok(results)
}

/// The number of hours.
fn check(stack: &Stack<'_>, request: &Year) -> Result<usize> {
    let shapes: Vec<usize> = request.rights.iter().map(|r| r.rows()).collect();
    if shapes != stack.bins() {
        return Err(Error::new(format!("view matrices of {:?} columns do not fit coefficients of {shapes:?} rows", stack.bins())));
    }
    let hours = request.rights[0].cols();
    if request.rights.iter().any(|r| r.cols() != hours || r.components() != 3) {
        return Err(Error::new("the coefficients of a picture's matrices must all be RGB and of the same hours"));
    }
    match request.illuminance {
        Some(given) if given.len() != hours => Err(Error::new(format!("{} illuminances do not fit {hours} hours", given.len()))),
        Some(given) if given.iter().any(|e| !(e.is_finite() && *e >= 0.0)) => {
            Err(Error::new("a vertical illuminance is not a finite number from 0 lx"))
        }
        _ => Ok(hours),
    }
}

struct Work<'a, 's> {
    view: &'a ReadyView<'a, 's>,
    stack: &'a Stack<'s>,
    request: &'a Year<'a>,
}

/// Added light as detectors want it.
fn lit(added: &[AddedLight]) -> Vec<(u32, f32)> {
    added.iter().map(|a| (a.pixel, a.luminance)).collect()
}

/// What an hour's picture amounts to without its glare pixels.
#[derive(Clone, Copy)]
struct Sums {
    totals: Totals,
    task: Option<f64>,
    threshold: f64,
}

impl Work<'_, '_> {
    fn detect(&self, pass: &Pass) -> Result<Vec<GlarePixels>> {
        if let Some(loaded) = &self.view.loaded {
            return loaded.detect(pass);
        }
        let mut parts = Vec::new();
        self.stack.for_each_group(&mut |bands| {
            parts.extend(self.view.detector.load(self.stack.bands_of(bands))?.detect(pass)?);
            Ok(())
        })?;
        Ok(parts)
    }

    fn pass(&self, first: usize, count: usize) -> Result<Vec<HourGlare>> {
        let (stack, terms) = (self.stack, self.stack.terms());
        let all = coefficients(stack, self.request.rights, first..first + count);
        let additions = (first..first + count).into_par_iter().map(|hour| self.added(hour)).collect::<Result<Vec<_>>>()?;
        let sums: Vec<Sums> = all.par_chunks_exact(terms).zip(&additions).map(|(c, added)| self.sums(c, added)).collect::<Result<_>>()?;
        // With a veil peaks are looked for too, wherever the threshold is.
        let limit = if stack.options.veil.is_some() { self.peak_limit().next_down() } else { f64::INFINITY };
        let thresholds: Vec<f64> = sums.iter().map(|s| s.threshold.min(limit)).collect();
        let magnitude = |c: &[f32]| -> f64 { c.iter().zip(&stack.rows.greatest).map(|(&c, g)| f64::from(c).abs() * g).sum() };
        // Both the bound and the luminance are sums in f32, at most two for each.
        let rounding = 4.0 * gamma(terms + 4);
        let hours: Vec<usize> = (0..count)
            .filter(|&h| {
                let most = magnitude(&all[h * terms..(h + 1) * terms]) * (1.0 + rounding);
                !self.request.skip || !additions[h].pixels.is_empty() || most > thresholds[h]
            })
            .collect();
        let pass = Pass {
            terms,
            coefficients: hours.iter().flat_map(|&h| &all[h * terms..(h + 1) * terms]).copied().collect(),
            thresholds: hours.iter().map(|&h| thresholds[h]).collect(),
            margins: hours.iter().map(|&h| rounding * magnitude(&all[h * terms..(h + 1) * terms])).collect(),
            additions: hours.iter().map(|&h| lit(&additions[h].pixels)).collect(),
            skip: self.request.skip,
        };
        let parts = if hours.is_empty() { Vec::new() } else { self.detect(&pass)? };
        let of = |h: usize| Light { hour: first + h, coefficients: &all[h * terms..(h + 1) * terms], added: &additions[h] };
        let place: Vec<Option<usize>> = (0..count).map(|h| hours.binary_search(&h).ok()).collect();
        let judged: Vec<(HourGlare, bool)> = (0..count)
            .into_par_iter()
            .map(|h| {
                let (pixels, luminance) = place[h].map_or_else(Default::default, |at| joined(&parts, at));
                let has_peaks = stack.options.veil.is_some() && luminance.iter().any(|&l| f64::from(l) >= self.peak_limit());
                if has_peaks {
                    // Judged below, from the whole picture.
                    return self.hour(of(h), &sums[h], &[], &[]).map(|glare| (glare, true));
                }
                self.hour(of(h), &sums[h], &pixels, &luminance).map(|glare| (glare, false))
            })
            .collect::<Result<_>>()?;
        let veiled: Vec<usize> = (0..count).filter(|&h| judged[h].1).collect();
        let mut results: Vec<HourGlare> = judged.into_iter().map(|(glare, _)| glare).collect();
        for hours in veiled.chunks(WHOLE_PICTURES) {
            let whole = Pass {
                terms,
                coefficients: hours.iter().flat_map(|&h| &all[h * terms..(h + 1) * terms]).copied().collect(),
                thresholds: vec![f64::NEG_INFINITY; hours.len()],
                margins: vec![0.0; hours.len()],
                additions: hours.iter().map(|&h| lit(&additions[h].pixels)).collect(),
                skip: false,
            };
            let parts = self.detect(&whole)?;
            let veiled: Vec<HourGlare> = (0..hours.len())
                .into_par_iter()
                .map(|at| {
                    let (pixels, luminance) = joined(&parts, at);
                    self.veiled_hour(of(hours[at]), &sums[hours[at]], &pixels, &luminance)
                })
                .collect::<Result<_>>()?;
            hours.iter().zip(veiled).for_each(|(&h, glare)| results[h] = glare);
        }
        Ok(results)
    }

    fn peak_limit(&self) -> f64 {
        self.stack.analyser().settings().peak_limit.unwrap_or(PEAK_LIMIT)
    }

    fn added(&self, hour: usize) -> Result<Added> {
        let Some(additions) = self.request.additions else { return Ok(Added::default()) };
        let added = additions.of_hour(hour)?;
        let count = self.stack.analyser().geometry().pixel_count();
        let sound = added.pixels.is_sorted_by(|a, b| a.pixel < b.pixel)
            && added.pixels.iter().all(|p| (p.pixel as usize) < count && p.luminance.is_finite() && p.luminance >= 0.0)
            && self.stack.options.dark_pixels;
        if !sound && !added.pixels.is_empty() {
            return Err(Error::new(format!("the light added in hour {hour} is not a list of pixels of the view")));
        }
        Ok(added)
    }

    fn sums(&self, coefficients: &[f32], added: &Added) -> Result<Sums> {
        let (rows, geometry) = (&self.stack.rows, self.stack.analyser().geometry());
        let times = |row: &[f64]| -> f64 { row.iter().zip(coefficients).map(|(r, &c)| r * f64::from(c)).sum() };
        let (mut illuminance, mut flux, mut task) = (times(&rows.illuminance), times(&rows.flux), times(&rows.task));
        let task_pixels = self.stack.analyser().task_pixels();
        let task_solid_angle = disc::task_solid_angle(geometry, task_pixels);
        for &AddedLight { pixel, luminance: l, .. } in &added.pixels {
            let p = pixel as usize;
            illuminance += f64::from(l) * geometry.projected_solid_angles[p];
            flux += f64::from(l) * geometry.solid_angles[p];
            if task_pixels.binary_search(&pixel).is_ok() {
                task += f64::from(l) * geometry.solid_angles[p] / task_solid_angle;
            }
        }
        // Subtracted terms may leave a little less than nothing.
        let mut totals = Totals {
            vertical_illuminance: illuminance.max(0.0),
            average_luminance: flux.max(0.0) / geometry.total_solid_angle(),
            solid_angle: geometry.total_solid_angle(),
        };
        let settings = self.stack.analyser().settings();
        let mut task = settings.task.is_some().then_some(task.max(0.0));
        self.stack.analyser().add_discs(&added.discs, &mut totals, &mut task);
        if !(illuminance.is_finite() && totals.vertical_illuminance.is_finite() && totals.average_luminance.is_finite()) {
            return Err(Error::new("the light of an hour is not finite").help("look for infinite or extreme values in the input"));
        }
        let threshold = settings.threshold.luminance(totals.average_luminance, task);
        Ok(Sums { totals, task, threshold })
    }

    fn hour(&self, light: Light<'_>, sums: &Sums, pixels: &[u32], luminance: &[f32]) -> Result<HourGlare> {
        let analyser = self.stack.analyser();
        let given = self.request.illuminance.map(|all| all[light.hour]);
        let found = Found { pixels, luminance };
        let discs = self.shown(&light.added.discs, sums.threshold)?;
        let glare = if self.stack.options.veil.is_some() {
            let searched = analyser.searched();
            let wanted = |&(&p, &l): &(&u32, &f32)| searched[p as usize] && f64::from(l) > sums.threshold;
            let (pixels, luminance): (Vec<u32>, Vec<f32>) = pixels.iter().zip(luminance).filter(wanted).unzip();
            analyser.judge(&sums.totals, sums.task, Found { pixels: &pixels, luminance: &luminance }, &discs, given)
        } else {
            analyser.judge(&sums.totals, sums.task, found, &discs, given)
        };
        self.result(light, found, &glare, given)
    }

    /// Peaks spread, from all pixels of the picture.
    fn veiled_hour(&self, light: Light<'_>, sums: &Sums, pixels: &[u32], luminance: &[f32]) -> Result<HourGlare> {
        let analyser = self.stack.analyser();
        let geometry = analyser.geometry();
        let mut picture = vec![0.0f32; geometry.pixel_count()];
        pixels.iter().zip(luminance).for_each(|(&p, &l)| picture[p as usize] = l.max(0.0));
        if let Some(width) = self.stack.options.veil {
            veil::spread_peaks(&mut picture, geometry, self.peak_limit(), width)?;
        }
        let given = self.request.illuminance.map(|all| all[light.hour]);
        // The veil moves light, so that the sums without discs are the picture's.
        let mut totals = geometry.totals(&picture)?;
        let mut task = sums.task.map(|_| geometry.mean_luminance(&picture, analyser.task_pixels()));
        analyser.add_discs(&light.added.discs, &mut totals, &mut task);
        let threshold = analyser.settings().threshold.luminance(totals.average_luminance, task);
        let glaring = detect::glare_pixels(&picture, analyser.searched(), threshold);
        let values: Vec<f32> = glaring.iter().map(|&p| picture[p as usize]).collect();
        let discs = self.shown(&light.added.discs, threshold)?;
        let glare = analyser.judge(&totals, task, Found { pixels: &glaring, luminance: &values }, &discs, given);
        // Spread light is not that of single pixels.
        self.result(light, Found { pixels: &[], luminance: &[] }, &glare, given)
    }

    /// Discs as the eye sees them: spread, if there is a veil.
    fn shown(&self, discs: &[Disc], threshold: f64) -> Result<Vec<Disc>> {
        let Some(width) = self.stack.options.veil else { return Ok(discs.to_vec()) };
        let spread = discs.iter().map(|d| veil::spread_disc(d, width, self.peak_limit(), threshold));
        Ok(spread.collect::<Result<Vec<_>>>()?.concat())
    }

    /// What one standard error more of each disc changes.
    fn disc_changes(&self, discs: &[Disc], threshold: f64) -> Result<Vec<DiscChange>> {
        let analyser = self.stack.analyser();
        let (settings, frame) = (analyser.settings(), &analyser.geometry().frame);
        let judged = settings.convention.frame(analyser.geometry());
        let contrast = |d: Disc| self.shown(&[d], threshold).map(|shown| disc::contrast(&shown, &judged, threshold, settings).0);
        let change = |d: &Disc| {
            let more = d.with_more_seen();
            let illuminance = more.illuminance(frame) - d.illuminance(frame);
            Ok(DiscChange { illuminance, contrast: contrast(more)? - contrast(*d)? })
        };
        discs.iter().filter(|d| d.error > 0.0).map(change).collect()
    }

    fn result(&self, light: Light<'_>, found: Found<'_>, glare: &Glare, given: Option<f64>) -> Result<HourGlare> {
        let ev = given.unwrap_or(glare.vertical_illuminance);
        let mut standard_error = 0.0;
        let discs = self.disc_changes(&light.added.discs, glare.threshold)?;
        let is_noisy = self.request.batches.is_some()
            || self.request.noise.is_some()
            || light.added.shared.batches > 1
            || !discs.is_empty()
            || light.added.pixels.iter().any(|a| a.error > 0.0);
        if is_noisy && ev > 0.0 {
            let slopes = Slopes::new(glare, given, self.stack, &light.added.pixels, found);
            let variance = slopes.variance(self.stack, &light, &discs, self.request.batches, self.request.noise);
            // Where there is hardly any light the slopes are as good as infinite; DGP spans no more than 1.
            standard_error = if variance <= 1.0 { variance.max(0.0).sqrt() } else { 1.0 };
        }
        Ok(HourGlare {
            indices: glare.indices,
            standard_error,
            vertical_illuminance: ev,
            average_luminance: glare.average_luminance,
            background_luminance: glare.background_luminance,
            threshold: glare.threshold,
            sources: glare.sources.len(),
        })
    }
}

/// The pixels of an hour from all parts of the view.
fn joined(parts: &[GlarePixels], hour: usize) -> (Vec<u32>, Vec<f32>) {
    let len = parts.iter().map(|p| p.of_hour(hour).0.len()).sum();
    let (mut pixels, mut luminance) = (Vec::with_capacity(len), Vec::with_capacity(len));
    for part in parts {
        let (p, l) = part.of_hour(hour);
        pixels.extend_from_slice(p);
        luminance.extend_from_slice(l);
    }
    (pixels, luminance)
}
