//! What few rays leave open: which share of a window is seen where none or few of them met it, what
//! reflections show that none found, and what light paths bring of which few arrived.

use super::ViewTracer;
use crate::kernels::light_paths::NearPaths;
use crate::kernels::light_paths::doubts::{BinShares, Chances};
use crate::kernels::trace::Window;
use crate::kernels::trace::doubt::{ENOUGH_HITS, Part, half_a_hit, pattern};
/// Samples of one sensor in a bin or a window: what arrived (rgb), and what would with nothing in the way.
type Met = [f64; 4];

/// A share in each channel, nothing if there was no sample.
fn share(met: &Met, c: usize) -> Option<f64> {
    (met[3] > 0.0).then(|| (met[c] / met[3]).min(1.0))
}

fn brightest(met: &Met) -> f64 {
    (0..3).filter_map(|c| share(met, c)).fold(0.0, f64::max)
}

/// What a sensor sees of the windows directly: the sums of `view_matrix/direct`, taken together by windows.
pub(super) struct DirectRow {
    batches: usize,
    bins: usize,
    /// `[batch][bin]`
    own: Vec<Met>,
    /// `[bin]`
    of_bins: Vec<Met>,
    /// `[batch][window]`
    of_batches: Vec<Met>,
    /// `[window]`
    of_windows: Vec<Met>,
    /// Window of each bin.
    window: Vec<usize>,
    /// Nothing stands in the scene that could hide a window.
    free: bool,
}

impl DirectRow {
    /// Of the sums `[batch][sensor][bin][rgb and unobstructed]` those of one sensor among `count`.
    pub fn new(sums: &[u32], (sensor, count): (usize, usize), batches: usize, bins: usize, windows: &[Window], free: bool) -> Self {
        let window: Vec<usize> = windows.iter().enumerate().flat_map(|(w, record)| std::iter::repeat_n(w, record.bins as usize)).collect();
        let mut row = Self {
            batches,
            bins,
            own: Vec::with_capacity(batches * bins),
            of_bins: vec![[0.0; 4]; bins],
            of_batches: vec![[0.0; 4]; batches * windows.len()],
            of_windows: vec![[0.0; 4]; windows.len()],
            window,
            free,
        };
        for batch in 0..batches {
            for bin in 0..bins {
                let cell = ((batch * count + sensor) * bins + bin) * 4;
                let met: Met = std::array::from_fn(|i| f64::from(sums[cell + i]));
                row.own.push(met);
                let w = row.window[bin];
                for sum in [&mut row.of_bins[bin], &mut row.of_batches[batch * windows.len() + w], &mut row.of_windows[w]] {
                    (0..4).for_each(|i| sum[i] += met[i]);
                }
            }
        }
        row
    }

    /// Share of a bin's light that arrives, by a batch. Bins too small for a batch to meet take the share of all
    /// batches; those that no sample met, that of the whole window; of a window that no sample met, a half
    /// may be seen, or all if nothing could hide it.
    pub fn share(&self, batch: usize, bin: usize, c: usize) -> f64 {
        let w = self.window[bin];
        share(&self.own[batch * self.bins + bin], c)
            .or_else(|| share(&self.of_bins[bin], c))
            .or_else(|| share(&self.of_batches[batch * self.of_windows.len() + w], c))
            .or_else(|| share(&self.of_windows[w], c))
            .unwrap_or(if self.free { 1.0 } else { 0.5 })
    }

    /// Deviations of the batches by what few samples leave open, for each bin that has such. `exact` is what
    /// would arrive with nothing in the way, `samples` are those of a batch.
    pub fn doubts(&self, exact: &[f64], samples: f64) -> Vec<(usize, Vec<f64>)> {
        let all = samples * self.batches as f64;
        let whole: f64 = exact.iter().sum();
        let met: f64 = self.of_windows.iter().map(|w| w[3]).sum();
        let number = |m: &Met| if met > 0.0 { all * m[3] / met } else { 0.0 };
        // A window behind something: half a hit more among all samples. (Few are seen, some are not.)
        let hidden: Vec<bool> = self
            .of_windows
            .iter()
            .map(|w| w[3] > 0.0 && brightest(w) < 1.0 && number(w) * brightest(w) < ENOUGH_HITS.min(0.5 * number(w)))
            .collect();
        let behind: f64 = (0..self.bins).filter(|b| hidden[self.window[*b]]).map(|b| exact[b]).sum();
        let of_hidden = pattern(Part::WINDOWS, self.batches);
        let mut doubts = Vec::new();
        for (bin, &value) in exact.iter().enumerate().filter(|(_, value)| **value > 0.0) {
            let w = self.window[bin];
            let mut deviations = vec![0.0; self.batches];
            let mut add = |size: f64, pattern: &[f64]| deviations.iter_mut().zip(pattern).for_each(|(d, p)| *d += size * p);
            if hidden[w] {
                add(half_a_hit(whole * value / behind, all), &of_hidden);
            }
            // Partly seen, as far as some of the bin's few samples say; a window without any is seen or is not.
            let top = (0..self.bins).filter(|b| self.window[*b] == w).map(|b| brightest(&self.of_bins[b])).fold(0.0, f64::max);
            let unmet = (0..self.batches).any(|batch| self.own[batch * self.bins + bin][3] == 0.0);
            if share(&self.of_windows[w], 0).is_none() && self.free {
                continue;
            } else if share(&self.of_windows[w], 0).is_none() {
                add(0.5 * value, &pattern(Part::OTHERS + self.bins + w, self.batches));
            } else if unmet && top > 0.0 {
                let n = number(&self.of_bins[bin]);
                let mean = brightest(&self.of_windows[w]) / top;
                let seen = ((n * brightest(&self.of_bins[bin]) / top + mean) / (n + 1.0)).min(1.0);
                add(value * top * (seen * (1.0 - seen) / (n + 1.0)).sqrt(), &pattern(Part::OTHERS + bin, self.batches));
            }
            if deviations.iter().any(|d| *d != 0.0) {
                doubts.push((bin, deviations));
            }
        }
        doubts
    }
}

/// Values of `view_matrix/gather` per sensor, bin and batch.
pub(super) const GATHERED: usize = 5;

impl ViewTracer<'_> {
    /// Puts half a hit more upon what sensors see by reflections that have no rays of their own, where few of
    /// their paths found a window in them. `open` is what images of windows leave open, per sensor.
    pub(super) fn doubt_reflections(&self, near: &mut NearPaths, open: &[f64]) {
        let (o, count) = (&self.options, open.len());
        if !o.first_round {
            return;
        }
        let other = self.tables.has_other_reflections();
        let batches = o.batches as usize;
        let bins = self.tables.bins();
        let paths = f64::from(o.near_samples) * batches as f64;
        let shares = BinShares::of(&self.tables, self.windows);
        let pattern = pattern(Part::REFLECTIONS, batches);
        for (receiver, open) in open.iter().enumerate() {
            let size = open.hypot(if other { near.doubt(receiver, count, paths) } else { 0.0 });
            for (batch, deviation) in pattern.iter().enumerate().filter(|_| size > 0.0) {
                let row = (batch * count + receiver) * bins * 3;
                for (values, share) in near.sums[row..row + bins * 3].chunks_exact_mut(3).zip(shares.iter()) {
                    values.iter_mut().for_each(|v| *v += (size * deviation * share) as f32);
                }
            }
        }
    }

    /// Half a hit more of what light paths bring to a sensor, per bin, if few of its rays to them arrived. `gathered`:
    /// `[batch][bin][sensor]`, [`GATHERED`] values each.
    pub(super) fn doubt_of_gathered(&self, gathered: &[f32], sensor: usize, count: usize) -> Option<Vec<f64>> {
        let (batches, bins) = (self.options.batches as usize, self.tables.bins());
        if !self.options.first_round {
            return None;
        }
        let mut of_bins = vec![0.0; bins];
        let mut chances = Chances::default();
        for (i, cell) in gathered.chunks_exact(GATHERED).skip(sensor).step_by(count).enumerate() {
            // The mean of the channels.
            let [r, g, b, sum, squares] = std::array::from_fn(|k| f64::from(cell[k]) / 3.0);
            chances.arrived += r + g + b;
            chances.possible += sum;
            chances.squares += squares / 3.0;
            of_bins[i % bins] += sum;
        }
        // Also if all of them arrive: the ends of light paths are found by chance themselves.
        let size = if chances.hits() < ENOUGH_HITS { chances.half_a_hit(batches as f64) } else { 0.0 };
        (size > 0.0).then(|| of_bins.iter().map(|p| size * p / chances.possible).collect())
    }
}
