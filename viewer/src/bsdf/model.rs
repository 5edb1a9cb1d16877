//! What the BSDF panel shows for which state.

use super::disc::{Projection, angles_of, direction, middle};
use crate::plot::value_text;
use crate::scale::ScaleChoice;
use glam::DVec3;
use lucarne::bins::shirley_chiu::{disk_from_square, square_from_disk};
use lucarne::bsdf::check::{Finding, check};
use lucarne::bsdf::{self, Block, Blocks, Bsdf, Component};
use lucarne::image::palette::Palette;
use lucarne::{Result, Warnings};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A file that was opened.
#[derive(Clone)]
pub struct BsdfFile {
    /// Where it came from.
    pub path: PathBuf,
    /// Its contents.
    pub bsdf: Arc<Bsdf>,
    /// What was noticed while reading.
    pub warnings: Warnings,
    /// Tells files apart in keys of caches.
    pub id: u64,
}

impl BsdfFile {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let mut warnings = Warnings::new();
        let bsdf = Arc::new(bsdf::read(path, &mut warnings)?);
        Ok(Self { path: path.to_path_buf(), bsdf, warnings, id: NEXT.fetch_add(1, Ordering::Relaxed) })
    }

    /// What to call it: its file name.
    pub fn name(&self) -> String {
        self.path.file_name().map_or_else(|| self.path.display().to_string(), |n| n.to_string_lossy().into_owned())
    }

    /// The doctor's verdicts.
    pub fn findings(&self) -> Vec<Finding> {
        check(&self.bsdf, &self.warnings)
    }

    /// The data of a band.
    pub fn blocks(&self, band: Band) -> &Blocks {
        match band {
            Band::Visible => &self.bsdf.visible,
            Band::Solar => &self.bsdf.solar,
        }
    }
}

/// Wavelength band.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Band {
    /// Visible light.
    Visible,
    /// The whole solar spectrum.
    Solar,
}

/// How two files are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compare {
    /// Both, with one scale.
    SideBySide,
    /// Second minus first.
    Difference,
}

/// Everything the user has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Band.
    pub band: Band,
    /// Component.
    pub component: Component,
    /// Direction in which the incident light travels: θ, φ in degrees.
    pub incident: [f64; 2],
    /// Projection of both discs.
    pub projection: Projection,
    /// Colour scale of the outgoing distribution.
    pub scale: ScaleChoice,
    /// Colours.
    pub palette: Palette,
    /// Patch numbers.
    pub numbers: bool,
    /// Patch outlines.
    pub grid: bool,
    /// Two files.
    pub compare: Compare,
    /// Turn of the lobe: yaw and pitch, radians.
    pub turn: [f32; 2],
}

impl Default for View {
    fn default() -> Self {
        Self {
            band: Band::Visible,
            component: Component::TransmissionFront,
            incident: [40.0, 270.0],
            projection: Projection::Equidistant,
            scale: ScaleChoice::automatic(true, 4.0),
            palette: Palette::Viridis,
            numbers: false,
            grid: true,
            compare: Compare::SideBySide,
            turn: [0.6, 0.35],
        }
    }
}

impl View {
    /// Chooses what a file has: its first band and component, and the middle of a patch.
    pub fn fit(&mut self, file: &BsdfFile) {
        if file.blocks(self.band).is_empty() {
            self.band = if file.blocks(Band::Visible).is_empty() { Band::Solar } else { Band::Visible };
        }
        if file.blocks(self.band).get(self.component).is_none()
            && let Some((component, _)) = file.blocks(self.band).iter().next()
        {
            self.component = component;
        }
        self.snap(file);
    }

    /// Moves the incident direction to the middle of its patch, where there are patches.
    pub fn snap(&mut self, file: &BsdfFile) {
        if let Some(Block::Klems(m)) = self.block(file) {
            self.incident = middle(m.incident(), m.incident().bin_of(direction(self.incident)));
        }
    }

    /// The data shown of a file.
    pub fn block<'f>(&self, file: &'f BsdfFile) -> Option<&'f Block> {
        file.blocks(self.band).get(self.component)
    }

    /// Steps to the next patch (or 5°) with the arrow keys: around the ring, or to another ring.
    pub fn step(&mut self, file: &BsdfFile, around: i32, outward: i32) {
        let [theta, phi] = self.incident;
        match self.block(file) {
            Some(Block::Klems(m)) => {
                let basis = m.incident();
                let (ring, position) = basis.ring_of(basis.bin_of(direction(self.incident)));
                if around != 0 {
                    let n = ring.bins as i32;
                    self.incident = middle(basis, ring.first + (position as i32 + around).rem_euclid(n) as usize);
                } else {
                    let index = basis.rings().iter().position(|r| r.first == ring.first).unwrap_or(0) as i32;
                    let other = (index + outward).clamp(0, basis.rings().len() as i32 - 1) as usize;
                    let ring = basis.rings()[other];
                    let middle_theta = (ring.theta_min + ring.theta_max) / 2.0;
                    self.incident = middle(basis, basis.bin_of(direction([middle_theta, phi])));
                }
            }
            _ => self.incident = [(theta + 5.0 * f64::from(outward)).clamp(0.0, 85.0), (phi + 5.0 * f64::from(around)).rem_euclid(360.0)],
        }
    }
}

/// What is known of one direction on a disc.
#[derive(Debug, Clone, PartialEq)]
pub struct Readout {
    /// Patch, from 1 as WINDOW counts; none for trees.
    pub patch: Option<usize>,
    /// θ, φ in degrees: of the pointer.
    pub angles: [f64; 2],
    /// Solid angle of the patch or cell, sr.
    pub solid_angle: Option<f64>,
    /// The value.
    pub value: f64,
}

impl Readout {
    /// The outgoing value in 1/sr at a direction.
    pub fn outgoing(block: &Block, incident: [f64; 2], angles: [f64; 2]) -> Self {
        let (i, o) = (direction(incident), direction(angles));
        let value = block.evaluate(o, i);
        match block {
            Block::Klems(m) => {
                let bin = m.outgoing().bin_of(o);
                Self { patch: Some(bin + 1), angles, solid_angle: Some(m.outgoing().solid_angle(bin)), value }
            }
            Block::Tree(_) => Self { patch: None, angles, solid_angle: None, value },
        }
    }

    /// The direct-hemispherical value for light from a direction.
    pub fn incident(block: &Block, angles: [f64; 2]) -> Self {
        let i = direction(angles);
        let value = block.direct_hemispherical(i);
        match block {
            Block::Klems(m) => {
                let bin = m.incident().bin_of(i);
                Self { patch: Some(bin + 1), angles, solid_angle: Some(m.incident().solid_angle(bin)), value }
            }
            Block::Tree(_) => Self { patch: None, angles, solid_angle: None, value },
        }
    }

    /// One line for the user.
    pub fn text(&self, what: &str, unit: &str) -> String {
        let patch = self.patch.map_or(String::new(), |p| format!("patch {p}   "));
        let solid = self.solid_angle.map_or(String::new(), |s| format!("Ω {s:.4} sr   "));
        format!("{patch}θ {:.1}°  φ {:.1}°   {solid}{what} {}{unit}", self.angles[0], self.angles[1], value_text(self.value))
    }
}

/// Largest outgoing value for one incident direction.
pub fn largest(block: &Block, incident: [f64; 2]) -> f64 {
    let i = direction(incident);
    match block {
        Block::Klems(m) => {
            let bin = m.incident().bin_of(i);
            (0..m.outgoing().len()).map(|o| m.at(o, bin)).fold(0.0, f64::max)
        }
        Block::Tree(_) => {
            let n = 128;
            let at = |k: usize| {
                let [x, y] = disk_from_square(((k / n) as f64 + 0.5) / n as f64, ((k % n) as f64 + 0.5) / n as f64);
                block.evaluate(DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()), i)
            };
            (0..n * n).into_par_iter().map(at).reduce(|| 0.0, f64::max)
        }
    }
}

/// Integrals of a block that take a moment for large trees.
#[derive(Debug, Clone)]
pub struct Integrals {
    /// Direct-hemispherical value over θ in degrees, mean over azimuths: the numbers of `bsdf info`.
    pub curve: Vec<[f64; 2]>,
    /// Hemispherical-hemispherical value.
    pub hemispherical: f64,
    map: Map,
    /// What the block is.
    pub description: String,
}

#[derive(Debug, Clone)]
enum Map {
    Bins(lucarne::bins::AngleBasis, Vec<f64>),
    Square(usize, Vec<f64>),
}

impl Integrals {
    /// Computes them.
    pub fn of(block: &Block) -> Self {
        let angles: Vec<f64> = (0..=17).map(|i| f64::from(i) * 5.0).chain([87.5]).collect();
        let curve = angles.into_par_iter().map(|theta| [theta, block.direct_hemispherical_at(theta)]).collect();
        let map = match block {
            Block::Klems(m) => Map::Bins(m.incident().clone(), m.all_direct_hemispherical()),
            Block::Tree(t) => {
                let n = t.resolution().clamp(1, 32);
                let at = |k: usize| {
                    let [x, y] = disk_from_square(((k / n) as f64 + 0.5) / n as f64, ((k % n) as f64 + 0.5) / n as f64);
                    block.direct_hemispherical(DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()))
                };
                Map::Square(n, (0..n * n).into_par_iter().map(at).collect())
            }
        };
        Self { curve, hemispherical: block.hemispherical(), map, description: block.describe() }
    }

    /// Direct-hemispherical value of light that travels along `d`.
    pub fn at(&self, d: DVec3) -> f64 {
        match &self.map {
            Map::Bins(basis, values) => values[basis.bin_of(d)],
            Map::Square(n, values) => {
                let [u, v] = square_from_disk(d.x, d.y);
                let cell = |t: f64| ((t * *n as f64) as usize).min(n - 1);
                values[cell(u) * n + cell(v)]
            }
        }
    }
}

/// The component of the other kind for light from the same side: the lobe shows both.
pub fn companion(component: Component) -> Component {
    match component {
        Component::TransmissionFront => Component::ReflectionFront,
        Component::TransmissionBack => Component::ReflectionBack,
        Component::ReflectionFront => Component::TransmissionFront,
        Component::ReflectionBack => Component::TransmissionBack,
    }
}

/// What light does in a component, in plain words.
pub fn plain_words(component: Component) -> &'static str {
    match component {
        Component::TransmissionFront => "from outside into the room",
        Component::TransmissionBack => "from the room to the outside",
        Component::ReflectionFront => "from outside back to the outside",
        Component::ReflectionBack => "from the room back into the room",
    }
}

/// A direction as text.
pub fn angles_text(angles: [f64; 2]) -> String {
    let [theta, phi] = angles_of(direction(angles));
    if theta < 1e-9 { "θ 0°".into() } else { format!("θ {theta:.1}°  φ {phi:.1}°") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str) -> BsdfFile {
        BsdfFile::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/office/bsdf").join(name)).unwrap()
    }

    #[test]
    fn the_curve_has_the_numbers_of_bsdf_info() {
        let f = file("blind.xml");
        let block = f.bsdf.visible.transmission_front.as_ref().unwrap();
        let integrals = Integrals::of(block);
        for [theta, value] in &integrals.curve {
            assert_eq!(*value, block.direct_hemispherical_at(*theta));
        }
        assert_eq!(integrals.hemispherical, block.hemispherical());
        assert_eq!(integrals.at(DVec3::Z), block.direct_hemispherical(DVec3::Z));
    }

    #[test]
    fn clicks_snap_to_patches_and_arrows_walk_over_them() {
        let f = file("blind.xml");
        let mut view = View { incident: [1.0, 77.0], ..View::default() };
        view.fit(&f);
        assert_eq!(view.incident, [0.0, 0.0], "patch 1 is the pole cap");
        view.step(&f, 0, 1);
        assert_eq!(view.incident[0], 10.0);
        view.step(&f, 1, 0);
        assert_eq!(view.incident, [10.0, 45.0]);
        view.step(&f, -1, 0);
        view.step(&f, 0, -1);
        assert_eq!(view.incident, [0.0, 0.0]);
        let block = view.block(&f).unwrap();
        let r = Readout::outgoing(block, view.incident, [2.0, 10.0]);
        assert_eq!((r.patch, r.value), (Some(1), block.as_klems().unwrap().at(0, 0)));
        assert!(r.text("f", " /sr").starts_with("patch 1   θ 2.0°  φ 10.0°   Ω 0.0239 sr   f "), "{}", r.text("f", " /sr"));
    }
}
