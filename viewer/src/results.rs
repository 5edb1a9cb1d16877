//! A result folder: what `lucarne run` writes, read as far as it is needed.

use crate::stamp::Stamp;
use glam::DVec3;
use lucarne::glare::annual::GlareClass;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::matrix::rows::MatrixRows;
use lucarne::scene::Scene;
use lucarne::scene::points::faces_up;
use lucarne::simulate::Project;
use lucarne::weather::Weather;
use lucarne::{Error, Result, Warnings};
use std::collections::{HashMap, HashSet};
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A group of sensors with its year.
pub struct Group {
    /// Its name.
    pub name: String,
    /// Positions, m; empty if the folder does not tell.
    pub positions: Vec<DVec3>,
    /// Directions they face; empty if the project is not found.
    pub directions: Vec<DVec3>,
    /// Lux, `[sensor][hour]`.
    pub lux: Arc<Matrix<f32>>,
    /// Their standard errors, lx, if the folder has them.
    pub error: Option<Matrix<f32>>,
}

impl Group {
    /// Number of sensors.
    pub fn len(&self) -> usize {
        self.lux.rows()
    }

    /// Whether a sensor measures the plan: it faces up, or nothing tells where it faces.
    pub fn is_of_plan(&self, sensor: usize) -> bool {
        self.directions.get(sensor).is_none_or(|d| faces_up(*d))
    }
}

/// A view whose pictures can be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewFile {
    /// Its name.
    pub name: String,
    /// Its view matrix.
    pub matrix: PathBuf,
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Columns of the matrix.
    pub bins: usize,
    /// The view as Radiance options.
    pub options: Option<String>,
}

/// Glare of one view over the year.
pub struct GlareYear {
    /// The view's name.
    pub view: String,
    /// DGP by hour; NaN where it was not computed (night).
    pub dgp: Vec<f64>,
    /// Its standard error; NaN where it is not known.
    pub error: Vec<f64>,
    /// Class by hour as the table has it; its place in [`GlareClass::ALL`], NaN where there is none.
    pub class: Vec<f64>,
    /// Illuminance at the eye by hour, lx; NaN where it is not known.
    pub illuminance: Vec<f64>,
}

/// A folder of results.
pub struct Results {
    /// The folder, or the matrix file.
    pub folder: PathBuf,
    /// One line about it.
    pub title: String,
    /// Time of each hour.
    pub stamps: Vec<Stamp>,
    /// Groups of sensors.
    pub groups: Vec<Group>,
    /// Views.
    pub views: Vec<ViewFile>,
    /// Glare.
    pub glare: Vec<GlareYear>,
    /// Names of the windows in the order of the view matrices' columns.
    pub windows: Vec<String>,
    /// Further states of each window that the project names, by its name in [`Self::windows`].
    pub states: HashMap<String, Vec<PathBuf>>,
    /// Windows with a shade or a tensor tree, by their names in [`Self::windows`]: their sun is traced.
    pub shaded: HashSet<String>,
    /// Phases of the method that gave the illuminance.
    pub phases: u64,
    /// The room, if the project it came from is found.
    pub scene: Option<Arc<Scene>>,
    /// Site and sun, likewise.
    pub weather: Option<Arc<Weather>>,
    /// What is worth telling: parts that are missing.
    pub notes: Vec<String>,
}

impl Results {
    /// Reads a folder.
    pub fn open(folder: &Path) -> Result<Self> {
        let summary_path = folder.join("summary.json");
        let bytes = lucarne::files::read(&summary_path).map_err(|_| {
            Error::new("this folder holds no results: there is no summary.json")
                .file(folder)
                .help("open a folder that 'lucarne run PROJECT.toml -o FOLDER' has written")
        })?;
        let summary: serde_json::Value =
            serde_json::from_slice(&bytes).map_err(|e| Error::new(e.to_string()).file(&summary_path).help("run the project again"))?;
        let names = |key: &str| -> Vec<String> {
            let list = summary[key].as_array().into_iter().flatten();
            list.filter_map(|s| s["name"].as_str().map(str::to_string)).collect()
        };
        let mut notes = Vec::new();
        let (mut groups, mut stamps) = (Vec::new(), Vec::new());
        for name in names("sensors") {
            let base = folder.join("illuminance").join(&name);
            let lux = read_matrix(&base.with_added_extension("mtx"))?.matrix;
            let (positions, times) = read_table(&base.with_added_extension("csv")).unwrap_or_default();
            let positions = if positions.len() == lux.rows() { positions } else { Vec::new() };
            if times.len() == lux.cols() {
                stamps = times;
            }
            let error = read_matrix(&folder.join("illuminance").join(format!("{name}_standard_error.mtx"))).ok().map(|f| f.matrix);
            let error = error.filter(|e| (e.rows(), e.cols()) == (lux.rows(), lux.cols()));
            groups.push(Group { name, positions, directions: Vec::new(), lux: Arc::new(lux), error });
        }
        let windows: Vec<String> = names("matrices").iter().filter_map(|n| n.strip_prefix("D_").map(str::to_string)).collect();
        let mut views = Vec::new();
        for name in names("views") {
            match view_file(folder, &name) {
                Ok(view) => views.push(view),
                Err(e) => notes.push(format!("view '{name}' cannot be shown: {e}")),
            }
        }
        let hours = groups
            .first()
            .map(|g| g.lux.cols())
            .or_else(|| summary["time_steps"].as_u64().or(summary["hours"].as_u64()).map(|h| h as usize))
            .unwrap_or(8760);
        let project = summary["project"].as_str().map(|p| folder.join(p)).or_else(|| guess_project(folder));
        let (mut scene, mut weather) = (None, None);
        let (mut states, mut shaded) = (HashMap::new(), HashSet::new());
        if let Some(project) = project {
            match read_room(&project, &mut groups, &windows, (&mut states, &mut shaded)) {
                Ok((s, w)) => (scene, weather) = (Some(Arc::new(s)), Some(Arc::new(w))),
                Err(e) => notes.push(format!("the room's outline and the sun are not shown: {e}")),
            }
        }
        if let Some(w) = &weather
            && w.records.len() == hours
        {
            stamps = w.records.iter().map(|r| Stamp { month: r.month, day: r.day, hour: r.hour }).collect();
        }
        if stamps.len() != hours {
            stamps = Stamp::common_year(hours);
        }
        let glare = read_glare(folder, hours, &mut notes);
        let title = format!(
            "{}   {} hours, preset {}, {}",
            shortened(folder),
            hours,
            summary["preset"].as_str().unwrap_or("?"),
            summary["device"]["name"].as_str().unwrap_or("?")
        );
        let phases = summary["phases"].as_u64().unwrap_or(3);
        Ok(Self {
            folder: folder.to_path_buf(),
            title,
            stamps,
            groups,
            views,
            glare,
            windows,
            states,
            shaded,
            phases,
            scene,
            weather,
            notes,
        })
    }

    /// A year of illuminance from a matrix file alone.
    pub fn of_illuminance(path: &Path, lux: Matrix<f32>) -> Result<Self> {
        let hours = lux.cols();
        let name = path.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let (positions, stamps) = read_table(&path.with_extension("csv")).unwrap_or_default();
        let positions = if positions.len() == lux.rows() { positions } else { Vec::new() };
        let stamps = if stamps.len() == hours { stamps } else { Stamp::common_year(hours) };
        Ok(Self {
            folder: path.to_path_buf(),
            title: format!("{}   {} sensors, {hours} hours", path.display(), lux.rows()),
            stamps,
            groups: vec![Group { name, positions, directions: Vec::new(), lux: Arc::new(lux), error: None }],
            views: Vec::new(),
            glare: Vec::new(),
            windows: Vec::new(),
            states: HashMap::new(),
            shaded: HashSet::new(),
            phases: 3,
            scene: None,
            weather: None,
            notes: Vec::new(),
        })
    }

    /// Number of hours.
    pub fn hours(&self) -> usize {
        self.stamps.len()
    }

    /// Path of a matrix.
    pub fn matrix(&self, name: &str) -> PathBuf {
        self.folder.join("matrices").join(format!("{name}.mtx"))
    }
}

/// The last two parts of a path.
pub fn shortened(path: &Path) -> String {
    let parts: Vec<_> = path.components().rev().take(2).map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
    parts.into_iter().rev().collect::<Vec<_>>().join("/")
}

fn view_file(folder: &Path, name: &str) -> Result<ViewFile> {
    let matrix = folder.join("matrices").join(format!("V_{name}.mtx"));
    let rows = MatrixRows::open(&matrix)?.ok_or_else(|| Error::new("the matrix is text").file(&matrix))?;
    let value = |key: &str| rows.header().iter().rev().find_map(|l| l.strip_prefix(key)?.strip_prefix('=')).map(|v| v.trim().to_string());
    let size = value("RESOLUTION").unwrap_or_default();
    let words: Vec<&str> = size.split_whitespace().collect();
    let [width, height] = match words[..] {
        ["-Y", h, "+X", w] => [w.parse().unwrap_or(0), h.parse().unwrap_or(0)],
        _ => [0, 0],
    };
    if width * height != rows.rows() || rows.rows() == 0 || rows.components() != 3 {
        return Err(Error::new("the header does not tell the size of the pictures").file(&matrix).field("RESOLUTION"));
    }
    Ok(ViewFile { name: name.into(), width, height, bins: rows.cols(), options: value("VIEW"), matrix })
}

/// Positions and times of an illuminance table: `month,day,hour,1 (x y z),2 (x y z),…`.
fn read_table(path: &Path) -> Option<(Vec<DVec3>, Vec<Stamp>)> {
    let mut lines = std::io::BufReader::new(std::fs::File::open(path).ok()?).lines();
    let head = lines.next()?.ok()?;
    let position = |label: &str| {
        let inside = label.split_once('(')?.1.strip_suffix(')')?;
        let n: Vec<f64> = inside.split_whitespace().filter_map(|v| v.parse().ok()).collect();
        (n.len() == 3).then(|| DVec3::new(n[0], n[1], n[2]))
    };
    let positions: Option<Vec<DVec3>> = head.split(',').skip(3).map(position).collect();
    let stamps = lines.map_while(|line| {
        let line = line.ok()?;
        let mut words = line.splitn(4, ',');
        Some(Stamp { month: words.next()?.parse().ok()?, day: words.next()?.parse().ok()?, hour: words.next()?.parse().ok()? })
    });
    Some((positions.unwrap_or_default(), stamps.collect()))
}

/// `glare/VIEW.csv` of every view, and `glare/STATE/VIEW.csv` of every state of the façade:
/// `hour,dgp,dgp_standard_error,ev_lux,sources,class`.
fn read_glare(folder: &Path, hours: usize, notes: &mut Vec<String>) -> Vec<GlareYear> {
    let folder = folder.join("glare");
    let inside = |folder: &Path| -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
        paths.sort();
        paths
    };
    let mut files: Vec<(String, PathBuf)> = Vec::new();
    for path in inside(&folder) {
        if path.is_dir() {
            let state = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            files.extend(inside(&path).into_iter().map(|p| (format!(", {state}"), p)));
        } else {
            files.push((String::new(), path));
        }
    }
    let tables = files.into_iter().filter(|(_, p)| p.extension().is_some_and(|e| e == "csv"));
    tables.filter_map(|(state, file)| read_hours(&file, &state, hours, notes)).collect()
}

/// One table of hours; other tables (of all views) are none.
fn read_hours(file: &Path, state: &str, hours: usize, notes: &mut Vec<String>) -> Option<GlareYear> {
    let text = std::fs::read_to_string(file).ok()?;
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next()?.split(',').map(str::trim).collect();
    let column = |name: &str| columns.iter().position(|c| *c == name);
    let (hour, dgp, light) = (column("hour")?, column("dgp")?, column("ev_lux")?);
    let (error, class) = (column("dgp_standard_error"), column("class"));
    let name = file.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let none = || vec![f64::NAN; hours];
    let mut year = GlareYear { view: name + state, dgp: none(), error: none(), class: none(), illuminance: none() };
    // A row per time step: then the hour of the year in it only names the step.
    let whole = text.lines().count() == hours + 1;
    for (row, line) in lines.enumerate() {
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |i: usize| words.get(i).and_then(|w| w.parse::<f64>().ok());
        let step = if whole { Some(row) } else { words.get(hour).and_then(|w| w.parse::<usize>().ok()) };
        match (step, number(dgp), number(light)) {
            // Without light there is no glare to speak of.
            (Some(h), Some(v), Some(lux)) if h < hours => {
                if lux > 0.0 {
                    year.dgp[h] = v;
                    year.error[h] = error.and_then(number).unwrap_or(f64::NAN);
                    // The table rounds DGP, its class is that of the unrounded one.
                    let named = class.and_then(|c| GlareClass::from_name(words.get(c)?));
                    year.class[h] = f64::from(named.unwrap_or_else(|| GlareClass::of(v)) as u8);
                    year.illuminance[h] = lux;
                }
            }
            _ => {
                notes.push(format!("{}: a line was not understood: {line}", file.display()));
                break;
            }
        }
    }
    Some(year)
}

/// A result folder `out/NAME` of a checkout whose project is `scenes/NAME/project.toml`.
fn guess_project(folder: &Path) -> Option<PathBuf> {
    let folder = std::path::absolute(folder).ok()?;
    let project = folder.parent()?.parent()?.join("scenes").join(folder.file_name()?).join("project.toml");
    project.exists().then_some(project)
}

/// Scene and weather of a project, and where its sensors face.
fn read_room(
    project: &Path,
    groups: &mut [Group],
    windows: &[String],
    (states, shaded): (&mut HashMap<String, Vec<PathBuf>>, &mut HashSet<String>),
) -> Result<(Scene, Weather)> {
    let project = Project::read(project)?;
    let mut warnings = Warnings::new();
    let weather = Weather::read(&project.weather.file, &mut warnings)?;
    let base = project.folder();
    let files: Vec<PathBuf> = project.scene.files.iter().map(|f| f.strip_prefix(base).unwrap_or(f).to_path_buf()).collect();
    let mut scene = lucarne::scene::read_scene(&files, base, &mut warnings)?;
    for window in &project.windows {
        // A section of several windows names each after itself.
        let own = || windows.iter().filter(|n| **n == window.name || n.starts_with(&format!("{}-", window.name)));
        if window.states.len() > 1 {
            states.extend(own().map(|n| (n.clone(), window.states[1..].to_vec())));
        }
        if window.shade.is_some() || window.tensor_tree.is_some() {
            shaded.extend(own().cloned());
        }
    }
    // Windows are part of the outline.
    for window in &project.windows {
        let surface = window.surface.strip_prefix(base).unwrap_or(&window.surface);
        for w in lucarne::scene::read_windows(surface, base, &mut warnings)? {
            let surface = scene.surfaces.len() as u32;
            scene.surfaces.push(w.origin.clone());
            scene.triangles.extend(w.triangles.iter().map(|t| lucarne::scene::Triangle {
                vertices: *t,
                material: lucarne::scene::MaterialIndex(u32::MAX),
                surface,
            }));
        }
    }
    for section in &project.sensors {
        let sensors = lucarne::scene::read_sensors(&section.points, Some(&section.name), &mut warnings)?;
        if let Some(group) = groups.iter_mut().find(|g| g.name == section.name && g.len() == sensors.len()) {
            group.positions = sensors.iter().map(|s| s.position).collect();
            group.directions = sensors.iter().map(|s| s.direction).collect();
        }
    }
    Ok((scene, weather))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_those_of_the_table_also_at_the_limits_of_dgp() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("glare")).unwrap();
        let named = "hour,dgp,ev_lux,class\n0,0.350000,1,imperceptible\n1,0.350000,1,perceptible\n2,0.400000,1,perceptible\n\
                     3,0.450000,1,disturbing\n4,0.450001,1,intolerable\n";
        std::fs::write(folder.path().join("glare/named.csv"), named).unwrap();
        let unnamed = "hour,dgp,ev_lux\n0,0.35,1\n1,0.3501,1\n2,0.4,1\n3,0.45,1\n4,1,1\n";
        std::fs::write(folder.path().join("glare/unnamed.csv"), unnamed).unwrap();
        for year in read_glare(folder.path(), 5, &mut Vec::new()) {
            assert_eq!(year.class, [0.0, 1.0, 1.0, 2.0, 3.0], "{}", year.view);
        }
    }

    #[test]
    fn glare_tables_are_read_by_the_names_of_their_columns() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("glare")).unwrap();
        let text = "hour,dgp,dgp_standard_error,ev_lux,sources,class\n8,0.41,0.001,2000,2,disturbing\n9,0.2,0.001,900,0,imperceptible\n";
        std::fs::write(folder.path().join("glare/desk.csv"), text).unwrap();
        std::fs::write(folder.path().join("glare/undecided.csv"), "view,hour,dgp,dgp_standard_error,class,or\ndesk,8,0.4,0.1,a,b\n")
            .unwrap();
        std::fs::create_dir(folder.path().join("glare/tinted")).unwrap();
        std::fs::write(folder.path().join("glare/tinted/desk.csv"), "hour,dgp,ev_lux\n8,0.3,100\n9,0.0,0\n").unwrap();
        let mut notes = Vec::new();
        let glare = read_glare(folder.path(), 24, &mut notes);
        assert!(notes.is_empty() && glare.len() == 2 && glare[0].view == "desk" && glare[1].view == "desk, tinted", "{notes:?}");
        assert!(glare[1].dgp[9].is_nan(), "there is no glare in the dark");
        assert_eq!((glare[0].dgp[8], glare[0].error[8], glare[0].class[8], glare[0].dgp[9]), (0.41, 0.001, 2.0, 0.2));
        assert!(glare[1].error[8].is_nan(), "this table does not tell");
        assert_eq!((glare[0].illuminance[8], glare[1].illuminance[8]), (2000.0, 100.0));
        assert!(glare[0].dgp[0].is_nan());
    }

    #[test]
    fn eyes_and_ceilings_are_not_of_the_plan() {
        let lux = Arc::new(Matrix::zeros(3, 1, 1));
        let directions = vec![DVec3::Z, DVec3::Y, DVec3::NEG_Z];
        let mut group = Group { name: "desks".into(), positions: Vec::new(), directions, lux, error: None };
        assert_eq!([0, 1, 2].map(|s| group.is_of_plan(s)), [true, false, false]);
        group.directions.clear();
        assert!(group.is_of_plan(1), "without the project nothing tells where they face");
    }

    #[test]
    fn a_folder_without_results_is_told_so() {
        let folder = tempfile::tempdir().unwrap();
        let error = Results::open(folder.path()).err().unwrap().to_string();
        assert!(error.contains("summary.json") && error.contains("lucarne run"), "{error}");
    }
}
