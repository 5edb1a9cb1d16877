//! Windows: polygons and rings with `#@rfluxmtx` parameters, one [`Window`] per modifier.

use super::reader::{Reader, Sink};
use super::surfaces::{self, Geometry};
use super::syntax::{Object, ObjectType, Surface};
use super::xform::Placement;
use crate::bins::{AngleBasis, Frame, KlemsBasis};
use crate::error::{Error, Result, Warnings};
use crate::scene::{SurfaceOrigin, Window};
use glam::DVec3;
use std::path::Path;
use std::rc::Rc;

/// Polygons of one window that differ by more than this from their mean normal call for a warning.
const WARN_ANGLE_DEG: f64 = 1.0;

/// Reads the windows of a file: all polygons and rings, grouped by modifier in order of first
/// appearance. Their normals point into the room. The materials need not be defined.
///
/// `h=` of the `#@rfluxmtx` comment before a surface chooses the basis (`kf`, `kh`, `kq` or `u`;
/// without it Klems full), `u=` the up vector (without it, rfluxmtx's default).
/// A left-handed basis (`h=-kf`) gets a frame whose x axis is reversed.
///
/// # Errors
/// Anything wrong in the file; surfaces other than polygons and rings; polygons of one window that
/// face opposite ways; bases this program does not know.
pub fn read_windows(file: &Path, base: &Path, warnings: &mut Warnings) -> Result<Vec<Window>> {
    let mut sink = WindowSink::default();
    Reader::new(base).read(file, &mut sink, warnings)?;
    if let Some((_, origin_file, line)) = &sink.pending {
        warnings.push(
            Error::new("no surface follows this #@rfluxmtx comment")
                .file(origin_file)
                .line(*line)
                .help("put it before the window's polygon"),
        );
    }
    if sink.windows.is_empty() {
        return Err(Error::new("there is no window in this file")
            .file(base.join(file))
            .help("give polygons whose normals point into the room"));
    }
    sink.windows.into_iter().map(|w| w.finish(warnings)).collect()
}

#[derive(Default)]
struct WindowSink {
    pending: Option<(String, Rc<Path>, usize)>,
    windows: Vec<Group>,
}

struct Group {
    name: String,
    origin: SurfaceOrigin,
    triangles: Vec<[DVec3; 3]>,
    /// Name, line and area vector of each surface.
    surfaces: Vec<(SurfaceOrigin, DVec3)>,
    parameters: Parameters,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Parameters {
    basis: Option<AngleBasis>,
    left_handed: bool,
    up: Option<DVec3>,
}

impl Sink for WindowSink {
    fn object(&mut self, object: &Object, placement: &Placement, file: &Rc<Path>, warnings: &mut Warnings) -> Result<()> {
        let at = |e| object.at(e, file);
        let surface = match object.kind {
            ObjectType::Surface(surface) => surface,
            ObjectType::Unsupported("instance" | "mesh", help) => return Err(at(Error::new("this cannot be a window").help(help))),
            // What a window is made of is told by its BSDF, not by the material here.
            _ => return Ok(()),
        };
        if !matches!(surface, Surface::Polygon | Surface::Ring) {
            return Err(at(Error::new(format!("a {} cannot be a window", object.kind.word())).help("windows are polygons or rings")));
        }
        let Geometry::Triangles(triangles) = surfaces::geometry(surface, object, placement, file, warnings)? else {
            return Ok(());
        };
        let name = placement.modifier.as_deref().unwrap_or(&object.modifier).to_string();
        let origin = SurfaceOrigin { name: format!("{}{}", placement.prefix, object.name), file: file.to_path_buf(), line: object.line };
        let index = self.windows.iter().position(|w| w.name == name).unwrap_or_else(|| {
            self.windows.push(Group {
                name,
                origin: origin.clone(),
                triangles: Vec::new(),
                surfaces: Vec::new(),
                parameters: Parameters::default(),
            });
            self.windows.len() - 1
        });
        let group = &mut self.windows[index];
        if let Some((text, file, line)) = self.pending.take() {
            group.parameters.read(&text).map_err(|e| e.file(file).line(line).field("#@rfluxmtx"))?;
        }
        let area = triangles.iter().map(|[a, b, c]| (b - a).cross(c - a) / 2.0).sum();
        group.surfaces.push((origin, area));
        group.triangles.extend(triangles);
        Ok(())
    }

    fn alias(&mut self, _: &str, _: &str, _: &str, _: &Rc<Path>, _: usize) -> Result<()> {
        Ok(())
    }

    fn parameters(&mut self, text: &str, file: &Rc<Path>, line: usize) -> Result<()> {
        match &mut self.pending {
            Some((earlier, _, _)) => {
                earlier.push(' ');
                earlier.push_str(text);
            }
            none => *none = Some((text.to_string(), Rc::clone(file), line)),
        }
        Ok(())
    }
}

impl Group {
    fn finish(self, warnings: &mut Warnings) -> Result<Window> {
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
                    return Err(Error::new(format!("'{}' is not a parameter", super::syntax::shortened(word)))
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
            return Err(Error::new(format!("h={} is not a basis of windows", super::syntax::shortened(text)))
                .help("choose h=kf, h=kh or h=kq (Klems full, half, quarter) or h=u (one bin); r, t and sc are bases of skies"));
        }
    };
    Ok((Some(basis), left_handed))
}

fn direction(text: &str) -> Result<DVec3> {
    let bad = || {
        Error::new(format!("u={} is not a direction", super::syntax::shortened(text)))
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
