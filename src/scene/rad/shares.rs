//! What materials of several forms have in common: counts of arguments, and shares that sum to 1 at most.

use super::syntax::Object;
use crate::error::{Error, Result};
use crate::scene::{Lobes, MaterialKind};

/// # Errors
/// If an object has fewer arguments than it needs.
pub(super) fn needs(object: &Object, strings: usize, reals: usize, meaning: &str) -> Result<()> {
    if object.strings.len() < strings || object.reals.len() < reals {
        return Err(Error::new(format!(
            "{} string and {} real arguments, but {strings} and {reals} are needed",
            object.strings.len(),
            object.reals.len()
        ))
        .help(format!("the arguments are: {meaning}")));
    }
    Ok(())
}

/// The refusal of surfaces that scatter differently on their two sides.
pub(super) fn two_faced() -> Error {
    Error::new("its front and back reflect different shares of light to all directions, which one surface cannot do here")
        .help("draw the surface twice, each side with a `plastic` of its own, or use a BSDF file")
}

/// Lobes that send on no more light than they receive.
///
/// # Errors
/// If they do, or are negative.
pub(super) fn bounded(lobes: Lobes) -> Result<MaterialKind> {
    let parts = [lobes.diffuse, lobes.diffuse_transmitted, lobes.specular, lobes.specular_transmitted];
    for c in 0..3 {
        let sum: f64 = parts.iter().map(|p| p[c]).sum();
        if !(sum <= 1.0 + 1e-3 && parts.iter().all(|p| p[c] >= 0.0)) {
            return Err(Error::new(format!("its parts sum to {sum:.4} of the light that it receives"))
                .help("reflection and transmission together are at most 1, and none is negative"));
        }
    }
    Ok(MaterialKind::Lobes(lobes))
}
