//! Perez' all-weather model: luminous efficacy of sky and sun (Perez et al. 1990, Solar Energy
//! 44(5):271-289) and the distribution of luminance over the sky (Perez et al. 1993, Solar Energy
//! 50(3):235-245 with its erratum), with the limits that gendaymtx puts on their inputs.

use crate::units::{SOLAR_CONSTANT, SOLAR_CONSTANT_LUX};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Lower limits of the eight categories of sky clearness ε (1990, table 1).
const CLEARNESS_CATEGORIES: [f64; 8] = [1.0, 1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2];

/// Where ε is cut off. It only chooses a category, so that any value in the last one does.
const MAX_CLEARNESS: f64 = 12.0;

/// x₁…x₄ of a, b, c, d, e for each category (1993, table 1).
const DISTRIBUTION: [[[f64; 4]; 5]; 8] = [
    [
        [1.3525, -0.2576, -0.2690, -1.4366],
        [-0.7670, 0.0007, 1.2734, -0.1233],
        [2.8000, 0.6004, 1.2375, 1.0000],
        [1.8734, 0.6297, 0.9738, 0.2809],
        [0.0356, -0.1246, -0.5718, 0.9938],
    ],
    [
        [-1.2219, -0.7730, 1.4148, 1.1016],
        [-0.2054, 0.0367, -3.9128, 0.9156],
        [6.9750, 0.1774, 6.4477, -0.1239],
        [-1.5798, -0.5081, -1.7812, 0.1080],
        [0.2624, 0.0672, -0.2190, -0.4285],
    ],
    [
        [-1.1000, -0.2515, 0.8952, 0.0156],
        [0.2782, -0.1812, -4.5000, 1.1766],
        [24.7219, -13.0812, -37.7000, 34.8438],
        [-5.0000, 1.5218, 3.9229, -2.6204],
        [-0.0156, 0.1597, 0.4199, -0.5562],
    ],
    [
        [-0.5484, -0.6654, -0.2672, 0.7117],
        [0.7234, -0.6219, -5.6812, 2.6297],
        [33.3389, -18.3000, -62.2500, 52.0781],
        [-3.5000, 0.0016, 1.1477, 0.1062],
        [0.4659, -0.3296, -0.0876, -0.0329],
    ],
    [
        [-0.6000, -0.3566, -2.5000, 2.3250],
        [0.2937, 0.0496, -5.6812, 1.8415],
        [21.0000, -4.7656, -21.5906, 7.2492],
        [-3.5000, -0.1554, 1.4062, 0.3988],
        [0.0032, 0.0766, -0.0656, -0.1294],
    ],
    [
        [-1.0156, -0.3670, 1.0078, 1.4051],
        [0.2875, -0.5328, -3.8500, 3.3750],
        [14.0000, -0.9999, -7.1406, 7.5469],
        [-3.4000, -0.1078, -1.0750, 1.5702],
        [-0.0672, 0.4016, 0.3017, -0.4844],
    ],
    [
        [-1.0000, 0.0211, 0.5025, -0.5119],
        [-0.3000, 0.1922, 0.7023, -1.6317],
        [19.0000, -5.0000, 1.2438, -1.9094],
        [-4.0000, 0.0250, 0.3844, 0.2656],
        [1.0468, -0.3788, -2.4517, 1.4656],
    ],
    [
        [-1.0500, 0.0289, 0.4260, 0.3590],
        [-0.3250, 0.1156, 0.7781, 0.0025],
        [31.0625, -14.5000, -46.1148, 55.3750],
        [-7.2312, 0.4050, 13.3500, 0.6234],
        [1.5000, -0.6426, 1.8564, 0.5636],
    ],
];

/// a…d of the diffuse luminous efficacy for each category (1990, table 4).
const DIFFUSE_EFFICACY: [[f64; 4]; 8] = [
    [97.24, -0.46, 12.00, -8.91],
    [107.22, 1.15, 0.59, -3.95],
    [104.97, 2.96, -5.53, -8.77],
    [102.39, 5.59, -13.95, -13.90],
    [100.71, 5.94, -22.75, -23.74],
    [106.42, 3.83, -36.15, -28.83],
    [141.88, 1.90, -53.24, -14.03],
    [152.23, 0.35, -45.27, -7.98],
];

/// a…d of the direct luminous efficacy for each category (1990, table 4).
const DIRECT_EFFICACY: [[f64; 4]; 8] = [
    [57.20, -4.55, -2.98, 117.12],
    [98.99, -3.46, -1.21, 12.38],
    [109.83, -4.90, -1.71, -8.81],
    [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16],
    [107.19, -1.25, -1.51, -26.73],
    [105.75, 0.77, -1.26, -34.44],
    [101.18, 1.58, -1.10, -8.29],
];

/// The sun's angle from the zenith as the model sees it, radians: never below the horizon, and kept
/// 3° off the zenith so that the circumsolar peak is not cut by the zenith patch.
pub fn model_zenith_angle(altitude: f64) -> f64 {
    if altitude <= 0.0 {
        FRAC_PI_2
    } else if altitude >= 87f64.to_radians() {
        3f64.to_radians()
    } else {
        FRAC_PI_2 - altitude
    }
}

/// What the model needs to know of an hour besides its measured values.
#[derive(Debug, Clone, Copy)]
pub struct Conditions {
    /// The sun's angle from the zenith, from [`model_zenith_angle`].
    pub zenith_angle: f64,
    /// Day of the year from 1.
    pub day_of_year: u16,
    /// Dew point, °C (11 where it is not known).
    pub dew_point: f64,
}

/// Irradiance and illuminance of an hour, and the kind of its sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkyState {
    /// Sky clearness ε, 1 (overcast) … 12.
    pub clearness: f64,
    /// Sky brightness Δ, 0.01 … 0.6.
    pub brightness: f64,
    /// Diffuse horizontal irradiance, W/m².
    pub diffuse_irradiance: f64,
    /// Direct normal irradiance, W/m².
    pub direct_irradiance: f64,
    /// Diffuse horizontal illuminance, lx.
    pub diffuse_illuminance: f64,
    /// Direct normal illuminance, lx.
    pub direct_illuminance: f64,
}

impl Conditions {
    /// The state of a sky with these irradiances, W/m².
    pub fn from_irradiance(&self, diffuse: f64, direct: f64) -> SkyState {
        let (clearness, brightness) = self.clearness_and_brightness(diffuse, direct);
        SkyState {
            clearness,
            brightness,
            diffuse_irradiance: diffuse,
            direct_irradiance: direct,
            diffuse_illuminance: diffuse * self.diffuse_efficacy(clearness, brightness),
            direct_illuminance: direct * self.direct_efficacy(clearness, brightness),
        }
    }

    /// The state of a sky with these illuminances, lx. Efficacy depends on irradiance, so it is
    /// found by iteration: until it changes by less than 10 W/m², five times at most.
    pub fn from_illuminance(&self, diffuse: f64, direct: f64) -> SkyState {
        let mut irradiance = [diffuse, direct].map(|v| v * SOLAR_CONSTANT / SOLAR_CONSTANT_LUX);
        let (mut clearness, mut brightness) = self.clearness_and_brightness(irradiance[0], irradiance[1]);
        let mut previous = [0.1; 2];
        for _ in 0..5 {
            if (0..2).all(|i| (irradiance[i] - previous[i]).abs() <= 10.0) {
                break;
            }
            previous = irradiance;
            irradiance[0] = diffuse / self.diffuse_efficacy(clearness, brightness);
            let efficacy = self.direct_efficacy(clearness, brightness);
            irradiance[1] = if efficacy > 0.1 { direct / efficacy } else { efficacy };
            (clearness, brightness) = self.clearness_and_brightness(irradiance[0], irradiance[1]);
        }
        SkyState {
            clearness,
            brightness,
            diffuse_irradiance: irradiance[0],
            direct_irradiance: irradiance[1],
            diffuse_illuminance: diffuse,
            direct_illuminance: direct,
        }
    }

    /// ε (1990, equation 1) and Δ (equation 2), limited to what the tables cover.
    fn clearness_and_brightness(&self, diffuse: f64, direct: f64) -> (f64, f64) {
        let cubed = 1.041 * self.zenith_angle.powi(3);
        // No diffuse light at all is the clearest sky there is.
        let ratio = if diffuse > 0.0 { (diffuse + direct) / diffuse } else { f64::INFINITY };
        let clearness = ((ratio + cubed) / (1.0 + cubed)).clamp(1.0, MAX_CLEARNESS);
        let brightness = diffuse * self.air_mass() / (SOLAR_CONSTANT * self.eccentricity());
        (clearness, brightness.clamp(0.01, 0.6))
    }

    /// Relative optical air mass (Kasten 1966).
    fn air_mass(&self) -> f64 {
        1.0 / (self.zenith_angle.cos() + 0.15 * (93.885 - self.zenith_angle.to_degrees()).powf(-1.253))
    }

    /// Squared ratio of the mean to the present distance of the sun (Spencer 1971).
    fn eccentricity(&self) -> f64 {
        let day = TAU * (f64::from(self.day_of_year) - 1.0) / 365.0;
        1.00011 + 0.034221 * day.cos() + 0.00128 * day.sin() + 0.000719 * (2.0 * day).cos() + 0.000077 * (2.0 * day).sin()
    }

    /// Precipitable water, cm (1990, equation 3).
    fn precipitable_water(&self) -> f64 {
        (0.07 * self.dew_point - 0.075).exp()
    }

    /// lm/W of the sky (1990, equation 7).
    fn diffuse_efficacy(&self, clearness: f64, brightness: f64) -> f64 {
        let [a, b, c, d] = DIFFUSE_EFFICACY[category(clearness)];
        a + b * self.precipitable_water() + c * self.zenith_angle.cos() + d * brightness.ln()
    }

    /// lm/W of the sun (1990, equation 8).
    fn direct_efficacy(&self, clearness: f64, brightness: f64) -> f64 {
        let [a, b, c, d] = DIRECT_EFFICACY[category(clearness)];
        (a + b * self.precipitable_water() + c * (5.73 * self.zenith_angle - 5.0).exp() + d * brightness).max(0.0)
    }
}

fn category(clearness: f64) -> usize {
    CLEARNESS_CATEGORIES.iter().rposition(|lower| clearness >= *lower).unwrap_or(0)
}

/// Relative luminance over the sky: the five parameters of an hour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distribution {
    /// a: brighter (> 0) or darker horizon.
    pub a: f64,
    /// b: how fast the horizon's effect fades.
    pub b: f64,
    /// c: strength of the circumsolar region.
    pub c: f64,
    /// d: its width.
    pub d: f64,
    /// e: backscattered light.
    pub e: f64,
}

impl Distribution {
    /// The parameters for a clearness ε, brightness Δ and zenith angle of the sun, radians (1993,
    /// equations 6 to 8).
    pub fn new(clearness: f64, brightness: f64, zenith_angle: f64) -> Self {
        // Outside its range of validity the model would have negative luminances.
        let delta = if clearness > 1.065 && clearness < 2.8 { brightness.max(0.2) } else { brightness };
        let category = category(clearness);
        let x = &DISTRIBUTION[category];
        let linear = |i: usize| x[i][0] + x[i][1] * zenith_angle + delta * (x[i][2] + x[i][3] * zenith_angle);
        let [a, b, mut c, mut d, e] = std::array::from_fn(linear);
        if category == 0 {
            c = (delta * (x[2][0] + x[2][1] * zenith_angle)).powf(x[2][2]).exp() - x[2][3];
            d = -(delta * (x[3][0] + x[3][1] * zenith_angle)).exp() + x[3][2] + delta * x[3][3];
        }
        Self { a, b, c, d, e }
    }

    /// The factor that depends on the height of a sky element alone.
    pub fn gradation(&self, cos_zenith: f64) -> f64 {
        1.0 + self.a * (self.b / cos_zenith).exp()
    }

    /// The factor that depends on its angle to the sun alone.
    pub fn indicatrix(&self, cos_gamma: f64) -> f64 {
        let cos_gamma = cos_gamma.clamp(-1.0, 1.0);
        1.0 + self.c * (self.d * cos_gamma.acos()).exp() + self.e * cos_gamma * cos_gamma
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parameters printed by `gendaylit -ang altitude 0 -P ε Δ` (Radiance 6.0a), six decimals.
    #[test]
    fn distribution_parameters_are_those_of_gendaylit() {
        let cases = [
            (1.0, 0.1, 60.0, [0.905401, -0.651839, 0.304613, -0.286357, -0.047990]),
            (1.03, 0.3, 45.0, [0.730990, -0.413482, 1.656780, -0.976714, 0.000358]),
            (1.1, 0.15, 30.0, [-1.228323, -0.872863, 8.344452, -2.190771, 0.208913]),
            (1.3, 0.25, 50.0, [-1.092272, -0.748233, 11.483138, -3.262937, 0.107396]),
            (1.7, 0.12, 40.0, [-0.967005, -0.479833, 15.384564, -3.254515, 0.213682]),
            (2.2, 0.3, 20.0, [-1.231003, -1.200505, 13.618446, -3.090623, -0.003292]),
            (3.5, 0.2, 35.0, [-0.866562, -0.395635, 12.883104, -3.489015, 0.179283]),
            (5.0, 0.1, 65.0, [-0.983886, -0.196837, 13.235445, -3.903067, 0.538162]),
            (8.0, 0.08, 41.2, [-0.974487, -0.179483, 20.132224, -5.836113, 1.218856]),
        ];
        for (clearness, brightness, zenith, expected) in cases {
            let p = Distribution::new(clearness, brightness, f64::to_radians(zenith));
            for (got, want) in [p.a, p.b, p.c, p.d, p.e].into_iter().zip(expected) {
                assert!((got - want).abs() < 3e-6, "ε {clearness}: {p:?} against {expected:?}");
            }
        }
    }

    #[test]
    fn categories_begin_at_their_lower_limit() {
        let found: Vec<usize> = CLEARNESS_CATEGORIES.iter().map(|c| category(*c)).collect();
        assert_eq!(found, [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(category(1.0649), 0);
        assert_eq!(category(12.0), 7);
    }

    #[test]
    fn illuminance_leads_back_to_the_irradiance_it_came_from() {
        for (diffuse, direct, altitude) in [(150.0, 500.0, 36.0), (100.0, 850.0, 49.0), (180.0, 100.0, 26.0), (120.0, 0.0, 27.0)] {
            let conditions = Conditions { zenith_angle: model_zenith_angle(f64::to_radians(altitude)), day_of_year: 80, dew_point: 11.0 };
            let there = conditions.from_irradiance(diffuse, direct);
            let back = conditions.from_illuminance(there.diffuse_illuminance, there.direct_illuminance);
            // The iteration stops within 10 W/m² of itself.
            assert!((back.diffuse_irradiance - diffuse).abs() < 10.0, "{back:?}");
            assert!((back.direct_irradiance - direct).abs() < 10.0, "{back:?}");
        }
    }

    #[test]
    fn extreme_hours_stay_finite() {
        for altitude in [-1.5, -0.001, 0.0, 0.001, 1.5, FRAC_PI_2] {
            let conditions = Conditions { zenith_angle: model_zenith_angle(altitude), day_of_year: 366, dew_point: -60.0 };
            for (diffuse, direct) in [(0.0, 1.0), (1500.0, 0.0), (1e-3, 1500.0), (1500.0, 1500.0)] {
                let lux = 100.0;
                for state in [conditions.from_irradiance(diffuse, direct), conditions.from_illuminance(diffuse * lux, direct * lux)] {
                    let p = Distribution::new(state.clearness, state.brightness, conditions.zenith_angle);
                    let l = p.gradation(0.01) * p.indicatrix(1.0);
                    assert!(l.is_finite() && state.diffuse_illuminance >= 0.0 && state.direct_illuminance >= 0.0, "{state:?} {p:?}");
                }
            }
        }
    }
}
