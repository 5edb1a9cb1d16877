//! `lucarne bsdf` as users run it: the lines of its documentation, exit codes, input of any kind.

use lucarne::Warnings;
use lucarne::bsdf::{self, Block, Bsdf, Component, KlemsMatrix};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

#[path = "../src/testing.rs"]
mod testing;

fn lucarne(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lucarne")).args(arguments).current_dir(folder).stdin(Stdio::null()).output().unwrap()
}

/// A line of documentation, split at blanks; quotes and comments dropped.
fn line(folder: &Path, line: &str) -> Output {
    let words: Vec<String> = line.split('#').next().unwrap().split_whitespace().skip(1).map(|w| w.trim_matches('"').to_string()).collect();
    lucarne(folder, &words.iter().map(String::as_str).collect::<Vec<_>>())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).to_string()
}

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bsdf")
}

/// Whether kernels can run here, or a skip.
fn has_device() -> bool {
    testing::has_device(env!("CARGO_BIN_EXE_lucarne"))
}

fn read(path: &Path) -> Bsdf {
    bsdf::read(path, &mut Warnings::new()).unwrap()
}

fn matrix(bsdf: &Bsdf, component: Component) -> &KlemsMatrix {
    bsdf.visible.get(component).and_then(Block::as_klems).unwrap()
}

#[test]
fn the_lines_of_the_documentation_work_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let works = |words: &str| {
        let output = line(folder.path(), words);
        assert!(output.status.success(), "{words}: {}", text(&output.stderr));
        text(&output.stderr)
    };
    fs::copy(samples().join("blinds_device.rad"), at("blinds_device.rad")).unwrap();
    fs::copy(samples().join("film.dat"), at("table.dat")).unwrap();
    works("lucarne bsdf isotropic table.dat -o film.xml");
    works("lucarne bsdf isotropic --normal .6,.1,.08,.05 -o clear.xml");
    works("lucarne bsdf isotropic --normal .1,.5,.05,.15 -o cloudy.xml");
    works("lucarne bsdf interpolate clear.xml cloudy.xml --states 5 -o state_%d.xml");
    let hemispherical = |name: &str| read(&at(name)).visible.get(Component::TransmissionFront).unwrap().hemispherical();
    for (k, state) in ["state_0.xml", "state_1.xml", "state_2.xml", "state_3.xml", "state_4.xml"].iter().enumerate() {
        let share = k as f64 / 4.0;
        let mixed = (1.0 - share) * hemispherical("clear.xml") + share * hemispherical("cloudy.xml");
        // Files hold nine digits.
        assert!((hemispherical(state) - mixed).abs() < 1e-7, "{state}");
    }
    let loss = works("lucarne bsdf convert film.xml --to t4:5 -o film_t4.xml");
    assert!(loss.contains("hemispherical") && loss.contains("peak") && loss.contains("RMS"), "{loss}");
    assert!((hemispherical("film_t4.xml") - hemispherical("film.xml")).abs() < 1e-3);
    works("lucarne bsdf plot film.xml -o film.png");
    assert!(fs::read(at("film.png")).unwrap().starts_with(b"\x89PNG"));
    if !has_device() {
        return;
    }
    works("lucarne bsdf generate blinds_device.rad -o blinds.xml            # Klems full; -t4 5 for a tensor tree");
    assert_eq!(matrix(&read(&at("blinds.xml")), Component::TransmissionFront).incident().len(), 145);
    works("lucarne bsdf check blinds.xml                     # exit 0 sound, 1 faults found, 2 unreadable");
    works("lucarne bsdf generate --venetian width=25mm,spacing=20mm,angle=20,reflectance=0.5 -o venetian.xml");
    fs::copy(at("blinds.xml"), at("outside.xml")).unwrap();
    let values = works("lucarne bsdf layer outside.xml gap=16mm \"glass:clear_6mm\" -o system.xml   # from outside to inside");
    assert!(values.contains("Tvis") && values.contains("Rvis front") && values.contains("layer 2"), "{values}");
    let system = read(&at("system.xml"));
    assert!((system.thickness.unwrap() - read(&at("outside.xml")).thickness.unwrap() - 0.016 - 0.005_715).abs() < 1e-9);
    works("lucarne bsdf check system.xml");
}

/// The examples of the guide's page run in their order in the folder they name.
#[test]
fn the_examples_of_the_guide_work() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(samples()).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/guide/bsdf.md")).unwrap();
    // Scans have a test of their own, which makes some.
    let is_example = |s: &&str| s.starts_with("lucarne bsdf ") && !s.ends_with("VERB") && !s.contains("scans/");
    let examples: Vec<&str> = page.split('`').filter(is_example).collect();
    assert!(examples.len() >= 10, "{examples:?}");
    for example in examples {
        let output = line(folder.path(), example);
        // Two blinds of different bases differ: an answer, not a failure.
        let accepted = if example.starts_with("lucarne bsdf diff") { vec![0, 1] } else { vec![0] };
        assert!(output.status.code().is_some_and(|c| accepted.contains(&c)), "{example}: {}", text(&output.stderr));
    }
    for made in ["blinds.xml", "blind.xml", "system.xml", "film.xml", "state_4.xml", "film_t4.xml", "blinds.png"] {
        assert!(folder.path().join(made).exists(), "{made}");
    }
}

#[test]
fn every_verb_has_an_example_in_its_help() {
    let here = Path::new(".");
    for verb in ["generate", "info", "check", "isotropic", "layer", "plot", "interpolate", "convert", "diff", "fit", "peaks"] {
        let help = text(&lucarne(here, &["bsdf", verb, "--help"]).stdout);
        assert!(help.contains("Example") && help.contains(&format!("lucarne bsdf {verb} ")), "{verb}: {help}");
    }
}

#[test]
fn check_says_by_its_exit_code_what_it_found_and_repairs() {
    let folder = tempfile::tempdir().unwrap();
    let code = |arguments: &[&str]| lucarne(folder.path(), &[&["bsdf", "check"], arguments].concat()).status.code();
    let mut ill = read(&samples().join("venetian.xml"));
    bsdf::write(Some(&folder.path().join("sound.xml")), &ill, "").unwrap();
    let Some(Block::Klems(m)) = ill.visible.slot(Component::TransmissionBack) else { panic!("a matrix") };
    m.values_mut().fill(0.0);
    bsdf::write(Some(&folder.path().join("ill.xml")), &ill, "").unwrap();
    fs::write(folder.path().join("broken.xml"), "<WindowElement>").unwrap();
    assert_eq!(code(&["sound.xml"]), Some(0));
    assert_eq!(code(&["ill.xml"]), Some(1));
    assert_eq!(code(&["broken.xml"]), Some(2));
    assert_eq!(code(&["absent.xml"]), Some(2));
    let output = lucarne(folder.path(), &["bsdf", "check", "ill.xml", "--repair", "-o", "repaired.xml"]);
    assert!(text(&output.stdout).contains("made from Transmission Front by reciprocity"), "{}", text(&output.stdout));
    assert_eq!(code(&["repaired.xml"]), Some(0));
}

#[test]
fn tables_with_dummy_reflectances_give_visible_and_solar_in_one_file() {
    let folder = tempfile::tempdir().unwrap();
    // The transmittances at 0, 60 and 90° and the dummies of a PDLC study's table.
    let table = |scale: f64| {
        let row = |(theta, share): (u32, f64)| format!("{theta}.0,{},{},0.2,0.2\n", 0.519 * scale * share, 0.042 * scale * share);
        format!(",Ts,Td,Rs,Rd\n{}", [(0, 1.0), (60, 0.8), (90, 0.0)].map(row).concat())
    };
    std::fs::write(folder.path().join("visible.csv"), table(1.0)).unwrap();
    std::fs::write(folder.path().join("solar.csv"), table(0.8)).unwrap();
    let make = |more: &[&str]| {
        let given = ["bsdf", "isotropic", "visible.csv", "--solar", "solar.csv", "--basis", "quarter", "-o", "film.xml"];
        lucarne(folder.path(), &[&given, more].concat())
    };
    let read = || bsdf::read(&folder.path().join("film.xml"), &mut Warnings::new()).unwrap();
    let reflected = |blocks: &bsdf::Blocks| blocks.reflection_front.as_ref().unwrap().direct_hemispherical_at(0.0);
    let dummy = make(&[]);
    assert!(dummy.status.success() && text(&dummy.stderr).contains("as dummy values are"), "{}", text(&dummy.stderr));
    assert!((reflected(&read().visible) - 0.4).abs() < 1e-3);
    let real = make(&["--reflectance", ".08,.03", "--solar-reflectance", ".10,.04", "--solar-back", ".2,.04"]);
    assert!(real.status.success() && !text(&real.stderr).contains("warning"), "{}", text(&real.stderr));
    let film = read();
    for (blocks, transmitted, front, back) in [(&film.visible, 0.561, 0.11, 0.11), (&film.solar, 0.561 * 0.8, 0.14, 0.24)] {
        let at_normal = |component| blocks.get(component).unwrap().direct_hemispherical_at(0.0);
        let found = [bsdf::Component::TransmissionFront, bsdf::Component::ReflectionFront, bsdf::Component::ReflectionBack].map(at_normal);
        // The first bin is the mean over 0…6.5°.
        assert!(found.iter().zip([transmitted, front, back]).all(|(a, b)| (a - b).abs() < 5e-3), "{found:?}");
    }
    assert!(!make(&["--reflectance", ".08"]).status.success());
    assert!(!make(&["--back", ".08,.03"]).status.success(), "--back without values of the front");
}

#[test]
fn lists_of_isotropic_values_have_their_length_and_their_band() {
    let folder = tempfile::tempdir().unwrap();
    let visible = ["bsdf", "isotropic", "--normal", ".519,.042,.119,.030"];
    let solar = ["--solar-normal", ".4909,.043,.100,.0256"];
    let run = |more: &[&str], out: &str| lucarne(folder.path(), &[&visible[..], more, &["-o", out]].concat());
    for (more, wanted) in [
        (&["--back", ".5"][..], "--back: 2 values are needed, Rs,Rd, but there are 1"),
        (&["--back", ".5,.1,.2"], "--back: 2 values"),
        (&["--solar-normal", ".5,.1,.2"], "--solar-normal: 4 values are needed, Ts,Td,Rs,Rd, but there are 3"),
        (&[&solar[..], &["--solar-back", ".5"]].concat(), "--solar-back: 2 values"),
        (&["--solar-back", ".1,.1"], "--solar-normal"),
    ] {
        let output = run(more, "x.xml");
        assert!(!output.status.success() && text(&output.stderr).contains(wanted), "{more:?}: {}", text(&output.stderr));
    }
    assert!(text(&lucarne(folder.path(), &["bsdf", "isotropic", "--normal", ".5,.1"]).stderr).contains("4 values are needed"));
    let back = |more: &[&str]| {
        let output = run(&[&["--back", ".107,.027"], &solar[..], more].concat(), "b.xml");
        assert!(output.status.success(), "{}", text(&output.stderr));
        let bsdf = read(&folder.path().join("b.xml"));
        let normal = |b: &bsdf::Blocks, c: Component| b.get(c).unwrap().direct_hemispherical_at(0.0);
        [
            normal(&bsdf.visible, Component::ReflectionBack),
            normal(&bsdf.solar, Component::ReflectionFront),
            normal(&bsdf.solar, Component::ReflectionBack),
        ]
    };
    // The bin around the normal is 5° wide, over which the model changes little.
    let near = |found: [f64; 3], wanted: [f64; 3]| found.iter().zip(wanted).all(|(f, w)| (f - w).abs() < 1e-3);
    let (without, with) = (back(&[]), back(&["--solar-back", ".09,.02"]));
    assert!(near(without, [0.134, 0.1256, 0.1256]), "{without:?}");
    assert!(near(with, [0.134, 0.1256, 0.11]), "{with:?}");
}

/// The sample blind as text.
fn sound() -> String {
    fs::read_to_string(samples().join("venetian.xml")).unwrap()
}

#[test]
fn faulty_files_get_one_clear_error_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let data = sound();
    let start = data.find("<ScatteringData>").unwrap() + "<ScatteringData>\n".len();
    let first_row = &data[start..start + data[start..].find('\n').unwrap() + 1];
    let first = first_row.split(',').next().unwrap();
    let ring = data.find("<AngleBasisBlock>").unwrap();
    let ring_end = data[ring..].find("</AngleBasisBlock>").unwrap() + ring + "</AngleBasisBlock>".len();
    let own_basis = data.replace("LBNL/Klems Quarter", "own");
    let missing_angles = format!("{}{}", &own_basis[..own_basis.find("<AngleBasisBlock>").unwrap()], {
        let from = own_basis.find("</AngleBasisBlock>").unwrap() + "</AngleBasisBlock>".len();
        &own_basis[from..]
    });
    let bomb = "<?xml version=\"1.0\"?><!DOCTYPE b [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]><WindowElement>&b;</WindowElement>";
    let cases: [(&str, String, &[&str]); 12] = [
        ("a row too few", data.replacen(first_row, "", 1), &["values", "41"]),
        ("a row too many", data.replacen(first_row, &first_row.repeat(2), 1), &["values", "41"]),
        ("nan", data.replacen(first_row, &first_row.replacen(first, "nan", 1), 1), &["file.xml:", "finite"]),
        ("infinite", data.replacen(first_row, &first_row.replacen(first, "1e999", 1), 1), &["file.xml:", "finite"]),
        ("words", data.replacen(first_row, &first_row.replacen(first, "much", 1), 1), &["file.xml:", "'much' is not a number"]),
        ("missing angles", missing_angles, &["not a division of the hemisphere"]),
        ("an entity bomb", bomb.to_string(), &["document type"]),
        ("deep nesting", format!("<WindowElement>{}", "<a>".repeat(100_000)), &["nested deeper"]),
        ("a tag without end", format!("<WindowElement><{}", "a".repeat(4 << 20)), &["longer than"]),
        ("half a file", data[..data.len() / 2].to_string(), &["file.xml:"]),
        ("no file at all", String::new(), &["not a BSDF file"]),
        ("something else", "<?xml version=\"1.0\"?><svg></svg>".to_string(), &["not a BSDF file"]),
    ];
    assert!(ring_end > ring);
    testing::measured("faulty-input", &format!("{} files, one error each", cases.len()), "each");
    for (name, content, words) in &cases {
        let path = folder.path().join("file.xml");
        fs::write(&path, content).unwrap();
        let output = lucarne(folder.path(), &["bsdf", "check", "file.xml"]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {message}{}", text(&output.stdout));
        assert!(message.contains("file.xml") && words.iter().all(|w| message.contains(w)), "{name}: {message}");
        assert_eq!(message.matches("error:").count(), 1, "{name}: {message}");
        assert!(message.len() < 1000, "{name}: {} bytes", message.len());
    }
    // Decimal commas of another locale are understood, and said so; negative lobes are a finding.
    let numbers = |edit: &dyn Fn(f64) -> String| {
        let mut out = String::new();
        let mut rest = data.as_str();
        while let Some(at) = rest.find("<ScatteringData>") {
            let (head, tail) = rest.split_at(at + "<ScatteringData>".len());
            let end = tail.find("</ScatteringData>").unwrap();
            out += head;
            out += &tail[..end]
                .split([',', '\n', ' ', '\t'])
                .filter_map(|w| w.parse::<f64>().ok())
                .map(|v| edit(v) + "\n")
                .collect::<String>();
            rest = &tail[end..];
        }
        out + rest
    };
    fs::write(folder.path().join("commas.xml"), numbers(&|v| format!("{v:.6}").replace('.', ","))).unwrap();
    let output = lucarne(folder.path(), &["bsdf", "info", "commas.xml"]);
    assert!(output.status.success() && text(&output.stderr).contains("commas are read as decimal points"), "{}", text(&output.stderr));
    let of = |name: &str| read(&folder.path().join(name)).visible.get(Component::TransmissionFront).unwrap().hemispherical();
    assert!((of("commas.xml") - read(&samples().join("venetian.xml")).visible.transmission_front.unwrap().hemispherical()).abs() < 1e-4);
    fs::write(folder.path().join("lobes.xml"), numbers(&|v| if v < 0.05 { "-0.02".into() } else { v.to_string() })).unwrap();
    let output = lucarne(folder.path(), &["bsdf", "check", "lobes.xml"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).lines().any(|l| l.starts_with("FAULT positivity")), "{}", text(&output.stdout));
}

#[test]
#[cfg(unix)]
fn endless_input_ends_in_an_error_within_bounded_memory() {
    let head = "<?xml version=\"1.0\"?><WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure>\
                </DataDefinition><WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock><ScatteringData>";
    let tree = head.replace("Columns", "TensorTree4");
    const GIBIBYTE: usize = 1 << 30;
    let cases = [
        ("<WindowElement>", "<a>"),
        (head, "0.25, "),
        (head, "9"),
        (tree.as_str(), "{"),
        (tree.as_str(), " 1 "),
        ("<WindowElement><Optical><Layer><Material><Name>", "name "),
        ("<WindowElement><!-- ", "comment "),
        ("", "no xml at all "),
        ("<WindowElement a=\"", "attribute "),
    ];
    for (start, endless) in cases {
        // 1 GiB of address space, and input that never ends.
        let mut child = Command::new("sh")
            .args(["-c", "ulimit -v 1048576; exec \"$0\" bsdf check /dev/stdin", env!("CARGO_BIN_EXE_lucarne")])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut input = child.stdin.take().unwrap();
        let block = endless.repeat((1 << 16) / endless.len());
        let mut sent = input.write_all(start.as_bytes()).map(|()| start.len());
        let mut bytes = 0usize;
        while sent.is_ok() {
            sent = input.write_all(block.as_bytes()).map(|()| block.len());
            bytes += block.len();
            assert!(bytes < GIBIBYTE, "{start}…{endless}: still reading after 1 GiB");
        }
        drop(input);
        let output = child.wait_with_output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{start}…{endless}: {message}");
        assert!(message.contains("error:") && !message.contains("panicked") && message.len() < 1000, "{start}…{endless}: {message}");
    }
    let held = format!("below {} GiB", GIBIBYTE >> 30);
    testing::measured("endless-input", &format!("{} inputs, one error each", cases.len()), &held);
}

/// A plate with a square hole of half its width, as Radiance's text and as glTF.
fn plate(folder: &Path) {
    let bars = [[0.0, 0.25, 0.0, 1.0], [0.75, 1.0, 0.0, 1.0], [0.25, 0.75, 0.0, 0.25], [0.25, 0.75, 0.75, 1.0]];
    let corners = bars.map(|[x0, x1, y0, y1]| [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]);
    let mut rad = String::from("void plastic grey 0 0 5 .5 .5 .5 0 0\n");
    let (mut bytes, mut indices) = (Vec::new(), Vec::new());
    for (k, quad) in corners.iter().enumerate() {
        let words = quad.map(|[x, y]| format!("{x} {y} -0.1")).join(" ");
        rad += &format!("grey polygon bar{k} 0 0 12 {words}\n");
        for [x, y] in quad {
            bytes.extend([*x as f32, *y as f32, -0.1f32].into_iter().flat_map(f32::to_le_bytes));
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|i| (4 * k + i) as u16));
    }
    let vertices = bytes.len();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    fs::write(folder.join("plate.rad"), rad).unwrap();
    fs::write(folder.join("plate.bin"), &bytes).unwrap();
    let gltf = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0}}]}}],
        "materials": [{{"extras": {{"radiance": "void plastic grey 0 0 5 .5 .5 .5 0 0"}}}}],
        "buffers": [{{"uri": "plate.bin", "byteLength": {}}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {vertices}}}, {{"buffer": 0, "byteOffset": {vertices}, "byteLength": {}}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 16, "type": "VEC3", "min": [0, 0, -0.1], "max": [1, 1, -0.1]}},
                      {{"bufferView": 1, "componentType": 5123, "count": 24, "type": "SCALAR"}}]}}"#,
        bytes.len(),
        2 * indices.len()
    );
    fs::write(folder.join("plate.gltf"), gltf).unwrap();
}

#[test]
fn a_device_in_gltf_is_the_same_as_in_radiances_text() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    plate(folder.path());
    for name in ["plate.rad", "plate.gltf"] {
        let arguments = ["bsdf", "generate", name, "--basis", "quarter", "-c", "512", "--name", "plate", "-o"];
        let output = lucarne(folder.path(), &[&arguments[..], &[&format!("{name}.xml")]].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let [rad, gltf] = ["plate.rad.xml", "plate.gltf.xml"].map(|n| read(&folder.path().join(n)));
    assert!(rad.visible == gltf.visible, "the same bits");
    // A quarter is open; the rest reflects half.
    let t = matrix(&rad, Component::TransmissionFront);
    assert!((t.hemispherical() - 0.25).abs() < 2e-3, "{}", t.hemispherical());
    assert!((matrix(&rad, Component::ReflectionBack).hemispherical() - 0.375).abs() < 2e-3);
}

#[test]
fn slats_may_be_darker_for_the_sun() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &str| {
        let slats = format!("width=25mm,spacing=20mm,angle=20,reflectance=0.7{more}");
        lucarne(folder.path(), &["bsdf", "generate", "--venetian", &slats, "--basis", "quarter", "-c", "512", "-o", "blind.xml"])
    };
    assert!(run("").status.success());
    let visible = read(&folder.path().join("blind.xml"));
    assert!(visible.solar.is_empty());
    let output = run(",solar_reflectance=0.4");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let both = read(&folder.path().join("blind.xml"));
    assert!(both.visible == visible.visible);
    for component in Component::ALL {
        let [v, s] = [&both.visible, &both.solar].map(|b| b.get(component).unwrap().hemispherical());
        assert!(s < v && s > 0.3 * v, "{component:?}: {v} {s}");
    }
    assert!(!text(&run(",solar_reflectance=1.4").stderr).is_empty());
}

#[test]
#[cfg(unix)]
fn an_interrupted_generation_goes_on_to_the_same_bits() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    plate(folder.path());
    let arguments =
        |output| ["bsdf", "generate", "plate.rad", "--basis", "half", "-c", "65536", "--batches", "32", "--name", "plate", "-o", output];
    let whole = lucarne(folder.path(), &arguments("whole.xml"));
    assert!(whole.status.success(), "{}", text(&whole.stderr));
    let mut stopped_on_the_way = false;
    for wait in [1500u64, 3000, 6000, 12_000] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_lucarne"))
            .args(arguments("again.xml"))
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let code = child.wait().unwrap().code();
        if folder.path().join("again.xml").exists() {
            break;
        }
        assert_eq!(code, Some(4));
        stopped_on_the_way |= folder.path().join("again.xml.resume").exists();
        if stopped_on_the_way {
            break;
        }
    }
    let again = lucarne(folder.path(), &arguments("again.xml"));
    assert!(again.status.success(), "{}", text(&again.stderr));
    if stopped_on_the_way {
        assert!(text(&again.stderr).contains("going on after"), "{}", text(&again.stderr));
    } else {
        testing::note(&"half of it: the generation was done before it could be stopped");
    }
    let data = |name: &str| {
        let content = fs::read_to_string(folder.path().join(name)).unwrap();
        content[content.find("<WindowElement ").unwrap()..].to_string()
    };
    assert!(data("whole.xml") == data("again.xml"), "the same bits");
    assert!(!folder.path().join("again.xml.resume").exists());
}

fn radiance() -> Option<PathBuf> {
    testing::radiance_folder().map(Path::to_path_buf)
}

/// Runs a command and gives its standard output and its processor time, in seconds.
fn timed(folder: &Path, radiance: &Path, words: &[&str]) -> (Vec<u8>, f64) {
    let path = format!("{}:{}", radiance.join("bin").display(), std::env::var("PATH").unwrap_or_default());
    let output = Command::new("bash")
        .args(["-c", "TIMEFORMAT='cpu %U'; time \"$@\" 2>messages", "timed"])
        .args(words)
        .current_dir(folder)
        .env("PATH", path)
        .env("RAYPATH", format!(".:{}", radiance.join("lib").display()))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let messages = || fs::read_to_string(folder.join("messages")).unwrap_or_default();
    assert!(output.status.success(), "{words:?}: {}", messages());
    let seconds = text(&output.stderr).trim().trim_start_matches("cpu ").parse().unwrap();
    (output.stdout, seconds)
}

/// Transmission of light from the outside as genBSDF has it made by `rfluxmtx`: `[outgoing][incident]`, 1/sr.
fn genbsdf(folder: &Path, radiance: &Path, samples: &str) -> (Vec<f64>, f64) {
    let words = [
        "rfluxmtx",
        "-fd",
        "-n",
        "1",
        "-w",
        "-ab",
        "5",
        "-ad",
        "16",
        "-lw",
        "1e-3",
        "-c",
        samples,
        "sender.rad",
        "receiver.rad",
        "device.rad",
    ];
    let (bytes, seconds) = timed(folder, radiance, &words);
    let start = bytes.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
    let values: Vec<f64> = bytes[start..].chunks_exact(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect();
    let components = values.len() / (145 * 145);
    let basis = lucarne::bins::AngleBasis::from(lucarne::bins::KlemsBasis::Full);
    let entry = |o: usize, i: usize| values[(i * 145 + o) * components] / basis.projected_solid_angle(o);
    ((0..145 * 145).map(|k| entry(k / 145, k % 145)).collect(), seconds)
}

#[test]
fn generate_meets_genbsdf_on_the_tutorials_blinds_in_a_twentieth_of_its_time() {
    let Some(shared) = testing::shared() else { return };
    let bsdfs = shared.join("data/tutorial_room/bsdf");
    let Some(radiance) = radiance() else { return };
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    fs::copy(bsdfs.join("blinds_device.rad"), folder.path().join("device.rad")).unwrap();
    // The device's box, see getbbox; light starts just before it.
    let [x, y, z] = [6.096, 1.528_88, -0.048_602];
    let sender =
        format!("#@rfluxmtx u=-Y h=-kf\nvoid glow send 0 0 4 1 1 1 0\nsend polygon face 0 0 12 0 0 {z} 0 {y} {z} {x} {y} {z} {x} 0 {z}\n");
    fs::write(folder.path().join("sender.rad"), sender).unwrap();
    fs::write(folder.path().join("receiver.rad"), "#@rfluxmtx u=-Y h=-kf\nvoid glow room 0 0 4 1 1 1 0\nroom source r 0 0 4 0 0 1 180\n")
        .unwrap();
    // Compiled kernels go to the driver's cache first.
    let program = env!("CARGO_BIN_EXE_lucarne");
    let generate = |samples: &'static str| {
        [
            program,
            "bsdf",
            "generate",
            "device.rad",
            "--ab",
            "5",
            "--reciprocity",
            "keep",
            "-c",
            samples,
            "--standard-error",
            "e.mtx",
            "-o",
            "ours.xml",
        ]
    };
    timed(folder.path(), &radiance, &generate("16"));
    let (_, ours_seconds) = timed(folder.path(), &radiance, &generate("8192"));
    // Two runs with different rays show genBSDF's noise.
    let (first, first_seconds) = genbsdf(folder.path(), &radiance, "500");
    let (second, second_seconds) = genbsdf(folder.path(), &radiance, "512");
    let rms = |values: &mut dyn Iterator<Item = f64>| (values.map(|v| v * v).sum::<f64>() / 21_025.0).sqrt();
    let theirs_error = rms(&mut first.iter().zip(&second).map(|(a, b)| a - b)) / 2f64.sqrt();
    let bytes = fs::read(folder.path().join("e.mtx")).unwrap();
    let start = bytes.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
    let ours_error = rms(&mut bytes[start..].chunks_exact(4).take(145 * 145).map(|c| f64::from(f32::from_le_bytes(c.try_into().unwrap()))));
    let ours = read(&folder.path().join("ours.xml"));
    let reference = read(&bsdfs.join("blinds_correct_klems.xml"));
    const HEMISPHERICAL: f64 = 0.002;
    const DEVIATION: f64 = 3.0;
    const SPEED: f64 = 20.0;
    let mut pairs = Vec::new();
    for component in [Component::TransmissionFront, Component::TransmissionBack] {
        let [a, b] = [&ours, &reference].map(|f| matrix(f, component).hemispherical());
        println!("{}: hemispherical {a:.5}, genBSDF at -c 4000 {b:.5}", component.xml_name());
        assert!((a - b).abs() < HEMISPHERICAL, "{component:?}: {a} {b}");
        pairs.push(format!("{a:.4} and {b:.4}"));
    }
    let mean = first.iter().zip(&second).map(|(a, b)| (a + b) / 2.0);
    let deviation = rms(&mut matrix(&ours, Component::TransmissionFront).values().iter().zip(mean).map(|(a, b)| a - b));
    let combined = ours_error.hypot(theirs_error / 2f64.sqrt());
    println!(
        "RMS deviation of entries {deviation:.4}/sr, combined standard error {combined:.4}/sr ({ours_error:.4} and {theirs_error:.4} a run)"
    );
    assert!(deviation < DEVIATION * combined, "{deviation} {combined}");
    let found = format!(
        "hemispherical T {} (front), {} (back); RMS deviation of entries {} × the combined standard error",
        pairs[0],
        pairs[1],
        testing::short(deviation / combined)
    );
    testing::measured("generate-genbsdf", &found, &format!("{HEMISPHERICAL}; {DEVIATION} ×"));
    // Ours are both sides, transmission and reflection; theirs is one of two passes.
    let speed = (first_seconds + second_seconds) * theirs_error.powi(2) / (ours_seconds * ours_error.powi(2));
    println!("processor time {ours_seconds:.1} s; genBSDF's {first_seconds:.1} s a side: {speed:.0} × as fast at equal error");
    assert!(speed > SPEED, "{speed}");
    testing::measured("generate-speed", &format!("{speed:.0} × as fast"), &format!("{SPEED} ×"));
}

#[test]
fn radiance_evaluates_converted_trees_as_this_program_does() {
    let Some(radiance) = radiance() else { return };
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["bsdf", "convert", "venetian.xml", "--to", "t4:4", "-o", "tree.xml"];
    fs::copy(samples().join("venetian.xml"), folder.path().join("venetian.xml")).unwrap();
    assert!(lucarne(folder.path(), &arguments).status.success());
    let [tree, matrix] = ["tree.xml", "venetian.xml"].map(|n| read(&folder.path().join(n)).visible.transmission_front.unwrap());
    assert!((tree.hemispherical() - matrix.hemispherical()).abs() < 1e-3);
    let unit = |x: f64, y: f64| glam::DVec3::new(x, y, (1.0 - x * x - y * y).sqrt());
    let pairs = [
        (unit(0.717, -0.231), unit(0.869, -0.29)),
        (unit(-0.381, 0.247), unit(-0.401, 0.257)),
        (unit(0.718, 0.126), unit(-0.545, -0.133)),
        (unit(-0.802, 0.237), unit(-0.822, 0.247)),
        (unit(0.31, -0.62), unit(0.33, -0.6)),
        (unit(0.05, 0.04), unit(0.06, 0.03)),
    ];
    const OF_VALUE: f64 = 2e-3;
    const PER_STERADIAN: f64 = 1e-3;
    let mut worst = 0.0f64;
    for (out, incident) in pairs {
        let (s, o) = (-incident, out);
        let scene = format!(
            "void BSDF m 6 0 tree.xml 0 1 0 . 0 0\nm polygon p 0 0 12 -1 -1 0 1 -1 0 1 1 0 -1 1 0\nvoid light l 0 0 3 1e6 1e6 1e6\n\
             l source s 0 0 4 {} {} {} .1\n",
            s.x, s.y, s.z
        );
        fs::write(folder.path().join("scene.rad"), scene).unwrap();
        fs::write(folder.path().join("ray"), format!("{} {} {} {} {} {}\n", o.x, o.y, o.z, -o.x, -o.y, -o.z)).unwrap();
        let script = "oconv -f scene.rad > scene.oct && rtrace -h -ab 0 -ss 0 -ds 0 -dj 0 scene.oct < ray";
        let (answer, _) = timed(folder.path(), &radiance, &["sh", "-c", script]);
        let luminance: f64 = text(&answer).split_whitespace().nth(1).unwrap().parse().unwrap();
        // A source of 0.1° and 10⁶ W/sr/m², seen at the cosine of incidence.
        let solid_angle = std::f64::consts::TAU * (1.0 - 0.05f64.to_radians().cos());
        let theirs = luminance / (1e6 * solid_angle * incident.z);
        let ours = tree.evaluate(out, incident);
        println!("{ours:.5} {theirs:.5}");
        assert!((ours - theirs).abs() < OF_VALUE * ours + PER_STERADIAN, "{out} {incident}: {ours} {theirs}");
        worst = worst.max((ours - theirs).abs() / (OF_VALUE * ours + PER_STERADIAN));
    }
    let held = format!("{} and {PER_STERADIAN}/sr", testing::percent(OF_VALUE));
    testing::measured("trees-in-radiance", &format!("at most {} of the bound", testing::percent(worst)), &held);
}

#[test]
fn a_folder_of_iea_21_measurements_is_converted() {
    let folder = tempfile::tempdir().unwrap();
    let measured = folder.path().join("measured");
    fs::create_dir(&measured).unwrap();
    let rows: String = (90..=180)
        .step_by(5)
        .flat_map(|theta| (0..if theta == 180 { 1 } else { 72 }).map(move |k| format!("{}\t{theta}\t0.1\n", 5 * k)))
        .collect();
    for theta in (0..90).step_by(12) {
        let header = format!("#material: film\n#Isym = 1\n#phi_1: 0°\n#theta_1: {theta}°\n");
        fs::write(measured.join(format!("film_{theta}.txt")), header + &rows + "END\n").unwrap();
    }
    fs::write(measured.join("notes.txt"), "not a measurement\n").unwrap();
    let output = lucarne(folder.path(), &["bsdf", "convert", "measured", "--to", "klems:full", "-o", "film.xml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let film = read(&folder.path().join("film.xml"));
    let t = matrix(&film, Component::TransmissionFront);
    assert!(film.name == "film" && t.values().iter().all(|v| (v - 0.1).abs() < 1e-8));
    fs::remove_file(measured.join("film_24.txt")).unwrap();
    let output = lucarne(folder.path(), &["bsdf", "convert", "measured", "--to", "klems:full", "-o", "film.xml"]);
    assert!(text(&output.stderr).contains("12 of 145 incident directions are missing"), "{}", text(&output.stderr));
}
