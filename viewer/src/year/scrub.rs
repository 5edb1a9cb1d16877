//! The hour's picture while dragging, from V in memory and the light of the hour, by a worker that always
//! takes the newest wish.

use super::lines::{Lines, native};
use super::wish::Wish;
use crate::picture::model::{Judge, Judged, PictureFile};
use crate::results::Results;
use eframe::egui;
use lucarne::image::Picture;
use lucarne::kernels::product::{self, Arrangement, Factor, Multiplier};
use lucarne::simulate::year::ViewFile;
use lucarne::simulate::year::picture::ViewLight;
use lucarne::{Error, Result};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// How often an unfinished picture is shown while V is read.
const PARTIAL: Duration = Duration::from_millis(250);
/// How long dragging must rest before glare is looked for.
const PAUSE: Duration = Duration::from_millis(200);

/// What comes back.
pub enum Answer {
    /// A picture; whether all of it is there, whether its sun is as traced, and how long it took.
    Picture { wish: Wish, file: Box<PictureFile>, whole: bool, traced: bool, seconds: f64 },
    /// Its glare, if the view has any.
    Glare { wish: Wish, judged: Option<Box<Judged>> },
    /// What went wrong; the worker has ended.
    Failed(Error),
}

/// The window side of the worker.
pub struct Scrubber {
    wishes: Sender<Wish>,
    answers: Receiver<Answer>,
    last: Option<Wish>,
    /// Name of the view it serves.
    pub view: String,
}

impl Scrubber {
    /// Starts a worker for a view.
    pub fn start(ctx: &egui::Context, results: &Arc<Results>, view: &ViewFile) -> Self {
        let (wishes, wanted) = channel();
        let (answer, answers) = channel();
        let (ctx, results, view) = (ctx.clone(), results.clone(), view.clone());
        let name = view.name.clone();
        std::thread::spawn(move || {
            let send = |a: Answer| {
                let gone = answer.send(a).is_err();
                ctx.request_repaint();
                gone
            };
            if let Err(error) = work(&results, &view, &wanted, &send) {
                send(Answer::Failed(error));
            }
        });
        Self { wishes, answers, last: None, view: name }
    }

    /// Asks for a picture, unless it was the last one asked for.
    pub fn wish(&mut self, wish: Wish) {
        if self.last.as_ref() != Some(&wish) {
            self.last = Some(wish.clone());
            // A worker that has ended has said why.
            let _ = self.wishes.send(wish);
        }
    }

    /// What has come back.
    pub fn answers(&self) -> impl Iterator<Item = Answer> + '_ {
        self.answers.try_iter()
    }

    /// The newest wish.
    pub fn wanted(&self) -> Option<&Wish> {
        self.last.as_ref()
    }
}

/// V ready for products with one column.
enum Engine {
    /// On the processor: a third of the memory where all three channels are the same.
    Native { values: Vec<f32>, grey: bool },
    /// On the device.
    Device { multiplier: Box<dyn Multiplier>, left: Factor<'static> },
}

impl Engine {
    /// The fastest for all lines of a view.
    fn new(lines: Lines, pixels: usize) -> Result<Self> {
        let (terms, grey) = (lines.terms(), lines.grey);
        let multiplier = product::choose(None)?;
        if multiplier.description().starts_with("native") {
            return Ok(Self::Native { values: lines.values, grey });
        }
        let all = if grey { lines.values.iter().flat_map(|v| [*v; 3]).collect() } else { lines.values };
        let left = multiplier.left(pixels, terms, 3, all.into())?;
        Ok(Self::Device { multiplier, left })
    }

    /// The picture of one hour, `[pixel][rgb]`.
    fn picture(&self, light: &[f32], pixels: usize) -> Result<Vec<[f32; 3]>> {
        match self {
            Self::Native { values, grey } => Ok(native(values, *grey, light)),
            Self::Device { multiplier, left } => {
                let right = multiplier.right(light.len() / 3, 1, 3, light.into())?;
                let mut out = vec![0.0; pixels * 3];
                multiplier.multiply(left, &right, 0, 1, Arrangement::Rows, &mut out)?;
                Ok(out.as_chunks::<3>().0.to_vec())
            }
        }
    }
}

/// The newest of several wishes.
fn newest(first: Wish, wanted: &Receiver<Wish>) -> Wish {
    wanted.try_iter().last().unwrap_or(first)
}

fn work(results: &Results, view: &ViewFile, wanted: &Receiver<Wish>, send: &dyn Fn(Answer) -> bool) -> Result<()> {
    let Ok(mut wish) = wanted.recv() else { return Ok(()) };
    let mut start = Instant::now();
    let light = ViewLight::read(results, view)?;
    let pixels = view.width * view.height;
    let file = |rgb: Vec<[f32; 3]>| -> Result<PictureFile> {
        let mut picture = Picture::new(view.width, view.height, rgb)?;
        picture.view.clone_from(&view.options);
        Ok(PictureFile::of_picture(&view.matrix, picture))
    };
    // While V is read, the picture becomes finer.
    let mut lines = Lines::new(view, light.is_split());
    let mut shown: Option<Instant> = None;
    while lines.read()? {
        if shown.is_none_or(|at| at.elapsed() > PARTIAL) {
            wish = newest(wish, wanted);
            let now = light.at(wish.hour, &wish.state)?;
            let mut rgb = lines.picture(&now.terms);
            now.add_sun(&mut rgb);
            let (traced, seconds) = (now.sun_is_traced, start.elapsed().as_secs_f64());
            if send(Answer::Picture { wish: wish.clone(), file: Box::new(file(rgb)?), whole: false, traced, seconds }) {
                return Ok(());
            }
            shown = Some(Instant::now());
        }
    }
    let engine = Engine::new(lines, pixels)?;
    let mut judge: Option<Judge> = None;
    loop {
        let now = light.at(wish.hour, &wish.state)?;
        let mut rgb = engine.picture(&now.terms, pixels)?;
        now.add_sun(&mut rgb);
        let picture = file(rgb)?;
        let (traced, seconds) = (now.sun_is_traced, start.elapsed().as_secs_f64());
        if send(Answer::Picture { wish: wish.clone(), file: Box::new(picture.clone()), whole: true, traced, seconds }) {
            return Ok(());
        }
        // The glare of what is shown is worth its time only when the dragging has stopped.
        let next = match wanted.recv_timeout(PAUSE) {
            Ok(next) => next,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {
                if judge.is_none() {
                    judge = Judge::new(&picture, 2000.0, None).ok();
                }
                let judged = judge.as_ref().and_then(|j| j.judge(&picture).ok()).map(Box::new);
                if send(Answer::Glare { wish: wish.clone(), judged }) {
                    return Ok(());
                }
                match wanted.recv() {
                    Ok(next) => next,
                    Err(_) => return Ok(()),
                }
            }
        };
        start = Instant::now();
        wish = newest(next, wanted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lucarne::matrix::Matrix;
    use lucarne::simulate::year::facade::FacadeState;

    /// A day in the room with blinds as `lucarne run` has it, and the same from the matrices.
    #[test]
    fn pictures_of_five_phases_are_those_of_the_run() {
        let Some(device) = crate::testing::device(lucarne::gpu::Device::shared(), "pictures of five phases") else { return };
        let folder = tempfile::tempdir().unwrap();
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/blinds");
        let weather: String = (0..24).map(|h| format!("1 15 {h}.5 {} 120\n", if h > 8 && h < 17 { 700 } else { 0 })).collect();
        let header = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
        std::fs::write(folder.path().join("w.wea"), format!("{header}{weather}")).unwrap();
        let text = std::fs::read_to_string(format!("{scene}/project.toml")).unwrap();
        let text = ["room.rad", "window.rad", "blind.xml", "blinds.rad", "points.txt", "views/seat.vf"]
            .iter()
            .fold(text, |text, file| text.replace(&format!("\"{file}\""), &format!("\"{scene}/{file}\"")))
            .replace("../office/weather/new_york.wea", "w.wea")
            .replace("[300, 4716]", "[347, 349]")
            .replace("[96, 96]", "[32, 32]")
            .replace("[glare]                             # DGP of every hour, suns as traced\nmethod = \"image\"\n", "")
            .replace("\"standard\"", "\"draft\"");
        let project = folder.path().join("project.toml");
        std::fs::write(&project, text).unwrap();
        let project = lucarne::simulate::Project::read(&project).unwrap();
        let mut warnings = lucarne::Warnings::new();
        let inputs = lucarne::simulate::Inputs::read(&project, &mut warnings).unwrap();
        let out = folder.path().join("out");
        lucarne::simulate::run(&device, &project, &inputs, &out, &lucarne::progress::Silent, &mut warnings).unwrap();
        let results = Results::open(&out).unwrap();
        let view = &results.views[0];
        let light = ViewLight::read(&results, view).unwrap();
        assert!(light.is_split(), "{:?}", results.notes);
        let mut lines = Lines::new(view, true);
        while lines.read().unwrap() {}
        let engine = Engine::new(lines, view.width * view.height).unwrap();
        let render = |hour: usize, fraction: f64, state: Option<Matrix<f64>>| {
            let state = FacadeState { second: Arc::new(vec![state]), fractions: vec![fraction] };
            let now = light.at(hour, &state).unwrap();
            let mut rgb = engine.picture(&now.terms, view.width * view.height).unwrap();
            now.add_sun(&mut rgb);
            (rgb, now.sun_is_traced)
        };
        for hour in [11, 13] {
            let stored = lucarne::image::hdr::read(&out.join(format!("images/seat/img_{:04}.hdr", 14 * 24 + hour))).unwrap();
            let (found, traced) = render(hour, 0.0, None);
            assert!(traced);
            let most = stored.pixels.iter().flatten().copied().fold(0.0, f32::max);
            for (a, b) in found.iter().zip(&stored.pixels) {
                // RGBE has 8 bits for the largest channel.
                assert!((0..3).all(|c| (a[c] - b[c]).abs() <= 0.01 * b.iter().copied().fold(0.0, f32::max) + 1e-6 * most), "{a:?} {b:?}");
            }
        }
        // Another hour of sun was not traced.
        assert!(!render(15, 0.0, None).1);
        // The whole other state has no shade; half way is half of both.
        let other = lucarne::matrix::file::read_matrix(&results.matrix("T_south")).unwrap().matrix.map(|v| 0.5 * f64::from(v));
        let [first, half, second] = [0.0, 0.5, 1.0].map(|f| render(11, f, Some(other.clone())).0);
        for ((a, b), c) in first.iter().zip(&half).zip(&second) {
            assert!((b[1] - 0.5 * (a[1] + c[1])).abs() <= 1e-4 * (a[1] + c[1]), "{a:?} {b:?} {c:?}");
        }
    }
}
