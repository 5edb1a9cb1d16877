//! Colours for numbers: palettes, scales and their ticks.

use crate::error::{Error, Result};

/// An sRGB colour.
pub type Color = [u8; 3];

/// White, the background of plots.
pub const WHITE: Color = [255; 3];
/// Nearly black, for text and axes.
pub const INK: Color = [34, 34, 34];
/// Light grey, for grid lines.
pub const GRID: Color = [214, 214, 214];
/// Where there is no value.
pub const NO_DATA: Color = [228, 228, 228];

/// A continuous palette over 0…1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Palette {
    /// Dark blue to yellow, even to the eye, prints in grey, suits colour-blind readers (S. van der
    /// Walt and N. Smith, CC0). The default.
    #[default]
    Viridis,
    /// Blue to yellow, made for colour-blind readers (Nuñez, Anderton and Renslow 2018; the
    /// polynomials are those of d3-scale-chromatic).
    Cividis,
    /// `def` of Radiance's `falsecolor`: blue, green, brown, red, yellow.
    Def,
    /// `spec` of Radiance's `falsecolor`, its old rainbow: blue, green, red.
    Spec,
    /// `pm3d` of Radiance's `falsecolor` and gnuplot: black, violet, orange, yellow.
    Pm3d,
    /// `hot` of Radiance's `falsecolor`: black, red, yellow, white.
    Hot,
    /// Black to white.
    Gray,
}

/// Every fifteenth colour of the 256 of viridis.
const VIRIDIS: [u32; 18] = [
    0x440154, 0x481769, 0x472a7a, 0x433d84, 0x3d4e8a, 0x355e8d, 0x2e6d8e, 0x297b8e, 0x23898e, 0x1f978b, 0x21a585, 0x2eb37c, 0x46c06f,
    0x65cb5e, 0x89d548, 0xb0dd2f, 0xd8e219, 0xfde725,
];

/// Radiance's `def` at 0, 1/22, … 1 as shown on a screen of gamma 2.2.
const DEF: [u32; 23] = [
    0x770b8c, 0x4402a1, 0x0b0bb6, 0x0031bc, 0x0163c0, 0x0890bd, 0x0dadaa, 0x12b672, 0x24b043, 0x48a242, 0x738b53, 0x917359, 0x9a6252,
    0x9f4e47, 0xa3393a, 0xa7272e, 0xaf1623, 0xcc0117, 0xe31c0e, 0xf45a02, 0xff9601, 0xffd11a, 0xfdfc30,
];

/// Gamma of the screens that Radiance's palettes are made for.
const GAMMA: f64 = 2.2;

impl Palette {
    /// All palettes.
    pub const ALL: [Self; 7] = [Self::Viridis, Self::Cividis, Self::Def, Self::Spec, Self::Pm3d, Self::Hot, Self::Gray];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Cividis => "cividis",
            Self::Def => "def",
            Self::Spec => "spec",
            Self::Pm3d => "pm3d",
            Self::Hot => "hot",
            Self::Gray => "gray",
        }
    }

    /// The palette of a name.
    ///
    /// # Errors
    /// If there is none; the message lists them.
    pub fn from_name(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|p| p.name()).collect();
            Error::new(format!("there is no palette '{name}'")).help(format!("choose one of {}", names.join(", ")))
        })
    }

    /// The colour at a position in 0…1; positions outside are clamped, NaN is [`NO_DATA`].
    pub fn color(self, position: f64) -> Color {
        if position.is_nan() {
            return NO_DATA;
        }
        let t = position.clamp(0.0, 1.0);
        match self {
            Self::Viridis => interpolate(&VIRIDIS, t),
            Self::Cividis => [
                polynomial(&[-4.54, -35.34, 2381.73, -6402.7, 7024.72, -2710.57], t) as u8,
                polynomial(&[32.49, 170.73, 52.82, -131.46, 176.58, -67.37], t) as u8,
                polynomial(&[81.24, 442.36, -2482.43, 6167.24, -6614.94, 2475.67], t) as u8,
            ],
            Self::Def => interpolate(&DEF, t),
            // Linear light in Radiance, hence the gamma.
            Self::Spec => {
                let green = if t > 0.375 { 1.6 - 1.6 * t } else { 8.0 / 3.0 * t };
                [1.6 * t - 0.6, green, 1.0 - 8.0 / 3.0 * t].map(|v: f64| byte(v.clamp(0.0, 1.0).powf(1.0 / GAMMA)))
            }
            Self::Pm3d => [byte(t.sqrt()), byte(t.powi(3)), byte((std::f64::consts::TAU * t).sin())],
            Self::Hot => [byte(3.0 * t), byte(3.0 * t - 1.0), byte(3.0 * t - 2.0)],
            Self::Gray => [byte(t); 3],
        }
    }
}

fn byte(value: f64) -> u8 {
    // The cast clamps to 0…255.
    (value * 255.0).round() as u8
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c).round()
}

fn interpolate(nodes: &[u32], t: f64) -> Color {
    let at = t * (nodes.len() - 1) as f64;
    let left = (at as usize).min(nodes.len() - 2);
    let fraction = at - left as f64;
    let channel = |node: u32, shift: u32| f64::from((node >> shift) & 0xff);
    [16, 8, 0].map(|shift| {
        let (a, b) = (channel(nodes[left], shift), channel(nodes[left + 1], shift));
        (a + (b - a) * fraction).round() as u8
    })
}

/// Six colours for classes or lines, distinct for colour-blind readers (Okabe and Ito 2008, without
/// yellow, which is too light for lines).
pub const CLASS_COLORS: [Color; 6] = [[0, 114, 178], [230, 159, 0], [0, 158, 115], [213, 94, 0], [86, 180, 233], [204, 121, 167]];

/// Black or white, whichever is easier to read on a colour.
pub fn readable_on(color: Color) -> Color {
    let [r, g, b] = color.map(|c| (f64::from(c) / 255.0).powf(GAMMA));
    if 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.25 { [0; 3] } else { WHITE }
}

/// From values to positions on a palette.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    minimum: f64,
    maximum: f64,
    logarithmic: bool,
}

impl Scale {
    /// Even steps from `minimum` to `maximum`.
    ///
    /// # Errors
    /// If they are not finite and in this order.
    pub fn linear(minimum: f64, maximum: f64) -> Result<Self> {
        if !(minimum.is_finite() && maximum.is_finite() && minimum < maximum) {
            return Err(Error::new(format!("a scale from {minimum} to {maximum} is not possible")).field("scale"));
        }
        Ok(Self { minimum, maximum, logarithmic: false })
    }

    /// `decades` powers of ten below `maximum` (`falsecolor -log decades`).
    ///
    /// # Errors
    /// If the maximum is not positive or the decades not within 0…30.
    pub fn logarithmic(maximum: f64, decades: f64) -> Result<Self> {
        if !(maximum.is_finite() && maximum > 0.0) {
            return Err(Error::new(format!("a logarithmic scale cannot end at {maximum}")).field("scale"));
        }
        if !(decades > 0.0 && decades <= 30.0) {
            return Err(Error::new(format!("{decades} decades are not possible"))
                .field("log")
                .help("give a number between 0 and 30, for instance 3"));
        }
        Ok(Self { minimum: maximum * 10f64.powf(-decades), maximum, logarithmic: true })
    }

    /// Its lower end.
    pub fn minimum(&self) -> f64 {
        self.minimum
    }

    /// Its upper end.
    pub fn maximum(&self) -> f64 {
        self.maximum
    }

    /// Position of a value: 0 at the minimum, 1 at the maximum, not clamped; NaN stays NaN, and
    /// values a logarithm does not have are −∞.
    pub fn position(&self, value: f64) -> f64 {
        if self.logarithmic {
            if value <= 0.0 {
                return f64::NEG_INFINITY;
            }
            (value / self.minimum).ln() / (self.maximum / self.minimum).ln()
        } else {
            (value - self.minimum) / (self.maximum - self.minimum)
        }
    }

    /// Value at a position.
    pub fn value(&self, position: f64) -> f64 {
        if self.logarithmic {
            self.minimum * (self.maximum / self.minimum).powf(position)
        } else {
            self.minimum + position * (self.maximum - self.minimum)
        }
    }

    /// About `count` round values within the scale, rising.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        if !self.logarithmic {
            return round_steps(self.minimum, self.maximum, count);
        }
        let mantissas: &[f64] = match (self.maximum / self.minimum).log10() * 3.0 {
            n if n <= count as f64 * 1.2 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let slack = 1e-9;
        let (low, high) = (self.minimum * (1.0 - slack), self.maximum * (1.0 + slack));
        let first = self.minimum.log10().floor() as i32;
        let last = self.maximum.log10().ceil() as i32;
        let mut ticks: Vec<f64> = (first..=last)
            .flat_map(|e| mantissas.iter().map(move |m| format!("{m}e{e}").parse().unwrap_or(0.0)))
            .filter(|v| (low..=high).contains(v))
            .collect();
        // Wide scales: every n-th decade.
        let skip = ticks.len().div_ceil(count.max(1) * 2).max(1);
        ticks = ticks.into_iter().rev().step_by(skip).collect();
        ticks.reverse();
        ticks
    }
}

/// Multiples of 1, 2, 2.5 or 5 · 10ⁿ within a range, at most about `count` of them.
pub fn round_steps(minimum: f64, maximum: f64, count: usize) -> Vec<f64> {
    let rough = (maximum - minimum) / count.max(1) as f64;
    if !(rough.is_finite() && rough > 0.0) {
        return vec![minimum];
    }
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= rough * (1.0 - 1e-9)).unwrap_or(10.0 * power);
    let first = (minimum / step - 1e-6).ceil() as i64;
    let last = (maximum / step + 1e-6).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

/// The next larger 1, 1.5, 2, 3, 5 or 7 · 10ⁿ, for the end of an automatic scale; a millionth above
/// one of them is still that one.
pub fn round_up(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let exponent = value.log10().floor() as i32;
    let round = |m: f64, e: i32| format!("{m}e{e}").parse::<f64>().unwrap_or(value);
    [1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0].into_iter().map(|m| round(m, exponent)).find(|v| *v >= value * (1.0 - 1e-6)).unwrap_or(value)
}

/// A number with at most four significant digits: `0`, `0.025`, `62.5`, `2000`, `1.6e9`. Whole
/// numbers below a million keep all their digits.
pub fn short_number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e6).contains(&size) {
        let text = format!("{value:.1e}");
        return text.replace(".0e", "e");
    }
    let digits = (3 - size.log10().floor() as i32).clamp(0, 8) as usize;
    let mut text = format!("{value:.digits$}");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    text
}

/// A measured number, rounded to three significant digits.
pub fn rounded_number(value: f64) -> String {
    short_number(format!("{value:.2e}").parse().unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middle_of_palettes() {
        assert_eq!(Palette::Viridis.color(0.0), [0x44, 0x01, 0x54]);
        assert_eq!(Palette::Viridis.color(1.0), [0xfd, 0xe7, 0x25]);
        // The 128th of the original's 256 colours is 21918c.
        for (a, b) in Palette::Viridis.color(128.0 / 255.0).iter().zip([0x21u8, 0x91, 0x8c]) {
            assert!(a.abs_diff(b) <= 3, "{:?}", Palette::Viridis.color(128.0 / 255.0));
        }
        assert_eq!(Palette::Cividis.color(1.0), [253, 234, 69]);
        assert_eq!(Palette::Hot.color(0.5), [255, 128, 0]);
        assert_eq!(Palette::Spec.color(1.0), [255, 0, 0]);
        assert_eq!(Palette::Gray.color(7.0), [255; 3]);
        assert_eq!(Palette::Gray.color(f64::NAN), NO_DATA);
        for palette in Palette::ALL {
            assert_eq!(Palette::from_name(palette.name()).unwrap(), palette);
            assert_eq!(palette.color(f64::NEG_INFINITY), palette.color(0.0));
        }
        assert!(Palette::from_name("jet").unwrap_err().to_string().contains("viridis"));
    }

    #[test]
    fn viridis_and_cividis_grow_steadily_lighter() {
        for palette in [Palette::Viridis, Palette::Cividis, Palette::Gray] {
            let lightness = |i: i32| {
                let [r, g, b] = palette.color(f64::from(i) / 20.0).map(|c| (f64::from(c) / 255.0).powf(2.2));
                0.2126 * r + 0.7152 * g + 0.0722 * b
            };
            assert!((0..20).all(|i| lightness(i) < lightness(i + 1)), "{palette:?}");
        }
    }

    #[test]
    fn scales_and_ticks() {
        let linear = Scale::linear(0.0, 2000.0).unwrap();
        assert_eq!(linear.position(500.0), 0.25);
        assert_eq!(linear.ticks(5), [0.0, 500.0, 1000.0, 1500.0, 2000.0]);
        let log = Scale::logarithmic(2000.0, 3.0).unwrap();
        assert!((log.position(2.0)).abs() < 1e-12 && (log.position(2000.0) - 1.0).abs() < 1e-12);
        assert!((log.position(200.0) - 2.0 / 3.0).abs() < 1e-12);
        assert!((log.value(log.position(37.0)) - 37.0).abs() < 1e-9);
        assert_eq!(log.position(0.0), f64::NEG_INFINITY);
        assert!(log.position(f64::NAN).is_nan());
        assert_eq!(log.ticks(8), [2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0]);
        assert_eq!(Scale::logarithmic(1e6, 7.0).unwrap().ticks(6), [0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6]);
        assert!(Scale::logarithmic(1e20, 30.0).unwrap().ticks(6).len() <= 12);
        assert_eq!(round_steps(0.0, 1.0, 4), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(round_up(1234.0), 1500.0);
        assert_eq!(round_up(7.001), 10.0);
        assert_eq!(round_up(0.3), 0.3);
        assert!(Scale::linear(1.0, 1.0).is_err() && Scale::linear(0.0, f64::NAN).is_err());
        assert!(Scale::logarithmic(0.0, 2.0).is_err() && Scale::logarithmic(1.0, 0.0).is_err());
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (2000.0, "2000"),
            (62.5, "62.5"),
            (0.025, "0.025"),
            (1.0 / 3.0, "0.3333"),
            (1.6e9, "1.6e9"),
            (-0.5, "-0.5"),
            (1e-7, "1e-7"),
            (999_999.0, "999999"),
            (312.5, "312.5"),
        ] {
            assert_eq!(short_number(value), text);
        }
        assert_eq!(rounded_number(379_666.0), "380000");
        assert_eq!(rounded_number(28.5555), "28.6");
    }
}
