//! `lucarne devices`: the GPU devices of this machine, the preferred one first.

use lucarne::gpu::{self, AdapterSummary, Device};
use lucarne::{Error, Result, Warnings};
use std::process::ExitCode;

/// Options.
#[derive(clap::Args)]
pub struct Args {}

/// Lists the devices; with none, says what to install and fails.
pub fn run(_args: Args, _warnings: &mut Warnings) -> Result<ExitCode> {
    let devices = gpu::list();
    if devices.is_empty() {
        return Err(Error::new("this machine offers no Vulkan, Metal or DirectX 12 device").help(gpu::NO_DEVICE_HELP));
    }
    for (index, device) in devices.iter().enumerate() {
        // A driver that lists a device may still fail to open it, or stop long loops silently.
        let opened = Device::open(Some(&index.to_string()));
        let probe = match opened.as_ref().map_err(Clone::clone).and_then(Device::loop_limit) {
            Ok(None) => "no loop limit found".to_string(),
            Ok(Some(limit)) => format!("ends loops after {limit} iterations"),
            Err(error) => format!("cannot be used: {error}"),
        };
        print!("{}", describe(index, opened.as_ref().map_or(device, Device::summary), &probe));
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(index: usize, d: &AdapterSummary, probe: &str) -> String {
    let yes = |flag: bool| if flag { "yes" } else { "no" };
    let [low, high] = d.subgroup_sizes;
    let subgroup = match (d.subgroups, low == high) {
        (false, _) => "no".to_string(),
        (true, true) => format!("{low} lanes"),
        (true, false) => format!("{low} to {high} lanes"),
    };
    format!(
        "{index}  {} ({}, {})\n   driver {}\n   binding {}, buffer {}, workgroup memory {}, {} invocations per workgroup, {} workgroups per dimension\n   subgroups {subgroup}, f64 {}, int64 {}; {probe}\n",
        d.name,
        d.kind,
        d.backend,
        d.driver,
        size(d.max_binding_bytes),
        size(d.max_buffer_bytes),
        size(u64::from(d.workgroup_memory_bytes)),
        d.max_workgroup_size,
        d.max_workgroups,
        yes(d.f64),
        yes(d.int64),
    )
}

/// Bytes in the largest binary unit that keeps at least one digit before the point.
fn size(bytes: u64) -> String {
    let (value, unit) = match bytes {
        b if b >= 1 << 40 => (b as f64 / (1u64 << 40) as f64, "TiB"),
        b if b >= 1 << 30 => (b as f64 / (1u64 << 30) as f64, "GiB"),
        b if b >= 1 << 20 => (b as f64 / (1u64 << 20) as f64, "MiB"),
        b => (b as f64 / 1024.0, "KiB"),
    };
    if value.fract() == 0.0 { format!("{value} {unit}") } else { format!("{value:.1} {unit}") }
}
