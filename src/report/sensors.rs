//! What the sensors tell: heat maps, the course of the year, a table of the groups.

use super::metrics::words;
use super::parts::{Figure, Part, Section, Table, confidence_95, percent, with_interval};
use super::plan::HeatMap;
use crate::error::Result;
use crate::image::carpet::{Carpet, Coloring};
use crate::image::palette::{Palette, Scale, round_up, rounded_number};
use crate::metrics::Estimated;
use crate::simulate::Results;
use crate::simulate::inputs::counting::MEAN;
use crate::simulate::year::Sensors;
use crate::weather::Days;
use crate::weather::time::steps_per_day;
use std::collections::HashMap;

/// Most sensors of a heat map: more are dots nobody can tell apart, and a page nobody can open.
const MOST_CELLS: usize = 20_000;

/// Ends of the scales of a group, which all runs of a report share.
#[derive(Debug, Clone, Copy)]
struct Maxima {
    /// Mean illuminance of a sensor, lx.
    mean: f64,
    /// Mean illuminance of the group at a step, lx.
    step: f64,
    /// Standard error of a sensor's mean, % of it.
    error: f64,
}

/// Scales by the groups' names.
pub(super) struct Scales(HashMap<String, Maxima>);

impl Scales {
    /// Of all groups of all results.
    pub fn of(results: &[Results]) -> Self {
        let mut all: HashMap<String, Maxima> = HashMap::new();
        for group in results.iter().flat_map(|r| &r.year.sensors) {
            let maxima = all.entry(group.name.clone()).or_insert(Maxima { mean: 0.0, step: 0.0, error: 0.0 });
            for mean in column(group, MEAN) {
                maxima.mean = maxima.mean.max(mean.value);
                maxima.error = maxima.error.max(relative(mean));
            }
            let mut means: Vec<f64> = group_means(group).into_iter().filter(|v| *v > 0.0).collect();
            means.sort_by(f64::total_cmp);
            // A few hours of sun on the sensors should not darken all others.
            maxima.step = maxima.step.max(means.get(means.len().saturating_sub(1) * 98 / 100).copied().unwrap_or(0.0));
        }
        for m in all.values_mut() {
            *m = Maxima { mean: round_up(m.mean), step: round_up(m.step), error: round_up(m.error.max(0.1)) };
        }
        Self(all)
    }

    fn group(&self, group: &Sensors) -> Maxima {
        self.0.get(&group.name).copied().unwrap_or(Maxima { mean: 1.0, step: 1.0, error: 1.0 })
    }
}

/// Numbers of all sensors of a group; none if the results do not have them.
fn column(group: &Sensors, name: &str) -> Vec<Estimated> {
    (0..group.metrics.rows.len()).filter_map(|s| group.metrics.get(s, name)).collect()
}

/// Standard error of a sensor's mean, % of it.
fn relative(mean: Estimated) -> f64 {
    if mean.value > 0.0 { 100.0 * mean.standard_error / mean.value } else { 0.0 }
}

/// Mean illuminance of a group at every step, lx: of the sensors that face up, if any do.
fn group_means(group: &Sensors) -> Vec<f64> {
    let of_plan: Vec<usize> = (0..group.count()).filter(|i| group.is_of_plan(*i)).collect();
    let rows = if of_plan.is_empty() { (0..group.count()).collect() } else { of_plan };
    let mut means = vec![0.0; group.illuminance.cols()];
    for row in &rows {
        means.iter_mut().zip(group.illuminance.row(*row)).for_each(|(m, v)| *m += f64::from(*v));
    }
    means.iter_mut().for_each(|m| *m /= rows.len().max(1) as f64);
    means
}

/// The steps over whole days; nothing of moments.
pub(super) fn days(results: &Results) -> Option<Days> {
    let steps = results.year.times.len();
    if steps < 48 {
        return None;
    }
    if let Some(around) = results.surroundings.as_ref().filter(|a| a.weather.records.len() == steps) {
        return around.weather.steps().days();
    }
    let per_day = steps_per_day(steps);
    let whole = steps.is_multiple_of(per_day) && steps / per_day <= 366;
    whole.then(|| Days { first: 0, leap: steps / per_day == 366, per_day, steps: (0..steps).map(Some).collect() })
}

/// Illuminance of all groups.
pub(super) fn section(results: &Results, scales: &Scales) -> Result<Section> {
    let (year, mut parts) = (&results.year, Vec::new());
    let confidence = confidence_95(&year.summary);
    let mut groups = Table::new("groups", "Groups of sensors; ± is the interval of 95 %", &["sensors", "count", "without light", "mean"]);
    for s in &year.summary.sensors {
        let mean = match (s.mean_illuminance_lx, s.mean_irradiance_w_m2) {
            (Some(lx), _) => format!("{} lx", with_interval(lx, confidence * s.mean_illuminance_standard_error_lx.unwrap_or(0.0))),
            (None, Some(w)) => format!("{} W/m²", with_interval(w, confidence * s.mean_irradiance_standard_error_w_m2.unwrap_or(0.0))),
            (None, None) => "–".into(),
        };
        groups.rows.push(vec![s.name.clone(), s.count.to_string(), s.without_light.to_string(), mean]);
    }
    if groups.rows.is_empty() {
        return Ok(Section { title: "Sensors", parts: vec![Part::Text("The project has no sensors.".into())] });
    }
    parts.push(Part::Table(groups));
    let days = days(results);
    for group in &year.sensors {
        let maxima = scales.group(group);
        parts.push(Part::Heading(group.name.clone()));
        if column(group, MEAN).len() == group.count() && group.count() > 0 {
            parts.push(Part::Table(spread(group)));
            if group.positions.len() == group.count() && group.count() <= MOST_CELLS && is_a_plan(group) {
                parts.push(Part::Figures(maps(results, group, &maxima)?));
            }
        }
        if let Some(days) = &days {
            let means = group_means(group);
            let values: Vec<f64> =
                days.steps.iter().map(|s| s.map_or(f64::NAN, |s| means[s])).map(|v| if v > 0.0 { v } else { f64::NAN }).collect();
            let carpet = Carpet {
                values: &values,
                steps_per_day: days.per_day,
                first_day: days.first,
                leap: days.leap,
                title: format!("Mean illuminance, {}", group.name),
                label: "lx".into(),
                coloring: Coloring::Continuous { palette: Palette::Viridis, scale: Scale::linear(0.0, maxima.step)? },
                missing: Some("dark".into()),
                shares: false,
            };
            parts.push(Part::Figures(vec![Figure {
                name: format!("{}_year", group.name),
                label: format!("Mean illuminance at every hour of the year, {}", group.name),
                caption: String::new(),
                drawing: carpet.draw()?,
            }]));
        }
    }
    Ok(Section { title: "Sensors", parts })
}

/// Whether the group lies in a plane that a plan shows: sensors above each other would hide each other.
fn is_a_plan(group: &Sensors) -> bool {
    let places: std::collections::BTreeSet<[i64; 2]> =
        group.positions.iter().map(|p| [(p.x * 1e3).round() as i64, (p.y * 1e3).round() as i64]).collect();
    places.len() == group.count()
}

/// Least, median and greatest of the metrics.
fn spread(group: &Sensors) -> Table {
    let mut table = Table::new(
        &format!("{}_metrics", group.name),
        "Metrics of the sensors",
        &["metric", "least", "median", "greatest", "largest standard error"],
    );
    for name in &group.metrics.columns {
        let numbers = column(group, name);
        let mut values: Vec<f64> = numbers.iter().map(|n| n.value).filter(|v| v.is_finite()).collect();
        if values.is_empty() {
            continue;
        }
        values.sort_by(f64::total_cmp);
        let error = numbers.iter().map(|n| n.standard_error).fold(0.0, f64::max);
        let text = |v: f64| match () {
            () if name.starts_with("mean_") || name.starts_with("equinox_") => format!("{} lx", rounded_number(v)),
            () if name.starts_with("exposure_") => format!("{} klx·h", rounded_number(v)),
            () if name.starts_with("sun_hours_") => format!("{} h", rounded_number(v)),
            () => percent(v),
        };
        table.rows.push(vec![words(name), text(values[0]), text(values[values.len() / 2]), text(values[values.len() - 1]), text(error)]);
    }
    table
}

/// Heat maps of a group.
fn maps(results: &Results, group: &Sensors, maxima: &Maxima) -> Result<Vec<Figure>> {
    let around = results.surroundings.as_ref();
    let number = |v: f64| rounded_number(v);
    let share = |v: f64| format!("{v:.0}");
    let small = |v: f64| format!("{v:.2}");
    let shares = Scale::linear(0.0, 100.0)?;
    let first = |start: &str| group.metrics.columns.iter().find(|c| c.starts_with(start)).cloned().unwrap_or_default();
    let (autonomy, useful) = (first("autonomy_"), first("useful_"));
    let of = |name: &str, f: &dyn Fn(Estimated) -> f64| -> Vec<f64> { column(group, name).into_iter().map(f).collect() };
    let percents = |name: &str| of(name, &|e| 100.0 * e.value);
    let [mean, error] = [Scale::linear(0.0, maxima.mean)?, Scale::linear(0.0, maxima.error)?];
    let titles = [autonomy.replace('_', " "), useful.replace('_', " ")].map(|t| format!("Share of the hours: {t}"));
    let maps: [(&str, &str, &str, Vec<f64>, Scale, &dyn Fn(f64) -> String, Palette); 4] = [
        ("mean", "Mean illuminance", "lx", of(MEAN, &|e| e.value), mean, &number, Palette::Viridis),
        ("autonomy", &titles[0], "%", percents(&autonomy), shares, &share, Palette::Viridis),
        ("useful", &titles[1], "%", percents(&useful), shares, &share, Palette::Viridis),
        ("error", "Standard error of the mean", "%", of(MEAN, &relative), error, &small, Palette::Cividis),
    ];
    let figure =
        |(name, title, label, values, scale, text, palette): (&str, &str, &str, Vec<f64>, Scale, &dyn Fn(f64) -> String, Palette)| {
            let map = HeatMap {
                title: title.to_string(),
                group,
                scene: around.map(|a| &a.scene),
                north: around.map(|a| a.weather.north),
                values: &values,
                palette,
                scale,
                label,
                text,
            };
            Figure {
                name: format!("{}_{name}", group.name),
                label: format!("{title}, {}", group.name),
                caption: String::new(),
                drawing: map.draw(),
            }
        };
    Ok(maps.into_iter().filter(|m| !m.3.is_empty()).map(figure).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::Matrix;
    use glam::DVec3;

    #[test]
    fn a_group_s_mean_is_that_of_the_sensors_that_face_up() {
        let mut group = Sensors::new("a", Matrix::from_data(3, 2, 1, vec![100.0, 0.0, 300.0, 20.0, 9000.0, 9000.0]).unwrap());
        group.directions = vec![DVec3::Z, DVec3::Z, DVec3::Y];
        assert_eq!(group_means(&group), [200.0, 10.0]);
        group.directions = vec![DVec3::Y; 3];
        assert_eq!(group_means(&group)[1], 9020.0 / 3.0);
        group.positions = vec![DVec3::ZERO, DVec3::Z, DVec3::X];
        assert!(!is_a_plan(&group), "two stand above each other");
    }
}
