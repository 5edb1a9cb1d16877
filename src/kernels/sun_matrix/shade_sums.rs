//! Sums of the light that points of shades bring to receivers.

/// What a tile of receivers gets.
pub(super) struct Sums {
    /// `[batch][receiver][set][component, then points that found light][sun of the set]`
    pub values: Vec<f32>,
    /// `[receiver][set]`: what points would bring if nothing hid the sun, and their number.
    pub open: Vec<[f64; 2]>,
    pub receivers: usize,
    pub sets: usize,
    pub row: usize,
}

impl Sums {
    /// Those of a batch.
    pub fn of(&mut self, batch: usize) -> &mut [f32] {
        let size = self.receivers * self.sets * self.row;
        &mut self.values[batch * size..][..size]
    }
}

/// Mean over the suns that a point faces.
pub(super) fn mean_of_open(open: &[f32]) -> f64 {
    let (sum, count) = open.iter().filter(|v| **v > 0.0).fold((0.0, 0), |(sum, count), v| (sum + f64::from(*v), count + 1));
    sum / f64::from(count.max(1))
}

/// Adds a point's light through a link, and counts it.
pub(super) fn add_light(sums: &mut [f32], link: &[f32], light: &[f32], suns: usize) {
    for (c, link) in link.iter().enumerate() {
        let part = c * suns..(c + 1) * suns;
        sums[part.clone()].iter_mut().zip(&light[part]).for_each(|(sum, v)| *sum += link * v);
    }
    let hits = link.len() * suns..(link.len() + 1) * suns;
    sums[hits.clone()].iter_mut().zip(&light[hits]).for_each(|(sum, v)| *sum += v.min(1.0));
}
