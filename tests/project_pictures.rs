//! `lucarne run` with a `[[view]]`: the pictures of the shipped office are the product of the
//! matrices the run leaves, an eye in the place of the camera finds their vertical illuminance, and
//! a second run traces nothing.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::camera::{Raster, View};
use lucarne::glare::PixelGeometry;
use lucarne::image::hdr::{self, Exposure};
use lucarne::matrix::{Matrix, file::read_matrix};
use lucarne::units::ILLUMINANCE_WEIGHTS;
use std::path::Path;
use std::process::{Command, Output};

const SIZE: usize = 40;
/// A clear winter noon, a summer afternoon, and a night.
const HOURS: [usize; 3] = [300, 4716, 4728];

fn project() -> String {
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office");
    let office = office.display();
    format!(
        r#"
[weather]
file = "{office}/weather/new_york.wea"
[scene]
files = ["{office}/materials.rad", "{office}/office.rad"]
[[window]]
name = "vision"
surface = "{office}/windows/vision.rad"
bsdf = "{office}/bsdf/blind.xml"
[[window]]
name = "clerestory"
surface = "{office}/windows/clerestory.rad"
bsdf = "{office}/bsdf/double_clear.xml"
[[sensors]]
name = "eyes"
points = "{office}/eyes.txt"
[[view]]
name = "desk"
file = "{office}/views/desk.vf"
resolution = [{SIZE}, {SIZE}]
[images]
hours = {HOURS:?}
[quality]
preset = "draft"
"#
    )
}

fn run(folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lucarne")).args(["run", "project.toml", "-o", "out"]).current_dir(folder).output().unwrap()
}

fn matrix(folder: &Path, name: &str) -> Matrix<f32> {
    read_matrix(&folder.join("out/matrices").join(name)).unwrap().matrix
}

/// Radiance of every pixel in one hour, in f64 from the matrices.
fn expected(folder: &Path, hour: usize) -> Vec<[f64; 3]> {
    let (v, s) = (matrix(folder, "V_desk.mtx"), matrix(folder, "S.mtx"));
    let at = |m: &Matrix<f32>, row: usize, column: usize, c: usize| f64::from(m.row(row)[column * 3 + c]);
    let mut emitted = Vec::new();
    for window in ["vision", "clerestory"] {
        let (t, d) = (matrix(folder, &format!("T_{window}.mtx")), matrix(folder, &format!("D_{window}.mtx")));
        let incident: Vec<[f64; 3]> = (0..d.rows())
            .map(|bin| std::array::from_fn(|c| (0..d.cols()).map(|patch| at(&d, bin, patch, c) * at(&s, patch, hour, c)).sum()))
            .collect();
        let single = t.components() == 1;
        emitted.extend((0..t.rows()).map(|out| -> [f64; 3] {
            std::array::from_fn(|c| {
                let t_of = |bin: usize| if single { f64::from(t.row(out)[bin]) } else { at(&t, out, bin, c) };
                incident.iter().enumerate().map(|(bin, radiance)| t_of(bin) * radiance[c]).sum()
            })
        }));
    }
    (0..v.rows())
        .map(|pixel| std::array::from_fn(|c| emitted.iter().enumerate().map(|(bin, e)| at(&v, pixel, bin, c) * e[c]).sum()))
        .collect()
}

#[test]
fn pictures_of_a_project_are_the_product_of_its_matrices_and_light_an_eye_as_a_sensor_is_lit() {
    if device("pictures of a project").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("project.toml"), project()).unwrap();
    let first = run(folder.path());
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));

    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office");
    let camera = View::read(&office.join("views/desk.vf")).unwrap().camera().unwrap();
    let geometry = PixelGeometry::new(&Raster::fit(camera, SIZE, SIZE, 1.0).unwrap()).unwrap();
    let lux = read_matrix(&folder.path().join("out/illuminance/eyes.mtx")).unwrap().matrix;
    for hour in HOURS {
        let path = folder.path().join(format!("out/images/desk/img_{hour:04}.hdr"));
        let pixels = expected(folder.path(), hour);
        if pixels.iter().flatten().all(|v| *v == 0.0) {
            // Asked for by number, a night has its picture: a black one.
            assert!(hdr::read(&path).unwrap().pixels.iter().flatten().all(|v| *v == 0.0));
            continue;
        }
        let picture = hdr::read_with(&path, Exposure::Undo).unwrap();
        assert_eq!((picture.width, picture.height), (SIZE, SIZE));
        for (found, wanted) in picture.pixels.iter().zip(&pixels) {
            let largest = wanted.iter().copied().fold(0.0, f64::max);
            for (f, w) in found.iter().zip(wanted) {
                // RGBE keeps eight bits of the largest component.
                assert!((f64::from(*f) - w).abs() <= largest * (1.0 / 128.0 + 1e-5), "hour {hour}: {found:?} for {wanted:?}");
            }
        }
        let values: Vec<f32> =
            picture.pixels.iter().map(|p| p.iter().zip(ILLUMINANCE_WEIGHTS).map(|(v, w)| f64::from(*v) * w).sum::<f64>() as f32).collect();
        let seen = geometry.totals(&values).unwrap().vertical_illuminance;
        let sensed = f64::from(lux.row(0)[hour]);
        // 40 pixels across the hemisphere, draft quality.
        assert!((seen / sensed - 1.0).abs() < 0.05, "hour {hour}: the picture gives {seen} lx, the sensor {sensed} lx");
    }

    let second = run(folder.path());
    assert!(second.status.success());
    let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path().join("out/summary.json")).unwrap()).unwrap();
    let matrices = summary["matrices"].as_array().unwrap();
    assert!(matrices.iter().all(|m| m["reused"] == true), "{matrices:?}");
    assert!(matrices.iter().any(|m| m["name"] == "V_desk"), "{matrices:?}");
}

#[test]
fn a_camera_inside_a_wall_is_told_so_and_leaves_no_file() {
    if device("a camera inside a wall").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // A closed box far from the room, around the camera.
    std::fs::write(folder.path().join("wall.rad"), "void plastic stone 0 0 5 .5 .5 .5 0 0\n!genbox stone block 2 2 2 | xform -t 50 50 0\n")
        .unwrap();
    std::fs::write(folder.path().join("in.vf"), "rvu -vta -vp 51 51 1 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180\n").unwrap();
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office");
    let office = office.display();
    let arguments = format!(
        "matrix view --view in.vf -x 16 -y 16 --window {office}/windows/vision.rad {office}/materials.rad {office}/office.rad wall.rad -o v.mtx"
    );
    let out = Command::new(env!("CARGO_BIN_EXE_lucarne")).args(arguments.split(' ')).current_dir(folder.path()).output().unwrap();
    let message = String::from_utf8_lossy(&out.stderr);
    assert!(!out.status.success() && message.contains("no light of any window reaches the picture"), "{message}");
    let mut left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["in.vf", "wall.rad"]);
}
