//! Products of matrices with interleaved components, `C[row][column] = Σ A[row][term] · B[term][column]`
//! for each component: the phases V·(T·(D·S)) and the pictures of many hours.
//!
//! Two ways behind one trait, [`Multiplier`]: [`Native`] on the processor (crate `gemm`) and
//! [`OnDevice`] on the GPU. Both sum the terms of an entry in an order that does not depend on the
//! tiling, so results are identical bit by bit for any tile size on the same machine. Accuracy:
//! |ĉ − c| ≤ γ_k Σ|a||b| with γ_k = k·u / (1 − k·u), u = 2⁻²⁴ (Higham 2002, section 3.5), which
//! the tests check against the f64 [`reference`](mod@reference).

mod device;
mod lanes;
mod native;
mod pack;
pub mod reference;

pub(crate) use device::TileOnDevice;
pub use device::{DeviceKernel, OnDevice};
pub use native::Native;
pub(crate) use native::{Strides, product_on_this_thread};

use crate::error::{Error, Result};
use crate::gpu::{Device, DeviceKind, Shader};
use crate::matrix::Matrix;
use std::borrow::Cow;

/// Shader variants of this module.
pub fn registered() -> Vec<Shader> {
    device::registered()
}

/// How the entries of a product are arranged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// `[row][column][component]`, as in a [`Matrix`].
    Rows,
    /// `[column][row][component]`: with pixels as rows and hours as columns, one whole picture
    /// after the other.
    Columns,
}

/// A factor made ready by a [`Multiplier`].
pub struct Factor<'a> {
    outer: usize,
    inner: usize,
    components: usize,
    values: Values<'a>,
}

enum Values<'a> {
    Host(Cow<'a, [f32]>),
    Device(Vec<pack::Packed>),
}

impl Factor<'_> {
    /// Rows of a left factor, columns of a right one.
    pub fn outer(&self) -> usize {
        self.outer
    }

    /// Columns of a left factor, rows of a right one: the number of terms.
    pub fn inner(&self) -> usize {
        self.inner
    }

    /// Values per entry.
    pub fn components(&self) -> usize {
        self.components
    }
}

/// Multiplies matrices.
pub trait Multiplier: Send + Sync {
    /// What does the work, for messages and summaries.
    fn description(&self) -> String;

    /// Makes a left factor ready: `values[row][term][component]`.
    ///
    /// # Errors
    /// Memory and other failures of a device.
    fn left<'a>(&self, rows: usize, terms: usize, components: usize, values: Cow<'a, [f32]>) -> Result<Factor<'a>>;

    /// Makes a right factor ready: `values[term][column][component]`.
    ///
    /// # Errors
    /// Memory and other failures of a device.
    fn right<'a>(&self, terms: usize, columns: usize, components: usize, values: Cow<'a, [f32]>) -> Result<Factor<'a>>;

    /// The product of all rows of `left` with the columns of `right` from `first` up to `first +
    /// count`, into `product`, whose former values are overwritten.
    ///
    /// # Errors
    /// Failures of a device.
    ///
    /// # Panics
    /// If the factors do not fit each other, were made by another multiplier, or `product` has not
    /// `rows · count · components` values.
    fn multiply(
        &self,
        left: &Factor,
        right: &Factor,
        first: usize,
        count: usize,
        arrangement: Arrangement,
        product: &mut [f32],
    ) -> Result<()>;

    /// Bytes of device memory that a factor of this size occupies, beyond the host's copy.
    fn device_bytes(&self, outer: usize, inner: usize, components: usize) -> u64;
}

fn check_fit(left: &Factor, right: &Factor, first: usize, count: usize, product: &[f32]) {
    assert_eq!(left.inner, right.inner, "the factors have different numbers of terms");
    assert_eq!(left.components, right.components, "the factors have different components");
    assert!(first + count <= right.outer, "columns {first}…{} of {}", first + count, right.outer);
    assert_eq!(product.len(), left.outer * count * left.components, "room for the product");
}

/// The multiplier for this machine. A `choice` (the option `--device`) is honoured: `native` means
/// the processor without a GPU interface, anything else chooses a device as [`Device::open`].
/// Without a choice it is the device, unless that is software on the CPU or absent: there the native
/// product is several times as fast as the fastest kernel (see the benchmark `product`).
///
/// # Errors
/// As [`Device::open`], if there is a choice.
pub fn choose(choice: Option<&str>) -> Result<Box<dyn Multiplier>> {
    let environment = std::env::var("LUCARNE_DEVICE").ok().filter(|c| !c.trim().is_empty());
    match choice.map(str::to_string).or(environment) {
        Some(choice) if choice.eq_ignore_ascii_case("native") => Ok(Box::new(Native)),
        Some(choice) => Ok(Box::new(OnDevice::new(&Device::open(Some(&choice))?)?)),
        None => match Device::shared() {
            Ok(device) => for_device(&device),
            Err(_) => Ok(Box::new(Native)),
        },
    }
}

/// The faster multiplier where `device` is already open: itself, or [`Native`] if it is software on
/// the CPU.
///
/// # Errors
/// Refusal of the kernels by the driver.
pub fn for_device(device: &Device) -> Result<Box<dyn Multiplier>> {
    if device.summary().kind == DeviceKind::Cpu { Ok(Box::new(Native)) } else { Ok(Box::new(OnDevice::new(device)?)) }
}

/// The product of a chain of matrices, evaluated from the right as dctimestep does: V·(T·(D·S)). A
/// factor with one component applies to all components of the others.
///
/// # Errors
/// Shapes that do not fit (naming the position in the chain, from 1), and failures of a device.
pub fn chain(multiplier: &dyn Multiplier, factors: &[&Matrix<f32>]) -> Result<Matrix<f32>> {
    let Some((last, others)) = factors.split_last() else {
        return Err(Error::new("a product needs at least one matrix"));
    };
    let components = common_components(factors)?;
    for (i, pair) in factors.windows(2).enumerate() {
        if pair[0].cols() != pair[1].rows() {
            return Err(Error::new(format!(
                "matrix {} has {} columns, but matrix {} has {} rows",
                i + 1,
                pair[0].cols(),
                i + 2,
                pair[1].rows()
            )));
        }
    }
    let mut result = with_components(last, components).into_owned();
    for factor in others.iter().rev() {
        let left = with_components(factor, components);
        result = multiply(multiplier, &left, &result)?;
    }
    Ok(result)
}

/// The product of two matrices of the same components.
fn multiply(multiplier: &dyn Multiplier, left: &Matrix<f32>, right: &Matrix<f32>) -> Result<Matrix<f32>> {
    let (rows, terms, columns, components) = (left.rows(), left.cols(), right.cols(), left.components());
    let a = multiplier.left(rows, terms, components, left.data().into())?;
    let b = multiplier.right(terms, columns, components, right.data().into())?;
    let mut product = Matrix::zeros(rows, columns, components);
    multiplier.multiply(&a, &b, 0, columns, Arrangement::Rows, product.data_mut())?;
    Ok(product)
}

/// The number of components of the product of these matrices.
///
/// # Errors
/// Two different numbers other than 1.
pub(crate) fn common_components(factors: &[&Matrix<f32>]) -> Result<usize> {
    let most = factors.iter().map(|m| m.components()).max().unwrap_or(1);
    match factors.iter().position(|m| m.components() != most && m.components() != 1) {
        None => Ok(most),
        Some(i) => Err(Error::new(format!("matrix {} has {} components, another has {most}", i + 1, factors[i].components()))
            .help("matrices in a product have the same number of components (NCOMP), or one")),
    }
}

/// The matrix with one component repeated `components` times, or as it is.
pub fn with_components(matrix: &Matrix<f32>, components: usize) -> Cow<'_, Matrix<f32>> {
    if matrix.components() == components {
        return Cow::Borrowed(matrix);
    }
    assert_eq!(matrix.components(), 1, "only single components can be repeated");
    let data = matrix.data().iter().flat_map(|v| std::iter::repeat_n(*v, components)).collect();
    Cow::Owned(Matrix::from_data(matrix.rows(), matrix.cols(), components, data).expect("the size is right by construction"))
}

#[cfg(test)]
mod tests;
