//! Pictures against the plain product, in every way of cutting the work.

use super::view::resolution;
use super::*;
use crate::image;
use crate::kernels::product::{Native, chain};
use crate::matrix::Matrix;
use crate::matrix::file::{Format, write_matrix};
use crate::progress::Silent;
use std::path::Path;

const WIDTH: usize = 12;
const HEIGHT: usize = 9;
const BINS: usize = 7;
const HOURS: [usize; 5] = [3, 1164, 20, 8000, 4];

fn values(len: usize, seed: u32) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    (0..len).map(|_| next()).collect()
}

/// V whose corners see no window, and coefficients.
fn factors() -> (Matrix<f32>, Matrix<f32>) {
    let mut v = Matrix::from_data(WIDTH * HEIGHT, BINS, 3, values(WIDTH * HEIGHT * BINS * 3, 1)).unwrap();
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            if (x as f64 - 5.5).hypot(y as f64 - 4.0) > 5.0 {
                (0..BINS).for_each(|bin| v.at_mut(y * WIDTH + x, bin).fill(0.0));
            }
        }
    }
    (v, Matrix::from_data(BINS, HOURS.len(), 3, values(BINS * HOURS.len() * 3, 2)).unwrap())
}

fn matrix_file(folder: &Path, v: &Matrix<f32>) -> String {
    let path = folder.join("v.mtx");
    let header = ["VIEW= -vta -vh 180 -vv 180".to_string(), format!("RESOLUTION=-Y {HEIGHT} +X {WIDTH}")];
    write_matrix(Some(&path), v, Format::Float, &header).unwrap();
    path.to_string_lossy().into_owned()
}

fn run(view: &mut PictureView, coefficients: &Matrix<f32>, output: &Output, memory: u64) -> Result<()> {
    let request =
        Request { coefficients, hours: &HOURS, output, header: &["made by a test".to_string()], memory, addition: None, finished: None };
    write_pictures(&Native, view, &request, &Silent, &mut Warnings::new())
}

#[test]
fn pictures_are_columns_of_the_product_whatever_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let (v, coefficients) = factors();
    let name = matrix_file(folder.path(), &v);
    let product = chain(&Native, &[&v, &coefficients]).unwrap();
    let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
    // From one line and one hour at a time to everything at once.
    let mut bytes: Option<Vec<Vec<u8>>> = None;
    for memory in [600_000u64, 800_000, 1 << 21, 1 << 30] {
        let mut view = PictureView::open(&name, None).unwrap();
        assert_eq!((view.width, view.height, view.bins), (WIDTH, HEIGHT, BINS));
        let at = |file: &str| folder.path().join(file).to_string_lossy().into_owned();
        run(&mut view, &coefficients, &Output::parse(&at("img_%04d.exr"), options).unwrap(), memory).unwrap();
        run(&mut view, &coefficients, &Output::parse(&at("img_%04d.hdr"), options).unwrap(), memory).unwrap();
        run(&mut view, &coefficients, &Output::parse(&at("all.exr"), options).unwrap(), memory).unwrap();
        let mut files = Vec::new();
        for (column, hour) in HOURS.iter().enumerate() {
            let picture = image::read(&folder.path().join(format!("img_{hour:04}.exr"))).unwrap();
            assert_eq!(picture.view.as_deref(), Some("-vta -vh 180 -vv 180"));
            for (pixel, color) in picture.pixels.iter().enumerate() {
                assert_eq!(color, product.at(pixel, column), "memory {memory}, hour {hour}, pixel {pixel}");
            }
            assert_eq!(exr::read_part(&folder.path().join("all.exr"), column).unwrap().pixels, picture.pixels);
            let hdr = image::read(&folder.path().join(format!("img_{hour:04}.hdr"))).unwrap();
            assert_eq!((hdr.width, hdr.height, hdr.view), (WIDTH, HEIGHT, picture.view));
            assert!(hdr.header.contains(&"made by a test".to_string()));
            for (a, b) in hdr.pixels.iter().zip(&picture.pixels) {
                let largest = b.iter().fold(0f32, |m, v| m.max(*v));
                assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.004 * largest), "{a:?} {b:?}");
            }
            files.push(std::fs::read(folder.path().join(format!("img_{hour:04}.hdr"))).unwrap());
        }
        let parts = exr::parts(&folder.path().join("all.exr")).unwrap();
        assert_eq!(parts[1].name.as_deref(), Some("hour_1164"));
        // Identical bytes for every way of cutting the work.
        assert!(*bytes.get_or_insert_with(|| files.clone()) == files, "memory {memory}");
    }
}

#[test]
fn component_pictures_give_what_their_decoded_matrix_gives() {
    let folder = tempfile::tempdir().unwrap();
    let (v, coefficients) = factors();
    for bin in 0..BINS {
        let pixels = (0..WIDTH * HEIGHT).map(|p| v.at(p, bin).try_into().unwrap()).collect();
        crate::image::hdr::write(&folder.path().join(format!("v{bin:03}.hdr")), &Picture::new(WIDTH, HEIGHT, pixels).unwrap()).unwrap();
    }
    let mut decoded = Matrix::zeros(WIDTH * HEIGHT, BINS, 3);
    for bin in 0..BINS {
        let picture = image::read(&folder.path().join(format!("v{bin:03}.hdr"))).unwrap();
        picture.pixels.iter().enumerate().for_each(|(p, c)| decoded.at_mut(p, bin).copy_from_slice(c));
    }
    let product = chain(&Native, &[&decoded, &coefficients]).unwrap();
    let at = |file: &str| folder.path().join(file).to_string_lossy().into_owned();
    let mut view = PictureView::open(&at("v%03d.hdr"), None).unwrap();
    let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
    run(&mut view, &coefficients, &Output::parse(&at("o%d.exr"), options).unwrap(), 700_000).unwrap();
    for (column, hour) in HOURS.iter().enumerate() {
        let picture = image::read(&folder.path().join(format!("o{hour}.exr"))).unwrap();
        assert!(picture.pixels.iter().enumerate().all(|(p, c)| c == product.at(p, column)));
    }
    std::fs::remove_file(folder.path().join("v003.hdr")).unwrap();
    assert!(PictureView::open(&at("v%03d.hdr"), None).err().unwrap().to_string().contains("v003.hdr"));
}

#[test]
fn after_an_error_no_half_picture_is_left_and_finished_ones_stay() {
    let folder = tempfile::tempdir().unwrap();
    let (v, coefficients) = factors();
    let name = matrix_file(folder.path(), &v);
    let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
    let output = Output::parse(&folder.path().join("img_%04d.hdr").to_string_lossy(), options).unwrap();
    // A folder in the way of the third hour makes its rename fail; one hour per pass.
    std::fs::create_dir(folder.path().join("img_0020.hdr")).unwrap();
    let mut view = PictureView::open(&name, None).unwrap();
    let error = run(&mut view, &coefficients, &output, 600_000).unwrap_err().to_string();
    assert!(error.contains("img_0020.hdr"), "{error}");
    let mut left: Vec<String> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    left.sort();
    assert_eq!(left, ["img_0003.hdr", "img_0020.hdr", "img_1164.hdr", "v.mtx"]);
    assert_eq!(image::read(&folder.path().join("img_0003.hdr")).unwrap().width, WIDTH);

    // V cut off after it was opened: an error that names it, and nothing written.
    std::fs::remove_dir(folder.path().join("img_0020.hdr")).unwrap();
    let mut view = PictureView::open(&name, None).unwrap();
    let bytes = std::fs::read(&name).unwrap();
    std::fs::OpenOptions::new().write(true).open(&name).unwrap().set_len(bytes.len() as u64 / 2).unwrap();
    let other = Output::parse(&folder.path().join("new_%04d.hdr").to_string_lossy(), options).unwrap();
    let error = run(&mut view, &coefficients, &other, 1 << 30).unwrap_err().to_string();
    assert!(error.contains("v.mtx"), "{error}");
    assert!(std::fs::read_dir(folder.path()).unwrap().all(|e| !e.unwrap().file_name().to_string_lossy().starts_with("new_")));
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (v, coefficients) = factors();
    let name = matrix_file(folder.path(), &v);
    let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
    let output = Output::parse(&folder.path().join("%d.hdr").to_string_lossy(), options).unwrap();
    let mut view = PictureView::open(&name, None).unwrap();
    assert!(run(&mut view, &coefficients, &output, 1000).unwrap_err().to_string().contains("--memory"));
    let other = Matrix::zeros(BINS + 1, HOURS.len(), 3);
    assert!(run(&mut view, &other, &output, 1 << 30).unwrap_err().to_string().contains("v.mtx"));
    assert!(Output::parse("picture.hdr", options).is_err());
    let bare = folder.path().join("bare.mtx");
    write_matrix(Some(&bare), &v, Format::Ascii, &[]).unwrap();
    let bare = bare.to_string_lossy().into_owned();
    assert!(PictureView::open(&bare, None).err().unwrap().to_string().contains("RESOLUTION"));
    assert!(PictureView::open(&bare, Some([WIDTH, HEIGHT + 1])).is_err());
    assert_eq!(PictureView::open(&bare, Some([WIDTH, HEIGHT])).unwrap().bins, BINS);
    for bad in ["", "-Y 3 +X", "+X 3 -Y 3", "-Y 0 +X 4", "-Y a +X 4"] {
        assert!(resolution(bad).is_err(), "{bad}");
    }
}

#[test]
fn work_is_cut_to_the_memory() {
    let line = 400 * 145 * 12;
    let sizes = Sizes::within(2 << 30, [400, 400], 4380, line, 1 << 17).unwrap();
    assert_eq!(sizes, Sizes { hours: 200, lines: 82, keep: true });
    // 4000 × 4000 pixels: V of 28 GB is read in bands.
    let large = Sizes::within(2 << 30, [4000, 4000], 8760, 4000 * 145 * 12, 1 << 17).unwrap();
    assert!(!large.keep && large.hours == 200 && large.lines >= 1);
    for (memory, hours) in [(64 << 20, 10), (256 << 20, 500), (1 << 30, 8760)] {
        let s = Sizes::within(memory, [400, 400], hours, line, 1 << 17).unwrap();
        let v = if s.keep { line * 400 } else { 3 * line * s.lines as u64 };
        let results = 3 * s.lines as u64 * 400 * 12 * s.hours as u64;
        assert!(v + results + s.hours as u64 * (1 << 17) <= memory, "{s:?}");
    }
}
