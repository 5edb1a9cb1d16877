use super::*;
use crate::testing::{output, radiance};

/// Numbers in 0…1 from a fixed sequence.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

/// A picture with everything the encoder distinguishes: long and short runs, literals, black,
/// negative components, many exponents.
fn picture(width: usize, height: usize) -> Picture {
    let mut seed = (width * 1000 + height) as u64;
    let mut pixels = Vec::new();
    while pixels.len() < width * height {
        let magnitude = 10f64.powf(random(&mut seed) * 12.0 - 6.0);
        let mut color = [0; 3].map(|_| (random(&mut seed) * magnitude) as f32);
        match (random(&mut seed) * 8.0) as usize {
            0 => color = [0.0; 3],
            1 => color[1] = -color[1],
            2 => color[2] = 0.0,
            _ => {}
        }
        let run = match (random(&mut seed) * 6.0) as usize {
            0 => 2,
            1 => 3,
            2 => 4,
            3 => (random(&mut seed) * 300.0) as usize,
            _ => 1,
        };
        pixels.extend(std::iter::repeat_n(color, run));
    }
    pixels.truncate(width * height);
    Picture::new(width, height, pixels).unwrap()
}

fn file(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> std::path::PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn body(bytes: &[u8]) -> &[u8] {
    let empty = bytes.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
    let line = bytes[empty..].iter().position(|&b| b == b'\n').unwrap() + 1;
    &bytes[empty + line..]
}

fn floats(bytes: &[u8]) -> Vec<[f32; 3]> {
    bytes.chunks_exact(12).map(|c| [0, 4, 8].map(|i| f32::from_le_bytes(c[i..i + 4].try_into().unwrap()))).collect()
}

#[test]
fn writes_the_bytes_radiance_writes_and_decodes_as_pvalue() {
    let folder = tempfile::tempdir().unwrap();
    for (width, height) in [(1, 1), (7, 3), (16, 4), (17, 4), (130, 9), (400, 30), (1031, 5)] {
        let Some(mut pvalue) = radiance("pvalue") else { return };
        let picture = picture(width, height);
        let raw: Vec<u8> = picture.pixels.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let input = file(&folder, "in.raw", &raw);
        let theirs = output(pvalue.args(["-r", "-h", "-df", "-y", &height.to_string(), "+x", &width.to_string()]).arg(&input));
        let ours = encode(&picture).unwrap();
        assert!(body(&ours) == body(&theirs), "{width} × {height}: different bytes");

        let path = file(&folder, "ours.hdr", &ours);
        let values = floats(&output(radiance("pvalue").unwrap().args(["-h", "-H", "-df"]).arg(&path)));
        let read_back = read(&path).unwrap();
        assert_eq!(read_back.pixels, values);
        assert_eq!(encode(&read_back).unwrap(), ours, "decoded pixels encode to the same bytes");
    }
}

#[test]
fn rounding_and_limits() {
    assert_eq!(to_rgbe([1.0, 0.5, 0.25]).unwrap(), [128, 64, 32, 129]);
    assert_eq!(from_rgbe([128, 64, 32, 129]), [257.0 / 256.0, 129.0 / 256.0, 65.0 / 256.0]);
    assert_eq!(to_rgbe([1e-33, -5.0, 0.0]).unwrap(), [0; 4]);
    assert_eq!(to_rgbe([-1.0, 3.0, 0.0]).unwrap(), [0, 192, 0, 130]);
    assert_eq!(from_rgbe([255, 0, 0, 0]), [0.0; 3]);
    for e in 1..=255u8 {
        let expected = 128.5 * 2f64.powi(i32::from(e) - 136);
        assert_eq!(f64::from(from_rgbe([128, 0, 0, e])[0]), expected, "exponent {e}");
        assert_eq!(f64::from(from_rgbe([128, 0, 0, e])[1]), 0.5 * 2f64.powi(i32::from(e) - 136), "exponent {e}");
    }
    assert_eq!(to_rgbe([f32::from_bits(0x7effffff), 0.0, 0.0]).unwrap(), [255, 0, 0, 255]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.8e38, f32::MAX] {
        for place in 0..3 {
            let mut color = [1.0; 3];
            color[place] = bad;
            assert!(to_rgbe(color).is_err(), "{color:?}");
        }
    }
    let mut picture = picture(3, 3);
    picture.pixels[5][1] = f32::NAN;
    assert!(encode(&picture).unwrap_err().to_string().contains("pixel 2, 1"));
}

/// The pixel at column x and row y is (10x + y + 130, …), so that an order can be written down.
#[test]
fn all_orders_of_scanlines() {
    let orders = [
        ("-Y 2 +X 3", [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]),
        ("-Y 2 -X 3", [[2, 0], [1, 0], [0, 0], [2, 1], [1, 1], [0, 1]]),
        ("+Y 2 +X 3", [[0, 1], [1, 1], [2, 1], [0, 0], [1, 0], [2, 0]]),
        ("+Y 2 -X 3", [[2, 1], [1, 1], [0, 1], [2, 0], [1, 0], [0, 0]]),
        ("+X 3 -Y 2", [[0, 0], [0, 1], [1, 0], [1, 1], [2, 0], [2, 1]]),
        ("+X 3 +Y 2", [[0, 1], [0, 0], [1, 1], [1, 0], [2, 1], [2, 0]]),
        ("-X 3 -Y 2", [[2, 0], [2, 1], [1, 0], [1, 1], [0, 0], [0, 1]]),
        ("-X 3 +Y 2", [[2, 1], [2, 0], [1, 1], [1, 0], [0, 1], [0, 0]]),
    ];
    for (resolution, order) in orders {
        let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{resolution}\n").into_bytes();
        for [x, y] in order {
            bytes.extend([130 + 10 * x + y, 0, 0, 128]);
        }
        let picture = decode(&bytes, Exposure::Undo).unwrap();
        assert_eq!((picture.width, picture.height), (3, 2));
        for y in 0..2u8 {
            for x in 0..3u8 {
                let expected = from_rgbe([130 + 10 * x + y, 0, 0, 128]);
                assert_eq!(picture.pixels[usize::from(y) * 3 + usize::from(x)], expected, "{resolution}: {x} {y}");
            }
        }
    }
}

#[test]
fn old_run_lengths() {
    let (a, b) = ([200, 10, 20, 129], [2, 150, 3, 130]);
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 600\n".to_vec();
    // b 1×, a 1×, 5 more, 2·256 more (second repetition in a row), b 81×
    bytes.extend([b, a, [1, 1, 1, 5], [1, 1, 1, 2], b, [1, 1, 1, 80]].as_flattened());
    bytes.extend([a, [1, 1, 1, 87], [1, 1, 1, 2]].as_flattened());
    let picture = decode(&bytes, Exposure::Undo).unwrap();
    let expected: Vec<_> = [(b, 1), (a, 518), (b, 81), (a, 600)].iter().flat_map(|&(p, n)| std::iter::repeat_n(from_rgbe(p), n)).collect();
    assert_eq!(picture.pixels, expected);

    let Some(mut pvalue) = radiance("pvalue") else { return };
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(floats(&output(pvalue.args(["-h", "-H", "-df"]).arg(file(&folder, "old.hdr", &bytes)))), expected);
}

#[test]
fn exposure_is_undone_and_the_rest_of_the_header_kept() {
    let text = "#?RADIANCE\nrpict -vtv room.oct\nEXPOSURE=2\n\tEXPOSURE=77\nVIEW= -vta -vh 180 -vv 180\nEXPOSURE= 1.5e0 \nCOLORCORR=1 2 4\n\
                PIXASPECT=1\nVIEW= -vp 1 2 3\nFORMAT=32-bit_rle_rgbe\n\n-Y        1 +X        2\n";
    let mut bytes = text.as_bytes().to_vec();
    bytes.extend([200, 100, 50, 130, 0, 0, 0, 0]);
    let undone = decode(&bytes, Exposure::Undo).unwrap();
    let stored = from_rgbe([200, 100, 50, 130]);
    assert_eq!(undone.pixels[0], [stored[0] / 3.0, stored[1] / 6.0, stored[2] / 12.0]);
    assert_eq!(undone.view.as_deref(), Some("-vta -vh 180 -vv 180 -vp 1 2 3"));
    assert_eq!(undone.header, ["rpict -vtv room.oct", "\tEXPOSURE=77", "PIXASPECT=1"]);
    let kept = decode(&bytes, Exposure::Keep).unwrap();
    assert_eq!(kept.pixels[0], stored);
    assert_eq!(kept.header.len(), 6);
    let again = decode(&encode(&kept).unwrap(), Exposure::Undo).unwrap();
    assert_eq!(again, undone, "a picture kept raw and written again means the same");

    let Some(mut pvalue) = radiance("pvalue") else { return };
    let folder = tempfile::tempdir().unwrap();
    let theirs = floats(&output(pvalue.args(["-o", "-h", "-H", "-df"]).arg(file(&folder, "e.hdr", &bytes))));
    for (a, b) in theirs[0].iter().zip(undone.pixels[0]) {
        assert!((a - b).abs() <= 2e-7 * b, "{theirs:?} {:?}", undone.pixels[0]);
    }
}

/// A picture of 2 × 1 pixels with this text before its resolution line.
fn with_header(text: &str, end_of_line: &str) -> Vec<u8> {
    let mut bytes = format!("{text}\n-Y 1 +X 2\n").replace('\n', end_of_line).into_bytes();
    bytes.extend([200, 100, 50, 130, 10, 200, 13, 129]);
    bytes
}

#[test]
fn headers_are_taken_as_radiance_takes_them() {
    let rgbe = "FORMAT=32-bit_rle_rgbe\n";
    let fisheye = "-vta -vd 0 1 0 -vh 180 -vv 180";
    // The header's text, the view that it states, the factor of its exposures.
    let cases = [
        // No magic number, no FORMAT, a line of a program first.
        (format!("oconv room.rad\nrpict -vf fish.vf -x 96 room.oct\nVIEW= {fisheye}\npfilt -1 -x /2\nEXPOSURE=2\n"), Some(fisheye), 2.0),
        (format!("VIEW= {fisheye}\n"), Some(fisheye), 1.0),
        ("pfilt -1 -x /2\n".into(), None, 1.0),
        (format!("#?RGBE\nFORMAT=\n{rgbe}VIEW= {fisheye}\n"), Some(fisheye), 1.0),
        // Views in lines of programs; words that are no view options are skipped.
        (
            format!("#?RADIANCE\nrpict -x 96 -vp 9 9 9 -ab 2 room.oct\nVIEW= {fisheye} -vp 1 2 3\n{rgbe}"),
            Some("-vta -vd 0 1 0 -vh 180 -vv 180 -vp 1 2 3"),
            1.0,
        ),
        (format!("#?RADIANCE\n/usr/local/bin/rvu {fisheye} room.oct\n{rgbe}"), Some(fisheye), 1.0),
        (format!("#?RADIANCE\nC:\\Radiance\\bin\\rpict.exe {fisheye} room.oct\n{rgbe}"), Some(fisheye), 1.0),
        (format!("#?RADIANCE\nrpiece -x 64 {fisheye} -y 64 -o p.hdr room.oct\n{rgbe}"), Some(fisheye), 1.0),
        (format!("#?RADIANCE\nrview\t{fisheye}\n{rgbe}"), Some(fisheye), 1.0),
        (
            format!("#?RADIANCE\nold.hdr:\n\tVIEW= -vth -vh 180\n\tEXPOSURE=7\npinterp {fisheye} -x 96 -ff old.hdr 1\n{rgbe}"),
            Some(fisheye),
            1.0,
        ),
        (format!("#?RADIANCE\nVIEW= -x 96 {fisheye} -y 96 -ld- -vf a.vf -ve 3 -vwrays -vtfoo\n{rgbe}"), Some(fisheye), 1.0),
        (format!("#?RADIANCE\nVIEW={fisheye} \n{rgbe}"), Some(fisheye), 1.0),
        // Each option's last value.
        (format!("#?RADIANCE\nVIEW= -vth -vu 0 0 1\nVIEW= {fisheye} -vh 90\n{rgbe}"), Some("-vu 0 0 1 -vta -vd 0 1 0 -vv 180 -vh 90"), 1.0),
        // No views: other programs, indented lines, no option.
        (format!("#?RADIANCE\nrtrace -vta -vh 180 -vv 180\n VIEW= {fisheye}\nVIEW= room 7\nvwrays {fisheye}\n{rgbe}"), None, 1.0),
        (format!("#?RADIANCE\nEXPOSURE=2\nEXPOSURE=0.25 (two stops)\nEXPOSURE= 3e0\n \n{rgbe}"), None, 1.5),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (text, view, exposure) in &cases {
        for end_of_line in ["\n", "\r\n"] {
            let bytes = with_header(text, end_of_line);
            let picture = decode(&bytes, Exposure::Undo).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(picture.view.as_deref(), *view, "{text}");
            let stored = [[200, 100, 50, 130], [10, 200, 13, 129]].map(from_rgbe);
            assert_eq!(picture.pixels, stored.map(|p| p.map(|v| (f64::from(v) * (1.0 / exposure)) as f32)), "{text}");
            // Written again, it means the same.
            let kept = decode(&bytes, Exposure::Keep).unwrap();
            assert_eq!(decode(&encode(&kept).unwrap(), Exposure::Undo).unwrap(), picture, "{text}");

            let Some(mut pvalue) = radiance("pvalue") else { continue };
            let path = file(&folder, "h.hdr", &bytes);
            let theirs = floats(&output(pvalue.args(["-o", "-h", "-H", "-df"]).arg(&path)));
            for (a, b) in theirs.as_flattened().iter().zip(picture.pixels.as_flattened()) {
                assert!((a - b).abs() <= 2e-7 * b, "{text}: {theirs:?} {:?}", picture.pixels);
            }
            // A program that takes the view of a picture: square or not, with or without a view.
            let mut vwrays = radiance("vwrays").unwrap();
            let theirs = vwrays.args(["-d", "-x", "100", "-y", "100", "-vf"]).arg(&path).output().unwrap();
            let knows = (view.is_some() && !text.contains('\\') && !text.contains("VIEW=-")) || text.contains("vwrays ");
            assert_eq!(theirs.status.success(), knows, "{text}");
        }
    }
    for text in ["two\nlines\n", "\u{1}rpict\n", "\n", "notes\n\n-Y\n"] {
        assert!(decode(&with_header(text, "\r"), Exposure::Undo).unwrap_err().to_string().contains("not a Radiance picture"));
    }
    assert!(decode(b"Dear reader,\n\nhow are you?\n", Exposure::Undo).unwrap_err().to_string().contains("not a Radiance picture"));
}

#[test]
fn resolution_lines_need_no_spaces() {
    for line in ["-Y 1 +X 2", "  -Y   1\t+X 2\r", "-Y1+X2", "-Y 1 +X 2 and more"] {
        let mut bytes = format!("#?RADIANCE\n\n{line}\n").into_bytes();
        bytes.extend([200, 100, 50, 130, 10, 200, 13, 129]);
        let picture = decode(&bytes, Exposure::Undo).unwrap();
        assert_eq!((picture.width, picture.height, picture.pixels[1]), (2, 1, from_rgbe([10, 200, 13, 129])), "{line}");
    }
}

#[test]
fn xyze_is_turned_into_radiance() {
    let weights = rgb_to_xyz_matrix().row(1);
    for (a, b) in weights.to_array().iter().zip(crate::units::BRIGHTNESS_WEIGHTS) {
        assert!((a - b).abs() < 1e-9, "{weights}");
    }
    let Some(mut ra_xyze) = radiance("ra_xyze") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut seed = 5;
    // Colours of little saturation: inside the gamut also after quantisation.
    let pixels = (0..600).map(|_| [0.0; 3].map(|_: f64| (0.6 + 0.4 * random(&mut seed)) as f32)).collect();
    let original = Picture::new(30, 20, pixels).unwrap();
    let path = file(&folder, "rgb.hdr", &encode(&original).unwrap());
    let xyze = output(ra_xyze.arg(&path));
    let ours = decode(&xyze, Exposure::Undo).unwrap();
    let path = file(&folder, "xyz.hdr", &xyze);
    let theirs = decode(&output(radiance("ra_xyze").unwrap().arg("-r").arg(&path)), Exposure::Undo).unwrap();
    let quantised = decode(&encode(&original).unwrap(), Exposure::Undo).unwrap();
    // Half a mantissa step of a pixel: 1/512 of the power of two above its largest component.
    let half_step = |p: [f32; 3]| 2f32.powi(p[0].max(p[1]).max(p[2]).log2().floor() as i32 + 1) / 512.0;
    let to_rgb = rgb_to_xyz_matrix().inverse();
    for ((a, b), c) in ours.pixels.iter().zip(&theirs.pixels).zip(&quantised.pixels) {
        let xyz = (rgb_to_xyz_matrix() * DVec3::from(c.map(f64::from))).to_array().map(|v| v as f32);
        for i in 0..3 {
            let row_sum = to_rgb.row(i).abs().element_sum() as f32;
            // `ra_xyze` adapts the white of 0.3333, 0.3333 to 1/3, 1/3 (3e-4 of Z) by a matrix and
            // its inverse rounded to four digits (1e-4 of XYZ); here luminance stays exact instead.
            let matrix_digits = 4e-4 * row_sum;
            assert!((a[i] - b[i]).abs() <= half_step(*b) + matrix_digits, "{a:?} {b:?}");
            assert!((a[i] - c[i]).abs() <= row_sum * half_step(xyz) + matrix_digits, "{a:?} {c:?}");
        }
    }
}

#[test]
fn truncated_files_are_errors_with_a_place() {
    let bytes = encode(&picture(60, 4)).unwrap();
    assert!(decode(&bytes, Exposure::Undo).is_ok());
    for length in 0..bytes.len() {
        let error = decode(&bytes[..length], Exposure::Undo).expect_err("truncated").to_string();
        assert!(!error.is_empty());
    }
    let error = decode(&bytes[..bytes.len() - 1], Exposure::Undo).unwrap_err().to_string();
    assert!(error.contains("scanline 4 of 4") && error.contains(&format!("byte {}", bytes.len() - 1)), "{error}");
}

#[test]
fn damaged_files_are_errors_never_panics() {
    let good = encode(&picture(60, 4)).unwrap();
    let mut seed = 9;
    let mut errors = 0;
    for _ in 0..4000 {
        let mut bytes = good.clone();
        for _ in 0..1 + (random(&mut seed) * 4.0) as usize {
            let at = (random(&mut seed) * bytes.len() as f64) as usize;
            bytes[at] = (random(&mut seed) * 256.0) as u8;
        }
        errors += usize::from(decode(&bytes, Exposure::Undo).is_err());
    }
    assert!(errors > 1000, "{errors}");
    for length in 0..300 {
        let noise: Vec<u8> = (0..length).map(|_| (random(&mut seed) * 256.0) as u8).collect();
        assert!(decode(&noise, Exposure::Undo).is_err());
    }
}

#[test]
fn damaged_codes_and_headers_are_named() {
    let case = |header: &str, body: &[u8]| {
        let mut bytes = format!("#?RADIANCE\n{header}\n\n").into_bytes();
        bytes.extend(body);
        decode(&bytes, Exposure::Undo).expect_err(header).to_string()
    };
    let rgbe = "FORMAT=32-bit_rle_rgbe";
    for (header, body, expected) in [
        (rgbe, &b"-Y 1 +X 20\n\x02\x02\x00\x15"[..], "21 pixels instead of 20"),
        (rgbe, b"-Y 1 +X 20\n\x02\x02\x00\x14\xff\x01", "127 pixels at pixel 0"),
        (rgbe, b"-Y 1 +X 20\n\x02\x02\x00\x14\x00\x01", "0 pixels at pixel 0"),
        (rgbe, b"-Y 1 +X 20\n\x01\x01\x01\x05", "starts with a repetition"),
        (rgbe, b"-Y 1 +X 2\n\x80\x01\x01\x80\x01\x01\x01\x05", "repetition at pixel 1"),
        (rgbe, b"-Y 0 +X 20\n", "no pixels"),
        (rgbe, b"-Y 2000000000 +X 2000000000\n", "longer than 65536"),
        (rgbe, b"-Y 99999999999999999999999 +X 1\n", "longer than 65536"),
        (rgbe, b"-Y 268435456 +X 1\n\x80\x80\x80\x80", "longer than 65536"),
        (rgbe, b"+X 1 -Y 268435456\n\x80\x80\x80\x80", "longer than 65536"),
        (rgbe, b"-Y 65536 +X 65536\n", "larger than"),
        // As many pixels as are allowed, and four bytes: nothing is laid out for them.
        (rgbe, b"-Y 65536 +X 4096\n\x80\x80\x80\x80", "scanline 1 of 65536"),
        (rgbe, b"-X 65536 +Y 4096\n\x80\x80\x80\x80", "scanline 1 of 65536"),
        (rgbe, b"-Y 3 +Y 3\n", "no resolution"),
        (rgbe, b"-Y -3 +X 3\n", "no resolution"),
        (rgbe, b"Y 3 X 3\n", "no resolution"),
        (rgbe, b"-Y 3\n", "no resolution"),
        ("FORMAT=float", b"-Y 1 +X 1\n", "not a picture format"),
        ("EXPOSURE=0", b"-Y 1 +X 1\n", "EXPOSURE"),
        ("EXPOSURE=nan", b"-Y 1 +X 1\n", "EXPOSURE"),
        ("EXPOSURE=1,5", b"-Y 1 +X 1\n", "EXPOSURE"),
        ("EXPOSURE=", b"-Y 1 +X 1\n", "EXPOSURE"),
        ("EXPOSURE=2 0", b"-Y 1 +X 1\n", "EXPOSURE"),
        ("EXPOSURE=1 2", b"-Y 1 +X 1\n", "EXPOSURE"),
        ("COLORCORR=1", b"-Y 1 +X 1\n", "COLORCORR"),
    ] {
        let message = case(header, body);
        assert!(message.contains(expected), "{message}");
    }
    assert!(decode(b"\n-Y 1 +X 1\naaaa", Exposure::Undo).unwrap_err().to_string().contains("Radiance picture"));
    assert!(decode(b"\x89PNG\r\n\x1a\n", Exposure::Undo).unwrap_err().to_string().contains("Radiance picture"));
    assert!(read(Path::new("does/not/exist.hdr")).unwrap_err().to_string().starts_with("does/not/exist.hdr"));
}

#[test]
fn a_bad_header_line_or_a_missing_row_is_refused_and_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let mut picture = picture(20, 2);
    picture.header.push("two\nlines".into());
    let path = folder.path().join("out.hdr");
    assert!(write(&path, &picture).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let mut writer = ScanlineWriter::new(Vec::new(), &path, 20, 2, None, &[]).unwrap();
    writer.write(&picture.pixels[..20]).unwrap();
    assert!(writer.finish().is_err());
}

#[test]
fn streaming_reads_what_was_streamed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stream.hdr");
    let mut picture = picture(333, 12);
    picture.view = Some("-vtv -vh 60".into());
    picture.header = vec!["SOFTWARE= x".into()];
    write(&path, &picture).unwrap();
    let mut reader = ScanlineReader::open(&path, Exposure::Undo).unwrap();
    assert_eq!(reader.header().orientation, Orientation::STANDARD);
    assert_eq!(reader.header().view.as_deref(), Some("-vtv -vh 60"));
    let mut writer = ScanlineWriter::new(Vec::new(), &path, 333, 12, picture.view.as_deref(), &reader.kept_lines()).unwrap();
    let mut row = vec![[0.0; 3]; 333];
    for _ in 0..12 {
        reader.read(&mut row).unwrap();
        writer.write(&row).unwrap();
    }
    assert!(reader.read(&mut row).is_err(), "after the last row");
    assert_eq!(writer.finish().unwrap(), std::fs::read(&path).unwrap());
}
