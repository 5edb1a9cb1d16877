//! Arguments that all phases of `lucarne matrix` have.

use lucarne::Result;
use lucarne::kernels::trace::{ROULETTE_WEIGHT, TracedMatrix};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, write_matrix};
use std::path::{Path, PathBuf};

/// How paths are followed, and where the matrix goes.
#[derive(clap::Args)]
pub struct TraceArgs {
    /// Most diffuse bounces; left out: not truncated
    #[arg(long = "ab", value_name = "N")]
    pub bounces: Option<u32>,

    /// Weight below which Russian roulette ends paths
    #[arg(long = "lw", value_name = "WEIGHT", default_value_t = ROULETTE_WEIGHT)]
    pub roulette_weight: f32,

    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u32,

    /// Independent repetitions, whose spread is the standard error (default 8; 4 for pictures)
    #[arg(long, value_name = "N")]
    pub batches: Option<u32>,

    /// Matrix file; standard output if absent
    #[arg(short = 'o', value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Also write the part without diffuse bounces (Vd, Dd)
    #[arg(long, value_name = "FILE")]
    pub direct: Option<PathBuf>,

    /// Also write the standard error of each entry
    #[arg(long, value_name = "FILE")]
    pub standard_error: Option<PathBuf>,

    /// Write numbers as text
    #[arg(long = "oa", conflicts_with = "double")]
    pub ascii: bool,

    /// Write 64-bit numbers
    #[arg(long = "od")]
    pub double: bool,

    /// Device: index or part of its name (see `lucarne devices`)
    #[arg(long)]
    pub device: Option<String>,
}

impl TraceArgs {
    /// Lines for the header of what is written.
    pub fn header(&self) -> Vec<String> {
        vec![std::env::args().collect::<Vec<_>>().join(" "), format!("SOFTWARE= Lucarne {}", env!("CARGO_PKG_VERSION"))]
    }

    /// Writes a matrix and what else was asked for.
    pub fn write(&self, traced: &TracedMatrix) -> Result<()> {
        let format = match (self.ascii, self.double) {
            (true, _) => Format::Ascii,
            (_, true) => Format::Double,
            _ => Format::Float,
        };
        let header = self.header();
        let also = |path: &Option<PathBuf>, matrix: &Matrix<f32>| match path {
            Some(path) => write_matrix(Some(path), matrix, format, &header),
            None => Ok(()),
        };
        also(&self.direct, &traced.direct)?;
        also(&self.standard_error, &traced.standard_error)?;
        write_matrix(self.output.as_deref().filter(|p| *p != Path::new("-")), &traced.total, format, &header)
    }
}
