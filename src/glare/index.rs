//! Glare indices from the vertical illuminance and a list of sources.

use super::geometry::Totals;
use super::sources::Source;
use super::{Glare, Settings};
use crate::error::{Error, Result};

/// What stands for UGR and UGP where no background is left to compare the sources with.
pub const UNDEFINED: f64 = -99.0;

/// DGP = c1·Ev^a5 + c2·log10(1 + Σ Lˢ^a1 ω^a2 / (Ev^a3 P^a4)) + c3, at most 1
/// (J. Wienold and J. Christoffersen, Energy and Buildings 38, 2006).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DgpModel {
    /// Exponents a1 … a5 of luminance, solid angle, illuminance, position index, and of the
    /// illuminance in the first term.
    pub exponents: [f64; 5],
    /// c1, c2, c3.
    pub constants: [f64; 3],
    /// Whether DGP is multiplied by e^x/(1 + e^x), x = 0.024 Ev − 4, below 1000 lx
    /// (J. Wienold, 2012). Off by default, as in evalglare 3.
    pub low_light_correction: bool,
}

impl DgpModel {
    /// Constants of today's evalglare (3.06): 5.87e-5, 0.092, 0.159. The default.
    pub const EVALGLARE: Self =
        Self { exponents: [2.0, 1.0, 1.87, 2.0, 1.0], constants: [5.87e-5, 0.092, 0.159], low_light_correction: false };
    /// Constants of the paper of 2006: 5.87e-5, 0.0918, 0.16; `dcglare` uses these.
    pub const ORIGINAL: Self = Self { constants: [5.87e-5, 0.0918, 0.16], ..Self::EVALGLARE };

    /// The sum of the contrast term, Σ Lˢ^a1 ω^a2 / P^a4, from (luminance cd/m², solid angle sr,
    /// position index) of each source.
    pub(crate) fn contrast_sum(&self, sources: impl IntoIterator<Item = (f64, f64, f64)>) -> f64 {
        sources.into_iter().map(|source| self.contrast_of(source)).sum()
    }

    /// One source's part of `Self::contrast_sum`.
    pub fn contrast_of(&self, (luminance, solid_angle, position_index): (f64, f64, f64)) -> f64 {
        let [a1, a2, _, a4, _] = self.exponents;
        power(luminance, a1) * power(solid_angle, a2) / power(position_index, a4)
    }

    /// DGP from the vertical illuminance (lx) and `Self::contrast_sum`.
    ///
    /// Without light at the eye DGP is that of no source; should there be sources all the same
    /// (the illuminance was given from outside), it is 1.
    pub fn dgp(&self, vertical_illuminance: f64, contrast_sum: f64) -> f64 {
        let ev = vertical_illuminance;
        let [_, _, a3, _, a5] = self.exponents;
        let [c1, c2, c3] = self.constants;
        let contrast = if contrast_sum > 0.0 { (1.0 + contrast_sum / power(ev, a3)).log10() } else { 0.0 };
        let dgp = c1 * power(ev, a5) + c2 * contrast + c3;
        let factor = if self.low_light_correction { low_light_factor(ev) } else { 1.0 };
        (dgp * factor).min(1.0)
    }

    /// Standard error of DGP from those of the vertical illuminance (lx) and of the contrast sum,
    /// taken as independent; first order, at most 1. 0 where DGP is cut
    /// to 1.
    pub fn standard_error(&self, vertical_illuminance: f64, contrast_sum: f64, illuminance_error: f64, contrast_error: f64) -> f64 {
        let [by_illuminance, by_contrast] = self.slopes(vertical_illuminance, contrast_sum);
        // Without light the slopes are infinite; DGP itself spans no more than 1.
        let error = (by_illuminance * illuminance_error).hypot(by_contrast * contrast_error);
        if error <= 1.0 { error } else { 1.0 }
    }

    /// Change of DGP per lx and per unit of the contrast sum; 0 where DGP is cut to 1. Not finite
    /// without light at the eye.
    pub(crate) fn slopes(&self, vertical_illuminance: f64, contrast_sum: f64) -> [f64; 2] {
        if self.dgp(vertical_illuminance, contrast_sum) >= 1.0 {
            return [0.0; 2];
        }
        let ev = vertical_illuminance;
        let [_, _, a3, _, a5] = self.exponents;
        let [c1, c2, _] = self.constants;
        let scale = power(ev, a3);
        let ratio = if contrast_sum > 0.0 { contrast_sum / scale } else { 0.0 };
        let c2 = c2 / std::f64::consts::LN_10;
        let mut by_illuminance = c1 * a5 * power(ev, a5 - 1.0) - if ratio > 0.0 { c2 * a3 / ev / (1.0 + 1.0 / ratio) } else { 0.0 };
        let mut by_contrast = c2 / scale / (1.0 + ratio);
        if self.low_light_correction && ev < 1000.0 {
            let factor = low_light_factor(ev);
            by_illuminance = factor * by_illuminance + 0.024 * (1.0 - factor) * self.dgp(ev, contrast_sum);
            by_contrast *= factor;
        }
        [by_illuminance, by_contrast]
    }

    pub(super) fn check(&self) -> Result<()> {
        if self.exponents.iter().chain(&self.constants).all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(Error::new("the constants of DGP must be finite numbers").field("DGP"))
    }
}

impl Default for DgpModel {
    fn default() -> Self {
        Self::EVALGLARE
    }
}

/// x^a, quickly for the usual exponents.
fn power(x: f64, a: f64) -> f64 {
    if a == 1.0 {
        x
    } else if a == 2.0 {
        x * x
    } else {
        x.powf(a)
    }
}

/// Wienold's correction for dim scenes: e^x/(1 + e^x), x = 0.024 Ev − 4; 1 from 1000 lx.
pub(crate) fn low_light_factor(vertical_illuminance: f64) -> f64 {
    if vertical_illuminance >= 1000.0 {
        return 1.0;
    }
    1.0 / (1.0 + (4.0 - 0.024 * vertical_illuminance).exp())
}

/// Simplified DGP, from the vertical illuminance alone, for scenes without direct sun or its
/// reflections (J. Wienold, Building Simulation 2009): 6.22e-5 Ev + 0.184, at most 1.
pub fn dgps(vertical_illuminance: f64) -> f64 {
    (6.22e-5 * vertical_illuminance + 0.184).min(1.0)
}

/// Which luminance counts as the background (evalglare's `-q`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Background {
    /// (Ev − Edir)/π.
    #[default]
    Illuminance,
    /// Mean luminance of all that is no source.
    MeanLuminance,
    /// Ev/π, sources included.
    WholeIlluminance,
}

/// The glare indices of one picture. Finite for any picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Indices {
    /// Daylight glare probability.
    pub dgp: f64,
    /// Simplified daylight glare probability, without regard to the sources.
    pub dgps: f64,
    /// Daylight glare index (R. G. Hopkinson, 1972; source and position terms of P. Chauvel, 1982).
    pub dgi: f64,
    /// Unified glare rating (CIE 117, 1995).
    pub ugr: f64,
    /// Visual comfort probability, % (S. K. Guth, 1963).
    pub vcp: f64,
    /// CIE glare index (H. Einhorn, 1979).
    pub cgi: f64,
    /// Unified glare probability (M. Hirning et al., 2014).
    pub ugp: f64,
    /// Contrast term of DGP, Σ L²ω/(P² Ev^1.87).
    pub contrast: f64,
}

/// All that follows from the totals of a picture and its sources.
pub(super) fn judge(
    totals: &Totals,
    task_luminance: Option<f64>,
    threshold: f64,
    sources: Vec<Source>,
    given_illuminance: Option<f64>,
    settings: &Settings,
) -> Glare {
    let ev = totals.vertical_illuminance;
    let direct = sources.iter().map(|s| s.illuminance).sum::<f64>().min(ev);
    let background = background_luminance(totals, direct, &sources, settings.background);
    let ev_of_dgp = given_illuminance.unwrap_or(ev);
    let sum = settings.dgp.contrast_sum(sources.iter().map(|s| (s.luminance, s.solid_angle, s.position_index)));
    // Σ L²ω/P², which UGR, UGP and CGI share.
    let glare_sum: f64 = sources.iter().map(|s| s.luminance.powi(2) * s.solid_angle / s.position_index.powi(2)).sum();
    let ugr_argument = if background > 0.0 { 0.25 / background * glare_sum } else { 0.0 };
    let of_sources = |value: f64, defined: bool| match (sources.is_empty(), defined) {
        (true, _) => 0.0,
        (false, true) => value,
        (false, false) => UNDEFINED,
    };
    let indices = Indices {
        dgp: settings.dgp.dgp(ev_of_dgp, sum),
        dgps: dgps(ev_of_dgp),
        dgi: of_sources(dgi(&sources, background), true),
        ugr: of_sources(8.0 * ugr_argument.log10(), ugr_argument > 0.0),
        vcp: vcp(&sources, totals.average_luminance),
        cgi: of_sources(8.0 * (2.0 * (1.0 + direct / 500.0) / ev * glare_sum).log10(), ev > 0.0),
        ugp: of_sources(0.26 * ugr_argument.log10(), ugr_argument > 0.0),
        contrast: if sum > 0.0 && ev_of_dgp > 0.0 { (sum / power(ev_of_dgp, settings.dgp.exponents[2])).min(f64::MAX) } else { 0.0 },
    };
    Glare {
        vertical_illuminance: ev,
        direct_illuminance: direct,
        average_luminance: totals.average_luminance,
        background_luminance: background,
        task_luminance,
        threshold,
        sources,
        indices,
    }
}

fn background_luminance(totals: &Totals, direct: f64, sources: &[Source], rule: Background) -> f64 {
    let remainder = |whole: f64, part: f64| {
        // Where sources fill the picture only rounding is left.
        let rest = whole - part;
        if rest > 1e-9 * whole { rest } else { 0.0 }
    };
    let ev = totals.vertical_illuminance;
    match rule {
        Background::Illuminance => remainder(ev, direct) / std::f64::consts::PI,
        Background::WholeIlluminance => ev / std::f64::consts::PI,
        Background::MeanLuminance => {
            let flux: f64 = sources.iter().map(|s| s.luminance * s.solid_angle).sum();
            let solid_angle = remainder(totals.solid_angle, sources.iter().map(|s| s.solid_angle).sum());
            if solid_angle > 0.0 { remainder(totals.average_luminance * totals.solid_angle, flux) / solid_angle } else { 0.0 }
        }
    }
}

fn dgi(sources: &[Source], background: f64) -> f64 {
    let sum: f64 = sources
        .iter()
        .map(|s| {
            let seen = (s.solid_angle / s.position_index.powi(2)).powf(0.8);
            0.478 * s.luminance.powf(1.6) * seen / (background + 0.07 * s.solid_angle.sqrt() * s.luminance)
        })
        .sum();
    10.0 * sum.log10()
}

/// From the discomfort glare rating; 100 below a rating of 20 and 0 above 750.
fn vcp(sources: &[Source], average_luminance: f64) -> f64 {
    if sources.is_empty() {
        return 100.0;
    }
    let field = average_luminance.powf(0.44);
    let sum: f64 = sources
        .iter()
        .map(|s| {
            // Guth's fit turns negative for sources below 3e-7 sr, which do not disturb.
            let size = (20.4 * s.solid_angle + 1.52 * s.solid_angle.powf(0.2) - 0.075).max(0.0);
            0.5 * s.luminance * size / (s.position_index * field)
        })
        .sum();
    let rating = sum.powf((sources.len() as f64).powf(-0.0914));
    if rating < 20.0 {
        100.0
    } else if rating > 750.0 {
        0.0
    } else {
        50.0 + 50.0 * libm::erf((6.374 - 1.3227 * rating.ln()) / std::f64::consts::SQRT_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dgp_of_a_uniform_field_with_a_sun_on_the_axis() {
        // Uniform 1000 cd/m² and a sun of 1e7 cd/m², 6.7967e-5 sr, on the line of sight.
        let (ev, omega) = (1000.0 * std::f64::consts::PI + 1e7 * 6.7967e-5, 6.7967e-5);
        let sum = DgpModel::ORIGINAL.contrast_sum([(1e7, omega, 1.0)]);
        assert!((DgpModel::ORIGINAL.dgp(ev, sum) - 0.6720).abs() < 5e-5);
        // Today's constants differ in the third digit.
        assert!((DgpModel::EVALGLARE.dgp(ev, sum) - DgpModel::ORIGINAL.dgp(ev, sum)).abs() > 1e-4);
    }

    #[test]
    fn low_light_and_limits() {
        assert!((low_light_factor(200.0) - 0.68997).abs() < 1e-5);
        assert_eq!(low_light_factor(1000.0), 1.0);
        for model in [DgpModel::EVALGLARE, DgpModel { low_light_correction: true, ..DgpModel::ORIGINAL }] {
            for ev in [0.0, 1e-300, 1.0, 1e5, 1e300] {
                for sum in [0.0, 1e-300, 1.0, 1e30, 1e300] {
                    let dgp = model.dgp(ev, sum);
                    assert!((0.0..=1.0).contains(&dgp), "{ev} {sum} {dgp}");
                    let error = model.standard_error(ev, sum, 1.0, 1.0);
                    assert!(error.is_finite(), "{ev} {sum} {error}");
                }
            }
        }
        assert!((dgps(1000.0) - 0.2462).abs() < 1e-12);
        assert_eq!(dgps(1e9), 1.0);
    }

    #[test]
    fn standard_error_is_the_spread_of_dgp() {
        let m = DgpModel::EVALGLARE;
        let (ev, sum, ev_error, sum_error) = (2500.0f64, 4e6, 25.0, 8e4);
        let expected = (5.87e-5
            - m.constants[1] / std::f64::consts::LN_10 * 1.87 * (sum / ev.powf(1.87)) / (1.0 + sum / ev.powf(1.87)) / ev)
            * ev_error;
        let by_sum = m.constants[1] / std::f64::consts::LN_10 / (ev.powf(1.87) + sum) * sum_error;
        let error = m.standard_error(ev, sum, ev_error, sum_error);
        assert!((error / expected.hypot(by_sum) - 1.0).abs() < 1e-12, "{error}");
        // By differences, with the correction for dim scenes too.
        let dim = DgpModel { low_light_correction: true, ..m };
        for (m, ev) in [(m, 2500.0), (dim, 150.0), (dim, 800.0)] {
            let slope = (m.dgp(ev + 0.01, sum) - m.dgp(ev - 0.01, sum)) / 0.02;
            assert!((m.standard_error(ev, sum, 1.0, 0.0) / slope.abs() - 1.0).abs() < 1e-6);
            let slope = (m.dgp(ev, sum + 10.0) - m.dgp(ev, sum - 10.0)) / 20.0;
            assert!((m.standard_error(ev, sum, 0.0, 1.0) / slope - 1.0).abs() < 1e-6);
        }
    }
}
