//! Viewer for Lucarne's results.
fn main() {}
