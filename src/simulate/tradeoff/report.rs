//! What a sweep found: the front, a recommendation, table and plot.

use super::{DGP_TARGET, Point, TARGET};
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::image::palette::{CLASS_COLORS, Color, INK};
use crate::image::scatter::{Panel, Point as Dot, Scatter};
use std::path::Path;

/// Points that no other of their program is both faster and better than, from the fastest.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < best;
        best = best.min(points[i].1);
        better
    });
    order
}

/// The fastest point that is good enough, or the best there is.
pub fn recommended(points: &[(f64, f64)], target: f64) -> Option<usize> {
    let front = front(points);
    front.iter().copied().find(|&i| points[i].1 <= target).or(front.last().copied())
}

/// Fronts and recommendations of a sweep, as indices of its points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Choice {
    /// Front of illuminance.
    pub front: Vec<usize>,
    /// Recommended for illuminance.
    pub recommended: Option<usize>,
    /// Front of glare.
    pub glare_front: Vec<usize>,
    /// Recommended for glare.
    pub glare_recommended: Option<usize>,
}

impl Choice {
    /// Of this program's points.
    pub fn of(points: &[Point]) -> Self {
        let pick = |value: &dyn Fn(&Point) -> Option<(f64, f64)>, target: f64| {
            let own: Vec<(usize, (f64, f64))> =
                points.iter().enumerate().filter(|(_, p)| p.program == "lucarne").filter_map(|(i, p)| Some((i, value(p)?))).collect();
            let values: Vec<(f64, f64)> = own.iter().map(|(_, v)| *v).collect();
            (front(&values).into_iter().map(|i| own[i].0).collect(), recommended(&values, target).map(|i| own[i].0))
        };
        let (front, recommended) = pick(&|p| p.illuminance.map(|m| (m.seconds, m.hourly)), TARGET);
        let (glare_front, glare_recommended) = pick(&|p| p.glare, DGP_TARGET);
        Self { front, recommended, glare_front, glare_recommended }
    }
}

/// Writes `tradeoff.csv`, `.png` and `.svg`.
///
/// # Errors
/// Failures of the file system; no points.
pub fn write(folder: &Path, title: &str, points: &[Point]) -> Result<Choice> {
    let choice = Choice::of(points);
    let path = folder.join("tradeoff.csv");
    write_atomically(&path, |out| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        writeln!(
            out,
            "program,knob,value,seconds,illuminance_error,annual_error,on_front,recommended,\
             glare_seconds,dgp_error,on_glare_front,recommended_for_glare"
        )
        .map_err(fault)?;
        for (i, p) in points.iter().enumerate() {
            let lux = p.illuminance.map_or_else(|| ",,".into(), |m| format!("{:.3},{:.6},{:.6}", m.seconds, m.hourly, m.annual));
            let glare = p.glare.map_or_else(|| ",".into(), |(s, e)| format!("{s:.3},{e:.6}"));
            let flag = |yes: bool| u8::from(yes);
            writeln!(
                out,
                "{},{},{},{lux},{},{},{glare},{},{}",
                p.program,
                p.knob,
                p.value,
                flag(choice.front.contains(&i)),
                flag(choice.recommended == Some(i)),
                flag(choice.glare_front.contains(&i)),
                flag(choice.glare_recommended == Some(i))
            )
            .map_err(fault)?;
        }
        Ok(())
    })?;
    let drawing = plot(title, points, &choice).draw()?;
    drawing.write(&folder.join("tradeoff.png"), 2.0)?;
    drawing.write(&folder.join("tradeoff.svg"), 1.0)?;
    Ok(choice)
}

fn plot(title: &str, points: &[Point], choice: &Choice) -> Scatter {
    let mut series: Vec<(String, Color)> = Vec::new();
    let number = |p: &Point, series: &mut Vec<(String, Color)>| {
        let (name, colour) = match p.program.as_str() {
            "lucarne" => (p.knob.clone(), CLASS_COLORS[series.len().min(CLASS_COLORS.len() - 1)]),
            other => (other.to_string(), INK),
        };
        series.iter().position(|(n, _)| *n == name).unwrap_or_else(|| {
            series.push((name, colour));
            series.len() - 1
        })
    };
    let numbers: Vec<usize> = points.iter().map(|p| number(p, &mut series)).collect();
    let panel = |title: String, axis: &str, value: &dyn Fn(&Point) -> Option<(f64, f64)>, front: &[usize], marked: Option<usize>, limit| {
        let at = |i: usize| value(&points[i]).map(|(x, y)| [x.max(1e-3), y.max(1e-9)]);
        let dots = (0..points.len())
            .filter_map(|i| Some(Dot { at: at(i)?, series: numbers[i], label: points[i].value.clone(), marked: marked == Some(i) }));
        Panel {
            title,
            axes: ["seconds".into(), axis.into()],
            points: dots.collect(),
            front: front.iter().filter_map(|&i| at(i)).collect(),
            limit: Some(limit),
        }
    };
    let percent = |p: &Point| p.illuminance.map(|m| (m.seconds, 100.0 * m.hourly));
    let mut panels = Vec::new();
    if points.iter().any(|p| p.illuminance.is_some()) {
        let title = format!("{title}: hourly illuminance");
        panels.push(panel(
            title,
            "error (rms of the hours, median sensor), %",
            &percent,
            &choice.front,
            choice.recommended,
            100.0 * TARGET,
        ));
    }
    if points.iter().any(|p| p.glare.is_some()) {
        let (front, marked) = (&choice.glare_front, choice.glare_recommended);
        panels.push(panel("DGP of all hours".into(), "error (rms)", &|p| p.glare, front, marked, DGP_TARGET));
    }
    let joined = series.iter().enumerate().filter(|(_, (n, _))| n != "basis").map(|(i, _)| i).collect();
    Scatter { panels, series, joined }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_is_faster_and_better_than() {
        let points = [(1.0, 0.5), (2.0, 0.1), (3.0, 0.2), (4.0, 0.01), (4.0, 0.02), (0.5, 0.9)];
        assert_eq!(front(&points), [5, 0, 1, 3]);
        assert_eq!(recommended(&points, 0.15), Some(1));
        assert_eq!(recommended(&points, 0.001), Some(3), "the best there is");
        assert_eq!(recommended(&[], 0.1), None);
    }
}
