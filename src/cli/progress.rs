//! Progress on standard error; Ctrl-C and the system's request to end; exit codes.

use lucarne::progress::Progress;
use lucarne::{Error, ErrorKind};
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

static STOP: AtomicBool = AtomicBool::new(false);

/// Shows the stage, its percentage and the time left: one line that is rewritten on a terminal, a
/// new line every few seconds elsewhere. Ctrl-C (and SIGTERM, SIGHUP) asks the work to stop at its next
/// safe point; a second one ends the program at once.
pub struct Terminal {
    state: Mutex<State>,
    terminal: bool,
}

struct State {
    stage: String,
    stage_start: Instant,
    shown: Option<Instant>,
    line_open: bool,
}

/// Exit code of work that was stopped.
const STOPPED: u8 = 4;

/// The exit codes, for `--help`. Those of wrong usage are clap's own.
pub const EXIT_CODES: &str = "Exit codes: 0 done; 1 something is wrong with the input; 2 wrong usage; 3 the device failed; \
     4 stopped (Ctrl-C, SIGTERM): the same command goes on where it was; 5 a file could not be read or written";

/// The exit code of a verb that failed.
pub fn failure(error: &Error) -> ExitCode {
    ExitCode::from(match error.kind() {
        ErrorKind::Input => 1,
        ErrorKind::Device => 3,
        ErrorKind::Stopped => STOPPED,
        ErrorKind::Io => 5,
        _ => 1,
    })
}

impl Terminal {
    /// Takes over Ctrl-C. Without a handler (where the system refuses one) Ctrl-C just ends the
    /// program; files are written whole or not at all in either case.
    pub fn new() -> Self {
        let _ = ctrlc::set_handler(|| {
            if STOP.swap(true, Ordering::SeqCst) {
                std::process::exit(i32::from(STOPPED));
            }
            eprintln!("\nlucarne: stopping; once more, and it ends at once");
        });
        let state = State { stage: String::new(), stage_start: Instant::now(), shown: None, line_open: false };
        Self { state: Mutex::new(state), terminal: std::io::stderr().is_terminal() }
    }

    /// Ends the rewritten line, so that what follows starts on its own.
    pub fn finish(&self) {
        let mut state = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if state.line_open {
            eprint!("\r\x1b[K");
            state.line_open = false;
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.finish();
    }
}

impl Progress for Terminal {
    fn update(&self, stage: &str, fraction: f64) {
        let Ok(mut state) = self.state.lock() else { return };
        let now = Instant::now();
        let new_stage = state.stage != stage;
        if new_stage {
            state.stage = stage.to_string();
            state.stage_start = now;
        }
        let pause = if self.terminal { Duration::from_millis(100) } else { Duration::from_secs(5) };
        let due = state.shown.is_none_or(|t| now - t >= pause);
        if !(due || new_stage && self.terminal) {
            return;
        }
        state.shown = Some(now);
        let left = time_left(now - state.stage_start, fraction).map(|t| format!(", {t} left")).unwrap_or_default();
        let text = format!("{stage} {:3.0} %{left}", 100.0 * fraction.clamp(0.0, 1.0));
        if self.terminal {
            eprint!("\r\x1b[K{text}");
            let _ = std::io::stderr().flush();
            state.line_open = true;
        } else {
            eprintln!("{text}");
        }
    }

    fn stop_requested(&self) -> bool {
        STOP.load(Ordering::SeqCst)
    }
}

/// The rest of a stage if it goes on as it began; nothing while that is guesswork.
fn time_left(elapsed: Duration, fraction: f64) -> Option<String> {
    if fraction.is_nan() || !(0.02..1.0).contains(&fraction) || elapsed < Duration::from_secs(1) {
        return None;
    }
    let seconds = (elapsed.as_secs_f64() * (1.0 - fraction) / fraction).ceil() as u64;
    Some(match seconds {
        0..=99 => format!("{seconds} s"),
        100..=5999 => format!("{} min", seconds.div_ceil(60)),
        _ => format!("{} h {} min", seconds / 3600, seconds % 3600 / 60),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_is_told_once_it_can_be_known() {
        let s = Duration::from_secs;
        assert_eq!(time_left(s(10), 0.5).as_deref(), Some("10 s"));
        assert_eq!(time_left(s(10), 0.04).as_deref(), Some("4 min"));
        assert_eq!(time_left(s(1000), 0.1).as_deref(), Some("2 h 30 min"));
        assert_eq!(time_left(s(10), 0.0), None);
        assert_eq!(time_left(s(10), f64::NAN), None);
        assert_eq!(time_left(s(0), 0.5), None);
        assert_eq!(time_left(s(10), 1.0), None);
    }
}
