//! The numbers of several runs beside each other, and how far each is from the first.

use super::parts::{Part, Section, Table, confidence_95, with_interval};
use crate::glare::annual::CLASS_LIMITS;
use crate::simulate::Results;
use std::collections::BTreeMap;

/// A number of a run with the half width of its interval of 95 %.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Number {
    value: f64,
    half_width: f64,
}

/// The numbers of a run by what they are.
fn numbers(results: &Results) -> Vec<(String, Number)> {
    let summary = &results.year.summary;
    let confidence = confidence_95(summary);
    let mut found = Vec::new();
    for s in &summary.sensors {
        let mut add = |what: &str, factor: f64, value: Option<f64>, error: Option<f64>| {
            if let Some(value) = value {
                let number = Number { value: factor * value, half_width: factor * confidence * error.unwrap_or(0.0) };
                found.push((format!("{}: {what}", s.name), number));
            }
        };
        add("mean illuminance, lx", 1.0, s.mean_illuminance_lx, s.mean_illuminance_standard_error_lx);
        add("mean irradiance, W/m²", 1.0, s.mean_irradiance_w_m2, s.mean_irradiance_standard_error_w_m2);
        for metric in s.metrics.iter().filter(|m| !m.is_detail()) {
            let (unit, factor) = if metric.unit == "share" { ("%", 100.0) } else { (metric.unit.as_str(), 1.0) };
            add(&format!("{}, {unit}", metric.title), factor, metric.value, metric.standard_error);
        }
    }
    for glare in &results.year.glare {
        let lit: Vec<f64> = glare.dgp.iter().copied().filter(|v| v.is_finite()).collect();
        let above = lit.iter().filter(|v| **v > CLASS_LIMITS[1]).count() as f64 / lit.len().max(1) as f64;
        found.push((
            format!("{}: lit hours with DGP above {:.2}, %", glare.name(), CLASS_LIMITS[1]),
            Number { value: 100.0 * above, half_width: 0.0 },
        ));
    }
    found.push(("time of the run, s".into(), Number { value: summary.seconds.total, half_width: 0.0 }));
    found
}

/// The comparison of runs.
pub(super) fn section(names: &[String], results: &[Results]) -> Section {
    let all: Vec<Vec<(String, Number)>> = results.iter().map(numbers).collect();
    let mut head = vec!["".to_string()];
    head.extend(names.iter().cloned());
    head.extend(names[1..].iter().map(|n| format!("{n} − {}", names[0])));
    let mut table = Table { name: "comparison".into(), caption: "± is the interval of 95 %".into(), head, rows: Vec::new() };
    let mut order: Vec<&String> = Vec::new();
    all.iter().flatten().for_each(|(what, _)| {
        if !order.contains(&what) {
            order.push(what);
        }
    });
    let tables: Vec<BTreeMap<&String, Number>> = all.iter().map(|run| run.iter().map(|(what, n)| (what, *n)).collect()).collect();
    for what in order {
        let text = |n: Option<&Number>| n.map_or("–".into(), |n| with_interval(n.value, n.half_width));
        let mut row = vec![what.clone()];
        row.extend(tables.iter().map(|t| text(t.get(what))));
        for other in &tables[1..] {
            let difference = tables[0].get(what).zip(other.get(what)).map(|(a, b)| difference(*a, *b));
            row.push(text(difference.as_ref()));
        }
        table.rows.push(row);
    }
    let note = "The intervals of differences take the runs' noise as independent. Runs of the same seed share much of it: their differences are \
                known better than that.";
    Section { title: "Side by side", parts: vec![Part::Table(table), Part::Text(note.into())] }
}

fn difference(a: Number, b: Number) -> Number {
    Number { value: b.value - a.value, half_width: a.half_width.hypot(b.half_width) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_has_the_noise_of_both() {
        let [a, b] = [Number { value: 100.0, half_width: 3.0 }, Number { value: 90.0, half_width: 4.0 }];
        assert_eq!(difference(a, b), Number { value: -10.0, half_width: 5.0 });
    }
}
