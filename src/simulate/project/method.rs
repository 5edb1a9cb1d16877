//! `[method]`: how many phases, which suns, and what is chosen where the project leaves it open.

use super::sections::WindowSection;
use super::table::Table;
use crate::bins::ReinhartSky;
use crate::error::{Error, Result};
use crate::kernels::sun_matrix::Sun;
use std::fmt;

/// `phases` of the project file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phases {
    /// Direct if all windows are clear glass, or there is none; else five if the sun can be traced through some
    /// window, else three.
    Auto,
    /// `I = C·S − Cd·Sds + Cds·Ssun` at sensors: daylight coefficients that are not factored at the windows. Honeybee
    /// calls it the enhanced two-phase method.
    Direct,
    /// Daylight coefficients `I = DC·S` with `DC = V·T·D`, which are kept.
    Two,
    /// `I = V·T·D·S`
    Three,
    /// `I = V·T·D·S − Vd·T·Dd·Sds + Cds·Ssun`
    Five,
}

/// Where suns stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SunScheme {
    /// At the centres of the patches of Reinhart's MF:n, as `gendaymtx -5` and `reinsrc.cal` have it.
    Patches(ReinhartSky),
    /// Where the sun really is in each hour; suns closer to each other than this angle (radians) are
    /// taken for one.
    Hourly {
        /// Largest distance from a real position to that of the sun traced in its place, radians.
        tolerance: f64,
    },
}

impl SunScheme {
    /// Patches MF:6, as in the five-phase method's tutorials: 5185 suns.
    pub const DEFAULT_SUBDIVISION: usize = 6;

    /// Real positions, merged where they are closer than the radius of the sun's disc.
    pub const HOURLY: Self = Self::Hourly { tolerance: Sun::RADIUS };
}

impl fmt::Display for SunScheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Patches(sky) => write!(f, "MF:{}", sky.subdivision()),
            Self::Hourly { tolerance } => write!(f, "hourly, merged within {:.3}°", tolerance.to_degrees()),
        }
    }
}

/// `[method]`: what is computed.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSection {
    /// Number of phases.
    pub phases: Phases,
    /// Suns that are traced, if `suns` was written; else of five phases MF:6, of direct coefficients hourly
    /// ([`MethodSection::suns_of`]).
    pub suns: SunScheme,
    /// Division of the sky, Reinhart MF:n; `None`: as fine as the glazing asks.
    pub sky: Option<ReinhartSky>,
    /// Whether `suns` was written.
    pub suns_are_given: bool,
    /// Radiance's `-ab`; `None`: paths end by Russian roulette only, without bias.
    pub bounces: Option<u32>,
}

/// What the glazing asks of a method that is left open: known when its files are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glazing {
    /// The sky that is fine enough for it.
    pub sky: ReinhartSky,
    /// Whether no window that suns could be traced through passes a sun as such: diffuse panels.
    pub spreads_suns: bool,
}

/// The method that a run follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// 2, 3 or 5: of pictures and glare, and of sensors unless they are `direct`.
    pub phases: u32,
    /// Whether the sensors' coefficients go straight to the sky, through glass or without any window.
    pub direct: bool,
    /// Why, for people.
    pub why: &'static str,
}

impl Choice {
    fn of(phases: u32, why: &'static str) -> Self {
        Self { phases, direct: false, why }
    }

    fn direct(why: &'static str) -> Self {
        Self { phases: 5, direct: true, why }
    }

    /// The formula of the sensors.
    pub fn formula(&self) -> &'static str {
        match self.phases {
            _ if self.direct => "direct, I = C·S − Cd·Sds + Cds·Ssun",
            2 => "two phases, I = DC·S with DC = V·T·D",
            5 => "five phases, I = V·T·D·S − Vd·T·Dd·Sds + Cds·Ssun",
            _ => "three phases, I = V·T·D·S",
        }
    }
}

/// What of a project its method depends on.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a> {
    /// `[[window]]`
    pub windows: &'a [WindowSection],
    /// Whether there are sensors.
    pub sensors: bool,
    /// Whether matrices of the factored method were made elsewhere.
    pub given: bool,
}

impl Asked<'_> {
    /// Whether sensors can do without bins at the windows.
    fn can_be_direct(&self) -> bool {
        self.sensors && !self.given && self.windows.iter().all(|w| w.filling.is_glass() && w.states.is_empty())
    }
}

/// What to do where a method needs windows.
const NO_WINDOW: &str = "add [[window]] with name, surface and glass = 0.65, or write phases = \"direct\": sensors under the open sky, or behind \
                         glass of the scene";

impl Asked<'_> {
    fn check_direct(&self) -> Result<()> {
        if let Some(moving) = self.windows.iter().find(|w| !w.states.is_empty()) {
            return Err(Error::new(format!(
                "phases = \"direct\" follows light through the panes as they are, but window '{}' has states",
                moving.name
            ))
            .help("write phases = \"auto\" or 5: then view and daylight matrices serve all states, and suns pass what each is made of"));
        }
        if let Some(other) = self.windows.iter().find(|w| !w.filling.is_glass()) {
            return Err(Error::new(format!(
                "phases = \"direct\" follows light through clear glass, but window '{}' scatters it",
                other.name
            ))
            .help("write phases = \"auto\", or give the window glass = 0.65 in place of its data"));
        }
        if self.given {
            return Err(Error::new("matrices V, D or Cds made elsewhere are of the factored method, not of phases = \"direct\"")
                .help("take them out, or write phases = 3 or 5"));
        }
        if !self.sensors {
            return Err(Error::new("phases = \"direct\" is for sensors, and there are none")
                .help("add [[sensors]], or write phases = 5, which pictures and glare follow"));
        }
        Ok(())
    }
}

impl MethodSection {
    pub(super) fn read(table: Option<Table<'_, '_>>, asked: Asked<'_>) -> Result<Self> {
        let windows = asked.windows;
        let patches = SunScheme::Patches(ReinhartSky::new(SunScheme::DEFAULT_SUBDIVISION)?);
        let mut method = Self { phases: Phases::Auto, suns: patches, sky: None, bounces: None, suns_are_given: false };
        let Some(mut table) = table else { return Ok(method) };
        method.phases = match table.integer_or_choice("phases", 2..=5, &["auto", "direct"])? {
            Some(Err("direct")) => Phases::Direct,
            None | Some(Err(_)) => Phases::Auto,
            Some(Ok(2)) => Phases::Two,
            Some(Ok(3)) => Phases::Three,
            Some(Ok(5)) => Phases::Five,
            Some(Ok(n)) => {
                return Err(table
                    .error("phases", format!("a method of {n} phases is not known"))
                    .help("choose 2, 3, 5, \"direct\" or \"auto\""));
            }
        };
        let suns = table.integer_or_choice("suns", 1..=6, &["hourly"])?;
        method.suns_are_given = suns.is_some();
        method.suns = match suns {
            None => method.suns,
            Some(Ok(n)) => SunScheme::Patches(ReinhartSky::new(n as usize)?),
            Some(Err(_)) => SunScheme::HOURLY,
        };
        match table.integer_or_choice("sky_subdivision", 1..=6, &["auto"])? {
            None | Some(Err(_)) => {}
            Some(Ok(n)) => method.sky = Some(ReinhartSky::new(n as usize)?),
        }
        method.bounces = table.integer("bounces", 0..=10_000)?.map(|b| b as u32);
        let shaded = windows.iter().find(|w| w.names_what_suns_pass());
        let clear = windows.iter().any(WindowSection::lets_suns_through);
        if method.phases == Phases::Direct {
            asked.check_direct().map_err(|e| table.place("phases").of(e))?;
        }
        if windows.is_empty() && matches!(method.phases, Phases::Two | Phases::Three | Phases::Five) {
            return Err(table.error("phases", "phases 2, 3 and 5 are taken at windows, and there is none").help(NO_WINDOW));
        }
        match (method.phases, shaded) {
            (Phases::Two | Phases::Three, Some(window)) => {
                return Err(table
                    .error(
                        "phases",
                        format!("the window '{}' has a shade or tensor tree, which only five phases trace the sun through", window.name),
                    )
                    .help("write phases = 5 or \"auto\", or take the shade out"));
            }
            (Phases::Two | Phases::Three, None) if suns.is_some() => {
                return Err(table.error("suns", "suns are traced by five phases only").help("write phases = 5, or take suns out"));
            }
            (Phases::Five, None) if !clear => {
                return Err(table
                    .error("phases", "five phases need a window that the sun is traced through")
                    .help("add shade = \"….rad\" (slats, panes) or tensor_tree = \"….xml\" to a [[window]], or glass = 0.65 in place of its bsdf, or write phases = 3"));
            }
            _ => {}
        }
        table.finish()?;
        Ok(method)
    }

    /// Takes these suns as if they were written.
    pub fn take_suns(&mut self, suns: SunScheme) {
        (self.suns, self.suns_are_given) = (suns, true);
    }

    /// The suns of a method.
    pub fn suns_of(&self, choice: &Choice) -> SunScheme {
        if choice.direct && !self.suns_are_given { SunScheme::HOURLY } else { self.suns }
    }

    /// The method for what a project asks and the glazing of its windows.
    pub fn choice(&self, asked: Asked<'_>, glazing: &Glazing) -> Choice {
        let windows = asked.windows;
        let shaded = windows.iter().any(WindowSection::lets_suns_through);
        let named = windows.iter().any(WindowSection::names_what_suns_pass);
        match self.phases {
            Phases::Two => Choice::of(2, "as asked: daylight coefficients V·T·D are kept"),
            Phases::Three => Choice::of(3, "as asked"),
            Phases::Five => Choice::of(5, "as asked"),
            Phases::Direct => Choice::direct("as asked"),
            Phases::Auto if asked.can_be_direct() && windows.is_empty() => {
                Choice::direct("the project names no window: light comes by the scene's glass, and where the scene leaves the sky free")
            }
            Phases::Auto if asked.can_be_direct() && windows.iter().any(|w| w.found.is_some()) => {
                Choice::direct("the project names no window: those of the scene are clear glass, which sensors see through")
            }
            Phases::Auto if asked.can_be_direct() => {
                Choice::direct("all windows are clear glass, which sensors see through without bins of directions")
            }
            Phases::Auto if shaded && !self.suns_are_given && glazing.spreads_suns => {
                Choice::of(3, "the windows that suns could be traced through spread all light evenly")
            }
            Phases::Auto if shaded && !named && !asked.sensors && windows.iter().any(WindowSection::has_states_of_data_alone) => {
                Choice::of(
                    3,
                    "the states of windows are scattering data that suns are not traced through; phases = 5 traces those through glass",
                )
            }
            Phases::Auto if shaded && !named && windows.iter().any(|w| !w.is_glass()) => {
                Choice::of(5, "the sun is traced through the clear panes themselves; not all windows are 'glass', so none is 'direct'")
            }
            Phases::Auto if shaded && !named => Choice::of(5, "the sun is traced through the clear panes themselves"),
            Phases::Auto if shaded => {
                Choice::of(5, "a window has a shade or tensor tree, whose patches of sun the sky's patches would blur")
            }
            Phases::Auto => Choice::of(3, "no window has glass, a shade or a tensor tree that suns could be traced through"),
        }
    }
}
