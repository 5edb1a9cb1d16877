//! Tables of annual glare, read back: `glare/VIEW.csv` of every view, `glare/STATE/VIEW.csv` of every state.

use crate::glare::annual::GlareClass;
use std::path::{Path, PathBuf};

/// Glare of one view over the year, in one state of the façade; arrays by time step.
#[derive(Debug, Clone, PartialEq)]
pub struct GlareYear {
    /// The view's name.
    pub view: String,
    /// The state's name; empty if there is only one.
    pub state: String,
    /// DGP (DGPs, eDGPs); NaN where there is no light.
    pub dgp: Vec<f64>,
    /// Its standard error; NaN where it is not known.
    pub standard_error: Vec<f64>,
    /// Class; nothing where there is no light.
    pub class: Vec<Option<GlareClass>>,
    /// Illuminance at the eye, lx; NaN where there is no light.
    pub illuminance: Vec<f64>,
}

impl GlareYear {
    /// Name of the view, with that of the state.
    pub fn name(&self) -> String {
        if self.state.is_empty() { self.view.clone() } else { format!("{}, {}", self.view, self.state) }
    }
}

/// All tables below a folder `glare`; `steps` are those of the year. Lines that are not understood are
/// told in `notes`.
pub(crate) fn read_years(folder: &Path, steps: usize, notes: &mut Vec<String>) -> Vec<GlareYear> {
    let inside = |folder: &Path| -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
        paths.sort();
        paths
    };
    let mut files: Vec<(String, PathBuf)> = Vec::new();
    for path in inside(folder) {
        if path.is_dir() {
            let state = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            files.extend(inside(&path).into_iter().map(|p| (state.clone(), p)));
        } else {
            files.push((String::new(), path));
        }
    }
    let tables = files.into_iter().filter(|(_, p)| p.extension().is_some_and(|e| e == "csv"));
    tables.filter_map(|(state, file)| read_hours(&file, state, steps, notes)).collect()
}

/// One table of steps; other tables (of all views) are none.
fn read_hours(file: &Path, state: String, steps: usize, notes: &mut Vec<String>) -> Option<GlareYear> {
    let text = std::fs::read_to_string(file).ok()?;
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next()?.split(',').map(str::trim).collect();
    let column = |name: &str| columns.iter().position(|c| *c == name);
    let (hour, dgp, light) = (column("hour")?, column("dgp")?, column("ev_lux")?);
    let (error, class) = (column("dgp_standard_error"), column("class"));
    let view = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let none = || vec![f64::NAN; steps];
    let mut year = GlareYear { view, state, dgp: none(), standard_error: none(), class: vec![None; steps], illuminance: none() };
    // A row per time step: then the hour of the year in it only names the step.
    let whole = text.lines().count() == steps + 1;
    for (row, line) in lines.enumerate() {
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |i: usize| words.get(i).and_then(|w| w.parse::<f64>().ok());
        let step = if whole { Some(row) } else { words.get(hour).and_then(|w| w.parse::<usize>().ok()) };
        match (step, number(dgp), number(light)) {
            // Without light there is no glare to speak of.
            (Some(step), Some(v), Some(lux)) if step < steps => {
                if lux > 0.0 {
                    year.dgp[step] = v;
                    year.standard_error[step] = error.and_then(number).unwrap_or(f64::NAN);
                    // The table rounds DGP, its class is that of the unrounded one.
                    let named = class.and_then(|c| GlareClass::from_name(words.get(c)?));
                    year.class[step] = Some(named.unwrap_or_else(|| GlareClass::of(v)));
                    year.illuminance[step] = lux;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_those_of_the_table_also_at_the_limits_of_dgp() {
        use GlareClass::{Disturbing, Imperceptible, Intolerable, Perceptible};
        let folder = tempfile::tempdir().unwrap();
        let named = "hour,dgp,ev_lux,class\n0,0.350000,1,imperceptible\n1,0.350000,1,perceptible\n2,0.400000,1,perceptible\n\
                     3,0.450000,1,disturbing\n4,0.450001,1,intolerable\n";
        std::fs::write(folder.path().join("named.csv"), named).unwrap();
        let unnamed = "hour,dgp,ev_lux\n0,0.35,1\n1,0.3501,1\n2,0.4,1\n3,0.45,1\n4,1,1\n";
        std::fs::write(folder.path().join("unnamed.csv"), unnamed).unwrap();
        for year in read_years(folder.path(), 5, &mut Vec::new()) {
            assert_eq!(year.class, [Imperceptible, Perceptible, Perceptible, Disturbing, Intolerable].map(Some), "{}", year.view);
        }
    }

    #[test]
    fn glare_tables_are_read_by_the_names_of_their_columns() {
        let folder = tempfile::tempdir().unwrap();
        let text = "hour,dgp,dgp_standard_error,ev_lux,sources,class\n8,0.41,0.001,2000,2,disturbing\n9,0.2,0.001,900,0,imperceptible\n";
        std::fs::write(folder.path().join("desk.csv"), text).unwrap();
        std::fs::write(folder.path().join("undecided.csv"), "view,hour,dgp,dgp_standard_error,class,or\ndesk,8,0.4,0.1,a,b\n").unwrap();
        std::fs::create_dir(folder.path().join("tinted")).unwrap();
        std::fs::write(folder.path().join("tinted/desk.csv"), "hour,dgp,ev_lux\n8,0.3,100\n9,0.0,0\n").unwrap();
        let mut notes = Vec::new();
        let glare = read_years(folder.path(), 24, &mut notes);
        assert!(notes.is_empty() && glare.len() == 2 && glare[0].name() == "desk" && glare[1].name() == "desk, tinted", "{notes:?}");
        assert!(glare[1].dgp[9].is_nan(), "there is no glare in the dark");
        assert_eq!((glare[0].dgp[8], glare[0].standard_error[8], glare[0].dgp[9]), (0.41, 0.001, 0.2));
        assert_eq!(glare[0].class[8], Some(GlareClass::Disturbing));
        assert!(glare[1].standard_error[8].is_nan(), "this table does not tell");
        assert_eq!((glare[0].illuminance[8], glare[1].illuminance[8]), (2000.0, 100.0));
        assert!(glare[0].dgp[0].is_nan());
    }
}
