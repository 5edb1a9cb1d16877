//! Matrix files: round trips, faults, and what Radiance's programs make of them.

use super::*;
use crate::testing;

fn sample(components: usize) -> Matrix<f64> {
    let data = (0..4 * 3 * components).map(|i| if i == 5 { 0.0 } else { (i as f64 * 0.7).sin() * 10f64.powi(i as i32 % 9 - 4) });
    Matrix::from_data(4, 3, components, data.collect()).unwrap()
}

fn bytes<T: Scalar>(m: &Matrix<T>, format: Format, header: &[String]) -> Vec<u8> {
    let mut out = Vec::new();
    write_matrix_to(&mut out, m, format, header).unwrap();
    out
}

fn error(text: &[u8]) -> String {
    read_matrix_from::<f32>(text).unwrap_err().to_string()
}

#[test]
fn round_trips_are_exact_in_every_format_and_component_count() {
    for components in [1, 3, 4] {
        let exact = sample(components);
        let single = exact.map(|v| v as f32);
        let header = vec!["gendaymtx -m 1".to_string(), "LATLONG= 40 -73".to_string()];
        for format in [Format::Ascii, Format::Float, Format::Double] {
            let back: MatrixFile<f32> = read_matrix_from(bytes(&single, format, &header).as_slice()).unwrap();
            assert_eq!(back.matrix, single, "{format:?}");
            assert_eq!(back.header, header);
            assert_eq!(back.value("LATLONG"), Some("40 -73"));
        }
        for format in [Format::Ascii, Format::Double] {
            let back: MatrixFile<f64> = read_matrix_from(bytes(&exact, format, &[]).as_slice()).unwrap();
            assert_eq!(back.matrix, exact, "{format:?}");
        }
    }
}

#[test]
fn binary_values_start_on_a_multiple_of_their_size() {
    for (format, width) in [(Format::Float, 4), (Format::Double, 8)] {
        for n in 0..9 {
            let out = bytes(&sample(3), format, &["x".repeat(n + 1)]);
            let blank = out.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
            assert_eq!(blank % width, 0);
            assert_eq!(out.len() - blank, 36 * width);
        }
    }
}

#[test]
fn streams_in_small_pieces_and_both_byte_orders_give_the_same() {
    struct Dribble<'a>(&'a [u8], usize);
    impl Read for Dribble<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            self.1 = self.1 % 7 + 1;
            let n = self.1.min(self.0.len()).min(buffer.len());
            buffer[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }
    let m = sample(3);
    for format in [Format::Ascii, Format::Double] {
        let out = bytes(&m, format, &[]);
        assert_eq!(read_matrix_from::<f64>(Dribble(&out, 0)).unwrap().matrix, m);
    }
    let mut big = b"#?RADIANCE\nNCOLS=3\nBigEndian=1\nFORMAT=double\n\n".to_vec();
    big.extend(m.data().iter().flat_map(|v| v.to_be_bytes()));
    assert_eq!(read_matrix_from::<f64>(big.as_slice()).unwrap().matrix, m, "NROWS and NCOMP missing, too");
}

#[test]
fn missing_lines_have_radiances_defaults_and_exposure_is_undone() {
    let m = read_matrix_from::<f32>(&b"NCOLS=2\n\n1 2 3\t4 5 6\n7 8 9\t10 11 12\n"[..]).unwrap().matrix;
    assert_eq!((m.rows(), m.cols(), m.components()), (2, 2, 3));
    let text = b"#?RADIANCE\nrtrace -x\nEXPOSURE=2\nEXPOSURE= 2\nCOLORCORR=1 2 4\nNCOLS=1\nNCOMP=3\nFORMAT=ascii\n\n4 8 16";
    let read = read_matrix_from::<f32>(&text[..]).unwrap();
    assert_eq!(read.matrix.data(), [1.0, 1.0, 1.0]);
    assert_eq!(read.header, ["rtrace -x"]);
}

#[test]
fn faults_are_named_with_their_place() {
    let head = "#?RADIANCE\nNROWS=2\nNCOLS=2\nNCOMP=1\nFORMAT=ascii\n\n";
    let with = |data: &str| error(format!("{head}{data}").as_bytes());
    assert!(with("1 2 3").contains("NROWS: the data end after 3 values (row 2, column 2"), "{}", with("1 2 3"));
    assert!(with("1 2 3 4 5").contains("more values than the 2 rows"));
    assert!(with("1 2\n3 x\n").contains("line 8: 'x' is not a number (row 2, column 2"), "{}", with("1 2\n3 x\n"));
    assert!(with("1 2 nan 4").contains("not finite"));
    assert!(with(&"7".repeat(1000)).contains("is not a number"));
    assert!(error(b"").contains("ends before the empty line"));
    assert!(error(b"\0\0\0\n\n").contains("binary data"));
    assert!(error(b"#?RADIANCE\n\n1 2 3").contains("no NCOLS"));
    assert!(error(b"NCOLS=0\n\n").contains("not a whole number above 0"));
    assert!(error(b"NCOLS=2\nFORMAT=32-bit_rle_rgbe\n\n").contains("a picture"));
    assert!(error(b"NCOLS=2\nFORMAT=half\n\n").contains("unknown format"));
    assert!(error(b"NCOLS=2\nEXPOSURE=0\n\n").contains("above 0"));
    assert!(error(b"NROWS=999999999999999\nNCOLS=999999999999999\n\n1").contains("do not fit into memory"));
    assert!(error(b"NROWS=99999999999\nNCOLS=99999\nFORMAT=float\n\n1234").contains("the data end after 1 values"));
    assert!(error(b"NCOLS=1\nNCOMP=1\nFORMAT=double\n\n123456789").contains("inside a value (1 of 8 bytes)"));
    assert!(error(b"NCOLS=2\nNCOMP=1\n\n1 2 3").contains("do not fill whole rows"));
    assert!(error(&[b'x'; 100_000]).contains("not a Radiance matrix"));
    let mut out = Vec::new();
    assert!(write_matrix_to(&mut out, &sample(1), Format::Ascii, &["a\n\nb".into()]).is_err());
    let huge = Matrix::from_data(1, 1, 1, vec![1e300]).unwrap();
    assert!(write_matrix_to(&mut out, &huge, Format::Float, &[]).is_err());
}

#[test]
fn truncation_and_corruption_never_panic() {
    let whole = bytes(&sample(3), Format::Float, &["line".into()]);
    for n in 0..whole.len() {
        assert!(read_matrix_from::<f32>(&whole[..n]).is_err(), "cut at {n}");
        let mut changed = whole.clone();
        changed[n] = changed[n].wrapping_mul(31).wrapping_add(97);
        let _ = read_matrix_from::<f32>(changed.as_slice());
    }
}

#[test]
fn rmtxop_and_dctimestep_read_ours_and_we_read_theirs() {
    let folder = tempfile::tempdir().unwrap();
    let single = Matrix::from_data(4, 3, 3, sample(3).data().iter().map(|&v| v.abs() as f32).collect()).unwrap();
    for format in [Format::Ascii, Format::Float, Format::Double] {
        let path = folder.path().join(format!("{}.mtx", format.name()));
        write_matrix(Some(&path), &single, format, &["made by hand".into()]).unwrap();
        assert_eq!(read_matrix(&path).unwrap().matrix, single);
        for option in ["-fa", "-ff", "-fd"] {
            let Some(mut rmtxop) = testing::radiance("rmtxop") else { return };
            let theirs = testing::output(rmtxop.arg(option).arg(&path));
            let back: MatrixFile<f32> = read_matrix_from(theirs.as_slice()).unwrap();
            let digits = if option == "-fa" { 1e-7 } else { 0.0 };
            for (a, b) in back.matrix.data().iter().zip(single.data()) {
                assert!((a - b).abs() <= digits * b.abs(), "{option} of {format:?}: {a} {b}");
            }
            assert!(back.header.iter().any(|l| l == "made by hand"));
        }
        // DC · S with S the identity gives DC back.
        let identity = Matrix::from_data(3, 3, 3, (0..27).map(|i| f32::from(i / 3 % 4 == 0)).collect()).unwrap();
        let sky = folder.path().join("identity.mtx");
        write_matrix(Some(&sky), &identity, format, &[]).unwrap();
        let Some(mut dctimestep) = testing::radiance("dctimestep") else { return };
        let theirs = testing::output(dctimestep.arg("-of").arg(&path).arg(&sky));
        assert_eq!(read_matrix_from::<f32>(theirs.as_slice()).unwrap().matrix, single);
    }
}

#[test]
fn exposure_of_a_file_agrees_with_rmtxop() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("e.mtx");
    let text = "#?RADIANCE\nEXPOSURE=1.003\nCOLORCORR=2 .5 4\nNROWS=1\nNCOLS=2\nNCOMP=3\nFORMAT=ascii\n\n1 2 3 4 5 6\n";
    std::fs::write(&path, text).unwrap();
    let Some(mut rmtxop) = testing::radiance("rmtxop") else { return };
    let theirs: MatrixFile<f64> = read_matrix_from(testing::output(rmtxop.arg("-fd").arg(&path)).as_slice()).unwrap();
    let ours = read_matrix_f64(&path).unwrap();
    for (a, b) in ours.matrix.data().iter().zip(theirs.matrix.data()) {
        assert!((a - b).abs() < 1e-6 * b, "{a} {b}");
    }
}
