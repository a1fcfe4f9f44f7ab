//! Static contact: patch test, one force from all responses, no trace of dt, mirror images.

use crate::common::{ORDERS, largest, run, scene};
use crate::setup::{RESPONSES, last, soft_block};
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::disturb::distort;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::scene::Scene;
use durometer::solve::Status;

/// A distorted block of 20 × 20 × 10 mm.
fn slab(order: Order) -> TetMesh {
    let mut mesh = block(4, 4, 2, 0.02, 0.02, 0.01, order);
    distort(&mut mesh, 3, 0.15);
    mesh
}

/// The slab between planes of symmetry, pressed on a floor 0.2 mm below it by its top.
fn pressed(order: Order, response: &str, dt: &str, extra: &str) -> Scene {
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
region = "xmin"
components = "x"
[[constraint]]
kind = "fixed"
region = "ymin"
components = "y"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = {{ kind = "ramp", from = "0 mm", to = "-1.2 mm", end = "1 s" }}
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-0.2 mm"], normal = [0, 0, 1] }}
response = "{response}"
friction = 0
{extra}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{dt}"
[[probe]]
kind = "reaction"
region = "zmax"
"#
    );
    scene(slab(order), &text)
}

/// The patch test: under a uniform stress the points carry p ∫ N_a dA at the nodes, whatever the mesh. Penalty and multiplier
/// reach it to the tolerance of the equilibrium (1e-8 of the sum of all forces, some hundred times that of one point); the
/// barrier on tet10 has guards at the corners with a millionth of the area, which bend the facets a little. The area in contact is that of the face.
#[test]
fn a_uniform_pressure_comes_out_uniform() {
    for order in ORDERS {
        for response in RESPONSES {
            let scene = pressed(order, response, "0.25 s", "");
            let run = run(&scene);
            assert_eq!(run.status, Status::Converged, "{order:?} {response}");
            let facets = &scene.body.mesh.regions["zmin"].facets;
            let areas = scene.body.mesh.nodal_areas(facets);
            let mut forces = vec![0.0; 3 * scene.body.mesh.points.len()];
            scene.contacts[0].nodal(&run.last.x, None, &mut forces);
            let total: f64 = forces.chunks(3).map(|f| f[2]).sum();
            let area: f64 = areas.iter().map(|a| a.1).sum();
            let worst = areas.iter().map(|&(n, a)| (forces[3 * n as usize + 2] - total * a / area).abs());
            let worst = worst.fold(0.0, larger) / (total / areas.len() as f64);
            let bound = if order == Order::Quadratic && response == "barrier" { 2e-4 } else { 1e-6 };
            assert!(worst < bound, "{order:?} {response}: {worst:.1e}");
            let balance = last(&run, "floor_force_z_N") / -last(&run, "zmax_reaction_z_N") - 1.0;
            assert!(balance.abs() < 1e-6, "{order:?} {response}: {balance:.1e}");
            // All of the face presses; guards have no area.
            let share = last(&run, "floor_area_m2") / area;
            assert!((share - 1.0).abs() < 1e-9, "{order:?} {response}: {share}");
        }
    }
}

/// The gap of the barrier and the depth of the penalty go with `distance`: the distance of their forces from that of the
/// multiplier is halved with it, up to the next order, distance/height = 1e-3.
#[test]
fn the_responses_converge_to_one_force() {
    let force = |response: &str, extra: &str| {
        let run = run(&pressed(Order::Linear, response, "0.5 s", extra));
        assert_eq!(run.status, Status::Converged, "{response} {extra}");
        last(&run, "floor_force_z_N")
    };
    let exact = force("multiplier", "");
    assert!((force("multiplier", "modulus = \"1 MPa\"") / exact - 1.0).abs() < 1e-7);
    for response in ["barrier", "penalty"] {
        let error = |d: f64| force(response, &format!("distance = \"{d} mm\"")) - exact;
        let (coarse, fine) = (error(0.02), error(0.01));
        assert!((coarse / fine - 2.0).abs() < 0.02, "{response}: {coarse} {fine}");
    }
}

/// Statics does not see dt: the same force from 2 and from 8 steps, up to the tolerance of the equilibrium.
#[test]
fn static_contact_does_not_depend_on_dt() {
    for response in RESPONSES {
        let force = |dt| last(&run(&pressed(Order::Linear, response, dt, "")), "floor_force_z_N");
        let (coarse, fine) = (force("0.5 s"), force("0.125 s"));
        assert!((coarse / fine - 1.0).abs() < 1e-6, "{response}: {coarse} {fine}");
    }
}

/// A sphere pressed into the middle of a block whose mesh is its own mirror image under x ↔ y.
#[test]
fn a_symmetric_scene_has_a_symmetric_answer() {
    for response in RESPONSES {
        let scene = soft_block(
            1.0,
            &format!(
                r#"
[[contact]]
name = "ball"
region = "zmax"
obstacle = {{ kind = "sphere", center = ["10 mm", "10 mm", "20.1 mm"], radius = "10 mm" }}
motion = {{ direction = [0, 0, -1], displacement = {{ kind = "ramp", from = "0 mm", to = "1.5 mm", end = "1 s" }} }}
response = "{response}"
friction = 0.3
"#
            ),
        );
        let points = &scene.body.mesh.points;
        let run = run(&scene);
        assert_eq!(run.status, Status::Converged, "{response}");
        let (x, y, z) = (last(&run, "ball_force_x_N"), last(&run, "ball_force_y_N"), last(&run, "ball_force_z_N"));
        assert!(z < -0.1 && (x - y).abs() < 1e-6 * z.abs(), "{response}: {x} {y} {z}");
        let size = largest(&run.last.x[..3 * points.len()]);
        for (k, p) in points.iter().enumerate() {
            let mirror = Vec3::new(p.y, p.x, p.z);
            let m = points.iter().position(|q| (q - mirror).norm() < 1e-9).expect("the mesh is symmetric");
            let (u, v) = (&run.last.x[3 * k..3 * k + 3], &run.last.x[3 * m..3 * m + 3]);
            let away = largest(&[u[0] - v[1], u[1] - v[0], u[2] - v[2]]);
            assert!(away < 1e-6 * size, "{response}, node {k}: {away:.1e} of {size:.1e}");
        }
    }
}

/// The default distance is a hundredth of the size of the cells at the region, not of all: of a block whose layers are thinner towards the top, that
/// of the top layer, each hexahedron of which is six cells.
#[test]
fn the_default_distance_is_that_of_the_cells_in_contact() {
    let (width, height, layers) = (0.02, 0.01, 4);
    let mut mesh = block(4, 4, layers, width, width, height, Order::Linear);
    mesh.points.iter_mut().for_each(|p| p.z = height * (1.0 - (1.0 - p.z / height).powi(2)));
    let top = width * width * height / 16.0 / f64::from(layers as u32).powi(2);
    let size = (top / 6.0).cbrt();
    let force = |extra: &str| {
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
name = "plate"
region = "zmax"
obstacle = {{ kind = "box", min = ["-5 mm", "-5 mm", "10.1 mm"], max = ["25 mm", "25 mm", "20 mm"] }}
motion = {{ direction = [0, 0, -1], displacement = {{ kind = "ramp", from = "0 mm", to = "0.5 mm", end = "1 s" }} }}
response = "barrier"
friction = 0
{extra}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
"#
        );
        let run = run(&scene(mesh.clone(), &text));
        assert_eq!(run.status, Status::Converged, "{extra}");
        last(&run, "plate_force_z_N")
    };
    let of = |size: f64| force(&format!("distance = \"{} mm\"", 10.0 * size));
    let (default, at_region, at_mean) = (force(""), of(size), of(mesh.h()));
    println!("forces: {default} {at_region} {at_mean} N");
    assert!((default / at_region - 1.0).abs() < 1e-6, "{default} for {at_region}");
    assert!((default / at_mean - 1.0).abs() > 1e-3, "{default} and {at_mean}");
}

/// A plate on all of the top of a block, 20 × 20 mm: the area in contact is that of the top, also where the region goes round its edges, whose nodes have parts of
/// the sides too. These hardly turn. Bound: rounding of the sum.
#[test]
fn the_area_in_contact_leaves_out_what_does_not_face_the_obstacle() {
    for region in ["zmax", "skin"] {
        for response in RESPONSES {
            let plate = format!(
                r#"
[[contact]]
name = "plate"
region = "{region}"
obstacle = {{ kind = "box", min = ["-10 mm", "-10 mm", "10.1 mm"], max = ["30 mm", "30 mm", "20 mm"] }}
motion = {{ direction = [0, 0, -1], displacement = {{ kind = "ramp", from = "0 mm", to = "0.6 mm", end = "1 s" }} }}
response = "{response}"
friction = 0
"#
            );
            let run = run(&soft_block(1.0, &plate));
            assert_eq!(run.status, Status::Converged, "{region} {response}");
            let area = last(&run, "plate_area_m2");
            assert!((area / 4e-4 - 1.0).abs() < 1e-9, "{region} {response}: {area}");
        }
    }
}
