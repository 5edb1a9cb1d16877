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
