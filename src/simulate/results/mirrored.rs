//! Sunlight that stays in the sky's patches where sensors see the sky: what mirrors and gloss throw.

use super::illuminance::luminous;
use crate::error::{Error, Warnings};
use crate::matrix::Matrix;
use crate::simulate::light::Skies;

/// Share of a sensor's year from which it is said.
const WORTH_SAYING: f64 = 0.01;

/// The largest share of a sensor's year that is sunlight of patches, from C, its part that suns stand for, and the illuminance
/// of the year, lx; with the sensor's number.
fn largest_share(total: &Matrix<f32>, replaced: &Matrix<f32>, sun: &Matrix<f32>, lux: &Matrix<f32>) -> Option<(usize, f64)> {
    let year: Vec<[f64; 3]> = (0..sun.rows())
        .map(|p| sun.row(p).chunks_exact(3).fold([0.0; 3], |sum, v| std::array::from_fn(|c| sum[c] + f64::from(v[c]))))
        .collect();
    let share = |sensor: usize| {
        let all: f64 = lux.row(sensor).iter().map(|v| f64::from(*v)).sum();
        let rest: f64 = year
            .iter()
            .enumerate()
            .map(|(p, sun)| {
                let [t, r] = [total, replaced].map(|m| m.at(sensor, p));
                luminous(&std::array::from_fn::<f32, 3, _>(|c| (f64::from((t[c] - r[c]).max(0.0)) * sun[c]) as f32))
            })
            .sum();
        if all > 0.0 { rest / all } else { 0.0 }
    };
    (0..lux.rows()).map(|s| (s, share(s))).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Warns if much of a sensor's light is sunlight that suns do not stand for.
pub(crate) fn warn(total: &Matrix<f32>, replaced: &Matrix<f32>, skies: &Skies, lux: &Matrix<f32>, warnings: &mut Warnings) {
    let Some(sun) = &skies.sun else { return };
    let Some((sensor, share)) = largest_share(total, replaced, sun, lux).filter(|(_, share)| *share > WORTH_SAYING) else { return };
    warnings.push(
        Error::new(format!(
            "{:.0} % of the year's light at sensor {} is sunlight that mirrors or glossy surfaces throw: it stays in the sun's patches of \
             the sky, and hours with much of it are less certain than their standard error says",
            100.0 * share,
            sensor + 1
        ))
        .help("a finer sky (`sky_subdivision` under [method]) places it better; a larger `scale` under [quality] makes it more certain"),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sunlight_that_suns_do_not_stand_for_is_said_with_its_share() {
        let one = |rows, cols, values: &[f32]| Matrix::from_data(rows, cols, 3, values.iter().flat_map(|v| [*v; 3]).collect()).unwrap();
        let (total, replaced) = (one(2, 2, &[0.5, 0.4, 0.5, 0.4]), one(2, 2, &[0.5, 0.4, 0.5, 0.3]));
        let skies = Skies { whole: one(2, 2, &[3.0; 4]), sun: Some(one(2, 2, &[0.0, 0.0, 1.0, 2.0])) };
        // 0.1 of three.
        let lux = Matrix::from_data(2, 2, 1, vec![10.0, 20.0, (0.3 * 179.0) as f32, (0.3 * 179.0 * 4.0) as f32]).unwrap();
        let (sensor, share) = largest_share(&total, &replaced, skies.sun.as_ref().unwrap(), &lux).unwrap();
        assert!(sensor == 1 && (share - 0.2).abs() < 1e-3, "{sensor} {share}");
        let mut warnings = Warnings::new();
        warn(&total, &replaced, &skies, &lux, &mut warnings);
        assert_eq!(warnings.iter().count(), 1);
        let mut none = Warnings::new();
        warn(&total, &total, &skies, &lux, &mut none);
        assert!(none.is_empty());
    }
}
