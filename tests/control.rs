//! Façades whose states the run decides: rules, LM-83's blinds and the best of each step, each against the same found by
//! hand from what the run wrote.

mod device;
#[path = "../src/testing.rs"]
mod testing;
mod two_windows;

use device::device;
use lucarne::Warnings;
use lucarne::control::optimum::{Aim, Lights, Limit, Problem, optimum};
use lucarne::control::{Facade, Group};
use lucarne::gpu::Device;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::metrics::Metric;
use lucarne::progress::Silent;
use lucarne::simulate::project::metrics::MetricsSection;
use lucarne::simulate::year::metrics::judge_folder;
use lucarne::simulate::{Plan, Project, Summary, Year};
use std::path::Path;
use two_windows::LOUVRE;

const OPEN: &str = "[[window.state]]\nname = \"open\"\nglass = 0.65\n";

fn slats() -> String {
    format!("[[window.state]]\nname = \"slats\"\nbsdf = \"{LOUVRE}\"\nshade = \"slats.rad\"\n")
}

/// The west window with two states, the east one with three, seen by desks and eyes.
fn both() -> String {
    let window = |name: &str| format!("[[window]]\nname = \"{name}\"\nsurface = \"{name}.rad\"\n");
    let shut = format!("[[window.state]]\nname = \"shut\"\nbsdf = \"{LOUVRE}\"\n");
    let [west, east] = ["west", "east"].map(window);
    let sensors = ["desks", "eyes"].map(|name| format!("[[sensors]]\nname = \"{name}\"\npoints = \"{name}.txt\"\n")).concat();
    west + OPEN + &slats() + &east + OPEN + &slats() + &shut + &sensors.replace("desks.txt", "points.txt") + "[method]\nphases = 5\n"
}

/// The west window alone, with states open and slats.
fn one() -> String {
    "[[window]]\nname = \"west\"\nsurface = \"west.rad\"\n".to_string()
        + OPEN
        + &slats()
        + "[[sensors]]\nname = \"desks\"\npoints = \"points.txt\"\n[method]\nphases = 5\n"
}

/// The west window of three phases, open or behind scattering data.
fn three() -> String {
    let shut = format!("[[window.state]]\nname = \"slats\"\nbsdf = \"{LOUVRE}\"\n");
    one().replace(&slats(), &shut).replace("phases = 5", "phases = 3")
}

fn project(folder: &Path, weather: &str, rest: &str) -> lucarne::Result<Project> {
    let text = format!("[weather]\n{weather}\n[scene]\nfiles = [\"room.rad\"]\n[quality]\npreset = \"draft\"\nseed = 3\n{rest}");
    std::fs::write(folder.join("project.toml"), text).unwrap();
    Project::read(&folder.join("project.toml"))
}

fn run(device: &Device, folder: &Path, rest: &str, out: &str) -> (Summary, String) {
    run_in(device, folder, "file = \"day.wea\"", rest, out)
}

fn run_in(device: &Device, folder: &Path, weather: &str, rest: &str, out: &str) -> (Summary, String) {
    let mut warnings = Warnings::new();
    let project = project(folder, weather, rest).unwrap_or_else(|e| panic!("{e}"));
    let plan = Plan::new(project, &mut warnings).unwrap_or_else(|e| panic!("{e}"));
    let summary = plan.write(device, &folder.join(out), &Silent, &mut warnings).unwrap_or_else(|e| panic!("{e}"));
    (summary, warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

fn read(path: &Path) -> Matrix<f32> {
    read_matrix(path).unwrap_or_else(|e| panic!("{e}")).matrix
}

/// A column of a table.
fn column(path: &Path, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap();
    let place = text.lines().next().unwrap().split(',').position(|c| c == name).unwrap_or_else(|| panic!("no {name}: {text}"));
    text.lines().skip(1).map(|l| l.split(',').nth(place).unwrap().to_string()).collect()
}

fn numbers(path: &Path, name: &str) -> Vec<f64> {
    column(path, name).iter().map(|v| v.parse().unwrap_or(f64::NAN)).collect()
}

fn metric<'m>(metrics: &'m [Metric], name: &str) -> &'m Metric {
    metrics
        .iter()
        .find(|m| m.name == name)
        .unwrap_or_else(|| panic!("no {name}: {:?}", metrics.iter().map(|m| &m.name).collect::<Vec<_>>()))
}

fn same_files(a: &Path, b: &Path, names: &[&str]) {
    for name in names {
        let bytes = |folder: &Path| std::fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(bytes(a) == bytes(b), "{name} differs");
    }
}

const RESULTS: [&str; 10] = [
    "control/schedule.csv",
    "illuminance/desks.mtx",
    "illuminance/desks_standard_error.mtx",
    "illuminance/desks_annual.csv",
    "illuminance/states/west/slats/desks.mtx",
    "metrics/metrics.csv",
    "matrices/V_desks.mtx",
    "images/seat/img_1908.hdr",
    "glare/image.dgp",
    "glare/seat.csv",
];

#[test]
fn a_rule_gives_the_bits_of_the_table_of_states_that_it_chose() {
    let Some(device) = device("control by rules") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    let seen =
        "[[view]]\nname = \"seat\"\nfile = \"v.vf\"\nresolution = [24, 24]\n[images]\nhours = [1908, 1911]\n[glare]\nmethod = \"image\"\n";
    for (i, (rule, signal, limit)) in [
        ("slats if irradiance > 300 W/m2; else open", "west: irradiance on west (W/m2)", 300.0),
        ("slats if mean illuminance of desks > 1200 lx", "west: mean illuminance of desks (lx)", 1200.0),
        ("slats if sun on desks > 1000 lx", "west: sun on desks (lx)", 1000.0),
    ]
    .into_iter()
    .enumerate()
    {
        let with = |control: &str| format!("{}{seen}[control]\nwest = {control}\n", one());
        let (by_rule, by_table) = (format!("rule{i}"), format!("table{i}"));
        let (summary, _) = run(&device, folder, &with(&format!("{{ rule = \"{rule}\" }}")), &by_rule);
        let out = folder.join(&by_rule);
        let states = column(&out.join("control/schedule.csv"), "west");
        let (signals, reasons) = (numbers(&out.join("control/signals.csv"), signal), column(&out.join("control/reasons.csv"), "west"));
        println!("{rule}: {signals:.0?}");
        for step in 0..24 {
            let closed = signals[step] > limit;
            assert_eq!((states[step] == "slats", reasons[step] == "clause 1"), (closed, closed), "{rule}: {step}");
        }
        assert!(states.contains(&"slats".into()) && states.contains(&"open".into()), "{rule}: {states:?}");
        let control = summary.control.unwrap();
        assert_eq!((control.groups[0].by.as_str(), control.groups[0].rule.as_str()), ("rule", rule));
        std::fs::copy(out.join("control/schedule.csv"), folder.join("chosen.csv")).unwrap();
        run(&device, folder, &with("\"chosen.csv\""), &by_table);
        same_files(&out, &folder.join(&by_table), &RESULTS);
        assert!(!folder.join(&by_table).join("control/reasons.csv").exists());
        // Once more, from what is kept: as if it had been stopped after the last matrix.
        let before: Vec<Vec<u8>> = RESULTS.iter().map(|name| std::fs::read(out.join(name)).unwrap()).collect();
        let (again, _) = run(&device, folder, &with(&format!("{{ rule = \"{rule}\" }}")), &by_rule);
        assert_eq!(again.rays, 0, "{:?}", again.matrices);
        assert!(RESULTS.iter().zip(&before).all(|(name, bytes)| std::fs::read(out.join(name)).unwrap() == *bytes));
        // Another rule in the same folder asks for pictures of other suns at most.
        let (other, _) = run(&device, folder, &format!("{}[control]\nwest = {{ rule = \"slats if time >= 12\" }}\n", one()), &by_rule);
        assert_eq!(other.rays, 0, "{:?}", other.matrices);
        assert_eq!(column(&out.join("control/schedule.csv"), "west")[12..], ["slats"; 12].map(String::from));
    }
}

#[test]
fn light_on_the_facade_is_that_of_the_sky_before_it() {
    let Some(device) = device("control by rules") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    // Half of a uniform sky and half of the ground: 10,000 lx on the ground, 0.2 of it back.
    let rule = |rule: &str| format!("{}[control]\nwest = {{ rule = \"{rule}\" }}\n", three());
    let uniform = "sky = \"cie uniform\"";
    run_in(&device, folder, uniform, &rule("slats if illuminance > 6000 lx"), "uniform");
    let lux = numbers(&folder.join("uniform/control/signals.csv"), "west: illuminance on west (lx)");
    assert!((lux[0] / 6000.0 - 1.0).abs() < 2e-3, "{lux:?}");
    // A sensor there that sees all of the sun's radiation, the sun where it stands; D has it in the middle of its patch.
    run(&device, folder, &rule("slats if irradiance > 500 W/m2 or profile angle > 40 or altitude > 60"), "rule");
    let signals = folder.join("rule/control/signals.csv");
    std::fs::write(folder.join("outside.txt"), "1 -0.01 1.7 0 -1 0\n").unwrap();
    let outside = "[[sensors]]\nname = \"facade\"\npoints = \"outside.txt\"\n[output]\nquantity = \"irradiance\"\n";
    run(&device, folder, outside, "outside");
    let watts = read(&folder.join("outside/irradiance/facade.mtx"));
    let found = numbers(&signals, "west: irradiance on west (W/m2)");
    println!("{found:.0?}\n{:.0?}", watts.row(0));
    for step in 8..17 {
        let wanted = f64::from(watts.at(0, step)[0]);
        // Patches are up to 6° wide (MF:4 at 24 sectors has 3.75°): the sun's cosine is off by 3° at most.
        assert!((found[step] - wanted).abs() < 500.0 * 3f64.to_radians() + 0.02 * wanted, "{step}: {} {wanted}", found[step]);
    }
    // At the equinox the profile angle of a south wall is the colatitude, all day.
    for (step, angle) in numbers(&signals, "west: profile angle on west (deg)").into_iter().enumerate() {
        // Where the sun rises and sets, next to the wall's plane, a little off is much.
        match step {
            8..16 => assert!((angle - 45.0).abs() < 1.0, "{step}: {angle}"),
            6 | 7 | 16 | 17 => {}
            _ => assert!(angle.is_nan(), "{step}: {angle}"),
        }
    }
    assert!(numbers(&signals, "west: altitude (deg)")[0] < 0.0);
}

#[test]
fn lm83_closes_just_the_blinds_that_it_must() {
    let Some(device) = device("LM-83's blinds") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    let control = "[control]\nwest = \"lm-83\"\neast = { lm-83 = [\"open\", \"slats\"] }\n";
    let (summary, told) = run(&device, folder, &(both() + control), "out");
    let out = folder.join("out");
    let sun = |window: &str, state: &str| read(&out.join(format!("illuminance/states/{window}/{state}/desks_direct.mtx")));
    let all = ["west", "east"].map(|window| ["open", "slats"].map(|state| sun(window, state)));
    let chosen = ["west", "east"].map(|window| column(&out.join("control/schedule.csv"), window));
    let reasons = column(&out.join("control/reasons.csv"), "west");
    let mut counts = [0; 3];
    let mut above = 0.0;
    for step in 0..24 {
        // Of four sensors none may be in the sun.
        let fits = |closed: [usize; 2]| (0..4).all(|s| all[0][closed[0]].at(s, step)[0] + all[1][closed[1]].at(s, step)[0] <= 1000.0);
        let ways = [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().filter(|c| fits(*c));
        let counts_for_lm83 = (8..18).contains(&step);
        let fewest = if counts_for_lm83 { ways.map(|c| c[0] + c[1]).min() } else { Some(0) };
        let closed = [0, 1].map(|g| usize::from(chosen[g][step] == "slats"));
        assert_eq!(closed[0] + closed[1], fewest.unwrap_or(2), "{step}");
        assert!(!counts_for_lm83 || fewest.is_none() || fits(closed), "{step}");
        assert_eq!(reasons[step] == "too much sun in any state", fewest.is_none(), "{step}");
        above += if fewest.is_none() { 1.0 } else { 0.0 };
        counts[closed[0] + closed[1]] += 1;
    }
    println!("none, one, two closed: {counts:?}, {above} h above");
    assert!(counts[0] > 15 && counts[1] + counts[2] > 2);
    let found = summary.control.as_ref().unwrap();
    assert_eq!((found.lm83_blinds, found.lm83_hours_above), (true, Some(above)));
    assert_eq!(told.contains("with all blinds closed"), above > 0.0, "{told}");
    // A day of four sensors is not LM-83's, but its blinds are.
    let share = metric(&summary.sensors[0].metrics, "da300_spatial_share");
    assert!(share.lm83_conformant == Some(false) && !share.notes.iter().any(|n| n.contains("blinds are not moved")), "{share:?}");
    assert!(share.notes.iter().any(|n| n.contains("m apart")) && share.notes.iter().any(|n| n.contains("10 h of LM-83's 3650 h")));
    // One window without such blinds, and it is not.
    let (summary, _) = run(&device, folder, &(both() + "[control]\nwest = \"lm-83\"\n"), "half");
    assert!(!summary.control.unwrap().lm83_blinds);
    assert!(metric(&summary.sensors[0].metrics, "da300_spatial_share").notes[0].contains("blinds are not moved"));
}

#[test]
fn sda_of_a_year_with_its_blinds_is_lm83s_and_ase_knows_none() {
    let Some(device) = device("LM-83's blinds") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    let desks: String = (0..24).map(|i| format!("{} {} 0.8 0 0 1\n", 0.6 + 0.6 * f64::from(i % 4), 0.6 + 0.6 * f64::from(i / 4))).collect();
    std::fs::write(folder.join("points.txt"), desks).unwrap();
    let weather = format!("file = \"{}\"", testing::new_york().display());
    let coarse = |text: String| text.replace("phases = 5\n", "phases = 5\nsuns = 1\nsky_subdivision = 1\n");
    let (summary, _) = run_in(&device, folder, &weather, &coarse(one() + "[control]\nwest = \"lm-83\"\n"), "blinds");
    let bare = one().replace(&(OPEN.to_string() + &slats()), "glass = 0.65\n");
    let (open, _) = run_in(&device, folder, &weather, &coarse(bare), "open");
    let (with, without) = (&summary.sensors[0].metrics, &open.sensors[0].metrics);
    let (sda, share) = (metric(with, "sda_300_50"), metric(without, "da300_spatial_share"));
    println!("{:?} with blinds, {:?} without; {:?}", sda.value, share.value, summary.control);
    assert_eq!((sda.lm83_conformant, sda.source.as_str()), (Some(true), "IES LM-83-12"));
    assert!(sda.title.starts_with("LM-83 sDA300/50%") && sda.value.unwrap() < share.value.unwrap());
    assert!(share.notes[0].contains("blinds are not moved") && with.iter().all(|m| m.name != "da300_spatial_share"));
    let (ase, bare) = (metric(with, "ase_1000_250"), metric(without, "ase_1000_250"));
    assert_eq!((ase.value, ase.standard_error, ase.lm83_conformant), (bare.value, bare.standard_error, Some(true)), "{ase:?} {bare:?}");
    assert!(ase.value.unwrap() > 0.0);
    // The folder alone says the same.
    let again = judge_folder(&folder.join("blinds"), &MetricsSection::default()).unwrap();
    let again = metric(&again, "sda_300_50");
    assert_eq!((again.value, &again.notes, again.lm83_conformant), (sda.value, &sda.notes, Some(true)));
}

/// The best combination of each step by trying all: states of west and east, whether it meets the limit, its aim.
fn by_hand(
    light: &[Vec<Matrix<f32>>; 2],
    eyes: &[Vec<Matrix<f32>>; 2],
    step: usize,
    most_at_eyes: f64,
    aim: &dyn Fn(&[f64]) -> f64,
) -> [usize; 2] {
    let at = |of: &[Vec<Matrix<f32>>; 2], c: [usize; 2], sensor: usize| -> f64 {
        (0..2).map(|g| f64::from(of[g][c[g]].at(sensor, step)[0]).max(0.0)).sum()
    };
    let all: Vec<[usize; 2]> = (0..2).flat_map(|a| (0..3).map(move |b| [a, b])).collect();
    let judged = |c: &[usize; 2]| {
        let eye = (0..2).map(|s| at(eyes, *c, s)).fold(0.0, f64::max);
        let desks: Vec<f64> = (0..4).map(|s| at(light, *c, s)).collect();
        ((eye / most_at_eyes - 1.0).max(0.0), aim(&desks))
    };
    // The least excess, then the most of the aim, then the first.
    let mut best = (all[0], judged(&all[0]));
    for c in &all[1..] {
        let (excess, gain) = judged(c);
        if excess < best.1.0 || (excess == best.1.0 && gain > best.1.1) {
            best = (*c, (excess, gain));
        }
    }
    best.0
}

#[test]
fn the_optimum_of_a_run_is_the_best_of_all_combinations_of_what_it_wrote() {
    let Some(device) = device("optimal states") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    let control = "[control]\nwest = \"optimal\"\neast = \"optimal\"\n[optimal]\neyes = \"eyes\"\n";
    type Gain = fn(&[f64]) -> f64;
    let daylight: Gain = |lux| lux.iter().sum::<f64>() / 4.0;
    let lighting: Gain = |lux| -lux.iter().map(|e| 0.1 + 0.9 * (1.0 - e / 700.0).max(0.0)).sum::<f64>() / 4.0;
    for (aim, limit, gain) in [("daylight", 0.3, daylight), ("lighting", 0.32, lighting)] {
        let target = if aim == "lighting" { "target = 700\n" } else { "" };
        let asked = format!("{}{control}aim = \"{aim}\"\ndgps = {limit}\n{target}", both());
        let (summary, told) = run(&device, folder, &asked, aim);
        let out = folder.join(aim);
        let light = |sensors: &str| {
            [("west", &["open", "slats"][..]), ("east", &["open", "slats", "shut"])].map(|(window, states)| {
                let of = |state: &&str| read(&out.join(format!("illuminance/states/{window}/{state}/{sensors}.mtx")));
                states.iter().map(of).collect::<Vec<_>>()
            })
        };
        let (desks, eyes) = (light("desks"), light("eyes"));
        let chosen = ["west", "east"].map(|window| column(&out.join("control/schedule.csv"), window));
        let most = (limit - 0.184) / 6.22e-5;
        let names = ["open", "slats", "shut"];
        let mut different = std::collections::BTreeSet::new();
        for step in 0..24 {
            let best = by_hand(&desks, &eyes, step, most, &gain);
            assert_eq!([0, 1].map(|g| chosen[g][step].as_str()), best.map(|s| names[s]), "{aim}, {step}");
            different.insert(best);
        }
        println!("{aim}: {different:?}");
        assert!(different.len() > 1);
        let found = summary.control.as_ref().unwrap();
        assert_eq!(found.optimal_may_be_lost, Some(0.0));
        assert_eq!(told.contains("no combination of states meets the limits"), found.optimal_hours_above.unwrap() > 0.0);
        // A value for each state and group, none below nothing.
        assert_eq!(found.values.len(), 7);
        assert!(found.values.iter().all(|v| v.lost >= -1e-9), "{:?}", found.values);
        let values = std::fs::read_to_string(out.join("control/values.csv")).unwrap();
        assert!(values.starts_with("group,without,lost,more_hours_above\nwest,open,") && values.lines().count() == 8, "{values}");
        // The light of the run is the light that was chosen.
        let lux = read(&out.join("illuminance/desks.mtx"));
        for (step, sensor) in (0..24).flat_map(|step| (0..4).map(move |s| (step, s))) {
            let state = |g: usize| names.iter().position(|n| *n == chosen[g][step]).unwrap();
            let wanted: f32 = (0..2).map(|g| desks[g][state(g)].at(sensor, step)[0]).sum();
            assert!(
                (lux.at(sensor, step)[0] - wanted).abs() <= 2e-6 * wanted.max(1.0),
                "{aim}, {step}: {} {wanted}",
                lux.at(sensor, step)[0]
            );
        }
    }
    // Fewest moves, never more than the best of each step has.
    let asked = format!("{}{control}aim = \"moves\"\ndgps = 0.3\n", both());
    let (summary, _) = run(&device, folder, &asked, "moves");
    let moves = |s: &Summary| s.groups.iter().map(|g| g.moves).sum::<usize>();
    let steady = run(&device, folder, &format!("{}{control}dgps = 0.3\n", both()), "daylight").0;
    println!("moves: {} in place of {}", moves(&summary), moves(&steady));
    assert!(moves(&summary) <= moves(&steady) && summary.control.unwrap().values.is_empty());
}

/// Light of four windows with ten states each at 500 sensors and 20 eyes: of each window its own part of the room, and of each
/// state its transmittance, more or less.
struct Office;

impl Lights for Office {
    fn fill(&self, step: usize, values: &mut [f64]) {
        let noise = |i: usize| {
            let mixed = (step * 50_021 + i).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (i << 7);
            0.8 + 0.4 * ((mixed >> 40) as f64 / f64::from(1 << 24)).fract()
        };
        values.fill(0.0);
        for (place, state) in values[520..].chunks_mut(520).enumerate() {
            let (group, transmittance) = (place / 10, 0.7 - 0.07 * (place % 10) as f64);
            let outdoors = 6000.0 * noise(group) * (1.0 + ((step + 3 * group) % 9) as f64);
            for (i, value) in state.iter_mut().enumerate() {
                let away = ((i % 25) as f64 - 6.0 * group as f64).abs() / 6.0;
                *value = outdoors * transmittance * noise(520 * place + i) / (1.0 + away * away) * if i < 500 { 0.2 } else { 0.25 };
            }
        }
    }
}

/// Its time for a year is 87.6 times this one's.
#[test]
fn the_optimum_of_four_groups_with_ten_states_is_exact_at_500_sensors() {
    let groups = (0..4).map(|g| Group::new(format!("g{g}"), &(0..10).map(|s| format!("s{s}")).collect::<Vec<_>>()).unwrap());
    let facade = Facade::new(groups.collect()).unwrap();
    for aim in [Aim::Daylight, Aim::Lighting { target: 500.0, least: 0.1 }] {
        let limits = (500..520).map(|channel| Limit::Most { channel, limit: 3473.0 }).collect();
        let problem = Problem { states: vec![10; 4], sensors: 500, channels: 520, wholes: 0, limits, aim, most_visits: Problem::EXACT };
        let clock = std::time::Instant::now();
        let found = optimum(&problem, &facade, &Office, 100).unwrap();
        println!("{aim:?}: {:.2} s for 100 steps, {} above the limits", clock.elapsed().as_secs_f64(), found.remaining.len());
        assert!(found.may_be_lost.iter().all(|l| *l == 0.0));
        assert!((0..4).any(|g| found.schedule.constant_state(g).is_none()));
    }
}

#[test]
fn dgp_of_a_view_decides_by_rules_and_limits_the_optimum() {
    let Some(device) = device("control by glare") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    for method in ["image", "imageless", "dgps", "edgps"] {
        let seen = format!("{}[[view]]\nname = \"seat\"\nfile = \"v.vf\"\nresolution = [24, 24]\n[glare]\nmethod = \"{method}\"\n", one());
        // Without control each state has its own results.
        run(&device, folder, &seen, &format!("{method} each"));
        let each = Year::open(&folder.join(format!("{method} each"))).unwrap();
        let of = |state: &str| each.glare.iter().find(|g| g.state == state).unwrap().dgp.clone();
        let (open, slats) = (of("open"), of("slats"));
        let lit: Vec<usize> = (0..24).filter(|h| !open[*h].is_nan()).collect();
        let mut sorted: Vec<f64> = lit.iter().map(|h| open[*h]).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        // In the middle of the widest gap: what the rule looked at is written with three digits.
        let gap = |i: &usize| sorted[*i] - sorted[i - 1];
        let widest = (2..sorted.len() - 1).max_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap();
        let limit = (1e4 * (sorted[widest - 1] + sorted[widest]) / 2.0).round() / 1e4;
        let rule = format!("slats if dgp of seat > {limit}");
        run(&device, folder, &format!("{seen}[control]\nwest = {{ rule = \"{rule}\" }}\n"), &format!("{method} rule"));
        let out = folder.join(format!("{method} rule/control"));
        let (states, found) = (column(&out.join("schedule.csv"), "west"), numbers(&out.join("signals.csv"), "west: dgp of seat"));
        for step in &lit {
            assert!((found[*step] - open[*step]).abs() < 6e-4, "{method}, {step}: {} {}", found[*step], open[*step]);
            assert_eq!(states[*step] == "slats", found[*step] > limit, "{method}, {step}: {}", found[*step]);
        }
        let closed = lit.iter().filter(|h| states[**h] == "slats").count();
        println!("{method}: limit {limit}, closed in {closed} of {} hours", lit.len());
        assert!(closed > 1 && closed < lit.len() - 1);
        // The best state: the brighter of those below the limit, or that with less glare.
        let asked = format!("{seen}[control]\nwest = \"optimal\"\n[optimal]\ndgp = {limit}\nviews = \"seat\"\n");
        let (summary, _) = run(&device, folder, &asked, &format!("{method} best"));
        let best = folder.join(format!("{method} best"));
        let states = column(&best.join("control/schedule.csv"), "west");
        let light = ["open", "slats"].map(|state| read(&best.join(format!("illuminance/states/west/{state}/desks.mtx"))));
        let mut above = 0.0;
        for step in &lit {
            let (a, b) = (open[*step], slats[*step]);
            let [bright, dim] = [0, 1].map(|s| (0..4).map(|sensor| f64::from(light[s].at(sensor, *step)[0])).sum::<f64>());
            let is_open = match (a <= limit, b <= limit) {
                (true, true) => bright >= dim,
                (false, false) => a <= b,
                (is_open, _) => is_open,
            };
            let wanted = if is_open { "open" } else { "slats" };
            above += if a > limit && b > limit { 1.0 } else { 0.0 };
            assert_eq!(states[*step], wanted, "{method}, {step}: {a} {b}");
        }
        assert_eq!(summary.control.unwrap().optimal_hours_above, Some(above), "{method}");
        // And the year as decided keeps the limit.
        let year = Year::open(&folder.join(format!("{method} best"))).unwrap();
        let dgp = &year.glare.iter().find(|g| g.state.is_empty()).unwrap().dgp;
        let noise = |h: usize| 4.0 * year.glare.iter().find(|g| g.state.is_empty()).unwrap().standard_error[h];
        assert!(lit.iter().filter(|h| dgp[**h] > limit + noise(**h)).count() as f64 <= above);
    }
}

#[test]
fn what_cannot_be_decided_is_refused_and_what_will_be_is_planned() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    let said = |rest: &str| {
        let mut warnings = Warnings::new();
        let read = project(folder, "file = \"day.wea\"", rest).and_then(|project| Plan::new(project, &mut warnings));
        read.map(|plan| plan.outline().unwrap().to_string()).map_err(|e| e.to_string())
    };
    let rule = |text: &str| format!("{}[control]\nwest = {{ rule = \"{text}\" }}\n", one());
    let outline = said(&rule("slats if occupied and irradiance > 200 W/m2")).unwrap();
    for words in ["group west: 2 states", "by the rule", "slats if occupied", "8:00 to 18:00", "Cds of states"] {
        assert!(outline.contains(words), "no '{words}' in: {outline}");
    }
    let asked = |text: &str| format!("{}[control]\n{text}", both());
    for (rest, words) in [
        (rule("shut if irradiance > 200"), &["has no state 'shut'", "column 1", "project.toml"][..]),
        (rule("slats if irradiance > 300 until irradiance > 200"), &["contradicts itself"]),
        (rule("slats if mean illuminance of chairs > 300 lx"), &["no group of sensors 'chairs'"]),
        (rule("slats if dgp of seat > 0.4"), &["view"]),
        (rule("slats if dgp of seat > 0.4") + "[[view]]\nname = \"seat\"\nfile = \"v.vf\"\nresolution = [24, 24]\n", &["[glare]"]),
        (one() + "[control]\nwest = \"optimal\"\n[optimal]\ndgp = 0.4\n", &["needs views"]),
        (one() + "[control]\nwest = { rul = \"x\" }\n", &["either a 'rule' or 'lm-83'"]),
        (one() + "[control]\nwest = \"slats if irradiance > 2\"\n", &["neither a state", "{ rule = "]),
        (one() + "[control]\nwest = \"optimum\"\n", &["did you mean \"optimal\"?"]),
        (one() + "[control]\nwest = \"optimal\"\n", &["nothing tells what is best", "[optimal]"]),
        (one() + "[control]\nwest = \"open\"\n[optimal]\nmost = 3000\n", &["no group", "optimal"]),
        (one() + "[control]\nwest = { lm-83 = [\"open\", \"closed\"] }\n", &["no state 'closed'"]),
        (one() + "[control]\nwest = { lm-83 = [\"open\", \"open\"] }\n", &["two states, open and closed"]),
        (one() + "[control]\nwest = \"optimal\"\n[optimal]\naim = \"daylight\"\n", &["without any limit"]),
        (one() + "[control]\nwest = \"optimal\"\n[optimal]\neyes = \"eye\"\n", &["no [[sensors]] with the name 'eye'"]),
        (rule("slats if irradiance > 200") + "[output]\nquantity = \"irradiance\"\n", &["irradiance", "lux"]),
        (asked("west = { rule = \"slats if sun on desks > 1000\" }\neast = \"lm-83\"\n"), &["looks at light indoors", "'east'"]),
        (three().replace("phases = 3", "phases = 2") + "[control]\nwest = { rule = \"slats if time > 12\" }\n", &["phases = 2"]),
    ] {
        let error = said(&rest).map(|_| panic!("{rest}")).unwrap_err();
        assert!(words.iter().all(|w| error.contains(w)), "{words:?} not in: {error}");
    }
    std::fs::write(folder.join("office.csv"), "1\n".repeat(22)).unwrap();
    let error = said(&(rule("slats if occupied") + "[metrics]\noccupancy = \"office.csv\"\n")).unwrap_err();
    assert!(error.contains("22 values"), "{error}");
}

#[test]
fn what_shows_in_the_run_is_refused_or_told_there() {
    let Some(device) = device("control by rules") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    two_windows::write(folder, 2.5);
    let refused = |weather: &str, rest: &str| {
        let plan = Plan::new(project(folder, weather, rest).unwrap(), &mut Warnings::new()).unwrap();
        plan.write(&device, &folder.join("refused"), &Silent, &mut Warnings::new()).unwrap_err().to_string()
    };
    let day = "file = \"day.wea\"";
    let three = |control: &str| format!("{}[control]\nwest = {control}\n", three());
    let error = refused(day, &three("\"lm-83\""));
    assert!(error.contains("no sun is traced") && error.contains("project.toml"), "{error}");
    let error = refused(day, &three("{ rule = \"slats if sun on desks > 1000\" }"));
    assert!(error.contains("no sun is traced"), "{error}");
    let error = refused("sky = \"cie uniform\"", &three("{ rule = \"slats if altitude > 10\" }"));
    assert!(error.contains("skies of the CIE"), "{error}");
    std::fs::write(folder.join("points.txt"), "1 2 1.2 0 -1 0\n").unwrap();
    let error = refused(day, &format!("{}[control]\nwest = \"lm-83\"\n", one()));
    assert!(error.contains("face up"), "{error}");
    two_windows::write(folder, 2.5);
    // Closed blinds ask to be opened: that is told.
    let rule = "slats if sun on desks as set > 1000 lx";
    let (summary, told) = run(&device, folder, &format!("{}[control]\nwest = {{ rule = \"{rule}\" }}\n", one()), "oscillates");
    let moves = summary.control.unwrap().groups[0].oscillating_moves;
    assert!(moves.is_some_and(|n| n >= 4) && told.contains("back and forth") && told.contains("until"), "{moves:?} {told}");
}
