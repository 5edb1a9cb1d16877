//! Tells the library which sources it was made from, so that a stored matrix is used only by the program
//! whose code computed it, whatever the version's number says.

use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rerun-if-changed=shaders");
    let mut files = Vec::new();
    collect(Path::new("src"), &mut files);
    collect(Path::new("shaders"), &mut files);
    files.sort();
    // FNV-1a, 64 bits.
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for file in files {
        let text = std::fs::read(&file).unwrap_or_default();
        // Line ends differ between checkouts.
        for byte in text.into_iter().filter(|b| *b != b'\r') {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    println!("cargo::rustc-env=LUCARNE_SOURCES={hash:016x}");
}

/// Files whose text may change what is computed: neither tests nor the command line nor pages for users.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        let aside = ["cli", "guide"].contains(&name.as_str()) || name.contains("test") || name == "main.rs" || name == "build.rs";
        if path.is_dir() && !aside {
            collect(&path, files);
        } else if !aside && (name.ends_with(".rs") || name.ends_with(".wgsl")) {
            files.push(path);
        }
    }
}
