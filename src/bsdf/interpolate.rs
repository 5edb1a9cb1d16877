//! Intermediate states of switchable glazing between measured ones.

use super::resample::FINEST_TREE;
use super::{Block, Bsdf, Component, KlemsMatrix, TensorTree};
use crate::error::{Error, Result, Warnings};

/// The state at `fraction` 0…1 between two measured ones, linear in every value.
///
/// Linear mixing keeps what the two states have in common: reciprocity, energy balance, and
/// hemispherical values mix linearly. Components that only one state has are left out, with a
/// warning. The geometry, which shows one state, is left out too.
///
/// # Errors
/// If the fraction is outside 0…1, if bases or structures differ, or if the states have no
/// component in common.
pub fn interpolate(a: &Bsdf, b: &Bsdf, fraction: f64, warnings: &mut Warnings) -> Result<Bsdf> {
    if !(0.0..=1.0).contains(&fraction) {
        return Err(Error::new(format!("a fraction of {fraction} is outside 0…1")));
    }
    let mix = |a: f64, b: f64| (1.0 - fraction) * a + fraction * b;
    let mut state = Bsdf {
        name: format!("{} {:.1} % of the way to {}", a.name, fraction * 100.0, b.name),
        thickness: a.thickness.zip(b.thickness).map(|(x, y)| mix(x, y)),
        geometry: None,
        skipped: Vec::new(),
        visible: Default::default(),
        solar: Default::default(),
        cie_x: Default::default(),
        cie_z: Default::default(),
        cie_u: Default::default(),
        cie_v: Default::default(),
        ..a.clone()
    };
    let mut common = 0;
    for ((band, of_a), (_, of_b)) in a.bands().into_iter().zip(b.bands()) {
        for component in Component::ALL {
            let place = format!("{band} {}", component.xml_name());
            match (of_a.get(component), of_b.get(component)) {
                (Some(x), Some(y)) => {
                    let mixed = mix_blocks(x, y, fraction).map_err(|e| e.field(place))?;
                    *state.band_mut(band).expect("the name is a band's own").slot(component) = Some(mixed);
                    common += 1;
                }
                (None, None) => {}
                _ => warnings.push(Error::new("only one of the two states has this component; it is left out").field(place)),
            }
        }
    }
    if common == 0 {
        return Err(Error::new("the two states have no component in common"));
    }
    Ok(state)
}

/// `count` states from the first to the last of the given ones, evenly spaced, ends included.
///
/// # Errors
/// As [`interpolate`]; fewer than two measured states or fewer than two wanted.
pub fn states(measured: &[Bsdf], count: usize, warnings: &mut Warnings) -> Result<Vec<Bsdf>> {
    if measured.len() < 2 || count < 2 {
        return Err(Error::new("interpolation needs at least two measured states and two wanted ones"));
    }
    let last = measured.len() - 1;
    (0..count)
        .map(|k| {
            let position = k as f64 / (count - 1) as f64 * last as f64;
            let from = (position.floor() as usize).min(last - 1);
            interpolate(&measured[from], &measured[from + 1], position - from as f64, warnings)
        })
        .collect()
}

fn mix_blocks(a: &Block, b: &Block, fraction: f64) -> Result<Block> {
    let differ = || Error::new("the two states have different bases").help("convert one of them first: lucarne bsdf convert");
    match (a, b) {
        (Block::Klems(x), Block::Klems(y)) if x.incident() == y.incident() && x.outgoing() == y.outgoing() => {
            let values = x.values().iter().zip(y.values()).map(|(x, y)| (1.0 - fraction) * x + fraction * y).collect();
            Ok(Block::Klems(KlemsMatrix::new(x.incident().clone(), x.outgoing().clone(), values)?))
        }
        (Block::Tree(x), Block::Tree(y)) if x.rank() == y.rank() => mix_trees(x, y, fraction).map(Block::Tree),
        _ => Err(differ()),
    }
}

/// Over the finest cells of both.
fn mix_trees(a: &TensorTree, b: &TensorTree, fraction: f64) -> Result<TensorTree> {
    let log2 = a.resolution().max(b.resolution()).max(2).ilog2();
    if log2 > FINEST_TREE {
        return Err(Error::new(format!("trees finer than 2^{FINEST_TREE} cells per side are not mixed"))
            .help("convert them to a coarser tree first: lucarne bsdf convert"));
    }
    let (x, y) = (a.to_grid(log2), b.to_grid(log2));
    let mixed: Vec<f32> = x.iter().zip(&y).map(|(x, y)| ((1.0 - fraction) * f64::from(*x) + fraction * f64::from(*y)) as f32).collect();
    Ok(TensorTree::from_grid(a.rank(), log2, &mixed, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::{AngleBasis, KlemsBasis};

    fn state(seed: usize, through: f64) -> Bsdf {
        let basis = AngleBasis::from(KlemsBasis::Quarter);
        // Symmetric under reversal, as every reciprocal front-back pair is.
        let f = |o: usize, i: usize| {
            let (a, b) = (o * 41 + i, basis.opposite(i) * 41 + basis.opposite(o));
            let random = |k: usize| ((k + seed) as f64 * 0.618_034).fract() * 0.05;
            random(a) + random(b) + if o == i { through / basis.projected_solid_angle(i) } else { 0.0 }
        };
        let mut bsdf = Bsdf { name: format!("state {seed}"), thickness: Some(seed as f64), ..Bsdf::default() };
        let m = Block::Klems(KlemsMatrix::from_fn(&basis, f));
        bsdf.visible.transmission_front = Some(m.clone());
        bsdf.visible.transmission_back = Some(m);
        bsdf
    }

    #[test]
    fn hemispherical_values_mix_linearly_and_reciprocity_stays() {
        let (a, b, c) = (state(1, 0.6), state(2, 0.1), state(3, 0.0));
        let h = |x: &Bsdf| x.visible.transmission_front.as_ref().unwrap().hemispherical();
        let made = states(&[a.clone(), b.clone(), c.clone()], 5, &mut Warnings::new()).unwrap();
        let wanted = [h(&a), (h(&a) + h(&b)) / 2.0, h(&b), (h(&b) + h(&c)) / 2.0, h(&c)];
        for (state, wanted) in made.iter().zip(wanted) {
            assert!((h(state) - wanted).abs() < 1e-12);
            let m = |block: &Option<Block>| block.as_ref().unwrap().as_klems().unwrap().clone();
            let (front, back) = (m(&state.visible.transmission_front), m(&state.visible.transmission_back).reversed());
            assert!(front.values().iter().zip(back.values()).all(|(x, y)| (x - y).abs() < 1e-12));
        }
        assert!(made[0].visible == a.visible && made[4].visible == c.visible);
        assert_eq!(made[1].thickness, Some(1.5));
    }

    #[test]
    fn trees_mix_like_matrices() {
        let tree = |b: &Bsdf, log2| {
            let mut t = b.clone();
            t.visible.transmission_back = None;
            let block = b.visible.transmission_front.as_ref().unwrap();
            t.visible.transmission_front = Some(Block::Tree(crate::bsdf::resample::to_tree(block, 4, log2, 1e-6).unwrap()));
            t
        };
        let (a, b) = (tree(&state(1, 0.6), 3), tree(&state(2, 0.1), 2));
        let mid = interpolate(&a, &b, 0.25, &mut Warnings::new()).unwrap();
        let h = |x: &Bsdf| x.visible.transmission_front.as_ref().unwrap().hemispherical();
        assert!((h(&mid) - 0.75 * h(&a) - 0.25 * h(&b)).abs() < 1e-6);
    }

    #[test]
    fn mismatches_are_named() {
        let (a, mut b) = (state(1, 0.6), state(2, 0.1));
        assert!(interpolate(&a, &b, 1.5, &mut Warnings::new()).is_err());
        b.visible.transmission_back = None;
        let mut warnings = Warnings::new();
        assert!(interpolate(&a, &b, 0.5, &mut warnings).unwrap().visible.transmission_back.is_none());
        assert_eq!(warnings.iter().count(), 1);
        b.visible.transmission_front = Some(Block::Klems(KlemsMatrix::from_fn(&AngleBasis::from(KlemsBasis::Half), |_, _| 0.1)));
        assert!(interpolate(&a, &b, 0.5, &mut Warnings::new()).unwrap_err().to_string().contains("different bases"));
        assert!(interpolate(&a, &Bsdf::default(), 0.5, &mut Warnings::new()).is_err());
        assert!(states(&[a], 3, &mut Warnings::new()).is_err());
    }
}
