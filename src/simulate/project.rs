//! `project.toml`: everything one simulation needs, in one file.
//!
//! ```toml
//! [weather]
//! file = "weather/NYC.wea"            # or .epw
//! [scene]
//! files = ["materials.rad", "room.rad"]
//! [[window]]                          # any number
//! name = "south"
//! surface = "objects/GlazingVmtx.rad" # polygons whose normal points into the room
//! bsdf = "bsdf/clear.xml"
//! shade = "blinds.rad"                # optional: slats and panes the sun is traced through
//! # tensor_tree = "blinds_t4.xml"     # or scattering data of high resolution
//! # daylight = "D.mtx"                # optional: a matrix made elsewhere, see import
//! [[sensors]]                         # any number
//! name = "workplane"
//! points = "points.txt"
//! [[view]]                            # any number
//! name = "desk"
//! file = "views/fish.vf"
//! resolution = [400, 400]
//! [[views]]                           # any number: views on points, see view_grid
//! name = "seats"
//! points = "seats.txt"
//! [glare]                             # glare of all views, see glare_section
//! method = "image"
//! [images]
//! hours = "daylight"                  # "daylight" | "none" | [1164, 1929]
//! [method]
//! phases = "auto"                     # "auto" | 2 | 3 | 5
//! suns = 6                            # of five phases: Reinhart MF, or "hourly"
//! sky_subdivision = 1                 # Reinhart MF (1 if left out), or "auto": as the glazing asks
//! bounces = 4                         # left out: not truncated (Russian roulette)
//! [quality]
//! preset = "standard"                 # draft | standard | final
//! # target_error = 0.02               # or: until the standard error is 2 %
//! # time_limit = "5 min"              # or: as long as that
//! seed = 1
//! ```
//!
//! Paths are relative to the file. Each section is one struct with one function that reads it, so
//! that a section added later touches nothing else.

use super::glare_section::GlareSection;
use super::import::ImportSection;
use super::method::MethodSection;
pub use super::quality::{Preset, QualitySection};
use super::table::{Document, Table};
use super::view_grid::read_grid;
use super::views::{ImageHours, ImagesSection, ViewSection};
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
    /// `[glare]`, if there is one.
    pub glare: Option<GlareSection>,
    /// `[images]`
    pub images: ImagesSection,
    /// `[method]`
    pub method: MethodSection,
    /// `[quality]`
    pub quality: QualitySection,
}

/// `[weather]`: where the hours come from.
#[derive(Debug, Clone, PartialEq)]
pub struct WeatherSection {
    /// Weather file, WEA or EPW.
    pub file: PathBuf,
}

/// `[scene]`: the room and what stands around it, without its windows.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSection {
    /// Radiance scene files, in the order Radiance would get them.
    pub files: Vec<PathBuf>,
}

/// One `[[window]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowSection {
    /// Name in results and messages.
    pub name: String,
    /// Radiance file with the window's polygons, normals into the room.
    pub surface: PathBuf,
    /// Transmission of the window, Klems XML; the first of its states, if it has several.
    pub bsdf: PathBuf,
    /// Slats and panes that the sun is traced through, Radiance file.
    pub shade: Option<PathBuf>,
    /// Scattering data that the sun is traced through in place of a shade, XML of any kind.
    pub tensor_tree: Option<PathBuf>,
    /// Further states of the façade: glare is computed for each, with the same view and daylight
    /// matrices. All states, the first included; empty for one state.
    pub states: Vec<PathBuf>,
    /// D and Dd made elsewhere.
    pub daylight: Option<ImportSection>,
}

/// One `[[sensors]]`: a group of sensors with one result file.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorsSection {
    /// Name of the group, and of its result files.
    pub name: String,
    /// File of `x y z dx dy dz` lines.
    pub points: PathBuf,
    /// V and Vd made elsewhere.
    pub view: Option<ImportSection>,
    /// Cds made elsewhere.
    pub sun: Option<PathBuf>,
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

    /// The folder its paths are relative to.
    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    fn parse(file: &Path, text: &str) -> Result<Self> {
        let document = Document::new(file, text);
        let entries = document.parse()?;
        let mut top = Table::top(&document, &entries);
        let weather = WeatherSection::read(top.required_table("weather", "add [weather] with file = \"….wea\" or \"….epw\"")?)?;
        let scene = SceneSection::read(top.required_table("scene", "add [scene] with files = [\"materials.rad\", \"room.rad\"]")?)?;
        let windows = top.tables("window")?.into_iter().map(WindowSection::read).collect::<Result<Vec<_>>>()?;
        let sensors = top.tables("sensors")?.into_iter().map(SensorsSection::read).collect::<Result<Vec<_>>>()?;
        let mut views = top.tables("view")?.into_iter().map(ViewSection::read).collect::<Result<Vec<_>>>()?;
        for table in top.tables("views")? {
            views.extend(read_grid(table)?);
        }
        let glare = GlareSection::read(top.table("glare")?)?;
        let images = ImagesSection::read(top.table("images")?)?;
        let method = MethodSection::read(top.table("method")?, &windows)?;
        let quality = QualitySection::read(top.table("quality")?)?;
        if windows.is_empty() {
            return Err(top.missing_section("window", "add [[window]] with name, surface and bsdf"));
        }
        if sensors.is_empty() && views.is_empty() {
            return Err(top.missing_section("sensors", "add [[sensors]] with name and points, or [[view]] with name and file"));
        }
        views.iter().try_for_each(|v| v.given.check(&top, &v.name, method.choice(&windows).phases))?;
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
        states_match(&top, &windows)?;
        imports_match(&top, method.choice(&windows).phases, &windows, &sensors)?;
        unique(&top, "window", windows.iter().map(|w| w.name.as_str()))?;
        unique(&top, "sensors", sensors.iter().map(|s| s.name.as_str()))?;
        // Both give matrices V_NAME.
        unique(&top, "view", sensors.iter().map(|s| s.name.as_str()).chain(views.iter().map(|v| v.name.as_str())))?;
        top.finish()?;
        Ok(Self { file: file.to_path_buf(), weather, scene, windows, sensors, views, glare, images, method, quality })
    }
}

fn unique<'n>(top: &Table<'_, '_>, section: &str, names: impl Iterator<Item = &'n str>) -> Result<()> {
    let mut seen = std::collections::HashSet::new();
    for name in names {
        if !seen.insert(name.to_lowercase()) {
            return Err(top
                .error(section, format!("two sections [[{section}]] have the name '{name}'"))
                .help("give each its own name: result files are called after it (capitals do not count)"));
        }
    }
    Ok(())
}

/// A name that can be part of a file name on every system.
pub(super) fn name(table: &mut Table<'_, '_>, help: &str) -> Result<String> {
    let name = table.required_string("name", help)?;
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    if name.starts_with('.') || name.len() > 100 || !name.chars().all(allowed) {
        return Err(table
            .error("name", format!("'{name}' cannot be part of a file name"))
            .help("use letters, digits, '-', '_', '.' and blanks, at most 100"));
    }
    Ok(name)
}

impl WeatherSection {
    fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let file = table.required_path("file", "add file = \"….wea\" or \"….epw\"")?;
        table.finish()?;
        Ok(Self { file })
    }
}

impl SceneSection {
    fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let files = table.required_paths("files", "add files = [\"materials.rad\", \"room.rad\"]")?;
        table.finish()?;
        Ok(Self { files })
    }
}

impl WindowSection {
    /// Whether suns are traced through it, by the five-phase method.
    pub fn lets_suns_through(&self) -> bool {
        self.shade.is_some() || self.tensor_tree.is_some()
    }

    fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"south\" or the like")?;
        let surface =
            table.required_path("surface", "add surface = \"….rad\": the window's polygons, with normals that point into the room")?;
        let states = table.paths("states")?;
        let bsdf = match states.first() {
            // The key is asked for all the same, so that it is known.
            Some(first) => match table.path("bsdf")? {
                None => first.clone(),
                Some(_) => {
                    return Err(table
                        .error("bsdf", "a window has either one 'bsdf' or several 'states'")
                        .help("put this file first in 'states' and take 'bsdf' out"));
                }
            },
            None => table.required_path("bsdf", "add bsdf = \"….xml\": the window's Klems BSDF")?,
        };
        let shade = table.path("shade")?;
        let tensor_tree = table.path("tensor_tree")?;
        if shade.is_some() && tensor_tree.is_some() {
            return Err(table
                .error("tensor_tree", "the sun is traced either through a 'shade' or through a 'tensor_tree'")
                .help("keep the shade if there are slats or panes to trace, the tensor tree if there are only measured data"));
        }
        let daylight = ImportSection::read(&mut table, "daylight", "daylight_direct")?;
        table.finish()?;
        Ok(Self { name, surface, bsdf, shade, tensor_tree, states, daylight })
    }
}

/// Windows with several states change them together.
fn states_match(top: &Table<'_, '_>, windows: &[WindowSection]) -> Result<()> {
    let mut changing = windows.iter().filter(|w| !w.states.is_empty());
    let Some(first) = changing.next() else { return Ok(()) };
    match changing.find(|w| w.states.len() != first.states.len()) {
        None => Ok(()),
        Some(other) => Err(top
            .error(
                "window",
                format!("window '{}' has {} states, '{}' has {}", first.name, first.states.len(), other.name, other.states.len()),
            )
            .help("give all windows with states the same number: the first of each belong together, and so on")),
    }
}

/// Five phases need the straight parts too, and only they need suns.
fn imports_match(top: &Table<'_, '_>, phases: u32, windows: &[WindowSection], sensors: &[SensorsSection]) -> Result<()> {
    let all = windows.iter().map(|w| ("window", &w.name, "daylight", &w.daylight));
    for (section, name, key, given) in all.chain(sensors.iter().map(|s| ("sensors", &s.name, "view", &s.view))) {
        if phases == 5 && given.as_ref().is_some_and(|g| g.direct.is_none()) {
            return Err(top
                .error(section, format!("'{name}' has a matrix '{key}' without its straight part, which five phases subtract"))
                .help(format!("add {key}_direct = \"….mtx\"")));
        }
    }
    match sensors.iter().find(|s| phases != 5 && s.sun.is_some()) {
        None => Ok(()),
        Some(group) => Err(top
            .error("sensors", format!("'{}' has a sun matrix, which only five phases use", group.name))
            .help("write phases = 5 and give the window a shade or tensor_tree, or take 'sun' out")),
    }
}

impl SensorsSection {
    fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"workplane\" or the like")?;
        let points = table.required_path("points", "add points = \"….txt\" with a line 'x y z dx dy dz' per sensor")?;
        let view = ImportSection::read(&mut table, "view", "view_direct")?;
        let sun = table.path("sun")?;
        table.finish()?;
        Ok(Self { name, points, view, sun })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::simulate::method::Phases;

    const GOOD: &str = r#"
[weather]
file = "a.wea"
[scene]
files = ["m.rad", "r.rad"]
[[window]]
name = "south"
surface = "w.rad"
bsdf = "b.xml"
[[sensors]]
name = "workplane"
points = "p.txt"
[method]
phases = 3
sky_subdivision = 4
bounces = 4
[quality]
preset = "final"
seed = 0x2a
"#;

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for f in ["a.wea", "m.rad", "r.rad", "w.rad", "b.xml", "p.txt", "s.rad"] {
            std::fs::write(folder.path().join(f), "").unwrap();
        }
        folder
    }

    fn read(text: &str) -> Result<Project> {
        let folder = folder();
        let file = folder.path().join("project.toml");
        std::fs::write(&file, text).unwrap();
        Project::read(&file)
    }

    fn complaint(text: &str) -> String {
        let message = read(text).unwrap_err().to_string();
        message[message.find("project.toml").expect("the file is named")..].to_string()
    }

    #[test]
    fn a_sound_project_is_read_with_paths_relative_to_it() {
        let p = read(GOOD).unwrap();
        assert!(p.weather.file.ends_with("a.wea") && p.weather.file.is_absolute());
        assert_eq!(p.scene.files.len(), 2);
        assert_eq!((p.windows[0].name.as_str(), p.sensors[0].name.as_str()), ("south", "workplane"));
        assert_eq!((p.method.phases, p.method.sky.subdivision(), p.method.bounces), (Phases::Three, 4, Some(4)));
        assert_eq!((p.quality.preset, p.quality.seed), (Preset::Final, 42));
    }

    #[test]
    fn what_is_left_out_has_defaults() {
        let p = read(&GOOD[..GOOD.find("[method]").unwrap()]).unwrap();
        assert_eq!((p.method.phases, p.method.sky.subdivision(), p.method.bounces), (Phases::Auto, 1, None));
        assert_eq!(p.method.choice(&p.windows).phases, 3);
        assert_eq!((p.quality.preset, p.quality.seed), (Preset::Standard, 1));
    }

    #[test]
    fn every_fault_is_answered_with_line_key_and_remedy() {
        // What is replaced by what, the line and the words that must be in the complaint.
        let cases: &[(&str, &str, usize, &[&str])] = &[
            ("bounces = 4", "bouncs = 4", 16, &["'bouncs'", "[method]", "did you mean 'bounces'?"]),
            ("[quality]", "[qualty]", 17, &["'qualty'", "did you mean 'quality'?"]),
            ("[[window]]", "[[windows]]", 6, &["'windows'", "did you mean 'window'?"]),
            ("[scene]", "[colours]", 1, &["the project has no 'scene'", "add [scene]"]),
            ("files = [", "file = [", 5, &["'file'", "[scene]", "did you mean 'files'?"]),
            ("[[window]]", "[window]", 6, &["window", "[[window]]"]),
            ("bsdf = \"b.xml\"", "bsfd = \"b.xml\"", 9, &["'bsfd'", "did you mean 'bsdf'?"]),
            ("bsdf = \"b.xml\"", "", 6, &["[window 1] has no 'bsdf'", "Klems"]),
            ("bsdf = \"b.xml\"", "bsdf = \"c.xml\"", 9, &["window 1.bsdf", "no file", "c.xml", "relative"]),
            ("surface = \"w.rad\"", "surface = 3", 8, &["window 1.surface", "a whole number", "text"]),
            ("sky_subdivision = 4", "sky_subdivision = 7", 15, &["method.sky_subdivision", "1 to 6"]),
            ("sky_subdivision = 4", "sky_subdivision = 1.5", 15, &["a number, not a whole number"]),
            ("bounces = 4", "bounces = -1", 16, &["method.bounces", "out of range"]),
            ("phases = 3", "phases = 4", 14, &["4 phases", "choose 2, 3, 5"]),
            ("\"final\"", "\"best\"", 18, &["'best'", "\"draft\", \"standard\", \"final\""]),
            ("seed = 0x2a", "seed = 99999999999999999999", 19, &["quality.seed", "out of range"]),
            ("seed = 0x2a", "target_error = 0.02", 19, &["quality.target_error", "'preset' and 'target_error' contradict", "keep one"]),
            ("preset = \"final\"", "rounds = 3\ntime_limit = \"5 min\"", 18, &["quality.rounds", "'time_limit' and 'rounds'"]),
            ("preset = \"final\"", "target_error = 2", 18, &["quality.target_error", "from 0.0001 to 0.5"]),
            ("preset = \"final\"", "target_error = 0.0", 18, &["quality.target_error", "out of range"]),
            ("preset = \"final\"", "time_limit = \"5 fortnights\"", 18, &["quality.time_limit", "'5 fortnights'", "5 min"]),
            ("preset = \"final\"", "time_limit = \"-1 s\"", 18, &["quality.time_limit", "'-1 s'"]),
            ("[\"m.rad\", \"r.rad\"]", "[]", 5, &["scene.files", "empty"]),
            ("[\"m.rad\", \"r.rad\"]", "[\"m.rad\", 3]", 5, &["scene.files", "name of a file"]),
            ("[\"m.rad\", \"r.rad\"]", "\"m.rad\"", 5, &["scene.files", "a list of files"]),
            ("file = \"a.wea\"", "", 2, &["[weather] has no 'file'"]),
            ("name = \"south\"", "name = \"a/b\"", 7, &["window 1.name", "file name"]),
            ("name = \"south\"", "name = \"../x\"", 7, &["window 1.name", "file name"]),
            ("points = \"p.txt\"", "points = \".\"", 12, &["sensors 1.points", "a folder"]),
            ("phases = 3", "phases = = 3", 14, &["toml.io"]),
            ("phases = 3", "phases = 5", 14, &["five phases need a window", "shade"]),
            ("phases = 3", "phases = \"some\"", 14, &["'some'", "\"auto\""]),
            ("phases = 3", "phases = 3\nsuns = 4", 15, &["suns are traced by five phases only"]),
            ("phases = 3", "suns = \"daily\"", 14, &["'daily'", "\"hourly\""]),
            ("phases = 3", "suns = 7", 14, &["1 to 6"]),
            ("bsdf = \"b.xml\"", "bsdf = \"b.xml\"\nshade = \"s.rad\"", 15, &["'south' has a shade", "phases = 5"]),
            ("bsdf = \"b.xml\"", "bsdf = \"b.xml\"\nshade = \"t.rad\"", 10, &["window 1.shade", "no file"]),
        ];
        for (from, to, line, words) in cases {
            assert!(GOOD.contains(from));
            let message = complaint(&GOOD.replacen(from, to, 1));
            assert!(message.starts_with(&format!("project.toml:{line}: ")), "{to}: wanted line {line}: {message}");
            for word in *words {
                assert!(message.contains(word), "{to}: no '{word}' in: {message}");
            }
        }
    }

    #[test]
    fn accuracy_is_asked_for_in_one_way() {
        use crate::simulate::sampling::Stop;
        use std::time::Duration;
        let stop = |text: &str| read(&GOOD.replace("preset = \"final\"", text)).unwrap().quality.stop();
        assert_eq!(stop(""), Stop::Rounds(1));
        assert_eq!(stop("preset = \"final\""), Stop::Rounds(16));
        assert_eq!(stop("target_error = 0.02"), Stop::Adaptive { target: Some(0.02), time: None, rounds: None });
        assert_eq!(stop("rounds = 7"), Stop::Adaptive { target: None, time: None, rounds: Some(7) });
        let both = stop("target_error = 0.01\ntime_limit = \"1.5 h\"");
        assert_eq!(both, Stop::Adaptive { target: Some(0.01), time: Some(Duration::from_secs(5400)), rounds: None });
    }

    #[test]
    fn a_shade_makes_five_phases() {
        use crate::simulate::suns::SunScheme;
        let shaded = GOOD.replace("bsdf = \"b.xml\"", "bsdf = \"b.xml\"\nshade = \"s.rad\"");
        for (phases, suns) in [
            ("phases = \"auto\"\nsuns = \"hourly\"", SunScheme::HOURLY),
            ("phases = 5\nsuns = 4", SunScheme::Patches(crate::bins::ReinhartSky::new(4).unwrap())),
        ] {
            let p = read(&shaded.replace("phases = 3", phases)).unwrap();
            assert_eq!(p.method.choice(&p.windows).phases, 5);
            assert_eq!(p.method.suns, suns);
            assert!(p.windows[0].shade.as_ref().is_some_and(|s| s.ends_with("s.rad")));
        }
        let p = read(&GOOD.replace("phases = 3", "phases = 2")).unwrap();
        assert_eq!((p.method.phases, p.method.choice(&p.windows).phases), (Phases::Two, 2));
    }

    #[test]
    fn views_and_hours_of_pictures_are_read() {
        let view = "[[view]]\nname = \"desk\"\nfile = \"m.rad\"\nresolution = [400, 300]\n";
        let p = read(&format!("{GOOD}{view}[images]\nhours = [12, 3]\n")).unwrap();
        assert_eq!((p.views[0].name.as_str(), p.views[0].resolution), ("desk", [400, 300]));
        assert_eq!(p.images.hours, ImageHours::Chosen(vec![12, 3]));
        assert_eq!(read(&format!("{GOOD}{view}[images]\nhours = \"daylight\"\n")).unwrap().images.hours, ImageHours::Daylight);
        assert_eq!(read(GOOD).unwrap().images.hours, ImageHours::None);
        for (wrong, words) in [
            ("resolution = [400]", "two numbers"),
            ("resolution = [400, 0]", "out of range"),
            ("resolution = 400", "a list of whole numbers"),
            ("name = \"workplane\"", "two sections"),
        ] {
            let line = if wrong.starts_with("name") {
                view.replace("name = \"desk\"", wrong)
            } else {
                view.replace("resolution = [400, 300]", wrong)
            };
            let message = complaint(&format!("{GOOD}{line}"));
            assert!(message.contains(words), "{wrong}: {message}");
        }
        assert!(complaint(&format!("{GOOD}[images]\nhours = \"daylight\"\n")).contains("[[view]]"));
        assert!(complaint(&format!("{GOOD}{view}[images]\nhours = \"night\"\n")).contains("'night'"));
    }

    #[test]
    fn names_used_twice_are_refused() {
        let twice = format!("{GOOD}[[sensors]]\nname = \"Workplane\"\npoints = \"p.txt\"\n");
        assert!(complaint(&twice).contains("two sections [[sensors]] have the name 'Workplane'"));
    }

    #[test]
    fn faults_that_show_later_still_name_the_projects_line_and_key() {
        use crate::matrix::Matrix;
        let view = |resolution: &str| format!("[[view]]\nname = \"desk\"\nfile = \"v.vf\"\nresolution = {resolution}\n");
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("v.vf"), "rvu -vtv -vh 10 -vv 170\n").unwrap();
        std::fs::write(at("up.txt"), "1 1 1 0 1 0\n2 2 2 0 0 1\n").unwrap();
        let read = |text: &str| {
            std::fs::write(at("project.toml"), text).unwrap();
            Project::read(&at("project.toml"))
        };
        let starts = |e: Error, start: &str| {
            let text = e.to_string();
            assert!(text.contains(start) && !text.split("help:").next().unwrap().contains(" -"), "{text}");
        };
        let project = read(&format!("{GOOD}{}[images]\nhours = [3, 9000]\n", view("[4, 4]"))).unwrap();
        let error = project.images.hours.chosen(&Matrix::zeros(1, 8760, 3)).unwrap_err();
        starts(project.images.place.as_ref().unwrap().of(error), "project.toml:25: images.hours: 'the weather file' has no hour 9000");
        starts(project.views[0].raster().unwrap_err(), "project.toml:23: view 1.resolution: 4 × 4 square pixels are too few");
        assert!(read(&format!("{GOOD}{}", view("[1, 400]"))).unwrap().views[0].raster().is_ok());
        let looking_up = format!("{GOOD}[[views]]\nname = \"seats\"\npoints = \"up.txt\"\n");
        starts(read(&looking_up).unwrap_err(), "up.txt:2: this point looks straight up or down");
        let comma = read(&GOOD.replace("preset = \"final\"", "target_error = 0,02")).unwrap_err().to_string();
        assert!(comma.contains("project.toml:18: ") && comma.contains("write a point in place of the comma: 0.02"), "{comma}");
    }

    #[test]
    fn garbage_is_refused_without_panic() {
        for cut in 0..GOOD.len() {
            if GOOD.is_char_boundary(cut) {
                let _ = read(&GOOD[..cut]);
            }
        }
        let folder = folder();
        let file = folder.path().join("project.toml");
        std::fs::write(&file, [b'\n', 0xff, 0xfe, 0, 1]).unwrap();
        assert!(Project::read(&file).unwrap_err().to_string().contains("project.toml:2: this is binary data, not a project file"));
        assert!(Project::read(&folder.path().join("none.toml")).is_err());
    }
}
