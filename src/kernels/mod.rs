//! One module per kernel: host half and f64 reference.
