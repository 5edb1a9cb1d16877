//! For tests of tests: a shader with a fault put in on purpose.

use super::link::{Linked, link_with};
use super::sources;
use crate::error::Result;
use std::cell::RefCell;

thread_local! {
    /// Path and text of the changed file.
    static MUTANT: RefCell<Option<(String, String)>> = const { RefCell::new(None) };
}

/// Runs `f` with `from` replaced by `to` in the shader file `path`, for kernels made by this thread.
///
/// # Panics
/// Unless `from` occurs in the file exactly once: a mutation must not outlive what it changes.
pub fn with<R>(path: &str, from: &str, to: &str, f: impl FnOnce() -> R) -> R {
    let text = sources::source(path).unwrap_or_else(|| panic!("there is no shader {path}"));
    assert_eq!(text.matches(from).count(), 1, "shaders/{path}.wgsl holds '{from}'");
    struct Restore;
    impl Drop for Restore {
        fn drop(&mut self) {
            MUTANT.set(None);
        }
    }
    let _restore = Restore;
    MUTANT.set(Some((path.to_string(), text.replace(from, to))));
    f()
}

/// The linked shader, if the fault of this thread changes it.
pub fn linked(path: &str, features: &[&str], generated: &[(&str, &str)]) -> Result<Option<Linked>> {
    let Some((file, text)) = MUTANT.with_borrow(Clone::clone) else { return Ok(None) };
    let changed = [generated, &[(file.as_str(), text.as_str())]].concat();
    let mutant = link_with(path, features, &changed)?;
    let differs = mutant.text() != link_with(path, features, generated)?.text();
    Ok(differs.then_some(mutant))
}
