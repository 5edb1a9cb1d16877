//! The transmission matrix T of the matrix methods.

use super::resample::to_klems;
use super::{Block, Bsdf, Component, KlemsMatrix, projected_solid_angles};
use crate::bins::{AngleBasis, KlemsBasis};
use crate::error::{Error, Result};
use crate::matrix::Matrix;

/// Where a simulation takes the transmission of daylight from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TransmissionSource {
    /// Visible / Transmission Front.
    Front,
    /// Visible / Transmission Back, reversed by reciprocity, because Front is missing.
    BackReversed,
}

/// The block that [`transmission_matrix`] uses, the choice of `dctimestep` and `rmtxop`.
///
/// # Errors
/// If the file has no visible transmission. (Radiance then simulates an opaque window.)
pub fn transmission_source(bsdf: &Bsdf) -> Result<TransmissionSource> {
    if bsdf.visible.transmission_front.is_some() {
        return Ok(TransmissionSource::Front);
    }
    if bsdf.visible.transmission_back.is_some() {
        return Ok(TransmissionSource::BackReversed);
    }
    let solar = if bsdf.solar.is_empty() { "" } else { "; its Solar data do not describe visible light" };
    Err(Error::new(format!("the BSDF has no transmission of wavelength Visible{solar}"))
        .field("WavelengthData")
        .help("use a file with Visible / Transmission Front data"))
}

/// The transmission matrix `T[outgoing bin][incident bin] = f Λ_incident`, dimensionless: incident
/// radiance per bin of the sky side to outgoing radiance per bin of the room side. One component;
/// three (RGB) if the file has CIE-X and CIE-Z data beside the visible.
///
/// Block and orientation are those of `dctimestep` (`cmbsdf.c`): Transmission Front, else
/// Transmission Back by reciprocity; negative values count as 0. Not followed: dctimestep's
/// perturbation of Lambertian parts (3e-4 relative) and its dropping of components below 0.1 %.
///
/// A tensor tree, which `dctimestep` refuses, is averaged over the bins of the Klems full basis.
///
/// # Errors
/// If there is no visible transmission, or colours of different bases.
pub fn transmission_matrix(bsdf: &Bsdf) -> Result<Matrix<f64>> {
    let source = transmission_source(bsdf)?;
    let y = directed(&bsdf.visible, source).expect("the source was found in this band");
    let coloured = directed(&bsdf.cie_x, source).zip(directed(&bsdf.cie_z, source));
    let (n_in, n_out) = (y.incident().len(), y.outgoing().len());
    let lambda = projected_solid_angles(y.incident());
    let value = |m: &KlemsMatrix, k: usize| m.values()[k].max(0.0) * lambda[k % n_in];
    let Some((x, z)) = coloured else {
        return Matrix::from_data(n_out, n_in, 1, (0..n_in * n_out).map(|k| value(&y, k)).collect());
    };
    if [&x, &z].iter().any(|m| m.incident() != y.incident() || m.outgoing() != y.outgoing()) {
        return Err(Error::new("the CIE-X, Visible and CIE-Z data have different angle bases").field("WavelengthDataBlock"));
    }
    let to_rgb = xyz_to_rgb();
    let data = (0..n_in * n_out).flat_map(|k| {
        let xyz = [value(&x, k), value(&y, k), value(&z, k)];
        to_rgb.map(|row| row.iter().zip(xyz).map(|(a, b)| a * b).sum::<f64>().max(0.0))
    });
    Matrix::from_data(n_out, n_in, 3, data.collect())
}

fn directed(blocks: &super::Blocks, source: TransmissionSource) -> Option<KlemsMatrix> {
    let component = match source {
        TransmissionSource::Front => Component::TransmissionFront,
        TransmissionSource::BackReversed => Component::TransmissionBack,
    };
    let full = AngleBasis::from(KlemsBasis::Full);
    let matrix = blocks.get(component).map(|block| match block {
        Block::Klems(m) => m.clone(),
        Block::Tree(_) => to_klems(block, &full, &full),
    });
    matrix.map(|m| if source == TransmissionSource::Front { m } else { m.reversed() })
}

/// CIE XYZ to RGB of Radiance's primaries: red (.640 .330), green (.290 .600), blue (.150 .060),
/// white of equal energy.
pub(super) fn xyz_to_rgb() -> [[f64; 3]; 3] {
    let xyz = |x: f64, y: f64| glam::DVec3::new(x, y, 1.0 - x - y);
    let primaries = glam::DMat3::from_cols(xyz(0.640, 0.330), xyz(0.290, 0.600), xyz(0.150, 0.060));
    let scale = primaries.inverse() * glam::DVec3::ONE;
    let inverse = (primaries * glam::DMat3::from_diagonal(scale)).inverse().transpose();
    [inverse.x_axis.to_array(), inverse.y_axis.to_array(), inverse.z_axis.to_array()]
}
