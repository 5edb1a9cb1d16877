//! Which suns are traced: those that occur, and that can reach a window.

use crate::bins::ReinhartSky;
use crate::error::{Error, Result};
use crate::kernels::sun_matrix::Sun;
use crate::scene::Window;
use crate::simulate::project::Quantity;
use crate::simulate::project::method::SunScheme;
use crate::sky::{SkyOptions, SunHour, sun_hours};
use crate::weather::Weather;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How many suns there are and why not all are traced.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SunCensus {
    /// Scheme, for people.
    pub scheme: String,
    /// Suns of the scheme: patches of the sky, or different hourly positions.
    pub all: usize,
    /// Traced.
    pub needed: usize,
    /// Left out: no hour of the weather has its sun there.
    pub never: usize,
    /// Left out: behind every window, where their light cannot enter.
    pub behind_windows: usize,
    /// Hours with direct sun.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours: f64,
    /// Of them, those whose sun is behind every window.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours_behind_windows: f64,
    /// Hours with direct light although the sun is below the horizon (left out with hourly suns; with
    /// patches they count with the lowest ones, as in gendaymtx).
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours_below_horizon: f64,
    /// Hours without direct sun: night and clouds.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours_without: f64,
}

/// The suns to trace and what they do in each hour.
#[derive(Debug, Clone, PartialEq)]
pub struct SunSet {
    /// The suns.
    pub suns: Vec<Sun>,
    /// Column of each in the full matrix (0 is the ground); the sun's own number for hourly suns.
    pub columns: Vec<usize>,
    /// Columns of the full matrix.
    pub all_columns: usize,
    /// Per time step of the weather: index into `suns` and radiance of the disc (W/m²sr, grey).
    pub hours: Vec<Option<(usize, f64)>>,
    /// Whether the sun of an hour, though not traced, shines: it is behind every window.
    pub behind: Vec<bool>,
    /// Counts.
    pub census: SunCensus,
}

/// Whether light of a sun can come through a window from outside: its centre, or part of its disc, is
/// before the window's outer face.
pub fn reaches(sun: &Sun, window: &Window) -> bool {
    sun.direction.dot(window.frame.z) < sun.radius.sin()
}

impl SunSet {
    /// The suns of a year. Without windows none is taken for unreachable.
    ///
    /// # Errors
    /// As [`sun_hours`].
    pub fn new(weather: &Weather, scheme: SunScheme, windows: &[Window]) -> Result<Self> {
        Self::of(weather, scheme, windows, Quantity::Illuminance)
    }

    /// The same of a quantity at sensors.
    ///
    /// # Errors
    /// As [`sun_hours`].
    pub(crate) fn of(weather: &Weather, scheme: SunScheme, windows: &[Window], quantity: Quantity) -> Result<Self> {
        // A sky made elsewhere has its suns where it has them.
        let given = weather.given.as_ref().and_then(|sky| sky.suns.as_ref());
        let scheme = match given {
            Some((subdivision, _)) => SunScheme::Patches(ReinhartSky::new(*subdivision)?),
            None => scheme,
        };
        let subdivision = match scheme {
            SunScheme::Patches(sky) => sky.subdivision(),
            SunScheme::Hourly { .. } => 1,
        };
        let mut hours = sun_hours(weather, &SkyOptions { subdivision, solar_spectrum: quantity.is_solar(), ..SkyOptions::default() })?;
        hours.iter_mut().flatten().for_each(|hour| hour.radiance *= quantity.factor());
        if let SunScheme::Hourly { tolerance } = scheme
            && !(tolerance.is_finite() && tolerance >= 0.0)
        {
            return Err(Error::new("the tolerance of hourly suns must be 0 or more"));
        }
        let below = hours.iter().flatten().filter(|h| h.position.altitude <= 0.0).count();
        let (candidates, sun_of_hour, all_columns) = match scheme {
            SunScheme::Patches(sky) => at_patches(sky, &hours),
            SunScheme::Hourly { tolerance } => at_real_positions(&hours, tolerance),
        };
        let all = match scheme {
            SunScheme::Patches(sky) => sky.len() - 1,
            SunScheme::Hourly { .. } => candidates.len(),
        };
        // Numbers of the suns that are traced.
        let mut numbers = vec![None; candidates.len()];
        let (mut suns, mut columns) = (Vec::new(), Vec::new());
        for (i, (column, sun)) in candidates.iter().enumerate() {
            if windows.is_empty() || windows.iter().any(|w| reaches(sun, w)) {
                numbers[i] = Some(suns.len());
                suns.push(*sun);
                columns.push(*column);
            }
        }
        let traced: Vec<Option<(usize, f64)>> =
            hours.iter().zip(&sun_of_hour).map(|(hour, sun)| Some((numbers[(*sun)?]?, hour.as_ref()?.radiance))).collect();
        let behind: Vec<bool> = sun_of_hour.iter().map(|sun| sun.is_some_and(|s| numbers[s].is_none())).collect();
        let with_sun = sun_of_hour.iter().flatten().count();
        let hours_of = |steps: usize| weather.steps().hours(steps);
        let census = SunCensus {
            scheme: scheme.to_string(),
            all,
            needed: suns.len(),
            never: all - candidates.len(),
            behind_windows: candidates.len() - suns.len(),
            hours: hours_of(with_sun),
            hours_behind_windows: hours_of(behind.iter().filter(|b| **b).count()),
            hours_below_horizon: hours_of(below),
            hours_without: hours_of(hours.len() - hours.iter().flatten().count()),
        };
        Ok(Self { suns, columns, all_columns, hours: traced, behind, census })
    }
}

type Candidates = (Vec<(usize, Sun)>, Vec<Option<usize>>, usize);

/// Patches that hold the sun at some hour, and the number among them of each hour.
fn at_patches(sky: ReinhartSky, hours: &[Option<SunHour>]) -> Candidates {
    let mut numbers = BTreeMap::new();
    for hour in hours.iter().flatten() {
        numbers.insert(hour.patch, 0);
    }
    let mut candidates = Vec::new();
    for (patch, number) in &mut numbers {
        *number = candidates.len();
        candidates.push((*patch, Sun::new(sky.centre(*patch))));
    }
    let of_hour = hours.iter().map(|h| h.as_ref().map(|h| numbers[&h.patch])).collect();
    (candidates, of_hour, sky.len())
}

/// Real positions above the horizon. Each hour joins the nearest sun within the tolerance, or becomes
/// a new one.
fn at_real_positions(hours: &[Option<SunHour>], tolerance: f64) -> Candidates {
    let least = tolerance.cos();
    let mut candidates: Vec<(usize, Sun)> = Vec::new();
    let of_hour = hours
        .iter()
        .map(|hour| {
            let direction = hour.as_ref().filter(|h| h.position.altitude > 0.0)?.position.direction();
            let near = |s: &Sun| s.direction.dot(direction);
            let best = candidates.iter().enumerate().max_by(|a, b| near(&a.1.1).total_cmp(&near(&b.1.1)));
            if let Some((number, (_, sun))) = best
                && near(sun) >= least
            {
                return Some(number);
            }
            candidates.push((candidates.len(), Sun::new(direction)));
            Some(candidates.len() - 1)
        })
        .collect();
    let columns = candidates.len();
    (candidates, of_hour, columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::{Frame, KlemsBasis};
    use crate::error::Warnings;
    use crate::scene::SurfaceOrigin;
    use glam::DVec3;

    fn year(latitude: f64, direct: f64) -> Weather {
        let mut text = format!("place X\nlatitude {latitude}\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n");
        for (month, days) in [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31].into_iter().enumerate() {
            for day in 1..=days {
                for hour in 0..24 {
                    text.push_str(&format!("{} {day} {hour}.5 {direct} 50\n", month + 1));
                }
            }
        }
        Weather::from_bytes(text.as_bytes(), &mut Warnings::new()).unwrap()
    }

    fn window(normal: DVec3) -> Window {
        Window {
            name: "w".into(),
            triangles: vec![[DVec3::ZERO, DVec3::Z, DVec3::X]],
            frame: Frame::new(normal, DVec3::Z).unwrap(),
            basis: KlemsBasis::Full.into(),
            origin: SurfaceOrigin { name: "w".into(), file: "w.rad".into(), line: 1 },
        }
    }

    #[test]
    fn every_sun_is_counted_once() {
        let weather = year(45.0, 500.0);
        let mf6 = SunScheme::Patches(ReinhartSky::new(6).unwrap());
        // A window to the south: its normal points north, into the room.
        for windows in [vec![], vec![window(DVec3::Y)], vec![window(DVec3::Y), window(DVec3::NEG_Y)]] {
            for scheme in [mf6, SunScheme::HOURLY] {
                let set = SunSet::new(&weather, scheme, &windows).unwrap();
                let c = &set.census;
                println!("{} {c:?}", windows.len());
                assert_eq!(c.needed + c.never + c.behind_windows, c.all);
                assert_eq!(c.needed, set.suns.len());
                let traced = set.hours.iter().flatten().count();
                assert_eq!(traced as f64 + c.hours_behind_windows, c.hours);
                assert_eq!(set.behind.iter().filter(|b| **b).count() as f64, c.hours_behind_windows);
                if windows.len() == 1 {
                    assert!(c.behind_windows > 0 && c.hours_behind_windows > 0.0, "the sun rises in the north-east in summer");
                    assert!(set.suns.iter().all(|s| s.direction.y < 0.005));
                } else {
                    assert_eq!(c.behind_windows, 0);
                }
            }
        }
        assert_eq!(SunSet::new(&weather, mf6, &[]).unwrap().census.all, 5185);
    }

    #[test]
    fn hourly_suns_stand_where_the_sun_is() {
        let weather = year(45.0, 500.0);
        for degrees in [0.0, 0.2, 1.0] {
            let tolerance = f64::to_radians(degrees);
            let set = SunSet::new(&weather, SunScheme::Hourly { tolerance }, &[]).unwrap();
            for (record, hour) in weather.records.iter().zip(&set.hours) {
                let position = weather.sun(record);
                assert_eq!(hour.is_some(), position.altitude > 0.0);
                if let Some((sun, radiance)) = hour {
                    let angle = set.suns[*sun].direction.angle_between(position.direction());
                    assert!(angle <= tolerance + 1e-7, "{}°", angle.to_degrees());
                    assert!(*radiance > 0.0);
                }
            }
            println!("{degrees}°: {} suns for {} hours", set.suns.len(), set.census.hours);
            assert!(set.suns.len() as f64 <= set.census.hours);
        }
    }

    #[test]
    fn without_sun_there_are_no_suns() {
        let set = SunSet::new(&year(45.0, 0.0), SunScheme::HOURLY, &[]).unwrap();
        assert!(set.suns.is_empty() && set.hours.iter().all(Option::is_none));
        assert_eq!(set.census.hours_without, 8760.0);
    }
}
