//! Everything a project names, read and checked against each other before any computing.

pub mod import;
pub mod mirrors;
pub mod reach;
pub mod shade;
mod shade_check;
pub mod suns;

use self::import::{Imported, sun_matrices};
use self::shade::Shade;
use self::suns::SunSet;
use crate::bsdf::evaluate::Scattering;
use crate::bsdf::{self, Component};
use crate::error::{Error, Result, Warnings};
use crate::kernels::sun_matrix::pane::PaneBsdf;
use crate::matrix::Matrix;
use crate::scene::points::Sensor;
use crate::scene::{self, Scene, Window};
use crate::simulate::project::glare::GlareMethod;
use crate::simulate::project::glazing;
use crate::simulate::project::{Project, SensorsSection, WindowSection};
use crate::simulate::store::fingerprint::Fingerprint;
use crate::weather::Weather;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The contents of all files of a project.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// Hours and their sun and sky.
    pub weather: Weather,
    /// The room and its surroundings.
    pub scene: Scene,
    /// All windows; the polygons of one `[[window]]` may make several (one per modifier).
    pub windows: Vec<ProjectWindow>,
    /// One per `[[sensors]]`.
    pub sensors: Vec<SensorGroup>,
    /// Of all sensors in the order of the groups, whether no way of light to them was found (see
    /// [`reach`]).
    pub seem_dark: Vec<bool>,
    /// Of the scene, hashed once.
    scene_fingerprint: OnceLock<Fingerprint>,
}

/// A window with its transmission.
#[derive(Debug, Clone)]
pub struct ProjectWindow {
    /// Name in results: the section's, with the modifier's where the section has several.
    pub name: String,
    /// Geometry and basis.
    pub window: Window,
    /// T `[outgoing bin][incident bin]`, RGB; includes the projected solid angle of the incident
    /// bin (as dctimestep applies it).
    pub transmission: Matrix<f64>,
    /// What the sun is traced through, if by anything but the transmission.
    pub shade: Option<Shade>,
    /// Scattering data that the sun is traced through in place of a shade.
    pub pane: Option<PaneBsdf>,
    /// T of all states of the façade, with their names; empty if the window has one state.
    pub states: Vec<(String, Matrix<f64>)>,
    /// D and Dd made elsewhere.
    pub daylight: Option<Imported>,
}

/// A group of sensors.
#[derive(Debug, Clone)]
pub struct SensorGroup {
    /// Name of its result files.
    pub name: String,
    /// File, for messages.
    pub file: PathBuf,
    /// Sensors in the order of the file.
    pub sensors: Vec<Sensor>,
    /// V and Vd made elsewhere, columns the bins of all windows.
    pub view: Option<Imported>,
    /// File of Cds made elsewhere.
    pub sun: Option<PathBuf>,
}

impl Inputs {
    /// What rays can meet.
    pub fn scene_fingerprint(&self) -> Fingerprint {
        *self.scene_fingerprint.get_or_init(|| {
            let scene = &self.scene;
            let corners: Vec<DVec3> = scene.triangles.iter().flat_map(|t| t.vertices).collect();
            let indices: Vec<_> = scene.triangles.iter().map(|t| t.material).collect();
            let materials: Vec<_> = scene.materials.iter().map(|m| m.kind).collect();
            // Each of them absorbs the light of all others.
            let windows: Vec<_> = scene.windows.iter().map(|w| (&w.triangles, w.frame.z)).collect();
            *Fingerprint::new("scene")
                .add_values(&corners)
                .add_values(&indices)
                .add(&materials)
                .add(&("windows absorb", windows))
                .add(&scene.unpruned)
        })
    }

    /// Reads and checks all files of a project.
    ///
    /// # Errors
    /// What is wrong in which file; windows whose basis is not their BSDF's, or that face away
    /// from every sensor.
    pub fn read(project: &Project, warnings: &mut Warnings) -> Result<Self> {
        let weather = Weather::read(&project.weather.file, warnings)?;
        check_steps(project, &weather, warnings)?;
        // Commands inside scene files may name files relative to the project's folder.
        let base = project.folder();
        let files: Vec<PathBuf> = project.scene.files.iter().map(|f| f.strip_prefix(base).unwrap_or(f).to_path_buf()).collect();
        let mut scene = scene::read_scene(&files, base, warnings)?;
        let mut windows = Vec::new();
        for section in &project.windows {
            windows.extend(read_windows(project, section, warnings)?);
        }
        let named = |w: &ProjectWindow| Window { name: w.name.clone(), ..w.window.clone() };
        scene.set_windows(&windows.iter().map(named).collect::<Vec<_>>(), warnings)?;
        let bins = windows.iter().map(|w| w.window.basis.len()).sum();
        let sensors = project.sensors.iter().map(|s| read_group(s, bins, warnings)).collect::<Result<Vec<_>>>()?;
        if project.windows.iter().any(|w| w.daylight.is_some()) || project.sensors.iter().any(|s| s.view.is_some() || s.sun.is_some()) {
            warnings.push(Error::new("matrices made elsewhere count as exact: their noise is not in the estimated error"));
        }
        for window in &windows {
            check_side(window, &sensors)?;
        }
        let plain: Vec<Window> = windows.iter().map(|w| w.window.clone()).collect();
        mirrors::warn(&scene, &plain, warnings);
        let seem_dark = reach::seem_dark(&scene, &plain, &sensors);
        reach::warn(&sensors, &seem_dark, warnings);
        let inputs = Self { weather, scene, windows, sensors, seem_dark, scene_fingerprint: OnceLock::new() };
        inputs.check_suns(project, warnings)?;
        inputs.check_peaks(project, warnings);
        Ok(inputs)
    }

    /// Faults of what five phases need, before hours of tracing.
    fn check_suns(&self, project: &Project, warnings: &mut Warnings) -> Result<()> {
        let method = &project.method;
        if method.choice(&project.windows).phases != 5 {
            if method.suns_are_given {
                warnings.push(
                    Error::new("'suns' has no effect: no window lets suns through, so there are three phases")
                        .file(&project.file)
                        .field("method.suns")
                        .help("add shade = \"….rad\" or tensor_tree = \"….xml\" to a [[window]], or take 'suns' out"),
                );
            }
            return Ok(());
        }
        shade_check::warn(project, self, warnings);
        if self.sensors.iter().any(|g| g.sun.is_some()) {
            let suns = self.sun_set(project)?;
            let files = self.sensors.iter().map(|g| (g.name.as_str(), g.sun.as_deref(), g.sensors.len()));
            sun_matrices(files, &suns)?;
        }
        Ok(())
    }

    /// Sharp glare that the sky's patches and the bins blur: a sun seen through a pane, but not traced.
    fn check_peaks(&self, project: &Project, warnings: &mut Warnings) {
        let Some(glare) = project.glare.as_ref().filter(|g| g.method != GlareMethod::Dgps) else { return };
        let five = project.method.choice(&project.windows).phases == 5;
        for section in project.windows.iter().filter(|w| !(five && w.lets_suns_through())) {
            let states = if section.states.is_empty() { std::slice::from_ref(&section.bsdf) } else { &section.states[..] };
            let Some(clear) = states.iter().find(|file| glazing::passes_straight(file)) else { continue };
            warnings.push(
                Error::new(format!(
                    "the sun is seen through window '{}', but it is spread over a patch of the sky and a bin of the BSDF: glare by \
                     method \"{}\" misses hours with the sun in view",
                    section.name,
                    glare.method.name()
                ))
                .file(clear)
                .help("give the window a shade = \"….rad\" with its panes, or a tensor_tree = \"….xml\": then five phases trace the sun through it"),
            );
        }
    }

    /// Number of bins of all windows: columns of V.
    pub fn bins(&self) -> usize {
        self.windows.iter().map(|w| w.window.basis.len()).sum()
    }

    /// The windows' geometry, in the order of V's columns.
    pub fn geometry(&self) -> Vec<Window> {
        self.windows.iter().map(|w| w.window.clone()).collect()
    }

    /// T of every window.
    pub fn transmissions(&self) -> Vec<&Matrix<f64>> {
        self.windows.iter().map(|w| &w.transmission).collect()
    }

    /// Whether a direct part can exceed its whole: where V, Vd, D or Dd were made elsewhere.
    pub fn differences(&self) -> Differences {
        let given = self.windows.iter().any(|w| w.daylight.is_some()) || self.sensors.iter().any(|g| g.view.is_some());
        if given { Differences::Noisy } else { Differences::NeverNegative }
    }

    /// All sensors, group by group.
    pub fn all_sensors(&self) -> Vec<Sensor> {
        self.sensors.iter().flat_map(|g| &g.sensors).copied().collect()
    }

    /// The suns of a project.
    ///
    /// # Errors
    /// As [`SunSet::new`].
    pub fn sun_set(&self, project: &Project) -> Result<SunSet> {
        // Without windows no sun is taken for unreachable.
        let windows: Vec<Window> = if project.quality.prune { self.sunny_windows() } else { Vec::new() };
        SunSet::new(&self.weather, project.method.suns, &windows)
    }

    /// Windows through which suns are traced, by their shade or their scattering data.
    pub fn sunny_windows(&self) -> Vec<Window> {
        self.windows.iter().filter(|w| w.is_sunny()).map(|w| w.window.clone()).collect()
    }

    /// Windows whose sun is traced through a shade, with the corners of their shades.
    pub fn shaded_windows(&self) -> Vec<(Window, Vec<DVec3>)> {
        self.windows.iter().filter_map(|w| Some((w.window.clone(), w.shade.as_ref()?.corners()))).collect()
    }

    /// Windows whose sun is traced through scattering data.
    pub fn pane_windows(&self) -> Vec<(Window, PaneBsdf)> {
        self.windows.iter().filter_map(|w| Some((w.window.clone(), w.pane.clone()?))).collect()
    }

    /// The shades of all windows.
    pub fn shades(&self) -> impl Iterator<Item = &Shade> {
        self.windows.iter().filter_map(|w| w.shade.as_ref())
    }
}

impl ProjectWindow {
    /// Whether its sun is traced.
    pub fn is_sunny(&self) -> bool {
        self.shade.is_some() || self.pane.is_some()
    }
}

/// Whether a direct part can exceed its whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Differences {
    /// No: both come from the same rays; rounding alone could make a difference negative.
    NeverNegative,
    /// Yes: they were made apart, each with its own noise, as matrices of Radiance are.
    Noisy,
}

impl Differences {
    /// Whole less part.
    pub fn of(self, whole: f32, part: f32) -> f32 {
        match self {
            Self::NeverNegative => (whole - part).max(0.0),
            Self::Noisy => whole - part,
        }
    }
}

/// The rows of each group.
pub fn split(matrix: &Matrix<f32>, groups: &[SensorGroup]) -> Vec<Matrix<f32>> {
    let mut first = 0;
    let values = matrix.cols() * matrix.components();
    groups
        .iter()
        .map(|group| {
            let rows = group.sensors.len();
            let data = matrix.data()[first * values..(first + rows) * values].to_vec();
            first += rows;
            Matrix::from_data(rows, matrix.cols(), matrix.components(), data).expect("a slice of whole rows")
        })
        .collect()
}

/// Faults of the hours, before hours of tracing.
fn check_steps(project: &Project, weather: &Weather, warnings: &mut Warnings) -> Result<()> {
    let steps = weather.steps();
    let all: Vec<usize> = (0..steps.len()).collect();
    let images = &project.images;
    images.hours.chosen(&steps, &all).map_err(|e| images.place.iter().fold(e, |e, place| place.of(e)))?;
    if !steps.are_even {
        let minutes = 60.0 * steps.length;
        warnings.push(
            Error::new(format!("time steps are of different lengths: in sums of hours each counts as {minutes:.0} minutes"))
                .file(&project.weather.file)
                .help("give the weather in even steps"),
        );
    }
    Ok(())
}

fn read_group(section: &SensorsSection, bins: usize, warnings: &mut Warnings) -> Result<SensorGroup> {
    let sensors = scene::read_sensors(&section.points, Some(&section.name), warnings)?;
    let shape = "V has a row per sensor and a column per bin of all windows, in the project's order";
    let view = section.view.as_ref().map(|v| Imported::load(v, sensors.len(), bins, shape)).transpose()?;
    Ok(SensorGroup { name: section.name.clone(), file: section.points.clone(), sensors, view, sun: section.sun.clone() })
}

fn read_windows(project: &Project, section: &WindowSection, warnings: &mut Warnings) -> Result<Vec<ProjectWindow>> {
    let base = project.folder();
    let mut surfaces = scene::read_windows(section.surface.strip_prefix(base).unwrap_or(&section.surface), base, warnings)?;
    // Of several windows in one file, the one that has the section's name is meant.
    if surfaces.iter().any(|w| w.name == section.name) {
        surfaces.retain(|w| w.name == section.name);
    }
    let bsdf = bsdf::read(&section.bsdf, warnings)?;
    let transmission = in_colour(bsdf::transmission_matrix(&bsdf).map_err(|e| e.file(&section.bsdf))?);
    checked(&bsdf, &section.bsdf, warnings)?;
    let pane = section.tensor_tree.as_ref().map(|file| read_pane(file, warnings)).transpose()?;
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
    for window in surfaces {
        let bins = window.basis.len();
        if (transmission.rows(), transmission.cols()) != (bins, bins) {
            return Err(Error::new(format!(
                "the window is divided by the basis {} ({bins} bins), its BSDF {} has {} outgoing and {} incident bins",
                window.basis.name(),
                section.bsdf.display(),
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
        let shade = Shade::read(project, section, &window, warnings)?;
        let shape = "D has a row per bin and a column per patch, the ground first";
        let daylight = section.daylight.as_ref().map(|d| Imported::load(d, bins, project.method.sky.len(), shape)).transpose()?;
        windows.push(ProjectWindow {
            name,
            window,
            transmission: transmission.clone(),
            states: states.clone(),
            shade,
            pane: pane.clone(),
            daylight,
        });
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

/// The scattering function, with warnings of doubtful values.
fn checked(bsdf: &bsdf::Bsdf, file: &Path, warnings: &mut Warnings) -> Result<Scattering> {
    let mut found = Warnings::new();
    let scattering = Scattering::checked(bsdf, &mut found).map_err(|e| e.file(file))?;
    found.iter().for_each(|w| warnings.push(w.clone().file(file)));
    Ok(scattering)
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

/// A grey matrix as RGB.
pub fn in_colour(matrix: Matrix<f64>) -> Matrix<f64> {
    if matrix.components() == 3 {
        return matrix;
    }
    let data = matrix.data().iter().flat_map(|&v| [v; 3]).collect();
    Matrix::from_data(matrix.rows(), matrix.cols(), 3, data).expect("three values per element")
}

/// Sensors must see some window from its room side, or its normal points the wrong way.
fn check_side(window: &ProjectWindow, groups: &[SensorGroup]) -> Result<()> {
    if groups.is_empty() {
        return Ok(());
    }
    let corners = || window.window.triangles.iter().flatten();
    let inside = |sensor: &Sensor| corners().any(|c| (sensor.position - *c).dot(window.window.frame.z) > 0.0);
    if groups.iter().flat_map(|g| &g.sensors).any(inside) {
        return Ok(());
    }
    let middle = corners().sum::<DVec3>() / corners().count().max(1) as f64;
    Err(Error::new(format!(
        "window '{}' at {:.3} {:.3} {:.3} faces the wrong way: every sensor is behind it",
        window.name, middle.x, middle.y, middle.z
    ))
    .file(&window.window.origin.file)
    .line(window.window.origin.line)
    .help("its normal must point into the room: reverse the order of its vertices"))
}
