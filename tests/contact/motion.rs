//! Obstacles that turn and move.

use crate::common::{column, largest, run, try_scene};
use crate::setup::{RESPONSES, last, soft_block};
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::solve::Status;
use nalgebra::{Rotation3, Unit};

/// A box that turns about an axis outside of it and moves: X goes to P + R (X − P) + s e, to rounding.
#[test]
fn an_obstacle_turns_about_its_axis_and_moves() {
    let scene = soft_block(
        1.0,
        r#"
[[contact]]
name = "flap"
region = "zmax"
obstacle = { kind = "box", min = ["0 mm", "0 mm", "30 mm"], max = ["20 mm", "20 mm", "32 mm"] }
response = "barrier"
friction = 0
[contact.motion]
direction = [0, 0, 2]
displacement = { kind = "ramp", from = "0 mm", to = "3 mm", end = "1 s" }
turn = { axis = [1, 2, 0], about = ["-5 mm", "0 mm", "40 mm"], angle = { kind = "ramp", from = "0 deg", to = "-75 deg", end = "1 s" } }
"#,
    );
    let run = run(&scene);
    assert_eq!(run.status, Status::Converged);
    let obstacle = &scene.contacts[0].points().expect("points").obstacle;
    let frame = obstacle.body.as_ref().expect("it moves");
    let p = frame.positions(&run.last.x);
    let turn = Rotation3::from_axis_angle(&Unit::new_normalize(Vec3::new(1.0, 2.0, 0.0)), -75f64.to_radians());
    let about = Vec3::new(-0.005, 0.0, 0.04);
    assert!((frame.gradient(&p) - turn.matrix()).norm() < 1e-14);
    let wanted = about + turn * (frame.center - about) + Vec3::new(0.0, 0.0, 0.003);
    assert!((p[0] - wanted).norm() < 1e-16, "{} {wanted}", p[0]);
}

/// A roller is pressed into a block, then turns by a radian about its own axis. Without friction nothing changes; with friction all
/// points slide, and the surface that turns to +x below takes them along: the points are on a side that is inclined by φ at most, sin φ ≤ a/R, so that
/// the resultant of friction is μ times that of the pressure up to 1 − cos φ, with a = 4.5 mm and R = 10 mm 11 %, and more than cos φ of it.
#[test]
fn a_roller_takes_the_surface_along() {
    let roller = |response: &str, friction: f64, turn: &str| {
        let scene = soft_block(
            2.0,
            &format!(
                r#"
[[contact]]
name = "roller"
region = "zmax"
obstacle = {{ kind = "cylinder", from = ["10 mm", "-5 mm", "20.1 mm"], to = ["10 mm", "25 mm", "20.1 mm"], radius = "10 mm" }}
response = "{response}"
friction = {friction}
[contact.motion]
direction = [0, 0, -1]
displacement = {{ kind = "ramp", from = "0 mm", to = "1.1 mm", end = "1 s" }}
{turn}
"#
            ),
        );
        let run = run(&scene);
        assert_eq!(run.status, Status::Converged, "{response} {friction} {turn}");
        run
    };
    // Downward, the lower side of what turns about +y goes to −x.
    let turn = r#"turn = { axis = [0, 1, 0], about = ["10 mm", "0 mm", "20.1 mm"], angle = { kind = "ramp", from = "0 rad", to = "-1 rad", start = "1 s", end = "2 s" } }"#;
    for response in RESPONSES {
        let (still, turned) = (roller(response, 0.0, ""), roller(response, 0.0, turn));
        let apart = still.last.x.iter().zip(&turned.last.x).take(3 * 7 * 7 * 4).map(|(a, b)| (a - b).abs());
        let (apart, size) = (apart.fold(0.0, larger), largest(&still.last.x[..3 * 7 * 7 * 4]));
        assert!(apart < 1e-6 * size, "{response}: {apart} of {size}");
        let rough = roller(response, 0.3, turn);
        let tangential = last(&rough, "roller_force_x_N") - last(&rough, "roller_normal_x_N");
        let normal = (0..3)
            .map(|i| last(&rough, &format!("roller_normal_{}_N", ["x", "y", "z"][i])).powi(2))
            .sum::<f64>()
            .sqrt();
        let ratio = tangential / (0.3 * normal);
        println!("{response}: friction {tangential} N of {normal} N, {ratio} of the limit");
        assert!((0.89..1.12).contains(&ratio), "{response}: {ratio}");
    }
}

/// A lever of 50 mm turns by 90° past a soft post that is in its way from 38° on: in one step its nodes would go straight, and it would be 35 mm long in between.
/// In steps that are short enough it meets the post, and pushes it aside by 5 mm within 45°.
#[test]
fn a_lever_that_turns_does_not_pass_a_post() {
    let lever = |angle: &str, dt: &str| {
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
kind = "fixed"
region = "zmin"
[[contact]]
name = "lever"
region = "ymax"
obstacle = {{ kind = "box", min = ["-30 mm", "-29 mm", "10 mm"], max = ["-28 mm", "21 mm", "40 mm"] }}
motion = {{ turn = {{ axis = [0, 0, 1], about = ["-29 mm", "-29 mm", "0 mm"], angle = {angle} }} }}
response = "barrier"
friction = 0
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{dt}"
[numerics]
max_iterations = 200
"#
        );
        try_scene(block(2, 2, 4, 0.006, 0.006, 0.02, Order::Linear), &text)
    };
    let turned = r#"{ kind = "ramp", from = "0 deg", to = "-90 deg", end = "1 s" }"#;
    for (angle, dt, says) in [
        (turned, "1 s", "the angle changes by 90° within the step at t = 0.000000 s"),
        (turned, "0.25 s", "take a dt of 1.67e-1 s"),
        (r#""-90 deg""#, "0.1 s", "turns it by 90° from its given place at once"),
    ] {
        let told = lever(angle, dt).err().expect("refused");
        assert!(told.contains(says), "{told}");
    }
    let half = turned.replace("-90", "-45");
    let run = run(&lever(&half, "0.05 s").unwrap_or_else(|e| panic!("{e}")));
    assert_eq!(run.status, Status::Converged);
    let force = column(&run, "lever_force_y_N").into_iter().fold(0.0, |most: f64, f| larger(most, f.abs()));
    assert!(force > 0.01, "{force} N");
}
