//! The plan against the run: what is foretold is what is counted.

use super::plan;
use crate::error::Warnings;
use crate::gpu::Device;
use crate::progress::Silent;
use crate::simulate::project::{Preset, SunData};
use crate::simulate::{Inputs, Project, run};
use std::path::{Path, PathBuf};

/// How far the number of rays may be from the foretold one: paths end by chance.
const FACTOR: f64 = 1.5;

fn shipped() -> Vec<PathBuf> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    ["glass_room/project.toml", "asymmetric/project.toml", "office/project_gltf.toml", "office/project.toml", "blinds/project.toml"]
        .map(|p| scenes.join(p))
        .into()
}

#[test]
fn the_rays_of_every_phase_are_those_foretold() {
    let Some(device) = Device::for_tests("the plan against the run") else { return };
    for file in shipped() {
        let mut project = Project::read(&file).unwrap();
        project.quality.preset = Preset::Draft;
        for view in &mut project.views {
            view.resolution = [32, 32];
        }
        let inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
        let foretold = plan(&project, &inputs).unwrap();
        let out = tempfile::tempdir().unwrap();
        let summary = run(&device, &project, &inputs, out.path(), &Silent, &mut Warnings::new()).unwrap();
        let counted = |prefix: &str, names: &[&str]| -> f64 {
            let is = |name: &str| names.iter().any(|n| name == format!("{prefix}_{n}"));
            summary.matrices.iter().filter(|m| is(&m.name)).map(|m| m.rays as f64).sum()
        };
        let groups: Vec<&str> = inputs.sensors.iter().map(|g| g.name.as_str()).collect();
        let mut all = 0.0;
        for phase in foretold.costs.iter().filter(|p| p.rays > 0.0) {
            let (kind, name) = phase.name.split_once(" of ").unwrap();
            let run = match (kind, name) {
                // Groups are traced together.
                ("V", "sensors") => counted("V", &groups[..1]),
                ("DC", "sensors") => counted("DC", &groups[..1]),
                ("Cds", "sensors") => counted("C", &groups[..1]),
                ("suns", view) => counted("suns", &[view]),
                (kind, name) => counted(kind, &[name]),
            };
            eprintln!("{}: {}: {:.0} rays foretold, {run:.0} counted, {:.2}", file.display(), phase.name, phase.rays, phase.rays / run);
            assert!(run > 0.0 && phase.rays < FACTOR * run && run < FACTOR * phase.rays, "{}: {}", file.display(), phase.name);
            all += run;
        }
        assert!((all / summary.rays as f64 - 1.0).abs() < 0.02, "phases have {all} rays, the run {}", summary.rays);
    }
}

/// Suns through a pane are work of scattering functions: with 4 times the cells and twice the batches 8 times as
/// much. Measured at standard: 43 s for 7200 pixels and 363 suns.
#[test]
fn suns_through_panes_in_pictures_cost_their_scattering_functions() {
    let blinds = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/blinds");
    let mut project = Project::read(&blinds.join("project.toml")).unwrap();
    (project.windows[0].shade, project.windows[0].tensor_tree) =
        (None, Some(SunData::of_file(project.windows[0].bsdf_files()[0].to_path_buf())));
    let seconds = |project: &Project| {
        let inputs = Inputs::read(project, &mut Warnings::new()).unwrap();
        plan(project, &inputs).unwrap().costs.iter().find(|p| p.name == "suns of seat").unwrap().slow_seconds
    };
    let standard = seconds(&project);
    assert!((43.0 / FACTOR..43.0 * FACTOR).contains(&standard), "{standard}");
    project.quality.preset = Preset::Final;
    let grown = seconds(&project) / standard;
    assert!((7.0..8.0).contains(&grown), "{grown}");
}

/// The two kinds of work that rays do not show: states of the façade, and pictures.
#[test]
fn states_and_pictures_cost_what_they_are_more() {
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office");
    let mut project = Project::read(&office.join("project.toml")).unwrap();
    let seconds = |project: &Project, name: &str| {
        let inputs = Inputs::read(project, &mut Warnings::new()).unwrap();
        plan(project, &inputs).unwrap().costs.iter().filter(|p| p.name.starts_with(name)).map(|p| p.slow_seconds).sum::<f64>()
    };
    let one = seconds(&project, "glare of desk");
    assert!(one > 0.5, "{one}");
    assert_eq!(seconds(&project, "pictures"), 0.0);
    project.images.hours = crate::simulate::project::views::ImageHours::Chosen(vec![12, 4716]);
    let two = seconds(&project, "pictures");
    project.images.hours = crate::simulate::project::views::ImageHours::Daylight;
    assert!((seconds(&project, "pictures") / two - 4405.0 / 2.0).abs() < 1e-6);
    project.images.hours = crate::simulate::project::views::ImageHours::None;
    project.sensors.clear();
    let file = project.windows[0].bsdf_files()[0].to_path_buf();
    project.give_states(0, &vec![file; 3]);
    assert!((seconds(&project, "glare of desk") / one - 3.0).abs() < 1e-9);
}
