//! Kernels: from a shader file to a pipeline whose bindings are found by name.

use super::buffer::Buffer;
use super::device::{Device, Inner};
use super::link::{Linked, link};
use super::shader::Shader;
use crate::error::{Error, Result};
use std::fmt;
use std::sync::{Arc, PoisonError, Weak};

/// A compiled compute shader. Cheap to clone; one per (shader, constants) and device.
#[derive(Clone)]
pub(crate) struct Kernel(Arc<KernelInner>);

struct KernelInner {
    /// Weak, since the device itself keeps all its kernels.
    device: Weak<Inner>,
    label: String,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    bindings: Vec<Slot>,
}

/// A binding that the shader declares.
struct Slot {
    name: String,
    binding: u32,
    uniform: bool,
    read_only: bool,
}

impl fmt::Debug for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Kernel({})", self.0.label)
    }
}

/// Buffers bound to a kernel.
#[derive(Debug, Clone)]
pub(crate) struct BindGroup {
    raw: wgpu::BindGroup,
    kernel: String,
}

impl BindGroup {
    pub(super) fn raw(&self) -> &wgpu::BindGroup {
        &self.raw
    }

    /// Path of the shader whose bindings these are.
    pub(super) fn kernel(&self) -> &str {
        &self.kernel
    }
}

impl Kernel {
    /// The kernel of a shader with these values of its `override` constants (booleans as 0 and 1).
    /// Compiled once per device and values.
    ///
    /// # Errors
    /// Any fault in the shader, with file and line; unknown constants; refusal by the driver.
    pub fn new(device: &Device, shader: &Shader, constants: &[(&str, f64)]) -> Result<Self> {
        #[cfg(test)]
        if let Some(mutant) = super::mutation::linked(shader)? {
            return Self::compile(device, &mutant, constants);
        }
        let key = format!("{shader:?} {constants:?}");
        if let Some(kernel) = device.0.kernels.lock().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return Ok(kernel.clone());
        }
        let kernel = Self::compile(device, &link(shader)?, constants)?;
        device.0.kernels.lock().unwrap_or_else(PoisonError::into_inner).insert(key, kernel.clone());
        Ok(kernel)
    }

    fn compile(device: &Device, linked: &Linked, constants: &[(&str, f64)]) -> Result<Self> {
        let label = linked.path();
        let named = |e: Error| e.file(format!("shaders/{label}.wgsl"));
        let (module, _) = linked.validate()?;
        let [entry] = module.entry_points.as_slice() else {
            return Err(named(Error::new(format!("a kernel has one entry point, this one has {}", module.entry_points.len()))));
        };
        let overrides: Vec<&str> = module.overrides.iter().filter_map(|(_, o)| o.name.as_deref()).collect();
        if let Some((unknown, _)) = constants.iter().find(|(name, _)| !overrides.contains(name)) {
            return Err(named(
                Error::new(format!("there is no override constant '{unknown}'")).help(format!("known: {}", overrides.join(", "))),
            ));
        }
        let bindings = slots(&module).map_err(named)?;
        let entries: Vec<wgpu::BindGroupLayoutEntry> = bindings.iter().map(Slot::layout_entry).collect();
        let raw = device.raw();
        device
            .guarded(&format!("kernel '{label}'"), || {
                let layout = raw.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries });
                let pipeline_layout = raw.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some(label),
                    bind_group_layouts: &[Some(&layout)],
                    immediate_size: 0,
                });
                let shader = create_module(raw, label, linked.text());
                let pipeline = raw.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(label),
                    layout: Some(&pipeline_layout),
                    module: &shader,
                    entry_point: Some(&entry.name),
                    compilation_options: wgpu::PipelineCompilationOptions { constants, zero_initialize_workgroup_memory: false },
                    cache: None,
                });
                Self(Arc::new(KernelInner { device: Arc::downgrade(&device.0), label: label.to_string(), pipeline, layout, bindings }))
            })
            .map_err(named)
    }

    /// Path of its shader, as it appears in messages and GPU debuggers.
    pub fn label(&self) -> &str {
        &self.0.label
    }

    pub(super) fn pipeline(&self) -> &wgpu::ComputePipeline {
        &self.0.pipeline
    }

    /// Names of its bindings.
    #[cfg(test)]
    pub(crate) fn declared(&self) -> Vec<&str> {
        self.0.bindings.iter().map(|s| s.name.as_str()).collect()
    }

    /// Binds buffers to the names that the shader declares, all of them and no others.
    ///
    /// # Errors
    /// Missing, unknown or repeated names (with those the shader has), parts at unaligned offsets,
    /// bindings larger than the device allows.
    pub(crate) fn bind(&self, buffers: &[(&str, &Buffer)]) -> Result<BindGroup> {
        let inner = &*self.0;
        let device = Device(inner.device.upgrade().ok_or_else(|| Error::new("the device of this kernel was closed"))?);
        let fail = |message: String| Err(Error::new(format!("kernel '{}': {message}", inner.label)));
        let names = || inner.bindings.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
        if let Some((unknown, _)) = buffers.iter().find(|(name, _)| !inner.bindings.iter().any(|s| s.name == *name)) {
            return fail(format!("there is no binding '{unknown}'; there are: {}", names()));
        }
        let mut entries = Vec::with_capacity(buffers.len());
        for slot in &inner.bindings {
            let mut found = buffers.iter().filter(|(name, _)| *name == slot.name);
            let Some((_, buffer)) = found.next() else {
                return fail(format!("nothing is bound to '{}'; it binds: {}", slot.name, names()));
            };
            if found.next().is_some() {
                return fail(format!("'{}' is bound twice", slot.name));
            }
            let limits = device.limits();
            let (alignment, limit) = if slot.uniform {
                (limits.min_uniform_buffer_offset_alignment, limits.max_uniform_buffer_binding_size)
            } else {
                (limits.min_storage_buffer_offset_alignment, limits.max_storage_buffer_binding_size)
            };
            if buffer.offset() % u64::from(alignment) != 0 {
                return fail(format!(
                    "the part of '{}' bound to '{}' begins at no multiple of {alignment} bytes",
                    buffer.label(),
                    slot.name
                ));
            }
            if buffer.bytes() > limit {
                return fail(format!("'{}' has {} bytes; the device binds at most {limit} at once", buffer.label(), buffer.bytes()));
            }
            entries.push(wgpu::BindGroupEntry { binding: slot.binding, resource: wgpu::BindingResource::Buffer(buffer.binding()) });
        }
        let descriptor = wgpu::BindGroupDescriptor { label: Some(&inner.label), layout: &inner.layout, entries: &entries };
        let raw = device.guarded(&format!("bindings of kernel '{}'", inner.label), || device.raw().create_bind_group(&descriptor))?;
        Ok(BindGroup { raw, kernel: inner.label.clone() })
    }
}

/// Compiles WGSL without naga's loop counters: they would only turn an endless loop into a wrong
/// result.
#[allow(unsafe_code)]
fn create_module(raw: &wgpu::Device, label: &str, text: &str) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(label), source: wgpu::ShaderSource::Wgsl(text.into()) };
    let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
    // SAFETY: all checks of memory accesses stay on. Without loop bounding every loop must end,
    // which our own shaders (the only ones ever compiled here) do: each counts up to a bound.
    unsafe { raw.create_shader_module_trusted(descriptor, checks) }
}

/// The bindings a module declares, ordered by number.
fn slots(module: &naga::Module) -> Result<Vec<Slot>> {
    let mut slots = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(place) = &variable.binding else { continue };
        let name = variable.name.clone().unwrap_or_default();
        if place.group != 0 {
            return Err(Error::new(format!("'{name}' is in group {}; kernels use group 0 alone", place.group)));
        }
        let (uniform, read_only) = match variable.space {
            naga::AddressSpace::Uniform => (true, true),
            naga::AddressSpace::Storage { access } => (false, !access.contains(naga::StorageAccess::STORE)),
            other => return Err(Error::new(format!("'{name}' is in the address space {other:?}; kernels bind buffers alone"))),
        };
        slots.push(Slot { name, binding: place.binding, uniform, read_only });
    }
    slots.sort_by_key(|s| s.binding);
    if let Some(pair) = slots.windows(2).find(|w| w[0].binding == w[1].binding) {
        return Err(Error::new(format!("'{}' and '{}' share binding {}", pair[0].name, pair[1].name, pair[0].binding)));
    }
    Ok(slots)
}

impl Slot {
    fn layout_entry(&self) -> wgpu::BindGroupLayoutEntry {
        let ty =
            if self.uniform { wgpu::BufferBindingType::Uniform } else { wgpu::BufferBindingType::Storage { read_only: self.read_only } };
        wgpu::BindGroupLayoutEntry {
            binding: self.binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOUBLE: &str = "
        import package::generated::Params;
        override WIDTH: u32 = 64;
        @group(0) @binding(0) var<uniform> params: Params;
        @group(0) @binding(3) var<storage, read> source: array<f32>;
        @group(0) @binding(1) var<storage, read_write> result: array<f32>;
        @compute @workgroup_size(WIDTH)
        fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
            let i = (group.y * groups.x + group.x) * WIDTH + lane;
            if i < params.count { result[i] = params.factor * source[i]; }
        }";

    crate::gpu_struct! {
        struct Params {
            count: u32,
            factor: f32,
        }
    }

    const SHADER: Shader = Shader::of_text("t/double", &[&[Params::DECLARED]], DOUBLE);

    fn double(device: &Device) -> Kernel {
        Kernel::new(device, &SHADER, &[("WIDTH", 32.0)]).unwrap()
    }

    #[test]
    fn a_kernel_runs_with_bindings_by_name_also_on_parts_and_empty_buffers() {
        let Some(device) = Device::for_tests("kernels") else { return };
        let kernel = double(&device);
        let values: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        let source = device.upload("source", &values).unwrap();
        let result = device.upload("result", &[f32::NAN; 1000]).unwrap();
        let params = device.uniform("params", &Params { count: 1000, factor: 2.0 }).unwrap();
        let group = kernel.bind(&[("result", &result), ("params", &params), ("source", &source)]).unwrap();
        device.dispatch(&kernel, &group, device.grid(1000u64.div_ceil(32)).unwrap()).unwrap();
        assert_eq!(device.read_finite::<f32>(&result).unwrap(), values.iter().map(|v| 2.0 * v).collect::<Vec<_>>());

        // 64 values = 256 bytes into the buffer; twice in one submission, after clearing.
        let part = result.part::<f32>(64, 100).unwrap();
        let few = device.uniform("params", &Params { count: 100, factor: 3.0 }).unwrap();
        let group = kernel.bind(&[("result", &part), ("params", &few), ("source", &source)]).unwrap();
        let mut batch = device.batch("batch");
        batch.clear(&result);
        batch.dispatch(&kernel, &group, [4, 1, 1]).unwrap().dispatch(&kernel, &group, [0, 1, 1]).unwrap();
        let copied = device.zeros::<f32>("copied", 2).unwrap();
        batch.copy(&part.part::<f32>(1, 2).unwrap(), &copied).unwrap();
        batch.submit().unwrap();
        let got = device.read::<f32>(&result).unwrap();
        assert_eq!((got[63], got[64], got[65], got[163], got[164]), (0.0, 0.0, 3.0, 297.0, 0.0));
        assert_eq!(device.read::<f32>(&copied).unwrap(), [3.0, 6.0]);

        let empty = device.upload::<f32>("empty", &[]).unwrap();
        let none = device.uniform("params", &Params { count: 0, factor: 3.0 }).unwrap();
        let group = kernel.bind(&[("result", &empty), ("params", &none), ("source", &source)]).unwrap();
        device.dispatch(&kernel, &group, [1, 1, 1]).unwrap();
        device.wait().unwrap();
    }

    #[test]
    fn wrong_bindings_sizes_and_constants_are_errors_not_panics() {
        let Some(device) = Device::for_tests("kernel errors") else { return };
        let kernel = double(&device);
        let b = device.zeros::<f32>("b", 1000).unwrap();
        let p = device.uniform("p", &Params::default()).unwrap();
        let bad = |buffers: &[(&str, &Buffer)]| kernel.bind(buffers).unwrap_err().to_string();
        assert!(bad(&[("result", &b), ("params", &p)]).contains("nothing is bound to 'source'"));
        assert!(bad(&[("result", &b), ("params", &p), ("source", &b), ("extra", &b)]).contains("no binding 'extra'"));
        assert!(bad(&[("result", &b), ("params", &p), ("source", &b), ("source", &b)]).contains("bound twice"));
        assert!(bad(&[("result", &b.part::<f32>(1, 9).unwrap()), ("params", &p), ("source", &b)]).contains("no multiple of"));
        // A storage buffer where a uniform is wanted is caught by the device.
        assert!(bad(&[("result", &b), ("params", &b), ("source", &b)]).contains("t/double"));
        let c = device.zeros::<f32>("c", 1000).unwrap();
        let group = kernel.bind(&[("result", &b), ("params", &p), ("source", &c)]).unwrap();
        let limit = device.limits().max_compute_workgroups_per_dimension;
        assert!(device.dispatch(&kernel, &group, [limit + 1, 1, 1]).unwrap_err().to_string().contains("Device::grid"));
        let [x, y, _] = device.grid(u64::from(limit) * 3 + 1).unwrap();
        assert!(x <= limit && y <= limit && u64::from(x) * u64::from(y) > u64::from(limit) * 3);
        assert!(device.grid(u64::MAX).is_err());
        // Reading and writing the same memory in one dispatch.
        let group = kernel.bind(&[("result", &b), ("params", &p), ("source", &b)]).unwrap();
        assert!(device.dispatch(&kernel, &group, [1, 1, 1]).is_err());
        let make = |constants: &[(&str, f64)], text: &str| {
            let shader = Shader::of_text("t/x", &[&[Params::DECLARED]], text.to_string().leak());
            Kernel::new(&device, &shader, constants).unwrap_err().to_string()
        };
        assert!(make(&[("HEIGHT", 1.0)], DOUBLE).contains("no override constant 'HEIGHT'"));
        assert!(make(&[("WIDTH", 1e9)], DOUBLE).contains("t/x"));
        assert!(make(&[], "fn f() {}").contains("one entry point"));
        assert!(make(&[], &DOUBLE.replace("@group(0) @binding(3)", "@group(1) @binding(3)")).contains("group 0 alone"));
        assert!(make(&[], &DOUBLE.replace("factor *", "faktor *")).contains("shaders/t/x.wgsl:10"));
    }

    #[test]
    fn each_variant_is_compiled_once() {
        let Some(device) = Device::for_tests("kernel cache") else { return };
        assert!(Arc::ptr_eq(&double(&device).0, &double(&device).0));
        let other = Kernel::new(&device, &SHADER, &[("WIDTH", 64.0)]).unwrap();
        assert!(!Arc::ptr_eq(&double(&device).0, &other.0));
    }
}
