//! S, and the sun's share of it.

use crate::error::{Result, Warnings};
use crate::matrix::Matrix;
use crate::simulate::context::{Context, Ledger, Traced};
use crate::simulate::store::fingerprint::Fingerprint;
use crate::sky::{SkyOptions, cie, sky_matrix};
use crate::weather::CieSky;
use crate::weather::time::Time;
use std::time::Instant;

fn options(context: &Context<'_>) -> SkyOptions {
    let ground_reflectance = [context.project.weather.ground_albedo; 3];
    let solar_spectrum = context.project.output.quantity.is_solar();
    SkyOptions { subdivision: context.sky().subdivision(), solar_spectrum, ground_reflectance, ..SkyOptions::default() }
}

/// As the products want it: a file holds W/m²sr.
fn for_products(context: &Context<'_>, sky: Matrix<f32>) -> Matrix<f32> {
    match context.project.output.quantity.factor() {
        1.0 => sky,
        factor => sky.map(|v| (f64::from(v) * factor) as f32),
    }
}

/// S `[patch][hour]`, the ground first; an earlier run's if its inputs are the same.
///
/// # Errors
/// Weather whose sky cannot be computed, failures of the file system, or when stopped.
pub(crate) fn sky(context: &Context<'_>, ledger: &mut Ledger) -> Result<Matrix<f32>> {
    let clock = Instant::now();
    context.check_stop()?;
    let options = options(context);
    let weather = &context.inputs.weather;
    let inputs = *Fingerprint::new("S").add(weather).add(&options);
    let shape = (context.sky().len(), weather.records.len(), 3);
    let kept = context.store.load("S", inputs, shape);
    let reused = kept.is_some();
    let sky = match kept {
        Some(sky) => sky,
        None => {
            let sky = sky_matrix(weather, &options, context.progress)?;
            context.store.save("S", &sky, inputs, "sky matrix, rows patches, columns hours")?;
            sky
        }
    };
    ledger.note("S", [sky.rows(), sky.cols()], reused, clock.elapsed().as_secs_f64(), Traced::default());
    Ok(for_products(context, sky))
}

/// S of the whole solar spectrum, W/m²sr, whatever the project asks for.
///
/// # Errors
/// As [`sky_matrix`].
pub(crate) fn solar(context: &Context<'_>) -> Result<Matrix<f32>> {
    sky_matrix(&context.inputs.weather, &SkyOptions { solar_spectrum: true, ..options(context) }, context.progress)
}

/// Sds `[patch][hour]`: the sun's share of S, as `gendaymtx -d`.
///
/// # Errors
/// As [`sky`].
pub(crate) fn sun_alone(context: &Context<'_>) -> Result<Matrix<f32>> {
    let options = SkyOptions { sky: false, ..options(context) };
    let weather = &context.inputs.weather;
    let inputs = *Fingerprint::new("Sds").add(weather).add(&options);
    let shape = (context.sky().len(), weather.records.len(), 3);
    if let Some(kept) = context.store.load("Sds", inputs, shape) {
        return Ok(for_products(context, kept));
    }
    let sun = sky_matrix(weather, &options, context.progress)?;
    context.store.save("Sds", &sun, inputs, "sky matrix of the sun alone, as gendaymtx -d, rows patches, columns hours")?;
    Ok(for_products(context, sun))
}

/// The overcast sky of the CIE, one column, that gives [`OUTDOORS`](cie::OUTDOORS) lx outdoors: for daylight factors.
///
/// # Errors
/// As [`sky_matrix`].
pub(crate) fn overcast(context: &Context<'_>) -> Result<Matrix<f32>> {
    let noon = Time { month: 3, day: 21, hour: 12.0 };
    sky_matrix(&cie::weather(&[(CieSky::Overcast, noon)], None, &mut Warnings::new())?, &options(context), context.progress)
}
