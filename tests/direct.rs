//! Sensors that see the sky itself: through clear glass, or by no window at all.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::gpu::Device;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::scene::Pane;
use lucarne::simulate::project::builder::ProjectBuilder;
use lucarne::simulate::{Plan, Project, Summary};
use lucarne::{Result, Warnings};
use std::path::Path;
use testing::{measured, percent, percents};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
const GREY: &str = "void plastic wall 0 0 5 .5 .5 .5 0 0\n";
/// A room of 3 m × 4 m × 3 m; the opening in its south wall has no reveal.
const ROOM: &str = include_str!("data/plain_room.rad");
/// A reveal of 0.4 m outside the opening.
const REVEAL: &str = "wall polygon sill 0 0 12  0.5 0 1  0.5 -0.4 1  2.5 -0.4 1  2.5 0 1
wall polygon head 0 0 12  0.5 0 2.4  2.5 0 2.4  2.5 -0.4 2.4  0.5 -0.4 2.4
wall polygon left 0 0 12  0.5 0 1  0.5 0 2.4  0.5 -0.4 2.4  0.5 -0.4 1
wall polygon right 0 0 12  2.5 0 1  2.5 -0.4 1  2.5 -0.4 2.4  2.5 0 2.4
";
const OPENING: &str = "0.5 0 1  0.5 0 2.4  2.5 0 2.4  2.5 0 1";
const POINTS: &str = "0.8 0.7 0.8 0 0 1\n2.2 1.5 0.8 0 0 1\n1.5 2.5 0.8 0 0 1\n1.2 3.5 0.8 0 0 1\n1.5 2.0 1.2 0 -1 0\n";

/// A project in a folder, without windows: scene, sensors, and some days of sun and sky at 45° north.
fn project(folder: &Path, scene: &str, points: &str) -> ProjectBuilder {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let header = "place Test\nlatitude 45\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n";
    let hours: String = [1, 3, 6].iter().flat_map(|month| (9..16).map(move |hour| format!("{month} 21 {hour}.5 600 120\n"))).collect();
    write("w.wea", &format!("{header}{hours}"));
    write("scene.rad", scene);
    write("window.rad", &format!("void glow window 0 0 4 1 1 1 0\nwindow polygon opening 0 0 12  {OPENING}\n"));
    write("points.txt", points);
    Project::builder(folder).weather("w.wea").scene(&["scene.rad"]).sensors("room", "points.txt")
}

fn glass(folder: &Path, scene: &str) -> ProjectBuilder {
    project(folder, scene, POINTS).glass_window("south", "window.rad", 0.65)
}

fn planned(builder: ProjectBuilder) -> Result<(Plan, Vec<String>)> {
    let mut warnings = Warnings::new();
    let plan = Plan::new(builder.build()?, &mut warnings)?;
    Ok((plan, warnings.iter().map(ToString::to_string).collect()))
}

fn computed(device: &Device, builder: ProjectBuilder, out: &Path) -> Summary {
    planned(builder).unwrap().0.write(device, out, &Silent, &mut Warnings::new()).unwrap()
}

/// Sums over the hours, of a matrix in the folder of results, per sensor.
fn sums(out: &Path, name: &str) -> Vec<f64> {
    let m = read_matrix(&out.join(format!("{name}.mtx"))).unwrap().matrix;
    (0..m.rows()).map(|row| m.row(row).iter().map(|v| f64::from(*v)).sum()).collect()
}

/// Columns of a table, without its head and the sensors' numbers and places.
fn table(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|l| l.split(',').skip(4).map_while(|v| v.parse().ok()).collect()).collect()
}

#[test]
fn sensors_behind_glass_see_the_sky_itself_unless_other_windows_forbid() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{GREY}{ROOM}");
    let (plan, warnings) = planned(glass(folder.path(), &scene)).unwrap();
    let outline = plan.outline().unwrap();
    let text = outline.to_string();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!(text.starts_with("direct, I = C·S − Cd·Sds + Cds·Ssun") && text.contains("all windows are clear glass"), "{text}");
    assert!(text.contains("DC of sensors") && !text.contains("D of south") && text.contains("suns hourly"), "{text}");
    // A view has its pictures by the windows' bins.
    std::fs::write(folder.path().join("v.vf"), "rvu -vta -vp 1.5 2 1.2 -vd 0 -1 0 -vh 180 -vv 180\n").unwrap();
    let (plan, _) = planned(glass(folder.path(), &scene).view("seat", "v.vf", [16, 16])).unwrap();
    let text = plan.outline().unwrap().to_string();
    assert!(text.contains("view seat: by bins of the windows") && text.contains("D of south") && text.contains("DC of sensors"), "{text}");
    // Another window with data: all are taken by bins, and the plan says why.
    std::fs::write(folder.path().join("east.rad"), "void polygon e 0 0 12  3 1 1  3 2 1  3 2 2  3 1 2\n").unwrap();
    let bsdf = format!("{SCENES}/office/bsdf/double_clear.xml");
    let (plan, _) = planned(glass(folder.path(), &scene).window("east", "east.rad", &bsdf)).unwrap();
    let outline = plan.outline().unwrap();
    assert!(outline.phases == 5 && outline.sensors_method.starts_with("five phases"), "{outline}");
    assert!(outline.phases_because.contains("not all windows are 'glass'"), "{outline}");
    let wrong = |builder: ProjectBuilder| planned(builder).unwrap_err().to_string();
    let direct = |b: ProjectBuilder| b.set("method", "phases", "direct");
    for (error, words) in [
        (wrong(direct(glass(folder.path(), &scene).window("east", "east.rad", &bsdf))), ["window 'east' scatters it", "method.phases"]),
        (wrong(project(folder.path(), &scene, POINTS).set("method", "phases", 3)), ["there is none", "write phases = \"direct\""]),
        (wrong(project(folder.path(), &scene, POINTS).view("seat", "v.vf", [16, 16])), ["need windows", "glass = 0.65"]),
        (wrong(glass(folder.path(), &scene).set("method", "phases", "direkt")), ["'direkt' is not known here", "\"direct\""]),
        (
            wrong(glass(folder.path(), &scene).view("seat", "v.vf", [16, 16]).set("output", "quantity", "irradiance")),
            ["output.quantity", "without [[view]]"],
        ),
        (wrong(project(folder.path(), &scene, POINTS).set("output", "quantity", "lux")), ["'lux' is not known here", "\"irradiance\""]),
        (wrong(project(folder.path(), &scene, POINTS).set("output", "quantiti", "irradiance")), ["'quantiti'", "did you mean 'quantity'?"]),
    ] {
        assert!(words.iter().all(|w| error.contains(w)), "{words:?}: {error}");
    }
}

/// Nothing outside or in the wall makes parts of the window differ, so what is averaged over it is exact; bins of the
/// Klems basis remain, and the light that the pane sends back into the room.
#[test]
fn without_a_reveal_direct_coefficients_and_five_phases_agree() {
    let Some(device) = device("direct coefficients and five phases") else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{GREY}{ROOM}");
    let of = |name: &str, phases: &dyn Fn(ProjectBuilder) -> ProjectBuilder| {
        let out = folder.path().join(name);
        let builder = phases(glass(folder.path(), &scene)).set("method", "suns", "hourly");
        let summary = computed(&device, builder, &out);
        let error = sums(&out, "illuminance/room_standard_error");
        (sums(&out, "illuminance/room"), error, summary)
    };
    let (direct, error, summary) = of("direct", &|b| b);
    assert!(summary.sensors_method.starts_with("direct") && summary.phases == 5, "{}", summary.sensors_method);
    let (five, ..) = of("five", &|b| b.set("method", "phases", 5));
    let differences: Vec<f64> = direct.iter().zip(&five).map(|(a, b)| a / b - 1.0).collect();
    // Errors of hours are those of the same rays, so their sum bounds that of the sum.
    let noise: Vec<f64> = error.iter().zip(&direct).map(|(e, v)| e / v).collect();
    println!("{differences:?}, noise {noise:?}");
    measured("direct-and-five-phases", &percents(&differences), "2 % + 3 standard errors");
    assert!(differences.iter().zip(&noise).all(|(d, n)| d.abs() < 0.02 + 3.0 * n), "{differences:?}");
    assert!(noise.iter().all(|n| *n < 0.05), "{noise:?}");
    // Again: nothing to trace. Another pane: C anew.
    let again = computed(&device, glass(folder.path(), &scene).set("method", "suns", "hourly"), &folder.path().join("direct"));
    assert!(again.rays == 0 && again.matrices.iter().all(|m| m.reused), "{:?}", again.matrices);
    let darker = project(folder.path(), &scene, POINTS).glass_window("south", "window.rad", 0.4).set("method", "suns", "hourly");
    let other = computed(&device, darker, &folder.path().join("direct"));
    assert!(other.matrices.iter().filter(|m| m.name != "S").all(|m| !m.reused), "{:?}", other.matrices);
}

/// The stated standard errors are those by which other random numbers differ.
#[test]
fn other_random_numbers_differ_by_the_stated_error() {
    let Some(device) = device("noise of direct coefficients") else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{GREY}{ROOM}{REVEAL}");
    let mut squares = Vec::new();
    let mut results: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut hours: Vec<[Vec<f32>; 2]> = Vec::new();
    for seed in 1..=6 {
        let out = folder.path().join(seed.to_string());
        let builder = glass(folder.path(), &scene).set("quality", "seed", seed).set("quality", "preset", "draft");
        computed(&device, builder.set("method", "sky_subdivision", 1), &out);
        // Mean of the year and its standard error.
        results.push(table(&out.join("illuminance/room_annual.csv")).iter().map(|r| [r[0], r[1]]).collect());
        let of = |name: &str| read_matrix(&out.join(format!("illuminance/{name}.mtx"))).unwrap().matrix.into_data();
        hours.push([of("room"), of("room_standard_error")]);
    }
    for sensor in 0..results[0].len() {
        let mean = results.iter().map(|r| r[sensor][0]).sum::<f64>() / results.len() as f64;
        squares.extend(results.iter().map(|r| ((r[sensor][0] - mean) / r[sensor][1]).powi(2)));
    }
    // Five degrees of freedom of six; errors are known from eight batches: the mean of z² is 7/5 of that.
    let z2 = squares.iter().sum::<f64>() / squares.len() as f64 * 6.0 / 5.0;
    println!("mean z² {z2:.2}");
    assert!((0.4..3.0).contains(&z2), "{z2}");
    // The same of single hours, most of them with sun.
    let n = hours.len() as f64;
    let (mut sum, mut errors) = (0.0, Vec::new());
    for hour in 0..hours[0][0].len() {
        let mean = hours.iter().map(|[v, _]| f64::from(v[hour])).sum::<f64>() / n;
        sum += hours.iter().map(|[v, e]| ((f64::from(v[hour]) - mean) / f64::from(e[hour])).powi(2)).sum::<f64>();
        errors.extend(hours.iter().map(|[_, e]| f64::from(e[hour]) / mean));
    }
    let z2 = sum / (n - 1.0) / hours[0][0].len() as f64;
    errors.sort_by(f64::total_cmp);
    let (median, most) = (errors[errors.len() / 2], errors[errors.len() - 1]);
    println!("hours: mean z² {z2:.2}, stated errors {median:.4} in the median, {most:.4} at most");
    measured("direct-hours-with-sun", &format!("median {}, most {}", percent(median), percent(most)), "median 4 %, as seeds differ");
    assert!((0.6..2.6).contains(&z2) && median < 0.04, "{z2} {median}");
}

#[test]
fn a_uniform_sky_through_a_pane_in_its_reveal_is_that_of_radiance() {
    let Some(device) = device("direct coefficients against Radiance") else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    computed(&device, glass(folder.path(), &format!("{GREY}{ROOM}{REVEAL}")).set("method", "sky_subdivision", 1), &out);
    let c = read_matrix(&out.join("matrices/DC_room.mtx")).unwrap().matrix;
    let sum = |row: usize| (0..c.cols()).map(|p| f64::from(c.at(row, p)[1])).sum::<f64>();
    let t = Pane::of_transmittance([0.65; 3]).unwrap().transmissivity[0];
    let pane = format!("void glass pane 0 0 3 {t} {t} {t}\npane polygon p 0 0 12 {OPENING}\n");
    let Some(wanted) = testing::rtrace_under_even_sky(folder.path(), &format!("{GREY}{ROOM}{REVEAL}{pane}"), POINTS) else { return };
    assert_eq!(wanted.len(), c.rows());
    let errors: Vec<f64> = (0..wanted.len()).map(|i| sum(i) / wanted[i] - 1.0).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    println!("{errors:?}, mean {mean}");
    measured("direct-uniform-sky", &format!("mean {}, {}", percent(mean), percents(&errors)), "mean 1 %, each 3 %");
    assert!(mean.abs() < 0.01 && errors.iter().all(|e| e.abs() < 0.03), "{errors:?}");
}

#[test]
fn a_wall_takes_its_half_of_the_sky_and_its_suns() {
    let Some(device) = device("a wall under the open sky") else { return };
    let folder = tempfile::tempdir().unwrap();
    // A black wall without end, and two sensors to its east: one looks up, one at the wall.
    let wall = "void plastic black 0 0 5 0 0 0 0 0\nblack polygon west 0 0 12  10 -5000 -1  10 5000 -1  10 5000 9000  10 -5000 9000\n";
    let points = "10.01 0 1 0 0 1\n10.01 0 1 -1 0 0\n";
    let builder = project(folder.path(), wall, points).set("output", "quantity", "irradiance");
    let (plan, warnings) = planned(builder).unwrap();
    assert!(plan.outline().unwrap().phases_because.contains("names no window"));
    assert!(warnings.iter().any(|w| w.contains("reflectances of light")), "{warnings:?}");
    let out = folder.path().join("out");
    let summary = plan.write(&device, &out, &Silent, &mut Warnings::new()).unwrap();
    assert_eq!(summary.quantity, "irradiance");
    assert!(summary.sensors[0].mean_illuminance_lx.is_none() && summary.sensors[0].metrics.is_empty());
    let sky = table(&out.join("irradiance/room_sky.csv"));
    assert!((sky[0][0] - 0.5).abs() < 0.01, "beside the wall half of the sky: {sky:?}");
    assert!(sky[1][0] < 1e-4 && sky[1][2] == 0.0, "towards the wall nothing is seen: {sky:?}");
    let mornings = plan.inputs.weather.records.iter().filter(|r| plan.inputs.weather.sun(r).direction().x > 0.0).count();
    assert_eq!(sky[0][2], mornings as f64, "the sun comes over the wall from the east alone");
    let annual = table(&out.join("irradiance/room_annual.csv"));
    let hours = plan.inputs.weather.records.len() as f64;
    assert!((annual[0][2] - annual[0][0] * hours / 1000.0).abs() < 2e-3, "{annual:?}");
}

#[test]
fn an_open_plane_has_the_whole_sky_and_all_of_the_sun() {
    let Some(device) = device("an open plane") else { return };
    let folder = tempfile::tempdir().unwrap();
    let far = "void plastic black 0 0 5 0 0 0 0 0\nblack polygon below 0 0 12  -1 -1 -9  1 -1 -9  1 1 -9  -1 1 -9\n";
    let builder = project(folder.path(), far, "0 0 1 0 0 1\n0 0 1 0 -1 0\n").set("output", "quantity", "irradiance");
    let (plan, _) = planned(builder).unwrap();
    let out = folder.path().join("out");
    plan.write(&device, &out, &Silent, &mut Warnings::new()).unwrap();
    let found = read_matrix(&out.join("irradiance/room.mtx")).unwrap().matrix;
    for (step, record) in plan.inputs.weather.records.iter().enumerate() {
        let sun = plan.inputs.weather.sun(record).direction();
        let (level, wanted) = (f64::from(found.at(0, step)[0]), 120.0 + 600.0 * sun.z);
        // Patches of the sky hold the diffuse light to some tenths of a percent; the weather's sun stands where it is.
        assert!((level / wanted - 1.0).abs() < 0.01, "step {step}: {level} {wanted}");
        // A wall: the sun by its cosine, half of the sky or more where it is bright there, and the ground's light.
        let south = f64::from(found.at(1, step)[0]) - 600.0 * (-sun.y).max(0.0);
        assert!((40.0..220.0).contains(&south), "step {step}: {south}");
    }
    let sky = table(&out.join("irradiance/room_sky.csv"));
    assert!((sky[0][0] - 1.0).abs() < 5e-3 && (sky[1][0] - 0.5).abs() < 5e-3, "{sky:?}");
    let all = plan.inputs.weather.records.len() as f64;
    assert_eq!(sky[0][2], all, "the sun shines in every hour of this weather");
    let south = plan.inputs.weather.records.iter().filter(|r| plan.inputs.weather.sun(r).direction().y < 0.0).count();
    assert_eq!(sky[1][2], south as f64);
}

/// The same room with its pane named as a window, and with the pane found in the scene.
#[test]
fn windows_that_are_found_give_what_windows_that_are_named_give() {
    let Some(device) = device("windows that are found") else { return };
    let folder = tempfile::tempdir().unwrap();
    let t = Pane::of_transmittance([0.65; 3]).unwrap().transmissivity[0];
    let scene = format!("{GREY}{ROOM}void glass clear 0 0 3 {t} {t} {t}\nclear polygon p 0 0 12 {OPENING}\n");
    let draft = |b: ProjectBuilder| b.set("method", "sky_subdivision", 1).set("quality", "preset", "draft");
    let (plan, warnings) = planned(draft(project(folder.path(), &scene, POINTS))).unwrap();
    let text = plan.outline().unwrap().to_string();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!(text.contains("window clear: 2.80 m² facing 180°, glass of the scene 'clear'") && text.contains("names no window"), "{text}");
    let out = folder.path().join("found");
    let summary = plan.write(&device, &out, &Silent, &mut Warnings::new()).unwrap();
    assert!(summary.windows.len() == 1 && summary.windows[0].faces == [180.0, 0.0] && summary.glass_left.is_empty());
    let named = folder.path().join("named");
    computed(&device, draft(glass(folder.path(), &format!("{GREY}{ROOM}"))), &named);
    let (found, named) = (sums(&out, "illuminance/room"), sums(&named, "illuminance/room"));
    // The same rays through the same window, whose corners begin elsewhere in its outline.
    let worst = found.iter().zip(&named).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    println!("{worst:.1e}");
    assert!(worst < 0.15, "{found:?} {named:?}");
}

#[test]
fn a_closed_room_without_a_window_is_told_what_it_lacks() {
    let Some(device) = device("a room without a window") else { return };
    let folder = tempfile::tempdir().unwrap();
    let pane = format!("wall polygon shut 0 0 12 {OPENING}\n");
    let (plan, warnings) = planned(project(folder.path(), &format!("{GREY}{ROOM}{pane}"), POINTS)).unwrap();
    assert!(warnings.iter().any(|w| w.contains("no light of the sky is found to reach 5 of 5 sensors")), "{warnings:?}");
    let error = plan.write(&device, &folder.path().join("out"), &Silent, &mut Warnings::new()).unwrap_err().to_string();
    assert!(error.contains("no light of the sky reaches any sensor") && error.contains("there is no [[window]]"), "{error}");
}
