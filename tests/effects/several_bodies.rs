//! Several bodies in one scene: where the copies are, what their regions hold, which body a cable is in.

use crate::common;
use crate::common::column;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::boundary::boundary_facets;
use durometer::mesh::disturb::distort;
use durometer::mesh::overlap::overlap;
use durometer::mesh::parts::{image, parts, side_by_side};
use durometer::mesh::structured::block;
use durometer::mesh::validate::min_det;
use durometer::mesh::{Order, TetMesh};
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
grid = {{ kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = [6, 2, 2] }}
element = "{element}"
[[mesh.part]]
name = "right"
shift = ["1 mm", "0 mm", "0 mm"]
[[mesh.part]]
name = "left"
mirror = [1, 0, 0]
shift = ["-1 mm", "0 mm", "0 mm"]
[[mesh.part]]
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
drive = {{ kind = "length", signal = {{ kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }} }}
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

/// Three fingers a third of a turn apart, each with its cable, grip a rigid sphere alike: the forces are images of each other up to the tolerance
/// of the equilibrium (1e-8 of the sum of all forces, here some thousand times that of a contact).
#[test]
fn a_gripper_of_three_fingers() {
    let turned = |k: usize, v: Vec3| {
        let angle = std::f64::consts::TAU * k as f64 / 3.0;
        nalgebra::Rotation3::from_axis_angle(&Vec3::x_axis(), angle) * v
    };
    let mut text = "[mesh]\nbody = \"finger\"\ncells = 700\n".to_string();
    for k in 0..3 {
        let away = turned(k, Vec3::new(0.0, -10.0, 22.0));
        text += &format!(
            "[[mesh.part]]\nname = \"finger-{k}\"\nturn = {{ axis = [1, 0, 0], angle = \"{} deg\" }}\nshift = [\"0 mm\", \"{} mm\", \"{} mm\"]\n",
            120 * k,
            away.y,
            away.z
        );
    }
    text += r#"
[laws.rubber]
law = "neo_hookean"
E = "1 MPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "root"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[numerics]
max_iterations = 100
"#;
    for k in 0..3 {
        text += &format!(
            r#"
[[constraint]]
kind = "cable"
name = "cable-{k}"
path = "finger-{k}.cable"
guide_radius = "4 mm"
drive = {{ kind = "length", signal = {{ kind = "ramp", from = "0 mm", to = "12 mm", end = "1 s" }} }}
[[contact]]
name = "grip-{k}"
region = "finger-{k}.skin"
obstacle = {{ kind = "sphere", center = ["75 mm", "0 mm", "0 mm"], radius = "15 mm" }}
response = "barrier"
friction = 0
"#
        );
    }
    let run = common::run(&load(&text));
    assert_eq!(run.status, Status::Converged);
    let force = |k: usize| {
        let last = |c: &str| *column(&run, &format!("grip-{k}_force_{c}_N")).last().expect("a row");
        Vec3::new(last("x"), last("y"), last("z"))
    };
    assert!(force(0).z > 1.0, "{:?}", force(0));
    for k in 1..3 {
        let away = force(k) - turned(k, force(0));
        assert!(away.norm() < 1e-4 * force(0).norm(), "{k}: {away:?}");
    }
}

/// Volumes, outward normals and facets of cells survive a mirror and a turn; two images are two parts.
#[test]
fn images_are_sound() {
    for order in [Order::Linear, Order::Quadratic] {
        let mut mesh = block(2, 2, 2, 0.2, 0.1, 0.1, order);
        distort(&mut mesh, 5, 0.1);
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, 0.2, -0.7).into_inner();
        let mirror = Mat3::from_diagonal(&Vec3::new(-1.0, 1.0, 1.0));
        let away = Vec3::new(-0.3, 0.0, 0.0);
        let other = image(&mesh, &(turn * mirror), &away);
        let named = [("a".to_string(), mesh.clone()), ("b".to_string(), other)];
        let whole = side_by_side(&named).expect("two meshes");
        assert!((0..whole.cell_count()).all(|c| min_det(&whole, c) > 0.0));
        assert!((whole.volume() / mesh.volume() - 2.0).abs() < 1e-13);
        let flux = |m: &TetMesh| -> f64 {
            let at = |f: usize| m.facet(f)[..3].iter().map(|&i| m.points[i as usize]).sum::<Vec3>() / 3.0;
            (0..m.facet_count()).map(|f| 0.5 * m.facet_normal(f, [1.0 / 3.0; 2]).dot(&at(f))).sum()
        };
        // Gauss: ∮ x·n dA = 3 V on flat facets.
        assert!((flux(&whole) / (3.0 * whole.volume()) - 1.0).abs() < 1e-12);
        assert_eq!(boundary_facets(&whole).len(), 2 * boundary_facets(&mesh).len());
        let area = |r: &str| whole.region_area(&whole.regions[r].facets);
        assert!((area("b.xmin") - area("a.xmin")).abs() < 1e-15);
        assert!((area("xmin") - 2.0 * area("a.xmin")).abs() < 1e-15);
        let parts = parts(&whole);
        let half = mesh.cell_count();
        assert!(parts[..half].iter().all(|p| *p == 0));
        assert!(parts[half..].iter().all(|p| *p == mesh.points.len() as u32));
    }
}

/// Apart, in contact with whole faces, overlapping by a corner, one in the other, the same place twice, and two crossed bars
/// whose cells are longer than the bars are thick.
#[test]
fn contact_is_told_from_overlap() {
    let at = |mesh: &TetMesh, b: [f64; 3]| image(mesh, &Mat3::identity(), &Vec3::from(b));
    for order in [Order::Linear, Order::Quadratic] {
        let cube = block(2, 2, 2, 1.0, 1.0, 1.0, order);
        for (away, shared) in [
            ([1.5, 0.0, 0.0], false),
            ([1.0, 0.0, 0.0], false),
            ([1.0, 0.3, 0.2], false),
            ([0.9, 0.9, 0.9], true),
            ([0.0; 3], true),
            ([0.5, 0.0, 0.0], true),
            ([0.5, 0.0, 0.9], true),
            ([0.5, 0.0, 1.0], false),
        ] {
            assert_eq!(overlap(&cube, &at(&cube, away)).is_some(), shared, "{away:?}");
        }
        let small = at(&block(1, 1, 1, 0.1, 0.1, 0.1, order), [0.4, 0.4, 0.3]);
        assert!(overlap(&cube, &small).is_some() && overlap(&small, &cube).is_some());
        let bar = block(1, 1, 1, 1.0, 0.1, 0.1, order);
        let crossed = at(&block(1, 1, 1, 0.1, 1.0, 0.1, order), [0.7, -0.2, 0.05]);
        assert!(overlap(&bar, &crossed).is_some());
        assert!(overlap(&bar, &at(&crossed, [0.0, 0.0, 0.06])).is_none());
    }
}

/// A scene in a folder of its own with two files in different units and a grid.
fn from_files(second: &str) -> Result<Scene, durometer::scene::SceneError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let good = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad/good");
    for name in ["boxes.msh", "boxes-5.1.vtk"] {
        std::fs::copy(good.join(name), folder.path().join(name)).expect("writable");
    }
    let file = folder.path().join("scene.toml");
    let text = format!(
        r#"
[[mesh.part]]
name = "lower"
file = "boxes.msh"
unit = "cm"
[[mesh.part]]
name = "upper"
{second}
[[mesh.part]]
name = "base"
grid = {{ kind = "box", size = ["20 mm", "10 mm", "2 mm"], divisions = [4, 2, 1] }}
shift = ["0 mm", "0 mm", "-2 mm"]
[laws.soft]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[laws.hard]
law = "neo_hookean"
E = "10 MPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "lower.body"
law = "soft"
[[effect]]
kind = "elastic"
region = "upper.body"
law = "hard"
[[effect]]
kind = "elastic"
region = "base.body"
law = "hard"
[[constraint]]
kind = "fixed"
region = "lower.root"
[[constraint]]
kind = "fixed"
region = "upper.skin"
[[constraint]]
kind = "fixed"
region = "base.zmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#
    );
    std::fs::write(&file, &text).expect("writable");
    let (spec, text) = read_scene(&file, &[])?;
    let body = Body::load(&file, &spec.mesh, &mut |_| {})?;
    Scene::build(&file, spec, text, Arc::new(body))
}

#[test]
fn bodies_come_from_files_of_their_own() {
    let upper = "file = \"boxes-5.1.vtk\"\nunit = \"in\"\nturn = { axis = [0, 0, 1], angle = \"90 deg\" }\nshift = [\"0 mm\", \"0 mm\", \"12 mm\"]";
    let scene = from_files(upper).expect("a sound scene");
    let mesh = &scene.body.mesh;
    let volume = |region: &str| mesh.region_volume(&mesh.regions[region].cells);
    assert!((volume("lower.body") / 2e-6 - 1.0).abs() < 1e-12);
    assert!((volume("upper.body") / (2.0 * 0.0254f64.powi(3)) - 1.0).abs() < 1e-12);
    assert!((volume("base.body") / 0.4e-6 - 1.0).abs() < 1e-12);
    assert!((volume("body") - volume("lower.body") - volume("upper.body") - volume("base.body")).abs() < 1e-18);
    let highest = mesh.bounding_box().1;
    assert!((highest - Vec3::new(0.02, 0.0508, 0.012 + 0.0254)).norm() < 1e-12, "{highest}");
    assert_eq!(scene.body.source, "boxes.msh + boxes-5.1.vtk + grid");
    assert!(matches!(scene.run().status, Status::Converged));
}

#[test]
fn mistakes_name_the_part() {
    for (upper, says) in [
        ("file = \"boxes-5.1.vtk\"\nunit = \"in\"", "the parts \"lower\" and \"upper\" both fill ("),
        (
            "file = \"boxes.mhs\"\nunit = \"mm\"",
            "mesh.part upper: there is no file boxes.mhs; did you mean `boxes.msh`?",
        ),
        ("file = \"boxes.msh\"", "mesh.part upper: the file has no unit of length"),
        (
            "grid = { kind = \"box\", size = [\"1 mm\", \"1 mm\", \"1 mm\"], divisions = [1, 1, 1] }\nunit = \"mm\"",
            "mesh.part upper: `unit` has no effect next to `grid`",
        ),
        ("shift = [\"0 mm\", \"0 mm\", \"12 mm\"]", "neither `body` nor `file` nor `grid` is given"),
    ] {
        let error = from_files(upper).err().expect("refused").to_string();
        assert!(error.contains(says), "{upper}: {error}");
    }
}
