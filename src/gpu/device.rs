//! Choice of adapter and the open device.

use crate::error::{Error, Result};
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// What to tell a user whose machine has no device.
pub const NO_DEVICE_HELP: &str = "install a Vulkan driver: the graphics card's own, or 'apt-get install mesa-vulkan-drivers' on Debian and Ubuntu \
     (Mesa's lavapipe in it runs on any CPU); 'lucarne devices' then lists it";

/// Kind of device, best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A graphics card with memory of its own.
    Discrete,
    /// Part of the processor.
    Integrated,
    /// A share of a card in a virtual machine, or of unknown kind.
    Other,
    /// Software on the CPU, such as lavapipe.
    Cpu,
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            DeviceKind::Discrete => "discrete",
            DeviceKind::Integrated => "integrated",
            DeviceKind::Other => "other",
            DeviceKind::Cpu => "CPU",
        })
    }
}

/// A device of this machine, with the limits that matter.
#[derive(Debug, Clone)]
pub struct AdapterSummary {
    /// Name the driver gives.
    pub name: String,
    /// Kind.
    pub kind: DeviceKind,
    /// Programming interface: Vulkan, Metal or Dx12.
    pub backend: String,
    /// Driver and its version.
    pub driver: String,
    /// Largest part of a buffer that a kernel sees, bytes.
    pub max_binding_bytes: u64,
    /// Largest buffer, bytes.
    pub max_buffer_bytes: u64,
    /// Memory shared by a workgroup, bytes.
    pub workgroup_memory_bytes: u32,
    /// Invocations per workgroup.
    pub max_workgroup_size: u32,
    /// Workgroups per dimension of a dispatch.
    pub max_workgroups: u32,
    /// Smallest and largest number of invocations that run in lockstep.
    pub subgroup_sizes: [u32; 2],
    /// Whether kernels may exchange values inside a subgroup.
    pub subgroups: bool,
    /// Whether kernels may use f64.
    pub f64: bool,
    /// Whether kernels may use 64-bit integers.
    pub int64: bool,
}

impl AdapterSummary {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let (info, limits, features) = (adapter.get_info(), adapter.limits(), adapter.features());
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => DeviceKind::Discrete,
            wgpu::DeviceType::IntegratedGpu => DeviceKind::Integrated,
            wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => DeviceKind::Other,
            wgpu::DeviceType::Cpu => DeviceKind::Cpu,
        };
        let mut summary = Self {
            name: info.name,
            kind,
            backend: format!("{:?}", info.backend),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
            max_binding_bytes: 0,
            max_buffer_bytes: 0,
            workgroup_memory_bytes: 0,
            max_workgroup_size: 0,
            max_workgroups: 0,
            subgroup_sizes: [info.subgroup_min_size, info.subgroup_max_size],
            subgroups: false,
            f64: false,
            int64: false,
        };
        summary.restrict(&limits, features);
        summary
    }

    /// Says these limits and features.
    fn restrict(&mut self, limits: &wgpu::Limits, features: wgpu::Features) {
        self.max_binding_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        self.max_buffer_bytes = limits.max_buffer_size;
        self.workgroup_memory_bytes = limits.max_compute_workgroup_storage_size;
        self.max_workgroup_size = limits.max_compute_invocations_per_workgroup;
        self.max_workgroups = limits.max_compute_workgroups_per_dimension;
        self.subgroups = features.contains(wgpu::Features::SUBGROUP);
        self.f64 = features.contains(wgpu::Features::SHADER_F64);
        self.int64 = features.contains(wgpu::Features::SHADER_INT64);
    }

    /// Discrete before integrated before CPU; on a tie Vulkan first.
    fn rank(&self) -> (DeviceKind, bool) {
        (self.kind, self.backend != "Vulkan")
    }
}

/// The devices of this machine in order of preference.
fn adapters() -> Vec<(AdapterSummary, wgpu::Adapter)> {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() });
    let found = pollster::block_on(instance.enumerate_adapters(backends));
    let mut all: Vec<_> = found.into_iter().map(|a| (AdapterSummary::of(&a), a)).collect();
    all.sort_by_key(|(summary, _)| summary.rank());
    all
}

/// Lists the devices of this machine, the preferred one first; the position is the index that
/// [`Device::open`] accepts. Empty if there is no driver.
pub fn list() -> Vec<AdapterSummary> {
    adapters().into_iter().map(|(summary, _)| summary).collect()
}

/// Finds the device a user means: an index of [`list`], or part of a name, kind or backend.
fn choose(all: &[AdapterSummary], choice: Option<&str>) -> Result<usize> {
    if all.is_empty() {
        return Err(Error::device("this machine offers no Vulkan, Metal or DirectX 12 device").help(NO_DEVICE_HELP));
    }
    let Some(choice) = choice.map(str::trim).filter(|c| !c.is_empty()) else {
        return Ok(0);
    };
    let wanted = choice.to_lowercase();
    let by_index = wanted.parse::<usize>().ok().filter(|i| *i < all.len());
    let matches = |text: &str| text.to_lowercase().contains(&wanted);
    let named = || {
        all.iter().position(|a| matches(&a.name)).or_else(|| all.iter().position(|a| matches(&a.kind.to_string()) || matches(&a.backend)))
    };
    by_index.or_else(named).ok_or_else(|| {
        let names: Vec<String> = all.iter().enumerate().map(|(i, a)| format!("{i} = {} ({})", a.name, a.kind)).collect();
        Error::new(format!("no device is called '{choice}'")).help(format!("give an index or part of a name: {}", names.join(", ")))
    })
}

/// The environment variable that says how much of a device may be used.
const LIMITS: &str = "LUCARNE_LIMITS";

/// Whether a device is held to WebGPU's default limits, with none of its special features: what every kernel
/// must do with.
fn is_capped(value: Option<&str>) -> Result<bool> {
    match value.map(str::trim) {
        None | Some("") => Ok(false),
        Some("webgpu") => Ok(true),
        Some(other) => Err(Error::new(format!("'{other}' names no limits of devices"))
            .field(LIMITS)
            .help("leave it out, which uses all that the device has, or write webgpu, which holds it to WebGPU's default limits")),
    }
}

/// An open device. Cheap to clone; may be used from several threads.
#[derive(Clone)]
pub struct Device(pub(super) Arc<Inner>);

pub(super) struct Inner {
    pub raw: wgpu::Device,
    pub queue: wgpu::Queue,
    pub summary: AdapterSummary,
    pub limits: wgpu::Limits,
    pub kernels: Mutex<HashMap<String, super::Kernel>>,
    pub loop_limit: OnceLock<Option<u32>>,
    /// Errors that no scope caught, reported by the next readback.
    pub stray_errors: Arc<Mutex<Vec<String>>>,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Device({}, {})", self.0.summary.name, self.0.summary.backend)
    }
}

impl Device {
    /// Opens a device: `choice` is an index of [`list`] or part of a name; without it the
    /// environment variable `LUCARNE_DEVICE` says it; else the first of discrete, integrated, CPU.
    /// All limits of the adapter are asked for; with `LUCARNE_LIMITS=webgpu` WebGPU's default limits, without
    /// 64-bit numbers and subgroups, which changes no result.
    ///
    /// # Errors
    /// No device at all (with what to install), none of that name (with the names there are), other limits than
    /// these, or the driver refuses.
    pub fn open(choice: Option<&str>) -> Result<Self> {
        let environment = std::env::var("LUCARNE_DEVICE").ok();
        let mut all = adapters();
        let summaries: Vec<AdapterSummary> = all.iter().map(|(s, _)| s.clone()).collect();
        let index = choose(&summaries, choice.or(environment.as_deref())).map_err(|e| match (choice, &environment) {
            (None, Some(_)) if !summaries.is_empty() => e.field("LUCARNE_DEVICE"),
            (Some(_), _) if !summaries.is_empty() => e.field("--device"),
            _ => e,
        })?;
        let (mut summary, adapter) = all.swap_remove(index);
        let capped = is_capped(std::env::var(LIMITS).ok().as_deref())?;
        let useful = wgpu::Features::SUBGROUP
            | wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::SHADER_F64
            | wgpu::Features::SHADER_INT64
            | wgpu::Features::SHADER_FLOAT32_ATOMIC;
        let own = adapter.limits();
        let limits = if capped { wgpu::Limits::default().or_worse_values_from(&own) } else { own };
        let features = if capped { wgpu::Features::empty() } else { adapter.features() & useful };
        summary.restrict(&limits, features);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("lucarne"),
            required_features: features,
            required_limits: limits.clone(),
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        };
        let (raw, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| Error::device(format!("the device '{}' cannot be opened: {e}", summary.name)).help(NO_DEVICE_HELP))?;
        let stray_errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&stray_errors);
        raw.on_uncaptured_error(Arc::new(move |e: wgpu::Error| sink.lock().unwrap_or_else(PoisonError::into_inner).push(e.to_string())));
        Ok(Self(Arc::new(Inner {
            raw,
            queue,
            summary,
            limits,
            kernels: Mutex::new(HashMap::new()),
            loop_limit: OnceLock::new(),
            stray_errors,
        })))
    }

    /// The process's default device, opened once as [`open`](Self::open) does without a choice.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn shared() -> Result<Self> {
        static SHARED: OnceLock<Result<Device>> = OnceLock::new();
        SHARED.get_or_init(|| Device::open(None)).clone()
    }

    /// What this device is.
    pub fn summary(&self) -> &AdapterSummary {
        &self.0.summary
    }

    /// All limits of the device.
    pub fn limits(&self) -> &wgpu::Limits {
        &self.0.limits
    }

    /// The subgroup size if it is one fixed number on this device and subgroup operations exist.
    pub(crate) fn subgroup_size(&self) -> Option<u32> {
        let [low, high] = self.0.summary.subgroup_sizes;
        (self.0.summary.subgroups && low == high && low > 1).then_some(low)
    }

    /// The underlying wgpu device, for the viewer and for what this layer does not cover.
    pub fn raw(&self) -> &wgpu::Device {
        &self.0.raw
    }

    /// The underlying wgpu queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.0.queue
    }

    /// Runs `create` with all errors of the device caught and turned into an [`Error`] about `what`.
    pub(super) fn guarded<T>(&self, what: &str, create: impl FnOnce() -> T) -> Result<T> {
        let memory = self.0.raw.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let internal = self.0.raw.push_error_scope(wgpu::ErrorFilter::Internal);
        let validation = self.0.raw.push_error_scope(wgpu::ErrorFilter::Validation);
        let created = create();
        // Scopes pop in reverse order.
        let caught = [pollster::block_on(validation.pop()), pollster::block_on(internal.pop()), pollster::block_on(memory.pop())];
        match caught.into_iter().flatten().next() {
            None => Ok(created),
            Some(wgpu::Error::OutOfMemory { .. }) => {
                Err(Error::device(format!("{what}: the device '{}' has not enough memory", self.0.summary.name))
                    .help("give a smaller --memory, close other programs, or choose another device with --device"))
            }
            Some(error) => Err(Error::device(format!("{what}: {}", flatten(&error)))),
        }
    }

    /// Waits until the device has finished everything submitted so far.
    ///
    /// # Errors
    /// The device was lost, or an earlier command failed.
    pub fn wait(&self) -> Result<()> {
        self.0
            .raw
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| Error::device(format!("waiting for the device '{}': {e}", self.0.summary.name)))?;
        self.stray_errors()
    }

    pub(super) fn stray_errors(&self) -> Result<()> {
        let mut strays = self.0.stray_errors.lock().unwrap_or_else(PoisonError::into_inner);
        if strays.is_empty() {
            return Ok(());
        }
        let text = strays.join("; ");
        strays.clear();
        Err(Error::device(format!("the device '{}' reports: {text}", self.0.summary.name)))
    }
}

/// An error with its causes in one line.
fn flatten(error: &wgpu::Error) -> String {
    let mut text = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(inner) = source {
        let inner_text = inner.to_string();
        if !text.contains(&inner_text) {
            text.push_str(": ");
            text.push_str(&inner_text);
        }
        source = inner.source();
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Device {
        /// The shared device for unit tests, or a skip of `what`.
        pub(crate) fn for_tests(what: &str) -> Option<Self> {
            crate::testing::device(Self::shared(), what)
        }
    }

    fn adapter(name: &str, kind: DeviceKind, backend: &str) -> AdapterSummary {
        AdapterSummary {
            name: name.into(),
            kind,
            backend: backend.into(),
            driver: String::new(),
            max_binding_bytes: 1,
            max_buffer_bytes: 1,
            workgroup_memory_bytes: 1,
            max_workgroup_size: 1,
            max_workgroups: 1,
            subgroup_sizes: [8, 8],
            subgroups: true,
            f64: true,
            int64: true,
        }
    }

    #[test]
    fn discrete_comes_before_integrated_before_cpu_and_vulkan_before_the_rest() {
        let mut all = [
            adapter("llvmpipe", DeviceKind::Cpu, "Vulkan"),
            adapter("Card", DeviceKind::Discrete, "Dx12"),
            adapter("Chip", DeviceKind::Integrated, "Vulkan"),
            adapter("Card", DeviceKind::Discrete, "Vulkan"),
        ];
        all.sort_by_key(AdapterSummary::rank);
        let order: Vec<_> = all.iter().map(|a| (a.name.as_str(), a.backend.as_str())).collect();
        assert_eq!(order, [("Card", "Vulkan"), ("Card", "Dx12"), ("Chip", "Vulkan"), ("llvmpipe", "Vulkan")]);
        assert_eq!(choose(&all, None).unwrap(), 0);
        assert_eq!(choose(&all, Some("2")).unwrap(), 2);
        assert_eq!(choose(&all, Some("LLVM")).unwrap(), 3);
        assert_eq!(choose(&all, Some("cpu")).unwrap(), 3);
        assert_eq!(choose(&all, Some("dx12")).unwrap(), 1);
        assert!(choose(&all, Some("7")).unwrap_err().to_string().contains("0 = Card"));
        assert!(choose(&[], Some("x")).unwrap_err().to_string().contains("mesa-vulkan-drivers"));
    }

    #[test]
    fn only_known_limits_are_taken() {
        assert_eq!([None, Some(""), Some(" webgpu ")].map(|v| is_capped(v).unwrap()), [false, false, true]);
        let error = is_capped(Some("nonsense")).unwrap_err().to_string();
        assert!(error.contains("LUCARNE_LIMITS") && error.contains("'nonsense'") && error.contains("webgpu"), "{error}");
    }

    #[test]
    fn a_wrong_name_is_an_error_that_lists_the_devices() {
        if Device::for_tests("choice of device").is_some() {
            let error = Device::open(Some("no such device")).unwrap_err().to_string();
            assert!(error.starts_with("--device:") && error.contains("0 ="), "{error}");
        }
    }
}
