//! EXR files: what comes back, what other readers see, what is refused.

use super::*;
use crate::error::Warnings;
use crate::image::Picture;

fn picture(width: usize, height: usize, seed: f32) -> Picture {
    let pixels = (0..width * height).map(|i| [(i as f32 * 0.37 + seed).sin().abs() * 50.0, i as f32 * 0.01 + seed, 1e-3]).collect();
    let mut picture = Picture::new(width, height, pixels).unwrap();
    picture.view = Some("-vta -vp 1 2 3 -vh 180 -vv 180".into());
    picture.header = vec!["rpict room.oct".into(), "SOFTWARE= test".into()];
    picture
}

const FLOAT_RGB: Options = Options { samples: Samples::Float, channels: Channels::Rgb };

#[test]
fn float_is_exact_and_half_within_its_precision() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let original = picture(37, 53, 1.0);
    let mut warnings = Warnings::new();
    write(&path, &original, FLOAT_RGB, &mut warnings).unwrap();
    // whiteLuminance is f32, 179 exactly.
    assert_eq!(read(&path).unwrap(), original);
    assert_eq!(crate::image::read(&path).unwrap(), original);

    write(&path, &original, Options { samples: Samples::Half, channels: Channels::Rgb }, &mut warnings).unwrap();
    for (a, b) in read(&path).unwrap().pixels.iter().flatten().zip(original.pixels.iter().flatten()) {
        assert!((a - b).abs() <= b / 2048.0, "{a} {b}");
    }
    for samples in [Samples::Half, Samples::Float] {
        write(&path, &original, Options { samples, channels: Channels::Luminance }, &mut warnings).unwrap();
        let grey = read(&path).unwrap();
        let precision = if samples == Samples::Half { 1.0 / 2048.0 } else { 1e-6 };
        for (a, b) in grey.pixels.iter().zip(&original.pixels) {
            let (a, b) = (crate::image::luminance(*a), crate::image::luminance(*b));
            assert!((a - b).abs() <= b * precision, "{a} {b}");
        }
    }
    assert!(warnings.is_empty());
}

/// The crate's own reader, which goes by names, sees the same colours, and the metadata say what
/// the numbers are.
#[test]
fn other_readers_see_the_same() {
    use ::exr::prelude::{AttributeValue, Text};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let original = picture(7, 5, 1.0);
    write(&path, &original, FLOAT_RGB, &mut Warnings::new()).unwrap();
    let read = ::exr::prelude::read_first_rgba_layer_from_file(
        &path,
        |size, _| vec![[0f32; 3]; size.area()],
        |pixels: &mut Vec<[f32; 3]>, at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * 7 + at.x()] = [r, g, b],
    )
    .unwrap();
    assert_eq!(read.layer_data.channel_data.pixels, original.pixels);
    assert_eq!(read.layer_data.attributes.white_luminance, Some(179.0));
    assert_eq!(read.layer_data.attributes.other[&b"VIEW"[..]], AttributeValue::Text(Text::from(original.view.as_deref().unwrap())));
    assert_eq!(read.attributes.chromaticities.unwrap().green.x(), 0.29);

    write(&path, &original, Options { samples: Samples::Float, channels: Channels::Luminance }, &mut Warnings::new()).unwrap();
    let read = ::exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
    let channel = &read.layer_data.channel_data.list[0];
    assert!(channel.name.eq("Y"));
    let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
    assert_eq!(values, original.luminance(), "cd/m²");
}

#[test]
fn too_large_for_half_is_said_and_nan_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut picture = picture(5, 4, 0.0);
    picture.pixels[7] = [1e5, 7e6, 1.0];
    let mut warnings = Warnings::new();
    write(&path, &picture, Options { samples: Samples::Half, channels: Channels::Rgb }, &mut warnings).unwrap();
    assert!(warnings.iter().next().unwrap().to_string().contains("2 samples"));
    assert_eq!(read(&path).unwrap().pixels[7], [65504.0, 65504.0, 1.0]);
    picture.pixels[7][2] = f32::NAN;
    let before = std::fs::read(&path).unwrap();
    let error = write(&path, &picture, FLOAT_RGB, &mut warnings).unwrap_err().to_string();
    assert!(error.contains("pixel 2, 1"), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), before, "the old file is untouched");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn parts_are_streamed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("year.exr");
    let hours = [1164, 1929, 7067];
    let parts = Parts {
        width: 40,
        height: 33,
        view: Some("-vtv -vh 60".into()),
        header: Vec::new(),
        names: hours.iter().map(|h| format!("hour_{h}")).collect(),
    };
    let mut warnings = Warnings::new();
    write_parts(&path, &parts, FLOAT_RGB, &mut warnings, |put| hours.iter().try_for_each(|&h| put(&picture(40, 33, h as f32).pixels)))
        .unwrap();
    let listed = super::parts(&path).unwrap();
    assert_eq!(listed[1], Part { name: Some("hour_1929".into()), width: 40, height: 33, view: parts.view.clone() });
    for (i, &h) in hours.iter().enumerate() {
        let read = read_part(&path, i).unwrap();
        assert_eq!(read.pixels, picture(40, 33, h as f32).pixels);
        assert_eq!(read.view, parts.view);
    }
    assert!(read(&path).unwrap_err().to_string().contains("3 parts"));
    assert!(read_part(&path, 3).is_err());

    let fails = |parts: &Parts, count: usize, expected: &str| {
        let path = folder.path().join("bad.exr");
        let result = write_parts(&path, parts, FLOAT_RGB, &mut Warnings::new(), |put| {
            (0..count).try_for_each(|i| put(&picture(40, 33, i as f32).pixels))
        });
        let error = result.unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert!(!path.exists());
    };
    fails(&parts, 2, "only 2 of 3");
    fails(&parts, 4, "more than 3");
    fails(&Parts { width: 41, ..parts.clone() }, 3, "1320 pixels are not 41 × 33");
    fails(&Parts { names: vec!["a".into(), "a".into()], ..parts.clone() }, 2, "named 'a'");
    fails(&Parts { names: Vec::new(), ..parts.clone() }, 0, "at least one part");
}

#[test]
fn damaged_files_are_errors_never_panics() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, &picture(20, 20, 1.0), FLOAT_RGB, &mut Warnings::new()).unwrap();
    let good = std::fs::read(&path).unwrap();
    for length in (0..good.len()).step_by(7) {
        std::fs::write(&path, &good[..length]).unwrap();
        assert!(read(&path).is_err(), "{length} of {} bytes", good.len());
    }
    let mut state = 12345u64;
    let mut random = |limit: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % limit
    };
    for _ in 0..300 {
        let mut bytes = good.clone();
        for _ in 0..1 + random(3) {
            let at = random(bytes.len().min(900));
            bytes[at] = random(256) as u8;
        }
        std::fs::write(&path, &bytes).unwrap();
        let _ = read(&path);
        let _ = parts(&path);
    }
    std::fs::write(&path, b"#?RADIANCE\n").unwrap();
    assert!(read(&path).unwrap_err().to_string().contains("a.exr"));
}

#[test]
fn a_small_file_that_states_a_huge_picture_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.exr");
    let picture = Picture::new(4, 4, vec![[1.0; 3]; 16]).unwrap();
    write(&path, &picture, Options { samples: Samples::Half, channels: Channels::Rgb }, &mut Warnings::new()).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    const WINDOW: &[u8] = b"dataWindow\0box2i\0";
    let at = bytes.windows(WINDOW.len()).position(|w| w == WINDOW).unwrap() + WINDOW.len() + 4 + 8;
    for side in [at, at + 4] {
        bytes[side..side + 4].copy_from_slice(&16_000i32.to_le_bytes());
    }
    std::fs::write(&path, bytes).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(["cannot be in a file of", "not a valid EXR", "truncated"].iter().any(|e| error.contains(e)), "{error}");
}
