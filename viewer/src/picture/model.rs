//! What the picture panel shows for which state.

use crate::scale::ScaleChoice;
use glam::DVec2;
use lucarne::camera::{Raster, View as Camera};
use lucarne::glare::{Analyser, Glare, PixelGeometry, Settings, TaskArea, Threshold, detect};
use lucarne::image::palette::Palette;
use lucarne::image::{Picture, luminance};
use lucarne::matrix::Matrix;
use lucarne::{Error, Result, Warnings, image};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Largest picture shown pixel by pixel; larger ones are shown with every n-th pixel.
pub const MOST_SIDE: usize = 4096;

/// A picture that was opened or computed.
#[derive(Clone)]
pub struct PictureFile {
    /// Where it came from.
    pub path: PathBuf,
    /// Its pixels: radiance.
    pub picture: Arc<Picture>,
    /// cd/m² of every pixel, or the entries of a matrix.
    pub luminance: Arc<Vec<f32>>,
    /// Unit of [`Self::luminance`].
    pub unit: &'static str,
    /// Tells pictures apart in keys of caches.
    pub id: u64,
}

impl PictureFile {
    /// Reads a picture.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::of_picture(path, image::read(path)?))
    }

    /// A picture in memory.
    pub fn of_picture(path: &Path, picture: Picture) -> Self {
        let values = picture.pixels.par_iter().map(|&p| luminance(p)).collect();
        Self { path: path.to_path_buf(), picture: Arc::new(picture), luminance: Arc::new(values), unit: "cd/m²", id: next_id() }
    }

    /// The entries of a matrix as a picture: rows downwards, columns to the right.
    pub fn of_matrix(path: &Path, m: &Matrix<f32>) -> Result<Self> {
        let channels = m.components();
        let at = |v: &[f32]| if channels == 3 { [v[0], v[1], v[2]] } else { [v[0]; 3] };
        if m.data().is_empty() || channels == 0 {
            return Err(Error::new("the matrix is empty").file(path));
        }
        let pixels: Vec<[f32; 3]> = m.data().chunks_exact(channels).map(at).collect();
        let values = m.data().chunks_exact(channels).map(|v| v.iter().sum::<f32>() / channels as f32).collect();
        let picture = Picture::new(m.cols(), m.rows(), pixels).map_err(|e| e.file(path))?;
        Ok(Self { path: path.to_path_buf(), picture: Arc::new(picture), luminance: Arc::new(values), unit: "", id: next_id() })
    }

    /// Value that only one lit pixel in 200 exceeds, for automatic scales.
    pub fn typical_maximum(&self) -> f64 {
        self.exceeded_by(0.005)
    }

    /// Luminance that one lit pixel in 20 exceeds: white of a photograph.
    pub fn white(&self) -> f64 {
        self.exceeded_by(0.05)
    }

    fn exceeded_by(&self, share: f64) -> f64 {
        let mut lit: Vec<f32> = self.luminance.iter().copied().filter(|v| *v > 0.0).collect();
        if lit.is_empty() {
            return 1.0;
        }
        let k = ((lit.len() - 1) as f64 * (1.0 - share)) as usize;
        f64::from(*lit.select_nth_unstable_by(k, f32::total_cmp).1)
    }

    /// The camera of the picture, if its header tells.
    pub fn raster(&self) -> Option<Raster> {
        let camera = Camera::parse(self.picture.view.as_deref()?).ok()?.camera().ok()?;
        Raster::new(camera, self.picture.width, self.picture.height).ok()
    }
}

fn next_id() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// How pixels become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Luminance by a palette.
    Falsecolor,
    /// As a photograph.
    Photograph,
}

/// Tone mapping of a photograph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Linear, bright parts clipped.
    Linear,
    /// Reinhard's L / (1 + L): bright parts compressed.
    Reinhard,
    /// Logarithm of luminance over four decades.
    Logarithmic,
}

/// What the first pointer button does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tool {
    /// Reads values and moves the picture.
    Inspect,
    /// Draws a line of which the profile is shown.
    Profile,
    /// Places the task circle.
    Task,
}

/// Everything the user has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Falsecolour or photograph.
    pub mode: Mode,
    /// Palette.
    pub palette: Palette,
    /// Scale of the falsecolour.
    pub scale: ScaleChoice,
    /// Tone mapping.
    pub tone: Tone,
    /// Exposure of the photograph, stops above the automatic one.
    pub stops: f64,
    /// Glare sources.
    pub sources: bool,
    /// Threshold of glare: cd/m² above 100, else a multiple of the task's or mean luminance.
    pub threshold: f64,
    /// Pointer tool.
    pub tool: Tool,
    /// Ends of the profile, pixels from the left and top.
    pub profile: Option<[[f64; 2]; 2]>,
    /// Task circle: centre in pixels from the left and top, full angle in degrees.
    pub task: Option<([f64; 2], f64)>,
    /// Enlargement beyond the fit, and the middle of the window in shares of the picture.
    pub zoom: f64,
    /// Middle of the window in shares of the picture.
    pub middle: [f64; 2],
}

impl Default for View {
    fn default() -> Self {
        Self {
            mode: Mode::Falsecolor,
            palette: Palette::Viridis,
            scale: ScaleChoice::automatic(true, 3.0),
            tone: Tone::Linear,
            stops: 0.0,
            sources: true,
            threshold: 2000.0,
            tool: Tool::Inspect,
            profile: None,
            task: None,
            zoom: 1.0,
            middle: [0.5, 0.5],
        }
    }
}

impl View {
    /// Enlarges around a point given in shares of the picture.
    pub fn zoom_at(&mut self, factor: f64, at: [f64; 2]) {
        let new = (self.zoom * factor).clamp(1.0, 64.0);
        let shrink = self.zoom / new;
        for c in 0..2 {
            self.middle[c] = at[c] + (self.middle[c] - at[c]) * shrink;
        }
        self.zoom = new;
        self.keep_inside();
    }

    /// Keeps the window over the picture.
    pub fn keep_inside(&mut self) {
        let half = 0.5 / self.zoom;
        self.middle = self.middle.map(|c| c.clamp(half.min(0.5), (1.0 - half).max(0.5)));
    }
}

/// Glare of a picture with what was noticed.
#[derive(Clone)]
pub struct Judged {
    /// The analysis.
    pub glare: Glare,
    /// Edges around each source, pixels from the left and top.
    pub outlines: Vec<Vec<[[f32; 2]; 2]>>,
    /// The task area's outline.
    pub task: Vec<[[f32; 2]; 2]>,
    /// Whether the view lacks a part of the hemisphere, so that illuminance and DGP are too low.
    pub partial: bool,
}

/// Judges pictures of one view, as `lucarne glare` does.
pub struct Judge {
    analyser: Analyser,
    width: usize,
}

impl Judge {
    /// Prepares the analysis of pictures like this one.
    pub fn new(file: &PictureFile, threshold: f64, task: Option<([f64; 2], f64)>) -> Result<Self> {
        if file.unit.is_empty() {
            return Err(Error::new("a matrix is no picture of a view"));
        }
        let raster = file.raster().ok_or_else(|| Error::new("the picture does not tell its view (no VIEW line in its header)"))?;
        let geometry = Arc::new(PixelGeometry::new(&raster)?);
        let height = file.picture.height as f64;
        let task = task.map(|([x, y], degrees)| TaskArea {
            x: x.floor(),
            y: (height - 1.0 - y.floor()).max(0.0),
            opening_angle: degrees.to_radians(),
        });
        let settings = Settings { threshold: Threshold::from_option(Some(threshold), task.is_some()), task, ..Settings::default() };
        Ok(Self { analyser: Analyser::new(geometry, settings)?, width: file.picture.width })
    }

    /// Judges a picture of the same view and size.
    pub fn judge(&self, file: &PictureFile) -> Result<Judged> {
        let mut faults = Warnings::new();
        let values = detect::luminance(&file.picture.pixels, file.picture.width, &mut faults);
        let glare = self.analyser.analyse(&values, None)?;
        let outlines = glare.sources.iter().map(|s| outline(&s.pixels, self.width)).collect();
        let task = outline(self.analyser.task_pixels(), self.width);
        Ok(Judged { glare, outlines, task, partial: self.analyser.geometry().hemisphere_coverage() < 0.98 })
    }
}

/// Judges one picture.
pub fn judge(file: &PictureFile, threshold: f64, task: Option<([f64; 2], f64)>) -> Result<Judged> {
    Judge::new(file, threshold, task)?.judge(file)
}

/// Edges between pixels that belong to a set and those that do not, joined along rows and columns.
pub fn outline(pixels: &[u32], width: usize) -> Vec<[[f32; 2]; 2]> {
    let inside = |x: i64, y: i64| {
        x >= 0 && y >= 0 && (x as usize) < width && pixels.binary_search(&((y as usize * width + x as usize) as u32)).is_ok()
    };
    let mut edges = Vec::new();
    for &p in pixels {
        let (x, y) = ((p as usize % width) as i64, (p as usize / width) as i64);
        let (l, t) = (x as f32, y as f32);
        if !inside(x, y - 1) {
            edges.push([[l, t], [l + 1.0, t]]);
        }
        if !inside(x, y + 1) {
            edges.push([[l, t + 1.0], [l + 1.0, t + 1.0]]);
        }
        if !inside(x - 1, y) {
            edges.push([[l, t], [l, t + 1.0]]);
        }
        if !inside(x + 1, y) {
            edges.push([[l + 1.0, t], [l + 1.0, t + 1.0]]);
        }
    }
    edges
}

/// Values along a line, one per pixel passed: (distance in pixels, value).
pub fn profile(file: &PictureFile, [a, b]: [[f64; 2]; 2]) -> Vec<[f64; 2]> {
    let (a, b) = (DVec2::from(a), DVec2::from(b));
    let length = (b - a).length();
    let steps = (length.ceil() as usize).clamp(1, 8192);
    let (w, h) = (file.picture.width, file.picture.height);
    (0..=steps)
        .filter_map(|i| {
            let t = i as f64 / steps as f64;
            let p = a + (b - a) * t;
            let inside = p.x >= 0.0 && p.y >= 0.0 && p.x < w as f64 && p.y < h as f64;
            inside.then(|| [t * length, f64::from(file.luminance[p.y as usize * w + p.x as usize])])
        })
        .collect()
}

/// Shares of lit pixels in equal steps of log₁₀ between two decades.
pub fn histogram(values: &[f32], steps: usize) -> ([f64; 2], Vec<f64>) {
    let lit: Vec<f64> = values.iter().filter(|v| **v > 0.0 && v.is_finite()).map(|v| f64::from(*v).log10()).collect();
    let (low, high) = lit.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    if lit.is_empty() {
        return ([0.0, 1.0], vec![0.0; steps]);
    }
    let range = [low.floor().max(high.ceil() - 8.0), high.ceil().max(low.floor() + 1.0)];
    let mut counts = vec![0.0; steps];
    for v in &lit {
        let k = ((v - range[0]) / (range[1] - range[0]) * steps as f64).clamp(0.0, steps as f64 - 1.0);
        counts[k as usize] += 1.0 / lit.len() as f64;
    }
    (range, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> PictureFile {
        let pixels = (0..200).map(|i| [(i % 20) as f32 / 179.0; 3]).collect();
        PictureFile::of_picture(Path::new("ramp"), Picture::new(20, 10, pixels).unwrap())
    }

    #[test]
    fn profiles_follow_the_pixels() {
        let line = profile(&ramp(), [[0.5, 3.5], [19.5, 3.5]]);
        assert_eq!(line.len(), 20);
        for (i, [d, v]) in line.iter().enumerate() {
            assert!((d - i as f64).abs() < 1e-9 && (v - i as f64).abs() < 1e-4, "{d} {v}");
        }
    }

    #[test]
    fn histograms_count_lit_pixels() {
        let (range, counts) = histogram(&ramp().luminance, 20);
        assert_eq!(range, [0.0, 2.0]);
        assert!((counts.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert!((counts[0] - 10.0 / 190.0).abs() < 1e-9, "1 cd/m²");
        assert_eq!(histogram(&[0.0], 4).1, [0.0; 4]);
    }

    #[test]
    fn outlines_close_around_a_set() {
        let edges = outline(&[21, 22, 41], 20);
        assert_eq!(edges.len(), 8);
        assert!(edges.contains(&[[1.0, 1.0], [2.0, 1.0]]) && !edges.contains(&[[2.0, 1.0], [2.0, 2.0]]));
    }

    #[test]
    fn zooming_keeps_the_point_under_the_pointer() {
        let mut v = View::default();
        v.zoom_at(4.0, [0.6, 0.4]);
        assert_eq!(v.zoom, 4.0);
        assert!((v.middle[0] - 0.575).abs() < 1e-9);
        v.zoom_at(1e-9, [0.0, 0.0]);
        assert_eq!((v.zoom, v.middle), (1.0, [0.5, 0.5]));
    }
}
