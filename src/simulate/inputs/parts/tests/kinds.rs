//! Everything that a run computes, of windows in parts.

use super::{CLEAR, REVEAL, means, planned, room};
use crate::bins::ReinhartSky;
use crate::error::Warnings;
use crate::gpu::Device;
use crate::kernels::daylight_matrix::{DaylightOptions, compute, compute_of_parts};
use crate::kernels::product::Native;
use crate::kernels::trace::rooms::street;
use crate::progress::Silent;
use crate::simulate::Plan;
use crate::simulate::project::Filling;
use crate::simulate::year::Year;
use crate::simulate::year::facade::{Facade, FacadeState};

#[test]
fn d_of_the_parts_averages_to_that_of_the_window() {
    let Some(device) = Device::for_tests("D of parts") else { return };
    let (scene, window) = street();
    let sky = ReinhartSky::new(1).unwrap();
    let options = DaylightOptions { paths: 1024, ..DaylightOptions::default() };
    let parts = window.in_parts([2, 2]);
    let whole = compute(&device, &scene, &window, sky, &DaylightOptions { paths: 4096, seed: 5, ..options }, &Silent).unwrap();
    let of_parts = compute_of_parts(&device, &scene, &parts, sky, &options, &Silent).unwrap();
    let bins = window.basis.len();
    assert_eq!((of_parts.total.rows(), of_parts.total.cols()), (4 * bins, sky.len()));
    let [mut squares, mut count, mut apart] = [0.0; 3];
    for (bin, patch) in (0..bins).flat_map(|b| (0..sky.len()).map(move |p| (b, p))) {
        let at = |part: usize| f64::from(of_parts.total.at(part * bins + bin, patch)[0]);
        let error = |part: usize| f64::from(of_parts.standard_error.at(part * bins + bin, patch)[0]);
        let own: Vec<f64> = (0..4).map(at).collect();
        let variance = (0..4).map(|p| error(p).powi(2)).sum::<f64>() / 16.0 + f64::from(whole.standard_error.at(bin, patch)[0]).powi(2);
        let mean = own.iter().sum::<f64>() / 4.0;
        if variance > 0.0 && mean > 0.002 {
            squares += (mean - f64::from(whole.total.at(bin, patch)[0])).powi(2) / variance;
            count += 1.0;
            apart += f64::from(u8::from((own[0] - own[3]).abs() > 6.0 * error(0).hypot(error(3))));
        }
    }
    // Eight batches each: the mean of t² with some nine degrees of freedom is 1.3.
    println!("mean z² {:.2} of {count} entries, {apart} of which differ from part to part", squares / count);
    assert!(squares / count < 1.6 && count > 500.0 && apart > 20.0);
}

/// A post far before the window makes D one that is traced, but leaves it nearly the same for all parts: results of the
/// divided window are those of the whole but for noise, in all that a run computes.
#[test]
fn a_window_that_is_lit_evenly_gives_the_same_in_parts() {
    let Some(device) = Device::for_tests("all results of windows in parts") else { return };
    let post = "wall polygon post 0 0 12  20 -60 0  20.2 -60 0  20.2 -60 4  20 -60 4\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("v.vf"), "rvu -vta -vp 1.5 2.5 1.2 -vd 0 -1 0 -vh 180 -vv 180\n").unwrap();
    let run = |name: &str, parts: [usize; 2], phases: u32| -> Year {
        let builder = room(folder.path(), post, CLEAR, parts).set("method", "phases", phases).set("method", "sky_subdivision", 1);
        // Five phases: the sun through a pane in the opening.
        let shade = "void glass pane 0 0 3 .8 .8 .8\npane polygon p 0 0 12  0.5 0 1  0.5 0 2.4  2.5 0 2.4  2.5 0 1\n";
        std::fs::write(folder.path().join("shade.rad"), shade).unwrap();
        let builder = if phases == 5 { builder.set("window", "shade", "shade.rad").set("method", "suns", 1) } else { builder };
        let builder = builder.view("seat", "v.vf", [24, 24]).set("images", "hours", [490]).begin("glare");
        let plan = planned(builder);
        let out = folder.path().join(format!("{name}{phases}"));
        plan.write(&device, &out, &Silent, &mut Warnings::new()).unwrap();
        Year::open(&out).unwrap()
    };
    for phases in [3, 5] {
        let (whole, parts) = (run("whole", [1, 1], phases), run("parts", [2, 2], phases));
        assert_eq!((parts.summary.windows[0].bins, parts.summary.windows[0].parts.count), (4 * 145, 4));
        let relative = |a: f64, b: f64| a / b - 1.0;
        let lux: Vec<f64> = means(whole.folder()).iter().zip(means(parts.folder())).map(|(w, p)| relative(p, *w)).collect();
        let errors = |y: &Year| y.summary.estimated_error.unwrap().annual_largest;
        let noise = errors(&whole).hypot(errors(&parts));
        assert!(lux.iter().all(|d| d.abs() < 4.0 * noise), "{phases} phases: {lux:?}, noise {noise}");
        assert!(noise < 0.02, "{noise}");
        // The light behind the windows, made anew from the files, gives the same table.
        let facade = Facade::read(&parts).unwrap();
        let again = facade.illuminance(&parts, "room", &FacadeState::default(), &Native).unwrap();
        for (a, b) in again.data().iter().zip(parts.sensors[0].illuminance.data()) {
            assert!((a - b).abs() < 1e-3 * b.abs() + 0.02, "{a} {b}");
        }
        let mean = |y: &Year, step: usize| {
            let pixels = y.picture("seat", step).unwrap().pixels;
            pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / pixels.len() as f64
        };
        let step = 3;
        assert!(relative(mean(&parts, step), mean(&whole, step)).abs() < 0.02, "{} {}", mean(&parts, step), mean(&whole, step));
        let (p, w) = (&parts.glare[0], &whole.glare[0]);
        for hour in 0..p.dgp.len() {
            let noise = p.standard_error[hour].hypot(w.standard_error[hour]);
            assert!(
                (p.dgp[hour] - w.dgp[hour]).abs() < 4.0 * noise + 0.003,
                "{phases} phases: DGP {} {} ± {noise}",
                p.dgp[hour],
                w.dgp[hour]
            );
        }
        let sigma = |y: &Year| y.glare[0].standard_error.iter().sum::<f64>();
        let ratio = sigma(&parts) / sigma(&whole);
        assert!((0.5..2.0).contains(&ratio), "{phases} phases: stated errors of DGP differ by {ratio}");
    }
}

/// States of the façade share V and D of all parts; the light at the eye is that at a sensor in its place.
#[test]
fn states_of_a_divided_window_and_glare_without_pictures() {
    let Some(device) = Device::for_tests("states of windows in parts") else { return };
    let blind = CLEAR.replace("double_clear", "blind");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("v.vf"), "rvu -vta -vp 1.5 1.5 1.2 -vd 0 -1 0 -vh 180 -vv 180\n").unwrap();
    for method in ["dgps", "imageless", "edgps"] {
        let run = |states: &[&str]| -> Year {
            let builder = room(folder.path(), REVEAL, CLEAR, [4, 4]).view("seat", "v.vf", [16, 16]).set("glare", "method", method);
            let mut project = builder.build().unwrap();
            project.sensors.clear();
            project.windows[0].filling = Filling::Bsdf(states[0].into());
            if states.len() > 1 {
                project.give_states(0, &states.iter().map(Into::into).collect::<Vec<_>>());
            }
            let plan = Plan::new(project, &mut Warnings::new()).unwrap();
            let out = folder.path().join(format!("{method}{}{}", states.len(), states[0].len()));
            plan.write(&device, &out, &Silent, &mut Warnings::new()).unwrap();
            Year::open(&out).unwrap()
        };
        let both = run(&[CLEAR, &blind]);
        assert_eq!(both.glare.len(), 2);
        for (name, file) in [("double_clear", CLEAR), ("blind", &blind)] {
            let state = both.glare.iter().find(|g| g.state == name).unwrap();
            let alone = run(&[file]);
            assert_eq!((&state.dgp, &state.illuminance), (&alone.glare[0].dgp, &alone.glare[0].illuminance), "{method}");
            if method == "dgps" {
                // A sensor in the eye's place.
                let sensor = room(folder.path(), REVEAL, file, [4, 4]);
                std::fs::write(folder.path().join("points.txt"), "1.5 1.5 1.2 0 -1 0\n").unwrap();
                let out = folder.path().join(format!("sensor_{name}"));
                planned(sensor).write(&device, &out, &Silent, &mut Warnings::new()).unwrap();
                let (found, wanted) = (state.illuminance.iter().sum::<f64>() / state.illuminance.len() as f64, means(&out)[0]);
                println!("{name}: {found:.0} lx at the eye, {wanted:.0} at the sensor");
                assert!((found / wanted - 1.0).abs() < 0.02, "{found} {wanted}");
            }
        }
    }
}
