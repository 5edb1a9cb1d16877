use super::*;
use crate::error::Warnings;
use crate::gpu::Device;
use crate::kernels::daylight_matrix::{self, DaylightOptions};
use crate::kernels::product::Native;
use crate::kernels::trace::{TraceStatistics, TracedBatch, TracedMatrix};
use crate::kernels::view_matrix::{self, ViewOptions};
use crate::progress::Silent;
use crate::scene::points::Sensor;
use crate::simulate::Inputs;
use crate::simulate::Project;
use crate::simulate::inputs::counting::Counting;
use crate::simulate::light::{Daylight, WindowLight, multiply};
use crate::simulate::project::metrics::{Family, MetricsSection};
use crate::simulate::results::annual::{self, YearJob};
use crate::simulate::results::metrics::Samples;
use crate::simulate::sampling::estimate::Estimate;
use crate::sky::{SkyOptions, sky_matrix};
use crate::statistics::variance_of_mean;
use crate::units::ILLUMINANCE_WEIGHTS;
use std::path::Path;

/// The asymmetric room on one day in March, with its first sensors.
fn room(sensors: usize) -> (Project, Inputs, Matrix<f32>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/asymmetric/project.toml");
    let project = Project::read(&file).unwrap();
    let mut inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    inputs.weather.records = inputs.weather.records[79 * 24..80 * 24].to_vec();
    inputs.sensors[0].sensors.truncate(sensors);
    let sky = sky_matrix(&inputs.weather, &SkyOptions::default(), &Silent).unwrap();
    (project, inputs, sky)
}

fn estimate(batches: &[TracedBatch]) -> Estimate {
    let none = Matrix::zeros(0, 0, 3);
    let mut estimate = Estimate::none();
    let statistics = TraceStatistics::default();
    let (total, direct) = (none.clone(), none.clone());
    estimate.add(Estimate::of_round(TracedMatrix { total, direct, standard_error: none, batches: batches.to_vec(), statistics }, true));
    estimate
}

/// Made-up replicates: values between 0 and 1.
fn made_up(rows: usize, cols: usize, seed: u32) -> Estimate {
    let value = |batch: u32, i: usize, part: u32| crate::kernels::trace::stream_seed(seed + part, batch, i as u32) as f32 / u32::MAX as f32;
    let matrix = |batch: u32, part: u32, scale: f32| {
        Matrix::from_data(rows, cols, 3, (0..rows * cols * 3).map(|i| scale * value(batch, i, part)).collect()).unwrap()
    };
    let batches: Vec<_> = (0..8).map(|b| TracedBatch { total: matrix(b, 0, 1.0), direct: matrix(b, 100, 0.3), sunlit: None }).collect();
    estimate(&batches)
}

/// What the windows send into the room by the means of a chain's matrices.
fn light_of(chain: &Chain<'_>) -> Light {
    let means = |mean: fn(&Estimate) -> Matrix<f32>| chain.daylight.iter().map(mean).collect::<Vec<_>>();
    let (total, direct) = (means(Estimate::total), means(Estimate::direct));
    let skies = Skies { whole: chain.sky.clone(), sun: chain.sun.cloned() };
    let daylight = Daylight { total: &total, direct: &direct };
    let windows = WindowLight::of(chain.inputs, &chain.inputs.transmissions(), daylight);
    Light::new(&windows, &Native, &skies, chain.inputs.differences()).unwrap()
}

/// The mean and the daylight factor.
fn counting(inputs: &Inputs) -> Counting {
    let wanted = MetricsSection { families: vec![Family::DaylightFactor], ..MetricsSection::default() };
    Counting::new(&wanted, &inputs.weather, false).unwrap()
}

fn job<'a>(chain: &'a Chain<'a>, counting: &'a Counting, light: &'a Light, target: Option<f64>) -> YearJob<'a> {
    YearJob { chain, counting, multiplier: &Native, light, suns: None, overcast: None, target }
}

fn illuminance_of(chain: &Chain<'_>, light: &Light) -> Matrix<f32> {
    light.over_the_year(&illuminance(&Native, &chain.view.total(), &light.right).unwrap())
}

#[test]
fn deviations_are_those_of_the_products_replicate_by_replicate() {
    let (_, mut inputs, sky) = room(3);
    let sun = sky.map(|v| 0.5 * v);
    let (view, daylight) = (made_up(3, 41, 1), vec![made_up(41, 146, 7)]);
    // With the sun taken out, as behind a shade, and without.
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/asymmetric/louvre.xml");
    let scattering = crate::bsdf::evaluate::Scattering::new(&crate::bsdf::read(&file, &mut Warnings::new()).unwrap()).unwrap();
    inputs.windows[0].pane = Some(crate::simulate::inputs::windows::SunPane {
        data: crate::kernels::sun_matrix::pane::PaneBsdf::Bsdf(scattering),
        inputs: crate::simulate::Fingerprint::new("louvre"),
    });
    for taken in [None, Some(&sun)] {
        let chain = Chain { inputs: &inputs, view: &view, daylight: &daylight, sees_sky: false, sky: &sky, sun: taken };
        let light = light_of(&chain);
        assert_eq!(light.is_split(), taken.is_some());
        let deviations = Deviations::new(&chain, &light).of(&Native, 0..3).unwrap().unwrap();
        let t = &inputs.windows[0].transmission;
        let mean = |all: &[Matrix<f32>]| {
            let mut sum = Matrix::<f64>::zeros(all[0].rows(), all[0].cols(), 3);
            for m in all {
                sum.data_mut().iter_mut().zip(m.data()).for_each(|(s, v)| *s += f64::from(*v) / all.len() as f64);
            }
            sum
        };
        let product = |v: &Matrix<f64>, d: &Matrix<f64>, s: &Matrix<f32>| multiply(&multiply(v, &multiply(t, d)), s);
        let (v, d, vd, dd) = (mean(&view.replicates), mean(&daylight[0].replicates), mean(&view.direct), mean(&daylight[0].direct));
        let annual = chain.annual();
        for r in 0..8 {
            let f64s = |m: &Matrix<f32>| m.map(f64::from);
            // Far from first order in nothing: linear in each, so two products less two means.
            let whole = [product(&f64s(&view.replicates[r]), &d, &sky), product(&v, &f64s(&daylight[0].replicates[r]), &sky)];
            let direct = taken.map(|sun| {
                [product(&f64s(&view.direct[r]), &dd, sun), product(&vd, &f64s(&daylight[0].direct[r]), sun), product(&vd, &dd, sun)]
            });
            let centre = product(&v, &d, &sky);
            for sensor in 0..3 {
                for hour in 0..24 {
                    let lux = |m: &Matrix<f64>| (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * m.at(sensor, hour)[c]).sum::<f64>();
                    let mut wanted = lux(&whole[0]) + lux(&whole[1]) - 2.0 * lux(&centre);
                    if let Some([a, b, mean]) = &direct {
                        wanted -= lux(a) + lux(b) - 2.0 * lux(mean);
                    }
                    let found = f64::from(deviations.at(r * 3 + sensor, hour)[0]);
                    assert!((found - wanted).abs() <= 1e-5 * lux(&centre), "{r} {sensor} {hour}: {found} {wanted}");
                }
            }
        }
        // The year's errors are those of the sums of the hours.
        for (sensor, annual) in annual.iter().enumerate() {
            let sums = (0..8).map(|r| deviations.row(r * 3 + sensor).iter().map(|v| f64::from(*v)).sum::<f64>());
            let variance = variance_of_mean(sums);
            assert!((annual.variance / variance - 1.0).abs() < 1e-4, "{} {variance}", annual.variance);
            assert_eq!(annual.by_source.len(), 2);
        }
    }
}

#[test]
fn errors_reach_the_metrics_of_the_year() {
    let (_, inputs, sky) = room(3);
    let (view, daylight) = (made_up(3, 41, 3), vec![made_up(41, 146, 9)]);
    let chain = Chain { inputs: &inputs, view: &view, daylight: &daylight, sees_sky: false, sky: &sky, sun: None };
    let counting = counting(&inputs);
    let light = light_of(&chain);
    let lux = illuminance_of(&chain, &light);
    // Three times the mean sky in place of an overcast one.
    let mean_sky = {
        let of = |patch: usize, c: usize| 3.0 * (0..24).map(|h| sky.at(patch, h)[c]).sum::<f32>() / 24.0;
        Matrix::from_data(sky.rows(), 1, 3, (0..sky.rows() * 3).map(|i| of(i / 3, i % 3)).collect()).unwrap()
    };
    let under = Chain { inputs: &inputs, view: &view, daylight: &daylight, sees_sky: false, sky: &mean_sky, sun: None };
    let mean_light = light_of(&under);
    let with_sky = YearJob { overcast: Some((&under, &mean_light)), ..job(&chain, &counting, &light, Some(0.02)) };
    let year = annual::estimate(&with_sky, &lux, &|_| Ok(())).unwrap();
    let annual_sums = chain.annual();
    let samples = Samples { counting: &counting, noise: &year.noise, replicates: year.replicates };
    for (sample, sum) in year.samples.iter().zip(&annual_sums) {
        let (mean, wanted) = (samples.sensor(sample)[0], sum.variance.sqrt() / 24.0);
        assert!((mean.standard_error / wanted - 1.0).abs() < 1e-3, "{} {wanted}", mean.standard_error);
        // The daylight factor is the light of the overcast sky, its error that of the same replicates.
        assert!((sample.values[1] - 1e-4 * 3.0 * mean.value).abs() < 1e-6 * mean.value, "{:?}", sample.values);
        let factor = samples.sensor(sample)[1].standard_error;
        assert!((factor / (3e-4 * wanted) - 1.0).abs() < 1e-3, "{factor} {wanted}");
    }
    let estimated = year.estimated.unwrap();
    assert_eq!(estimated.target_met, Some(estimated.annual_largest <= 0.02));
    assert!((estimated.confidence_95 - 2.3646).abs() < 1e-9);
    // An hour's error is the spread of its replicates.
    let deviations = Deviations::new(&chain, &light).of(&Native, 1..2).unwrap().unwrap();
    let spread = variance_of_mean((0..8).map(|r| f64::from(deviations.at(r, 12)[0]))).sqrt();
    assert!((f64::from(year.standard_error.at(1, 12)[0]) / spread - 1.0).abs() < 1e-4);
    assert_eq!(year.standard_error.at(1, 0)[0], 0.0, "there is no error at night");
    // Without noise there is none anywhere.
    let exact = Estimate::exact(view.total(), view.direct());
    let known = vec![Estimate::exact(daylight[0].total(), daylight[0].direct())];
    let chain = Chain { inputs: &inputs, view: &exact, daylight: &known, sees_sky: false, sky: &sky, sun: None };
    let year = annual::estimate(&job(&chain, &counting, &light, None), &lux, &|_| Ok(())).unwrap();
    assert_eq!(year.estimated.unwrap().annual_largest, 0.0);
}

/// Share of the cases whose interval holds the truth.
struct Coverage {
    held: usize,
    cases: usize,
}

impl Coverage {
    fn count(&mut self, distance: f64, half_width: f64) {
        self.cases += 1;
        self.held += usize::from(distance.abs() <= half_width);
    }

    fn share(&self) -> f64 {
        self.held as f64 / self.cases as f64
    }
}

/// 240 independent results of eight batches each, traced as 12 seeds of 160 batches: batches of one
/// seed are as independent as those of two. The converged value is the mean of all of them, whose own
/// error is a fifteenth of a result's.
#[test]
fn intervals_of_95_percent_hold_the_converged_value_in_93_to_97_percent_of_cases() {
    const SEEDS: u32 = 12;
    const BATCHES: u32 = 160;
    let Some(device) = Device::for_tests("coverage of the standard errors") else { return };
    let (project, inputs, sky) = room(4);
    let windows: Vec<_> = inputs.windows.iter().map(|w| w.window.clone()).collect();
    let sensors: Vec<Sensor> = inputs.sensors[0].sensors.clone();
    let (mut view, mut daylight) = (Vec::new(), Vec::new());
    for seed in 0..SEEDS {
        let options = ViewOptions {
            light_paths: 8,
            visibility_rays: 2,
            direct_samples: 64,
            near_samples: 32,
            batches: BATCHES,
            seed: 1000 + seed,
            keep_batches: true,
            ..ViewOptions::default()
        };
        view.extend(view_matrix::compute(&device, &inputs.scene, &windows, &sensors, &options, &Silent).unwrap().batches);
        let options = DaylightOptions { paths: 64, batches: BATCHES, seed: 5000 + seed, keep_batches: true, ..DaylightOptions::default() };
        let sky = inputs.sky(&project);
        daylight.extend(daylight_matrix::compute(&device, &inputs.scene, &windows[0], sky, &options, &Silent).unwrap().batches);
    }
    let all = (estimate(&view), vec![estimate(&daylight)]);
    let chain = Chain { inputs: &inputs, view: &all.0, daylight: &all.1, sees_sky: false, sky: &sky, sun: None };
    let truth = illuminance_of(&chain, &light_of(&chain));
    let year: Vec<f64> = (0..4).map(|s| truth.row(s).iter().map(|v| f64::from(*v)).sum()).collect();
    let counting = counting(&inputs);
    let hours: Vec<usize> = (0..24).filter(|&h| truth.at(0, h)[0] > 1.0).collect();
    let new = || Coverage { held: 0, cases: 0 };
    let (mut annual, mut hourly, mut without_view) = (new(), new(), new());
    let (mut relative_error, mut shares) = (0.0, [0.0; 2]);
    for (v, d) in view.chunks_exact(8).zip(daylight.chunks_exact(8)) {
        let (v, d) = (estimate(v), vec![estimate(d)]);
        let chain = Chain { inputs: &inputs, view: &v, daylight: &d, sees_sky: false, sky: &sky, sun: None };
        let sums = chain.annual();
        let factor = chain.confidence_95(&sums);
        for (sum, truth) in sums.iter().zip(&year) {
            annual.count(sum.value - truth, factor * sum.variance.sqrt());
            without_view.count(sum.value - truth, factor * sum.by_source[1].sqrt());
            relative_error += sum.variance.sqrt() / truth;
            shares = [0, 1].map(|i| shares[i] + sum.by_source[i]);
        }
        let light = light_of(&chain);
        let lux = illuminance_of(&chain, &light);
        let errors = annual::estimate(&job(&chain, &counting, &light, None), &lux, &|_| Ok(())).unwrap().standard_error;
        for sensor in 0..4 {
            for &hour in &hours {
                let value = |m: &Matrix<f32>| f64::from(m.at(sensor, hour)[0]);
                hourly.count(value(&lux) - value(&truth), factor * value(&errors));
            }
        }
    }
    let results = annual.cases / 4;
    assert!(results >= 200);
    eprintln!(
        "coverage of 95 %: {:.1} % of {} annual sums, {:.1} % of {} single hours; {results} results, mean standard error {:.1} %, \
         of whose variance V has {:.0} %; without V's part {:.1} %",
        100.0 * annual.share(),
        annual.cases,
        100.0 * hourly.share(),
        hourly.cases,
        100.0 * relative_error / annual.cases as f64,
        100.0 * shares[0] / (shares[0] + shares[1]),
        100.0 * without_view.share()
    );
    const OFF: f64 = 0.02;
    for (what, coverage) in [("annual sums", &annual), ("single hours", &hourly)] {
        assert!((0.95 - OFF..=0.95 + OFF).contains(&coverage.share()), "{what}: {:.2} %", 100.0 * coverage.share());
    }
    let found = format!("{:.1} % of annual sums, {:.1} % of single hours", 100.0 * annual.share(), 100.0 * hourly.share());
    crate::testing::measured("intervals", &found, &format!("± {} %", 100.0 * OFF));
    // The count can tell: an error that leaves a matrix out does not pass.
    assert!(without_view.share() < 0.9, "{:.3}", without_view.share());
}
