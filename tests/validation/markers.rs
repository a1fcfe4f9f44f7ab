//! `[[compare.markers]]`: recorded points over measured tracks of markers, by the program on files.

use crate::common::program::durometer;
use durometer::math::tensor::Vec3;
use nalgebra::Rotation3;
use std::fmt::Write;
use std::path::Path;

/// A beam that a ramp of gravity bends, with a point at its tip and one at mid-length.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["100 mm", "20 mm", "20 mm"], divisions = [4, 1, 1] }

[laws.rubber]
law = "neo_hookean"
E = "300 kPa"
nu = 0.3

[[effect]]
kind = "elastic"
region = "body"
law = "rubber"

[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "1 s" }

[[constraint]]
kind = "fixed"
region = "xmin"

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.125 s"

[[probe]]
kind = "markers"
name = "face"
points = [["100 mm", "10 mm", "20 mm"], ["50 mm", "10 mm", "20 mm"]]
"#;

const COMPARED: &str = r#"
[[compare.markers]]
file = "capture.csv"
points = { tip = "face_1", middle = "face_2" }
reference = "base.csv"
held = ["-0.5 s", "0 s"]
"#;

/// Markers of the base \[m\].
const BASE: [[f64; 3]; 4] = [[0.0, -0.06, 0.0], [0.0, 0.07, 0.0], [-0.08, 0.0, 0.01], [0.01, 0.005, 0.09]];

fn simulate(folder: &Path, scene: &str, words: &[&str]) -> (Option<i32>, String) {
    std::fs::write(folder.join("scene.toml"), scene).expect("writable");
    durometer(folder, &[words, &["scene.toml"]].concat()).code_and_said()
}

/// Rows of `t, x₁, y₁, z₁, x₂, …` of the run.
fn rows(folder: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(folder.join("out/scene.csv")).expect("a series");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let wanted = ["t_s", "face_1_x_m", "face_1_y_m", "face_1_z_m", "face_2_x_m", "face_2_y_m", "face_2_z_m"];
    let places = wanted.map(|w| names.iter().position(|n| *n == w).unwrap_or_else(|| panic!("{w} of {names:?}")));
    lines
        .map(|l| l.split(',').collect::<Vec<_>>())
        .map(|l| places.map(|k| l[k].parse().expect("a number")).to_vec())
        .collect()
}

/// Tracks in the frame of the cameras \[mm\], which start 12 s after their clock and are held until 12.5 s. The tip is off by 3 mm in y and 4 mm in z, the middle
/// by 2 mm in x at the end alone.
fn write_tracks(folder: &Path, run: &[Vec<f64>]) {
    let (turn, shift) = (Rotation3::from_euler_angles(0.4, -1.1, 2.0), Vec3::new(0.9, -0.4, 1.5));
    let mut text = String::from("t_s");
    for name in ["a", "b", "c", "d", "tip", "middle"] {
        write!(text, ",{name}_x_mm,{name}_y_mm,{name}_z_mm").expect("a string");
    }
    let held = (0..50).map(|k| (0.01 * f64::from(k) - 0.5, &run[0]));
    for (number, (t, row)) in held.chain(run.iter().map(|r| (r[0], r))).enumerate() {
        let off = [Vec3::new(0.0, 0.003, 0.004), Vec3::new(if t == 1.0 { 0.002 } else { 0.0 }, 0.0, 0.0)];
        let seen = [0, 1].map(|k| Vec3::from_row_slice(&row[1 + 3 * k..4 + 3 * k]) + off[k]);
        // A tenth of a micrometre of noise, by which the held state has a deviation
        let noise = 1e-7 * (1.7 * number as f64).sin();
        write!(text, "\n{t}").expect("a string");
        for p in BASE.map(Vec3::from).into_iter().chain(seen) {
            let p = 1e3 * (turn * (p + Vec3::repeat(noise)) + shift);
            write!(text, ",{},{},{}", p.x, p.y, p.z).expect("a string");
        }
    }
    std::fs::write(folder.join("capture.csv"), text).expect("writable");
    let row = |(name, p): (&str, &[f64; 3])| format!("{name},{},{},{}\n", p[0], p[1], p[2]);
    let base: String = ["a", "b", "c", "d"].into_iter().zip(&BASE).map(row).collect();
    std::fs::write(folder.join("base.csv"), format!("marker,x_m,y_m,z_m\n{base}")).expect("writable");
}

/// The distances are those that the tracks were made with: 5 mm always, and 2 mm in the last of nine rows, 2/√9 mm rms. The release is found where the tip
/// leaves the held state, and `start` says the same.
#[test]
fn distances_are_those_that_the_tracks_were_made_with() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, out) = simulate(folder.path(), SCENE, &["simulate", "--out", "out"]);
    assert_eq!(code, Some(0), "{out}");
    let run = rows(folder.path());
    assert_eq!(run.len(), 9);
    write_tracks(folder.path(), &run);
    for more in ["", "start = \"0 s\"\n"] {
        let (code, out) = simulate(folder.path(), &format!("{SCENE}{COMPARED}{more}"), &["simulate", "--out", "out"]);
        assert_eq!(code, Some(0), "{out}");
        assert!(out.contains("tip of capture.csv is off face_1 by 5.000 mm (rms), 5.00"), "{out}");
        assert!(
            out.contains(
                "middle of capture.csv is off face_2 by 0.667 mm (rms), 2.000 mm at 1.000 s (largest), over 9 rows"
            ),
            "{out}"
        );
        let record = std::fs::read(folder.path().join("out/scene.json")).expect("a record");
        let record: serde_json::Value = serde_json::from_slice(&record).expect("JSON");
        let middle = &record["markers"][0];
        assert_eq!((middle["marker"].as_str(), middle["rows"].as_u64()), (Some("middle"), Some(9)));
        assert!((middle["largest_m"].as_f64().expect("a number") - 0.002).abs() < 2e-6);
        for ending in ["svg", "png", "pdf"] {
            assert!(folder.path().join(format!("out/scene-markers-1.{ending}")).is_file(), "{ending}");
        }
    }
}

/// The report of a study has the distances of every case in a table.
#[test]
fn the_report_of_a_study_has_the_distances_of_its_cases() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, out) = simulate(folder.path(), SCENE, &["simulate", "--out", "out"]);
    assert_eq!(code, Some(0), "{out}");
    write_tracks(folder.path(), &rows(folder.path()));
    std::fs::write(folder.path().join("scene.toml"), format!("{SCENE}{COMPARED}")).expect("writable");
    let study = "kind = \"convergence\"\nquestion = \"?\"\nexpectation = \"?\"\nscene = \"scene.toml\"\ntolerance = \"5 %\"\n\
         [[variant]]\nname = \"down\"\nquantity = [{ name = \"face_1_z_m\", label = \"height\", symbol = \"z\", unit = \"m\" }]\n\
         [[family]]\nname = \"sizes\"\nrole = \"sizes\"\n[family.members]\nnominal = {}\n";
    std::fs::write(folder.path().join("study.toml"), study).expect("writable");
    let ended = durometer(folder.path(), &["run", "study.toml", "--out", "results"]);
    assert!(ended.is_success(), "{}", ended.err);
    let table = std::fs::read_to_string(folder.path().join("results/tables/markers.csv")).expect("a table");
    let row =
        |marker: &str| table.lines().find(|l| l.contains(marker)).unwrap_or_else(|| panic!("{table}")).to_string();
    assert!(row("tip").contains(",9,5.00,5.00,"), "{table}");
    assert!(row("middle").ends_with(",9,0.67,2.00,1.000"), "{table}");
    let page = std::fs::read_to_string(folder.path().join("results/index.html")).expect("a report");
    assert!(page.contains("Distances of recorded points from measured markers"));
}

/// Points, markers and files that do not exist are refused before the run, by `check` and by `simulate`; a list of curves may come before the markers.
#[test]
fn mistakes_are_refused_before_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, out) = simulate(folder.path(), SCENE, &["simulate", "--out", "out"]);
    write_tracks(folder.path(), &rows(folder.path()));
    std::fs::write(folder.path().join("m.csv"), "t,z\n0,0.02\n1,0.01\n").expect("writable");
    let curve = "[[compare]]\ncolumn = \"face_1_z_m\"\nfile = \"m.csv\"\nx = { column = \"t\", unit = \"s\" }\ny = { column = \"z\", unit = \"m\" }\n";
    let (code, both) = simulate(folder.path(), &format!("{SCENE}{curve}{COMPARED}"), &["simulate", "--out", "out"]);
    assert_eq!(code, Some(0), "{out} {both}");
    assert!(
        both.contains("is off m.csv, z [m] over t [s], by") && both.contains("tip of capture.csv is off"),
        "{both}"
    );
    std::fs::write(folder.path().join("far.csv"), "t,z\n100,0.02\n200,0.01\n").expect("writable");
    let far = curve.replace("m.csv", "far.csv");
    let (code, apart) = simulate(folder.path(), &format!("{SCENE}{far}"), &["simulate", "--out", "out"]);
    assert!(code == Some(0) && apart.contains("face_1_z_m has no distance from far.csv"), "{code:?} {apart}");
    for (from, to, part) in [
        ("face_1", "fcae_1", "the scene records no positions of \"fcae_1\""),
        ("tip = ", "tpi = ", "there are no markers tpi"),
        ("capture.csv", "caption.csv", "cannot be read"),
        ("[\"-0.5 s\", \"0 s\"]", "[\"0 s\", \"-0.5 s\"]", "before it begins"),
        ("points = { tip = \"face_1\", middle = \"face_2\" }", "points = {}", "it names no points"),
        ("reference =", "referenz =", "unknown key `referenz`"),
    ] {
        let scene = format!("{SCENE}{COMPARED}").replacen(from, to, if from == "face_1" { 9 } else { 1 });
        for command in [&["check"][..], &["simulate", "--out", "out"]] {
            let (code, out) = simulate(folder.path(), &scene, command);
            assert!(code == Some(2) && out.contains(part), "{command:?}: {code:?} {out}");
        }
    }
}
