//! Names with numbers, and sets of pictures as matrices.

use super::*;
use crate::image::Picture;
use crate::testing::{output, radiance};

#[test]
fn patterns() {
    let name = |pattern: &str, n: usize| Pattern::parse(pattern).unwrap().path(n).to_string_lossy().into_owned();
    assert_eq!(name("v%03d.hdr", 7), "v007.hdr");
    assert_eq!(name("dir/img_%04d.hdr", 12345), "dir/img_12345.hdr");
    assert_eq!(name("%d", 0), "0");
    assert_eq!(name("a%3db%%c.hdr", 5), "a  5b%c.hdr");
    assert!(Pattern::is_pattern("v%d.hdr") && !Pattern::is_pattern("v.hdr") && !Pattern::is_pattern("100%%.hdr"));
    for bad in ["v.hdr", "v%s.hdr", "v%", "v%3", "v%d%d.hdr", "v%999999999999999999999999d.hdr", "v%-3d"] {
        assert!(Pattern::parse(bad).is_err(), "{bad}");
    }
}

fn component(n: usize, width: usize, height: usize) -> Picture {
    let pixels = (0..width * height).map(|i| [n as f32 + 0.5, i as f32 + 1.0, (n * i) as f32]).collect();
    let mut picture = Picture::new(width, height, pixels).unwrap();
    picture.view = Some("-vta -vh 180 -vv 180".into());
    picture
}

fn pattern(folder: &tempfile::TempDir) -> Pattern {
    Pattern::parse(&folder.path().join("v%02d.hdr").to_string_lossy()).unwrap()
}

#[test]
fn a_set_is_a_matrix_in_any_tiling() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = pattern(&folder);
    let (width, height, count) = (21, 10, 35);
    for n in 0..count {
        hdr::write(&pattern.path(n), &component(n, width, height)).unwrap();
    }
    let set = PictureSet::open(&pattern, Some(count), Exposure::Undo).unwrap();
    assert_eq!((set.len(), set.width(), set.height(), set.view()), (count, width, height, Some("-vta -vh 180 -vv 180")));
    let read = |rows: usize| {
        let (mut all, mut block, mut stream) = (Vec::new(), Vec::new(), set.rows());
        while stream.read(rows, &mut block).unwrap() > 0 {
            all.extend_from_slice(&block);
        }
        all
    };
    let whole = read(100);
    assert_eq!(whole.len(), width * height * count * 3);
    assert_eq!(read(3), whole);
    for n in [0, 7, 34] {
        let picture = hdr::read(&pattern.path(n)).unwrap();
        for (pixel, values) in picture.pixels.iter().enumerate() {
            assert_eq!(whole[(pixel * count + n) * 3..][..3], *values);
        }
    }
    // And back again, in other tiles: the same bytes.
    let copy = Pattern::parse(&folder.path().join("copy%d.hdr").to_string_lossy()).unwrap();
    let mut writer = SetWriter::create(&copy, count, [width, height], set.view(), |_| Vec::new()).unwrap();
    for rows in whole.chunks(width * count * 3 * 4) {
        writer.write(rows).unwrap();
    }
    assert!(copy.existing().unwrap().is_empty(), "nothing before the end");
    writer.finish().unwrap();
    for n in 0..count {
        assert_eq!(std::fs::read(copy.path(n)).unwrap(), std::fs::read(pattern.path(n)).unwrap());
    }
    let mut writer = SetWriter::create(&copy, 3, [width, height], None, |_| Vec::new()).unwrap();
    writer.write(&vec![1.0; width * 9]).unwrap();
    assert!(writer.finish().unwrap_err().to_string().contains("1 of 10 rows"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2 * count, "no partial files");
}

#[test]
fn incomplete_sets_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = pattern(&folder);
    let open = |count| PictureSet::open(&pattern, count, Exposure::Undo).map(|_| ()).map_err(|e| e.to_string());
    assert!(open(None).unwrap_err().contains("v00.hdr"));
    for n in [0, 1, 3] {
        hdr::write(&pattern.path(n), &component(n, 20, 4)).unwrap();
    }
    std::fs::write(folder.path().join("v2.hdr"), "another pattern").unwrap();
    assert!(open(None).unwrap_err().contains("v02.hdr is missing"));
    hdr::write(&pattern.path(2), &component(2, 4, 20)).unwrap();
    assert!(open(None).unwrap_err().contains("4 × 20 pixels"));
    hdr::write(&pattern.path(2), &component(2, 20, 4)).unwrap();
    open(None).unwrap();
    assert!(open(Some(145)).unwrap_err().contains("4 pictures instead of 145"));
    let bytes = std::fs::read(pattern.path(2)).unwrap();
    std::fs::write(pattern.path(2), &bytes[..bytes.len() - 5]).unwrap();
    let set = PictureSet::open(&pattern, None, Exposure::Undo).unwrap();
    let error = set.rows().read(4, &mut Vec::new()).unwrap_err().to_string();
    assert!(error.contains("v02.hdr") && error.contains("scanline 4 of 4"), "{error}");
    let text = String::from_utf8_lossy(&bytes).replace("-Y 4 +X 20", "-Y 4 -X 20");
    assert!(text.contains("-X 20"));
    std::fs::write(pattern.path(2), text.as_bytes()).unwrap();
    assert!(open(None).unwrap_err().contains("-Y +X"));
}

/// The set as a view matrix gives the picture that dctimestep makes of it.
#[test]
fn the_matrix_is_dctimesteps() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = pattern(&folder);
    for n in 0..5 {
        hdr::write(&pattern.path(n), &component(n, 24, 6)).unwrap();
    }
    let weights = [0.25f32, 0.0, 1.5, 3.0, 0.125];
    let text: String = weights.iter().map(|w| format!("{w} {} {}\n", 2.0 * w, 0.5 * w)).collect();
    let sky = folder.path().join("sky.mtx");
    std::fs::write(&sky, format!("#?RADIANCE\nNROWS=5\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n{text}")).unwrap();
    let Some(mut dctimestep) = radiance("dctimestep") else { return };
    let theirs = hdr::decode(&output(dctimestep.arg(pattern.to_string()).arg(&sky)), Exposure::Undo).unwrap();
    let mut matrix = Vec::new();
    let set = PictureSet::open(&pattern, None, Exposure::Keep).unwrap();
    assert_eq!(set.rows().read(6, &mut matrix).unwrap(), 6);
    let pixels = matrix
        .chunks_exact(15)
        .map(|row| {
            let mut sum = [0.0; 3];
            for (v, w) in row.chunks_exact(3).zip(weights) {
                sum = [sum[0] + v[0] * w, sum[1] + v[1] * 2.0 * w, sum[2] + v[2] * 0.5 * w];
            }
            sum
        })
        .collect();
    let ours = hdr::decode(&hdr::encode(&Picture::new(24, 6, pixels).unwrap()).unwrap(), Exposure::Undo).unwrap();
    for (a, b) in ours.pixels.iter().zip(&theirs.pixels) {
        let step = a[0].max(a[1]).max(a[2]) / 128.0;
        // Sums in another order may fall on the other side of one mantissa step.
        assert!((0..3).all(|i| (a[i] - b[i]).abs() <= step), "{a:?} {b:?}");
    }
    let same = ours.pixels.iter().zip(&theirs.pixels).filter(|(a, b)| a == b).count();
    assert!(same >= 140, "{same} of 144 pixels are identical");
}
