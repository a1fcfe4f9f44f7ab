//! A beam whose runs a formula replaces, and programs around it.

use durometer::study::kind::StudyScope;
use durometer::study::kinds::validation::analysis::analyse;
use durometer::study::kinds::validation::findings::ValidationFindings;
use durometer::study::kinds::validation::plan::ValidationPlan;
use durometer::study::store::record::{CaseRecord, FamilyRecord, Role, Series, StoredCase, StudyRecord};
use durometer::study::store::results::Results;
use std::collections::BTreeMap;
use std::path::Path;

/// A slender beam of 8 x 2 x 2 boxes under its own weight and a tip load, small enough to be run in tens of milliseconds.
pub const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["100 mm", "20 mm", "20 mm"], divisions = [8, 2, 2] }

[laws.rubber]
law = "neo_hookean"
E = "300 kPa"
nu = 0.3

[[effect]]
kind = "elastic"
region = "body"
law = "rubber"

[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "1 s" }

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
dt = "0.25 s"

[[probe]]
kind = "position"
region = "xmax"
"#;

pub const STUDY: &str = r#"
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

[[input]]
name = "density"
keys = ["effect.gravity.density"]
deviation = "3 %"
source = "data sheet"
group = "load"

[[input]]
name = "load"
keys = ["effect.load.traction.to"]
deviation = "2 %"
source = "scale"

[[input]]
name = "batch"
keys = ["laws.rubber.E"]
deviation = "9 kPa"
source = "scatter of specimens"
records = ["heavy"]

[[record]]
name = "none"
purpose = "calibration"
set = { "effect.load.traction.to" = "1 Pa" }

[[record]]
name = "light"
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
measured = { none = [2.9, 3.1], light = 5.0 }
error = [
  { group = "reading", deviation = "0.2 mm", source = "scatter" },
  { group = "zero", deviation = "0.3 mm", source = "registration", shared = true },
]

[[family]]
name = "sizes"
role = "sizes"
[family.members]
coarse = { "mesh.grid.divisions" = [4, 1, 1] }
middle = { "mesh.grid.divisions" = [8, 2, 2] }
"#;

/// Elastic modulus \[kPa\], and density, load and batch in standard deviations, with the load of each record \[Pa\].
pub type Truth = (f64, [f64; 3]);

/// Drop of a beam that stiffens as it bends, w = a tanh(u/a), u in proportion to weight and load over stiffness \[mm\].
pub fn drop(load: f64, (e, [density, of_load, batch]): Truth, is_heavy: bool) -> f64 {
    let e = if is_heavy { e + 9.0 * batch } else { e };
    let u = 300.0 / e * (3.0 * (1.0 + 0.03 * density) + 0.02 * load * (1.0 + 0.02 * of_load));
    25.0 * (u / 25.0).tanh()
}

pub const LOADS: [(&str, f64); 3] = [("none", 1.0), ("light", 100.0), ("heavy", 300.0)];

/// Plan of a study text in a folder, to which the scene is written.
pub fn plan(folder: &Path, text: &str) -> Result<ValidationPlan, String> {
    std::fs::write(folder.join("scene.toml"), SCENE).expect("writable");
    let (_, expansion) = durometer::study::study_file::parse(&folder.join("study.toml"), text, StudyScope::Whole)
        .map_err(|e| e.to_string())?;
    Ok(serde_json::from_value(expansion.details).expect("a plan"))
}

/// Plan of the study, and results of its design, checks and meshes by the formula.
pub fn by_formula() -> (ValidationPlan, Results) {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = plan(folder.path(), STUDY).unwrap_or_else(|e| panic!("{e}"));
    let results = results(&plan);
    (plan, results)
}

/// Results of a plan by the formula.
pub fn results(plan: &ValidationPlan) -> Results {
    let mut cases = vec![];
    let mut sensitivities = BTreeMap::new();
    let mut case = |id: String, variant: &str, value: f64, h_m: f64| {
        let mut record =
            CaseRecord { id, variant: variant.into(), status: "Converged".into(), ..CaseRecord::default() };
        record.mesh.h_m = h_m;
        record.integrator = "static".into();
        let columns = [("xmax_z_m".to_string(), vec![0.01, 0.01 - 1e-3 * value])].into();
        cases.push(StoredCase::new(record, Series { t_s: vec![0.0, 1.0], columns }));
    };
    for (name, load) in LOADS {
        let heavy = name == "heavy";
        for (id, at) in plan.points.iter().filter(|(id, _)| id.starts_with(&format!("design-{name}-"))) {
            let e = 300.0 + 100.0 * at[0];
            case(id.clone(), name, drop(load, (e, [0.0; 3]), heavy), 0.01);
            let step = 1e-4;
            let by = |d: [f64; 4]| {
                let at = |sign: f64| drop(load, (e + sign * step * d[0], [1, 2, 3].map(|k| sign * step * d[k])), heavy);
                -1e-3 * (at(1.0) - at(-1.0)) / (2.0 * step)
            };
            // By Pa, kg/m³ and Pa
            let keys = [
                ("laws.rubber.E", by([1.0, 0.0, 0.0, 0.0]) / 1e3),
                ("effect.gravity.density", by([0.0, 1.0, 0.0, 0.0]) / 30.0),
                ("effect.load.traction.to", by([0.0, 0.0, 1.0, 0.0]) / (0.02 * load)),
            ];
            let columns = keys.map(|(key, d)| (format!("d xmax_z_m/d {key}"), vec![0.0, d])).into();
            sensitivities.insert(id.clone(), Series { t_s: vec![0.0, 1.0], columns });
        }
        for (id, (at, s)) in plan.checks.iter().filter(|(id, _)| id.starts_with(&format!("check-{name}-"))) {
            let s = [s[0], s[1], if heavy { s[2] } else { 0.0 }];
            case(id.clone(), name, drop(load, (300.0 + 100.0 * at[0], s), heavy), 0.01);
        }
        for (k, label) in ["coarse", "middle"].into_iter().enumerate() {
            let value = drop(load, (300.0, [0.0; 3]), heavy);
            case(format!("sizes-{name}-{label}"), name, value, [0.02, 0.01][k]);
        }
    }
    let cases_of = |role: &str| cases.iter().map(|c| c.record.id.clone()).filter(|id| id.starts_with(role)).collect();
    let family = |name: &str, role, cases| FamilyRecord {
        name: name.into(),
        role,
        formulation: "tet4".into(),
        cases,
        members: vec![],
    };
    let families =
        vec![family("design", Role::Design, cases_of("design")), family("sizes", Role::Sizes, cases_of("sizes"))];
    let study = StudyRecord {
        schema: 1,
        study: "beam".into(),
        kind: "validation".into(),
        question: String::new(),
        expectation: String::new(),
        tolerance: 0.05,
        quantities: BTreeMap::new(),
        groups: BTreeMap::new(),
        members: BTreeMap::new(),
        variants: vec![],
        labels: BTreeMap::new(),
        families,
        details: serde_json::Value::Null,
        version: String::new(),
        asks: None,
        inputs_sha256: BTreeMap::new(),
        overridden: vec![],
    };
    let (skins, motions, found) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    Results { study, cases, skins, motions, found, sensitivities, derived: None, damaged: vec![], outdated: vec![] }
}

pub fn found(results: &Results, plan: &ValidationPlan) -> ValidationFindings {
    analyse(results, plan).found
}
