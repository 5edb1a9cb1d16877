//! Angle bases as a file defines them, and the matrices over them.

use crate::bins::{AngleBasis, KlemsBasis};
use crate::bsdf::KlemsMatrix;
use crate::bsdf::numbers::NumberList;
use crate::error::{Error, Result, Warnings};
use crate::limits::BASIS_BINS;

/// An angle basis as the file defines it.
#[derive(Default)]
struct Definition {
    name: String,
    lower: Vec<f64>,
    upper: Vec<f64>,
    counts: Vec<usize>,
    line: usize,
}

/// The bases that a file defines.
#[derive(Default)]
pub(super) struct Bases(Vec<Definition>);

impl Bases {
    /// Begins the next basis, in a line of the file.
    pub fn begin(&mut self, line: usize) {
        self.0.push(Definition { line, ..Definition::default() });
    }

    /// Takes the text of an element inside the basis that began last.
    pub(crate) fn define(&mut self, element: &str, text: String) -> Result<()> {
        let Some(basis) = self.0.last_mut() else {
            return Err(Error::new("this element must stand inside an AngleBasis"));
        };
        let number = || {
            text.replacen(',', ".", 1)
                .parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .ok_or_else(|| Error::new(format!("'{text}' is not a number")))
        };
        match element {
            "AngleBasisName" => basis.name = text,
            "LowerTheta" => basis.lower.push(number()?),
            "UpperTheta" => basis.upper.push(number()?),
            _ => {
                let count = text.parse::<usize>().map_err(|_| Error::new(format!("'{text}' is not a number of azimuths")))?;
                basis.counts.push(count);
                if basis.counts.iter().try_fold(0usize, |sum, n| sum.checked_add(*n)).is_none_or(|n| n > BASIS_BINS) {
                    return Err(Error::new(format!("angle basis '{}' has more than {BASIS_BINS} bins", basis.name)));
                }
            }
        }
        Ok(())
    }

    /// The basis of this name: the built-in table for known names, else as the file defines it.
    fn by_name(&self, name: &str, warnings: &mut Warnings) -> Result<Option<AngleBasis>> {
        let definition = self.0.iter().find(|d| d.name.eq_ignore_ascii_case(name));
        if let Some(known) = AngleBasis::by_name(name) {
            if let Some(d) = definition
                && !d.counts.is_empty()
                && d.build().ok().is_none_or(|b| b.rings() != known.rings())
            {
                let text = format!("the file defines '{name}' otherwise than its name says; the standard table is used");
                warnings.push(Error::new(text).line(d.line).field("AngleBasis"));
            }
            return Ok(Some(known));
        }
        match definition {
            Some(d) => d.build().map(Some).map_err(|e| e.line(d.line).field("AngleBasis")),
            None => Ok(None),
        }
    }

    /// A matrix of these values over the bases of these names, for columns and rows; missing and unknown
    /// ones are guessed, with a warning.
    pub fn matrix(&self, list: NumberList, names: [Option<String>; 2], by_rows: bool, warnings: &mut Warnings) -> Result<KlemsMatrix> {
        let mut resolved = [None, None];
        let mut unknown = Vec::new();
        for (slot, name) in resolved.iter_mut().zip(&names) {
            if let Some(name) = name.as_deref().filter(|n| !n.is_empty()) {
                *slot = self.by_name(name, warnings)?;
                if slot.is_none() {
                    unknown.push(name.to_string());
                }
            }
        }
        // Guessed from the file's only basis, else from the number of values.
        let mut candidates = Vec::new();
        if let [only] = &*self.0 {
            candidates.extend(self.by_name(&only.name, warnings)?);
        }
        candidates.extend(KlemsBasis::ALL.map(AngleBasis::from));
        let pair = |count: usize| -> Option<(AngleBasis, AngleBasis)> {
            let choices = |known: &Option<AngleBasis>| known.as_ref().map_or_else(|| candidates.clone(), |b| vec![b.clone()]);
            let (c, r) = (choices(&resolved[0]), choices(&resolved[1]));
            c.iter().flat_map(|c| r.iter().map(move |r| (c.clone(), r.clone()))).find(|(c, r)| c.len() * r.len() == count)
        };
        let known = resolved[0].as_ref().zip(resolved[1].as_ref());
        let (values, decimal_commas) = match list.finish(|n| pair(n).is_some())? {
            Ok(found) => found,
            Err(count) => {
                let wanted = match known {
                    Some((c, r)) => {
                        format!("{} × {} = {} values are needed for {} × {}", r.len(), c.len(), c.len() * r.len(), r.name(), c.name())
                    }
                    None if unknown.is_empty() => "no Klems basis has this number of bins".to_string(),
                    None => format!("the basis '{}' is not defined in the file", unknown.join("', '")),
                };
                return Err(Error::new(format!("there are {count} values; {wanted}"))
                    .help("the file is cut off, or its basis does not belong to its data"));
            }
        };
        let (incident, outgoing) = pair(values.len()).expect("the count was accepted");
        if known.is_none() {
            let why = if unknown.is_empty() { "is missing".into() } else { format!("'{}' is not defined", unknown.join("', '")) };
            let text = format!("the basis {why}; {} is assumed from the number of values", incident.name());
            warnings.push(Error::new(text));
        }
        if decimal_commas {
            warnings.push(Error::new("commas are read as decimal points"));
        }
        let values = if by_rows {
            // Text rows are incident directions: transpose.
            let (n_in, n_out) = (incident.len(), outgoing.len());
            (0..n_out * n_in).map(|k| values[k % n_in * n_out + k / n_in]).collect()
        } else {
            values
        };
        KlemsMatrix::new(incident, outgoing, values)
    }
}

impl Definition {
    fn build(&self) -> Result<AngleBasis> {
        if self.upper.len() != self.counts.len() || (!self.lower.is_empty() && self.lower.len() != self.counts.len()) {
            return Err(Error::new(format!("angle basis '{}' has incomplete blocks", self.name))
                .help("every AngleBasisBlock needs nPhis, LowerTheta and UpperTheta"));
        }
        let mut limits = vec![self.lower.first().copied().unwrap_or(0.0)];
        limits.extend(&self.upper);
        if self.lower.iter().zip(&limits).any(|(lower, limit)| (lower - limit).abs() > 0.01) {
            return Err(Error::new(format!("angle basis '{}': rings do not join ({:?}° up to {:?}°)", self.name, self.lower, self.upper)));
        }
        AngleBasis::from_rings(&self.name, &limits, &self.counts)
    }
}
