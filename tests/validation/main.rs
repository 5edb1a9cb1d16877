//! VALIDATION.md is `template.md` with what tests and benchmarks measured in its places; `make validation` writes it.

use std::path::{Path, PathBuf};

mod checks;
mod document;

use checks::{keys, stale, unmatched};
use document::{NOTHING, fill};

const TEMPLATE: &str = include_str!("template.md");

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn present() -> String {
    std::fs::read_to_string(root().join("VALIDATION.md")).unwrap_or_default()
}

/// Rust sources below a folder, as (path, text).
fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path: PathBuf = entry.unwrap().path();
        // What is defined there, and these tests, measure nothing.
        if path.ends_with("src/testing.rs") || path.ends_with("tests/validation") {
            continue;
        }
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push((path.display().to_string(), std::fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn every_place_of_the_template_is_measured_once() {
    let mut all = Vec::new();
    ["src", "tests", "viewer/src"].iter().for_each(|folder| sources(&root().join(folder), &mut all));
    let faults = unmatched(TEMPLATE, &all);
    assert!(faults.is_empty(), "tests/validation/template.md and calls of testing::measured differ:\n{}", faults.join("\n"));
    assert!(keys(TEMPLATE).len() > 30, "only {} keys", keys(TEMPLATE).len());
}

#[test]
fn validation_has_the_structure_of_its_template() {
    let faults = stale(TEMPLATE, &present());
    assert!(faults.is_empty(), "VALIDATION.md is stale: run `make validation`\n{}", faults.join("\n"));
}

const MADE_UP: &str =
    "# Made up\n\n| What | Found | Held |\n|---|---|---|\n| light | within {{light}}, {{dark}} | {{light.held}} |\n\nEnd.\n";
const FILLED: &str = "# Made up\n\n| What | Found | Held |\n|---|---|---|\n| light | within 1 %, 2 % of it, in the mean | 5 % |\n\nEnd.\n";

#[test]
fn a_stale_document_is_found() {
    assert_eq!(stale(MADE_UP, FILLED), [""; 0]);
    for (from, to) in
        [("| 5 %", "| "), ("within", "up to"), ("End", "The end"), ("End.\n", ""), ("End.\n", "End.\n\nMore.\n"), ("2 %", "2 | %")]
    {
        assert_ne!(stale(MADE_UP, &FILLED.replace(from, to)), [""; 0], "'{to}' for '{from}'");
    }
    let faults = stale(MADE_UP, &FILLED.replace("within", "up to"));
    assert!(faults.len() == 1 && faults[0].contains("line 5, under '# Made up'"), "{faults:?}");
}

#[test]
fn unmatched_keys_are_found() {
    let source = |text: &str| vec![("a.rs".to_string(), text.to_string())];
    let both = "testing::measured(\"light\", &f, &h);\nmeasured(\n    \"dark\",\n    f, h);\nunmeasured(x);";
    assert_eq!(unmatched(MADE_UP, &source(both)), [""; 0]);
    let found = |text: &str, fault: &str| {
        let faults = unmatched(MADE_UP, &source(text));
        assert!(faults.len() == 1 && faults[0].contains(fault), "{faults:?}");
    };
    found("measured(\"light\", f, h)", "'dark' of the template is measured nowhere");
    found(&format!("{both} measured(\"grey\", f, h)"), "no place for 'grey'");
    found(&format!("{both} measured(\"dark\", f, h)"), "more than once");
    found(&format!("{both} measured(&key, f, h)"), "&key");
}

#[test]
fn what_was_measured_is_filled_in_and_what_was_not_is_kept() {
    let of = |key: &str| (key == "light").then(|| ["3 %".to_string(), "6 %".to_string()]);
    let (text, kept) = fill(MADE_UP, FILLED, of);
    assert_eq!(text, FILLED.replace("1 %", "3 %").replace("5 %", "6 %"));
    assert_eq!(kept, ["dark"]);
    // From a document of another structure, whose line is alike; and from none.
    let (text, _) = fill(MADE_UP, &format!("Before.\n{FILLED}"), |_| None);
    assert_eq!(text, FILLED);
    let (text, kept) = fill(MADE_UP, "", of);
    assert_eq!(text, MADE_UP.replace("{{light}}", "3 %").replace("{{light.held}}", "6 %").replace("{{dark}}", NOTHING));
    assert_eq!(kept, ["dark"]);
}
