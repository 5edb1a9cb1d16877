//! Rooms whose windows are shaded in parts, and what a project may ask for.

mod kinds;
mod rooms;

use crate::error::Warnings;
use crate::matrix::file::read_matrix;
use crate::simulate::Plan;
use crate::simulate::project::builder::ProjectBuilder;
use std::path::Path;

const CLEAR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/office/bsdf/double_clear.xml");
const GREY: &str = "void plastic wall 0 0 5 .5 .5 .5 0 0\nvoid plastic white 0 0 5 .8 .8 .8 0 0\n";
/// A room of 3 m × 4 m × 3 m with an opening in its south wall.
const ROOM: &str = include_str!("../../../../tests/data/plain_room.rad");
const OPENING: &str = "0.5 0 1  0.5 0 2.4  2.5 0 2.4  2.5 0 1";
const POINTS: &str = "0.8 0.7 0.8 0 0 1\n2.2 1.5 0.8 0 0 1\n1.5 2.5 0.8 0 0 1\n1.2 3.5 0.8 0 0 1\n1.5 2.0 1.2 0 -1 0\n";

const REVEAL: &str = "wall polygon sill 0 0 12  0.5 0 1  0.5 -0.4 1  2.5 -0.4 1  2.5 0 1
wall polygon head 0 0 12  0.5 0 2.4  2.5 0 2.4  2.5 -0.4 2.4  0.5 -0.4 2.4
wall polygon left 0 0 12  0.5 0 1  0.5 0 2.4  0.5 -0.4 2.4  0.5 -0.4 1
wall polygon right 0 0 12  2.5 0 1  2.5 -0.4 1  2.5 -0.4 2.4  2.5 0 2.4
";
const OVERHANG: &str = "wall polygon over 0 0 12  -0.5 0 2.4  3.5 0 2.4  3.5 -1 2.4  -0.5 -1 2.4\n";
const FINS: &str = "wall polygon fin1 0 0 12  0.5 0 1  0.5 0 2.4  0.5 -0.5 2.4  0.5 -0.5 1
wall polygon fin2 0 0 12  1.2 0 1  1.2 0 2.4  1.2 -0.5 2.4  1.2 -0.5 1
wall polygon fin3 0 0 12  1.8 0 1  1.8 0 2.4  1.8 -0.5 2.4  1.8 -0.5 1
wall polygon fin4 0 0 12  2.5 0 1  2.5 0 2.4  2.5 -0.5 2.4  2.5 -0.5 1
";
const SHELF: &str = "white polygon shelf 0 0 12  0.5 -0.6 1.9  2.5 -0.6 1.9  2.5 0.4 1.9  0.5 0.4 1.9\n";
const NEIGHBOUR: &str = "wall polygon neighbour 0 0 12  -8 -3 -1  11 -3 -1  11 -3 5  -8 -3 5\n";
/// A yard of 5 m × 6 m, 6 m deep, with a second room on its other side.
const YARD: &str = "white polygon ground 0 0 12  -1 -6 0  4 -6 0  4 0 0  -1 0 0
white polygon yard_west 0 0 12  -1 -6 0  -1 0 0  -1 0 6  -1 -6 6
white polygon yard_east 0 0 12  4 -6 0  4 -6 6  4 0 6  4 0 0
white polygon above 0 0 12  0 0 3  3 0 3  3 0 6  0 0 6
white polygon beside1 0 0 12  -1 0 0  0 0 0  0 0 6  -1 0 6
white polygon beside2 0 0 12  3 0 0  4 0 0  4 0 6  3 0 6
white polygon facing 0 0 30  -1 -6 0  -1 -6 6  4 -6 6  4 -6 0  -1 -6 0  0.5 -6 1  2.5 -6 1  2.5 -6 2.4  0.5 -6 2.4  0.5 -6 1
wall polygon floor2 0 0 12  0 -10 0  3 -10 0  3 -6 0  0 -6 0
wall polygon ceiling2 0 0 12  0 -10 3  0 -6 3  3 -6 3  3 -10 3
wall polygon west2 0 0 12  0 -10 0  0 -6 0  0 -6 3  0 -10 3
wall polygon east2 0 0 12  3 -10 0  3 -10 3  3 -6 3  3 -6 0
wall polygon north2 0 0 12  0 -10 0  3 -10 0  3 -10 3  0 -10 3
";
const OTHER_OPENING: &str = "0.5 -6 1  2.5 -6 1  2.5 -6 2.4  0.5 -6 2.4";
const OTHER_POINTS: &str = "0.8 -6.7 0.8 0 0 1\n2.2 -8 0.8 0 0 1\n";

/// A room in a folder, its windows with a BSDF and divided as told; some hours of sun and sky at 45° north.
fn room(folder: &Path, around: &str, bsdf: &str, parts: impl serde::Serialize + Clone) -> ProjectBuilder {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let header = "place Test\nlatitude 45\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n";
    let hours: String = [1, 3, 6].iter().flat_map(|month| (9..16).map(move |hour| format!("{month} 21 {hour}.5 600 120\n"))).collect();
    write("w.wea", &format!("{header}{hours}"));
    write("scene.rad", &format!("{GREY}{ROOM}{around}"));
    let window = |opening: &str| format!("void glow window 0 0 4 1 1 1 0\nwindow polygon opening 0 0 12  {opening}\n");
    write("window.rad", &window(OPENING));
    let yard = around == YARD;
    write("points.txt", &format!("{POINTS}{}", if yard { OTHER_POINTS } else { "" }));
    let project = crate::simulate::Project::builder(folder).weather("w.wea").scene(&["scene.rad"]).sensors("room", "points.txt");
    let project = project.set("method", "phases", 3).set("method", "sky_subdivision", 1);
    let project = project.window("south", "window.rad", bsdf).set("window", "parts", parts.clone());
    if !yard {
        return project;
    }
    write("other.rad", &window(OTHER_OPENING));
    project.window("north", "other.rad", bsdf).set("window", "parts", parts)
}

fn planned(builder: ProjectBuilder) -> Plan {
    Plan::new(builder.build().unwrap(), &mut Warnings::new()).unwrap()
}

/// Mean of the hours at each sensor, lx.
fn means(out: &Path) -> Vec<f64> {
    let m = read_matrix(&out.join("illuminance/room.mtx")).unwrap().matrix;
    (0..m.rows()).map(|row| m.row(row).iter().map(|v| f64::from(*v)).sum::<f64>() / m.cols() as f64).collect()
}

fn refused(builder: ProjectBuilder) -> String {
    let plan = builder.build().and_then(|project| Plan::new(project, &mut Warnings::new()));
    plan.err().map_or_else(|| "nothing was refused".into(), |e| e.to_string())
}

#[test]
fn what_cannot_be_divided_is_refused_where_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let with = |parts: toml::Value| room(folder.path(), REVEAL, CLEAR, parts);
    let list = |numbers: &[i64]| toml::Value::Array(numbers.iter().map(|n| toml::Value::Integer(*n)).collect());
    for (parts, words) in [
        (toml::Value::Integer(0), "from 1 to 256"),
        (toml::Value::Integer(-3), "from 1 to 256"),
        (toml::Value::Integer(1_000_000_000), "from 1 to 256"),
        (list(&[4, 0]), "out of range"),
        (list(&[64, 64]), "64 × 64 are 4096 parts, more than 256"),
        (list(&[4]), "two numbers, columns and rows, not 1"),
        (list(&[]), "two numbers, columns and rows, not 0"),
        (toml::Value::String("many".into()), "\"auto\""),
        (toml::Value::Float(2.5), "this is"),
    ] {
        let error = refused(with(parts.clone()));
        assert!(error.contains(words) && error.contains("window 1.parts"), "{parts}: {error}");
    }
    // 256 parts under the finest sky: replicates of D alone are beyond what machines have.
    let error = refused(with(toml::Value::Integer(256)).set("method", "sky_subdivision", 6));
    assert!(error.contains("in 256 parts") && error.contains("GB") && error.contains("sky_subdivision = 2"), "{error}");
    let d = folder.path().join("d.mtx");
    let matrix = crate::matrix::Matrix::<f32>::zeros(145, 146, 3);
    crate::matrix::file::write_matrix(Some(&d), &matrix, crate::matrix::file::Format::Float, &[]).unwrap();
    let given = |parts: toml::Value| with(parts).set("window", "daylight", "d.mtx");
    let error = refused(given(toml::Value::Integer(4)));
    assert!(error.contains("'south' is to be divided, but D of window 'south' was made elsewhere"), "{error}");
    let whole = planned(given(toml::Value::String("auto".into())));
    assert!(whole.inputs.windows[0].division.because.contains("was made elsewhere"), "{:?}", whole.inputs.windows[0].division);
}

#[test]
fn windows_of_any_outline_are_divided_into_what_they_have() {
    let folder = tempfile::tempdir().unwrap();
    // A frame around a hole, with a pane of its own beside it.
    let frame = "0.5 0 1  0.5 0 2.4  1.5 0 2.4  1.5 0 1  0.5 0 1  0.8 0 1.3  1.2 0 1.3  1.2 0 2.1  0.8 0 2.1  0.8 0 1.3";
    let text = format!(
        "void glow window 0 0 4 1 1 1 0\nwindow polygon frame 0 0 30  {frame}\nwindow polygon pane 0 0 12  2 0 1  2 0 2.4  2.5 0 2.4  2.5 0 1\n"
    );
    let builder = room(folder.path(), REVEAL, CLEAR, [4, 3]);
    std::fs::write(folder.path().join("window.rad"), text).unwrap();
    let inputs = planned(builder).inputs;
    let window = &inputs.windows[0];
    assert!((window.window.area() - (1.4 - 0.32 + 0.7)).abs() < 1e-9, "{}", window.window.area());
    // Nothing lies in the third column.
    assert_eq!((window.division.grid, window.division.count, window.parts.len()), ([4, 3], 9, 9));
    assert_eq!((inputs.bins(), inputs.geometry().len(), inputs.scene.windows.len()), (9 * 145, 9, 9));
    assert!(window.division.describe().unwrap() == "9 parts, 4 × 3");
}

#[test]
fn what_nothing_stands_before_stays_whole_with_its_bits() {
    let folder = tempfile::tempdir().unwrap();
    for parts in [toml::Value::String("auto".into()), toml::Value::Integer(16)] {
        let inputs = planned(room(folder.path(), "", CLEAR, parts)).inputs;
        let whole = planned(room(folder.path(), "", CLEAR, 1)).inputs;
        let window = &inputs.windows[0];
        assert!(window.parts.len() == 1 && window.division.because.contains("nothing stands before it"), "{:?}", window.division);
        // Fingerprints, random numbers and samples are those of a project without the key.
        assert_eq!(window.window, whole.windows[0].window);
        assert_eq!(inputs.scene_fingerprint().to_string(), whole.scene_fingerprint().to_string());
        assert_eq!((inputs.bins(), inputs.mean_parts()), (145, 1));
    }
}

#[test]
fn the_plan_says_what_parts_remove_and_what_a_whole_window_costs() {
    let folder = tempfile::tempdir().unwrap();
    let outline = |around: &str, parts: toml::Value| planned(room(folder.path(), around, CLEAR, parts)).outline().unwrap().to_string();
    let whole = outline(REVEAL, toml::Value::Integer(1));
    assert!(whole.contains("window south is whole: by a first look") && whole.contains("parts = \"auto\" divides it"), "{whole}");
    let auto = outline(REVEAL, toml::Value::String("auto".into()));
    assert!(auto.contains("bins in each of") && auto.contains("take the error of averages from"), "{auto}");
    let free = outline("", toml::Value::Integer(1));
    assert!(!free.contains("parts"), "{free}");
    let division = planned(room(folder.path(), REVEAL, CLEAR, 1)).inputs.windows[0].division.clone();
    assert!(division.is_doubtful() && division.because.contains("parts = \"auto\" divides it"), "{division:?}");
}

#[test]
fn windows_that_face_each_other_are_divided_each_for_itself() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = planned(room(folder.path(), YARD, CLEAR, [2, 3])).inputs;
    let counts: Vec<usize> = inputs.windows.iter().map(|w| w.parts.len()).collect();
    assert_eq!((counts, inputs.bins(), inputs.mean_parts(), inputs.scene.windows.len()), (vec![6, 6], 12 * 145, 6, 12));
    // Each window has its own parts in its place, and none of the other's.
    for window in &inputs.windows {
        assert_eq!(inputs.scene.windows.iter().filter(|part| window.window.is_in_place_of(part)).count(), 6);
    }
}
