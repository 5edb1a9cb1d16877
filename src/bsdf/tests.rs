//! Reading files and the transmission matrix: against hand-made files, hostile input and Radiance.

use super::*;
use crate::bins::KlemsBasis;
use crate::error::{Result, Warnings};
use crate::matrix::Matrix;
use crate::matrix::file::{Format, read_matrix_from, write_matrix};
use crate::testing;
use std::path::Path;

/// A file with blocks of (wavelength, direction, column basis, row basis, data).
fn xml(structure: &str, blocks: &[(&str, &str, &str, &str, String)]) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<WindowElement xmlns=\"http://windows.lbl.gov\">\n\
         <WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical>\n<Layer>\n<Material>\n\
         <Name>A &amp; B</Name><Manufacturer>nobody</Manufacturer>\n<Thickness unit=\"millimeter\">12,5</Thickness>\n</Material>\n\
         <DataDefinition>\n<IncidentDataStructure>{structure}</IncidentDataStructure>\n</DataDefinition>\n"
    );
    for (wavelength, direction, columns, rows, data) in blocks {
        text += &format!(
            "<WavelengthData>\n<LayerNumber>System</LayerNumber>\n<Wavelength unit=\"Integral\">{wavelength}</Wavelength>\n\
             <WavelengthDataBlock>\n<WavelengthDataDirection>{direction}</WavelengthDataDirection>\n\
             <ColumnAngleBasis>{columns}</ColumnAngleBasis>\n<RowAngleBasis>{rows}</RowAngleBasis>\n\
             <ScatteringDataType>BTDF</ScatteringDataType>\n<ScatteringData>\n{data}\n</ScatteringData>\n\
             </WavelengthDataBlock>\n</WavelengthData>\n"
        );
    }
    text + "</Layer>\n</Optical>\n</WindowElement>\n"
}

fn parse(text: &str) -> Result<(Bsdf, Vec<String>)> {
    let mut warnings = Warnings::new();
    let bsdf = read_from(text.as_bytes(), &mut warnings)?;
    Ok((bsdf, warnings.iter().map(ToString::to_string).collect()))
}

fn error(text: &str) -> String {
    parse(text).map(|_| ()).unwrap_err().to_string()
}

const QUARTER: &str = "LBNL/Klems Quarter";
const FULL: &str = "LBNL/Klems Full";

/// Different in every entry, without any symmetry, and far from Lambertian.
fn asymmetric(n: usize) -> Vec<f64> {
    (0..n).map(|k| 1e-3 + (k as f64 * 0.618_034).fract().powi(6)).collect()
}

fn text_of(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.9e}")).collect::<Vec<_>>().join(" ")
}

/// T by Radiance's rmtxop, one component after another.
fn rmtxop(path: &Path) -> Option<Matrix<f64>> {
    let out = testing::output(testing::radiance("rmtxop")?.arg("-fd").arg(path));
    Some(read_matrix_from(out.as_slice()).unwrap().matrix)
}

fn transmission_of(text: &str) -> Matrix<f64> {
    transmission_matrix(&parse(text).unwrap().0).unwrap()
}

/// Largest difference relative to the largest value of Radiance's matrix, over all components.
fn difference(ours: &Matrix<f64>, theirs: &Matrix<f64>) -> f64 {
    assert_eq!((ours.rows(), ours.cols()), (theirs.rows(), theirs.cols()));
    let largest = theirs.data().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let mut worst = 0.0f64;
    for row in 0..ours.rows() {
        for col in 0..ours.cols() {
            for c in 0..3 {
                let ours = ours.at(row, col)[c % ours.components()];
                worst = worst.max((ours - theirs.at(row, col)[c]).abs());
            }
        }
    }
    worst / largest
}

#[test]
fn metadata_and_values_are_read() {
    let (bsdf, warnings) =
        parse(&xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&asymmetric(1681)))])).unwrap();
    assert_eq!((bsdf.name.as_str(), bsdf.manufacturer.as_str(), bsdf.thickness), ("A & B", "nobody", Some(0.0125)));
    assert!(warnings.is_empty(), "{warnings:?}");
    let m = bsdf.visible.transmission_front.as_ref().unwrap().as_klems().unwrap();
    assert_eq!(m.outgoing().len(), 41);
    assert!((m.at(2, 5) - asymmetric(1681)[2 * 41 + 5]).abs() < 1e-9);
    assert!(bsdf.solar.is_empty());
}

#[test]
fn junk_separators_case_prefixes_comments_and_cdata_do_not_matter() {
    let values = asymmetric(1681);
    let plain = parse(&xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&values))])).unwrap().0;
    let variants = [
        format!(
            "Recover using: genBSDF & -recover\n{}",
            xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&values))])
        ),
        xml("columns", &[("visible", " transmission  FRONT", "lbnl/klems_quarter", QUARTER, text_of(&values).replace(' ', ",\n"))]),
        xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&values).replace('.', ","))]),
        xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, format!("<!-- 1 2 3 -->{}", text_of(&values)))]),
        xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, format!("<![CDATA[{}]]>", text_of(&values)))]),
        xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&values))]).replace('\n', "\r\n"),
        format!("\u{feff}{}", xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&values))])),
        xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&values))])
            .replace("</", "</w:")
            .replace("</w:", "</"),
    ];
    for (i, text) in variants.iter().enumerate() {
        let (bsdf, warnings) = parse(text).unwrap_or_else(|e| panic!("variant {i}: {e}"));
        assert!(bsdf == plain, "variant {i}");
        assert_eq!(warnings.len(), usize::from(i == 2), "variant {i}: {warnings:?}");
    }
}

#[test]
fn missing_and_contradictory_bases_are_warned_about_or_refused() {
    let data = text_of(&asymmetric(1681));
    let complete = xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, data.clone())]);
    let without = complete.replace("<ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis>", "");
    let (bsdf, warnings) = parse(&without).unwrap();
    assert_eq!(bsdf.visible.transmission_front.unwrap().as_klems().unwrap().incident().len(), 41);
    assert!(warnings[0].contains("assumed from the number of values"), "{warnings:?}");
    let defined = |name: &str, upper: [f64; 2], counts: [usize; 2]| {
        let mut basis = format!("<AngleBasis><AngleBasisName>{name}</AngleBasisName>");
        let mut lower = 0.0;
        for (u, n) in upper.iter().zip(counts) {
            basis += &format!(
                "<AngleBasisBlock><Theta>0</Theta><nPhis>{n}</nPhis><ThetaBounds><LowerTheta>{lower}</LowerTheta><UpperTheta>{u}</UpperTheta></ThetaBounds></AngleBasisBlock>"
            );
            lower = *u;
        }
        complete.replace("</DataDefinition>", &format!("{basis}</AngleBasis></DataDefinition>"))
    };
    assert!(parse(&defined(QUARTER, [30.0, 90.0], [1, 40])).unwrap().1[0].contains("otherwise than its name says"));
    let own = defined("own", [30.0, 90.0], [1, 40])
        .replace(">LBNL/Klems Quarter</Col", ">own</Col")
        .replace(">LBNL/Klems Quarter</Row", ">Own</Row");
    let (bsdf, warnings) = parse(&own).unwrap();
    assert!(warnings.is_empty());
    let basis = bsdf.visible.transmission_front.unwrap().as_klems().unwrap().incident().clone();
    assert_eq!((basis.name(), basis.rings().len()), ("own", 2));
    assert!(error(&own.replace("<UpperTheta>90", "<UpperTheta>80")).contains("not a division of the hemisphere"));
    assert!(error(&own.replace("<nPhis>40", "<nPhis>99999999")).contains("more than"));
    assert!(error(&own.replace("<nPhis>40", "<nPhis>-1")).contains("not a number of azimuths"));
}

#[test]
fn rows_are_transposed_and_bases_may_differ() {
    let values = asymmetric(145 * 41);
    let matrix = |structure| {
        let text = xml(structure, &[("Visible", "Transmission Front", FULL, QUARTER, text_of(&values))]);
        parse(&text).unwrap().0.visible.transmission_front.unwrap().as_klems().unwrap().clone()
    };
    let (columns, rows) = (matrix("Columns"), matrix("Rows"));
    assert_eq!((columns.incident().len(), columns.outgoing().len()), (145, 41));
    assert!((columns.at(3, 7) - values[3 * 145 + 7]).abs() < 1e-9);
    assert!((rows.at(3, 7) - values[7 * 41 + 3]).abs() < 1e-9);
}

#[test]
fn hostile_files_get_one_clear_error() {
    let data = text_of(&asymmetric(1681));
    let good = xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, data.clone())]);
    let changed = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        error(&good.replacen(from, to, 1))
    };
    assert!(error("").contains("not a BSDF file"));
    assert!(error(&"garbage\n".repeat(500_000)).contains("not a BSDF file"));
    assert!(error("<?xml version=\"1.0\"?><html></html>").contains("this is a web page (HTML), not a BSDF file"));
    assert!(error("<WindowElement></WindowElement>").contains("no WavelengthData"));
    assert!(changed(&data, &data.replacen("e", "x", 1)).contains("is not a number"));
    assert!(changed(&data, &format!("NaN {}", &data[16..])).contains("finite"));
    assert!(changed(&data, &data[..1000]).contains("values; 41 × 41 = 1681 values are needed"), "{}", changed(&data, &data[..1000]));
    assert!(changed(&data, &format!("{data} 1")).contains("there are 1682 values"));
    assert!(changed(&data, "").contains("no values"));
    assert!(changed(&data, &"1 ".repeat(10_000_000)).contains("more than"));
    assert!(changed(&data, &"&lol;".repeat(100)).contains("is not a number"));
    assert!(changed("Transmission Front", "Sideways").contains("unknown direction 'Sideways'"));
    assert!(changed(">Visible<", ">Infrared<").contains("neither Visible nor Solar"));
    assert!(changed("<Wavelength unit=\"Integral\">Visible</Wavelength>", "").contains("no Wavelength"));
    assert!(changed(">Columns<", ">Diagonals<").contains("unknown data structure"));
    assert!(changed("LBNL/Klems Quarter", "LBNL/Klems Full").contains("values are needed"));
    assert!(parse(&good.replacen("LBNL/Klems Quarter", "nonsense", 1)).unwrap().1[0].contains("'nonsense' is not defined"));
    let bomb = "<!DOCTYPE b [<!ENTITY a \"aaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\n<WindowElement>&b;</WindowElement>";
    assert!(error(bomb).contains("document type definition"));
    assert!(error(&format!("<WindowElement>{}", "<a>".repeat(100_000))).contains("deeper than"));
    assert!(error(&format!("<WindowElement><!-- {} -->", "x".repeat(5_000_000))).contains("longer than"));
    assert!(error(&format!("<WindowElement a=\"{}\">", "x".repeat(5_000_000))).contains("longer than"));
    assert!(changed("A &amp; B", &"x".repeat(1_000_000)).contains("bytes of text"));
    assert!(error(&good.replace("</Layer>", "</Leyer>")).contains("damaged XML"));
    assert!(changed("<ScatteringData>\n", "<ScatteringData>\n{{{ ").contains("IncidentDataStructure is 'Columns'"));
    // Every error names the line.
    let message = error(&good.replacen("Transmission Front", "Sideways", 1));
    assert!(message.starts_with("line 18: WavelengthDataDirection"), "{message}");
}

#[test]
fn truncated_and_garbled_files_never_panic() {
    let good = xml("Columns", &[("Visible", "Transmission Front", QUARTER, QUARTER, text_of(&asymmetric(1681)))]);
    for cut in (0..good.len()).step_by(53).filter(|c| good.len() - c > 2) {
        assert!(parse(&good[..cut]).is_err(), "cut at {cut}");
    }
    let mut state = 1u64;
    for _ in 0..300 {
        let mut bytes = good.clone().into_bytes();
        for _ in 0..5 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (state >> 33) as usize % 1600;
            bytes[at] = (state >> 25) as u8;
        }
        let _ = read_from(bytes.as_slice(), &mut Warnings::new());
    }
}

#[test]
fn visible_front_is_chosen_else_back_reversed_and_solar_alone_is_refused() {
    let block = |w, d| (w, d, QUARTER, QUARTER, text_of(&asymmetric(1681)));
    let source = |blocks: &[_]| transmission_source(&parse(&xml("Columns", blocks)).unwrap().0);
    assert_eq!(source(&[block("Visible", "Transmission Back"), block("Visible", "Transmission Front")]), Ok(TransmissionSource::Front));
    assert_eq!(
        source(&[block("Visible", "Transmission Back"), block("Solar", "Transmission Front")]),
        Ok(TransmissionSource::BackReversed)
    );
    assert!(source(&[block("Solar", "Transmission Front")]).unwrap_err().to_string().contains("Solar data do not"));
    let tree = xml("TensorTree4", &[("Visible", "Transmission Front", "", "", "{ 0.3 }".into())]);
    let t = transmission_matrix(&parse(&tree).unwrap().0).unwrap();
    assert_eq!((t.rows(), t.cols()), (145, 145));
    assert!((t.at(3, 7)[0] - 0.3 * AngleBasis::from(KlemsBasis::Full).projected_solid_angle(7)).abs() < 1e-8);
}

/// Self-made files, all left-right asymmetric. Radiance quantises values to some 2e-7 and takes out
/// a Lambertian part with a perturbation of 3e-4 of it (see [`transmission_matrix`]).
#[test]
fn the_matrix_of_self_made_files_is_rmtxops() {
    let folder = tempfile::tempdir().unwrap();
    let square = |d: &'static str, v: &[f64]| ("Visible", d, QUARTER, QUARTER, text_of(v));
    let (a, b) = (asymmetric(1681), asymmetric(1681).into_iter().rev().collect::<Vec<_>>());
    let mixed = text_of(&asymmetric(145 * 41));
    let scaled = |f: f64| text_of(&a.iter().map(|v| v * f).collect::<Vec<_>>());
    let files = [
        ("front", xml("Columns", &[square("Transmission Front", &a)])),
        ("rows", xml("Rows", &[square("Transmission Front", &a)])),
        ("back", xml("Columns", &[square("Transmission Back", &a)])),
        ("back_rows", xml("Rows", &[square("Transmission Back", &a)])),
        ("both", xml("Columns", &[square("Transmission Back", &a), square("Transmission Front", &b)])),
        ("twice", xml("Columns", &[square("Transmission Front", &a), square("Transmission Front", &b)])),
        ("mixed", xml("Columns", &[("Visible", "Transmission Front", FULL, QUARTER, mixed.clone())])),
        ("mixed_rows", xml("Rows", &[("Visible", "Transmission Front", FULL, QUARTER, mixed)])),
        // Not tried: Back alone with two different bases. rmtxop then looks up outgoing bins in the
        // incident basis (6.0a), so that even bin 0 comes from elsewhere.
        (
            "colour",
            xml(
                "Columns",
                &[
                    ("CIE-X", "Transmission Front", QUARTER, QUARTER, scaled(1.1)),
                    ("Visible", "Transmission Front", QUARTER, QUARTER, scaled(1.0)),
                    ("CIE-Z", "Transmission Front", QUARTER, QUARTER, scaled(0.7)),
                ],
            ),
        ),
    ];
    for (name, text) in files {
        let path = folder.path().join(format!("{name}.xml"));
        std::fs::write(&path, &text).unwrap();
        let Some(theirs) = rmtxop(&path) else { return };
        let ours = transmission_of(&text);
        let worst = difference(&ours, &theirs);
        println!("{name}: largest difference {worst:.1e} of the largest value");
        // There, chromaticity is stored in 2 × 8 bits, rounded at random.
        assert!(worst < if name == "colour" { 0.04 } else { 2e-6 }, "{name}: {worst}");
        for c in 0..3 {
            let mean = |m: &Matrix<f64>| m.data().chunks(m.components()).map(|v| v[c % m.components()]).sum::<f64>();
            let ratio = mean(&ours) / mean(&theirs);
            assert!((ratio - 1.0).abs() < if name == "colour" { 2e-3 } else { 1e-6 }, "{name}, component {c}: {ratio}");
        }
    }
}

#[test]
fn the_matrix_of_the_reference_files_is_dctimesteps() {
    let Some(shared) = testing::shared() else { return };
    let folder = tempfile::tempdir().unwrap();
    let identity = |n: usize| Matrix::from_data(n, n, 3, (0..n * n * 3).map(|i| f32::from(i / 3 % n == i / 3 / n)).collect()).unwrap();
    let path = folder.path().join("identity.mtx");
    write_matrix(Some(&path), &identity(145), Format::Float, &[]).unwrap();
    let mut solar_differs = 0;
    for name in ["clear", "ven0", "ven45", "blinds", "blinds_correct_klems"] {
        let file = shared.join(format!("data/tutorial_room/bsdf/{name}.xml"));
        let mut warnings = Warnings::new();
        let bsdf = read(&file, &mut warnings).unwrap();
        assert!(warnings.is_empty(), "{name}: {:?}", warnings.iter().map(ToString::to_string).collect::<Vec<_>>());
        let ours = transmission_matrix(&bsdf).unwrap();
        let Some(mut dctimestep) = testing::radiance("dctimestep") else { return };
        let out = testing::output(dctimestep.arg("-od").args([&path, &file, &path, &path]));
        let theirs = read_matrix_from(out.as_slice()).unwrap().matrix;
        let worst = difference(&ours, &theirs);
        println!("{name}: largest difference from dctimestep {worst:.1e} of the largest value");
        assert!(worst < 2e-6, "{name}: {worst}");
        solar_differs += usize::from(bsdf.solar.transmission_front.is_some_and(|b| b != bsdf.visible.transmission_front.clone().unwrap()));
    }
    assert!(solar_differs > 0, "no file tells Visible from Solar");
}

#[test]
fn the_reference_tensor_tree_is_read() {
    let Some(shared) = testing::shared() else { return };
    let bsdf = read(&shared.join("data/tutorial_room/bsdf/blinds_correct_t4.xml"), &mut Warnings::new()).unwrap();
    let matrix = read(&shared.join("data/tutorial_room/bsdf/blinds_correct_klems.xml"), &mut Warnings::new()).unwrap();
    assert_eq!(bsdf.visible.iter().count(), 4);
    for (component, block) in bsdf.visible.iter() {
        let (tree, klems) = (block.hemispherical(), matrix.visible.get(component).unwrap().hemispherical());
        println!("{}: {} tree {tree:.5} Klems {klems:.5}", component.xml_name(), block.describe());
        // Two Monte-Carlo runs; the tree's is of modest quality.
        assert!((tree - klems).abs() < 0.01, "{component:?}: {tree} {klems}");
    }
    let klems = AngleBasis::from(KlemsBasis::Full);
    assert_eq!(matrix.visible.transmission_front.unwrap().as_klems().unwrap().incident(), &klems);
}
