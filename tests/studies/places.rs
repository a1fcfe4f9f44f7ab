//! Cases that belong to several families, variants or members of a study, and cases whose records have the names of another study.

use crate::common::synthetic;
use durometer::study::analysis::Analysis;
use durometer::study::kinds::convergence;
use durometer::study::kinds::convergence::findings::ConvergenceFindings;
use durometer::study::store::record::{FamilyRecord, Role, StoredCase, StudyRecord, VariantMember};
use durometer::study::store::results;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// The study with the members of its families, as the program of today writes it.
fn study() -> (StudyRecord, Vec<StoredCase>) {
    let (mut study, cases) = synthetic::study();
    for family in &mut study.families {
        let own = cases.iter().map(|c| &c.record).filter(|r| r.family == family.name);
        family.members = own.map(|r| VariantMember { variant: r.variant.clone(), member: r.member.clone() }).collect();
    }
    (study, cases)
}

/// The analysis of these results as they are read from their files.
fn read(of: &(StudyRecord, Vec<StoredCase>)) -> Analysis<ConvergenceFindings> {
    let folder = tempfile::tempdir().expect("a folder");
    synthetic::store(folder.path(), of);
    let store = results::read(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    convergence::analysis::analyse(&store.study, &store.cases)
}

/// `a-b` with member `c` and `a` with variant `b-c` have cases of one name: the record of the first has no say in the second.
#[test]
fn the_names_of_a_record_are_not_those_of_the_study() {
    let (study, mut cases) = study();
    let expected = read(&(study.clone(), cases.clone()));
    for r in cases.iter_mut().map(|c| &mut c.record) {
        (r.family, r.variant, r.member) = ("other".into(), "one".into(), "else".into());
    }
    assert_eq!(format!("{:?}", read(&(study, cases))), format!("{expected:?}"));
}

/// A study that an earlier version has written, without the members of its families, is the same study and says the same.
#[test]
fn a_study_of_an_earlier_version_is_the_same() {
    let (now, cases) = study();
    let (then, _) = synthetic::study();
    assert!(then.families[0].members.is_empty() && now == then);
    assert_eq!(format!("{:?}", read(&(then, cases.clone()))), format!("{:?}", read(&(now, cases))));
}

/// A mesh that is also one of the seeds is a setting, whichever family was listed first.
#[test]
fn the_order_of_families_decides_nothing() {
    let (mut study, cases) = study();
    let seeds = FamilyRecord {
        name: "seeds".into(),
        cases: cases.iter().filter(|c| c.record.mesh.cells == 9_300).map(|c| c.record.id.clone()).collect(),
        members: cases
            .iter()
            .filter(|c| c.record.mesh.cells == 9_300)
            .map(|c| VariantMember { variant: c.record.variant.clone(), member: c.record.id.clone() })
            .collect(),
        role: Role::Seeds,
        formulation: "tet4".into(),
    };
    study.families.retain(|f| f.role != Role::Seeds);
    let with = |at: usize| {
        let mut study = study.clone();
        study.families.insert(at, seeds.clone());
        study
    };
    let last = read(&(with(study.families.len()), cases.clone()));
    let first = read(&(with(0), cases));
    assert_eq!((&first.verdict, &first.found.settings), (&last.verdict, &last.found.settings));
    assert!(first.found.settings.iter().any(|s| s.cells == 9_300 && s.bars.len() == 3), "{:?}", first.found.settings);
}

/// Two variants of one scene that judge different quantities are one run with both.
#[test]
fn a_variant_of_the_same_scene_has_its_cases() {
    let (mut study, cases) = study();
    let expected = read(&(study.clone(), cases.clone()));
    // The variant `length` by its angle and by its tension
    study.variants.push("again".into());
    let own = study.quantities["length"].clone();
    study.quantities.insert("length".into(), own[..1].to_vec());
    study.quantities.insert("again".into(), own[1..].to_vec());
    for family in &mut study.families {
        let of_length: Vec<_> = family.cases.iter().cloned().zip(family.members.clone()).collect();
        for (id, member) in of_length.into_iter().filter(|(_, m)| m.variant == "length") {
            family.cases.push(id);
            family.members.push(VariantMember { variant: "again".into(), ..member });
        }
    }
    let a = read(&(study, cases));
    let by = |a: &Analysis<ConvergenceFindings>, variant: &str| {
        let q = a.found.find(variant, "cable_tension_N").expect("it is judged");
        (q.errors.clone(), q.reference.clone(), q.step.clone())
    };
    assert_eq!(by(&a, "again"), by(&expected, "length"));
    let recommended =
        |a: &Analysis<ConvergenceFindings>| a.found.recommended.as_ref().map(|r| (r.label.clone(), r.error_bar));
    assert_eq!(recommended(&a), recommended(&expected));
}

const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [2, 1, 2] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "zmin"
[[constraint]]
kind = "fixed"
region = "zmax"
components = "xy"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = { kind = "points", unit = "mm", of = [[0, 0], [0.5, -1], [1, -0.5]] }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "reaction"
region = "zmax"
[[probe]]
kind = "position"
region = "xmax"
"#;

/// Summary of a run of a small study.
fn run(folder: &Path, study: &str) -> Value {
    run_with(folder, study, &[])
}

/// The same with further options.
fn run_with(folder: &Path, study: &str, options: &[&str]) -> Value {
    std::fs::write(folder.join("scene.toml"), SCENE).expect("writable");
    let head = "question = \"?\"\nexpectation = \"!\"\nscene = \"scene.toml\"\ntolerance = \"2 %\"\n";
    std::fs::write(folder.join("study.toml"), format!("{head}{study}")).expect("writable");
    let output = Command::new(env!("CARGO_BIN_EXE_durometer"))
        .args(["run", "--json", "--out"])
        .args([folder.join("out"), folder.join("study.toml")])
        .args(options)
        .output()
        .expect("the program starts");
    assert!(!output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

const FORCE: &str = "{ name = \"zmax_reaction_z_N\", label = \"force\", symbol = \"F\", unit = \"N\" }";
const SIDE: &str = "{ name = \"xmax_x_m\", label = \"side\", symbol = \"x\", unit = \"m\" }";

/// A member with the scene of another one is compared, and a member whose curve is not whole is not; a coarse curve is compared on the samples of both.
#[test]
fn every_member_of_a_comparison_is_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    let study = format!(
        "kind = \"comparison\"\nreference = \"whole\"\n[[variant]]\nname = \"press\"\nquantity = [{FORCE}]\n\
         [[variant]]\nname = \"hard\"\nset = {{ \"constraint.2.displacement.of\" = [[0, 0], [0.5, -2], [1, -1]] }}\nquantity = [{FORCE}]\n\
         [[family]]\nname = \"members\"\nrole = \"members\"\n[family.members]\nwhole = {{}}\nother_name = {{ \"laws.rubber.E\" = \"100 kPa\" }}\n\
         short = {{ \"stage.0.duration\" = \"0.5 s\" }}\ncoarse = {{ \"stage.0.dt\" = \"1 s\" }}\n\
         broken = {{ \"numerics.max_iterations\" = 1, \"numerics.cuts\" = 0 }}\nsoft = {{ \"laws.rubber.E\" = \"50 kPa\" }}\n"
    );
    let summary = run(folder.path(), &study);
    let verdict = summary["verdict"].as_str().expect("a verdict");
    for words in [
        "other name (0 %) can replace whole",
        "short (force, press: its curve is from 0 s to 0.5 s",
        "coarse by",
        "soft by 50",
    ] {
        assert!(verdict.contains(words), "{words}: {verdict}");
    }
    assert!(!verdict.contains("broken can replace") && !verdict.contains("broken ("), "{verdict}");
    let missing = summary["analysis"]["incomparable"].as_array().expect("a list");
    let of = |member: &str| missing.iter().filter(|i| i["member"] == member).count();
    assert_eq!(["short", "broken", "coarse", "other_name"].map(of), [2, 2, 0, 0], "{missing:?}");
    let decisions = serde_json::json!({
        "other_name can replace whole": "yes",
        "short can replace whole": "not comparable",
        "coarse can replace whole": "no",
        "soft can replace whole": "no",
    });
    assert_eq!(summary["decisions"], decisions);
}

/// A sweep of two variants that differ in their quantities only has the points of both.
#[test]
fn a_sweep_of_one_scene_has_all_its_variants() {
    let folder = tempfile::tempdir().expect("a folder");
    let axis = "[[axis]]\nname = \"E\"\nkeys = [\"laws.rubber.E\"]\nlabel = \"stiffness\"\nsymbol = \"E\"\nunit = \"kPa\"\nvalues = [\"100 kPa\", \"200 kPa\"]\n";
    let study = format!(
        "kind = \"sweep\"\n[[variant]]\nname = \"press\"\nquantity = [{FORCE}]\n[[variant]]\nname = \"b\"\nquantity = [{SIDE}]\n{axis}"
    );
    let summary = run(folder.path(), &study);
    for (quantity, variant) in [("zmax_reaction_z_N", "press"), ("xmax_x_m", "b")] {
        let points = summary["analysis"][quantity][variant]["points"].as_array().expect("points");
        assert_eq!(points.len(), 2, "{quantity}");
    }
    assert_eq!(summary["cases"].as_array().map(Vec::len), Some(2), "one scene is run once");
}

/// The reference of a map is that of its first variant, also where another one is run first; an answer without one is not judged.
#[test]
fn a_map_has_one_reference_whichever_variant_is_run() {
    let axis = |name: &str, key: &str, values: &str| {
        format!(
            "[[map.axis]]\nname = \"{name}\"\nkeys = [\"{key}\"]\nlabel = \"l\"\nsymbol = \"s\"\nvalues = {values}\n"
        )
    };
    let study = format!(
        "kind = \"robustness\"\n[[variant]]\nname = \"own\"\n[[variant]]\nname = \"soft\"\nset = {{ \"laws.rubber.E\" = \"10 kPa\" }}\n\
         [[map]]\nname = \"it\"\nsetup = \"Iterations against contraction.\"\nvariants = [\"own\", \"soft\"]\nquantity = {FORCE}\n{}{}",
        axis("n", "numerics.max_iterations", "[20, 30]"),
        axis("nu", "laws.rubber.nu", "[0.2, 0.3]")
    );
    let folder = tempfile::tempdir().expect("a folder");
    let alone = run_with(folder.path(), &study, &["--only", "soft"]);
    let said = |summary: &Value| summary["verdict"].as_str().expect("a verdict").to_string();
    assert!(said(&alone).contains("soft has no judged point"), "{}", said(&alone));
    let whole = run(folder.path(), &study);
    assert!(said(&whole).contains("own 100 %, soft 0 %"), "{}", said(&whole));
    let decided = |how: &str| whole["decisions"].as_object().expect("decisions").values().filter(|d| *d == how).count();
    // Two are the references, which nothing is compared with
    let outcomes = ["pass", "unchecked", "inaccurate", "fail"];
    assert_eq!(outcomes.map(decided), [2, 2, 4, 0], "{}", whole["decisions"]);
}
