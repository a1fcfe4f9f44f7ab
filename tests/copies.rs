//! Several bodies in one scene: where the copies are, what their regions hold, which body a cable is in.

mod common;

use common::column;
use durometer::math::tensor::Vec3;
use durometer::mesh::validate::min_det;
use durometer::scene::{Body, Scene, read_scene};
use durometer::solve::Status;
use std::sync::Arc;

fn load(text: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("writable");
    let (spec, text) = read_scene(&file, &[]).expect("a sound scene");
    let body = Body::load(&file, &spec.mesh, &mut |_| {}).expect("a sound mesh");
    Scene::build(&file, spec, text, Arc::new(body)).expect("a sound scene")
}

/// A bar along x three times: as it is, as its image in the plane x = 0, and turned about y and shifted, each held at its own end,
/// with a cable 2 mm from the next body in one of them.
fn scene(element: &str, extra: &str) -> Scene {
    load(&format!(
        r#"
[mesh]
grid = {{ box = {{ size = ["40 mm", "10 mm", "10 mm"], divisions = [6, 2, 2] }} }}
element = "{element}"
[[mesh.copy]]
name = "right"
shift = ["1 mm", "0 mm", "0 mm"]
[[mesh.copy]]
name = "left"
mirror = [1, 0, 0]
shift = ["-1 mm", "0 mm", "0 mm"]
[[mesh.copy]]
name = "top"
turn = {{ axis = [0, 1, 0], angle = "180 deg" }}
shift = ["41 mm", "0 mm", "21 mm"]
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
region = "xmax"
{extra}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "position"
region = "right.xmin"
[[probe]]
kind = "position"
region = "left.xmin"
[[probe]]
kind = "position"
region = "top.xmin"
"#
    ))
}

#[test]
fn regions_are_those_of_one_body_or_of_all() {
    for element in ["tet4", "tet10"] {
        let scene = scene(element, "");
        let mesh = &scene.body.mesh;
        assert!((0..mesh.cell_count()).all(|c| min_det(mesh, c) > 0.0));
        assert!((mesh.volume() / 12e-6 - 1.0).abs() < 1e-12);
        let middle = |region: &str| {
            let nodes = mesh.nodes_of(&mesh.regions[region]);
            nodes.iter().map(|&k| mesh.points[k as usize]).sum::<Vec3>() / nodes.len() as f64
        };
        for (region, x, z) in
            [("right.xmax", 41.0, 5.0), ("left.xmax", -41.0, 5.0), ("top.xmax", 1.0, 16.0), ("top.xmin", 41.0, 16.0)]
        {
            let away = middle(region) - Vec3::new(x, 5.0, z) * 1e-3;
            assert!(away.norm() < 1e-15, "{element} {region}: {away:?}");
        }
        assert_eq!(mesh.regions["xmax"].facets.len(), 3 * mesh.regions["top.xmax"].facets.len());
        assert_eq!(mesh.regions["body"].cells.len(), mesh.cell_count());
        assert_eq!(3 * mesh.regions["left.body"].cells.len(), mesh.cell_count());
        assert_eq!(mesh.regions["top.skin"].facets.len(), 2 * (2 * 2 * 2 + 4 * 6 * 2));
    }
}

/// A cable whose guides have balls that reach into the next body moves its own body only. Mirrored bodies move as mirror
/// images, up to the tolerance of the equilibrium (1e-8 of the forces, a few hundred times that of one node).
#[test]
fn a_cable_is_in_one_body() {
    let cable = |name: &str, sign: f64| {
        format!(
            r#"
[[constraint]]
kind = "cable"
name = "{name}"
guides = [["{} mm", "5 mm", "9 mm"], ["{} mm", "5 mm", "9 mm"]]
pull_point = ["{} mm", "5 mm", "9 mm"]
guide_radius = "4 mm"
drive = {{ length = {{ kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }} }}
"#,
            sign * 20.0,
            sign * 3.0,
            sign * 50.0
        )
    };
    let scene = scene("tet4", &(cable("first", 1.0) + &cable("second", -1.0)));
    let run = common::run(&scene);
    assert_eq!(run.status, Status::Converged);
    let change = |name: &str| {
        let c = column(&run, name);
        c.last().expect("a row") - c[0]
    };
    let lift = change("right.xmin_z_m");
    assert!(lift.abs() > 1e-4, "{lift}");
    assert!((change("left.xmin_z_m") / lift - 1.0).abs() < 1e-6);
    assert!((change("left.xmin_x_m") / change("right.xmin_x_m") + 1.0).abs() < 1e-6);
    // Nothing acts on the third body, whose nodes are within the balls.
    assert_eq!(change("top.xmin_z_m"), 0.0);
}
