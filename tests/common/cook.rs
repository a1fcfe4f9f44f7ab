//! Cook's membrane (Cook 1974), in plane strain and nearly incompressible, at large strain (as Simo & Armero, *Int. J. Numer. Methods Eng.* 33, 1992). It has no closed form: formulations are compared with each other's limit, 6.93.

use super::formulation::{Formulation, solid};
use super::{DeadLoad, hold, law, nodes, ramp, statics, straighten};
use durometer::material::Law;
use durometer::math::tensor::Vec3;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::system::Prescribed;

/// μ = 80.194, κ = 400889.806, ψ = ½μ(J^{−2/3}I₁ − 3) + ½κ(J − 1)²: ν ≈ 0.4999.
pub fn rubber() -> Box<dyn Law> {
    let (mu, kappa) = (80.194, 400_889.806);
    let e = 9.0 * kappa * mu / (3.0 * kappa + mu);
    let nu = (3.0 * kappa - 2.0 * mu) / (2.0 * (3.0 * kappa + mu));
    law("neo_hookean_split", e, nu)
}

/// The membrane as one layer of n × n boxes in plane strain; `mirrored` turns the diagonals round.
pub fn membrane(n: usize, order: Order, mirrored: bool) -> TetMesh {
    let mut mesh = block(n, n, 1, 1.0, 1.0, 1.0 / n as f64, order);
    if mirrored {
        // A reflection y → 1 − y of the unit square, with the cells turned back to positive volume.
        mesh.points.iter_mut().for_each(|p| p.y = 1.0 - p.y);
        mesh = flipped(mesh);
    }
    for p in &mut mesh.points {
        let (s, t) = (p.x, p.y);
        *p = Vec3::new(48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s), p.z * n as f64);
    }
    straighten(&mut mesh);
    mesh
}

/// Swaps two corners of every cell and facet, with the mid-nodes that go with them.
fn flipped(mut mesh: TetMesh) -> TetMesh {
    let (n, m) = (mesh.order.cell_nodes(), mesh.order.facet_nodes());
    for cell in mesh.cells.chunks_mut(n) {
        cell.swap(0, 1);
        if n == 10 {
            // Mid-edges (0,1) (1,2) (0,2) (0,3) (1,3) (2,3)
            cell.swap(5, 6);
            cell.swap(7, 8);
        }
    }
    for facet in mesh.facets.chunks_mut(m) {
        facet.swap(0, 1);
        if m == 6 {
            facet.swap(4, 5);
        }
    }
    let (ymin, ymax) = (mesh.regions["ymin"].clone(), mesh.regions["ymax"].clone());
    mesh.regions.insert("ymin".into(), ymax);
    mesh.regions.insert("ymax".into(), ymin);
    mesh
}

/// The membrane of n × n boxes under F = 100, and its unknowns.
pub fn bent(n: usize, order: Order, formulation: Formulation, mirrored: bool) -> (TetMesh, Vec<f64>) {
    let mesh = membrane(n, order, mirrored);
    let load = DeadLoad::traction(&mesh, "xmax", ramp(1.0), Vec3::new(0.0, 100.0, 0.0));
    let all: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let mut prescribed: Vec<Prescribed> = hold(&all, &[2]);
    prescribed.extend(hold(&nodes(&mesh, "xmin"), &[0, 1]));
    let system = solid(&mesh, rubber(), formulation, vec![Box::new(load)], prescribed);
    let (state, _) = statics(&mesh, &system, 1e-8, 2);
    (mesh, state.x)
}

/// u_y at (48, 60).
pub fn tip(mesh: &TetMesh, x: &[f64]) -> f64 {
    let corner = (0..mesh.points.len())
        .find(|&k| (mesh.points[k] - Vec3::new(48.0, 60.0, 0.0)).norm() < 1e-9)
        .expect("the corner is a node");
    x[3 * corner + 1]
}
