//! `[quality]`: accuracy against time.

use super::table::Table;
use crate::error::{Error, Result};
use std::time::Duration;

/// How much work is spent on accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    /// A first look: twice the errors of `Standard`.
    Draft,
    /// Standard errors of a year's light at a sensor of less than 2 %; about 0.3 % in the shipped
    /// office.
    Standard,
    /// Errors about a quarter of `Standard`'s.
    Final,
}

impl Preset {
    const NAMES: [(&'static str, Preset); 3] = [("draft", Preset::Draft), ("standard", Preset::Standard), ("final", Preset::Final)];

    /// The word in the project file.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, p)| *p == self).map_or("", |(n, _)| n)
    }

    /// The relative standard error that it is meant to stay below, of a year's light at the worst
    /// sensor. The summary says whether it did.
    pub fn target(self) -> f64 {
        match self {
            Self::Draft => 0.05,
            Self::Standard => 0.02,
            Self::Final => 0.005,
        }
    }
}

/// When sampling stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// After so many rounds of every matrix.
    Rounds(u32),
    /// Once the relative standard error is no more than the target, or the time is over, or after so
    /// many rounds of all matrices together.
    Adaptive {
        /// Relative standard error to reach.
        target: Option<f64>,
        /// Time for tracing.
        time: Option<Duration>,
        /// Rounds of all matrices together.
        rounds: Option<u32>,
    },
}

/// `[quality]`. At most one of `preset`, `rounds`, and `target_error` with or without `time_limit`.
#[derive(Debug, Clone, PartialEq)]
pub struct QualitySection {
    /// Samples of a round: the preset, `Standard` under the other settings.
    pub preset: Preset,
    /// Relative standard error to reach, of a year's light at the worst sensor, or without sensors at the
    /// eye of each view.
    pub target_error: Option<f64>,
    /// Time for tracing V and D.
    pub time_limit: Option<Duration>,
    /// Rounds of all matrices together: repeats what a time limit came to.
    pub rounds: Option<u32>,
    /// Seed of all random numbers: the same seed on the same device gives the same bits.
    pub seed: u32,
    /// Samples as a multiple of the preset's, for measurements; 1 for all projects. Above 1 they are
    /// taken in as many rounds.
    pub scale: f64,
    /// Whether what a scene does not need is left out; cleared by `lucarne run --no-prune` only.
    pub prune: bool,
}

/// Targets: from what f32 can bear to what is of some use.
const TARGETS: std::ops::RangeInclusive<f64> = 1e-4..=0.5;

impl Default for QualitySection {
    fn default() -> Self {
        Self { preset: Preset::Standard, target_error: None, time_limit: None, rounds: None, seed: 1, scale: 1.0, prune: true }
    }
}

impl QualitySection {
    pub(super) fn read(table: Option<Table<'_, '_>>) -> Result<Self> {
        let mut quality = Self::default();
        let Some(mut table) = table else { return Ok(quality) };
        let preset = table.choice("preset", &Preset::NAMES)?;
        quality.preset = preset.unwrap_or(quality.preset);
        quality.target_error = table.number("target_error", TARGETS)?;
        quality.time_limit = match table.string("time_limit")? {
            None => None,
            Some(text) => Some(parse_time(&text).map_err(|e| table.error("time_limit", e.message()).help(TIME_HELP))?),
        };
        quality.rounds = table.integer("rounds", 1..=1_000_000)?.map(|n| n as u32);
        quality.seed = table.integer("seed", 0..=u64::from(u32::MAX))?.map_or(quality.seed, |s| s as u32);
        quality.check(preset.is_some(), &table)?;
        table.finish()?;
        Ok(quality)
    }

    fn check(&self, preset: bool, table: &Table<'_, '_>) -> Result<()> {
        let given = [
            ("preset", preset),
            ("target_error", self.target_error.is_some()),
            ("time_limit", self.time_limit.is_some()),
            ("rounds", self.rounds.is_some()),
        ];
        let given: Vec<&str> = given.iter().filter(|(_, there)| *there).map(|(key, _)| *key).collect();
        match given[..] {
            [] | [_] | ["target_error", "time_limit"] => Ok(()),
            [first, second, ..] => Err(table
                .error(second, format!("'{first}' and '{second}' contradict each other: each says how much to sample"))
                .help("keep one of them; target_error and time_limit may stand together and mean whichever comes first")),
        }
    }

    /// When sampling ends.
    pub fn stop(&self) -> Stop {
        match (self.target_error, self.time_limit, self.rounds) {
            (None, None, None) => Stop::Rounds(match self.preset {
                Preset::Draft | Preset::Standard => self.scale.max(1.0) as u32,
                Preset::Final => 16,
            }),
            (target, time, rounds) => Stop::Adaptive { target, time, rounds },
        }
    }

    /// What was asked for, in words.
    pub fn name(&self) -> String {
        match (self.target_error, self.time_limit, self.rounds) {
            (None, None, None) => self.preset.name().to_string(),
            (Some(target), None, _) => format!("target error {} %", percent(target)),
            (None, Some(time), _) => format!("time limit {:.0} s", time.as_secs_f64()),
            (Some(target), Some(time), _) => format!("target error {} % within {:.0} s", percent(target), time.as_secs_f64()),
            (None, None, Some(rounds)) => format!("{rounds} rounds"),
        }
    }

    /// The relative standard error that the result should have, if it should.
    pub fn target(&self) -> Option<f64> {
        match self.stop() {
            Stop::Rounds(_) => Some(self.preset.target()),
            Stop::Adaptive { target, .. } => target,
        }
    }
}

/// Without the digits that binary fractions add.
fn percent(fraction: f64) -> f64 {
    (fraction * 1e6).round() / 1e4
}

const TIME_HELP: &str = "write a number and s, min or h, as in \"5 min\"";

/// A length of time in words, as in "5 min".
pub(in crate::simulate) fn parse_time(text: &str) -> Result<Duration> {
    let text = text.trim();
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let seconds = match unit.trim() {
        "s" | "sec" | "second" | "seconds" => 1.0,
        "min" | "minute" | "minutes" => 60.0,
        "h" | "hour" | "hours" => 3600.0,
        _ => return Err(unreadable(text)),
    };
    let number: f64 = number.trim().parse().map_err(|_| unreadable(text))?;
    if !(number > 0.0 && number * seconds < 1e7) {
        return Err(unreadable(text));
    }
    Ok(Duration::from_secs_f64(number * seconds))
}

fn unreadable(text: &str) -> Error {
    Error::new(format!("'{text}' is not a length of time")).help("write a number and s, min or h, as in \"5 min\"")
}
