//! Every shader file is linked and validated in every registered variant, and every struct shared
//! with Rust is compared member by member.

use lucarne::gpu;

#[test]
fn every_variant_links_validates_and_shares_its_structs_with_rust() {
    let registered = lucarne::kernels::registered();
    assert!(!registered.is_empty(), "found no shaders");
    let mut faults = Vec::new();
    for variant in &registered {
        let name = format!("{} {:?}", variant.path, variant.features);
        let generated: Vec<(&str, &str)> = variant.generated.iter().map(|(p, t)| (*p, t.as_str())).collect();
        match gpu::link_with(&variant.path, &variant.features, &generated).and_then(|linked| linked.validate()) {
            Err(error) => faults.push(format!("{name}: {error}")),
            Ok((module, _)) => {
                for layout in &variant.structs {
                    faults.extend(layout.differences(&module).into_iter().map(|d| format!("{name}: {d}")));
                }
                // Uniforms hold host structs, so each must be among those compared.
                for (_, variable) in module.global_variables.iter().filter(|(_, v)| v.space == naga::AddressSpace::Uniform) {
                    let type_name = module.types[variable.ty].name.as_deref().unwrap_or("a type without name");
                    if !variant.structs.iter().any(|s| s.name == type_name) {
                        faults.push(format!("{name}: the uniform's struct '{type_name}' is not registered"));
                    }
                }
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
        let listed = registered.iter().any(|r| r.path == *path);
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
