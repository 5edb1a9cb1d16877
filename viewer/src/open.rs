//! From a path to something that can be shown.

use crate::bsdf::model::BsdfFile;
use crate::picture::model::PictureFile;
use crate::results::Results;
use lucarne::matrix::file::read_matrix;
use lucarne::{Error, Result};
use std::path::Path;
use std::sync::Arc;

/// What a file turned out to be.
pub enum Opened {
    /// A BSDF.
    Bsdf(BsdfFile),
    /// A picture, or a matrix shown as one.
    Picture(Box<PictureFile>),
    /// A result folder, or illuminance alone.
    Results(Arc<Results>),
}

/// Reads a file or folder.
pub fn open(path: &Path) -> Result<Opened> {
    if path.is_dir() {
        return Ok(Opened::Results(Arc::new(Results::open(path)?)));
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "xml" => Ok(Opened::Bsdf(BsdfFile::read(path)?)),
        "hdr" | "pic" | "exr" => Ok(Opened::Picture(Box::new(PictureFile::read(path)?))),
        "mtx" | "smx" | "dmx" | "vmx" => matrix(path),
        "json" if path.file_name().is_some_and(|n| n == "summary.json") => {
            Ok(Opened::Results(Arc::new(Results::open(path.parent().unwrap_or(Path::new(".")))?)))
        }
        _ if !path.exists() => Err(Error::io(path, &std::io::Error::from(std::io::ErrorKind::NotFound))),
        _ => Err(Error::new("this kind of file cannot be shown")
            .file(path)
            .help("open a result folder of 'lucarne run', a BSDF (.xml), a picture (.hdr, .pic, .exr) or a matrix (.mtx)")),
    }
}

/// Illuminance over hours is a year; any other matrix is a picture of its entries.
fn matrix(path: &Path) -> Result<Opened> {
    let file = read_matrix(path)?;
    let m = &file.matrix;
    if m.components() == 1 && m.cols() >= 24 && m.cols().is_multiple_of(24) {
        return Ok(Opened::Results(Arc::new(Results::of_illuminance(path, file.matrix))));
    }
    PictureFile::of_matrix(path, m).map(|p| Opened::Picture(Box::new(p)))
}
