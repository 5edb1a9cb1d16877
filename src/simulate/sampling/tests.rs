use super::*;
use crate::error::Error;
use crate::kernels::trace::{TraceStatistics, TracedBatch};
use crate::matrix::Matrix;
use crate::progress::{Silent, cancelled};
use std::sync::atomic::{AtomicU32, Ordering};

/// A round of eight batches around `truth`, with noise that is the same for the same round.
fn traced(truth: f32, noise: f32, source: u32, round: u32, rays: u64) -> TracedMatrix {
    let one = |v: f32| Matrix::from_data(1, 1, 3, vec![v; 3]).unwrap();
    let batches = (0..8)
        .map(|batch| {
            let random = crate::kernels::trace::stream_seed(source, round * 8 + batch, 0x7465_7374) as f32 / u32::MAX as f32;
            TracedBatch { total: one(truth + noise * (random - 0.5)), direct: one(0.0), sunlit: None }
        })
        .collect();
    let statistics = TraceStatistics { paths: rays, segments: rays };
    TracedMatrix { total: one(truth), direct: one(0.0), standard_error: one(0.0), batches, statistics }
}

/// Two matrices whose sum is asked for: the first is noisy, the second cheap. `left` rounds may be
/// traced before the user stops.
fn sources<'a>(left: &'a AtomicU32) -> Vec<Source<'a>> {
    [("V", 4.0, 1000), ("D_south", 1.0, 100)]
        .into_iter()
        .enumerate()
        .map(|(i, (name, noise, rays))| Source {
            name: name.into(),
            inputs: Fingerprint::new(name),
            shape: (1, 1),
            keep_direct: false,
            has_sunlit: false,
            trace: Box::new(move |round, _| {
                if left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| n.checked_sub(1)).is_err() {
                    return Err(cancelled());
                }
                Ok(traced(10.0, noise, i as u32, round, rays))
            }),
            exact: None,
        })
        .collect()
}

fn judge(estimates: &[Estimate]) -> Result<Judgement> {
    let of = |e: &Estimate| e.spread.variance(0).unwrap_or_else(|| f64::from(e.standard_error().data()[0]).powi(2));
    let variances: Vec<f64> = estimates.iter().map(of).collect();
    let value: f64 = estimates.iter().map(|e| f64::from(e.total().data()[0])).sum();
    let error = variances.iter().sum::<f64>().sqrt() / value;
    Ok(Judgement { error, at_most: error, variances })
}

fn squares(estimates: &[Estimate], source: usize) -> Vec<f64> {
    let n = estimates[source].replicates.len() as f64;
    vec![f64::from(estimates[source].standard_error().data()[0]).powi(2) * n * (n - 1.0)]
}

/// With this judgement.
fn by(judge: &dyn Fn(&[Estimate]) -> Result<Judgement>) -> Judge<'_> {
    Judge { judge, squares: &squares }
}

fn adaptive(target: f64) -> Stop {
    Stop::Adaptive { target: Some(target), time: None, rounds: None }
}

fn store() -> (tempfile::TempDir, Store) {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    (folder, store)
}

/// A run that is stopped after `rounds` rounds, if it takes so many.
fn run(store: &Store, stop: Stop, rounds: u32) -> Result<(Vec<Estimate>, Vec<bool>)> {
    sample(&sources(&AtomicU32::new(rounds)), stop, store, &Silent, &by(&judge))
}

#[test]
fn sampling_goes_on_where_it_helps_most_until_the_target_is_met() {
    let (_folder, store) = store();
    let (estimates, traced) = run(&store, adaptive(0.002), u32::MAX).unwrap();
    assert!(judge(&estimates).unwrap().error <= 0.002 && traced == [true, true]);
    // At the best ratio of rounds n ∝ noise / √rays both gain the same per ray: 4/√1000 to 1/√100.
    let ratio = f64::from(estimates[0].rounds) / f64::from(estimates[1].rounds);
    assert!(estimates[1].rounds > 5 && (0.6..2.6).contains(&ratio), "{} {}", estimates[0].rounds, estimates[1].rounds);
    // The truth lies where the error says.
    let sum: f64 = estimates.iter().map(|e| f64::from(e.total().data()[0])).sum();
    assert!((sum / 20.0 - 1.0).abs() < 3.0 * 0.002, "{sum}");
}

#[test]
fn a_stop_anywhere_leads_to_the_same_bits() {
    let (_folder, kept) = store();
    let whole = run(&kept, adaptive(0.004), u32::MAX).unwrap().0;
    let total: u32 = whole.iter().map(|e| e.rounds).sum();
    assert!(total > 6, "{total}");
    for after in 0..total {
        let (_folder, store) = store();
        let error = run(&store, adaptive(0.004), after).unwrap_err().to_string();
        assert!(error.contains("stopped"), "{error}");
        let (resumed, _) = run(&store, adaptive(0.004), total - after).unwrap();
        assert_eq!(resumed, whole, "stopped after {after}");
    }
    // Nothing is left to do.
    let (again, traced) = run(&kept, adaptive(0.004), 0).unwrap();
    assert_eq!((again, traced), (whole.clone(), vec![false, false]));
    // A file that does not belong to the others' rounds makes all of it start anew.
    std::fs::remove_file(kept.matrix_path("replicates_V")).unwrap();
    assert_eq!(run(&kept, adaptive(0.004), u32::MAX).unwrap().0, whole);
}

#[test]
fn a_tighter_target_goes_on_and_a_looser_one_does_not_profit() {
    let fresh = |target: f64| run(&store().1, adaptive(target), u32::MAX).unwrap().0;
    let rounds = |e: &[Estimate]| e.iter().map(|e| e.rounds).sum::<u32>();
    let (_folder, store) = store();
    let loose = run(&store, adaptive(0.01), u32::MAX).unwrap().0;
    let tight = fresh(0.003);
    let more = rounds(&tight) - rounds(&loose);
    assert!(more > 0);
    assert_eq!(run(&store, adaptive(0.003), more).unwrap().0, tight);
    assert_eq!(run(&store, adaptive(0.01), u32::MAX).unwrap().0, loose);
}

#[test]
fn rounds_of_a_time_limit_can_be_repeated() {
    let (_folder, a) = store();
    let time = Stop::Adaptive { target: None, time: Some(Duration::from_millis(3)), rounds: None };
    let timed = run(&a, time, u32::MAX).unwrap().0;
    let rounds = timed.iter().map(|e| e.rounds).sum();
    let (_folder, b) = store();
    assert_eq!(run(&b, Stop::Adaptive { target: None, time: None, rounds: Some(rounds) }, u32::MAX).unwrap().0, timed);
    // The time is spent: running again changes nothing.
    assert_eq!(run(&a, time, 0).unwrap().0, timed);
}

#[test]
fn fixed_rounds_go_on_too_and_exact_matrices_are_left_alone() {
    let (_folder, store_a) = store();
    let whole = run(&store_a, Stop::Rounds(4), u32::MAX).unwrap().0;
    assert_eq!(whole.iter().map(|e| e.rounds).collect::<Vec<_>>(), [4, 4]);
    let (_folder, store_b) = store();
    assert!(run(&store_b, Stop::Rounds(4), 6).is_err());
    assert_eq!(run(&store_b, Stop::Rounds(4), 2).unwrap().0, whole);
    let (_folder, store_c) = store();
    let left = AtomicU32::new(u32::MAX);
    let mut all = sources(&left);
    let one = Matrix::from_data(1, 1, 3, vec![10.0f32; 3]).unwrap();
    all[1].exact = Some(Estimate::exact(one.clone(), one));
    let (estimates, traced) = sample(&all, adaptive(0.005), &store_c, &Silent, &by(&judge)).unwrap();
    assert!(estimates[0].rounds > 1 && estimates[1].rounds == 0 && traced == [true, false]);
}

#[test]
fn what_cannot_be_improved_ends() {
    // An error that no source contributes to.
    let (_folder, store) = store();
    let stuck = |estimates: &[Estimate]| Ok(Judgement { error: 1.0, at_most: 1.0, variances: vec![0.0; estimates.len()] });
    let (estimates, _) = sample(&sources(&AtomicU32::new(u32::MAX)), adaptive(0.01), &store, &Silent, &by(&stuck)).unwrap();
    assert!(estimates.iter().all(|e| e.rounds == 1));
    let failing = |_: &[Estimate]| -> Result<Judgement> { Err(Error::new("no device")) };
    assert!(sample(&sources(&AtomicU32::new(u32::MAX)), adaptive(0.02), &store, &Silent, &by(&failing)).is_err());
}

#[test]
fn progress_tells_the_error_as_it_falls() {
    struct Told(std::sync::Mutex<Vec<String>>);
    impl Progress for Told {
        fn update(&self, stage: &str, _: f64) {
            self.0.lock().unwrap().push(stage.to_string());
        }
    }
    let told = Told(std::sync::Mutex::default());
    let (_folder, store) = store();
    let left = AtomicU32::new(u32::MAX);
    let mut all = sources(&left);
    for source in &mut all {
        let trace = std::mem::replace(&mut source.trace, Box::new(|_, _| Err(cancelled())));
        source.trace = Box::new(move |round, progress| {
            progress.update("a matrix", 0.5);
            trace(round, progress)
        });
    }
    sample(&all, adaptive(0.003), &store, &told, &by(&judge)).unwrap();
    let told = told.0.into_inner().unwrap();
    let errors: Vec<f64> = told.iter().filter_map(|t| t.strip_prefix("standard error ")?.split(' ').next()?.parse().ok()).collect();
    assert!(errors.len() > 3 && errors.first() > errors.last(), "{told:?}");
    assert!(told.last().unwrap().ends_with("target 0.30 %: a matrix"), "{told:?}");
}

#[test]
fn lengths_of_time_are_read() {
    for (text, seconds) in [("5 min", 300.0), ("90s", 90.0), ("0.5 h", 1800.0), (" 2 minutes ", 120.0)] {
        assert_eq!(crate::simulate::project::quality::parse_time(text).unwrap(), Duration::from_secs_f64(seconds));
    }
    for text in ["", "5", "min", "-5 min", "0 s", "1e300 h", "nan s", "5 min 3", "five min"] {
        assert!(crate::simulate::project::quality::parse_time(text).is_err(), "{text}");
    }
}
