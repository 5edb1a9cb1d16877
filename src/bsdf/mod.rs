//! Bidirectional scattering distribution functions of windows: reading, checking, making, converting.
//!
//! # Which side is "front"
//! Names here are those of WINDOW's XML files, for a window whose z axis points **into the room**:
//!
//! | in the file (WINDOW) | light comes from | goes to | Radiance's own name |
//! |---|---|---|---|
//! | Transmission Front | outside | room | `tb` |
//! | Transmission Back | room | outside | `tf` |
//! | Reflection Front | outside | outside | `rb` |
//! | Reflection Back | room | room | `rf` |
//!
//! WINDOW's *front* is the outside; Radiance's *front* is the side to which the normal points, the
//! room. Daylight that enters uses **Transmission Front**.
//!
//! # Directions, units
//! Values are BTDF or BRDF in 1/sr. Every direction, incident or outgoing, is the direction in which
//! light **travels**, in the window's frame ([`crate::bins::Frame`]); only its x and y count, the
//! component tells the side. See [`crate::bins::AngleBasis`] for the consequence.

pub mod blinds;
pub mod check;
pub mod difference;
pub mod evaluate;
pub mod glass;
pub mod iea21;
pub mod interpolant;
pub mod interpolate;
pub mod isotropic;
mod klems;
pub mod layer;
mod numbers;
mod overlap;
pub(crate) mod peak;
mod read;
pub mod resample;
pub(crate) mod sample;
pub mod scans;
pub mod screen;
pub mod spectrum;
mod transmission;
mod tree;
mod write;

pub use klems::KlemsMatrix;
pub use read::read;
pub use read::read_from;
pub use transmission::{TransmissionSource, transmission_matrix, transmission_source};
pub use tree::Cell;
pub(crate) use tree::PACKED_BRANCH;
pub use tree::TensorTree;
pub use write::write;
pub use write::write_to;

use crate::bins::AngleBasis;
use glam::DVec3;

/// The scattering data of a window system or a layer, as one XML file holds them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bsdf {
    /// Name of the material or system.
    pub name: String,
    /// Who makes it.
    pub manufacturer: String,
    /// WINDOW's class, for instance `Venetian Blind` or `Other`.
    pub device_type: String,
    /// Thickness, m.
    pub thickness: Option<f64>,
    /// Width, m.
    pub width: Option<f64>,
    /// Height, m.
    pub height: Option<f64>,
    /// Other properties of the material as (element, text), in the file's order: thermal
    /// conductivity, emissivities, openness.
    pub properties: Vec<(String, String)>,
    /// Geometry that stands in for the data in direct views.
    pub geometry: Option<Geometry>,
    /// Visible light: wavelength `Visible`, the CIE Y of coloured files. Simulations use this one.
    pub visible: Blocks,
    /// Wavelength `Solar`.
    pub solar: Blocks,
    /// Wavelength `CIE-X` (matrices) of coloured files.
    pub cie_x: Blocks,
    /// Wavelength `CIE-Z` (matrices) of coloured files.
    pub cie_z: Blocks,
    /// Wavelength `CIE-u` (trees) of coloured files.
    pub cie_u: Blocks,
    /// Wavelength `CIE-v` (trees) of coloured files.
    pub cie_v: Blocks,
    /// Names of wavelengths that the file has and that are not kept (thermal infrared, single
    /// wavelengths).
    pub skipped: Vec<String>,
}

/// Geometry embedded in a file (MGF text).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Geometry {
    /// Value of the attribute `format`, usually `MGF`.
    pub format: String,
    /// Unit of its lengths as written.
    pub unit: String,
    /// The text itself.
    pub text: String,
}

/// One of the four ways light can take, named as in WINDOW's files; see the [module](self).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Component {
    /// From outside into the room.
    TransmissionFront,
    /// From the room to the outside.
    TransmissionBack,
    /// From outside back to the outside.
    ReflectionFront,
    /// From the room back into the room.
    ReflectionBack,
}

impl Component {
    /// All four, in the order of WINDOW's files.
    pub const ALL: [Component; 4] =
        [Component::TransmissionFront, Component::TransmissionBack, Component::ReflectionFront, Component::ReflectionBack];

    /// The words of `WavelengthDataDirection`.
    pub fn xml_name(self) -> &'static str {
        match self {
            Component::TransmissionFront => "Transmission Front",
            Component::TransmissionBack => "Transmission Back",
            Component::ReflectionFront => "Reflection Front",
            Component::ReflectionBack => "Reflection Back",
        }
    }

    /// The component these words mean, ignoring case and extra blanks.
    pub fn by_xml_name(words: &str) -> Option<Self> {
        let plain = words.split_whitespace().collect::<Vec<_>>().join(" ");
        Component::ALL.into_iter().find(|c| c.xml_name().eq_ignore_ascii_case(&plain))
    }

    /// Whether light passes to the other side.
    pub fn is_transmission(self) -> bool {
        matches!(self, Component::TransmissionFront | Component::TransmissionBack)
    }

    /// Whether light comes from the outside.
    pub fn is_front(self) -> bool {
        matches!(self, Component::TransmissionFront | Component::ReflectionFront)
    }

    /// The component of light that travels the same paths backwards: the other transmission, or
    /// the same reflection.
    pub fn reciprocal(self) -> Self {
        match self {
            Component::TransmissionFront => Component::TransmissionBack,
            Component::TransmissionBack => Component::TransmissionFront,
            reflection => reflection,
        }
    }
}

impl Bsdf {
    /// All bands with their names in the file.
    pub fn bands(&self) -> [(&'static str, &Blocks); 6] {
        [
            ("Visible", &self.visible),
            ("Solar", &self.solar),
            ("CIE-X", &self.cie_x),
            ("CIE-Z", &self.cie_z),
            ("CIE-u", &self.cie_u),
            ("CIE-v", &self.cie_v),
        ]
    }

    /// The band of this name, if it is one that is kept (case does not matter).
    pub fn band_mut(&mut self, name: &str) -> Option<&mut Blocks> {
        match name.to_ascii_lowercase().as_str() {
            "visible" => Some(&mut self.visible),
            "solar" => Some(&mut self.solar),
            "cie-x" => Some(&mut self.cie_x),
            "cie-z" => Some(&mut self.cie_z),
            "cie-u" => Some(&mut self.cie_u),
            "cie-v" => Some(&mut self.cie_v),
            _ => None,
        }
    }
}

/// The components of one wavelength band that a file has.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Blocks {
    /// From outside into the room.
    pub transmission_front: Option<Block>,
    /// From the room to the outside.
    pub transmission_back: Option<Block>,
    /// From outside back to the outside.
    pub reflection_front: Option<Block>,
    /// From the room back into the room.
    pub reflection_back: Option<Block>,
}

impl Blocks {
    /// The block of a component.
    pub fn get(&self, component: Component) -> Option<&Block> {
        match component {
            Component::TransmissionFront => self.transmission_front.as_ref(),
            Component::TransmissionBack => self.transmission_back.as_ref(),
            Component::ReflectionFront => self.reflection_front.as_ref(),
            Component::ReflectionBack => self.reflection_back.as_ref(),
        }
    }

    /// The place of a component's block.
    pub fn slot(&mut self, component: Component) -> &mut Option<Block> {
        match component {
            Component::TransmissionFront => &mut self.transmission_front,
            Component::TransmissionBack => &mut self.transmission_back,
            Component::ReflectionFront => &mut self.reflection_front,
            Component::ReflectionBack => &mut self.reflection_back,
        }
    }

    /// The components that are present, in the order of [`Component::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Component, &Block)> {
        Component::ALL.into_iter().filter_map(|c| Some((c, self.get(c)?)))
    }

    /// Whether no component is present.
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The value in 1/sr for light travelling along `incident` that leaves along `outgoing`; where
    /// a transmission is missing, the other one by reciprocity. `None` if neither is there.
    pub fn evaluate(&self, component: Component, outgoing: DVec3, incident: DVec3) -> Option<f64> {
        match self.get(component) {
            Some(block) => Some(block.evaluate(outgoing, incident)),
            None => Some(self.get(component.reciprocal())?.evaluate(-incident, -outgoing)),
        }
    }
}

/// The data of one component in one band.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A matrix over two angle bases.
    Klems(KlemsMatrix),
    /// A tensor tree.
    Tree(TensorTree),
}

impl Block {
    /// The value in 1/sr for light travelling along `incident` that leaves along `outgoing`
    /// (unit vectors in the window's frame): the value of the bin or cell, not interpolated.
    pub fn evaluate(&self, outgoing: DVec3, incident: DVec3) -> f64 {
        match self {
            Block::Klems(m) => m.at(m.outgoing().bin_of(outgoing), m.incident().bin_of(incident)),
            Block::Tree(t) => t.evaluate(outgoing, incident),
        }
    }

    /// Direct-hemispherical transmittance or reflectance of light travelling along `incident`.
    pub fn direct_hemispherical(&self, incident: DVec3) -> f64 {
        match self {
            Block::Klems(m) => m.direct_hemispherical(m.incident().bin_of(incident)),
            Block::Tree(t) => t.direct_hemispherical(incident),
        }
    }

    /// Direct-hemispherical value at a polar angle, the mean over all azimuths.
    pub fn direct_hemispherical_at(&self, theta_deg: f64) -> f64 {
        // A multiple of the azimuth counts of the Klems bases: the mean over their bins is exact.
        const AZIMUTHS: usize = 240;
        let (sin, cos) = theta_deg.to_radians().sin_cos();
        let values = (0..AZIMUTHS).map(|k| {
            let phi = std::f64::consts::TAU * (k as f64 + 0.5) / AZIMUTHS as f64;
            self.direct_hemispherical(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos))
        });
        values.sum::<f64>() / AZIMUTHS as f64
    }

    /// Hemispherical-hemispherical transmittance or reflectance (uniform diffuse incidence).
    pub fn hemispherical(&self) -> f64 {
        match self {
            Block::Klems(m) => m.hemispherical(),
            Block::Tree(t) => t.hemispherical(),
        }
    }

    /// What the block is, in words: basis and size.
    pub fn describe(&self) -> String {
        match self {
            Block::Klems(m) if m.incident() == m.outgoing() => format!("{} ({} bins)", m.incident().name(), m.incident().len()),
            Block::Klems(m) => format!(
                "{} ({} bins) incident, {} ({} bins) outgoing",
                m.incident().name(),
                m.incident().len(),
                m.outgoing().name(),
                m.outgoing().len()
            ),
            Block::Tree(t) => format!("tensor tree, rank {}, up to {} cells per side", t.rank(), t.resolution()),
        }
    }

    /// The matrix, if it is one.
    pub fn as_klems(&self) -> Option<&KlemsMatrix> {
        match self {
            Block::Klems(m) => Some(m),
            Block::Tree(_) => None,
        }
    }
}

/// The projected solid angles of all bins of a basis, sr; their sum is π.
pub fn projected_solid_angles(basis: &AngleBasis) -> Vec<f64> {
    (0..basis.len()).map(|bin| basis.projected_solid_angle(bin)).collect()
}

#[cfg(test)]
mod tests;
