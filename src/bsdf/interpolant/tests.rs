use super::*;
use crate::bins::{AngleBasis, KlemsBasis};
use crate::bsdf::scans::{Scan, Scans, angle};
use crate::error::Warnings;
use std::path::Path;

fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((s, c), (y, x)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(s * x, s * y, c)
}

/// DSF of a lobe of 3° around `centre` that has 20 % of the light, and of white paper with 10 %.
fn truth(centre: DVec3, out: DVec3) -> f64 {
    let s = 3f64.to_radians();
    0.2 / (TAU * s * s) * ((centre.dot(out) - 1.0) / (s * s)).exp() + 0.1 / std::f64::consts::PI * out.z
}

/// A scan every 1.2° of what `centre` says of the direction of travel.
fn scan(incident: DVec3, centre: impl Fn(DVec3) -> DVec3) -> Scan {
    let mut scan = Scan::new(incident, Component::TransmissionFront, Path::new("made"));
    for ring in 0..75 {
        let theta = 1.2 * (f64::from(ring) + 0.5);
        let count = (300.0 * theta.to_radians().sin()).ceil() as usize;
        for k in 0..count {
            let out = direction(theta, 360.0 * k as f64 / count as f64);
            scan.add(out, truth(centre(incident), out));
        }
    }
    scan
}

fn scans(all: Vec<Scan>) -> Scans {
    Scans { name: "cloth".into(), component: Component::TransmissionFront, scans: all }
}

fn fitted(all: Vec<Scan>) -> (Interpolant, Warnings) {
    let mut warnings = Warnings::new();
    (fit(&scans(all), &FitOptions::default(), &mut warnings).unwrap(), warnings)
}

/// Straight through, isotropic, measured every 20° up to 60°.
fn isotropic() -> Interpolant {
    let (found, warnings) = fitted([0.0, 20.0, 40.0, 60.0].map(|t| scan(direction(t, 270.0), |d| d)).into());
    assert!(warnings.is_empty(), "{:?}", warnings.iter().map(ToString::to_string).collect::<Vec<_>>());
    found
}

#[test]
fn lobes_meet_the_samples_and_their_integral() {
    let found = isotropic();
    assert_eq!(found.symmetry, Symmetry::Isotropic);
    for d in &found.distributions {
        let mass: f64 = d.lobes.iter().map(|l| l.mass).sum();
        assert!((mass - 0.3).abs() < 0.003, "θ {}: {mass}", angle(d.incident, DVec3::Z));
        for out in [d.incident, direction(angle(d.incident, DVec3::Z) + 3.0, 0.0), direction(30.0, 180.0)] {
            let (f, t) = (dsf(&d.lobes, out), truth(d.incident, out));
            assert!((f - t).abs() < 0.05 * t, "{f} {t}");
        }
    }
}

#[test]
fn a_peak_moves_between_measured_directions() {
    let found = isotropic();
    for theta in [5.0, 10.0, 15.0, 30.0, 50.0] {
        for phi in [270.0, 10.0] {
            let light = direction(theta, phi);
            let there = peak(&found, light);
            assert!(angle(there.direction, light) < 0.5, "θ {theta}: {}", angle(there.direction, light));
            // Full width at half of a Gaussian of σ = 3°: 7.06°.
            assert!((there.width - 7.06).abs() < 1.0, "θ {theta}: {}", there.width);
            // Faded between its neighbours, the peak would be less than a tenth.
            let (f, t) = (found.evaluate(light, light) * light.z, truth(light, light));
            assert!((f / t - 1.0).abs() < 0.15, "θ {theta}: {f} {t}");
            assert!((found.direct_hemispherical(light) - 0.3).abs() < 0.003);
        }
    }
    // Beyond the last measured direction it goes on with the light.
    let beyond = direction(66.0, 270.0);
    assert!(angle(peak(&found, beyond).direction, beyond) < 2.0);
}

#[test]
fn a_sample_measured_in_one_half_is_mirrored_into_the_other() {
    // Light leaves turned by 15° in azimuth: the mirror image turns it the other way.
    let turned = |d: DVec3| {
        let (s, c) = 15f64.to_radians().sin_cos();
        DVec3::new(c * d.x - s * d.y, s * d.x + c * d.y, d.z)
    };
    let mut all = vec![scan(DVec3::Z, turned)];
    for theta in [30.0, 60.0] {
        all.extend([180.0, 225.0, 270.0, 315.0, 360.0].map(|phi| scan(direction(theta, phi), turned)));
    }
    let (found, warnings) = fitted(all.clone());
    assert!(warnings.is_empty(), "{:?}", warnings.iter().map(ToString::to_string).collect::<Vec<_>>());
    assert_eq!(found.symmetry, Symmetry::Bilateral);
    let light = direction(45.0, 250.0);
    assert!(angle(peak(&found, light).direction, turned(light)) < 1.0, "{}", angle(peak(&found, light).direction, turned(light)));
    let image = mirrored(light, MIRROR_Y);
    assert!(angle(peak(&found, image).direction, mirrored(turned(light), MIRROR_Y)) < 1.0);
    for out in [direction(20.0, 30.0), turned(light), direction(50.0, 260.0)] {
        let (a, b) = (found.evaluate(out, light), found.evaluate(mirrored(out, MIRROR_Y), image));
        assert!((a - b).abs() < 1e-9 * a, "{a} {b}");
    }
    // Turned by 180° is the other thing that half a circle can mean.
    let up = FitOptions { symmetry: Some(Symmetry::Up), ..FitOptions::default() };
    let found = fit(&scans(all), &up, &mut Warnings::new()).unwrap();
    let image = mirrored(light, MIRROR_X | MIRROR_Y);
    assert!(angle(peak(&found, image).direction, turned(image)) < 1.0);
}

#[test]
fn symmetries_and_directions_that_do_not_fit_are_refused() {
    let all: Vec<Scan> = [0.0, 30.0, 60.0].map(|t| scan(direction(t, 270.0), |d| d)).into();
    for wanted in [Symmetry::Quadrilateral, Symmetry::Bilateral, Symmetry::Anisotropic] {
        let options = FitOptions { symmetry: Some(wanted), ..FitOptions::default() };
        let error = fit(&scans(all.clone()), &options, &mut Warnings::new()).unwrap_err().to_string();
        assert!(error.contains("isotropic") && error.contains(wanted.name()), "{error}");
    }
    // Two azimuths in one plane are no mesh.
    let flat = vec![scan(direction(30.0, 0.0), |d| d), scan(DVec3::Z, |d| d), scan(direction(30.0, 180.0), |d| d)];
    let error = fit(&scans(flat), &FitOptions::default(), &mut Warnings::new()).unwrap_err().to_string();
    assert!(error.contains("do not span a mesh"), "{error}");
    assert_eq!(Symmetry::by_name("BI").unwrap(), Symmetry::Bilateral);
    assert!(Symmetry::by_name("").is_err() && Symmetry::by_name("round").is_err());
}

#[test]
fn what_is_short_or_too_bright_is_said() {
    let (_, warnings) = fitted([0.0, 30.0].map(|t| scan(direction(t, 0.0), |d| d)).into());
    assert!(warnings.iter().any(|w| w.to_string().contains("beyond θ = 30°")));
    let bright = |t: f64| {
        let mut s = Scan::new(direction(t, 0.0), Component::TransmissionFront, Path::new("made"));
        for cell in 0..crate::bsdf::scans::CELLS {
            let out = crate::bsdf::scans::cell_direction(cell, crate::bsdf::scans::SIDE);
            s.add(out, 1.02 / std::f64::consts::PI * out.z);
        }
        s
    };
    let (_, warnings) = fitted([0.0, 75.0].map(bright).into());
    assert!(warnings.iter().any(|w| w.to_string().contains("more light leaves than arrives")));
}

#[test]
fn trees_and_matrices_keep_the_light_of_each_direction() {
    let found = isotropic();
    let klems = to_klems(&found, &AngleBasis::from(KlemsBasis::Full), &AngleBasis::from(KlemsBasis::Full));
    for bin in 0..145 {
        assert!((klems.direct_hemispherical(bin) - 0.3).abs() < 0.003, "{bin}: {}", klems.direct_hemispherical(bin));
    }
    // What passes straight falls into the bin of the same number.
    for bin in [0, 10, 60, 110] {
        let column: Vec<f64> = (0..145).map(|o| klems.at(o, bin)).collect();
        assert_eq!(column.iter().copied().fold(0.0, f64::max), column[bin], "{bin}");
    }
    for (rank, log2) in [(3, 5), (4, 4)] {
        let tree = to_tree(&found, rank, log2, 0.0).unwrap();
        let light = direction(35.0, 270.0);
        assert!((tree.direct_hemispherical(light) - 0.3).abs() < 0.004, "{rank}: {}", tree.direct_hemispherical(light));
        let smaller = to_tree(&found, rank, log2, 80.0).unwrap();
        assert!(smaller.len() * 4 <= tree.len(), "{} of {}", smaller.len(), tree.len());
        assert!((smaller.hemispherical() / tree.hemispherical() - 1.0).abs() < 0.01);
    }
    for (rank, log2, reduce) in [(5, 4, 0.0), (4, 7, 0.0), (3, 1, 0.0), (4, 4, 100.0), (4, 4, f64::NAN)] {
        assert!(to_tree(&found, rank, log2, reduce).is_err());
    }
}

#[test]
fn a_file_gives_the_interpolant_back_and_damage_is_found() {
    let found = isotropic();
    let mut bytes = Vec::new();
    write_to(&mut bytes, &found, "a test").unwrap();
    let back = read_from(&bytes, &mut Warnings::new()).unwrap();
    assert_eq!((back.symmetry, back.component, &back.name, back.lobes()), (found.symmetry, found.component, &found.name, found.lobes()));
    let (light, out) = (direction(33.0, 250.0), direction(30.0, 240.0));
    let (a, b) = (found.evaluate(out, light), back.evaluate(out, light));
    assert!((a - b).abs() < 1e-4 * a, "{a} {b}");
    // Written again it does not drift.
    let mut again = Vec::new();
    write_to(&mut again, &back, "a test").unwrap();
    let c = read_from(&again, &mut Warnings::new()).unwrap().evaluate(out, light);
    assert!((c - b).abs() < 1e-5 * b, "{b} {c}");
    // A damaged end leaves Radiance's part, with a warning.
    let mut damaged = bytes.clone();
    *damaged.last_mut().unwrap() ^= 1;
    let mut warnings = Warnings::new();
    let rough = read_from(&damaged, &mut warnings).unwrap();
    assert!(!warnings.is_empty());
    assert!((rough.direct_hemispherical(light) - 0.3).abs() < 0.01, "{}", rough.direct_hemispherical(light));
    assert!(angle(peak(&rough, light).direction, light) < 1.0);
    // Cut off anywhere it is an error or its first part, never a panic.
    for length in (0..bytes.len()).step_by(bytes.len() / 60) {
        let _ = read_from(&bytes[..length], &mut Warnings::new());
    }
}
