//! Named metrics: of a whole run against plain counts of its illuminance, again from the folder, and against
//! honeybee-radiance-postprocess on the same illuminance.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::metrics::blinds::{Group, operate};
use lucarne::metrics::en17037::{LEVELS_LX, Openings, Provision};
use lucarne::metrics::{Clock, Counted, Metric, Occupancy, Year, lm83};
use lucarne::progress::Silent;
use lucarne::simulate::project::metrics::{MetricsSection, OccupancyChoice};
use lucarne::simulate::year::metrics::judge_folder;
use lucarne::simulate::{Plan, Project, Summary};
use std::path::Path;
use std::process::Command;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");

fn metric<'m>(metrics: &'m [Metric], name: &str) -> &'m Metric {
    metrics
        .iter()
        .find(|m| m.name == name)
        .unwrap_or_else(|| panic!("no {name} in {:?}", metrics.iter().map(|m| &m.name).collect::<Vec<_>>()))
}

/// The columns of a table by name; empty cells are NaN.
fn column(path: &Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(path).unwrap();
    let place = text.lines().next().unwrap().split(',').position(|c| c == name).unwrap_or_else(|| panic!("no {name}: {text}"));
    text.lines().skip(1).map(|l| l.split(',').nth(place).unwrap().parse().unwrap_or(f64::NAN)).collect()
}

#[test]
fn metrics_of_a_year_are_plain_counts_of_its_illuminance() {
    let Some(device) = device("metrics of a year") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let desks: String = (0..12).map(|i| format!("{} {} 0.8 0 0 1\n", 0.4 + 0.5 * f64::from(i % 4), 0.3 + 0.5 * f64::from(i / 4))).collect();
    std::fs::write(folder.join("points.txt"), desks + "1 1 1.2 0 -1 0\n").unwrap();
    let project = Project::builder(folder)
        .weather(&testing::new_york().display().to_string())
        .scene(&[&format!("{SCENES}/asymmetric/room.rad")])
        .glass_window("south", &format!("{SCENES}/asymmetric/window.rad"), 0.1)
        .sensors("desks", "points.txt")
        .set("method", "sky_subdivision", 1)
        .set("quality", "preset", "draft")
        .set("metrics", "autonomy", 250)
        .save("project.toml")
        .unwrap();
    let plan = Plan::new(project, &mut Warnings::new()).unwrap();
    let out = folder.join("out");
    let summary = plan.write(&device, &out, &Silent, &mut Warnings::new()).unwrap();
    let lux = read_matrix(&out.join("illuminance/desks.mtx")).unwrap().matrix;
    assert_eq!((lux.rows(), lux.cols()), (13, 8760));

    // Plain counts: the file's hours are half past.
    let records = &plan.inputs.weather.records;
    let day: Vec<usize> = (0..8760).filter(|h| records[*h].hour > 8.0 && records[*h].hour < 18.0).collect();
    let share = |sensor: usize, hours: &[usize], least: f32| {
        hours.iter().filter(|h| lux.at(sensor, **h)[0] >= least).count() as f64 / hours.len() as f64
    };
    assert_eq!(day.len(), 3650);
    let table = out.join("illuminance/desks_annual.csv");
    let (da, own) = (column(&table, "lm83_autonomy_300_lx"), column(&table, "autonomy_250_lx"));
    for sensor in 0..13 {
        assert!(
            (da[sensor] - share(sensor, &day, 300.0)).abs() < 1e-5 && (own[sensor] - share(sensor, &day, 250.0)).abs() < 1e-5,
            "{sensor}"
        );
    }
    let metrics = &summary.sensors[0].metrics;
    let spatial = metric(metrics, "da300_spatial_share");
    assert!(own.iter().zip(&da).any(|(o, d)| o > d), "the room is neither dark nor bright: {own:?} {da:?}");
    let passing = (0..12).filter(|s| share(*s, &day, 300.0) >= 0.5).count() as f64 / 12.0;
    assert_eq!((spatial.value, spatial.lm83_conformant), (Some(passing), Some(false)), "{spatial:?}");
    assert!(
        spatial.notes[0].contains("blinds are not moved") && spatial.notes.iter().any(|n| n.contains("12 of the 13 sensors")),
        "{spatial:?}"
    );
    // EN 17037's hours, by the table that the run wrote of them.
    let daylight: Vec<usize> =
        column(&out.join("metrics/hours.csv"), "en17037").iter().enumerate().filter(|(_, v)| **v == 1.0).map(|(i, _)| i).collect();
    assert_eq!(daylight.len(), 4380);
    for lux in LEVELS_LX {
        let area = (0..12).filter(|s| share(*s, &daylight, lux as f32) >= 0.5).count() as f64 / 12.0;
        assert_eq!(metric(metrics, &format!("en17037_area_{lux}_lx")).value, Some(area));
    }
    let provision = metric(metrics, "en17037_provision");
    assert!(provision.class.is_some() && provision.probability_of_another_class.is_some(), "{provision:?}");
    // A sensor's daylight factor is the light of the overcast sky: brightest by the window.
    let factors = column(&table, "daylight_factor");
    let errors = column(&table, "daylight_factor_standard_error");
    assert!(
        (0..12).all(|s| factors[s] > 0.001 && factors[s] < 0.5 && errors[s] > 0.0 && errors[s] < 0.3 * factors[s]),
        "{factors:?} {errors:?}"
    );
    // Direct sun: the hours of the term, which is direct alone in a room of clear glass.
    let sun = read_matrix(&out.join("illuminance/terms/desks_sun.mtx")).unwrap().matrix;
    let hours = column(&table, "sun_hours_1000_lx");
    let most = |sensor: usize| day.iter().filter(|h| sun.at(sensor, **h)[0] > 1000.0).count() as f64;
    assert!((0..13).all(|s| hours[s] <= most(s)) && hours.iter().any(|h| *h > 0.0), "{hours:?}");
    let ase = metric(metrics, "ase_1000_250");
    assert_eq!(ase.value, Some(hours[..12].iter().filter(|h| **h > 250.0).count() as f64 / 12.0));
    assert_eq!(ase.lm83_conformant, Some(true), "{ase:?}");
    assert!(metric(metrics, "vertical_2669_lx").value.is_some());
    for name in ["leed_option_1", "leed_option_2"] {
        assert!(metric(&summary.metrics, name).probability_of_another_class.is_some(), "{name}");
    }
    // The old names are gone.
    let json = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(!json.contains("spatial_autonomy") && !json.contains("\"sda"), "{json}");
    assert_eq!(Summary::read(&out).unwrap().sensors[0].metrics.len(), metrics.len());

    // The same from the folder, and with hours of one's own.
    let again = judge_folder(&out, &MetricsSection { autonomy: 250.0, ..MetricsSection::default() }).unwrap();
    for m in metrics.iter().chain(&summary.metrics) {
        let same = metric(&again, &m.name);
        let close = match (m.value, same.value) {
            (Some(a), Some(b)) => (a - b).abs() <= 1e-5 * a.abs().max(1.0),
            (a, b) => a == b,
        };
        assert!(close && m.class == same.class && m.lm83_conformant == same.lm83_conformant, "{m:?} {same:?}");
    }
    let schedule = folder.join("nine.csv");
    std::fs::write(&schedule, (0..8760).map(|h| if h % 24 == 9 { "1\n" } else { "0\n" }).collect::<String>()).unwrap();
    let section = MetricsSection { occupancy: OccupancyChoice::File(schedule.clone()), ..MetricsSection::default() };
    let nine: Vec<usize> = (0..365).map(|d| d * 24 + 9).collect();
    let mean = (0..13).map(|s| share(s, &nine, 300.0)).sum::<f64>() / 13.0;
    let found = judge_folder(&out, &section).unwrap();
    assert!((metric(&found, "mean_autonomy_300_lx").value.unwrap() - mean).abs() < 1e-9);
    assert_eq!(metric(&found, "da300_spatial_share").value, spatial.value, "LM-83 has its own hours");

    let lucarne = |arguments: &[&str]| Command::new(env!("CARGO_BIN_EXE_lucarne")).current_dir(folder).args(arguments).output().unwrap();
    let told = lucarne(&["metrics", "out", "--occupancy", "nine.csv", "-o", "again.csv"]);
    let text = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(told.status.success() && text.contains("DA300 spatial share") && text.contains("blinds are not moved"), "{text}");
    assert!(std::fs::read_to_string(folder.join("again.csv")).unwrap().starts_with(Metric::COLUMNS));
    std::fs::write(&schedule, "1\n".repeat(24)).unwrap();
    let told = lucarne(&["metrics", "out", "--occupancy", "nine.csv"]);
    let text = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(!told.status.success() && text.contains("nine.csv") && text.contains("24 values"), "{text}");
    // Before anything is traced, too.
    let project = std::fs::read_to_string(folder.join("project.toml")).unwrap();
    std::fs::write(folder.join("project.toml"), project.replace("autonomy = 250", "occupancy = \"nine.csv\"")).unwrap();
    let told = lucarne(&["plan", "project.toml"]);
    let text = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(!told.status.success() && text.contains("24 values") && text.contains("metrics.occupancy"), "{text}");
}

const SENSORS: usize = 60;

/// Illuminance of a made-up room, lx `[sensor][hour]`, some of it exactly at the limits; and the direct sun of three groups
/// of windows.
fn made_up() -> (Matrix<f32>, Vec<Matrix<f32>>) {
    let hash = |a: usize, b: usize, c: usize| {
        let x = (a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b) ^ c.wrapping_mul(0xc2b2_ae35)) & 0xffff_ffff;
        ((x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d) & 0xffff_ffff) as f64 / 4_294_967_296.0
    };
    let light = |h: usize| (std::f64::consts::PI * ((h % 24) as f64 - 5.5) / 13.0).sin().max(0.0) * (1.0 + 0.5 * (h as f64 / 1394.0).sin());
    let mut lux = Matrix::zeros(SENSORS, 8760, 1);
    let mut suns = vec![Matrix::zeros(SENSORS, 8760, 1); 3];
    for s in 0..SENSORS {
        for h in (0..8760).filter(|h| (6..19).contains(&(h % 24))) {
            let value = 2600.0 * light(h) * (-(s as f64) / 16.0).exp() * (0.3 + hash(s, h, 0));
            lux.at_mut(s, h)[0] = match hash(s, h, 1) {
                p if p < 0.01 => 300.0,
                p if p < 0.02 => 100.0,
                p if p < 0.03 => 3000.0,
                _ => value as f32,
            };
            for (g, sun) in suns.iter_mut().enumerate() {
                let reaches = hash(0, h, 10 + g) * 14.0;
                if (s as f64 - 13.0 * g as f64).abs() < reaches && hash(0, h, 20 + g) < 0.4 {
                    sun.at_mut(s, h)[0] = (6000.0 * hash(0, h, 30 + g)) as f32;
                }
            }
        }
    }
    (lux, suns)
}

/// Closed blinds let this much through.
const CLOSED: f32 = 0.2;

const SCRIPT: &str = r"
import sys, numpy as np
from honeybee_radiance_postprocess import metrics as m
from honeybee_radiance_postprocess.annual import occupancy_schedule_8_to_6
from honeybee_radiance_postprocess.en17037 import en17037_compute
from honeybee_radiance_postprocess.ies.lm_schedule import shd_trans_schedule_descending
from collections import defaultdict
folder, sensors = sys.argv[1], int(sys.argv[2])
read = lambda name: np.fromfile(folder + '/' + name, dtype='<f4').reshape(sensors, 8760)
lux, suns = read('lux'), [read('sun%d' % g) for g in range(3)]
daylight = np.fromfile(folder + '/daylight', dtype=np.uint8).astype(bool)
occupied = np.array(occupancy_schedule_8_to_6()).astype(bool)
def show(name, values):
    print('@', name, *['%.9g' % v for v in np.atleast_1d(values)])
show('hours', np.where(occupied)[0])
o = lux[:, occupied]
show('da', m.da_array2d(o) / 100)
show('cda', m.cda_array2d(o) / 100)
show('udi', m.udi_array2d(o) / 100)
show('below', m.udi_lower_array2d(o) / 100)
show('above', m.udi_upper_array2d(o) / 100)
show('exposure', m.cumulative_values_array2d(lux) / 1000)
show('sda', m.sda_array2d(o, total_occ=o.shape[1]))
ase, hours = m.ase_array2d(sum(suns)[:, occupied])
show('sun_hours', hours)
found = en17037_compute(lux[:, daylight], {'full_id': 'a', 'count': sensors})['target_types']
for kind in ('Target Illuminance', 'Minimum Illuminance'):
    show(kind[:6], found[kind]['compliance_level'][0])
    for level in found[kind]['levels'].values():
        show('%s%d' % (kind[:6], level['threshold']), level['sda'] / 100)
class Results:
    sun_up_hours = [h + 0.5 for h in range(8760)]
    def _get_array(self, grid_info, light_path, state=0, res_type='direct'):
        return suns[int(light_path)]
paths = ['0', '1', '2']
states, failing = shd_trans_schedule_descending(Results(), {'name': 'a', 'count': sensors}, paths, {p: [1, 0.2] for p in paths}, occupied, defaultdict(list), {})
for p in paths:
    show('group' + p, np.array(states[p]) < 1)
show('listed', failing.get('a', []))
moved = sum(sun[:, occupied] * np.array(states[p]) for p, sun in zip(paths, suns))
show('failing', np.where(occupied)[0][(moved >= 1000).sum(axis=0) / sensors > 0.02])
";

#[test]
fn metrics_are_those_of_honeybee_radiance_postprocess() {
    let (lux, suns) = made_up();
    let year = Year::common();
    let diffuse: Vec<f64> = (0..8760).map(|h| f64::from(lux.at(0, h)[0])).collect();
    let daylight = Occupancy::en17037(&year, &diffuse).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, m: &Matrix<f32>| {
        let bytes: Vec<u8> = m.data().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(folder.path().join(name), bytes).unwrap();
    };
    write("lux", &lux);
    suns.iter().enumerate().for_each(|(g, sun)| write(&format!("sun{g}"), sun));
    std::fs::write(folder.path().join("daylight"), daylight.mask(8760).iter().map(|d| u8::from(*d)).collect::<Vec<_>>()).unwrap();
    let Some(output) = testing::honeybee_postprocess(SCRIPT, &[&folder.path().display().to_string(), &SENSORS.to_string()]) else { return };
    let output = String::from_utf8(output).unwrap();
    let oracle = |name: &str| -> Vec<f64> {
        let line = output.lines().find_map(|l| l.strip_prefix(&format!("@ {name}"))).unwrap_or_else(|| panic!("no {name}: {output}"));
        line.split_whitespace().map(|v| v.parse().unwrap()).collect()
    };

    let occupied = Occupancy::lm83(&year, Clock::Standard);
    let hours: Vec<f64> = occupied.steps.iter().map(|s| *s as f64).collect();
    assert_eq!(oracle("hours "), hours, "8:00 to 18:00");
    let rows: Vec<Vec<f64>> = (0..SENSORS).map(|s| lux.row(s).iter().map(|v| f64::from(*v)).collect()).collect();
    let of = |counted: Counted, time: &Occupancy| -> Vec<f64> { rows.iter().map(|r| counted.of(r, time)).collect() };
    let mut largest = 0.0f64;
    let mut same = |name: &str, found: &[f64], tolerance: f64| {
        let wanted = oracle(name);
        assert_eq!(wanted.len(), found.len(), "{name}");
        for (f, w) in found.iter().zip(&wanted) {
            let off = (f - w).abs() / w.abs().max(1.0);
            assert!(off <= tolerance, "{name}: {f} {w}");
            largest = largest.max(off);
        }
    };
    // Printed to nine digits.
    same("da ", &of(Counted::AtLeast(300.0), &occupied), 1e-8);
    same("udi ", &of(Counted::Between(100.0, 3000.0), &occupied), 1e-8);
    same("below ", &of(Counted::Below(100.0), &occupied), 1e-8);
    same("above ", &of(Counted::Above(3000.0), &occupied), 1e-8);
    // It adds in single precision: 8760 terms.
    same("cda ", &of(Counted::Continuous(300.0), &occupied), 1e-4);
    same("exposure ", &of(Counted::Exposure, &Occupancy::always(&year)), 1e-4);
    let autonomy = of(Counted::AtLeast(300.0), &occupied);
    let share = lm83::spatial_share(&autonomy).unwrap();
    assert!((0.1..0.9).contains(&share), "the made-up room is neither dark nor bright: {share}");
    same("sda ", &[share], 1e-8);
    // The four bands, and the two that are one there.
    let bands: Vec<f64> =
        of(Counted::From(100.0, 300.0), &occupied).iter().zip(of(Counted::Between(300.0, 3000.0), &occupied)).map(|(a, b)| a + b).collect();
    same("udi ", &bands, 1e-8);

    // ASE: the hours are the same; 250 of them are too many there, and not here (LM-83: more than 250).
    let sun: Vec<f64> = (0..SENSORS)
        .map(|s| occupied.steps.iter().filter(|h| suns.iter().map(|g| g.at(s, **h)[0]).sum::<f32>() > 1000.0).count() as f64)
        .collect();
    same("sun_hours ", &sun, 0.0);

    // EN 17037, its levels and areas.
    let time = LEVELS_LX.map(|lux| of(Counted::AtLeast(lux), &daylight));
    let found = Provision::by_illuminance([&time[0], &time[1], &time[2], &time[3]], Openings::Side).unwrap();
    same("Target ", &[f64::from(found.target as u8)], 0.0);
    same("Minimu ", &[f64::from(found.minimum as u8)], 0.0);
    for (kind, levels) in [("Target", [300.0, 500.0, 750.0]), ("Minimu", [100.0, 300.0, 500.0])] {
        for lux in levels {
            let reached = &time[LEVELS_LX.iter().position(|l| *l == lux).unwrap()];
            let area = reached.iter().filter(|t| **t >= 0.5).count() as f64 / SENSORS as f64;
            same(&format!("{kind}{lux} "), &[area], 1e-8);
        }
    }

    // Blinds: hours that none mends are the same; here no more groups close than there.
    let closed: Vec<Matrix<f32>> = suns.iter().map(|s| s.map(|v| CLOSED * v)).collect();
    let groups: Vec<Group<'_>> = suns.iter().zip(&closed).map(|(open, closed)| Group { open, closed }).collect();
    let operation = operate(&groups, None, &occupied);
    let failing: Vec<usize> = oracle("failing").iter().map(|h| *h as usize).collect();
    assert!(!failing.is_empty() && failing.len() < 1000, "{}", failing.len());
    assert_eq!(operation.remaining, failing);
    // Its own list has all hours in which it closed the last group, mended by that or not.
    let listed: Vec<usize> = oracle("listed").iter().map(|h| *h as usize).collect();
    assert!(failing.iter().all(|h| listed.contains(h)) && listed.len() > failing.len(), "{} {}", listed.len(), failing.len());
    let there_closed = [0, 1, 2].map(|g| oracle(&format!("group{g} ")));
    let (mut fewer, mut equal) = (0, 0);
    for (i, step) in occupied.steps.iter().enumerate() {
        let here = operation.closed.iter().filter(|g| g[*step]).count();
        let there = there_closed.iter().filter(|g| g[i] == 1.0).count();
        assert!(here <= there, "hour {step}: {here} groups closed, {there} there");
        fewer += usize::from(here < there);
        equal += usize::from(here == there);
    }
    assert!(equal > 10 * fewer, "{equal} {fewer}");
    let found = format!(
        "shares within {}; blinds: {} hours that none mends, {equal} of 3650 hours with as many groups closed, {fewer} with fewer here",
        testing::short(largest),
        failing.len()
    );
    testing::measured("metrics-honeybee", &found, "1e-8 (sums in single precision there: 1e-4); the same hours, no more groups");
}
