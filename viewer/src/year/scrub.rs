//! The hour's picture while dragging: `V · T·D·S` of one hour, by a worker that always takes the
//! newest wish.

use crate::picture::model::{Judge, Judged, PictureFile};
use crate::results::{Results, ViewFile};
use eframe::egui;
use lucarne::image::Picture;
use lucarne::kernels::product::{self, Arrangement, Factor, Multiplier};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::matrix::rows::MatrixRows;
use lucarne::{Error, Result};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Rows of V read at a time.
const BAND: usize = 4096;
/// How often an unfinished picture is shown while V is read.
const PARTIAL: Duration = Duration::from_millis(250);
/// How long dragging must rest before glare is looked for.
const PAUSE: Duration = Duration::from_millis(200);

/// A picture that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// Hour of the year.
    pub hour: usize,
    /// How far each window is on its way to its second state.
    pub fractions: Vec<f64>,
    /// Second states, by window; the number tells sets apart.
    pub states: (u64, Arc<Vec<Option<Matrix<f32>>>>),
}

/// What comes back.
pub enum Answer {
    /// A picture; whether all of it is there, and how long it took.
    Picture { wish: Wish, file: Box<PictureFile>, whole: bool, seconds: f64 },
    /// Its glare, if the view has any.
    Glare { wish: Wish, judged: Option<Box<Judged>> },
    /// What went wrong; the worker has ended.
    Failed(Error),
}

/// The window side of the worker.
pub struct Scrubber {
    wishes: Sender<Wish>,
    answers: Receiver<Answer>,
    last: Option<Wish>,
    /// Name of the view it serves.
    pub view: String,
}

impl Scrubber {
    /// Starts a worker for a view.
    pub fn start(ctx: &egui::Context, results: &Arc<Results>, view: &ViewFile) -> Self {
        let (wishes, wanted) = channel();
        let (answer, answers) = channel();
        let (ctx, results, view) = (ctx.clone(), results.clone(), view.clone());
        let name = view.name.clone();
        std::thread::spawn(move || {
            let send = |a: Answer| {
                let gone = answer.send(a).is_err();
                ctx.request_repaint();
                gone
            };
            if let Err(error) = work(&results, &view, &wanted, &send) {
                send(Answer::Failed(error));
            }
        });
        Self { wishes, answers, last: None, view: name }
    }

    /// Asks for a picture, unless it was the last one asked for.
    pub fn wish(&mut self, wish: Wish) {
        if self.last.as_ref() != Some(&wish) {
            self.last = Some(wish.clone());
            // A worker that has ended has said why.
            let _ = self.wishes.send(wish);
        }
    }

    /// What has come back.
    pub fn answers(&self) -> impl Iterator<Item = Answer> + '_ {
        self.answers.try_iter()
    }

    /// The newest wish.
    pub fn wanted(&self) -> Option<&Wish> {
        self.last.as_ref()
    }
}

/// Light that leaves the windows into the room: the product T·D·S of one hour.
pub struct Facade {
    windows: Vec<(Matrix<f32>, Matrix<f32>)>,
    sky: Matrix<f32>,
}

impl Facade {
    /// Reads the matrices of all windows and the sky.
    pub fn read(results: &Results) -> Result<Self> {
        let read = |name: String| read_matrix(&results.matrix(&name)).map(|f| f.matrix);
        let windows: Result<Vec<_>> = results.windows.iter().map(|w| Ok((read(format!("T_{w}"))?, read(format!("D_{w}"))?))).collect();
        let facade = Self { windows: windows?, sky: read("S".into())? };
        for (name, (t, d)) in results.windows.iter().zip(&facade.windows) {
            let fits = t.cols() == d.rows() && d.cols() == facade.sky.rows() && d.components() == 3 && t.components() == 3;
            if !fits || facade.sky.components() != 3 {
                return Err(Error::new(format!("the matrices of window '{name}' do not fit each other"))
                    .file(&results.folder)
                    .help("run the project again"));
            }
        }
        Ok(facade)
    }

    /// T of a window between its two states.
    fn transmission(&self, index: usize, wish: &Wish) -> Matrix<f32> {
        let first = &self.windows[index].0;
        let fraction = wish.fractions.get(index).copied().unwrap_or(0.0) as f32;
        match wish.states.1.get(index).and_then(Option::as_ref) {
            Some(second) if fraction > 0.0 && second.data().len() == first.data().len() => {
                let mixed = first.data().iter().zip(second.data()).map(|(a, b)| a + (b - a) * fraction).collect();
                Matrix::from_data(first.rows(), first.cols(), 3, mixed).unwrap_or_else(|_| first.clone())
            }
            _ => first.clone(),
        }
    }

    /// `[bin][rgb]` of one hour, the bins of all windows.
    pub fn light(&self, wish: &Wish) -> Vec<f32> {
        let column: Vec<[f32; 3]> =
            (0..self.sky.rows()).map(|p| <[f32; 3]>::try_from(self.sky.at(p, wish.hour)).unwrap_or_default()).collect();
        let mut light = Vec::new();
        for (i, (_, d)) in self.windows.iter().enumerate() {
            let arriving = apply(d, &column);
            let t = self.transmission(i, wish);
            light.extend(apply(&t, &arriving).into_iter().flatten());
        }
        light
    }

    /// T·D of all windows, one below the other.
    pub fn transmitted(&self, wish: &Wish) -> Result<Matrix<f32>> {
        let mut data = Vec::new();
        for (i, (_, d)) in self.windows.iter().enumerate() {
            data.extend(product::chain(&product::Native, &[&self.transmission(i, wish), d])?.into_data());
        }
        let cols = self.sky.rows();
        Matrix::from_data(data.len() / (cols * 3).max(1), cols, 3, data)
    }

    /// Illuminance `[sensor][hour]` of a group of sensors.
    pub fn illuminance(&self, view: &Matrix<f32>, wish: &Wish) -> Result<Matrix<f32>> {
        let rgb = product::chain(&product::Native, &[view, &self.transmitted(wish)?, &self.sky])?;
        let lux = rgb
            .data()
            .chunks_exact(3)
            .map(|v| v.iter().zip(lucarne::units::ILLUMINANCE_WEIGHTS).map(|(a, w)| f64::from(*a) * w).sum::<f64>() as f32);
        Matrix::from_data(rgb.rows(), rgb.cols(), 1, lux.collect())
    }
}

fn apply(m: &Matrix<f32>, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let row = |r: usize| {
        let mut sum = [0.0f64; 3];
        for (m, x) in m.row(r).chunks_exact(3).zip(x) {
            for c in 0..3 {
                sum[c] += f64::from(m[c]) * f64::from(x[c]);
            }
        }
        sum.map(|v| v as f32)
    };
    (0..m.rows()).into_par_iter().map(row).collect()
}

/// V ready for products with one column.
enum Engine {
    /// On the processor: a third of the memory where all three channels are the same.
    Native { values: Vec<f32>, grey: bool },
    /// On the device.
    Device { multiplier: Box<dyn Multiplier>, left: Factor<'static> },
}

impl Engine {
    /// The picture of one hour, `[pixel][rgb]`.
    fn picture(&self, light: &[f32], pixels: usize) -> Result<Vec<[f32; 3]>> {
        match self {
            Self::Native { values, grey } => Ok(native(values, *grey, light)),
            Self::Device { multiplier, left } => {
                let right = multiplier.right(light.len() / 3, 1, 3, light.into())?;
                let mut out = vec![0.0; pixels * 3];
                multiplier.multiply(left, &right, 0, 1, Arrangement::Rows, &mut out)?;
                Ok(out.as_chunks::<3>().0.to_vec())
            }
        }
    }
}

/// Lanes summed side by side; a multiple of three, so that channels do not mix.
const LANES: usize = 24;

fn native(values: &[f32], grey: bool, light: &[f32]) -> Vec<[f32; 3]> {
    let bins = light.len() / 3;
    if bins == 0 {
        return Vec::new();
    }
    if grey {
        let channels: [Vec<f32>; 3] = std::array::from_fn(|c| light.iter().skip(c).step_by(3).copied().collect());
        return values.par_chunks_exact(bins).with_min_len(256).map(|row| [0, 1, 2].map(|c| dot(row, &channels[c]))).collect();
    }
    let pixel = |row: &[f32]| {
        let mut lanes = [0.0f32; LANES];
        let (rows, row_rest) = row.as_chunks::<LANES>();
        let (lights, light_rest) = light.as_chunks::<LANES>();
        for (a, b) in rows.iter().zip(lights) {
            for i in 0..LANES {
                lanes[i] += a[i] * b[i];
            }
        }
        for (i, (a, b)) in row_rest.iter().zip(light_rest).enumerate() {
            lanes[i] += a * b;
        }
        let mut rgb = [0.0; 3];
        lanes.iter().enumerate().for_each(|(i, v)| rgb[i % 3] += v);
        rgb
    };
    values.par_chunks_exact(3 * bins).with_min_len(256).map(pixel).collect()
}

fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0f32; 16];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<16>(), b.as_chunks::<16>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..16 {
            lanes[i] += a[i] * b[i];
        }
    }
    lanes.iter().sum::<f32>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f32>()
}

/// The newest of several wishes.
fn newest(first: Wish, wanted: &Receiver<Wish>) -> Wish {
    wanted.try_iter().last().unwrap_or(first)
}

fn work(results: &Results, view: &ViewFile, wanted: &Receiver<Wish>, send: &dyn Fn(Answer) -> bool) -> Result<()> {
    let Ok(mut wish) = wanted.recv() else { return Ok(()) };
    let facade = Facade::read(results)?;
    let bins: usize = facade.windows.iter().map(|(t, _)| t.rows()).sum();
    if bins != view.bins {
        return Err(Error::new(format!("the view matrix has {} columns, the windows have {bins} bins", view.bins))
            .file(&view.matrix)
            .help("run the project again"));
    }
    let pixels = view.width * view.height;
    let start = Instant::now();
    let answer = |wish: &Wish, rgb: Vec<[f32; 3]>, whole: bool, start: Instant| -> Result<Answer> {
        let mut picture = Picture::new(view.width, view.height, rgb)?;
        picture.view.clone_from(&view.options);
        let file = Box::new(PictureFile::of_picture(&view.matrix, picture));
        Ok(Answer::Picture { wish: wish.clone(), file, whole, seconds: start.elapsed().as_secs_f64() })
    };
    // While V is read, the picture grows from the top.
    let mut rows = MatrixRows::open(&view.matrix)?.ok_or_else(|| Error::new("a text matrix cannot be scrubbed").file(&view.matrix))?;
    let (mut values, mut grey) = (Vec::with_capacity(pixels * bins), true);
    let mut light = facade.light(&wish);
    let (mut rgb, mut band) = (vec![[0.0f32; 3]; pixels], Vec::new());
    let (mut done, mut shown) = (0, Instant::now());
    while rows.read(BAND, &mut band)? > 0 {
        if grey && !band.as_chunks::<3>().0.iter().all(|[r, g, b]| r == g && g == b) {
            grey = false;
            values = values.iter().flat_map(|v| [*v; 3]).collect();
            values.reserve(pixels * bins * 3 - values.len());
        }
        let part = native(&band, false, &light);
        rgb[done..done + part.len()].copy_from_slice(&part);
        done += part.len();
        if grey {
            values.extend(band.iter().step_by(3))
        } else {
            values.extend_from_slice(&band)
        }
        if shown.elapsed() > PARTIAL {
            shown = Instant::now();
            if send(answer(&wish, rgb.clone(), false, start)?) {
                return Ok(());
            }
        }
    }
    if send(answer(&wish, rgb, true, start)?) {
        return Ok(());
    }
    let multiplier = product::choose(None)?;
    let engine = if multiplier.description().starts_with("native") {
        Engine::Native { values, grey }
    } else {
        let all = if grey { values.iter().flat_map(|v| [*v; 3]).collect() } else { values };
        let left = multiplier.left(pixels, bins, 3, all.into())?;
        Engine::Device { multiplier, left }
    };
    let mut judge: Option<Judge> = None;
    loop {
        // The glare of what is shown is worth its time only when the dragging has stopped.
        let next = match wanted.recv_timeout(PAUSE) {
            Ok(next) => Some(next),
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
            Err(RecvTimeoutError::Timeout) => None,
        };
        let next = match next {
            Some(next) => next,
            None => {
                let mut picture = Picture::new(view.width, view.height, engine.picture(&light, pixels)?)?;
                picture.view.clone_from(&view.options);
                let file = PictureFile::of_picture(&view.matrix, picture);
                if judge.is_none() {
                    judge = Judge::new(&file, 2000.0, None).ok();
                }
                let judged = judge.as_ref().and_then(|j| j.judge(&file).ok()).map(Box::new);
                if send(Answer::Glare { wish: wish.clone(), judged }) {
                    return Ok(());
                }
                match wanted.recv() {
                    Ok(next) => next,
                    Err(_) => return Ok(()),
                }
            }
        };
        let start = Instant::now();
        wish = newest(next, wanted);
        light = facade.light(&wish);
        let rgb = engine.picture(&light, pixels)?;
        if send(answer(&wish, rgb, true, start)?) {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fast_sums_are_those_of_f64() {
        for bins in [1usize, 7, 16, 145, 290] {
            let number = |i: usize| ((i * 7919 % 1013) as f32) / 1013.0;
            let light: Vec<f32> = (0..3 * bins).map(|i| number(i + 5)).collect();
            let values: Vec<f32> = (0..3 * bins * 300).map(number).collect();
            let found = native(&values, false, &light);
            let grey_values: Vec<f32> = (0..bins * 300).map(number).collect();
            let grey = native(&grey_values, true, &light);
            assert_eq!((found.len(), grey.len()), (300, 300));
            for p in [0, 17, 299] {
                for c in 0..3 {
                    let exact: f64 = (0..bins).map(|b| f64::from(values[(p * bins + b) * 3 + c]) * f64::from(light[3 * b + c])).sum();
                    assert!((f64::from(found[p][c]) - exact).abs() <= 1e-5 * exact);
                    let exact: f64 = (0..bins).map(|b| f64::from(grey_values[p * bins + b]) * f64::from(light[3 * b + c])).sum();
                    assert!((f64::from(grey[p][c]) - exact).abs() <= 1e-5 * exact);
                }
            }
        }
    }
}
