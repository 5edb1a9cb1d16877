use super::*;
use crate::camera::{Raster, View};
use crate::error::Warnings;
use std::f64::consts::PI;

const FISHEYE: &str = "-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180";

/// Numbers in 0…1 from a fixed sequence.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Between two numbers, evenly in their logarithm.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.next())
    }
}

pub(super) fn view(options: &str, width: usize, height: usize) -> Arc<PixelGeometry> {
    let raster = Raster::new(View::parse(options).unwrap().camera().unwrap(), width, height).unwrap();
    Arc::new(PixelGeometry::new(&raster).unwrap())
}

pub(super) fn fisheye(size: usize) -> Arc<PixelGeometry> {
    view(FISHEYE, size, size)
}

/// Direction at an azimuth to the right of +Y and an altitude, degrees.
pub(super) fn towards(azimuth: f64, altitude: f64) -> [f64; 3] {
    let (a, h) = (azimuth.to_radians(), altitude.to_radians());
    [a.sin() * h.cos(), a.cos() * h.cos(), h.sin()]
}

/// Sets the luminance of all pixels within a radius, degrees, of a direction.
pub(super) fn paint(luminance: &mut [f32], geometry: &PixelGeometry, direction: [f64; 3], radius: f64, value: f64) {
    let cosine = radius.to_radians().cos();
    for (l, d) in luminance.iter_mut().zip(&geometry.directions) {
        if geometry::dot(*d, direction) >= cosine {
            *l = value as f32;
        }
    }
}

fn analyse(geometry: &Arc<PixelGeometry>, luminance: &[f32], settings: &Settings) -> Glare {
    Analyser::new(geometry.clone(), settings.clone()).unwrap().analyse(luminance, None).unwrap()
}

fn assert_finite(glare: &Glare) {
    let i = &glare.indices;
    for v in [
        i.dgp,
        i.dgps,
        i.dgi,
        i.ugr,
        i.vcp,
        i.cgi,
        i.ugp,
        i.contrast,
        glare.vertical_illuminance,
        glare.direct_illuminance,
        glare.average_luminance,
        glare.background_luminance,
    ] {
        assert!(v.is_finite(), "{i:?}");
    }
    for s in &glare.sources {
        assert!(
            [s.x, s.y, s.luminance, s.solid_angle, s.position_index, s.sigma, s.tau, s.illuminance].iter().all(|v| v.is_finite()),
            "{s:?}"
        );
        assert!(!s.pixels.is_empty());
    }
}

#[test]
fn a_fisheye_is_a_hemisphere() {
    for size in [64, 101, 400] {
        let g = fisheye(size);
        // The rim is a staircase of pixels: its error falls with their number.
        let tolerance = 3.0 / size as f64;
        assert!((g.total_solid_angle() / (2.0 * PI) - 1.0).abs() < tolerance, "{size}: {}", g.total_solid_angle());
        assert!((g.hemisphere_coverage() - 1.0).abs() < tolerance * tolerance, "{size}: {}", g.hemisphere_coverage());
    }
}

/// A uniform field of 1000 cd/m² and a sun of 1e7 cd/m² on the line of sight, original constants.
#[test]
fn uniform_field_with_a_sun_ahead() {
    let g = fisheye(401);
    let middle = 200 * 401 + 200;
    let omega = 6.7967e-5;
    let mut luminance = vec![1000.0f32; g.pixel_count()];
    // The middle pixel is smaller than the sun: it gets the sun's light.
    let scale = omega / g.solid_angles[middle];
    luminance[middle] = (1e7 * scale) as f32;
    let glare = analyse(&g, &luminance, &Settings { dgp: DgpModel::ORIGINAL, ..Settings::default() });
    assert_eq!(glare.sources.len(), 1);
    assert!((glare.vertical_illuminance / 3821.19 - 1.0).abs() < 2e-4, "{}", glare.vertical_illuminance);
    let expected =
        5.87e-5 * 3821.19 + 0.0918 * (1.0 + (1e7 * scale).powi(2) * g.solid_angles[middle] / 3821.19f64.powf(1.87)).log10() + 0.16;
    assert!((glare.indices.dgp - expected).abs() < 1e-4, "{} {expected}", glare.indices.dgp);
    assert!((expected - 0.6720).abs() < 0.0918 * scale.log10().abs() + 1e-3);
    assert!((glare.background_luminance / 1000.0 - 1.0).abs() < 1e-3);
    // The enhanced simplified DGP is DGP when the given illuminance is the picture's.
    let analyser = Analyser::new(g.clone(), Settings::default()).unwrap();
    let own = analyser.analyse(&luminance, None).unwrap();
    assert_eq!(analyser.analyse(&luminance, Some(own.vertical_illuminance)).unwrap(), own);
}

/// All pairs, no blocks: the plain meaning of grouping.
fn plain_groups(pixels: &[u32], geometry: &PixelGeometry, radius: f64) -> Vec<u32> {
    let cosine = (radius / 2.0).cos();
    let mut labels: Vec<u32> = (0..pixels.len() as u32).collect();
    let direction = |n: usize| geometry.directions[pixels[n] as usize];
    loop {
        let mut changed = false;
        for a in 0..pixels.len() {
            for b in 0..pixels.len() {
                if labels[b] < labels[a] && geometry::dot(direction(a), direction(b)) >= cosine {
                    labels[a] = labels[b];
                    changed = true;
                }
            }
        }
        if !changed {
            return labels;
        }
    }
}

#[test]
fn grouping_in_blocks_is_grouping_by_pairs() {
    let mut random = Random(7);
    for (options, size) in
        [(FISHEYE, 60), (FISHEYE, 101), ("-vth -vh 180 -vv 180", 80), ("-vtv -vh 90 -vv 60", 50), ("-vts -vh 180 -vv 180", 64)]
    {
        let g = view(options, size, size);
        for radius in [0.0, 0.05, 0.2, 0.7, 3.0] {
            let neighbourhood = Neighbourhood::new(&g, radius);
            for density in [0.002, 0.01, 0.05, 0.3] {
                let pixels: Vec<u32> =
                    (0..g.pixel_count() as u32).filter(|&i| g.is_inside(i as usize) && random.next() < density).collect();
                let pixels = &pixels[..pixels.len().min(700)];
                assert_eq!(
                    neighbourhood.group(pixels, &g),
                    plain_groups(pixels, &g, radius),
                    "{options} {size} r {radius} density {density}"
                );
            }
        }
    }
}

/// The result depends on the pixels alone: reduced elsewhere, or found among others in any way.
#[test]
fn judging_the_glare_pixels_is_analysing_the_picture() {
    let g = fisheye(120);
    let mut random = Random(9);
    let analyser = Analyser::new(g.clone(), Settings { field_of_view: FieldOfView::Total, ..Settings::default() }).unwrap();
    for density in [0.0, 0.01, 0.2, 0.9] {
        let luminance: Vec<f32> =
            (0..g.pixel_count()).map(|_| if random.next() < density { random.magnitude(2e3, 2e5) as f32 } else { 300.0 }).collect();
        let whole = analyser.analyse(&luminance, None).unwrap();
        let pixels: Vec<u32> =
            (0..g.pixel_count() as u32).filter(|&i| analyser.searched()[i as usize] && luminance[i as usize] > 2000.0).collect();
        let values: Vec<f32> = pixels.iter().map(|&p| luminance[p as usize]).collect();
        let totals = g.totals(&luminance).unwrap();
        let found = GlarePixels { pixels: &pixels, luminance: &values };
        assert_eq!(analyser.judge(&totals, None, found, &[], None), whole);
        // Every glare pixel is in exactly one source.
        let mut found: Vec<u32> = whole.sources.iter().flat_map(|s| s.pixels.clone()).collect();
        found.sort_unstable();
        assert_eq!(found, pixels);
    }
    let table = analyser.position_indices();
    assert!(table.iter().enumerate().all(|(i, &p)| if g.is_inside(i) { p >= 1.0 } else { p == 0.0 }));
}

#[test]
fn pixels_apart_by_less_than_half_the_radius_are_one_source() {
    let g = fisheye(400);
    let two = |apart: f64, settings: &Settings| {
        let mut luminance = vec![500.0; g.pixel_count()];
        paint(&mut luminance, &g, towards(20.0, 0.0), 1.0, 5000.0);
        paint(&mut luminance, &g, towards(20.0 + apart, 0.0), 1.0, 8000.0);
        analyse(&g, &luminance, settings).sources.len()
    };
    // 0.1 rad are 5.73°; the discs are 2° wide and the pixels 0.45°.
    assert_eq!(two(7.0, &Settings::default()), 1);
    assert_eq!(two(8.6, &Settings::default()), 2);
    assert_eq!(two(8.6, &Settings { search_radius: 0.3, ..Settings::default() }), 1);
}

#[test]
fn peaks_form_their_own_sources() {
    let g = fisheye(400);
    let mut luminance = vec![500.0; g.pixel_count()];
    paint(&mut luminance, &g, towards(20.0, 20.0), 10.0, 5000.0);
    paint(&mut luminance, &g, towards(20.0, 20.0), 1.0, 1e6);
    let glare = analyse(&g, &luminance, &Settings::default());
    assert_eq!(glare.sources.iter().map(|s| s.is_peak).collect::<Vec<_>>(), [false, true]);
    assert!((glare.sources[0].luminance - 5000.0).abs() < 1.0 && (glare.sources[1].luminance - 1e6).abs() < 1.0);
    assert_eq!(analyse(&g, &luminance, &Settings { peak_limit: None, ..Settings::default() }).sources.len(), 1);
    assert_eq!(analyse(&g, &luminance, &Settings { peak_limit: Some(2e6), ..Settings::default() }).sources.len(), 1);
    // A source all above the limit leaves nothing behind.
    let mut luminance = vec![500.0; g.pixel_count()];
    paint(&mut luminance, &g, towards(20.0, 20.0), 2.0, 1e6);
    assert_eq!(analyse(&g, &luminance, &Settings::default()).sources.len(), 1);
}

#[test]
fn thresholds_may_follow_the_average_or_the_task() {
    let g = fisheye(200);
    let mut luminance = vec![400.0; g.pixel_count()];
    paint(&mut luminance, &g, towards(0.0, -30.0), 15.0, 150.0);
    paint(&mut luminance, &g, towards(30.0, 20.0), 3.0, 1000.0);
    let count = |s: &Settings| analyse(&g, &luminance, s).sources.len();
    assert_eq!(count(&Settings::default()), 0);
    let average = analyse(&g, &luminance, &Settings::default()).average_luminance;
    let by_average = |factor| Settings { threshold: Threshold::from_option(Some(factor), false), ..Settings::default() };
    assert_eq!((count(&by_average(990.0 / average)), count(&by_average(1010.0 / average))), (1, 0));
    let task = Some(TaskArea { x: 99.0, y: 66.0, opening_angle: 0.3 });
    let by_task = |factor| Settings { task, threshold: Threshold::from_option(factor, true), ..Settings::default() };
    let glare = analyse(&g, &luminance, &by_task(None));
    assert!((glare.task_luminance.unwrap() - 150.0).abs() < 1e-6);
    assert!((glare.threshold - 750.0).abs() < 1e-9);
    assert_eq!(glare.sources.len(), 1);
    assert_eq!(count(&by_task(Some(6.7))), 0);
    for task in [
        TaskArea { x: 0.0, y: 0.0, opening_angle: 0.3 },
        TaskArea { x: 500.0, y: 1.0, opening_angle: 0.3 },
        TaskArea { x: 99.0, y: 99.0, opening_angle: f64::NAN },
    ] {
        assert!(Analyser::new(g.clone(), Settings { task: Some(task), ..Settings::default() }).is_err());
    }
}

#[test]
fn sources_outside_the_field_of_view_do_not_count() {
    let g = fisheye(200);
    let mut luminance = vec![500.0; g.pixel_count()];
    paint(&mut luminance, &g, towards(75.0, 0.0), 5.0, 20000.0);
    paint(&mut luminance, &g, towards(0.0, 70.0), 5.0, 20000.0);
    paint(&mut luminance, &g, towards(10.0, 10.0), 3.0, 20000.0);
    let of = |field_of_view| analyse(&g, &luminance, &Settings { field_of_view, ..Settings::default() });
    let [whole, total, both] = [FieldOfView::Whole, FieldOfView::Total, FieldOfView::Binocular].map(of);
    assert_eq!([&whole, &total, &both].map(|x| x.sources.len()), [3, 2, 1]);
    assert_eq!(whole.vertical_illuminance, both.vertical_illuminance);
}

/// The weighted centroid treats left and right alike; evalglare's truncated one does not.
#[test]
fn mirrored_pictures_give_the_same_glare() {
    let g = fisheye(100);
    let mut random = Random(3);
    for _ in 0..5 {
        let mut luminance = vec![500.0; g.pixel_count()];
        for _ in 0..4 {
            let direction = towards(random.next() * 160.0 - 80.0, random.next() * 140.0 - 70.0);
            paint(&mut luminance, &g, direction, 1.0 + 5.0 * random.next(), random.magnitude(3e3, 1e6));
        }
        let mirrored: Vec<f32> = luminance.chunks(100).flat_map(|row| row.iter().rev().copied().collect::<Vec<_>>()).collect();
        let settings = Settings { convention: Convention::Exact, ..Settings::default() };
        let (a, b) = (analyse(&g, &luminance, &settings), analyse(&g, &mirrored, &settings));
        assert_eq!(a.sources.len(), b.sources.len());
        assert!((a.indices.dgp - b.indices.dgp).abs() < 1e-9 && (a.indices.ugr - b.indices.ugr).abs() < 1e-9);
    }
}

/// What evalglare 3.06 says of a source of a tilted view (`-d`, `-vd 0 1 1.5`), and what is right.
#[test]
fn tilted_views_turn_tau() {
    let level = ViewFrame::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
    let tilted = ViewFrame::new([0.0, 1.0, 1.5], [0.0, 0.0, 2.0]).unwrap();
    assert!((tilted.up_length - 1.0 / 3.25f64.sqrt()).abs() < 1e-12);
    // The same place in both pictures, 30° above the line of sight.
    let at = |f: &ViewFrame| [0, 1, 2].map(|k| 0.75f64.sqrt() * f.forward[k] + 0.5 * f.up[k]);
    let (sigma, tau) = position::angles(&tilted.squared(), at(&tilted));
    assert!((sigma - 30.0).abs() < 1e-9 && tau.abs() < 1e-6);
    assert_eq!(position::angles(&level, at(&level)).1, 0.0);
    let tau = position::angles(&tilted, at(&tilted)).1;
    assert!((tau - (1.0 / 3.25f64.sqrt()).acos().to_degrees()).abs() < 1e-9, "{tau}");
}

#[test]
fn no_picture_gives_an_undefined_number() {
    let mut random = Random(11);
    for (options, w, h) in [
        (FISHEYE, 50, 50),
        (FISHEYE, 60, 40),
        ("-vth -vd 0 0 1 -vu 0 1 0 -vh 180 -vv 180", 40, 40),
        ("-vtc -vh 360 -vv 100", 60, 30),
        ("-vta -vh 360 -vv 360", 41, 41),
        ("-vta -vh 180 -vv 180", 1, 1),
        ("-vta -vh 180 -vv 90", 3, 2),
    ] {
        let g = view(options, w, h);
        let n = g.pixel_count();
        let mut pictures: Vec<Vec<f32>> = [0.0, f32::MIN_POSITIVE, 100.0, 5000.0, 1e30].iter().map(|&l| vec![l; n]).collect();
        pictures.push((0..n).map(|_| random.magnitude(1e-10, 1e20) as f32).collect());
        pictures.push((0..n).map(|i| if i % 3 == 0 { 1e5 } else { 0.0 }).collect());
        pictures.push((0..n).map(|i| if i == n / 2 { 1e9 } else { 0.0 }).collect());
        for picture in &pictures {
            for convention in [Convention::Evalglare, Convention::Exact] {
                for background in [Background::Illuminance, Background::MeanLuminance, Background::WholeIlluminance] {
                    for position_index in [PositionIndex::Guth, PositionIndex::GuthIwata, PositionIndex::Kim] {
                        let settings = Settings { convention, background, position_index, ..Settings::default() };
                        let analyser = Analyser::new(g.clone(), settings).unwrap();
                        for ev in [None, Some(0.0), Some(1e4)] {
                            let glare = analyser.analyse(picture, ev).unwrap();
                            assert_finite(&glare);
                            assert!((0.0..=1.0).contains(&glare.indices.dgp));
                        }
                    }
                }
            }
        }
        let analyser = Analyser::new(g.clone(), Settings::default()).unwrap();
        assert!(analyser.analyse(&vec![f32::NAN; n], None).is_err());
        assert!(analyser.analyse(&vec![-1.0; n], None).is_err());
        assert!(analyser.analyse(&vec![f32::INFINITY; n], None).is_err());
        assert!(analyser.analyse(&[], None).is_err());
        assert!(analyser.analyse(&vec![1.0; n], Some(f64::NAN)).is_err());
    }
    let mut warnings = Warnings::new();
    let pixels = [[1.0; 3], [f32::NAN, 1.0, 1.0], [-5.0; 3], [f32::MAX; 3]];
    let luminance = detect::luminance(&pixels, 2, &mut warnings);
    assert!((luminance[0] - 179.0).abs() < 1e-3 && luminance[1..] == [0.0; 3]);
    assert!(warnings.iter().next().unwrap().message().starts_with("3 pixels"));
}

#[test]
fn impossible_settings_are_refused() {
    let g = fisheye(20);
    let d = Settings::default;
    for settings in [
        Settings { search_radius: f64::NAN, ..d() },
        Settings { search_radius: -1.0, ..d() },
        Settings { peak_limit: Some(0.0), ..d() },
        Settings { threshold: Threshold::Fixed(f64::INFINITY), ..d() },
        Settings { threshold: Threshold::TimesTask(5.0), ..d() },
        Settings { dgp: DgpModel { constants: [f64::NAN; 3], ..DgpModel::ORIGINAL }, ..d() },
    ] {
        assert!(Analyser::new(g.clone(), settings.clone()).is_err(), "{settings:?}");
    }
    let parallel = Raster::new(View::parse("-vtl -vh 2 -vv 2").unwrap().camera().unwrap(), 10, 10).unwrap();
    assert!(PixelGeometry::new(&parallel).unwrap_err().to_string().contains("-vta"));
}

#[test]
fn veil_conserves_light_and_has_its_width() {
    for size in [100, 400, 1000] {
        let g = fisheye(size);
        let flux = |l: &[f32]| l.iter().zip(&g.solid_angles).map(|(&l, w)| f64::from(l) * w).sum::<f64>();
        let direction = towards(25.0, 33.0);
        let pixel = 180.0 / size as f64;
        // One pixel of a dark picture. Its second moment about the centre, in one direction, is then the
        // Gaussian's variance and the pixel's.
        let one = (0..g.pixel_count())
            .max_by(|&a, &b| geometry::dot(g.directions[a], direction).total_cmp(&geometry::dot(g.directions[b], direction)))
            .unwrap();
        let mut luminance = vec![0.0f32; g.pixel_count()];
        luminance[one] = 1e8;
        let before = flux(&luminance);
        veil::spread_peaks(&mut luminance, &g, 5e4, 0.533).unwrap();
        assert!((flux(&luminance) / before - 1.0).abs() < 1e-6);
        let moment: f64 = luminance
            .iter()
            .zip(&g.solid_angles)
            .zip(&g.directions)
            .map(|((&l, w), d)| f64::from(l) * w * geometry::dot(*d, g.directions[one]).clamp(-1.0, 1.0).acos().powi(2))
            .sum::<f64>();
        let sigma = (moment / before / 2.0).sqrt().to_degrees();
        let expected = (0.22634f64.powi(2) + pixel * pixel / 12.0).sqrt();
        // A coarse pixel keeps what falls into its middle.
        assert!(size == 100 || (sigma / expected - 1.0).abs() < 0.05, "{size}: {sigma} instead of {expected}");
        // At the rim the light stays inside.
        let mut rim = vec![0.0f32; g.pixel_count()];
        paint(&mut rim, &g, towards(90.0 - pixel, 0.0), pixel, 1e7);
        let before = flux(&rim);
        veil::spread_peaks(&mut rim, &g, 5e4, 0.533).unwrap();
        assert!(before > 0.0 && (flux(&rim) / before - 1.0).abs() < 1e-6);
        // Pixels of a picture.
        let mut picture = vec![800.0f32; g.pixel_count()];
        paint(&mut picture, &g, direction, pixel.max(0.2667), 1e8);
        let before = flux(&picture);
        let dim: f64 = picture.iter().zip(&g.solid_angles).filter(|(l, _)| **l < 1e4).map(|(&l, w)| f64::from(l) * w).sum();
        veil::spread_peaks(&mut picture, &g, 5e4, 0.533).unwrap();
        assert!((flux(&picture) / before - 1.0).abs() < 1e-6 && dim < before);
        assert!(picture.iter().fold(0.0f32, |a, &b| a.max(b)) < 1e8);
        assert!(veil::spread_peaks(&mut picture, &g, 5e4, f64::NAN).is_err());
    }
}
