//! Bundles of studies on meshes of a body: they have every mesh and every file that the body is made of, or say which mesh is not there.

use crate::calibrations::{CURVE, GRID, MESHER, PULL, ROD, SCENE, SIZES, STUDY, write_mesh};
use crate::common::program::call;
use crate::common::stores::write_rod;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A sweep on adaptive meshes.
const SWEEP: &str = r#"
kind = "sweep"
question = "How does the force depend on the shear modulus?"
expectation = "It is proportional."
scene = "rod.toml"
tolerance = "2 %"
[[variant]]
name = "pull"
quantity = [{ name = "xmax_reaction_x_N", label = "force", symbol = "F", unit = "N" }]
[[axis]]
name = "mu"
keys = ["laws.rubber.mu"]
label = "shear modulus"
symbol = "mu"
unit = "kPa"
values = ["50 kPa", "100 kPa"]
"#;

fn write(folder: &Path, name: &str, text: &str) {
    let file = folder.join(name);
    std::fs::create_dir_all(file.parent().expect("below the folder")).expect("room");
    std::fs::write(file, text).expect("room");
}

/// A project with the body `rod`, whose geometry takes a module next to it and reads a table in a folder of its own.
fn project() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write_rod(at, MESHER);
    write_mesh(&at.join("rod.msh.gz"), 0.01);
    write(at, "meshes/meshgen/__main__.py", "");
    write(at, "meshes/rod/geometry.py", "from shared.dims import SCALE\n");
    write(at, "meshes/rod/tables/profile.csv", "0,1\n");
    write(at, "meshes/shared/dims.py", "SCALE = 1\n");
    folder
}

/// Meshes that the bundle `out` of the study is without.
fn without_mesh(folder: &Path, out: &str) -> Value {
    let written = call(folder, &["bundle", "write", "studies/rod/study.toml", out, "--results", "r", "--json"], 0).0;
    let mut written: Value = serde_json::from_str(&written).expect("JSON");
    written["without_mesh"].take()
}

/// The stored meshes.
fn made(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder.join("meshes/cache")).expect("made meshes").flatten();
    let files = entries.map(|entry| entry.path());
    files.filter(|path| path.extension().is_some_and(|end| end == "gz")).collect()
}

/// Puts a copy of a mesh next to its body, as if it were of another geometry.
fn commit_of_another_geometry(folder: &Path, mesh: &Path) {
    let name = mesh.file_name().expect("a name").to_string_lossy().into_owned();
    let manifest = name.replace(".msh.gz", ".json");
    let text = std::fs::read_to_string(mesh.with_file_name(&manifest)).expect("a manifest");
    let mut value: Value = serde_json::from_str(&text).expect("JSON");
    assert!(value["geometry_sha256"].is_string(), "{text}");
    value["geometry_sha256"] = "0".repeat(64).into();
    write(&folder.join("meshes/rod"), &manifest, &value.to_string());
    std::fs::copy(mesh, folder.join("meshes/rod").join(name)).expect("room");
}

/// Moves the bundle `crate` away from what it was made of, and runs it again without a mesher.
fn rerun_elsewhere(folder: tempfile::TempDir) {
    let moved = tempfile::tempdir().expect("a temporary folder");
    std::fs::rename(folder.path().join("crate"), moved.path().join("crate")).expect("a move");
    drop(folder);
    let said = call(moved.path(), &["bundle", "rerun", "crate", "--out", "again"], 0).0;
    assert!(said.contains("unchanged"), "{said}");
}

/// The body of a further curve of a calibration, which no case has as its own mesh.
#[test]
fn a_bundle_has_the_body_of_a_further_curve_with_its_geometry() {
    let folder = project();
    let at = folder.path();
    write(at, "studies/rod/scene.toml", &format!("{GRID}{SCENE}"));
    write(at, "studies/rod/rod.toml", &format!("{ROD}{SCENE}"));
    write(at, "studies/rod/study.toml", &format!("{STUDY}{CURVE}{SIZES}"));
    write(at, "studies/rod/pull.csv", PULL);
    write(at, "studies/rod/rod.csv", "u (mm),F (N)\n1.5,1.50\n3,2.90\n4.5,4.25\n6,5.50\n");
    call(at, &["run", "studies/rod/study.toml", "--out", "r", "--jobs", "1"], 0);
    assert_eq!(without_mesh(at, "crate"), json!([]));
    for name in ["rod/body.toml", "rod/geometry.py", "rod/tables/profile.csv", "shared/dims.py", "meshgen/__main__.py"]
    {
        assert!(at.join("crate/home/meshes").join(name).is_file(), "{name}");
    }
    let made = made(at);
    assert_eq!(made.len(), 1, "{made:?}");
    let kept = std::fs::read(&made[0]).expect("a mesh");
    std::fs::remove_file(&made[0]).expect("a mesh");
    assert_eq!(without_mesh(at, "other"), json!([made[0].file_name().expect("a name").to_string_lossy()]));
    std::fs::write(&made[0], kept).expect("room");
    rerun_elsewhere(folder);
}

/// Every mesh of a refinement, since the rerun goes through them again, also where one of another geometry lies with the body. The mesher of this test makes
/// the same one for each.
#[test]
fn a_bundle_has_all_meshes_of_a_refinement() {
    let folder = project();
    let at = folder.path();
    let refine = "\nrefine = { quantity = \"xmax_reaction_x_N\", tolerance = \"0.01 %\", meshes = 3 }\n[mesh.regions]";
    let mesh = ROD.replace("\n[mesh.regions]", refine);
    assert!(mesh != ROD);
    write(at, "studies/rod/rod.toml", &format!("{mesh}{SCENE}"));
    write(at, "studies/rod/study.toml", SWEEP);
    call(at, &["run", "studies/rod/study.toml", "--out", "r", "--jobs", "1"], 0);
    let made = made(at);
    assert!(made.len() >= 3, "{made:?}");
    assert_eq!(without_mesh(at, "crate"), json!([]));
    for mesh in &made {
        let name = mesh.file_name().expect("a name");
        assert!(at.join("crate/home/meshes/cache").join(name).is_file(), "{}", mesh.display());
        let kept = std::fs::read(mesh).expect("a mesh");
        std::fs::remove_file(mesh).expect("a mesh");
        let out = format!("without-{}", name.to_string_lossy());
        assert_eq!(without_mesh(at, &out), json!([name.to_string_lossy()]));
        std::fs::write(mesh, kept).expect("room");
    }
    made.iter().for_each(|mesh| commit_of_another_geometry(at, mesh));
    std::fs::remove_dir_all(at.join("crate")).expect("own files");
    assert_eq!(without_mesh(at, "crate"), json!([]));
    rerun_elsewhere(folder);
}
