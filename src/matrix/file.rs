//! Radiance matrix files: a text header, then values as `ascii`, `float` or `double`.
//!
//! ```text
//! #?RADIANCE
//! (any lines; kept)
//! NROWS=145
//! NCOLS=146
//! NCOMP=3
//! BigEndian=0
//! FORMAT=float          (spaces may follow, so that the values start on a multiple of 4 or 8 bytes)
//! (one empty line)
//! values, row by row, components interleaved
//! ```
//!
//! Read as `rmtxop` reads them: NROWS may be missing (then the data decide), a missing NCOMP means
//! 3, a missing FORMAT means `ascii`, EXPOSURE and COLORCORR are undone. Unlike Radiance, NROWS
//! that does not fit the data and values that are not finite are errors.

use super::Matrix;
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::text;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;

/// How the values of a matrix file are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Numbers as text: exact when written here, 7 digits or fewer in files of Radiance's programs.
    Ascii,
    /// 32-bit IEEE.
    Float,
    /// 64-bit IEEE.
    Double,
}

impl Format {
    /// The word after `FORMAT=`.
    pub fn name(self) -> &'static str {
        match self {
            Format::Ascii => "ascii",
            Format::Float => "float",
            Format::Double => "double",
        }
    }

    /// The format of Radiance's option letter, as in `-fa`, `-ff`, `-fd`.
    pub fn from_letter(letter: char) -> Option<Self> {
        match letter {
            'a' => Some(Format::Ascii),
            'f' => Some(Format::Float),
            'd' => Some(Format::Double),
            _ => None,
        }
    }

    /// Bytes per value; `None` for text.
    pub(super) fn width(self) -> Option<usize> {
        match self {
            Format::Ascii => None,
            Format::Float => Some(4),
            Format::Double => Some(8),
        }
    }
}

/// A matrix with the header lines of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixFile<T = f32> {
    /// The values, EXPOSURE and COLORCORR undone.
    pub matrix: Matrix<T>,
    /// Header lines without line ends and in their order, except those that describe size and
    /// storage (`#?RADIANCE`, NROWS, NCOLS, NCOMP, BigEndian, FORMAT, EXPOSURE, COLORCORR).
    pub header: Vec<String>,
}

impl<T> MatrixFile<T> {
    /// The value of the last header line `key=value`, trimmed.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.header.iter().rev().find_map(|l| l.strip_prefix(key)?.strip_prefix('=')).map(str::trim)
    }
}

/// A value that matrix files can hold: `f32` or `f64`.
pub trait Scalar: Copy + Default + sealed::Sealed {
    /// From a file's number; infinite if out of range.
    fn from_f64(value: f64) -> Self;
    /// To a file's number.
    fn to_f64(self) -> f64;
    /// From text.
    fn parse(text: &str) -> Option<Self>;
    /// As the shortest text that reads back to the same value.
    fn write_text(self, out: &mut Vec<u8>);
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

impl Scalar for f32 {
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn parse(text: &str) -> Option<Self> {
        text.parse().ok()
    }
    fn write_text(self, out: &mut Vec<u8>) {
        write!(out, "{self:e}").expect("a vector takes everything");
    }
}

impl Scalar for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
    fn parse(text: &str) -> Option<Self> {
        text.parse().ok()
    }
    fn write_text(self, out: &mut Vec<u8>) {
        write!(out, "{self:e}").expect("a vector takes everything");
    }
}

/// Reads a matrix into 32-bit values; `-` is standard input.
///
/// # Errors
/// What is wrong with the file and where, see the module.
pub fn read_matrix(path: &Path) -> Result<MatrixFile<f32>> {
    read(path)
}

/// Reads a matrix into 64-bit values; `-` is standard input.
///
/// # Errors
/// As [`read_matrix`].
pub fn read_matrix_f64(path: &Path) -> Result<MatrixFile<f64>> {
    read(path)
}

fn read<T: Scalar>(path: &Path) -> Result<MatrixFile<T>> {
    if path == Path::new("-") {
        return read_matrix_from(std::io::stdin().lock()).map_err(|e| e.file("standard input"));
    }
    let file = File::open(path).map_err(|e| Error::io(path, &e))?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(Error::new("this is a folder, not a matrix file").file(path));
    }
    read_matrix_from(file).map_err(|e| e.file(path))
}

/// Reads a matrix from a stream up to its end. Memory: the matrix itself, grown as data arrive
/// whatever the header promises, and a buffer of 1 MiB.
///
/// # Errors
/// As [`read_matrix`], without the file's name.
pub fn read_matrix_from<T: Scalar>(stream: impl Read) -> Result<MatrixFile<T>> {
    let mut stream = BufReader::with_capacity(1 << 20, stream);
    let (header, lines_read) = Header::read(&mut stream)?;
    let cols = header.cols.ok_or_else(|| {
        Error::new("the header has no NCOLS").field("NCOLS").help("add the line NCOLS=… for the number of columns before FORMAT")
    })?;
    let components = header.components;
    let row_len = cols.checked_mul(components).ok_or_else(|| Error::new("rows of this length do not fit into memory").field("NCOLS"))?;
    let expected = match header.rows {
        Some(rows) => Some(rows.checked_mul(row_len).ok_or_else(|| Error::new("this many rows do not fit into memory").field("NROWS"))?),
        None => None,
    };
    let mut values = Values { data: Vec::new(), row_len, components, expected };
    match header.format.width() {
        None => values.read_text(&mut stream, lines_read)?,
        Some(width) => values.read_binary(&mut stream, width, header.big_endian)?,
    }
    let rows = values.check_count(header.rows)?;
    header.undo_exposure(&mut values.data);
    let matrix = Matrix::from_data(rows, cols, components, values.data)?;
    Ok(MatrixFile { matrix, header: header.kept })
}

/// What the header says.
#[derive(Debug)]
pub(super) struct Header {
    pub rows: Option<usize>,
    pub cols: Option<usize>,
    pub components: usize,
    pub big_endian: bool,
    pub format: Format,
    exposure: f64,
    colour_correction: [f64; 3],
    pub kept: Vec<String>,
}

/// Longest header that is read: rcontrib repeats its whole command line, so lines can be long.
const HEADER_LIMIT: u64 = 16 << 20;

impl Header {
    /// Reads up to and including the empty line; also gives the number of lines read.
    pub(super) fn read(stream: &mut impl BufRead) -> Result<(Self, usize)> {
        let mut header = Header {
            rows: None,
            cols: None,
            components: 3,
            big_endian: cfg!(target_endian = "big"),
            format: Format::Ascii,
            exposure: 1.0,
            colour_correction: [1.0; 3],
            kept: Vec::new(),
        };
        let head = stream.fill_buf().map_err(|e| Error::stream(&e))?;
        if let Some(other) = text::Other::of(head) {
            return Err(other.instead_of("a matrix"));
        }
        if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
            return Err(Error::new("this file is in UTF-16, which no matrix is").help("save it as plain text"));
        }
        if head.starts_with(b"\xef\xbb\xbf") {
            stream.consume(3);
        }
        let mut limited = stream.take(HEADER_LIMIT);
        let mut line = Vec::new();
        for number in 1.. {
            line.clear();
            limited.read_until(b'\n', &mut line).map_err(|e| Error::stream(&e).line(number))?;
            if line.last() != Some(&b'\n') {
                return Err(not_a_matrix("it ends before the empty line that closes the header", number));
            }
            if line.contains(&0) {
                return Err(not_a_matrix("it has binary data where the header should be", number));
            }
            let text = String::from_utf8_lossy(&line);
            let text = text.trim_end_matches(['\n', '\r']);
            if text.is_empty() {
                return Ok((header, number));
            }
            header.take_line(text).map_err(|e| e.line(number))?;
        }
        unreachable!("the header limit ends the loop")
    }

    fn take_line(&mut self, line: &str) -> Result<()> {
        let (key, value) = line.split_once('=').unwrap_or((line, ""));
        let value = value.trim();
        match key {
            "NROWS" => self.rows = Some(size(key, value)?),
            "NCOLS" => self.cols = Some(size(key, value)?),
            "NCOMP" => self.components = size(key, value)?,
            "BigEndian" => {
                self.big_endian = match value {
                    "0" => false,
                    "1" => true,
                    _ => return Err(Error::new(format!("'{value}' is neither 0 nor 1")).field(key)),
                }
            }
            "FORMAT" => {
                self.format = match value {
                    "ascii" => Format::Ascii,
                    "float" => Format::Float,
                    "double" => Format::Double,
                    "32-bit_rle_rgbe" | "32-bit_rle_xyze" | "Radiance_spectra" => {
                        return Err(Error::new(format!("this is a picture ({value}), not a matrix"))
                            .field(key)
                            .help("give a matrix of format ascii, float or double"));
                    }
                    _ => return Err(Error::new(format!("unknown format '{value}'")).field(key).help("ascii, float and double are read")),
                }
            }
            "EXPOSURE" => {
                let [factor] = positive_numbers::<1>(key, value)?;
                self.exposure *= factor;
            }
            "COLORCORR" => {
                let factors = positive_numbers::<3>(key, value)?;
                self.colour_correction = std::array::from_fn(|c| self.colour_correction[c] * factors[c]);
            }
            _ if line.starts_with("#?") => {}
            _ => self.kept.push(line.to_string()),
        }
        Ok(())
    }

    /// Divides by EXPOSURE and, for colour, COLORCORR, as rmtxop does. (dctimestep leaves factors
    /// within 1 % of 1 alone.)
    pub(super) fn undo_exposure<T: Scalar>(&self, data: &mut [T]) {
        let colour = if self.components == 3 { self.colour_correction } else { [1.0; 3] };
        let factors = colour.map(|c| c * self.exposure);
        if factors != [1.0; 3] {
            for (v, factor) in data.iter_mut().zip(factors.into_iter().cycle()) {
                *v = T::from_f64(v.to_f64() / factor);
            }
        }
    }
}

fn not_a_matrix(why: &str, line: usize) -> Error {
    Error::new(format!("this is not a Radiance matrix: {why}")).line(line).help(
        "a matrix file has header lines such as NROWS=, NCOLS= and FORMAT=, one empty line, then the values; see the option -h of the program that wrote it",
    )
}

fn size(key: &str, value: &str) -> Result<usize> {
    value.parse().ok().filter(|&n: &usize| n > 0).ok_or_else(|| Error::new(format!("'{value}' is not a whole number above 0")).field(key))
}

fn positive_numbers<const N: usize>(key: &str, value: &str) -> Result<[f64; N]> {
    let numbers: Option<Vec<f64>> = value.split_whitespace().map(|w| w.parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite())).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| Error::new(format!("'{value}' should be {N} number(s) above 0")).field(key))
}

/// The values read so far.
struct Values<T> {
    data: Vec<T>,
    row_len: usize,
    components: usize,
    expected: Option<usize>,
}

impl<T: Scalar> Values<T> {
    fn push(&mut self, value: T) -> Result<()> {
        if self.expected == Some(self.data.len()) {
            return Err(self.too_many());
        }
        if !value.to_f64().is_finite() {
            return Err(Error::new(format!("the value {} of {} is not finite", value.to_f64(), self.place(self.data.len())))
                .help("something went wrong where this matrix was made; make it again"));
        }
        self.data.push(value);
        Ok(())
    }

    fn place(&self, index: usize) -> String {
        let (row, rest) = (index / self.row_len, index % self.row_len);
        format!("row {}, column {}, component {}", row + 1, rest / self.components + 1, rest % self.components + 1)
    }

    fn too_many(&self) -> Error {
        let rows = self.data.len() / self.row_len;
        Error::new(format!("there are more values than the {rows} rows × {} values that the header announces", self.row_len))
            .field("NROWS")
            .help("correct NROWS, NCOLS or NCOMP in the header, or remove NROWS to let the data decide")
    }

    fn read_binary(&mut self, stream: &mut impl BufRead, width: usize, big_endian: bool) -> Result<()> {
        let mut held = [0u8; 8];
        let mut holding = 0;
        loop {
            let chunk = stream.fill_buf().map_err(|e| Error::stream(&e))?;
            if chunk.is_empty() {
                break;
            }
            let mut rest = chunk;
            if holding > 0 {
                // A value may straddle two chunks of a pipe.
                let take = rest.len().min(width - holding);
                held[holding..holding + take].copy_from_slice(&rest[..take]);
                holding += take;
                rest = &rest[take..];
                if holding == width {
                    self.push(decode(&held[..width], big_endian))?;
                    holding = 0;
                }
            }
            let whole = rest.chunks_exact(width);
            let tail = whole.remainder();
            self.data.reserve(whole.len());
            for bytes in whole {
                self.push(decode(bytes, big_endian))?;
            }
            if !tail.is_empty() {
                held[..tail.len()].copy_from_slice(tail);
                holding = tail.len();
            }
            let used = chunk.len();
            stream.consume(used);
        }
        if holding > 0 {
            return Err(Error::new(format!("the file ends inside a value ({holding} of {width} bytes) after {} values", self.data.len()))
                .help("the file is cut off or not of the FORMAT that its header names"));
        }
        Ok(())
    }

    fn read_text(&mut self, stream: &mut impl BufRead, header_lines: usize) -> Result<()> {
        let mut line = header_lines + 1;
        let mut word: Vec<u8> = Vec::new();
        loop {
            let chunk = stream.fill_buf().map_err(|e| Error::stream(&e).line(line))?;
            if chunk.is_empty() {
                break;
            }
            for &byte in chunk {
                if byte.is_ascii_whitespace() {
                    if !word.is_empty() {
                        self.push_word(&word).map_err(|e| e.line(line))?;
                        word.clear();
                    }
                    line += usize::from(byte == b'\n');
                } else if word.len() < 64 {
                    word.push(byte);
                } else {
                    return Err(
                        Error::new(format!("'{}…' is not a number", String::from_utf8_lossy(&word[..32]).escape_debug())).line(line)
                    );
                }
            }
            let used = chunk.len();
            stream.consume(used);
        }
        if !word.is_empty() {
            self.push_word(&word).map_err(|e| e.line(line))?;
        }
        Ok(())
    }

    fn push_word(&mut self, word: &[u8]) -> Result<()> {
        let value = std::str::from_utf8(word).ok().and_then(T::parse).ok_or_else(|| {
            let word = String::from_utf8_lossy(word);
            let place = self.place(self.data.len());
            Error::new(format!("'{}' is not a number ({place}){}", word.escape_debug(), text::why_no_number(&word)))
                .help("values are separated by white space; is the FORMAT of the header right?")
        })?;
        self.push(value)
    }

    /// The number of rows, if the values fill them.
    fn check_count(&self, announced: Option<usize>) -> Result<usize> {
        let count = self.data.len();
        if let Some(rows) = announced
            && Some(count) != self.expected
        {
            return Err(Error::new(format!(
                "the data end after {count} values ({}); the header announces {rows} rows × {} values",
                self.place(count),
                self.row_len
            ))
            .field("NROWS")
            .help("the file is cut off, or NROWS, NCOLS or NCOMP is wrong; remove NROWS to let the data decide"));
        }
        if count == 0 || !count.is_multiple_of(self.row_len) {
            return Err(Error::new(format!("{count} values do not fill whole rows of {} values", self.row_len))
                .field("NCOLS")
                .help("the file is cut off, or NCOLS or NCOMP is wrong"));
        }
        Ok(count / self.row_len)
    }
}

fn decode<T: Scalar>(bytes: &[u8], big_endian: bool) -> T {
    let mut ordered = [0u8; 8];
    let n = bytes.len();
    ordered[..n].copy_from_slice(bytes);
    if big_endian {
        ordered[..n].reverse();
    }
    let [a, b, c, d, ..] = ordered;
    T::from_f64(if n == 4 { f64::from(f32::from_le_bytes([a, b, c, d])) } else { f64::from_le_bytes(ordered) })
}

/// Writes a matrix to a file (atomically), or to standard output where `path` is absent or `-`.
///
/// `header` holds further header lines without line ends (the program's own line, LATLONG=, …);
/// lines about size and storage among them are left out, this function writes its own.
///
/// # Errors
/// A header line that would end the header, a value that overflows the format, and failures of the
/// file system with the path named.
pub fn write_matrix<T: Scalar>(path: Option<&Path>, matrix: &Matrix<T>, format: Format, header: &[String]) -> Result<()> {
    match path {
        Some(path) if path != Path::new("-") => {
            write_atomically(path, |out| write_matrix_to(out, matrix, format, header).map_err(|e| e.file(path)))
        }
        _ => {
            let mut out = std::io::BufWriter::with_capacity(1 << 20, std::io::stdout().lock());
            write_matrix_to(&mut out, matrix, format, header)
                .and_then(|()| out.flush().map_err(|e| Error::stream(&e)))
                .map_err(|e| e.file("standard output"))
        }
    }
}

/// Writes a matrix to a stream. Binary values are little-endian and start on a multiple of their
/// size, as Radiance's own files do, so that its programs can map them into memory.
///
/// # Errors
/// As [`write_matrix`], without the file's name.
pub fn write_matrix_to<T: Scalar>(out: &mut dyn Write, matrix: &Matrix<T>, format: Format, header: &[String]) -> Result<()> {
    let failed = |e: std::io::Error| Error::new(e.to_string());
    let shape = [matrix.rows(), matrix.cols(), matrix.components()];
    out.write_all(header_text(shape, format, header)?.as_bytes()).map_err(failed)?;
    let row_len = matrix.cols() * matrix.components();
    let mut bytes = Vec::new();
    for row in 0..matrix.rows() {
        bytes.clear();
        for (i, &value) in matrix.row(row).iter().enumerate() {
            match format {
                Format::Double => bytes.extend_from_slice(&value.to_f64().to_le_bytes()),
                Format::Float => {
                    let single = value.to_f64() as f32;
                    if single.is_infinite() && value.to_f64().is_finite() {
                        return Err(Error::new(format!("the value {:e} in row {} is too large for format float", value.to_f64(), row + 1))
                            .help("write format double or ascii"));
                    }
                    bytes.extend_from_slice(&single.to_le_bytes());
                }
                Format::Ascii => {
                    value.write_text(&mut bytes);
                    bytes.push(match i + 1 {
                        n if n == row_len => b'\n',
                        n if n % matrix.components() == 0 => b'\t',
                        _ => b' ',
                    });
                }
            }
        }
        out.write_all(&bytes).map_err(failed)?;
    }
    Ok(())
}

/// Writes the header of a float matrix whose rows follow piece by piece, each value little-endian:
/// for matrices that are never in memory as a whole.
///
/// # Errors
/// As [`write_matrix_to`].
pub fn write_float_header(out: &mut dyn Write, [rows, cols, components]: [usize; 3], header: &[String]) -> Result<()> {
    let text = header_text([rows, cols, components], Format::Float, header)?;
    out.write_all(text.as_bytes()).map_err(|e| Error::stream(&e))
}

fn header_text([rows, cols, components]: [usize; 3], format: Format, lines: &[String]) -> Result<String> {
    const OURS: [&str; 7] = ["NROWS=", "NCOLS=", "NCOMP=", "BigEndian=", "FORMAT=", "EXPOSURE=", "COLORCORR="];
    let mut text = String::from("#?RADIANCE\n");
    for line in lines {
        if line.is_empty() || line.contains(['\n', '\r', '\0']) {
            return Err(Error::new(format!("the header line {line:?} would end or break the header")));
        }
        if !line.starts_with("#?") && !OURS.iter().any(|key| line.starts_with(key)) {
            text.push_str(line);
            text.push('\n');
        }
    }
    text.push_str(&format!("NROWS={rows}\nNCOLS={cols}\nNCOMP={components}\n"));
    if format != Format::Ascii {
        text.push_str("BigEndian=0\n");
    }
    text.push_str(&format!("FORMAT={}", format.name()));
    if let Some(width) = format.width() {
        let after_blank_line = text.len() + 2;
        text.extend(std::iter::repeat_n(' ', after_blank_line.next_multiple_of(width) - after_blank_line));
    }
    text.push_str("\n\n");
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    fn sample(components: usize) -> Matrix<f64> {
        let data = (0..4 * 3 * components).map(|i| if i == 5 { 0.0 } else { (i as f64 * 0.7).sin() * 10f64.powi(i as i32 % 9 - 4) });
        Matrix::from_data(4, 3, components, data.collect()).unwrap()
    }

    fn bytes<T: Scalar>(m: &Matrix<T>, format: Format, header: &[String]) -> Vec<u8> {
        let mut out = Vec::new();
        write_matrix_to(&mut out, m, format, header).unwrap();
        out
    }

    fn error(text: &[u8]) -> String {
        read_matrix_from::<f32>(text).unwrap_err().to_string()
    }

    #[test]
    fn round_trips_are_exact_in_every_format_and_component_count() {
        for components in [1, 3, 4] {
            let exact = sample(components);
            let single = exact.map(|v| v as f32);
            let header = vec!["gendaymtx -m 1".to_string(), "LATLONG= 40 -73".to_string()];
            for format in [Format::Ascii, Format::Float, Format::Double] {
                let back: MatrixFile<f32> = read_matrix_from(bytes(&single, format, &header).as_slice()).unwrap();
                assert_eq!(back.matrix, single, "{format:?}");
                assert_eq!(back.header, header);
                assert_eq!(back.value("LATLONG"), Some("40 -73"));
            }
            for format in [Format::Ascii, Format::Double] {
                let back: MatrixFile<f64> = read_matrix_from(bytes(&exact, format, &[]).as_slice()).unwrap();
                assert_eq!(back.matrix, exact, "{format:?}");
            }
        }
    }

    #[test]
    fn binary_values_start_on_a_multiple_of_their_size() {
        for (format, width) in [(Format::Float, 4), (Format::Double, 8)] {
            for n in 0..9 {
                let out = bytes(&sample(3), format, &["x".repeat(n + 1)]);
                let blank = out.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
                assert_eq!(blank % width, 0);
                assert_eq!(out.len() - blank, 36 * width);
            }
        }
    }

    #[test]
    fn streams_in_small_pieces_and_both_byte_orders_give_the_same() {
        struct Dribble<'a>(&'a [u8], usize);
        impl Read for Dribble<'_> {
            fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
                self.1 = self.1 % 7 + 1;
                let n = self.1.min(self.0.len()).min(buffer.len());
                buffer[..n].copy_from_slice(&self.0[..n]);
                self.0 = &self.0[n..];
                Ok(n)
            }
        }
        let m = sample(3);
        for format in [Format::Ascii, Format::Double] {
            let out = bytes(&m, format, &[]);
            assert_eq!(read_matrix_from::<f64>(Dribble(&out, 0)).unwrap().matrix, m);
        }
        let mut big = b"#?RADIANCE\nNCOLS=3\nBigEndian=1\nFORMAT=double\n\n".to_vec();
        big.extend(m.data().iter().flat_map(|v| v.to_be_bytes()));
        assert_eq!(read_matrix_from::<f64>(big.as_slice()).unwrap().matrix, m, "NROWS and NCOMP missing, too");
    }

    #[test]
    fn missing_lines_have_radiances_defaults_and_exposure_is_undone() {
        let m = read_matrix_from::<f32>(&b"NCOLS=2\n\n1 2 3\t4 5 6\n7 8 9\t10 11 12\n"[..]).unwrap().matrix;
        assert_eq!((m.rows(), m.cols(), m.components()), (2, 2, 3));
        let text = b"#?RADIANCE\nrtrace -x\nEXPOSURE=2\nEXPOSURE= 2\nCOLORCORR=1 2 4\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n4 8 16";
        let read = read_matrix_from::<f32>(&text[..]).unwrap();
        assert_eq!(read.matrix.data(), [1.0, 1.0, 1.0]);
        assert_eq!(read.header, ["rtrace -x"]);
    }

    #[test]
    fn faults_are_named_with_their_place() {
        let head = "#?RADIANCE\nNROWS=2\nNCOLS=2\nNCOMP=1\nFORMAT=ascii\n\n";
        let with = |data: &str| error(format!("{head}{data}").as_bytes());
        assert!(with("1 2 3").contains("NROWS: the data end after 3 values (row 2, column 2"), "{}", with("1 2 3"));
        assert!(with("1 2 3 4 5").contains("more values than the 2 rows"));
        assert!(with("1 2\n3 x\n").contains("line 8: 'x' is not a number (row 2, column 2"), "{}", with("1 2\n3 x\n"));
        assert!(with("1 2 nan 4").contains("not finite"));
        assert!(with(&"7".repeat(1000)).contains("is not a number"));
        assert!(error(b"").contains("ends before the empty line"));
        assert!(error(b"\0\0\0\n\n").contains("binary data"));
        assert!(error(b"#?RADIANCE\n\n1 2 3").contains("no NCOLS"));
        assert!(error(b"NCOLS=0\n\n").contains("not a whole number above 0"));
        assert!(error(b"NCOLS=2\nFORMAT=32-bit_rle_rgbe\n\n").contains("a picture"));
        assert!(error(b"NCOLS=2\nFORMAT=half\n\n").contains("unknown format"));
        assert!(error(b"NCOLS=2\nEXPOSURE=0\n\n").contains("above 0"));
        assert!(error(b"NROWS=999999999999999\nNCOLS=999999999999999\n\n1").contains("do not fit into memory"));
        assert!(error(b"NROWS=99999999999\nNCOLS=99999\nFORMAT=float\n\n1234").contains("the data end after 1 values"));
        assert!(error(b"NCOLS=1\nNCOMP=1\nFORMAT=double\n\n123456789").contains("inside a value (1 of 8 bytes)"));
        assert!(error(b"NCOLS=2\nNCOMP=1\n\n1 2 3").contains("do not fill whole rows"));
        assert!(error(&[b'x'; 100_000]).contains("not a Radiance matrix"));
        let mut out = Vec::new();
        assert!(write_matrix_to(&mut out, &sample(1), Format::Ascii, &["a\n\nb".into()]).is_err());
        let huge = Matrix::from_data(1, 1, 1, vec![1e300]).unwrap();
        assert!(write_matrix_to(&mut out, &huge, Format::Float, &[]).is_err());
    }

    #[test]
    fn truncation_and_corruption_never_panic() {
        let whole = bytes(&sample(3), Format::Float, &["line".into()]);
        for n in 0..whole.len() {
            assert!(read_matrix_from::<f32>(&whole[..n]).is_err(), "cut at {n}");
            let mut changed = whole.clone();
            changed[n] = changed[n].wrapping_mul(31).wrapping_add(97);
            let _ = read_matrix_from::<f32>(changed.as_slice());
        }
    }

    #[test]
    fn rmtxop_and_dctimestep_read_ours_and_we_read_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let single = Matrix::from_data(4, 3, 3, sample(3).data().iter().map(|&v| v.abs() as f32).collect()).unwrap();
        for format in [Format::Ascii, Format::Float, Format::Double] {
            let path = folder.path().join(format!("{}.mtx", format.name()));
            write_matrix(Some(&path), &single, format, &["made by hand".into()]).unwrap();
            assert_eq!(read_matrix(&path).unwrap().matrix, single);
            for option in ["-fa", "-ff", "-fd"] {
                let Some(mut rmtxop) = testing::radiance("rmtxop") else { return };
                let theirs = testing::output(rmtxop.arg(option).arg(&path));
                let back: MatrixFile<f32> = read_matrix_from(theirs.as_slice()).unwrap();
                let digits = if option == "-fa" { 1e-7 } else { 0.0 };
                for (a, b) in back.matrix.data().iter().zip(single.data()) {
                    assert!((a - b).abs() <= digits * b.abs(), "{option} of {format:?}: {a} {b}");
                }
                assert!(back.header.iter().any(|l| l == "made by hand"));
            }
            // DC · S with S the identity gives DC back.
            let identity = Matrix::from_data(3, 3, 3, (0..27).map(|i| f32::from(i / 3 % 4 == 0)).collect()).unwrap();
            let sky = folder.path().join("identity.mtx");
            write_matrix(Some(&sky), &identity, format, &[]).unwrap();
            let Some(mut dctimestep) = testing::radiance("dctimestep") else { return };
            let theirs = testing::output(dctimestep.arg("-of").arg(&path).arg(&sky));
            assert_eq!(read_matrix_from::<f32>(theirs.as_slice()).unwrap().matrix, single);
        }
    }

    #[test]
    fn exposure_of_a_file_agrees_with_rmtxop() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("e.mtx");
        let text = "#?RADIANCE\nEXPOSURE=1.003\nCOLORCORR=2 .5 4\nNROWS=1\nNCOLS=2\nNCOMP=3\nFORMAT=ascii\n\n1 2 3 4 5 6\n";
        std::fs::write(&path, text).unwrap();
        let Some(mut rmtxop) = testing::radiance("rmtxop") else { return };
        let theirs: MatrixFile<f64> = read_matrix_from(testing::output(rmtxop.arg("-fd").arg(&path)).as_slice()).unwrap();
        let ours = read_matrix_f64(&path).unwrap();
        for (a, b) in ours.matrix.data().iter().zip(theirs.matrix.data()) {
            assert!((a - b).abs() < 1e-6 * b, "{a} {b}");
        }
    }
}
