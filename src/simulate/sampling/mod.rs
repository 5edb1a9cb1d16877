//! Rounds of sampling: which matrix gets the next one, when to stop, and how to go on after a stop.

pub(crate) mod chain;
pub(crate) mod estimate;
pub(crate) mod rounds;

use self::estimate::{Estimate, Spread};
use self::rounds::Part;
use crate::error::Result;
use crate::kernels::trace::TracedMatrix;
use crate::matrix::Matrix;
use crate::progress::Progress;
use crate::simulate::project::quality::Stop;
use crate::simulate::store::Store;
use crate::simulate::store::fingerprint::Fingerprint;
use std::time::{Duration, Instant};

/// A matrix that can be sampled.
pub(crate) struct Source<'a> {
    /// Name of its results, `V` or `D_WINDOW`.
    pub name: String,
    /// What determines it, but for the number of rounds.
    pub inputs: Fingerprint,
    /// Rows and columns.
    pub shape: (usize, usize),
    /// Whether every replicate's direct part is kept.
    pub keep_direct: bool,
    /// Whether its batches tell what traced suns stand for.
    pub has_sunlit: bool,
    /// Traces the round of this number, with batches.
    pub trace: Box<dyn Fn(u32, &dyn Progress) -> Result<TracedMatrix> + 'a>,
    /// What is known without sampling.
    pub exact: Option<Estimate>,
}

impl Source<'_> {
    /// The name that the plan of a run has for it.
    fn phase(&self) -> String {
        self.name.strip_prefix("D_").map_or_else(|| format!("{} of sensors", self.name), |window| format!("D of {window}"))
    }
}

/// How good the estimates are by now.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Relative standard error of what is asked for.
    pub error: f64,
    /// What it is at most, as far as the samples tell (see [`upper_variance`](crate::statistics::upper_variance)):
    /// sampling ends when this is no more than the target, not when an error of few degrees of freedom
    /// happens to be.
    pub at_most: f64,
    /// The variance that each source contributes where the error is largest.
    pub variances: Vec<f64>,
}

/// Tells how good estimates are.
pub(crate) struct Judge<'a> {
    /// Of all sources.
    pub judge: &'a dyn Fn(&[Estimate]) -> Result<Judgement>,
    /// Of each value asked for, the sum of the squares by which it differs among the replicates of the source of
    /// this number.
    pub squares: &'a dyn Fn(&[Estimate], usize) -> Vec<f64>,
}

/// Header key of a state: rounds of all sources when it was written.
const ROUNDS: &str = "LUCARNE_ROUNDS";
/// Header key: rays spent on this source.
const RAYS: &str = "LUCARNE_RAYS";
/// Header key: seconds of tracing of all sources so far.
const SECONDS: &str = "LUCARNE_SECONDS";
/// Header key: the target under which the rounds were chosen.
const TARGET: &str = "LUCARNE_TARGET";
/// A state is written at least this often.
const SAVE_AFTER: Duration = Duration::from_secs(10);
/// No run needs more; a judgement that never falls must end.
const MOST_ROUNDS: u32 = 1_000_000;

/// Samples all sources until told to stop. What an earlier run left is gone on from, and leads to the
/// same bits as one without a stop. Which source is next depends on rays and variances alone, never
/// on the clock. Returns the estimates and which of them were traced now.
///
/// # Errors
/// Failures of tracing, of the judgement and of the file system; when stopped, after the state has
/// been written.
pub(crate) fn sample(
    sources: &[Source<'_>],
    stop: Stop,
    store: &Store,
    progress: &dyn Progress,
    judge: &Judge<'_>,
) -> Result<(Vec<Estimate>, Vec<bool>)> {
    let mut state = State::load(sources, stop, store);
    let result = state.go_on(stop, store, progress, judge);
    // Also after a stop: the next run goes on from here.
    let saved = state.save(stop, store);
    result.and(saved)?;
    let traced = state.traced.clone();
    Ok((state.estimates, traced))
}

struct State<'s, 'a> {
    sources: &'s [Source<'a>],
    estimates: Vec<Estimate>,
    traced: Vec<bool>,
    dirty: Vec<bool>,
    seconds: f64,
    last_save: Instant,
}

impl<'s, 'a> State<'s, 'a> {
    fn load(sources: &'s [Source<'a>], stop: Stop, store: &Store) -> Self {
        let n = sources.len();
        let fresh = |source: &Source<'_>| source.exact.clone().unwrap_or_else(Estimate::none);
        let mut state = Self {
            sources,
            estimates: sources.iter().map(fresh).collect(),
            traced: vec![false; n],
            dirty: vec![false; n],
            seconds: 0.0,
            last_save: Instant::now(),
        };
        // The rounds of all sources as each file knew them.
        let mut known = vec![vec![0; n]; n];
        for (i, source) in sources.iter().enumerate().filter(|(_, s)| s.exact.is_none()) {
            if let Some((estimate, rounds, seconds)) = load_one(source, i, stop, store) {
                state.estimates[i] = estimate;
                state.seconds = state.seconds.max(seconds);
                known[i] = rounds;
            }
        }
        if let Stop::Adaptive { .. } = stop {
            // Files of different moments do not fit: a choice would not be the one made before.
            let fits = known.iter().all(|rounds| rounds.len() == n && rounds.iter().zip(&state.estimates).all(|(r, e)| *r <= e.rounds));
            if !fits {
                state.estimates = sources.iter().map(fresh).collect();
                state.seconds = 0.0;
            }
        }
        state
    }

    fn go_on(&mut self, stop: Stop, store: &Store, progress: &dyn Progress, judge: &Judge<'_>) -> Result<()> {
        let open: Vec<usize> = (0..self.sources.len()).filter(|&i| self.sources[i].exact.is_none()).collect();
        let first = match stop {
            Stop::Rounds(rounds) => rounds,
            Stop::Adaptive { .. } => 1,
        };
        for &i in &open {
            progress.begin(&self.sources[i].phase());
            while self.estimates[i].rounds < first {
                let part = Part::of(progress, self.estimates[i].rounds as usize, first as usize);
                self.round(i, None, stop, store, &part)?;
            }
        }
        let Stop::Adaptive { target, time, rounds } = stop else { return Ok(()) };
        for &i in &open {
            if self.estimates[i].spread.rounds == 0 {
                let squares = (judge.squares)(&self.estimates, i);
                let estimate = &mut self.estimates[i];
                estimate.spread.add(&squares, estimate.replicates.len());
                self.dirty[i] = true;
            }
        }
        let mut start: Option<f64> = None;
        progress.begin("rounds for a target");
        for _ in 0..MOST_ROUNDS {
            let total: u32 = self.estimates.iter().map(|e| e.rounds).sum();
            let over = time.is_some_and(|t| self.seconds >= t.as_secs_f64()) || rounds.is_some_and(|r| total >= r);
            if over || open.is_empty() {
                return Ok(());
            }
            let judgement = (judge.judge)(&self.estimates)?;
            if target.is_some_and(|t| judgement.at_most <= t) {
                return Ok(());
            }
            // One more of n rounds takes 1 / (n + 1) of the variance away, for the rays of a round.
            let gain = |&i: &usize| {
                let e = &self.estimates[i];
                let rays_per_round = (e.rays as f64 / f64::from(e.rounds)).max(1.0);
                judgement.variances[i] / f64::from(e.rounds + 1) / rays_per_round
            };
            let Some(best) = open.iter().copied().max_by(|a, b| gain(a).total_cmp(&gain(b))) else { return Ok(()) };
            if !(gain(&best) > 0.0) {
                // Nothing that is sampled here can make it better.
                return Ok(());
            }
            let start = *start.get_or_insert(judgement.at_most);
            let stage = StageWithError {
                whole: progress,
                told: match target {
                    Some(t) => format!("standard error {:.2} %, target {:.2} %: ", 100.0 * judgement.error, 100.0 * t),
                    None => format!("standard error {:.2} %: ", 100.0 * judgement.error),
                },
                fraction: fraction_done(start, judgement.at_most, target, time.map(|t| self.seconds / t.as_secs_f64().max(1e-9))),
            };
            self.round(best, Some(judge), stop, store, &stage)?;
        }
        Ok(())
    }

    fn round(&mut self, i: usize, judge: Option<&Judge<'_>>, stop: Stop, store: &Store, progress: &dyn Progress) -> Result<()> {
        let source = &self.sources[i];
        let clock = Instant::now();
        let number = self.estimates[i].rounds;
        let kept = store.stage(&source.name, *source.inputs.clone().add(&number), progress);
        let traced = (source.trace)(number, &kept)?;
        self.seconds += clock.elapsed().as_secs_f64();
        let mut round = Estimate::of_round(traced, source.keep_direct);
        if let Some(judge) = judge {
            // With this round alone in the place of all.
            std::mem::swap(&mut self.estimates[i], &mut round);
            let squares = (judge.squares)(&self.estimates, i);
            std::mem::swap(&mut self.estimates[i], &mut round);
            self.estimates[i].spread.add(&squares, round.replicates.len());
        }
        self.estimates[i].add(round);
        (self.traced[i], self.dirty[i]) = (true, true);
        if self.last_save.elapsed() > SAVE_AFTER {
            self.save(stop, store)?;
        }
        kept.finish();
        Ok(())
    }

    fn save(&mut self, stop: Stop, store: &Store) -> Result<()> {
        let rounds: Vec<String> = self.estimates.iter().map(|e| e.rounds.to_string()).collect();
        for (i, source) in self.sources.iter().enumerate() {
            if !std::mem::take(&mut self.dirty[i]) {
                continue;
            }
            let estimate = &self.estimates[i];
            let mut more =
                vec![format!("{ROUNDS}={}", rounds.join(" ")), format!("{RAYS}={}", estimate.rays), format!("{SECONDS}={}", self.seconds)];
            if let Stop::Adaptive { target: Some(target), .. } = stop {
                more.push(format!("{TARGET}={target}"));
            }
            let about = "independent replicates, one below the other, then the same of the direct part, then of what traced suns stand for";
            store.save_with(&file_name(&source.name), &estimate.stacked()?, source.inputs, about, &more)?;
            let spread = &estimate.spread;
            if spread.rounds > 0 {
                let squares = Matrix::from_data(spread.squares.len(), 1, 1, spread.squares.clone())?;
                let about = "squares by which the values asked for differ within rounds";
                let more = [format!("{ROUNDS}={}", spread.rounds)];
                store.save_with(&spread_name(&source.name), &squares, source.inputs, about, &more)?;
            }
        }
        self.last_save = Instant::now();
        Ok(())
    }
}

/// Name of the matrix file that holds the replicates.
fn file_name(source: &str) -> String {
    format!("replicates_{source}")
}

/// Name of the file that holds the spread within rounds.
fn spread_name(source: &str) -> String {
    format!("spread_{source}")
}

/// The spread within so many rounds.
fn load_spread(source: &Source<'_>, rounds: u32, batches: usize, store: &Store) -> Option<Spread> {
    let file = store.load_file(&spread_name(&source.name), source.inputs)?;
    let fits = file.value(ROUNDS)?.parse() == Ok(rounds);
    fits.then(|| Spread { squares: file.matrix.data().to_vec(), rounds, batches })
}

/// A state that an earlier run left, the rounds of all sources it knew of, and its seconds. Nothing
/// if it comes from other inputs, or went further than this run may.
fn load_one(source: &Source<'_>, number: usize, stop: Stop, store: &Store) -> Option<(Estimate, Vec<u32>, f64)> {
    let file = store.load_file(&file_name(&source.name), source.inputs)?;
    let rounds: Vec<u32> = file.value(ROUNDS)?.split_whitespace().map(|w| w.parse().ok()).collect::<Option<_>>()?;
    let own = *rounds.get(number)?;
    let rays = file.value(RAYS)?.parse().ok()?;
    let seconds: f64 = file.value(SECONDS)?.parse().ok()?;
    let allowed = match stop {
        Stop::Rounds(most) => own <= most,
        // Of a looser target this one's rounds are the continuation.
        Stop::Adaptive { target: Some(target), .. } => file.value(TARGET)?.parse::<f64>().ok()? >= target,
        Stop::Adaptive { rounds: Some(most), .. } => rounds.iter().sum::<u32>() <= most,
        Stop::Adaptive { .. } => true,
    };
    let m = &file.matrix;
    let rows = source.shape.0;
    let parts = m.rows().checked_div(rows)?;
    let sound = allowed && own > 0 && m.cols() == source.shape.1 && m.components() == 3 && m.rows() == parts * rows && parts >= 2;
    let of_each = match (source.keep_direct, source.has_sunlit) {
        (true, true) => [parts / 3; 2],
        (true, false) => [parts / 2, 0],
        (false, _) => [1, 0],
    };
    let mut estimate = Estimate::unstacked(m, rows, of_each, own, rays).ok()?;
    if let Stop::Adaptive { .. } = stop {
        match load_spread(source, own, estimate.replicates.len(), store) {
            Some(spread) => estimate.spread = spread,
            // Of the first round it follows from the replicates.
            None if own == 1 => {}
            None => return None,
        }
    }
    sound.then_some((estimate, rounds, seconds))
}

/// How far the work is, as far as it can be told: variance falls as one over the work.
fn fraction_done(start: f64, now: f64, target: Option<f64>, time: Option<f64>) -> f64 {
    let by_target = target.map_or(0.0, |t| if now > 0.0 && now.is_finite() && start > t { (t / now).powi(2) } else { 0.0 });
    by_target.max(time.unwrap_or(0.0)).clamp(0.0, 1.0)
}

/// Tells the error in front of every stage.
struct StageWithError<'a> {
    whole: &'a dyn Progress,
    told: String,
    fraction: f64,
}

impl Progress for StageWithError<'_> {
    fn update(&self, stage: &str, _fraction: f64) {
        self.whole.update(&format!("{}{stage}", self.told), self.fraction);
    }

    fn stop_requested(&self) -> bool {
        self.whole.stop_requested()
    }
}

#[cfg(test)]
mod coverage;
#[cfg(test)]
mod tests;
