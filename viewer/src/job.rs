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
    wanted: Option<K>,
    job: Option<Job<T>>,
    value: Option<(K, T)>,
}

impl<K, T> Default for Derived<K, T> {
    fn default() -> Self {
        Self { wanted: None, job: None, value: None }
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
            self.wanted = Some(key);
            self.job = Some(Job::start(ctx, work()));
        }
    }

    /// The newest value, which may belong to an earlier key.
    pub fn value(&self) -> Option<&T> {
        self.value.as_ref().map(|(_, v)| v)
    }

    /// The value of this very key.
    pub fn value_of(&self, key: &K) -> Option<&T> {
        self.value.as_ref().filter(|(k, _)| k == key).map(|(_, v)| v)
    }

    /// Whether work is under way.
    pub fn busy(&self) -> bool {
        self.job.is_some()
    }
}
