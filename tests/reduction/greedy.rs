//! Training states that are chosen where the estimated error is large: how well, and as parts of a study.

use crate::bar::{self, Bar, SCENE, Weight};
use crate::common::program::durometer;
use crate::common::studies::run_folder;
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::prelude::write_report;
use durometer::reduction::training::greedy::Search;
use durometer::reduction::{FullState, Training, errors};
use durometer::scene::Scene;
use durometer::study::kinds::reduction::path::{ordered, random, spread};
use durometer::study::rounds::Rounds;
use serde_json::Value;
use std::path::Path;

/// Weight across a bar, and a cable that is slack over most of its range: below 4 mm nothing depends on it.
const RANGES: [[f64; 2]; 2] = [[-10.0, 10.0], [-12e-3, 4e-3]];

const DRIVE: &str =
    "{ kind = \"length\", signal = { kind = \"controlled\", initial = \"0 mm\", range = [\"-12 mm\", \"4 mm\"] } }";

fn bar(points: usize) -> Scene {
    let bar = Bar { weight: Weight::Input([-10, 10]), drive: Some(DRIVE), ..Bar::default() };
    bar.of_points(block(8, 2, 2, 0.04, 0.01, 0.01, Order::Linear), points)
}

fn names() -> Vec<String> {
    vec!["xmax_z_m".into(), "xmax_y_m".into()]
}

/// Full solutions at these shares of the ranges, and how many there were.
fn states(shares: Vec<Vec<f64>>) -> Vec<FullState> {
    let in_si = |share: &Vec<f64>| -> Vec<f64> {
        share.iter().zip(RANGES).map(|(s, range)| range[0] + s * (range[1] - range[0])).collect()
    };
    let points: Vec<Vec<f64>> = ordered(shares, &[0.5, 0.75]).iter().map(in_si).collect();
    bar::states(&bar(points.len()), &points, &names())
}

/// Largest error at states that were held back, of a model of as many modes as the search looks at.
fn held_back_error(scene: &Scene, known: &[FullState], others: &[FullState]) -> f64 {
    let training = Training::new(scene, known, &names()).unwrap_or_else(|e| panic!("{e}"));
    let model = training.model(MODES, Some(1e-3), &[]).unwrap_or_else(|e| panic!("{e}"));
    let all = errors(&model, others).expect("a law of the library");
    let of = |k: usize| all.iter().map(|row| row[k].0.abs() / model.largest_changes[k]).fold(0.0, larger);
    (0..names().len()).map(of).fold(0.0, larger)
}

const MODES: usize = 6;

/// Three quarters of the range of the cable move nothing, so that most states of a plan in one shot say the same. From the hypercube's number of states on,
/// the greedy plan has no larger an error at states that were held back; it has it with fewer.
#[test]
fn no_more_states_than_a_hypercube_for_the_same_error() {
    let scene = bar(1);
    let others = states(random(2, 60, 7));
    let candidates: Vec<Vec<f64>> = random(2, 256, 3);
    let in_si: Vec<Vec<f64>> =
        candidates.iter().map(|s| s.iter().zip(RANGES).map(|(s, r)| r[0] + s * (r[1] - r[0])).collect()).collect();
    let mut known = states(spread(2, 8, 1));
    let mut greedy = vec![];
    while known.len() < 24 {
        let training = Training::new(&scene, &known, &names()).unwrap_or_else(|e| panic!("{e}"));
        let search = Search { modes: MODES, sampling: Some(1e-3), batch: 4 };
        let choice = search.choose(&training, &in_si).unwrap_or_else(|e| panic!("{e}"));
        known.extend(states(choice.chosen.iter().map(|&k| candidates[k].clone()).collect()));
        greedy.push((known.len(), choice.largest, held_back_error(&scene, &known, &others)));
    }
    let one_shot = |count: usize| (count, held_back_error(&scene, &states(spread(2, count, 1)), &others));
    let hypercube: Vec<(usize, f64)> = [12, 16, 20, 24, 32, 48].map(one_shot).to_vec();
    println!("greedy: states, estimate before, error {greedy:?}");
    println!("hypercube: states, error {hypercube:?}");
    let needed =
        |all: &[(usize, f64)], error: f64| all.iter().find(|(_, e)| *e <= error).map_or(usize::MAX, |(n, _)| *n);
    let errors: Vec<(usize, f64)> = greedy.iter().map(|(n, _, e)| (*n, *e)).collect();
    let reached = hypercube.iter().find(|(n, _)| *n == 24).expect("it was run").1;
    assert!(needed(&errors, reached) <= needed(&hypercube, reached), "{reached:e}");
}

const STUDY: &str = r#"
kind = "reduction"
question = "How few?"
expectation = "Few."
scene = "scene.toml"
tolerance = "1 %"
training = { kind = "greedy", states = 18, start = 8, batch = 3, candidates = 60, tolerance = "0.0001 %" }
held_back = 20
modes = [3, 5]
[[input]]
name = "tension"
key = "constraint.cable.drive.signal"
range = ["0 N", "0.4 N"]
[[input]]
name = "weight"
key = "effect.gravity.acceleration"
range = ["-10 m/s^2", "10 m/s^2"]
[[quantity]]
name = "xmax_z_m"
label = "height of the tip"
symbol = "z"
unit = "m"
[meshes]
coarse = { "mesh.grid.divisions" = [4, 1, 1] }
[reference]
"mesh.grid.divisions" = [16, 4, 4]
"#;

fn json(file: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(file).expect("it is there")).expect("JSON")
}

/// A search is of ordinary cases: one that was cut off goes on to the same states, models and bits, it ends at its number of states, and the report says how
/// the estimate fell. Meshes are compared at the same states: the coarse one is farther from the fine one than the mesh of the models.
#[test]
fn a_search_is_continued_with_the_same_bits() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    std::fs::write(at.join("scene.toml"), SCENE).expect("room");
    std::fs::write(at.join("study.toml"), STUDY).expect("room");
    // A part runs what is known, and says that the search waits
    let part = ["run", "study.toml", "--out", "whole", "--partition", "1/1"];
    let (code, words) = durometer(at, &part).code_and_said();
    assert_eq!(code, Some(0), "{words}");
    assert!(words.contains("the search for further cases waits for a run of the study without --partition"), "{words}");
    assert!(!at.join("whole/growth.json").exists());
    let (code, words) = durometer(at, &["run", "study.toml", "--out", "whole"]).code_and_said();
    assert_eq!(code, Some(0), "{words}");
    let (code, words) = durometer(at, &part).code_and_said();
    assert!(code == Some(0) && !words.contains("the search for further cases"), "{words}");
    let derived = json(&at.join("whole/derived.json"));
    let search: Vec<(u64, f64)> = derived["search"]
        .as_array()
        .expect("steps")
        .iter()
        .map(|s| (s["states"].as_u64().expect("a number"), s["largest"].as_f64().expect("an estimate")))
        .collect();
    println!("{search:?}");
    let counts: Vec<u64> = search.iter().map(|s| s.0).collect();
    assert_eq!(counts, [8, 11, 14, 17, 18]);
    assert!(search[4].1 < 0.5 * search[0].1, "{search:?}");
    assert_eq!(derived["training"], 18);
    let page = std::fs::read_to_string(at.join("whole/index.html")).expect("a page");
    assert!(page.contains("The search began with 8 states and ended with 18"));
    for name in ["search", "meshes", "work-precision"] {
        assert!(at.join(format!("whole/figures/{name}.svg")).is_file(), "{name}");
    }
    let of = &derived["comparison"];
    let error = |k: usize| of["meshes"][k]["errors"][0].as_f64().expect("a number");
    assert!(error(1) > error(0) && error(0) > 0.0, "{of}");
    let models: Vec<f64> = (0..2).map(|k| of["models"][k][0].as_f64().expect("a number")).collect();
    // The triangle inequality, with the error of the model from its own mesh
    for (k, distance) in models.iter().enumerate() {
        let own = derived["models"][k]["quantities"][0]["largest"].as_f64().expect("a number");
        assert!((distance - error(0)).abs() <= own, "{distance} {own} {of}");
    }

    // Cut off after the first batch: the file of the search without its later rounds, and the results without their cases
    let mut growth = json(&at.join("whole/growth.json"));
    let rounds = growth["rounds"].as_array_mut().expect("rounds");
    let later: Vec<String> =
        rounds[1..].iter().flat_map(|r| r["members"].as_object().expect("members").keys().cloned()).collect();
    assert_eq!(later.len(), 7, "{later:?}");
    rounds.truncate(1);
    std::fs::write(at.join("whole/growth.json"), growth.to_string()).expect("room");
    let model = at.join("whole/models/whole-5.durom");
    let model = if model.is_file() {
        model
    } else {
        at.join("whole").join(derived["models"][1]["file"].as_str().expect("a file"))
    };
    let before = std::fs::read(&model).expect("a model");
    for label in later {
        for file in std::fs::read_dir(at.join("whole/cases")).expect("cases").flatten() {
            if file.file_name().to_string_lossy().contains(&format!("static-{label}.")) {
                std::fs::remove_file(file.path()).expect("it is a file");
            }
        }
    }
    std::fs::remove_file(at.join("whole/derived.json")).expect("it was there");
    let (code, words) = durometer(at, &["run", "study.toml", "--out", "whole"]).code_and_said();
    assert_eq!(code, Some(0), "{words}");
    assert!(std::fs::read(&model).expect("a model") == before, "the same states give the same bits");
    // Another range is another search
    std::fs::write(at.join("study.toml"), STUDY.replacen("\"0.4 N\"", "\"0.3 N\"", 1)).expect("room");
    let (code, words) = durometer(at, &["run", "study.toml", "--out", "whole"]).code_and_said();
    assert_eq!(code, Some(0), "{words}");
    assert_eq!(json(&at.join("whole/derived.json"))["training"], 18);
}

/// A run of the library goes on to the end of the search, as that of the program does: the report is of all its states.
#[test]
fn a_run_of_the_library_ends_its_search() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let without_meshes = STUDY.split("[meshes]").next().expect("the first part");
    let few = without_meshes.replace("states = 18, start = 8, batch = 3", "states = 10, start = 8, batch = 1");
    std::fs::write(at.join("scene.toml"), SCENE).expect("room");
    std::fs::write(at.join("study.toml"), few).expect("room");
    let records = run_folder(at);
    let added = records.iter().filter(|record| record.id.contains("greedy-")).count();
    assert_eq!(added, 2, "{:?}", records.iter().map(|record| &record.id).collect::<Vec<_>>());
    let results = at.join("results");
    assert!(Rounds::read(&results).has_ended());
    write_report(&results).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(json(&results.join("derived.json"))["training"], 10);
}

/// Plans that cannot be are refused before anything runs.
#[test]
fn mistakes_of_a_plan_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    std::fs::write(at.join("scene.toml"), SCENE).expect("room");
    let plan = "{ kind = \"greedy\", states = 18, start = 8, batch = 3, candidates = 60, tolerance = \"0.0001 %\" }";
    for (plan_or_key, to, word) in [
        (plan, "{ kind = \"greedy\", states = 18, start = 2 }", "begin with three"),
        (plan, "{ kind = \"greedy\", states = 18, batch = 0 }", "batches of 0"),
        (plan, "{ kind = \"greedy\", states = 18, tolerance = \"0 %\" }", "tolerance"),
        (plan, "{ kind = \"greedy\", states = 18, steps = 1 }", "steps"),
        (plan, "{ kind = \"random\", states = 18 }", "random"),
        (plan, "{ kind = \"grid\", each = 3 }", "9 states for 5 modes"),
        (plan, "{ kind = \"grid\", each = 100000 }", "more than 100000 states"),
        (plan, "-4", "-4"),
        ("\"effect.gravity.acceleration\"", "\"mesh.grid.size.0\"", "no modes in common"),
        ("\"effect.gravity.acceleration\"", "\"effect.gravity.density\"", "acceleration of the weight"),
        ("\"effect.gravity.acceleration\"", "\"laws.rubber.law\"", "law"),
        ("\"effect.gravity.acceleration\"", "\"laws.rubber.E\"", "two sets of constants"),
        ("\"effect.gravity.acceleration\"", "\"laws.gel.mu\"", "gel"),
        ("[reference]\n\"mesh.grid.divisions\" = [16, 4, 4]", "", "reference"),
    ] {
        assert!(STUDY.contains(plan_or_key), "{plan_or_key}");
        std::fs::write(at.join("study.toml"), STUDY.replacen(plan_or_key, to, 1)).expect("room");
        let (code, words) = durometer(at, &["run", "study.toml", "--out", "refused"]).code_and_said();
        assert_eq!(code, Some(2), "{to}: {words}");
        assert!(words.contains(word), "{to}: {words}");
    }
}
