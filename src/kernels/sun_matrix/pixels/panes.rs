//! Suns in pictures through panes of scattering data: the panes themselves, and the surfaces of the
//! room that they light.

use super::super::Sun;
use super::super::geometry::{Openings, SunTracer};
use super::super::pane::tracer::{PaneTracer, Tile};
use super::{Behind, Errors, MOST_TILE, Models, Pixels, discs};
use crate::camera::Raster;
use crate::error::Result;
use crate::glare::PixelGeometry;
use crate::gpu::Device;
use crate::kernels::glare::{PixelWeights, SharedNoise, SharedSums};
use crate::kernels::sun_matrix::geometry::SunOptions;
use crate::kernels::sun_matrix::pane::{PaneBsdf, PaneOptions};
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
    options: &PaneOptions,
    progress: &dyn Progress,
    statistics: &mut TraceStatistics,
    pictures: &mut [Pixels],
) -> Result<Vec<SharedNoise>> {
    let windows: Vec<Window> = models.panes.iter().map(|(w, _)| w.clone()).collect();
    let tracer = PaneTracer::new(device, models.black, models.panes, suns, options)?;
    let behind = Behind::new(device, models.lit, &windows, raster, [options.batches, options.seed])?;
    let batches = options.batches as usize;
    // A view without them has no glare.
    let weights = PixelGeometry::new(raster).map(PixelWeights::new).ok();
    let mut shared = vec![SharedSums::new(weights.as_ref(), batches); suns.len()];
    let outline = Behind::new(device, models.lit, &windows, raster, [options.batches * OUTLINE as u32, options.seed])?;
    // Number of a sun among those that reach a pane.
    let mut active = vec![None; suns.len()];
    tracer.active().iter().enumerate().for_each(|(number, &sun)| active[sun] = Some(number));
    let sun_chunks = tracer.chunks_of_suns()?;
    let rows = tracer.tiles(behind.inside.len(), sun_chunks.rows_per_chunk())?.at_most(MOST_TILE / OUTLINE);
    for chunk in rows.chunks() {
        progress.update("suns through panes in the picture", chunk.first as f64 / behind.inside.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let tile = &behind.inside[chunk.first..chunk.first + chunk.count];
        let count = tile.len();
        let surfaces = behind.find(tile, u32::MAX, true, statistics)?;
        let pane = outline.find(tile, u32::MAX, true, statistics)?;
        let own = |receivers| Tile { receivers, count, batch_stride: count as u32 };
        for part in sun_chunks.chunks() {
            // Number of a sun in this part, and the place of what a ray of a pixel gets from it.
            let cell = |sun: usize, ray: usize, i: usize| {
                let number = active[sun].filter(|s| (part.first..part.first + part.count).contains(s))? - part.first;
                Some(((ray * part.count + number) * count + i) * 3)
            };
            let at_panes = tracer.suns_at_panes(part.first, part.count, statistics)?;
            let [scattered, clear] = tracer.gather(&at_panes, &own(&surfaces.receivers), progress, statistics)?;
            let of = |values: &[f32], k: usize| values.get(k).copied().unwrap_or(0.0);
            let on_surfaces = |part: &[f32], sun: usize, ray: usize, i: usize| {
                let weight = surfaces.weights[ray * count + i];
                let Some(cell) = cell(sun, ray, i).filter(|_| weight[3] == 0.0) else { return [0.0; 3] };
                std::array::from_fn(|c| weight[c] * of(part, cell + c))
            };
            // Points of the disc are each pixel's own, those of the panes are not.
            let errors = Errors::Shared(weights.as_ref(), &mut shared);
            super::add(tile, [batches, batches], pictures, errors, &|sun, ray, i| on_surfaces(&scattered, sun, ray, i));
            super::add(tile, [batches, batches], pictures, Errors::Own, &|sun, ray, i| on_surfaces(&clear, sun, ray, i));
            let radiance = tracer.facade(&at_panes, &own(&pane.facade), batches * OUTLINE, statistics)?;
            super::add(tile, [batches, batches * OUTLINE], pictures, Errors::Own, &|sun, ray, i| {
                let weight = pane.weights[ray * count + i];
                let Some(cell) = cell(sun, ray, i).filter(|_| weight[3] == 1.0) else { return [0.0; 3] };
                std::array::from_fn(|c| weight[c] * of(&radiance, cell + c))
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
    options: &PaneOptions,
    statistics: &mut TraceStatistics,
    seen: &mut discs::Seen,
) -> Result<()> {
    // What stands in the way of the discs. The panes themselves are polygons without thickness.
    let openings: Vec<(Window, Vec<DVec3>)> = models.panes.iter().map(|(w, _)| (w.clone(), Vec::new())).collect();
    let plain = SunOptions { memory: options.memory, ..SunOptions::default() }.direct();
    let straight = SunTracer::new(device, models.black, Openings::Shaded(&openings), &[], suns, &plain)?;
    let filter = |origin, direction| clear_through(models.panes, origin, direction);
    let way = discs::Way { tracer: &straight, filter: &filter, openings: &openings, images: false };
    discs::add(device, eye, &way, suns, options.seed, statistics, seen)
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
