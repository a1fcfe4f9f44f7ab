//! Initial states other than rest: their energies, and the regions that move.

use crate::common::{column, largest, run, scene};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::Scene;

/// A free cube of 10 mm with this start, and regions.
fn cube(regions: &str, start: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
{regions}
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
[start]
{start}
[[stage]]
integrator = "implicit_euler"
duration = "2e-6 s"
dt = "1e-6 s"
[[probe]]
kind = "energy"
"#
    );
    scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text)
}

/// ½ m v² of 1 g at 1 m/s from the first row on, without work.
#[test]
fn a_body_that_moves_has_its_energy_at_the_start() {
    let run = run(&cube("", "kind = \"moving\"\nvelocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"]"));
    let [kinetic, work] = ["kinetic_J", "work_J"].map(|name| column(&run, name));
    assert!(kinetic.iter().all(|k| (k / 5e-4 - 1.0).abs() < 1e-9), "{kinetic:?}");
    assert_eq!(work[0], 0.0);
}

/// The strain of a twist is in the first row. A step of 1 µs is 4e-3 of the fastest motion, of the square of which the energy changes.
#[test]
fn a_body_that_is_deformed_has_its_energy_at_the_start() {
    let run = run(&cube("", "kind = \"twisted\"\naxis = [0, 0, 1]\nangle = \"20 deg\""));
    let [elastic, kinetic, work] = ["elastic_J", "kinetic_J", "work_J"].map(|name| column(&run, name));
    assert!(elastic[0] > 0.0 && kinetic[0] == 0.0 && work[0] == 0.0, "{elastic:?} {kinetic:?} {work:?}");
    assert!((elastic[1] / elastic[0] - 1.0).abs() < 1e-3, "{elastic:?}");
}

/// A selector and the whole surface are regions of a start as those of the mesh are.
#[test]
fn a_start_takes_all_regions_of_the_scene() {
    let half = "[mesh.regions.half]\nkind = \"box\"\nmin = [\"4 mm\", \"-1 mm\", \"-1 mm\"]\nmax = [\"11 mm\", \"11 mm\", \"11 mm\"]";
    for (name, least) in [("half", 0.004), ("skin", -1.0), ("xmax", 0.009)] {
        let start = format!("kind = \"moving\"\nregion = \"{name}\"\nvelocity = [\"0 m/s\", \"1 m/s\", \"0 m/s\"]");
        let scene = cube(half, &start);
        let state = scene.start();
        for (k, p) in scene.body.mesh.points.iter().enumerate() {
            // The node in the middle is the only one that is not of the surface.
            let is_inside = p.iter().all(|x| (x - 0.005).abs() < 1e-9);
            let moves = p.x > least && !(name == "skin" && is_inside);
            assert_eq!(state.v[3 * k + 1], if moves { 1.0 } else { 0.0 }, "{name}: {p:?}");
        }
    }
}

/// A bar whose end is displaced from the start on, in a first stage that is dynamic.
fn displaced(displacement: &str, integrator: &str, steps: &str, more: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "bar"
[laws.rubber]
law = "linear"
E = "1 MPa"
nu = 0.0
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "consistent"
[[constraint]]
kind = "prescribed"
region = "xmin"
components = "x"
displacement = {displacement}
[[constraint]]
kind = "fixed"
region = "body"
components = "yz"
[[stage]]
integrator = {integrator}
{steps}
[[probe]]
kind = "position"
region = "xmin"
[[probe]]
kind = "reaction"
region = "xmin"
{more}"#
    );
    scene(block(4, 1, 1, 0.04, 0.01, 0.01, Order::Linear), &text)
}

/// The end is in its place before the first step, as with a `[start]` at rest, and not put there in it, which is an impact of u/Δt.
#[test]
fn prescribed_nodes_are_in_place_before_a_dynamic_stage() {
    let steps = "duration = \"2 ms\"\ndt = \"0.1 ms\"";
    let rest = "[start]\nkind = \"moving\"\nvelocity = [\"0 m/s\", \"0 m/s\", \"0 m/s\"]\n";
    let controlled = "{ kind = \"controlled\", initial = \"1 mm\" }";
    for integrator in ["\"bdf2\"", "\"implicit_euler\"", "{ kind = \"generalised_alpha\", rho = 0.8 }"] {
        let [with, without] = [rest, ""].map(|start| run(&displaced("\"1 mm\"", integrator, steps, start)));
        assert_eq!(with.rows, without.rows, "{integrator}");
        let decided = run(&displaced(controlled, integrator, steps, ""));
        for run in [&without, &decided] {
            assert!(column(run, "xmin_x_m").iter().all(|x| (x - 1e-3).abs() < 1e-15), "{integrator}");
        }
        assert_eq!(column(&decided, "xmin_reaction_x_N")[1..], column(&without, "xmin_reaction_x_N")[1..]);
    }
}

/// A base that moves by 1 mm · sin 2π 5 Hz t moves with its velocity from the start on, so that no rule rings about it: the largest reaction in 0.2 s
/// is 0.17 N with all steps and rules (by a bar of four cells in one dimension: 0.161 to 0.172 N). A base that is at rest before has 6 and 26 N by the
/// undamped ones.
#[test]
fn the_reaction_of_a_moving_base_has_a_limit() {
    let motion = "{ kind = \"sine\", amplitude = \"1 mm\", frequency = \"5 Hz\" }";
    for rule in [
        "kind = \"newmark\", beta = 0.25, gamma = 0.5",
        "kind = \"generalised_alpha\", rho = 1",
        "kind = \"generalised_alpha\", rho = 0.8",
    ] {
        for dt in ["0.5 ms", "0.25 ms"] {
            let steps = format!("duration = \"0.2 s\"\ndt = \"{dt}\"");
            let run = run(&displaced(motion, &format!("{{ {rule} }}"), &steps, ""));
            let most = largest(&column(&run, "xmin_reaction_x_N"));
            assert!((0.12..0.23).contains(&most), "{rule}, {dt}: {most} N");
        }
    }
}
