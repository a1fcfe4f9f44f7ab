//! Stress at nodes: fields of the degree of the recovery are exact up to the surface, an interface does not smear, and NAFEMS LE1.

use crate::common;
use crate::common::{distorted_cube, scene};
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::curved::mapped_block;
use durometer::mesh::{Order, TetMesh};
use durometer::scene::Scene;
use durometer::scene::output::FieldSpec;
use durometer::solve::Status;
use durometer::system::State;
use std::f64::consts::FRAC_PI_2;

const E: f64 = 210e9;
const NU: f64 = 0.3;

fn plate(mesh: TetMesh, more: &str) -> Scene {
    scene(
        mesh,
        &format!(
            r#"
[mesh]
body = "block"
[laws.steel]
law = "linear"
E = "210 GPa"
nu = {NU}
[[effect]]
kind = "elastic"
region = "body"
law = "steel"
{more}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#
        ),
    )
}

/// \[nodes\] and \[cells\] σ
fn stress(scene: &Scene, state: &State) -> [Vec<Mat3>; 2] {
    let fields = scene.fields(state, &[FieldSpec::Stress]);
    assert!(fields[0].at_nodes && !fields[1].at_nodes);
    [0, 1].map(|k| fields[k].values.chunks_exact(9).map(Mat3::from_row_slice).collect())
}

/// Quadratic displacements on a distorted mesh of tet10: σ = 2με + λ tr ε is linear in X. At displacements of 1e-8 of the size F is I up
/// to a few of them, and its rounding is ε/1e-8 of the strain, which the fit may enlarge tenfold: 1e-6 of the largest stress, at every node, corners of the body included. Means
/// over cells are off by a third of its range there. A linear displacement does the same for tet4.
#[test]
fn linear_stress_is_exact_at_the_surface() {
    let (mu, lambda) = (E / (2.0 * (1.0 + NU)), E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU)));
    for order in common::ORDERS {
        let bend = if order == Order::Linear { 0.0 } else { 1e-8 };
        let mesh = distorted_cube(3, order, 0.15, 5);
        let u = |p: Vec3| {
            let quadratic = Vec3::new(p.x * p.y - p.z * p.z, p.x * p.x + 0.5 * p.y * p.z, p.y * p.y - p.z * p.x);
            bend * quadratic + 1e-8 * Vec3::new(p.y, 2.0 * p.z, -p.x)
        };
        let gradient = |p: Vec3| {
            bend * Mat3::new(p.y, p.x, -2.0 * p.z, 2.0 * p.x, 0.5 * p.z, 0.5 * p.y, -p.z, 2.0 * p.y, -p.x)
                + 1e-8 * Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 2.0, -1.0, 0.0, 0.0)
        };
        let held = "[[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n";
        let scene = plate(mesh, held);
        let mut state = scene.start();
        for (x, p) in state.x.chunks_exact_mut(3).zip(&scene.body.mesh.points) {
            x.copy_from_slice(u(*p).as_slice());
        }
        let [nodes, _] = stress(&scene, &state);
        let exact = |p: &Vec3| {
            let e = 0.5 * (gradient(*p) + gradient(*p).transpose());
            2.0 * mu * e + Mat3::identity() * (lambda * e.trace())
        };
        let points = &scene.body.mesh.points;
        let size = points.iter().map(|p| exact(p).norm()).fold(0.0, larger);
        let off = points.iter().zip(&nodes).map(|(p, s)| (s - exact(p)).norm()).fold(0.0, larger);
        println!("{order:?}: {off:e} of {size:e}");
        assert!(off < 1e-6 * size, "{order:?}: {off:e} of {size:e}");
    }
}

/// NAFEMS LE1 (The Standard NAFEMS Benchmarks, 1990): a membrane between the ellipses x²/4 + y² = 1 and x²/3.25² + y²/2.75² = 1 under
/// 10 MPa outwards, plane stress; σ_yy = 92.7 MPa at D = (2, 0). Returns that of the node, and the mean over its cells.
fn le1(n: usize) -> [f64; 2] {
    let mesh = mapped_block([n, 2 * n, 1], Order::Quadratic, |p| {
        let (s, c) = (FRAC_PI_2 * p.y).sin_cos();
        Vec3::new((2.0 + 1.25 * p.x) * c, (1.0 + 1.75 * p.x) * s, 0.05 * p.z)
    });
    let held = [("ymin", "y"), ("ymax", "x"), ("zmin", "z")];
    let held = held
        .map(|(region, c)| format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{region}\"\ncomponents = \"{c}\"\n"));
    let load = "[[constraint]]\nkind = \"cavity\"\nregion = \"xmax\"\nopen = true\ndrive = { kind = \"pressure\", signal = \"-10 MPa\" }\n";
    let scene = plate(mesh, &(held.concat() + load));
    let run = common::run(&scene);
    assert_eq!(run.status, Status::Converged);
    let [nodes, cells] = stress(&scene, &run.last);
    let mesh = &scene.body.mesh;
    let d = mesh.points.iter().position(|p| (p - Vec3::new(2.0, 0.0, 0.0)).norm() < 1e-9).expect("D is a node");
    let there = (0..mesh.cell_count()).filter(|&c| mesh.cell(c).contains(&(d as u32)));
    let sum = there.fold((0.0, 0.0), |(s, v), c| (s + mesh.cell_volume(c) * cells[c][(1, 1)], v + mesh.cell_volume(c)));
    [nodes[d][(1, 1)], sum.0 / sum.1]
}

/// Within 1.5 % with 1 728 tet10, where a mean over the cells at D is several per cent low.
#[test]
fn elliptic_membrane_has_the_published_stress() {
    let errors = [6, 8, 12].map(|n| {
        let [node, mean] = le1(n).map(|s| s / 92.7e6 - 1.0);
        println!("LE1 {} tet10: node {:+.2} %, mean of cells {:+.2} %", 12 * n * n, 100.0 * node, 100.0 * mean);
        [node, mean]
    });
    let [node, mean] = errors[2];
    assert!(node.abs() < 0.015 && mean < -0.02, "{errors:?}");
}
