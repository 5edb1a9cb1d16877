//! The product of all hours: bands of pixels are read, multiplied and handed to the pictures at the same time.

use super::request::{Addition, Request};
use super::view::{PictureView, Reader};
use crate::error::{Error, Result};
use crate::files::AtomicFile;
use crate::gpu::Plan;
use crate::image::hdr::{self, ScanlineWriter};
use crate::image::series::Pattern;
use crate::kernels::product::{Arrangement, Factor, Multiplier};
use crate::progress::{Progress, cancelled};
use rayon::prelude::*;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

const RGB: usize = 3;
/// Bytes of a pixel in memory.
const PIXEL_BYTES: u64 = (RGB * size_of::<f32>()) as u64;
/// Most hours in a pass: each keeps a file open.
const MOST_HOURS: usize = 200;
/// Rows of pixels in a band, if memory allows: enough for the product to be efficient, few enough
/// for the stages to overlap.
const BAND_PIXELS: usize = 1 << 15;

/// How the work is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sizes {
    /// Hours per pass.
    pub hours: usize,
    /// Rows of pixels per band.
    pub lines: usize,
    /// Whether V stays in memory for all passes.
    pub keep: bool,
}

impl Sizes {
    pub(super) fn new(multiplier: &dyn Multiplier, view: &PictureView, request: &Request) -> Result<Self> {
        let (width, height, bins) = (view.width, view.height, view.bins);
        // V as read, and as the multiplier keeps it.
        let row_bytes = |rows: usize| rows as u64 * bins as u64 * PIXEL_BYTES + multiplier.device_bytes(rows, bins, RGB);
        let whole = if request.output.needs_whole_pictures() { view.pixels() as u64 * PIXEL_BYTES } else { 1 << 17 };
        Self::within(request.memory, [width, height], request.hours.len(), row_bytes(width), whole)
    }

    /// `line_bytes` is V for a row of pixels, `sink_bytes` what an hour keeps until it is written.
    pub(super) fn within(memory: u64, [width, height]: [usize; 2], hours: usize, line_bytes: u64, sink_bytes: u64) -> Result<Self> {
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
pub(super) trait Sinks {
    /// Prepares for the hours of a pass.
    fn begin(&mut self, numbers: &[usize]) -> Result<Vec<Sink>>;
    /// Completes the pictures of a pass, in order.
    fn end(&mut self, numbers: &[usize], sinks: Vec<Sink>) -> Result<()>;
}

/// One picture in the making.
pub(super) enum Sink {
    File(Box<ScanlineWriter<AtomicFile>>),
    Pixels(Vec<[f32; 3]>),
}

pub(super) struct HdrFiles<'a> {
    pub pattern: &'a Pattern,
    pub width: usize,
    pub height: usize,
    pub view: Option<String>,
    pub header: &'a [String],
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

pub(super) struct Whole<'a> {
    pub pixels: usize,
    pub done: &'a mut dyn FnMut(usize, Vec<[f32; 3]>) -> Result<()>,
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
pub(super) fn passes(
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
        request.finished.map_or(Ok(()), |finished| finished(numbers))?;
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
