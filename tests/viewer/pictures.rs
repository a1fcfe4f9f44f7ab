//! First picture, legends and curves of a page, of a body that moves to and fro on a floor.

use crate::{driven, durometer};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The tip goes to 30 mm, back through rest to −30 mm, and ends at rest; it hangs on the floor.
const SCENE: &str = r#"
title = "to and fro"
[mesh]
grid = { kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = [6, 2, 2] }
[laws.rubber]
law = "neo_hookean"
E = "30 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "gravity"
region = "body"
density = "2 g/cm^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "0.25 s" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "y"
displacement = { kind = "sine", amplitude = "30 mm", frequency = "1 Hz" }
[[contact]]
name = "ground"
region = "zmin"
obstacle = { kind = "floor", point = ["0 mm", "0 mm", "-1 mm"], normal = [0, 0, 1] }
response = "barrier"
friction = 0
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.125 s"
[[probe]]
kind = "reaction"
region = "xmin"
[[probe]]
kind = "position"
region = "xmax"
[output]
fields = { what = ["displacement", "stress"] }
"#;

/// The page of the run.
fn page(folder: &Path) -> PathBuf {
    let file = folder.join("scene.toml");
    std::fs::write(&file, SCENE).expect("room");
    let output = durometer(&["simulate", &file.to_string_lossy(), "--out", &folder.to_string_lossy()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder.join("scene.html")
}

#[test]
fn a_browser_frames_all_states_of_a_motion_that_returns() {
    let folder = TempDir::new().expect("a temporary folder");
    let Some(found) = driven(&page(folder.path()), false) else { return };
    assert_eq!(found["errors"], json!([]));
    let reach: Vec<f64> = found["reach"].as_array().expect("shares").iter().filter_map(Value::as_f64).collect();
    assert!(reach.len() == 2 && reach.iter().all(|share| (0.3..1.0).contains(share)), "{reach:?}");
}
