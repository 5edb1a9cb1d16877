//! Faulty and contradictory input of five phases: what a user is told, before anything is traced.

use super::*;
use std::fmt::Write;

/// What reading a project in the shipped room with blinds says: the error (empty without), then warnings.
fn said(folder: &Path, window: &str, sensors: &str, method: &str) -> String {
    let header = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
    std::fs::write(folder.join("w.wea"), header.to_string() + &clear_day()).unwrap();
    let scene = format!("{SCENES}/blinds");
    let bsdf =
        if window.contains("bsdf =") || window.contains("states =") { String::new() } else { format!("bsdf = \"{scene}/blind.xml\"") };
    let text = format!(
        "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"{scene}/room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"{scene}/window.rad\"\n\
         {bsdf}\n{window}\n[[sensors]]\nname = \"room\"\npoints = \"{scene}/points.txt\"\n{sensors}\n[method]\n{method}\n"
    );
    let file = folder.join("project.toml");
    std::fs::write(&file, text).unwrap();
    let mut warnings = Warnings::new();
    let result = Project::read(&file).and_then(|project| Inputs::read(&project, &mut warnings));
    let mut said = result.err().map(|e| format!("error: {e}\n")).unwrap_or_default();
    // The trees made up here are not those of the room's BSDF.
    let made_up = |w: &lucarne::Error| window.contains("tree.xml") && w.message().contains("sun and sky pass different windows");
    warnings.iter().filter(|w| !made_up(w)).for_each(|w| writeln!(said, "warning: {w}").unwrap());
    said
}

/// A day whose sun shines by day only.
fn clear_day() -> String {
    (0..24)
        .map(|h| format!("1 15 {h}.5 {} {}\n", if (9..16).contains(&h) { 500 } else { 0 }, if (8..17).contains(&h) { 120 } else { 0 }))
        .collect()
}

fn check(cases: &[(&str, String, &[&str])]) {
    for (case, said, words) in cases {
        for word in *words {
            assert!(said.contains(word), "{case}: no '{word}' in: {said}");
        }
        // An error says what to do.
        assert!(said.is_empty() == words.is_empty() && (!said.starts_with("error") || said.contains("help: ")), "{case}: {said}");
    }
}

#[test]
fn contradictions_are_answered_with_file_line_key_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let said = |window: &str, sensors: &str, method: &str| said(folder.path(), window, sensors, method);
    let (shade, tree) = (shade(), format!("tensor_tree = \"{SCENES}/blinds/blind.xml\""));
    let states = format!("states = [\"{SCENES}/blinds/blind.xml\", \"{SCENES}/blinds/blind.xml\"]");
    let five = "phases = 5";
    let columns = |n: usize| format!("#?RADIANCE\nNROWS=16\nNCOLS={n}\nNCOMP=1\nFORMAT=ascii\n\n{}", ("0\t".repeat(n) + "\n").repeat(16));
    for n in [3, 5186] {
        std::fs::write(folder.path().join(format!("C{n}.mtx")), columns(n)).unwrap();
    }
    check(&[
        ("a shade", said(&shade, "", five), &[]),
        (
            "three phases with a shade",
            said(&shade, "", "phases = 3"),
            &["error", "project.toml:15: method.phases", "'south' has a shade", "phases = 5"],
        ),
        ("two phases with a tree", said(&tree, "", "phases = 2"), &["error", "project.toml:15: method.phases", "tensor tree"]),
        ("five phases without", said("", "", five), &["error", "method.phases", "add shade", "tensor_tree"]),
        ("suns of three phases", said("", "", "phases = 3\nsuns = 4"), &["error", "project.toml:16: method.suns", "five phases only"]),
        (
            "suns that nothing lets through",
            said("", "", "suns = 4"),
            &["warning", "project.toml: method.suns", "no effect", "take 'suns' out"],
        ),
        ("MF:7", said(&shade, "", "phases = 5\nsuns = 7"), &["error", "method.suns", "1 to 6"]),
        ("a slip", said(&shade, "", "phases = 5\nsuns = \"hourli\""), &["error", "'hourli'", "\"hourly\", or a whole number from 1 to 6"]),
        ("five in words", said(&shade, "", "phases = \"five\""), &["error", "'five'", "\"direct\", or a whole number"]),
        ("shade and tree", said(&format!("{shade}\n{tree}"), "", five), &["error", "window 1.tensor_tree", "either", "keep the shade"]),
        (
            "BSDF and states",
            said(&format!("bsdf = \"{SCENES}/blinds/blind.xml\"\n{states}"), "", five),
            &["error", "window 1.bsdf", "either"],
        ),
        (
            "a shade with states",
            said(&format!("{states}\n{shade}"), "", five),
            &["error", "'south' in all states", "[[window.state]] its own 'shade'"],
        ),
        (
            "hourly suns, matrix of patches",
            said(&shade, "sun = \"C5186.mtx\"", "phases = 5\nsuns = \"hourly\""),
            &["error", "C5186.mtx", "5186 columns", "suns hourly"],
        ),
        ("patches, matrix of others", said(&shade, "sun = \"C3.mtx\"", five), &["error", "C3.mtx", "3 columns", "need 5186", "suns.rad"]),
        ("a matrix of all patches", said(&shade, "sun = \"C5186.mtx\"", five), &["warning", "their noise is not in the estimated error"]),
        (
            "an XML file as shade",
            said(&format!("shade = \"{SCENES}/blinds/blind.xml\""), "", five),
            &["error", "blind.xml:1", "XML", "tensor_tree"],
        ),
        (
            "a shade as tree",
            said(&format!("tensor_tree = \"{SCENES}/blinds/blinds.rad\""), "", five),
            &["error", "blinds.rad", "not a BSDF file"],
        ),
    ]);
}

/// A BSDF file with blocks of a tensor tree.
fn xml(rank: usize, blocks: &[(&str, &str)]) -> String {
    let block = |(direction, data): &(&str, &str)| {
        format!(
            "<WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>\n\
             <WavelengthDataDirection>{direction}</WavelengthDataDirection><AngleBasis>LBNL/Shirley-Chiu</AngleBasis>\n\
             <ScatteringData>\n{data}\n</ScatteringData></WavelengthDataBlock></WavelengthData>\n"
        )
    };
    format!(
        "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>TensorTree{rank}</IncidentDataStructure></DataDefinition>\n\
         {}</Layer></Optical></WindowElement>",
        blocks.iter().map(block).collect::<String>()
    )
}

fn groups(count: usize, last: &str) -> String {
    format!("{{\n{}{{ {last} }}\n}}", "{ 0.05 }\n".repeat(count - 1))
}

#[test]
fn faults_of_tensor_trees_are_told_with_file_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let said = |rank: usize, blocks: &[(&str, &str)]| {
        std::fs::write(folder.path().join("tree.xml"), xml(rank, blocks)).unwrap();
        said(folder.path(), "tensor_tree = \"tree.xml\"", "", "phases = 5")
    };
    let front = |data: &str| said(4, &[("Transmission Front", data)]);
    let good = groups(16, "0.05");
    check(&[
        ("sound", front(&good), &[]),
        ("a brace too few", front(good.trim_end_matches('}')), &["error", "tree.xml:", "inside 1 open brace", "missing"]),
        ("an open brace too many", front(&format!("{{{good}")), &["error", "tree.xml:", "open brace"]),
        ("a closing brace too many", front(&format!("{good}}}")), &["error", "tree.xml:", "without its opening one", "too many"]),
        ("15 groups", front(&groups(15, "0.05")), &["error", "tree.xml:", "15 groups", "16 are needed"]),
        ("17 groups", front(&groups(17, "0.05")), &["error", "tree.xml:", "more than 16 groups"]),
        ("rank 3 in 4", front(&groups(8, "0.05")), &["error", "8 groups", "TensorTree3"]),
        ("rank 4 in 3", said(3, &[("Transmission Front", &good)]), &["error", "more than 8 groups", "TensorTree3"]),
        ("an empty group", front(&groups(16, "")), &["error", "tree.xml:", "empty brace"]),
        ("numbers outside", front(&format!("{good} 0.5")), &["error", "outside the innermost braces"]),
        ("nested without end", front(&("{".repeat(400) + "1")), &["error", "nested deeper"]),
        ("not a number", front(&groups(16, "ten")), &["error", "'ten' is not a number"]),
        ("NaN", front(&groups(16, "nan")), &["error", "Transmission Front", "'nan'", "finite"]),
        ("infinite", front(&groups(16, "1e39")), &["error", "'1e39'", "finite"]),
        ("absurd", front(&groups(16, "1e30")), &["error", "tree.xml: ScatteringData", "times the light", "1/sr"]),
        ("too much", front(&groups(16, "9")), &["warning", "tree.xml:", "% of the light from the", "lucarne bsdf check"]),
        (
            "negative",
            front(&groups(16, "-5")),
            &["warning", "tree.xml: Transmission Front", "1 values are negative and count as 0", "--repair"],
        ),
        ("nothing", front(""), &["error", "no values"]),
        ("no transmission", said(4, &[("Reflection Front", &good)]), &["error", "tree.xml", "no transmission", "Transmission Front"]),
        (
            "an unknown direction",
            said(4, &[("Transmission Fornt", &good)]),
            &["error", "tree.xml:", "'Transmission Fornt'", "it is one of"],
        ),
        ("twice", said(4, &[("Transmission Front", &good), ("Transmission Front", "{ 0.1 }")]), &["warning", "comes twice"]),
        // One transmission stands for both, as in Radiance.
        ("incomplete directions", said(4, &[("Transmission Back", &good)]), &[]),
    ]);
}

/// SplitMix64.
fn random(state: &mut u64) -> usize {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as usize
}

/// A file with some of its bytes changed, taken out, doubled, or with words exchanged for hostile ones.
fn damaged(sound: &[u8], state: &mut u64) -> Vec<u8> {
    const WORDS: [&str; 14] =
        ["nan", "-1", "1e999", "999999999999", "{", "}", "<", "\"", "\n", "\u{0}", "polygon", "!xform", "NROWS=99999999999", "-99999999"];
    let mut bytes = sound.to_vec();
    for _ in 0..1 + random(state) % 3 {
        if bytes.is_empty() {
            break;
        }
        let at = random(state) % bytes.len();
        match random(state) % 5 {
            0 => bytes.truncate(at),
            1 => bytes[at] = random(state) as u8,
            2 => drop(bytes.drain(at..(at + 1 + random(state) % 40).min(bytes.len()))),
            3 => {
                let piece = bytes[at..(at + random(state) % 60).min(bytes.len())].to_vec();
                let _ = bytes.splice(at..at, piece).count();
            }
            _ => {
                let start = bytes[..at].iter().rposition(u8::is_ascii_whitespace).map_or(0, |i| i + 1);
                let end = bytes[at..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |i| at + i);
                let word = WORDS[random(state) % WORDS.len()].bytes();
                let _ = bytes.splice(start..end.max(start), word).count();
            }
        }
    }
    bytes
}

/// No reader panics, hangs, or gives what is not finite, whatever is done to its file.
#[test]
fn damaged_files_of_all_kinds_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut warnings = Warnings::new();
    let tree = xml(4, &[("Transmission Front", &groups(16, "0.05")), ("Reflection Front", &groups(16, "0.01"))]);
    let matrix = "#?RADIANCE\nNROWS=3\nNCOLS=2\nNCOMP=3\nFORMAT=ascii\n\n".to_string() + &"1 2 3\t4 5 6\n".repeat(3);
    let wea = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n".to_string()
        + &day(500.0);
    let mut epw = "LOCATION,Test,NY,USA,TMY3,725030,40.78,-73.97,-5.0,3.4\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\n\
        GROUND TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,\nCOMMENTS 2,\nDATA PERIODS,1,1,Data,Sunday, 1/ 1, 1/ 1\n"
        .to_string();
    for hour in 1..=24 {
        writeln!(
            epw,
            "1999,1,1,{hour},0,?9?9,2.0,1.0,90,101300,0,0,300,100,400,120,0,0,0,0,0,3.0,5,5,20,77777,9,999999999,99,0.1,0,88,0,0,0"
        )
        .unwrap();
    }
    let scene = |name: &str| std::fs::read_to_string(format!("{SCENES}/blinds/{name}")).unwrap();
    let mut project = scene("project.toml").replace("../office", &format!("{SCENES}/office"));
    for file in ["room.rad", "window.rad", "blind.xml", "blinds.rad", "points.txt", "views/seat.vf"] {
        project = project.replace(&format!("\"{file}\""), &format!("\"{SCENES}/blinds/{file}\""));
    }
    let files: Vec<(&str, String, usize)> = vec![
        ("a.xml", tree, 400),
        ("a.mtx", matrix, 400),
        ("a.wea", wea, 300),
        ("a.epw", epw, 300),
        ("a.rad", scene("room.rad"), 400),
        ("window.rad", scene("window.rad"), 400),
        ("a.toml", project, 400),
        ("a.vf", scene("views/seat.vf"), 400),
        ("a.txt", scene("points.txt"), 400),
    ];
    let mut state = 5;
    for (name, sound, rounds) in files {
        let path = folder.path().join(name);
        let mut read = 0;
        for round in 0..=rounds {
            let bytes = if round == 0 { sound.clone().into_bytes() } else { damaged(sound.as_bytes(), &mut state) };
            std::fs::write(&path, &bytes).unwrap();
            let local = [PathBuf::from(name)];
            let result = match name {
                "a.xml" => lucarne::bsdf::read(&path, &mut warnings).map(|b| {
                    lucarne::bsdf::check::check(&b, &Warnings::new());
                    let _ = lucarne::bsdf::evaluate::Scattering::checked(&b, &mut warnings);
                }),
                "a.mtx" => read_matrix(&path).map(drop),
                "a.wea" | "a.epw" => Weather::read(&path, &mut warnings).map(|w| {
                    let finite = |r: &lucarne::weather::Record| r.direct.is_finite() && r.diffuse.is_finite();
                    assert!(w.records.iter().all(finite), "{}", String::from_utf8_lossy(&bytes));
                    let sky = lucarne::sky::sky_matrix(&w, &lucarne::sky::SkyOptions::default(), &Silent);
                    assert!(sky.is_ok_and(|s| s.data().iter().all(|v| v.is_finite())), "{}", String::from_utf8_lossy(&bytes));
                }),
                "a.rad" => lucarne::scene::rad::read_scene(&local, folder.path(), &mut warnings).map(|s| {
                    assert!(s.triangles.iter().flat_map(|t| t.vertices).all(|v| v.is_finite()), "{}", String::from_utf8_lossy(&bytes));
                }),
                "window.rad" => lucarne::scene::read_windows(Path::new(name), folder.path(), &mut warnings).map(drop),
                "a.toml" => Project::read(&path).map(drop),
                "a.vf" => lucarne::camera::View::read(&path).and_then(|v| v.camera()).map(drop),
                _ => read_points(&path).map(drop),
            };
            match result {
                Ok(()) => read += 1,
                Err(e) => {
                    assert!(round > 0, "{name}: {e}");
                    // A panic would have stopped here; the message names the file.
                    assert!(e.to_string().contains(name) || name == "a.vf", "{name}: {e}");
                }
            }
        }
        println!("{name}: {read} of {rounds} damaged files were read");
    }
}

/// Slats of a shade in the slab of a BSDF that is a little too thin for what lies farthest from its face.
#[test]
fn a_shade_that_sticks_out_of_its_slab_is_told_of() {
    let folder = tempfile::tempdir().unwrap();
    let slats = std::fs::read_to_string(format!("{SCENES}/blinds/blinds.rad")).unwrap();
    let with = |thickness: f64| {
        // The pane, 0.09 behind the face, lies farthest out.
        let head = format!(
            "void BSDF proxy\n6 {thickness} {SCENES}/blinds/blind.xml 0 0 1 .\n0\n0\n\
             proxy polygon face 0 0 12  0.7 -0.06 0.95  0.7 -0.06 2.15  2.3 -0.06 2.15  2.3 -0.06 0.95\n"
        );
        std::fs::write(folder.path().join("proxy.rad"), head + &slats).unwrap();
        said(folder.path(), "shade = \"proxy.rad\"", "", "phases = 5")
    };
    // A hundredth of the thickness and a tenth of a millimetre are rounding: 0.00098 here.
    let line = 5 + 1 + slats.lines().position(|l| l.contains("polygon the_pane")).unwrap();
    let place = format!("'the_pane' (line {line})");
    check(&[
        ("thick enough", with(0.0901), &[]),
        ("too thin by rounding", with(0.0892), &[]),
        (
            "a little too thin",
            with(0.0885),
            &["warning", "proxy.rad", "window 'south'", &place, "0.0015 outside the slab of 0.0885", "'face' (line 5)", "as its thickness"],
        ),
        ("for most of it", with(0.06), &["warning", &place, "0.0300 outside the slab of 0.0600"]),
        ("altogether on the wrong side", with(-0.06), &["error", "proxy.rad", "outside the slab of 0.0600"]),
    ]);
}
