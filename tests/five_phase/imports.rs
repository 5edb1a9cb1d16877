//! Radiance's matrices in place of V, Vd, D, Dd and Cds.

use super::*;
use lucarne::matrix::file::{Format, write_matrix};

/// A project in the tutorial's room with Radiance's matrices; `sun` and `phases` as given.
fn project(folder: &Path, shared: &Path, sensors: &str, window: &str, method: &str) -> Result<Matrix<f32>> {
    let room = shared.join("data/tutorial_room");
    let room = room.display();
    let text = format!(
        "[weather]\nfile = \"{room}/weather/NYC.wea\"\n[scene]\nfiles = [\"{room}/materials.rad\", \"{room}/room.rad\"]\n\
         [[window]]\nname = \"south\"\nsurface = \"{room}/objects/GlazingVmtx.rad\"\nbsdf = \"{room}/bsdf/blinds_correct_klems.xml\"\n{window}\n\
         [[sensors]]\nname = \"points\"\npoints = \"{room}/points.txt\"\n{sensors}\n[method]\n{method}\n[quality]\npreset = \"draft\"\n"
    );
    std::fs::write(folder.join("project.toml"), text).unwrap();
    let project = Project::read(&folder.join("project.toml"))?;
    let mut warnings = Warnings::new();
    let inputs = Inputs::read(&project, &mut warnings)?;
    let out = folder.join("out");
    let summary = run(&Device::shared()?, &project, &inputs, &out, &Silent, &mut warnings)?;
    assert_eq!(summary.rays, 0, "nothing is traced");
    assert!(warnings.iter().any(|w| w.to_string().contains("made elsewhere")));
    Ok(read_matrix(&out.join("illuminance/points.mtx")).unwrap().matrix)
}

/// Cds of point suns by Radiance, columns as in the project's suns.rad.
fn suns_by_radiance(folder: &Path, shared: &Path) -> Option<()> {
    let room = shared.join("data/tutorial_room");
    let weather = Weather::read(&room.join("weather/NYC.wea"), &mut Warnings::new()).unwrap();
    let windows = lucarne::scene::read_windows(Path::new("objects/GlazingVmtx.rad"), &room, &mut Warnings::new()).unwrap();
    let set = SunSet::new(&weather, SunScheme::Patches(ReinhartSky::new(6).unwrap()), &windows).unwrap();
    let (mut lights, mut names) = (String::new(), String::new());
    for (column, sun) in set.columns.iter().zip(&set.suns) {
        let d = sun.direction;
        lights += &format!("void light sol{column} 0 0 3 1e6 1e6 1e6\nsol{column} source s 0 0 4 {} {} {} .533\n", d.x, d.y, d.z);
        names += &format!("sol{column}\n");
    }
    let file = |name: &str| folder.join(name);
    std::fs::write(file("suns.rad"), lights).unwrap();
    std::fs::write(file("suns.mod"), names).unwrap();
    let mut oconv = testing::radiance("oconv")?;
    oconv.args(["materialBlack.rad", "roomBlack.rad", "../reference/fivephase/blindsGeometry.rad"]).arg(file("suns.rad"));
    std::fs::write(file("room.oct"), testing::output(oconv.current_dir(&room))).unwrap();
    let mut rcontrib = testing::radiance("rcontrib")?;
    rcontrib.args("-V+ -I+ -ab 0 -dc 1 -dt 0 -dj 0 -ss 0 -y 100 -faf -M".split(' ')).arg(file("suns.mod")).arg(file("room.oct"));
    rcontrib.current_dir(&room).stdin(std::fs::File::open(room.join("points.txt")).unwrap());
    std::fs::write(file("values.mtx"), testing::output(&mut rcontrib)).unwrap();
    // Radiance drops coefficients below 1e-6, so its suns have a radiance of a million.
    let coefficients = read_matrix(&file("values.mtx")).unwrap().matrix.map(|v| v / 1e6);
    assert_eq!((coefficients.rows(), coefficients.cols()), (100, set.suns.len()));
    write_matrix(Some(&file("Cds.mtx")), &coefficients, Format::Float, &[]).unwrap();
    Some(())
}

/// The largest deviation from a reference (rows hours), relative to the sensor's mean. The light is grey,
/// and the reference's photometric weights are rounded.
fn deviation(found: &Matrix<f32>, reference: &Path) -> f64 {
    let wanted = read_matrix(reference).unwrap().matrix;
    assert_eq!((found.rows(), found.cols()), (wanted.cols(), wanted.rows()));
    let rounded = (47.4 + 119.9 + 11.6) / lucarne::units::ILLUMINANCE_WEIGHTS.iter().sum::<f64>();
    let mut worst = 0.0f64;
    for sensor in 0..found.rows() {
        let mean = (0..found.cols()).map(|hour| at(&wanted, hour, sensor)).sum::<f64>() / found.cols() as f64;
        for hour in 0..found.cols() {
            worst = worst.max((at(found, sensor, hour) * rounded - at(&wanted, hour, sensor)).abs() / mean);
        }
    }
    worst
}

#[test]
fn radiances_matrices_give_radiances_years() {
    let (Some(shared), Some(_)) = (testing::shared(), device("imported matrices")) else { return };
    let reference = shared.join("data/reference");
    let at_sensors = reference.join("sensors");
    let (v, d) = (at_sensors.join("V_best.mtx"), at_sensors.join("D1_4x.mtx"));
    let folder = tempfile::tempdir().unwrap();
    let (view, daylight) = (format!("view = \"{}\"", v.display()), format!("daylight = \"{}\"", d.display()));
    let three = project(folder.path(), &shared, &view, &daylight, "phases = 3").unwrap();
    const SAME: f64 = 1e-4;
    let of_three = deviation(&three, &at_sensors.join("annual_MF1_blinds_correct_klems.ill"));
    println!("three phases: {of_three:.1e} of a sensor's mean");
    assert!(of_three < SAME, "{of_three}");

    let Some(()) = suns_by_radiance(folder.path(), &shared) else { return };
    let five = reference.join("fivephase");
    let sensors = format!("{view}\nview_direct = \"{0}/Vd.mtx\"\nsun = \"Cds.mtx\"", five.display());
    let window = format!("{daylight}\ndaylight_direct = \"{0}/Dd.mtx\"\nshade = \"{0}/blindsGeometry.rad\"", five.display());
    let year = project(folder.path(), &shared, &sensors, &window, "phases = 5\nsuns = 6").unwrap();
    let off = deviation(&year, &five.join("annual_5ph_geo0.ill"));
    println!("five phases: {off:.1e} of a sensor's mean");
    assert!(off < SAME, "{off}");
    measured("imported-years", &format!("within {} of the sensor's mean", short(off.max(of_three))), &short(SAME));

    // What does not fit is refused, with file and reason.
    let complaint = |sensors: &str, window: &str, method: &str| {
        project(folder.path(), &shared, sensors, window, method).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let swapped = [format!("view = \"{}\"", d.display()), format!("daylight = \"{}\"", v.display())];
    let message = complaint(&swapped[0], "", "phases = 3");
    assert!(message.contains("D1_4x.mtx") && message.contains("145 rows and 146 columns") && message.contains("100 x 145"), "{message}");
    assert!(complaint("", &swapped[1], "phases = 3\nsky_subdivision = 1").contains("145 x 146"));
    assert!(complaint(&view, &window, "phases = 5").contains("without its direct part"));
    assert!(complaint(&sensors, &daylight, "phases = 3").contains("only five phases"));
    let alone = format!("view_direct = \"{}/Vd.mtx\"", five.display());
    assert!(complaint(&alone, "", "phases = 3").contains("which is not given"));
    assert!(complaint(&sensors, &window, "phases = 5\nsuns = 5").contains("columns, one per sun"));
    let mut broken = read_matrix(&v).unwrap().matrix;
    broken.at_mut(3, 7)[0] = -1.0;
    write_matrix(Some(&folder.path().join("broken.mtx")), &broken, Format::Float, &[]).unwrap();
    let message = complaint("view = \"broken.mtx\"", "", "phases = 3");
    assert!(message.contains("row 4, column 8 holds -1") && message.contains("broken.mtx"), "{message}");
}
