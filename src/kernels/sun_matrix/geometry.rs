//! Suns through the scene's geometry: openings, panes of glass, slats.
//!
//! Rays are traced only where the sun is seen through a window's polygon (if any is given), so most
//! pairs of receiver and sun cost nothing. Light that slats scatter is found by paths from the
//! receiver out through the windows; each vertex sends one ray to every sun (next-event
//! estimation), so that the paths serve all suns. Mirror-like reflections of the sun are not in it,
//! as they are not in Radiance's direct calculation.

use super::Sun;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device, Kernel, Plan};
use crate::gpu_struct;
use crate::kernels::light_paths::{Receiver, finish_dispatch};
use crate::kernels::trace::{Counters, Normalization, TraceScene, TraceStatistics, TraceTables, WindowSurfaces, stream_seed};
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::scene::points::Sensor;
use crate::scene::{Scene, Window};
use glam::{DVec3, Vec3};

gpu_struct! {
    /// A sun (`shared/sun.wgsl`).
    pub(crate) struct SunRecord {
        direction: [f32; 3],
        chord: f32,
        solid_angle: f32,
        number: u32,
        padding0: u32,
        padding1: u32,
    }
}

gpu_struct! {
    /// Parameters of `trace/sun_vertices`.
    pub(crate) struct SunPathParams {
        seed: u32,
        receivers: u32,
        paths: u32,
        batches: u32,
        window_count: u32,
        most_vertices: u32,
        roulette_weight: f32,
        batch_stride: u32,
        path_sets: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

gpu_struct! {
    /// Parameters of `trace/sun_gather`.
    pub(crate) struct SunGatherParams {
        seed: u32,
        receivers: u32,
        suns: u32,
        batches: u32,
        window_count: u32,
        disc_samples: u32,
        paths: u32,
        most_vertices: u32,
        batch_stride: u32,
        gates: u32,
        path_sets: u32,
        padding0: u32,
    }
}

gpu_struct! {
    /// A box that light must pass (`shared/sun.wgsl`).
    pub(crate) struct Gate {
        x: [f32; 3],
        padding0: u32,
        y: [f32; 3],
        padding1: u32,
        z: [f32; 3],
        padding2: u32,
        low: [f32; 3],
        padding3: u32,
        high: [f32; 3],
        padding4: u32,
    }
}

gpu_struct! {
    /// Where a path meets a surface that scatters (`shared/receiver.wgsl`).
    pub(crate) struct SunVertex {
        position: [f32; 3],
        material: u32,
        facing: [f32; 3],
        thickness: f32,
        incoming: [f32; 3],
        padding0: u32,
        throughput: [f32; 3],
        padding1: u32,
    }
}

/// Slots of a path without a limit on reflections: after as many, slats of reflectance 0.5 have
/// lost all but 2⁻¹⁶ of the light.
const MOST_VERTICES: u32 = 16;
/// Pairs of receiver and sun, over all batches, of one dispatch: bounds its time.
const MOST_PAIRS: usize = 1 << 20;

/// How much to sample. Every number is per receiver *and batch*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunOptions {
    /// Points of a sun's disc.
    pub disc_samples: u32,
    /// Paths to scattering surfaces that a sun is seen from.
    pub paths: u32,
    /// Sets of so many paths. Suns take turns in using them (`number % path_sets`): paths cost little
    /// beside the rays from their vertices to the suns, and errors of a year of suns even out.
    pub path_sets: u32,
    /// Most diffuse (or rough) reflections of sunlight: 0 is straight light only, Radiance's `-ab`;
    /// `None` is 16.
    pub bounces: Option<u32>,
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
        Self { disc_samples: 16, paths: 32, path_sets: 4, bounces: None, batches: 4, seed: 1, roulette_weight: 0.05, memory: 1 << 30 }
    }
}

impl SunOptions {
    /// Straight light only.
    #[must_use]
    pub fn direct(self) -> Self {
        Self { bounces: Some(0), ..self }
    }

    /// The set of paths that the sun of this number uses.
    pub fn path_set(&self, sun: usize) -> usize {
        sun % self.path_sets as usize
    }

    fn most_vertices(&self) -> u32 {
        self.bounces.unwrap_or(MOST_VERTICES).min(MOST_VERTICES)
    }

    /// Whether anything beyond straight light is asked for.
    fn scatters(&self) -> bool {
        self.most_vertices() > 0 && self.paths > 0
    }
}

/// Where sunlight comes in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Openings<'a> {
    /// Wherever the scene leaves it in.
    Anywhere,
    /// Through the polygons of these windows, which are holes.
    Windows(&'a [Window]),
    /// Through the boxes around these windows and the shades before and behind them (corners of their
    /// geometry): slats may let light pass beside the window's own polygon.
    Shaded(&'a [(Window, Vec<DVec3>)]),
}

impl Openings<'_> {
    fn windows(&self) -> Vec<Window> {
        match self {
            Self::Anywhere => Vec::new(),
            Self::Windows(windows) => windows.to_vec(),
            Self::Shaded(shaded) => shaded.iter().map(|(w, _)| w.clone()).collect(),
        }
    }

    fn gates(&self, normalization: &Normalization) -> Vec<Gate> {
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
    /// Straight from the sun.
    pub direct: Matrix<f32>,
    /// Straight and scattered.
    pub total: Matrix<f32>,
    /// Standard error of `direct`; independent from sun to sun.
    pub direct_error: Matrix<f32>,
    /// Standard error of the scattered part; suns of one [set](SunOptions::path_set) share paths, so
    /// their errors at one receiver go together.
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

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<crate::gpu::Registered> {
    use crate::gpu::Registered;
    vec![
        Registered::new("trace/sun_vertices").with::<SunPathParams>().with::<SunVertex>().with::<Receiver>(),
        Registered::new("trace/sun_gather")
            .with::<SunGatherParams>()
            .with::<SunVertex>()
            .with::<SunRecord>()
            .with::<Gate>()
            .with::<Receiver>(),
    ]
}

/// Computes the sun matrix of `sensors`. The windows are holes: what fills them (panes, slats) is
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
    let mut done = 0;
    for chunk in tracer.plan(sensors.len())?.chunks() {
        progress.update("sun matrix", done as f64 / sensors.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let records: Vec<Receiver> = (chunk.first..chunk.first + chunk.count).map(|i| tracer.receiver(&sensors[i], i)).collect();
        let buffer = device.upload("receivers of suns", &records)?;
        let sums = tracer.trace(&buffer, chunk.count, 0, &mut result.statistics)?;
        tracer.reduce(&sums, chunk.first, chunk.count, &mut result);
        done += chunk.count;
    }
    progress.update("sun matrix", 1.0);
    Ok(result)
}

/// A scene and its suns on the device.
pub(crate) struct SunTracer<'d> {
    device: &'d Device,
    tables: TraceTables,
    scene: TraceScene,
    options: SunOptions,
    window_count: u32,
    gate_count: u32,
    gates: Buffer,
    sun_count: usize,
    suns: Buffer,
    panes: bool,
    vertices: Kernel,
    gather: Kernel,
    counters: Buffer,
}

impl<'d> SunTracer<'d> {
    /// `around` are points near which the tracer must be exact where there are no windows.
    pub fn new(
        device: &'d Device,
        scene: &Scene,
        openings: Openings<'_>,
        around: &[DVec3],
        suns: &[Sun],
        options: &SunOptions,
    ) -> Result<Self> {
        if options.batches < 2 || options.disc_samples == 0 || options.path_sets == 0 {
            return Err(Error::new("a sun matrix needs at least two batches, one point of the sun's disc and one set of paths"));
        }
        if let Some((i, sun)) = suns.iter().enumerate().find(|(_, s)| {
            !s.direction.is_finite()
                || (s.direction.length() - 1.0).abs() > 1e-6
                || !(0.0..=std::f64::consts::FRAC_PI_4).contains(&s.radius)
        }) {
            return Err(Error::new(format!("sun {} is no disc in the sky: direction {}, radius {}", i + 1, sun.direction, sun.radius))
                .help("a sun needs a direction and a radius of at most 45°"));
        }
        let windows = openings.windows();
        let tables = match openings {
            Openings::Anywhere => TraceTables::without_windows(scene, around),
            _ => TraceTables::new(scene, &windows, WindowSurfaces::Open)?,
        };
        let gates = openings.gates(&tables.normalization);
        let panes = tables.features.glass || tables.features.specular;
        let records: Vec<SunRecord> = suns
            .iter()
            .enumerate()
            .map(|(i, s)| SunRecord {
                direction: s.direction.as_vec3().normalize().to_array(),
                chord: s.chord() as f32,
                solid_angle: s.solid_angle() as f32,
                number: i as u32,
                padding0: 0,
                padding1: 0,
            })
            .collect();
        let (none, no_gate) = ([SunRecord::default()], [Gate::default()]);
        Ok(Self {
            device,
            scene: tables.upload(device)?,
            options: *options,
            window_count: windows.len() as u32,
            gate_count: gates.len() as u32,
            gates: device.upload("gates of sunlight", if gates.is_empty() { &no_gate } else { &gates })?,
            sun_count: suns.len(),
            suns: device.upload("suns", if records.is_empty() { &none } else { &records })?,
            panes,
            vertices: Kernel::new(device, "trace/sun_vertices", &[], &[])?,
            gather: Kernel::new(device, "trace/sun_gather", &[], &[("HAS_PANES", f64::from(u8::from(panes)))])?,
            counters: device.zeros::<Counters>("path counters", 1)?,
            tables,
        })
    }

    /// Tiles of receivers that fit memory and bound the time of a dispatch.
    pub fn plan(&self, receivers: usize) -> Result<Plan> {
        let o = &self.options;
        let batches = u64::from(o.batches);
        let sums = batches * self.sun_count as u64 * 24;
        let slots = if o.scatters() { batches * u64::from(o.paths * o.path_sets * o.most_vertices()) * 64 } else { 64 };
        let most = (MOST_PAIRS / (self.sun_count * o.batches as usize).max(1)).clamp(1, 1 << 15);
        Ok(Plan::new(self.device, o.memory, receivers, &[sums, sums, slots, 64], &[], 1)?.at_most(most))
    }

    /// Constants of kernels that trace rays to suns.
    pub fn panes(&self) -> [(&'static str, f64); 1] {
        [("HAS_PANES", f64::from(u8::from(self.panes)))]
    }

    /// Boxes that light must pass, and their number.
    pub fn gates(&self) -> (&Buffer, u32) {
        (&self.gates, self.gate_count)
    }

    /// The black model.
    pub fn scene(&self) -> &TraceScene {
        &self.scene
    }

    /// A point in the tracer's coordinates.
    pub fn point(&self, point: DVec3) -> Vec3 {
        self.tables.normalization.point(point)
    }

    /// A sensor in the tracer's coordinates.
    fn receiver(&self, sensor: &Sensor, number: usize) -> Receiver {
        let normal = sensor.direction.normalize().as_vec3();
        Receiver {
            position: beside(self.tables.normalization.point(sensor.position), normal).to_array(),
            number: number as u32,
            normal: normal.to_array(),
            padding1: 0,
        }
    }

    /// `[batch][receiver][sun][straight rgb, scattered rgb]` of one tile. `batch_stride` is the number
    /// of receivers from one batch to the next, 0 if all batches share them.
    pub fn trace(&self, receivers: &Buffer, count: usize, batch_stride: u32, statistics: &mut TraceStatistics) -> Result<Vec<f32>> {
        let (o, device) = (&self.options, self.device);
        let scatters = o.scatters();
        let paths = if scatters { o.paths } else { 0 };
        let slots = if scatters { o.batches as usize * count * (o.paths * o.path_sets * o.most_vertices()) as usize } else { 1 };
        let vertices = device.zeros::<SunVertex>("vertices that see suns", slots)?;
        if scatters {
            let params = SunPathParams {
                seed: stream_seed(o.seed, 0, 0x7375_6e70),
                receivers: count as u32,
                paths,
                batches: o.batches,
                window_count: self.window_count,
                most_vertices: o.most_vertices(),
                roulette_weight: o.roulette_weight,
                batch_stride,
                path_sets: o.path_sets,
                ..SunPathParams::default()
            };
            let params = device.uniform("paths to suns", &params)?;
            let own = [("params", &params), ("receivers", receivers), ("vertices", &vertices)];
            let all = paths * o.path_sets;
            let started = u64::from(all) * count as u64 * u64::from(o.batches);
            self.run(&self.vertices, &own, [all.div_ceil(64), count as u32, o.batches], started, statistics)?;
        }
        let params = SunGatherParams {
            seed: stream_seed(o.seed, 0, 0x7375_6e67),
            receivers: count as u32,
            suns: self.sun_count as u32,
            batches: o.batches,
            window_count: self.window_count,
            disc_samples: o.disc_samples,
            paths,
            most_vertices: o.most_vertices(),
            batch_stride,
            gates: self.gate_count,
            path_sets: o.path_sets,
            padding0: 0,
        };
        let params = device.uniform("suns", &params)?;
        let sums = device.zeros::<f32>("sun matrix", o.batches as usize * count * self.sun_count * 6)?;
        let own = [
            ("params", &params),
            ("receivers", receivers),
            ("suns", &self.suns),
            ("vertices", &vertices),
            ("sums", &sums),
            ("gates", &self.gates),
        ];
        let started = (self.sun_count * count) as u64 * u64::from(o.batches);
        self.run(&self.gather, &own, [(self.sun_count as u32).div_ceil(64), count as u32, o.batches], started, statistics)?;
        device.read_finite(&sums)
    }

    fn run(
        &self,
        kernel: &Kernel,
        own: &[(&str, &Buffer)],
        workgroups: [u32; 3],
        started: u64,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        self.run_in(&self.scene, kernel, own, workgroups, started, statistics)
    }

    /// Runs a kernel in a scene and checks that all invocations came to their end.
    pub fn run_in(
        &self,
        scene: &TraceScene,
        kernel: &Kernel,
        own: &[(&str, &Buffer)],
        workgroups: [u32; 3],
        started: u64,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        self.device.write(&self.counters, &[Counters::default()])?;
        let mut all = own.to_vec();
        all.push(("counters", &self.counters));
        let bind = kernel.bind(&scene.bindings(&all))?;
        self.device.dispatch(kernel, &bind, workgroups)?;
        finish_dispatch(self.device, &self.counters, started, kernel.label(), statistics)?;
        Ok(())
    }

    /// Means and standard errors over the batches of a tile.
    fn reduce(&self, sums: &[f32], first: usize, count: usize, result: &mut SunMatrix) {
        let batches = self.options.batches as usize;
        for receiver in 0..count {
            for sun in 0..self.sun_count {
                for c in 0..3 {
                    let of = |part: usize| {
                        let values =
                            (0..batches).map(|b| f64::from(sums[((b * count + receiver) * self.sun_count + sun) * 6 + part * 3 + c]));
                        let (mut sum, mut squares) = (0.0, 0.0);
                        for v in values {
                            sum += v;
                            squares += v * v;
                        }
                        let n = batches as f64;
                        (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / (n - 1.0)).sqrt())
                    };
                    let ((direct, direct_error), (scattered, scattered_error)) = (of(0), of(1));
                    let row = first + receiver;
                    result.direct.at_mut(row, sun)[c] = direct as f32;
                    result.total.at_mut(row, sun)[c] = (direct + scattered) as f32;
                    result.direct_error.at_mut(row, sun)[c] = direct_error as f32;
                    result.scattered_error.at_mut(row, sun)[c] = scattered_error as f32;
                }
            }
        }
    }
}

/// A sensor that lies on a surface is moved a little to the side it faces, or rounding would put it
/// behind the surface.
fn beside(position: Vec3, direction: Vec3) -> Vec3 {
    position + direction * (1e-5 * (position.abs().max_element() + 0.5))
}
