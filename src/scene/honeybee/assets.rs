//! Sensor grids and views of a model.

use super::json::Node;
use super::modifiers::radiance;
use super::windows::unique;
use crate::error::{Result, Warnings};
use crate::scene::points::{Sensor, SensorGrid};
use std::collections::HashSet;
use std::path::Path;

/// A view of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelView {
    /// Its name.
    pub name: String,
    /// Its options as in a view file: `-vth -vp 1 2 1.2 …`.
    pub options: String,
}

/// Grids and views; names that occur twice get a number, but grids of the same full name are one, as in
/// honeybee-radiance.
///
/// # Errors
/// Sensors without position or direction.
pub(super) fn read(model: &Node<'_>, scale: f64, file: &Path, warnings: &mut Warnings) -> Result<(Vec<SensorGrid>, Vec<ModelView>)> {
    let Some(properties) = radiance(model)? else { return Ok((Vec::new(), Vec::new())) };
    let mut taken = HashSet::new();
    let mut grids: Vec<(String, SensorGrid)> = Vec::new();
    for grid in properties.list("sensor_grids")? {
        let name = full_name(&grid)?;
        let sensors = grid.list("sensors")?;
        if let Some(mesh) = grid.object("mesh")? {
            let [faces, corners] = ["faces", "vertices"].map(|key| mesh.value[key].as_array().map_or(0, Vec::len));
            if ![faces, corners].contains(&sensors.len()) {
                let told = grid
                    .error(format!("its mesh has {faces} faces and {corners} corners for {} sensors; the mesh is not used", sensors.len()));
                warnings.push(told.file(file).help("results are those of the sensors"));
            }
        }
        if sensors.is_empty() {
            warnings.push(grid.error("this grid has no sensors and is left out").file(file).help("make the grid again in Honeybee"));
            continue;
        }
        let known = grids.iter().position(|(n, _)| *n == name);
        let place = known.unwrap_or_else(|| {
            let plain = unique(&name.replace('/', "-"), &mut taken);
            grids.push((name, SensorGrid { name: plain, sensors: Vec::new() }));
            grids.len() - 1
        });
        let list = &mut grids[place].1.sensors;
        for sensor in sensors {
            let position = sensor.vector("pos")?.ok_or_else(|| sensor.missing("pos"))? * scale;
            let direction = sensor.vector("dir")?.ok_or_else(|| sensor.missing("dir"))?;
            let direction = direction
                .try_normalize()
                .ok_or_else(|| sensor.error("its direction has no length").help("give the normal of the plane it measures"))?;
            list.push(Sensor { position, direction, line: list.len() + 1 });
        }
    }
    let mut views = Vec::new();
    for view in properties.list("views")? {
        views.push(ModelView { name: unique(&full_name(&view)?.replace('/', "-"), &mut taken), options: options(&view, scale)? });
    }
    Ok((grids.into_iter().map(|(_, grid)| grid).collect(), views))
}

/// Group and identifier.
fn full_name(asset: &Node<'_>) -> Result<String> {
    let name = asset.identifier()?;
    Ok(asset.text("group_identifier")?.map_or_else(|| name.to_string(), |group| format!("{group}/{name}")))
}

fn options(view: &Node<'_>, scale: f64) -> Result<String> {
    let kind = view.text("view_type")?.unwrap_or("v");
    if !["v", "h", "l", "c", "a", "s"].contains(&kind) {
        return Err(view.error(format!("there is no view type '{kind}'")).help("view types are v, h, l, c, a and s, as Radiance's -vt"));
    }
    let triple = |key: &str| view.vector(key).and_then(|v| v.ok_or_else(|| view.missing(key)));
    let (point, direction, up) = (triple("position")? * scale, triple("direction")?, triple("up_vector")?);
    // Of a parallel view the sizes are lengths.
    let unit = if kind == "l" { scale } else { 1.0 };
    let size = |key: &str| -> Result<f64> { Ok(view.number(key)?.unwrap_or(60.0) * unit) };
    let mut text = format!(
        "-vt{kind} -vp {} {} {} -vd {} {} {} -vu {} {} {} -vh {} -vv {}",
        point.x,
        point.y,
        point.z,
        direction.x,
        direction.y,
        direction.z,
        up.x,
        up.y,
        up.z,
        size("h_size")?,
        size("v_size")?
    );
    for (key, option, unit) in [("shift", "-vs", 1.0), ("lift", "-vl", 1.0), ("fore_clip", "-vo", scale), ("aft_clip", "-va", scale)] {
        if let Some(value) = view.number(key)?.filter(|v| *v != 0.0) {
            text.push_str(&format!(" {option} {}", value * unit));
        }
    }
    Ok(text)
}
