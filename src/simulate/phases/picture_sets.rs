//! Component pictures of a project's views: those made elsewhere in place of what is traced here, and
//! those that a run writes.
//!
//! | key of `[[view]]` | pictures | made by |
//! |---|---|---|
//! | `view`, `view_matrix/direct` | V, Vd: one per bin of all windows in the project's order | `rfluxmtx -o v%03d.hdr`; the same in a black room with `-ab 1`, times the map of reflectances |
//! | `sun` | C: one per sun of an earlier run's `suns.rad`, or the ground and all suns of MF:n | `rcontrib -o c%04d.hdr -m solar` |
//!
//! `[images] components = true` writes the same into `images/VIEW/components`: `V%03d.hdr`, `Vd%03d.hdr`,
//! `C%04d.hdr`. RGBE keeps a value to half a per cent of its pixel's largest channel.

use crate::camera::Raster;
use crate::error::{Error, Result};
use crate::files::AtomicFile;
use crate::image::hdr::{self, Exposure};
use crate::image::series::{Pattern, PictureSet, SetWriter};
use crate::kernels::sun_matrix::pixels::SunPicture;
use crate::matrix::file::write_float_header;
use crate::matrix::rows::MatrixRows;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::store::fingerprint::Fingerprint;
use crate::simulate::store::sun_pictures::SunPictures;
use crate::simulate::store::{Store, header, software};
use std::path::Path;

/// Pixels of a band.
const BAND_PIXELS: usize = 1 << 14;

fn check_size(pattern: &Pattern, [width, height]: [usize; 2], raster: &Raster) -> Result<()> {
    if (width, height) == (raster.width(), raster.height()) {
        return Ok(());
    }
    let wanted = format!("{} × {}", raster.width(), raster.height());
    Err(Error::new(format!("the pictures have {width} × {height} pixels, the view has {wanted}"))
        .file(pattern.path(0))
        .help("resolution = [columns, rows] in [[view]] tells the most pixels; vwrays -d the size that a view fits"))
}

/// Puts component pictures of V and, if there are any, Vd into matrix files `[pixel][bin]`. `rows` is shown
/// the first set's pixels with their values, in bands.
///
/// # Errors
/// Pictures that are missing, damaged or of another size or number, and failures of the file system.
#[allow(clippy::type_complexity, reason = "one function")]
pub(crate) fn import(
    sets: &[Option<(&Pattern, &Path)>; 2],
    raster: &Raster,
    bins: usize,
    inputs: Fingerprint,
    rows: &mut dyn FnMut(&[(usize, &[f32])]),
) -> Result<()> {
    for (number, (pattern, path)) in sets.iter().flatten().enumerate() {
        let set = PictureSet::open(pattern, Some(bins), Exposure::Undo)?;
        check_size(pattern, [set.width(), set.height()], raster)?;
        let more =
            [format!("VIEW= {}", raster.camera().view().to_options()), format!("RESOLUTION=-Y {} +X {}", raster.height(), raster.width())];
        let about = format!("view matrix from pictures {pattern}, rows pixels from the top left, columns the windows' bins");
        let header = header(inputs, &about, &more);
        crate::files::seal::write_sealed(path, |out| {
            write_float_header(out, [raster.len(), bins, 3], &header)?;
            let (mut reader, mut values) = (set.rows(), Vec::new());
            let mut first = 0;
            while reader.read((BAND_PIXELS / raster.width()).max(1), &mut values)? > 0 {
                if number == 0 {
                    let band: Vec<(usize, &[f32])> = values.chunks_exact(bins * 3).enumerate().map(|(i, v)| (first + i, v)).collect();
                    rows(&band);
                }
                first += values.len() / (bins * 3);
                let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
                out.write_all(&bytes).map_err(|e| Error::io(path, &e))?;
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// Pictures of suns made elsewhere.
pub(crate) struct SunsGiven<'a> {
    pattern: &'a Pattern,
    raster: &'a Raster,
    /// Number of the picture of each sun.
    numbers: Vec<usize>,
}

impl<'a> SunsGiven<'a> {
    /// # Errors
    /// Gaps, and numbers of pictures that are neither that of all suns of the scheme nor that of those traced.
    pub(crate) fn open(pattern: &'a Pattern, set: &SunSet, raster: &'a Raster) -> Result<Self> {
        let found = pattern.existing()?;
        if let Some(gap) = (0..).zip(&found).find_map(|(wanted, &number)| (wanted != number).then_some(wanted)) {
            return Err(Error::new(format!("{} is missing", pattern.path(gap).display()))
                .help("the pictures of a set are numbered from 0 without gaps"));
        }
        let numbers = match found.len() {
            n if n == set.suns.len() => (0..n).collect(),
            n if n == set.all_columns => set.columns.clone(),
            n => {
                return Err(Error::new(format!(
                    "there are {n} pictures {pattern}; the project needs {} (all suns and the ground) or {} (those of suns.rad)",
                    set.all_columns,
                    set.suns.len()
                ))
                .help("suns = 6 in [method] means MF:6, whose pictures are 0 (the ground) to 5185"));
            }
        };
        Ok(Self { pattern, raster, numbers })
    }

    /// The picture of a sun.
    ///
    /// # Errors
    /// A picture that is damaged or of another size.
    pub(crate) fn read(&self, sun: usize) -> Result<SunPicture> {
        let picture = hdr::read_with(&self.pattern.path(self.numbers[sun]), Exposure::Undo)?;
        check_size(self.pattern, [picture.width, picture.height], self.raster)?;
        let lit = |v: &[f32; 3]| v.iter().any(|c| *c > 0.0);
        let pixels: Vec<_> = (0u32..).zip(picture.pixels).filter(|(_, v)| lit(v)).collect();
        let none = vec![0.0; pixels.len()];
        // The disc is where the renderer put it.
        Ok(SunPicture { pixels, errors: none.clone(), shared_errors: none, ..SunPicture::default() })
    }
}

/// Writes the kept view matrices of a view, and the suns in its pictures, as component pictures.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn export(store: &Store, view: &str, suns: Option<(&SunSet, &SunPictures)>) -> Result<()> {
    let folder = store.image_folder(view)?.join("components");
    std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
    let pattern = |name: &str| Pattern::inside(&folder, name);
    let mut size = None;
    for (suffix, name) in [("", "V%03d.hdr"), ("_direct", "Vd%03d.hdr")] {
        let path = store.matrix_path(&format!("V_{view}{suffix}"));
        let Some(mut matrix) = path.is_file().then(|| MatrixRows::open(&path)).transpose()?.flatten() else { continue };
        let value = |key: &str| matrix.header().iter().find_map(|l| l.strip_prefix(key)).map(|v| v.trim().to_string());
        let numbers = value("RESOLUTION=").map(|r| r.split_whitespace().filter_map(|w| w.parse().ok()).collect::<Vec<usize>>());
        let Some([height, width]) = numbers.as_deref().and_then(|n| <[usize; 2]>::try_from(n).ok()) else {
            return Err(Error::new("the matrix does not tell the size of its pictures").file(&path));
        };
        let options = value("VIEW=");
        size = Some(([width, height], options.clone()));
        let mut writer = SetWriter::create(&pattern(name)?, matrix.cols(), [width, height], options.as_deref(), |_| vec![software()])?;
        let mut values = Vec::new();
        while matrix.read(width * (BAND_PIXELS / width).max(1), &mut values)? > 0 {
            writer.write(&values)?;
        }
        writer.finish()?;
    }
    let (Some((set, pictures)), Some(([width, height], options))) = (suns, size) else { return Ok(()) };
    let pattern = pattern("C%04d.hdr")?;
    let mut files: Vec<AtomicFile> = Vec::new();
    for sun in 0..set.suns.len() {
        let mut pixels = vec![[0.0f32; 3]; width * height];
        for (pixel, value) in pictures.of_sun(sun, 1.0)? {
            pixels[pixel as usize] = value;
        }
        let mut writer = hdr::create(&pattern.path(sun), width, height, options.as_deref(), &[software()])?;
        pixels.chunks_exact(width).try_for_each(|row| writer.write(row))?;
        files.push(writer.finish()?);
        // Few files are open at a time.
        if files.len() == 64 || sun + 1 == set.suns.len() {
            files.drain(..).try_for_each(AtomicFile::commit)?;
        }
    }
    Ok(())
}
