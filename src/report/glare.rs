//! What the views tell: carpets of the year, a table of the classes, the picture of the worst hour.

use super::parts::{Figure, Part, Section, Table};
use super::sensors::days;
use crate::error::Result;
use crate::glare::annual::CLASS_LIMITS;
use crate::image::falsecolor::FalseColor;
use crate::image::palette::short_number;
use crate::simulate::Results;
use crate::simulate::results::glare::carpet::carpet;
use crate::simulate::results::glare::read::GlareYear;

/// Most views of which carpets and pictures are drawn; of more the table alone is shown.
const MOST_VIEWS: usize = 24;
/// Largest picture that is computed for a report, pixels × columns of its matrix.
const MOST_WORK: usize = 400_000_000;

/// Glare of all views and states.
pub(super) fn section(results: &Results) -> Result<Section> {
    let title = "Views and glare";
    let year = &results.year;
    let mut parts = Vec::new();
    let annual = year.folder().join("glare/annual.csv");
    if let Some(table) =
        std::fs::read_to_string(annual).ok().and_then(|text| Table::from_csv("glare", "Glare of the occupied hours", &text))
    {
        parts.push(Part::Table(named(table)));
        let [a, b, c] = CLASS_LIMITS;
        parts.push(Part::Text(format!(
            "Classes after DGP: imperceptible to {a:.2}, perceptible to {b:.2}, disturbing to {c:.2}, intolerable above. Undecided are hours \
             whose class the noise of the sampling leaves open; they are listed in glare/undecided.csv."
        )));
    }
    let method = year.summary.glare.as_ref().map_or("DGP", |g| g.method.as_str());
    let days = days(results);
    for glare in year.glare.iter().take(MOST_VIEWS) {
        let mut figures = Vec::new();
        if let Some(days) = &days {
            figures.push(Figure {
                name: format!("glare_{}", glare.name().replace(", ", "_")),
                label: format!("Glare at every hour of the year, {}", glare.name()),
                caption: String::new(),
                drawing: carpet(days, &|step| glare.dgp[step], &glare.name(), method)?,
            });
        }
        if glare.state.is_empty() {
            figures.extend(worst(results, glare)?);
        }
        if !figures.is_empty() {
            parts.push(Part::Heading(glare.name()));
            parts.push(Part::Figures(figures));
        }
    }
    if year.glare.len() > MOST_VIEWS {
        parts.push(Part::Text(format!("{} of {} views and states are drawn; the table has all.", MOST_VIEWS, year.glare.len())));
    }
    if parts.is_empty() {
        parts.push(Part::Text("The project asks for no glare.".into()));
    }
    Ok(Section { title, parts })
}

/// Rows above which a table of views is not turned.
const FEW_VIEWS: usize = 3;

/// The table of a year with its columns in words; of a few views a row for each number.
fn named(mut table: Table) -> Table {
    for head in &mut table.head {
        let word = match head.as_str() {
            "dgp exceeded 5 percent" => "DGP exceeded in 5 % of them",
            "en17037 protection" => "protection by EN 17037",
            "mean dgp" => "mean DGP",
            "greatest dgp" => "greatest DGP",
            "glare autonomy" => "glare autonomy (DGP not disturbing)",
            _ => continue,
        };
        *head = word.into();
    }
    if table.rows.len() > FEW_VIEWS {
        return table;
    }
    let column = |i: usize| std::iter::once(table.head[i].clone()).chain(table.rows.iter().map(|r| r[i].clone())).collect();
    let mut columns = (0..table.head.len()).map(column).collect::<Vec<Vec<String>>>().into_iter();
    let head = columns.next().unwrap_or_default();
    Table { head, rows: columns.collect(), ..table }
}

/// The picture of the hour of greatest DGP, in false colour.
fn worst(results: &Results, glare: &GlareYear) -> Result<Option<Figure>> {
    let year = &results.year;
    let greatest = |(_, a): &(usize, &f64), (_, b): &(usize, &f64)| a.total_cmp(b);
    let Some((step, dgp)) = glare.dgp.iter().enumerate().filter(|(_, v)| v.is_finite()).max_by(greatest) else { return Ok(None) };
    let Some(view) = year.views.iter().find(|v| v.name == glare.view) else { return Ok(None) };
    if view.width * view.height * view.bins > MOST_WORK {
        return Ok(None);
    }
    let picture = year.picture(&view.name, step)?;
    let look = FalseColor { decades: Some(3.0), ..FalseColor::default() };
    Ok(Some(Figure {
        name: format!("worst_{}", glare.view),
        label: format!("View {} in false colour", glare.view),
        caption: format!("The hour of greatest DGP, {}: {}", short_number((dgp * 1000.0).round() / 1000.0), year.times[step]),
        drawing: look.draw(&picture, None)?,
    }))
}
