//! Pictures of a project: `[[view]]` and `[images]`, their view matrices and hourly pictures.

use super::fingerprint::Fingerprint;
use super::five_phase::{FivePhase, without_sun_patches};
use super::multiply::{check_hours, lit_columns, select_columns};
use super::picture_sets::{self, GivenPictures};
use super::pictures::{Addition, Output, PictureView, Request, write_pictures};
use super::project::name;
use super::store::{INPUTS, Store, is_of, software};
use super::sun_pictures::SunPictures;
use super::table::{Place, Table};
use crate::camera::{Raster, View};
use crate::error::{Error, Result, Warnings};
use crate::files::write_atomically;
use crate::glare::PixelGeometry;
use crate::gpu::Device;
use crate::image::exr;
use crate::kernels::glare::BatchSums;
use crate::kernels::image_matrix::{self, ImageOptions, PixelRows};
use crate::kernels::product::Multiplier;
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::matrix::file::{Format, write_float_header, write_matrix};
use crate::progress::Progress;
use crate::scene::{Scene, Window};
use rayon::prelude::*;
use std::io::Write;
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
    /// View file, or the file of points that the view stands on.
    pub file: PathBuf,
    /// The view itself, if it is not in a view file.
    pub view: Option<View>,
    /// Most pixels per row, and most rows; pixels stay square.
    pub resolution: [usize; 2],
    /// Where the resolution stands in the project file.
    pub(super) place: Place,
    /// Pictures made elsewhere.
    pub given: GivenPictures,
}

impl ViewSection {
    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"desk\" or the like")?;
        let file = table.required_path("file", "add file = \"….vf\": a file with a line of view options")?;
        let resolution = resolution(&mut table)?.unwrap_or([512, 512]);
        let given = GivenPictures::read(&mut table)?;
        let place = table.place("resolution");
        table.finish()?;
        Ok(Self { name, file, view: None, resolution, place, given })
    }

    /// The view, not yet checked.
    ///
    /// # Errors
    /// A view file that cannot be read or makes no sense.
    pub fn view(&self) -> Result<View> {
        self.view.map_or_else(|| View::read(&self.file), Ok)
    }

    /// Its pixels.
    ///
    /// # Errors
    /// A view file that cannot be read or makes no sense.
    pub fn raster(&self) -> Result<Raster> {
        let camera = self.view()?.camera().map_err(|e| e.file(&self.file))?;
        let [width, height] = self.resolution;
        Raster::fit(camera, width, height, 1.0).map_err(|_| {
            let fault = format!("{width} × {height} square pixels are too few for a view {:.3} times as high as wide", camera.aspect());
            self.place.of(Error::new(fault).help("give more pixels, or another -vh or -vv in the view file"))
        })
    }
}

/// The key `resolution`: most pixels per row, and most rows.
pub(super) fn resolution(table: &mut Table<'_, '_>) -> Result<Option<[usize; 2]>> {
    let Some(size) = table.integers("resolution", 1..=MOST_PIXELS)? else { return Ok(None) };
    let size = <[u64; 2]>::try_from(size)
        .map_err(|_| table.error("resolution", "a resolution is two numbers").help("write resolution = [400, 400]"))?;
    Ok(Some(size.map(|n| n as usize)))
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
    /// Whether V, Vd and the suns are written as component pictures too.
    pub components: bool,
    /// Where the hours stand in the project file, if there is such a section.
    pub(super) place: Option<Place>,
}

impl ImageHours {
    /// The hours, by number of the year.
    ///
    /// # Errors
    /// Hours that the sky matrix does not have.
    pub fn chosen(&self, sky: &Matrix<f32>) -> Result<Vec<usize>> {
        match self {
            ImageHours::None => Ok(Vec::new()),
            ImageHours::Daylight => Ok(lit_columns(sky)),
            ImageHours::Chosen(hours) => {
                check_hours(hours, "the weather file", sky.cols())?;
                Ok(hours.clone())
            }
        }
    }
}

impl ImagesSection {
    pub(super) fn read(table: Option<Table<'_, '_>>) -> Result<Self> {
        let mut images = Self { hours: ImageHours::None, components: false, place: None };
        let Some(mut table) = table else { return Ok(images) };
        images.hours = match table.integers_or_choice("hours", 0..=1_000_000, &["daylight", "none"])? {
            None => ImageHours::None,
            Some(Ok(hours)) => ImageHours::Chosen(hours.into_iter().map(|h| h as usize).collect()),
            Some(Err("daylight")) => ImageHours::Daylight,
            Some(Err(_)) => ImageHours::None,
        };
        images.components = table.boolean("components")?.unwrap_or(false);
        images.place = Some(table.place("hours"));
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
    /// Batches as a multiple of the options'; as many together make one of those that are kept.
    pub refinement: u32,
    /// Where results go.
    pub store: &'a Store,
    /// Progress.
    pub progress: &'a dyn Progress,
}

impl ViewJob<'_> {
    /// Rows and columns of the view matrix if one of the same inputs is there, with all that belongs to it.
    ///
    /// # Errors
    /// A view that cannot be.
    pub fn kept(&self, inputs: Fingerprint) -> Result<Option<(usize, usize)>> {
        let raster = self.view.raster()?;
        let bins = self.windows.iter().map(|w| w.basis.len()).sum();
        let kept = |path: &Path, rows: usize| self.store.has(path, &|path| is_of(path, inputs, (rows, bins, 3)));
        let rows = self.batch_rows(&raster).unwrap_or(0) * self.options.batches as usize;
        let there = kept(&self.store.matrix_path(&format!("V_{}", self.view.name)), raster.len())
            && (!self.options.straight || kept(&self.direct_path(), raster.len()))
            && (rows == 0 || kept(&self.batches_path(), rows));
        Ok(there.then_some((raster.len(), bins)))
    }

    /// Rows of a batch's sums. A view without directions (parallel) has no glare, and no need of batches.
    fn batch_rows(&self, raster: &Raster) -> Option<usize> {
        PixelGeometry::new(raster).ok().map(|g| BatchSums::new(&g, 0).rows())
    }

    /// Computes the view matrix into `matrices/V_NAME.mtx`, unless one of the same inputs is there.
    /// Returns rows, columns and whether it was reused.
    ///
    /// # Errors
    /// As [`image_matrix::compute`], and failures of the file system.
    pub fn matrix(&self, inputs: Fingerprint, statistics: &mut TraceStatistics) -> Result<(usize, usize, bool)> {
        if let Some((rows, columns)) = self.kept(inputs)?.filter(|_| self.view.given.view.is_none()) {
            return Ok((rows, columns, true));
        }
        let raster = self.view.raster()?;
        let bins = self.windows.iter().map(|w| w.basis.len()).sum();
        let path = self.store.matrix_path(&format!("V_{}", self.view.name));
        let direct_path = self.direct_path();
        // A view without directions (parallel) has no glare, and no need of batches.
        let geometry = PixelGeometry::new(&raster).ok();
        let batches = if geometry.is_some() { self.options.batches as usize } else { 0 };
        let mut sums: Vec<BatchSums> = geometry.iter().flat_map(|g| vec![BatchSums::new(g, bins); batches]).collect();
        let rows = sums.iter().map(BatchSums::rows).sum();
        let straight = self.options.straight;
        if let Some(given) = &self.view.given.view {
            let direct = self.view.given.view_direct.as_ref().filter(|_| straight).map(|d| (d, direct_path.as_path()));
            let sets = [Some((given, path.as_path())), direct];
            picture_sets::import(&sets, &raster, bins, inputs, &mut |rows| {
                if let (Some(geometry), [sums, ..]) = (&geometry, &mut sums[..]) {
                    rows.iter().for_each(|(pixel, values)| sums.add(geometry, *pixel, values));
                }
            })?;
            // Taken for exact: all batches are the same.
            if let Some(first) = sums.first().map(|s| s.sums().to_vec()) {
                let all: Vec<f32> = (0..batches).flat_map(|_| first.iter().map(|&v| v as f32)).collect();
                self.keep_batches(all, (rows, bins), inputs)?;
            }
            return Ok((raster.len(), bins, false));
        }
        let header = [
            software(),
            "CONTENT=view matrix, rows pixels from the top left, columns the windows' bins".to_string(),
            format!("{INPUTS}={inputs}"),
            format!("VIEW= {}", raster.camera().view().to_options()),
            format!("RESOLUTION=-Y {} +X {}", raster.height(), raster.width()),
        ];
        let mut trace = |out: &mut dyn Write, direct: Option<&mut dyn Write>| {
            let mut direct = direct;
            write_float_header(out, [raster.len(), bins, 3], &header)?;
            if let Some(direct) = &mut direct {
                write_float_header(*direct, [raster.len(), bins, 3], &header)?;
            }
            let mut bytes = Vec::new();
            let (batches, subpixels) = (self.options.batches * self.refinement, self.options.subpixels * self.refinement);
            let options = ImageOptions { batches, subpixels, ..self.options };
            let found = image_matrix::compute(self.device, self.scene, self.windows, &raster, &options, self.progress, &mut |rows| {
                if let Some(geometry) = &geometry {
                    add_batches(&mut sums, geometry, &rows, bins);
                }
                bytes.clear();
                bytes.extend(rows.values.iter().flat_map(|v| v.to_le_bytes()));
                out.write_all(&bytes).map_err(|e| Error::io(&path, &e))?;
                if let Some(direct) = &mut direct {
                    bytes.clear();
                    bytes.extend(rows.straight.iter().flat_map(|v| v.to_le_bytes()));
                    direct.write_all(&bytes).map_err(|e| Error::io(&direct_path, &e))?;
                }
                Ok(())
            })?;
            statistics.paths += found.paths;
            statistics.segments += found.segments;
            Ok(())
        };
        if straight {
            write_atomically(&direct_path, |direct| write_atomically(&path, |out| trace(out, Some(direct))))?;
        } else {
            write_atomically(&path, |out| trace(out, None))?;
        }
        if !sums.is_empty() {
            let values = sums.iter().flat_map(BatchSums::sums).map(|&v| (v / f64::from(self.refinement)) as f32).collect();
            self.keep_batches(values, (rows, bins), inputs)?;
        }
        Ok((raster.len(), bins, false))
    }

    fn keep_batches(&self, values: Vec<f32>, (rows, bins): (usize, usize), inputs: Fingerprint) -> Result<()> {
        let matrix = Matrix::from_data(rows, bins, 3, values)?;
        let about = "CONTENT=independent batches of the view matrix, rows Ev and sums over blocks of pixels";
        let header = [software(), about.to_string(), format!("{INPUTS}={inputs}")];
        write_matrix(Some(&self.batches_path()), &matrix, Format::Float, &header)
    }

    /// Where the straight part of the view matrix is kept.
    fn direct_path(&self) -> PathBuf {
        self.store.matrix_path(&format!("V_{}_direct", self.view.name))
    }

    /// Where the batches of the view matrix are kept, reduced to what the noise of glare needs.
    pub fn batches_path(&self) -> PathBuf {
        self.store.matrix_path(&format!("V_{}_batches", self.view.name))
    }

    /// Writes `images/NAME/img_%04d.hdr`, numbered by hour, from the stored view matrix; with five
    /// phases (their terms, T·Dd of the windows with a shade, the suns' pictures) the sun goes out of the
    /// product and comes back as traced. Returns how many.
    ///
    /// # Errors
    /// Hours that the weather file does not have, and failures of device and file system.
    pub fn pictures(
        &self,
        multiplier: &dyn Multiplier,
        transmitted: &Matrix<f64>,
        sky: &Matrix<f32>,
        hours: &[usize],
        five: Option<(&FivePhase<'_>, &Matrix<f64>, &SunPictures)>,
        warnings: &mut Warnings,
    ) -> Result<usize> {
        if hours.is_empty() {
            return Ok(0);
        }
        let folder = self.store.image_folder(&self.view.name)?;
        let matrix = self.store.matrix_path(&format!("V_{}", self.view.name));
        let sun = five.and_then(|(five, shaded, _)| five.sun_at_windows(multiplier, shaded, hours).transpose()).transpose()?;
        let mut view = match &sun {
            None => PictureView::open(&matrix.display().to_string(), None)?,
            Some(_) => PictureView::open_split(&matrix, &self.direct_path())?,
        };
        let transmitted = transmitted.map(|v| v as f32);
        let coefficients = crate::simulate::multiply::product(
            multiplier,
            vec![
                crate::simulate::multiply::Factor { name: "T·D".into(), matrix: transmitted },
                crate::simulate::multiply::Factor { name: "S".into(), matrix: select_columns(sky, hours) },
            ],
            None,
        )?;
        let coefficients = match sun {
            None => coefficients,
            Some(sun) => without_sun_patches(&coefficients, &sun),
        };
        let sun_picture = |hour: usize| five.map_or_else(|| Ok(Vec::new()), |(_, _, suns)| suns.sun_picture(hour));
        let addition: Option<&Addition<'_>> = if five.is_some() { Some(&sun_picture) } else { None };
        let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
        let output = Output::parse(&folder.join("img_%04d.hdr").display().to_string(), options)?;
        let header = [software()];
        let request = Request { coefficients: &coefficients, hours, output: &output, header: &header, memory: PICTURE_MEMORY, addition };
        write_pictures(multiplier, &mut view, &request, self.progress, warnings)?;
        Ok(hours.len())
    }
}

/// Adds the rows of some pixels to each batch's sums; there may be several batches to each of them.
fn add_batches(sums: &mut [BatchSums], geometry: &PixelGeometry, rows: &PixelRows, bins: usize) {
    let row = bins * 3;
    let batches = rows.batches.len() / (rows.pixels * row).max(1);
    let each = batches / sums.len();
    sums.par_iter_mut().enumerate().for_each(|(number, sums)| {
        for (i, values) in rows.batches.chunks_exact(batches * row).enumerate() {
            for batch in number * each..(number + 1) * each {
                sums.add(geometry, rows.first + i, &values[batch * row..(batch + 1) * row]);
            }
        }
    });
}
