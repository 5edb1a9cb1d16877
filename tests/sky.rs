//! `lucarne sky` as a user runs it: files in, matrix files out, one clear error otherwise.

use lucarne::matrix::file::{read_matrix, read_matrix_from};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const WEA: &str = "place Testville_XYZ\nlatitude 40.78\nlongitude 73.97\ntime_zone 75.0\nsite_elevation 57.0\nweather_data_file_units 1\n3 21 9.5 500 150\n3 21 12.0 850 100\n12 21 20.0 0 0\n";
const EPW: &str = "LOCATION,New York,NY,USA,TMY3,725033,40.78,-73.97,-5.0,57.0\nDESIGN CONDITIONS,0\nDATA PERIODS,1,1,Data,Sunday, 3/21, 3/21\n1999,3,21,12,60,A7A7,10.0,5.0,70,101300,1200,1300,320,700,850,100,70000\n1999,3,21,13,60,A7A7,10.0,7.0,70,101300,1200,1300,320,700,800,120,70000\n";

/// A folder with `weather/NYC.wea` and `weather/NYC.epw` in it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("weather")).unwrap();
    std::fs::write(folder.path().join("weather/NYC.wea"), WEA).unwrap();
    std::fs::write(folder.path().join("weather/NYC.epw"), EPW).unwrap();
    folder
}

fn lucarne(folder: &Path, arguments: &str, input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_lucarne"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that refuses its arguments may have gone before it read anything.
    let _ = child.stdin.take().unwrap().write_all(input);
    child.wait_with_output().unwrap()
}

/// Standard output of a run that must succeed without a word on standard error.
fn output(folder: &Path, arguments: &str, input: &[u8]) -> Vec<u8> {
    let out = lucarne(folder, arguments, input);
    assert!(out.status.success() && out.stderr.is_empty(), "{arguments}: {}", String::from_utf8_lossy(&out.stderr));
    out.stdout
}

fn refusal(folder: &Path, arguments: &str, input: &[u8]) -> String {
    let out = lucarne(folder, arguments, input);
    assert!(!out.status.success(), "{arguments} succeeded");
    assert!(out.stdout.is_empty(), "{arguments} wrote something");
    String::from_utf8(out.stderr).unwrap()
}

#[test]
fn the_line_of_the_manual_works_as_written() {
    let folder = folder();
    for (arguments, columns) in [("sky weather/NYC.wea -m 1 -o S.mtx", 3), ("sky weather/NYC.epw -m 1 -o S.mtx", 2)] {
        assert!(output(folder.path(), arguments, b"").is_empty());
        let file = read_matrix(&folder.path().join("S.mtx")).unwrap();
        assert_eq!((file.matrix.rows(), file.matrix.cols(), file.matrix.components()), (146, columns, 3));
        assert_eq!(file.value("LATLONG"), Some("40.78000000 -73.97000000"));
        assert!(file.header.iter().any(|l| l == &format!("lucarne {arguments}")), "{:?}", file.header);
        let bytes = std::fs::read(folder.path().join("S.mtx")).unwrap();
        assert!(String::from_utf8_lossy(&bytes[..300]).contains("\nBigEndian=0\nFORMAT=float"), "float in a file");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing else is left");
    }
}

#[test]
fn standard_streams_and_formats_hold_the_same_matrix() {
    let folder = folder();
    output(folder.path(), "sky weather/NYC.wea -o S.mtx", b"");
    let expected = read_matrix(&folder.path().join("S.mtx")).unwrap().matrix;
    for arguments in ["sky", "sky -", "sky -oa", "sky -of -o -", "sky -od", "sky -m 1 -O0 -r 0 -g .2 .2 .2 -c .96 1.004 1.118"] {
        let bytes = output(folder.path(), arguments, WEA.as_bytes());
        assert_eq!(read_matrix_from::<f32>(bytes.as_slice()).unwrap().matrix, expected, "{arguments}");
    }
    let text = output(folder.path(), "sky", WEA.as_bytes());
    assert!(String::from_utf8(text).unwrap().contains("\nNROWS=146\nNCOLS=3\nNCOMP=3\nFORMAT=ascii\n\n"), "text on standard output");
}

#[test]
fn no_header_leaves_the_values_alone() {
    let folder = folder();
    output(folder.path(), "sky weather/NYC.wea -o S.mtx", b"");
    let values: Vec<u8> = read_matrix(&folder.path().join("S.mtx")).unwrap().matrix.data().iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(output(folder.path(), "sky weather/NYC.wea -h -of", b""), values);
    output(folder.path(), "sky weather/NYC.wea -h -o bare.mtx", b"");
    assert_eq!(std::fs::read(folder.path().join("bare.mtx")).unwrap(), values);
    let text = String::from_utf8(output(folder.path(), "sky weather/NYC.wea -h", b"")).unwrap();
    assert_eq!(text.lines().count(), 146);
}

#[test]
fn options_are_those_of_gendaymtx() {
    let folder = folder();
    let sky = |arguments: &str| {
        read_matrix_from::<f32>(output(folder.path(), &format!("sky weather/NYC.wea -of {arguments}"), b"").as_slice()).unwrap()
    };
    let sun = sky("-5 0.533 -d -m 4");
    assert_eq!(sun.matrix.rows(), 2306);
    // gendaymtx -m 4 -of -5 0.533 -d.
    assert!((sun.matrix.at(1284, 0)[0] - 3891528.5).abs() < 1.0 && (sun.matrix.at(1681, 1)[2] - 7202603.5).abs() < 1.0);
    assert_eq!(sun.matrix.data().iter().filter(|v| **v != 0.0).count(), 6);
    assert_eq!(sky("-u").matrix.cols(), 2);
    let mean = sky("-A");
    assert_eq!((mean.matrix.cols(), mean.value("NAVERAGED")), (1, Some("3")));
    assert_eq!(sky("-r -30").matrix, sky("-rz -30").matrix);
    assert_ne!(sky("-r -30").matrix, sky("-r 30").matrix);
    assert_ne!(sky("-O1").matrix, sky("-O0").matrix);
    assert_eq!(sky("-s -g 0 0 0").matrix.at(0, 0), [0.0; 3]);
    let colored = sky("-s -c 1 2 4");
    let [r, g, b] = colored.matrix.at(145, 0) else { panic!("three components") };
    assert!((g / r - 2.0).abs() < 1e-6 && (b / r - 4.0).abs() < 1e-6);
}

#[test]
fn mistakes_are_explained_and_leave_no_file() {
    let folder = folder();
    std::fs::write(folder.path().join("bad.wea"), format!("{WEA}3 21 13 -1 0\n")).unwrap();
    std::fs::write(folder.path().join("short.wea"), &WEA[..100]).unwrap();
    std::fs::write(folder.path().join("garbage.wea"), [0u8, 159, 146, 150].repeat(100)).unwrap();
    for (arguments, expected) in [
        ("sky bad.wea -o S.mtx", "bad.wea:10: direct normal irradiance: -1 is impossible"),
        ("sky short.wea -o S.mtx", "short.wea:"),
        ("sky garbage.wea -o S.mtx", "garbage.wea:1: this is binary data, not a weather file"),
        ("sky none.wea -o S.mtx", "none.wea: No such file"),
        ("sky weather -o S.mtx", "weather: Is a directory"),
        ("sky weather/NYC.wea -m 7 -o S.mtx", "MF:7 does not exist"),
        ("sky weather/NYC.wea -d -s -o S.mtx", "cannot be used with"),
        ("sky weather/NYC.wea -5 0 -o S.mtx", "-5: the angle of the sun's disc"),
        ("sky weather/NYC.wea -g .1 .2 -o S.mtx", "-g"),
        ("sky weather/NYC.wea -O3 -o S.mtx", "-O"),
        ("sky weather/NYC.wea -o none/S.mtx", "none/S.mtx: No such file"),
        ("sky - -o S.mtx", "standard input: the file is empty"),
    ] {
        let error = refusal(folder.path(), arguments, b"");
        assert!(error.contains(expected), "{arguments}: {error}");
        assert!(!folder.path().join("S.mtx").exists());
    }
}
