use super::*;

/// A room of 4 m × 3 m × 2.5 m as a `.rad` file, with what is added to it.
fn info(more: &str) -> SceneInfo {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.rad");
    let walls = "void plastic wall 0 0 5 .5 .5 .5 0 0\nvoid glass pane 0 0 3 .96 .96 .96\n!genbox wall box 4 3 2.5 -i\n";
    std::fs::write(&file, format!("{walls}{more}\n")).unwrap();
    SceneInfo::read(&[file], &mut Warnings::new()).unwrap()
}

#[test]
fn a_closed_room_has_its_area_and_no_doubts() {
    let found = info("");
    assert_eq!((found.surfaces, found.triangles, found.edges.open, found.edges.turned), (6, 12, 0, 0));
    assert_eq!(found.extent, Some([[0.0; 3], [4.0, 3.0, 2.5]]));
    let [wall] = &found.materials[..] else { panic!("{:?}", found.materials) };
    assert!((wall.area - 59.0).abs() < 1e-9 && wall.surfaces == 6 && wall.kind == "plastic, reflectance 0.500");
    assert!(found.doubts.is_empty(), "{:?}", found.doubts);
    assert!(found.to_string().contains("extent: 4.000 × 3.000 × 2.500"));
}

#[test]
fn where_light_leaks_the_surfaces_are_named_and_where_surfaces_meet_it_does_not() {
    // A partition from wall to wall stands on the middle of the floor, its upper edge 3 m long is free.
    let found = info("wall polygon partition 0 0 12  2 0 0  2 3 0  2 3 1  2 0 1");
    assert!(found.edges.open == 1 && (found.edges.open_length - 3.0).abs() < 1e-9, "{:?}", found.edges);
    assert_eq!(found.edges.open_surfaces[0].name, "partition");
    assert!(found.doubts.len() == 1 && found.doubts[0].contains("'partition' (3.00)"), "{:?}", found.doubts);
    // One that ends 5 mm above the floor.
    let found = info("wall polygon partition 0 0 12  2 0 .005  2 3 .005  2 3 2.5  2 0 2.5");
    assert!((found.edges.open_length - 3.0).abs() < 1e-9, "{:?}", found.edges);
}

#[test]
fn normals_doubles_and_other_units_are_told() {
    let found =
        info("wall polygon table 0 0 12  1 1 .7  2 1 .7  2 2 .7  1 2 .7\nwall polygon again 0 0 12  2 2 .7  2 1 .7  1 1 .7  1 2 .7");
    assert_eq!(found.doubled, [["table".to_string(), "again".to_string()]]);
    assert!(found.doubts.iter().any(|d| d.contains("'table' and 'again'")), "{:?}", found.doubts);
    // A lid whose one half is turned.
    let found = info("wall polygon a 0 0 12  1 1 .7  2 1 .7  2 2 .7  1 2 .7\nwall polygon b 0 0 12  2 1 .7  2 2 .7  3 2 .7  3 1 .7");
    assert!(found.edges.turned == 1 && found.doubts.iter().any(|d| d.contains("opposite ways")), "{:?}", found.edges);
    let scaled = |length: &str| {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("room.rad");
        std::fs::write(&file, format!("void plastic wall 0 0 5 .5 .5 .5 0 0\n!genbox wall box 4 3 2.5 -i | xform -s {length}\n")).unwrap();
        SceneInfo::read(&[file], &mut Warnings::new()).unwrap().doubts
    };
    assert!(scaled("1000")[0].contains("millimetres") && scaled("39.37")[0].contains("inches") && scaled("1").is_empty());
}

#[test]
fn a_model_s_windows_close_its_rooms() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/honeybee_room/room.hbjson");
    let found = SceneInfo::read(&[file], &mut Warnings::new()).unwrap();
    let south = found.windows.iter().find(|w| w.name == "south").unwrap();
    assert!((south.area - 2.8).abs() < 1e-9 && south.faces == [180.0, 0.0] && south.apertures == 2, "{south:?}");
    assert!(south.glazing.contains("clear_double, glass, transmittance 0.7"), "{}", south.glazing);
    assert_eq!(found.sensors, [("Workplane".to_string(), 24), ("Corridor".to_string(), 8)]);
    // Only shades and the corridor's second side of the wall, two tolerances within, have free edges.
    let allowed = ["house", "awning", "hedge", "table", "shelf", "south_left_OutOverhang0", "Corridor_Back"];
    let wrong: Vec<&str> = found.edges.open_surfaces.iter().map(|s| s.name.as_str()).filter(|n| !allowed.contains(n)).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}
