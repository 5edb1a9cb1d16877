//! The values of a matrix file, as they arrive.

use super::Scalar;
use crate::error::{Error, Result};
use crate::text;
use std::io::BufRead;

/// The values read so far.
pub(super) struct Values<T> {
    pub data: Vec<T>,
    row_len: usize,
    components: usize,
    expected: Option<usize>,
}

impl<T: Scalar> Values<T> {
    /// None yet, of rows of `row_len` values; `expected` in all, if the header says.
    pub fn new(row_len: usize, components: usize, expected: Option<usize>) -> Self {
        Self { data: Vec::new(), row_len, components, expected }
    }

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

    pub(crate) fn read_binary(&mut self, stream: &mut impl BufRead, width: usize, big_endian: bool) -> Result<()> {
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

    pub(crate) fn read_text(&mut self, stream: &mut impl BufRead, header_lines: usize) -> Result<()> {
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
        let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).ok_or_else(|| {
            let word = String::from_utf8_lossy(word);
            let place = self.place(self.data.len());
            Error::new(format!("'{}' is not a number ({place}){}", word.escape_debug(), text::why_no_number(&word)))
                .help("values are separated by white space; is the FORMAT of the header right?")
        })?;
        self.push(value)
    }

    /// The number of rows, if the values fill them.
    pub(crate) fn check_count(&self, announced: Option<usize>) -> Result<usize> {
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
