//! The sky dome of an hour, seen from above: north is up, east to the right.

use crate::bsdf::disc::{Projection, disc_image};
use crate::plot::{self, color32};
use crate::texture::CachedTexture;
use eframe::egui::{self, Align2, Color32, FontId, Rect, Sense, Stroke, pos2, vec2};
use glam::DVec3;
use lucarne::bins::ReinhartSky;
use lucarne::image::palette::{Palette, Scale, rounded_number};
use lucarne::matrix::Matrix;
use lucarne::units::LUMINOUS_EFFICACY;
use lucarne::weather::sun::SunPosition;

/// Luminance of all patches, cd/m², ground first.
pub fn luminances(sky: &Matrix<f32>, hour: usize) -> Vec<f64> {
    let weights = lucarne::units::BRIGHTNESS_WEIGHTS;
    (0..sky.rows()).map(|p| sky.at(p, hour).iter().zip(weights).map(|(v, w)| f64::from(*v) * w).sum::<f64>() * LUMINOUS_EFFICACY).collect()
}

/// Paints the dome into the next space of `ui`; gives a line about what is under the pointer.
pub fn show(
    ui: &mut egui::Ui,
    texture: &mut CachedTexture,
    sky: Option<(&Matrix<f32>, usize)>,
    sun: Option<SunPosition>,
    palette: Palette,
) -> Option<String> {
    let side = ui.available_width().min(240.0);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), side), Sense::hover());
    let disc = crate::bsdf::disc::Disc { center: rect.center(), radius: side / 2.0 - 16.0, projection: Projection::Equidistant };
    let mut said = None;
    if let Some((sky, hour)) = sky
        && let Some(bins) = ReinhartSky::from_bins(sky.rows())
    {
        let size = ((2.0 * disc.radius * ui.ctx().pixels_per_point()) as usize).clamp(32, 800);
        let values = luminances(sky, hour);
        let scale = Scale::logarithmic(100_000.0, 3.0);
        let id = texture.get(ui.ctx(), format!("{hour} {palette:?} {size} {}", values.len()), true, || {
            let table: Vec<Color32> =
                values.iter().map(|v| scale.as_ref().map_or(Color32::GRAY, |s| color32(palette.color(s.position(*v))))).collect();
            // The disc's right is east, its top north.
            disc_image(size, Projection::Equidistant, |d| table[bins.bin_of(DVec3::new(d.x, d.y, d.z.max(1e-9)))])
        });
        ui.painter().image(
            id,
            Rect::from_center_size(disc.center, vec2(2.0, 2.0) * disc.radius),
            Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)),
            Color32::WHITE,
        );
        if let Some([zenith, phi]) = response.hover_pos().and_then(|p| disc.angles(p)) {
            let d = crate::bsdf::disc::direction([zenith, phi]);
            let bin = bins.bin_of(DVec3::new(d.x, d.y, d.z.max(1e-9)));
            said = Some(format!(
                "Sky patch {bin}   altitude {:.0}°, azimuth {:.0}° from north   {} cd/m²",
                90.0 - zenith,
                (90.0 - phi).rem_euclid(360.0),
                rounded_number(values[bin])
            ));
        }
    } else {
        ui.painter().circle_filled(disc.center, disc.radius, plot::field(ui));
    }
    ui.painter().circle_stroke(disc.center, disc.radius, Stroke::new(1.0, ui.visuals().text_color()));
    for (phi, name) in [(90.0, "N"), (0.0, "E"), (270.0, "S"), (180.0, "W")] {
        let p = disc.place(90.0, phi);
        let at = p + (p - disc.center) / disc.radius * 9.0;
        ui.painter().text(at, Align2::CENTER_CENTER, name, FontId::proportional(12.0), ui.visuals().text_color());
    }
    if let Some(sun) = sun.filter(SunPosition::is_up) {
        let zenith = 90.0 - sun.altitude.to_degrees().max(0.0);
        let at = disc.place(zenith, 90.0 - sun.azimuth.to_degrees());
        ui.painter().circle_filled(at, 6.0, Color32::from_rgb(255, 200, 0));
        ui.painter().circle_stroke(at, 6.0, Stroke::new(1.5, Color32::BLACK));
        if response.hover_pos().is_some_and(|p| p.distance(at) < 9.0) {
            said = Some(format!(
                "Sun   altitude {:.1}°, azimuth {:.1}° from north",
                sun.altitude.to_degrees(),
                sun.azimuth.to_degrees().rem_euclid(360.0)
            ));
        }
    }
    said
}
