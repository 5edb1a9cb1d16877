//! Every kernel has faults planted in it, on purpose, that tests must find: at least [`LEAST`] of them.
//!
//! Faults are read from the sources: a text that stands exactly once in a shader, in a file of tests that
//! names this shader and plants faults ([`MARK`]). What modules that many kernels share lose by a fault
//! is no matter of one kernel, so a fault counts for a kernel if it stands in its own file or in a
//! module that no other kernel imports.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Faults that each kernel needs.
const LEAST: usize = 2;

/// The call by which files of tests plant faults.
const MARK: &str = "mutation::with(";

/// Kernels without so many faults, by their path below `shaders/`; the list may only become shorter.
const WITHOUT_FAULTS: &[&str] = &[];

/// Shaders by their path below a folder without `.wgsl`, without comments.
fn shaders(root: &Path) -> BTreeMap<String, String> {
    fn collect(root: &Path, folder: &Path, found: &mut BTreeMap<String, String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(root, &path, found);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                let name = path.with_extension("").strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
                let code = |line: &str| line.split("//").next().unwrap_or_default().to_string() + "\n";
                found.insert(name, std::fs::read_to_string(&path).unwrap().lines().map(code).collect());
            }
        }
    }
    let mut found = BTreeMap::new();
    collect(root, root, &mut found);
    found
}

/// Modules that a shader imports: `import package::shared::bvh::{Hit};` names shared/bvh.
fn imports(text: &str) -> Vec<String> {
    let paths = text.split("import package::").skip(1).filter_map(|rest| rest.split(';').next());
    paths.map(|path| path.split("::{").next().unwrap_or(path)).map(|path| path.trim().replace("::", "/")).collect()
}

/// The kernels, each with the modules that it alone imports, itself among them. Probes are no kernels.
fn kernels(shaders: &BTreeMap<String, String>) -> BTreeMap<&str, BTreeSet<String>> {
    let is_kernel = |(path, text): &(&String, &String)| text.contains("@compute") && !path.split('/').any(|part| part == "diagnostic");
    let mut reached: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for (path, _) in shaders.iter().filter(is_kernel) {
        let (mut seen, mut open) = (BTreeSet::new(), vec![path.clone()]);
        while let Some(next) = open.pop() {
            open.extend(shaders.get(&next).into_iter().flat_map(|text| imports(text)));
            if !seen.insert(next) {
                continue;
            }
            open.retain(|path| !seen.contains(path));
        }
        reached.insert(path, seen);
    }
    let users = |module: &String| reached.values().filter(|seen| seen.contains(module)).count();
    reached.iter().map(|(path, seen)| (*path, seen.iter().filter(|module| users(module) == 1).cloned().collect())).collect()
}

/// A text in quotes in a Rust source, and what stands between it and the one before.
struct Literal {
    value: String,
    between: String,
}

fn literals(text: &str) -> Vec<Literal> {
    let (mut found, mut between) = (Vec::new(), String::new());
    let chars: Vec<char> = text.chars().collect();
    let mut i = 0;
    while i < chars.len() {
        match chars[i] {
            '/' if chars.get(i + 1) == Some(&'/') => i = (i..chars.len()).find(|k| chars[*k] == '\n').unwrap_or(chars.len()),
            // Characters, also a quote and an escape; lifetimes go by.
            '\'' if chars.get(i + 1) == Some(&'\\') => i += 3,
            '\'' if chars.get(i + 2) == Some(&'\'') => i += 2,
            'r' if chars.get(i + 1) == Some(&'#') && chars.get(i + 2) == Some(&'"') => {
                let end = (i + 3..chars.len()).find(|k| chars[*k] == '"' && chars.get(k + 1) == Some(&'#')).unwrap_or(chars.len());
                found.push(Literal { value: chars[i + 3..end].iter().collect(), between: std::mem::take(&mut between) });
                i = end + 1;
            }
            '"' => {
                let mut value = String::new();
                i += 1;
                while i < chars.len() && chars[i] != '"' {
                    if chars[i] == '\\' {
                        i += 1;
                        match chars.get(i) {
                            Some('n') => value.push('\n'),
                            Some('\n') => i = (i..chars.len()).find(|k| !chars[*k].is_whitespace()).unwrap_or(chars.len()) - 1,
                            Some(c) => value.push(*c),
                            None => {}
                        }
                    } else {
                        value.push(chars[i]);
                    }
                    i += 1;
                }
                found.push(Literal { value, between: std::mem::take(&mut between) });
            }
            c => between.push(c),
        }
        i += 1;
    }
    found
}

/// A fault: shader, text, what it becomes.
type Fault = (String, String, String);

/// Faults that a source plants; and those whose shader does not hold their text once, which it cannot plant.
fn planted(source: &str, shaders: &BTreeMap<String, String>) -> (BTreeSet<Fault>, Vec<String>) {
    let (mut found, mut lost) = (BTreeSet::new(), Vec::new());
    if !source.contains(MARK) {
        return (found, lost);
    }
    let literals = literals(source);
    let is_next = |literal: &Literal| literal.between.chars().all(|c| c == ',' || c.is_whitespace());
    let is_path = |text: &str| shaders.contains_key(text);
    let is_code = |text: &str| text.len() > 4 && text.contains(|c: char| c.is_ascii_punctuation() && c != '_');
    let named: BTreeSet<&str> = literals.iter().map(|l| l.value.as_str()).filter(|text| is_path(text)).collect();
    let holds = |path: &str, text: &str| is_code(text) && shaders[path].matches(text).count() == 1;
    let mut k = 0;
    while k < literals.len() {
        let from = &literals[k].value;
        let before = k.checked_sub(1).map(|p| literals[p].value.as_str()).filter(|text| is_next(&literals[k]) && is_path(text));
        let of: Vec<&str> = match before {
            _ if is_path(from) => Vec::new(),
            Some(path) => vec![path],
            None => named.iter().copied().collect(),
        };
        let of: Vec<&str> = of.into_iter().filter(|path| holds(path, from)).collect();
        k += 1;
        if of.is_empty() {
            lost.extend(before.filter(|_| !is_path(from)).map(|path| format!("{path}: does not hold '{from}' once")));
            continue;
        }
        // What it becomes is no fault by itself.
        let to = literals.get(k).filter(|to| is_next(to)).map(|to| to.value.clone());
        k += usize::from(to.is_some());
        found.extend(of.iter().map(|path| ((*path).to_string(), from.clone(), to.clone().unwrap_or_default())));
    }
    (found, lost)
}

/// What is wrong: kernels with too few faults that are not in the list, names in the list without cause, and faults
/// that cannot be planted.
fn faults(shaders: &BTreeMap<String, String>, sources: &[String], without: &[&str]) -> Vec<String> {
    let (planted, lost): (Vec<_>, Vec<_>) = sources.iter().map(|source| planted(source, shaders)).unzip();
    let planted: BTreeSet<Fault> = planted.into_iter().flatten().collect();
    let kernels = kernels(shaders);
    let mut found = lost.concat();
    for (kernel, modules) in &kernels {
        let count = planted.iter().filter(|(path, ..)| modules.contains(path)).count();
        match (count >= LEAST, without.contains(kernel)) {
            (false, false) => found.push(format!("{kernel}: {count} faults are planted in it, {LEAST} are needed")),
            (true, true) => found.push(format!("{kernel}: has its {count} faults: take it out of WITHOUT_FAULTS")),
            _ => {}
        }
    }
    found.extend(without.iter().filter(|name| !kernels.contains_key(*name)).map(|name| format!("{name}: there is no such kernel")));
    found
}

#[test]
fn every_kernel_has_planted_faults() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shaders = shaders(&root.join("shaders"));
    let mut files = Vec::new();
    super::rust_files(&root.join("src"), &mut files);
    let sources: Vec<String> = files.iter().map(|f| std::fs::read_to_string(f).unwrap()).collect();
    assert!(kernels(&shaders).len() > 20, "only {} kernels were found", kernels(&shaders).len());
    let found = faults(&shaders, &sources, WITHOUT_FAULTS);
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn a_kernel_without_faults_is_found() {
    let shader = |path: &str, text: &str| (path.to_string(), text.to_string());
    let shaders = BTreeMap::from([
        shader(
            "a/gather",
            "import package::all::sun::{x};\nimport package::a::own::{y};\n@compute fn main() { let p = q * 2.0; sum += p.x; }",
        ),
        shader("b/gather", "import package::all::sun::{x};\n@compute fn main() { let a = 1.0; let b = 2.0; }"),
        shader("a/own", "fn y() { return max(z, 0.0); }"),
        shader("all/sun", "fn x() { return 1.0 / 3.0 + 2.0; }"),
        shader("diagnostic/probe", "@compute fn main() {}"),
    ]);
    let check =
        |sources: &[&str], without: &[&str]| faults(&shaders, &sources.iter().map(|s| (*s).to_string()).collect::<Vec<_>>(), without);
    let a = "for (from, to) in [(\"q * 2.0\", \"q\"), (\"sum += p.x;\", \"\")] { mutation::with(\"a/gather\", from, to, f) }";
    let b = "for (_, path, from, to) in [(2, \"b/gather\", \"let a = 1.0;\", \"'\\\"'\"),\n(4, \"b/gather\", \"let b = 2.0;\", \"let a = 1.0;\")] \
             { mutation::with(path, from, to, f) }";
    assert_eq!(check(&[a, b], &[]), [""; 0]);
    // One of a module that only this kernel has counts, one of a module that both have does not; what a text becomes is no fault.
    let own = "mutation::with(\"a/own\", \"max(z, 0.0)\", \"z\", f); mutation::with(\"a/gather\", \"let p = q * 2.0;\", \"q * 2.0;\", f);";
    assert_eq!(check(&[own, b], &[]), [""; 0]);
    let one = ["a/gather: 1 faults are planted in it, 2 are needed"];
    let shared = own.replace("a/own", "all/sun").replace("max(z, 0.0)", "1.0 / 3.0");
    assert_eq!(check(&[&shared, b], &[]), one);
    // A text that the shader does not hold, the same fault twice, a comment, and a file that plants nothing.
    assert_eq!(check(&[&a.replace("sum += p.x;", "sum -= p.x;"), b], &[]), one);
    assert_eq!(check(&[&a.replace("sum += p.x;\", \"", "q * 2.0\", \"q"), b], &[]), one);
    assert_eq!(check(&[&a.replace("(\"sum", "\n// (\"sum").replace(")] {", "\n)] {"), b], &[]), one);
    assert_eq!(check(&[&a.replace("mutation::with", "show"), b], &[]).len(), 1);
    // A text that its shader lost.
    assert_eq!(check(&[a, &format!("{own}{b}").replace("max(z, 0.0)", "max(z, 1.0)")], &[]), ["a/own: does not hold 'max(z, 1.0)' once"]);
    // The list: a kernel that needs it, one that does not, one that is none.
    assert_eq!(check(&[b], &["a/gather"]), [""; 0]);
    assert_eq!(check(&[a, b], &["b/gather"]), ["b/gather: has its 2 faults: take it out of WITHOUT_FAULTS"]);
    assert_eq!(check(&[a, b], &["c/gather"]), ["c/gather: there is no such kernel"]);
}
