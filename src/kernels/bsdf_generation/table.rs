//! Sums over batches: the table that grows until the BSDF is good enough, and its standard error.

use super::Directions;
use crate::bsdf::Component;
use crate::error::{Error, Result};

/// Means of finished batches, `[incident cell][outgoing cell]`, each counted over both sides with
/// the outside first, in 1/sr.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    directions: Directions,
    batches: u32,
    sum: Vec<f64>,
    squares: Vec<f64>,
}

impl Table {
    /// A table without batches.
    pub fn new(directions: Directions) -> Self {
        let entries = directions.entries();
        Self { directions, batches: 0, sum: vec![0.0; entries], squares: vec![0.0; entries] }
    }

    /// What the entries stand for.
    pub fn directions(&self) -> Directions {
        self.directions
    }

    /// Batches summed.
    pub fn batches(&self) -> u32 {
        self.batches
    }

    /// Adds the means of one batch.
    pub(super) fn add(&mut self, batch: &[f32]) {
        for ((sum, squares), &v) in self.sum.iter_mut().zip(&mut self.squares).zip(batch) {
            *sum += f64::from(v);
            *squares += f64::from(v) * f64::from(v);
        }
        self.batches += 1;
    }

    /// Place in the table of a component's entry.
    fn index(&self, component: Component, outgoing: usize, incident: usize) -> usize {
        place(self.directions, component, outgoing, incident)
    }

    /// Mean, 1/sr.
    pub fn mean(&self, component: Component, outgoing: usize, incident: usize) -> f64 {
        self.sum[self.index(component, outgoing, incident)] / f64::from(self.batches.max(1))
    }

    /// Standard error of the mean, 1/sr, from the spread of the batches.
    pub fn standard_error(&self, component: Component, outgoing: usize, incident: usize) -> f64 {
        let i = self.index(component, outgoing, incident);
        let n = f64::from(self.batches);
        if self.batches < 2 {
            return f64::INFINITY;
        }
        ((self.squares[i] / n - (self.sum[i] / n).powi(2)).max(0.0) / (n - 1.0)).sqrt()
    }

    /// Transmittance or reflectance of uniform diffuse light.
    pub fn hemispherical(&self, component: Component) -> f64 {
        let d = self.directions;
        let (outgoing, shares) = (d.outgoing_projected(), d.incident_shares());
        (0..d.incident()).map(|i| shares[i] * (0..d.outgoing()).map(|o| outgoing[o] * self.mean(component, o, i)).sum::<f64>()).sum()
    }

    /// Root mean square of the standard errors of a component over its root mean square value.
    pub fn relative_error(&self, component: Component) -> f64 {
        let d = self.directions;
        let (mut errors, mut values) = (0.0, 0.0);
        for i in 0..d.incident() {
            for o in 0..d.outgoing() {
                errors += self.standard_error(component, o, i).powi(2);
                values += self.mean(component, o, i).powi(2);
            }
        }
        if values > 0.0 { (errors / values).sqrt() } else { 0.0 }
    }

    /// The table as bytes, for going on later.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.batches.to_le_bytes().to_vec();
        bytes.extend(self.sum.iter().chain(&self.squares).flat_map(|v| v.to_le_bytes()));
        bytes
    }

    /// The table that [`to_bytes`](Self::to_bytes) stored.
    ///
    /// # Errors
    /// If the bytes are no such table.
    pub fn from_bytes(directions: Directions, bytes: &[u8]) -> Result<Self> {
        let mut table = Self::new(directions);
        let entries = table.sum.len();
        let Some((batches, values)) = bytes.split_at_checked(4).filter(|(_, values)| values.len() == 16 * entries) else {
            return Err(Error::new("the stored sums do not fit what is computed"));
        };
        table.batches = u32::from_le_bytes(batches.try_into().expect("four bytes were split off"));
        let numbers = values.chunks_exact(8).map(|c| f64::from_le_bytes(c.try_into().expect("chunks of eight bytes")));
        for (slot, value) in table.sum.iter_mut().chain(&mut table.squares).zip(numbers) {
            *slot = value;
        }
        if table.sum.iter().chain(&table.squares).any(|v| !v.is_finite()) {
            return Err(Error::new("the stored sums are not finite"));
        }
        Ok(table)
    }
}

/// Place of an entry in a table `[incident, both sides][outgoing, both sides]`, the outside first.
pub(super) fn place(directions: Directions, component: Component, outgoing: usize, incident: usize) -> usize {
    let (n_in, n_out) = (directions.incident(), directions.outgoing());
    let from_room = !component.is_front();
    let to_room = component.is_front() == component.is_transmission();
    (usize::from(from_room) * n_in + incident) * 2 * n_out + usize::from(to_room) * n_out + outgoing
}

/// Averages each entry with that of the same light travelling backwards (Helmholtz), in a table of
/// both sides. For rank 3, which cannot tell the way back, with its mirror image left to right: an
/// isotropic sample has no preferred side.
pub(super) fn average_reciprocal(directions: Directions, table: &mut [f32]) {
    if let Directions::Tree3(_) = directions {
        let n = directions.side();
        for square in table.chunks_exact_mut(n * n) {
            for row in square.chunks_exact_mut(n) {
                for k in 0..n / 2 {
                    let mean = 0.5 * (row[k] + row[n - 1 - k]);
                    row[k] = mean;
                    row[n - 1 - k] = mean;
                }
            }
        }
        return;
    }
    let n = directions.outgoing();
    let opposite = directions.opposite();
    for incident in 0..2 * n {
        for outgoing in 0..2 * n {
            let here = incident * 2 * n + outgoing;
            // Light that leaves on a side comes from there on its way back.
            let back = (outgoing / n * n + opposite[outgoing % n]) * 2 * n + incident / n * n + opposite[incident % n];
            if here < back {
                let mean = 0.5 * (table[here] + table[back]);
                table[here] = mean;
                table[back] = mean;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;

    #[test]
    fn stored_tables_come_back_and_damaged_ones_are_refused() {
        let d = Directions::Klems(KlemsBasis::Quarter);
        let mut table = Table::new(d);
        table.add(&(0..d.entries()).map(|i| i as f32).collect::<Vec<_>>());
        table.add(&(0..d.entries()).map(|i| i as f32 + 2.0).collect::<Vec<_>>());
        let bytes = table.to_bytes();
        assert_eq!(Table::from_bytes(d, &bytes).unwrap(), table);
        assert!(Table::from_bytes(d, &bytes[..bytes.len() - 1]).is_err());
        assert!(Table::from_bytes(d, &[]).is_err());
        assert!(Table::from_bytes(Directions::Tree4(2), &bytes).is_err());
        assert_eq!(table.mean(Component::TransmissionFront, 0, 0), 42.0);
        assert_eq!(table.standard_error(Component::TransmissionFront, 0, 0), 1.0);
    }

    #[test]
    fn the_average_is_reciprocal_and_keeps_reciprocal_tables() {
        let d = Directions::Tree4(1);
        let n = 2 * d.outgoing();
        let mut table: Vec<f32> = (0..d.entries()).map(|i| (i * 7 % 31) as f32).collect();
        let total: f32 = table.iter().sum();
        average_reciprocal(d, &mut table);
        assert!((table.iter().sum::<f32>() - total).abs() < 1e-3);
        // Cell k of four has the opposite 3 - k. Outside in at 1 to the room at 2 (global 6) comes back
        // from the room at 1 (global 5) to the outside at 2.
        assert_eq!(table[n + 6], table[5 * n + 2]);
        // Reflection to the outside: 1 to 3 comes back from 0 to 2.
        assert_eq!(table[n + 3], table[2]);
        let once = table.clone();
        average_reciprocal(d, &mut table);
        assert_eq!(once, table);
    }
}
