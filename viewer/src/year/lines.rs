//! The view matrix in memory, read in an order that shows the whole picture soon: every eighth line of
//! pixels first, then those between, on all cores.

use lucarne::Result;
use lucarne::kernels::glare::PixelSource;
use lucarne::simulate::results::pictures::PictureView;
use lucarne::simulate::year::ViewFile;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// First line and distance of each pass; after it, lines so far apart are there.
const PASSES: [(usize, usize, usize); 4] = [(0, 8, 8), (4, 8, 4), (2, 4, 2), (1, 2, 1)];

/// V of a view, or with five phases V − Vd beside Vd.
pub struct Lines {
    view: ViewFile,
    split: bool,
    /// `[pixel][term]` if grey, else `[pixel][term][rgb]`.
    pub values: Vec<f32>,
    /// Whether one channel stands for all three.
    pub grey: bool,
    passes: usize,
}

impl Lines {
    /// Nothing read yet. `split`: whether V − Vd and Vd are wanted apart.
    pub fn new(view: &ViewFile, split: bool) -> Self {
        let mut lines = Self { view: view.clone(), split, values: Vec::new(), grey: true, passes: 0 };
        lines.values = vec![0.0; lines.line_values() * view.height];
        lines
    }

    /// Terms of a pixel.
    pub fn terms(&self) -> usize {
        self.view.bins * if self.split { 2 } else { 1 }
    }

    fn line_values(&self) -> usize {
        self.view.width * self.terms() * if self.grey { 1 } else { 3 }
    }

    /// Reads a part of the lines; false when all were there already.
    pub fn read(&mut self) -> Result<bool> {
        if self.passes == PASSES.len() {
            return Ok(false);
        }
        self.passes += 1;
        if self.read_pass(self.passes - 1)? {
            // The first coloured pixel: three channels from now on.
            self.grey = false;
            self.values = vec![0.0; self.line_values() * self.view.height];
            for pass in 0..self.passes {
                self.read_pass(pass)?;
            }
        }
        Ok(true)
    }

    /// True if there is colour that grey values cannot hold.
    fn read_pass(&mut self, pass: usize) -> Result<bool> {
        let (first, step, _) = PASSES[pass];
        let (row, grey) = (self.line_values(), self.grey);
        let coloured = AtomicBool::new(false);
        let (view, split) = (&self.view, self.split);
        let lines = self.values.par_chunks_mut(row.max(1)).enumerate().filter(|(line, _)| line % step == first);
        lines.try_for_each_init(
            || Reader::open(view, split),
            |reader, (line, out)| {
                let reader = reader.as_mut().map_err(|e| e.clone())?;
                if !(grey && coloured.load(Ordering::Relaxed)) && reader.read(line, view.width, grey, out)? {
                    coloured.store(true, Ordering::Relaxed);
                }
                Ok(())
            },
        )?;
        Ok(coloured.into_inner())
    }

    /// The picture that the lines read so far give; lines that are not there repeat those above.
    pub fn picture(&self, light: &[f32]) -> Vec<[f32; 3]> {
        let apart = self.passes.checked_sub(1).map_or(1, |p| PASSES[p].2);
        let (row, width) = (self.line_values(), self.view.width);
        let mut picture = vec![[0.0; 3]; width * self.view.height];
        picture.par_chunks_mut((width * apart).max(1)).enumerate().for_each(|(group, lines)| {
            let line = native(&self.values[group * apart * row..][..row], self.grey, light);
            lines.chunks_exact_mut(width).for_each(|to| to.copy_from_slice(&line));
        });
        picture
    }
}

/// One thread's files.
struct Reader {
    view: PictureView,
    values: Vec<f32>,
}

impl Reader {
    fn open(view: &ViewFile, split: bool) -> Result<Self> {
        let view = PictureView::open_parts(&view.matrix, split.then(|| view.direct_matrix()).as_deref())?;
        Ok(Self { view, values: Vec::new() })
    }

    /// Reads a line of pixels; true if it is coloured but `out` is grey.
    fn read(&mut self, line: usize, width: usize, grey: bool, out: &mut [f32]) -> Result<bool> {
        self.view.go_to(line)?;
        self.view.read(1, width, &mut self.values)?;
        let colours = self.values.as_chunks::<3>().0;
        if !grey {
            out.iter_mut().zip(&self.values).for_each(|(to, v)| *to = *v);
        } else if colours.iter().all(|[r, g, b]| r == g && g == b) {
            out.iter_mut().zip(colours).for_each(|(to, [v, ..])| *to = *v);
        } else {
            return Ok(true);
        }
        Ok(false)
    }
}

/// Lanes summed side by side; a multiple of three, so that channels do not mix.
const LANES: usize = 24;

/// The picture `[pixel][rgb]` of rows of V, `[pixel][term]` if grey, and the light of an hour,
/// `[term][rgb]`.
pub fn native(values: &[f32], grey: bool, light: &[f32]) -> Vec<[f32; 3]> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use lucarne::matrix::Matrix;
    use lucarne::matrix::file::{Format, write_matrix};

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

    #[test]
    fn lines_read_in_passes_are_the_whole_matrix() {
        let folder = tempfile::tempdir().unwrap();
        let (width, height, bins) = (5, 19, 4);
        for coloured in [None, Some(0), Some(17)] {
            let value = |i: usize| ((i * 7919 % 1013) as f32) / 1013.0;
            let number = |i: usize| value(i / 3) + if coloured == Some(i / (3 * bins * width)) { 0.1 * (i % 3) as f32 } else { 0.0 };
            let total = Matrix::from_data(width * height, bins, 3, (0..width * height * bins * 3).map(number).collect()).unwrap();
            let direct = total.map(|v| v * 0.25);
            let path = |name: &str| folder.path().join(name);
            let header = [format!("RESOLUTION=-Y {height} +X {width}")];
            write_matrix(Some(&path("V_v.mtx")), &total, Format::Float, &header).unwrap();
            write_matrix(Some(&path("V_v_direct.mtx")), &direct, Format::Float, &[]).unwrap();
            let view = ViewFile { name: "v".into(), matrix: path("V_v.mtx"), width, height, bins, options: None };
            for split in [false, true] {
                let mut lines = Lines::new(&view, split);
                let light: Vec<f32> = (0..lines.terms() * 3).map(|i| value(i + 3)).collect();
                let exact = |pixel: usize, c: usize| -> f32 {
                    let sum =
                        |m: &Matrix<f32>, first: usize| (0..bins).map(|b| m.at(pixel, b)[c] * light[(first + b) * 3 + c]).sum::<f32>();
                    if split { 0.75 * sum(&total, 0) + sum(&direct, bins) } else { sum(&total, 0) }
                };
                let mut passes = 0;
                while lines.read().unwrap() {
                    passes += 1;
                    let picture = lines.picture(&light);
                    // The first pass already fills all lines, from the eighth above.
                    let apart = [8, 4, 2, 1][passes - 1];
                    for line in 0..height {
                        let (pixel, from) = (line * width + 2, (line - line % apart) * width + 2);
                        assert!((0..3).all(|c| (picture[pixel][c] - exact(from, c)).abs() < 1e-5), "{coloured:?} {split} {passes} {line}");
                    }
                }
                assert_eq!((passes, lines.grey), (4, coloured.is_none()));
            }
        }
    }
}
