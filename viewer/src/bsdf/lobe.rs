//! The scattering lobe in space: distance from the centre is the value, on the panel's scale.

use super::disc::direction;
use super::model::{View, companion};
use crate::plot::{self, color32};
use eframe::egui::{self, Align2, Color32, FontId, Mesh, Pos2, Rect, Stroke, pos2, vec2};
use glam::DVec3;
use lucarne::bsdf::{Block, Blocks};
use lucarne::image::palette::Scale;

const RINGS: usize = 30;
const SPOKES: usize = 72;

/// Points of a lobe with their position on the scale, once per state.
#[derive(Default)]
pub struct Lobe {
    key: String,
    /// One grid per hemisphere: points (length 0…1) and positions.
    sides: Vec<Vec<(DVec3, f64)>>,
}

impl Lobe {
    /// Takes the values of the shown component, and of the other one of the same light.
    pub fn update(&mut self, key: String, blocks: &Blocks, view: &View, scale: &Scale) {
        if self.key == key {
            return;
        }
        self.key = key;
        let incident = direction(view.incident);
        self.sides = [view.component, companion(view.component)]
            .into_iter()
            .filter_map(|c| Some((c, blocks.get(c)?)))
            .map(|(component, block)| side(block, incident, scale, if component.is_transmission() { 1.0 } else { -1.0 }))
            .collect();
    }

    /// Paints it into `rect`, turned by the view's angles.
    pub fn paint(&self, ui: &egui::Ui, rect: Rect, view: &View) {
        let painter = ui.painter().with_clip_rect(rect);
        let unit = rect.width().min(rect.height()) * 0.40;
        let center = rect.center();
        let (sin_y, cos_y) = f64::from(view.turn[0]).sin_cos();
        let (sin_p, cos_p) = f64::from(view.turn[1]).sin_cos();
        // The window's z (into the room) lies to the right, its y upwards.
        let turn = |p: DVec3| {
            let (x, y, z) = (p.z, p.y, -p.x);
            let (x, z) = (x * cos_y + z * sin_y, z * cos_y - x * sin_y);
            (x, y * cos_p - z * sin_p, y * sin_p + z * cos_p)
        };
        let place = |p: DVec3| {
            let (x, y, _) = turn(p);
            pos2(center.x + (x as f32) * unit, center.y - (y as f32) * unit)
        };
        let line = Stroke::new(1.0, plot::axis(ui));
        let pane: Vec<Pos2> =
            [(-0.55, -0.55), (0.55, -0.55), (0.55, 0.55), (-0.55, 0.55)].map(|(x, y)| place(DVec3::new(x, y, 0.0))).to_vec();
        painter.add(egui::Shape::convex_polygon(pane, plot::axis(ui).gamma_multiply(0.15), line));
        let mut triangles: Vec<(f64, [(Pos2, Color32); 3])> = Vec::new();
        for side in &self.sides {
            let screen: Vec<(Pos2, DVec3, Color32)> = side
                .iter()
                .map(|&(p, t)| {
                    let (x, y, z) = turn(p);
                    (pos2(center.x + x as f32 * unit, center.y - y as f32 * unit), DVec3::new(x, y, z), color32(view.palette.color(t)))
                })
                .collect();
            for r in 0..RINGS {
                for s in 0..SPOKES {
                    let [a, b, c, d] = [(r, s), (r + 1, s), (r + 1, s + 1), (r, s + 1)].map(|(r, s)| screen[r * (SPOKES + 1) + s]);
                    for [i, j, k] in [[a, b, c], [a, c, d]] {
                        // A light from the upper left makes the shape readable.
                        let normal = (j.1 - i.1).cross(k.1 - i.1).normalize_or_zero();
                        let shade = 0.72 + 0.28 * normal.dot(DVec3::new(-0.4, 0.5, 0.77)).abs();
                        let lit = |c: Color32| {
                            Color32::from_rgb(
                                (f64::from(c.r()) * shade) as u8,
                                (f64::from(c.g()) * shade) as u8,
                                (f64::from(c.b()) * shade) as u8,
                            )
                        };
                        triangles.push((i.1.z + j.1.z + k.1.z, [(i.0, lit(i.2)), (j.0, lit(j.2)), (k.0, lit(k.2))]));
                    }
                }
            }
        }
        triangles.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut mesh = Mesh::default();
        for (_, corners) in triangles {
            let first = mesh.vertices.len() as u32;
            for (p, color) in corners {
                mesh.colored_vertex(p, color);
            }
            mesh.add_triangle(first, first + 1, first + 2);
        }
        painter.add(mesh);
        let d = direction(view.incident);
        let (from, to) = (place(d * -1.15), place(d * -0.06));
        painter.arrow(from, to - from, Stroke::new(2.0, plot::line_color(ui, 1)));
        let ink = ui.visuals().text_color();
        let small = FontId::proportional(11.0);
        let (behind, ahead) = if view.component.is_front() { ("outside", "room") } else { ("room", "outside") };
        painter.text(rect.left_bottom() + vec2(8.0, -6.0), Align2::LEFT_BOTTOM, "drag to turn", small.clone(), plot::axis(ui));
        for (z, name) in [(-1.02, behind), (1.02, ahead)] {
            painter.text(place(DVec3::new(0.0, -0.62, z * 0.8)), Align2::CENTER_TOP, name, small.clone(), ink);
        }
    }
}

fn side(block: &Block, incident: DVec3, scale: &Scale, sign: f64) -> Vec<(DVec3, f64)> {
    let mut points = Vec::with_capacity((RINGS + 1) * (SPOKES + 1));
    for r in 0..=RINGS {
        for s in 0..=SPOKES {
            let theta = (89.5 * r as f64 / RINGS as f64).max(0.01);
            let d = direction([theta, 360.0 * s as f64 / SPOKES as f64]);
            let t = scale.position(block.evaluate(d, incident)).clamp(0.0, 1.0);
            points.push((DVec3::new(d.x, d.y, d.z * sign) * t, t));
        }
    }
    points
}
