//! Dynamic groups: what openings are in each state, and which groups can be windows with states.
//!
//! An object that has fewer states than its group stays in its last one, as in honeybee-radiance. What a state puts
//! into the scene beside its pane has to be there in all states: V and D are computed once.

use super::geometry::Face3d;
use super::modifiers::{Kind, Modifier};
use crate::error::{Error, Warnings};
use crate::scene::{Material, MaterialIndex, MaterialKind, Pane, Scene, SurfaceOrigin, Triangle};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What fills a window of a model.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelGlazing {
    /// A clear pane; where nothing is, one that reflects nothing, where light is kept out, one that passes none.
    Glass(Pane),
    /// Scattering data: a file, or `model.hbjson#modifier` of those that the model holds.
    Bsdf(PathBuf),
}

/// What suns are traced through, where a window of scattering data has more than them.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelSun {
    /// The shades of the state, and its pane for direct studies.
    Shade(Scene),
    /// Other scattering data for direct studies.
    Bsdf(PathBuf),
}

/// What a window of a model is in one of its states.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelState {
    /// Its name: that of honeybee-radiance's `states.json`, `0_facade`.
    pub name: String,
    /// Its modifier.
    pub modifier: String,
    /// What fills the window.
    pub glazing: ModelGlazing,
    /// What suns pass, if by anything but that.
    pub sun: Option<ModelSun>,
}

/// A shade of a state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StateShade {
    pub face: Face3d,
    pub modifier: Rc<Modifier>,
    /// Its modifier in direct studies, if that is given. honeybee-radiance has black else; real slats send light on.
    pub direct: Option<Rc<Modifier>>,
    pub origin: SurfaceOrigin,
}

/// What an opening is in one state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OpeningState {
    pub modifier: Rc<Modifier>,
    /// Its modifier in direct studies, if that is another.
    pub direct: Option<Rc<Modifier>>,
    pub shades: Vec<StateShade>,
}

/// An aperture or glass door to the outside, its front outside.
pub(super) struct Opening {
    pub face: Face3d,
    /// Its dynamic group, if it has one.
    pub group: Option<String>,
    /// What it is, in each state; one if it never changes.
    pub states: Vec<OpeningState>,
    pub origin: SurfaceOrigin,
}

impl Opening {
    /// An opening that never changes.
    pub fn of(face: Face3d, modifier: Rc<Modifier>, group: Option<String>, origin: SurfaceOrigin) -> Self {
        Self { face, group, states: vec![OpeningState { modifier, direct: None, shades: Vec::new() }], origin }
    }

    /// Its modifier, of the first state.
    pub fn modifier(&self) -> &Rc<Modifier> {
        &self.states[0].modifier
    }
}

/// What becomes of the states of an object.
pub(super) enum Fate {
    /// All are the same.
    Stays,
    /// A window with states.
    Moves,
    /// Its group counts in its first state, for this reason.
    FirstOnly(String),
}

impl OpeningState {
    fn is_bsdf(&self) -> bool {
        matches!(self.modifier.kind, Kind::Bsdf { .. })
    }

    /// What of it stands in the scene. The shades of scattering data are what the data stand for.
    pub fn shades_of_scene(&self) -> &[StateShade] {
        if self.is_bsdf() { &[] } else { &self.shades }
    }

    /// What fills the window.
    ///
    /// # Errors
    /// Why a window cannot be that.
    pub fn glazing(&self) -> Result<ModelGlazing, &'static str> {
        let kind = match &self.modifier.kind {
            Kind::Bsdf { data, .. } => return Ok(ModelGlazing::Bsdf(data.clone())),
            Kind::Material(kind) => kind,
        };
        let lets_through = kind.lobes().is_some_and(|l| [l.diffuse_transmitted, l.specular_transmitted].iter().flatten().any(|t| *t > 0.0));
        match kind {
            MaterialKind::Void => Ok(ModelGlazing::Glass(Pane { transmissivity: [1.0; 3], refraction_index: 1.0 })),
            MaterialKind::Light { .. } | MaterialKind::Glow { .. } => Err("shines by itself"),
            _ if lets_through => Err("scatters light as a material of the scene, not as a Glass or BSDF"),
            other => Ok(ModelGlazing::Glass(Pane::of_material(other).unwrap_or(CLOSED))),
        }
    }

    fn is_closed(&self) -> bool {
        matches!(self.glazing(), Ok(ModelGlazing::Glass(pane)) if pane == CLOSED)
    }
}

/// States of all openings of a group together.
const MOST_STATES: usize = 1 << 20;

/// A window that lets nothing through.
const CLOSED: Pane = Pane { transmissivity: [0.0; 3], refraction_index: 1.52 };

/// What becomes of the states of one object; `between_rooms` if it does not lead outside.
pub(super) fn judge(states: &[OpeningState], between_rooms: bool) -> Fate {
    let first = &states[0];
    if states.iter().all(|s| s == first) {
        return Fate::Stays;
    }
    if between_rooms {
        return Fate::FirstOnly("it lies between two rooms".into());
    }
    let mut data = states.iter().filter_map(|s| s.modifier.directions());
    if let Some(one) = data.next()
        && data.any(|other| other != one)
    {
        return Fate::FirstOnly("its BSDFs have different bases or up vectors".into());
    }
    for (number, state) in states.iter().enumerate() {
        if let Err(why) = state.glazing() {
            return Fate::FirstOnly(format!("its modifier '{}' of state {number} {why}", state.modifier.identifier));
        }
        if state.shades_of_scene() != first.shades_of_scene() {
            return Fate::FirstOnly(format!("state {number} has other shades than state 0, and neither has a BSDF that stands for them"));
        }
    }
    Fate::Moves
}

/// Settles which groups move: their openings have as many states as the group; all others have one. `first_only` names
/// groups that do not, with the object and the reason.
pub(super) fn settle(
    openings: &mut [Opening],
    counts: &BTreeMap<String, usize>,
    first_only: &BTreeMap<String, (String, String)>,
    file: &Path,
    warnings: &mut Warnings,
) {
    for (group, (object, why)) in first_only {
        let count = counts.get(group).copied().unwrap_or(0);
        let told = format!("the dynamic group '{group}' ({count} states) counts in its first state: of '{object}', {why}");
        let help = "give its states a Glass or BSDF each (a BSDF may stand for shades too), or its windows [[window.state]]s in a project";
        warnings.push(Error::new(told).file(file).help(help));
    }
    let mut sizes: BTreeMap<String, usize> = BTreeMap::new();
    openings.iter().filter_map(|o| o.group.clone()).for_each(|group| *sizes.entry(group).or_default() += 1);
    let all_states = |group: &String| counts.get(group).copied().unwrap_or(1);
    let too_many = |group: &String| all_states(group).saturating_mul(sizes[group]) > MOST_STATES;
    for (group, size) in sizes.iter().filter(|(group, _)| too_many(group)) {
        let told =
            format!("the dynamic group '{group}' counts in its first state: {} states of {size} windows are too many", all_states(group));
        warnings.push(Error::new(told).file(file).help("join the windows of a wall, or take states out that are not needed"));
    }
    for opening in openings {
        let Some(group) = &opening.group else { continue };
        let count = if first_only.contains_key(group) || too_many(group) { 1 } else { all_states(group) };
        if let Some(last) = opening.states.last().cloned() {
            opening.states.resize(count.max(1), last);
        }
        told_states(opening, group, file, warnings);
    }
}

/// What states of an opening leave out.
fn told_states(opening: &Opening, group: &str, file: &Path, warnings: &mut Warnings) {
    let mut tell = |text: String, help: &str| {
        let known = warnings.iter().any(|w| w.message() == text);
        if !known {
            warnings.push(Error::new(text).file(file).help(help));
        }
    };
    let mut named: Vec<&str> = Vec::new();
    for state in &opening.states {
        let name = state.modifier.identifier.as_str();
        if named.contains(&name) {
            continue;
        }
        named.push(name);
        if state.is_closed() {
            tell(
                format!("in the group '{group}' the modifier '{name}' lets no light through: windows of it are black from both sides"),
                "give a BSDF whose reflectance counts where it matters; light that a closed window sends back is little",
            );
        }
        if state.is_bsdf() && !state.shades.is_empty() && state.direct.is_none() {
            tell(
                format!("suns are not traced through the shades of '{name}' in the group '{group}': nothing says what pane is behind them"),
                "set modifier_direct of the state to the pane's Glass (or to void); without it the sun stays in the sky's patches",
            );
        }
    }
}

/// What suns pass in a state of a window of scattering data.
pub(super) fn sun(openings: &[Opening], number: usize) -> Option<ModelSun> {
    let first = openings.first()?.states.get(number)?;
    let (true, Some(direct)) = (first.is_bsdf(), &first.direct) else { return None };
    let kind = match &direct.kind {
        Kind::Bsdf { data, .. } => return Some(ModelSun::Bsdf(data.clone())),
        Kind::Material(kind) => *kind,
    };
    let mut scene = Scene::default();
    for opening in openings {
        if kind != MaterialKind::Void {
            add(&mut scene, &opening.face, &direct.identifier, kind, &opening.origin);
        }
        for shade in &opening.states.get(number)?.shades {
            // Shades of scattering data are not known to rays.
            let modifier = shade.direct.as_ref().unwrap_or(&shade.modifier);
            let Kind::Material(kind) = modifier.kind else { continue };
            add(&mut scene, &shade.face, &modifier.identifier, kind, &shade.origin);
        }
    }
    (!scene.triangles.is_empty()).then_some(ModelSun::Shade(scene))
}

fn add(scene: &mut Scene, face: &Face3d, name: &str, kind: MaterialKind, origin: &SurfaceOrigin) {
    let known = scene.materials.iter().position(|m| m.name == name && m.kind == kind);
    let material = known.unwrap_or_else(|| {
        scene.materials.push(Material { name: name.to_string(), kind });
        scene.materials.len() - 1
    });
    let surface = scene.surfaces.len() as u32;
    scene.surfaces.push(origin.clone());
    let material = MaterialIndex(material as u32);
    scene.triangles.extend(face.triangles().triangles.into_iter().map(|vertices| Triangle { vertices, material, surface }));
}
