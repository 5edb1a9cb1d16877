//! `[method]`: how many phases, which suns, and what is chosen where the project leaves it open.

use super::sections::WindowSection;
use super::table::Table;
use crate::bins::ReinhartSky;
use crate::error::Result;
use crate::kernels::sun_matrix::Sun;
use std::fmt;

/// `phases` of the project file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phases {
    /// Five if the sun can be traced through some window, else three.
    Auto,
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
    /// Suns of the five-phase method.
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
    /// 2, 3 or 5.
    pub phases: u32,
    /// Why, for people.
    pub why: &'static str,
}

impl MethodSection {
    pub(super) fn read(table: Option<Table<'_, '_>>, windows: &[WindowSection]) -> Result<Self> {
        let patches = SunScheme::Patches(ReinhartSky::new(SunScheme::DEFAULT_SUBDIVISION)?);
        let mut method = Self { phases: Phases::Auto, suns: patches, sky: None, bounces: None, suns_are_given: false };
        let Some(mut table) = table else { return Ok(method) };
        method.phases = match table.integer_or_choice("phases", 2..=5, &["auto"])? {
            None | Some(Err(_)) => Phases::Auto,
            Some(Ok(2)) => Phases::Two,
            Some(Ok(3)) => Phases::Three,
            Some(Ok(5)) => Phases::Five,
            Some(Ok(n)) => {
                return Err(table.error("phases", format!("a method of {n} phases is not known")).help("choose 2, 3, 5 or \"auto\""));
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
        let clear = windows.iter().any(|w| w.filling.is_clear());
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

    /// The method for these windows and their glazing.
    pub fn choice(&self, windows: &[WindowSection], glazing: &Glazing) -> Choice {
        let shaded = windows.iter().any(WindowSection::lets_suns_through);
        let named = windows.iter().any(WindowSection::names_what_suns_pass);
        match self.phases {
            Phases::Two => Choice { phases: 2, why: "as asked: daylight coefficients V·T·D are kept" },
            Phases::Three => Choice { phases: 3, why: "as asked" },
            Phases::Five => Choice { phases: 5, why: "as asked" },
            Phases::Auto if shaded && !self.suns_are_given && glazing.spreads_suns => {
                Choice { phases: 3, why: "the windows that suns could be traced through spread all light evenly" }
            }
            Phases::Auto if shaded && !named && windows.iter().any(|w| w.states.len() > 1) => {
                Choice { phases: 3, why: "windows have several states, for which suns are not traced" }
            }
            Phases::Auto if shaded && !named => Choice { phases: 5, why: "the sun is traced through the clear panes themselves" },
            Phases::Auto if shaded => {
                Choice { phases: 5, why: "a window has a shade or tensor tree, whose patches of sun the sky's patches would blur" }
            }
            Phases::Auto => Choice { phases: 3, why: "no window has glass, a shade or a tensor tree that suns could be traced through" },
        }
    }
}
