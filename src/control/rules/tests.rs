use super::*;
use crate::control::Group;
use crate::control::rules::words::{JOINING_WORDS, SIGNAL_WORDS};
use crate::control::rules::{Known, Statistic};
use crate::error::Error;

fn facade() -> Facade {
    let south = Group::new("south", &["open", "blind 45", "closed"]).unwrap();
    Facade::new(vec![south, Group::new("north", &["clear", "dark"]).unwrap()]).unwrap()
}

fn parse_for(group: usize, text: &str) -> std::result::Result<Rule, Error> {
    let (sensors, views) = (["desks".to_string(), "wall".to_string()], ["east".to_string(), "west door".to_string()]);
    Rule::parse(text, group, Known { facade: &facade(), sensors: &sensors, views: &views })
}

fn parse(text: &str) -> Rule {
    parse_for(0, text).unwrap()
}

fn refused(text: &str) -> String {
    parse_for(0, text).unwrap_err().to_string()
}

/// Values of a step by hand.
struct Given<F>(F);

impl<F: Fn(Signal, usize, &[State]) -> f64> Values for Given<F> {
    fn value(&self, signal: Signal, step: usize, states: &[State]) -> f64 {
        (self.0)(signal, step, states)
    }

    fn occupied(&self, step: usize) -> bool {
        step % 24 >= 8 && step % 24 < 18
    }
}

fn day(steps: usize, per_hour: usize) -> Year {
    let mut year = Year::common();
    let length = 1.0 / per_hour as f64;
    year.steps = (0..steps).map(|i| crate::metrics::Step { begins: i as f64 * length % 24.0, ..year.steps[i / per_hour] }).collect();
    year.length = length;
    year
}

/// States of the south group in hourly steps with these irradiances.
fn by_irradiance(rule: &str, per_hour: usize, watts: &[f64]) -> Vec<State> {
    let year = day(watts.len(), per_hour);
    let given = Schedule::first(&facade(), watts.len());
    let values = Given(|signal, step: usize, _: &[State]| {
        assert_eq!(signal, Signal::Irradiance(0));
        watts[step]
    });
    operate(&[parse(rule)], &facade(), &year, &given, &values).unwrap().schedule.of_group(0).to_vec()
}

#[test]
fn the_first_clause_that_is_on_decides() {
    let rule = "closed if irradiance > 400 W/m2; 'blind 45' if irradiance > 200; else open";
    assert_eq!(by_irradiance(rule, 1, &[0.0, 200.0, 201.0, 400.0, 401.0, 100.0]), [0, 0, 1, 1, 2, 0]);
    // Without an else it is the first state.
    assert_eq!(by_irradiance("closed if irradiance >= 400", 1, &[399.0, 400.0, 0.0]), [0, 2, 0]);
    assert_eq!(by_irradiance("open if irradiance < 150; else closed;", 1, &[149.0, 150.0]), [0, 2]);
}

#[test]
fn until_is_a_lower_limit_for_going_back() {
    let rule = "closed if irradiance > 300 until irradiance < 200; else open";
    assert_eq!(by_irradiance(rule, 1, &[250.0, 301.0, 250.0, 200.0, 199.0, 250.0, 301.0]), [0, 2, 2, 2, 0, 0, 2]);
    // The clause behind goes on remembering while the first decides.
    let rule = "'blind 45' if irradiance > 500; closed if irradiance > 300 until irradiance < 200";
    assert_eq!(by_irradiance(rule, 1, &[600.0, 250.0, 100.0, 250.0]), [1, 2, 0, 0]);
}

#[test]
fn minutes_count_whole_steps() {
    let sunny = [0.0, 300.0, 300.0, 300.0, 0.0, 300.0, 0.0];
    // Of hours: 30 minutes are one, 90 are two.
    assert_eq!(by_irradiance("closed if irradiance > 250 for 30 min", 1, &sunny), [0, 2, 2, 2, 0, 2, 0]);
    assert_eq!(by_irradiance("closed if irradiance > 250 for 90 min", 1, &sunny), [0, 0, 2, 2, 0, 0, 0]);
    assert_eq!(by_irradiance("closed if irradiance > 250 for 2 h", 1, &sunny), [0, 0, 2, 2, 0, 0, 0]);
    assert_eq!(by_irradiance("closed if irradiance > 250 for 30 min", 4, &sunny), [0, 0, 2, 2, 0, 0, 0]);
    assert_eq!(by_irradiance("closed if irradiance > 250 for 45 min", 4, &sunny), [0, 0, 0, 2, 0, 0, 0]);
    // A state that was taken stays.
    assert_eq!(by_irradiance("closed if irradiance > 250; keep 2 h", 1, &[300.0, 0.0, 0.0, 300.0, 300.0, 0.0, 0.0]), [2, 2, 0, 0, 2, 2, 0]);
    assert_eq!(by_irradiance("closed if irradiance > 250; keep 15 min", 1, &[300.0, 0.0, 300.0]), [2, 0, 2]);
}

#[test]
fn a_gap_in_the_steps_ends_what_is_remembered() {
    let mut year = day(8, 1);
    year.steps.drain(2..5);
    let values = Given(|_: Signal, _: usize, _: &[State]| 300.0);
    let run = |rule: &str| operate(&[parse(rule)], &facade(), &year, &Schedule::first(&facade(), 5), &values).unwrap();
    assert_eq!(run("closed if irradiance > 250 for 2 h").schedule.of_group(0), [0, 2, 0, 2, 2]);
    // From the last hour of the year to the first there is none.
    let mut turn = Year::common();
    turn.steps = [8758, 8759, 0, 1].map(|i| turn.steps[i]).to_vec();
    let found = operate(&[parse("closed if irradiance > 250 for 2 h")], &facade(), &turn, &Schedule::first(&facade(), 4), &values).unwrap();
    assert_eq!(found.schedule.of_group(0), [0, 2, 2, 2]);
}

#[test]
fn times_months_and_occupancy_are_known() {
    let year = Year::common();
    let run = |rule: &str| {
        let values = Given(|_: Signal, _: usize, _: &[State]| f64::NAN);
        operate(&[parse(rule)], &facade(), &year, &Schedule::first(&facade(), 8760), &values).unwrap().schedule.of_group(0).to_vec()
    };
    let hours = |states: &[State]| states.iter().filter(|s| **s == 2).count();
    let between = run("closed if time between 8:00 and 18:00");
    assert_eq!((hours(&between), between[7], between[8], between[17], between[18]), (3650, 0, 2, 2, 0));
    let night = run("closed if time between 18:00 and 8:00");
    assert!(between.iter().zip(&night).all(|(a, b)| a + b == 2));
    assert_eq!(hours(&run("closed if month between 6 and 8")), 92 * 24);
    assert_eq!(hours(&run("closed if month between 12 and 2")), 90 * 24);
    assert_eq!(run("closed if occupied"), between);
    assert_eq!(run("closed if not occupied"), night);
    assert_eq!(hours(&run("closed if (month < 2 or month > 11) and time >= 12 h and not (time > 13)")), 62 * 2);
    // `and` binds more than `or`.
    assert_eq!(hours(&run("closed if month < 2 or month > 11 and time >= 12")), 31 * 24 + 31 * 12);
    // What has no value satisfies no comparison.
    assert_eq!(hours(&run("closed if profile angle < 30 or profile angle >= 30")), 0);
    assert_eq!(hours(&run("closed if not profile angle < 30")), 8760);
}

#[test]
fn signals_indoors_are_of_the_open_group_unless_as_set() {
    // 3000 lx open, 500 lx closed.
    let lux = |_: Signal, _: usize, states: &[State]| if states[0] == 2 { 500.0 } else { 3000.0 };
    let run = |rule: &str| operate(&[parse(rule)], &facade(), &day(12, 1), &Schedule::first(&facade(), 12), &Given(lux)).unwrap();
    let open = run("closed if mean illuminance of desks > 2000 lx");
    assert_eq!((open.schedule.of_group(0), &open.oscillations), (&[2u16; 12][..], &vec![]));
    // As it was set, closed blinds ask to be opened: it oscillates, and that is said.
    let set = run("closed if mean illuminance of desks as set > 2000 lx");
    assert_eq!(set.schedule.of_group(0), [2, 0].repeat(6));
    assert_eq!(set.oscillations, [Oscillation { group: 0, step: 2, moves: 10 }]);
    // With a lower limit for going back it does not.
    let calm = run("closed if mean illuminance of desks as set > 2000 lx until mean illuminance of desks as set < 300 lx");
    assert_eq!((calm.schedule.constant_state(0), calm.oscillations.len()), (Some(2), 0));
}

#[test]
fn a_group_sees_earlier_groups_as_decided_and_later_ones_as_before() {
    // Sun by both windows; either one closed is enough.
    let sun = |_: Signal, _: usize, states: &[State]| {
        [if states[0] == 0 { 600.0 } else { 0.0 }, if states[1] == 0 { 600.0 } else { 0.0 }].iter().sum()
    };
    let rules = [parse("closed if sun on desks > 1000 lx"), parse_for(1, "dark if sun on sensors > 1000 lx; else clear").unwrap()];
    let found = operate(&rules, &facade(), &day(6, 1), &Schedule::first(&facade(), 6), &Given(sun)).unwrap();
    assert_eq!((found.schedule.constant_state(0), found.schedule.constant_state(1)), (Some(2), Some(0)));
    assert_eq!(found.decided[0][0], Decided::Clause(0));
    assert_eq!(found.decided[1][0], Decided::Otherwise);
    // A group without a rule is as it is given.
    let given = Schedule::new(&facade(), 4, vec![vec![0; 4], vec![0, 1, 1, 0]]).unwrap();
    let found = operate(&rules[..1], &facade(), &day(4, 1), &given, &Given(sun)).unwrap();
    assert_eq!(found.schedule.of_group(1), [0, 1, 1, 0]);
    // Later groups count as in the step before.
    assert_eq!(found.schedule.of_group(0), [2, 2, 0, 0]);
    assert_eq!(found.decided[1], [Decided::Given; 4]);
}

#[test]
fn a_rule_tells_which_signals_it_needs() {
    let rule = parse(
        "\"blind 45\" if sun on sensors > 1 klx and irradiance on north > 10; closed if dgp 'west door' > 40 % until dgp of 'west door' < 0.35 \
         or percentile 10 illuminance desks < 100 or occupied; open if sunlit share of wall as set > 2 %; keep 30 min",
    );
    let reading = |signal, as_set| Reading { signal, as_set };
    let mut wanted = [
        reading(Signal::Sun(None), false),
        reading(Signal::Irradiance(1), false),
        reading(Signal::Dgp(1), false),
        reading(Signal::Sensors(Statistic::Percentile(10), Some(0)), false),
        reading(Signal::SunlitShare(Some(1)), true),
    ];
    wanted.sort();
    assert_eq!(rule.readings(), wanted);
    assert!(rule.asks_for_occupancy() && rule.keep_minutes == 30.0);
    assert_eq!(rule.clauses[0].text, "\"blind 45\" if sun on sensors > 1 klx and irradiance on north > 10");
    assert!(rule.clauses[0].condition.holds(&mut |r| if r.signal == Signal::Sun(None) { 1001.0 } else { 11.0 }, false));
    assert!(!rule.clauses[0].condition.holds(&mut |_| 999.0, false));
}

#[test]
fn what_cannot_be_read_is_answered_with_its_column() {
    for (text, column, wanted) in [
        ("closd if time > 8", 1, "did you mean 'closed'?"),
        ("closed when time > 8", 8, "'when' stands where 'if' should"),
        ("closed if irradianc > 250", 11, "did you mean 'irradiance'?"),
        ("closed if irradiance > 250 lx", 28, "'lx' is not the unit of this signal, which is in W/m2"),
        ("closed if dgp of east > 40", 25, "40 is never reached: this signal is between 0 and 1"),
        ("closed if dgp of eest > 0.4", 18, "did you mean 'east'?"),
        ("closed if sun on dsks > 1000", 18, "did you mean 'desks'?"),
        ("closed if irradiance on suth > 9", 25, "did you mean 'south'?"),
        ("closed if irradiance 250", 22, "the number 250 stands where one of >, >=, <, <=, between should"),
        ("closed if irradiance > much", 24, "'much' stands where a number should"),
        ("closed if illuminance of desks > 5", 11, "write mean, least, most or percentile N"),
        ("closed if irradiance > 250; open if", 36, "the end stands where a signal should"),
        ("closed if (time > 8", 20, "the end stands where ')' should"),
        ("closed if time > 8 or", 22, "the end stands where a signal should"),
        ("else open; closed if time > 8", 12, "never reached"),
        ("closed if time > 8; open if time > 8", 21, "never reached"),
        ("else open; else closed", 12, "an 'else' already"),
        ("closed if irradiance > 300 and irradiance < 100", 1, "can never hold"),
        ("closed if time > 24", 1, "can never hold"),
        ("closed if irradiance > 150 until irradiance < 250", 1, "contradicts itself"),
        ("closed if irradiance between 300 and 200", 30, "nothing lies between 300 and 200"),
        ("closed if irradiance > 300 for 20", 34, "'min' or 'h'"),
        ("closed if irradiance > 300 for -5 min", 32, "choose more than 0"),
        ("closed if irradiance > 3.0.0", 24, "no number"),
        ("closed if time > 8:75", 18, "no number"),
        ("'closed if time > 8", 1, "not closed"),
        ("closed if time > 8 & month > 2", 20, "has no meaning"),
        ("closed if percentile 0 illuminance of desks > 2", 22, "from 1 to 99"),
        ("closed if month > 2 closed if month > 5", 21, "stands where ';' or the end should"),
    ] {
        let error = refused(text);
        assert!(error.contains(&format!("column {column} of the rule")) && error.contains(wanted), "{text}: {error}");
    }
    assert!(refused("").contains("column 1"), "{}", refused(""));
    assert!(refused("else open").contains("no clause with a condition"));
    assert!(refused(&format!("closed if {}time > 8", "(".repeat(5000))).contains("parentheses within"));
    assert!(refused(&format!("closed if {}time > 8", "not ".repeat(2000))).contains("parentheses within"));
    assert!(refused(&"closed ".repeat(5000)).contains("at most 10000"));
}

/// Any order of words is a rule or an error, never a panic.
#[test]
fn no_text_panics() {
    let others = [
        "closed",
        "open",
        "'blind 45'",
        ">",
        "<=",
        "(",
        ")",
        ";",
        "250",
        "-1",
        "8:30",
        "min",
        "lx",
        "%",
        "desks",
        "sensors",
        "east",
        "angle",
        "'",
        "ß",
        "1e999",
        ".",
        "share",
        "°",
    ];
    let words = [&JOINING_WORDS[..], &SIGNAL_WORDS, &others].concat();
    let rule =
        "closed if sun on desks > 250 lx and not ( dgp of east < 0.4 or time between 8:30 and 18 ) for 20 min until month > 5 ; else open";
    let mut seed = 1u64;
    let mut next = |most: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % most
    };
    let mut good = 0;
    for _ in 0..20_000 {
        let mut text: Vec<&str> = rule.split(' ').collect();
        for _ in 0..next(4) {
            let (at, word) = (next(text.len()), words[next(words.len())]);
            match next(3) {
                0 => text[at] = word,
                1 => text.insert(at, word),
                _ => drop(text.remove(at)),
            }
        }
        good += usize::from(parse_for(0, &text.join(if next(9) == 0 { "" } else { " " })).is_ok());
    }
    assert!((2000..19_000).contains(&good), "{good} good rules of 20000");
}
