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

/// Triangles of a scene that copies and generators make: a short line asks for them, where files bring their own. They
/// take some hundred bytes each until the scene is read.
pub(crate) const MADE_TRIANGLES: usize = 1 << 20;

/// Surfaces in a file of windows.
pub(crate) const WINDOW_SURFACES: usize = 1 << 17;

/// Pairs of a window's part and a part of a surface, or of another window, that are looked at for whether one covers the
/// other: a minute or two of work.
pub(crate) const COVERING_PAIRS: usize = 1 << 32;

/// Nodes and instances of a glTF scene, each counted as often as it appears.
pub(crate) const NODES: usize = 1 << 20;

/// Bytes of a Honeybee model: read, it takes some seven times as much memory.
pub(crate) const MODEL_BYTES: u64 = 256 << 20;

/// Vertices of a glTF scene, each counted as often as it appears.
pub(crate) const VERTICES: usize = 3 * TRIANGLES;

/// Elements of a glTF accessor that has no data of its own.
pub(crate) const EMPTY_ELEMENTS: usize = 1 << 22;

/// Characters of a number in a BSDF file.
pub(crate) const NUMBER_CHARACTERS: usize = 64;

/// Nesting of a tensor tree: cells of 1/65536 per side.
pub(crate) const TREE_DEPTH: usize = 16;

/// Numbers of a tensor tree: 512 MiB of them, a full rank 4 grid of 2^6 per side eight times over.
pub(crate) const TREE_VALUES: usize = 1 << 27;

/// Bytes of a tag, comment or processing instruction of an XML file.
pub(crate) const XML_MARKUP: usize = 1 << 20;

/// Bytes of text before its first element (`Recover using: …` of genBSDF).
pub(crate) const XML_JUNK: usize = 1 << 20;

/// Bytes of a file of spectral data.
pub(crate) const GLASS_BYTES: u64 = 16 << 20;

/// Most bins of a basis that a file defines.
pub(crate) const BASIS_BINS: usize = 1 << 14;

/// Nesting of its elements; real files have 9 levels.
pub(crate) const NESTED_ELEMENTS: usize = 64;

/// Longest text of an element other than data and geometry.
pub(crate) const XML_TEXT: usize = 1 << 16;

/// Bytes of the geometry in a BSDF file that are kept.
pub(crate) const BSDF_GEOMETRY: usize = 64 << 20;

/// Most values of a matrix, when the bases are not known before the values: 2048 × 2048.
pub(crate) const BSDF_VALUES: usize = 1 << 22;

/// Most properties of the material that are kept.
pub(crate) const BSDF_PROPERTIES: usize = 64;

/// Files of a folder of measurements.
pub(crate) const GONIOPHOTOMETER_FILES: usize = 2000;

/// Bytes of one of them.
pub(crate) const GONIOPHOTOMETER_BYTES: u64 = 64 << 20;

/// Different directions, over all incident ones, of a measurement that is fitted: below 1 GiB of sums.
pub(crate) const GONIOPHOTOMETER_CELLS: usize = 1 << 24;

/// Characters of a line of a measurement.
pub(crate) const SCAN_LINE: usize = 1 << 12;

/// Lobes of all incident directions of an interpolant that is read.
pub(crate) const INTERPOLANT_LOBES: usize = 1 << 23;

/// Parts of a formula in a scene: keeps what walks through it off the end of the stack.
pub(crate) const EXPRESSION_PARTS: usize = 400;

/// Steps of its evaluation.
pub(crate) const EXPRESSION_STEPS: usize = 1 << 20;

/// Pixels of a picture; more are taken for a damaged resolution line (2²⁸: 16384 × 16384).
pub(crate) const PIXELS: usize = 1 << 28;

/// Pixels of an EXR picture for each byte of its file, which no compression exceeds: deflate packs at most 1032 bytes
/// into one, and a pixel has two or more.
pub(crate) const EXR_PIXELS_PER_BYTE: u64 = 516;

/// Bytes added to the file's before that, for the smallest pictures.
pub(crate) const EXR_HEADROOM: u64 = 1 << 10;

/// Bytes of the header of a picture; a binary file without line ends stops here.
pub(crate) const PICTURE_HEADER: usize = 1 << 20;

/// Bytes of the header of a matrix: rcontrib repeats its whole command line, so lines can be long.
pub(crate) const MATRIX_HEADER: u64 = 16 << 20;

/// Pixels along one side of a picture.
pub(crate) const PICTURE_SIDE: usize = 1 << 16;

/// The error of a limit: `what` ("the scene has", "this xform makes") more than `limit` of `unit`.
pub(crate) fn exceeded(what: &str, limit: usize, unit: &str) -> Error {
    Error::new(format!("{what} more than {limit} {unit}"))
}
