//! A stored result counts only for the inputs, the files and the build that made it.

use durometer::material::{Chosen, Law, LawEntry, LawInfo, Moduli, Values, find, moduli, neo_hookean, register_anew};
use durometer::scene::Progress;
use durometer::study::expand::Study;
use durometer::study::report;
use durometer::study::run::growing::run_study;
use durometer::study::run::only::Only;
use durometer::study::run::runner::{Options, Watch};
use durometer::study::store::folder::Store;
use durometer::study::store::record::CaseRecord;
use durometer::study::store::seal::sealed;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

const SCENE: &str = r#"
title = "A block that is pressed on a plate"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [2, 1, 1] }
[laws.rubber]
include = "law.toml"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "zmax"
components = "xy"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = { kind = "table", file = "way.csv", unit = "mm" }
[[contact]]
name = "plate"
region = "zmin"
obstacle = { kind = "surface", file = "plate.stl", unit = "mm" }
response = "penalty"
friction = 0
[[skin]]
name = "glove"
file = "glove.stl"
unit = "mm"
reach = "1 mm"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "reaction"
region = "zmax"
"#;
const STUDY: &str = r#"
kind = "comparison"
reference = "one"
question = "Does a result belong to its files?"
expectation = "Yes."
scene = "scene.toml"
tolerance = "5 %"
[[variant]]
name = "press"
quantity = [{ name = "zmax_reaction_z_N", label = "force", symbol = "F", unit = "N" }]
[[family]]
name = "ways"
role = "members"
[family.members]
one = {}
other = { "constraint.prescribed.displacement.file" = "other.csv" }
"#;
const LAW: &str = "law = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.3\n";

/// A plate of 60 mm × 60 mm × 2 mm whose top is at `top` \[mm\], closed, with outward normals.
fn plate(top: f64) -> String {
    let corner = |k: usize| {
        let pick = |bit: usize, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        [pick(0, -20.0, 40.0), pick(1, -20.0, 40.0), pick(2, top - 2.0, top)]
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid plate\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid plate\n"
}

/// One triangle on the top of the block, `x` \[mm\] from its end.
fn glove(x: f64) -> String {
    format!(
        "solid g\nfacet normal 0 0 1\nouter loop\nvertex {x} 2 10\nvertex 12 2 10\nvertex {x} 8 10\nendloop\nendfacet\nendsolid g\n"
    )
}

/// The cases that were computed, not kept.
#[derive(Default)]
struct Computed(Mutex<Vec<String>>);

impl Watch for Computed {
    fn finished(&self, record: &CaseRecord, skipped: bool) {
        if !skipped {
            self.0.lock().expect("no panic").push(record.member.clone());
        }
    }
}

fn computed_with(folder: &Path, accept_build: bool) -> Vec<String> {
    computed_of(folder, accept_build, None)
}

/// The same of a run that takes only cases with this text in their ids.
fn computed_of(folder: &Path, accept_build: bool, only: Option<&str>) -> Vec<String> {
    let study = Study::read(&folder.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let (stop, watch) = (AtomicBool::new(false), Computed::default());
    let options = Options { jobs: 1, accept_build, only: only.map(Only::from), ..Options::new(&stop) };
    let records = run_study(&study, &folder.join("results"), &options, &watch).unwrap_or_else(|e| panic!("{e}"));
    assert!(records.iter().all(CaseRecord::converged), "{records:?}");
    let mut cases = watch.0.into_inner().expect("no panic");
    cases.sort();
    cases
}

fn computed(folder: &Path) -> Vec<String> {
    computed_with(folder, false)
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plate = plate(-0.5);
    let files = [
        ("scene.toml", SCENE),
        ("study.toml", STUDY),
        ("law.toml", LAW),
        ("way.csv", "t_s,w\n0,0\n1,-1\n"),
        ("other.csv", "t_s,w\n0,0\n1,-2\n"),
        ("plate.stl", plate.as_str()),
    ];
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("writable");
    }
    std::fs::write(folder.path().join("glove.stl"), glove(4.0)).expect("writable");
    folder
}

/// Exactly the cases that read a file are computed again when it changes.
#[test]
fn a_changed_file_is_seen() {
    let keep = folder();
    let at = keep.path();
    assert_eq!(computed(at), ["one", "other"]);
    assert_eq!(computed(at), [""; 0]);
    let change = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("writable");
    change("way.csv", "t_s,w\n0,0\n1,-1.5\n");
    assert_eq!(computed(at), ["one"]);
    change("other.csv", "t_s,w\n0,0\n1,-2.5\n");
    assert_eq!(computed(at), ["other"]);
    for (name, text) in [("plate.stl", plate(-0.4)), ("glove.stl", glove(5.0)), ("law.toml", LAW.replace("100", "110"))]
    {
        change(name, &text);
        assert_eq!(computed(at), ["one", "other"], "{name}");
        assert_eq!(computed(at), [""; 0], "{name}");
    }
}

/// A run of some cases leaves the results of the others: those of other inputs do not count, are said to be so, and count again with their inputs.
#[test]
fn a_run_of_some_cases_leaves_the_results_of_the_others() {
    let keep = folder();
    let at = keep.path();
    computed(at);
    let other = at.join("results/cases/ways-press-other.json");
    let before = std::fs::read(&other).expect("stored");
    std::fs::write(at.join("law.toml"), LAW.replace("100", "110")).expect("writable");
    assert_eq!(computed_of(at, false, Some("one")), ["one"]);
    assert_eq!(std::fs::read(&other).expect("it stays"), before);
    let summary = report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(summary.outdated, ["ways-press-other"]);
    assert_eq!(summary.cases.iter().map(|c| c.id.as_str()).collect::<Vec<_>>(), ["ways-press-one"]);
    let warned = |w: &String| w.contains("result of case ways-press-other is of other inputs");
    assert!(summary.warnings.iter().any(warned), "{:?}", summary.warnings);
    std::fs::write(at.join("law.toml"), LAW).expect("writable");
    assert_eq!(computed_of(at, false, Some("one")), ["one"]);
    let counted = report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}"));
    assert!(counted.outdated.is_empty() && counted.cases.len() == 2, "{:?}", counted.outdated);
    assert_eq!(computed(at), [""; 0]);
    assert_eq!(std::fs::read(&other).expect("it stays"), before);
}

/// A law that this process has registered may be another one by now, of which neither files nor build tell.
#[test]
fn results_of_a_registered_law_are_not_kept() {
    let multiple = |factor: f64| {
        let make = move |values: &Values, _: &Chosen| {
            let given = Moduli::from_map(values)?;
            find("neo_hookean")?.build_with(&[factor * given.e, given.nu], &[])
        };
        let rates = |law: &dyn Law, given: &Values, key: &str| law.small_strain().rates(given, key);
        let info: &'static LawInfo = Box::leak(Box::new(LawInfo { name: "of_this_process", ..neo_hookean::INFO }));
        register_anew(LawEntry::made_by(info, moduli::KEYS, &[100e3, 0.4], make, rates)).expect("a name of its own");
    };
    let keep = folder();
    let at = keep.path();
    std::fs::write(at.join("law.toml"), LAW.replace("neo_hookean", "of_this_process")).expect("writable");
    multiple(1.0);
    let notes = Notes::default();
    let force = || {
        let study = Study::read(&at.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
        let stop = AtomicBool::new(false);
        let records = run_study(&study, &at.join("results"), &Options { jobs: 1, ..Options::new(&stop) }, &notes);
        records.unwrap_or_else(|e| panic!("{e}"))[0].probes["zmax_reaction_z_N"].last
    };
    let before = force();
    multiple(2.0);
    let after = force();
    assert!((after / before - 1.0).abs() > 0.1, "{before} N, then {after} N");
    let notes = notes.0.into_inner().expect("no panic");
    assert!(notes.len() == 2 && notes.iter().all(|note| note.contains("its law is one of this process")), "{notes:?}");
}

/// Stops the run when the first case is finished.
struct Stops<'a>(&'a AtomicBool);

impl Watch for Stops<'_> {
    fn finished(&self, _: &CaseRecord, _: bool) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A run that is stopped after an edit leaves new and old results: a report does not mix them.
#[test]
fn a_stopped_run_leaves_no_mixture() {
    let keep = folder();
    let at = keep.path();
    computed(at);
    std::fs::write(at.join("law.toml"), LAW.replace("100", "110")).expect("writable");
    let study = Study::read(&at.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let stop = AtomicBool::new(false);
    let options = Options { jobs: 1, ..Options::new(&stop) };
    let records = run_study(&study, &at.join("results"), &options, &Stops(&stop)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(records.len(), 1);
    let summary = report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((summary.cases.len(), summary.outdated.len()), (1, 1));
    assert_eq!(summary.cases[0].id, records[0].id);
    let all = ["one", "other"].map(|name| at.join(format!("results/cases/ways-press-{name}.json")));
    assert!(all.iter().all(|record| record.is_file()), "nothing is lost");
    assert_eq!(computed(at).len(), 1);
    assert!(report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}")).outdated.is_empty());
}

/// Changes the surface of the obstacle when the first case is finished.
struct Meddles<'a>(&'a Path);

impl Watch for Meddles<'_> {
    fn finished(&self, _: &CaseRecord, _: bool) {
        std::fs::write(self.0.join("plate.stl"), plate(-0.4)).expect("writable");
    }
}

/// Keeps what is noted.
#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Watch for Notes {
    fn note(&self, case: &str, text: &str) {
        self.0.lock().expect("no panic").push(format!("{case}: {text}"));
    }
}

/// A case that is computed after a file has changed has no result: other cases of the same run have the file of before.
#[test]
fn a_file_that_changes_during_a_run_leaves_no_mixture() {
    let keep = folder();
    let at = keep.path();
    let study = Study::read(&at.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let stop = AtomicBool::new(false);
    let options = Options { jobs: 1, ..Options::new(&stop) };
    let records = run_study(&study, &at.join("results"), &options, &Meddles(at)).unwrap_or_else(|e| panic!("{e}"));
    let (one, other) = (&records[0], &records[1]);
    assert!(one.converged() && other.status == "InputsChanged", "{records:?}");
    assert!(other.status_detail.as_ref().is_some_and(|why| why.contains("plate.stl")), "{other:?}");
    let summary = report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}"));
    assert!(summary.cases.iter().all(|c| c.id != other.id || c.status == "InputsChanged"), "{:?}", summary.cases);
    assert_eq!(computed(at), ["one", "other"]);
}

const SEARCH: &str = r#"
kind = "calibration"
question = "Is an edit seen that is taken back?"
expectation = "Yes."
scene = "search.toml"
tolerance = "2 %"
[calibration]
unknown = ["laws.rubber.E"]
weighting = "absolute"
[[variant]]
name = "press"
quantity = [{ name = "zmax_reaction_z_N", label = "force", symbol = "F", unit = "N" }]
[variant.measured]
file = "measured.csv"
x = { column = "t", unit = "s", is = "t_s" }
y = { column = "F", unit = "N", is = "zmax_reaction_z_N" }
[[family]]
name = "sizes"
role = "sizes"
[family.members]
a = {}
"#;

/// Edits a table after some states of a search, and takes the edit back after some more.
struct Edits<'a> {
    folder: &'a Path,
    from: usize,
    to: usize,
    states: Mutex<usize>,
}

impl Watch for Edits<'_> {
    fn progress(&self, _: &str, _: Progress) {
        let mut states = self.states.lock().expect("no panic");
        *states += 1;
        let write = |text: &str| std::fs::write(self.folder.join("way.csv"), text).expect("writable");
        match *states {
            k if k == self.from => write("t_s,w\n0,0\n1,-0.5\n"),
            k if k == self.to => write(WAY),
            _ => {}
        }
    }
}

const WAY: &str = "t_s,w\n0,0\n1,-1\n";

/// A search reads its files again and again. Whenever one of them was edited, the edit taken back or not, the result is that of the files or there is none.
#[test]
fn an_edit_during_a_search_is_seen_though_it_is_taken_back() {
    let found = |from: usize, to: usize| {
        let keep = folder();
        let at = keep.path();
        let scene = SCENE.split("[[contact]]").next().expect("the first part").replace(
            "constraint]]\nkind = \"fixed\"\nregion = \"zmax\"\ncomponents = \"xy\"",
            "constraint]]\nkind = \"fixed\"\nregion = \"zmin\"",
        );
        let rest = &SCENE[SCENE.find("[[stage]]").expect("a stage")..];
        let files = [("search.toml", scene + rest), ("search-study.toml", SEARCH.into()), ("way.csv", WAY.into())];
        for (name, text) in files {
            std::fs::write(at.join(name), text).expect("writable");
        }
        std::fs::write(at.join("measured.csv"), "t,F\n0.5,-0.7\n1,-1.5\n").expect("writable");
        let study = Study::read(&at.join("search-study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
        let stop = AtomicBool::new(false);
        let watch = Edits { folder: at, from, to, states: Mutex::new(0) };
        let records = run_study(&study, &at.join("results"), &Options { jobs: 1, ..Options::new(&stop) }, &watch);
        let records = records.unwrap_or_else(|e| panic!("{e}"));
        let values = Store::at(&at.join("results")).calibration(&records[0].id).map(|found| found.values());
        let states = *watch.states.lock().expect("no panic");
        (records[0].status.clone(), values, states)
    };
    let (status, undisturbed, states) = found(usize::MAX, usize::MAX);
    assert!(status == "Converged" && undisturbed.is_some() && states > 5, "{status}, {undisturbed:?}, {states}");
    let mut seen = 0;
    for from in 1..states {
        for to in [from + states / 3, usize::MAX] {
            let (status, values, _) = found(from, to);
            match values {
                Some(_) => assert_eq!((status.as_str(), &values), ("Converged", &undisturbed), "{from} to {to}"),
                None => {
                    assert_eq!(status, "InputsChanged", "{from} to {to}");
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 6, "{seen}");
}

/// A name of a case that would give its files the names of those of another one is refused.
#[test]
fn a_case_that_is_called_like_a_file_of_another_is_refused() {
    let keep = folder();
    for end in ["fit", "search", "skin", "sensitivities", "damaged-1"] {
        let named = STUDY.replace("other = {", &format!("\"one.{end}\" = {{"));
        std::fs::write(keep.path().join("study.toml"), named).expect("writable");
        let why = Study::read(&keep.path().join("study.toml"), &[]).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(why.contains("would have the names of files of another case"), "{end}: {why}");
    }
}

/// A case that is refused, as its study expects, was not computed: no file of it has changed.
#[test]
fn a_case_that_is_refused_has_no_changed_file() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/hard-cases/study.toml");
    let study = Study::read(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
    let (stop, watch) = (AtomicBool::new(false), Notes::default());
    let only = Some(Only::from("finger-overpull-tet4-pull-110"));
    let options = Options { jobs: 1, only, ..Options::new(&stop) };
    let records = run_study(&study, keep.path(), &options, &watch).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((records.len(), records[0].status.as_str()), (1, "Refused"));
    let notes = watch.0.into_inner().expect("no panic");
    assert!(!notes.iter().any(|note| note.contains("has changed")), "{notes:?}");
}

/// A table of results that is not the one that was stored is computed again: deleted, cut off, or that of another case.
#[test]
fn a_damaged_result_is_computed_again() {
    let keep = folder();
    let at = keep.path();
    computed(at);
    let cases = at.join("results/cases");
    let [one, other] = ["one", "other"].map(|name| cases.join(format!("ways-press-{name}.csv")));
    let sound = std::fs::read(&one).expect("stored");
    std::fs::remove_file(&one).expect("there");
    assert_eq!(computed(at), ["one"]);
    std::fs::write(&one, &sound[..sound.len() / 2]).expect("writable");
    assert_eq!(computed(at), ["one"]);
    std::fs::copy(&other, &one).expect("both are there");
    assert_eq!(computed(at), ["one"]);
    assert_eq!(std::fs::read(&one).expect("stored"), sound);
    let record = cases.join("ways-press-one.json");
    std::fs::write(&record, "{").expect("writable");
    assert_eq!(computed(at), ["one"]);
    let text = std::fs::read_to_string(&record).expect("stored");
    std::fs::write(&record, text.replacen("\"steps\": ", "\"steps\": 1", 1)).expect("writable");
    let page = report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}")).warnings.join("\n");
    assert!(page.contains("cases/ways-press-one.json: its contents are not those that were stored"), "{page}");
    assert_eq!(computed(at), ["one"]);
}

/// A result of another build is computed again, or kept where that is asked for; then the report names it.
#[test]
fn another_build_is_seen() {
    let keep = folder();
    let at = keep.path();
    computed(at);
    let path = at.join("results/cases/ways-press-one.json");
    let text = std::fs::read_to_string(&path).expect("stored");
    let own = env!("CARGO_PKG_VERSION");
    let stored: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let source = stored["provenance"]["build"]["source_sha256"].as_str().expect("a digest").to_string();
    let own_digest = stored["provenance"]["record_sha256"].as_str().expect("a digest");
    let of_another = text.replace(own_digest, "").replace(&source, &"0".repeat(64));
    std::fs::write(&path, sealed(&of_another)).expect("writable");
    assert_eq!(computed_with(at, true), [""; 0]);
    let said = report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}")).warnings.join("\n");
    assert!(said.contains(&format!("ways-press-one ({own}, sources 000000000000")), "{said}");
    assert_eq!(computed(at), ["one"]);
    let said = report::write_report(&at.join("results")).unwrap_or_else(|e| panic!("{e}")).warnings.join("\n");
    assert!(!said.contains("other builds"), "{said}");
}
