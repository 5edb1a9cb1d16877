//! Everything a project names, read and checked against each other before any computing.

pub mod counting;
pub mod division;
mod doubles;
pub(crate) mod filling;
mod given_sky;
pub(crate) mod glare_states;
pub(crate) mod glazing;
pub(crate) mod grids;
pub(crate) mod import;
pub mod mirrors;
mod models;
pub(crate) mod outlook;
pub mod parts;
pub(crate) mod reach;
pub(crate) mod shade;
mod shade_check;
pub mod states;
pub mod suns;
pub(crate) mod windows;

use self::counting::Counting;
pub use self::filling::in_colour;
use self::import::{Imported, sun_matrices};
use self::shade::Shade;
use self::suns::SunSet;
pub(crate) use self::windows::ProjectWindow;
pub(crate) use self::windows::read_surfaces;
use self::windows::{check_sides, read_windows};
use crate::bins::ReinhartSky;
use crate::control::{Facade, Schedule};
use crate::error::{Error, Result, Warnings};
use crate::kernels::sun_matrix::pane::PaneBsdf;
use crate::matrix::Matrix;
use crate::scene::points::Sensor;
use crate::scene::{self, GlazedWindow, Scene, Window};
use crate::simulate::project::glare::GlareMethod;
use crate::simulate::project::method::{Choice, Glazing};
use crate::simulate::project::{Project, SensorPoints, SensorsSection, WindowSection};
use crate::simulate::store::fingerprint::Fingerprint;
use crate::weather::Weather;
use glam::DVec3;
use std::path::PathBuf;

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
    /// `reach`).
    pub seem_dark: Vec<bool>,
    /// What the windows ask of a method that is left open.
    pub glazing: Glazing,
    /// Of a project that names no windows, the scene's glass that was not taken for windows, and why.
    pub glass_left: Vec<String>,
    /// Groups of the windows that have states.
    pub facade: Facade,
    /// The state of each group in every time step.
    pub schedule: Schedule,
    /// Groups whose states the run is still to decide; until then they take turns in the schedule.
    pub undecided: Vec<usize>,
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
    pub(crate) fn scene_fingerprint(&self) -> Fingerprint {
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
    }

    /// Reads and checks all files of a project.
    ///
    /// # Errors
    /// What is wrong in which file; windows whose basis is not their BSDF's, or that face away
    /// from every sensor.
    pub fn read(project: &Project, warnings: &mut Warnings) -> Result<Self> {
        let mut glazing = glazing::glazing(project)?;
        let choice = project.choice(&glazing);
        project.check_phases(choice.phases)?;
        let weather = project.weather.load(warnings)?;
        if let Some(sky) = &weather.given {
            glazing.sky = given_sky::check(project, &choice, sky)?;
        }
        check_steps(project, &weather, warnings)?;
        let mut scene = read_scene(project, warnings)?;
        let mut windows = Vec::new();
        let patches = project.method.sky.unwrap_or(glazing.sky).len();
        for section in &project.windows {
            windows.extend(read_windows(project, section, patches, &mut scene, warnings)?);
        }
        let glass_left = project.found.left.clone();
        project.found.warnings.iter().for_each(|w| warnings.push(w.clone()));
        let named = |w: &ProjectWindow| Window { name: w.name.clone(), ..w.window.clone() };
        doubles::warn(&scene, warnings);
        scene.set_windows(&windows.iter().map(named).collect::<Vec<_>>(), warnings)?;
        let bins = windows.iter().map(|w| w.window.basis.len()).sum();
        let plain: Vec<Window> = windows.iter().map(|w| w.window.clone()).collect();
        let direct = project.choice(&glazing).direct;
        let light = if direct { reach::Light::Sky } else { reach::Light::Windows(&plain) };
        let sensors = project.sensors.iter().map(|s| read_group(project, s, &scene, light, bins, warnings)).collect::<Result<Vec<_>>>()?;
        if project.windows.iter().any(|w| w.daylight.is_some()) || project.sensors.iter().any(|s| s.view.is_some() || s.sun.is_some()) {
            warnings.push(Error::new("matrices made elsewhere count as exact: their noise is not in the estimated error"));
        }
        let everywhere: Vec<Sensor> = sensors.iter().flat_map(|g| &g.sensors).copied().collect();
        check_sides(&windows, &everywhere, direct, warnings)?;
        if !windows.is_empty() {
            mirrors::warn(&scene, &plain, warnings);
        }
        let seem_dark = reach::seem_dark(&scene, light, &everywhere);
        reach::warn(&sensors, &seem_dark, direct, warnings);
        models::warn(project, warnings)?;
        let schedule = states::schedule(project, &weather)?;
        let facade = project.facade.clone();
        let inputs = Self {
            weather,
            scene,
            windows,
            sensors,
            seem_dark,
            glazing,
            glass_left,
            facade,
            schedule: schedule.clone(),
            undecided: Vec::new(),
        };
        let mut inputs = inputs.with_schedule(schedule);
        inputs.undecided = project.control.decided_by_the_run();
        parts::divide(project, &mut inputs)?;
        // A schedule that does not fit the year is told before hours of tracing.
        inputs.counting(project)?;
        if project.output.quantity.is_solar() {
            inputs.warn_of_solar(project, warnings);
        }
        inputs.check_states(project, warnings)?;
        inputs.check_suns(project, warnings)?;
        inputs.check_peaks(project, warnings);
        Ok(inputs)
    }

    /// Faults of what five phases need, before hours of tracing.
    fn check_suns(&self, project: &Project, warnings: &mut Warnings) -> Result<()> {
        let method = &project.method;
        if self.choice(project).phases != 5 {
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

    /// Materials are those of light.
    fn warn_of_solar(&self, project: &Project, warnings: &mut Warnings) {
        let windows: Vec<&str> = self.windows.iter().map(|w| w.name.as_str()).collect();
        let behind = match &windows[..] {
            [] => String::new(),
            names => format!(", and the transmittance of light of windows '{}'", names.join("', '")),
        };
        warnings.push(
            Error::new(format!(
                "irradiance is computed with the scene's reflectances of light{behind} as those of the whole solar spectrum"
            ))
            .file(&project.file)
            .field("output.quantity")
            .help("give scene files and windows with solar values for this project; coated glass passes much less of the sun's heat"),
        );
    }

    /// Sharp glare that the sky's patches and the bins blur: a sun seen through a pane, but not traced.
    fn check_peaks(&self, project: &Project, warnings: &mut Warnings) {
        let Some(glare) = project.glare.as_ref().filter(|g| g.method != GlareMethod::Dgps) else { return };
        let five = self.choice(project).phases == 5;
        let blurred = |w: &WindowSection| !(five && w.lets_suns_through()) && glazing::passes_direct(project, w);
        for section in project.windows.iter().filter_map(|w| w.each_state().into_iter().find(blurred)) {
            warnings.push(section.place.of(
                Error::new(format!(
                    "the sun is seen through window '{}', but it is spread over a patch of the sky and a bin of the BSDF: glare by \
                     method \"{}\" misses hours with the sun in view",
                    section.name,
                    glare.method.name()
                ))
                .help(if section.filling.is_clear() {
                    "write phases = 5 or \"auto\": then the sun is traced through its panes"
                } else {
                    "give the window a shade = \"….rad\" with its panes, or a tensor_tree = \"….xml\": then five phases trace the sun through it"
                }),
            ));
        }
    }

    /// The number of phases of a project with these windows, and why.
    pub fn choice(&self, project: &Project) -> Choice {
        project.choice(&self.glazing)
    }

    /// The division of the sky of a project with these windows.
    pub fn sky(&self, project: &Project) -> ReinhartSky {
        project.method.sky.unwrap_or(self.glazing.sky)
    }

    /// Which hours and numbers metrics count.
    ///
    /// # Errors
    /// As [`Counting::new`].
    pub fn counting(&self, project: &Project) -> Result<Counting> {
        let vertical = self.sensors.iter().flat_map(|g| &g.sensors).any(|s| !s.faces_up());
        let counting = Counting::new(&project.metrics, &self.weather, vertical).map_err(|e| e.file(&project.file))?;
        Ok(if project.output.quantity.is_solar() { counting.of_irradiance() } else { counting })
    }

    /// Number of bins of all parts of all windows: columns of V.
    pub fn bins(&self) -> usize {
        self.windows.iter().map(ProjectWindow::bins).sum()
    }

    /// The parts of the windows, in the order of V's columns.
    pub fn geometry(&self) -> Vec<Window> {
        self.windows.iter().flat_map(|w| w.parts.clone()).collect()
    }

    /// How many parts a window's bin is divided into, on average.
    pub(crate) fn mean_parts(&self) -> usize {
        let whole: usize = self.windows.iter().map(|w| w.window.basis.len()).sum();
        (self.bins() / whole.max(1)).max(1)
    }

    /// T of every window, in the state that it shows.
    pub(crate) fn transmissions(&self) -> Vec<&Matrix<f64>> {
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

    /// Windows of clear glass.
    pub(crate) fn glazed(&self) -> Vec<GlazedWindow> {
        self.windows.iter().filter_map(|w| Some(GlazedWindow { window: w.window.clone(), pane: w.glass? })).collect()
    }

    /// The suns of a project.
    ///
    /// # Errors
    /// As [`SunSet::new`].
    pub(crate) fn sun_set(&self, project: &Project) -> Result<SunSet> {
        let choice = self.choice(project);
        // Without windows no sun is taken for unreachable. Sensors may see the sky by no window.
        let windows: Vec<Window> = if project.quality.prune && !choice.direct { self.sunny_windows() } else { Vec::new() };
        SunSet::of(&self.weather, project.method.suns_of(&choice), &windows, project.output.quantity)
    }

    /// Windows whose sun is traced through a shade, with the corners of their shades.
    pub(crate) fn shaded_windows(&self) -> Vec<(Window, Vec<DVec3>)> {
        self.windows.iter().filter_map(|w| Some((w.window.clone(), w.shade.as_ref()?.corners()))).collect()
    }

    /// Windows whose sun is traced through scattering data.
    pub(crate) fn pane_windows(&self) -> Vec<(Window, PaneBsdf)> {
        self.windows.iter().filter_map(|w| Some((w.window.clone(), w.pane.as_ref()?.data.clone()))).collect()
    }

    /// The shades of all windows.
    pub fn shades(&self) -> impl Iterator<Item = &Shade> {
        self.windows.iter().filter_map(|w| w.shade.as_ref())
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

/// The scene of a project, without its windows.
///
/// # Errors
/// What is wrong in which file.
pub fn read_scene(project: &Project, warnings: &mut Warnings) -> Result<Scene> {
    // Commands inside scene files may name files relative to the project's folder.
    let base = project.folder();
    let files: Vec<PathBuf> = project.scene.files.iter().map(|f| f.strip_prefix(base).unwrap_or(f).to_path_buf()).collect();
    if !project.windows.iter().any(|w| w.found.is_some()) {
        return scene::read_scene(&files, base, warnings);
    }
    // All scattering data are windows: else they would have been refused.
    let (mut scene, scattering) = scene::read_scene_and_scattering(&files, base, warnings)?;
    scene.triangles.retain(|t| scattering.iter().all(|s| s.material != t.material));
    Ok(scene)
}

fn read_group(
    project: &Project,
    section: &SensorsSection,
    scene: &Scene,
    light: reach::Light<'_>,
    bins: usize,
    warnings: &mut Warnings,
) -> Result<SensorGroup> {
    let sensors = grids::sensors(project, section, scene, light, warnings)?;
    let shape = "V has a row per sensor and a column per bin of all windows, in the project's order";
    let view = section.view.as_ref().map(|v| Imported::load(v, sensors.len(), bins, shape)).transpose()?;
    let file = match &section.points {
        SensorPoints::File(file) | SensorPoints::OverFile(file, _) => file.clone(),
        SensorPoints::OverSurface(..) => project.file.clone(),
    };
    Ok(SensorGroup { name: section.name.clone(), file, sensors, view, sun: section.sun.clone() })
}
