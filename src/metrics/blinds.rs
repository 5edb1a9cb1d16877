//! LM-83's blinds: which groups of windows are closed in which hour.

use super::lm83::{MAY_BE_IN_SUN, SUN_LX};
use super::occupancy::Occupancy;
use crate::matrix::Matrix;

/// One group of windows whose blinds move together: the direct sun that it lets onto the sensors, lx `[sensor][step]`.
#[derive(Debug, Clone, Copy)]
pub struct Group<'a> {
    /// With its blinds open.
    pub open: &'a Matrix<f32>,
    /// Closed.
    pub closed: &'a Matrix<f32>,
}

/// What the groups do over the year.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Operation {
    /// Whether a group is closed, `[group][step]`; open in steps that do not count.
    pub closed: Vec<Vec<bool>>,
    /// Steps in which too many sensors are in the sun even with all groups closed, rising.
    pub remaining: Vec<usize>,
}

/// Moves the blinds by IES LM-83-12: in every step that counts no more than 2 % of the sensors shall have more than 1000 lx
/// of direct sun. While more have, the group closes that leaves the fewest of them in it, among equals the one that takes
/// most sun away, then the first; a group that turns out not to be needed opens again. `fixed` is the sun of windows
/// without blinds. Each step is decided for itself.
///
/// # Panics
/// If the shapes differ, or a step of `time` is none of theirs.
pub fn operate(groups: &[Group<'_>], fixed: Option<&Matrix<f32>>, time: &Occupancy) -> Operation {
    let shape = |m: &Matrix<f32>| (m.rows(), m.cols());
    let Some((sensors, steps)) = groups.first().map(|g| shape(g.open)).or(fixed.map(shape)) else {
        return Operation { closed: Vec::new(), remaining: Vec::new() };
    };
    let all = groups.iter().flat_map(|g| [g.open, g.closed]).chain(fixed);
    all.for_each(|m| assert_eq!(shape(m), (sensors, steps), "sun at the same sensors and steps"));
    let mut operation = Operation { closed: vec![vec![false; steps]; groups.len()], remaining: Vec::new() };
    for &step in &time.steps {
        let light = |m: &Matrix<f32>, s: usize| f64::from(m.at(s, step)[0]);
        // Sensors in the sun, and all of it, with these groups closed.
        let sun = |closed: &[bool]| {
            let of = |s: usize| {
                let moving = groups.iter().zip(closed).map(|(g, closed)| light(if *closed { g.closed } else { g.open }, s)).sum::<f64>();
                moving + fixed.map_or(0.0, |m| light(m, s))
            };
            let (mut count, mut sum) = (0usize, 0.0);
            for s in 0..sensors {
                let lux = of(s);
                count += usize::from(lux > SUN_LX);
                sum += lux;
            }
            (count, sum)
        };
        let fits = |count: usize| count as f64 <= MAY_BE_IN_SUN * sensors as f64;
        let mut closed = vec![false; groups.len()];
        while !fits(sun(&closed).0) && closed.contains(&false) {
            let with = |g: usize| {
                let mut next = closed.clone();
                next[g] = true;
                sun(&next)
            };
            let better = |a: &(usize, (usize, f64)), b: &(usize, (usize, f64))| a.1.0.cmp(&b.1.0).then(a.1.1.total_cmp(&b.1.1));
            let open = (0..groups.len()).filter(|g| !closed[*g]).map(|g| (g, with(g)));
            if let Some((group, _)) = open.min_by(better) {
                closed[group] = true;
            }
        }
        if fits(sun(&closed).0) {
            for group in 0..groups.len() {
                let mut without = closed.clone();
                without[group] = false;
                if closed[group] && fits(sun(&without).0) {
                    closed = without;
                }
            }
        } else {
            operation.remaining.push(step);
        }
        closed.iter().enumerate().for_each(|(group, is)| operation.closed[group][step] = *is);
    }
    operation
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(steps: &[usize]) -> Occupancy {
        Occupancy { name: String::new(), steps: steps.to_vec(), hours: steps.len() as f64 }
    }

    /// `[sensor][step]` of 100 sensors: so many of the first of them from `first` on have `lux`, by step.
    fn sun(steps: &[(usize, usize, f32)]) -> Matrix<f32> {
        let mut m = Matrix::zeros(100, steps.len(), 1);
        for (step, (first, count, lux)) in steps.iter().enumerate() {
            (*first..first + count).for_each(|s| m.at_mut(s, step)[0] = *lux);
        }
        m
    }

    #[test]
    fn blinds_close_when_more_than_2_percent_are_in_the_sun() {
        // 2 of 100 may be; 1000 lx are not more than 1000 lx.
        let open = sun(&[(0, 2, 5000.0), (0, 3, 5000.0), (0, 100, 1000.0), (0, 100, 1000.1), (0, 3, 5000.0)]);
        let closed = Matrix::zeros(100, 5, 1);
        let found = operate(&[Group { open: &open, closed: &closed }], None, &time(&[0, 1, 2, 3]));
        assert_eq!(found.closed, [[false, true, false, true, false]], "the last step does not count");
        assert!(found.remaining.is_empty());
        // Blinds that let too much through leave the hour on the list, and stay closed.
        let leaky = open.map(|v| 0.3 * v);
        let found = operate(&[Group { open: &open, closed: &leaky }], None, &time(&[1, 3]));
        assert_eq!((found.closed[0].clone(), found.remaining), (vec![false, true, false, true, false], vec![1]));
    }

    #[test]
    fn the_group_that_shades_most_closes_first_and_no_other_without_need() {
        let none = Matrix::zeros(100, 4, 1);
        // East lights sensors 0…9, south 10…14, west 20…21.
        let east = sun(&[(0, 10, 4000.0), (0, 10, 4000.0), (0, 0, 0.0), (0, 3, 700.0)]);
        let south = sun(&[(10, 1, 4000.0), (10, 5, 4000.0), (10, 2, 4000.0), (0, 3, 600.0)]);
        let west = sun(&[(20, 1, 4000.0), (20, 1, 4000.0), (20, 2, 4000.0), (0, 0, 0.0)]);
        let groups = [&west, &south, &east].map(|open| Group { open, closed: &none });
        let found = operate(&groups, None, &time(&[0, 1, 2, 3]));
        let at = |step: usize| [0, 1, 2].map(|g| found.closed[g][step]);
        assert_eq!(at(0), [false, false, true], "east alone: two sensors are left");
        assert_eq!(at(1), [false, true, true]);
        assert_eq!(at(2).iter().filter(|c| **c).count(), 1, "one of two equals");
        assert!(at(2)[0], "the first of them");
        assert_eq!(at(3), [false, false, true], "1300 lx of two groups: the one with more of it");
        assert!(found.remaining.is_empty());
        // A skylight without blinds counts too.
        let sky = sun(&[(50, 3, 2000.0), (50, 2, 2000.0), (0, 0, 0.0), (0, 0, 0.0)]);
        let found = operate(&groups, Some(&sky), &time(&[0, 1, 2, 3]));
        assert_eq!(found.remaining, [0]);
        assert_eq!([0, 1, 2].map(|g| found.closed[g][1]), [true, true, true]);
        assert_eq!(operate(&[], Some(&sky), &time(&[0, 1])).remaining, [0]);
    }

    #[test]
    fn a_group_that_others_make_needless_opens_again() {
        // A lights sensors 0 to 5 (six of them), B 0 to 2 and 10 to 12, C 3 to 5 and 13 to 15, all with 600 lx: where
        // two meet it is too much. A leaves least and closes first, but B and C do not meet: it is enough.
        let none = Matrix::zeros(100, 1, 1);
        let of = |ranges: &[std::ops::Range<usize>]| {
            let mut m = Matrix::zeros(100, 1, 1);
            ranges.iter().flat_map(Clone::clone).for_each(|s| m.at_mut(s, 0)[0] = 600.0);
            m
        };
        let (a, b, c) = (of(&[0..3, 3..6]), of(&[0..3, 10..13]), of(&[3..6, 13..16]));
        let groups = [&b, &a, &c].map(|open| Group { open, closed: &none });
        let found = operate(&groups, None, &time(&[0]));
        assert_eq!([0, 1, 2].map(|g| found.closed[g][0]), [false, true, false]);
    }
}
