//! Keeps what the benchmarks measure in `target/bench.json`, and says what changed since the last run.

#[path = "../../src/testing.rs"]
mod testing;

use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

#[allow(unused_imports, reason = "not every benchmark has a row in VALIDATION.md")]
pub use testing::{measured, percent, short};

/// Measurements of one benchmark.
pub struct Record {
    bench: &'static str,
    values: Map<String, Value>,
}

impl Record {
    /// An empty record of the benchmark of this name.
    pub fn new(bench: &'static str) -> Self {
        Self { bench, values: Map::new() }
    }

    /// A measurement: a rate or a ratio, of which more is better.
    pub fn add(&mut self, name: impl Into<String>, value: f64, unit: &str) {
        self.values.insert(name.into(), json!({ "value": value, "unit": unit }));
    }

    /// Compares with what is stored and stores instead of it. Names that this run did not measure stay.
    pub fn finish(self) {
        let path = path();
        let mut all: Map<String, Value> =
            std::fs::read_to_string(&path).ok().and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
        let stored = all.entry(self.bench).or_insert_with(|| json!({}));
        let Some(stored) = stored.as_object_mut() else { return };
        println!("\n{}: against the last run", self.bench);
        for (name, new) in self.values {
            let value = |v: &Value| v["value"].as_f64().unwrap_or(f64::NAN);
            let before = stored.get(&name).map(value);
            let change = before.map_or_else(|| "new".into(), |old| format!("{:+.0} % of {old:.4}", 100.0 * (value(&new) / old - 1.0)));
            println!("  {:10.4} {:24} {change:>20}   {name}", value(&new), new["unit"].as_str().unwrap_or_default());
            stored.insert(name, new);
        }
        let text = serde_json::to_string_pretty(&all).expect("numbers and names");
        match std::fs::write(&path, text + "\n") {
            Ok(()) => println!("written to {}", path.display()),
            Err(error) => println!("cannot write {}: {error}", path.display()),
        }
    }
}

fn path() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("target"), PathBuf::from)
        .join("bench.json")
}
