//! Lookup and integrals of trees, and what no tree is.

use super::*;

/// f = .1 + .1 ix + .01 iy + .001 ox + .0001 oy on 8⁴ cells, one level of branches.
fn text_of_rank4() -> String {
    let f = |i: [usize; 4]| 0.1 + 0.1 * i[0] as f64 + 0.01 * i[1] as f64 + 0.001 * i[2] as f64 + 0.0001 * i[3] as f64;
    let mut text = String::from("{\n");
    for child in 0..16usize {
        text.push('{');
        for index in 0..256usize {
            let digit = |d: usize| (child >> d & 1) * 4 + index / 4usize.pow(3 - d as u32) % 4;
            text.push_str(&format!(" {:.4}", f([digit(0), digit(1), digit(2), digit(3)])));
        }
        text.push_str(" }\n");
    }
    text + "}\n"
}

fn direction(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

#[test]
fn rank_4_has_the_values_that_radiance_finds() {
    // rtrace of such a tree, see bsdf_t.c; incident along the second argument.
    let tree = TensorTree::parse(&text_of_rank4(), 4).unwrap();
    assert_eq!(tree.resolution(), 8);
    for (out, incident, wanted) in [
        ((0.0, 0.0), (0.0, 0.0), 0.5444),
        ((0.6, 0.0), (0.0, 0.0), 0.5464),
        ((0.0, 0.6), (0.0, 0.0), 0.5446),
        ((0.0, 0.0), (-0.3, 0.0), 0.3444),
        ((0.6, 0.0), (-0.3, 0.0), 0.3464),
        ((0.0, 0.6), (0.309, -0.206), 0.6246),
    ] {
        let value = tree.evaluate(direction(out.0, out.1), direction(incident.0, incident.1));
        assert!((value - wanted).abs() < 1e-6, "{out:?} {incident:?}: {value} {wanted}");
    }
}

#[test]
fn rank_3_turns_with_the_incident_azimuth() {
    // Values .1 i + .01 ox + .001 oy on 2 × 4² … a 4³ grid whose upper half is never used.
    let mut text = String::from("{");
    for i in 0..64 {
        text.push_str(&format!(" {}", 0.1 * (i / 16) as f64 + 0.01 * (i / 4 % 4) as f64 + 0.001 * (i % 4) as f64));
    }
    let tree = TensorTree::parse(&(text + "}"), 3).unwrap();
    // Normal incidence lies in slice 1, grazing in slice 0; straight through lies on +x.
    assert!((tree.evaluate(direction(0.7, 0.01), direction(1e-9, 0.0)) - 0.132).abs() < 1e-6);
    for azimuth in [0.3f64, 1.0, 2.5, -2.0] {
        let incident = direction(0.9 * azimuth.cos(), 0.9 * azimuth.sin());
        let out = direction(0.9 * (azimuth + 0.1).cos(), 0.9 * (azimuth + 0.1).sin());
        assert!((tree.evaluate(out, incident) - 0.032).abs() < 1e-6);
    }
}

#[test]
fn integrals_of_a_constant_are_pi_times_it_at_both_ranks() {
    for rank in [3, 4] {
        let leaf = "{ 0.1 }".to_string();
        let level1 = format!("{{ {} }}", vec![leaf; 1 << rank].join(" "));
        let mixed = format!("{{ {} {} }}", level1, vec!["{ 0.1 }"; (1 << rank) - 1].join(", "));
        let tree = TensorTree::parse(&mixed, rank).unwrap();
        assert_eq!(tree.resolution(), 4);
        assert!((tree.hemispherical() - 0.1 * PI).abs() < 1e-6, "{}", tree.hemispherical());
        for x in [0.0, 0.3, -0.9] {
            assert!((tree.direct_hemispherical(direction(x, -x / 3.0)) - 0.1 * PI).abs() < 1e-6);
        }
        assert!((TensorTree::constant(rank, 0.1).hemispherical() - tree.hemispherical()).abs() < 1e-12);
    }
}

#[test]
fn direct_hemispherical_is_the_sum_over_outgoing_cells() {
    let tree = TensorTree::parse(&text_of_rank4(), 4).unwrap();
    let incident = direction(-0.3, 0.5);
    let n = 64;
    let mut sum = 0.0;
    for i in 0..n * n {
        let (u, v) = ((i / n) as f64 + 0.5, (i % n) as f64 + 0.5);
        let [x, y] = crate::bins::shirley_chiu::disk_from_square(u / n as f64, v / n as f64);
        sum += tree.evaluate(direction(x, y), incident) * PI / (n * n) as f64;
    }
    assert!((tree.direct_hemispherical(incident) - sum).abs() < 1e-6);
}

#[test]
fn broken_trees_are_refused_and_never_panic() {
    let bad = [
        "",
        "{",
        "}",
        "{}",
        "{ 1 2 }",
        "{ 1 } 2",
        "{ 1 } { 1 }",
        "1",
        "{ x }",
        "{ nan }",
        "{ { 1 } }",
        "{ 1 { 1 } }",
        "{ { 1 } 1 }",
        "{1e99}",
    ];
    for text in bad {
        for rank in [3, 4] {
            assert!(TensorTree::parse(text, rank).is_err(), "{text:?}");
        }
    }
    assert!(TensorTree::parse(&"{".repeat(1_000_000), 4).unwrap_err().to_string().contains("nested deeper"));
    let good = text_of_rank4();
    for cut in (0..good.len()).step_by(97) {
        assert!(TensorTree::parse(&good[..cut], 4).is_err());
    }
    assert!(TensorTree::parse(&good, 3).is_err());
}
