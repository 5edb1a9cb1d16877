//! What the windows' glazing asks of the method: a panel that spreads all light evenly blurs what finer
//! skies and traced suns would add.

use super::filling::{Filled, data_of_states};
use crate::bins::{AngleBasis, KlemsBasis, ReinhartSky};
use crate::bsdf::peak::PUBLISHED_CONTRAST;
use crate::bsdf::{Block, Bsdf};
use crate::error::Result;
use crate::matrix::rows::MatrixRows;
use crate::simulate::project::method::Glazing;
use crate::simulate::project::{Project, WindowSection};
use glam::DVec3;

/// Largest radiance of an outgoing bin, over the mean of all, of a panel that counts as diffuse.
const EVEN: f64 = 1.5;
/// Reinhart MF of diffuse panels: hourly illuminance behind one differs by 2 % (rms) from that of MF:4.
const DIFFUSE_SUBDIVISION: usize = 2;
/// Reinhart MF of all other glazing: behind clear glass MF:1 is off by 27 % (rms) in an hour, MF:4 by 1 %.
const DIRECTIONAL_SUBDIVISION: usize = 4;

/// What the glazing of these windows asks of a method that is left open.
///
/// # Errors
/// None: the subdivisions exist.
pub(crate) fn glazing(project: &Project) -> Result<Glazing> {
    let mut sunny = project.windows.iter().filter(|w| w.lets_suns_through()).peekable();
    // Real slats in front of a window are as sharp as they are, whatever its scattering data say.
    let has_shade = |w: &WindowSection| w.shade.is_some() || w.states.iter().any(|s| s.shade.is_some());
    let spreads_suns = sunny.peek().is_some() && sunny.all(|w| !has_shade(w) && is_diffuse(project, w));
    Ok(Glazing { sky: sky(project)?, spreads_suns })
}

/// Whether a window spreads light evenly, whatever it comes from, in each of its states. A file that
/// cannot be read is not diffuse; reading it as an input says what is wrong with it.
fn is_diffuse(project: &Project, window: &WindowSection) -> bool {
    let is_clear = window.each_state().iter().any(|s| s.filling.is_clear());
    !is_clear && data_of_states(project, window).iter().all(|data| data.as_ref().is_some_and(spreads))
}

fn spreads(bsdf: &Bsdf) -> bool {
    let blocks = [&bsdf.visible.transmission_front, &bsdf.visible.transmission_back];
    let mut found = blocks.into_iter().flatten().peekable();
    found.peek().is_some() && found.all(block_spreads)
}

fn block_spreads(block: &Block) -> bool {
    let basis = AngleBasis::from(KlemsBasis::Full);
    (0..basis.len()).map(|i| basis.centre(i)).all(|incident| {
        let mean = block.direct_hemispherical(incident) / std::f64::consts::PI;
        (0..basis.len()).all(|o| block.evaluate(basis.centre(o), incident) <= EVEN * mean)
    })
}

/// Light that a pane passes straight on, beyond what it scatters around, from which a sun is seen through it.
const SEEN_THROUGH: f64 = 0.01;
/// Bins within this angle of the straight one are its surround, degrees.
const SURROUND_DEG: f64 = 30.0;

/// Whether a sun is seen through a window in any of its states, from any direction. A file that cannot be read is left
/// to the reading of the inputs.
pub(crate) fn passes_direct(project: &Project, window: &WindowSection) -> bool {
    window.each_state().iter().any(|s| s.filling.is_clear()) || data_of_states(project, window).iter().flatten().any(sees_sun)
}

fn sees_sun(bsdf: &Bsdf) -> bool {
    let blocks = [&bsdf.visible.transmission_front, &bsdf.visible.transmission_back];
    blocks.into_iter().flatten().next().is_some_and(block_passes_direct)
}

/// In data as coarse as Klems' a peak is a bin whose value exceeds that of its surround by the published
/// rule of peak extraction ([`PUBLISHED_CONTRAST`]), and by light that counts.
fn block_passes_direct(block: &Block) -> bool {
    let basis = AngleBasis::from(KlemsBasis::Full);
    (0..basis.len()).any(|i| peak(block, &basis, i).is_some_and(|share| share > SEEN_THROUGH))
}

/// The share of light from a bin that goes straight on, beyond what is scattered around; nothing without a peak there.
fn peak(block: &Block, basis: &AngleBasis, bin: usize) -> Option<f64> {
    let incident = basis.centre(bin);
    let ahead = block.evaluate(incident, incident);
    let near = |d: &DVec3| d.angle_between(incident).to_degrees() < SURROUND_DEG && *d != incident;
    let around: Vec<f64> = (0..basis.len()).map(|i| basis.centre(i)).filter(near).map(|d| block.evaluate(d, incident)).collect();
    let surround = around.iter().sum::<f64>() / around.len().max(1) as f64;
    (ahead > PUBLISHED_CONTRAST * surround).then(|| (ahead - surround) * basis.projected_solid_angle(bin))
}

/// Whether what is outside is seen through: of the light that comes square to it more goes straight on than is scattered.
pub(super) fn is_seen_through(filled: &Filled) -> bool {
    match filled {
        Filled::Data(data, _) | Filled::Layers(data) => shows_view(data),
        Filled::Glass(_) => true,
    }
}

fn shows_view(bsdf: &Bsdf) -> bool {
    let blocks = [&bsdf.visible.transmission_front, &bsdf.visible.transmission_back];
    let basis = AngleBasis::from(KlemsBasis::Full);
    blocks.into_iter().flatten().next().is_some_and(|block| {
        let passed: f64 = (0..basis.len()).map(|o| block.evaluate(basis.centre(o), basis.centre(0)) * basis.projected_solid_angle(o)).sum();
        peak(block, &basis, 0).is_some_and(|straight| straight > passed / 2.0)
    })
}

/// The sky of `sky_subdivision = "auto"`: that of a matrix D made elsewhere, or as fine as the glazing asks.
fn sky(project: &Project) -> Result<ReinhartSky> {
    let windows = &project.windows;
    let columns = |w: &WindowSection| Some(MatrixRows::open(&w.daylight.as_ref()?.total).ok()??.cols());
    if let Some(columns) = windows.iter().find_map(columns)
        && let Some(sky) = (1..=6).filter_map(|n| ReinhartSky::new(n).ok()).find(|sky| sky.len() == columns)
    {
        return Ok(sky);
    }
    let diffuse = !windows.is_empty() && windows.iter().all(|w| is_diffuse(project, w));
    ReinhartSky::new(if diffuse { DIFFUSE_SUBDIVISION } else { DIRECTIONAL_SUBDIVISION })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Blocks, KlemsMatrix, TensorTree};
    use crate::error::Warnings;
    use std::path::Path;

    fn of(block: Block) -> Bsdf {
        Bsdf { visible: Blocks { transmission_front: Some(block), ..Blocks::default() }, ..Bsdf::default() }
    }

    #[test]
    fn even_scatterers_are_diffuse_and_all_others_are_not() {
        let basis = AngleBasis::from(KlemsBasis::Full);
        assert!(spreads(&of(Block::Tree(TensorTree::constant(4, 0.1)))));
        assert!(spreads(&of(Block::Klems(KlemsMatrix::from_fn(&basis, |_, _| 0.1)))));
        let clear = |through: f64| Block::Klems(KlemsMatrix::from_fn(&basis, move |o, i| if o == i { through } else { 0.1 }));
        assert!(spreads(&of(clear(0.12))) && !spreads(&of(clear(2.0))));
        assert!(!spreads(&Bsdf::default()), "nothing is known of it");
    }

    #[test]
    fn the_sun_is_seen_through_clear_panes_and_open_slats_and_not_through_diffusers() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let seen = |name: &str| sees_sun(&crate::bsdf::read(&scenes.join(name), &mut Warnings::new()).unwrap());
        assert!(seen("office/bsdf/double_clear.xml") && seen("bsdf/clear.xml") && seen("bsdf/woven.xml"));
        let view = |name: &str| shows_view(&crate::bsdf::read(&scenes.join(name), &mut Warnings::new()).unwrap());
        assert!(view("office/bsdf/double_clear.xml") && view("bsdf/clear.xml") && !view("bsdf/cloudy.xml"), "5 % straight of 65 %");
        let basis = AngleBasis::from(KlemsBasis::Full);
        let with_peak = |share: f64| {
            let lambda: Vec<f64> = (0..basis.len()).map(|i| basis.projected_solid_angle(i)).collect();
            let value = move |o: usize, i: usize| if o == i { 0.1 + share / lambda[i] } else { 0.1 };
            block_passes_direct(&Block::Klems(KlemsMatrix::from_fn(&basis, value)))
        };
        assert!(!with_peak(0.0) && !with_peak(0.009) && with_peak(0.011) && with_peak(0.5));
        assert!(!block_passes_direct(&Block::Tree(TensorTree::constant(4, 0.1))));
    }
}
