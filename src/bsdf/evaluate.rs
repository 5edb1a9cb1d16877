//! Scattering data as a tracer asks for them: which block answers for which side, what is missing
//! made from what is there, the diffuse part split off.
//!
//! Rules are those of Radiance's library (`bsdf.c`, `bsdf_m.c`, `bsdf_t.c`):
//! * only the wavelength `Visible` counts; negative values are 0;
//! * a missing transmission is the other one by Helmholtz reciprocity; a missing reflection is black;
//! * the least value of a block, if above 0.01/π, is its Lambertian part ([`Lobe::lambertian`]); a
//!   tree's only below 1.5/π, and at rank 3 without the unused half;
//! * values are those of the bin or cell, never interpolated.
//!
//! Not followed, on purpose: Radiance multiplies every value by a factor that depends on its
//! position, so that equal neighbours can be told apart (±3e-4 for matrices, ±2e-4 for trees), and
//! drops components whose largest direct-hemispherical value is at most 0.001.
//!
//! Directions are those in which light **travels**, unit vectors in the window's frame (z into the
//! room); unlike in [`Block::evaluate`] the sign of z counts and tells the side.
//!
//! Radiance's material (`m_bsdf.c`) asks with the two directions exchanged, because it follows
//! light backwards: for daylight seen from the room it takes *Transmission Back*, where
//! `dctimestep` and this program take *Transmission Front*. Data that are not reciprocal differ.

use super::{Block, Blocks, Bsdf, Component, TensorTree};
use crate::error::{Error, Result, Warnings};
use glam::DVec3;
use std::f64::consts::PI;

/// Least value that is split off as a Lambertian part, 1/sr.
pub const LEAST_LAMBERTIAN: f64 = 0.01 / PI;
/// A tree's least value from which it is not split off, 1/sr.
pub const LARGEST_LAMBERTIAN: f64 = 1.5 / PI;

/// Share of light that leaves a pane above which energy is made up; Radiance warns at the same.
pub(super) const MOST_SHARE: f64 = 1.01;

/// Share above which values are no scattering values at all.
const ABSURD_SHARE: f64 = 1000.0;

/// The scattering function of a pane with all its sides, 1/sr.
#[derive(Debug, Clone, PartialEq)]
pub struct Scattering {
    lobes: [Option<Lobe>; 4],
}

/// The scattering of light that comes from one side and leaves on one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobe {
    /// Hemispherical transmittance or reflectance of the part that goes into all directions alike.
    pub lambertian: f64,
    /// What remains without it: no negative values.
    pub residue: Residue,
    /// Projected solid angle of the smallest bin or cell, sr.
    pub smallest: f64,
}

/// The part of a [`Lobe`] that depends on direction.
#[derive(Debug, Clone, PartialEq)]
pub enum Residue {
    /// Data of this component.
    Block(Block),
    /// An isotropic tree of the opposite transmission, by reciprocity. (Other data are turned into
    /// a [`Block`] of their own.)
    ReversedIsotropic(TensorTree),
}

impl Scattering {
    /// The visible data of a file.
    ///
    /// # Errors
    /// If the file has no visible data, or a value that is not finite.
    pub fn new(bsdf: &Bsdf) -> Result<Self> {
        Self::of_blocks(&bsdf.visible)
    }

    /// As [`new`](Self::new), with warnings of what is used all the same: negative values (they count
    /// as 0), more light out than in, no transmission.
    ///
    /// # Errors
    /// As [`new`](Self::new); a thousand times more light out than in.
    pub fn checked(bsdf: &Bsdf, warnings: &mut Warnings) -> Result<Self> {
        let scattering = Self::new(bsdf)?;
        for (component, block) in bsdf.visible.iter() {
            let negative = count_negative(block);
            if negative > 0 {
                let text = format!("{negative} values are negative and count as 0");
                warnings.push(
                    Error::new(text).field(component.xml_name()).help("`lucarne bsdf check --repair -o FILE` writes a file without them"),
                );
            }
        }
        if scattering.lobe(Component::TransmissionFront).is_none() {
            warnings.push(Error::new("there is no transmission: no light passes the pane").field("Transmission Front"));
        }
        let (direction, share) = scattering.largest_share();
        if share > ABSURD_SHARE {
            return Err(Error::new(format!("{share:.2e} times the light that arrives would leave the pane")).field("ScatteringData").help(
                "scattering values are in 1/sr, their hemispherical sums at most 1: get the file again, or `lucarne bsdf check` it",
            ));
        }
        if share > MOST_SHARE {
            let theta = direction.z.abs().min(1.0).acos().to_degrees();
            let side = if direction.z > 0.0 { "outside" } else { "room" };
            warnings.push(
                Error::new(format!("{:.1} % of the light from the {side} at {theta:.0}° leaves the pane", 100.0 * share))
                    .help("more leaves than arrives: check the file with `lucarne bsdf check`"),
            );
        }
        Ok(scattering)
    }

    /// The incident direction, among many, of the largest transmitted and reflected share together.
    fn largest_share(&self) -> (DVec3, f64) {
        const STEPS: usize = 12;
        let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
        let mut largest = (DVec3::Z, 0.0);
        for k in 0..STEPS * STEPS {
            let [x, y] = crate::bins::shirley_chiu::disk_from_square(at(k / STEPS), at(k % STEPS));
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            for d in [DVec3::new(x, y, z), DVec3::new(x, y, -z)] {
                let share = |transmitted: bool| match self.lobe(Self::component_of(d, transmitted)).map(|l| &l.residue) {
                    // Its quadrature is slow, and the other side has been looked at.
                    Some(Residue::ReversedIsotropic(_)) | None => 0.0,
                    Some(_) => self.direct_hemispherical(d, transmitted),
                };
                let sum = share(true) + share(false);
                if sum > largest.1 {
                    largest = (d, sum);
                }
            }
        }
        largest
    }

    /// The data of one band.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_blocks(blocks: &Blocks) -> Result<Self> {
        if blocks.is_empty() {
            return Err(Error::new("the BSDF has no data of wavelength Visible")
                .field("WavelengthData")
                .help("use a file with Visible data: a pane cannot be shown with Solar data"));
        }
        for (component, block) in blocks.iter() {
            if !is_finite(block) {
                return Err(Error::new("a scattering value is not a finite number").field(component.xml_name()));
            }
        }
        let lobe = |component: Component| match blocks.get(component) {
            Some(block) => Some(Lobe::new(block)),
            None => blocks.get(component.reciprocal()).map(Lobe::reversed),
        };
        Ok(Self { lobes: Component::ALL.map(lobe) })
    }

    /// The component of light travelling along these directions.
    pub fn component(outgoing: DVec3, incident: DVec3) -> Component {
        match (incident.z >= 0.0, outgoing.z > 0.0) {
            (true, true) => Component::TransmissionFront,
            (false, false) => Component::TransmissionBack,
            (true, false) => Component::ReflectionFront,
            (false, true) => Component::ReflectionBack,
        }
    }

    /// The lobe of a component; `None` if it is black.
    pub fn lobe(&self, component: Component) -> Option<&Lobe> {
        self.lobes[component as usize].as_ref()
    }

    /// The scattering function in 1/sr for light that travels along `incident` and leaves along
    /// `outgoing`.
    pub fn evaluate(&self, outgoing: DVec3, incident: DVec3) -> f64 {
        self.lobe(Self::component(outgoing, incident)).map_or(0.0, |l| l.evaluate(outgoing, incident))
    }

    /// Transmittance (or reflectance) of light that travels along `incident`.
    pub fn direct_hemispherical(&self, incident: DVec3, transmitted: bool) -> f64 {
        self.lobe(Self::component_of(incident, transmitted)).map_or(0.0, |l| l.direct_hemispherical(incident))
    }

    /// The component of transmitted or reflected light that travels along `incident` before.
    pub fn component_of(incident: DVec3, transmitted: bool) -> Component {
        let z = if transmitted == (incident.z >= 0.0) { 1.0 } else { -1.0 };
        Self::component(DVec3::Z * z, incident)
    }
}

impl Lobe {
    fn new(block: &Block) -> Self {
        let block = map(block, |v| v.max(0.0));
        let least = least_value(&block);
        let splits = least > LEAST_LAMBERTIAN && (matches!(block, Block::Klems(_)) || least < LARGEST_LAMBERTIAN);
        let lambertian = if splits { least } else { 0.0 };
        let residue = if splits { map(&block, |v| (v - least).max(0.0)) } else { block };
        Self { lambertian: PI * lambertian, smallest: smallest(&residue), residue: Residue::Block(residue) }
    }

    /// The lobe of the opposite transmission.
    fn reversed(block: &Block) -> Self {
        let lobe = Self::new(block);
        let Residue::Block(block) = lobe.residue else { return lobe };
        let residue = match block {
            Block::Klems(m) => Residue::Block(Block::Klems(m.reversed())),
            Block::Tree(t) => match t.reversed() {
                Some(reversed) => Residue::Block(Block::Tree(reversed)),
                None => Residue::ReversedIsotropic(t),
            },
        };
        Self { residue, ..lobe }
    }

    /// The lobe's function, 1/sr, for unit vectors whose sides are those of the lobe.
    pub fn evaluate(&self, outgoing: DVec3, incident: DVec3) -> f64 {
        self.lambertian / PI
            + match &self.residue {
                Residue::Block(block) => block.evaluate(outgoing, incident),
                Residue::ReversedIsotropic(tree) => tree.evaluate(-incident, -outgoing),
            }
    }

    /// Transmittance or reflectance of light that travels along `incident`, the Lambertian part
    /// included. Exact over bins and cells; by quadrature for a reversed isotropic tree.
    pub fn direct_hemispherical(&self, incident: DVec3) -> f64 {
        self.lambertian
            + match &self.residue {
                Residue::Block(block) => block.direct_hemispherical(incident),
                Residue::ReversedIsotropic(tree) => {
                    const STEPS: usize = 256;
                    let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
                    let value = |k: usize| {
                        let [x, y] = crate::bins::shirley_chiu::disk_from_square(at(k / STEPS), at(k % STEPS));
                        tree.evaluate(-incident, DVec3::new(-x, -y, 1.0))
                    };
                    (0..STEPS * STEPS).map(value).sum::<f64>() * PI / (STEPS * STEPS) as f64
                }
            }
    }

    /// What tells the bin or cell around two directions from all others.
    pub fn cell(&self, outgoing: DVec3, incident: DVec3) -> [u64; 5] {
        let of_tree = |tree: &TensorTree, o: DVec3, i: DVec3| {
            let cell = tree.cell(tree.point(o, i));
            let [a, b, c, d] = cell.corner.map(f64::to_bits);
            [a, b, c, d, cell.side.to_bits()]
        };
        match &self.residue {
            Residue::Block(Block::Klems(m)) => [m.incident().bin_of(incident) as u64, m.outgoing().bin_of(outgoing) as u64, 0, 0, 0],
            Residue::Block(Block::Tree(t)) => of_tree(t, outgoing, incident),
            Residue::ReversedIsotropic(t) => of_tree(t, -incident, -outgoing),
        }
    }

    /// Projected solid angle of the bin or cell around two directions, the smaller one of the
    /// incident and the outgoing side, sr (`SDsizeBSDF` with `SDqueryMin`).
    pub fn cell_size(&self, outgoing: DVec3, incident: DVec3) -> f64 {
        let of_tree = |tree: &TensorTree, o: DVec3, i: DVec3| PI * tree.cell(tree.point(o, i)).side.powi(2);
        match &self.residue {
            Residue::Block(Block::Klems(m)) => {
                let size = |basis: &crate::bins::AngleBasis, d: DVec3| basis.projected_solid_angle(basis.bin_of(d));
                size(m.incident(), incident).min(size(m.outgoing(), outgoing))
            }
            Residue::Block(Block::Tree(t)) => of_tree(t, outgoing, incident),
            Residue::ReversedIsotropic(t) => of_tree(t, -incident, -outgoing),
        }
    }
}

fn is_finite(block: &Block) -> bool {
    match block {
        Block::Klems(m) => m.values().iter().all(|v| v.is_finite()),
        Block::Tree(t) => {
            let mut finite = true;
            t.for_each_cell(|c| finite &= c.value.is_finite());
            finite
        }
    }
}

fn count_negative(block: &Block) -> usize {
    match block {
        Block::Klems(m) => m.values().iter().filter(|v| **v < 0.0).count(),
        Block::Tree(t) => {
            let mut count = 0;
            t.for_each_cell(|c| count += usize::from(c.value < 0.0));
            count
        }
    }
}

fn map(block: &Block, f: impl Fn(f64) -> f64) -> Block {
    match block {
        Block::Klems(m) => {
            let mut m = m.clone();
            m.values_mut().iter_mut().for_each(|v| *v = f(*v));
            Block::Klems(m)
        }
        Block::Tree(t) => Block::Tree(t.map(|v| f(f64::from(v)) as f32)),
    }
}

/// The least value, without the half of a rank 3 tree that no direction reaches.
fn least_value(block: &Block) -> f64 {
    match block {
        Block::Klems(m) => m.values().iter().copied().fold(f64::INFINITY, f64::min),
        Block::Tree(t) => {
            let mut least = f64::INFINITY;
            t.for_each_cell(|c| {
                if t.rank() == 4 || c.corner[0] < 0.5 {
                    least = least.min(c.value);
                }
            });
            least
        }
    }
}

fn smallest(block: &Block) -> f64 {
    match block {
        Block::Klems(m) => {
            let least = |basis| super::projected_solid_angles(basis).into_iter().fold(PI, f64::min);
            least(m.incident()).min(least(m.outgoing()))
        }
        Block::Tree(t) => PI / (t.resolution() as f64).powi(2),
    }
}

#[cfg(test)]
mod tests;
