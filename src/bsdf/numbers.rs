//! The number list of a matrix's `ScatteringData`, read piece by piece.

use crate::error::{Error, Result};
use crate::limits::NUMBER_CHARACTERS;

/// Collects numbers separated by blanks, commas or semicolons from pieces of text.
///
/// Files written under a locale with decimal commas (`0,25 1,5e-3`) are recognised: as long as no
/// decimal point has been seen, every inner comma is read both ways, and the number of values
/// decides in [`finish`](Self::finish).
pub(super) struct NumberList {
    word: String,
    /// Commas separate.
    points: Vec<f64>,
    /// Commas are decimal; `None` once that reading is impossible.
    commas: Option<Vec<f64>>,
    limit: usize,
}

impl NumberList {
    /// An empty list that refuses to hold more than `limit` values.
    pub(super) fn new(limit: usize) -> Self {
        Self { word: String::new(), points: Vec::new(), commas: Some(Vec::new()), limit }
    }

    /// Takes the next piece of text, which starts on line `line`.
    pub(super) fn feed(&mut self, text: &[u8], mut line: usize) -> Result<()> {
        for &byte in text {
            if byte.is_ascii_whitespace() || byte == b';' {
                self.end_word().map_err(|e| e.line(line))?;
                line += usize::from(byte == b'\n');
                continue;
            }
            if byte == b',' && self.commas.is_none() {
                self.end_word().map_err(|e| e.line(line))?;
                continue;
            }
            if self.word.len() >= NUMBER_CHARACTERS {
                // Either commas alone separate the numbers, or this is no number.
                let last = self.word.rfind(',').ok_or_else(|| not_a_number(&self.word).line(line))?;
                let rest = self.word.split_off(last + 1);
                self.commas = None;
                self.end_word().map_err(|e| e.line(line))?;
                self.word = rest;
            }
            self.word.push(byte as char);
        }
        Ok(())
    }

    fn end_word(&mut self) -> Result<()> {
        let word = std::mem::take(&mut self.word);
        let bare = word.trim_matches(',');
        if bare.is_empty() {
            return Ok(());
        }
        if let Some(commas) = &mut self.commas {
            let decimal = if bare.contains('.') { None } else { bare.replacen(',', ".", 1).parse::<f64>().ok() };
            match decimal {
                Some(v) if v.is_finite() => commas.push(v),
                _ => self.commas = None,
            }
        }
        for number in bare.split(',').filter(|n| !n.is_empty()) {
            let value: f64 = number.parse().map_err(|_| not_a_number(number))?;
            if !value.is_finite() {
                return Err(Error::new(format!("value {} is '{}'", self.points.len() + 1, number.escape_debug()))
                    .help("a scattering value must be a finite number; measure or generate the file again"));
            }
            self.points.push(value);
        }
        // Twice, because decimal commas count as two numbers until the end.
        if self.points.len() > self.limit.saturating_mul(2) {
            return Err(Error::new(format!("more than {} values", self.limit)));
        }
        Ok(())
    }

    /// The values if there are as many as `fits` accepts, and whether decimal commas were assumed;
    /// else how many were found.
    pub(super) fn finish(mut self, fits: impl Fn(usize) -> bool) -> Result<std::result::Result<(Vec<f64>, bool), usize>> {
        self.end_word()?;
        if fits(self.points.len()) {
            return Ok(Ok((self.points, false)));
        }
        match self.commas {
            Some(values) if fits(values.len()) => Ok(Ok((values, true))),
            _ => Ok(Err(self.points.len())),
        }
    }
}

fn not_a_number(word: &str) -> Error {
    Error::new(format!("'{}' is not a number", word.escape_debug())).help("values are numbers separated by blanks or commas")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str, count: usize) -> Result<std::result::Result<(Vec<f64>, bool), usize>> {
        let mut list = NumberList::new(count);
        for piece in text.as_bytes().chunks(3) {
            list.feed(piece, 1)?;
        }
        list.finish(|n| n == count)
    }

    fn values(text: &str, count: usize) -> Vec<f64> {
        parse(text, count).unwrap().unwrap().0
    }

    #[test]
    fn blanks_commas_semicolons_and_decimal_commas_separate_as_meant() {
        let wanted = [0.25, 1.0, -3e-4];
        for text in
            ["0.25 1 -3e-4", "0.25,1,-3e-4,", " 0.25, 1.0,\n\t-3.0E-4 ,\n", "0,25 1,0 -3e-4", "0,25; 1,0;-3,0e-4;", "0,25, 1,0, -3e-4"]
        {
            assert_eq!(values(text, 3), wanted, "{text:?}");
        }
        assert_eq!(values("0,1,1,0", 4), [0.0, 1.0, 1.0, 0.0]);
        assert_eq!(values("0,1 1,0", 4), [0.0, 1.0, 1.0, 0.0]);
        assert_eq!(values("0,1 1,0", 2), [0.1, 1.0]);
        assert_eq!(values(&"1,".repeat(500), 500), [1.0; 500]);
        assert_eq!(values(&"0.123456789,".repeat(50), 50), [0.123456789; 50]);
        assert!(parse("0,1 1,0", 2).unwrap().unwrap().1);
    }

    #[test]
    fn faults_are_errors() {
        assert_eq!(parse("1 2", 3).unwrap().unwrap_err(), 2);
        assert!(parse("1 2 3 4 5 6 7 8", 3).is_err());
        assert!(parse("1 x 3", 3).is_err());
        assert!(parse("1 nan 3", 3).is_err());
        assert!(parse("1 inf 3", 3).is_err());
        assert!(parse("1 1e999 3", 3).is_err());
        assert!(parse("1 {2} 3", 3).is_err());
        assert!(parse(&"9".repeat(100), 1).is_err());
        assert!(NumberList::new(3).feed(&[0xff, b' '], 7).unwrap_err().to_string().contains("line 7"));
    }
}
