//! Which lobes of one incident direction become which of another.
//!
//! Mass transport with entropy (Sinkhorn's iteration, Cuturi 2013), where mass may change on its way at a price (Chizat,
//! Peyré, Schmitzer and Vialard 2018). It costs to move, and to become brighter or darker: the squared angle over
//! [`FAR`]² plus the squared difference of the logarithms of the densities, so that peaks go to peaks and the ground
//! stays where it is (by angle alone a peak would rather push its surround ahead than move through it). The entropy's
//! weight falls in steps, from a rough plan to a sharp one.

use super::{CUT, Edge, Lobe, Target, mirrored};
use glam::DVec3;

/// An angle that costs as much as a density e times larger, radians.
const FAR: f64 = 0.1;
/// Weights of the entropy, one after the other, in units of the cost.
const STEPS: [f64; 5] = [4.0, 1.0, 0.25, 0.06, 0.015];
/// Iterations of each.
const ITERATIONS: usize = 8;
/// Price of changing mass, in units of the cost.
const CHANGE: f64 = 10.0;
/// Parts of a plan below this share of its lobe's largest are left out.
const NEGLIGIBLE: f32 = 1e-4;

/// Transport between a distribution and the image of another in mirrors.
pub(crate) fn edge(first: usize, a: &[Lobe], second: usize, b: &[Lobe], mirror: u8) -> Edge {
    let b: Vec<Lobe> = b.iter().map(|l| Lobe { direction: mirrored(l.direction, mirror), ..*l }).collect();
    let plan = plan(a, &b);
    let (mut forward, mut backward) = (vec![(DVec3::ZERO, 0.0, 0.0); a.len()], vec![(DVec3::ZERO, 0.0, 0.0); b.len()]);
    let put = |sum: &mut (DVec3, f64, f64), to: &Lobe, share: f64| {
        *sum = (sum.0 + share * to.direction, sum.1 + share * to.radius * to.radius, sum.2 + share);
    };
    for &(i, j, share) in &plan {
        put(&mut forward[i as usize], &b[j as usize], f64::from(share));
        put(&mut backward[j as usize], &a[i as usize], f64::from(share));
    }
    let target = |(sum, own): (&(DVec3, f64, f64), &Lobe)| {
        if sum.2 > 0.0 {
            Target { direction: sum.0.normalize_or(own.direction), radius: (sum.1 / sum.2).sqrt() }
        } else {
            Target { direction: own.direction, radius: own.radius }
        }
    };
    let forward = forward.iter().zip(a).map(target).collect();
    let backward = backward.iter().zip(&b).map(target).collect();
    Edge { first, second, mirror, forward, backward, plan }
}

/// Logarithm of the density at each lobe, relative to the mean, no less than so far below the largest.
fn densities(lobes: &[Lobe]) -> Vec<f64> {
    let total: f64 = lobes.iter().map(|l| l.mass).sum::<f64>().max(1e-30);
    let amplitudes: Vec<f64> = lobes.iter().map(Lobe::amplitude).collect();
    let all: Vec<f64> = lobes
        .iter()
        .map(|at| {
            let sum: f64 = lobes
                .iter()
                .zip(&amplitudes)
                .map(|(l, a)| {
                    let exponent = (l.direction.dot(at.direction) - 1.0) / (l.radius * l.radius);
                    if exponent < -0.5 * CUT * CUT { 0.0 } else { a * exponent.exp() }
                })
                .sum();
            sum / total
        })
        .collect();
    let largest = all.iter().copied().fold(0.0, f64::max).max(1e-30);
    all.iter().map(|f| f.max(1e-7 * largest).ln()).collect()
}

/// The plan as (lobe of a, lobe of b, mass).
fn plan(a: &[Lobe], b: &[Lobe]) -> Vec<(u32, u32, f32)> {
    let (n, m) = (a.len(), b.len());
    if n == 0 || m == 0 {
        return Vec::new();
    }
    let (fa, fb) = (densities(a), densities(b));
    let cost = |i: usize, j: usize| {
        let moved = (a[i].direction - b[j].direction).length_squared() / (FAR * FAR);
        let brighter = fa[i] - fb[j];
        moved + brighter * brighter
    };
    let shares = |lobes: &[Lobe]| -> Vec<f64> {
        let total: f64 = lobes.iter().map(|l| l.mass).sum::<f64>().max(1e-30);
        lobes.iter().map(|l| (l.mass / total).max(1e-12)).collect()
    };
    let (pa, pb) = (shares(a), shares(b));
    let (mut f, mut g) = (vec![0.0f64; n], vec![0.0f64; m]);
    // Of each lobe of a, those of b that may receive from it: all at first.
    let arc = |i: usize, j: usize| Arc { to: j as u32, cost: cost(i, j) as f32, kernel: 0.0 };
    let mut rows: Vec<Vec<Arc>> = (0..n).map(|i| (0..m).map(|j| arc(i, j)).collect()).collect();
    let (mut u, mut v) = (vec![1.0f64; n], vec![1.0f64; m]);
    for epsilon in STEPS {
        for (i, row) in rows.iter_mut().enumerate() {
            for arc in row.iter_mut() {
                arc.kernel = ((f[i] + g[arc.to as usize] - f64::from(arc.cost)) / epsilon).min(80.0).exp() as f32;
            }
        }
        let rho = CHANGE / (CHANGE + epsilon);
        let (f0, g0) = (f.clone(), g.clone());
        u.fill(1.0);
        v.fill(1.0);
        let mut sums = vec![0.0f64; m];
        for _ in 0..ITERATIONS {
            for i in 0..n {
                let sum: f64 = rows[i].iter().map(|arc| f64::from(arc.kernel) * v[arc.to as usize]).sum();
                f[i] = rho * (epsilon * pa[i].ln() + f0[i] - epsilon * sum.max(1e-280).ln());
                u[i] = ((f[i] - f0[i]) / epsilon).clamp(-300.0, 300.0).exp();
            }
            sums.fill(0.0);
            for i in 0..n {
                for arc in &rows[i] {
                    sums[arc.to as usize] += f64::from(arc.kernel) * u[i];
                }
            }
            for j in 0..m {
                g[j] = rho * (epsilon * pb[j].ln() + g0[j] - epsilon * sums[j].max(1e-280).ln());
                v[j] = ((g[j] - g0[j]) / epsilon).clamp(-300.0, 300.0).exp();
            }
        }
        prune(&mut rows, &u, &v);
    }
    let mut plan = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        for arc in row {
            let mass = arc.mass(u[i], &v);
            if mass > 0.0 && mass.is_finite() {
                plan.push((i as u32, arc.to, mass));
            }
        }
    }
    plan
}

/// What may go from one lobe to another.
struct Arc {
    to: u32,
    cost: f32,
    kernel: f32,
}

impl Arc {
    fn mass(&self, u: f64, v: &[f64]) -> f32 {
        (f64::from(self.kernel) * u * v[self.to as usize]) as f32
    }
}

/// Leaves out what is negligible to both of its ends.
fn prune(rows: &mut [Vec<Arc>], u: &[f64], v: &[f64]) {
    let mut most = vec![0.0f32; v.len()];
    for (row, u) in rows.iter().zip(u) {
        row.iter().for_each(|arc| most[arc.to as usize] = most[arc.to as usize].max(arc.mass(*u, v)));
    }
    for (row, u) in rows.iter_mut().zip(u) {
        let row_most = row.iter().map(|arc| arc.mass(*u, v)).fold(0.0, f32::max);
        row.retain(|arc| {
            let mass = arc.mass(*u, v);
            mass >= NEGLIGIBLE * row_most || mass >= NEGLIGIBLE * most[arc.to as usize]
        });
    }
}
