//! What fills a window: scattering data of a file, a clear pane, or layers; and T of it.
//!
//! A pane's T is diagonal: light leaves in the bin in which it comes, weakened by the mean of the glass formula
//! ([`Pane::at`]) over the bin's ring. Layers are put together as `lucarne bsdf layer` does.

use crate::bins::{AngleBasis, KlemsBasis};
use crate::bsdf::evaluate::Scattering;
use crate::bsdf::interpolate::interpolate;
use crate::bsdf::isotropic::{AngularTable, Sample};
use crate::bsdf::layer::{LayerWords, combine_visible, read_layers};
use crate::bsdf::{self, Bsdf};
use crate::error::{Error, Result, Warnings};
use crate::kernels::sun_matrix::pane::PaneBsdf;
use crate::matrix::Matrix;
use crate::scene::{Pane, Scene, Window};
use crate::simulate::project::{Filling, Project, WindowSection};
use crate::simulate::store::fingerprint::Fingerprint;
use std::path::{Path, PathBuf};

/// What fills a window, read.
#[derive(Debug, Clone)]
pub(crate) enum Filled {
    /// Scattering data and the file they come from.
    Data(Bsdf, PathBuf),
    /// A clear pane.
    Glass(Pane),
    /// The data of layers.
    Layers(Bsdf),
}

impl Filled {
    /// Reads what a section says of a window whose panes in the scene are still there: of `glass = "scene"` they are
    /// taken out.
    ///
    /// # Errors
    /// Faulty files and layers; a window without glass in the scene.
    pub(super) fn read(
        project: &Project,
        section: &WindowSection,
        window: &Window,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) -> Result<Self> {
        match &section.filling {
            Filling::Glass(transmittance) => Pane::of_transmittance([*transmittance; 3]).map(Self::Glass).map_err(|e| section.place.of(e)),
            Filling::Pane(pane) => Ok(Self::Glass(*pane)),
            Filling::SceneGlass => of_scene(project, section, window, scene).map(Self::Glass),
            _ => Self::data(project, section, &window.basis, warnings),
        }
    }

    /// The same of sections that need no scene.
    fn data(project: &Project, section: &WindowSection, basis: &AngleBasis, warnings: &mut Warnings) -> Result<Self> {
        match &section.filling {
            Filling::Layers(words) => {
                let mut system = |folder: &Path| {
                    let LayerWords { layers, thickness } = read_layers(words, folder, warnings)?;
                    Ok(Bsdf { thickness, ..combine_visible(&layers, basis)?.bsdf })
                };
                system(project.folder()).map(Self::Layers).map_err(|e: Error| section.place.of(e))
            }
            Filling::Interpolated([from, to], fraction) => {
                let [a, b] = [bsdf::read(from, warnings)?, bsdf::read(to, warnings)?];
                let between = interpolate(&a, &b, *fraction, warnings).map_err(|e| section.place.of(e))?;
                Ok(Self::Data(between, from.clone()))
            }
            _ => {
                let file = section.filling.files().first().cloned().unwrap_or_default();
                Ok(Self::Data(bsdf::read(&file, warnings)?, file))
            }
        }
    }

    /// T, RGB, over a basis: that of the data, for panes and layers the one asked for.
    ///
    /// # Errors
    /// Data without visible transmission.
    pub(super) fn transmission(&self, basis: &AngleBasis) -> Result<Matrix<f64>> {
        match self {
            Self::Glass(pane) => pane_transmission(pane, basis),
            Self::Data(data, file) => bsdf::transmission_matrix(data).map(in_colour).map_err(|e| e.file(file)),
            Self::Layers(data) => bsdf::transmission_matrix(data).map(in_colour),
        }
    }

    /// What suns are traced through where the project names nothing else: the clear view through layers of glass.
    ///
    /// # Errors
    /// Data that cannot be sampled.
    pub(super) fn pane(&self, project: &Project, section: &WindowSection, warnings: &mut Warnings) -> Result<Option<PaneBsdf>> {
        match self {
            Self::Glass(_) => Ok(None),
            Self::Data(data, file) => checked(data, file, warnings).map(|_| None),
            Self::Layers(data) => {
                let scattering = checked(data, &project.file, warnings).map_err(|e| section.place.of(e))?;
                let sees_sun = section.filling.is_clear() && !section.names_what_suns_pass();
                Ok(sees_sun.then_some(PaneBsdf::PeakBsdf(scattering)))
            }
        }
    }

    /// Its own scattering data, as suns meet them.
    ///
    /// # Errors
    /// A clear pane; data that cannot be sampled, or without visible transmission.
    pub(super) fn scattering(&self, project: &Path) -> Result<Scattering> {
        let (data, file) = match self {
            Self::Data(data, file) => (data, file.as_path()),
            Self::Layers(data) => (data, project),
            Self::Glass(_) => return Err(Error::new("a clear pane has no scattering data of its own")),
        };
        // `pane` warns of them.
        checked(data, file, &mut Warnings::new())
    }

    /// What the sun depends on that meets its own data.
    pub(super) fn inputs(&self, sees_peak: bool) -> Fingerprint {
        let mut inputs = Fingerprint::new("own pane");
        if let Self::Data(data, _) | Self::Layers(data) = self {
            inputs.add(&data.visible);
        }
        *inputs.add(&sees_peak)
    }

    /// What it is, for people.
    pub(super) fn describe(&self, section: &WindowSection) -> String {
        match (self, &section.filling) {
            (Self::Glass(pane), Filling::SceneGlass) if section.found.is_some() => {
                format!("glass of the scene '{}', {}", section.name, describe(pane))
            }
            (Self::Glass(pane), Filling::SceneGlass) => format!("the scene's glass, {}", describe(pane)),
            (Self::Glass(pane), _) => describe(pane),
            (Self::Data(..), Filling::Interpolated([from, to], fraction)) => {
                let [from, to] = [from, to].map(|f| f.file_name().unwrap_or_default().to_string_lossy().into_owned());
                format!("{from}, {:.1} % of the way to {to}", 100.0 * fraction)
            }
            (Self::Layers(_), Filling::Layers(words)) => format!("layers {}", words.join(" | ")),
            (Self::Data(_, file), _) => file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            (Self::Layers(_), _) => "layers".into(),
        }
    }
}

pub(super) fn describe(pane: &Pane) -> String {
    if pane.transmissivity == [0.0; 3] {
        return "closed: no light passes".into();
    }
    let ([r, g, b], [a, ..]) = (pane.at(1.0).0, pane.transmissivity);
    let passes = if r == g && g == b { format!("{g:.3}") } else { format!("{r:.3} {g:.3} {b:.3} (RGB)") };
    format!("clear glass of transmittance {passes} at the normal (Radiance's transmissivity {a:.4})")
}

/// The glass in the window's place in the scene, which is taken out; else that of the window's own material.
fn of_scene(project: &Project, section: &WindowSection, window: &Window, scene: &mut Scene) -> Result<Pane> {
    let panes = scene.panes_at(window);
    let in_place: Vec<_> = panes.iter().filter(|p| p.is_in_plane).collect();
    let kinds: Vec<Pane> = in_place.iter().filter_map(|p| Pane::of_material(&scene.material(p.material).kind)).collect();
    let own = super::shade::own_material(project, section, window).and_then(|kind| Pane::of_material(&kind));
    let told = |message: String| section.place.of(Error::new(message));
    let first = kinds.first().copied();
    if let Some((other, _)) = in_place.iter().zip(&kinds).find(|(_, kind)| Some(**kind) != first) {
        let name = |index| &scene.material(index).name;
        return Err(told(format!(
            "the window '{}' has two kinds of glass in the scene, '{}' and '{}'",
            window.name,
            name(in_place[0].material),
            name(other.material)
        ))
        .help("make each a [[window]] of its own"));
    }
    let covered: f64 = in_place.iter().map(|p| p.area).sum();
    let whole = covered >= (1.0 - 1e-3) * window.area();
    if let (Some(pane), true) = (first, whole) {
        let surfaces = in_place.iter().map(|p| p.surface).collect();
        scene.take_out(window, &surfaces);
        return Ok(pane);
    }
    // The window's polygon stands for the pane, what of it is in the scene is the same.
    if let Some(pane) = own.filter(|own| first.is_none_or(|f| f == *own)) {
        let surfaces = in_place.iter().map(|p| p.surface).collect();
        scene.take_out(window, &surfaces);
        return Ok(pane);
    }
    const HELP: &str = "write glass = 0.65 (the transmittance), or give the window's polygon the place, or the material, of the pane";
    if first.is_some() {
        let text = format!("glass of the scene fills {:.0} % of window '{}' only", 100.0 * covered / window.area(), window.name);
        return Err(told(text).help("draw the window as large as its pane, or write glass = 0.65 (the transmittance)"));
    }
    let near = panes.iter().min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
    Err(told(match near {
        Some(p) => format!(
            "there is no glass in the plane of window '{}'; the nearest is '{}', {:.4} from it",
            window.name,
            scene.surfaces.get(p.surface as usize).map_or("?", |s| s.name.as_str()),
            p.distance.abs()
        ),
        None => format!("window '{}' has no glass: neither its material nor the scene's surfaces in its plane are glass", window.name),
    })
    .help(HELP))
}

/// T of a pane: diagonal, each colour for itself, the mean of each ring weighted by projected solid angle.
pub(super) fn pane_transmission(pane: &Pane, basis: &AngleBasis) -> Result<Matrix<f64>> {
    let bins = basis.len();
    let mut t = Matrix::zeros(bins, bins, 3);
    for colour in 0..3 {
        let sample = |degrees: u32| {
            let (passed, mirrored) = pane.at(if degrees == 90 { 0.0 } else { f64::from(degrees).to_radians().cos() });
            let (t, r) = (passed[colour].clamp(0.0, 1.0), mirrored[colour]);
            let specular_reflectance = r.clamp(0.0, 1.0 - t);
            Sample { theta: f64::from(degrees), specular_transmittance: t, specular_reflectance, ..Sample::default() }
        };
        let table = AngularTable::new((0..=90).map(sample).collect(), Vec::new(), &mut Warnings::new())?;
        let blocks = table.to_blocks(basis, &mut Warnings::new());
        let grey = bsdf::transmission_matrix(&Bsdf { visible: blocks, ..Bsdf::default() })?;
        for bin in 0..bins {
            t.at_mut(bin, bin)[colour] = grey.at(bin, bin)[0];
        }
    }
    Ok(t)
}

/// T of a window of the project over another basis.
///
/// # Errors
/// As [`Filled::read`].
pub(crate) fn transmission_over(
    project: &Project,
    section: &WindowSection,
    glass: Option<&Pane>,
    basis: &AngleBasis,
) -> Result<Matrix<f64>> {
    let mut filled = match glass {
        Some(pane) => Filled::Glass(*pane),
        None => Filled::data(project, section, basis, &mut Warnings::new())?,
    };
    if let Filled::Data(data, _) = &mut filled {
        use crate::bsdf::{Block, Component, resample::to_klems};
        for blocks in [&mut data.visible, &mut data.cie_x, &mut data.cie_z] {
            for component in [Component::TransmissionFront, Component::TransmissionBack] {
                let slot = blocks.slot(component);
                *slot = slot.take().map(|block| Block::Klems(to_klems(&block, basis, basis)));
            }
        }
    }
    filled.transmission(basis)
}

/// The scattering data of a window in each of its states; nothing of those that cannot be read: reading them as inputs
/// says what is wrong. Of a pane of glass there are none.
pub(super) fn data_of_states(project: &Project, section: &WindowSection) -> Vec<Option<Bsdf>> {
    let full = AngleBasis::from(KlemsBasis::Full);
    let data = |section: &WindowSection| match Filled::data(project, section, &full, &mut Warnings::new()) {
        Ok(Filled::Layers(data) | Filled::Data(data, _)) => Some(data),
        _ => None,
    };
    section.each_state().iter().filter(|s| !s.filling.is_glass()).map(data).collect()
}

/// The scattering function, with warnings of doubtful values.
pub(super) fn checked(bsdf: &bsdf::Bsdf, file: &Path, warnings: &mut Warnings) -> Result<Scattering> {
    let mut found = Warnings::new();
    let scattering = Scattering::checked(bsdf, &mut found).map_err(|e| e.file(file))?;
    found.iter().for_each(|w| warnings.push(w.clone().file(file)));
    Ok(scattering)
}

/// A grey matrix as RGB.
pub fn in_colour(matrix: Matrix<f64>) -> Matrix<f64> {
    if matrix.components() == 3 {
        return matrix;
    }
    let data = matrix.data().iter().flat_map(|&v| [v; 3]).collect();
    Matrix::from_data(matrix.rows(), matrix.cols(), 3, data).expect("three values per element")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_t_of_a_pane_is_the_glass_formula_s_mean_over_each_bin() {
        let full = AngleBasis::from(KlemsBasis::Full);
        let pane = Pane { transmissivity: [0.3, 0.7, 0.9], refraction_index: 1.52 };
        let t = pane_transmission(&pane, &full).unwrap();
        for bin in 0..full.len() {
            // By points spread evenly over the bin's projected solid angle.
            const STEPS: usize = 64;
            let mut mean = [0.0; 3];
            for k in 0..STEPS * STEPS {
                let [u, v] = [k / STEPS, k % STEPS].map(|i| (i as f64 + 0.5) / STEPS as f64);
                let passed = pane.at(full.direction(bin, u, v).z).0;
                (0..3).for_each(|c| mean[c] += passed[c] / (STEPS * STEPS) as f64);
            }
            for c in 0..3 {
                let (found, wanted) = (t.at(bin, bin)[c], mean[c]);
                assert!((found - wanted).abs() < 2e-4, "bin {bin}, colour {c}: {found} {wanted}");
            }
            assert!((0..full.len()).filter(|o| *o != bin).all(|o| t.at(o, bin) == [0.0; 3]), "nothing is scattered");
        }
        // The first bin, within 5° of the normal, has the value of the data sheet.
        let sheet = pane_transmission(&Pane::of_transmittance([0.65; 3]).unwrap(), &full).unwrap();
        assert!((sheet.at(0, 0)[1] - 0.65).abs() < 3e-4, "{:?}", sheet.at(0, 0));
    }
}
