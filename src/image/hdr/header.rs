//! The text in front of the pixels: information header and resolution line.

use super::input::Input;
use crate::camera::View;
use crate::error::{Error, Result};
use crate::limits::{PICTURE_HEADER, PICTURE_SIDE, PIXELS};
use std::io::Read;

/// What the four bytes of a pixel mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelFormat {
    /// `32-bit_rle_rgbe`: red, green, blue and a common exponent; radiance in W/m²sr.
    Rgbe,
    /// `32-bit_rle_xyze`: CIE X, Y, Z and a common exponent; cd/m².
    Xyze,
}

/// Order of the scanlines in a file; Radiance's usual one is `-Y +X`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Orientation {
    /// Scanlines are rows (the first letter of the resolution line is Y); otherwise columns.
    pub y_major: bool,
    /// `+X`: from left to right.
    pub x_increasing: bool,
    /// `+Y`: from bottom to top.
    pub y_increasing: bool,
}

impl Orientation {
    /// `-Y +X`: rows from top to bottom, pixels from left to right.
    pub(crate) const STANDARD: Self = Self { y_major: true, x_increasing: true, y_increasing: false };

    /// Column and row (from the top left) of pixel `along` of scanline `scan` in a picture of
    /// `width` × `height`.
    pub(super) fn place(self, scan: usize, along: usize, width: usize, height: usize) -> (usize, usize) {
        let (x, y) = if self.y_major { (along, scan) } else { (scan, along) };
        (if self.x_increasing { x } else { width - 1 - x }, if self.y_increasing { height - 1 - y } else { y })
    }
}

/// What the header of a picture says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Order of the pixels in the file.
    pub orientation: Orientation,
    /// Meaning of the pixels.
    pub format: PixelFormat,
    /// Product of all EXPOSURE and COLORCORR lines: stored = true × exposure, per channel.
    pub exposure: [f64; 3],
    /// The view options of all lines that state a view ([`View::options_in_header`]), joined: a
    /// later option takes the place of an earlier one.
    pub view: Option<String>,
    /// All lines in their order but the magic number, FORMAT and VIEW, without line ends;
    /// EXPOSURE, COLORCORR and the lines of programs are among them.
    pub lines: Vec<String>,
}

/// Whether a header line scales the pixels.
pub(super) fn is_exposure(line: &str) -> bool {
    line.starts_with("EXPOSURE=") || line.starts_with("COLORCORR=")
}

impl Header {
    /// Reads a header up to and including the resolution line, as Radiance's `getheader` does: any
    /// lines up to an empty one. Neither the magic number nor FORMAT need be there: pictures of
    /// Radiance's first years have none, and are RGBE.
    pub(super) fn read(input: &mut Input<impl Read>) -> Result<Self> {
        let mut magic = false;
        let mut format = None;
        let mut exposure = [1.0; 3];
        let mut view: Vec<String> = Vec::new();
        let mut lines = Vec::new();
        let mut number = 0;
        loop {
            number += 1;
            let line = read_line(input)?.ok_or_else(|| ended(magic || format.is_some(), number))?;
            if line.is_empty() && number > 1 {
                break;
            }
            if number == 1 {
                // `#?RADIANCE` and `#?RGBE` are both in use.
                if line.starts_with("#?") {
                    magic = true;
                    continue;
                }
                if !line.starts_with(|c: char| c.is_ascii_graphic() || c == ' ') {
                    return Err(not_a_picture());
                }
            }
            if let Some(value) = line.strip_prefix("FORMAT=") {
                format = Some(match value.trim() {
                    "32-bit_rle_rgbe" => PixelFormat::Rgbe,
                    "32-bit_rle_xyze" => PixelFormat::Xyze,
                    "" => continue,
                    other => {
                        return Err(Error::new(format!("'{other}' is not a picture format; expected 32-bit_rle_rgbe or 32-bit_rle_xyze"))
                            .line(number)
                            .field("FORMAT"));
                    }
                });
                continue;
            }
            for option in View::options_in_header(&line) {
                // Three letters tell options apart: `-vp`, `-vt` with any kind.
                view.retain(|earlier| earlier.get(..3) != option.get(..3));
                view.push(option);
            }
            if !line.starts_with("VIEW=") {
                multiply_exposure(&line, &mut exposure).map_err(|e| e.line(number))?;
                lines.push(line);
            }
        }
        number += 1;
        let is_named = magic || format.is_some();
        let line = read_line(input)?.ok_or_else(|| ended(is_named, number))?;
        // Only the resolution tells an early picture from any other text.
        let resolution = parse_resolution(&line).map_err(|e| if is_named { e.line(number) } else { not_a_picture() });
        let (width, height, orientation) = resolution?;
        let view = (!view.is_empty()).then(|| view.join(" "));
        Ok(Self { width, height, orientation, format: format.unwrap_or(PixelFormat::Rgbe), exposure, view, lines })
    }

    /// Number of scanlines in the file and pixels in each.
    pub(crate) fn scanlines(&self) -> (usize, usize) {
        if self.orientation.y_major { (self.height, self.width) } else { (self.width, self.height) }
    }
}

/// Text of a header as written by [`super::write`]: magic number, other lines, VIEW, FORMAT, an
/// empty line, the resolution.
pub(super) fn compose(width: usize, height: usize, view: Option<&str>, lines: &[String]) -> Result<String> {
    let mut text = String::from("#?RADIANCE\n");
    let mut add = |line: &str| {
        // A line end inside a line, or an empty line, would end the header early.
        if line.is_empty() || line.contains(['\n', '\r']) {
            return Err(Error::new(format!("header line {line:?} is empty or contains a line end")).help("give header lines one by one"));
        }
        text.push_str(line);
        text.push('\n');
        Ok(())
    };
    for line in lines {
        if line.starts_with("FORMAT=") {
            continue;
        }
        add(line)?;
    }
    if let Some(view) = view {
        add(&format!("VIEW= {}", view.trim()))?;
    }
    add("FORMAT=32-bit_rle_rgbe")?;
    text.push('\n');
    text.push_str(&format!("-Y {height} +X {width}\n"));
    Ok(text)
}

fn not_a_picture() -> Error {
    Error::new("this is not a Radiance picture: it has no header that ends with an empty line and a resolution")
}

fn ended(is_named: bool, line: usize) -> Error {
    if is_named { Error::new("the file ends within its header").line(line) } else { not_a_picture() }
}

/// The next line, without its end (LF or CR LF); `None` if the input ends first.
fn read_line(input: &mut Input<impl Read>) -> Result<Option<String>> {
    let mut bytes = Vec::new();
    loop {
        match input.byte()? {
            Some(b'\n') => return Ok(Some(String::from_utf8_lossy(bytes.strip_suffix(b"\r").unwrap_or(&bytes)).into_owned())),
            Some(b) => bytes.push(b),
            None => return Ok(None),
        }
        if input.offset() > PICTURE_HEADER as u64 {
            return Err(not_a_picture());
        }
    }
}

fn multiply_exposure(line: &str, exposure: &mut [f64; 3]) -> Result<()> {
    if !is_exposure(line) {
        return Ok(());
    }
    let (key, value) = line.split_once('=').unwrap_or((line, ""));
    let bad = || Error::new(format!("'{}' is not a positive factor", value.trim())).field(key);
    // Words behind the numbers are remarks.
    let numbers: Vec<f64> = value.split_whitespace().map_while(|word| word.parse().ok()).collect();
    // Beyond these the pixels themselves would leave the range of f32.
    if !numbers.iter().all(|number| (1e-30..=1e30).contains(number)) {
        return Err(bad());
    }
    match (key, numbers.as_slice()) {
        ("EXPOSURE", [all]) => exposure.iter_mut().for_each(|e| *e *= all),
        ("COLORCORR", [r, g, b]) => exposure.iter_mut().zip([r, g, b]).for_each(|(e, f)| *e *= f),
        _ => return Err(bad().help("EXPOSURE takes one number, COLORCORR three")),
    }
    Ok(())
}

fn parse_resolution(line: &str) -> Result<(usize, usize, Orientation)> {
    let bad = || {
        Error::new(format!("'{}' is no resolution; expected for instance '-Y 480 +X 640'", line.chars().take(60).collect::<String>()))
            .field("resolution")
    };
    // `-Y 480 +X 640`; spaces are free, and what follows is not read.
    let spaced = line.replace('X', "X ").replace('Y', "Y ").replace('+', " +").replace('-', " -");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let [first_axis, first, second_axis, second, ..] = words[..] else { return Err(bad()) };
    let increasing = |axis: &str| match axis.as_bytes().first() {
        Some(b'+') => Ok(true),
        Some(b'-') => Ok(false),
        _ => Err(bad()),
    };
    let y_major = match (first_axis.get(1..), second_axis.get(1..)) {
        (Some("Y"), Some("X")) => true,
        (Some("X"), Some("Y")) => false,
        _ => return Err(bad()),
    };
    let (y_axis, x_axis) = if y_major { (first_axis, second_axis) } else { (second_axis, first_axis) };
    let orientation = Orientation { y_major, x_increasing: increasing(x_axis)?, y_increasing: increasing(y_axis)? };
    let number = |word: &str| {
        if word.is_empty() || !word.bytes().all(|b| b.is_ascii_digit()) {
            return Err(bad());
        }
        // All digits, so that only overflow is left as an error.
        Ok(word.parse::<usize>().unwrap_or(usize::MAX))
    };
    let (first, second) = (number(first)?, number(second)?);
    let (height, width) = if y_major { (first, second) } else { (second, first) };
    if width == 0 || height == 0 {
        return Err(Error::new(format!("a picture of {width} × {height} has no pixels")).field("resolution"));
    }
    if width.max(height) > PICTURE_SIDE {
        return Err(Error::new(format!("a picture of {width} × {height} is longer than {PICTURE_SIDE} pixels")).field("resolution"));
    }
    if width * height > PIXELS {
        return Err(Error::new(format!("a picture of {width} × {height} is larger than {PIXELS} pixels")).field("resolution"));
    }
    Ok((width, height, orientation))
}
