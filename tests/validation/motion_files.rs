//! Files of measured motion: C3D against files of independent writers, TRC, tables; and what is refused, with its remedy.
//!
//! `tests/motion/c3d/make.py` made the C3D files with the packages ezc3d and c3d of PyPI and checked each one with their readers; `values.csv` has the
//! positions in millimetres as these read them, with empty cells where a marker was not seen.

use durometer::math::tensor::Vec3;
use durometer::motion::body::pose;
use durometer::motion::{BodyRequest, Evaluation, MotionError, MotionRequest, ReadOptions, Tracks, evaluate};
use std::path::{Path, PathBuf};

fn at(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/motion").join(name)
}

fn parse(text: &str) -> Result<Tracks, MotionError> {
    Tracks::parse("a.csv", text.as_bytes(), &ReadOptions::default())
}

fn refused(text: &str) -> String {
    parse(text).expect_err("must be refused").to_string()
}

const FILES: [&str; 8] = [
    "ezc3d_float",
    "c3d_float",
    "intel_float",
    "intel_integer",
    "dec_float",
    "dec_integer",
    "mips_float",
    "mips_integer",
];

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(at(&format!("c3d/{name}.c3d"))).expect("a file of this test")
}

#[test]
fn c3d_files_of_all_byte_orders_have_the_values_of_other_readers() {
    let text = std::fs::read_to_string(at("c3d/values.csv")).expect("a file of this test");
    let expected: Vec<Vec<Option<f64>>> =
        text.lines().map(|l| l.split(',').map(|c| c.parse().ok()).collect()).collect();
    for name in FILES {
        let tracks =
            Tracks::read(&at(&format!("c3d/{name}.c3d")), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let labels: Vec<&str> = tracks.markers.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(labels, ["tip1", "tip2", "base 1"], "{name}");
        assert_eq!(tracks.time_s.len(), expected.len(), "{name}");
        assert!((tracks.time_s[19] - 19.0 / 120.0).abs() < 1e-12, "{name}: {:?}", tracks.time_s);
        for (row, values) in expected.iter().enumerate() {
            for (k, marker) in tracks.markers.iter().enumerate() {
                for axis in 0..3 {
                    let found = marker.points[row].map(|p| 1e3 * p[axis]);
                    let truth = values[3 * k + axis];
                    // Floats have 24 bits: 120 mm to 1e-5 mm
                    let same = found.zip(truth).is_none_or(|(a, b)| (a - b).abs() < 1e-5);
                    assert!(found.is_some() == truth.is_some() && same, "{name} {row} {k} {axis}: {found:?} {truth:?}");
                }
            }
        }
        assert!(tracks.log.iter().any(|l| l.contains("tip2 is not seen in 3 of 20 rows")), "{name}: {:?}", tracks.log);
    }
}

#[test]
fn damaged_c3d_files_are_refused() {
    let read = |b: &[u8], o: &ReadOptions| Tracks::parse("a.c3d", b, o);
    let fact = |b: &[u8]| read(b, &ReadOptions::default()).expect_err("must be refused").to_string();
    let sound = bytes("intel_integer");
    let with = |at: usize, new: &[u8]| {
        let mut b = sound.clone();
        b[at..at + new.len()].copy_from_slice(new);
        b
    };
    assert!(fact(&sound[..1400]).contains("announces 20 frames"), "{}", fact(&sound[..1400]));
    // Points in the header; the last frame before the first; data beyond the end
    assert!(fact(&with(2, &[200, 0])).contains("200 points"));
    assert!(fact(&with(8, &[0, 0])).contains("before the first"));
    // Frames counted from zero
    assert_eq!(read(&with(6, &[0, 0, 19, 0]), &ReadOptions::default()).expect("20 frames").time_s.len(), 20);
    // Where the data begin, the parameters say too
    assert!(read(&with(16, &[0; 4]), &ReadOptions::default()).is_ok_and(|tracks| tracks.markers.len() == 3));
    let label = sound.windows(4).position(|w| w == b"RATE").expect("a rate") + 8;
    let mut zero = with(label, &[0; 4]);
    zero[20..24].fill(0);
    assert!(fact(&zero).contains("--rate"), "{}", fact(&zero));
    let given = ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() };
    assert!((read(&zero, &given).expect("with a rate").time_s[1] - 0.02).abs() < 1e-15);
    let unit = sound.windows(5).position(|w| w == b"UNITS").expect("units") + 10;
    assert!(fact(&with(unit, b"  ")).contains("--unit"), "{}", fact(&with(unit, b"  ")));
    assert!(fact(&with(unit, b"km")).contains("no unit of length"), "{}", fact(&with(unit, b"km")));
    assert!(fact(&with(unit, b"m ")).contains("off by 1000"), "{}", fact(&with(unit, b"m ")));
}

/// Labels that occur twice get numbers that no other label has, with a line that says so; the points stay those of the file.
#[test]
fn equal_labels_are_numbered() {
    let sound = bytes("intel_integer");
    let plain = Tracks::parse("a.c3d", &sound, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let with = |labels: [&str; 3]| {
        let mut b = sound.clone();
        let first = b.windows(4).position(|w| w == b"tip1").expect("the first label");
        let second = b.windows(4).position(|w| w == b"tip2").expect("the second label");
        for (k, label) in labels.iter().enumerate() {
            let at = first + k * (second - first);
            b[at..second - first + at].fill(b' ');
            b[at..at + label.len()].copy_from_slice(label.as_bytes());
        }
        let tracks = Tracks::parse("a.c3d", &b, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let names: Vec<String> = tracks.markers.iter().map(|m| m.name.clone()).collect();
        assert!(tracks.markers.iter().zip(&plain.markers).all(|(a, b)| a.points == b.points));
        (names, tracks.log.join("\n"))
    };
    let (names, log) = with(["tip", "tip", "tip"]);
    assert_eq!(names, ["tip", "tip 2", "tip 3"]);
    assert!(log.contains("\"tip\" occurs 3 times; after the first the points are named \"tip 2\", \"tip 3\""), "{log}");
    assert_eq!(with(["t", "t", "t 2"]).0, ["t", "t 3", "t 2"]);
}

/// The header says how many analog numbers a frame has; a rate that is no multiple of that of the points does not tell. A file without a processor is one of
/// C3D that is damaged, not a text.
#[test]
fn analog_numbers_of_a_frame_are_those_of_the_header() {
    let sound = bytes("intel_float");
    let plain = Tracks::parse("a.c3d", &sound, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let word = |k: usize| usize::from(u16::from_le_bytes([sound[2 * k - 2], sound[2 * k - 1]]));
    let (start, own) = (512 * (word(9) - 1), word(3));
    let mut b = sound[..start].to_vec();
    // 17 more, of which no ratio of rates tells
    b[4..6].copy_from_slice(&(own as u16 + 17).to_le_bytes());
    for frame in sound[start..].chunks_exact((3 * 4 + own) * 4).take(20) {
        b.extend(frame);
        b.extend([7_u8; 17 * 4]);
    }
    let found = Tracks::parse("a.c3d", &b, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(found.markers, plain.markers);
    let mut empty = vec![0; 1024];
    empty[..2].copy_from_slice(&[2, 0x50]);
    let why = Tracks::parse("a.c3d", &empty, &ReadOptions::default()).expect_err("nothing is in it").to_string();
    assert!(why.contains("the C3D file is damaged: processor 0"), "{why}");
}

/// A marker that is hidden in the final state has no such state, which is said; the others have theirs. A window in which no marker is seen is refused.
#[test]
fn a_hidden_marker_does_not_refuse_the_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = String::from("t_s,tip_x_mm,tip_y_mm,tip_z_mm,side_x_mm,side_y_mm,side_z_mm\n");
    for k in 0..200 {
        let (t, fallen) = (0.01 * f64::from(k), if k < 60 { 0.0 } else { 5.0 });
        let side = if k < 62 { format!("3,4,{}", 20.0 - 0.1 * fallen) } else { ",,".into() };
        text += &format!("{t},1,2,{},{side}\n", 30.0 - fallen + 1e-4 * f64::from(k).sin());
    }
    let file = folder.path().join("hidden.csv");
    std::fs::write(&file, text).expect("writable");
    let found =
        evaluate(&MotionRequest { file: file.clone(), ..MotionRequest::default() }).unwrap_or_else(|e| panic!("{e}"));
    let of = |name: &str| found.curves.iter().find(|c| c.curve.name == name).expect("a curve");
    let change = of("tip_z_m").change.expect("both states");
    assert!((change.value + 0.005).abs() < 1e-7 && of("side_z_m").held.is_some() && of("side_z_m").last.is_none());
    // Two rows of the final window are seen, and six are needed
    assert!(found.doubts.iter().any(|d| d.starts_with("side_z_m: ") && d.contains("are needed")), "{:?}", found.doubts);
    let late = MotionRequest { file, final_s: Some([5.0, 6.0]), ..MotionRequest::default() };
    assert!(evaluate(&late).expect_err("nothing is seen").to_string().contains("0 samples in 5 s to 6 s"));
}

/// Every byte of a small file changed in turn, and every length: an answer or a refusal, never a panic.
#[test]
fn no_single_change_of_a_c3d_file_ends_the_program() {
    for name in ["intel_integer", "dec_float", "ezc3d_float"] {
        let sound = bytes(name);
        for at in 0..sound.len() {
            for value in [0, 1, 127, 128, 255] {
                let mut b = sound.clone();
                b[at] = value;
                Tracks::parse("a.c3d", &b, &ReadOptions::default()).ok();
            }
            Tracks::parse("a.c3d", &sound[..at], &ReadOptions::default()).ok();
        }
    }
}

const TRC: &str = "PathFileType\t4\t(X/Y/Z)\ta.trc\n\
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
100.00\t100.00\t3\t2\tmm\t100.00\t1\t3\n\
Frame#\tTime\ttip1\t\t\tbase\t\t\n\
\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\
\n\
1\t0.000\t100.5\t-20.25\t3\t1\t2\t3\n\
2\t0.010\t\t\t\t1\t2\t3.5\n\
3\t0.020\t101.5\t-21\t4\tnan\tnan\tnan\n";

#[test]
fn a_trc_file_is_read() {
    let t = Tracks::parse("a.trc", TRC.as_bytes(), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(t.time_s, [0.0, 0.01, 0.02]);
    assert_eq!(t.markers[0].name, "tip1");
    let near = |p: Option<[f64; 3]>, mm: [f64; 3]| p.is_some_and(|p| (0..3).all(|k| (1e3 * p[k] - mm[k]).abs() < 1e-9));
    assert!(near(t.markers[0].points[0], [100.5, -20.25, 3.0]) && near(t.markers[1].points[1], [1.0, 2.0, 3.5]));
    assert!(t.markers[0].points[1].is_none() && t.markers[1].points[2].is_none());
    assert_eq!(t.log.iter().filter(|l| l.contains("not seen")).count(), 2, "{:?}", t.log);
    let fact =
        |text: &str| Tracks::parse("a.trc", text.as_bytes(), &ReadOptions::default()).expect_err("refused").to_string();
    assert!(fact(&TRC.replace("\t3\t2\tmm", "\t9\t2\tmm")).contains("announces 9 frames"));
    assert!(fact(&TRC.replace("\t3\t2\tmm", "\t3\t7\tmm")).contains("announces 7 markers"));
    assert!(fact(&TRC.replace("base", "tip1")).contains("occurs twice"));
    assert!(fact(&TRC.replace("Units", "Other")).contains("--unit"));
    assert!(
        fact(&TRC.replace("0.020", "0.010")).contains("do not increase in 1 lines: 9"),
        "{}",
        fact(&TRC.replace("0.020", "0.010"))
    );
    assert!(fact(&TRC.replace("101.5", "x")).contains("line 9 \"x\""));
    let rate =
        Tracks::parse("a.trc", TRC.replace("100.00\t100.00\t3", "50.00\t50.00\t3").as_bytes(), &ReadOptions::default());
    assert!(rate.expect("read").log.iter().any(|l| l.contains("the times count")));
}

#[test]
fn tables_of_several_spellings_are_one() {
    let same = [
        "t_s,a_x_mm,a_y_mm,a_z_mm\n0,1.5,2,3\n0.5,4,5,6\n",
        "t_s;a_x_mm;a_y_mm;a_z_mm\n0;1,5;2;3\n0,5;4;5;6\n",
        "Time (ms)\ta X [mm]\ta Y [mm]\ta Z [mm]\n0\t1.5\t2\t3\n500\t4\t5\t6\n",
        "exported today\ntime,a:X,a:Y,a:Z\n(s),(mm),(mm),(mm)\n0,1.5,2,3\n0.5,4,5,6\n",
        "marker,t_s,x_mm,y_mm,z_mm\na,0,1.5,2,3\na,0.5,4,5,6\n",
    ];
    for text in same {
        let t = parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!((t.markers.len(), t.markers[0].name.as_str(), &t.time_s[..]), (1, "a", &[0.0, 0.5][..]), "{text}");
        let [p, q] = [0, 1].map(|k| t.markers[0].points[k].expect("seen").map(|x| 1e3 * x));
        assert!((p[0] - 1.5).abs() < 1e-12 && (q[2] - 6.0).abs() < 1e-12, "{text}: {p:?} {q:?}");
    }
}

/// With a rate the rows of each marker are its frames, in blocks or in turn, also where the file has times, and a marker without some of them is refused.
#[test]
fn frames_of_a_table_with_one_row_per_marker_have_a_rate() {
    let read = |text: &str| {
        Tracks::parse("a.csv", text.as_bytes(), &ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() })
    };
    for text in [
        "marker,x_mm,y_mm,z_mm\na,1,2,3\na,4,5,6\nb,7,8,9\nb,,,\n",
        "marker,x_mm,y_mm,z_mm\na,1,2,3\nb,7,8,9\na,4,5,6\nb,,,\n",
        "marker,t_s,x_mm,y_mm,z_mm\na,7,1,2,3\nb,7,7,8,9\na,9,4,5,6\nb,9,,,\n",
    ] {
        let tracks = read(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(tracks.time_s, [0.0, 0.02], "{text}");
        let z = |k: usize| tracks.markers[k].points.iter().map(|p| p.map(|p| (1e3 * p[2]).round())).collect::<Vec<_>>();
        assert_eq!((z(0), z(1)), (vec![Some(3.0), Some(6.0)], vec![Some(9.0), None]), "{text}");
    }
    let why = read("marker,x_mm,y_mm,z_mm\na,1,2,3\na,4,5,6\nb,7,8,9\n").expect_err("a row is missing").to_string();
    assert!(why.contains("(a 2, b 1)") && why.contains("three empty cells"), "{why}");
}

#[test]
fn a_record_of_a_table_with_several_is_chosen() {
    let text = "record,marker,x_m,y_m,z_m,n_samples\nr1,a,0.1,0,0,8\nr1,b,0,0.2,0,8\nr2,a,0.3,0,0,9\nr2,b,0,0.4,0,9\n";
    assert!(refused(text).contains("--record"), "{}", refused(text));
    let read = |record: &str| {
        Tracks::parse("a.csv", text.as_bytes(), &ReadOptions { record: Some(record.into()), ..ReadOptions::default() })
    };
    let found = read("r2").expect("known");
    assert_eq!((found.markers[1].points[0], found.samples[0]), (Some([0.0, 0.4, 0.0]), 9.0));
    assert!(read("r3").expect_err("unknown").to_string().contains("known: r1, r2"));
}

#[test]
fn tables_that_are_no_tracks_are_refused_with_a_remedy() {
    for (text, fact) in [
        ("", "no names"),
        ("t_s,force_N\n0,1\n", "names columns of markers"),
        ("t_s,a_x,a_y,a_z\n0,1,2,3\n", "--unit mm"),
        ("t_s,a_x_mm,a_y_mm\n0,1,2\n", "names columns of markers"),
        ("t_s,a_x_mm,a_y_mm,a_z_mm,b_x_mm\n0,1,2,3,4\n", "without a coordinate: b"),
        ("t_s,a_x_mm,a_y_cm,a_z_mm\n0,1,2,3\n", "different units: cm, mm"),
        ("t_s,a_x_m,a_y_m,a_z_m\n0,150,2,3\n1,151,2,3\n", "off by 1000"),
        ("t_s,a_x_um,a_y_um,a_z_um\n0,0.1,0.2,0.3\n", "off by 1000"),
        ("t_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,3\n0,1,2,3\n1,1,2,3\n1,2,2,2\n", "in 2 lines: 3, 5"),
        ("t_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,q\n1,w,2,3\n", "2 cells are no numbers: line 2 \"q\", line 3 \"w\""),
        (
            "t_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,q\nw,1,2,3\n",
            "1 times are no numbers: line 3 \"w\"; write them in seconds, or pass --rate",
        ),
        (
            "t_s,a_x_mm,a_y_mm,a_z_mm\n0,1,,3\n",
            "1 positions have one or two coordinates of three: line 2 (1, –, 3); complete them",
        ),
        ("t_s,a_x_mm,a_y_mm,a_z_mm,a_z_mm\n0,1,2,3,4\n", "column \"a_z_mm\" occurs twice"),
        ("t_s,a_x_mm,a_y_mm,a_z_mm,a Z (mm)\n0,1,2,3,4\n", "column \"a Z (mm)\" occurs twice"),
        ("t_s,t_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,3,4\n", "column \"t_s\" occurs twice"),
        (
            "t_s,a_x_mm,a_y_mm,a_z_mm\n0,90,2,3\n1,91,2,3\n2,0,0,0\n3,92,2,3\n4,91,2,3\n5,90,2,3\n",
            "marker a is at exactly 0, 0, 0 in 1 of 6 rows",
        ),
        ("marker,t_s,x_mm,y_mm,z_mm\na,0,1,2,3\na,0,1,2,3\n", "occurs twice at 0 s"),
        ("t_s,a_x_mm,a_y_mm,a_z_mm\n", "holds no marker"),
    ] {
        assert!(refused(text).contains(fact), "{text}: {}", refused(text));
    }
}

/// A marker that rests at the origin and leaves it is seen there. Rows a second apart are probably of times in another unit.
#[test]
fn zeros_at_rest_and_times_in_milliseconds() {
    let row = |k: u32| format!("{k},0,0,{}\n", -0.5 * f64::from(k.saturating_sub(9)).powi(2));
    let text = format!("time,a_x_mm,a_y_mm,a_z_mm\n{}", (0..40).map(row).collect::<String>());
    assert!(parse(&text).is_ok_and(|t| t.markers[0].points.iter().all(Option::is_some)));
    let lost = |k: u32| if (10..14).contains(&k) { format!("{k},0,0,0\n") } else { format!("{k},100,0,{k}\n") };
    let lost = format!("time,a_x_mm,a_y_mm,a_z_mm\n{}", (0..40).map(lost).collect::<String>());
    let refused = parse(&lost).expect_err("zeros in place of gaps").to_string();
    assert!(refused.contains("marker a is at exactly 0, 0, 0 in 4 of 40 rows"), "{refused}");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("ms.csv");
    std::fs::write(&file, text).expect("writable");
    let request = MotionRequest { file, ring_down: Some(("a_z_m".into(), [0.1, 2.0])), ..MotionRequest::default() };
    let why = evaluate(&request).expect_err("few rows").to_string();
    assert!(why.contains("its rows are 1 s apart; state the unit of the times with --time-unit"), "{why}");
}

/// Two markers of three that exchange their names from the fourth row on.
#[test]
fn markers_that_swap_are_named() {
    let mut text = String::from("t_s,a_x_mm,a_y_mm,a_z_mm,b_x_mm,b_y_mm,b_z_mm,c_x_mm,c_y_mm,c_z_mm\n");
    for k in 0..8 {
        let (a, b) = (format!("{k},0,0"), format!("{},50,0", k));
        let (a, b) = if k < 4 { (a, b) } else { (b, a) };
        text += &format!("{},{a},{b},{k},20,40\n", 0.1 * f64::from(k));
    }
    let tracks = parse(&text).expect("sound");
    let names = ["a", "b", "c"].map(String::from);
    let reference: Vec<Vec3> = [[0.0, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.02, 0.04]].map(Vec3::from).to_vec();
    let fact = pose(&tracks, &names, &reference).expect_err("swapped").to_string();
    assert!(fact.contains("1 exchange of markers: a and b at 0.4 s"), "{fact}");
    let unknown = pose(&tracks, &["a".into(), "q".into(), "r".into()], &reference).expect_err("unknown").to_string();
    assert!(unknown.contains("no markers q, r"), "{unknown}");
    assert!(pose(&tracks, &names[..2], &reference[..2]).expect_err("two").to_string().contains("three points or more"));
}

/// The tip of the beam with names that go round, with a marker that is knocked off by 10 mm, and with one that is taken for a distant one.
#[test]
fn markers_that_go_round_or_are_knocked_are_named() {
    let sound = Tracks::read(&at("gravity_a.csv"), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let from = sound.time_s.iter().position(|t| *t >= 0.905).expect("a row");
    let folder = tempfile::tempdir().expect("a folder");
    let found = |change: &dyn Fn(usize, [[f64; 3]; 3]) -> [[f64; 3]; 3]| {
        let mut text =
            String::from("t_s,n_avg,tip1_x_m,tip1_y_m,tip1_z_m,tip2_x_m,tip2_y_m,tip2_z_m,tip3_x_m,tip3_y_m,tip3_z_m");
        for (k, time) in sound.time_s.iter().enumerate() {
            let points = change(k, [0, 1, 2].map(|m: usize| sound.markers[m].points[k].expect("seen")));
            let cells: Vec<String> = points.as_flattened().iter().map(f64::to_string).collect();
            text += &format!("\n{time},{},{}", sound.samples[k], cells.join(","));
        }
        let file = folder.path().join("changed.csv");
        std::fs::write(&file, text).expect("writable");
        let body = BodyRequest { markers: ["tip1", "tip2", "tip3"].map(String::from).to_vec(), at: None };
        evaluate(&MotionRequest { file, body: Some(body), ..MotionRequest::default() })
    };
    let doubts = |why: Result<Evaluation, MotionError>| why.unwrap_or_else(|e| panic!("{e}")).doubts.join("\n");
    let plain = doubts(found(&|_, p| p));
    assert!(!plain.contains("jumps") && !plain.contains("not rigid"), "{plain}");
    for (round, names) in [([1, 2, 0], "tip1, tip3 and tip2 at "), ([2, 0, 1], "tip1, tip2 and tip3 at ")] {
        let why =
            found(&|k, p| if k < from { p } else { round.map(|m: usize| p[m]) }).expect_err("exchanged").to_string();
        assert!(why.contains(names) && why.contains("0.91 s"), "{why}");
    }
    let moved = |shift: f64| {
        move |k: usize, mut p: [[f64; 3]; 3]| {
            p[2][0] += if k < from { 0.0 } else { shift };
            p
        }
    };
    let knocked = doubts(found(&moved(0.0105)));
    assert!(knocked.contains("marker tip3 jumps by 10.") && knocked.contains(" at 0.91 s"), "{knocked}");
    // 0.1 m away it is another marker, and the group is far from rigid
    let other = doubts(found(&moved(0.1005)));
    assert!(other.contains("jumps by 100.") && other.contains("it is not rigid"), "{other}");
}

/// Four markers off a plane whose y has the other sign in the record: no rotation reaches the reference. The sign of any coordinate brings it back, and a
/// record in the same hand is read in any orientation.
#[test]
fn a_mirrored_record_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let known = [[0.0, 0.0, 0.0], [60.0, 5.0, 0.0], [0.0, 60.0, 10.0], [20.0, 20.0, 45.0]];
    let table = |sign: [f64; 3], times: &[f64]| {
        let row = |t: &f64| {
            let one = |(k, p): (usize, &[f64; 3])| {
                let p = [0, 1, 2].map(|i| sign[i] * (p[i] + 0.2 * (3.0 * k as f64 + i as f64 + 40.0 * t).sin()));
                format!("{},{t},{},{},{}\n", ["a", "b", "c", "d"][k], p[0], p[1], p[2])
            };
            known.iter().enumerate().map(one).collect::<String>()
        };
        format!("marker,t_s,x_mm,y_mm,z_mm\n{}", times.iter().map(row).collect::<String>())
    };
    let [file, reference] = ["record.csv", "known.csv"].map(|name| folder.path().join(name));
    let rows = known.iter().zip(["a", "b", "c", "d"]).map(|(p, n)| format!("{n},{},{},{}\n", p[0], p[1], p[2]));
    std::fs::write(&reference, format!("marker,x_mm,y_mm,z_mm\n{}", rows.collect::<String>())).expect("writable");
    let times: Vec<f64> = (0..60).map(|k| 0.01 * f64::from(k)).collect();
    let evaluated = |sign: [f64; 3]| {
        std::fs::write(&file, table(sign, &times)).expect("writable");
        evaluate(&MotionRequest {
            file: file.clone(),
            reference: Some(reference.clone()),
            held_s: None,
            final_s: Some([0.0, 0.5]),
            ..MotionRequest::default()
        })
    };
    for sign in [[1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, -1.0]] {
        let why = evaluated(sign).expect_err("mirrored").to_string();
        assert!(why.contains("fits known.csv as its mirror image") && why.contains("sign of one coordinate"), "{why}");
    }
    for sign in [[1.0; 3], [-1.0, -1.0, 1.0]] {
        let registration = evaluated(sign).unwrap_or_else(|e| panic!("{e}")).registration.expect("registered");
        assert!(registration.rms < 3e-4 && registration.mirrored_rms.is_none(), "{registration:?}");
    }
}

/// The same record cut at 1 s, while the beam swings: it is held as in the whole one, and nothing is final. From the middle of the
/// motion on nothing is held.
#[test]
fn a_record_that_ends_in_motion_has_a_held_state() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(at("gravity_a.csv")).expect("a table");
    let (names, rows) = text.split_once('\n').expect("rows");
    let between = |from: f64, to: f64| {
        let time =
            |row: &&str| row.split(',').next().and_then(|t| t.parse().ok()).is_some_and(|t| from <= t && t <= to);
        let kept: Vec<&str> = std::iter::once(names).chain(rows.lines().filter(time)).collect();
        let file = folder.path().join("part.csv");
        std::fs::write(&file, kept.join("\n")).expect("writable");
        evaluate(&MotionRequest { file, ..MotionRequest::default() }).unwrap_or_else(|e| panic!("{e}"))
    };
    let whole = between(f64::NEG_INFINITY, f64::INFINITY);
    let released = whole.release.expect("released").time_s;
    let cut = between(f64::NEG_INFINITY, 1.0);
    let z = cut.curves.iter().find(|c| c.curve.name == "tip1_z_m").expect("a curve");
    let held = z.held.as_ref().unwrap_or_else(|| panic!("held: {}", cut.log.join("\n")));
    assert!(held.window_s[0] == -0.3 && held.window_s[1].abs() < 0.03 && held.deviation < 1e-4, "{held:?}");
    assert!((cut.release.expect("released").time_s - released).abs() < 0.015 && z.last.is_none());
    assert!(!cut.doubts.iter().any(|d| d.contains("no state is held")), "{:?}", cut.doubts);
    // From the second swing on to the fourth
    let swing = between(0.1, 0.45);
    assert!(swing.release.is_none() && swing.curves.iter().all(|c| c.held.is_none() && c.last.is_none()));
    assert!(swing.doubts.iter().any(|d| d.contains("neither begins nor ends within")), "{:?}", swing.doubts);
}

/// Repeats of which one ends in motion are pooled over the others, with their number; a copy is no repeat, in whatever unit; and refusals name the file.
#[test]
fn repeats_are_counted_and_copies_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(at("gravity_b.csv")).expect("a table");
    let (names, rows) = text.split_once('\n').expect("rows");
    let rows = || rows.lines().map(|row| row.split(',').map(|c| c.parse().expect("a number")).collect::<Vec<f64>>());
    let write = |name: &str, names: String, rows: Vec<Vec<f64>>| {
        let lines = rows.iter().map(|r| r.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
        let path = folder.path().join(name);
        std::fs::write(&path, format!("{names}\n{}", lines.collect::<Vec<_>>().join("\n"))).expect("writable");
        path
    };
    let cut = write("cut.csv", names.into(), rows().filter(|r| r[0] < 1.0).collect());
    let centimetres = |r: Vec<f64>| r.iter().enumerate().map(|(k, x)| if k < 2 { *x } else { 100.0 * x }).collect();
    let copy = write("copy.csv", names.replace("_m", "_cm"), rows().map(centimetres).collect());
    let out = folder.path().join("out");
    let motion = |files: &[&Path], more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_durometer"));
        command.arg("motion").args(files).args(more).arg("--replace").arg("--out").arg(&out);
        let done = command.output().expect("the program runs");
        (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
    };
    let [a, b] = ["gravity_a.csv", "gravity_b.csv"].map(at);
    // The first file need not have the quantity
    for files in [[&a, &b, &cut], [&cut, &a, &b]] {
        let (code, said) = motion(&files.map(|f| &**f), &["--body", "tip1,tip2,tip3"]);
        let table = std::fs::read_to_string(out.join("repeats.csv")).expect("a table");
        assert!(code == Some(0) && table.contains("displacement_z_m,mm,2 of 3,-6."), "{said}\n{table}");
    }
    let (code, said) = motion(&[&a, &b, &copy], &[]);
    assert!(code == Some(2) && said.contains("hold the same positions"), "{said}");
    assert!(said.contains("gravity_b.csv and ") && said.contains("copy.csv hold"), "{said}");
    let (code, said) = motion(&[&a, &cut], &["--ring-down", "tip1_z_m", "--window", "1.5 s,2 s"]);
    assert!(code == Some(2) && said.contains("cut.csv: the curve has 0 samples"), "{said}");
}

/// Records of one name in several folders have files and rows of their own, also where a number after the name makes that of a third one.
#[test]
fn records_of_one_name_are_kept_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b] = ["gravity_a.csv", "gravity_b.csv"].map(|name| std::fs::read_to_string(at(name)).expect("a table"));
    let short: Vec<&str> = b.lines().take(b.lines().count() - 20).collect();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.arg("motion");
    for (name, text) in [("a/x.csv", &a), ("b/x.csv", &b), ("c/x-2.csv", &short.join("\n"))] {
        let path = folder.path().join(name);
        std::fs::create_dir(path.parent().expect("a folder")).expect("writable");
        std::fs::write(&path, text).expect("writable");
        command.arg(path);
    }
    let out = folder.path().join("out");
    let done = command.arg("--out").arg(&out).output().expect("the program runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let curves = ["x-curves.csv", "x-3-curves.csv", "x-2-curves.csv"].map(read);
    assert!(curves[0] != curves[1] && curves[1].len() > curves[2].len(), "{curves:?}");
    let table = read("states.csv");
    let mut records: Vec<&str> = table.lines().skip(1).filter_map(|row| row.split(',').next()).collect();
    records.dedup();
    assert_eq!(records, ["x", "x-3", "x-2"], "{table}");
    assert!(read("audit.txt").contains("b/x.csv, called x-3 here\n"));
    assert!(["x", "x-2", "x-3"].iter().all(|name| out.join(format!("figures/{name}.svg")).is_file()));
}

#[test]
fn a_measured_beam_is_evaluated_and_its_decisions_are_written_down() {
    let body = BodyRequest {
        markers: ["tip1", "tip2", "tip3"].map(String::from).to_vec(),
        at: Some(Vec3::new(0.1, 0.0, 0.0)),
    };
    let request = MotionRequest {
        file: at("gravity_a.csv"),
        body: Some(body),
        ring_down: Some(("displacement_z_m".into(), [0.3, 1.6])),
        ..MotionRequest::default()
    };
    let found = evaluate(&request).unwrap_or_else(|e| panic!("{e}"));
    let log = found.log.join("\n");
    println!("{log}\n{}", found.doubts.join("\n"));
    for fact in
        ["coordinates in m", "100.0", "3 markers", "held state: ", "final state: ", "release between", "frequency 7.7"]
    {
        assert!(log.contains(fact), "{fact}: {log}");
    }
    let z = found.curves.iter().find(|c| c.curve.name == "displacement_z_m").expect("followed");
    let change = z.change.expect("two states");
    assert!((1e3 * change.value + 6.45).abs() < 0.05 && change.half_width() < 1e-4, "{change:?}");
    let other = MotionRequest { ring_down: Some(("q".into(), [0.3, 1.6])), ..request };
    assert!(evaluate(&other).expect_err("no such curve").to_string().contains("displacement_x_m"));
}

/// A record is chosen in every kind of table, or the option is refused; with a rate, times follow the numbers of the frames; rows of one time are means of
/// one number of samples.
#[test]
fn options_and_columns_count_or_are_refused() {
    let read = |file: &str, text: &str, options: ReadOptions| Tracks::parse(file, text.as_bytes(), &options);
    let record = |name: &str| ReadOptions { record: Some(name.into()), ..ReadOptions::default() };
    let rate = || ReadOptions { rate_hz: Some(50.0), ..ReadOptions::default() };
    let why = |found: Result<Tracks, MotionError>| found.expect_err("must be refused").to_string();
    let wide = "t_s,trial,a_x_mm,a_y_mm,a_z_mm\n0,p,1,2,3\n1,p,1,2,4\n2,q,1,2,5\n";
    assert_eq!(read("a.csv", wide, record("q")).expect("known").time_s, [2.0]);
    assert!(why(read("a.csv", wide, ReadOptions::default())).contains("--record"));
    assert!(why(read("a.csv", wide, record("r"))).contains("known: p, q"));
    assert!(why(read("a.csv", "t_s,a_x_mm,a_y_mm,a_z_mm\n0,1,2,3\n", record("q"))).contains("leave it out"));
    assert!(why(read("a.trc", TRC, record("q"))).contains("--record has no meaning"));
    let time_unit = ReadOptions { time_unit: Some("ms".into()), ..ReadOptions::default() };
    assert!(why(read("a.trc", TRC, time_unit)).contains("--time-unit has no meaning"));
    let frames = "frame,a_x_mm,a_y_mm,a_z_mm\n5,1,2,3\n6,1,2,4\n9,1,2,5\n";
    assert_eq!(read("a.csv", frames, rate()).expect("numbered").time_s, [0.0, 0.02, 0.08]);
    let back = frames.replace("9,", "6,");
    assert!(why(read("a.csv", &back, rate())).contains("numbers of the frames do not increase"));
    assert_eq!(
        read("a.trc", &TRC.replace("\n3\t0.020", "\n5\t0.020"), rate()).expect("numbered").time_s,
        [0.0, 0.02, 0.08]
    );
    let lost = "marker,frame,x_mm,y_mm,z_mm\na,1,1,2,3\na,3,4,5,6\nb,3,7,8,9\n";
    let lost = read("a.csv", lost, rate()).expect("numbered");
    assert!(lost.time_s == [0.0, 0.04] && lost.markers[1].points[0].is_none());
    let uneven = "marker,t_s,n_avg,x_mm,y_mm,z_mm\na,0,1,1,2,3\nb,0,1,1,2,3\na,1,1,1,2,3\nb,1,9,1,2,3\n";
    assert!(refused(uneven).contains("another number of samples") && refused(uneven).contains(": 5;"));
}

/// A reflection that is seen in few rows far away, and one row of a marker at rest that is far off, leave states, change and release as they are without them. A
/// record without a release has no ring-down.
#[test]
fn a_reflection_or_an_outlier_does_not_decide_the_states() {
    let folder = tempfile::tempdir().expect("a folder");
    let found = |name: &str, from: u32, other: &dyn Fn(u32) -> String, ring_down| {
        let mut text = String::from("t_s,tip_x_mm,tip_y_mm,tip_z_mm,base_x_mm,base_y_mm,base_z_mm\n");
        for k in from..400 {
            let s = 0.01 * f64::from(k.max(100) - 100);
            let z = -6.5 * (1.0 - (-3.0 * s).exp() * (20.0 * s).cos()) + 0.01 * (1.7 * f64::from(k).powi(2)).sin();
            text += &format!("{},1,2,{z},{}\n", 0.01 * f64::from(k), other(k));
        }
        let file = folder.path().join(name);
        std::fs::write(&file, text).expect("writable");
        evaluate(&MotionRequest { file, ring_down, ..MotionRequest::default() })
    };
    let change = |e: &Evaluation| e.curves.iter().find(|c| c.curve.name == "tip_z_m").expect("a curve").change;
    let sound = found("a.csv", 0, &|k| format!("5,6,{}", 0.01 * f64::from(k % 3)), None).expect("sound");
    let spike = |k: u32| format!("5,6,{}", if k == 300 { 900.0 } else { 0.01 * f64::from(k % 3) });
    let ghost = |k: u32| if (200..230).contains(&k) { format!("{k},6,7") } else { ",,".into() };
    for other in [&spike as &dyn Fn(u32) -> String, &ghost] {
        let e = found("b.csv", 0, other, None).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(change(&e), change(&sound));
        assert_eq!(e.release, sound.release);
    }
    let ring = Some(("tip_z_m".to_string(), [0.05, 1.0]));
    // The last rows, which are at rest
    let why = found("c.csv", 330, &|_| ",,".into(), ring).map(|e| e.release).expect_err("no release").to_string();
    assert!(why.contains("there was no release") && why.contains("--held"), "{why}");
}
