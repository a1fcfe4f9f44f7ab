//! Inverse analysis: constants found again from simulated tests, in other units, from a bad start; what a curve does not say; the
//! synthetic dumbbell of `studies/dumbbell-synthetic`.

mod common;

use common::example_table;
use durometer::calibrate::Weighting;
use durometer::calibrate::inverse::{Calibration, Failure, Measured, MeasuredSpec, SceneModel, Settings, calibrate};
use durometer::material::{LAWS, registry};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Constant, Progress, Scene};
use durometer::solve::Status;
use durometer::study::expand::Study;
use durometer::study::report;
use durometer::study::run::runner::{self, Isolation, Options, Watch};
use durometer::study::store::record::CaseRecord;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use toml::{Table, Value};

/// A bar between bonded ends; `to` and `steps` of the pull.
fn bar(law: &Table, to: &str, steps: usize) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "xyz"
displacement = {{ kind = "ramp", from = "0 mm", to = "0 mm", end = "1 s" }}
[[constraint]]
kind = "prescribed"
region = "middle"
components = "x"
displacement = {{ kind = "ramp", from = "0 mm", to = "{to}", end = "1 s" }}
[mesh.regions.middle]
kind = "plane"
point = ["15 mm", "0 mm", "0 mm"]
normal = [1, 0, 0]
tolerance = "0.1 mm"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{} s"
[[probe]]
kind = "reaction"
region = "middle"
[numerics]
tolerance = 1e-11
[laws.rubber]
{law}"#,
        1.0 / steps as f64
    );
    common::scene(block(4, 1, 1, 0.03, 0.01, 0.01, Order::Linear), &text)
}

const X: &str = "middle_x_displacement_m";
const Y: &str = "middle_reaction_x_N";

fn model(scene: &Scene, keys: &[&str], x: &str, y: &str) -> SceneModel {
    let constants: Vec<Constant> = keys.iter().map(|k| format!("laws.rubber.{k}").parse().expect("a name")).collect();
    let unknown = SceneModel::unknowns(&scene.spec, &constants).unwrap_or_else(|e| panic!("{e}"));
    SceneModel {
        file: PathBuf::from("scene.toml"),
        spec: scene.spec.clone(),
        text: scene.text.clone(),
        body: scene.body.clone(),
        unknown,
        x: x.into(),
        y: y.into(),
    }
}

/// What the model says at its own constants, as if it were measured at these x.
fn made(model: &SceneModel, x: Vec<f64>) -> Measured {
    let empty = |n: usize| vec![0.0; n];
    let blank = Measured {
        file: "made".into(),
        sha256: String::new(),
        y: empty(x.len()),
        lines: (1..=x.len() as u64).collect(),
        x,
        notes: vec![],
    };
    let own: Vec<f64> = model.unknown.iter().map(|u| u.start).collect();
    let Ok(answer) = model.answer(&own, &blank, &mut |_| true) else { panic!("the truth can be solved") };
    Measured { y: answer.y, ..blank }
}

fn found(model: &SceneModel, measured: &Measured) -> Calibration {
    let settings = Settings { weighting: Weighting::Absolute, gauge: None, profile: false };
    match calibrate(model, measured, &settings, &mut |_| true) {
        Ok((calibration, _)) => calibration,
        Err(Failure::Input(e)) => panic!("{e}"),
        Err(Failure::Run(status)) => panic!("{status}"),
        Err(_) => panic!("no answer"),
    }
}

/// The table of a law with its stiffnesses moved by turns up and down.
fn moved(law: &Table, keys: &[&str], by: f64) -> Table {
    let mut law = law.clone();
    for (k, key) in keys.iter().enumerate() {
        let factor = if k % 2 == 0 { 1.0 + by } else { 1.0 - by };
        let value = match &law[*key] {
            Value::String(text) => {
                let (number, unit) = text.split_once(' ').expect("a number and its unit");
                format!("{:?} {unit}", number.parse::<f64>().expect("a number") * factor).into()
            }
            other => (other.as_float().expect("a number") * factor).into(),
        };
        law.insert((*key).into(), value);
    }
    law
}

/// The first two constants of every law from a force over a displacement, without noise. Forward solves end 1e-11 from equilibrium
/// and the search where f < 1e-16, a misfit of 1.4e-8: constants that are told apart a hundred times worse than a stiffness come
/// back to 1e-5.
#[test]
fn every_law_is_found_again() {
    for entry in LAWS {
        let law = example_table(entry.info.name);
        let keys: Vec<&str> = (entry.keys.iter().map(|p| p.name))
            .filter(|k| law.contains_key(*k) && !["nu", "kappa"].contains(k))
            .take(2)
            .collect();
        let truth = model(&bar(&law, "6 mm", 8), &keys, X, Y);
        let measured = made(&truth, (1..=30).map(|k| 6e-3 * f64::from(k) / 30.0).collect());
        let start = moved(&law, &keys, 0.2);
        let c = found(&model(&bar(&start, "6 mm", 8), &keys, X, Y), &measured);
        let off = |(f, u): (&durometer::calibrate::inverse::Found, &durometer::calibrate::inverse::Unknown)| {
            (f.value / u.start - 1.0).abs()
        };
        let worst = c.constants.iter().zip(&truth.unknown).map(off).fold(0.0, f64::max);
        println!("{} {keys:?}: {worst:.1e} in {} solves, misfit {:.1e}", entry.info.name, c.solves, c.rms_relative);
        assert!(c.settled && c.rms_relative < 1e-6, "{}: misfit {:e}", entry.info.name, c.rms_relative);
        assert!(worst < 1e-5, "{}: {worst:e}", entry.info.name);
    }
}

/// The same table in other units gives the same constants, to the rounding of the conversion.
#[test]
fn units_of_the_table_change_nothing() {
    let law = example_table("yeoh");
    let truth = model(&bar(&law, "6 mm", 6), &["C10", "C20"], X, Y);
    let measured = made(&truth, (1..=20).map(|k| 3e-4 * f64::from(k)).collect());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let from = |unit_x: &str, per_m: f64, unit_y: &str, per_n: f64| {
        let rows = measured.x.iter().zip(&measured.y).map(|(x, y)| format!("{:?};{:?}\n", x * per_m, y * per_n));
        let text = format!("header\nu;F\n{}", rows.collect::<String>());
        std::fs::write(folder.path().join("table.csv"), text).expect("writable");
        let spec = format!(
            "file = \"table.csv\"\nx = {{ column = \"u\", unit = \"{unit_x}\", is = \"{X}\" }}\ny = {{ column = \"F\", unit = \"{unit_y}\", is = \"{Y}\" }}"
        );
        let spec: MeasuredSpec = toml::from_str(&spec).expect("sound");
        let read = Measured::read(folder.path(), &spec).unwrap_or_else(|e| panic!("{e}"));
        let start = moved(&law, &["C10", "C20"], 0.3);
        found(&model(&bar(&start, "6 mm", 6), &["C10", "C20"], X, Y), &read)
    };
    let (si, other) = (from("m", 1.0, "N", 1.0), from("mm", 1e3, "mN", 1e3));
    for (a, b) in si.constants.iter().zip(&other.constants) {
        assert!((a.value / b.value - 1.0).abs() < 1e-9, "{}: {} {}", a.key, a.value, b.value);
    }
}

/// Gent's law ends where its chains are stretched out: trial constants beyond are walls, not the end of the search.
#[test]
fn a_forward_solve_that_fails_is_stepped_back_from() {
    let mut law = example_table("gent");
    law.insert("J_m".into(), 0.6.into());
    let truth = model(&bar(&law, "7 mm", 10), &["mu", "J_m"], X, Y);
    let measured = made(&truth, (1..=30).map(|k| 7e-3 * f64::from(k) / 30.0).collect());
    let mut start = law.clone();
    start.insert("J_m".into(), 30.0.into());
    let c = found(&model(&bar(&start, "7 mm", 10), &["mu", "J_m"], X, Y), &measured);
    println!("{} solves, {} failed: {:?}", c.solves, c.failed, c.constants);
    assert!(c.failed > 0, "the case must make forward solves fail");
    assert!((c.constants[1].value / 0.6 - 1.0).abs() < 1e-4, "{:?}", c.constants);
}

/// The protocol goes on where the law has no answer any more; the data end before, and nothing beyond them is solved.
#[test]
fn the_protocol_after_the_data_is_not_solved() {
    let mut law = example_table("gent");
    law.insert("J_m".into(), 0.6.into());
    let truth = model(&bar(&law, "7 mm", 10), &["mu", "J_m"], X, Y);
    let measured = made(&truth, (1..=30).map(|k| 7e-3 * f64::from(k) / 30.0).collect());
    let whole = bar(&law, "14 mm", 20);
    assert_ne!(whole.run().status, Status::Converged, "the law ends before the protocol");
    let mut start = law.clone();
    start.insert("J_m".into(), 1.0.into());
    let c = found(&model(&bar(&start, "14 mm", 20), &["mu", "J_m"], X, Y), &measured);
    assert!(c.settled && (c.constants[1].value / 0.6 - 1.0).abs() < 1e-4, "{:?}", c.constants);
    assert_eq!(c.curve.len(), 11, "the start, and ten steps to the last data point");
}

/// An end by profile likelihood that is not found is not replaced by that of another interval.
#[test]
fn an_open_end_of_a_profile_is_open() {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "3 mm", 4), &["E"], X, Y);
    let measured = made(&truth, (1..=10).map(|k| 3e-4 * f64::from(k)).collect());
    let mut constant = found(&truth, &measured).constants.remove(0);
    let closed = constant.widest().expect("it is determined");
    constant.profile = Some([Some(constant.value), None]);
    assert_eq!(constant.widest(), None);
    assert!(constant.open_end().is_some_and(|words| words.starts_with("laws.rubber.E: the upper end")));
    constant.profile = Some([Some(closed[0]), Some(2.0 * closed[1])]);
    assert_eq!((constant.widest(), constant.open_end()), (Some([closed[0], 2.0 * closed[1]]), None));
}

/// Reference 21h: without gravity the angle of a body under cable-length control does not depend on its stiffness.
#[test]
fn length_control_says_nothing_on_the_stiffness() {
    let text = |y: &str| {
        let scene = common::scene(
            block(6, 1, 1, 0.06, 0.01, 0.01, Order::Linear),
            r#"
[mesh]
body = "block"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["20 mm", "5 mm", "2 mm"], ["50 mm", "5 mm", "2 mm"]]
pull_point = ["-6 mm", "5 mm", "2 mm"]
guide_radius = "point"
drive = { kind = "length", signal = { kind = "ramp", from = "0 mm", to = "4 mm", end = "1 s" } }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.125 s"
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
[laws.rubber]
law = "neo_hookean"
mu = "100 kPa"
nu = 0.45
"#,
        );
        model(&scene, &["mu"], "cable_shortening_m", y)
    };
    let x: Vec<f64> = (1..=20).map(|k| 2e-4 * f64::from(k)).collect();
    let angle = text("bending_angle_deg");
    let blind = found(&angle, &made(&angle, x.clone()));
    assert_eq!((blind.constants[0].interval, blind.constants[0].std_error), (None, None));
    assert!(blind.unidentified[0].contains("insensitive to μ"), "{:?}", blind.unidentified);
    let mut tension = text("cable_tension_N");
    let measured = made(&tension, x);
    tension.unknown[0].start = 40e3;
    let seen = found(&tension, &measured);
    assert!(seen.unidentified.is_empty(), "{:?}", seen.unidentified);
    assert!((seen.constants[0].value / 100e3 - 1.0).abs() < 1e-6, "{:?}", seen.constants);
}

/// Errors of 1 % on a curve that is linear in its constants: the profile is the interval of the covariance, to the 2 % at which its
/// ends are found, and both hold the truth.
#[test]
fn profiles_of_a_linear_law_are_its_covariance() {
    let law = example_table("mooney_rivlin");
    let keys = ["C10", "C20"];
    let truth = model(&bar(&law, "6 mm", 6), &keys, X, Y);
    let mut measured = made(&truth, (1..=60).map(|k| 1e-4 * f64::from(k)).collect());
    let largest = measured.y.iter().fold(0.0f64, |m, y| m.max(y.abs()));
    let mut random = common::Random(11);
    measured.y.iter_mut().for_each(|y| *y += 0.01 * largest * random.normal());
    let settings = Settings { weighting: Weighting::Absolute, gauge: None, profile: true };
    let Ok((c, _)) = calibrate(&truth, &measured, &settings, &mut |_| true) else { panic!("it can be solved") };
    for (f, u) in c.constants.iter().zip(&truth.unknown) {
        let (wald, profile) = (f.interval.expect("determined"), f.profile.expect("asked for"));
        println!("{}: {wald:?} {profile:?} in {} solves", f.key, c.profile_solves);
        for (w, p) in wald.iter().zip(profile) {
            let p = p.expect("an end");
            assert!((p - w).abs() < 0.025 * (wald[1] - wald[0]), "{}: {w} {p}", f.key);
        }
        assert!(wald[0] < u.start && u.start < wald[1], "{}: {wald:?} {}", f.key, u.start);
    }
}

struct Quiet;

impl Watch for Quiet {
    fn meshing(&self, _: &str, _: &str) {}
    fn started(&self, _: &str) {}
    fn progress(&self, _: &str, _: Progress) {}
    fn finished(&self, _: &CaseRecord, _: bool) {}
}

/// The committed study on its coarse meshes: mu = 100 kPa was pulled with 75 mm between the grips. The rows leave ±0.12 %, and half as
/// many steps change the interpolation by less: within 0.5 % where the distance is known, in the interval where it is not, and the
/// gauge length tens of percent off. The law file is a law.
#[test]
fn a_dumbbell_gives_its_stiffness_and_the_gauge_length_does_not() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/dumbbell-synthetic/study.toml");
    let changes = [("stage.0.dt".to_string(), Value::from("0.1 s"))];
    let study = Study::read(&file, &changes).unwrap_or_else(|e| panic!("{e}"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let stop = AtomicBool::new(false);
    for only in ["mesh-pull-coarse", "grips"] {
        let options = Options {
            jobs: 2,
            redo: false,
            accept_build: false,
            only: Some(only.into()),
            vtu: false,
            isolation: Isolation::Threads,
            memory: None,
            stop: &stop,
        };
        let records = runner::run(&study, folder.path(), &options, &Quiet).unwrap_or_else(|e| panic!("{e}"));
        assert!(records.iter().all(CaseRecord::converged), "{only}");
    }
    let summary = report::write(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    let mu = &summary.analysis["pull"]["constants"][0];
    let number = |key: &str| mu[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    assert!((number("value") / 100e3 - 1.0).abs() < 5e-3, "{mu}");
    assert!(number("bias") < -0.25, "{mu}");
    let (low, high) = (mu["interval"][0].as_f64().expect("a number"), mu["interval"][1].as_f64().expect("a number"));
    assert!(low < 100e3 && 100e3 < high && high - low > 5e3, "{mu}");
    let law: Table = std::fs::read_to_string(folder.path().join("law.toml")).expect("written").parse().expect("TOML");
    let of_law = registry::law_from_table(&law).unwrap_or_else(|e| panic!("{e}"));
    assert!((of_law.small_strain().mu / number("value") - 1.0).abs() < 1e-12);
    assert!(summary.warnings.iter().any(|w| w.contains("one mesh only")), "{:?}", summary.warnings);
    band(&study, folder.path(), &summary);
}

/// The ends of the band where the law is used, against runs of that scene at the constants of the nuisance cases: δ of 3.5 % in μ moves
/// the angle by about that much, so what is not linear is of the order of its square, 0.1 % of the angle; the rows add 0.12 % in μ.
fn band(study: &Study, folder: &Path, summary: &report::Summary) {
    let stop = AtomicBool::new(false);
    let options = Options {
        jobs: 2,
        redo: false,
        accept_build: false,
        only: Some("coarse".into()),
        vtu: false,
        isolation: Isolation::Threads,
        memory: None,
        stop: &stop,
    };
    runner::run(study, folder, &options, &Quiet).unwrap_or_else(|e| panic!("{e}"));
    let summary_of_use = report::write(folder).unwrap_or_else(|e| panic!("{e}"));
    let band = &summary_of_use.analysis["use"][0];
    let last = |v: &serde_json::Value| v.as_array().and_then(|a| a.last()?.as_f64()).expect("numbers");
    let peak = last(&band["y"]);
    let case = study.cases.iter().find(|c| c.id == "use-pull-coarse").expect("a case of [use]");
    let cases = summary.analysis["pull"]["constants"][0]["cases"].as_array().expect("a list");
    let found =
        |member: &str| cases.iter().find(|c| c["member"] == member).and_then(|c| c["value"].as_f64()).expect("found");
    // Softer bends more: the upper end belongs to the smaller μ
    for (member, end) in [("65mm", 1), ("85mm", 0)] {
        let law = format!("{{ law = \"neo_hookean\", mu = \"{} Pa\", nu = 0.49 }}", found(member));
        let mut scene: Table = case.text.parse().expect("TOML");
        scene["laws"]["rubber"] = law.parse().expect("a table");
        let spec =
            durometer::scene::from_text(&case.scene_file, &scene.to_string(), "").unwrap_or_else(|e| panic!("{e}"));
        let body = durometer::scene::Body::load(&case.scene_file, &case.spec.mesh, &mut |_| {})
            .unwrap_or_else(|e| panic!("{e}"));
        let built =
            Scene::build(&case.scene_file, spec, scene.to_string(), body.into()).unwrap_or_else(|e| panic!("{e}"));
        let angle = *common::column(&common::run(&built), "bending_angle_deg").last().expect("a row");
        let band_end = last(&band["constants"][end]);
        println!("{member}: {angle}, end of the band {band_end}, peak {peak}");
        assert!((band_end - angle).abs() < 4e-3 * peak && (band_end - peak).abs() > 2e-2 * peak, "{member}");
    }
}
