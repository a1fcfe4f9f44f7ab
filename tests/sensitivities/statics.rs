//! Derivatives of what a static scene records by the constants of its laws: closed forms, and differences of whole runs
//! (`common/sensitivities.rs`).

use crate::common::{column, example_table, sensitivities};
use durometer::material::LAWS;
use durometer::scene::{Body, ParameterKey, RunOptions, Scene, SceneSpec, SensitivityRecorder, extreme};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use toml::Table;

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
tolerance = 1e-12
reuse_factor = false
[laws.rubber]
"#;
const LENGTH: &str = r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "5 mm", end = "1 s" } }"#;
const TENSION: &str = r#"{ kind = "tension", signal = { kind = "ramp", from = "0 N", to = "0.2 N", end = "1 s" } }"#;

fn text(formulation: &str, drive: &str, law: &Table) -> String {
    SCENE.replace("FORMULATION", formulation).replace("DRIVE", drive) + &toml::to_string(law).expect("a table")
}

fn build(text: &str, body: &Arc<Body>) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let spec = SceneSpec::from_text(&file, text, "").unwrap_or_else(|e| panic!("{e}\n{text}"));
    Scene::build(&file, spec, text.into(), body.clone()).unwrap_or_else(|e| panic!("{e}"))
}

fn body() -> Arc<Body> {
    let text = text("displacement", LENGTH, &example_table("neo_hookean"));
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let spec = SceneSpec::from_text(&file, &text, "").expect("the scene above");
    Body::load(&file, &spec.mesh, &mut |_| {}).expect("a committed mesh").into()
}

/// Every constant of the table against differences of runs; the largest error.
fn check(formulation: &str, drive: &str, table: &Table, body: &Arc<Body>) -> f64 {
    let label = format!("{} {formulation}", table["law"]);
    sensitivities::check(&label, table, &|table| build(&text(formulation, drive, table), body))
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

/// The row of an elastic cable has a compliance; a drive at its limit is a tension that does not change.
#[test]
fn an_elastic_cable_and_one_that_yields() {
    let body = body();
    for extra in ["EA = \"20 N\"", "max_tension = \"0.1 N\"", "EA = \"20 N\"\nfriction = 0"] {
        let drive = format!("{LENGTH}\n{extra}");
        println!("{extra}: {:.1e}", check("displacement", &drive, &example_table("neo_hookean"), &body));
    }
}

/// A coefficient of friction that is 0 changes no derivative; those of its own columns are checked above.
#[test]
fn the_coefficient_of_friction_zero_changes_no_derivative() {
    let (body, law) = (body(), example_table("neo_hookean"));
    let of = |extra: &str| {
        let scene = build(&text("displacement", &format!("{LENGTH}\n{extra}"), &law), &body);
        sensitivities::sensitivities(&scene, &["E".into()]).1
    };
    let (plain, zero) = (of(""), of("friction = 0"));
    assert!(zero.columns.len() > plain.columns.len(), "{:?}", zero.columns);
    for (place, name) in plain.columns.iter().enumerate() {
        let same = zero.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("{name} is missing"));
        for (a, b) in plain.rows.iter().zip(&zero.rows) {
            assert_eq!(a[place], b[same], "{name}");
        }
    }
}

/// Without gravity every force is proportional to E at fixed ν and length control imposes the motion: E dT/dE = T and the angle
/// does not depend on E at all. Equilibrium to 1e-12 of the forces: accepted 1e-8.
#[test]
fn length_control_hides_the_stiffness() {
    let body = body();
    for formulation in ["displacement", "mixed"] {
        let text = text(formulation, LENGTH, &example_table("neo_hookean")).replace("9.81 m/s^2", "0 m/s^2");
        let scene = build(&text, &body);
        let (run, sensitivities) = sensitivities::sensitivities(&scene, &["E".into(), "nu".into()]);
        let last = sensitivities.rows.last().expect("a row");
        // Value, and E/value times its derivative by E
        let relative = |name: &str| {
            let k = sensitivities.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no {name}"));
            let value = *column(&run, name).last().expect("a row");
            (value, last[k][0] * 100e3 / value)
        };
        let ((angle, turned), (tension, pulled)) = (relative("bending_angle_deg"), relative("cable_tension_N"));
        assert!(angle > 5.0 && tension > 0.01, "{angle}, {tension}");
        assert!((pulled - 1.0).abs() < 1e-8, "E dT/dE = {pulled} T");
        assert!(turned.abs() < 1e-8, "E dθ/dE = {turned} θ");
    }
}

fn simulate(text: &str, slope: &str) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("a temporary file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("simulate").arg(&file).arg("--out").arg(folder.path());
    let output = command.args(["--sensitivity", slope]).output().expect("the program starts");
    let table = std::fs::read_to_string(folder.path().join("scene.sensitivities.csv")).unwrap_or_default();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), table)
}

#[test]
fn the_command_writes_a_table() {
    let text = text("displacement", LENGTH, &example_table("yeoh"))
        .replace("[numerics]", "[[probe]]\nkind = \"moment\"\nregion = \"root\"\n[numerics]");
    let (code, errors, table) = simulate(&text, "laws.rubber.C10");
    assert_eq!(code, Some(0), "{errors}");
    let left_out = errors.lines().find_map(|line| line.strip_prefix("note: no derivatives are computed of "));
    let left_out: Vec<&str> = left_out.unwrap_or_else(|| panic!("{errors}")).split(", ").collect();
    assert!(left_out.contains(&"root_moment_x_Nm") && !left_out.contains(&"t_s"), "{left_out:?}");
    assert!(left_out.iter().all(|column| !table.contains(&format!("d {column}/d "))), "{left_out:?}");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[0].starts_with("t_s,d bending_angle_deg/d laws.rubber.C10,"), "{table}");
    assert_eq!(lines.len(), 3, "header, rest, end");
    assert!(lines[1].split(',').all(|v| v == "0"), "{table}");
}

/// (change of the text, constant, what the message must say)
#[test]
fn what_is_not_covered_is_refused() {
    let plain = text("displacement", LENGTH, &example_table("yeoh"));
    let friction = text("displacement", &format!("{LENGTH}\nfriction = 0.1"), &example_table("yeoh"));
    let linearised = plain.replace("\"static\"", "\"implicit_euler_linearised\"");
    let spare = format!("{plain}[laws.spare]\nlaw = \"linear\"\nE = \"1 MPa\"\nnu = 0.3\n");
    for (text, slope, says) in [
        (
            &plain,
            "density",
            "\"density\" is no path to a key of a scene; write for example laws.rubber.mu, or effect.gravity.density",
        ),
        (&plain, "rubber.C10", "\"rubber.C10\" leads nowhere: there is no \"rubber\""),
        (&plain, "laws.ruber.C10", "laws.ruber.C10: the scene has no such law; did you mean `rubber`?"),
        (&plain, "laws.rubber.mu", "laws.rubber.mu: `mu` is not given"),
        (&spare, "laws.spare.E", "no elastic effect takes this law"),
        (&friction, "laws.rubber.C10", "the cable has friction: its tensions depend on the path of loading"),
        (&linearised, "laws.rubber.C10", "stage 1 is implicit_euler_linearised, whose states are not converged"),
    ] {
        let (code, errors, _) = simulate(text, slope);
        assert_eq!(code, Some(2), "{slope}: {errors}");
        assert!(errors.contains(says), "{errors}\nnot: {says}");
    }
}

/// A size of a mesh that a mesher makes has no derivative; a declared deformation of the same mesh has.
#[test]
fn shapes_of_made_meshes_need_a_declared_deformation() {
    let body = body();
    let plain = text("displacement", LENGTH, &example_table("neo_hookean")).replace("cells = 700", "size = \"6 mm\"");
    let keys = |path: &str| [path.parse::<durometer::scene::ParameterKey>().expect("a path")];
    let refused = durometer::scene::SensitivityRecorder::new(&build(&plain, &body), &keys("mesh.size")).err();
    let message = refused.expect("refused").to_string();
    assert!(message.contains("the mesher would make another mesh") && message.contains("[mesh.deform]"), "{message}");
}

/// A pull that is let go of, and a dynamic stage of the same: at extremes the derivatives are those of every step, bit for bit. In statics no other
/// row has them, and a factorisation is made for each row with an extreme; in dynamics every step needs the one before.
#[test]
fn derivatives_at_extremes_are_those_of_every_step() {
    let body = body();
    let drive = r#"{ kind = "length", signal = { kind = "raised_cosine", amplitude = "5 mm", frequency = "1 Hz" } }"#;
    let text = text("displacement", drive, &example_table("neo_hookean"))
        .replace("dt = \"1 s\"", "dt = \"0.1 s\"")
        .replace("reuse_factor = false", "");
    let dynamic = text.replace("integrator = \"static\"", "integrator = \"bdf2\"");
    for (text, is_static) in [(text, true), (dynamic, false)] {
        let scene = build(&text, &body);
        let keys: Vec<ParameterKey> =
            ["laws.rubber.E", "effect.gravity.density"].map(|key| key.parse().expect("a key")).to_vec();
        let run = |recorder| scene.run_with(RunOptions { sensitivities: Some(recorder), ..RunOptions::default() });
        let [all, few] = [SensitivityRecorder::new, SensitivityRecorder::at_extremes]
            .map(|new| run(new(&scene, &keys).expect("a scene with derivatives")));
        assert_eq!((&all.status, &all.rows), (&few.status, &few.rows));
        let [all_found, found] = [&all, &few].map(|run| run.sensitivities.as_ref().expect("asked for"));
        let at = |name: &String| {
            let k = all.columns.iter().position(|column| column == name).expect("a recorded column");
            extreme(all.rows.iter().map(|row| row[k])).expect("rows").at
        };
        let rows: BTreeSet<usize> = found.columns.iter().map(at).collect();
        assert!(rows.contains(&5) && rows.len() < 6, "most at the end of the pull: {rows:?}");
        let bits = |row: &Vec<Vec<f64>>| row.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        for (k, (all, few)) in all_found.rows.iter().zip(&found.rows).enumerate() {
            if k == 0 || rows.contains(&k) || !is_static {
                assert_eq!(bits(all), bits(few), "row {k}");
            } else {
                assert!(few.iter().flatten().all(|x| x.is_nan()), "row {k}: {few:?}");
            }
        }
        let counts = (all_found.factorisations, found.factorisations);
        assert_eq!(counts, if is_static { (10, rows.len()) } else { (10, 10) });
        assert_eq!(all_found.rows.len(), found.rows.len());
    }
}
