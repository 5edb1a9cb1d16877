//! A scene and its suns on the device: paths to the surfaces that scatter, and what receivers get of
//! every sun.

use super::Sun;
use super::geometry::{Gate, Openings, SunMatrix, SunOptions};
use super::mirrors::Mirrors;
use super::pairs::Pairs;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device, Kernel, Plan, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::{Receiver, finish_dispatch};
use crate::kernels::trace::{self, Counters, TraceScene, TraceStatistics, TraceTables, WindowSurfaces, stream_seed};
use crate::scene::Scene;
use crate::scene::points::Sensor;
use glam::{DVec3, Vec3};
use std::cell::OnceCell;

gpu_struct! {
    /// A sun (`shared/sun.wgsl`).
    pub(crate) struct SunRecord {
        /// Unit vector towards the centre.
        direction: [f32; 3],
        /// 2 sin(angular radius / 2): length of the chord from the centre to the rim of the disc on the
        /// unit sphere; 0 for a point.
        chord: f32,
        /// Solid angle it counts with, sr.
        solid_angle: f32,
        /// Chooses its random numbers, whatever dispatch it is in.
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
        /// Paths per receiver and batch that one sun uses.
        paths: u32,
        batches: u32,
        window_count: u32,
        /// Slots per path.
        most_vertices: u32,
        roulette_weight: f32,
        /// Receivers from one batch to the next; 0 if all batches share them.
        batch_stride: u32,
        /// Sets of so many paths; suns take turns in using them.
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
        /// Polygons of windows that light must pass, or boxes in their place; it comes from anywhere if
        /// there are neither.
        window_count: u32,
        /// Points of the disc per batch.
        disc_samples: u32,
        /// Paths per receiver and batch, and their slots; 0 for straight light only.
        paths: u32,
        most_vertices: u32,
        /// Receivers from one batch to the next; 0 if all batches share them.
        batch_stride: u32,
        gates: u32,
        /// Sets of so many paths; the suns take turns.
        path_sets: u32,
        /// Points of the disc's rim that are looked at where all other points agree: whatever covers a part of
        /// the disc from one side is seen at its rim first.
        rim: u32,
        /// Columns of the matrix that takes a direction to the sun to that of its image.
        image_x: [f32; 3],
        /// Whether neighbours take neighbouring receivers, not suns: their rays go side by side.
        receivers_first: u32,
        image_y: [f32; 3],
        /// Paths of this dispatch: some drivers end loops early. What is straight belongs to the first.
        first_path: u32,
        image_z: [f32; 3],
        end_path: u32,
    }
}

gpu_struct! {
    /// Where a path meets a surface that scatters (`shared/receiver.wgsl`).
    pub(crate) struct SunVertex {
        /// Beside the surface, on the side of arrival.
        position: [f32; 3],
        /// Index + 1; 0 after the last vertex of a path.
        pub(super) material: u32,
        facing: [f32; 3],
        /// From `position` through the surface to the other side.
        thickness: f32,
        incoming: [f32; 3],
        padding0: u32,
        throughput: [f32; 3],
        /// That it stands for, if it is a point of a shade.
        area: f32,
    }
}

/// Points of a disc's rim.
const RIM: u32 = 4;
/// Paths that one invocation gathers. Mesa's lavapipe ends all loops of an invocation after 65,535 turns; the rays
/// of a path take up to 160 between slats, that to a point of the disc up to 60, whatever lies behind.
const MOST_PATHS: usize = 64;
/// Points of a disc in a batch, all of which one invocation takes.
const MOST_POINTS: u32 = 512;
/// Turns of a ray's loops, about, when that many are taken.
const TURNS_OF_RAY: u32 = 120;
/// Pairs of receiver and sun, over all batches, of one dispatch: bounds its time.
const MOST_PAIRS: usize = 1 << 20;

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<Shader> {
    let mut all = super::pairs::registered();
    all.extend([VERTICES, GATHER]);
    all
}

pub(super) const VERTICES: Shader =
    trace::shader("trace/sun_vertices", &[&[SunPathParams::DECLARED, SunVertex::DECLARED, Receiver::DECLARED]]);
const GATHER: Shader = trace::shader(
    "trace/sun_gather",
    &[&[SunGatherParams::DECLARED, SunVertex::DECLARED, SunRecord::DECLARED, Gate::DECLARED, Receiver::DECLARED]],
);

/// A scene and its suns on the device.
pub(crate) struct SunTracer<'d> {
    pub(super) device: &'d Device,
    pub(super) tables: TraceTables,
    pub(super) scene: TraceScene,
    pub(super) options: SunOptions,
    pub(super) window_count: u32,
    gate_count: u32,
    gates: Buffer,
    pub(super) sun_count: usize,
    pub(super) suns: Buffer,
    panes: bool,
    /// Whether the rays to suns could enter a window from outside.
    may_enter: bool,
    most_paths: usize,
    vertices: Kernel,
    gather: OnceCell<Kernel>,
    /// Straight light where every batch has receivers of its own.
    pairs: OnceCell<Pairs>,
    /// Images of the suns in mirrors, and the kernel that looks for them.
    mirrored: Option<(Kernel, Vec<glam::Mat3>)>,
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
        let windows = openings.windows();
        let into = |sun: &Sun| windows.iter().any(|w| sun.direction.dot(w.frame.z) > -sun.chord());
        let may_enter = suns.iter().any(into);
        // Every ray then looks at every window, too.
        let turns = TURNS_OF_RAY + if may_enter { 2 * windows.len() as u32 } else { 0 };
        let fewer = |most: u32| (most * TURNS_OF_RAY / turns).max(1);
        let options = &options.in_batches_of(fewer(MOST_POINTS));
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
        let images: Vec<glam::Mat3> = Mirrors::of(scene).images.iter().map(glam::DMat3::as_mat3).collect();
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
            may_enter,
            most_paths: fewer(MOST_PATHS as u32) as usize,
            vertices: Kernel::new(device, &VERTICES, &[])?,
            gather: OnceCell::new(),
            pairs: OnceCell::new(),
            mirrored: if images.is_empty() {
                None
            } else {
                let constants = [("MIRRORED", 1.0), ("MAY_ENTER", f64::from(u8::from(may_enter)))];
                Some((Kernel::new(device, &GATHER, &constants)?, images))
            },
            counters: device.zeros::<Counters>("path counters", 1)?,
            tables,
        })
    }

    /// Tiles of receivers that fit memory and bound the time of a dispatch.
    pub fn plan(&self, receivers: usize) -> Result<Plan> {
        let o = &self.options;
        let batches = u64::from(o.batches);
        let sums = batches * self.sun_count as u64 * 28;
        let slots = if o.scatters() { batches * u64::from(o.paths * o.path_sets * o.most_vertices()) * 64 } else { 64 };
        let most = (MOST_PAIRS / (self.sun_count * o.batches as usize).max(1)).clamp(1, 1 << 15);
        Ok(Plan::new(self.device, o.memory, receivers, &[sums, sums, slots, 64], &[], 1)?.at_most(most))
    }

    /// Constants of kernels that trace rays to suns.
    pub fn constants(&self) -> [(&'static str, f64); 2] {
        [("HAS_PANES", f64::from(u8::from(self.panes))), ("MAY_ENTER", f64::from(u8::from(self.may_enter)))]
    }

    /// Matrices that take a direction to a sun to those of its images in flat mirrors.
    pub fn images(&self) -> &[glam::Mat3] {
        self.mirrored.as_ref().map_or(&[], |(_, images)| images)
    }

    /// Boxes that light must pass, and their number.
    pub fn gates(&self) -> (&Buffer, u32) {
        (&self.gates, self.gate_count)
    }

    /// Whether flat mirrors show images of the suns.
    pub(super) fn has_images(&self) -> bool {
        self.mirrored.is_some()
    }

    /// The suns, and their number.
    pub(super) fn suns(&self) -> (&Buffer, usize) {
        (&self.suns, self.sun_count)
    }

    pub(super) fn device(&self) -> &'d Device {
        self.device
    }

    pub(super) fn options(&self) -> &SunOptions {
        &self.options
    }

    pub(super) fn window_count(&self) -> u32 {
        self.window_count
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
    pub(super) fn receiver(&self, sensor: &Sensor, number: usize) -> Receiver {
        let normal = sensor.direction.normalize().as_vec3();
        Receiver {
            position: beside(self.tables.normalization.point(sensor.position), normal).to_array(),
            number: number as u32,
            normal: normal.to_array(),
            role: 0,
        }
    }

    /// `[batch][receiver][sun][straight rgb, scattered rgb]` of one tile, then `[batch][receiver][sun]` the doubt about
    /// the straight part. `batch_stride` is the number
    /// of receivers from one batch to the next, 0 if all batches share them.
    pub fn trace(&self, receivers: &Buffer, count: usize, batch_stride: u32, statistics: &mut TraceStatistics) -> Result<Vec<f32>> {
        self.trace_parts(receivers, count, batch_stride, self.options.scatters(), statistics)
    }

    /// The same with or without what surfaces scatter.
    pub(super) fn trace_parts(
        &self,
        receivers: &Buffer,
        count: usize,
        batch_stride: u32,
        scatters: bool,
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<f32>> {
        let (o, device) = (&self.options, self.device);
        let paths = if scatters { o.paths } else { 0 };
        let slots = if scatters { o.batches as usize * count * (o.paths * o.path_sets * o.most_vertices()) as usize } else { 1 };
        let vertices = device.zeros::<SunVertex>("vertices that see suns", slots)?;
        if scatters {
            self.start_paths(&self.vertices, receivers, count, batch_stride, &vertices, statistics)?;
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
            // A pixel's batches have surface points of their own: their spread is its error.
            rim: if batch_stride == 0 { RIM } else { 0 },
            receivers_first: u32::from(batch_stride > 0),
            ..SunGatherParams::default()
        };
        let sums = device.zeros::<f32>("sun matrix", o.batches as usize * count * self.sun_count * 7)?;
        let own_points = batch_stride > 0;
        if own_points {
            let pairs = made_once(&self.pairs, || Pairs::new(device, &self.constants()))?;
            pairs.trace(self, receivers, count, &sums, statistics)?;
        }
        let mut passes = Vec::new();
        if scatters || !own_points {
            let [panes, may_enter] = self.constants();
            let constants = [
                panes,
                may_enter,
                ("STRAIGHT", f64::from(u8::from(!own_points))),
                ("SCATTERED", f64::from(u8::from(self.options.scatters()))),
            ];
            passes.push((made_once(&self.gather, || Kernel::new(device, &GATHER, &constants))?, glam::Mat3::IDENTITY));
        }
        if let Some((kernel, images)) = &self.mirrored {
            passes.extend(images.iter().map(|image| (kernel, *image)));
        }
        let chunks = (0..paths.max(1)).step_by(self.most_paths).map(|first| [first, paths.min(first + self.most_paths as u32)]);
        for ((kernel, image), [first_path, end_path]) in passes.into_iter().flat_map(|pass| chunks.clone().map(move |chunk| (pass, chunk)))
        {
            let [image_x, image_y, image_z] = image.to_cols_array_2d();
            let params = device.uniform("suns", &SunGatherParams { image_x, image_y, image_z, first_path, end_path, ..params })?;
            let own = [
                ("params", &params),
                ("receivers", receivers),
                ("suns", &self.suns),
                ("vertices", &vertices),
                ("sums", &sums),
                ("gates", &self.gates),
            ];
            let started = (self.sun_count * count) as u64 * u64::from(o.batches);
            let (suns, receivers) = (self.sun_count as u32, count as u32);
            let groups =
                if batch_stride > 0 { [receivers.div_ceil(64), suns, o.batches] } else { [suns.div_ceil(64), receivers, o.batches] };
            self.run(kernel, &own, groups, started, statistics)?;
        }
        device.read_finite(&sums)
    }

    /// Paths of all sets from these receivers, by a variant of `trace/sun_vertices`.
    pub(super) fn start_paths(
        &self,
        kernel: &Kernel,
        receivers: &Buffer,
        count: usize,
        batch_stride: u32,
        vertices: &Buffer,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let o = &self.options;
        let params = SunPathParams {
            seed: stream_seed(o.seed, 0, 0x7375_6e70),
            receivers: count as u32,
            paths: o.paths,
            batches: o.batches,
            window_count: self.window_count,
            most_vertices: o.most_vertices(),
            roulette_weight: o.roulette_weight,
            batch_stride,
            path_sets: o.path_sets,
            ..SunPathParams::default()
        };
        let params = self.device.uniform("paths to suns", &params)?;
        let own = [("params", &params), ("receivers", receivers), ("vertices", vertices)];
        let all = o.paths * o.path_sets;
        let started = u64::from(all) * count as u64 * u64::from(o.batches);
        self.run(kernel, &own, [all.div_ceil(64), count as u32, o.batches], started, statistics)
    }

    pub(super) fn run(
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

    /// Means and standard errors over the batches of a tile, whose receivers belong into these rows.
    pub(super) fn reduce(&self, sums: &[f32], rows: &[usize], result: &mut SunMatrix) {
        let (batches, count) = (self.options.batches as usize, rows.len());
        for (receiver, &row) in rows.iter().enumerate() {
            for sun in 0..self.sun_count {
                let cells = (0..batches).map(move |b| (b * count + receiver) * self.sun_count + sun);
                let values = |part: usize| cells.clone().map(move |cell| f64::from(sums[cell * 6 + part]));
                let doubts = cells.clone().map(|cell| f64::from(sums[batches * count * self.sun_count * 6 + cell]));
                let doubt = doubts.sum::<f64>() / (batches * batches) as f64;
                for c in 0..3 {
                    let ((direct, direct_variance), (scattered, scattered_variance)) =
                        (mean_and_variance(values(c)), mean_and_variance(values(3 + c)));
                    result.direct.at_mut(row, sun)[c] = direct as f32;
                    result.total.at_mut(row, sun)[c] = (direct + scattered) as f32;
                    result.direct_error.at_mut(row, sun)[c] = with_doubt(direct_variance, batches, doubt).sqrt() as f32;
                    result.scattered_error.at_mut(row, sun)[c] = scattered_variance.sqrt() as f32;
                }
            }
        }
    }
}

/// What a cell holds, made at the first call.
fn made_once<T>(cell: &OnceCell<T>, make: impl FnOnce() -> Result<T>) -> Result<&T> {
    match cell.get() {
        Some(made) => Ok(made),
        None => {
            let made = make()?;
            Ok(cell.get_or_init(|| made))
        }
    }
}

/// Mean of independent values and its variance.
pub(super) fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}

/// Variance of a mean by its spread and by what the points seen allow. Few batches often agree by
/// chance, above all where an edge hides a sliver of the disc; the second then counts as much as three
/// further batches would.
fn with_doubt(spread: f64, batches: usize, doubt: f64) -> f64 {
    const WEIGHT: f64 = 3.0;
    let degrees = (batches - 1) as f64;
    if doubt > 0.0 { (degrees * spread + WEIGHT * doubt) / (degrees + WEIGHT) } else { spread }
}

/// A sensor that lies on a surface is moved a little to the side it faces, or rounding would put it
/// behind the surface.
fn beside(position: Vec3, direction: Vec3) -> Vec3 {
    position + direction * (1e-5 * (position.abs().max_element() + 0.5))
}
