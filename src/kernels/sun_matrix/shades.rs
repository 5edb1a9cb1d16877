//! Light that surfaces scatter, by points that all receivers share: C = G·L.
//!
//! `L[point][sun]` is the radiance that a point sends to its front for a sun of radiance 1, directly and by
//! a path from the point to what lights it in turn; `G[receiver][point]` what the receiver gets of it, a
//! ray each, cosines over squared distance times the area that the point stands for. Rays are points ×
//! suns and receivers × points, where paths of each receiver's own cost receivers × vertices × suns.
//!
//! Points lie in cells of the surfaces, drawn by how much receivers see of a cell and how bright suns
//! make it; a first look tells both and costs a few rays a cell. Every batch and set has points of its own,
//! evenly spread; suns take turns in the sets. Only what a receiver sees reflected in panes comes by
//! paths of its own.

use super::links::{Points, links};
use super::options::{ScatteredBy, SunOptions};
use super::paths::{self, Gathered, Lists, VertexList};
use super::result::{Hits, SunMatrix, mean_and_variance};
use super::shade_cells::{self, Cells, ShadeCell, strided};
use super::shade_sums::{Sums, add_light, mean_of_open};
use super::tracer::{MOST_PAIRS, STRUCTS, SunTracer, SunVertex, Tile};
use crate::error::Result;
use crate::gpu::{Buffer, Kernel, Plan, Shader, allowed};
use crate::gpu_struct;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{self, TraceStatistics, stream_seed, unit};
use crate::progress::{Progress, cancelled};
use rayon::prelude::*;

gpu_struct! {
    /// Parameters of `sun_matrix/shade_points`.
    pub(crate) struct ShadePointParams {
        seed: u32,
        first: u32,
        count: u32,
        points: u32,
        cells: u32,
        most_vertices: u32,
        roulette_weight: f32,
        each_cell: u32,
        paths: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

/// Points for each path that a receiver would have of its own, at most.
const MOST_POINTS: f64 = 16.0;
/// Paths from each point to what lights it.
const PATHS: u32 = 2;
/// Pairs of sun and path of receivers that are done before a first look at the shades would be.
const LEAST_PAIRS: f64 = 1e6;
/// Receivers and suns of the first look.
const FIRST_LOOK: usize = 16;
/// Cells that it looks at, at most.
const MOST_LOOKED_AT: usize = 4096;
/// Vertices of one list: some drivers end long loops.
const MOST_LISTED: usize = 256;

pub(super) const POINTS: Shader =
    trace::shader("sun_matrix/shade_points", &[shade_cells::NUMBERS, STRUCTS, &[ShadePointParams::DECLARED, ShadeCell::DECLARED]]);

/// Points that receivers share.
pub(super) struct Shades<'t, 'd> {
    tracer: &'t SunTracer<'d>,
    cells: Cells,
    /// Of each set and batch.
    points: u32,
}

impl<'t, 'd> Shades<'t, 'd> {
    /// Points for those of the receivers that can do with them, and which these are. Nothing if there are
    /// none, or too few to be worth it.
    pub fn choose(tracer: &'t SunTracer<'d>, receivers: &[Receiver]) -> Result<Option<(Self, Vec<bool>)>> {
        let o = &tracer.options;
        if !tracer.scatters() || o.scattered_by == ScatteredBy::Paths || receivers.is_empty() || !tracer.images.is_empty() {
            return Ok(None);
        }
        let forced = o.scattered_by == ScatteredBy::Points;
        let points = points(o, receivers.len(), tracer.sun_count);
        let pairs = receivers.len() as f64 * f64::from(o.paths) * f64::from(o.batches) * tracer.sun_count as f64;
        if !forced && (points < o.paths || pairs < LEAST_PAIRS) {
            return Ok(None);
        }
        let Some(mut cells) = Cells::of(&tracer.tables) else { return Ok(None) };
        let points = if forced { points.max(o.paths.next_power_of_two()) } else { points };
        let suited = cells.choose(receivers, if forced { f64::INFINITY } else { f64::from(points) / f64::from(o.paths) });
        let count = suited.iter().filter(|s| **s).count();
        if cells.len() == 0 || count < if forced { 1 } else { receivers.len().div_ceil(2) } {
            return Ok(None);
        }
        Ok(Some((Self { cells, points, tracer }, suited)))
    }

    fn sets(&self) -> usize {
        self.tracer.options.path_sets as usize
    }

    /// Suns of a set.
    fn suns(&self) -> usize {
        self.tracer.sun_count.div_ceil(self.sets())
    }

    /// Paths from each point.
    fn paths(&self) -> u32 {
        if self.tracer.options.most_vertices() > 1 { PATHS } else { 1 }
    }

    /// Vertices of each path and each point.
    fn path_slots(&self) -> usize {
        self.tracer.options.most_vertices() as usize
    }

    fn slots(&self) -> usize {
        self.path_slots() * self.paths() as usize
    }

    /// Adds what the receivers of these rows get to a result.
    pub fn light(
        &self,
        rows: &[usize],
        receivers: &[Receiver],
        result: &mut SunMatrix,
        progress: &dyn Progress,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let (o, device, sets) = (&self.tracer.options, self.tracer.device, self.sets());
        let probabilities = self.first_look(receivers, statistics)?;
        let cells = device.upload("cells of shades", &self.cells.records(&probabilities, self.points))?;
        let row = (self.tracer.components() + 1) * self.suns();
        let batches = o.batches as usize;
        let most = (usize::try_from(allowed(o.memory)).unwrap_or(usize::MAX) / (batches * sets * row * 4).max(1)).max(1);
        let steps = (batches * receivers.len().div_ceil(most)) as f64;
        for (tile, (some, rows)) in receivers.chunks(most).zip(rows.chunks(most)).enumerate() {
            let values = vec![0.0; batches * some.len() * sets * row];
            let sums = Sums { values, open: vec![[0.0; 2]; some.len() * sets], receivers: some.len(), sets, row };
            let mut state = (sums, *statistics);
            for batch in 0..batches {
                progress.update("light of shades", (tile * batches + batch) as f64 / steps);
                if progress.stop_requested() {
                    return Err(cancelled());
                }
                let mut make = |(sums, statistics): &mut (Sums, TraceStatistics)| self.add_points(some, &cells, batch, sums, statistics);
                unit(progress, &format!("shades, tile {tile}, batch {batch}"), &mut state, &mut make, &|(sums, statistics), values| {
                    values.pass_work(statistics)?;
                    values.pass(sums.of(batch))?;
                    values.pass(&mut sums.open)
                })?;
            }
            if self.tracer.tables.features.glass {
                let mut make = |(sums, statistics): &mut (Sums, TraceStatistics)| self.add_reflected(some, sums, statistics);
                unit(progress, &format!("shades in panes, tile {tile}"), &mut state, &mut make, &|(sums, statistics), values| {
                    values.pass_work(statistics)?;
                    values.pass(&mut sums.values)
                })?;
            }
            let sums = state.0;
            *statistics = state.1;
            self.reduce(&sums, rows, result);
        }
        Ok(())
    }

    /// Probabilities of the cells: what some receivers see of a point in each, times its light of some suns.
    fn first_look(&self, receivers: &[Receiver], statistics: &mut TraceStatistics) -> Result<Vec<f64>> {
        let step = self.cells.len().div_ceil(MOST_LOOKED_AT);
        let looking: Vec<Receiver> = strided(receivers.len(), FIRST_LOOK).map(|r| receivers[r]).collect();
        let stride = self.tracer.sun_count.div_ceil(FIRST_LOOK).max(1);
        let suns = self.tracer.sun_count.div_ceil(stride);
        let records = self.cells.samples(step);
        let cells = records.len();
        let seed = stream_seed(self.tracer.options.seed, 0, 0x7375_6e66);
        let params = ShadePointParams { seed, points: cells as u32, count: cells as u32, each_cell: 1, ..self.point_params() };
        let vertices = self.place(&self.tracer.device.upload("cells of shades", &records)?, params, statistics)?;
        let links = self.links(&looking, &vertices, cells, statistics)?;
        let lists: Vec<VertexList> = (0..cells).map(|i| self.list(i, i)).collect();
        let light = self.gather(&lists, &vertices, [suns, stride], seed, statistics)?;
        let n = self.tracer.components();
        // What is seen of each, and what would be if nothing were in the way.
        let mut open = vec![[0.0; 2]; cells];
        for (r, receiver) in looking.iter().enumerate() {
            let seen = self.cells.seen_by(receiver, step);
            let whole = seen.iter().sum::<f64>().max(1e-30);
            for (i, (open, seen)) in open.iter_mut().zip(seen).enumerate() {
                let link = &links[(i * looking.len() + r) * n..][..n];
                open[0] += link.iter().map(|v| f64::from(*v)).sum::<f64>() / n as f64 / whole;
                open[1] += seen / whole;
            }
        }
        let square = |values: &[f32]| values.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>() / (n * suns) as f64;
        let bright: Vec<f64> = (0..cells).map(|i| square(&light.list(i)[..n * suns]).sqrt()).collect();
        Ok(self.cells.after_look(step, &open, &bright))
    }

    /// Paths of a point at this place in memory.
    fn list(&self, place: usize, number: usize) -> VertexList {
        let paths = self.paths();
        VertexList { first: (place * self.slots()) as u32, paths, index: number as u32 * paths, ..VertexList::default() }
    }

    fn point_params(&self) -> ShadePointParams {
        let o = &self.tracer.options;
        ShadePointParams {
            seed: stream_seed(o.seed, 0, 0x7375_6e73),
            first: 0,
            count: 0,
            points: self.points,
            cells: self.cells.len() as u32,
            most_vertices: o.most_vertices(),
            roulette_weight: o.roulette_weight,
            each_cell: 0,
            paths: self.paths(),
            ..Default::default()
        }
    }

    /// Points and what lights them.
    fn place(&self, cells: &Buffer, params: ShadePointParams, statistics: &mut TraceStatistics) -> Result<Buffer> {
        let device = self.tracer.device;
        let vertices = device.zeros::<SunVertex>("points of shades", params.count as usize * self.slots())?;
        let uniform = device.uniform("points of shades", &params)?;
        let own = [("params", &uniform), ("cells", cells), ("vertices", &vertices)];
        let kernel = Kernel::new(device, &POINTS, &[])?;
        self.tracer.run(&kernel, &own, u64::from(params.count * params.paths), statistics)?;
        Ok(vertices)
    }

    /// G of these points, `[point][receiver][component]`.
    fn links(&self, receivers: &[Receiver], vertices: &Buffer, count: usize, statistics: &mut TraceStatistics) -> Result<Vec<f32>> {
        let device = self.tracer.device;
        let buffer = device.upload("receivers of suns", receivers)?;
        let points = Points { vertices, count, slots: self.slots(), batch: None, of_panes: false };
        device.read_finite(&links(self.tracer, &buffer, receivers.len(), points, statistics)?)
    }

    /// Light of every list for its suns.
    fn gather(
        &self,
        lists: &[VertexList],
        vertices: &Buffer,
        [suns, stride]: [usize; 2],
        seed: u32,
        statistics: &mut TraceStatistics,
    ) -> Result<Gathered> {
        let how = Lists { path_slots: self.path_slots(), suns, stride, seed, lists_first: false };
        paths::gather(self.tracer, lists, vertices, how, None, statistics)
    }

    /// G·L of one batch.
    fn add_points(
        &self,
        receivers: &[Receiver],
        cells: &Buffer,
        batch: usize,
        sums: &mut Sums,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let (o, sets, suns) = (&self.tracer.options, self.sets(), self.suns());
        let (points, n) = (self.points as usize, self.tracer.components());
        let seed = stream_seed(o.seed, 0, 0x7375_6e74);
        let sizes = [self.slots() * 64, suns * (n + 4) * 4, receivers.len() * n * 4, 32].map(|v| v as u64);
        let most = (MOST_PAIRS / suns.max(1)).min(8 * MOST_PAIRS / receivers.len()).clamp(1, 1 << 15);
        for chunk in Plan::new(self.tracer.device, o.memory, points * sets, &sizes, &[], 1)?.at_most(most).chunks() {
            let first = (batch * sets * points + chunk.first) as u32;
            let params = ShadePointParams { first, count: chunk.count as u32, ..self.point_params() };
            let vertices = self.place(cells, params, statistics)?;
            let links = self.links(receivers, &vertices, chunk.count, statistics)?;
            // Points that nobody sees need no light.
            let seen: Vec<usize> =
                (0..chunk.count).filter(|i| links[i * receivers.len() * n..][..receivers.len() * n].iter().any(|v| *v > 0.0)).collect();
            if seen.is_empty() {
                continue;
            }
            let list = |i: &usize| {
                let number = chunk.first + i;
                VertexList { first_sun: (number / points) as u32, stream: batch as u32, ..self.list(*i, number % points) }
            };
            let lists: Vec<VertexList> = seen.iter().map(list).collect();
            let light = self.gather(&lists, &vertices, [suns, sets], seed, statistics)?;
            // What a point would bring of a sun that it faces, if nothing hid the sun.
            let bright: Vec<f64> = (0..lists.len()).map(|i| mean_of_open(&light.list(i)[(n + 2) * suns..][..suns])).collect();
            let (row, receiver_count) = (sums.row, receivers.len());
            let size = receiver_count * sets * row;
            let values = sums.values[batch * size..][..size].par_chunks_mut(sets * row);
            values.zip(sums.open.par_chunks_mut(sets)).enumerate().for_each(|(r, (values, open))| {
                for (k, (i, list)) in seen.iter().zip(&lists).enumerate() {
                    let set = list.first_sun as usize;
                    let link = &links[(i * receiver_count + r) * n..][..n];
                    let most = link.iter().fold(0.0f32, |a, b| a.max(*b));
                    if most > 0.0 {
                        add_light(&mut values[set * row..][..row], link, light.list(k), suns);
                        open[set] = [open[set][0] + f64::from(most) * bright[k], open[set][1] + 1.0];
                    }
                }
            });
        }
        Ok(())
    }

    /// What receivers see of the surfaces in panes, by paths of their own.
    fn add_reflected(&self, receivers: &[Receiver], sums: &mut Sums, statistics: &mut TraceStatistics) -> Result<()> {
        let (o, sets, suns, device) = (&self.tracer.options, self.sets(), self.suns(), self.tracer.device);
        let (batches, n, row) = (o.batches as usize, self.tracer.components(), sums.row);
        let slots = o.paths as usize * self.path_slots();
        let bytes = [batches * sets * slots * 64, batches * sets * (n + 4) * suns * 4].map(|v| v as u64);
        let most = (MOST_PAIRS / (self.tracer.sun_count * batches).max(1)).clamp(1, 1 << 15);
        let seed = stream_seed(o.seed, 0, 0x7375_6e75);
        for chunk in Plan::new(device, o.memory, receivers.len(), &bytes, &[], 1)?.at_most(most).chunks() {
            let some = &receivers[chunk.first..][..chunk.count];
            let numbers: Vec<u32> = some.iter().map(|r| r.number).collect();
            let buffer = device.upload("receivers of suns", some)?;
            let tile = Tile { receivers: &buffer, numbers: &numbers, batch_stride: 0 };
            let all = device.read::<SunVertex>(&paths::start(self.tracer, &tile, true, statistics)?)?;
            let (mut kept, mut lists, mut groups_seen) = (Vec::new(), Vec::new(), Vec::new());
            for (group, of_group) in all.chunks_exact(slots).enumerate() {
                let first = kept.len();
                kept.extend(of_group.chunks_exact(self.path_slots()).flat_map(|path| path.iter().take_while(|v| v.material > 0)).copied());
                let number = numbers[group / sets % chunk.count];
                for part in (first..kept.len()).step_by(MOST_LISTED) {
                    groups_seen.push(group);
                    // Each vertex by itself.
                    lists.push(VertexList {
                        first: part as u32,
                        paths: (kept.len() - part).min(MOST_LISTED) as u32,
                        first_sun: (group % sets) as u32,
                        stream: stream_seed(number, (group / sets / chunk.count) as u32, 0x7375_6e6c),
                        index: (part - first) as u32,
                        ..VertexList::default()
                    });
                }
            }
            if kept.is_empty() {
                continue;
            }
            let how = Lists { path_slots: 1, suns, stride: sets, seed, lists_first: false };
            let light = paths::gather(self.tracer, &lists, &device.upload("vertices seen in panes", &kept)?, how, None, statistics)?;
            for (i, group) in groups_seen.iter().enumerate() {
                let (batch, receiver) = (group / sets / chunk.count, chunk.first + group / sets % chunk.count);
                let own = &mut sums.of(batch)[(receiver * sets + group % sets) * row..][..n * suns];
                own.iter_mut().zip(light.list(i)).for_each(|(sum, v)| *sum += v);
            }
        }
        Ok(())
    }

    /// Means over the batches and their variances.
    fn reduce(&self, sums: &Sums, rows: &[usize], result: &mut SunMatrix) {
        let (sets, suns, batches, n) = (self.sets(), self.suns(), self.tracer.options.batches as usize, self.tracer.components());
        let size = sums.receivers * sets * sums.row;
        for (receiver, &row) in rows.iter().enumerate() {
            for sun in 0..self.tracer.sun_count {
                let group = receiver * sets + sun % sets;
                let values = |part: usize| {
                    let cell = group * sums.row + part * suns + sun / sets;
                    (0..batches).map(move |b| f64::from(sums.values[b * size + cell]))
                };
                let [open, looks] = sums.open[group];
                let light = (0..n).map(|c| values(c).sum()).fold(0.0, f64::max);
                let hits = Hits { found: values(n).sum(), looks, light, unseen: open / looks.max(1.0) };
                let [own, shared] = hits.doubts(batches);
                for c in 0..3 {
                    let [mean, variance] = mean_and_variance(values(if n == 1 { 0 } else { c }));
                    result.add_scattered(row, sun, c, mean, [own, variance + shared]);
                }
            }
        }
    }
}

/// Points of each set and batch: so many that they cost no more than paths of so many receivers would. A point
/// needs about two rays to each sun of its set and one to every other receiver, a path one to each sun.
fn points(options: &SunOptions, receivers: usize, suns: usize) -> u32 {
    let (receivers, suns) = (receivers as f64, suns as f64);
    let of_point = 2.0 * suns + 0.5 * f64::from(options.path_sets) * receivers;
    let most = f64::from(options.paths) * (receivers * suns / of_point.max(1.0)).min(MOST_POINTS);
    1 << (most.max(1.0).log2() as u32).min(20)
}
