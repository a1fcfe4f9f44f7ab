//! A small study on disk, and the comparison of two folders of results.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const SCENE: &str = r#"
title = "A block that is pressed"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [2, 1, 2] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "zmin"
[[constraint]]
kind = "fixed"
region = "zmax"
components = "xy"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = { kind = "ramp", from = "0 mm", to = "-1 mm", start = "0 s", end = "1 s" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "reaction"
region = "zmax"
"#;

/// Writes a sweep of the stiffness with this many points. A case lasts some milliseconds.
pub fn write_study(folder: &Path, points: usize) {
    write_study_with(SCENE, folder, points);
}

/// Writes the same sweep on a finer mesh with 200 steps. A case lasts about a second, so that it is still there when a test kills it.
pub fn write_slow_study(folder: &Path, points: usize) {
    let finer = SCENE.replace("divisions = [2, 1, 2]", "divisions = [12, 6, 12]");
    write_study_with(&finer.replace("dt = \"0.5 s\"", "dt = \"0.005 s\""), folder, points);
}

/// Writes a scene `rod.toml` with the body `rod`, whose mesher is a shell script.
pub fn write_rod(folder: &Path, script: &str) {
    for sub in ["meshes/meshgen", "meshes/rod"] {
        std::fs::create_dir_all(folder.join(sub)).expect("a folder");
    }
    let body = "version = 3\nsummary = \"a rod\"\n[parameters]\n[regions]\nbody = { dim = 3, meaning = \"all\" }\n[features]\n";
    std::fs::write(folder.join("meshes/rod/body.toml"), body).expect("writable");
    // A file that another thread may hold open for writing cannot be run; the copy has been closed
    std::fs::write(folder.join("script"), format!("#!/bin/sh\n{script}\n")).expect("writable");
    let made = Command::new("sh").args(["-c", "cp script mesher && chmod +x mesher"]).current_dir(folder).status();
    assert!(made.expect("sh").success());
    let grid = "grid = { kind = \"box\", size = [\"20 mm\", \"10 mm\", \"10 mm\"], divisions = [2, 1, 2] }";
    assert!(SCENE.contains(grid));
    std::fs::write(folder.join("rod.toml"), SCENE.replace(grid, "body = \"rod\"\nsize = \"2 mm\"")).expect("writable");
}

fn write_study_with(scene: &str, folder: &Path, points: usize) {
    std::fs::create_dir_all(folder).expect("a folder");
    std::fs::write(folder.join("scene.toml"), scene).expect("writable");
    let values: Vec<String> = (0..points).map(|k| format!("\"{} kPa\"", 100 + k)).collect();
    let study = format!(
        r#"
kind = "sweep"
question = "Does it matter who runs a case?"
expectation = "No."
scene = "scene.toml"
tolerance = "5 %"
[[variant]]
name = "press"
quantity = [{{ name = "zmax_reaction_z_N", label = "force", symbol = "F", unit = "N" }}]
[[axis]]
name = "E"
keys = ["laws.rubber.E"]
label = "stiffness"
symbol = "E"
unit = "kPa"
values = [{}]
"#,
        values.join(", ")
    );
    std::fs::write(folder.join("study.toml"), study).expect("writable");
}

/// What a folder of results holds, times and the like apart: file → contents, of records their values.
pub fn contents(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    for entry in std::fs::read_dir(dir.join("cases")).expect("results").flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        // What a killed writer has left is removed when it is old
        if path.is_dir() || name.contains(".damaged-") || name.ends_with(".part") {
            continue;
        }
        let bytes = std::fs::read(&path).expect("readable");
        let bytes = match path.extension().is_some_and(|e| e == "json") {
            true => without_times(&bytes),
            false => bytes,
        };
        out.insert(name, bytes);
    }
    out
}

/// A record without its times, its memory (expected or measured), whether something else ran at the same time, and its digest.
fn without_times(bytes: &[u8]) -> Vec<u8> {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(map) => {
                let timed = |key: &str| {
                    let kinds =
                        ["wall_s", "cpu_s", "phases", "shared", "memory", "expected", "started", "threads", "host"];
                    kinds.iter().any(|kind| key.contains(kind)) || key == "record_sha256"
                };
                map.retain(|key, _| !timed(key));
                map.values_mut().for_each(strip);
            }
            Value::Array(values) => values.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let mut value: Value = serde_json::from_slice(bytes).expect("JSON");
    strip(&mut value);
    serde_json::to_vec_pretty(&value).expect("JSON")
}

/// Panics where two folders of results differ, with the name of the first difference.
pub fn assert_same(one: &Path, other: &Path) {
    let (one, other) = (contents(one), contents(other));
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
        assert!(*bytes == other[name], "{name}:\n{}\n{}", text(bytes), text(&other[name]));
    }
}
