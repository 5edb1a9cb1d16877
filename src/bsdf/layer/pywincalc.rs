//! Layering against WINDOW's engine (pywincalc), for a system whose layers are all different,
//! scattering and left-right asymmetric.
//!
//! Visible only: for layers whose Solar and Visible data differ, pywincalc 3.3.1 derives a
//! near-infrared band from both, and two panes of τ_sol = 0.6, τ_vis = 0.9 without reflection then
//! come out at 0.717 instead of 0.36, so its solar values are no oracle.

use super::*;
use crate::bins::KlemsBasis;
use crate::bsdf::{glass, write};
use crate::testing;
use std::process::Command;

const SCRIPT: &str = "
import pywincalc as w, sys
layers = [w.convert_to_solid_layer(w.parse_bsdf_xml_file(f)) for f in sys.argv[1:]]
gaps = [w.Layers.gap(thickness=.012) for _ in layers[1:]]
h = w.BSDFHemisphere.create(w.BSDFBasisType.FULL)
g = w.GlazingSystem(solid_layers=layers, gap_layers=gaps, bsdf_hemisphere=h)
r = g.optical_method_results('PHOTOPIC')
s = r.system_results
for side in (s.front, s.back):
    for flux in (side.transmittance, side.reflectance):
        print(*(v for row in flux.matrix for v in row))
for layer in r.layer_results:
    print(layer.front.absorptance.total_diffuse, layer.back.absorptance.total_diffuse)
";

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
fn a_system_of_three_layers_is_that_of_windows_engine() {
    let installed = Command::new("python3").args(["-c", "import pywincalc"]).output().is_ok_and(|o| o.status.success());
    if !installed {
        eprintln!("SKIPPED a test: pywincalc is not installed");
        return;
    }
    let basis = AngleBasis::from(KlemsBasis::Full);
    let [visible, _] = glass::named("clear_6mm").unwrap().to_blocks(&basis);
    let pane = Bsdf { thickness: Some(0.006), solar: visible.clone(), visible, ..Bsdf::default() };
    let folder = tempfile::tempdir().unwrap();
    let mut layers = Vec::new();
    let mut command = Command::new("python3");
    command.args(["-c", SCRIPT]);
    for (k, layer) in [scatterer(1, &basis), pane, scatterer(5, &basis)].into_iter().enumerate() {
        let path = folder.path().join(format!("layer{k}.xml"));
        write(Some(&path), &layer, "").unwrap();
        // Layer what the engine reads: 9 digits.
        layers.push(crate::bsdf::read(&path, &mut Warnings::new()).unwrap());
        command.arg(path);
    }
    let out = String::from_utf8(testing::output(&mut command)).unwrap();
    let lines: Vec<Vec<f64>> = out.lines().map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect();
    let system = combine(&layers, &basis, &mut Warnings::new()).unwrap();
    let order = [Component::TransmissionFront, Component::ReflectionFront, Component::TransmissionBack, Component::ReflectionBack];
    for (component, theirs) in order.into_iter().zip(&lines) {
        let ours = system.bsdf.visible.get(component).unwrap().as_klems().unwrap();
        let mut worst = 0.0f64;
        for (a, b) in ours.values().chunks(145).zip(theirs.chunks(145)) {
            let largest = b.iter().fold(0.0f64, |m, v| m.max(*v));
            worst = a.iter().zip(b).fold(worst, |w, (x, y)| w.max((x - y).abs() / largest));
        }
        println!("{}: largest difference {worst:.1e} of the largest value of its row", component.xml_name());
        assert!(worst < 1e-6, "{component:?}: {worst}");
    }
    for (ours, theirs) in system.absorptance[0].iter().zip(&lines[4..]) {
        for (a, b) in ours.hemispherical.iter().zip(theirs) {
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }
}
