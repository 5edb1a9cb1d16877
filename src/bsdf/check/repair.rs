//! Repairs that need no guessing.

use super::measures::{SIDES, dummy, largest_sum, through_peak, turned};
use super::{ENERGY_FAULT, ENERGY_NOTE};
use crate::bsdf::{Block, Blocks, Bsdf, Component};

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
