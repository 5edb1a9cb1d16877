//! States of the façade: a second BSDF per window, and everything in between.

use super::wish::Wish;
use crate::bsdf::model::BsdfFile;
use crate::job::Derived;
use crate::results::Results;
use eframe::egui;
use lucarne::bsdf::transmission_matrix;
use lucarne::kernels::product::Native;
use lucarne::matrix::Matrix;
use lucarne::matrix::rows::MatrixRows;
use lucarne::simulate::inputs::in_colour;
use lucarne::simulate::year::Sensors;
use lucarne::simulate::year::facade::{Facade, FacadeState};
use lucarne::{Error, Result};
use std::sync::Arc;

/// Second states by window, and the year's illuminance of the chosen mixture.
#[derive(Default)]
pub struct States {
    number: u64,
    names: Vec<Option<String>>,
    second: Arc<Vec<Option<Matrix<f64>>>>,
    lux: Derived<String, std::result::Result<Vec<Arc<Matrix<f32>>>, String>>,
}

/// The year's illuminance, as far as it is there.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct YearLux<'a> {
    /// By group, of another state than the stored one.
    pub lux: Option<&'a [Arc<Matrix<f32>>]>,
    /// Tells what is shown apart from what was shown before.
    pub key: String,
    /// The state of the façade, where it is not the stored one.
    pub state: Option<String>,
    /// What is shown in place of that state.
    pub instead: Option<String>,
}

impl States {
    /// Forgets everything: other results.
    pub fn reset(&mut self, windows: usize) {
        *self = Self { number: self.number + 1, names: vec![None; windows], second: Arc::new(vec![None; windows]), ..Self::default() };
    }

    /// Name of a window's second state.
    pub fn name(&self, window: usize) -> Option<&str> {
        self.names.get(window).and_then(Option::as_deref)
    }

    /// Takes a BSDF as the second state of a window.
    ///
    /// # Errors
    /// A file without visible transmission, or of another basis.
    pub fn add(&mut self, results: &Results, window: usize, file: &BsdfFile) -> Result<()> {
        let t = in_colour(transmission_matrix(&file.bsdf).map_err(|e| e.file(&file.path))?);
        let path = results.matrix(&format!("T_{}", results.windows.get(window).map_or("", String::as_str)));
        if let Some(first) = MatrixRows::open(&path)?
            && (first.rows(), first.cols()) != (t.rows(), t.cols())
        {
            return Err(Error::new(format!(
                "the window was computed with {} × {} bins, this BSDF has {} × {}",
                first.rows(),
                first.cols(),
                t.rows(),
                t.cols()
            ))
            .file(&file.path)
            .help("convert it first: lucarne bsdf convert"));
        }
        let mut second = Vec::clone(&self.second);
        second[window] = Some(t);
        self.second = Arc::new(second);
        self.names[window] = Some(file.name());
        self.number += 1;
        Ok(())
    }

    /// What the worker needs for an hour.
    pub fn wish(&self, hour: usize, fractions: &[f64]) -> Wish {
        Wish { hour, state: FacadeState { second: self.second.clone(), fractions: fractions.to_vec() } }
    }

    /// Whether the façade is in another state than the stored one.
    pub fn changed(&self, fractions: &[f64]) -> bool {
        fractions.iter().zip(&self.names).any(|(f, n)| *f > 0.0 && n.is_some())
    }

    /// Keeps the year's illuminance up to date; key of what is there.
    pub fn update(&mut self, ctx: &egui::Context, results: &Arc<Results>, fractions: &[f64]) {
        if !self.changed(fractions) {
            return;
        }
        let wish = self.wish(0, fractions);
        self.lux.update(ctx, format!("{} {fractions:?}", self.number), || {
            let results = results.clone();
            move || illuminance(&results, &wish).map_err(|e| e.to_string())
        });
    }

    /// The year's illuminance in the chosen state of the façade.
    pub fn lux(&self, windows: &[String], fractions: &[f64]) -> YearLux<'_> {
        if !self.changed(fractions) {
            return YearLux::default();
        }
        let (lux, instead) = match (self.lux.current(), self.lux.newest()) {
            (Some(Ok(lux)), _) => (Some(lux), None),
            (Some(Err(e)), _) => (None, Some(format!("the façade as computed: its other state cannot be computed: {e}"))),
            (None, Some(Ok(lux))) => (Some(lux), Some("an earlier state of the façade; the new one is being computed".to_string())),
            _ => (None, Some("the façade as computed; its other state is being computed".to_string())),
        };
        let pointer = lux.and_then(|l| l.first()).map_or(std::ptr::null(), Arc::as_ptr);
        let parts = windows.iter().zip(fractions).enumerate();
        let parts: Vec<String> =
            parts.filter_map(|(i, (w, f))| Some(format!("{w} {:.0} % {}", f * 100.0, self.name(i).filter(|_| *f > 0.0)?))).collect();
        YearLux { lux: lux.map(Vec::as_slice), key: format!("{} {pointer:p}", self.number), state: Some(parts.join(", ")), instead }
    }

    /// Whether the year is being computed.
    pub fn busy(&self) -> bool {
        self.lux.busy()
    }
}

fn illuminance(results: &Results, wish: &Wish) -> Result<Vec<Arc<Matrix<f32>>>> {
    let facade = Facade::read(results)?;
    let of = |group: &Sensors| facade.illuminance(results, &group.name, &wish.state, &Native).map(Arc::new);
    results.sensors.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn illuminance_of_another_state_than_the_chosen_one_is_called_so() {
        let ctx = egui::Context::default();
        let windows = ["south".to_string()];
        let matrix = |v: f32| Arc::new(Matrix::from_data(1, 1, 1, vec![v]).unwrap());
        let mut states = States::default();
        states.reset(1);
        assert_eq!(states.lux(&windows, &[1.0]), YearLux::default(), "without a second state there is no other one");
        states.names[0] = Some("clear.xml".into());
        let ask = |states: &mut States, key: &str, value: std::result::Result<f32, String>| {
            states.lux.update(&ctx, key.into(), || move || value.map(|v| vec![matrix(v)]));
        };
        let settle = |states: &mut States, key: &str, value: std::result::Result<f32, String>| {
            ask(states, key, value.clone());
            while states.busy() {
                std::thread::sleep(std::time::Duration::from_millis(1));
                ask(states, key, value.clone());
            }
        };
        let first = states.lux(&windows, &[0.5]);
        assert_eq!((first.lux, first.state.as_deref()), (None, Some("south 50 % clear.xml")));
        assert!(first.instead.unwrap().starts_with("the façade as computed"));
        settle(&mut states, "a", Ok(1.0));
        let ready = states.lux(&windows, &[0.5]);
        assert_eq!((ready.lux.unwrap()[0].data(), ready.instead), (&[1.0][..], None));
        // The next one is not there yet.
        let (go, wait) = std::sync::mpsc::channel::<()>();
        states.lux.update(&ctx, "b".into(), || move || wait.recv().map(|()| vec![]).map_err(|e| e.to_string()));
        let earlier = states.lux(&windows, &[0.6]);
        assert!(earlier.lux.is_some() && earlier.instead.unwrap().starts_with("an earlier state"));
        drop(go);
        settle(&mut states, "c", Err("no file".into()));
        let failed = states.lux(&windows, &[0.6]);
        assert!(failed.lux.is_none() && failed.instead.unwrap().contains("no file"));
        assert_eq!(states.lux(&windows, &[0.0]), YearLux::default(), "back at the stored state");
    }
}
