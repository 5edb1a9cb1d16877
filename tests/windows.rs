//! What windows of a whole project do to each other's light: they absorb it, in every matrix.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::gpu::Device;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::simulate::{Inputs, Project, run};
use std::path::Path;

const OFFICE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/office");

/// A window of 1 m² at y = 0 with its room behind; across the court a black wing, y = 4 … 6 m, that is open
/// from one side to the other by 6 m × 3 m.
const SCENE: &str = "void plastic black 0 0 5 0 0 0 0 0
void plastic grey 0 0 5 .5 .5 .5 0 0
grey polygon back 0 0 12  0 -3 0  0 -3 3  4 -3 3  4 -3 0
grey polygon floor 0 0 12  0 -3 0  4 -3 0  4 0 0  0 0 0
grey polygon ceiling 0 0 12  0 -3 3  0 0 3  4 0 3  4 -3 3
black polygon wall 0 0 30  0 0 0  4 0 0  4 0 3  0 0 3  0 0 0  1.5 0 1  1.5 0 2  2.5 0 2  2.5 0 1  1.5 0 1
black polygon front 0 0 30  -4 4 0  8 4 0  8 4 6  -4 4 6  -4 4 0  -1 4 1  -1 4 4  5 4 4  5 4 1  -1 4 1
black polygon behind 0 0 30  -4 6 0  -4 6 6  8 6 6  8 6 0  -4 6 0  -1 6 1  5 6 1  5 6 4  -1 6 4  -1 6 1
black polygon roof 0 0 12  -4 4 6  8 4 6  8 6 6  -4 6 6
";
const WINDOWS: [(&str, &str); 3] =
    [("near", "1.5 0 1  2.5 0 1  2.5 0 2  1.5 0 2"), ("far1", "-1 4 1  -1 4 4  5 4 4  5 4 1"), ("far2", "-1 6 1  5 6 1  5 6 4  -1 6 4")];
/// What is in place of the far windows where they are no windows.
const PLATES: &str = "black polygon plate1 0 0 12  -1 4 1  -1 4 4  5 4 4  5 4 1
black polygon plate2 0 0 12  -1 6 1  5 6 1  5 6 4  -1 6 4
";

fn project(folder: &Path, scene: &str, windows: &[(&str, &str)], more: &str) -> Project {
    std::fs::write(folder.join("room.rad"), scene).unwrap();
    std::fs::write(folder.join("points.txt"), "2 -1 1 0 0 1\n").unwrap();
    let mut text = format!(
        "[weather]\nfile = \"{OFFICE}/weather/new_york.wea\"\n[scene]\nfiles = [\"room.rad\"]\n[[sensors]]\nname = \"near\"\npoints = \"points.txt\"\n\
         [method]\nphases = 3\nsky_subdivision = 1\nbounces = 4\n[quality]\npreset = \"draft\"\n"
    );
    for (name, corners) in windows {
        std::fs::write(folder.join(format!("{name}.rad")), format!("#@rfluxmtx h=kf u=Z\n{name} polygon pane 0 0 12 {corners}\n")).unwrap();
        text += &format!("[[window]]\nname = \"{name}\"\nsurface = \"{name}.rad\"\nbsdf = \"{OFFICE}/bsdf/double_clear.xml\"\n{more}");
    }
    let file = folder.join("project.toml");
    std::fs::write(&file, text).unwrap();
    Project::read(&file).unwrap()
}

/// Sum of D of the near window over the sky, and V's row at the sensor, of that window.
fn sums(device: &Device, scene: &str, windows: &[(&str, &str)]) -> (f64, f64) {
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), scene, windows, "");
    let mut inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    inputs.weather.records = inputs.weather.records[79 * 24..80 * 24].to_vec();
    let out = folder.path().join("out");
    run(device, &project, &inputs, &out, &Silent, &mut Warnings::new()).unwrap();
    let d = read_matrix(&out.join("matrices/D_near.mtx")).unwrap().matrix;
    let v = read_matrix(&out.join("matrices/V_near.mtx")).unwrap().matrix;
    let sky = (0..d.rows()).flat_map(|bin| (1..d.cols()).map(move |patch| (bin, patch))).map(|(b, p)| f64::from(d.at(b, p)[1])).sum();
    (sky, (0..145).map(|bin| f64::from(v.at(0, bin)[1])).sum())
}

#[test]
fn other_windows_of_a_project_absorb_as_black_plates_do() {
    let Some(device) = device("windows of other rooms") else { return };
    let (d, v) = sums(&device, SCENE, &WINDOWS);
    let (with_plates, v_plates) = sums(&device, &format!("{SCENE}{PLATES}"), &WINDOWS[..1]);
    let (holes, _) = sums(&device, SCENE, &WINDOWS[..1]);
    println!("sum of D over the sky: {d:.2}, with black plates {with_plates:.2}, with holes {holes:.2}; V {v:.4} and {v_plates:.4}");
    // Radiance's rfluxmtx -ab 1 -c 1000 with black plates finds 26.0, with holes 40.3.
    assert!((d / 26.0 - 1.0).abs() < 0.01 && (d / with_plates - 1.0).abs() < 0.01, "{d} {with_plates}");
    assert!((holes / 40.3 - 1.0).abs() < 0.02, "{holes}");
    assert!((v / v_plates - 1.0).abs() < 0.02, "{v} {v_plates}");
}

#[test]
fn a_wall_in_the_plane_of_a_projects_window_is_named_and_does_not_darken_it() {
    let Some(device) = device("a wall in the plane of a window") else { return };
    // The same room with a wall that was not cut.
    let uncut = "black polygon uncut 0 0 12  0 0 0  4 0 0  4 0 3  0 0 3\n";
    let ((d, v), (d_cut, v_cut)) = (sums(&device, &format!("{SCENE}{uncut}"), &WINDOWS[..1]), sums(&device, SCENE, &WINDOWS[..1]));
    println!("D {d:.3} and {d_cut:.3}, V {v:.4} and {v_cut:.4}");
    assert!((d / d_cut - 1.0).abs() < 0.01 && (v / v_cut - 1.0).abs() < 0.02, "{d} {d_cut} {v} {v_cut}");
    let folder = tempfile::tempdir().unwrap();
    let mut warnings = Warnings::new();
    Inputs::read(&project(folder.path(), &format!("{SCENE}{uncut}"), &WINDOWS, ""), &mut warnings).unwrap();
    let text: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    let of_plane: Vec<&String> = text.iter().filter(|t| t.contains("in its plane")).collect();
    assert!(of_plane.len() == 1 && of_plane[0].contains("room.rad:10: surface 'uncut'"), "{text:?}");
}

#[test]
fn two_windows_of_a_project_in_one_place_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let twice = [WINDOWS[0], ("copy", WINDOWS[0].1)];
    let error = Inputs::read(&project(folder.path(), SCENE, &twice, ""), &mut Warnings::new()).unwrap_err().to_string();
    for part in ["copy.rad:2", "'copy'", "'near'", "near.rad:2", "same place"] {
        assert!(error.contains(part), "{part}: {error}");
    }
}
