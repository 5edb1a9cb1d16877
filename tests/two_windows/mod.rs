//! A room with two windows in its south wall.

use std::path::Path;

/// A louvre's scattering data.
pub const LOUVRE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/asymmetric/louvre.xml");
const MATERIALS: &str = "void plastic wall 0 0 5 .5 .5 .5 0 0\nvoid plastic grey 0 0 5 .4 .4 .4 0 0\n";

/// Writes its files, with a day of March that has sun from 8:00 to 16:00 and slats in front of the windows up to x = `slats_end`, m.
pub fn write(folder: &Path, slats_end: f64) {
    let sun = |h: usize| match h {
        8..16 => "500 150",
        16 => "0 100",
        _ => "0 0",
    };
    let weather: String = (0..24).map(|h| format!("3 21 {h}.5 {}\n", sun(h))).collect();
    let window = |low: f64, high: f64| {
        format!(
            "void glow light 0 0 4 1 1 1 0\n#@rfluxmtx h=kq u=+Z\nlight polygon w 0 0 12 {low} 0 1 {low} 0 2.4 {high} 0 2.4 {high} 0 1\n"
        )
    };
    let slat = |z: f64| {
        format!("grey polygon slat{z} 0 0 12 0.5 -.05 {z} {slats_end} -.05 {z} {slats_end} -.2 {low} 0.5 -.2 {low}\n", low = z - 0.1)
    };
    let slats: String = [1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4].map(slat).concat();
    for (name, text) in [
        ("day.wea", format!("place X\nlatitude 45\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n{weather}")),
        ("room.rad", MATERIALS.to_string() + include_str!("../data/plain_room.rad")),
        ("west.rad", window(0.5, 1.5)),
        ("east.rad", window(1.5, 2.5)),
        ("slats.rad", slats),
        ("points.txt", "0.8 0.7 0.8 0 0 1\n2.2 1.5 0.8 0 0 1\n1.5 2.5 0.8 0 0 1\n1.2 3.5 0.8 0 0 1\n".to_string()),
        ("eyes.txt", "1.5 2.5 1.2 0 -1 0\n0.9 1.5 1.2 0 -1 0\n".to_string()),
        ("v.vf", "rvu -vta -vp 1.5 2.5 1.2 -vd 0 -1 0 -vh 180 -vv 180\n".to_string()),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
}
