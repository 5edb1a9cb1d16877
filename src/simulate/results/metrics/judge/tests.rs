use super::super::samples::Row;
use super::*;
use crate::metrics::{Noise, Year};
use crate::simulate::inputs::counting::Counting;
use crate::simulate::project::metrics::MetricsSection;
use crate::statistics::student_95;

/// 20 sensors `spacing` apart, of which each has its illuminance by day (7:00 to 19:00), known to a standard error, and a
/// daylight factor.
struct Room {
    counting: Counting,
    noise: Noise,
    facts: GroupFacts,
    sensors: Vec<SensorSample>,
}

impl Room {
    fn new(spacing: f64, lux: [f64; 20], error: f64, factor: f64) -> Self {
        let year = Year::common();
        let is_day = |h: &usize| (7..19).contains(&(h % 24));
        let diffuse = (0..8760).map(|h| if is_day(&h) { 12_000.0 } else { 0.0 }).collect();
        let counting = Counting::of_steps(&MetricsSection::default(), year, diffuse, None, true).unwrap();
        let noise = Noise::new(0, true, student_95(1000));
        let errors: Vec<f32> = (0..8760).map(|h| if is_day(&h) { error as f32 } else { 0.0 }).collect();
        let sky_error = [error as f32];
        let sensor = |lux: f64| {
            let row = (0..8760).map(|h| if is_day(&h) { lux } else { 0.0 }).collect();
            let sky = Row { lux: vec![factor * crate::sky::cie::OUTDOORS], directions: vec![&sky_error] };
            SensorSample::new(&counting, &noise, &Row { lux: row, directions: vec![&errors] }, &sky)
        };
        let sensors: Vec<SensorSample> = lux.into_iter().map(sensor).collect();
        let positions = (0..20).map(|i| DVec3::new(f64::from(i % 5) * spacing, f64::from(i / 5) * spacing, 0.8)).collect();
        let facts = GroupFacts {
            name: "room".into(),
            positions,
            faces_up: vec![true; 20],
            not_bare: None,
            shading: Shading::Undeclared,
            hours_in_sun: 0.0,
            outlook: Vec::new(),
        };
        Self { counting, noise, facts, sensors }
    }

    fn samples(&self) -> Samples<'_> {
        Samples { counting: &self.counting, noise: &self.noise, replicates: 0 }
    }

    fn metric(&self, name: &str) -> Metric {
        let all = judge_all(&self.samples(), &[(&self.facts, &self.sensors)]);
        let metrics = judge(&self.samples(), &self.facts, &self.sensors);
        metrics.into_iter().chain(all).find(|m| m.name == name).unwrap_or_else(|| panic!("no {name}"))
    }
}

/// So many sensors of 20 have the first illuminance, the others the second.
fn lux(count: usize, first: f64, second: f64) -> [f64; 20] {
    std::array::from_fn(|i| if i < count { first } else { second })
}

#[test]
fn a_room_is_judged_by_all_that_is_known_of_it() {
    let room = Room::new(0.5, lux(12, 600.0, 150.0), 1.0, 0.03);
    let share = room.metric("da300_spatial_share");
    assert_eq!((share.value, share.standard_error, share.lm83_conformant), (Some(0.6), Some(0.0), Some(false)));
    assert!(share.notes[0].contains("blinds are not moved") && share.notes.len() == 2, "{share:?}");
    // 12 of 20 have 500 lx, all have 100 lx in all of the 4380 hours.
    let provision = room.metric("en17037_provision");
    assert_eq!((provision.class.as_deref(), provision.undecided), (Some("minimum"), false));
    assert!(provision.notes.iter().any(|n| n == "target medium, minimum minimum"), "{provision:?}");
    // 3 % of 12,000 lx are 360 lx everywhere.
    assert_eq!(room.metric("en17037_provision_by_factor").class.as_deref(), Some("minimum"));
    let points = room.metric("leed_option_1");
    assert_eq!((points.value, points.undecided, points.of.as_str()), (Some(3.0), false, "all"), "60 % and every group above 55 %");
    let ase = room.metric("ase_1000_250");
    assert!(ase.value.is_none() && ase.notes[0].contains("not judged"), "{ase:?}");
    // LM-83 has 3650 h, all of them by day; the exposure has the night, too.
    assert!((room.metric("mean_exposure_klxh").value.unwrap() - (0.6 * 600.0 + 0.4 * 150.0) * 4380.0 / 1000.0).abs() < 1e-6);
}

#[test]
fn what_noise_leaves_open_is_told_with_its_probability() {
    // The eleventh of 20 decides on the target of half of the plane, and has 300 ± 10 lx.
    let mut values = lux(9, 400.0, 150.0);
    values[9] = 301.0;
    let room = Room::new(0.5, values, 10.0, 0.0251);
    let provision = room.metric("en17037_provision");
    assert_eq!(provision.class.as_deref(), Some("minimum"));
    let probability = provision.probability_of_another_class.unwrap();
    assert!(provision.undecided && (probability - 0.46).abs() < 0.12, "a tenth of a standard error above: {probability}");
    assert!(provision.result().contains("undecided within noise"), "{}", provision.result());
    // 2.51 ± 0.1 % of 12,000 lx are 301 ± 12 lx.
    assert!(room.metric("en17037_provision_by_factor").undecided);
    let share = room.metric("da300_spatial_share");
    assert!((share.standard_error.unwrap() - 0.05 / 2f64.sqrt()).abs() < 1e-9, "a sensor of 20 to one of both sides: {share:?}");
    // 50 % or 45 %: both one point.
    assert!(!room.metric("leed_option_1").undecided);
}

#[test]
fn grids_that_no_standard_means_are_told() {
    let noted = |room: &Room, name: &str, words: &str| room.metric(name).notes.iter().any(|n| n.contains(words));
    let coarse = Room::new(0.75, lux(12, 600.0, 150.0), 1.0, 0.03);
    assert!(noted(&coarse, "da300_spatial_share", "0.75 m apart"));
    let outdoors = Room::new(0.5, lux(12, 9000.0, 150.0), 1.0, 0.95);
    for name in ["da300_spatial_share", "en17037_provision", "en17037_provision_by_factor"] {
        assert!(noted(&outdoors, name, "20 of the sensors have a daylight factor above 60 %"), "{name}");
    }
    let dark = Room::new(0.5, lux(12, 600.0, 0.0), 0.0, 0.03);
    assert!(noted(&dark, "da300_spatial_share", "8 of the sensors get no light"));
    // Eyes have no plan, but thresholds of their own.
    let mut eyes = Room::new(0.5, lux(10, 2700.0, 2600.0), 1.0, 0.03);
    assert_eq!(eyes.counting.column("above_2669_lx").map(|_| ()), Some(()));
    eyes.facts.faces_up.fill(false);
    assert!(noted(&eyes, "da300_spatial_share", "no sensor faces up") && noted(&eyes, "en17037_provision", "no sensor faces up"));
    assert_eq!((eyes.metric("vertical_2669_lx").value, eyes.metric("vertical_3473_lx").value), (Some(0.5), Some(0.0)));
    assert!(judge_all(&eyes.samples(), &[(&eyes.facts, &eyes.sensors)]).is_empty());
}
