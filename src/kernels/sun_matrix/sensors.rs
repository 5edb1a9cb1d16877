//! The sun matrix of sensors.
//!
//! Rays are traced only where the sun is seen through an opening (if there are any), so most pairs of receiver
//! and sun cost nothing.

use super::openings::Openings;
use super::options::SunOptions;
use super::pane::light::PaneLight;
use super::result::{SunMatrix, mean_and_variance, with_doubt};
use super::shades::Shades;
use super::sun::Sun;
use super::tracer::{SunTracer, Tile};
use super::{direct, paths};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{TraceStatistics, unit};
use crate::progress::{Progress, cancelled};
use crate::scene::Scene;
use crate::scene::points::Sensor;
use glam::DVec3;

/// Computes the sun matrix of `sensors`: irradiance (W/m²) per unit radiance of each sun's disc (W/m²sr), that is sr. A
/// point sun counts with the solid angle of the real disc. The windows are holes to their rooms: what fills them
/// (panes, slats) is part of the scene, or of the openings.
///
/// # Errors
/// Sensors without direction, suns that are no discs, options without sense, windows without area, data that are too
/// large, failures of the device, or when stopped by `progress`.
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
    let result = SunMatrix::zeros(sensors.len(), suns.len());
    if sensors.is_empty() || suns.is_empty() {
        return Ok(result);
    }
    let mut state = (result, TraceStatistics::default());
    let receivers: Vec<Receiver> = sensors.iter().enumerate().map(|(i, s)| tracer.receiver(s, i)).collect();
    let shades = Shades::choose(&tracer, &receivers)?;
    let shares = |i: &usize| shades.as_ref().is_some_and(|(_, suited)| suited[*i]);
    let (shared, own): (Vec<usize>, Vec<usize>) = (0..sensors.len()).partition(shares);
    let mut done = 0;
    for (rows, scatters) in [(&shared, false), (&own, tracer.scatters())] {
        for chunk in tracer.plan(rows.len())?.chunks() {
            progress.update("sun matrix", done as f64 / sensors.len() as f64);
            if progress.stop_requested() {
                return Err(cancelled());
            }
            let rows = &rows[chunk.first..][..chunk.count];
            let mut make = |(result, statistics): &mut (SunMatrix, TraceStatistics)| {
                let records: Vec<Receiver> = rows.iter().map(|i| receivers[*i]).collect();
                let numbers: Vec<u32> = records.iter().map(|r| r.number).collect();
                let buffer = device.upload("receivers of suns", &records)?;
                let tile = Tile { receivers: &buffer, numbers: &numbers, batch_stride: 0 };
                add_tile(&tracer, &tile, rows, scatters, result, statistics)
            };
            unit(progress, &format!("sensors {rows:?}"), &mut state, &mut make, &|(result, statistics), values| {
                values.pass_work(statistics)?;
                result.pass(rows, values)
            })?;
            done += chunk.count;
        }
    }
    if let Some((shades, _)) = &shades {
        let records: Vec<Receiver> = shared.iter().map(|i| receivers[*i]).collect();
        shades.light(&shared, &records, &mut state.0, progress, &mut state.1)?;
    }
    if let Some(panes) = PaneLight::new(&tracer)? {
        state = panes.add(&receivers, state, progress)?;
    }
    let (mut result, statistics) = state;
    result.statistics = statistics;
    progress.update("sun matrix", 1.0);
    Ok(result)
}

/// Adds what the receivers of a tile, which belong into these rows, get directly and by paths of their own.
fn add_tile(
    tracer: &SunTracer<'_>,
    tile: &Tile<'_>,
    rows: &[usize],
    scatters: bool,
    result: &mut SunMatrix,
    statistics: &mut TraceStatistics,
) -> Result<()> {
    let (batches, suns) = (tracer.options.batches as usize, tracer.sun_count);
    let direct = direct::light(tracer, tile, statistics)?;
    let scattered = if scatters { Some(paths::light(tracer, tile, statistics)?) } else { None };
    for (receiver, &row) in rows.iter().enumerate() {
        for sun in 0..suns {
            let cells = (0..batches).map(move |b| (b * rows.len() + receiver) * suns + sun);
            let doubt = cells.clone().map(|cell| f64::from(direct[cell][3])).sum::<f64>() / (batches * batches) as f64;
            for c in 0..3 {
                let [mean, spread] = mean_and_variance(cells.clone().map(|cell| f64::from(direct[cell][c])));
                result.set_direct(row, sun, c, [mean, with_doubt(spread, batches, doubt)]);
                if let Some(scattered) = &scattered {
                    let [mean, spread] = mean_and_variance(cells.clone().map(|cell| f64::from(scattered.light[cell][c])));
                    let [own, shared] = scattered.hits[receiver * suns + sun].doubts(batches);
                    result.add_scattered(row, sun, c, mean, [own, spread + shared]);
                }
            }
        }
    }
    Ok(())
}
