//! Windows with their transmission, their states, and what the sun is traced through.

use super::division::Division;
use super::filling::{Filled, checked};
use super::glazing::is_seen_through;
use super::import::Imported;
use super::shade::Shade;
use crate::bsdf::evaluate::Scattering;
use crate::bsdf::{self, Component};
use crate::control::State;
use crate::error::{Error, Result, Warnings};
use crate::kernels::sun_matrix::pane::PaneBsdf;
use crate::matrix::Matrix;
use crate::scene::points::Sensor;
use crate::scene::{self, Pane, Scene, Window};
use crate::simulate::project::names::alike;
use crate::simulate::project::{Filling, Project, SunData, WindowSection};
use crate::simulate::store::fingerprint::Fingerprint;
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
    /// Whether what is outside is seen through it.
    pub see_through: bool,
    /// The clear pane that it is, if it is one; the sun is traced through it (`shade`).
    pub glass: Option<Pane>,
    /// What the sun is traced through, if by anything but the transmission.
    pub shade: Option<Shade>,
    /// Scattering data that the sun is traced through in place of a shade.
    pub pane: Option<SunPane>,
    /// All its states, of which the fields above show one; empty if it has but one.
    pub states: Vec<WindowState>,
    /// Number of the state that they show.
    pub state: State,
    /// Number of its group, if it has states.
    pub group: Option<usize>,
    /// D and Dd made elsewhere.
    pub daylight: Option<Imported>,
}

/// What a window is in one of its states.
#[derive(Debug, Clone)]
pub struct WindowState {
    /// Its name.
    pub name: String,
    /// As of [`ProjectWindow`].
    pub transmission: Matrix<f64>,
    /// As of [`ProjectWindow`].
    pub made_of: String,
    /// As of [`ProjectWindow`].
    pub see_through: bool,
    /// As of [`ProjectWindow`].
    pub glass: Option<Pane>,
    /// As of [`ProjectWindow`].
    pub shade: Option<Shade>,
    /// As of [`ProjectWindow`].
    pub pane: Option<SunPane>,
}

/// Scattering data that suns are traced through.
#[derive(Debug, Clone)]
pub struct SunPane {
    /// The data.
    pub data: PaneBsdf,
    /// What they were read from.
    pub(crate) inputs: Fingerprint,
}

impl WindowState {
    /// Whether its sun is traced.
    pub fn is_sunny(&self) -> bool {
        self.shade.is_some() || self.pane.is_some()
    }

    /// Whether suns pass it as they pass another.
    pub(crate) fn is_passed_as(&self, other: &Self) -> bool {
        let inputs = |s: &Self| s.pane.as_ref().map(|p| p.inputs);
        self.shade == other.shade && inputs(self) == inputs(other)
    }
}

impl ProjectWindow {
    /// Shows a state.
    ///
    /// # Panics
    /// If there is no such one.
    pub(crate) fn take_state(&mut self, number: State) {
        let WindowState { name: _, transmission, made_of, see_through, glass, shade, pane } = self.states[usize::from(number)].clone();
        (self.transmission, self.made_of, self.see_through) = (transmission, made_of, see_through);
        (self.glass, self.shade, self.pane, self.state) = (glass, shade, pane, number);
    }

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
    let mut states: Vec<StateReader> = section.each_state().into_iter().map(StateReader::new).collect();
    let single = surfaces.len() == 1;
    if let (Some(_), [first, second, ..]) = (&section.daylight, &surfaces[..]) {
        return Err(Error::new(format!(
            "a matrix 'daylight' belongs to one window, but this file holds several: '{}', '{}'",
            first.name, second.name
        ))
        .file(&section.surface)
        .help("give each its own [[window]] with its own matrix"));
    }
    if let (true, [first, second, ..]) = (states.iter().any(|s| s.section.shade.is_some()), &surfaces[..]) {
        return Err(Error::new(format!("a shade belongs to one window, but this file holds several: '{}', '{}'", first.name, second.name))
            .file(&section.surface)
            .help("give each its own [[window]] with its own shade"));
    }
    let mut windows = Vec::new();
    for window in surfaces {
        let bins = window.basis.len();
        let mut pane_of_scene = None;
        let mut read = |(i, reader): (usize, &mut StateReader)| {
            let name = section.states.get(i).map_or("", |s| s.name.as_str());
            reader.read(project, &window, name, (&mut *scene, &mut pane_of_scene), warnings)
        };
        let mut all = states.iter_mut().enumerate().map(&mut read).collect::<Result<Vec<_>>>()?;
        let name = if single { section.name.clone() } else { format!("{}-{}", section.name, window.name) };
        let shape = "D has a row per bin and a column per patch, the ground first";
        let daylight = section.daylight.as_ref().map(|d| Imported::load(d, bins, patches, shape)).transpose()?;
        let first = if section.states.is_empty() { all.remove(0) } else { all[0].clone() };
        windows.push(ProjectWindow {
            name,
            parts: vec![window.clone()],
            division: Division::of(section),
            window,
            transmission: first.transmission,
            made_of: first.made_of,
            see_through: first.see_through,
            glass: first.glass,
            shade: first.shade,
            pane: first.pane,
            states: all,
            state: 0,
            group: project.facade.groups().iter().position(|g| !section.states.is_empty() && alike(&g.name, &section.group)),
            daylight,
        });
    }
    Ok(windows)
}

/// Reads one state of all windows of a section.
struct StateReader {
    /// The section in this state.
    section: WindowSection,
    /// Scattering data, which are the same for all its windows.
    data: Option<Filled>,
    tensor_tree: Option<SunPane>,
}

impl StateReader {
    fn new(section: WindowSection) -> Self {
        Self { section, data: None, tensor_tree: None }
    }

    /// What a window is in it; `pane_of_scene` is the glass that another of its states has taken out of the scene.
    fn read(
        &mut self,
        project: &Project,
        window: &Window,
        name: &str,
        (scene, pane_of_scene): (&mut Scene, &mut Option<Filled>),
        warnings: &mut Warnings,
    ) -> Result<WindowState> {
        let (section, bins) = (&self.section, window.basis.len());
        if let (None, Some(SunData { file: Some(file), sees_peak })) = (&self.tensor_tree, &section.tensor_tree) {
            self.tensor_tree = Some(read_pane(file, *sees_peak, warnings)?);
        }
        let filled = match (self.data.take(), &section.filling, &*pane_of_scene) {
            (Some(data), ..) => data,
            (None, Filling::SceneGlass, Some(pane)) => pane.clone(),
            _ => Filled::read(project, section, window, scene, warnings)?,
        };
        if section.filling == Filling::SceneGlass {
            *pane_of_scene = Some(filled.clone());
        }
        let transmission = filled.transmission(&window.basis)?;
        let own_pane = filled.pane(project, section, warnings)?;
        if (transmission.rows(), transmission.cols()) != (bins, bins) {
            let of_state = if name.is_empty() { String::new() } else { format!(" of state '{name}'") };
            return Err(Error::new(format!(
                "the window is divided by the basis {} ({bins} bins), its BSDF {}{of_state} has {} outgoing and {} incident bins",
                window.basis.name(),
                filled.describe(section),
                transmission.rows(),
                transmission.cols()
            ))
            .file(&window.origin.file)
            .line(window.origin.line)
            .help("use the BSDF's basis in the comment before the polygon: '#@rfluxmtx h=kf' for Klems full, h=kh half, h=kq quarter"));
        }
        let glass = if let Filled::Glass(pane) = &filled { Some(*pane) } else { None };
        let shade = match &glass {
            Some(pane) => Some(Shade::of_pane(window, pane)),
            None => Shade::read(project, section, window, warnings)?,
        };
        // Of layers the clear view is on the diagonal of T.
        let own_pane = own_pane.map(|data| SunPane { data, inputs: *Fingerprint::new("pane of layers").add(&transmission.data()) });
        let own_pane = match &section.tensor_tree {
            Some(SunData { file: None, sees_peak }) => {
                let scattering = filled.scattering(&project.file).map_err(|e| section.place.of(e))?;
                Some(SunPane { data: pane_bsdf(scattering, *sees_peak), inputs: filled.inputs(*sees_peak) })
            }
            _ => own_pane,
        };
        let state = WindowState {
            name: name.to_string(),
            transmission,
            made_of: filled.describe(section),
            see_through: is_seen_through(&filled),
            glass,
            shade,
            pane: self.tensor_tree.clone().or(own_pane),
        };
        self.data = Some(filled).filter(|f| matches!(f, Filled::Data(..)));
        Ok(state)
    }
}

/// Scattering data as the sun meets them: with their through-peak, if they have one and it is asked for, as a clear view.
fn pane_bsdf(scattering: Scattering, sees_peak: bool) -> PaneBsdf {
    if sees_peak && scattering.has_peak() { PaneBsdf::PeakBsdf(scattering) } else { PaneBsdf::Bsdf(scattering) }
}

fn read_pane(file: &Path, sees_peak: bool, warnings: &mut Warnings) -> Result<SunPane> {
    let scattering = checked(&bsdf::read(file, warnings)?, file, warnings)?;
    if scattering.lobe(Component::TransmissionFront).is_none() {
        return Err(Error::new("the BSDF has no transmission of wavelength Visible, so no sun passes it")
            .file(file)
            .help("use a file with Visible / Transmission Front or Transmission Back"));
    }
    let mut inputs = *Fingerprint::new("pane").add_values(&crate::files::read(file)?);
    if !sees_peak {
        inputs.add(&"no peak");
    }
    Ok(SunPane { data: pane_bsdf(scattering, sees_peak), inputs })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::Inputs;

    /// What suns pass in each state of a window whose section ends with these lines; without states, in the window.
    fn panes(lines: &str) -> Vec<SunPane> {
        let folder = tempfile::tempdir().unwrap();
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
        let window = std::fs::read_to_string(format!("{scenes}/glass_room/window.rad"))
            .unwrap()
            .replace("pane polygon", "#@rfluxmtx h=kq u=+Z\npane polygon");
        std::fs::write(folder.path().join("window.rad"), window).unwrap();
        let text = format!(
            "[weather]\nfile = \"{scenes}/office/weather/new_york.wea\"\n[scene]\nfiles = [\"{scenes}/glass_room/room.rad\"]\n\
             [[sensors]]\nname = \"room\"\npoints = \"{scenes}/glass_room/points.txt\"\n[[window]]\nname = \"south\"\n\
             surface = \"window.rad\"\n{}\n",
            lines.replace("BSDF/", &format!("{scenes}/bsdf/"))
        );
        std::fs::write(folder.path().join("project.toml"), text).unwrap();
        let project = Project::read(&folder.path().join("project.toml")).unwrap();
        let window = Inputs::read(&project, &mut Warnings::new()).unwrap().windows.remove(0);
        let of_states = window.states.iter().map(|s| s.pane.clone().unwrap()).collect();
        if window.states.is_empty() { vec![window.pane.unwrap()] } else { of_states }
    }

    #[test]
    fn the_sun_passes_a_windows_own_data_with_or_without_their_peak() {
        let clear = |lines: &str| panes(lines).remove(0);
        let own = clear("bsdf = \"BSDF/clear.xml\"\ntensor_tree = \"own\"");
        let file = clear("bsdf = \"BSDF/clear.xml\"\ntensor_tree = \"BSDF/clear.xml\"");
        let spread = clear("bsdf = \"BSDF/clear.xml\"\ntensor_tree = \"own\"\npeak = false");
        let through = |pane: &SunPane| pane.data.clear(DVec3::new(0.1, -0.3, 0.9).normalize())[1];
        assert!(matches!(own.data, PaneBsdf::PeakBsdf(_)) && matches!(spread.data, PaneBsdf::Bsdf(_)));
        assert!(through(&own) > 0.6 && through(&own) == through(&file) && through(&spread) == 0.0, "{}", through(&own));
        assert_ne!(own.inputs, spread.inputs);
        // Halfway to the other state; and layers.
        let panes = panes(
            "[[window.state]]\nname = \"clear\"\nbsdf = \"BSDF/clear.xml\"\ntensor_tree = \"own\"\n\
             [[window.state]]\nname = \"half\"\ninterpolate = [\"BSDF/clear.xml\", \"BSDF/cloudy.xml\", 0.5]\ntensor_tree = \"own\"\n\
             [[window.state]]\nname = \"cloudy\"\nbsdf = \"BSDF/cloudy.xml\"\ntensor_tree = \"own\"\n\
             [[window.state]]\nname = \"behind glass\"\nglazing = [\"glass:clear_3mm\", \"gap=16mm\", \"BSDF/clear.xml\"]\ntensor_tree = \"own\"",
        );
        let [a, half, b, behind] = [0, 1, 2, 3].map(|k| through(&panes[k]));
        // The cloudy state scatters so much that its peak is none; halfway its share and the clear one's are averaged.
        assert!((0.5..0.58).contains(&(half / a)) && b == 0.0, "{a} {half} {b}");
        assert!((0.85..0.95).contains(&(behind / a)), "{behind} of {a}");
        assert_ne!(panes[0].inputs, panes[1].inputs);
    }
}
