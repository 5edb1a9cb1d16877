//! Transmission measured by goniophotometers in the format of IEA SHC Task 21: incident directions at
//! the centres of Tregenza's 145 zones, outgoing ones every 5° (1297).
//!
//! A text per incident direction: `#material: NAME`, `#Isym = N`, `#phi_1: 90°`, `#theta_1: 30°`, then
//! rows of `phi_2 theta_2 BTDF` (degrees, 1/sr); other lines with `#`, and `END`, say nothing. Several
//! may follow each other in one file.
//!
//! Angles are those of a frame whose z points to the **outside** and y up; seen from the room, φ runs
//! counter-clockwise from the right, as in this program's frame. `theta_1` < 90° and `phi_1` point
//! **to the source**; `theta_2` > 90° and `phi_2` are where transmitted light goes: what passes straight
//! has phi_2 = phi_1 + 180°, theta_2 = 180° − theta_1. (So LESO-EPFL's converter to Radiance.)
//!
//! | `Isym` | the sample looks the same | directions that need not be measured |
//! |---|---|---|
//! | 0 | – | none |
//! | 1 | turned by any angle | all but one of each θ |
//! | 2 | upside down | φ and −φ |
//! | 3 | left to right | φ and 180° − φ |
//! | 4 | both | all four |

use super::{Block, Bsdf, KlemsMatrix};
use crate::bins::AngleBasis;
use crate::error::{Error, Result};
use crate::limits::{GONIOPHOTOMETER_BYTES, GONIOPHOTOMETER_FILES};
use crate::text;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// The 145 zones of Tregenza around the normal.
pub fn incident_basis() -> AngleBasis {
    let theta = [0.0, 6.0, 18.0, 30.0, 42.0, 54.0, 66.0, 78.0, 90.0];
    AngleBasis::from_rings("IEA21/Tregenza", &theta, &[1, 6, 12, 18, 24, 24, 30, 30]).expect("a table of this program")
}

/// The 1297 directions every 5°.
pub fn outgoing_basis() -> AngleBasis {
    let theta: Vec<f64> = std::iter::once(0.0).chain((0..18).map(|k| 2.5 + 5.0 * f64::from(k))).chain([90.0]).collect();
    let counts: Vec<usize> = std::iter::once(1).chain(std::iter::repeat_n(72, 18)).collect();
    AngleBasis::from_rings("IEA21/5 degrees", &theta, &counts).expect("a table of this program")
}

/// One measured incident direction.
struct Measurement {
    /// Zone of the light's direction of travel.
    zone: usize,
    symmetry: u32,
    /// Per outgoing direction.
    values: Vec<f64>,
    place: (PathBuf, usize),
}

/// Whether a file looks like this format: a folder, or a text with its header.
pub fn is_iea21(path: &Path) -> bool {
    path.is_dir()
        || std::fs::File::open(path).is_ok_and(|mut file| {
            let mut head = vec![0; 4096];
            let length = std::io::Read::read(&mut file, &mut head).unwrap_or(0);
            String::from_utf8_lossy(&head[..length]).contains("#phi_1")
        })
}

/// Reads a file, or all files of a folder that have the header.
///
/// # Errors
/// File and line of what is wrong; zones that neither a measurement nor the symmetry gives.
pub fn read(path: &Path) -> Result<Bsdf> {
    let mut paths = vec![path.to_path_buf()];
    if path.is_dir() {
        let entries = std::fs::read_dir(path).map_err(|e| Error::io(path, &e))?;
        paths =
            entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_file() && is_iea21(p)).take(GONIOPHOTOMETER_FILES + 1).collect();
        paths.sort();
        if paths.is_empty() || paths.len() > GONIOPHOTOMETER_FILES {
            return Err(Error::new(format!("the folder has {} files with the header '#phi_1'", paths.len())).file(path));
        }
    }
    let mut parser = Parser::default();
    for file in &paths {
        if std::fs::metadata(file).map_err(|e| Error::io(file, &e))?.len() > GONIOPHOTOMETER_BYTES {
            return Err(Error::new(format!("more than {} MiB", GONIOPHOTOMETER_BYTES >> 20)).file(file));
        }
        parser.file(file, &text::read(file, "a table of IEA Task 21")?)?;
    }
    parser.finish().map_err(|e| e.file(path))
}

#[derive(Default)]
struct Parser {
    material: String,
    symmetry: u32,
    phi: Option<f64>,
    theta: Option<f64>,
    open: Option<Measurement>,
    done: Vec<Measurement>,
}

impl Parser {
    fn file(&mut self, path: &Path, text: &str) -> Result<()> {
        for (number, line) in text.lines().enumerate().map(|(k, l)| (k + 1, l.trim())) {
            self.line(line, (path, number)).map_err(|e| e.line(number).file(path))?;
        }
        self.close()
    }

    fn line(&mut self, line: &str, place: (&Path, usize)) -> Result<()> {
        if let Some(header) = line.strip_prefix('#') {
            let Some((key, value)) = header.split_once([':', '=']) else { return Ok(()) };
            let value = value.trim();
            match key.trim() {
                "material" => self.material = value.to_string(),
                "Isym" => {
                    self.symmetry = value.parse().ok().filter(|s| *s <= 4).ok_or_else(|| {
                        Error::new(format!("'{value}' is no symmetry"))
                            .field("#Isym")
                            .help("0 none, 1 rotation, 2 up-down, 3 left-right, 4 both")
                    })?;
                }
                "phi_1" => {
                    self.close()?;
                    self.phi = Some(angle(value, 360.0).ok_or_else(|| Error::new(format!("'{value}' is no angle")).field("#phi_1"))?);
                }
                "theta_1" => {
                    self.close()?;
                    let theta = angle(value, 89.999);
                    self.theta = Some(theta.ok_or_else(|| Error::new(format!("'{value}' is not within 0…90°")).field("#theta_1"))?);
                }
                _ => {}
            }
            return Ok(());
        }
        if line.is_empty() || line.eq_ignore_ascii_case("end") {
            return Ok(());
        }
        let numbers: Option<Vec<f64>> = text::words(line)?.iter().map(|w| w.parse().ok().filter(|v: &f64| v.is_finite())).collect();
        let Some([phi, theta, value]) = numbers.and_then(|v| <[f64; 3]>::try_from(v).ok()) else {
            let shown: String = line.chars().take(60).collect();
            return Err(Error::new(format!("'{}' is not a row of three numbers", shown.escape_debug()))
                .help("rows are: phi_2, theta_2, BTDF in 1/sr"));
        };
        if !(90.0..=180.0).contains(&theta) {
            return Err(Error::new(format!("theta_2 = {theta}° is not within 90…180°")).help("only transmission is read"));
        }
        let outgoing = outgoing_basis();
        let bin = outgoing.bin_of(direction(phi, 180.0 - theta));
        let open = match &mut self.open {
            Some(open) => open,
            None => {
                let missing = |key: &str| {
                    Error::new(format!("values come before {key}")).help("each incident direction begins with #phi_1 and #theta_1")
                };
                let (phi, theta) = (self.phi.ok_or_else(|| missing("#phi_1"))?, self.theta.ok_or_else(|| missing("#theta_1"))?);
                let zone = incident_basis().bin_of(direction(phi + 180.0, theta));
                let values = vec![f64::NAN; outgoing.len()];
                self.open.insert(Measurement { zone, symmetry: self.symmetry, values, place: (place.0.to_path_buf(), place.1) })
            }
        };
        if !open.values[bin].is_nan() {
            return Err(Error::new(format!("phi_2 = {phi}°, theta_2 = {theta}° comes twice")).help("outgoing directions are read every 5°"));
        }
        open.values[bin] = value;
        Ok(())
    }

    /// Ends the incident direction that is being read.
    fn close(&mut self) -> Result<()> {
        let Some(mut measurement) = self.open.take() else { return Ok(()) };
        let outgoing = outgoing_basis();
        // θ = 90° is not always measured: no light leaves there.
        let grazing = outgoing.rings().last().map_or(0, |r| r.first);
        let (head, tail) = measurement.values.split_at_mut(grazing);
        let missing = head.iter().filter(|v| v.is_nan()).count();
        if missing > 0 {
            return Err(Error::new(format!("{missing} of the 1297 outgoing directions (every 5°) have no value"))
                .line(measurement.place.1)
                .file(&measurement.place.0)
                .help("the file is cut off, or measured in other steps"));
        }
        tail.iter_mut().filter(|v| v.is_nan()).for_each(|v| *v = 0.0);
        self.done.push(measurement);
        Ok(())
    }

    fn finish(self) -> Result<Bsdf> {
        let (incident, outgoing) = (incident_basis(), outgoing_basis());
        let mut columns: Vec<Option<Vec<f64>>> = vec![None; incident.len()];
        // What is measured goes before what symmetry says.
        for measurement in &self.done {
            if columns[measurement.zone].replace(measurement.values.clone()).is_some() {
                return Err(Error::new(format!("{} is measured twice", zone_words(&incident, measurement.zone)))
                    .line(measurement.place.1)
                    .file(&measurement.place.0));
            }
        }
        for measurement in &self.done {
            for image in images(measurement.symmetry, &incident, measurement.zone) {
                let to = incident.bin_of(image(incident.centre(measurement.zone)));
                if columns[to].is_none() {
                    let mut column = vec![0.0; outgoing.len()];
                    for (bin, value) in measurement.values.iter().enumerate() {
                        column[outgoing.bin_of(image(outgoing.centre(bin)))] = *value;
                    }
                    columns[to] = Some(column);
                }
            }
        }
        let missing: Vec<usize> = (0..incident.len()).filter(|z| columns[*z].is_none()).collect();
        if let Some(first) = missing.first() {
            return Err(Error::new(format!(
                "{} of 145 incident directions are missing, first {}",
                missing.len(),
                zone_words(&incident, *first)
            ))
            .help("give all files of the measurement; #Isym says which ones symmetry replaces"));
        }
        let columns: Vec<Vec<f64>> = columns.into_iter().flatten().collect();
        let values = (0..outgoing.len()).flat_map(|o| columns.iter().map(move |c| c[o])).collect();
        let mut bsdf = Bsdf { name: self.material, device_type: "Other".into(), ..Bsdf::default() };
        bsdf.visible.transmission_front = Some(Block::Klems(KlemsMatrix::new(incident, outgoing, values)?));
        Ok(bsdf)
    }
}

fn angle(text: &str, most: f64) -> Option<f64> {
    text.trim_end_matches(|c: char| !c.is_ascii_digit()).parse().ok().filter(|v| (0.0..=most).contains(v))
}

/// Towards azimuth and polar angle, degrees.
fn direction(phi: f64, theta: f64) -> DVec3 {
    let (sin, cos) = theta.to_radians().sin_cos();
    let (y, x) = phi.to_radians().sin_cos();
    DVec3::new(sin * x, sin * y, cos)
}

/// Azimuth and polar angle, degrees, at which the format has a bin: the middle of its ring, 0° for the
/// first one, 90° for an outgoing last one.
fn nominal(basis: &AngleBasis, bin: usize) -> [f64; 2] {
    let (ring, position) = basis.ring_of(bin);
    let middle = (ring.theta_min + ring.theta_max) / 2.0;
    let theta = match () {
        () if ring.theta_min == 0.0 => 0.0,
        () if ring.theta_max == 90.0 && ring.theta_min > 87.0 => 90.0,
        () => middle,
    };
    [360.0 * position as f64 / ring.bins as f64, theta]
}

/// The angles of a zone as the files have them.
fn zone_words(incident: &AngleBasis, zone: usize) -> String {
    let [phi, theta] = nominal(incident, zone);
    format!("phi_1 = {}°, theta_1 = {theta}°", (phi + 180.0) % 360.0)
}

type Image = Box<dyn Fn(DVec3) -> DVec3>;

/// Where the symmetry sends the directions of a measurement.
fn images(symmetry: u32, incident: &AngleBasis, zone: usize) -> Vec<Image> {
    let mirror = |x: f64, y: f64| -> Image { Box::new(move |d: DVec3| DVec3::new(x * d.x, y * d.y, d.z)) };
    match symmetry {
        1 => {
            let (ring, _) = incident.ring_of(zone);
            let turn = |k: usize| -> Image {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / ring.bins as f64).sin_cos();
                Box::new(move |d: DVec3| DVec3::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y, d.z))
            };
            (1..ring.bins).map(turn).collect()
        }
        2 => vec![mirror(1.0, -1.0)],
        3 => vec![mirror(-1.0, 1.0)],
        4 => vec![mirror(1.0, -1.0), mirror(-1.0, 1.0), mirror(-1.0, -1.0)],
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::bsdf::resample::{to_klems, to_tree};

    /// A function without symmetry but the given one, of directions of travel.
    fn sample(symmetry: u32, out: DVec3, incident: DVec3) -> f64 {
        let lobe = (-8.0 * (out - incident).length_squared()).exp();
        let tilt = match symmetry {
            2 => 1.0 + 0.4 * out.x,
            3 => 1.0 + 0.4 * out.y,
            4 => 1.0,
            _ => 1.0 + 0.4 * out.x + 0.2 * out.y,
        };
        0.1 + lobe * tilt
    }

    /// The measurements as files, of the zones that `keep` lets through.
    fn files(symmetry: u32, keep: impl Fn(DVec3) -> bool) -> String {
        let (incident, outgoing) = (incident_basis(), outgoing_basis());
        let mut text = String::new();
        for zone in (0..145).filter(|z| keep(incident.centre(*z))) {
            let [phi, theta] = nominal(&incident, zone);
            let travel = direction(phi, theta);
            text += &format!("#material: sample\n#Isym = {symmetry}\n#phi_1: {}°\n#theta_1: {theta}°\n", (phi + 180.0) % 360.0);
            for bin in 0..outgoing.len() {
                let [phi, theta] = nominal(&outgoing, bin);
                text += &format!("{phi}\t{}\t{:.9}\n", 180.0 - theta, sample(symmetry, direction(phi, theta), travel));
            }
            text += "END\n";
        }
        text
    }

    fn parsed(text: &str) -> Result<Bsdf> {
        let mut parser = Parser::default();
        parser.file(Path::new("sample.txt"), text)?;
        parser.finish()
    }

    #[test]
    fn the_bases_have_the_directions_of_the_format() {
        let (incident, outgoing) = (incident_basis(), outgoing_basis());
        assert_eq!((incident.len(), outgoing.len()), (145, 1297));
        let total: f64 = (0..1297).map(|b| outgoing.projected_solid_angle(b)).sum();
        assert!((total - std::f64::consts::PI).abs() < 1e-12);
        let angles = |basis: &AngleBasis, bins: [usize; 4]| bins.map(|b| nominal(basis, b));
        assert_eq!(angles(&incident, [0, 1, 2, 144]), [[0.0, 0.0], [0.0, 12.0], [60.0, 12.0], [348.0, 84.0]]);
        assert_eq!(angles(&outgoing, [0, 1, 73, 1296]), [[0.0, 0.0], [0.0, 5.0], [0.0, 10.0], [355.0, 90.0]]);
        for basis in [&incident, &outgoing] {
            assert!((0..basis.len()).all(|b| basis.bin_of(direction(nominal(basis, b)[0], nominal(basis, b)[1].min(89.9))) == b));
        }
    }

    #[test]
    fn measurements_come_back_whatever_symmetry_saves() {
        let (incident, outgoing) = (incident_basis(), outgoing_basis());
        let keep: [fn(DVec3) -> bool; 5] =
            [|_| true, |d| d.x < -1e-9 && d.y.abs() < 1e-9 || d.z > 0.999, |d| d.y < 1e-9, |d| d.x < 1e-9, |d| d.x < 1e-9 && d.y < 1e-9];
        for (symmetry, keep) in (0..5).zip(keep).filter(|(s, _)| *s != 1) {
            let bsdf = parsed(&files(symmetry, keep)).unwrap();
            let m = bsdf.visible.transmission_front.as_ref().unwrap().as_klems().unwrap();
            for i in 0..145 {
                for o in (0..1297).step_by(7) {
                    let [out, travel] = [nominal(&outgoing, o), nominal(&incident, i)].map(|[phi, theta]| direction(phi, theta));
                    let wanted = sample(symmetry, out, travel);
                    assert!((m.at(o, i) - wanted).abs() < 1e-6, "Isym {symmetry}: {o} {i}: {} {wanted}", m.at(o, i));
                }
            }
        }
        // Turning: 12° and 72° of one ring; every outgoing 5° bin falls on another where 360°/bins does.
        let bsdf = parsed(&files(1, keep[1])).unwrap();
        let m = bsdf.visible.transmission_front.as_ref().unwrap().as_klems().unwrap();
        let sums = m.all_direct_hemispherical();
        assert!((sums[1] - sums[3]).abs() < 1e-9 && sums.iter().all(|s| *s > 0.0));
    }

    #[test]
    fn straight_light_stays_straight_and_resampling_keeps_the_energy() {
        let bsdf = parsed(&files(0, |_| true)).unwrap();
        let block = bsdf.visible.transmission_front.as_ref().unwrap();
        let full = AngleBasis::from(KlemsBasis::Full);
        let matrix = Block::Klems(to_klems(block, &full, &full));
        let tree = Block::Tree(to_tree(block, 4, 4, 0.0).unwrap());
        for other in [&matrix, &tree] {
            assert!((other.hemispherical() - block.hemispherical()).abs() < 1e-6);
        }
        let m = matrix.as_klems().unwrap();
        for i in [3, 20, 77] {
            let largest = (0..145).max_by(|a, b| m.at(*a, i).total_cmp(&m.at(*b, i))).unwrap();
            assert!((full.centre(largest) - full.centre(i)).length() < 0.3, "{i} {largest}");
        }
    }

    #[test]
    fn faults_are_named() {
        let text = files(0, |d| d.z > 0.999);
        let fault = |text: &str| parsed(text).unwrap_err().to_string();
        assert!(fault(&text).contains("144 of 145"));
        assert!(fault(&text.repeat(2)).contains("measured twice"));
        assert!(fault(&text.replacen("0\t175\t", "0\t175\tx", 1)).contains("sample.txt"));
        assert!(fault(&text.replacen("#theta_1: 0°", "#theta_1: 95°", 1)).contains("theta_1"));
        assert!(fault(&text.replacen("Isym = 0", "Isym = 9", 1)).contains("symmetry"));
        assert!(fault("0 180 0.1\n").contains("before #phi_1"));
        let cut = &text[..text.len() / 2];
        assert!(fault(&cut[..cut.rfind('\n').unwrap()]).contains("outgoing directions"));
        assert!(fault("").contains("145 of 145"));
    }
}
