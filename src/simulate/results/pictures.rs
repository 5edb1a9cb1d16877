//! Pictures of many hours from a view matrix of pixels: V · (T·D·S), one picture per column,
//! streamed.
//!
//! ```text
//! V (file or pictures) ──reader──▶ rows of pixels ──product──▶ [hour][pixel][rgb] ──▶ one file per hour
//! ```
//!
//! The three stages overlap. Hours are taken in passes and pixels in bands of whole rows, sized by
//! the memory allowed; V is read once if it fits, else once per pass. Pictures appear under their
//! names when a pass is complete: after an error those of earlier passes are there, whole, and
//! nothing else.

use crate::error::{Error, Result, Warnings};
use crate::files::AtomicFile;
use crate::gpu::Plan;
use crate::image::Picture;
use crate::image::exr;
use crate::image::hdr::{self, Exposure, ScanlineWriter};
use crate::image::series::{Pattern, PictureSet, SetRows};
use crate::kernels::glare::PixelSource;
use crate::kernels::product::{Arrangement, Factor, Multiplier};
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::matrix::rows::MatrixRows;
use crate::progress::{Progress, cancelled};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

const RGB: usize = 3;
/// Bytes of a pixel in memory.
const PIXEL_BYTES: u64 = (RGB * size_of::<f32>()) as u64;
/// Most hours in a pass: each keeps a file open.
const MOST_HOURS: usize = 200;
/// Rows of pixels in a band, if memory allows: enough for the product to be efficient, few enough
/// for the stages to overlap.
const BAND_PIXELS: usize = 1 << 15;

/// A view matrix with one row per pixel, from the top left, row by row.
pub struct PictureView {
    /// Name in messages.
    name: String,
    source: Source,
    /// Where a [`PixelSource`] goes on in a matrix in memory.
    next_row: usize,
    /// Pixels per row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Columns: bins of the window.
    pub bins: usize,
    /// View as Radiance options, if the files tell.
    pub view: Option<String>,
}

enum Source {
    Matrix(Matrix<f32>),
    Rows(MatrixRows),
    Pictures(PictureSet),
    /// V and its straight part Vd: rows V − Vd, then Vd.
    Split(Box<[MatrixRows; 2]>),
}

impl PictureView {
    /// Opens a view matrix: a pattern of component pictures (`v%03d.hdr`), whose EXPOSURE is undone,
    /// or a matrix file, whose header says `RESOLUTION=-Y height +X width` and perhaps `VIEW=`.
    /// `size` (width, height) is for matrices whose header has no resolution.
    ///
    /// # Errors
    /// Files that cannot be read, gaps and different sizes among the pictures, a missing resolution
    /// or one that does not fit the number of rows.
    pub fn open(name: &str, size: Option<[usize; 2]>) -> Result<Self> {
        if Pattern::is_pattern(name) {
            let set = PictureSet::open(&Pattern::parse(name)?, None, Exposure::Undo)?;
            let (width, height, bins, view) = (set.width(), set.height(), set.len(), set.view().map(str::to_string));
            return Ok(Self { name: name.into(), source: Source::Pictures(set), next_row: 0, width, height, bins, view });
        }
        Self::open_matrix(Path::new(name), size)
    }

    /// Opens a matrix file, whatever its name or that of a folder looks like.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_matrix(path: &Path, size: Option<[usize; 2]>) -> Result<Self> {
        let rows = if path == Path::new("-") { None } else { MatrixRows::open(path)? };
        let (source, header, rows, bins, components) = match rows {
            Some(r) => {
                let (header, rows, cols, components) = (r.header().to_vec(), r.rows(), r.cols(), r.components());
                (Source::Rows(r), header, rows, cols, components)
            }
            None => {
                let file = read_matrix(path)?;
                let (rows, cols, components) = (file.matrix.rows(), file.matrix.cols(), file.matrix.components());
                (Source::Matrix(file.matrix), file.header, rows, cols, components)
            }
        };
        if components != RGB {
            return Err(Error::new(format!("a view matrix of pictures has 3 components, this one has {components}"))
                .file(path)
                .field("NCOMP"));
        }
        let value = |key: &str| header.iter().rev().find_map(|l| l.strip_prefix(key)?.strip_prefix('=')).map(str::trim);
        let stated = value("RESOLUTION").map(|text| resolution(text).map_err(|e| e.file(path))).transpose()?;
        let [width, height] = stated.or(size).ok_or_else(|| {
            Error::new("the header does not tell the size of the pictures")
                .file(path)
                .field("RESOLUTION")
                .help("make V with 'lucarne matrix view --view', or give the size with -x and -y")
        })?;
        if width.checked_mul(height) != Some(rows) {
            return Err(Error::new(format!("pictures of {width} × {height} pixels need as many rows, there are {rows}"))
                .file(path)
                .field(if stated.is_some() { "RESOLUTION" } else { "-x, -y" }));
        }
        let view = value("VIEW").map(str::to_string);
        Ok(Self { name: path.display().to_string(), source, next_row: 0, width, height, bins, view })
    }

    /// Opens a view matrix and its straight part, both files of this program with the same shape: a
    /// matrix of twice the columns, V − Vd and Vd.
    ///
    /// # Errors
    /// As [`open`](Self::open), and files of different shapes.
    pub fn open_split(total: &Path, direct: &Path) -> Result<Self> {
        let Self { name, source, width, height, bins, view, .. } = Self::open_matrix(total, None)?;
        let rows = MatrixRows::open(direct)?.filter(|r| (r.rows(), r.cols(), r.components()) == (width * height, bins, RGB));
        let (Source::Rows(total), Some(direct)) = (source, rows) else {
            return Err(Error::new("the straight part of a view matrix has not the shape of the whole").file(direct));
        };
        Ok(Self { name, source: Source::Split(Box::new([total, direct])), next_row: 0, width, height, bins: 2 * bins, view })
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Name in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn reader(&mut self) -> Result<Reader<'_>> {
        Ok(match &mut self.source {
            Source::Matrix(matrix) => Reader::Matrix(matrix, 0),
            Source::Rows(rows) => {
                rows.rewind()?;
                Reader::Rows(rows)
            }
            Source::Pictures(set) => Reader::Pictures(set.rows()),
            Source::Split(both) => {
                both.iter_mut().try_for_each(MatrixRows::rewind)?;
                Reader::Split(both)
            }
        })
    }
}

impl PixelSource for PictureView {
    fn bins(&self) -> usize {
        self.bins
    }

    fn rewind(&mut self) -> Result<()> {
        self.next_row = 0;
        match &mut self.source {
            Source::Rows(rows) => rows.rewind(),
            Source::Split(both) => both.iter_mut().try_for_each(MatrixRows::rewind),
            Source::Matrix(_) | Source::Pictures(_) => Ok(()),
        }
    }

    fn read(&mut self, lines: usize, width: usize, values: &mut Vec<f32>) -> Result<()> {
        match &mut self.source {
            Source::Matrix(matrix) => {
                let row = matrix.cols() * RGB;
                let end = (self.next_row + lines * width).min(matrix.rows());
                values.clear();
                values.extend_from_slice(&matrix.data()[self.next_row * row..end * row]);
                self.next_row = end;
            }
            Source::Rows(rows) => {
                rows.read(lines * width, values)?;
            }
            Source::Split(both) => read_split(both, lines * width, values)?,
            Source::Pictures(_) => {
                return Err(Error::new("glare is not computed from component pictures").file(&self.name));
            }
        }
        Ok(())
    }
}

/// `-Y height +X width`, the only order of pixels a matrix may have.
fn resolution(text: &str) -> Result<[usize; 2]> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let size = match words[..] {
        ["-Y", height, "+X", width] => width.parse().ok().zip(height.parse().ok()).filter(|(w, h)| *w > 0 && *h > 0),
        _ => None,
    };
    size.map(|(width, height)| [width, height]).ok_or_else(|| {
        Error::new(format!("'{text}' is no resolution")).field("RESOLUTION").help("write for instance RESOLUTION=-Y 256 +X 256")
    })
}

/// Reads V from the top.
enum Reader<'a> {
    Matrix(&'a Matrix<f32>, usize),
    Rows(&'a mut MatrixRows),
    Pictures(SetRows<'a>),
    Split(&'a mut [MatrixRows; 2]),
}

impl Reader<'_> {
    /// The next `lines` rows of pixels, `[pixel][bin][rgb]`.
    fn read(&mut self, lines: usize, width: usize) -> Result<Vec<f32>> {
        let mut values = Vec::new();
        match self {
            Reader::Matrix(matrix, next) => {
                let row = matrix.cols() * RGB;
                let count = (lines * width).min(matrix.rows() - *next);
                values.extend_from_slice(&matrix.data()[*next * row..(*next + count) * row]);
                *next += count;
            }
            Reader::Rows(rows) => {
                rows.read(lines * width, &mut values)?;
            }
            Reader::Pictures(rows) => {
                rows.read(lines, &mut values)?;
            }
            Reader::Split(both) => read_split(both, lines * width, &mut values)?,
        }
        Ok(values)
    }
}

/// The next rows of V − Vd and Vd, side by side.
fn read_split([total, direct]: &mut [MatrixRows; 2], count: usize, values: &mut Vec<f32>) -> Result<()> {
    let (mut all, mut straight) = (Vec::new(), Vec::new());
    total.read(count, &mut all)?;
    direct.read(count, &mut straight)?;
    let row = total.cols() * RGB;
    values.clear();
    values.reserve(2 * all.len());
    for (all, straight) in all.chunks_exact(row).zip(straight.chunks_exact(row)) {
        values.extend(all.iter().zip(straight).map(|(a, s)| (a - s).max(0.0)));
        values.extend_from_slice(straight);
    }
    Ok(())
}

/// Where the pictures go.
#[derive(Debug, Clone)]
pub enum Output {
    /// Radiance pictures, one per hour.
    Hdr(Pattern),
    /// OpenEXR pictures, one per hour.
    Exr(Pattern, exr::Options),
    /// One OpenEXR file with a part `hour_‹number›` per hour.
    ExrParts(PathBuf, exr::Options),
}

impl Output {
    /// The output that a file name means: a pattern or file ending in `.exr`, or a pattern for
    /// Radiance pictures of any other ending.
    ///
    /// # Errors
    /// A name without a place for the hour that is no `.exr` file.
    pub fn parse(name: &str, options: exr::Options) -> Result<Self> {
        let is_exr = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        match (Pattern::is_pattern(name), is_exr) {
            (true, true) => Ok(Output::Exr(Pattern::parse(name)?, options)),
            (true, false) => Ok(Output::Hdr(Pattern::parse(name)?)),
            (false, true) => Ok(Output::ExrParts(name.into(), options)),
            (false, false) => {
                Err(Error::new(format!("'{name}' has no place for the hour")).field("-o").help("write for instance -o img_%04d.hdr"))
            }
        }
    }

    /// Whether whole pictures have to be in memory until they are written.
    fn needs_whole_pictures(&self) -> bool {
        !matches!(self, Output::Hdr(_))
    }
}

/// What to make of a view matrix.
pub struct Request<'a> {
    /// T·D·S or DC·S: `[bin][hour]`, RGB.
    pub coefficients: &'a Matrix<f32>,
    /// Number of each column, for file names.
    pub hours: &'a [usize],
    /// Where the pictures go.
    pub output: &'a Output,
    /// Header lines of all pictures.
    pub header: &'a [String],
    /// Memory for matrices and pictures, bytes.
    pub memory: u64,
    /// What comes on top of the product.
    pub addition: Option<&'a Addition<'a>>,
}

/// A sparse picture for an hour, by its number: pixels in rising order, and RGB radiance.
pub type Addition<'a> = dyn Fn(usize) -> Result<Vec<(u32, [f32; 3])>> + Sync + 'a;

/// Makes one picture per column of the coefficients and writes it.
///
/// # Errors
/// Shapes that do not fit, too little memory, failures of device and file system, and
/// [`cancelled`]. Pictures of finished passes stay.
pub fn write_pictures(
    multiplier: &dyn Multiplier,
    view: &mut PictureView,
    request: &Request,
    progress: &dyn Progress,
    warnings: &mut Warnings,
) -> Result<()> {
    let Request { coefficients, hours, output, .. } = *request;
    if view.bins != coefficients.rows() {
        return Err(Error::new(format!("'{}' has {} columns (pictures), but {} are needed", view.name, view.bins, coefficients.rows())));
    }
    assert_eq!((coefficients.cols(), coefficients.components()), (hours.len(), RGB), "one RGB column per hour");
    if hours.is_empty() {
        return Ok(());
    }
    let sizes = Sizes::new(multiplier, view, request)?;
    let [width, height] = [view.width, view.height];
    let title = view.view.clone();
    match output {
        Output::Hdr(pattern) => {
            let mut sinks = HdrFiles { pattern, width, height, view: title, header: request.header };
            passes(multiplier, view, request, &sizes, progress, &mut sinks)
        }
        Output::Exr(pattern, options) => {
            let mut done = |number: usize, pixels: Vec<[f32; 3]>| {
                let mut picture = Picture::new(width, height, pixels)?;
                picture.view.clone_from(&title);
                picture.header = request.header.to_vec();
                exr::write(&pattern.path(number), &picture, *options, warnings)
            };
            passes(multiplier, view, request, &sizes, progress, &mut Whole { pixels: width * height, done: &mut done })
        }
        Output::ExrParts(path, options) => {
            let names = hours.iter().map(|hour| format!("hour_{hour:04}")).collect();
            let parts = exr::Parts { width, height, view: title, header: request.header.to_vec(), names };
            exr::write_parts(path, &parts, *options, warnings, |put| {
                let mut done = |_: usize, pixels: Vec<[f32; 3]>| put(&pixels);
                passes(multiplier, view, request, &sizes, progress, &mut Whole { pixels: width * height, done: &mut done })
            })
        }
    }
}

/// How the work is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Sizes {
    /// Hours per pass.
    hours: usize,
    /// Rows of pixels per band.
    lines: usize,
    /// Whether V stays in memory for all passes.
    keep: bool,
}

impl Sizes {
    fn new(multiplier: &dyn Multiplier, view: &PictureView, request: &Request) -> Result<Self> {
        let (width, height, bins) = (view.width, view.height, view.bins);
        // V as read, and as the multiplier keeps it.
        let row_bytes = |rows: usize| rows as u64 * bins as u64 * PIXEL_BYTES + multiplier.device_bytes(rows, bins, RGB);
        let whole = if request.output.needs_whole_pictures() { view.pixels() as u64 * PIXEL_BYTES } else { 1 << 17 };
        Self::within(request.memory, [width, height], request.hours.len(), row_bytes(width), whole)
    }

    /// `line_bytes` is V for a row of pixels, `sink_bytes` what an hour keeps until it is written.
    fn within(memory: u64, [width, height]: [usize; 2], hours: usize, line_bytes: u64, sink_bytes: u64) -> Result<Self> {
        let too_little = |e: Error| e.field("--memory");
        // Half the memory for sinks and bands of results, half for V.
        let hours = Plan::within(u64::MAX, memory / 4, hours, &[sink_bytes], &[], 1).map_err(too_little)?.rows_per_chunk().min(MOST_HOURS);
        // A band is read while one is multiplied and one written; of results there are three.
        let result_bytes = 3 * width as u64 * hours as u64 * PIXEL_BYTES;
        let all = line_bytes * height as u64;
        let keep = all <= memory / 2;
        let fixed = if keep { all } else { 0 };
        let per_line = if keep { result_bytes } else { result_bytes + 3 * line_bytes };
        let budget = memory - memory / 4;
        let plan = Plan::within(u64::MAX, budget, height, &[per_line], &[fixed], 1).map_err(too_little)?;
        let lines = plan.rows_per_chunk().min(BAND_PIXELS.div_ceil(width)).max(1);
        Ok(Self { hours, lines, keep })
    }
}

/// Takes the results of a pass, band by band.
trait Sinks {
    /// Prepares for the hours of a pass.
    fn begin(&mut self, numbers: &[usize]) -> Result<Vec<Sink>>;
    /// Completes the pictures of a pass, in order.
    fn end(&mut self, numbers: &[usize], sinks: Vec<Sink>) -> Result<()>;
}

/// One picture in the making.
enum Sink {
    File(Box<ScanlineWriter<AtomicFile>>),
    Pixels(Vec<[f32; 3]>),
}

struct HdrFiles<'a> {
    pattern: &'a Pattern,
    width: usize,
    height: usize,
    view: Option<String>,
    header: &'a [String],
}

impl Sinks for HdrFiles<'_> {
    fn begin(&mut self, numbers: &[usize]) -> Result<Vec<Sink>> {
        let create = |n: &usize| hdr::create(&self.pattern.path(*n), self.width, self.height, self.view.as_deref(), self.header);
        numbers.iter().map(|n| Ok(Sink::File(Box::new(create(n)?)))).collect()
    }

    fn end(&mut self, _numbers: &[usize], sinks: Vec<Sink>) -> Result<()> {
        for sink in sinks {
            if let Sink::File(writer) = sink {
                writer.finish()?.commit()?;
            }
        }
        Ok(())
    }
}

struct Whole<'a> {
    pixels: usize,
    done: &'a mut dyn FnMut(usize, Vec<[f32; 3]>) -> Result<()>,
}

impl Sinks for Whole<'_> {
    fn begin(&mut self, numbers: &[usize]) -> Result<Vec<Sink>> {
        Ok(numbers.iter().map(|_| Sink::Pixels(Vec::with_capacity(self.pixels))).collect())
    }

    fn end(&mut self, numbers: &[usize], sinks: Vec<Sink>) -> Result<()> {
        for (number, sink) in numbers.iter().zip(sinks) {
            if let Sink::Pixels(pixels) = sink {
                (self.done)(*number, pixels)?;
            }
        }
        Ok(())
    }
}

/// V of a band of rows, ready to multiply.
struct Band {
    pixels: usize,
    /// Pixels that the factor has, in order, if it leaves out those that see no window.
    lit: Option<Vec<u32>>,
    factor: Factor<'static>,
}

/// Results of a band: `[hour][pixel of the factor]`.
struct Piece {
    pixels: usize,
    lit: Option<Vec<u32>>,
    values: Vec<f32>,
}

/// All hours, pass by pass.
fn passes(
    multiplier: &dyn Multiplier,
    view: &mut PictureView,
    request: &Request,
    sizes: &Sizes,
    progress: &dyn Progress,
    sinks: &mut dyn Sinks,
) -> Result<()> {
    let coefficients = request.coefficients;
    let right = multiplier.right(coefficients.rows(), coefficients.cols(), RGB, coefficients.data().into())?;
    let bands = view.height.div_ceil(sizes.lines);
    let total = (request.hours.len().div_ceil(sizes.hours) * bands) as f64;
    let mut kept: Vec<Band> = Vec::new();
    for (pass, numbers) in request.hours.chunks(sizes.hours).enumerate() {
        let first = pass * sizes.hours;
        let mut open = sinks.begin(numbers)?;
        let (width, height, bins) = (view.width, view.height, view.bins);
        let resident = kept.len() == bands;
        let mut reader = if resident { None } else { Some(view.reader()?) };
        let kept = &mut kept;
        let right = &right;
        std::thread::scope(|scope| -> Result<()> {
            // Bands of V come from a thread of their own, results go to this one.
            let (give_band, take_band) = sync_channel::<Result<Vec<f32>>>(1);
            let (give_piece, take_piece) = sync_channel::<Result<Piece>>(1);
            if let Some(reader) = reader.take() {
                scope.spawn(move || read_bands(reader, height, sizes.lines, width, &give_band));
            }
            scope.spawn(move || {
                let multiply = |band: &Band| {
                    let mut values = vec![0.0; band.factor.outer() * numbers.len() * RGB];
                    multiplier.multiply(&band.factor, right, first, numbers.len(), Arrangement::Columns, &mut values)?;
                    Ok(Piece { pixels: band.pixels, lit: band.lit.clone(), values })
                };
                if resident {
                    // A closed channel means that the other side met an error, which it reports.
                    let _ = kept.iter().try_for_each(|band| give_piece.send(multiply(band)));
                    return;
                }
                for values in take_band {
                    let band = values.and_then(|values| ready(multiplier, bins, values));
                    let piece = band.and_then(|band| {
                        let piece = multiply(&band)?;
                        if sizes.keep {
                            kept.push(band);
                        }
                        Ok(piece)
                    });
                    if give_piece.send(piece).is_err() {
                        return;
                    }
                }
            });
            let adder = Adder { addition: request.addition, numbers };
            collect(
                &take_piece,
                &mut open,
                width,
                &adder,
                &|done| progress.update("pictures", ((pass * bands + done) as f64) / total),
                progress,
            )
        })?;
        sinks.end(numbers, open)?;
    }
    Ok(())
}

fn read_bands(mut reader: Reader, height: usize, lines: usize, width: usize, give: &SyncSender<Result<Vec<f32>>>) {
    for first in (0..height).step_by(lines) {
        let band = reader.read(lines.min(height - first), width);
        let failed = band.is_err();
        if give.send(band).is_err() || failed {
            return;
        }
    }
}

/// Makes a band ready: pixels whose coefficients are all zero (outside a fisheye's circle, without
/// sight of the window) are left out if they are more than a few.
fn ready(multiplier: &dyn Multiplier, bins: usize, values: Vec<f32>) -> Result<Band> {
    let row = bins * RGB;
    let pixels = values.len() / row;
    let lit: Vec<u32> =
        values.par_chunks_exact(row).enumerate().filter(|(_, v)| v.iter().any(|v| *v != 0.0)).map(|(i, _)| i as u32).collect();
    if lit.len() * 20 > pixels * 19 {
        return Ok(Band { pixels, lit: None, factor: multiplier.left(pixels, bins, RGB, values.into())? });
    }
    let mut packed = Vec::with_capacity(lit.len() * row);
    for &pixel in &lit {
        packed.extend_from_slice(&values[pixel as usize * row..][..row]);
    }
    drop(values);
    Ok(Band { pixels, factor: multiplier.left(lit.len(), bins, RGB, packed.into())?, lit: Some(lit) })
}

/// Hands the results of all bands to the pictures.
fn collect(
    take: &Receiver<Result<Piece>>,
    open: &mut [Sink],
    width: usize,
    adder: &Adder<'_>,
    advanced: &dyn Fn(usize),
    progress: &dyn Progress,
) -> Result<()> {
    let mut first = 0;
    for (band, piece) in take.iter().enumerate() {
        let Piece { pixels, lit, values } = piece?;
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let per_hour = values.len() / open.len();
        open.par_iter_mut().enumerate().try_for_each(|(hour, sink)| -> Result<()> {
            let colors: &[[f32; 3]] = bytemuck::cast_slice(&values[hour * per_hour..][..per_hour]);
            if lit.is_none() && adder.addition.is_none() {
                return put(sink, colors, width);
            }
            let mut all = match &lit {
                None => colors.to_vec(),
                Some(lit) => {
                    let mut all = vec![[0f32; 3]; pixels];
                    for (&pixel, color) in lit.iter().zip(colors) {
                        all[pixel as usize] = *color;
                    }
                    all
                }
            };
            adder.add(hour, first, &mut all)?;
            put(sink, &all, width)
        })?;
        first += pixels;
        advanced(band + 1);
    }
    Ok(())
}

/// Adds sparse pictures to the hours of a pass.
struct Adder<'a> {
    addition: Option<&'a Addition<'a>>,
    numbers: &'a [usize],
}

impl Adder<'_> {
    /// Adds what belongs to the pixels from `first` on to the picture of the `hour`-th hour of the pass.
    fn add(&self, hour: usize, first: usize, pixels: &mut [[f32; 3]]) -> Result<()> {
        let Some(addition) = self.addition else { return Ok(()) };
        let sparse = addition(self.numbers[hour])?;
        let begin = sparse.partition_point(|(pixel, _)| (*pixel as usize) < first);
        for (pixel, value) in &sparse[begin..] {
            let Some(to) = pixels.get_mut(*pixel as usize - first) else { break };
            for (to, value) in to.iter_mut().zip(value) {
                *to += value;
            }
        }
        Ok(())
    }
}

fn put(sink: &mut Sink, colors: &[[f32; 3]], width: usize) -> Result<()> {
    match sink {
        Sink::File(writer) => colors.chunks_exact(width).try_for_each(|row| writer.write(row)),
        Sink::Pixels(pixels) => {
            pixels.extend_from_slice(colors);
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests;
