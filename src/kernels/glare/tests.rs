//! Both detectors against pictures made in f64 and analysed as pictures are.

use super::*;
use crate::camera::{Raster, View};
use crate::glare::{Analyser, PixelGeometry, Settings, TaskArea, Threshold};
use crate::gpu::mutation;
use crate::kernels::product::{self, DeviceKernel};
use crate::progress::Silent;
use std::sync::Arc;

/// Reproducible numbers in 0…1.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 16_777_216.0
    }
}

const BINS: usize = 11;

/// A view matrix: dim walls with noise, some bright rectangles of various sizes that see single
/// bins, dark pixels in between.
fn view_matrix(width: usize, height: usize, grey: bool, seed: u32) -> Matrix<f32> {
    let mut random = Random(seed);
    let mut matrix = Matrix::zeros(width * height, BINS, 3);
    for pixel in 0..width * height {
        if pixel % 7 == 3 {
            continue;
        }
        for bin in 0..BINS {
            let value = 0.02 * random.next();
            for c in 0..3 {
                matrix.at_mut(pixel, bin)[c] = if grey { value } else { value * (0.5 + random.next()) };
            }
        }
    }
    for _ in 0..9 {
        let mut within = |n: usize| (random.next() * n as f32) as usize;
        let (x, y) = (within(width), within(height));
        let (w, h) = (1 + within(width / 5), 1 + within(height / 5));
        for j in y..(y + h).min(height) {
            for i in x..(x + w).min(width) {
                let bin = within(BINS);
                matrix.at_mut(j * width + i, bin).fill(0.9);
            }
        }
    }
    matrix
}

/// Radiance of the window's bins, black in every fifth hour, in others from dim to very bright.
fn hours(count: usize, seed: u32, sign: f32) -> Matrix<f32> {
    let mut random = Random(seed);
    let mut matrix = Matrix::zeros(BINS, count, 3);
    for hour in 0..count {
        let level = if hour % 5 == 4 { 0.0 } else { 10f32.powf(3.5 * random.next() - 0.5) };
        for bin in 0..BINS {
            let value = sign * level * random.next().powi(3);
            for c in 0..3 {
                matrix.at_mut(bin, hour)[c] = value * (0.7 + 0.3 * c as f32);
            }
        }
    }
    matrix
}

pub(super) fn analyser(width: usize, height: usize, settings: Settings) -> Arc<Analyser> {
    let camera = View::parse("-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180").unwrap().camera().unwrap();
    let geometry = PixelGeometry::new(&Raster::new(camera, width, height).unwrap()).unwrap();
    Arc::new(Analyser::new(Arc::new(geometry), settings).unwrap())
}

pub(super) fn detectors(what: &str) -> Vec<Box<dyn Detector>> {
    let mut all: Vec<Box<dyn Detector>> = vec![Box::new(Native)];
    if let Some(device) = Device::for_tests(what) {
        let product = product::OnDevice::with_kernel(&device, DeviceKernel::Tiled).unwrap();
        all.push(Box::new(OnDevice::with_product(&device, product).unwrap()));
    }
    all
}

pub(super) fn run(
    detector: &dyn Detector,
    analyser: &Arc<Analyser>,
    lefts: &[&Matrix<f32>],
    options: StackOptions,
    request: &Year,
) -> Vec<HourGlare> {
    let mut sources: Vec<InMemory> = lefts.iter().map(|m| InMemory::new(m)).collect();
    let sources = sources.iter_mut().map(|s| s as &mut dyn PixelSource).collect();
    let stack = Stack::new(analyser.clone(), sources, options).unwrap();
    year(&ReadyView::new(detector, &stack).unwrap(), request, &Silent).unwrap()
}

/// What a picture in f64 (rounded to f32 as pictures are) gives.
pub(super) fn expected(analyser: &Analyser, picture: &[f64]) -> crate::glare::Glare {
    let picture: Vec<f32> = picture.iter().map(|&l| l.max(0.0) as f32).collect();
    analyser.analyse(&picture, None).unwrap()
}

/// Bound on DGP, and relative on illuminance and mean luminance, against the same picture in f64.
pub(super) const OF_PICTURE: f64 = 1e-5;

pub(super) fn compare(what: &str, found: &HourGlare, wanted: &crate::glare::Glare) {
    let near = |a: f64, b: f64, relative: f64| (a - b).abs() <= relative * b.abs().max(1.0);
    assert_eq!(found.sources, wanted.sources.len(), "{what}");
    assert!((found.indices.dgp - wanted.indices.dgp).abs() < OF_PICTURE, "{what}: {} {}", found.indices.dgp, wanted.indices.dgp);
    assert!(near(found.vertical_illuminance, wanted.vertical_illuminance, OF_PICTURE), "{what}");
    assert!(near(found.average_luminance, wanted.average_luminance, OF_PICTURE), "{what}");
    assert!(near(found.background_luminance, wanted.background_luminance, 1e-3), "{what}");
    for (a, b) in [
        (found.indices.ugr, wanted.indices.ugr),
        (found.indices.dgi, wanted.indices.dgi),
        (found.indices.vcp, wanted.indices.vcp),
        (found.indices.cgi, wanted.indices.cgi),
        (found.threshold, wanted.threshold),
    ] {
        assert!(near(a, b, 1e-3), "{what}: {found:?} {wanted:?}");
    }
}

#[test]
fn every_hour_is_that_of_its_picture() {
    let task = TaskArea { x: 20.0, y: 12.0, opening_angle: 0.7 };
    let thresholds = [
        Settings::default(),
        Settings { threshold: Threshold::TimesAverage(5.0), ..Settings::default() },
        Settings { threshold: Threshold::TimesTask(4.0), task: Some(task), peak_limit: None, ..Settings::default() },
        Settings { field_of_view: crate::glare::FieldOfView::Binocular, ..Settings::default() },
    ];
    let mut with_sources = 0;
    for detector in detectors("fused glare") {
        for (i, settings) in thresholds.iter().enumerate() {
            for grey in [true, false] {
                // Sizes that are no multiples of the tiles'.
                let [width, height] = [[41, 37], [48, 48]][i % 2];
                let analyser = analyser(width, height, settings.clone());
                let (v, x) = (view_matrix(width, height, grey, 1 + i as u32), hours(23, 7 + i as u32, 1.0));
                let found = run(&*detector, &analyser, &[&v], StackOptions::default(), &Year::new(&[&x]));
                let pictures = reference::luminance(&[(&v, &x)]);
                for (hour, (found, picture)) in found.iter().zip(&pictures).enumerate() {
                    let wanted = expected(&analyser, picture);
                    compare(&format!("{} settings {i} grey {grey} hour {hour}", detector.description()), found, &wanted);
                    with_sources += usize::from(!wanted.sources.is_empty());
                }
            }
        }
    }
    assert!(with_sources > 30, "only {with_sources} hours had sources");
}

#[test]
fn random_images_have_the_same_sources_fused_and_whole() {
    // A view of one bin whose light is the image itself: one product per pixel, so that both ways
    // see the same bits. What is left: Ev is made of pixels rounded to f32, or of exact ones.
    let rounding = f64::from(f32::EPSILON);
    let mut random = Random(2026);
    for detector in detectors("fused glare of random images") {
        for round in 0..24 {
            let (width, height) = (24 + (random.next() * 40.0) as usize, 24 + (random.next() * 40.0) as usize);
            let radius = [0.02, 0.1, 0.2, 0.6][round % 4];
            let settings = Settings { search_radius: radius, ..Settings::default() };
            let analyser = analyser(width, height, settings);
            // Noise around the threshold, and spots far above it, some above the peak limit.
            let density = random.next();
            let image: Vec<f32> = (0..width * height)
                .map(|_| match random.next() {
                    x if x > 0.99 => 30_000.0 + 60_000.0 * random.next(),
                    x if x > density => 1500.0 + 600.0 * random.next(),
                    _ => 100.0,
                })
                .collect();
            let v = Matrix::from_data(width * height, 1, 3, image.iter().flat_map(|&l| [l / 1000.0; 3]).collect()).unwrap();
            let light = Matrix::from_data(1, 2, 3, vec![1000.0 / 179.0, 1000.0 / 179.0, 1000.0 / 179.0, 3.0, 4.0, 5.0]).unwrap();
            let found = run(&*detector, &analyser, &[&v], StackOptions::default(), &Year::new(&[&light]));
            for (hour, found) in found.iter().enumerate() {
                let coefficient = (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * f64::from(light.at(0, hour)[c])).sum::<f64>() as f32;
                let picture: Vec<f32> = v.data().as_chunks::<3>().0.iter().map(|l| l[0] * coefficient).collect();
                let wanted = analyser.analyse(&picture, None).unwrap();
                assert_eq!(found.sources, wanted.sources.len(), "round {round} hour {hour}");
                let pairs = [
                    (found.indices.dgp, wanted.indices.dgp),
                    (found.indices.dgi, wanted.indices.dgi),
                    (found.indices.cgi, wanted.indices.cgi),
                    (found.indices.contrast, wanted.indices.contrast),
                ];
                for (a, b) in pairs {
                    assert!((a - b).abs() <= rounding * b.abs().max(1.0), "round {round} hour {hour}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn one_channel_is_kept_only_of_grey_pictures() {
    let analyser = analyser(20, 20, Settings::default());
    for (grey, terms) in [(true, BINS), (false, 3 * BINS)] {
        let v = view_matrix(20, 20, grey, 3);
        let mut source = InMemory::new(&v);
        let stack = Stack::new(analyser.clone(), vec![&mut source], StackOptions::default()).unwrap();
        assert_eq!((stack.is_grey(), stack.terms()), (grey, terms));
    }
    // One coloured pixel near the end is enough.
    let mut v = view_matrix(20, 20, true, 3);
    v.at_mut(310, 2)[1] += 0.01;
    let mut source = InMemory::new(&v);
    let stack = Stack::new(analyser, vec![&mut source], StackOptions::default()).unwrap();
    assert!(!stack.is_grey());
}

/// All numbers of all hours, as bits.
fn bits(year: &[HourGlare]) -> Vec<u64> {
    year.iter()
        .flat_map(|h| {
            let i = &h.indices;
            [i.dgp, i.dgi, i.ugr, i.vcp, i.cgi, i.ugp, h.vertical_illuminance, h.average_luminance, h.standard_error, h.sources as f64]
        })
        .map(f64::to_bits)
        .collect()
}

#[test]
fn bits_do_not_depend_on_passes_memory_or_skipping() {
    let analyser = analyser(53, 45, Settings::default());
    for detector in detectors("fused glare in tiles") {
        for grey in [true, false] {
            let (v, x) = (view_matrix(53, 45, grey, 5), hours(29, 8, 1.0));
            let rights = [&x];
            let whole = run(&*detector, &analyser, &[&v], StackOptions::default(), &Year::new(&rights));
            assert!(whole.iter().any(|h| h.sources > 1));
            for hours_per_pass in [1, 2, 7, 28] {
                let request = Year { hours_per_pass, ..Year::new(&rights) };
                let some = run(&*detector, &analyser, &[&v], StackOptions::default(), &request);
                assert!(bits(&some) == bits(&whole), "{} hours per pass", hours_per_pass);
            }
            let unskipped = run(&*detector, &analyser, &[&v], StackOptions::default(), &Year { skip: false, ..Year::new(&rights) });
            assert!(bits(&unskipped) == bits(&whole), "without skipping");
            let streamed = StackOptions { memory: 1, ..StackOptions::default() };
            let streamed = run(&*detector, &analyser, &[&v], streamed, &Year { hours_per_pass: 10, ..Year::new(&rights) });
            assert!(bits(&streamed) == bits(&whole), "streamed");
            let little = Year { memory: 1, ..Year::new(&rights) };
            assert!(bits(&run(&*detector, &analyser, &[&v], StackOptions::default(), &little)) == bits(&whole));
        }
    }
}

/// A sun in a few hours, on pixels that see no window too.
struct Sun;

impl Additions for Sun {
    fn of_hour(&self, hour: usize) -> Result<Added> {
        let mut added = Added::default();
        if hour.is_multiple_of(3) {
            let light = |i: u32| AddedLight {
                pixel: 700 + 53 * i + hour as u32,
                luminance: 1e3 * (hour * 40 + i as usize) as f32,
                error: 10.0 * (i + 1) as f32,
                shared_error: 0.0,
            };
            added.pixels.extend((0..6).map(light));
        }
        if hour.is_multiple_of(2) {
            let direction = [0.3, 0.8, 0.1 * hour as f64 - 0.6];
            let length = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
            let disc = Disc { direction: direction.map(|v| v / length), luminance: 2e5 * hour as f64, solid_angle: 5e-5, error: 0.0 };
            added.discs.push(disc);
        }
        Ok(added)
    }
}

#[test]
fn sums_of_several_terms_and_additional_light_are_pictures_too() {
    let analyser = analyser(53, 45, Settings::default());
    let (v, direct) = (view_matrix(53, 45, true, 11), view_matrix(53, 45, true, 12));
    let x = hours(17, 13, 1.0);
    // Less than what it is taken from, as in the five-phase method.
    let mut less = hours(17, 13, -0.4);
    less.data_mut().iter_mut().for_each(|v| *v *= 0.5);
    let mut smaller = direct.clone();
    smaller.data_mut().iter_mut().zip(v.data()).for_each(|(d, v)| *d = d.min(*v));
    let options = StackOptions { dark_pixels: true, ..StackOptions::default() };
    let mut pictures = reference::luminance(&[(&v, &x), (&smaller, &less)]);
    for (hour, picture) in pictures.iter_mut().enumerate() {
        let added = Sun.of_hour(hour).unwrap();
        added.pixels.iter().for_each(|a| picture[a.pixel as usize] += f64::from(a.luminance));
    }
    for detector in detectors("fused glare of several terms") {
        let rights = [&x, &less];
        let request = Year { additions: Some(&Sun), ..Year::new(&rights) };
        let found = run(&*detector, &analyser, &[&v, &smaller], options, &request);
        for (hour, (found, picture)) in found.iter().zip(&pictures).enumerate() {
            let picture: Vec<f32> = picture.iter().map(|&l| l.max(0.0) as f32).collect();
            let wanted = analyser.analyse_with_discs(&picture, &Sun.of_hour(hour).unwrap().discs, None).unwrap();
            compare(&format!("{} hour {hour}", detector.description()), found, &wanted);
        }
        let unskipped = Year { skip: false, hours_per_pass: 4, ..request };
        assert!(bits(&run(&*detector, &analyser, &[&v, &smaller], options, &unskipped)) == bits(&found));
    }
}

/// Light with independent noise.
struct Noisy(Vec<AddedLight>);

impl Noisy {
    /// The same with other noise, normally distributed.
    fn shaken(&self, random: &mut Random) -> Self {
        let mut light = self.0.clone();
        for l in &mut light {
            let normal: f32 = (0..12).map(|_| random.next()).sum::<f32>() - 6.0;
            l.luminance = (l.luminance + l.error * normal).max(0.0);
        }
        Self(light)
    }
}

impl Additions for Noisy {
    fn of_hour(&self, _hour: usize) -> Result<Added> {
        Ok(Added { pixels: self.0.clone(), ..Added::default() })
    }
}

/// Light in independent batches, each of which is too bright or too dark everywhere.
struct Batched(Vec<AddedLight>, SharedNoise);

impl Batched {
    const BATCHES: usize = 8;

    fn shaken(light: &[AddedLight], weights: &PixelWeights, random: &mut Random) -> Self {
        let factors: Vec<f64> =
            (0..Self::BATCHES).map(|_| 1.0 + 0.2 * f64::from((0..12).map(|_| random.next()).sum::<f32>() - 6.0)).collect();
        let mean = factors.iter().sum::<f64>() / Self::BATCHES as f64;
        let mut sums = SharedSums::new(Some(weights), Self::BATCHES);
        let mut light = light.to_vec();
        for l in &mut light {
            let batches: Vec<f64> = factors.iter().map(|f| f * f64::from(l.luminance)).collect();
            sums.add(weights, l.pixel as usize, &batches);
            l.luminance = (f64::from(l.luminance) * mean) as f32;
        }
        Self(light, sums.noise())
    }
}

impl Additions for Batched {
    fn of_hour(&self, _hour: usize) -> Result<Added> {
        // As the light of a sun twice as strong.
        Ok(Added { pixels: self.0.clone(), shared: self.1.clone().times(2.0).times(0.5), discs: Vec::new() })
    }
}

#[test]
fn noise_that_pixels_share_does_not_even_out() {
    const RUNS: usize = 400;
    let analyser = analyser(53, 45, Settings::default());
    let weights = PixelWeights::new(analyser.geometry().clone());
    let mut v = view_matrix(53, 45, true, 11);
    v.data_mut().iter_mut().for_each(|v| *v = v.min(0.02));
    let x = Matrix::from_data(BINS, 1, 3, vec![20.0; BINS * 3]).unwrap();
    let options = StackOptions { dark_pixels: true, ..StackOptions::default() };
    let mut random = Random(5);
    let each = |pixel: u32, luminance: f32| AddedLight { pixel, luminance, error: 0.0, shared_error: 0.0 };
    for (case, light) in [
        ("by the eye alone", (0..900).map(|i| each(300 + i * 1700 / 900, 100.0 + (i % 7) as f32 * 40.0)).collect::<Vec<_>>()),
        // A source of several blocks: a patch of 6 × 6 pixels.
        ("a bright source", (0..36).map(|i| each((20 + i / 6) * 53 + 24 + i % 6, 2e4)).collect()),
    ] {
        let years: Vec<HourGlare> = (0..RUNS)
            .map(|_| {
                let (shaken, rights) = (Batched::shaken(&light, &weights, &mut random), [&x]);
                run(&Native, &analyser, &[&v], options, &Year { additions: Some(&shaken), ..Year::new(&rights) }).remove(0)
            })
            .collect();
        let mean = years.iter().map(|h| h.indices.dgp).sum::<f64>() / RUNS as f64;
        let seen = (years.iter().map(|h| (h.indices.dgp - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64).sqrt();
        let predicted = (years.iter().map(|h| h.standard_error.powi(2)).sum::<f64>() / RUNS as f64).sqrt();
        println!("{case}: predicted {predicted:.3e}, seen {seen:.3e}, {} sources", years[0].sources);
        // The spread of 400 values is known to 3.5 %, the mean of as many variances of 8 batches better.
        assert!((predicted / seen - 1.0).abs() < 0.15, "{case}: {predicted} {seen}");
    }
}

#[test]
fn noise_of_added_light_reaches_dgp_by_the_eye_the_sources_and_the_threshold() {
    const RUNS: usize = 400;
    let analyser = analyser(53, 45, Settings::default());
    let mut v = view_matrix(53, 45, true, 11);
    v.data_mut().iter_mut().for_each(|v| *v = v.min(0.02));
    let x = Matrix::from_data(BINS, 1, 3, vec![20.0; BINS * 3]).unwrap();
    let options = StackOptions { dark_pixels: true, ..StackOptions::default() };
    let mut random = Random(3);
    let mut light = |count: u32, low: f32, high: f32, error: f32| {
        let each =
            |i: u32| AddedLight { pixel: 300 + i * 1700 / count, luminance: low + (high - low) * random.next(), error, shared_error: 0.0 };
        Noisy((0..count).map(each).collect())
    };
    for (case, light) in [
        ("by the eye alone", light(900, 100.0, 400.0, 90.0)),
        ("bright sources", light(20, 2e4, 6e4, 6e3)),
        ("over the threshold and back", light(100, 0.0, 4000.0, 250.0)),
    ] {
        let years: Vec<HourGlare> = (0..RUNS)
            .map(|_| {
                let (shaken, rights) = (light.shaken(&mut random), [&x]);
                run(&Native, &analyser, &[&v], options, &Year { additions: Some(&shaken), ..Year::new(&rights) }).remove(0)
            })
            .collect();
        let mean = years.iter().map(|h| h.indices.dgp).sum::<f64>() / RUNS as f64;
        let seen = (years.iter().map(|h| (h.indices.dgp - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64).sqrt();
        let predicted = (years.iter().map(|h| h.standard_error.powi(2)).sum::<f64>() / RUNS as f64).sqrt();
        println!("{case}: predicted {predicted:.3e}, seen {seen:.3e}, {} sources", years[0].sources);
        // The spread of 400 values is known to 3.5 %; 12 numbers make a normal one only nearly.
        assert!((predicted / seen - 1.0).abs() < 0.15, "{case}: {predicted} {seen}");
    }
}

/// A disc in every hour.
struct OneDisc(Disc);

impl Additions for OneDisc {
    fn of_hour(&self, _hour: usize) -> Result<Added> {
        Ok(Added { discs: vec![self.0], ..Added::default() })
    }
}

#[test]
fn dgp_is_as_uncertain_as_the_share_of_the_sun_that_is_seen() {
    const RUNS: usize = 400;
    let analyser = analyser(24, 24, Settings::default());
    let (v, x) = (view_matrix(24, 24, true, 5), hours(1, 8, 0.05));
    let rights = [&x];
    for (veil, given, luminance) in [(None, None, 1e8), (None, Some([900.0]), 2e7), (Some(0.533), None, 1e8), (None, None, 6e7)] {
        let disc = Disc { direction: [0.28, 0.96, 0.0], luminance, solid_angle: 3e-5, error: 0.03 };
        let options = StackOptions { veil, ..StackOptions::default() };
        let of = |disc: Disc| {
            let discs = OneDisc(disc);
            let illuminance = given.as_ref().map(|g| &g[..]);
            run(&Native, &analyser, &[&v], options, &Year { additions: Some(&discs), illuminance, ..Year::new(&rights) })[0]
        };
        let mut random = Random(77);
        let stated = of(disc);
        let values: Vec<f64> = (0..RUNS)
            .map(|_| {
                let normal = f64::from((0..12).map(|_| random.next()).sum::<f32>() - 6.0);
                of(Disc { solid_angle: disc.solid_angle * (1.0 + disc.error * normal), ..disc }).indices.dgp
            })
            .collect();
        let mean = values.iter().sum::<f64>() / RUNS as f64;
        let seen = (values.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64).sqrt();
        println!("veil {veil:?}, Ev {given:?}: DGP {:.4} ± {:.2e}, seen {seen:.2e}", stated.indices.dgp, stated.standard_error);
        // The spread of 400 values is known to 3.5 %.
        assert!(seen > 1e-4 && (stated.standard_error / seen - 1.0).abs() < 0.12, "{} {seen}", stated.standard_error);
        assert_eq!(of(Disc { error: 0.0, ..disc }).standard_error, 0.0);
    }
}

#[test]
fn a_veil_spreads_peaks_as_in_a_picture() {
    let settings = Settings { peak_limit: Some(20_000.0), ..Settings::default() };
    let analyser = analyser(53, 45, settings);
    let (v, x) = (view_matrix(53, 45, true, 11), hours(17, 13, 1.0));
    let options = StackOptions { veil: Some(6.0), ..StackOptions::default() };
    let mut spread = 0;
    for detector in detectors("fused glare with a veil") {
        let rights = [&x];
        let found = run(&*detector, &analyser, &[&v], options, &Year::new(&rights));
        for (hour, (found, picture)) in found.iter().zip(reference::luminance(&[(&v, &x)])).enumerate() {
            let mut picture: Vec<f32> = picture.iter().map(|&l| l as f32).collect();
            let plain = analyser.analyse(&picture, None).unwrap();
            crate::glare::veil::spread_peaks(&mut picture, analyser.geometry(), 20_000.0, 6.0).unwrap();
            let wanted = analyser.analyse(&picture, None).unwrap();
            compare(&format!("{} hour {hour}", detector.description()), found, &wanted);
            spread += usize::from((plain.indices.dgp - wanted.indices.dgp).abs() > 1e-3);
        }
        // A disc is spread by itself, whatever the pixels, with peaks among them or without.
        for luminance in [3e8, 1e3] {
            let disc = Disc { direction: [0.6, 0.8, 0.0], luminance, solid_angle: 6.8e-5, error: 0.02 };
            let discs = OneDisc(disc);
            let request = Year { additions: Some(&discs), ..Year::new(&rights) };
            let found = run(&*detector, &analyser, &[&v], options, &request);
            let sharp = run(&*detector, &analyser, &[&v], StackOptions::default(), &request);
            for (hour, (found, picture)) in found.iter().zip(reference::luminance(&[(&v, &x)])).enumerate() {
                let mut picture: Vec<f32> = picture.iter().map(|&l| l as f32).collect();
                crate::glare::veil::spread_peaks(&mut picture, analyser.geometry(), 20_000.0, 6.0).unwrap();
                let parts = crate::glare::veil::spread_disc(&disc, 6.0, 20_000.0, 2000.0).unwrap();
                assert_eq!(parts.len(), if luminance > 1e4 { 2 } else { 0 });
                let light = disc.flux() * 0.8;
                let (plain, with) =
                    (analyser.analyse(&picture, None).unwrap(), analyser.analyse_with_discs(&picture, &parts, None).unwrap());
                assert!((found.vertical_illuminance / (plain.vertical_illuminance + light) - 1.0).abs() < 1e-5, "hour {hour}");
                assert_eq!(found.sources, with.sources.len());
                let contrast = |g: &crate::glare::Glare| {
                    let model = analyser.settings().dgp;
                    model.contrast_sum(g.sources.iter().map(|s| (s.luminance, s.solid_angle, s.position_index)))
                };
                let dgp = analyser.settings().dgp.dgp(plain.vertical_illuminance + light, contrast(&with));
                assert!((found.indices.dgp - dgp).abs() < 1e-5, "hour {hour}: {} {dgp}", found.indices.dgp);
                assert!(
                    luminance < 1e4
                        || (found.standard_error > 0.0 && found.indices.dgp < sharp[hour].indices.dgp)
                        || found.indices.dgp == 1.0
                );
            }
        }
    }
    assert!(spread > 0, "the veil changed nothing");
}

#[test]
fn faults_planted_in_the_shaders_are_found() {
    let Some(device) = Device::for_tests("faults planted in glare shaders") else { return };
    let analyser = analyser(53, 45, Settings { threshold: Threshold::TimesAverage(5.0), ..Settings::default() });
    // More hours than the smallest tile of a product, each with a threshold of its own.
    let (v, x) = (view_matrix(53, 45, true, 11), hours(140, 13, 1.0));
    let options = StackOptions { dark_pixels: true, ..StackOptions::default() };
    let rights = [&x];
    let request = Year { additions: Some(&Sun), ..Year::new(&rights) };
    let wanted = run(&Native, &analyser, &[&v], options, &request);
    let faults = [
        ("glare/compact", "value > threshold", "value >= 0.5 * threshold"),
        ("glare/compact", "* PIXELS_EACH;", "* (PIXELS_EACH - 1u);"),
        ("glare/list", "sums[lane] - own", "sums[lane]"),
        ("glare/compact", "step *= 2u", "step *= 4u"),
        ("glare/compact", "params.first_hour + hour", "params.first_hour"),
        ("glare/add", "+= bitcast", "= bitcast"),
        ("glare/add", "luminance[addition.x]", "luminance[addition.x + 1u]"),
    ];
    for (path, from, to) in faults {
        let product = product::OnDevice::with_kernel(&device, DeviceKernel::Tiled).unwrap().tiles_of(1);
        let faulty = mutation::with(path, from, to, || OnDevice::with_product(&device, product)).unwrap();
        let mut source = InMemory::new(&v);
        let stack = Stack::new(analyser.clone(), vec![&mut source], options).unwrap();
        let found = year(&ReadyView::new(&faulty, &stack).unwrap(), &request, &Silent);
        let same =
            found.is_ok_and(|f| f.iter().zip(&wanted).all(|(a, b)| a.sources == b.sources && (a.indices.dgp - b.indices.dgp).abs() < 1e-5));
        assert!(!same, "nobody noticed '{to}' in {path}");
    }
}

#[test]
fn what_does_not_fit_is_an_error() {
    let analyser = analyser(20, 20, Settings::default());
    let (v, x) = (view_matrix(20, 20, true, 1), hours(3, 1, 1.0));
    let short = view_matrix(20, 19, true, 1);
    let mut source = InMemory::new(&short);
    assert!(Stack::new(analyser.clone(), vec![&mut source], StackOptions::default()).err().unwrap().to_string().contains("fewer rows"));
    let mut source = InMemory::new(&v);
    let stack = Stack::new(analyser, vec![&mut source], StackOptions::default()).unwrap();
    let wrong = Matrix::<f32>::zeros(BINS + 1, 3, 3);
    assert!(year(&ReadyView::new(&Native, &stack).unwrap(), &Year::new(&[&wrong]), &Silent).is_err());
    let rights = [&x];
    assert!(year(&ReadyView::new(&Native, &stack).unwrap(), &Year { illuminance: Some(&[1.0]), ..Year::new(&rights) }, &Silent).is_err());
    // Light may be added only where it was provided for.
    let error =
        year(&ReadyView::new(&Native, &stack).unwrap(), &Year { additions: Some(&Sun), ..Year::new(&rights) }, &Silent).unwrap_err();
    assert!(error.to_string().contains("added in hour 0"), "{error}");
}

/// Counts how often pixels are loaded.
struct Counting(std::sync::atomic::AtomicUsize);

impl Detector for Counting {
    fn description(&self) -> String {
        "counting".into()
    }

    fn load<'b>(&'b self, bands: Bands<'b>) -> Result<Box<dyn Loaded + 'b>> {
        self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Native.load(bands).map(|_| Box::new(bands) as Box<dyn Loaded + 'b>)
    }
}

#[test]
fn pixels_are_loaded_once_for_all_states() {
    let analyser = analyser(24, 24, Settings::default());
    let v = view_matrix(24, 24, true, 5);
    let mut source = InMemory::new(&v);
    let stack = Stack::new(analyser.clone(), vec![&mut source], StackOptions::default()).unwrap();
    let detector = Counting(std::sync::atomic::AtomicUsize::new(0));
    let view = ReadyView::new(&detector, &stack).unwrap();
    for state in 0..3 {
        let x = hours(9, 8 + state, 1.0);
        let rights = [&x];
        let request = Year { hours_per_pass: 2, ..Year::new(&rights) };
        let wanted = run(&Native, &analyser, &[&v], StackOptions::default(), &request);
        assert!(bits(&year(&view, &request, &Silent).unwrap()) == bits(&wanted));
    }
    assert_eq!(detector.0.load(std::sync::atomic::Ordering::Relaxed), 1);
}
