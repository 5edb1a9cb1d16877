//! What suns bring through panes that scatter: to receivers, and to the panes themselves as an eye sees them.

use super::tables::{GATHERED_SUNS, NUMBERS, Pane, PaneCell, PaneSun, PaneTables};
use crate::error::Result;
use crate::gpu::{Buffer, Declared, Kernel, Plan, Shader};
use crate::gpu_struct;
use crate::kernels::bsdf_scattering;
use crate::kernels::light_paths::Receiver;
use crate::kernels::sun_matrix::links::{Points, links};
use crate::kernels::sun_matrix::result::{SunMatrix, mean_and_variance};
use crate::kernels::sun_matrix::tracer::{STRUCTS, SunRecord, SunTracer, SunVertex, Tile};
use crate::kernels::trace::{self, TraceStatistics, stream_seed, unit};
use crate::progress::{Progress, cancelled};
use glam::Vec3;
use std::ops::Range;

gpu_struct! {
    /// Parameters of the pane kernels (`sun_matrix/pane.wgsl`).
    pub(crate) struct PaneParams {
        seed: u32,
        receivers: u32,
        suns: u32,
        /// Cells of the panes, or points, per batch.
        cells: u32,
        batches: u32,
        panes: u32,
        /// Directions to a sun's disc per point.
        disc_samples: u32,
        /// Cells that one dispatch takes of each batch where light is gathered.
        first_cell: u32,
        end_cell: u32,
        /// Receivers from one batch to the next; 0 if all batches share them.
        batch_stride: u32,
        /// Size of a part of a cell seen from the receiver, radians.
        part_angle: f32,
        /// Of what passes between receivers and cells.
        components: u32,
    }
}

gpu_struct! {
    /// A point of a pane.
    pub(crate) struct PanePoint {
        position: [f32; 3],
        /// Beyond all panes: no point.
        pane: u32,
        /// Towards the eye that sees it, unit length; 0 if none does.
        outgoing: [f32; 3],
        number: u32,
    }
}

gpu_struct! {
    /// A sun as a point of a pane sees it.
    pub(crate) struct PaneEnd {
        /// What evaluation needs to know of the incident direction.
        key: [f32; 2],
        /// x and y of the direction of travel in the pane's frame.
        direction: [f32; 2],
        /// Cosine times solid angle times transmittance of the way and tint of the pane, 0 if nothing arrives; by way of
        /// the pane towards an eye if there is one.
        pub strength: [f32; 3],
        padding: u32,
    }
}

/// Cells of one dispatch of it. Mesa's lavapipe ends all loops of an invocation after 65,535 turns; a cell
/// takes at most 65 points × (4 suns × 54 steps down a tree of 2⁹ cells + 10 rings) = 14,700.
const GATHERED_CELLS: u32 = 4;
/// Most receivers of a tile: bounds the time of a dispatch.
const MOST_ROWS: usize = 1 << 14;

/// Shaders of this module, for the tests.
pub(in super::super) fn registered() -> Vec<Shader> {
    vec![SUNS, GATHER]
}

const OF_PANES: &[Declared] = &[
    PaneParams::DECLARED,
    Pane::DECLARED,
    Pane::OF_WORDS,
    PaneSun::DECLARED,
    PaneSun::OF_WORDS,
    PaneCell::DECLARED,
    PanePoint::DECLARED,
    PaneEnd::DECLARED,
];
const SUNS: Shader = trace::shader("sun_matrix/pane_suns", &[bsdf_scattering::NUMBERS, NUMBERS, STRUCTS, OF_PANES]);
const GATHER: Shader = trace::shader("sun_matrix/pane_gather", &[bsdf_scattering::NUMBERS, NUMBERS, STRUCTS, OF_PANES]);

/// The panes on the device.
pub(in super::super) struct PaneLight<'t, 'd> {
    tracer: &'t SunTracer<'d>,
    tables: &'t PaneTables,
    cells: Buffer,
    words: Buffer,
    /// Points of the cells, where their light is followed: for suns, and for receivers.
    points: Buffer,
    vertices: Buffer,
}

/// Some of the suns that can reach a pane, and what they bring to the cells.
pub(in super::super) struct SunsAtPanes {
    suns: Buffer,
    /// The panes, and what they are to the suns.
    panes: Buffer,
    /// `[sun][batch][cell]`
    ends: Buffer,
    count: usize,
}

impl<'t, 'd> PaneLight<'t, 'd> {
    /// Nothing if no pane scatters.
    pub fn new(tracer: &'t SunTracer<'d>) -> Result<Option<Self>> {
        let Some(tables) = tracer.panes.as_ref().filter(|p| !p.cells.is_empty()) else { return Ok(None) };
        let per_batch = (tables.cells.len() / tracer.options.batches as usize) as u32;
        let point = |(i, c): (usize, &PaneCell)| PanePoint {
            position: c.position,
            pane: c.pane,
            number: i as u32 % per_batch,
            ..PanePoint::default()
        };
        let vertex = |c: &PaneCell| {
            let z = tables.panes[c.pane as usize].z;
            let [position, corner, edge1, edge2] = [c.position, c.corner, c.edge1, c.edge2].map(Vec3::from);
            let reach = [corner, corner + edge1, corner + edge2].map(|p| p.distance(position)).into_iter().fold(0.0, f32::max);
            // Off what stands in the pane's own plane.
            let margin = 1e-5 * (position.abs().max_element() + 0.5);
            SunVertex { position: (position + Vec3::from(z) * margin).to_array(), facing: z, reach, ..SunVertex::default() }
        };
        let points: Vec<PanePoint> = tables.cells.iter().enumerate().map(point).collect();
        let device = tracer.device;
        Ok(Some(Self {
            cells: device.upload("cells of the panes", &tables.cells)?,
            words: device.upload("BSDFs", tables.words.words())?,
            points: device.upload("points of the cells", &points)?,
            vertices: device.upload("points of the cells", &tables.cells.iter().map(vertex).collect::<Vec<_>>())?,
            tracer,
            tables,
        }))
    }

    fn params(&self, receivers: usize, suns: usize, batch_stride: u32) -> PaneParams {
        let o = &self.tracer.options;
        PaneParams {
            seed: stream_seed(o.seed, 0, 0x7061_6e65),
            receivers: receivers as u32,
            suns: suns as u32,
            cells: (self.tables.cells.len() / o.batches as usize) as u32,
            batches: o.batches,
            panes: self.tables.panes.len() as u32,
            disc_samples: 1,
            batch_stride,
            part_angle: o.part_angle,
            ..PaneParams::default()
        }
    }

    /// The suns that can reach a pane, in chunks that fit memory.
    pub(crate) fn chunks_of_suns(&self) -> Result<Plan> {
        let bytes = (self.tables.cells.len() * size_of::<PaneEnd>()) as u64;
        Plan::new(self.tracer.device, self.tracer.options.memory / 2, self.tables.active.len(), &[bytes], &[], 1)
    }

    /// Some of the suns that can reach a pane.
    pub(crate) fn active(&self, first: usize, count: usize) -> &[usize] {
        &self.tables.active[first..first + count]
    }

    /// Tiles of receivers that fit memory beside so many suns, with so many points of panes each and batch.
    pub fn tiles(&self, receivers: usize, suns: usize, points: usize) -> Result<Plan> {
        let links = (self.tables.cells.len() * 12) as u64;
        let cells = (suns * self.tracer.options.batches as usize) as u64;
        let bytes = [links, cells * 12, cells * 12, cells * (points * size_of::<PaneEnd>()) as u64];
        Ok(Plan::new(self.tracer.device, self.tracer.options.memory / 2, receivers, &bytes, &[], 1)?.at_most(MOST_ROWS))
    }

    /// What `count` of the suns that can reach a pane, from number `first` of them on, bring to the cells.
    pub(crate) fn suns_at_cells(&self, first: usize, count: usize, statistics: &mut TraceStatistics) -> Result<SunsAtPanes> {
        let (device, panes) = (self.tracer.device, self.tables.panes.len());
        let active = self.active(first, count);
        let records: Vec<SunRecord> = active.iter().map(|i| self.tracer.records[*i]).collect();
        let of_panes: Vec<PaneSun> = active.iter().flat_map(|i| &self.tables.suns[i * panes..(i + 1) * panes]).copied().collect();
        let suns = device.upload("suns", &records)?;
        let tables = [bytemuck::cast_slice(&self.tables.panes), bytemuck::cast_slice(&of_panes)];
        let panes = device.upload_tables("panes and their suns", &tables)?;
        let ends = self.ends(&self.params(0, count, 0), &self.points, [&suns, &panes], statistics)?;
        Ok(SunsAtPanes { suns, panes, ends, count })
    }

    /// What suns bring to points of panes, `[sun][batch][point]`.
    fn ends(&self, params: &PaneParams, points: &Buffer, [suns, panes]: [&Buffer; 2], statistics: &mut TraceStatistics) -> Result<Buffer> {
        let device = self.tracer.device;
        let all = (params.suns * params.batches * params.cells) as usize;
        let ends = device.zeros::<PaneEnd>("suns at points of panes", all)?;
        let params = device.uniform("parameters", params)?;
        let own =
            [("params", &params), ("suns", suns), ("pane_words", panes), ("points", points), ("ends", &ends), ("bsdf_words", &self.words)];
        self.tracer.run(&self.tracer.kernel(&SUNS, &[])?, &own, all as u64, statistics)?;
        Ok(ends)
    }

    /// Scattered light that receivers get, `[batch][sun][receiver][rgb]`.
    pub fn gather(
        &self,
        suns: &SunsAtPanes,
        tile: &Tile<'_>,
        progress: &dyn Progress,
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<f32>> {
        let (device, count, all) = (self.tracer.device, tile.count(), self.tables.cells.len());
        let mut params = self.params(count, suns.count, tile.batch_stride);
        let batches = params.batches as usize;
        let batch = Some([params.cells as usize, tile.batch_stride as usize]);
        let points = Points { vertices: &self.vertices, count: all, slots: 1, batch, of_panes: true };
        let links = links(self.tracer, tile.receivers, count, points, statistics)?;
        params.components = self.tracer.components() as u32;
        let sums = device.zeros::<f32>("sun matrix", batches * suns.count * count * 3)?;
        let kernel = Kernel::new(device, &GATHER, &[])?;
        while params.end_cell < params.cells {
            params.first_cell = params.end_cell;
            params.end_cell = (params.first_cell + GATHERED_CELLS).min(params.cells);
            let params = device.uniform("parameters", &params)?;
            let own = [
                ("params", &params),
                ("pane_words", &suns.panes),
                ("cells", &self.cells),
                ("links", &links),
                ("receivers", tile.receivers),
                ("sun_ends", &suns.ends),
                ("bsdf_words", &self.words),
                ("sums", &sums),
            ];
            self.tracer.run_alone(&kernel, &own, (count * suns.count.div_ceil(GATHERED_SUNS as usize) * batches) as u64, statistics)?;
            if progress.stop_requested() {
                return Err(cancelled());
            }
        }
        device.read_finite(&sums)
    }

    /// Radiance of points of panes towards an eye ([`PanePoint`]s, `count` in each of so many batches),
    /// `[sun][batch][point]`.
    pub fn facade(
        &self,
        suns: &SunsAtPanes,
        points: &Buffer,
        [count, batches]: [usize; 2],
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<PaneEnd>> {
        let params = PaneParams {
            cells: count as u32,
            batches: batches as u32,
            disc_samples: self.tracer.options.disc_samples,
            ..self.params(0, suns.count, count as u32)
        };
        self.tracer.device.read(&self.ends(&params, points, [&suns.suns, &suns.panes], statistics)?)
    }

    /// Adds what receivers get to a result, whose rows they are, and the work to what was done before.
    pub fn add(
        &self,
        receivers: &[Receiver],
        mut state: (SunMatrix, TraceStatistics),
        progress: &dyn Progress,
    ) -> Result<(SunMatrix, TraceStatistics)> {
        let suns = self.chunks_of_suns()?;
        let rows = self.tiles(receivers.len(), suns.rows_per_chunk(), 0)?;
        let steps = (self.tables.active.len() * receivers.len()).max(1) as f64;
        let mut done = 0usize;
        for sun_chunk in suns.chunks() {
            let at_cells = self.suns_at_cells(sun_chunk.first, sun_chunk.count, &mut state.1)?;
            for chunk in rows.chunks() {
                progress.update("sun matrix through panes", done as f64 / steps);
                if progress.stop_requested() {
                    return Err(cancelled());
                }
                let range = chunk.first..chunk.first + chunk.count;
                let columns = self.active(sun_chunk.first, sun_chunk.count);
                let mut make = |(result, statistics): &mut (SunMatrix, TraceStatistics)| {
                    self.add_tile(receivers, range.clone(), (&at_cells, columns), result, progress, statistics)
                };
                let name = format!("panes, sensors {range:?}, suns from {}", sun_chunk.first);
                unit(progress, &name, &mut state, &mut make, &|(result, statistics), values| {
                    values.pass_work(statistics)?;
                    result.pass(&range.clone().collect::<Vec<_>>(), values)
                })?;
                done += chunk.count * sun_chunk.count;
            }
        }
        Ok(state)
    }

    /// Adds what some of the receivers get of the suns of these columns.
    fn add_tile(
        &self,
        receivers: &[Receiver],
        range: Range<usize>,
        (suns, columns): (&SunsAtPanes, &[usize]),
        result: &mut SunMatrix,
        progress: &dyn Progress,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let batches = self.tracer.options.batches as usize;
        let (first, count) = (range.start, range.len());
        let some = &receivers[range];
        let numbers: Vec<u32> = some.iter().map(|r| r.number).collect();
        let buffer = self.tracer.device.upload("receivers", some)?;
        let tile = Tile { receivers: &buffer, numbers: &numbers, batch_stride: 0 };
        let sums = self.gather(suns, &tile, progress, statistics)?;
        for (sun, column) in columns.iter().enumerate() {
            for row in 0..count {
                for c in 0..3 {
                    let value = |batch: usize| sums[((batch * suns.count + sun) * count + row) * 3 + c];
                    let [mean, variance] = mean_and_variance((0..batches).map(|b| f64::from(value(b))));
                    result.add_scattered(first + row, *column, c, mean, [0.0, variance]);
                }
            }
        }
        Ok(())
    }
}
