//! The device that integration tests share.

use lucarne::gpu::Device;

#[path = "../../src/testing.rs"]
mod testing;

/// The device, or a skip of `what`.
pub fn device(what: &str) -> Option<Device> {
    testing::device(Device::shared(), what)
}
