//! Every shader in use is linked and validated, and has the host's structs from the host.

use lucarne::gpu;
use naga::TypeInner;

#[test]
fn every_shader_links_and_validates_and_binds_no_struct_of_its_own() {
    let registered = lucarne::kernels::registered();
    assert!(!registered.is_empty(), "found no shaders");
    let mut faults = Vec::new();
    for shader in &registered {
        let module = match gpu::link(shader).and_then(|linked| linked.validate()) {
            Err(error) => {
                faults.push(format!("{}: {error}", shader.path()));
                continue;
            }
            Ok((module, _)) => module,
        };
        for (_, variable) in module.global_variables.iter().filter(|(_, v)| v.binding.is_some()) {
            let bound = match module.types[variable.ty].inner {
                TypeInner::Array { base, .. } => base,
                _ => variable.ty,
            };
            let bound = &module.types[bound];
            let name = bound.name.as_deref().unwrap_or_default();
            if matches!(bound.inner, TypeInner::Struct { .. }) && !shader.declared().any(|d| d.name == name) {
                faults.push(format!("{}: '{name}' is bound but not declared by gpu_struct!", shader.path()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The variants of a kernel that `override` constants make have the same bindings, memory and workgroups.
#[test]
fn every_kernel_keeps_within_the_default_limits_of_webgpu() {
    let limits = wgpu::Limits::default();
    assert_eq!((limits.max_storage_buffers_per_shader_stage, limits.max_compute_workgroup_storage_size), (8, 16384));
    let (mut faults, mut most_bound) = (Vec::new(), 0);
    for shader in lucarne::kernels::registered() {
        let linked = gpu::link(&shader).unwrap();
        let (module, _) = linked.validate().unwrap();
        let mut fault = |what: String| faults.push(format!("{}: {what}", shader.path()));
        let [entry] = module.entry_points.as_slice() else { panic!("{}: one entry point", shader.path()) };
        let size_of = |variable: &naga::GlobalVariable| module.types[variable.ty].inner.size(module.to_ctx());
        let of_space = |wanted: fn(&naga::AddressSpace) -> bool| -> Vec<_> {
            module.global_variables.iter().map(|(_, v)| v).filter(|v| wanted(&v.space)).collect()
        };
        let storage = of_space(|s| matches!(s, naga::AddressSpace::Storage { .. })).len() as u32;
        most_bound = storage.max(most_bound);
        if storage > limits.max_storage_buffers_per_shader_stage {
            fault(format!("{storage} storage buffers"));
        }
        let uniforms = of_space(|s| *s == naga::AddressSpace::Uniform);
        if uniforms.len() as u32 > limits.max_uniform_buffers_per_shader_stage {
            fault(format!("{} uniform buffers", uniforms.len()));
        }
        if uniforms.iter().any(|v| u64::from(size_of(v)) > limits.max_uniform_buffer_binding_size) {
            fault("a uniform buffer that is too large".into());
        }
        let shared: u32 = of_space(|s| *s == naga::AddressSpace::WorkGroup).into_iter().map(size_of).sum();
        if shared > limits.max_compute_workgroup_storage_size {
            fault(format!("{shared} bytes of workgroup memory"));
        }
        let [x, y, z] = entry.workgroup_size;
        if entry.workgroup_size_overrides.is_some()
            || x * y * z > limits.max_compute_invocations_per_workgroup
            || x > limits.max_compute_workgroup_size_x
            || y > limits.max_compute_workgroup_size_y
            || z > limits.max_compute_workgroup_size_z
        {
            fault(format!("workgroups of {x} × {y} × {z}"));
        }
        if module.types.iter().any(|(_, t)| t.inner.scalar_width() == Some(8)) {
            fault("numbers of 64 bits".into());
        }
        // `product/gemm_tiled` is there for devices without them.
        if linked.text().contains("subgroup") && shader.path() != "product/gemm_subgroup" {
            fault("subgroups".into());
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(most_bound > 4, "{most_bound}: nothing was counted");
}

#[test]
fn every_shader_file_is_a_registered_kernel_or_imported_by_one() {
    let registered = lucarne::kernels::registered();
    let entry = |text: &str| text.lines().any(|l| !l.trim_start().starts_with("//") && l.contains("@compute"));
    for (path, text) in gpu::SOURCES {
        let listed = registered.iter().any(|r| r.path() == *path);
        assert_eq!(
            entry(text),
            listed,
            "shaders/{path}.wgsl: entry-point files are registered in kernels::registered(), shared ones are not"
        );
        let import = format!("package::{}::", path.replace('/', "::"));
        let used = listed || gpu::SOURCES.iter().any(|(_, other)| other.contains(&import));
        assert!(used, "shaders/{path}.wgsl is imported by no other shader");
    }
}
