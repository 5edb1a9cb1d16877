//! Dew points as `gendaymtx` takes them.

use super::Record;

/// Dew point assumed where a file tells none, °C (gendaymtx).
const DEFAULT_DEW_POINT: f64 = 11.0;

/// Mean dew point of a record and the two before it.
#[derive(Default)]
pub(crate) struct DewPoints {
    previous: Option<[f64; 2]>,
    mean: Option<f64>,
}

impl DewPoints {
    pub(crate) fn mean(&mut self, record: &Record) -> f64 {
        if let Some(now) = record.dew_point {
            let [older, newer] = self.previous.unwrap_or([now; 2]);
            self.mean = Some((older + newer + now) / 3.0);
            self.previous = Some([newer, now]);
        } else {
            // After a gap the mean starts anew; inside it the last one still holds.
            self.previous = None;
        }
        self.mean.unwrap_or(DEFAULT_DEW_POINT)
    }
}
