//! How much a file may ask for. A few bytes can ask for a year of work or all of the memory; each
//! limit here lies far above what real files need, and ends in one error that [`exceeded`] makes.

use crate::error::Error;

/// Files of a scene inside each other (`!xform` in files that `!xform` names).
pub(crate) const NESTED_FILES: usize = 64;

/// Patterns, mixtures and materials that modify each other.
pub(crate) const NESTED_MODIFIERS: usize = 256;

/// Sensors that are spread over one plane.
pub(crate) const GRID_POINTS: usize = 1 << 20;

/// Nodes of a glTF file inside each other.
pub(crate) const NESTED_NODES: usize = 128;

/// Copies that all `xform`s of a scene make together, each copy of a file or generator counted
/// where it stands; also repetitions of one `-a` or `-i`.
pub(crate) const COPIES: usize = 1 << 21;

/// Stages of one pipeline (`!genbox … | xform … | xform …`).
pub(crate) const PIPED_COMMANDS: usize = 64;

/// Surfaces that one `genblinds` makes.
pub(crate) const GENERATED_SURFACES: usize = 1 << 20;

/// Statements of a scene, after arrays and repeated files are expanded.
pub(crate) const STATEMENTS: usize = 50_000_000;

/// Triangles of a scene; more would not fit the memory of usual machines and devices.
pub(crate) const TRIANGLES: usize = 50_000_000;

/// Surfaces in a file of windows.
pub(crate) const WINDOW_SURFACES: usize = 1 << 17;

/// Pairs of a window's part and a part of a surface, or of another window, that are looked at for whether one covers the
/// other: a minute or two of work.
pub(crate) const COVERING_PAIRS: usize = 1 << 32;

/// Nodes and instances of a glTF scene, each counted as often as it appears.
pub(crate) const NODES: usize = 1 << 20;

/// Vertices of a glTF scene, each counted as often as it appears.
pub(crate) const VERTICES: usize = 3 * TRIANGLES;

/// Elements of a glTF accessor that has no data of its own.
pub(crate) const EMPTY_ELEMENTS: usize = 1 << 22;

/// The error of a limit: `what` ("the scene has", "this xform makes") more than `limit` of `unit`.
pub(crate) fn exceeded(what: &str, limit: usize, unit: &str) -> Error {
    Error::new(format!("{what} more than {limit} {unit}"))
}
