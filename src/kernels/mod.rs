//! One module per kernel: host half and f64 reference.

/// Every shader variant in use, for the tests that link, validate and compare layouts.
pub fn registered() -> Vec<crate::gpu::Registered> {
    let mut all = crate::gpu::registered();
    all.extend([]);
    all
}
