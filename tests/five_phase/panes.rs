//! Suns through panes of scattering data.

use super::*;

/// Scattering data in place of the slats. The traced suns bring back 0.93 of Vd·T·Dd·Sds, and most of the
/// difference is Sds: gendaymtx, and with it the three-phase method, spreads every sun over the four
/// nearest patches, up to 24° wide. The same Vd·T·Dd gives 0.89 of that if each sun stays in its own
/// patch. What remains is that a real sun does not fill its patch, and the deep reveal.
#[test]
fn suns_are_traced_through_scattering_data_in_place_of_a_shade() {
    if device("five phases through scattering data").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let tree = format!("tensor_tree = \"{SCENES}/blinds/blind.xml\"");
    // Suns of a whole summer and winter, so that the places within patches even out.
    let weather: String = (1..=12)
        .flat_map(|month| (1..=28).step_by(3).map(move |day| (month, day)))
        .flat_map(|(month, day)| (7..17).map(move |h| format!("{month} {day} {h}.5 600 80\n")))
        .collect();
    let (summary, out) = blinds(folder.path(), &weather, &tree, "phases = 5\nsuns = \"hourly\"").unwrap();
    assert_eq!(summary.phases, 5);
    let [direct, sun] = ["direct", "sun"].map(|term| values(&out, &format!("terms/room_{term}.mtx")));
    let sum = |v: &[f32]| v.iter().map(|x| f64::from(*x)).sum::<f64>();
    let back = sum(&sun) / sum(&direct);
    // Each sun in its own patch of Vd·T·Dd, by the sensors' illuminance.
    let project = Project::read(&folder.path().join("project.toml")).unwrap();
    let inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    let [coefficients, _] = direct_coefficients(&out, &inputs.windows[0].transmission);
    let sky = ReinhartSky::new(1).unwrap();
    let hours = SunSet::new(&inputs.weather, SunScheme::HOURLY, &[]).unwrap().hours;
    let disc = Sun::new(glam::DVec3::Z).solid_angle() * lucarne::units::ILLUMINANCE_WEIGHTS.iter().sum::<f64>();
    let mut unspread = 0.0;
    for (record, hour) in inputs.weather.records.iter().zip(&hours) {
        let Some((_, radiance)) = hour else { continue };
        let patch = sky.bin_of(inputs.weather.sun(record).direction());
        let of_patch: f64 = coefficients.chunks(sky.len()).map(|row| row[patch]).sum();
        unspread += of_patch * radiance * disc / sky.solid_angle(patch);
    }
    let own_patch = unspread / sum(&direct);
    println!("{} suns: {back:.3} of the direct part comes back; in its own patch {own_patch:.3}", summary.suns.unwrap().needed);
    assert!(own_patch < 0.92, "the spread alone makes {own_patch}");
    assert!((back / own_patch - 1.0).abs() < 0.06, "{back} {own_patch}");
    assert!(values(&out, "room.mtx").iter().all(|v| *v >= 0.0));
    // Either of the two, not both.
    let both = format!("{tree}\n{}", shade());
    let error = blinds(folder.path(), &day(0.0), &both, "phases = 5").unwrap_err().to_string();
    assert!(error.contains("either through a 'shade' or through a 'tensor_tree'"), "{error}");
}

/// Vd·T·Dd of a black project's only window, `[sensor][patch]`, and its variance by the standard errors
/// stated for V and D.
fn direct_coefficients(out: &Path, t: &Matrix<f64>) -> [Vec<f64>; 2] {
    let read = |name: &str| read_matrix(&out.join(format!("matrices/{name}.mtx"))).unwrap().matrix;
    let [v, d] = ["V_room_direct", "D_south_direct"].map(read);
    let [v_error, d_error] = ["V_room_standard_error", "D_south_standard_error"].map(read);
    let (bins, patches) = (d.rows(), d.cols());
    let (mut values, mut variances) = (vec![0.0; v.rows() * patches], vec![0.0; v.rows() * patches]);
    for patch in 1..patches {
        let through: Vec<f64> = (0..bins).map(|o| (0..bins).map(|i| t.at(o, i)[0] * at(&d, i, patch)).sum()).collect();
        for sensor in 0..v.rows() {
            let cell = sensor * patches + patch;
            values[cell] = (0..bins).map(|o| at(&v, sensor, o) * through[o]).sum();
            let of_v = (0..bins).map(|o| (at(&v_error, sensor, o) * through[o]).powi(2)).sum::<f64>();
            let of_d =
                (0..bins).map(|i| (at(&d_error, i, patch) * (0..bins).map(|o| at(&v, sensor, o) * t.at(o, i)[0]).sum::<f64>()).powi(2));
            variances[cell] = of_v + of_d.sum::<f64>();
        }
    }
    [values, variances]
}

/// With suns that fill the sky's own patches and a pane of the same Klems data, Cds is Vd·T·Dd, and
/// Cds·Ssun cancels Vd·T·Dd·Sds. Where the window stands free: a deep reveal lights parts of the window
/// differently, which V and D average separately.
#[test]
fn suns_that_fill_the_skys_patches_cancel_the_direct_part() {
    use lucarne::kernels::sun_matrix::pane::PaneBsdf;
    use lucarne::kernels::sun_matrix::{Openings, SunOptions, compute};
    let Some(device) = device("cancellation") else { return };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("room.rad", "void plastic black 0 0 5 0 0 0 0 0\nblack polygon floor 0 0 12 0 0 0  3 0 0  3 4 0  0 4 0\n");
    write("window.rad", "#@rfluxmtx h=kf u=+Z\nvoid polygon south 0 0 12  0.7 0 0.95  0.7 0 2.15  2.3 0 2.15  2.3 0 0.95\n");
    write("points.txt", "0.5 0.6 0.8 0 0 1\n2.2 2.4 0.8 0.2 0 1\n1.5 2.2 1.2 0 -1 0\n");
    let header = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
    let days: String = [1, 3, 6].iter().flat_map(|month| (7..18).map(move |h| format!("{month} 21 {h}.5 700 80\n"))).collect();
    write("w.wea", &format!("{header}{days}"));
    let bsdf = format!("{SCENES}/blinds/blind.xml");
    write(
        "project.toml",
        &format!(
            "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"window.rad\"\nbsdf = \"{bsdf}\"\n\
         tensor_tree = \"{bsdf}\"\n[[sensors]]\nname = \"room\"\npoints = \"points.txt\"\n[method]\nphases = 5\nsky_subdivision = 1\nsuns = 1\n[quality]\npreset = \"draft\"\n"
        ),
    );
    let project = Project::read(&folder.path().join("project.toml")).unwrap();
    let inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    let out = folder.path().join("out");
    run(&device, &project, &inputs, &out, &Silent, &mut Warnings::new()).unwrap();
    let [three, variance] = direct_coefficients(&out, &inputs.windows[0].transmission);

    let sun_only = lucarne::sky::SkyOptions { sky: false, ..lucarne::sky::SkyOptions::default() };
    let sds = lucarne::sky::sky_matrix(&inputs.weather, &sun_only, &Silent).unwrap();
    let sunny: Vec<usize> = (1..sds.rows()).filter(|p| (0..sds.cols()).any(|hour| at(&sds, *p, hour) > 0.0)).collect();
    // Independent suns in each part of every patch, four times: their spread is the error of all.
    const SIDE: usize = 6;
    const REPEATS: usize = 6;
    let scattering =
        lucarne::bsdf::evaluate::Scattering::new(&lucarne::bsdf::read(Path::new(&bsdf), &mut Warnings::new()).unwrap()).unwrap();
    let panes = [(inputs.windows[0].window.clone(), PaneBsdf::Bsdf(scattering))];
    let sky = ReinhartSky::new(1).unwrap();
    let sensors = &inputs.sensors[0].sensors;
    let mut filled = Vec::new();
    for repeat in 0..REPEATS {
        let random = |k: usize| ((k as f64 + 1.0) * 0.754_877_666 * (repeat as f64 + 1.37)).fract();
        let suns: Vec<Sun> = (0..sunny.len() * SIDE * SIDE)
            .map(|n| {
                let k = n % (SIDE * SIDE);
                let place = |i: usize, r: usize| (i as f64 + random(2 * n + r)) / SIDE as f64;
                Sun::new(sky.direction(sunny[n / (SIDE * SIDE)], place(k / SIDE, 0), place(k % SIDE, 1))).as_point()
            })
            .collect();
        let options = SunOptions { cells: 64, batches: 2, seed: repeat as u32 + 1, ..SunOptions::default() };
        let c = compute(&device, &inputs.scene, Openings::Panes(&panes), sensors, &suns, &options, &Silent).unwrap().total;
        let mut of_patches = vec![0.0; sensors.len() * sky.len()];
        for sensor in 0..sensors.len() {
            for (first, &patch) in (0..suns.len()).step_by(SIDE * SIDE).zip(&sunny) {
                let mean = (first..first + SIDE * SIDE).map(|sun| at(&c, sensor, sun)).sum::<f64>() / (SIDE * SIDE) as f64;
                of_patches[sensor * sky.len() + patch] = mean / suns[0].solid_angle() * sky.solid_angle(patch);
            }
        }
        filled.push(of_patches);
    }
    let (mut chi, mut count, mut sums) = (0.0, 0.0, [0.0f64; 3]);
    for sensor in 0..sensors.len() {
        for hour in 0..sds.cols() {
            let over =
                |m: &[f64], power: i32| (1..sky.len()).map(|p| m[sensor * sky.len() + p] * at(&sds, p, hour).powi(power)).sum::<f64>();
            let repeats: Vec<f64> = filled.iter().map(|f| over(f, 1)).collect();
            let mean = repeats.iter().sum::<f64>() / REPEATS as f64;
            let own = repeats.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (REPEATS * (REPEATS - 1)) as f64;
            let (wanted, error) = (over(&three, 1), (own + over(&variance, 2)).sqrt());
            if wanted > 0.0 {
                chi += ((mean - wanted) / error).powi(2);
                count += 1.0;
                sums = [sums[0] + mean, sums[1] + wanted, sums[2] + error];
            }
        }
    }
    let [traced, wanted, error] = sums;
    println!(
        "Cds·Ssun {:.4} of Vd·T·Dd·Sds; standard error {:.4} of it; {count} sensor hours, χ² {:.2} each",
        traced / wanted,
        error / wanted,
        chi / count
    );
    assert!(error < 0.015 * wanted && (traced - wanted).abs() < error);
    // With six repeats the mean of χ² is 5/3.
    const CHI: f64 = 3.0;
    assert!(chi / count < CHI);
    let found = format!("{:.3} ± {:.3}; χ² {} per sensor and hour (5/3 expected)", traced / wanted, error / wanted, short(chi / count));
    measured("filled-patches-cancel", &found, &format!("stated error; χ² {}", short(CHI)));
}

/// A shade as Radiance has it: slats in the slab of a BSDF with thickness, which sun and eye pass.
#[test]
fn a_bsdf_with_thickness_lets_the_sun_pass_to_its_slats() {
    let folder = tempfile::tempdir().unwrap();
    let slats = std::fs::read_to_string(format!("{SCENES}/blinds/blinds.rad")).unwrap();
    let with = |head: &str| {
        // Beside the shipped file, since it may name others.
        let file = folder.path().join("proxy.rad");
        std::fs::write(&file, format!("{head}{slats}")).unwrap();
        format!("shade = \"{}\"", file.display())
    };
    let proxy = |thickness: &str, up: &str| {
        format!(
            "void BSDF proxy\n6 {thickness} {SCENES}/blinds/blind.xml {up} .\n0\n0\n\
             proxy polygon face 0 0 12  0.7 -0.06 0.95  0.7 -0.06 2.15  2.3 -0.06 2.15  2.3 -0.06 0.95\n"
        )
    };
    let complaint = |head: &str| blinds(folder.path(), &day(0.0), &with(head), "phases = 5").err().map(|e| e.to_string());
    let message = complaint(&proxy("0.2", "0 2 0")).unwrap();
    assert!(message.contains("up vector 0 2 0") && message.contains("parallel") && message.contains("proxy.rad:5"), "{message}");
    let message = complaint(&proxy("0", "0 0 1")).unwrap();
    assert!(message.contains("BSDF") && message.contains("not supported"), "{message}");
    let message = complaint(&proxy("wide", "0 0 1")).unwrap();
    assert!(message.contains("'wide' is no number") && message.contains("proxy.rad:1"), "{message}");
    let message = complaint("void BSDF proxy\n2 0.1 x.xml\n0\n0\nproxy polygon f 0 0 9  0 0 0  1 0 0  0 0 1\n").unwrap();
    assert!(message.contains("2 string arguments are too few"), "{message}");
    if device("geometry behind a BSDF").is_none() {
        return;
    }
    // The wrong side, all of it; and too thin a slab, where a part lies outside.
    let shade = |head: &str| {
        let project = folder.path().join("project.toml");
        blinds(folder.path(), &day(0.0), &with(head), "phases = 5")?;
        let mut warnings = Warnings::new();
        Inputs::read(&Project::read(&project)?, &mut warnings)?;
        Ok::<_, lucarne::Error>(warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    };
    let message = shade(&proxy("-0.001", "0 0 1")).unwrap_err().to_string();
    assert!(message.contains("outside the slab of 0.0010") && message.contains("proxy.rad"), "{message}");
    // The same light as of the slats alone.
    let mut found = Vec::new();
    for head in ["", &proxy("1", "0 0 1")] {
        let (_, out) = blinds(folder.path(), &day(700.0), &with(head), "phases = 5\nsuns = \"hourly\"").unwrap();
        found.push(values(&out, "terms/room_sun.mtx"));
    }
    assert!(found[0] == found[1] && found[0].iter().any(|v| *v > 1000.0));
}
