//! Suns through the scene's geometry: openings, panes of glass, slats.
//!
//! Rays are traced only where the sun is seen through a window's polygon (if any is given), so most
//! pairs of receiver and sun cost nothing. Light that slats scatter is found by paths from the
//! receiver out through the windows; each vertex sends one ray to every sun (next-event
//! estimation), so that the paths serve all suns; or by points that [receivers share](ScatteredBy). Flat mirror-like surfaces show [images](super::mirrors)
//! of the sun, which are traced as suns are.

use super::Sun;
use super::shades::Shades;
pub(crate) use super::tracer::SunTracer;
use crate::error::{Error, Result};
use crate::gpu::{DEFAULT_MEMORY, Device};
use crate::gpu_struct;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{Normalization, ROULETTE_WEIGHT, TraceStatistics};
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::scene::points::Sensor;
use crate::scene::{Scene, Window};
use glam::{DVec3, Vec3};

gpu_struct! {
    /// The room that a shade takes up, in front of and behind its window, as a box.
    pub(crate) struct Gate {
        /// Axes of the window's frame; z points into the room.
        x: [f32; 3],
        padding0: u32,
        y: [f32; 3],
        padding1: u32,
        z: [f32; 3],
        padding2: u32,
        /// Limits along the axes.
        low: [f32; 3],
        padding3: u32,
        high: [f32; 3],
        padding4: u32,
    }
}

/// Slots of a path without a limit on reflections: after as many, slats of reflectance 0.5 have
/// lost all but 2⁻¹⁶ of the light.
const MOST_VERTICES: u32 = 16;

/// How light is found that surfaces scatter. All ways give the same but for noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScatteredBy {
    /// By points on the surfaces that receivers share, where these tell more than paths of their own in no
    /// more time; else by paths.
    Automatic,
    /// By paths from every receiver.
    Paths,
    /// By points wherever they can stand for everything: where nothing scatters in preferred directions,
    /// and at receivers that are not next to the surfaces.
    Points,
}

/// How much to sample. Every number is per receiver *and batch*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunOptions {
    /// Points of a sun's disc.
    pub disc_samples: u32,
    /// Paths to scattering surfaces that a sun is seen from.
    pub paths: u32,
    /// Sets of so many paths, or of the points in their place. Suns take turns in using them (`number % path_sets`): paths cost little
    /// beside the rays from their vertices to the suns, and errors of a year of suns even out.
    pub path_sets: u32,
    /// Most diffuse (or rough) reflections of sunlight: 0 is straight light only, Radiance's `-ab`;
    /// `None` is 16.
    pub bounces: Option<u32>,
    /// How scattered light is found.
    pub scattered_by: ScatteredBy,
    /// Independent repetitions; their spread gives the standard error. At least 2.
    pub batches: u32,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Share of its first weight below which Russian roulette ends a path.
    pub roulette_weight: f32,
    /// Device memory to use, bytes.
    pub memory: u64,
}

impl Default for SunOptions {
    fn default() -> Self {
        Self {
            disc_samples: 16,
            paths: 32,
            path_sets: 4,
            bounces: None,
            scattered_by: ScatteredBy::Automatic,
            batches: 4,
            seed: 1,
            roulette_weight: ROULETTE_WEIGHT,
            memory: DEFAULT_MEMORY,
        }
    }
}

impl SunOptions {
    /// Straight light only.
    #[must_use]
    pub fn direct(self) -> Self {
        Self { bounces: Some(0), ..self }
    }

    /// As many samples in batches of no more than so many points of a disc.
    #[must_use]
    pub(super) fn in_batches_of(self, points: u32) -> Self {
        let times = self.disc_samples.div_ceil(points).max(1);
        Self {
            disc_samples: self.disc_samples.div_ceil(times),
            paths: self.paths.div_ceil(times),
            batches: self.batches.saturating_mul(times),
            ..self
        }
    }

    /// The set of paths that the sun of this number uses.
    pub fn path_set(&self, sun: usize) -> usize {
        sun % self.path_sets as usize
    }

    pub(super) fn most_vertices(&self) -> u32 {
        self.bounces.unwrap_or(MOST_VERTICES).min(MOST_VERTICES)
    }

    /// Whether anything beyond straight light is asked for.
    pub(super) fn scatters(&self) -> bool {
        self.most_vertices() > 0 && self.paths > 0
    }
}

/// Where sunlight comes in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Openings<'a> {
    /// Wherever the scene leaves it in.
    Anywhere,
    /// Through the polygons of these windows, which are holes for light that comes into their room. They, and
    /// all other windows of the scene, absorb what comes to them from elsewhere.
    Windows(&'a [Window]),
    /// Through the boxes around these windows and the shades before and behind them (corners of their
    /// geometry): slats may let light pass beside the window's own polygon.
    Shaded(&'a [(Window, Vec<DVec3>)]),
}

impl Openings<'_> {
    pub(super) fn windows(&self) -> Vec<Window> {
        match self {
            Self::Anywhere => Vec::new(),
            Self::Windows(windows) => windows.to_vec(),
            Self::Shaded(shaded) => shaded.iter().map(|(w, _)| w.clone()).collect(),
        }
    }

    pub(super) fn gates(&self, normalization: &Normalization) -> Vec<Gate> {
        let Self::Shaded(shaded) = self else { return Vec::new() };
        let gate = |(window, corners): &(Window, Vec<DVec3>)| {
            let frame = &window.frame;
            // Rounding must not shut out what grazes the box.
            const MARGIN: f32 = 1e-4;
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for corner in window.triangles.iter().flatten().chain(corners) {
                let p = (*corner - normalization.origin) * normalization.scale;
                let local = Vec3::new(p.dot(frame.x) as f32, p.dot(frame.y) as f32, p.dot(frame.z) as f32);
                (low, high) = (low.min(local), high.max(local));
            }
            Gate {
                x: frame.x.as_vec3().to_array(),
                y: frame.y.as_vec3().to_array(),
                z: frame.z.as_vec3().to_array(),
                low: (low - MARGIN).to_array(),
                high: (high + MARGIN).to_array(),
                ..Gate::default()
            }
        };
        shaded.iter().map(gate).collect()
    }
}

/// Sun matrix of some receivers. All matrices are `[receiver][sun]`, RGB, sr.
#[derive(Debug, Clone, PartialEq)]
pub struct SunMatrix {
    /// Straight from the sun, or by way of flat mirrors.
    pub direct: Matrix<f32>,
    /// Straight and scattered.
    pub total: Matrix<f32>,
    /// Standard error of `direct`; independent from sun to sun.
    pub direct_error: Matrix<f32>,
    /// Standard error of the scattered part; suns of one [set](SunOptions::path_set) share paths or points, so
    /// their errors at one receiver go together, and with points those of neighbouring receivers too.
    pub scattered_error: Matrix<f32>,
    /// Work done.
    pub statistics: TraceStatistics,
}

impl SunMatrix {
    /// No light at all.
    pub fn zeros(receivers: usize, suns: usize) -> Self {
        let shape = || Matrix::zeros(receivers, suns, 3);
        let statistics = TraceStatistics::default();
        Self { direct: shape(), total: shape(), direct_error: shape(), scattered_error: shape(), statistics }
    }

    /// Adds independent light of the same receivers and suns, scattered: one error for all suns.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn add(&mut self, total: &Matrix<f32>, error: &Matrix<f32>, statistics: TraceStatistics) {
        assert_eq!((self.total.rows(), self.total.cols()), (total.rows(), total.cols()), "the same receivers and suns");
        self.total.data_mut().iter_mut().zip(total.data()).for_each(|(sum, v)| *sum += v);
        self.scattered_error.data_mut().iter_mut().zip(error.data()).for_each(|(sum, e)| *sum = sum.hypot(*e));
        self.statistics.paths += statistics.paths;
        self.statistics.segments += statistics.segments;
    }

    /// Standard error of `total`.
    pub fn standard_error(&self) -> Matrix<f32> {
        let data = self.direct_error.data().iter().zip(self.scattered_error.data()).map(|(a, b)| a.hypot(*b)).collect();
        Matrix::from_data(self.total.rows(), self.total.cols(), 3, data).expect("the same shape")
    }
}

/// Computes the sun matrix of `sensors`. The windows are holes to their rooms: what fills them (panes, slats) is
/// part of the scene.
///
/// # Errors
/// Sensors without direction, suns that are no discs, options without sense, failures of the device,
/// or when stopped by `progress`.
pub fn compute(
    device: &Device,
    scene: &Scene,
    openings: Openings<'_>,
    sensors: &[Sensor],
    suns: &[Sun],
    options: &SunOptions,
    progress: &dyn Progress,
) -> Result<SunMatrix> {
    for (i, sensor) in sensors.iter().enumerate() {
        if !sensor.position.is_finite() || !sensor.direction.is_finite() || sensor.direction.length() < 1e-12 {
            return Err(Error::new(format!("sensor {} has no usable position and direction", i + 1))
                .help("each line of a points file needs x y z dx dy dz, the direction not zero"));
        }
    }
    let around: Vec<DVec3> = sensors.iter().map(|s| s.position).collect();
    let tracer = SunTracer::new(device, scene, openings, &around, suns, options)?;
    let shape = || Matrix::<f32>::zeros(sensors.len(), suns.len(), 3);
    let mut result = SunMatrix {
        direct: shape(),
        total: shape(),
        direct_error: shape(),
        scattered_error: shape(),
        statistics: TraceStatistics::default(),
    };
    if sensors.is_empty() || suns.is_empty() {
        return Ok(result);
    }
    let receivers: Vec<Receiver> = sensors.iter().enumerate().map(|(i, s)| tracer.receiver(s, i)).collect();
    let shades = Shades::choose(&tracer, &receivers)?;
    let shares = |i: &usize| shades.as_ref().is_some_and(|(_, suited)| suited[*i]);
    let (shared, own): (Vec<usize>, Vec<usize>) = (0..sensors.len()).partition(shares);
    let mut done = 0;
    for (rows, scatters) in [(&shared, false), (&own, options.scatters())] {
        for chunk in tracer.plan(rows.len())?.chunks() {
            progress.update("sun matrix", done as f64 / sensors.len() as f64);
            if progress.stop_requested() {
                return Err(cancelled());
            }
            let rows = &rows[chunk.first..][..chunk.count];
            let records: Vec<Receiver> = rows.iter().map(|i| receivers[*i]).collect();
            let buffer = device.upload("receivers of suns", &records)?;
            let sums = tracer.trace_parts(&buffer, chunk.count, 0, scatters, &mut result.statistics)?;
            tracer.reduce(&sums, rows, &mut result);
            done += chunk.count;
        }
    }
    if let Some((shades, _)) = &shades {
        let records: Vec<Receiver> = shared.iter().map(|i| receivers[*i]).collect();
        let [mean, error] = shades.light(&records, progress, &mut result.statistics)?;
        for (row, &i) in shared.iter().enumerate() {
            let cells = i * suns.len() * 3..(i + 1) * suns.len() * 3;
            result.total.data_mut()[cells.clone()].iter_mut().zip(mean.row(row)).for_each(|(sum, v)| *sum += v);
            result.scattered_error.data_mut()[cells].copy_from_slice(error.row(row));
        }
    }
    progress.update("sun matrix", 1.0);
    Ok(result)
}
