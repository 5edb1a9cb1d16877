//! `[[view]]` and `[images]`: the cameras of a project, and the hours whose pictures are written.

use super::given::GivenPictures;
use super::names::name;
use super::table::{Place, Table};
use crate::camera::{Raster, View};
use crate::error::{Error, Result, Warnings};
use crate::scene;
use crate::scene::points::Sensor;
use crate::weather::Steps;
use std::path::PathBuf;

/// Pixels of a view, if nothing else is said.
pub(super) const DEFAULT_RESOLUTION: [usize; 2] = [512, 512];
/// Most pixels in a row or column.
const MOST_PIXELS: u64 = 16_384;
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
    pub place: Place,
    /// Pictures made elsewhere.
    pub given: GivenPictures,
}

impl ViewSection {
    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"desk\" or the like")?;
        let file = table.required_path("file", "add file = \"….vf\": a file with a line of view options")?;
        let view =
            scene::read_model_view(&file, &mut Warnings::new())?.map(|o| view_of_options(&o).map_err(|e| e.file(&file))).transpose()?;
        let resolution = resolution(&mut table)?.unwrap_or(DEFAULT_RESOLUTION);
        let given = GivenPictures::read(&mut table)?;
        let place = table.place("resolution");
        table.finish()?;
        Ok(Self { name, file, view, resolution, place, given })
    }

    /// The view, not yet checked.
    ///
    /// # Errors
    /// A view file that cannot be read or makes no sense.
    pub fn view(&self) -> Result<View> {
        self.view.map_or_else(|| View::read(&self.file), Ok)
    }

    /// The sensor at its eye: at the view's point, facing as it looks.
    ///
    /// # Errors
    /// A view file that cannot be read or makes no sense.
    pub fn eye(&self) -> Result<Sensor> {
        let view = self.view()?;
        let camera = view.camera().map_err(|e| e.file(&self.file))?;
        Ok(Sensor { position: view.point, direction: camera.direction, line: 1 })
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

/// A view of a model, by its options.
///
/// # Errors
/// Options that no camera has.
pub(super) fn view_of_options(options: &str) -> Result<View> {
    let view = View::parse(options)?;
    view.camera()?;
    Ok(view)
}

/// Hours of which pictures are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ImageHours {
    /// None: only the view matrices are kept.
    None,
    /// All whose sky is not black.
    Daylight,
    /// These hours of the year, from 0 (1164: 18 February, 12 to 13 o'clock), whatever part of the year the
    /// weather file holds; of steps shorter than an hour all that lie in it.
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
    pub place: Option<Place>,
}

impl ImageHours {
    /// The time steps, by number in the weather file; `lit` are those with light.
    ///
    /// # Errors
    /// Hours that the weather file does not have, or has several times.
    pub fn chosen(&self, steps: &Steps, lit: &[usize]) -> Result<Vec<usize>> {
        match self {
            ImageHours::None => Ok(Vec::new()),
            ImageHours::Daylight => steps.check_unique(lit).map(|()| lit.to_vec()),
            ImageHours::Chosen(hours) => steps.of_hours(hours),
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
        images.place = Some(table.place("hours"));
        images.components = table.boolean("components")?.unwrap_or(false);
        table.finish()?;
        Ok(images)
    }
}
