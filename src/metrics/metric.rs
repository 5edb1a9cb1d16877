//! One result.

use super::{Decision, Estimated};
use serde::{Deserialize, Serialize};

/// A metric of a group of sensors, of a view, or of all of them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Metric {
    /// Its name in files: `da300_spatial_share`.
    pub name: String,
    /// What it is, for people.
    pub title: String,
    /// Group, view, or `all`.
    pub of: String,
    /// Its value; absent where it is not judged, and notes say why.
    pub value: Option<f64>,
    /// Unit of the value: `share` (0…1), `lx`, `klx·h`, `points`, `h`.
    pub unit: String,
    /// Standard error of the value; absent where it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
    /// Its class, or level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Probability that noise changes class or points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probability_of_another_class: Option<f64>,
    /// Whether class or points are undecided within noise.
    pub undecided: bool,
    /// Whether it is LM-83's, where that could be thought.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lm83_conformant: Option<bool>,
    /// Where it is defined.
    pub source: String,
    /// Hours, sensors, what is missing: for who reads the number.
    pub notes: Vec<String>,
}

impl Metric {
    /// A metric without a value yet.
    pub fn new(name: &str, title: &str, unit: &str, source: &str) -> Self {
        Self { name: name.into(), title: title.into(), unit: unit.into(), source: source.into(), ..Self::default() }
    }

    /// With its value and error.
    #[must_use]
    pub fn value(self, value: Estimated) -> Self {
        Self { value: Some(value.value), standard_error: Some(value.standard_error), ..self }
    }

    /// With its class.
    #[must_use]
    pub fn class<C: PartialEq>(self, decision: &Decision<C>, name: impl Fn(&C) -> String) -> Self {
        let class = name(&decision.class);
        let probability = Some(decision.probability_of_another);
        Self { class: Some(class), probability_of_another_class: probability, undecided: decision.is_undecided(), ..self }
    }

    /// With a note.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Of a group or view.
    #[must_use]
    pub fn of(self, of: &str) -> Self {
        Self { of: of.into(), ..self }
    }

    /// Whether it is a mean over sensors or a step on the way to a class, not what a standard names.
    pub fn is_detail(&self) -> bool {
        let not_judged = self.value.is_none() && self.class.is_none();
        not_judged
            || ["mean_autonomy", "mean_continuous", "mean_u", "en17037_area", "mean_exp", "largest_", "median_"]
                .iter()
                .any(|p| self.name.starts_with(p))
    }

    /// Value, error and class in words: `43.2 ± 1.1 %, minimum, undecided within noise (12 % for another class)`.
    pub fn result(&self) -> String {
        let number = match (self.value, self.unit.as_str()) {
            (None, _) => None,
            (Some(v), "share") => Some((100.0 * v, self.standard_error.map(|e| 100.0 * e), "%")),
            (Some(v), unit) => Some((v, self.standard_error, unit)),
        };
        let mut words = Vec::new();
        if let Some((value, error, unit)) = number {
            // As many decimals as the error has, so that both are read alike.
            words.push(match error.filter(|e| *e > 0.0) {
                Some(error) => {
                    let places = decimals(error);
                    format!("{value:.places$} ± {error:.places$} {unit}")
                }
                None => format!("{value:.places$} {unit}", places = usize::from(unit != "points" && value.abs() < 1000.0)),
            });
        }
        words.extend(self.class.clone());
        if let Some(p) = self.probability_of_another_class.filter(|_| self.undecided) {
            words.push(format!("undecided within noise ({:.0} % for another)", 100.0 * p));
        }
        if words.is_empty() { "not judged".into() } else { words.join(", ") }
    }

    /// Columns of a table of metrics.
    pub const COLUMNS: &'static str =
        "of,metric,value,unit,standard_error,class,probability_of_another_class,undecided,lm83_conformant,source,notes";

    /// A line of it.
    pub fn row(&self) -> String {
        let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.6}"));
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "'"));
        [
            quoted(&self.of),
            self.name.clone(),
            number(self.value),
            self.unit.clone(),
            number(self.standard_error),
            self.class.clone().unwrap_or_default(),
            number(self.probability_of_another_class),
            if self.undecided { "yes".into() } else { String::new() },
            self.lm83_conformant.map_or(String::new(), |c| c.to_string()),
            quoted(&self.source),
            quoted(&self.notes.join("; ")),
        ]
        .join(",")
    }
}

/// Decimals that show a positive number to two digits.
fn decimals(v: f64) -> usize {
    (1.0 - v.log10().floor()).clamp(0.0, 6.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_told_with_their_error_and_doubt() {
        let metric = Metric::new("da300_spatial_share", "DA300 spatial share", "share", "-")
            .value(Estimated { value: 0.4321, standard_error: 0.0113 });
        assert_eq!(metric.result(), "43.2 ± 1.1 %");
        let metric =
            metric.class(&Decision { class: 1, probability_of_another: 0.12 }, |c| format!("class {c}")).of("desks").note("a \"b\"");
        assert_eq!(metric.result(), "43.2 ± 1.1 %, class 1, undecided within noise (12 % for another)");
        assert_eq!(metric.row(), "\"desks\",da300_spatial_share,0.432100,share,0.011300,class 1,0.120000,yes,,\"-\",\"a 'b'\"");
        assert_eq!(Metric::new("view_out", "View out", "", "EN").note("why").result(), "not judged");
        let exposure = Metric::new("largest_exposure_klxh", "-", "klx·h", "-").value(Estimated { value: 2306.123, standard_error: 21.0 });
        assert_eq!((exposure.result(), exposure.is_detail(), metric.is_detail()), ("2306 ± 21 klx·h".into(), true, false));
        assert_eq!(Metric::new("a", "-", "points", "-").value(Estimated { value: 2.0, standard_error: 0.0 }).result(), "2 points");
        assert_eq!(metric.row().split(',').count(), Metric::COLUMNS.split(',').count());
    }
}
