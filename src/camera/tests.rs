use super::*;
use crate::testing::{output, radiance, shared};

/// A view of each projection, turned in space, with shift and lift.
fn views() -> Vec<View> {
    Projection::ALL
        .into_iter()
        .enumerate()
        .map(|(i, projection)| {
            let (horizontal, vertical) = match projection {
                Projection::Perspective => (70.0, 50.0),
                Projection::Parallel => (3.0, 2.0),
                Projection::Hemispherical => (180.0, 150.0),
                Projection::Angular => (200.0, 180.0),
                Projection::Planispheric => (180.0, 240.0),
                Projection::Cylindrical => (300.0, 80.0),
            };
            View {
                projection,
                point: DVec3::new(1.0, -2.0, 1.5 + i as f64),
                direction: DVec3::new(0.3, 2.0, -0.4),
                up: DVec3::new(0.1, 0.2, 3.0),
                horizontal,
                vertical,
                shift: if i % 2 == 0 { 0.25 } else { 0.0 },
                lift: if i % 3 == 0 { -0.125 } else { 0.0 },
                ..View::default()
            }
        })
        .collect()
}

fn theirs(view: &View, width: usize, height: usize) -> Option<Vec<[f64; 6]>> {
    let mut vwrays = radiance("vwrays")?;
    vwrays.args(["-fd", "-pa", "0", "-x", &width.to_string(), "-y", &height.to_string()]);
    let bytes = output(vwrays.args(view.to_options().split_whitespace()));
    Some(bytes.chunks_exact(48).map(|ray| std::array::from_fn(|i| f64::from_le_bytes(ray[i * 8..][..8].try_into().unwrap()))).collect())
}

#[test]
fn rays_are_those_of_vwrays() {
    let mut inside = 0;
    let mut outside = 0;
    for view in views() {
        for (fore, aft) in [(0.0, 0.0), (0.5, 0.0), (0.25, 4.0)] {
            let view = View { fore, aft, ..view };
            let Some(theirs) = theirs(&view, 13, 11) else { return };
            let raster = Raster::new(view.camera().unwrap(), 13, 11).unwrap();
            assert_eq!(theirs.len(), raster.len());
            for (i, ray) in theirs.iter().enumerate() {
                let ours = raster.ray(i % 13, i / 13);
                let (origin, direction) = (DVec3::from_slice(&ray[..3]), DVec3::from_slice(&ray[3..]));
                match ours {
                    None => {
                        assert_eq!(*ray, [0.0; 6], "{view:?} pixel {i}");
                        outside += 1;
                    }
                    Some(ours) => {
                        let scaled = ours.direction * if ours.length > 0.0 { ours.length } else { 1.0 };
                        assert!((ours.origin - origin).length() < 1e-12, "{view:?} pixel {i}: {ours:?} {ray:?}");
                        assert!((scaled - direction).length() < 1e-12, "{view:?} pixel {i}: {ours:?} {ray:?}");
                        inside += 1;
                    }
                }
            }
        }
    }
    assert!(inside > 2000 && outside > 50, "{inside} {outside}");
}

#[test]
fn resolutions_are_those_of_vwrays() {
    for view in views() {
        for (width, height, aspect) in [(16, 12, 1.0), (400, 400, 1.0), (100, 333, 1.0), (640, 480, 1.5), (77, 50, 0.3), (50, 60, 0.0)] {
            let Some(mut vwrays) = radiance("vwrays") else { return };
            vwrays.args(["-d", "-pa", &format!("{aspect}"), "-x", &width.to_string(), "-y", &height.to_string()]);
            let text = String::from_utf8(output(vwrays.args(view.to_options().split_whitespace()))).unwrap();
            let raster = Raster::fit(view.camera().unwrap(), width, height, aspect).unwrap();
            assert!(text.starts_with(&format!("-x {} -y {}", raster.width(), raster.height())), "{text} {raster:?}");
            assert_eq!(text.split_whitespace().nth(3).unwrap(), raster.height().to_string(), "{view:?} {width} {height} {aspect}");
        }
    }
}

#[test]
fn directions_lead_back_to_their_pixels() {
    for view in views() {
        let view = View { fore: 0.5, ..view };
        let raster = Raster::new(view.camera().unwrap(), 61, 47).unwrap();
        let mut found = 0;
        for row in 0..47 {
            for column in 0..61 {
                let offset = DVec2::new(0.3, -0.4);
                let Some(ray) = raster.sample(column, row, offset) else { continue };
                let Some(position) = raster.camera().locate_point(ray.origin + ray.direction * 2.5) else {
                    panic!("{view:?}: {column} {row}")
                };
                let expected = DVec2::new((column as f64 + 0.8) / 61.0, 1.0 - (row as f64 + 0.9) / 47.0);
                // The rim of a hemisphere is flat: position = sin θ.
                assert!((position - expected).length() < 1e-9, "{view:?}: {position} {expected}");
                if view.projection != Projection::Parallel {
                    assert_eq!(raster.pixel_of(ray.direction), Some((column, row)));
                }
                found += 1;
            }
        }
        assert!(found > 1000, "{view:?}: {found}");
    }
    let camera = View::default().camera().unwrap();
    assert_eq!(camera.locate(-DVec3::Y), None);
    assert_eq!(Raster::new(camera, 9, 9).unwrap().pixel_of(DVec3::X), None);
}

#[test]
fn solid_angles_add_up() {
    // Straight edges: the pixels of a perspective fill exactly the pyramid of the whole view.
    let view = View { horizontal: 90.0, vertical: 60.0, ..View::default() };
    let raster = Raster::new(view.camera().unwrap(), 40, 30).unwrap();
    let exact = 4.0 * (45f64.to_radians().sin() * 30f64.to_radians().sin()).asin();
    let sum: f64 = (0..1200).map(|i| raster.solid_angle(i % 40, i / 40)).sum();
    assert!((sum - exact).abs() < 1e-12, "{sum} {exact}");
    assert_eq!(raster.solid_angles(), (0..1200).map(|i| raster.solid_angle(i % 40, i / 40)).collect::<Vec<_>>());

    // A cylinder is bounded by small circles, a fisheye by a ragged rim: the errors fall with the
    // square (cylinder) or at least the first power (rim) of the pixel.
    let view = View { projection: Projection::Cylindrical, horizontal: 360.0, vertical: 90.0, ..View::default() };
    let raster = Raster::new(view.camera().unwrap(), 720, 180).unwrap();
    let exact = 4.0 * PI * 45f64.to_radians().sin();
    assert!((raster.solid_angles().iter().sum::<f64>() / exact - 1.0).abs() < 1e-5);

    for projection in [Projection::Angular, Projection::Planispheric, Projection::Hemispherical] {
        let view = View { projection, horizontal: 180.0, vertical: 180.0, ..View::default() };
        let raster = Raster::new(view.camera().unwrap(), 400, 400).unwrap();
        let sum: f64 = raster.solid_angles().iter().zip(raster.mask()).map(|(w, seen)| if seen { *w } else { 0.0 }).sum();
        // At the rim of a hemispherical fisheye sin θ = 1, and a pixel with a corner beyond is
        // lost: those within a diagonal of √2/200, where cos θ is still large.
        let loss = if projection == Projection::Hemispherical { (1.0 - (1.0 - 2f64.sqrt() / 200.0).powi(2)).sqrt() } else { 0.002 };
        assert!((sum / (2.0 * PI) - 1.0).abs() < loss, "{projection:?} {sum}");
    }
    let parallel = View { projection: Projection::Parallel, ..View::default() };
    assert_eq!(Raster::new(parallel.camera().unwrap(), 4, 4).unwrap().solid_angle(1, 1), 0.0);
}

#[test]
fn no_view_that_is_accepted_gives_a_number_without_meaning() {
    let sizes = |projection: Projection| -> (f64, f64) {
        match projection {
            Projection::Perspective => (180.0 - 2e-6, 1e-5),
            Projection::Parallel => (1e9, 1e-5),
            Projection::Hemispherical => (180.0, 1e-5),
            Projection::Angular => (360.0, 180.0),
            Projection::Planispheric => (360.0 - 2e-6, 1e-5),
            Projection::Cylindrical => (360.0, 180.0 - 2e-6),
        }
    };
    for projection in Projection::ALL {
        let (wide, narrow) = sizes(projection);
        for (horizontal, vertical) in [(wide, narrow), (narrow.min(170.0), wide.min(179.9)), (narrow.min(170.0), narrow)] {
            for far in [0.0, 0.5, -0.5, 1e6, -1e6] {
                let view = View {
                    projection,
                    horizontal,
                    vertical,
                    shift: far,
                    lift: -far,
                    aft: 1e9,
                    point: DVec3::splat(1e9 * far.signum()),
                    ..View::default()
                };
                let raster = Raster::new(view.camera().unwrap(), 5, 4).unwrap();
                for i in 0..20 {
                    let whole = raster.solid_angle(i % 5, i / 5);
                    let plain = raster.plain_solid_angle(i % 5, i / 5);
                    assert!((0.0..=4.0 * PI).contains(&whole) && plain.is_finite(), "{view:?}: {whole} {plain}");
                    if let Some(ray) = raster.ray(i % 5, i / 5) {
                        assert!(
                            (ray.direction.length() - 1.0).abs() < 1e-9 && ray.origin.is_finite() && ray.length.is_finite(),
                            "{view:?} {ray:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn plain_solid_angles_approach_the_exact_ones() {
    for view in views().into_iter().filter(|v| v.projection != Projection::Parallel) {
        let raster = Raster::new(view.camera().unwrap(), 300, 300).unwrap();
        for i in (0..90_000).step_by(97) {
            let (exact, plain) = (raster.solid_angle(i % 300, i / 300), raster.plain_solid_angle(i % 300, i / 300));
            if exact > 0.0 && raster.ray(i % 300, i / 300).unwrap().direction.dot(raster.camera().direction) > 0.3 {
                assert!((plain / exact - 1.0).abs() < 2e-3, "{view:?} pixel {i}: {exact} {plain}");
            }
        }
    }
}

#[test]
fn solid_angles_are_those_of_evalglare() {
    use crate::image::{Picture, hdr};
    let folder = tempfile::tempdir().unwrap();
    for (projection, angle) in [(Projection::Angular, 180.0), (Projection::Hemispherical, 180.0), (Projection::Perspective, 100.0)] {
        for (x, y) in [(20, 22), (40, 9), (33, 50)] {
            let Some(mut evalglare) = radiance("evalglare") else { return };
            let view = View { projection, horizontal: angle, vertical: angle, ..View::default() };
            let mut picture = Picture::new(64, 64, vec![[1.0; 3]; 64 * 64]).unwrap();
            picture.pixels[y * 64 + x] = [200.0; 3];
            picture.view = Some(view.to_options());
            let path = folder.path().join("spot.hdr");
            hdr::write(&path, &picture).unwrap();
            let text = String::from_utf8(output(evalglare.arg("-d").arg(&path))).unwrap();
            let source: Vec<f64> = text.lines().nth(1).unwrap().split_whitespace().map(|w| w.parse().unwrap()).collect();
            let raster = Raster::new(view.camera().unwrap(), 64, 64).unwrap();
            // Columns: No pixels x-pos y-pos L_s Omega_s …; y-pos counts from 1.
            assert_eq!(source[..4], [1.0, 1.0, x as f64, y as f64 + 1.0], "{text}");
            let ours = raster.solid_angle(x, y);
            // evalglare prints ten decimals.
            assert!((source[5] - ours).abs() <= 1e-10 + 1e-6 * ours, "{projection:?} {x} {y}: {} {ours}", source[5]);
        }
    }
}

#[test]
fn masks() {
    let count = |projection, angle, shift| {
        let view = View { projection, horizontal: angle, vertical: angle, shift, ..View::default() };
        Raster::new(view.camera().unwrap(), 100, 100).unwrap().mask().iter().filter(|&&seen| seen).count()
    };
    let circle = (PI / 4.0 * 1e4) as i64;
    for projection in [Projection::Angular, Projection::Planispheric, Projection::Hemispherical] {
        let seen = count(projection, 180.0, 0.0) as i64;
        assert!((seen - circle).abs() < 40, "{projection:?} {seen} {circle}");
    }
    assert_eq!(count(Projection::Angular, 90.0, 0.0), 10_000, "a part of a fisheye fills the frame");
    assert!((count(Projection::Angular, 360.0, 0.0) as i64 - circle).abs() < 40);
    assert!(count(Projection::Angular, 180.0, 0.5) > 9000);
    assert_eq!(count(Projection::Perspective, 100.0, 0.0), 10_000);
}

#[test]
fn samples_cover_the_pixel_evenly() {
    let samples = PixelSamples::new(256, 0.5, 7).unwrap();
    let mut mean = DVec2::ZERO;
    let mut cells = [0; 16];
    for i in 0..256 {
        let p = samples.offset(12345, i);
        assert!(p.abs().max_element() <= 0.25);
        mean += p / 256.0;
        let cell = ((p / 0.5 + 0.5) * 4.0).floor();
        cells[(cell.y * 4.0 + cell.x) as usize] += 1;
    }
    // Exactly even in cells; 256 independent samples would scatter by 0.5/√12/√256 = 0.009.
    assert!(mean.length() < 0.003, "{mean}");
    assert_eq!(cells, [16; 16]);
    assert_ne!(samples.offset(1, 0), samples.offset(2, 0));
    assert_eq!(PixelSamples::new(3, 0.0, 7).unwrap().offset(5, 2), DVec2::ZERO);
    assert!(PixelSamples::new(0, 0.5, 1).is_err());
    assert!(PixelSamples::new(1, f64::NAN, 1).is_err());
    // Offsets go to the right and up.
    let raster = Raster::new(View::default().camera().unwrap(), 3, 3).unwrap();
    let (centre, moved) = (raster.ray(1, 1).unwrap(), raster.sample(1, 1, DVec2::new(0.4, 0.3)).unwrap());
    assert!(moved.direction.x > centre.direction.x && moved.direction.z > centre.direction.z);
}

#[test]
fn options_and_view_files() {
    let view = View::parse("-vta -vp 1 2 3 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 170.5 -vo 0.1 -va 9 -vs .25 -vl -.5").unwrap();
    assert_eq!(View::parse(&view.to_options()).unwrap(), view);
    assert_eq!((view.vertical, view.shift, view.lift, view.aft), (170.5, 0.25, -0.5, 9.0));
    assert_eq!(View::parse("--vt c --vh 10").unwrap().projection, Projection::Cylindrical);

    let text = "#?RADIANCE\n/usr/bin/rpict -x 512 -vf other.vf -vtv -vp 1 1 1 -ab 3 room.oct\n\tVIEW= -vtl\nVIEW= -vth -vh 120\nFORMAT=x";
    let view = View::from_lines(text).unwrap();
    assert_eq!((view.projection, view.point, view.horizontal), (Projection::Hemispherical, DVec3::ONE, 120.0));
    assert!(View::from_lines("rcontrib -V+ -vtv\n").is_err());
    assert_eq!(View::from_lines("-vta -vh 99").unwrap().horizontal, 99.0);
    // As Radiance's rays through a picture that has no VIEW= line.
    let text = "#?RADIANCE\r\npinterp -vtl -ff -vh 3 -vx 7 -vtoo a.hdr 1\r\nvwrays -vv 4 -ld-\r\n";
    let view = View::from_lines(text).unwrap();
    assert_eq!((view.projection, view.horizontal, view.vertical), (Projection::Parallel, 3.0, 4.0));
    assert_eq!(View::options_in_header("rxpiece --vtl -x 3 -vp 1 2"), ["-vtl", "-vp 1 2"]);
    assert!(View::options_in_header("\trpict -vta").is_empty() && View::options_in_header("-vta").is_empty());

    for (options, expected) in [
        ("-vtq", "unknown projection"),
        ("-vt", "unknown projection"),
        ("-vtaa", "unknown projection"),
        ("-vp 1 2", "found 'nothing'"),
        ("-vh wide", "found 'wide'"),
        ("-vh nan", "found 'nan'"),
        ("-vx 3", "no view option"),
        ("-ab 3", "no view option"),
    ] {
        let error = View::parse(options).unwrap_err().to_string();
        assert!(error.contains(expected), "{options}: {error}");
    }
    assert!(View::from_lines("x\nrvu -vta -vp 1 two 3").unwrap_err().to_string().contains("line 2"));

    let Some(shared) = shared() else { return };
    let view = View::read(&shared.join("data/tutorial_room/views/fish.vf")).unwrap();
    assert_eq!(view.projection, Projection::Angular);
    view.camera().unwrap();
}

#[test]
fn impossible_views_are_refused() {
    let check = |options: &str, expected: &str| {
        let error = View::parse(options).unwrap().camera().expect_err(options).to_string();
        assert!(error.contains(expected), "{options}: {error}");
    };
    check("-vd 0 0 0", "-vd");
    check("-vu 0 0 0", "-vu");
    check("-vd 0 0 -1", "parallel");
    check("-vd 0 1 0 -vu 0 -3 0", "parallel");
    check("-vo 3 -va 2", "-vo");
    check("-vo -1", "-vo");
    for (options, expected) in [
        ("-vtv -vh 180", "-vh"),
        ("-vtv -vv 180", "-vv"),
        ("-vtv -vh 0", "-vh"),
        ("-vtl -vv -2", "-vv"),
        ("-vth -vh 181", "-vh"),
        ("-vta -vh 361", "-vh"),
        ("-vts -vh 360", "-vh"),
        ("-vtc -vv 180", "-vv"),
        ("-vtc -vh 400", "-vh"),
    ] {
        check(options, expected);
        // Radiance refuses the same ones.
        if let Some(mut vwrays) = radiance("vwrays") {
            let out = vwrays.args(["-x", "2", "-y", "2"]).args(options.split(' ')).output().unwrap();
            assert!(!out.status.success(), "vwrays {options}");
        }
    }
    for options in
        ["-vts -vs 1e308", "-vl -1e7", "-vp 0 1e10 0", "-vtl -vv 1e12", "-vo 1e300", "-va 1e10", "-vd 1e200 0 0", "-vu 0 0 -1e300"]
    {
        check(options, "out of range");
    }
    View::parse("-vtl -vh 4000 -vv 3000").unwrap().camera().unwrap();
    let camera = View::default().camera().unwrap();
    for (width, height) in [(0, 5), (5, 0), (70_000, 5), (usize::MAX, usize::MAX)] {
        assert!(Raster::new(camera, width, height).is_err());
        assert!(Raster::fit(camera, width, height, 1.0).is_err());
    }
    assert!(Raster::fit(camera, 5, 5, f64::NAN).is_err());
    assert!(Raster::fit(camera, 5, 1, 1e-4).is_err(), "nothing is left");
}
