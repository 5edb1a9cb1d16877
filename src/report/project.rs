//! What was asked, the room and its windows.

use super::parts::{Figure, Part, Section, Table};
use super::plan::Marks;
use crate::image::palette::short_number;
use crate::scene::outline::Cut;
use crate::simulate::Results;
use glam::DVec3;

/// Project, method and windows.
pub(super) fn section(results: &Results) -> Section {
    let summary = &results.year.summary;
    let from_above: std::path::PathBuf = summary.project.components().filter(|c| !matches!(c, std::path::Component::ParentDir)).collect();
    let mut facts = vec![("Project", from_above.display().to_string())];
    if let Some(around) = &results.surroundings {
        let w = &around.weather;
        let degrees = |value: f64, names: [&str; 2]| format!("{:.2}° {}", value.abs(), names[usize::from(value < 0.0)]);
        let site = format!("{}, {}", degrees(w.latitude, ["north", "south"]), degrees(w.longitude, ["east", "west"]));
        facts.push(("Place", if w.place.is_empty() { site } else { format!("{}, {site}", w.place) }));
    }
    let steps = if summary.hours == summary.time_steps as f64 || summary.time_steps == 0 {
        format!("{} hours", short_number(summary.hours))
    } else {
        format!("{} hours in {} steps", short_number(summary.hours), summary.time_steps)
    };
    facts.push(("Weather", steps));
    let method = if summary.sensors_method.is_empty() { format!("{} phases", summary.phases) } else { summary.sensors_method.clone() };
    facts.push(("Method", if summary.phases_because.is_empty() { method } else { format!("{method}; {}", summary.phases_because) }));
    if let Some(suns) = &summary.suns {
        facts.push((
            "Suns",
            format!("{}: {} of {} traced, for {} hours with direct sun", suns.scheme, suns.needed, suns.all, short_number(suns.hours)),
        ));
    }
    facts.push(("Sky", format!("Reinhart's patches, MF:{}", summary.sky_subdivision)));
    facts.push(("Diffuse reflections", summary.bounces.map_or("all".to_string(), |b| format!("at most {b}"))));
    facts.push(("Quality", format!("{}, seed {}", summary.quality, summary.seed)));
    facts.push(("Made by", format!("{} on {} ({})", summary.program, summary.device.name, summary.device.kind)));
    let mut parts = vec![Part::Facts(facts)];
    let mut windows = Table::new("windows", "Windows", &["window", "glazing", "area, m²", "faces", "its sun"]);
    for w in &summary.windows {
        let [azimuth, altitude] = w.faces;
        let tilt = if altitude.abs() < 0.05 { String::new() } else { format!(", {} of the horizon", tilt(altitude)) };
        windows.rows.push(vec![
            w.name.clone(),
            w.group.as_ref().map_or_else(|| w.glazing.clone(), |group| format!("states of group {group}")),
            format!("{:.2}", w.area),
            format!("{azimuth:.0}° ({}){tilt}", compass(azimuth)),
            if w.sun_is_traced { "traced" } else { "in the sky's patches" }.into(),
        ]);
    }
    if !windows.rows.is_empty() {
        parts.push(Part::Table(windows));
    }
    if !summary.glass_left.is_empty() {
        parts.push(Part::Heading("Glass of the scene that was not taken for windows".into()));
        parts.push(Part::Notes(summary.glass_left.clone()));
    }
    Section { title: "Project and method", parts }
}

fn tilt(altitude: f64) -> String {
    format!("{:.0}° {}", altitude.abs(), if altitude > 0.0 { "above" } else { "below" })
}

/// The point of the compass nearest to an azimuth, degrees clockwise from north.
fn compass(azimuth: f64) -> &'static str {
    const NAMES: [&str; 8] = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];
    NAMES[(azimuth / 45.0).round() as usize % 8]
}

/// Plan and section of the room.
pub(super) fn room(results: &Results) -> Section {
    let title = "Room";
    let Some(around) = &results.surroundings else {
        let why = results.year.notes.iter().find(|n| n.contains("outline")).cloned();
        return Section {
            title,
            parts: vec![Part::Text(why.unwrap_or_else(|| "The project was not found, so the room is not drawn.".into()))],
        };
    };
    let windows: Vec<(String, Vec<[DVec3; 3]>)> = around.windows.iter().map(|w| (w.name.clone(), w.triangles.clone())).collect();
    let sensors: Vec<DVec3> = results.year.sensors.iter().flat_map(|g| g.positions.clone()).collect();
    // Views without a place of their own, such as parallel ones of a site, stand where they are.
    let views = around.project.views.iter().filter_map(|v| Some((v.name.clone(), v.view().ok()?)));
    let eyes: Vec<(DVec3, DVec3, String)> = views.map(|(name, v)| (v.point, v.direction.normalize_or_zero(), name)).collect();
    let height = match (sensors.is_empty(), eyes.is_empty()) {
        (false, _) => sensors.iter().map(|p| p.z).sum::<f64>() / sensors.len() as f64,
        (true, false) => eyes.iter().map(|e| e.0.z).sum::<f64>() / eyes.len() as f64,
        (true, true) => 1.2,
    };
    // A plan is cut through the windows where they stand above the sensors.
    let sill = windows.iter().flat_map(|w| &w.1).flatten().map(|p| p.z).fold([f64::MAX, f64::MIN], |[l, h], z| [l.min(z), h.max(z)]);
    let height = if sill[0] > height && sill[1] - sill[0] > 0.1 { sill[0] + 0.3 * (sill[1] - sill[0]) } else { height };
    let north = Some(around.weather.north);
    let marks = |title, cut, north| Marks { title, cut, windows: &windows, sensors: sensors.clone(), eyes: &eyes, north };
    let plan = format!("Plan, {height:.2} m above zero");
    let mut figures = vec![Figure {
        name: "plan".into(),
        label: "Plan of the room".into(),
        caption: "The room cut by a horizontal plane, with its windows (blue), sensors (grey) and views (orange)".into(),
        drawing: marks(&plan, Cut::plan(height), north).draw(&around.scene),
    }];
    if let Some(cut) = across(around) {
        figures.push(Figure {
            name: "section".into(),
            label: "Section of the room".into(),
            caption: "The room cut by a vertical plane through its largest window".into(),
            drawing: marks("Section", cut, None).draw(&around.scene),
        });
    }
    Section { title, parts: vec![Part::Figures(figures)] }
}

/// The vertical plane through the middle of the largest window, square to it; the outside is on the left.
fn across(around: &crate::simulate::year::Surroundings) -> Option<Cut> {
    let largest = around.windows.iter().max_by(|a, b| a.area().total_cmp(&b.area()))?;
    let corners = || largest.triangles.iter().flatten();
    let middle = corners().sum::<DVec3>() / corners().count() as f64;
    let inwards = DVec3::new(largest.frame.z.x, largest.frame.z.y, 0.0);
    // Of roof lights any direction does.
    let right = inwards.try_normalize().unwrap_or(DVec3::X);
    Some(Cut { origin: DVec3::new(middle.x, middle.y, 0.0), right, up: DVec3::Z })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_face_a_point_of_the_compass() {
        assert_eq!([0.0, 44.0, 180.0, 350.0, 292.6].map(compass), ["north", "north-east", "south", "north", "north-west"]);
        assert_eq!(tilt(-12.4), "12° below");
    }
}
