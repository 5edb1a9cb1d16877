//! Rows of a text table of angular values.

use super::{Sample, check};
use crate::error::{Error, Result};
use crate::text;

/// Samples of light from the outside and from the room, each by ascending angle. Without
/// `reflects` the columns Rs and Rd count for nothing, and may be missing.
pub(super) fn rows(text: &str, reflects: bool) -> Result<[Vec<Sample>; 2]> {
    let (mut front, mut back) = (Vec::new(), Vec::new());
    let mut columns = None;
    for (number, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let number = number + 1;
        let line = line.split('#').next().unwrap_or_default();
        let words = text::words(line).map_err(|e| e.line(number))?;
        if words.is_empty() {
            continue;
        }
        if columns.is_none() && words.iter().all(|w| w.parse::<f64>().is_err()) {
            columns = Some(Columns::named(line, reflects).map_err(|e| e.line(number))?);
            continue;
        }
        let without_reflectance = !reflects && words.len() == 3;
        let columns = *columns.get_or_insert(if without_reflectance { Columns::TRANSMITTANCE } else { Columns::USUAL });
        let parsed: Option<Vec<f64>> = words.iter().map(|w| w.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect();
        let Some(values) = parsed.filter(|v| v.len() == columns.count) else {
            return Err(Error::new(format!("'{}' is not a row of {} numbers", line.trim(), columns.count))
                .line(number)
                .help("rows are: angle of incidence in degrees, Ts, Td, Rs, Rd (specular and diffuse transmittance and reflectance)"));
        };
        let [theta, ts, td, rs, rd] = columns.places.map(|place| values[place]);
        let [rs, rd] = if reflects { [rs, rd] } else { [0.0; 2] };
        let sample = |theta| Sample {
            theta,
            specular_transmittance: ts,
            diffuse_transmittance: td,
            specular_reflectance: rs,
            diffuse_reflectance: rd,
        };
        check(&sample(theta)).map_err(|e| e.line(number))?;
        if !(0.0..=180.0).contains(&theta) {
            return Err(Error::new(format!("an angle of {theta}° is outside 0…180°")).line(number));
        }
        if theta <= 90.0 {
            front.push(sample(theta));
        }
        if theta >= 90.0 {
            back.push(sample(180.0 - theta));
        }
    }
    if back.len() < 2 {
        back.clear();
    }
    back.reverse();
    Ok([front, back])
}

/// Where the columns of a table stand.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Columns {
    count: usize,
    /// Of θ, Ts, Td, Rs, Rd.
    places: [usize; 5],
}

impl Columns {
    const USUAL: Self = Self { count: 5, places: [0, 1, 2, 3, 4] };
    /// θ, Ts, Td alone: two columns stand for those that count for nothing.
    const TRANSMITTANCE: Self = Self { count: 3, places: [0, 1, 2, 1, 2] };

    /// From a header, whose fields stand between commas, semicolons or tabs, else between spaces.
    /// The angle is the first field that is not one of the four names.
    fn named(header: &str, reflects: bool) -> Result<Self> {
        let plain = |field: &str| -> String {
            let name = field.split(['(', '[']).next().unwrap_or_default();
            name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase()
        };
        let mut fields: Vec<String> = match [',', ';', '\t'].into_iter().find(|c| header.contains(*c)) {
            Some(separator) => header.split(separator).map(plain).collect(),
            None => header.split_whitespace().map(plain).collect(),
        };
        // A separator at the end of every line.
        fields.truncate(fields.iter().rposition(|f| !f.is_empty()).map_or(0, |last| last + 1));
        let names = ["ts", "td", "rs", "rd"];
        let found = names.map(|name| fields.iter().position(|f| f == name));
        let bad = |message: String| Error::new(message).help("name the columns Ts, Td, Rs and Rd, or leave the header out");
        if let Some(twice) = names.into_iter().find(|name| fields.iter().filter(|f| f == name).count() > 1) {
            return Err(bad(format!("the header '{}' names {twice} twice", header.trim())));
        }
        let found = match found {
            [Some(ts), Some(td), rs, rd] if !reflects => [Some(ts), Some(td), rs.or(Some(ts)), rd.or(Some(td))],
            found => found,
        };
        match found {
            [None, None, None, None] => Ok(Self::USUAL),
            [Some(ts), Some(td), Some(rs), Some(rd)] => {
                let angle = fields.iter().position(|f| !names.contains(&f.as_str()));
                // Without a field of its own the angle stands before the others.
                let shift = usize::from(angle.is_none());
                let places = [angle.unwrap_or(0), ts + shift, td + shift, rs + shift, rd + shift];
                Ok(Self { count: fields.len() + shift, places })
            }
            _ => Err(bad(format!("the header '{}' names some of the columns only", header.trim()))),
        }
    }
}
