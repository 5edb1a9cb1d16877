//! The WGSL files, embedded in the program. A test compares this table with the folder.

macro_rules! sources {
    ($($path:literal),* $(,)?) => {
        /// Path below `shaders/` without `.wgsl`, and text, of every shader file.
        pub const SOURCES: &[(&str, &str)] = &[$(($path, include_str!(concat!("../../shaders/", $path, ".wgsl")))),*];
    };
}

// One line per file, in alphabetical order.
sources![
    "bsdf/chain",
    "bsdf/chain_start",
    "bsdf/chain_walk",
    "bsdf/directions",
    "bsdf/fans",
    "bsdf/paths",
    "bsdf/sample",
    "bsdf/scattering",
    "bsdf/scattering_sample",
    "bsdf/square",
    "diagnostic/loop_limit",
    "diagnostic/probe_bins",
    "diagnostic/probe_bsdf",
    "diagnostic/probe_leaks",
    "diagnostic/probe_material",
    "diagnostic/probe_random",
    "diagnostic/probe_rays",
    "diagnostic/probe_windows",
    "glare/add",
    "glare/compact",
    "glare/count",
    "glare/list",
    "product/gemm_subgroup",
    "product/gemm_tiled",
    "product/pack",
    "shared/bins",
    "shared/bvh",
    "shared/counters",
    "shared/frame",
    "shared/gates",
    "shared/gemm",
    "shared/material",
    "shared/mirrored",
    "shared/pairs",
    "shared/pane",
    "shared/pixel",
    "shared/random",
    "shared/sky",
    "shared/sun",
    "shared/sun_path",
    "shared/window",
    "trace/daylight_paths",
    "trace/light_compact",
    "trace/light_paths",
    "trace/pane_clear",
    "trace/pane_facade",
    "trace/pane_gather",
    "trace/pane_receivers",
    "trace/pane_suns",
    "trace/pixel_direct",
    "trace/pixel_gather",
    "trace/pixel_receivers",
    "trace/sun_candidates",
    "trace/sun_gather",
    "trace/sun_pixels",
    "trace/sun_rays",
    "trace/sun_scattered",
    "trace/sun_shade_links",
    "trace/sun_shade_points",
    "trace/sun_straight",
    "trace/sun_vertices",
    "trace/view_direct",
    "trace/view_gather",
    "trace/view_images",
    "trace/view_near",
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
