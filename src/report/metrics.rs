//! Metrics with names, their classes and what noise leaves open.

use super::parts::{Part, Section, Table, percent, with_interval};
use crate::metrics::Metric;
use crate::simulate::Results;

/// All metrics of a run.
pub(super) fn section(results: &Results) -> Section {
    let summary = &results.year.summary;
    let all: Vec<&Metric> = summary
        .sensors
        .iter()
        .flat_map(|s| &s.metrics)
        .chain(&summary.metrics)
        .chain(summary.glare.iter().flat_map(|g| &g.metrics))
        .collect();
    let title = "Metrics";
    if all.is_empty() {
        return Section { title, parts: vec![Part::Text("The results hold no metrics with names.".into())] };
    }
    let confidence = summary.estimated_error.map_or(2.0, |e| e.confidence_95);
    let head = ["of", "metric", "value", "class", "undecided", "source"];
    let mut named = Table::new("metrics", "± is the interval of 95 %", &head);
    let mut details = Table::new("metrics_details", "Means over sensors, and steps on the way to a class", &head);
    for metric in &all {
        let table = if metric.is_detail() { &mut details } else { &mut named };
        table.rows.push(row(metric, confidence));
    }
    let mut parts = Vec::new();
    if !named.rows.is_empty() {
        parts.push(Part::Table(named));
    }
    let mut notes: Vec<String> = Vec::new();
    for metric in &all {
        for note in &metric.notes {
            let line = format!("{}: {note}", metric.title);
            if !notes.contains(&line) {
                notes.push(line);
            }
        }
    }
    if !notes.is_empty() {
        parts.push(Part::Heading("Notes".into()));
        parts.push(Part::Notes(notes));
    }
    if !details.rows.is_empty() {
        parts.push(Part::Table(details));
    }
    Section { title, parts }
}

fn row(metric: &Metric, confidence: f64) -> Vec<String> {
    let (factor, unit) = if metric.unit == "share" { (100.0, "%") } else { (1.0, metric.unit.as_str()) };
    let value = metric.value.map_or("–".to_string(), |v| {
        format!("{} {unit}", with_interval(factor * v, factor * confidence * metric.standard_error.unwrap_or(0.0)))
    });
    let chance = metric.probability_of_another_class.filter(|_| metric.undecided);
    vec![
        metric.of.clone(),
        metric.title.clone(),
        value,
        metric.class.clone().unwrap_or_default(),
        chance.map_or(String::new(), |p| format!("{} for another class", percent(p))),
        metric.source.clone(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_noise_leaves_open_is_marked() {
        let mut metric = Metric::new("en17037_provision", "EN 17037 daylight provision", "share", "EN 17037").of("desks");
        metric = Metric { value: Some(0.52), standard_error: Some(0.01), class: Some("minimum".into()), undecided: true, ..metric };
        metric.probability_of_another_class = Some(0.12);
        assert_eq!(row(&metric, 2.0)[..5], ["desks", "EN 17037 daylight provision", "52.0 ± 2.0 %", "minimum", "12.0 % for another class"]);
    }
}
