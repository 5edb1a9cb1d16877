//! Tables, their faults, and the data made of them.

use super::*;
use crate::bins::KlemsBasis;
use crate::bsdf::{Bsdf, Component, write};
use crate::matrix::file::read_matrix_from;
use crate::testing;

const TABLE: &str = "# θ Ts Td Rs Rd\n0 .50 .10 .05 .08\n30 .48 .10 .05 .08\n60 .35 .09 .10 .09\n85 .05 .03 .40 .10\n90 0 0 .6 .1\n\
                     95 .05 .03 .40 .10\n120 .35 .09 .10 .09\n150 .48 .10 .05 .08\n180 .50 .10 .05 .08\n";

fn blocks(text: &str, basis: &AngleBasis) -> (Blocks, usize) {
    let mut warnings = Warnings::new();
    let blocks = AngularTable::parse(text, &mut warnings).unwrap().to_blocks(basis, &mut warnings);
    (blocks, warnings.iter().count())
}

/// ∫ of one column over the hemisphere by a fine sum, apart from the code under test's rings.
fn integral(columns: &[usize], samples: &[Sample]) -> f64 {
    let curves: Vec<Curve> = columns.iter().map(|k| Curve::new(samples, *k)).collect();
    let n = 200_000;
    (0..n)
        .map(|k| {
            let theta = (k as f64 + 0.5) / n as f64 * 90.0;
            curves.iter().map(|c| c.at(theta)).sum::<f64>() * (2.0 * theta.to_radians()).sin() * PI / 2.0 / n as f64
        })
        .sum()
}

#[test]
fn hemispherical_values_are_those_of_the_table_and_the_specular_part_is_on_the_diagonal() {
    let table = AngularTable::parse(TABLE, &mut Warnings::new()).unwrap();
    for basis in KlemsBasis::ALL.map(AngleBasis::from) {
        let (blocks, warned) = blocks(TABLE, &basis);
        assert_eq!(warned, 0);
        for (component, columns) in [(Component::TransmissionFront, [0, 1]), (Component::ReflectionBack, [2, 3])] {
            let block = blocks.get(component).unwrap();
            let wanted = integral(&columns, &table.front);
            assert!((block.hemispherical() - wanted).abs() < 1e-6, "{component:?}: {} {wanted}", block.hemispherical());
            let m = block.as_klems().unwrap();
            let lambda = projected_solid_angles(&basis);
            // Off the diagonal there is only the separable part; the cap has no opposite bin.
            let diffuse = |i: usize| {
                if i > 0 { m.at(basis.opposite(i), i) } else { m.at(0, 1) * m.at(1, 0) / m.at(basis.opposite(1), 1) }
            };
            let specular: f64 = (0..basis.len()).map(|i| (m.at(i, i) - diffuse(i)) * lambda[i] * lambda[i]).sum::<f64>() / PI;
            let own = if component.is_transmission() { 0 } else { 2 };
            assert!((specular - integral(&[own], &table.front)).abs() < 1e-6);
        }
        let t = blocks.transmission_front.as_ref().unwrap();
        // The mean over the cap of 5 to 9° instead of the value at 0°.
        assert!((t.direct_hemispherical_at(0.0) - 0.6).abs() < 2e-3, "{}", t.direct_hemispherical_at(0.0));
    }
}

#[test]
fn both_sides_are_reciprocal_and_no_energy_is_made() {
    let basis = AngleBasis::from(KlemsBasis::Full);
    // Different reflectance on the two sides.
    let asymmetric = TABLE.replace("150 .48 .10 .05 .08", "150 .48 .10 .25 .02").replace("180 .50 .10 .05 .08", "180 .50 .10 .25 .02");
    let (blocks, _) = blocks(&asymmetric, &basis);
    let matrix = |c| blocks.get(c).unwrap().as_klems().unwrap();
    for (c, d) in [(Component::TransmissionFront, Component::TransmissionBack), (Component::ReflectionBack, Component::ReflectionBack)] {
        let reversed = matrix(d).reversed();
        for (a, b) in matrix(c).values().iter().zip(reversed.values()) {
            assert!((a - b).abs() < 1e-9 * b.abs().max(1.0));
        }
    }
    for i in 0..basis.len() {
        for (t, r) in [(Component::TransmissionFront, Component::ReflectionFront), (Component::TransmissionBack, Component::ReflectionBack)]
        {
            assert!(matrix(t).direct_hemispherical(i) + matrix(r).direct_hemispherical(i) <= 1.0);
        }
    }
    assert!(matrix(Component::ReflectionBack).hemispherical() > matrix(Component::ReflectionFront).hemispherical() + 0.02);
}

#[test]
fn contradictions_are_warned_about_and_impossible_tables_refused() {
    let basis = AngleBasis::from(KlemsBasis::Quarter);
    assert_eq!(blocks(&TABLE.replace("150 .48 .10", "150 .48 .02"), &basis).1, 1);
    assert_eq!(blocks(&TABLE.replace("150 .48 .10", "150 .28 .10"), &basis).1, 1);
    assert_eq!(blocks("5 .5 .1 .05 .05\n60 .4 .1 .1 .1\n", &basis).1, 2);
    let fails = |text: &str| AngularTable::parse(text, &mut Warnings::new()).unwrap_err().to_string();
    assert!(fails("0 .5 .1 .05").contains("line 1"));
    assert!(fails("0 .5 .1 .05 x").contains("5 numbers"));
    assert!(fails("0 .5 .1 .05 nan").contains("5 numbers"));
    assert!(fails("theta Ts Td Rs\n0 .5 .1 .05 .1").contains("line 1: the header 'theta Ts Td Rs' names some"));
    assert!(fails(",Ts,Td,Rs,Rs,Rd\n0,.5,.1,.05,.1,.1").contains("names rs twice"));
    assert!(fails(",Ts,Td,Rs,Rd,Tvis\n0,.5,.1,.05,.1").contains("line 2: '0,.5,.1,.05,.1' is not a row of 6"));
    assert!(fails("theta,Ts,Td,Rs,Rd\n0,.5,.1,.05,.1\nTs,Td,Rs,Rd,theta\n").contains("line 3"));
    assert!(fails("0 .5 .1 .5 .1\n90 0 0 1 0").contains("more than 1"));
    assert!(fails("0 -.5 .1 .5 .1\n90 0 0 1 0").contains("within 0…1"));
    assert!(fails("0 .5 .1 .1 .1\n20 .5 .1 .1 .1").contains("ends at 20"));
    assert!(fails("0 .5 .1 .1 .1\n0 .5 .1 .1 .1").contains("do not ascend"));
    assert!(fails("190 .5 .1 .1 .1").contains("outside"));
    assert!(fails("# nothing").contains("no row"));
}

#[test]
fn a_header_says_where_the_columns_stand() {
    let wanted = AngularTable::parse(TABLE, &mut Warnings::new()).unwrap();
    let rows: Vec<Vec<&str>> = TABLE.lines().skip(1).map(|row| row.split_whitespace().collect()).collect();
    let cases: [(&str, &str, &[usize]); 11] = [
        (",Ts,Td,Rs,Rd", ",", &[0, 1, 2, 3, 4]),
        ("theta,Ts,Td,Rs,Rd", ",", &[0, 1, 2, 3, 4]),
        ("th Ts Td Rs Rd", " ", &[0, 1, 2, 3, 4]),
        ("Ts Td Rs Rd", " ", &[0, 1, 2, 3, 4]),
        ("angle tau tau_d rho rho_d", " ", &[0, 1, 2, 3, 4]),
        ("\u{feff}theta;Rd;Rs;Td;Ts", ";", &[0, 4, 3, 2, 1]),
        ("# film\n\n\"T_s\"\t\"T_d\"\t\"R_s\"\t\"R_d\"\t\"theta [deg]\"", "\t", &[1, 2, 3, 4, 0]),
        ("TS (-), RS (-), theta, TD (-), RD (-)", ", ", &[1, 3, 0, 2, 4]),
        ("Rs Rd Ts Td", " ", &[0, 3, 4, 1, 2]),
        ("theta,Ts,Td,Rs,Rd,Tvis", ",", &[0, 1, 2, 3, 4, 1]),
        ("theta,Tvis,Td,Ts,Rs,Rd,\r", ",", &[0, 3, 2, 1, 3, 4]),
    ];
    for (header, separator, order) in cases {
        let row = |row: &Vec<&str>| order.iter().map(|column| row[*column]).collect::<Vec<_>>().join(separator) + "\n";
        let text = format!("{header}\n{}", rows.iter().map(row).collect::<String>());
        let found = AngularTable::parse(&text, &mut Warnings::new()).unwrap_or_else(|e| panic!("{header}: {e}"));
        assert_eq!(found, wanted, "{header}");
    }
}

#[test]
fn the_roos_model_has_its_published_shape() {
    // Clear double glazing, p = 2, q = 4: from the formula, z = 2/3 at 60°.
    let z: f64 = 2.0 / 3.0;
    let wanted = 1.0 - 8.0 * z.powf(8.0) - 0.0625 * z.powi(2) + 7.0625 * z.powf(5.38 + 0.81 * 4.0);
    assert!((roos_share(60.0, 2, 4.0) - wanted).abs() < 1e-12);
    assert!((0.80..0.95).contains(&wanted), "{wanted}");
    assert_eq!((roos_share(0.0, 2, 4.0), roos_share(90.0, 2, 4.0).abs() < 1e-12), (1.0, true));
    let normal = Sample {
        theta: 0.0,
        specular_transmittance: 0.6,
        diffuse_transmittance: 0.1,
        specular_reflectance: 0.1,
        diffuse_reflectance: 0.05,
    };
    let table = AngularTable::roos(normal, normal, 2, 4.0, &mut Warnings::new()).unwrap();
    let grazing = table.front.last().unwrap();
    assert!((grazing.specular_reflectance - 1.0).abs() < 1e-9 && grazing.specular_transmittance < 1e-9);
    assert!((table.front[0].specular_reflectance - 0.1).abs() < 1e-12);
    assert!(AngularTable::roos(normal, normal, 1, f64::NAN, &mut Warnings::new()).is_err());
}

/// First rows of a table of a PDLC pane as a study printed them (Roos' polynomial of beam and diffuse transmittance).
const PDLC: &str = "0.0,0.5192166899999999,0.04201341999999999,0.2,0.2
1.0,0.5192112358995501,0.04201297867094156,0.2,0.2
2.0,0.5191948735961853,0.04201165468360318,0.2,0.2
3.0,0.5191676030592118,0.04200944803550123,0.2,0.2
4.0,0.519129424110523,0.04200635871222384,0.2,0.2
5.0,0.5190803361231647,0.04200238666303984,0.2,0.2
";
/// The category of those rows, found from them: 0.25/q is the limit of (1 − τ/τ₀)/z² towards the normal.
const PDLC_CATEGORY: f64 = 2.938_194_239_920_6;

/// A whole table with the header of the study, θ = 0…90°, with these transmittances at the normal.
fn pdlc(ts: f64, td: f64) -> String {
    let row = |degrees: u32| {
        let share = roos_share(f64::from(degrees), 0, PDLC_CATEGORY);
        format!("{degrees}.0,{},{},0.2,0.2\n", ts * share, td * share)
    };
    format!(",Ts,Td,Rs,Rd\n{}", (0..=90).map(row).collect::<String>())
}

#[test]
fn the_rows_of_a_pdlc_study_are_the_roos_polynomial_without_terms_of_panes() {
    let [printed, _] = rows::rows(PDLC, true).unwrap();
    let normal = printed[0];
    for panes in [0, 1] {
        let table = AngularTable::roos(normal, normal, panes, PDLC_CATEGORY, &mut Warnings::new()).unwrap();
        let worst = |column: usize| {
            printed.iter().zip(&table.front).map(|(a, b)| (a.values()[column] - b.values()[column]).abs()).fold(0.0, f64::max)
        };
        // To the last digit with p = 0. One pane is off in the ninth digit already within the first five degrees.
        assert_eq!(worst(0).max(worst(1)) < 5e-16, panes == 0, "p = {panes}: {:e} {:e}", worst(0), worst(1));
    }
    let table = AngularTable::parse(&pdlc(normal.specular_transmittance, normal.diffuse_transmittance), &mut Warnings::new()).unwrap();
    assert_eq!(table.front.len(), 91);
    for (read, printed) in table.front.iter().zip(&printed) {
        assert!(read.values().iter().zip(printed.values()).all(|(a, b)| (a - b).abs() < 5e-16), "{read:?} {printed:?}");
    }
    assert!(table.front[90].transmittance() < 1e-15);
}

#[test]
fn dummy_reflectances_are_warned_about_and_can_be_replaced() {
    let text = pdlc(0.519_216_69, 0.042_013_42);
    let warned = |text: &str| {
        let mut warnings = Warnings::new();
        AngularTable::parse(text, &mut warnings).unwrap();
        warnings.iter().map(ToString::to_string).collect::<String>()
    };
    assert!(warned(&text).contains("Rs is 0.2 at all angles, as dummy values are"));
    assert_eq!(warned(TABLE), "");
    // The table's transmittance is Roos'; so with its own values at the normal the two must agree.
    let mut warnings = Warnings::new();
    let table = AngularTable::parse_transmittance(&text, [0.08, 0.03], [0.10, 0.02], &mut warnings).unwrap();
    let normal = |rs, rd| Sample {
        theta: 0.0,
        specular_transmittance: 0.519_216_69,
        diffuse_transmittance: 0.042_013_42,
        specular_reflectance: rs,
        diffuse_reflectance: rd,
    };
    let wanted = AngularTable::roos(normal(0.08, 0.03), normal(0.10, 0.02), 0, PDLC_CATEGORY, &mut warnings).unwrap();
    for (found, wanted) in [(&table.front, &wanted.front), (&table.back, &wanted.back)] {
        for (a, b) in found.iter().zip(wanted) {
            assert!(a.values().iter().zip(b.values()).all(|(a, b)| (a - b).abs() < 1e-14), "{a:?} {b:?}");
            assert!(a.values().iter().sum::<f64>() <= 1.0 + 1e-12);
        }
    }
    assert_eq!((table.front[0].specular_reflectance * 1e9).round(), 0.08e9);
    assert!((table.front[90].specular_reflectance - 1.0).abs() < 1e-12);
    assert!(warnings.is_empty());
    // Dummy values that would make light, missing columns, and an opaque sheet.
    let transmittance = |text: &str| AngularTable::parse_transmittance(text, [0.08, 0.03], [0.08, 0.03], &mut Warnings::new());
    let more_than_all = text.replace("0.2,0.2", "0.5,0.5");
    assert!(AngularTable::parse(&more_than_all, &mut Warnings::new()).unwrap_err().to_string().contains("line 2: at 0°"));
    let cut = |from: &str| from.replace(",0.2,0.2", "").replace(",Rs,Rd", "");
    for text in [more_than_all, cut(&text), cut(&text).replace(",Ts,Td\n", "").replace(',', " ")] {
        assert_eq!(transmittance(&text).unwrap().front, table.front);
    }
    assert!(AngularTable::parse(&cut(&text), &mut Warnings::new()).unwrap_err().to_string().contains("some of the columns only"));
    let opaque = transmittance("0 0 0\n90 0 0\n").unwrap();
    assert!(opaque.front.iter().all(|s| (s.specular_reflectance - 0.08).abs() < 1e-12 && s.diffuse_reflectance == 0.03));
    assert!(transmittance("0 .8 .15\n90 0 0\n").unwrap_err().to_string().contains("more than 1"));
}

#[test]
fn radiance_finds_the_same_direct_hemispherical_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("iso.xml");
    let full = AngleBasis::from(KlemsBasis::Full);
    let bsdf = Bsdf { visible: blocks(TABLE, &full).0, ..Bsdf::default() };
    write(Some(&path), &bsdf, "").unwrap();
    let Some(mut rmtxop) = testing::radiance("rmtxop") else { return };
    let t = read_matrix_from::<f64>(testing::output(rmtxop.arg("-fd").arg(&path)).as_slice()).unwrap().matrix;
    let lambda = projected_solid_angles(&full);
    let ours = bsdf.visible.transmission_front.as_ref().unwrap().as_klems().unwrap();
    for i in 0..145 {
        let theirs: f64 = (0..145).map(|o| t.at(o, i)[0] * lambda[o]).sum::<f64>() / lambda[i];
        assert!((theirs - ours.direct_hemispherical(i)).abs() < 1e-3, "bin {i}: {theirs} {}", ours.direct_hemispherical(i));
    }
}
