//! What an interrupted generation leaves, so that it can go on.

use super::Args;
use lucarne::files::{self, seal};
use lucarne::kernels::bsdf_generation::{Directions, GenerationOptions, Sample, Table};
use lucarne::{Error, Result, Warnings};
use std::path::{Path, PathBuf};

/// The sums of an interrupted run, beside the output.
pub(super) struct Store {
    path: Option<PathBuf>,
    inputs: String,
}

impl Store {
    pub(super) fn new(args: &Args, directions: Directions, options: &GenerationOptions, sample: &Sample, suffix: &str) -> Self {
        let path = args.output.as_ref().filter(|p| *p != Path::new("-")).map(|p| {
            let mut name = p.file_name().unwrap_or_default().to_os_string();
            name.push(format!("{suffix}.resume"));
            p.with_file_name(name)
        });
        let mut inputs = lucarne::simulate::Fingerprint::new("BSDF");
        inputs
            .add(&(directions, options))
            .add(&(sample.low, sample.high, sample.repeats))
            .add(&sample.scene.triangles)
            .add(&sample.scene.materials);
        Self { path, inputs: inputs.to_string() }
    }

    /// The table of an earlier run with the same inputs, or an empty one.
    pub(super) fn load(&self, directions: Directions, warnings: &mut Warnings) -> Table {
        let new = || Table::new(directions);
        let Some(path) = self.path.as_deref().filter(|p| p.exists()) else { return new() };
        let stale = |why: &str| Error::new(format!("{why}; starting anew")).file(path);
        if !seal::is_whole(path) {
            warnings.push(stale("these sums of an interrupted run have changed since they were written"));
            return new();
        }
        let found = files::read(path).ok().and_then(|bytes| {
            let (_, bytes) = bytes.split_at_checked(seal::line().len())?;
            let (inputs, rest) = bytes.split_at_checked(self.inputs.len())?;
            if inputs != self.inputs.as_bytes() { None } else { Table::from_bytes(directions, rest).ok() }
        });
        found.unwrap_or_else(|| {
            warnings.push(stale("these sums of an interrupted run belong to other inputs"));
            new()
        })
    }

    pub(super) fn save(&self, table: &Table) -> Result<()> {
        let Some(path) = &self.path else { return Ok(()) };
        seal::write_sealed(path, |out| {
            let parts = [seal::line().as_bytes(), self.inputs.as_bytes(), &table.to_bytes()].concat();
            out.write_all(&parts).map_err(|e| Error::io(path, &e))
        })
    }

    pub(super) fn remove(&self) {
        if let Some(path) = &self.path {
            // Nothing is lost if it stays: its inputs are checked.
            let _ = std::fs::remove_file(path);
        }
    }
}
