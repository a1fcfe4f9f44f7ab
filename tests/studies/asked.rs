//! A stored result counts only if it has what the study asks of its cases now, and a report shows no more than that.

use durometer::study::expand::Study;
use durometer::study::listing::{State, list};
use durometer::study::run::growing::run_study;
use durometer::study::run::runner::{Options, Watch};
use durometer::study::store::record::CaseRecord;
use durometer::study::store::results;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

const SCENE: &str = r#"
title = "A block that is pressed"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [2, 1, 1] }
[laws.rubber]
law = "neo_hookean"
mu = "40 kPa"
nu = 0.3
provenance = { mu_interval = ["38 kPa", "42 kPa"] }
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
displacement = { kind = "ramp", from = "0 mm", to = "-1 mm", start = "0 s", end = "1 s" }
components = "z"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "reaction"
region = "zmax"
"#;
const FORCE: &str = "{ name = \"zmax_reaction_z_N\", label = \"force\", symbol = \"F\", unit = \"N\" }";

fn study(kind: &str, keys: &str, quantities: &[&str]) -> String {
    format!(
        r#"
kind = "{kind}"
question = "Has a result what is asked for?"
expectation = "Yes."
scene = "scene.toml"
tolerance = "5 %"
{keys}
[[variant]]
name = "press"
quantity = [{}]
[[family]]
name = "sizes"
role = "sizes"
[family.members]
n1 = {{}}
n2 = {{ "mesh.grid.divisions" = [4, 2, 2] }}
"#,
        quantities.join(", ")
    )
}

/// Counts what is computed.
#[derive(Default)]
struct Computed(AtomicUsize);

impl Watch for Computed {
    fn finished(&self, _: &CaseRecord, skipped: bool) {
        self.0.fetch_add(usize::from(!skipped), Ordering::Relaxed);
    }
}

/// Writes the study and runs it: what was computed, what `cases` has said before, and the records as a report takes them.
fn after(at: &Path, text: &str) -> (usize, Vec<State>, Vec<CaseRecord>) {
    std::fs::write(at.join("study.toml"), text).expect("room");
    let study = Study::read(&at.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let states = list(&study, &at.join("r")).into_iter().map(|c| c.state).collect();
    let (stop, watch) = (AtomicBool::new(false), Computed::default());
    run_study(&study, &at.join("r"), &Options { jobs: 1, ..Options::new(&stop) }, &watch)
        .unwrap_or_else(|e| panic!("{e}"));
    let found = results::read(&at.join("r")).unwrap_or_else(|e| panic!("{e}"));
    (watch.0.into_inner(), states, found.cases.into_iter().map(|c| c.record).collect())
}

#[test]
fn a_kept_result_has_what_a_new_one_would_have() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    std::fs::write(at.join("scene.toml"), SCENE).expect("room");
    let (kept, partial) = (vec![State::Stored; 2], vec![State::Partial; 2]);
    let estimated = |records: &[CaseRecord]| records.iter().filter(|r| r.one_run.is_some()).count();
    let with_inputs = |records: &[CaseRecord]| records.iter().filter(|r| !r.inputs.is_empty()).count();

    let (computed, _, records) = after(at, &study("cost", "repeats = 2", &[FORCE]));
    assert_eq!((computed, with_inputs(&records)), (2, 0));
    let (computed, states, _) = after(at, &study("cost", "repeats = 1", &[FORCE]));
    assert_eq!((computed, states), (0, kept.clone()));
    // Another kind asks for derivatives by the constants with intervals
    let (computed, states, records) = after(at, &study("convergence", "", &[FORCE]));
    assert_eq!((computed, states, with_inputs(&records)), (2, partial.clone(), 2));
    let (computed, states, records) = after(at, &study("convergence", "error_estimates = true", &[FORCE]));
    assert_eq!((computed, states, estimated(&records)), (2, partial.clone(), 2));
    let lateral = FORCE.replace("_z_N", "_x_N").replace("\"force\"", "\"lateral force\"");
    let (computed, states, records) = after(at, &study("convergence", "error_estimates = true", &[FORCE, &lateral]));
    assert_eq!((computed, states), (2, partial.clone()));
    assert!(records.iter().all(|r| r.provenance.asked.as_ref().is_some_and(|asked| asked.estimates.len() == 2)));
    // More than is asked for is kept, and no report takes it
    let (computed, states, records) = after(at, &study("convergence", "", &[FORCE]));
    assert_eq!((computed, states, with_inputs(&records)), (0, kept.clone(), 2));
    assert_eq!(estimated(&records), 0);
    let (computed, _, records) = after(at, &study("cost", "repeats = 1", &[FORCE]));
    assert_eq!((computed, with_inputs(&records)), (0, 0));
    assert_eq!(after(at, &study("cost", "repeats = 3", &[FORCE])).0, 2);
}
