//! What a report is made of.

use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::image::drawing::Drawing;
use crate::simulate::Summary;
use std::path::Path;

/// Factor from the pixels of a figure to those of its PNG.
const PNG_SCALE: f64 = 2.0;

/// A chapter.
#[derive(Debug, Clone)]
pub(super) struct Section {
    /// Its title.
    pub title: &'static str,
    /// What it holds, in order.
    pub parts: Vec<Part>,
}

/// A piece of a section.
#[derive(Debug, Clone)]
pub(super) enum Part {
    /// A paragraph.
    Text(String),
    /// A title within the section.
    Heading(String),
    /// Names and what they are.
    Facts(Vec<(&'static str, String)>),
    /// Messages, one per line.
    Notes(Vec<String>),
    /// A table.
    Table(Table),
    /// Figures beside each other.
    Figures(Vec<Figure>),
}

/// A table with a line of column names.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    /// Name of its files.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// Names of the columns.
    pub head: Vec<String>,
    /// Rows of as many texts.
    pub rows: Vec<Vec<String>>,
}

/// A drawing with what it shows.
#[derive(Debug, Clone)]
pub(super) struct Figure {
    /// Name of its files.
    pub name: String,
    /// What it shows, for who cannot see it.
    pub label: String,
    /// What its own title does not say; may be empty.
    pub caption: String,
    /// The drawing.
    pub drawing: Drawing,
}

impl Table {
    /// A table of these columns without rows.
    pub fn new(name: &str, caption: &str, head: &[&str]) -> Self {
        Self { name: name.into(), caption: caption.into(), head: head.iter().map(|h| (*h).into()).collect(), rows: Vec::new() }
    }

    /// A table as a file of comma-separated values has it; nothing if it has no rows.
    pub fn from_csv(name: &str, caption: &str, text: &str) -> Option<Self> {
        let cells = |line: &str| line.split(',').map(|c| c.trim().to_string()).collect::<Vec<_>>();
        let mut lines = text.lines().filter(|l| !l.trim().is_empty()).map(cells);
        let head: Vec<String> = lines.next()?.iter().map(|h| h.replace('_', " ")).collect();
        let rows: Vec<Vec<String>> = lines.filter(|r| r.len() == head.len()).collect();
        (!rows.is_empty()).then(|| Self { name: name.into(), caption: caption.into(), head, rows })
    }

    /// Comma-separated values; what holds a comma or a quotation mark stands in quotation marks.
    fn csv(&self) -> String {
        let cell = |text: &String| {
            if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.clone() }
        };
        let line = |cells: &Vec<String>| cells.iter().map(cell).collect::<Vec<_>>().join(",") + "\n";
        std::iter::once(&self.head).chain(&self.rows).map(line).collect()
    }

    /// A list of objects by the columns' names.
    fn json(&self) -> String {
        let object = |row: &Vec<String>| -> serde_json::Value {
            self.head
                .iter()
                .zip(row)
                .map(|(h, c)| (h.clone(), serde_json::Value::from(c.clone())))
                .collect::<serde_json::Map<_, _>>()
                .into()
        };
        format!("{:#}\n", serde_json::Value::from(self.rows.iter().map(object).collect::<Vec<_>>()))
    }
}

impl Section {
    /// Writes its figures and tables; gives the number of files.
    pub fn write_parts(&self, folder: &Path) -> Result<usize> {
        let mut count = 0;
        for part in &self.parts {
            match part {
                Part::Figures(figures) => {
                    for figure in figures {
                        for ending in ["svg", "png"] {
                            figure.drawing.write(&folder.join(format!("{}.{ending}", file_name(&figure.name))), PNG_SCALE)?;
                            count += 1;
                        }
                    }
                }
                Part::Table(table) => {
                    for (ending, text) in [("csv", table.csv()), ("json", table.json())] {
                        let path = folder.join(format!("{}.{ending}", file_name(&table.name)));
                        write_atomically(&path, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io(&path, &e)))?;
                        count += 1;
                    }
                }
                Part::Text(_) | Part::Heading(_) | Part::Facts(_) | Part::Notes(_) => {}
            }
        }
        Ok(count)
    }
}

/// A name without what files' names cannot have everywhere.
pub(super) fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' };
    name.chars().map(plain).collect::<String>().trim_start_matches('.').to_string()
}

/// A value with the half width of its interval of 95 %: `417 ± 3`. Of the interval two digits are kept and of the
/// value as many places.
pub(super) fn with_interval(value: f64, half_width: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if !(half_width.is_finite() && half_width > 0.0) {
        return crate::image::palette::rounded_number(value);
    }
    // The place of the second digit.
    let place = half_width.log10().floor() as i32 - 1;
    let unit = 10f64.powi(place);
    let places = (-place).clamp(0, 6) as usize;
    format!("{:.places$} ± {:.places$}", (value / unit).round() * unit, (half_width / unit - 1e-6).ceil() * unit)
}

/// Half width of an interval of 95 %, in standard errors; of results that do not tell, that of many replicates.
pub(super) fn confidence_95(summary: &Summary) -> f64 {
    summary.estimated_error.map_or(1.96, |e| e.confidence_95)
}

/// A share, 0…1, in per cent.
pub(super) fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.1} %", share * 100.0) } else { "–".into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_go_to_files_and_back() {
        let mut table = Table::new("a", "", &["view", "hours"]);
        table.rows.push(vec!["desk, left".into(), "3".into()]);
        assert_eq!(table.csv(), "view,hours\n\"desk, left\",3\n");
        let json: serde_json::Value = serde_json::from_str(&table.json()).unwrap();
        assert_eq!(json[0]["view"], "desk, left");
        let read = Table::from_csv("b", "", "view,en17037_protection\ndesk,none\n\n").unwrap();
        assert_eq!((read.head[1].as_str(), read.rows.len()), ("en17037 protection", 1));
        assert!(Table::from_csv("b", "", "view\n").is_none());
        assert_eq!(file_name("../a b/ü"), "_a_b_ü");
    }

    #[test]
    fn intervals_keep_two_digits() {
        assert_eq!(with_interval(416.723, 0.4463), "416.72 ± 0.45");
        assert_eq!(with_interval(416.723, 1.0), "416.7 ± 1.0");
        assert_eq!(with_interval(416.723, 31.2), "417 ± 32");
        assert_eq!(with_interval(12_416.0, 312.0), "12420 ± 320");
        assert_eq!(with_interval(0.9, 0.0), "0.9");
        assert_eq!(with_interval(f64::NAN, 1.0), "–");
    }
}
