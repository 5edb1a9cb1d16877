//! The BSDF doctor: is this file physically possible and complete, and what can safely be repaired?
//!
//! Every finding has the number behind it. Tolerances are those of traced and measured data: a
//! Monte-Carlo file is sound although its values scatter. Tests of reciprocity therefore compare
//! means over the Klems quarter basis.
//!
//! What cannot be found: a device that is turned around as a whole, or whose matrices are all
//! transposed, is still reciprocal and conserves energy.

use super::evaluate::MOST_SHARE;
use super::resample::to_klems;
use super::{Block, Blocks, Bsdf, Component, KlemsMatrix, projected_solid_angles, transmission_source};
use crate::bins::{AngleBasis, KlemsBasis};
use crate::error::Warnings;

/// How serious a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// As it should be.
    Sound,
    /// Worth knowing; not wrong.
    Note,
    /// Wrong.
    Fault,
}

/// One result of the examination.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// How serious it is.
    pub verdict: Verdict,
    /// What was examined: `positivity`, `energy`, `reciprocity`, …
    pub item: &'static str,
    /// Band and component.
    pub place: String,
    /// The finding in words, with its number.
    pub text: String,
}

/// Negative flux of an incident bin that is more than rounding.
const NEGATIVE_FLUX: f64 = 1e-4;
/// Transmittance + reflectance of an incident bin above which energy is made up.
const ENERGY_FAULT: f64 = MOST_SHARE;
const ENERGY_NOTE: f64 = 1.001;
/// Mean absolute difference between a matrix and its reverse, relative to their mean. Traced
/// files of ordinary quality reach 3 %, text files of few digits 0.1 %.
const RECIPROCITY: f64 = 0.06;
/// Hemispherical values of front and back transmission may differ by this much, relatively.
const HEMISPHERICAL: f64 = 0.03;
/// A component below this hemispherical value is too dark to be judged by relative differences.
const DARK: f64 = 2e-3;

/// Examines a BSDF and what was noticed while reading it.
pub fn check(bsdf: &Bsdf, reading: &Warnings) -> Vec<Finding> {
    let mut doctor = Doctor { findings: Vec::new() };
    for warning in reading.iter() {
        doctor.say(Verdict::Fault, "header", "file", warning.to_string());
    }
    if reading.is_empty() {
        doctor.say(Verdict::Sound, "header", "file", "bases and directions are stated and consistent".into());
    }
    match transmission_source(bsdf) {
        Ok(_) => {}
        Err(e) => doctor.say(Verdict::Fault, "blocks", "file", e.message().to_string()),
    }
    for (band, blocks) in bsdf.bands().into_iter().take(2).filter(|(_, b)| !b.is_empty()) {
        doctor.check_band(band, blocks);
    }
    if !bsdf.solar.is_empty() && bsdf.solar == bsdf.visible {
        doctor.say(Verdict::Note, "blocks", "Solar", "the same data as Visible".into());
    }
    if bsdf.solar.is_empty() {
        doctor.say(Verdict::Note, "blocks", "Solar", "no data; solar heat gain cannot be computed with this file".into());
    }
    doctor.findings
}

/// Whether nothing is wrong.
pub fn is_sound(findings: &[Finding]) -> bool {
    findings.iter().all(|f| f.verdict != Verdict::Fault)
}

/// Repairs what can be repaired without guessing: negative values become 0; a transmission that is
/// missing, empty or a mere copy is made from the other by reciprocity; a transmission whose
/// straight-through peak lies on the opposite side is turned; reflections that only fit the energy
/// balance when exchanged are exchanged. Gives the repaired BSDF and what was changed.
pub fn repair(bsdf: &Bsdf) -> (Bsdf, Vec<String>) {
    let mut repaired = bsdf.clone();
    let mut changes = Vec::new();
    for band in ["Visible", "Solar"] {
        let blocks = repaired.band_mut(band).expect("a band's name");
        if !blocks.is_empty() {
            repair_band(band, blocks, &mut changes);
        }
    }
    (repaired, changes)
}

struct Doctor {
    findings: Vec<Finding>,
}

impl Doctor {
    fn say(&mut self, verdict: Verdict, item: &'static str, place: impl Into<String>, text: String) {
        self.findings.push(Finding { verdict, item, place: place.into(), text });
    }

    fn check_band(&mut self, band: &'static str, blocks: &Blocks) {
        self.check_presence(band, blocks);
        for (component, block) in blocks.iter() {
            let place = format!("{band} {}", component.xml_name());
            self.check_positivity(&place, block);
            self.check_peak(&place, component, block);
        }
        self.check_energy(band, blocks);
        self.check_transmission_reciprocity(band, blocks);
        for component in [Component::ReflectionFront, Component::ReflectionBack] {
            self.check_reflection_reciprocity(band, component, blocks);
        }
    }

    fn check_presence(&mut self, band: &'static str, blocks: &Blocks) {
        let names = |present: bool| {
            let which = Component::ALL.into_iter().filter(|c| blocks.get(*c).is_some() == present).map(Component::xml_name);
            which.collect::<Vec<_>>().join(", ")
        };
        let count = blocks.iter().count();
        match count {
            4 => self.say(Verdict::Sound, "blocks", band, "all four components".into()),
            // genBSDF's trees of rank 4 and measurements from one side: Radiance's readers expect it.
            3 if blocks.transmission_front.is_none() || blocks.transmission_back.is_none() => {
                self.say(Verdict::Note, "blocks", band, format!("{} is missing; it follows from the other by reciprocity", names(false)));
            }
            3 => self.say(Verdict::Note, "blocks", band, format!("{} is missing; Radiance takes that side as black", names(false))),
            _ => self.say(Verdict::Note, "blocks", band, format!("only {}", names(true))),
        }
        for component in Component::ALL {
            let place = format!("{band} {}", component.xml_name());
            if let Some(problem) = dummy(blocks, component) {
                self.say(Verdict::Fault, "blocks", place, problem.to_string());
            }
        }
    }

    fn check_positivity(&mut self, place: &str, block: &Block) {
        let (count, least, flux) = negatives(block);
        let text = format!("{count} negative values, the least {least:.3e}/sr; up to {flux:.2e} of the light of one direction");
        match () {
            () if count == 0 => self.say(Verdict::Sound, "positivity", place, "no negative values".into()),
            () if flux > NEGATIVE_FLUX => self.say(Verdict::Fault, "positivity", place, text),
            () => self.say(Verdict::Note, "positivity", place, text),
        }
    }

    fn check_peak(&mut self, place: &str, component: Component, block: &Block) {
        let Some(peak) = through_peak(block) else { return };
        let what = if component.is_transmission() { "straight-through" } else { "mirror" };
        let share = |n: usize| 100.0 * n as f64 / peak.peaked as f64;
        if 2 * peak.opposite > peak.peaked && component.is_transmission() {
            let text = format!("the {what} peak of {:.0} % of the peaked directions lies on the opposite side", share(peak.opposite));
            self.say(Verdict::Fault, "orientation", place, text + ": outgoing directions are turned by 180°");
        } else if 2 * peak.opposite > peak.peaked {
            let text =
                format!("{:.0} % of the peaked directions are sent back where they come from: a retroreflector?", share(peak.opposite));
            self.say(Verdict::Note, "orientation", place, text);
        } else {
            let text = format!("the {what} peak of {:.0} % of the peaked directions lies on the diagonal", share(peak.diagonal));
            self.say(if 2 * peak.diagonal > peak.peaked { Verdict::Sound } else { Verdict::Note }, "orientation", place, text);
        }
    }

    fn check_energy(&mut self, band: &'static str, blocks: &Blocks) {
        for (side, t, r) in SIDES {
            if blocks.get(t).is_none() && blocks.get(r).is_none() {
                continue;
            }
            let (worst, bin) = largest_sum(blocks.get(t), blocks.get(r));
            let place = format!("{band} {side}");
            let text = format!("transmittance + reflectance is at most {worst:.4} (incident bin {bin})");
            if worst > ENERGY_FAULT {
                let exchanged = SIDES.iter().map(|(_, t, r)| largest_sum(blocks.get(*t), blocks.get(other_side(*r))).0).fold(0.0, f64::max);
                let hint = if exchanged <= ENERGY_NOTE { "; with the two reflections exchanged it would fit" } else { "" };
                self.say(Verdict::Fault, "energy", place, text + hint);
            } else {
                self.say(if worst > ENERGY_NOTE { Verdict::Note } else { Verdict::Sound }, "energy", place, text);
            }
        }
    }

    fn check_transmission_reciprocity(&mut self, band: &'static str, blocks: &Blocks) {
        let (Some(front), Some(back)) = (&blocks.transmission_front, &blocks.transmission_back) else { return };
        let place = format!("{band} Transmission");
        let (a, b) = (front.hemispherical(), back.hemispherical());
        if a.max(b) < DARK {
            self.say(Verdict::Note, "reciprocity", place, format!("too dark to judge: hemispherical {a:.5} and {b:.5}"));
            return;
        }
        let limit = tolerance(front);
        let fabric = leaves_lambertian(front) && leaves_lambertian(back);
        let (front, back) = (coarse(front), coarse(back));
        let distance = relative_distance(&front, &back.reversed());
        let text = format!("front and back differ by {:.2} % from reciprocity; hemispherical {a:.4} and {b:.4}", distance * 100.0);
        if distance <= limit && (a - b).abs() <= HEMISPHERICAL * a.max(b) {
            self.say(Verdict::Sound, "reciprocity", place, text);
            return;
        }
        if fabric {
            self.say(Verdict::Note, "reciprocity", place, text + FABRIC);
            return;
        }
        let candidates = [
            ("one of them is transposed", relative_distance(&front, &transposed(&back).reversed())),
            ("one of them has its outgoing directions turned by 180°", relative_distance(&front, &turned(&back).reversed())),
            ("one of them has its incident directions turned by 180°", relative_distance(&turned(&front), &back.reversed())),
            ("one of them is mirrored left to right", relative_distance(&mirrored(&front), &back.reversed())),
        ];
        // Evidence is that everything fits then; several may fit a symmetric device.
        let fitting = candidates.iter().filter(|(_, then)| *then <= limit && *then < distance / 2.0);
        let fitting: Vec<_> = fitting.map(|(what, then)| format!("{what} ({:.2} % then)", then * 100.0)).collect();
        let hint = if fitting.is_empty() { String::new() } else { format!("; it looks as if {}", fitting.join(", or ")) };
        self.say(Verdict::Fault, "reciprocity", place, text + &hint);
    }

    fn check_reflection_reciprocity(&mut self, band: &'static str, component: Component, blocks: &Blocks) {
        let Some(block) = blocks.get(component) else { return };
        let place = format!("{band} {}", component.xml_name());
        let hemispherical = block.hemispherical();
        if hemispherical < DARK {
            self.say(Verdict::Note, "reciprocity", place, format!("too dark to judge: hemispherical {hemispherical:.5}"));
            return;
        }
        let matrix = coarse(block);
        let distance = relative_distance(&matrix, &matrix.reversed());
        let text = format!("differs by {:.2} % from reciprocity", distance * 100.0);
        match () {
            () if distance <= tolerance(block) => self.say(Verdict::Sound, "reciprocity", place, text),
            () if leaves_lambertian(block) => self.say(Verdict::Note, "reciprocity", place, text + FABRIC),
            () => self.say(Verdict::Fault, "reciprocity", place, text),
        }
    }
}

const FABRIC: &str = "; scattered light leaves Lambertian from every incidence, WINDOW's model of fabrics, which is not reciprocal";

const SIDES: [(&str, Component, Component); 2] =
    [("Front", Component::TransmissionFront, Component::ReflectionFront), ("Back", Component::TransmissionBack, Component::ReflectionBack)];

fn other_side(reflection: Component) -> Component {
    if reflection == Component::ReflectionFront { Component::ReflectionBack } else { Component::ReflectionFront }
}

/// Why a block is a placeholder, if it is one.
fn dummy(blocks: &Blocks, component: Component) -> Option<&'static str> {
    let own = blocks.get(component)?;
    let partner = if component.is_transmission() { component.reciprocal() } else { other_side(component) };
    let other = blocks.get(partner)?;
    let (h, other_h) = (own.hemispherical(), other.hemispherical());
    if h == 0.0 && other_h > 0.01 {
        let passes = blocks.transmission_front.as_ref().is_some_and(|t| t.hemispherical() > 0.0);
        // A black side of an opaque layer is possible; a transmission from one side only is not.
        if component.is_transmission() || passes {
            return Some("all values are 0 while the other side's are not: a placeholder");
        }
    }
    if component == Component::TransmissionBack && own == other && !leaves_lambertian(own) {
        let matrix = coarse(own);
        if relative_distance(&matrix, &matrix.reversed()) > tolerance(own) {
            return Some("a copy of Transmission Front; reciprocity demands the reverse");
        }
    }
    None
}

/// Number of negative values, the least value, and the largest negative share of the light of one
/// incident direction.
fn negatives(block: &Block) -> (usize, f64, f64) {
    let (mut count, mut least, mut flux) = (0, 0.0f64, 0.0f64);
    match block {
        Block::Klems(m) => {
            let lambda = projected_solid_angles(m.outgoing());
            let n = m.incident().len();
            let mut sums = vec![0.0; n];
            for (k, f) in m.values().iter().enumerate().filter(|(_, f)| **f < 0.0) {
                count += 1;
                least = least.min(*f);
                sums[k % n] -= f * lambda[k / n];
            }
            flux = sums.into_iter().fold(flux, f64::max);
        }
        Block::Tree(t) => t.for_each_cell(|c| {
            if c.value < 0.0 {
                count += 1;
                least = least.min(c.value);
                flux = flux.max(-c.value * c.side * c.side * std::f64::consts::PI);
            }
        }),
    }
    (count, least, flux)
}

/// Largest transmittance + reflectance over the incident bins, and that bin.
fn largest_sum(t: Option<&Block>, r: Option<&Block>) -> (f64, usize) {
    let full = AngleBasis::from(KlemsBasis::Full);
    let basis = t.or(r).and_then(Block::as_klems).map_or(full, |m| m.incident().clone());
    let sums = |block: &Block| match block {
        Block::Klems(m) if *m.incident() == basis => m.all_direct_hemispherical(),
        other => (0..basis.len()).map(|i| other.direct_hemispherical(basis.centre(i))).collect(),
    };
    let mut total = vec![0.0; basis.len()];
    for block in [t, r].into_iter().flatten() {
        total.iter_mut().zip(sums(block)).for_each(|(sum, v)| *sum += v);
    }
    total.into_iter().enumerate().fold((0.0, 0), |worst, (bin, v)| if v > worst.0 { (v, bin) } else { worst })
}

/// Where the sharp peaks of a block lie.
struct Peaks {
    peaked: usize,
    diagonal: usize,
    opposite: usize,
}

/// Counts the incident bins whose largest value stands out, and where it lies; `None` if few have
/// one, or the block is no square matrix.
fn through_peak(block: &Block) -> Option<Peaks> {
    let half = AngleBasis::from(KlemsBasis::Half);
    let resampled;
    let m = match block {
        Block::Klems(m) if m.incident() == m.outgoing() => m,
        other => {
            resampled = to_klems(other, &half, &half);
            &resampled
        }
    };
    let basis = m.incident();
    let lambda = projected_solid_angles(basis);
    let sums = m.all_direct_hemispherical();
    let mut peaks = Peaks { peaked: 0, diagonal: 0, opposite: 0 };
    let mut judged = 0;
    for i in (0..basis.len()).filter(|i| basis.opposite(*i) != *i && sums[*i] > DARK) {
        judged += 1;
        let (o, f) = (0..basis.len()).map(|o| (o, m.at(o, i))).max_by(|a, b| a.1.total_cmp(&b.1)).expect("a basis has bins");
        // A tenth of the light in one bin of a hundred, and well above the mean.
        if f * lambda[o] > 0.1 * sums[i] && f > 5.0 * sums[i] / std::f64::consts::PI {
            peaks.peaked += 1;
            peaks.diagonal += usize::from(o == i);
            peaks.opposite += usize::from(o == basis.opposite(i));
        }
    }
    (peaks.peaked > 0 && 4 * peaks.peaked > judged).then_some(peaks)
}

/// How far a block may be from reciprocity. Trees of rank 3 divide incident and outgoing angles
/// differently: a sharp peak is cut differently before and after reversing (7 % at 2^4 cells).
fn tolerance(block: &Block) -> f64 {
    if matches!(block, Block::Tree(t) if t.rank() == 3) { 2.0 * RECIPROCITY } else { RECIPROCITY }
}

/// Whether, apart from the diagonal, light of every incident bin leaves evenly, and how much of it
/// depends on the incidence. (A scatterer that is Lambertian throughout is reciprocal.)
fn leaves_lambertian(block: &Block) -> bool {
    let Block::Klems(m) = block else { return false };
    let sums = m.all_direct_hemispherical();
    let (low, high) = (sums.iter().copied().fold(f64::MAX, f64::min), sums.iter().copied().fold(0.0, f64::max));
    if high - low <= 0.01 * high {
        return false;
    }
    let even = |i: usize| {
        let values = || (0..m.outgoing().len()).filter(|o| *o != i).map(|o| m.at(o, i));
        let (low, high) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
        high - low <= 0.01 * high.abs()
    };
    let count = (0..m.incident().len()).filter(|i| even(*i)).count();
    count * 20 >= m.incident().len() * 19
}

/// Means over the Klems quarter basis: less noise.
fn coarse(block: &Block) -> KlemsMatrix {
    let quarter = AngleBasis::from(KlemsBasis::Quarter);
    to_klems(block, &quarter, &quarter)
}

/// Σ |a − b| ΛΛ / Σ (|a| + |b|)/2 ΛΛ.
fn relative_distance(a: &KlemsMatrix, b: &KlemsMatrix) -> f64 {
    let lambda = projected_solid_angles(a.incident());
    let n = lambda.len();
    let (mut difference, mut mean) = (0.0, 0.0);
    for (k, (x, y)) in a.values().iter().zip(b.values()).enumerate() {
        let weight = lambda[k / n] * lambda[k % n];
        difference += (x - y).abs() * weight;
        mean += (x.abs() + y.abs()) / 2.0 * weight;
    }
    if mean > 0.0 { difference / mean } else { 0.0 }
}

fn transposed(m: &KlemsMatrix) -> KlemsMatrix {
    KlemsMatrix::from_fn(m.incident(), |o, i| m.at(i, o))
}

/// Outgoing directions turned by 180°.
fn turned(m: &KlemsMatrix) -> KlemsMatrix {
    let basis = m.outgoing().clone();
    let n = m.incident().len();
    let values = (0..basis.len() * n).map(|k| m.at(basis.opposite(k / n), k % n)).collect();
    KlemsMatrix::new(m.incident().clone(), basis, values).expect("the same size")
}

/// Incident and outgoing directions mirrored in x.
fn mirrored(m: &KlemsMatrix) -> KlemsMatrix {
    let basis = m.incident();
    let mirror = |bin: usize| {
        let c = basis.centre(bin);
        basis.bin_of(glam::DVec3::new(-c.x, c.y, c.z))
    };
    KlemsMatrix::from_fn(basis, |o, i| m.at(mirror(o), mirror(i)))
}

fn repair_band(band: &str, blocks: &mut Blocks, changes: &mut Vec<String>) {
    for component in Component::ALL {
        if let Some(Block::Klems(m)) = blocks.slot(component) {
            let negative = m.values().iter().filter(|v| **v < 0.0).count();
            if negative > 0 {
                m.values_mut().iter_mut().for_each(|v| *v = v.max(0.0));
                changes.push(format!("{band} {}: {negative} negative values set to 0", component.xml_name()));
            }
        }
    }
    for component in [Component::TransmissionFront, Component::TransmissionBack] {
        let turn = blocks.get(component).and_then(through_peak).is_some_and(|p| 2 * p.opposite > p.peaked);
        if let (true, Some(Block::Klems(m))) = (turn, blocks.slot(component)) {
            *m = turned(m);
            changes.push(format!("{band} {}: outgoing directions turned by 180°", component.xml_name()));
        }
    }
    for component in [Component::TransmissionFront, Component::TransmissionBack] {
        let useless = blocks.get(component).is_none() || dummy(blocks, component).is_some();
        let reversed = match blocks.get(component.reciprocal()) {
            Some(Block::Klems(m)) if useless => Some(m.reversed()),
            _ => None,
        };
        if let Some(m) = reversed {
            *blocks.slot(component) = Some(Block::Klems(m));
            changes.push(format!("{band} {}: made from {} by reciprocity", component.xml_name(), component.reciprocal().xml_name()));
        }
    }
    let worst = |blocks: &Blocks| SIDES.iter().map(|(_, t, r)| largest_sum(blocks.get(*t), blocks.get(*r)).0).fold(0.0, f64::max);
    if blocks.reflection_front.is_some() && blocks.reflection_back.is_some() && worst(blocks) > ENERGY_FAULT {
        let mut exchanged = blocks.clone();
        std::mem::swap(&mut exchanged.reflection_front, &mut exchanged.reflection_back);
        if worst(&exchanged) <= ENERGY_NOTE {
            *blocks = exchanged;
            changes.push(format!("{band}: Reflection Front and Reflection Back exchanged"));
        }
    }
}

#[cfg(test)]
mod tests;
