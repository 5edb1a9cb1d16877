use super::*;
use crate::error::Warnings;
use crate::metrics::en17037::Level;
use crate::simulate::Project;

/// A box 4 m wide, 6 m deep and 3 m high, open to the south, with a window from 1 m to 2 m and 2 m wide in its south wall; what stands
/// outside is the test's.
fn room(outside: &str, window: &str) -> Inputs {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let face = |name: &str, corners: &[[f64; 3]]| {
        let numbers: String = corners.iter().flatten().map(|v| format!(" {v}")).collect();
        format!("grey polygon {name} 0 0 {}{numbers}\n", 3 * corners.len())
    };
    let mut scene = String::from("void plastic grey 0 0 5 .5 .5 .5 0 0\n");
    for (name, corners) in [
        ("floor", [[0., 0., 0.], [4., 0., 0.], [4., 6., 0.], [0., 6., 0.]]),
        ("ceiling", [[0., 0., 3.], [0., 6., 3.], [4., 6., 3.], [4., 0., 3.]]),
        ("west", [[0., 0., 0.], [0., 6., 0.], [0., 6., 3.], [0., 0., 3.]]),
        ("east", [[4., 0., 0.], [4., 0., 3.], [4., 6., 3.], [4., 6., 0.]]),
        ("north", [[0., 6., 0.], [4., 6., 0.], [4., 6., 3.], [0., 6., 3.]]),
        ("below", [[0., 0., 0.], [4., 0., 0.], [4., 0., 1.], [0., 0., 1.]]),
        ("above", [[0., 0., 2.], [4., 0., 2.], [4., 0., 3.], [0., 0., 3.]]),
        ("left", [[0., 0., 1.], [1., 0., 1.], [1., 0., 2.], [0., 0., 2.]]),
        ("right", [[3., 0., 1.], [4., 0., 1.], [4., 0., 2.], [3., 0., 2.]]),
    ] {
        scene += &face(name, &corners);
    }
    write("room.rad", &(scene + outside));
    write("window.rad", "#@rfluxmtx h=kq u=+Z\nvoid glow pane 0 0 4 1 1 1 0\npane polygon w 0 0 12 1 0 1 1 0 2 3 0 2 3 0 1\n");
    write("points.txt", "2 3 0.8 0 0 1\n");
    write(
        "w.wea",
        concat!("place x\nlatitude 50\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n", "3 21 12 500 100\n"),
    );
    let project = Project::builder(folder.path()).weather("w.wea").scene(&["room.rad"]).sensors("room", "points.txt");
    let project = match window {
        "glass" => project.glass_window("south", "window.rad", 0.65),
        bsdf => project.window("south", "window.rad", bsdf),
    };
    Inputs::read(&project.build().unwrap(), &mut Warnings::new()).unwrap()
}

/// A wall, 40 m wide and 30 m high, that faces the window from so far.
fn opposite(distance: f64) -> String {
    let y = -distance;
    format!("grey polygon wall 0 0 12 -18 {y} -5 22 {y} -5 22 {y} 30 -18 {y} 30\n")
}

#[test]
fn the_sight_angle_is_that_of_the_opening() {
    let inputs = room("", "glass");
    let outlook = Outlook::new(&inputs).unwrap();
    assert!((outlook.floor_below(DVec3::new(2.0, 3.0, 0.8)).unwrap()).abs() < 1e-6);
    for depth in [1.0, 3.0, 5.5] {
        let seen = outlook.seen_from(DVec3::new(2.0, depth, 1.2));
        let expected = 2.0 * f64::atan(1.0 / depth).to_degrees();
        assert!((seen.view.sight_deg - expected).abs() <= 1.0, "{depth}: {} {expected}", seen.view.sight_deg);
        assert_eq!(seen.view.distance_m, f64::INFINITY);
        assert_eq!(seen.windows, [true]);
    }
    // An eye 1 m behind a window from 0.2 m below it to 0.8 m above sees all; 5 m behind, no ground nearer than 5° below.
    let near = outlook.seen_from(DVec3::new(2.0, 1.0, 1.2)).view;
    assert_eq!(near.layers, Layers { sky: true, landscape: true, ground: true });
    let far = outlook.seen_from(DVec3::new(2.0, 5.0, 1.2)).view;
    assert_eq!(far.layers, Layers { sky: true, landscape: true, ground: false });
    assert_eq!((near.level(), far.level()), (Level::High, Level::Minimum), "22.6° of sight");
}

#[test]
fn what_stands_opposite_is_as_far_as_it_is() {
    let eye = DVec3::new(2.0, 1.0, 1.2);
    for (distance, level) in [(25.0, Level::Medium), (10.0, Level::Minimum), (4.0, Level::None)] {
        let inputs = room(&opposite(distance), "glass");
        let view = Outlook::new(&inputs).unwrap().seen_from(eye).view;
        assert!((view.distance_m - distance).abs() < 1e-3, "{view:?}");
        assert!(view.layers.landscape == (distance > 6.0), "{view:?}");
        assert_eq!(view.level(), level, "{view:?}");
    }
    // Ground before the window is a layer, and no obstacle.
    let inputs = room("grey polygon ground 0 0 12 -50 -80 0 50 -80 0 50 -.01 0 -50 -.01 0\n", "glass");
    let view = Outlook::new(&inputs).unwrap().seen_from(eye).view;
    assert!(view.distance_m == f64::INFINITY && view.layers.ground, "{view:?}");
}

#[test]
fn blurred_windows_are_no_view() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/bsdf/");
    for (file, clear) in [("clear.xml", true), ("cloudy.xml", false)] {
        let inputs = room("", &format!("{scene}{file}"));
        let seen = Outlook::new(&inputs).unwrap().seen_from(DVec3::new(2.0, 1.0, 1.2));
        assert_eq!((seen.view.sight_deg > 80.0, seen.view.level() > Level::None), (clear, clear), "{file}: {seen:?}", seen = seen.view);
        assert_eq!(seen.windows, [true], "sun comes through both");
    }
}

#[test]
fn the_sun_stands_in_the_window_as_long_as_nothing_is_before_it() {
    let hours = |outside: &str, altitude: f64| {
        let inputs = room(outside, "glass");
        let outlook = Outlook::new(&inputs).unwrap();
        let minutes = outlook.minutes_of_sun(&inputs.weather, 80, altitude, 0.0, &[0]);
        minutes[0].as_ref().unwrap().iter().filter(|m| **m).count() as f64 / 60.0
    };
    // At the equinox the sun stands south of the east-west line all day: from 10° to 10° at 50° north.
    let above = |altitude: f64| 2.0 / 15.0 * (altitude.to_radians().sin() / 50f64.to_radians().cos()).acos().to_degrees();
    assert!((hours("", 10.0) - above(10.0)).abs() < 0.1, "{} {}", hours("", 10.0), above(10.0));
    // A long wall 10 m before it, as high above the reference point (1.3 m: sill and 0.3 m) as hides the sun below 30° of profile.
    let top = 1.3 + 10.0 * 30f64.to_radians().tan();
    let wall = format!("grey polygon wall 0 0 12 -900 -10 -5 900 -10 -5 900 -10 {top} -900 -10 {top}\n");
    // At the equinox all suns have the profile angle of noon, 40°, as seen from a south window.
    assert!((hours(&wall, 10.0) - hours("", 10.0)).abs() < 0.1);
    let higher =
        format!("grey polygon wall 0 0 12 -900 -10 -5 900 -10 -5 900 -10 {h} -900 -10 {h}\n", h = 1.3 + 10.0 * 42f64.to_radians().tan());
    assert!(hours(&higher, 10.0) < 0.1);
    // A wall to the west hides the afternoon.
    let west = "grey polygon side 0 0 12 1.9 -.01 0 1.9 -30 0 1.9 -30 40 1.9 -.01 40\n";
    assert!((hours(west, 10.0) / hours("", 10.0) - 0.5).abs() < 0.02);
}

#[test]
fn the_reference_point_is_where_the_standard_has_it() {
    let inputs = room("", "glass");
    let outlook = Outlook::new(&inputs).unwrap();
    let at = |floor: f64| outlook.reference_point(0, floor);
    assert!((at(0.0).unwrap() - DVec3::new(2.0, 0.0, 1.3)).length() < 1e-6, "0.3 m above the sill");
    assert!((at(0.5).unwrap() - DVec3::new(2.0, 0.0, 1.7)).length() < 1e-6, "1.2 m above the floor");
    assert_eq!(at(1.0), None, "the window ends below");
}
