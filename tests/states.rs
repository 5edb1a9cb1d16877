//! Façades that move: what is computed for all states at once is what each state gives alone.

mod device;
#[path = "../src/testing.rs"]
mod testing;
mod two_windows;

use device::device;
use lucarne::Warnings;
use lucarne::gpu::Device;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::simulate::project::builder::ProjectBuilder;
use lucarne::simulate::{Plan, Project, Year};
use std::collections::BTreeMap;
use std::path::Path;
use two_windows::LOUVRE;

/// A room with two windows in its south wall, on a day with sun.
fn room(folder: &Path) -> ProjectBuilder {
    two_windows::write(folder, 1.5);
    let room = Project::builder(folder).weather("day.wea").scene(&["room.rad"]).sensors("desks", "points.txt");
    room.set("quality", "preset", "draft").set("quality", "seed", 3)
}

type Keys = BTreeMap<&'static str, String>;

/// Keys of what fills a window, in TOML.
fn state(name: &str) -> Keys {
    let keys: &[(&'static str, &str)] = match name {
        "open" => &[("glass", "0.65")],
        "slats" => &[("bsdf", LOUVRE), ("shade", "slats.rad")],
        "shut" => &[("bsdf", LOUVRE)],
        other => panic!("{other}"),
    };
    keys.iter().map(|(key, value)| (*key, (*value).to_string())).collect()
}

fn value(key: &str, text: &str) -> toml::Value {
    if key == "glass" { toml::Value::Float(text.parse().unwrap()) } else { toml::Value::String(text.to_string()) }
}

/// Adds a window in one state, or with several.
fn window(builder: ProjectBuilder, name: &str, states: &[&str]) -> ProjectBuilder {
    let mut builder = builder.begin("window").set("window", "name", name).set("window", "surface", format!("{name}.rad"));
    if let [one] = states {
        for (key, text) in state(one) {
            builder = builder.set("window", key, value(key, &text));
        }
        return builder;
    }
    let table = |name: &&str| {
        let mut table: toml::Table = state(name).iter().map(|(key, text)| (key.to_string(), value(key, text))).collect();
        table.insert("name".into(), toml::Value::String(name.to_string()));
        toml::Value::Table(table)
    };
    builder.set("window", "state", states.iter().map(table).collect::<Vec<_>>())
}

fn run(device: &Device, builder: ProjectBuilder, out: &Path) -> Year {
    let plan = Plan::new(builder.build().unwrap(), &mut Warnings::new()).unwrap();
    plan.run(device, out, &Silent, &mut Warnings::new()).unwrap()
}

fn read(path: &Path) -> Matrix<f32> {
    read_matrix(path).unwrap_or_else(|e| panic!("{e}")).matrix
}

/// Largest difference in relation to the value, of what is not next to nothing.
fn difference(found: &Matrix<f32>, wanted: &Matrix<f32>) -> f64 {
    assert_eq!((found.rows(), found.cols()), (wanted.rows(), wanted.cols()));
    let most = wanted.data().iter().copied().fold(0.0, f32::max);
    let of = |(a, b): (&f32, &f32)| f64::from((a - b).abs() / b.max(1e-3 * most));
    found.data().iter().zip(wanted.data()).map(of).fold(0.0, f64::max)
}

fn same_files(a: &Path, b: &Path, names: &[&str]) {
    for name in names {
        let bytes = |folder: &Path| std::fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(bytes(a) == bytes(b), "{name} differs");
    }
}

const RESULTS: [&str; 8] = [
    "illuminance/desks.mtx",
    "illuminance/desks_standard_error.mtx",
    "illuminance/desks_annual.csv",
    "metrics/metrics.csv",
    "matrices/V_desks.mtx",
    "images/seat/img_1908.hdr",
    "glare/image.dgp",
    "glare/seat.csv",
];

/// Hour of the day in which each state holds.
fn schedule(folder: &Path, name: &str, states: &[&str; 24]) {
    std::fs::write(folder.join(name), format!("hour,state\n{}", (0..24).map(|h| format!("{h},{}\n", states[h])).collect::<String>()))
        .unwrap();
}

#[test]
fn a_schedule_that_never_changes_is_the_run_of_its_state_to_the_bit() {
    let Some(device) = device("states of a façade") else { return };
    let folder = tempfile::tempdir().unwrap();
    let seen = |b: ProjectBuilder| b.view("seat", "v.vf", [24, 24]).set("images", "hours", [1908, 1911]).set("glare", "method", "image");
    for (phases, kept, others) in [(5, "slats", ["open", "shut"]), (3, "shut", ["open", "shut"])] {
        let with = |b: ProjectBuilder| seen(window(b, "east", &["open"])).set("method", "phases", phases);
        let alone = run(&device, with(window(room(folder.path()), "west", &[kept])), &folder.path().join(format!("alone{phases}")));
        let states = if phases == 5 { vec![others[0], kept, others[1]] } else { others.to_vec() };
        schedule(folder.path(), "always.csv", &[kept; 24]);
        for (i, control) in [kept, "always.csv"].into_iter().enumerate() {
            let moving = with(window(room(folder.path()), "west", &states)).set("control", "west", control);
            let out = folder.path().join(format!("kept{phases}{i}"));
            let year = run(&device, moving, &out);
            same_files(alone.folder(), &out, &RESULTS);
            let hours: Vec<f64> = year.summary.groups[0].states.iter().map(|s| s.hours).collect();
            assert_eq!(hours.iter().sum::<f64>(), 24.0);
            assert_eq!(hours[states.iter().position(|s| *s == kept).unwrap()], 24.0);
        }
    }
}

#[test]
fn every_hour_is_that_of_its_state_and_all_states_are_those_alone() {
    let Some(device) = device("states of a façade") else { return };
    let folder = tempfile::tempdir().unwrap();
    let names = ["open", "slats", "shut"];
    for phases in [3, 5] {
        let names = if phases == 5 { &names[..] } else { &["open", "shut"] };
        let with = |b: ProjectBuilder| b.set("method", "phases", phases);
        let alone: Vec<Year> = names
            .iter()
            .map(|name| {
                // Alone it lets no sun through, and has three phases.
                let phases = if *name == "shut" { 3 } else { phases };
                let alone = window(room(folder.path()), "west", &[name]).set("method", "phases", phases);
                run(&device, alone, &folder.path().join(format!("{name}{phases}")))
            })
            .collect();
        let of_hour: [&str; 24] = std::array::from_fn(|h| names[(h / 2) % names.len()]);
        schedule(folder.path(), "moving.csv", &of_hour);
        let out = folder.path().join(format!("moving{phases}"));
        let moving = || with(window(room(folder.path()), "west", names)).set("control", "west", "moving.csv");
        let year = run(&device, moving(), &out);
        let steps: Vec<usize> = (0..24).map(|h| names.iter().position(|n| *n == of_hour[h]).unwrap()).collect();
        let pick = |of: &dyn Fn(&Year) -> Matrix<f32>| {
            let all: Vec<Matrix<f32>> = alone.iter().map(of).collect();
            let data = (0..4).flat_map(|s| (0..24).map(|h| all[steps[h]].at(s, h)[0]).collect::<Vec<_>>()).collect();
            Matrix::from_data(4, 24, 1, data).unwrap()
        };
        let lux = difference(&year.sensors[0].illuminance, &pick(&|y| (*y.sensors[0].illuminance).clone()));
        let error = difference(year.sensors[0].standard_error.as_ref().unwrap(), &pick(&|y| y.sensors[0].standard_error.clone().unwrap()));
        println!("{phases} phases, hours of a schedule: {lux:.1e} of the light, {error:.1e} of its standard error");
        assert!(lux < 1e-6 && error < 1e-5, "{lux} {error}");
        for (name, alone) in names.iter().zip(&alone) {
            let found = read(&out.join(format!("illuminance/states/west/{name}/desks.mtx")));
            let differs = difference(&found, &alone.sensors[0].illuminance);
            println!("{phases} phases, state '{name}' in the batch: {differs:.1e}");
            // Sums of as many terms as bins, channels and halves, taken in another order in 32 bits.
            let rounding = 2.0 * f64::from(2 * 41 * 3).sqrt() * 2.0f64.powi(-24);
            assert!(differs < rounding, "{name}: {differs}");
            let direct = out.join(format!("illuminance/states/west/{name}/desks_direct.mtx"));
            assert_eq!(direct.exists(), phases == 5 && *name != "shut", "{name}");
        }
        // Another schedule asks for no rays.
        let other: [&str; 24] = std::array::from_fn(|h| names[(h / 3) % names.len()]);
        schedule(folder.path(), "moving.csv", &other);
        let again = run(&device, moving(), &out);
        assert_eq!(again.summary.rays, 0, "{:?}", again.summary.matrices);
        assert!(again.sensors[0].illuminance != year.sensors[0].illuminance);
        // The written schedule gives the same again.
        std::fs::copy(out.join("control/schedule.csv"), folder.path().join("moving.csv")).unwrap();
        assert_eq!(run(&device, moving(), &out).sensors[0].illuminance, again.sensors[0].illuminance);
    }
}

#[test]
fn the_light_of_any_combination_is_the_sum_over_the_groups() {
    let Some(device) = device("states of a façade") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (west, east) = (["open", "slats"], ["shut", "open"]);
    let both = |b: ProjectBuilder| window(window(b, "west", &west), "east", &east).set("method", "phases", 5);
    let out = folder.path().join("out");
    let of_hour = |names: [&'static str; 2], by: usize| -> [&str; 24] { std::array::from_fn(|h| names[(h / by) % 2]) };
    schedule(folder.path(), "west.csv", &of_hour(west, 1));
    schedule(folder.path(), "east.csv", &of_hour(east, 2));
    let moving = both(room(folder.path())).set("control", "west", "west.csv").set("control", "east", "east.csv");
    let year = run(&device, moving, &out);
    let light = |window: &str, state: &str| read(&out.join(format!("illuminance/states/{window}/{state}/desks.mtx")));
    let mut worst: f64 = 0.0;
    for a in west {
        for b in east {
            let mut sum = light("west", a);
            sum.data_mut().iter_mut().zip(light("east", b).data()).for_each(|(sum, v)| *sum += v);
            let alone = window(window(room(folder.path()), "west", &[a]), "east", &[b]).set("method", "phases", 5);
            let alone = run(&device, alone, &folder.path().join(format!("{a}{b}")));
            let (together, error) = (&alone.sensors[0].illuminance, alone.sensors[0].standard_error.as_ref().unwrap());
            if (a, b) == ("slats", "open") {
                // Slats scatter with other random numbers where more than they lets suns in.
                for ((sum, together), error) in sum.data().iter().zip(together.data()).zip(error.data()) {
                    assert!((sum - together).abs() <= 4.0 * std::f32::consts::SQRT_2 * error, "{sum} {together} ± {error}");
                }
            } else {
                worst = worst.max(difference(&sum, together));
            }
            // The façade as it moves, in the hours of this combination.
            let hours: Vec<usize> = (0..24).filter(|h| west[h % 2] == a && east[(h / 2) % 2] == b).collect();
            assert!(!hours.is_empty());
            for sensor in 0..4 {
                for &hour in &hours {
                    let (found, wanted) = (year.sensors[0].illuminance.at(sensor, hour)[0], sum.at(sensor, hour)[0]);
                    assert!((found - wanted).abs() <= 1e-6 * wanted.max(1.0), "{a} {b}: {found} {wanted}");
                }
            }
        }
    }
    println!("sum over two groups against one run of both: {worst:.1e}");
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn pictures_and_glare_follow_the_facade() {
    let Some(device) = device("states of a façade") else { return };
    let folder = tempfile::tempdir().unwrap();
    for method in ["image", "imageless", "dgps", "edgps"] {
        let with = |b: ProjectBuilder| {
            let b = b.view("seat", "v.vf", [24, 24]).set("glare", "method", method).set("method", "phases", 5);
            if method == "image" { b.set("images", "hours", [1906, 1907]) } else { b }
        };
        let of_hour: [&str; 24] = std::array::from_fn(|h| if h % 2 == 0 { "open" } else { "slats" });
        schedule(folder.path(), "moving.csv", &of_hour);
        let states = |b: ProjectBuilder| window(b, "west", &["open", "slats"]);
        let out = |name: &str| folder.path().join(format!("{method}{name}"));
        let year = run(&device, with(states(room(folder.path()))).set("control", "west", "moving.csv"), &out("moving"));
        let alone = ["open", "slats"].map(|name| run(&device, with(window(room(folder.path()), "west", &[name])), &out(name)));
        // Without control each state has its own results.
        let each = run(&device, with(states(room(folder.path()))), &out("each"));
        assert_eq!((year.glare.len(), each.glare.len()), (1, 2));
        for (name, alone) in ["open", "slats"].iter().zip(&alone) {
            let of_state = each.glare.iter().find(|g| g.state == *name).unwrap();
            let most =
                of_state.dgp.iter().zip(&alone.glare[0].dgp).filter(|(a, _)| !a.is_nan()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("{method}, '{name}' beside the other state: DGP differs by {most:.1e}");
            assert!(most < 2e-6, "{name}: {most}");
        }
        // Suns of some hours have other random numbers than those of all.
        for hour in (0..24).filter(|h| !year.glare[0].dgp[*h].is_nan()) {
            let wanted = &alone[hour % 2].glare[0];
            let noise = year.glare[0].standard_error[hour].hypot(wanted.standard_error[hour]);
            let (a, b) = (year.glare[0].dgp[hour], wanted.dgp[hour]);
            assert!((a - b).abs() < 4.0 * noise + 1e-6, "{method}, {hour}: DGP {a} {b} ± {noise}");
            // A wrong state is no noise.
            let other = &alone[1 - hour % 2].glare[0];
            assert!((a - other.dgp[hour]).abs() > (a - b).abs(), "{method}, {hour}: {a} is {} of the other state", other.dgp[hour]);
        }
        if method != "image" {
            continue;
        }
        for (step, hour) in [(10, 1906), (11, 1907)] {
            let name = format!("images/seat/img_{hour}.hdr");
            let sum = |folder: &Path| {
                let picture = lucarne::image::hdr::read(&folder.join(&name)).unwrap();
                picture.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>()
            };
            let (found, wanted, other) = (sum(year.folder()), sum(alone[step % 2].folder()), sum(alone[1 - step % 2].folder()));
            println!("picture of step {step}: {found:.1}, alone {wanted:.1}, in the other state {other:.1}");
            assert!((found / wanted - 1.0).abs() < 0.02 && (found / other - 1.0).abs() > 0.1);
            // And read back, of the stored matrices.
            let again: f64 = year.picture("seat", step).unwrap().pixels.iter().map(|p| f64::from(p[1])).sum();
            assert!((again / found - 1.0).abs() < 0.01, "{again} {found}");
        }
        let facade = lucarne::simulate::year::facade::Facade::read(&year).unwrap();
        let lux = facade.illuminance(&year, "desks", &Default::default(), &lucarne::kernels::product::Native).unwrap();
        let differs = difference(&lux, &year.sensors[0].illuminance);
        assert!(differs < 1e-4, "{differs}");
    }
}

#[test]
fn what_cannot_be_is_refused_and_what_is_unsaid_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let said = |builder: ProjectBuilder| {
        let mut warnings = Warnings::new();
        let read = builder.build().and_then(|project| Plan::new(project, &mut warnings)).map(|plan| plan.outline().unwrap().to_string());
        (read.map_err(|e| e.to_string()), warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    };
    let states = || window(room(folder.path()), "west", &["open", "slats"]).set("method", "phases", 5);
    let (outline, told) = said(states());
    assert!(told.contains("nothing decides the state of the windows 'west'") && told.contains("the first, 'open'"), "{told}");
    let outline = outline.unwrap();
    for words in [
        "state 'slats': louvre.xml, the sun through 14 triangles",
        "group west: 2 states, in 'open' for 24 h, never moves",
        "Cds of states",
        "light of states",
    ] {
        assert!(outline.contains(words), "no '{words}' in: {outline}");
    }
    let control = |text: &str| {
        std::fs::write(folder.path().join("bad.csv"), text).unwrap();
        states().set("control", "west", "bad.csv")
    };
    let (error, _) = said(control(&"open\n".repeat(22)));
    let error = error.unwrap_err();
    assert!(error.contains("bad.csv") && error.contains("22 rows") && error.contains("24 time steps"), "{error}");
    let (error, _) = said(control(&("open\n".repeat(3) + "clsoed\n" + &"slats\n".repeat(20))));
    let error = error.unwrap_err();
    assert!(error.contains("bad.csv") && error.contains("4") && error.contains("'clsoed'"), "{error}");
    let moving = || control(&("open\n".repeat(12) + &"slats\n".repeat(12)));
    let (outline, told) = said(moving());
    assert!(
        outline.unwrap().contains("in 'open' for 12 h, 'slats' for 12 h, moves 1 times") && !told.contains("nothing decides"),
        "{told}"
    );
    let components = moving().view("seat", "v.vf", [24, 24]).set("images", "components", true);
    assert!(said(components).0.unwrap_err().contains("component pictures are of one state"));
    let two = window(room(folder.path()), "west", &["open", "shut"]).set("method", "phases", 2).set("control", "west", "bad.csv");
    std::fs::write(folder.path().join("bad.csv"), "open\n".repeat(12) + &"shut\n".repeat(12)).unwrap();
    assert!(said(two).0.unwrap_err().contains("phases = 2 keeps daylight coefficients"));
}
