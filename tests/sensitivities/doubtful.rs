//! Which derivatives are called doubtful: those of a scene with a kink, and none that is zero but for rounding; which keys change nothing.

use durometer::math::statistics::larger;
use durometer::math::stopwatch::Spent;
use durometer::scene::{ParameterKey, RunOptions, Sensitivities, SensitivityRecorder, parse_scene};
use durometer::solve::Failure;

/// A block between two faces that alone hold it: the sum of all its reactions is zero, while those of the nodes are not, and one component of the quaternion
/// of the face that turns is.
const BETWEEN_TWO_FACES: &str = r#"
[mesh]
element = "tet4"
[mesh.grid]
kind = "box"
size = ["30 mm", "10 mm", "10 mm"]
divisions = [3, 2, 2]
[laws.rubber]
law = "neo_hookean_split"
mu = "60 kPa"
nu = 0.45
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
rotation = { axis = [1, 0, 0.2], about = ["30 mm", "5 mm", "5 mm"], angle = { kind = "ramp", from = "0 deg", to = "30 deg", end = "0.2 s" } }
translation = ["1 mm", "0 mm", { kind = "ramp", from = "0 mm", to = "2 mm", end = "0.2 s" }]
[[stage]]
integrator = "static"
duration = "0.2 s"
dt = "0.1 s"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "pose"
region = "xmax"
[[probe]]
kind = "reaction"
region = "body"
[numerics]
tolerance = 1e-12
"#;

fn key(path: &str) -> ParameterKey {
    path.parse().unwrap_or_else(|e| panic!("{e}"))
}

fn derivatives(paths: &[&str]) -> Sensitivities {
    let scene = parse_scene(BETWEEN_TWO_FACES).unwrap_or_else(|e| panic!("{e}"));
    let keys: Vec<ParameterKey> = paths.iter().map(|path| key(path)).collect();
    let recorder = SensitivityRecorder::new(&scene, &keys).unwrap_or_else(|e| panic!("{e}"));
    let run = scene.run_with(RunOptions { sensitivities: Some(recorder), ..RunOptions::default() });
    run.sensitivities.expect("the options ask for them")
}

/// Derivatives that are zero by balance of forces, or by the direction of an axis, are rounding, which has no relative error.
#[test]
fn a_derivative_that_is_rounding_is_not_doubtful() {
    let paths = [
        "constraint.prescribed.rotation.angle.to",
        "constraint.prescribed.rotation.axis.2",
        "constraint.prescribed.rotation.about.1",
        "constraint.prescribed.translation.2.to",
        "mesh.grid.size.0",
        "mesh.grid.size.2",
    ];
    let found = derivatives(&paths);
    assert!(found.doubtful().is_empty(), "{:?}", found.doubtful());
    // The error is as large as the derivative there, and both are far below the terms that cancel
    let c = found.columns.iter().position(|name| name == "body_reaction_x_N").expect("recorded");
    for (k, path) in paths.iter().enumerate() {
        let largest = found.rows.iter().map(|row| row[c][k].abs()).fold(0.0, larger);
        let terms = found.terms[c][k];
        assert!(largest < 1e-9 * terms && found.errors[c][k] < 1e-10 * terms, "{path}: {largest:e} of {terms:e}");
    }
}

/// A ramp that ends when the run does has a kink in the time of its end: what it moves is doubtful, the sum of the reactions is not.
#[test]
fn a_kink_is_doubtful() {
    let found = derivatives(&["constraint.prescribed.translation.2.end"]);
    let doubtful = found.doubtful();
    let (_, _, error) =
        doubtful.iter().find(|(column, ..)| *column == "xmax_z_m").expect("the end of a ramp is a kink");
    // The derivative is the mean of zero and that of the ramp, and the estimate is half of the jump
    assert!((error - 1.0).abs() < 1e-3, "{error}");
    assert!(doubtful.iter().all(|(column, ..)| !column.contains("reaction")), "{doubtful:?}");
}

/// The derivative of one column by one key in one row, with its error and the sum of the sizes of its terms, of a column of this size.
fn one(derivative: f64, error: f64, terms: f64, column_size: f64) -> Sensitivities {
    Sensitivities {
        columns: vec!["tip_x_m".into()],
        keys: vec![key("effect.gravity.density")],
        rows: vec![vec![vec![derivative]]],
        errors: vec![vec![error]],
        terms: vec![vec![terms]],
        column_sizes: vec![column_size],
        key_sizes: vec![1.0],
        stopped: None,
        factorisations: 0,
        solves: 0,
        spent: Spent::default(),
    }
}

/// An error of 2e-6 of a derivative that is one term, that is 1e-4 of its terms and that is 1e-2 of them; one that changes the column by less than rounding.
#[test]
fn errors_are_compared_with_terms_and_columns() {
    for (terms, column_size, is_doubtful) in [(1.0, 1.0, true), (1e4, 1.0, false), (1e2, 1.0, true), (1.0, 1e4, false)]
    {
        let found = one(1.0, 2e-6, terms, column_size);
        assert_eq!(found.doubtful().len(), usize::from(is_doubtful), "{terms:e} {column_size:e}");
    }
}

/// A key is idle where all derivatives by it are zero, but not where they end before the end of the run: it may matter later.
#[test]
fn no_key_is_idle_where_the_derivatives_end_early() {
    let mut found = one(0.0, 0.0, 0.0, 1.0);
    assert_eq!(found.idle().count(), 1);
    assert_eq!(one(1.0, 0.0, 1.0, 1.0).idle().count(), 0);
    found.stopped = Some((0.045, Failure::Landing));
    assert_eq!(found.idle().count(), 0);
}
