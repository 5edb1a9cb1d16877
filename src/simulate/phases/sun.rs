//! Cds: the sun matrix of sensors. Behind glass it has the light that rooms reflect of the suns as well.

use crate::error::{Error, Result};
use crate::kernels::coefficients::{CoefficientOptions, compute_suns};
use crate::kernels::sun_matrix::{Openings, SunMatrix, compute};
use crate::kernels::trace::TraceStatistics;
use crate::matrix::Matrix;
use crate::scene::points::Sensor;
use crate::simulate::context::Context;
use crate::simulate::inputs::shade::black_model;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::inputs::{SensorGroup, import, split};
use crate::simulate::plan::presets::{coefficient_options, pane_options, sun_options};
use crate::simulate::store::fingerprint::Fingerprint;

/// Where the sun comes in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SunEntry {
    /// By the windows whose sun is traced.
    Windows,
    /// Wherever the scene with its panes leaves it in.
    Anywhere,
}

/// Sun matrix of these sensors, kept per group as `C_GROUP` with what stands behind (`@WINDOWS@STATE` of a façade that
/// moves), or that of an earlier run, and whether it was traced now.
///
/// # Errors
/// Failures of device and file system, or when stopped.
pub(crate) fn sun_matrix(
    context: &Context<'_>,
    groups: &[SensorGroup],
    suns: &SunSet,
    way: SunEntry,
    behind: &str,
) -> Result<(SunMatrix, bool)> {
    let (project, inputs) = (context.project, context.inputs);
    let mut fingerprint = context.scene_fingerprint("C");
    let shaded = inputs.shaded_windows();
    let panes = inputs.pane_windows();
    let sensors: Vec<Sensor> = groups.iter().flat_map(|g| &g.sensors).copied().collect();
    let options = sun_options(project);
    fingerprint.add(&sensors).add(&options).add(&suns.suns).add(&way);
    for (window, corners) in &shaded {
        fingerprint.add(&(&window.triangles, &window.frame)).add(corners);
    }
    for (window, _) in &panes {
        fingerprint.add(&(&window.triangles, &window.frame)).add(&pane_options(project));
    }
    // What panes of glass let in, surfaces reflect: by light paths of the suns.
    let glazed = if way == SunEntry::Anywhere { inputs.glazed() } else { Vec::new() };
    let lights = CoefficientOptions { keep_batches: false, ..coefficient_options(project, 0) };
    if way == SunEntry::Anywhere {
        fingerprint.add(&lights);
        for glazed in &glazed {
            fingerprint.add(&(&glazed.window.triangles, glazed.window.frame.z, glazed.pane));
        }
    }
    add_scattering_data(context, &mut fingerprint);
    for shade in inputs.shades() {
        fingerprint.add(&shade.scene.materials).add_values(&shade.scene.triangles.iter().map(|t| t.material).collect::<Vec<_>>());
    }
    let files = groups.iter().map(|g| (g.name.as_str(), g.sun.as_deref(), g.sensors.len()));
    if let Some(given) = import::sun_matrices(files, suns)? {
        keep(context, &given, groups, behind, *Fingerprint::new("C imported").add_values(given.total.data()))?;
        write_suns(context, suns)?;
        return Ok((given, false));
    }
    if let Some(matrix) = kept(context, fingerprint, groups, behind, suns.suns.len()) {
        return Ok((matrix, false));
    }
    let scene = black_model(&inputs.scene, inputs.shades());
    let stage = context.store.stage(&format!("C{behind}"), fingerprint, context.progress);
    let mut matrix = if way == SunEntry::Anywhere {
        let mut matrix = compute(context.device, &scene, Openings::Anywhere, &sensors, &suns.suns, &options, &stage)?;
        matrix.add(&compute_suns(context.device, &inputs.scene, &glazed, &sensors, &suns.suns, &lights, &stage)?);
        matrix
    } else if shaded.is_empty() {
        SunMatrix::zeros(sensors.len(), suns.suns.len())
    } else {
        compute(context.device, &scene, Openings::Shaded(&shaded), &sensors, &suns.suns, &options, &stage)?
    };
    if !panes.is_empty() && !suns.suns.is_empty() && !sensors.is_empty() {
        let openings = Openings::Panes(&panes);
        matrix.add(&compute(context.device, &scene, openings, &sensors, &suns.suns, &pane_options(project), &stage)?);
    }
    keep(context, &matrix, groups, behind, fingerprint)?;
    stage.finish();
    Ok((matrix, true))
}

/// Endings of the files of a sun matrix.
const PARTS: [&str; 4] = ["", "_direct", "_own_standard_error", "_shared_standard_error"];

fn keep(context: &Context<'_>, matrix: &SunMatrix, groups: &[SensorGroup], behind: &str, inputs: Fingerprint) -> Result<()> {
    let all = [&matrix.total, &matrix.direct, &matrix.own_error, &matrix.shared_error];
    for (suffix, part) in PARTS.iter().zip(all) {
        for (group, rows) in groups.iter().zip(split(part, groups)) {
            let about = "sun matrix, rows sensors, columns the suns of suns.rad";
            context.store.save(&format!("C_{}{behind}{suffix}", group.name), &rows, inputs, about)?;
        }
    }
    Ok(())
}

fn kept(context: &Context<'_>, inputs: Fingerprint, groups: &[SensorGroup], behind: &str, suns: usize) -> Option<SunMatrix> {
    let together = |suffix: &str| {
        let (mut data, mut rows) = (Vec::new(), 0);
        for group in groups {
            let part = context.store.load(&format!("C_{}{behind}{suffix}", group.name), inputs, (group.sensors.len(), suns, 3))?;
            rows += part.rows();
            data.extend(part.into_data());
        }
        Matrix::from_data(rows, suns, 3, data).ok()
    };
    let [total, direct, own_error, shared_error] = PARTS.map(together);
    let statistics = TraceStatistics::default();
    Some(SunMatrix { total: total?, direct: direct?, own_error: own_error?, shared_error: shared_error?, statistics })
}

/// The suns in the order of Cds's columns, as a scene file for `rcontrib -M`.
pub(crate) fn write_suns(context: &Context<'_>, suns: &SunSet) -> Result<()> {
    let path = context.store.suns_path();
    crate::files::write_atomically(&path, |out| {
        for (column, sun) in suns.columns.iter().zip(&suns.suns) {
            let (d, angle) = (sun.direction, 2.0 * sun.radius.to_degrees());
            writeln!(out, "void light sol{column} 0 0 3 1 1 1\nsol{column} source sun{column} 0 0 4 {} {} {} {angle}", d.x, d.y, d.z)
                .map_err(|e| Error::io(&path, &e))?;
        }
        Ok(())
    })
}

/// Adds the scattering data that suns are traced through.
pub(crate) fn add_scattering_data(context: &Context<'_>, fingerprint: &mut Fingerprint) {
    for pane in context.inputs.windows.iter().filter_map(|w| w.pane.as_ref()) {
        fingerprint.add_all_of(pane.inputs);
    }
}
