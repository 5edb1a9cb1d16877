//! Extensions that a file uses: those that are obeyed, and a warning for each of the others.

use super::instances;
use crate::error::Error;
use serde_json::Value;
use std::collections::BTreeMap;

/// Extensions that are obeyed, and may be required.
pub(crate) const OBEYED: [&str; 5] =
    ["KHR_materials_transmission", "KHR_materials_ior", "KHR_materials_emissive_strength", "KHR_mesh_quantization", instances::NAME];

/// The JSON of a file's bytes, `.gltf` or `.glb`.
///
/// # Errors
/// What is wrong with it, in words.
pub(super) fn json(bytes: &[u8]) -> Result<Value, String> {
    if bytes.starts_with(b"glTF") {
        let binary = gltf::binary::Glb::from_slice(bytes).map_err(|e| e.to_string())?;
        return serde_json::from_slice(&binary.json).map_err(|e| e.to_string());
    }
    serde_json::from_slice(bytes).map_err(|e| e.to_string())
}

/// Warns of each extension that the file uses or names and that is not obeyed.
pub(super) fn warn(json: &Value, warn: &mut impl FnMut(Error)) {
    // Where each is first used, and how often.
    let mut users: BTreeMap<&str, (String, usize)> = BTreeMap::new();
    for (kind, items) in json.as_object().into_iter().flatten() {
        for (i, item) in items.as_array().into_iter().flatten().enumerate() {
            // What the extras say goes before all else.
            if !item["extras"]["radiance"].is_string() {
                collect(item, &format!("{kind}[{i}]"), &mut users);
            }
        }
    }
    let named = json["extensionsUsed"].as_array().into_iter().flatten().filter_map(Value::as_str);
    // Of materials with exact extras nothing is left out.
    let exact = |name: &str| name.starts_with("KHR_materials") && json["materials"].as_array().is_some_and(|m| !m.is_empty());
    for name in named {
        if !exact(name) {
            users.entry(name).or_default();
        }
    }
    for (name, (place, count)) in users {
        if OBEYED.contains(&name) {
            continue;
        }
        let message = match count {
            0 => format!("the extension {name} is left out"),
            1 => format!("the extension {name} of {place} is left out"),
            _ => format!("the extension {name} of {place} and {} others is left out", count - 1),
        };
        let help = match name {
            "KHR_lights_punctual" => "give luminaires an emissive material",
            n if n.starts_with("KHR_materials") => {
                "where it matters, write the exact material into the extras: \"radiance\": \"void plastic wall 0 0 5 .5 .5 .5 0 0\""
            }
            _ => "where it matters, export without it",
        };
        warn(Error::new(message).help(help));
    }
}

/// Extensions within one item of the file, at any depth.
fn collect<'j>(item: &'j Value, place: &str, users: &mut BTreeMap<&'j str, (String, usize)>) {
    match item {
        Value::Object(entries) => {
            for (key, value) in entries {
                match value {
                    Value::Object(extensions) if key == "extensions" => {
                        for name in extensions.keys() {
                            let (first, count) = users.entry(name).or_default();
                            if *count == 0 {
                                *first = place.to_string();
                            }
                            *count += 1;
                        }
                    }
                    // Extras are the user's own.
                    _ if key == "extras" => {}
                    _ => collect(value, place, users),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|v| collect(v, place, users)),
        _ => {}
    }
}
