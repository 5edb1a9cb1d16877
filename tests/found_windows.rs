//! Windows that a project does not name: surfaces of scattering data and panes of glass in its scene.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::simulate::project::builder::ProjectBuilder;
use lucarne::simulate::{Plan, Project, Summary};
use std::path::Path;

const BLIND: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/office/bsdf/blind.xml");
const ROOM: &str = concat!("void plastic wall 0 0 5 .5 .5 .5 0 0\n", include_str!("data/plain_room.rad"));
/// The opening of the south wall, its front in the room.
const INWARD: &str = "0.5 0 1  0.5 0 2.4  2.5 0 2.4  2.5 0 1";
const OUTWARD: &str = "2.5 0 1  2.5 0 2.4  0.5 0 2.4  0.5 0 1";

/// A room under some hours of sun, with what stands in its opening.
fn room(folder: &Path, opening: &str) -> ProjectBuilder {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let header = "place Test\nlatitude 45\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n";
    let hours: String = [1, 3, 6].iter().flat_map(|month| (9..16).map(move |hour| format!("{month} 21 {hour}.5 600 120\n"))).collect();
    write("w.wea", &format!("{header}{hours}"));
    write("room.rad", &format!("{ROOM}{opening}"));
    write("window.rad", &format!("void glow blind 0 0 4 1 1 1 0\nblind polygon opening 0 0 12  {INWARD}\n"));
    write("points.txt", "0.8 0.7 0.8 0 0 1\n2.2 1.5 0.8 0 0 1\n1.5 2.5 0.8 0 0 1\n1.2 3.5 0.8 0 0 1\n");
    write("eye.vf", "rvu -vta -vp 1.5 3 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180\n");
    std::fs::copy(BLIND, folder.join("blind.xml")).unwrap();
    let builder = Project::builder(folder).weather("w.wea").scene(&["room.rad"]).sensors("room", "points.txt");
    builder.view("eye", "eye.vf", [16, 16]).set("glare", "method", "dgps").set("quality", "preset", "draft")
}

fn bsdf(arguments: &str, corners: &str) -> String {
    format!("void BSDF blind {arguments}\nblind polygon opening 0 0 12  {corners}\n")
}

fn computed(builder: ProjectBuilder, out: &Path) -> Option<(Matrix<f32>, String, Summary, Vec<String>)> {
    let device = device("windows found in a scene")?;
    let mut warnings = Warnings::new();
    let plan = Plan::new(builder.build().unwrap(), &mut warnings).unwrap();
    let summary = plan.write(&device, out, &Silent, &mut Warnings::new()).unwrap();
    let glare = std::fs::read_to_string(out.join("glare/eye.csv")).unwrap();
    let lux = read_matrix(&out.join("illuminance/room.mtx")).unwrap().matrix;
    Some((lux, glare, summary, warnings.iter().map(ToString::to_string).collect()))
}

#[test]
fn scattering_data_of_a_scene_are_the_window_that_a_project_would_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let out = |name: &str| path.join(name);
    let named = |builder: ProjectBuilder| builder.window("blind", "window.rad", "blind.xml");
    let Some((lux, glare, summary, _)) = computed(named(room(path, "")), &out("named")) else { return };
    assert!(lux.data().iter().all(|v| *v > 0.0));

    let found = bsdf("6 0 blind.xml 0 0 1 . 0 0", INWARD);
    let (found_lux, found_glare, found_summary, warnings) = computed(room(path, &found), &out("found")).unwrap();
    assert!(found_lux == lux && found_glare == glare, "the same light at sensors and eyes");
    assert_eq!(found_summary.windows, summary.windows);
    assert!(!warnings.iter().any(|w| w.contains("turned around")), "{warnings:?}");
    // The up vector by a transform of its own: 1 0 0 about -y.
    let turned = bsdf("8 0 blind.xml 1 0 0 . -ry -90 0 0", INWARD);
    assert!(computed(room(path, &turned), &out("turned")).unwrap().0 == lux);

    // From the other side: the data are turned around, not the room.
    let planned = |builder: ProjectBuilder| {
        let mut warnings = Warnings::new();
        (Plan::new(builder.build().unwrap(), &mut warnings).unwrap(), warnings.iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let (back, warnings) = planned(room(path, &bsdf("6 0 blind.xml 0 0 1 . 0 0", OUTWARD)));
    assert!(warnings.iter().any(|w| w.contains("has its front outdoors: the data are turned around")), "{warnings:?}");
    let layers = room(path, "").begin("window").set("window", "name", "blind").set("window", "surface", "window.rad");
    let (layers, _) = planned(layers.set("window", "glazing", ["flip:blind.xml"]));
    let (plain, _) = planned(named(room(path, "")));
    let [back, layers, plain] = [&back, &layers, &plain].map(|p| &p.inputs.windows[0]);
    assert!(back.transmission == layers.transmission && back.transmission != plain.transmission);
    assert!(back.window.faces() == [180.0, 0.0] && back.window.frame == plain.window.frame);

    // aBSDF: the sun is seen through its peak.
    let clear = "void aBSDF blind 5 blind.xml 0 0 1 . 0 0\n".to_string() + &format!("blind polygon opening 0 0 12  {INWARD}\n");
    let plan = Plan::new(room(path, &clear).build().unwrap(), &mut Warnings::new()).unwrap();
    assert_eq!(plan.outline().unwrap().phases, 5);
}

#[test]
fn panes_of_a_scene_are_windows_for_views_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let glass = |corners: &str| format!("void glass blind 0 0 3 .7 .7 .7\nblind polygon opening 0 0 12  {corners}\n");
    let named = room(path, "").begin("window").set("window", "name", "blind").set("window", "surface", "window.rad");
    let transmittance = lucarne::scene::Pane { transmissivity: [0.7; 3], refraction_index: 1.52 }.at(1.0).0[0];
    let Some((lux, glare, ..)) = computed(named.set("window", "glass", transmittance), &path.join("named")) else { return };
    let (found, found_glare, summary, _) = computed(room(path, &glass(INWARD)), &path.join("found")).unwrap();
    assert_eq!((summary.windows.len(), summary.phases), (1, 5));
    for (found, lux) in found.data().iter().zip(lux.data()) {
        assert!((found / lux - 1.0).abs() < 1e-4, "{found} {lux}");
    }
    let rows = |text: &str| text.lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse::<f64>().unwrap()).collect::<Vec<_>>();
    assert!(rows(&found_glare).iter().zip(rows(&glare)).all(|(a, b)| (a - b).abs() < 1e-4), "{found_glare}{glare}");
    // Whichever way they are drawn.
    let plan = Plan::new(room(path, &glass(OUTWARD)).build().unwrap(), &mut Warnings::new()).unwrap();
    let window = &plan.inputs.windows[0];
    assert!(window.window.faces() == [180.0, 0.0] && window.glass.is_some() && (window.window.area() - 2.8).abs() < 1e-9);
}

#[test]
fn scattering_data_that_are_no_window_are_refused_by_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let said = |opening: &str| match room(folder.path(), opening).build() {
        Ok(_) => String::new(),
        Err(e) => e.to_string(),
    };
    let partition = "0.1 2 0.1  0.1 2 2.9  2.9 2 2.9  2.9 2 0.1";
    let outdoors = "0 -5 0  0 -5 3  3 -5 3  3 -5 0";
    for (opening, words) in [
        (
            format!("{}void glass g 0 0 3 .7 .7 .7\ng polygon w 0 0 12 {INWARD}\n", bsdf("6 0 blind.xml 0 0 1 . 0 0", partition)),
            "'opening' of scattering data 'blind' (7.84 m²) is no window: both of its sides are indoors",
        ),
        (bsdf("6 0 blind.xml 0 0 1 . 0 0", outdoors), "is no window: the sky is open to both of its sides"),
        (bsdf("6 0.05 blind.xml 0 0 1 . 0 0", INWARD), "its thickness 0.05 says that it stands for geometry"),
        (bsdf("6 th blind.xml 0 0 1 my.cal 0 0", INWARD), "the thickness 'th' is no number"),
        (bsdf("6 0 blind.xml ux uy uz my.cal 0 0", INWARD), "its up vector 'ux uy uz' is that of a function file ('my.cal')"),
        (bsdf("4 0 blind.xml 0 0 0 0", INWARD), "4 string arguments are too few"),
        (bsdf("6 0 blind.xml 0 0 0 . 0 0", INWARD), "its up vector has no length"),
        (bsdf("6 0 none.xml 0 0 1 . 0 0", INWARD), "'none.xml' does not exist"),
        (bsdf("6 0 blind.xml 0 0 1 . 0 9 .1 .1 .1 0 0 0 0 0 0", INWARD), "diffuse light that is added to the data (0.1)"),
        (bsdf("8 0 blind.xml 0 0 1 . -a 2 0 0", INWARD), "is no single motion"),
        (
            format!("void colorfunc c 4 .5 .5 .5 . 0 0\n{}", bsdf("6 0 blind.xml 0 0 1 . 0 0", INWARD).replace("void BSDF", "c BSDF")),
            "a pattern on scattering data",
        ),
        (format!("{}blind sphere ball 0 0 4 1.5 -3 1 0.5\n", bsdf("6 0 blind.xml 0 0 1 . 0 0", INWARD)), "is no window: it is not plane"),
    ] {
        let said = said(&opening);
        assert!(said.contains(words) && said.contains("room.rad:"), "{opening}: {said}");
    }
    // A room without any opening has no windows, and pictures need them.
    assert!(said("").contains("no glass or BSDF between indoors and the sky"), "{}", said(""));
}
