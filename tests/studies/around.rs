//! The study around a scene of one's own: every load is scaled, meshes have the cells that the axis says, and a map that is left out has a reason.

use crate::common::synthetic;
use durometer::study::expand::Study;
use durometer::study::kinds::robustness::analysis::analyse;
use durometer::study::kinds::robustness::record::RobustnessRecord;
use toml::{Table, Value};

const ANGLE: &str = "{ kind = \"ramp\", from = \"0 deg\", to = \"20 deg\", end = \"1 s\" }";

/// A bar whose end is turned by `angle`.
fn twisted(divisions: &str, angle: &str, more: &str) -> String {
    format!(
        r#"[mesh]
grid = {{ kind = "box", size = ["40 mm", "20 mm", "20 mm"], divisions = {divisions} }}
[laws.rubber]
law = "neo_hookean"
mu = "100 kPa"
nu = 0.35
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
rotation = {{ axis = [1, 0, 0], about = ["40 mm", "10 mm", "10 mm"], angle = {angle} }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
[[probe]]
kind = "reaction"
region = "xmax"
{more}"#
    )
}

const WEIGHT: &str = "[[effect]]\nkind = \"gravity\"\nregion = \"body\"\ndensity = \"1 g/cm^3\"\ndirection = [0, 0, -1]\n\
                      acceleration = { kind = \"ramp\", from = \"0 m/s^2\", to = \"9.81 m/s^2\", end = \"1 s\" }\n";

fn around(text: &str) -> (Study, RobustnessRecord) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("writable");
    let study = Study::around(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
    let details = serde_json::from_value(study.record.details.clone()).expect("maps and suites");
    (study, details)
}

fn families(study: &Study) -> Vec<&str> {
    study.record.families.iter().map(|f| f.name.as_str()).collect()
}

/// The scene of a case.
fn scene(study: &Study, member: &str) -> Table {
    let case = study.cases.iter().find(|c| c.member == member).unwrap_or_else(|| panic!("no member {member}"));
    case.text.parse().expect("TOML")
}

/// A twist alone is a load, and so is a twist next to a weight: both are multiplied.
#[test]
fn every_load_is_scaled() {
    let (alone, kept) = around(&twisted("[4, 2, 2]", ANGLE, ""));
    assert_eq!(kept.left_out, Vec::<String>::new());
    assert_eq!(alone.cases.len(), 67, "{:?}", families(&alone));
    let (both, _) = around(&twisted("[4, 2, 2]", ANGLE, WEIGHT));
    let thrice = scene(&both, "dt1_load3");
    let factor = |signal: &Value| (signal["kind"].as_str().map(String::from), signal["of"][1].as_float());
    let product = (Some("product".to_string()), Some(3.0));
    assert_eq!(factor(&thrice["constraint"][1]["rotation"]["angle"]), product);
    assert_eq!(factor(&thrice["effect"][1]["acceleration"]), product);
}

/// A signal of a controller takes no factor: it is named, and a scene that has no other has no map of the load.
#[test]
fn a_load_that_cannot_be_scaled_is_named() {
    let controlled = "{ kind = \"controlled\", initial = \"0 deg\" }";
    let (study, kept) = around(&twisted("[4, 2, 2]", controlled, ""));
    assert_eq!(families(&study), ["start", "dt-nu"]);
    let expected = "There is no map of the load: a controller sets constraint.1.rotation.angle.";
    assert_eq!(kept.left_out, [expected]);
    let (_, stored) = synthetic::study();
    let warnings = analyse(&study.record, &kept, &stored).warnings;
    assert!(warnings.iter().any(|w| w == expected), "{warnings:?}");
    let (_, kept) = around(&twisted("[4, 2, 2]", controlled, WEIGHT));
    let map = kept.maps.iter().find(|m| m.family == "dt-load").expect("the weight is scaled");
    assert!(map.setup.contains("Not scaled: constraint.1.rotation.angle, which a controller sets"), "{}", map.setup);
}

/// Twice the cells are divisions 1.26 times as many each; the axis has the number that whole divisions give.
#[test]
fn the_mesh_has_the_cells_of_its_axis() {
    let (study, kept) = around(&twisted("[16, 8, 8]", ANGLE, ""));
    let map = kept.maps.iter().find(|m| m.family == "mesh-load").expect("a map of the mesh");
    assert_eq!(map.axes[0].numbers, [1.95, 1.0, 0.46]);
    let divisions = scene(&study, "mesh1.95_load1")["mesh"]["grid"]["divisions"].clone();
    assert_eq!(divisions, Value::from(vec![20, 10, 10]));
    let (_, kept) = around(&twisted("[1, 1, 1]", ANGLE, ""));
    assert!(kept.left_out[0].starts_with("There is no map of the mesh: the divisions"), "{:?}", kept.left_out);
}

/// A scene that ends static is compared with its run from rest, which has no start of the scene's own, and twists are about the longest direction of the body.
/// Where a scene that ends dynamic ends depends on the start: none is compared. One in which nothing can be varied is refused with the reasons.
#[test]
fn starts_are_of_scenes_that_end_static() {
    let start = "[start]\nkind = \"twisted\"\naxis = [0, 1, 0]\nangle = \"30 deg\"\n";
    let kept = |text: &str, member: &str| scene(&around(text).0, member).get("start").cloned();
    let (plain, own) = (twisted("[4, 2, 2]", ANGLE, ""), twisted("[4, 2, 2]", ANGLE, start));
    assert_eq!(kept(&plain, "rest"), None);
    assert_eq!(kept(&own, "rest").expect("a twist")["angle"].as_str(), Some("0 deg"));
    for text in [&plain, &own] {
        let start = kept(text, "twisted-90").expect("a twist");
        assert_eq!((start["angle"].as_str(), start.get("axis")), (Some("90 deg"), None));
    }
    let dynamic = plain.replace("\"static\"", "\"bdf2\"");
    let (study, record) = around(&dynamic);
    assert_eq!(families(&study), ["dt-load", "dt-nu", "mesh-load"]);
    assert_eq!(
        record.left_out,
        ["There is no suite of starts: the last stage is dynamic, and its end depends on the start."]
    );
    let controlled = "{ kind = \"controlled\", initial = \"0 deg\" }";
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = folder.path().join("scene.toml");
    let fixed = dynamic.replace(ANGLE, controlled).replace("nu = 0.35", "kappa = \"300 kPa\"");
    std::fs::write(&file, fixed).expect("writable");
    let refused = Study::around(&file, &[]).expect_err("nothing to vary").to_string();
    assert!(
        refused.contains("There is no map of Poisson's ratio") && refused.contains("no suite of starts"),
        "{refused}"
    );
}

/// The edge length of a body is scaled as the cells are.
#[test]
fn a_size_is_scaled() {
    let body = "[mesh]\nbody = \"beam\"\nsize = \"6 mm\"\n";
    let text = twisted("[4, 2, 2]", ANGLE, "").replace("xmin", "root").replace("xmax", "tip");
    let rest = text.find("[laws").expect("laws");
    let (study, kept) = around(&format!("{body}{}", &text[rest..]));
    assert_eq!(kept.left_out, Vec::<String>::new());
    let size = scene(&study, "mesh0.5_load1")["mesh"]["size"].as_str().map(String::from).expect("a size");
    let metres: f64 = size.trim_end_matches(" m").parse().expect("metres");
    assert!((metres / 6e-3 - 2f64.cbrt()).abs() < 1e-12, "{size}");
}
