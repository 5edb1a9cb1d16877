//! The job that the engine Foton (github.com/snjsomnath/foton, MIT) publishes as its benchmark: a shoebox behind a pane
//! under an overhang and between fins, 216 sensors, 146 patches, 8760 hours of a made-up sky, two diffuse reflections.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::bins::ReinhartSky;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, read_matrix, write_matrix};
use lucarne::progress::Silent;
use lucarne::scene::Pane;
use lucarne::simulate::{Plan, Project};
use std::f64::consts::PI;
use testing::{measured, percent};

const ROOM: &str = "void plastic grey 0 0 5 .5 .5 .5 0 0
grey polygon floor 0 0 12  0 0 0  6 0 0  6 9 0  0 9 0
grey polygon ceiling 0 0 12  0 0 3  0 9 3  6 9 3  6 0 3
grey polygon west 0 0 12  0 0 0  0 9 0  0 9 3  0 0 3
grey polygon east 0 0 12  6 0 0  6 0 3  6 9 3  6 9 0
grey polygon north 0 0 12  0 9 0  6 9 0  6 9 3  0 9 3
grey polygon south 0 0 30  0 0 0  0 0 3  6 0 3  6 0 0  0 0 0  1.5 0 1  4.5 0 1  4.5 0 2.5  1.5 0 2.5  1.5 0 1
grey polygon overhang 0 0 12  1.5 0 2.5  4.5 0 2.5  4.5 -.75 2.5  1.5 -.75 2.5
grey polygon fin1 0 0 12  1.5 0 1  1.5 -.5 1  1.5 -.5 2.5  1.5 0 2.5
grey polygon fin2 0 0 12  4.5 0 1  4.5 -.5 1  4.5 -.5 2.5  4.5 0 2.5
";
const HOURS: usize = 8760;
/// Lumens per watt of red, green and blue, as Radiance has them.
const WEIGHTS: [f64; 3] = [47.435, 119.93, 11.635];

/// Radiance of a patch at brightness 1, RGB: brighter towards the zenith.
fn patch(height: f64) -> [f64; 3] {
    [0.92, 1.0, 1.08].map(|c| 14.0 * (0.25 + 0.75 * height.max(0.0)) * c)
}

/// Brightness of an hour: by day, season and clouds.
fn brightness(step: usize) -> f64 {
    let (hour, day) = ((step % 24) as f64, (step / 24) as f64);
    let daylight = (PI * (hour - 6.0) / 12.0).sin().max(0.0);
    let season = 0.72 + 0.28 * (2.0 * PI * (day - 172.0) / 365.0).cos();
    daylight * season * (0.78 + 0.22 * (0.37 * day + 0.11 * hour).sin().powi(2))
}

#[test]
fn a_public_shoebox_s_year_is_that_of_rcontrib() {
    let Some(device) = device("the public shoebox") else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let t = Pane::of_transmittance([0.6; 3]).unwrap().transmissivity[0];
    let pane = format!("void glass pane 0 0 3 {t} {t} {t}\npane polygon p 0 0 12  1.5 0 1  4.5 0 1  4.5 0 2.5  1.5 0 2.5\n");
    std::fs::write(path("room.rad"), format!("{ROOM}{pane}")).unwrap();
    let grid: Vec<String> =
        (0..216).map(|i| format!("{} {} .75 0 0 1\n", 0.25 + 0.5 * f64::from(i % 12), 0.25 + 0.5 * f64::from(i / 12))).collect();
    std::fs::write(path("points.txt"), grid.concat()).unwrap();
    let sky = ReinhartSky::new(1).unwrap();
    let of_hours: Vec<f64> = (0..HOURS).map(brightness).collect();
    let row = |p: usize| of_hours.iter().flat_map(move |b| patch(sky.centre(p).z).map(|c| (c * b) as f32)).collect::<Vec<f32>>();
    let matrix = Matrix::from_data(sky.len(), HOURS, 3, (0..sky.len()).flat_map(row).collect()).unwrap();
    write_matrix(Some(&path("S.mtx")), &matrix, Format::Float, &[]).unwrap();

    let builder = Project::builder(folder.path()).scene(&["room.rad"]).sensors("grid", "points.txt").set("method", "bounces", 3);
    let builder = builder.set("weather", "sky_matrix", "S.mtx").set("weather", "sky_matrix_direct", "none");
    let summary = Plan::new(builder.build().unwrap(), &mut Warnings::new())
        .unwrap()
        .write(&device, &path("out"), &Silent, &mut Warnings::new())
        .unwrap();
    let lux = read_matrix(&path("out/illuminance/grid.mtx")).unwrap().matrix;
    assert_eq!((lux.rows(), lux.cols(), summary.windows.len(), summary.sky_subdivision), (216, HOURS, 1, 1));
    let stated = summary.estimated_error.unwrap();
    assert!(stated.annual_median < 0.01 && stated.target_met != Some(false), "{stated:?}");

    // Radiance with the options of that benchmark.
    let (Some(mut oconv), Some(mut rcontrib)) = (testing::radiance("oconv"), testing::radiance("rcontrib")) else { return };
    let glow = "void glow even 0 0 4 1 1 1 0\neven source sky 0 0 4 0 0 1 180\neven source ground 0 0 4 0 0 -1 180\n";
    std::fs::write(path("sky.rad"), glow).unwrap();
    std::fs::write(path("scene.oct"), testing::output(oconv.current_dir(folder.path()).args(["room.rad", "sky.rad"]))).unwrap();
    let options =
        "-I+ -h -w -V- -ab 3 -ad 4096 -as 0 -aa 0 -lr -10 -lw 2.4e-5 -e MF:1 -f reinhart.cal -b rbin -bn Nrbins -m even scene.oct";
    let points = std::fs::File::open(path("points.txt")).unwrap();
    let text = testing::output(rcontrib.current_dir(folder.path()).args(options.split(' ')).stdin(points));
    let values: Vec<f64> = String::from_utf8(text).unwrap().split_whitespace().map(|v| v.parse().unwrap()).collect();
    assert_eq!(values.len(), 216 * 146 * 3);
    let wanted = |sensor: usize| -> f64 {
        let of_patch = |p: usize| {
            let rgb = patch(sky.centre(p).z);
            (0..3).map(|c| values[(sensor * 146 + p) * 3 + c] * rgb[c] * WEIGHTS[c]).sum::<f64>()
        };
        (0..146).map(of_patch).sum::<f64>() * of_hours.iter().sum::<f64>()
    };
    let years: Vec<[f64; 2]> = (0..216).map(|s| [lux.row(s).iter().map(|v| f64::from(*v)).sum(), wanted(s)]).collect();
    let total = |i: usize| years.iter().map(|y| y[i]).sum::<f64>();
    let bias = total(0) / total(1) - 1.0;
    let spread = (years.iter().map(|[a, b]| (a / b - 1.0).powi(2)).sum::<f64>() / 216.0).sqrt();
    println!("bias {bias:.5}, sensors' years differ by {spread:.4} (rms), stated {:?}", stated.annual_median);
    let found = format!("sum {}, sensors' years {} (rms, most of it Radiance's)", percent(bias), percent(spread));
    measured("shoebox", &found, "1 %, 6 %");
    // Two such runs of rcontrib differ by some 5 % at single sensors, in the sum by less than 0.1 %.
    assert!(bias.abs() < 0.01 && spread < 0.06, "{bias} {spread}");
}
