//! Modifiers of surfaces: Honeybee's own, those of a room's set, the generic ones.

use super::json::Node;
use crate::bins::{AngleBasis, KlemsBasis};
use crate::bsdf::{self, Bsdf};
use crate::error::{Error, Result, Warnings};
use crate::scene::pane::REFRACTION_INDEX;
use crate::scene::{MaterialKind, rad};
use glam::DVec3;
use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What a modifier comes to.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// A material that the tracer knows.
    Material(MaterialKind),
    /// Scattering data, held by the model itself.
    Bsdf {
        /// Up vector of its angles.
        up: DVec3,
        /// Its basis, in rfluxmtx's words: `kf`, `kh` or `kq`.
        basis: &'static str,
        /// Where they are.
        data: PathBuf,
    },
}

/// A modifier with its name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Modifier {
    pub identifier: String,
    pub kind: Kind,
}

impl Modifier {
    /// Up vector and basis of scattering data.
    pub fn directions(&self) -> Option<(DVec3, &'static str)> {
        if let Kind::Bsdf { up, basis, .. } = self.kind { Some((up, basis)) } else { None }
    }
}

/// Where a surface stands, which says what its modifier is if it has none of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Wall {
        outdoors: bool,
    },
    Floor {
        outdoors: bool,
    },
    RoofCeiling {
        outdoors: bool,
    },
    Aperture {
        outdoors: bool,
        operable: bool,
        in_wall: bool,
    },
    Door {
        outdoors: bool,
        glass: bool,
        in_wall: bool,
    },
    Shade {
        indoor: bool,
    },
    /// A shade that stands apart: surrounding buildings, trees.
    Context,
}

impl Role {
    /// Keys of a modifier set, and the generic modifier there.
    fn place(self) -> (&'static str, &'static str, &'static str) {
        let side = |outdoors: bool| if outdoors { "exterior_modifier" } else { "interior_modifier" };
        match self {
            Self::Wall { outdoors } => ("wall_set", side(outdoors), "generic_wall_0.50"),
            Self::Floor { outdoors } => ("floor_set", side(outdoors), "generic_floor_0.20"),
            Self::RoofCeiling { outdoors } => ("roof_ceiling_set", side(outdoors), "generic_ceiling_0.80"),
            Self::Aperture { outdoors: false, .. } => ("aperture_set", "interior_modifier", INTERIOR_PANE),
            Self::Aperture { operable: true, .. } => ("aperture_set", "operable_modifier", EXTERIOR_PANE),
            Self::Aperture { in_wall: true, .. } => ("aperture_set", "window_modifier", EXTERIOR_PANE),
            Self::Aperture { .. } => ("aperture_set", "skylight_modifier", EXTERIOR_PANE),
            Self::Door { outdoors: false, glass: true, .. } => ("door_set", "interior_glass_modifier", INTERIOR_PANE),
            Self::Door { glass: true, .. } => ("door_set", "exterior_glass_modifier", EXTERIOR_PANE),
            Self::Door { outdoors: false, .. } => ("door_set", "interior_modifier", OPAQUE_DOOR),
            Self::Door { in_wall: true, .. } => ("door_set", "exterior_modifier", OPAQUE_DOOR),
            Self::Door { .. } => ("door_set", "overhead_modifier", OPAQUE_DOOR),
            Self::Shade { indoor: true } => ("shade_set", "interior_modifier", "generic_interior_shade_0.50"),
            Self::Shade { indoor: false } => ("shade_set", "exterior_modifier", "generic_exterior_shade_0.35"),
            Self::Context => ("", "", "generic_context_0.20"),
        }
    }
}

/// Bases of windows in rfluxmtx's words.
const KLEMS: [(KlemsBasis, &str); 3] = [(KlemsBasis::Full, "kf"), (KlemsBasis::Half, "kh"), (KlemsBasis::Quarter, "kq")];

const INTERIOR_PANE: &str = "generic_interior_window_vis_0.88";
const EXTERIOR_PANE: &str = "generic_exterior_window_vis_0.64";
const OPAQUE_DOOR: &str = "generic_opaque_door_0.50";

/// Reflectance or, of panes, transmissivity of Honeybee's generic modifiers, by name: the numbers that
/// honeybee-radiance 1.66 writes for a model without modifiers.
const GENERIC: [(&str, f64, bool); 16] = [
    ("generic_floor_0.20", 0.2, false),
    ("generic_wall_0.50", 0.5, false),
    ("generic_ceiling_0.80", 0.8, false),
    (OPAQUE_DOOR, 0.5, false),
    ("generic_interior_shade_0.50", 0.5, false),
    ("generic_exterior_shade_0.35", 0.35, false),
    ("generic_context_0.20", 0.2, false),
    ("generic_floor_exterior_side_0.50", 0.5, false),
    ("generic_wall_exterior_side_0.35", 0.35, false),
    ("generic_ceiling_exterior_side_0.35", 0.35, false),
    ("black", 0.0, false),
    (INTERIOR_PANE, 0.958_415_432_861_059_6, true),
    (EXTERIOR_PANE, 0.697_576_181_538_433_1, true),
    ("generic_exterior_screened_window_vis_0.32", 0.349_018_950_910_318_54, true),
    ("generic_exterior_window_sol_0.37", 0.403_523_157_288_518_2, true),
    ("generic_interior_window_sol_0.77", 0.838_940_544_725_175_7, true),
];

fn generic(name: &str) -> Option<MaterialKind> {
    let (_, value, glass) = GENERIC.iter().find(|(n, ..)| *n == name)?;
    Some(if *glass {
        MaterialKind::Glass { transmissivity: [*value; 3], refraction_index: REFRACTION_INDEX }
    } else {
        MaterialKind::Plastic { color: [*value; 3], specularity: 0.0, roughness: 0.0 }
    })
}

/// All modifiers and modifier sets of a model.
pub(super) struct Modifiers<'a> {
    file: &'a Path,
    modifiers: HashMap<&'a str, Node<'a>>,
    sets: HashMap<&'a str, Node<'a>>,
    /// Metres per unit of the model.
    scale: f64,
    /// Those that were asked for, by name; those without a name in the list are made anew.
    made: RefCell<HashMap<String, Rc<Modifier>>>,
}

impl<'a> Modifiers<'a> {
    /// # Errors
    /// Modifiers without identifier, lists that are none.
    pub fn read(model: &Node<'a>, file: &'a Path, scale: f64) -> Result<Self> {
        let mut all = Self { file, modifiers: HashMap::new(), sets: HashMap::new(), scale, made: RefCell::default() };
        let Some(radiance) = radiance(model)? else { return Ok(all) };
        let global = radiance.object("global_modifier_set")?.map(|g| g.list("modifiers")).transpose()?.unwrap_or_default();
        for modifier in global.into_iter().chain(radiance.list("modifiers")?) {
            all.modifiers.insert(modifier.identifier()?, modifier);
        }
        for set in radiance.list("modifier_sets")? {
            all.sets.insert(set.identifier()?, set);
        }
        Ok(all)
    }

    /// The modifier set of a room, by name or in place; `None` for Honeybee's generic one.
    ///
    /// # Errors
    /// A set that the model does not hold.
    pub fn set_of(&self, room: &Node<'a>) -> Result<Option<Node<'a>>> {
        let Some(radiance) = radiance(room)? else { return Ok(None) };
        let Some(set) = radiance.get("modifier_set") else { return Ok(None) };
        let Some(name) = set.value.as_str() else { return Ok(Some(set)) };
        if let Some(set) = self.sets.get(name) {
            return Ok(Some(set.clone()));
        }
        // Honeybee's generic set is in no list.
        if name == "Generic_Interior_Visible_Modifier_Set" {
            return Ok(None);
        }
        Err(room.error(format!("there is no modifier set '{name}' in the model")).help("export the model again, with its modifier sets"))
    }

    /// The modifier of a surface: its own, that of its room's set, or Honeybee's generic one.
    ///
    /// # Errors
    /// Modifiers that the model does not hold or this program does not know.
    pub fn of(&self, object: &Node<'a>, set: Option<&Node<'a>>, role: Role, warnings: &mut Warnings) -> Result<Rc<Modifier>> {
        if let Some(own) = radiance(object)?.and_then(|r| r.get("modifier")) {
            return self.find(&own, object, warnings);
        }
        let (group, key, fallback) = role.place();
        let of_set = match set {
            Some(set) => set.object(group)?.and_then(|g| g.get(key)),
            None => None,
        };
        match of_set {
            Some(modifier) => self.find(&modifier, object, warnings),
            None => self.named(fallback, object, warnings),
        }
    }

    /// A modifier where it is named, or stands in place.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn find(&self, modifier: &Node<'a>, object: &Node<'a>, warnings: &mut Warnings) -> Result<Rc<Modifier>> {
        match modifier.value.as_str() {
            Some(name) => self.named(name, object, warnings),
            None => self.make(modifier, warnings).map(Rc::new),
        }
    }

    fn named(&self, name: &str, object: &Node<'a>, warnings: &mut Warnings) -> Result<Rc<Modifier>> {
        if let Some(known) = self.made.borrow().get(name) {
            return Ok(Rc::clone(known));
        }
        let made = match self.modifiers.get(name) {
            Some(node) => self.make(node, warnings)?,
            None => match generic(name) {
                Some(kind) => Modifier { identifier: name.to_string(), kind: Kind::Material(kind) },
                None => {
                    return Err(object
                        .error(format!("there is no modifier '{name}' in the model"))
                        .help("export the model again, with its modifiers (properties.radiance.modifiers)"));
                }
            },
        };
        let made = Rc::new(made);
        self.made.borrow_mut().insert(name.to_string(), Rc::clone(&made));
        Ok(made)
    }

    fn make(&self, node: &Node<'a>, warnings: &mut Warnings) -> Result<Modifier> {
        let kind = match kind_of(node)? {
            "Void" => Kind::Material(MaterialKind::Void),
            "BSDF" | "aBSDF" => {
                if node.text("bsdf_data")?.is_none_or(|data| !data.contains('<')) {
                    return Err(node.error("'bsdf_data' holds no XML").help("export the model again, with the BSDF in it"));
                }
                if node.number("thickness")?.is_some_and(|t| t != 0.0) {
                    let told = node.error("the thickness of this BSDF has no effect: the geometry it stands for is not looked for");
                    warnings.push(told.help("give the window a shade = \"….rad\" in a project file, or set the thickness to 0"));
                }
                let mut heard = Warnings::new();
                let data = bsdf::read_from(node.required_text("bsdf_data")?.as_bytes(), &mut heard);
                let basis = data.and_then(|d| basis_of(&d)).map_err(|e| node.at(e))?;
                let data = PathBuf::from(format!("{}#{}", self.file.display(), node.identifier()?));
                Kind::Bsdf { up: node.vector("up_orientation")?.unwrap_or(DVec3::new(0.01, 0.01, 1.0)), basis, data }
            }
            _ => {
                let mut text = String::new();
                definition(node, &mut text)?;
                let mut heard = Warnings::new();
                let kind = rad::material(&text, Path::new("modifier"), &mut heard);
                heard.iter().for_each(|w| warnings.push(node.error(w.message())));
                let mut kind =
                    kind.map_err(|e| node.error(e.message()).help("correct the modifier in Honeybee and export the model again"))?;
                if let MaterialKind::Glow { max_radius, .. } = &mut kind {
                    *max_radius *= self.scale;
                }
                Kind::Material(kind)
            }
        };
        let identifier = if node.get("identifier").is_some() { node.identifier()? } else { "void" };
        Ok(Modifier { identifier: identifier.to_string(), kind })
    }
}

/// The basis of scattering data, in rfluxmtx's words.
///
/// # Errors
/// Data without visible transmission, or of other directions.
pub(crate) fn basis_of(data: &Bsdf) -> Result<&'static str> {
    let bins = bsdf::transmission_matrix(data)?.rows();
    let named = KLEMS.into_iter().find(|(basis, _)| AngleBasis::from(*basis).len() == bins);
    named.map(|(_, word)| word).ok_or_else(|| {
        Error::new(format!("the scattering data have {bins} directions, which is no Klems basis")).help("use Klems full, half or quarter")
    })
}

/// The radiance properties of an object.
pub(super) fn radiance<'a>(object: &Node<'a>) -> Result<Option<Node<'a>>> {
    match object.object("properties")? {
        Some(properties) => properties.object("radiance"),
        None => Ok(None),
    }
}

/// Types of modifiers that are known.
const KINDS: [&str; 10] = ["Plastic", "Metal", "Trans", "Glass", "BSDF", "aBSDF", "Mirror", "Light", "Glow", "Void"];

/// The type of a modifier. Schemas of version 1 have some in small letters.
fn kind_of<'a>(node: &Node<'a>) -> Result<&'a str> {
    let kind = node.required_text("type")?;
    Ok(KINDS.into_iter().find(|known| known.eq_ignore_ascii_case(kind)).unwrap_or(kind))
}

/// The definition of a material as a `.rad` file has it, after those it depends on. Blanks that the schema allows
/// nowhere would end a name.
fn definition(node: &Node<'_>, text: &mut String) -> Result<()> {
    let name = node.identifier()?.replace(char::is_whitespace, "_");
    if let Some(own) = node.object("modifier")?
        && own.get("type").is_some()
        && kind_of(&own)? != "Void"
    {
        let what = own.required_text("type")?;
        return Err(node
            .error(format!("this material is modified by a {what}: patterns and textures are not known here"))
            .help("give the material without its modifier: the mean of a pattern, or the plain material under a texture"));
    }
    let channels = |quantity: &str, default: f64| -> Result<String> {
        let value = |c: &str| Ok::<f64, Error>(node.number(&format!("{c}_{quantity}"))?.unwrap_or(default));
        Ok(format!("{} {} {}", value("r")?, value("g")?, value("b")?))
    };
    let number = |key: &str, default: f64| -> Result<f64> { Ok(node.number(key)?.unwrap_or(default)) };
    let kind = kind_of(node)?;
    let (word, strings, reals) = match kind {
        "Plastic" => (
            "plastic",
            String::new(),
            format!("5 {} {} {}", channels("reflectance", 0.0)?, number("specularity", 0.0)?, number("roughness", 0.0)?),
        ),
        "Metal" => (
            "metal",
            String::new(),
            format!("5 {} {} {}", channels("reflectance", 0.0)?, number("specularity", 0.9)?, number("roughness", 0.0)?),
        ),
        "Trans" => {
            let (diffuse, specular) = (number("transmitted_diff", 0.0)?, number("transmitted_spec", 0.0)?);
            let surface = format!("{} {} {}", channels("reflectance", 0.0)?, number("specularity", 0.0)?, number("roughness", 0.0)?);
            ("trans", String::new(), format!("7 {surface} {diffuse} {specular}"))
        }
        "Glass" => match node.number("refraction_index")? {
            Some(index) => ("glass", String::new(), format!("4 {} {index}", channels("transmissivity", 0.0)?)),
            None => ("glass", String::new(), format!("3 {}", channels("transmissivity", 0.0)?)),
        },
        "Mirror" => {
            let strings = match node.object("alternate_material")? {
                Some(other) if kind_of(&other)? == "Void" => "1 void".to_string(),
                Some(other) => {
                    definition(&other, text)?;
                    format!("1 {}", other.identifier()?.replace(char::is_whitespace, "_"))
                }
                None => String::new(),
            };
            ("mirror", strings, format!("3 {}", channels("reflectance", 1.0)?))
        }
        "Light" => ("light", String::new(), format!("3 {}", channels("emittance", 0.0)?)),
        "Glow" => ("glow", String::new(), format!("4 {} {}", channels("emittance", 0.0)?, number("max_radius", 0.0)?)),
        other => {
            return Err(node
                .error(format!("modifiers of type '{}' are not known here", rad::shortened(other)))
                .help("known are Plastic, Metal, Trans, Glass, BSDF, Mirror, Light, Glow and Void"));
        }
    };
    let strings = if strings.is_empty() { "0" } else { &strings };
    let _ = writeln!(text, "void {word} {name} {strings} 0 {reals}");
    Ok(())
}
