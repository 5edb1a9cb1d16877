//! Sums of each month at sensors.

use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::simulate::inputs::SensorGroup;
use crate::simulate::store::Store;
use crate::weather::Weather;

/// Sums of the months and of all steps per sensor, kWh/m² of irradiances `[sensor][step]` in W/m².
fn sums(weather: &Weather, irradiance: &Matrix<f32>) -> Vec<[f64; 13]> {
    let hours = weather.steps().length;
    let of = |sensor: usize| {
        let mut sums = [0.0; 13];
        for (value, record) in irradiance.row(sensor).iter().zip(&weather.records) {
            let energy = f64::from(*value) * hours / 1000.0;
            sums[usize::from(record.month) - 1] += energy;
            sums[12] += energy;
        }
        sums
    };
    (0..irradiance.rows()).map(of).collect()
}

/// Writes `GROUP_monthly.csv`: irradiation of each month and of all time steps, kWh/m²; months without a step are empty.
///
/// # Errors
/// Failures of the file system.
pub(super) fn write(store: &Store, group: &SensorGroup, weather: &Weather, irradiance: &Matrix<f32>) -> Result<()> {
    let path = store.results_path(&format!("{}_monthly", group.name), "csv");
    let has: Vec<bool> = (1..=12).map(|m| weather.records.iter().any(|r| r.month == m)).collect();
    crate::files::write_atomically(&path, |out| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        let months: Vec<String> = (1..=12).map(|m| format!("month_{m:02}_kwh_m2")).collect();
        writeln!(out, "sensor,x,y,z,{},sum_kwh_m2", months.join(",")).map_err(fault)?;
        for (i, (sensor, sums)) in group.sensors.iter().zip(sums(weather, irradiance)).enumerate() {
            let p = sensor.position;
            let month = |m: usize| if has[m] { format!("{:.3}", sums[m]) } else { String::new() };
            let values: Vec<String> = (0..12).map(month).collect();
            writeln!(out, "{},{},{},{},{},{:.3}", i + 1, p.x, p.y, p.z, values.join(","), sums[12]).map_err(fault)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Warnings;

    #[test]
    fn months_are_summed_in_hours_whatever_the_step() {
        let head = "place x\nlatitude 0\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n";
        let lines = "1 31 23.250 0 0\n1 31 23.750 0 0\n2 1 0.250 0 0\n2 1 0.750 0 0\n";
        let weather = Weather::from_bytes(format!("{head}{lines}").as_bytes(), &mut Warnings::new()).unwrap();
        let irradiance = Matrix::from_data(1, 4, 1, vec![1000.0, 500.0, 200.0, 0.0]).unwrap();
        let found = sums(&weather, &irradiance)[0];
        assert!((found[0] - 0.75).abs() < 1e-12 && (found[1] - 0.1).abs() < 1e-9 && (found[12] - 0.85).abs() < 1e-9, "{found:?}");
        assert_eq!(found[2..12], [0.0; 10]);
    }
}
