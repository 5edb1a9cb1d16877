//! Every key of a project file, with its text. [`page`] is the reference of the guide; a test holds the reader to this
//! table, so that no key is taken without its text, and none is described that is not taken.

use std::fmt::Write;

/// A section of a project file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Section {
    /// Its name.
    pub name: &'static str,
    /// Whether there may be several (`[[name]]`).
    pub repeated: bool,
    /// What it says, in a sentence.
    pub meaning: &'static str,
    /// Its keys.
    pub keys: &'static [Key],
}

/// A key of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What stands there: a kind of value with its unit, or the words that may.
    pub value: &'static str,
    /// What holds where it is left out.
    pub default: &'static str,
    /// What it means, in a sentence.
    pub meaning: &'static str,
}

const fn key(name: &'static str, value: &'static str, default: &'static str, meaning: &'static str) -> Key {
    Key { name, value, default, meaning }
}

/// All sections.
pub const SECTIONS: &[Section] = &[
    Section {
        name: "weather",
        repeated: false,
        meaning: "The time steps, and what makes the sky and sun of each. Required.",
        keys: &[
            key(
                "file",
                "path: WEA or EPW",
                "a `sky`, a `sky_matrix` or `[[moment]]` in its place",
                "Weather: its steps, Perez' sky of its radiation, the real sun. Beside `sky_matrix` it tells the times only.",
            ),
            key(
                "sky",
                "`cie clear`, `cie intermediate`, `cie overcast`, `cie uniform`",
                "–",
                "A sky of the CIE in place of a file, in the moments of `date`.",
            ),
            key(
                "date",
                "`MM-DDThh:mm` or a list, standard time",
                "without `site` noon of 21 March",
                "Moments under `sky`; times of the columns of `sky_matrix`.",
            ),
            key(
                "site",
                "[latitude, longitude, standard meridian], degrees north and east",
                "10,000 lx outdoors, of overcast and uniform skies only",
                "Where the sun of `date` or `[[moment]]` is seen from.",
            ),
            key(
                "sky_matrix",
                "path: rows the ground and the patches of MF:1 … 6, columns steps, W/m²sr",
                "–",
                "A sky made elsewhere, as `gendaymtx` writes it; already turned to the scene's north.",
            ),
            key(
                "sky_matrix_direct",
                "path, or `none`",
                "required where suns are traced",
                "The sun's share of `sky_matrix` (`gendaymtx -d`); `none`: the sky holds no sun.",
            ),
            key(
                "sun_matrix",
                "path: one sun a column",
                "required where suns are traced, but with `none`",
                "The suns of `sky_matrix` (`gendaymtx -5 0.533 -d -m 6`); their MF is that of the suns.",
            ),
            key(
                "timestep",
                "minutes: 1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60",
                "the file's",
                "Steps are divided, with the sun where it stands in each part, or joined; no sum changes.",
            ),
            key(
                "period",
                "`MM-DD`, or [first, last]",
                "all days",
                "Days that are computed, both ends included; over New Year if the last comes first.",
            ),
            key(
                "hours",
                "a list of hours of the year from 0, or path: a schedule of 8760 or 8784 values",
                "all hours",
                "Hours that are computed: those listed, or those whose value (the last column) is above 0.",
            ),
            key("north", "degrees", "0", "Where north lies in the scene: from +Y, counter-clockwise seen from above."),
            key("ground_albedo", "0 … 1", "0.2", "Reflectance of the ground beyond what the scene has of it."),
        ],
    },
    Section {
        name: "moment",
        repeated: true,
        meaning: "Named moments under skies of the CIE, in place of `file`, `sky` and `date` of `[weather]`; `site` stands there. The table `GROUP_moments.csv` has a row for each.",
        keys: &[
            key("name", "text", "required", "Its name in tables."),
            key("sky", "as `sky` of `[weather]`", "required", "The sky."),
            key("date", "`MM-DDThh:mm`, standard time", "required with a `site`", "The time."),
        ],
    },
    Section {
        name: "scene",
        repeated: false,
        meaning: "The room and what stands around it, without the windows that are named. Required.",
        keys: &[
            key(
                "files",
                "list of paths: `.rad`, `.obj`, `.gltf`, `.glb`, `.hbjson`",
                "required without `model`",
                "Scene files; Radiance's in the order in which Radiance would get them.",
            ),
            key(
                "model",
                "path: `.hbjson`, or a folder of honeybee-radiance",
                "–",
                "A Honeybee model, whose windows, grids and views are taken where the project names none.",
            ),
        ],
    },
    Section {
        name: "window",
        repeated: true,
        meaning: "A window. Without any, panes of glass and surfaces of `BSDF` and `aBSDF` between indoors and the sky are taken for windows. Exactly one of `glass`, `bsdf`, `glazing`, `interpolate`, `states`, `[[window.state]]` says what it is made of.",
        keys: &[
            key("name", "text", "required", "Its name in results and messages."),
            key("surface", "path, `FILE#PART` of models", "required", "Its polygons, whose normals point into the room."),
            key(
                "glass",
                "0 … 1, or `scene`",
                "–",
                "A clear pane of this visible transmittance at normal incidence; `scene`: the glass that the scene has there.",
            ),
            key("bsdf", "path: XML", "–", "Scattering data."),
            key("glazing", "list of layers, from outside to inside", "–", "Layers in the words of `lucarne bsdf layer`."),
            key(
                "interpolate",
                "[path, path, 0 … 1]: XML",
                "–",
                "Scattering data so far on the way from the first file's to the second's, in every value.",
            ),
            key("states", "list of paths: XML", "–", "Short for `[[window.state]]` with `bsdf`, named after the files."),
            key(
                "group",
                "text",
                "the window's name",
                "Windows of one group change their states together; these have the same names in the same order.",
            ),
            key("shade", "path", "–", "Real slats and panes that five phases trace the sun through."),
            key(
                "tensor_tree",
                "path: XML, or `own`",
                "–",
                "Scattering data that five phases trace the sun through, of high resolution; `own`: those that the window is made of.",
            ),
            key(
                "peak",
                "true or false",
                "true",
                "Whether a through-peak of `tensor_tree` is a clear view, as of Radiance's `aBSDF`; false: it fills its bin, as of `BSDF`.",
            ),
            key("daylight", "path: matrix", "traced", "D made elsewhere: rows bins, columns patches, the ground first."),
            key("daylight_direct", "path: matrix", "required by five phases beside `daylight`", "Its direct part, Dd."),
            key(
                "parts",
                "`auto`, a number up to 256, or [columns, rows]",
                "1: the whole window",
                "Parts over each of which V and D are averages; `auto`: as many as a first look at what shades the window says.",
            ),
        ],
    },
    Section {
        name: "window.state",
        repeated: true,
        meaning: "A state of the window above it, in place of what the window is made of. View and daylight matrices are computed once for all states.",
        keys: &[
            key("name", "text", "required", "Its name in results and schedules."),
            key("glass", "as of `[[window]]`", "–", "A clear pane, which suns are traced through."),
            key("bsdf", "path: XML", "–", "Scattering data."),
            key("glazing", "as of `[[window]]`", "–", "Layers."),
            key("interpolate", "as of `[[window]]`", "–", "Scattering data between two files'."),
            key("shade", "path", "–", "Real slats and panes that five phases trace the sun through in this state."),
            key(
                "tensor_tree",
                "path: XML, or `own`",
                "–",
                "Scattering data that five phases trace the sun through in this state; `own`: those that the state is made of.",
            ),
            key("peak", "true or false", "true", "As of `[[window]]`."),
        ],
    },
    Section {
        name: "control",
        repeated: false,
        meaning: "The state of each group of windows in every time step; illuminance, pictures, glare and metrics follow it. Each key is a group.",
        keys: &[key(
            "GROUP",
            "path: CSV with a state per time step or hour of the year; the name of a state; `{ rule = \"…\" }`; `lm-83` or `{ lm-83 = [\"open\", \"closed\"] }`; `optimal`",
            "the group's first state",
            "What decides the state of this group of windows.",
        )],
    },
    Section {
        name: "optimal",
        repeated: false,
        meaning: "What the best states are of the groups that `[control]` calls `optimal`. It needs at least one of `eyes`, `dgp`, `sunlit`, `most`.",
        keys: &[
            key("aim", "`daylight`, `lighting`, `moves`", "`daylight`", "Most daylight, least power for lights, or fewest moves."),
            key("eyes", "name of `[[sensors]]`", "no limit of glare", "Sensors at eyes, whose DGPs stays at or below `dgps`."),
            key("dgps", "0.2 … 1", "0.4", "Most DGPs = 6.22e-5 Ev + 0.184 at any eye."),
            key("dgp", "0.2 … 1", "no limit", "Most DGP of the views by `[glare]`, of up to 100 combinations of states."),
            key("views", "names of `[[view]]`", "all views", "The views that `dgp` limits."),
            key("sunlit", "%", "no limit", "Most of the sensors that face up with more than 1000 lx of direct sun."),
            key("most", "lx", "no limit", "Most illuminance of any sensor that faces up."),
            key("target", "lx", "500", "Illuminance that lights fill up to, each sensor's for itself."),
            key("least_power", "0 … 1", "0.1", "Power of lights that are dimmed down, as a share of all of it."),
        ],
    },
    Section {
        name: "sensors",
        repeated: true,
        meaning: "A group of sensors.",
        keys: &[
            key("name", "text", "required", "Its name in results."),
            key("points", "path: lines `x y z dx dy dz`, `FILE#PART` of models", "required without `surface`", "Positions and directions."),
            key("surface", "a material, a surface's name, or a path of polygons", "–", "Sensors are spread over it."),
            key("spacing", "scene's unit", "required with `surface`", "Distance of neighbours."),
            key("height", "scene's unit", "0.8", "Height above the surface."),
            key("margin", "scene's unit", "0", "Distance from its edge."),
            key("view", "path: matrix", "traced", "V made elsewhere: rows sensors, columns the bins of all windows."),
            key("view_direct", "path: matrix", "required by five phases beside `view`", "Its direct part, Vd."),
            key("sun", "path: matrix", "traced", "Cds made elsewhere: rows sensors, columns suns."),
        ],
    },
    Section {
        name: "view",
        repeated: true,
        meaning: "A camera, for pictures and glare.",
        keys: &[
            key("name", "text", "required", "Its name in results."),
            key("file", "path: view file, `FILE#PART` of models", "required", "A line of Radiance's view options."),
            key("resolution", "[columns, rows], pixels", "[512, 512]", "The most of each; pixels stay square."),
            key("view", "pattern: `v%03d.hdr`", "traced", "Pictures V made elsewhere."),
            key("view_direct", "pattern", "required by five phases beside `view`", "Their direct part."),
            key("sun", "pattern", "traced", "Pictures of suns made elsewhere."),
        ],
    },
    Section {
        name: "views",
        repeated: true,
        meaning: "Fisheye views on many points.",
        keys: &[
            key("name", "text", "required", "Views are called `NAME-001`, or `NAME-001-090` with directions."),
            key("points", "path: lines `x y z dx dy dz`", "required", "Eyes."),
            key("directions", "list of degrees from north, clockwise", "the points' own", "Where each eye looks to."),
            key("resolution", "[columns, rows], pixels", "[360, 360]", "The most of each."),
        ],
    },
    Section {
        name: "glare",
        repeated: false,
        meaning: "Glare of all views in every step. Left out: none.",
        keys: &[
            key("method", "`image`, `edgps`, `dgps`, `imageless`", "`image`", "How sources and vertical illuminance are found."),
            key("constants", "`evalglare`, `original`", "`evalglare`", "Constants of DGP."),
            key("low_light_correction", "true or false", "false", "Correction of DGP for low light."),
            key("task", "[column, row from below, opening angle in rad]", "–", "Task area."),
            key(
                "threshold",
                "above 100 cd/m², else a factor",
                "2000 cd/m²; with a task five times its mean",
                "What is a source (`evalglare -b`).",
            ),
            key("search_radius", "rad", "0.2", "Distance in which pixels join one source (`-r`)."),
            key("peaks", "true or false", "true", "Whether peaks are sources of their own (`-y`, `-x`)."),
            key("peak_limit", "cd/m²", "50,000", "What is a peak (`-Y`)."),
            key("position_index", "`guth`, `kim`, `guth_iwata`", "`guth`", "Position index."),
            key("field_of_view", "`whole`, `total`, `binocular`", "`whole`", "Part of the picture that counts (`-G`)."),
            key("veil", "degrees, 0.01 … 20", "–", "Full width at half maximum of the spread of peaks."),
            key("occupied", "[from, to], hours of the day", "[8, 18]", "Hours that annual sums count."),
        ],
    },
    Section {
        name: "images",
        repeated: false,
        meaning: "Pictures of hours.",
        keys: &[
            key("hours", "`daylight`, `none`, or a list of hours of the year from 0", "`none`", "Hours whose pictures are written."),
            key("components", "true or false", "false", "Whether V, Vd and the suns are written as pictures too."),
        ],
    },
    Section {
        name: "method",
        repeated: false,
        meaning: "What is computed.",
        keys: &[
            key("phases", "`auto`, `direct`, 2, 3, 5", "`auto`", "The formula; `lucarne plan` says which `auto` takes, and why."),
            key("suns", "1 … 6 (Reinhart MF), or `hourly`", "five phases 6, direct ones `hourly`", "Where suns stand."),
            key("sky_subdivision", "`auto`, or 1 … 6 (Reinhart MF)", "`auto`: 4, of diffuse panels 2", "Division of the sky."),
            key("bounces", "0 … 10,000", "no limit: Russian roulette", "Most diffuse reflections (`-ab`)."),
        ],
    },
    Section {
        name: "quality",
        repeated: false,
        meaning: "How much is sampled: at most one of `preset`, `rounds`, and `target_error` with or without `time_limit`.",
        keys: &[
            key("preset", "`draft`, `standard`, `final`", "`standard`", "Samples, aimed at a standard error of 5, 2, 0.5 %."),
            key("target_error", "0.0001 … 0.5", "–", "Sampling ends at this relative standard error of a year."),
            key("time_limit", "a number and `s`, `min` or `h`", "–", "Sampling ends after this time."),
            key("rounds", "a whole number", "–", "Sampling ends after so many rounds: repeats what a time limit came to."),
            key("seed", "0 … 4,294,967,295", "1", "Seed of all random numbers."),
        ],
    },
    Section {
        name: "metrics",
        repeated: false,
        meaning: "Named metrics of the year, and which hours count.",
        keys: &[
            key("occupancy", "`lm-83`, `en-17037`, or a path: CSV of 0 or 1", "`lm-83`", "Hours of DA, cDA, UDI and vertical illuminance."),
            key(
                "metrics",
                "list of `autonomy`, `exposure`, `lm-83`, `leed`, `en-17037`, `daylight-factor`, `vertical`, `glare`",
                "all of them",
                "What is judged.",
            ),
            key("autonomy", "lx", "300", "Illuminance of DA and cDA."),
            key("useful", "[lx, lx, lx], rising", "[100, 300, 3000]", "Limits of UDI's four bands."),
            key("daylight_saving", "[MM-DD, MM-DD]", "standard time", "First day of summer time and first day without, for LM-83's clock."),
            key("openings", "`side`, `roof`", "`side`", "EN 17037's table of daylight provision: A.1, or A.2 for horizontal openings."),
            key("median_diffuse", "lx", "of the weather", "Median diffuse illuminance outdoors of EN 17037's method 1."),
            key("sunlight_date", "MM-DD", "03-21", "Day of EN 17037's exposure to sunlight, from 1 February to 21 March."),
            key(
                "sunlight_altitude",
                "0 … 60 degrees",
                "10",
                "Least altitude of the sun that counts there; the standard's depends on the place.",
            ),
        ],
    },
    Section {
        name: "output",
        repeated: false,
        meaning: "What sensors tell.",
        keys: &[key(
            "quantity",
            "`illuminance`, `irradiance`",
            "`illuminance`",
            "Lux, or W/m² of the whole solar spectrum (`gendaymtx -O1`).",
        )],
    },
];

impl Section {
    /// Its part of the reference, in Markdown.
    pub fn page(&self) -> String {
        let name = if self.repeated { format!("[[{}]]", self.name) } else { format!("[{}]", self.name) };
        let mut text = format!("## `{name}`\n\n{}\n\n| key | value | left out | meaning |\n|---|---|---|---|\n", self.meaning);
        for key in self.keys {
            // Writing into a text cannot fail.
            let _ = writeln!(text, "| `{}` | {} | {} | {} |", key.name, key.value, key.default, key.meaning);
        }
        text
    }
}

/// The reference as a page of Markdown.
pub fn page() -> String {
    let head = "# All keys of a project file\n\nWritten by `lucarne keys`. Paths are relative to the project file. Sections in double \
                brackets may be several.\n";
    let sections: Vec<String> = SECTIONS.iter().map(Section::page).collect();
    format!("{head}\n{}", sections.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::super::table::asked::asked_keys;
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_reader_takes_the_keys_of_this_table_and_no_others() {
        let described: BTreeSet<(String, String)> = SECTIONS
            .iter()
            .flat_map(|s| s.keys.iter().map(|k| (s.name.to_string(), k.name.to_string())))
            .chain(
                SECTIONS
                    .iter()
                    .map(|s| s.name.rsplit_once('.').unwrap_or(("", s.name)))
                    .map(|(of, name)| (of.to_string(), name.to_string())),
            )
            .collect();
        let count: usize = SECTIONS.iter().map(|s| s.keys.len() + 1).sum();
        assert_eq!(described.len(), count, "a section or key stands twice");
        let folder = tempfile::tempdir().unwrap();
        for file in ["a.wea", "r.rad", "w.rad", "b.xml", "m.mtx"] {
            std::fs::write(folder.path().join(file), "").unwrap();
        }
        std::fs::write(folder.path().join("p.txt"), "0 0 1 0 1 0\n").unwrap();
        std::fs::write(folder.path().join("v.vf"), "rvu -vta -vh 180 -vv 180\n").unwrap();
        let text = "[weather]\nsite = [46, 11, 15]\n[[moment]]\nname = \"n\"\nsky = \"cie clear\"\ndate = \"03-21T12:00\"\n\
                    [scene]\nfiles = [\"r.rad\"]\n[[window]]\nname = \"w\"\nsurface = \"w.rad\"\nbsdf = \"b.xml\"\n\
                    [[window]]\nname = \"m\"\nsurface = \"w.rad\"\n[[window.state]]\nname = \"a\"\nglass = 0.5\n[control]\nm = \"optimal\"\n\
                    [[sensors]]\nname = \"s\"\npoints = \"p.txt\"\n[[view]]\nname = \"v\"\nfile = \"v.vf\"\n\
                    [[views]]\nname = \"vs\"\npoints = \"p.txt\"\n[glare]\n[metrics]\n[optimal]\nmost = 3000\n[images]\n[method]\n[quality]\n[output]\n";
        let file = folder.path().join("p.toml");
        let asked = asked_keys(|| super::super::Project::parse(&file, text).map(|_| ()).unwrap());
        let without: Vec<_> = asked.difference(&described).collect();
        assert!(without.is_empty(), "keys without their text in {}: {without:?}", file!());
        let unknown: Vec<_> = described.difference(&asked).collect();
        assert!(unknown.is_empty(), "keys that the reader does not ask for: {unknown:?}");
    }

    #[test]
    fn the_guide_s_page_is_this_table() {
        let page_of_guide = include_str!("../../guide/keys.md");
        assert!(page_of_guide == page(), "write the page anew: lucarne keys > src/guide/keys.md");
    }

    #[test]
    fn every_key_has_its_text() {
        for key in SECTIONS.iter().flat_map(|s| s.keys) {
            let sentence = key.meaning.ends_with('.') && key.meaning.chars().next().is_some_and(char::is_uppercase);
            assert!(sentence && !key.value.is_empty() && !key.default.is_empty() && !key.meaning.contains('|'), "{key:?}");
        }
    }
}
