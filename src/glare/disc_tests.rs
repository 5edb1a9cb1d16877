use super::geometry::dot;
use super::tests::{fisheye, paint, towards, view};
use super::*;
use crate::units::cap_solid_angle;
use std::f64::consts::PI;

const SUN_RADIUS: f64 = 0.533 / 2.0;

fn sun(azimuth: f64, altitude: f64, luminance: f64) -> Disc {
    Disc { direction: towards(azimuth, altitude), luminance, solid_angle: cap_solid_angle(SUN_RADIUS.to_radians()), error: 0.0 }
}

fn analyser(size: usize, settings: Settings) -> Analyser {
    Analyser::new(fisheye(size), settings).unwrap()
}

/// DGP of discs above the line of sight in a uniform field, by the published formulas (Wienold and
/// Christoffersen 2006 with today's constants; Guth's position index).
fn published(discs: &[([f64; 2], f64, f64)], field: f64) -> f64 {
    let direction = |[azimuth, altitude]: [f64; 2]| towards(azimuth, altitude);
    let illuminance = field * PI + discs.iter().map(|&(at, l, w)| l * w * direction(at)[1]).sum::<f64>();
    let mut sum = 0.0;
    for &(at, l, w) in discs {
        let [x, y, z] = direction(at);
        let (tau, sigma) = (x.abs().atan2(z).to_degrees(), y.acos().to_degrees());
        let position = ((35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp()) / 1000.0 * sigma
            + (21.0 + 0.26667 * tau - 0.002963 * tau * tau) / 100_000.0 * sigma * sigma)
            .exp()
            .min(16.0);
        sum += l * l * w / (illuminance.powf(1.87) * position * position);
    }
    (5.87e-5 * illuminance + 0.092 * (1.0 + sum).log10() + 0.159).min(1.0)
}

#[test]
fn a_sun_alone_has_the_dgp_of_the_formula_whatever_the_pixels() {
    let omega = 2.0 * PI * (1.0 - SUN_RADIUS.to_radians().cos());
    const SAME: f64 = 1e-9;
    let mut worst = 0.0f64;
    for (at, luminance) in [([0.0, 20.0], 2e7), ([30.0, 15.0], 5e7), ([-60.0, 40.0], 1e8), ([0.0, 85.0], 1e9)] {
        let expected = published(&[(at, luminance, omega)], 0.0);
        for size in [16, 64, 200, 800] {
            let black = vec![0.0; size * size];
            let glare = analyser(size, Settings::default()).analyse_with_discs(&black, &[sun(at[0], at[1], luminance)], None).unwrap();
            worst = worst.max((glare.indices.dgp - expected).abs());
            assert!(worst < SAME, "{at:?}, {size}: {} {expected}", glare.indices.dgp);
            let illuminance = luminance * omega * towards(at[0], at[1])[1];
            assert!((glare.vertical_illuminance / illuminance - 1.0).abs() < 1e-9);
            assert_eq!((glare.sources.len(), glare.direct_illuminance), (1, glare.vertical_illuminance));
        }
    }
    crate::testing::measured("disc-formula", &format!("within {}", crate::testing::short(worst)), &crate::testing::short(SAME));
}

#[test]
fn half_a_disc_has_half_the_solid_angle_not_half_the_luminance() {
    let whole = sun(10.0, 25.0, 3e7);
    let half = Disc { solid_angle: whole.solid_angle / 2.0, ..whole };
    let field = vec![500.0; 64 * 64];
    let found = analyser(64, Settings::default()).analyse_with_discs(&field, &[half], None).unwrap();
    // The field's illuminance is that of pixels, a little less than π.
    let own = analyser(64, Settings::default()).analyse(&field, None).unwrap().vertical_illuminance / PI;
    let expected = published(&[([10.0, 25.0], 3e7, half.solid_angle)], own);
    assert!((found.indices.dgp - expected).abs() < 1e-9, "{} {expected}", found.indices.dgp);
    // The error of what is seen is that of the formula's light and contrast together.
    let uncertain = Disc { error: 0.01, ..half };
    assert!((uncertain.with_more_seen().solid_angle / half.solid_angle - 1.01).abs() < 1e-12);
}

#[test]
fn images_of_the_sun_are_sources_each_at_its_own_place() {
    let omega = cap_solid_angle(SUN_RADIUS.to_radians());
    let discs = [sun(0.0, 30.0, 1e7), sun(20.0, 10.0, 4e6), sun(-35.0, 5.0, 2e6)];
    let found = analyser(100, Settings::default()).analyse_with_discs(&vec![0.0; 10_000], &discs, None).unwrap();
    let expected = published(&[([0.0, 30.0], 1e7, omega), ([20.0, 10.0], 4e6, omega), ([-35.0, 5.0], 2e6, omega)], 0.0);
    assert!((found.indices.dgp - expected).abs() < 1e-9, "{} {expected}", found.indices.dgp);
    assert_eq!(found.sources.len(), 3);
    assert!(found.sources.iter().all(|s| s.is_peak && s.pixels.is_empty()));
}

#[test]
fn a_sun_at_the_border_lights_what_it_can_and_behind_it_is_nothing() {
    let black = vec![0.0; 64 * 64];
    let of = |azimuth: f64| analyser(64, Settings::default()).analyse_with_discs(&black, &[sun(azimuth, 0.0, 1e9)], None).unwrap();
    let mut last = f64::INFINITY;
    for azimuth in [80.0, 85.0, 88.0, 89.0, 89.7, 89.99] {
        let glare = of(azimuth);
        let expected = published(&[([azimuth, 0.0], 1e9, cap_solid_angle(SUN_RADIUS.to_radians()))], 0.0);
        assert!((glare.indices.dgp - expected).abs() < 1e-9, "{azimuth}: {} {expected}", glare.indices.dgp);
        assert!(glare.vertical_illuminance < last && glare.sources.len() == 1);
        last = glare.vertical_illuminance;
    }
    for azimuth in [90.01, 120.0, 180.0] {
        let glare = of(azimuth);
        assert_eq!((glare.vertical_illuminance, glare.average_luminance, glare.sources.len()), (0.0, 0.0, 0));
    }
}

#[test]
fn threshold_field_of_view_and_task_hold_for_discs() {
    let field = vec![100.0; 64 * 64];
    let dim = sun(10.0, 20.0, 1900.0);
    let whole = analyser(64, Settings::default());
    let glare = whole.analyse_with_discs(&field, &[dim, sun(75.0, 0.0, 2100.0)], None).unwrap();
    assert_eq!(glare.sources.len(), 1);
    let lux = |d: &Disc| d.flux() * d.direction[1];
    let without = whole.analyse(&field, None).unwrap();
    let more = glare.vertical_illuminance - without.vertical_illuminance;
    assert!((more / (lux(&dim) + lux(&sun(75.0, 0.0, 2100.0))) - 1.0).abs() < 1e-6);
    // Both eyes do not see 75° aside.
    let both = analyser(64, Settings { field_of_view: FieldOfView::Binocular, ..Settings::default() });
    let one = sun(75.0, 0.0, 1e8);
    let glare = both.analyse_with_discs(&field, &[one], None).unwrap();
    assert!(glare.sources.is_empty() && glare.vertical_illuminance > 1000.0);
    // A disc in the task area raises its mean.
    let task = TaskArea { x: 32.0, y: 32.0, opening_angle: 0.6 };
    let by_task = analyser(64, Settings { task: Some(task), threshold: Threshold::TimesTask(5.0), ..Settings::default() });
    let [inside, outside] = [3.0, 60.0].map(|azimuth| by_task.analyse_with_discs(&field, &[sun(azimuth, 0.0, 1e6)], None).unwrap());
    assert!((outside.task_luminance.unwrap() - 100.0).abs() < 1e-3);
    let area: f64 = by_task.task_pixels().iter().map(|&p| by_task.geometry().solid_angles[p as usize]).sum();
    let expected = 100.0 + 1e6 * cap_solid_angle(SUN_RADIUS.to_radians()) / area;
    assert!((inside.task_luminance.unwrap() / expected - 1.0).abs() < 1e-6, "{:?} {expected}", inside.task_luminance);
    // Peaks left in their sources: the disc is a source all the same.
    let no_peaks = analyser(64, Settings { peak_limit: None, ..Settings::default() });
    assert_eq!(no_peaks.analyse_with_discs(&field, &[one], None).unwrap().sources.len(), 1);
    assert!(whole.analyse_with_discs(&field, &[Disc { luminance: f64::NAN, ..one }], None).is_err());
}

/// A veil over a disc, by pixels of 0.04° that hold the disc, and by the integral.
#[test]
fn a_veil_over_a_disc_is_that_of_fine_pixels() {
    let g = view("-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 16 -vv 16", 400, 400);
    let (peak_limit, threshold) = (5e4, 2000.0);
    let cases = [(1e8, 0.533, 1.0), (3e7, 0.2, 1.0), (1e9, 2.0, 1.0), (2e6, 0.533, 1.0), (4e4, 0.533, 1.0), (1e8, 0.533, 0.3)];
    for (luminance, width, share) in cases {
        let radius = (SUN_RADIUS.to_radians() * f64::sqrt(share)).to_degrees();
        let disc = Disc { solid_angle: cap_solid_angle(radius.to_radians()), ..sun(0.0, 0.0, luminance) };
        let mut picture = vec![0.0f32; g.pixel_count()];
        paint(&mut picture, &g, [0.0, 1.0, 0.0], radius, luminance);
        let flux = |l: &[f32]| l.iter().zip(&g.solid_angles).map(|(&l, w)| f64::from(l) * w).sum::<f64>();
        // Pixels cut the rim roughly: the light is that of the disc.
        let scale = disc.flux() / flux(&picture);
        picture.iter_mut().for_each(|l| *l *= scale as f32);
        veil::spread_peaks(&mut picture, &g, 1.0, width).unwrap();
        let parts = veil::spread_disc(&disc, width, peak_limit, threshold).unwrap();
        let mut found = parts.iter();
        for [low, high] in [[peak_limit, f64::INFINITY], [threshold, peak_limit]] {
            let pixels = (0..g.pixel_count()).filter(|&p| (low..high).contains(&f64::from(picture[p])));
            let (w, f) = pixels.fold((0.0, 0.0), |(w, f), p| (w + g.solid_angles[p], f + f64::from(picture[p]) * g.solid_angles[p]));
            // Pixels are spread to four standard deviations, where a Gaussian is 1/3000: what is dimmer ends there.
            if w == 0.0 || (low == threshold && luminance > 5e6) {
                continue;
            }
            let part = found.next().expect("a part where pixels have one");
            // Of L²ω only the logarithm counts: 5 % are 0.002 of DGP.
            let (a, b) = (part.luminance.powi(2) * part.solid_angle, f * f / w);
            println!("{luminance:e}, {width}: {:.3e} sr and {w:.3e}, {a:.3e} and {b:.3e}", part.solid_angle);
            assert!((a / b - 1.0).abs() < 0.05, "{luminance:e}, {width}°: {a} {b}");
            assert!((part.solid_angle / w - 1.0).abs() < 0.05);
        }
        assert!(found.next().is_none() || luminance > 5e6);
    }
    // A narrow veil leaves the disc's light in the disc and a rim of a few of its widths.
    let disc = sun(0.0, 0.0, 1e8);
    let sharp = veil::spread_disc(&disc, 0.01, peak_limit, threshold).unwrap()[0];
    assert!((sharp.flux() / disc.flux() - 1.0).abs() < 1e-3);
    assert!(sharp.solid_angle > disc.solid_angle && sharp.solid_angle < cap_solid_angle((SUN_RADIUS + 0.02).to_radians()), "{sharp:?}");
    assert!(veil::spread_disc(&disc, 0.0, peak_limit, threshold).is_err());
}

#[test]
fn a_picture_with_the_sun_on_coarse_pixels_is_doubted_and_a_window_is_not() {
    let disc = sun(12.0, 25.0, 4e7);
    let field = |g: &PixelGeometry| vec![1500.0f32; g.pixel_count()];
    for size in [64, 100, 200, 300] {
        let analyser = analyser(size, Settings::default());
        let g = analyser.geometry().clone();
        let mut picture = field(&g);
        // All of the sun's light in the pixel it falls into.
        let pixel = (0..g.pixel_count())
            .max_by(|&a, &b| dot(g.directions[a], disc.direction).total_cmp(&dot(g.directions[b], disc.direction)))
            .unwrap();
        picture[pixel] += (disc.flux() / g.solid_angles[pixel]) as f32;
        let glare = analyser.analyse(&picture, None).unwrap();
        let right = analyser.analyse_with_discs(&field(&g), &[disc], None).unwrap().indices.dgp;
        let doubt = analyser.doubt_of_coarse_sun(&picture, &glare, None).expect("the sun on a coarse pixel").to_string();
        assert!(right - glare.indices.dgp > 0.01, "{size}: {right} {}", glare.indices.dgp);
        // The warning tells what is right, but for where in the pixel the sun stands.
        let told: f64 = doubt.split("DGP of ").nth(1).unwrap()[..5].parse().unwrap();
        assert!((told - right).abs() < 0.005, "{size}: {doubt}; {right}");
    }
    let fine = view("-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 60 -vv 60", 1200, 1200);
    let mut picture = field(&fine);
    paint(&mut picture, &fine, disc.direction, SUN_RADIUS, disc.luminance);
    let of_fine = Analyser::new(fine, Settings::default()).unwrap();
    assert!(of_fine.doubt_of_coarse_sun(&picture, &of_fine.analyse(&picture, None).unwrap(), None).is_none());
    // Neither a bright window nor a lamp is a sun.
    let analyser = analyser(100, Settings::default());
    let g = analyser.geometry().clone();
    for (radius, luminance) in [(15.0, 2e4), (3.0, 1e5), (0.9, 2e5)] {
        let mut picture = field(&g);
        paint(&mut picture, &g, disc.direction, radius, luminance);
        assert!(analyser.doubt_of_coarse_sun(&picture, &analyser.analyse(&picture, None).unwrap(), None).is_none(), "{radius} {luminance}");
    }
}
