//! Judging the sensors' numbers by the standards.

use super::samples::{Samples, SensorSample};
use crate::metrics::en17037::{self, LEVELS_LX, Level, Provision};
use crate::metrics::lm83::{self, Shading};
use crate::metrics::{Decision, Estimated, Metric, glare, leed, share_of};
use crate::simulate::inputs::counting::{Counting, EXPOSURE, FACTOR, LEED, LM83, Time, daylight_share, vertical_limits, vertical_share};
use crate::simulate::project::metrics::Family;
use glam::DVec3;

/// What is known of a group of sensors besides their light.
#[derive(Debug, Clone)]
pub struct GroupFacts {
    /// Its name.
    pub name: String,
    /// Positions, m.
    pub positions: Vec<DVec3>,
    /// Whether each faces up: belongs to the plan.
    pub faces_up: Vec<bool>,
    /// Why direct sun is not that through bare windows, if it is not.
    pub not_bare: Option<String>,
    /// View out and exposure to sunlight, which geometry decides.
    pub outlook: Vec<Metric>,
    /// What was done about blinds.
    pub shading: Shading,
    /// Hours in which blinds leave more than 2 % of the sensors in the sun.
    pub hours_in_sun: f64,
}

impl GroupFacts {
    fn plan<'s>(&self, sensors: &'s [SensorSample]) -> Vec<&'s SensorSample> {
        sensors.iter().zip(&self.faces_up).filter(|(_, up)| **up).map(|(s, _)| s).collect()
    }
}

/// Sensors of the plan with a daylight factor above this stand outdoors.
const OUTDOORS: f64 = 0.6;

/// All metrics of one group.
pub fn judge(samples: &Samples<'_>, facts: &GroupFacts, sensors: &[SensorSample]) -> Vec<Metric> {
    let everyone: Vec<&SensorSample> = sensors.iter().collect();
    let plan = facts.plan(sensors);
    let mut metrics = means(samples, &everyone);
    let judge = Judge { samples, facts, plan: &plan };
    metrics.extend(judge.lm83());
    metrics.extend(judge.en17037());
    metrics.extend(judge.factor());
    metrics.extend(judge.vertical(sensors));
    metrics.into_iter().map(|m| m.of(&facts.name)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Means over the sensors of DA, cDA, UDI, and the exposure.
fn means(samples: &Samples<'_>, sensors: &[&SensorSample]) -> Vec<Metric> {
    let occupied = &samples.counting.occupied;
    let mut metrics = Vec::new();
    for (i, column) in samples.counting.columns.iter().enumerate() {
        if column.name == EXPOSURE {
            let largest = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
            let metric = |name: &str, title: &str| {
                Metric::new(name, title, "klx·h", "CIE 157:2004").note(format!("{} h", samples.counting.all.hours))
            };
            metrics.push(metric("mean_exposure_klxh", "Light exposure, mean over the sensors").value(samples.of(sensors, i, mean)));
            metrics.push(metric("largest_exposure_klxh", "Light exposure, largest of the sensors").value(samples.of(sensors, i, largest)));
        } else if column.time == Time::Occupied && !column.name.starts_with("above_") {
            let title = format!("{}, mean over the sensors", column.name);
            let metric = Metric::new(&format!("mean_{}", column.name), &title, "share", "guide: metrics");
            let note = format!("{}: {} h", occupied.name, occupied.hours);
            metrics.push(metric.value(samples.of(sensors, i, mean)).note(note));
        }
    }
    metrics
}

/// One group.
struct Judge<'a> {
    samples: &'a Samples<'a>,
    facts: &'a GroupFacts,
    plan: &'a [&'a SensorSample],
}

/// A number that needs sensors: they are there where it is asked for.
fn there(number: Option<f64>) -> f64 {
    number.unwrap_or_default()
}

impl Judge<'_> {
    /// Values of a judged column in a draw.
    fn drawn(&self, draw: usize, column: usize) -> Vec<f64> {
        let place = self.samples.judged(column);
        self.plan.iter().map(|s| s.drawn[draw][place]).collect()
    }

    fn values(&self, column: usize) -> Vec<f64> {
        self.plan.iter().map(|s| s.values[column]).collect()
    }

    fn draws(&self) -> usize {
        self.plan.first().map_or(0, |s| s.drawn.len())
    }

    /// DA300's spatial share and ASE.
    fn lm83(&self) -> Vec<Metric> {
        let counting = self.samples.counting;
        let Some(column) = counting.column(LM83).filter(|_| counting.section.wants(Family::Lm83)) else { return Vec::new() };
        let share =
            Metric::new("da300_spatial_share", "DA300 spatial share: sensors with 300 lx in half of the hours", "share", lm83::SOURCE);
        let ase = Metric::new(
            "ase_1000_250",
            "ASE1000,250h: sensors with more than 1000 lx of direct sun in more than 250 h",
            "share",
            lm83::SOURCE,
        );
        if self.plan.is_empty() {
            let why = "no sensor faces up, so that there is no plan";
            return vec![share.note(why), ase.note(why)];
        }
        let doubts = |shading: Shading| doubts(counting, self.facts, shading);
        let why = doubts(self.facts.shading);
        let share = if why.is_empty() { Metric::new(lm83::SDA, lm83::SDA_TITLE, "share", lm83::SOURCE) } else { share };
        let mut share = share.value(self.samples.of(self.plan, column, |a| there(lm83::spatial_share(a))));
        share.lm83_conformant = Some(why.is_empty());
        share.notes = why;
        if self.facts.hours_in_sun > 0.0 {
            let hours = self.facts.hours_in_sun;
            share.notes.push(format!("in {hours} h more than 2 % of the sensors stay in the sun with all blinds closed"));
        }
        share.notes.push(format!("{}: {} h; {}", counting.lm83.name, counting.lm83.hours, self.sensors()));
        share.notes.extend(self.unusual());
        vec![share, self.ase(ase, doubts(Shading::Operated))]
    }

    fn ase(&self, metric: Metric, mut doubts: Vec<String>) -> Metric {
        let hours: Option<Vec<[f64; 3]>> = self.plan.iter().map(|s| s.sun_hours).collect();
        let Some(hours) = hours else {
            return metric.note("not judged: it needs suns that are traced, as by phases = 5 or \"direct\" (or clear glass and \"auto\")");
        };
        let of = |i: usize| there(lm83::exposed_share(&hours.iter().map(|h| h[i]).collect::<Vec<f64>>()));
        let [value, less, more] = [0, 1, 2].map(of);
        let standard_error = (((less - value).powi(2) + (more - value).powi(2)) / 2.0).sqrt();
        doubts.extend(self.facts.not_bare.clone());
        let mut metric = metric.value(Estimated { value, standard_error });
        metric.lm83_conformant = Some(doubts.is_empty());
        metric.notes = doubts;
        metric.notes.extend(leed::explanation(value).map(|why| format!("LEED: {why}")));
        metric
    }

    /// How many sensors count.
    fn sensors(&self) -> String {
        match (self.plan.len(), self.facts.faces_up.len()) {
            (n, all) if n == all => format!("{all} sensors"),
            (n, all) => format!("those {n} of the {all} sensors that face up"),
        }
    }

    /// What is odd about the sensors.
    fn unusual(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let is_dark = |s: &&&SensorSample| s.values.first() == Some(&0.0);
        let dark = self.plan.iter().filter(is_dark).count();
        if dark > 0 {
            notes.push(format!("{dark} of the sensors get no light and count with 0 lx"));
        }
        if let Some(factor) = self.samples.counting.column(FACTOR) {
            let outside = self.values(factor).iter().filter(|f| **f > OUTDOORS).count();
            if outside > 0 {
                notes.push(format!("{outside} of the sensors have a daylight factor above {:.0} %: they stand outdoors", 100.0 * OUTDOORS));
            }
        }
        notes
    }

    /// Daylight provision by both methods, view out and exposure to sunlight.
    fn en17037(&self) -> Vec<Metric> {
        let counting = self.samples.counting;
        if !counting.section.wants(Family::En17037) || counting.are_moments && counting.section.median_diffuse.is_none() {
            return Vec::new();
        }
        let mut metrics = Vec::new();
        let openings = counting.section.openings;
        let by_hours = Metric::new("en17037_provision", "EN 17037 daylight provision, method 2 (illuminance)", "", en17037::SOURCE);
        let by_factor =
            Metric::new("en17037_provision_by_factor", "EN 17037 daylight provision, method 1 (daylight factor)", "", en17037::SOURCE);
        if self.plan.is_empty() {
            return vec![by_hours.note("no sensor faces up, so that there is no plan")];
        }
        let columns: Option<Vec<usize>> = LEVELS_LX.iter().map(|lux| counting.column(&daylight_share(*lux))).collect();
        match columns {
            None if counting.are_moments => {}
            None => metrics.push(by_hours.note("not judged: the weather is not one whole year, or its sky was made elsewhere")),
            Some(columns) => {
                for (lux, column) in LEVELS_LX.iter().zip(&columns) {
                    let title = format!("EN 17037: plane with {lux} lx in half of the daylight hours");
                    let metric = Metric::new(&format!("en17037_area_{lux}_lx"), &title, "share", en17037::SOURCE);
                    metrics.push(metric.value(self.samples.of(self.plan, *column, |t| there(share_of(t, |t| *t >= en17037::TIME)))));
                }
                let level = |values: &dyn Fn(usize) -> Vec<f64>| {
                    let time: Vec<Vec<f64>> = columns.iter().map(|c| values(*c)).collect();
                    Provision::by_illuminance([&time[0], &time[1], &time[2], &time[3]], openings)
                };
                let found = level(&|c| self.values(c));
                let decision = Decision::new(level_of(found), (0..self.draws()).map(|d| level_of(level(&|c| self.drawn(d, c)))));
                metrics.push(self.provision(by_hours, &decision, found));
            }
        }
        if let (Some(column), Some(median)) = (counting.column(FACTOR), counting.median_diffuse())
            && self.values(column).iter().all(|f| f.is_finite())
        {
            let level = |factors: &[f64]| Provision::by_factor(factors, median, openings);
            let found = level(&self.values(column));
            let decision = Decision::new(level_of(found), (0..self.draws()).map(|d| level_of(level(&self.drawn(d, column)))));
            metrics.push(self.provision(by_factor, &decision, found).note(format!("median diffuse illuminance outdoors {median:.0} lx")));
        }
        metrics.extend(self.facts.outlook.iter().cloned());
        metrics
    }

    fn provision(&self, metric: Metric, decision: &Decision<Level>, found: Option<Provision>) -> Metric {
        let metric = metric.class(decision, |level| level.name().into()).note(self.sensors());
        let metric = found.iter().fold(metric, |m, p| m.note(format!("target {}, minimum {}", p.target.name(), p.minimum.name())));
        self.unusual().into_iter().fold(metric, Metric::note)
    }

    fn factor(&self) -> Vec<Metric> {
        let counting = self.samples.counting;
        let wanted = counting.section.wants(Family::DaylightFactor) && !self.plan.is_empty();
        let Some(column) = counting.column(FACTOR).filter(|_| wanted) else { return Vec::new() };
        if self.values(column).iter().any(|f| !f.is_finite()) {
            return Vec::new();
        }
        let metric = |name: &str, title: &str| Metric::new(name, title, "share", "CIE S 011: overcast sky").note(self.sensors());
        let median = |v: &[f64]| {
            let mut v = v.to_vec();
            v.sort_unstable_by(f64::total_cmp);
            (v[(v.len() - 1) / 2] + v[v.len() / 2]) / 2.0
        };
        vec![
            metric("mean_daylight_factor", "Daylight factor, mean").value(self.samples.of(self.plan, column, mean)),
            metric("median_daylight_factor", "Daylight factor, median").value(self.samples.of(self.plan, column, median)),
        ]
    }

    /// Sensors as eyes: the share of those that do not face up with more than a threshold in more than 5 % of the time.
    fn vertical(&self, sensors: &[SensorSample]) -> Vec<Metric> {
        let eyes: Vec<&SensorSample> = sensors.iter().zip(&self.facts.faces_up).filter(|(_, up)| !**up).map(|(s, _)| s).collect();
        let of = |lux: f64| {
            let column = self.samples.counting.column(&vertical_share(lux)).filter(|_| !eyes.is_empty())?;
            let title = format!("Sensors not facing up with more than {lux} lx in more than 5 % of the hours");
            let metric = Metric::new(&format!("vertical_{lux}_lx"), &title, "share", "DGPs, J. Wienold 2009");
            let number = |t: &[f64]| there(glare::spatial_disturbing(t));
            Some(metric.value(self.samples.of(&eyes, column, number)).note(format!(
                "{} sensors; {}",
                eyes.len(),
                self.samples.counting.occupied.name
            )))
        };
        vertical_limits().into_iter().filter_map(of).collect()
    }
}

/// Why the share of a group's sensors is not LM-83's; empty if it is.
fn doubts(counting: &Counting, facts: &GroupFacts, shading: Shading) -> Vec<String> {
    lm83::doubts(&counting.year, &counting.lm83, &positions(facts), shading)
}

fn level_of(provision: Option<Provision>) -> Level {
    provision.map_or(Level::None, |p| p.level())
}

fn positions(facts: &GroupFacts) -> Vec<DVec3> {
    facts.positions.iter().zip(&facts.faces_up).filter(|(_, up)| **up).map(|(p, _)| *p).collect()
}

/// LEED's points of all groups together, each a space; sensors stand for equal parts of the floor.
pub fn judge_all(samples: &Samples<'_>, groups: &[(&GroupFacts, &[SensorSample])]) -> Vec<Metric> {
    let counting = samples.counting;
    let plans: Vec<Vec<&SensorSample>> = groups.iter().map(|(f, s)| f.plan(s)).filter(|p| !p.is_empty()).collect();
    if !counting.section.wants(Family::Leed) || plans.is_empty() {
        return Vec::new();
    }
    let all: Vec<&SensorSample> = plans.iter().flatten().copied().collect();
    let draws = all[0].drawn.len();
    let points = |decision: Decision<u8>, metric: Metric| {
        let value = Estimated { value: f64::from(decision.class), standard_error: 0.0 };
        // The value is the class.
        Metric { class: None, ..metric.value(value).class(&decision, |p| p.to_string()) }
    };
    let mut metrics = Vec::new();
    if let Some(column) = counting.column(LM83) {
        let place = samples.judged(column);
        let of = |number: &dyn Fn(&SensorSample) -> f64| {
            let share = |s: &[&SensorSample]| there(lm83::spatial_share(&s.iter().map(|s| number(s)).collect::<Vec<_>>()));
            leed::option_1(share(&all), &plans.iter().map(|p| share(p)).collect::<Vec<_>>())
        };
        let decision = Decision::new(of(&|s| s.values[column]), (0..draws).map(|d| of(&|s| s.drawn[d][place])));
        let is_open =
            groups.iter().filter(|(f, _)| f.faces_up.contains(&true)).any(|(f, _)| !doubts(samples.counting, f, f.shading).is_empty());
        let (title, note) = match is_open {
            true => (
                "LEED v4.1 daylight option 1, at most",
                "no credit yet: sDA needs all that LM-83 asks for, as its blinds, which can only lower it",
            ),
            false => ("LEED v4.1 daylight option 1", "by LM-83's sDA300/50% with its blinds"),
        };
        let metric = Metric::new("leed_option_1", title, "points", leed::SOURCE);
        metrics.push(points(decision, metric).note(format!("{note}; ASE above 10 % must be explained")));
    }
    if let (Some(morning), Some(afternoon), Some([time, _])) = (counting.column(LEED[0]), counting.column(LEED[1]), &counting.equinox) {
        let share = |number: &dyn Fn(&SensorSample, usize) -> f64| {
            let at = |column: usize| all.iter().map(|s| number(s, column)).collect::<Vec<f64>>();
            there(leed::share_at_both(&at(morning), &at(afternoon)))
        };
        let value = share(&|s, c| s.values[c]);
        let drawn = (0..draws).map(|d| leed::option_2(share(&|s, c| s.drawn[d][samples.judged(c)])));
        let probes = all[0].probed.len();
        let standard_error = samples.noise.standard_error(value, (0..probes).map(|p| share(&|s, c| s.probed[p][c])));
        let title = "LEED v4.1 option 2: sensors with 300 to 3000 lx at 9:00 and 15:00";
        let metric = Metric::new("leed_option_2", title, "share", leed::SOURCE).value(Estimated { value, standard_error });
        let decision = Decision::new(leed::option_2(value), drawn);
        metrics.push(metric.class(&decision, |p| format!("{p} points")).note(format!("{}, standard time", time.name)));
    }
    metrics.into_iter().map(|m| m.of("all")).collect()
}

#[cfg(test)]
mod tests;
