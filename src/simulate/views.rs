//! Pictures of a project: `[[view]]` and `[images]`, their view matrices and hourly pictures.

use super::fingerprint::Fingerprint;
use super::multiply::{check_hours, lit_columns, select_columns};
use super::pictures::{Output, PictureView, Request, write_pictures};
use super::project::name;
use super::store::{INPUTS, Store, software};
use super::table::Table;
use crate::camera::{Raster, View};
use crate::error::{Error, Result, Warnings};
use crate::files::write_atomically;
use crate::gpu::Device;
use crate::image::exr;
use crate::kernels::image_matrix::{self, ImageOptions};
use crate::kernels::product::Multiplier;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::matrix::file::write_float_header;
use crate::matrix::rows::MatrixRows;
use crate::progress::Progress;
use crate::scene::{Scene, Window};
use std::path::{Path, PathBuf};

/// Most pixels in a row or column.
const MOST_PIXELS: u64 = 16_384;
/// Memory for the product of pictures, bytes.
const PICTURE_MEMORY: u64 = 1 << 30;

/// One `[[view]]`: a camera with one picture per hour.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewSection {
    /// Name of its matrix and its folder of pictures.
    pub name: String,
    /// View file.
    pub file: PathBuf,
    /// Most pixels per row, and most rows; pixels stay square.
    pub resolution: [usize; 2],
}

impl ViewSection {
    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"desk\" or the like")?;
        let file = table.required_path("file", "add file = \"….vf\": a file with a line of view options")?;
        let resolution = match table.integers("resolution", 1..=MOST_PIXELS)? {
            None => [512, 512],
            Some(size) => <[u64; 2]>::try_from(size)
                .map_err(|_| table.error("resolution", "a resolution is two numbers").help("write resolution = [400, 400]"))?
                .map(|n| n as usize),
        };
        table.finish()?;
        Ok(Self { name, file, resolution })
    }

    /// Its pixels.
    ///
    /// # Errors
    /// A view file that cannot be read or makes no sense.
    pub fn raster(&self) -> Result<Raster> {
        let camera = View::read(&self.file)?.camera().map_err(|e| e.file(&self.file))?;
        Raster::fit(camera, self.resolution[0], self.resolution[1], 1.0).map_err(|e| e.file(&self.file))
    }
}

/// Hours of which pictures are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ImageHours {
    /// None: only the view matrices are kept.
    None,
    /// All whose sky is not black.
    Daylight,
    /// These, by number of the year from 0.
    Chosen(Vec<usize>),
}

/// `[images]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImagesSection {
    /// Hours to write.
    pub hours: ImageHours,
}

impl ImagesSection {
    pub(super) fn read(table: Option<Table<'_, '_>>) -> Result<Self> {
        let mut images = Self { hours: ImageHours::None };
        let Some(mut table) = table else { return Ok(images) };
        images.hours = match table.integers_or_choice("hours", 0..=1_000_000, &["daylight", "none"])? {
            None => ImageHours::None,
            Some(Ok(hours)) => ImageHours::Chosen(hours.into_iter().map(|h| h as usize).collect()),
            Some(Err("daylight")) => ImageHours::Daylight,
            Some(Err(_)) => ImageHours::None,
        };
        table.finish()?;
        Ok(images)
    }
}

/// What the pictures of one view are made from.
pub struct ViewJob<'a> {
    /// Device that traces.
    pub device: &'a Device,
    /// Room.
    pub scene: &'a Scene,
    /// Windows in the order of the bins.
    pub windows: &'a [Window],
    /// The view.
    pub view: &'a ViewSection,
    /// Sampling.
    pub options: ImageOptions,
    /// Where results go.
    pub store: &'a Store,
    /// Progress.
    pub progress: &'a dyn Progress,
}

impl ViewJob<'_> {
    /// Computes the view matrix into `matrices/V_NAME.mtx`, unless one of the same inputs is there.
    /// Returns rows, columns and whether it was reused.
    ///
    /// # Errors
    /// As [`image_matrix::compute`], and failures of the file system.
    pub fn matrix(&self, inputs: Fingerprint, statistics: &mut TraceStatistics) -> Result<(usize, usize, bool)> {
        let raster = self.view.raster()?;
        let bins = self.windows.iter().map(|w| w.basis.len()).sum();
        let path = self.store.matrix_path(&format!("V_{}", self.view.name));
        if kept(&path, inputs, [raster.len(), bins]) {
            return Ok((raster.len(), bins, true));
        }
        let header = [
            software(),
            "CONTENT=view matrix, rows pixels from the top left, columns the windows' bins".to_string(),
            format!("{INPUTS}={inputs}"),
            format!("VIEW= {}", raster.camera().view().to_options()),
            format!("RESOLUTION=-Y {} +X {}", raster.height(), raster.width()),
        ];
        write_atomically(&path, |out| {
            write_float_header(out, [raster.len(), bins, 3], &header)?;
            let mut bytes = Vec::new();
            let found = image_matrix::compute(self.device, self.scene, self.windows, &raster, &self.options, self.progress, &mut |rows| {
                bytes.clear();
                bytes.extend(rows.values.iter().flat_map(|v| v.to_le_bytes()));
                out.write_all(&bytes).map_err(|e| Error::io(&path, &e))
            })?;
            statistics.paths += found.paths;
            statistics.segments += found.segments;
            Ok(())
        })?;
        Ok((raster.len(), bins, false))
    }

    /// Writes `images/NAME/img_%04d.hdr`, numbered by hour, from the stored view matrix. Returns how
    /// many.
    ///
    /// # Errors
    /// Hours that the weather file does not have, and failures of device and file system.
    pub fn pictures(
        &self,
        multiplier: &dyn Multiplier,
        transmitted: &Matrix<f64>,
        sky: &Matrix<f32>,
        hours: &ImageHours,
        warnings: &mut Warnings,
    ) -> Result<usize> {
        let hours = match hours {
            ImageHours::None => return Ok(0),
            ImageHours::Daylight => lit_columns(sky),
            ImageHours::Chosen(hours) => {
                check_hours(hours, "the weather file", sky.cols()).map_err(|e| e.field("images.hours"))?;
                hours.clone()
            }
        };
        let folder = self.store.image_folder(&self.view.name)?;
        let matrix = self.store.matrix_path(&format!("V_{}", self.view.name));
        let mut view = PictureView::open(&matrix.display().to_string(), None)?;
        let transmitted = transmitted.map(|v| v as f32);
        let coefficients = crate::simulate::multiply::product(
            multiplier,
            vec![
                crate::simulate::multiply::Factor { name: "T·D".into(), matrix: transmitted },
                crate::simulate::multiply::Factor { name: "S".into(), matrix: select_columns(sky, &hours) },
            ],
            None,
        )?;
        let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
        let output = Output::parse(&folder.join("img_%04d.hdr").display().to_string(), options)?;
        let header = [software()];
        let request = Request { coefficients: &coefficients, hours: &hours, output: &output, header: &header, memory: PICTURE_MEMORY };
        write_pictures(multiplier, &mut view, &request, self.progress, warnings)?;
        Ok(hours.len())
    }
}

/// Whether a matrix file of these inputs and shape is there, by its header alone.
fn kept(path: &Path, inputs: Fingerprint, [rows, cols]: [usize; 2]) -> bool {
    let Ok(Some(file)) = MatrixRows::open(path) else { return false };
    let line = format!("{INPUTS}={inputs}");
    file.header().contains(&line) && (file.rows(), file.cols(), file.components()) == (rows, cols, 3)
}
