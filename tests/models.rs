//! Models of design programs, as users run them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

#[path = "../src/testing.rs"]
mod testing;

fn lucarne(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lucarne")).args(arguments).current_dir(folder).stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).to_string()
}

fn model() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/honeybee_room/room.hbjson")
}

/// A folder with the weather of one clear day.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut weather =
        "place Test_USA\nlatitude 40.78\nlongitude 73.96\ntime_zone 75\nsite_elevation 40.0\nweather_data_file_units 1\n".to_string();
    for hour in 0..24 {
        let (direct, diffuse) = if (8..16).contains(&hour) { (500, 150) } else { (0, 0) };
        weather.push_str(&format!("3 21 {hour}.500 {direct} {diffuse}\n"));
    }
    fs::write(folder.path().join("day.wea"), weather).unwrap();
    folder
}

#[test]
fn a_model_is_planned_with_its_weather_and_not_without() {
    let folder = folder();
    let model = model().display().to_string();
    let planned = lucarne(folder.path(), &["plan", &model, "--weather", "day.wea"]);
    let said = text(&planned.stdout);
    assert!(planned.status.success(), "{}", text(&planned.stderr));
    for words in [
        "window south: 2.80 m² facing 180°",
        "window roof_light: 2.00 m²",
        "window west_blind: 1.00 m² facing 270°",
        "sensors Workplane: 24",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(!folder.path().join("out").exists());
    let without = lucarne(folder.path(), &["plan", &model]);
    assert!(!without.status.success() && text(&without.stderr).contains("add --weather city.epw"), "{}", text(&without.stderr));
    fs::write(folder.path().join("p.toml"), "").unwrap();
    let both = lucarne(folder.path(), &["plan", "p.toml", "--weather", "day.wea"]);
    assert!(text(&both.stderr).contains("take --weather out"), "{}", text(&both.stderr));
    let pickled = folder.path().join("room.hbpkl");
    fs::write(&pickled, b"\x80\x04").unwrap();
    let refused = lucarne(folder.path(), &["run", "room.hbpkl", "--weather", "day.wea", "-o", "out"]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("from_hbpkl"), "{}", text(&refused.stderr));
}

#[test]
fn scene_info_says_what_files_hold() {
    let folder = folder();
    let model = model().display().to_string();
    let said = text(&lucarne(folder.path(), &["scene", "info", &model]).stdout);
    for words in ["material light_walls", "45.42 m² in 4 surfaces  plastic, reflectance", "sensors Corridor: 8", "view desk", "doubt: "] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let json = lucarne(folder.path(), &["scene", "info", "--json", &model]);
    let value: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((value["windows"].as_array().unwrap().len(), value["doubled"].as_array().unwrap().len()), (5, 0));
    fs::write(folder.path().join("m.rad"), "void plastic wall 0 0 5 .5 .5 .5 0 0\n").unwrap();
    fs::write(folder.path().join("room.obj"), "v 0 0 0\nv 2000 0 0\nv 2000 2000 0\nusemtl wall\nf 1 2 3\n").unwrap();
    let said = text(&lucarne(folder.path(), &["scene", "info", "m.rad", "room.obj"]).stdout);
    assert!(said.contains("2000000.00 m² in 1 surfaces") && said.contains("lengths look like millimetres"), "{said}");
    let missing = lucarne(folder.path(), &["scene", "info", "room.obj"]);
    assert!(!missing.status.success() && text(&missing.stderr).contains("void plastic wall"), "{}", text(&missing.stderr));
}

#[test]
fn a_model_runs_as_it_is() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = folder();
    let project = format!(
        "[weather]\nfile = \"day.wea\"\n[scene]\nmodel = \"{}\"\n[method]\nbounces = 2\n[quality]\npreset = \"draft\"\n",
        model().display()
    );
    fs::write(folder.path().join("p.toml"), project).unwrap();
    let run = lucarne(folder.path(), &["run", "p.toml", "-o", "out"]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    let table = |name: &str| fs::read_to_string(folder.path().join(format!("out/illuminance/{name}.csv"))).unwrap();
    for name in ["Workplane", "Corridor"] {
        let lit = table(name).lines().filter(|l| l.split(',').skip(3).any(|v| v.trim().parse::<f64>().is_ok_and(|v| v > 50.0))).count();
        assert!(lit >= 8, "{name}: {lit} hours");
    }
}

#[test]
fn a_model_gives_the_light_of_all_states_of_its_groups() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = folder();
    let run = |name: &str, more: &str| {
        let project = format!(
            "[weather]\nfile = \"day.wea\"\n[scene]\nmodel = \"{}\"\n[method]\nbounces = 2\nphases = 3\n[quality]\npreset = \"draft\"\n{more}",
            model().display()
        );
        fs::write(folder.path().join(format!("{name}.toml")), project).unwrap();
        let run = lucarne(folder.path(), &["run", &format!("{name}.toml"), "-o", name]);
        assert!(run.status.success(), "{}", text(&run.stderr));
        text(&run.stderr)
    };
    let said = run("out", "");
    assert!(said.contains("nothing decides the state of the windows 'facade'"), "{said}");
    for state in ["0_facade", "1_facade"] {
        for sensors in ["Workplane", "Corridor"] {
            let file = folder.path().join(format!("out/illuminance/states/facade/{state}/{sensors}.mtx"));
            assert!(file.is_file(), "{}", file.display());
        }
    }
    // A schedule of a state that stays: darker panes, less light at each sensor that sees them.
    run("dark", "[control]\nfacade = \"1_facade\"\n");
    let sum = |name: &str| -> f64 {
        let table = fs::read_to_string(folder.path().join(name).join("illuminance/Workplane.csv")).unwrap();
        table.lines().skip(1).flat_map(|l| l.split(',').skip(3)).filter_map(|v| v.trim().parse::<f64>().ok()).sum()
    };
    let (open, dark) = (sum("out"), sum("dark"));
    assert!(dark > 0.3 * open && dark < 0.95 * open, "{open} {dark}");
}
