//! Fast paths give what the slow ones do: cells side by side against one at a time, and directions from a factor that is kept
//! against a fresh factorisation in every iteration (`reuse_factor = false`).

use crate::common;
use crate::common::{ORDERS, Random, column, distorted_cube, law, shipped_scene};
use durometer::effect::{Elastic, Inertia, Lumping, Mass, ViscousDamping};
use durometer::material::{LAWS, Want};
use durometer::math::lanes::LANES;
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Checkpoint, Run, RunOptions};
use durometer::solve::Status;
use durometer::system::{At, Batch, BlockValues, Effect, Rates};

/// Asserts that blocks side by side are those evaluated one at a time: the same operations in the same order, so that no rounding separates them.
fn assert_lanes_are_blocks(name: &str, effect: &dyn Effect, at: &At) {
    let batched = effect.capabilities().batched.expect("it has batches");
    let n = effect.blocks().size(0);
    for first in (0..effect.blocks().len() / LANES * LANES).step_by(LANES) {
        let mut batch = Batch::new(n);
        batched.eval(at, first, Want::Tangent, &mut batch).expect("defined");
        for lane in 0..LANES {
            let mut single = BlockValues::new(n);
            effect.eval(at, first + lane, Want::Tangent, &mut single).expect("defined");
            assert_eq!(single.energy, batch.energy.0[lane], "{name}");
            assert!(single.r.iter().zip(&batch.r).all(|(one, four)| *one == four.0[lane]), "{name}");
            for (i, row) in single.k.chunks_exact(n).enumerate() {
                let side_by_side = batch.k[i * n..=i * n + i].iter().map(|k| k.0[lane]);
                assert!(row[..=i].iter().copied().eq(side_by_side), "{name}, row {i}");
            }
        }
    }
}

/// Every law on both elements, at states where F differs from I by some 10 %.
#[test]
fn cells_side_by_side() {
    for order in ORDERS {
        let mut random = Random::seed(7);
        let mesh = distorted_cube(2, order, 0.1, 7);
        let cells: Vec<u32> = (0..mesh.cell_count() as u32).collect();
        let x = random.vector(3 * mesh.points.len(), 0.02);
        let still = vec![0.0; x.len()];
        let at = At {
            t: 0.0,
            dt: f64::INFINITY,
            x: &x,
            v: &still,
            a: &still,
            old: &still,
            history: &[],
            inputs: &[],
            rates: Rates::default(),
        };
        for entry in LAWS.iter().filter(|e| e.keys.iter().any(|k| k.name == "E")) {
            let name = entry.info.name;
            let effect = Elastic::new("elastic".into(), &mesh, &cells, law(name, 1e5, 0.4));
            assert_lanes_are_blocks(name, &effect, &at);
        }
    }
}

/// Masses and viscous damping, as the laws above, at random velocities and accelerations.
#[test]
fn masses_and_dampers_side_by_side() {
    for order in ORDERS {
        let mut random = Random::seed(3);
        let mesh = distorted_cube(2, order, 0.1, 7);
        let cells: Vec<u32> = (0..mesh.cell_count() as u32).collect();
        let n = 3 * mesh.points.len();
        let [x, old, v, a] = [0.02, 0.02, 3.0, 50.0].map(|size| random.vector(n, size));
        let rates = Rates { cv: 200.0, ca: 4e4 };
        let at = At { t: 0.01, dt: 0.01, x: &x, v: &v, a: &a, old: &old, history: &[], inputs: &[], rates };
        let mass = |lumping| Inertia { mass: Mass::new(&mesh, &cells, 1000.0, lumping) };
        let effects: [(&str, Box<dyn Effect>); 4] = [
            ("consistent", Box::new(mass(Lumping::Consistent))),
            ("lumped", Box::new(mass(Lumping::Lumped))),
            ("uniform", Box::new(mass(Lumping::Uniform))),
            ("viscous", Box::new(ViscousDamping::new(&mesh, &cells, 300.0))),
        ];
        let start = At { dt: 0.0, old: &x, rates: Rates { cv: 0.0, ca: 4e4 }, ..at };
        for (name, effect) in &effects {
            assert_lanes_are_blocks(name, effect.as_ref(), &at);
            assert_lanes_are_blocks(name, effect.as_ref(), &start);
        }
    }
}

fn run(study: &str, changes: &[&str]) -> Run {
    let run = shipped_scene(study, changes).run();
    assert_eq!(run.status, Status::Converged, "{study} {changes:?}");
    run
}

const TIGHT: &str = "numerics.tolerance=1e-11";
const KEEP: &str = "numerics.reuse_threshold=0";
const FRESH: &str = "numerics.reuse_factor=false";

/// Study, and changes that make it short.
const SCENES: [(&str, &[&str]); 6] = [
    ("finger-convergence", &["stage.0.dt=\"0.1 s\"", "stage.0.duration=\"1 s\""]),
    ("finger-dynamics", &["stage.1.duration=\"0.1 s\""]),
    ("finger-gravity", &[]),
    ("antagonist", &["mesh.cells=1100", "stage.0.dt=\"0.1 s\""]),
    ("pay-for-use", &["stage.0.duration=\"0.1 s\""]),
    ("finger-mass-spring", &["stage.0.duration=\"0.2 s\""]),
];

/// At the tolerance 1e-8 the tension of the finger scatters by 3e-5 of itself, since block forces are that much larger than the
/// force at the cable. At 1e-11 it is 3e-8; 1e-6 leaves room for bodies that are softer in some direction.
#[test]
fn a_lagged_factor_leads_to_the_same_states() {
    for (study, changes) in SCENES {
        let fast = run(study, &[changes, &[TIGHT, KEEP]].concat());
        let slow = run(study, &[changes, &[TIGHT, FRESH]].concat());
        let size = slow.peak.x.iter().fold(0.0, |m, x| larger(m, x.abs()));
        let apart = fast.last.x.iter().zip(&slow.last.x).fold(0.0, |m, (a, b)| larger(m, (a - b).abs()));
        assert!(apart <= 1e-6 * size, "{study}: {apart:e} m of {size:e} m");
        for (a, b) in fast.last.lambda.iter().zip(&slow.last.lambda) {
            assert!((a - b).abs() <= 1e-6 * b.abs().max(1e-3), "{study}: λ = {a} and {b}");
        }
        assert_eq!(fast.totals.unstable, slow.totals.unstable, "{study}");
        let (few, all) = (fast.factorisations, slow.factorisations);
        assert!(few < all, "{study}: {few} of {all} factorisations");
    }
}

/// A strip of L/h = 100 bends under its weight by more than a fifth of its length: L in single precision, by which a lagged factor is applied,
/// leads to the states of fresh factors here too. At the tolerance of 1e-11 of the forces on its cells 1e-6 of the largest displacement
/// is the bound of the other bodies above.
#[test]
fn a_lagged_factor_leads_to_the_same_states_of_a_slender_body() {
    let run = |changes: &str| {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "40 MPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = {{ kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "1 s" }}
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[numerics]
tolerance = 1e-11
{changes}
"#
        );
        let run = common::run(&common::scene(block(100, 2, 1, 0.1, 0.002, 0.001, Order::Quadratic), &text));
        assert_eq!(run.status, Status::Converged, "{changes}");
        run
    };
    let (kept, fresh) = (run("reuse_threshold = 0"), run("reuse_factor = false"));
    let size = fresh.last.x.iter().fold(0.0, |m, x| larger(m, x.abs()));
    let apart = kept.last.x.iter().zip(&fresh.last.x).fold(0.0, |m, (a, b)| larger(m, (a - b).abs()));
    println!("{apart:e} m of {size:e} m, {} of {} factorisations", kept.factorisations, fresh.factorisations);
    assert!(size > 0.02, "it bends: {size} m");
    assert!(apart <= 1e-6 * size, "{apart:e} m of {size:e} m");
    assert_eq!(kept.totals.unstable, fresh.totals.unstable);
}

/// A rigid brick falls on a soft block on a floor, without friction, which corrections would take. The nodes of the brick have no place in
/// the mesh, and turn with a lagged factor like all others. States agree to the tolerance of the equilibrium, 1e-11 of the sum of all
/// forces, over the stiffness; 1e-6 of the largest displacement leaves room for the brick, which is free.
#[test]
fn a_lagged_factor_serves_with_contact_and_rigid_bodies() {
    let run = |changes: &str| {
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
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "lumped"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "200 Pa s"
[[rigid]]
name = "brick"
shape = {{ kind = "box", min = ["-1 mm", "-1 mm", "10.1 mm"], max = ["11 mm", "11 mm", "20.1 mm"] }}
density = "2000 kg/m^3"
gravity = {{ direction = [0.1, 0, -1], acceleration = "9.81 m/s^2" }}
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-0.01 mm"], normal = [0, 0, 1] }}
response = "barrier"
friction = 0.0
[[contact]]
name = "top"
region = "zmax"
obstacle = {{ kind = "rigid", body = "brick" }}
response = "barrier"
friction = 0.0
[[stage]]
integrator = "bdf2"
duration = "0.1 s"
dt = "5 ms"
[numerics]
max_iterations = 200
tolerance = 1e-11
{changes}
"#
        );
        let run = common::run(&common::scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text));
        assert_eq!(run.status, Status::Converged, "{changes}");
        run
    };
    let (kept, replaced, fresh) =
        (run("reuse_threshold = 0"), run("reuse_threshold = 1e9"), run("reuse_factor = false"));
    assert!(column(&fresh, "top_force_z_N").iter().any(|f| *f < -0.01), "they met");
    let size = fresh.last.x.iter().fold(0.0, |m, x| larger(m, x.abs()));
    for other in [&kept, &replaced] {
        let apart = other.last.x.iter().zip(&fresh.last.x).fold(0.0, |m, (a, b)| larger(m, (a - b).abs()));
        println!("{apart:e} m of {size:e} m, {} of {} factorisations", other.factorisations, fresh.factorisations);
        assert!(apart <= 1e-6 * size, "{apart:e} m of {size:e} m");
    }
    assert!(kept.factorisations < replaced.factorisations, "{} of {}", kept.factorisations, replaced.factorisations);
}

/// A finger pushes a rigid cube over a floor, with barriers and friction: corrections, in which each point solves for its own force, lead to
/// the states of Newton's method with a third of its iterations. Friction adds up over the path, each step to the tolerance of its forces,
/// 1e-8 of their sum, some 1e-5 of the force on the cube: the travel agrees to 1e-4 of itself. In the step to 0.76 s one of the points of the finger
/// leaves the cube, and there are two equilibria, with its left or its right corner pressed more: the comparison ends before.
#[test]
fn corrections_lead_to_the_states_of_newtons_method() {
    let short: &[&str] = &["mesh.cells=1770", "stage.0.duration=\"0.74 s\""];
    let (corrected, newton) = (run("finger-cube", short), run("finger-cube", &[short, &[FRESH]].concat()));
    let travel = |run: &Run| column(run, "cube_x_m").last().expect("rows") - column(run, "cube_x_m")[0];
    let (ours, other) = (travel(&corrected), travel(&newton));
    assert!(ours < -1e-3, "the cube is pushed: {ours} m");
    assert!((ours - other).abs() < 1e-4 * other.abs(), "{ours} and {other} m");
    let count = |run: &Run| run.totals.iterations as f64 / (run.rows.len() - 1) as f64;
    println!("{:.2} and {:.2} iterations a step", count(&corrected), count(&newton));
    assert!(count(&corrected) <= 3.0, "{} iterations a step", count(&corrected));
}

/// A saved state holds the matrix of the lagged factor.
#[test]
fn a_restart_keeps_the_factor() {
    let scene = shipped_scene("finger-convergence", &[KEEP, "stage.0.duration=\"0.4 s\""]);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("middle.state");
    let mut saved = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file).expect("writable");
    let options = RunOptions { save_at: vec![0.2], on_save: Some(&mut saved), ..RunOptions::default() };
    let whole = scene.run_with(options);
    let from = Checkpoint::read(&file, &scene).unwrap_or_else(|e| panic!("{e}"));
    let part = scene.run_with(RunOptions { restart: Some(from), ..RunOptions::default() });
    assert_eq!(whole.last, part.last);
    assert_eq!(whole.rows, part.rows);
}
