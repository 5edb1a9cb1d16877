//! The library as a program uses it: project, plan, year, results.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::{Progress, Silent};
use lucarne::report::Report;
use lucarne::simulate::project::builder::ProjectBuilder;
use lucarne::simulate::{Plan, Project, Results, Year};
use lucarne::{Error, ErrorKind, Warnings};
use std::path::Path;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");

/// The room with blinds on a winter's day, small.
fn blinds(folder: &Path) -> ProjectBuilder {
    let weather: String = (0..24).map(|h| format!("1 15 {h}.5 {}\n", if h > 8 && h < 17 { "700 120" } else { "0 0" })).collect();
    let header = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
    std::fs::write(folder.join("day.wea"), format!("{header}{weather}")).unwrap();
    let scene = |file: &str| format!("{SCENES}/blinds/{file}");
    Project::builder(folder)
        .weather("day.wea")
        .scene(&[&scene("room.rad")])
        .window("south", &scene("window.rad"), &scene("blind.xml"))
        .set("window", "shade", scene("blinds.rad"))
        .sensors("desks", &scene("points.txt"))
        .view("seat", &scene("views/seat.vf"), [32, 32])
        .set("images", "hours", [347, 349])
        .set("glare", "method", "image")
        .set("quality", "preset", "draft")
        .set("quality", "seed", 5)
}

#[test]
fn a_year_holds_what_its_folder_holds() {
    let Some(device) = device("a year as arrays") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut warnings = Warnings::new();
    let plan = Plan::new(blinds(folder.path()).save("project.toml").unwrap(), &mut warnings).unwrap();
    let out = folder.path().join("out");
    let year = plan.run(&device, &out, &Silent, &mut warnings).unwrap();

    let desks = &year.sensors[0];
    assert_eq!((desks.name.as_str(), desks.count(), year.times.len()), ("desks", plan.inputs.sensors[0].sensors.len(), 24));
    assert_eq!(*desks.illuminance, read_matrix(&out.join("illuminance/desks.mtx")).unwrap().matrix);
    let error = desks.standard_error.as_ref().unwrap();
    // The sun stands highest at 12: light, known to a few per cent.
    let (lux, error) = (desks.illuminance.at(0, 12)[0], error.at(0, 12)[0]);
    assert!(lux > 10.0 && error > 0.0 && error < 0.3 * lux, "{lux} ± {error}");
    let mean = desks.illuminance.row(0).iter().map(|v| f64::from(*v)).sum::<f64>() / 24.0;
    assert!((desks.metrics.get(0, "mean_lx").unwrap().value / mean - 1.0).abs() < 1e-3, "{mean} {:?}", desks.metrics.rows[0]);

    // DGP of the table against the matrix, which has it unrounded; nothing at night.
    let dgp = read_matrix(&out.join("glare/image.dgp")).unwrap().matrix;
    let glare = &year.glare[0];
    assert_eq!((glare.view.as_str(), glare.state.as_str()), ("seat", ""));
    assert!(glare.dgp[0].is_nan() && glare.class[0].is_none());
    assert!((glare.dgp[12] - f64::from(dgp.at(0, 12)[0])).abs() < 1e-6 && glare.standard_error[12] > 0.0);

    // Pictures are those that the run wrote; others are made of the same matrices.
    for step in [11, 13] {
        let stored = lucarne::image::hdr::read(&out.join(format!("images/seat/img_{:04}.hdr", 14 * 24 + step))).unwrap();
        let found = year.picture("seat", step).unwrap();
        assert_eq!((found.width, found.height, found.view), (32, 32, stored.view));
        let most = stored.pixels.iter().flatten().copied().fold(0.0, f32::max);
        for (a, b) in found.pixels.iter().zip(&stored.pixels) {
            // RGBE has 8 bits for the largest channel.
            let largest = b.iter().copied().fold(0.0, f32::max);
            assert!((0..3).all(|c| (a[c] - b[c]).abs() <= 0.01 * largest + 1e-6 * most), "{a:?} {b:?}");
        }
    }
    let dark = year.picture("seat", 0).unwrap();
    assert!(dark.pixels.iter().flatten().all(|v| *v == 0.0));
    let error = year.picture("seta", 0).unwrap_err().to_string();
    assert!(error.contains("no view 'seta'") && error.contains("seat"), "{error}");
    assert!(year.picture("seat", 24).unwrap_err().to_string().contains("no step 24"));

    // Read back, it is the same with its room.
    let results = Results::open(&out).unwrap();
    assert_eq!((&results.year.summary, &results.year.sensors), (&year.summary, &year.sensors));
    assert_eq!(results.year.glare.len(), 1);
    assert!(results.year.notes.is_empty(), "{:?}", results.year.notes);
    assert!(results.surroundings.unwrap().scene.triangles.len() > plan.inputs.scene.triangles.len(), "the windows are part of the outline");

    // Every file is in the copy, in which a run has nothing left to do.
    let copy = folder.path().join("copy");
    year.write(&copy).unwrap();
    let again = plan.run(&device, &copy, &Silent, &mut warnings).unwrap();
    assert_eq!((again.summary.rays, &again.sensors[0].illuminance), (0, &desks.illuminance));

    a_report_shows_what_the_folder_holds(&out, &folder.path().join("report"));
}

/// The page of a run has its numbers and figures, needs nothing from elsewhere, and is well formed.
fn a_report_shows_what_the_folder_holds(out: &Path, folder: &Path) {
    let results = || Results::open(out).unwrap();
    let report = Report::new(&[results()]).unwrap();
    let page = report.html().unwrap();
    let mean = results().year.summary.sensors[0].mean_illuminance_lx.unwrap();
    assert!(
        page.contains(&format!("{:.0}", mean.floor())) || page.contains(&format!("{:.0}", mean.ceil())),
        "{mean} lx is not on the page"
    );
    // Plan, section, four maps, the worst hour; a single day has no carpet of its own below two days.
    assert_eq!(page.matches("<figure").count(), 7, "{}", page.matches("<figcaption").count());
    for part in page.split("<svg").skip(1) {
        let svg = format!("<svg{}</svg>", part.split("</svg>").next().unwrap());
        let mut reader = quick_xml::Reader::from_str(&svg);
        while !matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {}
    }
    let addresses = page.matches("http").count() - page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count();
    assert!(addresses == 0 && !page.contains("<script") && !page.contains("<link"), "the page asks for something outside");
    let count = report.write_parts(folder).unwrap();
    let files = std::fs::read_dir(folder).unwrap().count();
    assert!(
        count == files && folder.join("plan.svg").is_file() && folder.join("groups.csv").is_file(),
        "{count} files, {files} in the folder"
    );
    // Beside itself a run differs by nothing.
    let twice = Report::new(&[results(), results()]).unwrap().html().unwrap();
    assert!(twice.contains("Side by side") && twice.matches("<figure").count() == 14);
}

#[test]
fn the_facade_as_computed_has_the_illuminance_of_the_run() {
    use lucarne::kernels::product::Native;
    use lucarne::simulate::year::facade::{Facade, FacadeState};
    let Some(device) = device("states of the façade") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut warnings = Warnings::new();
    let plan = Plan::new(blinds(folder.path()).build().unwrap(), &mut warnings).unwrap();
    let year = plan.compute(&device, &Silent, &mut warnings).unwrap();
    let facade = Facade::read(&year).unwrap();
    assert!(facade.has_suns());
    let found = facade.illuminance(&year, "desks", &FacadeState::default(), &Native).unwrap();
    let most = year.sensors[0].illuminance.data().iter().copied().fold(0.0, f32::max);
    for (found, wanted) in found.data().iter().zip(year.sensors[0].illuminance.data()) {
        // T is kept in 32 bits, and sums are taken in another order.
        assert!((found - wanted).abs() <= 1e-4 * wanted + 1e-6 * most, "{found} {wanted}");
    }
    // A window that is half on its way to darkness gives half the light, its sun's included.
    let dark = lucarne::matrix::Matrix::<f64>::zeros(facade.bins(), facade.bins(), 3);
    let half = FacadeState { second: std::sync::Arc::new(vec![Some(dark)]), fractions: vec![0.5] };
    for (half, whole) in facade.illuminance(&year, "desks", &half, &Native).unwrap().data().iter().zip(found.data()) {
        assert!((half - 0.5 * whole).abs() <= 1e-4 * whole + 1e-6 * most, "{half} {whole}");
    }
    // A temporary folder goes with the last year in it.
    let (kept, place) = (year.clone(), year.folder().to_path_buf());
    drop(year);
    assert!(kept.picture("seat", 12).is_ok());
    drop(kept);
    assert!(!place.exists());
}

struct Stopping;

impl Progress for Stopping {
    fn update(&self, _stage: &str, _fraction: f64) {}

    fn stop_requested(&self) -> bool {
        true
    }
}

#[test]
fn errors_say_what_kind_they_are() {
    let kind = |error: Option<Error>| error.map(|e| e.kind());
    assert_eq!(kind(Project::read(Path::new("nowhere.toml")).err()), Some(ErrorKind::Io));
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(kind(blinds(folder.path()).set("quality", "sed", 1).build().err()), Some(ErrorKind::Input));
    assert_eq!(kind(Year::open(folder.path()).err()), Some(ErrorKind::Input));
    let Some(device) = device("a run that is stopped") else { return };
    let plan = Plan::new(blinds(folder.path()).build().unwrap(), &mut Warnings::new()).unwrap();
    assert_eq!(kind(plan.compute(&device, &Stopping, &mut Warnings::new()).err()), Some(ErrorKind::Stopped));
}
