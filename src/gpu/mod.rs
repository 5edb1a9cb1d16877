//! Everything that touches the GPU device: choice of adapter, shader linking, pipelines, memory plans, readback.
