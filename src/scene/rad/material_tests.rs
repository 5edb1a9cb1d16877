//! Materials and patterns, against their definitions and against Radiance.

use super::*;
use crate::scene::Lobes;
use crate::testing;
use std::io::Write;

const SQUARE: &str = "m polygon p 0 0 12 -9 -9 0 9 -9 0 9 9 0 -9 9 0\n";

/// Reads a scene of one square, made of the last material, which is `m`.
fn read_with(text: &str, files: &[(&str, &[u8])]) -> (std::result::Result<MaterialKind, String>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    std::fs::write(folder.path().join("main.rad"), format!("{text}\n{SQUARE}")).unwrap();
    let mut warnings = Warnings::new();
    let scene = read_scene(&["main.rad".into()], folder.path(), &mut warnings);
    (scene.map(|s| s.materials[0].kind).map_err(|e| e.to_string()), warnings.iter().map(ToString::to_string).collect())
}

fn silent(text: &str) -> MaterialKind {
    let (kind, warnings) = read_with(text, &[]);
    assert_eq!(warnings, Vec::<String>::new(), "{text}");
    kind.unwrap()
}

fn warned(text: &str, what: &str) -> MaterialKind {
    let (kind, warnings) = read_with(text, &[]);
    assert!(warnings.len() == 1 && warnings[0].contains(what) && warnings[0].contains("help: "), "{text}: {warnings:?}");
    kind.unwrap()
}

fn refused(text: &str, what: &str) {
    let error = read_with(text, &[]).0.expect_err(text);
    assert!(error.contains(what) && error.contains("help: "), "{text}: {error}");
}

fn lobes(kind: MaterialKind) -> Lobes {
    let MaterialKind::Lobes(lobes) = kind else { panic!("{kind:?}") };
    lobes
}

fn close(a: [f64; 3], b: [f64; 3], most: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= most)
}

fn plastic(color: [f64; 3]) -> MaterialKind {
    MaterialKind::Plastic { color, specularity: 0.0, roughness: 0.0 }
}

#[test]
fn an_illum_is_its_alternate_material() {
    assert_eq!(silent("void plastic wall 0 0 5 .5 .4 .3 0 0\nvoid illum m 1 wall 0 3 9 9 9"), plastic([0.5, 0.4, 0.3]));
    assert_eq!(silent("void illum m 1 void 0 3 9 9 9"), MaterialKind::Void);
    assert_eq!(silent("void illum m 0 0 3 9 9 9"), MaterialKind::Void);
    // As in Radiance: the material as it stood before the illum.
    let earlier = "void plastic wall 0 0 5 .5 .4 .3 0 0\nvoid illum m 1 wall 0 3 9 9 9\nvoid plastic wall 0 0 5 .1 .1 .1 0 0";
    assert_eq!(silent(earlier), plastic([0.5, 0.4, 0.3]));
    refused("void illum m 1 missing 0 3 9 9 9", "'missing' is not defined");
}

#[test]
fn a_mixture_of_constant_share_is_its_mean() {
    let parts = "void plastic white 0 0 5 .8 .6 .4 0 0\nvoid plastic black 0 0 5 .1 .1 .1 0 0\nvoid trans cloth 0 0 7 .8 .8 .8 0 0 .5 .5\n";
    let mixed = lobes(silent(&format!("{parts}void mixfunc m 4 white black .25 . 0 0")));
    assert!(close(mixed.diffuse, [0.275, 0.225, 0.175], 1e-12) && mixed.specular_transmitted == [0.0; 3], "{mixed:?}");
    let open = lobes(silent(&format!("{parts}void mixfunc m 4 white void A1*2 . 0 1 .3")));
    assert!(close(open.diffuse, [0.48, 0.36, 0.24], 1e-12) && close(open.specular_transmitted, [0.4; 3], 1e-12), "{open:?}");
    let cloth = lobes(silent(&format!("{parts}void mixfunc m 4 cloth void .5 . 0 0")));
    assert!(close(cloth.diffuse, [0.2; 3], 1e-12) && close(cloth.diffuse_transmitted, [0.1; 3], 1e-12), "{cloth:?}");
    assert!(close(cloth.specular_transmitted, [0.6; 3], 1e-12), "{cloth:?}");
    // Of one, of two alike, of two patterns, of mixtures.
    assert_eq!(silent(&format!("{parts}void mixfunc m 4 white black 1 . 0 0")), plastic([0.8, 0.6, 0.4]));
    assert_eq!(silent(&format!("{parts}void mixfunc m 4 white white .3 . 0 0")), plastic([0.8, 0.6, 0.4]));
    let patterns = "void brightfunc a 2 .2 . 0 0\nvoid mixfunc b 4 a void .5 . 0 0\nb plastic m 0 0 5 .5 .5 .5 0 0";
    assert_eq!(silent(patterns), plastic([0.3; 3]));
    let nested = lobes(silent(&format!("{parts}void mixfunc n 4 white black .5 . 0 0\nvoid mixfunc m 4 n void .5 . 0 0")));
    assert!(close(nested.diffuse, [0.225, 0.175, 0.125], 1e-12), "{nested:?}");
    // Holes of radius 0.4 in squares of 1: the part of perforate.cal that is open.
    let holes =
        lobes(warned(&format!("{parts}void mixfunc m 6 white void z_hole perforate.cal -s .05 0 1 .4"), "50.27 % of the surface is open"));
    assert!(close(holes.specular_transmitted, [std::f64::consts::PI * 0.16; 3], 1e-12), "{holes:?}");
    let shiny = "void metal alu 0 0 5 .8 .8 .8 .05 .1\n";
    let shine = lobes(warned(&format!("{shiny}void mixfunc m 4 alu void .5 . 0 0"), "its shine, 2.0 % of the light, is taken as diffuse"));
    assert!(close(shine.diffuse, [0.4; 3], 1e-12) && shine.roughness == 0.0, "{shine:?}");
    // Fritted glass: half of 0.884… and what the paint reflects.
    let glass = "void glass pane 0 0 3 .96 .96 .96\n";
    let frit = lobes(warned(&format!("{parts}{glass}void mixfunc m 4 white pane .5 . 0 0"), "of diffuse light through in place of"));
    assert!(close(frit.diffuse, [0.4, 0.3, 0.2], 1e-12) && close(frit.specular_transmitted, [0.441; 3], 1e-3), "{frit:?}");
    refused(&format!("{parts}void mixfunc m 4 white black noise f.cal 0 0"), "varies over the surface");
    refused(&format!("{parts}void mixfunc m 4 white black 1.5 . 0 0"), "share of its foreground is 1.5");
    refused(&format!("{parts}void mirror mi 0 0 3 1 1 1\nvoid mixfunc m 4 white mi .5 . 0 0"), "a mirror in a mixture");
    refused("void metal a 0 0 5 .8 .8 .8 .9 .1\nvoid mixfunc m 4 a void .5 . 0 0", "different roughness");
    refused(&format!("{parts}white mixfunc m 4 white black .5 . 0 0"), "a mixture of materials with a modifier");
    refused("void mixfunc m 2 a b 0 0", "2 string arguments");
}

#[test]
fn a_pattern_colours_its_material_by_its_mean() {
    assert_eq!(silent("void brightfunc b 2 .5 . 0 0\nb plastic m 0 0 5 .8 .6 .4 0 0"), plastic([0.4, 0.3, 0.2]));
    assert_eq!(silent("void colorfunc b 4 A1 A1/2 1 . 0 1 .5\nb plastic m 0 0 5 .8 .6 .4 0 0"), plastic([0.4, 0.15, 0.4]));
    assert_eq!(silent("void brightfunc a 2 .5 . 0 0\na brightfunc b 2 .5 . 0 0\nb plastic m 0 0 5 .8 .8 .8 0 0"), plastic([0.2; 3]));
    assert_eq!(
        silent("void brightfunc b 2 .5 . 0 0\nb glass m 0 0 3 .8 .6 .4"),
        MaterialKind::Glass { transmissivity: [0.4, 0.3, 0.2], refraction_index: 1.52 }
    );
    // Through an alias that adds it, too; but not where nothing uses it.
    let base = "void plastic red 0 0 5 .8 .8 .8 0 0\nvoid brightfunc half 2 .5 . 0 0\n";
    assert_eq!(silent(&format!("{base}half alias m red")), plastic([0.4; 3]));
    assert_eq!(silent(&format!("{base}void brightdata other 3 a b.dat . 0 0\nother alias both red\nvoid alias m red")), plastic([0.8; 3]));
    assert_eq!(
        warned("void texfunc b 4 a b c bumps.cal 0 0\nb plastic m 0 0 5 .8 .6 .4 0 0", "texfunc is ignored"),
        plastic([0.8, 0.6, 0.4])
    );
    for pattern in [
        "brightfunc b 2 f(Px) f.cal 0 0",
        "colorfunc b 4 1 1 Nz . 0 0",
        "brightdata b 5 noop d.dat . Px Py 0 0",
        "brighttext b 2 f.fnt t.txt 0 11 0 0 0 1 0 0 0 1 0 0 1",
        "specdata b 3 noop d.dat . 0 0",
    ] {
        refused(&format!("void {pattern}\nb plastic m 0 0 5 .8 .6 .4 0 0"), "mean is not known");
        // What a lamp looks like is not asked for.
        assert!(matches!(silent(&format!("void {pattern}\nb light m 0 0 3 8 6 4")), MaterialKind::Light { .. }), "{pattern}");
    }
    refused("void brightfunc b 2 1+ . 0 0\nb plastic m 0 0 5 .8 .6 .4 0 0", "formula");
}

#[test]
fn a_spectrum_becomes_rgb_as_radiance_has_it() {
    let spectrum = |values: &str, n: usize| silent(&format!("void spectrum s 0 0 {} 780 380 {values}\ns plastic m 0 0 5 1 1 1 0 0", n + 2));
    let MaterialKind::Plastic { color, .. } = spectrum("1 1 1 1 1", 5) else { panic!() };
    assert!(close(color, [1.0; 3], 1e-9), "{color:?}");
    assert_eq!(spectrum(".8 .3 .1", 3), plastic([0.8, 0.3, 0.1]));
    // A smooth spectrum of brick at 81 wavelengths, which Radiance samples as finely.
    let values: Vec<f64> = (0..81).map(|k| 0.08 + 0.35 / (1.0 + ((k as f64 - 38.0) / 6.0).exp())).collect();
    let text: String = values.iter().map(|v| format!(" {v}")).collect();
    let definition = format!("void spectrum s 0 0 83 780 380{text}\ns");
    let MaterialKind::Plastic { color, .. } = silent(&format!("{definition} plastic m 0 0 5 .9 .9 .9 0 0")) else { panic!() };
    // The same as a data file, rising.
    let rising: String = values.iter().rev().map(|v| format!(" {v}")).collect();
    let file = format!("# brick\n1\n380 780 81\n{rising}\n");
    let (kind, _) = read_with("void specfile s 1 brick.dat 0 0\ns plastic m 0 0 5 .9 .9 .9 0 0", &[("brick.dat", file.as_bytes())]);
    let MaterialKind::Plastic { color: other, .. } = kind.unwrap() else { panic!() };
    assert!(close(color, other, 1e-12), "{color:?} {other:?}");
    let Some(seen) =
        radiance(&format!("{definition} glow m 0 0 4 .9 .9 .9 0"), "", &["-cs", "81", "-pRGB"], [0.0, 0.0, 1.0, 0.0, 0.0, -1.0])
    else {
        return;
    };
    // Radiance takes the nearest of the values for each of its 24 bands: up to 8.3 nm, two values, to either side.
    let shifted = |by: i32| {
        let value = |k: i32| values[(k + by).clamp(0, 80) as usize];
        let text: String = (0..81).map(|k| format!(" {}", value(k))).collect();
        let MaterialKind::Plastic { color, .. } = silent(&format!("void spectrum s 0 0 83 780 380{text}\ns plastic m 0 0 5 .9 .9 .9 0 0"))
        else {
            panic!()
        };
        color
    };
    let (low, high) = (shifted(2), shifted(-2));
    for c in 0..3 {
        let (least, most) = (low[c].min(high[c]), low[c].max(high[c]));
        assert!((least..=most).contains(&seen[c]) && (least..=most).contains(&color[c]), "{color:?} {seen:?} {low:?} {high:?}");
    }
    for (bad, what) in [("2 780 380", "no spectrum"), ("5 500 500 1 1 1", "no spectrum"), ("0", "do not make a spectrum")] {
        refused(&format!("void spectrum s 0 0 {bad}\ns plastic m 0 0 5 1 1 1 0 0"), what);
    }
    for bad in ["", "1 380 780 4 1 1 1", "2 0 1 2 380 780 2 1 1 1 1", "1 0 0 3 500 400 600 1 1 1", "x"] {
        let (kind, _) = read_with("void specfile s 1 s.dat 0 0\ns plastic m 0 0 5 1 1 1 0 0", &[("s.dat", bad.as_bytes())]);
        assert!(kind.unwrap_err().contains("s.dat"), "{bad}");
    }
    refused("void specfile s 1 missing.dat 0 0\ns plastic m 0 0 5 1 1 1 0 0", "does not exist");
}

#[test]
fn a_picture_on_a_surface_counts_by_its_mean() {
    let picture = crate::image::Picture::new(2, 1, vec![[0.5, 0.25, 1.0], [0.25, 0.75, 0.0]]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.hdr");
    hdr_write(&path, &picture);
    let bytes = std::fs::read(&path).unwrap();
    let text = |functions: &str| format!("void colorpict c 7 {functions} p.hdr . frac(U) frac(V) 0 0\nc plastic m 0 0 5 .8 .8 .8 0 0");
    let (kind, warnings) = read_with(&text("red green blue"), &[("p.hdr", &bytes)]);
    let MaterialKind::Plastic { color, .. } = kind.unwrap() else { panic!() };
    // Eight bits of the largest component.
    assert!(close(color, [0.3, 0.4, 0.4], 0.8 / 256.0), "{color:?}");
    assert!(warnings.len() == 1 && warnings[0].contains("the mean of its picture stands for it"), "{warnings:?}");
    let (kind, _) = read_with(&text("clipgrey clipgrey clipgrey"), &[("p.hdr", &bytes)]);
    let MaterialKind::Plastic { color, .. } = kind.unwrap() else { panic!() };
    let grey: f64 = [0.375, 0.5, 0.5].iter().zip(crate::units::BRIGHTNESS_WEIGHTS).map(|(c, w)| 0.8 * c * w).sum();
    assert!(close(color, [grey; 3], 0.8 / 256.0), "{color:?} {grey}");
    let (kind, _) = read_with(&text("mine green blue"), &[("p.hdr", &bytes)]);
    assert!(kind.unwrap_err().contains("'mine' of the picture's colours is not known"));
    let (kind, _) = read_with(&text("red green blue"), &[("p.hdr", b"no picture")]);
    assert!(kind.is_err());
}

fn hdr_write(path: &Path, picture: &crate::image::Picture) {
    crate::image::hdr::write(path, picture).unwrap();
}

/// Glazing in every published form: its definition, transmittance, reflectance of front and back.
fn glazings() -> Vec<(&'static str, f64, f64, f64)> {
    vec![
        ("void BRTDfunc m 10 .1 .1 .1 .6 .6 .6 0 0 0 . 0 9 0 0 0 0 0 0 0 0 0", 0.6, 0.1, 0.1),
        (
            "void BRTDfunc m 10 rR_clear rG_clear rB_clear .7*tR_clear .7*tG_clear .7*tB_clear 0 0 0 window.cal 0 15 0 0 0 0 0 0 0 0 0 .1 .1 .1 .16 .16 .16",
            0.7,
            0.1,
            0.16,
        ),
        (
            "void BRTDfunc m 10 sr_clear_r sr_clear_g sr_clear_b st_clear_r st_clear_g st_clear_b 0 0 0 glaze1.cal 0 19 0 0 0 0 0 0 0 0 0 1 .1 .1 .1 .2 .2 .2 .65 .65 .65",
            0.65,
            0.1,
            0.2,
        ),
        (
            "void BRTDfunc m 10 sr_frit_r sr_frit_g sr_frit_b st_frit_r st_frit_g st_frit_b 0 0 0 glaze1.cal 0 11 0 0 0 0 0 0 0 0 0 1 0",
            0.883,
            0.076,
            0.076,
        ),
        (
            "void BRTDfunc m 10 if(Rdot,cr(fr(.08),ft(.8),fr(.07)),cr(fr(.07),ft(.7),fr(.08))) if(Rdot,cr(fr(.08),ft(.8),fr(.07)),cr(fr(.07),ft(.7),fr(.08))) \
             if(Rdot,cr(fr(.08),ft(.8),fr(.07)),cr(fr(.07),ft(.7),fr(.08))) ft(.8)*tclr ft(.8)*tclr ft(.8)*tclr 0 0 0 glaze2.cal 0 9 0 0 0 0 0 0 0 0 0",
            0.7064,
            0.1248,
            0.1092,
        ),
    ]
}

#[test]
fn published_glazing_is_a_pane_of_its_transmittance_and_reflectance() {
    for (text, transmitted, front, back) in glazings() {
        let pane = lobes(warned(text, "it is taken as a pane that transmits"));
        let mean = (front + back) / 2.0;
        // Radiance's fit of clear glass is 0.1 % off at normal incidence.
        assert!(close(pane.specular_transmitted, [transmitted; 3], 1e-9) && close(pane.specular, [mean; 3], 1e-9), "{text}: {pane:?}");
        for (side, reflectance, cosine) in [(1.0, front, 1.0), (-1.0, back, 1.0), (1.0, front, 0.5)] {
            let sine = (1.0f64 - cosine * cosine).sqrt();
            let ray = [0.0, 0.0, side, sine, 0.0, -side * cosine];
            let sky = |towards: f64| format!("void glow white 0 0 4 1 1 1 0\nwhite source sky 0 0 4 0 0 {towards} 180\n");
            let Some(through) = radiance(text, &sky(-side), &["-lr", "8", "-lw", "1e-6"], ray) else { return };
            let Some(reflected) = radiance(text, &sky(side), &["-lr", "8", "-lw", "1e-6"], ray) else { return };
            let rise = crate::scene::pane::smooth_fresnel(cosine);
            // At 60° window.cal has a fit of its own, and constants stay what they are.
            let most = if cosine == 1.0 { 2e-3 } else { 0.06 };
            assert!((through[1] - transmitted * (1.0 - rise)).abs() < most, "{text} {side} {cosine}: {through:?}");
            assert!((reflected[1] - (reflectance + rise * (1.0 - reflectance))).abs() < most, "{text} {side} {cosine}: {reflected:?}");
        }
    }
    // Without specular parts there is nothing to say.
    let wall = lobes(silent("void BRTDfunc m 10 0 0 0 0 0 0 0 0 0 . 0 9 .5 .4 .3 .5 .4 .3 .1 .2 .3"));
    assert_eq!((wall.diffuse, wall.diffuse_transmitted), ([0.5, 0.4, 0.3], [0.1, 0.2, 0.3]));
    let nine = "0 9 0 0 0 0 0 0 0 0 0";
    refused(&format!("void BRTDfunc m 10 f f f 0 0 0 0 0 0 own.cal {nine}"), "'f' is neither constant");
    // Its transmittance falls faster than any that is known here.
    refused(
        &format!("void BRTDfunc m 10 sr_red sr_grn sr_blu st_red st_grn st_blu 0 0 0 glass3.cal {nine}"),
        "'sr_red' is neither constant",
    );
    refused(&format!("void BRTDfunc m 10 Rdot 0 0 0 0 0 0 0 0 . {nine}"), "'Rdot' is neither constant");
    refused(&format!("void BRTDfunc m 10 0 0 0 0 0 0 lobe 0 0 own.cal {nine}"), "'lobe' towards light sources");
    refused(&format!("void BRTDfunc m 10 .5 .5 .5 .6 .6 .6 0 0 0 . {nine}"), "sum to 1.1000");
    refused("void BRTDfunc m 10 0 0 0 0 0 0 0 0 0 . 0 9 .5 .5 .5 .2 .2 .2 0 0 0", "front and back reflect different");
    refused("void BRTDfunc m 3 0 0 0 0 9 .5 .5 .5 .2 .2 .2 0 0 0", "3 string and 9 real arguments");
}

#[test]
fn a_wgmd_of_constants_has_the_colours_of_its_patterns() {
    let patterns = "void colorfunc blue 4 .1 .2 1 . 0 0\nvoid brightfunc half 2 .5 . 0 0\n";
    let text = format!("{patterns}half WGMDfunc m 13 blue .1 .05 .05 void .2 A10 .05 inherit 0 0 1 . 0 10 .4 .3 .2 .4 .3 .2 .2 .2 .2 .05");
    let found = lobes(silent(&text));
    assert!(close(found.diffuse, [0.2, 0.15, 0.1], 1e-12) && close(found.diffuse_transmitted, [0.1; 3], 1e-12), "{found:?}");
    assert!(close(found.specular, [0.01, 0.02, 0.1], 1e-12) && close(found.specular_transmitted, [0.2; 3], 1e-12), "{found:?}");
    assert_eq!(found.roughness, 0.05);
    let plain = |strings: &str| format!("void WGMDfunc m 13 {strings} void 0 0 1 . 0 9 .4 .3 .2 .4 .3 .2 .2 .2 .2");
    assert_eq!(lobes(warned(&plain("void .1 .02 .08 void 0 0 0"), "taken as round")).roughness, 0.04);
    refused(&plain("void .1 .05 .05 void .2 .1 .1"), "of roughness 0.05 and transmission of roughness 0.1");
    refused(&plain("void 1-Rdot .05 .05 void .2 .1 .1"), "'1-Rdot' is not a constant");
    refused(&format!("void plastic w 0 0 5 1 1 1 0 0\n{}", plain("w .1 .1 .1 void 0 0 0")), "'w' is a material");
    refused("void WGMDfunc m 13 void 0 0 0 void 0 0 0 void 0 0 1 . 0 9 .5 .5 .5 .2 .2 .2 0 0 0", "front and back reflect different");
}

#[test]
fn brushed_surfaces_keep_their_light_and_lose_their_grain() {
    let four = "4 0 0 1 . 0";
    assert_eq!(
        warned(&format!("void metal2 m {four} 6 .5 .4 .3 .9 .02 .08"), "of roughness 0.0400"),
        MaterialKind::Metal { color: [0.5, 0.4, 0.3], specularity: 0.9, roughness: 0.04 }
    );
    assert_eq!(
        silent(&format!("void plastic2 m {four} 6 .5 .4 .3 .04 .1 .1")),
        MaterialKind::Plastic { color: [0.5, 0.4, 0.3], specularity: 0.04, roughness: 0.1 }
    );
    assert!(matches!(
        warned(&format!("void trans2 m {four} 8 .5 .4 .3 .04 .1 .4 .5 .6"), "roughness 0.2000"),
        MaterialKind::Trans { transmissivity: 0.5, transmitted_specularity: 0.6, .. }
    ));
    let varnish = lobes(warned(&format!("void ashik2 m {four} 8 .3 .2 .1 .2 .2 .2 49 199"), "taken as round"));
    assert_eq!((varnish.diffuse, varnish.specular), ([0.3, 0.2, 0.1], [0.2; 3]));
    assert!((varnish.roughness - (2.0f64 / 99.0).sqrt()).abs() < 1e-12);
    refused("void metal2 m 0 0 6 .5 .4 .3 .9 .02 .08", "0 string and 6 real arguments");
    refused(&format!("void ashik2 m {four} 8 .3 .2 .1 .2 .2 .2 -2 199"), "the argument -2 is negative");
}

#[test]
fn refracting_panes_transmit_as_they_do_in_radiance() {
    let face = lobes(warned("void dielectric m 0 0 5 1 1 1 1.5 0", "reflects 4.00 % and lets the rest pass undeflected"));
    assert!(close(face.specular, [0.04; 3], 1e-12) && close(face.specular_transmitted, [0.96; 3], 1e-12));
    warned("void dielectric m 0 0 5 .9 1 1 1.5 0", "its absorption is left out");
    let face = lobes(warned("void interface m 0 0 8 1 1 1 1.5 1 1 1 1.33", "reflects 0.36 %"));
    assert!((face.specular[0] - (0.17f64 / 2.83).powi(2)).abs() < 1e-12);
    refused("void dielectric m 0 0 5 1 1 1 .5 0", "refraction index is 0.5");
    refused("void dielectric m 0 0 0", "0 string and 0 real arguments");
    // Two faces a hundredth apart: what a pane of both lets through, all reflections between them included.
    let pane = "void dielectric m 0 0 5 1 1 1 1.5 0\nm polygon q 0 0 12 -9 -9 -.01 -9 9 -.01 9 9 -.01 9 -9 -.01\n";
    let below = "void glow white 0 0 4 1 1 1 0\nwhite source below 0 0 4 0 0 -1 180\n";
    for cosine in [1.0, 0.8, 0.5, 0.3] {
        let sine = (1.0f64 - cosine * cosine).sqrt();
        let ray = [0.0, 0.0, 1.0, sine, 0.0, -cosine];
        let Some(through) = radiance(pane, below, &["-lr", "20", "-lw", "1e-7", "-st", "0"], ray) else { return };
        let one = 0.04 + 0.96 * crate::scene::pane::smooth_fresnel(cosine);
        let both = (1.0 - one) / (1.0 + one);
        // Fresnel's law against its approximation.
        assert!((through[1] - both).abs() < 0.02, "{cosine}: {through:?} {both}");
    }
}

#[test]
fn a_scene_s_own_sky_is_left_out_with_one_warning() {
    let sky = "!gensky 6 21 +12 -a 40 -o 75 -m 75\nskyfunc glow skyglow 0 0 4 1 1 1 0\nskyglow source sky 0 0 4 0 0 1 180\n\
        skyfunc glow groundglow 0 0 4 1 .8 .5 0\ngroundglow source ground 0 0 4 0 0 -1 180\n!gendaylit 6 21 12 -W 500 100 | xform -rz 3\n\
        void plastic m 0 0 5 .5 .5 .5 0 0\n";
    assert_eq!(warned(sky, "the sky comes from the weather"), plastic([0.5; 3]));
    // Also where the output of gensky was kept.
    let kept = "void light solar 0 0 3 9 9 9\nvoid brightfunc skyfunc 2 skybr skybright.cal 0 7 1 2 3 4 5 6 7\nskyfunc glow skyglow 0 0 4 1 1 1 0\n\
        skyglow source sky 0 0 4 0 0 1 180\nvoid plastic m 0 0 5 .5 .5 .5 0 0\n";
    assert_eq!(warned(kept, "the sky comes from the weather"), plastic([0.5; 3]));
}

#[test]
fn what_cannot_be_read_names_the_way_round() {
    refused("void antimatter m 2 void void 0 0", "polygon 'p': it is made of `antimatter` ('m')");
    refused("void mesh me 1 a.rtm 0 0\nvoid plastic m 0 0 5 0 0 0 0 0", "give the OBJ file");
    refused("void instance i 1 a.oct 0 0\nvoid plastic m 0 0 5 0 0 0 0 0", "give the `.rad` files that it was made from");
    let deep: String = (1..400).map(|i| format!("p{} brightfunc p{i} 2 1 . 0 0\n", i - 1)).collect();
    refused(&format!("void brightfunc p0 2 1 . 0 0\n{deep}p399 plastic m 0 0 5 0 0 0 0 0"), "modifiers stand behind each other");
    // Every mixture of two mixtures, again and again.
    let many: String = (1..200).map(|i| format!("void mixfunc x{i} 4 x{0} x{0} .5 . 0 0\n", i - 1)).collect();
    assert_eq!(silent(&format!("void plastic x0 0 0 5 .5 .5 .5 0 0\n{many}void alias m x199")), plastic([0.5; 3]));
}

/// What rtrace sees along a ray in a scene with `m` as the square, against a sky; RGB.
fn radiance(material: &str, sky: &str, options: &[&str], ray: [f64; 6]) -> Option<[f64; 3]> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("main.rad"), format!("{material}\n{SQUARE}{sky}")).unwrap();
    let octree = testing::output(testing::radiance("oconv")?.current_dir(folder.path()).args(["-w", "main.rad"]));
    std::fs::write(folder.path().join("main.oct"), octree).unwrap();
    let mut input = tempfile::tempfile().unwrap();
    writeln!(input, "{}", ray.map(|v| v.to_string()).join(" ")).unwrap();
    std::io::Seek::rewind(&mut input).unwrap();
    let mut rtrace = testing::radiance("rtrace")?;
    rtrace.current_dir(folder.path()).args(["-h", "-w", "-ab", "0"]).args(options).arg("main.oct").stdin(input);
    let out = String::from_utf8(testing::output(&mut rtrace)).unwrap();
    let values: Vec<f64> = out.split_whitespace().map(|w| w.parse().unwrap()).collect();
    Some([values[0], values[1], values[2]])
}
