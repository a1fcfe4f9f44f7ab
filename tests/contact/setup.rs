//! What the scenes of contact share.

use crate::common::{column, scene};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Run, Scene};

pub const RESPONSES: [&str; 3] = ["barrier", "penalty", "multiplier"];

/// A moving block: law, mass, and all of its surface as `skin`.
pub const CUBE: &str = r#"
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
"#;

/// The last value of a column.
pub fn last(run: &Run, name: &str) -> f64 {
    *column(run, name).last().expect("a row")
}

/// tan φ of [`cube_on_slope`] \[–\]
pub const SLOPE: f64 = 0.5;

/// A cube of 10 mm on a slope, as gravity that is inclined, so many mm above it, with its place as `body_x_m`.
pub fn cube_on_slope(response: &str, friction: f64, gap: f64, rest: &str) -> Scene {
    let (sin, cos) = SLOPE.atan().sin_cos();
    let text = format!(
        r#"{CUBE}
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [{sin}, 0, {}]
acceleration = "9.81 m/s^2"
[[contact]]
name = "slope"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "{} mm"], normal = [0, 0, 1] }}
response = "{response}"
friction = {friction}
[[probe]]
kind = "position"
region = "body"
{rest}
"#,
        -cos, -gap
    );
    scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text)
}

/// A viscosity of the body.
pub const VISCOUS: &str = "[[effect]]\nkind = \"viscous_damping\"\nregion = \"body\"\neta = \"100 Pa s\"\n";

/// A soft block of 20 × 20 × 10 mm that is held at its bottom, with these contacts, in static steps of a quarter of a second.
pub fn soft_block(seconds: f64, contacts: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "zmin"
{contacts}
[[stage]]
integrator = "static"
duration = "{seconds} s"
dt = "0.25 s"
"#
    );
    scene(block(6, 6, 3, 0.02, 0.02, 0.01, Order::Linear), &text)
}
