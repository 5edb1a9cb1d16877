//! Layering against WINDOW's engine (pywincalc 3.3.1).
//!
//! Where all layers have two bands only, the engine's solar values are no oracle: it then interpolates
//! between 0.78 and 2.5 µm, so that visible light has 87 % of the weight; two panes of τ_sol = 0.6,
//! τ_vis = 0.9 without reflection come out at 0.717. Systems with a measured pane have its wavelengths.
//! The engine also takes the regression for bronze glass for every coated pane, also where τ > 0.645; the
//! coated pane here is darker than that.

use super::*;
use crate::bins::KlemsBasis;
use crate::bsdf::{Block, glass, write};
use crate::testing;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Prints, for each system (files separated by commas), the visible and the solar results.
const SCRIPT: &str = "
import pywincalc as w, sys, xml.etree.ElementTree as e
h = w.BSDFHemisphere.create(getattr(w.BSDFBasisType, sys.argv[1]))
def matrices(f):
    # The engine's own reader takes the full basis only.
    found = {}
    for data in e.parse(f).getroot().iter('{http://windows.lbl.gov}WavelengthData'):
        text = lambda name: data.find('.//{http://windows.lbl.gov}' + name).text
        values = [float(v) for v in text('ScatteringData').replace(',', ' ').split()]
        n = round(len(values) ** .5)
        found[text('Wavelength'), text('WavelengthDataDirection')] = [values[k * n:(k + 1) * n] for k in range(n)]
    kinds = ['Transmission Front', 'Transmission Back', 'Reflection Front', 'Reflection Back']
    return [found[band, kind] for band in ('Solar', 'Visible') for kind in kinds]
def solid(f):
    if not f.endswith('.xml'):
        return w.convert_to_solid_layer(w.parse_optics_file(f))
    if sys.argv[1] == 'FULL':
        return w.convert_to_solid_layer(w.parse_bsdf_xml_file(f))
    return w.ProductDataOpticalAndThermal(w.ProductDataOpticalDualBandBSDF(*matrices(f), h, .001), w.ProductDataThermal(1, .001))
for system in sys.argv[2:]:
    layers = [solid(f) for f in system.split(',')]
    gaps = [w.Layers.gap(thickness=.012) for _ in layers[1:]]
    g = w.GlazingSystem(solid_layers=layers, gap_layers=gaps, bsdf_hemisphere=h)
    for method in ('PHOTOPIC', 'SOLAR'):
        r = g.optical_method_results(method)
        s = r.system_results
        for side in (s.front, s.back):
            for flux in (side.transmittance, side.reflectance):
                print(*(v for row in flux.matrix for v in row))
        for side in (s.front, s.back):
            print(side.transmittance.diffuse_diffuse, side.reflectance.diffuse_diffuse)
        for layer in r.layer_results:
            print(layer.front.absorptance.total_diffuse, layer.back.absorptance.total_diffuse)
";

/// The engine's lines for these systems of files.
fn engine(basis: &str, systems: &[Vec<String>]) -> Vec<Vec<f64>> {
    let mut command = Command::new("python3");
    command.args(["-c", SCRIPT, basis]).args(systems.iter().map(|s| s.join(",")));
    let out = String::from_utf8(testing::output(&mut command)).unwrap();
    out.lines().map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect()
}

/// Largest differences of an entry (over the largest of its row), of a hemispherical value and of an
/// absorptance, from the engine's lines for one band.
fn differences(system: &System, band: usize, lines: &mut impl Iterator<Item = Vec<f64>>) -> [f64; 3] {
    let blocks = system.bsdf.bands()[band].1;
    let mut worst = [0.0f64; 3];
    let order = [Component::TransmissionFront, Component::ReflectionFront, Component::TransmissionBack, Component::ReflectionBack];
    let matrices = order.map(|c| blocks.get(c).unwrap().as_klems().unwrap());
    for m in matrices {
        let n = m.incident().len();
        for (ours, theirs) in m.values().chunks(n).zip(lines.next().unwrap().chunks(n)) {
            let largest = theirs.iter().fold(1e-6f64, |m, v| m.max(*v));
            worst[0] = ours.iter().zip(theirs).fold(worst[0], |w, (x, y)| w.max((x - y).abs() / largest));
        }
    }
    for pair in matrices.chunks(2) {
        let theirs = lines.next().unwrap();
        worst[1] = pair.iter().zip(&theirs).fold(worst[1], |w, (m, t)| w.max((m.hemispherical() - t).abs()));
    }
    for layer in &system.absorptance[band] {
        let theirs = lines.next().unwrap();
        worst[2] = layer.hemispherical.iter().zip(&theirs).fold(worst[2], |w, (a, t)| w.max((a - t).abs()));
    }
    worst
}

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bsdf").join(name)
}

#[test]
fn twelve_systems_are_those_of_windows_engine_visible_and_solar() {
    if !testing::has_pywincalc() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // Every third wavelength: the engine takes its time for each.
    for name in ["clear_float.dat", "low_e.dat"] {
        let text = std::fs::read_to_string(sample(name)).unwrap();
        let (header, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|l| l.starts_with('{'));
        let kept = rows.iter().enumerate().filter(|(k, _)| k % 3 == 0 || k + 1 == rows.len()).map(|(_, r)| *r);
        let kept: Vec<&str> = kept.collect();
        let turn = |row: &&str| {
            let words: Vec<&str> = row.split_whitespace().collect();
            format!("{} {} {} {}", words[0], words[1], words[3], words[2])
        };
        let turned: Vec<String> = kept.iter().map(turn).collect();
        std::fs::write(path(name), [header.join("\n"), kept.join("\n")].join("\n")).unwrap();
        std::fs::write(path(&format!("turned_{name}")), [header.join("\n"), turned.join("\n")].join("\n")).unwrap();
    }
    // The blind's slats are darker for the sun.
    let mut blind = crate::bsdf::read(&sample("venetian.xml"), &mut Warnings::new()).unwrap();
    blind.solar = blind.visible.clone();
    for component in Component::ALL {
        let factor = if component.is_transmission() { 0.95 } else { 0.8 };
        let Some(Block::Klems(m)) = blind.solar.slot(component) else { panic!("a matrix") };
        m.values_mut().iter_mut().for_each(|v| *v *= factor);
    }
    write(Some(&path("blind.xml")), &blind, "").unwrap();
    write(Some(&path("turned.xml")), &flipped(&blind).unwrap(), "").unwrap();
    for name in ["perforated.xml", "woven.xml", "film.xml"] {
        std::fs::copy(sample(name), path(name)).unwrap();
    }
    let systems = [
        "clear_float.dat",
        "clear_float.dat clear_float.dat",
        "low_e.dat clear_float.dat flip:low_e.dat",
        "blind.xml clear_float.dat clear_float.dat",
        "clear_float.dat blind.xml clear_float.dat",
        "clear_float.dat clear_float.dat blind.xml",
        "turned.xml low_e.dat",
        "low_e.dat film.xml",
        "film.xml clear_float.dat blind.xml",
        "clear_float.dat perforated.xml",
        "perforated.xml low_e.dat clear_float.dat",
        "clear_float.dat low_e.dat woven.xml",
    ]
    .map(|s| s.split(' ').collect::<Vec<_>>());
    let name = |file: &str| match file.strip_prefix("flip:") {
        Some(plain) => path(&format!("turned_{plain}")).display().to_string(),
        None => path(file).display().to_string(),
    };
    const SAME: f64 = 1e-4;
    let count = systems.len();
    // By band: of an entry, of a hemispherical value, of an absorptance.
    let mut all = [[0.0f64; 3]; 2];
    let mut lines = engine("QUARTER", &systems.clone().map(|s| s.into_iter().map(name).collect())).into_iter();
    let quarter = AngleBasis::from(KlemsBasis::Quarter);
    for files in systems {
        let layers: Vec<Layer> = files
            .iter()
            .map(|file| {
                let plain = file.trim_start_matches("flip:");
                if plain.ends_with(".xml") {
                    return crate::bsdf::read(&path(plain), &mut Warnings::new()).unwrap().into();
                }
                let pane = Pane::parse(path(plain).to_str().unwrap()).unwrap();
                Layer::Pane(if plain == *file { pane } else { pane.flipped() })
            })
            .collect();
        let system = combine(&layers, &quarter, &mut Warnings::new()).unwrap();
        for (band, worst) in BANDS.into_iter().enumerate().map(|(k, band)| (band, differences(&system, k, &mut lines))) {
            let [entry, hemispherical, absorptance] = worst;
            println!(
                "{:<46} {band:<8} entry {entry:.1e}, hemispherical {hemispherical:.1e}, absorptance {absorptance:.1e}",
                files.join(" | ")
            );
            assert!(worst.iter().all(|w| *w < SAME), "{files:?} {band}: {worst:?}");
            let of_band = &mut all[usize::from(band == BANDS[1])];
            of_band.iter_mut().zip(worst).for_each(|(most, w)| *most = most.max(w));
        }
    }
    let texts: Vec<String> = BANDS
        .into_iter()
        .zip(&all)
        .map(|(band, of_band)| {
            let [entry, hemispherical, absorptance] = of_band.map(testing::short);
            format!("{band}: entries within {entry} of the largest of their row, hemispherical {hemispherical}, absorptances {absorptance}")
        })
        .collect();
    testing::measured("layers", &format!("{count} systems. {}", texts.join("; ")), &testing::short(SAME));
}

fn scatterer(seed: usize, basis: &AngleBasis) -> Bsdf {
    let random = |k: usize| ((k + seed) as f64 * 0.618_034).fract();
    let n = basis.len();
    let block = |level: f64, peak: f64, shift: usize| {
        Some(Block::Klems(KlemsMatrix::from_fn(basis, |o, i| {
            level * random(o * n + i + shift).powi(3) + if o == i { peak / basis.projected_solid_angle(i) } else { 0.0 }
        })))
    };
    let blocks = Blocks {
        transmission_front: block(0.3, 0.3, 0),
        transmission_back: block(0.25, 0.3, 7),
        reflection_front: block(0.2, 0.1, 14),
        reflection_back: block(0.35, 0.05, 21),
    };
    Bsdf {
        name: format!("scatterer {seed}"),
        manufacturer: "nobody".into(),
        thickness: Some(0.001),
        visible: blocks.clone(),
        solar: blocks,
        ..Bsdf::default()
    }
}

#[test]
fn a_system_of_three_layers_over_the_full_basis_is_that_of_windows_engine() {
    if !testing::has_pywincalc() {
        return;
    }
    let basis = AngleBasis::from(KlemsBasis::Full);
    let mut pane = glass::named("clear_6mm").unwrap();
    if let Values::Bands { visible, solar } = &mut pane.values {
        *solar = *visible;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut layers = Vec::new();
    let mut files = Vec::new();
    let pane = combine(&[pane.into()], &basis, &mut Warnings::new()).unwrap().bsdf;
    for (k, layer) in [scatterer(1, &basis), Bsdf { thickness: Some(0.006), ..pane }, scatterer(5, &basis)].into_iter().enumerate() {
        let path = folder.path().join(format!("layer{k}.xml"));
        write(Some(&path), &layer, "").unwrap();
        // Layer what the engine reads: 9 digits.
        layers.push(Layer::from(crate::bsdf::read(&path, &mut Warnings::new()).unwrap()));
        files.push(path.display().to_string());
    }
    let mut lines = engine("FULL", &[files]).into_iter();
    let system = combine(&layers, &basis, &mut Warnings::new()).unwrap();
    for band in 0..2 {
        let worst = differences(&system, band, &mut lines);
        assert!(worst.iter().all(|w| *w < 1e-6), "{}: {worst:?}", BANDS[band]);
    }
}
