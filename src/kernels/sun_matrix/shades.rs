//! Light that surfaces scatter, by points that all receivers share: C = G·L.
//!
//! `L[point][sun]` is the radiance that a point sends to its front for a sun of radiance 1, straight and by
//! a path from the point to what lights it in turn; `G[receiver][point]` what the receiver gets of it, a
//! ray each, cosines over squared distance times the area that the point stands for. Rays are points ×
//! suns and receivers × points, where paths of each receiver's own cost receivers × vertices × suns.
//!
//! Points lie in cells of the surfaces, drawn by how much receivers see of a cell and how bright suns
//! make it; a first look tells both and costs a few rays a cell. Every batch and set has points of its own,
//! evenly spread; suns take turns in the sets. Only what a receiver sees reflected in panes comes by
//! paths of its own.

use super::geometry::{ScatteredBy, SunOptions};
use super::shade_cells::{self, Cells, ShadeCell, strided};
use super::tracer::{SunRecord, SunTracer, SunVertex, VERTICES, mean_and_variance};
use crate::error::Result;
use crate::gpu::{Buffer, Kernel, Plan, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{self, TraceStatistics, stream_seed};
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use rayon::prelude::*;

gpu_struct! {
    /// Parameters of `trace/sun_shade_points`.
    pub(crate) struct ShadePointParams {
        seed: u32,
        /// The points of this dispatch: point `first + i` of all sets in a row is number `(first + i) % points`
        /// of its set.
        first: u32,
        count: u32,
        points: u32,
        cells: u32,
        /// Slots per path, the point itself counted.
        most_vertices: u32,
        /// Share of its first weight below which roulette ends a path.
        roulette_weight: f32,
        /// Whether point i lies in cell i, instead of where chance wants it.
        each_cell: u32,
        /// From each point.
        paths: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

gpu_struct! {
    /// Parameters of `trace/sun_shade_links`.
    pub(crate) struct ShadeLinkParams {
        receivers: u32,
        points: u32,
        /// Vertices per point.
        slots: u32,
        /// Windows that light must leave through; from anywhere if there are none.
        window_count: u32,
        components: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

gpu_struct! {
    /// Parameters of `trace/sun_scattered`.
    pub(crate) struct ScatteredParams {
        seed: u32,
        lists: u32,
        /// Suns of each set: numbers `set`, `set + stride` …
        suns: u32,
        stride: u32,
        all_suns: u32,
        components: u32,
        /// Slots per path, which ends with its first vertex without material.
        path_slots: u32,
        padding1: u32,
    }
}

gpu_struct! {
    /// Vertices that a receiver, or a point, gets light from.
    pub(crate) struct VertexList {
        /// Vertices, path by path.
        first: u32,
        count: u32,
        /// Number of its first sun.
        first_sun: u32,
        /// These choose its random numbers: lists of one stream share them out.
        stream: u32,
        index: u32,
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
/// Pairs of one dispatch, which bounds its time.
const MOST_PAIRS: usize = 1 << 20;

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<Shader> {
    vec![POINTS, LINKS, SCATTERED]
}

const POINTS: Shader = trace::shader(
    "trace/sun_shade_points",
    &[shade_cells::NUMBERS, &[ShadePointParams::DECLARED, ShadeCell::DECLARED, SunVertex::DECLARED]],
);
const LINKS: Shader =
    trace::shader("trace/sun_shade_links", &[&[ShadeLinkParams::DECLARED, Receiver::DECLARED, SunVertex::DECLARED, SunRecord::DECLARED]]);
const SCATTERED: Shader =
    trace::shader("trace/sun_scattered", &[&[ScatteredParams::DECLARED, VertexList::DECLARED, SunVertex::DECLARED, SunRecord::DECLARED]]);

/// Points that receivers share.
pub(super) struct Shades<'t, 'd> {
    tracer: &'t SunTracer<'d>,
    cells: Cells,
    /// Of each set and batch.
    points: u32,
    /// 1 if all is grey, or 3.
    components: usize,
    place: Kernel,
    link: Kernel,
    gather: Kernel,
    /// Paths to what is seen in panes, if there are any.
    reflected: Option<Kernel>,
}

/// What a tile of receivers gets, `[batch][receiver][set][component][sun of the set]`.
struct Sums {
    values: Vec<f32>,
    receivers: usize,
    sets: usize,
    row: usize,
}

impl Sums {
    fn of(&mut self, batch: usize) -> &mut [f32] {
        let size = self.receivers * self.sets * self.row;
        &mut self.values[batch * size..][..size]
    }
}

impl<'t, 'd> Shades<'t, 'd> {
    /// Points for those of the receivers that can do with them, and which these are. Nothing if there are
    /// none, or too few to be worth it.
    pub fn choose(tracer: &'t SunTracer<'d>, receivers: &[Receiver]) -> Result<Option<(Self, Vec<bool>)>> {
        let o = &tracer.options;
        if !o.scatters() || o.scattered_by == ScatteredBy::Paths || receivers.is_empty() || tracer.has_images() {
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
        let (device, panes) = (tracer.device, tracer.constants());
        let reflected = [("REFLECTED_ONLY", 1.0)];
        let shades = Self {
            cells,
            points,
            components: if tracer.tables.features.grey { 1 } else { 3 },
            place: Kernel::new(device, &POINTS, &[])?,
            link: Kernel::new(device, &LINKS, &panes)?,
            gather: Kernel::new(device, &SCATTERED, &panes)?,
            reflected: tracer.tables.features.glass.then(|| Kernel::new(device, &VERTICES, &reflected)).transpose()?,
            tracer,
        };
        Ok(Some((shades, suited)))
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

    /// Mean and standard error of what the receivers get, `[receiver][sun]`.
    pub fn light(&self, receivers: &[Receiver], progress: &dyn Progress, statistics: &mut TraceStatistics) -> Result<[Matrix<f32>; 2]> {
        let (o, device, suns) = (&self.tracer.options, self.tracer.device, self.tracer.sun_count);
        let shape = || Matrix::<f32>::zeros(receivers.len(), suns, 3);
        let (mut mean, mut error) = (shape(), shape());
        let probabilities = self.first_look(receivers, statistics)?;
        let cells = device.upload("cells of shades", &self.cells.records(&probabilities, self.points))?;
        let row = self.components * self.suns();
        let batches = o.batches as usize;
        let most = (usize::try_from(o.memory).unwrap_or(usize::MAX) / (batches * self.sets() * row * 4).max(1)).max(1);
        let steps = (batches * receivers.len().div_ceil(most)) as f64;
        for (tile, some) in receivers.chunks(most).enumerate() {
            let length = batches * some.len() * self.sets() * row;
            let mut sums = Sums { values: vec![0.0; length], receivers: some.len(), sets: self.sets(), row };
            for batch in 0..batches {
                progress.update("light of shades", (tile * batches + batch) as f64 / steps);
                if progress.stop_requested() {
                    return Err(cancelled());
                }
                self.add_points(some, &cells, batch, &mut sums, statistics)?;
            }
            if let Some(kernel) = &self.reflected {
                self.add_reflected(kernel, some, &mut sums, statistics)?;
            }
            self.reduce(&sums, tile * most, &mut mean, &mut error);
        }
        Ok([mean, error])
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
        let list =
            |i: usize| VertexList { first: (i * self.slots()) as u32, count: self.slots() as u32, index: i as u32, ..Default::default() };
        let lists: Vec<VertexList> = (0..cells).map(list).collect();
        let light = self.gather(&lists, &vertices, self.path_slots(), [suns, stride], seed, statistics)?;
        let n = self.components;
        // What is seen of each, and what would be if nothing were in the way.
        let mut open = vec![[0.0; 2]; cells];
        for (receiver, links) in looking.iter().zip(links.chunks_exact(cells * n)) {
            let seen = self.cells.seen_by(receiver, step);
            let whole = seen.iter().sum::<f64>().max(1e-30);
            for ((open, link), seen) in open.iter_mut().zip(links.chunks_exact(n)).zip(seen) {
                open[0] += link.iter().map(|v| f64::from(*v)).sum::<f64>() / n as f64 / whole;
                open[1] += seen / whole;
            }
        }
        let square = |values: &[f32]| values.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>() / (n * suns) as f64;
        let bright: Vec<f64> = light.chunks_exact(n * suns).map(|values| square(values).sqrt()).collect();
        Ok(self.cells.after_look(step, &open, &bright))
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
        self.tracer.run(
            &self.place,
            &own,
            [params.count.div_ceil(64), params.paths, 1],
            u64::from(params.count * params.paths),
            statistics,
        )?;
        Ok(vertices)
    }

    /// G of these points, `[receiver][point][component]`.
    fn links(&self, receivers: &[Receiver], vertices: &Buffer, points: usize, statistics: &mut TraceStatistics) -> Result<Vec<f32>> {
        let device = self.tracer.device;
        let links = device.zeros::<f32>("links to shades", receivers.len() * points * self.components)?;
        let params = ShadeLinkParams {
            receivers: receivers.len() as u32,
            points: points as u32,
            slots: self.slots() as u32,
            window_count: self.tracer.window_count,
            components: self.components as u32,
            ..Default::default()
        };
        let params = device.uniform("links to shades", &params)?;
        let receiver_buffer = device.upload("receivers of suns", receivers)?;
        let own = [("params", &params), ("receivers", &receiver_buffer), ("vertices", vertices), ("links", &links)];
        let groups = [(points as u32).div_ceil(64), receivers.len() as u32, 1];
        self.tracer.run(&self.link, &own, groups, (points * receivers.len()) as u64, statistics)?;
        device.read_finite(&links)
    }

    /// Light of every list for its suns, `[list][component][sun]`.
    fn gather(
        &self,
        lists: &[VertexList],
        vertices: &Buffer,
        path_slots: usize,
        [suns, stride]: [usize; 2],
        seed: u32,
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<f32>> {
        let device = self.tracer.device;
        let sums = device.zeros::<f32>("light of shades", lists.len() * suns * self.components)?;
        let params = ScatteredParams {
            seed,
            lists: lists.len() as u32,
            suns: suns as u32,
            stride: stride as u32,
            all_suns: self.tracer.sun_count as u32,
            components: self.components as u32,
            path_slots: path_slots as u32,
            ..Default::default()
        };
        let params = device.uniform("light of shades", &params)?;
        let list_buffer = device.upload("lists of vertices", lists)?;
        let own = [("params", &params), ("lists", &list_buffer), ("vertices", vertices), ("suns", &self.tracer.suns), ("sums", &sums)];
        let groups = [(suns as u32).div_ceil(64), lists.len() as u32, 1];
        self.tracer.run(&self.gather, &own, groups, (suns * lists.len()) as u64, statistics)?;
        device.read_finite(&sums)
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
        let (points, n) = (self.points as usize, self.components);
        let seed = stream_seed(o.seed, 0, 0x7375_6e74);
        let sizes = [self.slots() * 64, suns * n * 4, receivers.len() * n * 4, 32].map(|v| v as u64);
        let most = (MOST_PAIRS / suns.max(1)).min(8 * MOST_PAIRS / receivers.len()).clamp(1, 1 << 15);
        for chunk in Plan::new(self.tracer.device, o.memory, points * sets, &sizes, &[], 1)?.at_most(most).chunks() {
            let first = (batch * sets * points + chunk.first) as u32;
            let params = ShadePointParams { first, count: chunk.count as u32, ..self.point_params() };
            let vertices = self.place(cells, params, statistics)?;
            let links = self.links(receivers, &vertices, chunk.count, statistics)?;
            let list = |i: usize| {
                let number = chunk.first + i;
                VertexList {
                    first: (i * self.slots()) as u32,
                    count: self.slots() as u32,
                    first_sun: (number / points) as u32,
                    stream: batch as u32,
                    index: (number % points) as u32,
                    ..Default::default()
                }
            };
            // Points that nobody sees need no light.
            let mut seen = vec![false; chunk.count];
            for links in links.chunks_exact(chunk.count * n) {
                seen.iter_mut().zip(links.chunks_exact(n)).for_each(|(seen, link)| *seen |= link.iter().any(|v| *v > 0.0));
            }
            let seen: Vec<usize> = (0..chunk.count).filter(|i| seen[*i]).collect();
            if seen.is_empty() {
                continue;
            }
            let lists: Vec<VertexList> = seen.iter().map(|i| list(*i)).collect();
            let light = self.gather(&lists, &vertices, self.path_slots(), [suns, sets], seed, statistics)?;
            let row = n * suns;
            sums.of(batch).par_chunks_mut(sets * row).zip(links.par_chunks(chunk.count * n)).for_each(|(sums, links)| {
                for ((i, light), list) in seen.iter().zip(light.chunks_exact(row)).zip(&lists) {
                    add_light(&mut sums[list.first_sun as usize * row..][..row], &links[i * n..][..n], light, suns);
                }
            });
        }
        Ok(())
    }

    /// What receivers see of the surfaces in panes, by paths of their own.
    fn add_reflected(&self, kernel: &Kernel, receivers: &[Receiver], sums: &mut Sums, statistics: &mut TraceStatistics) -> Result<()> {
        let (o, sets, suns, device) = (&self.tracer.options, self.sets(), self.suns(), self.tracer.device);
        let (batches, row) = (o.batches as usize, self.components * suns);
        let slots = o.paths as usize * self.path_slots();
        let bytes = [batches * sets * slots * 64, batches * sets * row * 4].map(|v| v as u64);
        let most = (MOST_PAIRS / (self.tracer.sun_count * batches).max(1)).clamp(1, 1 << 15);
        let seed = stream_seed(o.seed, 0, 0x7375_6e75);
        for chunk in Plan::new(device, o.memory, receivers.len(), &bytes, &[], 1)?.at_most(most).chunks() {
            let some = &receivers[chunk.first..][..chunk.count];
            let groups = batches * chunk.count * sets;
            let buffer = device.upload("receivers of suns", some)?;
            let vertices = device.zeros::<SunVertex>("vertices seen in panes", groups * slots)?;
            self.tracer.start_paths(kernel, &buffer, chunk.count, 0, &vertices, statistics)?;
            let all = device.read::<SunVertex>(&vertices)?;
            let (mut kept, mut lists, mut groups_seen) = (Vec::new(), Vec::new(), Vec::new());
            for (group, of_group) in all.chunks_exact(slots).enumerate() {
                let first = kept.len();
                kept.extend(of_group.chunks_exact(self.path_slots()).flat_map(|path| path.iter().take_while(|v| v.material > 0)).copied());
                let number = some[group / sets % chunk.count].number;
                for (part, first) in (first..kept.len()).step_by(MOST_LISTED).enumerate() {
                    groups_seen.push(group);
                    lists.push(VertexList {
                        first: first as u32,
                        count: (kept.len() - first).min(MOST_LISTED) as u32,
                        first_sun: (group % sets) as u32,
                        stream: (group / sets / chunk.count + part * batches) as u32,
                        index: number,
                        ..Default::default()
                    });
                }
            }
            if kept.is_empty() {
                continue;
            }
            let light = self.gather(&lists, &device.upload("vertices seen in panes", &kept)?, 1, [suns, sets], seed, statistics)?;
            for (group, light) in groups_seen.iter().zip(light.chunks_exact(row)) {
                let (batch, receiver) = (group / sets / chunk.count, chunk.first + group / sets % chunk.count);
                let own = &mut sums.of(batch)[(receiver * sets + group % sets) * row..][..row];
                own.iter_mut().zip(light).for_each(|(sum, v)| *sum += v);
            }
        }
        Ok(())
    }

    /// Means and standard errors over the batches.
    fn reduce(&self, sums: &Sums, first: usize, mean: &mut Matrix<f32>, error: &mut Matrix<f32>) {
        let (sets, suns, batches) = (self.sets(), self.suns(), self.tracer.options.batches as usize);
        let size = sums.receivers * sets * sums.row;
        for receiver in 0..sums.receivers {
            for sun in 0..self.tracer.sun_count {
                for c in 0..3 {
                    let component = if self.components == 1 { 0 } else { c };
                    let cell = (receiver * sets + sun % sets) * sums.row + component * suns + sun / sets;
                    let (value, variance) = mean_and_variance((0..batches).map(|b| f64::from(sums.values[b * size + cell])));
                    mean.at_mut(first + receiver, sun)[c] = value as f32;
                    error.at_mut(first + receiver, sun)[c] = variance.sqrt() as f32;
                }
            }
        }
    }
}

/// Adds a point's light through a link.
fn add_light(sums: &mut [f32], link: &[f32], light: &[f32], suns: usize) {
    for (c, link) in link.iter().enumerate().filter(|(_, link)| **link > 0.0) {
        let part = c * suns..(c + 1) * suns;
        sums[part.clone()].iter_mut().zip(&light[part]).for_each(|(sum, v)| *sum += link * v);
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
