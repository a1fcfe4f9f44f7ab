//! Code that closes the loop: at each point of the time grid it receives the recorded row and sets signals for the next point.

use super::ControlError;
use serde_json::Value;

/// Information for a controller before the first step.
#[derive(Clone, Copy, Debug)]
pub struct Opening<'a> {
    /// Names of the recorded columns; the first is `t_s`
    pub columns: &'a [String],
    /// Names of the signals that the controller may set: those of `kind = "controlled"`
    pub signals: &'a [String],
    /// Time of the first state \[s\]; not 0 after a restart
    pub t: f64,
    /// The last [`Reply::memory`], after a restart
    pub memory: &'a Value,
}

/// Information for a controller at a point of the time grid.
#[derive(Clone, Copy, Debug)]
pub struct Observation<'a> {
    /// The recorded row, in the order of [`Opening::columns`]
    pub row: &'a [f64],
    /// Time of the next point \[s\], at which the signals reach the values set now
    pub next: f64,
}

/// Values that were set at a point of the time grid.
#[derive(Clone, Copy, Debug)]
pub struct SignalSetting<'a> {
    /// Time of the point \[s\]
    pub t: f64,
    /// Time of the next point \[s\]
    pub next: f64,
    /// Values of the signals \[SI\], in the order of [`Opening::signals`]
    pub values: &'a [f64],
}

/// Further requests of a controller.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Reply {
    /// Whether to end the run here
    pub stop: bool,
    /// Whether to save a state from which the run can be restarted
    pub save: bool,
    /// Memory that is kept in saved states and returned after a restart; null keeps the last one
    pub memory: Value,
}

/// A controller in Rust. It drives the signals that the scene leaves to it, `kind = "controlled"`.
///
/// An integrating controller that holds a bending angle of 10° by shortening the cable:
///
/// ```
/// use durometer::scene::control::{ControlError, Controller, Observation, Opening, Reply};
/// use durometer::scene::{Body, Scene, RunOptions, read_scene};
/// use std::path::Path;
///
/// struct Integrating {
///     angle: usize,
/// }
///
/// impl Controller for Integrating {
///     fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
///         let angle = |name: &String| name == "bending_angle_deg";
///         self.angle = opening.columns.iter().position(angle).expect("the scene records it");
///         Ok(())
///     }
///
///     fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
///         // [m] per [°]: about the inverse sensitivity of the finger
///         signals[0] += 1e-4 * (10.0 - observation.row[self.angle]);
///         Ok(Reply::default())
///     }
/// }
///
/// let file = Path::new("../tests/cli/scene.toml");
/// let drive = r#"{ kind = "length", signal = { kind = "controlled", initial = "0 mm" } }"#;
/// let change = durometer::scene::overrides::parse(&format!("constraint.cable.drive={drive}"))?;
/// let longer = durometer::scene::overrides::parse("stage.0.duration=\"5 s\"")?;
/// let (spec, text) = read_scene(file, &[change, longer])?;
/// let body = Body::load(file, &spec.mesh, &mut |_| {})?;
/// let scene = Scene::build(file, spec, text, body.into())?;
/// let mut controller = Integrating { angle: 0 };
/// let options = RunOptions { controller: Some(&mut controller), ..RunOptions::default() };
/// let run = scene.run_with(options);
/// let angle = scene.columns().iter().position(|c| c == "bending_angle_deg").expect("recorded");
/// let last = run.rows.last().expect("a row")[angle];
/// assert!((last - 10.0).abs() < 0.5, "{last}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Controller {
    /// Called before the first step.
    fn begin(&mut self, _opening: &Opening) -> Result<(), ControlError> {
        Ok(())
    }

    /// Sets `signals` \[SI\], in the order of [`Opening::signals`], for the next point of the grid. They hold their present values, and keep them unless they
    /// are set.
    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError>;

    /// Name by which a run that continues from a checkpoint recognises the controller; `None` if it cannot be told from others.
    fn identity(&self) -> Option<String> {
        None
    }

    /// Whether the controller would have set these values at all points of the grid up to a checkpoint, starting from the initial values of the scene; `None`
    /// if only its identity can tell.
    fn would_set(&self, _initial: &[f64], _set: &[SignalSetting]) -> Option<bool> {
        None
    }

    /// Called after the last step, with the last row and the name of the status.
    fn end(&mut self, _row: &[f64], _status: &str) {}
}
