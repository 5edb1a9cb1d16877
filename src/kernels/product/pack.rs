//! Factors of a product on the GPU: cut into parts that it can bind, one plane per component.

use crate::error::{Error, Result};
use crate::gpu::{Buffer, Chunk, Device, Kernel, Plan, Shader};
use std::borrow::Cow;

crate::gpu_struct! {
    /// Parameters of `product/pack`.
    pub(crate) struct PackParams {
        /// Rows of the matrix.
        pub rows: u32,
        /// Columns of the matrix.
        pub columns: u32,
        /// Values per entry.
        pub components: u32,
        /// Distance in the plane between neighbours in a column.
        pub row_stride: u32,
        /// Distance in the plane between neighbours in a row.
        pub column_stride: u32,
        /// Distance between planes.
        pub plane: u32,
    }
}

/// Factors are padded with zeros to these multiples, rows and columns to whole tiles of either
/// kernel, terms to the depth of a tile.
pub(super) const OUTER_MULTIPLE: usize = 128;
pub(super) const INNER_MULTIPLE: usize = 8;

crate::gpu_constants! {
    const NUMBERS = {
        /// Invocations per workgroup of `product/pack`.
        const PACK_WORKGROUP: u32 = 64;
    }
}

pub(super) const PACK: Shader = Shader::new("product/pack", &[NUMBERS, &[PackParams::DECLARED]]);

/// A part of a factor on the device: one plane `[term][outer]` per component, padded with zeros.
pub(super) struct Packed {
    pub chunk: Chunk,
    pub stride: usize,
    pub plane: usize,
    pub planes: Buffer,
}

/// Packs factors (`product/pack`).
pub(super) struct Packer {
    device: Device,
    kernel: Kernel,
}

impl Packer {
    /// The packer of a device.
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self { device: device.clone(), kernel: Kernel::new(device, &PACK, &[])? })
    }

    /// Cuts a factor into parts that the device can bind, and packs each.
    pub(crate) fn pack(&self, outer: usize, inner: usize, components: usize, values: &[f32], left: bool) -> Result<Vec<Packed>> {
        let padded_inner = inner.next_multiple_of(INNER_MULTIPLE);
        // The narrowest tile of the product has `OUTER_MULTIPLE` columns and must be bound as well.
        let bytes = (padded_inner.max(OUTER_MULTIPLE) * components * size_of::<f32>()) as u64;
        // Room for the padding of the last part.
        let binding = self.device.limits().max_storage_buffer_binding_size.min(self.device.limits().max_buffer_size);
        let reserve = bytes * OUTER_MULTIPLE as u64;
        if reserve >= binding {
            return Err(Error::new(format!("{inner} terms per entry are too many for '{}'", self.device.summary().name)));
        }
        let plan = Plan::within(binding - reserve, u64::MAX, outer, &[bytes], &[], OUTER_MULTIPLE)?;
        plan.chunks().map(|chunk| self.pack_part(chunk, outer, inner, components, values, left)).collect()
    }

    fn pack_part(&self, chunk: Chunk, outer: usize, inner: usize, components: usize, values: &[f32], left: bool) -> Result<Packed> {
        let stride = chunk.count.next_multiple_of(OUTER_MULTIPLE);
        let plane = stride * inner.next_multiple_of(INNER_MULTIPLE);
        // A tile that begins inside may read up to one padding beyond the last term.
        let planes = self.device.zeros::<f32>(if left { "left factor" } else { "right factor" }, plane * components + OUTER_MULTIPLE)?;
        let packed = Packed { chunk, stride, plane, planes };
        if chunk.count == 0 || inner == 0 {
            return Ok(packed);
        }
        let (rows, columns) = if left { (chunk.count, inner) } else { (inner, chunk.count) };
        let part: Cow<[f32]> = if left {
            let row = inner * components;
            Cow::Borrowed(&values[chunk.first * row..(chunk.first + chunk.count) * row])
        } else if chunk.count == outer {
            Cow::Borrowed(values)
        } else {
            let rows = values.chunks_exact(outer * components);
            rows.flat_map(|r| &r[chunk.first * components..(chunk.first + chunk.count) * components]).copied().collect()
        };
        let interleaved = self.device.upload("factor as it came", &part)?;
        let params = PackParams {
            rows: rows as u32,
            columns: columns as u32,
            components: components as u32,
            row_stride: if left { 1 } else { stride as u32 },
            column_stride: if left { stride as u32 } else { 1 },
            plane: plane as u32,
        };
        let params = self.device.uniform("pack parameters", &params)?;
        let bindings = self.kernel.bind(&[("params", &params), ("interleaved", &interleaved), ("planes", &packed.planes)])?;
        let grid = self.device.grid(((rows * columns) as u64).div_ceil(u64::from(PACK_WORKGROUP)))?;
        self.device.dispatch(&self.kernel, &bindings, grid)?;
        Ok(packed)
    }
}
