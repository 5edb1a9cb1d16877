//! Windows in parts: over what V and D are averaged.
//!
//! `V·T·D` multiplies averages over a window. Where reveals, overhangs, fins or neighbours shade its parts
//! differently and the room sees them differently, the product of the averages is not the average of the products.
//! Divided into parts, each with a V and D of its own, a window has one T, one name and one trace of suns still:
//!
//! ```text
//! I = Σ over the parts k of V_k · T · D_k · S
//! ```
//!
//! Columns of V and rows of D count the bins of the first part, then those of the second, and so on. Memory and
//! the time of products grow with the parts; rays do not, as each part's bins get fewer.

mod look;

use self::look::{Look, MOST_OF_AUTO};
use super::Inputs;
use super::division::{Division, WHOLE_ALL_THE_SAME};
use crate::error::{Error, Result};
use crate::kernels::daylight_matrix::{DaylightOptions, unobstructed};
use crate::scene::windows::parts::grid_of;
use crate::simulate::project::parts::MOST_PARTS;
use crate::simulate::project::{Parts, Project, WindowSection};

/// Bytes of V and D, with their replicates, that `parts = "auto"` may come to, and that any division may.
const BYTES_OF_AUTO: f64 = 2e9;
const MOST_BYTES: f64 = 16e9;
/// Bytes on disk that pictures' V may come to by `"auto"`.
const PICTURES_OF_AUTO: f64 = 8e9;
/// Error of a year's light that `"auto"` leaves if it can, whatever the target: what a first look can tell, and what
/// nobody sees.
const LEAST_LIMIT: f64 = 0.0025;
const MOST_LIMIT: f64 = 0.005;

/// Why a window cannot or need not be divided, if that is known without a look.
fn whole_because(project: &Project, inputs: &Inputs, window: usize) -> Option<&'static str> {
    if inputs.choice(project).direct && project.views.is_empty() {
        return Some("the sensors see the sky through the pane itself: it needs no V and D");
    }
    // Exact only where D is not sampled.
    if project.quality.prune && unobstructed::nothing_before(&inputs.scene, &inputs.windows[window].window) {
        return Some("nothing stands before it: D is the same for all of its parts");
    }
    None
}

/// The first V or D of the project that was made elsewhere, for windows as wholes.
fn given(project: &Project, inputs: &Inputs) -> Option<String> {
    let daylight = inputs.windows.iter().find(|w| w.daylight.is_some()).map(|w| format!("D of window '{}'", w.name));
    let view = || inputs.sensors.iter().find(|g| g.view.is_some()).map(|g| format!("V of sensors '{}'", g.name));
    let picture = || project.views.iter().find(|v| v.given.view.is_some()).map(|v| format!("V of view '{}'", v.name));
    daylight.or_else(view).or_else(picture)
}

/// Divides all windows as the project asks.
///
/// # Errors
/// Parts beside matrices made elsewhere; parts that ask for more memory than machines have.
pub(super) fn divide(project: &Project, inputs: &mut Inputs) -> Result<()> {
    if inputs.windows.iter().all(|w| w.division.asked == Parts::default()) {
        for i in 0..inputs.windows.len() {
            inputs.windows[i].division.because = whole_because(project, inputs, i).unwrap_or(WHOLE_ALL_THE_SAME).into();
        }
        return Ok(());
    }
    let given = given(project, inputs);
    let mut grids = vec![[1, 1]; inputs.windows.len()];
    let mut auto = vec![false; inputs.windows.len()];
    for (i, grid) in grids.iter_mut().enumerate() {
        let window = &inputs.windows[i];
        let asked = match window.division.asked {
            Parts::Auto => None,
            Parts::Number(n) => Some(grid_of(n, window.window.extent())),
            Parts::Grid(grid) => Some(grid),
        };
        let because = match (whole_because(project, inputs, i), &given) {
            (Some(because), _) => because.to_string(),
            (None, Some(given)) if asked.is_none() => format!("{given} was made elsewhere, for the whole window"),
            (None, Some(given)) if asked != Some([1, 1]) => {
                let error =
                    Error::new(format!("window '{}' is to be divided, but {given} was made elsewhere, for whole windows", window.name));
                let error = error.help("write parts = 1, or leave the matrix out to have it traced for each part");
                return Err(section(project, &window.name).map_or_else(|| error.clone(), |s| s.parts_place.of(error.clone())));
            }
            (None, _) => {
                (auto[i], *grid) = (asked.is_none(), asked.unwrap_or([1, 1]));
                (if asked == Some([1, 1]) { WHOLE_ALL_THE_SAME } else { "as the project asks" }).to_string()
            }
        };
        inputs.windows[i].division.because = because;
    }
    if auto.contains(&true) {
        choose(project, inputs, &auto, &mut grids);
    }
    for (window, grid) in inputs.windows.iter_mut().zip(&grids) {
        window.division.grid = *grid;
        if *grid != [1, 1] {
            window.parts = window.window.in_parts(*grid);
            window.division.count = window.parts.len();
        }
    }
    check_memory(project, inputs)?;
    if grids.iter().any(|g| *g != [1, 1]) {
        let named = |w: &super::ProjectWindow| {
            w.parts.iter().map(|p| crate::scene::Window { name: w.name.clone(), ..p.clone() }).collect::<Vec<_>>()
        };
        inputs.scene.windows = inputs.windows.iter().flat_map(named).collect();
    }
    Ok(())
}

/// Divides all windows otherwise than the project asks.
///
/// # Errors
/// As where a project's windows are divided: matrices made elsewhere, and parts that ask for too much memory.
pub(crate) fn divide_anew(project: &Project, inputs: &mut Inputs, parts: Parts) -> Result<()> {
    for window in &mut inputs.windows {
        window.parts = vec![window.window.clone()];
        window.division = Division { asked: parts, ..Division::default() };
    }
    inputs.scene.windows = inputs.windows.iter().map(|w| crate::scene::Window { name: w.name.clone(), ..w.window.clone() }).collect();
    divide(project, inputs)
}

fn section<'p>(project: &'p Project, window: &str) -> Option<&'p WindowSection> {
    project.windows.iter().find(|s| s.name == window).or_else(|| project.windows.iter().find(|s| s.is_of(window)))
}

/// Bytes of V of the sensors and of D, with the replicates of both, for so many bins.
fn bytes_of(project: &Project, inputs: &Inputs, bins: usize) -> f64 {
    let sensors: usize = inputs.sensors.iter().map(|g| g.sensors.len()).sum();
    let receivers = if inputs.choice(project).direct { 0 } else { sensors };
    let direct_too = if inputs.choice(project).phases == 5 { 2.0 } else { 1.0 };
    let copies = (f64::from(DaylightOptions::default().batches) + 1.0) * direct_too;
    12.0 * copies * bins as f64 * (inputs.sky(project).len() + receivers) as f64
}

/// Bytes on disk of the pictures' V.
fn pictures_of(project: &Project, inputs: &Inputs, bins: usize) -> f64 {
    let direct_too = if inputs.choice(project).phases == 5 { 2.0 } else { 1.0 };
    let pixels: usize = project.views.iter().filter_map(|v| v.raster().ok()).map(|r| r.len()).sum();
    12.0 * direct_too * (bins * pixels) as f64
}

fn check_memory(project: &Project, inputs: &Inputs) -> Result<()> {
    let bytes = bytes_of(project, inputs, inputs.bins());
    let Some(most) = inputs.windows.iter().max_by_key(|w| w.parts.len()).filter(|w| w.parts.len() > 1 && bytes > MOST_BYTES) else {
        return Ok(());
    };
    let error = Error::new(format!(
        "window '{}' in {} parts: V and D of all windows, with their replicates, would take {:.0} GB, more than {:.0}",
        most.name,
        most.parts.len(),
        bytes / 1e9,
        MOST_BYTES / 1e9
    ))
    .help("take fewer parts, parts = \"auto\", or a coarser sky: sky_subdivision = 2 in [method]");
    Err(section(project, &most.name).map_or_else(|| error.clone(), |s| s.parts_place.of(error.clone())))
}

/// What a division may leave of a year's light.
fn limit(project: &Project) -> f64 {
    project.quality.target().map_or(MOST_LIMIT, |target| (target / 2.0).clamp(LEAST_LIMIT, MOST_LIMIT))
}

/// Divides the windows whose parts are left open until the errors of all together are below the limit: at each step
/// the window that is most wrong at the worst receiver gets twice as many.
fn choose(project: &Project, inputs: &mut Inputs, auto: &[bool], grids: &mut [[usize; 2]]) {
    let limit = limit(project);
    let Some(look) = Look::new(project, inputs) else {
        for (window, _) in inputs.windows.iter_mut().zip(auto).filter(|(_, auto)| **auto) {
            window.division.because = "there are too many windows for a first look, or nothing that sees them".into();
        }
        return;
    };
    let mut count = vec![1usize; grids.len()];
    let bins = |count: &[usize]| -> usize { inputs.windows.iter().zip(count).map(|(w, n)| n * w.window.basis.len()).sum() };
    loop {
        // Parts that are asked for are taken for fine enough.
        let error = |w: usize, receiver: usize| if auto[w] { look.error(w, grids[w], receiver) } else { 0.0 };
        let all = |receiver: &usize| (0..grids.len()).map(|w| error(w, *receiver)).sum::<f64>();
        let Some(worst) = (0..look.receivers()).max_by(|a, b| all(a).total_cmp(&all(b))).filter(|r| all(r) > limit) else { break };
        let can_grow = |w: &usize| {
            let mut more = count.clone();
            more[*w] *= 2;
            let bins = bins(&more);
            auto[*w]
                && more[*w] <= MOST_OF_AUTO.min(look.finest(*w))
                && bytes_of(project, inputs, bins) <= BYTES_OF_AUTO
                && pictures_of(project, inputs, bins) <= PICTURES_OF_AUTO
        };
        let Some(next) = (0..grids.len()).filter(can_grow).max_by(|a, b| error(*a, worst).total_cmp(&error(*b, worst))) else { break };
        if error(next, worst) == 0.0 {
            break;
        }
        count[next] *= 2;
        grids[next] = look.best_grid(next, count[next]);
    }
    for (w, window) in inputs.windows.iter_mut().enumerate().filter(|(w, _)| auto[*w]) {
        let [whole, left] = [[1, 1], grids[w]].map(|grid| look.worst(w, grid));
        let percent = |error: f64| format!("{:.1} %", 100.0 * error);
        let division = &mut window.division;
        (division.error_of_whole, division.error_left) = (Some(whole), Some(left));
        division.because = match grids[w] {
            [1, 1] => format!("a first look finds that averages over the whole change a year's light by {} at most", percent(whole)),
            _ => {
                let short = if left > limit { ": more than asked for, but no more parts are taken" } else { "" };
                format!("by a first look they take the error of averages from {} to {}{short}", percent(whole), percent(left))
            }
        };
    }
}

/// By what averages over whole windows change a year's light at the worst receiver, relative: for each window that is
/// whole though something stands before it. A first look, of a second or less.
pub fn errors_of_wholes(project: &Project, inputs: &Inputs) -> Vec<Option<f64>> {
    let open: Vec<bool> = (0..inputs.windows.len())
        .map(|w| {
            let division = &inputs.windows[w].division;
            division.count == 1 && division.error_of_whole.is_none() && whole_because(project, inputs, w).is_none()
        })
        .collect();
    let look = if open.contains(&true) { Look::new(project, inputs) } else { None };
    let of = |w: usize| look.as_ref().filter(|_| open[w]).map(|look| look.worst(w, [1, 1]));
    (0..open.len()).map(of).collect()
}

const _: () = assert!(MOST_OF_AUTO <= MOST_PARTS);

#[cfg(test)]
mod tests;
