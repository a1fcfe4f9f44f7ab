//! Writes a controller in Rust: it shortens a cable until the body bends by 10°.
//!
//! The signal of the cable has `kind = "controlled"`; at each point of the time grid the controller sees what was
//! recorded and sets the signal for the next one. Run with `cargo run --release --example write_a_controller`.

use durometer::prelude::*;

/// A beam of 60 mm × 10 mm × 10 mm, clamped at one end, with a cable below its axis.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["60 mm", "10 mm", "10 mm"], divisions = [12, 2, 2] }

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
drive = { kind = "length", signal = { kind = "controlled", initial = "0 mm" } }

[[stage]]
integrator = "static"
duration = "4 s"
dt = "0.25 s"

[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"#;

/// An integral controller, u ← u + K (target − angle), which leaves no steady-state error.
struct Integrating {
    /// \[°\]
    target: f64,
    /// \[m/°\]
    gain: f64,
    /// Index of the recorded angle
    angle: usize,
}

impl Controller for Integrating {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        let angle = opening.columns.iter().position(|name| name == "bending_angle_deg");
        self.angle = angle.expect("the scene records the angle");
        Ok(())
    }

    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        signals[0] += self.gain * (self.target - observation.row[self.angle]);
        Ok(Reply::default())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = parse_scene(SCENE)?;
    let mut controller = Integrating { target: 10.0, gain: 1e-4, angle: 0 };
    let run = scene.run_with(RunOptions { controller: Some(&mut controller), ..RunOptions::default() });
    assert_eq!(run.status, Status::Converged);
    let angle = controller.angle;
    for row in run.rows.iter().step_by(4) {
        println!("t = {:4.2} s   angle {:6.3}°", row[0], row[angle]);
    }
    let last = run.rows.last().expect("at least one state")[angle];
    assert!((last - 10.0).abs() < 0.1, "the angle ends at {last}°");
    Ok(())
}
