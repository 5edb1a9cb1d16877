//! Speed of the product beside numpy (OpenBLAS) in the same run: V (pixels × 145 × RGB) times
//! T·D·S (145 × hours × RGB), in GFLOP per CPU-second of the process (all its threads together), so
//! that other load on the machine does not count. On a device that is no software the wall clock
//! is the measure.
//!
//! `cargo bench --bench product [-- PIXELS HOURS]`

#[path = "record.rs"]
mod record;

use lucarne::gpu::Device;
use lucarne::kernels::product::{Arrangement, DeviceKernel, Multiplier, Native, OnDevice};
use std::process::Command;
use std::time::Instant;

const TERMS: usize = 145;
const REPEATS: usize = 3;

fn values(len: usize, seed: u32) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    (0..len).map(|_| next()).collect()
}

/// CPU time of this process in seconds (Linux), from its statistics in 1/100 s.
fn cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}

/// Median CPU and wall seconds of several runs.
fn measure(mut run: impl FnMut()) -> (f64, f64) {
    let mut times: Vec<(f64, f64)> = (0..REPEATS)
        .map(|_| {
            let (cpu, start) = (cpu_seconds(), Instant::now());
            run();
            let wall = start.elapsed().as_secs_f64();
            (cpu_seconds().zip(cpu).map_or(wall, |(after, before)| after - before), wall)
        })
        .collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    times[REPEATS / 2]
}

fn main() {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let pixels = numbers.first().copied().unwrap_or(160_000);
    let hours = numbers.get(1).copied().unwrap_or(256);
    let flops = 2.0 * (pixels * TERMS * hours * 3) as f64;
    println!("V {pixels} × {TERMS} × RGB times {TERMS} × {hours} × RGB: {:.1} GFLOP, median of {REPEATS}", flops / 1e9);
    let (v, s) = (values(pixels * TERMS * 3, 1), values(TERMS * hours * 3, 2));
    let mut product = vec![0.0; pixels * hours * 3];
    let mut multipliers: Vec<Box<dyn Multiplier>> = vec![Box::new(Native)];
    if let Ok(device) = Device::open(None) {
        for kernel in [DeviceKernel::Subgroup, DeviceKernel::Tiled] {
            multipliers.extend(OnDevice::with_kernel(&device, kernel).map(|m| Box::new(m) as Box<dyn Multiplier>));
        }
    }
    let mut record = record::Record::new("product");
    let (mut best, mut native) = (0.0f64, 0.0f64);
    for multiplier in multipliers {
        let mut factors = None;
        let mut prepare = || {
            let left = multiplier.left(pixels, TERMS, 3, (&v[..]).into()).expect("left factor");
            factors = Some((left, multiplier.right(TERMS, hours, 3, (&s[..]).into()).expect("right factor")));
        };
        prepare();
        let prepared = measure(&mut prepare);
        let (left, right) = factors.expect("prepared");
        for arrangement in [Arrangement::Rows, Arrangement::Columns] {
            let mut run = || multiplier.multiply(&left, &right, 0, hours, arrangement, &mut product).expect("product");
            run();
            let (cpu, wall) = measure(run);
            let rate = flops / cpu / 1e9;
            best = best.max(rate);
            // The first of all.
            native = if native == 0.0 { rate } else { native };
            record.add(format!("{} ({arrangement:?})", multiplier.description()), rate, "GFLOP/CPU-s");
            println!(
                "{:>7.1} GFLOP per CPU-second, {:>7.1} per second   {} ({arrangement:?}); factors made ready in {:.2} CPU-seconds",
                flops / cpu / 1e9,
                flops / wall / 1e9,
                multiplier.description(),
                prepared.0
            );
        }
    }
    let script = format!(
        "import numpy,time\nr=numpy.random.default_rng(1)\n\
         v=r.random((3,{pixels},{TERMS}),dtype='f4');s=r.random((3,{TERMS},{hours}),dtype='f4');o=numpy.empty((3,{pixels},{hours}),'f4')\n\
         numpy.matmul(v,s,out=o);t=[]\n\
         for _ in range({REPEATS}):\n c=time.process_time();w=time.perf_counter();numpy.matmul(v,s,out=o);t.append((time.process_time()-c,time.perf_counter()-w))\n\
         c,w=sorted(t)[{REPEATS}//2];print('%7.1f GFLOP per CPU-second, %7.1f per second   numpy %s'%({flops}/c/1e9,{flops}/w/1e9,numpy.__version__))"
    );
    match Command::new("python3").args(["-c", &script]).output() {
        Ok(out) if out.status.success() => {
            let text = String::from_utf8_lossy(&out.stdout);
            print!("{text}");
            if let Some(numpy) = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok()) {
                record.add("numpy", numpy, "GFLOP/CPU-s");
                record.add("best / numpy", best / numpy, "ratio");
                if numbers.is_empty() {
                    record::measured("product", &format!("native {native:.0}, numpy {numpy:.0}"), "");
                }
            }
        }
        _ => println!("SKIPPED numpy: python3 with numpy is not installed"),
    }
    record.finish();
}
