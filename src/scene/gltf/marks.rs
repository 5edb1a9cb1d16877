//! What objects of a glTF file are marked as, by their `extras` or their names.

use crate::error::{Error, Result};
use serde_json::Value;

/// The `extras` of an object; null without any.
pub(super) fn extras(raw: &gltf::json::Extras) -> Result<Value> {
    raw.as_ref().map_or(Ok(Value::Null), |raw| {
        serde_json::from_str(raw.get()).map_err(|e| Error::new(format!("extras are not JSON: {e}")).help("export the file again"))
    })
}

/// What a node, mesh or material is marked as.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mark {
    Window { name: String, parameters: String },
    Sensors { name: String },
}

impl Mark {
    pub fn of(name: Option<&str>, raw: &gltf::json::Extras) -> Result<Option<Self>> {
        let extras = extras(raw)?;
        let named = |prefix: &str| name.and_then(|n| n.strip_prefix(prefix)).map(str::trim).filter(|n| !n.is_empty());
        let marked = |key: &str| match &extras[key] {
            Value::Null | Value::Bool(false) => Ok(None),
            Value::String(s) if !s.trim().is_empty() => Ok(Some(s.trim().to_string())),
            other => Err(Error::new(format!("the extras entry \"{key}\" is {other}")).help(format!("write a name: \"{key}\": \"south\""))),
        };
        let parameters = match &extras["rfluxmtx"] {
            Value::String(s) => s.clone(),
            Value::Null => String::new(),
            other => return Err(Error::new(format!("the extras entry \"rfluxmtx\" is {other}")).help("write \"rfluxmtx\": \"h=kf u=+Z\"")),
        };
        if let Some(name) = marked("window")?.or_else(|| named("window:").map(str::to_string)) {
            return Ok(Some(Self::Window { name, parameters }));
        }
        Ok(marked("sensors")?.or_else(|| named("sensors:").map(str::to_string)).map(|name| Self::Sensors { name }))
    }
}
