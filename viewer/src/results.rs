//! What is open of results: a year, its room, and a line about it.

use lucarne::Result;
use lucarne::matrix::Matrix;
use lucarne::scene::Scene;
use lucarne::simulate::year::Surroundings;
use lucarne::simulate::{self, Year};
use lucarne::weather::Weather;
use std::ops::Deref;
use std::path::{Path, PathBuf};

/// A year of results.
pub struct Results {
    /// One line about it.
    pub title: String,
    /// Names of the windows in the order of the view matrices' columns.
    pub windows: Vec<String>,
    year: Year,
    surroundings: Option<Surroundings>,
}

impl Deref for Results {
    type Target = Year;

    fn deref(&self) -> &Year {
        &self.year
    }
}

impl Results {
    /// Reads a folder.
    pub fn open(folder: &Path) -> Result<Self> {
        let simulate::Results { year, surroundings } = simulate::Results::open(folder)?;
        let summary = &year.summary;
        let known = |text: &str| if text.is_empty() { "?" } else { text }.to_string();
        let (preset, device) = (known(&summary.preset), known(&summary.device.name));
        let title = format!("{}   {} hours, preset {preset}, {device}", shortened(folder), year.times.len());
        let windows = summary.windows.iter().map(|w| w.name.clone()).collect();
        Ok(Self { title, windows, year, surroundings })
    }

    /// A year of illuminance from a matrix file alone.
    pub fn of_illuminance(path: &Path, lux: Matrix<f32>) -> Self {
        let title = format!("{}   {} sensors, {} hours", path.display(), lux.rows(), lux.cols());
        Self { title, windows: Vec::new(), year: Year::of_illuminance(path, lux), surroundings: None }
    }

    /// Number of steps.
    pub fn hours(&self) -> usize {
        self.times.len()
    }

    /// The room, if the project it came from is found.
    pub fn scene(&self) -> Option<&Scene> {
        self.surroundings.as_ref().map(|s| &s.scene)
    }

    /// Site and sun, likewise.
    pub fn weather(&self) -> Option<&Weather> {
        self.surroundings.as_ref().map(|s| &s.weather)
    }

    /// Further states of a window that the project names.
    pub fn states(&self, window: &str) -> &[PathBuf] {
        self.surroundings.as_ref().and_then(|s| s.states.get(window)).map_or(&[], Vec::as_slice)
    }
}

/// The last two parts of a path.
pub fn shortened(path: &Path) -> String {
    let parts: Vec<_> = path.components().rev().take(2).map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
    parts.into_iter().rev().collect::<Vec<_>>().join("/")
}
