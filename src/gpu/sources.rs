//! The WGSL files, embedded in the program. A test compares this table with the folder.

macro_rules! sources {
    ($($path:literal),* $(,)?) => {
        /// Path below `shaders/` without `.wgsl`, and text, of every shader file.
        pub const SOURCES: &[(&str, &str)] = &[$(($path, include_str!(concat!("../../shaders/", $path, ".wgsl")))),*];
    };
}

// One line per file, in alphabetical order.
sources![
    "bsdf_generation/chain",
    "bsdf_generation/chain_start",
    "bsdf_generation/chain_walk",
    "bsdf_generation/directions",
    "bsdf_generation/fans",
    "bsdf_generation/paths",
    "bsdf_generation/sample",
    "bsdf_scattering/sample",
    "bsdf_scattering/scattering",
    "bsdf_scattering/square",
    "coefficients/deposit",
    "coefficients/direct",
    "coefficients/entering",
    "coefficients/gather",
    "coefficients/paths",
    "coefficients/starts",
    "coefficients/sun_starts",
    "coefficients/sunlight",
    "daylight_matrix/paths",
    "diagnostic/loop_limit",
    "diagnostic/probe_bins",
    "diagnostic/probe_bsdf",
    "diagnostic/probe_circle",
    "diagnostic/probe_leaks",
    "diagnostic/probe_material",
    "diagnostic/probe_random",
    "diagnostic/probe_rays",
    "diagnostic/probe_windows",
    "glare/add",
    "glare/compact",
    "glare/count",
    "glare/list",
    "image_matrix/direct",
    "image_matrix/gather",
    "image_matrix/receivers",
    "light_paths/compact",
    "light_paths/images",
    "light_paths/near",
    "light_paths/paths",
    "product/gemm_subgroup",
    "product/gemm_tiled",
    "product/pack",
    "shared/bins",
    "shared/bvh",
    "shared/circle",
    "shared/connection",
    "shared/counters",
    "shared/disc",
    "shared/frame",
    "shared/gathering",
    "shared/gemm",
    "shared/material",
    "shared/outside",
    "shared/pixel",
    "shared/random",
    "shared/scene",
    "shared/sky",
    "shared/window",
    "sun_matrix/candidates",
    "sun_matrix/direct",
    "sun_matrix/follow_path",
    "sun_matrix/gates",
    "sun_matrix/links",
    "sun_matrix/mirrored",
    "sun_matrix/pairs",
    "sun_matrix/pane",
    "sun_matrix/pane_gather",
    "sun_matrix/pane_suns",
    "sun_matrix/paths",
    "sun_matrix/pixels",
    "sun_matrix/scattered",
    "sun_matrix/shade_points",
    "sun_matrix/sun",
    "view_matrix/direct",
    "view_matrix/gather",
];

/// The text of a shader file, by its path below `shaders/` without `.wgsl`.
pub fn source(path: &str) -> Option<&'static str> {
    SOURCES.iter().find(|(p, _)| *p == path).map(|&(_, text)| text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn collect(folder: &Path, root: &Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(&path, root, found);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                let relative = path.with_extension("").strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
                found.push(relative);
            }
        }
    }

    #[test]
    fn the_table_lists_every_file_once_and_in_order() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
        let mut found = Vec::new();
        collect(&root, &root, &mut found);
        found.sort();
        let listed: Vec<&str> = SOURCES.iter().map(|(p, _)| *p).collect();
        assert_eq!(listed, found, "add or remove the line in src/gpu/sources.rs");
    }
}
