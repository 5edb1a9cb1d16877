//! A project that is ready to run: from what is asked for to a year.

use super::inputs::Inputs;
use super::plan::{RunPlan, plan};
use super::project::Project;
use super::run::{run, without_pruning};
use super::summary::Summary;
use super::year::{TemporaryFolder, Year};
use crate::error::{Result, Warnings};
use crate::gpu::Device;
use crate::progress::Progress;
use std::path::Path;

/// A project and the contents of all its files, checked against each other.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What is asked for.
    pub project: Project,
    /// What its files hold.
    pub inputs: Inputs,
}

impl Plan {
    /// Reads all files that a project names. No device is needed, and nothing is computed.
    ///
    /// # Errors
    /// What is wrong in which file; files that contradict each other.
    pub fn new(project: Project, warnings: &mut Warnings) -> Result<Self> {
        let inputs = Inputs::read(&project, warnings)?;
        Ok(Self { project, inputs })
    }

    /// The same, modelling also what [`outline`](Self::outline) would leave out: a check that it changes nothing.
    #[must_use]
    pub fn without_pruning(mut self) -> Self {
        without_pruning(&mut self.project, &mut self.inputs);
        self
    }

    /// What a run will model, what it leaves out and why, and what it costs: matrices, memory, rays.
    ///
    /// # Errors
    /// Views that cannot be, hours that the weather does not have.
    pub fn outline(&self) -> Result<RunPlan> {
        plan(&self.project, &self.inputs)
    }

    /// Computes the year into a folder. Matrices of an earlier run into it are used again if their inputs are
    /// the same, so that a run that was stopped goes on where it was.
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&self, device: &Device, folder: &Path, progress: &dyn Progress, warnings: &mut Warnings) -> Result<Year> {
        self.write(device, folder, progress, warnings)?;
        let mut year = Year::open(folder)?;
        for (group, given) in year.sensors.iter_mut().zip(&self.inputs.sensors) {
            // Tables round positions, and tell no directions.
            group.positions = given.sensors.iter().map(|s| s.position).collect();
            group.directions = given.sensors.iter().map(|s| s.direction).collect();
        }
        Ok(year)
    }

    /// Computes the year without a folder of one's own: its files are among the system's temporary ones, for as
    /// long as the year or a clone of it exists. [`Year::write`] keeps them.
    ///
    /// # Errors
    /// As [`run`].
    pub fn compute(&self, device: &Device, progress: &dyn Progress, warnings: &mut Warnings) -> Result<Year> {
        let folder = TemporaryFolder::new()?;
        let year = self.run(device, folder.path(), progress, warnings)?;
        Ok(year.in_temporary(folder))
    }

    /// The same as [`run`](Self::run) for whom the files are enough.
    ///
    /// # Errors
    /// As [`run`].
    pub fn write(&self, device: &Device, folder: &Path, progress: &dyn Progress, warnings: &mut Warnings) -> Result<Summary> {
        run(device, &self.project, &self.inputs, folder, progress, warnings)
    }
}
