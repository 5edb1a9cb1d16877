//! Whole projects of five phases, by the library.

use super::*;
use lucarne::kernels::sun_matrix::{Openings, SunOptions, compute};

#[test]
fn without_sun_five_phases_are_three() {
    if device("five phases without sun").is_none() {
        return;
    }
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (five, out5) = blinds(folders[0].path(), &day(0.0), &shade(), "phases = 5").unwrap();
    let (three, out3) = blinds(folders[1].path(), &day(0.0), "", "phases = 3").unwrap();
    assert_eq!((five.phases, three.phases), (5, 3));
    assert_eq!(values(&out5, "room.mtx"), values(&out3, "room.mtx"));
    assert!(values(&out5, "room.mtx").iter().any(|v| *v > 0.0));
    assert_eq!(five.suns.unwrap().needed, 0);
}

#[test]
fn the_terms_of_five_phases_add_up_and_nothing_is_negative() {
    if device("terms of five phases").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (summary, out) = blinds(folder.path(), &day(700.0), &shade(), "phases = \"auto\"\nsuns = \"hourly\"").unwrap();
    assert_eq!(summary.phases, 5);
    let census = summary.suns.clone().unwrap();
    assert!(census.needed >= 8, "{census:?}");
    let all = values(&out, "room.mtx");
    let [three, direct, sun] = ["three_phase", "direct", "sun"].map(|term| values(&out, &format!("terms/room_{term}.mtx")));
    let largest = three.iter().copied().fold(0.0, f32::max);
    let (mut sunny, mut shadowed) = (0, 0);
    for i in 0..all.len() {
        assert!(all[i] >= 0.0 && direct[i] >= 0.0 && sun[i] >= 0.0 && three[i] >= direct[i] * 0.9999, "{i}");
        assert!((all[i] - (three[i] - direct[i] + sun[i])).abs() <= 1e-5 * largest, "{} {} {} {}", all[i], three[i], direct[i], sun[i]);
        sunny += usize::from(sun[i] > 5000.0);
        shadowed += usize::from(sun[i] < 500.0 && direct[i] > 1000.0);
    }
    println!("{sunny} sensor hours in a patch of sun, {shadowed} between patches that three phases blur");
    assert!(sunny > 0 && shadowed > 0);
    let error = summary.estimated_error.unwrap();
    assert!(error.hourly_median > 0.0 && error.hourly_median < 0.1);
    // A second run finds everything there.
    let (again, out) = blinds(folder.path(), &day(700.0), &shade(), "phases = \"auto\"\nsuns = \"hourly\"").unwrap();
    assert!(again.matrices.iter().all(|m| m.reused) && again.matrices.iter().any(|m| m.name == "C_room"), "{:?}", again.matrices);
    assert_eq!(values(&out, "room.mtx"), all);
    // Two phases keep the coefficients and give what three give.
    let (two, out) = blinds(folder.path(), &day(700.0), "", "phases = 2").unwrap();
    assert_eq!(two.phases, 2);
    assert_eq!(values(&out, "room.mtx"), three);
    assert!(out.join("matrices/DC_room.mtx").is_file());
}

/// The slats alone let the sun through, whatever the BSDF of their window is: no sun is counted twice.
#[test]
fn a_shaded_window_lets_the_direct_sun_in_once() {
    let Some(device) = device("the direct sun, once") else { return };
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let run = |folder: &Path, bsdf: &str| {
        let (_, out) = blinds_with(folder, &day(700.0), bsdf, &shade(), "phases = 5\nsuns = \"hourly\"").unwrap();
        [values(&out, "terms/room_sun.mtx"), values(&out, "terms/room_three_phase.mtx")]
    };
    let [sun, three] = run(folders[0].path(), &format!("{SCENES}/blinds/blind.xml"));
    let [sun_of_glass, three_of_glass] = run(folders[1].path(), &format!("{SCENES}/office/bsdf/double_clear.xml"));
    assert_eq!(sun, sun_of_glass);
    assert_ne!(three, three_of_glass);
    // It is that of the slats and the pane in a black room without any BSDF.
    let files = ["room.rad", "blinds.rad"].map(PathBuf::from);
    let mut scene = lucarne::scene::rad::read_scene(&files, &Path::new(SCENES).join("blinds"), &mut Warnings::new()).unwrap();
    for material in &mut scene.materials {
        if !material.name.starts_with("slat") && !material.name.starts_with("pane") {
            material.kind = lucarne::scene::MaterialKind::Plastic { color: [0.0; 3], specularity: 0.0, roughness: 0.0 };
        }
    }
    let project = Project::read(&folders[0].path().join("project.toml")).unwrap();
    let inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    let set = SunSet::new(&inputs.weather, SunScheme::HOURLY, &[inputs.windows[0].window.clone()]).unwrap();
    let options = SunOptions { paths: 1024, disc_samples: 64, ..SunOptions::default() };
    let windows = [inputs.windows[0].window.clone()];
    let sensors = &inputs.sensors[0].sensors;
    let plain = compute(&device, &scene, Openings::Windows(&windows), sensors, &set.suns, &options, &Silent).unwrap();
    let weight: f64 = lucarne::units::ILLUMINANCE_WEIGHTS.iter().sum();
    let read = |name: &str| read_matrix(&folders[0].path().join(format!("out/matrices/C_room_{name}_standard_error.mtx"))).unwrap().matrix;
    let errors = [read("own"), read("shared"), plain.own_error, plain.shared_error];
    let (mut sums, mut variance) = ([0.0; 2], 0.0);
    for sensor in 0..sensors.len() {
        // Suns share the paths of a sensor, so their errors add up.
        let mut error = [0.0; 4];
        for (hour, of_hour) in set.hours.iter().enumerate() {
            let Some((column, radiance)) = of_hour else { continue };
            sums[0] += f64::from(sun[sensor * set.hours.len() + hour]);
            sums[1] += at(&plain.total, sensor, *column) * radiance * weight;
            error.iter_mut().zip(&errors).for_each(|(sum, e)| *sum += at(e, sensor, *column) * radiance * weight);
        }
        variance += error.iter().map(|e| e * e).sum::<f64>();
    }
    let error = variance.sqrt() / sums[1];
    println!("sun {:.4} of that of the plain geometry ± {error:.4}", sums[0] / sums[1]);
    assert!((sums[0] / sums[1] - 1.0).abs() < 3.0 * error && error < 0.06);
}

#[test]
fn a_shade_must_be_at_its_window() {
    let folder = tempfile::tempdir().unwrap();
    let complaint = |text: &str| {
        std::fs::write(folder.path().join("shade.rad"), text).unwrap();
        let error = blinds(folder.path(), &day(0.0), "shade = \"shade.rad\"", "phases = 5").err().map(|e| e.to_string());
        error.unwrap_or_default()
    };
    let away = "void plastic slat 0 0 5 .5 .5 .5 0 0\nslat polygon p 0 0 9 10 0 0  11 0 0  10 0 1\n";
    let message = complaint(away);
    assert!(message.contains("not at its window") && message.contains("shade.rad") && message.contains("south"), "{message}");
    let message = complaint("# nothing\n");
    assert!(message.contains("no surface"), "{message}");
    let message = complaint("slat polygon p 0 0 9 1 0 0  2 0 0  1 0 1\n");
    assert!(message.contains("shade.rad") && message.contains("slat"), "{message}");
}

#[test]
fn direct_matrices_never_exceed_the_whole_on_any_shipped_scene() {
    let Some(device) = device("direct matrices of the shipped scenes") else { return };
    let analytic = ["facing_window", "furnace", "horizontal_window"].map(|scene| format!("analytic/{scene}"));
    for scene in ["office", "asymmetric", "blinds"].map(String::from).into_iter().chain(analytic) {
        let folder = tempfile::tempdir().unwrap();
        let mut file = Path::new(SCENES).join(&scene).join("project.toml");
        if !file.is_file() {
            let place = format!("{SCENES}/{scene}");
            let text = format!(
                "[weather]\nfile = \"{SCENES}/office/weather/new_york.wea\"\n[scene]\nfiles = [\"{place}/room.rad\"]\n\
                 [[window]]\nname = \"w\"\nsurface = \"{place}/window.rad\"\nbsdf = \"{SCENES}/office/bsdf/double_clear.xml\"\n\
                 [[sensors]]\nname = \"points\"\npoints = \"{place}/points.txt\"\n"
            );
            file = folder.path().join("project.toml");
            std::fs::write(&file, text).unwrap();
        }
        let mut project = Project::read(&file).unwrap();
        project.quality.preset = lucarne::simulate::project::Preset::Draft;
        // Pictures have direct parts where suns are taken out of them.
        project.views.retain(|_| project.method.phases == lucarne::simulate::project::method::Phases::Five);
        project.views.iter_mut().for_each(|v| v.resolution = [24, 24]);
        project.images.hours = lucarne::simulate::project::views::ImageHours::None;
        project.glare = None;
        let mut warnings = Warnings::new();
        let mut inputs = Inputs::read(&project, &mut warnings).unwrap();
        inputs.weather.records.truncate(24);
        if scene == "analytic/facing_window" {
            // In this black room a sensor that looks away from the window sees nothing.
            inputs.sensors[0].sensors.retain(|s| s.direction.y < 0.0);
        }
        run(&device, &project, &inputs, folder.path(), &Silent, &mut warnings).unwrap();
        let receivers = project.sensors.iter().map(|s| &s.name).chain(project.views.iter().map(|v| &v.name));
        let names = receivers.map(|n| format!("V_{n}")).chain(inputs.windows.iter().map(|w| format!("D_{}", w.name)));
        for name in names {
            let read = |suffix: &str| read_matrix(&folder.path().join(format!("matrices/{name}{suffix}.mtx"))).unwrap().matrix.into_data();
            let (total, direct) = (read(""), read("_direct"));
            assert!(direct.iter().any(|d| *d > 0.0), "{scene}: {name}");
            assert!(total.iter().zip(&direct).all(|(t, d)| t >= d && *d >= 0.0), "{scene}: {name}");
        }
    }
}

/// Illuminance at the eye from the picture of an hour.
fn seen_by_the_eye(out: &Path, size: usize, hour: usize) -> f64 {
    let camera = lucarne::camera::View::read(&Path::new(SCENES).join("blinds/views/seat.vf")).unwrap().camera().unwrap();
    let raster = lucarne::camera::Raster::fit(camera, size, size, 1.0).unwrap();
    let geometry = lucarne::glare::PixelGeometry::new(&raster).unwrap();
    let path = out.join(format!("images/seat/img_{hour:04}.hdr"));
    let picture = lucarne::image::hdr::read_with(&path, lucarne::image::hdr::Exposure::Undo).unwrap();
    let weights = lucarne::units::ILLUMINANCE_WEIGHTS;
    let values: Vec<f32> =
        picture.pixels.iter().map(|p| p.iter().zip(weights).map(|(v, w)| f64::from(*v) * w).sum::<f64>() as f32).collect();
    assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0));
    geometry.totals(&values).unwrap().vertical_illuminance
}

#[test]
fn pictures_with_suns_light_the_eye_as_the_sensor_in_its_place_is_lit() {
    if device("pictures of five phases").is_none() {
        return;
    }
    const SIZE: usize = 96;
    let hours = [9, 11, 12, 14];
    // 15 January.
    let of_year = hours.map(|h| 14 * 24 + h);
    let folder = tempfile::tempdir().unwrap();
    let view = format!("[[view]]\nname = \"seat\"\nfile = \"{SCENES}/blinds/views/seat.vf\"\nresolution = [{SIZE}, {SIZE}]\n");
    let method = format!("phases = 5\nsuns = \"hourly\"\n{view}[images]\nhours = {of_year:?}");
    let (_, out) = blinds(folder.path(), &day(700.0), &shade(), &method).unwrap();
    let lux = values(&out, "room.mtx");
    let sun = values(&out, "terms/room_sun.mtx");
    let count = lux.len() / 24;
    let (mut worst, mut sunny) = (0.0f64, 0.0f64);
    for hour in hours {
        // The last sensor is the eye.
        let (sensor, of_sun) = (f64::from(lux[(count - 1) * 24 + hour]), f64::from(sun[(count - 1) * 24 + hour]));
        let eye = seen_by_the_eye(&out, SIZE, 14 * 24 + hour);
        println!("hour {hour}: picture {eye:.0} lx, sensor {sensor:.0} lx, of which {of_sun:.0} lx from the traced sun");
        worst = worst.max((eye / sensor - 1.0).abs());
        sunny = sunny.max(of_sun);
    }
    assert!(sunny > 100.0, "no sun reaches the eye");
    // The sensor's hour alone has a standard error of 1 %.
    assert!(worst < 0.03, "{worst}");
    // Run again, nothing is traced and the pictures are the same.
    let before = std::fs::read(out.join("images/seat/img_0348.hdr")).unwrap();
    let (again, out) = blinds(folder.path(), &day(700.0), &shade(), &method).unwrap();
    assert_eq!(again.rays, 0);
    assert_eq!(std::fs::read(out.join("images/seat/img_0348.hdr")).unwrap(), before);
}
