//! Rooms whose windows are shaded in parts: `parts = "auto"` against light that is followed without V and D.

use super::super::look::truth;
use super::super::*;
use super::{CLEAR, FINS, NEIGHBOUR, OVERHANG, REVEAL, SHELF, means, planned, room};
use crate::error::Warnings;
use crate::gpu::Device;
use crate::progress::Silent;
use std::time::Instant;

/// Rooms, and whether their windows are also computed in parts, of which some take half a minute.
const ROOMS: [(&str, &str, bool); 5] = [
    ("reveal", REVEAL, true),
    ("overhang", OVERHANG, false),
    ("fins", FINS, false),
    ("shelf", SHELF, false),
    ("neighbour", NEIGHBOUR, true),
];

/// Errors of each sensor's mean, and the standard error of each.
struct Found {
    errors: Vec<f64>,
    noise: Vec<f64>,
    rays: u64,
    seconds: f64,
    division: Division,
}

impl Found {
    fn tell(&self, what: &str) {
        let errors = self.errors.iter().map(|e| format!("{:+.2}", 100.0 * e)).collect::<Vec<_>>().join(" ");
        println!("  {what} ({:?}): {errors} %; {:.1} s, {} M rays", self.division.grid, self.seconds, self.rays / 1_000_000);
    }

    fn worst(&self) -> f64 {
        self.errors.iter().fold(0.0, |a, e| a.max(e.abs()))
    }
}

fn found(device: &Device, folder: &std::path::Path, around: &str, parts: toml::Value, wanted: &[[f64; 2]]) -> Found {
    let out = folder.join(format!("out_{}", parts.to_string().replace(['"', ' '], "")));
    let plan = planned(room(folder, around, CLEAR, parts).set("quality", "preset", "draft"));
    let clock = Instant::now();
    let summary = plan.write(device, &out, &Silent, &mut Warnings::new()).unwrap();
    let error = summary.estimated_error.unwrap().annual_largest;
    let means = means(&out);
    Found {
        errors: means.iter().zip(wanted).map(|(m, [w, _])| m / w - 1.0).collect(),
        noise: wanted.iter().map(|[w, e]| (e / w).hypot(error)).collect(),
        rays: summary.rays,
        seconds: clock.elapsed().as_secs_f64(),
        division: summary.windows[0].parts.clone(),
    }
}

/// The error that the look foretells, and that which is there; the error with the parts that it chooses.
#[test]
fn parts_that_a_look_chooses_take_away_the_error_of_averages() {
    let Some(device) = Device::for_tests("windows in parts") else { return };
    let [mut of_wholes, mut left, mut told] = [0.0f64, 0.0, 0.0];
    for (name, around, divided) in ROOMS {
        let folder = tempfile::tempdir().unwrap();
        let plan = planned(room(folder.path(), around, CLEAR, 1));
        let clock = Instant::now();
        let foretold = errors_of_wholes(&plan.project, &plan.inputs).into_iter().flatten().fold(0.0, f64::max);
        let look = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let samples = truth::Samples { batches: 16, direct: 4096, paths: 2048, points: 1 };
        let wanted = truth::light(&plan.project, &plan.inputs, &plan.inputs.all_sensors(), samples);
        let truth = clock.elapsed().as_secs_f64();
        let whole = found(&device, folder.path(), around, toml::Value::Integer(1), &wanted);
        let percents = |v: &[f64]| v.iter().map(|e| format!("{:+.2}", 100.0 * e)).collect::<Vec<_>>().join(" ");
        println!("{name}: look {look:.2} s, truth {truth:.1} s, foretold {:.1} %", 100.0 * foretold);
        whole.tell("whole");
        if divided {
            let auto = found(&device, folder.path(), around, toml::Value::String("auto".into()), &wanted);
            auto.tell(&auto.division.because);
            println!("  noise {} %", percents(&auto.noise));
            for (error, noise) in auto.errors.iter().zip(&auto.noise) {
                assert!(error.abs() < 0.01 + 2.0 * noise, "{name}: {error} ± {noise}");
            }
            assert!(auto.worst() < whole.worst() / 3.0, "{name}");
            left = left.max(auto.worst());
        }
        // What the look foretells of the whole is there.
        let noise = whole.noise.iter().copied().fold(0.0, f64::max);
        assert!(
            (foretold - whole.worst()).abs() < 0.01 + 0.2 * foretold + 2.0 * noise,
            "{name}: foretold {foretold}, found {}",
            whole.worst()
        );
        of_wholes = of_wholes.max(whole.worst());
        told = told.max((foretold - whole.worst()).abs());
    }
    let percent = crate::testing::percent;
    crate::testing::measured(
        "parts-auto",
        &format!("{} (whole windows: {})", percent(left), percent(of_wholes)),
        "1 % + 2 standard errors",
    );
    crate::testing::measured("parts-look", &format!("within {}", percent(told)), "1 % + a fifth + 2 standard errors");
    assert!(of_wholes > 0.03, "the rooms tell whole windows from divided ones: {of_wholes}");
}
