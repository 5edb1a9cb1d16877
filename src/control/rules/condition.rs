//! Conditions of rules.

use super::signal::{Reading, Signal};

/// How a signal is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Above a value.
    Above(f64),
    /// At or above it.
    AtLeast(f64),
    /// Below it.
    Below(f64),
    /// At or below it.
    AtMost(f64),
    /// From one value to before another; months including the other. From a larger one to a smaller: over midnight, New
    /// Year or north.
    Between(f64, f64),
}

/// A condition of a rule.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition {
    /// A signal compared with a number.
    Compare(Reading, Limit),
    /// The step is occupied.
    Occupied,
    /// The contrary.
    Not(Box<Condition>),
    /// All of them.
    All(Vec<Condition>),
    /// One of them.
    Any(Vec<Condition>),
}

impl Limit {
    /// Whether a value of a signal is so; no number never is.
    pub fn holds(self, signal: Signal, value: f64) -> bool {
        match self {
            Self::Above(limit) => value > limit,
            Self::AtLeast(limit) => value >= limit,
            Self::Below(limit) => value < limit,
            Self::AtMost(limit) => value <= limit,
            Self::Between(from, to) => {
                let before = if signal == Signal::Month { value <= to } else { value < to };
                if from <= to { value >= from && before } else { value >= from || before }
            }
        }
    }

    /// The values that hold: from, whether itself, to, whether itself. Nothing of those that go round.
    fn interval(self, signal: Signal) -> Option<(f64, bool, f64, bool)> {
        let (least, most) = (*signal.range().start(), *signal.range().end());
        match self {
            Self::Above(v) => Some((v, false, most, true)),
            Self::AtLeast(v) => Some((v, true, most, true)),
            Self::Below(v) => Some((least, true, v, false)),
            Self::AtMost(v) => Some((least, true, v, true)),
            Self::Between(from, to) => (from <= to).then_some((from, true, to, signal == Signal::Month)),
        }
    }
}

impl Condition {
    /// Whether it holds, with the value of each reading.
    pub fn holds(&self, value: &mut dyn FnMut(Reading) -> f64, occupied: bool) -> bool {
        match self {
            Self::Compare(reading, limit) => limit.holds(reading.signal, value(*reading)),
            Self::Occupied => occupied,
            Self::Not(inner) => !inner.holds(value, occupied),
            Self::All(parts) => parts.iter().all(|c| c.holds(value, occupied)),
            Self::Any(parts) => parts.iter().any(|c| c.holds(value, occupied)),
        }
    }

    /// All readings in it, in order, some perhaps twice.
    pub fn readings(&self) -> Vec<Reading> {
        match self {
            Self::Compare(reading, _) => vec![*reading],
            Self::Occupied => Vec::new(),
            Self::Not(inner) => inner.readings(),
            Self::All(parts) | Self::Any(parts) => parts.iter().flat_map(Self::readings).collect(),
        }
    }

    /// Whether occupancy is asked for.
    pub fn asks_for_occupancy(&self) -> bool {
        match self {
            Self::Compare(..) => false,
            Self::Occupied => true,
            Self::Not(inner) => inner.asks_for_occupancy(),
            Self::All(parts) | Self::Any(parts) => parts.iter().any(Self::asks_for_occupancy),
        }
    }

    /// Comparisons all of which must hold.
    fn conjuncts(&self) -> Vec<(Reading, Limit)> {
        match self {
            Self::Compare(reading, limit) => vec![(*reading, *limit)],
            Self::All(parts) => parts.iter().flat_map(Self::conjuncts).collect(),
            _ => Vec::new(),
        }
    }

    /// A reading of which no value can satisfy all comparisons that must hold.
    pub(super) fn impossible(&self) -> Option<Reading> {
        if let Self::Any(parts) = self {
            return parts.iter().find_map(Self::impossible);
        }
        if let Self::All(parts) = self
            && let Some(found) = parts.iter().filter(|p| matches!(p, Self::Any(_))).find_map(Self::impossible)
        {
            return Some(found);
        }
        let all = self.conjuncts();
        all.iter().map(|(r, _)| *r).find(|reading| {
            let of = all.iter().filter(|(r, _)| r == reading).filter_map(|(r, limit)| limit.interval(r.signal));
            is_empty(of)
        })
    }

    /// Whether both can hold at once, where both are comparisons of one reading only; nothing is said of others.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        let (Self::Compare(a, first), Self::Compare(b, second)) = (self, other) else { return false };
        let (Some(first), Some(second)) = (first.interval(a.signal), second.interval(b.signal)) else { return false };
        a.signal == b.signal && a.as_set == b.as_set && !is_empty([first, second].into_iter())
    }
}

fn is_empty(intervals: impl Iterator<Item = (f64, bool, f64, bool)>) -> bool {
    let (mut from, mut to) = ((f64::NEG_INFINITY, true), (f64::INFINITY, true));
    for (a, with_a, b, with_b) in intervals {
        if a > from.0 || (a == from.0 && !with_a) {
            from = (a, with_a);
        }
        if b < to.0 || (b == to.0 && !with_b) {
            to = (b, with_b);
        }
    }
    from.0 > to.0 || (from.0 == to.0 && !(from.1 && to.1))
}
