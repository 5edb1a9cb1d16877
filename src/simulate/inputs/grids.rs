//! Sensors of a group: listed in a file, or spread over surfaces of the room.

use super::reach::{Light, are_enclosed};
use crate::error::{Error, Result, Warnings};
use crate::scene::grid::{self, Spread};
use crate::scene::points::Sensor;
use crate::scene::{self, Scene};
use crate::simulate::project::{Project, SensorPoints, SensorsSection};
use glam::DVec3;
use std::path::Path;

/// Names of surfaces or materials that a message lists.
const NAMED: usize = 12;

/// The sensors of a group. Of those spread over a surface the ones from which no way to light is found are left
/// out: they are inside walls or furniture, or outside the room.
///
/// # Errors
/// What is wrong in which file; a surface that the scene does not have.
pub(crate) fn sensors(
    project: &Project,
    section: &SensorsSection,
    scene: &Scene,
    light: Light<'_>,
    warnings: &mut Warnings,
) -> Result<Vec<Sensor>> {
    let field = format!("sensors '{}'", section.name);
    let (triangles, spread) = match &section.points {
        SensorPoints::File(file) => return scene::read_sensors(file, Some(&section.name), warnings),
        SensorPoints::OverFile(file, spread) => (in_file(file, project, warnings)?, spread),
        SensorPoints::OverSurface(name, spread) => (of_name(name, scene).map_err(|e| e.file(&project.file).field(&field))?, spread),
    };
    let all = grid::over(&triangles, spread).map_err(|e| e.file(&project.file).field(&field))?;
    let dark = are_enclosed(scene, light, &all);
    let left = dark.iter().filter(|d| **d).count();
    // All of them: something else is wrong, and the warning of dark sensors says what.
    if left == 0 || left == all.len() {
        return Ok(all);
    }
    warnings.push(
        Error::new(format!(
            "{left} of {} points of '{}' are left out: no light finds its way to them, so that they are inside walls or furniture, or outside",
            all.len(),
            section.name
        ))
        .file(&project.file)
        .field(&field)
        .help(help(spread)),
    );
    let kept = all.into_iter().zip(dark).filter(|(_, dark)| !dark).map(|(s, _)| s);
    Ok(kept.enumerate().map(|(i, s)| Sensor { line: i + 1, ..s }).collect())
}

fn help(spread: &Spread) -> String {
    format!(
        "this is as it should be if furniture reaches {} above the surface; otherwise look for a closed space around these points",
        spread.height
    )
}

/// The polygons of a file; their materials need not be known.
fn in_file(file: &Path, project: &Project, warnings: &mut Warnings) -> Result<Vec<[DVec3; 3]>> {
    let base = project.folder();
    let own = file.strip_prefix(base).unwrap_or(file);
    let windows = scene::read_windows(own, base, warnings)?;
    Ok(windows.into_iter().flat_map(|w| w.triangles).collect())
}

/// Surfaces of the scene of a material, or else of a name.
fn of_name(name: &str, scene: &Scene) -> Result<Vec<[DVec3; 3]>> {
    let material = |t: &scene::Triangle| scene.materials.get(t.material.0 as usize).is_some_and(|m| m.name == name);
    let surface = |t: &scene::Triangle| scene.surfaces.get(t.surface as usize).is_some_and(|s| s.name == name);
    let pick = |wanted: &dyn Fn(&scene::Triangle) -> bool| -> Vec<[DVec3; 3]> {
        scene.triangles.iter().filter(|t| wanted(t)).map(|t| t.vertices).collect()
    };
    let found = pick(&material);
    let found = if found.is_empty() { pick(&surface) } else { found };
    if !found.is_empty() {
        return Ok(found);
    }
    let mut names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let alike = names.iter().find(|n| n.eq_ignore_ascii_case(name));
    let help = match alike {
        Some(alike) => format!("did you mean '{alike}'?"),
        None => format!(
            "name a material or surface of the scene, or a .rad file of polygons; materials in use: {}{}",
            names.iter().take(NAMED).copied().collect::<Vec<_>>().join(", "),
            if names.len() > NAMED { ", …" } else { "" }
        ),
    };
    Err(Error::new(format!("the scene has neither a material nor a surface '{name}'")).help(help))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of 4 by 3 by 3 m with a window in its south wall and a closed cabinet of 1 by 1 by 1.5 m in a corner.
    const ROOM: &str = "void plastic floor 0 0 5 .3 .3 .3 0 0\nvoid plastic wall 0 0 5 .5 .5 .5 0 0\nvoid plastic wood 0 0 5 .5 .4 .3 0 0\n\
        floor polygon ground 0 0 12 0 0 0 4 0 0 4 3 0 0 3 0\nwall polygon top 0 0 12 0 0 3 0 3 3 4 3 3 4 0 3\n\
        wall polygon w 0 0 12 0 0 0 0 3 0 0 3 3 0 0 3\nwall polygon e 0 0 12 4 0 0 4 0 3 4 3 3 4 3 0\nwall polygon n 0 0 12 0 3 0 4 3 0 4 3 3 0 3 3\n\
        wall polygon s 0 0 12 0 0 0 4 0 0 4 0 1 0 0 1\n!genbox wood cabinet 1 1 1.5 | xform -t 3 2 0\n";

    fn project(sensors: &str) -> (tempfile::TempDir, Result<Project>) {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("w.wea", "");
        write("b.xml", "");
        write("room.rad", ROOM);
        write("half.rad", "none polygon half 0 0 12 0 0 0 2 0 0 2 3 0 0 3 0\n");
        write("window.rad", "glazing polygon g 0 0 12 0 0 1 0 0 3 4 0 3 4 0 1\n");
        write(
            "project.toml",
            &format!(
                "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"room.rad\"]\n[[window]]\nname = \"s\"\nsurface = \"window.rad\"\nbsdf = \"b.xml\"\n[[sensors]]\nname = \"desk\"\n{sensors}\n"
            ),
        );
        let project = Project::read(&folder.path().join("project.toml"));
        (folder, project)
    }

    fn read(text: &str) -> (Result<Vec<Sensor>>, Vec<String>) {
        let (folder, project) = project(text);
        let project = project.unwrap();
        let mut warnings = Warnings::new();
        let scene = super::super::read_scene(&project, &mut warnings).unwrap();
        let windows = scene::read_windows(Path::new("window.rad"), folder.path(), &mut warnings).unwrap();
        let found = sensors(&project, &project.sensors[0], &scene, Light::Windows(&windows), &mut warnings);
        (found, warnings.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn points_inside_furniture_are_left_out_and_counted() {
        let (found, warnings) = read("surface = \"floor\"\nspacing = 0.5\nheight = 0.75\n");
        let found = found.unwrap();
        assert_eq!(found.len(), 48 - 4);
        assert!(found.iter().all(|s| s.position.z == 0.75 && !(s.position.x > 3.0 && s.position.y > 2.0)));
        assert!(found.iter().enumerate().all(|(i, s)| s.line == i + 1));
        assert!(warnings.len() == 1 && warnings[0].contains("4 of 48 points of 'desk' are left out"), "{warnings:?}");
        // Above the cabinet all of them see the window.
        let (found, warnings) = read("surface = \"ground\"\nspacing = 0.5\nheight = 1.6\nmargin = 0.5\n");
        assert_eq!((found.unwrap().len(), warnings.len()), (24, 0));
        let (found, _) = read("surface = \"half.rad\"\nspacing = 1\n");
        let found = found.unwrap();
        assert!(found.len() == 6 && found.iter().all(|s| s.position.z == 0.8 && s.position.x < 2.0));
    }

    #[test]
    fn a_surface_that_is_not_there_is_named_with_those_that_are() {
        let fault = |text: &str| read(text).0.unwrap_err().to_string();
        let message = fault("surface = \"Floor\"\nspacing = 0.5\n");
        assert!(message.contains("sensors 'desk'") && message.contains("did you mean 'floor'?"), "{message}");
        let message = fault("surface = \"carpet\"\nspacing = 0.5\n");
        assert!(message.contains("materials in use: floor, wall, wood"), "{message}");
        assert!(fault("surface = \"floor\"\nspacing = 0.5\nmargin = 2\n").contains("smaller margin"));
        for (text, what) in [
            ("surface = \"floor\"\n", "need their 'spacing'"),
            ("surface = \"floor\"\nspacing = 0\n", "out of range"),
            ("surface = \"floor\"\nspacing = 1\npoints = \"room.rad\"\n", "either listed in 'points' or spread"),
            ("points = \"room.rad\"\nheight = 1\n", "'height' spreads sensors over a surface"),
            ("surface = \"missing.rad\"\nspacing = 1\n", "there is no file"),
            ("surface = \"floor\"\nspacin = 1\n", "need their 'spacing'"),
            ("", "surface = \"floor\" with spacing"),
            ("surfce = \"floor\"\nspacing = 1\n", "did you mean 'surface'?"),
        ] {
            let message = project(text).1.unwrap_err().to_string();
            assert!(message.contains(what) && message.contains("project.toml:"), "{text}: {message}");
        }
    }
}
