//! Tracing of a picture, tile by tile.

use super::{
    BinShare, DIRECT, GATHER, ImageOptions, LEAST_IMAGE_RAYS, MOST_LIGHTS, PixelPoint, PixelRay, PixelRows, RECEIVERS, TileParams,
    VERTICES_KEPT, doubts,
};
use crate::camera::{PixelSamples, Raster};
use crate::error::Result;
use crate::gpu::{Buffer, Device, Kernel};
use crate::kernels::light_paths::doubts::BinShares;
use crate::kernels::light_paths::images::{ReceiverPoint, WindowImages};
use crate::kernels::light_paths::{
    LightPathKernels, LightPathOptions, LightPaths, NEAR, NearOptions, NearPaths, Receiver, finish_dispatch, near_paths,
};
use crate::kernels::trace::{Counters, FAR_AWAY, TraceScene, TraceStatistics, TraceTables, stream_seed};
use crate::scene::Window;
use glam::Vec3;
use rayon::prelude::*;

pub(super) struct ImageTracer<'d> {
    device: &'d Device,
    pub(super) windows: &'d [Window],
    pub(super) tables: TraceTables,
    scene: TraceScene,
    pub(super) options: ImageOptions,
    receivers: Kernel,
    direct: Kernel,
    gather: Kernel,
    near: Kernel,
    /// Where there are plane mirrors.
    images: Option<WindowImages>,
    light_paths: LightPathKernels,
    counters: Buffer,
}

impl<'d> ImageTracer<'d> {
    pub(super) fn new(device: &'d Device, windows: &'d [Window], tables: TraceTables, options: &ImageOptions) -> Result<Self> {
        let scene = tables.upload(device)?;
        let glass = ("HAS_GLASS", f64::from(u8::from(tables.features.glass)));
        let specular = ("HAS_SPECULAR", f64::from(u8::from(tables.features.specular)));
        // As many rays to an image as a batch has, for its share of those to the windows themselves.
        let direct_rays = options.window_samples.div_ceil(options.traced_every);
        Ok(Self {
            device,
            windows,
            scene,
            options: *options,
            receivers: Kernel::new(device, &RECEIVERS, &[specular])?,
            direct: Kernel::new(device, &DIRECT, &[glass])?,
            gather: Kernel::new(device, &GATHER, &[glass, ("RAYS", f64::from(options.visibility_rays))])?,
            near: Kernel::new(device, &NEAR, &[glass])?,
            images: WindowImages::new(device, &tables, options.seed, direct_rays, LEAST_IMAGE_RAYS)?,
            light_paths: LightPathKernels::new(device)?,
            counters: device.zeros::<Counters>("path counters", 1)?,
            tables,
        })
    }

    /// Rows of `count` pixels from `first` on; only those inside the view are traced.
    pub(super) fn tile(
        &self,
        raster: &Raster,
        samples: &PixelSamples,
        first: usize,
        count: usize,
        statistics: &mut TraceStatistics,
    ) -> Result<PixelRows> {
        let bins = self.tables.bins();
        let inside: Vec<usize> = (first..first + count).filter(|&p| raster.is_seen(p % raster.width(), p / raster.width())).collect();
        let mut rows = PixelRows {
            first,
            pixels: count,
            values: vec![0.0; count * bins * 3],
            standard_error: vec![0.0; count * bins * 3],
            doubts: doubts::PixelDoubts::none(BinShares::of(&self.tables, self.windows), count),
            direct_view: vec![0.0; count * bins * 3],
            batches: vec![0.0; self.options.batches as usize * count * bins * 3],
            direct: if self.options.direct { vec![0.0; count * bins * 3] } else { Vec::new() },
        };
        if inside.is_empty() {
            return Ok(rows);
        }
        let tile = self.trace(raster, samples, &inside, statistics)?;
        let batches = self.options.batches as usize;
        let row_len = bins * 3;
        for (pixel, &place) in inside.iter().enumerate() {
            rows.doubts.set(place - first, self.doubts(&tile, pixel, inside.len()));
        }
        let doubts = &rows.doubts;
        // Subpixels of each group.
        let subpixels = self.options.subpixels;
        let part = |subpixel: u32| (subpixel * self.options.batches / subpixels) as usize;
        let mut per_part = vec![0u32; batches];
        (0..subpixels).for_each(|s| per_part[part(s)] += 1);
        let share = |count: u32, rays: u32| count as f32 / self.unit() / rays as f32;
        rows.values
            .par_chunks_mut(row_len)
            .zip(rows.standard_error.par_chunks_mut(row_len))
            .zip(rows.direct_view.par_chunks_mut(row_len))
            .zip(rows.batches.par_chunks_mut(batches * row_len))
            .enumerate()
            .for_each(|(pixel, (((values, errors), direct_view), estimates))| {
                let place = pixel;
                let Ok(pixel) = inside.binary_search(&(first + pixel)) else { return };
                let by_chance = tile.looks[pixel][0] > 0;
                for (i, ((value, error), direct)) in values.iter_mut().zip(errors).zip(direct_view).enumerate() {
                    let (bin, c) = (i / 3, i % 3);
                    let (mut sum, mut squares) = (0.0f64, 0.0f64);
                    let seen = |batch: usize| tile.seen[((pixel * batches + batch) * bins + bin) * 3 + c];
                    *direct = share((0..batches).map(seen).sum(), subpixels);
                    for batch in 0..batches {
                        let at = batch * inside.len() + pixel;
                        let mut v = f64::from(tile.sums[((bin * batches + batch) * inside.len() + pixel) * 3 + c]);
                        if let Some(near) = &tile.near {
                            v += f64::from(near.sums[(at * bins + bin) * 3 + c]) * f64::from(tile.points[at].weight[c]);
                        }
                        sum += v;
                        let own = share(seen(batch), per_part[batch]);
                        estimates[batch * row_len + i] = v as f32 + own;
                        // Of windows shown in full the parts of a pixel differ, but not by chance.
                        let chance = v + if by_chance { f64::from(own - *direct) } else { 0.0 };
                        squares += chance * chance;
                    }
                    let n = batches as f64;
                    *value = (sum / n) as f32 + *direct;
                    let spread = (squares / n - (sum / n).powi(2)).max(0.0) / (n - 1.0);
                    *error = (spread + doubts.of(place, bin, c).powi(2)).sqrt() as f32;
                }
            });
        let (values, seen, direct) = (&rows.values, &rows.direct_view, &mut rows.direct);
        direct.par_chunks_mut(row_len).enumerate().for_each(|(pixel, row)| {
            let Ok(at) = inside.binary_search(&(first + pixel)) else { return };
            for (i, value) in row.iter_mut().enumerate() {
                let (bin, c) = (i / 3, i % 3);
                let lit: f64 = (0..batches).map(|b| f64::from(tile.direct[((bin * batches + b) * inside.len() + at) * 3 + c])).sum();
                let place = pixel * row_len + i;
                *value = ((lit / batches as f64) as f32 + seen[place]).min(values[place]);
            }
        });
        Ok(rows)
    }

    /// Fixed-point units of one subpixel ray: weights stay below 2.
    pub(super) fn unit(&self) -> f32 {
        (1u32 << 31) as f32 / (self.options.subpixels * 2) as f32
    }

    fn trace(&self, raster: &Raster, samples: &PixelSamples, inside: &[usize], statistics: &mut TraceStatistics) -> Result<TracedTile> {
        let (o, device) = (&self.options, self.device);
        let bins = self.tables.bins();
        let (pixels, batches) = (inside.len(), o.batches as usize);
        let rays: Vec<PixelRay> = (0..o.subpixels as usize)
            .into_par_iter()
            .flat_map_iter(|subpixel| inside.iter().map(move |&pixel| self.ray(raster, samples, pixel, subpixel)))
            .collect();
        let params = TileParams {
            seed: stream_seed(o.seed, 0, 0x7069_7865),
            pixels: pixels as u32,
            paths: self.rounds() * self.paths_per_round(),
            batches: o.batches,
            bins: bins as u32,
            window_count: self.tables.windows.len() as u32,
            subpixels: o.subpixels,
            window_samples: o.window_samples,
            traced_every: o.traced_every,
            lights: self.room(),
            near_radius: o.near_radius,
            unit: self.unit(),
        };
        let params_buffer = device.uniform("tile parameters", &params)?;
        let rays = device.upload("camera rays", &rays)?;
        let receivers = device.zeros::<Receiver>("receivers of the pixels", batches * pixels)?;
        let seen = device.zeros::<u32>("windows seen directly", batches * pixels * bins * 3)?;
        let looks = device.zeros::<[u32; 4]>("reflections left to chance", pixels)?;
        let points = device.zeros::<PixelPoint>("surface points of the pixels", batches * pixels)?;
        let shares = device.zeros::<BinShare>("shares of the bins", batches * pixels * bins)?;
        let sums = device.zeros::<f32>("rows of the picture", batches * pixels * bins * 3)?;
        let groups = (pixels as u32).div_ceil(64);

        let own = [
            ("params", &params_buffer),
            ("rays", &rays),
            ("receivers", &receivers),
            ("points", &points),
            ("seen", &seen),
            ("looks", &looks),
        ];
        self.run(&self.receivers, &own, [groups, o.subpixels, 1], pixels as u64 * u64::from(o.subpixels), statistics)?;
        let reached = o.bounces.is_none_or(|b| b > 0);
        let (mut near, mut open) = (None, Vec::new());
        if reached {
            let own = [("params", &params_buffer), ("receivers", &receivers), ("shares", &shares), ("sums", &sums), ("points", &points)];
            self.run(&self.direct, &own, [groups, o.batches, 1], (pixels * batches) as u64, statistics)?;
            statistics.segments += pixels as u64 * u64::from(o.batches) * u64::from(o.window_samples.div_ceil(o.traced_every));
        }
        let direct = if o.direct { device.read_finite(&sums)? } else { Vec::new() };
        let reflected = o.bounces.is_none_or(|b| b > 1);
        if reflected || (reached && self.tables.features.specular) {
            let near_options = NearOptions {
                samples: o.near_samples,
                batches: o.batches,
                bounces: o.bounces,
                seed: o.seed,
                near_radius: o.near_radius,
                roulette_weight: o.roulette_weight,
                receivers_per_batch: true,
                images: self.images.is_some(),
            };
            let which = (&receivers, pixels);
            let mut found = near_paths(device, (&self.tables, &self.scene), &self.near, &near_options, which, statistics)?;
            if let Some(images) = &self.images {
                let receiver_points = self.receiver_points(&device.read(&receivers)?, &device.read(&points)?, pixels);
                let sums = (&mut found.sums[..], pixels);
                open = images.add(device, (&self.tables, &self.scene), self.windows, &receiver_points, sums, statistics)?;
            }
            near = Some(found);
        }
        if reflected {
            for round in 0..self.rounds() {
                self.reflected(round, &params, (&receivers, &points), (&shares, &sums), statistics)?;
            }
        }
        Ok(TracedTile {
            direct,
            sums: device.read_finite(&sums)?,
            seen: device.read(&seen)?,
            looks: device.read(&looks)?,
            points: device.read(&points)?,
            near,
            images: open,
        })
    }

    /// The surface points of the pixels, `[batch][pixel]`, as far as there are.
    fn receiver_points(&self, receivers: &[Receiver], points: &[PixelPoint], pixels: usize) -> Vec<ReceiverPoint> {
        let of = |(place, (r, p)): (usize, (&Receiver, &PixelPoint))| {
            let batch = (place / pixels) as u32;
            let position = Vec3::from_array(r.position);
            (p.weight != [0.0; 3]).then(|| ReceiverPoint {
                row: place % pixels,
                batches: batch..batch + 1,
                position: self.tables.normalization.back(position),
                normal: Vec3::from_array(r.normal).as_dvec3(),
                start: position,
                number: r.number,
            })
        };
        receivers.iter().zip(points).enumerate().filter_map(of).collect()
    }

    /// Lights per bin that one dispatch of `image_matrix/gather` can connect: a limit on its loops, which some
    /// drivers cut short.
    fn room(&self) -> u32 {
        (MOST_LIGHTS / self.tables.bins() as u32).max(1)
    }

    /// Light paths per bin whose first vertices have room together: going through a pixel's row costs
    /// as much as connecting it.
    fn paths_per_round(&self) -> u32 {
        let vertices = self.options.bounces.map_or(VERTICES_KEPT, |b| b.saturating_sub(1).clamp(1, VERTICES_KEPT));
        (self.room() / vertices).clamp(1, self.options.light_paths)
    }

    fn rounds(&self) -> u32 {
        self.options.light_paths.div_ceil(self.paths_per_round())
    }

    /// Adds the light of one round of light paths to `sums`.
    fn reflected(
        &self,
        round: u32,
        params: &TileParams,
        (receivers, points): (&Buffer, &Buffer),
        (shares, sums): (&Buffer, &Buffer),
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let (o, device) = (&self.options, self.device);
        let invocations = u64::from(params.pixels) * u64::from(params.batches);
        let seed = stream_seed(o.seed, round, 0x726f_756e);
        let path_options = LightPathOptions {
            paths: self.paths_per_round(),
            batches: o.batches,
            bounces: o.bounces,
            seed,
            room: self.room(),
            started: false,
            lists: self.tables.bins() as u32,
            first_list: 0,
            certain: 0,
        };
        let paths = LightPaths::new(device, &self.tables, &self.scene, &self.light_paths, path_options, None)?;
        for vertex in 0..paths.most_vertices() {
            let go_on = paths.advance(vertex, statistics)?;
            let last = !go_on || vertex + 1 == paths.most_vertices();
            if !last && paths.has_room()? {
                continue;
            }
            let params_now = device.uniform("tile parameters", &TileParams { seed: stream_seed(seed, vertex, 0x6761_7468), ..*params })?;
            let own = [
                ("params", &params_now),
                ("receivers", receivers),
                ("shares", shares),
                ("sums", sums),
                ("points", points),
                ("lights", &paths.lights),
                ("light_counts", &paths.light_counts),
            ];
            self.run(&self.gather, &own, [params.pixels.div_ceil(64), o.batches, 1], invocations, statistics)?;
            statistics.segments += invocations * u64::from(o.visibility_rays);
            paths.forget()?;
            if last {
                break;
            }
        }
        Ok(())
    }

    fn run(
        &self,
        kernel: &Kernel,
        own: &[(&str, &Buffer)],
        workgroups: [u32; 3],
        started: u64,
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        self.device.write(&self.counters, &[Counters::default()])?;
        let mut all = own.to_vec();
        all.push(("counters", &self.counters));
        let bind = kernel.bind(&self.scene.bindings(&all))?;
        self.device.dispatch(kernel, &bind, workgroups)?;
        finish_dispatch(self.device, &self.counters, started, kernel.label(), statistics)?;
        Ok(())
    }

    fn ray(&self, raster: &Raster, samples: &PixelSamples, pixel: usize, subpixel: usize) -> PixelRay {
        let (column, row) = (pixel % raster.width(), pixel / raster.width());
        // At the rim a sample may fall outside the view although the centre is inside.
        let ray = raster.sample(column, row, samples.offset(pixel, subpixel)).or_else(|| raster.ray(column, row));
        ray.map_or_else(
            || PixelRay { number: pixel as u32, ..PixelRay::default() },
            |r| PixelRay {
                origin: self.tables.normalization.point(r.origin).to_array(),
                length: if r.length > 0.0 { (r.length * self.tables.normalization.scale) as f32 } else { FAR_AWAY as f32 },
                direction: r.direction.as_vec3().to_array(),
                number: pixel as u32,
            },
        )
    }
}

pub(super) struct TracedTile {
    /// As `sums`, of direct light only; empty unless asked for.
    pub(super) direct: Vec<f32>,
    /// `[bin][batch][pixel][rgb]`
    pub(super) sums: Vec<f32>,
    /// `[pixel][group of subpixels][bin][rgb]`, fixed point.
    pub(super) seen: Vec<u32>,
    /// `[pixel]`: rays left to chance that left a reflection, those of them that saw a window, the sum of their
    /// weights, rays that met what might reflect.
    pub(super) looks: Vec<[u32; 4]>,
    /// `[batch][pixel]`
    pub(super) points: Vec<PixelPoint>,
    /// `[batch][pixel]`
    pub(super) near: Option<NearPaths>,
    /// What images of windows leave open, per pixel; empty if there are none.
    pub(super) images: Vec<f64>,
}
