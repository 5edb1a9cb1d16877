//! Pictures of single steps from a result folder: `[V − Vd | Vd] · [X ; X − Xsun] + C`.

use super::arrays::{ViewFile, Year};
use super::facade::{Facade, FacadeState};
use crate::error::{Error, Result};
use crate::files::seal;
use crate::image::Picture;
use crate::kernels::glare::PixelSource;
use crate::kernels::product::{Arrangement, Multiplier, Native};
use crate::kernels::sun_matrix::pixels::SparsePicture;
use crate::matrix::rows::MatrixRows;
use crate::simulate::results::pictures::PictureView;
use crate::simulate::store::sun_pictures::SunPictures;

/// Rows of pixels that are multiplied at once.
const BAND: usize = 64;

/// What the light of a view is made of: that of the windows, and the suns' own.
pub struct ViewLight {
    /// The windows.
    pub facade: Facade,
    /// With five phases: what the suns put into this view.
    suns: Option<SunPictures>,
}

/// Light of a view at a step.
pub struct StepLight {
    /// The right factor for V, or for V − Vd beside Vd, `[term][rgb]`.
    pub terms: Vec<f32>,
    /// What the traced sun adds: pixels in rising order, RGB radiance.
    pub sun: SparsePicture,
    /// Whether the sun is as traced; else it is in the patches of the sky.
    pub sun_is_traced: bool,
}

impl StepLight {
    /// Adds what the traced sun puts into a picture.
    pub fn add_sun(&self, pixels: &mut [[f32; 3]]) {
        for (pixel, value) in &self.sun {
            if let Some(to) = pixels.get_mut(*pixel as usize) {
                to.iter_mut().zip(value).for_each(|(to, value)| *to += value);
            }
        }
    }
}

impl ViewLight {
    /// Reads what belongs to a view.
    ///
    /// # Errors
    /// Matrices that cannot be read, or a view matrix of other windows.
    pub fn read(year: &Year, view: &ViewFile) -> Result<Self> {
        let facade = Facade::read(year)?;
        let bins = facade.bins();
        if bins != view.bins {
            return Err(Error::new(format!("the view matrix has {} columns, the windows have {bins} bins", view.bins))
                .file(&view.matrix)
                .help("run the project again"));
        }
        // A project without pictures and glare has no suns' pictures: its suns stay in the patches.
        let path = view.suns();
        [&view.matrix, &view.direct_matrix(), &path].into_iter().filter(|p| p.exists()).try_for_each(|p| seal::check(p))?;
        let suns = if facade.has_suns() && path.exists() { Some(SunPictures::open(&path)?) } else { None };
        let rows = MatrixRows::open(&view.direct_matrix()).ok().flatten();
        let fits = rows.is_some_and(|r| (r.rows(), r.cols(), r.components()) == (view.width * view.height, bins, 3));
        Ok(Self { facade, suns: suns.filter(|_| fits).map(|kept| kept.pictures) })
    }

    /// Whether its terms belong to V − Vd beside Vd, not to V.
    pub fn is_split(&self) -> bool {
        self.suns.is_some()
    }

    /// The light of a step.
    ///
    /// # Errors
    /// Matrices of different skies.
    ///
    /// # Panics
    /// If the year has no such step.
    pub fn at(&self, step: usize, state: &FacadeState) -> Result<StepLight> {
        let mut light = self.facade.light(step, state)?;
        let Some(suns) = &self.suns else {
            let mut terms = light.right.into_data();
            terms.truncate(light.bins * 3);
            return Ok(StepLight { terms, sun: Vec::new(), sun_is_traced: false });
        };
        // No sun may be traced through the states of this step.
        light.split();
        // An hour whose sun was not traced stays three-phase.
        let Ok(mut sun) = suns.sun_picture(step) else {
            return Ok(StepLight { terms: light.with_sun_in_patches().right.into_data(), sun: Vec::new(), sun_is_traced: false });
        };
        let share = self.facade.sun_share(state) as f32;
        sun.iter_mut().flat_map(|(_, value)| value).for_each(|v| *v *= share);
        Ok(StepLight { terms: light.right.into_data(), sun, sun_is_traced: true })
    }
}

/// Pictures of a view, one step after the other.
pub struct Pictures {
    light: ViewLight,
    rows: PictureView,
}

impl Pictures {
    /// Opens the matrices of a view.
    ///
    /// # Errors
    /// As [`ViewLight::read`].
    pub fn open(year: &Year, view: &ViewFile) -> Result<Self> {
        let light = ViewLight::read(year, view)?;
        let rows = PictureView::open_parts(&view.matrix, light.is_split().then(|| view.direct_matrix()).as_deref())?;
        Ok(Self { light, rows })
    }

    /// The picture of a step, W/m²sr, the façade as computed.
    ///
    /// # Errors
    /// Files that cannot be read any more.
    ///
    /// # Panics
    /// If the year has no such step.
    pub fn at(&mut self, step: usize) -> Result<Picture> {
        let light = self.light.at(step, &FacadeState::default())?;
        let (width, height, terms) = (self.rows.width, self.rows.height, self.rows.bins);
        let right = Native.right(terms, 1, 3, light.terms.as_slice().into())?;
        let mut pixels = Vec::with_capacity(width * height);
        let mut values = Vec::new();
        self.rows.rewind()?;
        for first in (0..height).step_by(BAND) {
            self.rows.read(BAND.min(height - first), width, &mut values)?;
            let count = values.len() / (3 * terms);
            let left = Native.left(count, terms, 3, values.as_slice().into())?;
            let mut band = vec![0.0; count * 3];
            Native.multiply(&left, &right, 0, 1, Arrangement::Rows, &mut band)?;
            pixels.extend_from_slice(band.as_chunks::<3>().0);
        }
        light.add_sun(&mut pixels);
        let mut picture = Picture::new(width, height, pixels)?;
        picture.view.clone_from(&self.rows.view);
        Ok(picture)
    }
}

impl Year {
    /// The picture of a view at a time step, W/m²sr, the façade as computed.
    ///
    /// # Errors
    /// A view that the year does not have, a step beyond its end, matrices that cannot be read.
    pub fn picture(&self, view: &str, step: usize) -> Result<Picture> {
        let found = self.views.iter().find(|v| v.name == view).ok_or_else(|| {
            let names: Vec<&str> = self.views.iter().map(|v| v.name.as_str()).collect();
            Error::new(format!("there is no view '{view}'")).file(self.folder()).help(format!("choose one of {}", names.join(", ")))
        })?;
        if step >= self.times.len() {
            return Err(
                Error::new(format!("there is no step {step}: the year has {}, counted from 0", self.times.len())).file(self.folder())
            );
        }
        Pictures::open(self, found)?.at(step)
    }
}
