//! Buffers of glTF files and typed reading from them, with every bound checked.

use crate::error::{Error, Result};
use crate::{files, limits};
use glam::DVec3;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::{Source, View};
use std::path::{Component, Path, PathBuf};

/// Bytes of all buffers.
pub(super) struct Buffers {
    bytes: Vec<Vec<u8>>,
    /// Whether positions and normals may be integers (`KHR_mesh_quantization`).
    quantised: bool,
}

impl Buffers {
    /// Loads all buffers of a file: its binary part, data URIs, and files in its folder or below.
    ///
    /// # Errors
    /// Missing or short buffers, and paths that lead out of the folder.
    pub(super) fn load(gltf: &gltf::Gltf, file: &Path) -> Result<Self> {
        let mut buffers = Vec::new();
        for buffer in gltf.buffers() {
            let at = |e: Error| e.file(file).field(format!("buffer {}", buffer.index()));
            let bytes = match buffer.source() {
                Source::Bin => {
                    let missing = || Error::new("the binary part of the file is missing").help("export the file again");
                    gltf.blob.clone().ok_or_else(missing).map_err(at)?
                }
                Source::Uri(uri) if uri.starts_with("data:") => {
                    let bad = |e| at(Error::new(format!("its data URI cannot be decoded: {e}")).help("export the file again"));
                    let text = uri.split_once(";base64,").map_or("", |(_, text)| text);
                    base64::decode(text).map_err(bad)?
                }
                Source::Uri(uri) => {
                    files::read(&beside(file, uri).map_err(at)?).map_err(|e| e.field(format!("buffer {}", buffer.index())))?
                }
            };
            if bytes.len() < buffer.length() {
                let message = format!("{} bytes are there, {} are announced", bytes.len(), buffer.length());
                return Err(at(Error::new(message).help("copy the whole buffer file, or export again")));
            }
            buffers.push(bytes);
        }
        Ok(Self { bytes: buffers, quantised: gltf.extensions_used().any(|e| e == "KHR_mesh_quantization") })
    }

    /// The positions or normals of an accessor.
    ///
    /// # Errors
    /// As [`floats`](Self::floats); integers in files that do not use `KHR_mesh_quantization`.
    pub(super) fn vectors(&self, accessor: &gltf::Accessor) -> Result<Vec<DVec3>> {
        if accessor.data_type() != DataType::F32 && !self.quantised {
            return Err(Error::new(
                "positions and normals must be vectors of three 32-bit floats, unless the file uses KHR_mesh_quantization",
            )
            .field(format!("accessor {}", accessor.index()))
            .help("export without quantisation"));
        }
        Ok(self.floats::<3>(accessor)?.into_iter().map(DVec3::from_array).collect())
    }

    /// The vectors of N components of an accessor: 32-bit floats, or integers of 8 or 16 bits, normalised
    /// or not, as `KHR_mesh_quantization` has them.
    ///
    /// # Errors
    /// Other types of numbers or vectors; data outside the buffers.
    pub(super) fn floats<const N: usize>(&self, accessor: &gltf::Accessor) -> Result<Vec<[f64; N]>> {
        let at = |e: Error| e.field(format!("accessor {}", accessor.index()));
        if accessor.dimensions().multiplicity() != N || matches!(accessor.dimensions(), Dimensions::Mat2) {
            return Err(at(
                Error::new(format!("{N} components are needed, this has {:?}", accessor.dimensions())).help("export the file again")
            ));
        }
        // Bytes of a component, and the value that stands for 1.
        let (size, one, number): (usize, f64, fn(&[u8]) -> f64) = match accessor.data_type() {
            DataType::F32 => (4, 1.0, |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
            DataType::I8 => (1, 127.0, |b| f64::from(b[0].cast_signed())),
            DataType::U8 => (1, 255.0, |b| f64::from(b[0])),
            DataType::I16 => (2, 32767.0, |b| f64::from(i16::from_le_bytes([b[0], b[1]]))),
            DataType::U16 => (2, 65535.0, |b| f64::from(u16::from_le_bytes([b[0], b[1]]))),
            DataType::U32 => return Err(at(Error::new("vectors cannot be integers of 32 bits").help("export the file again"))),
        };
        let one = if accessor.normalized() { one } else { 1.0 };
        let lowest = if accessor.normalized() { -1.0 } else { f64::NEG_INFINITY };
        self.elements(accessor, N * size, |bytes| std::array::from_fn(|i| (number(&bytes[i * size..]) / one).max(lowest))).map_err(at)
    }

    /// The indices of an accessor.
    ///
    /// # Errors
    /// Other types than unsigned integers; data outside the buffers.
    pub(super) fn indices(&self, accessor: &gltf::Accessor) -> Result<Vec<u32>> {
        let at = |e: Error| e.field(format!("accessor {}", accessor.index()));
        if accessor.dimensions() != Dimensions::Scalar {
            return Err(at(Error::new("indices must be single numbers").help("export the file again")));
        }
        match unsigned_size(accessor.data_type()) {
            Some(size) => self.elements(accessor, size, unsigned).map_err(at),
            None => Err(at(Error::new("indices must be unsigned integers").help("export the file again"))),
        }
    }

    fn elements<T: Clone>(&self, accessor: &gltf::Accessor, size: usize, decode: impl Fn(&[u8]) -> T) -> Result<Vec<T>> {
        let count = accessor.count();
        let mut values = match accessor.view() {
            Some(view) => self.decoded(&view, accessor.offset(), count, size, &decode)?,
            // Without a view all elements are zero, but for the sparse ones.
            None if accessor.sparse().is_some() && count <= limits::EMPTY_ELEMENTS => vec![decode(&[0; 16]); count],
            None if accessor.sparse().is_some() => {
                return Err(
                    limits::exceeded("the accessor has no data, but", limits::EMPTY_ELEMENTS, "elements").help("export the file again")
                );
            }
            None => return Err(Error::new("the accessor has no data").help("export the file again, without compression of meshes")),
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, replacements) = (sparse.indices(), sparse.values());
            let index_size = match indices.index_type() {
                gltf::accessor::sparse::IndexType::U8 => 1,
                gltf::accessor::sparse::IndexType::U16 => 2,
                gltf::accessor::sparse::IndexType::U32 => 4,
            };
            let places = self.decoded(&indices.view(), indices.offset(), sparse.count(), index_size, &unsigned)?;
            let new = self.decoded(&replacements.view(), replacements.offset(), sparse.count(), size, &decode)?;
            for (place, value) in places.into_iter().zip(new) {
                let out = || Error::new(format!("a sparse element replaces number {place} of {count}")).help("export the file again");
                *values.get_mut(place as usize).ok_or_else(out)? = value;
            }
        }
        Ok(values)
    }

    fn decoded<T>(&self, view: &View, offset: usize, count: usize, size: usize, decode: &impl Fn(&[u8]) -> T) -> Result<Vec<T>> {
        let outside = || Error::new("the data lie outside their buffer").help("export the file again");
        let bytes = self.bytes.get(view.buffer().index()).ok_or_else(outside)?;
        let end = view.offset().checked_add(view.length()).ok_or_else(outside)?;
        let bytes = bytes.get(view.offset()..end).ok_or_else(outside)?;
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(Error::new(format!("a stride of {stride} bytes for elements of {size}")).help("export the file again"));
        }
        let last = count.checked_sub(1).and_then(|n| n.checked_mul(stride)).and_then(|n| n.checked_add(offset)?.checked_add(size));
        match last {
            None if count == 0 => Ok(Vec::new()),
            Some(last) if last <= bytes.len() => Ok((0..count).map(|i| decode(&bytes[offset + i * stride..][..size])).collect()),
            _ => Err(outside()),
        }
    }
}

fn unsigned_size(data_type: DataType) -> Option<usize> {
    match data_type {
        DataType::U8 => Some(1),
        DataType::U16 => Some(2),
        DataType::U32 => Some(4),
        DataType::I8 | DataType::I16 | DataType::F32 => None,
    }
}

fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().take(4).rev().fold(0, |n, &b| n << 8 | u32::from(b))
}

/// The file a relative URI names, which must lie in the folder of `file` or below.
fn beside(file: &Path, uri: &str) -> Result<PathBuf> {
    let refused = |why: &str| {
        Error::new(format!("the buffer '{}' {why}", crate::scene::rad::shortened(uri)))
            .help("put the buffer into the folder of the file, and name it relative to that")
    };
    let decoded = percent_decoded(uri).ok_or_else(|| refused("is not a valid URI"))?;
    let relative = Path::new(&decoded);
    // A scheme (http:, file:) would come before the first slash.
    if decoded.split('/').next().is_some_and(|first| first.contains(':')) {
        return Err(refused("is not a relative path; nothing is loaded from elsewhere"));
    }
    if !relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir))
        || decoded.contains('\\')
        || decoded.contains('\0')
    {
        return Err(refused("lies outside the folder of the file"));
    }
    let folder = match file.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let path = folder.join(relative);
    let (real, home) = (path.canonicalize().map_err(|e| Error::io(&path, &e))?, folder.canonicalize().map_err(|e| Error::io(folder, &e))?);
    if !real.starts_with(&home) {
        return Err(refused("is a link that leads out of the folder of the file"));
    }
    Ok(path)
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(b) = rest.next() {
        if b == b'%' {
            let digit = |b: Option<u8>| b.and_then(|b| (b as char).to_digit(16));
            bytes.push((digit(rest.next())? * 16 + digit(rest.next())?) as u8);
        } else {
            bytes.push(b);
        }
    }
    String::from_utf8(bytes).ok()
}
