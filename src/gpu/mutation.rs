//! For tests of tests: a shader with a fault put in on purpose.

use super::link::{Linked, link, link_from};
use super::shader::{GENERATED, Shader};
use super::sources;
use crate::error::Result;
use std::cell::RefCell;

/// What is replaced in a file.
#[derive(Clone)]
struct Fault {
    path: String,
    from: String,
    to: String,
}

thread_local! {
    static FAULT: RefCell<Option<Fault>> = const { RefCell::new(None) };
}

/// Runs `f` with `from` replaced by `to` in the shader file `path`, or in what is `generated`, for
/// kernels made by this thread.
///
/// # Panics
/// Unless `from` occurs in the file exactly once: a mutation must not outlive what it changes.
pub fn with<R>(path: &str, from: &str, to: &str, f: impl FnOnce() -> R) -> R {
    if path != GENERATED {
        let text = sources::source(path).unwrap_or_else(|| panic!("there is no shader {path}"));
        assert_eq!(text.matches(from).count(), 1, "shaders/{path}.wgsl holds '{from}'");
    }
    struct Restore;
    impl Drop for Restore {
        fn drop(&mut self) {
            FAULT.set(None);
        }
    }
    let _restore = Restore;
    FAULT.set(Some(Fault { path: path.to_string(), from: from.to_string(), to: to.to_string() }));
    f()
}

/// The linked shader, if the fault of this thread changes it.
pub fn linked(shader: &Shader) -> Result<Option<Linked>> {
    let Some(Fault { path, from, to }) = FAULT.with_borrow(Clone::clone) else { return Ok(None) };
    let mutant = link_from(shader.path(), &|file| {
        let text = shader.file(file)?;
        Some(if file == path { text.replace(&from, &to).into() } else { text })
    })?;
    let differs = mutant.text() != link(shader)?.text();
    Ok(differs.then_some(mutant))
}
