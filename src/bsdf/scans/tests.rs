use super::*;
use std::fmt::Write as _;

/// Files of a folder that is removed at the end.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

/// Rows of a DSF that is `amplitude` · cos θ, every 3°; the room's side if `room`.
fn cosine(amplitude: f64, room: bool) -> String {
    let mut text = String::new();
    for ring in 0..30 {
        let theta = 1.5 + 3.0 * f64::from(ring);
        for k in 0..60 {
            let shown = if room { theta } else { 180.0 - theta };
            let _ = writeln!(text, "{shown} {} {:.6}", 6 * k, amplitude * theta.to_radians().cos());
        }
    }
    text
}

/// A file of light from the outside at 30°, up as given.
fn header(theta: f64, phi: f64, up: f64) -> String {
    format!("#sample_name \"cloth\"\n#format: theta phi DSF\n#intheta {theta}\n#inphi {phi}\n#upphi {up}\n")
}

fn read_all(paths: &[PathBuf]) -> (Result<Scans>, Warnings) {
    let mut warnings = Warnings::new();
    (read(paths, &Options::default(), &mut warnings), warnings)
}

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-12
}

#[test]
fn angles_become_directions_of_travel_in_the_windows_frame() {
    let folder = Folder::new();
    // Light from the outside, above: θ from the normal into the room is 150°, up is at φ = 0.
    let file = folder.file("a.dat", header(150.0, 0.0, 0.0) + &cosine(0.2 / std::f64::consts::PI, true));
    let one = &read_one(&file, &Options::default(), &mut Warnings::new()).unwrap()[0];
    assert_eq!(one.component, Component::TransmissionFront);
    assert!(close(one.incident, DVec3::new(0.0, -0.5, 0.75f64.sqrt())), "it travels downwards: {}", one.incident);
    assert!((one.theta() - 30.0).abs() < 1e-9 && (one.phi() - 270.0).abs() < 1e-9);
    // ∫ a cos θ over the hemisphere is a π; means over blocks of cells meet it to within 2 %.
    assert!((one.grid.integral() - 0.2).abs() < 0.004, "{}", one.grid.integral());
    // Seen from behind (the sample's front to the outside): the same numbers are light from the room, mirrored.
    let options = Options { reversed: true, ..Options::default() };
    let other = &read_one(&file, &options, &mut Warnings::new()).unwrap()[0];
    assert_eq!(other.component, Component::TransmissionBack);
    assert!(close(other.incident, DVec3::new(0.0, -0.5, 0.75f64.sqrt())));
    // Right of up, seen from the front, is φ = −90°; reversed it is +90°.
    let right = folder.file("r.dat", header(150.0, 270.0, 0.0) + &cosine(0.1, true));
    let travel = |options: &Options| read_one(&right, options, &mut Warnings::new()).unwrap()[0].incident;
    assert!(close(travel(&Options::default()), DVec3::new(-0.5, 0.0, 0.75f64.sqrt())));
    assert!(close(travel(&options), DVec3::new(0.5, 0.0, 0.75f64.sqrt())));
}

#[test]
fn each_side_and_sense_has_its_component() {
    let folder = Folder::new();
    for (theta, room, component) in [
        (150.0, true, Component::TransmissionFront),
        (30.0, false, Component::TransmissionBack),
        (150.0, false, Component::ReflectionFront),
        (30.0, true, Component::ReflectionBack),
    ] {
        let file = folder.file("a.dat", header(theta, 10.0, 90.0) + &cosine(0.1, room));
        assert_eq!(read_one(&file, &Options::default(), &mut Warnings::new()).unwrap()[0].component, component);
    }
}

#[test]
fn a_bsdf_is_multiplied_by_the_cosine_and_of_xyz_y_is_used() {
    let folder = Folder::new();
    let constant: String = cosine(1.0, true).lines().map(|l| format!("{} 0.1\n", l.rsplit_once(' ').unwrap().0)).collect();
    let file = folder.file("a.dat", header(150.0, 0.0, 90.0).replace("DSF", "BTDF") + &constant);
    let one = &read_one(&file, &Options::default(), &mut Warnings::new()).unwrap()[0];
    assert!((one.grid.integral() - 0.1 * std::f64::consts::PI).abs() < 0.0063, "{}", one.grid.integral());
    let xyz: String = cosine(0.1, true)
        .lines()
        .map(|l| {
            let w: Vec<&str> = l.split(' ').collect();
            format!("{} {} 9 {} 8\n", w[0], w[1], w[2])
        })
        .collect();
    let file = folder.file("b.dat", header(150.0, 0.0, 90.0) + "#colorimetry: CIE-XYZ\n" + &xyz);
    let mut warnings = Warnings::new();
    let one = &read_one(&file, &Options::default(), &mut warnings).unwrap()[0];
    assert!((one.grid.integral() - 0.1 * std::f64::consts::PI).abs() < 0.0063, "{}", one.grid.integral());
    assert!(warnings.iter().any(|w| w.to_string().contains("only Y")));
}

#[test]
fn a_table_means_what_files_of_one_direction_mean_and_order_does_not_matter() {
    let folder = Folder::new();
    let rows = cosine(0.05, true);
    let files: Vec<PathBuf> =
        [40.0, 0.0, 20.0].iter().map(|t| folder.file(&format!("{t}.dat"), header(180.0 - t, 30.0, 90.0) + &rows)).collect();
    let mut table = String::from("theta_in,phi_in,theta_out,phi_out,DSF\n");
    // All incident directions interleaved, from the last row to the first.
    for row in rows.lines().rev() {
        for t in [20.0, 40.0, 0.0] {
            let _ = writeln!(table, "{},30,{}", 180.0 - t, row.replace(' ', ","));
        }
    }
    let (by_file, warnings) = read_all(&files);
    assert!(warnings.is_empty());
    let (by_table, _) = read_all(&[folder.file("all.csv", table)]);
    let (by_file, by_table) = (by_file.unwrap(), by_table.unwrap());
    assert_eq!(by_file.name, "cloth");
    assert_eq!(by_file.scans.iter().map(|s| s.theta().round()).collect::<Vec<_>>(), [0.0, 20.0, 40.0]);
    for (a, b) in by_file.scans.iter().zip(&by_table.scans) {
        assert!(close(a.incident, b.incident));
        assert_eq!((a.samples, a.grid.len(), a.largest.0), (b.samples, b.grid.len(), b.largest.0));
        assert!((a.grid.integral() - b.grid.integral()).abs() < 1e-12);
    }
}

#[test]
fn values_below_zero_stay_in_averages_and_are_counted() {
    let folder = Folder::new();
    let noisy: String = cosine(0.0, true)
        .lines()
        .enumerate()
        .map(|(k, l)| format!("{} {}\n", l.rsplit_once(' ').unwrap().0, if k % 2 == 0 { -0.01 } else { 0.03 }))
        .collect();
    let file = folder.file("a.dat", header(150.0, 0.0, 90.0) + &noisy);
    let one = &read_one(&file, &Options::default(), &mut Warnings::new()).unwrap()[0];
    assert_eq!(one.negative.0 * 2, one.samples);
    assert!((one.noise() - 0.01).abs() < 1e-12);
    // The mean is 0.01.
    assert!((one.grid.integral() - 0.01 * std::f64::consts::TAU).abs() < 0.005, "{}", one.grid.integral());
}

#[test]
fn bad_input_is_refused_with_file_line_and_a_way_out() {
    let folder = Folder::new();
    let good = header(150.0, 0.0, 90.0);
    let rows = cosine(0.05, true);
    let radians: String = rows
        .lines()
        .map(|l| {
            let w: Vec<f64> = l.split(' ').map(|w| w.parse().unwrap()).collect();
            format!("{} {} {}\n", w[0].to_radians(), w[1].to_radians(), w[2])
        })
        .collect();
    let brighter = cosine(1.2, true);
    for (text, wanted, line) in [
        (rows.clone(), "does not say what the values are", Some(1)),
        (good.replace("#intheta 150\n", "") + &rows, "from where the light comes", Some(5)),
        (good.replace("DSF", "XYZ") + &rows, "no known quantity", Some(2)),
        (good.replace("150", "steep") + &rows, "no angle in degrees", Some(3)),
        (good.clone(), "no rows of values", None),
        (good.clone() + "1 2 0.1\n1 2 NaN\n", "no measured one", Some(7)),
        (good.clone() + "1 2 inf\n", "no measured one", Some(6)),
        (good.clone() + "1 2\n", "not a row of three numbers", Some(6)),
        (good.clone() + "1 2 dark\n", "not a row of three numbers", Some(6)),
        (good.clone() + "190 2 0.1\n", "beyond 180°", Some(6)),
        (good.clone() + "10 0 0.1\n170 0 0.1\n", "both sides of the sample", Some(7)),
        (good.clone() + &radians, "look like radians", Some(6)),
        (good.clone() + &"1 ".repeat(5000), "characters", Some(6)),
        (good.clone() + "1 2 \0\n", "binary data", Some(6)),
        (String::from("theta_in,phi_in,theta_out,phi_out,DSF\n150,0,10,0,0.1\n150,0,10,0\n"), "not a row of five numbers", Some(3)),
        (String::from("theta_in,phi_in,theta_out,phi_out,DSF\n"), "no rows that are used", None),
    ] {
        let file = folder.file("bad.dat", &text);
        let error = read_one(&file, &Options::default(), &mut Warnings::new()).expect_err(wanted).to_string();
        assert!(error.contains(wanted) && error.contains("bad.dat"), "{wanted}: {error}");
        if let Some(line) = line {
            assert!(error.contains(&format!("bad.dat:{line}")), "{wanted}: {error}");
        }
    }
    let other = folder.file("other.dat", header(180.0, 0.0, 90.0) + &rows);
    for (text, wanted) in [
        (good.clone() + &cosine(0.0, true), "all values are zero or negative"),
        // 1.2 π of the light as DSF; as BSDF values it would be 0.8 π, which is too much as well.
        (good.clone() + &brighter, "% of the light is scattered"),
        (good.replace("150", "30") + &rows, "this is reflection into the room"),
    ] {
        let file = folder.file("bad.dat", &text);
        let error = read_all(&[other.clone(), file]).0.expect_err(wanted).to_string();
        assert!(error.contains(wanted) && error.contains("bad.dat"), "{wanted}: {error}");
    }
    // BSDF values that are called DSF: 0.45/sr everywhere is 2.8 of the light as DSF, and would be 1.4 as a BSDF; 0.3/sr is 0.94.
    let constant: String = rows.lines().map(|l| format!("{} 0.3\n", l.rsplit_once(' ').unwrap().0)).collect();
    let error = read_all(&[other.clone(), folder.file("bad.dat", good.clone() + &constant)]).0.unwrap_err().to_string();
    assert!(error.contains("theta phi BSDF"), "{error}");
    let error = read_all(&[other]).0.unwrap_err().to_string();
    assert!(error.contains("at least two"), "{error}");
    let missing = read_all(&[folder.0.path().join("none.dat")]).0.unwrap_err().to_string();
    assert!(missing.contains("none.dat"), "{missing}");
}

#[test]
fn files_of_the_same_incident_direction_are_put_together_with_a_warning() {
    let folder = Folder::new();
    let rows = cosine(0.05, true);
    let a = folder.file("a.dat", header(150.0, 0.0, 90.0) + &rows);
    let b = folder.file("b.dat", header(150.01, 0.0, 90.0) + "20 20 0.08\n");
    let c = folder.file("c.dat", header(180.0, 0.0, 90.0) + &rows);
    let (scans, warnings) = read_all(&[a, b, c]);
    let scans = scans.unwrap();
    assert_eq!(scans.scans.len(), 2);
    assert_eq!(scans.scans[1].samples, rows.lines().count() + 1);
    assert_eq!(scans.scans[1].largest.0, 0.08);
    assert!(warnings.iter().any(|w| w.to_string().contains("put together")));
}

#[test]
fn a_flat_top_warns_of_a_saturated_detector() {
    let folder = Folder::new();
    let peak = |most: f64| -> String {
        let mut text = String::new();
        for i in -40..=40 {
            for j in -40..=40 {
                let (x, y) = (0.4 * f64::from(i), 0.4 * f64::from(j));
                let (r2, phi) = (x * x + y * y, y.atan2(x).to_degrees());
                let _ = writeln!(text, "{} {phi} {}", r2.sqrt(), (2.0 * (-0.5 * r2 / 9.0).exp()).min(most));
            }
        }
        text
    };
    let other = folder.file("other.dat", header(150.0, 0.0, 90.0) + &peak(9.0));
    for (most, warned) in [(9.0, false), (1.0, true)] {
        let file = folder.file("a.dat", header(180.0, 0.0, 90.0) + &peak(most));
        let (scans, warnings) = read_all(&[other.clone(), file]);
        scans.unwrap();
        assert_eq!(warnings.iter().any(|w| w.to_string().contains("saturated")), warned, "{most}");
    }
}

#[test]
fn many_samples_take_the_memory_of_the_directions_they_lie_in() {
    let mut scan = Scan::new(DVec3::Z, Component::TransmissionFront, Path::new("a"));
    let mut random = crate::random::Random(3);
    for _ in 0..1_000_000 {
        scan.add(random.cosine_direction(DVec3::Z), 0.1);
    }
    assert_eq!(scan.samples, 1_000_000);
    assert!(scan.grid.len() <= CELLS);
    assert!((scan.grid.integral() - 0.1 * std::f64::consts::TAU).abs() < 1e-9);
}

#[test]
fn cells_are_of_equal_solid_angle_and_directions_come_back() {
    for cell in (0..CELLS).step_by(97) {
        let d = cell_direction(cell, SIDE);
        assert!((d.length() - 1.0).abs() < 1e-12 && d.z >= 0.0);
        let [u, v] = square_of(d);
        assert_eq!((u * SIDE as f64) as usize * SIDE + (v * SIDE as f64) as usize, cell);
    }
    // Equal solid angles: a random direction falls into each of 16 × 16 blocks equally often.
    let mut counts = [0u32; 256];
    let mut random = crate::random::Random(5);
    for _ in 0..256_000 {
        let (z, phi) = (random.next(), std::f64::consts::TAU * random.next());
        let r = (1.0 - z * z).sqrt();
        let [u, v] = square_of(DVec3::new(r * phi.cos(), r * phi.sin(), z));
        counts[(u * 16.0) as usize * 16 + (v * 16.0) as usize] += 1;
    }
    // χ² of 255 degrees of freedom: 255 ± 23.
    let chi: f64 = counts.iter().map(|c| (f64::from(*c) - 1000.0).powi(2) / 1000.0).sum();
    assert!((chi - 255.0).abs() < 4.0 * 22.6, "{chi}");
}
