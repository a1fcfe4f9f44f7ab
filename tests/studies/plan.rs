//! Plans keep their budget by the clock, whatever the mesh is: stored, made from a surface, given.

use crate::common::tools;
use durometer::mesh::generate::MeshStore;
use durometer::mesh::{Order, structured::block};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const BUDGET_S: f64 = 12.0;
/// So much that small scenes have their pilots in time on a busy machine too; a plan of them ends long before.
const PLENTY_S: f64 = 60.0;

/// So little that it binds.
const SHORT_S: f64 = 4.0;

/// What follows `[mesh]`: a beam of rubber that is stretched by a tenth.
const REST: &str = r#"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "rubber"

[[constraint]]
kind = "fixed"
region = "left"

[[constraint]]
kind = "prescribed"
region = "right"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "10 mm", end = "1 s" }

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"

[[probe]]
kind = "reaction"
region = "right"
"#;

/// The ends of a beam of 100 mm as regions, for files without any.
const ENDS: &str = r#"
[mesh.regions]
left = { kind = "plane", point = ["0 mm", "0 mm", "0 mm"], normal = [1, 0, 0], tolerance = "0.01 mm" }
right = { kind = "plane", point = ["100 mm", "0 mm", "0 mm"], normal = [1, 0, 0], tolerance = "0.01 mm" }
"#;

/// The plan of a scene that is small enough to have one, whether or not a setting meets the tolerance.
fn plan(scene: &str, more: &[&str], out: &Path) -> Value {
    let (code, plan, said) = planned(PLENTY_S, scene, more, out);
    assert!(matches!(code, Some(0 | 3)), "{said}");
    plan.unwrap_or_else(|| panic!("no plan: {said}"))
}

/// Plans a scene; returns the exit code and plan.json, if there is one. It fails if it takes much longer than the budget: as much
/// again, and the start of two programs on a busy machine.
fn planned(budget_s: f64, scene: &str, more: &[&str], out: &Path) -> (Option<i32>, Option<Value>, String) {
    let start = Instant::now();
    let budget = format!("{budget_s} s");
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.args(["plan", scene, "--tolerance", "5 %", "--budget", &budget, "--json", "--out"]).arg(out).args(more);
    let output = command.output().expect("the program starts");
    let taken = start.elapsed();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(taken < Duration::from_secs_f64(2.0 * budget_s + 15.0), "{scene}: {taken:?} of {budget_s} s\n{said}");
    let plan = std::fs::read(out.join("plan.json")).ok();
    (output.status.code(), plan.map(|bytes| serde_json::from_slice(&bytes).expect("JSON")), said)
}

/// A scene file in a folder of its own.
fn scene(mesh: &str, ends: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, format!("title = \"A beam\"\n\n[mesh]\n{mesh}\n{ends}{REST}")).expect("writable");
    let name = file.to_string_lossy().into_owned();
    (folder, name)
}

const FORCE: [&str; 2] = ["--quantity", "right_reaction_x_N"];

#[test]
fn of_a_parametric_body_with_stored_meshes() {
    let out = tempfile::tempdir().expect("temporary folder");
    let one_step = ["--set", "stage.0.dt=\"0.1 s\"", "--set", "stage.0.duration=\"0.1 s\""];
    let plan = plan("finger-convergence", &one_step, out.path());
    // Coarse meshes were looked at, and of the settings that were weighed few were meshed.
    assert_ne!(plan["meshes"], "given");
    let weighed = plan["weighed"].as_array().expect("settings");
    assert!(weighed.iter().filter(|s| s["on_its_mesh"] == true).count() <= 3, "{plan}");
    assert!(plan["planning_s"].as_f64().expect("a number") < 1.5 * PLENTY_S, "{plan}");
}

#[test]
fn of_a_scene_in_time() {
    let out = tempfile::tempdir().expect("temporary folder");
    let short = ["--set", "stage.0.dt=\"1 s\"", "--set", "stage.1.duration=\"0.03 s\""];
    let plan = plan("finger-dynamics", &short, out.path());
    assert_eq!(plan["steps"]["matter"], true, "{plan}");
    // A whole motion takes longer than that: there is a plan or there is none, in time
    let out = tempfile::tempdir().expect("temporary folder");
    let (code, _, said) = planned(SHORT_S, "finger-dynamics", &[], out.path());
    assert!(matches!(code, Some(0 | 3)), "{said}");
}

#[test]
fn of_a_surface_file() {
    let store = MeshStore::find().expect("inside the project");
    let is_sound = store.mesher().diagnose().iter().all(|c| c.ok || c.optional);
    if tools::is_missing(is_sound, "the mesher (durometer doctor --setup)") {
        return;
    }
    let mesh = block(10, 2, 2, 0.1, 0.02, 0.02, Order::Linear);
    let (folder, name) = scene("file = \"beam.stl\"\nunit = \"m\"\ncells = 100000", ENDS);
    let mut text = String::from("solid beam\n");
    for f in 0..mesh.facet_count() {
        let corners = mesh.facet(f).iter().map(|n| mesh.points[*n as usize]);
        text += "facet normal 0 0 0\nouter loop\n";
        corners.for_each(|p| text += &format!("vertex {} {} {}\n", p.x, p.y, p.z));
        text += "endloop\nendfacet\n";
    }
    std::fs::write(folder.path().join("beam.stl"), text + "endsolid beam\n").expect("writable");
    let (code, plan, said) = planned(2.0 * BUDGET_S, &name, &FORCE, folder.path());
    assert!(matches!(code, Some(0 | 3)), "{said}");
    // Meshes take seconds: a busy machine has pilots only
    match plan {
        Some(plan) => assert_eq!(plan["meshes"], "made"),
        None => assert!(said.contains("complete: "), "{said}"),
    }
}

#[test]
fn of_a_given_mesh_there_is_no_size_to_choose() {
    let mesh = block(10, 2, 2, 0.1, 0.02, 0.02, Order::Linear);
    let (folder, name) = scene("file = \"beam.vtk\"\nunit = \"m\"", ENDS);
    let mut text = format!(
        "# vtk DataFile Version 3.0\nbeam\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
        mesh.points.len()
    );
    mesh.points.iter().for_each(|p| text += &format!("{} {} {}\n", p.x, p.y, p.z));
    let n = mesh.cell_count();
    text += &format!("CELLS {n} {}\n", 5 * n);
    (0..n).for_each(|c| {
        text += &format!("4 {}\n", mesh.cell(c).iter().map(u32::to_string).collect::<Vec<_>>().join(" "))
    });
    text += &format!("CELL_TYPES {n}\n{}", "10\n".repeat(n));
    std::fs::write(folder.path().join("beam.vtk"), text).expect("writable");
    let plan = plan(&name, &FORCE, folder.path());
    assert_eq!(plan["meshes"], "given");
    assert!(plan["promises"].to_string().contains("The mesh is given"), "{plan}");
    let weighed = plan["weighed"].as_array().expect("settings");
    assert!(weighed.iter().all(|s| s["cells"] == n && s["on_its_mesh"] == true), "{plan}");
    assert!(weighed.iter().all(|s| s["set"][0].as_str().is_some_and(|c| c.contains("formulation"))), "{plan}");
}

/// A scene of a grid, whose ends are regions.
fn grid(divisions: &str, size: &str) -> (tempfile::TempDir, String) {
    let (folder, name) = scene(&format!("grid = {{ kind = \"box\", size = {size}, divisions = {divisions} }}"), "");
    let text = std::fs::read_to_string(&name)
        .expect("readable")
        .replace("\"left\"", "\"xmin\"")
        .replace("\"right\"", "\"xmax\"");
    std::fs::write(&name, text).expect("writable");
    (folder, name)
}

/// A grid is planned over both elements and over divisions of its proportions, and the change that is advised is one of the scene.
#[test]
fn of_a_grid_elements_and_divisions_are_chosen() {
    let (folder, name) = grid("[20, 4, 4]", "[\"100 mm\", \"20 mm\", \"20 mm\"]");
    // Both elements are tried on a machine with other load too.
    let (code, plan, said) = planned(PLENTY_S, &name, &["--quantity", "xmax_reaction_x_N"], folder.path());
    assert_eq!(code, Some(0), "{said}");
    let plan = plan.expect("a small grid has its pilots in time");
    assert_eq!(plan["meshes"], "scaled");
    let weighed = plan["weighed"].as_array().expect("settings");
    let elements: Vec<&str> = weighed.iter().filter_map(|s| s["element"].as_str()).collect();
    assert!(elements.iter().any(|e| e.starts_with("tet10")), "{elements:?}");
    let of = |cells: u64| weighed.iter().find(|s| s["cells"] == cells).expect("a setting")["set"].to_string();
    assert!(of(810).contains("mesh.grid.divisions=[15, 3, 3]"), "{}", of(810));
}

/// Divisions without a common factor have no coarser grid of their proportions.
#[test]
fn of_a_mesh_that_is_too_large_for_it() {
    let (folder, name) = grid("[61, 30, 31]", "[\"100 mm\", \"60 mm\", \"60 mm\"]");
    let (code, _, said) = planned(BUDGET_S, &name, &["--quantity", "xmax_reaction_x_N"], folder.path());
    assert_eq!(code, Some(3), "{said}");
}
