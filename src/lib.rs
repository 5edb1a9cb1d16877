//! Annual daylight and glare simulation of rooms with complex windows, on any GPU.
//!
//! Light from the sky reaches a sensor through four phases, one matrix each:
//! `I = V · T · D · S` with the view matrix V (window → sensor), the window's transmission matrix T,
//! the daylight matrix D (sky → window) and the sky matrix S (one column per hour). Five phases add
//! accurate suns. Through clear glass, or without any window, sensors see the sky itself: `I = C · S` with accurate
//! suns. What a user needs to know of each method is in the [`guide`].
//!
//! # A year in a few lines
//!
//! A [`Project`](simulate::Project) says what is asked for: read from a file, or made in code. A
//! [`Plan`](simulate::Plan) holds the contents of all its files and tells what a run will cost. It gives a
//! [`Year`](simulate::Year): illuminance with standard errors, metrics, glare and pictures as arrays.
//!
//! ```
//! use lucarne::Warnings;
//! use lucarne::simulate::{Plan, Project};
//!
//! let project = Project::builder("scenes/analytic/furnace")
//!     .weather("../../office/weather/new_york.wea")
//!     .scene(&["room.rad"])
//!     .window("south", "window.rad", "../../office/bsdf/double_clear.xml")
//!     .sensors("cube", "points.txt")
//!     .build()?;
//! let mut warnings = Warnings::new();
//! let plan = Plan::new(project, &mut warnings)?;
//! let outline = plan.outline()?;
//! assert_eq!((outline.phases, outline.hours), (3, 8760.0));
//! println!("{outline}");
//! # lucarne::Result::Ok(())
//! ```
//!
//! With a device the plan becomes a year:
//!
//! ```no_run
//! use lucarne::gpu::Device;
//! use lucarne::progress::Silent;
//! use lucarne::simulate::{Plan, Project, Results};
//! use lucarne::{ErrorKind, Warnings};
//!
//! let mut warnings = Warnings::new();
//! let plan = Plan::new(Project::read("scenes/office/project.toml".as_ref())?, &mut warnings)?;
//! let device = Device::open(None)?;
//! let year = match plan.run(&device, "out/office".as_ref(), &Silent, &mut warnings) {
//!     Err(e) if e.kind() == ErrorKind::Stopped => return Ok(()), // the next run goes on from here
//!     year => year?,
//! };
//! let desks = &year.sensors[0];
//! for (step, time) in year.times.iter().enumerate().take(24) {
//!     println!("{time}: {:.0} lx at the first sensor", desks.illuminance.at(0, step)[0]);
//! }
//! for glare in &year.glare {
//!     println!("{}: DGP {:.2} ± {:.2}", glare.view, glare.dgp[12], glare.standard_error[12]);
//! }
//! let picture = year.picture(&year.views[0].name, 12)?;
//! lucarne::image::hdr::write("noon.hdr".as_ref(), &picture)?;
//!
//! let again = Results::open("out/office".as_ref())?; // on another day, with the room
//! assert_eq!(again.year.sensors, year.sensors);
//! # lucarne::Result::Ok(())
//! ```
//!
//! [`Plan::compute`](simulate::Plan::compute) needs no folder; [`Year::write`](simulate::Year::write) keeps what it
//! gave. Each phase can be had alone as well: readers, bases, skies, BSDFs and the matrices of
//! [`kernels`] are public.
//!
//! # Two walks through the code
//!
//! **From points to illuminance.** A [`Plan`](simulate::Plan) reads a project ([`simulate::project`]: what is
//! asked) and its files ([`simulate::inputs`]: what is there). The phases (`simulate::phases`) make S with
//! [`sky`], D with [`kernels::daylight_matrix`], V with [`kernels::view_matrix`] (or C, of clear glass, with
//! [`kernels::coefficients`]) and, of five phases, Cds with
//! [`kernels::sun_matrix`]. V and D come as independent replicates (`simulate::sampling`); all are kept in the
//! output folder (`simulate::store`). One formula ([`simulate::light`]) makes illuminance of them, and the
//! spread of the replicates its standard error ([`simulate::results`]). [`simulate::year`] reads it all back.
//!
//! **From a picture to DGP.** A view's rays ([`camera`]) give V of its pixels
//! ([`kernels::image_matrix`]). [`simulate::results::glare`] multiplies it with the light at the windows, tile by
//! tile, finds the sources ([`kernels::glare`]) and judges them ([`glare`]), without writing a picture. The picture of one
//! hour, in any state of the façade, is [`simulate::year::picture`]: what the viewer shows while the pointer moves.
//!
//! # Who imports whom
//!
//! Downwards only; `tests/architecture` holds the list:
//! `files, gpu, bins, matrix → bsdf, weather, sky → bvh, camera, image → scene, glare → kernels, metrics → control → simulate → report → cli`.
//! The device layer knows nothing of daylight, the readers nothing of the device, the library nothing of
//! the command line and the viewer.
//!
//! # What always holds
//!
//! - **Every kernel has a twin in f64** that is plainly correct, an analytic case, and planted faults that the
//!   comparison finds.
//! - **Same input, seed and device: same bits**, whatever the chunk size, the number of threads, the split of the
//!   work or the place where a run was stopped.
//! - **Every sampled matrix comes as independent replicates**; all errors are made of their spread.
//! - **Paths started are paths finished**: a kernel counts both, and a difference is an error, not darkness.
//! - **Right, a warning, or an error**: what is not modelled is said.

pub mod bins;
pub mod bsdf;
pub(crate) mod bvh;
pub mod camera;
pub mod control;
pub mod error;
pub mod files;
pub mod glare;
pub mod gpu;
pub mod guide;
pub mod image;
pub mod kernels;
pub(crate) mod limits;
pub mod matrix;
pub mod metrics;
pub mod progress;
pub(crate) mod random;
pub mod report;
pub mod scene;
pub mod simulate;
pub mod sky;
mod statistics;
#[cfg(test)]
mod testing;
pub mod text;
pub mod units;
pub mod weather;

pub use error::{Error, ErrorKind, Result, Warnings};
