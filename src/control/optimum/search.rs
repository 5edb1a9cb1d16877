//! One step: branch and bound over the groups.

use super::problem::{Aim, Limit, Problem};
use crate::control::State;

/// The best combination of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// A state of each group.
    pub states: Vec<State>,
    /// The aim's value.
    pub value: f64,
    /// By how much limits are exceeded, relative: 0 where they are met.
    pub excess: f64,
    /// By how much the value (or, where limits are exceeded, the excess) may be worse than the best; 0 if the search was
    /// exact.
    pub may_be_lost: f64,
}

/// Bounds of sums that are added in another order.
const ROUNDING: f64 = 1e-9;

/// The best combination of a step's light (see [`Lights`](super::Lights)), of the states that `allowed` (`[group]`, rising) lists.
///
/// # Panics
/// If the light has not as many values as the problem, or a group has no state.
pub fn best(problem: &Problem, light: &[f64], allowed: Option<&[Vec<State>]>) -> Best {
    assert_eq!(light.len(), problem.values(), "the light of all states");
    let all: Vec<Vec<State>>;
    let allowed = match allowed {
        Some(allowed) => allowed,
        None => {
            all = problem.states.iter().map(|n| (0..*n as State).collect()).collect();
            &all
        }
    };
    assert!(allowed.len() == problem.states.len() && allowed.iter().all(|a| !a.is_empty()), "a state of each group");
    let mut search = Search::new(problem, light, allowed);
    search.run(Wanted::Gain);
    if search.found.is_none() && !search.ended {
        // No combination meets the limits: the one that exceeds them least.
        search.run(Wanted::LeastExcess);
    } else if search.found.is_none() {
        let lost = search.left;
        search.run(Wanted::LeastExcess);
        search.left = search.left.max(lost);
    }
    search.result()
}

#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    /// The best of those that meet the limits.
    Gain,
    /// The least excess, then the best.
    LeastExcess,
}

struct Search<'a> {
    problem: &'a Problem,
    light: &'a [f64],
    allowed: &'a [Vec<State>],
    /// Channels that limits and aim look at one by one.
    active: Vec<usize>,
    /// The most that groups from each on can add, `[group][channel]`.
    most: Vec<Vec<f64>>,
    /// Sum over the sensors of each state, where the aim is their mean.
    daylight: Vec<Vec<f64>>,
    most_daylight: Vec<f64>,
    /// Light of the first groups, `[groups chosen][channel]`.
    sums: Vec<Vec<f64>>,
    states: Vec<State>,
    found: Option<(Vec<State>, f64, f64)>,
    visits: u64,
    ended: bool,
    /// The best bound of what was not looked at.
    left: f64,
}

impl<'a> Search<'a> {
    fn new(problem: &'a Problem, light: &'a [f64], allowed: &'a [Vec<State>]) -> Self {
        let groups = problem.states.len();
        let mut is_active = vec![!matches!(problem.aim, Aim::Daylight); problem.sensors];
        is_active.resize(problem.channels, false);
        for limit in &problem.limits {
            match limit {
                Limit::Most { channel, .. } => is_active[*channel] = true,
                Limit::Dgp { illuminance, contrast, .. } => [*illuminance, *contrast].iter().for_each(|c| is_active[*c] = true),
                Limit::Share { channels, .. } => is_active[channels.clone()].fill(true),
                Limit::Whole { .. } => {}
            }
        }
        let active: Vec<usize> = (0..problem.channels).filter(|c| is_active[*c]).collect();
        let mut most = vec![vec![0.0; problem.channels]; groups + 1];
        for group in (0..groups).rev() {
            for channel in &active {
                let largest = allowed[group].iter().map(|s| light[problem.place(group, *s) + channel]).fold(0.0, f64::max);
                most[group][*channel] = most[group + 1][*channel] + largest;
            }
        }
        let sum = |place: usize| light[place..place + problem.sensors].iter().sum::<f64>();
        let daylight: Vec<Vec<f64>> =
            (0..groups).map(|g| (0..problem.states[g]).map(|s| sum(problem.place(g, s as State))).collect()).collect();
        let mut most_daylight = vec![0.0; groups + 1];
        for group in (0..groups).rev() {
            let largest = allowed[group].iter().map(|s| daylight[group][usize::from(*s)]).fold(0.0, f64::max);
            most_daylight[group] = most_daylight[group + 1] + largest;
        }
        Self {
            sums: vec![light[..problem.channels].to_vec(); groups + 1],
            states: vec![0; groups],
            found: None,
            visits: 0,
            ended: false,
            left: f64::NEG_INFINITY,
            problem,
            light,
            allowed,
            active,
            most,
            daylight,
            most_daylight,
        }
    }

    fn run(&mut self, wanted: Wanted) {
        (self.visits, self.ended, self.left) = (0, false, f64::NEG_INFINITY);
        let fixed = self.light[..self.problem.sensors].iter().sum();
        self.descend(0, fixed, wanted);
    }

    /// What a combination gains at most: the first groups are chosen, with this sum over the sensors.
    fn bound(&self, chosen: usize, daylight: f64) -> f64 {
        if self.problem.aim == Aim::Daylight {
            return (daylight + self.most_daylight[chosen]) / self.problem.sensors.max(1) as f64;
        }
        if chosen == self.states.len() {
            return self.problem.gain(&self.sums[chosen]);
        }
        let both: Vec<f64> = (0..self.problem.sensors).map(|c| self.sums[chosen][c] + self.most[chosen][c]).collect();
        self.problem.gain(&both)
    }

    fn descend(&mut self, chosen: usize, daylight: f64, wanted: Wanted) {
        let is_whole = chosen == self.states.len();
        let bound = self.bound(chosen, daylight);
        let (more, whole) = match is_whole {
            true => (None, self.problem.whole(self.light, &self.states)),
            false => (Some(&self.most[chosen][..]), &[][..]),
        };
        let excess = self.problem.excess(&self.sums[chosen], more, whole);
        if wanted == Wanted::Gain && excess > 0.0 {
            return;
        }
        let rank = |gain: f64, excess: f64| if wanted == Wanted::Gain { gain } else { -excess };
        if let Some((_, gain, least)) = &self.found {
            let worse = match wanted {
                Wanted::Gain => bound < gain - ROUNDING * gain.abs(),
                Wanted::LeastExcess => excess > least + ROUNDING * least || (excess == *least && bound < gain - ROUNDING * gain.abs()),
            };
            if worse {
                return;
            }
        }
        self.visits += 1;
        if self.visits > self.problem.most_visits && (self.found.is_some() || wanted == Wanted::Gain) {
            self.ended = true;
            self.left = self.left.max(rank(bound, excess));
            return;
        }
        if is_whole {
            let better = match &self.found {
                None => true,
                Some((_, gain, least)) => match wanted {
                    Wanted::Gain => bound > *gain,
                    Wanted::LeastExcess => excess < *least || (excess == *least && bound > *gain),
                },
            };
            if better {
                self.found = Some((self.states.clone(), bound, excess));
            }
            return;
        }
        let allowed = self.allowed;
        for state in &allowed[chosen] {
            let place = self.problem.place(chosen, *state);
            let (before, after) = self.sums.split_at_mut(chosen + 1);
            for channel in &self.active {
                after[0][*channel] = before[chosen][*channel] + self.light[place + channel];
            }
            self.states[chosen] = *state;
            self.descend(chosen + 1, daylight + self.daylight[chosen][usize::from(*state)], wanted);
        }
    }

    fn result(self) -> Best {
        // The search for the least excess looks at one combination at least.
        let (states, gain, excess) = self.found.unwrap_or_else(|| (self.states.clone(), 0.0, f64::INFINITY));
        let own = if excess > 0.0 { -excess } else { gain };
        let may_be_lost = if self.ended { (self.left - own).max(0.0) } else { 0.0 };
        Best { states, value: self.problem.value(gain), excess, may_be_lost }
    }
}
