//! The house rules that one crate cannot enforce by itself: which module may import which, that
//! the library never prints, and that nothing is ever executed on behalf of an input file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

mod faults;
mod imports;
#[path = "../../src/testing.rs"]
mod testing;

use imports::{Tree, circles};

/// What each module of the library may import; light flows from the top of the list to its end.
/// `error` and `units` are open to all and not repeated.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("units", &[]),
    ("statistics", &[]),
    ("random", &[]),
    // Pages for users.
    ("guide", &[]),
    ("limits", &[]),
    ("files", &[]),
    // Opens what people wrote.
    ("text", &["files"]),
    ("progress", &[]),
    // Knows the device, and nothing about daylight.
    ("gpu", &["progress"]),
    ("bins", &[]),
    ("matrix", &["text", "files", "progress"]),
    ("bsdf", &["bins", "matrix", "text", "files", "progress"]),
    ("weather", &["matrix", "text", "files"]),
    ("sky", &["bins", "weather", "matrix", "files", "progress"]),
    ("bvh", &["progress"]),
    ("camera", &["bins", "text", "files"]),
    ("image", &["camera", "files", "matrix", "progress"]),
    ("scene", &["bins", "bsdf", "image", "text", "files", "progress"]),
    // Definitions of metrics in f64.
    ("glare", &["bins", "camera", "image", "matrix", "progress"]),
    // Named metrics of a year, in f64 over arrays: knows nothing of simulate.
    ("metrics", &["glare", "matrix", "text", "weather"]),
    // States of a façade over the year, in f64 over arrays: knows nothing of simulate.
    ("control", &["metrics", "matrix", "text", "weather", "files"]),
    // Device code with its host half: reads no files.
    ("kernels", &["gpu", "bins", "bsdf", "scene", "bvh", "sky", "camera", "image", "glare", "matrix", "progress"]),
    (
        "simulate",
        &[
            "gpu", "bvh", "kernels", "bins", "bsdf", "weather", "sky", "scene", "camera", "image", "glare", "metrics", "control", "matrix",
            "text", "files", "progress",
        ],
    ),
    // What results hold, on a page.
    ("report", &["simulate", "metrics", "bsdf", "weather", "scene", "image", "glare", "metrics", "files"]),
];

const OPEN_TO_ALL: &[&str] = &["error", "limits", "units", "statistics", "random"];

/// The order inside the module that is a house of its own: each part imports only parts before it.
const INSIDE_SIMULATE: &[&str] = &[
    "multiply", "project", "store", "inputs", "context", "light", "sampling", "plan", "overall", "phases", "results", "summary", "year",
    "run", "ready", "rooms", "tradeoff",
];

/// Files that import each other still; the list may only become shorter.
const KNOWN_CIRCLES: &[&[&str]] = &[];

/// A file of the library: the module it belongs to and its text without tests.
struct Source {
    path: PathBuf,
    module: String,
    text: String,
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// All sources below `src/`, the command line's included, without what only tests compile.
fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&root, &mut files);
    files.sort();
    let texts: Vec<(PathBuf, String)> = files.into_iter().map(|f| (f.clone(), std::fs::read_to_string(f).unwrap())).collect();
    let test_files: BTreeSet<PathBuf> = texts.iter().flat_map(|(path, text)| test_modules(path, text)).collect();
    texts
        .into_iter()
        .filter(|(path, _)| !test_files.iter().any(|t| path == t || path.starts_with(t.with_extension(""))))
        .map(|(path, text)| {
            let inside = path.strip_prefix(&root).unwrap();
            let first = inside.components().next().unwrap().as_os_str().to_string_lossy().to_string();
            Source { module: first.trim_end_matches(".rs").to_string(), text: without_tests(&text), path }
        })
        .collect()
}

/// Files of modules declared `#[cfg(test)] mod name;`.
fn test_modules(path: &Path, text: &str) -> Vec<PathBuf> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let folder = match path.file_name().and_then(|n| n.to_str()) {
        Some("mod.rs" | "lib.rs" | "main.rs") => path.parent().unwrap().to_path_buf(),
        _ => path.with_extension(""),
    };
    lines
        .windows(2)
        .filter(|w| w[0].starts_with("#[cfg(test)]"))
        .filter_map(|w| w[1].trim_start_matches("pub(crate) ").strip_prefix("mod ")?.strip_suffix(';'))
        .map(|name| folder.join(name).with_extension("rs"))
        .collect()
}

/// The text up to its test module, without comments.
fn without_tests(text: &str) -> String {
    let mut kept = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line.trim_start().starts_with("#[cfg(test)]") && lines.peek().is_some_and(|l| l.contains("mod ") && l.trim_end().ends_with('{'))
        {
            break;
        }
        let code = match line.find("//") {
            // `://` is an address in a text, not a comment.
            Some(i) if i == 0 || !line[..i].ends_with(':') => &line[..i],
            _ => line,
        };
        kept.push_str(code);
        kept.push('\n');
    }
    kept
}

/// Modules named after `crate::` in a text, in `use` lines and in paths.
fn imported_modules(text: &str, root: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (i, _) in text.match_indices(root) {
        let before = text[..i].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':' || c == '$') {
            continue;
        }
        let rest = &text[i + root.len()..];
        if let Some(group) = rest.strip_prefix('{') {
            found.extend(first_words_of_group(group));
        } else {
            found.extend(module_word(rest));
        }
    }
    found
}

/// The word at the start of a path, if it names a module: macros and re-exports at the root do not.
fn module_word(text: &str) -> Option<String> {
    let word: String = text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    let is_macro = text[word.len()..].starts_with('!');
    word.chars().next().filter(|c| c.is_lowercase() && !is_macro)?;
    // A macro that the device layer exports at the root.
    Some(if word == "gpu_struct" { "gpu".to_string() } else { word })
}

/// `a::b, c::{d, e}, f}` gives a, c, f.
fn first_words_of_group(text: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut depth = 0;
    let mut at_start = true;
    for (i, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => at_start = true,
            c if c.is_whitespace() => {}
            _ if at_start => {
                words.extend(module_word(&text[i..]));
                at_start = false;
            }
            _ => {}
        }
    }
    words
}

#[test]
fn modules_import_one_way_only() {
    let rules: BTreeMap<&str, &[&str]> = MAY_IMPORT.iter().copied().collect();
    let mut faults = Vec::new();
    let mut checked = 0;
    for source in sources() {
        if matches!(source.module.as_str(), "lib" | "main" | "cli" | "build") {
            continue;
        }
        let Some(allowed) = rules.get(source.module.as_str()) else {
            faults.push(format!("{}: module '{}' is not in the list of this test", source.path.display(), source.module));
            continue;
        };
        checked += 1;
        for module in imported_modules(&source.text, "crate::") {
            let fine = module == source.module || OPEN_TO_ALL.contains(&module.as_str()) || allowed.contains(&module.as_str());
            if !fine {
                faults.push(format!("{}: '{}' may not import '{module}'", source.path.display(), source.module));
            }
        }
    }
    assert!(checked > 10, "only {checked} files were found");
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_list_itself_has_no_circle() {
    // Each module may import only modules that stand before it, but for those that stand apart.
    for (i, (module, allowed)) in MAY_IMPORT.iter().enumerate() {
        for import in *allowed {
            let place = MAY_IMPORT.iter().position(|(m, _)| m == import).unwrap_or_else(|| panic!("'{import}' is not in the list"));
            assert!(place < i, "'{module}' imports '{import}', which stands after it");
        }
    }
    for module in ["scene", "bvh", "bsdf", "weather", "sky", "bins", "glare", "image", "camera"] {
        let (_, allowed) = MAY_IMPORT.iter().find(|(m, _)| *m == module).unwrap();
        assert!(!allowed.contains(&"gpu") && !allowed.contains(&"kernels"), "'{module}' must not know the device");
    }
}

#[test]
fn simulate_imports_one_way_inside() {
    let tree = Tree::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    let part = |file: &[String]| INSIDE_SIMULATE.iter().position(|p| file.get(1).is_some_and(|f| f == p));
    let mut faults = Vec::new();
    let mut checked = 0;
    for (file, imports) in tree.edges().iter().filter(|(f, _)| f.first().is_some_and(|m| m == "simulate") && f.len() > 1) {
        let Some(own) = part(file) else {
            faults.push(format!("{}: is not in the list of this test", file.join("/")));
            continue;
        };
        checked += 1;
        for import in imports.iter().filter(|i| i.first().is_some_and(|m| m == "simulate")) {
            if part(import).is_some_and(|place| place > own) {
                faults.push(format!("{} imports {}, which stands after it", file.join("/"), import.join("/")));
            }
        }
    }
    assert!(checked > 30, "only {checked} files were found");
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    for folder in ["src", "viewer/src"] {
        let tree = Tree::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder));
        let found = circles(tree.edges());
        let known = |c: &Vec<String>| KNOWN_CIRCLES.iter().any(|k| *k == c.iter().map(String::as_str).collect::<Vec<_>>());
        let new: Vec<String> = found.iter().filter(|c| !known(c)).map(|c| c.join(", ")).collect();
        assert!(new.is_empty(), "files that import each other in a circle:\n{}", new.join("\n"));
        if folder == "src" {
            assert_eq!(found.len(), KNOWN_CIRCLES.len(), "a circle is gone: take it out of the list");
        }
    }
}

#[test]
fn the_library_never_prints_and_nothing_is_executed() {
    let mut faults = Vec::new();
    for source in sources() {
        let prints = ["println!", "eprintln!", "print!(", "eprint!(", "dbg!(", "stderr()"];
        let is_cli = matches!(source.module.as_str(), "cli" | "main" | "build");
        for word in prints.iter().filter(|w| !is_cli && source.text.contains(**w)) {
            faults.push(format!("{}: the library prints ({word})", source.path.display()));
        }
        for word in ["process::Command", "Command::new"] {
            // `lucarne view` starts the viewer that lies beside it: no input file has a say in that.
            // `lucarne tradeoff` measures Radiance beside itself, by fixed names on PATH and arguments made there.
            if source.text.contains(word) && !source.path.ends_with("cli/viewer.rs") && !source.path.ends_with("cli/tradeoff/radiance.rs") {
                faults.push(format!("{}: runs a program ({word})", source.path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_command_line_reaches_the_library_by_its_public_face() {
    // `cli` is compiled into the binary only: the library cannot import it, and it has no way in
    // but `lucarne::`.
    let library = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    assert!(!library.contains("mod cli"));
    for source in sources().iter().filter(|s| s.module == "cli") {
        for module in imported_modules(&source.text, "crate::") {
            assert_eq!(module, "cli", "{}", source.path.display());
        }
    }
}

/// Whoever lacks something says so by `testing::skip`: what a passing test prints is swallowed.
#[test]
fn no_test_is_skipped_without_being_counted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut faults = Vec::new();
    for folder in ["src", "tests", "viewer/src"] {
        for path in {
            let mut files = Vec::new();
            rust_files(&root.join(folder), &mut files);
            files
        } {
            // Benchmarks are no tests: they print.
            let own = path.ends_with("testing.rs")
                || path.ends_with("tests/architecture/main.rs")
                || path.starts_with(root.join("tests/benches"));
            let text = std::fs::read_to_string(&path).unwrap();
            if !own && (text.contains("SKIPPED") || text.contains("LUCARNE_REQUIRE")) {
                faults.push(path.display().to_string());
            }
        }
    }
    assert!(faults.is_empty(), "use testing::skip in {}", faults.join(", "));
}

#[test]
fn the_scanner_sees_what_it_should() {
    let text = without_tests(
        "use crate::error::Error; // use crate::gpu\n\
         use crate::{bins::{Frame, rings}, Warnings, matrix::Matrix};\n\
         fn f() { crate::kernels::product(); crate::gpu_struct!(X); other_crate::scene::x(); }\n\
         #[cfg(test)]\nmod tests {\n use crate::sky;\n}",
    );
    let found: Vec<String> = imported_modules(&text, "crate::").into_iter().collect();
    assert_eq!(found, ["bins", "error", "kernels", "matrix"]);
}

#[test]
fn circles_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    write("lib.rs", "pub mod a;\npub mod b;\npub mod c;\n");
    write("a.rs", "use crate::{b::X, c};\n");
    write("b/mod.rs", "mod inner;\npub use self::inner::X;\n#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n");
    write("b/inner.rs", "// use crate::a;\npub struct X;\n");
    write("c.rs", "fn f() { crate::b::inner::g(); }\n");
    assert!(circles(Tree::read(folder.path()).edges()).is_empty());
    write("b/inner.rs", "use super::super::a::Y;\npub struct X;\n");
    assert_eq!(circles(Tree::read(folder.path()).edges()), [["a", "b", "b/inner", "c"].map(String::from)]);
}

#[test]
fn the_top_level_holds_only_what_it_should() {
    let allowed =
        ["Cargo.toml", "Cargo.lock", "shaders", "src", "viewer", "scenes", "tests", "README.md", "VALIDATION.md", "LICENSE", "Makefile"];
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let Ok(git) = std::process::Command::new("git").arg("-C").arg(root).args(["ls-tree", "--name-only", "HEAD"]).output() else {
        testing::note(&"no git");
        return;
    };
    let names = String::from_utf8_lossy(&git.stdout).to_string();
    let extra: Vec<&str> = names.lines().filter(|n| !n.starts_with('.') && !allowed.contains(n)).collect();
    // One more document is welcome, no more.
    assert!(extra.len() <= 1 && extra.iter().all(|n| n.ends_with(".md")), "unexpected at the top: {extra:?}");
}
