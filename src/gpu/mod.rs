//! Everything that touches the GPU device: choice of adapter, shader linking, pipelines, memory
//! plans, readback. Knows nothing of daylight.
//!
//! ```text
//! shaders/**/*.wgsl ──sources──▶ link (imports) ──▶ Kernel (naga reflection, pipeline)
//!                                                          │ bind by name
//! Device::open ──▶ upload / zeros ──▶ Buffer ──────────────┴──▶ dispatch / Batch ──▶ read
//! ```
//!
//! Rules kept here, so that kernels need not think of them: every object has a label, every object
//! is created under an error scope, sizes are checked against the device's limits beforehand,
//! nothing panics on a user's machine, and bindings are found by their WGSL names.

mod batch;
mod buffer;
mod canary;
mod device;
mod kernel;
mod link;
mod memory;
#[cfg(test)]
pub(crate) mod mutation;
mod shader;
mod sources;

#[doc(hidden)]
pub use bytemuck;

pub use batch::Batch;
pub use buffer::Buffer;
pub(crate) use buffer::check_finite;
pub use device::{AdapterSummary, Device, DeviceKind, NO_DEVICE_HELP, list};
pub(crate) use kernel::{BindGroup, Kernel};
pub use link::{Linked, link};
pub use memory::Plan;
pub use memory::{Chunk, allow_memory, available};
pub(crate) use memory::{DEFAULT_MEMORY, allowed};
pub use shader::{Declared, Member, Number, Shader};
#[doc(hidden)]
pub use shader::{Layout, wgsl_constant, wgsl_of_words, wgsl_struct};
pub use sources::{SOURCES, source};

/// Shaders of this module, for the test that links and validates every shader.
pub fn registered() -> Vec<Shader> {
    vec![canary::LOOP_LIMIT]
}
