//! A study with a measured curve: the report lays it over the recorded ones, and the bundle runs again elsewhere.

use crate::common::files::files_below;
use crate::common::program::{Ended, ROOT, ended, program};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["10 mm", "10 mm", "20 mm"], divisions = [1, 1, 2] }

[laws.rubber]
include = "../data/law.toml"

[[effect]]
kind = "elastic"
region = "body"
law = "rubber"

[[constraint]]
kind = "fixed"
region = "zmin"

[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = { kind = "ramp", from = "0 mm", to = "2 mm", start = "0 s", end = "1 s" }

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"

[[probe]]
kind = "position"
region = "zmax"

[[probe]]
kind = "reaction"
region = "zmax"

[[compare]]
column = "zmax_reaction_z_N"
file = "../data/pull.csv"
x = { column = "t", unit = "s" }
y = { column = "F", unit = "N" }

[[compare]]
column = "zmax_reaction_z_N"
file = "../data/pull.csv"
x = { column = "t", unit = "s" }
y = { column = "G", unit = "N" }
"#;

const STUDY: &str = r#"
kind = "sweep"
question = "How does the force depend on E?"
expectation = "It is proportional."
scene = "scene.toml"
tolerance = "2 %"

[[variant]]
name = "pull"
quantity = [{ name = "zmax_reaction_z_N", label = "force", symbol = "F", unit = "N" }]

[[axis]]
name = "E"
keys = ["laws.rubber.E"]
label = "Young's modulus"
symbol = "E"
unit = "kPa"
values = ["50 kPa", "100 kPa"]
"#;

/// A call with these paths after its arguments.
fn with_paths(arguments: &[&str], paths: &[&Path]) -> Ended {
    ended(program(ROOT, arguments).args(paths))
}

/// The study, run, in a folder of its own.
fn study() -> (tempfile::TempDir, PathBuf, PathBuf) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    for folder in ["bar", "data"] {
        std::fs::create_dir(dir.path().join(folder)).expect("a folder");
    }
    let files = [
        ("bar/scene.toml", SCENE),
        ("bar/study.toml", STUDY),
        ("data/law.toml", "law = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.3\n"),
        ("data/pull.csv", "t,F,G\n0,0,0\n0.5,0.5,1\n1,1,2\n"),
    ];
    for (name, text) in files {
        std::fs::write(dir.path().join(name), text).expect("a file");
    }
    let (file, results) = (dir.path().join("bar/study.toml"), dir.path().join("results"));
    let out = with_paths(&["run"], &[&file, Path::new("--out"), &results]);
    assert!(out.is_success(), "{}", out.said());
    (dir, file, results)
}

#[test]
fn a_measured_curve_is_laid_over_those_of_the_cases() {
    let (_dir, _, results) = study();
    let svg = std::fs::read_to_string(results.join("figures/compare-pull-1.svg")).expect("a figure");
    assert!(svg.contains("measured") && svg.matches("sweep-pull-").count() == 2, "marks, and a line for each case");
    let table = std::fs::read_to_string(results.join("tables/compare.csv")).expect("a table");
    assert_eq!(table.lines().count(), 5, "{table}");
    let page = std::fs::read_to_string(results.join("index.html")).expect("the page");
    assert!(page.contains("id=\"compare-pull-1\""));
    // The curves of one file have rows and captions of their own
    for row in ["sweep-pull-E50kPa", "sweep-pull-E100kPa"] {
        let record = std::fs::read_to_string(results.join(format!("cases/{row}.json"))).expect("a record");
        let record: Value = serde_json::from_str(&record).expect("JSON");
        let distances = record["distances"].as_array().expect("distances");
        let l2: Vec<f64> = distances.iter().map(|d| d["l2"].as_f64().expect("a number")).collect();
        assert!(l2.len() == 2 && l2[0] != l2[1], "{l2:?}");
        assert!(l2.iter().all(|l2| page.contains(&format!("{row}: {:.2} % (L2)", 100.0 * l2))), "{l2:?}");
        for column in ["F", "G"] {
            let of = format!("{column} [N] over t [s]");
            assert!(table.lines().any(|l| l.starts_with(row) && l.contains(&of)), "{table}");
            assert!(page.contains(&format!("(../data/pull.csv, {of})")), "{of}");
        }
    }
}

#[test]
fn a_bundle_lists_what_it_holds_and_runs_again() {
    let (dir, file, results) = study();
    let bundle = dir.path().join("crate");
    std::fs::write(results.join("paper/draft.tex"), "\\input{methods}").expect("a text");
    std::fs::write(results.join("paper/draft.log"), "This is pdfTeX").expect("a file that LaTeX has left");
    let out = with_paths(&["bundle", "write", "--results"], &[&results, &file, &bundle]);
    assert!(out.is_success(), "{}", out.said());
    check_crate(&bundle);
    let has = |name: &str| bundle.join("results/paper").join(name).exists();
    assert!(has("draft.tex") && !has("draft.log"));
    // Elsewhere, without what it was made from
    let moved = tempfile::tempdir().expect("a temporary folder");
    let there = moved.path().join("crate");
    std::fs::rename(&bundle, &there).expect("a move");
    drop(dir);
    let again = moved.path().join("again");
    let rerun = || with_paths(&["bundle", "rerun", "--out"], &[&again, &there]);
    let out = rerun();
    assert_eq!(out.code, Some(0), "{}", out.said());
    assert!(out.said().contains("2 values: 2 unchanged"), "{}", out.said());
    // A result that is not the one of the inputs: the digests are those of the file, the comparison says so
    let law = there.join("home/data/law.toml");
    let sound = std::fs::read_to_string(&law).expect("the law");
    std::fs::write(&law, sound.replace("0.3", "0.31")).expect("the law");
    let out = rerun();
    assert!(out.code == Some(2) && out.said().contains("home/data/law.toml is not the file"), "{}", out.said());
    std::fs::remove_file(&law).expect("the law");
    assert_eq!(rerun().code, Some(2));
    std::fs::write(&law, sound).expect("the law");
    assert_eq!(rerun().code, Some(0));
}

/// Results that `run` wrote next to a study are found from another folder; where there are none both places are named.
#[test]
fn results_next_to_a_study_are_found_from_elsewhere() {
    let (dir, file, results) = study();
    let (elsewhere, next_to_it) = (dir.path().join("elsewhere"), dir.path().join("bar/reports"));
    for folder in [&elsewhere, &next_to_it] {
        std::fs::create_dir(folder).expect("a folder");
    }
    let write = || ended(program(&elsewhere, &["bundle", "write"]).args([&file, &dir.path().join("crate")]));
    let out = write();
    let (here, there) = (Path::new("reports").join("bar"), next_to_it.join("bar"));
    let places = format!("in {} or in {}", here.display(), there.display());
    assert!(out.code == Some(2) && out.said().contains(&places), "{}", out.said());
    std::fs::rename(&results, &there).expect("a move");
    let out = write();
    assert_eq!(out.code, Some(0), "{}", out.said());
    check_crate(&dir.path().join("crate"));
}

/// A link to a file, or to a folder, has the name in the bundle that the study uses.
#[cfg(unix)]
#[test]
fn a_study_with_links_runs_again() {
    let (dir, file, _) = study();
    let at = dir.path();
    let link = |old: &str, new: &str, target: &str| {
        std::fs::rename(at.join(old), at.join(new)).expect("own file");
        std::os::unix::fs::symlink(target, at.join(old)).expect("a link");
    };
    std::fs::create_dir(at.join("elsewhere")).expect("room");
    link("bar/scene.toml", "elsewhere/the-scene.toml", "../elsewhere/the-scene.toml");
    link("data/pull.csv", "elsewhere/measured.csv", "../elsewhere/measured.csv");
    link("data", "elsewhere/tables", "elsewhere/tables");
    // The link to the table led out of the folder that was moved
    std::fs::remove_file(at.join("data/pull.csv")).expect("a link");
    std::os::unix::fs::symlink("../measured.csv", at.join("data/pull.csv")).expect("a link");
    let (results, bundle) = (at.join("linked"), at.join("crate"));
    let done = |out: Ended| assert_eq!(out.code, Some(0), "{}", out.said());
    done(with_paths(&["run", "--out"], &[&results, &file]));
    done(with_paths(&["bundle", "write", "--results"], &[&results, &file, &bundle]));
    let moved = tempfile::tempdir().expect("a temporary folder");
    let there = moved.path().join("crate");
    std::fs::rename(&bundle, &there).expect("a move");
    drop(dir);
    done(with_paths(&["bundle", "rerun", "--out"], &[&moved.path().join("again"), &there]));
}

/// Every file but the manifest is an entity, and every entity that is a file exists with its digest.
fn check_crate(bundle: &Path) {
    let text = std::fs::read(bundle.join("ro-crate-metadata.json")).expect("the metadata");
    let metadata: Value = serde_json::from_slice(&text).expect("JSON");
    assert_eq!(metadata["@context"][0], "https://w3id.org/ro/crate/1.1/context");
    // The validator of the specification refuses keys without a term
    assert_eq!(metadata["@context"][1]["sha256"], "http://schema.org/sha256");
    let graph = metadata["@graph"].as_array().expect("entities");
    let id = |e: &Value| e["@id"].as_str().expect("an id").to_string();
    let ids: BTreeSet<String> = graph.iter().map(id).collect();
    assert_eq!(ids.len(), graph.len(), "ids are unique");
    let root = graph.iter().find(|e| id(e) == "./").expect("a root");
    for key in ["name", "description", "datePublished", "license"] {
        assert!(root[key].is_string(), "{key}");
    }
    for part in root["hasPart"].as_array().expect("parts") {
        assert!(ids.contains(&id(part)), "{part}");
    }
    let mut listed: BTreeSet<String> = BTreeSet::new();
    for e in graph.iter().filter(|e| e["@type"] == "File") {
        let name = e["name"].as_str().expect("a name");
        let bytes = std::fs::read(bundle.join(name)).expect("a file");
        assert_eq!(e["sha256"], durometer::storage::sha256(&bytes), "{name}");
        assert_eq!(e["contentSize"], bytes.len().to_string());
        listed.insert(name.into());
    }
    listed.extend(["ro-crate-metadata.json", "manifest-sha256.txt"].map(String::from));
    let name = |path: PathBuf| path.strip_prefix(bundle).expect("inside").display().to_string();
    let found: BTreeSet<String> = files_below(bundle).into_iter().map(name).collect();
    assert_eq!(found, listed);
    for name in [
        "home/bar/study.toml",
        "home/bar/scene.toml",
        "home/data/law.toml",
        "home/data/pull.csv",
        "results/paper/methods.md",
    ] {
        assert!(found.contains(name), "{name}");
    }
}

/// A beam under its weight, whose moving points are measured.
const BEAM: &str = r#"
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
kind = "traction"
name = "load"
region = "xmax"
direction = [0, 0, -1]
traction = { kind = "ramp", from = "0 Pa", to = "100 Pa", end = "1 s" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "position"
region = "xmax"
"#;
const MEASURED: &str = r#"
kind = "validation"
question = "How far does a heavy load bend a beam?"
expectation = "As far as a light one says."
scene = "scene.toml"
tolerance = "5 %"
checks = 1
[[unknown]]
name = "E"
key = "laws.rubber.E"
label = "Young's modulus"
symbol = "E"
range = ["200 kPa", "400 kPa"]
[[record]]
name = "light"
experiment = "monday"
purpose = "calibration"
[[record]]
name = "heavy"
purpose = "prediction"
set = { "effect.load.traction.to" = "300 Pa" }
[[quantity]]
name = "drop"
label = "tip drop"
symbol = "w"
unit = "mm"
column = "xmax_z_m"
value = "change"
times = -1
records = ["heavy"]
error = [{ group = "reading", deviation = "0.2 mm", source = "scatter" }]
[[field]]
name = "face"
file = "measured/{experiment}.csv"
unit = "m"
position = ["X", "Y", "Z"]
displacement = ["U", "V", "W"]
records = ["light"]
deviation = "0.05 mm"
source = "the test"
"#;

/// The name of the file is that of each experiment.
#[test]
fn a_bundle_has_the_measured_fields_of_its_experiments() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| dir.path().join(name);
    std::fs::create_dir_all(at("beam/measured")).expect("room");
    let measured = "X,Y,Z,U,V,W\n0.04,0.004,0.02,0,0,-2e-4\n0.06,0.004,0.02,0,0,-4.5e-4\n0.08,0.004,0.02,0,0,-8e-4\n";
    for (name, text) in [("scene.toml", BEAM), ("study.toml", MEASURED), ("measured/monday.csv", measured)] {
        std::fs::write(at("beam").join(name), text).expect("room");
    }
    let (file, results, bundle) = (at("beam/study.toml"), at("results"), at("crate"));
    let done = |out: Ended| assert_eq!(out.code, Some(0), "{}", out.said());
    done(with_paths(&["run", "--out"], &[&results, &file]));
    done(with_paths(&["bundle", "write", "--results"], &[&results, &file, &bundle]));
    assert!(bundle.join("home/beam/measured/monday.csv").is_file());
    let moved = tempfile::tempdir().expect("a temporary folder");
    let there = moved.path().join("crate");
    std::fs::rename(&bundle, &there).expect("a move");
    drop(dir);
    done(with_paths(&["bundle", "rerun", "--out"], &[&moved.path().join("again"), &there]));
}

/// A file that a change of the study names relative to its scene in another folder.
#[test]
fn a_bundle_has_the_files_that_changes_of_a_study_name() {
    let (dir, file, _) = study();
    let at = |name: &str| dir.path().join(name);
    std::fs::create_dir(at("scenes")).expect("room");
    std::fs::rename(at("bar/scene.toml"), at("scenes/scene.toml")).expect("own file");
    std::fs::write(at("scenes/other.csv"), "t,F,G\n0,0,0\n0.5,0.6,1\n1,1.1,2\n").expect("room");
    let changed = STUDY.replace("\"scene.toml\"", "\"../scenes/scene.toml\"");
    let changed = changed.replace("[[axis]]", "set = { \"compare.0.file\" = \"other.csv\" }\n\n[[axis]]");
    std::fs::write(&file, changed).expect("the study");
    let (results, bundle) = (at("changed"), at("crate"));
    let done = |out: Ended| assert_eq!(out.code, Some(0), "{}", out.said());
    done(with_paths(&["run", "--out"], &[&results, &file]));
    done(with_paths(&["bundle", "write", "--results"], &[&results, &file, &bundle]));
    assert!(bundle.join("home/scenes/other.csv").is_file());
    let moved = tempfile::tempdir().expect("a temporary folder");
    let there = moved.path().join("crate");
    std::fs::rename(&bundle, &there).expect("a move");
    drop(dir);
    done(with_paths(&["bundle", "rerun", "--out"], &[&moved.path().join("again"), &there]));
}

/// What a mesher has made of `m.inp`: one cell of 10 mm × 10 mm × 20 mm.
const CONVERTED: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n10 0 0\n0 10 0\n0 0 20\n\
$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n";
const REGIONS: &str = r#"file = "m.inp"
unit = "mm"

[mesh.regions]
zmin = { kind = "box", min = ["-1 mm", "-1 mm", "-1 mm"], max = ["11 mm", "11 mm", "1 mm"] }
zmax = { kind = "box", min = ["-1 mm", "-1 mm", "19 mm"], max = ["11 mm", "11 mm", "21 mm"] }
"#;

/// The mesh file includes another, and the mesher is a shell script.
#[cfg(unix)]
#[test]
fn a_bundle_on_a_mesh_file_needs_neither_its_mesher_nor_its_cache() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| dir.path().join(name);
    let grid = SCENE.lines().find(|line| line.starts_with("grid")).expect("a grid");
    let mesher = "#!/bin/sh\nout=$(sed 's/.*\"output\":\"\\([^\"]*\\)\".*/\\1/')\ngzip < \"${0%mesher}converted.msh\" > \"$out\"\n";
    let files = [
        ("bar/scene.toml", SCENE.replace(grid, REGIONS)),
        ("bar/study.toml", STUDY.into()),
        ("bar/m.inp", "*HEADING\n*INCLUDE, INPUT=parts/nodes.inp\n".into()),
        ("bar/parts/nodes.inp", "*NODE\n".into()),
        ("data/law.toml", "law = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.3\n".into()),
        ("data/pull.csv", "t,F,G\n0,0,0\n0.5,0.5,1\n1,1,2\n".into()),
        ("project/meshes/meshgen/__main__.py", String::new()),
        ("project/converted.msh", CONVERTED.into()),
        ("project/script", mesher.into()),
    ];
    for (name, text) in files {
        std::fs::create_dir_all(at(name).parent().expect("a folder")).expect("a folder");
        std::fs::write(at(name), text).expect("a file");
    }
    // A file that another thread may hold open for writing cannot be run; the copy has been closed
    let made =
        Command::new("sh").args(["-c", "cp script mesher && chmod +x mesher"]).current_dir(at("project")).status();
    assert!(made.expect("sh").success());
    let here = |arguments: &[&str]| {
        let mut command = program(dir.path(), arguments);
        ended(command.env("DUROMETER_HOME", at("project")).env("DUROMETER_PYTHON", at("project/mesher")))
    };
    let out = here(&["run", "bar/study.toml", "--out", "results"]);
    assert!(out.is_success(), "{}", out.said());
    let out = here(&["bundle", "write", "bar/study.toml", "crate", "--results", "results"]);
    assert!(out.is_success() && !out.said().contains("not stored"), "{}", out.said());
    let moved = tempfile::tempdir().expect("a temporary folder");
    let there = moved.path().join("crate");
    std::fs::rename(at("crate"), &there).expect("a move");
    drop(dir);
    for name in ["bar/m.inp", "bar/parts/nodes.inp", "meshes/meshgen/__main__.py"] {
        assert!(there.join("home").join(name).is_file(), "{name}");
    }
    let out = with_paths(&["bundle", "rerun", "--out"], &[&moved.path().join("again"), &there]);
    assert_eq!(out.code, Some(0), "{}", out.said());
    assert!(out.said().contains("2 values: 2 unchanged"), "{}", out.said());
}

/// Changes of the command line, edits of a file or of the study after the run, and damage: the cases are named. A bundle of earlier, which holds such
/// results, is compared with the statement that they are of other inputs.
#[test]
fn results_of_other_inputs_are_no_part_of_a_bundle() {
    let (dir, file, results) = study();
    let out = dir.path().join("crate");
    let bundle = |results: &Path| with_paths(&["bundle", "write", "--results"], &[results, &file, &out]);
    let refused = |results: &Path, facts: &[&str]| {
        let done = bundle(results);
        assert_eq!(done.code, Some(2), "{}", done.said());
        assert!(facts.iter().all(|fact| done.said().contains(fact)) && !out.exists(), "{facts:?}: {}", done.said());
    };
    let other = dir.path().join("other");
    let run = with_paths(&["run", "--set", "laws.rubber.nu=0.4", "--out"], &[&other, &file]);
    assert!(run.is_success(), "{}", run.said());
    let both = ["another scene, other files", "sweep-pull-E50kPa", "sweep-pull-E100kPa", "--set"];
    refused(&other, &both);
    let compared = with_paths(&["compare"], &[&results, &other]);
    assert!(
        compared.said().contains("inputs: 2 of the common cases were computed from another scene"),
        "{}",
        compared.said()
    );
    let edit = |name: &str, old: &str, new: &str| {
        let path = dir.path().join(name);
        let text = std::fs::read_to_string(&path).expect("a file");
        assert!(text.contains(old), "{text}");
        std::fs::write(path, text.replace(old, new)).expect("a file");
    };
    edit("data/law.toml", "0.3", "0.31");
    refused(&results, &both);
    edit("data/law.toml", "0.31", "0.3");
    edit("bar/study.toml", "2 %", "3 %");
    refused(&results, &["the study file has changed since"]);
    edit("bar/study.toml", "3 %", "2 %");
    edit("results/cases/sweep-pull-E50kPa.json", "\"steps\": 4", "\"steps\": 5");
    refused(&results, &["sweep-pull-E50kPa: their files are not those that were stored"]);
    edit("results/cases/sweep-pull-E50kPa.json", "\"steps\": 5", "\"steps\": 4");
    let done = bundle(&results);
    assert!(done.is_success(), "{}", done.said());
}

const LAWS: &str = r#"
kind = "comparison"
reference = "soft"
question = "How does the force depend on E?"
expectation = "It is proportional."
scene = "scene.toml"
tolerance = "2 %"

[[variant]]
name = "pull"
quantity = [{ name = "zmax_reaction_z_N", label = "force", symbol = "F", unit = "N" }]

[[family]]
name = "laws"
role = "members"

[family.members]
soft = {}
stiff = { "laws.rubber.E" = "120 kPa" }
"#;

/// The members that were added to a study are those of its rerun. A folder to which others were added is not taken.
#[test]
fn a_rerun_has_the_members_that_were_added() {
    let (dir, file, _) = study();
    std::fs::write(&file, LAWS).expect("the study");
    let [results, out, again] = ["extended", "crate", "again"].map(|name| dir.path().join(name));
    let add = |results: &Path, modulus: &str| {
        std::fs::create_dir_all(results).expect("a folder");
        let text = format!("[family.laws]\nadded = {{ \"laws.rubber.E\" = \"{modulus}\" }}\n");
        std::fs::write(results.join("extension.toml"), text).expect("a file");
    };
    add(&results, "150 kPa");
    let run = with_paths(&["run", "--out"], &[&results, &file]);
    assert!(run.is_success(), "{}", run.said());
    let written = with_paths(&["bundle", "write", "--results"], &[&results, &file, &out]);
    assert!(written.is_success(), "{}", written.said());
    let rerun = |to: &Path| with_paths(&["bundle", "rerun", "--out"], &[to, &out]);
    for _ in 0..2 {
        let done = rerun(&again);
        assert_eq!(done.code, Some(0), "{}", done.said());
        assert!(done.said().contains("3 values: 3 unchanged") && !done.said().contains("gone"), "{}", done.said());
        assert!(!done.said().contains("inputs: "), "{}", done.said());
        assert!(again.join("cases/laws-pull-added.json").is_file());
    }
    let other = dir.path().join("other");
    add(&other, "160 kPa");
    let done = rerun(&other);
    assert!(done.code == Some(2) && done.said().contains("adds other meshes"), "{}", done.said());
}

#[test]
fn what_cannot_be_bundled_is_refused() {
    let (dir, file, results) = study();
    let refused = |results: &Path, out: &Path, fact: &str| {
        let done = with_paths(&["bundle", "write", "--results"], &[results, &file, out]);
        assert!(done.code == Some(2) && done.said().contains(fact), "{fact}: {}", done.said());
    };
    refused(&results, dir.path(), "is not empty");
    refused(&dir.path().join("nothing"), &dir.path().join("b"), "does not exist");
    let scene = dir.path().join("bar/scene.toml");
    let absolute = dir.path().join("data/pull.csv").display().to_string();
    std::fs::write(&scene, SCENE.replace("../data/pull.csv", &absolute)).expect("the scene");
    refused(&results, &dir.path().join("b"), "name it relative");
    for (text, fact) in [("", "study"), ("x\n", "without a digest")] {
        std::fs::write(dir.path().join("manifest-sha256.txt"), text).expect("a manifest");
        let done = with_paths(&["bundle", "rerun"], &[dir.path()]);
        assert!(done.code == Some(2) && done.said().contains("is no bundle"), "{fact}: {}", done.said());
    }
    let outside = format!("{}  ../secret\n", "0".repeat(64));
    std::fs::write(dir.path().join("manifest-sha256.txt"), outside).expect("a manifest");
    assert!(with_paths(&["bundle", "rerun"], &[dir.path()]).said().contains("leads out of the bundle"));
}
