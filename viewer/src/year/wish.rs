//! A picture that is wanted.

use crate::results::Results;
use lucarne::simulate::year::facade::FacadeState;

/// A picture that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// Hour of the year.
    pub hour: usize,
    /// State of the façade.
    pub state: FacadeState,
}

impl Wish {
    /// What this is when another one is wanted; nothing if it is the wanted one.
    pub fn instead_of(&self, wanted: &Self, results: &Results) -> Option<String> {
        if self == wanted {
            return None;
        }
        match results.times.get(self.hour).filter(|_| self.hour != wanted.hour) {
            Some(time) => Some(format!("picture of {time}")),
            None => Some("picture of an earlier state".into()),
        }
    }
}
