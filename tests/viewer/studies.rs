//! The page of a study in three dimensions: motion where it is recorded, the key that records it where it is not, its size; and the shares of cells in an error.

use crate::common::program::{ROOT, durometer};
use durometer::report::viewer::film::Film;
use durometer::report::viewer::footage::{About, hollow};
use durometer::report::viewer::pack::{Packed, pack};
use durometer::report::viewer::page;
use durometer::report::viewer::shape::Limits;
use durometer::report::viewer::unpack::unpack;
use durometer::scene::{ErrorEstimator, RunOptions, Scene, SceneBuilder};
use durometer::study::store::record::{CaseRecord, Series, StoredCase, StudyRecord};
use durometer::study::store::results::{self, Results};
use durometer::study::view;
use durometer::system::State;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// The study of `tests/cli` in a folder, its scene with these lines at the end.
fn study(folder: &Path, lines: &str) -> PathBuf {
    let root = Path::new(ROOT);
    let scene = std::fs::read_to_string(root.join("tests/cli/scene.toml")).expect("a scene");
    let scene = scene.replace("../bad/good/boxes.msh", &text(&root.join("tests/bad/good/boxes.msh")));
    std::fs::write(folder.join("scene.toml"), format!("{scene}\n{lines}\n")).expect("room");
    std::fs::copy(root.join("tests/cli/study.toml"), folder.join("study.toml")).expect("room");
    folder.join("study.toml")
}

fn states(case: &Packed) -> usize {
    case.head["times"].as_array().expect("times").len()
}

/// With the key the slider of the page has every state of each case, as its own page has it; without it the page names the key.
#[test]
fn the_page_of_a_study_has_the_motion_that_its_scene_records() {
    let folder = TempDir::new().expect("a temporary folder");
    let file = study(folder.path(), "[output]\nfields = { what = [\"displacement\", \"stress\"] }");
    let out = folder.path().join("results");
    let run = || durometer(ROOT, &["run", &text(&file), "--out", &text(&out)]);
    let output = run();
    assert!(output.is_success(), "{}", output.err);
    let shown = page::read(&out.join("view.html")).expect("a page");
    assert_eq!(shown.len(), 3);
    for case in &shown {
        let own = page::read(&out.join(format!("cases/{}.view.html", case.title()))).expect("a page");
        assert_eq!(own[0], *case);
        let csv = std::fs::read_to_string(out.join(format!("cases/{}.csv", case.title()))).expect("a series");
        assert_eq!(states(case), csv.lines().count() - 1, "one state for each row");
        assert!(case.head["motion"]["error"].as_f64().is_some_and(|e| e > 0.0 && e < 1e-5), "{}", case.head["motion"]);
        assert!(case.head["fields"].to_string().contains("\"name\":\"stress\""));
        assert_eq!(case.head["still"], "");
    }
    let index = std::fs::read_to_string(out.join("index.html")).expect("the report");
    assert!(index.contains("The cases in three dimensions</a>, with their motion."));
    // The page belongs to the stored files: a changed one is noticed, named in the report, and computed again
    let page = out.join("cases/sizes-length-nominal.view.html");
    let sound = std::fs::read_to_string(&page).expect("a page");
    std::fs::write(&page, sound.replacen("\"nodes\":", "\"nodes\":9", 1)).expect("room");
    let damaged = results::read(&out).expect("results").damaged;
    assert!(damaged.iter().any(|d| d.contains("its data do not fit together")), "{damaged:?}");
    assert!(damaged.iter().any(|d| d.contains("nominal.view.html: its contents are not those")), "{damaged:?}");
    let output = run();
    assert!(output.is_success(), "{}", output.err);
    assert!(results::read(&out).expect("results").damaged.is_empty());

    let file = study(folder.path(), "");
    let output = durometer(ROOT, &["run", &text(&file), "--out", &text(&out)]);
    assert!(output.is_success(), "{}", output.err);
    assert!(!page.exists(), "the page of the result before");
    for case in page::read(&out.join("view.html")).expect("a page") {
        let still = case.head["still"].as_str().expect("text");
        assert!(states(&case) == 1 && still.contains("`[output] fields = { what = [\"displacement\"] }`"), "{still}");
    }
}

/// A body of 36 000 cells that bends and twists.
fn bar(element: &str) -> (Scene, impl Fn(&Scene, usize) -> State) {
    let scene = format!(
        "[mesh]\ngrid = {{ kind = \"box\", size = [\"100 mm\", \"20 mm\", \"20 mm\"], divisions = [60, 10, 10] }}\nelement = \"{element}\"\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"1 MPa\"\nnu = 0.45\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
    );
    let scene = SceneBuilder::parse(&scene).and_then(SceneBuilder::build).expect("a scene");
    let state = |scene: &Scene, k: usize| {
        let mut state = scene.start();
        state.t = k as f64 / 10.0;
        for (n, p) in scene.body.mesh.points.iter().enumerate() {
            let (turn, twist) = (1.3 * state.t * p.x / 0.1 + 1e-9, 0.8 * (6.0 * state.t).sin() * p.x / 0.1);
            let (y, z) = (p.y * twist.cos() - p.z * twist.sin(), p.y * twist.sin() + p.z * twist.cos());
            let radius = p.x / turn;
            let x = [(radius - z) * turn.sin(), y, radius - (radius - z) * turn.cos()];
            (0..3).for_each(|i| state.x[3 * n + i] = x[i] - p[i]);
        }
        state
    };
    (scene, state)
}

/// Results of cases with these motions and nothing else.
fn stored(motions: BTreeMap<String, Packed>) -> Results {
    let case = |id: &String| {
        let record = CaseRecord { id: id.clone(), ..CaseRecord::default() };
        StoredCase::new(record, Series { t_s: vec![], columns: BTreeMap::new() })
    };
    let study = serde_json::json!({
        "study": "bars", "kind": "convergence", "question": "", "expectation": "", "tolerance": 0.05, "quantities": {}, "variants": [], "families": [],
        "version": "",
    });
    let study: StudyRecord = serde_json::from_value(study).expect("a record");
    let (skins, found, sensitivities) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let cases = motions.keys().map(case).collect();
    Results { study, cases, skins, motions, found, sensitivities, derived: None, damaged: vec![], outdated: vec![] }
}

/// The page of a study whose finest meshes have 36 000 cells stays below 5 MB with the motion of all of them.
#[test]
fn a_study_of_36_000_cells_moves_within_5_mb() {
    let of = |element: &str| {
        let (scene, state) = bar(element);
        let mut film = Film::new(&scene, &[], &Limits::USUAL);
        (0..11).for_each(|k| film.add(&scene, &state(&scene, k)));
        film.finish(&scene, About { title: element.into(), ..About::default() })
    };
    let (linear, quadratic) = (of("tet4"), of("tet10"));
    // What is unpacked is what was packed, and the inside can be left out afterwards
    for case in [&linear, &quadratic] {
        assert_eq!(pack(&unpack(case).expect("sound")), *case);
    }
    let surface = pack(&hollow(&unpack(&quadratic).expect("sound")));
    assert!(surface.data.len() < quadratic.data.len() / 2, "{} and {}", surface.data.len(), quadratic.data.len());
    assert!(surface.notes().iter().any(|n| n.contains("hollow")), "{:?}", surface.notes());
    let many =
        ["a", "b", "c"].iter().flat_map(|k| [(format!("{k}4"), linear.clone()), (format!("{k}10"), quadratic.clone())]);
    let shown = view::cases(&stored(many.collect()));
    let html = page::page("bars", &shown);
    println!("{} bytes for {} cases", html.len(), shown.len());
    assert!(shown.len() == 6 && shown.iter().all(|case| states(case) == 11) && html.len() <= 5_000_000);
    // Where even that is too much, the page says what is not there
    let many = 2 + 3_500_000 / surface.data.len();
    let last = format!("case-{:02}", many - 1);
    let shown = view::cases(&stored((0..many).map(|k| (format!("case-{k:02}"), surface.clone())).collect()));
    let html = page::page("bars", &shown);
    assert!(html.len() <= 5_000_000 && shown.len() < many);
    assert!(shown[0].notes().iter().any(|n| n.contains("Left out") && n.contains(&last)), "{:?}", shown[0].notes());
}

/// The colour is that of the estimate: its shares by cell, which add up to at least the error.
#[test]
fn the_page_of_a_run_shows_the_shares_of_the_cells_in_an_error() {
    let folder = TempDir::new().expect("a temporary folder");
    let scene = "[mesh]\ngrid = { kind = \"box\", size = [\"40 mm\", \"10 mm\", \"10 mm\"], divisions = [6, 2, 2] }\nelement = \"tet4\"\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"1 MPa\"\nnu = 0.3\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n[[effect]]\nkind = \"traction\"\nregion = \"xmax\"\ndirection = [0, 0, 1]\n\
         traction = { kind = \"ramp\", from = \"0 kPa\", to = \"1 kPa\", start = \"0 s\", end = \"1 s\" }\n\
         [[probe]]\nkind = \"position\"\nregion = \"xmax\"\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.5 s\"\n";
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, scene).expect("room");
    let args = ["simulate", &text(&file), "--out", &text(folder.path()), "--error", "xmax_z_m", "--error-cells"];
    let output = durometer(ROOT, &args);
    assert!(output.is_success(), "{}", output.err);
    let case = unpack(&page::read(&folder.path().join("scene.html")).expect("a page")[0]).expect("sound");
    let field = case.fields.iter().find(|f| f.name == "share in the error of the xmax z").expect("the shares");
    assert_eq!((field.unit.as_str(), field.at_nodes), ("m", false));

    let scene = SceneBuilder::parse(scene).and_then(SceneBuilder::build).expect("a scene");
    let mut estimator = ErrorEstimator::new(&scene).and_then(ErrorEstimator::localised).expect("an estimate");
    let run = scene.run_with(RunOptions { on_state: Some(&mut |s: &State| estimator.add(s)), ..RunOptions::default() });
    let found = estimator.estimate(&run, &["xmax_z_m".into()]).expect("an estimate");
    let shares = &found.cells[0].size;
    for state in 0..case.times.len() {
        let shown = field.modes.at(state);
        assert_eq!(shown.len(), shares.len());
        for (a, b) in shown.iter().zip(shares) {
            // Single precision, and the stated error of the page
            assert!((a - b).abs() <= field.modes.error + 1e-6 * b.abs(), "{a} for {b}");
        }
    }
    let sum: f64 = shares.iter().sum();
    let signed: f64 = found.cells[0].signed.iter().sum();
    assert!(sum >= signed.abs() && signed.abs() > 0.0, "{sum} and {signed}");
    let plain = durometer(ROOT, &["simulate", &text(&file), "--out", &text(folder.path())]);
    assert!(plain.is_success());
    let case = &page::read(&folder.path().join("scene.html")).expect("a page")[0];
    assert!(case.head["absent"].to_string().contains("--error COLUMN --error-cells"), "{}", case.head["absent"]);
}
