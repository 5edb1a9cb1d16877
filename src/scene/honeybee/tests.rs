use super::*;
use crate::scene::MaterialKind;
use glam::DVec3;
use std::collections::BTreeMap;

fn room() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/honeybee_room/room.hbjson")
}

/// The shipped model with something changed.
fn changed(change: impl FnOnce(&mut Value)) -> (Result<Model>, Vec<String>) {
    let mut value: Value = serde_json::from_slice(&files::read(&room()).unwrap()).unwrap();
    change(&mut value);
    read_text(&value.to_string())
}

fn read_text(text: &str) -> (Result<Model>, Vec<String>) {
    let mut warnings = Warnings::new();
    let model = read_bytes(text.as_bytes(), Path::new("room.hbjson"), &mut warnings);
    (model, warnings.iter().map(ToString::to_string).collect())
}

fn area([a, b, c]: &[DVec3; 3]) -> f64 {
    (*b - *a).cross(*c - *a).length() / 2.0
}

/// Number of polygons and area in m², by modifier, of surfaces and windows together.
fn areas(model: &Model) -> BTreeMap<String, (usize, f64)> {
    let mut found: BTreeMap<String, (usize, f64)> = BTreeMap::new();
    let mut last = None;
    for t in &model.scene.triangles {
        let entry = found.entry(model.scene.materials[t.material.0 as usize].name.clone()).or_default();
        entry.0 += usize::from(last != Some(t.surface));
        entry.1 += area(&t.vertices);
        last = Some(t.surface);
    }
    for window in &model.windows {
        let entry = found.entry(window.modifier.clone()).or_default();
        entry.0 += window.apertures.len();
        entry.1 += window.window.area();
    }
    found
}

/// What honeybee-radiance 1.66.299 writes for the shipped model: `model_to_rad_folder(Model.from_hbjson(…), …)`, then
/// the polygons of scene/, aperture/ and the first state of aperture_group/ counted by modifier. A mesh is one
/// surface here, three polygons there, of which one is the house.
const REFERENCE: [(&str, usize, f64); 15] = [
    ("blind", 1, 1.0),
    ("canvas", 1, 1.0),
    ("clear_double", 2, 2.8),
    ("generic_ceiling_0.80", 2, 30.0),
    ("generic_context_0.20", 2, 88.0),
    ("generic_exterior_shade_0.35", 1, 0.72),
    ("generic_exterior_window_vis_0.64", 2, 4.08),
    ("generic_floor_0.20", 1, 8.0),
    ("generic_interior_shade_0.50", 1, 1.92),
    ("generic_interior_window_vis_0.88", 1, 1.5),
    ("generic_opaque_door_0.50", 1, 2.08),
    ("generic_wall_0.50", 4, 30.02),
    ("light_walls", 4, 45.42),
    ("polished", 1, 0.48),
    ("steel_floor", 1, 24.0),
];

#[test]
fn areas_counts_and_sensors_are_those_that_honeybee_radiance_writes() {
    let mut warnings = Warnings::new();
    let model = read(&room(), &mut warnings).unwrap();
    let mut found = areas(&model);
    // The first of two states.
    assert_eq!(found.remove("tint_clear").map(|(n, a)| (n, (a * 1e6).round())), Some((1, 1.12e6)));
    assert_eq!(found.len(), REFERENCE.len(), "{found:?}");
    for ((name, (count, area)), expected) in found.iter().zip(REFERENCE) {
        assert!(
            (name.as_str(), *count) == (expected.0, expected.1) && (area - expected.2).abs() < 1e-9,
            "{name} {count} {area} {expected:?}"
        );
    }
    let grids: Vec<(&str, usize)> = model.sensors.iter().map(|g| (g.name.as_str(), g.sensors.len())).collect();
    assert_eq!(grids, [("Workplane", 24), ("Corridor", 8)]);
    // `grid/Workplane.pts` begins `0.5 5.5 0.8 0.0 0.0 1.0`.
    let first = model.sensors[0].sensors[0];
    assert!((first.position - DVec3::new(0.5, 5.5, 0.8)).length() < 1e-12 && first.direction == DVec3::Z, "{first:?}");
    // `view/desk.vf` has these words.
    assert_eq!(model.views[0].options, "-vth -vp 2 5 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180");
    assert_eq!(model.groups, [("facade".to_string(), 2)]);
    let texts: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert!(
        texts.len() == 1 && texts.iter().any(|t| t.contains("'west_blind' and all others of a BSDF") && t.contains("front outside")),
        "{texts:?}"
    );
}

#[test]
fn materials_are_those_that_honeybee_radiance_writes() {
    let model = read(&room(), &mut Warnings::new()).unwrap();
    let kind = |name: &str| model.scene.materials.iter().find(|m| m.name == name).unwrap().kind;
    let plastic = |color: [f64; 3]| MaterialKind::Plastic { color, specularity: 0.0, roughness: 0.0 };
    assert_eq!(kind("light_walls"), plastic([0.7, 0.68, 0.6]));
    assert_eq!(kind("generic_ceiling_0.80"), plastic([0.8; 3]));
    assert_eq!(kind("generic_exterior_shade_0.35"), plastic([0.35; 3]));
    assert_eq!(kind("steel_floor"), MaterialKind::Metal { color: [0.4, 0.4, 0.42], specularity: 0.9, roughness: 0.1 });
    assert_eq!(kind("polished"), MaterialKind::Mirror { color: [0.85; 3] });
    let canvas =
        MaterialKind::Trans { color: [0.6, 0.5, 0.4], specularity: 0.0, roughness: 0.0, transmissivity: 0.3, transmitted_specularity: 0.1 };
    assert_eq!(kind("canvas"), canvas);
    assert_eq!(
        kind("generic_interior_window_vis_0.88"),
        MaterialKind::Glass { transmissivity: [0.9584154328610596; 3], refraction_index: 1.52 }
    );
    let glazing = |name: &str| &model.windows.iter().find(|w| w.window.name == name).unwrap().glazing;
    let pane = |transmissivity: [f64; 3]| ModelGlazing::Glass(crate::scene::Pane { transmissivity, refraction_index: 1.52 });
    assert_eq!(*glazing("south"), pane([0.8, 0.82, 0.79]));
    assert_eq!(*glazing("facade"), pane([0.65; 3]));
    assert_eq!(*glazing("terrace"), pane([0.6975761815384331; 3]));
    assert_eq!(*glazing("west_blind"), ModelGlazing::Bsdf(format!("{}#blind", room().display()).into()));
}

#[test]
fn windows_are_grouped_by_plane_modifier_and_group_and_look_into_their_rooms() {
    let model = read(&room(), &mut Warnings::new()).unwrap();
    let found: Vec<(&str, DVec3, Vec<&str>)> = model
        .windows
        .iter()
        .map(|w| (w.window.name.as_str(), w.window.frame.z, w.apertures.iter().map(String::as_str).collect()))
        .collect();
    let expected: [(&str, DVec3, Vec<&str>); 5] = [
        ("terrace", DVec3::NEG_X, vec!["terrace"]),
        ("south", DVec3::Y, vec!["south_left", "south_right"]),
        ("facade", DVec3::Y, vec!["switchable"]),
        ("west_blind", DVec3::X, vec!["west_blind"]),
        ("roof_light", DVec3::NEG_Z, vec!["roof_light"]),
    ];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (name, normal, apertures) in expected {
        let (_, z, own) = found.iter().find(|(n, ..)| *n == name).unwrap();
        assert!((*z - normal).length() < 1e-9 && *own == apertures, "{name}: {z} {own:?}");
    }
    let blind = &model.windows.iter().find(|w| w.window.name == "west_blind").unwrap().window;
    assert!(blind.basis.len() == 41 && (blind.frame.y - DVec3::Z).length() < 1e-9);
    // Whichever way a model has them.
    let (turned, _) = changed(|m| {
        for face in m["rooms"][0]["faces"].as_array_mut().unwrap() {
            for aperture in face["apertures"].as_array_mut().into_iter().flatten() {
                aperture["geometry"]["boundary"].as_array_mut().unwrap().reverse();
                aperture["geometry"].as_object_mut().unwrap().remove("plane");
            }
        }
    });
    for (a, b) in turned.unwrap().windows.iter().zip(&model.windows) {
        assert!((a.window.frame.z - b.window.frame.z).length() < 1e-9 && a.apertures == b.apertures);
    }
}

#[test]
fn units_become_metres() {
    let metres = read(&room(), &mut Warnings::new()).unwrap();
    for (unit, length) in [("Millimeters", 0.001), ("Inches", 0.0254), ("Feet", 0.3048), ("Centimeters", 0.01)] {
        fn scale(value: &mut Value, by: f64, is_length: bool) {
            match value {
                Value::Number(n) if is_length => *value = (n.as_f64().unwrap() * by).into(),
                Value::Array(items) => items.iter_mut().for_each(|v| scale(v, by, is_length)),
                Value::Object(entries) => {
                    for (key, v) in entries {
                        let own = ["boundary", "holes", "vertices", "pos", "position", "o", "tolerance"].contains(&key.as_str());
                        scale(v, by, own);
                    }
                }
                _ => {}
            }
        }
        let (model, warnings) = changed(|m| {
            scale(m, 1.0 / length, false);
            m["units"] = unit.into();
        });
        let model = model.unwrap();
        assert!(warnings.len() == 1, "{warnings:?}");
        for ((a, (n, x)), (b, (m, y))) in areas(&model).iter().zip(&areas(&metres)) {
            assert!(a == b && n == m && (x - y).abs() < 1e-9 * y, "{unit} {a}: {x} {y}");
        }
        let [a, b] = [&model, &*metres].map(|m| m.sensors[0].sensors[3].position);
        assert!((a - b).length() < 1e-12);
        let point = |m: &Model| m.views[0].options.split(' ').skip(2).take(3).map(|w| w.parse::<f64>().unwrap()).collect::<Vec<_>>();
        for (a, b) in point(&model).iter().zip(point(&metres)) {
            assert!((a - b).abs() < 1e-9, "{unit} {a}");
        }
    }
    // Drawn in millimetres and said to be metres.
    let (model, warnings) = changed(|m| m["units"] = "Millimeters".into());
    assert!(model.is_ok() && warnings.iter().any(|w| w.contains("look like larger ones (Meters)")), "{warnings:?}");
}

#[test]
fn the_two_sides_of_an_inner_wall_have_their_own_colours() {
    let model = read(&room(), &mut Warnings::new()).unwrap();
    let of = |name: &str| {
        let surface = model.scene.surfaces.iter().position(|s| s.name == name).unwrap() as u32;
        let triangle = model.scene.triangles.iter().find(|t| t.surface == surface).unwrap();
        (model.scene.materials[triangle.material.0 as usize].name.clone(), triangle.vertices[0].y)
    };
    assert_eq!(of("Office_Front"), ("light_walls".to_string(), 6.0));
    // Two tolerances within the corridor.
    let (name, y) = of("Corridor_Back");
    assert!(name == "generic_wall_0.50" && (y - 6.02).abs() < 1e-12, "{name} {y}");
    // Its pane and its door are there once.
    for name in ["Corridor_pane", "Corridor_door"] {
        assert!(!model.scene.surfaces.iter().any(|s| s.name == name), "{name}");
    }
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let office = |m: &mut Value| m["rooms"][0].take();
    for (change, words) in [
        (Box::new(|m: &mut Value| m["type"] = "Room".into()) as Box<dyn FnOnce(&mut Value)>, vec!["a Honeybee 'Room', not a Model"]),
        (Box::new(|m| *m = office(m)), vec!["'Room'", "not a Model"]),
        (Box::new(|m| m["units"] = "Furlongs".into()), vec!["units", "no unit 'Furlongs'", "Millimeters"]),
        (Box::new(|m| m["rooms"][0]["faces"] = Value::Null), vec!["rooms[0] 'Office' (Office, south)", "'faces' is missing"]),
        (Box::new(|m| m["rooms"] = 3.into()), vec!["model", "'rooms' is a number, not a list"]),
        (
            Box::new(|m| m["rooms"][0]["faces"][2]["geometry"]["boundary"][1] = "here".into()),
            vec!["rooms[0].faces[2].geometry", "point 1 of 'boundary' is not three numbers"],
        ),
        (
            Box::new(|m| {
                let face = m["rooms"][0]["faces"].as_array().unwrap().iter().position(|f| f["identifier"] == "Office_Back").unwrap();
                m["rooms"][0]["faces"][face]["apertures"][1]["geometry"]["boundary"] = serde_json::json!([[0, 0, 0], [1, 0, 0]]);
            }),
            vec![".apertures[1] 'south_right'", "fewer than three corners"],
        ),
        (
            Box::new(|m| m["orphaned_shades"][1]["properties"]["radiance"]["modifier"] = "velvet".into()),
            vec!["'awning'", "no modifier 'velvet'"],
        ),
        (Box::new(|m| m["rooms"][0]["properties"]["radiance"]["modifier_set"] = "cold".into()), vec!["'Office'", "no modifier set 'cold'"]),
        (
            Box::new(|m| {
                let all = m["properties"]["radiance"]["modifiers"].as_array_mut().unwrap();
                all.iter_mut().find(|f| f["identifier"] == "canvas").unwrap()["type"] = "Plastic2".into();
            }),
            vec!["properties.radiance.modifiers", "'canvas'", "type 'Plastic2'"],
        ),
        (
            Box::new(|m| {
                let all = m["properties"]["radiance"]["modifiers"].as_array_mut().unwrap();
                all.iter_mut().find(|f| f["identifier"] == "blind").unwrap()["bsdf_data"] = "<WindowElement>".into();
            }),
            vec!["modifiers", "'blind'"],
        ),
        (
            Box::new(|m| m["orphaned_shades"][0]["properties"]["radiance"] = serde_json::json!({"modifier": "blind"})),
            vec!["'house'", "is a BSDF"],
        ),
        (
            Box::new(|m| m["properties"]["radiance"]["sensor_grids"][1]["sensors"][4]["dir"] = serde_json::json!([0, 0, 0])),
            vec!["sensor_grids[1].sensors[4]", "no length"],
        ),
        (
            Box::new(|m| m["shade_meshes"][0]["geometry"]["faces"][1][0] = 77.into()),
            vec!["shade_meshes[0] 'hedge'", "face 1 of the mesh names"],
        ),
    ] {
        let (model, _) = changed(change);
        let message = model.map(|_| ()).unwrap_err().to_string();
        assert!(words.iter().all(|w| message.contains(w)) && message.contains("help:"), "{words:?}: {message}");
    }
    for (text, words) in
        [("{\"type\": \"Model\"", "no JSON"), ("[1]", "a list, not a Honeybee model"), ("{}", "no 'type'"), ("PK\x03\x04", "zip archive")]
    {
        let message = read_text(text).0.unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let pickled = read_bytes(b"\x80\x04", Path::new("room.hbpkl"), &mut Warnings::new()).unwrap_err().to_string();
    assert!(pickled.contains("from_hbpkl") && pickled.contains("help:"), "{pickled}");
}

#[test]
fn what_a_run_can_go_on_with_is_told_too() {
    let face = |m: &Value, room: usize, name: &str| {
        m["rooms"][room]["faces"].as_array().unwrap().iter().position(|f| f["identifier"] == name).unwrap()
    };
    let told = |change: Box<dyn FnOnce(&mut Value)>, words: &[&str]| {
        let (model, warnings) = changed(change);
        let found = warnings.iter().any(|w| words.iter().all(|word| w.contains(word)));
        assert!(found, "{words:?}: {warnings:#?}");
        model.unwrap()
    };
    told(Box::new(|m| m["version"] = "3.1.0".into()), &["version", "3.1.0", "newer"]);
    // A room without its roof.
    let open = told(
        Box::new(move |m| {
            let roof = face(m, 0, "Office_Top");
            m["rooms"][0]["faces"].as_array_mut().unwrap().remove(roof);
            // Only a ray to the roof tells; with the floor gone too no ray finds a way.
            let floor = face(m, 0, "Office_Bottom");
            m["rooms"][0]["faces"].as_array_mut().unwrap().remove(floor);
            let north = face(m, 0, "Office_Front");
            m["rooms"][0]["faces"].as_array_mut().unwrap().remove(north);
        }),
        &["'Office'", "do not close it"],
    );
    assert!(open.windows.iter().any(|w| w.window.name == "south" && w.window.frame.z == DVec3::Y));
    // An aperture out of its plane, and one beyond its wall.
    for (shift, words) in [([0.0, 0.1, 0.0], "0.100 m outside the plane"), ([-1.0, 0.0, 0.0], "overlap or reach beyond")] {
        told(
            Box::new(move |m| {
                let wall = face(m, 0, "Office_Back");
                for point in m["rooms"][0]["faces"][wall]["apertures"][0]["geometry"]["boundary"].as_array_mut().unwrap() {
                    for i in 0..3 {
                        point[i] = (point[i].as_f64().unwrap() + shift[i]).into();
                    }
                }
            }),
            &[words],
        );
    }
    // Rooms beside each other whose adjacency is not solved: their panes are one.
    let joined = told(
        Box::new(move |m| {
            for (room, name) in [(0, "Office_Front"), (1, "Corridor_Back")] {
                let wall = face(m, room, name);
                let wall = &mut m["rooms"][room]["faces"][wall];
                wall["boundary_condition"] = serde_json::json!({"type": "Outdoors"});
                for key in ["apertures", "doors"] {
                    wall[key][0]["boundary_condition"] = serde_json::json!({"type": "Outdoors"});
                }
            }
        }),
        &["'Corridor_pane'", "'Office_pane'", "one pane between two rooms"],
    );
    assert_eq!(joined.windows.len(), 5);
    let panes = joined.scene.surfaces.iter().filter(|s| s.name == "Office_pane" || s.name == "Corridor_pane").count();
    assert_eq!(panes, 1);
    // An aperture without a room, which looks south.
    let orphan = told(
        Box::new(move |m| {
            let wall = face(m, 0, "Office_Back");
            let aperture = m["rooms"][0]["faces"][wall]["apertures"][0].clone();
            m["rooms"][0]["faces"][wall]["apertures"].as_array_mut().unwrap().remove(0);
            m["orphaned_apertures"] = serde_json::json!([aperture]);
        }),
        &["1 apertures stand without a face or room", "'south_left'"],
    );
    let south = orphan.windows.iter().find(|w| w.window.name == "south_left").unwrap();
    assert!(south.modifier == "generic_exterior_window_vis_0.64" && south.window.frame.z == DVec3::Y);
    // A neighbour that is not there, an empty grid, a grid with a mesh of another room.
    told(Box::new(|m| _ = m["rooms"].as_array_mut().unwrap().pop()), &["'Corridor_Back'", "not in the model"]);
    told(Box::new(|m| m["properties"]["radiance"]["sensor_grids"][0]["sensors"] = serde_json::json!([])), &["'Workplane'", "no sensors"]);
    told(
        Box::new(|m| _ = m["properties"]["radiance"]["sensor_grids"][0]["sensors"].as_array_mut().unwrap().pop()),
        &["'Workplane'", "24 faces", "23 sensors"],
    );
    // A panel that only a trans lets light through.
    told(
        Box::new(move |m| {
            let wall = face(m, 0, "Office_Left");
            m["rooms"][0]["faces"][wall]["apertures"][0]["properties"]["radiance"]["modifier"] = "canvas".into();
        }),
        &["'west_blind'", "'canvas' is a trans"],
    );
    told(
        Box::new(move |m| {
            let wall = face(m, 0, "Office_Right");
            m["rooms"][0]["faces"][wall]["doors"][0]["properties"]["radiance"] = serde_json::json!({"modifier": {"type": "Void"}});
        }),
        &["'terrace'", "is void"],
    );
}

#[test]
fn a_wall_of_glass_is_a_window_too() {
    let (model, _) = changed(|m| {
        let wall = m["rooms"][0]["faces"].as_array().unwrap().iter().position(|f| f["identifier"] == "Office_Right").unwrap();
        m["rooms"][0]["faces"][wall]["properties"]["radiance"] = serde_json::json!({"modifier": "clear_double"});
    });
    let model = model.unwrap();
    let wall = model.windows.iter().find(|w| w.window.name == "Office_Right").unwrap();
    // 6 m × 2.8 m less the door of 2.08 m².
    assert!((wall.window.area() - 14.72).abs() < 1e-9 && (wall.window.frame.z - DVec3::NEG_X).length() < 1e-9);
    assert!(!model.scene.surfaces.iter().any(|s| s.name == "Office_Right"));
}

#[test]
fn modifiers_and_sets_may_stand_where_they_are_used() {
    let own =
        serde_json::json!({"type": "Plastic", "identifier": "own", "r_reflectance": 0.25, "g_reflectance": 0.5, "b_reflectance": 0.75});
    let (model, _) = changed(|m| {
        m["orphaned_shades"][0]["properties"]["radiance"] = serde_json::json!({"modifier": own});
        m["rooms"][1]["properties"]["radiance"] = serde_json::json!({"modifier_set": {
            "type": "ModifierSet", "identifier": "set", "floor_set": {"type": "FloorModifierSet", "interior_modifier": own}
        }});
    });
    let model = model.unwrap();
    let found = areas(&model);
    // The corridor's floor of 8 m², and the house of 12 m × 7 m.
    assert_eq!(found["own"].0, 2);
    assert!((found["own"].1 - 92.0).abs() < 1e-9 && !found.contains_key("generic_floor_0.20"), "{found:?}");
    // Names that the file does not define, but Honeybee.
    let (model, _) =
        changed(|m| m["orphaned_shades"][0]["properties"]["radiance"] = serde_json::json!({"modifier": "generic_wall_exterior_side_0.35"}));
    assert!((areas(&model.unwrap())["generic_wall_exterior_side_0.35"].1 - 84.0).abs() < 1e-9);
}

#[test]
fn models_that_would_take_gigabytes_of_memory_are_refused() {
    assert!(check_bytes(limits::MODEL_BYTES).is_ok());
    let message = check_bytes(limits::MODEL_BYTES + (1 << 20)).unwrap_err().to_string();
    assert!(message.contains("257 MiB") && message.contains("help:"), "{message}");
}

#[test]
fn types_of_modifiers_in_small_letters_are_those_of_older_schemas() {
    let (model, warnings) = changed(|m| {
        m["version"] = "1.42.0".into();
        for modifier in m["properties"]["radiance"]["modifiers"].as_array_mut().unwrap() {
            let kind = modifier["type"].as_str().unwrap().to_lowercase();
            modifier["type"] = kind.into();
        }
    });
    let (model, as_shipped) = (model.unwrap(), read(&room(), &mut Warnings::new()).unwrap());
    assert_eq!((model.scene.materials.clone(), model.windows.len()), (as_shipped.scene.materials.clone(), as_shipped.windows.len()));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}

#[test]
fn too_many_apertures_are_refused_before_they_cost_hours() {
    let (model, _) = changed(|m| {
        let wall = m["rooms"][0]["faces"].as_array().unwrap().iter().position(|f| f["identifier"] == "Office_Back").unwrap();
        let aperture = m["rooms"][0]["faces"][wall]["apertures"][0].clone();
        m["rooms"][0]["faces"][wall]["apertures"] = Value::Array(vec![aperture; 9000]);
    });
    let message = model.unwrap_err().to_string();
    assert!(message.contains("'Office_Back'") && message.contains("more than 8192 apertures and doors"), "{message}");
}

#[test]
fn the_folder_that_honeybee_radiance_writes_holds_the_same_as_its_model() {
    let mut warnings = Warnings::new();
    let folder = read(&room().with_file_name("model"), &mut warnings).unwrap();
    let model = read(&room(), &mut Warnings::new()).unwrap();
    let (found, expected) = (areas(&folder), areas(&model));
    assert!(found.keys().eq(expected.keys()), "{found:?}");
    for (name, (_, area)) in &found {
        assert!((area - expected[name].1).abs() < 1e-6, "{name}: {area} {:?}", expected[name]);
    }
    let windows = |m: &Model| {
        let mut all: Vec<_> =
            m.windows.iter().map(|w| (w.window.name.clone(), w.apertures.clone(), w.window.frame.z.to_array().map(f64::round))).collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    };
    assert_eq!(windows(&folder), windows(&model));
    let grid = |m: &Model, name: &str| m.sensors.iter().find(|g| g.name == name).unwrap().sensors.clone();
    for name in ["Workplane", "Corridor"] {
        for (a, b) in grid(&folder, name).iter().zip(grid(&model, name)) {
            assert!((a.position - b.position).length() < 1e-9 && a.direction == b.direction);
        }
    }
    assert!(folder.views[0].name == "desk" && folder.views[0].options.starts_with("-vth -vp 2.0 5.0 1.2"), "{}", folder.views[0].options);
    assert_eq!(folder.groups, model.groups);
    let blind = folder.windows.iter().find(|w| w.window.name == "west_blind").unwrap();
    assert!(matches!(&blind.glazing, ModelGlazing::Bsdf(file) if file.ends_with("bsdf/blind.xml")) && blind.window.basis.len() == 41);
    let texts: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert!(
        texts.len() == 1 && texts.iter().any(|t| t.contains("'west_blind' and all others of a BSDF") && t.contains("front outside")),
        "{texts:?}"
    );
    // An empty one.
    let empty = tempfile::tempdir().unwrap();
    std::fs::create_dir(empty.path().join("scene")).unwrap();
    let message = read(empty.path(), &mut Warnings::new()).unwrap_err().to_string();
    assert!(message.contains("nothing in scene/ and aperture/") && message.contains("help:"), "{message}");
}

/// The states of the shipped model's one dynamic aperture, replaced, and another aperture in its group.
fn with_states(m: &mut Value, states: Value) {
    let faces = m["rooms"][0]["faces"].as_array_mut().unwrap();
    let wall = faces.iter_mut().find(|f| f["identifier"] == "Office_Back").unwrap();
    for aperture in wall["apertures"].as_array_mut().unwrap() {
        if aperture["identifier"] == "switchable" {
            aperture["properties"]["radiance"]["states"] = states.clone();
        }
        if aperture["identifier"] == "south_right" {
            aperture["properties"]["radiance"]["dynamic_group_identifier"] = "facade".into();
            aperture["properties"]["radiance"]["states"] =
                serde_json::json!([{"type": "RadianceSubFaceStateAbridged", "modifier": "tint_dark"}, {"modifier": "tint_clear"}]);
        }
    }
}

/// A slat before the switchable pane.
fn slat(modifier: &str) -> Value {
    serde_json::json!({"type": "StateGeometryAbridged", "identifier": "slat", "modifier": modifier, "geometry":
        {"type": "Face3D", "boundary": [[3.0, -0.1, 1.5], [3.8, -0.1, 1.5], [3.8, -0.02, 1.5], [3.0, -0.02, 1.5]]}})
}

fn three_states() -> Value {
    serde_json::json!([
        {"modifier": "tint_clear"},
        {"modifier": "blind", "modifier_direct": "tint_dark", "shades": [slat("light_walls")]},
        {"modifier": "light_walls"}
    ])
}

/// Windows of a group: name, group, and of each state name, modifier and what suns pass.
fn states_of(model: &Model, group: &str) -> Vec<(String, Vec<(String, String, bool)>)> {
    let windows = model.windows.iter().filter(|w| w.group == group);
    let told = |w: &ModelWindow| w.states.iter().map(|s| (s.name.clone(), s.modifier.clone(), s.sun.is_some())).collect();
    windows.map(|w| (w.window.name.clone(), told(w))).collect()
}

#[test]
fn dynamic_groups_become_windows_with_states() {
    let (model, warnings) = changed(|m| with_states(m, three_states()));
    let model = model.unwrap();
    let state = |i: usize, modifier: &str, sun: bool| (format!("{i}_facade"), modifier.to_string(), sun);
    // Objects with fewer states stay in their last one; names and numbers are those of honeybee-radiance's states.json.
    let expected = [
        ("facade-2", vec![state(0, "tint_dark", false), state(1, "tint_clear", false), state(2, "tint_clear", false)]),
        ("facade", vec![state(0, "tint_clear", false), state(1, "blind", true), state(2, "light_walls", false)]),
    ];
    let mut found = states_of(&model, "facade");
    found.sort_by_key(|(_, states)| states[0].1 != "tint_dark");
    for ((name, states), (expected, of)) in found.iter().zip(expected) {
        assert_eq!((states, name.starts_with("facade")), (&of, true), "{expected}");
    }
    assert_eq!((found.len(), model.groups.clone()), (2, vec![("facade".to_string(), 3)]));
    let window = model.windows.iter().find(|w| w.apertures == ["switchable"]).unwrap();
    // The basis of all states is that of the data.
    assert_eq!((window.window.basis.len(), window.modifier.as_str(), &window.sun), (41, "tint_clear", &None));
    assert!(matches!(&window.states[1].glazing, ModelGlazing::Bsdf(data) if data.to_string_lossy().ends_with("#blind")));
    assert_eq!(window.states[2].glazing, ModelGlazing::Glass(crate::scene::Pane { transmissivity: [0.0; 3], refraction_index: 1.52 }));
    let Some(ModelSun::Shade(sun)) = &window.states[1].sun else { panic!("{:?}", window.states[1].sun) };
    let names: Vec<&str> = sun.surfaces.iter().map(|s| s.name.as_str()).collect();
    assert_eq!((names, sun.triangles.len()), (vec!["switchable", "slat"], 4));
    let kind = |i: usize| sun.material(sun.triangles[i].material).kind;
    assert_eq!(kind(0), MaterialKind::Glass { transmissivity: [0.1, 0.12, 0.14], refraction_index: 1.52 });
    assert_eq!(kind(2), MaterialKind::Plastic { color: [0.7, 0.68, 0.6], specularity: 0.0, roughness: 0.0 });
    // The slat is what the data stand for: the scene has it not.
    assert!(model.scene.surfaces.iter().all(|s| s.name != "slat"));
    assert!(warnings.iter().any(|w| w.contains("'light_walls' lets no light through: windows of it are black")), "{warnings:?}");
    assert!(!warnings.iter().any(|w| w.contains("counts in its first state")), "{warnings:?}");
    // Without a pane for the sun it is not traced through the slats, and that is told.
    let (model, warnings) = changed(|m| {
        with_states(m, serde_json::json!([{"modifier": "tint_clear"}, {"modifier": "blind", "shades": [slat("light_walls")]}]));
    });
    assert!(states_of(&model.unwrap(), "facade").iter().all(|(_, states)| states.iter().all(|s| !s.2)));
    assert!(warnings.iter().any(|w| w.contains("not traced through the shades of 'blind'")), "{warnings:?}");
    // Shades of all states are part of the scene.
    let both = serde_json::json!([{"modifier": "tint_clear", "shades": [slat("light_walls")]}, {"modifier": "tint_dark", "shades": [slat("light_walls")]}]);
    let (model, _) = changed(|m| with_states(m, both));
    let model = model.unwrap();
    assert_eq!(model.scene.surfaces.iter().filter(|s| s.name == "slat").count(), 1);
    assert_eq!(states_of(&model, "facade").len(), 2);
}

#[test]
fn groups_that_cannot_move_count_in_their_first_state_and_say_why() {
    let dark = serde_json::json!({"modifier": "tint_dark"});
    for (states, words) in [
        (serde_json::json!([dark, {"modifier": "canvas"}]), "'canvas' of state 1 scatters light as a material of the scene"),
        (serde_json::json!([dark, {"modifier": "tint_clear", "shades": [slat("light_walls")]}]), "state 1 has other shades than state 0"),
    ] {
        let (model, warnings) = changed(|m| with_states(m, states));
        let model = model.unwrap();
        assert!(model.windows.iter().all(|w| w.states.is_empty()), "{words}");
        // Both windows are in one plane and of one modifier.
        let window = model.windows.iter().find(|w| w.apertures.iter().any(|a| a == "switchable")).unwrap();
        assert_eq!((window.modifier.as_str(), window.apertures.len(), window.window.name.as_str()), ("tint_dark", 2, "facade"));
        let told: Vec<&String> =
            warnings.iter().filter(|w| w.contains("'facade' (2 states) counts in its first state: of 'switchable'")).collect();
        assert!(told.len() == 1 && told[0].contains(words), "{warnings:?}");
    }
    // Shades outdoors.
    let (model, warnings) = changed(|m| {
        m["orphaned_shades"][1]["properties"]["radiance"] =
            serde_json::json!({"dynamic_group_identifier": "trees", "states": [{"modifier": "canvas"}, {"modifier": "light_walls"}]});
    });
    let model = model.unwrap();
    assert!(warnings.iter().any(|w| w.contains("groups of shades count in their first state: 'trees' (2 states)")), "{warnings:?}");
    assert!((areas(&model)["canvas"].1 - 1.0).abs() < 1e-9 && model.groups.len() == 2);
    // Groups whose objects never change say nothing.
    let (model, warnings) = changed(|m| with_states(m, serde_json::json!([dark, dark])));
    assert!(model.unwrap().windows.iter().any(|w| w.group == "facade" && w.states.len() == 2), "the other aperture changes");
    assert!(!warnings.iter().any(|w| w.contains("first state")), "{warnings:?}");
}

#[test]
fn a_window_called_as_a_group_gives_way_to_it() {
    let (model, _) = changed(|m| {
        let faces = m["rooms"][0]["faces"].as_array_mut().unwrap();
        let west = faces.iter_mut().find_map(|f| f["apertures"].as_array_mut()?.iter_mut().find(|a| a["identifier"] == "west_blind"));
        west.unwrap()["identifier"] = "Facade".into();
    });
    let model = model.unwrap();
    let name = |aperture: &str| {
        let window = model.windows.iter().find(|w| w.apertures[0] == aperture).unwrap();
        (window.window.name.as_str(), window.group.as_str())
    };
    assert_eq!((name("switchable"), name("Facade")), (("facade", "facade"), ("Facade-2", "Facade-2")));
}

#[test]
fn the_folder_has_the_same_states_as_its_model() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, text).unwrap();
    };
    let pane = "polygon switchable 0 0 12 3 0 .9 3.8 0 .9 3.8 0 2.3 3 0 2.3\n";
    let other = "polygon south_right 0 0 12 2 0 .9 2.8 0 .9 2.8 0 2.3 2 0 2.3\n";
    let slat = "polygon slat 0 0 12 3 -.1 1.5 3.8 -.1 1.5 3.8 -.02 1.5 3 -.02 1.5\n";
    let materials = "void glass tint_clear 0 0 3 .65 .65 .65\nvoid glass tint_dark 0 0 3 .1 .12 .14\nvoid plastic black 0 0 5 0 0 0 0 0\n\
                     void plastic light_walls 0 0 5 .7 .68 .6 0 0\nvoid BSDF blind 6 0 model/bsdf/blind.xml 0 0 1 . 0 0\n";
    std::fs::create_dir_all(folder.path().join("bsdf")).unwrap();
    std::fs::copy(room().with_file_name("model").join("bsdf/blind.xml"), folder.path().join("bsdf/blind.xml")).unwrap();
    write("scene/envelope.rad", &format!("{materials}light_walls polygon floor 0 0 12 0 0 0 4 0 0 4 6 0 0 6 0\n"));
    let file = |kind: &str, number: usize| format!("./facade..{kind}..{number}.rad");
    let state = |n: usize| serde_json::json!({"identifier": format!("{n}_facade"), "default": file("default", n), "direct": file("direct", n), "black": "./facade..black.rad"});
    write("aperture_group/states.json", &serde_json::json!({"facade": [state(0), state(1), state(2)]}).to_string());
    write("aperture_group/facade..black.rad", &format!("{materials}black {pane}black {other}"));
    for (number, [default, direct]) in [
        [format!("tint_clear {pane}tint_dark {other}"), format!("tint_clear {pane}tint_dark {other}")],
        [format!("blind {pane}light_walls {slat}tint_clear {other}"), format!("tint_dark {pane}black {slat}tint_clear {other}")],
        [format!("light_walls {pane}tint_clear {other}"), format!("light_walls {pane}tint_clear {other}")],
    ]
    .into_iter()
    .enumerate()
    {
        write(&format!("aperture_group/facade..default..{number}.rad"), &format!("{materials}{default}"));
        write(&format!("aperture_group/facade..direct..{number}.rad"), &format!("{materials}{direct}"));
    }
    let folder = read(folder.path(), &mut Warnings::new()).unwrap();
    let model = changed(|m| with_states(m, three_states())).0.unwrap();
    let sorted = |m: &Model| {
        let mut all = states_of(m, "facade").into_iter().map(|(_, states)| states).collect::<Vec<_>>();
        all.sort();
        all
    };
    assert_eq!((sorted(&folder), folder.groups.clone()), (sorted(&model), model.groups.clone()));
    let sun = |m: &Model| match &m.windows.iter().find(|w| w.apertures == ["switchable"]).unwrap().states[1].sun {
        Some(ModelSun::Shade(scene)) => (scene.triangles.len(), scene.materials.clone()),
        other => panic!("{other:?}"),
    };
    // The slat keeps its own colour: black is what honeybee-radiance writes where nothing is said.
    assert_eq!(sun(&folder), sun(&model));
}
