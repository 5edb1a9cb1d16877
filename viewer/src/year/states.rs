//! States of the façade: a second BSDF per window, and everything in between.

use super::facade::Facade;
use super::scrub::Wish;
use crate::bsdf::model::BsdfFile;
use crate::job::Derived;
use crate::results::Results;
use eframe::egui;
use lucarne::bsdf::transmission_matrix;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::matrix::rows::MatrixRows;
use lucarne::{Error, Result};
use std::sync::Arc;

/// Second states by window, and the year's illuminance of the chosen mixture.
#[derive(Default)]
pub struct States {
    number: u64,
    names: Vec<Option<String>>,
    matrices: Arc<Vec<Option<Matrix<f32>>>>,
    lux: Derived<String, std::result::Result<Vec<Arc<Matrix<f32>>>, String>>,
}

impl States {
    /// Forgets everything: other results.
    pub fn reset(&mut self, windows: usize) {
        *self = Self { number: self.number + 1, names: vec![None; windows], matrices: Arc::new(vec![None; windows]), ..Self::default() };
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
        let t = transmission_matrix(&file.bsdf).map_err(|e| e.file(&file.path))?;
        let data: Vec<f32> = t
            .data()
            .chunks_exact(t.components())
            .flat_map(|v| if v.len() == 3 { [v[0], v[1], v[2]] } else { [v[0]; 3] })
            .map(|v| v as f32)
            .collect();
        let t = Matrix::from_data(t.rows(), t.cols(), 3, data)?;
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
        let mut matrices = Vec::clone(&self.matrices);
        matrices[window] = Some(t);
        self.matrices = Arc::new(matrices);
        self.names[window] = Some(file.name());
        self.number += 1;
        Ok(())
    }

    /// What the worker needs for an hour.
    pub fn wish(&self, hour: usize, fractions: &[f64]) -> Wish {
        Wish { hour, fractions: fractions.to_vec(), states: (self.number, self.matrices.clone()) }
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

    /// Illuminance by group in the chosen state, if it is not the stored one, with a key.
    pub fn lux(&self, fractions: &[f64]) -> Option<(String, &[Arc<Matrix<f32>>])> {
        if !self.changed(fractions) {
            return None;
        }
        let lux = self.lux.value()?.as_ref().ok()?;
        Some((format!("{} {:p}", self.number, lux.first().map_or(std::ptr::null(), Arc::as_ptr)), lux))
    }

    /// Whether the year is being computed.
    pub fn busy(&self) -> bool {
        self.lux.busy()
    }
}

fn illuminance(results: &Results, wish: &Wish) -> Result<Vec<Arc<Matrix<f32>>>> {
    let facade = Facade::read(results)?;
    results
        .groups
        .iter()
        .map(|g| {
            let view = read_matrix(&results.matrix(&format!("V_{}", g.name)))?.matrix;
            let traced = facade.has_suns().then(|| traced_suns(results, &g.name)).flatten();
            Ok(Arc::new(facade.illuminance(&view, wish, traced.as_ref())?))
        })
        .collect()
}

/// What five phases add to three in the stored state, lx `[sensor][hour]`: Cds·Ssun − Vd·T·Dd·Sds.
fn traced_suns(results: &Results, group: &str) -> Option<Matrix<f32>> {
    let term = |name: &str| read_matrix(&results.folder.join(format!("illuminance/terms/{group}_{name}.mtx"))).ok().map(|f| f.matrix);
    let (sun, direct) = (term("sun")?, term("direct")?);
    let data = sun.data().iter().zip(direct.data()).map(|(sun, direct)| sun - direct).collect();
    Matrix::from_data(sun.rows(), sun.cols(), 1, data).ok()
}
