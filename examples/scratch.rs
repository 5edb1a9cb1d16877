use lucarne::image::{drawing::*, palette::*};
fn main() {
    let mut d = Drawing::new(700.0, 330.0);
    for (i, (t, s)) in [("ABCDEFGHIJKLMNOPQRSTUVWXYZ 0123456789", 20.0), ("abcdefghijklmnopqrstuvwxyz äöüéè ß", 20.0), (".,:;-−+=<>≤≥×·/|%()[]'\"!?*#&@ °²³¹⁻ µθφτρΩ→", 20.0), ("Luminance [cd/m²]   Illuminance, lx", 16.0), ("Luminance [cd/m²]  0 500 1000 1500 2000 hour Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec", 12.0), ("The quick brown fox jumps over the lazy dog 0.45 Glare", 10.0)].iter().enumerate() {
        d.label(*t, [10.0, 25.0 + 38.0 * i as f64], *s, INK, Anchor::Start);
    }
    for (i, p) in Palette::ALL.iter().enumerate() {
        for x in 0..200 { d.rectangle([10.0 + x as f64, 240.0 + 12.0 * i as f64, 1.0, 11.0], p.color(x as f64 / 199.0)); }
        d.label(p.name(), [220.0, 246.0 + 12.0 * i as f64], 10.0, INK, Anchor::Start);
    }
    d.write(std::path::Path::new("/tmp/img_font.png"), 2.0).unwrap();
}
