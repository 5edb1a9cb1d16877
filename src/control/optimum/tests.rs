use super::*;
use crate::control::Group;

/// Made-up light `[step][value]`.
struct Given(Vec<Vec<f64>>);

impl Lights for Given {
    fn fill(&self, step: usize, values: &mut [f64]) {
        values.copy_from_slice(&self.0[step]);
    }
}

fn facade(states: &[usize]) -> Facade {
    let group = |(g, n): (usize, &usize)| {
        let names: Vec<String> = (0..*n).map(|s| format!("s{s}")).collect();
        Group::new(format!("g{g}"), &names).unwrap()
    };
    Facade::new(states.iter().enumerate().map(group).collect()).unwrap()
}

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Eight sensors, vertical illuminance and contrast of an eye; a night now and then.
fn problem(states: &[usize], aim: Aim, limit: f64) -> Problem {
    let dgp = Limit::Dgp { illuminance: 8, contrast: 9, constants: [5.87e-5, 0.0918, 0.16], limit };
    Problem {
        states: states.to_vec(),
        sensors: 8,
        channels: 10,
        wholes: 0,
        limits: vec![dgp, Limit::Most { channel: 8, limit: 5000.0 }, Limit::Share { channels: 0..8, above: 3000.0, share: 0.25 }],
        aim,
        most_visits: Problem::EXACT,
    }
}

fn lights(problem: &Problem, steps: usize, seed: u64) -> Given {
    let mut random = Random(seed);
    let step = |i: usize| {
        let bright = if i % 7 == 6 { 0.0 } else { random.next() };
        (0..problem.values())
            .map(|k| match k % 10 {
                9 => bright * 4e6 * random.next().powi(3),
                8 => bright * 3000.0 * random.next(),
                _ => bright * 2000.0 * random.next(),
            })
            .collect()
    };
    Given((0..steps).map(step).collect())
}

fn all_combinations(states: &[usize]) -> Vec<Vec<State>> {
    states.iter().fold(vec![Vec::new()], |all, n| {
        all.iter().flat_map(|c| (0..*n as State).map(move |s| c.iter().copied().chain([s]).collect())).collect()
    })
}

/// Light of a combination, excess by the definitions, and the aim.
fn judged(problem: &Problem, values: &[f64], states: &[State]) -> (f64, f64) {
    let light: Vec<f64> = (0..10)
        .map(|c| {
            let mut place = 10;
            let mut sum = values[c];
            for (state, count) in states.iter().zip(&problem.states) {
                sum += values[place + 10 * usize::from(*state) + c];
                place += 10 * count;
            }
            sum
        })
        .collect();
    let Limit::Dgp { limit, .. } = &problem.limits[0] else { panic!() };
    let dgp = if light[8] > 0.0 { 5.87e-5 * light[8] + 0.0918 * (1.0 + light[9] / light[8].powf(1.87)).log10() + 0.16 } else { 0.16 };
    let share = light[..8].iter().filter(|e| **e > 3000.0).count() as f64 / 8.0;
    let excess = [dgp.min(1.0) / limit - 1.0, light[8] / 5000.0 - 1.0, (share - 0.25) / 0.25].into_iter().fold(0.0, f64::max);
    let gain = match problem.aim {
        Aim::Daylight => light[..8].iter().sum::<f64>() / 8.0,
        Aim::Lighting { target, least } => -light[..8].iter().map(|e| least.max(1.0 - (1.0 - least) * e / target)).sum::<f64>() / 8.0,
    };
    (excess, gain)
}

const AIMS: [Aim; 2] = [Aim::Daylight, Aim::Lighting { target: 3000.0, least: 0.1 }];

#[test]
fn the_optimum_is_that_of_trying_all() {
    let states = [3, 4, 1, 2];
    let (facade, combinations) = (facade(&states), all_combinations(&states));
    let (mut met, mut exceeded) = (0, 0);
    for (aim, limit) in [(AIMS[0], 0.35), (AIMS[1], 0.35), (AIMS[0], 0.25), (AIMS[1], 0.28)] {
        let problem = problem(&states, aim, limit);
        let lights = lights(&problem, 200, 3);
        let found = optimum(&problem, &facade, &lights, 200).unwrap();
        assert!(found.may_be_lost.iter().all(|l| *l == 0.0));
        for step in 0..200 {
            let judge = |c: &Vec<State>| judged(&problem, &lights.0[step], c);
            let (excess, gain) = judge(&found.schedule.of_step(step));
            let least = combinations.iter().map(|c| judge(c).0).fold(f64::INFINITY, f64::min);
            assert!((excess - least).abs() < 1e-9, "step {step}: exceeds by {excess}, {least} can be");
            let most =
                combinations.iter().map(judge).filter(|(e, _)| *e <= least + 1e-12).map(|(_, g)| g).fold(f64::NEG_INFINITY, f64::max);
            assert!((gain - most).abs() < 1e-9 * most.abs().max(1.0), "step {step}: {gain}, {most} can be");
            assert!((problem.value(found.value[step]) - gain).abs() < 1e-9 * gain.abs().max(1.0));
            assert_eq!(found.remaining.contains(&step), least > 0.0);
            let tally = if least > 0.0 { &mut exceeded } else { &mut met };
            *tally += 1;
        }
        let of: Vec<f64> = found.remaining.iter().map(|s| judged(&problem, &lights.0[*s], &found.schedule.of_step(*s)).0).collect();
        assert!(of.iter().zip(&found.excess).all(|(a, b)| (a - b).abs() < 1e-9));
        // In the dark all are equal: the first.
        assert_eq!(found.schedule.of_step(6), [0; 4]);
    }
    assert!(met > 200 && exceeded > 50, "{met} {exceeded}");
}

#[test]
fn values_of_whole_combinations_are_limits_too() {
    let states = [3, 4, 2];
    let (facade, combinations) = (facade(&states), all_combinations(&states));
    let sums = problem(&states, AIMS[0], 0.35);
    let mut limits = sums.limits.clone();
    limits.push(Limit::Whole { number: 1, limit: 0.4 });
    let problem = Problem { wholes: 2, limits, ..sums.clone() };
    // Of each combination a value that does not count and one that does.
    let Given(mut values) = lights(&sums, 100, 5);
    let mut random = Random(8);
    values.iter_mut().for_each(|step| step.extend((0..2 * combinations.len()).map(|_| random.next())));
    let lights = Given(values);
    let judge = |step: usize, number: usize| {
        let (excess, gain) = judged(&sums, &lights.0[step][..sums.values()], &combinations[number]);
        let whole = lights.0[step][sums.values() + 2 * number + 1];
        (excess.max(whole / 0.4 - 1.0).max(0.0), gain)
    };
    let found = optimum(&problem, &facade, &lights, 100).unwrap();
    let steady = fewest_moves(&problem, &facade, &lights, 100).unwrap();
    let mut met = 0;
    for step in 0..100 {
        let number = |of: &Optimum| combinations.iter().position(|c| *c == of.schedule.of_step(step)).unwrap();
        let all: Vec<(f64, f64)> = (0..combinations.len()).map(|n| judge(step, n)).collect();
        let least = all.iter().map(|j| j.0).fold(f64::INFINITY, f64::min);
        let most = all.iter().filter(|j| j.0 <= least + 1e-12).map(|j| j.1).fold(f64::NEG_INFINITY, f64::max);
        let (excess, gain) = all[number(&found)];
        assert!((excess - least).abs() < 1e-9 && (gain - most).abs() < 1e-9 * most.max(1.0), "{step}: {excess} {least}, {gain} {most}");
        assert!((all[number(&steady)].0 - least).abs() < 1e-9, "{step}");
        met += usize::from(least == 0.0);
    }
    assert!(met > 50, "{met}");
}

#[test]
fn a_search_that_ends_early_bounds_what_it_loses() {
    let states = [5, 5, 5, 5];
    let facade = facade(&states);
    let mut lost_any = 0;
    for aim in AIMS {
        let exact = problem(&states, aim, 0.32);
        let lights = lights(&exact, 60, 9);
        let best = optimum(&exact, &facade, &lights, 60).unwrap();
        for most_visits in [1, 12, 100] {
            let early = optimum(&Problem { most_visits, ..exact.clone() }, &facade, &lights, 60).unwrap();
            for step in 0..60 {
                let (a, b) = (
                    judged(&exact, &lights.0[step], &best.schedule.of_step(step)),
                    judged(&exact, &lights.0[step], &early.schedule.of_step(step)),
                );
                if b.0 > 0.0 {
                    // Nothing that meets the limits was found: it stands among the remaining steps.
                    assert!(early.remaining.contains(&step));
                    continue;
                }
                let lost = a.1 - b.1;
                assert!(lost <= early.may_be_lost[step] + 1e-9, "step {step}: lost {lost}, stated {}", early.may_be_lost[step]);
                lost_any += usize::from(lost > 1e-6);
            }
        }
    }
    assert!(lost_any > 20, "{lost_any}");
}

#[test]
fn marginal_values_are_those_of_the_optimum_without() {
    let states = [3, 2];
    let facade = facade(&states);
    for aim in AIMS {
        let problem = problem(&states, aim, 0.33);
        let lights = lights(&problem, 150, 5);
        let with = optimum(&problem, &facade, &lights, 150).unwrap();
        let counts: Vec<bool> = (0..150).map(|s| s % 3 != 0).collect();
        let found = marginal(&problem, &facade, &lights, &with, &counts);
        let cases: Vec<_> = found.iter().map(|m| (m.group, m.state)).collect();
        assert_eq!(cases, [(0, Some(0)), (0, Some(1)), (0, Some(2)), (0, None), (1, Some(0)), (1, Some(1)), (1, None)]);
        for m in &found {
            let left = |c: &Vec<State>| m.state.map_or(c[m.group] == 0, |s| c[m.group] != s);
            let (mut lost, mut more, mut number) = (0.0, 0, 0);
            for step in (0..150).filter(|s| counts[*s]) {
                let best = |with: bool| {
                    let all =
                        all_combinations(&states).into_iter().filter(|c| with || left(c)).map(|c| judged(&problem, &lights.0[step], &c));
                    all.filter(|(e, _)| *e == 0.0).map(|(_, g)| g).fold(None, |a: Option<f64>, g| Some(a.map_or(g, |a| a.max(g))))
                };
                number += 1;
                match (best(true), best(false)) {
                    (Some(a), Some(b)) => lost += a - b,
                    (Some(_), None) => more += 1,
                    _ => {}
                }
            }
            lost /= f64::from(number);
            assert!((m.lost - lost).abs() < 1e-9 * lost.abs().max(1.0) && m.more_remaining == more, "{m:?}: {lost} {more}");
            assert!(m.lost >= 0.0);
        }
        assert!(found.iter().any(|m| m.lost > 0.0) && found.iter().any(|m| m.more_remaining > 0), "{found:?}");
    }
}

#[test]
fn fewest_moves_are_those_of_trying_all_paths() {
    let states = [2, 3];
    let (facade, combinations) = (facade(&states), all_combinations(&states));
    let mut moved = 0;
    for seed in 0..30 {
        let problem = problem(&states, Aim::Daylight, 0.26);
        let steps = 6;
        let lights = lights(&problem, steps, 100 + seed);
        let found = fewest_moves(&problem, &facade, &lights, steps).unwrap();
        // All paths through combinations that may stand.
        let fits: Vec<Vec<(usize, f64)>> = (0..steps)
            .map(|step| {
                let judged: Vec<(f64, f64)> = combinations.iter().map(|c| judged(&problem, &lights.0[step], c)).collect();
                let met: Vec<(usize, f64)> = (0..6).filter(|i| judged[*i].0 == 0.0).map(|i| (i, judged[i].1)).collect();
                let only = optimum(&problem, &facade, &Given(vec![lights.0[step].clone()]), 1).unwrap().schedule.of_step(0);
                let only = combinations.iter().position(|c| *c == only).unwrap();
                if met.is_empty() { vec![(only, judged[only].1)] } else { met }
            })
            .collect();
        let apart = |a: usize, b: usize| combinations[a].iter().zip(&combinations[b]).filter(|(a, b)| a != b).count();
        let mut paths: Vec<(usize, f64, usize)> = fits[0].iter().map(|(i, g)| (0, *g, *i)).collect();
        for step in 1..steps {
            paths =
                paths.iter().flat_map(|(m, gain, at)| fits[step].iter().map(move |(i, g)| (m + apart(*at, *i), gain + g, *i))).collect();
        }
        let fewest = paths.iter().map(|p| p.0).min().unwrap();
        let most = paths.iter().filter(|p| p.0 == fewest).map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        let moves: usize = (0..2).map(|g| found.schedule.moves(g)).sum();
        assert_eq!(moves, fewest, "seed {seed}");
        assert!((found.value.iter().sum::<f64>() - most).abs() < 1e-6, "seed {seed}: {} {most}", found.value.iter().sum::<f64>());
        moved += moves;
        // Over more steps than are kept at once, never more moves than of the best of each step.
        let many = super::tests::lights(&problem, 90, 500 + seed);
        let (path, best) = (fewest_moves(&problem, &facade, &many, 90).unwrap(), optimum(&problem, &facade, &many, 90).unwrap());
        let count = |o: &Optimum| (0..2).map(|g| o.schedule.moves(g)).sum::<usize>();
        assert!(count(&path) < count(&best));
        assert_eq!((&path.remaining, path.excess.len()), (&best.remaining, best.excess.len()));
    }
    assert!(moved > 20, "{moved}");
    let many = super::tests::facade(&[30, 30, 30]);
    let error = fewest_moves(&problem(&[30, 30, 30], Aim::Daylight, 0.3), &many, &Given(Vec::new()), 0).unwrap_err().to_string();
    assert!(error.contains("20000 combinations"), "{error}");
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let states = [4, 3, 3];
    let (facade, problem) = (facade(&states), problem(&states, AIMS[1], 0.3));
    let lights = lights(&problem, 300, 21);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let found = optimum(&problem, &facade, &lights, 300).unwrap();
            let worth = marginal(&problem, &facade, &lights, &found, &[true; 300]);
            (found, worth)
        })
    };
    assert_eq!(run(1), run(4));
}
