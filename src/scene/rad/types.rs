//! The types of objects in `.rad` files, by their words.

/// What the second word of an object says it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ObjectType {
    /// A shape this program cuts into triangles, or a distant source.
    Surface(Surface),
    /// A material this program knows.
    Material(MaterialType),
    /// A pattern, whose mean colours the material, or a texture, without which it stays usable.
    Texture(&'static str),
    /// Part of Radiance, but not of this program: (word, what to do instead).
    Unsupported(&'static str, &'static str),
}

/// Surface types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as in the files")]
pub(crate) enum Surface {
    Polygon,
    Ring,
    Sphere,
    Bubble,
    Cylinder,
    Tube,
    Cone,
    Cup,
    Source,
}

/// Material types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as in the files")]
pub(crate) enum MaterialType {
    Plastic,
    Metal,
    Trans,
    Glass,
    Mirror,
    Light,
    Glow,
    Spotlight,
    Illum,
    Plastic2,
    Metal2,
    Trans2,
    Ashik2,
    BrtdFunc,
    WgmdFunc,
    Dielectric,
    Interface,
    MixFunc,
}

const SURFACES: [(&str, Surface); 9] = [
    ("polygon", Surface::Polygon),
    ("ring", Surface::Ring),
    ("sphere", Surface::Sphere),
    ("bubble", Surface::Bubble),
    ("cylinder", Surface::Cylinder),
    ("tube", Surface::Tube),
    ("cone", Surface::Cone),
    ("cup", Surface::Cup),
    ("source", Surface::Source),
];

const MATERIALS: [(&str, MaterialType); 18] = [
    ("plastic", MaterialType::Plastic),
    ("metal", MaterialType::Metal),
    ("trans", MaterialType::Trans),
    ("glass", MaterialType::Glass),
    ("mirror", MaterialType::Mirror),
    ("light", MaterialType::Light),
    ("glow", MaterialType::Glow),
    ("spotlight", MaterialType::Spotlight),
    ("illum", MaterialType::Illum),
    ("plastic2", MaterialType::Plastic2),
    ("metal2", MaterialType::Metal2),
    ("trans2", MaterialType::Trans2),
    ("ashik2", MaterialType::Ashik2),
    ("BRTDfunc", MaterialType::BrtdFunc),
    ("WGMDfunc", MaterialType::WgmdFunc),
    ("dielectric", MaterialType::Dielectric),
    ("interface", MaterialType::Interface),
    ("mixfunc", MaterialType::MixFunc),
];

const TEXTURES: [&str; 14] = [
    "texfunc",
    "texdata",
    "colorfunc",
    "brightfunc",
    "colordata",
    "brightdata",
    "colorpict",
    "colortext",
    "brighttext",
    "spectrum",
    "specfile",
    "specfunc",
    "specdata",
    "specpict",
];

const FUNCTION: &str = "replace it by a `plastic`, `metal` or `trans` that fits its mean behaviour";
const REFRACTING: &str = "replace panes by one polygon of `glass`, or make the surface a window with a BSDF file";
const SCATTERING: &str = "make the surface a window with its BSDF file, or replace it by its geometry or a `trans`";
const MIXTURE: &str = "replace it by one material of mean reflectance";
const UNSUPPORTED: [(&str, &str); 17] = [
    ("plasfunc", FUNCTION),
    ("metfunc", FUNCTION),
    ("transfunc", FUNCTION),
    ("plasdata", FUNCTION),
    ("metdata", FUNCTION),
    ("transdata", FUNCTION),
    ("prism1", REFRACTING),
    ("prism2", REFRACTING),
    ("BSDF", SCATTERING),
    ("aBSDF", SCATTERING),
    ("mist", "take the volume out of the scene"),
    ("antimatter", "cut the opening into the polygons that it takes away from, or write them with the hole as a seam"),
    ("mixdata", MIXTURE),
    ("mixpict", MIXTURE),
    ("mixtext", MIXTURE),
    ("instance", "an octree is not read: give the `.rad` files that it was made from, placed with `!xform`"),
    (
        "mesh",
        "a compiled mesh is not read: give the OBJ file that `obj2mesh` made it from among the scene's files; its materials are those of the .rad files",
    ),
];

impl ObjectType {
    /// The type a word names.
    pub(crate) fn from_word(word: &str) -> Option<Self> {
        let surface = SURFACES.iter().find(|(w, _)| *w == word).map(|&(_, s)| Self::Surface(s));
        let material = || MATERIALS.iter().find(|(w, _)| *w == word).map(|&(_, m)| Self::Material(m));
        let texture = || TEXTURES.iter().find(|w| **w == word).map(|w| Self::Texture(w));
        let unsupported = || UNSUPPORTED.iter().find(|(w, _)| *w == word).map(|&(w, help)| Self::Unsupported(w, help));
        surface.or_else(material).or_else(texture).or_else(unsupported)
    }

    /// The word that was probably meant.
    pub(crate) fn nearest_word(word: &str) -> Option<&'static str> {
        let words = [&SURFACES.map(|(w, _)| w)[..], &MATERIALS.map(|(w, _)| w), &TEXTURES, &UNSUPPORTED.map(|(w, _)| w)].concat();
        words.into_iter().map(|w| (edit_distance(w, word), w)).min().filter(|(d, _)| *d <= 2).map(|(_, w)| w)
    }

    /// Its word in the files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Surface(s) => SURFACES.iter().find(|(_, t)| *t == s).map_or("", |(w, _)| w),
            Self::Material(m) => MATERIALS.iter().find(|(_, t)| *t == m).map_or("", |(w, _)| w),
            Self::Texture(w) | Self::Unsupported(w, _) => w,
        }
    }

    /// Whether it is a material that gives light of its own.
    pub fn emits(self) -> bool {
        matches!(self, Self::Material(MaterialType::Light | MaterialType::Glow | MaterialType::Spotlight | MaterialType::Illum))
    }

    /// Whether other objects can name it as their modifier.
    pub(crate) fn is_modifier(self) -> bool {
        !matches!(self, Self::Surface(_) | Self::Unsupported("instance" | "mesh", _))
    }
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(40).flat_map(char::to_lowercase).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().flat_map(char::to_lowercase).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
