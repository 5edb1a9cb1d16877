//! Writing XML files that WINDOW, Radiance and pywincalc read.

use super::{Block, Bsdf, Component, KlemsMatrix};
use crate::bins::AngleBasis;
use crate::error::{Error, Result};
use crate::files::write_atomically;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Properties that readers insist on, where the BSDF has none: those of ordinary glass. They do not
/// influence light.
const DEFAULT_PROPERTIES: [(&str, &str); 4] =
    [("ThermalConductivity", "1"), ("EmissivityFront", "0.84"), ("EmissivityBack", "0.84"), ("TIR", "0")];

/// Writes a BSDF file (atomically), or to standard output where `path` is absent or `-`.
/// `made_by` goes into a comment: the command that made the data.
///
/// Matrices are written as `Columns` with 9 significant digits, one line per outgoing bin, values
/// separated by commas, one `WavelengthData` per block, as WINDOW does.
///
/// # Errors
/// If the BSDF mixes matrices with trees, or trees of different rank; failures of the file system
/// with the path named.
pub fn write(path: Option<&Path>, bsdf: &Bsdf, made_by: &str) -> Result<()> {
    match path {
        Some(path) if path != Path::new("-") => write_atomically(path, |out| write_to(out, bsdf, made_by).map_err(|e| e.file(path))),
        _ => {
            let mut out = BufWriter::with_capacity(1 << 20, std::io::stdout().lock());
            write_to(&mut out, bsdf, made_by)
                .and_then(|()| out.flush().map_err(|e| Error::stream(&e)))
                .map_err(|e| e.file("standard output"))
        }
    }
}

/// Writes a BSDF file to a stream.
///
/// # Errors
/// As [`write()`], without the file's name.
pub fn write_to(out: &mut dyn Write, bsdf: &Bsdf, made_by: &str) -> Result<()> {
    let structure = structure(bsdf)?;
    write_all(out, bsdf, structure, made_by).map_err(|e| Error::stream(&e))
}

/// The `IncidentDataStructure` that all blocks share.
fn structure(bsdf: &Bsdf) -> Result<&'static str> {
    let mut structures =
        bsdf.bands().into_iter().flat_map(|(_, blocks)| blocks.iter().map(|(_, block)| structure_of(block)).collect::<Vec<_>>());
    let first = structures.next().ok_or_else(|| Error::new("there is no scattering data to write"))?;
    if structures.any(|s| s != first) {
        return Err(Error::new("a file cannot hold matrices and tensor trees, or trees of different rank, together")
            .help("convert all blocks to one structure first"));
    }
    Ok(first)
}

fn structure_of(block: &Block) -> &'static str {
    match block {
        Block::Klems(_) => "Columns",
        Block::Tree(t) if t.rank() == 3 => "TensorTree3",
        Block::Tree(_) => "TensorTree4",
    }
}

fn write_all(out: &mut dyn Write, bsdf: &Bsdf, structure: &str, made_by: &str) -> std::io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    if !made_by.is_empty() {
        writeln!(out, "<!-- {} -->", printable(made_by).replace("--", "- -"))?;
    }
    writeln!(
        out,
        "<WindowElement xmlns=\"http://windows.lbl.gov\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"http://windows.lbl.gov/BSDF-v1.4.xsd\">"
    )?;
    writeln!(out, "<WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical>\n<Layer>\n\t<Material>")?;
    // pywincalc crashes on empty names, and insists on a thickness: 0 says nothing wrong about an
    // unknown one.
    let or = |text: &str, otherwise: &str| escape(if text.trim().is_empty() { otherwise } else { text });
    writeln!(
        out,
        "\t\t<Name>{}</Name>\n\t\t<Manufacturer>{}</Manufacturer>",
        or(&bsdf.name, "unnamed"),
        or(&bsdf.manufacturer, "unknown")
    )?;
    writeln!(out, "\t\t<Thickness unit=\"Meter\">{}</Thickness>", bsdf.thickness.unwrap_or(0.0))?;
    for (name, length) in [("Width", bsdf.width), ("Height", bsdf.height)] {
        if let Some(metres) = length {
            writeln!(out, "\t\t<{name} unit=\"Meter\">{metres}</{name}>")?;
        }
    }
    writeln!(out, "\t\t<DeviceType>{}</DeviceType>", or(&bsdf.device_type, "Other"))?;
    let has = |name: &str| bsdf.properties.iter().any(|(n, _)| n == name);
    let defaults = DEFAULT_PROPERTIES.iter().filter(|(name, _)| !has(name)).map(|(n, v)| (*n, *v));
    for (name, text) in bsdf.properties.iter().map(|(n, v)| (n.as_str(), v.as_str())).chain(defaults) {
        if !name.is_empty() && name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(|c| c.is_ascii_alphanumeric()) {
            writeln!(out, "\t\t<{name}>{}</{name}>", escape(text))?;
        }
    }
    writeln!(out, "\t</Material>")?;
    if let Some(g) = &bsdf.geometry {
        let (format, unit) = (escape(&g.format), if g.unit.is_empty() { "meter".into() } else { escape(&g.unit) });
        writeln!(out, "\t<Geometry format=\"{format}\"><MGFblock unit=\"{unit}\">{}</MGFblock></Geometry>", escape_block(&g.text))?;
    }
    writeln!(out, "\t<DataDefinition>\n\t\t<IncidentDataStructure>{structure}</IncidentDataStructure>")?;
    write_bases(out, bsdf)?;
    writeln!(out, "\t</DataDefinition>")?;
    for (wavelength, blocks) in bsdf.bands() {
        for (component, block) in blocks.iter() {
            write_block(out, wavelength, component, block)?;
        }
    }
    writeln!(out, "</Layer>\n</Optical>\n</WindowElement>")
}

fn write_bases(out: &mut dyn Write, bsdf: &Bsdf) -> std::io::Result<()> {
    let mut written: Vec<&AngleBasis> = Vec::new();
    for (_, blocks) in bsdf.bands() {
        for matrix in blocks.iter().filter_map(|(_, b)| b.as_klems()) {
            for basis in [matrix.incident(), matrix.outgoing()] {
                if !written.contains(&basis) {
                    written.push(basis);
                }
            }
        }
    }
    for basis in written {
        writeln!(out, "\t\t<AngleBasis>\n\t\t\t<AngleBasisName>{}</AngleBasisName>", escape(basis.name()))?;
        for ring in basis.rings() {
            let theta = if ring.bins == 1 && ring.first == 0 { 0.0 } else { (ring.theta_min + ring.theta_max) / 2.0 };
            writeln!(out, "\t\t\t<AngleBasisBlock>\n\t\t\t\t<Theta>{theta}</Theta>\n\t\t\t\t<nPhis>{}</nPhis>", ring.bins)?;
            writeln!(out, "\t\t\t\t<ThetaBounds>\n\t\t\t\t\t<LowerTheta>{}</LowerTheta>", ring.theta_min)?;
            writeln!(out, "\t\t\t\t\t<UpperTheta>{}</UpperTheta>\n\t\t\t\t</ThetaBounds>\n\t\t\t</AngleBasisBlock>", ring.theta_max)?;
        }
        writeln!(out, "\t\t</AngleBasis>")?;
    }
    Ok(())
}

fn write_block(out: &mut dyn Write, wavelength: &str, component: Component, block: &Block) -> std::io::Result<()> {
    let source = if wavelength == "Solar" { "NFRC 300-2003.ssp" } else { "CIE Illuminant D65 1nm.ssp" };
    let detector = match wavelength {
        "Solar" => "None",
        "CIE-X" => "ASTM E308 1931 X.dsp",
        "CIE-Z" => "ASTM E308 1931 Z.dsp",
        _ => "ASTM E308 1931 Y.dsp",
    };
    writeln!(
        out,
        "\t<WavelengthData>\n\t\t<LayerNumber>System</LayerNumber>\n\t\t<Wavelength unit=\"Integral\">{wavelength}</Wavelength>"
    )?;
    writeln!(out, "\t\t<SourceSpectrum>{source}</SourceSpectrum>\n\t\t<DetectorSpectrum>{detector}</DetectorSpectrum>")?;
    writeln!(out, "\t\t<WavelengthDataBlock>\n\t\t\t<WavelengthDataDirection>{}</WavelengthDataDirection>", component.xml_name())?;
    match block {
        Block::Klems(m) => {
            writeln!(out, "\t\t\t<ColumnAngleBasis>{}</ColumnAngleBasis>", escape(m.incident().name()))?;
            writeln!(out, "\t\t\t<RowAngleBasis>{}</RowAngleBasis>", escape(m.outgoing().name()))?;
        }
        Block::Tree(_) => writeln!(out, "\t\t\t<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>")?,
    }
    let kind = if component.is_transmission() { "BTDF" } else { "BRDF" };
    writeln!(out, "\t\t\t<ScatteringDataType>{kind}</ScatteringDataType>\n\t\t\t<ScatteringData>")?;
    match block {
        Block::Klems(m) => write_matrix(out, m)?,
        Block::Tree(t) => t.write_text(out)?,
    }
    writeln!(out, "\t\t\t</ScatteringData>\n\t\t</WavelengthDataBlock>\n\t</WavelengthData>")
}

fn write_matrix(out: &mut dyn Write, matrix: &KlemsMatrix) -> std::io::Result<()> {
    for row in matrix.values().chunks_exact(matrix.incident().len()) {
        for (i, &value) in row.iter().enumerate() {
            write!(out, "{}{}", if i == 0 { "" } else { ", " }, number(value))?;
        }
        // A comma at the end of a line, as in WINDOW's files: some readers split at commas only.
        writeln!(out, ",")?;
    }
    Ok(())
}

/// 9 significant digits without idle zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.8e}");
    let (mantissa, exponent) = text.split_once('e').expect("the format has an exponent");
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    if exponent == "0" { mantissa.to_string() } else { format!("{mantissa}e{exponent}") }
}

/// Without characters that XML does not allow.
fn printable(text: &str) -> String {
    text.chars().filter(|c| !c.is_control() || matches!(c, '\n' | '\t')).collect()
}

fn escape(text: &str) -> String {
    escape_block(text).replace('"', "&quot;")
}

/// Text of an element: Radiance takes embedded geometry as it stands, so quotes stay.
fn escape_block(text: &str) -> String {
    printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::bsdf::{Geometry, TensorTree, read_from};
    use crate::error::Warnings;
    use crate::matrix::file::read_matrix_from;
    use crate::testing;

    fn matrix(basis: KlemsBasis, seed: usize) -> Block {
        let basis = AngleBasis::from(basis);
        let n = basis.len();
        let f = |o: usize, i: usize| {
            let random = ((o * n + i + seed) as f64 * 0.618_034).fract().powi(8) * 0.1;
            let peak = if o == i { 0.4 / basis.projected_solid_angle(i) } else { 0.0 };
            (random + peak) * 1e6
        };
        // Values of 9 digits come back exactly.
        Block::Klems(KlemsMatrix::from_fn(&basis, |o, i| f(o, i).round() / 1e6))
    }

    fn complete(basis: KlemsBasis) -> Bsdf {
        let mut bsdf = Bsdf { name: "a <b> & \"c\"".into(), manufacturer: "Ö".into(), device_type: "Other".into(), ..Bsdf::default() };
        bsdf.thickness = Some(0.012);
        bsdf.width = Some(1.5);
        bsdf.properties =
            ["ThermalConductivity", "EmissivityFront", "EmissivityBack", "TIR"].map(|n| (n.to_string(), "0.5".to_string())).to_vec();
        bsdf.geometry = Some(Geometry { format: "MGF".into(), unit: "meter".into(), text: "# a < b & \"c\"\no x\no\n".into() });
        for (k, component) in Component::ALL.into_iter().enumerate() {
            *bsdf.visible.slot(component) = Some(matrix(basis, 7 * k));
            *bsdf.solar.slot(component) = Some(matrix(basis, 7 * k + 3));
        }
        bsdf
    }

    fn text(bsdf: &Bsdf) -> String {
        let mut out = Vec::new();
        write_to(&mut out, bsdf, "lucarne bsdf test -- of the writer").unwrap();
        String::from_utf8(out).unwrap()
    }

    fn read_back(text: &str) -> Bsdf {
        let mut warnings = Warnings::new();
        let bsdf = read_from(text.as_bytes(), &mut warnings).unwrap();
        assert!(warnings.is_empty(), "{:?}", warnings.iter().map(ToString::to_string).collect::<Vec<_>>());
        bsdf
    }

    fn tree(rank: usize) -> TensorTree {
        let mut grid = String::from("{");
        for i in 0..4usize.pow(rank as u32) {
            grid += &format!(" {}", 0.001 + (i as f64 * 0.618_034).fract().powi(5));
        }
        let mut text = format!("{{ {grid} }}");
        text += &" { 0.25 }".repeat((1 << rank) - 1);
        TensorTree::parse(&(text + " }"), rank).unwrap()
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        for basis in KlemsBasis::ALL {
            let bsdf = complete(basis);
            assert!(read_back(&text(&bsdf)) == bsdf);
        }
        for rank in [3, 4] {
            let mut bsdf = Bsdf { visible: Default::default(), ..complete(KlemsBasis::Quarter) };
            bsdf.solar = Default::default();
            bsdf.visible.transmission_front = Some(Block::Tree(tree(rank)));
            assert!(read_back(&text(&bsdf)) == bsdf);
        }
        let rings = AngleBasis::from_rings("own", &[0.0, 30.0, 90.0], &[1, 4]).unwrap();
        let mut bsdf = complete(KlemsBasis::Quarter);
        bsdf.visible.reflection_back = Some(Block::Klems(KlemsMatrix::from_fn(&rings, |o, i| (o + 10 * i) as f64)));
        assert!(read_back(&text(&bsdf)) == bsdf);
    }

    #[test]
    fn numbers_have_nine_digits_and_no_idle_zeros() {
        let shown = [0.0, 1.0, -0.5, 34.832863, 1.0 / 3.0, 1.5e-12, 2e10].map(number);
        assert_eq!(shown, ["0", "1", "-5e-1", "3.4832863e1", "3.33333333e-1", "1.5e-12", "2e10"]);
    }

    #[test]
    fn mixtures_and_nothing_are_refused() {
        let mut bsdf = complete(KlemsBasis::Quarter);
        bsdf.solar.reflection_back = Some(Block::Tree(tree(4)));
        assert!(write_to(&mut Vec::new(), &bsdf, "").unwrap_err().to_string().contains("together"));
        assert!(write_to(&mut Vec::new(), &Bsdf::default(), "").is_err());
    }

    #[test]
    fn radiance_reads_matrices_and_trees() {
        let folder = tempfile::tempdir().unwrap();
        for basis in KlemsBasis::ALL {
            let path = folder.path().join("matrix.xml");
            let bsdf = complete(basis);
            write(Some(&path), &bsdf, "").unwrap();
            let Some(mut rmtxop) = testing::radiance("rmtxop") else { return };
            let theirs = read_matrix_from::<f64>(testing::output(rmtxop.arg("-fd").arg(&path)).as_slice()).unwrap().matrix;
            let ours = crate::bsdf::transmission_matrix(&bsdf).unwrap();
            let largest = theirs.data().iter().fold(0.0f64, |m, v| m.max(*v));
            for (a, b) in ours.data().iter().zip(theirs.data().chunks(3)) {
                assert!((a - b[0]).abs() < 2e-6 * largest, "{a} {b:?}");
            }
            // Radiance's loader takes the largest Lambertian part out; the rest must be reported as is.
            let report = testing::output(testing::radiance("checkBSDF").unwrap().arg(&path));
            let report = String::from_utf8(report).unwrap();
            assert!(report.contains("Manufacturer: 'Ö'") && report.contains("Ext->Int Trans"), "{report}");
        }
        for rank in [3, 4] {
            let path = folder.path().join("tree.xml");
            let mut bsdf = Bsdf::default();
            bsdf.visible.transmission_back = Some(Block::Tree(tree(rank)));
            write(Some(&path), &bsdf, "").unwrap();
            let klems = testing::output(testing::radiance("bsdf2klems").unwrap().args(["-q", "-n", "64"]).arg(&path));
            let klems = read_from(klems.as_slice(), &mut Warnings::new()).unwrap();
            let theirs = klems.visible.transmission_back.as_ref().or(klems.visible.transmission_front.as_ref()).unwrap();
            let ours = bsdf.visible.transmission_back.as_ref().unwrap();
            // Random sampling of 41 × 41 × 64 points: a few 1e-4.
            assert!((theirs.hemispherical() - ours.hemispherical()).abs() < 2e-3, "{} {}", theirs.hemispherical(), ours.hemispherical());
        }
    }

    #[test]
    fn pywincalc_reads_matrices() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("matrix.xml");
        let bsdf = complete(KlemsBasis::Full);
        write(Some(&path), &bsdf, "").unwrap();
        let script = "import pywincalc as w, sys\np = w.parse_bsdf_xml_file(sys.argv[1])\nw.convert_to_solid_layer(p)\n\
                      m = p.measurements.visible.transmittance_front.data\nprint(len(m), m[3][7], m[140][9], p.thickness, p.emissivity_front)";
        if !testing::has_pywincalc() {
            return;
        }
        let out = testing::output(std::process::Command::new("python3").args(["-c", script]).arg(&path));
        let words: Vec<f64> = String::from_utf8(out).unwrap().split_whitespace().map(|w| w.parse().unwrap()).collect();
        let m = bsdf.visible.transmission_front.as_ref().unwrap().as_klems().unwrap();
        assert_eq!(words, [145.0, m.at(3, 7), m.at(140, 9), 0.012, 0.5]);
    }
}
