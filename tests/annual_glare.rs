//! Annual glare of the shipped office as users run it: all files, and every number against float
//! pictures of the same hours given to `lucarne glare`.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::image::exr;
use lucarne::kernels::product::Native;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::simulate::multiply::{Factor, product};
use lucarne::simulate::results::pictures::{Output, PictureView, Request, write_pictures};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;

fn office() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office")
}

fn lucarne(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_lucarne")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A copy of the office whose project has a small view, coarse matrices and these lines of glare.
fn project(folder: &Path, name: &str, windows: &str, glare: &str) -> PathBuf {
    let text = format!(
        "[weather]\nfile = \"weather/new_york.wea\"\n[scene]\nfiles = [\"materials.rad\", \"office.rad\"]\n{windows}\n\
         [[view]]\nname = \"desk\"\nfile = \"views/desk.vf\"\nresolution = [48, 48]\n\
         [glare]\n{glare}\n[quality]\npreset = \"draft\"\n"
    );
    for sub in ["weather", "windows", "bsdf", "views", "objects"] {
        std::fs::create_dir_all(folder.join(sub)).unwrap();
        for file in std::fs::read_dir(office().join(sub)).unwrap() {
            let file = file.unwrap().path();
            std::fs::copy(&file, folder.join(sub).join(file.file_name().unwrap())).unwrap();
        }
    }
    for file in ["materials.rad", "office.rad"] {
        std::fs::copy(office().join(file), folder.join(file)).unwrap();
    }
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

const WINDOWS: &str = "[[window]]\nname = \"vision\"\nsurface = \"windows/vision.rad\"\nbsdf = \"bsdf/blind.xml\"\n\
                       [[window]]\nname = \"clerestory\"\nsurface = \"windows/clerestory.rad\"\nbsdf = \"bsdf/double_clear.xml\"";

/// Rows of a CSV file by column.
fn table(text: &str) -> Vec<HashMap<String, String>> {
    let mut lines = text.lines().take_while(|l| !l.is_empty());
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines.map(|l| names.iter().map(|n| (*n).to_string()).zip(l.split(',').map(str::to_string)).collect()).collect()
}

fn csv(path: &Path) -> Vec<HashMap<String, String>> {
    table(&std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
}

fn number(row: &HashMap<String, String>, key: &str) -> f64 {
    row[key].parse().unwrap()
}

fn matrix(out: &Path, name: &str) -> Matrix<f32> {
    read_matrix(&out.join("matrices").join(format!("{name}.mtx"))).unwrap().matrix
}

/// Float pictures of some hours from the run's own matrices.
fn write_hours(out: &Path, view: &str, hours: &[usize], pattern: &str) {
    let mut data = Vec::new();
    for window in ["vision", "clerestory"] {
        let factors = ["T", "D"].map(|kind| format!("{kind}_{window}")).map(|name| Factor { matrix: matrix(out, &name), name });
        let sky = Factor { name: "S".into(), matrix: matrix(out, "S") };
        let [t, d] = factors;
        data.extend(product(&Native, vec![t, d, sky], Some(hours)).unwrap().into_data());
    }
    let bins = data.len() / hours.len() / 3;
    let coefficients = Matrix::from_data(bins, hours.len(), 3, data).unwrap();
    let mut view = PictureView::open(&out.join("matrices").join(format!("{view}.mtx")).display().to_string(), None).unwrap();
    let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
    let output = Output::parse(&out.join(pattern).display().to_string(), options).unwrap();
    let request =
        Request { coefficients: &coefficients, hours, output: &output, header: &[], memory: 1 << 28, addition: None, finished: None };
    write_pictures(&Native, &mut view, &request, &lucarne::progress::Silent, &mut Warnings::new()).unwrap();
}

#[test]
fn the_year_is_that_of_float_pictures_and_all_files_are_there() {
    if device("annual glare").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let project_file = project(folder.path(), "project.toml", WINDOWS, "method = \"image\"\noccupied = [9, 17]");
    let out = folder.path().join("out");
    lucarne(&["run", project_file.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    for file in ["desk.csv", "desk.png", "desk.svg", "annual.csv", "undecided.csv", "image.dgp"] {
        assert!(out.join("glare").join(file).metadata().unwrap().len() > 0, "{file}");
    }
    let text = std::fs::read_to_string(out.join("glare/desk.csv")).unwrap();
    assert!(text.starts_with("hour,dgp,dgp_standard_error,ev_lux,sources,class\n"));
    let year = table(&text);
    assert_eq!(year.len(), 8760);

    // Hours of every kind: the brightest, some with sources, some without, one of night.
    let mut by_dgp: Vec<usize> = (0..8760).collect();
    by_dgp.sort_by(|&a, &b| number(&year[a], "dgp").total_cmp(&number(&year[b], "dgp")));
    let lit: Vec<usize> = by_dgp.iter().copied().filter(|&h| number(&year[h], "ev_lux") > 0.0).collect();
    let mut hours: Vec<usize> = (0..24).map(|i| lit[i * (lit.len() - 1) / 23]).collect();
    hours.push(0);
    hours.sort_unstable();
    hours.dedup();
    write_hours(&out, "V_desk", &hours, "hour_%04d.exr");
    let files: Vec<String> = hours.iter().map(|h| out.join(format!("hour_{h:04}.exr")).display().to_string()).collect();
    let mut arguments = vec!["glare"];
    arguments.extend(files.iter().map(String::as_str));
    const OF_PICTURE: f64 = 1e-4;
    let (mut with_sources, mut worst) = (0, 0.0f64);
    for (row, &hour) in table(&lucarne(&arguments)).iter().zip(&hours) {
        let fused = &year[hour];
        let difference = number(row, "dgp") - number(fused, "dgp");
        assert!(difference.abs() < OF_PICTURE, "hour {hour}: DGP {} {}", row["dgp"], fused["dgp"]);
        worst = worst.max(difference.abs());
        assert_eq!(row["sources"], fused["sources"], "hour {hour}");
        let (a, b) = (number(row, "ev_lux"), number(fused, "ev_lux"));
        assert!((a - b).abs() <= 1e-4 * b + 0.01, "hour {hour}: Ev {a} {b}");
        with_sources += usize::from(number(fused, "sources") > 0.0);
    }
    assert!(with_sources > 5, "only {with_sources} hours have sources");
    let found = format!("{} hours within {}", hours.len(), testing::short(worst));
    testing::measured("annual-glare-pictures", &found, &testing::short(OF_PICTURE));

    // The summary counts what the table has.
    let annual = &csv(&out.join("glare/annual.csv"))[0];
    assert_eq!((annual["view"].as_str(), annual["occupied_hours"].as_str()), ("desk", "2920"));
    for class in ["imperceptible", "perceptible", "disturbing", "intolerable"] {
        let counted = year.iter().enumerate().filter(|(h, r)| (9..17).contains(&(h % 24)) && r["class"] == class).count();
        assert_eq!(annual[&format!("{class}_hours")], counted.to_string(), "{class}");
    }
    assert_eq!(csv(&out.join("glare/undecided.csv")).len() as f64, number(annual, "undecided_hours"));
    let dgp = read_matrix(&out.join("glare/image.dgp")).unwrap().matrix;
    assert_eq!((dgp.rows(), dgp.cols(), dgp.components()), (1, 8760, 1));
    for (value, row) in dgp.data().iter().zip(&year) {
        assert!((f64::from(*value) - number(row, "dgp")).abs() < 1e-6);
    }

    // A second run finds the matrices there and gives the same bits.
    let again = lucarne(&["run", project_file.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    drop(again);
    assert_eq!(std::fs::read_to_string(out.join("glare/desk.csv")).unwrap(), text);
    let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert!(summary["matrices"].as_array().unwrap().iter().all(|m| m["reused"] == true));
    assert_eq!(summary["glare"]["method"], "image");

    // The other ways share V of the eyes and D; all see the same light.
    let ways = ["edgps", "dgps", "imageless"].map(|method| {
        let file = project(folder.path(), &format!("{method}.toml"), WINDOWS, &format!("method = \"{method}\""));
        lucarne(&["run", file.to_str().unwrap(), "-o", out.to_str().unwrap()]);
        assert!(out.join(format!("glare/{method}.dgp")).is_file());
        csv(&out.join("glare/desk.csv"))
    });
    let mean = |rows: &[HashMap<String, String>], key: &str| rows.iter().map(|r| number(r, key)).sum::<f64>() / rows.len() as f64;
    for (way, rows) in ["edgps", "dgps", "imageless"].iter().zip(&ways) {
        // A picture of 48² pixels and the sensor's samples differ by some per cent.
        let (a, b) = (mean(rows, "ev_lux"), mean(&year, "ev_lux"));
        assert!((a / b - 1.0).abs() < 0.05, "{way}: Ev {a} {b}");
    }
    for (row, image) in ways[0].iter().zip(&year) {
        // Few sources are not windows: eDGPs is DGP here.
        assert!((number(row, "dgp") - number(image, "dgp")).abs() < 0.05, "{row:?} {image:?}");
    }
    for row in &ways[1] {
        let simplified = (6.22e-5 * number(row, "ev_lux") + 0.184).min(1.0);
        assert!((number(row, "dgp") - simplified).abs() < 1e-5);
    }
    assert!(ways[2].iter().any(|r| number(r, "sources") > 0.0));
}

#[test]
fn standard_errors_are_the_spread_over_seeds() {
    if device("annual glare").is_none() {
        return;
    }
    const SEEDS: usize = 6;
    let folder = tempfile::tempdir().unwrap();
    // One window keeps it short.
    let window = WINDOWS.split("[[window]]").nth(2).map(|w| format!("[[window]]{w}")).unwrap();
    let years: Vec<Vec<HashMap<String, String>>> = (0..SEEDS)
        .map(|seed| {
            let file = project(folder.path(), &format!("{seed}.toml"), &window, "");
            let text = std::fs::read_to_string(&file).unwrap().replace("[48, 48]", "[32, 32]");
            std::fs::write(&file, format!("{text}seed = {}\n", 11 + seed)).unwrap();
            let out = folder.path().join(format!("out{seed}"));
            lucarne(&["run", file.to_str().unwrap(), "-o", out.to_str().unwrap()]);
            csv(&out.join("glare/desk.csv"))
        })
        .collect();
    // Hours without sources (noise of Ev alone) and with the same ones; where the noise decides
    // whether a pixel is a source at all, first order is not enough.
    const FACTOR: f64 = 2.0;
    let mut ratios = Vec::new();
    for (name, wanted) in [("without sources", false), ("with sources", true)] {
        let (mut predicted, mut spread, mut hours) = (0.0, 0.0, 0);
        for hour in 0..8760 {
            let rows: Vec<_> = years.iter().map(|y| &y[hour]).collect();
            let same = rows.iter().all(|r| r["sources"] == rows[0]["sources"]);
            if !same || number(rows[0], "ev_lux") == 0.0 || (number(rows[0], "sources") > 0.0) != wanted {
                continue;
            }
            let mean = rows.iter().map(|r| number(r, "dgp")).sum::<f64>() / SEEDS as f64;
            spread += rows.iter().map(|r| (number(r, "dgp") - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
            predicted += rows.iter().map(|r| number(r, "dgp_standard_error").powi(2)).sum::<f64>() / SEEDS as f64;
            hours += 1;
        }
        // All hours share the matrices, so that their deviations are few independent ones: with 5
        // degrees of freedom the spread itself is uncertain by a third.
        let ratio = (predicted / spread).sqrt();
        eprintln!("{name}: {hours} hours, predicted over seen {ratio:.2}");
        assert!(hours > 100, "{name}: {hours} hours");
        assert!((1.0 / FACTOR..FACTOR).contains(&ratio), "{name}: predicted over seen {ratio}");
        ratios.push(testing::short(ratio));
    }
    let found = format!("{} of it without, {} with sources, {SEEDS} seeds", ratios[0], ratios[1]);
    testing::measured("annual-glare-errors", &found, &format!("factor {FACTOR}"));
}

#[test]
fn states_and_points_share_matrices_and_give_a_result_each() {
    if device("annual glare").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let states = WINDOWS.replacen("bsdf = \"bsdf/blind.xml\"", "states = [\"bsdf/blind.xml\", \"bsdf/double_clear.xml\"]", 1);
    let file = project(folder.path(), "project.toml", &states, "method = \"dgps\"");
    std::fs::write(folder.path().join("seats.txt"), "2.7 2.3 1.2 0 -1 0\n0.9 4.2 1.2 1 0 0\n").unwrap();
    let grid = "[[views]]\nname = \"seats\"\npoints = \"seats.txt\"\ndirections = [90, 180]\n";
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, format!("{grid}{text}")).unwrap();
    let out = folder.path().join("out");
    lucarne(&["run", file.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    let annual = csv(&out.join("glare/annual.csv"));
    let names: Vec<(&str, &str)> = annual.iter().map(|r| (r["view"].as_str(), r["state"].as_str())).collect();
    let views = ["desk", "seats-001-090", "seats-001-180", "seats-002-090", "seats-002-180"];
    let wanted: Vec<(&str, &str)> = views.iter().flat_map(|v| [(*v, "blind"), (*v, "double_clear")]).collect();
    assert_eq!(names, wanted);
    let year = |state: &str, view: &str| csv(&out.join(format!("glare/{state}/{view}.csv")));
    let ev = |rows: &[HashMap<String, String>]| rows.iter().map(|r| number(r, "ev_lux")).sum::<f64>();
    assert!(ev(&year("double_clear", "desk")) > 1.5 * ev(&year("blind", "desk")), "blinds keep light out");
    // The desk looks south from the first seat.
    let (desk, seat) = (year("blind", "desk"), year("blind", "seats-001-180"));
    assert!((ev(&desk) / ev(&seat) - 1.0).abs() < 0.02);
    let dgp = read_matrix(&out.join("glare/blind/dgps.dgp")).unwrap().matrix;
    assert_eq!((dgp.rows(), dgp.cols()), (5, 8760));
}

#[test]
fn several_rooms_share_matrices_and_have_one_table() {
    if device("annual glare").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let states = WINDOWS.replacen("bsdf = \"bsdf/blind.xml\"", "states = [\"bsdf/blind.xml\", \"bsdf/double_clear.xml\"]", 1);
    let clear = WINDOWS.replacen("bsdf/blind.xml", "bsdf/double_clear.xml", 1);
    let glare = "method = \"dgps\"";
    let files = [("blinds", WINDOWS), ("clear", &clear), ("both", &states)].map(|(name, windows)| {
        let file = project(folder.path(), &format!("{name}.toml"), windows, glare);
        file.to_str().unwrap().to_string()
    });
    let out = folder.path().join("out");
    let text = lucarne(&["run", &files[0], &files[1], &files[2], "-o", out.to_str().unwrap()]);
    assert!(text.contains("all 3 rooms"), "{text}");
    let annual = csv(&out.join("glare/annual.csv"));
    let column = |row: &HashMap<String, String>| ["room", "view", "state"].map(|n| row[n].clone()).join(" ");
    let rows: Vec<String> = annual.iter().map(column).collect();
    assert_eq!(rows, ["blinds desk ", "clear desk ", "both desk blind", "both desk double_clear"]);
    // One office with three façades: all is computed once, and the numbers are those of each alone.
    let summary =
        |room: &str| -> serde_json::Value { serde_json::from_slice(&std::fs::read(out.join(room).join("summary.json")).unwrap()).unwrap() };
    assert!(summary("blinds")["matrices"].as_array().unwrap().iter().all(|m| m["reused"] == false));
    for room in ["clear", "both"] {
        assert!(summary(room)["matrices"].as_array().unwrap().iter().all(|m| m["reused"] == true), "{room}");
        assert_eq!(summary(room)["rays"], 0);
    }
    let year = |path: &str| std::fs::read(out.join(path)).unwrap();
    assert!(year("both/glare/blind/desk.csv") == year("blinds/glare/desk.csv"));
    assert!(year("both/glare/double_clear/desk.csv") == year("clear/glare/desk.csv"));
    assert!(year("clear/glare/desk.csv") != year("blinds/glare/desk.csv"));
}

#[test]
fn faults_of_the_section_are_answered_with_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let complaint = |windows: &str, glare: &str| {
        let file = project(folder.path(), "project.toml", windows, glare);
        let run =
            Command::new(env!("CARGO_BIN_EXE_lucarne")).args(["run", file.to_str().unwrap(), "-o"]).arg(folder.path().join("out")).output();
        let run = run.unwrap();
        assert!(!run.status.success(), "{glare}");
        String::from_utf8(run.stderr).unwrap()
    };
    let two = WINDOWS.replacen("bsdf = \"bsdf/blind.xml\"", "states = [\"bsdf/blind.xml\", \"bsdf/double_clear.xml\"]", 1);
    let both =
        two.replacen("bsdf = \"bsdf/double_clear.xml\"", "states = [\"bsdf/blind.xml\"]", 1).replace("name = ", "group = \"all\"\nname = ");
    for (windows, glare, words) in [
        (WINDOWS, "method = \"pictures\"", &["glare.method", "\"imageless\""][..]),
        (WINDOWS, "treshold = 5", &["'treshold'", "did you mean 'threshold'?"]),
        (WINDOWS, "occupied = [18, 8]", &["glare.occupied", "[8, 18]"]),
        (WINDOWS, "threshold = -3", &["glare.threshold", "out of range"]),
        (WINDOWS, "veil = \"sun\"", &["glare.veil", "not a number"]),
        (WINDOWS, "method = \"imageless\"\nthreshold = 7", &["glare.threshold", "average"]),
        (WINDOWS, "method = \"dgps\"\nveil = 0.5", &["glare.veil", "pictures"]),
        (WINDOWS, "task = [10, 20]", &["glare.task", "opening angle"]),
        (&both, "", &["of group 'all'", "their states differ"]),
    ] {
        let text = complaint(windows, glare);
        assert!(words.iter().all(|w| text.contains(w)) && text.contains("project.toml:"), "{text}");
    }
}
