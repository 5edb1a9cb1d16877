//! Scattering data that a Honeybee model holds: `model.hbjson#modifier`.

use super::read_from;
use crate::bsdf::Bsdf;
use crate::error::{Error, Result, Warnings};
use crate::{files, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The model and the identifier of the modifier, if a path names one.
pub(super) fn split(path: &Path) -> Option<(PathBuf, String)> {
    let text = path.to_string_lossy();
    let (model, name) = text.rsplit_once('#')?;
    (model.to_lowercase().ends_with(".hbjson") && !path.exists()).then(|| (PathBuf::from(model), name.to_string()))
}

/// Reads the `bsdf_data` of a modifier.
///
/// # Errors
/// A file that is no JSON or has no such modifier; faults of the XML.
pub(super) fn read(model: &Path, name: &str, warnings: &mut Warnings) -> Result<Bsdf> {
    let bytes = files::read(model)?;
    let at = |e: Error| e.field(format!("bsdf_data of '{name}'")).file(model);
    let value: Value = text::decode(&bytes, "a Honeybee model")
        .and_then(|text| serde_json::from_str(&text).map_err(|e| Error::new(format!("this is no JSON: {e}"))))
        .map_err(at)?;
    let data = find(&value, name).ok_or_else(|| {
        at(Error::new("the model has no BSDF modifier of this name")
            .help("name a modifier of type BSDF among properties.radiance.modifiers"))
    })?;
    let mut found = Warnings::new();
    // Lines are those of the XML.
    let result = read_from(data.as_bytes(), &mut found).map_err(at);
    found.iter().for_each(|w| warnings.push(at(w.clone())));
    result
}

/// Modifiers stand in lists, in sets, and in the objects that they belong to.
fn find<'v>(value: &'v Value, name: &str) -> Option<&'v str> {
    match value {
        Value::Array(items) => items.iter().find_map(|v| find(v, name)),
        Value::Object(entries) => {
            let own = entries.get("identifier").and_then(Value::as_str) == Some(name);
            match entries.get("bsdf_data").and_then(Value::as_str) {
                Some(data) if own => Some(data),
                _ => entries.values().find_map(|v| find(v, name)),
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_s_scattering_data_are_those_of_the_file_they_were_made_from() {
        let folder = tempfile::tempdir().unwrap();
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bsdf/clear.xml");
        let xml = std::fs::read_to_string(&file).unwrap();
        let model = folder.path().join("room.hbjson");
        let modifiers = serde_json::json!([
            {"type": "Glass", "identifier": "pane"},
            {"type": "BSDF", "identifier": "blind", "bsdf_data": "no XML"},
            {"type": "BSDF", "identifier": "clear", "bsdf_data": xml},
        ]);
        std::fs::write(&model, serde_json::json!({"properties": {"radiance": {"modifiers": modifiers}}}).to_string()).unwrap();
        let named = |name: &str| super::super::read(&folder.path().join(format!("room.hbjson#{name}")), &mut Warnings::new());
        assert_eq!(named("clear").unwrap().visible, super::super::read(&file, &mut Warnings::new()).unwrap().visible);
        let missing = named("pane").unwrap_err().to_string();
        assert!(missing.contains("room.hbjson") && missing.contains("'pane'") && missing.contains("no BSDF modifier"), "{missing}");
        assert!(named("blind").unwrap_err().to_string().contains("bsdf_data of 'blind'"));
    }
}
