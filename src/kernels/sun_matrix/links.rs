//! What passes between receivers and points that they share.

use super::tracer::{STRUCTS, SunTracer};
use crate::error::Result;
use crate::gpu::{Buffer, Shader};
use crate::gpu_struct;
use crate::kernels::trace::{self, TraceStatistics};

gpu_struct! {
    /// Parameters of `sun_matrix/links`.
    pub(crate) struct LinkParams {
        receivers: u32,
        points: u32,
        /// Vertices per point.
        slots: u32,
        /// Windows that light must leave through; from anywhere if there are none.
        window_count: u32,
        components: u32,
        /// Whether only what is in the way counts.
        plain: u32,
        /// Points of each batch, and receivers from one batch to the next; 0 if all batches share them.
        batch_points: u32,
        batch_stride: u32,
    }
}

pub(super) const LINKS: Shader = trace::shader("sun_matrix/links", &[STRUCTS, &[LinkParams::DECLARED]]);

/// Points on the device.
#[derive(Clone, Copy)]
pub(super) struct Points<'a> {
    /// A point and its vertices each.
    pub vertices: &'a Buffer,
    pub count: usize,
    /// Vertices per point.
    pub slots: usize,
    /// Points of each batch where batches have receivers of their own, and receivers from one to the next.
    pub batch: Option<[usize; 2]>,
    /// Whether these are points of panes, where only what is in the way counts; else of shades behind windows, and
    /// the light comes as irradiance.
    pub of_panes: bool,
}

/// Links of receivers and points, `[point][receiver][component]`.
pub(super) fn links(
    tracer: &SunTracer<'_>,
    receivers: &Buffer,
    count: usize,
    points: Points<'_>,
    statistics: &mut TraceStatistics,
) -> Result<Buffer> {
    let device = tracer.device;
    let components = tracer.components();
    let links = device.zeros::<f32>("links", points.count * count * components)?;
    let [batch_points, batch_stride] = points.batch.unwrap_or([points.count.max(1), 0]);
    let params = LinkParams {
        receivers: count as u32,
        points: points.count as u32,
        slots: points.slots as u32,
        window_count: if points.of_panes { 0 } else { tracer.window_count },
        components: components as u32,
        plain: u32::from(points.of_panes),
        batch_points: batch_points as u32,
        batch_stride: batch_stride as u32,
    };
    let params = device.uniform("links", &params)?;
    let own = [("params", &params), ("receivers", receivers), ("vertices", points.vertices), ("links", &links)];
    tracer.run(&tracer.kernel(&LINKS, &[])?, &own, (points.count * count) as u64, statistics)?;
    Ok(links)
}
