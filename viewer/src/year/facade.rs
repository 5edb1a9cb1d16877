//! What the windows let in at an hour, in any state of the façade: T·D·S, and with five phases what of
//! it is the sun's patches seen straight.

use super::wish::Wish;
use crate::results::Results;
use lucarne::bins::ReinhartSky;
use lucarne::kernels::product;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::sky::{SkyOptions, sky_matrix};
use lucarne::{Error, Result};
use rayon::prelude::*;

/// Light that leaves the windows into the room: the product T·D·S of one hour.
pub struct Facade {
    windows: Vec<(Matrix<f32>, Matrix<f32>)>,
    sky: Matrix<f32>,
    suns: Option<Suns>,
}

/// With five phases.
struct Suns {
    /// Sds.
    patches: Matrix<f32>,
    /// Dd of the windows with a shade.
    direct: Vec<Option<Matrix<f32>>>,
}

impl Facade {
    /// Reads the matrices of all windows and the sky.
    pub fn read(results: &Results) -> Result<Self> {
        let read = |name: String| read_matrix(&results.matrix(&name)).map(|f| f.matrix);
        let windows: Result<Vec<_>> = results.windows.iter().map(|w| Ok((read(format!("T_{w}"))?, read(format!("D_{w}"))?))).collect();
        let facade = Self { windows: windows?, sky: read("S".into())?, suns: None };
        for (name, (t, d)) in results.windows.iter().zip(&facade.windows) {
            let fits = t.cols() == d.rows() && d.cols() == facade.sky.rows() && d.components() == 3 && t.components() == 3;
            if !fits || facade.sky.components() != 3 {
                return Err(Error::new(format!("the matrices of window '{name}' do not fit each other"))
                    .file(&results.folder)
                    .help("run the project again"));
            }
        }
        // Without the project there is no telling the sun from the sky: three phases.
        let suns = Suns::read(results, &facade);
        Ok(Self { suns, ..facade })
    }

    /// Bins of all windows.
    pub fn bins(&self) -> usize {
        self.windows.iter().map(|(t, _)| t.rows()).sum()
    }

    /// Whether the sun's patches can be taken out.
    pub fn has_suns(&self) -> bool {
        self.suns.is_some()
    }

    /// T of a window between its two states.
    fn transmission(&self, index: usize, wish: &Wish) -> Matrix<f32> {
        let first = &self.windows[index].0;
        let fraction = wish.fractions.get(index).copied().unwrap_or(0.0) as f32;
        match wish.states.1.get(index).and_then(Option::as_ref) {
            Some(second) if fraction > 0.0 && second.data().len() == first.data().len() => {
                let mixed = first.data().iter().zip(second.data()).map(|(a, b)| a + (b - a) * fraction).collect();
                Matrix::from_data(first.rows(), first.cols(), 3, mixed).unwrap_or_else(|_| first.clone())
            }
            _ => first.clone(),
        }
    }

    /// How much of the sun comes through shades: the mean of the windows that have one. The other state
    /// of a window has no shade, its sun comes from the sky's patches.
    pub fn sun_share(&self, wish: &Wish) -> f32 {
        let Some(suns) = &self.suns else { return 0.0 };
        let shares: Vec<f64> = (0..suns.direct.len()).filter(|&i| suns.direct[i].is_some()).map(|i| wish.share(i)).collect();
        (shares.iter().sum::<f64>() / shares.len().max(1) as f64) as f32
    }

    /// `[bin][rgb]` of one hour, the bins of all windows.
    pub fn light(&self, wish: &Wish) -> Vec<f32> {
        let column = column(&self.sky, wish.hour);
        let mut light = Vec::new();
        for (i, (_, d)) in self.windows.iter().enumerate() {
            let arriving = apply(d, &column);
            let t = self.transmission(i, wish);
            light.extend(apply(&t, &arriving).into_iter().flatten());
        }
        light
    }

    /// What of [`Self::light`] is left for a straight look: without the sun's patches behind shades.
    pub fn straight_light(&self, wish: &Wish, light: &[f32]) -> Vec<f32> {
        let mut rest = light.to_vec();
        let Some(suns) = &self.suns else { return rest };
        let column = column(&suns.patches, wish.hour);
        let mut first = 0;
        for (i, (t, _)) in self.windows.iter().enumerate() {
            if let Some(direct) = &suns.direct[i] {
                let share = wish.share(i) as f32;
                let sun = apply(t, &apply(direct, &column));
                let range = &mut rest[first..first + t.rows() * 3];
                range.iter_mut().zip(sun.iter().flatten()).for_each(|(rest, sun)| *rest = (*rest - share * sun).max(0.0));
            }
            first += t.rows() * 3;
        }
        rest
    }

    /// T·D of all windows, one below the other.
    pub fn transmitted(&self, wish: &Wish) -> Result<Matrix<f32>> {
        let mut data = Vec::new();
        for (i, (_, d)) in self.windows.iter().enumerate() {
            data.extend(product::chain(&product::Native, &[&self.transmission(i, wish), d])?.into_data());
        }
        let cols = self.sky.rows();
        Matrix::from_data(data.len() / (cols * 3).max(1), cols, 3, data)
    }

    /// Illuminance `[sensor][hour]` of a group of sensors. `traced`: what the traced suns add to three
    /// phases in the stored state, Cds·Ssun − Vd·T·Dd·Sds.
    pub fn illuminance(&self, view: &Matrix<f32>, wish: &Wish, traced: Option<&Matrix<f32>>) -> Result<Matrix<f32>> {
        let rgb = product::chain(&product::Native, &[view, &self.transmitted(wish)?, &self.sky])?;
        let lux = rgb
            .data()
            .chunks_exact(3)
            .map(|v| v.iter().zip(lucarne::units::ILLUMINANCE_WEIGHTS).map(|(a, w)| f64::from(*a) * w).sum::<f64>() as f32);
        let mut lux = Matrix::from_data(rgb.rows(), rgb.cols(), 1, lux.collect())?;
        if let Some(traced) = traced.filter(|t| t.data().len() == lux.data().len()) {
            let share = self.sun_share(wish);
            lux.data_mut().iter_mut().zip(traced.data()).for_each(|(lux, t)| *lux = (*lux + share * t).max(0.0));
        }
        Ok(lux)
    }
}

impl Suns {
    fn read(results: &Results, facade: &Facade) -> Option<Self> {
        let weather = results.weather.as_ref().filter(|w| results.phases == 5 && w.records.len() == facade.sky.cols())?;
        let is_shaded = |name: &String| results.shaded.contains(name);
        if !results.windows.iter().any(is_shaded) {
            return None;
        }
        let subdivision = (1..=6).find(|&n| ReinhartSky::new(n).is_ok_and(|sky| sky.len() == facade.sky.rows()))?;
        let patches = sky_matrix(weather, &SkyOptions { subdivision, sky: false, ..SkyOptions::default() }, &Silent).ok()?;
        let direct = |name: &String, d: &Matrix<f32>| {
            let direct = read_matrix(&results.matrix(&format!("D_{name}_direct"))).ok()?.matrix;
            ((direct.rows(), direct.cols(), direct.components()) == (d.rows(), d.cols(), 3)).then_some(direct)
        };
        let of = |(name, (_, d)): (&String, &(Matrix<f32>, Matrix<f32>))| match is_shaded(name) {
            true => direct(name, d).map(Some),
            false => Some(None),
        };
        let direct = results.windows.iter().zip(&facade.windows).map(of).collect::<Option<Vec<_>>>()?;
        Some(Self { patches, direct })
    }
}

fn column(sky: &Matrix<f32>, hour: usize) -> Vec<[f32; 3]> {
    (0..sky.rows()).map(|p| <[f32; 3]>::try_from(sky.at(p, hour)).unwrap_or_default()).collect()
}

fn apply(m: &Matrix<f32>, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let row = |r: usize| {
        let mut sum = [0.0f64; 3];
        for (m, x) in m.row(r).chunks_exact(3).zip(x) {
            for c in 0..3 {
                sum[c] += f64::from(m[c]) * f64::from(x[c]);
            }
        }
        sum.map(|v| v as f32)
    };
    (0..m.rows()).into_par_iter().map(row).collect()
}
