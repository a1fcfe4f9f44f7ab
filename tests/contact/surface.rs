//! Triangle surfaces as obstacles, against the same shapes as primitives.

use crate::common::run;
use crate::setup::{RESPONSES, last, soft_block};
use durometer::effect::contact::shape::Shape;
use durometer::math::tensor::Vec3;
use durometer::mesh::surface_file::Surface;
use durometer::solve::Status;
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
fn write(file: &Path, surface: &Surface, at: Vec3) {
    let vertices =
        surface.points.iter().map(|p| (p * 1e3 + at).iter().map(f64::to_string).collect::<Vec<_>>().join(" "));
    let faces = surface.triangles.iter().map(|t| t.map(|k| (k + 1).to_string()).join(" "));
    let lines = vertices.map(|v| format!("v {v}\n")).chain(faces.map(|f| format!("f {f}\n")));
    std::fs::write(file, lines.collect::<String>()).expect("a temporary file");
}

/// Flat sides have no sagitta: the box of triangles is the box. The barrier counts a point twice where two triangles are near, within its
/// distance of a diagonal or an edge, in which no node lies here.
#[test]
fn a_box_of_triangles_is_a_box() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("box.obj");
    let shape = Shape::cuboid(Vec3::new(0.0061, 0.0043, 0.004)).triangles(0).expect("it has sides");
    write(&file, &shape, Vec3::new(9.7, 10.4, 14.1));
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
