//! A report of a run, or of several beside each other: one HTML page that needs no network.
//!
//! ```text
//! parts    what a report is made of: sections of text, tables and figures
//! plan     drawings of plans and sections of the room
//! project  what was asked, the room, its windows
//! facade   the states of the windows through the year
//! metrics  metrics with names, their classes
//! sensors  what the sensors tell
//! glare    what the views tell
//! account  how exact it is, warnings, where the time went
//! compare  the numbers of several runs beside each other
//! page     parts as HTML
//! ```
//!
//! Nothing is computed here that the results do not hold; a figure can be had as SVG and PNG too, a table as
//! CSV and JSON ([`Report::write_parts`]).

mod account;
mod compare;
mod facade;
mod glare;
mod metrics;
mod page;
mod parts;
mod plan;
mod project;
mod sensors;

use self::parts::Section;
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::simulate::Results;
use std::path::{Path, PathBuf};

/// A report of one or more runs.
#[derive(Debug, Clone)]
pub struct Report {
    /// Names of the runs: of their folders.
    names: Vec<String>,
    /// What compares them; nothing of one run.
    comparison: Option<Section>,
    /// Sections of every run; the same titles in the same order.
    runs: Vec<Vec<Section>>,
}

impl Report {
    /// Makes the report of results.
    ///
    /// # Errors
    /// No results at all, and matrices of a picture that cannot be read.
    pub fn new(results: &[Results]) -> Result<Self> {
        if results.is_empty() {
            return Err(Error::new("a report needs at least one folder of results"));
        }
        let has_states = results.iter().any(|r| !r.year.summary.groups.is_empty());
        let names = names(&results.iter().map(|r| r.year.folder().to_path_buf()).collect::<Vec<_>>());
        let scales = sensors::Scales::of(results);
        let sections = |results: &Results| -> Result<Vec<Section>> {
            let mut sections = vec![project::section(results), project::room(results)];
            if has_states {
                sections.push(facade::section(results)?);
            }
            sections.push(metrics::section(results));
            sections.push(sensors::section(results, &scales)?);
            sections.push(glare::section(results)?);
            sections.push(account::accuracy(results));
            sections.push(account::windows(results));
            sections.push(account::record(results));
            Ok(sections)
        };
        let runs = results.iter().map(sections).collect::<Result<Vec<_>>>()?;
        let comparison = (results.len() > 1).then(|| compare::section(&names, results));
        Ok(Self { names, comparison, runs })
    }

    /// The page.
    ///
    /// # Errors
    /// A figure that cannot be encoded.
    pub fn html(&self) -> Result<String> {
        page::html(&self.names, self.comparison.as_ref(), &self.runs)
    }

    /// Writes the page, whole or not at all.
    ///
    /// # Errors
    /// As [`html`](Self::html), and failures of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        let html = self.html()?;
        write_atomically(path, |out| out.write_all(html.as_bytes()).map_err(|e| Error::io(path, &e)))
    }

    /// Writes every figure as SVG and PNG and every table as CSV and JSON into a folder, of several runs into one
    /// folder each. Gives the number of files.
    ///
    /// # Errors
    /// Failures of the file system.
    pub fn write_parts(&self, folder: &Path) -> Result<usize> {
        let mut count = 0;
        for (name, sections) in self.names.iter().zip(&self.runs) {
            let folder = if self.runs.len() == 1 { folder.to_path_buf() } else { folder.join(parts::file_name(name)) };
            std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
            for section in sections {
                count += section.write_parts(&folder)?;
            }
        }
        if let Some(comparison) = &self.comparison {
            count += comparison.write_parts(folder)?;
        }
        Ok(count)
    }
}

/// Names of folders: the last part of their paths where these differ, else the whole paths.
fn names(folders: &[PathBuf]) -> Vec<String> {
    let last = |path: &PathBuf| {
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.clone());
        absolute.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned())
    };
    let short: Vec<String> = folders.iter().map(last).collect();
    let differ = short.iter().enumerate().all(|(i, name)| !short[..i].contains(name));
    if differ { short } else { folders.iter().map(|f| f.display().to_string()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_named_by_their_folders_unless_these_are_alike() {
        let named = |folders: &[&str]| names(&folders.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(named(&["out/a", "out/b/"]), ["a", "b"]);
        assert_eq!(named(&["x/out", "y/out"]), ["x/out", "y/out"]);
        assert!(Report::new(&[]).is_err());
    }
}
