//! Files written by the tests, and the office beside its `.rad` twin.

use super::reader::triangle_indices;
use super::*;
use crate::scene::points::Sensor;
use crate::scene::{self, MaterialKind, rad};
use gltf::mesh::Mode;
use serde_json::json;

/// Writes `main.gltf` with the given top-level entries, and `data.bin` with three vertices of a
/// triangle (0,0,0) (1,0,0) (0,1,0), their normals and indices.
struct File {
    folder: tempfile::TempDir,
    json: Value,
}

impl File {
    fn new() -> Self {
        let mut data: Vec<u8> = Vec::new();
        for c in [0f32, 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1., 0., 0., 1.] {
            data.extend(c.to_le_bytes());
        }
        data.extend([0, 0, 1, 0, 2, 0]);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("data.bin"), &data).unwrap();
        let vectors = |view: usize| json!({ "bufferView": view, "componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 1, 0] });
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }] }],
            "materials": [{ "name": "grey", "extras": { "radiance": "void plastic grey 0 0 5 .5 .5 .5 0 0" } }],
            "accessors": [vectors(0), vectors(1), { "bufferView": 2, "componentType": 5123, "type": "SCALAR", "count": 3 }],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
                { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
                { "buffer": 0, "byteOffset": 72, "byteLength": 6 }
            ],
            "buffers": [{ "uri": "data.bin", "byteLength": 78 }]
        });
        Self { folder, json }
    }

    fn with(pointer: &str, value: Value) -> Self {
        Self::new().and(pointer, value)
    }

    /// Sets one entry; missing objects on the way are made.
    fn and(mut self, pointer: &str, value: Value) -> Self {
        let mut place = &mut self.json;
        for key in pointer.split('/').skip(1) {
            place = match key.parse::<usize>() {
                Ok(i) => &mut place[i],
                Err(_) => &mut place[key],
            };
        }
        *place = value;
        self
    }

    fn read_with(&self, options: &Options) -> (std::result::Result<Contents, String>, String) {
        let path = self.folder.path().join("main.gltf");
        std::fs::write(&path, serde_json::to_vec(&self.json).unwrap()).unwrap();
        let mut warnings = Warnings::new();
        let contents = read(&path, options, &mut warnings);
        let texts: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        (contents.map_err(|e| e.to_string()), texts.join("\n"))
    }

    fn read(&self) -> Contents {
        let (contents, warnings) = self.read_with(&Options::default());
        assert_eq!(warnings, "");
        contents.unwrap()
    }

    fn error(&self) -> String {
        self.read_with(&Options::default()).0.expect_err("should be refused")
    }
}

#[test]
fn y_up_becomes_z_up_unless_the_file_or_the_caller_says_otherwise() {
    let triangle = |c: Contents| c.scene.triangles[0].vertices;
    let (o, x, y, z) = (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z);
    assert_eq!(triangle(File::new().read()), [o, x, z]);
    assert_eq!(triangle(File::with("/asset/extras", json!({ "up_axis": "Z" })).read()), [o, x, y]);
    let millimetres = json!({ "up_axis": "Z", "scale": 0.001 });
    assert_eq!(triangle(File::with("/scenes/0/extras", millimetres).read()), [o, x * 0.001, y * 0.001]);
    let options = Options { up: UpAxis::Z, scale: 2.0 };
    assert_eq!(triangle(File::new().read_with(&options).0.unwrap()), [o, x * 2.0, y * 2.0]);
    assert!(File::with("/asset/extras", json!({ "up_axis": "W" })).error().contains("up_axis is \"W\""));
    assert!(File::with("/asset/extras", json!({ "scale": -1 })).error().contains("scale is not a positive number"));
}

#[test]
fn nodes_place_their_meshes_and_mirrors_keep_the_front() {
    // Turned by 90° about x (y to z), scaled, moved; inside a node that moves and mirrors.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let file = File::with(
        "/nodes",
        json!([
            { "children": [1], "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1] },
            { "mesh": 0, "rotation": [half, 0, 0, half], "scale": [2, 3, 4], "translation": [5, 6, 7] }
        ]),
    )
    .and("/asset/extras", json!({ "up_axis": "Z" }));
    let [a, b, c] = file.read().scene.triangles[0].vertices;
    // Mirrored: the last two corners change places.
    let expected = [DVec3::new(5.0, 6.0, 7.0), DVec3::new(5.0, 6.0, 10.0), DVec3::new(3.0, 6.0, 7.0)];
    for (found, expected) in [a, b, c].iter().zip(expected) {
        assert!((found - expected).length() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn strips_and_fans_turn_as_triangles_do() {
    let indices = [7, 8, 9, 10, 11];
    assert_eq!(triangle_indices(Mode::TriangleStrip, &indices, false), [[7, 8, 9], [9, 8, 10], [9, 10, 11]]);
    assert_eq!(triangle_indices(Mode::TriangleFan, &indices, false), [[7, 8, 9], [7, 9, 10], [7, 10, 11]]);
    assert_eq!(triangle_indices(Mode::Triangles, &indices, true), [[7, 9, 8]]);
    for mode in [Mode::TriangleStrip, Mode::TriangleFan, Mode::Triangles] {
        assert!(triangle_indices(mode, &[1], false).is_empty() && triangle_indices(mode, &[], false).is_empty());
    }
}

#[test]
fn materials_follow_the_table() {
    let kind = |material: Value| {
        let (contents, warnings) = File::with("/materials/0", material).read_with(&Options::default());
        (contents.map(|c| c.scene.materials[0].kind), warnings)
    };
    let plain = |material: Value| {
        let (kind, warnings) = kind(material);
        assert_eq!(warnings, "");
        kind.unwrap()
    };
    let wall = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.7, 0.6, 1], "metallicFactor": 0 } });
    let color = [0.8, 0.7, 0.6];
    assert_eq!(plain(wall), MaterialKind::Plastic { color, specularity: 0.0, roughness: 0.0 });
    let paint = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.7, 0.6, 1], "metallicFactor": 0, "roughnessFactor": 0.5 } });
    let MaterialKind::Plastic { specularity, roughness, .. } = plain(paint) else { panic!() };
    assert!((specularity - 0.04).abs() < 1e-12 && roughness == 0.25);
    let steel = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.7, 0.6, 1], "roughnessFactor": 0.3 } });
    let MaterialKind::Metal { color: c, specularity, roughness } = plain(steel) else { panic!() };
    assert!(c == color && specularity == 1.0 && (roughness - 0.09).abs() < 1e-12);
    let lamp = json!({ "emissiveFactor": [1, 1, 0.5], "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 358 } } });
    assert_eq!(plain(lamp), MaterialKind::Glow { radiance: [2.0, 2.0, 1.0], max_radius: 0.0 });
    let pane = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.88, 0.88, 0.88, 1], "metallicFactor": 0, "roughnessFactor": 0 },
        "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1.52 } }
    });
    // The manual of Radiance: a transmittance of 0.88 is a transmissivity of 0.96.
    let MaterialKind::Glass { transmissivity, refraction_index } = plain(pane) else { panic!() };
    assert!((transmissivity[1] - 0.9584).abs() < 1e-3 && (refraction_index - 1.52).abs() < 1e-9, "{transmissivity:?}");
    let blind = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.7, 0.6, 1], "metallicFactor": 0, "roughnessFactor": 0.5 },
        "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.25 } }
    });
    let MaterialKind::Trans { transmissivity: 0.25, transmitted_specularity: 1.0, roughness: 0.25, .. } = plain(blind) else { panic!() };

    let (blended, warnings) =
        kind(json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 0.25], "metallicFactor": 0 } }));
    assert!(matches!(blended, Ok(MaterialKind::Glass { .. })) && warnings.contains("transmits 0.750"), "{warnings}");
    let (_, warnings) = kind(json!({ "pbrMetallicRoughness": { "metallicFactor": 0.25 } }));
    assert!(warnings.contains("metallic factor 0.25 is taken as 0"), "{warnings}");
    let (bad, _) = kind(json!({ "pbrMetallicRoughness": { "baseColorFactor": [2, 0, 0, 1] } }));
    assert!(bad.is_err());
    let textured = File::with(
        "/materials/0",
        json!({ "name": "carpet", "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": { "index": 0 } } }),
    )
    .and("/textures", json!([{ "source": 0 }]))
    .and("/images", json!([{ "uri": "carpet.png" }]));
    assert!(textured.read_with(&Options::default()).1.contains("material 0 'carpet': its textures are left out"));
}

#[test]
fn alpha_masks_are_obeyed_or_named() {
    let masked = |material: Value| {
        let file =
            File::with("/materials/0", material).and("/textures", json!([{ "source": 0 }])).and("/images", json!([{ "uri": "leaf.png" }]));
        let (contents, warnings) = file.read_with(&Options::default());
        (contents.unwrap().scene.materials[0].kind, warnings)
    };
    let leaf = |alpha: f64, cutoff: Value| {
        masked(
            json!({ "alphaMode": "MASK", "alphaCutoff": cutoff, "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, alpha], "metallicFactor": 0 } }),
        )
    };
    let whole = MaterialKind::Plastic { color: [0.5; 3], specularity: 0.0, roughness: 0.0 };
    assert_eq!(leaf(0.6, json!(0.5)), (whole, String::new()));
    assert_eq!(leaf(0.6, json!(0.6)), (whole, String::new()));
    let (gone, warnings) = leaf(0.6, json!(0.7));
    assert!(gone == MaterialKind::Void && warnings.contains("below the cutoff of its alpha mask"), "{warnings}");
    for (mode, words) in
        [("MASK", "its alpha mask, which a picture gives, is left out"), ("BLEND", "its opacity, which a picture gives, is left out")]
    {
        let (kind, warnings) = masked(
            json!({ "alphaMode": mode, "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "baseColorTexture": { "index": 0 } } }),
        );
        assert!(kind == whole && warnings.contains(words), "{warnings}");
    }
}

/// The triangle, with one more accessor of so many floats.
fn with_floats(file: File, kind: &str, floats: &[f32]) -> (File, usize) {
    let data: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
    let components = if kind == "VEC4" { 4 } else { 3 };
    with_data(file, json!({ "componentType": 5126, "type": kind, "count": floats.len() / components }), &data)
}

/// The triangle, with one more accessor, whose data are put into a file of their own.
fn with_data(mut file: File, mut accessor: Value, data: &[u8]) -> (File, usize) {
    let count = |v: &Value| v.as_array().unwrap().len();
    let [buffer, view, number] = ["buffers", "bufferViews", "accessors"].map(|key| count(&file.json[key]));
    std::fs::write(file.folder.path().join(format!("more{buffer}.bin")), data).unwrap();
    accessor["bufferView"] = json!(view);
    let mut push = |key: &str, value: Value| file.json[key].as_array_mut().unwrap().push(value);
    push("buffers", json!({ "uri": format!("more{buffer}.bin"), "byteLength": data.len() }));
    push("bufferViews", json!({ "buffer": buffer, "byteOffset": 0, "byteLength": data.len() }));
    push("accessors", accessor);
    (file, number)
}

#[test]
fn instances_stand_where_the_extension_says() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let (file, translation) = with_floats(File::new(), "VEC3", &[0., 0., 0., 100., 0., 0.]);
    // The second is turned by 90° about y (z to x) and twice as large.
    let (file, rotation) = with_floats(file, "VEC4", &[0., 0., 0., 1., 0., half, 0., half]);
    let (file, scale) = with_floats(file, "VEC3", &[1., 1., 1., 2., 2., 2.]);
    let attributes = json!({ "TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale, "_ID": 0 });
    let file = file
        .and("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"]))
        .and("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"]))
        .and(
            "/nodes/0",
            json!({ "mesh": 0, "translation": [0, 0, 5], "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } } }),
        )
        .and("/asset/extras", json!({ "up_axis": "Z" }));
    let scene = file.read().scene;
    let expected = [
        [DVec3::new(0., 0., 5.), DVec3::new(1., 0., 5.), DVec3::new(0., 1., 5.)],
        [DVec3::new(100., 0., 5.), DVec3::new(100., 0., 3.), DVec3::new(100., 2., 5.)],
    ];
    assert_eq!(scene.triangles.len(), 2);
    for (triangle, expected) in scene.triangles.iter().zip(expected) {
        for (found, expected) in triangle.vertices.iter().zip(expected) {
            assert!((found - expected).length() < 1e-6, "{found} {expected}");
        }
    }
    // Sensors are instanced too.
    let sensors = file.and("/nodes/0/name", json!("sensors:desk")).read().sensors;
    assert_eq!((sensors[0].sensors.len(), sensors[0].sensors[3].position), (6, DVec3::new(100., 0., 5.)));

    let broken = |attributes: Value| {
        let (file, _) = with_floats(File::new(), "VEC3", &[0.; 6]);
        let (file, _) = with_floats(file, "VEC3", &[1.; 9]);
        file.and("/nodes/0/extensions", json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } })).error()
    };
    for (attributes, message) in [
        (json!({}), "neither TRANSLATION, ROTATION nor SCALE"),
        (json!({ "TRANSLATION": 77 }), "TRANSLATION names accessor 77, which is not there"),
        (json!({ "TRANSLATION": "x" }), "TRANSLATION names accessor \"x\""),
        (json!({ "TRANSLATION": 3, "SCALE": 4 }), "its accessors have 2 and 3 elements"),
        (json!({ "ROTATION": 3 }), "4 components are needed"),
        (json!({ "TRANSLATION": 2 }), "3 components are needed"),
    ] {
        let error = broken(attributes);
        assert!(error.contains(message) && (error.contains("node 0") || error.contains("accessor ")), "{error}");
    }
}

#[test]
fn quantised_meshes_are_read() {
    // (0,0,0) (1,0,0) (0,1,0) as normalised 16-bit integers, padded to 8 bytes.
    let data: Vec<u8> = [0i16, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let accessor =
        json!({ "componentType": 5122, "normalized": true, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [32767, 32767, 0] });
    let (file, number) = with_data(File::new(), accessor, &data);
    let view = file.json["accessors"][number]["bufferView"].as_u64().unwrap();
    let file = file
        .and(&format!("/bufferViews/{view}/byteStride"), json!(8))
        .and("/meshes/0/primitives/0/attributes", json!({ "POSITION": number }))
        .and("/extensionsRequired", json!(["KHR_mesh_quantization"]))
        .and("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    assert_eq!(file.read().scene.triangles[0].vertices, [DVec3::ZERO, DVec3::X, DVec3::Z]);
    let bytes = json!({ "componentType": 5121, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [255, 1, 0] });
    let used = File::with("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    let (file, number) = with_data(used, bytes, &[0, 0, 0, 255, 0, 0, 0, 1, 0]);
    let file = file.and("/meshes/0/primitives/0/attributes", json!({ "POSITION": number }));
    assert_eq!(file.read().scene.triangles[0].vertices, [DVec3::ZERO, DVec3::X * 255.0, DVec3::Z]);
}

#[test]
fn every_extension_that_is_not_obeyed_is_named() {
    let plain = json!({ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_clearcoat": {} } });
    let file = || {
        File::with("/materials/0", plain.clone())
            .and("/nodes/0/extensions", json!({ "KHR_lights_punctual": { "light": 0 } }))
            .and("/meshes/0/primitives/0/extensions", json!({ "VENDOR_unknown": {} }))
            .and("/extensionsUsed", json!(["KHR_materials_clearcoat", "VENDOR_animation", "KHR_materials_ior"]))
    };
    let (contents, warnings) = file().read_with(&Options::default());
    assert_eq!(contents.unwrap().scene.triangles.len(), 1);
    for words in [
        "the extension KHR_materials_clearcoat of materials[0] is left out",
        "the extension KHR_lights_punctual of nodes[0] is left out",
        "the extension VENDOR_unknown of meshes[0] is left out",
        "the extension VENDOR_animation is left out",
    ] {
        assert!(warnings.contains(words), "{warnings}");
    }
    assert_eq!(warnings.matches("is left out").count(), 4, "{warnings}");
    // Nothing is left out of a material that is given exactly.
    let exact = json!({ "radiance": "void plastic p 0 0 5 .5 .5 .5 0 0" });
    let (_, warnings) = file().and("/materials/0/extras", exact).read_with(&Options::default());
    assert!(!warnings.contains("clearcoat") && warnings.contains("VENDOR_unknown"), "{warnings}");
    let required = file().and("/extensionsRequired", json!(["KHR_draco_mesh_compression"])).error();
    assert!(
        required.contains("requires an extension this program does not know") && required.contains("KHR_draco_mesh_compression"),
        "{required}"
    );
}

#[test]
fn files_that_ask_for_too_much_end_in_one_error() {
    let dangling = File::with("/meshes/0/primitives/0/attributes/POSITION", json!(9)).error();
    assert!(dangling.contains("meshes[0].primitives[0].attributes[\"POSITION\"]"), "{dangling}");
    let alone = File {
        json: json!({ "asset": { "version": "2.0" }, "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }] }),
        ..File::new()
    };
    assert!(alone.error().contains("POSITION"));

    let mut nodes: Vec<Value> = (1..=60).map(|i| json!({ "children": [i, i] })).collect();
    nodes.push(json!({}));
    let shared = File::with("/nodes", json!(nodes)).error();
    assert!(shared.contains("more than 1048576 nodes and instances"), "{shared}");
    let deep: Vec<Value> = (1..=200).map(|i| json!({ "children": [i] })).chain([json!({})]).collect();
    assert!(File::with("/nodes", json!(deep)).error().contains("nested more than 128 deep"));
    let circle = json!([{ "children": [1] }, { "children": [0] }]);
    assert!(File::with("/nodes", circle).error().contains("or in a circle"));

    let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": 1_000_000_000_000_u64, "min": [0, 0, 0], "max": [0, 0, 0],
        "sparse": { "count": 1, "indices": { "bufferView": 2, "componentType": 5123 }, "values": { "bufferView": 0 } } });
    let many = File::with("/accessors/0", zeros).error();
    assert!(many.contains("more than 4194304 elements") || many.contains("150000000 vertices"), "{many}");
}

#[test]
fn a_surface_without_a_material_is_refused_by_name() {
    let mut file = File::with("/nodes/0/name", json!("desk"));
    file.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    let error = file.error();
    assert!(error.contains("node 0 'desk'") || error.contains("mesh 0"), "{error}");
    assert!(error.contains("has no material") && error.contains("assign a material"), "{error}");
}

#[test]
fn extras_give_exact_materials() {
    let kind = |text: &str| File::with("/materials/0/extras", json!({ "radiance": text })).read_with(&Options::default());
    let trans = "void trans t 0 0 7 .5 .4 .3 .06 .05 .7 .8";
    assert_eq!(
        kind(trans).0.unwrap().scene.materials[0].kind,
        MaterialKind::Trans {
            color: [0.5, 0.4, 0.3],
            specularity: 0.06,
            roughness: 0.05,
            transmissivity: 0.7,
            transmitted_specularity: 0.8
        }
    );
    assert_eq!(kind("void").0.unwrap().scene.materials[0].kind, MaterialKind::Void);
    let (_, warnings) = kind("void texfunc b 4 x y z y.cal 0 0\nb plastic p 0 0 5 1.5 .5 .5 0 0");
    assert!(warnings.contains("this texfunc is ignored") && warnings.contains("more than 1"), "{warnings}");
    for (text, message) in [
        ("void plastic p 0 0 4 1 1 1 1", "5 are needed"),
        ("void prism1 d 5 1 0 0 1 . 0 0", "not supported"),
        ("!genbox a b 1 1 1", "this is no material"),
        ("", "this is no material"),
        ("void sphere s 0 0 4 0 0 0 1", "this is no material"),
    ] {
        let error = kind(text).0.unwrap_err();
        assert!(error.contains(message) && error.contains("material 0 'grey'"), "{text}: {error}");
    }
    assert!(File::with("/materials/0/extras", json!({ "radiance": 5 })).error().contains("\"radiance\" is 5"));
}

#[test]
fn windows_and_sensors_are_found_by_their_marks() {
    let south = |file: File| {
        let contents = file.read();
        assert!(contents.scene.triangles.is_empty() && contents.scene.materials.is_empty());
        let [window] = contents.windows.try_into().unwrap();
        assert_eq!((window.name.as_str(), window.triangles.len()), ("south", 1));
        // Counter-clockwise seen from glTF's +z, which is south.
        assert!((window.frame.z - DVec3::NEG_Y).length() < 1e-12);
        window
    };
    south(File::with("/nodes/0/name", json!("window:south")));
    south(File::with("/meshes/0/name", json!("window: south")));
    south(File::with("/materials/0/name", json!("window:south")));
    south(File::with("/materials/0/extras", json!({ "window": "south" })));
    south(File::with("/nodes", json!([{ "name": "window:south", "children": [1] }, { "mesh": 0 }])));
    let window = south(File::with("/nodes/0/extras", json!({ "window": "south", "rfluxmtx": "h=kh u=-Z" })));
    assert_eq!((window.basis.len(), window.frame.y), (77, DVec3::NEG_Z));

    let sensors = |file: File| {
        let contents = file.read();
        let [grid] = contents.sensors.try_into().unwrap();
        assert_eq!((grid.name.as_str(), grid.sensors.len()), ("desk", 3));
        assert_eq!((grid.sensors[2].position, grid.sensors[2].direction), (DVec3::Z, DVec3::NEG_Y));
    };
    sensors(File::with("/nodes/0/extras", json!({ "sensors": "desk" })));
    sensors(File::with("/nodes/0/name", json!("sensors:desk")));
    sensors(File::with("/nodes/0/name", json!("sensors:desk")).and("/meshes/0/primitives/0/mode", json!(0)));
    let mut without_normals = File::with("/nodes/0/name", json!("sensors:desk"));
    without_normals.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
    sensors(without_normals);

    let unnamed = File::with("/nodes/0/extras", json!({ "window": true })).error();
    assert!(unnamed.contains("\"window\" is true"), "{unnamed}");
    let basis = File::with("/nodes/0/extras", json!({ "window": "south", "rfluxmtx": "h=r4" })).error();
    assert!(basis.contains("h=r4 is not a basis of windows"), "{basis}");
}

#[test]
fn buffers_come_from_the_files_own_folder_only() {
    let outside = tempfile::tempdir().unwrap();
    let data = std::fs::read(File::new().folder.path().join("data.bin")).unwrap();
    std::fs::write(outside.path().join("data.bin"), &data).unwrap();
    let absolute = outside.path().join("data.bin").display().to_string();
    let climbing = format!("../{}/data.bin", outside.path().file_name().unwrap().to_string_lossy());
    let encoded = climbing.replace("../", "%2e%2e/");
    for (uri, message) in [
        (absolute.as_str(), "lies outside the folder"),
        (climbing.as_str(), "lies outside the folder"),
        (encoded.as_str(), "lies outside the folder"),
        ("http://example.org/data.bin", "nothing is loaded from elsewhere"),
        ("file:///data.bin", "nothing is loaded from elsewhere"),
        ("sub\\data.bin", "lies outside the folder"),
        ("%zz", "not a valid URI"),
        ("missing.bin", "No such file"),
        ("data:application/octet-stream;base64,@@@@", "data URI cannot be decoded"),
        ("data:application/octet-stream;base64,AAAA", "3 bytes are there, 78 are announced"),
    ] {
        let error = File::with("/buffers/0/uri", json!(uri)).error();
        // Data URIs are padded by the reader to a multiple of four bytes.
        let message = if uri.ends_with("AAAA") { "bytes are there, 78 are announced" } else { message };
        assert!(error.contains(message), "{uri}: {error}");
    }
    #[cfg(unix)]
    {
        let file = File::with("/buffers/0/uri", json!("link.bin"));
        std::os::unix::fs::symlink(&absolute, file.folder.path().join("link.bin")).unwrap();
        assert!(file.error().contains("a link that leads out"));
    }
    let spaced = File::with("/buffers/0/uri", json!("sub%20folder/./data.bin"));
    std::fs::create_dir(spaced.folder.path().join("sub folder")).unwrap();
    std::fs::write(spaced.folder.path().join("sub folder/data.bin"), &data).unwrap();
    assert_eq!(spaced.read().scene.triangles.len(), 1);
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let nan = File::new();
    let mut data = std::fs::read(nan.folder.path().join("data.bin")).unwrap();
    data[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    std::fs::write(nan.folder.path().join("data.bin"), &data).unwrap();
    assert!(nan.error().contains("mesh 0: vertex 1 has coordinates that are not finite"), "{}", nan.error());
    let wild = File::new();
    data[12..16].copy_from_slice(&1f32.to_le_bytes());
    data[74] = 9;
    std::fs::write(wild.folder.path().join("data.bin"), &data).unwrap();
    assert!(wild.error().contains("a triangle names vertex 9 of 3"), "{}", wild.error());
    for (pointer, value, message) in [
        ("/buffers/0/byteLength", json!(7800), "78 bytes are there, 7800 are announced"),
        ("/bufferViews/0/byteOffset", json!(70), "the data lie outside their buffer"),
        ("/bufferViews/0/byteLength", json!(35), "accessor 0: the data lie outside their buffer"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "outside their buffer"),
        ("/accessors/0/count", json!(4), "accessor 0: the data lie outside their buffer"),
        ("/accessors/0/count", json!(u64::MAX), "accessor 0: the data lie outside their buffer"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessor 0: the data lie outside their buffer"),
        ("/accessors/0/componentType", json!(5122), "vectors of three 32-bit floats"),
        ("/accessors/2/componentType", json!(5122), "indices must be unsigned integers"),
        ("/accessors/2/type", json!("VEC2"), "indices must be single numbers"),
        ("/meshes/0/primitives/0/material", Value::Null, "the mesh has no material"),
        ("/meshes/0/primitives/0/attributes", json!({ "NORMAL": 1 }), "positions"),
        ("/meshes/0/primitives/0/material", json!(7), "not glTF"),
        ("/nodes/0", json!({ "mesh": 0, "children": [0] }), "nested more than 128 deep"),
        ("/nodes/0", json!({ "mesh": 0, "scale": [1e38, 1e38, 1e38], "children": [0] }), "node"),
        ("/nodes/0", json!({ "mesh": 0, "rotation": [0, 0, 0, 0] }), "not a unit quaternion"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"),
        ("/scenes", json!([]), ""),
        ("/asset/version", json!("1.0"), ""),
    ] {
        let error = File::with(pointer, value.clone()).error();
        assert!(error.contains("main.gltf") && error.contains("help:"), "{pointer} {value}: {error}");
        // What the JSON's own validation finds is worded by it.
        let own = error.contains(message) || message == "not glTF" || error.contains("faults)");
        assert!(own, "{pointer} {value}: {error}");
    }
}

#[test]
fn written_scenes_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let text = "void plastic red 0 0 5 .501 .2 .1 .04 .1\nvoid metal m 0 0 5 .5 .2 .1 .9 .1\nvoid trans t 0 0 7 .5 .4 .3 .06 .05 .7 .8\n\
        void glass g 0 0 3 .9 .8 .7\nvoid mirror r 0 0 3 .9 .8 .7\nvoid light l 0 0 3 9 8 7\nvoid glow w 0 0 4 9 8 7 2\n\
        void plastic a 0 0 5 .501 .2 .1 0 0\nvoid mixfunc x 4 a void .7 . 0 0\nx polygon p 0 0 9 0 0 .4 1 0 .4 1 1 .4\n\
        !genbox red b 1 2 3\n!genbox m b 1 2 3 -i | xform -t 1.1 2.2 3.3\nt sphere s 0 0 4 1 2 3 .5\ng ring r 0 0 8 1 2 3 0 1 1 0 .5\n\
        r cone c 0 0 8 0 0 0 0 0 1 .2 .3\nl polygon p 0 0 9 0 0 .1 1 0 .1 1 1 .1\nw polygon p 0 0 9 0 0 .2 1 0 .2 1 1 .2\nvoid polygon p 0 0 9 0 0 .3 1 0 .3 1 1 .3\n";
    std::fs::write(folder.path().join("main.rad"), text).unwrap();
    let windows_text = "#@rfluxmtx h=kh u=1,2,3\nsouth polygon w 0 0 12 0 0 1 0 0 2 3 0 2 3 0 1\n#@rfluxmtx h=-kf\neast polygon w 0 0 12 5 0 1 5 0 2 5 3 2 5 3 1\n";
    std::fs::write(folder.path().join("windows.rad"), windows_text).unwrap();
    let mut warnings = Warnings::new();
    let scene = rad::read_scene(&["main.rad".into()], folder.path(), &mut warnings).unwrap();
    let windows = rad::read_windows(Path::new("windows.rad"), folder.path(), &mut warnings).unwrap();
    let sensor = |x: f64, line: usize| Sensor { position: DVec3::new(x, 2.0, 0.75), direction: DVec3::new(0.6, 0.0, 0.8), line };
    let sensors = [SensorGrid { name: "desk".into(), sensors: vec![sensor(1.0, 1), sensor(1.5, 2)] }];
    for name in ["main.gltf", "main.glb"] {
        let path = folder.path().join(name);
        write(&path, &scene, &windows, &sensors).unwrap();
        let back = read(&path, &Options::default(), &mut warnings).unwrap();
        assert_eq!(
            back.scene.materials.iter().map(|m| m.kind).collect::<Vec<_>>(),
            scene.materials.iter().map(|m| m.kind).collect::<Vec<_>>()
        );
        assert_same_triangles(&back.scene, &scene);
        for (a, b) in back.windows.iter().zip(&windows) {
            assert_eq!((&a.name, &a.basis), (&b.name, &b.basis));
            for (u, v) in [(a.frame.x, b.frame.x), (a.frame.y, b.frame.y), (a.frame.z, b.frame.z)] {
                assert!((u - v).length() < 1e-6);
            }
            assert!((a.area() - b.area()).abs() < 1e-6);
        }
        assert_eq!((back.windows.len(), back.sensors.len(), back.sensors[0].sensors.len()), (2, 1, 2));
        assert!((back.sensors[0].sensors[1].direction - sensors[0].sensors[1].direction).length() < 1e-6);
    }
    assert!(warnings.is_empty(), "{warnings:?}");
    // Parts of a file by name.
    let east = scene::read_windows(Path::new("main.glb#east"), folder.path(), &mut warnings).unwrap();
    assert_eq!((east.len(), east[0].name.as_str()), (1, "east"));
    let none = scene::read_windows(Path::new("main.glb#west"), folder.path(), &mut warnings).unwrap_err().to_string();
    assert!(none.contains("no window 'west', but: south, east"), "{none}");
    assert_eq!(scene::read_sensors(&folder.path().join("main.gltf"), Some("other"), &mut warnings).unwrap().len(), 2);
    let joined = scene::read_scene(&["main.glb".into(), "main.rad".into()], folder.path(), &mut warnings).unwrap();
    assert_eq!(joined.triangles.len(), 2 * scene.triangles.len());
    assert_eq!(joined.materials[joined.triangles.last().unwrap().material.0 as usize].name, "void");

    // Cut off or damaged anywhere: an error, or another scene, but no panic.
    let bytes = std::fs::read(folder.path().join("main.glb")).unwrap();
    let path = folder.path().join("broken.glb");
    for end in (0..bytes.len()).step_by(bytes.len() / 200) {
        std::fs::write(&path, &bytes[..end]).unwrap();
        assert!(read(&path, &Options::default(), &mut Warnings::new()).is_err(), "{end} bytes");
    }
    let mut state = 5_u64;
    for _ in 0..300 {
        let mut bytes = bytes.clone();
        for _ in 0..4 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let place = (state >> 33) as usize % bytes.len().min(9000);
            bytes[place] = (state >> 20) as u8;
        }
        std::fs::write(&path, &bytes).unwrap();
        let _ = read(&path, &Options::default(), &mut Warnings::new());
    }
}

/// The same triangles in any order, to the precision of 32-bit coordinates.
fn assert_same_triangles(a: &Scene, b: &Scene) {
    let sorted = |s: &Scene| {
        let mut all: Vec<(String, [DVec3; 3])> =
            s.triangles.iter().map(|t| (s.materials[t.material.0 as usize].name.clone(), t.vertices)).collect();
        let key = |(name, v): &(String, [DVec3; 3])| (name.clone(), v.map(|p| (p * 1e4).round().to_array().map(|c| c as i64)));
        all.sort_by_key(key);
        all
    };
    let (a, b) = (sorted(a), sorted(b));
    assert_eq!(a.len(), b.len());
    for (x, y) in a.iter().zip(&b) {
        assert_eq!(x.0, y.0);
        // Half a unit in the last place of 24 bits, of coordinates up to 512.
        let far = x.1.iter().zip(y.1).map(|(p, q)| (p - q).abs().max_element()).fold(0.0, f64::max);
        assert!(far < 512.0 * 2f64.powi(-24), "{x:?} {y:?}");
    }
}

#[test]
fn the_office_is_its_rad_twin() {
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office");
    let mut warnings = Warnings::new();
    let twin = read(&office.join("office.gltf"), &Options::default(), &mut warnings).unwrap();
    let scene = rad::read_scene(&["materials.rad".into(), "office.rad".into()], &office, &mut warnings).unwrap();
    assert!(warnings.is_empty());
    assert_same_triangles(&twin.scene, &scene);
    let kinds = |s: &Scene| s.materials.iter().map(|m| (m.name.clone(), m.kind)).collect::<Vec<_>>();
    assert_eq!(kinds(&twin.scene), kinds(&scene));
    for window in &twin.windows {
        let file = format!("windows/{}.rad", window.name);
        let [own] = rad::read_windows(Path::new(&file), &office, &mut warnings).unwrap().try_into().unwrap();
        assert!((window.frame.z - own.frame.z).length() < 1e-6 && (window.area() - own.area()).abs() < 1e-5);
        assert_eq!(window.basis, own.basis);
    }
    assert_eq!(twin.windows.len(), 2);
    for grid in &twin.sensors {
        let own = crate::scene::points::read_points(&office.join(format!("{}.txt", grid.name))).unwrap();
        assert_eq!(grid.sensors.len(), own.len());
        for (a, b) in grid.sensors.iter().zip(&own) {
            assert!((a.position - b.position).length() < 1e-6 && (a.direction - b.direction).length() < 1e-6);
        }
    }
    assert_eq!(twin.sensors.len(), 2);
}
