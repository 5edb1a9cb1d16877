//! Stored results that cannot be mistaken: damage is noticed, two runs do not share a folder, and what a
//! killed run left half-written goes.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

mod small_project;
#[path = "../src/testing.rs"]
mod testing;

use small_project::{PROJECT, header, lucarne, project, results, run, text, timeless};

#[test]
fn a_flipped_byte_in_any_stored_file_is_noticed_and_the_results_are_the_same() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let first = run(folder.path());
    assert!(first.status.success(), "{}", text(&first));
    let whole = results(folder.path());
    let stored: Vec<&PathBuf> = whole.keys().filter(|f| f.parent().unwrap().ends_with("matrices") && !f.ends_with("suns.rad")).collect();
    assert!(stored.len() >= 19, "kinds of stored files: {stored:?}");

    // In the checksum, behind the header, in the middle, at the end; and a file that is cut.
    let checksum = |bytes: &[u8]| bytes.windows(9).position(|w| w == b"CHECKSUM=").unwrap() + 20;
    let places: [(&str, &dyn Fn(&[u8]) -> usize); 4] =
        [("checksum", &checksum), ("first value", &header), ("middle", &|b| (header(b) + b.len()) / 2), ("last byte", &|b| b.len() - 1)];
    for (name, place) in places {
        for (number, file) in stored.iter().enumerate() {
            let mut bytes = whole[*file].clone();
            let at = place(&bytes);
            bytes[at] ^= 1 << (number % 8);
            fs::write(file, bytes).unwrap();
        }
        let again = run(folder.path());
        let told = text(&again);
        assert!(again.status.success(), "{name}: {told}");
        assert!(told.contains("has changed since it was written") && told.contains("S.mtx"), "{name}: {told}");
        let now = timeless(results(folder.path()));
        assert_eq!(now.keys().collect::<Vec<_>>(), whole.keys().collect::<Vec<_>>(), "{name}");
        for (file, bytes) in &timeless(whole.clone()) {
            assert!(now[file] == *bytes, "{name}: {} differs", file.display());
        }
    }
    for file in &stored {
        fs::write(file, &whole[*file][..whole[*file].len() - 1]).unwrap();
    }
    let again = run(folder.path());
    assert!(again.status.success(), "{}", text(&again));
    assert!(timeless(results(folder.path())) == timeless(whole.clone()));
    // Results that are only looked at are checked too.
    let flip = |name: &str| {
        let file = folder.path().join("out").join(name);
        let good = fs::read(&file).unwrap();
        let mut bytes = good.clone();
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        fs::write(&file, bytes).unwrap();
        let open = || -> lucarne::Result<()> {
            let results = lucarne::simulate::Results::open(&folder.path().join("out"))?;
            results.year.picture("eye", 12).map(|_| ())
        };
        let error = open().expect_err(name).to_string();
        assert!(error.contains("has changed since it was written"), "{name}: {error}");
        fs::write(&file, good).unwrap();
        open().unwrap();
    };
    ["illuminance/room.mtx", "illuminance/room_standard_error.mtx", "matrices/S.mtx", "matrices/D_south_direct.mtx"]
        .into_iter()
        .for_each(flip);
    ["matrices/V_eye.mtx", "matrices/V_eye_direct.mtx", "matrices/C_eye.suns"].into_iter().for_each(flip);
    // Nothing is computed twice where nothing is wrong.
    let quiet = run(folder.path());
    assert!(quiet.status.success() && !text(&quiet).contains("has changed"), "{}", text(&quiet));
    assert!(timeless(results(folder.path())) == timeless(whole.clone()));
}

#[test]
fn two_runs_do_not_share_a_folder_and_leftovers_of_a_killed_one_go() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let out = folder.path().join("out");
    fs::create_dir_all(out.join("matrices")).unwrap();
    let leftover = out.join("matrices/V_room.mtx.123.partial");
    fs::write(&leftover, b"half").unwrap();
    let lock = fs::File::create(out.join(".lock")).unwrap();
    lock.try_lock().unwrap();
    let refused = run(folder.path());
    assert_eq!(refused.status.code(), Some(1), "{}", text(&refused));
    assert!(text(&refused).contains("another run writes into this folder"), "{}", text(&refused));
    assert!(leftover.exists(), "the other run may be writing it");
    drop(lock);
    let run = run(folder.path());
    assert!(run.status.success(), "{}", text(&run));
    assert!(results(folder.path()).keys().all(|f| !f.to_string_lossy().contains("partial")));
}

/// Work that may be killed: a command in a folder, and the results that it must end in.
struct Work {
    name: &'static str,
    folder: tempfile::TempDir,
    arguments: Vec<&'static str>,
}

impl Work {
    fn project(name: &'static str, text: &str) -> Self {
        let folder = project();
        fs::write(folder.path().join("project.toml"), text).unwrap();
        Self { name, folder, arguments: vec!["run", "project.toml", "-o", "out"] }
    }

    /// Slats whose data take some seconds.
    fn generate() -> Self {
        let slats = "width=25mm,spacing=20mm,angle=30,reflectance=0.5";
        let arguments =
            vec!["bsdf", "generate", "--venetian", slats, "--basis", "half", "-c", "4000", "--method", "paths", "-o", "out/blind.xml"];
        Self { name: "bsdf generate", folder: tempfile::tempdir().unwrap(), arguments }
    }

    /// Pictures of 400 hours from a view matrix.
    fn multiply() -> Self {
        use lucarne::matrix::Matrix;
        use lucarne::matrix::file::{Format, write_matrix};
        let folder = tempfile::tempdir().unwrap();
        let (pixels, bins, hours) = (160 * 120, 60, 400);
        let values = |n: usize| (0..n).map(|i| ((i * 7919) % 1013) as f32 / 1013.0).collect::<Vec<f32>>();
        let view = Matrix::from_data(pixels, bins, 3, values(pixels * bins * 3)).unwrap();
        let sky = Matrix::from_data(bins, hours, 3, values(bins * hours * 3)).unwrap();
        let header = ["RESOLUTION=-Y 120 +X 160".to_string(), "VIEW= -vtv -vh 40 -vv 30".to_string()];
        write_matrix(Some(&folder.path().join("V.mtx")), &view, Format::Float, &header).unwrap();
        write_matrix(Some(&folder.path().join("S.mtx")), &sky, Format::Float, &[]).unwrap();
        let arguments = vec!["multiply", "V.mtx", "S.mtx", "-o", "out/img_%04d.hdr", "--memory", "24M", "--device", "native"];
        Self { name: "multiply", folder, arguments }
    }

    /// Pictures whose glare goes into a table.
    fn glare() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let names: Vec<String> = (0..40).map(|n| format!("p{n:02}.hdr")).collect();
        for (n, name) in names.iter().enumerate() {
            let pixel = |i: usize| if (i * 31 + n) % 997 < 3 { [60.0; 3] } else { [2.0 + ((i + n) % 7) as f32; 3] };
            let mut picture = lucarne::image::Picture::new(300, 300, (0..90_000).map(pixel).collect()).unwrap();
            picture.view = Some("-vta -vh 180 -vv 180".into());
            lucarne::image::hdr::write(&folder.path().join(name), &picture).unwrap();
        }
        let mut arguments = vec!["glare", "-d", "-o", "out/glare.csv"];
        arguments.extend(names.into_iter().map(|name| &*name.leak()));
        Self { name: "glare", folder, arguments }
    }

    fn command(&self) -> std::process::Command {
        fs::create_dir_all(self.folder.path().join("out")).unwrap();
        lucarne(self.folder.path(), &self.arguments)
    }

    fn finish(&self) -> std::time::Duration {
        let start = std::time::Instant::now();
        let output = self.command().output().unwrap();
        assert!(output.status.success(), "{}: {}", self.name, text(&output));
        start.elapsed()
    }

    /// Kills it at random moments, and lets it go on each time or after some of them. Returns the most seconds of work
    /// that a kill cost.
    fn killed(&self, kills: usize) -> f64 {
        let length = self.finish();
        let whole = timeless(results(self.folder.path()));
        let out = self.folder.path().join("out");
        fs::remove_dir_all(&out).unwrap();
        // A Weyl sequence: moments all over the run, in no order.
        let (mut moment, mut lost, mut spent) = (0.37f64, 0.0f64, 0.0f64);
        for number in 0..kills {
            moment = (moment + 0.618_034) % 1.0;
            let start = std::time::Instant::now();
            let mut child = self.command().stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            std::thread::sleep(length.mul_f64(moment));
            let signal = ["-KILL", "-TERM", "-INT"][number % 3];
            // It may have ended already.
            let _ = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
            let code = child.wait().unwrap().code();
            assert!([None, Some(0), Some(4)].contains(&code), "{}, {signal}: {code:?}", self.name);
            spent += start.elapsed().as_secs_f64();
            if number % 4 == 3 || number + 1 == kills {
                spent += self.finish().as_secs_f64();
                // What all of them together cost, shared evenly.
                lost = lost.max((spent - length.as_secs_f64()) / (number % 4 + 1) as f64);
                spent = 0.0;
                let now = timeless(results(self.folder.path()));
                assert!(now.keys().eq(whole.keys()), "{}, {signal}: {:?}", self.name, now.keys());
                whole.iter().for_each(|(file, bytes)| assert!(now[file] == *bytes, "{}, {signal}: {} differs", self.name, file.display()));
                fs::remove_dir_all(&out).unwrap();
            }
        }
        lost
    }
}

/// Random kills of each kind of work in a test; many more by `LUCARNE_KILLS`, of all together.
const KILLS: usize = 4;

#[test]
fn work_that_is_killed_ends_in_the_same_results_and_leaves_nothing_behind() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let three = PROJECT.replace("shade = \"slat.rad\"\n", "").replace("\"draft\"", "\"standard\"");
    let works = [
        Work::project("run, five phases", &PROJECT.replace("\"draft\"", "\"standard\"")),
        Work::project("run, three phases", &three),
        Work::generate(),
        Work::multiply(),
        Work::glare(),
    ];
    let asked: Option<usize> = std::env::var("LUCARNE_KILLS").ok().and_then(|n| n.parse().ok());
    let each = asked.map_or(KILLS, |all| all.div_ceil(works.len()));
    let mut most = 0.0f64;
    for work in &works {
        let lost = work.killed(each);
        println!("{}: {each} kills, at most {lost:.1} s lost by one", work.name);
        most = most.max(lost);
    }
    assert!(most <= 30.0, "{most:.1} s of work lost");
    if let Some(all) = asked.filter(|n| *n >= 200) {
        let found = format!("{all} kills: no result differs, nothing is left behind, at most {most:.1} s of work lost by one");
        testing::measured("kills", &found, "0 differ, 30 s");
    }
}

/// Flips of each stored file in a test; more by `LUCARNE_SOAK`.
const FLIPS: usize = 12;

#[test]
fn no_flipped_bit_of_a_stored_file_goes_unnoticed() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let first = run(folder.path());
    assert!(first.status.success(), "{}", text(&first));
    let whole = results(folder.path());
    let sealed: Vec<&PathBuf> = whole.keys().filter(|f| lucarne::files::seal::is_whole(f)).collect();
    // Tables and pictures for people are written anew by each run, and are never read by one.
    let open = |f: &&PathBuf| !["csv", "png", "svg", "hdr", "rad"].iter().any(|e| f.extension().is_some_and(|own| own == *e));
    assert_eq!(sealed, whole.keys().filter(open).collect::<Vec<_>>(), "files without a checksum");
    let each = if std::env::var_os("LUCARNE_SOAK").is_some() { 2000usize.div_ceil(sealed.len()).max(100) } else { FLIPS };
    let mut flips = 0;
    for file in &sealed {
        let bytes = fs::read(file).unwrap();
        let own = header(&bytes).min(bytes.len());
        for number in 0..each {
            // Half of them in the header, where lengths and names stand.
            let part = if number % 2 == 0 { 0..own } else { own..bytes.len() };
            let at = part.start + (number * 7919 + 13) % part.len().max(1);
            let Some(byte) = bytes.get(at) else { continue };
            let mut changed = fs::File::options().write(true).open(file).unwrap();
            let mut put = |byte: u8| {
                std::io::Seek::seek(&mut changed, std::io::SeekFrom::Start(at as u64)).unwrap();
                std::io::Write::write_all(&mut changed, &[byte]).unwrap();
            };
            put(byte ^ (1 << (number % 8)));
            assert!(!lucarne::files::seal::is_whole(file), "{}, byte {at}", file.display());
            put(*byte);
            flips += 1;
        }
        assert!(lucarne::files::seal::is_whole(file));
    }
    if each > FLIPS {
        testing::measured("flips", &format!("{flips} flipped bits in {} files: all noticed", sealed.len()), "0 unnoticed");
    }
}
