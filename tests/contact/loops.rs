//! Free motion, then one correction: what it has in common with the equilibrium of the monolithic loop, and what it loses.

use crate::common::{column, largest, run, scene};
use crate::setup::{CUBE, SLOPE, VISCOUS, cube_on_slope, last};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::Run;
use durometer::solve::Status;

const CORRECTED: &str = "integrator = \"implicit_euler_corrected\"";
const MONOLITHIC: &str = "integrator = \"implicit_euler\"";

/// A cube on a slope with one search for contact every step, and every four: gravity inclined by tan φ = ½ over a cube of 10 mm. It slides with
/// a = g (sin φ − μ cos φ); with μ = 0.51 it stays. Implicit Euler has the velocities of a constant
/// acceleration exactly, and so the second difference of the way.
#[test]
fn a_cube_slides_on_a_slope_or_sticks() {
    let (g, phi) = (9.81, SLOPE.atan());
    let mut ways = Vec::new();
    for steps in [1, 4] {
        let path = |mu: f64| {
            let stage = format!(
                "[[stage]]\n{CORRECTED}\nintegration_steps = {steps}\nduration = \"0.4 s\"\ndt = \"{} ms\"\n",
                5 * steps
            );
            let run = run(&cube_on_slope("multiplier", mu, 0.0, &format!("{VISCOUS}{stage}")));
            assert_eq!(run.status, Status::Converged, "μ = {mu}");
            assert!(run.contact_forces > std::time::Duration::ZERO, "the time of the sweeps is not counted");
            (column(&run, "body_x_m"), last(&run, "slope_force_z_N"))
        };
        let weight = 1e-6 * 1000.0 * g * phi.cos();
        for mu in [0.0, 0.3] {
            let (x, normal) = path(mu);
            let n = x.len() - 1;
            let (quarter, dt) = (n / 4, 0.4 / n as f64);
            let a = (x[n] - 2.0 * x[n - quarter] + x[n - 2 * quarter]) / (quarter as f64 * dt).powi(2);
            let wanted = g * (phi.sin() - mu * phi.cos());
            println!("μ = {mu}, {steps} steps: {a} {wanted}, {normal} {weight}");
            assert!((a / wanted - 1.0).abs() < 1e-8, "{steps} steps, μ = {mu}: {a} and {wanted}");
            assert!((normal / weight - 1.0).abs() < 1e-8, "{normal} and {weight}");
        }
        let (x, ..) = path(0.51);
        let stick_velocity = 1e-3 * 0.01 * 3f64.sqrt();
        let n = x.len() - 1;
        let speed = (x[n] - x[n / 2]) / 0.2;
        println!("{steps} steps: moves at {speed} m/s after {} m", x[n] - x[0]);
        assert!(speed.abs() < 1e-3 * stick_velocity, "{speed} and {stick_velocity}");
        ways.push(x[n] - x[0]);
    }
    // Sliding is that of the integration step, whenever obstacles were looked at.
    assert!((ways[0] / ways[1] - 1.0).abs() < 1e-8, "{ways:?}");
}

const FLOOR: &str = r#"{ kind = "floor", point = ["0 mm", "0 mm", "-1 mm"], normal = [0, 0, 1] }"#;
const BALL: &str = r#"{ kind = "sphere", center = ["33 mm", "5 mm", "-9 mm"], radius = "8 mm" }"#;

/// A bar of 40 mm that a cable bends on to an obstacle, and what presses it there.
fn pulled(obstacle: &str, stage: &str) -> Run {
    let text = format!(
        r#"{CUBE}
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "2000 Pa s"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = {{ kind = "length", signal = {{ kind = "ramp", from = "0 mm", to = "3 mm", end = "0.5 s" }} }}
[[contact]]
name = "floor"
region = "zmin"
obstacle = {obstacle}
response = "multiplier"
friction = 0
[[stage]]
{stage}
[numerics]
tolerance = 1e-11
"#
    );
    let run = run(&scene(block(8, 2, 2, 0.04, 0.01, 0.01, Order::Linear), &text));
    assert_eq!(run.status, Status::Converged, "{stage}");
    run
}

/// Where nothing moves any more, one correction is the equilibrium: cable and contact are solved for together. Viscosity has a time of
/// η/E = 20 ms, so that after 1.5 s e^{-75} of the motion is left; Newton's tolerance is 1e-11 of the sum of all forces, which is some
/// hundred times the force that acts.
#[test]
fn at_rest_a_correction_is_the_equilibrium() {
    let still = pulled(FLOOR, &format!("{MONOLITHIC}\nduration = \"2 s\"\ndt = \"10 ms\""));
    for steps in [1, 3] {
        let loose = pulled(
            FLOOR,
            &format!("{CORRECTED}\nintegration_steps = {steps}\nduration = \"2 s\"\ndt = \"{} ms\"", 10 * steps),
        );
        for name in ["floor_force_z_N", "cable_tension_N"] {
            let (one, other) = (last(&loose, name), last(&still, name));
            println!("{steps} {name}: {one} {other}");
            assert!(other > 0.05 && (one / other - 1.0).abs() < 1e-8, "{name}: {one} and {other}");
        }
        let gap = last(&loose, "floor_gap_m");
        assert!(gap.abs() < 1e-9, "{gap}");
    }
}

/// Until then it is off by an error of first order in both steps: that of one linearisation, and that of planes as old as the last
/// search. The monolithic loop with the same integration steps is the reference, so that the error of implicit Euler drops out.
#[test]
fn the_error_of_one_correction_is_of_first_order() {
    let way = |stage: &str, every: usize| {
        let run = pulled(BALL, stage);
        let force = column(&run, "floor_force_z_N");
        force.into_iter().step_by(every).collect::<Vec<f64>>()
    };
    let error = |ms: f64, steps: usize| {
        let corrected = format!("{CORRECTED}\nintegration_steps = {steps}\nduration = \"0.4 s\"\ndt = \"{ms} ms\"");
        let monolithic = format!("{MONOLITHIC}\nduration = \"0.4 s\"\ndt = \"{} ms\"", ms / steps as f64);
        let (one, other) = (way(&corrected, 1), way(&monolithic, steps));
        assert_eq!(one.len(), other.len());
        // The last quarter, well after the first touch
        let late = 3 * one.len() / 4;
        let differences: Vec<f64> = one[late..].iter().zip(&other[late..]).map(|(a, b)| a - b).collect();
        largest(&differences) / largest(&other)
    };
    let one = [8.0, 4.0, 2.0].map(|ms| error(ms, 1));
    println!("{one:?}");
    for pair in one.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((0.9..1.1).contains(&order), "order {order} of {one:?}");
    }
    // Both errors, with signs of their own: over a factor of 16 they fall by at least 8.
    let four = [16.0, 1.0].map(|ms| error(ms, 4));
    println!("{four:?}");
    assert!(four[0] > 8.0 * four[1], "{four:?}");
}

/// Without contact it is one linearised step, to the rounding of a sum in another order.
#[test]
fn without_contact_it_is_the_linearised_step() {
    let path = |integrator: &str| {
        let text = format!(
            r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "xmin"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"
[[stage]]
integrator = "{integrator}"
duration = "0.1 s"
dt = "5 ms"
[[probe]]
kind = "position"
region = "xmax"
"#
        );
        let run = run(&scene(block(3, 1, 1, 0.03, 0.01, 0.01, Order::Linear), &text));
        assert_eq!(run.status, Status::Converged);
        column(&run, "xmax_z_m")
    };
    let (one, other) = (path("implicit_euler_corrected"), path("implicit_euler_linearised"));
    assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-13), "{one:?} {other:?}");
    assert!((one[20] - one[0]).abs() > 1e-4, "it bends");
}
