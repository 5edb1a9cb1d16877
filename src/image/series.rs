//! Numbered pictures `name%03d.hdr`: view matrices as component pictures, and one picture per hour.
//!
//! As a matrix, a set has one row per pixel (from the top left, row by row) and one column per
//! picture, as Radiance's `dctimestep` takes it: column 0 is picture 0.

use super::hdr::{self, Exposure, Pause, ScanlineReader};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// A file name with a place for a number, as in C's `printf`: `%d`, `%4d` or `%04d`; `%%` is a
/// percent sign.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    before: String,
    after: String,
    digits: usize,
    fill: char,
    text: String,
}

impl Pattern {
    /// Whether a name has a place for a number, and thus stands for a set of pictures.
    pub fn is_pattern(text: &str) -> bool {
        split(text).is_ok_and(|parts| parts.1.is_some())
    }

    /// Takes a name apart.
    ///
    /// # Errors
    /// If it has no place for a number, more than one, or a conversion of another kind.
    pub fn parse(text: &str) -> Result<Self> {
        let (before, conversion, after) = split(text)?;
        let Some(conversion) = conversion else {
            return Err(Error::new(format!("'{text}' has no place for a number")).help("write for instance img_%04d.hdr"));
        };
        let zero = conversion.starts_with('0');
        let digits = if conversion.is_empty() { 0 } else { conversion.parse().unwrap_or(usize::MAX) };
        if digits > 20 {
            return Err(Error::new(format!("'%{conversion}d' asks for too many digits")).help("write for instance %04d"));
        }
        Ok(Self { before, after, digits, fill: if zero { '0' } else { ' ' }, text: text.to_owned() })
    }

    /// The pattern `name` in a folder, in whose own name a percent sign is one.
    ///
    /// # Errors
    /// As [`parse`](Self::parse) of the name.
    pub fn inside(folder: &Path, name: &str) -> Result<Self> {
        let before = folder.display().to_string().replace('%', "%%");
        Self::parse(&Path::new(&before).join(name).display().to_string())
    }

    /// The file of a number.
    pub fn path(&self, number: usize) -> PathBuf {
        let digits = number.to_string();
        let fill: String = std::iter::repeat_n(self.fill, self.digits.saturating_sub(digits.len())).collect();
        PathBuf::from(format!("{}{fill}{digits}{}", self.before, self.after))
    }

    /// Numbers for which files exist, rising.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn existing(&self) -> Result<Vec<usize>> {
        let sample = self.path(0);
        let folder = match sample.parent() {
            Some(p) if !p.as_os_str().is_empty() => p.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let name_of = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        // The number is normally in the name; in a folder's name, files are tried one by one.
        let (Some(start), true) = (self.before.rsplit(['/', '\\']).next(), !self.after.contains(['/', '\\'])) else {
            return Ok((0..).take_while(|&n| self.path(n).exists()).collect());
        };
        let entries = std::fs::read_dir(&folder).map_err(|e| Error::io(&folder, &e))?;
        let mut numbers = Vec::new();
        for entry in entries {
            let name = name_of(&entry.map_err(|e| Error::io(&folder, &e))?.path());
            let number = name.strip_prefix(start).and_then(|n| n.strip_suffix(&*self.after)).and_then(|n| n.trim_start().parse().ok());
            if let Some(number) = number.filter(|&n| name_of(&self.path(n)) == name) {
                numbers.push(number);
            }
        }
        numbers.sort_unstable();
        Ok(numbers)
    }
}

impl std::fmt::Display for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

/// What stands before the number, its conversion without `%` and `d` if there is one, and what
/// stands after.
fn split(text: &str) -> Result<(String, Option<String>, String)> {
    let mut parts = [String::new(), String::new()];
    let mut conversion = None;
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        let part = &mut parts[usize::from(conversion.is_some())];
        if c != '%' {
            part.push(c);
            continue;
        }
        if rest.as_str().starts_with('%') {
            rest.next();
            part.push('%');
            continue;
        }
        let width: String = rest.as_str().chars().take_while(char::is_ascii_digit).collect();
        let kind = rest.nth(width.len());
        if !matches!(kind, Some('d' | 'i' | 'u')) {
            return Err(Error::new(format!("'{text}' has a % that is not followed by a number of digits and d"))
                .help("write for instance %04d, or %% for a percent sign"));
        }
        if conversion.replace(width).is_some() {
            return Err(Error::new(format!("'{text}' has two places for numbers")).help("leave one of them, as in img_%04d.hdr"));
        }
    }
    let [before, after] = parts;
    Ok((before, conversion, after))
}

/// A complete set of component pictures 0, 1, … of one size.
#[derive(Debug, Clone)]
pub struct PictureSet {
    paths: Vec<PathBuf>,
    starts: Vec<Pause>,
    width: usize,
    height: usize,
    view: Option<String>,
}

impl PictureSet {
    /// Reads the headers of all pictures of a pattern. With `count`, exactly as many must be there.
    ///
    /// # Errors
    /// No picture, a gap in the numbers, another number of pictures than wanted, different sizes,
    /// scanlines in an unusual order, or a file that is no picture.
    pub fn open(pattern: &Pattern, count: Option<usize>, exposure: Exposure) -> Result<Self> {
        let numbers = pattern.existing()?;
        let Some(&last) = numbers.last() else {
            return Err(Error::new(format!("there are no pictures {pattern}, the first should be {}", pattern.path(0).display())));
        };
        if let Some(gap) = (0..=last).zip(&numbers).find_map(|(wanted, &found)| (wanted != found).then_some(wanted)) {
            return Err(Error::new(format!("{} is missing, but there is {}", pattern.path(gap).display(), pattern.path(last).display()))
                .help("the pictures of a set are numbered from 0 without gaps"));
        }
        if let Some(count) = count.filter(|&c| c != numbers.len()) {
            return Err(Error::new(format!("{pattern} has {} pictures instead of {count}", numbers.len()))
                .help("a view matrix has one picture per direction of the window's basis, 145 for Klems full"));
        }
        let paths: Vec<PathBuf> = numbers.iter().map(|&n| pattern.path(n)).collect();
        let starts: Vec<Pause> =
            paths.iter().map(|p| ScanlineReader::open(p, exposure).map(ScanlineReader::pause)).collect::<Result<_>>()?;
        let first = starts[0].header();
        let (width, height, view) = (first.width, first.height, first.view.clone());
        for (path, start) in paths.iter().zip(&starts) {
            let header = start.header();
            if (header.width, header.height) != (width, height) {
                return Err(Error::new(format!(
                    "it has {} × {} pixels, but {} has {width} × {height}",
                    header.width,
                    header.height,
                    paths[0].display()
                ))
                .file(path));
            }
            if header.orientation != hdr::Orientation::STANDARD {
                return Err(Error::new("its scanlines are not in the order -Y +X")
                    .file(path)
                    .help("turn it with Radiance's pflip or protate"));
            }
        }
        Ok(Self { paths, starts, width, height, view })
    }

    /// Number of pictures.
    #[expect(clippy::len_without_is_empty, reason = "a set is never empty")]
    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Pixels per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// View of the first picture as Radiance options.
    pub fn view(&self) -> Option<&str> {
        self.view.as_deref()
    }

    /// Starts reading from the top.
    pub fn rows(&self) -> SetRows<'_> {
        SetRows { set: self, places: self.starts.clone(), next: 0 }
    }
}

/// Reads a [`PictureSet`] a few rows of pixels at a time, so that no matrix is in memory as a whole.
#[derive(Debug)]
pub struct SetRows<'a> {
    set: &'a PictureSet,
    places: Vec<Pause>,
    next: usize,
}

impl SetRows<'_> {
    /// First row of pixels not yet read.
    pub fn next_row(&self) -> usize {
        self.next
    }

    /// Reads the next `rows` rows of pixels (fewer at the end) as rows of a matrix:
    /// `out[(pixel * pictures + picture) * 3 + component]`. Gives the number of rows of pixels
    /// read; 0 after the last.
    ///
    /// # Errors
    /// If a file is truncated, damaged or gone.
    pub fn read(&mut self, rows: usize, out: &mut Vec<f32>) -> Result<usize> {
        let rows = rows.min(self.set.height - self.next);
        let (width, count) = (self.set.width, self.set.len());
        let pixels = rows * width;
        out.clear();
        out.resize(pixels * count * 3, 0.0);
        if rows == 0 {
            return Ok(0);
        }
        // A bounded number of pictures at a time: their rows are decoded in parallel, then laid
        // into the matrix.
        let group = (16 * rayon::current_num_threads()).min(count);
        for first in (0..count).step_by(group) {
            let last = (first + group).min(count);
            let decoded: Vec<Vec<[f32; 3]>> = self.places[first..last]
                .par_iter_mut()
                .zip(&self.set.paths[first..last])
                .map(|(place, path)| {
                    let mut reader = place.resume(path)?;
                    let mut buffer = vec![[0f32; 3]; pixels];
                    buffer.chunks_exact_mut(width).try_for_each(|row| reader.read(row))?;
                    *place = reader.pause();
                    Ok(buffer)
                })
                .collect::<Result<_>>()?;
            out.par_chunks_exact_mut(count * 3).enumerate().for_each(|(pixel, row)| {
                for (target, picture) in row[first * 3..last * 3].chunks_exact_mut(3).zip(&decoded) {
                    target.copy_from_slice(&picture[pixel]);
                }
            });
        }
        self.next += rows;
        Ok(rows)
    }
}

/// Writes a matrix of pixels × pictures, given a few rows of pixels at a time, as numbered
/// pictures. All files appear at the end, or none.
pub struct SetWriter {
    writers: Vec<hdr::ScanlineWriter<crate::files::AtomicFile>>,
    width: usize,
}

impl SetWriter {
    /// Creates `count` pictures numbered from 0; `lines` gives the header lines of each.
    ///
    /// # Errors
    /// Failures of the file system, among them too many open files.
    pub fn create(
        pattern: &Pattern,
        count: usize,
        [width, height]: [usize; 2],
        view: Option<&str>,
        lines: impl Fn(usize) -> Vec<String>,
    ) -> Result<Self> {
        let writers = (0..count).map(|n| hdr::create(&pattern.path(n), width, height, view, &lines(n))).collect::<Result<_>>()?;
        Ok(Self { writers, width })
    }

    /// Writes rows of pixels: `values[(pixel * pictures + picture) * 3 + component]`.
    ///
    /// # Errors
    /// If a value is not finite or writing fails.
    ///
    /// # Panics
    /// If the values are not whole rows.
    pub fn write(&mut self, values: &[f32]) -> Result<()> {
        let (count, width) = (self.writers.len(), self.width);
        assert_eq!(values.len() % (width * count * 3), 0, "whole rows of pixels");
        self.writers.par_iter_mut().enumerate().try_for_each(|(picture, writer)| {
            let mut row = vec![[0f32; 3]; width];
            for line in values.chunks_exact(width * count * 3) {
                for (pixel, all) in row.iter_mut().zip(line.chunks_exact(count * 3)) {
                    pixel.copy_from_slice(&all[picture * 3..][..3]);
                }
                writer.write(&row)?;
            }
            Ok(())
        })
    }

    /// Completes all pictures.
    ///
    /// # Errors
    /// If rows are missing or the file system fails.
    pub fn finish(self) -> Result<()> {
        let files = self.writers.into_iter().map(hdr::ScanlineWriter::finish).collect::<Result<Vec<_>>>()?;
        files.into_iter().try_for_each(crate::files::AtomicFile::commit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Picture;
    use crate::testing::{output, radiance};

    #[test]
    fn patterns() {
        let name = |pattern: &str, n: usize| Pattern::parse(pattern).unwrap().path(n).to_string_lossy().into_owned();
        assert_eq!(name("v%03d.hdr", 7), "v007.hdr");
        assert_eq!(name("dir/img_%04d.hdr", 12345), "dir/img_12345.hdr");
        assert_eq!(name("%d", 0), "0");
        assert_eq!(name("a%3db%%c.hdr", 5), "a  5b%c.hdr");
        assert!(Pattern::is_pattern("v%d.hdr") && !Pattern::is_pattern("v.hdr") && !Pattern::is_pattern("100%%.hdr"));
        for bad in ["v.hdr", "v%s.hdr", "v%", "v%3", "v%d%d.hdr", "v%999999999999999999999999d.hdr", "v%-3d"] {
            assert!(Pattern::parse(bad).is_err(), "{bad}");
        }
    }

    fn component(n: usize, width: usize, height: usize) -> Picture {
        let pixels = (0..width * height).map(|i| [n as f32 + 0.5, i as f32 + 1.0, (n * i) as f32]).collect();
        let mut picture = Picture::new(width, height, pixels).unwrap();
        picture.view = Some("-vta -vh 180 -vv 180".into());
        picture
    }

    fn pattern(folder: &tempfile::TempDir) -> Pattern {
        Pattern::parse(&folder.path().join("v%02d.hdr").to_string_lossy()).unwrap()
    }

    #[test]
    fn a_set_is_a_matrix_in_any_tiling() {
        let folder = tempfile::tempdir().unwrap();
        let pattern = pattern(&folder);
        let (width, height, count) = (21, 10, 35);
        for n in 0..count {
            hdr::write(&pattern.path(n), &component(n, width, height)).unwrap();
        }
        let set = PictureSet::open(&pattern, Some(count), Exposure::Undo).unwrap();
        assert_eq!((set.len(), set.width(), set.height(), set.view()), (count, width, height, Some("-vta -vh 180 -vv 180")));
        let read = |rows: usize| {
            let (mut all, mut block, mut stream) = (Vec::new(), Vec::new(), set.rows());
            while stream.read(rows, &mut block).unwrap() > 0 {
                all.extend_from_slice(&block);
            }
            all
        };
        let whole = read(100);
        assert_eq!(whole.len(), width * height * count * 3);
        assert_eq!(read(3), whole);
        for n in [0, 7, 34] {
            let picture = hdr::read(&pattern.path(n)).unwrap();
            for (pixel, values) in picture.pixels.iter().enumerate() {
                assert_eq!(whole[(pixel * count + n) * 3..][..3], *values);
            }
        }
        // And back again, in other tiles: the same bytes.
        let copy = Pattern::parse(&folder.path().join("copy%d.hdr").to_string_lossy()).unwrap();
        let mut writer = SetWriter::create(&copy, count, [width, height], set.view(), |_| Vec::new()).unwrap();
        for rows in whole.chunks(width * count * 3 * 4) {
            writer.write(rows).unwrap();
        }
        assert!(copy.existing().unwrap().is_empty(), "nothing before the end");
        writer.finish().unwrap();
        for n in 0..count {
            assert_eq!(std::fs::read(copy.path(n)).unwrap(), std::fs::read(pattern.path(n)).unwrap());
        }
        let mut writer = SetWriter::create(&copy, 3, [width, height], None, |_| Vec::new()).unwrap();
        writer.write(&vec![1.0; width * 9]).unwrap();
        assert!(writer.finish().unwrap_err().to_string().contains("1 of 10 rows"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2 * count, "no partial files");
    }

    #[test]
    fn incomplete_sets_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let pattern = pattern(&folder);
        let open = |count| PictureSet::open(&pattern, count, Exposure::Undo).map(|_| ()).map_err(|e| e.to_string());
        assert!(open(None).unwrap_err().contains("v00.hdr"));
        for n in [0, 1, 3] {
            hdr::write(&pattern.path(n), &component(n, 20, 4)).unwrap();
        }
        std::fs::write(folder.path().join("v2.hdr"), "another pattern").unwrap();
        assert!(open(None).unwrap_err().contains("v02.hdr is missing"));
        hdr::write(&pattern.path(2), &component(2, 4, 20)).unwrap();
        assert!(open(None).unwrap_err().contains("4 × 20 pixels"));
        hdr::write(&pattern.path(2), &component(2, 20, 4)).unwrap();
        open(None).unwrap();
        assert!(open(Some(145)).unwrap_err().contains("4 pictures instead of 145"));
        let bytes = std::fs::read(pattern.path(2)).unwrap();
        std::fs::write(pattern.path(2), &bytes[..bytes.len() - 5]).unwrap();
        let set = PictureSet::open(&pattern, None, Exposure::Undo).unwrap();
        let error = set.rows().read(4, &mut Vec::new()).unwrap_err().to_string();
        assert!(error.contains("v02.hdr") && error.contains("scanline 4 of 4"), "{error}");
        let text = String::from_utf8_lossy(&bytes).replace("-Y 4 +X 20", "-Y 4 -X 20");
        assert!(text.contains("-X 20"));
        std::fs::write(pattern.path(2), text.as_bytes()).unwrap();
        assert!(open(None).unwrap_err().contains("-Y +X"));
    }

    /// The set as a view matrix gives the picture that dctimestep makes of it.
    #[test]
    fn the_matrix_is_dctimesteps() {
        let folder = tempfile::tempdir().unwrap();
        let pattern = pattern(&folder);
        for n in 0..5 {
            hdr::write(&pattern.path(n), &component(n, 24, 6)).unwrap();
        }
        let weights = [0.25f32, 0.0, 1.5, 3.0, 0.125];
        let text: String = weights.iter().map(|w| format!("{w} {} {}\n", 2.0 * w, 0.5 * w)).collect();
        let sky = folder.path().join("sky.mtx");
        std::fs::write(&sky, format!("#?RADIANCE\nNROWS=5\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n{text}")).unwrap();
        let Some(mut dctimestep) = radiance("dctimestep") else { return };
        let theirs = hdr::decode(&output(dctimestep.arg(pattern.to_string()).arg(&sky)), Exposure::Undo).unwrap();
        let mut matrix = Vec::new();
        let set = PictureSet::open(&pattern, None, Exposure::Keep).unwrap();
        assert_eq!(set.rows().read(6, &mut matrix).unwrap(), 6);
        let pixels = matrix
            .chunks_exact(15)
            .map(|row| {
                let mut sum = [0.0; 3];
                for (v, w) in row.chunks_exact(3).zip(weights) {
                    sum = [sum[0] + v[0] * w, sum[1] + v[1] * 2.0 * w, sum[2] + v[2] * 0.5 * w];
                }
                sum
            })
            .collect();
        let ours = hdr::decode(&hdr::encode(&Picture::new(24, 6, pixels).unwrap()).unwrap(), Exposure::Undo).unwrap();
        for (a, b) in ours.pixels.iter().zip(&theirs.pixels) {
            let step = a[0].max(a[1]).max(a[2]) / 128.0;
            // Sums in another order may fall on the other side of one mantissa step.
            assert!((0..3).all(|i| (a[i] - b[i]).abs() <= step), "{a:?} {b:?}");
        }
        let same = ours.pixels.iter().zip(&theirs.pixels).filter(|(a, b)| a == b).count();
        assert!(same >= 140, "{same} of 144 pixels are identical");
    }
}
