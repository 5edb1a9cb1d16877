//! The verb `multiply` as users run it, against Radiance's results and its dctimestep.

use lucarne::image;
use lucarne::image::Picture;
use lucarne::image::hdr;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, read_matrix, write_matrix};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

#[path = "../src/testing.rs"]
mod testing;

use testing::{Need, radiance, skip};

fn shared() -> Option<PathBuf> {
    testing::shared().map(|folder| folder.join("data"))
}

fn lucarne(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lucarne"));
    command.arg("multiply").args(arguments).current_dir(folder).env_remove("LUCARNE_DEVICE").output().expect("the program starts")
}

fn succeed(folder: &Path, arguments: &[&str]) -> Output {
    let out = lucarne(folder, arguments);
    assert!(out.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&out.stderr));
    out
}

fn fail(folder: &Path, arguments: &[&str]) -> String {
    let out = lucarne(folder, arguments);
    assert!(!out.status.success(), "{arguments:?} succeeded");
    String::from_utf8_lossy(&out.stderr).into_owned()
}

fn random(rows: usize, cols: usize, components: usize, seed: u32) -> Matrix<f32> {
    let mut state = seed;
    let data = (0..rows * cols * components)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        })
        .collect();
    Matrix::from_data(rows, cols, components, data).unwrap()
}

fn save(path: &Path, matrix: &Matrix<f32>, header: &[String]) {
    write_matrix(Some(path), matrix, Format::Float, header).unwrap();
}

#[test]
fn a_year_of_illuminance_is_that_of_dctimestep() {
    let (Some(data), Some(mut gendaymtx)) = (shared(), radiance("gendaymtx")) else { return };
    let folder = tempfile::tempdir().unwrap();
    let sky = gendaymtx.args(["-of", "-m", "1"]).arg(data.join("tutorial_room/weather/NYC.wea")).output().unwrap();
    std::fs::write(folder.path().join("S.mtx"), sky.stdout).unwrap();
    let path = |name: &str| data.join(name).to_string_lossy().into_owned();
    let (v, d) = (path("reference/sensors/V_best.mtx"), path("reference/sensors/D1_4x.mtx"));
    for bsdf in ["clear", "blinds", "ven0", "ven45", "blinds_correct_klems"] {
        let xml = path(&format!("tutorial_room/bsdf/{bsdf}.xml"));
        for device in [&[][..], &["--device", "0"]] {
            let mut line = vec!["--illuminance", "-c", "47.4", "119.9", "11.6", &v, &xml, &d, "S.mtx", "-o", "lux.mtx"];
            line.extend(device);
            let out = lucarne(folder.path(), &line);
            if !out.status.success() && String::from_utf8_lossy(&out.stderr).contains("install a Vulkan driver") {
                skip(Need::Gpu, &"the product on a device: there is none");
                continue;
            }
            assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
            let lux = read_matrix(&folder.path().join("lux.mtx")).unwrap().matrix;
            // The reference has one row per hour.
            let reference = read_matrix(Path::new(&path(&format!("reference/sensors/annual_MF1_{bsdf}.ill")))).unwrap().matrix;
            assert_eq!((lux.rows(), lux.cols(), lux.components()), (reference.cols(), reference.rows(), 1));
            let mut worst = 0f64;
            for sensor in 0..lux.rows() {
                let largest = (0..lux.cols()).map(|h| reference.at(h, sensor)[0]).fold(0.0, f32::max);
                for hour in 0..lux.cols() {
                    worst = worst.max(f64::from((lux.at(sensor, hour)[0] - reference.at(hour, sensor)[0]).abs() / largest));
                }
            }
            println!("{bsdf} {device:?}: largest difference {worst:.2e} of a sensor's maximum");
            assert!(worst <= 1e-5, "{bsdf} {device:?}: {worst:e}");
        }
    }
}

#[test]
fn factors_come_from_files_and_standard_input_and_leave_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (dc, s) = (random(3, 5, 3, 1), random(5, 4, 3, 2));
    save(&at("DC.mtx"), &dc, &[]);
    save(&at("S.mtx"), &s, &["LATLONG= 40.7 -73.9".into()]);
    succeed(folder.path(), &["DC.mtx", "S.mtx", "-o", "E.mtx"]);
    let file = read_matrix(&at("E.mtx")).unwrap();
    assert_eq!(file.value("LATLONG"), Some("40.7 -73.9"));
    for (row, column) in [(0, 0), (2, 3)] {
        for c in 0..3 {
            let exact: f64 = (0..5).map(|k| f64::from(dc.at(row, k)[c]) * f64::from(s.at(k, column)[c])).sum();
            assert!((f64::from(file.matrix.at(row, column)[c]) - exact).abs() < 1e-6);
        }
    }
    for (option, format) in [("-oa", "FORMAT=ascii"), ("-of", "FORMAT=float"), ("-od", "FORMAT=double")] {
        succeed(folder.path(), &[option, "DC.mtx", "S.mtx", "-o", "F.mtx"]);
        assert!(String::from_utf8_lossy(&std::fs::read(at("F.mtx")).unwrap()).contains(format));
        assert_eq!(read_matrix(&at("F.mtx")).unwrap().matrix, file.matrix, "{option}");
    }
    // Standard input and output.
    let mut child = Command::new(env!("CARGO_BIN_EXE_lucarne"));
    child.args(["multiply", "DC.mtx"]).current_dir(folder.path());
    child.stdin(std::fs::File::open(at("S.mtx")).unwrap());
    let out = child.output().unwrap();
    std::fs::write(at("G.mtx"), &out.stdout).unwrap();
    assert_eq!(read_matrix(&at("G.mtx")).unwrap().matrix, file.matrix);
    // Selected hours, weights, without header.
    succeed(folder.path(), &["DC.mtx", "S.mtx", "--hours", "2,0", "--illuminance", "-o", "H.mtx"]);
    let lux = read_matrix(&at("H.mtx")).unwrap().matrix;
    assert_eq!((lux.cols(), lux.components()), (2, 1));
    let e = file.matrix.at(1, 2);
    let wanted = 179.0 * (0.265_074_126 * f64::from(e[0]) + 0.670_114_631 * f64::from(e[1]) + 0.064_811_243 * f64::from(e[2]));
    assert!((f64::from(lux.at(1, 0)[0]) - wanted).abs() < 1e-5 * wanted);
    succeed(folder.path(), &["-h", "-of", "DC.mtx", "S.mtx", "-o", "raw"]);
    assert_eq!(std::fs::read(at("raw")).unwrap().len(), 3 * 4 * 3 * 4);
}

#[test]
fn bad_input_gives_one_clear_error_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    save(&at("V.mtx"), &random(4, 145, 3, 1), &[]);
    save(&at("T.mtx"), &random(77, 77, 3, 2), &[]);
    save(&at("D.mtx"), &random(77, 6, 3, 3), &[]);
    save(&at("S.mtx"), &random(6, 4, 3, 4), &[]);
    std::fs::write(at("garbage.mtx"), [0u8, 1, 2, 255].repeat(100)).unwrap();
    std::fs::write(at("broken.xml"), "<Window").unwrap();
    for (line, words) in [
        (&["V.mtx", "T.mtx", "D.mtx", "S.mtx"][..], &["'V.mtx' has 145 columns", "'T.mtx' has 77 rows"][..]),
        (&["D.mtx", "V.mtx"], &["'D.mtx' has 6 columns", "'V.mtx' has 4 rows"]),
        (&["none.mtx", "S.mtx"], &["none.mtx"]),
        (&["garbage.mtx", "S.mtx"], &["garbage.mtx"]),
        (&["V.mtx", "broken.xml", "D.mtx", "S.mtx"], &["broken.xml"]),
        (&["D.mtx", "S.mtx", "--hours", "4"], &["--hours", "S.mtx"]),
        (&["D.mtx", "S.mtx", "--hours", "x"], &["--hours"]),
        (&["D.mtx", "S.mtx", "--device", "no such device"], &["--device"]),
        (&["-", "-"], &["standard input"]),
        (&["v%03d.hdr", "S.mtx", "-o", "img_%04d.hdr"], &["v000.hdr"]),
        (&["D.mtx", "S.mtx", "-o", "img_%04d.hdr"], &["RESOLUTION"]),
        (&["D.mtx", "S.mtx", "-o", "no/such/folder/E.mtx"], &["no/such/folder/E.mtx"]),
    ] {
        let mut line = line.to_vec();
        if !line.contains(&"-o") {
            line.extend(["-o", "out.mtx"]);
        }
        let error = fail(folder.path(), &line);
        assert!(words.iter().all(|w| error.contains(w)), "{line:?}: {error}");
        assert!(error.matches("lucarne: error:").count() == 1 && !error.contains("panicked"), "{error}");
        assert!(!at("out.mtx").exists());
    }
}

#[test]
fn pictures_are_those_of_dctimestep() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    const SIZE: usize = 20;
    let bins = 6;
    let v = random(SIZE * SIZE, bins, 3, 5);
    for bin in 0..bins {
        let pixels = (0..SIZE * SIZE).map(|p| v.at(p, bin).try_into().unwrap()).collect();
        hdr::write(&at(&format!("v{bin:03}.hdr")), &Picture::new(SIZE, SIZE, pixels).unwrap()).unwrap();
    }
    save(&at("T.mtx"), &random(bins, bins, 3, 6), &[]);
    save(&at("D.mtx"), &random(bins, 4, 3, 7), &[]);
    let mut sky = random(4, 3, 3, 8);
    (0..4).for_each(|row| sky.at_mut(row, 1).fill(0.0));
    save(&at("S.mtx"), &sky, &[]);
    succeed(folder.path(), &["v%03d.hdr", "T.mtx", "D.mtx", "S.mtx", "-o", "img_%04d.hdr"]);
    assert!(at("img_0000.hdr").exists() && !at("img_0001.hdr").exists(), "black hours are left out");
    // The same from a matrix with the pictures' pixels, for named hours, black ones too.
    let mut decoded = Matrix::zeros(SIZE * SIZE, bins, 3);
    for bin in 0..bins {
        let picture = image::read(&at(&format!("v{bin:03}.hdr"))).unwrap();
        picture.pixels.iter().enumerate().for_each(|(p, c)| decoded.at_mut(p, bin).copy_from_slice(c));
    }
    save(&at("v.mtx"), &decoded, &[format!("RESOLUTION=-Y {SIZE} +X {SIZE}")]);
    succeed(folder.path(), &["v.mtx", "T.mtx", "D.mtx", "S.mtx", "--hours", "1,2", "-o", "mtx_%04d.hdr", "--memory", "64M"]);
    let pixels = |name: &str| image::read(&at(name)).unwrap().pixels;
    assert_eq!(pixels("mtx_0002.hdr"), pixels("img_0002.hdr"));
    assert!(pixels("mtx_0001.hdr").iter().all(|c| *c == [0.0; 3]) && !at("mtx_0000.hdr").exists());

    let Some(mut dctimestep) = radiance("dctimestep") else { return };
    let out = dctimestep.args(["-o", "rad_%04d.hdr", "v%03d.hdr", "T.mtx", "D.mtx", "S.mtx"]).current_dir(folder.path()).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    for hour in [0, 2] {
        let (ours, theirs) = (pixels(&format!("img_{hour:04}.hdr")), pixels(&format!("rad_{hour:04}.hdr")));
        // Both are RGBE: a sum that lies on the edge of two codes may fall on either side.
        let mut different = 0;
        for (a, b) in ours.iter().zip(&theirs) {
            let largest = a.iter().fold(0f32, |m, v| m.max(*v));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.008 * largest), "{a:?} {b:?}");
            different += usize::from(a != b);
        }
        assert!(different * 100 <= ours.len(), "{different} pixels of {} differ", ours.len());
    }
}
