//! Light by a BSDF window without V and D: each path from a receiver goes on outside from the very point where it crosses
//! the window. In f64, and plainly.

use super::{Opening, Surroundings, spread};
use crate::random::Random;
use crate::scene::points::Sensor;
use crate::simulate::inputs::Inputs;
use crate::simulate::project::Project;
use crate::statistics::variance_of_mean;
use crate::units::ILLUMINANCE_WEIGHTS;
use glam::DVec3;
use rayon::prelude::*;

/// How much to sample: batches; points of each window seen directly from the receiver; paths into the room, and points that each
/// of their reflections is connected to.
#[derive(Clone, Copy)]
pub struct Samples {
    pub batches: u64,
    pub direct: usize,
    pub paths: usize,
    pub points: usize,
}

struct Truth<'a> {
    around: Surroundings,
    inputs: &'a Inputs,
    /// Of each window and outgoing bin: what it passes of each incident bin, summed up.
    passed: Vec<Vec<Vec<f64>>>,
}

/// The year's mean at each sensor with its standard error, lx.
pub fn light(project: &Project, inputs: &Inputs, sensors: &[Sensor], samples: Samples) -> Vec<[f64; 2]> {
    let weights: f64 = ILLUMINANCE_WEIGHTS.iter().sum();
    let grey = |v: &[f64]| v.iter().zip(ILLUMINANCE_WEIGHTS).map(|(v, w)| v * w).sum::<f64>() / weights;
    let sums = |window: &crate::simulate::inputs::ProjectWindow| {
        let t = &window.transmission;
        let running = |sum: &mut f64, value: f64| {
            *sum += value;
            Some(*sum)
        };
        let row = |out: usize| (0..t.cols()).map(|i| grey(t.at(out, i))).scan(0.0, running).collect();
        (0..t.rows()).map(row).collect()
    };
    let truth = Truth { around: Surroundings::new(project, inputs).unwrap(), inputs, passed: inputs.windows.iter().map(sums).collect() };
    let of = |(i, sensor): (usize, &Sensor)| {
        let batches: Vec<f64> = (0..samples.batches)
            .into_par_iter()
            .map(|b| truth.batch(sensor, Random(b * 7919 + i as u64 * 104_729 + 13), samples))
            .collect();
        [batches.iter().sum::<f64>() / batches.len() as f64, variance_of_mean(batches.iter().copied()).sqrt()]
    };
    sensors.iter().enumerate().map(of).collect()
}

impl Truth<'_> {
    fn batch(&self, sensor: &Sensor, mut random: Random, samples: Samples) -> f64 {
        let normal = sensor.direction.normalize();
        let mut light = self.connected(sensor.position, normal, samples.direct, &mut random);
        for _ in 0..samples.paths {
            let (mut origin, mut direction, mut weight) = (sensor.position, random.cosine_direction(normal), 1.0);
            for _ in 0..24 {
                let Some((distance, number)) = self.around.met(origin, direction, 1e-6) else { break };
                if self.around.windows.nearest(origin, direction, 1e-6).is_some_and(|(d, _)| d < distance) {
                    break;
                }
                let Some((share, next)) = self.around.sent_on(number, direction, &mut random) else { break };
                let front = self.around.fronts[number];
                weight *= share;
                origin += distance * direction;
                direction = next;
                let side = if next.dot(front) < 0.0 { -front } else { front };
                light += weight / samples.paths as f64 * self.connected(origin, side, samples.points, &mut random);
            }
        }
        light
    }

    /// Irradiance of a point directly from all windows.
    fn connected(&self, origin: DVec3, normal: DVec3, points: usize, random: &mut Random) -> f64 {
        let mut light = 0.0;
        for (number, opening) in self.around.openings.iter().enumerate() {
            let shift: [f64; 4] = std::array::from_fn(|_| random.next());
            for i in 0..points {
                let [u, v, pick, turn] = spread(i, &shift);
                let point = opening.point(u, v);
                let (to, distance) = ((point - origin).normalize(), (point - origin).length());
                let (cosine, leaving) = (to.dot(normal), -to.dot(opening.window.frame.z));
                if cosine > 0.0 && leaving > 0.0 && self.around.met(origin, to, 1e-6).is_none_or(|(d, _)| d > distance * (1.0 - 1e-6)) {
                    let seen = cosine * leaving * opening.area / (points as f64 * distance * distance);
                    light += seen * self.behind(number, opening, point, -to, [pick, turn], random);
                }
            }
        }
        light
    }

    /// Luminance that leaves a point of a window into the room: one incident bin by chance, one direction in it.
    fn behind(&self, number: usize, opening: &Opening, point: DVec3, direction: DVec3, [pick, turn]: [f64; 2], random: &mut Random) -> f64 {
        let frame = opening.window.frame;
        let sums = &self.passed[number][opening.window.basis.bin_of(frame.to_local(direction))];
        let all = sums[sums.len() - 1];
        if all == 0.0 {
            return 0.0;
        }
        let incident = sums.iter().position(|s| pick * all < *s).unwrap_or(sums.len() - 1);
        let from = -frame.to_world(self.inputs.windows[number].window.basis.direction(incident, random.next(), turn));
        all * self.around.luminance_outside(point - frame.z * 1e-6, from, 24, random)
    }
}
