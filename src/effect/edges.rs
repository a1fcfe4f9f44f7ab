//! Edges between nodes, for springs and dampers: d = D + u_j − u_i, l = ‖d‖, τ = d/l, with D = X_j − X_i.
//!
//! Everything is a function of l, so that an inverted cell is not detected.

use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::TetMesh;
use crate::mesh::element::CELL_EDGES;
use crate::system::{BlockValues, Blocks, EvalError, Want};

/// Distinct edges; block `b` is the edge from its first node i to its second node j.
pub struct Edges {
    pub blocks: Blocks,
    /// \[edges\] D \[m\]
    rest: Vec<Vec3>,
}

impl Edges {
    /// Builds each edge once, in the given order; the two nodes of an edge must be distinct at rest.
    pub fn between(points: &[Vec3], pairs: &[[u32; 2]]) -> Self {
        let rest = pairs.iter().map(|&[i, j]| points[j as usize] - points[i as usize]).collect();
        Self { blocks: Blocks::new(pairs.iter().map(|p| &p[..])), rest }
    }

    /// Returns the edges between the corners of some cells, in ascending order, and for each edge the volume of the cells around it \[m³\].
    pub fn of_cells(mesh: &TetMesh, cells: &[u32]) -> (Self, Vec<f64>) {
        let sides = |c: u32| {
            let nodes = mesh.cell(c as usize);
            CELL_EDGES.map(|[a, b]| [nodes[a].min(nodes[b]), nodes[a].max(nodes[b])])
        };
        let mut pairs: Vec<[u32; 2]> = cells.iter().flat_map(|&c| sides(c)).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut around = vec![0.0; pairs.len()];
        for &c in cells {
            let volume = mesh.jacobian(c as usize, [0.25; 3]).determinant() / 6.0;
            for side in sides(c) {
                around[pairs.binary_search(&side).expect("every side is listed")] += volume;
            }
        }
        (Self::between(&mesh.points, &pairs), around)
    }

    /// D of edge `b` \[m\].
    pub fn rest(&self, b: usize) -> Vec3 {
        self.rest[b]
    }

    /// u_j − u_i of edge `b` at displacement x \[m\].
    pub fn stretching(&self, x: &[f64], b: usize) -> Vec3 {
        let at = |node: u32| Vec3::from_column_slice(&x[3 * node as usize..][..3]);
        let nodes = self.blocks.nodes(b);
        at(nodes[1]) - at(nodes[0])
    }

    /// Returns l \[m\] and τ of edge `b` for its vector d; an error if the length is zero.
    pub fn direction(&self, effect: &str, b: usize, d: Vec3) -> Result<(f64, Vec3), EvalError> {
        let (l, nodes) = (d.norm(), self.blocks.nodes(b));
        if l == 0.0 {
            return Err(EvalError::Coincident { effect: effect.into(), nodes: [nodes[0], nodes[1]] });
        }
        Ok((l, d / l))
    }
}

/// Adds r_e = n (−τ, τ) of a force n along an edge, and K_e from the derivatives `along` = ∂n/∂l and `across` = n/l \[N/m\].
pub fn add_force(tau: Vec3, n: f64, along: f64, across: f64, want: Want, out: &mut BlockValues) {
    for i in 0..3 {
        out.r[i] -= n * tau[i];
        out.r[3 + i] += n * tau[i];
    }
    if want == Want::Tangent {
        let h = tau * tau.transpose() * (along - across) + Mat3::identity() * across;
        for i in 0..3 {
            for j in 0..3 {
                out.k[6 * i + j] += h[(i, j)];
                out.k[6 * (3 + i) + j] -= h[(i, j)];
                out.k[6 * (3 + i) + 3 + j] += h[(i, j)];
            }
        }
    }
}

/// Returns ‖a‖ − ‖b‖ without cancellation, from b and a − b.
pub fn longer(b: Vec3, difference: Vec3) -> f64 {
    let a = b + difference;
    difference.dot(&(a + b)) / (a.norm() + b.norm())
}
