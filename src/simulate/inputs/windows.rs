//! Windows with their transmission, their states, and what the sun is traced through.

use super::division::Division;
use super::filling::{Filled, checked, in_colour};
use super::import::Imported;
use super::shade::Shade;
use crate::bsdf::{self, Component};
use crate::error::{Error, Result, Warnings};
use crate::kernels::sun_matrix::pane::PaneBsdf;
use crate::matrix::Matrix;
use crate::scene::points::Sensor;
use crate::scene::{self, Pane, Scene, Window};
use crate::simulate::project::{Project, WindowSection};
use glam::DVec3;
use std::path::Path;

/// A window with its transmission.
#[derive(Debug, Clone)]
pub struct ProjectWindow {
    /// Name in results: the section's, with the modifier's where the section has several.
    pub name: String,
    /// Geometry and basis.
    pub window: Window,
    /// The parts over each of which V and D are averaged, of the same frame and basis; the window itself if it is
    /// not divided.
    pub parts: Vec<Window>,
    /// Why these.
    pub division: Division,
    /// T `[outgoing bin][incident bin]`, RGB; includes the projected solid angle of the incident
    /// bin (as dctimestep applies it).
    pub transmission: Matrix<f64>,
    /// What it is made of, for people.
    pub made_of: String,
    /// The clear pane that it is, if it is one; the sun is traced through it (`shade`).
    pub glass: Option<Pane>,
    /// What the sun is traced through, if by anything but the transmission.
    pub shade: Option<Shade>,
    /// Scattering data that the sun is traced through in place of a shade.
    pub pane: Option<PaneBsdf>,
    /// T of all states of the façade, with their names; empty if the window has one state.
    pub states: Vec<(String, Matrix<f64>)>,
    /// D and Dd made elsewhere.
    pub daylight: Option<Imported>,
}

impl ProjectWindow {
    /// Bins of all its parts: columns of V and rows of D.
    pub fn bins(&self) -> usize {
        self.parts.len() * self.window.basis.len()
    }

    /// Whether its sun is traced.
    pub fn is_sunny(&self) -> bool {
        self.shade.is_some() || self.pane.is_some()
    }
}

/// The surfaces of a window section; each is a window of its own.
///
/// # Errors
/// What is wrong in which file.
pub(crate) fn read_surfaces(project: &Project, section: &WindowSection, warnings: &mut Warnings) -> Result<Vec<Window>> {
    if let Some(window) = &section.found {
        return Ok(vec![window.clone()]);
    }
    let base = project.folder();
    let mut surfaces = scene::read_windows(section.surface.strip_prefix(base).unwrap_or(&section.surface), base, warnings)?;
    // Of several windows in one file, the one that has the section's name is meant.
    if surfaces.iter().any(|w| w.name == section.name) {
        surfaces.retain(|w| w.name == section.name);
    }
    Ok(surfaces)
}

/// All windows of a section with what fills them; `patches` are those of the sky, `scene` has their panes still.
pub(super) fn read_windows(
    project: &Project,
    section: &WindowSection,
    patches: usize,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<Vec<ProjectWindow>> {
    let surfaces = read_surfaces(project, section, warnings)?;
    let named_pane = section.tensor_tree.as_ref().map(|file| read_pane(file, warnings)).transpose()?;
    let states = section.states.iter().map(|path| read_state(path, warnings)).collect::<Result<Vec<_>>>()?;
    let single = surfaces.len() == 1;
    if let (Some(_), [first, second, ..]) = (&section.daylight, &surfaces[..]) {
        return Err(Error::new(format!(
            "a matrix 'daylight' belongs to one window, but this file holds several: '{}', '{}'",
            first.name, second.name
        ))
        .file(&section.surface)
        .help("give each its own [[window]] with its own matrix"));
    }
    if let (Some(_), [first, second, ..]) = (&section.shade, &surfaces[..]) {
        return Err(Error::new(format!("a shade belongs to one window, but this file holds several: '{}', '{}'", first.name, second.name))
            .file(&section.surface)
            .help("give each its own [[window]] with its own shade"));
    }
    let mut windows = Vec::new();
    let mut read: Option<Filled> = None;
    for window in surfaces {
        let bins = window.basis.len();
        let filled = match read.take() {
            Some(data @ Filled::Data(..)) => data,
            _ => Filled::read(project, section, &window, scene, warnings)?,
        };
        let transmission = filled.transmission(&window.basis)?;
        let own_pane = filled.pane(project, section, warnings)?;
        if (transmission.rows(), transmission.cols()) != (bins, bins) {
            return Err(Error::new(format!(
                "the window is divided by the basis {} ({bins} bins), its BSDF {} has {} outgoing and {} incident bins",
                window.basis.name(),
                filled.describe(section),
                transmission.rows(),
                transmission.cols()
            ))
            .file(&window.origin.file)
            .line(window.origin.line)
            .help("use the BSDF's basis in the comment before the polygon: '#@rfluxmtx h=kf' for Klems full, h=kh half, h=kq quarter"));
        }
        for (path, (_, state)) in section.states.iter().zip(&states) {
            if (state.rows(), state.cols()) != (bins, bins) {
                return Err(Error::new(format!(
                    "this state has {} outgoing and {} incident bins, the window {bins}",
                    state.rows(),
                    state.cols()
                ))
                .file(path)
                .help("all states of a window need the basis of the window"));
            }
        }
        let name = if single { section.name.clone() } else { format!("{}-{}", section.name, window.name) };
        let glass = if let Filled::Glass(pane) = &filled { Some(*pane) } else { None };
        let shade = match &glass {
            Some(pane) => Some(Shade::of_pane(&window, pane)),
            None => Shade::read(project, section, &window, warnings)?,
        };
        let shape = "D has a row per bin and a column per patch, the ground first";
        let daylight = section.daylight.as_ref().map(|d| Imported::load(d, bins, patches, shape)).transpose()?;
        windows.push(ProjectWindow {
            name,
            parts: vec![window.clone()],
            division: Division::of(section),
            window,
            transmission,
            made_of: filled.describe(section),
            glass,
            states: states.clone(),
            shade,
            pane: named_pane.clone().or(own_pane),
            daylight,
        });
        read = Some(filled);
    }
    Ok(windows)
}

/// A state of the façade: the file's name without its ending, and T.
fn read_state(path: &Path, warnings: &mut Warnings) -> Result<(String, Matrix<f64>)> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let bsdf = bsdf::read(path, warnings)?;
    checked(&bsdf, path, warnings)?;
    Ok((name, in_colour(bsdf::transmission_matrix(&bsdf).map_err(|e| e.file(path))?)))
}

/// Scattering data as the sun meets them: with their through-peak, if they have one, as a clear view.
fn read_pane(file: &Path, warnings: &mut Warnings) -> Result<PaneBsdf> {
    let scattering = checked(&bsdf::read(file, warnings)?, file, warnings)?;
    if scattering.lobe(Component::TransmissionFront).is_none() {
        return Err(Error::new("the BSDF has no transmission of wavelength Visible, so no sun passes it")
            .file(file)
            .help("use a file with Visible / Transmission Front or Transmission Back"));
    }
    Ok(if scattering.has_peak() { PaneBsdf::PeakBsdf(scattering) } else { PaneBsdf::Bsdf(scattering) })
}

/// Sensors must see some window from its room side, or the normals point the wrong way. Windows that no sensor
/// sees so may be those of other rooms: they are named.
pub(super) fn check_sides(windows: &[ProjectWindow], sensors: &[Sensor], direct: bool, warnings: &mut Warnings) -> Result<()> {
    if sensors.is_empty() {
        return Ok(());
    }
    let corners = |window: &ProjectWindow| window.window.triangles.as_flattened().to_vec();
    let lights = |w: &&ProjectWindow| {
        let corners = corners(w);
        sensors.iter().any(|s| corners.iter().any(|c| (s.position - *c).dot(w.window.frame.z) > 0.0))
    };
    let behind: Vec<&ProjectWindow> = windows.iter().filter(|w| !lights(w)).collect();
    for window in &behind {
        let corners = corners(window);
        let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        let place = format!("window '{}' at {:.3} {:.3} {:.3}", window.name, middle.x, middle.y, middle.z);
        let told = |text: String| Error::new(text).file(&window.window.origin.file).line(window.window.origin.line);
        // Sensors outdoors are behind all windows.
        if behind.len() == windows.len() && !direct {
            return Err(told(format!("{place} faces the wrong way: every sensor is behind it"))
                .help("its normal must point into the room: reverse the order of its vertices"));
        }
        warnings.push(
            told(format!("{place} lights no sensor: all are behind it"))
                .help("right for a window of another room; else its normal must point into this one: reverse the order of its vertices"),
        );
    }
    Ok(())
}
