//! Lines of the tables: of pictures, of sources, of zones and the band.

use lucarne::glare::statistics::Statistics;
use lucarne::glare::{self, Glare, Settings};
use std::fmt::Write;

/// First line of the table of pictures.
pub(super) const HEADER: &str = "file,dgp,dgi,ugr,vcp,cgi,ugp,ev_lux,average_luminance,background_luminance,sources";
/// First line of the table of sources.
pub(super) const SOURCE_HEADER: &str = "file,source,pixels,x,y,luminance,peak_luminance,solid_angle_sr,position_index,sigma_deg,tau_deg,illuminance_lux,contrast,direction_x,direction_y,direction_z,is_peak";

/// First line of the table of zones and the band.
pub(super) const PART_HEADER: &str = "file,part,pixels,solid_angle_sr,average_luminance,standard_deviation,least,median,percentile_75,percentile_95,greatest,illuminance_lux";

/// Statistics of a part of a picture.
pub(super) struct Measured {
    pub name: &'static str,
    pub statistics: Statistics,
}

pub(super) fn part_line(name: &str, measured: &Measured, out: &mut String) {
    let s = &measured.statistics;
    let [least, median, three_quarters, most, greatest] = s.quantiles;
    let _ = writeln!(
        out,
        "{name},{},{},{:.8},{:.6},{:.6},{least:.6},{median:.6},{three_quarters:.6},{most:.6},{greatest:.6},{:.6}",
        measured.name, s.pixels, s.solid_angle, s.average, s.standard_deviation, s.illuminance
    );
}

pub(super) fn picture_line(name: &str, glare: &Glare) -> String {
    let i = &glare.indices;
    let numbers =
        [i.dgp, i.dgi, i.ugr, i.vcp, i.cgi, i.ugp, glare.vertical_illuminance, glare.average_luminance, glare.background_luminance];
    let mut line = name.to_string();
    for n in numbers {
        let _ = write!(line, ",{n:.6}");
    }
    let _ = writeln!(line, ",{}", glare.sources.len());
    line
}

pub(super) fn source_lines(name: &str, glare: &Glare, settings: &Settings, out: &mut String) {
    let contrast_of = |s: &glare::Source| settings.dgp.contrast_of((s.luminance, s.solid_angle, s.position_index));
    let whole: f64 = glare.sources.iter().map(contrast_of).sum();
    for (n, s) in glare.sources.iter().enumerate() {
        let share = if whole > 0.0 { contrast_of(s) / whole } else { 0.0 };
        let [dx, dy, dz] = s.direction;
        let _ = writeln!(
            out,
            "{name},{},{},{:.3},{:.3},{:.6},{:.6},{:.10},{:.6},{:.6},{:.6},{:.6},{:.6},{dx:.6},{dy:.6},{dz:.6},{}",
            n + 1,
            s.pixels.len(),
            s.x,
            s.y,
            s.luminance,
            s.peak_luminance,
            s.solid_angle,
            s.position_index,
            s.sigma,
            s.tau,
            s.illuminance,
            share * glare.indices.contrast,
            u8::from(s.is_peak)
        );
    }
}

/// A field of a CSV file.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_string() }
}
