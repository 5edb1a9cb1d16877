//! Which pixels of a picture are glare.

use super::geometry::{PixelGeometry, dot};
use crate::error::{Error, Result, Warnings};
use crate::image;

/// Luminance above which a pixel belongs to a glare source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Threshold {
    /// A luminance, cd/m².
    Fixed(f64),
    /// A multiple of the picture's average luminance.
    TimesAverage(f64),
    /// A multiple of the task area's average luminance.
    TimesTask(f64),
}

impl Default for Threshold {
    fn default() -> Self {
        Self::Fixed(2000.0)
    }
}

impl Threshold {
    /// The rule of evalglare's `-b`: above 100 a luminance in cd/m²; up to 100 a multiple of the
    /// task's luminance, or of the average without a task. Without a value 2000 cd/m², or 5 times
    /// the task's luminance.
    pub fn from_option(value: Option<f64>, has_task: bool) -> Self {
        match (value, has_task) {
            (None, false) => Self::default(),
            (None, true) => Self::TimesTask(5.0),
            (Some(b), _) if b > 100.0 => Self::Fixed(b),
            (Some(b), true) => Self::TimesTask(b),
            (Some(b), false) => Self::TimesAverage(b),
        }
    }

    /// The threshold of one picture, cd/m².
    pub fn luminance(self, average: f64, task: Option<f64>) -> f64 {
        match self {
            Self::Fixed(luminance) => luminance,
            Self::TimesAverage(factor) => factor * average,
            Self::TimesTask(factor) => factor * task.unwrap_or(average),
        }
    }

    pub(super) fn check(self, has_task: bool) -> Result<()> {
        let (Self::Fixed(value) | Self::TimesAverage(value) | Self::TimesTask(value)) = self;
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::new(format!("{value} is not a number above 0")).field("threshold"));
        }
        if matches!(self, Self::TimesTask(_)) && !has_task {
            return Err(Error::new("a threshold relative to the task needs a task area").field("threshold"));
        }
        Ok(())
    }
}

/// A round area of the view around a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaskArea {
    /// Column of the centre's pixel, from the left, from 0.
    pub x: f64,
    /// Row of the centre's pixel, from the bottom, from 0 (as in Radiance's pixel numbers).
    pub y: f64,
    /// Full opening angle, rad.
    pub opening_angle: f64,
}

impl TaskArea {
    pub(super) fn pixels(&self, geometry: &PixelGeometry) -> Result<Vec<u32>> {
        let (direction, cosine) = self.cap(geometry)?;
        Ok((0..geometry.pixel_count())
            .filter(|&i| geometry.is_inside(i) && dot(direction, geometry.directions[i]) >= cosine)
            .map(|i| i as u32)
            .collect())
    }

    /// The centre's direction and the cosine of half the opening angle.
    pub(super) fn cap(&self, geometry: &PixelGeometry) -> Result<([f64; 3], f64)> {
        let (w, h) = (geometry.width, geometry.height);
        let angle = self.opening_angle;
        if !(angle > 0.0 && angle <= std::f64::consts::TAU) {
            return Err(Error::new(format!("{angle} is not an opening angle between 0 and 2π rad")).field("task area"));
        }
        if !((0.0..w as f64).contains(&self.x) && (0.0..h as f64).contains(&self.y)) {
            return Err(Error::new(format!("({}, {}) is not a pixel of a {w} × {h} picture", self.x, self.y)).field("task area"));
        }
        let centre = (h - 1 - self.y as usize) * w + self.x as usize;
        if !geometry.is_inside(centre) {
            return Err(Error::new(format!("pixel ({}, {}) is outside the view", self.x, self.y)).field("task area"));
        }
        Ok((geometry.directions[centre], (angle / 2.0).cos()))
    }
}

/// Luminance of RGB radiance (W/m²sr), cd/m². Pixels that are negative or not finite become 0 and
/// are reported.
pub fn luminance(pixels: &[[f32; 3]], width: usize, warnings: &mut Warnings) -> Vec<f32> {
    let mut faulty = 0;
    let mut first = 0;
    let luminance = pixels
        .iter()
        .enumerate()
        .map(|(i, &color)| {
            let l = image::luminance(color);
            if l.is_finite() && l >= 0.0 {
                return l;
            }
            if faulty == 0 {
                first = i;
            }
            faulty += 1;
            0.0
        })
        .collect();
    if faulty > 0 {
        let (x, y) = (first % width.max(1), first / width.max(1));
        warnings.push(
            Error::new(format!("{faulty} pixels with a negative, infinite or undefined luminance are taken as black; the first is column {x}, row {y} from the top"))
                .help("look for the renderer's fault, or repair the picture, if these pixels matter"),
        );
    }
    luminance
}

/// Pixels among `searched` that are brighter than the threshold, ascending.
pub fn glare_pixels(luminance: &[f32], searched: &[bool], threshold: f64) -> Vec<u32> {
    let mut pixels = Vec::new();
    // Most pixels are dark: whole groups are passed over with one comparison.
    const GROUP: usize = 16;
    for (group, values) in luminance.chunks(GROUP).enumerate() {
        let brightest = values.iter().fold(0.0f32, |a, &b| a.max(b));
        if f64::from(brightest) > threshold {
            let first = group * GROUP;
            pixels.extend(
                values
                    .iter()
                    .enumerate()
                    .filter(|&(i, &l)| f64::from(l) > threshold && searched[first + i])
                    .map(|(i, _)| (first + i) as u32),
            );
        }
    }
    pixels
}
