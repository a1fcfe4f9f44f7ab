//! The full model behind a reduced one: it answers where the bar is above the tolerance, and only its own scene is accepted.

use crate::bar::without_cable;
use crate::common::program::{Ended, durometer, durometer_with};
use durometer::reduction::polynomial::Quadratic;
use durometer::reduction::quantities::{ReducedQuantity, ReducedReading};
use durometer::reduction::running::fallback::By;
use durometer::reduction::training::full_model::FullModelError;
use durometer::reduction::{Fallback, FullModel, ReducedModel, Twin};
use durometer::scene::{Body, changed_scene, mesh_sha256, read_scene};
use serde_json::Value;
use std::path::{Path, PathBuf};

const STUDY: &str = r#"
kind = "reduction"
question = "How few?"
expectation = "Few."
scene = "scene.toml"
tolerance = "1 %"
training = 14
held_back = 12
modes = [4]
[[input]]
name = "weight"
key = "effect.gravity.acceleration"
range = ["0 m/s^2", "20 m/s^2"]
[[input]]
name = "stiffness"
key = "laws.rubber.mu"
range = ["50 kPa", "80 kPa"]
[[quantity]]
name = "xmax_z_m"
label = "height of the tip"
symbol = "z"
unit = "m"
"#;

fn answers(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

/// Height of the tip by a plain run of the scene.
fn plain(folder: &Path, weight: f64, mu: f64) -> f64 {
    let set = [format!("effect.gravity.acceleration={weight} m/s^2"), format!("laws.rubber.mu={mu} Pa")];
    let arguments = ["simulate", "scene.toml", "--out", "plain", "--set", &set[0], "--set", &set[1]];
    let Ended { code, out, err } = durometer(folder, &arguments);
    assert_eq!(code, Some(0), "{out}{err}");
    let mut files = std::fs::read_dir(folder.join("plain")).expect("a folder").flatten().map(|f| f.path());
    let file = files.find(|f| f.extension().is_some_and(|e| e == "csv")).expect("a table");
    let text = std::fs::read_to_string(file).expect("it can be read");
    std::fs::remove_dir_all(folder.join("plain")).expect("it was made");
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let place = rows.next().expect("a head").split(',').position(|c| c == "xmax_z_m").expect("the column");
    rows.next_back().expect("a row").split(',').nth(place).expect("a cell").parse().expect("a number")
}

/// In the range the reduced model answers; beyond it, and where the bar is above the tolerance, the full one, with the value of a plain run of the scene to
/// the tolerance of its solver (1e-8 of the forces, 1e-6 of the motion). Other scenes and meshes are refused.
#[test]
fn the_full_model_answers_where_the_reduced_one_is_not_trusted() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    std::fs::write(at.join("scene.toml"), without_cable()).expect("room");
    std::fs::write(at.join("study.toml"), STUDY).expect("room");
    let Ended { code, out, err } = durometer(at, &["run", "study.toml", "--out", "out"]);
    assert_eq!(code, Some(0), "{out}{err}");
    let record: Value =
        serde_json::from_str(&std::fs::read_to_string(at.join("out/derived.json")).expect("models")).expect("JSON");
    let file = format!("out/{}", record["models"][0]["file"].as_str().expect("a file"));

    let protocol = "{\"inputs\": {\"body_acceleration_m_s2\": 8, \"rubber_mu_Pa\": 60000}}\n\
        {\"inputs\": {\"body_acceleration_m_s2\": 30}}\n\
        {\"inputs\": {\"rubber_mu_Pa\": 95000}}\n\
        {\"inputs\": {\"body_acceleration_m_s2\": 8, \"rubber_mu_Pa\": 60000}}\n\
        {\"inputs\": {\"rubber_mu_Pa\": -1}}\n";
    let backed = ["twin", &file, "--tolerance", "5%", "--full", "scene.toml"];
    let Ended { code, out, err } = durometer_with(at, &backed, protocol);
    assert_eq!(code, Some(0), "{out}{err}");
    let all = answers(&out);
    let by: Vec<&str> = all[1..5].iter().map(|a| a["by"].as_str().unwrap_or("none")).collect();
    assert_eq!(by, ["reduced", "full", "full", "reduced"], "{out}");
    let tip = |k: usize| all[k]["quantities"]["xmax_z_m"]["value"].as_f64().expect("a value");
    for (k, weight, mu) in [(2, 30.0, 60e3), (3, 30.0, 95e3)] {
        let full = plain(at, weight, mu);
        assert!((tip(k) - full).abs() < 1e-6 * full.abs().max(1e-3), "{k}: {} {full}", tip(k));
        assert!(all[k]["quantities"]["xmax_z_m"]["bar"] == 0.0 && all[k]["within_tolerance"] == true, "{}", all[k]);
        assert_eq!(all[k]["in_range"], false);
    }
    // From another start, to the tolerance of Newton's method
    assert!((tip(1) - tip(4)).abs() < 1e-9 * tip(1).abs());
    assert!(all[5]["error"].as_str().is_some_and(|why| why.contains("law")), "{}", all[5]);

    // A tolerance that no bar keeps: every answer is the full one, and a target is judged by it
    let strict = ["twin", &file, "--tolerance", "1e-9", "--full", "scene.toml"];
    let step = "{\"inputs\": {\"body_acceleration_m_s2\": 8, \"rubber_mu_Pa\": 60000}}\n";
    let answer = &answers(&durometer_with(at, &strict, step).out)[1];
    let value = answer["quantities"]["xmax_z_m"]["value"].as_f64().expect("a value");
    assert!(answer["by"] == "full" && (value - plain(at, 8.0, 60e3)).abs() < 1e-8, "{answer}");
    in_the_library(at, &file);
    it_begins_without_loads(at, &file);
    rotations_are_counted(at, &file);
    others_are_refused(at, &file);
}

/// A slender bar that a cable winds up: with 20 mm of it drawn in at once it finds no equilibrium, and one with 30 mm from zero on.
const WOUND: &str = r#"
[mesh.grid]
kind = "box"
size = ["60 mm", "4 mm", "4 mm"]
divisions = [15, 1, 1]
[laws.rubber]
law = "neo_hookean"
mu = "60 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["6 mm", "2 mm", "0 mm"], ["12 mm", "2 mm", "0 mm"], ["18 mm", "2 mm", "0 mm"], ["24 mm", "2 mm", "0 mm"], ["30 mm", "2 mm", "0 mm"], ["36 mm", "2 mm", "0 mm"], ["42 mm", "2 mm", "0 mm"], ["48 mm", "2 mm", "0 mm"], ["54 mm", "2 mm", "0 mm"], ["59 mm", "2 mm", "0 mm"]]
pull_point = ["-1 mm", "2 mm", "0 mm"]
guide_radius = "2 mm"
drive = { kind = "length", signal = "0 mm" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "position"
region = "xmax"
"#;

/// A bar that winds up by 300°, whose angle is recorded.
const TURNED: &str = r#"
[mesh.grid]
kind = "box"
size = ["100 mm", "6 mm", "6 mm"]
divisions = [20, 2, 2]
[laws.rubber]
law = "neo_hookean"
mu = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["2 mm", "3 mm", "5 mm"], ["18 mm", "3 mm", "5 mm"], ["34 mm", "3 mm", "5 mm"], ["50 mm", "3 mm", "5 mm"], ["66 mm", "3 mm", "5 mm"], ["82 mm", "3 mm", "5 mm"], ["98 mm", "3 mm", "5 mm"]]
pull_point = ["-10 mm", "3 mm", "5 mm"]
guide_radius = "2.5 mm"
drive = { kind = "length", signal = "0 mm" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"#;

/// A model with the origin of a scene whose cable is an input; what it is made of is another scene.
fn of_scene(at: &Path, file: &str, (name, text): (&str, &str)) -> (ReducedModel, PathBuf) {
    let scene = at.join(name);
    std::fs::write(&scene, text).expect("room");
    let (spec, text) = read_scene(&scene, &[]).expect("a scene");
    let marked = "kind = 'controlled'\ninitial = '20 mm'\nrange = ['0 mm', '40 mm']";
    let marked: toml::Table = marked.parse().expect("TOML");
    let changes = [("constraint.cable.drive.signal".to_string(), toml::Value::from(marked))];
    let mut model = ReducedModel::read(&at.join(file)).expect("a model");
    model.origin.scene = changed_scene(&scene, &text, &changes, &spec.known_laws).expect("a scene").1;
    model.origin.changes = changes.into_iter().collect::<toml::Table>().to_string();
    model.origin.mesh_sha256 = mesh_sha256(&Body::load(&scene, &spec.mesh, &mut |_| {}).expect("a grid"));
    (model, scene)
}

/// A study marks its inputs by values within their ranges, and the full model has none of them at its start.
fn it_begins_without_loads(at: &Path, file: &str) {
    let (model, scene) = of_scene(at, file, ("wound.toml", WOUND));
    let mut full = FullModel::open(&model, &scene).unwrap_or_else(|e| panic!("{e}"));
    let tip = full.step(&[30e-3, 60e3]).unwrap_or_else(|e| panic!("{e}"));
    assert!(tip.len() == 1 && tip[0].is_finite(), "{tip:?}");
}

/// An angle counts its rotations from any inputs to any others, as in small steps: from rest, and from the other end of the range.
fn rotations_are_counted(at: &Path, file: &str) {
    let (mut model, scene) = of_scene(at, file, ("turned.toml", TURNED));
    let direction = Quadratic { coordinates: 1, constant: vec![0.0; 3], linear: vec![], quadratic: vec![] };
    let reading = ReducedReading::Turned { direction, rest: [1.0, 0.0, 0.0], axis: None };
    model.quantities = vec![ReducedQuantity { name: "bending_angle_deg".into(), reading }];
    model.inputs[0].range = [0.0, 26e-3];
    let mut full = FullModel::open(&model, &scene).unwrap_or_else(|e| panic!("{e}"));
    let angle = |full: &mut FullModel, u: f64| full.step(&[u, 100e3]).unwrap_or_else(|e| panic!("{e}"))[0];
    let mut slowly = 0.0;
    for k in 1..=60 {
        slowly = angle(&mut full, 23e-3 * f64::from(k) / 60.0);
    }
    assert!(slowly > 260.0, "{slowly}");
    full.reset();
    for (u, expected) in [(23e-3, slowly), (0.0, 0.0), (23e-3, slowly)] {
        let found = angle(&mut full, u);
        assert!((found - expected).abs() < 0.01, "{u}: {found} in place of {expected}");
    }
}

/// The same in the library.
fn in_the_library(at: &Path, file: &str) {
    let model = ReducedModel::read(&at.join(file)).expect("a model");
    let full = FullModel::open(&model, &at.join("scene.toml")).unwrap_or_else(|e| panic!("{e}"));
    let mut twin = Twin::new(model).expect("a law of the library");
    let mut fallback = Fallback { full, tolerance: 0.05 };
    let inside = fallback.step(&mut twin, &[8.0, 60e3]).expect("an equilibrium");
    assert!(inside.by == By::Reduced && inside.values == twin.values() && inside.bars == twin.bars());
    let beyond = fallback.step(&mut twin, &[30.0, 60e3]).expect("an equilibrium");
    assert!(beyond.by == By::Full && beyond.bars == [0.0]);
    assert!(fallback.step(&mut twin, &[f64::NAN, 60e3]).is_err());
    // So heavy that the bar is not in equilibrium; the next step is answered
    let far = fallback.step(&mut twin, &[1e9, 60e3]);
    assert!(far.is_err(), "{far:?}");
    let again = fallback.step(&mut twin, &[30.0, 60e3]).expect("an equilibrium");
    assert!((again.values[0] - beyond.values[0]).abs() < 1e-9);
}

fn others_are_refused(at: &Path, file: &str) {
    let scene = without_cable();
    let (_, after) = scene.split_once("fixed").expect("a constraint");
    let gravity = &after[after.find("[[effect]]").expect("a load")..after.find("[[stage]]").expect("a stage")];
    for (from, to, words) in [
        ("nu = 0.45", "nu = 0.4", "laws.rubber.nu differs"),
        ("divisions = [8, 2, 2]", "divisions = [8, 2, 3]", "mesh.grid.divisions.2 differs"),
        ("density = \"1100 kg/m^3\"", "density = \"1000 kg/m^3\"", "density differs"),
        (gravity, "", "effect.gravity.acceleration differs or is missing; give"),
    ] {
        std::fs::write(at.join("other.toml"), scene.replacen(from, to, 1)).expect("room");
        let Ended { code, err, .. } = durometer(at, &["twin", file, "--tolerance", "1%", "--full", "other.toml"]);
        assert_eq!(code, Some(2), "{to}: {err}");
        assert!(err.contains(words) && err.contains("other.toml"), "{to}: {err}");
    }
    let model = ReducedModel::read(&at.join(file)).expect("a model");
    let mut elsewhere = model.clone();
    elsewhere.origin.mesh_sha256 = "0".into();
    let scene = at.join("scene.toml");
    assert!(matches!(FullModel::open(&elsewhere, &scene), Err(FullModelError::OtherMesh { .. })));
    elsewhere.origin.changes = String::new();
    assert!(matches!(FullModel::open(&elsewhere, &scene), Err(FullModelError::Unknown)));
    let Ended { code, err, .. } = durometer(at, &["twin", file, "--full", "scene.toml"]);
    assert!(code == Some(2) && err.contains("--tolerance"), "{err}");
}
