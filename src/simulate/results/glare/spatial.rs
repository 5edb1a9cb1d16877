//! Metrics over all views: sGA, sDG, and how sure EN 17037's protection is.

use super::tables::{Calendar, ViewYear};
use crate::glare::annual::{AnnualGlare, GlareProtection};
use crate::metrics::{Decision, Estimated, Metric, en17037, glare};
use crate::simulate::project::glare::GlareSection;

/// Metrics of the views in each state of the façade; none if no step is occupied.
pub(super) fn metrics(section: &GlareSection, calendar: &Calendar<'_>, years: &[ViewYear]) -> Vec<Metric> {
    let occupied: Vec<bool> = calendar.records.iter().map(|r| (section.occupied[0]..section.occupied[1]).contains(&r.hour)).collect();
    if !occupied.contains(&true) {
        return Vec::new();
    }
    let mut states: Vec<&str> = Vec::new();
    for year in years {
        if !states.contains(&year.state.as_str()) {
            states.push(&year.state);
        }
    }
    let [from, to] = section.occupied;
    let hours = format!("{from} to {to} o'clock, {} h", calendar.steps.hours(occupied.iter().filter(|o| **o).count()));
    let mut metrics = Vec::new();
    for state in states {
        let own: Vec<&ViewYear> = years.iter().filter(|y| y.state == state).collect();
        let name = |of: &str| if state.is_empty() { of.to_string() } else { format!("{of}, {state}") };
        for year in &own {
            let metric = Metric::new("en17037_glare_protection", "EN 17037 protection from glare", "", en17037::SOURCE);
            let decision = protection(year, &occupied, calendar);
            metrics.push(metric.class(&decision, |c| c.name().into()).note(hours.clone()).of(&name(&year.view)));
        }
        let shares: [(&str, &str, f64, fn(&[f64]) -> Option<f64>); 2] = [
            ("sga_40", "sGA: views with DGP above 0.40 in no more than 5 % of the time", glare::PERCEPTIBLE, glare::spatial_autonomy),
            ("sdg_38", "sDG: views with DGP above 0.38 in more than 5 % of the time", glare::DISTURBING, glare::spatial_disturbing),
        ];
        for (key, title, limit, share) in shares {
            // All views and hours moved by their errors together: the most that their share can err.
            let moved = |by: f64| {
                let of = |y: &&ViewYear| glare::time_above(&y.dgp(by), &occupied, limit);
                share(&own.iter().map(of).collect::<Vec<f64>>()).unwrap_or_default()
            };
            let value = moved(0.0);
            let standard_error = (((moved(1.0) - value).powi(2) + (moved(-1.0) - value).powi(2)) / 2.0).sqrt();
            let metric = Metric::new(key, title, "share", "N. L. Jones 2019; sDG: J. A. Jakubiec and C. F. Reinhart 2012");
            metrics.push(
                metric.value(Estimated { value, standard_error }).note(format!("{} views, {hours}", own.len())).of(&name("all views")),
            );
        }
    }
    metrics
}

/// The class of protection of a view, and how sure it is.
fn protection(year: &ViewYear, occupied: &[bool], calendar: &Calendar<'_>) -> Decision<GlareProtection> {
    let errors: Vec<f64> = year.hours.iter().map(|h| h.standard_error).collect();
    glare::decide(&year.dgp(0.0), &errors, calendar.confidence_95, |dgp| {
        AnnualGlare::new(dgp, occupied, calendar.steps.length).map_or(GlareProtection::None, |a| a.protection)
    })
}
