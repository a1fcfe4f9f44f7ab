//! Evidence in addition to the families of meshes: estimates from single runs, and constants that are known within intervals, from a study that is run.

use crate::common::studies::run_folder;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::store::record::{CaseRecord, StoredCase};
use durometer::study::store::results::{Results, read};
use std::sync::OnceLock;

/// A block that is pulled, with a law whose file knows μ within 10 %.
const SCENE: &str = r#"
title = "A block that is pulled"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [2, 1, 1] }
element = "tet10"
[laws.rubber]
include = "law.toml"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "traction"
region = "xmax"
direction = [1, 0, 0]
traction = { kind = "ramp", from = "0 Pa", to = "10 kPa", end = "1 s" }
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
[[probe]]
kind = "energy"
"#;
const LAW: &str = "law = \"neo_hookean\"\nmu = \"100 kPa\"\n[provenance]\nmu_interval = [\"90 kPa\", \"110 kPa\"]\n";
const STUDY: &str = r#"
kind = "convergence"
question = "How far does the end move?"
expectation = "As far as its modulus says."
scene = "scene.toml"
tolerance = "5 %"
error_estimates = true
[[variant]]
name = "pull"
quantity = [
  { name = "xmax_x_m", label = "way of the end", symbol = "u", unit = "m" },
  { name = "work_J", label = "work", symbol = "W", unit = "J" },
  { name = "elastic_J", label = "elastic energy", symbol = "W", unit = "J" },
]
[[family]]
name = "sizes"
role = "sizes"
[family.members]
a = { "mesh.grid.divisions" = [2, 1, 1] }
b = { "mesh.grid.divisions" = [4, 2, 2] }
c = { "mesh.grid.divisions" = [6, 3, 3] }
[[family]]
name = "dt"
role = "time_step"
[family.members]
nominal = { "mesh.grid.divisions" = [4, 2, 2] }
fine = { "mesh.grid.divisions" = [4, 2, 2], "stage.0.dt" = "0.25 s" }
"#;

fn results(study: &str) -> Results {
    with_law(study, LAW)
}

fn with_law(study: &str, law: &str) -> Results {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in [("scene.toml", SCENE), ("law.toml", law), ("study.toml", study)] {
        std::fs::write(folder.path().join(name), text).expect("writable");
    }
    run_folder(folder.path());
    read(&folder.path().join("results")).unwrap_or_else(|e| panic!("{e}"))
}

/// Those of the study as it is, which is run once.
fn of_study() -> &'static Results {
    static RESULTS: OnceLock<Results> = OnceLock::new();
    RESULTS.get_or_init(|| results(STUDY))
}

fn record<'a>(cases: &'a [StoredCase], id: &str) -> &'a CaseRecord {
    &cases.iter().find(|c| c.record.id == id).unwrap_or_else(|| panic!("{id} has no result")).record
}

#[test]
fn one_run_and_the_constants_are_evidence_of_their_own() {
    let results = of_study();
    let finest = record(&results.cases, "sizes-pull-c");
    let own = finest.one_run.as_ref().expect("the study asks for it");
    assert!(own.refused.is_none() && own.quantities.contains_key("xmax_x_m"), "{own:?}");

    let a = analyse(&results.study, &results.cases);
    let q = a.find("pull", "xmax_x_m").expect("listed");
    let reference = q.reference.as_ref().expect("a family");
    let check = reference.independent.as_ref().expect("an estimate from one run");
    assert_eq!(check.of, "sizes-pull-c");
    assert_eq!(q.one_run.len(), 4, "every case of the variant has one: {:?}", q.one_run);

    // u is proportional to 1/μ at small strain; at a stretch of 1.04 within the strain
    let inputs = q.inputs.as_ref().expect("the file gives an interval");
    println!("{inputs:?}\n{check:?}\n{}", a.verdict);
    assert_eq!(inputs.constants, ["laws.rubber.mu"]);
    assert!((inputs.share - 0.10).abs() < 0.01, "{inputs:?}");
    let input = &finest.inputs[0];
    assert!((input.half_width - 1e4).abs() < 1e-6, "{input:?}");
    let r = a.recommended.as_ref().unwrap_or_else(|| panic!("{}", a.verdict));
    let together = r.error_bar.hypot(inputs.share);
    let words = format!("{:.0} %", 100.0 * together);
    assert!(a.verdict.contains("Constants (laws.rubber.mu)") && a.verdict.contains(&words), "{words}: {}", a.verdict);

    // Static, without history: the steps measure the solver
    assert_eq!(finest.steps_matter, Some(false));
    assert!(
        a.warnings.iter().any(|w| w.contains("values at one time do not depend on the time steps")),
        "{:?}",
        a.warnings
    );
}

/// The top of a sine lies between two steps of 0.2 s, and between two of 0.1 s at the same values: the family of time steps sees no difference, and the peak is 5 % off. Steps of 0.05 s
/// meet it.
#[test]
fn a_peak_between_two_static_steps_is_not_trusted() {
    let ramp = "{ kind = \"ramp\", from = \"0 Pa\", to = \"10 kPa\", end = \"1 s\" }";
    let end = "duration = \"1 s\"\ndt = \"0.5 s\"";
    assert!(SCENE.contains(ramp) && SCENE.contains(end) && STUDY.contains("5 %"));
    let analysed = |dt: f64| {
        let scene = SCENE
            .replace("include = \"law.toml\"", "law = \"neo_hookean\"\nE = \"260 kPa\"")
            .replace(ramp, "{ kind = \"sine\", amplitude = \"10 kPa\", frequency = \"1 Hz\" }")
            .replace(end, &format!("duration = \"0.4 s\"\ndt = \"{dt} s\""));
        let study = STUDY
            .replace("error_estimates = true\n", "")
            .replace("\"stage.0.dt\" = \"0.25 s\"", &format!("\"stage.0.dt\" = \"{} s\"", 0.5 * dt));
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in [("scene.toml", scene), ("study.toml", study)] {
            std::fs::write(folder.path().join(name), text).expect("writable");
        }
        run_folder(folder.path());
        let results = read(&folder.path().join("results")).unwrap_or_else(|e| panic!("{e}"));
        analyse(&results.study, &results.cases)
    };
    let [coarse, fine] = [0.2, 0.05].map(analysed);
    println!("{}\n{}", coarse.verdict, fine.verdict);
    let step = coarse.find("pull", "xmax_x_m").and_then(|q| q.step.clone()).expect("a family of steps");
    assert!(step.error < 1e-4 * step.values[0].abs(), "both grids see the same values: {step:?}");
    assert!(coarse.recommended.is_none() && coarse.verdict.contains("of a peak"), "{}", coarse.verdict);
    assert!(coarse.warnings.iter().any(|w| w.contains("values at one time do not depend on the time steps")));
    assert!(fine.recommended.is_some(), "{}", fine.verdict);
}

/// A law file that leaves an end of an interval open bounds no share of the constants: the verdict is one on the mesh alone, and says so.
#[test]
fn constants_that_are_not_determined_have_no_share() {
    let study = STUDY.replace("error_estimates = true\n", "");
    let results = with_law(&study, &LAW.replace("110 kPa", "inf Pa"));
    let words = "Constants (laws.rubber.mu) have no closed interval in their law file";
    let a = analyse(&results.study, &results.cases);
    let q = a.find("pull", "xmax_x_m").expect("listed");
    assert!(q.inputs.is_none() && q.undetermined == ["laws.rubber.mu"], "{:?}", q.undetermined);
    let trusts = |verdict: &str| verdict.contains("can be trusted");
    assert!(a.recommended.is_some() && a.verdict.contains(words) && !trusts(&a.verdict), "{}", a.verdict);
    let summary = durometer::study::kinds::convergence::report::summary::headline(&a);
    assert_eq!(summary["xmax_x_m"]["pull"]["undetermined"][0], "laws.rubber.mu", "{summary:?}");
    // Without a recommendation, too
    let few: Vec<StoredCase> = results.cases.into_iter().filter(|c| c.record.id == "sizes-pull-a").collect();
    let refused = analyse(&results.study, &few);
    assert!(refused.recommended.is_none() && refused.verdict.contains(words), "{}", refused.verdict);
}

/// The energies of the study have no derivative by the constants: their bars lack the share of these, and no verdict on them claims to be whole.
#[test]
fn a_quantity_without_a_derivative_has_no_share() {
    let Results { study, cases, .. } = of_study();
    let a = analyse(study, cases);
    let of = |name: &str| a.find("pull", name).expect("listed");
    let energy = of("elastic_J");
    assert!(energy.inputs.is_none() && energy.without_share == ["laws.rubber.mu"], "{:?}", energy.without_share);
    assert!(of("xmax_x_m").without_share.is_empty());
    assert!(a.recommended.is_some() && !a.verdict.contains("can be trusted"), "{}", a.verdict);
    assert!(a.verdict.contains("no derivative of ") && a.verdict.contains(&energy.peak_title()), "{}", a.verdict);
    let told = |w: &&String| w.contains("elastic energy") && w.contains("is in no error bar");
    assert_eq!(a.warnings.iter().filter(told).count(), 1, "{:?}", a.warnings);
    let summary = durometer::study::kinds::convergence::report::summary::headline(&a);
    assert_eq!(summary["elastic_J"]["pull"]["without_share"][0], "laws.rubber.mu", "{summary:?}");
    // Where it decides nothing, the bars that decide are whole
    let mut study = study.clone();
    let listed = study.quantities.get_mut("pull").expect("a variant");
    listed.iter_mut().filter(|q| q.name == "xmax_x_m").for_each(|q| q.deciding = true);
    let a = analyse(&study, cases);
    assert!(a.verdict.contains("can be trusted") && !a.verdict.contains("no derivative of "), "{}", a.verdict);
}

/// A constant that a calibration holds at a bound has no interval, whatever the data say of it.
#[test]
fn constants_at_a_bound_have_no_share() {
    let (known, _) = LAW.split_once("mu_interval").expect("an interval");
    let results = of_study();
    let (study, mut cases) = (&results.study, results.cases.clone());
    for c in &mut cases {
        let scene = &mut c.record.provenance.scene;
        let mut table: toml::Table = scene.parse().expect("TOML");
        let law = table["laws"]["rubber"].as_table_mut().expect("a law");
        let held: toml::Table =
            format!("{known}mu_without_interval = \"it is held at a bound\"\n").parse().expect("TOML");
        law.insert("provenance".into(), held["provenance"].clone());
        *scene = toml::to_string(&table).expect("TOML");
    }
    let a = analyse(study, &cases);
    let q = a.find("pull", "xmax_x_m").expect("listed");
    assert!(q.inputs.is_none() && q.undetermined == ["laws.rubber.mu"], "{:?}", q.undetermined);
    assert!(a.verdict.contains("have no closed interval") && !a.verdict.contains("by the data"), "{}", a.verdict);
    assert!(!a.verdict.contains("can be trusted"), "{}", a.verdict);
}

/// An estimate that contradicts the families widens the reference, and is said.
#[test]
fn a_disagreement_with_one_run_widens_the_reference() {
    let Results { study, cases, .. } = of_study();
    let (before, mut cases) = (analyse(study, cases), cases.clone());
    let of = |a: &durometer::study::analysis::Analysis<_>| -> durometer::study::estimate::reference::Reference {
        let found: &durometer::study::kinds::convergence::findings::ConvergenceFindings = &a.found;
        found.find("pull", "xmax_x_m").and_then(|q| q.reference.clone()).expect("a reference")
    };
    let finest = cases.iter_mut().find(|c| c.record.id == "sizes-pull-c").expect("a result");
    let error = finest.record.one_run.as_mut().and_then(|o| o.quantities.get_mut("xmax_x_m")).expect("an estimate");
    let size = of(&before).value.abs();
    error.correction += 0.03 * size;
    let after = analyse(study, &cases);
    assert!(of(&after).uncertainty > 0.025 * size, "{:?}", of(&after));
    assert!(after.warnings.iter().any(|w| w.contains("has grown to reach it")), "{:?}", after.warnings);
}

/// Energies have no estimate, and take nothing from the quantities that have one.
#[test]
fn a_column_without_an_estimate_leaves_those_of_the_others() {
    let results = of_study();
    for c in &results.cases {
        let own = c.record.one_run.as_ref().expect("the study asks for it");
        assert!(own.refused.is_none() && own.quantities.keys().eq(["xmax_x_m"]), "{own:?}");
        assert_eq!(own.unestimated, ["work_J", "elastic_J"]);
    }
    let a = analyse(&results.study, &results.cases);
    let wanted =
        "No error estimate from one run of elastic_J and work_J: only quantities with a derivative by the state";
    let found = a.warnings.iter().filter(|w| w.starts_with("No error estimate"));
    assert!(found.clone().all(|w| w.starts_with(wanted)) && found.count() == 1, "{:?}", a.warnings);
    assert_eq!(a.find("pull", "xmax_x_m").expect("listed").one_run.len(), 4);
}

/// Without the key no case has an estimate of its own.
#[test]
fn estimates_from_one_run_are_made_on_request() {
    let plain = STUDY.replace("error_estimates = true\n", "").replace("c = {", "# c = {");
    let results = results(&plain);
    assert!(results.cases.iter().all(|c| c.record.one_run.is_none()));
}
