//! A million pixels, and a sun of 10⁹ beside a sky of 1.

use super::tests::{OF_PICTURE, analyser, compare, detectors, expected, run};
use super::*;
use crate::glare::Settings;
use crate::testing::{measured, short};
use crate::units::LUMINOUS_EFFICACY;
use std::f64::consts::PI;

#[test]
fn a_million_pixels_sum_up_and_a_sun_does_not_drown_the_sky() {
    let size = 1000;
    let analyser = analyser(size, size, Settings::default());
    // All pixels see the sky, a few the sun as well, 40° above the horizon.
    let sun = [0.0, 40f64.to_radians().cos(), 40f64.to_radians().sin()];
    let geometry = analyser.geometry();
    let is_sun = |pixel: usize| geometry.directions[pixel].iter().zip(sun).map(|(a, b)| a * b).sum::<f64>() > 0.5f64.to_radians().cos();
    let mut view = Matrix::zeros(size * size, 2, 3);
    for pixel in 0..size * size {
        view.at_mut(pixel, 0).fill(1.0);
        view.at_mut(pixel, 1).fill(f32::from(is_sun(pixel)));
    }
    let hours = [[1.0, 1e9], [1.0, 0.0], [1e-3, 0.0], [0.0, 0.0], [1e-30, 1e-20], [1e9, 1e9]];
    let right = Matrix::from_data(2, hours.len(), 3, (0..2).flat_map(|bin| hours.iter().flat_map(move |h| [h[bin]; 3])).collect()).unwrap();
    const HEMISPHERE: f64 = 1e-4;
    let mut worst = [0.0f64; 2];
    for detector in detectors("a million pixels") {
        let found = run(&*detector, &analyser, &[&view], StackOptions::default(), &Year::new(&[&right]));
        for (hour, ([sky, sun], found)) in hours.iter().zip(&found).enumerate() {
            let picture: Vec<f64> =
                (0..size * size).map(|p| LUMINOUS_EFFICACY * (f64::from(*sky) + if is_sun(p) { f64::from(*sun) } else { 0.0 })).collect();
            let what = format!("{}, hour {hour}", detector.description());
            let wanted = expected(&analyser, &picture);
            compare(&what, found, &wanted);
            if wanted.vertical_illuminance > 1.0 {
                worst[0] = worst[0].max((found.vertical_illuminance / wanted.vertical_illuminance - 1.0).abs());
            }
            for value in [found.indices.dgp, found.indices.ugr, found.indices.dgi, found.average_luminance, found.vertical_illuminance] {
                assert!(value.is_finite(), "{what}: {value}");
            }
            if *sun == 0.0 {
                // A hemisphere of one luminance: π times that.
                let exact = PI * LUMINOUS_EFFICACY * f64::from(*sky);
                assert!(
                    (found.vertical_illuminance - exact).abs() <= HEMISPHERE * exact,
                    "{what}: {} of {exact}",
                    found.vertical_illuminance
                );
                if exact > 0.0 {
                    worst[1] = worst[1].max((found.vertical_illuminance / exact - 1.0).abs());
                }
            }
        }
    }
    measured("million-pixels", &worst.map(short).join("; "), &[OF_PICTURE, HEMISPHERE].map(short).join("; "));
}
