//! Weather of a part of a year, in steps of a quarter of an hour: sums are in hours, and everything is
//! numbered by the hour of the year.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::progress::Silent;
use lucarne::simulate::{Inputs, Project, run};
use std::path::Path;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
/// 21 March, 12 o'clock.
const NOON: usize = 79 * 24 + 12;

fn project(folder: &Path, images: &str) -> Project {
    let mut wea =
        "place Test_USA\nlatitude 40.78\nlongitude 73.96\ntime_zone 75\nsite_elevation 40.0\nweather_data_file_units 1\n".to_string();
    for quarter in 0..96 {
        let (direct, diffuse) = if (32..64).contains(&quarter) { (500, 150) } else { (0, 0) };
        wea.push_str(&format!("3 21 {:.3} {direct} {diffuse}\n", 0.25 * f64::from(quarter) + 0.125));
    }
    std::fs::write(folder.join("day.wea"), wea).unwrap();
    std::fs::write(folder.join("eye.vf"), "rvu -vta -vp 1.5 1.5 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180\n").unwrap();
    let scene = format!("{SCENES}/asymmetric");
    let text = format!(
        "[weather]\nfile = \"day.wea\"\n[scene]\nfiles = [\"{scene}/room.rad\"]\n[[window]]\nname = \"south\"\n\
         surface = \"{scene}/window.rad\"\nbsdf = \"{scene}/louvre.xml\"\n[[sensors]]\nname = \"room\"\npoints = \"{scene}/points.txt\"\n\
         [[view]]\nname = \"eye\"\nfile = \"eye.vf\"\nresolution = [16, 16]\n[images]\nhours = {images}\n[glare]\n\
         [method]\nsky_subdivision = 1\n[quality]\npreset = \"draft\"\n"
    );
    std::fs::write(folder.join("project.toml"), text).unwrap();
    Project::read(&folder.join("project.toml")).unwrap()
}

#[test]
fn quarters_of_an_hour_count_as_quarters_and_carry_the_hour_of_the_year() {
    let Some(device) = device("quarter hours") else { return };
    let folder = tempfile::tempdir().unwrap();
    let project = project(folder.path(), &format!("[{NOON}]"));
    let inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    // A folder that looks like a set of pictures is a folder.
    let out = folder.path().join("50%d");
    let summary = run(&device, &project, &inputs, &out, &Silent, &mut Warnings::new()).unwrap();
    assert_eq!((summary.hours, summary.time_steps), (24.0, 96));
    assert_eq!(summary.glare.map(|g| g.hours), Some(8.0));
    assert_eq!(summary.estimated_error.map(|e| e.hours), Some(8.0));
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!((json["hours"].as_u64(), json["time_steps"].as_u64()), (Some(24), Some(96)));

    let text = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let annual = text("glare/annual.csv");
    let rows: Vec<Vec<&str>> = annual.lines().map(|l| l.split(',').collect()).collect();
    let number = |name: &str| rows[1][rows[0].iter().position(|c| *c == name).unwrap()].parse::<f64>().unwrap();
    assert_eq!(number("occupied_hours"), 10.0);
    let classes = ["imperceptible", "perceptible", "disturbing", "intolerable"].map(|c| number(&format!("{c}_hours")));
    assert_eq!(classes.iter().sum::<f64>(), 10.0);
    assert_eq!(number("undecided_hours") * 4.0, (text("glare/undecided.csv").lines().count() - 1) as f64);
    let hours = text("glare/eye.csv");
    assert_eq!(hours.lines().count(), 97);
    assert!(hours.lines().nth(1 + 49).unwrap().starts_with(&format!("{NOON}.2500,")), "{hours}");
    let svg = text("glare/eye.svg");
    assert!(svg.contains("21 Mar") && svg.contains("night") && !svg.contains("not in the weather"), "a carpet of the day");
    let mut pictures: Vec<String> =
        std::fs::read_dir(out.join("images/eye")).unwrap().map(|f| f.unwrap().file_name().to_string_lossy().into_owned()).collect();
    pictures.sort();
    assert_eq!(pictures, ["00", "15", "30", "45"].map(|minute| format!("img_{NOON}{minute}.hdr")));
}

#[test]
fn hours_that_the_weather_lacks_are_refused_before_tracing() {
    let folder = tempfile::tempdir().unwrap();
    for (images, words) in
        [("[12]", "hour 12 of the year (1 January, 12 o'clock) is not in the weather file"), ("[1908, 1908]", "named twice")]
    {
        let message = Inputs::read(&project(folder.path(), images), &mut Warnings::new()).unwrap_err().to_string();
        assert!(message.contains("project.toml:17: images.hours: ") && message.contains(words), "{message}");
        assert!(!words.contains("12 o'clock") || message.contains("the file has hours 1896 to 1919"), "{message}");
    }
}
