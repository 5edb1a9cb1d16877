//! Whether template, sources and document fit together.

use super::document::{Piece, fits, pieces};
use std::collections::{BTreeMap, BTreeSet};

/// What is wrong with the document's structure: paragraphs that are not the template's with something in each place.
pub fn stale(template: &str, document: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let mut heading = "the beginning";
    let mut lines = document.lines();
    for (number, wanted) in template.lines().enumerate() {
        if wanted.starts_with('#') {
            heading = wanted;
        }
        let found = lines.next().unwrap_or_default();
        if !fits(&pieces(wanted), found, &mut Vec::new()) {
            faults.push(format!("line {}, under '{heading}': the template has\n    {wanted}\n  the document\n    {found}", number + 1));
        }
    }
    faults.extend(lines.map(|line| format!("after the template's end: {line}")));
    faults
}

/// Keys that the template names.
pub fn keys(template: &str) -> BTreeSet<&str> {
    let places = template.lines().flat_map(pieces).filter_map(|piece| match piece {
        Piece::Place(place) => Some(place),
        Piece::Text(_) => None,
    });
    places.map(|place| place.strip_suffix(".held").unwrap_or(place)).collect()
}

/// Keys that a source measures; a call without a key as text is a fault.
fn measured_keys(text: &str) -> Vec<Result<&str, &str>> {
    let calls = text.match_indices("measured(").filter(|(at, _)| !text[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
    calls
        .map(|(at, call)| {
            let after = text[at + call.len()..].trim_start();
            let key = after.strip_prefix('"').and_then(|key| key.split('"').next());
            key.ok_or_else(|| after.lines().next().unwrap_or_default())
        })
        .collect()
}

/// Keys that are not in the template and measured in exactly one place of the sources, given as (path, text).
pub fn unmatched(template: &str, sources: &[(String, String)]) -> Vec<String> {
    let mut faults = Vec::new();
    let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (path, text) in sources {
        for key in measured_keys(text) {
            match key {
                Ok(key) => places.entry(key).or_default().push(path),
                Err(call) => faults.push(format!("{path}: measured({call} …: the key must be a plain text")),
            }
        }
    }
    let wanted = keys(template);
    faults
        .extend(wanted.iter().filter(|key| !places.contains_key(**key)).map(|key| format!("'{key}' of the template is measured nowhere")));
    for (key, at) in places {
        if !wanted.contains(key) {
            faults.push(format!("{}: the template has no place for '{key}'", at[0]));
        }
        if at.len() > 1 {
            faults.push(format!("'{key}' is measured more than once: {}", at.join(", ")));
        }
    }
    faults
}
