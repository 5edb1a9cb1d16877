//! What the noise of V and D does to the illuminance of single hours.
//!
//! The product is linear in each matrix, so to first order its error is the sum of what each matrix'
//! error does: `δI = δ[V − Vd | Vd]·[X ; X − Xsun] + [V − Vd | Vd]·δ[X ; X − Xsun]`. Every
//! matrix comes as independent replicates ([`Estimate`](crate::simulate::sampling::estimate::Estimate)). Replicate by replicate, all entries changing
//! together as their common rays have it, they give as many independent values of each illuminance:
//! their mean is the result, their spread its standard error, and with R of them
//! `(mean − truth) / error` follows Student's distribution with R − 1 degrees of freedom.

use super::illuminance::illuminance;
use crate::error::Result;
use crate::kernels::product::{Multiplier, chain};
use crate::matrix::Matrix;
use crate::simulate::inputs::Differences;
use crate::simulate::inputs::states::WindowUse;
use crate::simulate::light::{Light, Skies, without_sun};
use crate::simulate::multiply::{put_columns, select_columns};
use crate::simulate::sampling::chain::Chain;
use crate::simulate::sampling::estimate::mean_of;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Standard errors relative to the values, as fractions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EstimatedError {
    /// Of a sensor's sum over all hours: median over the sensors. Where the mean is below 0.1 lx, in relation
    /// to that.
    pub annual_median: f64,
    /// The largest of them.
    pub annual_largest: f64,
    /// Of a single daylight hour at one sensor: median.
    pub hourly_median: f64,
    /// Exceeded by one in twenty.
    pub hourly_95th_percentile: f64,
    /// Sensors.
    pub sensors: usize,
    /// Daylight hours.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours: f64,
    /// Multiply a standard error by this for the interval that holds the converged value in 95 % of
    /// cases.
    pub confidence_95: f64,
    /// What `annual_largest` should be at most: asked for, or meant by the preset.
    pub target: Option<f64>,
    /// Whether it is.
    pub target_met: Option<bool>,
}

/// Rows of all sensors that the deviations are measured from, and what each replicate changes in them.
pub(crate) struct Deviations<'m> {
    chain: &'m Chain<'m>,
    /// Left factor of the formula, `[sensor][bin]`.
    receivers: Matrix<f32>,
    /// Its change by each replicate of V; empty if V is exact.
    changes: Vec<Matrix<f32>>,
    light: &'m Light,
    /// Skies of the lit hours.
    skies: Skies,
}

impl<'m> Deviations<'m> {
    /// Deviations of a chain whose mean light is `light`.
    pub(crate) fn new(chain: &'m Chain<'m>, light: &'m Light) -> Self {
        let lit = |sky: &Matrix<f32>| select_columns(sky, &light.hours);
        let skies = Skies { whole: lit(chain.sky), sun: chain.sun.map(lit) };
        let (total, direct) = (chain.view.total(), chain.view.mean_replaced());
        let mean_direct = mean_of(chain.view.replaced());
        // Differences of noise have either sign.
        let rows = |total: &Matrix<f32>, direct: &Matrix<f32>| light.receivers(total, direct, Differences::Noisy);
        let mean = rows(&mean_of(&chain.view.replicates), &mean_direct);
        let changes = match chain.view.replicates.len() {
            0 | 1 => Vec::new(),
            n => (0..n)
                .map(|r| {
                    let own = rows(&chain.view.replicates[r], chain.view.replaced().get(r).unwrap_or(&mean_direct));
                    own.less(&mean)
                })
                .collect(),
        };
        Self { chain, receivers: light.receivers(&total, &direct, chain.inputs.differences()), changes, light, skies }
    }

    /// What each replicate's illuminances differ from their mean by, for some sensors: `[replicate · sensor][hour]`,
    /// lx. Nothing if all matrices are exact.
    ///
    /// # Errors
    /// Failures of the multiplier's device.
    pub(crate) fn of(&self, multiplier: &dyn Multiplier, sensors: std::ops::Range<usize>) -> Result<Option<Matrix<f32>>> {
        let (replicates, n) = (self.chain.replicates(), sensors.len());
        if replicates < 2 || n == 0 {
            return Ok(None);
        }
        let width = self.receivers.cols() * 3;
        let rows = |m: &Matrix<f32>| m.data()[sensors.start * width..sensors.end * width].to_vec();
        let shaped = |data: Vec<f32>, rows: usize| Matrix::from_data(rows, self.receivers.cols(), 3, data);
        let hours = self.light.hours.len();
        let mut lux = match self.changes.len() {
            0 => Matrix::zeros(replicates * n, hours, 1),
            _ => {
                let mut changes: Vec<f32> = self.changes.iter().flat_map(rows).collect();
                changes.resize(replicates * n * width, 0.0);
                illuminance(multiplier, &shaped(changes, replicates * n)?, &self.light.right)?
            }
        };
        let receivers = shaped(rows(&self.receivers), n)?;
        let mut first = 0;
        for (number, window) in self.chain.windows().iter().enumerate() {
            let bins = first..first + window.bins();
            first = bins.end;
            let seen = self.columns_of(&receivers, bins)?;
            let daylight = &self.chain.daylight[number];
            if daylight.replicates.len() < 2 {
                continue;
            }
            let means = [mean_of(&daylight.replicates), mean_of(&daylight.direct)];
            for r in 0..daylight.replicates.len() {
                let change = self.change_of_light(multiplier, number, r, &means)?;
                let part = illuminance(multiplier, &seen, &change)?;
                let own = &mut lux.data_mut()[r * n * hours..(r + 1) * n * hours];
                own.par_iter_mut().zip(part.data()).for_each(|(sum, v)| *sum += v);
            }
        }
        Ok(Some(self.light.over_the_year(&lux)))
    }

    /// The columns of one window, in both halves of the rows.
    fn columns_of(&self, receivers: &Matrix<f32>, bins: std::ops::Range<usize>) -> Result<Matrix<f32>> {
        let halves = if self.light.is_split() { 2 } else { 1 };
        let of = |half: usize| (half * self.light.bins + bins.start) * 3..(half * self.light.bins + bins.end) * 3;
        let data = (0..receivers.rows()).flat_map(|row| (0..halves).flat_map(move |half| receivers.row(row)[of(half)].to_vec())).collect();
        Matrix::from_data(receivers.rows(), halves * bins.len(), 3, data)
    }

    /// What a replicate of a window's D changes in the right factor of the formula, from the means of D and Dd.
    fn change_of_light(
        &self,
        multiplier: &dyn Multiplier,
        window: usize,
        replicate: usize,
        [total, direct]: &[Matrix<f32>; 2],
    ) -> Result<Matrix<f32>> {
        let inputs = self.chain.inputs;
        let uses = inputs.uses(window);
        if let [used] = &uses[..] {
            return self.change_in_use(multiplier, (window, used), replicate, [total, direct], &self.skies);
        }
        // Each state in its own hours.
        let bins = inputs.windows[window].bins();
        let mut all = Matrix::zeros(if self.light.is_split() { 2 * bins } else { bins }, self.light.hours.len(), 3);
        for used in &uses {
            let columns: Vec<usize> = (0..self.light.hours.len()).filter(|c| used.holds(self.light.hours[*c])).collect();
            let of = |sky: &Matrix<f32>| select_columns(sky, &columns);
            let skies = Skies { whole: of(&self.skies.whole), sun: self.skies.sun.as_ref().map(of) };
            let part = self.change_in_use(multiplier, (window, used), replicate, [total, direct], &skies)?;
            let rows = all.rows();
            put_columns(&mut all, 0, &columns, &part, 0..rows);
        }
        Ok(all)
    }

    /// The same of a window in one of its states, in the hours of these skies.
    fn change_in_use(
        &self,
        multiplier: &dyn Multiplier,
        (window, used): (usize, &WindowUse<'_>),
        replicate: usize,
        [total, direct]: [&Matrix<f32>; 2],
        skies: &Skies,
    ) -> Result<Matrix<f32>> {
        let estimate = &self.chain.daylight[window];
        let transmission = used.transmission.map(|v| v as f32);
        let through = |all: &[Matrix<f32>], mean: &Matrix<f32>, sky: &Matrix<f32>| {
            let change = all[replicate].less(mean);
            let (rows, cols) = (transmission.cols(), change.cols());
            let mut light = Vec::new();
            for part in change.data().chunks(rows * cols * 3) {
                let part = Matrix::from_data(rows, cols, 3, part.to_vec())?;
                light.extend(chain(multiplier, &[&transmission, &part, sky])?.into_data());
            }
            Matrix::from_data(change.rows(), sky.cols(), 3, light)
        };
        let all = through(&estimate.replicates, total, &skies.whole)?;
        if !self.light.is_split() {
            return Ok(all);
        }
        let sun = match skies.sun.as_ref().filter(|_| used.is_sunny && estimate.direct.len() > 1) {
            Some(sun) => through(&estimate.direct, direct, sun)?,
            None => Matrix::zeros(all.rows(), all.cols(), 3),
        };
        Ok(without_sun(all, &sun, Differences::Noisy))
    }
}

#[cfg(test)]
mod tests;
