//! `[[views]]`: many fisheye views from a file of points.
//!
//! ```toml
//! [[views]]
//! name = "seats"
//! points = "seats.txt"                # lines "x y z dx dy dz"
//! directions = [0, 90, 180, 270]      # degrees from north, clockwise; left out: the points' own
//! resolution = [200, 200]
//! ```
//!
//! Their names are `seats-001`, `seats-002`, … in the order of the points, or with directions
//! `seats-001-090`.

use super::given::GivenPictures;
use super::names::name;
use super::table::Table;
use super::views::{ViewSection, resolution};
use crate::camera::{Projection, View};
use crate::error::{Error, Result};
use crate::scene::points::read_points;
use glam::DVec3;

/// Pixels of a view of a grid, if nothing else is said: each is half a degree.
const RESOLUTION: [usize; 2] = [360, 360];

pub(super) fn read_grid(mut table: Table<'_, '_>) -> Result<Vec<ViewSection>> {
    let name = name(&mut table, "add name = \"seats\" or the like")?;
    let file = table.required_path("points", "add points = \"….txt\" with a line 'x y z dx dy dz' per point")?;
    let directions = table.integers("directions", 0..=360)?;
    let resolution = resolution(&mut table)?.unwrap_or(RESOLUTION);
    if directions.as_ref().is_some_and(Vec::is_empty) {
        return Err(table.error("directions", "this list is empty").help("leave it out to look as the points file says"));
    }
    let place = table.place("resolution");
    let mut views = Vec::new();
    for (i, point) in read_points(&file)?.iter().enumerate() {
        let fisheye = |direction: DVec3| View {
            projection: Projection::Angular,
            point: point.position,
            direction,
            horizontal: 180.0,
            vertical: 180.0,
            ..View::default()
        };
        let number = i + 1;
        let mut add = |name: String, view: View| -> Result<()> {
            // The file has directions, and none of a view's options that the camera would name.
            view.camera().map_err(|_| {
                Error::new("this point looks straight up or down, where a view has no upper edge")
                    .file(&file)
                    .line(point.line)
                    .help("give directions = [0, 90, 180, 270] in [[views]]")
            })?;
            views.push(ViewSection {
                name,
                file: file.clone(),
                view: Some(view),
                resolution,
                place: place.clone(),
                given: GivenPictures::default(),
            });
            Ok(())
        };
        match &directions {
            None => add(format!("{name}-{number:03}"), fisheye(point.direction))?,
            Some(all) => {
                for &azimuth in all {
                    let angle = (azimuth as f64).to_radians();
                    let view = fisheye(DVec3::new(angle.sin(), angle.cos(), 0.0));
                    add(format!("{name}-{number:03}-{azimuth:03}"), view)?;
                }
            }
        }
    }
    table.finish()?;
    Ok(views)
}
