//! Controls the full model of a beam with its reduced model: a cable makes the bending angle of the beam follow a sine.
//!
//! The reduced model is built from states without weight, but the plant has weight: at each point of the time grid the controller asks the
//! reduced model for the cable length that gives the target angle minus the last error of the plant.
//! Run with `cargo run --release --example control_with_a_reduced_model`.

use durometer::prelude::*;
use durometer::reduction::running::inverse::{Target, reach};
use durometer::reduction::{FullState, ReducedModel, Training, Twin};
use durometer::system::State;
use std::f64::consts::TAU;

/// A beam of 60 mm × 10 mm × 10 mm, clamped at one end, with a cable below its axis, for 40 points of time.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["60 mm", "10 mm", "10 mm"], divisions = [12, 2, 2] }
element = "tet10"

[laws.silicone]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "silicone"

[[constraint]]
kind = "fixed"
region = "xmin"

[[constraint]]
kind = "cable"
guides = [["5 mm", "5 mm", "2.5 mm"], ["30 mm", "5 mm", "2.5 mm"], ["55 mm", "5 mm", "2.5 mm"]]
pull_point = ["-10 mm", "5 mm", "2.5 mm"]
guide_radius = "2 mm"
drive = { kind = "length", signal = { kind = "controlled", initial = "0 mm", range = ["0 mm", "6 mm"] } }

[[stage]]
integrator = "static"
duration = "4 s"
dt = "0.1 s"

[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"#;

/// The weight, which the reduced model does not include.
const WEIGHT: &str = r#"
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = [0, 0, 1]
acceleration = "2 m/s^2"
"#;

/// Shortens the cable in equal steps.
struct Sweep {
    /// \[m\]
    step: f64,
}

impl Controller for Sweep {
    fn step(&mut self, _: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        signals[0] += self.step;
        Ok(Reply::default())
    }
}

/// Builds a reduced model with four modes from the states of a sweep.
fn reduced_model() -> Result<ReducedModel, Box<dyn std::error::Error>> {
    let scene = parse_scene(SCENE)?;
    let step = 6e-3 / 40.0;
    let mut states: Vec<State> = vec![];
    let mut keep = |state: &State| states.push(state.clone());
    let mut sweep = Sweep { step };
    let run =
        scene.run_with(RunOptions { on_state: Some(&mut keep), controller: Some(&mut sweep), ..RunOptions::default() });
    let angles = run.column("bending_angle_deg").ok_or("the scene records the angle")?;
    let full = |(k, state): (usize, State)| FullState {
        inputs: vec![step * k as f64],
        x: state.x,
        lambda: state.lambda,
        values: vec![angles[k]],
    };
    let full: Vec<FullState> = states.into_iter().enumerate().skip(1).map(full).collect();
    // Every other state is held back for the error bars
    let (known, held_back): (Vec<_>, Vec<_>) = full.into_iter().enumerate().partition(|(k, _)| k % 2 == 1);
    let states = |numbered: Vec<(usize, FullState)>| numbered.into_iter().map(|(_, s)| s).collect::<Vec<_>>();
    let (known, held_back, quantities) = (states(known), states(held_back), ["bending_angle_deg".to_string()]);
    Ok(Training::new(&scene, &known, &quantities)?.model(4, Some(1e-3), &held_back)?)
}

/// Returns the target angle \[°\].
fn wanted(time: f64) -> f64 {
    8.0 + 6.0 * (TAU * time / 4.0).sin()
}

struct Following {
    model: Twin,
    /// Index of the recorded angle
    angle: usize,
    /// Time between two points of the grid \[s\]
    dt: f64,
}

impl Controller for Following {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        let angle = opening.columns.iter().position(|name| name == "bending_angle_deg");
        self.angle = angle.expect("the scene records the angle");
        Ok(())
    }

    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        let off = observation.row[self.angle] - self.model.values()[0];
        let value = wanted(observation.row[0] + self.dt) - off;
        reach(&mut self.model, &[Target { quantity: 0, value, tolerance: 1e-3 }]).expect("an equilibrium");
        signals[0] = self.model.inputs()[0];
        Ok(Reply::default())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut controller = Following { model: Twin::new(reduced_model()?)?, angle: 0, dt: 0.1 };
    let plant = parse_scene(&format!("{SCENE}{WEIGHT}"))?;
    let run = plant.run_with(RunOptions { controller: Some(&mut controller), ..RunOptions::default() });
    assert_eq!(run.status, Status::Converged);
    let errors: Vec<f64> = run.rows.iter().map(|row| row[controller.angle] - wanted(row[0])).collect();
    for (row, error) in run.rows.iter().zip(&errors).step_by(5) {
        println!("t = {:3.1} s   angle {:6.3}°, {error:+.3}° from the wanted one", row[0], row[controller.angle]);
    }
    // The first point is at rest, and the second one shows the weight
    let largest = errors[2..].iter().fold(0.0_f64, |a, e| a.max(e.abs()));
    assert!(largest < 0.05, "the angle is {largest}° from the wanted one");
    Ok(())
}
