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
    assert!(warning(&without(9)).contains("47 time steps, from 6/21 1.50 h to 6/22 23.50 h; its DATA PERIODS promises 48"));
    assert!(warning(&without(56)).contains("47 time steps, from 6/21 0.50 h to 6/22 22.50 h; its DATA PERIODS promises 48"));
    assert!(warning(&hourly_epw("6/21,6/24", &[(6, 21), (6, 22)])).contains("promises 96, from 6/21 to 6/24"));
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
        ("1 1 12 3001 0", "direct normal irradiance: 3001 is impossible: it lies outside 0 … 3000 W/m²"),
        ("1 1 12 0 9998", "diffuse horizontal irradiance: 9998 is impossible"),
        ("1 1 12 0 9999", "diffuse horizontal irradiance: the value is missing (9999)"),
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
fn chosen_hours_of_an_epw_file_are_read_as_those_of_a_wea_file() {
    let hours = || [(3, 21), (6, 21), (9, 21), (12, 21)].into_iter().flat_map(|(m, d)| (8..=17).map(move |h| (m, d, h)));
    let lines = |direct: &str| hours().map(|(m, d, h)| epw_line(m, d, h, 60, "5.0", direct, "100")).collect::<String>();
    let chosen = epw("1,Data,Sunday,1/ 1,12/31", &lines("600"));
    let e = read(&chosen);
    let w = read(&wea(&hours()
        .map(|(m, d, h)| format!("{m} {d} {h}.5 600 100\n").replace(&format!("{h}.5"), &format!("{}.5", h - 1)))
        .collect::<String>()));
    assert_eq!(e.records.len(), 40);
    for (a, b) in e.records.iter().zip(&w.records) {
        assert_eq!((a.day_of_year, a.hour, a.direct, a.diffuse), (b.day_of_year, b.hour, b.direct, b.diffuse));
    }
    let text = warning(&chosen);
    assert!(text.contains("40 time steps, from 3/21 7.50 h to 12/21 16.50 h; its DATA PERIODS promises 8760, from 1/1 to 12/31"), "{text}");
    // A year that lacks a few hours is a loss.
    let days: Vec<(u8, u8)> = (1..=12).flat_map(|m| (1..=days_in(m)).map(move |d| (m, d))).filter(|d| *d != (2, 29)).collect();
    let year = hourly_epw("1/1,12/31", &days);
    assert_eq!(read(&year).records.len(), 8760);
    let lost: String = year.lines().enumerate().filter(|(i, _)| *i != 4000).map(|(_, l)| format!("{l}\n")).collect();
    assert!(refusal(&lost).starts_with("line 4001: time steps are missing"));
    // Every other day: nobody loses half a year.
    let half: Vec<(u8, u8)> = days.iter().copied().step_by(2).collect();
    assert!(warning(&hourly_epw("1/1,12/31", &half[1..])).contains("4368 time steps"));
}

#[test]
fn radiation_that_was_not_measured_at_night_is_none() {
    // 21 June at 40.78° N: the sun rises at 4:27 and sets at 19:33, so 4.5 h and 19.5 h are day.
    let day = |at_night: [&str; 2], at_noon: [&str; 2]| {
        let line = |h: u8| {
            let [direct, diffuse] = match h {
                5..=20 if h != 12 => ["600", "120"],
                12 => at_noon,
                _ => at_night,
            };
            epw_line(6, 21, h, 60, "5.0", direct, diffuse)
        };
        epw("1,Data,Sunday,6/21,6/21", &(1..=24).map(line).collect::<String>())
    };
    let plain = read(&day(["0", "0"], ["600", "120"]));
    assert_eq!(warning(&day(["0", "0"], ["600", "120"])), "");
    for at_night in [["-999", "-999"], ["9999", "9999"], ["", ""], ["-0.4", "0"], ["0", "-1.5"], ["-9999", "999999"]] {
        let text = day(at_night, ["600", "120"]);
        assert_eq!(read(&text).records, plain.records, "{at_night:?}");
        let warned = warning(&text);
        assert!(warned.contains("line 9: negative or missing radiation while the sun is down ("), "{warned}");
        assert!(warned.contains("at 6/21 0.50 h, and 7 more steps): 0 is used"), "{warned}");
    }
    for (at_noon, message) in [
        (["-999", "100"], "line 20: direct normal irradiance: the value is missing (-999 at 6/21 11.50 h): 1 of 15 steps"),
        (["600", "9999"], "line 20: diffuse horizontal irradiance: the value is missing (9999)"),
        (["", "100"], "line 20: direct normal irradiance: the value is missing (empty)"),
        (["-5", "100"], "line 20: direct normal irradiance: -5 is impossible"),
    ] {
        assert!(refusal(&day(["0", "0"], at_noon)).starts_with(message), "{}", refusal(&day(["0", "0"], at_noon)));
    }
    // WEA files of all three kinds.
    for units in ["1", "2", "3"] {
        let text = wea("6 21 0.5 -999 -999\n6 21 1.5 999999 0\n6 21 12.5 700 120\n").replace("units 1", &format!("units {units}"));
        let values: Vec<_> = read(&text).records.iter().map(|r| (r.direct, r.diffuse)).collect();
        assert_eq!(values, [(0.0, 0.0), (0.0, 0.0), (700.0, 120.0)]);
        assert!(warning(&text).contains("(-999 at 6/21 0.50 h, and 1 more steps)"), "{}", warning(&text));
        assert!(
            refusal(&text.replace("12.5 700", "12.5 -999"))
                .contains("the value is missing (-999 at 6/21 12.50 h): 1 of 1 steps with the sun up")
        );
    }
}

#[test]
fn only_hours_that_are_dark_from_beginning_to_end_make_a_site_suspect() {
    // 1 February at 40.78° N 73.97° W: sunrise at 7:05, sunset at 17:12 (day 32, gendaymtx's sun).
    let at = |hour: &str| warning(&wea(&format!("2 1 {hour} 60 10\n")));
    for up_for_a_part in ["7.5", "16.5", "17.5", "17", "18", "7", "8"] {
        assert_eq!(at(up_for_a_part), "", "{up_for_a_part}");
    }
    // 6.5 stands for the hour from 6 to 7.
    for dark in ["18.5", "6.5", "5.5", "0.5", "19", "6"] {
        assert!(at(dark).contains("direct sun while the sun is below the horizon"), "{dark}");
    }
    // Quarters of an hour are judged as such: half past five is a quarter of an hour too late.
    let quarters = |hour: &str| warning(&wea(&format!("2 1 12.25 600 100\n2 1 12.50 600 100\n2 1 {hour} 60 10\n")));
    assert!(!quarters("17.25").contains("check latitude") && quarters("17.75").contains("check latitude"));
}

#[test]
fn an_epw_file_that_a_spreadsheet_saved_with_semicolons_keeps_its_values() {
    let plain = epw("1,Data,Sunday,6/21,6/21", &epw_line(6, 21, 12, 60, "5.5", "850.5", "100"));
    let saved = plain.replace(',', ";").replace('.', ",").replace("Sunday,", "Sunday;");
    let (a, b) = (read(&plain), read(&saved));
    assert_eq!((a.latitude, a.longitude, a.elevation), (b.latitude, b.longitude, b.elevation));
    assert_eq!(a.records, b.records);
    assert!(warning(&saved).contains("semicolons"));
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
    assert!(refusal("\u{0}\u{1}ELF").contains("this is binary data, not a weather file"));
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

#[test]
fn a_few_gaps_by_day_are_dark_and_said_many_are_refused() {
    // Of the steps with the sun up a twentieth may lack their radiation: 17 of 354.
    let days: Vec<(u8, u8)> = (5..=28).map(|d| (6, d)).collect();
    let whole = hourly_epw("6/5,6/28", &days);
    let daylit = {
        let w = read(&whole);
        w.records.iter().filter(|r| w.sun(r).altitude > 0.0).count()
    };
    assert_eq!(daylit, 354);
    let with_gaps = |count: usize| {
        let w = read(&whole);
        let lines: Vec<usize> = w.records.iter().filter(|r| w.sun(r).altitude > 0.0).map(|r| r.line).take(count).collect();
        whole
            .lines()
            .enumerate()
            .map(|(i, l)| {
                if !lines.contains(&(i + 1)) {
                    return format!("{l}\n");
                }
                let mut fields: Vec<&str> = l.split(',').collect();
                (fields[14], fields[15]) = ("-999", "100");
                fields.join(",") + "\n"
            })
            .collect::<String>()
    };
    let w = read(&with_gaps(17));
    let gaps: Vec<_> = w.records.iter().filter(|r| w.sun(r).altitude > 0.0).take(17).collect();
    // The diffuse half of such a step was measured, but a sky of half a measurement is no sky.
    assert!(gaps.iter().all(|r| (r.direct, r.diffuse) == (0.0, 0.0)));
    let text = warning(&with_gaps(17));
    assert!(text.contains(&format!("17 of {daylit} steps with the sun up: these are dark in the results")), "{text}");
    assert!(refusal(&with_gaps(18)).contains(&format!("18 of {daylit} steps with the sun up")), "{}", refusal(&with_gaps(18)));
}

#[test]
fn a_direct_value_above_the_suns_is_used_and_said() {
    for (units, value, told) in [("1", "2337", "2337 W/m²"), ("2", "1501", "1501 W/m²"), ("3", "200000", "200000 lx")] {
        let text = wea(&format!("4 28 17.5 {value} 120\n4 28 18.5 1300 120\n")).replace("units 1", &format!("units {units}"));
        assert_eq!(read(&text).records[0].direct, value.parse::<f64>().unwrap());
        let warned = warning(&text);
        assert!(
            warned.contains(&format!("line 7: brighter than the sun outside the atmosphere ({told} at 4/28 17.50 h): used")),
            "{warned}"
        );
    }
    assert_eq!(warning(&wea("4 28 17.5 1500 120\n")), "");
}
