//! Interpolants as files: Radiance's `.sir`, and after its end what that cannot hold.
//!
//! The first part is what `pabopto2bsdf` writes and `bsdf2ttree`, `bsdf2klems`, `bsdf2rad` and `bsdfview` read: a header
//! (`NAME=`, `SYMMETRY=`, `IO_SIDES=`, `GRIDRES=`, `FORMAT=BSDF_RBFmesh`), the lobes of each incident direction with
//! coded radii and positions, a sparse transport plan per edge. All numbers big-endian; a float is a mantissa of 4
//! bytes and an exponent of 1. Radiance stops reading there. Images in mirrors are written out (`SYMMETRY=15`).
//!
//! Then follows, little-endian: `\nLUCARNE interpolant 1\n`, the symmetry (1 byte: isotropic, quadrilateral, bilateral,
//! up, anisotropic), notes (count u32; length u32, UTF-8), distributions (count u32; incident direction 3 f64, count u32,
//! lobes of 5 f32: direction, radius, mass), vertices (count u32; distribution u32, mirrors 1 byte), edges (count u32;
//! first u32, second u32, mirrors 1 byte, per lobe of the first and then of the second its target: 4 f32: direction,
//! radius), and the BLAKE3 hash (32 bytes) of this part up to here.
//!
//! A file without the second part, as Radiance writes it, is read as well: its lobes are kept, transport is found anew.

use super::mesh::{Mesh, Vertex};
use super::{Distribution, Edge, Interpolant, Lobe, Symmetry, Target, above, fit, upper};
use crate::bsdf::Component;
use crate::bsdf::scans::direction_of;
use crate::error::{Error, Result, Warnings};
use crate::files;
use crate::limits::INTERPOLANT_LOBES;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::io::Read;
use std::path::Path;

mod write;
pub use write::{write, write_to};

const MARK: &[u8] = b"\nLUCARNE interpolant 1\n";
const SYMMETRIES: [Symmetry; 5] = [Symmetry::Isotropic, Symmetry::Quadrilateral, Symmetry::Bilateral, Symmetry::Up, Symmetry::Anisotropic];
/// Cells per side to which positions of lobes are rounded in the first part.
const GRID: usize = 4096;
/// First bytes of the data of the first part.
const MAGIC: [u8; 2] = [0x5a, 0x3c];
/// Largest file, bytes.
const LARGEST: u64 = 1 << 31;

/// Whether a file is an interpolant.
pub fn is_interpolant(path: &Path) -> bool {
    let mut head = Vec::new();
    std::fs::File::open(path).and_then(|f| f.take(1 << 14).read_to_end(&mut head)).is_ok() && is_head(&head)
}

fn is_head(head: &[u8]) -> bool {
    head.starts_with(b"#?") && head.windows(20).any(|w| w == b"\nFORMAT=BSDF_RBFmesh")
}

/// Reads an interpolant: of this program, or of Radiance's `pabopto2bsdf`.
///
/// # Errors
/// With the file: if it cannot be read, is none, is cut off or damaged.
pub fn read(path: &Path, warnings: &mut Warnings) -> Result<Interpolant> {
    let size = std::fs::metadata(path).map_err(|e| Error::io(path, &e))?.len();
    if size > LARGEST {
        return Err(Error::new(format!("more than {} MiB", LARGEST >> 20)).file(path));
    }
    read_from(&files::read(path)?, warnings).map_err(|e| e.file(path))
}

/// As [`read`], from bytes.
///
/// # Errors
/// As [`read`], without the file's name.
pub fn read_from(bytes: &[u8], warnings: &mut Warnings) -> Result<Interpolant> {
    let head = &bytes[..bytes.len().min(1 << 16)];
    if !is_head(head) {
        return Err(Error::new("this is no interpolant").help("`lucarne bsdf fit scans/*.dat -o sample.sir` makes one"));
    }
    let end = head.windows(2).position(|w| w == b"\n\n").ok_or_else(|| Error::new("the header has no end"))? + 2;
    let header = Header::parse(&String::from_utf8_lossy(&bytes[..end]))?;
    let own = bytes.windows(MARK.len()).rposition(|w| w == MARK);
    let own = own.and_then(|at| {
        let (data, hash) = bytes[at..].split_at_checked(bytes.len().checked_sub(at + 32)?)?;
        if blake3::hash(data).as_bytes() == hash { Some(&data[MARK.len()..]) } else { None }.or_else(|| {
            warnings.push(
                Error::new("the last part of the interpolant is damaged: the part for Radiance is used")
                    .help("make it again with `lucarne bsdf fit`"),
            );
            None
        })
    });
    match own {
        Some(data) => header.own(&mut Cursor { data, little: true }),
        None => header.radiance(&mut Cursor { data: &bytes[end..], little: false }, warnings),
    }
}

struct Header {
    name: String,
    manufacturer: String,
    coverage: u32,
    component: Component,
    grid: usize,
}

impl Header {
    fn parse(text: &str) -> Result<Self> {
        let value = |key: &str| text.lines().find_map(|l| l.strip_prefix(key)).map(str::trim);
        let sides: Vec<i32> = value("IO_SIDES=").unwrap_or_default().split_whitespace().filter_map(|w| w.parse().ok()).collect();
        let component = match sides[..] {
            [-1, 1] => Component::TransmissionFront,
            [1, -1] => Component::TransmissionBack,
            [-1, -1] => Component::ReflectionFront,
            [1, 1] => Component::ReflectionBack,
            _ => return Err(Error::new("the header does not say the sides").field("IO_SIDES=")),
        };
        let coverage = value("SYMMETRY=").and_then(|v| v.parse().ok()).filter(|v| *v <= 15);
        let grid = value("GRIDRES=").and_then(|v| v.parse().ok()).filter(|v| (16..=0xffff).contains(v));
        let text = |key: &str| value(key).unwrap_or_default().chars().filter(|c| !c.is_control()).take(255).collect();
        Ok(Self {
            name: text("NAME="),
            manufacturer: text("MANUFACT="),
            coverage: coverage.ok_or_else(|| Error::new("no number of 0…15").field("SYMMETRY="))?,
            component,
            grid: grid.ok_or_else(|| Error::new("no number of 16…65535").field("GRIDRES="))?,
        })
    }

    fn finish(self, symmetry: Symmetry, distributions: Vec<Distribution>, notes: Vec<String>, mesh: Mesh, edges: Vec<Edge>) -> Interpolant {
        Interpolant {
            name: self.name,
            manufacturer: self.manufacturer,
            component: self.component,
            symmetry,
            distributions,
            notes,
            mesh,
            edges,
        }
    }

    /// The part of this program.
    fn own(self, from: &mut Cursor) -> Result<Interpolant> {
        let symmetry = *SYMMETRIES.get(usize::from(from.byte()?)).ok_or_else(damaged)?;
        let notes = (0..from.count(4)?).map(|_| from.text()).collect::<Result<Vec<_>>>()?;
        let mut distributions = Vec::new();
        for _ in 0..from.count(28)? {
            let incident = DVec3::new(from.f64()?, from.f64()?, from.f64()?);
            let lobe = |from: &mut Cursor| -> Result<Lobe> {
                let t = from.target()?;
                let mass = f64::from(from.f32()?);
                if !(0.0..=10.0).contains(&mass) {
                    return Err(damaged());
                }
                Ok(Lobe { direction: t.direction, radius: t.radius, mass })
            };
            let lobes = (0..from.count(20)?).map(|_| lobe(from)).collect::<Result<Vec<_>>>()?;
            if (incident.length() - 1.0).abs() > 1e-6 || incident.z < 0.0 {
                return Err(damaged());
            }
            distributions.push(Distribution { incident, lobes });
        }
        let mut vertices = Vec::new();
        for _ in 0..from.count(5)? {
            let vertex = Vertex { distribution: from.u32()? as usize, mirror: from.byte()? };
            if vertex.distribution >= distributions.len() || vertex.mirror > 3 {
                return Err(damaged());
            }
            vertices.push(vertex);
        }
        let mut edges: Vec<Edge> = Vec::new();
        for _ in 0..from.count(9)? {
            let (first, second, mirror) = (from.u32()? as usize, from.u32()? as usize, from.byte()?);
            let (Some(a), Some(b)) = (distributions.get(first), distributions.get(second)) else { return Err(damaged()) };
            if edges.last().is_some_and(|e| (e.first, e.second, e.mirror) >= (first, second, mirror)) {
                return Err(damaged());
            }
            let forward = (0..a.lobes.len()).map(|_| from.target()).collect::<Result<Vec<_>>>()?;
            let backward = (0..b.lobes.len()).map(|_| from.target()).collect::<Result<Vec<_>>>()?;
            edges.push(Edge { first, second, mirror, forward, backward, plan: Vec::new() });
        }
        if distributions.is_empty() || vertices.is_empty() || vertices.len() > 4 * crate::limits::GONIOPHOTOMETER_FILES {
            return Err(damaged());
        }
        let incident: Vec<DVec3> = distributions.iter().map(|d| d.incident).collect();
        let mesh = if symmetry == Symmetry::Isotropic { Mesh::chain(vertices, &incident) } else { Mesh::triangles(vertices, &incident) };
        Ok(self.finish(symmetry, distributions, notes, mesh, edges))
    }

    /// The part of Radiance.
    fn radiance(self, from: &mut Cursor, warnings: &mut Warnings) -> Result<Interpolant> {
        if from.take(2)? != MAGIC {
            return Err(damaged());
        }
        let symmetry = match self.coverage {
            0 => Symmetry::Isotropic,
            1 | 2 | 4 | 8 => Symmetry::Quadrilateral,
            3 | 6 | 9 | 12 => Symmetry::Bilateral,
            15 => Symmetry::Anisotropic,
            other => return Err(Error::new(format!("{other} is no symmetry of a sample")).field("SYMMETRY=")),
        };
        let mut distributions: Vec<Distribution> = Vec::new();
        let mut all = 0;
        while from.i32()? >= 0 {
            let source = DVec3::new(from.float()?, from.float()?, from.float()?).try_normalize().ok_or_else(damaged)?;
            let mut incident = DVec3::new(-source.x, -source.y, source.z.abs());
            let turn = if symmetry == Symmetry::Isotropic { incident.y.atan2(incident.x) } else { 0.0 };
            let turned = |d: DVec3| DVec3::new(turn.cos() * d.x + turn.sin() * d.y, turn.cos() * d.y - turn.sin() * d.x, d.z);
            incident = turned(incident);
            from.float()?;
            let mut lobes = Vec::new();
            for _ in 0..from.count(13)? {
                let peak = from.float()?;
                from.take(2)?;
                let [radius, x, y] = [from.u16()?, from.u16()?, from.u16()?];
                let radius = (f64::from(radius) + 0.5) * PI / 65536.0;
                let at = |c: u16| (f64::from(c) + 0.5) / self.grid as f64;
                if usize::from(x.max(y)) >= self.grid || !(0.0..1e9).contains(&peak) {
                    return Err(damaged());
                }
                let direction = turned(direction_of(at(x), at(y)));
                lobes.push(Lobe { direction, radius, mass: peak * TAU * radius * radius * above(direction.z / radius) });
            }
            all += lobes.len();
            if all > INTERPOLANT_LOBES || distributions.len() > crate::limits::GONIOPHOTOMETER_FILES {
                return Err(crate::limits::exceeded("the interpolant has", INTERPOLANT_LOBES, "lobes"));
            }
            // Transport between pairs takes the product of their lobes.
            if lobes.len() > 1 << 13 {
                warnings.push(Error::new(format!("{} lobes of one incident direction: this takes long", lobes.len())));
            }
            if lobes.len() > 1 << 15 {
                return Err(crate::limits::exceeded("an incident direction has", 1 << 15, "lobes"));
            }
            distributions.push(Distribution { incident, lobes });
        }
        if symmetry == Symmetry::Isotropic {
            distributions.sort_by(|a, b| b.incident.z.total_cmp(&a.incident.z));
        }
        if distributions.len() < 2 {
            return Err(Error::new("fewer than two incident directions"));
        }
        let mesh = fit::mesh(&distributions, symmetry)?;
        let edges = fit::edges(&mesh, &distributions);
        Ok(self.finish(symmetry, distributions, vec!["lobes of pabopto2bsdf".into()], mesh, edges))
    }
}

fn damaged() -> Error {
    Error::new("the interpolant is cut off or damaged").help("make it again with `lucarne bsdf fit`")
}

struct Cursor<'a> {
    data: &'a [u8],
    little: bool,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        let (head, rest) = self.data.split_at_checked(n).ok_or_else(damaged)?;
        self.data = rest;
        Ok(head)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes: [u8; N] = self.take(N)?.try_into().map_err(|_| damaged())?;
        if !self.little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn byte(&mut self) -> Result<u8> {
        Ok(self.take(1)?[0])
    }

    fn u16(&mut self) -> Result<u16> {
        Ok(u16::from_le_bytes(self.bytes()?))
    }

    fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    fn i32(&mut self) -> Result<i32> {
        Ok(i32::from_le_bytes(self.bytes()?))
    }

    fn f32(&mut self) -> Result<f32> {
        Ok(f32::from_le_bytes(self.bytes()?))
    }

    fn f64(&mut self) -> Result<f64> {
        Ok(f64::from_le_bytes(self.bytes()?))
    }

    /// A count of things of at least so many bytes each, which must still be there.
    fn count(&mut self, size: usize) -> Result<usize> {
        let count = self.u32()? as usize;
        if count.saturating_mul(size) > self.data.len() { Err(damaged()) } else { Ok(count) }
    }

    fn text(&mut self) -> Result<String> {
        let length = self.count(1)?;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    fn target(&mut self) -> Result<Target> {
        let direction = DVec3::new(f64::from(self.f32()?), f64::from(self.f32()?), f64::from(self.f32()?));
        let radius = f64::from(self.f32()?);
        if !((direction.length() - 1.0).abs() < 1e-3 && direction.z > -1e-3 && radius > 1e-5 && radius < 4.0) {
            return Err(damaged());
        }
        Ok(Target { direction: upper(direction), radius })
    }

    /// Radiance's own float.
    fn float(&mut self) -> Result<f64> {
        let mantissa = self.i32()?;
        let exponent = i32::from(self.byte()? as i8);
        let whole = f64::from(mantissa) + if mantissa < 0 { -0.5 } else { 0.5 };
        Ok(if mantissa == 0 { 0.0 } else { whole / f64::from(i32::MAX) * 2f64.powi(exponent) })
    }
}
