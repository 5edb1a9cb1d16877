//! `lucarne matrix view --view`: the view matrix of a picture, as a matrix of pixels or as
//! Radiance's component pictures.

use lucarne::camera::{Raster, View};
use lucarne::files::write_atomically;
use lucarne::gpu::Device;
use lucarne::image::series::{Pattern, SetWriter};
use lucarne::kernels::image_matrix::{self, ImageOptions, PixelRows};
use lucarne::matrix::file::write_float_header;
use lucarne::progress::Progress;
use lucarne::scene::{Scene, Window};
use lucarne::{Error, Result};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Options of a picture's view matrix.
#[derive(clap::Args)]
pub struct PictureArgs {
    /// View file (or a picture with a VIEW line); instead of --points
    #[arg(long, value_name = "VIEW.vf")]
    pub view: Option<PathBuf>,

    /// Most pixels per row
    #[arg(short = 'x', value_name = "PIXELS", default_value_t = 512)]
    width: usize,

    /// Most rows
    #[arg(short = 'y', value_name = "PIXELS", default_value_t = 512)]
    height: usize,

    /// Width over height of a pixel; 0 stretches the picture to -x and -y
    #[arg(long = "pa", value_name = "RATIO", default_value_t = 1.0)]
    pixel_aspect: f64,

    /// Part of a pixel over which its samples are spread
    #[arg(long = "pj", value_name = "FRACTION", default_value_t = 1.0)]
    jitter: f64,

    /// Samples of the windows per pixel and batch
    #[arg(long, value_name = "N", default_value_t = ImageOptions::default().window_samples)]
    window_samples: u32,
}

impl PictureArgs {
    /// The picture's pixels.
    pub fn raster(&self, file: &Path) -> Result<Raster> {
        Raster::fit(View::read(file)?.camera().map_err(|e| e.file(file))?, self.width, self.height, self.pixel_aspect)
    }

    /// Sampling options that belong to pictures alone, on top of `base`.
    pub fn apply(&self, base: ImageOptions) -> ImageOptions {
        ImageOptions { jitter: self.jitter, window_samples: self.window_samples, ..base }
    }
}

/// Everything the computation needs.
pub struct Job<'a> {
    pub device: &'a Device,
    pub scene: &'a Scene,
    pub windows: &'a [Window],
    pub raster: &'a Raster,
    pub options: &'a ImageOptions,
    pub progress: &'a dyn Progress,
    pub header: Vec<String>,
}

impl Job<'_> {
    /// Computes the matrix and writes it to `output`: a matrix of floats with one row per pixel, or
    /// component pictures if the name holds a number pattern like `%03d`.
    pub fn run(&self, output: Option<&Path>) -> Result<()> {
        match output {
            Some(path) if Pattern::is_pattern(&path.to_string_lossy()) => {
                self.component_pictures(&Pattern::parse(&path.to_string_lossy())?)
            }
            Some(path) => write_atomically(path, |out| self.pixel_matrix(out).map_err(|e| e.file(path))),
            None => self.pixel_matrix(&mut std::io::stdout().lock()),
        }
    }

    fn bins(&self) -> usize {
        self.windows.iter().map(|w| w.basis.len()).sum()
    }

    fn compute(&self, sink: &mut dyn FnMut(PixelRows) -> Result<()>) -> Result<()> {
        image_matrix::compute(self.device, self.scene, self.windows, self.raster, self.options, self.progress, sink).map(|_| ())
    }

    fn pixel_matrix(&self, out: &mut dyn Write) -> Result<()> {
        let mut header = self.header.clone();
        header.push(format!("VIEW= {}", self.raster.camera().view().to_options()));
        header.push(format!("RESOLUTION=-Y {} +X {}", self.raster.height(), self.raster.width()));
        write_float_header(out, [self.raster.len(), self.bins(), 3], &header)?;
        let mut bytes = Vec::new();
        self.compute(&mut |rows| {
            bytes.clear();
            bytes.extend(rows.values.iter().flat_map(|v| v.to_le_bytes()));
            out.write_all(&bytes).map_err(|e| Error::stream(&e))
        })
    }

    fn component_pictures(&self, pattern: &Pattern) -> Result<()> {
        let view = self.raster.camera().view().to_options();
        let size = [self.raster.width(), self.raster.height()];
        let lines = |bin: usize| self.header.iter().cloned().chain([format!("BIN={bin}")]).collect();
        let mut writer = SetWriter::create(pattern, self.bins(), size, Some(&view), lines)?;
        let scanline = size[0] * self.bins() * 3;
        // Pixels of a scanline that is not complete yet.
        let mut pending: Vec<f32> = Vec::new();
        self.compute(&mut |rows| {
            pending.extend_from_slice(&rows.values);
            let complete = pending.len() / scanline * scanline;
            writer.write(&pending[..complete])?;
            pending.drain(..complete);
            Ok(())
        })?;
        writer.finish()
    }
}
