//! What rules look at, from the run's own arrays.

use super::super::illuminance::luminous;
use super::super::states::StateLight;
use super::super::views::Made;
use super::glare::DgpOfStates;
use super::groups::fault_of;
use crate::control::rules::{Reading, Rule, Signal, Statistic, Values};
use crate::control::{Schedule, State};
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::metrics::Year;
use crate::metrics::lm83::SUN_LX;
use crate::simulate::context::Context;
use crate::simulate::inputs::Inputs;
use crate::simulate::inputs::counting::Counting;
use crate::simulate::light::Daylight;
use crate::simulate::phases::sky::solar;
use crate::units::LUMINOUS_EFFICACY;
use crate::weather::sun::SunPosition;
use glam::DVec3;
use std::collections::BTreeMap;
use std::ops::Range;

/// Signals of all steps.
pub(super) struct Signals<'a> {
    light: Option<&'a StateLight>,
    glare: &'a DgpOfStates,
    /// Rows of each group of sensors.
    sensors: Vec<Range<usize>>,
    all: Range<usize>,
    outdoors: BTreeMap<Signal, Vec<f64>>,
    occupied: Vec<bool>,
}

impl<'a> Signals<'a> {
    /// The signals that some rules need.
    ///
    /// # Errors
    /// Signals that the weather does not tell, suns that are not traced, failures of the sky, or when stopped.
    pub fn new(
        context: &Context<'_>,
        counting: &Counting,
        made: &Made<'_>,
        daylight: Daylight<'_>,
        (light, glare): (Option<&'a StateLight>, &'a DgpOfStates),
        rules: &[Rule],
    ) -> Result<Self> {
        let inputs = context.inputs;
        let mut outdoors = BTreeMap::new();
        let mut whole_spectrum: Option<Matrix<f32>> = None;
        for rule in rules {
            for signal in rule.readings().iter().map(|r| r.signal) {
                check(context, rule, signal)?;
                if outdoors.contains_key(&signal) {
                    continue;
                }
                let values = match signal {
                    Signal::Illuminance(group) => on_facade(inputs, daylight, group, &made.skies.whole),
                    Signal::Irradiance(group) => {
                        let sky = match &whole_spectrum {
                            Some(sky) => sky,
                            None => whole_spectrum.insert(solar(context)?),
                        };
                        on_facade(inputs, daylight, group, sky).into_iter().map(|lx| lx / LUMINOUS_EFFICACY).collect()
                    }
                    other => match of_sun(inputs, other) {
                        Some(values) => values,
                        None => continue,
                    },
                };
                outdoors.insert(signal, values);
            }
        }
        let mut first = 0;
        let sensors = inputs.sensors.iter().map(|g| {
            let rows = first..first + g.sensors.len();
            first = rows.end;
            rows
        });
        let sensors: Vec<Range<usize>> = sensors.collect();
        let occupied = counting.occupied.mask(inputs.weather.records.len());
        Ok(Self { light, glare, sensors, all: 0..first, outdoors, occupied })
    }

    /// What the rules looked at, each signal of each rule with its values by step, when they had decided this.
    pub fn readings(&self, rules: &[Rule], year: &Year, decided: &Schedule) -> Vec<(usize, Reading, Vec<f64>)> {
        let of = |rule: &Rule, reading: Reading| {
            let value = |step: usize| match reading.signal {
                Signal::Time => year.steps[step].begins,
                Signal::Month => f64::from(year.steps[step].month),
                signal => self.value(signal, step, &seen(rule.group, reading, step, decided, rules)),
            };
            (rule.group, reading, (0..decided.steps()).map(value).collect())
        };
        rules.iter().flat_map(|rule| rule.readings().into_iter().map(move |reading| of(rule, reading))).collect()
    }

    fn rows(&self, group: Option<usize>) -> Range<usize> {
        group.map_or(self.all.clone(), |g| self.sensors[g].clone())
    }

    /// Light of some sensors with the groups in these states.
    fn indoors(&self, rows: Range<usize>, step: usize, states: &[State], sun: bool) -> Vec<f64> {
        let mut values = vec![0.0; rows.len()];
        let Some(light) = self.light else { return values };
        for part in light.parts(states.iter().copied().enumerate()) {
            let Some(of) = (if sun { part.sun.as_ref() } else { Some(&part.lux) }) else { continue };
            values.iter_mut().zip(rows.clone()).for_each(|(value, row)| *value += f64::from(of.at(row, step)[0]));
        }
        values
    }
}

impl Values for Signals<'_> {
    fn value(&self, signal: Signal, step: usize, states: &[State]) -> f64 {
        match signal {
            Signal::Sun(group) => Statistic::Most.of(&self.indoors(self.rows(group), step, states, true)),
            Signal::SunlitShare(group) => {
                let sun = self.indoors(self.rows(group), step, states, true);
                100.0 * sun.iter().filter(|lx| **lx > SUN_LX).count() as f64 / sun.len().max(1) as f64
            }
            Signal::Sensors(statistic, group) => statistic.of(&self.indoors(self.rows(group), step, states, false)),
            Signal::Dgp(view) => self.glare.of(view, step, states),
            other => self.outdoors.get(&other).map_or(f64::NAN, |values| values[step]),
        }
    }

    fn occupied(&self, step: usize) -> bool {
        self.occupied[step]
    }
}

/// The states that a rule saw in a step: those of the groups before its own as decided for it, of its own and those after
/// as in the step before (in the first step: the first, or as given); its own in the first state unless it looks at it as set.
fn seen(group: usize, reading: Reading, step: usize, decided: &Schedule, rules: &[Rule]) -> Vec<State> {
    let has_rule = |g: usize| rules.iter().any(|r| r.group == g);
    let before = |g: usize| match step.checked_sub(1) {
        Some(last) => decided.at(g, last),
        None if has_rule(g) => 0,
        None => decided.at(g, 0),
    };
    let of = |g: usize| match g.cmp(&group) {
        std::cmp::Ordering::Less => decided.at(g, step),
        std::cmp::Ordering::Equal if !reading.as_set => 0,
        _ => before(g),
    };
    (0..decided.groups()).map(of).collect()
}

/// Whether a run can give a rule this signal.
fn check(context: &Context<'_>, rule: &Rule, signal: Signal) -> Result<()> {
    let weather = &context.inputs.weather;
    let fault = |message: &str, help: &str| Err(fault_of(context, rule.group, Error::new(message).help(help)));
    let needs_sun = matches!(signal, Signal::Altitude | Signal::Azimuth | Signal::ProfileAngle(_) | Signal::Irradiance(_));
    if needs_sun && (weather.given.is_some() || !weather.skies.is_empty()) {
        return fault(
            "this rule looks at the sun or at irradiance, which skies of the CIE and skies made elsewhere do not tell",
            "give a weather file, or write a rule of illuminance",
        );
    }
    if matches!(signal, Signal::Sun(_) | Signal::SunlitShare(_)) && context.choice.phases != 5 {
        return fault(
            "this rule looks at direct sun on sensors, but no sun is traced",
            "write phases = 5, and give the windows' states glass, a shade or a tensor_tree that the sun is traced through",
        );
    }
    Ok(())
}

/// Where the sun stands, by step, as a signal has it; nothing of other signals.
fn of_sun(inputs: &Inputs, signal: Signal) -> Option<Vec<f64>> {
    let weather = &inputs.weather;
    let each = |of: &dyn Fn(&SunPosition) -> f64| weather.records.iter().map(|r| of(&weather.sun(r))).collect();
    match signal {
        Signal::Altitude => Some(each(&|s| s.altitude.to_degrees())),
        Signal::Azimuth => Some(each(&|s| s.azimuth.to_degrees().rem_euclid(360.0))),
        Signal::ProfileAngle(group) => {
            let outward = outward(inputs, group);
            // In the scene's axes.
            let turned = |s: &SunPosition| SunPosition { azimuth: s.azimuth - weather.north.to_radians(), ..*s };
            Some(each(&|s| profile_angle(turned(s).direction(), outward)))
        }
        _ => None,
    }
}

/// Where the windows of a group look to, by their areas.
fn outward(inputs: &Inputs, group: usize) -> DVec3 {
    let windows = inputs.windows_of_group(group).into_iter().map(|w| &inputs.windows[w].window);
    windows.map(|w| -w.frame.z * w.area()).sum::<DVec3>().normalize_or_zero()
}

/// The sun's altitude in the plane of the zenith and a window's horizontal normal, degrees; no number while the sun is down
/// or behind the window, or the window is horizontal.
fn profile_angle(sun: DVec3, outward: DVec3) -> f64 {
    let flat = DVec3::new(outward.x, outward.y, 0.0);
    if flat.length() < 1e-6 || sun.z <= 0.0 || sun.dot(outward) <= 0.0 {
        return f64::NAN;
    }
    sun.z.atan2(sun.dot(flat.normalize())).to_degrees()
}

/// Illuminance on the outer side of a group's windows by D·S, the mean over their area, lx.
fn on_facade(inputs: &Inputs, daylight: Daylight<'_>, group: usize, sky: &Matrix<f32>) -> Vec<f64> {
    let mut sum = vec![0.0; sky.cols()];
    let mut area = 0.0;
    for window in inputs.windows_of_group(group) {
        let (own, d) = (&inputs.windows[window], &daylight.total[window]);
        let basis = &own.window.basis;
        // Of each patch what it sends onto the window per radiance, by the areas of the parts.
        let mut weights = vec![[0.0f64; 3]; d.cols()];
        for (part, first) in own.parts.iter().zip((0..d.rows()).step_by(basis.len().max(1))) {
            for bin in 0..basis.len() {
                let factor = part.area() * basis.projected_solid_angle(bin);
                for (patch, weight) in weights.iter_mut().enumerate() {
                    weight.iter_mut().zip(d.at(first + bin, patch)).for_each(|(w, v)| *w += factor * f64::from(*v));
                }
            }
            area += part.area();
        }
        for (patch, weight) in weights.iter().enumerate() {
            for (step, total) in sum.iter_mut().enumerate() {
                let light: [f32; 3] = std::array::from_fn(|c| (weight[c] * f64::from(sky.at(patch, step)[c])) as f32);
                *total += luminous(&light);
            }
        }
    }
    sum.iter_mut().for_each(|v| *v /= f64::max(area, f64::MIN_POSITIVE));
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_angle_is_the_altitude_in_the_plane_of_the_normal() {
        let south = -DVec3::Y;
        let sun = |altitude: f64, from_south: f64| {
            let (a, b) = (altitude.to_radians(), from_south.to_radians());
            DVec3::new(a.cos() * b.sin(), -a.cos() * b.cos(), a.sin())
        };
        assert!((profile_angle(sun(40.0, 0.0), south) - 40.0).abs() < 1e-9);
        // tan(profile) = tan(altitude) / cos(azimuth from the normal).
        let wanted = (30f64.to_radians().tan() / 60f64.to_radians().cos()).atan().to_degrees();
        assert!((profile_angle(sun(30.0, 60.0), south) - wanted).abs() < 1e-9);
        assert!(profile_angle(sun(30.0, 100.0), south).is_nan() && profile_angle(sun(-1.0, 0.0), south).is_nan());
        assert!(profile_angle(sun(30.0, 0.0), DVec3::Z).is_nan());
    }
}
