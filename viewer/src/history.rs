//! Undo of view changes.

/// Most steps kept.
const LIMIT: usize = 100;

/// States passed through, with the ways back and forth.
pub struct History<T> {
    current: T,
    past: Vec<T>,
    future: Vec<T>,
}

impl<T: Clone + PartialEq> History<T> {
    /// A history that begins at `state`.
    pub fn new(state: T) -> Self {
        Self { current: state, past: Vec::new(), future: Vec::new() }
    }

    /// Notes the state of now; a new step if it differs. Called when no drag is under way, so that
    /// a drag is one step.
    pub fn note(&mut self, state: &T) {
        if *state != self.current {
            self.past.push(std::mem::replace(&mut self.current, state.clone()));
            self.future.clear();
            if self.past.len() > LIMIT {
                self.past.remove(0);
            }
        }
    }

    /// Replaces the state of now without a step: for what the program changes by itself.
    pub fn amend(&mut self, state: &T) {
        self.current = state.clone();
    }

    /// One step back.
    pub fn undo(&mut self) -> Option<T> {
        let state = self.past.pop()?;
        self.future.push(std::mem::replace(&mut self.current, state.clone()));
        Some(state)
    }

    /// One step forward again.
    pub fn redo(&mut self) -> Option<T> {
        let state = self.future.pop()?;
        self.past.push(std::mem::replace(&mut self.current, state.clone()));
        Some(state)
    }

    /// Whether there are steps back, and forward.
    pub fn steps(&self) -> (bool, bool) {
        (!self.past.is_empty(), !self.future.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_go_back_and_forth_and_a_new_one_cuts_the_future() {
        let mut h = History::new(1);
        h.note(&1);
        assert_eq!(h.steps(), (false, false));
        h.note(&2);
        h.note(&3);
        assert_eq!((h.undo(), h.undo(), h.undo()), (Some(2), Some(1), None));
        assert_eq!(h.redo(), Some(2));
        h.note(&7);
        assert_eq!((h.redo(), h.undo()), (None, Some(2)));
        for i in 0..500 {
            h.note(&i);
        }
        assert_eq!(h.past.len(), LIMIT);
    }
}
