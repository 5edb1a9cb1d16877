//! V and D of a run: sampled together, since one stops when the other is good enough, and kept.

use super::pictures::SHARE_OF_VIEW;
use super::{Run, split};
use crate::error::Result;
use crate::kernels::daylight_matrix::{self, DaylightOptions, unobstructed};
use crate::kernels::trace::TraceStatistics;
use crate::kernels::view_matrix::{self, ViewOptions};
use crate::matrix::Matrix;
use crate::scene::Window;
use crate::scene::points::Sensor;
use crate::simulate::estimate::Estimate;
use crate::simulate::fingerprint::Fingerprint;
use crate::simulate::glare::eye;
use crate::simulate::import::{self, Imported};
use crate::simulate::inputs::Inputs;
use crate::simulate::presets::{daylight_options, view_options};
use crate::simulate::sampling::{Source, Stop, sample};
use crate::simulate::summary::Seconds;
use crate::simulate::uncertainty::Chain;
use crate::sky::{SkyOptions, sky_matrix};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The sampled matrices.
pub(super) struct Sampled {
    /// V of all sensors.
    pub view: Estimate,
    /// D of each window.
    pub daylight: Vec<Estimate>,
    /// Sds, where five phases take the sun out.
    pub sun: Option<Matrix<f32>>,
}

impl Sampled {
    /// For the errors of its product with S.
    pub fn chain<'m>(&'m self, inputs: &'m Inputs, sky: &'m Matrix<f32>) -> Chain<'m> {
        Chain { inputs, view: &self.view, daylight: &self.daylight, sky, sun: self.sun.as_ref() }
    }
}

impl Run<'_> {
    /// V of all groups and D of all windows, sampled as `[quality]` asks.
    pub(super) fn sampled(&mut self, sky: &Matrix<f32>) -> Result<Sampled> {
        self.check_stop()?;
        let (project, inputs, device) = (self.project, self.inputs, self.device);
        let windows: Vec<_> = inputs.windows.iter().map(|w| w.window.clone()).collect();
        let sensors: Vec<Sensor> = inputs.sensors.iter().flat_map(|g| &g.sensors).copied().collect();
        let straight = self.choice.phases == 5;
        let stop = project.quality.stop();
        let statistics = Mutex::new(TraceStatistics::default());
        let seconds = Mutex::new(Seconds::default());
        let none = || Matrix::zeros(0, inputs.bins(), 3);
        let view_options = |round| ViewOptions { keep_batches: true, ..view_options(project, round) };
        let mut view_inputs = self.view_fingerprint("V");
        view_inputs.add(&sensors).add(&view_options(0)).add(&straight);
        let given = import::view(inputs.sensors.iter().map(|g| (g.name.as_str(), g.view.as_ref())), inputs.bins())?;
        if let Some(given) = &given {
            given.mark(&mut view_inputs);
        }
        let mut sources = vec![Source {
            name: "V".into(),
            inputs: view_inputs,
            shape: (sensors.len(), inputs.bins()),
            keep_straight: straight,
            trace: Box::new(|round, progress| {
                let clock = Instant::now();
                let traced = view_matrix::compute(device, &inputs.scene, &windows, &sensors, &view_options(round), progress)?;
                statistics.lock().unwrap_or_else(PoisonError::into_inner).add(traced.statistics);
                seconds.lock().unwrap_or_else(PoisonError::into_inner).view += clock.elapsed().as_secs_f64();
                Ok(traced)
            }),
            exact: sensors.is_empty().then(|| Estimate::exact(none(), none())).or_else(|| given.map(Imported::into_estimate)),
        }];
        for (i, window) in inputs.windows.iter().enumerate() {
            let sky = project.method.sky;
            let options = move |round| DaylightOptions { keep_batches: true, ..daylight_options(project, i, round) };
            let mut fingerprint = self.scene_fingerprint("D");
            fingerprint
                .add(&(&window.window.triangles, &window.window.frame, &window.window.basis))
                .add(&sky)
                .add(&options(0))
                .add(&straight);
            if let Some(given) = &window.daylight {
                given.mark(&mut fingerprint);
            }
            let (statistics, seconds) = (&statistics, &seconds);
            sources.push(Source {
                name: format!("D_{}", window.name),
                inputs: fingerprint,
                shape: (window.window.basis.len(), sky.len()),
                keep_straight: straight,
                trace: Box::new(move |round, progress| {
                    let clock = Instant::now();
                    let traced = daylight_matrix::compute(device, &inputs.scene, &window.window, sky, &options(round), progress)?;
                    statistics.lock().unwrap_or_else(PoisonError::into_inner).add(traced.statistics);
                    seconds.lock().unwrap_or_else(PoisonError::into_inner).daylight += clock.elapsed().as_secs_f64();
                    Ok(traced)
                }),
                exact: window.daylight.clone().map(Imported::into_estimate).or_else(|| {
                    (project.quality.prune && unobstructed::nothing_before(&inputs.scene, &window.window)).then(|| {
                        let shares = unobstructed::compute(&window.window, sky);
                        Estimate::exact(shares.clone(), shares)
                    })
                }),
            });
        }
        if let Stop::Adaptive { .. } = stop {
            // What is sampled next depends on all of it.
            for source in &mut sources {
                source.inputs.add(&"adaptive").add(&sky.data());
                for window in &inputs.windows {
                    source.inputs.add(&window.transmission.data());
                }
            }
        }
        let sun = if straight { Some(self.sun_alone()?) } else { None };
        let eyes = self.eyes(stop, &windows, &statistics)?;
        let judge = |estimates: &[Estimate]| {
            let (view, daylight) = (eyes.as_ref().unwrap_or(&estimates[0]), &estimates[1..]);
            let mut judgement = Chain { inputs, view, daylight, sky, sun: sun.as_ref() }.judge();
            if eyes.is_some() {
                // What the pictures' own noise leaves.
                judgement.error /= (1.0 - SHARE_OF_VIEW).sqrt();
            } else if straight {
                // Room for the suns' own error: 0.8² + 0.6² = 1.
                judgement.error /= 0.8;
            }
            Ok(judgement)
        };
        let (mut estimates, traced) = sample(&sources, stop, self.store, self.progress, &judge)?;
        let fingerprints: Vec<Fingerprint> = sources.iter().map(|s| s.inputs).collect();
        drop(sources);
        let statistics = statistics.into_inner().unwrap_or_else(PoisonError::into_inner);
        let spent = seconds.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.statistics.add(statistics);
        self.traced_seconds += spent.view + spent.daylight;
        (self.seconds.view, self.seconds.daylight) = (spent.view, spent.daylight);
        let daylight = estimates.split_off(1);
        let view = estimates.remove(0);
        self.keep_view(&view, fingerprints[0], traced[0])?;
        for (i, d) in daylight.iter().enumerate() {
            self.keep_daylight(i, d, fingerprints[i + 1], traced[i + 1])?;
        }
        Ok(Sampled { view, daylight, sun })
    }

    /// V of the views' eyes, taken for exact, where they alone tell how good D must be: in a project
    /// without sensors. The pictures' view matrices are sampled for themselves, see [`super::pictures`].
    fn eyes(&self, stop: Stop, windows: &[Window], statistics: &Mutex<TraceStatistics>) -> Result<Option<Estimate>> {
        let (project, inputs) = (self.project, self.inputs);
        if !matches!(stop, Stop::Adaptive { .. }) || !inputs.sensors.is_empty() || project.views.is_empty() {
            return Ok(None);
        }
        let sensors = project.views.iter().map(eye).collect::<Result<Vec<_>>>()?;
        let traced = view_matrix::compute(self.device, &inputs.scene, windows, &sensors, &view_options(project, 0), self.progress)?;
        statistics.lock().unwrap_or_else(PoisonError::into_inner).add(traced.statistics);
        Ok(Some(Estimate::exact(traced.total, traced.direct)))
    }

    /// Sds: the sun's share of S.
    fn sun_alone(&self) -> Result<Matrix<f32>> {
        let options = SkyOptions { subdivision: self.project.method.sky.subdivision(), sky: false, ..SkyOptions::default() };
        sky_matrix(&self.inputs.weather, &options, self.progress)
    }

    fn keep_view(&mut self, view: &Estimate, mut inputs: Fingerprint, traced: bool) -> Result<()> {
        if self.inputs.sensors.is_empty() {
            return Ok(());
        }
        inputs.add(&view.rounds);
        let total = view.total();
        let parts = [("", total), ("_direct", view.direct()), ("_standard_error", view.standard_error())];
        for (suffix, matrix) in parts {
            for (group, part) in self.inputs.sensors.iter().zip(split(&matrix, &self.inputs.sensors)) {
                let name = format!("V_{}{suffix}", group.name);
                if !self.store.has_matrix(&name, inputs) {
                    self.store.save(&name, &part, inputs, "view matrix, rows sensors, columns the windows' bins")?;
                }
                if suffix.is_empty() {
                    self.note(&name, (part.rows(), part.cols()), !traced, self.seconds.view, (view.rounds, view.rays));
                }
            }
        }
        Ok(())
    }

    fn keep_daylight(&mut self, index: usize, daylight: &Estimate, mut inputs: Fingerprint, traced: bool) -> Result<()> {
        let window = &self.inputs.windows[index];
        let name = format!("D_{}", window.name);
        inputs.add(&daylight.rounds);
        let total = daylight.total();
        let parts = [("_direct", daylight.direct()), ("_standard_error", daylight.standard_error()), ("", total.clone())];
        for (suffix, matrix) in parts {
            let name = format!("{name}{suffix}");
            if !self.store.has_matrix(&name, inputs) {
                self.store.save(&name, &matrix, inputs, "daylight matrix, rows the window's bins, columns patches")?;
            }
        }
        let t = window.transmission.map(|v| v as f32);
        let transmission_inputs = *Fingerprint::new("T").add(&t.data());
        let t_name = format!("T_{}", window.name);
        if !self.store.has_matrix(&t_name, transmission_inputs) {
            self.store.save(&t_name, &t, transmission_inputs, "transmission, rows outgoing bins, columns incident bins")?;
        }
        self.note(&name, (total.rows(), total.cols()), !traced, self.seconds.daylight, (daylight.rounds, daylight.rays));
        Ok(())
    }
}
