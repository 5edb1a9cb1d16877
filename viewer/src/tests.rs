//! The program as a user meets it: clicks, keys, files, and pictures of every panel.

use crate::app::App;
use crate::args::{Args, PanelKind};
use crate::offscreen::Offscreen;
use eframe::egui::{Key, Modifiers, Pos2, Rect};
use glam::DVec3;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, write_matrix};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

fn scenes(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(path)
}

/// A window with files open and settled.
fn open(files: &[&Path], panel: Option<PanelKind>) -> (Offscreen, App) {
    let mut window = Offscreen::new([1280, 800], 1.0);
    let args = Args { files: files.iter().map(|f| f.to_path_buf()).collect(), panel, screenshot: Some("none".into()), ..Args::default() };
    let mut app = App::new(window.ctx(), &args, None);
    window.settle(&mut app).unwrap();
    (window, app)
}

fn place(window: &Offscreen, text: &str) -> Rect {
    let texts = window.texts();
    texts.iter().find(|(t, _)| t == text).unwrap_or_else(|| panic!("'{text}' is not shown: {texts:?}")).1
}

fn shows(window: &Offscreen, part: &str) -> bool {
    window.texts().iter().any(|(t, _)| t.contains(part))
}

/// A small result folder: two rows of sensors whose illuminance is known, a view of 8 × 6 pixels,
/// one window, one hour of sun.
fn results() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    FOLDER.get_or_init(|| make_results().unwrap()).path()
}

/// Illuminance of sensor `s` at hour `h`: a day's half sine, largest on 21 January at noon.
fn lux(s: usize, h: usize) -> f32 {
    let day = ((h % 24) as f32 - 12.0) / 6.0;
    let peak = if h == 20 * 24 + 12 { 2.0 } else { 1.0 };
    if day.abs() >= 1.0 { 0.0 } else { (1000.0 + 100.0 * s as f32) * (1.0 - day * day) * peak }
}

fn make_results() -> lucarne::Result<tempfile::TempDir> {
    let folder = tempfile::tempdir().unwrap();
    for sub in ["illuminance", "matrices", "glare"] {
        std::fs::create_dir(folder.path().join(sub)).unwrap();
    }
    let write = |name: &str, rows: usize, cols: usize, n: usize, header: &[String], f: &dyn Fn(usize, usize) -> f32| {
        let data = (0..rows * cols).flat_map(|k| std::iter::repeat_n(f(k / cols, k % cols), n)).collect();
        write_matrix(Some(&folder.path().join(name)), &Matrix::from_data(rows, cols, n, data)?, Format::Float, header)
    };
    write("illuminance/desks.mtx", 6, 8760, 1, &[], &lux)?;
    let positions: Vec<DVec3> = (0..6).map(|s| DVec3::new((s % 3) as f64, (s / 3) as f64, 0.8)).collect();
    let labels: Vec<String> = positions.iter().enumerate().map(|(i, p)| format!("{} ({} {} {})", i + 1, p.x, p.y, p.z)).collect();
    let mut csv = format!("month,day,hour,{}\n", labels.join(","));
    for time in lucarne::weather::time::Time::common_year(8760) {
        csv += &format!("{},{},{:.3},0\n", time.month, time.day, time.hour);
    }
    std::fs::write(folder.path().join("illuminance/desks.csv"), csv).unwrap();
    let lit = |h: usize| lux(0, h) / 1000.0;
    write("matrices/V_desks.mtx", 6, 145, 3, &[], &|s, _| 0.01 * (s + 1) as f32)?;
    write("matrices/S.mtx", 146, 8760, 3, &[], &|p, h| lit(h) * if p == 0 { 0.1 } else { 1.0 })?;
    write("matrices/D_south.mtx", 145, 146, 3, &[], &|b, p| if b + 1 == p { 1.0 } else { 0.0 })?;
    write("matrices/T_south.mtx", 145, 145, 3, &[], &|o, i| if o == i { 0.5 } else { 0.0 })?;
    let header = ["RESOLUTION=-Y 6 +X 8".to_string(), "VIEW= -vta -vp 0 0 1 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 135".to_string()];
    write("matrices/V_desk.mtx", 48, 145, 3, &header, &|p, b| if b == p { 2.0 } else { 0.0 })?;
    let glare: String = (0..8760).filter(|h| lit(*h) > 0.0).map(|h| format!("{h},{:.4},0.001,900,1,x\n", 0.2 + 0.1 * lit(h))).collect();
    std::fs::write(folder.path().join("glare/desk.csv"), format!("hour,dgp,dgp_standard_error,ev_lux,sources,class\n{glare}")).unwrap();
    let summary = r#"{"sensors":[{"name":"desks"}],"views":[{"name":"desk"}],"matrices":[{"name":"D_south"},{"name":"V_desk"}],"hours":8760,"preset":"draft","device":{"name":"test"}}"#;
    std::fs::write(folder.path().join("summary.json"), summary).unwrap();
    Ok(folder)
}

#[test]
fn clicking_patch_1_shows_the_values_of_lucarne_bsdf() {
    let path = scenes("office/bsdf/blind.xml");
    let (mut window, mut app) = open(&[&path], None);
    let bsdf = lucarne::bsdf::read(&path, &mut lucarne::Warnings::new()).unwrap();
    let block = bsdf.visible.transmission_front.as_ref().unwrap();
    // What `bsdf info` prints.
    assert!(shows(&window, &format!("diffuse light {:.4}", block.hemispherical())));
    let title = place(&window, "Incident").center();
    let (top, bottom) = (place(&window, "90°").bottom(), place(&window, "270°").top());
    let middle = Pos2::new(title.x, (top + bottom) / 2.0);
    window.click(&mut app, middle);
    assert_eq!(app.views.bsdf.incident, [0.0, 0.0]);
    let total = block.direct_hemispherical(DVec3::Z);
    assert!(shows(&window, &format!("light along θ 0°: {total:.4} transmitted")), "{:?}", window.texts());
    assert!(shows(&window, "Incident   patch 1   θ") && shows(&window, &format!("share transmitted {total:.4}")));
    // The outgoing disc's middle is patch 1, too.
    let out = place(&window, "Outgoing").center();
    window.point(&mut app, Pos2::new(out.x, middle.y));
    let value = crate::plot::value_text(block.as_klems().unwrap().at(0, 0));
    assert!(shows(&window, &format!("f {value} /sr")), "{value} {:?}", window.texts());
    // Undo goes back to the direction shown first.
    window.key(&mut app, Key::Z, Modifiers::COMMAND);
    assert_eq!(app.views.bsdf.incident, [40.0, 270.0]);
}

/// A tensor tree of 20 MB: 16⁵ values for each side.
fn large_tree() -> String {
    fn node(depth: u32, state: &mut u32, out: &mut String) {
        if depth == 0 {
            *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *out += &format!("0.{:06} ", (*state >> 8) % 300_000);
            return;
        }
        *out += "{ ";
        (0..16).for_each(|_| node(depth - 1, state, out));
        *out += "} ";
    }
    let mut text = "<?xml version=\"1.0\"?>\n<WindowElement>\n<WindowElementType>System</WindowElementType>\n<Optical>\n<Layer>\n\
                    <Material><Name>large</Name></Material>\n<DataDefinition>\n\
                    <IncidentDataStructure>TensorTree4</IncidentDataStructure>\n</DataDefinition>\n"
        .to_string();
    for direction in ["Transmission Front", "Transmission Back"] {
        text += &format!(
            "<WavelengthData>\n<Wavelength unit=\"Integral\">Visible</Wavelength>\n<WavelengthDataBlock>\n\
             <WavelengthDataDirection>{direction}</WavelengthDataDirection>\n<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>\n\
             <ScatteringDataType>BTDF</ScatteringDataType>\n<ScatteringData>\n"
        );
        node(5, &mut 7, &mut text);
        text += "\n</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>\n";
    }
    text + "</Layer>\n</Optical>\n</WindowElement>\n"
}

#[test]
fn a_large_tensor_tree_opens_and_answers_the_pointer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.xml");
    let text = large_tree();
    assert!(text.len() > 19_000_000);
    std::fs::write(&path, text).unwrap();
    let cpu = cpu_seconds();
    let start = std::time::Instant::now();
    let (mut window, mut app) = open(&[&path], None);
    println!("opened in {:.2?}, {:.2} s of processor time", start.elapsed(), cpu_seconds() - cpu);
    let out = place(&window, "Outgoing").center();
    let (mut slowest, mut values) = (std::time::Duration::ZERO, std::collections::BTreeSet::new());
    for k in 0..40 {
        let start = std::time::Instant::now();
        window.point(&mut app, Pos2::new(out.x - 80.0 + 4.0 * k as f32, out.y + 150.0 + 3.0 * k as f32));
        slowest = slowest.max(start.elapsed());
        values.extend(window.texts().into_iter().map(|t| t.0).filter(|t| t.contains("f 0.") && t.contains("/sr")));
    }
    println!("slowest frame {slowest:.1?}, {} different values under the pointer", values.len());
    // On a busy machine, still: no search through the whole tree.
    assert!(values.len() > 10 && slowest.as_secs_f64() < 0.25, "{values:?}");
}

#[test]
fn two_bsdfs_are_compared() {
    let (a, b) = (scenes("office/bsdf/blind.xml"), scenes("office/bsdf/double_clear.xml"));
    let (mut window, mut app) = open(&[&a, &b], None);
    assert!(shows(&window, "A: Outgoing") && shows(&window, "B: Outgoing") && shows(&window, "double_clear.xml"));
    window.key(&mut app, Key::D, Modifiers::NONE);
    window.frame(&mut app);
    assert!(shows(&window, "Difference B − A"));
}

#[test]
fn clicking_the_carpet_changes_the_hour_and_its_picture() {
    let (mut window, mut app) = open(&[results()], None);
    assert_eq!(app.views.panel, PanelKind::Year);
    assert!(shows(&window, "Daylight glare probability of desk"));
    // The first is the choice at the side.
    let frame = window.texts().into_iter().rfind(|(t, _)| t == "Daylight glare probability of desk").unwrap().1;
    let (low, high) = (place(&window, "0 h").center().y, place(&window, "24 h").center().y);
    // 1 February (day 31) at 9:30.
    let left = frame.left();
    let day = (place(&window, "Dec").left() - 4.0 - left) / 334.0;
    let at = Pos2::new(left + 31.5 * day, low + (high - low) * 9.5 / 24.0);
    window.click(&mut app, at);
    window.settle(&mut app).unwrap();
    assert_eq!(app.views.year.hour, 31 * 24 + 9);
    assert!(shows(&window, "1 February, 09:30") && shows(&window, "hour 753"), "{:?}", window.texts());
    let dgp = 0.2 + 0.1 * f64::from(lux(0, 753)) / 1000.0;
    assert!(shows(&window, &format!("DGP {dgp:.3}")), "{dgp} {:?}", window.texts());
    // The picture: V = 2, T = 0.5, D = 1, so that a pixel is the sky of its bin; 48 of 48 are lit.
    let mean = 179.0 * f64::from(lux(0, 753)) / 1000.0;
    assert!(shows(&window, &format!("mean {} cd/m²", lucarne::image::palette::rounded_number(mean))), "{mean} {:?}", window.texts());
    // The worst hour is one click away.
    let button = place(&window, "Worst glare hour").center();
    window.click(&mut app, button);
    assert_eq!(app.views.year.hour, 20 * 24 + 12);
    window.key(&mut app, Key::ArrowRight, Modifiers::NONE);
    assert_eq!(app.views.year.hour, 20 * 24 + 13);
}

#[test]
fn a_bsdf_over_a_year_is_another_state_of_the_facade() {
    let clear = scenes("office/bsdf/double_clear.xml");
    let (mut window, mut app) = open(&[results()], None);
    app.open(&clear);
    window.settle(&mut app).unwrap();
    assert_eq!(app.first_error(), None);
    assert_eq!((app.views.panel, app.views.year.fractions.as_slice()), (PanelKind::Year, &[1.0][..]));
    assert!(shows(&window, "to double_clear.xml"));
    // DGP stays that of the run: said beside header and carpet.
    let said = "DGP: of the façade as computed, not with south 100 % double_clear.xml";
    assert!(shows(&window, said) && shows(&window, "Daylight glare probability of desk (façade as computed)"), "{:?}", window.texts());
    // Illuminance follows, in the carpet and on the grid.
    app.views.year.quantity = crate::year::model::Quantity::Sensor(0, 5);
    window.settle(&mut app).unwrap();
    assert!(!shows(&window, "as computed)"), "{:?}", window.texts());
    let results = app.results.clone().unwrap();
    let (hour, stored) = (app.views.year.hour, f64::from(lux(5, app.views.year.hour)));
    let found = f64::from(app.year.lux(&results, &[1.0]).lux.unwrap()[0].at(5, hour)[0]);
    assert!((found / stored - 1.0).abs() > 0.1, "{found} {stored}");
    let text = lucarne::image::palette::rounded_number(found);
    assert!(shows(&window, &format!("{text} lx")), "{text} {:?}", window.texts());
    (app.views.panel, app.views.grid.metric) = (PanelKind::Grid, crate::grid::metric::Metric::Hour);
    window.settle(&mut app).unwrap();
    assert!(shows(&window, "The façade with south 100 % double_clear.xml: the Year panel's choice"), "{:?}", window.texts());
    assert!(window.texts().iter().any(|(t, _)| *t == text), "{text} {:?}", window.texts());
    // Half way: until it is computed the earlier state is dimmed and called so.
    app.views.year.fractions = vec![0.5];
    window.frame(&mut app);
    let ready = app.year.lux(&results, &[0.5]).instead.is_none();
    assert!(ready || shows(&window, "an earlier state of the façade; the new one is being computed"), "{:?}", window.texts());
    window.settle(&mut app).unwrap();
    assert!(!shows(&window, "an earlier state"));
    // Back at the stored one. Behind another panel the Year panel's picture is not waited for.
    (app.views.panel, app.views.year.hour) = (PanelKind::Year, hour + 1);
    window.frame(&mut app);
    app.views.panel = PanelKind::Grid;
    app.views.year.fractions = vec![0.0];
    window.settle(&mut app).unwrap();
    assert!(!shows(&window, "The façade with") && shows(&window, "The façade as computed."));
}

#[test]
fn a_state_that_cannot_be_computed_is_not_hidden() {
    let folder = make_results().unwrap();
    std::fs::remove_file(folder.path().join("matrices/V_desks.mtx")).unwrap();
    let clear = scenes("office/bsdf/double_clear.xml");
    let (mut window, mut app) = open(&[folder.path()], None);
    app.open(&clear);
    app.views.year.quantity = crate::year::model::Quantity::Mean(0);
    window.settle(&mut app).unwrap();
    assert!(shows(&window, "the façade as computed: its other state cannot be computed"), "{:?}", window.texts());
    assert!(shows(&window, "V_desks.mtx"), "{:?}", window.texts());
}

#[test]
fn of_many_hours_at_dgp_1_the_brightest_is_the_worst_and_the_next_follow() {
    let folder = make_results().unwrap();
    let lines: String = [(3000, 21_300), (3001, 34_035), (3002, 30_000), (3003, 25_000)]
        .map(|(hour, ev)| {
            format!(
                "{hour},{},0,{ev},1,{}\n",
                if hour == 3003 { 0.45 } else { 1.0 },
                if hour == 3003 { "disturbing" } else { "intolerable" }
            )
        })
        .concat();
    std::fs::write(folder.path().join("glare/desk.csv"), format!("hour,dgp,dgp_standard_error,ev_lux,sources,class\n{lines}")).unwrap();
    let (mut window, mut app) = open(&[folder.path()], None);
    assert!(shows(&window, "no light; 3 hours at DGP 1.000, in order of Ev"), "{:?}", window.texts());
    let mut go = |key: Key| {
        window.key(&mut app, key, Modifiers::NONE);
        app.views.year.hour
    };
    assert_eq!(go(Key::W), 3001);
    assert_eq!([go(Key::N), go(Key::N), go(Key::N), go(Key::N)], [3002, 3000, 3003, 3003]);
    window.frame(&mut app);
    assert!(shows(&window, "DGP 0.450, disturbing") && shows(&window, "4 of 4;"), "{:?}", window.texts());
    let mut go = |key: Key| {
        window.key(&mut app, key, Modifiers::NONE);
        app.views.year.hour
    };
    assert_eq!(go(Key::P), 3000);
    assert_eq!([go(Key::Home), go(Key::M)], [0, 3001]);
    let next = place(&window, "Next").center();
    window.click(&mut app, next);
    assert_eq!(app.views.year.hour, 3002);
}

#[test]
fn a_picture_of_an_earlier_hour_is_called_so() {
    let (mut window, mut app) = open(&[results()], None);
    for hour in [1000, 1500, 2000, 2500, 3000] {
        app.views.year.hour = hour;
        window.frame(&mut app);
        assert_eq!(shows(&window, "picture of "), !app.shows_hour(hour), "{:?}", window.texts());
    }
    window.settle(&mut app).unwrap();
    assert!(!shows(&window, "picture of "));
}

#[test]
fn what_is_typed_into_a_field_is_no_shortcut() {
    let (mut window, mut app) = open(&[results()], None);
    let before = app.views.clone();
    let path = "wmlnp 3?/out";
    // The first letters come before the field is there.
    window.send(eframe::egui::Event::Key { key: Key::O, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::COMMAND });
    window.write(&mut app, "w");
    window.write(&mut app, path);
    assert_eq!(app.path_field.as_deref(), Some(format!("w{path}").as_str()));
    window.key(&mut app, Key::Num2, Modifiers::COMMAND);
    window.key(&mut app, Key::ArrowDown, Modifiers::NONE);
    assert!(app.views == before && !app.help, "nothing has changed");
    window.key(&mut app, Key::Escape, Modifiers::NONE);
    window.frame(&mut app);
    assert_eq!(app.path_field, None);
    // The field for another state of the façade.
    let field = place(&window, "another state: BSDF file").center();
    window.click(&mut app, field);
    window.write(&mut app, path);
    window.frame(&mut app);
    assert!(shows(&window, path), "{:?} {:?}", window.ctx().memory(|m| m.focused()), window.texts());
    window.key(&mut app, Key::Z, Modifiers::COMMAND);
    window.key(&mut app, Key::D, Modifiers::COMMAND);
    assert!(app.views == before && !app.help && !window.ctx().global_style().visuals.dark_mode, "nothing has changed");
}

#[test]
fn keys_stay_in_an_open_list() {
    let (mut window, mut app) = open(&[results()], None);
    let hour = app.views.year.hour;
    let list = place(&window, "Daylight glare probability of desk").center();
    window.click(&mut app, list);
    assert!(shows(&window, "Mean illuminance of desks"), "the list is open: {:?}", window.texts());
    for (key, quantity) in [
        (Key::ArrowDown, "Glare class of desk"),
        (Key::ArrowDown, "Mean illuminance of desks"),
        (Key::ArrowUp, "Glare class of desk"),
        (Key::End, "Illuminance at desks 6"),
        (Key::W, "Illuminance at desks 6"),
    ] {
        window.key(&mut app, key, Modifiers::NONE);
        let results = app.results.clone().unwrap();
        assert_eq!((app.views.year.quantity.name(&results), app.views.year.hour), (quantity.to_string(), hour), "{key:?}");
    }
    window.key(&mut app, Key::Enter, Modifiers::NONE);
    window.frame(&mut app);
    window.key(&mut app, Key::ArrowDown, Modifiers::NONE);
    assert_eq!(app.views.year.hour, hour + 24, "the list is closed");
}

#[test]
fn size_and_scale_of_the_command_line_count_more_than_those_of_last_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("viewer.json");
    let last = crate::remember::Remembered { zoom: 1.5, window: Some([900.0, 700.0]), ..Default::default() };
    last.write(&file);
    let start = |args: Args| {
        let mut window = Offscreen::new([800, 600], 1.0);
        let mut app = App::new(window.ctx(), &args, Some(file.clone()));
        window.frame(&mut app);
        app.fit_window(window.ctx());
        window.frame(&mut app);
        (window.ctx().zoom_factor(), window.commands())
    };
    let (zoom, commands) = start(Args { size: Some(crate::args::Size([1000, 500])), scale: Some(2.0), ..Args::default() });
    assert_eq!(zoom, 2.0);
    let points = eframe::egui::vec2(500.0, 250.0);
    assert!(commands.contains(&eframe::egui::ViewportCommand::InnerSize(points)), "{commands:?}");
    let (zoom, commands) = start(Args::default());
    assert!(zoom == 1.5 && commands.is_empty(), "{zoom} {commands:?}");
}

#[test]
fn the_grid_panel_shows_metrics_and_values_under_the_pointer() {
    let (mut window, mut app) = open(&[results()], Some(PanelKind::Grid));
    let choice = place(&window, "Illuminance of the hour").center();
    window.click(&mut app, choice);
    window.settle(&mut app).unwrap();
    let hour = app.views.year.hour;
    let text = lucarne::image::palette::rounded_number(f64::from(lux(5, hour)));
    let cell = place(&window, &text).center();
    window.point(&mut app, cell);
    assert!(shows(&window, &format!("desks 6   x 2.00  y 1.00  z 0.80 m   {text} lx")), "{:?}", window.texts());
}

#[test]
fn wrong_files_are_messages_inside_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.xml");
    std::fs::write(&bad, "<WindowElement><not closed").unwrap();
    let text = folder.path().join("notes.txt");
    std::fs::write(&text, "hello").unwrap();
    let broken = folder.path().join("broken.hdr");
    std::fs::write(&broken, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9 +X 9\nxx").unwrap();
    for (path, part) in [
        (bad, "bad.xml"),
        (text, "cannot be shown"),
        (broken, "broken.hdr"),
        (folder.path().to_path_buf(), "summary.json"),
        ("/nowhere.hdr".into(), "nowhere.hdr"),
    ] {
        let (mut window, mut app) = open(&[&path], None);
        assert!(shows(&window, part), "{part}: {:?}", window.texts());
        window.key(&mut app, Key::Escape, Modifiers::NONE);
        window.frame(&mut app);
        assert!(!shows(&window, part), "Esc closes messages");
    }
}

#[test]
fn empty_panels_say_what_to_do() {
    for panel in PanelKind::ALL {
        let (window, _) = open(&[], Some(panel));
        assert!(shows(&window, "Ctrl+O"), "{panel:?}");
    }
}

#[test]
fn a_picture_is_read_under_the_pointer_and_judged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spot.hdr");
    let mut pixels = vec![[1.0f32; 3]; 100 * 100];
    for y in 40..50 {
        pixels[y * 100 + 60..y * 100 + 70].fill([100.0; 3]);
    }
    let mut picture = lucarne::image::Picture::new(100, 100, pixels).unwrap();
    picture.view = Some("-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180".into());
    lucarne::image::hdr::write(&path, &picture).unwrap();
    let (mut window, mut app) = open(&[&path], None);
    assert_eq!(app.views.panel, PanelKind::Picture);
    // The spot is source 1, and its number stands in its middle.
    let number = window.texts().iter().rfind(|(t, _)| t == "1").unwrap().1.center();
    window.point(&mut app, number);
    assert!(shows(&window, "source 1: 17"), "{:?}", window.texts());
    // RGBE keeps 100 exactly.
    assert!(shows(&window, "17900 cd/m²"), "{:?}", window.texts());
    window.key(&mut app, Key::P, Modifiers::NONE);
    window.point(&mut app, number - eframe::egui::vec2(200.0, 0.0));
    window.button(&mut app, number - eframe::egui::vec2(200.0, 0.0), true);
    window.point(&mut app, number);
    window.point(&mut app, number + eframe::egui::vec2(100.0, 0.0));
    window.button(&mut app, number + eframe::egui::vec2(100.0, 0.0), false);
    window.frame(&mut app);
    assert!(shows(&window, "Profile from A to B"), "{:?}", window.texts());
}

/// Processor time of this process so far (Linux).
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let words: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    // Ticks of a hundredth of a second: user, then system.
    [11, 12].iter().filter_map(|i| words.get(*i)?.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Scrubs through a real result folder, named by LUCARNE_VIEWER_RESULTS, and says how fast.
#[test]
#[ignore = "measures; needs a result folder with a view"]
fn scrubbing_speed() {
    let folder = PathBuf::from(std::env::var_os("LUCARNE_VIEWER_RESULTS").expect("LUCARNE_VIEWER_RESULTS names a result folder"));
    let start = std::time::Instant::now();
    let mut window = Offscreen::new([1280, 800], 1.0);
    let args = Args { files: vec![folder], panel: Some(PanelKind::Year), screenshot: Some("none".into()), ..Args::default() };
    let mut app = App::new(window.ctx(), &args, None);
    while app.seconds_of_picture() == 0.0 && app.first_error().is_none() {
        window.frame(&mut app);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let (first, cpu) = (start.elapsed(), cpu_seconds());
    println!("first picture after {first:.2?} and {cpu:.2} s of processor time");
    window.settle(&mut app).unwrap();
    let whole = start.elapsed();
    window.pixels().unwrap();
    let cpu = cpu_seconds();
    let start = std::time::Instant::now();
    let (frames, mut pictures) = (40, 0.0);
    for k in 0..frames {
        app.views.year.hour = 1900 + k;
        window.frame(&mut app);
        while !app.shows_hour(1900 + k) {
            std::thread::sleep(std::time::Duration::from_millis(1));
            window.frame(&mut app);
        }
        pictures += app.seconds_of_picture();
        window.pixels().unwrap();
    }
    let rate = f64::from(frames as u32) / start.elapsed().as_secs_f64();
    let cpu = (cpu_seconds() - cpu) / f64::from(frames as u32);
    println!("{:.1} ms of processor time per frame: {:.1} frames/s on two idle cores", 1e3 * cpu, 2.0 / cpu);
    println!(
        "settled after {whole:.2?}; {rate:.1} frames/s, of which the product takes {:.1} ms",
        1e3 * pictures / f64::from(frames as u32)
    );
}

/// Share of 8 × 8 blocks whose mean colour differs visibly: text that moves by a fraction of a pixel
/// does not count, a colour or a shape that changes does.
fn differing(a: &[u8], b: &[u8], [w, h]: [usize; 2]) -> f64 {
    const BLOCK: usize = 8;
    let mean = |p: &[u8], x0: usize, y0: usize, c: usize| {
        let sum: u32 =
            (y0..y0 + BLOCK).flat_map(|y| (x0..x0 + BLOCK).map(move |x| (x, y))).map(|(x, y)| u32::from(p[(y * w + x) * 3 + c])).sum();
        f64::from(sum) / (BLOCK * BLOCK) as f64
    };
    let blocks: Vec<(usize, usize)> = (0..h / BLOCK).flat_map(|y| (0..w / BLOCK).map(move |x| (x * BLOCK, y * BLOCK))).collect();
    let different = blocks.iter().filter(|(x, y)| (0..3).any(|c| (mean(a, *x, *y, c) - mean(b, *x, *y, c)).abs() > 12.0)).count();
    different as f64 / blocks.len() as f64
}

/// Compares with `scenes/pictures/viewer_NAME.png`; LUCARNE_UPDATE_SNAPSHOTS=1 writes it.
fn snapshot(name: &str, files: &[&Path], panel: PanelKind, dark: bool) {
    if crate::testing::device(lucarne::gpu::Device::shared(), &format!("snapshot {name}")).is_none() {
        return;
    }
    let size = [960u32, 640];
    let mut window = Offscreen::new(size, 1.0);
    let theme = Some(if dark { crate::args::ThemeChoice::Dark } else { crate::args::ThemeChoice::Light });
    let files = files.iter().map(|f| f.to_path_buf()).collect();
    let args = Args { files, panel: Some(panel), theme, hour: (panel == PanelKind::Year).then_some(1931), ..Args::default() };
    let mut app = App::new(window.ctx(), &args, None);
    window.settle(&mut app).unwrap();
    let rgba = window.pixels().unwrap();
    let path = scenes(&format!("pictures/viewer_{name}.png"));
    if std::env::var_os("LUCARNE_UPDATE_SNAPSHOTS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        crate::offscreen::write_png(&path, size, &rgba).unwrap();
        return;
    }
    let mut reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut wanted = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut wanted).unwrap();
    let found: Vec<u8> = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let share = differing(&found, &wanted, size.map(|n| n as usize));
    if share > 0.006 {
        let now = std::env::temp_dir().join(format!("viewer_{name}.png"));
        crate::offscreen::write_png(&now, size, &rgba).unwrap();
        panic!("{:.2} % of '{name}' look different now; see {}", share * 100.0, now.display());
    }
}

#[test]
fn every_panel_looks_as_it_did() {
    snapshot("bsdf", &[&scenes("office/bsdf/blind.xml"), &scenes("office/bsdf/double_clear.xml")], PanelKind::Bsdf, true);
    snapshot("year", &[results()], PanelKind::Year, false);
    snapshot("grid", &[results()], PanelKind::Grid, true);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spot.hdr");
    let pixels = (0..120 * 120)
        .map(|i| {
            let (x, y) = (i % 120, i / 120);
            if (50..70).contains(&x) && (40..52).contains(&y) { [60.0; 3] } else { [0.2 + x as f32 * 0.05, 2.0, 3.0] }
        })
        .collect();
    let mut picture = lucarne::image::Picture::new(120, 120, pixels).unwrap();
    picture.view = Some("-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180".into());
    lucarne::image::hdr::write(&path, &picture).unwrap();
    snapshot("picture", &[&path], PanelKind::Picture, false);
}

#[test]
fn a_changed_picture_is_noticed() {
    let (w, h) = (64, 64);
    let white = vec![255u8; w * h * 3];
    let mut other = white.clone();
    for y in 8..24 {
        other[(y * w + 8) * 3..(y * w + 24) * 3].fill(180);
    }
    assert_eq!(differing(&white, &white, [w, h]), 0.0);
    assert_eq!(differing(&white, &other, [w, h]), 4.0 / 64.0);
}

#[test]
fn hemispheres_are_saved_as_png_and_svg() {
    let folder = tempfile::tempdir().unwrap();
    let file = crate::bsdf::model::BsdfFile::read(&scenes("office/bsdf/blind.xml")).unwrap();
    let (png, svg) = (folder.path().join("a.png"), folder.path().join("a.svg"));
    for path in [&png, &svg] {
        crate::bsdf::export::write(&[&file, &file], &Default::default(), path).unwrap();
    }
    assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    let text = std::fs::read_to_string(&svg).unwrap();
    assert!(text.contains("Transmission Front") && text.contains("blind.xml"), "titles are in the drawing");
    assert!(crate::bsdf::export::write(&[], &Default::default(), &png).is_err());
}
