//! States of the objects of dynamic groups.

use super::Reader;
use crate::error::{Error, Result};
use crate::scene::honeybee::json::Node;
use crate::scene::honeybee::modifiers::{Modifier, Role, radiance};
use crate::scene::honeybee::states::{OpeningState, StateShade};
use std::rc::Rc;

impl<'a> Reader<'a, '_> {
    /// The dynamic group of an object.
    pub(super) fn group_of(&self, node: &Node<'a>) -> Result<Option<String>> {
        match radiance(node)? {
            Some(properties) => Ok(properties.text("dynamic_group_identifier")?.map(str::to_string)),
            None => Ok(None),
        }
    }

    /// The modifier of an object, in the first of its states if it has some, and these.
    pub(super) fn states(&mut self, node: &Node<'a>, set: Option<&Node<'a>>, role: Role) -> Result<(Rc<Modifier>, Vec<OpeningState>)> {
        let Some(group) = self.group_of(node)? else { return Ok((self.modifiers.of(node, set, role, self.warnings)?, Vec::new())) };
        let states = match radiance(node)? {
            Some(properties) => properties.list("states")?,
            None => Vec::new(),
        };
        let groups = if matches!(role, Role::Shade { .. } | Role::Context) { &mut self.shade_groups } else { &mut self.groups };
        let most = groups.entry(group).or_default();
        *most = (*most).max(states.len());
        let mut found = Vec::with_capacity(states.len().max(1));
        for state in &states {
            let modifier = match state.get("modifier") {
                Some(modifier) => self.modifiers.find(&modifier, node, self.warnings)?,
                None => self.modifiers.of(node, set, role, self.warnings)?,
            };
            let direct = state.get("modifier_direct").map(|m| self.modifiers.find(&m, node, self.warnings)).transpose()?;
            let direct = direct.filter(|d| d.identifier != modifier.identifier);
            if let Some(key) = ["vmtx_geometry", "dmtx_geometry"].into_iter().find(|key| state.get(key).is_some()) {
                let told = node.error(format!("'{key}' of its states has no effect: V and D are taken at the aperture itself"));
                self.warn(told.help("move the aperture if the depth of what is in it matters"));
            }
            let mut shades = Vec::new();
            for shade in state.list("shades")? {
                shades.push(self.shade_of_state(&shade)?);
            }
            found.push(OpeningState { modifier, direct, shades });
        }
        if found.is_empty() {
            let modifier = self.modifiers.of(node, set, role, self.warnings)?;
            found.push(OpeningState { modifier, direct: None, shades: Vec::new() });
        }
        Ok((Rc::clone(&found[0].modifier), found))
    }

    fn shade_of_state(&mut self, shade: &Node<'a>) -> Result<StateShade> {
        let face = self.geometry(shade)?;
        let modifier = match shade.get("modifier") {
            Some(modifier) => self.modifiers.find(&modifier, shade, self.warnings)?,
            None => self.modifiers.of(shade, None, Role::Shade { indoor: false }, self.warnings)?,
        };
        let direct = shade.get("modifier_direct").map(|m| self.modifiers.find(&m, shade, self.warnings)).transpose()?;
        Ok(StateShade { face, modifier, direct, origin: self.origin(shade)? })
    }

    /// Shades of a state that are part of the scene.
    pub(super) fn state_shades(&mut self, shades: &[StateShade]) -> Result<()> {
        for StateShade { face, modifier, origin, .. } in shades {
            let told = |e: Error| e.field(format!("shade '{}' of a state", origin.name));
            self.add_triangles(origin.clone(), face.triangles().triangles, modifier).map_err(told)?;
        }
        Ok(())
    }
}
