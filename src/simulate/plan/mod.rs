//! What a run will model, what it leaves out because the scene does not need it, and what it costs:
//! `lucarne plan`. Nothing is traced and no device is needed.

mod control;
pub(crate) mod costs;
mod lives;
pub(crate) mod presets;

use self::costs::{PhasePlan, costs, daylight_rays};
use crate::error::Result;
use crate::kernels::daylight_matrix::unobstructed;
use crate::kernels::trace::{TraceTables, WindowSurfaces};
use crate::scene::Window;
use crate::simulate::inputs::parts::errors_of_wholes;
use crate::simulate::inputs::shade::Shade;
use crate::simulate::inputs::suns::SunCensus;
use crate::simulate::inputs::{Inputs, ProjectWindow};
use crate::simulate::project::Project;
use crate::sky::{SkyOptions, sky_columns};
use serde::Serialize;
use std::fmt;

/// Something that is not computed, and why that changes nothing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Omission {
    /// What.
    pub what: String,
    /// Why it may be left out.
    pub because: String,
    /// What that saves, roughly.
    pub saves: String,
    /// How far results may differ by it: "nothing" where it is exact.
    pub changes: String,
}

/// The plan of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunPlan {
    /// 2, 3 or 5, of pictures and glare; of sensors too, unless they are direct.
    pub phases: u32,
    /// Method of the sensors, with its formula.
    pub sensors_method: String,
    /// Why.
    pub phases_because: String,
    /// What `[quality]` asks for.
    pub preset: String,
    /// Reinhart subdivision of the sky.
    pub sky_subdivision: usize,
    /// Whether it was left to the glazing.
    pub sky_follows_glazing: bool,
    /// Hours that the weather covers.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours: f64,
    /// Those that are not night.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub lit_hours: f64,
    /// What is modelled, one line per item.
    pub model: Vec<String>,
    /// Suns of five phases.
    pub suns: Option<SunCensus>,
    /// Phases in the order of their computation.
    pub costs: Vec<PhasePlan>,
    /// What is left out.
    pub omissions: Vec<Omission>,
    /// What is modelled though this project alone would not need it, and why.
    pub kept: Vec<String>,
}

/// Makes the plan of a project.
///
/// # Errors
/// Views that cannot be read, hours that the weather does not have.
pub fn plan(project: &Project, inputs: &Inputs) -> Result<RunPlan> {
    let choice = inputs.choice(project);
    let columns = sky_columns(&inputs.weather, &SkyOptions::default())?;
    let lit = columns.iter().filter(|c| !c.black).count();
    let steps = inputs.weather.steps();
    let windows: Vec<Window> = inputs.windows.iter().map(|w| w.window.clone()).collect();
    let suns = (choice.phases == 5).then(|| inputs.sun_set(project)).transpose()?;
    let mut plan = RunPlan {
        phases: choice.phases,
        sensors_method: choice.formula().to_string(),
        phases_because: choice.why.to_string(),
        preset: project.quality.name(),
        sky_subdivision: inputs.sky(project).subdivision(),
        sky_follows_glazing: project.method.sky.is_none() && inputs.weather.given.is_none(),
        hours: steps.hours(steps.len()),
        lit_hours: steps.hours(lit),
        model: model(project, inputs),
        costs: costs(project, inputs, suns.as_ref(), lit)?,
        suns: suns.map(|s| s.census),
        omissions: Vec::new(),
        kept: kept(inputs),
    };
    plan.omissions = omissions(&plan, project, inputs, &windows)?;
    Ok(plan)
}

fn model(project: &Project, inputs: &Inputs) -> Vec<String> {
    let direct = inputs.choice(project).direct;
    let scene = &inputs.scene;
    let mut lines = vec![project.weather.describe(&inputs.weather)];
    lines.push(format!("scene: {} triangles of {} materials, the only ones read", scene.triangles.len(), scene.materials.len()));
    let wholes = errors_of_wholes(project, inputs);
    for (window, whole) in inputs.windows.iter().zip(&wholes) {
        let [azimuth, altitude] = window.window.faces();
        let tilt = if altitude == 0.0 { String::new() } else { format!(" and {altitude}° up") };
        let parts = window.division.describe().map_or_else(String::new, |parts| format!(" in each of {parts}"));
        let (name, area, bins) = (&window.name, window.window.area(), window.window.basis.len());
        let start = format!("window {name}: {area:.2} m² facing {azimuth}°{tilt}");
        match window.group {
            None => {
                let shade = way_of_suns(window.glass.is_some(), window.shade.as_ref(), window.pane.is_some());
                lines.push(format!("{start}, {}, {bins} bins{parts}, {shade}", window.made_of));
            }
            Some(group) => {
                let group = &inputs.facade.groups()[group].name;
                lines.push(format!("{start}, {bins} bins{parts}, of group '{group}'"));
                lines.extend(window.states.iter().map(|state| {
                    let shade = way_of_suns(state.glass.is_some(), state.shade.as_ref(), state.pane.is_some());
                    format!("window {name}, state '{}': {}, {shade}", state.name, state.made_of)
                }));
            }
        }
        lines.extend(parts_of(window, *whole));
    }
    lines.extend(inputs.glass_left.iter().cloned());
    lines.extend(control::lines(project, inputs));
    for group in &inputs.sensors {
        let how = if direct { ", each sees the sky itself, through all glass and by any way" } else { "" };
        let quantity = project.output.quantity;
        let what = if quantity.is_solar() { format!(", {} in {}", quantity.name(), quantity.unit()) } else { String::new() };
        lines.push(format!("sensors {}: {}{what}{how}", group.name, group.sensors.len()));
    }
    if direct {
        let pictures = "by bins of the windows, in five phases: pictures share V and D among all hours and pixels";
        lines.extend(project.views.iter().map(|view| format!("view {}: {pictures}", view.name)));
    }
    lines
}

fn way_of_suns(is_glass: bool, shade: Option<&Shade>, has_pane: bool) -> String {
    match shade {
        Some(_) if is_glass => "the sun through the pane itself".to_string(),
        Some(shade) => format!("the sun through {} triangles of its shade", shade.scene.triangles.len()),
        None if has_pane => "the sun through its scattering data".to_string(),
        None => "the sun in patches of the sky, by its BSDF".to_string(),
    }
}

/// What dividing a window does, or would do.
fn parts_of(window: &ProjectWindow, error_of_whole: Option<f64>) -> Option<String> {
    let (name, division) = (&window.name, &window.division);
    if division.error_of_whole.is_some() || division.count > 1 {
        let cost = if division.count > 1 { "; V and D grow with the parts, in memory and in the time of products" } else { "" };
        return Some(format!("window {name}, parts: {}{cost}", division.because));
    }
    // Less is not worth a word.
    let error = error_of_whole.filter(|e| *e >= 0.0025)?;
    Some(format!(
        "window {name} is whole: by a first look, V and D as averages over it change a year's light by {:.1} % at the worst sensor; \
         parts = \"auto\" divides it",
        100.0 * error
    ))
}

fn omissions(plan: &RunPlan, project: &Project, inputs: &Inputs, windows: &[Window]) -> Result<Vec<Omission>> {
    let mut all = Vec::new();
    let mut leave = |what: String, because: &str, saves: String, changes: &str| {
        all.push(Omission { what, because: because.to_string(), saves, changes: changes.to_string() });
    };
    const EXACT: &str = "nothing";
    let direct = inputs.choice(project).direct;
    let share = |part: f64, of: f64| format!("{:.0} %", 100.0 * part / of.max(1e-9));
    if let Some(suns) = &plan.suns {
        let per_sun = plan.costs.iter().find(|p| p.name.starts_with("Cds")).map_or(0.0, |p| p.rays / suns.needed.max(1) as f64);
        if suns.never > 0 {
            leave(
                format!("{} of {} suns", suns.never, suns.all),
                "no hour of the weather has its sun there",
                format!("{} rays", rays(suns.never as f64 * per_sun)),
                EXACT,
            );
        }
        if suns.behind_windows > 0 {
            leave(
                format!("{} suns, in {} hours", suns.behind_windows, suns.hours_behind_windows),
                "they stand behind every window that suns are traced through: no light of theirs comes in straight",
                format!("{} rays", rays(suns.behind_windows as f64 * per_sun)),
                "the suns' noise alone (they get other random numbers)",
            );
        }
        if suns.hours_without > 0.0 {
            leave(format!("suns of {} hours", suns.hours_without), "night, or clouds before the sun", "their products".into(), EXACT);
        }
        if suns.hours_below_horizon > 0.0 && suns.scheme.starts_with("hourly") {
            leave(
                format!("suns of {} hours", suns.hours_below_horizon),
                "the sun is below the horizon although the weather has direct light",
                "their products".into(),
                "less than the light of a sun that has set",
            );
        }
        if direct {
            leave(
                "samples of suns' own for what mirrors, panes and gloss throw of them".into(),
                "it stays in the sun's patches of the sky, as light of C",
                "their rays".into(),
                "hours in which much of a sensor's light comes so are less certain than stated",
            );
        }
        if !inputs.any_window(|w| w.pane.is_some()) {
            leave("scattering data in rays to suns".into(), "no window has a tensor tree", "its kernels".into(), EXACT);
        }
    } else {
        leave(
            "all suns".into(),
            "no sharp patches of sun are asked for: the sky's patches hold the sun",
            "Cds, Vd and Dd".into(),
            "the method is three-phase by choice: sun is spread over patches",
        );
    }
    let night = plan.hours - plan.lit_hours;
    if night > 0.0 {
        let what = format!("sky and pictures of {night} hours");
        leave(what, "night: they are zero", format!("{} of the products", share(night, plan.hours)), EXACT);
    }
    let needs_windows = !direct || !project.views.is_empty();
    let free = |w: &ProjectWindow| needs_windows && unobstructed::nothing_before(&inputs.scene, &w.window);
    for (i, window) in inputs.windows.iter().enumerate().filter(|(_, w)| free(w)) {
        leave(
            format!("rays of D of {}", window.name),
            "nothing stands before it: a quadrature gives the sky's shares of its bins",
            format!("{} rays, and D's noise", rays(daylight_rays(project, inputs, i))),
            "entries by 2e-4 of their row's sum at most",
        );
    }
    for view in &project.views {
        let raster = view.raster()?;
        let outside = (0..raster.len()).filter(|p| !raster.is_seen(p % raster.width(), p / raster.width())).count();
        if outside > 0 {
            let what = format!("{outside} of {} pixels of {}", raster.len(), view.name);
            leave(what, "they are outside the view", format!("{} of its rays", share(outside as f64, raster.len() as f64)), EXACT);
        }
    }
    if !needs_windows {
        if !inputs.windows.is_empty() {
            let because = "the sensors see the sky through the panes themselves, and there are no views";
            leave("V, T and D of the windows".into(), because, "their rays".into(), EXACT);
        }
        return Ok(all);
    }
    let features = TraceTables::new(&inputs.scene, windows, WindowSurfaces::Absorb)?.features;
    if features.grey {
        leave("two of three channels of D".into(), "the scene is grey: they are equal", "two thirds of D's sums".into(), EXACT);
    }
    if !features.glass {
        let because = "the scene has no glass: the first surface met ends a ray";
        leave("panes, in the rays of V".into(), because, "the shaders' loops through panes".into(), EXACT);
    }
    if !features.specular && !features.glass {
        leave("paths to mirrors".into(), "nothing reflects or transmits other than diffusely", "paths that find none".into(), EXACT);
    }
    let shades = inputs.windows_in_use();
    let panes = shades
        .iter()
        .filter_map(|w| w.shade.as_ref())
        .any(|s| s.scene.materials.iter().any(|m| matches!(m.kind, crate::scene::MaterialKind::Glass { .. })));
    if plan.phases == 5 && !panes && !features.glass {
        let because = "neither scene nor shades have glass";
        leave("panes, in the rays to suns".into(), because, "the shaders' loops through panes".into(), EXACT);
    }
    Ok(all)
}

/// Bins that T leaves dark are traced all the same.
fn kept(inputs: &Inputs) -> Vec<String> {
    let mut lines = Vec::new();
    for window in &inputs.windows {
        let t = &window.transmission;
        let transmits = |bin: &usize| (0..t.rows()).any(|out| t.at(out, *bin).iter().any(|v| *v != 0.0));
        let dark = t.cols() - (0..t.cols()).filter(transmits).count();
        if dark > 0 {
            lines.push(format!(
                "{dark} of {} incident bins of {}, though its BSDF lets none of their light through: D serves other BSDFs too",
                t.cols(),
                window.name
            ));
        }
    }
    lines
}

fn bytes(n: usize) -> String {
    match n {
        0..1_000_000 => format!("{} kB", n.div_ceil(1000)),
        1_000_000..1_000_000_000 => format!("{:.0} MB", n as f64 / 1e6),
        _ => format!("{:.1} GB", n as f64 / 1e9),
    }
}

fn rays(n: f64) -> String {
    match n {
        0.0 => "none".into(),
        n if n < 1e6 => format!("{:.0} thousand", n / 1e3),
        n if n < 1e9 => format!("{:.0} million", n / 1e6),
        n => format!("{:.1} billion", n / 1e9),
    }
}

impl fmt::Display for RunPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n  {}", self.sensors_method, self.phases_because)?;
        writeln!(
            f,
            "  sky MF:{}{}, {} hours of which {} have light, quality {}",
            self.sky_subdivision,
            if self.sky_follows_glazing { " (as the glazing asks)" } else { "" },
            self.hours,
            self.lit_hours,
            self.preset
        )?;
        writeln!(f, "\nWhat is modelled")?;
        for line in &self.model {
            writeln!(f, "  {line}")?;
        }
        if let Some(s) = &self.suns {
            writeln!(f, "  suns {}: {} of {} are traced, for {} hours", s.scheme, s.needed, s.all, s.hours - s.hours_behind_windows)?;
        }
        writeln!(f, "\nWhat is left out")?;
        for omission in &self.omissions {
            writeln!(f, "  {}: {}", omission.what, omission.because)?;
            writeln!(f, "      saves {}; changes {}", omission.saves, omission.changes)?;
        }
        if !self.kept.is_empty() {
            writeln!(f, "\nWhat is modelled all the same")?;
            for line in &self.kept {
                writeln!(f, "  {line}")?;
            }
        }
        writeln!(f, "\n{:<22} {:>24} {:>9} {:>15} {:>12}", "Phase", "size", "memory", "rays, about", "slow device")?;
        for p in &self.costs {
            let size = format!("{} {} x {} {}", p.rows.0, p.rows.1, p.columns.0, p.columns.1);
            let seconds = if p.slow_seconds >= 0.5 { format!("{:.0} s", p.slow_seconds) } else { String::new() };
            writeln!(f, "{:<22} {size:>24} {:>9} {:>15} {seconds:>12}", p.name, bytes(p.bytes), rays(p.rays))?;
        }
        let total: f64 = self.costs.iter().map(|p| p.slow_seconds).sum();
        write!(f, "Slow: software Vulkan on two cores, about {total:.0} s in all; a discrete GPU traces some hundred times as fast.")
    }
}

#[cfg(test)]
mod tests;
