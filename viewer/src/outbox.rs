//! What a panel asks of the window.

use crate::args::PanelKind;
use lucarne::Result;
use std::path::{Path, PathBuf};

/// Writes to a path.
pub type Writer = Box<dyn FnOnce(&Path) -> Result<()>>;

/// What a panel wants the window to do.
#[derive(Default)]
pub struct Outbox {
    /// Failures (true) and notes.
    pub messages: Vec<(bool, String)>,
    /// What is to be saved.
    pub save: Option<(PathBuf, Writer)>,
    /// The panel to change to.
    pub show: Option<PanelKind>,
}

impl Outbox {
    /// Tells the user about a failure.
    pub fn error(&mut self, text: String) {
        self.messages.push((true, text));
    }

    /// Tells the user that something was done.
    pub fn note(&mut self, text: String) {
        self.messages.push((false, text));
    }

    /// Asks for a name, then writes.
    pub fn save(&mut self, name: PathBuf, write: Writer) {
        self.save = Some((name, write));
    }

    /// Changes to another panel.
    pub fn show(&mut self, panel: PanelKind) {
        self.show = Some(panel);
    }
}
