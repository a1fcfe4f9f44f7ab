//! First picture, legends and curves of a page, of two bodies of which one moves to and fro on a floor.

use crate::common::program::{ROOT, durometer};
use crate::driven;
use durometer::math::statistics::{larger, smaller};
use durometer::report::viewer::of_scene;
use durometer::report::viewer::shape::{Limits, PartKind};
use durometer::scene::SceneBuilder;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The tip of the lower part goes to 30 mm, back through rest to −30 mm, and ends at rest; the part lies on a floor.
const SCENE: &str = r#"
title = "to and fro"
[[mesh.part]]
name = "low"
grid = { kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = [6, 2, 2] }
[[mesh.part]]
name = "high"
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [3, 2, 2] }
shift = ["0 mm", "0 mm", "25 mm"]
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
region = "low.xmax"
components = "y"
displacement = { kind = "sine", amplitude = "30 mm", frequency = "1 Hz" }
[[contact]]
name = "ground"
region = "low.zmin"
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
region = "low.xmax"
[output]
fields = { what = ["displacement", "stress"] }
"#;

fn texts(value: &Value) -> Vec<&str> {
    value.as_array().expect("a list").iter().filter_map(Value::as_str).collect()
}

/// The page of the run.
fn page(folder: &Path) -> PathBuf {
    let file = folder.join("scene.toml");
    std::fs::write(&file, SCENE).expect("room");
    let output = durometer(ROOT, &["simulate", &file.to_string_lossy(), "--out", &folder.to_string_lossy()]);
    assert!(output.is_success(), "{}", output.err);
    folder.join("scene.html")
}

#[test]
fn a_browser_shows_what_moves_to_and_fro() {
    let folder = TempDir::new().expect("a temporary folder");
    let Some(found) = driven(&page(folder.path()), false) else { return };
    assert_eq!(found["errors"], json!([]));
    // Also the farthest states, of which none is the first, the middle or the last one, are within the first picture
    let reach: Vec<f64> = found["reach"].as_array().expect("shares").iter().filter_map(Value::as_f64).collect();
    assert!(reach.len() == 2 && reach.iter().all(|share| (0.3..1.0).contains(share)), "{reach:?}");
    // The first column, a force across the motion, is rounding
    assert_eq!(found["column"], "low.xmax_x_m");
    assert_floor(&found);
    assert_fields(&found);
    assert_words(&found);
}

#[test]
fn a_floor_is_on_a_page_once_and_moves_as_its_obstacle() {
    let floor = "obstacle = { kind = \"floor\", point = [\"0 mm\", \"0 mm\", \"-1 mm\"], normal = [0, 0, 1] }";
    let again = format!(
        "\n[[contact]]\nname = \"again\"\nregion = \"high.zmin\"\n{floor}\nresponse = \"penalty\"\nfriction = 0\n"
    );
    let motion = "motion = { direction = [0, 0, -1], displacement = { kind = \"ramp\", from = \"0 mm\", to = \"5 mm\", end = \"1 s\" } }";
    let heights = |points: &[[f64; 3]]| points.iter().map(|p| (p[2] * 1e9).round() / 1e3).collect::<Vec<_>>();
    let moved = SCENE.replace(floor, &format!("{floor}\n{motion}"));
    for (scene, lower) in [(format!("{SCENE}{again}"), -1000.0), (moved, -4000.0)] {
        let scene = SceneBuilder::parse(&scene).and_then(SceneBuilder::build).expect("a scene");
        let shape = of_scene::shape(&scene, &Limits::USUAL);
        let [part] = &shape.parts[..] else { panic!("one floor, and nothing else") };
        assert_eq!((part.name.as_str(), part.kind, part.triangles.len()), ("ground", PartKind::Floor, 2));
        assert_eq!(heights(&shape.points[part.first as usize..]), [-1000.0; 4]);
        // The nodes that carry an obstacle come after those of the mesh
        let mut x = scene.start().x;
        (scene.body.mesh.points.len()..x.len() / 3).for_each(|n| x[3 * n + 2] = -0.003);
        assert_eq!(heights(&of_scene::parts(&scene, &x)), [lower; 4]);
    }
}

/// The floor is drawn in its plane under all states, with a margin, and can be hidden.
fn assert_floor(found: &Value) {
    let numbers =
        |value: &Value| value.as_array().expect("a list").iter().filter_map(Value::as_f64).collect::<Vec<_>>();
    let (floor, low, high) = (numbers(&found["floors"]), numbers(&found["box"][0]), numbers(&found["box"][1]));
    assert!(floor.len() == 18 && floor.iter().skip(2).step_by(3).all(|z| (z + 1e-3).abs() < 1e-6), "{floor:?}");
    for i in 0..2 {
        let ends = || floor.iter().skip(i).step_by(3).copied();
        let (from, to) = (ends().fold(f64::INFINITY, smaller), ends().fold(f64::NEG_INFINITY, larger));
        let margin = (low[i] - from).min(to - high[i]);
        assert!(margin > 0.003 && margin < 0.03, "{from} to {to} for {} to {}", low[i], high[i]);
    }
    let checks = texts(&found["checks"]);
    assert!(checks.contains(&"rigid bodies, obstacles, skins"), "{checks:?}");
}

/// Fields take a decimal comma; what they do not take is named, and the number before it stays.
fn assert_fields(found: &Value) {
    let below = "30 is not below the other end, 20.5 mm; change that first.";
    let expected = json!([
        ["20,5", "20.5", "", 0, 0.0205, "own"],
        ["", "0", "“” is no number.", 0, 0.0205, "own"],
        ["30", "0", below, 0, 0.0205, "own"],
        ["abc", "0", "“abc” is no number.", 0, 0.0205, "own"],
        ["-Infinity", "0", "“-Infinity” is no number.", 0, 0.0205, "own"],
        ["1e400", "20.5", "“1e400” is no number.", 0, 0.0205, "own"],
        ["0,5", "0.5", "", 0.0005, 0.0205, "own"],
    ]);
    assert_eq!((&found["typed"], &found["factors"]), (&expected, &json!(["1", "2.5"])));
    // A node is where it is, however its displacement is drawn
    let picked = texts(&found["picked"]);
    let has_moved = !picked[0].ends_with(", displacement 0 m");
    assert!(picked[0].starts_with("node ") && has_moved && picked[0] == picked[1], "{picked:?}");
}

/// A picture says the factor of the displacements, the scale of the forces and which colour is which region; "About" the fields with their errors.
fn assert_words(found: &Value) {
    let words = texts(&found["words"]);
    assert!(words[0] == "t = 0.5 s, displacements × 2.5", "{words:?}");
    assert!(words[1].starts_with("normal contact forces ") && words[1].ends_with(" mN"), "{words:?}");
    assert_eq!(found["force"], words[1]);
    // Those that a later region covers have no place in the picture
    assert_eq!(words[2..], ["regions", "xmax", "xmin", "ymax", "ymin", "zmax", "zmin"]);
    let colours = found["colours"].as_array().expect("a list");
    let distinct: BTreeSet<String> = colours.iter().map(|c| c[1].to_string()).collect();
    assert!(colours.len() == 18 && distinct.len() == 18, "{colours:?}");
    let errors = found["about"]["error of the colours"].as_str().expect("text");
    assert!(errors.contains(", stress ") && errors.ends_with(" Pa"), "{errors}");
}
