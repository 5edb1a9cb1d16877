//! Skies made elsewhere, as `gendaymtx` and its like write them: read, checked, and asked as if they were made here.

use super::{SkyColumn, SkyOptions, SunHour};
use crate::bins::ReinhartSky;
use crate::error::{Error, Result, Warnings};
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::units::{ILLUMINANCE_WEIGHTS, LUMINOUS_EFFICACY, SUN_DIAMETER_DEG};
use crate::weather::given::GivenSky;
use crate::weather::sun::SunPosition;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

/// Files of a sky made elsewhere.
#[derive(Debug, Clone, Copy)]
pub struct Files<'a> {
    /// S.
    pub whole: &'a Path,
    /// Sds; `Err` where the sky holds no sun.
    pub direct: Option<std::result::Result<&'a Path, NoSun>>,
    /// Suns, one a column, as of `gendaymtx -5 0.533 -d`.
    pub suns: Option<&'a Path>,
}

/// A sky that holds no sun: its direct part is nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NoSun;

/// By how much the suns' light may differ from that of the direct part, as a share of it.
const SUNS_AGREE: f64 = 0.02;

/// Reads a sky.
///
/// # Errors
/// Which file holds what it should not: rows of no sky, columns that are not the others', values below 0, several
/// suns in a step, a direct part above its whole.
pub fn read(files: Files<'_>, warnings: &mut Warnings) -> Result<GivenSky> {
    let (whole, sky) = sky_file(files.whole)?;
    let steps = whole.cols();
    let fitting = |m: &Matrix<f32>, file: &Path| match m.cols() {
        n if n == steps => Ok(()),
        n => Err(Error::new(format!("the matrix has {n} columns, the sky {steps}")).file(file).help("columns are the same time steps")),
    };
    let direct = match files.direct {
        None => None,
        Some(Err(NoSun)) => Some(Matrix::zeros(whole.rows(), steps, 3)),
        Some(Ok(file)) => {
            let (direct, own) = sky_file(file)?;
            fitting(&direct, file)?;
            if own != sky {
                return Err(Error::new(format!("the sky is MF:{}, its direct part MF:{}", sky.subdivision(), own.subdivision()))
                    .file(file)
                    .help("make both with the same -m"));
            }
            // Sums of single precision.
            if let Some(i) = (0..direct.data().len()).find(|i| direct.data()[*i] > whole.data()[*i] * 1.0001 + 1e-6) {
                let (row, column) = (i / 3 / steps, i / 3 % steps);
                return Err(Error::new(format!(
                    "the direct part is more than the sky in row {}, column {}: {} of {}",
                    row + 1,
                    column + 1,
                    direct.data()[i],
                    whole.data()[i]
                ))
                .file(file)
                .help("it is the sun's share of the same sky, as gendaymtx -d makes it beside S"));
            }
            Some(direct)
        }
    };
    let suns = match (files.suns, files.direct) {
        (None, Some(Err(NoSun))) => Some((1, vec![None; steps])),
        (None, _) => None,
        (Some(file), _) => {
            let (matrix, own) = sky_file(file)?;
            fitting(&matrix, file)?;
            Some((own.subdivision(), suns_of(&matrix, file, warnings)?))
        }
    };
    if let (Some(direct), Some((_, suns)), Some(file)) = (&direct, &suns, files.suns) {
        let disc = TAU * (1.0 - (SUN_DIAMETER_DEG / 2.0).to_radians().cos());
        let of_suns: f64 = suns.iter().flatten().map(|(_, radiance)| radiance * disc).sum();
        let patch = |row: usize| direct.row(row).chunks_exact(3).map(luminance).sum::<f64>() * sky.solid_angle(row);
        let of_patches: f64 = (1..direct.rows()).map(patch).sum();
        if (of_suns - of_patches).abs() > SUNS_AGREE * of_patches.max(of_suns) {
            warnings.push(
                Error::new(format!(
                    "the suns have {:.3} times the light of the sky's direct part, which they stand for",
                    of_suns / of_patches.max(f64::MIN_POSITIVE)
                ))
                .file(file)
                .help("make both of the same weather: gendaymtx -d, and gendaymtx -5 0.533 -d"),
            );
        }
    }
    let mut hash = blake3::Hasher::new();
    for matrix in [Some(&whole), direct.as_ref()].into_iter().flatten() {
        hash.update(bytemuck::cast_slice(matrix.data()));
    }
    hash.update(format!("{:?} {suns:?}", direct.is_some()).as_bytes());
    let hash = hash.finalize().to_hex().to_string();
    Ok(GivenSky { whole: Arc::new(whole), direct: direct.map(Arc::new), suns, hash })
}

/// A matrix whose rows are ground and patches of a sky, as RGB.
fn sky_file(file: &Path) -> Result<(Matrix<f32>, ReinhartSky)> {
    let matrix = read_matrix(file)?.matrix;
    let Some(sky) = ReinhartSky::from_bins(matrix.rows()) else {
        return Err(Error::new(format!("the matrix has {} rows, which is no sky", matrix.rows())).file(file).help(
            "rows are the ground and the patches of Reinhart's MF:1 to 6: 146, 578, 1298, 2306, 3602 or 5186; columns time steps \
             (gendaymtx -m N, or genskyvec)",
        ));
    };
    if let Some(i) = matrix.data().iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        let at = i / matrix.components();
        return Err(Error::new(format!("row {}, column {} holds {}", at / matrix.cols() + 1, at % matrix.cols() + 1, matrix.data()[i]))
            .file(file)
            .help("radiances are finite and not negative"));
    }
    let matrix = match matrix.components() {
        3 => matrix,
        1 => Matrix::from_data(matrix.rows(), matrix.cols(), 3, matrix.data().iter().flat_map(|v| [*v; 3]).collect())?,
        n => {
            return Err(Error::new(format!("the matrix has {n} components")).file(file).help("skies have one component or three (RGB)"));
        }
    };
    Ok((matrix, sky))
}

/// The grey radiance that gives as much light.
fn luminance(rgb: &[f32]) -> f64 {
    let sum: f64 = ILLUMINANCE_WEIGHTS.iter().sum();
    rgb.iter().zip(ILLUMINANCE_WEIGHTS).map(|(v, w)| f64::from(*v) * w).sum::<f64>() / sum
}

fn suns_of(matrix: &Matrix<f32>, file: &Path, warnings: &mut Warnings) -> Result<Vec<Option<(usize, f64)>>> {
    let mut suns = vec![None; matrix.cols()];
    let mut coloured = false;
    for row in 1..matrix.rows() {
        for (column, rgb) in matrix.row(row).chunks_exact(3).enumerate() {
            if rgb.iter().all(|v| *v == 0.0) {
                continue;
            }
            if suns[column].is_some() {
                return Err(Error::new(format!("column {} has more than one sun", column + 1))
                    .file(file)
                    .help("make the suns with gendaymtx -5 0.533 -d: each step's sun whole in its nearest patch"));
            }
            coloured |= (rgb[0] - rgb[1]).abs().max((rgb[1] - rgb[2]).abs()) > 0.01 * rgb[1];
            suns[column] = Some((row, luminance(rgb)));
        }
    }
    if coloured {
        warnings.push(Error::new("the suns are coloured: they are taken as white ones of the same light").file(file));
    }
    Ok(suns)
}

/// [`super::sky_columns`] of it.
pub(super) fn columns(given: &GivenSky) -> Vec<SkyColumn> {
    let whole = &given.whole;
    let mut black = vec![true; whole.cols()];
    for row in 0..whole.rows() {
        for (dark, rgb) in black.iter_mut().zip(whole.row(row).chunks_exact(3)) {
            *dark &= rgb.iter().all(|v| *v == 0.0);
        }
    }
    let disc = TAU * (1.0 - (SUN_DIAMETER_DEG / 2.0).to_radians().cos());
    let sun = |step: usize| given.suns.as_ref().and_then(|(mf, all)| Some((*mf, all[step]?)));
    let below = SunPosition { altitude: -std::f64::consts::FRAC_PI_2, azimuth: 0.0 };
    let place = |mf: usize, patch: usize| ReinhartSky::new(mf).map_or(below, |sky| position(&sky, patch));
    black
        .iter()
        .enumerate()
        .map(|(record, &black)| match sun(record) {
            Some((mf, (patch, radiance))) => SkyColumn { record, sun: place(mf, patch), direct_normal: radiance * disc, black },
            None => SkyColumn { record, sun: below, direct_normal: 0.0, black },
        })
        .collect()
}

/// Per step the sun's direct normal and the sky's diffuse horizontal illuminance, lx, as the matrices have them; of a sky
/// whose direct part is not given the sun is in the diffuse.
pub fn outdoors(given: &GivenSky) -> Vec<[f64; 2]> {
    let (whole, disc) = (&given.whole, TAU * (1.0 - (SUN_DIAMETER_DEG / 2.0).to_radians().cos()));
    let Some(sky) = ReinhartSky::from_bins(whole.rows()) else { return vec![[0.0; 2]; whole.cols()] };
    let sun = |step: usize| given.suns.as_ref().and_then(|(_, all)| all[step]).map_or(0.0, |(_, radiance)| radiance * disc);
    let mut found: Vec<[f64; 2]> = (0..whole.cols()).map(|step| [sun(step) * LUMINOUS_EFFICACY, 0.0]).collect();
    for patch in 1..whole.rows() {
        let horizontal = sky.solid_angle(patch) * sky.centre(patch).z * LUMINOUS_EFFICACY;
        let direct = given.direct.as_ref().map(|d| d.row(patch));
        for (step, out) in found.iter_mut().enumerate() {
            let at = 3 * step..3 * step + 3;
            out[1] += horizontal * (luminance(&whole.row(patch)[at.clone()]) - direct.map_or(0.0, |d| luminance(&d[at])));
        }
    }
    found
}

fn position(sky: &ReinhartSky, patch: usize) -> SunPosition {
    let direction = sky.centre(patch);
    SunPosition { altitude: direction.z.clamp(-1.0, 1.0).asin(), azimuth: direction.x.atan2(direction.y) }
}

/// [`super::sun_hours`] of it.
pub(super) fn suns(given: &GivenSky, subdivision: usize) -> Result<Vec<Option<SunHour>>> {
    let Some((own, suns)) = &given.suns else {
        return Err(Error::new("the suns of this sky are not given")
            .field("weather.sun_matrix")
            .help("add sun_matrix = \"….mtx\" (gendaymtx -5 0.533 -d -m 6), or sky_matrix_direct = \"none\" where the sky holds no sun"));
    };
    if suns.iter().any(Option::is_some) && *own != subdivision {
        return Err(Error::new(format!("the suns of this sky are those of MF:{own}, not of MF:{subdivision}")).field("method.suns"));
    }
    let sky = ReinhartSky::new(*own)?;
    Ok(suns.iter().map(|s| s.map(|(patch, radiance)| SunHour { patch, radiance, position: position(&sky, patch) })).collect())
}

/// [`super::sky_matrix`] of it.
pub(super) fn matrix(given: &GivenSky, options: &SkyOptions) -> Result<Matrix<f32>> {
    let own = ReinhartSky::from_bins(given.whole.rows()).map_or(0, |s| s.subdivision());
    if own != options.subdivision {
        return Err(Error::new(format!("the sky is MF:{own}, not MF:{}", options.subdivision)).field("method.sky_subdivision"));
    }
    match (options.sky, &given.direct) {
        (true, _) => Ok((*given.whole).clone()),
        (false, Some(direct)) => Ok((**direct).clone()),
        (false, None) => Err(Error::new("the direct part of this sky is not given")
            .field("weather.sky_matrix_direct")
            .help("add sky_matrix_direct = \"….mtx\" (the same gendaymtx with -d), or \"none\" where the sky holds no sun")),
    }
}
