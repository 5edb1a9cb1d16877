//! Settings of a project that can be changed.

use crate::bins::{AngleBasis, KlemsBasis};
use crate::control::{Facade, Schedule};
use crate::error::{Error, Result};
use crate::simulate::inputs::Inputs;
use crate::simulate::inputs::filling::transmission_over;
use crate::simulate::inputs::parts::errors_of_wholes;
use crate::simulate::project::Project;

/// What is changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Knob {
    /// Samples of everything, as a multiple of `preset = "standard"`.
    Samples(f64),
    /// Limit of diffuse reflections, Radiance's `-ab`.
    Bounces(u32),
    /// Basis of the windows.
    Basis(KlemsBasis),
    /// Parts of every window before which something stands.
    Parts(usize),
    /// Reinhart subdivision of the sky, and samples with it.
    Sky(usize, f64),
    /// Width and height of pictures, as a multiple of the project's.
    Picture(f64),
    /// Three phases where the project has five.
    ThreePhase,
    /// Suns at patches of MF:n.
    Suns(usize),
    /// Suns where they are.
    HourlySuns,
}

impl Knob {
    /// The family it belongs to, and its value.
    pub fn names(&self) -> (&'static str, String) {
        match self {
            Self::Samples(scale) => ("samples", multiple(*scale)),
            Self::Bounces(n) => ("bounces", n.to_string()),
            Self::Basis(basis) => ("basis", basis.xml_name().rsplit([' ', '/']).next().unwrap_or_default().to_lowercase()),
            Self::Parts(n) => ("parts", n.to_string()),
            Self::Sky(n, 1.0) => ("sky", format!("MF:{n}")),
            Self::Sky(n, scale) => ("sky", format!("MF:{n} x{}", multiple(*scale))),
            Self::Picture(scale) => ("picture", format!("{scale}")),
            Self::ThreePhase => ("method", "three phases".into()),
            Self::Suns(n) => ("method", format!("suns MF:{n}")),
            Self::HourlySuns => ("method", "hourly suns".into()),
        }
    }

    /// Whether pictures are all that it changes.
    pub(super) fn is_for_pictures(&self) -> bool {
        matches!(self, Self::Picture(_))
    }
}

fn multiple(scale: f64) -> String {
    if scale < 1.0 { format!("1/{:.0}", 1.0 / scale) } else { format!("{scale:.0}") }
}

/// The sky of all settings that do not change it.
pub(super) fn finest(project: &Project, inputs: &Inputs) -> usize {
    inputs.sky(project).subdivision().max(4)
}

/// All settings that make sense for a project: around its own method with a fine sky, at standard
/// quality.
pub fn knobs(project: &Project, inputs: &Inputs) -> Vec<Knob> {
    let mut all: Vec<Knob> = [1.0 / 16.0, 0.25, 1.0].map(Knob::Samples).to_vec();
    all.extend([1, 2, 4].map(Knob::Bounces));
    let bins = inputs.windows.iter().map(|w| w.window.basis.len()).max().unwrap_or(0);
    let coarser = [KlemsBasis::Half, KlemsBasis::Quarter].into_iter().filter(|b| AngleBasis::from(*b).len() < bins);
    // Sensors that see the sky itself know no bins.
    if !inputs.choice(project).direct || project.glare.is_some() {
        all.extend(coarser.map(Knob::Basis));
    }
    if errors_of_wholes(project, inputs).iter().any(Option::is_some) || inputs.windows.iter().any(|w| w.parts.len() > 1) {
        all.extend([1, 4, 16].map(Knob::Parts));
    }
    all.extend([(1, 1.0 / 16.0), (1, 1.0), (2, 1.0)].map(|(n, scale)| Knob::Sky(n, scale)));
    if !project.views.is_empty() && project.glare.is_some() {
        all.extend([0.5, 2.0].map(Knob::Picture));
    }
    if inputs.choice(project).phases == 5 {
        all.extend([Knob::ThreePhase, Knob::Suns(1), Knob::HourlySuns].into_iter().skip(usize::from(project.windows.is_empty())));
    }
    all
}

/// Windows and transmissions over another basis.
pub(super) fn rebase(inputs: &mut Inputs, project: &Project, basis: &AngleBasis) -> Result<()> {
    for window in &mut inputs.windows {
        let section = project
            .windows
            .iter()
            .find(|s| s.is_of(&window.name))
            .ok_or_else(|| Error::new(format!("window '{}' belongs to no [[window]]", window.name)))?;
        window.transmission = transmission_over(project, &section.in_state(usize::from(window.state)), window.glass.as_ref(), basis)?;
        window.window.basis = basis.clone();
        window.parts.iter_mut().for_each(|part| part.basis = basis.clone());
        window.states.clear();
        window.group = None;
    }
    inputs.facade = Facade::default();
    inputs.schedule = Schedule::first(&inputs.facade, inputs.weather.records.len());
    Ok(())
}
