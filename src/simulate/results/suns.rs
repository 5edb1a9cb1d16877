//! The suns of five phases at the sensors: Cds·Ssun, and its error.

use super::illuminance::luminous;
use crate::error::{Result, Warnings};
use crate::kernels::sun_matrix::SunMatrix;
use crate::matrix::Matrix;
use crate::metrics::Occupancy;
use crate::simulate::context::{Context, Ledger, Traced};
use crate::simulate::inputs::shade;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::phases::facade_suns::FacadeSuns;
use crate::simulate::phases::sun::{SunEntry, write_suns};
use crate::simulate::plan::presets::{coefficient_options, sun_options};
use rayon::prelude::*;
use std::time::Instant;

/// The suns of five phases and what they send to the sensors.
pub(crate) struct TracedSuns {
    /// The suns and their hours.
    pub facade: FacadeSuns,
    /// Cds of all sensors.
    matrix: SunMatrix,
    /// Suns whose numbers differ by a multiple of this have scattered errors in common.
    error_sets: usize,
}

impl TracedSuns {
    /// Traces the suns of a project, or takes those of an earlier run; nothing with fewer phases.
    ///
    /// # Errors
    /// Failures of device and file system, or when stopped.
    pub fn trace(context: &Context<'_>, ledger: &mut Ledger, warnings: &mut Warnings) -> Result<Option<Self>> {
        if context.choice.phases != 5 {
            return Ok(None);
        }
        let clock = Instant::now();
        context.check_stop()?;
        let (project, inputs) = (context.project, context.inputs);
        let facade = FacadeSuns::new(inputs, project)?;
        let used = inputs.windows_in_use();
        shade::warn_of_mirrors(used.iter().filter_map(|w| w.shade.as_ref()), warnings);
        let way = if context.choice.direct { SunEntry::Anywhere } else { SunEntry::Windows };
        let (matrix, traced) = facade.matrix(context, &inputs.sensors, way, "")?;
        write_suns(context, &facade.base)?;
        // Through panes of data all suns share their cells; where sensors see the sky, the surfaces that their own paths meet.
        let error_sets = match way {
            _ if used.iter().any(|w| w.pane.is_some()) => 1,
            SunEntry::Anywhere => coefficient_options(project, 0).sun_sets,
            SunEntry::Windows => sun_options(project).path_sets,
        } as usize;
        for group in &inputs.sensors {
            let (name, seconds) = (format!("C_{}", group.name), clock.elapsed().as_secs_f64());
            ledger.note(
                &name,
                [group.sensors.len(), facade.set.suns.len()],
                !traced,
                seconds,
                Traced { rounds: 0, rays: matrix.statistics.segments },
            );
        }
        if traced {
            ledger.count(matrix.statistics, clock);
        }
        Ok(Some(Self { facade, matrix, error_sets }))
    }

    /// These suns through a façade each of whose groups had its suns traced alone, at the sensors.
    ///
    /// # Errors
    /// Failures of device and file system, or when stopped.
    pub fn apart(context: &Context<'_>, suns: SunSet) -> Result<Self> {
        let facade = FacadeSuns::of(context.inputs, suns);
        let (matrix, _) = facade.matrix_apart(context, &context.inputs.sensors)?;
        Ok(Self { facade, matrix, error_sets: 1 })
    }

    /// The suns and their hours; of a façade that moves, a sun counts once for each thing that it passes.
    pub fn set(&self) -> &SunSet {
        &self.facade.set
    }

    /// Cds·Ssun, lux `[sensor][hour]`: one product per hour with sun.
    pub fn illuminance(&self) -> Matrix<f32> {
        let hours = &self.set().hours;
        let mut lux = Matrix::zeros(self.matrix.total.rows(), hours.len(), 1);
        if hours.is_empty() {
            return lux;
        }
        lux.data_mut().par_chunks_mut(hours.len()).enumerate().for_each(|(sensor, row)| {
            for (value, hour) in row.iter_mut().zip(hours) {
                if let Some((sun, radiance)) = hour {
                    *value = (luminous(self.matrix.total.at(sensor, *sun)) * radiance) as f32;
                }
            }
        });
        lux
    }

    /// Time steps in which a sensor sees the sun, or a part of its disc, directly, panes between them or not.
    pub fn steps_in_sun(&self, sensor: usize) -> usize {
        self.set()
            .hours
            .iter()
            .flatten()
            .filter(|(sun, radiance)| *radiance > 0.0 && luminous(self.matrix.direct.at(sensor, *sun)) > 0.0)
            .count()
    }

    /// Hours, of those of `time`, in which a sensor gets more than `lux` directly from the sun, and the same with the
    /// standard error of each hour less and more; `length` of a step in hours.
    pub fn hours_above(&self, sensor: usize, lux: f64, time: &Occupancy, length: f64) -> [f64; 3] {
        let count = |side: f64| {
            let above = |step: &&usize| {
                self.set().hours[**step].is_some_and(|(sun, radiance)| {
                    let of = |m: &Matrix<f32>| luminous(m.at(sensor, sun)) * radiance;
                    of(&self.matrix.direct) + side * of(&self.matrix.own_error) > lux
                })
            };
            time.steps.iter().filter(above).count() as f64 * length
        };
        [0.0, -1.0, 1.0].map(count)
    }

    /// Variance of a sensor's illuminance by suns in an hour, or of its sum over the year: lx², (lx·h)².
    /// Own errors of different suns are independent. Shared ones, of what shades and panes scatter, are one and the
    /// same for suns of one set. The direct term that is taken away needs no error of its own: V's and
    /// D's, multiplied with the whole sky, bound that of the difference, which shares their rays.
    pub fn variance(&self) -> impl Fn(usize, Option<usize>) -> f64 + Sync + '_ {
        // Over the year a sun counts with its radiance of all hours.
        let mut yearly = vec![0.0; self.set().suns.len()];
        for (sun, radiance) in self.set().hours.iter().flatten() {
            yearly[*sun] += radiance;
        }
        move |sensor, hour| {
            let errors = |s: usize| (luminous(self.matrix.own_error.at(sensor, s)), luminous(self.matrix.shared_error.at(sensor, s)));
            match hour {
                Some(hour) => self.set().hours[hour].map_or(0.0, |(s, radiance)| {
                    let (own, shared) = errors(s);
                    (own * radiance).powi(2) + (shared * radiance).powi(2)
                }),
                None => {
                    // A sun that passes different states has the same rays in all of them: their errors go together.
                    let mut own = vec![0.0; self.facade.base.suns.len()];
                    let mut shared = vec![0.0; self.error_sets];
                    for (s, radiance) in yearly.iter().enumerate() {
                        let ((a, b), (_, sun)) = (errors(s), self.facade.places[s]);
                        own[sun] += a * radiance;
                        shared[sun % self.error_sets] += b * radiance;
                    }
                    own.iter().map(|error| error * error).sum::<f64>() + shared.iter().map(|error| error * error).sum::<f64>()
                }
            }
        }
    }
}
