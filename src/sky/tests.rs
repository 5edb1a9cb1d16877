//! The sky matrix against gendaymtx (numbers kept here, and the program itself where installed),
//! and against what must hold for any sky.

use super::*;
use crate::error::Warnings;
use crate::matrix::file::read_matrix_from;
use crate::progress::Silent;
use crate::testing;
use std::fmt::Write as _;
use std::path::Path;

const NEW_YORK: &str = "place NEWYORK_USA\nlatitude 40.78\nlongitude 73.97\ntime_zone 75.0\nsite_elevation 57.0\nweather_data_file_units 1\n3 21 9.5 500 150\n3 21 12.0 850 100\n6 21 12.0 900 110\n6 21 7.0 0 120\n12 21 12.0 100 180\n12 21 20.0 0 0\n9 21 15.5 300 200\n";

fn weather(text: &str) -> Weather {
    Weather::from_bytes(text.as_bytes(), &mut Warnings::new()).unwrap()
}

fn matrix(weather: &Weather, options: &SkyOptions) -> Matrix<f32> {
    sky_matrix(weather, options, &Silent).unwrap()
}

fn header(latitude: f64, west: f64, meridian: f64, units: u8) -> String {
    format!(
        "place Somewhere_XYZ\nlatitude {latitude}\nlongitude {west}\ntime_zone {meridian}\nsite_elevation 1\nweather_data_file_units {units}\n"
    )
}

/// Numbers that look random and never change.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// Six days of the year with all kinds of sky: overcast, broken, clear, no diffuse light at all,
/// night. Values in the unit of the WEA kind, with the extra columns of newer files.
fn varied_days(units: u8) -> String {
    let mut random = Random(u64::from(units));
    let mut text = String::new();
    for month in [1, 2, 4, 6, 9, 12] {
        for step in 0..24 {
            let hour = f64::from(step) + 0.75 * random.next();
            let [direct, diffuse] = match step % 6 {
                0 => [0.0, 350.0 * random.next()],
                1 => [900.0 * random.next(), 200.0 * random.next()],
                2 => [950.0, 20.0 + 100.0 * random.next()],
                3 => [30.0 * random.next(), 30.0 * random.next()],
                4 if step % 4 == 0 => [0.0, 0.0],
                _ => [200.0 * random.next(), 0.0],
            };
            let unit = if units == 3 { 110.0 } else { 1.0 };
            writeln!(text, "{month} {} {hour} {:.3} {:.3} 0.1 0.5", 3 + 2 * month, direct * unit, diffuse * unit).unwrap();
        }
    }
    text
}

/// Bounds on the difference of an entry: of the entry, or of its column's largest.
const OF_ENTRY: f32 = 1e-4;
const OF_LARGEST: f32 = 1e-6;

/// The largest difference, as a share of what is allowed.
fn assert_agrees(ours: &Matrix<f32>, theirs: &Matrix<f32>, what: &str) -> f32 {
    assert_eq!((ours.rows(), ours.cols(), ours.components()), (theirs.rows(), theirs.cols(), theirs.components()), "{what}");
    let mut largest = vec![0f32; theirs.cols()];
    for (i, v) in theirs.data().iter().enumerate() {
        let column = i / 3 % theirs.cols();
        largest[column] = largest[column].max(v.abs());
    }
    let mut worst = 0.0f32;
    for (i, (a, b)) in ours.data().iter().zip(theirs.data()).enumerate() {
        let column = i / 3 % theirs.cols();
        let allowed = (OF_ENTRY * b.abs()).max(OF_LARGEST * largest[column]);
        assert!((a - b).abs() <= allowed, "{what}: row {}, column {column}: {a} against {b}", i / 3 / theirs.cols());
        worst = worst.max((a - b).abs() / allowed.max(f32::MIN_POSITIVE));
    }
    worst
}

/// Runs gendaymtx on a file and compares; gives the largest difference as a share of what is allowed.
fn compare_with_gendaymtx(path: &Path, arguments: &str, options: &SkyOptions) -> Option<f32> {
    let mut command = testing::radiance("gendaymtx")?;
    let bytes = testing::output(command.arg("-of").args(arguments.split_whitespace()).arg(path));
    let theirs = read_matrix_from::<f32>(bytes.as_slice()).unwrap().matrix;
    let weather = Weather::read(path, &mut Warnings::new()).unwrap();
    Some(assert_agrees(&matrix(&weather, options), &theirs, &format!("gendaymtx {arguments} {}", path.display())))
}

fn with_file(name: &str, contents: &str, test: impl FnOnce(&Path)) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, contents).unwrap();
    test(&path);
}

fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs()
}

#[test]
fn ground_and_patches_are_those_of_gendaymtx() {
    let s = matrix(&weather(NEW_YORK), &SkyOptions::default());
    assert_eq!((s.rows(), s.cols(), s.components()), (146, 7, 3));
    // gendaymtx -m 1 -of, row 0, printed with four decimals.
    let ground = [17.3602, 28.3441, 36.7033, 4.9487, 8.7399, 0.0, 12.7747];
    for (column, expected) in ground.into_iter().enumerate() {
        for v in s.at(0, column) {
            assert!((f64::from(*v) - expected).abs() < 6e-5, "column {column}: {v}");
        }
    }
    // Row 1 of column 3 with its colour.
    let sky: Vec<f64> = s.at(1, 3).iter().map(|v| f64::from(*v)).collect();
    assert!((sky[0] - 17.505).abs() < 6e-4 && (sky[1] - 18.3073).abs() < 6e-5, "{sky:?}");
}

#[test]
fn the_sun_alone_is_in_the_patches_of_gendaymtx() {
    let w = weather(NEW_YORK);
    // gendaymtx -m 1 -of -d: (row, radiance) of all non-zero entries per column.
    let four: [&[(usize, f64)]; 7] = [
        &[(69, 979.1823), (70, 1680.8666), (93, 1275.5748), (94, 2127.5149)],
        &[(96, 1483.6107), (97, 3735.3503), (117, 1218.6696), (118, 5245.479)],
        &[(132, 1223.9609), (133, 3779.5439), (134, 1460.9741), (142, 5118.7822)],
        &[],
        &[(46, 291.498), (47, 135.3516), (73, 577.6672), (74, 115.5797)],
        &[],
        &[(51, 804.0478), (52, 716.8955), (77, 1163.3971), (78, 631.3343)],
    ];
    // gendaymtx -m 4 -of -5 0.533 -d.
    let one: [&[(usize, f64)]; 7] =
        [&[(1284, 3891528.5)], &[(1681, 7202603.5)], &[(2185, 7662576.5)], &[], &[(1009, 744971.625)], &[], &[(923, 2183440.75)]];
    let sun_only = SkyOptions { sky: false, ..SkyOptions::default() };
    for (options, expected) in [(sun_only.clone(), four), (SkyOptions { subdivision: 4, sun_disc: Some(0.533), ..sun_only }, one)] {
        let s = matrix(&w, &options);
        for (column, list) in expected.into_iter().enumerate() {
            let found: Vec<usize> = (0..s.rows()).filter(|r| s.at(*r, column)[0] != 0.0).collect();
            assert_eq!(found, list.iter().map(|(r, _)| *r).collect::<Vec<_>>(), "column {column}");
            for (row, value) in list {
                assert!(relative(f64::from(s.at(*row, column)[0]), *value) < 1e-6, "row {row}, column {column}");
            }
        }
    }
}

#[test]
fn the_dew_point_of_an_epw_file_counts() {
    let line = |hour: u8, dew: &str, direct: u32, diffuse: u32| {
        format!(
            "1999,3,21,{hour},60,A7A7,10.0,{dew},70,101300,1200,1300,320,700,{direct},{diffuse},70000,85000,12000,2000,180,3.0,3,3,20.0,77777,9,999999999,120,0.1,0,88,0.2,0.0,1.0\n"
        )
    };
    let epw = format!(
        "LOCATION,New York,NY,USA,TMY3,725033,40.78,-73.97,-5.0,57.0\nDATA PERIODS,1,1,Data,Sunday, 3/21, 3/21\n{}{}",
        line(12, "5.0", 850, 100),
        line(13, "7.0", 800, 120)
    );
    let wea = format!("{}3 21 11.5 850 100\n3 21 12.5 800 120\n", header(40.78, 73.97, 75.0, 1));
    // Rows 0 and 100 of gendaymtx -m 1 -of for both files.
    for (text, ground, sky) in [
        (&epw, [27.84578, 27.50419], [[20.22034, 21.1471, 23.54827], [45.86353, 47.96561, 53.41191]]),
        (&wea, [28.09874, 27.65704], [[20.25569, 21.18407, 23.58944], [46.26684, 48.3874, 53.88159]]),
    ] {
        let s = matrix(&weather(text), &SkyOptions::default());
        for column in 0..2 {
            assert!(relative(f64::from(s.at(0, column)[0]), ground[column]) < 1e-6);
            for (v, expected) in s.at(100, column).iter().zip(sky[column]) {
                assert!(relative(f64::from(*v), expected) < 1e-6);
            }
        }
    }
    // The mean runs over three records and starts anew after a gap.
    let mut dew = DewPoints::default();
    let at = |dew_point| Record { month: 1, day: 1, hour: 0.0, day_of_year: 1, direct: 0.0, diffuse: 0.0, dew_point, line: 1 };
    let means: Vec<f64> =
        [None, Some(3.0), Some(6.0), Some(9.0), None, Some(0.0), Some(3.0)].into_iter().map(|d| dew.mean(&at(d))).collect();
    assert_eq!(means, [11.0, 3.0, 4.0, 6.0, 6.0, 0.0, 1.0]);
}

#[test]
fn every_option_agrees_with_gendaymtx() {
    let base = SkyOptions::default;
    let cases = [
        ("-m 1", base()),
        ("-m 2", SkyOptions { subdivision: 2, ..base() }),
        ("-m 3 -r 17.5", SkyOptions { subdivision: 3, rotation: 17.5, ..base() }),
        ("-m 4 -s", SkyOptions { subdivision: 4, sun: false, ..base() }),
        ("-m 5 -rz -200", SkyOptions { subdivision: 5, rotation: -200.0, ..base() }),
        ("-m 6", SkyOptions { subdivision: 6, ..base() }),
        ("-d", SkyOptions { sky: false, ..base() }),
        ("-d -m 6", SkyOptions { sky: false, subdivision: 6, ..base() }),
        ("-d -5 .533 -m 6", SkyOptions { sky: false, sun_disc: Some(0.533), subdivision: 6, ..base() }),
        ("-5 .533 -m 2", SkyOptions { sun_disc: Some(0.533), subdivision: 2, ..base() }),
        ("-5 5 -m 4 -d", SkyOptions { sky: false, sun_disc: Some(5.0), subdivision: 4, ..base() }),
        ("-O1", SkyOptions { solar_spectrum: true, ..base() }),
        ("-O1 -d -m 4", SkyOptions { solar_spectrum: true, sky: false, subdivision: 4, ..base() }),
        ("-O1 -s -c 1 1 1", SkyOptions { solar_spectrum: true, sun: false, sky_color: [1.0; 3], ..base() }),
        ("-O0 -g .1 .3 .6", SkyOptions { ground_reflectance: [0.1, 0.3, 0.6], ..base() }),
        ("-c 1.2 1 .4 -g 0 0 0", SkyOptions { sky_color: [1.2, 1.0, 0.4], ground_reflectance: [0.0; 3], ..base() }),
        ("-c 0 0 0", SkyOptions { sky_color: [0.0; 3], ..base() }),
        ("-u", SkyOptions { sun_hours_only: true, ..base() }),
        ("-u -m 2 -r 90 -O1", SkyOptions { sun_hours_only: true, subdivision: 2, rotation: 90.0, solar_spectrum: true, ..base() }),
        ("-A -m 2", SkyOptions { average: true, subdivision: 2, ..base() }),
        ("-A -u -s", SkyOptions { average: true, sun_hours_only: true, sun: false, ..base() }),
        ("-i 30", SkyOptions { interval_minutes: 30.0, ..base() }),
        ("-i 60 -u -m 2", SkyOptions { interval_minutes: 60.0, sun_hours_only: true, subdivision: 2, ..base() }),
    ];
    let mut all = Vec::new();
    for units in 1..=3 {
        // North and west, south and east, the equator, beyond both polar circles.
        let sites = [(40.78, 73.97, 75.0), (-33.9, -151.2, -150.0), (0.0, 10.0, 0.0), (78.2, -15.6, -15.0), (-90.0, 0.0, 0.0)];
        for (site, (latitude, west, meridian)) in sites.into_iter().enumerate() {
            with_file("year.wea", &(header(latitude, west, meridian, units) + &varied_days(units)), |path| {
                for (index, (arguments, options)) in cases.iter().enumerate() {
                    // All options at the first site, a third of them at each other one.
                    if site == 0 || (index + site) % 3 == 0 {
                        let Some(worst) = compare_with_gendaymtx(path, arguments, options) else { return };
                        all.push(worst);
                    }
                }
            });
        }
    }
    if !all.is_empty() {
        let worst = testing::percent(all.iter().copied().fold(0.0, f32::max).into());
        let held = [OF_ENTRY, OF_LARGEST].map(|bound| testing::short(bound.into()));
        let held = format!("each entry {}, or {} of its hour's largest", held[0], held[1]);
        testing::measured("sky-matrix", &format!("{} skies: at most {worst} of the bound", all.len()), &held);
    }
}

#[test]
fn leap_years_and_finer_steps_agree_with_gendaymtx() {
    let mut text = header(52.5, -13.4, -15.0, 1);
    for (month, day) in [(2, 28), (2, 29), (3, 1), (12, 31)] {
        for step in 0..96 {
            writeln!(text, "{month} {day} {:.3} {} {}", f64::from(step) * 0.25, step * 4, 10 + step).unwrap();
        }
    }
    with_file("leap.wea", &text, |path| {
        compare_with_gendaymtx(path, "-m 2", &SkyOptions { subdivision: 2, ..SkyOptions::default() });
        compare_with_gendaymtx(path, "-m 1 -d -u", &SkyOptions { sky: false, sun_hours_only: true, ..SkyOptions::default() });
    });
}

#[test]
fn the_reference_year_agrees_with_gendaymtx() {
    let Some(folder) = testing::shared() else { return };
    let folder = folder.join("data/tutorial_room/weather");
    const EPW: &str = "USA_NY_New.York.City-Central.Park.94728_TMY_3.epw";
    for name in ["NYC.wea", EPW] {
        // MF:4 of a year is 240 MB: once is enough.
        for subdivision in if name == "NYC.wea" { vec![1, 4] } else { vec![2] } {
            let options = SkyOptions { subdivision, ..SkyOptions::default() };
            compare_with_gendaymtx(&folder.join(name), &format!("-m {subdivision}"), &options);
        }
    }
    // Small enough even for MF:6.
    let options = SkyOptions { subdivision: 6, average: true, sun_hours_only: true, ..SkyOptions::default() };
    compare_with_gendaymtx(&folder.join(EPW), "-m 6 -A -u", &options);
}

/// The input comes back: patches integrate to the diffuse irradiance, the sun's patches to the
/// direct normal one, and the ground shows both.
#[test]
fn irradiance_of_the_patches_is_that_of_the_weather() {
    let w = weather(&(header(40.78, 73.97, 75.0, 1) + &varied_days(1)));
    for subdivision in [1, 2, 6] {
        let sky = ReinhartSky::new(subdivision).unwrap();
        let options =
            SkyOptions { subdivision, sky_color: [1.0; 3], solar_spectrum: true, ground_reflectance: [1.0; 3], ..SkyOptions::default() };
        let diffuse = matrix(&w, &SkyOptions { sun: false, ..options.clone() });
        let direct = matrix(&w, &SkyOptions { sky: false, ..options.clone() });
        for (column, record) in w.records.iter().enumerate() {
            let integral = |m: &Matrix<f32>, weight: &dyn Fn(usize) -> f64| -> f64 {
                (1..sky.len()).map(|p| f64::from(m.at(p, column)[1]) * weight(p)).sum()
            };
            // gendaymtx's own quadrature: patch centre × solid angle.
            let horizontal = integral(&diffuse, &|p| sky.centre(p).z * sky.solid_angle(p));
            let normal = integral(&direct, &|p| sky.solid_angle(p));
            let ground = f64::from(diffuse.at(0, column)[1]) * PI;
            let altitude = w.sun(record).altitude;
            assert!((horizontal - record.diffuse).abs() <= 1e-6 * record.diffuse, "{horizontal} {record:?}");
            assert!((normal - record.direct).abs() <= 1e-6 * record.direct, "{normal} {record:?}");
            assert!((ground - record.diffuse - record.direct * altitude.sin().max(0.0)).abs() <= 1e-6 * ground, "{ground} {record:?}");
            // Exactly projected patches differ from the quadrature by their extent alone.
            let exact = integral(&diffuse, &|p| {
                let ([low, high], [from, to]) = sky.limits(p);
                (high.sin().powi(2) - low.sin().powi(2)) / 2.0 * (to - from)
            });
            let bound = (1.0 - sky.row_height().cos()) + 1e-6;
            assert!((exact / record.diffuse - 1.0).abs() < bound || record.diffuse == 0.0, "MF:{subdivision} {exact} {record:?}");
        }
    }
}

/// 60° take every patch of every row to another one: the rotated matrix is the same, renumbered.
#[test]
fn rotation_turns_the_sky_counter_clockwise() {
    let w = weather(NEW_YORK);
    let options = SkyOptions { subdivision: 2, ..SkyOptions::default() };
    let plain = matrix(&w, &options);
    let turned = matrix(&w, &SkyOptions { rotation: 60.0, ..options });
    for (first, patches) in ReinhartSky::new(2).unwrap().rows() {
        for patch in 0..patches {
            let from = first + (patch + patches / 6) % patches;
            for column in 0..plain.cols() {
                let (a, b) = (turned.at(first + patch, column)[0], plain.at(from, column)[0]);
                assert!((a - b).abs() <= 1e-5 * b, "patch {} column {column}: {a} {b}", first + patch);
            }
        }
    }
}

#[test]
fn sky_and_sun_add_up_and_the_brightest_patch_faces_the_sun() {
    let w = weather(NEW_YORK);
    let all = matrix(&w, &SkyOptions::default());
    let sky = matrix(&w, &SkyOptions { sun: false, ..SkyOptions::default() });
    let sun = matrix(&w, &SkyOptions { sky: false, ..SkyOptions::default() });
    for ((a, b), c) in all.data().iter().zip(sky.data()).zip(sun.data()) {
        assert!((a - b - c).abs() <= 1e-6 * a);
    }
    let bins = ReinhartSky::new(1).unwrap();
    for column in [0, 1, 4, 6] {
        let brightest = (1..146).max_by(|a, b| sun.at(*a, column)[0].total_cmp(&sun.at(*b, column)[0])).unwrap();
        let angle = bins.centre(brightest).dot(w.sun(&w.records[column]).direction()).acos().to_degrees();
        assert!(angle < 9.0, "column {column}: {angle}°");
    }
}

#[test]
fn black_columns_are_known_beforehand() {
    let w = weather(&(header(60.0, 0.0, 0.0, 1) + &varied_days(1)));
    let base = SkyOptions::default;
    for options in [
        base(),
        SkyOptions { sky: false, ..base() },
        SkyOptions { sun: false, ground_reflectance: [0.0; 3], ..base() },
        SkyOptions { sky_color: [0.0; 3], sun: false, ..base() },
        SkyOptions { sky: false, sun: false, ..base() },
        SkyOptions { sun_hours_only: true, ..base() },
    ] {
        let s = matrix(&w, &options);
        let columns = sky_columns(&w, &options).unwrap();
        assert_eq!(columns.len(), s.cols());
        for (index, column) in columns.iter().enumerate() {
            let black = (0..s.rows()).all(|row| s.at(row, index).iter().all(|v| *v == 0.0));
            assert_eq!(column.black, black, "column {index} of {options:?}");
            assert!(!options.sun_hours_only || column.sun.is_up());
        }
    }
    let up = sky_columns(&w, &SkyOptions { sun_hours_only: true, ..base() }).unwrap();
    assert!(up.len() < w.records.len() && up.iter().all(|c| w.sun(&w.records[c.record]).is_up()));
}

#[test]
fn the_average_is_the_mean_of_all_columns() {
    let w = weather(NEW_YORK);
    let s = matrix(&w, &SkyOptions::default());
    let mean = matrix(&w, &SkyOptions { average: true, ..SkyOptions::default() });
    assert_eq!((mean.rows(), mean.cols()), (146, 1));
    for row in 0..146 {
        for k in 0..3 {
            let expected: f64 = (0..7).map(|c| f64::from(s.at(row, c)[k])).sum::<f64>() / 7.0;
            assert!(relative(f64::from(mean.at(row, 0)[k]), expected) < 1e-6);
        }
    }
}

#[test]
fn polar_night_and_midnight_sun() {
    let hours = |month: u8| (0..24).map(|h| format!("{month} 21 {h}.5 100 50\n")).collect::<String>();
    let only_sun = SkyOptions { sun_hours_only: true, ..SkyOptions::default() };
    let summer = weather(&(header(78.2, -15.6, -15.0, 1) + &hours(6)));
    assert_eq!(matrix(&summer, &only_sun).cols(), 24);
    // At midnight the sun stands in the north, above the horizon.
    let midnight = matrix(&summer, &SkyOptions { sky: false, ..SkyOptions::default() });
    let bins = ReinhartSky::new(1).unwrap();
    let lit: Vec<usize> = (0..146).filter(|p| midnight.at(*p, 0)[0] > 0.0).collect();
    assert!(lit.len() == 4 && lit.iter().all(|p| bins.centre(*p).y > 0.7), "{lit:?}");
    let winter = weather(&(header(78.2, -15.6, -15.0, 1) + &hours(12)));
    assert!(sky_matrix(&winter, &only_sun, &Silent).unwrap_err().to_string().contains("the sun is below the horizon in every time step"));
    assert_eq!(matrix(&winter, &SkyOptions::default()).cols(), 24);
}

#[test]
fn any_weather_gives_finite_radiance() {
    let mut random = Random(7);
    let w = |units: u8, random: &mut Random| {
        let mut text = header(180.0 * random.next() - 90.0, 0.0, 0.0, units);
        for _ in 0..300 {
            let value = |random: &mut Random| match (random.next() * 4.0) as u32 {
                0 => 0.0,
                1 => 1e-5 * random.next(),
                2 => 1500.0,
                _ => 1400.0 * random.next(),
            };
            let (direct, diffuse) = (value(random), value(random));
            writeln!(
                text,
                "{} {} {} {direct} {diffuse}",
                1 + (random.next() * 12.0) as u8,
                1 + (random.next() * 28.0) as u8,
                random.next() * 24.0
            )
            .unwrap();
        }
        weather(&text)
    };
    for units in [1, 2, 3, 1, 2, 3] {
        let w = w(units, &mut random);
        for solar_spectrum in [false, true] {
            let s = matrix(&w, &SkyOptions { solar_spectrum, ..SkyOptions::default() });
            assert!(s.data().iter().all(|v| v.is_finite() && *v >= 0.0));
        }
    }
}

#[test]
fn options_out_of_range_are_refused_and_work_can_be_stopped() {
    let w = weather(NEW_YORK);
    let base = SkyOptions::default;
    for (options, expected) in [
        (SkyOptions { subdivision: 7, ..base() }, "MF:7"),
        (SkyOptions { subdivision: 0, ..base() }, "MF:0"),
        (SkyOptions { sun_disc: Some(0.0), ..base() }, "-5"),
        (SkyOptions { sun_disc: Some(f64::NAN), ..base() }, "-5"),
        (SkyOptions { sky_color: [1.0, -1.0, 1.0], ..base() }, "-c"),
        (SkyOptions { ground_reflectance: [f64::NAN; 3], ..base() }, "-g"),
        (SkyOptions { rotation: f64::INFINITY, ..base() }, "-r"),
        (SkyOptions { interval_minutes: -1.0, ..base() }, "-i"),
    ] {
        let error = sky_matrix(&w, &options, &Silent).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let empty = Weather { records: Vec::new(), ..w.clone() };
    assert!(sky_matrix(&empty, &base(), &Silent).unwrap_err().to_string().contains("no time steps"));

    struct Stop;
    impl Progress for Stop {
        fn update(&self, _: &str, _: f64) {}
        fn stop_requested(&self) -> bool {
            true
        }
    }
    assert_eq!(sky_matrix(&w, &base(), &Stop).unwrap_err(), cancelled());
}

#[test]
fn the_suns_of_the_hours_are_the_entries_of_the_sun_matrix() {
    let records: String = (0..24).map(|h| format!("3 21 {h}.5 {} 80\n", if h == 9 { 0 } else { 600 })).collect();
    let text = format!("place Test\nlatitude 40.8\nlongitude 74\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n{records}");
    let weather = Weather::from_bytes(text.as_bytes(), &mut crate::error::Warnings::new()).unwrap();
    for subdivision in [1, 4] {
        let options = SkyOptions { subdivision, sky: false, sun_disc: Some(0.533), ..SkyOptions::default() };
        let matrix = sky_matrix(&weather, &options, &crate::progress::Silent).unwrap();
        let suns = sun_hours(&weather, &options).unwrap();
        assert_eq!(suns.len(), matrix.cols());
        assert!(suns[12].is_some() && suns[9].is_none(), "{:?}", suns[9]);
        for (column, sun) in suns.iter().enumerate() {
            for patch in 0..matrix.rows() {
                let wanted = sun.filter(|s| s.patch == patch).map_or(0.0, |s| s.radiance as f32);
                assert_eq!(matrix.at(patch, column), [wanted; 3], "patch {patch}, hour {column}");
            }
        }
    }
}

#[test]
fn the_scene_s_north_turns_sky_and_suns_as_gendaymtx_does() {
    let text = "place x\nlatitude 40\nlongitude 74\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n6 21 9.5 600 150\n6 21 15.5 500 200\n";
    let straight = weather(text);
    let turned = Weather { north: 25.0, ..straight.clone() };
    let options = SkyOptions::default();
    let by_option = sky_matrix(&straight, &SkyOptions { rotation: 25.0, ..options.clone() }, &Silent).unwrap();
    let by_north = sky_matrix(&turned, &options, &Silent).unwrap();
    assert_eq!(by_north.data(), by_option.data());
    assert_ne!(by_north.data(), sky_matrix(&straight, &options, &Silent).unwrap().data());
    let (before, after) = (sun_hours(&straight, &options).unwrap(), sun_hours(&turned, &options).unwrap());
    for (a, b) in before.iter().zip(&after) {
        // North lies 25° counter-clockwise of +Y, so that a sun over the east stands 25° nearer to it.
        let turn = a.unwrap().position.azimuth - b.unwrap().position.azimuth;
        assert!((turn.to_degrees() - 25.0).abs() < 1e-9);
    }
}

#[test]
fn the_sky_of_a_chosen_hour_is_that_of_the_year() {
    let records: String = (0..48).map(|h| format!("6 {} {}.500 400 {}\n", 21 + h / 24, h % 24, 100 + h)).collect();
    let header = "place x\nlatitude 47\nlongitude -11\ntime_zone -15\nsite_elevation 0\nweather_data_file_units 1\n";
    let mut all = weather(&format!("{header}{records}"));
    // The mean dew point of an hour is that of three.
    all.records.iter_mut().enumerate().for_each(|(i, r)| r.dew_point = Some((7 * i % 20) as f64));
    let options = SkyOptions { solar_spectrum: false, ..SkyOptions::default() };
    let year = matrix(&all, &options);
    let mut some = all.clone();
    some.keep_hours(&[171 * 24 + 10, 172 * 24 + 15]).unwrap();
    let chosen = matrix(&some, &options);
    for (column, own) in [(10, 0), (39, 1)] {
        for patch in 0..year.rows() {
            assert_eq!(year.at(patch, column), chosen.at(patch, own), "{patch}");
        }
    }
    let mut without = all.clone();
    without.records = [all.records[10], all.records[39]].to_vec();
    assert_ne!(matrix(&without, &options).data(), chosen.data(), "dew points tell");
    // Halves of an hour have their own suns, and the hour's light.
    let halves = all.clone().with_step(30, &mut Warnings::new()).unwrap();
    let suns = sun_hours(&halves, &options).unwrap();
    for (half, sun) in halves.records.iter().zip(&suns) {
        let up = halves.sun(half).altitude > 0.0;
        assert_eq!(sun.is_some_and(|s| (s.position.altitude - halves.sun(half).altitude).abs() < 1e-12), up, "{half:?}");
    }
}
