//! Free rigid bodies: their own motion, and rest under their weight.

use crate::common::{run, scene};
use crate::setup::{CUBE, last};
use durometer::effect::contact::shape::Shape;
use durometer::math::stopwatch::Spent;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::mesh::surface_file::Surface;
use durometer::scene::Scene;
use durometer::solve::Status;

/// Torque-free motion of a brick: Euler's equations I ω̇ + ω × Iω = 0, integrated by Runge & Kutta with a hundredth of the step.
/// BDF2 has an error of second order in Δt: it falls fourfold with half of it. Momentum and moment of momentum are linear and
/// bilinear in x and v; BDF2 keeps the first to the tolerance of the solver.
#[test]
fn a_free_brick_turns_by_eulers_equations() {
    let spin = Vec3::new(3.0, 0.4, 20.0);
    let size = Vec3::new(0.01, 0.02, 0.04);
    let inertia =
        Vec3::new(size.y.powi(2) + size.z.powi(2), size.x.powi(2) + size.z.powi(2), size.x.powi(2) + size.y.powi(2));
    let error = |dt: f64| {
        let text = format!(
            r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "brick"
shape = {{ kind = "box", min = ["0 mm", "0 mm", "100 mm"], max = ["10 mm", "20 mm", "140 mm"] }}
density = "1000 kg/m^3"
velocity = ["0.1 m/s", "0.2 m/s", "0 m/s"]
spin = ["{} rad/s", "{} rad/s", "{} rad/s"]
[[stage]]
integrator = "bdf2"
duration = "0.1 s"
dt = "{dt} s"
"#,
            spin.x, spin.y, spin.z
        );
        let scene = scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), &text);
        let run = run(&scene);
        assert_eq!(run.status, Status::Converged);
        let frame = &scene.rigids[0].frame;
        let p = frame.positions(&run.last.x);
        let a = frame.gradient(&p);
        assert!((a.tr_mul(&a) - Mat3::identity()).norm() < 1e-5, "not rigid: {a}");
        let moved = p[0] - frame.center - Vec3::new(0.01, 0.02, 0.0);
        assert!(moved.norm() < 1e-10, "the centre of mass is off by {moved:?}");
        // Attitude by the closed form's equations in the body frame
        let (mut omega, mut turn) = (spin, Mat3::identity());
        let h = dt / 100.0;
        let rate = |w: Vec3| {
            let l = inertia.component_mul(&w);
            (-w.cross(&l)).component_div(&inertia)
        };
        for _ in 0..(0.1 / h).round() as usize {
            let k1 = rate(omega);
            let k2 = rate(omega + 0.5 * h * k1);
            let k3 = rate(omega + 0.5 * h * k2);
            let k4 = rate(omega + h * k3);
            let middle = omega + 0.5 * h * k1;
            turn *= nalgebra::Rotation3::from_scaled_axis(h * middle).into_inner();
            omega += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        }
        (a - turn).norm()
    };
    let (coarse, fine) = (error(2e-3), error(1e-3));
    println!("attitude: {coarse} {fine}");
    assert!(coarse < 0.02 && (coarse / fine - 4.0).abs() < 0.8, "{coarse} {fine}");
}

/// A brick in the air, with these steps.
fn brick(start: &str, stage: &str) -> Scene {
    let text = format!(
        r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "brick"
shape = {{ kind = "box", min = ["-10 mm", "-20 mm", "0 mm"], max = ["10 mm", "20 mm", "10 mm"] }}
density = "1000 kg/m^3"
{start}
[[stage]]
integrator = "bdf2"
{stage}
"#
    );
    let mut mesh = block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear);
    mesh.points.iter_mut().for_each(|p| p.x += 0.1);
    scene(mesh, &text)
}

/// A brick that spins about its axis at 10 rad/s for a second: its rotation is recorded with its whole rotations, 573°. The error is of the size of (ω Δt)² = 4e-4, ω Δt being the rotation of a step of 2 ms.
#[test]
fn the_rotation_of_a_rigid_body_is_recorded() {
    let spin = "spin = [\"0 rad/s\", \"0 rad/s\", \"10 rad/s\"]";
    let run = run(&brick(spin, "duration = \"1 s\"\ndt = \"2 ms\""));
    assert_eq!(run.status, Status::Converged);
    let angle = last(&run, "brick_rotation_z_deg").to_radians();
    println!("turned by {angle}");
    assert!((angle / 10.0 - 1.0).abs() < 1e-3, "turned by {angle} in place of 10");
    for across in ["brick_rotation_x_deg", "brick_rotation_y_deg"] {
        assert!(last(&run, across).abs() < 1e-6, "{across}: {}", last(&run, across));
    }
}

/// Motions that the steps do not resolve are told by the columns that move, not by those that symmetry or an equilibrium holds, whose values are rounding: of a brick that
/// slides on a floor at constant speed none, of one that flies for two steps or turns by 1 rad in each the one that does.
#[test]
fn motions_of_rounding_are_not_unresolved() {
    let unresolved = |scene: &Scene| {
        let run = run(scene);
        assert_eq!(run.status, Status::Converged);
        let record = durometer::study::store::finished_run::record(scene, &run, Spent::default());
        record.probes.keys().filter(|probe| record.unresolved(probe, 0.0).is_some()).cloned().collect::<Vec<_>>()
    };
    let floor = "[[contact]]\nname = \"floor\"\nregion = \"brick\"\nobstacle = { kind = \"floor\", point = [\"0 m\", \"0 m\", \"0 m\"], normal = [0, 0, 1] }\nresponse = \"multiplier\"\nfriction = 0\n[[probe]]\nkind = \"energy\"";
    let weight = "gravity = { direction = [0, 0, -1], acceleration = \"9.81 m/s^2\" }";
    let moving = "velocity = [\"0.1 m/s\", \"0 m/s\", \"0 m/s\"]";
    for start in [weight.to_string(), format!("{weight}\n{moving}")] {
        let resolved = brick(&format!("{start}\n{floor}"), "duration = \"0.05 s\"\ndt = \"1 ms\"");
        assert_eq!(unresolved(&resolved), Vec::<String>::new(), "{start}");
    }
    let flies = brick(moving, "duration = \"2 ms\"\ndt = \"1 ms\"");
    assert_eq!(unresolved(&flies), ["brick_x_m"]);
    let spins = brick("spin = [\"0 rad/s\", \"0 rad/s\", \"100 rad/s\"]", "duration = \"0.1 s\"\ndt = \"10 ms\"");
    assert_eq!(unresolved(&spins), ["brick_rotation_z_deg"]);
}

/// A turned brick as a surface has the mass, the centre and the inertia of the box, R diag(I) Rᵀ, at any size; so has a pair of bricks whose principal axes
/// are no sides, by the parallel axis theorem (Steiner). Bounds: rounding of some dozen terms.
#[test]
fn a_surface_has_the_inertia_of_what_it_encloses() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.8, 1.9).into_inner();
    for size in [1e-4, 1e-2, 1.0, 1e3] {
        let (half, away) = (Vec3::new(0.5, 0.75, 2.0) * size, Vec3::new(3.0, -5.0, 2.0) * size);
        let brick = Shape::cuboid(half);
        let (mass, _, inertia) = brick.mass(1200.0);
        let exact = (half * 2.0).iter().product::<f64>() * 1200.0;
        let about = |i: usize| exact / 3.0 * (half.norm_squared() - half[i].powi(2));
        assert!((mass / exact - 1.0).abs() < 1e-14);
        assert!((inertia - Mat3::from_diagonal(&Vec3::new(about(0), about(1), about(2)))).norm() < 1e-13 * about(0));
        let mut surface = brick.triangles(0).expect("a box has sides");
        surface.points.iter_mut().for_each(|p| *p = turn * *p + away);
        let is_right = |surface: &Surface, mass: f64, center: Vec3, inertia: Mat3| {
            let found = Shape::surface(surface).expect("closed").mass(1200.0);
            assert!((found.0 / mass - 1.0).abs() < 1e-13, "{size}: {found:?}");
            assert!((found.1 - center).norm() < 1e-13 * away.norm(), "{size}: {found:?}");
            assert!((found.2 - inertia).norm() < 1e-12 * inertia.norm(), "{size}: {found:?}\n{inertia}");
        };
        is_right(&surface, exact, away, turn * inertia * turn.transpose());
        let (count, apart) = (surface.points.len() as u32, Vec3::new(0.0, 4.0, 3.0) * size);
        surface.points.extend(surface.points.clone().iter().map(|p| p + apart));
        surface.triangles.extend(surface.triangles.clone().iter().map(|t| t.map(|k| k + count)));
        let steiner = (Mat3::identity() * apart.norm_squared() - apart * apart.transpose()) * (exact / 2.0);
        is_right(&surface, 2.0 * exact, away + apart / 2.0, turn * inertia * turn.transpose() * 2.0 + steiner);
    }
}

/// A rigid brick falls on a soft block that lies on the floor and stays there: its weight, and that of the block, come out.
#[test]
fn a_brick_rests_on_a_soft_block() {
    let text = format!(
        r#"{CUBE}
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "200 Pa s"
[[rigid]]
name = "brick"
shape = {{ kind = "box", min = ["-1 mm", "-1 mm", "10.1 mm"], max = ["11 mm", "11 mm", "20.1 mm"] }}
density = "2000 kg/m^3"
gravity = {{ direction = [0, 0, -1], acceleration = "9.81 m/s^2" }}
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-0.01 mm"], normal = [0, 0, 1] }}
response = "barrier"
friction = 0.5
[[contact]]
name = "top"
region = "zmax"
obstacle = {{ kind = "rigid", body = "brick" }}
response = "barrier"
friction = 0.5
[[stage]]
integrator = "bdf2"
duration = "0.6 s"
dt = "5 ms"
"#
    );
    let scene = scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text);
    let run = run(&scene);
    println!("brick: {:?} {} it {} cuts", run.status, run.totals.iterations, run.totals.cuts);
    assert_eq!(run.status, Status::Converged);
    let brick = 2000.0 * 0.012 * 0.012 * 0.01 * 9.81;
    let block = 1000.0 * 1e-6 * 9.81;
    let (top, floor) = (last(&run, "top_force_z_N"), last(&run, "floor_force_z_N"));
    println!("{top} {brick} {floor} {block}");
    // What still moves after 0.6 s is damped by e^{-20}.
    assert!((top / -brick - 1.0).abs() < 1e-5, "{top} and {brick}");
    assert!((floor / (brick + block) - 1.0).abs() < 1e-5, "{floor} and {}", brick + block);
}

/// A rigid sphere, a rigid cube and a rigid cylinder on its end are themselves points of a contact: they come to rest on a floor with their weight.
#[test]
fn rigid_bodies_rest_on_a_floor() {
    for (shape, weight) in [
        (
            r#"{ kind = "sphere", center = ["0 mm", "0 mm", "5.1 mm"], radius = "5 mm" }"#,
            4.0 / 3.0 * std::f64::consts::PI * 125e-9,
        ),
        (r#"{ kind = "box", min = ["0 mm", "0 mm", "0.1 mm"], max = ["10 mm", "10 mm", "10.1 mm"] }"#, 1e-6),
        (
            r#"{ kind = "cylinder", from = ["0 mm", "0 mm", "0.1 mm"], to = ["0 mm", "0 mm", "12.1 mm"], radius = "5 mm" }"#,
            std::f64::consts::PI * 25e-6 * 12e-3,
        ),
    ] {
        let text = format!(
            r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "piece"
shape = {shape}
density = "1000 kg/m^3"
gravity = {{ direction = [0, 0, -1], acceleration = "9.81 m/s^2" }}
[[contact]]
name = "floor"
region = "piece"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "0 mm"], normal = [0, 0, 1] }}
response = "barrier"
friction = 0.5
modulus = "10 kPa"
[[stage]]
integrator = "implicit_euler"
duration = "0.5 s"
dt = "5 ms"
"#
        );
        let mut mesh = block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear);
        mesh.points.iter_mut().for_each(|p| p.x += 0.1);
        let run = run(&scene(mesh, &text));
        assert_eq!(run.status, Status::Converged, "{shape}");
        let force = last(&run, "floor_force_z_N");
        println!("{shape}: {force} {}", weight * 9810.0);
        assert!((force / (weight * 9810.0) - 1.0).abs() < 1e-5, "{shape}: {force}");
    }
}

/// A cube 1 µm above a floor begins deep in the reach of a barrier of 0.02 mm, whose force throws it 0.15 m up in the first step; the third one led to its mirror image, which has no strain. Whatever
/// ends the run, its last state is a rigid motion of the cube, and all of its rows are numbers.
#[test]
fn no_force_turns_a_rigid_body_inside_out() {
    let text = format!(
        r#"{}
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "cube"
shape = {{ kind = "box", min = ["90 mm", "-10 mm", "0.001 mm"], max = ["110 mm", "10 mm", "20.001 mm"] }}
density = "1000 kg/m^3"
gravity = {{ direction = [0, 0, -1], acceleration = "9.81 m/s^2" }}
[[contact]]
name = "floor"
region = "cube"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "0 mm"], normal = [0, 0, 1] }}
response = "barrier"
distance = "0.02 mm"
friction = 0
[[stage]]
integrator = {{ kind = "generalised_alpha", rho = 0.8 }}
duration = "20 ms"
dt = "1 ms"
"#,
        CUBE.replace("100 kPa", "1 MPa")
    );
    let scene = scene(block(1, 1, 1, 0.02, 0.02, 0.02, Order::Linear), &text);
    let run = run(&scene);
    println!("{}", run.status);
    let a = scene.rigids[0].frame.gradient_of(&run.last.x);
    // The strain is that of a force on a stiffness of 10⁴ E V
    assert!((a.determinant() - 1.0).abs() < 0.05, "{a}");
    assert!(run.rows.len() > 2 && run.rows.iter().flatten().all(|value| value.is_finite()));
}
