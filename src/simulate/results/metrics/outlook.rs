//! EN 17037's view out and exposure to sunlight: what geometry decides.

use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::metrics::en17037::{self, Level};
use crate::metrics::view_out::{self, ViewOut};
use crate::metrics::{Decision, Estimated, Metric, share_of};
use crate::scene::points::Sensor;
use crate::simulate::context::Context;
use crate::simulate::inputs::SensorGroup;
use crate::simulate::inputs::outlook::{EYE_HEIGHT, Outlook, Seen};
use crate::weather::day_of_year;
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;

/// Names of the metrics here.
pub(crate) const NAMES: [&str; 2] = ["en17037_view_out", "en17037_sunlight"];
/// Eyes, at most: of more sensors some are taken, evenly.
const EYES: usize = 400;

fn view_out_metric() -> Metric {
    Metric::new(NAMES[0], "EN 17037 view out: eyes with at least the minimum", "share", en17037::SOURCE)
}

fn sunlight_metric() -> Metric {
    Metric::new(NAMES[1], "EN 17037 exposure to sunlight: possible sun of a cloudless day", "h", en17037::SOURCE)
}

/// The metrics of a group, not judged, and why.
pub(crate) fn not_judged(why: &str) -> Vec<Metric> {
    vec![view_out_metric().note(why), sunlight_metric().note(why)]
}

/// Judges a group, and writes `metrics/SENSORS_view_out.csv`: a line per eye.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn judge(context: &Context<'_>, outlook: Option<&Outlook<'_>>, group: &SensorGroup) -> Result<Vec<Metric>> {
    let plan: Vec<&Sensor> = group.sensors.iter().filter(|s| s.faces_up()).collect();
    let Some(outlook) = outlook else { return Ok(not_judged("not judged: there is no window")) };
    if plan.is_empty() {
        return Ok(not_judged("no sensor faces up, so that there is no plan"));
    }
    let mut floors: Vec<f64> = plan.iter().filter_map(|s| outlook.floor_below(s.position)).collect();
    if floors.is_empty() {
        return Ok(not_judged("not judged: there is no floor below the sensors"));
    }
    floors.sort_by(f64::total_cmp);
    let floor = floors[floors.len() / 2];
    let step = plan.len().div_ceil(EYES);
    let eyes: Vec<DVec3> = plan.iter().step_by(step).map(|s| s.position.truncate().extend(floor + EYE_HEIGHT)).collect();
    let seen: Vec<Seen> = eyes.par_iter().map(|eye| outlook.seen_from(*eye)).collect();
    write(&context.store.metrics_path(&format!("{}_view_out", group.name))?, &eyes, &seen)?;
    Ok(vec![of_views(context, &seen, plan.len()), of_sun(context, outlook, &seen, floor)])
}

fn of_views(context: &Context<'_>, seen: &[Seen], sensors: usize) -> Metric {
    let views: Vec<ViewOut> = seen.iter().map(|s| s.view).collect();
    let value = share_of(&views, |v| v.level() >= Level::Minimum).unwrap_or_default();
    let class = Decision { class: view_out::level_of(&views), probability_of_another: 0.0 };
    let eyes = match views.len() {
        n if n == sensors => format!("{n} eyes"),
        n => format!("{n} eyes, of {sensors} sensors"),
    };
    let metric = view_out_metric()
        .value(Estimated { value, standard_error: 0.0 })
        .class(&class, |l| l.name().into())
        .note(format!("{eyes}, {EYE_HEIGHT} m above the floor; the level is that of {:.0} % of them", 100.0 * view_out::AREA))
        .note("geometry alone: blinds are away, and colour and size of the openings are not looked at");
    let blurred: Vec<&str> = (context.inputs.windows.iter().enumerate())
        .filter(|(i, _)| !context.inputs.is_seen_through(*i))
        .map(|(_, w)| w.name.as_str())
        .collect();
    if blurred.is_empty() { metric } else { metric.note(format!("windows '{}' scatter most of the light: no view", blurred.join("', '"))) }
}

fn of_sun(context: &Context<'_>, outlook: &Outlook<'_>, seen: &[Seen], floor: f64) -> Metric {
    let metric = sunlight_metric();
    let (weather, section) = (&context.inputs.weather, &context.project.metrics);
    if !context.project.weather.has_site() {
        return metric.note("not judged: it is not known where the sun stands");
    }
    let windows: Vec<usize> = (0..context.inputs.windows.len()).filter(|w| seen.iter().any(|s| s.windows[*w])).collect();
    if windows.is_empty() {
        return metric.note("not judged: no window is seen from the sensors");
    }
    let (month, day) = section.sunlight_date;
    let minutes = outlook.minutes_of_sun(weather, day_of_year(month, day), section.sunlight_altitude, floor, &windows);
    let counted: Vec<&Vec<bool>> = minutes.iter().flatten().collect();
    let sunny = |minute: usize| counted.iter().any(|w| w[minute]);
    let value = (0..counted.first().map_or(0, |w| w.len())).filter(|m| sunny(*m)).count() as f64 / 60.0;
    let metric = match en17037::exposure_to_sunlight(value, section.sunlight_date) {
        Ok(level) => metric
            .value(Estimated { value, standard_error: 0.0 })
            .class(&Decision { class: level, probability_of_another: 0.0 }, |l| l.name().into()),
        Err(e) => return metric.note(e.message()),
    };
    let metric = metric
        .note(format!(
            "{} of {} windows that the room has; {day}.{month}., sun at least {}° high (the standard's angle depends on the place)",
            counted.len(),
            windows.len(),
            section.sunlight_altitude
        ))
        .note("reference points on the windows' surfaces as the model has them; blinds are away");
    match windows.len() - counted.len() {
        0 => metric,
        n => metric.note(format!("{n} windows end below the reference point")),
    }
}

fn write(path: &Path, eyes: &[DVec3], seen: &[Seen]) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        writeln!(out, "x,y,z,horizontal_sight_deg,distance_m,sky,landscape,ground,level").map_err(fault)?;
        for (p, s) in eyes.iter().zip(seen) {
            let (v, l) = (&s.view, s.view.layers);
            let distance = if v.distance_m.is_finite() { format!("{:.2}", v.distance_m) } else { "unlimited".into() };
            let [sky, landscape, ground] = [l.sky, l.landscape, l.ground].map(u8::from);
            writeln!(out, "{},{},{},{},{distance},{sky},{landscape},{ground},{}", p.x, p.y, p.z, v.sight_deg, v.level().name())
                .map_err(fault)?;
        }
        Ok(())
    })
}
