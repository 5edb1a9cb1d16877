//! Values of a JSON file that know where they stand, for messages.

use crate::error::{Error, Result};
use crate::scene::rad::shortened;
use glam::DVec3;
use serde_json::Value;

/// A value and its place: `rooms[0].faces[3]`.
#[derive(Debug, Clone)]
pub(super) struct Node<'a> {
    pub value: &'a Value,
    path: String,
}

impl<'a> Node<'a> {
    /// The whole file.
    pub fn root(value: &'a Value) -> Self {
        Self { value, path: String::new() }
    }

    /// An error at this place, with the object's identifier and the name that people gave it.
    pub fn at(&self, error: Error) -> Error {
        let text = |key: &str| self.value[key].as_str().map(shortened);
        let name = match (text("identifier"), text("display_name")) {
            (Some(id), Some(name)) if id != name => format!(" '{id}' ({name})"),
            (Some(id), _) => format!(" '{id}'"),
            (None, _) => String::new(),
        };
        error.field(format!("{}{name}", if self.path.is_empty() { "model" } else { &self.path }))
    }

    /// An error at this place.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.at(Error::new(message))
    }

    fn wrong_type(&self, key: &str, wanted: &str) -> Error {
        self.error(format!("'{key}' is {}, not {wanted}", kind(&self.value[key]))).help("export the model again")
    }

    fn below(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_string() } else { format!("{}.{key}", self.path) }
    }

    /// A value that is there and not null.
    pub fn get(&self, key: &str) -> Option<Node<'a>> {
        let value = self.value.get(key).filter(|v| !v.is_null())?;
        Some(Node { value, path: self.below(key) })
    }

    /// An object; `None` if it is not there.
    pub fn object(&self, key: &str) -> Result<Option<Node<'a>>> {
        match self.get(key) {
            Some(node) if !node.value.is_object() => Err(self.wrong_type(key, "an object")),
            other => Ok(other),
        }
    }

    /// The objects of a list; none if it is not there.
    pub fn list(&self, key: &str) -> Result<Vec<Node<'a>>> {
        let Some(list) = self.get(key) else { return Ok(Vec::new()) };
        let Some(items) = list.value.as_array() else { return Err(self.wrong_type(key, "a list")) };
        let nodes = items.iter().enumerate().map(|(i, value)| Node { value, path: format!("{}[{i}]", list.path) });
        let nodes: Vec<Node<'a>> = nodes.collect();
        match nodes.iter().find(|n| !n.value.is_object()) {
            Some(wrong) => Err(wrong.error(format!("this is {}, not an object", kind(wrong.value))).help("export the model again")),
            None => Ok(nodes),
        }
    }

    /// A text; `None` if it is not there.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>> {
        match self.get(key) {
            None => Ok(None),
            Some(node) => node.value.as_str().map(Some).ok_or_else(|| self.wrong_type(key, "a text")),
        }
    }

    /// A text that must be there.
    pub fn required_text(&self, key: &str) -> Result<&'a str> {
        self.text(key)?.ok_or_else(|| self.missing(key))
    }

    /// The error that something is missing.
    pub fn missing(&self, key: &str) -> Error {
        self.error(format!("'{key}' is missing")).help("export the model again; the file is incomplete, or no Honeybee model")
    }

    /// The identifier, which every named object has.
    pub fn identifier(&self) -> Result<&'a str> {
        self.required_text("identifier")
    }

    /// A finite number; `None` if it is not there.
    pub fn number(&self, key: &str) -> Result<Option<f64>> {
        match self.get(key) {
            None => Ok(None),
            // `{"type": "Autocalculate"}` and the like stand for the default.
            Some(node) if node.value.is_object() => Ok(None),
            Some(node) => node.value.as_f64().filter(|v| v.is_finite()).map(Some).ok_or_else(|| self.wrong_type(key, "a number")),
        }
    }

    /// True or false.
    pub fn boolean(&self, key: &str, default: bool) -> Result<bool> {
        match self.get(key) {
            None => Ok(default),
            Some(node) => node.value.as_bool().ok_or_else(|| self.wrong_type(key, "true or false")),
        }
    }

    /// Three numbers; `None` if they are not there.
    pub fn vector(&self, key: &str) -> Result<Option<DVec3>> {
        match self.get(key) {
            None => Ok(None),
            Some(node) => vector(node.value).map(Some).ok_or_else(|| self.wrong_type(key, "a list of three numbers")),
        }
    }

    /// A list of points.
    pub fn points(&self, key: &str) -> Result<Vec<DVec3>> {
        let Some(list) = self.get(key) else { return Err(self.missing(key)) };
        let Some(items) = list.value.as_array() else { return Err(self.wrong_type(key, "a list of points")) };
        self.points_of(key, items)
    }

    fn points_of(&self, key: &str, items: &[Value]) -> Result<Vec<DVec3>> {
        let point = |(i, value): (usize, &Value)| {
            vector(value).ok_or_else(|| {
                self.error(format!("point {i} of '{key}' is not three numbers")).help("a point is a list [x, y, z] of finite numbers")
            })
        };
        items.iter().enumerate().map(point).collect()
    }

    /// A list of lists of points; none if it is not there.
    pub fn outlines(&self, key: &str) -> Result<Vec<Vec<DVec3>>> {
        let Some(list) = self.get(key) else { return Ok(Vec::new()) };
        let Some(items) = list.value.as_array() else { return Err(self.wrong_type(key, "a list of outlines")) };
        let outline = |item: &Value| match item.as_array() {
            Some(points) => self.points_of(key, points),
            None => Err(self.error(format!("an entry of '{key}' is {}, not a list of points", kind(item)))),
        };
        items.iter().map(outline).collect()
    }

    /// Lists of whole numbers, as a mesh has its faces.
    pub fn indices(&self, key: &str) -> Result<Vec<Vec<usize>>> {
        let Some(list) = self.get(key) else { return Err(self.missing(key)) };
        let index = |v: &Value| v.as_u64().and_then(|i| usize::try_from(i).ok());
        let all = list.value.as_array().and_then(|faces| {
            faces.iter().map(|face| face.as_array()?.iter().map(index).collect::<Option<Vec<_>>>()).collect::<Option<Vec<_>>>()
        });
        all.ok_or_else(|| self.wrong_type(key, "a list of lists of whole numbers"))
    }
}

/// Three finite numbers.
fn vector(value: &Value) -> Option<DVec3> {
    let items = value.as_array()?;
    let number = |i: usize| items.get(i)?.as_f64().filter(|v| v.is_finite());
    (items.len() == 3).then_some(())?;
    Some(DVec3::new(number(0)?, number(1)?, number(2)?))
}

/// What a value is, in words.
pub(super) fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}
