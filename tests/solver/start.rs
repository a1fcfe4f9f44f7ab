//! Initial states other than rest: their energies, and the regions that move.

use crate::common::{column, run, scene};
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
