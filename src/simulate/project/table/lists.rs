//! Values that are lists.

use super::Table;
use crate::error::Result;
use std::path::PathBuf;
use toml::Spanned;
use toml::de::DeValue;

/// What stands under a name.
pub(in super::super) enum Named {
    /// A text.
    Text(String),
    /// `{ rule = "…" }`
    Rule(String),
    /// `{ lm-83 = ["open", "closed"] }`
    Lm83([String; 2]),
}

impl Table<'_, '_> {
    /// All keys of a table whose keys are names, each with what stands there.
    pub(in super::super) fn all_named(&mut self) -> Result<Vec<(String, Named)>> {
        #[cfg(test)]
        super::asked::note(&self.name, "GROUP");
        self.entries.iter().map(|(key, value)| Ok((key.get_ref().to_string(), self.named(key.get_ref(), value.get_ref())?))).collect()
    }

    fn named(&self, key: &str, value: &DeValue<'_>) -> Result<Named> {
        let help = "write a text, { rule = \"closed if irradiance > 250 W/m2\" } or { lm-83 = [\"open\", \"closed\"] }";
        let entries = match value {
            DeValue::String(s) if !s.trim().is_empty() => return Ok(Named::Text(s.to_string())),
            DeValue::String(_) => return Err(self.error(key, "this text is empty")),
            DeValue::Table(entries) => entries,
            other => return Err(self.wrong_type(key, other, "a text in quotes").help(help)),
        };
        let only = entries.iter().next().filter(|_| entries.len() == 1).map(|(k, v)| (k.get_ref().as_ref(), v.get_ref()));
        match only {
            Some(("rule", DeValue::String(s))) if !s.trim().is_empty() => Ok(Named::Rule(s.to_string())),
            Some(("lm-83", DeValue::Array(items))) => match items.iter().map(Spanned::get_ref).collect::<Vec<_>>()[..] {
                [DeValue::String(open), DeValue::String(closed)] => Ok(Named::Lm83([open.to_string(), closed.to_string()])),
                _ => Err(self.error(key, "'lm-83' has the names of two states, open and closed").help(help)),
            },
            _ => Err(self.error(key, "here stands either a 'rule' or 'lm-83'").help(help)),
        }
    }

    /// A file named by the text of a key.
    pub(in super::super) fn file_named(&self, key: &str, text: &str) -> Result<PathBuf> {
        self.existing_file(key, text)
    }

    /// Two files, and how far (0…1) between them.
    pub(in super::super) fn files_and_fraction(&mut self, key: &'static str) -> Result<Option<([PathBuf; 2], f64)>> {
        let example = format!("write {key} = [\"clear.xml\", \"cloudy.xml\", 0.5]: two files, and how far from the first to the second");
        let Some(value) = self.get(key).map(Spanned::get_ref) else { return Ok(None) };
        let DeValue::Array(items) = value else { return Err(self.wrong_type(key, value, "a list").help(example)) };
        let items: Vec<&DeValue<'_>> = items.iter().map(Spanned::get_ref).collect();
        let [DeValue::String(a), DeValue::String(b), fraction] = items[..] else {
            return Err(self.error(key, "this is not two files and a number").help(example));
        };
        let files = [self.existing_file(key, a)?, self.existing_file(key, b)?];
        Ok(Some((files, self.number_of(key, fraction, &(0.0..=1.0))?)))
    }

    /// A text, or a non-empty list of them.
    pub(in super::super) fn texts(&mut self, key: &'static str, example: &str) -> Result<Option<Vec<String>>> {
        match self.get(key).map(Spanned::get_ref) {
            Some(DeValue::String(_)) => Ok(self.string(key)?.map(|text| vec![text])),
            _ => self.strings(key, example),
        }
    }

    /// A list of texts that is not empty; `example` shows one.
    pub(in super::super) fn strings(&mut self, key: &'static str, example: &str) -> Result<Option<Vec<String>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong_type(key, value.get_ref(), &format!("a list like {example}")));
        };
        if items.is_empty() {
            return Err(self.error(key, "this list is empty").help(format!("write {key} = {example} or the like")));
        }
        let text = |item: &Spanned<DeValue<'_>>| match item.get_ref() {
            DeValue::String(s) if !s.trim().is_empty() => Ok(s.to_string()),
            DeValue::String(_) => Err(self.error(key, "a text of this list is empty")),
            other => Err(self.wrong_type(key, other, "a text in quotes")),
        };
        items.iter().map(text).collect::<Result<_>>().map(Some)
    }

    /// A list of numbers within limits.
    pub(in super::super) fn numbers(&mut self, key: &'static str, limits: std::ops::RangeInclusive<f64>) -> Result<Option<Vec<f64>>> {
        match self.get(key).map(Spanned::get_ref) {
            None => Ok(None),
            Some(DeValue::Array(items)) => items.iter().map(|i| self.number_of(key, i.get_ref(), &limits)).collect::<Result<_>>().map(Some),
            Some(other) => Err(self.wrong_type(key, other, "a list of numbers like [8, 18]")),
        }
    }

    /// A list of whole numbers within limits.
    pub(in super::super) fn integers(&mut self, key: &'static str, limits: std::ops::RangeInclusive<u64>) -> Result<Option<Vec<u64>>> {
        match self.get(key).map(Spanned::get_ref) {
            None => Ok(None),
            Some(DeValue::Array(items)) => items.iter().map(|i| self.listed(key, i.get_ref(), &limits)).collect::<Result<_>>().map(Some),
            Some(other) => Err(self.wrong_type(key, other, "a list of whole numbers like [400, 400]")),
        }
    }

    fn listed(&self, key: &str, item: &DeValue<'_>, limits: &std::ops::RangeInclusive<u64>) -> Result<u64> {
        let DeValue::Integer(i) = item else { return Err(self.wrong_type(key, item, "a whole number")) };
        let value = i64::from_str_radix(i.as_str(), i.radix()).ok().and_then(|v| u64::try_from(v).ok());
        value.filter(|v| limits.contains(v)).ok_or_else(|| {
            self.error(key, format!("the number {} is out of range", i.as_str())).help(format!(
                "choose whole numbers from {} to {}",
                limits.start(),
                limits.end()
            ))
        })
    }

    /// A list of whole numbers within limits (`Ok`) or one of several words (`Err`).
    #[allow(clippy::type_complexity, reason = "one of two kinds of value, or none")]
    pub(in super::super) fn integers_or_choice(
        &mut self,
        key: &'static str,
        limits: std::ops::RangeInclusive<u64>,
        words: &[&'static str],
    ) -> Result<Option<std::result::Result<Vec<u64>, &'static str>>> {
        if let Some(DeValue::String(_)) = self.get(key).map(Spanned::get_ref) {
            let choices: Vec<(&str, &'static str)> = words.iter().map(|&w| (w, w)).collect();
            return Ok(self.choice_beside(key, &choices, ", or a list of whole numbers")?.map(Err));
        }
        Ok(self.integers(key, limits)?.map(Ok))
    }

    /// A list of whole numbers within limits (`Ok`) or a path (`Err`).
    #[allow(clippy::type_complexity, reason = "one of two kinds of value, or none")]
    pub(in super::super) fn integers_or_path(
        &mut self,
        key: &'static str,
        limits: std::ops::RangeInclusive<u64>,
    ) -> Result<Option<std::result::Result<Vec<u64>, PathBuf>>> {
        if let Some(DeValue::String(_)) = self.get(key).map(Spanned::get_ref) {
            return Ok(self.path(key)?.map(Err));
        }
        Ok(self.integers(key, limits)?.map(Ok))
    }
}
