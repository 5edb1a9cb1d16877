//! A scene and its suns on the device.

use super::mirrors::Mirrors;
use super::openings::{Gate, Openings};
use super::options::SunOptions;
use super::pane::tables::{PaneSun, PaneTables};
use super::sun::Sun;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Declared, Device, Kernel, Plan, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::{Receiver, finish_dispatch};
use crate::kernels::trace::{Counters, TraceScene, TraceStatistics, TraceTables, WindowSurfaces};
use crate::scene::Scene;
use crate::scene::points::Sensor;
use glam::{DVec3, Mat3, Vec3};

gpu_struct! {
    /// A sun (`sun_matrix/sun.wgsl`).
    pub(crate) struct SunRecord {
        pub direction: [f32; 3],
        pub chord: f32,
        pub solid_angle: f32,
        pub number: u32,
        pub padding0: u32,
        pub padding1: u32,
    }
}

gpu_struct! {
    /// Where a path from a receiver meets a surface that scatters sunlight.
    pub(crate) struct SunVertex {
        pub position: [f32; 3],
        pub material: u32,
        pub facing: [f32; 3],
        pub thickness: f32,
        pub incoming: [f32; 3],
        pub reach: f32,
        pub throughput: [f32; 3],
        pub area: f32,
    }
}

impl SunRecord {
    pub(crate) fn new(sun: &Sun, number: usize) -> Self {
        Self {
            direction: sun.direction.as_vec3().normalize().to_array(),
            chord: sun.chord() as f32,
            solid_angle: sun.solid_angle() as f32,
            number: number as u32,
            ..Self::default()
        }
    }
}

/// What shaders of suns share.
pub(super) const STRUCTS: &[Declared] = &[SunRecord::DECLARED, SunVertex::DECLARED, Gate::DECLARED, Receiver::DECLARED];

/// Points of a disc in a batch, all of which one invocation takes. Mesa's lavapipe ends all loops of an invocation
/// after 65,535 turns; the ray to a point takes up to 60, whatever lies behind.
const MOST_POINTS: u32 = 512;
/// Paths that one invocation gathers: the rays of a path take up to 160 turns between slats.
const MOST_PATHS: u32 = 64;
/// Turns of a ray's loops, about, when that many are taken.
const TURNS_OF_RAY: u32 = 120;
/// Pairs of receiver and sun, over all batches, of one dispatch: bounds its time.
pub(super) const MOST_PAIRS: usize = 1 << 20;

/// A scene and its suns on the device.
pub(crate) struct SunTracer<'d> {
    pub(super) device: &'d Device,
    pub(super) tables: TraceTables,
    pub(super) options: SunOptions,
    pub(super) window_count: u32,
    /// Boxes that light must pass, and their number.
    pub(super) gates: Buffer,
    pub(super) gate_count: u32,
    pub(super) sun_count: usize,
    pub(super) suns: Buffer,
    pub(super) records: Vec<SunRecord>,
    /// Panes of scattering data in the openings, and what they are to each sun.
    pub(super) panes: Option<PaneTables>,
    pub(super) pane_suns: Buffer,
    /// Matrices that take a direction to a sun to those of its images in flat mirrors.
    pub(super) images: Vec<Mat3>,
    /// Paths that one invocation gathers.
    pub(super) most_paths: u32,
    /// The largest share of light that a surface of the scene scatters.
    pub(super) brightest: f32,
    scene: TraceScene,
    /// Whether the rays to suns could enter a window from outside.
    may_enter: bool,
    counters: Buffer,
}

/// Receivers on the device.
pub(super) struct Tile<'a> {
    pub receivers: &'a Buffer,
    /// Number of each, of a batch.
    pub numbers: &'a [u32],
    /// From one batch to the next; 0 if all batches share them.
    pub batch_stride: u32,
}

impl Tile<'_> {
    /// Receivers of a batch.
    pub fn count(&self) -> usize {
        self.numbers.len()
    }
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
        // Behind panes of scattering data none are met.
        let no_mirrors = matches!(openings, Openings::Panes(_));
        let images = if no_mirrors { Vec::new() } else { Mirrors::of(scene).images.iter().map(glam::DMat3::as_mat3).collect() };
        // Every ray then looks at every window, too, and has several legs.
        let turns = TURNS_OF_RAY * if images.is_empty() { 1 } else { 3 } + if may_enter { 2 * windows.len() as u32 } else { 0 };
        let fewer = |most: u32| (most * TURNS_OF_RAY / turns).max(1);
        let options = options.in_batches_of(fewer(MOST_POINTS));
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
        let panes = match openings {
            Openings::Panes(panes) => Some(PaneTables::new(&tables, panes, suns, &options)?),
            _ => None,
        };
        let gates = openings.gates(&tables.normalization);
        let records: Vec<SunRecord> = suns.iter().enumerate().map(|(i, s)| SunRecord::new(s, i)).collect();
        let (none, no_gate, no_pane) = ([SunRecord::default()], [Gate::default()], [PaneSun::default()]);
        let of_panes = panes.as_ref().map(|p| &p.suns[..]).filter(|s| !s.is_empty()).unwrap_or(&no_pane);
        Ok(Self {
            device,
            scene: tables.upload(device)?,
            options,
            window_count: windows.len() as u32,
            gate_count: gates.len() as u32,
            gates: device.upload("gates of sunlight", if gates.is_empty() { &no_gate } else { &gates })?,
            sun_count: suns.len(),
            suns: device.upload("suns", if records.is_empty() { &none } else { &records })?,
            pane_suns: device.upload("suns through panes", of_panes)?,
            records,
            panes,
            images,
            most_paths: fewer(MOST_PATHS),
            brightest: tables.triangle_materials.iter().map(|m| tables.materials[*m as usize].scattered()).fold(0.0, f32::max),
            may_enter,
            counters: device.zeros::<Counters>("path counters", 1)?,
            tables,
        })
    }

    /// Whether light that surfaces scatter is asked for, and any does.
    pub fn scatters(&self) -> bool {
        self.options.scatters() && self.panes.is_none() && self.brightest > 0.0
    }

    /// Components of scattered light: 1 if all is grey, or 3.
    pub fn components(&self) -> usize {
        if self.tables.features.grey { 1 } else { 3 }
    }

    /// Tiles of receivers that fit memory and bound the time of a dispatch.
    pub fn plan(&self, receivers: usize) -> Result<Plan> {
        let o = &self.options;
        let batches = u64::from(o.batches);
        let suns = batches * self.sun_count as u64;
        let slots = if self.scatters() { batches * u64::from(o.paths * o.path_sets * o.most_vertices()) * 64 } else { 64 };
        let most = (MOST_PAIRS / (self.sun_count * o.batches as usize).max(1)).clamp(1, 1 << 15);
        Ok(Plan::new(self.device, o.memory, receivers, &[8 * suns, 16 * suns, 24 * suns, slots, 64], &[], 1)?.at_most(most))
    }

    /// A kernel that traces rays to suns.
    pub fn kernel(&self, shader: &Shader, constants: &[(&str, f64)]) -> Result<Kernel> {
        let switch = |on: bool| f64::from(u8::from(on));
        let clear = self.tables.features.glass || self.tables.features.specular;
        let all = [&[("HAS_PANES", switch(clear)), ("MAY_ENTER", switch(self.may_enter))], constants].concat();
        Kernel::new(self.device, shader, &all)
    }

    /// A point in the tracer's coordinates.
    pub fn point(&self, point: DVec3) -> Vec3 {
        self.tables.normalization.point(point)
    }

    /// A sensor in the tracer's coordinates.
    pub fn receiver(&self, sensor: &Sensor, number: usize) -> Receiver {
        let normal = sensor.direction.normalize().as_vec3();
        Receiver {
            position: beside(self.point(sensor.position), normal).to_array(),
            number: number as u32,
            normal: normal.to_array(),
            role: 0,
        }
    }

    /// Runs so many invocations of a kernel that traces rays, and checks that all came to their end.
    pub fn run(&self, kernel: &Kernel, own: &[(&str, &Buffer)], invocations: u64, statistics: &mut TraceStatistics) -> Result<()> {
        let mut all = own.to_vec();
        all.push(("counters", &self.counters));
        self.run_bound(kernel, &self.scene.bindings(&all), invocations, statistics)
    }

    /// The same of one that traces none.
    pub(crate) fn run_alone(
        &self,
        kernel: &Kernel,
        own: &[(&str, &Buffer)],
        invocations: u64,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let mut all = own.to_vec();
        all.push(("counters", &self.counters));
        self.run_bound(kernel, &all, invocations, statistics)
    }

    fn run_bound(&self, kernel: &Kernel, bindings: &[(&str, &Buffer)], invocations: u64, statistics: &mut TraceStatistics) -> Result<()> {
        if invocations == 0 {
            return Ok(());
        }
        self.device.write(&self.counters, &[Counters::default()])?;
        self.device.dispatch(kernel, &kernel.bind(bindings)?, self.device.grid(invocations.div_ceil(64))?)?;
        finish_dispatch(self.device, &self.counters, invocations, kernel.label(), statistics)?;
        Ok(())
    }
}

/// A sensor that lies on a surface is moved a little to the side it faces, or rounding would put it
/// behind the surface.
fn beside(position: Vec3, direction: Vec3) -> Vec3 {
    position + direction * (1e-5 * (position.abs().max_element() + 0.5))
}
