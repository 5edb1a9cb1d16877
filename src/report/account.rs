//! How exact the numbers are, what the windows' data are worth, warnings, where the time went.

use super::parts::{Part, Section, Table, percent};
use crate::bsdf;
use crate::bsdf::check::{Verdict, check};
use crate::error::Warnings;
use crate::image::palette::{rounded_number, short_number};
use crate::simulate::Results;
use std::path::PathBuf;

/// Errors of the sampling.
pub(super) fn accuracy(results: &Results) -> Section {
    let mut parts = Vec::new();
    if let Some(e) = results.year.summary.estimated_error {
        let mut facts = vec![
            ("A year at a sensor", format!("median {}, largest {} of the value", percent(e.annual_median), percent(e.annual_largest))),
            (
                "An hour at a sensor",
                format!("median {}, one in twenty above {}", percent(e.hourly_median), percent(e.hourly_95th_percentile)),
            ),
            ("For 95 % confidence", format!("standard errors times {:.2}", e.confidence_95)),
            ("From", format!("{} sensors, {} daylight hours", e.sensors, short_number(e.hours))),
        ];
        if let Some(target) = e.target {
            let met = match e.target_met {
                Some(true) => "reached",
                Some(false) => "not reached",
                None => "not judged",
            };
            facts.push(("Target", format!("{} of a year: {met}", percent(target))));
        }
        parts.push(Part::Facts(facts));
        parts.push(Part::Text(
            "Standard errors of the sampling: how far the same computation with other random numbers would come out. What the method itself \
             leaves out is told among the warnings and in the guide."
                .into(),
        ));
    } else {
        parts.push(Part::Text("The results hold no estimate of their error.".into()));
    }
    Section { title: "How exact", parts }
}

/// What the doctor says of the windows' BSDFs.
pub(super) fn windows(results: &Results) -> Section {
    let mut parts = Vec::new();
    let windows = results.surroundings.iter().flat_map(|a| &a.project.windows);
    let mut files: Vec<PathBuf> = Vec::new();
    for window in windows {
        let trees = window.states.iter().filter_map(|s| s.tensor_tree.as_ref()).chain(&window.tensor_tree).filter_map(|t| t.file.as_ref());
        files.extend(window.bsdf_files().into_iter().chain(trees).cloned());
    }
    files.sort();
    files.dedup();
    for file in files {
        let mut reading = Warnings::new();
        parts.push(Part::Heading(file.file_name().unwrap_or_default().to_string_lossy().into_owned()));
        match bsdf::read(&file, &mut reading) {
            Err(e) => parts.push(Part::Notes(vec![format!("cannot be read any more: {e}")])),
            Ok(bsdf) => {
                let findings = check(&bsdf, &reading);
                let sound = findings.iter().filter(|f| f.verdict == Verdict::Sound).count();
                parts.push(Part::Text(format!("{sound} of {} things examined are sound.", findings.len())));
                let name = format!("bsdf_{}", file.file_stem().unwrap_or_default().to_string_lossy());
                let mut table = Table::new(&name, "", &["", "examined", "where", "found"]);
                for f in findings.into_iter().filter(|f| f.verdict != Verdict::Sound) {
                    let word = if f.verdict == Verdict::Fault { "fault" } else { "note" };
                    table.rows.push(vec![word.into(), f.item.into(), f.place, f.text]);
                }
                if table.rows.is_empty() {
                    continue;
                }
                parts.push(Part::Table(table));
            }
        }
    }
    if parts.is_empty() {
        parts.push(Part::Text("The windows have no BSDF files, or the project was not found.".into()));
    }
    Section { title: "BSDFs", parts }
}

/// Warnings, matrices, times.
pub(super) fn record(results: &Results) -> Section {
    let summary = &results.year.summary;
    let mut parts = Vec::new();
    parts.push(Part::Heading("Warnings".into()));
    let notes: Vec<String> = summary.warnings.iter().chain(&results.year.notes).cloned().collect();
    parts.push(if notes.is_empty() { Part::Text("None.".into()) } else { Part::Notes(notes) });
    let s = &summary.seconds;
    let mut times = Table::new(
        "times",
        "Where the time of the last run went; stages that were taken from an earlier run take none",
        &["stage", "seconds"],
    );
    let stages = [
        ("sky matrix", s.sky),
        ("view matrix", s.view),
        ("daylight matrix", s.daylight),
        ("suns", s.suns),
        ("product", s.product),
        ("errors", s.error_estimate),
        ("glare", s.glare),
        ("writing", s.write),
        ("all", s.total),
    ];
    for (name, seconds) in stages.into_iter().filter(|(_, seconds)| *seconds >= 0.005) {
        times.rows.push(vec![name.into(), format!("{seconds:.2}")]);
    }
    parts.push(Part::Table(times));
    let mut matrices = Table::new("matrices", "Matrices", &["matrix", "rows", "columns", "rays", "rounds", "from"]);
    for m in &summary.matrices {
        let rounds = m.rounds.map_or(String::new(), |r| r.to_string());
        let rays = if m.rays == 0 { String::new() } else { rounded_number(m.rays as f64) };
        let from = if m.reused { "an earlier run" } else { "this run" };
        matrices.rows.push(vec![m.name.clone(), m.rows.to_string(), m.columns.to_string(), rays, rounds, from.into()]);
    }
    parts.push(Part::Table(matrices));
    Section { title: "Record", parts }
}
