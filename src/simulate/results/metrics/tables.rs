//! Tables of metrics: per sensor, per group, and what they were made of.

use super::samples::{Samples, SensorSample};
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::metrics::{Estimated, Metric, Occupancy, Step, Year};
use crate::scene::points::Sensor;
use crate::simulate::inputs::SensorGroup;
use crate::simulate::inputs::counting::Counting;
use glam::DVec3;
use std::path::Path;

/// Numbers of each sensor's year: a column per metric.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SensorTable {
    /// Names of the columns: `mean_lx`, `autonomy_300_lx`, …
    pub columns: Vec<String>,
    /// `[sensor][column]`.
    pub rows: Vec<Vec<Estimated>>,
}

impl SensorTable {
    /// A number of a sensor; nothing if there is none of this name.
    pub fn get(&self, sensor: usize, column: &str) -> Option<Estimated> {
        let place = self.columns.iter().position(|c| c == column)?;
        self.rows.get(sensor)?.get(place).copied()
    }
}

/// Name of ASE's hours.
pub(crate) const SUN_HOURS: &str = "sun_hours_1000_lx";

/// The table of a group.
pub(crate) fn sensor_table(samples: &Samples<'_>, sensors: &[SensorSample]) -> SensorTable {
    let mut columns: Vec<String> = samples.counting.columns.iter().map(|c| c.name.clone()).collect();
    let sunny = sensors.iter().all(|s| s.sun_hours.is_some()) && !sensors.is_empty();
    if sunny {
        columns.push(SUN_HOURS.into());
    }
    let row = |s: &SensorSample| {
        let mut row = samples.sensor(s);
        if let Some([value, less, more]) = s.sun_hours.filter(|_| sunny) {
            row.push(Estimated { value, standard_error: (((less - value).powi(2) + (more - value).powi(2)) / 2.0).sqrt() });
        }
        row
    };
    SensorTable { rows: sensors.iter().map(row).collect(), columns }
}

/// A number with three decimals, or three digits where that would leave fewer: an error is never written as 0 unless it is.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || value.abs() >= 0.1 { format!("{value:.3}") } else { format!("{value:.2e}") }
}

/// Numbers of sensors: lx as [`number`], shares with five decimals, nothing where nothing is known.
fn cell(column: &str, value: f64) -> String {
    match () {
        () if !value.is_finite() => String::new(),
        () if column.starts_with("mean_") || column.starts_with("exposure") || column.starts_with("equinox") => number(value),
        () => format!("{value:.5}"),
    }
}

/// Writes `SENSORS_annual.csv`: a sensor per line, every number followed by its standard error, and `no light` where none
/// arrives. Lengths in m.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_sensors(path: &Path, (group, dark): (&SensorGroup, &[bool]), table: &SensorTable) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        let names: String = table.columns.iter().map(|c| format!("{c},{c}_standard_error,")).collect();
        writeln!(out, "sensor,x,y,z,{names}note").map_err(fault)?;
        for (i, (sensor, row)) in group.sensors.iter().zip(&table.rows).enumerate() {
            let p = sensor.position;
            write!(out, "{},{},{},{}", i + 1, p.x, p.y, p.z).map_err(fault)?;
            for (column, e) in table.columns.iter().zip(row) {
                write!(out, ",{},{}", cell(column, e.value), cell(column, e.standard_error)).map_err(fault)?;
            }
            writeln!(out, ",{}", if dark[i] { "no light" } else { "" }).map_err(fault)?;
        }
        Ok(())
    })
}

/// The numbers of a table that [`write_sensors`] wrote; nothing if there is no such file, or it is of another kind.
pub(crate) fn read_sensors(path: &Path) -> Option<SensorTable> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next()?.strip_prefix("sensor,x,y,z,")?.strip_suffix(",note")?.split(',').collect();
    let columns: Vec<String> = names.iter().step_by(2).map(ToString::to_string).collect();
    let in_pairs = names.chunks(2).all(|pair| matches!(pair, [a, b] if **b == format!("{a}_standard_error")));
    let row = |line: &str| -> Option<Vec<Estimated>> {
        let cells: Vec<f64> = line.split(',').skip(4).take(2 * columns.len()).map(|v| v.parse().unwrap_or(f64::NAN)).collect();
        let pairs = cells.as_chunks::<2>().0;
        (pairs.len() == columns.len()).then(|| pairs.iter().map(|&[value, standard_error]| Estimated { value, standard_error }).collect())
    };
    let rows = in_pairs.then(|| lines.map(row).collect::<Option<Vec<_>>>()).flatten()?;
    Some(SensorTable { columns, rows })
}

/// Writes the table of metrics, `metrics/metrics.csv`.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_metrics(path: &Path, metrics: &[&Metric]) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        writeln!(out, "{}", Metric::COLUMNS).map_err(fault)?;
        metrics.iter().try_for_each(|m| writeln!(out, "{}", m.row())).map_err(fault)
    })
}

/// Stands for a diffuse illuminance that is not known.
const UNKNOWN: f64 = -1.0;

/// Columns of the table of hours.
const HOURS: &str = "month,day,begins,diffuse_horizontal_lx,occupied,lm83,en17037,leed_option_2";

/// Writes `metrics/hours.csv`: a line per time step, when it begins (standard time), the diffuse illuminance outdoors, and
/// which schedules count it.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_hours(path: &Path, counting: &Counting) -> Result<()> {
    let steps = counting.year.steps.len();
    let masks = [
        counting.occupied.mask(steps),
        counting.lm83.mask(steps),
        counting.daylight.as_ref().map_or(vec![false; steps], |d| d.mask(steps)),
    ];
    let diffuse = |step: usize| counting.diffuse.get(step).copied().unwrap_or(UNKNOWN);
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        writeln!(out, "{HOURS}").map_err(fault)?;
        for (i, s) in counting.year.steps.iter().enumerate() {
            let [occupied, lm83, daylight] = [0, 1, 2].map(|m| u8::from(masks[m][i]));
            let of = |o: &Occupancy| o.steps.contains(&i);
            let equinox = match &counting.equinox {
                Some([morning, _]) if of(morning) => 9,
                Some([_, afternoon]) if of(afternoon) => 15,
                _ => 0,
            };
            writeln!(out, "{},{},{:.4},{:.1},{occupied},{lm83},{daylight},{equinox}", s.month, s.day, s.begins, diffuse(i))
                .map_err(fault)?;
        }
        Ok(())
    })
}

/// What a table of hours holds.
pub(crate) struct Hours {
    /// The time steps.
    pub year: Year,
    /// Diffuse illuminance outdoors in each, lx; empty if it is not known.
    pub diffuse: Vec<f64>,
    /// Steps of LEED's option 2.
    pub equinox: Option<[Occupancy; 2]>,
}

/// Reads a table that [`write_hours`] wrote; `length` of a step in hours.
///
/// # Errors
/// No such file, or one of another kind.
pub(crate) fn read_hours(path: &Path, length: f64) -> Result<Hours> {
    let text = std::fs::read_to_string(path).map_err(|e| {
        Error::io(path, &e).help("this folder is of moments, not of a year, or of an older version: then run the project again")
    })?;
    let mut lines = text.lines();
    let wrong = |line: usize| Error::new("this is no table of hours").file(path).line(line).help("run the project again");
    if lines.next() != Some(HOURS) {
        return Err(wrong(1));
    }
    let (mut steps, mut diffuse, mut at) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for (i, line) in lines.enumerate() {
        let cells: Vec<f64> = line.split(',').map_while(|v| v.parse().ok()).collect();
        let [month, day, begins, lux, _, _, _, equinox] = cells[..] else { return Err(wrong(i + 2)) };
        steps.push(Step { month: month as u8, day: day as u8, begins });
        diffuse.push(lux);
        at.iter_mut().zip([9.0, 15.0]).filter(|(_, hour)| *hour == equinox).for_each(|(steps, _)| steps.push(i));
    }
    if diffuse.contains(&UNKNOWN) {
        diffuse.clear();
    }
    let of = |steps: Vec<usize>| Occupancy { name: "the clearest days at the equinoxes".into(), hours: steps.len() as f64 * length, steps };
    let equinox = at.iter().all(|steps| !steps.is_empty()).then(|| at.map(of));
    Ok(Hours { year: Year { steps, length }, diffuse, equinox })
}

/// Writes `metrics/SENSORS_sensors.csv`: where the sensors of a group are and face; lengths in m.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_directions(path: &Path, sensors: &[Sensor]) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        writeln!(out, "x,y,z,dx,dy,dz").map_err(fault)?;
        for s in sensors {
            let (p, d) = (s.position, s.direction);
            writeln!(out, "{},{},{},{},{},{}", p.x, p.y, p.z, d.x, d.y, d.z).map_err(fault)?;
        }
        Ok(())
    })
}

/// Positions and directions that [`write_directions`] wrote; nothing if there is no such file.
pub(crate) fn read_directions(path: &Path) -> Option<Vec<[DVec3; 2]>> {
    let text = std::fs::read_to_string(path).ok()?;
    let row = |line: &str| {
        let v: Vec<f64> = line.split(',').map_while(|v| v.parse().ok()).collect();
        (v.len() == 6).then(|| [DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5])])
    };
    text.lines().skip(1).map(row).collect()
}

/// The same of irradiance: mean, and the sum over so many hours.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_irradiance(path: &Path, (group, dark): (&SensorGroup, &[bool]), means: &[Estimated], hours: f64) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        writeln!(out, "sensor,x,y,z,mean_w_m2,mean_w_m2_standard_error,sum_kwh_m2,sum_kwh_m2_standard_error,note").map_err(fault)?;
        for (i, (sensor, mean)) in group.sensors.iter().zip(means).enumerate() {
            let (p, sum) = (sensor.position, hours / 1000.0);
            let values = [mean.value, mean.standard_error, sum * mean.value, sum * mean.standard_error].map(number).join(",");
            writeln!(out, "{},{},{},{},{values},{}", i + 1, p.x, p.y, p.z, if dark[i] { "no light" } else { "" }).map_err(fault)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("desks_annual.csv");
        let sensor = |x: f64| Sensor { position: DVec3::new(x, 1.0, 0.8), direction: DVec3::Z, line: 1 };
        let group =
            SensorGroup { name: "desks".into(), file: path.clone(), sensors: vec![sensor(0.5), sensor(1.0)], view: None, sun: None };
        let e = |value, standard_error| Estimated { value, standard_error };
        let table = SensorTable {
            columns: vec!["mean_lx".into(), "autonomy_300_lx".into()],
            rows: vec![vec![e(412.345, 1.25), e(0.51234, 0.0025)], vec![e(0.0, 0.0), e(0.0, 0.0)]],
        };
        write_sensors(&path, (&group, &[false, true]), &table).unwrap();
        let read = read_sensors(&path).unwrap();
        assert_eq!(read, table);
        assert_eq!((read.get(0, "autonomy_300_lx"), read.get(0, "udi"), read.get(2, "mean_lx")), (Some(e(0.51234, 0.0025)), None, None));
        std::fs::write(&path, "sensor,x,y,z,mean_w_m2,other,note\n1,0,0,0,1,1,\n").unwrap();
        assert_eq!(read_sensors(&path), None, "another kind of table");
        let path = folder.path().join("sensors.csv");
        write_directions(&path, &group.sensors).unwrap();
        assert_eq!(read_directions(&path).unwrap()[1], [DVec3::new(1.0, 1.0, 0.8), DVec3::Z]);
    }
}
