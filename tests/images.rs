//! Pictures as users handle them: the verb falsecolor.

use lucarne::Warnings;
use lucarne::image::{self, Picture, exr, hdr};
use std::path::Path;
use std::process::{Command, Output};

fn lucarne(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lucarne")).args(arguments.split_whitespace()).current_dir(folder).output().unwrap()
}

fn succeeds(folder: &Path, arguments: &str) {
    let out = lucarne(folder, arguments);
    assert!(out.status.success(), "lucarne {arguments}: {}", String::from_utf8_lossy(&out.stderr));
}

fn fails(folder: &Path, arguments: &str, expected: &str) {
    let out = lucarne(folder, arguments);
    let message = String::from_utf8_lossy(&out.stderr);
    assert!(!out.status.success() && message.contains(expected), "lucarne {arguments}: {message}");
}

/// Width, height and colours of a PNG file.
fn png(path: &Path) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap())).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    (info.width, info.height, data)
}

/// A picture whose luminance rises from left to right up to 2000 cd/m².
fn ramp() -> Picture {
    let (width, height) = (400, 320);
    let pixels = (0..width * height).map(|i| [(2000.0 * ((i % width) as f32 + 0.5) / width as f32) / 179.0; 3]).collect();
    Picture::new(width, height, pixels).unwrap()
}

#[test]
fn falsecolor_takes_the_options_of_users_and_of_radiance() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    hdr::write(&at("img.hdr"), &ramp()).unwrap();
    succeeds(folder.path(), "falsecolor img.hdr --scale 2000 --log 3 -o img.png");
    let (width, height, data) = png(&at("img.png"));
    assert!(width > 450 && height > 320);
    // The pixel at 200 cd/m², two of three decades up: position 2/3 of viridis.
    let place = (12 + 160) * width as usize + 12 + 40;
    let expected = image::palette::Palette::Viridis.color(2.0 / 3.0);
    for (a, b) in data[place * 3..][..3].iter().zip(expected) {
        assert!(a.abs_diff(b) <= 4, "{:?} {expected:?}", &data[place * 3..][..3]);
    }
    for options in [
        "-ip img.hdr -cl -s auto -n 5",
        "-i img.hdr -p img.hdr -cb -log 2 -s 2000",
        "img.hdr -cp -pal def -l lx -m 179 -e",
        "img.hdr --no-legend --palette hot",
    ] {
        succeeds(folder.path(), &format!("falsecolor {options} -o other.png"));
        png(&at("other.png"));
    }
    succeeds(folder.path(), "falsecolor img.hdr -o img.svg");
    assert!(std::fs::read_to_string(at("img.svg")).unwrap().starts_with("<svg"));

    let half = exr::Options { samples: exr::Samples::Half, channels: exr::Channels::Luminance };
    exr::write(&at("img.exr"), &ramp(), half, &mut Warnings::new()).unwrap();
    succeeds(folder.path(), "falsecolor img.exr --scale 2000 --log 3 -o exr.png");
    let (_, _, other) = png(&at("exr.png"));
    let different = data.iter().zip(&other).filter(|(a, b)| a.abs_diff(**b) > 4).count();
    assert!(different * 100 < data.len(), "the same picture from EXR: {different} bytes differ");
}

#[test]
fn falsecolor_says_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    hdr::write(&at("img.hdr"), &ramp()).unwrap();
    let bytes = std::fs::read(at("img.hdr")).unwrap();
    std::fs::write(at("cut.hdr"), &bytes[..bytes.len() / 2]).unwrap();
    std::fs::write(at("text.hdr"), "hello\n\nis this a picture?\naaaa").unwrap();
    fails(folder.path(), "falsecolor none.hdr -o a.png", "none.hdr");
    fails(folder.path(), "falsecolor cut.hdr -o a.png", "cut.hdr: scanline");
    fails(folder.path(), "falsecolor text.hdr -o a.png", "not a Radiance picture");
    fails(folder.path(), "falsecolor img.hdr -o a.gif", ".png or .svg");
    fails(folder.path(), "falsecolor img.hdr -s 0 -o a.png", "scale");
    fails(folder.path(), "falsecolor img.hdr -s lots -o a.png", "no number");
    fails(folder.path(), "falsecolor img.hdr -pal jet -o a.png", "viridis");
    fails(folder.path(), "falsecolor img.hdr -log 0 -s 100 -o a.png", "decades");
    fails(folder.path(), "falsecolor -o a.png", "PICTURE");
    assert!(!at("a.png").exists() && !at("a.gif").exists());
}
