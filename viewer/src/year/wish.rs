//! A picture that is wanted.

use crate::results::Results;
use lucarne::matrix::Matrix;
use std::sync::Arc;

/// A picture that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// Hour of the year.
    pub hour: usize,
    /// How far each window is on its way to its second state.
    pub fractions: Vec<f64>,
    /// Second states, by window; the number tells sets apart.
    pub states: (u64, Arc<Vec<Option<Matrix<f32>>>>),
}

impl Wish {
    /// What this is when another one is wanted; nothing if it is the wanted one.
    pub fn instead_of(&self, wanted: &Self, results: &Results) -> Option<String> {
        if self == wanted {
            return None;
        }
        match results.stamps.get(self.hour).filter(|_| self.hour != wanted.hour) {
            Some(stamp) => Some(format!("picture of {}", stamp.text())),
            None => Some("picture of an earlier state".into()),
        }
    }

    /// How much of a window is still in its first state.
    pub fn share(&self, window: usize) -> f64 {
        let has_second = self.states.1.get(window).is_some_and(Option::is_some);
        1.0 - self.fractions.get(window).filter(|_| has_second).map_or(0.0, |f| f.clamp(0.0, 1.0))
    }
}
