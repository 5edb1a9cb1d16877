use super::*;
use std::collections::BTreeMap;

/// Area and number of surfaces by modifier.
fn areas(model: &Model) -> BTreeMap<String, (usize, f64)> {
    let mut found: BTreeMap<String, (usize, f64)> = BTreeMap::new();
    let mut last = None;
    for t in &model.scene.triangles {
        let [a, b, c] = t.vertices;
        let entry = found.entry(model.scene.materials[t.material.0 as usize].name.clone()).or_default();
        entry.0 += usize::from(last != Some(t.surface));
        entry.1 += (b - a).cross(c - a).length() / 2.0;
        last = Some(t.surface);
    }
    found
}

#[test]
fn temporary_oracle() {
    for entry in std::fs::read_dir("/tmp/hbs").unwrap() {
        let path = entry.unwrap().path();
        let mut warnings = Warnings::new();
        match read(&path, &mut warnings) {
            Ok(model) => {
                let windows: Vec<_> = model.windows.iter().map(|w| (w.window.name.clone(), w.modifier.clone(), w.apertures.len(), w.window.area(), w.window.frame.z.to_array())).collect();
                let grids: Vec<_> = model.sensors.iter().map(|g| (g.name.clone(), g.sensors.len())).collect();
                let materials: Vec<_> = model.scene.materials.iter().map(|m| format!("{m:?}")).collect();
                println!("ORACLE {}", serde_json::json!({"file": path.file_name().unwrap().to_string_lossy(), "areas": areas(&model), "windows": windows, "grids": grids, "materials": materials, "warnings": warnings.iter().map(|w| w.to_string()).collect::<Vec<_>>()}));
            }
            Err(e) => println!("ORACLE {}", serde_json::json!({"file": path.file_name().unwrap().to_string_lossy(), "error": e.to_string()})),
        }
    }
}
