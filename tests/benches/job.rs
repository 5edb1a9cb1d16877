//! The whole job on shipped scenes, and what each of its stages takes, from the runs' own summaries.
//!
//! `cargo bench --bench job [-- SCENE...]` (default: office blinds)

#[path = "record.rs"]
mod record;

use std::error::Error;
use std::path::Path;
use std::process::Command;

fn main() -> Result<(), Box<dyn Error>> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let given: Vec<String> = std::env::args().skip(1).filter(|a| scenes.join(a).join("project.toml").is_file()).collect();
    let names = if given.is_empty() { vec!["office".to_string(), "blinds".to_string()] } else { given };
    let mut record = record::Record::new("job");
    for name in names {
        let folder = tempfile::tempdir()?;
        let run = Command::new(env!("CARGO_BIN_EXE_lucarne"))
            .arg("run")
            .arg(scenes.join(&name).join("project.toml"))
            .arg("-o")
            .arg(folder.path())
            .output()?;
        if !run.status.success() {
            return Err(String::from_utf8_lossy(&run.stderr).into());
        }
        let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path().join("summary.json"))?)?;
        println!("{name}, {}", summary["device"]["name"].as_str().unwrap_or("?"));
        for (stage, seconds) in summary["seconds"].as_object().into_iter().flatten() {
            let seconds = seconds.as_f64().unwrap_or(0.0);
            println!("  {seconds:8.2} s  {stage}");
            // What takes no time says nothing.
            if seconds > 0.01 {
                record.add(format!("{name}: {stage}"), 1.0 / seconds, "1/s");
            }
        }
        record.add(format!("{name}: rays"), summary["rays_per_second"].as_f64().unwrap_or(0.0) / 1e6, "Mrays/s");
    }
    record.finish();
    Ok(())
}
