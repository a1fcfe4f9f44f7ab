//! Tracks of markers as the measured values of a validation: the same constants as by numbers, errors that hold, and refusals.

use crate::beam::{STUDY, drop, found, plan, results};
use durometer::math::random::SplitMix;
use durometer::math::tensor::Vec3;
use durometer::study::kinds::validation::budget::COVERAGE;
use durometer::study::kinds::validation::plan::ValidationPlan;
use durometer::study::kinds::validation::spec::Evaluation;
use nalgebra::Rotation3;
use std::fmt::Write;
use std::path::Path;

/// Markers of the base \[mm\], in the frame of the scene.
const BASE: [[f64; 3]; 4] = [[0.0, -60.0, 0.0], [0.0, 70.0, 0.0], [-80.0, 0.0, 10.0], [10.0, 5.0, 90.0]];
/// The tip at rest \[mm\], in the frame of the scene.
const TIP: [f64; 3] = [100.0, 10.0, 20.0];
/// Vibration of the tip: frequency \[Hz\] and decay \[1/s\]
const RINGING: [f64; 2] = [4.0, 5.0];

/// A synthetic robot in front of cameras.
#[derive(Clone, Copy)]
struct Robot {
    /// At the end \[mm\]
    drop: f64,
    /// Standard deviation of a coordinate of a frame \[mm\]
    noise: f64,
    /// Standard deviation of the place of a marker of the base \[mm\]
    misplaced: f64,
    /// \[mm/s\] in the end
    creep: f64,
}

/// A table of tracks in the frame of the cameras: 0.5 s held, then 3 s in motion, at 100 Hz.
fn tracks(robot: Robot, random: &mut SplitMix) -> String {
    let (turn, shift) = (Rotation3::from_euler_angles(0.4, -1.1, 2.0), Vec3::new(900.0, -400.0, 1500.0));
    let misplaced: Vec<Vec3> = BASE.iter().map(|_| Vec3::from_fn(|_, _| robot.misplaced * random.normal())).collect();
    let mut text = String::from("t_s");
    for name in ["a", "b", "c", "d", "tip"] {
        write!(text, ",{name}_x_mm,{name}_y_mm,{name}_z_mm").expect("a string");
    }
    let [f, d] = RINGING;
    for k in 0..350 {
        let t = 0.01 * f64::from(k) - 0.5;
        let s = t.max(0.0);
        let fallen = robot.drop * (1.0 - (-d * s).exp() * (std::f64::consts::TAU * f * s).cos()) + robot.creep * s;
        let tip = Vec3::from(TIP) - Vec3::new(0.1 * fallen, 0.0, fallen);
        write!(text, "\n{t}").expect("a string");
        for p in BASE.iter().zip(&misplaced).map(|(p, m)| Vec3::from(*p) + m).chain([tip]) {
            let seen = turn * p + shift + Vec3::from_fn(|_, _| robot.noise * random.normal());
            write!(text, ",{},{},{}", seen.x, seen.y, seen.z).expect("a string");
        }
    }
    text
}

/// Writes the positions of the base.
fn write_reference(folder: &Path) {
    let row = |(name, p): (&str, &[f64; 3])| format!("{name},{},{},{}\n", p[0], p[1], p[2]);
    let rows: String = ["a", "b", "c", "d"].into_iter().zip(&BASE).map(row).collect();
    std::fs::write(folder.join("base.csv"), format!("marker,x_mm,y_mm,z_mm\n{rows}")).expect("writable");
}

/// The study of the beam with the drops of its calibration records in tracks.
fn with_tracks() -> String {
    let own = |name: &str| {
        format!("purpose = \"calibration\"\ntracks = {{ files = [\"{name}.csv\"], reference = \"base.csv\" }}")
    };
    let purpose = "purpose = \"calibration\"";
    STUDY
        .replacen(&format!("name = \"none\"\n{purpose}"), &format!("name = \"none\"\n{}", own("none")), 1)
        .replacen(&format!("name = \"light\"\n{purpose}"), &format!("name = \"light\"\n{}", own("light")), 1)
        .replace("measured = { none = [2.9, 3.1], light = 5.0 }", "curve = \"tip_z_m\"")
}

fn write_tracks(folder: &Path, name: &str, robot: Robot, random: &mut SplitMix) {
    std::fs::write(folder.join(format!("{name}.csv")), tracks(robot, random)).expect("writable");
}

/// Tracks of a robot whose modulus is 330 kPa, seen by cameras in another frame, give the constants that its drops give as numbers. The errors of
/// the study (0.2 mm of reading) are above those of the tracks (0.02 mm/√300), so that values and intervals agree within 3 % of the interval.
#[test]
fn tracks_calibrate_as_numbers_do() {
    let (folder, mut random) = (tempfile::tempdir().expect("a folder"), SplitMix(3));
    let drops = [("none", 1.0), ("light", 100.0)].map(|(name, load)| (name, drop(load, (330.0, [0.0; 3]), false)));
    write_reference(folder.path());
    for (name, drop) in drops {
        let robot = Robot { drop, noise: 0.02, misplaced: 0.0, creep: 0.0 };
        write_tracks(folder.path(), name, robot, &mut random);
    }
    let by_tracks = plan(folder.path(), &with_tracks()).unwrap_or_else(|e| panic!("{e}"));
    let numbers = format!("measured = {{ none = {}, light = {} }}", drops[0].1, drops[1].1);
    let typed = STUDY.replace("measured = { none = [2.9, 3.1], light = 5.0 }", &numbers);
    let typed = plan(folder.path(), &typed).unwrap_or_else(|e| panic!("{e}"));
    let [a, b] = [&by_tracks, &typed].map(|p| found(&results(p), p));
    let (x, y) = (&a.constants[0], &b.constants[0]);
    let half = y.interval[1] - y.value;
    println!("{} ± {half} kPa by numbers, {} by tracks", y.value, x.value);
    assert!((y.value - 330.0).abs() < 0.03 * half && (x.value - y.value).abs() < 0.03 * half);
    assert!(((x.interval[1] - x.value) / half - 1.0).abs() < 0.03);
    // The prediction has the errors of the tracks by way of the constants
    let groups: Vec<&str> = a.predictions[0].budget.iter().map(|c| c.group.as_str()).collect();
    assert!(groups.contains(&"constants: noise of the tracks") && groups.contains(&"registration"), "{groups:?}");
    let audit: Vec<&String> = a.tracks.iter().flat_map(|t| &t.log).collect();
    for part in ["registered onto base.csv", "held state:", "final state:", "release between"] {
        assert!(audit.iter().any(|line| line.contains(part)), "{part} is missing in {audit:?}");
    }
    assert!(a.sources.iter().any(|(term, ..)| term.contains("tip drop of light (registration)")), "{:?}", a.sources);
}

/// Distance of the value of a record from the truth, in its standard deviations.
fn score(plan: &ValidationPlan, k: usize, truth: f64) -> f64 {
    let q = &plan.quantities[k];
    let variance: f64 = q.by_record["light"].iter().map(|e| e.deviation.powi(2)).sum();
    (q.records["light"][0] - truth) / variance.sqrt()
}

/// 95 % of the intervals contain the truth: 200 records of misplaced reference markers and noise, for a position, a displacement, the frequency and the
/// decay. A share of 95 % of 200 has a standard error of 1.5 %; 90 to 99 % are allowed. Drops and vibrations have a window of 0.2 s to 1.2 s.
#[test]
fn errors_of_tracks_hold() {
    let folder = tempfile::tempdir().expect("a folder");
    write_reference(folder.path());
    let mut random = SplitMix(77);
    let quantity = |name: &str, value: &str, unit: &str, more: &str| {
        format!(
            "[[quantity]]\nname = \"{name}\"\nlabel = \"{name}\"\nsymbol = \"x\"\nunit = \"{unit}\"\ncolumn = \"xmax_z_m\"\nvalue = \"{value}\"\ncurve = \"tip_z_m\"\nrecords = [\"light\"]\n{more}\n"
        )
    };
    let window = "window = [\"0.2 s\", \"1.2 s\"]";
    let all = [
        quantity("height", "final", "mm", ""),
        quantity("change", "change", "mm", ""),
        quantity("frequency", "frequency", "Hz", window),
        quantity("decay", "decay", "1/s", window),
    ];
    // After 1.5 s the vibration is below the noise, with which it would be taken for correlated noise
    let text = with_tracks().replace("tracks = { files = [\"none.csv\"], reference = \"base.csv\" }", "");
    let text = text.replace("files = [\"light.csv\"]", "files = [\"light.csv\"], final = [\"1.5 s\", \"3 s\"]");
    let (head, rest) = text.split_at(text.find("[[quantity]]").expect("a quantity"));
    let family = &rest[rest.find("[[family]]").expect("a family")..];
    let text = format!("{head}{}{family}", all.concat());
    let n = 200;
    let (mut inside, drop) = ([0; 4], 20.0);
    for _ in 0..n {
        write_tracks(folder.path(), "light", Robot { drop, noise: 0.1, misplaced: 0.3, creep: 0.0 }, &mut random);
        let plan = plan(folder.path(), &text).unwrap_or_else(|e| panic!("{e}"));
        let truth = [TIP[2] - drop, -drop, RINGING[0], RINGING[1]];
        for (k, truth) in truth.into_iter().enumerate() {
            inside[k] += usize::from(score(&plan, k, truth).abs() <= COVERAGE);
        }
        let ringing = plan.quantities.iter().filter(|q| q.value == Evaluation::Frequency);
        assert!(ringing.flat_map(|q| &q.by_record["light"]).all(|e| e.group == "noise of the tracks"));
    }
    println!("{inside:?} of {n} intervals contain height, change, frequency and decay");
    assert!(inside.iter().all(|k| (180..=198).contains(k)), "{inside:?} of {n}");
}

/// A slow drift within the tolerance of a plateau is an error of its own, change/√12, and a doubt; with a window in which the tip still moves the study is
/// refused.
#[test]
fn a_drift_is_an_error_or_a_refusal() {
    let folder = tempfile::tempdir().expect("a folder");
    write_reference(folder.path());
    let robot = |creep| Robot { drop: 20.0, noise: 0.01, misplaced: 0.0, creep };
    let mut random = SplitMix(8);
    write_tracks(folder.path(), "none", robot(0.0), &mut random);
    write_tracks(folder.path(), "light", robot(0.02), &mut random);
    let late =
        with_tracks().replace("files = [\"light.csv\"]", "files = [\"light.csv\"], final = [\"1.6 s\", \"3 s\"]");
    let found = plan(folder.path(), &late).unwrap_or_else(|e| panic!("{e}"));
    let drift = found.quantities[0].by_record["light"].iter().find(|e| e.group == "plateau drift").expect("a drift");
    let last = found.tracks.iter().find(|t| t.record == "light").expect("tracks");
    assert!(last.doubts.iter().any(|d| d.contains("tip_z_m, final state")), "{:?}", last.doubts);
    // The slope is known to 0.01 mm √12/(1.39 s √140) = 0.002 mm/s, a tenth of it
    assert!((drift.deviation / (0.02 * 1.39 / 12_f64.sqrt()) - 1.0).abs() < 0.2, "{drift:?}");
    let early = with_tracks().replace(
        "files = [\"light.csv\"]",
        "files = [\"light.csv\"], held = [\"-0.5 s\", \"-0.1 s\"], final = [\"0.2 s\", \"0.3 s\"]",
    );
    let why = plan(folder.path(), &early).expect_err("it moves");
    assert!(why.contains("light: tracks light.csv: the final state of tip_z_m does not rest"), "{why}");
    // 0.3 mm/s over 1.39 s are 0.42 mm, more than twice the tolerance of 0.15 mm (0.5 % of the range with the overshoot), and deviate by 0.12 mm
    write_tracks(folder.path(), "light", robot(0.3), &mut random);
    let why = plan(folder.path(), &late).expect_err("it creeps");
    assert!(why.contains("light: tracks light.csv: the final state of tip_z_m drifts by"), "{why}");
}

/// Every mistake is named with the record it is in.
#[test]
fn mistakes_of_tracks_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    write_reference(folder.path());
    let robot = Robot { drop: 9.0, noise: 0.01, misplaced: 0.0, creep: 0.0 };
    for name in ["none", "light"] {
        write_tracks(folder.path(), name, robot, &mut SplitMix(1));
    }
    std::fs::write(folder.path().join("two.csv"), "marker,x_mm,y_mm,z_mm\na,0,-60,0\nb,0,70,0\n").expect("writable");
    let refused = |from: &str, to: &str, parts: &[&str]| {
        let text = with_tracks();
        assert!(text.contains(from), "{from}");
        let why = plan(folder.path(), &text.replace(from, to)).expect_err("a mistake");
        for part in parts {
            assert!(why.contains(part), "{part} is missing in: {why}");
        }
    };
    refused(
        "tip_z_m",
        "tpi_z_m",
        &["record none: tracks none.csv: there is no curve \"tpi_z_m\"", "record light:", "tip_z_m"],
    );
    refused(
        "reference = \"base.csv\"",
        "reference = \"two.csv\"",
        &["record none: tracks", "three points or more, 2 are given: a, b"],
    );
    refused("files = [\"light.csv\"]", "files = []", &["record light: tracks: there is no file"]);
    refused("\"light.csv\"", "\"dark.csv\"", &["record light: tracks dark.csv:", "cannot be read"]);
    refused(
        "files = [\"light.csv\"]",
        "files = [\"light.csv\"], final = [\"2.9 s\", \"2.93 s\"]",
        &["record light: tracks light.csv:", "samples in 2.9 s to 2.93 s, and 6 are needed"],
    );
    refused(
        "curve = \"tip_z_m\"",
        "measured = { none = 3.0, light = 5.0 }",
        &["record light has tracks, but no quantity of it names a `curve`"],
    );
    refused(
        "curve = \"tip_z_m\"",
        "curve = \"tip_z_m\"\nmeasured = { light = 5.0 }",
        &["quantity drop, record light: its value is in its tracks and is typed in too"],
    );
    refused(
        "files = [\"light.csv\"]",
        "files = [\"light.csv\"], threshold = \"1 kg\"",
        &["record light: tracks: threshold: "],
    );
}

/// A body whose record begins after the motion has no final displacement: from its final state it would be zero by construction. The level of a marker has one.
#[test]
fn a_body_without_a_held_state_has_no_final_value() {
    let folder = tempfile::tempdir().expect("a folder");
    write_reference(folder.path());
    let robot = Robot { drop: 9.0, noise: 0.01, misplaced: 0.0, creep: 0.0 };
    write_tracks(folder.path(), "none", robot, &mut SplitMix(1));
    let text = tracks(robot, &mut SplitMix(2));
    // From 1.5 s after the release on, where the vibration is below the noise
    let rest: Vec<&str> = text.lines().enumerate().filter(|(k, _)| *k == 0 || *k > 200).map(|(_, line)| line).collect();
    std::fs::write(folder.path().join("light.csv"), rest.join("\n")).expect("writable");
    let levels = with_tracks().replace("value = \"change\"", "value = \"final\"");
    let by_marker = plan(folder.path(), &levels).unwrap_or_else(|e| panic!("{e}"));
    let light = by_marker.tracks.iter().find(|t| t.record == "light").expect("tracks");
    assert!(light.doubts.iter().any(|d| d.contains("there is no held state")), "{:?}", light.doubts);
    let body = levels
        .replace(".csv\"], reference", ".csv\"], body = [\"a\", \"b\", \"tip\"], reference")
        .replace("curve = \"tip_z_m\"", "curve = \"displacement_z_m\"");
    let why = plan(folder.path(), &body).expect_err("nothing is held");
    assert!(why.contains("light: tracks light.csv: displacement_z_m has no held state"), "{why}");
}
