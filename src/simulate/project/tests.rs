//! Projects, sound and faulty.

use super::*;
use crate::bins::ReinhartSky;
use crate::error::{Error, Warnings};
use crate::simulate::project::method::{Glazing, Phases};

const GOOD: &str = r#"
[weather]
file = "a.wea"
[scene]
files = ["m.rad", "r.rad"]
[[window]]
name = "south"
surface = "w.rad"
bsdf = "b.xml"
[[sensors]]
name = "workplane"
points = "p.txt"
[method]
phases = 3
sky_subdivision = 4
bounces = 4
[quality]
preset = "final"
seed = 0x2a
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for f in ["a.wea", "m.rad", "r.rad", "w.rad", "b.xml", "p.txt", "s.rad"] {
        std::fs::write(folder.path().join(f), "").unwrap();
    }
    folder
}

fn read(text: &str) -> Result<Project> {
    let folder = folder();
    let file = folder.path().join("project.toml");
    std::fs::write(&file, text).unwrap();
    let project = Project::read(&file)?;
    project.check_phases(project.choice(&glazing()).phases)?;
    Ok(project)
}

/// Clear glazing.
fn glazing() -> Glazing {
    Glazing { sky: ReinhartSky::new(4).unwrap(), spreads_suns: false }
}

fn complaint(text: &str) -> String {
    let message = read(text).unwrap_err().to_string();
    message[message.find("project.toml").expect("the file is named")..].to_string()
}

#[test]
fn a_sound_project_is_read_with_paths_relative_to_it() {
    let p = read(GOOD).unwrap();
    assert!(p.weather.file.ends_with("a.wea") && p.weather.file.is_absolute());
    assert_eq!(p.scene.files.len(), 2);
    assert_eq!((p.windows[0].name.as_str(), p.sensors[0].name.as_str()), ("south", "workplane"));
    assert_eq!((p.method.phases, p.method.sky.map(|s| s.subdivision()), p.method.bounces), (Phases::Three, Some(4), Some(4)));
    assert_eq!((p.quality.preset, p.quality.seed), (Preset::Final, 42));
}

#[test]
fn what_is_left_out_has_defaults() {
    let p = read(&GOOD[..GOOD.find("[method]").unwrap()]).unwrap();
    assert_eq!((p.method.phases, p.method.sky, p.method.bounces), (Phases::Auto, None, None));
    assert_eq!(p.choice(&glazing()).phases, 3);
    assert_eq!((p.quality.preset, p.quality.seed), (Preset::Standard, 1));
}

#[test]
fn every_fault_is_answered_with_line_key_and_remedy() {
    // What is replaced by what, the line and the words that must be in the complaint.
    let cases: &[(&str, &str, usize, &[&str])] = &[
        ("bounces = 4", "bouncs = 4", 16, &["'bouncs'", "[method]", "did you mean 'bounces'?"]),
        ("[quality]", "[qualty]", 17, &["'qualty'", "did you mean 'quality'?"]),
        ("[[window]]", "[[windows]]", 6, &["'windows'", "did you mean 'window'?"]),
        ("[scene]", "[colours]", 1, &["the project has no 'scene'", "add [scene]"]),
        ("files = [", "file = [", 5, &["'file'", "[scene]", "did you mean 'files'?"]),
        ("[[window]]", "[window]", 6, &["window", "[[window]]"]),
        ("bsdf = \"b.xml\"", "bsfd = \"b.xml\"", 9, &["'bsfd'", "did you mean 'bsdf'?"]),
        ("bsdf = \"b.xml\"", "", 6, &["[window 1] does not say what the window is made of", "glass = 0.65", "bsdf =", "glazing ="]),
        ("bsdf = \"b.xml\"", "bsdf = \"c.xml\"", 9, &["window 1.bsdf", "no file", "c.xml", "relative"]),
        ("surface = \"w.rad\"", "surface = 3", 8, &["window 1.surface", "a whole number", "text"]),
        ("sky_subdivision = 4", "sky_subdivision = 7", 15, &["method.sky_subdivision", "1 to 6"]),
        ("sky_subdivision = 4", "sky_subdivision = 1.5", 15, &["a number, not a whole number"]),
        ("bounces = 4", "bounces = -1", 16, &["method.bounces", "out of range"]),
        ("phases = 3", "phases = 4", 14, &["4 phases", "choose 2, 3, 5"]),
        ("\"final\"", "\"best\"", 18, &["'best'", "\"draft\", \"standard\", \"final\""]),
        ("seed = 0x2a", "seed = 99999999999999999999", 19, &["quality.seed", "out of range"]),
        ("seed = 0x2a", "target_error = 0.02", 19, &["quality.target_error", "'preset' and 'target_error' contradict", "keep one"]),
        ("preset = \"final\"", "rounds = 3\ntime_limit = \"5 min\"", 18, &["quality.rounds", "'time_limit' and 'rounds'"]),
        ("preset = \"final\"", "target_error = 2", 18, &["quality.target_error", "from 0.0001 to 0.5"]),
        ("preset = \"final\"", "target_error = 0.0", 18, &["quality.target_error", "out of range"]),
        ("preset = \"final\"", "time_limit = \"5 fortnights\"", 18, &["quality.time_limit", "'5 fortnights'", "5 min"]),
        ("preset = \"final\"", "time_limit = \"-1 s\"", 18, &["quality.time_limit", "'-1 s'"]),
        ("[\"m.rad\", \"r.rad\"]", "[]", 5, &["scene.files", "empty"]),
        ("[\"m.rad\", \"r.rad\"]", "[\"m.rad\", 3]", 5, &["scene.files", "name of a file"]),
        ("[\"m.rad\", \"r.rad\"]", "\"m.rad\"", 5, &["scene.files", "a list of files"]),
        ("file = \"a.wea\"", "", 2, &["[weather] has no 'file'"]),
        ("name = \"south\"", "name = \"a/b\"", 7, &["window 1.name", "file name"]),
        ("name = \"south\"", "name = \"../x\"", 7, &["window 1.name", "file name"]),
        ("points = \"p.txt\"", "points = \".\"", 12, &["sensors 1.points", "a folder"]),
        ("phases = 3", "phases = = 3", 14, &["toml.io"]),
        ("phases = 3", "phases = 5", 14, &["five phases need a window", "shade"]),
        ("phases = 3", "phases = \"some\"", 14, &["'some'", "\"auto\""]),
        ("phases = 3", "phases = 3\nsuns = 4", 15, &["suns are traced by five phases only"]),
        ("phases = 3", "suns = \"daily\"", 14, &["'daily'", "\"hourly\""]),
        ("phases = 3", "suns = 7", 14, &["1 to 6"]),
        ("bsdf = \"b.xml\"", "bsdf = \"b.xml\"\nshade = \"s.rad\"", 15, &["'south' has a shade", "phases = 5"]),
        ("bsdf = \"b.xml\"", "bsdf = \"b.xml\"\nshade = \"t.rad\"", 10, &["window 1.shade", "no file"]),
    ];
    for (from, to, line, words) in cases {
        assert!(GOOD.contains(from));
        let message = complaint(&GOOD.replacen(from, to, 1));
        assert!(message.starts_with(&format!("project.toml:{line}: ")), "{to}: wanted line {line}: {message}");
        for word in *words {
            assert!(message.contains(word), "{to}: no '{word}' in: {message}");
        }
    }
}

#[test]
fn accuracy_is_asked_for_in_one_way() {
    use crate::simulate::project::quality::Stop;
    use std::time::Duration;
    let stop = |text: &str| read(&GOOD.replace("preset = \"final\"", text)).unwrap().quality.stop();
    assert_eq!(stop(""), Stop::Rounds(1));
    assert_eq!(stop("preset = \"final\""), Stop::Rounds(16));
    assert_eq!(stop("target_error = 0.02"), Stop::Adaptive { target: Some(0.02), time: None, rounds: None });
    assert_eq!(stop("rounds = 7"), Stop::Adaptive { target: None, time: None, rounds: Some(7) });
    let both = stop("target_error = 0.01\ntime_limit = \"1.5 h\"");
    assert_eq!(both, Stop::Adaptive { target: Some(0.01), time: Some(Duration::from_secs(5400)), rounds: None });
}

#[test]
fn a_shade_makes_five_phases() {
    use crate::simulate::project::method::SunScheme;
    let shaded = GOOD.replace("bsdf = \"b.xml\"", "bsdf = \"b.xml\"\nshade = \"s.rad\"");
    for (phases, suns) in [
        ("phases = \"auto\"\nsuns = \"hourly\"", SunScheme::HOURLY),
        ("phases = 5\nsuns = 4", SunScheme::Patches(ReinhartSky::new(4).unwrap())),
    ] {
        let p = read(&shaded.replace("phases = 3", phases)).unwrap();
        assert_eq!(p.choice(&glazing()).phases, 5);
        assert_eq!(p.method.suns, suns);
        assert!(p.windows[0].shade.as_ref().is_some_and(|s| s.ends_with("s.rad")));
    }
    let p = read(&GOOD.replace("phases = 3", "phases = 2")).unwrap();
    assert_eq!((p.method.phases, p.choice(&glazing()).phases), (Phases::Two, 2));
}

#[test]
fn views_and_hours_of_pictures_are_read() {
    let view = "[[view]]\nname = \"desk\"\nfile = \"m.rad\"\nresolution = [400, 300]\n";
    let p = read(&format!("{GOOD}{view}[images]\nhours = [12, 3]\n")).unwrap();
    assert_eq!((p.views[0].name.as_str(), p.views[0].resolution), ("desk", [400, 300]));
    assert_eq!(p.images.hours, ImageHours::Chosen(vec![12, 3]));
    assert_eq!(read(&format!("{GOOD}{view}[images]\nhours = \"daylight\"\n")).unwrap().images.hours, ImageHours::Daylight);
    assert_eq!(read(GOOD).unwrap().images.hours, ImageHours::None);
    for (wrong, words) in [
        ("resolution = [400]", "two numbers"),
        ("resolution = [400, 0]", "out of range"),
        ("resolution = 400", "a list of whole numbers"),
        ("name = \"workplane\"", "two sections"),
    ] {
        let line =
            if wrong.starts_with("name") { view.replace("name = \"desk\"", wrong) } else { view.replace("resolution = [400, 300]", wrong) };
        let message = complaint(&format!("{GOOD}{line}"));
        assert!(message.contains(words), "{wrong}: {message}");
    }
    assert!(complaint(&format!("{GOOD}[images]\nhours = \"daylight\"\n")).contains("[[view]]"));
    assert!(complaint(&format!("{GOOD}{view}[images]\nhours = \"night\"\n")).contains("'night'"));
}

/// Two states by their tables, the first of glass.
const STATES: &str = "group = \"façade\"\n[[window.state]]\nname = \"open\"\nglass = 0.65\n\
                      [[window.state]]\nname = \"blind 45\"\nbsdf = \"b.xml\"\nshade = \"s.rad\"";

#[test]
fn states_are_read_in_both_forms() {
    let short = read(&GOOD.replace("bsdf = \"b.xml\"", "states = [\"b.xml\", \"w.rad\", \"b.xml\"]")).unwrap();
    let names = |p: &Project| p.windows[0].states.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
    assert_eq!((names(&short), short.windows[0].group.as_str()), (["b", "w", "b-2"].map(String::from).to_vec(), "south"));
    assert_eq!(short.facade.groups()[0].states, names(&short));
    // One state is no choice.
    assert!(read(&GOOD.replace("bsdf = \"b.xml\"", "states = [\"b.xml\"]")).is_ok());
    let text = GOOD.replace("bsdf = \"b.xml\"", STATES).replace("phases = 3", "phases = 5");
    let long = read(&format!("{text}[control]\n\"façade\" = \"blind 45\"\n")).unwrap();
    assert_eq!((names(&long), long.facade.groups()[0].name.as_str()), (["open", "blind 45"].map(String::from).to_vec(), "façade"));
    let window = &long.windows[0];
    assert!(window.filling.is_glass() && window.shade.is_none() && window.lets_suns_through() && !window.is_glass());
    let closed = window.in_state(1);
    assert!(closed.states.is_empty() && closed.shade.is_some() && closed.filling == Filling::Bsdf(window.bsdf_files()[0].clone()));
    assert_eq!(long.control.groups[0].asked, super::control::Asked::Stays(1));
    let scheduled = read(&format!("{text}[control]\n\"FAÇADE\" = \"p.txt\"\n")).unwrap();
    assert!(matches!(&scheduled.control.groups[0].asked, super::control::Asked::Schedule(file) if file.ends_with("p.txt")));
    let between = read(&GOOD.replace("bsdf = \"b.xml\"", "interpolate = [\"b.xml\", \"w.rad\", 0.25]")).unwrap();
    assert!(matches!(&between.windows[0].filling, Filling::Interpolated([a, b], 0.25) if a.ends_with("b.xml") && b.ends_with("w.rad")));
}

#[test]
fn faults_of_states_and_their_control_are_answered_with_line_key_and_remedy() {
    let other = "[[window]]\nname = \"north\"\nsurface = \"w.rad\"\ngroup = \"façade\"\n";
    let two = "[[window.state]]\nname = \"open\"\nglass = 0.5\n[[window.state]]\nname = \"shut\"\nglass = 0.1\n";
    let with = |states: &str, more: &str| GOOD.replace("bsdf = \"b.xml\"", states).replace("phases = 3", "phases = 5") + more;
    for (states, more, words) in [
        (STATES, "[control]\nsouth = \"open\"\n", &["control.south", "no group of windows 'south'", "façade"][..]),
        (STATES, "[control]\n\"façade\" = \"opne\"\n", &["control.façade", "neither a state", "did you mean the state 'open'?"]),
        (STATES, "[control]\n\"façade\" = \"blinds.csv\"\n", &["control.façade", "neither a state", "nor a file", "open, blind 45"]),
        (STATES, "[control]\n\"façade\" = 3\n", &["control.façade", "a whole number, not a text"]),
        ("bsdf = \"b.xml\"\nshade = \"s.rad\"", "[control]\nsouth = \"open\"\n", &["control.south", "no window has states"]),
        (&format!("glass = 0.5\n{STATES}"), "", &["window 1.glass", "either 'glass' or 'state'", "[[window.state]] of its own"]),
        (&format!("shade = \"s.rad\"\n{STATES}"), "", &["window 1.shade", "'south' in all states, 'open' the first", "its own 'shade'"]),
        (&format!("states = [\"b.xml\"]\n{STATES}"), "", &["window 1.states", "either 'states' or [[window.state]]"]),
        (&STATES.replace("blind 45", "OPEN"), "", &["window 1.state 2.name", "two states", "'OPEN'"]),
        (&STATES.replace("blind 45", "blind/45"), "", &["window 1.state 2.name", "file name"]),
        (&STATES.replace("glass = 0.65\n", ""), "", &["[window 1.state 1]", "does not say what the window is made of"]),
        (&STATES.replace("glass = 0.65", "glas = 0.65"), "", &["'glas'", "did you mean 'glass'?"]),
        (&STATES.replace("glass = 0.65", "glass = 0.65\nshade = \"s.rad\""), "", &["window 1.state 1.shade", "the pane of 'glass' itself"]),
        (
            STATES,
            &format!("{other}{two}"),
            &["window 2.group", "'south' and 'north' are of group 'façade'", "'open', 'blind 45' and 'open', 'shut'"],
        ),
        (STATES, &format!("{other}glass = 0.5\n"), &["window 2.group", "'open', 'blind 45' and none", "groups of their own"]),
        ("interpolate = [\"b.xml\", 0.5]", "", &["window 1.interpolate", "two files", "0.5]"]),
        ("interpolate = [\"b.xml\", \"b.xml\", 1.5]", "", &["window 1.interpolate", "out of range"]),
        ("interpolate = [\"b.xml\", \"c.xml\", 0.5]", "", &["window 1.interpolate", "no file"]),
    ] {
        let message = complaint(&with(states, more));
        assert!(message.starts_with("project.toml:") && message.contains("help: "), "{states} {more}: {message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{states} {more}: no '{word}' in: {message}"));
    }
    let direct = with(STATES, "").replace("phases = 5", "phases = \"direct\"");
    let message = complaint(&direct);
    assert!(message.contains("method.phases") && message.contains("'south' has states") && message.contains("\"auto\" or 5"), "{message}");
    // Suns made elsewhere passed one state.
    let given = with(STATES, "").replace("points = \"p.txt\"", "points = \"p.txt\"\nsun = \"s.rad\"");
    assert!(complaint(&given).contains("'workplane' has a sun matrix made elsewhere"), "{}", complaint(&given));
}

#[test]
fn names_used_twice_are_refused() {
    let twice = format!("{GOOD}[[sensors]]\nname = \"Workplane\"\npoints = \"p.txt\"\n");
    assert!(complaint(&twice).contains("two sections [[sensors]] have the name 'Workplane'"));
    // The direct part of the first would have the name of the second.
    let other = format!("{GOOD}[[sensors]]\nname = \"workplane_Direct\"\npoints = \"p.txt\"\n");
    assert!(complaint(&other).contains("'workplane_Direct' is another name with '_direct'"), "{}", complaint(&other));
}

#[test]
fn names_that_are_no_file_names_are_refused() {
    let named = |name: &str| GOOD.replace("name = \"workplane\"", &format!("name = '{name}'"));
    for bad in ["../up", "a/b", "a\\b", "C:x", ".hidden", "end.", "end ", "nul", "CON.x", "Com1", "new\u{1}line", "a*b"] {
        let told = complaint(&named(bad));
        // TOML itself refuses what cannot be seen.
        assert!(told.contains("cannot be part of a file name") || told.contains("invalid literal string"), "{bad:?}: {told}");
    }
    for empty in ["", " "] {
        assert!(complaint(&named(empty)).contains("this text is empty"), "{empty:?}");
    }
    for good in ["desk 1", "Büro", "a.b-c_d", "console", "com"] {
        assert!(read(&named(good)).is_ok(), "{good}");
    }
}

#[test]
fn faults_that_show_later_still_name_the_projects_line_and_key() {
    let view = |resolution: &str| format!("[[view]]\nname = \"desk\"\nfile = \"v.vf\"\nresolution = {resolution}\n");
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("v.vf"), "rvu -vtv -vh 10 -vv 170\n").unwrap();
    std::fs::write(at("up.txt"), "1 1 1 0 1 0\n2 2 2 0 0 1\n").unwrap();
    let read = |text: &str| {
        std::fs::write(at("project.toml"), text).unwrap();
        Project::read(&at("project.toml"))
    };
    let starts = |e: Error, start: &str| {
        let text = e.to_string();
        assert!(text.contains(start) && !text.split("help:").next().unwrap().contains(" -"), "{text}");
    };
    let project = read(&format!("{GOOD}{}[images]\nhours = [3, 9000]\n", view("[4, 4]"))).unwrap();
    let place = project.images.place.as_ref().unwrap();
    starts(place.of(Error::new("there is no hour 9000")), "project.toml:25: images.hours: there is no hour 9000");
    starts(project.views[0].raster().unwrap_err(), "project.toml:23: view 1.resolution: 4 × 4 square pixels are too few");
    assert!(read(&format!("{GOOD}{}", view("[1, 400]"))).unwrap().views[0].raster().is_ok());
    let looking_up = format!("{GOOD}[[views]]\nname = \"seats\"\npoints = \"up.txt\"\n");
    starts(read(&looking_up).unwrap_err(), "up.txt:2: this point looks straight up or down");
    let comma = read(&GOOD.replace("preset = \"final\"", "target_error = 0,02")).unwrap_err().to_string();
    assert!(comma.contains("project.toml:18: ") && comma.contains("write a point in place of the comma: 0.02"), "{comma}");
}

#[test]
fn garbage_is_refused_without_panic() {
    for cut in 0..GOOD.len() {
        if GOOD.is_char_boundary(cut) {
            let _ = read(&GOOD[..cut]);
        }
    }
    let folder = folder();
    let file = folder.path().join("project.toml");
    std::fs::write(&file, [b'\n', 0xff, 0xfe, 0, 1]).unwrap();
    assert!(Project::read(&file).unwrap_err().to_string().contains("project.toml:2: this is binary data, not a project file"));
    assert!(Project::read(&folder.path().join("none.toml")).is_err());
}

#[test]
fn a_sky_takes_the_place_of_a_weather_file() {
    let with = |keys: &str| GOOD.replacen("file = \"a.wea\"", keys, 1);
    let p = read(&with("sky = \"cie clear\"\ndate = [\"03-21T09:00\", \"06-21T12:00\"]\nsite = [46.5, 11.35, 15]")).unwrap();
    let weather = p.weather.load(&mut Warnings::new()).unwrap();
    assert_eq!((weather.records.len(), weather.latitude, weather.longitude, weather.time_zone), (2, 46.5, 11.35, 1.0));
    assert!(weather.records.iter().all(|r| r.direct > 10_000.0 && r.diffuse > 5_000.0), "{:?}", weather.records);
    // A daylight factor in one line.
    let p = read(&with("sky = \"cie overcast\"")).unwrap();
    let weather = p.weather.load(&mut Warnings::new()).unwrap();
    assert_eq!((weather.records.len(), weather.records[0].diffuse, weather.records[0].direct), (1, 10_000.0, 0.0));
    for (keys, words) in [
        ("sky = \"cie cloudy\"", "\"cie clear\""),
        ("sky = \"cie clear\"", "both its date and its site"),
        ("sky = \"cie overcast\"\ndate = \"03-21T12:00\"", "both its date and its site"),
        ("sky = \"cie overcast\"\nsite = [46.5, 11.35, 15]", "both its date and its site"),
        ("sky = \"cie overcast\"\ndate = \"3/21\"\nsite = [46.5, 11.35, 15]", "as 03-21T12:00"),
        ("sky = \"cie overcast\"\ndate = []\nsite = [46.5, 11.35, 15]", "this list is empty"),
        ("sky = \"cie overcast\"\ndate = \"03-21T12:00\"\nsite = [46.5, 11.35]", "latitude, longitude and standard meridian"),
        ("sky = \"cie overcast\"\nfile = \"a.wea\"", "take one of the two out"),
        ("file = \"a.wea\"\ndate = \"03-21T12:00\"", "'date' belongs to a 'sky'"),
        ("skey = \"cie overcast\"", "did you mean 'sky'?"),
        ("sky = \"cie overcast\"\n[output]\nquantity = \"irradiance\"", "skies are of visible light"),
    ] {
        let message = complaint(&with(keys));
        assert!(message.contains(words), "{keys}: {message}");
    }
    let night = read(&with("sky = \"cie clear\"\ndate = \"12-21T23:00\"\nsite = [46.5, 11.35, 15]")).unwrap();
    let message = night.weather.load(&mut Warnings::new()).unwrap_err().to_string();
    assert!(message.contains("project.toml") && message.contains("below the horizon"), "{message}");
}

#[test]
fn north_turns_the_sky_and_the_ground_reflects_as_the_project_says() {
    let p = read(&GOOD.replacen("file = \"a.wea\"", "file = \"a.wea\"\nnorth = 30\nground_albedo = 0.35", 1)).unwrap();
    assert_eq!((p.weather.north, p.weather.ground_albedo), (30.0, 0.35));
    let p = read(GOOD).unwrap();
    assert_eq!((p.weather.north, p.weather.ground_albedo), (0.0, 0.2));
    for (keys, words) in [("north = 400", "-360 to 360"), ("ground_albedo = 20", "0 to 1"), ("nort = 3", "did you mean 'north'?")] {
        let message = complaint(&GOOD.replacen("file = \"a.wea\"", &format!("file = \"a.wea\"\n{keys}"), 1));
        assert!(message.contains(words), "{keys}: {message}");
    }
}

#[test]
fn moments_have_names_skies_and_dates_of_their_own() {
    let with = |weather: &str, moments: &str| format!("{}{moments}", GOOD.replacen("file = \"a.wea\"", weather, 1));
    const SITE: &str = "site = [46.5, 11.35, 15]";
    let noon = "[[moment]]\nname = \"noon\"\nsky = \"cie clear\"\ndate = \"03-21T12:00\"\n";
    let grey = "[[moment]]\nname = \"noon, grey\"\nsky = \"cie overcast\"\ndate = \"03-21T12:00\"\n".replace(", ", " ");
    let project = read(&with(SITE, &format!("{noon}{grey}"))).unwrap();
    let weather = project.weather.load(&mut Warnings::new()).unwrap();
    assert_eq!(weather.names, ["noon", "noon grey"]);
    assert!(weather.records[0].direct > 10_000.0 && weather.records[1].direct == 0.0);
    let steps = weather.steps();
    // Two skies of one time have their own names in tables and pictures.
    assert_eq!((steps.label(1), steps.number(0), steps.number(1), steps.check_unique(&[0, 1]).is_ok()), ("noon grey".into(), 1, 2, true));
    assert_eq!(
        project.weather.describe(&weather),
        "weather: moments noon (cie clear, 21 March, 12:00), noon grey (cie overcast, 21 March, 12:00); 2 time steps"
    );
    let factor = read(&with("", "[[moment]]\nname = \"df\"\nsky = \"cie overcast\"\n")).unwrap();
    assert_eq!(factor.weather.load(&mut Warnings::new()).unwrap().records[0].diffuse, 10_000.0);
    for (weather, moments, words) in [
        (SITE, noon.repeat(2), "two sections [[moment]] have the name 'noon'"),
        ("file = \"a.wea\"", noon.to_string(), "'file' is not for [[moment]]"),
        ("period = \"03-21\"", noon.to_string(), "'period' is not for [[moment]]"),
        ("", noon.to_string(), "the moment 'noon' needs a site"),
        (SITE, noon.replace("date = \"03-21T12:00\"\n", ""), "the moment 'noon' needs its date"),
        ("", noon.replace("date = \"03-21T12:00\"\n", ""), "needs its date and a site"),
        (SITE, noon.replace("sky = \"cie clear\"\n", ""), "has no 'sky'"),
        (SITE, noon.replace("sky =", "skye ="), "did you mean 'sky'?"),
        (SITE, noon.replace("clear", "cloudy"), "\"cie intermediate\""),
    ] {
        let message = complaint(&with(weather, &moments));
        assert!(message.contains(words), "{moments}: {message}");
    }
}

#[test]
fn steps_of_a_weather_file_are_divided_and_chosen_in_this_order() {
    let folder = folder();
    let year: String = (0..24).map(|h| format!("6 21 {h}.500 500 100\n6 22 {h}.500 500 100\n")).collect();
    let mut lines: Vec<&str> = year.lines().collect();
    lines.sort_by_key(|l| l.split(' ').nth(1).map(str::to_string));
    let header = "place x\nlatitude 47\nlongitude -11\ntime_zone -15\nsite_elevation 0\nweather_data_file_units 1\n";
    std::fs::write(folder.path().join("a.wea"), format!("{header}{}\n", lines.join("\n"))).unwrap();
    let schedule: String = (0..8760).map(|h| format!("{}\n", u8::from((9..11).contains(&(h % 24))))).collect();
    std::fs::write(folder.path().join("office.csv"), schedule).unwrap();
    std::fs::write(folder.path().join("short.csv"), "1\n0\n").unwrap();
    let load = |keys: &str| {
        let file = folder.path().join("project.toml");
        let text = GOOD.replacen("file = \"a.wea\"", &format!("file = \"a.wea\"\n{keys}"), 1);
        let project = Project::parse(&file, &text)?;
        let weather = project.weather.load(&mut Warnings::new())?;
        let told = project.weather.describe(&weather);
        Result::Ok((weather, told))
    };
    let (weather, told) = load("timestep = 30\nperiod = \"06-22\"\nhours = \"office.csv\"").unwrap();
    let hours: Vec<f64> = weather.records.iter().map(|r| r.hour).collect();
    assert_eq!((hours, weather.records[0].day), (vec![9.25, 9.75, 10.25, 10.75], 22));
    assert_eq!((weather.steps().length, weather.steps().hours(4), weather.steps().place(3).minute), (0.5, 2.0, 30));
    assert!(told.contains("4 time steps of 30 min") && told.contains("from 06-22 to 06-22") && told.contains("office.csv"), "{told}");
    let (weather, told) = load(&format!("hours = [{}]", 172 * 24 + 3)).unwrap();
    assert_eq!((weather.records.len(), weather.records[0].day, weather.records[0].hour), (1, 22, 3.5));
    assert!(told.contains("1 time steps of 60 min"), "{told}");
    for (keys, words) in [
        ("timestep = 7", "7 minutes do not divide an hour"),
        ("period = \"07-01\"", "project.toml:4: weather.period: the weather has no time step from 07-01 to 07-01"),
        ("period = [\"07-01\", \"07-02\", \"07-03\"]", "a period is a day, or its first and last day"),
        ("period = \"7/1\"", "as 03-21"),
        ("hours = [3]", "weather.hours: hour 3 of the year (1 January, 3 o'clock) is not in the weather file"),
        ("hours = []", "this list is empty"),
        ("hours = \"short.csv\"", "short.csv: the schedule has 2 values"),
        ("hours = \"none.csv\"", "there is no file"),
        ("sun_matrix = \"a.wea\"", "'sun_matrix' belongs to a 'sky_matrix'"),
        ("sky_matrix = \"a.wea\"\nnorth = 3", "'north' turns skies that are made here"),
        ("sky_matrix = \"a.wea\"\ntimestep = 30", "'timestep' divides steps of a weather file"),
        ("sky_matrix = \"a.wea\"\nsky = \"cie clear\"", "take one of the two out"),
        ("sky_matrix = \"a.wea\"\nground_albedo = 0.3", "the first row of the matrix is its ground"),
    ] {
        let message = load(keys).unwrap_err().to_string();
        assert!(message.contains(words), "{keys}: {message}");
    }
}
