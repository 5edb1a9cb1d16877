//! `[optimal]`: what the best states of the groups are that `[control]` calls "optimal".

use super::document::Place;
use super::table::Table;
use crate::error::{Error, Result};
use crate::glare::CLASS_LIMITS;

/// What is best.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wanted {
    /// Most daylight on the sensors that face up.
    #[default]
    Daylight,
    /// Least power for lights above them.
    Lighting,
    /// Fewest moves, and of these most daylight.
    Moves,
}

/// `[optimal]`
#[derive(Debug, Clone, PartialEq)]
pub struct OptimalSection {
    /// What is best.
    pub aim: Wanted,
    /// Name of the group of sensors that stand at eyes.
    pub eyes: Option<String>,
    /// The simplified DGPs that no eye may exceed.
    pub dgps: f64,
    /// DGP by `[glare]` that no view may exceed.
    pub dgp: Option<f64>,
    /// Names of these views; nothing: all.
    pub views: Option<Vec<String>>,
    /// Share of the sensors that face up with more than 1000 lx of direct sun.
    pub sunlit: Option<f64>,
    /// Illuminance of any sensor that faces up, lx.
    pub most: Option<f64>,
    /// Illuminance that lights fill up to, lx.
    pub target: f64,
    /// Power of lights that are dimmed down, as a share of all of it.
    pub least_power: f64,
    /// Where the section stands in the project, if it does.
    pub place: Option<Place>,
}

impl Default for OptimalSection {
    fn default() -> Self {
        let [_, disturbing, _] = CLASS_LIMITS;
        Self {
            aim: Wanted::default(),
            eyes: None,
            dgps: disturbing,
            dgp: None,
            views: None,
            sunlit: None,
            most: None,
            target: 500.0,
            least_power: 0.1,
            place: None,
        }
    }
}

impl OptimalSection {
    /// # Errors
    /// No limit at all, sensors and views that there are not, limits without what they are of.
    pub(super) fn read(table: Option<Table<'_, '_>>, sensors: &[String], views: &[String], has_glare: bool) -> Result<Self> {
        let Some(mut table) = table else { return Ok(Self::default()) };
        let mut section = Self { place: Some(table.place("aim")), ..Self::default() };
        let aims = [("daylight", Wanted::Daylight), ("lighting", Wanted::Lighting), ("moves", Wanted::Moves)];
        section.aim = table.choice("aim", &aims)?.unwrap_or_default();
        section.eyes = table.string("eyes")?;
        if let Some(name) = section.eyes.as_ref().filter(|name| !sensors.contains(name)) {
            let help = "name a group of sensors at eyes, whose directions are those of the views";
            return Err(unknown(table.error("eyes", format!("there is no [[sensors]] with the name '{name}'")), name, sensors, help));
        }
        let dgps = table.number("dgps", 0.2..=1.0)?;
        if dgps.is_some() && section.eyes.is_none() {
            return Err(table.error("dgps", "this limit needs eyes").help("add eyes = the name of the [[sensors]] that stand at eyes"));
        }
        section.dgps = dgps.unwrap_or(section.dgps);
        section.dgp = table.number("dgp", 0.2..=1.0)?;
        section.views = table.texts("views", "[\"desk\"]")?;
        if let Some(name) = section.views.iter().flatten().find(|name| !views.contains(name)) {
            return Err(unknown(table.error("views", format!("there is no [[view]] with the name '{name}'")), name, views, "name views"));
        }
        if section.views.is_some() && section.dgp.is_none() {
            return Err(table.error("views", "no limit is asked for these views").help("add dgp = 0.4, or take 'views' out"));
        }
        if section.dgp.is_some() && (views.is_empty() || !has_glare) {
            return Err(table
                .error("dgp", "this limit needs views and a method of glare")
                .help("add [[view]] and [glare]; or eyes = the name of the [[sensors]] at eyes, whose simplified DGPs is limited"));
        }
        section.sunlit = table.number("sunlit", 0.0..=100.0)?.map(|percent| percent / 100.0);
        section.most = table.number("most", 1.0..=1e6)?;
        let (target, least) = (table.number("target", 1.0..=1e5)?, table.number("least_power", 0.0..=1.0)?);
        for (key, value) in [("target", target), ("least_power", least)] {
            if value.is_some() && section.aim != Wanted::Lighting {
                return Err(table.error(key, "this is for lights").help("write aim = \"lighting\", or take it out"));
            }
        }
        section.target = target.unwrap_or(section.target);
        section.least_power = least.unwrap_or(section.least_power);
        if section.eyes.is_none() && section.dgp.is_none() && section.sunlit.is_none() && section.most.is_none() {
            return Err(table.missing_section(
                "eyes",
                "the best state without any limit is the brightest: add eyes (sensors at eyes, for glare), dgp, sunlit or most",
            ));
        }
        table.finish()?;
        Ok(section)
    }

    /// Whether the DGP of a view is limited.
    pub fn looks_from(&self, view: &str) -> bool {
        self.dgp.is_some() && self.views.as_ref().is_none_or(|names| names.iter().any(|name| name == view))
    }
}

fn unknown(error: Error, name: &str, known: &[String], help: &str) -> Error {
    match crate::text::nearest(name, &known.iter().map(String::as_str).collect::<Vec<_>>()) {
        Some(near) => error.help(format!("did you mean '{near}'?")),
        None => error.help(help),
    }
}
