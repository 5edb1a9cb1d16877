//! The header of a matrix file: its size and how its values are stored.

use super::{Format, Scalar};
use crate::error::{Error, Result};
use crate::limits::MATRIX_HEADER;
use crate::text;
use std::io::{BufRead, Read};

/// What the header says.
#[derive(Debug)]
pub(in crate::matrix) struct Header {
    pub rows: Option<usize>,
    pub cols: Option<usize>,
    pub components: usize,
    pub big_endian: bool,
    pub format: Format,
    exposure: f64,
    colour_correction: [f64; 3],
    pub kept: Vec<String>,
}

impl Header {
    /// Reads up to and including the empty line; also gives the number of lines read.
    pub fn read(stream: &mut impl BufRead) -> Result<(Self, usize)> {
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
        let mut limited = stream.take(MATRIX_HEADER);
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
    pub(crate) fn undo_exposure<T: Scalar>(&self, data: &mut [T]) {
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

/// The header of a matrix of this shape with further lines, up to and including the empty line.
pub(super) fn header_text([rows, cols, components]: [usize; 3], format: Format, lines: &[String]) -> Result<String> {
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
