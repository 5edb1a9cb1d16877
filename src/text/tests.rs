//! Every reader of text, given the same text in other clothes.

use super::*;
use crate::bsdf;
use crate::camera::View;
use crate::error::Warnings;
use crate::matrix;
use crate::scene::{self, points};
use crate::simulate::project::Project;
use crate::weather::Weather;
use std::path::PathBuf;

/// A reader: the name of its file, good contents, and what the file comes to, as text.
struct Reader {
    file: &'static str,
    good: String,
    read: fn(&Path) -> Result<String>,
}

fn shown<T: std::fmt::Debug>(value: T) -> String {
    format!("{value:?}")
}

fn readers() -> Vec<Reader> {
    let wea = "place Zürich_CHE\nlatitude 47.4\nlongitude -8.5\ntime_zone -15\nsite_elevation 400\nweather_data_file_units 1\n3 21 12.5 500 150\n";
    let epw = format!(
        "LOCATION,Zürich,-,CHE,x,1,47.4,8.5,1,400\nDATA PERIODS,1,1,Data,Sunday,3/21,3/21\n1999,3,21,13,60,x,10,5.0,70,101300,0,0,300,700,500,150{}\n",
        ",0".repeat(19)
    );
    let spectrum: String = (0..=22).map(|i| format!("{:.1}\t0.8\t0.08\t0.08\n", 0.3 + 0.1 * f64::from(i))).collect();
    let project = "# Büro\n[weather]\nfile = \"a.wea\"\n[scene]\nfiles = [\"r.rad\"]\n[[window]]\nname = \"süd\"\nsurface = \"w.rad\"\nbsdf = \"b.xml\"\n[[sensors]]\nname = \"desk\"\npoints = \"p.txt\"\n";
    let reader = |file, good: &str, read| Reader { file, good: good.to_string(), read };
    vec![
        reader("p.txt", "# Büro\n1.5\t2 0.8 0 0 1\n2.5 2 0.8 0 0 1\n", |p| points::read_points(p).map(shown)),
        reader(
            "room.rad",
            "# Büro\nvoid plastic wand_grün\n0\n0\n5 .5 .5 .5 0 0\nwand_grün polygon p\n0\n0\n9 0 0 0 1 0 0 0 1 0\n",
            |p| scene::read_scene(&[p.to_path_buf()], Path::new(""), &mut Warnings::new()).map(shown),
        ),
        reader("window.rad", "# Büro\n#@rfluxmtx h=kf u=+Z\nsüd polygon p\n0\n0\n9 0 0 0 1 0 0 0 0 1\n", |p| {
            scene::read_windows(p, Path::new(""), &mut Warnings::new()).map(shown)
        }),
        reader("eye.vf", "# Büro\nrvu -vta -vp 1 2\t1.2 -vd 0 1 0 -vh 180 -vv 180\n", |p| View::read(p).map(shown)),
        reader("a.wea", wea, |p| Weather::read(p, &mut Warnings::new()).map(shown)),
        reader("a.epw", &epw, |p| Weather::read(p, &mut Warnings::new()).map(shown)),
        reader("m.mtx", "#?RADIANCE\nBüro\nNROWS=1\nNCOLS=2\nNCOMP=1\nFORMAT=ascii\n\n1.5 2\n", |p| {
            matrix::file::read_matrix(p).map(|m| shown(m.matrix.data()))
        }),
        reader("project.toml", project, |p| Project::read(p).map(|p| shown((&p.windows[0].name, &p.sensors)))),
        reader("glass.dat", &format!("{{ Product Name }} Größe\n{{ Thickness }} 4\n{spectrum}"), |p| {
            bsdf::spectrum::read_pane(p).map(|p| shown((p.name, p.thickness)))
        }),
        reader("table.dat", "# Büro\n0 .6 .1 .08 .02\n30\t.6 .1 .08 .02\n60 .5 .1 .1 .02\n80 .2 .1 .5 .02\n", |p| {
            let text = super::read(p, "a table of angular values")?;
            bsdf::isotropic::AngularTable::parse(&text, &mut Warnings::new()).map(shown).map_err(|e| e.file(p))
        }),
    ]
}

/// A folder with the files that the project names.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.wea", "r.rad", "w.rad", "b.xml", "p.txt"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    folder
}

fn in_file(folder: &Path, reader: &Reader, bytes: &[u8]) -> Result<String> {
    let path: PathBuf = folder.join(reader.file);
    std::fs::write(&path, bytes).unwrap();
    let result = (reader.read)(&path);
    // Other readers' files are names of the project's.
    std::fs::write(&path, "").unwrap();
    result
}

#[test]
fn every_reader_takes_marks_line_ends_and_encodings() {
    let folder = folder();
    for reader in readers() {
        let name = reader.file;
        let plain = in_file(folder.path(), &reader, reader.good.as_bytes()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let crlf = reader.good.replace('\n', "\r\n");
        let latin: Vec<u8> = reader.good.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        let units: Vec<u16> = reader.good.encode_utf16().collect();
        let little: Vec<u8> = [0xfeff].iter().chain(&units).flat_map(|u: &u16| u.to_le_bytes()).collect();
        let big: Vec<u8> = [0xfeff].iter().chain(&units).flat_map(|u: &u16| u.to_be_bytes()).collect();
        let forms: [(&str, Vec<u8>); 6] = [
            ("byte order mark", [b"\xef\xbb\xbf", reader.good.as_bytes()].concat()),
            ("CR LF", crlf.clone().into_bytes()),
            ("both", [b"\xef\xbb\xbf", crlf.as_bytes()].concat()),
            ("Latin-1", latin),
            ("UTF-16 LE", little),
            ("UTF-16 BE", big),
        ];
        for (form, bytes) in forms {
            // The header of a matrix may be followed by gigabytes of numbers: it stays a stream of bytes.
            let result = in_file(folder.path(), &reader, &bytes);
            if name == "m.mtx" && form.starts_with("UTF-16") {
                assert!(result.unwrap_err().to_string().contains("UTF-16"));
                continue;
            }
            assert_eq!(result.unwrap_or_else(|e| panic!("{name}, {form}: {e}")), plain, "{name}, {form}");
        }
    }
}

#[test]
fn every_reader_calls_a_wrong_file_by_its_name() {
    let folder = folder();
    let mut all = readers();
    let read_bsdf: fn(&Path) -> Result<String> = |p| bsdf::read(p, &mut Warnings::new()).map(|b| b.name);
    all.push(Reader { file: "b.xml", good: String::new(), read: read_bsdf });
    let read_gltf: fn(&Path) -> Result<String> =
        |p| scene::gltf::read(p, &scene::gltf::Options::default(), &mut Warnings::new()).map(shown);
    all.push(Reader { file: "room.gltf", good: String::new(), read: read_gltf });
    for reader in all {
        for (bytes, words) in [
            (&b"<!DOCTYPE html>\n<html><body>1 2 3</body></html>"[..], "a web page (HTML)"),
            (b"\xef\xbb\xbf\r\n <HTML lang=\"de\">", "a web page (HTML)"),
            (b"<?xml version=\"1.0\"?>\n<!-- saved -->\n<!doctype HTML>\n<html>", "a web page (HTML)"),
            (b"PK\x03\x04\x14\0\0\0", "a zip archive"),
            (b"\x1f\x8b\x08\0\0\0\0\0", "a gzip archive"),
            (b"%PDF-1.7\n%\xe2\xe3", "a PDF document"),
            (b"\xd0\xcf\x11\xe0\xa1\xb1", "a spreadsheet"),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\n", "a pointer of Git LFS"),
            (b"#?RADIANCE\npabopto2bsdf a.dat b.dat\nNAME=x\nFORMAT=BSDF_RBFmesh\n\n\x01\x02\0\0", "an interpolant of measurements (.sir)"),
            (b"#sample_name \"x\"\n#format: theta phi DSF\n#intheta 0\n#inphi 0\n170 0 0.3\n", "a table of a goniophotometer"),
        ] {
            let error = in_file(folder.path(), &reader, bytes).expect_err(reader.file).to_string();
            assert!(error.contains(words), "{}: {error}", reader.file);
            assert!(error.contains(reader.file) && error.contains("help:"), "{error}");
            assert!(!error.contains("DOCTYPE") && !error.contains(&*folder.path().join("elsewhere").to_string_lossy()), "{error}");
        }
    }
}

#[test]
fn decimal_commas_are_read_in_tables_and_named_elsewhere() {
    let folder = folder();
    for reader in readers() {
        let comma = reader.good.replace("1.5", "1,5").replace("12.5", "12,5").replace(".5 .5 .5", "0,5 0,5 0,5").replace("1.2 ", "1,2 ");
        if !["p.txt", "a.wea", "room.rad", "eye.vf", "m.mtx"].contains(&reader.file) {
            continue;
        }
        let plain = in_file(folder.path(), &reader, reader.good.as_bytes()).unwrap();
        match in_file(folder.path(), &reader, comma.replace("0.8", "0,8").replace("2.5", "2,5").as_bytes()) {
            Ok(found) => assert!(found == plain && ["p.txt", "a.wea"].contains(&reader.file), "{}: {found}", reader.file),
            Err(e) => {
                let e = e.to_string();
                let named = e.contains("write a point in place of the comma");
                assert!(named && !["p.txt", "a.wea"].contains(&reader.file), "{}: {e}", reader.file);
            }
        }
    }
    // A column of numbers below one is unambiguous; thousands are not.
    let split = |line| words(line).map(|w| w.join(" ")).map_err(|e| e.to_string());
    assert_eq!(split("0,300;0,8;0,08;0,08").unwrap(), "0.300 0.8 0.08 0.08");
    assert_eq!(split("0,300\t0,800").unwrap(), "0.300 0.800");
    assert_eq!(split("1e-3,2,-3").unwrap(), "1e-3 2 -3");
    assert_eq!(split("1,5e-3 2").unwrap(), "1.5e-3 2");
    assert_eq!(split("1, 2, 3").unwrap(), "1 2 3");
    assert!(split("1,250 12").unwrap_err().contains("may mean 1.250 or 1250"));
    assert!(split("").unwrap().is_empty() && split(" ;, ").unwrap().is_empty());
}

#[test]
fn bytes_of_older_systems_become_their_characters() {
    assert_eq!(decode(b"Z\xfcrich \x80 \x96", "x").unwrap(), "Zürich € –");
    assert_eq!(decode("Zürich €".as_bytes(), "x").unwrap(), "Zürich €");
    assert!(matches!(decode(b"plain", "x").unwrap(), Cow::Borrowed("plain")));
    let zero = decode(b"a\nb\0c", "a points file").unwrap_err().to_string();
    assert!(zero.starts_with("line 2: this is binary data, not a points file"), "{zero}");
    assert_eq!(decode(b"", "x").unwrap(), "");
    assert_eq!(decode(b"\xff\xfea", "x").unwrap(), "");
    // A comment about pages is no page.
    assert!(Other::of(b"# <html>\n1 2 3").is_none() && Other::of(b"# format: theta phi\n").is_some());
}
