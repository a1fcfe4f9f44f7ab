//! The bar of these tests: its scenes, and its states at given inputs.

use crate::common;
use durometer::mesh::TetMesh;
use durometer::reduction::FullState;
use durometer::scene::control::{ControlError, Controller, Observation, Reply};
use durometer::scene::{Run, RunOptions, Scene};
use durometer::solve::Status;
use durometer::system::State;

pub const SOFT: &str = "law = \"neo_hookean\"\nmu = \"60 kPa\"\nnu = 0.45";
pub const BY_LENGTH: &str =
    "{ kind = \"length\", signal = { kind = \"controlled\", initial = \"0 mm\", range = [\"0 mm\", \"4 mm\"] } }";

/// The weight of a bar over its mass \[m/s²\].
#[derive(Clone, Copy)]
pub enum Weight {
    /// An input with this range
    Input([i32; 2]),
    Given(f64),
}

/// A bar of 40 mm along x that is held at one end and bent by its weight, and by a cable if it has one.
pub struct Bar<'a> {
    pub law: &'a str,
    pub formulation: &'a str,
    /// Tables of its effects by rates
    pub rates: &'a str,
    pub direction: &'a str,
    pub weight: Weight,
    /// Drive of the cable
    pub drive: Option<&'a str>,
    /// Integrator, duration and step
    pub stage: &'a str,
}

impl Default for Bar<'_> {
    fn default() -> Self {
        Self {
            law: SOFT,
            formulation: "displacement",
            rates: "",
            direction: "[0, 1, 0]",
            weight: Weight::Input([-20, 20]),
            drive: Some(BY_LENGTH),
            stage: "",
        }
    }
}

impl Bar<'_> {
    /// With a static step for each of so many points.
    pub fn of_points(&self, mesh: TetMesh, points: usize) -> Scene {
        let stage = format!("\"static\"\nduration = \"{points} s\"\ndt = \"1 s\"");
        Bar { stage: &stage, ..*self }.scene(mesh)
    }

    pub fn scene(&self, mesh: TetMesh) -> Scene {
        let Self { law, formulation, rates, direction, weight, drive, stage } = self;
        let acceleration = match weight {
            Weight::Input([least, most]) => {
                format!(r#"{{ kind = "controlled", initial = "0 m/s^2", range = ["{least} m/s^2", "{most} m/s^2"] }}"#)
            }
            Weight::Given(value) => format!("\"{value} m/s^2\""),
        };
        let cable = drive.map_or_else(String::new, |drive| {
            format!(
                r#"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = {drive}
"#
            )
        });
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
{rates}
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = {direction}
acceleration = {acceleration}
[[constraint]]
kind = "fixed"
region = "xmin"
{cable}
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
        common::scene(mesh, &text)
    }
}

/// Sets the inputs to one point after another.
struct InTurn<'a>(std::slice::Iter<'a, Vec<f64>>);

impl Controller for InTurn<'_> {
    fn step(&mut self, _: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        if let Some(point) = self.0.next() {
            signals.copy_from_slice(point);
        }
        Ok(Reply::default())
    }
}

/// The states of the full model after each step, at these points.
pub fn states(scene: &Scene, points: &[Vec<f64>], names: &[String]) -> Vec<FullState> {
    run(scene, points, names).1
}

/// The same with the run.
pub fn run(scene: &Scene, points: &[Vec<f64>], names: &[String]) -> (Run, Vec<FullState>) {
    let mut all: Vec<State> = vec![];
    let mut on_state = |state: &State| all.push(state.clone());
    let mut inputs = InTurn(points.iter());
    let options = RunOptions { on_state: Some(&mut on_state), controller: Some(&mut inputs), ..RunOptions::default() };
    let run = scene.run_with(options);
    assert_eq!(run.status, Status::Converged);
    let columns: Vec<Vec<f64>> = names.iter().map(|n| run.column(n).expect("it is recorded")).collect();
    let state = |(k, state): (usize, &State)| FullState {
        inputs: points[k - 1].clone(),
        x: state.x.clone(),
        lambda: state.lambda.clone(),
        values: columns.iter().map(|c| c[k]).collect(),
    };
    let states = all.iter().enumerate().skip(1).map(state).collect();
    (run, states)
}

/// A scene file: the bar on a grid, under the tension of a cable and its weight.
pub const SCENE: &str = r#"
[mesh.grid]
kind = "box"
size = ["40 mm", "10 mm", "10 mm"]
divisions = [8, 2, 2]
[laws.rubber]
law = "neo_hookean"
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
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = { kind = "tension", signal = "0 N" }
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "position"
region = "xmax"
"#;

/// The same without the cable.
pub fn without_cable() -> String {
    let (before, cable) = SCENE.split_once("[[constraint]]\nkind = \"cable\"\n").expect("a cable");
    format!("{before}{}", &cable[cable.find("[[effect]]").expect("a load")..])
}
