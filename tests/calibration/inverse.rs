//! Inverse analysis: constants found again from simulated tests, in other units, from a bad start; what a curve does not say; the
//! synthetic dumbbell of `studies/dumbbell-synthetic`.

use crate::common;
use crate::common::coverage::{Coverage, Found, median_half};
use crate::common::studies::run_study;
use crate::common::{Random, example_table};
use durometer::calibrate::inverse::{
    Bound, Bounds, Calibration, End, Failure, InverseError, Measured, MeasuredSpec, ObservedCurve, OffsetAxis,
    SceneModel, Settings, Unknown, calibrate,
};
use durometer::calibrate::{ErrorModel, FittableLaw, Loss, Mode, Weighting};
use durometer::material::{LAWS, registry};
use durometer::math::statistics::{deviation, larger};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{ParameterKey, Progress, Scene};
use durometer::solve::Status;
use durometer::study::expand::Study;
use durometer::study::report;
use durometer::study::store::record::CaseRecord;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A bar between bonded ends; `to` and `steps` of the pull.
pub fn bar(law: &Table, to: &str, steps: usize) -> Scene {
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

pub const X: &str = "middle_x_displacement_m";
pub const Y: &str = "middle_reaction_x_N";

pub fn model(scene: &Scene, keys: &[&str], x: &str, y: &str) -> SceneModel {
    let constants: Vec<ParameterKey> =
        keys.iter().map(|k| format!("laws.rubber.{k}").parse().expect("a name")).collect();
    let unknown = Unknown::all((Path::new("scene.toml"), &scene.spec, &scene.text), &constants, &Bounds::new())
        .unwrap_or_else(|e| panic!("{e}"));
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
pub fn made(model: &SceneModel, x: Vec<f64>) -> Measured {
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
    let answer = match model.answer(&own, &blank.x, 0.0, &mut |_| true) {
        Ok(answer) => answer,
        Err(Failure::Input(e)) => panic!("{e}"),
        Err(_) => panic!("the truth can be solved"),
    };
    Measured { y: answer.y, ..blank }
}

pub fn curve(model: &SceneModel, measured: &Measured) -> ObservedCurve {
    ObservedCurve {
        name: "made".into(),
        model: model.clone(),
        measured: measured.clone(),
        specimen: None,
        offsets: vec![],
    }
}

/// Curves without errors, which the scenes reproduce to rounding.
fn exact() -> Settings {
    Settings { accuracy: 1e-7, ..Settings::new(Weighting::Absolute) }
}

fn found(model: &SceneModel, measured: &Measured) -> Calibration {
    found_with(vec![curve(model, measured)], &exact())
}

pub fn found_with(curves: Vec<ObservedCurve>, settings: &Settings) -> Calibration {
    match calibrate(curves, settings, None, &mut |_: Progress| true) {
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
        let off =
            |(f, u): (&durometer::calibrate::inverse::FittedConstant, &durometer::calibrate::inverse::Unknown)| {
                (f.value / u.start - 1.0).abs()
            };
        let worst = c.constants.iter().zip(&truth.unknown).map(off).fold(0.0, larger);
        println!(
            "{} {keys:?}: {worst:.1e} in {} solves, misfit {:.1e}",
            entry.info.name, c.solves, c.curves[0].rms_relative
        );
        let misfit = c.curves[0].rms_relative;
        assert!(c.settled() && misfit < 1e-6, "{}: misfit {misfit:e}", entry.info.name);
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

/// A curve is read in the unit of the column that it is compared with, of every dimension that a column has.
#[test]
fn a_curve_has_the_unit_of_its_column() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("table.csv"), "u;F\n0;0\n90;2.5\n180;5\n").expect("writable");
    let read = |[of_x, x]: [&str; 2], [of_y, y]: [&str; 2]| {
        let column = |name: &str, unit: &str, is: &str| {
            format!(
                "{name} = {{ column = \"{}\", unit = \"{unit}\", is = \"{is}\" }}\n",
                if name == "x" { "u" } else { "F" }
            )
        };
        let spec = format!("file = \"table.csv\"\n{}{}", column("x", of_x, x), column("y", of_y, y));
        let spec: MeasuredSpec = toml::from_str(&spec).expect("sound");
        Measured::read(folder.path(), &spec).map_err(|e| e.to_string())
    };
    let rotation = ["deg", "xmax_rotation_rad"];
    for (y, last) in [
        (["mN m", "xmin_moment_x_Nm"], 5e-3),
        (["1/mm", "line_1_curvature_per_m"], 5e3),
        (["mm^2", "sole_area_m2"], 5e-6),
        (["ml", "air_volume_m3"], 5e-6),
        (["rad", "bending_angle_deg"], 5.0_f64.to_degrees()),
        (["1", "stretch_p95"], 5.0),
    ] {
        let read = read(rotation, y).unwrap_or_else(|e| panic!("{y:?}: {e}"));
        let ends = [read.x[2] / std::f64::consts::PI, read.y[2] / last];
        assert!(ends.iter().all(|ratio| (ratio - 1.0).abs() < 1e-14), "{y:?}: {ends:?}");
    }
    for y in [
        ["mm", "line_1_curvature_per_m"],
        ["1", "xmin_moment_x_Nm"],
        ["mm", "sole_area_m2"],
        ["1", "bending_angle_deg"],
    ] {
        let why = read(rotation, y).expect_err("another dimension");
        assert!(why.contains(y[1]) && why.contains("wrong dimension"), "{why}");
    }
}

/// The loading of a force ends before a hold at its peak, at which it relaxes, and before a rupture, with notes; `cycle = "all"` takes every row.
#[test]
fn a_loading_ends_before_a_hold_and_before_rupture() {
    let text = |rows: &[[f64; 2]]| -> String { rows.iter().map(|[x, y]| format!("{x},{y}\n")).collect() };
    let pulled: Vec<[f64; 2]> = (0..50).map(|k| 0.2 * f64::from(k)).map(|x| [x, 2.0 * x]).collect();
    let hold = (0..200).map(|k| [9.8 + 1e-3 * f64::from(k % 3), 19.6 * (0.8 + 0.2 * (-f64::from(k) / 40.0).exp())]);
    let held = text(&pulled.iter().copied().chain(hold).collect::<Vec<_>>());
    let torn = text(&pulled.iter().map(|[x, y]| [*x, if *x < 6.1 { *y } else { 0.01 }]).collect::<Vec<_>>());
    for (rows, last, note) in
        [(&held, 9.8, "of a hold at the peak were left out"), (&torn, 6.0, "after rupture were left out")]
    {
        let found = read("u,F", rows, "").unwrap_or_else(|e| panic!("{e}"));
        let end = 1e3 * found.x.last().expect("rows");
        assert!((end - last).abs() < 0.01, "{note}: to {end} mm, {:?}", found.notes);
        assert!(found.notes.len() == 1 && found.notes[0].contains(note), "{:?}", found.notes);
        let all = read("u,F", rows, "cycle = \"all\"").unwrap_or_else(|e| panic!("{e}"));
        assert!(all.notes.is_empty() && all.x.len() == rows.lines().count(), "{:?}", all.notes);
    }
}

/// A table with these lines below its names, read for the bar.
fn read(names: &str, lines: &str, more: &str) -> Result<Measured, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("table.csv"), format!("{names}\n{lines}")).expect("writable");
    let spec = format!(
        "file = \"table.csv\"\nx = {{ column = \"u\", unit = \"mm\", is = \"{X}\" }}\ny = {{ column = \"F\", unit = \"N\", is = \"{Y}\" }}\n{more}"
    );
    let spec: MeasuredSpec = toml::from_str(&spec).expect("sound");
    Measured::read(folder.path(), &spec).map_err(|e| e.to_string())
}

/// Of a table that loads and unloads twice the first loading counts, with a note, or the one that is asked for. A scatter of x is no unloading.
#[test]
fn one_loading_of_a_table_counts() {
    let up: Vec<f64> = (0..12).map(|k| 0.5 * f64::from(k)).collect();
    let down: Vec<f64> = up.iter().rev().skip(1).copied().collect();
    let lines = |x: &[f64]| -> String { x.iter().enumerate().map(|(k, x)| format!("{x},{k}\n")).collect() };
    let twice = lines(&[&up[..], &down, &up[1..], &down].concat());
    let rows = |more: &str| read("u,F", &twice, more).map(|m| (m.y[0], m.y.len(), m.notes.len()));
    assert_eq!(rows(""), Ok((0.0, 12, 1)));
    assert_eq!(rows("cycle = \"last-loading\""), Ok((23.0, 11, 1)));
    assert_eq!(rows("cycle = \"all\""), Ok((0.0, 45, 0)));
    assert!(rows("cycle = \"3\"").is_err_and(|e| e.contains("the table has 2")));
    let mut noise = Random::seed(3);
    let scattered: Vec<f64> = (0..60).map(|k| 0.1 * f64::from(k) + 0.15 * noise.normal()).collect();
    assert_eq!(read("u,F", &lines(&scattered), "").map(|m| m.y.len()), Ok(60));
}

/// A unit in the names of the table, or below them, has to be that of the study.
#[test]
fn units_of_table_and_study_agree() {
    let lines = "0,0\n1,0.1\n2,0.2\n3,0.3\n";
    for names in ["u,F", "u (mm),F (N)", "u [mm],F\nmm,N", "u (machine),F (N)"] {
        let read = read(names, lines, "").unwrap_or_else(|e| panic!("{names}: {e}"));
        assert_eq!((read.x.len(), read.notes.len()), (4, 0), "{names}");
    }
    for (names, said) in
        [("u (cm),F (N)", "\"u (cm)\" is in cm by the table and in mm"), ("u,F\nmm,kN", "in kN by the table")]
    {
        let refused = read(names, lines, "").expect_err(names);
        assert!(refused.contains(said) && refused.contains("correct one of them"), "{refused}");
    }
}

/// Gent's law ends where its chains are stretched out: trial constants beyond are walls, not the end of the search.
#[test]
fn a_forward_solve_that_fails_is_stepped_back_from() {
    let mut law = example_table("gent");
    law.insert("J_m".into(), 0.35.into());
    let truth = model(&bar(&law, "7 mm", 10), &["mu", "J_m"], X, Y);
    let measured = made(&truth, (1..=30).map(|k| 7e-3 * f64::from(k) / 30.0).collect());
    let mut start = law.clone();
    start.insert("J_m".into(), 30.0.into());
    let c = found(&model(&bar(&start, "7 mm", 10), &["mu", "J_m"], X, Y), &measured);
    println!("{} solves, {} failed: {:?}", c.solves, c.failed, c.constants);
    assert!(c.failed > 0, "the case must make forward solves fail");
    assert!((c.constants[1].value / 0.35 - 1.0).abs() < 1e-4, "{:?}", c.constants);
}

/// The protocol goes on where the law has no answer any more; the data end before, and nothing beyond them is solved.
#[test]
fn the_protocol_after_the_data_is_not_solved() {
    let mut law = example_table("gent");
    law.insert("J_m".into(), 0.35.into());
    let truth = model(&bar(&law, "7 mm", 10), &["mu", "J_m"], X, Y);
    let measured = made(&truth, (1..=30).map(|k| 7e-3 * f64::from(k) / 30.0).collect());
    let whole = bar(&law, "14 mm", 20);
    assert_ne!(whole.run().status, Status::Converged, "the law ends before the protocol");
    let mut start = law.clone();
    start.insert("J_m".into(), 1.0.into());
    let c = found(&model(&bar(&start, "14 mm", 20), &["mu", "J_m"], X, Y), &measured);
    assert!(c.settled() && (c.constants[1].value / 0.35 - 1.0).abs() < 1e-4, "{:?}", c.constants);
    assert_eq!(c.curves[0].curve.len(), 11, "the start, and ten steps to the last data point");
}

/// Curves of two or three specimens whose stiffness scatters by 5 %, with noise of 0.3 %: the interval is t s/√k of the stiffnesses that least squares find in each curve alone, in each of 20 draws, and holds
/// the mean stiffness in 95 % of them. By the noise of the data points alone it held it in 58 and 68 %. Curves that are said to be of one specimen count by their data points.
#[test]
fn the_interval_of_several_specimens_is_that_between_them() {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "3 mm", 2), &["E"], X, Y);
    let mean = truth.unknown[0].start;
    let exact = made(&truth, (1..=20).map(|k| 1.5e-4 * f64::from(k)).collect());
    let largest = exact.y.iter().copied().fold(0.0, larger);
    let along = |y: &[f64]| exact.y.iter().zip(y).map(|(exact, y)| exact * y).sum::<f64>();
    let draw = |count: usize, seed: u64, specimen: Option<&str>| {
        let mut noise = Random::seed(1 + 7919 * seed);
        let one = |_| {
            let level = 1.0 + 0.05 * noise.normal();
            let y = exact.y.iter().map(|y| level * y + 3e-3 * largest * noise.normal()).collect();
            ObservedCurve { specimen: specimen.map(Into::into), ..curve(&truth, &Measured { y, ..exact.clone() }) }
        };
        let curves: Vec<ObservedCurve> = (0..count).map(one).collect();
        let levels: Vec<f64> = curves.iter().map(|c| along(&c.measured.y) / along(&exact.y)).collect();
        (levels, found_with(curves, &Settings::new(Weighting::Absolute)))
    };
    // t₀.₉₇₅ of one and two degrees of freedom
    for (count, t) in [(2, 12.706_205), (3, 4.302_653)] {
        let one = |seed: u64| {
            let (levels, c) = draw(count, seed, None);
            assert_eq!(c.errors, ErrorModel::Specimens { specimens: count });
            assert!(c.curves.iter().all(|c| c.runs_p.is_none()), "a level is no pattern");
            let [low, high] = c.constants[0].interval.expect("determined");
            let half = t * mean * deviation(&levels) / (count as f64).sqrt();
            assert!((0.5 * (high - low) / half - 1.0).abs() < 1e-4, "{seed}: {low} to {high}, not ±{half}");
            (c.constants[0].value, [low, high])
        };
        let found = Coverage::of(mean, &(0..20).into_par_iter().map(one).collect::<Vec<_>>());
        println!("{count} specimens: {found:?}");
        assert!(found.holds(), "{count} specimens: {found:?}");
    }
    let (_, one) = draw(3, 1, Some("A"));
    assert!(!matches!(one.errors, ErrorModel::Specimens { .. }), "{:?}", one.errors);
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

/// Without gravity the angle of a body under cable-length control does not depend on its stiffness.
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
    assert!(blind.unidentified[0].contains("do not determine μ"), "{:?}", blind.unidentified);
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
    let largest = measured.y.iter().fold(0.0, |m, y| larger(m, y.abs()));
    let mut random = common::Random::seed(11);
    measured.y.iter_mut().for_each(|y| *y += 0.01 * largest * random.normal());
    let c = found_with(vec![curve(&truth, &measured)], &Settings { profile: true, ..exact() });
    for (f, u) in c.constants.iter().zip(&truth.unknown) {
        let (wald, profile) = (f.interval.expect("determined"), f.profile.expect("asked for"));
        println!("{}: {wald:?} {profile:?} in {} solves", f.key, c.profile_solves);
        for (w, p) in wald.iter().zip(profile) {
            let p = p.expect("an end");
            assert!((p - w).abs() < 0.025 * (wald[1] - wald[0]), "{}: {w} {p}", f.key);
        }
        assert!(wald[0] < u.start && u.start < wald[1], "{}: {wald:?} {}", f.key, u.start);
    }
    // Where the other constant has no room, it is held at its bounds, and the profile is closed all the same
    let (value, error) = (c.constants[1].value, c.constants[1].std_error.expect("determined"));
    let mut near = truth.clone();
    (near.unknown[1].start, near.unknown[1].bounds) = (value, [value - 0.5 * error, value + 0.5 * error]);
    let held = found_with(vec![curve(&near, &measured)], &Settings { profile: true, ..exact() });
    let ends = |c: &Calibration| c.constants[0].profile.expect("asked for").map(|end| end.expect("an end"));
    let ([low, high], [least, most]) = (ends(&held), ends(&c));
    assert!(least < low && high < most, "{low} to {high} in {least} to {most}");
}

/// The reading by a gauge length of constants that are sought, with the others at the values of the scene: of one factor it is P(1)·(P − P(0))/P(1)², summed
/// over the data points, whatever the data; a shape is found again from the data of the law itself. A term held at zero is a term that is not there.
#[test]
fn a_gauge_length_reads_what_is_sought_with_the_rest_held() {
    let (length, section) = (0.015, 1e-4);
    let read = |law: &str, keys: &[&str], stress: &dyn Fn(f64) -> f64| {
        let law: Table = law.parse().expect("TOML");
        let model = model(&bar(&law, "6 mm", 4), keys, X, Y);
        let mut measured = made(&model, (1..=20).map(|k| 3e-4 * f64::from(k)).collect());
        measured.y = measured.x.iter().map(|x| section * stress(1.0 + x / length)).collect();
        let settings = Settings { gauge: Some([length, section]), ..Settings::new(Weighting::Absolute) };
        let gauge = found_with(vec![curve(&model, &measured)], &settings).gauge.expect("a closed form");
        gauge.values.iter().map(|v| v.expect("of the law")).collect::<Vec<f64>>()
    };
    let stretches: Vec<f64> = (1..=20).map(|k| 1.0 + 3e-4 * f64::from(k) / length).collect();
    let form = |name: &str, terms: usize, values: &[f64], stretch: f64| {
        FittableLaw::new(name, Some(terms)).expect("a law").stress(values, Mode::Uniaxial, stretch)
    };
    let test = |stretch: f64| 120e3 * (stretch - stretch.powi(-2)) * (1.0 + 0.2 * (stretch - 1.0).powi(2));
    let factor = |name: &str, terms: usize, at: &dyn Fn(f64) -> Vec<f64>| {
        let [zero, one] = [0.0, 1.0].map(|c| move |l: f64| form(name, terms, &at(c), l));
        let column = |l: f64| one(l) - zero(l);
        let sum = |f: &dyn Fn(f64) -> f64| stretches.iter().map(|l| f(*l)).sum::<f64>();
        sum(&|l| column(l) * (test(l) - zero(l))) / sum(&|l| column(l).powi(2))
    };
    let near = |found: &[f64], right: &[f64]| {
        println!("{found:?} {right:?}");
        assert!(found.iter().zip(right).all(|(a, b)| (a / b - 1.0).abs() < 1e-6), "{found:?} {right:?}");
    };
    let volume = "volumetric = \"quadratic\"\nnu = 0.45";
    let mooney = format!("law = \"mooney_rivlin\"\nC10 = \"50 kPa\"\nC01 = \"20 kPa\"\n{volume}");
    near(&read(&mooney, &["C10"], &test), &[factor("mooney_rivlin", 2, &|c| vec![c, 20e3])]);
    let ogden = format!("law = \"ogden\"\nmu1 = \"100 kPa\"\nalpha1 = 3.0\n{volume}");
    near(&read(&ogden, &["mu1"], &test), &[factor("ogden", 1, &|c| vec![c, 3.0])]);
    near(&read(&ogden, &["alpha1"], &|l| form("ogden", 1, &[100e3, 4.0], l)), &[4.0]);
    let yeoh = format!("law = \"yeoh\"\nC10 = \"50 kPa\"\nC20 = \"5 kPa\"\n{volume}");
    let keys = ["C10", "C20"];
    near(&read(&format!("{yeoh}\nC30 = \"0 kPa\""), &keys, &test), &read(&yeoh, &keys, &test));
    // E of a law whose closed form has μ: 2μ(1 + ν) with ν held, 9κμ/(3κ + μ) with κ held
    let neo = |pair: &str, key: &str| read(&format!("law = \"neo_hookean\"\n{pair}"), &[key], &test);
    let mu = neo("mu = \"100 kPa\"\nnu = 0.45", "mu")[0];
    near(&[mu], &[factor("neo_hookean", 1, &|c| vec![c])]);
    near(&neo("E = \"300 kPa\"\nnu = 0.45", "E"), &[2.9 * mu]);
    near(&neo("E = \"300 kPa\"\nkappa = \"1 MPa\"", "E"), &[9e6 * mu / (3e6 + mu)]);
}

/// Where a homogeneous piece tells nothing of what is sought, the answer says why.
#[test]
fn a_reading_by_a_gauge_length_that_is_left_out_has_a_reason() {
    let why = |law: &str, key: &str| {
        let law: Table = law.parse().expect("TOML");
        let model = model(&bar(&law, "6 mm", 4), &[key], X, Y);
        let measured = made(&model, (1..=20).map(|k| 3e-4 * f64::from(k)).collect());
        let settings = Settings { gauge: Some([0.015, 1e-4]), ..Settings::new(Weighting::Absolute) };
        let gauge = found_with(vec![curve(&model, &measured)], &settings).gauge.expect("it is asked for");
        assert_eq!((gauge.values, gauge.rms_relative), (vec![None], None));
        gauge.left_out.expect("a reason")
    };
    let linear = why("law = \"stable_neo_hookean\"\nE = \"300 kPa\"\nnu = 0.45", "E");
    assert_eq!(linear, "the law of rubber, stable Neo-Hookean, has no closed form for a homogeneous piece");
    let ratio = why("law = \"neo_hookean\"\nE = \"300 kPa\"\nnu = 0.4", "nu");
    assert!(ratio.contains("none of the constants of rubber that are looked for"), "{ratio}");
}

/// Bounds that exclude the truth: the constant is held there, named, and has no interval; the other one is the best next to it. Let go, the search
/// comes back from a bound at which it began.
#[test]
fn a_bound_holds_a_constant_and_is_named() {
    let law = example_table("mooney_rivlin");
    let truth = model(&bar(&law, "6 mm", 6), &["C10", "C20"], X, Y);
    let measured = made(&truth, (1..=30).map(|k| 2e-4 * f64::from(k)).collect());
    let c10 = truth.unknown[0].start;
    let bounded = |low: f64, high: f64, start: f64| {
        let mut model = truth.clone();
        model.unknown[0].start = start;
        model.unknown[0].bounds = [low, high];
        found(&model, &measured)
    };
    let held = bounded(0.1 * c10, 0.8 * c10, 0.5 * c10);
    assert_eq!((held.constants[0].value, held.constants[0].bound), (0.8 * c10, Bound::Upper));
    assert!(held.settled() && held.constants[0].interval.is_none() && held.constants[1].interval.is_some());
    let named = held.unidentified.iter().any(|words| words.contains("laws.rubber.C10 is held at its upper bound"));
    assert!(named, "{:?}", held.unidentified);
    let free = bounded(0.8 * c10, 2.0 * c10, 0.8 * c10);
    assert!(
        free.constants[0].bound.is_free() && (free.constants[0].value / c10 - 1.0).abs() < 1e-5,
        "{:?}",
        free.constants
    );
}

/// A curve that is given twice counts once: it is refused before the search.
#[test]
fn one_curve_under_two_names_is_refused() {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "6 mm", 6), &["E"], X, Y);
    let measured = made(&truth, (1..=30).map(|k| 2e-4 * f64::from(k)).collect());
    let again = Measured { file: "again".into(), ..measured.clone() };
    let both = vec![curve(&truth, &measured), curve(&truth, &again)];
    let refused = calibrate(both, &exact(), None, &mut |_: Progress| true);
    assert!(matches!(refused, Err(Failure::Input(InverseError::SameData { .. }))));
}

/// A force of the other sign is refused before the search, whatever the start.
#[test]
fn a_curve_of_the_other_sign_is_refused() {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "6 mm", 6), &["E"], X, Y);
    let mut measured = made(&truth, (1..=30).map(|k| 2e-4 * f64::from(k)).collect());
    measured.y.iter_mut().for_each(|y| *y = -*y);
    for factor in [0.1, 1.0, 10.0] {
        let mut start = truth.clone();
        start.unknown[0].start *= factor;
        let refused = calibrate(vec![curve(&start, &measured)], &exact(), None, &mut |_: Progress| true);
        assert!(matches!(refused, Err(Failure::Input(InverseError::Sign { cosine, .. })) if cosine < -0.99));
    }
}

/// Everything that is wrong with bounds is said at once.
#[test]
fn bounds_that_cannot_be_met_are_refused_together() {
    let law: Table = "law = \"neo_hookean\"\nmu = \"100 kPa\"\nnu = 0.45".parse().expect("TOML");
    let scene = bar(&law, "3 mm", 2);
    let constants: Vec<ParameterKey> = ["mu", "nu"].map(|k| format!("laws.rubber.{k}").parse().expect("a name")).into();
    let of = |text: &str| {
        let bounds: Bounds = toml::from_str(text).expect("TOML");
        Unknown::all((Path::new("scene.toml"), &scene.spec, &scene.text), &constants, &bounds)
    };
    let ok = of("\"laws.rubber.mu\" = [\"10 kPa\", \"1 MPa\"]\n\"laws.rubber.nu\" = [0.3, 0.5]")
        .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(ok[0].bounds, [1e4, 1e6]);
    assert!(ok[1].bounds[0] == 0.3 && ok[1].bounds[1] < 0.5, "the end of an open interval is not taken");
    let Err(why) = of(
        "\"laws.rubber.mu\" = [\"1 MPa\", \"10 kPa\"]\n\"laws.rubber.nu\" = [0.46, 0.49]\n\"laws.rubber.kappa\" = [1, 2]",
    ) else {
        panic!("they cannot be met")
    };
    let words = why.to_string();
    for part in ["laws.rubber.kappa: it has bounds", "leave nothing between them", "exclude it"] {
        assert!(words.contains(part), "{words}");
    }
    let Err(why) = of("\"laws.rubber.nu\" = [0.3, 0.6]") else { panic!("beyond the law") };
    assert!(why.to_string().contains("go beyond what the law allows"), "{why}");
}

/// A cantilever bent by a cable, its angle over the tension: bending and compression are of E, and ν changes the angle at the same E by less
/// than the one per cent to which such a scene can be trusted. Neither μ nor ν has an interval, and E is named.
#[test]
fn an_angle_over_the_tension_determines_e_alone() {
    let scene = |mu: &str, nu: f64| {
        let text = format!(
            r#"
[mesh]
body = "block"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "mixed"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["20 mm", "5 mm", "2 mm"], ["50 mm", "5 mm", "2 mm"]]
pull_point = ["-6 mm", "5 mm", "2 mm"]
guide_radius = "point"
drive = {{ kind = "tension", signal = {{ kind = "ramp", from = "0 N", to = "0.4 N", end = "1 s" }} }}
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
mu = "{mu}"
nu = {nu}
"#
        );
        common::scene(block(12, 2, 2, 0.06, 0.01, 0.01, Order::Quadratic), &text)
    };
    let of = |mu: &str, nu: f64| model(&scene(mu, nu), &["mu", "nu"], TENSION, "bending_angle_deg");
    let truth = of("100 kPa", 0.4);
    let mut measured = made(&truth, (1..=20).map(|k| 0.02 * f64::from(k)).collect());
    let mut random = common::Random::seed(3);
    let largest = measured.y.iter().fold(0.0, |m, y| larger(m, y.abs()));
    measured.y.iter_mut().for_each(|y| *y += 0.005 * largest * random.normal());
    let started = of("60 kPa", 0.3);
    let c = found_with(vec![curve(&started, &measured)], &Settings::new(Weighting::Absolute));
    println!("{:?}\n{:?} in {} solves", c.unidentified, c.constants, c.solves);
    assert!(
        c.settled() && c.unidentified[0].contains("they determine E, Young's modulus at rest"),
        "{:?}",
        c.unidentified
    );
    assert!(c.constants.iter().all(|f| f.interval.is_none()) && c.covariance.is_none());
    let e = 2.0 * c.constants[0].value * (1.0 + c.constants[1].value);
    // A modulus that stays moves by less than a tenth of the constants; here ν moves by 0.1 or 0.13 in u, next to errors of 0.5 % and the 1 %
    // to which directions are told apart
    assert!((e / 280e3 - 1.0).abs() < 0.04, "E = {e}");
}

/// A budget of time that is over at once leaves the answer of one step, and the next search goes on from it.
#[test]
fn a_search_without_time_goes_on_later() {
    let law = example_table("yeoh");
    let truth = model(&bar(&law, "6 mm", 6), &["C10", "C20"], X, Y);
    let measured = made(&truth, (1..=20).map(|k| 3e-4 * f64::from(k)).collect());
    let start = model(&bar(&moved(&law, &["C10", "C20"], 0.3), "6 mm", 6), &["C10", "C20"], X, Y);
    let short = Settings { time_budget: Some(1e-9), ..exact() };
    let first = found_with(vec![curve(&start, &measured)], &short);
    assert_eq!((first.end, first.solves), (End::OutOfTime, 2));
    let Ok((second, _)) =
        calibrate(vec![curve(&start, &measured)], &exact(), Some(&first.values()), &mut |_: Progress| true)
    else {
        panic!("it can be solved")
    };
    assert!(second.settled() && (second.constants[0].value / truth.unknown[0].start - 1.0).abs() < 1e-6);
    let Ok((third, _)) =
        calibrate(vec![curve(&start, &measured)], &exact(), Some(&second.values()), &mut |_: Progress| true)
    else {
        panic!("it can be solved")
    };
    assert!(third.settled() && third.solves <= 2, "from its own answer a search has nothing to do: {}", third.solves);
}

/// μ of Gent's law from a short pull that hardly sees J_m, and J_m from a stubbier bar that is pulled far: together they determine both, each
/// curve by its own noise; the first one alone leaves J_m open.
#[test]
fn two_curves_share_their_constants() {
    let mut law = example_table("gent");
    law.insert("J_m".into(), 1.2.into());
    let keys = ["mu", "J_m"];
    let far = model(&bar(&law, "7 mm", 10), &keys, X, Y);
    let near = model(&bar(&law, "0.4 mm", 4), &keys, X, Y);
    let mut random = common::Random::seed(5);
    let mut noisy = |model: &SceneModel, to: f64, size: f64| {
        let mut m = made(model, (1..=25).map(|k| to * f64::from(k) / 25.0).collect());
        m.y.iter_mut().for_each(|y| *y += size * random.normal());
        m
    };
    // A machine for small forces, and a coarse one
    let (small, large) = (noisy(&near, 4e-4, 2e-4), noisy(&far, 7e-3, 2e-2));
    // J_m changes the curve by little more than one per cent, to which scenes are trusted if nothing is said
    let settings = Settings { accuracy: 1e-3, ..Settings::new(Weighting::Noise) };
    let mut start = law.clone();
    start.insert("J_m".into(), 3.0.into());
    let [near, far] = [("0.4 mm", 4), ("7 mm", 10)].map(|(to, steps)| model(&bar(&start, to, steps), &keys, X, Y));
    let alone =
        found_with(vec![curve(&near, &small)], &Settings { weighting: Weighting::Absolute, ..settings.clone() });
    assert!(alone.constants[1].interval.is_none_or(|[a, b]| b - a > 0.5), "{:?}", alone.constants);
    let both = found_with(vec![curve(&near, &small), curve(&far, &large)], &settings);
    println!("{:?}", both.constants);
    let wide = |c: &Calibration, k: usize| c.constants[k].interval.map(|[a, b]| b - a).expect("determined");
    for (k, value) in [(0, truth_of(&law, "mu")), (1, 1.2)] {
        let [a, b] = both.constants[k].interval.expect("determined");
        assert!(a < value && value < b, "{k}: {a} {value} {b}");
    }
    let other = found_with(vec![curve(&far, &large)], &Settings { weighting: Weighting::Absolute, ..settings });
    assert!(wide(&both, 0) < 0.5 * wide(&other, 0), "the good machine counts by its noise");
    assert_eq!(both.curves.len(), 2);
}

/// The signal of a cable that is pulled by a force.
const TENSION: &str = "cable_imposed_tension_N";

/// A constant of a law table \[SI\].
fn truth_of(law: &Table, key: &str) -> f64 {
    registry::given(law).expect("a law").1[key]
}

/// A load cell that shows 0.3 N without load and a specimen that carries after 0.4 mm: as unknowns of the curve they come back with the constant.
#[test]
fn offsets_of_a_curve_are_found_with_the_constants() {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "6 mm", 12), &["E"], X, Y);
    let x: Vec<f64> = (0..=40).map(|k| 1.4e-4 * f64::from(k)).collect();
    let (slack, zero) = (4e-4, 0.3);
    let y = made(&truth, x.iter().map(|x| (x - slack).max(0.0)).collect()).y;
    let measured = Measured { y: y.iter().map(|y| y + zero).collect(), ..made(&truth, x) };
    let mut start = truth.clone();
    start.unknown[0].start *= 0.7;
    let offsets = vec![OffsetAxis::Slack, OffsetAxis::Zero];
    let c = found_with(vec![ObservedCurve { offsets, ..curve(&start, &measured) }], &exact());
    println!("{:?} {:?}", c.constants, c.curves[0].offsets);
    let [of_x, of_y] = &c.curves[0].offsets[..] else { panic!("two offsets") };
    // The kink at the slack is where the specimen begins; a curve of the scene is smooth there to the cubic of its steps
    assert!((c.constants[0].value / truth.unknown[0].start - 1.0).abs() < 1e-5, "{:?}", c.constants);
    assert!((of_x.value - slack).abs() < 1e-8 && (of_y.value - zero).abs() < 1e-5, "{of_x:?} {of_y:?}");
    let without = found(&start, &measured);
    assert!((without.constants[0].value / truth.unknown[0].start - 1.0).abs() > 0.01, "the offsets matter");
}

/// A tare a hundred times the force is the zero of the curve: the constant is determined as without it, with the same misfit. A zero that is 0 is no doubt.
#[test]
fn a_tare_changes_neither_the_misfit_nor_what_is_determined() {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "6 mm", 6), &["E"], X, Y);
    let made = made(&truth, (1..=60).map(|k| 1e-4 * f64::from(k)).collect());
    let largest = made.y.iter().fold(0.0, |m, y| larger(m, y.abs()));
    let mut start = truth.clone();
    start.unknown[0].start *= 0.7;
    let of = |tare: f64| {
        let mut random = common::Random::seed(5);
        let y = made.y.iter().map(|y| y + tare * largest + 0.02 * largest * random.normal()).collect();
        let measured = Measured { y, ..made.clone() };
        let offsets = vec![OffsetAxis::Zero];
        let settings = Settings::new(Weighting::Absolute);
        let c = found_with(vec![ObservedCurve { offsets, ..curve(&start, &measured) }], &settings);
        assert!(c.unidentified.is_empty(), "{tare}: {:?}", c.unidentified);
        let [low, high] = c.constants[0].interval.unwrap_or_else(|| panic!("{tare}: {:?}", c.constants));
        (c.constants[0].value, high - low, c.curves[0].rms_relative)
    };
    let (value, width, misfit) = of(0.0);
    for tare in [3.0, 100.0] {
        let (other, wide, rms) = of(tare);
        assert!((other / value - 1.0).abs() < 1e-3 && (wide / width - 1.0).abs() < 0.01, "{tare}: {other} {wide}");
        assert!((rms / misfit - 1.0).abs() < 1e-3, "{tare}: {rms} {misfit}");
    }
}

/// Three data points of thirty far off, as of a slipped grip: squares follow them, Huber's loss stays.
#[test]
fn a_robust_loss_ignores_what_is_far_off() {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "6 mm", 6), &["E"], X, Y);
    let mut measured = made(&truth, (1..=30).map(|k| 2e-4 * f64::from(k)).collect());
    let largest = measured.y.iter().fold(0.0, |m, y| larger(m, y.abs()));
    let mut random = common::Random::seed(8);
    measured.y.iter_mut().for_each(|y| *y += 0.002 * largest * random.normal());
    for k in [20, 24, 27] {
        measured.y[k] *= 0.6;
    }
    let off = |loss| {
        let c = found_with(vec![curve(&truth, &measured)], &Settings { loss, ..Settings::new(Weighting::Absolute) });
        (c.constants[0].value / truth.unknown[0].start - 1.0).abs()
    };
    let (squares, huber) = (off(Loss::Squares), off(Loss::Huber));
    println!("squares {squares:.2e}, Huber {huber:.2e}");
    assert!(squares > 0.02 && huber < 0.005, "{squares} {huber}");
}

/// Errors of a test by their kind, of a size relative to the largest force.
#[derive(Clone, Copy, Debug)]
enum Errors {
    Independent,
    /// ρ = 0.9 of neighbours
    Correlated,
    /// Independent ones, and 2 % of the travel without load
    Slack,
    /// Independent ones of 5 % of the force
    Proportional,
    /// Independent ones with Huber's loss
    Robust,
    /// Independent ones, every tenth of which is half of the largest force to either side, with Huber's loss
    Outliers,
}

/// E of every draw, with its 95 % interval. The bar is as coarse as it can be, and each draw is a whole search.
fn drawn(errors: Errors, draws: u64) -> Vec<Found> {
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "3 mm", 4), &["E"], X, Y);
    let slack = if matches!(errors, Errors::Slack) { 6e-5 } else { 0.0 };
    let x: Vec<f64> = (1..=60).map(|k| 5e-5 * f64::from(k)).collect();
    let y = made(&truth, x.iter().map(|x| (x - slack).max(0.0)).collect()).y;
    let clean = Measured { y, ..made(&truth, x) };
    let largest = clean.y.iter().fold(0.0, |m, y| larger(m, y.abs()));
    let one = |seed: u64| {
        let (mut random, mut before) = (common::Random::seed(1000 + seed), 0.0);
        (0..20).for_each(|_| _ = random.normal());
        let mut measured = clean.clone();
        for (k, y) in measured.y.iter_mut().enumerate() {
            let z = random.normal();
            before = match errors {
                Errors::Correlated if k > 0 => 0.9 * before + 0.19_f64.sqrt() * z,
                _ => z,
            };
            *y += match errors {
                Errors::Proportional => 0.05 * *y * before,
                _ => 0.01 * largest * before,
            };
            if matches!(errors, Errors::Outliers) && k % 10 == 5 {
                *y += 0.5 * largest * (random.unit() - 0.5).signum();
            }
        }
        let mut start = truth.clone();
        start.unknown[0].start *= 0.8;
        let offsets = if slack > 0.0 { vec![OffsetAxis::Slack] } else { vec![] };
        let loss = if matches!(errors, Errors::Robust | Errors::Outliers) { Loss::Huber } else { Loss::Squares };
        let settings = Settings { loss, ..Settings::new(Weighting::Absolute) };
        let c = found_with(vec![ObservedCurve { offsets, ..curve(&start, &measured) }], &settings);
        (c.constants[0].value, c.constants[0].widest().expect("determined"))
    };
    (0..draws).into_par_iter().map(one).collect()
}

/// Of E \[Pa\] over draws.
fn coverage(errors: Errors, all: &[Found]) -> Coverage {
    let truth = truth_of(&example_table("neo_hookean"), "E");
    let found = Coverage::of(truth, all);
    println!("{errors:?}: {found:?}");
    found
}

/// One data point of ten far off, which Huber's loss limits: the intervals are wider by the data points that are lost, in theory by a fifth. Those of weighted residuals, whose limits
/// looked like correlated errors, were several times as wide.
#[test]
fn data_points_far_off_leave_the_interval_of_a_robust_loss() {
    let off = drawn(Errors::Outliers, 50);
    assert!(coverage(Errors::Outliers, &off).holds_within(OF_NORMAL_ERRORS));
    let width = |all: &[Found]| all[..10].iter().map(|(_, [low, high])| high - low).sum::<f64>() / 10.0;
    let (clean, off) = (width(&drawn(Errors::Robust, 10)), width(&off));
    println!("interval with data points far off over the one without: {:.3}", off / clean);
    assert!((1.0..1.5).contains(&(off / clean)), "{off} {clean}");
}

/// Draws of errors in proportion to the force, of most of which the residuals show that they grow. The force is linear in E, and E of least squares has the variance Σ(y s)²/(Σy²)² of errors s = 0.05 y: the median
/// half-width of 50 draws, known to some per cent, is the t = 2.0 of its root. Intervals of errors of one size were 1.6, and held the truth in 89 of 100.
#[test]
fn intervals_know_of_errors_that_grow_with_the_force() {
    let all = drawn(Errors::Proportional, 50);
    assert!(coverage(Errors::Proportional, &all).holds());
    let law = example_table("neo_hookean");
    let truth = model(&bar(&law, "3 mm", 4), &["E"], X, Y);
    let exact = made(&truth, (1..=60).map(|k| 5e-5 * f64::from(k)).collect());
    let sum = |power: i32| exact.y.iter().map(|y| y.powi(power)).sum::<f64>();
    let deviation = truth.unknown[0].start * 0.05 * sum(4).sqrt() / sum(2);
    let half = median_half(&all) / deviation;
    println!("median half-width over the standard deviation: {half:.3}");
    assert!((1.8..2.3).contains(&half), "{half}");
    let grows = |seed: &u64| {
        let mut random = common::Random::seed(4000 + 7919 * seed);
        let y = exact.y.iter().map(|y| y * (1.0 + 0.05 * random.normal())).collect();
        let c = found_with(vec![curve(&truth, &Measured { y, ..exact.clone() })], &Settings::new(Weighting::Absolute));
        c.errors.grows()
    };
    // Nine of ten are told
    let told = (0..20).filter(grows).count();
    assert!(told >= 12, "{told} of 20 are said to grow");
}

/// Median half-width over the scatter of 50 draws of normal errors: 2.0, and three standard deviations of the scatter, 30 %.
const OF_NORMAL_ERRORS: [f64; 2] = [1.5, 2.9];

/// 50 draws for each kind of errors.
#[test]
fn intervals_hold_the_truth_in_95_of_100() {
    for errors in [Errors::Independent, Errors::Correlated, Errors::Slack] {
        let found = coverage(errors, &drawn(errors, 50));
        assert!(found.holds_within(OF_NORMAL_ERRORS), "{errors:?}: {found:?}");
    }
}

/// The published version: 95 ± 3 % of 1000 draws in every row.
#[test]
#[ignore = "takes minutes"]
fn intervals_hold_the_truth_in_95_of_100_of_many_draws() {
    for errors in [Errors::Independent, Errors::Correlated, Errors::Slack] {
        let found = coverage(errors, &drawn(errors, 1000));
        assert!((92.0..=98.0).contains(&found.covered), "{errors:?}: {found:?}");
    }
}

/// The committed study on its coarse meshes: mu = 100 kPa was pulled with 75 mm between the grips. The rows leave ±0.12 %, and a quarter
/// of the steps changes the interpolation by less: within 0.5 % where the distance is known, in the interval where it is not, and the
/// gauge length tens of percent off. The law file is a law.
#[test]
fn a_dumbbell_gives_its_stiffness_and_the_gauge_length_does_not() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/dumbbell-synthetic/study.toml");
    let changes = [("stage.0.dt".to_string(), Value::from("0.2 s"))];
    let study = Study::read(&file, &changes).unwrap_or_else(|e| panic!("{e}"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    for only in ["mesh-pull-coarse", "grips"] {
        let records = run_study(&study, folder.path(), Some(only));
        assert!(records.iter().all(CaseRecord::converged), "{only}");
    }
    let summary = report::write_report(folder.path()).unwrap_or_else(|e| panic!("{e}"));
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
    run_study(study, folder, Some("coarse"));
    let summary_of_use = report::write_report(folder).unwrap_or_else(|e| panic!("{e}"));
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
        let spec = durometer::scene::SceneSpec::from_text(&case.scene_file, &scene.to_string(), "")
            .unwrap_or_else(|e| panic!("{e}"));
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
