//! Importance sampling of outgoing directions.
//!
//! Directions are drawn with a density proportional to the scattering function in projected solid
//! angle, so that every sample carries the same weight: the direct-hemispherical value. (A reversed
//! isotropic tree is drawn from the cosine distribution instead; Radiance does not sample it.)

use super::evaluate::{Lobe, Residue, Scattering};
use super::{Block, Component};
use crate::bins::shirley_chiu::disk_from_square;
use glam::DVec3;
use std::f64::consts::PI;

/// A direction drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// In which light travels on; unit length, window's frame.
    pub direction: DVec3,
    /// Factor on the light's flux: the scattering function over the density.
    pub weight: f64,
    /// Density, per sr of projected solid angle.
    pub density: f64,
}

/// Bins or cells of outgoing directions for one incident direction: corner and width in the
/// basis's own coordinates, and the flux each of them takes.
enum Place {
    Bin(usize),
    Cell { corner: [f64; 2], side: f64 },
    Anywhere,
}

impl Scattering {
    /// Draws where transmitted (or reflected) light goes on that travels along `incident`;
    /// `random` are three numbers in [0, 1). `None` if none is transmitted (reflected).
    pub fn sample(&self, incident: DVec3, transmitted: bool, random: [f64; 3]) -> Option<Sample> {
        let component = Self::component_of(incident, transmitted);
        let mut sample = self.lobe(component)?.sample(incident, random)?;
        let to_room = matches!(component, Component::TransmissionFront | Component::ReflectionBack);
        if !to_room {
            sample.direction.z = -sample.direction.z;
        }
        Some(sample)
    }
}

impl Lobe {
    /// As [`Scattering::sample`]; the direction has z ≥ 0.
    pub fn sample(&self, incident: DVec3, random: [f64; 3]) -> Option<Sample> {
        let places = self.places(incident);
        let total: f64 = self.lambertian + places.iter().map(|(flux, _)| flux).sum::<f64>();
        if !(total > 0.0) {
            return None;
        }
        let mut rest = random[0] * total;
        let mut chosen = &Place::Anywhere;
        if rest >= self.lambertian {
            rest -= self.lambertian;
            // The last place with any flux takes what rounding leaves over.
            for (flux, place) in places.iter().filter(|(flux, _)| *flux > 0.0) {
                chosen = place;
                if rest < *flux {
                    break;
                }
                rest -= flux;
            }
        }
        let direction = self.direction_in(chosen, incident, [random[1], random[2]]);
        if matches!(self.residue, Residue::ReversedIsotropic(_)) {
            return Some(Sample { direction, weight: PI * self.evaluate(direction, incident), density: 1.0 / PI });
        }
        Some(Sample { direction, weight: total, density: self.evaluate(direction, incident) / total })
    }

    fn places(&self, incident: DVec3) -> Vec<(f64, Place)> {
        match &self.residue {
            Residue::Block(Block::Klems(m)) => {
                let i = m.incident().bin_of(incident);
                let flux = |o: usize| m.at(o, i) * m.outgoing().projected_solid_angle(o);
                (0..m.outgoing().len()).map(|o| (flux(o), Place::Bin(o))).collect()
            }
            Residue::Block(Block::Tree(t)) => {
                let mut places = Vec::new();
                t.for_each_outgoing_cell(t.point(DVec3::Z, incident), |c| {
                    let corner = [c.corner[t.rank() - 2], c.corner[t.rank() - 1]];
                    places.push((c.value * PI * c.side * c.side, Place::Cell { corner, side: c.side }));
                });
                places
            }
            Residue::ReversedIsotropic(_) => vec![(1.0, Place::Anywhere)],
        }
    }

    fn direction_in(&self, place: &Place, incident: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        let upward = |[x, y]: [f64; 2]| DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
        match (place, &self.residue) {
            (Place::Bin(o), Residue::Block(Block::Klems(m))) => m.outgoing().direction(*o, u, v),
            (Place::Cell { corner, side }, Residue::Block(Block::Tree(t))) => {
                let [x, y] = disk_from_square(corner[0] + u * side, corner[1] + v * side);
                if t.rank() == 4 {
                    return upward([x, y]);
                }
                let [cos, sin] = azimuth(incident);
                upward([x * cos - y * sin, x * sin + y * cos])
            }
            _ => upward(disk_from_square(u, v)),
        }
    }
}

/// Cosine and sine of the azimuth; 0 at the pole, as [`super::TensorTree::point`] has it.
fn azimuth(direction: DVec3) -> [f64; 2] {
    let sin = direction.x.hypot(direction.y);
    if sin > 1e-12 { [direction.x / sin, direction.y / sin] } else { [1.0, 0.0] }
}
