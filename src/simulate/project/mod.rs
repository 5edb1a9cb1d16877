//! `project.toml`: everything one simulation needs, in one file.
//!
//! ```toml
//! [weather]
//! file = "weather/NYC.wea"            # or .epw; or moments under a sky of the CIE in place of a file:
//! # sky = "cie clear"                 # clear | intermediate | overcast | uniform
//! # date = "03-21T12:00"              # or a list; standard time
//! # site = [46.5, 11.35, 15]          # latitude, longitude, standard meridian: degrees north and east
//! # sky = "cie overcast"              # without date and site: 10,000 lx outdoors, for daylight factors
//! # sky_matrix = "S.mtx"             # or a sky made elsewhere, as gendaymtx writes it; with
//! # sky_matrix_direct = "Sds.mtx"     # its sun's share (gendaymtx -d), or "none"
//! # sun_matrix = "Ssun.mtx"           # and its suns (gendaymtx -5 0.533 -d -m 6)
//! # timestep = 15                     # minutes: hours of the file divided, with the sun where it stands
//! # period = ["03-01", "05-31"]       # first and last day; or one day
//! # hours = "schedule.csv"            # hours of the year that count: a value above 0; or a list of numbers from 0
//! north = 0                           # where north lies: degrees from +Y, counter-clockwise seen from above
//! ground_albedo = 0.2                 # reflectance of the ground beyond the scene's
//! # [[moment]]                        # in place of file, sky and date: any number of moments with names
//! # name = "noon, overcast"
//! # sky = "cie overcast"
//! # date = "03-21T12:00"
//! [scene]
//! files = ["materials.rad", "room.rad"]  # and, or in their place, model = "room.hbjson", see model
//! [[window]]                          # any number; without one sensors see the sky by what the scene leaves free
//! name = "south"
//! surface = "objects/GlazingVmtx.rad" # polygons whose normal points into the room
//! glass = 0.65                        # a clear pane; "scene": as in the scene files; or one of these:
//! # interpolate = ["clear.xml", "cloudy.xml", 0.5]  # scattering data half-way between two
//! # bsdf = "bsdf/clear.xml"           # scattering data
//! # glazing = ["glass:clear_6mm", "gap=16mm", "film.xml"]  # layers from outside to inside
//! shade = "blinds.rad"                # optional: slats and panes the sun is traced through
//! # tensor_tree = "blinds_t4.xml"     # or scattering data of high resolution; "own": those of the window itself
//! # daylight = "D.mtx"                # optional: a matrix made elsewhere, see import
//! # parts = "auto"                    # or 16, or [4, 4]: over what parts of it V and D are averaged; left out: 1
//! # group = "south"                   # windows of one group change their states together; left out: its name
//! # [[window.state]]                  # in place of glass, bsdf, …: any number, each with a name and these keys
//! # name = "open"
//! # glass = 0.65
//! # [[window.state]]
//! # name = "blind 45"
//! # bsdf = "ven45.xml"
//! # shade = "slats45.rad"
//! [[sensors]]                         # any number
//! name = "workplane"
//! points = "points.txt"               # or, spread over a material, a named surface or a file of polygons:
//! # surface = "Floor"
//! # spacing = 0.5
//! # height = 0.8                      # above it; left out: 0.8
//! # margin = 0.5                      # from its edge; left out: 0
//! [[view]]                            # any number
//! name = "desk"
//! file = "views/fish.vf"
//! resolution = [400, 400]
//! [[views]]                           # any number: views on points, see view_grid
//! name = "seats"
//! points = "seats.txt"
//! [glare]                             # glare of all views, see glare_section
//! method = "image"
//! # [control]                         # states of the groups by time step, see control; left out: the first
//! # south = "blinds.csv"             # or a state's name, { rule = "…" }, "lm-83", "optimal"
//! # [optimal]                         # what the best states are, see optimal
//! # eyes = "eyes"
//! [images]
//! hours = "daylight"                  # "daylight" | "none" | [1164, 1929], hours of the year from 0
//! [method]
//! phases = "auto"                     # "auto" | "direct" | 2 | 3 | 5
//! suns = 6                            # Reinhart MF, or "hourly": left out, five phases have 6, direct ones hourly
//! sky_subdivision = "auto"            # as the glazing asks (MF:4, diffuse panels MF:2), or Reinhart MF:1 … 6
//! bounces = 4                         # left out: not truncated (Russian roulette)
//! [quality]
//! preset = "standard"                 # draft | standard | final
//! # target_error = 0.02               # or: until the standard error is 2 %
//! # time_limit = "5 min"              # or: as long as that
//! seed = 1
//! [metrics]                           # named metrics and whose hours count, see metrics
//! occupancy = "lm-83"                 # "lm-83" | "en-17037" | "office.csv"
//! [output]
//! quantity = "illuminance"             # or "irradiance": solar, W/m²
//! ```
//!
//! Paths are relative to the file. Of the files that it names the points of `[[views]]` are read here, models, and
//! without `[[window]]` the scene, for the windows that it has (`found`).
//! Each section is one struct with one function that reads it, so
//! that a section added later touches nothing else.

pub mod builder;
mod check;
pub(crate) mod control;
mod document;
mod filling;
mod found;
pub mod given;
pub mod glare;
mod groups;
pub mod keys;
pub mod method;
pub mod metrics;
mod model;
pub(crate) mod names;
mod of_model;
pub(crate) mod optimal;
pub mod output;
pub(crate) mod parts;
pub mod quality;
mod sections;
pub(crate) mod states;
mod table;
mod view_grid;
pub mod views;
pub mod weather;

use self::control::ControlSection;
pub use self::document::Place;
use self::document::Places;
pub(crate) use self::filling::{Filling, SunData};
use self::found::Found;
use self::glare::GlareSection;
use self::method::{Asked, Choice, Glazing, MethodSection};
use self::metrics::MetricsSection;
use self::model::NamedModel;
use self::optimal::OptimalSection;
pub(crate) use self::output::OutputSection;
pub use self::output::Quantity;
pub use self::parts::Parts;
pub use self::quality::Preset;
pub(crate) use self::quality::QualitySection;
pub(crate) use self::sections::{SceneSection, SensorPoints, SensorsSection, WindowSection};
use self::table::{Document, Table};
use self::view_grid::read_grid;
use self::views::{ImageHours, ImagesSection, ViewSection};
pub(crate) use self::weather::WeatherSection;
use crate::control::Facade;
use crate::control::rules::Known;
use crate::error::Result;
use std::path::{Path, PathBuf};

/// A project file that has been read and found sound. All paths exist and are relative to the
/// working folder (not to the project file any more).
#[derive(Debug, Clone, PartialEq)]
pub struct Project {
    /// The file it was read from.
    pub file: PathBuf,
    /// `[weather]`
    pub weather: WeatherSection,
    /// `[scene]`
    pub scene: SceneSection,
    /// `[[window]]`
    pub windows: Vec<WindowSection>,
    /// `[[sensors]]`
    pub sensors: Vec<SensorsSection>,
    /// `[[view]]`, then those of `[[views]]`.
    pub views: Vec<ViewSection>,
    /// Groups of the windows that have states.
    pub facade: Facade,
    /// `[control]`
    pub control: ControlSection,
    /// `[glare]`, if there is one.
    pub glare: Option<GlareSection>,
    /// `[images]`
    pub images: ImagesSection,
    /// `[method]`
    pub method: MethodSection,
    /// `[quality]`
    pub quality: QualitySection,
    /// `[output]`
    pub output: OutputSection,
    /// `[metrics]`
    pub metrics: MetricsSection,
    /// Of a project that names no windows, what else the search for them in the scene found.
    pub(crate) found: Found,
    /// Where its sections stand, for faults that show when its files are read.
    pub(crate) places: Places,
}

impl Project {
    /// Reads and checks a project file. The files it names are looked for, but not read.
    ///
    /// # Errors
    /// A file that cannot be read or is no TOML, unknown or missing keys, wrong values, files that
    /// do not exist, names used twice: each with file, line and key.
    pub fn read(file: &Path) -> Result<Self> {
        let text = crate::text::read(file, "a project file")?;
        Self::parse(file, &text)
    }

    /// The method that a run follows, whose windows have this glazing.
    pub fn choice(&self, glazing: &Glazing) -> Choice {
        self.method.choice(asked(&self.windows, &self.sensors), glazing)
    }

    /// The folder its paths are relative to.
    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    fn parse(file: &Path, text: &str) -> Result<Self> {
        let document = Document::new(file, text);
        let entries = document.parse()?;
        let mut top = Table::top(&document, &entries);
        let moments = top.tables("moment")?;
        let weather = top.required_table("weather", "add [weather] with file = \"….wea\" or \"….epw\"")?;
        let weather = WeatherSection::read(weather, moments)?;
        let (scene, model) =
            SceneSection::read(top.required_table("scene", "add [scene] with files = [\"materials.rad\", \"room.rad\"]")?)?;
        let mut windows = top.tables("window")?.into_iter().map(WindowSection::read).collect::<Result<Vec<_>>>()?;
        if windows.is_empty() {
            top.refuse_slips("window")?;
        }
        let mut sensors = top.tables("sensors")?.into_iter().map(SensorsSection::read).collect::<Result<Vec<_>>>()?;
        let mut views = top.tables("view")?.into_iter().map(ViewSection::read).collect::<Result<Vec<_>>>()?;
        for table in top.tables("views")? {
            views.extend(read_grid(table)?);
        }
        let glare = GlareSection::read(top.table("glare")?)?;
        let images = ImagesSection::read(top.table("images")?)?;
        if let (Some(place), Some(file)) = (model, scene.files.last()) {
            let model = NamedModel::read(file, place)?;
            if windows.is_empty() {
                windows = model.windows();
            }
            if sensors.is_empty() && views.is_empty() {
                sensors = model.sensors();
            }
            if views.is_empty() && (sensors.is_empty() || glare.is_some() || images.hours != ImageHours::None) {
                views = model.views()?;
            }
        }
        let mut found = Found::default();
        if windows.is_empty() {
            let folder = file.parent().unwrap_or(Path::new(""));
            found = found::find_in(&scene.files, folder, &top.place("scene"))?;
            windows = std::mem::take(&mut found.windows);
        }
        let facade = groups::facade(&windows, &top.place("window"))?;
        let mut control = ControlSection::read(top.table("control")?, &facade)?;
        let optimal = top.table("optimal")?;
        let output = OutputSection::read(top.table("output")?, !views.is_empty())?;
        let names = sensors.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
        let views_named = views.iter().map(|v| v.name.clone()).collect::<Vec<_>>();
        control.optimal = OptimalSection::read(optimal, &names, &views_named, glare.is_some())?;
        control.check(Known { facade: &facade, sensors: &names, views: &views_named }, output.quantity, glare.is_some())?;
        let method = MethodSection::read(top.table("method")?, asked(&windows, &sensors))?;
        let quality = QualitySection::read(top.table("quality")?)?;
        let metrics = MetricsSection::read(top.table("metrics")?)?;
        if output.quantity.is_solar() && weather.moments.is_some() {
            return Err(top
                .error("output", "the CIE's skies are of visible light: there is no solar irradiance under them")
                .help("take 'quantity' out, or give a weather file in place of 'sky'"));
        }
        if windows.is_empty() && (!views.is_empty() || sensors.iter().any(|s| s.view.is_some() || s.sun.is_some())) {
            return Err(top.missing_section(
                "window",
                "pictures, glare and matrices V need windows, and the scene has no glass or BSDF between indoors and the sky: add [[window]] with name, surface and glass = 0.65 (or bsdf = \"….xml\")",
            ));
        }
        if sensors.is_empty() && views.is_empty() {
            return Err(top.missing_section("sensors", "add [[sensors]] with name and points, or [[view]] with name and file"));
        }
        if images.hours != ImageHours::None && views.is_empty() {
            return Err(top.missing_section("view", "[images] needs at least one [[view]] with name and file"));
        }
        if glare.is_some() && views.is_empty() {
            return Err(top.missing_section("view", "[glare] needs at least one [[view]] with name and file"));
        }
        if glare.is_some()
            && let Some(view) = views.iter().find(|v| ["annual", "undecided"].contains(&v.name.to_lowercase().as_str()))
        {
            return Err(top.error("view", format!("a view cannot have the name '{}': a table of glare has it", view.name)));
        }
        unique(&top, "window", windows.iter().map(|w| w.name.as_str()))?;
        unique(&top, "sensors", sensors.iter().map(|s| s.name.as_str()))?;
        // Both give matrices V_NAME.
        unique(&top, "view", sensors.iter().map(|s| s.name.as_str()).chain(views.iter().map(|v| v.name.as_str())))?;
        let [window, sensor, view, image] = ["window", "sensors", "view", "images"].map(|key| top.place(key));
        let places = Places { window, sensors: sensor, view, images: image };
        top.finish()?;
        let file = file.to_path_buf();
        Ok(Self {
            file,
            weather,
            scene,
            windows,
            sensors,
            views,
            facade,
            control,
            glare,
            images,
            method,
            quality,
            output,
            metrics,
            found,
            places,
        })
    }
}

fn asked<'a>(windows: &'a [WindowSection], sensors: &[SensorsSection]) -> Asked<'a> {
    let given = windows.iter().any(|w| w.daylight.is_some()) || sensors.iter().any(|s| s.view.is_some() || s.sun.is_some());
    Asked { windows, sensors: !sensors.is_empty(), given }
}

fn unique<'n>(top: &Table<'_, '_>, section: &str, names: impl Iterator<Item = &'n str>) -> Result<()> {
    let names: Vec<(&str, String)> = names.map(|name| (name, name.to_lowercase())).collect();
    let mut seen = std::collections::HashSet::new();
    for (name, lower) in &names {
        if !seen.insert(lower) {
            return Err(top
                .error(section, format!("two sections [[{section}]] have the name '{name}'"))
                .help("give each its own name: result files are called after it (capitals do not count)"));
        }
    }
    for (name, lower) in &names {
        let Some(ending) = names::ENDINGS.iter().find(|e| lower.strip_suffix(**e).is_some_and(|other| seen.contains(&other.to_string())))
        else {
            continue;
        };
        return Err(top
            .error(section, format!("'{name}' is another name with '{ending}', which files of its results end in"))
            .help("give one of them another name: their files would replace each other"));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
