//! Picture sets: what a run exports, imported again and read by Radiance.

use super::*;
use lucarne::image::hdr;
use lucarne::simulate::SunPictures;

const SIZE: usize = 24;

/// A view in the room with blinds, one day; results and the summary.
fn view_of_blinds(folder: &Path, name: &str, view: &str, images: &str, method: &str) -> Result<(Summary, PathBuf)> {
    let header = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
    std::fs::write(folder.join("w.wea"), format!("{header}{}", day(500.0))).unwrap();
    let scene = format!("{SCENES}/blinds");
    let through = if method.contains('5') { shade() } else { String::new() };
    let text = format!(
        "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"{scene}/room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"{scene}/window.rad\"\n\
         bsdf = \"{scene}/blind.xml\"\n{through}\n[[view]]\nname = \"seat\"\nfile = \"{scene}/views/seat.vf\"\n\
         resolution = [{SIZE}, {SIZE}]\n{view}\n[images]\nhours = \"daylight\"\n{images}\n[glare]\n[method]\n{method}\n[quality]\npreset = \"draft\"\n"
    );
    let file = folder.join(format!("{name}.toml"));
    std::fs::write(&file, text).unwrap();
    let project = Project::read(&file)?;
    let mut warnings = Warnings::new();
    let inputs = Inputs::read(&project, &mut warnings)?;
    let out = folder.join(name);
    let summary = run(&Device::shared()?, &project, &inputs, &out, &Silent, &mut warnings)?;
    Ok((summary, out))
}

/// DGP and Ev of every hour.
fn glare_of(out: &Path) -> Vec<[f64; 2]> {
    let text = std::fs::read_to_string(out.join("glare/seat.csv")).unwrap();
    let number = |line: &str, i: usize| line.split(',').nth(i).unwrap().parse::<f64>().unwrap();
    text.lines().skip(1).map(|l| [number(l, 1), number(l, 3)]).collect()
}

#[test]
fn exported_pictures_imported_give_the_same_pictures_and_glare() {
    if device("picture sets").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (_, traced) = view_of_blinds(folder.path(), "traced", "", "components = true", "phases = 5\nsuns = 4").unwrap();
    let set = "view = \"traced/images/seat/components/V%03d.hdr\"\nview_direct = \"traced/images/seat/components/Vd%03d.hdr\"\n\
               sun = \"traced/images/seat/components/C%04d.hdr\"";
    let (_, imported) = view_of_blinds(folder.path(), "imported", set, "", "phases = 5\nsuns = 4").unwrap();
    // Every entry to RGBE's half of a 128th of its largest channel.
    const ENTRY: f32 = 0.0045;
    const PICTURE: f64 = 0.01;
    let same = |a: &[f32], b: &[f32]| {
        let most = a.iter().copied().fold(0.0, f32::max);
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= ENTRY * most), "{a:?} {b:?}");
    };
    for name in ["V_seat", "V_seat_direct"] {
        let [a, b] = [&traced, &imported].map(|out| read_matrix(&out.join(format!("matrices/{name}.mtx"))).unwrap().matrix);
        assert_eq!((a.rows(), a.cols()), (b.rows(), b.cols()));
        a.data().chunks_exact(3).zip(b.data().chunks_exact(3)).for_each(|(a, b)| same(a, b));
    }
    let [a, b] = [&traced, &imported].map(|out| SunPictures::open(&out.join("matrices/C_seat.suns")).unwrap().pictures);
    let mut lit = 0;
    for sun in b.suns() {
        let [a, b] = [&a, &b].map(|pictures| {
            let mut dense = vec![0.0f32; SIZE * SIZE * 3];
            for (pixel, value) in pictures.of_sun(sun, 1.0).unwrap() {
                dense[pixel as usize * 3..][..3].copy_from_slice(&value);
            }
            dense
        });
        lit += a.iter().filter(|v| **v > 0.0).count();
        a.chunks_exact(3).zip(b.chunks_exact(3)).for_each(|(a, b)| same(a, b));
    }
    assert!(lit > 1000);
    // A picture is a sum of such entries, and of differences between them.
    let (mut compared, mut worst) = (0, 0.0f64);
    for entry in std::fs::read_dir(traced.join("images/seat")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "hdr") {
            continue;
        }
        let [a, b] =
            [path.clone(), imported.join("images/seat").join(path.file_name().unwrap())].map(|p| hdr::read(&p).unwrap().luminance());
        let square = |v: &mut dyn Iterator<Item = f32>| v.map(|v| f64::from(v).powi(2)).sum::<f64>();
        let off = square(&mut a.iter().zip(&b).map(|(a, b)| a - b)) / square(&mut a.iter().copied());
        worst = worst.max(off.sqrt());
        compared += 1;
    }
    assert!(worst < PICTURE, "{worst}");
    let pairs: Vec<_> = glare_of(&traced).into_iter().zip(glare_of(&imported)).collect();
    let off = pairs.iter().fold(0.0f64, |most, (a, b)| most.max((a[0] - b[0]).abs()));
    println!("{compared} pictures within {worst:.1e} (rms), DGP within {off:.1e}");
    const DGP: f64 = 2e-3;
    assert!(compared >= 8 && off < DGP);
    for ([_, a], [_, b]) in pairs {
        // The table has hundredths of a lux.
        assert!((a - b).abs() <= 0.004 * a + 0.01, "{a} {b} lx");
    }
    let found = format!("{compared} pictures within {} (rms), DGP within {}", percent(worst), short(off));
    measured("picture-sets", &found, &format!("entries {}, pictures {}, DGP {}", percent(ENTRY.into()), percent(PICTURE), short(DGP)));
    // Nothing of the view was traced, and its noise counts as none.
    let error = |out: &Path| {
        let text = std::fs::read_to_string(out.join("glare/seat.csv")).unwrap();
        text.lines().skip(1).map(|l| l.split(',').nth(2).unwrap().parse::<f64>().unwrap()).sum::<f64>()
    };
    assert!(error(&imported) < error(&traced));

    // Radiance multiplies the sun pictures with a vector of suns.
    let suns = std::fs::read_to_string(traced.join("matrices/suns.rad")).unwrap().matches(" source ").count();
    let pictures = lucarne::image::series::Pattern::parse(&traced.join("images/seat/components/C%04d.hdr").display().to_string()).unwrap();
    assert_eq!(pictures.existing().unwrap().len(), suns);
    let mut vector = format!("#?RADIANCE\nNROWS={suns}\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n");
    (0..suns).for_each(|sun| vector += if sun % 2 == 0 { "1e6 1e6 1e6\n" } else { "0 0 0\n" });
    std::fs::write(folder.path().join("suns.mtx"), vector).unwrap();
    let Some(mut dctimestep) = testing::radiance("dctimestep") else { return };
    dctimestep.current_dir(traced.join("images/seat/components")).args(["C%04d.hdr", "../../../../suns.mtx"]);
    let theirs = hdr::decode(&testing::output(&mut dctimestep), hdr::Exposure::Undo).unwrap();
    let mut ours = vec![0.0f64; SIZE * SIZE];
    for sun in (0..suns).step_by(2) {
        let picture = hdr::read(&pictures.path(sun)).unwrap();
        ours.iter_mut().zip(&picture.pixels).for_each(|(sum, v)| *sum += 1e6 * f64::from(v[1]));
    }
    let most = ours.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.0);
    const SUM: f64 = 0.01;
    let mut worst = 0.0f64;
    for (wanted, found) in ours.iter().zip(&theirs.pixels) {
        let off = (wanted - f64::from(found[1])).abs();
        assert!(off <= SUM * wanted + 1e-6 * most, "{wanted} {found:?}");
        worst = worst.max(off / wanted.max(1e-3 * most));
    }
    measured("sun-pictures-multiplied", &format!("pixels within {}", percent(worst)), &percent(SUM));
}

#[test]
fn wrong_picture_sets_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let complaint = |view: &str, method: &str| view_of_blinds(folder.path(), "wrong", view, "", method).unwrap_err().to_string();
    let message = complaint("view = \"v.hdr\"", "phases = 3");
    assert!(message.contains("no place for the number") && message.contains("view"), "{message}");
    let message = complaint("view = \"v%03d.hdr\"", "phases = 5");
    assert!(message.contains("view_direct") && message.contains("seat"), "{message}");
    let message = complaint("view_direct = \"v%03d.hdr\"", "phases = 5");
    assert!(message.contains("part of pictures 'view'"), "{message}");
    let message = complaint("sun = \"c%04d.hdr\"", "phases = 3");
    assert!(message.contains("only five phases"), "{message}");
    if device("picture sets").is_none() {
        return;
    }
    let message = complaint("view = \"v%03d.hdr\"", "phases = 3");
    assert!(message.contains("v%03d.hdr") && message.contains("no pictures"), "{message}");
    let small = lucarne::image::Picture::new(8, 8, vec![[1.0; 3]; 64]).unwrap();
    (0..145).for_each(|n| hdr::write(&folder.path().join(format!("v{n:03}.hdr")), &small).unwrap());
    let message = complaint("view = \"v%03d.hdr\"", "phases = 3");
    assert!(message.contains("8 × 8") && message.contains("24 × 24") && message.contains("v000.hdr"), "{message}");
    std::fs::remove_file(folder.path().join("v100.hdr")).unwrap();
    let message = complaint("view = \"v%03d.hdr\"", "phases = 3");
    assert!(message.contains("v100.hdr is missing"), "{message}");
    let message = complaint("sun = \"v%03d.hdr\"", "phases = 5\nsuns = 4");
    assert!(message.contains("v100.hdr is missing"), "{message}");
}
