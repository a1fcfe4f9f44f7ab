//! Derivatives of what a scene records by the constants of its laws: closed forms, and differences of whole runs.
//!
//! Differences: central over θ(1 ± h), h = 4e-3 and half of it, Richardson's (4D(h/2) − D(h))/3. With poles 0.3 θ away the
//! truncation is (4e-3/0.3)⁴/4 ≈ 8e-9 of the value; runs that end 1e-11 from equilibrium add 3·1e-11/4e-3 ≈ 8e-9. Accepted is
//! 1e-6 of the largest value of the same unit.

mod common;

use common::{column, example_table, run};
use durometer::material::LAWS;
use durometer::scene::{Body, Constant, Scene, from_text};
use durometer::solve::Status;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use toml::{Table, Value};

const SCENE: &str = r#"
[mesh]
body = "finger"
cells = 700
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "FORMULATION"
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "1 s" }
[[constraint]]
kind = "fixed"
region = "root"
[[constraint]]
kind = "cable"
path = "cable"
guide_radius = "6 mm"
drive = DRIVE
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "bending_angle"
root = "root"
tip = "tip"
[[probe]]
kind = "position"
region = "tip"
[[probe]]
kind = "reaction"
region = "root"
[[probe]]
kind = "energy"
[numerics]
tolerance = 1e-11
[laws.rubber]
"#;
const LENGTH: &str = r#"{ length = { kind = "ramp", from = "0 mm", to = "5 mm", end = "1 s" } }"#;
const TENSION: &str = r#"{ tension = { kind = "ramp", from = "0 N", to = "0.2 N", end = "1 s" } }"#;

fn text(formulation: &str, drive: &str, law: &Table) -> String {
    SCENE.replace("FORMULATION", formulation).replace("DRIVE", drive) + &toml::to_string(law).expect("a table")
}

fn build(text: &str, body: &Arc<Body>) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let spec = from_text(&file, text, "").unwrap_or_else(|e| panic!("{e}\n{text}"));
    Scene::build(&file, spec, text.into(), body.clone()).unwrap_or_else(|e| panic!("{e}"))
}

fn body() -> Arc<Body> {
    let text = text("displacement", LENGTH, &example_table("neo_hookean"));
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let spec: durometer::scene::SceneSpec = from_text(&file, &text, "").expect("the scene above");
    Body::load(&file, &spec.mesh, &mut |_| {}).expect("a committed mesh").into()
}

/// Values of `columns` at the end.
fn values(scene: &Scene, columns: &[String]) -> Vec<f64> {
    let run = run(scene);
    assert_eq!(run.status, Status::Converged);
    columns.iter().map(|name| *column(&run, name).last().expect("a row")).collect()
}

/// Columns and [columns × constants] at the end.
fn slopes(scene: &Scene, keys: &[String]) -> (Vec<String>, Vec<Vec<f64>>) {
    let constants: Vec<Constant> = keys.iter().map(|k| format!("laws.rubber.{k}").parse().expect("a name")).collect();
    let found = scene.run_with_slopes(&constants, &mut |_| true, &mut |_| {});
    let (run, mut slopes) = found.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((&run.status, &slopes.stopped, run.rows.len()), (&Status::Converged, &None, slopes.rows.len()));
    (slopes.columns, slopes.rows.pop().expect("a row"))
}

/// Every constant of the table against differences of runs; the largest error.
fn check(formulation: &str, drive: &str, table: &Table, body: &Arc<Body>) -> f64 {
    let known = durometer::material::registry::find(table["law"].as_str().expect("a name")).expect("registered").keys;
    let keys: Vec<String> = table.keys().filter(|k| known.iter().any(|p| p.name == *k)).cloned().collect();
    let (columns, exact) = slopes(&build(&text(formulation, drive, table), body), &keys);
    let here = values(&build(&text(formulation, drive, table), body), &columns);
    let mut worst = 0.0_f64;
    for (k, key) in keys.iter().enumerate() {
        let (theta, unit) = match &table[key] {
            Value::String(text) => {
                let (number, unit) = text.split_once(' ').expect("a number and its unit");
                (number.parse::<f64>().expect("a number"), Some(unit))
            }
            other => (other.as_float().expect("a number"), None),
        };
        let pascal = if unit == Some("kPa") { 1e3 } else { 1.0 };
        let at = |s: f64| {
            let mut table = table.clone();
            let value = theta * (1.0 + s);
            let quantity = unit.map(|unit| Value::from(format!("{value:?} {unit}")));
            table.insert(key.clone(), quantity.unwrap_or(Value::from(value)));
            values(&build(&text(formulation, drive, &table), body), &columns)
        };
        let difference = |h: f64| -> Vec<f64> {
            at(h).iter().zip(&at(-h)).map(|(a, b)| (a - b) / (2.0 * h * theta * pascal)).collect()
        };
        let (coarse, fine) = (difference(4e-3), difference(2e-3));
        let unit_of = |name: &str| name.rsplit('_').next().unwrap_or("").to_string();
        for (c, name) in columns.iter().enumerate() {
            let alike = columns.iter().zip(&here).filter(|(other, _)| unit_of(other) == unit_of(name));
            let size = alike.fold(0.0_f64, |m, (_, v)| m.max(v.abs())) / (theta.abs() * pascal);
            let (expected, got) = ((4.0 * fine[c] - coarse[c]) / 3.0, exact[c][k]);
            let label = format!("{} {formulation}: d {name}/d {key}", table["law"]);
            let error = (got - expected).abs() / size;
            assert!(error <= 1e-6, "{label} = {got}, differences say {expected} (size {size})");
            worst = worst.max(error);
        }
    }
    worst
}

/// Every constant of every law through the finger: gravity, cable under length control, reactions.
#[test]
fn every_constant_through_the_finger() {
    let body = body();
    for entry in LAWS {
        let name = entry.info.name;
        println!("{name}: {:.1e}", check("displacement", LENGTH, &example_table(name), &body));
    }
}

/// The mixed formulation, whose stabilisation and compliance hold constants too, and the cable under tension.
#[test]
fn mixed_formulation_and_imposed_tension() {
    let body = body();
    for name in ["neo_hookean", "gent"] {
        let mut table = example_table(name);
        if table.remove("kappa").is_some() {
            table.insert("nu".into(), 0.45.into());
        }
        println!("{name}, mixed: {:.1e}", check("mixed", LENGTH, &table, &body));
        println!("{name}, tension: {:.1e}", check("displacement", TENSION, &table, &body));
    }
}

/// Without gravity every force is proportional to E at fixed ν and length control imposes the motion: E dT/dE = T and the angle
/// does not depend on E at all. Equilibrium to 1e-11 of the forces: accepted 1e-8.
#[test]
fn length_control_hides_the_stiffness() {
    let body = body();
    for formulation in ["displacement", "mixed"] {
        let text = text(formulation, LENGTH, &example_table("neo_hookean")).replace("9.81 m/s^2", "0 m/s^2");
        let scene = build(&text, &body);
        let (columns, slopes) = slopes(&scene, &["E".into(), "nu".into()]);
        let values = values(&scene, &columns);
        let place = |name: &str| columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no {name}"));
        let (angle, tension) = (place("bending_angle_deg"), place("cable_tension_N"));
        let relative = |k: usize| slopes[k][0] * 100e3 / values[k];
        assert!(values[angle] > 5.0 && values[tension] > 0.01, "{values:?}");
        assert!((relative(tension) - 1.0).abs() < 1e-8, "E dT/dE = {} T", relative(tension));
        assert!(relative(angle).abs() < 1e-8, "E dθ/dE = {} θ", relative(angle));
    }
}

fn simulate(text: &str, slope: &str) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("a temporary file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("simulate").arg(&file).arg("--out").arg(folder.path());
    let output = command.args(["--slope", slope]).output().expect("the program starts");
    let table = std::fs::read_to_string(folder.path().join("scene.slopes.csv")).unwrap_or_default();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), table)
}

#[test]
fn the_command_writes_a_table() {
    let (code, errors, table) = simulate(&text("displacement", LENGTH, &example_table("yeoh")), "laws.rubber.C10");
    assert_eq!(code, Some(0), "{errors}");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[0].starts_with("t_s,d bending_angle_deg/d laws.rubber.C10,"), "{table}");
    assert_eq!(lines.len(), 3, "header, rest, end");
    assert!(lines[1].split(',').all(|v| v == "0"), "{table}");
}

/// (change of the text, constant, what the message must say)
#[test]
fn what_is_not_covered_is_refused() {
    let plain = text("displacement", LENGTH, &example_table("yeoh"));
    let moving = plain.replace("\"static\"", "\"implicit_euler\"");
    let spare = format!("{plain}[laws.spare]\nlaw = \"linear\"\nE = \"1 MPa\"\nnu = 0.3\n");
    for (text, slope, says) in [
        (&plain, "rubber.C10", "\"rubber.C10\" names no constant; write for example laws.rubber.mu"),
        (&plain, "laws.ruber.C10", "laws.ruber.C10: the scene has no such law; did you mean `rubber`?"),
        (&plain, "laws.rubber.mu", "laws.rubber.mu: `mu` is not given"),
        (&spare, "laws.spare.E", "no elastic effect takes this law"),
        (&moving, "laws.rubber.C10", "stage 1 is implicit_euler: derivatives are exact in static stages only"),
    ] {
        let (code, errors, _) = simulate(text, slope);
        assert_eq!(code, Some(2), "{slope}: {errors}");
        assert!(errors.contains(says), "{errors}\nnot: {says}");
    }
}
