//! The device that integration tests share.

use lucarne::gpu::Device;

/// The device, unless there is none, which is said; a failure where there must be one
/// (`LUCARNE_REQUIRE_GPU=1`).
pub fn device(what: &str) -> Option<Device> {
    match Device::shared() {
        Ok(device) => Some(device),
        Err(error) => {
            assert!(std::env::var_os("LUCARNE_REQUIRE_GPU").is_none_or(|v| v != "1"), "LUCARNE_REQUIRE_GPU=1, but {error}");
            eprintln!("SKIPPED {what}: {error}");
            None
        }
    }
}
