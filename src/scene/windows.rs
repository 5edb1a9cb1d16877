//! Surfaces that together are one window.

use super::{SurfaceOrigin, Window};
use crate::bins::{AngleBasis, Frame, KlemsBasis};
use crate::error::{Error, Result, Warnings};
use glam::DVec3;

/// Surfaces of one window that differ by more than this from their mean normal call for a warning.
const WARN_ANGLE_DEG: f64 = 1.0;

/// Collects the surfaces of a window and comes to its frame and basis.
pub(super) struct WindowBuilder {
    name: String,
    origin: SurfaceOrigin,
    triangles: Vec<[DVec3; 3]>,
    /// Place and area vector of each surface.
    surfaces: Vec<(SurfaceOrigin, DVec3)>,
    parameters: Parameters,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Parameters {
    basis: Option<AngleBasis>,
    left_handed: bool,
    up: Option<DVec3>,
}

impl WindowBuilder {
    /// A window without surfaces; `origin` is where it begins.
    pub fn new(name: String, origin: SurfaceOrigin) -> Self {
        Self { name, origin, triangles: Vec::new(), surfaces: Vec::new(), parameters: Parameters::default() }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Adds a surface whose front faces the room.
    pub fn add(&mut self, origin: SurfaceOrigin, triangles: Vec<[DVec3; 3]>) {
        let area = triangles.iter().map(|[a, b, c]| (b - a).cross(c - a) / 2.0).sum();
        self.surfaces.push((origin, area));
        self.triangles.extend(triangles);
    }

    /// Takes in rfluxmtx's parameters, as `h=kf u=+Y`; later ones win.
    ///
    /// # Errors
    /// Unknown parameters and bases that no window has.
    pub fn parameters(&mut self, text: &str) -> Result<()> {
        self.parameters.read(text)
    }

    /// The window.
    ///
    /// # Errors
    /// If it has no area, its surfaces face opposite ways, or its up vector is unusable.
    pub fn finish(self, warnings: &mut Warnings) -> Result<Window> {
        let at = |e: Error, o: &SurfaceOrigin| e.file(&o.file).line(o.line).field(format!("window '{}'", self.name));
        let total: DVec3 = self.surfaces.iter().map(|(_, area)| *area).sum();
        let areas: f64 = self.surfaces.iter().map(|(_, area)| area.length()).sum();
        if areas == 0.0 {
            return Err(at(Error::new("the window has no area").help("give a polygon with an area"), &self.origin));
        }
        // Opposite faces would cancel to a normal that means nothing.
        let normal = total.try_normalize().filter(|_| total.length() > 1e-6 * areas);
        for (origin, area) in &self.surfaces {
            let cosine = match (normal, area.try_normalize()) {
                (Some(n), Some(a)) => n.dot(a),
                (None, _) => -1.0,
                (_, None) => continue,
            };
            if cosine <= 0.0 {
                let message = format!("surface '{}' faces away from the other surfaces of the window", origin.name);
                return Err(at(
                    Error::new(message)
                        .help("turn all normals into the room, or give windows of different orientation different modifiers"),
                    origin,
                ));
            }
            if cosine < WARN_ANGLE_DEG.to_radians().cos() {
                let message = format!(
                    "surface '{}' is turned by {:.1}° from the mean of its window; one normal is used for all",
                    origin.name,
                    cosine.acos().to_degrees()
                );
                warnings.push(at(Error::new(message).help("give windows of different orientation different modifiers"), origin));
            }
        }
        let normal = normal.unwrap_or(DVec3::Z);
        let frame = match self.parameters.up {
            Some(up) => Frame::new(normal, up),
            None => Frame::with_default_up(normal),
        };
        let mut frame = frame.map_err(|e| at(e, &self.origin))?;
        if self.parameters.left_handed {
            frame.x = -frame.x;
        }
        let basis = self.parameters.basis.unwrap_or_else(|| KlemsBasis::Full.into());
        Ok(Window { name: self.name, triangles: self.triangles, frame, basis, origin: self.origin })
    }
}

impl Parameters {
    /// Takes in the words of a comment; later ones win.
    fn read(&mut self, text: &str) -> Result<()> {
        for word in text.split_whitespace() {
            match word.split_once('=') {
                Some(("h", basis)) => (self.basis, self.left_handed) = hemisphere(basis)?,
                Some(("u", up)) => self.up = Some(direction(up)?),
                // Where rfluxmtx would write the matrix to; here the command line says so.
                Some(("o", _)) => {}
                _ => {
                    return Err(Error::new(format!("'{}' is not a parameter", super::rad::shortened(word)))
                        .help("write h=kf, h=kh, h=kq or h=u for the basis, u=+Y or u=0,0,1 for the up vector, without blanks around ="));
                }
            }
        }
        Ok(())
    }
}

fn hemisphere(text: &str) -> Result<(Option<AngleBasis>, bool)> {
    let left_handed = text.starts_with('-');
    let name = text.strip_prefix(['+', '-']).unwrap_or(text);
    let basis = match name {
        "kf" | "k" | "k1" => KlemsBasis::Full.into(),
        "kh" | "k2" => KlemsBasis::Half.into(),
        "kq" | "k4" => KlemsBasis::Quarter.into(),
        "u" | "1" => AngleBasis::from_rings("Uniform", &[0.0, 90.0], &[1])?,
        _ => {
            return Err(Error::new(format!("h={} is not a basis of windows", super::rad::shortened(text)))
                .help("choose h=kf, h=kh or h=kq (Klems full, half, quarter) or h=u (one bin); r, t and sc are bases of skies"));
        }
    };
    Ok((Some(basis), left_handed))
}

fn direction(text: &str) -> Result<DVec3> {
    let bad = || {
        Error::new(format!("u={} is not a direction", super::rad::shortened(text)))
            .help("write an axis as u=Z, u=+Y, u=-X or three numbers as u=0,0,1")
    };
    let (sign, axis) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    match axis {
        "X" | "x" => return Ok(DVec3::X * sign),
        "Y" | "y" => return Ok(DVec3::Y * sign),
        "Z" | "z" => return Ok(DVec3::Z * sign),
        _ => {}
    }
    let numbers: Vec<f64> =
        text.split(',').map(|t| t.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect::<Option<_>>().ok_or_else(bad)?;
    match numbers[..] {
        [x, y, z] => DVec3::new(x, y, z).try_normalize().ok_or_else(bad),
        _ => Err(bad()),
    }
}
