//! Rigid spheres and cylinders on a plane with friction: they roll, slide, and go over from the one to the other.

use crate::common::{column, run, scene};
use crate::setup::{CUBE, RESPONSES};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::solve::Status;

/// Radius of the sphere and of the cylinder \[m\].
const RADIUS: f64 = 0.01;
const GRAVITY: f64 = 9.81;
/// Duration of a run and its step \[s\].
const TIMES: (f64, f64) = (0.2, 1e-3);

/// A body on a plane.
#[derive(Clone, Copy, Debug)]
enum Body {
    Sphere,
    /// Twice as long as it is wide
    Cylinder,
}

impl Body {
    /// Its shape with this middle \[mm\].
    fn shape(self, x: f64, z: f64) -> String {
        match self {
            Self::Sphere => {
                format!(r#"{{ kind = "sphere", center = ["{x} mm", "0 mm", "{z} mm"], radius = "10 mm" }}"#)
            }
            Self::Cylinder => format!(
                r#"{{ kind = "cylinder", from = ["{x} mm", "-20 mm", "{z} mm"], to = ["{x} mm", "20 mm", "{z} mm"], radius = "10 mm" }}"#
            ),
        }
    }

    /// Where a barrier of 0.02 mm carries its weight on its points, just within its distance \[mm\].
    fn gap(self) -> f64 {
        match self {
            Self::Sphere => 0.0196,
            Self::Cylinder => 0.0174,
        }
    }
}

/// Distances of a sphere along a plane at this slope, at every step \[m\].
fn path(response: &str, slope: f64, friction: f64, start: &str) -> Vec<f64> {
    path_of(Body::Sphere, response, slope, friction, start)
}

/// Distances along a plane at this slope, at every step \[m\].
fn path_of(body: Body, response: &str, slope: f64, friction: f64, start: &str) -> Vec<f64> {
    let (sin, cos) = slope.sin_cos();
    let height = 1e3 * RADIUS + if response == "barrier" { body.gap() } else { 0.0 };
    let text = format!(
        r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "ball"
shape = {}
density = "1000 kg/m^3"
gravity = {{ direction = [0, 0, -1], acceleration = "{GRAVITY} m/s^2" }}
{start}
[[contact]]
name = "plane"
region = "ball"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "0 mm"], normal = [{sin}, 0, {cos}] }}
response = "{response}"
friction = {friction}
distance = "0.02 mm"
stick_velocity = "0.1 mm/s"
[[stage]]
integrator = "bdf2"
duration = "{} s"
dt = "{} s"
[numerics]
max_iterations = 200
"#,
        body.shape(height * sin, height * cos),
        TIMES.0,
        TIMES.1
    );
    let run = run(&scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), &text));
    assert_eq!(run.status, Status::Converged, "{body:?}, {response}");
    let (x, z) = (column(&run, "ball_x_m"), column(&run, "ball_z_m"));
    x.iter().zip(&z).map(|(at_x, at_z)| (at_x - x[0]) * cos - (at_z - z[0]) * sin).collect()
}

/// On a slope of 20°: 5/7 g sin θ where friction is enough to roll, g (sin θ − μ cos θ) where μ is less than 2/7 tan θ. The step turns the sphere
/// by up to 0.05, whose square over six is 4e-4.
#[test]
fn a_sphere_rolls_or_slides_down_a_slope() {
    let slope = 20f64.to_radians();
    for response in RESPONSES {
        for (friction, acceleration) in [(0.5, 5.0 / 7.0 * slope.sin()), (0.05, slope.sin() - 0.05 * slope.cos())] {
            let s = path(response, slope, friction, "");
            let measured = 2.0 * s[s.len() - 1] / TIMES.0.powi(2);
            let expected = GRAVITY * acceleration;
            println!("{response}, friction {friction}: {measured} m/s², {expected}");
            assert!((measured / expected - 1.0).abs() < 5e-3, "{response}, {friction}: {measured} for {expected}");
        }
    }
}

/// A cylinder has 2/3 g sin θ where friction is enough to roll, g (sin θ − μ cos θ) where μ is less than 1/3 tan θ, with the errors of a sphere. A prism of
/// 24 sides would rest on one of them below 7.5°, and lose 4.5 % of its energy from each side to the next.
#[test]
fn a_cylinder_rolls_or_slides_down_a_slope() {
    for response in RESPONSES {
        for (degrees, friction) in [(2.0f64, 0.5), (5.0, 0.5), (15.0, 0.5), (15.0, 0.05)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let s = path_of(Body::Cylinder, response, degrees.to_radians(), friction, "");
            let measured = 2.0 * s[s.len() - 1] / TIMES.0.powi(2);
            let share = if friction < sin / cos / 3.0 { sin - friction * cos } else { 2.0 / 3.0 * sin };
            println!("{response}, {degrees}°, friction {friction}: {measured} m/s², {}", GRAVITY * share);
            assert!(
                (measured / (GRAVITY * share) - 1.0).abs() < 5e-3,
                "{response}, {degrees}°, {friction}: {measured}"
            );
        }
    }
}

/// A sphere that slides ends with 5/7 of its speed, one that spins with 2/7 of that of its surface: the moment of momentum about a point of the
/// plane is kept. The sliding ends after 2/7 v/μg = 0.05 s.
#[test]
fn a_sphere_that_slides_or_spins_comes_to_roll() {
    for response in RESPONSES {
        for (start, expected) in [
            ("velocity = [\"0.5 m/s\", \"0 m/s\", \"0 m/s\"]", 5.0 / 7.0 * 0.5),
            ("spin = [\"0 rad/s\", \"50 rad/s\", \"0 rad/s\"]", 2.0 / 7.0 * 50.0 * RADIUS),
        ] {
            let s = path(response, 0.0, 0.3, start);
            let measured = (s[s.len() - 1] - s[s.len() - 2]) / TIMES.1;
            println!("{response}, {start}: {measured} m/s, {expected}");
            assert!((measured / expected - 1.0).abs() < 5e-3, "{response}, {start}: {measured} for {expected}");
        }
    }
}

/// A ball that rolls in a groove of 90°, on two planes at ±45°, keeps its energy: at ω = √2 v/r both spots are at rest. Of a spot as it was turned at the start of a
/// step rω²Δt/2 is a speed across the planes, against which friction takes a third in 0.3 s.
#[test]
fn a_ball_that_rolls_in_a_groove_keeps_its_energy() {
    let sqrt2 = 2f64.sqrt();
    let plane = |name: &str, side: f64, response: &str| {
        format!(
            r#"
[[contact]]
name = "{name}"
region = "ball"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "0 mm"], normal = [0, {side}, 1] }}
response = "{response}"
friction = 0.3
distance = "0.02 mm"
"#
        )
    };
    for response in RESPONSES {
        for dt in [4.0, 2.0] {
            let height = sqrt2 * (1e3 * RADIUS + if response == "barrier" { Body::Sphere.gap() } else { 0.0 });
            let text = format!(
                r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "ball"
shape = {}
density = "1000 kg/m^3"
gravity = {{ direction = [0, 0, -1], acceleration = "{GRAVITY} m/s^2" }}
velocity = ["0.2 m/s", "0 m/s", "0 m/s"]
spin = ["0 rad/s", "{} rad/s", "0 rad/s"]
{}{}
[[stage]]
integrator = "bdf2"
duration = "0.3 s"
dt = "{dt} ms"
[[probe]]
kind = "energy"
[numerics]
max_iterations = 200
"#,
                Body::Sphere.shape(0.0, height),
                sqrt2 * 0.2 / RADIUS,
                plane("one", 1.0, response),
                plane("two", -1.0, response),
            );
            let run = run(&scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), &text));
            assert_eq!(run.status, Status::Converged, "{response}, {dt} ms");
            let kinetic = column(&run, "kinetic_J");
            let kept = kinetic[kinetic.len() - 1] / kinetic[0];
            println!("{response}, {dt} ms: {kept} of the energy");
            assert!((kept - 1.0).abs() < 0.02, "{response}, {dt} ms: {kept} of the energy");
        }
    }
}
