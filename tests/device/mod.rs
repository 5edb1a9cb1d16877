//! The device that integration tests share. Whoever includes this has `src/testing.rs` as its module `testing`.

use lucarne::gpu::Device;

/// The device, or a skip of `what`.
pub fn device(what: &str) -> Option<Device> {
    crate::testing::device(Device::shared(), what)
}
