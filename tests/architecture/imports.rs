//! Which source file imports which: read from `use` lines and paths, as far as a scanner sees them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A file by the words of its module's path: `["simulate", "inputs", "shade"]`.
pub type File = Vec<String>;

/// The files of a crate and what they import of each other.
pub struct Tree {
    edges: BTreeMap<File, BTreeSet<File>>,
}

impl Tree {
    /// Reads all sources below a folder, without what only tests compile.
    pub fn read(root: &Path) -> Self {
        let mut paths = Vec::new();
        super::rust_files(root, &mut paths);
        let texts: BTreeMap<_, String> = paths.into_iter().map(|p| (p.clone(), std::fs::read_to_string(p).unwrap())).collect();
        let tests: BTreeSet<_> = texts.iter().flat_map(|(path, text)| super::test_modules(path, text)).collect();
        let files: BTreeMap<File, String> = texts
            .iter()
            .filter(|(path, _)| !tests.iter().any(|t| *path == t || path.starts_with(t.with_extension(""))))
            .map(|(path, text)| (file_of(path.strip_prefix(root).unwrap()), super::without_tests(text)))
            .collect();
        let edges = files.iter().map(|(file, text)| (file.clone(), imports(file, text, &files))).collect();
        Self { edges }
    }

    /// Imports of each file, itself and the crate's root left out.
    pub fn edges(&self) -> &BTreeMap<File, BTreeSet<File>> {
        &self.edges
    }
}

fn file_of(path: &Path) -> File {
    let mut words: File = path.with_extension("").components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
    if words.last().is_some_and(|w| matches!(w.as_str(), "mod" | "lib" | "main")) {
        words.pop();
    }
    words
}

fn imports(file: &File, text: &str, files: &BTreeMap<File, String>) -> BTreeSet<File> {
    let mut found = BTreeSet::new();
    for root in ["crate::", "super::", "self::"] {
        for (i, _) in text.match_indices(root) {
            let before = text[..i].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || matches!(c, '_' | ':' | '$')) {
                continue;
            }
            for path in expand(&text[i..]) {
                let target = resolve(file, &path, files);
                if !target.is_empty() && target != *file {
                    found.insert(target);
                }
            }
        }
    }
    found
}

/// The paths that a use tree stands for: `a::{b, c::d}` gives a::b and a::c::d.
fn expand(text: &str) -> Vec<Vec<String>> {
    let mut words = Vec::new();
    let mut rest = text;
    loop {
        if let Some(group) = rest.strip_prefix('{') {
            return parts_of_group(group)
                .iter()
                .flat_map(|part| expand(part.trim_start()))
                .map(|path| words.iter().cloned().chain(path).collect())
                .collect();
        }
        let word: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if word.is_empty() {
            return vec![words];
        }
        rest = &rest[word.len()..];
        words.push(word);
        match rest.strip_prefix("::") {
            Some(after) => rest = after,
            None => return vec![words],
        }
    }
}

fn parts_of_group(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                parts.push(&text[start..i]);
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts
}

/// The file that a path leads to: its longest beginning that is one.
fn resolve(file: &File, path: &[String], files: &BTreeMap<File, String>) -> File {
    let mut words = if path[0] == "crate" { Vec::new() } else { file.clone() };
    for word in path {
        match word.as_str() {
            "crate" | "self" => {}
            "super" => {
                words.pop();
            }
            _ => words.push(word.clone()),
        }
    }
    while !words.is_empty() && !files.contains_key(&words) {
        words.pop();
    }
    words
}

/// Groups of files each of which imports all others, directly or by way of others: sorted, as `a/b`.
pub fn circles(edges: &BTreeMap<File, BTreeSet<File>>) -> Vec<Vec<String>> {
    let reached: BTreeMap<&File, BTreeSet<&File>> = edges.keys().map(|file| (file, reach(file, edges))).collect();
    let mut found: BTreeSet<Vec<String>> = BTreeSet::new();
    for (file, all) in reached.iter().filter(|(file, all)| all.contains(*file)) {
        let circle = all.iter().filter(|other| reached[**other].contains(*file));
        found.insert(circle.map(|f| f.join("/")).collect());
    }
    found.into_iter().collect()
}

fn reach<'e>(file: &File, edges: &'e BTreeMap<File, BTreeSet<File>>) -> BTreeSet<&'e File> {
    let mut seen = BTreeSet::new();
    let mut open: Vec<&File> = edges.get(file).into_iter().flatten().collect();
    while let Some(next) = open.pop() {
        if edges.contains_key(next) && seen.insert(next) {
            open.extend(&edges[next]);
        }
    }
    seen
}
