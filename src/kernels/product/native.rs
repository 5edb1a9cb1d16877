//! Products on the processor.

use super::{Arrangement, Factor, Multiplier, Values, check_fit};
use crate::error::Result;
use crate::gpu::check_finite;
use rayon::prelude::*;
use std::borrow::Cow;

/// Multiplies on the processor's vector units, by the kernel of the crate `gemm`, on all cores.
#[derive(Debug, Clone, Copy, Default)]
pub struct Native;

/// Rows and columns of the blocks handed to `gemm`. Blocks begin at multiples of these numbers in
/// the whole product and never depend on the tiling, so each entry is always summed in the same way.
const BLOCK: usize = 512;

impl Multiplier for Native {
    fn description(&self) -> String {
        format!("native product on {} threads", rayon::current_num_threads())
    }

    fn left<'a>(&self, rows: usize, terms: usize, components: usize, values: Cow<'a, [f32]>) -> Result<Factor<'a>> {
        assert_eq!(values.len(), rows * terms * components);
        Ok(Factor { outer: rows, inner: terms, components, values: Values::Host(values) })
    }

    fn right<'a>(&self, terms: usize, columns: usize, components: usize, values: Cow<'a, [f32]>) -> Result<Factor<'a>> {
        assert_eq!(values.len(), terms * columns * components);
        Ok(Factor { outer: columns, inner: terms, components, values: Values::Host(values) })
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
        let (Values::Host(a), Values::Host(b)) = (&left.values, &right.values) else {
            panic!("the factors belong to another multiplier");
        };
        let (rows, terms, components) = (left.outer, left.inner, left.components);
        if terms == 0 || product.is_empty() {
            product.fill(0.0);
            return Ok(());
        }
        let (row_stride, column_stride) = match arrangement {
            Arrangement::Rows => (count * components, components),
            Arrangement::Columns => (components, rows * components),
        };
        let blocks = |len: usize| (0..len).step_by(BLOCK).map(move |start| (start, BLOCK.min(len - start)));
        let mut work = Vec::new();
        for (column, columns) in blocks(count) {
            for (row, rows) in blocks(rows) {
                work.extend((0..components).map(|component| (row, rows, column, columns, component)));
            }
        }
        let target = Target(product.as_mut_ptr());
        work.into_par_iter().for_each(|(row, rows, column, columns, component)| {
            let a = &a[row * terms * components + component..];
            let b = &b[(first + column) * components + component..];
            let strides = Strides {
                left: [terms * components, components],
                right: [right.outer * components, components],
                product: [row_stride, column_stride],
            };
            block(rows, columns, terms, a, b, &target, row * row_stride + column * column_stride + component, &strides);
        });
        check_finite(product, "product")
    }

    fn device_bytes(&self, _outer: usize, _inner: usize, _components: usize) -> u64 {
        0
    }
}

/// The product's memory, written by several threads at different places.
struct Target(*mut f32);

// SAFETY: every entry of the product belongs to exactly one block (row and column range and
// component), and only the thread of that block touches it.
#[allow(unsafe_code)]
unsafe impl Sync for Target {}

/// Distances between neighbours in a column and in a row.
pub(crate) struct Strides {
    /// Of the left factor.
    pub left: [usize; 2],
    /// Of the right factor.
    pub right: [usize; 2],
    /// Of the product.
    pub product: [usize; 2],
}

/// The product of `rows` × `terms` and `terms` × `columns` on this thread, into `product`. An entry
/// is summed in the same way whatever the rows and columns beside it, if there are at least two of
/// each.
///
/// # Panics
/// If a factor or the product does not hold all its entries.
pub(crate) fn product_on_this_thread([rows, terms, columns]: [usize; 3], a: &[f32], b: &[f32], product: &mut [f32], strides: &Strides) {
    if rows == 0 || columns == 0 {
        return;
    }
    assert!(terms > 0 && last(strides.product, rows, columns) < product.len(), "room for the product");
    block(rows, columns, terms, a, b, &Target(product.as_mut_ptr()), 0, strides);
}

/// Place of the last entry.
fn last([down, along]: [usize; 2], height: usize, width: usize) -> usize {
    (height - 1) * down + (width - 1) * along
}

#[allow(unsafe_code, clippy::too_many_arguments)]
fn block(rows: usize, columns: usize, terms: usize, a: &[f32], b: &[f32], target: &Target, offset: usize, strides: &Strides) {
    assert!(last(strides.left, rows, terms) < a.len() && last(strides.right, terms, columns) < b.len());
    // Strides of slices in memory fit an isize.
    let signed = |s: usize| s as isize;
    let [m, k, n] = [rows, terms, columns];
    let (a, b) = ((a.as_ptr(), strides.left.map(signed)), (b.as_ptr(), strides.right.map(signed)));
    let [down, along] = strides.product.map(signed);
    // The kernel fills columns: where rows are denser it computes the transpose, (B^T A^T)^T.
    let ([m, n], [down, along], (a, [a_down, a_along]), (b, [b_down, b_along])) = if along < down {
        let turned = |(from, [down, along]): (*const f32, [isize; 2])| (from, [along, down]);
        ([n, m], [along, down], turned(b), turned(a))
    } else {
        ([m, n], [down, along], a, b)
    };
    // SAFETY: the assertion above bounds every read; writes stay inside the product, since `multiply`
    // checked its length and blocks are cut from its rows and columns; blocks do not overlap.
    unsafe {
        let (product, alone) = (target.0.add(offset), gemm_common::Parallelism::None);
        let multiply = gemm_f32::gemm::f32::get_gemm_fn();
        multiply(m, n, k, product, along, down, false, a, a_along, a_down, b, b_along, b_down, 0.0, 1.0, false, false, false, alone);
    }
}
