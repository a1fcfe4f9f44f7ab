//! Triangle surfaces as obstacles, against the same shapes as primitives.

use crate::common::run;
use crate::setup::{RESPONSES, last, soft_block};
use durometer::effect::contact::shape::Shape;
use durometer::math::tensor::Vec3;
use durometer::mesh::surface_file::Surface;
use durometer::scene::{Scene, parse_scene};
use durometer::solve::Status;
use std::collections::BTreeMap;
use std::path::Path;

/// Force of a surface or primitive that is pressed 1 mm into the block.
fn force(response: &str, obstacle: &str) -> f64 {
    let scene = soft_block(
        1.0,
        &format!(
            r#"
[[contact]]
name = "stamp"
region = "zmax"
obstacle = {obstacle}
motion = {{ direction = [0, 0, -1], displacement = {{ kind = "ramp", from = "0 mm", to = "1.1 mm", end = "1 s" }} }}
response = "{response}"
friction = 0.2
"#
        ),
    );
    let run = run(&scene);
    assert_eq!(run.status, Status::Converged, "{response} {obstacle}");
    last(&run, "stamp_force_z_N")
}

/// In Wavefront's format, in millimetres; the vertices of its triangles as they come.
pub fn write(file: &Path, surface: &Surface, at: Vec3) {
    let vertices =
        surface.points.iter().map(|p| (p * 1e3 + at).iter().map(f64::to_string).collect::<Vec<_>>().join(" "));
    let faces = surface.triangles.iter().map(|t| t.map(|k| (k + 1).to_string()).join(" "));
    let lines = vertices.map(|v| format!("v {v}\n")).chain(faces.map(|f| format!("f {f}\n")));
    std::fs::write(file, lines.collect::<String>()).expect("a temporary file");
}

/// The same surface with each triangle split into four.
fn split(surface: &Surface) -> Surface {
    let mut fine = Surface { points: surface.points.clone(), triangles: vec![] };
    let mut middles = BTreeMap::new();
    for &[a, b, c] in &surface.triangles {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                fine.points.push((surface.points[i as usize] + surface.points[j as usize]) / 2.0);
                fine.points.len() as u32 - 1
            })
        });
        fine.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    fine
}

/// Flat sides have no sagitta: the box of many triangles is the box, also where a point is near several of them. The barrier counts a point twice within its
/// distance of a convex edge, in which no node lies here.
#[test]
fn a_box_of_triangles_is_a_box() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("box.obj");
    let sides = Shape::cuboid(Vec3::new(0.0061, 0.0043, 0.004)).triangles(0).expect("it has sides");
    write(&file, &split(&split(&split(&sides))), Vec3::new(9.7, 10.4, 14.1));
    let surface = format!(r#"{{ kind = "surface", file = "{}", unit = "mm" }}"#, file.display());
    let primitive =
        r#"{ kind = "box", min = ["3.6 mm", "6.1 mm", "10.1 mm"], max = ["15.8 mm", "14.7 mm", "18.1 mm"] }"#;
    for response in RESPONSES {
        let (a, b) = (force(response, &surface), force(response, primitive));
        println!("{response}: {a} N and {b} N");
        assert!(b < -0.1 && (a / b - 1.0).abs() < 1e-6, "{response}: {a} and {b}");
    }
}

/// An inscribed polyhedron is lower than its sphere by the sagitta, R (1 − cos(π/n)): the error of the force falls fourfold from n to 2n parts.
/// Nodes see facets or edges by turns, so the ratio is kept within 2 and 8.
#[test]
fn a_sphere_of_triangles_converges_to_the_sphere() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let exact =
        force("multiplier", r#"{ kind = "sphere", center = ["9.7 mm", "10.4 mm", "20.1 mm"], radius = "10 mm" }"#);
    let error = |parts: u32| {
        let file = folder.path().join(format!("{parts}.obj"));
        let shape = Shape::sphere(0.01).triangles(parts).expect("it has a side");
        write(&file, &shape, Vec3::new(9.7, 10.4, 20.1));
        let surface = format!(r#"{{ kind = "surface", file = "{}", unit = "mm" }}"#, file.display());
        force("multiplier", &surface) / exact - 1.0
    };
    let (coarse, fine) = (error(24), error(48));
    println!("24 and 48 parts: {coarse} {fine}");
    assert!(coarse < 0.0 && fine < 0.0 && (2.0..8.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// A pyramid of `sides` faces whose tip points down.
fn pyramid(sides: u32, slope: f64) -> Surface {
    let (radius, top) = (7.0, 9.0);
    let around = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(sides) + 0.1;
    let rim = (0..sides).map(|k| Vec3::new(radius * around(k).cos(), radius * around(k).sin(), slope * radius));
    let points = std::iter::once(Vec3::zeros()).chain(rim).chain([Vec3::new(0.0, 0.0, top)]);
    let next = |k: u32| (k + 1) % sides + 1;
    let triangles = (0..sides).flat_map(|k| [[0, next(k), k + 1], [sides + 1, k + 1, next(k)]]);
    Surface { points: points.map(|p| p * 1e-3).collect(), triangles: triangles.collect() }
}

/// A block with a node in the middle of its top, and the surface in this file that comes down on it by 1 mm.
fn under(file: &Path) -> Scene {
    let text = format!(
        r#"
[mesh]
grid = {{ kind = "box", size = ["20 mm", "20 mm", "10 mm"], divisions = [4, 4, 4] }}
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "zmin"
[[contact]]
name = "stamp"
region = "zmax"
obstacle = {{ kind = "surface", file = "{}", unit = "mm" }}
motion = {{ direction = [0, 0, -1], displacement = {{ kind = "ramp", from = "0 mm", to = "1.1 mm", end = "1 s" }} }}
response = "penalty"
friction = 0.3
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
"#,
        file.display()
    );
    parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// A node under a corner, next to it, under a side, and under a face, with friction by which it sticks: the penalty converges
/// wherever the node is, and under a corner without a cut step.
#[test]
fn a_node_may_be_under_a_corner_a_side_or_a_face() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (sides, slope) in [(4, 0.05), (8, 0.05), (3, 0.2), (4, 0.4)] {
        let side = 0.1_f64;
        for (what, away) in
            [("corner", [0.0, 0.0]), ("near", [1e-5, 2e-6]), ("side", [side.cos(), side.sin()]), ("face", [0.7, 0.6])]
        {
            let file = folder.path().join(format!("{sides}-{slope}-{what}.obj"));
            write(&file, &pyramid(sides, slope), Vec3::new(10.0 - away[0], 10.0 - away[1], 10.1));
            let run = run(&under(&file));
            let force = ["x", "y", "z"].map(|c| last(&run, &format!("stamp_force_{c}_N")));
            println!(
                "{sides} sides, slope {slope}, {what}: {} cuts, {} iterations, F = {force:?}",
                run.totals.cuts, run.tried_iterations
            );
            assert_eq!(run.status, Status::Converged, "{sides} {slope} {what}");
            assert!(force[2] < -0.01, "{force:?}");
        }
    }
}
