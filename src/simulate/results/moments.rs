//! The table of named moments: how bright a group of sensors is under each.

use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::simulate::inputs::SensorGroup;
use crate::simulate::store::Store;
use crate::weather::{CieSky, Weather};

/// Writes `GROUP_moments.csv` where moments have names: mean, least and most illuminance of each, and under an overcast
/// sky the mean daylight factor, in percent of the horizontal illuminance outdoors.
///
/// # Errors
/// Failures of the file system.
pub(super) fn write(store: &Store, group: &SensorGroup, weather: &Weather, lux: &Matrix<f32>) -> Result<()> {
    if weather.names.is_empty() {
        return Ok(());
    }
    let path = store.results_path(&format!("{}_moments", group.name), "csv");
    crate::files::write_atomically(&path, |out| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        writeln!(out, "moment,sky,month,day,hour,mean_lx,least_lx,most_lx,mean_daylight_factor_percent").map_err(fault)?;
        for (step, (name, record)) in weather.names.iter().zip(&weather.records).enumerate() {
            let values = || (0..lux.rows()).map(|sensor| f64::from(lux.at(sensor, step)[0]));
            let mean = values().sum::<f64>() / lux.rows().max(1) as f64;
            let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
            let sky = weather.skies[step];
            let factor = if sky == CieSky::Overcast { format!("{:.3}", 100.0 * mean / record.diffuse) } else { String::new() };
            let (month, day, hour) = (record.month, record.day, record.hour);
            writeln!(out, "{name},cie {},{month},{day},{hour:.3},{mean:.1},{least:.1},{most:.1},{factor}", sky.name()).map_err(fault)?;
        }
        Ok(())
    })
}
