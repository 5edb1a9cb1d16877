//! The CIE's skies as Radiance's `gensky` has them, for a moment of a site: overcast, clear, intermediate,
//! uniform; and their column of the sky matrix, as `genskyvec` makes it.

use super::{Matrix, Patches, SkyOptions, check};
use crate::bins::ReinhartSky;
use crate::error::{Error, Result, Warnings};
use crate::units::LUMINOUS_EFFICACY;
pub use crate::weather::CieSky;
use crate::weather::sun::{SunPosition, position};
use crate::weather::time::Time;
use crate::weather::{Quantity, Record, Weather};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Turbidity of the air that gensky assumes.
pub const TURBIDITY: f64 = 2.45;

/// Luminous efficacies of sky and sun by which gensky turns luminance into radiance, lm/W (Radiance's `color.h`).
const SKY_EFFICACY: f64 = 203.0;
const SUN_EFFICACY: f64 = 208.0;

/// Solid angle of gensky's sun, sr.
const SUN_SOLID_ANGLE: f64 = 6e-5;

/// Illuminance outdoors under a sky of no particular time, lx: a lux indoors is a hundredth of a percent of it.
pub const OUTDOORS: f64 = 10_000.0;

/// The weather of moments, each under a sky of its own. `site` is latitude, longitude and standard meridian, degrees
/// north and east; without it an overcast or uniform sky gives [`OUTDOORS`].
///
/// # Errors
/// As [`CieMoment::new`]; a clear or intermediate sky without a site, no time at all.
pub fn weather(moments: &[(CieSky, Time)], site: Option<[f64; 3]>, warnings: &mut Warnings) -> Result<Weather> {
    if site.is_none() && moments.iter().any(|(kind, _)| kind.shows_sun()) {
        return Err(Error::new("this sky depends on where the sun stands").help("give the site, and month, day and time"));
    }
    if moments.is_empty() {
        return Err(Error::new("there is no time").help("give month, day and standard time, as 03-21T12:00"));
    }
    let [latitude, longitude, meridian] = site.unwrap_or_default();
    let time_zone = meridian / 15.0;
    let mut weather = Weather { latitude, longitude, time_zone, ..Weather::nowhere(Quantity::Illuminance) };
    for &(kind, time) in moments {
        let day_of_year = time.day_of_year();
        let (diffuse, direct) = if site.is_some() {
            let sun = position(latitude, longitude, weather.time_zone, day_of_year, time.hour);
            let moment = CieMoment::new(kind, sun, TURBIDITY, warnings)
                .map_err(|e| Error::new(format!("{time}: {}", e.message())).help("choose another time (standard time of the site)"))?;
            (moment.diffuse() * LUMINOUS_EFFICACY, moment.direct() * LUMINOUS_EFFICACY)
        } else {
            (OUTDOORS, 0.0)
        };
        weather.records.push(Record {
            month: time.month,
            day: time.day,
            hour: time.hour,
            day_of_year,
            direct,
            diffuse,
            dew_point: None,
            line: 0,
        });
        weather.skies.push(kind);
    }
    Ok(weather)
}

/// A CIE sky with the sun at its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CieMoment {
    kind: CieSky,
    sun: DVec3,
    /// Radiance of the zenith, W/m²sr.
    zenith: f64,
    /// What the sky's formula is divided by so that the zenith has that radiance.
    formula_at_zenith: f64,
    /// Mean radiance of the sky, weighted with the cosine: horizontal irradiance / π.
    ambient: f64,
    /// Direct normal irradiance, W/m².
    direct: f64,
}

impl CieMoment {
    /// The sky of a kind when the sun is at a place, in air of a turbidity ([`TURBIDITY`]).
    ///
    /// # Errors
    /// A sun below the horizon under a clear or intermediate sky; a sky without light.
    pub fn new(kind: CieSky, sun: SunPosition, turbidity: f64, warnings: &mut Warnings) -> Result<Self> {
        let mut sun = sun;
        let highest = 87f64.to_radians();
        if kind.shows_sun() && sun.altitude <= 0.0 {
            return Err(Error::new(format!("the sun is {:.1}° below the horizon", -sun.altitude.to_degrees()))
                .help("choose another time (standard time of the site), or an overcast sky"));
        }
        if kind.shows_sun() && sun.altitude > highest {
            warnings.push(
                Error::new(format!("the sun is {:.1}° high: it is taken as 87°, as gensky does", sun.altitude.to_degrees()))
                    .help("the formula of this sky does not hold for a sun at the zenith"),
            );
            sun.altitude = highest;
        }
        let direction = sun.direction();
        let height = direction.z;
        let from_zenith = FRAC_PI_2 - sun.altitude;
        // Polynomials in the altitude for horizontal irradiance over the formula's value at the zenith.
        let x = (sun.altitude - FRAC_PI_4) / FRAC_PI_4;
        let series = |c: [f64; 5]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let clear_zenith = ((1.376 * turbidity - 1.81) * sun.altitude.tan() + 0.38).max(0.0);
        let overcast_zenith = (8.6 * height + 0.123).max(0.0);
        let (formula_at_zenith, ambient_share, zenith) = match kind {
            CieSky::Uniform => (1.0, 1.0, overcast_zenith),
            CieSky::Overcast => (1.0, 7.0 / 9.0, overcast_zenith),
            CieSky::Clear => {
                let formula = 0.274 * (0.91 + 10.0 * (-3.0 * from_zenith).exp() + 0.45 * height * height);
                (formula, series([2.766521, 0.547665, -0.369832, 0.009237, 0.059229]) / formula / PI, clear_zenith)
            }
            CieSky::Intermediate => {
                let formula =
                    (2.739 + 0.9891 * (0.3119 + 2.6 * sun.altitude).sin()) * (-from_zenith * (0.4441 + 1.48 * sun.altitude)).exp();
                let series = series([3.5556, -2.7152, -1.3081, 1.0660, 0.60227]);
                (formula, series / formula / PI, (clear_zenith + overcast_zenith) / 2.0)
            }
        };
        if !(zenith > 0.0) {
            return Err(Error::new("this sky gives no light: it is night").help("choose another time (standard time of the site)"));
        }
        let zenith = zenith * 1000.0 / SKY_EFFICACY;
        let radiance = 1.5e9 / SUN_EFFICACY * (1.147 - 0.147 / height.max(0.16));
        let direct = match kind {
            CieSky::Clear => radiance * SUN_SOLID_ANGLE,
            CieSky::Intermediate => 0.15 * radiance * SUN_SOLID_ANGLE,
            _ => 0.0,
        };
        Ok(Self { kind, sun: direction, zenith, formula_at_zenith, ambient: zenith * ambient_share, direct })
    }

    /// Irradiance of the sky on the horizontal plane without the sun, W/m².
    pub fn diffuse(&self) -> f64 {
        self.ambient * PI
    }

    /// Irradiance of the sun across its rays, W/m².
    pub fn direct(&self) -> f64 {
        self.direct
    }

    /// Only how the sky's luminance is spread, whatever its amount.
    pub(super) fn shape(kind: CieSky, sun: SunPosition) -> Self {
        let formula_at_zenith = 1.0;
        Self { kind, sun: sun.direction(), zenith: 1.0, formula_at_zenith, ambient: 0.0, direct: 0.0 }
    }

    /// Radiance of the ground before it reflects: what sky and sun throw on it, over π.
    fn ground(&self) -> f64 {
        self.ambient + self.direct * self.sun.z.max(0.0) / PI
    }

    /// Radiance of the sky alone in a direction of unit length above the horizon, W/m²sr.
    pub fn radiance(&self, direction: DVec3) -> f64 {
        let height = direction.z;
        let angle = |cosine: f64| cosine.clamp(-1.0, 1.0).acos();
        let to_sun = angle(direction.dot(self.sun));
        let (sun_from_zenith, from_zenith) = (angle(self.sun.z), angle(height));
        let relative = match self.kind {
            CieSky::Uniform => 1.0,
            CieSky::Overcast => (1.0 + 2.0 * height) / 3.0,
            CieSky::Clear => {
                let gradation = if height > 0.01 { 1.0 - (-0.32 / height).exp() } else { 1.0 };
                (0.91 + 10.0 * (-3.0 * to_sun).exp() + 0.45 * to_sun.cos().powi(2)) * gradation / self.formula_at_zenith
            }
            CieSky::Intermediate => {
                ((1.35 * (5.631 - 3.59 * from_zenith).sin() + 3.12) * (4.396 - 2.6 * sun_from_zenith).sin() + 6.37 - from_zenith) / 2.326
                    * (to_sun * -0.563 * ((2.629 - from_zenith) * (1.562 - sun_from_zenith) + 0.812)).exp()
                    / self.formula_at_zenith
            }
        };
        self.zenith * relative
    }

    /// The column of the sky matrix: the ground, then the patches of [`ReinhartSky`], each with the sky at its
    /// centre; the sun on the four patches nearest to it. As the scene of `gensky` has it, sky and ground run into
    /// each other at the horizon.
    ///
    /// Of the options the subdivision, sky and sun, colours and the sun's disc count.
    ///
    /// # Errors
    /// Options out of their range.
    pub fn matrix(&self, options: &SkyOptions) -> Result<Matrix<f32>> {
        check(options)?;
        let patches = Patches::new(ReinhartSky::new(options.subdivision)?);
        let mut column = Matrix::zeros(patches.len(), 1, 3);
        let has_sun = options.sun && self.direct > 0.0;
        let ground = self.ground();
        if options.sky {
            let grey = options.ground_reflectance.iter().sum::<f64>() / 3.0;
            for patch in 0..patches.len() {
                let (value, color) = if patch == 0 {
                    (ground, options.ground_reflectance)
                } else {
                    let direction = patches.centre(patch);
                    let weight = (direction.z + 1.01).powi(10);
                    let mean = (weight * self.radiance(direction) + ground * grey / weight) / (weight + 1.0 / weight);
                    (mean, options.sky_color)
                };
                column.at_mut(patch, 0).iter_mut().zip(color).for_each(|(out, c)| *out = (value * c) as f32);
            }
        }
        if has_sun {
            for (patch, radiance) in patches.sun(self.sun, self.direct, options.sun_disc).iter() {
                column.at_mut(patch, 0).iter_mut().for_each(|v| *v += radiance as f32);
            }
        }
        Ok(column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use std::io::Write;

    fn moment(kind: CieSky, altitude: f64, azimuth: f64) -> CieMoment {
        let sun = SunPosition { altitude: altitude.to_radians(), azimuth: azimuth.to_radians() };
        CieMoment::new(kind, sun, TURBIDITY, &mut Warnings::new()).unwrap()
    }

    #[test]
    fn the_overcast_and_the_uniform_sky_give_what_their_formulas_integrate_to() {
        for (kind, share) in [(CieSky::Overcast, 7.0 / 9.0), (CieSky::Uniform, 1.0)] {
            let sky = moment(kind, 30.0, 180.0);
            let zenith = sky.radiance(DVec3::Z);
            // 8.6 sin 30° + 0.123 kcd/m².
            assert!((zenith - 4423.0 / SKY_EFFICACY).abs() < 1e-9, "{zenith}");
            assert!((sky.diffuse() / (PI * zenith) - share).abs() < 1e-12);
            assert_eq!(sky.direct(), 0.0);
            let sum: f64 = (0..90)
                .map(|k| (f64::from(k) + 0.5).to_radians())
                .map(|a| sky.radiance(DVec3::new(a.cos(), 0.0, a.sin())) * a.sin() * a.cos())
                .sum();
            assert!((sum * 2.0 * PI * PI / 180.0 / sky.diffuse() - 1.0).abs() < 1e-4);
        }
        assert!(
            (moment(CieSky::Overcast, 30.0, 0.0).radiance(DVec3::X) * 3.0 / moment(CieSky::Overcast, 30.0, 0.0).radiance(DVec3::Z) - 1.0)
                .abs()
                < 1e-12
        );
    }

    #[test]
    fn night_and_a_sun_at_the_zenith_are_told() {
        let at = |kind, altitude: f64, warnings: &mut Warnings| {
            CieMoment::new(kind, SunPosition { altitude: altitude.to_radians(), azimuth: 0.0 }, TURBIDITY, warnings)
        };
        let mut warnings = Warnings::new();
        assert!(at(CieSky::Clear, -5.0, &mut warnings).unwrap_err().message().contains("5.0° below the horizon"));
        assert!(at(CieSky::Overcast, -5.0, &mut warnings).unwrap_err().message().contains("it is night"));
        assert!(warnings.is_empty());
        let high = at(CieSky::Clear, 89.0, &mut warnings).unwrap();
        assert_eq!(high, at(CieSky::Clear, 87.0, &mut Warnings::new()).unwrap());
        assert!(warnings.iter().any(|w| w.to_string().contains("89.0° high")));
        at(CieSky::Overcast, 89.0, &mut Warnings::new()).unwrap();
    }

    #[test]
    fn a_daylight_factor_needs_no_site() {
        let noon = Time::parse("03-21T12:00").unwrap();
        let weather =
            weather(&[noon, Time::parse("06-21T09:00").unwrap()].map(|t| (CieSky::Overcast, t)), None, &mut Warnings::new()).unwrap();
        let matrix = crate::sky::sky_matrix(
            &weather,
            &SkyOptions { sky_color: [1.0; 3], subdivision: 2, ..SkyOptions::default() },
            &crate::progress::Silent,
        )
        .unwrap();
        let sky = ReinhartSky::new(2).unwrap();
        let patches = Patches::new(sky);
        for column in 0..2 {
            let value = |patch: usize| f64::from(matrix.at(patch, column)[1]);
            let horizontal: f64 = (1..sky.len()).map(|p| value(p) * sky.solid_angle(p) * patches.centre(p).z).sum();
            assert!((horizontal * LUMINOUS_EFFICACY / OUTDOORS - 1.0).abs() < 1e-5, "{horizontal}");
            assert!((value(0) - 0.2 * OUTDOORS / LUMINOUS_EFFICACY / PI).abs() < 1e-4);
            let zenith = value(sky.len() - 1);
            assert!((1..sky.len()).all(|p| (value(p) / zenith - (1.0 + 2.0 * patches.centre(p).z) / 3.0).abs() < 1e-6));
        }
        assert!(crate::sky::sun_hours(&weather, &SkyOptions::default()).unwrap().iter().all(Option::is_none));
        assert!(super::weather(&[(CieSky::Clear, noon)], None, &mut Warnings::new()).is_err());
        assert!(super::weather(&[], None, &mut Warnings::new()).is_err());
    }

    #[test]
    fn a_clear_moment_of_a_site_has_the_light_that_its_formula_gives() {
        let noon = Time::parse("03-21T12:00").unwrap();
        let weather = weather(&[(CieSky::Clear, noon)], Some([46.5, 11.35, 15.0]), &mut Warnings::new()).unwrap();
        let moment = CieMoment::new(CieSky::Clear, weather.sun(&weather.records[0]), TURBIDITY, &mut Warnings::new()).unwrap();
        let options = SkyOptions { sky_color: [1.0; 3], sun: false, subdivision: 4, ..SkyOptions::default() };
        let matrix = crate::sky::sky_matrix(&weather, &options, &crate::progress::Silent).unwrap();
        let patches = Patches::new(ReinhartSky::new(4).unwrap());
        // Its luminance is spread as the formula says, and gives gensky's horizontal illuminance.
        let sky = ReinhartSky::new(4).unwrap();
        let value = |patch: usize| f64::from(matrix.at(patch, 0)[1]);
        let ratio = |patch: usize| value(patch) / moment.radiance(patches.centre(patch));
        assert!((1..sky.len()).all(|p| (ratio(p) / ratio(1) - 1.0).abs() < 1e-5));
        let horizontal: f64 = (1..sky.len()).map(|p| value(p) * sky.solid_angle(p) * patches.centre(p).z).sum();
        assert!((horizontal / moment.diffuse() - 1.0).abs() < 1e-5, "{horizontal} {}", moment.diffuse());
        let suns = crate::sky::sun_hours(&weather, &SkyOptions::default()).unwrap();
        let disc = crate::units::cap_solid_angle((crate::units::SUN_DIAMETER_DEG / 2.0).to_radians());
        assert!((suns[0].unwrap().radiance * disc / moment.direct() - 1.0).abs() < 1e-4);
        let night =
            super::weather(&[(CieSky::Clear, Time::parse("12-21T23:00").unwrap())], Some([46.5, 11.35, 15.0]), &mut Warnings::new());
        assert!(night.unwrap_err().to_string().contains("21 December, 23:00: the sun is"));
    }

    /// Against gensky and rtrace towards every patch; gensky prints three digits.
    #[test]
    fn skies_are_those_of_gensky() {
        let words = [(CieSky::Clear, "+s"), (CieSky::Intermediate, "+i"), (CieSky::Overcast, "-c"), (CieSky::Uniform, "-u")];
        for (kind, option) in words {
            for (altitude, azimuth) in [(48.3f64, 25.0f64), (12.0, -70.0), (80.0, 10.0)] {
                let Some(mut gensky) = testing::radiance("gensky") else { return };
                // gensky counts from south to west.
                let sky = testing::output(gensky.args(["-ang", &altitude.to_string(), &azimuth.to_string(), option, "-g", "0.2"]));
                let sky = String::from_utf8(sky).unwrap();
                let ours = moment(kind, altitude, azimuth + 180.0);
                let told = |start: &str| {
                    sky.lines().find(|l| l.starts_with(start)).map(|l| l.split_whitespace().map(str::to_string).collect::<Vec<_>>())
                };
                let ambient: f64 = told("# Ground ambient level").or_else(|| told("# Ground")).unwrap().last().unwrap().parse().unwrap();
                assert!((ambient - ours.ambient).abs() < 0.051, "{kind:?} {altitude}: {ambient} {}", ours.ambient);
                if let Some(light) = told("3 ").filter(|_| kind.shows_sun()) {
                    let radiance: f64 = light[1].parse().unwrap();
                    assert!((radiance * SUN_SOLID_ANGLE / ours.direct() - 1.0).abs() < 0.006, "{kind:?} {altitude}: {radiance}");
                }
                let folder = tempfile::tempdir().unwrap();
                let scene = format!("{sky}\nskyfunc glow g 0 0 4 1 1 1 0\ng source all 0 0 4 0 0 1 360\n");
                // Without the sun's disc, which no patch's centre is to meet.
                let scene: String = scene.replace("solar source sun", "solar source gone").replace("0.5\n", "0.01\n");
                std::fs::write(folder.path().join("s.rad"), scene).unwrap();
                let octree = testing::output(testing::radiance("oconv").unwrap().current_dir(folder.path()).args(["-w", "s.rad"]));
                std::fs::write(folder.path().join("s.oct"), octree).unwrap();
                let options = SkyOptions { sun: false, sky_color: [1.0; 3], ..SkyOptions::default() };
                let column = ours.matrix(&options).unwrap();
                let patches = Patches::new(ReinhartSky::new(1).unwrap());
                let mut input = tempfile::tempfile().unwrap();
                for patch in 0..patches.len() {
                    let d = patches.centre(patch);
                    writeln!(input, "0 0 0 {} {} {}", d.x, d.y, d.z).unwrap();
                }
                std::io::Seek::rewind(&mut input).unwrap();
                let mut rtrace = testing::radiance("rtrace").unwrap();
                let out = testing::output(rtrace.current_dir(folder.path()).args(["-h", "-w", "-ab", "0", "s.oct"]).stdin(input));
                for (patch, line) in String::from_utf8(out).unwrap().lines().enumerate() {
                    let theirs: f64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
                    let own = f64::from(column.at(patch, 0)[1]);
                    assert!((own / theirs - 1.0).abs() < 0.012, "{kind:?} {altitude} patch {patch}: {own} {theirs}");
                }
            }
        }
    }
}
