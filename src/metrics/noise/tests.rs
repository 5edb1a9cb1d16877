use super::super::en17037::{Level, Openings, Provision};
use super::super::{Counted, Occupancy, Year, lm83};
use super::*;

const SENSORS: usize = 40;
const HOURS: usize = 200;
const REPLICATES: usize = 8;

fn time() -> Occupancy {
    let mut year = Year::common();
    year.steps.truncate(HOURS);
    Occupancy::always(&year)
}

/// A room whose light falls with the sensor and rises over the hours, as it truly is.
fn truth(scale: f64) -> Vec<Vec<f64>> {
    let at = |s: usize, h: usize| scale * 900.0 * (-(s as f64) / 18.0).exp() * (0.2 + h as f64 / HOURS as f64);
    (0..SENSORS).map(|s| (0..HOURS).map(|h| at(s, h)).collect()).collect()
}

/// One result: its illuminances, and the deviations of its replicates, `[replicate][sensor][hour]`. Errors go together
/// over the hours, in part over the sensors: each sensor's, one of all, and each of four parts of the day.
fn result(truth: &[Vec<f64>], noise: f64, random: &mut Random) -> (Vec<Vec<f64>>, Vec<Vec<Vec<f32>>>) {
    let mut replicates: Vec<Vec<Vec<f64>>> = Vec::new();
    for _ in 0..REPLICATES {
        let all = normal(random);
        let parts: Vec<f64> = (0..4).map(|_| normal(random)).collect();
        let sensor = |row: &Vec<f64>| -> Vec<f64> {
            let own = normal(random);
            row.iter().enumerate().map(|(h, v)| v * (1.0 + noise * (all + own + parts[h % 4]))).collect()
        };
        replicates.push(truth.iter().map(sensor).collect());
    }
    let mean = |s: usize, h: usize| replicates.iter().map(|r| r[s][h]).sum::<f64>() / REPLICATES as f64;
    let lux: Vec<Vec<f64>> = (0..SENSORS).map(|s| (0..HOURS).map(|h| mean(s, h)).collect()).collect();
    let deviations =
        replicates.iter().map(|r| r.iter().zip(&lux).map(|(r, m)| r.iter().zip(m).map(|(a, b)| (a - b) as f32).collect()).collect());
    (lux.clone(), deviations.collect())
}

/// Numbers per sensor of a result, of each probe and of each draw: `[change][sensor]`.
fn counted<T>(noise: &Noise, lux: &[Vec<f64>], deviations: &[Vec<Vec<f32>>], of: &dyn Fn(&[f64]) -> T) -> [Vec<Vec<T>>; 2] {
    let rows = |s: usize| deviations.iter().map(|r| r[s].as_slice()).collect::<Vec<_>>();
    let probe = |p: usize| (0..SENSORS).map(|s| of(&noise.probe(p, &lux[s], &rows(s)))).collect();
    let draw = |d: usize| (0..SENSORS).map(|s| of(&noise.draw(d, &lux[s], &rows(s)))).collect();
    [(0..noise.probes()).map(probe).collect(), (0..noise.draws()).map(draw).collect()]
}

#[test]
fn standard_errors_of_sums_are_those_of_the_replicates() {
    let mut random = Random(1);
    let (lux, deviations) = result(&truth(1.0), 0.1, &mut random);
    let noise = Noise::new(REPLICATES, false, student_95(REPLICATES - 1));
    let time = time();
    let [probed, drawn] = counted(&noise, &lux, &deviations, &|row| Counted::Mean.of(row, &time));
    for s in 0..SENSORS {
        let mean = Counted::Mean.of(&lux[s], &time);
        let own = deviations.iter().map(|r| mean + r[s].iter().map(|d| f64::from(*d)).sum::<f64>() / HOURS as f64);
        let wanted = crate::statistics::variance_of_mean(own).sqrt();
        let found = noise.standard_error(mean, probed.iter().map(|p| p[s]));
        assert!((found / wanted - 1.0).abs() < 1e-4, "{found} {wanted}");
        // Student's distribution is wider by √(ν / (ν − 2)).
        let spread = (drawn.iter().map(|d| (d[s] - mean).powi(2)).sum::<f64>() / drawn.len() as f64).sqrt();
        assert!((spread / wanted / (7.0f64 / 5.0).sqrt() - 1.0).abs() < 0.3, "{spread} {wanted}");
    }
    // Standard errors alone: as they are, to either side.
    let alone = Noise::new(0, true, 1.96);
    let errors = [3.0f32; HOURS];
    let moved = alone.probe(0, &lux[0], &[&errors]);
    assert!((lux[0][5] - moved[5] - 3.0).abs() < 1e-9);
    assert_eq!((alone.probes(), Noise::new(1, false, 1.96).probes(), Noise::new(0, false, 1.96).draws()), (2, 0, 0));
}

/// 400 results of rooms whose metrics lie anywhere between their limits: what is called decided is right in 95 % of cases
/// or more, and the probabilities that are told are as large as the shares of results that are wrong.
#[test]
fn classes_change_as_often_as_their_probability_says() {
    const RESULTS: usize = 400;
    let time = time();
    let noise = Noise::new(REPLICATES, false, student_95(REPLICATES - 1));
    let mut random = Random(2);
    let classes = |levels: &dyn Fn(f64) -> Vec<f64>| {
        let reached = [100.0, 300.0, 500.0, 750.0].map(levels);
        Provision::by_illuminance([&reached[0], &reached[1], &reached[2], &reached[3]], Openings::Side).unwrap().level()
    };
    let (mut told, mut wrong, mut decided, mut decided_wrong, mut levels) = (0.0, 0.0, 0.0, 0.0, [0usize; 4]);
    let (mut held, mut all) = (0.0, 0.0);
    for number in 0..RESULTS {
        let truth = truth(0.5 + 9.0 * number as f64 / RESULTS as f64);
        let (lux, deviations) = result(&truth, 0.15, &mut random);
        let autonomy = |rows: &[Vec<f64>], limit: f64| -> Vec<f64> { rows.iter().map(|r| Counted::AtLeast(limit).of(r, &time)).collect() };
        let [probed, drawn] = counted(&noise, &lux, &deviations, &|row| LEVELS.map(|limit| Counted::AtLeast(limit).of(row, &time)));
        let level_of = |d: usize| {
            let place = |limit: f64| LEVELS.iter().position(|l| *l == limit).unwrap();
            classes(&|limit| drawn[d].iter().map(|reached| reached[place(limit)]).collect())
        };
        let decision = Decision::new(classes(&|limit| autonomy(&lux, limit)), (0..noise.draws()).map(level_of));
        let right = classes(&|limit| autonomy(&truth, limit));
        let is_wrong = f64::from(u8::from(right != decision.class));
        levels[Level::High.min(right) as usize] += 1;
        told += decision.probability_of_another;
        wrong += is_wrong;
        if !decision.is_undecided() {
            decided += 1.0;
            decided_wrong += is_wrong;
        }
        // The share of sensors with DA300 of a half, and the interval of its standard error.
        let share = |a: &[f64]| lm83::spatial_share(a).unwrap();
        let value = share(&autonomy(&lux, 300.0));
        let error = noise.standard_error(value, probed.iter().map(|p| share(&p.iter().map(|reached| reached[1]).collect::<Vec<_>>())));
        let distance = (value - share(&autonomy(&truth, 300.0))).abs();
        all += 1.0;
        // One sensor is the least that a share can differ by.
        held += f64::from(u8::from(distance <= student_95(REPLICATES - 1) * error + 1.0 / SENSORS as f64));
    }
    let share = |n: f64, of: f64| 100.0 * n / of;
    eprintln!(
        "probability told {:.1} %, wrong {:.1} %; decided {:.0} %, of them wrong {:.1} %; intervals of shares hold {:.1} %; levels {levels:?}",
        share(told, RESULTS as f64),
        share(wrong, RESULTS as f64),
        share(decided, RESULTS as f64),
        share(decided_wrong, decided),
        share(held, all)
    );
    assert!(levels.iter().all(|n| *n > 10), "all levels occur: {levels:?}");
    assert!(wrong / RESULTS as f64 > 0.03, "noise changes some classes: the count can tell");
    // Three standard deviations of a count.
    let bound = |p: f64, n: f64| 3.0 * (p * (1.0 - p) / n).sqrt();
    let (p, n) = (told / RESULTS as f64, RESULTS as f64);
    assert!((wrong / n - p).abs() < bound(p, n), "told {p}, found {}", wrong / n);
    assert!(decided_wrong / decided <= UNDECIDED, "{decided_wrong} of {decided}");
    assert!(held / all >= 0.95 - bound(0.95, all), "{held} of {all}");
    let found = format!(
        "{:.1} % of classes told to change, {:.1} % did; {:.1} % of decided ones wrong",
        share(told, n),
        share(wrong, n),
        share(decided_wrong, decided)
    );
    crate::testing::measured("metric-classes", &found, &format!("± {:.1} %; {:.0} %", 100.0 * bound(p, n), 100.0 * UNDECIDED));
}

const LEVELS: [f64; 4] = [100.0, 300.0, 500.0, 750.0];
