//! Skies that are no weather file's: matrices made elsewhere, and named moments.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, read_matrix, write_matrix};
use lucarne::progress::Silent;
use lucarne::simulate::project::builder::ProjectBuilder;
use lucarne::simulate::{Plan, Project};
use lucarne::sky::{SkyOptions, sky_columns, sky_matrix};
use lucarne::weather::Weather;
use std::path::Path;

const ROOM: &str = concat!("void plastic wall 0 0 5 .5 .5 .5 0 0\n", include_str!("data/plain_room.rad"));
const WINDOW: &str = "void glow window 0 0 4 1 1 1 0\nwindow polygon opening 0 0 12  0.5 0 1  0.5 0 2.4  2.5 0 2.4  2.5 0 1\n";

/// A room behind glass, without weather.
fn room(folder: &Path) -> ProjectBuilder {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("room.rad", ROOM);
    write("window.rad", WINDOW);
    write("points.txt", "0.8 0.7 0.8 0 0 1\n2.2 1.5 0.8 0 0 1\n1.5 2.5 0.8 0 0 1\n1.2 3.5 0.8 0 0 1\n");
    let builder = Project::builder(folder).scene(&["room.rad"]).sensors("room", "points.txt");
    builder.glass_window("south", "window.rad", 0.65).set("quality", "preset", "draft")
}

/// The same with some hours of sun, in matrices too.
fn sunny(folder: &Path) -> ProjectBuilder {
    let header = "place Test\nlatitude 45\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n";
    let hours: String = [1, 3, 6].iter().flat_map(|month| (9..16).map(move |hour| format!("{month} 21 {hour}.5 600 120\n"))).collect();
    std::fs::write(folder.join("w.wea"), format!("{header}{hours}")).unwrap();
    let weather = Weather::read(&folder.join("w.wea"), &mut Warnings::new()).unwrap();
    let write = |name: &str, options: SkyOptions| {
        let matrix: Matrix<f32> = sky_matrix(&weather, &options, &Silent).unwrap();
        write_matrix(Some(&folder.join(name)), &matrix, Format::Float, &[]).unwrap();
    };
    let sky = SkyOptions { subdivision: 2, ..SkyOptions::default() };
    write("S.mtx", sky.clone());
    write("Sds.mtx", SkyOptions { sky: false, ..sky.clone() });
    write("Ssun.mtx", SkyOptions { subdivision: 6, sky: false, sun_disc: Some(0.533), ..sky });
    room(folder)
}

fn lux(device: &lucarne::gpu::Device, builder: ProjectBuilder, out: &Path) -> (Matrix<f32>, lucarne::simulate::Summary) {
    let plan = Plan::new(builder.build().unwrap(), &mut Warnings::new()).unwrap();
    let summary = plan.write(device, out, &Silent, &mut Warnings::new()).unwrap();
    (read_matrix(&out.join("illuminance/room.mtx")).unwrap().matrix, summary)
}

#[test]
fn a_sky_made_elsewhere_gives_what_the_weather_gives_that_it_was_made_of() {
    let Some(device) = device("skies made elsewhere") else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let given = |b: ProjectBuilder| b.set("weather", "sky_matrix", "S.mtx").set("weather", "file", "w.wea");
    let whole = |b: ProjectBuilder| given(b).set("weather", "sky_matrix_direct", "Sds.mtx").set("weather", "sun_matrix", "Ssun.mtx");
    let method = |b: ProjectBuilder| b.set("method", "sky_subdivision", 2).set("method", "suns", 6);

    let (by_weather, _) = lux(&device, method(sunny(folder.path())).weather("w.wea"), &out("weather"));
    let (by_sky, summary) = lux(&device, whole(sunny(folder.path())), &out("sky"));
    assert_eq!((summary.sky_subdivision, summary.phases, summary.time_steps), (2, 5, 21));
    assert!(summary.weather.contains("sky made elsewhere") && summary.weather.contains("S.mtx"), "{}", summary.weather);
    // A file holds the suns' radiance in single precision.
    let same = |a: &f32, b: &f32| *a > 0.0 && (a / b - 1.0).abs() < 1e-6;
    assert!(by_sky.data().iter().zip(by_weather.data()).all(|(a, b)| same(a, b)));
    // What the sky gives outdoors is what the weather gave: the same suns, and 120 W/m² of sky at 125 to 150 lm/W.
    let plan = Plan::new(whole(sunny(folder.path())).build().unwrap(), &mut Warnings::new()).unwrap();
    let weather = Weather::read(&folder.path().join("w.wea"), &mut Warnings::new()).unwrap();
    for (record, column) in plan.inputs.weather.records.iter().zip(sky_columns(&weather, &SkyOptions::default()).unwrap()) {
        assert!((record.direct / (179.0 * column.direct_normal) - 1.0).abs() < 1e-5, "{record:?} {column:?}");
        assert!((125.0..150.0).contains(&(record.diffuse / 120.0)), "{record:?}");
    }
    // Some of the hours: their columns.
    let some = whole(sunny(folder.path())).set("weather", "period", ["03-21"]);
    let plan = Plan::new(some.build().unwrap(), &mut Warnings::new()).unwrap();
    assert!(plan.outline().unwrap().to_string().contains("7 time steps"));

    // With phases = 3 the sun stays in the patches, and S alone will do.
    let three = |b: ProjectBuilder| b.set("method", "phases", 3);
    let (by_weather, _) = lux(&device, three(sunny(folder.path()).weather("w.wea").set("method", "sky_subdivision", 2)), &out("weather3"));
    let (by_sky, _) = lux(&device, three(given(sunny(folder.path()))), &out("sky3"));
    assert_eq!(by_sky, by_weather);

    // The same files with another sky in them are another sky.
    let builder = three(given(sunny(folder.path())));
    let mut darker = read_matrix(&out("S.mtx")).unwrap().matrix;
    darker.data_mut().iter_mut().for_each(|v| *v *= 0.5);
    write_matrix(Some(&out("S.mtx")), &darker, Format::Float, &[]).unwrap();
    let (halved, _) = lux(&device, builder, &out("sky3"));
    assert!(halved.data().iter().zip(by_sky.data()).all(|(half, whole)| (half / whole - 0.5).abs() < 1e-5));
}

#[test]
fn a_sky_made_elsewhere_must_have_what_the_method_asks() {
    let folder = tempfile::tempdir().unwrap();
    let said = |keys: &[(&str, &str, toml::Value)]| {
        let builder = keys.iter().fold(sunny(folder.path()), |b, (section, key, value)| b.set(section, key, value));
        let mut warnings = Warnings::new();
        let said = builder.build().and_then(|p| Plan::new(p, &mut warnings)).map(|_| String::new()).unwrap_or_else(|e| e.to_string());
        format!("{said}{}", warnings.iter().map(ToString::to_string).collect::<String>())
    };
    let s = || ("weather", "sky_matrix", "S.mtx".into());
    let file = || ("weather", "file", "w.wea".into());
    let ds = || ("weather", "sky_matrix_direct", "Sds.mtx".into());
    let suns = || ("weather", "sun_matrix", "Ssun.mtx".into());
    let words = |keys: &[(&str, &str, toml::Value)], words: &str| {
        let said = said(keys);
        assert!(said.contains(words), "{words}: {said}");
    };
    words(&[s(), file()], "weather.sky_matrix_direct: the method (direct");
    words(&[s(), file(), ds()], "weather.sun_matrix: the method (direct");
    words(&[s(), ds(), suns()], "the sky has 21 columns, and nothing tells their times");
    words(&[s(), ds(), suns(), ("weather", "date", vec!["03-21T12:00"].into())], "the sky has 21 columns, but there are 1 time steps");
    words(&[s(), file(), ds(), suns(), ("method", "sky_subdivision", 4.into())], "the sky that is given is MF:2, not MF:4");
    words(&[s(), file(), ds(), suns(), ("method", "suns", "hourly".into())], "the suns that are given are those of MF:6");
    words(&[s(), file(), ("weather", "sky_matrix_direct", "S.mtx".into()), suns()], "times the light of the sky's direct part");
    words(
        &[("weather", "sky_matrix", "Sds.mtx".into()), file(), ("weather", "sky_matrix_direct", "S.mtx".into()), suns()],
        "is more than the sky in row",
    );
    words(&[s(), file(), ds(), ("weather", "sun_matrix", "Sds.mtx".into())], "has more than one sun");
    words(&[("weather", "sky_matrix", "Ssun.mtx".into()), file(), ds(), suns()], "the sky is MF:6, its direct part MF:2");
    std::fs::write(folder.path().join("bad.mtx"), "NROWS=3\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n1 1 1 1 1 1 1 1 1\n").unwrap();
    words(&[("weather", "sky_matrix", "bad.mtx".into()), file(), ds(), suns()], "bad.mtx: the matrix has 3 rows, which is no sky");
    // A sky that holds no sun needs no suns.
    let none = said(&[s(), file(), ("weather", "sky_matrix_direct", "none".into())]);
    assert!(!none.contains("not given"), "{none}");
}

#[test]
fn named_moments_are_computed_in_one_run_and_called_by_their_names() {
    let Some(device) = device("named moments") else { return };
    let folder = tempfile::tempdir().unwrap();
    let moment = |b: ProjectBuilder, name: &str, sky: &str, date: &str| {
        b.begin("moment").set("moment", "name", name).set("moment", "sky", sky).set("moment", "date", date)
    };
    let site = |b: ProjectBuilder| b.set("weather", "site", [45.0, 0.0, 0.0]);
    let mut builder = site(room(folder.path()));
    builder = moment(builder, "noon", "cie clear", "03-21T12:00");
    builder = moment(builder, "noon grey", "cie overcast", "03-21T12:00");
    builder = moment(builder, "evening", "cie intermediate", "06-21T18:00");
    let (all, summary) = lux(&device, builder, &folder.path().join("all"));
    assert_eq!((summary.time_steps, all.cols()), (3, 3));
    assert!(summary.weather.contains("noon grey (cie overcast, 21 March, 12:00)"), "{}", summary.weather);
    assert_eq!(summary.sensors[0].mean_daylight_factor, None, "not all are overcast");
    let table = std::fs::read_to_string(folder.path().join("all/illuminance/room_moments.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.iter().map(|r| r[0]).collect::<Vec<_>>(), ["noon", "noon grey", "evening"]);
    for (step, row) in rows.iter().enumerate() {
        let values: Vec<f64> = (0..all.rows()).map(|i| f64::from(all.at(i, step)[0])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((row[5].parse::<f64>().unwrap() - mean).abs() < 0.051, "{row:?} {mean}");
        assert!((row[6].parse::<f64>().unwrap() - values.iter().copied().fold(f64::INFINITY, f64::min)).abs() < 0.051);
        assert_eq!(row[8].is_empty(), step != 1);
    }
    // The overcast one alone: the same light, and the same daylight factor.
    let alone = site(room(folder.path())).set("weather", "sky", "cie overcast").set("weather", "date", "03-21T12:00");
    let (grey, summary) = lux(&device, alone, &folder.path().join("alone"));
    for sensor in 0..grey.rows() {
        let ratio = grey.at(sensor, 0)[0] / all.at(sensor, 1)[0];
        assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
    }
    let factor = summary.sensors[0].mean_daylight_factor.unwrap();
    assert!((rows[1][8].parse::<f64>().unwrap() - 100.0 * factor).abs() < 6e-4, "{} {factor}", rows[1][8]);
}
