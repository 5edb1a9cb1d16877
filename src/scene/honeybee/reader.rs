//! Rooms, faces, apertures, doors and shades of a model as surfaces and openings.

mod doubles;
mod dynamic;

use super::geometry::{Face3d, mesh};
use super::json::Node;
use super::modifiers::{Kind, Modifier, Modifiers, Role};
use super::states::{self, Fate, Opening, OpeningState};
use super::windows::RoomSolid;
use crate::error::{Error, Result, Warnings};
use crate::limits;
use crate::scene::polygon::triangulate;
use crate::scene::{Material, MaterialIndex, MaterialKind, Scene, SurfaceOrigin, Triangle};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;

/// Apertures and doors of one face, at most: each makes the outline of its face longer.
const SUB_FACES: usize = 1 << 13;

/// Walks through a model.
pub(super) struct Reader<'a, 'w> {
    file: &'a Path,
    pub warnings: &'w mut Warnings,
    modifiers: Modifiers<'a>,
    /// Metres per unit, and the model's tolerance in metres.
    pub scale: f64,
    pub tolerance: f64,
    pub scene: Scene,
    pub openings: Vec<Opening>,
    materials: HashMap<String, MaterialIndex>,
    /// Partners of interior faces that are there already.
    interior: HashSet<String>,
    /// Identifiers of faces, and the adjacencies that name them.
    faces: HashSet<String>,
    adjacencies: Vec<(String, String)>,
    /// Outer faces by their corners: where there are two, rooms share an unsolved wall.
    outlines: HashMap<Vec<[i64; 3]>, String>,
    /// Dynamic groups of apertures and doors with their most states.
    pub groups: BTreeMap<String, usize>,
    /// The same of shades.
    pub shade_groups: BTreeMap<String, usize>,
    /// Groups that cannot change their states: an object, and why.
    pub first_only: BTreeMap<String, (String, String)>,
}

/// What surfaces inherit from those that hold them.
#[derive(Clone, Copy)]
struct Parent<'p, 'a> {
    set: Option<&'p Node<'a>>,
    /// Whether the face is a wall; faces without a parent count as walls.
    wall: bool,
    /// The second side of an interior face, whose openings are those of the first.
    second: bool,
}

impl<'a, 'w> Reader<'a, 'w> {
    pub fn new(file: &'a Path, modifiers: Modifiers<'a>, scale: f64, tolerance: f64, warnings: &'w mut Warnings) -> Self {
        Self {
            file,
            warnings,
            modifiers,
            scale,
            tolerance,
            scene: Scene::default(),
            openings: Vec::new(),
            materials: HashMap::new(),
            interior: HashSet::new(),
            faces: HashSet::new(),
            adjacencies: Vec::new(),
            outlines: HashMap::new(),
            groups: BTreeMap::new(),
            shade_groups: BTreeMap::new(),
            first_only: BTreeMap::new(),
        }
    }

    /// All geometry of the model.
    pub fn model(&mut self, model: &Node<'a>) -> Result<()> {
        for room in model.list("rooms")? {
            self.room(&room)?;
        }
        let orphan = Parent { set: None, wall: true, second: false };
        for face in model.list("orphaned_faces")? {
            self.face(&face, None, None)?;
        }
        let (apertures, doors) = (model.list("orphaned_apertures")?, model.list("orphaned_doors")?);
        let before = self.openings.len();
        for (sub_face, door) in apertures.iter().map(|a| (a, false)).chain(doors.iter().map(|d| (d, true))) {
            self.sub_face(sub_face, door, orphan, None)?;
        }
        if let Some(first) = self.openings.get(before) {
            let count = self.openings.len() - before;
            let told = Error::new(format!(
                "{count} apertures stand without a face or room, '{}' first: their fronts are taken to look outside",
                first.origin.name
            ));
            self.warn(told.field("orphaned_apertures").help("turn them round in Honeybee if the room is on their front"));
        }
        for shade in model.list("orphaned_shades")? {
            let detached = shade.boolean("is_detached", false)?;
            self.shade(&shade, None, if detached { Role::Context } else { Role::Shade { indoor: false } })?;
        }
        for shade in model.list("shade_meshes")? {
            self.shade_mesh(&shade)?;
        }
        self.check_adjacencies();
        self.join_doubled_openings();
        Ok(())
    }

    fn warn(&mut self, warning: Error) {
        self.warnings.push(warning.file(self.file));
    }

    fn room(&mut self, room: &Node<'a>) -> Result<()> {
        let set = self.modifiers.set_of(room)?;
        let faces = room.list("faces")?;
        if faces.is_empty() {
            return Err(room.missing("faces"));
        }
        let before = self.openings.len();
        let mut outlines = Vec::with_capacity(faces.len());
        for face in &faces {
            outlines.push(self.face(face, set.as_ref(), Some(room))?);
        }
        self.shades(room, set.as_ref())?;
        if self.openings.len() > before {
            let solid = RoomSolid::new(&outlines);
            let mut open = false;
            for opening in &mut self.openings[before..] {
                match solid.faces_out(&opening.face) {
                    Some(false) => opening.face.boundary.reverse(),
                    Some(true) => {}
                    None => open = true,
                }
            }
            if open {
                let told = room.error(
                    "the faces of this room do not close it: light may leak, and the fronts of its apertures are taken to look outside",
                );
                self.warn(told.help("check the room in Honeybee (Validate Model: 'not closed')"));
            }
        }
        Ok(())
    }

    /// A face with all that belongs to it; its outline without the holes of its openings.
    fn face(&mut self, face: &Node<'a>, set: Option<&Node<'a>>, room: Option<&Node<'a>>) -> Result<Face3d> {
        let identifier = face.identifier()?;
        let outline = self.geometry(face)?;
        let (condition, partner) = boundary_condition(face)?;
        let outdoors = condition == "Outdoors";
        let kind = face.required_text("face_type")?;
        let second = condition == "Surface" && self.interior.contains(identifier);
        self.faces.insert(identifier.to_string());
        if let (Some(partner), false) = (partner, second) {
            self.interior.insert(partner.to_string());
            self.adjacencies.push((identifier.to_string(), partner.to_string()));
        }
        let (apertures, doors) = (face.list("apertures")?, face.list("doors")?);
        if apertures.len() + doors.len() > SUB_FACES {
            let help = "join neighbouring apertures";
            return Err(face.at(limits::exceeded("this face has", SUB_FACES, "apertures and doors").help(help)));
        }
        let parent = Parent { set, wall: kind == "Wall", second };
        let mut holes = Vec::new();
        for (sub_face, door) in apertures.iter().map(|a| (a, false)).chain(doors.iter().map(|d| (d, true))) {
            let hole = self.sub_face(sub_face, door, parent, Some(condition))?;
            let off = outline.distance(&hole);
            if off > self.tolerance {
                let told = sub_face.error(format!("it lies {off:.3} m outside the plane of its face, into which its hole is pressed"));
                self.warn(told.help("let apertures lie in the plane of their face"));
            }
            holes.push(hole);
        }
        let role = match kind {
            "Wall" => Some(Role::Wall { outdoors }),
            "Floor" => Some(Role::Floor { outdoors }),
            "RoofCeiling" => Some(Role::RoofCeiling { outdoors }),
            // No wall at all.
            "AirBoundary" => None,
            other => {
                return Err(face
                    .error(format!("there is no face type '{other}'"))
                    .help("face types are Wall, Floor, RoofCeiling and AirBoundary"));
            }
        };
        if let Some(role) = role {
            if partner.is_none() {
                self.look_for_double(face, &outline, room);
            }
            let modifier = self.modifiers.of(face, set, role, self.warnings)?;
            let holes: Vec<&Face3d> = holes.iter().collect();
            let mut punched = outline.with_holes(&holes);
            if second {
                // As honeybee-radiance: the second side of a wall between rooms stands a little within its own room.
                punched = punched.moved(-2.0 * self.tolerance * outline.normal());
            }
            self.part_of_a_wall(face, &punched, modifier, outdoors, Vec::new())?;
        }
        self.shades(face, set)?;
        Ok(outline)
    }

    /// An aperture or door; its outline.
    fn sub_face(&mut self, node: &Node<'a>, door: bool, parent: Parent<'_, 'a>, of_face: Option<&str>) -> Result<Face3d> {
        let outline = self.geometry(node)?;
        let (condition, partner) = boundary_condition(node)?;
        let outdoors = match condition {
            "Outdoors" => true,
            "Surface" => false,
            other => {
                let message = format!("an aperture or door cannot have the boundary condition '{other}'");
                return Err(node.error(message).help("use Outdoors or Surface"));
            }
        };
        if of_face.is_some_and(|face| (face == "Surface") == outdoors) {
            let told =
                node.error(format!("its boundary condition is {condition}, that of its face {}: its own counts", of_face.unwrap_or("")));
            self.warn(told.help("solve the adjacency of the rooms again"));
        }
        self.shades(node, parent.set)?;
        let in_wall = parent.wall;
        let role = match door {
            true => Role::Door { outdoors, glass: node.boolean("is_glass", false)?, in_wall },
            false => Role::Aperture { outdoors, operable: node.boolean("is_operable", false)?, in_wall },
        };
        let (modifier, states) = self.states(node, parent.set, role)?;
        // Of an interior opening the side that comes first counts, whether or not its face names the other.
        let again = !outdoors && (parent.second || (of_face.is_none() && self.interior.contains(node.identifier()?)));
        if let (Some(partner), false) = (partner, outdoors) {
            self.interior.insert(partner.to_string());
        }
        if again {
            return Ok(outline);
        }
        self.part_of_a_wall(node, &outline, modifier, outdoors, states)?;
        Ok(outline)
    }

    /// A face, aperture or door: an opening if it lets light in from outside, whatever it is called. `states` has those of
    /// an object of a dynamic group.
    fn part_of_a_wall(
        &mut self,
        node: &Node<'a>,
        face: &Face3d,
        modifier: Rc<Modifier>,
        outdoors: bool,
        states: Vec<OpeningState>,
    ) -> Result<()> {
        let group = self.group_of(node)?;
        if let Some(group) = group.clone().filter(|_| !states.is_empty()) {
            match states::judge(&states, !outdoors) {
                Fate::Moves => return self.opening(node, face, Some(group), states),
                Fate::Stays => {}
                Fate::FirstOnly(why) => {
                    self.first_only.entry(group.clone()).or_insert((node.identifier()?.to_string(), why));
                }
            }
            if outdoors && matches!(modifier.kind, Kind::Bsdf { .. }) {
                return self.opening(node, face, Some(group), states[..1].to_vec());
            }
            self.state_shades(states[0].shades_of_scene())?;
        }
        let light = match &modifier.kind {
            Kind::Bsdf { .. } | Kind::Material(MaterialKind::Glass { .. }) => None,
            Kind::Material(MaterialKind::Trans { .. }) => Some("a trans"),
            Kind::Material(MaterialKind::Void) => Some("void"),
            Kind::Material(_) => return self.surface(node, face, &modifier),
        };
        if let (Some(what), true) = (light, outdoors) {
            let told = node.error(format!(
                "its modifier '{}' is {what}: light that passes it from outside counts only for sensors that follow light straight to the sky",
                modifier.identifier
            ));
            self.warn(told.help(
                "they do where all windows are of glass (phases = \"direct\"); else give it a Glass or BSDF modifier: 'lucarne bsdf isotropic' \
                 makes data of a diffusing pane",
            ));
        }
        if !outdoors || light.is_some() {
            return self.surface(node, face, &modifier);
        }
        let states = vec![OpeningState { modifier, direct: None, shades: Vec::new() }];
        self.opening(node, face, group, states)
    }

    fn opening(&mut self, node: &Node<'a>, face: &Face3d, group: Option<String>, states: Vec<OpeningState>) -> Result<()> {
        if face.triangles().triangles.is_empty() {
            self.warn(node.error("it has no area and is left out").help("remove it"));
            return Ok(());
        }
        self.state_shades(states[0].shades_of_scene())?;
        self.openings.push(Opening { face: face.clone(), group, states, origin: self.origin(node)? });
        Ok(())
    }

    fn shades(&mut self, node: &Node<'a>, set: Option<&Node<'a>>) -> Result<()> {
        for (key, indoor) in [("outdoor_shades", false), ("indoor_shades", true)] {
            for shade in node.list(key)? {
                self.shade(&shade, set, Role::Shade { indoor })?;
            }
        }
        Ok(())
    }

    fn shade(&mut self, shade: &Node<'a>, set: Option<&Node<'a>>, role: Role) -> Result<()> {
        let outline = self.geometry(shade)?;
        let (modifier, states) = self.states(shade, set, role)?;
        self.state_shades(states.first().map_or(&[][..], |s| &s.shades))?;
        self.surface(shade, &outline, &modifier)
    }

    fn shade_mesh(&mut self, shade: &Node<'a>) -> Result<()> {
        let role = if shade.boolean("is_detached", true)? { Role::Context } else { Role::Shade { indoor: false } };
        let modifier = self.modifiers.of(shade, None, role, self.warnings)?;
        let faces = mesh(shade, "geometry", self.scale)?;
        let triangles = faces.iter().flat_map(|f| triangulate(f).triangles).collect();
        self.add(shade, triangles, &modifier)
    }

    fn geometry(&mut self, node: &Node<'a>) -> Result<Face3d> {
        Face3d::read(node, "geometry", self.scale)
    }

    fn origin(&self, node: &Node<'a>) -> Result<SurfaceOrigin> {
        Ok(SurfaceOrigin { name: node.identifier()?.to_string(), file: self.file.to_path_buf(), line: 1 })
    }

    fn surface(&mut self, node: &Node<'a>, face: &Face3d, modifier: &Modifier) -> Result<()> {
        let cut = face.triangles();
        if cut.triangles.is_empty() {
            let whole = face.area_vector().length() <= 1e-9;
            let why = if whole { "it has no area and is left out" } else { "its outline cannot be cut into triangles: it is left out" };
            self.warn(node.error(why).help("remove or repair it in Honeybee"));
            return Ok(());
        }
        if cut.departure > self.tolerance && cut.flattened {
            let told = node.error(format!("its corners lie up to {:.3} m outside its plane, into which they are pressed", cut.departure));
            self.warn(told.help("let Honeybee triangulate non-planar faces"));
        }
        let area: f64 = cut.triangles.iter().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum();
        let expected = face.area_vector().length();
        if (area - expected).abs() > 1e-3 * expected.max(self.tolerance * self.tolerance) {
            let told = node.error(format!(
                "its apertures and doors overlap or reach beyond it: {area:.3} m² remain of it, where {expected:.3} m² would by its outlines"
            ));
            self.warn(told.help("move or shrink them in Honeybee"));
        }
        self.add(node, cut.triangles, modifier)
    }

    fn add(&mut self, node: &Node<'a>, triangles: Vec<[DVec3; 3]>, modifier: &Modifier) -> Result<()> {
        let origin = self.origin(node)?;
        self.add_triangles(origin, triangles, modifier).map_err(|e| node.at(e))
    }

    fn add_triangles(&mut self, origin: SurfaceOrigin, triangles: Vec<[DVec3; 3]>, modifier: &Modifier) -> Result<()> {
        let Kind::Material(kind) = &modifier.kind else {
            let message = format!("its modifier '{}' is a BSDF, which is known for apertures to the outside only", modifier.identifier);
            return Err(Error::new(message).help("give it a glass or trans of about the same transmittance"));
        };
        if self.scene.triangles.len() + triangles.len() > limits::TRIANGLES {
            return Err(limits::exceeded("the model has", limits::TRIANGLES, "triangles").help("simplify its meshes"));
        }
        let scene = &mut self.scene;
        let material = *self.materials.entry(modifier.identifier.clone()).or_insert_with(|| {
            scene.materials.push(Material { name: modifier.identifier.clone(), kind: *kind });
            MaterialIndex((scene.materials.len() - 1) as u32)
        });
        let surface = scene.surfaces.len() as u32;
        scene.surfaces.push(origin);
        scene.triangles.extend(triangles.into_iter().map(|vertices| Triangle { vertices, material, surface }));
        Ok(())
    }
}

/// The kind of a boundary condition, and the neighbour that it names.
fn boundary_condition<'a>(node: &Node<'a>) -> Result<(&'a str, Option<&'a str>)> {
    let Some(condition) = node.object("boundary_condition")? else { return Err(node.missing("boundary_condition")) };
    let kind = condition.required_text("type")?;
    if kind != "Surface" {
        return Ok((kind, None));
    }
    let partner = condition.value["boundary_condition_objects"][0].as_str();
    match partner {
        Some(partner) => Ok((kind, Some(partner))),
        None => Err(node.error("its boundary condition is Surface, but names no neighbour").help("solve the adjacency of the rooms again")),
    }
}
