//! What was decided, for people: `control/reasons.csv`, `control/signals.csv`, `control/values.csv`, the summary.

use super::decide::{Decision, OfRules};
use super::groups::fault_of;
use crate::control::optimum::Marginal;
use crate::control::rules::{Decided, Reading, Signal, Statistic};
use crate::error::{Error, Result, Warnings};
use crate::files::write_atomically;
use crate::simulate::context::Context;
use crate::simulate::inputs::counting::Counting;
use crate::simulate::project::control::{Asked, GroupControl};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// States that the run decided.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ControlSummary {
    /// The groups that it decided.
    pub groups: Vec<DecidedGroup>,
    /// By LM-83: hours in which more than 2 % of the sensors stay in the sun with all blinds closed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lm83_hours_above: Option<f64>,
    /// Whether all windows have LM-83's blinds, and these were moved.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lm83_blinds: bool,
    /// Of optimal states: hours in which no combination of states meets the limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub optimal_hours_above: Option<f64>,
    /// The most by which a step's value may be worse than the best, lx or a share of the lights' power; 0: all are exact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub optimal_may_be_lost: Option<f64>,
    /// What states and groups are worth, in occupied hours.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<StateValue>,
}

/// A group whose states the run decided.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DecidedGroup {
    /// Its name.
    pub name: String,
    /// `rule`, `lm-83` or `optimal`.
    pub by: String,
    /// The text of its rule.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub rule: String,
    /// Moves back to the state of two steps before, where it does so four times in a row or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oscillating_moves: Option<usize>,
}

/// What is lost without a state, or if a group stayed in its first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StateValue {
    /// The group.
    pub group: String,
    /// The state; empty: the group as a whole.
    pub state: String,
    /// Loss of the aim's mean over the occupied hours in which the limits are met either way: lx, or a share of the lights'
    /// power.
    pub lost: f64,
    /// Further occupied hours above the limits.
    pub more_hours_above: f64,
}

impl Decision {
    /// Writes the tables and says what there is to say.
    ///
    /// # Errors
    /// Failures of the file system.
    pub(crate) fn write(&self, context: &Context<'_>, counting: &Counting, warnings: &mut Warnings) -> Result<ControlSummary> {
        let folder = context.store.schedule_path()?;
        self.write_reasons(context, counting, &folder.with_file_name("reasons.csv"))?;
        if let Some(rules) = &self.rules {
            write_signals(context, counting, rules, &folder.with_file_name("signals.csv"))?;
        }
        let summary = self.summary(context, counting);
        if !summary.values.is_empty() {
            let path = folder.with_file_name("values.csv");
            write_atomically(&path, |out| {
                let fault = |e: std::io::Error| Error::io(&path, &e);
                writeln!(out, "group,without,lost,more_hours_above").map_err(fault)?;
                for value in &summary.values {
                    writeln!(out, "{},{},{:.5},{}", value.group, value.without(), value.lost, value.more_hours_above).map_err(fault)?;
                }
                Ok(())
            })?;
        }
        self.warn(context, &summary, warnings);
        Ok(summary)
    }

    fn summary(&self, context: &Context<'_>, counting: &Counting) -> ControlSummary {
        let (facade, length) = (&context.inputs.facade, counting.year.length);
        let of = |c: &GroupControl| {
            let (by, rule) = match &c.asked {
                Asked::Rule(text, _) => ("rule", text.clone()),
                Asked::Lm83 { .. } => ("lm-83", String::new()),
                _ => ("optimal", String::new()),
            };
            let oscillation = self.rules.iter().flat_map(|r| &r.operation.oscillations).find(|o| o.group == c.group);
            DecidedGroup {
                name: facade.groups()[c.group].name.clone(),
                by: by.into(),
                rule,
                oscillating_moves: oscillation.map(|o| o.moves),
            }
        };
        let value = |groups: &[usize], m: &Marginal| {
            let group = &facade.groups()[groups[m.group]];
            StateValue {
                group: group.name.clone(),
                state: m.state.map_or_else(String::new, |s| group.states[usize::from(s)].clone()),
                lost: m.lost,
                more_hours_above: m.more_remaining as f64 * length,
            }
        };
        let optimum = self.best.as_ref().map(|b| &b.optimum);
        ControlSummary {
            groups: decided(context).map(of).collect(),
            lm83_hours_above: self.blinds.as_ref().map(|b| b.remaining.len() as f64 * length),
            lm83_blinds: self.blinds.as_ref().is_some_and(|b| b.all),
            optimal_hours_above: optimum.map(|o| o.remaining.len() as f64 * length),
            optimal_may_be_lost: optimum.map(|o| o.may_be_lost.iter().copied().fold(0.0, f64::max)),
            values: self.best.iter().flat_map(|b| b.worth.iter().map(|m| value(&b.groups, m))).collect(),
        }
    }

    /// A row per step: why each group is in its state.
    fn write_reasons(&self, context: &Context<'_>, counting: &Counting, path: &Path) -> Result<()> {
        let facade = &context.inputs.facade;
        let names: Vec<&str> = decided(context).map(|c| facade.groups()[c.group].name.as_str()).collect();
        write_steps(path, counting, &names, &|step| decided(context).map(|c| self.reason(c, step)).collect())
    }

    fn reason(&self, control: &GroupControl, step: usize) -> String {
        match (&control.asked, &self.rules, &self.blinds, &self.best) {
            (Asked::Rule(..), Some(rules), ..) => match rules.operation.decided[control.group][step] {
                Decided::Clause(i) => format!("clause {}", i + 1),
                Decided::Kept => "kept".into(),
                Decided::Otherwise | Decided::Given => "else".into(),
            },
            (Asked::Lm83 { .. }, _, Some(blinds), _) => match blinds.remaining.binary_search(&step) {
                Ok(_) => "too much sun in any state".into(),
                Err(_) => "lm-83".into(),
            },
            (Asked::Optimal, _, _, Some(best)) => match best.optimum.remaining.binary_search(&step) {
                Ok(i) => format!("{:.1} % above the limits in the best state", 100.0 * best.optimum.excess[i]),
                Err(_) => "best".into(),
            },
            _ => String::new(),
        }
    }

    fn warn(&self, context: &Context<'_>, summary: &ControlSummary, warnings: &mut Warnings) {
        const WHICH: &str = "control/reasons.csv tells which hours";
        let steps = &context.inputs.weather.records;
        for o in self.rules.iter().flat_map(|r| &r.operation.oscillations) {
            let at = crate::weather::time::Time::from(&steps[o.step]);
            let message =
                format!("the rule moves the windows back and forth: {} times to the state of two steps before, first at {at}", o.moves);
            let help = "give it a lower limit for going back (until …), or keep 2 h";
            warnings.push(fault_of(context, o.group, Error::new(message)).help(help));
        }
        let first = |is: fn(&Asked) -> bool| decided(context).find(|c| is(&c.asked)).map_or(0, |c| c.group);
        let of_lm83 = first(|asked| matches!(asked, Asked::Lm83 { .. }));
        if let Some(hours) = summary.lm83_hours_above.filter(|h| *h > 0.0) {
            let message =
                format!("in {hours} h of LM-83 more than 2 % of the sensors have over 1000 lx of direct sun with all blinds closed");
            warnings.push(fault_of(context, of_lm83, Error::new(message)).help(WHICH));
        }
        let optimal = first(|asked| matches!(asked, Asked::Optimal));
        if let Some(lost) = summary.optimal_may_be_lost.filter(|lost| *lost > 0.0) {
            let message = format!("the search for the best states ended early in some steps: they may be worse than the best by {lost:.3}");
            let help = "1,000,000 combinations of states a step are searched exactly: leave out groups or states";
            warnings.push(fault_of(context, optimal, Error::new(message)).help(help));
        }
        if let Some(hours) = summary.optimal_hours_above.filter(|h| *h > 0.0) {
            let message = format!("in {hours} h no combination of states meets the limits: there the one that exceeds them least stands");
            warnings.push(fault_of(context, optimal, Error::new(message)).help(format!("{WHICH}, and by how much")));
        }
    }
}

impl StateValue {
    /// What the façade would be without.
    pub fn without(&self) -> &str {
        if self.state.is_empty() { "all but the first state" } else { &self.state }
    }
}

/// The groups that the run decides.
fn decided<'c>(context: &Context<'c>) -> impl Iterator<Item = &'c GroupControl> {
    context.project.control.groups.iter().filter(|c| c.asked.is_decided_by_the_run())
}

/// A row per step, columns by name.
fn write_steps(path: &Path, counting: &Counting, names: &[&str], row: &dyn Fn(usize) -> Vec<String>) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        writeln!(out, "month,day,begins,{}", names.join(",")).map_err(fault)?;
        for (step, at) in counting.year.steps.iter().enumerate() {
            let begins = (at.begins * 1e4).round() / 1e4;
            writeln!(out, "{},{},{begins},{}", at.month, at.day, row(step).join(",")).map_err(fault)?;
        }
        Ok(())
    })
}

/// What each rule looked at in every step; nothing where a signal has no value.
fn write_signals(context: &Context<'_>, counting: &Counting, rules: &OfRules, path: &Path) -> Result<()> {
    let names: Vec<String> = rules.readings.iter().map(|(group, reading, _)| describe(context, *group, *reading)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let cell = |value: f64| if value.is_finite() { format!("{}", (value * 1e3).round() / 1e3) } else { String::new() };
    write_steps(path, counting, &names, &|step| rules.readings.iter().map(|(.., values)| cell(values[step])).collect())
}

/// A signal of a group's rule as a column's name: `south: irradiance on south (W/m2)`.
fn describe(context: &Context<'_>, group: usize, reading: Reading) -> String {
    let facade = context.inputs.facade.groups();
    let sensors = |of: Option<usize>| of.map_or("sensors", |g| context.inputs.sensors[g].name.as_str());
    let what = match reading.signal {
        Signal::Irradiance(g) => format!("irradiance on {}", facade[g].name),
        Signal::Illuminance(g) => format!("illuminance on {}", facade[g].name),
        Signal::ProfileAngle(g) => format!("profile angle on {}", facade[g].name),
        Signal::Altitude => "altitude".into(),
        Signal::Azimuth => "azimuth".into(),
        Signal::Time => "time".into(),
        Signal::Month => "month".into(),
        Signal::Sun(of) => format!("sun on {}", sensors(of)),
        Signal::SunlitShare(of) => format!("sunlit share of {}", sensors(of)),
        Signal::Sensors(statistic, of) => {
            let statistic = match statistic {
                Statistic::Mean => "mean".into(),
                Statistic::Least => "least".into(),
                Statistic::Most => "most".into(),
                Statistic::Percentile(p) => format!("percentile {p}"),
            };
            format!("{statistic} illuminance of {}", sensors(of))
        }
        Signal::Dgp(view) => format!("dgp of {}", context.project.views[view].name),
    };
    let unit = if reading.signal.unit().is_empty() { String::new() } else { format!(" ({})", reading.signal.unit()) };
    let set = if reading.as_set { " as set" } else { "" };
    format!("{}: {what}{set}{unit}", facade[group].name).replace([',', '"', '\n'], " ")
}
