//! Geometry as MGF text, for embedding in BSDF files (Materials and Geometry Format, LBNL).

use crate::scene::{MaterialKind, Scene};
use std::fmt::Write;

/// The triangles of a scene with their materials, lengths times `scale` in metres. Smooth panes become
/// two-sided surfaces with specular transmission; light sources and absorbers black.
pub fn text(scene: &Scene, scale: f64) -> String {
    let mut text = String::new();
    let mut vertex = 0usize;
    for (index, material) in scene.materials.iter().enumerate() {
        let mut faces = scene.triangles.iter().filter(|t| t.material.0 as usize == index).peekable();
        if faces.peek().is_none() || material.kind == MaterialKind::Void {
            continue;
        }
        write_material(&mut text, &material.name, &material.kind);
        for triangle in faces {
            for p in triangle.vertices {
                vertex += 1;
                let _ = writeln!(text, "v v{vertex} =\n\tp {} {} {}", p.x * scale, p.y * scale, p.z * scale);
            }
            let _ = writeln!(text, "f v{} v{} v{}", vertex - 2, vertex - 1, vertex);
        }
    }
    text
}

fn write_material(text: &mut String, name: &str, kind: &MaterialKind) {
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() || "_-.".contains(c) { c } else { '_' }).collect();
    let name = if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("m{name}") };
    let grey = |c: [f64; 3]| c.iter().zip(crate::units::BRIGHTNESS_WEIGHTS).map(|(a, b)| a * b).sum::<f64>();
    let one_sided = matches!(kind, MaterialKind::Mirror { .. });
    let [mut rd, mut rs, mut td, mut ts, mut roughness] = [0.0; 5];
    match *kind {
        MaterialKind::Glass { transmissivity, refraction_index } => {
            // At normal incidence, internal reflections included.
            let (t, r) = (grey(transmissivity), ((refraction_index - 1.0) / (refraction_index + 1.0)).powi(2));
            ts = (1.0 - r).powi(2) * t / (1.0 - (r * t).powi(2));
            rs = r * (1.0 + (1.0 - 2.0 * r) * t * t) / (1.0 - (r * t).powi(2));
        }
        MaterialKind::Mirror { color } => rs = grey(color),
        _ => {
            if let Some(l) = kind.lobes() {
                (rd, rs, td, ts) = (grey(l.diffuse), grey(l.specular), grey(l.diffuse_transmitted), grey(l.specular_transmitted));
                roughness = l.roughness;
            }
        }
    }
    let _ = writeln!(text, "m {name} =\n\tsides {}", if one_sided { 1 } else { 2 });
    for (word, share) in [("rd", rd), ("td", td)] {
        if share > 0.0 {
            let _ = writeln!(text, "\t{word} {share:.6}");
        }
    }
    for (word, share) in [("rs", rs), ("ts", ts)] {
        if share > 0.0 {
            let _ = writeln!(text, "\t{word} {share:.6} {roughness}");
        }
    }
}
