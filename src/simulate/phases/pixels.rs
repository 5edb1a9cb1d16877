//! V of the pixels of a view, kept on disk with its direct part and its batches.

use super::picture_sets;
use crate::camera::Raster;
use crate::error::{Error, Result};
use crate::files::seal::write_sealed;
use crate::glare::PixelGeometry;
use crate::kernels::glare::BatchSums;
use crate::kernels::image_matrix::{self, ImageOptions, KnownPixels, PixelRows};
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::matrix::file::write_float_header;
use crate::scene::Window;
use crate::simulate::context::Context;
use crate::simulate::project::views::ViewSection;
use crate::simulate::store::fingerprint::Fingerprint;
use crate::simulate::store::{header, is_of};
use rayon::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What the view matrix of one view is made from.
pub(crate) struct ViewJob<'a> {
    /// The run.
    pub context: Context<'a>,
    /// Windows in the order of the bins.
    pub windows: &'a [Window],
    /// The view.
    pub view: &'a ViewSection,
    /// Sampling.
    pub options: ImageOptions,
    /// Batches as a multiple of the options': so many together make one of those that are kept.
    pub refinement: u32,
}

impl ViewJob<'_> {
    /// Rows and columns of the view matrix if one of the same inputs is there, with all that belongs to it.
    ///
    /// # Errors
    /// A view that cannot be.
    pub(crate) fn kept(&self, inputs: Fingerprint) -> Result<Option<(usize, usize)>> {
        let raster = self.view.raster()?;
        let bins = self.windows.iter().map(|w| w.basis.len()).sum();
        let kept = |path: &Path, rows: usize| self.context.store.has(path, &|path| is_of(path, inputs, (rows, bins, 3)));
        let rows = self.batch_rows(&raster).unwrap_or(0) * self.options.batches as usize;
        let there = kept(&self.context.store.matrix_path(&format!("V_{}", self.view.name)), raster.len())
            && (!self.options.direct || kept(&self.direct_path(), raster.len()))
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
    pub(crate) fn matrix(&self, inputs: Fingerprint, statistics: &mut TraceStatistics) -> Result<(usize, usize, bool)> {
        if let Some((rows, columns)) = self.kept(inputs)?.filter(|_| self.view.given.view.is_none()) {
            return Ok((rows, columns, true));
        }
        let raster = self.view.raster()?;
        let bins = self.windows.iter().map(|w| w.basis.len()).sum();
        let path = self.context.store.matrix_path(&format!("V_{}", self.view.name));
        let direct_path = self.direct_path();
        // A view without directions (parallel) has no glare, and no need of batches.
        let geometry = PixelGeometry::new(&raster).ok();
        let batches = if geometry.is_some() { self.options.batches as usize } else { 0 };
        let mut sums: Vec<BatchSums> = geometry.iter().flat_map(|g| vec![BatchSums::new(g, bins); batches]).collect();
        let rows = sums.iter().map(BatchSums::rows).sum();
        let with_direct = self.options.direct;
        if let Some(given) = &self.view.given.view {
            let direct = self.view.given.view_direct.as_ref().filter(|_| with_direct).map(|d| (d, direct_path.as_path()));
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
        let more =
            [format!("VIEW= {}", raster.camera().view().to_options()), format!("RESOLUTION=-Y {} +X {}", raster.height(), raster.width())];
        let header = header(inputs, "view matrix, rows pixels from the top left, columns the windows' bins", &more);
        let stage =
            self.context.store.stage(&format!("V_{}", self.view.name), *inputs.clone().add(&self.refinement), self.context.progress);
        let mut trace = |out: &mut dyn Write, direct: Option<&mut dyn Write>| {
            let mut direct = direct;
            write_float_header(out, [raster.len(), bins, 3], &header)?;
            if let Some(direct) = &mut direct {
                write_float_header(*direct, [raster.len(), bins, 3], &header)?;
            }
            let mut write = |tile: &Tile| -> Result<()> {
                out.write_all(&tile.values).map_err(|e| Error::io(&path, &e))?;
                if let Some(direct) = &mut direct {
                    direct.write_all(&tile.direct).map_err(|e| Error::io(&direct_path, &e))?;
                }
                Ok(())
            };
            // What an earlier run finished.
            let mut known = KnownPixels::default();
            while let Some(bytes) = stage.journal().known()? {
                let tile = Tile::of_bytes(&bytes, [bins, with_direct.into()], &mut sums)?;
                write(&tile)?;
                known.count += tile.values.len() / (bins * 12);
                known.lit |= tile.values.iter().any(|v| *v != 0);
            }
            let (batches, subpixels) = (self.options.batches * self.refinement, self.options.subpixels * self.refinement);
            let options = ImageOptions { batches, subpixels, ..self.options };
            let context = &self.context;
            let scene = &context.inputs.scene;
            let found = image_matrix::go_on(context.device, scene, self.windows, &raster, &options, known, &stage, &mut |rows| {
                if let Some(geometry) = &geometry {
                    add_batches(&mut sums, geometry, &rows, bins);
                }
                let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect();
                let tile = Tile { values: bytes(&rows.values), direct: bytes(&rows.direct) };
                write(&tile)?;
                stage.journal().add(&tile.into_bytes(&sums))
            })?;
            statistics.add(found);
            Ok(())
        };
        if with_direct {
            write_sealed(&direct_path, |direct| write_sealed(&path, |out| trace(out, Some(direct))))?;
        } else {
            write_sealed(&path, |out| trace(out, None))?;
        }
        if !sums.is_empty() {
            let values = sums.iter().flat_map(BatchSums::sums).map(|&v| (v / f64::from(self.refinement)) as f32).collect();
            self.keep_batches(values, (rows, bins), inputs)?;
        }
        stage.finish();
        Ok((raster.len(), bins, false))
    }

    fn keep_batches(&self, values: Vec<f32>, (rows, bins): (usize, usize), inputs: Fingerprint) -> Result<()> {
        let matrix = Matrix::from_data(rows, bins, 3, values)?;
        let about = "independent batches of the view matrix, rows Ev and sums over blocks of pixels";
        self.context.store.save(&format!("V_{}_batches", self.view.name), &matrix, inputs, about)
    }

    /// Where the direct part of the view matrix is kept.
    pub(crate) fn direct_path(&self) -> PathBuf {
        self.context.store.matrix_path(&format!("V_{}_direct", self.view.name))
    }

    /// Where the batches of the view matrix are kept, reduced to what the noise of glare needs.
    pub(crate) fn batches_path(&self) -> PathBuf {
        self.context.store.matrix_path(&format!("V_{}_batches", self.view.name))
    }
}

/// Rows of some pixels as their files have them.
struct Tile {
    values: Vec<u8>,
    direct: Vec<u8>,
}

impl Tile {
    /// With the sums over all pixels so far.
    fn into_bytes(self, sums: &[BatchSums]) -> Vec<u8> {
        let sums = sums.iter().flat_map(BatchSums::sums).flat_map(|v| v.to_le_bytes());
        sums.chain(self.values).chain(self.direct).collect()
    }

    /// Sets the sums to what they were.
    fn of_bytes(bytes: &[u8], [bins, direct]: [usize; 2], sums: &mut [BatchSums]) -> Result<Self> {
        let length = sums.iter().map(|s| s.sums().len() * 8).sum();
        let whole = bytes.split_at_checked(length).filter(|(_, rows)| rows.len() % (bins * 12 * (1 + direct)) == 0);
        let (of_sums, rows) = whole.ok_or_else(|| Error::new("a kept part of a picture has another size than the picture"))?;
        let values = sums.iter_mut().flat_map(BatchSums::sums_mut);
        values.zip(of_sums.as_chunks::<8>().0).for_each(|(value, bytes)| *value = f64::from_le_bytes(*bytes));
        let (values, direct) = rows.split_at(rows.len() / (1 + direct));
        Ok(Self { values: values.to_vec(), direct: direct.to_vec() })
    }
}

/// Adds the rows of some pixels to each batch's sums; there may be several batches to each of them.
fn add_batches(sums: &mut [BatchSums], geometry: &PixelGeometry, rows: &PixelRows, bins: usize) {
    let row = bins * 3;
    let batches = rows.batches.len() / (rows.pixels * row).max(1);
    let count = sums.len();
    let each = batches / count;
    sums.par_iter_mut().enumerate().for_each(|(number, sums)| {
        let mut doubt = vec![0.0; row];
        for (i, values) in rows.batches.chunks_exact(batches * row).enumerate() {
            for batch in number * each..(number + 1) * each {
                sums.add(geometry, rows.first + i, &values[batch * row..(batch + 1) * row]);
            }
            let place = (i, rows.first + i);
            if rows.doubts.fill(place, (number, count), each as f64, &mut doubt) {
                sums.add(geometry, rows.first + i, &doubt);
            }
        }
    });
}
