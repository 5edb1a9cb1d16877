//! Sensors and the files that list them.

use crate::error::{Error, Result};
use crate::text;
use glam::DVec3;
use std::path::Path;

/// A point that measures irradiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Position, world coordinates.
    pub position: DVec3,
    /// Normal of the measuring plane, unit length, away from the surface it may lie on.
    pub direction: DVec3,
    /// Line in its file (from 1), for messages.
    pub line: usize,
}

/// Sensors that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorGrid {
    /// Its name.
    pub name: String,
    /// Its sensors, in the order of their file; their `line` counts from 1.
    pub sensors: Vec<Sensor>,
}

impl Sensor {
    /// Whether it measures a horizontal plane from above, as the sensors of a work plane do: the
    /// direction is at most 1° from upwards.
    pub fn faces_up(&self) -> bool {
        faces_up(self.direction)
    }
}

/// Whether a direction of unit length is at most 1° from upwards; see [`Sensor::faces_up`].
pub fn faces_up(direction: DVec3) -> bool {
    // Not by the cosine: 1 − cos 1° is small beside the rounding of short directions in files.
    direction.z > 0.0 && direction.truncate().length() <= 1f64.to_radians().sin()
}

/// Reads a points file: a line `x y z dx dy dz` per sensor, as for `rtrace -I`. Empty lines and
/// lines that begin with `#` are skipped. Directions may have any length but zero. As spreadsheets
/// write them, numbers may be separated by commas or semicolons and have decimal commas
/// ([`text::words`]).
///
/// # Errors
/// A file that cannot be read, lines with more or fewer than six numbers, numbers that are not
/// finite, a direction of zero length, no sensor at all: with the line.
pub fn read_points(path: &Path) -> Result<Vec<Sensor>> {
    parse_points(&crate::files::read(path)?).map_err(|e| e.file(path))
}

/// As [`read_points`], from bytes (standard input).
///
/// # Errors
/// As [`read_points`], without the file's name.
pub fn parse_points(bytes: &[u8]) -> Result<Vec<Sensor>> {
    const HELP: &str = "a line is 'x y z dx dy dz': a position and the direction the sensor faces";
    let mut sensors = Vec::new();
    for (i, line) in text::decode(bytes, "a points file")?.lines().enumerate() {
        let fault = |message: String| Error::new(message).line(i + 1).help(HELP);
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let mut values = [0.0f64; 6];
        let mut count = 0;
        for word in &text::words(line).map_err(|e| e.line(i + 1))? {
            let value: f64 = word.parse().map_err(|_| fault(format!("'{}' is not a number", shortened(word))))?;
            if !value.is_finite() || value.abs() > 1e30 {
                return Err(fault(format!("'{}' is not a usable number", shortened(word))));
            }
            if let Some(place) = values.get_mut(count) {
                *place = value;
            }
            count += 1;
        }
        if count != 6 {
            return Err(fault(format!("{count} numbers instead of 6")));
        }
        let [x, y, z, dx, dy, dz] = values;
        let direction = DVec3::new(dx, dy, dz);
        // Scaled first, so that tiny and huge vectors neither vanish nor overflow when squared.
        let direction =
            (direction / direction.abs().max_element()).try_normalize().ok_or_else(|| fault("the direction has no length".into()))?;
        sensors.push(Sensor { position: DVec3::new(x, y, z), direction, line: i + 1 });
    }
    if sensors.is_empty() {
        return Err(Error::new("there is no sensor in this file").help(HELP));
    }
    Ok(sensors)
}

/// Enough of a word to recognise it: binary garbage can be one word of a megabyte.
fn shortened(word: &str) -> String {
    let mut text: String = word.chars().take(24).collect();
    if text.len() < word.len() {
        text.push('…');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_sensors_with_unit_directions() {
        let s = parse_points(b"# grid\n1 2 3 0 0 5\n\n -1e1\t.5 0 1e-200 0 0\r\n").unwrap();
        assert_eq!(s.len(), 2);
        assert_eq!(s[0], Sensor { position: DVec3::new(1., 2., 3.), direction: DVec3::Z, line: 2 });
        assert_eq!(s[1], Sensor { position: DVec3::new(-10., 0.5, 0.), direction: DVec3::X, line: 4 });
    }

    #[test]
    fn sensors_of_a_work_plane_face_up_and_those_of_eyes_and_ceilings_do_not() {
        let s = parse_points(b"0 0 0 0 0 2\n0 0 0 0.0001 0 1\n0 0 0 0.0174 0 1\n0 0 0 0 0.0176 1\n0 0 0 0 1 0\n0 0 0 0 0 -1\n").unwrap();
        let found: Vec<bool> = s.iter().map(Sensor::faces_up).collect();
        assert_eq!(found, [true, true, true, false, false, false]);
    }

    #[test]
    fn lists_of_spreadsheets_are_read() {
        let expected = parse_points(b"1.5 -2.25 0.8 0 0 1").unwrap();
        for line in [
            "1,5 -2,25 0,8 0 0 1",
            "1,5;-2,25;0,8;0;0;1",
            "1.5,-2.25,0.8,0,0,1",
            "1.5, -2.25, 0.8, 0, 0, 1",
            "1,500\t-2,250\t0,800\t0\t0\t1",
        ] {
            assert_eq!(parse_points(line.as_bytes()).unwrap(), expected, "{line}");
        }
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (text, words) in [
            ("1 2 3 0 0 1\n1 2 3 0 0\n", "line 2: 5 numbers instead of 6"),
            ("1 2 3 0 0 1 7\n", "line 1: 7 numbers instead of 6"),
            ("1 2 nan 0 0 1\n", "line 1: 'nan' is not a usable number"),
            ("1 2 3 0 inf 1\n", "line 1: 'inf' is not a usable number"),
            ("1 2 3 0 0 0\n", "line 1: the direction has no length"),
            ("\n1 2 three 0 0 1\n", "line 2: 'three' is not a number"),
            ("1,250 2,500 3,000 0 0 1\n", "line 1: '1,250' may mean 1.250 or 1250"),
            ("1,5 2.5 3 0 0 1\n", "line 1: 7 numbers instead of 6"),
            ("", "no sensor"),
            ("# only a comment\n", "no sensor"),
        ] {
            let message = parse_points(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(words), "{text:?}: {message}");
            assert!(message.contains("help:"));
        }
        assert!(parse_points(&[0, 159, 146, 150, 10, 255]).is_err());
        let missing = read_points(Path::new("/nowhere/points.txt")).unwrap_err().to_string();
        assert!(missing.contains("/nowhere/points.txt"));
    }
}
