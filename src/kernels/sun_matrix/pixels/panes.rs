//! Suns in pictures through panes of scattering data: the panes themselves, and the surfaces of the
//! room that they light.

use super::behind::PixelSurfaces;
use super::{Errors, MOST_TILE, Models, Pixels, discs};
use crate::camera::Raster;
use crate::error::Result;
use crate::glare::PixelGeometry;
use crate::gpu::Device;
use crate::kernels::glare::{PixelWeights, SharedNoise, SharedSums};
use crate::kernels::sun_matrix::direct;
use crate::kernels::sun_matrix::openings::Openings;
use crate::kernels::sun_matrix::options::SunOptions;
use crate::kernels::sun_matrix::pane::PaneBsdf;
use crate::kernels::sun_matrix::pane::light::PaneLight;
use crate::kernels::sun_matrix::sun::Sun;
use crate::kernels::sun_matrix::tracer::{SunTracer, Tile};
use crate::kernels::trace::TraceStatistics;
use crate::progress::{Progress, cancelled};
use crate::scene::Window;
use glam::DVec3;

/// Rays of a pixel per batch that find which share of it panes fill.
pub(super) const OUTLINE: usize = 4;

/// Adds them to the pictures, and finds by how much pixels err together.
#[allow(clippy::too_many_arguments, reason = "private; each is a different thing")]
pub(super) fn add(
    device: &Device,
    models: &Models<'_>,
    raster: &Raster,
    suns: &[Sun],
    options: &SunOptions,
    progress: &dyn Progress,
    statistics: &mut TraceStatistics,
    pictures: &mut [Pixels],
) -> Result<Vec<SharedNoise>> {
    let windows: Vec<Window> = models.panes.iter().map(|(w, _)| w.clone()).collect();
    let tracer = SunTracer::new(device, models.black, Openings::Panes(models.panes), &[], suns, options)?;
    let light = PaneLight::new(&tracer)?;
    let behind = PixelSurfaces::new(device, models.lit, &windows, raster, [options.batches, options.seed])?;
    let batches = options.batches as usize;
    // A view without them has no glare.
    let weights = PixelGeometry::new(raster).map(PixelWeights::new).ok();
    let mut shared = vec![SharedSums::new(weights.as_ref(), batches); suns.len()];
    let outline = PixelSurfaces::new(device, models.lit, &windows, raster, [options.batches * OUTLINE as u32, options.seed])?;
    let sun_chunks = light.as_ref().map(PaneLight::chunks_of_suns).transpose()?;
    let mut rows = tracer.plan(behind.inside.len())?.at_most(MOST_TILE / OUTLINE);
    if let (Some(light), Some(suns)) = (&light, &sun_chunks) {
        rows = light.tiles(behind.inside.len(), suns.rows_per_chunk(), OUTLINE)?.at_most(rows.rows_per_chunk());
    }
    for chunk in rows.chunks() {
        progress.update("suns through panes in the picture", chunk.first as f64 / behind.inside.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let tile = &behind.inside[chunk.first..chunk.first + chunk.count];
        let count = tile.len();
        let surfaces = behind.find(tile, u32::MAX, true, statistics)?;
        let pane = outline.find(tile, u32::MAX, true, statistics)?;
        let numbers: Vec<u32> = tile.iter().map(|p| *p as u32).collect();
        let receivers = Tile { receivers: &surfaces.receivers, numbers: &numbers, batch_stride: count as u32 };
        let on_surface = |light: [f32; 3], ray: usize, i: usize| {
            let weight = surfaces.weights[ray * count + i];
            if weight[3] == 0.0 { std::array::from_fn(|c| weight[c] * light[c]) } else { [0.0; 3] }
        };
        // Points of the disc are each pixel's own, those of the panes are not.
        let clear = direct::light(&tracer, &receivers, statistics)?;
        super::add(tile, [batches, batches], pictures, Errors::Own(&|_, _| 0.0), &|sun, ray, i| {
            let [r, g, b, _] = clear[(ray * count + i) * suns.len() + sun];
            on_surface([r, g, b], ray, i)
        });
        let (Some(light), Some(sun_chunks)) = (&light, &sun_chunks) else { continue };
        for part in sun_chunks.chunks() {
            // Number of a sun in this part.
            let mut numbers = vec![None; suns.len()];
            light.active(part.first, part.count).iter().enumerate().for_each(|(number, &sun)| numbers[sun] = Some(number));
            let at_cells = light.suns_at_cells(part.first, part.count, statistics)?;
            let scattered = light.gather(&at_cells, &receivers, progress, statistics)?;
            let errors = Errors::Shared(weights.as_ref(), &mut shared);
            super::add(tile, [batches, batches], pictures, errors, &|sun, ray, i| {
                let Some(number) = numbers[sun] else { return [0.0; 3] };
                let cell = ((ray * part.count + number) * count + i) * 3;
                on_surface(std::array::from_fn(|c| scattered[cell + c]), ray, i)
            });
            let rays = batches * OUTLINE;
            let radiance = light.facade(&at_cells, &pane.facade, [count, rays], statistics)?;
            super::add(tile, [batches, rays], pictures, Errors::Own(&|_, _| 0.0), &|sun, ray, i| {
                let weight = pane.weights[ray * count + i];
                let Some(number) = numbers[sun].filter(|_| weight[3] == 1.0) else { return [0.0; 3] };
                let shown = radiance[(number * rays + ray) * count + i].strength;
                std::array::from_fn(|c| weight[c] * shown[c])
            });
        }
    }
    Ok(shared.iter().map(SharedSums::noise).collect())
}

/// Adds the discs of suns that are seen through panes.
pub(super) fn discs(
    device: &Device,
    models: &Models<'_>,
    eye: discs::Eye<'_>,
    suns: &[Sun],
    options: &SunOptions,
    statistics: &mut TraceStatistics,
    seen: &mut discs::Seen,
) -> Result<()> {
    // What stands in the way of the discs. The panes themselves are polygons without thickness.
    let openings: Vec<(Window, Vec<DVec3>)> = models.panes.iter().map(|(w, _)| (w.clone(), Vec::new())).collect();
    let plain = SunOptions { memory: options.memory, ..SunOptions::default() }.direct();
    let tracer = SunTracer::new(device, models.black, Openings::Shaded(&openings), &[], suns, &plain)?;
    let filter = |origin, direction| clear_through(models.panes, origin, direction);
    let way = discs::Obstructions { tracer: &tracer, filter: &filter, openings: &openings, images: false };
    discs::add(eye, &way, suns, options.seed, statistics, seen)
}

/// Transmittance of the clear view along a ray from inside through the first pane that it meets; 0
/// beside all panes.
fn clear_through(panes: &[(Window, PaneBsdf)], origin: DVec3, direction: DVec3) -> [f64; 3] {
    let mut nearest = f64::INFINITY;
    let mut clear = [0.0; 3];
    for (window, pane) in panes.iter().filter(|(w, _)| direction.dot(w.frame.z) < 0.0) {
        for t in &window.triangles {
            let distance = (t[0] - origin).dot(window.frame.z) / direction.dot(window.frame.z);
            let volumes = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| direction.dot((t[a] - origin).cross(t[b] - origin)));
            let passes = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
            if passes && distance > 0.0 && distance < nearest {
                nearest = distance;
                clear = pane.clear(-window.frame.to_local(direction));
            }
        }
    }
    clear
}
