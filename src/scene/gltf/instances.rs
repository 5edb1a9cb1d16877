//! `EXT_mesh_gpu_instancing`: one mesh in many places. The `gltf` crate does not know it, so its words
//! are taken from the file's JSON.

use super::buffers::Buffers;
use crate::error::{Error, Result};
use glam::{DAffine3, DQuat, DVec3};
use serde_json::Value;

/// Name of the extension.
pub(super) const NAME: &str = "EXT_mesh_gpu_instancing";

/// Where a node's mesh stands, in the frame of the node; nothing if the node has no instances.
///
/// # Errors
/// Accessors that do not exist, differ in length or hold other than vectors; rotations that are no unit
/// quaternions; values that are not finite.
pub(super) fn of(node: &gltf::Node, gltf: &gltf::Gltf, json: &Value, buffers: &Buffers) -> Result<Option<Vec<DAffine3>>> {
    let attributes = &json["nodes"][node.index()]["extensions"][NAME]["attributes"];
    if !attributes.is_object() {
        return Ok(None);
    }
    let fault = |message: String| Error::new(format!("{NAME}: {message}")).help("export the file again, or without instances");
    let accessor = |key: &str| match &attributes[key] {
        Value::Null => Ok(None),
        index => {
            let found = index.as_u64().and_then(|i| gltf.accessors().nth(usize::try_from(i).ok()?));
            found.map(Some).ok_or_else(|| fault(format!("{key} names accessor {index}, which is not there")))
        }
    };
    let translations = accessor("TRANSLATION")?.map(|a| buffers.floats::<3>(&a)).transpose()?;
    let rotations = accessor("ROTATION")?.map(|a| buffers.floats::<4>(&a)).transpose()?;
    let scales = accessor("SCALE")?.map(|a| buffers.floats::<3>(&a)).transpose()?;
    let lengths: Vec<usize> = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)]
        .into_iter()
        .flatten()
        .collect();
    let Some(&count) = lengths.first() else {
        return Err(fault("neither TRANSLATION, ROTATION nor SCALE says where the instances are".into()));
    };
    if lengths.iter().any(|n| *n != count) {
        return Err(fault(format!(
            "its accessors have {} elements",
            lengths.iter().map(usize::to_string).collect::<Vec<_>>().join(" and ")
        )));
    }
    let place = |i: usize| {
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |r| DQuat::from_array(r[i]));
        let length = rotation.length();
        if !(length > 0.5 && length < 2.0) {
            return Err(fault(format!("the rotation of instance {i} is not a unit quaternion")));
        }
        let scale = scales.as_ref().map_or(DVec3::ONE, |s| DVec3::from_array(s[i]));
        let translation = translations.as_ref().map_or(DVec3::ZERO, |t| DVec3::from_array(t[i]));
        let place = DAffine3::from_scale_rotation_translation(scale, rotation.normalize(), translation);
        if !place.is_finite() {
            return Err(fault(format!("the place of instance {i} is not finite")));
        }
        Ok(place)
    };
    (0..count).map(place).collect::<Result<_>>().map(Some)
}
