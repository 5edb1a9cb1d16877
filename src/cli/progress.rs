//! Progress on standard error; Ctrl-C and the system's request to end; exit codes.

use lucarne::progress::{Progress, Whole};
use lucarne::{Error, ErrorKind};
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

static STOP: AtomicBool = AtomicBool::new(false);

/// How progress is shown on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Shown {
    /// A line on a terminal, lines elsewhere
    Auto,
    /// One line that is rewritten
    Line,
    /// A new line every few seconds
    Lines,
    /// One object a line, each second: stage, fraction of it, share of the whole, seconds left
    Json,
    /// Nothing
    None,
}

static SHOWN: OnceLock<Shown> = OnceLock::new();

/// Chooses how progress is shown from now on.
pub fn show_as(shown: Shown) {
    let _ = SHOWN.set(shown);
}

/// Shows the stage and what is done of it, and of a whole run the finished share and the time left. Ctrl-C (and
/// SIGTERM, SIGHUP) asks the work to stop at its next safe point; a second one ends the program at once.
pub struct Terminal {
    state: Mutex<State>,
    shown: Shown,
}

struct State {
    stage: String,
    stage_start: Instant,
    shown: Option<Instant>,
    line_open: bool,
}

/// Takes over Ctrl-C, for work that keeps what it has done.
fn catch_stop() {
    // Where the system refuses a handler, Ctrl-C just ends the program; files are written whole or not at all in
    // either case.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(STOPPED));
        }
        eprintln!("\nlucarne: stopping; once more, and it ends at once");
    });
}

/// Whether the work was asked to stop; from the first call on, a request is caught.
pub fn stop_asked() -> bool {
    static CAUGHT: std::sync::Once = std::sync::Once::new();
    CAUGHT.call_once(catch_stop);
    STOP.load(Ordering::SeqCst)
}

/// Exit code of work that was stopped.
const STOPPED: u8 = 4;
/// Of what could not be read or written.
pub const IO_FAILED: u8 = 5;

/// The exit codes, for `--help`. Those of wrong usage are clap's own.
pub const EXIT_CODES: &str = "Exit codes: 0 done; 1 something is wrong with the input; 2 wrong usage; 3 the device failed; \
     4 stopped (Ctrl-C, SIGTERM): the same command goes on where it was; 5 a file could not be read or written";

/// The exit code of a verb that failed.
pub fn failure(error: &Error) -> ExitCode {
    ExitCode::from(match error.kind() {
        ErrorKind::Input => 1,
        ErrorKind::Device => 3,
        ErrorKind::Stopped => STOPPED,
        ErrorKind::Io => IO_FAILED,
        _ => 1,
    })
}

impl Terminal {
    /// Takes over Ctrl-C.
    pub fn new() -> Self {
        stop_asked();
        let state = State { stage: String::new(), stage_start: Instant::now(), shown: None, line_open: false };
        let shown = match SHOWN.get().copied().unwrap_or(Shown::Auto) {
            Shown::Auto if std::io::stderr().is_terminal() => Shown::Line,
            Shown::Auto => Shown::Lines,
            chosen => chosen,
        };
        Self { state: Mutex::new(state), shown }
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

impl Terminal {
    fn tell(&self, stage: &str, fraction: f64, whole: Option<Whole>) {
        let Ok(mut state) = self.state.lock() else { return };
        let now = Instant::now();
        let new_stage = state.stage != stage;
        if new_stage {
            state.stage = stage.to_string();
            state.stage_start = now;
        }
        let pause = match self.shown {
            Shown::None => return,
            Shown::Line => Duration::from_millis(100),
            Shown::Json => Duration::from_secs(1),
            Shown::Lines | Shown::Auto => Duration::from_secs(5),
        };
        let due = state.shown.is_none_or(|t| now - t >= pause);
        if !(due || new_stage && matches!(self.shown, Shown::Line | Shown::Json)) {
            return;
        }
        state.shown = Some(now);
        let of_stage = seconds_left(now - state.stage_start, fraction);
        match self.shown {
            Shown::Json => eprintln!("{}", json(stage, fraction, whole, of_stage)),
            Shown::Line => {
                eprint!("\r\x1b[K{}", line(stage, fraction, whole, of_stage));
                let _ = std::io::stderr().flush();
                state.line_open = true;
            }
            _ => eprintln!("{}", line(stage, fraction, whole, of_stage)),
        }
    }
}

impl Progress for Terminal {
    fn update(&self, stage: &str, fraction: f64) {
        self.tell(stage, fraction, None);
    }

    fn update_of_whole(&self, stage: &str, fraction: f64, whole: Whole) {
        self.tell(stage, fraction, Some(whole));
    }

    fn shows_whole(&self) -> bool {
        self.shown != Shown::None
    }

    fn stop_requested(&self) -> bool {
        STOP.load(Ordering::SeqCst)
    }
}

/// A stage alone tells its own time left, a run that of all of it.
fn line(stage: &str, fraction: f64, whole: Option<Whole>, of_stage: Option<f64>) -> String {
    let percent = |share: f64| 100.0 * share.clamp(0.0, 1.0);
    let text = format!("{stage} {:3.0} %", percent(fraction));
    let (text, left) = match whole {
        None => (text, of_stage),
        Some(whole) => (format!("{text}, run {:3.0} %", percent(whole.share)), whole.seconds_left),
    };
    left.map_or_else(|| text.clone(), |seconds| format!("{text}, {} left", duration(seconds)))
}

fn json(stage: &str, fraction: f64, whole: Option<Whole>, of_stage: Option<f64>) -> String {
    let rounded = |value: f64, digits: f64| (value * digits).round() / digits;
    let mut told = serde_json::Map::new();
    told.insert("stage".into(), stage.into());
    told.insert("fraction".into(), rounded(fraction.clamp(0.0, 1.0), 1e4).into());
    if let Some(whole) = whole {
        told.insert("share".into(), rounded(whole.share, 1e4).into());
    }
    let left = whole.map_or(of_stage, |w| w.seconds_left);
    told.insert("seconds_left".into(), left.map(|s| rounded(s, 10.0)).into());
    serde_json::Value::Object(told).to_string()
}

/// The rest of a stage if it goes on as it began; nothing while that is guesswork.
fn seconds_left(elapsed: Duration, fraction: f64) -> Option<f64> {
    let known = (0.02..1.0).contains(&fraction) && elapsed >= Duration::from_secs(1);
    known.then(|| elapsed.as_secs_f64() * (1.0 - fraction) / fraction)
}

fn duration(seconds: f64) -> String {
    let seconds = seconds.ceil() as u64;
    match seconds {
        0..=99 => format!("{seconds} s"),
        100..=5999 => format!("{} min", seconds.div_ceil(60)),
        _ => format!("{} h {} min", seconds / 3600, seconds % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_is_told_once_it_can_be_known() {
        let s = Duration::from_secs;
        let told = |elapsed, fraction| seconds_left(elapsed, fraction).map(duration);
        assert_eq!(told(s(10), 0.5).as_deref(), Some("10 s"));
        assert_eq!(told(s(10), 0.04).as_deref(), Some("4 min"));
        assert_eq!(told(s(1000), 0.1).as_deref(), Some("2 h 30 min"));
        for (elapsed, fraction) in [(10, 0.0), (10, f64::NAN), (0, 0.5), (10, 1.0)] {
            assert_eq!(told(s(elapsed), fraction), None);
        }
    }

    #[test]
    fn a_run_tells_its_share_and_the_rest_of_all_of_it() {
        let whole = Whole { share: 0.345, seconds_left: Some(130.0) };
        assert_eq!(line("view matrix", 0.56, Some(whole), Some(3.0)), "view matrix  56 %, run  34 %, 3 min left");
        assert_eq!(line("BSDF", 0.56, None, Some(3.0)), "BSDF  56 %, 3 s left");
        let told: serde_json::Value = serde_json::from_str(&json("a \"stage\"", 0.5, Some(whole), None)).unwrap();
        assert_eq!(told, serde_json::json!({"stage": "a \"stage\"", "fraction": 0.5, "share": 0.345, "seconds_left": 130.0}));
        let told: serde_json::Value = serde_json::from_str(&json("BSDF", f64::NAN, None, None)).unwrap();
        assert_eq!(told["seconds_left"], serde_json::Value::Null);
    }
}
