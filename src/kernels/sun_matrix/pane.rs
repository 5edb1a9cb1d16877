//! The sun through a pane that scatters: BSDF, aBSDF, glass and trans.
//!
//! `C[receiver][sun] = ∫_pane f(ω_sun → ω) cosθ_sun Ω_sun · visible outside · visible inside · G dA`,
//! the irradiance per unit radiance of the sun's disc (sr). Only light that the pane scatters once,
//! directly to the receiver, counts: five-phase's Cds is a direct part.
//!
//! The panes are cut into small triangles. A ray from a random point of each to every receiver and to
//! every sun tells what is visible – rays grow with cells × (receivers + suns). Only the scattering
//! function and G are evaluated for every pair of receiver and sun: at that point, and as a control
//! variate at as many more as the cell's size seen from the receiver asks for. Several batches with
//! other random points give the standard error.
//!
//! What passes directly through – the peak of an aBSDF, glass, the specular part of trans – is the
//! clear disc seen through the window: Ω cosθ · transmittance · visibility.
//!
//! # Why Radiance's coefficients through a Klems BSDF lie above the three-phase direct part
//! For eight single suns in a side-lit room, `rcontrib` through a Klems pane gives 16 % more than
//! Vd·T·Dd of the suns' patches (and 14 % more than the real slats). Two causes; a test holds the
//! first, the second is an estimate:
//! * *One sun, one bin* (13 %). A sun falls into a single incident bin of 10–15° and meets its mean
//!   value; the patch of a three-phase product, 12° wide, spreads it over all bins that it overlaps.
//!   For one sun the two differ by up to a factor of 4 in either direction. This module finds the same
//!   excess for the same suns; over suns that fill the patches evenly it comes within 2 % of Vd·T·Dd.
//!   What is left then is the deep reveal: V and D each average over the window, while an oblique sun
//!   lights a strip of it only, and a sensor near the wall sees that strip well or not at all. With V and
//!   D sampled for parts of the window, single patches come within 10 % by 2 columns of parts, 7 % by 8,
//!   3 % by 16, and 1 % (all together 0.4 %) by 32; more rows, more suns in a patch, or discs for points
//!   change nothing. Neither is wrong: the data do not tell more.
//! * *The other block* (3 %). Radiance's material follows light backwards and takes Transmission Back;
//!   `dctimestep` and this program take Transmission Front. Traced data are not exactly reciprocal.
//!
//! Radiance also moves the direction to the eye at random by up to half a bin (`-ss`), which smooths
//! single receivers.

mod kinds;
pub(super) mod light;
pub(super) mod tables;

pub use kinds::PaneBsdf;

#[cfg(test)]
pub(crate) mod tests;
