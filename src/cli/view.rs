//! Radiance's view options on the command line (`-vta -vp x y z -vd x y z …`, `-vf file`).

use lucarne::camera::View;
use lucarne::{Error, Result};
use std::path::PathBuf;

/// View options, for `#[command(flatten)]`.
#[derive(clap::Args, Debug, Clone, Default)]
#[command(next_help_heading = "View", allow_negative_numbers = true)]
pub struct ViewOptions {
    /// View file; options beside it override it.
    #[arg(long = "vf", value_name = "FILE")]
    file: Option<PathBuf>,
    /// Perspective view.
    #[arg(long, group = "projection")]
    vtv: bool,
    /// Parallel view.
    #[arg(long, group = "projection")]
    vtl: bool,
    /// Hemispherical fisheye.
    #[arg(long, group = "projection")]
    vth: bool,
    /// Angular fisheye.
    #[arg(long, group = "projection")]
    vta: bool,
    /// Planispheric fisheye.
    #[arg(long, group = "projection")]
    vts: bool,
    /// Cylindrical panorama.
    #[arg(long, group = "projection")]
    vtc: bool,
    /// View point.
    #[arg(long, num_args = 3, allow_hyphen_values = true, value_names = ["X", "Y", "Z"])]
    vp: Option<Vec<f64>>,
    /// View direction.
    #[arg(long, num_args = 3, allow_hyphen_values = true, value_names = ["X", "Y", "Z"])]
    vd: Option<Vec<f64>>,
    /// Up vector.
    #[arg(long, num_args = 3, allow_hyphen_values = true, value_names = ["X", "Y", "Z"])]
    vu: Option<Vec<f64>>,
    /// Horizontal size, degrees.
    #[arg(long, value_name = "DEGREES")]
    vh: Option<f64>,
    /// Vertical size, degrees.
    #[arg(long, value_name = "DEGREES")]
    vv: Option<f64>,
    /// Distance of the fore clipping plane.
    #[arg(long, value_name = "DISTANCE")]
    vo: Option<f64>,
    /// Distance of the aft clipping plane.
    #[arg(long, value_name = "DISTANCE")]
    va: Option<f64>,
    /// Shift to the right, in picture widths.
    #[arg(long, allow_hyphen_values = true, value_name = "SHARE")]
    vs: Option<f64>,
    /// Lift, in picture heights.
    #[arg(long, allow_hyphen_values = true, value_name = "SHARE")]
    vl: Option<f64>,
}

impl ViewOptions {
    /// Whether the options say by themselves what a picture shows: a view file, or a projection
    /// with both sizes.
    pub fn is_complete(&self) -> bool {
        self.file.is_some() || (self.projection().is_some() && self.vh.is_some() && self.vv.is_some())
    }

    /// The view from these options over those of `picture` (its VIEW line), over Radiance's standard.
    ///
    /// # Errors
    /// An unreadable view file, or impossible values.
    pub fn view(&self, picture: Option<&str>) -> Result<View> {
        let mut view = match (&self.file, picture) {
            (Some(file), _) => View::read(file)?,
            (None, Some(options)) => View::parse(options)?,
            (None, None) => View::default(),
        };
        let words = self.words();
        view.apply(&words.iter().map(String::as_str).collect::<Vec<_>>())?;
        Ok(view)
    }

    /// The view of a picture, which must be known from its VIEW line or these options.
    ///
    /// # Errors
    /// If it is not, or as [`Self::view`].
    pub fn view_of_picture(&self, picture: Option<&str>) -> Result<View> {
        if picture.is_none() && !self.is_complete() {
            return Err(Error::new("the picture does not tell its view (it has no VIEW line)").help(
                "say it with options, for a fisheye `-vta -vh 180 -vv 180` (and -vd, -vu if up is not +Z), or with a view file: `-vf FILE`",
            ));
        }
        self.view(picture)
    }

    fn projection(&self) -> Option<&'static str> {
        let kinds =
            [(self.vtv, "-vtv"), (self.vtl, "-vtl"), (self.vth, "-vth"), (self.vta, "-vta"), (self.vts, "-vts"), (self.vtc, "-vtc")];
        kinds.into_iter().find(|(given, _)| *given).map(|(_, word)| word)
    }

    fn words(&self) -> Vec<String> {
        let mut words: Vec<String> = self.projection().map(str::to_owned).into_iter().collect();
        for (name, vector) in [("-vp", &self.vp), ("-vd", &self.vd), ("-vu", &self.vu)] {
            if let Some(v) = vector {
                words.push(name.to_owned());
                words.extend(v.iter().map(f64::to_string));
            }
        }
        let numbers = [("-vh", self.vh), ("-vv", self.vv), ("-vo", self.vo), ("-va", self.va), ("-vs", self.vs), ("-vl", self.vl)];
        for (name, number) in numbers {
            if let Some(x) = number {
                words.extend([name.to_owned(), x.to_string()]);
            }
        }
        words
    }
}
