//! Units of a stage that were finished, kept until the stage is.

use super::Store;
use super::fingerprint::Fingerprint;
use crate::error::Result;
use crate::files::journal::Journal;
use crate::progress::Progress;
use std::path::Path;

/// The progress of a stage in an output folder, with what an earlier run finished of it.
pub(crate) struct KeptStage<'a> {
    whole: &'a dyn Progress,
    journal: Journal,
}

/// Ending of the files of units.
const ENDING: &str = "units";

impl Store {
    /// A stage whose units are kept in `matrices/NAME.units`; `inputs` are what they depend on.
    pub(crate) fn stage<'a>(&self, name: &str, inputs: Fingerprint, whole: &'a dyn Progress) -> KeptStage<'a> {
        let path = self.folder.join("matrices").join(format!("{name}.{ENDING}"));
        KeptStage { whole, journal: Journal::open(&path, &inputs.to_string()) }
    }

    /// Removes the units of stages that are finished, or that this project does not have.
    pub(crate) fn remove_units(&self) {
        let Ok(entries) = std::fs::read_dir(self.folder.join("matrices")) else { return };
        let is_of_units = |path: &Path| path.extension().is_some_and(|e| e == ENDING);
        entries.flatten().map(|e| e.path()).filter(|p| is_of_units(p)).for_each(|path| {
            let _ = std::fs::remove_file(path);
        });
    }
}

impl KeptStage<'_> {
    /// The units in their order, for stages that are cut here.
    pub(crate) fn journal(&self) -> &Journal {
        &self.journal
    }

    /// Ends the stage: its result is stored.
    pub(crate) fn finish(self) {
        self.journal.finish();
    }
}

impl Progress for KeptStage<'_> {
    fn update(&self, stage: &str, fraction: f64) {
        self.whole.update(stage, fraction);
    }

    fn stop_requested(&self) -> bool {
        self.whole.stop_requested()
    }

    fn unit(&self, name: &str, make: &mut dyn FnMut() -> Result<Vec<u8>>) -> Result<Vec<u8>> {
        self.journal.unit(name, make)
    }
}
