//! Writing interpolants.

use super::super::{Interpolant, Lobe, mirrored, transport};
use super::{GRID, MAGIC, MARK, SYMMETRIES};
use crate::bsdf::Component;
use crate::bsdf::scans::square_of;
use crate::error::{Error, Result};
use crate::files;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::io::Write;
use std::path::Path;

/// Writes an interpolant; `made_by` stands in its header.
///
/// # Errors
/// Failures of the file system with the path named.
pub fn write(path: &Path, interpolant: &Interpolant, made_by: &str) -> Result<()> {
    files::write_atomically(path, |out| write_to(out, interpolant, made_by).map_err(|e| Error::io(path, &e)))
}

/// As [`write()`], to a stream.
///
/// # Errors
/// Those of the stream.
pub fn write_to(out: &mut dyn Write, interpolant: &Interpolant, made_by: &str) -> std::io::Result<()> {
    radiance_part(out, interpolant, made_by)?;
    let mut own = MARK.to_vec();
    own.push(SYMMETRIES.iter().position(|s| *s == interpolant.symmetry).unwrap_or(0) as u8);
    let count = |own: &mut Vec<u8>, n: usize| own.extend((n as u32).to_le_bytes());
    count(&mut own, interpolant.notes.len());
    for note in &interpolant.notes {
        count(&mut own, note.len());
        own.extend(note.as_bytes());
    }
    let put = |own: &mut Vec<u8>, values: &[f64]| values.iter().for_each(|v| own.extend((*v as f32).to_le_bytes()));
    count(&mut own, interpolant.distributions.len());
    for d in &interpolant.distributions {
        d.incident.to_array().iter().for_each(|v| own.extend(v.to_le_bytes()));
        count(&mut own, d.lobes.len());
        d.lobes.iter().for_each(|l| put(&mut own, &[l.direction.x, l.direction.y, l.direction.z, l.radius, l.mass]));
    }
    count(&mut own, interpolant.mesh.vertices().len());
    for vertex in interpolant.mesh.vertices() {
        count(&mut own, vertex.distribution);
        own.push(vertex.mirror);
    }
    count(&mut own, interpolant.edges.len());
    for e in &interpolant.edges {
        count(&mut own, e.first);
        count(&mut own, e.second);
        own.push(e.mirror);
        e.forward.iter().chain(&e.backward).for_each(|t| put(&mut own, &[t.direction.x, t.direction.y, t.direction.z, t.radius]));
    }
    out.write_all(&own)?;
    out.write_all(blake3::hash(&own).as_bytes())
}

/// Radiance's float: mantissa times 2^exponent.
fn put_float(out: &mut Vec<u8>, value: f64) {
    let (mantissa, exponent) = libm::frexp(value);
    let (mantissa, exponent) = if value == 0.0 || exponent < -127 { (0, 0) } else { ((mantissa * f64::from(i32::MAX)) as i32, exponent) };
    out.extend(mantissa.to_be_bytes());
    out.push(exponent.clamp(-127, 127) as i8 as u8);
}

fn radiance_part(out: &mut dyn Write, interpolant: &Interpolant, made_by: &str) -> std::io::Result<()> {
    let plain = |text: &str| text.chars().filter(|c| !c.is_control()).take(255).collect::<String>();
    writeln!(out, "#?RADIANCE\n{}", plain(made_by))?;
    for note in &interpolant.notes {
        writeln!(out, "NOTE= {}", plain(note))?;
    }
    for (key, text) in [("NAME", &interpolant.name), ("MANUFACT", &interpolant.manufacturer)] {
        if !text.is_empty() {
            writeln!(out, "{key}={}", plain(text))?;
        }
    }
    let (from, to) = match interpolant.component {
        Component::TransmissionFront => (-1, 1),
        Component::TransmissionBack => (1, -1),
        Component::ReflectionFront => (-1, -1),
        Component::ReflectionBack => (1, 1),
    };
    let coverage = if interpolant.mesh.is_chain() { 0 } else { 15 };
    writeln!(out, "SYMMETRY={coverage}\nIO_SIDES= {from} {to}\nCOLORIMETRY=CIE-Y\nGRIDRES={GRID}\nBSDFMIN=0\nFORMAT=BSDF_RBFmesh\n")?;
    let mut data = MAGIC.to_vec();
    let vertices = interpolant.mesh.vertices();
    let volume = |l: &Lobe| TAU * l.radius * l.radius * l.amplitude();
    for (order, (vertex, direction)) in vertices.iter().zip(interpolant.mesh.directions()).enumerate() {
        let lobes = &interpolant.distributions[vertex.distribution].lobes;
        data.extend((order as i32).to_be_bytes());
        [-direction.x, -direction.y, f64::from(from) * direction.z].iter().for_each(|v| put_float(&mut data, *v));
        put_float(&mut data, lobes.iter().map(volume).sum());
        data.extend((lobes.len() as i32).to_be_bytes());
        for lobe in lobes {
            put_float(&mut data, lobe.amplitude());
            let [x, y] = square_of(mirrored(lobe.direction, vertex.mirror)).map(|c| ((c * GRID as f64) as u16).min(GRID as u16 - 1));
            let radius = (lobe.radius * 65536.0 / PI).clamp(1.0, 65535.0) as u16;
            // The colour code of pabopto2bsdf where there is no colour.
            [0xc256u16, radius, x, y].iter().for_each(|v| data.extend(v.to_be_bytes()));
        }
    }
    data.extend((-1i32).to_be_bytes());
    out.write_all(&data)?;
    for [a, b] in interpolant.mesh.edges() {
        out.write_all(&plan_bytes(interpolant, a, b))?;
    }
    out.write_all(&[0xff; 8])
}

/// The plan of an edge between two vertices: rows of shares that sum to 1, without zeros.
fn plan_bytes(interpolant: &Interpolant, a: usize, b: usize) -> Vec<u8> {
    let (va, vb) = (interpolant.mesh.vertices()[a], interpolant.mesh.vertices()[b]);
    let (la, lb) = (&interpolant.distributions[va.distribution].lobes, &interpolant.distributions[vb.distribution].lobes);
    let mirror = va.mirror ^ vb.mirror;
    let swapped = if va.distribution == vb.distribution { va.mirror > vb.mirror } else { va.distribution > vb.distribution };
    let key = (va.distribution.min(vb.distribution), va.distribution.max(vb.distribution), mirror);
    let kept = interpolant.edges.iter().find(|e| (e.first, e.second, e.mirror) == key).filter(|e| !e.plan.is_empty());
    let found = kept.map_or_else(
        || transport::edge(key.0, &interpolant.distributions[key.0].lobes, key.1, &interpolant.distributions[key.1].lobes, mirror).plan,
        |e| e.plan.clone(),
    );
    let mut rows: HashMap<u32, Vec<(u32, f32)>> = HashMap::new();
    for (i, j, mass) in found {
        let (i, j) = if swapped { (j, i) } else { (i, j) };
        rows.entry(i).or_default().push((j, mass));
    }
    let mut bytes = [(a as i32).to_be_bytes(), (b as i32).to_be_bytes()].concat();
    let mut zeros = 0usize;
    let skip = |bytes: &mut Vec<u8>, zeros: &mut usize| {
        // 255 stands for so many without a value after them.
        bytes.extend(std::iter::repeat_n(0xff, *zeros / 0xff));
        bytes.push((*zeros % 0xff) as u8);
        *zeros = 0;
    };
    for i in 0..la.len() {
        let mut row = rows.remove(&(i as u32)).unwrap_or_default();
        row.sort_unstable_by_key(|(j, _)| *j);
        let total: f32 = row.iter().map(|(_, m)| m).sum();
        row.retain(|(_, m)| *m > 1e-3 * total);
        let total: f32 = row.iter().map(|(_, m)| m).sum();
        let mut at = 0;
        for (j, mass) in row {
            zeros += j as usize - at;
            skip(&mut bytes, &mut zeros);
            put_float(&mut bytes, f64::from(mass / total));
            at = j as usize + 1;
        }
        zeros += lb.len() - at;
    }
    skip(&mut bytes, &mut zeros);
    bytes
}
