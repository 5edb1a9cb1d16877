//! Sun matrix Cds: what each receiver gets from each sun through the windows.
//!
//! `C[receiver][sun]` is the irradiance per unit radiance of the sun's disc (sr): Ω·cos θ where
//! nothing is in the way, as `rcontrib -I+ -m solar` has it.
//!
//! | part | estimator | module |
//! |---|---|---|
//! | direct through openings, panes and between slats | low-discrepancy points of the disc, a ray each | `direct` |
//! | suns in pictures: lit surfaces, lit slats, the disc itself | the same for the surface behind each pixel, of which those that may see a sun are listed first; rays to points of the disc | [`pixels`] |
//! | by way of flat mirror-like slats | the same for the sun's images in them | [`mirrors`] |
//! | scattered once by a BSDF pane | quadrature over the window | [`pane`] |
//! | scattered diffusely by slats and other surfaces | points on them that all receivers share, where these say more | `shades` |
//! | the same for few suns or receivers, next to the surfaces, by rough or mirror-like ones, seen in panes | paths from the receiver, whose vertices serve *all* suns | `paths` |

#[cfg(test)]
mod coverage;
mod direct;
mod links;
#[cfg(test)]
mod mirror_tests;
pub mod mirrors;
mod openings;
mod options;
#[cfg(test)]
mod pair_tests;
pub mod pane;
mod paths;
pub mod pixels;
#[cfg(test)]
pub(crate) mod reference;
mod result;
mod sensors;
mod shade_cells;
mod shade_sums;
#[cfg(test)]
mod shade_tests;
mod shades;
mod sun;
#[cfg(test)]
mod tests;
mod tracer;

pub use openings::Openings;
pub use options::ScatteredBy;
pub use options::SunOptions;
pub(crate) use result::Hits;
pub use result::SunMatrix;
pub use sensors::compute;
pub use sun::Sun;
pub(crate) use tracer::SunRecord;

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<crate::gpu::Shader> {
    let mut all = direct::registered();
    all.extend(paths::registered());
    all.extend([links::LINKS, pixels::behind::PIXELS, shades::POINTS]);
    all.extend(pane::light::registered());
    all
}
