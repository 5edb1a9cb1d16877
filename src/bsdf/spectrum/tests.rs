use super::*;

fn flat(t: f64) -> Vec<[f64; 4]> {
    [0.3, 0.5, 1.0, 2.5].map(|w| [w, t, 0.1, 0.2]).to_vec()
}

#[test]
fn weights_sum_to_one_and_integrate_linear_functions_exactly() {
    let fine: Vec<f64> = (0..=2200).map(|k| 0.3 + f64::from(k) * 0.001).collect();
    let coarse = [0.3, 0.9, 2.5];
    let linear = |w: f64| 0.2 + 0.1 * w;
    for band in 0..2 {
        let mean = |grid: &[f64]| grid.iter().zip(&weights(grid)[band]).map(|(w, s)| s * linear(*w)).sum::<f64>();
        assert!((weights(&coarse)[band].iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Beyond 2.5 µm values stay constant, on either grid.
        assert!((mean(&fine) - mean(&coarse)).abs() < 1e-12, "{} {}", mean(&fine), mean(&coarse));
    }
    // Half of the sun's energy is visible; all of the eye's sensitivity is.
    let step: Vec<f64> = [0.3, 0.379_999, 0.38, 0.78, 0.780_001, 2.5].to_vec();
    let [visible, solar] = weights(&step).map(|w| w[2] + w[3]);
    assert!((visible - 1.0).abs() < 1e-6 && (solar - 0.509).abs() < 1e-3, "{visible} {solar}");
}

#[test]
fn two_bands_add_up_to_the_solar_value() {
    let rest = beyond_visible(0.8, 0.5);
    assert!((VISIBLE_SHARE * 0.8 + (1.0 - VISIBLE_SHARE) * rest - 0.5).abs() < 1e-12);
    assert_eq!(beyond_visible(1.0, 0.1), 0.0);
}

#[test]
fn text_and_both_kinds_of_json_say_the_same() {
    let text = "{ Units, Wavelength Units } SI Microns\n{ Thickness } 5.5\n{ Product Name: Pane 1 }\n{ Type: Coated }\n\
                { Coated Side: Front }\n{ }\n0.300 0.1 0.05 0.06\n0.500\t0.8 0.05 0.06\n2.500 0.4 0.30 0.20\n\n";
    let first = r#"{"name": "Pane 1", "subtype": "coated", "coated_side": "Front", "measured_data": {"thickness": 5.5},
        "spectral_data": {"spectral_data": [{"T": 0.1, "Rf": 0.05, "Rb": 0.06, "wavelength": 0.3},
        {"T": 0.8, "Rf": 0.05, "Rb": 0.06, "wavelength": 0.5}, {"T": 0.4, "Rf": 0.3, "Rb": 0.2, "wavelength": 2.5}]}}"#;
    let entry = |w: &str, t: &str, f: &str, b: &str| {
        format!(r#"{{"w": "{w}", "specular": {{"tf": "{t}", "tb": "{t}", "rf": "{f}", "rb": "{b}"}}}}"#)
    };
    let entries = [entry("0.3", "0.1", "0.05", "0.06"), entry("0.5", "0.8", "0.05", "0.06"), entry("2.5", "0.4", "0.3", "0.2")].join(",");
    let second = format!(
        r#"{{"name": "Pane 1", "subtype": "COATED", "coated_side": "FRONT", "physical_properties": {{"thickness": "5.5",
        "optical_properties": {{"optical_data": {{"angle_blocks": [{{"incidence_angle": 0, "wavelength_data": [{entries}]}}]}}}}}}}}"#
    );
    let nanometres = text.replace("Microns", "Nanometers").replace("0.300 ", "300 ").replace("0.500\t", "500 ").replace("2.500 ", "2500 ");
    let pane = from_text(text).unwrap();
    assert!(pane.coated && (pane.thickness - 0.0055).abs() < 1e-12 && pane.name == "Pane 1");
    assert_eq!(pane.spectrum.at(0.4).map(|v| (v * 1e12).round() / 1e12), [0.45, 0.05, 0.06]);
    assert_eq!(from_json(first).unwrap(), pane);
    assert_eq!(from_json(&second).unwrap(), pane);
    assert_eq!(from_text(&nanometres).unwrap(), pane);
    assert_eq!(pane.spectrum.flipped().flipped(), pane.spectrum);
    assert!(!from_text(&text.replace("Coated }", "Monolithic }").replace("Side: Front", "Side: Neither")).unwrap().coated);
}

#[test]
fn a_flat_spectrum_has_its_own_means() {
    let spectrum = Spectrum::new(&flat(0.7)).unwrap();
    for mean in spectrum.means() {
        assert!(mean.iter().zip([0.7, 0.1, 0.2]).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}

#[test]
fn faulty_spectra_are_explained() {
    let fault = |text: &str| from_text(text).unwrap_err().to_string();
    assert!(fault("0.3 0.1 0.1 0.1\n0.5 x 0.1 0.1\n").contains("line 2"));
    assert!(fault("0.3 0.1 0.1 nan\n").contains("not a row"));
    assert!(fault("0,3 0.1 0.1 0.1\n").contains("not a row"));
    assert!(fault("").contains("no rows"));
    assert!(fault("{ Thickness } thin\n").contains("thickness"));
    assert!(fault("0.4 0.1 0.1 0.1\n2.5 0.1 0.1 0.1\n").contains("0.3 to 2.5"));
    assert!(fault("0.3 0.1 0.1 0.1\n0.3 0.1 0.1 0.1\n").contains("ascend"));
    assert!(fault("0.3 1.1 0.1 0.1\n2.5 0.1 0.1 0.1\n").contains("within 0…1"));
    assert!(fault("0.3 0.9 0.1 0.2\n2.5 0.1 0.1 0.1\n").contains("more than 1"));
    assert!(from_json("{}").unwrap_err().to_string().contains("no spectral data"));
    assert!(from_json(r#"{"spectral_data": [{"T": 1}]}"#).unwrap_err().to_string().contains("incomplete"));
    assert!(from_json(r#"{"spectral_data": [{"diffuse": {"tf": "0.3"}}]}"#).unwrap_err().to_string().contains("scatters"));
    assert!(from_json(&"[".repeat(100_000)).is_err());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pane.json");
    std::fs::write(&path, "{ \"spectral_data\": ").unwrap();
    assert!(read_pane(&path).unwrap_err().to_string().contains("pane.json"));
}
