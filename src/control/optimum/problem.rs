//! What is sought.

use crate::control::State;

/// What shall not be exceeded in a step.
#[derive(Debug, Clone, PartialEq)]
pub enum Limit {
    /// The sum of one channel: vertical illuminance at an eye, light at a painting.
    Most {
        /// Number of the channel.
        channel: usize,
        /// The limit, above 0, in the channel's unit.
        limit: f64,
    },
    /// Daylight glare probability by Wienold and Christoffersen 2006, of two additive channels:
    /// `a Ev + b log10(1 + C / Ev^1.87) + c`.
    Dgp {
        /// Vertical illuminance at the eye, Ev, lx.
        illuminance: usize,
        /// Contrast of all sources, C = Σ L² ω / P².
        contrast: usize,
        /// a, b, c.
        constants: [f64; 3],
        /// The limit.
        limit: f64,
    },
    /// The share of sensors (the first channels) with more than so much light.
    Share {
        /// Channels that count.
        channels: std::ops::Range<usize>,
        /// More than this, in their unit.
        above: f64,
        /// No more than this share of them.
        share: f64,
    },
    /// One of the values of a combination as a whole, which is no sum over the groups: the DGP of a view.
    Whole {
        /// Its number.
        number: usize,
        /// The limit, above 0.
        limit: f64,
    },
}

/// What is best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// Most daylight: the highest mean illuminance of the sensors.
    Daylight,
    /// Least power for lights that are dimmed to fill up to `target` lx: a share of the installed power. Each sensor's
    /// light is dimmed for itself, from all of its power without daylight down to `least` of it where daylight is enough.
    Lighting {
        /// lx.
        target: f64,
        /// Share of the power that is left when dimmed down.
        least: f64,
    },
}

/// A façade's states with what is sought.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Number of states of each group.
    pub states: Vec<usize>,
    /// The first channels are sensors, lx.
    pub sensors: usize,
    /// All channels.
    pub channels: usize,
    /// Values that each combination has as a whole.
    pub wholes: usize,
    /// Limits.
    pub limits: Vec<Limit>,
    /// Aim.
    pub aim: Aim,
    /// Partial combinations of a step after which the search ends: beyond 10⁶ combinations it may.
    pub most_visits: u64,
}

/// Light of a step.
pub trait Lights: Sync {
    /// Fills in the light of a step: first `[channel]` of what never changes, then `[group][state][channel]`, then what
    /// combinations have as wholes, `[combination][number]`, the state of the last group changing fastest. None is negative.
    fn fill(&self, step: usize, values: &mut [f64]);
}

impl Problem {
    /// Visits of which every search of 10⁶ combinations is exact.
    pub const EXACT: u64 = 2_500_000;

    /// Number of values of a step.
    pub fn values(&self) -> usize {
        let combinations = if self.wholes > 0 { self.states.iter().product() } else { 0 };
        self.sums() + self.wholes * combinations
    }

    /// Those that are summed over the groups.
    fn sums(&self) -> usize {
        self.channels * (1 + self.states.iter().sum::<usize>())
    }

    /// What a combination has as a whole.
    pub(super) fn whole<'v>(&self, values: &'v [f64], states: &[State]) -> &'v [f64] {
        let number = self.states.iter().zip(states).fold(0, |number, (count, state)| number * count + usize::from(*state));
        if self.wholes > 0 { &values[self.sums() + self.wholes * number..][..self.wholes] } else { &[] }
    }

    /// Where the channels of a group's state begin.
    pub(super) fn place(&self, group: usize, state: State) -> usize {
        self.channels * (1 + self.states[..group].iter().sum::<usize>() + usize::from(state))
    }

    /// What the light of a combination comes to: larger is better.
    pub(super) fn gain(&self, light: &[f64]) -> f64 {
        let sensors = &light[..self.sensors];
        let mean = |f: &dyn Fn(f64) -> f64| sensors.iter().map(|e| f(*e)).sum::<f64>() / sensors.len().max(1) as f64;
        match self.aim {
            Aim::Daylight => mean(&|e| e),
            Aim::Lighting { target, least } => -mean(&|e| least + (1.0 - least) * (1.0 - e / target).max(0.0)),
        }
    }

    /// The aim's value of a gain.
    pub(super) fn value(&self, gain: f64) -> f64 {
        match self.aim {
            Aim::Daylight => gain,
            Aim::Lighting { .. } => -gain,
        }
    }

    /// By how much light exceeds the limits, relative; 0 if it does not. With `more` light that may be added still: at
    /// least so much. `whole`: what the combination has as a whole, nothing of a part of one.
    pub(super) fn excess(&self, light: &[f64], more: Option<&[f64]>, whole: &[f64]) -> f64 {
        self.limits.iter().map(|limit| limit.excess(light, more, whole)).fold(0.0, f64::max)
    }
}

impl Limit {
    fn excess(&self, light: &[f64], more: Option<&[f64]>, whole: &[f64]) -> f64 {
        let over = |value: f64, limit: f64| if value > limit { value / limit - 1.0 } else { 0.0 };
        match self {
            Self::Most { channel, limit } => over(light[*channel], *limit),
            Self::Dgp { illuminance, contrast, constants: [a, b, c], limit } => {
                let ev = light[*illuminance];
                // Contrast weighs less in brighter light.
                let around = ev + more.map_or(0.0, |m| m[*illuminance]);
                let contrast = if around > 0.0 { b * (1.0 + light[*contrast] / around.powf(1.87)).log10() } else { 0.0 };
                over((a * ev + contrast + c).min(1.0), *limit)
            }
            Self::Whole { number, limit } => whole.get(*number).map_or(0.0, |value| over(*value, *limit)),
            Self::Share { channels, above, share } => {
                let count = light[channels.clone()].iter().filter(|e| **e > *above).count();
                let part = count as f64 / channels.len().max(1) as f64;
                // A share of 0 has no relative excess.
                if part > *share { (part - share) / share.max(0.01) } else { 0.0 }
            }
        }
    }
}
