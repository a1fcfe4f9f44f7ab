//! Reduced models that move: equal to the full model where nothing is left out, with its balance of energy, its relaxation, and bars that hold for whole runs.

mod common;

use common::{Random, scene};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::reduction::inverse::{Target, reach};
use durometer::reduction::{FullState, ReducedModel, StepError, TransientTraining, Twin, errors_in_time};
use durometer::scene::control::{ControlError, Controller, Observation, Reply};
use durometer::scene::{RunOptions, Scene};
use durometer::solve::Status;
use durometer::system::State;
use std::path::Path;
use std::sync::OnceLock;

/// A bar of 40 mm that a cable bends and its weight swings; `parts` are its effects by rates.
fn bar(order: Order, law: &str, formulation: &str, drive: &str, stage: &str, parts: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
{law}
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "{formulation}"
[[effect]]
kind = "inertia"
region = "body"
density = "1100 kg/m^3"
mass = "consistent"
{parts}
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = [0, 1, 0]
acceleration = {{ kind = "controlled", initial = "0 m/s^2", range = ["-20 m/s^2", "20 m/s^2"] }}
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = {drive}
[[stage]]
integrator = {stage}
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"#
    );
    scene(block(6, 2, 2, 0.04, 0.01, 0.01, order), &text)
}

const SOFT: &str = "law = \"neo_hookean\"\nmu = \"60 kPa\"\nnu = 0.45";
const SPLIT: &str = "law = \"yeoh\"\nc = [\"30 kPa\", \"1 kPa\", \"0.1 kPa\"]\nnu = 0.49";
const BY_LENGTH: &str =
    "{ kind = \"length\", signal = { kind = \"controlled\", initial = \"0 mm\", range = [\"0 mm\", \"4 mm\"] } }";
const BY_TENSION: &str =
    "{ kind = \"tension\", signal = { kind = \"controlled\", initial = \"0 N\", range = [\"0 N\", \"0.4 N\"] } }";
/// Inputs are the acceleration, then the drive of the cable: the order of the scene.
const LENGTHS: [[f64; 2]; 2] = [[-20.0, 20.0], [0.0, 4e-3]];
const TENSIONS: [[f64; 2]; 2] = [[-20.0, 20.0], [0.0, 0.4]];

const MASS_DAMPING: &str = "[[effect]]\nkind = \"mass_damping\"\nregion = \"body\"\ndensity = \"1100 kg/m^3\"\nmass = \"lumped\"\nalpha = \"3 1/s\"\n";
const STIFFNESS_DAMPING: &str =
    "[[effect]]\nkind = \"stiffness_damping\"\nregion = \"body\"\nbeta = \"2 ms\"\nstiffness = \"initial\"\n";
const VISCOUS: &str = "[[effect]]\nkind = \"viscous_damping\"\nregion = \"body\"\neta = \"100 Pa s\"\n";
const RELAXING: &str = "[[effect]]\nkind = \"viscoelastic\"\nregion = \"body\"\nlaw = \"rubber\"\nmoduli = \"instantaneous\"\n\
    prony = [{ g = 0.2, tau = \"20 ms\" }, { g = 0.15, tau = \"0.2 s\" }]\n";

/// Sets the inputs point after point.
struct Way(std::vec::IntoIter<Vec<f64>>);

impl Controller for Way {
    fn step(&mut self, _: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        if let Some(point) = self.0.next() {
            signals.copy_from_slice(&point);
        }
        Ok(Reply::default())
    }
}

/// The states of the full model after each step.
fn states(scene: &Scene, points: &[Vec<f64>], names: &[String]) -> Vec<FullState> {
    let mut all: Vec<State> = vec![];
    let mut on_state = |state: &State| all.push(state.clone());
    let mut way = Way(points.to_vec().into_iter());
    let options = RunOptions { on_state: Some(&mut on_state), controller: Some(&mut way), ..RunOptions::default() };
    let run = scene.run_with(options);
    assert_eq!(run.status, Status::Converged);
    assert_eq!(run.totals.cuts, 0, "a step of another length");
    let columns: Vec<Vec<f64>> = names.iter().map(|n| run.column(n).expect("it is recorded")).collect();
    let state = |(k, state): (usize, &State)| FullState {
        inputs: points[k - 1].clone(),
        x: state.x.clone(),
        lambda: state.lambda.clone(),
        values: columns.iter().map(|c| c[k]).collect(),
    };
    all.iter().enumerate().skip(1).map(state).collect()
}

/// Inputs over time: polygons from rest with a corner every `each` steps, drawn evenly from the ranges.
fn signal(ranges: [[f64; 2]; 2], steps: usize, each: usize, random: &mut Random) -> Vec<Vec<f64>> {
    let mut corners = vec![vec![0.0, 0.0]];
    for _ in 0..=steps / each {
        corners.push(ranges.iter().map(|r| r[0] + random.unit() * (r[1] - r[0])).collect());
    }
    let at = |step: usize| {
        let (corner, share) = (step / each, (step % each) as f64 / each as f64);
        let between = corners[corner].iter().zip(&corners[corner + 1]);
        between.map(|(a, b)| a + share * (b - a)).collect()
    };
    (1..=steps).map(at).collect()
}

fn names() -> Vec<String> {
    ["xmax_z_m", "bending_angle_deg", "cable_tension_N", "cable_length_m"].map(String::from).to_vec()
}

fn stage(integrator: &str, steps: usize) -> String {
    format!("{integrator}\nduration = \"{} ms\"\ndt = \"5 ms\"\n[numerics]\ntolerance = 1e-10", 5 * steps)
}

const EULER: &str = "\"implicit_euler\"";
const BDF2: &str = "\"bdf2\"";
const ALPHA: &str = "{ kind = \"generalised_alpha\", rho = 0.8 }";
const MIDPOINT: &str = "{ kind = \"generalised_alpha\", rho = 1 }";

/// With as many modes as a run has states, and all points, the reduced trajectory is the full one: the displacements of every step are in the space, and with
/// them velocities and accelerations. The solver leaves 1e-10 of the forces, which bending turns into 1e-8 of the motion, and modes below 1e-7 are left out;
/// a run adds these up over its steps.
#[test]
fn all_modes_and_all_points_give_the_full_trajectory() {
    let all = [MASS_DAMPING, STIFFNESS_DAMPING, VISCOUS, RELAXING].concat();
    let mixed = [MASS_DAMPING, VISCOUS, RELAXING].concat();
    for (order, law, formulation, integrator, parts, drive, ranges) in [
        (Order::Linear, SOFT, "displacement", EULER, "", BY_TENSION, TENSIONS),
        (Order::Linear, SOFT, "displacement", BDF2, MASS_DAMPING, BY_LENGTH, LENGTHS),
        (Order::Linear, SOFT, "displacement", ALPHA, STIFFNESS_DAMPING, BY_TENSION, TENSIONS),
        (Order::Linear, SOFT, "displacement", EULER, VISCOUS, BY_LENGTH, LENGTHS),
        (Order::Linear, SOFT, "displacement", BDF2, RELAXING, BY_TENSION, TENSIONS),
        (Order::Linear, SOFT, "displacement", ALPHA, &all, BY_TENSION, TENSIONS),
        (Order::Quadratic, SPLIT, "mixed", EULER, &mixed, BY_LENGTH, LENGTHS),
        (Order::Quadratic, SPLIT, "mixed", BDF2, RELAXING, BY_TENSION, TENSIONS),
    ] {
        let steps = 14;
        let scene = bar(order, law, formulation, drive, &stage(integrator, steps), parts);
        let runs = vec![states(&scene, &signal(ranges, steps, 5, &mut Random(3)), &names())];
        let training = TransientTraining::new(&scene, &runs, &names()).unwrap_or_else(|e| panic!("{e}"));
        let model = training.model(steps, None, &[]).unwrap_or_else(|e| panic!("{e}"));
        let all = errors_in_time(&model, &runs).expect("a law of the library");
        let mut worst = vec![0.0_f64; names().len()];
        for row in &all[0] {
            row.iter().zip(&model.largest).zip(&mut worst).for_each(|(((e, _), size), w)| *w = w.max(e.abs() / size));
        }
        println!("{formulation} {integrator} {parts:.40?}: {worst:.1e?}");
        assert!(worst.iter().all(|w| *w < 1e-6), "{formulation} {integrator} {parts}: {worst:e?}");
    }
}
