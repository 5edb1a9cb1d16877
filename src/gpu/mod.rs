//! Everything that touches the GPU device: choice of adapter, shader linking, pipelines, memory
//! plans, readback. Knows nothing of daylight.
//!
//! ```text
//! shaders/**/*.wgsl ──sources──▶ link (imports, @if) ──▶ Kernel (naga reflection, pipeline)
//!                                                          │ bind by name
//! Device::open ──▶ upload / zeros ──▶ Buffer ──────────────┴──▶ dispatch / Batch ──▶ read
//! ```
//!
//! Rules kept here, so that kernels need not think of them: every object has a label, every object
//! is created under an error scope, sizes are checked against the device's limits beforehand,
//! nothing panics on a user's machine, and bindings are found by their WGSL names.

mod buffer;
mod canary;
mod conditional;
mod device;
mod kernel;
mod layout;
mod link;
mod memory;
#[cfg(test)]
pub(crate) mod mutation;
mod sources;

#[doc(hidden)]
pub use bytemuck;

pub(crate) use buffer::check_finite;
pub use buffer::{Buffer, Finite};
pub use device::{AdapterSummary, Device, DeviceKind, NO_DEVICE_HELP, list};
pub use kernel::{Batch, BindGroup, Kernel};
pub use layout::{Field, GpuStruct, Registered, StructLayout};
pub use link::{Linked, link, link_with};
pub use memory::{Chunk, Plan};
pub use sources::{SOURCES, source};

/// Kernels of this module, for the tests that link, validate and lay out every shader.
pub fn registered() -> Vec<Registered> {
    vec![Registered::new("diagnostic/loop_limit").with::<canary::LoopLimitParams>()]
}
