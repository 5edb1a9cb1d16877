//! Progress on standard error: one line that changes on a terminal, a line every few seconds
//! elsewhere.

use lucarne::progress::Progress;
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Shows stage, percentage and time left.
pub struct Terminal {
    interactive: bool,
    state: Mutex<State>,
}

struct State {
    stage: String,
    started: Instant,
    shown: Option<Instant>,
}

impl Terminal {
    /// Progress on this process's standard error.
    pub fn new() -> Self {
        let state = State { stage: String::new(), started: Instant::now(), shown: None };
        Self { interactive: std::io::stderr().is_terminal(), state: Mutex::new(state) }
    }
}

impl Progress for Terminal {
    fn update(&self, stage: &str, fraction: f64) {
        let Ok(mut state) = self.state.lock() else { return };
        let now = Instant::now();
        if state.stage != stage {
            *state = State { stage: stage.to_string(), started: now, shown: None };
        }
        let pause = if self.interactive { Duration::from_millis(200) } else { Duration::from_secs(5) };
        let due = state.shown.unwrap_or(state.started) + pause <= now;
        let finished = fraction >= 1.0 && state.shown.is_some();
        if !due && !finished {
            return;
        }
        state.shown = Some(now);
        let spent = now.duration_since(state.started).as_secs_f64();
        let left = if fraction > 0.0 { format!(", {:.0} s left", spent * (1.0 - fraction) / fraction) } else { String::new() };
        let end = if self.interactive && !finished { "\r" } else { "\n" };
        let start = if self.interactive { "\x1b[2K" } else { "" };
        let mut out = std::io::stderr().lock();
        // Progress that cannot be shown is no reason to stop the work.
        let _ = write!(out, "{start}{stage}: {:.0} %{left}{end}", fraction * 100.0);
        let _ = out.flush();
    }
}
