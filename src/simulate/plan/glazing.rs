//! What the windows' glazing asks of the method: a panel that spreads all light evenly blurs what finer
//! skies and traced suns would add.

use crate::bins::{AngleBasis, KlemsBasis, ReinhartSky};
use crate::bsdf::{self, Block, Bsdf};
use crate::error::{Result, Warnings};
use crate::simulate::project::WindowSection;

/// Largest radiance of an outgoing bin, over the mean of all, of a panel that counts as diffuse.
const EVEN: f64 = 1.5;
/// Reinhart MF of diffuse panels: hourly illuminance behind one differs by 2 % (rms) from that of MF:4.
const DIFFUSE_SUBDIVISION: usize = 2;
/// Reinhart MF of all other glazing: behind clear glass MF:1 is off by 27 % (rms) in an hour, MF:4 by 1 %.
const DIRECTIONAL_SUBDIVISION: usize = 4;

/// Whether a window spreads light evenly, whatever it comes from, in each of its states. A file that
/// cannot be read is not diffuse; reading the inputs will say what is wrong with it.
pub fn is_diffuse(window: &WindowSection) -> bool {
    let states = if window.states.is_empty() { std::slice::from_ref(&window.bsdf) } else { &window.states[..] };
    states.iter().all(|file| bsdf::read(file, &mut Warnings::new()).is_ok_and(|b| spreads(&b)))
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

/// The sky of `sky_subdivision = "auto"`.
///
/// # Errors
/// None: the subdivisions exist.
pub fn sky(windows: &[WindowSection]) -> Result<ReinhartSky> {
    ReinhartSky::new(if windows.iter().all(is_diffuse) { DIFFUSE_SUBDIVISION } else { DIRECTIONAL_SUBDIVISION })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Blocks, KlemsMatrix, TensorTree};

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
}
