//! `lucarne matrix coefficients`: which panes windows have, and what comes through them.

#[path = "../src/testing.rs"]
mod testing;

use lucarne::matrix::file::read_matrix;
use std::path::Path;
use std::process::Output;

/// A black cube without its south side; a sensor that looks out.
const SCENE: &str = "void plastic black 0 0 5 0 0 0 0 0
black polygon back 0 0 12  0 1 0  1 1 0  1 1 1  0 1 1
black polygon floor 0 0 12  0 0 0  1 0 0  1 1 0  0 1 0
black polygon ceiling 0 0 12  0 0 1  0 1 1  1 1 1  1 0 1
black polygon west 0 0 12  0 0 0  0 1 0  0 1 1  0 0 1
black polygon east 0 0 12  1 0 0  1 0 1  1 1 1  1 1 0
";
const PANE: &str = "#@rfluxmtx h=kq u=Z\npane polygon south 0 0 12  0 0 0  0 0 1  1 0 1  1 0 0\n";

fn lucarne(folder: &Path, arguments: &str) -> Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_lucarne"))
        .current_dir(folder)
        .args(["matrix", "coefficients"])
        .args(arguments.split_whitespace())
        .output()
        .unwrap()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("room.rad", SCENE);
    // Transmissivity 0.96 is a pane of transmittance 0.88.
    write("glass.rad", &format!("void glass pane 0 0 3 .96 .96 .96\n{PANE}"));
    write("paint.rad", &format!("void plastic pane 0 0 5 .5 .5 .5 0 0\n{PANE}"));
    write("points.txt", "0.5 0.9 0.5 0 -1 0\n");
    folder
}

#[test]
fn panes_are_of_the_windows_glass_or_as_the_command_line_says() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = folder();
    let sums = |arguments: &str| -> [f64; 3] {
        let output = lucarne(
            folder.path(),
            &format!("{arguments} --points points.txt -m 2 -o C.mtx --direct Cd.mtx --standard-error E.mtx room.rad"),
        );
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        ["C.mtx", "Cd.mtx", "E.mtx"].map(|name| {
            let matrix = read_matrix(&folder.path().join(name)).unwrap().matrix;
            assert_eq!((matrix.rows(), matrix.cols(), matrix.components()), (1, 578, 3));
            matrix.data().iter().skip(1).step_by(3).map(|v| f64::from(*v)).sum()
        })
    };
    let glass = sums("--window glass.rad");
    let said = sums("--window paint.rad --glass 0.8799");
    let half = sums("--window paint.rad --glass 0.8799,0.44,0.1");
    let open = sums("");
    println!("glass {glass:?}, --glass {said:?}, half of it {half:?}, open {open:?}");
    // Configuration factor of the square as seen from its axis: 4 parallel rectangles of a quarter.
    let x = 0.5 / 0.9;
    let factor = 4.0 / (2.0 * std::f64::consts::PI) * 2.0 * (x / f64::hypot(1.0, x) * (x / f64::hypot(1.0, x)).atan());
    assert!((open[0] / (std::f64::consts::PI * factor) - 1.0).abs() < 0.02, "{open:?} {factor}");
    // Light meets the pane at 0° to 38°, where it lets as much through as at 0°, to 1 %.
    assert!((glass[0] / (std::f64::consts::PI * factor * 0.88) - 1.0).abs() < 0.015, "{glass:?}");
    assert!((said[0] / glass[0] - 1.0).abs() < 1e-3 && (half[0] / said[0] - 0.5).abs() < 3e-3, "{said:?} {half:?}");
    for [total, direct, error] in [glass, said, half, open] {
        assert!((total - direct).abs() < 1e-6 && error > 0.0 && error < 0.2 * total);
    }
}

#[test]
fn a_window_that_is_no_glass_is_refused() {
    let folder = folder();
    let fails = |arguments: &str, parts: &[&str]| {
        let output = lucarne(folder.path(), &format!("{arguments} --points points.txt -o C.mtx room.rad"));
        let message = String::from_utf8_lossy(&output.stderr).to_string();
        assert!(!output.status.success(), "{arguments}");
        parts.iter().for_each(|part| assert!(message.contains(part), "{part}: {message}"));
    };
    fails("--window paint.rad", &["paint.rad:2", "'pane'", "no glass", "--glass"]);
    fails("--window paint.rad --glass 0.95", &["--glass", "0.918"]);
    fails("--window paint.rad --glass 0.5,0.5", &["one transmittance or three"]);
    fails("--glass 0.5", &["--window"]);
    fails("--window glass.rad -m 7", &["-m", "1 to 6"]);
    let help = lucarne(folder.path(), "--help");
    assert!(String::from_utf8_lossy(&help.stdout).contains("rfluxmtx"));
}
