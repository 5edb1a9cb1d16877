//! Scanline by scanline, for pictures that should not be in memory as a whole.

use super::header::{Header, PixelFormat, compose};
use super::input::Input;
use super::{Exposure, scanline, xyz_to_rgb};
use crate::error::{Error, Result};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Reads a picture scanline by scanline, in the file's own order (see [`Header::orientation`]).
pub(crate) struct ScanlineReader<R> {
    input: Input<R>,
    header: Header,
    exposure: Exposure,
    encoded: Vec<[u8; 4]>,
    next: usize,
}

impl ScanlineReader<File> {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// As [`super::read`], for the header.
    pub fn open(path: &Path, exposure: Exposure) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::io(path, &e))?;
        Self::new(file, path, exposure)
    }
}

/// Where a reader stopped; see [`ScanlineReader::pause`].
#[derive(Debug, Clone)]
pub(crate) struct Pause {
    header: Header,
    exposure: Exposure,
    offset: u64,
    next: usize,
}

impl Pause {
    /// What the header says.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Opens the file again and goes on where it was left.
    ///
    /// # Errors
    /// If the file cannot be opened.
    pub fn resume(&self, path: &Path) -> Result<ScanlineReader<File>> {
        let mut file = File::open(path).map_err(|e| Error::io(path, &e))?;
        file.seek(SeekFrom::Start(self.offset)).map_err(|e| Error::io(path, &e))?;
        let input = Input::resume(file, path, self.offset);
        Ok(ScanlineReader { input, header: self.header.clone(), exposure: self.exposure, encoded: Vec::new(), next: self.next })
    }
}

impl<R: Read> ScanlineReader<R> {
    /// Remembers the place and closes the file, so that many pictures can be read in turns without
    /// keeping all of them open.
    pub fn pause(self) -> Pause {
        Pause { offset: self.input.offset(), header: self.header, exposure: self.exposure, next: self.next }
    }

    /// Reads the header from `source`; `path` is for messages only (empty for bytes in memory).
    ///
    /// # Errors
    /// As [`super::read`], for the header.
    pub fn new(source: R, path: &Path, exposure: Exposure) -> Result<Self> {
        let mut input = Input::new(source, path);
        let header = Header::read(&mut input).map_err(|e| input.named(e))?;
        let encoded = Vec::new();
        Ok(Self { input, header, exposure, encoded, next: 0 })
    }

    pub(super) fn exposure(&self) -> Exposure {
        self.exposure
    }

    /// What the header says.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Reads the next scanline as stored, `[mantissas, exponent]` per pixel.
    ///
    /// # Errors
    /// If the file ends early, is damaged, or all scanlines have been read.
    ///
    /// # Panics
    /// If `pixels` has not the length that [`Header::scanlines`] gives.
    pub(crate) fn read_encoded(&mut self, pixels: &mut [[u8; 4]]) -> Result<()> {
        let (count, length) = self.header.scanlines();
        assert_eq!(pixels.len(), length, "length of the scanline");
        if self.next == count {
            return Err(self.input.named(Error::new(format!("all {count} scanlines have been read"))));
        }
        let number = self.next + 1;
        scanline::decode(&mut self.input, pixels).map_err(|e| self.input.named(e.field(format!("scanline {number} of {count}"))))?;
        self.next += 1;
        Ok(())
    }

    /// Reads the next scanline as RGB radiance.
    ///
    /// # Errors
    /// As [`Self::read_encoded`].
    ///
    /// # Panics
    /// As [`Self::read_encoded`].
    pub fn read(&mut self, pixels: &mut [[f32; 3]]) -> Result<()> {
        let mut encoded = std::mem::take(&mut self.encoded);
        encoded.resize(pixels.len(), [0; 4]);
        let result = self.read_encoded(&mut encoded);
        self.encoded = encoded;
        result?;
        for (pixel, &code) in pixels.iter_mut().zip(&self.encoded) {
            *pixel = scanline::from_rgbe(code);
        }
        if self.header.format == PixelFormat::Xyze {
            xyz_to_rgb(pixels);
        }
        if self.exposure == Exposure::Undo && self.header.exposure != [1.0; 3] {
            let factor = self.header.exposure.map(|e| 1.0 / e);
            for pixel in pixels {
                for (value, f) in pixel.iter_mut().zip(factor) {
                    *value = (f64::from(*value) * f) as f32;
                }
            }
        }
        Ok(())
    }
}

/// Writes a picture row by row, from the top.
pub struct ScanlineWriter<W> {
    out: W,
    path: PathBuf,
    width: usize,
    height: usize,
    rows: usize,
    pixels: Vec<[u8; 4]>,
    planes: Vec<u8>,
    bytes: Vec<u8>,
}

impl<W: Write> ScanlineWriter<W> {
    /// Writes the header; `path` is for messages only. Header lines are as in
    /// [`super::super::Picture`].
    ///
    /// # Errors
    /// If writing fails or a header line cannot be one.
    pub fn new(out: W, path: &Path, width: usize, height: usize, view: Option<&str>, lines: &[String]) -> Result<Self> {
        if width == 0 || height == 0 || width.checked_mul(height).is_none_or(|n| n > crate::limits::PIXELS) {
            return Err(Error::new(format!("cannot write a picture of {width} × {height} pixels")).file(path));
        }
        let text = compose(width, height, view, lines).map_err(|e| e.file(path))?;
        let mut writer =
            Self { out, path: path.to_path_buf(), width, height, rows: 0, pixels: Vec::new(), planes: Vec::new(), bytes: Vec::new() };
        writer.bytes.extend_from_slice(text.as_bytes());
        writer.flush_bytes()?;
        Ok(writer)
    }

    /// Writes the next row.
    ///
    /// # Errors
    /// If writing fails or a pixel cannot be encoded.
    ///
    /// # Panics
    /// If the row has the wrong length or there are too many rows.
    pub fn write(&mut self, row: &[[f32; 3]]) -> Result<()> {
        assert_eq!(row.len(), self.width, "length of the row");
        assert!(self.rows < self.height, "too many rows");
        self.pixels.clear();
        for (x, &color) in row.iter().enumerate() {
            let code = scanline::to_rgbe(color).map_err(|e| e.file(&self.path).field(format!("pixel {x}, {}", self.rows)))?;
            self.pixels.push(code);
        }
        scanline::encode(&self.pixels, &mut self.planes, &mut self.bytes);
        self.rows += 1;
        self.flush_bytes()
    }

    /// Ends the picture.
    ///
    /// # Errors
    /// If rows are missing.
    pub fn finish(self) -> Result<W> {
        if self.rows < self.height {
            return Err(Error::new(format!("only {} of {} rows were written", self.rows, self.height)).file(&self.path));
        }
        Ok(self.out)
    }

    fn flush_bytes(&mut self) -> Result<()> {
        self.out.write_all(&self.bytes).map_err(|e| Error::io(&self.path, &e))?;
        self.bytes.clear();
        Ok(())
    }
}
