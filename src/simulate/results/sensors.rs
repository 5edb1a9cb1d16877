//! The sensors' year: illuminance by the formula, its terms, its errors and its tables.

use super::annual::{self, YearErrors, YearJob};
use super::control::Operated;
use super::illuminance::{Content, illuminance, luminous, write_illuminance};
use super::metrics::{self, GroupFacts, Samples, SensorSample};
use super::suns::TracedSuns;
use super::views::Made;
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::metrics::lm83::Shading;
use crate::metrics::{Estimated, Metric, lm83};
use crate::scene::points::Sensor;
use crate::simulate::context::Context;
use crate::simulate::inputs::counting::{Counting, FACTOR, MEAN};
use crate::simulate::inputs::outlook::Outlook;
use crate::simulate::inputs::split;
use crate::simulate::light::{Daylight, Light, Skies, WindowLight, multiply, transmitted};
use crate::simulate::phases::sky::overcast;
use crate::simulate::project::Quantity;
use crate::simulate::project::metrics::Family;
use crate::simulate::sampling::chain::Chain;
use crate::simulate::sampling::estimate::Estimate;
use crate::simulate::store::fingerprint::Fingerprint;
use crate::simulate::store::write_stored;
use crate::statistics::variance_of_mean;
use crate::units::LUMINOUS_EFFICACY;
use crate::weather::{CieSky, Weather};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// One group of sensors.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SensorSummary {
    /// Its name.
    pub name: String,
    /// Number of sensors.
    pub count: usize,
    /// Those that no light reaches, with 0 lx.
    pub without_light: usize,
    /// Mean over sensors and hours, lux; absent of irradiance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_illuminance_lx: Option<f64>,
    /// Its standard error, lux.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_illuminance_standard_error_lx: Option<f64>,
    /// Mean irradiance over sensors and hours, W/m², where the project asks for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_irradiance_w_m2: Option<f64>,
    /// Its standard error, W/m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_irradiance_standard_error_w_m2: Option<f64>,
    /// Under an overcast sky of the CIE: mean over the sensors of their share of the horizontal illuminance outdoors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_daylight_factor: Option<f64>,
    /// Named metrics of the group, each with its error, class and doubts; none of irradiance.
    pub metrics: Vec<Metric>,
}

/// Illuminance of all sensors in all hours, `[sensor][hour]`, lx. Of five phases the three terms are
/// written too.
///
/// # Errors
/// Failures of the multiplier's device and of the file system.
pub(crate) fn light_at_sensors(context: &Context<'_>, made: &Made<'_>) -> Result<Matrix<f32>> {
    let (light, multiplier, inputs) = (made.at_sensors, made.multiplier, context.inputs);
    let (total, direct) = (made.sampled.view.total(), made.sampled.view.mean_replaced());
    let receivers = light.receivers(&total, &direct, inputs.differences());
    let mut lux = light.over_the_year(&illuminance(multiplier, &receivers, &light.right)?);
    let Some(suns) = made.suns else { return Ok(lux) };
    let sun = suns.illuminance();
    if light.is_split() {
        lux.data_mut().iter_mut().zip(sun.data()).for_each(|(lux, sun)| *lux = (*lux + sun).max(0.0));
    }
    write_terms(context, made, [&total, &direct], &lux, &sun)?;
    Ok(lux)
}

/// Writes V·T·D·S (or C·S), Vd·T·Dd·Sds (or Cd·Sds) and Cds·Ssun of every group.
fn write_terms(
    context: &Context<'_>,
    made: &Made<'_>,
    [total, direct]: [&Matrix<f32>; 2],
    lux: &Matrix<f32>,
    sun: &Matrix<f32>,
) -> Result<()> {
    let light = made.at_sensors;
    let (three_phase, taken) = if light.is_split() {
        // The halves of the right factor are X and X − Xsun.
        let (x, rest) = light.right.data().split_at(light.right.data().len() / 2);
        let part = |data: Vec<f32>| Matrix::from_data(light.bins, light.hours.len(), 3, data);
        let sun_patches = part(x.iter().zip(rest).map(|(x, rest)| x - rest).collect())?;
        let of = |rows: &Matrix<f32>, right: &Matrix<f32>| Ok(light.over_the_year(&illuminance(made.multiplier, rows, right)?));
        (of(total, &part(x.to_vec())?)?, of(direct, &sun_patches)?)
    } else {
        (lux.clone(), Matrix::zeros(lux.rows(), lux.cols(), 1))
    };
    let [whole, part] = match made.sampled.sees_sky {
        true => [("whole", "C·S"), ("direct", "Cd·Sds")],
        false => [("three_phase", "V·T·D·S"), ("direct", "Vd·T·Dd·Sds")],
    };
    let terms = [(whole, &three_phase), (part, &taken), (("sun", "Cds·Ssun"), sun)];
    for ((name, formula), term) in terms {
        for (group, part) in context.inputs.sensors.iter().zip(split(term, &context.inputs.sensors)) {
            let unit = context.project.output.quantity.unit();
            let about = format!("{formula} of {} in {unit}, rows sensors, columns hours", group.name);
            write_stored(&context.store.term_path(&group.name, name)?, &part, &about)?;
        }
    }
    Ok(())
}

/// Writes the daylight coefficients V·T·D of all groups, the one matrix of the two-phase method.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_coefficients(context: &Context<'_>, made: &Made<'_>) -> Result<()> {
    let inputs = context.inputs;
    let daylight: Vec<Matrix<f32>> = made.sampled.daylight.iter().map(|d| d.total()).collect();
    let windows = WindowLight::of(inputs, &inputs.transmissions(), Daylight { total: &daylight, direct: &daylight });
    let transmitted = transmitted(&windows, &windows.iter().map(|w| Some(w.all)).collect::<Vec<_>>())?;
    let coefficients = multiply(&made.sampled.view.total(), &transmitted).map(|v| v as f32);
    for (group, part) in inputs.sensors.iter().zip(split(&coefficients, &inputs.sensors)) {
        let key = *Fingerprint::new("DC").add_values(part.data());
        context.store.save(&format!("DC_{}", group.name), &part, key, "daylight coefficients V·T·D, rows sensors, columns patches")?;
    }
    Ok(())
}

/// Standard errors of all hours, and what metrics count with theirs.
///
/// # Errors
/// Failures of the multiplier's device, or when stopped.
pub(crate) fn errors(
    context: &Context<'_>,
    counting: &Counting,
    made: &Made<'_>,
    lux: &Matrix<f32>,
    blinds: Option<&Operated>,
) -> Result<YearErrors> {
    let stage = |fraction: f64| {
        context.progress.update("error estimate", fraction);
        context.check_stop()
    };
    let inputs = context.inputs;
    let chain = made.sampled.chain(inputs, &made.skies.whole);
    let suns = made.suns.map(TracedSuns::variance);
    let suns = suns.as_ref().map(|s| s as &annual::SunVariance<'_>);
    let overcast = if counting.column(FACTOR).is_some() { Some(overcast(context)?) } else { None };
    // One sky knows no schedule.
    let at_rest = if inputs.moves() { &inputs.at_rest() } else { inputs };
    let under = match &overcast {
        None => None,
        Some(sky) => {
            let skies = Skies { whole: sky.clone(), sun: None };
            let light = if made.sampled.sees_sky {
                Light::of_sky(&skies, inputs.differences())
            } else {
                let mean = |of: fn(&Estimate) -> Matrix<f32>| made.sampled.daylight.iter().map(of).collect::<Vec<_>>();
                let (total, direct) = (mean(Estimate::total), mean(Estimate::direct));
                Light::of_facade(at_rest, Daylight { total: &total, direct: &direct }, made.multiplier, &skies)?
            };
            Some((Chain { sun: None, ..made.sampled.chain(at_rest, sky) }, light))
        }
    };
    let job = YearJob {
        chain: &chain,
        counting,
        multiplier: made.multiplier,
        light: made.at_sensors,
        suns,
        overcast: under.as_ref().map(|(chain, light)| (chain, light)),
        target: context.project.quality.target(),
    };
    let mut errors = annual::estimate(&job, lux, &stage)?;
    if let Some(suns) = made.suns {
        for (row, sample) in errors.samples.iter_mut().enumerate() {
            // ASE knows no blinds.
            let suns = blinds.map_or(suns, |b| &b.open_suns);
            sample.sun_hours = Some(suns.hours_above(row, lm83::SUN_LX, &counting.lm83, counting.year.length));
        }
    }
    Ok(errors)
}

/// Writes what sensors see of sky and sun: `SENSORS_sky.csv` of every group, where their light is followed straight to
/// the sky.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_sky(context: &Context<'_>, made: &Made<'_>) -> Result<()> {
    if !made.sampled.sees_sky {
        return Ok(());
    }
    let view = &made.sampled.view;
    let steps = context.inputs.weather.steps();
    // The ground below the horizon comes first.
    let share = |m: &Matrix<f32>, row: usize| m.row(row)[3..].chunks_exact(3).map(luminous).sum::<f64>() / (PI * LUMINOUS_EFFICACY);
    let mut first = 0;
    for group in &context.inputs.sensors {
        let path = context.store.results_path(&format!("{}_sky", group.name), "csv");
        crate::files::write_atomically(&path, |out| {
            let fault = |e: std::io::Error| Error::io(&path, &e);
            writeln!(out, "sensor,x,y,z,sky_view_factor,sky_view_factor_standard_error,sunlight_hours").map_err(fault)?;
            for (i, sensor) in group.sensors.iter().enumerate() {
                let (p, row) = (sensor.position, first + i);
                let own: Vec<f64> = view.direct.iter().map(|m| share(m, row)).collect();
                let mean = own.iter().sum::<f64>() / own.len().max(1) as f64;
                let error = variance_of_mean(own.iter().copied()).sqrt();
                let hours = made.suns.map_or(0.0, |suns| steps.hours(suns.steps_in_sun(row)));
                writeln!(out, "{},{},{},{},{mean:.4},{error:.1e},{hours}", i + 1, p.x, p.y, p.z).map_err(fault)?;
            }
            Ok(())
        })?;
        first += group.sensors.len();
    }
    Ok(())
}

/// Mean horizontal illuminance outdoors, lx, if the sky is the CIE's overcast one in all steps.
fn overcast_outdoors(weather: &Weather) -> Option<f64> {
    let all = !weather.skies.is_empty() && weather.skies.iter().all(|s| *s == CieSky::Overcast);
    all.then(|| weather.records.iter().map(|r| r.diffuse).sum::<f64>() / weather.records.len() as f64)
}

/// Why the direct sun at sensors is not that through bare windows.
fn not_bare(context: &Context<'_>, blinds: Option<&Operated>) -> Option<String> {
    if let Some(blinds) = blinds.filter(|b| b.all) {
        let windows = blinds.covered.join("', '");
        return (!blinds.covered.is_empty()).then(|| format!("windows '{windows}' are not of clear glass with their blinds open"));
    }
    let used = context.inputs.windows_in_use();
    let mut covered: Vec<&str> = used.iter().filter(|w| w.glass.is_none()).map(|w| w.name.as_str()).collect();
    covered.dedup();
    let windows = covered.join("', '");
    (!covered.is_empty()).then(|| format!("windows '{windows}' are as computed, LM-83 wants them without blinds"))
}

/// Writes illuminances, errors and metrics of all groups; of the metrics, those of each group and those of all.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write(
    context: &Context<'_>,
    counting: &Counting,
    lux: &Matrix<f32>,
    errors: &YearErrors,
    dark: &[bool],
    blinds: Option<&Operated>,
) -> Result<(Vec<SensorSummary>, Vec<Metric>)> {
    let groups = &context.inputs.sensors;
    let (records, steps, quantity) = (&context.inputs.weather.records, context.inputs.weather.steps(), context.project.output.quantity);
    let outdoors = overcast_outdoors(&context.inputs.weather);
    let samples = Samples { counting, noise: &errors.noise, replicates: errors.replicates };
    let mean_column = counting.column(MEAN).expect("the mean is always counted");
    let (mut sensors, mut facts, mut rest) = (Vec::new(), Vec::new(), dark);
    let parts = split(lux, groups).into_iter().zip(split(&errors.standard_error, groups));
    let looks_out = counting.section.wants(Family::En17037) && !quantity.is_solar() && !groups.is_empty();
    let outlook = if looks_out { Outlook::new(context.inputs) } else { None };
    let mut first = 0;
    for (i, (group, (part, error))) in groups.iter().zip(parts).enumerate() {
        context.progress.update("writing", i as f64 / groups.len() as f64);
        let dark = rest.split_off(..group.sensors.len()).unwrap_or_default();
        let own = &errors.samples[first..first + group.sensors.len()];
        first += own.len();
        write_illuminance(context.store, group, dark, records, &part, Content::Illuminance, quantity)?;
        write_illuminance(context.store, group, dark, records, &error, Content::StandardError, quantity)?;
        super::moments::write(context.store, group, &context.inputs.weather, &part)?;
        if quantity.is_solar() {
            super::monthly::write(context.store, group, &context.inputs.weather, &part)?;
        }
        let path = context.store.results_path(&format!("{}_annual", group.name), "csv");
        let fact = GroupFacts {
            name: group.name.clone(),
            positions: group.sensors.iter().map(|s| s.position).collect(),
            faces_up: group.sensors.iter().map(Sensor::faces_up).collect(),
            outlook: if looks_out { metrics::outlook::judge(context, outlook.as_ref(), group)? } else { Vec::new() },
            not_bare: not_bare(context, blinds),
            shading: if blinds.is_some_and(|b| b.all) { Shading::Operated } else { Shading::Undeclared },
            hours_in_sun: blinds.map_or(0.0, |b| b.remaining.len() as f64 * counting.year.length),
        };
        match quantity {
            Quantity::Illuminance => {
                metrics::write_sensors(&path, (group, dark), &metrics::sensor_table(&samples, own))?;
                metrics::write_directions(&context.store.metrics_path(&format!("{}_sensors", group.name))?, &group.sensors)?;
            }
            Quantity::Irradiance => {
                let means: Vec<Estimated> = own.iter().map(|s| samples.of(&[s], mean_column, |v| v[0])).collect();
                metrics::write_irradiance(&path, (group, dark), &means, steps.hours(steps.len()))?;
            }
        }
        let everyone: Vec<&SensorSample> = own.iter().collect();
        let year = samples.of(&everyone, mean_column, |v| v.iter().sum::<f64>() / v.len().max(1) as f64);
        let mean = |of: Quantity, value: f64| (quantity == of).then_some(value);
        let (value, error) = (year.value, year.standard_error);
        sensors.push(SensorSummary {
            name: group.name.clone(),
            count: group.sensors.len(),
            without_light: dark.iter().filter(|d| **d).count(),
            mean_illuminance_lx: mean(Quantity::Illuminance, value),
            mean_illuminance_standard_error_lx: mean(Quantity::Illuminance, error),
            mean_daylight_factor: mean(Quantity::Illuminance, value).zip(outdoors).map(|(lux, outdoors)| lux / outdoors),
            mean_irradiance_w_m2: mean(Quantity::Irradiance, value),
            mean_irradiance_standard_error_w_m2: mean(Quantity::Irradiance, error),
            metrics: if quantity.is_solar() { Vec::new() } else { metrics::judge(&samples, &fact, own) },
        });
        facts.push((fact, own));
    }
    let parts: Vec<(&GroupFacts, &[SensorSample])> = facts.iter().map(|(f, s)| (f, *s)).collect();
    let all = if quantity.is_solar() { Vec::new() } else { metrics::judge_all(&samples, &parts) };
    if !quantity.is_solar() && !groups.is_empty() {
        let listed: Vec<&Metric> = sensors.iter().flat_map(|s| &s.metrics).chain(&all).collect();
        metrics::write_metrics(&context.store.metrics_path("metrics")?, &listed)?;
        // Moments are no year to be judged again.
        if !counting.are_moments {
            metrics::write_hours(&context.store.metrics_path("hours")?, counting)?;
        }
    }
    Ok((sensors, all))
}
