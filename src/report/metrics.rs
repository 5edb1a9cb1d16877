//! Metrics with names, their classes and what noise leaves open.

use super::parts::{Part, Section, Table, confidence_95, percent, with_interval};
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
    let confidence = confidence_95(summary);
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
    let notes = notes(&all);
    if !notes.is_empty() {
        parts.push(Part::Heading("Notes".into()));
        parts.push(Part::Notes(notes));
    }
    if !details.rows.is_empty() {
        parts.push(Part::Table(details));
    }
    Section { title, parts }
}

/// Titles of a note before it says how many more there are.
const MOST_TITLES: usize = 2;

/// Every note once, with what it is about.
fn notes(all: &[&Metric]) -> Vec<String> {
    let mut found: Vec<(&String, Vec<String>)> = Vec::new();
    for metric in all {
        let title = words(metric.title.split(':').next().unwrap_or_default());
        for note in &metric.notes {
            match found.iter_mut().find(|(text, _)| *text == note) {
                Some((_, titles)) if titles.contains(&title) => {}
                Some((_, titles)) => titles.push(title.clone()),
                None => found.push((note, vec![title.clone()])),
            }
        }
    }
    let line = |(note, titles): (&String, Vec<String>)| {
        let more = titles.len().saturating_sub(MOST_TITLES);
        let more = if more == 0 { String::new() } else { format!(" and {more} more") };
        format!("{note} ({}{more})", titles[..titles.len().min(MOST_TITLES)].join("; "))
    };
    found.into_iter().map(line).collect()
}

/// A name of a column as words.
pub(super) fn words(name: &str) -> String {
    name.replace('_', " ")
}

fn row(metric: &Metric, confidence: f64) -> Vec<String> {
    let (factor, unit) = if metric.unit == "share" { (100.0, "%") } else { (1.0, metric.unit.as_str()) };
    let value = metric.value.map_or("–".to_string(), |v| {
        format!("{} {unit}", with_interval(factor * v, factor * confidence * metric.standard_error.unwrap_or(0.0)))
    });
    let chance = metric.probability_of_another_class.filter(|_| metric.undecided);
    vec![
        metric.of.clone(),
        words(&metric.title),
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
    fn a_note_of_many_metrics_stands_once() {
        let metric = |title: &str| Metric::new("m", title, "share", "guide").note("3650 h").note("24 sensors");
        let all = [metric("autonomy_300_lx, mean"), metric("UDI: x"), metric("cDA"), metric("cDA")];
        let all: Vec<&Metric> = all.iter().collect();
        assert_eq!(notes(&all)[0], "3650 h (autonomy 300 lx, mean; UDI and 1 more)");
        assert_eq!(notes(&all).len(), 2);
    }

    #[test]
    fn what_noise_leaves_open_is_marked() {
        let mut metric = Metric::new("en17037_provision", "EN 17037 daylight provision", "share", "EN 17037").of("desks");
        metric = Metric { value: Some(0.52), standard_error: Some(0.01), class: Some("minimum".into()), undecided: true, ..metric };
        metric.probability_of_another_class = Some(0.12);
        assert_eq!(row(&metric, 2.0)[..5], ["desks", "EN 17037 daylight provision", "52.0 ± 2.0 %", "minimum", "12.0 % for another class"]);
    }
}
