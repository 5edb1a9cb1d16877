//! The carpet of a view's year in the classes of daylight glare.

use crate::error::Result;
use crate::glare::annual::CLASS_LIMITS;
use crate::image::carpet::{Carpet, Coloring};
use crate::image::drawing::Drawing;
use crate::image::palette::Palette;
use crate::weather::Days;

/// Draws DGP by step (NaN where there is no light) over the days of a year.
///
/// # Errors
/// Days that are no year's.
pub(crate) fn carpet(days: &Days, dgp: &dyn Fn(usize) -> f64, name: &str, method: &str) -> Result<Drawing> {
    let values: Vec<f64> = days.steps.iter().map(|step| step.map_or(f64::NAN, dgp)).collect();
    let [a, b, c] = CLASS_LIMITS;
    let names = [
        format!("imperceptible, to {a:.2}"),
        format!("perceptible, to {b:.2}"),
        format!("disturbing, to {c:.2}"),
        "intolerable".to_string(),
    ];
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let gaps = days.steps.contains(&None);
    Carpet {
        values: &values,
        steps_per_day: days.per_day,
        first_day: days.first,
        leap: days.leap,
        title: format!("Daylight glare probability, {name}"),
        label: format!("DGP ({method})"),
        // A class holds its upper limit.
        coloring: Coloring::classes(&CLASS_LIMITS.map(f64::next_up), &names, Palette::Viridis)?,
        missing: Some(if gaps { "night, or not in the weather file" } else { "night" }.into()),
        shares: true,
    }
    .draw()
}
