//! Work in the background whose result arrives in a later frame.

use eframe::egui;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// One piece of work on its own thread.
pub struct Job<T> {
    receiver: Receiver<T>,
}

impl<T: Send + 'static> Job<T> {
    /// Starts `work`; the window is painted again when it is done.
    pub fn start(ctx: &egui::Context, work: impl FnOnce() -> T + Send + 'static) -> Self {
        let (sender, receiver) = channel();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            // Nobody may be waiting any more.
            let _ = sender.send(work());
            ctx.request_repaint();
        });
        Self { receiver }
    }

    /// The result, once; `Err` when the work has died.
    pub fn poll(&self) -> Option<Result<T, ()>> {
        match self.receiver.try_recv() {
            Ok(value) => Some(Ok(value)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(())),
        }
    }
}

/// A value that is computed in the background whenever its key changes; the last one stays visible
/// until the next is ready.
pub struct Derived<K, T> {
    asked: Option<K>,
    wanted: Option<K>,
    job: Option<Job<T>>,
    value: Option<(K, T)>,
}

impl<K, T> Default for Derived<K, T> {
    fn default() -> Self {
        Self { asked: None, wanted: None, job: None, value: None }
    }
}

impl<K: PartialEq + Clone, T: Send + 'static> Derived<K, T> {
    /// Starts the work for `key` unless it is done or under way, and takes what is ready.
    pub fn update<F: FnOnce() -> T + Send + 'static>(&mut self, ctx: &egui::Context, key: K, work: impl FnOnce() -> F) {
        if let Some(done) = self.job.as_ref().and_then(Job::poll) {
            self.job = None;
            if let (Ok(value), Some(wanted)) = (done, self.wanted.clone()) {
                self.value = Some((wanted, value));
            }
        }
        if self.wanted.as_ref() != Some(&key) && self.job.is_none() {
            self.wanted = Some(key.clone());
            self.job = Some(Job::start(ctx, work()));
        }
        self.asked = Some(key);
    }

    /// The value of the key asked for last, if it is ready.
    pub fn current(&self) -> Option<&T> {
        self.value.as_ref().filter(|(k, _)| Some(k) == self.asked.as_ref()).map(|(_, v)| v)
    }

    /// The newest value, which may belong to an earlier key: whoever shows it says so.
    pub fn newest(&self) -> Option<&T> {
        self.value.as_ref().map(|(_, v)| v)
    }

    /// Whether work is under way.
    pub fn busy(&self) -> bool {
        self.job.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_of_an_earlier_key_is_not_the_current_one() {
        let ctx = egui::Context::default();
        let mut derived = Derived::default();
        let settle = |derived: &mut Derived<u32, u32>, key: u32| {
            derived.update(&ctx, key, || move || key * 10);
            while derived.busy() {
                std::thread::sleep(std::time::Duration::from_millis(1));
                derived.update(&ctx, key, || move || key * 10);
            }
        };
        settle(&mut derived, 1);
        assert_eq!((derived.current(), derived.newest()), (Some(&10), Some(&10)));
        let (go, wait) = channel::<()>();
        derived.update(&ctx, 2, || move || wait.recv().map_or(0, |()| 20));
        assert_eq!((derived.current(), derived.newest()), (None, Some(&10)));
        go.send(()).unwrap();
        settle(&mut derived, 2);
        assert_eq!(derived.current(), Some(&20));
    }
}
