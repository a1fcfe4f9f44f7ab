//! Friction that holds: what sticks stays where it is, however long and in however many steps, and returns when the load is taken away.

use crate::common::{Random, column, run, scene};
use crate::setup::{RESPONSES, SLOPE, VISCOUS, cube_on_slope, last};
use durometer::effect::contact::friction::{ContactFriction, Coulomb};
use durometer::effect::contact::penalty::Penalty;
use durometer::effect::contact::placement::Obstacle;
use durometer::effect::contact::pressed::Pressed;
use durometer::effect::contact::shape::Shape;
use durometer::effect::contact::{Contact, SurfacePoint};
use durometer::material::Want;
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Checkpoint, Run, RunOptions, Scene, friction_at_limit};
use durometer::solve::Status;
use durometer::system::friction::HISTORY;
use durometer::system::{At, BlockValues, Effect, HistoryVariables, Rates};
use std::sync::Arc;

/// A point that moves at random over a floor, in steps of random lengths. Its force at the end of a step is that at the start of the next one, whatever
/// ε is there; |e| ≤ 1, across the normal, and 1 where the point slides; without contact e is zero.
#[test]
fn a_force_goes_on_from_step_to_step() {
    let mut random = Random::seed(7);
    let axes = Mat3::from_columns(&[Vec3::new(0.8, 0.0, -0.6), Vec3::y(), Vec3::new(0.6, 0.0, 0.8)]);
    let normal = axes * Vec3::z();
    let point = SurfacePoint::flat(Vec3::zeros(), vec![0], vec![1.0], 0.7);
    let obstacle = Obstacle { shape: Shape::floor(), origin: Vec3::zeros(), axes, body: None };
    let contact = Arc::new(Contact::new("floor".into(), vec![point], obstacle));
    let pressing = Pressed { contact, response: Penalty { stiffness: 5.0, rounding: 0.0 }, friction: None };
    let law = Coulomb { coefficient: 0.4, stick_velocity: 1.0, slip: 0.1, most: f64::INFINITY };
    let friction = ContactFriction { name: "floor_friction".into(), pressing: Arc::new(pressing), law };
    let force = |old: &[f64], x: &[f64], dt: f64, history: &[f64]| {
        let at = At { t: 0.0, dt, x, v: x, a: x, old, history, inputs: &[], rates: Rates::default() };
        let mut out = BlockValues::new(3);
        friction.eval(&at, 0, Want::Residual, &mut out).expect("a floor");
        let mut new = history.to_vec();
        friction.advance(&at, 0, &mut new).expect("a floor");
        (-Vec3::from_column_slice(&out.r), new)
    };
    let (mut stuck, mut slid, mut lifted) = (0, 0, 0);
    let (mut old, mut history) = ((normal * -0.2).as_slice().to_vec(), vec![0.0; HISTORY]);
    for _ in 0..300 {
        let lifts = random.unit() < 0.1;
        let dt = [0.02, 0.05, f64::INFINITY][(3.0 * random.unit()) as usize];
        let along = axes * Vec3::new(random.around(0.05), random.around(0.05), 0.0);
        let height = normal * if lifts { 0.1 } else { random.around(0.1) - 0.2 };
        let flat = Vec3::from_column_slice(&old);
        let x = (flat - normal * normal.dot(&flat) + along + height).as_slice().to_vec();
        let (f, new) = force(&old, &x, dt, &history);
        let e = Vec3::from_column_slice(&new);
        if lifts {
            assert!(f == Vec3::zeros() && e == Vec3::zeros(), "{f:?}, {e:?}");
            lifted += 1;
        } else {
            let limit = -0.4 * 0.7 * 5.0 * normal.dot(&height);
            assert!(f.norm() <= limit * (1.0 + 1e-12), "{f:?} of {limit}");
            assert!(e.norm() <= 1.0 + 1e-14 && e.dot(&normal).abs() < 1e-14, "{e:?}");
            assert!((f.norm() - limit * e.norm() * (2.0 - e.norm())).abs() < 1e-12 * limit, "{f:?} for {e:?}");
            for dt in [0.02, 0.05, f64::INFINITY] {
                let (next, held) = force(&x, &x, dt, &new);
                assert!((next - f).norm() < 1e-12 * limit && held.iter().zip(&new).all(|(a, b)| (a - b).abs() < 1e-14));
            }
            *if e.norm() < 1.0 - 1e-12 { &mut stuck } else { &mut slid } += 1;
        }
        (old, history) = (x, new);
    }
    assert!(stuck > 20 && slid > 20 && lifted > 20, "{stuck} {slid} {lifted}");
}

/// A block of 20 mm on a floor: pressed by 1 mm, then displaced along the floor as `of` says, in `steps` a second.
fn sheared(response: &str, of: &str, steps: u32, rest: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = {{ kind = "ramp", from = "0 mm", to = "-1 mm", end = "1 s" }}
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "x"
displacement = {{ kind = "points", of = {of}, unit = "mm" }}
[[constraint]]
kind = "fixed"
region = "zmax"
components = "y"
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-0.02 mm"], normal = [0, 0, 1] }}
response = "{response}"
friction = 0.5
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[[stage]]
integrator = "static"
duration = "2 s"
dt = "{} s"
{rest}
"#,
        1.0 / f64::from(steps)
    );
    scene(block(4, 4, 4, 0.02, 0.02, 0.02, Order::Linear), &text)
}

/// The force of a block that is sheared and then held neither decays while it is held, nor depends on the number of steps by more than the elastic slip,
/// a thousandth of a cell of 5 mm on 0.5 mm: 1 %. Held, nothing moves but by the tolerance of Newton's method.
#[test]
fn a_sheared_block_holds_its_force() {
    for response in RESPONSES {
        let force = |steps: u32| {
            let run = run(&sheared(response, "[[0, 0], [1, 0], [2, 0.5], [3, 0.5]]", steps, ""));
            assert_eq!(run.status, Status::Converged, "{response}, {steps} steps");
            let force = column(&run, "floor_force_x_N");
            let [sheared, held] = [force[10 + steps as usize], *force.last().expect("rows")];
            println!("{response}, {steps} steps: {sheared} N, then {held} N, {} iterations", run.totals.iterations);
            assert!((held / sheared - 1.0).abs() < 1e-6, "{response}, {steps} steps: {sheared} N, then {held} N");
            sheared
        };
        let [few, many] = [10, 200].map(force);
        assert!((few / many - 1.0).abs() < 0.01, "{response}: {few} N in few steps, {many} N in many");
    }
}

/// A block that is sheared by less than its friction holds and pushed back has the force again that it had before.
#[test]
fn what_sticks_returns() {
    for response in RESPONSES {
        let run = run(&sheared(response, "[[0, 0], [1, 0], [2, 0.05], [3, 0]]", 5, ""));
        assert_eq!(run.status, Status::Converged, "{response}");
        let force = column(&run, "floor_force_x_N");
        let [before, sheared, after] = [10, 15, 20].map(|k| force[k]);
        println!("{response}: {before} N, sheared {sheared} N, then {after} N");
        assert!((after - before).abs() < 1e-2 * (sheared - before).abs(), "{response}: {before} N, then {after} N");
    }
}

/// A cube on a slope that friction holds stays: in 2 s it does not move on by a hundredth of its elastic slip, with steps of 5 and of 1 ms, in both
/// loops. It has moved by less than ε and its own shear before.
#[test]
fn a_cube_on_a_slope_does_not_creep() {
    for (integrator, response) in
        [("bdf2", 0), ("bdf2", 1), ("bdf2", 2), ("implicit_euler", 2), ("implicit_euler_corrected", 2)]
    {
        for dt in [5.0, 1.0] {
            let response = RESPONSES[response];
            let stage = format!("[[stage]]\nintegrator = \"{integrator}\"\nduration = \"2 s\"\ndt = \"{dt} ms\"\n");
            let run = run(&cube_on_slope(response, 0.51, 0.001, &stage));
            assert_eq!(run.status, Status::Converged, "{integrator} {response}");
            let x = column(&run, "body_x_m");
            let epsilon = 1e-3 * 0.01 * 3f64.sqrt() * 1e-3 * dt;
            let (n, settled) = (x.len() - 1, x.len() / 2);
            let label = format!("{integrator}, {response}, {dt} ms");
            println!("{label}: {:e} m after 1 s, then {:e} m; ε = {epsilon:e} m", x[settled] - x[0], x[n] - x[settled]);
            assert!((x[n] - x[settled]).abs() < 0.01 * epsilon, "{label}: it creeps by {:e} m", x[n] - x[settled]);
        }
    }
}

/// However long the steps are, what sticks moves by the elastic slip of statics, a thousandth of a cell, and by its own shear.
#[test]
fn long_steps_do_not_let_a_cube_slide() {
    for dt in [0.005, 60.0, 600.0] {
        let stage =
            format!("[[stage]]\nintegrator = \"implicit_euler\"\nduration = \"{} s\"\ndt = \"{dt} s\"\n", 10.0 * dt);
        let run = run(&cube_on_slope("barrier", 0.6, 0.001, &stage));
        assert_eq!(run.status, Status::Converged, "{dt} s");
        let x = column(&run, "body_x_m");
        println!("{dt} s: {:e} m", x[x.len() - 1] - x[0]);
        assert!((x[x.len() - 1] - x[0]).abs() < 1e-4, "{dt} s: it moves by {:e} m", x[x.len() - 1] - x[0]);
    }
    let law = Coulomb { coefficient: 0.4, stick_velocity: 1.0, slip: 0.1, most: 0.1 };
    assert_eq!([0.01, 60.0, f64::INFINITY].map(|dt| law.threshold(dt)), [0.01, 0.1, 0.1]);
    assert_eq!(Coulomb { most: f64::INFINITY, ..law }.threshold(60.0), 60.0);
}

/// A dynamic stage begins with the force that friction held at the end of a static one: nothing moves by more than the elastic slip of a step.
#[test]
fn a_dynamic_stage_goes_on_from_a_static_one() {
    let inertia = "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1000 kg/m^3\"\nmass = \"lumped\"\n";
    for integrator in [
        "\"bdf2\"",
        "\"implicit_euler\"",
        "{ kind = \"generalised_alpha\", rho = 0.8 }",
        "{ kind = \"generalised_alpha\", rho = 0.0 }",
        "{ kind = \"newmark\", beta = 0.3025, gamma = 0.6 }",
    ] {
        for response in RESPONSES {
            let stage = format!("[[stage]]\nintegrator = {integrator}\nduration = \"20 ms\"\ndt = \"1 ms\"\n{inertia}");
            let run = run(&sheared(response, "[[0, 0], [1, 0], [2, 0.5], [4, 0.5]]", 5, &stage));
            assert_eq!(run.status, Status::Converged, "{integrator}, {response}");
            let force = &column(&run, "floor_force_x_N")[20..];
            let change = force.iter().fold(0.0, |m, f| larger(m, (f / force[0] - 1.0).abs()));
            println!("{integrator}, {response}: {} N, changes by {change:e}", force[0]);
            assert!(change < 1e-4, "{integrator}, {response}: the force changes by {change:e}");
        }
    }
}

/// With one iteration a step a viscous cube on a slope that friction holds comes to a force that stays: that of its weight along the slope, less what the
/// linearised onset of sliding, 2y for 2y − y² with y = 0.31, leaves out of it, 16 %.
#[test]
fn linearised_steps_come_to_rest() {
    let phi = SLOPE.atan();
    for response in ["penalty", "barrier"] {
        for dt in [1.0, 0.2] {
            let stage = "[[stage]]\nintegrator = \"implicit_euler_linearised\"\nduration = \"0.2 s\"";
            let run = run(&cube_on_slope(response, 0.8, 0.03, &format!("{VISCOUS}{stage}\ndt = \"{dt} ms\"\n")));
            let (force, weight) = (column(&run, "slope_force_x_N"), 9.81e-3 * phi.sin());
            let [before, end] = [force[force.len() - 2], force[force.len() - 1]];
            println!("{response}, {dt} ms: {before} N, then {end} N, for {weight} N");
            assert!((end / before - 1.0).abs() < 1e-3, "{response}, {dt} ms: {before} N, then {end} N");
            assert!((end / -weight - 1.0).abs() < 0.2, "{response}, {dt} ms: {end} N for {weight} N");
        }
    }
}

/// A block that is pressed and sheared on a box, which turns with its top about the normal: the force of friction turns along, and neither grows nor decays.
#[test]
fn what_sticks_turns_with_the_obstacle() {
    let angle = "{ kind = \"ramp\", from = \"0 deg\", to = \"720 deg\", start = \"2 s\", end = \"3 s\" }";
    let along = |of: &str| {
        let formula = format!("0.5*min(max(t-1,0),1)*{of}({}*max(t-2,0))", 4.0 * std::f64::consts::PI);
        format!("{{ kind = \"expression\", formula = \"{formula}\", unit = \"mm\" }}")
    };
    for response in ["penalty", "multiplier"] {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "prescribed"
region = "zmax"
rotation = {{ axis = [0, 0, 1], about = ["10 mm", "10 mm", "0 mm"], angle = {angle} }}
translation = [{}, {}, {{ kind = "ramp", from = "0 mm", to = "-1 mm", end = "1 s" }}]
[[contact]]
name = "table"
region = "zmin"
obstacle = {{ kind = "box", min = ["-30 mm", "-30 mm", "-20 mm"], max = ["50 mm", "50 mm", "-0.02 mm"] }}
motion = {{ turn = {{ axis = [0, 0, 1], about = ["10 mm", "10 mm", "0 mm"], angle = {angle} }} }}
response = "{response}"
friction = 0.5
[[stage]]
integrator = "static"
duration = "2 s"
dt = "0.1 s"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{} s"
[numerics]
max_iterations = 100
"#,
            along("cos"),
            along("sin"),
            1.0 / 72.0
        );
        let run = run(&scene(block(4, 4, 4, 0.02, 0.02, 0.02, Order::Linear), &text));
        assert_eq!(run.status, Status::Converged, "{response}");
        let [x, y] = ["table_force_x_N", "table_force_y_N"].map(|name| column(&run, name));
        let (start, end) = (x[20].hypot(y[20]), x[92].hypot(y[92]));
        let lag = (y[92].atan2(x[92]) - y[20].atan2(x[20])).to_degrees();
        println!("{response}: {start} N, after two turns {end} N, {lag}° behind");
        assert!((end / start - 1.0).abs() < 1e-4 && lag.abs() < 0.01, "{response}: {start} N, {end} N, {lag}°");
    }
}

/// The elastic slip is part of a saved state: a run that goes on while something sticks has the bits of the whole run.
#[test]
fn a_restart_has_the_bits_of_the_whole_run() {
    for response in RESPONSES {
        let scene = sheared(response, "[[0, 0], [1, 0], [2, 1.5], [3, 0]]", 5, "");
        let whole = run(&scene);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("middle.state");
        let mut save = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file).expect("writable");
        scene.run_with(RunOptions { save_at: vec![1.6], on_save: Some(&mut save), ..RunOptions::default() });
        let restart = Some(Checkpoint::read(&file, &scene).unwrap_or_else(|e| panic!("{e}")));
        let again = scene.run_with(RunOptions { restart, ..RunOptions::default() });
        let bits = |run: &Run| run.last.x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert!(again.status == Status::Converged && bits(&again) == bits(&whole), "{response}");
        assert!(last(&again, "floor_force_x_N") == last(&whole, "floor_force_x_N"), "{response}");
    }
}

/// A block with nothing but friction to hold it, under a push that reaches μ N at 1.6 s: in statics the run ends there, and the note says why. Before, friction has
/// more to give.
#[test]
fn friction_at_its_limit_is_noted() {
    let pushed = |duration: &str| {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "50 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "gravity"
name = "weight"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = {{ kind = "ramp", from = "0 m/s^2", to = "10 m/s^2", end = "1 s" }}
[[effect]]
kind = "gravity"
name = "push"
region = "body"
density = "1000 kg/m^3"
direction = [1, 0, 0]
acceleration = {{ kind = "ramp", from = "0 m/s^2", to = "5 m/s^2", start = "1 s", end = "2 s" }}
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["5 mm", "5 mm", "0 mm"], normal = [0, 0, 1] }}
response = "multiplier"
friction = 0.3
[[stage]]
integrator = "static"
duration = "{duration}"
dt = "0.13 s"
[numerics]
max_iterations = 100
"#
        );
        let scene = scene(block(2, 2, 1, 0.01, 0.01, 0.005, Order::Linear), &text);
        let run = run(&scene);
        (run.status == Status::Converged, friction_at_limit(&scene, &run.last))
    };
    assert_eq!(pushed("1.3 s"), (true, Vec::new()));
    let (converged, notes) = pushed("2 s");
    let [note] = &notes[..] else { panic!("{notes:?}") };
    assert!(!converged && note.starts_with("floor: at t = 1.") && note.contains("(9)"), "{note}");
}
