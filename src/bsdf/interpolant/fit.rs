//! From measurements to an interpolant: lobes, mesh, transport.

use super::lobes::lobes;
use super::mesh::{Mesh, Vertex};
use super::{Distribution, Edge, Interpolant, Lobe, MIRROR_X, MIRROR_Y, Symmetry, mirrored, transport, upper};
use crate::bsdf::scans::{Grid, SIDE, Scan, Scans, angle};
use crate::error::{Error, Result, Warnings};
use glam::DVec3;
use rayon::prelude::*;

/// How measurements are fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitOptions {
    /// In what the sample looks the same; by the incident directions that were measured, if absent.
    pub symmetry: Option<Symmetry>,
    /// Samples that lie on a plane to within this share of their mean are one lobe.
    pub tolerance: f64,
    /// Most lobes of an incident direction.
    pub lobes: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { symmetry: None, tolerance: 0.02, lobes: 300 }
    }
}

/// Polar angles below this are normal incidence, degrees; twins of mirrors are as close.
const NORMAL: f64 = 1.0;

/// Makes the interpolant of a sample's measurements.
///
/// # Errors
/// If the incident directions do not fit the symmetry, or do not span a mesh.
pub fn fit(scans: &Scans, options: &FitOptions, warnings: &mut Warnings) -> Result<Interpolant> {
    let incident: Vec<DVec3> = scans.scans.iter().map(|s| s.incident).collect();
    let symmetry = symmetry_of(&incident, options.symmetry)?;
    let mut distributions: Vec<Distribution> = scans
        .scans
        .par_iter()
        .map(|scan| {
            let turn = if symmetry == Symmetry::Isotropic { scan.incident.y.atan2(scan.incident.x) } else { 0.0 };
            let turned = |d: DVec3| DVec3::new(turn.cos() * d.x + turn.sin() * d.y, turn.cos() * d.y - turn.sin() * d.x, d.z);
            let mut lobes = lobes(&scan.grid, scan.noise(), options.tolerance, options.lobes);
            lobes.iter_mut().for_each(|l| l.direction = turned(l.direction));
            Distribution { incident: if scan.theta() < NORMAL { DVec3::Z } else { turned(scan.incident) }, lobes }
        })
        .collect();
    if let Some(dark) = distributions.iter().position(|d| d.lobes.is_empty()) {
        return Err(Error::new("the samples add up to no light").file(&scans.scans[dark].files[0]));
    }
    for (scan, d) in scans.scans.iter().zip(&distributions) {
        let share: f64 = d.lobes.iter().map(|l| l.mass).sum();
        if share > 1.0 {
            warnings.push(
                Error::new(format!("{:.1} % of the light is scattered for incident θ {:.1}°", 100.0 * share, scan.theta()))
                    .file(&scan.files[0])
                    .help("more light leaves than arrives: check the calibration; the values are kept"),
            );
        }
    }
    if symmetry == Symmetry::Isotropic {
        distributions.sort_by(|a, b| b.incident.z.total_cmp(&a.incident.z));
        add_normal(&mut distributions);
    }
    let mesh = mesh(&distributions, symmetry)?;
    let notes = notes(&scans.scans, warnings, &mesh);
    let edges = edges(&mesh, &distributions);
    Ok(Interpolant {
        name: scans.name.clone(),
        manufacturer: String::new(),
        component: scans.component,
        symmetry,
        distributions,
        notes,
        mesh,
        edges,
    })
}

/// Transport along all edges of a mesh, images of the same edge once.
pub(super) fn edges(mesh: &Mesh, distributions: &[Distribution]) -> Vec<Edge> {
    let mut keys: Vec<(usize, usize, u8)> = mesh
        .edges()
        .into_iter()
        .map(|[a, b]| {
            let (a, b) = (mesh.vertices()[a], mesh.vertices()[b]);
            (a.distribution.min(b.distribution), a.distribution.max(b.distribution), a.mirror ^ b.mirror)
        })
        .collect();
    keys.sort_unstable();
    keys.dedup();
    keys.into_par_iter().map(|(a, b, mirror)| transport::edge(a, &distributions[a].lobes, b, &distributions[b].lobes, mirror)).collect()
}

/// Normal incidence, where it was not measured: between the least polar angle and its image on the other side.
fn add_normal(distributions: &mut Vec<Distribution>) {
    let Some(first) = distributions.first().filter(|d| d.incident.z < 1.0) else { return };
    let edge = transport::edge(0, &first.lobes, 0, &first.lobes, MIRROR_X | MIRROR_Y);
    let lobes = first.lobes.iter().zip(&edge.forward).flat_map(|(l, t)| {
        let half = Lobe {
            direction: upper(l.direction + t.direction),
            radius: (0.5 * (l.radius.powi(2) + t.radius.powi(2))).sqrt(),
            mass: 0.5 * l.mass,
        };
        [half, Lobe { direction: mirrored(half.direction, MIRROR_X | MIRROR_Y), ..half }]
    });
    let normal = Distribution { incident: DVec3::Z, lobes: lobes.collect() };
    distributions.insert(0, normal);
}

/// The symmetry that incident directions (of travel) stand for, or that was asked for, if they do.
fn symmetry_of(incident: &[DVec3], asked: Option<Symmetry>) -> Result<Symmetry> {
    let oblique: Vec<DVec3> = incident.iter().copied().filter(|d| angle(*d, DVec3::Z) >= NORMAL).collect();
    let azimuth = |d: &DVec3| d.y.atan2(d.x);
    let one_plane = oblique.iter().all(|d| (azimuth(d) - azimuth(&oblique[0])).cos() > NORMAL.to_radians().cos());
    let [x, y] = halves(&oblique);
    let covered = match () {
        () if one_plane => Symmetry::Isotropic,
        () if x && y => Symmetry::Quadrilateral,
        () if x || y => Symmetry::Bilateral,
        () => Symmetry::Anisotropic,
    };
    let fits = match asked {
        None => true,
        Some(Symmetry::Up) => covered == Symmetry::Bilateral || covered == Symmetry::Anisotropic,
        Some(wanted) => wanted == covered,
    };
    if fits {
        return Ok(asked.unwrap_or(covered));
    }
    let wanted = asked.map_or("", Symmetry::name);
    Err(Error::new(format!("the incident directions are those of a sample of {} symmetry, not {wanted}", covered.name())).help(
        "one plane of incidence is isotropic, one quarter quadrilateral, one half bilateral (or up), all around anisotropic: \
         leave out the symmetry or files",
    ))
}

/// Whether directions lie on one side of x = 0, and of y = 0.
fn halves(directions: &[DVec3]) -> [bool; 2] {
    const ON: f64 = 0.02;
    let one_sided = |c: fn(&DVec3) -> f64| directions.iter().all(|d| c(d) <= ON) || directions.iter().all(|d| c(d) >= -ON);
    [one_sided(|d| d.x), one_sided(|d| d.y)]
}

/// The mesh over what was measured and its images.
pub(super) fn mesh(distributions: &[Distribution], symmetry: Symmetry) -> Result<Mesh> {
    let incident: Vec<DVec3> = distributions.iter().map(|d| d.incident).collect();
    let own: Vec<Vertex> = (0..incident.len()).map(|distribution| Vertex { distribution, mirror: 0 }).collect();
    if symmetry == Symmetry::Isotropic {
        return Ok(Mesh::chain(own, &incident));
    }
    let oblique: Vec<DVec3> = incident.iter().copied().filter(|d| angle(*d, DVec3::Z) >= NORMAL).collect();
    let mirrors: Vec<u8> = match symmetry {
        Symmetry::Quadrilateral => vec![MIRROR_X, MIRROR_Y, MIRROR_X | MIRROR_Y],
        Symmetry::Bilateral => vec![if halves(&oblique)[1] { MIRROR_Y } else { MIRROR_X }],
        Symmetry::Up => vec![MIRROR_X | MIRROR_Y],
        _ => Vec::new(),
    };
    let mut vertices = own;
    for mirror in mirrors {
        for (distribution, d) in incident.iter().enumerate() {
            let image = mirrored(*d, mirror);
            if vertices.iter().all(|v| angle(mirrored(incident[v.distribution], v.mirror), image) >= NORMAL) {
                vertices.push(Vertex { distribution, mirror });
            }
        }
    }
    let mesh = Mesh::triangles(vertices, &incident);
    if mesh.edges().is_empty() {
        return Err(Error::new("the incident directions do not span a mesh")
            .help("measure at least three that do not lie in one plane, or give isotropic samples one azimuth only"));
    }
    Ok(mesh)
}

/// What is worth knowing of the measurements, for the file.
fn notes(scans: &[Scan], warnings: &mut Warnings, mesh: &Mesh) -> Vec<String> {
    let samples: usize = scans.iter().map(|s| s.samples).sum();
    let negative: usize = scans.iter().map(|s| s.negative.0).sum();
    let noise = scans.iter().map(Scan::noise).fold(0.0, f64::max);
    let last = mesh.directions().iter().map(|d| angle(*d, DVec3::Z)).fold(0.0, f64::max);
    let widest = mesh.edges().iter().map(|[a, b]| angle(mesh.directions()[*a], mesh.directions()[*b])).fold(0.0, f64::max);
    if last < 59.5 {
        warnings.push(
            Error::new(format!("no incident direction beyond θ = {last:.0}° was measured"))
                .help("beyond it the distribution of the nearest one is used: scan up to 75° or more"),
        );
    }
    let sides: Vec<f64> = scans.iter().map(|s| unmeasured(&s.grid)).collect();
    if let Some((scan, share)) = scans.iter().zip(&sides).find(|(_, share)| **share > 0.3) {
        warnings.push(
            Error::new(format!("{:.0} % of the hemisphere lies further than 8° from any sample", 100.0 * share))
                .file(&scan.files[0])
                .help("its values are guessed from the nearest samples: scan the whole hemisphere"),
        );
    }
    let missing = sides.iter().copied().fold(0.0, f64::max);
    vec![
        format!(
            "{} incident directions, {samples} samples; widest step between incident directions {widest:.1} deg, last theta {last:.1} deg",
            scans.len()
        ),
        format!("{negative} negative samples kept in averages; noise (standard deviation) {noise:.2e}/sr"),
        format!("largest unmeasured part of an outgoing hemisphere {:.1} %", 100.0 * missing),
    ]
}

/// Share of the hemisphere in squares of about 10° without a sample.
fn unmeasured(grid: &Grid) -> f64 {
    const BLOCK: usize = 16;
    const BLOCKS: usize = SIDE / BLOCK;
    let mut met = [false; BLOCKS * BLOCKS];
    for (cell, _) in grid.sorted() {
        let cell = cell as usize;
        met[cell / SIDE / BLOCK * BLOCKS + cell % SIDE / BLOCK] = true;
    }
    met.iter().filter(|m| !**m).count() as f64 / met.len() as f64
}
