//! Runs the pane kernels over tiles of suns and receivers.

use super::tables::{pane_cells, sun_record};
use super::{FacadePoint, Pane, PaneBsdf, PaneCell, PaneEnd, PaneOptions, PaneParams, PaneSun, PaneSunRecord, Sun};
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device, Kernel, Plan, Shader};
use crate::kernels::bsdf_scattering::{PackedBsdfs, Tables};
use crate::kernels::light_paths::{Receiver, finish_dispatch};
use crate::kernels::trace::{Counters, TraceScene, TraceStatistics, TraceTables, WindowSurfaces, stream_seed};
use crate::kernels::view_matrix::mean_and_error;
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::scene::points::Sensor;
use crate::scene::{Scene, Window};
use glam::Vec3;

/// The scene on the device, and the suns that can reach a pane.
pub(in super::super) struct PaneTracer<'d> {
    device: &'d Device,
    options: PaneOptions,
    pub(super) tables: TraceTables,
    scene: TraceScene,
    glass: f64,
    panes: Vec<Pane>,
    cells: Vec<PaneCell>,
    words: PackedBsdfs,
    /// Columns of the suns traced, and their records `[sun][pane]`.
    active: Vec<usize>,
    suns: Vec<PaneSunRecord>,
    scatters: bool,
    is_clear: bool,
    /// Cells of one dispatch beside the device's own limit.
    pub(super) most_cells: u32,
}

/// Suns whose light at the panes' cells is known.
pub(in super::super) struct SunsAtPanes {
    shared: Shared,
    suns: Buffer,
    ends: Buffer,
    count: usize,
}

/// Receivers, or points of the façade, on the device.
pub(in super::super) struct Tile<'a> {
    pub receivers: &'a Buffer,
    pub count: usize,
    /// From one batch to the next; 0 if all batches share them.
    pub batch_stride: u32,
}

/// Buffers that every kernel of this module binds.
struct Shared {
    panes: Buffer,
    cells: Buffer,
    words: Buffer,
    counters: Buffer,
}

impl<'d> PaneTracer<'d> {
    pub fn new(device: &'d Device, scene: &Scene, windows: &[(Window, PaneBsdf)], suns: &[Sun], options: &PaneOptions) -> Result<Self> {
        if options.batches < 2 {
            return Err(Error::new("at least two batches are needed for a standard error"));
        }
        let shapes: Vec<Window> = windows.iter().map(|(w, _)| w.clone()).collect();
        let tables = TraceTables::new(scene, &shapes, WindowSurfaces::Open)?;
        let mut words = PackedBsdfs::new();
        let mut panes = Vec::new();
        for ((window, bsdf), record) in windows.iter().zip(&tables.windows) {
            let at = |e: Error| e.file(&window.origin.file).line(window.origin.line);
            let first = bsdf.scattering().map(|s| words.push(s, Tables::Evaluate)).transpose().map_err(at)?;
            panes.push(Pane {
                x: record.x,
                words: first.unwrap_or(super::NO_SCATTERING),
                y: record.y,
                first_triangle: record.first_triangle,
                z: record.z,
                triangles: record.triangles,
                tint: bsdf.tint().map(|v| v as f32),
                padding: 0,
            });
        }
        let (mut active, mut records) = (Vec::new(), Vec::new());
        for (column, sun) in suns.iter().enumerate() {
            let Some(direction) = sun.direction.try_normalize() else {
                return Err(Error::new(format!("sun {} has no direction", column + 1)));
            };
            if windows.iter().any(|(w, _)| direction.dot(w.frame.z) < 0.0) {
                active.push(column);
                records.extend(windows.iter().map(|(w, bsdf)| sun_record(sun, w, bsdf)));
            }
        }
        let glass = f64::from(u8::from(tables.features.glass));
        Ok(Self {
            scene: tables.upload(device)?,
            cells: pane_cells(&shapes, &tables, options),
            device,
            options: *options,
            glass,
            panes,
            words,
            scatters: windows.iter().any(|(_, b)| b.scattering().is_some()),
            is_clear: records.iter().any(|r| r.clear != [0.0; 3]),
            active,
            suns: records,
            tables,
            most_cells: u32::MAX,
        })
    }

    pub(super) fn empty(&self, rows: usize, columns: usize) -> PaneSun {
        let zeros = || Matrix::zeros(rows, columns, 3);
        PaneSun { total: zeros(), clear: zeros(), standard_error: zeros(), statistics: TraceStatistics::default() }
    }

    pub(super) fn receiver(&self, number: usize, sensor: &Sensor) -> Receiver {
        let normal = sensor.direction.normalize().as_vec3();
        let position = self.tables.normalization.point(sensor.position);
        let beside: Vec3 = position + normal * (1e-5 * (position.abs().max_element() + 0.5));
        Receiver { position: beside.to_array(), number: number as u32, normal: normal.to_array(), role: 0 }
    }

    fn params(&self, receivers: usize, suns: usize, batch_stride: u32) -> PaneParams {
        PaneParams {
            seed: stream_seed(self.options.seed, 0, 0x7061_6e65),
            receivers: receivers as u32,
            suns: suns as u32,
            cells: (self.cells.len() / self.options.batches as usize) as u32,
            batches: self.options.batches,
            panes: self.panes.len() as u32,
            disc_samples: self.options.disc_samples.max(1),
            batch_stride,
            part_angle: self.options.part_angle,
            ..PaneParams::default()
        }
    }

    fn shared(&self) -> Result<Shared> {
        Ok(Shared {
            panes: self.device.upload("panes", &self.panes)?,
            cells: self.device.upload("cells of the panes", &self.cells)?,
            words: self.device.upload("BSDFs", self.words.words())?,
            counters: self.device.zeros::<Counters>("path counters", 1)?,
        })
    }

    fn kernel(&self, shader: &Shader) -> Result<Kernel> {
        Kernel::new(self.device, shader, &[("HAS_GLASS", self.glass)])
    }

    /// Runs a kernel and checks that all of it ran.
    #[allow(clippy::too_many_arguments, reason = "private; each is a different thing")]
    fn dispatch(
        &self,
        kernel: &Kernel,
        traces: bool,
        own: &[(&str, &Buffer)],
        shared: &Shared,
        grid: [usize; 3],
        what: &str,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        self.device.write(&shared.counters, &[Counters::default()])?;
        let mut own = own.to_vec();
        own.push(("counters", &shared.counters));
        let bind = kernel.bind(&if traces { self.scene.bindings(&own) } else { own })?;
        self.device.dispatch(kernel, &bind, [grid[0].div_ceil(64) as u32, grid[1] as u32, grid[2] as u32])?;
        finish_dispatch(self.device, &shared.counters, (grid[0] * grid[1] * grid[2]) as u64, what, statistics)?;
        Ok(())
    }

    /// The suns that can reach a pane, in chunks that fit memory.
    pub fn chunks_of_suns(&self) -> Result<Plan> {
        let sun_bytes = (self.cells.len() * size_of::<PaneEnd>()) as u64;
        Ok(Plan::new(self.device, self.options.memory / 2, self.active.len(), &[sun_bytes], &[], 1)?.at_most(MOST_ROWS))
    }

    /// Tiles of receivers that fit memory beside so many suns.
    pub fn tiles(&self, receivers: usize, suns: usize) -> Result<Plan> {
        let passed = (self.cells.len() * size_of::<PaneEnd>() / 2) as u64;
        let cells = (suns * self.options.batches as usize * 12) as u64;
        Ok(Plan::new(self.device, self.options.memory / 2, receivers, &[passed, cells, cells], &[], 1)?.at_most(MOST_ROWS))
    }

    /// Columns of the suns that can reach a pane.
    pub fn active(&self) -> &[usize] {
        &self.active
    }

    /// Finds the cells that suns reach: `count` of the active ones from `first`.
    pub fn suns_at_panes(&self, first: usize, count: usize, statistics: &mut TraceStatistics) -> Result<SunsAtPanes> {
        let panes = self.panes.len();
        let all = self.cells.len();
        let shared = self.shared()?;
        let suns = self.device.upload("suns", &self.suns[first * panes..(first + count) * panes])?;
        let ends = self.device.zeros::<PaneEnd>("suns at cells", if self.scatters { count * all } else { 0 })?;
        if self.scatters {
            let params = self.device.uniform("parameters", &self.params(0, count, 0))?;
            let own = [
                ("params", &params),
                ("panes", &shared.panes),
                ("cells", &shared.cells),
                ("suns", &suns),
                ("ends", &ends),
                ("bsdf_words", &shared.words),
            ];
            self.dispatch(&self.kernel(&super::SUNS)?, true, &own, &shared, [all, count, 1], "suns at panes", statistics)?;
        }
        Ok(SunsAtPanes { shared, suns, ends, count })
    }

    /// Light that receivers get: scattered, and clear, each `[batch][sun][receiver][rgb]` or empty if
    /// there is none.
    pub fn gather(
        &self,
        suns: &SunsAtPanes,
        tile: &Tile<'_>,
        progress: &dyn Progress,
        statistics: &mut TraceStatistics,
    ) -> Result<[Vec<f32>; 2]> {
        let (all, batches) = (self.cells.len(), self.options.batches as usize);
        let shared = &suns.shared;
        let sums = self.device.zeros::<f32>("sun matrix", batches * suns.count * tile.count * 3)?;
        let mut params = self.params(tile.count, suns.count, tile.batch_stride);
        let uniform = self.device.uniform("parameters", &params)?;
        let mut parts: [Vec<f32>; 2] = [Vec::new(), Vec::new()];
        if self.scatters {
            let passed = self.device.zeros::<[f32; 4]>("receivers at cells", tile.count * all)?;
            self.ways_to_cells(shared, tile, &passed, statistics)?;
            let kernel = Kernel::new(self.device, &super::GATHER, &[])?;
            let grid = [tile.count, suns.count.div_ceil(super::GATHERED_SUNS as usize), batches];
            while params.end_cell < params.cells {
                params.first_cell = params.end_cell;
                params.end_cell = (params.first_cell + GATHERED_CELLS).min(params.cells);
                let params = self.device.uniform("parameters", &params)?;
                let own = [
                    ("params", &params),
                    ("panes", &shared.panes),
                    ("cells", &shared.cells),
                    ("suns", &suns.suns),
                    ("passed", &passed),
                    ("receivers", tile.receivers),
                    ("sun_ends", &suns.ends),
                    ("bsdf_words", &shared.words),
                    ("sums", &sums),
                ];
                self.dispatch(&kernel, false, &own, shared, grid, "gathering over panes", statistics)?;
                if progress.stop_requested() {
                    return Err(cancelled());
                }
            }
            parts[0] = self.device.read_finite(&sums)?;
        }
        if self.is_clear {
            let own =
                [("params", &uniform), ("panes", &shared.panes), ("receivers", tile.receivers), ("suns", &suns.suns), ("sums", &sums)];
            let grid = [tile.count, suns.count, batches];
            self.dispatch(&self.kernel(&super::CLEAR)?, true, &own, shared, grid, "suns seen through panes", statistics)?;
            parts[1] = self.device.read_finite(&sums)?;
        }
        Ok(parts)
    }

    /// What share of light passes between receivers and cells, `[batch][cell][receiver]`. Cells are an axis
    /// of the dispatch, and a device takes only so many workgroups along it.
    fn ways_to_cells(&self, shared: &Shared, tile: &Tile<'_>, passed: &Buffer, statistics: &mut TraceStatistics) -> Result<()> {
        let kernel = self.kernel(&super::RECEIVERS)?;
        let most = self.device.limits().max_compute_workgroups_per_dimension.min(self.most_cells);
        let all = self.cells.len() as u32;
        for first_cell in (0..all).step_by(most.max(1) as usize) {
            let end_cell = all.min(first_cell.saturating_add(most));
            let params = PaneParams { first_cell, end_cell, ..self.params(tile.count, 0, tile.batch_stride) };
            let params = self.device.uniform("parameters", &params)?;
            let own = [
                ("params", &params),
                ("panes", &shared.panes),
                ("cells", &shared.cells),
                ("receivers", tile.receivers),
                ("passed", passed),
            ];
            let grid = [tile.count, (end_cell - first_cell) as usize, 1];
            self.dispatch(&kernel, true, &own, shared, grid, "receivers at panes", statistics)?;
        }
        Ok(())
    }

    /// Radiance of façade points (`tile.receivers` holds [`FacadePoint`]s), `[batch][sun][point][rgb]`;
    /// empty if nothing scatters.
    pub fn facade(&self, suns: &SunsAtPanes, tile: &Tile<'_>, batches: usize, statistics: &mut TraceStatistics) -> Result<Vec<f32>> {
        if !self.scatters {
            return Ok(Vec::new());
        }
        let params = self.device.uniform("parameters", &self.params(tile.count, suns.count, tile.batch_stride))?;
        let sums = self.device.zeros::<f32>("façade", batches * suns.count * tile.count * 3)?;
        let own = [
            ("params", &params),
            ("panes", &suns.shared.panes),
            ("points", tile.receivers),
            ("suns", &suns.suns),
            ("sums", &sums),
            ("bsdf_words", &suns.shared.words),
        ];
        let grid = [tile.count, suns.count, batches];
        self.dispatch(&self.kernel(&super::FACADE)?, true, &own, &suns.shared, grid, "suns on the façade", statistics)?;
        self.device.read_finite(&sums)
    }

    pub(super) fn run(&self, receivers: &[Receiver], result: &mut PaneSun, progress: &dyn Progress) -> Result<()> {
        self.over_tiles(receivers, "sun matrix through panes", result, progress, &|suns, tile, statistics| {
            self.gather(suns, tile, progress, statistics)
        })
    }

    pub(super) fn run_facade(&self, points: &[FacadePoint], result: &mut PaneSun, progress: &dyn Progress) -> Result<()> {
        self.over_tiles(points, "suns on the façade", result, progress, &|suns, tile, statistics| {
            Ok([self.facade(suns, tile, self.options.batches as usize, statistics)?, Vec::new()])
        })
    }

    #[allow(clippy::type_complexity, reason = "one function")]
    fn over_tiles<T: bytemuck::NoUninit>(
        &self,
        records: &[T],
        what: &str,
        result: &mut PaneSun,
        progress: &dyn Progress,
        light: &dyn Fn(&SunsAtPanes, &Tile<'_>, &mut TraceStatistics) -> Result<[Vec<f32>; 2]>,
    ) -> Result<()> {
        let suns = self.chunks_of_suns()?;
        let rows = self.tiles(records.len(), suns.rows_per_chunk())?;
        let steps = (self.active.len() * records.len()).max(1) as f64;
        let mut done = 0usize;
        for sun_chunk in suns.chunks() {
            let at_panes = self.suns_at_panes(sun_chunk.first, sun_chunk.count, &mut result.statistics)?;
            for chunk in rows.chunks() {
                progress.update(what, done as f64 / steps);
                if progress.stop_requested() {
                    return Err(cancelled());
                }
                let buffer = self.device.upload("receivers", &records[chunk.first..chunk.first + chunk.count])?;
                let tile = Tile { receivers: &buffer, count: chunk.count, batch_stride: 0 };
                let parts = light(&at_panes, &tile, &mut result.statistics)?;
                self.collect(&parts, chunk.first, chunk.count, sun_chunk.first, sun_chunk.count, result);
                done += chunk.count * sun_chunk.count;
            }
        }
        progress.update(what, 1.0);
        Ok(())
    }

    /// Means and standard errors of a tile's batches, `[batch][sun][row][rgb]`.
    fn collect(&self, parts: &[Vec<f32>; 2], first: usize, rows: usize, first_sun: usize, suns: usize, result: &mut PaneSun) {
        let batches = self.options.batches as usize;
        let mut values = vec![0.0; batches];
        for sun in 0..suns {
            let column = self.active[first_sun + sun];
            for row in 0..rows {
                for c in 0..3 {
                    let cell = |batch: usize| ((batch * suns + sun) * rows + row) * 3 + c;
                    let part = |k: usize, batch: usize| parts[k].get(cell(batch)).copied().map_or(0.0, f64::from);
                    let mut clear = 0.0;
                    for (batch, value) in values.iter_mut().enumerate() {
                        clear += part(1, batch) / batches as f64;
                        *value = part(0, batch) + part(1, batch);
                    }
                    let (mean, error) = mean_and_error(&values);
                    result.total.at_mut(first + row, column)[c] = mean as f32;
                    result.clear.at_mut(first + row, column)[c] = clear as f32;
                    result.standard_error.at_mut(first + row, column)[c] = error as f32;
                }
            }
        }
    }
}

/// Cells of one dispatch of it. Mesa's lavapipe ends all loops of an invocation after 65,535 turns; a cell
/// takes at most 65 points × (4 suns × 54 steps down a tree of 2⁹ cells + 10 rings) = 14,700.
const GATHERED_CELLS: u32 = 4;
/// Most rows of a tile: dispatches have no more than 65535 workgroups along an axis.
const MOST_ROWS: usize = 1 << 14;
