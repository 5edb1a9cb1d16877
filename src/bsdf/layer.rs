//! Window systems of several layers by the matrix layer calculation (Klems, ASHRAE Transactions
//! 100(1) 1994, "A new method for predicting the solar heat gain of complex fenestration
//! systems"; what WINDOW does).
//!
//! Layers are given from the outside to the inside. Between two neighbours light is reflected back
//! and forth; with matrices M = f Λ that map radiance per bin, the sum over all reflections is the
//! inverse of I − R R'. Because bins are indexed by the direction of travel, transmission and
//! reflection multiply without any renumbering.

use super::resample::to_klems;
use super::{Block, Blocks, Bsdf, Component, KlemsMatrix, projected_solid_angles};
use crate::bins::AngleBasis;
use crate::error::{Error, Result, Warnings};

/// A system made of layers.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// Scattering data of the whole, visible and solar.
    pub bsdf: Bsdf,
    /// Absorptance of each layer, from outside to inside, for visible and solar light.
    pub absorptance: [Vec<Absorptance>; 2],
}

/// Share of the light that one layer of a system absorbs.
#[derive(Debug, Clone, PartialEq)]
pub struct Absorptance {
    /// Per incident bin, light from the outside.
    pub front: Vec<f64>,
    /// Per incident bin, light from the room.
    pub back: Vec<f64>,
    /// Uniform diffuse light from the outside and from the room.
    pub hemispherical: [f64; 2],
}

/// Combines layers, outermost first, in the bands that all of them have. A band that only some
/// have is left out, with a warning. Other bases are brought to `basis`.
///
/// # Errors
/// No layers; a layer without transmission or reflection data in every band; layers whose
/// reflections would make up energy.
pub fn combine(layers: &[Bsdf], basis: &AngleBasis, warnings: &mut Warnings) -> Result<System> {
    if layers.is_empty() {
        return Err(Error::new("a system needs at least one layer"));
    }
    let names: Vec<&str> = layers.iter().map(|l| if l.name.is_empty() { "layer" } else { l.name.as_str() }).collect();
    let mut system = System { bsdf: Bsdf { name: names.join(" | "), ..Bsdf::default() }, absorptance: [Vec::new(), Vec::new()] };
    for (k, band) in ["Visible", "Solar"].into_iter().enumerate() {
        let blocks: Vec<&Blocks> = layers.iter().map(|l| l.bands()[k].1).collect();
        let missing = blocks.iter().position(|b| b.is_empty());
        if let Some(layer) = missing {
            if blocks.iter().any(|b| !b.is_empty()) {
                warnings.push(
                    Error::new(format!("layer {} ({}) has no {band} data; the system gets none", layer + 1, names[layer])).field(band),
                );
            }
            continue;
        }
        let operators: Vec<Operators> = blocks
            .iter()
            .enumerate()
            .map(|(n, b)| Operators::new(b, basis).map_err(|e| e.field(format!("layer {} ({}), {band}", n + 1, names[n]))))
            .collect::<Result<_>>()?;
        let (whole, absorptance) = stack(&operators, basis)?;
        *system.bsdf.band_mut(band).expect("a band's name") = whole.into_blocks(basis);
        system.absorptance[k] = absorptance;
    }
    if system.bsdf.visible.is_empty() && system.bsdf.solar.is_empty() {
        return Err(Error::new("no band is complete in all layers"));
    }
    Ok(system)
}

/// A layer turned around: what was outside is inside. Light that travelled into the room now
/// travels out; seen in the window's frame the layer is turned about the vertical axis, so the x
/// of every direction changes sign.
pub fn flipped(layer: &Bsdf) -> Result<Bsdf> {
    let mut turned = Bsdf { geometry: None, name: format!("{} (flipped)", layer.name), ..layer.clone() };
    for (band, blocks) in layer.bands() {
        let mut new = Blocks::default();
        for (component, block) in blocks.iter() {
            let Block::Klems(m) = block else {
                return Err(
                    Error::new("a tensor tree cannot be flipped").help("convert it first: lucarne bsdf convert FILE.xml --to klems:full")
                );
            };
            let target = match component {
                Component::TransmissionFront => Component::TransmissionBack,
                Component::TransmissionBack => Component::TransmissionFront,
                Component::ReflectionFront => Component::ReflectionBack,
                Component::ReflectionBack => Component::ReflectionFront,
            };
            let mirror = |basis: &AngleBasis| -> Vec<usize> {
                let mirrored = |bin| {
                    let c = basis.centre(bin);
                    basis.bin_of(glam::DVec3::new(-c.x, c.y, c.z))
                };
                (0..basis.len()).map(mirrored).collect()
            };
            let (on_in, on_out) = (mirror(m.incident()), mirror(m.outgoing()));
            let n = m.incident().len();
            let values = (0..m.values().len()).map(|k| m.at(on_out[k / n], on_in[k % n])).collect();
            *new.slot(target) = Some(Block::Klems(KlemsMatrix::new(m.incident().clone(), m.outgoing().clone(), values)?));
        }
        if let Some(slot) = turned.band_mut(band) {
            *slot = new;
        }
    }
    Ok(turned)
}

/// A length such as `16mm`, `1.2cm` or `0.016` (m).
///
/// # Errors
/// If it is none.
pub fn length(text: &str) -> Result<f64> {
    let (number, metres) = [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("m", 1.0)]
        .into_iter()
        .find_map(|(unit, metres)| Some((text.strip_suffix(unit)?, metres)))
        .unwrap_or((text, 1.0));
    number
        .trim()
        .parse::<f64>()
        .ok()
        .map(|v| v * metres)
        .filter(|v| v.is_finite() && *v >= 0.0)
        .ok_or_else(|| Error::new(format!("'{text}' is not a length")).help("for instance 16mm or 0.016 (metres)"))
}

/// A square matrix of f Λ.
#[derive(Clone)]
struct Square {
    n: usize,
    data: Vec<f64>,
}

impl Square {
    fn identity(n: usize) -> Self {
        Self { n, data: (0..n * n).map(|k| f64::from(k / n == k % n)).collect() }
    }

    fn times(&self, other: &Self) -> Self {
        let n = self.n;
        let mut data = vec![0.0; n * n];
        for (row, out) in self.data.chunks_exact(n).zip(data.chunks_exact_mut(n)) {
            for (a, from) in row.iter().zip(other.data.chunks_exact(n)).filter(|(a, _)| **a != 0.0) {
                out.iter_mut().zip(from).for_each(|(o, b)| *o += a * b);
            }
        }
        Self { n, data }
    }

    fn plus(mut self, other: &Self) -> Self {
        self.data.iter_mut().zip(&other.data).for_each(|(a, b)| *a += b);
        self
    }

    /// (I − self)⁻¹ · right, by elimination with row pivots.
    fn resolve(&self, right: &Self) -> Result<Self> {
        let n = self.n;
        let mut a: Vec<f64> = self.data.iter().enumerate().map(|(k, v)| f64::from(k / n == k % n) - v).collect();
        let mut b = right.data.clone();
        for column in 0..n {
            let pivot = (column..n).max_by(|x, y| a[x * n + column].abs().total_cmp(&a[y * n + column].abs())).expect("rows remain");
            if a[pivot * n + column].abs() < 1e-12 {
                return Err(Error::new(
                    "light between two layers never gets out: their reflectances leave nothing to be absorbed or transmitted",
                ));
            }
            if pivot != column {
                for k in 0..n {
                    a.swap(pivot * n + k, column * n + k);
                    b.swap(pivot * n + k, column * n + k);
                }
            }
            let inverse = 1.0 / a[column * n + column];
            a[column * n..(column + 1) * n].iter_mut().for_each(|v| *v *= inverse);
            b[column * n..(column + 1) * n].iter_mut().for_each(|v| *v *= inverse);
            let (pivot_a, pivot_b) = (a[column * n..(column + 1) * n].to_vec(), b[column * n..(column + 1) * n].to_vec());
            for row in (0..n).filter(|r| *r != column) {
                let factor = a[row * n + column];
                if factor != 0.0 {
                    a[row * n + column..(row + 1) * n].iter_mut().zip(&pivot_a[column..]).for_each(|(v, p)| *v -= factor * p);
                    b[row * n..(row + 1) * n].iter_mut().zip(&pivot_b).for_each(|(v, p)| *v -= factor * p);
                }
            }
        }
        Ok(Self { n, data: b })
    }
}

/// What a layer or stack does with radiance: f Λ of the four components.
#[derive(Clone)]
struct Operators {
    tf: Square,
    tb: Square,
    rf: Square,
    rb: Square,
}

impl Operators {
    fn new(blocks: &Blocks, basis: &AngleBasis) -> Result<Self> {
        let lambda = projected_solid_angles(basis);
        let n = basis.len();
        let square = |m: KlemsMatrix| Square { n, data: m.values().iter().enumerate().map(|(k, f)| f.max(0.0) * lambda[k % n]).collect() };
        let get = |component: Component| -> Result<Square> {
            if let Some(block) = blocks.get(component) {
                return Ok(square(to_klems(block, basis, basis)));
            }
            match blocks.get(component.reciprocal()) {
                Some(block) if component.is_transmission() => Ok(square(to_klems(block, basis, basis).reversed())),
                _ => Err(Error::new(format!("{} is missing", component.xml_name()))
                    .help("layering needs reflection from both sides; use a file with all four blocks")),
            }
        };
        Ok(Self {
            tf: get(Component::TransmissionFront)?,
            tb: get(Component::TransmissionBack)?,
            rf: get(Component::ReflectionFront)?,
            rb: get(Component::ReflectionBack)?,
        })
    }

    /// Empty space.
    fn nothing(n: usize) -> Self {
        let zero = Square { n, data: vec![0.0; n * n] };
        Self { tf: Square::identity(n), tb: Square::identity(n), rf: zero.clone(), rb: zero }
    }

    /// This stack outside, another inside.
    fn then(&self, inner: &Self) -> Result<Self> {
        let gap = Gap::between(self, inner)?;
        Ok(Self {
            tf: inner.tf.times(&gap.inward_from_front),
            rf: self.rf.clone().plus(&self.tb.times(&gap.outward_from_front)),
            tb: self.tb.times(&gap.outward_from_back),
            rb: inner.rb.clone().plus(&inner.tf.times(&gap.inward_from_back)),
        })
    }

    fn into_blocks(self, basis: &AngleBasis) -> Blocks {
        let lambda = projected_solid_angles(basis);
        let block = |m: Square| {
            let values = m.data.iter().enumerate().map(|(k, v)| v / lambda[k % m.n]).collect();
            Some(Block::Klems(KlemsMatrix::new(basis.clone(), basis.clone(), values).expect("square")))
        };
        Blocks {
            transmission_front: block(self.tf),
            transmission_back: block(self.tb),
            reflection_front: block(self.rf),
            reflection_back: block(self.rb),
        }
    }
}

/// Radiance in the gap between two stacks per radiance from outside (front) or from the room (back).
struct Gap {
    inward_from_front: Square,
    outward_from_front: Square,
    inward_from_back: Square,
    outward_from_back: Square,
}

impl Gap {
    fn between(outer: &Operators, inner: &Operators) -> Result<Self> {
        let inward_from_front = outer.rb.times(&inner.rf).resolve(&outer.tf)?;
        let outward_from_back = inner.rf.times(&outer.rb).resolve(&inner.tb)?;
        Ok(Self {
            outward_from_front: inner.rf.times(&inward_from_front),
            inward_from_back: outer.rb.times(&outward_from_back),
            inward_from_front,
            outward_from_back,
        })
    }
}

fn stack(layers: &[Operators], basis: &AngleBasis) -> Result<(Operators, Vec<Absorptance>)> {
    let n = basis.len();
    // outer[k]: layers before k; inner[k]: layers from k on.
    let mut outer = vec![Operators::nothing(n)];
    for layer in layers {
        let next = outer.last().expect("starts with nothing").then(layer)?;
        outer.push(next);
    }
    let mut inner = vec![Operators::nothing(n)];
    for layer in layers.iter().rev() {
        let next = layer.then(inner.last().expect("starts with nothing"))?;
        inner.push(next);
    }
    inner.reverse();
    let gaps: Vec<Gap> = (0..=layers.len()).map(|k| Gap::between(&outer[k], &inner[k])).collect::<Result<_>>()?;
    let lambda = projected_solid_angles(basis);
    let flux_absorbed = |layer: &Operators, inward: &Square, outward: &Square| -> Vec<f64> {
        let share = |t: &Square, r: &Square, b: usize| -> f64 {
            1.0 - (0..n).map(|o| (t.data[o * n + b] + r.data[o * n + b]) * lambda[o]).sum::<f64>() / lambda[b]
        };
        let mut absorbed = vec![0.0; n];
        for b in 0..n {
            let (front, back) = (share(&layer.tf, &layer.rf, b) * lambda[b], share(&layer.tb, &layer.rb, b) * lambda[b]);
            for (i, sum) in absorbed.iter_mut().enumerate() {
                *sum += front * inward.data[b * n + i] + back * outward.data[b * n + i];
            }
        }
        absorbed.iter().zip(&lambda).map(|(a, l)| a / l).collect()
    };
    let absorptance = layers
        .iter()
        .enumerate()
        .map(|(k, layer)| {
            let front = flux_absorbed(layer, &gaps[k].inward_from_front, &gaps[k + 1].outward_from_front);
            let back = flux_absorbed(layer, &gaps[k].inward_from_back, &gaps[k + 1].outward_from_back);
            let mean = |v: &[f64]| v.iter().zip(&lambda).map(|(a, l)| a * l).sum::<f64>() / std::f64::consts::PI;
            Absorptance { hemispherical: [mean(&front), mean(&back)], front, back }
        })
        .collect();
    Ok((outer.pop().expect("at least nothing"), absorptance))
}

#[cfg(test)]
mod pywincalc;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::bsdf::check;
    use crate::bsdf::glass;
    use std::f64::consts::PI;

    fn quarter() -> AngleBasis {
        AngleBasis::from(KlemsBasis::Quarter)
    }

    fn pane(name: &str, basis: &AngleBasis) -> Bsdf {
        let pane = glass::named(name).unwrap();
        let [visible, solar] = pane.to_blocks(basis);
        Bsdf { name: name.into(), visible, solar, ..Bsdf::default() }
    }

    /// Lambertian on both sides.
    fn diffuser(t: f64, rf: f64, rb: f64) -> Bsdf {
        let flat = |v: f64| Some(Block::Klems(KlemsMatrix::from_fn(&quarter(), |_, _| v / PI)));
        let blocks =
            Blocks { transmission_front: flat(t), transmission_back: flat(t), reflection_front: flat(rf), reflection_back: flat(rb) };
        Bsdf { visible: blocks.clone(), solar: blocks, ..Bsdf::default() }
    }

    /// Different everywhere, reciprocal, left-right asymmetric.
    fn odd(seed: usize) -> Bsdf {
        let basis = quarter();
        let symmetric = |level: f64, shift: usize| {
            KlemsMatrix::from_fn(&basis, |o, i| {
                let random = |o: usize, i: usize| ((o * 41 + i + shift) as f64 * 0.618_034).fract();
                level / PI * (0.5 + 0.5 * (random(o, i) + random(basis.opposite(i), basis.opposite(o))))
            })
        };
        let through = KlemsMatrix::from_fn(&basis, |o, i| {
            0.3 / PI * ((o * 41 + i + seed) as f64 * 0.414_21).fract() + if o == i { 0.2 / basis.projected_solid_angle(i) } else { 0.0 }
        });
        let blocks = Blocks {
            transmission_back: Some(Block::Klems(through.reversed())),
            transmission_front: Some(Block::Klems(through)),
            reflection_front: Some(Block::Klems(symmetric(0.2, seed + 5))),
            reflection_back: Some(Block::Klems(symmetric(0.3, seed + 9))),
        };
        Bsdf { name: format!("odd {seed}"), visible: blocks.clone(), solar: blocks, ..Bsdf::default() }
    }

    fn hemispherical(system: &System) -> [f64; 4] {
        Component::ALL.map(|c| system.bsdf.visible.get(c).unwrap().hemispherical())
    }

    #[test]
    fn two_diffusers_have_their_textbook_values() {
        let (a, b) = (diffuser(0.4, 0.3, 0.5), diffuser(0.2, 0.6, 0.1));
        let system = combine(&[a, b], &quarter(), &mut Warnings::new()).unwrap();
        let d = 1.0 - 0.5 * 0.6;
        let wanted = [0.4 * 0.2 / d, 0.2 * 0.4 / d, 0.3 + 0.4 * 0.6 * 0.4 / d, 0.1 + 0.2 * 0.5 * 0.2 / d];
        for (h, w) in hemispherical(&system).iter().zip(wanted) {
            assert!((h - w).abs() < 1e-12, "{h} {w}");
        }
        let first = 0.3 + 0.4 * 0.6 / d * 0.1;
        assert!((system.absorptance[0][0].hemispherical[0] - first).abs() < 1e-12);
    }

    #[test]
    fn specular_panes_multiply_bin_by_bin() {
        let basis = AngleBasis::from(KlemsBasis::Full);
        let (a, b) = (pane("clear_3mm", &basis), pane("clear_6mm", &basis));
        let system = combine(&[a, b], &basis, &mut Warnings::new()).unwrap();
        let (p, q) = (glass::named("clear_3mm").unwrap(), glass::named("clear_6mm").unwrap());
        let t = system.bsdf.visible.transmission_front.as_ref().unwrap().as_klems().unwrap();
        for (bin, theta) in [(0, 0.0), (30, 30.0), (100, 60.0), (140, 82.5)] {
            let ([t1, _, r1], [t2, r2, _]) = (p.at(&p.visible, theta), q.at(&q.visible, theta));
            assert!((t.direct_hemispherical(bin) - t1 * t2 / (1.0 - r1 * r2)).abs() < 1e-12);
        }
    }

    #[test]
    fn energy_is_accounted_for_and_the_system_is_reciprocal() {
        let layers = [odd(1), odd(20), diffuser(0.3, 0.4, 0.5)];
        let system = combine(&layers, &quarter(), &mut Warnings::new()).unwrap();
        let m = |c| system.bsdf.visible.get(c).unwrap().as_klems().unwrap();
        for i in 0..41 {
            for (t, r, front) in [
                (Component::TransmissionFront, Component::ReflectionFront, true),
                (Component::TransmissionBack, Component::ReflectionBack, false),
            ] {
                let absorbed: f64 = system.absorptance[0].iter().map(|a| if front { a.front[i] } else { a.back[i] }).sum();
                let total = m(t).direct_hemispherical(i) + m(r).direct_hemispherical(i) + absorbed;
                assert!((total - 1.0).abs() < 1e-12, "bin {i}: {total}");
            }
        }
        let reversed = m(Component::TransmissionBack).reversed();
        for (a, b) in m(Component::TransmissionFront).values().iter().zip(reversed.values()) {
            assert!((a - b).abs() < 1e-12);
        }
        assert!(check::is_sound(&check::check(&system.bsdf, &Warnings::new())));
    }

    #[test]
    fn grouping_does_not_matter_and_turning_everything_around_swaps_the_sides() {
        let (a, b, c) = (odd(1), odd(7), odd(30));
        let whole = combine(&[a.clone(), b.clone(), c.clone()], &quarter(), &mut Warnings::new()).unwrap();
        let pair = combine(&[b.clone(), c.clone()], &quarter(), &mut Warnings::new()).unwrap();
        let grouped = combine(&[a.clone(), pair.bsdf], &quarter(), &mut Warnings::new()).unwrap();
        let around =
            combine(&[flipped(&c).unwrap(), flipped(&b).unwrap(), flipped(&a).unwrap()], &quarter(), &mut Warnings::new()).unwrap();
        let back = flipped(&around.bsdf).unwrap();
        for component in Component::ALL {
            let values = |x: &Bsdf| x.visible.get(component).unwrap().as_klems().unwrap().values().to_vec();
            for other in [&grouped.bsdf, &back] {
                assert!(values(&whole.bsdf).iter().zip(values(other)).all(|(x, y)| (x - y).abs() < 1e-10), "{component:?}");
            }
        }
    }

    #[test]
    fn incomplete_layers_are_named() {
        let mut layer = odd(1);
        layer.visible.transmission_back = None;
        assert!(combine(&[layer.clone(), odd(2)], &quarter(), &mut Warnings::new()).is_ok(), "reciprocity serves");
        layer.visible.reflection_back = None;
        let message = combine(&[odd(2), layer.clone()], &quarter(), &mut Warnings::new()).unwrap_err().to_string();
        assert!(message.contains("layer 2 (odd 1), Visible: Reflection Back is missing"), "{message}");
        layer.visible = Blocks::default();
        let mut warnings = Warnings::new();
        assert!(combine(&[odd(2), layer], &quarter(), &mut warnings).unwrap().bsdf.visible.is_empty());
        assert_eq!(warnings.iter().count(), 1);
        assert!(combine(&[], &quarter(), &mut Warnings::new()).is_err());
        let mirror = diffuser(0.0, 1.0, 1.0);
        assert!(combine(&[mirror.clone(), mirror], &quarter(), &mut Warnings::new()).unwrap_err().to_string().contains("never gets out"));
        assert!(length("16mm").unwrap() == 0.016 && length("1").unwrap() == 1.0 && length("-1").is_err() && length("x").is_err());
    }
}
