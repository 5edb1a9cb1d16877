//! A first look at windows on the host: how the light that meets them and what the room sees of them vary over them
//! together.
//!
//! Rays from points of a window along its bins find the mean sky of the year, or what surfaces send on of it: D·S of the
//! cells of a fine grid. Points of the window as sensors see them, directly and by a few reflections in the room, give V of
//! the same cells. From both follows a year's light with every division into cells taken together, and so what the
//! division leaves of the error. V and D have random numbers of their own, so that what is found is right on average; and
//! all is done twice, so that the product of two errors, which noise does not make larger on average, tells the square.

mod opening;
#[cfg(test)]
pub(super) mod truth;

use self::opening::Opening;
use crate::bins::ReinhartSky;
use crate::bvh::Caster;
use crate::progress::Silent;
use crate::random::Random;
use crate::scene::points::Sensor;
use crate::scene::{MaterialKind, Scene, Window};
use crate::simulate::inputs::Inputs;
use crate::simulate::project::Project;
use crate::sky::{SkyOptions, sky_matrix};
use crate::units::ILLUMINANCE_WEIGHTS;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Parts of a window that `"auto"` may come to.
pub(super) const MOST_OF_AUTO: usize = 64;
/// Cells along each side of a window where there are at most so many windows; more get no look.
const CELLS: [(usize, usize); 3] = [(8, 32), (64, 16), (512, 8)];
/// Rays of D per bin and cell.
const RAYS: usize = 3;
/// Receivers, at most: sensors and eyes.
const RECEIVERS: usize = 192;
/// Paths from a receiver into the room, their reflections, and points of each window that each end is connected to.
const PATHS: usize = 16;
const REFLECTIONS: usize = 3;
const POINTS: usize = 16;
/// Reflections outside.
const OUTSIDE: usize = 4;
/// Light below which errors count in relation to it, lx.
const DARK: f64 = 0.1;

/// What a look found.
pub(super) struct Look {
    /// A year's light at each receiver, lx.
    light: Vec<f64>,
    windows: Vec<OfWindow>,
}

struct OfWindow {
    cells: usize,
    /// Divisions into cells taken together.
    grids: Vec<[usize; 2]>,
    /// Of each division, the error of each receiver's light, lx, not negative.
    errors: Vec<Vec<f64>>,
}

/// Divisions of a window into powers of two along each side, and the cells themselves, twice as fine, last. Were it not
/// finer than the divisions, it would take those for right that are as fine along one side.
fn grids(cells: usize) -> Vec<[usize; 2]> {
    let sides: Vec<usize> = (0..cells.ilog2()).map(|i| 1 << i).collect();
    let all = sides.iter().flat_map(|&columns| sides.iter().map(move |&rows| [columns, rows]));
    all.filter(|[columns, rows]| columns * rows <= MOST_OF_AUTO).chain([[cells; 2]]).collect()
}

impl Look {
    /// Nothing if there is nobody to see a window, or there are too many windows.
    pub fn new(project: &Project, inputs: &Inputs) -> Option<Self> {
        let &(_, cells) = CELLS.iter().find(|(most, _)| inputs.windows.len() <= *most)?;
        let receivers = receivers(project, inputs);
        let surroundings = Surroundings::new(project, inputs)?;
        if receivers.is_empty() {
            return None;
        }
        let finest = grids(cells).len() - 1;
        let look = |time: u64| -> Vec<Vec<Vec<f64>>> {
            let behind: Vec<LightBehindWindow> =
                (0..inputs.windows.len()).map(|w| LightBehindWindow::new(&surroundings, inputs, (w, time), cells)).collect();
            receivers.par_iter().enumerate().map(|(i, sensor)| surroundings.light(sensor, 2 * i as u64 + time, &behind)).collect()
        };
        let seen = [look(0), look(1)];
        let of_finest = |s: &Vec<Vec<f64>>| s.iter().map(|of_grids| of_grids[finest]).sum::<f64>();
        let light = seen[0].iter().zip(&seen[1]).map(|(a, b)| (of_finest(a) + of_finest(b)) / 2.0).collect();
        let error = |s: &Vec<Vec<f64>>, w: usize, g: usize| s[w][g] - s[w][finest];
        let both = |w: usize, g: usize| {
            let of = |(a, b)| (error(a, w, g) * error(b, w, g)).max(0.0).sqrt();
            seen[0].iter().zip(&seen[1]).map(of).collect()
        };
        let of_window = |w: usize| OfWindow { cells, grids: grids(cells), errors: (0..=finest).map(|g| both(w, g)).collect() };
        Some(Self { light, windows: (0..inputs.windows.len()).map(of_window).collect() })
    }

    /// How many sensors and eyes were asked.
    pub fn receivers(&self) -> usize {
        self.light.len()
    }

    /// Most parts of a window that a look tells of.
    pub fn finest(&self, window: usize) -> usize {
        (self.windows[window].cells / 2).pow(2)
    }

    /// Relative error of a receiver's light by one window's division into columns and rows, powers of two.
    pub fn error(&self, window: usize, grid: [usize; 2], receiver: usize) -> f64 {
        let w = &self.windows[window];
        let found = w.grids.iter().position(|g| *g == grid).map_or(0.0, |g| w.errors[g][receiver]);
        found / self.light[receiver].max(DARK)
    }

    /// The largest of all receivers.
    pub fn worst(&self, window: usize, grid: [usize; 2]) -> f64 {
        (0..self.receivers()).map(|r| self.error(window, grid, r)).fold(0.0, f64::max)
    }

    /// The division into so many parts, a power of two, that leaves least: of all receivers together, which chance
    /// decides less than the worst alone.
    pub fn best_grid(&self, window: usize, count: usize) -> [usize; 2] {
        let of_count = self.windows[window].grids.iter().copied().filter(|[c, r]| c * r == count);
        let all = |grid: [usize; 2]| (0..self.receivers()).map(|r| self.error(window, grid, r).powi(2)).sum::<f64>();
        of_count.min_by(|a, b| all(*a).total_cmp(&all(*b))).unwrap_or([1, 1])
    }
}

/// Sensors that V serves, and eyes: some of all if there are many.
fn receivers(project: &Project, inputs: &Inputs) -> Vec<Sensor> {
    let mut all = if inputs.choice(project).direct { Vec::new() } else { inputs.all_sensors() };
    // A view without a direction has no eye.
    all.extend(project.views.iter().filter_map(|v| v.eye().ok()));
    let step = all.len().div_ceil(RECEIVERS).max(1);
    all.into_iter().step_by(step).collect()
}

/// Surfaces, windows, and the year's mean sky.
struct Surroundings {
    solid: Option<Caster>,
    kinds: Vec<MaterialKind>,
    fronts: Vec<DVec3>,
    windows: Caster,
    openings: Vec<Opening>,
    sky: ReinhartSky,
    /// Luminance of each patch, cd/m².
    luminance: Vec<f64>,
}

/// Evenly spread numbers of four dimensions (Roberts' R sequence), shifted at random.
fn spread(index: usize, shift: &[f64; 4]) -> [f64; 4] {
    const STEP: f64 = 1.167_303_978_261_418_7;
    std::array::from_fn(|k| (shift[k] + (index + 1) as f64 / STEP.powi(k as i32 + 1)).fract())
}

fn shift(seed: u64) -> [f64; 4] {
    let mut random = Random(seed);
    std::array::from_fn(|_| random.next())
}

fn mean(color: [f64; 3]) -> f64 {
    color.iter().sum::<f64>() / 3.0
}

impl Surroundings {
    fn new(project: &Project, inputs: &Inputs) -> Option<Self> {
        let scene: &Scene = &inputs.scene;
        let kind = |t: &crate::scene::Triangle| scene.materials[t.material.0 as usize].kind;
        // Light passes panes.
        let solid: Vec<_> =
            scene.triangles.iter().filter(|t| !matches!(kind(t), MaterialKind::Void | MaterialKind::Glass { .. })).collect();
        let ground_reflectance = [project.weather.ground_albedo; 3];
        // Of five phases the sun's direct light is not V's and D's.
        let sun = inputs.choice(project).phases != 5;
        // A sky made elsewhere has its own division.
        let subdivision = if inputs.weather.given.is_some() { inputs.sky(project).subdivision() } else { 1 };
        let options = SkyOptions { subdivision, sun, ground_reflectance, ..SkyOptions::default() };
        let sky = sky_matrix(&inputs.weather, &options, &Silent).ok()?;
        let of_row = |row: &[f32]| -> f64 {
            row.chunks_exact(3).flat_map(|v| v.iter().zip(ILLUMINANCE_WEIGHTS)).map(|(v, w)| f64::from(*v) * w).sum()
        };
        let luminance = |p: usize| of_row(sky.row(p)) / sky.cols().max(1) as f64;
        Some(Self {
            kinds: solid.iter().map(|t| kind(t)).collect(),
            fronts: solid.iter().map(|t| t.normal()).collect(),
            solid: Caster::new(solid.iter().map(|t| t.vertices).collect()),
            windows: Caster::new(inputs.windows.iter().flat_map(|w| w.window.triangles.clone()).collect())?,
            openings: inputs.windows.iter().map(|w| Opening::new(&w.window)).collect(),
            luminance: (0..sky.rows()).map(luminance).collect(),
            sky: ReinhartSky::from_bins(sky.rows())?,
        })
    }

    fn met(&self, origin: DVec3, direction: DVec3, least: f64) -> Option<(f64, usize)> {
        self.solid.as_ref().and_then(|s| s.nearest(origin, direction, least))
    }

    /// What a surface sends on of light that a path meets it with: the share of it, and where to.
    fn sent_on(&self, number: usize, direction: DVec3, random: &mut Random) -> Option<(f64, DVec3)> {
        let front = self.fronts[number];
        let facing = if direction.dot(front) < 0.0 { front } else { -front };
        let mirrored = direction - 2.0 * direction.dot(facing) * facing;
        if let MaterialKind::Mirror { color } = self.kinds[number] {
            return (direction.dot(front) < 0.0).then_some((mean(color), mirrored));
        }
        let lobes = self.kinds[number].lobes()?;
        let shares = [lobes.diffuse, lobes.diffuse_transmitted, lobes.specular, lobes.specular_transmitted].map(mean);
        let all: f64 = shares.iter().sum();
        let mut pick = random.next() * all;
        let chosen = shares.iter().position(|s| {
            pick -= s;
            pick < 0.0
        })?;
        let next = match chosen {
            0 => random.cosine_direction(facing),
            1 => random.cosine_direction(-facing),
            2 => mirrored,
            _ => direction,
        };
        Some((all, next))
    }

    /// Luminance that comes to a point before the windows from a direction; windows send nothing.
    fn luminance_outside(&self, mut origin: DVec3, mut direction: DVec3, reflections: usize, random: &mut Random) -> f64 {
        let mut weight = 1.0;
        for _ in 0..=reflections {
            let met = self.met(origin, direction, 1e-6);
            if self.windows.nearest(origin, direction, 1e-5).is_some_and(|(d, _)| met.is_none_or(|(met, _)| d < met)) {
                return 0.0;
            }
            let Some((distance, number)) = met else { return weight * self.luminance[self.sky.bin_of(direction)] };
            let Some((share, next)) = self.sent_on(number, direction, random) else { return 0.0 };
            weight *= share;
            origin += distance * direction;
            direction = next;
        }
        0.0
    }

    /// Light at a receiver from each window with each of its divisions, lx.
    fn light(&self, sensor: &Sensor, seed: u64, behind: &[LightBehindWindow]) -> Vec<Vec<f64>> {
        let mut sums: Vec<Vec<f64>> = behind.iter().map(|b| vec![0.0; b.light.len()]).collect();
        let mut random = Random(seed ^ 0x7061_7274);
        let normal = sensor.direction.normalize_or(DVec3::Z);
        self.connect(sensor.position, normal, 1.0, None, &mut random, behind, &mut sums);
        for _ in 0..PATHS {
            let (mut origin, mut direction) = (sensor.position, random.cosine_direction(normal));
            let mut weight = 1.0 / PATHS as f64;
            for _ in 0..REFLECTIONS {
                let Some((distance, number)) = self.met(origin, direction, 1e-6) else { break };
                if self.windows.nearest(origin, direction, 1e-6).is_some_and(|(d, _)| d < distance) {
                    break;
                }
                let Some((share, next)) = self.sent_on(number, direction, &mut random) else { break };
                let front = self.fronts[number];
                let side = if next.dot(front) < 0.0 { -front } else { front };
                weight *= share;
                origin += distance * direction;
                direction = next;
                self.connect(origin, side, weight, Some(POINTS), &mut random, behind, &mut sums);
            }
        }
        sums
    }

    /// Adds the light of all windows at a surface, or a receiver, times a weight. Few points of each window are asked, or
    /// half as many as it has cells.
    #[allow(clippy::too_many_arguments, reason = "each is a different thing")]
    fn connect(
        &self,
        origin: DVec3,
        normal: DVec3,
        weight: f64,
        points: Option<usize>,
        random: &mut Random,
        behind: &[LightBehindWindow],
        sums: &mut [Vec<f64>],
    ) {
        for ((opening, behind), sums) in self.openings.iter().zip(behind).zip(sums) {
            let count = points.unwrap_or(behind.cells * behind.cells / 2);
            let shift: [f64; 4] = std::array::from_fn(|_| random.next());
            // Nearer than points are apart a single one would stand for more than the whole hemisphere.
            let nearest = opening.area / count as f64;
            for i in 0..count {
                let [u, v, ..] = spread(i, &shift);
                let point = opening.point(u, v);
                let to = point - origin;
                let distance = to.length();
                let direction = to / distance;
                let (cosine, leaving) = (direction.dot(normal), -direction.dot(opening.window.frame.z));
                if !(cosine > 0.0 && leaving > 0.0) || self.met(origin, direction, 1e-6).is_some_and(|(d, _)| d < distance * (1.0 - 1e-6)) {
                    continue;
                }
                let value = weight * cosine * leaving * nearest / (distance * distance).max(nearest / 2.0);
                behind.add(&opening.window, point, -direction, value, sums);
            }
        }
    }
}

/// Light behind a window: luminance in the directions of its bins.
struct LightBehindWindow {
    cells: usize,
    low: DVec2,
    size: DVec2,
    grids: Vec<[usize; 2]>,
    /// Of each division, `[part][bin]`.
    light: Vec<Vec<f64>>,
    bins: usize,
}

impl LightBehindWindow {
    /// `time`: which of several looks it is for.
    fn new(surroundings: &Surroundings, inputs: &Inputs, (number, time): (usize, u64), cells: usize) -> Self {
        let opening = &surroundings.openings[number];
        let window = &opening.window;
        let [low, high] = window.extent();
        let bins = window.basis.len();
        let start = window.frame.z * (-1e-5 * opening.area.sqrt());
        let mut behind = Self { cells, low, size: (high - low).max(DVec2::splat(1e-12)), grids: grids(cells), light: Vec::new(), bins };
        // Sums of luminance and numbers of rays of a bin's cells.
        let of_bin = |bin: usize| {
            let seed = 2 * (number * bins + bin) as u64 + time;
            let (shift, mut random) = (shift(seed), Random(seed ^ 0x6461_796c));
            let mut found = vec![(0.0, 0.0); cells * cells];
            for i in 0..RAYS * cells * cells {
                let [u, v, a, b] = spread(i, &shift);
                let point = opening.point(u, v);
                let direction = -window.frame.to_world(window.basis.direction(bin, a, b));
                let (sum, rays) = &mut found[behind.cell(window, point)];
                *sum += surroundings.luminance_outside(point + start, direction, OUTSIDE, &mut random);
                *rays += 1.0;
            }
            found
        };
        let before: Vec<Vec<(f64, f64)>> = (0..bins).into_par_iter().map(of_bin).collect();
        let t = &inputs.windows[number].transmission;
        let weights: f64 = ILLUMINANCE_WEIGHTS.iter().sum();
        let grey = |v: &[f64]| v.iter().zip(ILLUMINANCE_WEIGHTS).map(|(v, w)| v * w).sum::<f64>() / weights;
        let passed: Vec<f64> = (0..bins * bins).map(|k| grey(t.at(k / bins, k % bins))).collect();
        let all: Vec<(f64, f64)> = before.iter().map(|b| b.iter().fold((0.0, 0.0), |a, c| (a.0 + c.0, a.1 + c.1))).collect();
        behind.light = behind
            .grids
            .par_iter()
            .map(|grid| {
                let parts = grid[0] * grid[1];
                let mut light = vec![0.0; parts * bins];
                let mut sums = vec![vec![(0.0, 0.0); bins]; parts];
                for (bin, of_cells) in before.iter().enumerate() {
                    for (cell, (sum, rays)) in of_cells.iter().enumerate() {
                        let to = &mut sums[behind.part(cell, *grid)][bin];
                        *to = (to.0 + sum, to.1 + rays);
                    }
                }
                for (part, incident) in sums.iter().enumerate() {
                    // A cell without a ray takes what the window has.
                    let mean: Vec<f64> =
                        incident.iter().zip(&all).map(|(own, all)| if own.1 > 0.0 { own.0 / own.1 } else { all.0 / all.1 }).collect();
                    for out in 0..bins {
                        light[part * bins + out] = passed[out * bins..(out + 1) * bins].iter().zip(&mean).map(|(t, l)| t * l).sum();
                    }
                }
                light
            })
            .collect();
        behind
    }

    /// The cell of a point, row by row from below.
    fn cell(&self, window: &Window, point: DVec3) -> usize {
        let at = (DVec2::new(point.dot(window.frame.x), point.dot(window.frame.y)) - self.low) / self.size * self.cells as f64;
        let [x, y] = [at.x, at.y].map(|v| (v.max(0.0) as usize).min(self.cells - 1));
        y * self.cells + x
    }

    /// The part of a division that a cell belongs to.
    fn part(&self, cell: usize, [columns, rows]: [usize; 2]) -> usize {
        let (x, y) = (cell % self.cells, cell / self.cells);
        y * rows / self.cells * columns + x * columns / self.cells
    }

    /// Adds the light from a point along a direction into the room, of each division, times a value.
    fn add(&self, window: &Window, point: DVec3, direction: DVec3, value: f64, sums: &mut [f64]) {
        let bin = window.basis.bin_of(window.frame.to_local(direction));
        let cell = self.cell(window, point);
        for ((sum, grid), light) in sums.iter_mut().zip(&self.grids).zip(&self.light) {
            *sum += value * light[self.part(cell, *grid) * self.bins + bin];
        }
    }
}
