//! The BSDF doctor: is this file physically possible and complete, and what can safely be repaired?
//!
//! Every finding has the number behind it. Tolerances are those of traced and measured data: a
//! Monte-Carlo file is sound although its values scatter. Tests of reciprocity therefore compare
//! means over the Klems quarter basis.
//!
//! What cannot be found: a device that is turned around as a whole, or whose matrices are all
//! transposed, is still reciprocal and conserves energy.

mod measures;
mod repair;

pub use repair::repair;

use super::evaluate::MOST_SHARE;
use super::{Block, Blocks, Bsdf, Component, transmission_source};
use crate::error::Warnings;
use measures::{
    DARK, SIDES, coarse, dummy, largest_sum, leaves_lambertian, mirrored, negatives, other_side, relative_distance, through_peak,
    tolerance, transposed, turned,
};

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
/// Hemispherical values of front and back transmission may differ by this much, relatively.
const HEMISPHERICAL: f64 = 0.03;

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

#[cfg(test)]
mod tests;
