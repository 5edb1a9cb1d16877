//! Readers of weather files: what they accept, and what they say of what they refuse.

use super::*;

const WEA_HEADER: &str =
    "place Testville_XYZ\nlatitude 40.78\nlongitude 73.97\ntime_zone 75.0\nsite_elevation 57.0\nweather_data_file_units 1\n";

fn wea(records: &str) -> String {
    format!("{WEA_HEADER}{records}")
}

/// One EPW line with dew point, direct normal and diffuse horizontal irradiance.
fn epw_line(month: u8, day: u8, hour: u8, minute: u8, dew: &str, direct: &str, diffuse: &str) -> String {
    format!(
        "1999,{month},{day},{hour},{minute},A7A7,10.0,{dew},70,101300,1200,1300,320,700,{direct},{diffuse},70000,85000,12000,2000,180,3.0,3,3,20.0,77777,9,999999999,120,0.1,0,88,0.2,0.0,1.0\n"
    )
}

fn epw(period: &str, records: &str) -> String {
    format!(
        "LOCATION,New York,NY,USA,TMY3,725033,40.78,-73.97,-5.0,57.0\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\nGROUND TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,x\nCOMMENTS 2,y\nDATA PERIODS,1,{period}\n{records}"
    )
}

fn hourly_epw(period: &str, days: &[(u8, u8)]) -> String {
    let lines: String = days.iter().flat_map(|&(m, d)| (1..=24).map(move |h| epw_line(m, d, h, 60, "5.0", "0", "0"))).collect();
    epw(&format!("1,Data,Sunday,{period}"), &lines)
}

/// A full year of hours, as WEA records.
fn year(leap: bool) -> Vec<String> {
    let mut lines = Vec::new();
    for month in 1..=12 {
        for day in 1..=days_in(month) {
            if leap || (month, day) != (2, 29) {
                lines.extend((0..24).map(|h| format!("{month} {day} {h}.500 0 0\n")));
            }
        }
    }
    lines
}

fn read(text: &str) -> Weather {
    Weather::from_bytes(text.as_bytes(), &mut Warnings::new()).unwrap()
}

fn refusal(text: &str) -> String {
    Weather::from_bytes(text.as_bytes(), &mut Warnings::new()).unwrap_err().to_string()
}

fn warning(text: &str) -> String {
    let mut warnings = Warnings::new();
    Weather::from_bytes(text.as_bytes(), &mut warnings).unwrap();
    warnings.iter().map(ToString::to_string).collect()
}

#[test]
fn wea_header_signs_become_east_positive() {
    let w = read(&wea("3 21 9.5 500 150\n"));
    assert_eq!((w.place.as_str(), w.latitude, w.longitude, w.time_zone, w.elevation), ("Testville_XYZ", 40.78, -73.97, -5.0, 57.0));
    let r = w.records[0];
    assert_eq!((r.month, r.day, r.hour, r.day_of_year, r.direct, r.diffuse, r.dew_point, r.line), (3, 21, 9.5, 80, 500.0, 150.0, None, 7));
}

#[test]
fn epw_and_wea_of_the_same_hour_agree() {
    let e = read(&epw("1,Data,Sunday, 3/21, 3/21", &epw_line(3, 21, 12, 60, "5.0", "850", "100")));
    let w = read(&wea("3 21 11.5 850 100\n"));
    assert_eq!((e.latitude, e.longitude, e.time_zone, e.quantity), (w.latitude, w.longitude, w.time_zone, w.quantity));
    assert_eq!(e.place, "New York_USA");
    let (a, b) = (e.records[0], w.records[0]);
    assert_eq!((a.hour, a.day_of_year, a.direct, a.diffuse), (b.hour, b.day_of_year, b.direct, b.diffuse));
    assert_eq!((a.dew_point, a.line), (Some(5.0), 9));
}

#[test]
fn the_three_kinds_of_wea_data_are_told_apart() {
    for (units, quantity) in [(1, Quantity::NormalIrradiance), (2, Quantity::HorizontalIrradiance), (3, Quantity::Illuminance)] {
        assert_eq!(read(&wea("3 21 9.5 50 15\n").replace("units 1", &format!("units {units}"))).quantity, quantity);
    }
    assert!(read(&wea("3 21 9.5 90000 15000\n").replace("units 1", "units 3")).records[0].direct == 90000.0);
    assert!(refusal(&wea("3 21 9.5 90000 15000\n")).contains("direct normal irradiance: 90000 is impossible"));
    assert!(refusal(&wea("3 21 9.5 5 1\n").replace("units 1", "units 4")).contains("weather_data_file_units: 4 is impossible"));
    assert!(refusal(&wea("3 21 9.5 5 1\n").replace("units 1", "units 1.5")).contains("none of the known kinds"));
}

#[test]
fn extra_columns_blank_lines_and_line_ends_are_tolerated() {
    let text = wea("3 21 9.5 500 150 0.1 0.3\n\n  3 21\t10.5 510 140\n").replace('\n', "\r\n");
    let w = read(&text);
    assert_eq!(w.records.len(), 2);
    assert_eq!(w.records[1].line, 9);
    assert_eq!(read(&format!("\u{feff}{text}")).records.len(), 2);
    let latin1: Vec<u8> = [b"place Z\xfcrich_CHE\n", &text.as_bytes()[text.find("latitude").unwrap()..]].concat();
    assert_eq!(Weather::from_bytes(&latin1, &mut Warnings::new()).unwrap().records.len(), 2);
    assert_eq!(read(&text.replace("Testville_XYZ", "Nowhere")).place, "Nowhere");
}

#[test]
fn time_steps_finer_than_an_hour_keep_their_instant() {
    let lines: String =
        (1..=24).flat_map(|h| [15, 30, 45, 60].map(|m| epw_line(6, 21, h, m, "5.0", "0", "0"))).collect::<Vec<_>>().concat();
    let w = read(&epw("4,Data,Sunday,6/21,6/21", &lines));
    assert_eq!(w.records.len(), 96);
    assert_eq!((w.records[0].hour, w.records[1].hour, w.records[95].hour), (0.25, 0.5, 24.0));
    let w = read(&wea("6 21 12.083 100 100\n6 21 12.167 100 100\n"));
    assert_eq!(w.records[1].hour, 12.167);
}

#[test]
fn a_leap_day_moves_the_days_after_it() {
    let w = read(&wea("2 28 12 0 0\n2 29 12 0 0\n3 1 12 0 0\n12 31 12 0 0\n"));
    assert_eq!(w.records.iter().map(|r| r.day_of_year).collect::<Vec<_>>(), [59, 60, 61, 366]);
    let common = read(&wea("2 28 12 0 0\n3 1 12 0 0\n12 31 12 0 0\n"));
    assert_eq!(common.records.iter().map(|r| r.day_of_year).collect::<Vec<_>>(), [59, 60, 365]);
    assert_eq!(read(&wea(&year(true).concat())).records.len(), 8784);
    let days = [(2, 27), (2, 28), (2, 29), (3, 1)];
    assert_eq!(read(&hourly_epw("2/27, 3/ 1", &days)).records.len(), 96);
    assert_eq!(read(&hourly_epw("2/27,2/28", &days[..3])).records.len(), 72);
    assert_eq!(read(&hourly_epw("12/31/2019,1/1/2020", &[(12, 31), (1, 1)])).records.len(), 48);
}

#[test]
fn a_missing_hour_is_named_with_its_line() {
    let mut lines = year(false);
    assert_eq!(lines.len(), 8760);
    assert!(warning(&wea(&lines.concat())).is_empty());
    lines.remove(1000);
    let error = refusal(&wea(&lines.concat()));
    assert!(error.starts_with("line 1007: time steps are missing: 2/11 15.50 h is followed by 2/11 17.50 h"), "{error}");

    let mut lines = year(false);
    lines.insert(1000, lines[999].clone());
    assert!(refusal(&wea(&lines.concat())).contains("line 1007: the series repeats or goes back in time"));

    let cut = year(false)[..5000].concat();
    assert!(warning(&wea(&cut)).contains("begins with the year but ends on 7/28 7.50 h"));
    // A choice of hours is nobody's mistake.
    let chosen: String = year(false).into_iter().filter(|l| l.split(' ').nth(2) == Some("12.500")).collect();
    assert!(warning(&wea(&chosen)).is_empty());

    let day = hourly_epw("6/21,6/22", &[(6, 21), (6, 22)]);
    assert_eq!(read(&day).records.len(), 48);
    let without = |line: usize| day.lines().enumerate().filter(|(i, _)| i + 1 != line).map(|(_, l)| format!("{l}\n")).collect::<String>();
    assert!(refusal(&without(20)).starts_with("line 20: time steps are missing: 6/21 10.50 h is followed by 6/21 12.50 h"));
    assert!(refusal(&without(9)).starts_with("line 9: time steps are missing: the records begin on 6/21 1.50 h"));
    assert!(refusal(&without(56)).starts_with("line 55: time steps are missing: the records end on 6/22 22.50 h"));
    assert!(refusal(&hourly_epw("6/21,6/24", &[(6, 21), (6, 22)])).contains("DATA PERIODS says 6/24"));
    assert!(warning(&day.replace("DATA PERIODS,1,", "DATA PERIODS,2,")).contains("several data periods"));
    assert!(warning(&day.replace("6/21,6/22", "summer,?")).contains("first and last date are not readable"));
}

#[test]
fn impossible_values_are_refused_with_line_and_field() {
    for (record, expected) in [
        ("13 1 12 0 0", "month: 13 is impossible"),
        ("0 1 12 0 0", "month: 0 is impossible"),
        ("2 30 12 0 0", "day: 30 is impossible"),
        ("4 31 12 0 0", "day: 31 is impossible"),
        ("1 1.5 12 0 0", "day: 1.5 is not a whole number"),
        ("1 1 24.5 0 0", "hour: 24.5 is impossible"),
        ("1 1 -1 0 0", "hour: -1 is impossible"),
        ("1 1 12 -5 0", "direct normal irradiance: -5 is impossible"),
        ("1 1 12 0 -0.1", "diffuse horizontal irradiance: -0.1 is impossible"),
        ("1 1 12 1501 0", "direct normal irradiance: 1501 is impossible"),
        ("1 1 12 0 9999", "diffuse horizontal irradiance: 9999 is impossible"),
        ("1 1 12 nan 0", "direct normal irradiance: 'nan' is not a number"),
        ("1 1 12 0 inf", "diffuse horizontal irradiance: 'inf' is not a number"),
        ("1 1 12 0", "a record needs 5 columns, this line has 4"),
        ("latitude 40", "month: 'latitude' is not a number"),
        ("\u{1}\u{7f}x 1 12 0 0", "month: '\\u{1}\\u{7f}x' is not a number"),
    ] {
        let error = refusal(&wea(&format!("1 1 11 0 0\n{record}\n")));
        assert!(error.starts_with("line 8: ") && error.contains(expected), "{record}: {error}");
    }
    let good = epw_line(6, 21, 12, 60, "5.0", "850", "100");
    for (bad, expected) in [
        (epw_line(6, 21, 12, 60, "5.0", "9999", "100"), "direct normal irradiance: the value is missing (9999)"),
        (epw_line(6, 21, 12, 60, "5.0", "850", ""), "diffuse horizontal irradiance: the value is missing (empty)"),
        (epw_line(6, 21, 12, 60, "5.0", "850", "-1"), "diffuse horizontal irradiance: -1 is impossible"),
        (epw_line(6, 21, 12, 60, "500", "850", "1"), "dew point: 500 is impossible"),
        (epw_line(6, 21, 25, 60, "5.0", "850", "1"), "hour: 25 is impossible"),
        (epw_line(6, 21, 0, 60, "5.0", "850", "1"), "hour: 0 is impossible"),
        (epw_line(6, 21, 12, 61, "5.0", "850", "1"), "minute: 61 is impossible"),
        (epw_line(6, 31, 12, 60, "5.0", "850", "1"), "day: 31 is impossible"),
        (good[..60].to_string(), "it is cut short"),
        ("\n1999,6\n".to_string(), "it is cut short"),
    ] {
        let error = refusal(&epw("1,Data,Sunday,6/21,6/21", &format!("{good}{bad}")));
        assert!(error.starts_with("line 1") && error.contains(expected), "{bad}: {error}");
    }
}

#[test]
fn a_missing_dew_point_is_no_error() {
    let lines = [epw_line(6, 21, 12, 60, "99.9", "850", "100"), epw_line(6, 21, 13, 60, "", "850", "100")].concat();
    assert!(read(&epw("1,Data,Sunday,6/21,6/21", &lines)).records.iter().all(|r| r.dew_point.is_none()));
}

#[test]
fn damaged_headers_say_what_they_lack() {
    assert!(refusal("").contains("the file is empty"));
    assert!(refusal(" \n\n").contains("the file is empty"));
    assert!(refusal("\u{0}\u{1}ELF").contains("neither an EPW file"));
    assert!(refusal("hello").contains("neither an EPW file"));
    for key in ["latitude", "longitude", "time_zone", "weather_data_file_units"] {
        let without: String = wea("1 1 1 0 0\n").lines().filter(|l| !l.starts_with(key)).map(|l| format!("{l}\n")).collect();
        assert!(refusal(&without).contains(&format!("the header has no '{key}'")));
        let garbled = wea("1 1 1 0 0\n").replace(&format!("\n{key} "), &format!("\n{key} x"));
        assert!(refusal(&garbled).contains(&format!("{key}: 'x")), "{}", refusal(&garbled));
    }
    assert!(refusal(&wea("1 1 1 0 0\n").replace("latitude 40.78", "latitude 140.78")).contains("line 2: latitude: 140.78 is impossible"));
    assert!(refusal(WEA_HEADER).contains("there is no time step"));
    assert!(refusal(&WEA_HEADER[..40]).contains("the header has no"));
    let complete = epw("1,Data,Sunday,6/21,6/21", "");
    assert!(refusal(&complete).contains("there is no time step"));
    assert!(refusal(&complete[..100]).contains("the file ends inside its header"));
    assert!(refusal(&complete.replace("40.78", "40.78N")).starts_with("line 1: latitude: '40.78N' is not a number"));
    assert!(refusal("LOCATION,a,b,c").starts_with("line 1: LOCATION has 4 fields"));
    assert!(refusal(&complete.replace("DATA PERIODS,1,1", "DATA PERIODS,1,0")).starts_with("line 8: records per hour: 0 is impossible"));
    assert!(refusal("LOCATION,a,b,c,d,e,1,2,3,4\n1999,1,1,1,60,x\n").starts_with("line 2: records begin before"));
}

#[test]
fn wrong_signs_are_suspected() {
    let noon = "6 21 12.0 900 110\n";
    assert!(warning(&wea(noon)).is_empty());
    assert!(warning(&wea(noon).replace("longitude 73.97", "longitude -73.97")).contains("away from the longitude"));
    // Longitude and time zone both wrong: only the sun knows.
    let night = wea("6 21 0.5 900 110\n6 21 1.5 900 110\n");
    let text = warning(&night);
    assert!(text.contains("7: direct sun while the sun is below the horizon (6/21 0.50 h, and 1 more like it)"), "{text}");
    // The date line is not a mistake.
    let kiribati =
        wea(noon).replace("longitude 73.97", "longitude 157.4").replace("time_zone 75.0", "time_zone -210").replace("40.78", "1.9");
    assert!(warning(&kiribati).is_empty(), "{}", warning(&kiribati));
}

#[test]
fn no_damage_makes_the_readers_panic() {
    let originals = [
        wea("3 21 9.5 500 150\n3 21 12.0 850 100\n12 31 24 0 0\n"),
        hourly_epw("6/21,6/22", &[(6, 21), (6, 22)]),
        epw("4,Data,Sunday,1/1,1/1", &epw_line(1, 1, 1, 15, "5", "0", "0")),
    ];
    let mut state = 1u64;
    let mut random = |n: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % n
    };
    let words: [&[u8]; 12] =
        [b"nan", b"-1", b"1e999", b"99999999999999999999", b",", b"\n", b" ", b"\0", b"\xff\xfe", b"place ", b"DATA PERIODS,", b"0x10"];
    for original in &originals {
        for end in 0..original.len().min(900) {
            let _ = Weather::from_bytes(&original.as_bytes()[..end], &mut Warnings::new());
        }
        for _ in 0..3000 {
            let mut bytes = original.as_bytes().to_vec();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                match random(3) {
                    0 => bytes[at] = random(256) as u8,
                    1 => drop(bytes.splice(at..at, words[random(words.len())].iter().copied())),
                    _ => drop(bytes.drain(at..(at + random(40)).min(bytes.len()))),
                }
                if bytes.is_empty() {
                    break;
                }
            }
            if let Ok(w) = Weather::from_bytes(&bytes, &mut Warnings::new()) {
                assert!(!w.records.is_empty() && w.records.iter().all(|r| (1..=366).contains(&r.day_of_year) && r.direct >= 0.0));
                assert!(w.latitude.abs() <= 90.0 && w.longitude.abs() <= 180.0 && w.time_zone.abs() <= 14.0);
            }
        }
    }
}

#[test]
fn errors_of_files_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.wea");
    std::fs::write(&path, wea("1 1 12 -5 0\n")).unwrap();
    let error = Weather::read(&path, &mut Warnings::new()).unwrap_err().to_string();
    assert!(error.contains("bad.wea:7: direct normal irradiance"), "{error}");
    let mut warnings = Warnings::new();
    std::fs::write(&path, wea("6 21 0.5 900 110\n")).unwrap();
    Weather::read(&path, &mut warnings).unwrap();
    assert!(warnings.iter().next().unwrap().to_string().contains("bad.wea:7: direct sun"));
    assert!(Weather::read(&folder.path().join("none.wea"), &mut Warnings::new()).unwrap_err().to_string().contains("none.wea"));
}

#[test]
fn the_reference_year_is_complete() {
    let Some(folder) = crate::testing::shared() else { return };
    let folder = folder.join("data/tutorial_room/weather");
    for name in ["NYC.wea", "USA_NY_New.York.City-Central.Park.94728_TMY_3.epw"] {
        let w = Weather::read(&folder.join(name), &mut Warnings::new()).unwrap();
        assert_eq!(w.records.len(), 8760);
        assert!((w.latitude - 40.78).abs() < 1e-9 && (w.longitude + 73.96).abs() < 1e-9);
    }
}
