//! EN 17037:2018, view out: what an eye sees through the openings.

use super::en17037::Level;

/// Horizontal sight angles, degrees, by level (table A.5).
pub const SIGHT_DEG: [f64; 3] = [14.0, 28.0, 54.0];
/// Distances of what stands opposite, m, by level (table A.5).
pub const DISTANCE_M: [f64; 3] = [6.0, 20.0, 50.0];
/// Share of the plane from which it shall be seen.
pub const AREA: f64 = 0.75;

/// Layers that are seen through one opening.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Layers {
    /// The sky.
    pub sky: bool,
    /// Town or nature.
    pub landscape: bool,
    /// The ground.
    pub ground: bool,
}

impl Layers {
    /// The level of them: the landscape, with one more, with both.
    pub fn level(self) -> Level {
        Level::reached(if self.landscape { 1 + usize::from(self.sky) + usize::from(self.ground) } else { 0 })
    }
}

/// What an eye sees of the outside.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ViewOut {
    /// Horizontal sight angle of all openings, degrees.
    pub sight_deg: f64,
    /// Distance from the opening to what stands opposite, m; infinite where nothing does.
    pub distance_m: f64,
    /// Through the opening that shows most of them.
    pub layers: Layers,
}

impl ViewOut {
    /// The lowest of the three levels.
    pub fn level(&self) -> Level {
        let of = |limits: [f64; 3], value: f64| Level::reached(limits.iter().take_while(|l| value >= **l).count());
        of(SIGHT_DEG, self.sight_deg).min(of(DISTANCE_M, self.distance_m)).min(self.layers.level())
    }
}

/// The level that [`AREA`] of the eyes have.
pub fn level_of(views: &[ViewOut]) -> Level {
    let share = |level: Level| super::share_of(views, |v| v.level() >= level).unwrap_or_default();
    [Level::High, Level::Medium, Level::Minimum].into_iter().find(|l| share(*l) >= AREA).unwrap_or(Level::None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_of_angle_distance_and_layers_decides() {
        let layers = |[sky, landscape, ground]: [bool; 3]| Layers { sky, landscape, ground };
        let all = layers([true; 3]);
        for (sight_deg, distance_m, layers, level) in [
            (54.0, 50.0, all, Level::High),
            (53.9, f64::INFINITY, all, Level::Medium),
            (90.0, 19.9, all, Level::Minimum),
            (90.0, 5.9, all, Level::None),
            (13.9, 100.0, all, Level::None),
            (90.0, 100.0, layers([true, true, false]), Level::Medium),
            (90.0, 100.0, layers([false, true, false]), Level::Minimum),
            (90.0, 100.0, layers([true, false, true]), Level::None),
        ] {
            assert_eq!(ViewOut { sight_deg, distance_m, layers }.level(), level, "{sight_deg} {distance_m} {layers:?}");
        }
    }

    #[test]
    fn three_quarters_of_the_eyes_have_the_level() {
        let good = ViewOut { sight_deg: 90.0, distance_m: 100.0, layers: Layers { sky: true, landscape: true, ground: true } };
        let bad = ViewOut::default();
        assert_eq!(level_of(&[good, good, good, bad]), Level::High);
        assert_eq!(level_of(&[good, good, bad, bad]), Level::None);
        let medium = ViewOut { sight_deg: 30.0, ..good };
        assert_eq!(level_of(&[good, good, medium, bad]), Level::Medium);
        assert_eq!(level_of(&[]), Level::None);
    }
}
