//! Products on the GPU.

use super::pack::{INNER_MULTIPLE, OUTER_MULTIPLE, PACK, Packed, Packer};
use super::{Arrangement, Factor, Multiplier, Values, check_fit, lanes};
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Chunk, Device, DeviceKind, Kernel, Shader, check_finite};
use rayon::prelude::*;
use std::borrow::Cow;

crate::gpu_struct! {
    /// Parameters of the product kernels; see `shared/gemm.wgsl`. All but the first count quads.
    pub(crate) struct GemmParams {
        /// Terms of each sum, padded with zeros to a multiple of 8.
        pub inner: u32,
        /// First column of the tile in the right factor.
        pub first_column: u32,
        /// Distance between terms in the left factor.
        pub left_stride: u32,
        /// Distance between terms in the right factor.
        pub right_stride: u32,
        /// Distance between components in the left factor.
        pub left_plane: u32,
        /// Distance between components in the right factor.
        pub right_plane: u32,
        /// Distance between rows (or columns) of the tile.
        pub stride: u32,
        /// Distance between components of the tile.
        pub plane: u32,
    }
}

crate::gpu_constants! {
    const NUMBERS = {
        /// Entries per side of a workgroup's tile in `product/gemm_tiled`.
        const TILE: u32 = 128;
    }
}

const GEMM_TILED: Shader = Shader::new("product/gemm_tiled", &[NUMBERS, &[GemmParams::DECLARED]]);
/// By the subgroup sizes of software devices; with more lanes a tile's sums would not fit any registers.
const GEMM_SUBGROUP: [(u32, Shader); 3] = [
    (4, Shader::new("product/gemm_subgroup", &[lanes::FOUR, &[GemmParams::DECLARED]])),
    (8, Shader::new("product/gemm_subgroup", &[lanes::EIGHT, &[GemmParams::DECLARED]])),
    (16, Shader::new("product/gemm_subgroup", &[lanes::SIXTEEN, &[GemmParams::DECLARED]])),
];

pub(super) fn registered() -> Vec<Shader> {
    [PACK, GEMM_TILED].into_iter().chain(GEMM_SUBGROUP.map(|(_, shader)| shader)).collect()
}

/// The shader for the device's subgroups and their size, if it is fixed and there is one.
fn subgroup_shader(device: &Device) -> Option<(u32, Shader)> {
    GEMM_SUBGROUP.into_iter().find(|(lanes, _)| device.subgroup_size() == Some(*lanes))
}

/// Which kernel multiplies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceKernel {
    /// `product/gemm_subgroup`: registers and broadcasts; the fastest on software devices.
    Subgroup,
    /// `product/gemm_tiled`: workgroup memory; runs everywhere, made for graphics cards.
    Tiled,
}

/// Multiplies on a GPU device.
pub struct OnDevice {
    device: Device,
    packer: Packer,
    /// For [`Arrangement::Rows`] and [`Arrangement::Columns`].
    gemm: [Kernel; 2],
    /// Rows and columns of a workgroup's tile.
    workgroup: [u32; 2],
    name: &'static str,
    /// Largest tile of a product, bytes.
    tile_bytes: u64,
}

/// A tile of a product that stays on the device, of one component: `[column][row]` with padding.
pub(crate) struct TileOnDevice {
    /// Rows of the product that it has.
    pub rows: Chunk,
    /// Columns.
    pub columns: Chunk,
    /// Values.
    pub values: Buffer,
    /// Distance between columns.
    pub stride: usize,
}

/// A tile of a product as the device left it: `[component][slow][fast]` with padding.
struct Tile {
    values: Vec<f32>,
    stride: usize,
    plane: usize,
}

impl OnDevice {
    /// The multiplier with the kernel that suits the device.
    ///
    /// # Errors
    /// Refusal by the driver.
    pub fn new(device: &Device) -> Result<Self> {
        let software = device.summary().kind == DeviceKind::Cpu;
        let kernel = if software && subgroup_shader(device).is_some() { DeviceKernel::Subgroup } else { DeviceKernel::Tiled };
        Self::with_kernel(device, kernel)
    }

    /// The multiplier with a chosen kernel.
    ///
    /// # Errors
    /// A device without a fixed subgroup size for [`DeviceKernel::Subgroup`]; refusal by the driver.
    pub fn with_kernel(device: &Device, kernel: DeviceKernel) -> Result<Self> {
        let (shader, workgroup, name) = match kernel {
            DeviceKernel::Tiled => (GEMM_TILED, [TILE, TILE], "tiled"),
            DeviceKernel::Subgroup => {
                let (lanes, shader) = subgroup_shader(device).ok_or_else(|| {
                    let sizes = GEMM_SUBGROUP.map(|(lanes, _)| lanes);
                    Error::new(format!("'{}' has no fixed subgroup size among {sizes:?}", device.summary().name))
                })?;
                (shader, [lanes::rows(lanes), lanes::columns(lanes)], "subgroup")
            }
        };
        let packer = Packer::new(device)?;
        let gemm = [Kernel::new(device, &shader, &[("COLUMNS", 0.0)])?, Kernel::new(device, &shader, &[("COLUMNS", 1.0)])?];
        let limits = device.limits();
        let tile_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(1 << 30);
        Ok(Self { device: device.clone(), packer, gemm, workgroup, name, tile_bytes })
    }

    /// The same with tiles of a product of at most this many bytes.
    #[cfg(test)]
    pub(crate) fn tiles_of(self, bytes: u64) -> Self {
        Self { tile_bytes: self.tile_bytes.min(bytes), ..self }
    }

    /// Multiplies one part of each factor; `columns` counts from the right part's beginning and
    /// begins at a multiple of 4.
    fn tile(
        &self,
        left: &Packed,
        right: &Packed,
        inner: usize,
        components: usize,
        columns: Chunk,
        arrangement: Arrangement,
    ) -> Result<Tile> {
        let (product, stride, plane) = self.tile_on_device(left, right, inner, components, columns, arrangement)?;
        Ok(Tile { values: self.device.read::<f32>(&product)?, stride, plane })
    }

    /// As [`tile`](Self::tile), left on the device, with its stride and plane.
    fn tile_on_device(
        &self,
        left: &Packed,
        right: &Packed,
        inner: usize,
        components: usize,
        columns: Chunk,
        arrangement: Arrangement,
    ) -> Result<(Buffer, usize, usize)> {
        let padded = |len: usize| len.next_multiple_of(OUTER_MULTIPLE);
        let (rows, wide) = (padded(left.chunk.count), padded(columns.count));
        let (kernel, stride) = match arrangement {
            Arrangement::Rows => (&self.gemm[0], wide),
            Arrangement::Columns => (&self.gemm[1], rows),
        };
        let plane = rows * wide;
        let product = self.device.zeros::<f32>("product", plane * components)?;
        let quads = |values: usize| (values / 4) as u32;
        let params = GemmParams {
            inner: inner.next_multiple_of(INNER_MULTIPLE) as u32,
            first_column: quads(columns.first),
            left_stride: quads(left.stride),
            right_stride: quads(right.stride),
            left_plane: quads(left.plane),
            right_plane: quads(right.plane),
            stride: quads(stride),
            plane: quads(plane),
        };
        let params = self.device.uniform("product parameters", &params)?;
        let bindings = kernel.bind(&[("params", &params), ("left", &left.planes), ("right", &right.planes), ("product", &product)])?;
        let [down, along] = self.workgroup;
        self.device.dispatch(kernel, &bindings, [(wide as u32).div_ceil(along), (rows as u32).div_ceil(down), components as u32])?;
        Ok((product, stride, plane))
    }

    /// The whole product of factors with one component, tile by tile: for the same rows all columns
    /// in their order, then the next rows. `take` may change the tile.
    ///
    /// # Errors
    /// Failures of the device, and those of `take`.
    ///
    /// # Panics
    /// If the factors do not fit each other or were made by another multiplier.
    pub(crate) fn for_each_tile(&self, left: &Factor, right: &Factor, take: &mut dyn FnMut(TileOnDevice) -> Result<()>) -> Result<()> {
        assert_eq!((left.inner, left.components, right.components), (right.inner, 1, 1));
        let (Values::Device(a), Values::Device(b)) = (&left.values, &right.values) else {
            panic!("the factors belong to another multiplier");
        };
        self.check_terms(left.inner)?;
        for a in a {
            let widest = self.widest_tile(a, 1);
            for b in b {
                for first in (0..b.chunk.count).step_by(widest) {
                    let columns = Chunk { first, count: widest.min(b.chunk.count - first) };
                    let (values, stride, _) = self.tile_on_device(a, b, left.inner, 1, columns, Arrangement::Columns)?;
                    let columns = Chunk { first: b.chunk.first + first, count: columns.count };
                    take(TileOnDevice { rows: a.chunk, columns, values, stride })?;
                }
            }
        }
        Ok(())
    }

    /// Columns of a tile at most, a multiple of the padding.
    fn widest_tile(&self, left: &Packed, components: usize) -> usize {
        let bytes_per_column = (left.chunk.count.next_multiple_of(OUTER_MULTIPLE) * components * size_of::<f32>()) as u64;
        ((self.tile_bytes / bytes_per_column.max(1)) as usize / OUTER_MULTIPLE * OUTER_MULTIPLE).max(OUTER_MULTIPLE)
    }

    /// Some drivers cut long loops short.
    fn check_terms(&self, terms: usize) -> Result<()> {
        match self.device.loop_limit()? {
            Some(limit) if terms.next_multiple_of(INNER_MULTIPLE) * 2 > limit as usize => {
                Err(Error::device(format!("sums of {terms} terms are too long for '{}'", self.device.summary().name))
                    .help("use --device native"))
            }
            _ => Ok(()),
        }
    }
}

impl Multiplier for OnDevice {
    fn description(&self) -> String {
        let summary = self.device.summary();
        format!("{} kernel on {} ({})", self.name, summary.name, summary.backend)
    }

    fn left<'a>(&self, rows: usize, terms: usize, components: usize, values: Cow<'a, [f32]>) -> Result<Factor<'a>> {
        assert_eq!(values.len(), rows * terms * components);
        let parts = self.packer.pack(rows, terms, components, &values, true)?;
        Ok(Factor { outer: rows, inner: terms, components, values: Values::Device(parts) })
    }

    fn right<'a>(&self, terms: usize, columns: usize, components: usize, values: Cow<'a, [f32]>) -> Result<Factor<'a>> {
        assert_eq!(values.len(), terms * columns * components);
        let parts = self.packer.pack(columns, terms, components, &values, false)?;
        Ok(Factor { outer: columns, inner: terms, components, values: Values::Device(parts) })
    }

    fn multiply(
        &self,
        left: &Factor,
        right: &Factor,
        first: usize,
        count: usize,
        arrangement: Arrangement,
        product: &mut [f32],
    ) -> Result<()> {
        check_fit(left, right, first, count, product);
        let (Values::Device(a), Values::Device(b)) = (&left.values, &right.values) else {
            panic!("the factors belong to another multiplier");
        };
        let (rows, components) = (left.outer, left.components);
        self.check_terms(left.inner)?;
        for a in a {
            // A tile starts at a multiple of 4 columns and is padded to whole workgroups.
            let widest = self.widest_tile(a, components);
            for b in b {
                // The wanted columns that lie in this part, counted from its beginning.
                let to = (first + count).saturating_sub(b.chunk.first).min(b.chunk.count);
                let mut at = first.saturating_sub(b.chunk.first);
                while at < to {
                    let start = at / 4 * 4;
                    let end = (start + widest).min(to);
                    let columns = Chunk { first: start, count: end - start };
                    let tile = self.tile(a, b, left.inner, components, columns, arrangement)?;
                    let wanted = Chunk { first: at - start, count: end - at };
                    tile.scatter(a.chunk, wanted, components, b.chunk.first + at - first, [rows, count], arrangement, product);
                    at = end;
                }
            }
        }
        check_finite(product, "product")
    }

    fn device_bytes(&self, outer: usize, inner: usize, components: usize) -> u64 {
        (outer.next_multiple_of(OUTER_MULTIPLE) * inner.next_multiple_of(INNER_MULTIPLE) * components * size_of::<f32>()) as u64
    }
}

impl Tile {
    /// Copies the `wanted` columns of this tile of `rows` to column `at` of the whole product, of
    /// the given height and width, and interleaves the components.
    #[allow(clippy::too_many_arguments, reason = "one call, all places in three arrays")]
    fn scatter(
        &self,
        rows: Chunk,
        wanted: Chunk,
        components: usize,
        at: usize,
        [height, width]: [usize; 2],
        arrangement: Arrangement,
        product: &mut [f32],
    ) {
        // Lines of the product (rows or columns), the stretch of each that this tile fills, and
        // where the tile has it.
        let (line, first_line, lines, from, len, skip_lines, skip) = match arrangement {
            Arrangement::Rows => (width, rows.first, rows.count, at, wanted.count, 0, wanted.first),
            Arrangement::Columns => (height, at, wanted.count, rows.first, rows.count, wanted.first, 0),
        };
        let target = &mut product[first_line * line * components..(first_line + lines) * line * components];
        target.par_chunks_exact_mut(line * components).enumerate().for_each(|(i, target)| {
            let start = (skip_lines + i) * self.stride + skip;
            let planes: Vec<&[f32]> = (0..components).map(|c| &self.values[c * self.plane + start..][..len]).collect();
            let target = &mut target[from * components..(from + len) * components];
            if let [red, green, blue] = planes[..] {
                for (pixel, ((r, g), b)) in target.chunks_exact_mut(3).zip(red.iter().zip(green).zip(blue)) {
                    pixel.copy_from_slice(&[*r, *g, *b]);
                }
            } else {
                for (component, plane) in planes.into_iter().enumerate() {
                    for (entry, value) in target.chunks_exact_mut(components).zip(plane) {
                        entry[component] = *value;
                    }
                }
            }
        });
    }
}
