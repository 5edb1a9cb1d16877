//! A document that tests and benchmarks fill: its template with places `{{key}}` and `{{key.held}}`.

use std::collections::BTreeMap;

/// What a place shows of which nothing was ever measured.
pub const NOTHING: &str = "–";

/// A piece of a line of the template.
#[derive(Debug, PartialEq)]
pub enum Piece<'t> {
    /// Text that stands in the document as it is.
    Text(&'t str),
    /// The place of what was measured, by its name: `key` or `key.held`.
    Place(&'t str),
}

/// Texts and places of a line of the template, in turn.
pub fn pieces(line: &str) -> Vec<Piece<'_>> {
    let mut found = Vec::new();
    let mut rest = line;
    while let Some((text, after)) = rest.split_once("{{") {
        let (place, after) = after.split_once("}}").unwrap_or_else(|| panic!("no end of a place: {line}"));
        found.extend([Piece::Text(text), Piece::Place(place)]);
        rest = after;
    }
    found.push(Piece::Text(rest));
    found
}

/// Whether `line` is the template's line with something in each place; what that is goes to `values`.
pub fn fits<'t, 'd>(template: &[Piece<'t>], line: &'d str, values: &mut Vec<(&'t str, &'d str)>) -> bool {
    match template {
        [] => line.is_empty(),
        [Piece::Text(text), rest @ ..] => line.strip_prefix(text).is_some_and(|after| fits(rest, after, values)),
        [Piece::Place(place), rest @ ..] => {
            for (start, c) in line.char_indices() {
                // Values stay within a table's cell.
                if c == '|' {
                    return false;
                }
                let (value, after) = line.split_at(start + c.len_utf8());
                values.push((place, value));
                if fits(rest, after, values) {
                    return true;
                }
                values.pop();
            }
            false
        }
    }
}

/// What places of the template show in a document, also in one of an older template as far as lines are alike.
fn present<'t>(template: &'t str, document: &str) -> BTreeMap<&'t str, String> {
    let lines: Vec<&str> = document.lines().collect();
    let mut found = BTreeMap::new();
    for (number, wanted) in template.lines().enumerate().filter(|(_, line)| line.contains("{{")) {
        let wanted = pieces(wanted);
        // Its own line first.
        for line in lines.get(number).into_iter().chain(&lines) {
            let mut values = Vec::new();
            if fits(&wanted, line, &mut values) {
                found.extend(values.into_iter().map(|(place, value)| (place, value.to_string())));
                break;
            }
        }
    }
    found
}

/// The template with what was measured in its places, and where nothing was, with what the present document shows; and the
/// places that stay as they were.
pub fn fill(template: &str, document: &str, measured: impl Fn(&str) -> Option<[String; 2]>) -> (String, Vec<String>) {
    let present = present(template, document);
    let (mut text, mut kept) = (String::new(), Vec::new());
    for line in template.lines() {
        for piece in pieces(line) {
            match piece {
                Piece::Text(piece) => text.push_str(piece),
                Piece::Place(place) => {
                    let (key, held) = place.strip_suffix(".held").map_or((place, 0), |key| (key, 1));
                    let new = measured(key).map(|both| both[held].clone()).filter(|new| !new.is_empty());
                    if new.is_none() {
                        kept.push(place.to_string());
                    }
                    text.push_str(&new.or_else(|| present.get(place).cloned()).unwrap_or_else(|| NOTHING.to_string()));
                }
            }
        }
        text.push('\n');
    }
    (text, kept)
}
