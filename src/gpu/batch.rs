//! Commands to the device, recorded and handed over together.

use super::buffer::Buffer;
use super::device::Device;
use super::kernel::{BindGroup, Kernel};
use crate::error::{Error, Result};

/// Several dispatches and copies in one submission, run in order.
pub struct Batch<'a> {
    device: &'a Device,
    label: String,
    commands: Vec<Command>,
}

enum Command {
    Dispatch(Kernel, BindGroup, [u32; 3]),
    Copy(Buffer, Buffer),
    Clear(Buffer),
}

impl Batch<'_> {
    /// Adds a dispatch of `workgroups` (x, y, z); one of size 0 does nothing.
    ///
    /// # Errors
    /// More workgroups in a dimension than the device allows, or bindings of another kernel.
    pub(crate) fn dispatch(&mut self, kernel: &Kernel, bindings: &BindGroup, workgroups: [u32; 3]) -> Result<&mut Self> {
        let limit = self.device.limits().max_compute_workgroups_per_dimension;
        if workgroups.iter().any(|w| *w > limit) {
            return Err(Error::new(format!(
                "kernel '{}': {workgroups:?} workgroups; the device allows {limit} per dimension",
                kernel.label()
            ))
            .help("cut the work into several dispatches, or spread it over two dimensions with Device::grid"));
        }
        if kernel.label() != bindings.kernel() {
            return Err(Error::new(format!("kernel '{}' was given the bindings of '{}'", kernel.label(), bindings.kernel())));
        }
        if workgroups.iter().all(|w| *w > 0) {
            self.commands.push(Command::Dispatch(kernel.clone(), bindings.clone(), workgroups));
        }
        Ok(self)
    }

    /// Adds a copy of all of `from` to the beginning of `to`, another buffer. Sizes are multiples of
    /// 4 bytes.
    ///
    /// # Errors
    /// If `to` is smaller. Parts of one buffer are refused on submission.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer) -> Result<&mut Self> {
        if from.bytes() > to.bytes() {
            return Err(Error::new(format!(
                "'{}' ({} bytes) does not fit into '{}' ({})",
                from.label(),
                from.bytes(),
                to.label(),
                to.bytes()
            )));
        }
        self.commands.push(Command::Copy(from.clone(), to.clone()));
        Ok(self)
    }

    /// Adds filling a buffer with zeros.
    pub fn clear(&mut self, buffer: &Buffer) -> &mut Self {
        self.commands.push(Command::Clear(buffer.clone()));
        self
    }

    /// Hands everything to the device and returns at once.
    ///
    /// # Errors
    /// What the device finds wrong with the commands.
    pub fn submit(self) -> Result<()> {
        let device = self.device;
        device.guarded(&self.label, || {
            let mut encoder = device.raw().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(&self.label) });
            for command in &self.commands {
                match command {
                    Command::Dispatch(kernel, bindings, [x, y, z]) => {
                        let mut pass = encoder
                            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(kernel.label()), timestamp_writes: None });
                        pass.set_pipeline(kernel.pipeline());
                        pass.set_bind_group(0, bindings.raw(), &[]);
                        pass.dispatch_workgroups(*x, *y, *z);
                    }
                    Command::Copy(from, to) => {
                        let bytes = from.bytes().next_multiple_of(4);
                        encoder.copy_buffer_to_buffer(&from.raw, from.offset(), &to.raw, to.offset(), bytes);
                    }
                    Command::Clear(buffer) => encoder.clear_buffer(&buffer.raw, buffer.offset(), Some(buffer.bytes().next_multiple_of(4))),
                }
            }
            device.queue().submit([encoder.finish()]);
        })
    }
}

impl Device {
    /// Begins a batch of commands.
    pub fn batch(&self, label: &str) -> Batch<'_> {
        Batch { device: self, label: label.to_string(), commands: Vec::new() }
    }

    /// Submits one dispatch of `workgroups` (x, y, z) and returns at once.
    ///
    /// # Errors
    /// As [`Batch::dispatch`] and [`Batch::submit`].
    pub(crate) fn dispatch(&self, kernel: &Kernel, bindings: &BindGroup, workgroups: [u32; 3]) -> Result<()> {
        let mut batch = self.batch(kernel.label());
        batch.dispatch(kernel, bindings, workgroups)?;
        batch.submit()
    }

    /// A grid of at least `count` workgroups that respects the device's limit per dimension. The
    /// shader finds its number as `workgroup_id.y * num_workgroups.x + workgroup_id.x` and ignores
    /// numbers from `count` on.
    ///
    /// # Errors
    /// If not even two dimensions suffice.
    pub fn grid(&self, count: u64) -> Result<[u32; 3]> {
        let limit = u64::from(self.limits().max_compute_workgroups_per_dimension);
        let y = count.div_ceil(limit).max(1);
        let x = count.div_ceil(y);
        match (u32::try_from(x), u32::try_from(y)) {
            (Ok(x), Ok(y)) if u64::from(y) <= limit => Ok([x, y, 1]),
            _ => Err(Error::new(format!("{count} workgroups are too many for one dispatch")).help("cut the work into several dispatches")),
        }
    }
}
