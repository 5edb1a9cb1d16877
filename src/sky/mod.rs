//! The sky matrix S: radiance of the sky's patches and of the ground for every hour of a weather
//! file, exactly as Radiance's `gendaymtx` makes it.

pub mod cie;
pub mod given;
mod patches;
pub(crate) mod perez;

use crate::bins::ReinhartSky;
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::units::{BRIGHTNESS_WEIGHTS, LUMINOUS_EFFICACY, SUN_DIAMETER_DEG};
use crate::weather::sun::{self, SunPosition};
use crate::weather::{DewPoints, Quantity, Record, Weather};
use cie::CieMoment;
use patches::{Patches, SunPatches};
use perez::{Conditions, Distribution};
use rayon::prelude::*;
use std::f64::consts::PI;

/// What the matrix is to hold; the defaults are gendaymtx's. Options are named as there.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyOptions {
    /// `-m`: Reinhart subdivision, 1…6.
    pub subdivision: usize,
    /// Sky and ground are included (not with `-d`).
    pub sky: bool,
    /// The sun's patches are included (not with `-s`). The ground always shows the sun it receives.
    pub sun: bool,
    /// `-5`: the sun, undiluted, in the nearest patch alone, with the radiance of a disc of this
    /// full angle in degrees (for sun coefficients; 0.533).
    pub sun_disc: Option<f64>,
    /// `-c`: colour of the sky.
    pub sky_color: [f64; 3],
    /// `-g`: reflectance of the ground.
    pub ground_reflectance: [f64; 3],
    /// `-O1`: radiance of the whole solar spectrum in place of the visible (`-O0`), where
    /// 179 lm make a watt.
    pub solar_spectrum: bool,
    /// `-r`: turns the sky counter-clockwise seen from above, degrees (the scene's north is the
    /// site's this far to the east).
    pub rotation: f64,
    /// `-u`: only hours in which some of the sun is above the horizon.
    pub sun_hours_only: bool,
    /// `-A`: one column, the mean of all hours.
    pub average: bool,
    /// `-i`: length of the time steps in minutes; a step that holds sunrise or sunset gets the sun
    /// of the middle of its sunlit part. 0 leaves the sun where it is.
    pub interval_minutes: f64,
}

impl Default for SkyOptions {
    fn default() -> Self {
        Self {
            subdivision: 1,
            sky: true,
            sun: true,
            sun_disc: None,
            sky_color: [0.96, 1.004, 1.118],
            ground_reflectance: [0.2; 3],
            solar_spectrum: false,
            rotation: 0.0,
            sun_hours_only: false,
            average: false,
            interval_minutes: 0.0,
        }
    }
}

/// One column of the sky matrix (without averaging).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkyColumn {
    /// Index of the record in [`Weather::records`].
    pub record: usize,
    /// Where the sun stands, the rotation included.
    pub sun: SunPosition,
    /// Direct normal irradiance as radiance × solid angle of the sun, W/m² (visible: lux / 179),
    /// whether or not the matrix holds it.
    pub direct_normal: f64,
    /// Nothing in the column but zeros.
    pub black: bool,
}

/// The hours of the matrix: which record each column shows, where its sun stands, whether it is
/// black. Costs nothing compared with [`sky_matrix`].
///
/// # Errors
/// Options out of their range, or no hour left by `-u`.
pub fn sky_columns(weather: &Weather, options: &SkyOptions) -> Result<Vec<SkyColumn>> {
    if let Some(given) = &weather.given {
        return Ok(given::columns(given));
    }
    let hours = hours(weather, options)?;
    Ok(hours.iter().map(|h| SkyColumn { record: h.record, sun: h.sun, direct_normal: h.direct, black: h.is_black(options) }).collect())
}

/// The sun of one time step, as `gendaymtx -d -5` gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunHour {
    /// The patch nearest to it, of [`ReinhartSky`].
    pub patch: usize,
    /// Radiance of its disc of [`SkyOptions::sun_disc`] (the real sun's by default), W/m²sr; grey.
    pub radiance: f64,
    /// Where it stands, the rotation included.
    pub position: SunPosition,
}

/// The suns of all time steps: the only entries of `gendaymtx -d -5`'s matrix that are not zero.
/// Nothing for those without sun.
///
/// # Errors
/// Options out of their range, or no hour left by `-u`.
pub fn sun_hours(weather: &Weather, options: &SkyOptions) -> Result<Vec<Option<SunHour>>> {
    if let Some(given) = &weather.given {
        return given::suns(given, options.subdivision);
    }
    let options = SkyOptions { sun: true, sun_disc: options.sun_disc.or(Some(SUN_DIAMETER_DEG)), ..options.clone() };
    let patches = Patches::new(ReinhartSky::new(options.subdivision)?);
    let hours = hours(weather, &options)?;
    let sun = |hour: &Hour| {
        let (patch, radiance) = hour.sun_patches(&patches, &options).iter().next()?;
        Some(SunHour { patch, radiance, position: hour.sun })
    };
    Ok(hours.par_iter().map(sun).collect())
}

/// Diffuse horizontal illuminance outdoors of every time step, lx: what the file tells, or Perez' luminous efficacy of what
/// it tells.
///
/// # Errors
/// Weather without time steps.
pub fn diffuse_illuminance(weather: &Weather) -> Result<Vec<f64>> {
    Ok(hours(weather, &SkyOptions::default())?.iter().map(|h| h.diffuse * LUMINOUS_EFFICACY).collect())
}

/// The sky matrix `[patch][hour]` of RGB radiance, W/m²sr. Row 0 is the ground, then the patches of
/// [`ReinhartSky`]; with [`SkyOptions::average`] there is one column.
///
/// Perez' luminance is evaluated at each patch's centre and scaled so that the patches together
/// give the diffuse horizontal irradiance. The sun goes to the four patches nearest to it (to one
/// with [`SkyOptions::sun_disc`]). Matches `gendaymtx` of Radiance 6 within the rounding of its
/// single-precision sums.
///
/// # Errors
/// Options out of their range, no hour left by `-u`, or the work was stopped.
pub fn sky_matrix(weather: &Weather, options: &SkyOptions, progress: &dyn Progress) -> Result<Matrix<f32>> {
    if let Some(given) = &weather.given {
        return given::matrix(given, options);
    }
    let hours = hours(weather, options)?;
    let patches = Patches::new(ReinhartSky::new(options.subdivision)?);
    let lit: Vec<usize> = (0..hours.len()).filter(|&i| !hours[i].is_black(options)).collect();
    let mut target = if options.average {
        Target::Average { sums: vec![0.0; patches.len() * 3], hours: hours.len() }
    } else {
        Target::Columns(Matrix::zeros(patches.len(), hours.len(), 3))
    };
    // Columns are computed side by side in blocks and then turned into rows: a block of skies stays
    // in the cache, and little memory is needed besides the matrix itself.
    let mut block = vec![0f32; COLUMNS_PER_BLOCK.min(lit.len()) * patches.len()];
    for (done, columns) in lit.chunks(COLUMNS_PER_BLOCK).enumerate() {
        if progress.stop_requested() {
            return Err(cancelled());
        }
        progress.update("sky matrix", (done * COLUMNS_PER_BLOCK) as f64 / lit.len() as f64);
        let suns: Vec<SunPatches> = block
            .par_chunks_mut(patches.len())
            .zip(columns)
            .map(|(sky, &column)| {
                let hour = &hours[column];
                hour.fill_sky(&patches, options, sky);
                hour.sun_patches(&patches, options)
            })
            .collect();
        target.add(&patches, columns, &block, &suns, options);
    }
    progress.update("sky matrix", 1.0);
    Ok(target.finish(patches.len()))
}

const COLUMNS_PER_BLOCK: usize = 64;
const ROWS_PER_TASK: usize = 16;

/// Below this sum of direct and diffuse (W/m² or lx) an hour is night; below this brightness a
/// colour is black.
const DARKNESS: f64 = 1e-4;

/// An hour ready to be drawn.
struct Hour {
    record: usize,
    sun: SunPosition,
    /// Diffuse horizontal and direct normal, W/m² (visible: lux / 179).
    diffuse: f64,
    direct: f64,
    /// Angle of the model's sun from the zenith.
    zenith_angle: f64,
    distribution: Distribution,
    /// In place of Perez' distribution.
    cie: Option<CieMoment>,
}

fn check(options: &SkyOptions) -> Result<()> {
    for (name, values) in [("-c", options.sky_color), ("-g", options.ground_reflectance)] {
        if values.iter().any(|v| !v.is_finite() || *v < 0.0) {
            return Err(Error::new(format!("{values:?} is not a colour: each value must be 0 or more")).field(name));
        }
    }
    if options.sun_disc.is_some_and(|angle| !(angle > 0.0 && angle <= 180.0)) {
        return Err(Error::new("the angle of the sun's disc must lie between 0 and 180°").field("-5").help("the real sun has 0.533"));
    }
    if !options.rotation.is_finite() {
        return Err(Error::new("the rotation is not a number").field("-r"));
    }
    if !(options.interval_minutes >= 0.0 && options.interval_minutes.is_finite()) {
        return Err(Error::new("the interval must be 0 or more minutes").field("-i"));
    }
    Ok(())
}

/// Everything about the hours but their patches.
fn hours(weather: &Weather, options: &SkyOptions) -> Result<Vec<Hour>> {
    check(options)?;
    let mut dew_points = DewPoints::default();
    let mut hours = Vec::with_capacity(weather.records.len());
    for (index, record) in weather.records.iter().enumerate() {
        // Every record counts for the mean dew point, also those that `-u` leaves out.
        let mean = dew_points.mean(record);
        // Of chosen hours and parts of hours, dew points are means already.
        let dew_point = if weather.whole.is_some() { record.dew_point.unwrap_or(mean) } else { mean };
        let mut sun = sun_of(weather, record, options.interval_minutes);
        if options.sun_hours_only && !sun.is_up() {
            continue;
        }
        sun.azimuth -= (options.rotation + weather.north).to_radians();
        let mut hour = Hour::new(index, record, weather.quantity, sun, dew_point, options.solar_spectrum);
        if let Some(kind) = weather.skies.get(index) {
            // A CIE sky has no other spectrum than the visible.
            (hour.diffuse, hour.direct) = (record.diffuse / LUMINOUS_EFFICACY, record.direct / LUMINOUS_EFFICACY);
            hour.cie = Some(CieMoment::shape(*kind, sun));
        }
        hours.push(hour);
    }
    if hours.is_empty() {
        return Err(if weather.records.is_empty() {
            Error::new("the weather has no time steps")
        } else {
            Error::new("the sun is below the horizon in every time step: nothing is left").field("-u")
        });
    }
    Ok(hours)
}

fn sun_of(weather: &Weather, record: &Record, interval_minutes: f64) -> SunPosition {
    if interval_minutes <= 0.0 {
        return weather.sun(record);
    }
    let mut solar_time = record.hour + sun::solar_time_offset(record.day_of_year, weather.longitude, weather.time_zone);
    if let Some(half_day) = sun::half_day(weather.latitude, record.day_of_year) {
        let half_step = interval_minutes / 120.0;
        let (sunrise, sunset) = (12.0 - half_day, 12.0 + half_day);
        if (sunrise - solar_time).abs() <= half_step {
            solar_time = (solar_time + half_step + sunrise) / 2.0;
        } else if (sunset - solar_time).abs() < half_step {
            solar_time = (solar_time - half_step + sunset) / 2.0;
        }
    }
    sun::position_at_solar_time(weather.latitude, record.day_of_year, solar_time)
}

impl Hour {
    fn new(index: usize, record: &Record, quantity: Quantity, sun: SunPosition, dew_point: f64, solar_spectrum: bool) -> Self {
        let conditions = Conditions { zenith_angle: perez::model_zenith_angle(sun.altitude), day_of_year: record.day_of_year, dew_point };
        if record.direct + record.diffuse <= DARKNESS {
            let distribution = Distribution { a: 0.0, b: 0.0, c: 0.0, d: 0.0, e: 0.0 };
            return Self { record: index, sun, diffuse: 0.0, direct: 0.0, zenith_angle: conditions.zenith_angle, distribution, cie: None };
        }
        let state = match quantity {
            Quantity::NormalIrradiance => conditions.of_irradiance(record.diffuse, record.direct),
            Quantity::HorizontalIrradiance => {
                let normal = if sun.altitude > 1e-6 { record.direct / sun.altitude.sin() } else { record.direct };
                conditions.of_irradiance(record.diffuse, normal)
            }
            Quantity::Illuminance => conditions.of_illuminance(record.diffuse, record.direct),
        };
        let (diffuse, direct) = if solar_spectrum {
            (state.diffuse_irradiance, state.direct_irradiance)
        } else {
            (state.diffuse_illuminance / LUMINOUS_EFFICACY, state.direct_illuminance / LUMINOUS_EFFICACY)
        };
        let distribution = Distribution::new(state.clearness, state.brightness, conditions.zenith_angle);
        Self { record: index, sun, diffuse, direct, zenith_angle: conditions.zenith_angle, distribution, cie: None }
    }

    fn ground(&self) -> f64 {
        (self.diffuse + self.direct * self.sun.altitude.sin().max(0.0)) / PI
    }

    fn shows_sky(&self, options: &SkyOptions) -> bool {
        options.sky && self.diffuse > 0.0 && brightness(options.sky_color) > DARKNESS
    }

    fn shows_sun(&self, options: &SkyOptions) -> bool {
        options.sun && self.direct * LUMINOUS_EFFICACY > DARKNESS
    }

    fn is_black(&self, options: &SkyOptions) -> bool {
        let ground = options.sky && self.ground() > 0.0 && options.ground_reflectance.iter().any(|g| *g > 0.0);
        !(ground || self.shows_sky(options) || self.shows_sun(options))
    }

    /// Uncoloured radiance of the ground (before reflection) and of every patch, without the sun.
    fn fill_sky(&self, patches: &Patches, options: &SkyOptions, sky: &mut [f32]) {
        sky[0] = if options.sky { self.ground() as f32 } else { 0.0 };
        let sky = &mut sky[1..];
        if !self.shows_sky(options) {
            sky.fill(0.0);
            return;
        }
        // The model's sun is kept off zenith and horizon, so it is not where the real one is.
        let model_sun = SunPosition { altitude: std::f64::consts::FRAC_PI_2 - self.zenith_angle, azimuth: self.sun.azimuth };
        let horizontal = match &self.cie {
            Some(moment) => patches.luminance_of(moment, sky),
            None => patches.relative_luminance(&self.distribution, model_sun.direction(), sky),
        };
        if horizontal <= 1e-6 {
            sky.fill((self.diffuse / PI) as f32);
        } else {
            let scale = self.diffuse / horizontal;
            sky.iter_mut().for_each(|l| *l = (f64::from(*l) * scale) as f32);
        }
    }

    /// Radiance that the sun adds to its patches.
    fn sun_patches(&self, patches: &Patches, options: &SkyOptions) -> SunPatches {
        if self.shows_sun(options) { patches.sun(self.sun.direction(), self.direct, options.sun_disc) } else { SunPatches::default() }
    }
}

fn brightness(color: [f64; 3]) -> f64 {
    color.iter().zip(BRIGHTNESS_WEIGHTS).map(|(c, w)| c * w).sum()
}

/// Where blocks of columns go.
enum Target {
    Columns(Matrix<f32>),
    Average { sums: Vec<f64>, hours: usize },
}

impl Target {
    /// Colours a block of skies (`[column][patch]`) and adds the suns.
    fn add(&mut self, patches: &Patches, columns: &[usize], block: &[f32], suns: &[SunPatches], options: &SkyOptions) {
        let n = patches.len();
        let color = |row: usize| if row == 0 { options.ground_reflectance } else { options.sky_color }.map(|c| c as f32);
        match self {
            Target::Columns(matrix) => {
                let row_length = matrix.cols() * 3;
                matrix.data_mut().par_chunks_mut(row_length * ROWS_PER_TASK).enumerate().for_each(|(task, rows)| {
                    let first = task * ROWS_PER_TASK;
                    for (sky, &column) in block.chunks(n).zip(columns) {
                        for (row, out) in rows.chunks_mut(row_length).enumerate() {
                            let radiance = sky[first + row];
                            for (o, c) in out[column * 3..column * 3 + 3].iter_mut().zip(color(first + row)) {
                                *o = radiance * c;
                            }
                        }
                    }
                });
                for (sun, &column) in suns.iter().zip(columns) {
                    for (patch, radiance) in sun.iter() {
                        matrix.at_mut(patch, column).iter_mut().for_each(|v| *v += radiance as f32);
                    }
                }
            }
            Target::Average { sums, .. } => {
                for (sky, _) in block.chunks(n).zip(columns) {
                    for (row, (sum, radiance)) in sums.chunks_mut(3).zip(sky).enumerate() {
                        sum.iter_mut().zip(color(row)).for_each(|(s, c)| *s += f64::from(*radiance * c));
                    }
                }
                for (patch, radiance) in suns.iter().flat_map(SunPatches::iter) {
                    sums[patch * 3..patch * 3 + 3].iter_mut().for_each(|s| *s += radiance);
                }
            }
        }
    }

    fn finish(self, rows: usize) -> Matrix<f32> {
        match self {
            Target::Columns(matrix) => matrix,
            Target::Average { sums, hours } => {
                let data = sums.iter().map(|s| (s / hours as f64) as f32).collect();
                Matrix::from_data(rows, 1, 3, data).expect("one column of RGB per patch")
            }
        }
    }
}

#[cfg(test)]
mod tests;
