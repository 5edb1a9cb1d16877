use super::*;
use crate::camera::View;
use crate::kernels::trace::rooms::asymmetric;
use crate::kernels::view_matrix::reference::view_row;
use crate::progress::Silent;
use glam::DVec3;
use std::f64::consts::PI;

/// All tiles of a picture.
#[derive(Default)]
pub(super) struct Picture {
    pixels: usize,
    pub values: Vec<f32>,
    pub standard_error: Vec<f32>,
    pub direct_view: Vec<f32>,
    pub batches: Vec<f32>,
    /// Of all bins of a pixel, green.
    pub doubts: Vec<f64>,
}

fn picture(device: &Device, raster: &Raster, options: &ImageOptions) -> Picture {
    let (scene, window) = asymmetric();
    picture_of(device, &scene, &[window], raster, options)
}

pub(super) fn picture_of(device: &Device, scene: &Scene, windows: &[Window], raster: &Raster, options: &ImageOptions) -> Picture {
    let mut all = Picture::default();
    compute(device, scene, windows, raster, options, &Silent, &mut |rows| {
        assert_eq!(rows.first, all.pixels, "tiles come in order");
        all.pixels += rows.pixels;
        let bins = rows.values.len() / 3 / rows.pixels;
        all.doubts.extend((0..rows.pixels).map(|p| (0..bins).map(|b| rows.doubts.of(p, b, 1)).sum::<f64>()));
        all.values.extend(rows.values);
        all.standard_error.extend(rows.standard_error);
        all.direct_view.extend(rows.direct_view);
        all.batches.extend(rows.batches);
        Ok(())
    })
    .unwrap();
    assert_eq!(all.pixels, raster.len());
    all
}

pub(super) fn raster(options: &str, size: usize) -> Raster {
    Raster::new(View::parse(options).unwrap().camera().unwrap(), size, size).unwrap()
}

#[test]
fn pixels_agree_with_the_reference_at_their_surface_points() {
    let Some(device) = Device::for_tests("view matrix of a picture") else { return };
    let (scene, window) = asymmetric();
    // Looking north at the back wall (y = 5, reflectance 0.6), all samples through the centres.
    let raster = raster("-vtv -vp 2 1 1.5 -vd 0 1 0 -vu 0 0 1 -vh 20 -vv 20", 3);
    let options = ImageOptions {
        bounces: Some(3),
        jitter: 0.0,
        batches: 8,
        window_samples: 2048,
        traced_every: 1,
        light_paths: 512,
        visibility_rays: 64,
        near_samples: 256,
        ..ImageOptions::default()
    };
    let rows = picture(&device, &raster, &options);
    for pixel in [0, 4, 8] {
        let ray = raster.ray(pixel % 3, pixel / 3).unwrap();
        let point = ray.origin + ray.direction * ((5.0 - ray.origin.y) / ray.direction.y);
        let samples = 300_000;
        let position = point - DVec3::Y * 1e-6;
        let row = view_row(&scene, std::slice::from_ref(&window), position, DVec3::NEG_Y, 3, samples, 3 + pixel as u64);
        let (mut squares, mut count) = (0.0, 0.0);
        let (mut sum, mut sum_reference, mut variance) = (0.0, 0.0, 0.0);
        for bin in 0..145 {
            for c in 0..3 {
                let scale = 0.6 / PI;
                let expected = row[bin][c].mean(samples) * scale;
                let value = f64::from(rows.values[(pixel * 145 + bin) * 3 + c]);
                let error = f64::from(rows.standard_error[(pixel * 145 + bin) * 3 + c]).hypot(row[bin][c].standard_error(samples) * scale);
                sum += value;
                sum_reference += expected;
                variance += error * error;
                if row[bin][c].mean(samples) * samples as f64 > 100.0 {
                    squares += ((value - expected) / error).powi(2);
                    count += 1.0;
                }
            }
        }
        println!("pixel {pixel}: {count} entries, mean z² {:.2}, sums {sum:.5} {sum_reference:.5}", squares / count);
        assert!(count > 20.0 && squares / count < 2.0, "pixel {pixel}: mean z² {}", squares / count);
        assert!((sum - sum_reference).abs() < 5.0 * variance.sqrt(), "pixel {pixel}: {sum} and {sum_reference}");
    }
}

#[test]
fn a_window_seen_directly_is_exact() {
    let Some(device) = Device::for_tests("windows in a picture") else { return };
    let (_, window) = asymmetric();
    // From 1 m inside, straight at the window's middle: every pixel sees nothing else.
    let raster = raster("-vtv -vp 1.25 1 1.75 -vd 0 -1 0 -vu 0 0 1 -vh 30 -vv 30", 4);
    let rows = picture(&device, &raster, &ImageOptions { bounces: Some(0), jitter: 0.0, ..ImageOptions::default() });
    for pixel in 0..16 {
        let ray = raster.ray(pixel % 4, pixel / 4).unwrap();
        let bin = window.basis.bin_of(window.frame.to_local(-ray.direction));
        for b in 0..145 {
            let expected = if b == bin { 1.0 } else { 0.0 };
            assert!((rows.values[(pixel * 145 + b) * 3] - expected).abs() < 1e-6, "pixel {pixel} bin {b}");
        }
    }
    assert_eq!(rows.values, rows.direct_view);
    assert!(rows.standard_error.iter().all(|&e| e == 0.0));
}

#[test]
fn equal_seeds_give_equal_bits_whatever_the_tile_and_the_outside_stays_black() {
    let Some(device) = Device::for_tests("tiles of a picture") else { return };
    let raster = raster("-vta -vp 2 3 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180", 12);
    let options = ImageOptions { bounces: Some(3), window_samples: 16, ..ImageOptions::default() };
    let whole = picture(&device, &raster, &options);
    // Memory for seven pixels.
    let tiled = picture(&device, &raster, &ImageOptions { memory: 7 * (4 * 145 * 56 + 145 * 12 + 16 * 32) + 1, ..options });
    assert_eq!(whole.values, tiled.values);
    assert_eq!(whole.standard_error, tiled.standard_error);
    for (pixel, row) in whole.values.chunks_exact(145 * 3).enumerate() {
        let lit = row.iter().any(|&v| v > 0.0);
        assert_eq!(lit, raster.is_seen(pixel % 12, pixel / 12), "pixel {pixel}");
    }
}
