//! Mass matrices M_ab = ∫ ρ N_a N_b dV and their lumped forms.

use crate::mesh::{Order, TetMesh, element, quadrature};
use crate::system::{BlockValues, Blocks, Want};

/// Distribution of the mass of a region to its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lumping {
    /// ∫ ρ N_a N_b dV, degree-4 rule on tet10
    Consistent,
    /// Diagonal of the consistent matrix scaled to the mass of the cell (Hinton, Rock & Zienkiewicz 1976)
    Lumped,
    /// The same mass for each node, for comparison: it pulls the centre of mass towards refined parts
    Uniform,
}

/// Scalar mass matrix by blocks: cells, or single nodes when lumped.
pub struct Mass {
    pub blocks: Blocks,
    /// Block after block, n × n row by row \[kg\]
    entries: Vec<f64>,
    offsets: Vec<usize>,
    /// \[kg\]
    pub total: f64,
}

impl Mass {
    /// Of the cells of a region with density ρ \[kg/m³\].
    pub fn new(mesh: &TetMesh, cells: &[u32], rho: f64, lumping: Lumping) -> Self {
        let n = mesh.order.cell_nodes();
        let matrices: Vec<Vec<f64>> = cells.iter().map(|&c| consistent(mesh, c as usize, rho)).collect();
        let total = matrices.iter().flatten().sum();
        if lumping == Lumping::Consistent {
            let blocks = Blocks::new(cells.iter().map(|&c| mesh.cell(c as usize)));
            let offsets = (0..cells.len()).map(|b| b * n * n).collect();
            return Self { blocks, entries: matrices.concat(), offsets, total };
        }
        let mut nodal = vec![0.0; mesh.points.len()];
        for (&c, m) in cells.iter().zip(&matrices) {
            let (mass, trace): (f64, f64) = (m.iter().sum(), (0..n).map(|a| m[a * n + a]).sum());
            for (a, &node) in mesh.cell(c as usize).iter().enumerate() {
                nodal[node as usize] += m[a * n + a] * mass / trace;
            }
        }
        let nodes: Vec<u32> = (0..nodal.len() as u32).filter(|&k| nodal[k as usize] > 0.0).collect();
        let entries = match lumping {
            Lumping::Uniform => vec![total / nodes.len() as f64; nodes.len()],
            _ => nodes.iter().map(|&k| nodal[k as usize]).collect(),
        };
        Self { blocks: Blocks::new(nodes.chunks(1)), offsets: (0..nodes.len()).collect(), entries, total }
    }

    /// r_e += c M y, K_e += rate · c M on block `b`; returns ½ y·My.
    pub fn apply(&self, y: &[f64], b: usize, c: f64, rate: f64, want: Want, out: &mut BlockValues) -> f64 {
        let nodes = self.blocks.nodes(b);
        let n = nodes.len();
        let m = &self.entries[self.offsets[b]..self.offsets[b] + n * n];
        let mut energy = 0.0;
        for row in 0..n {
            for column in 0..n {
                let entry = m[row * n + column];
                let from = 3 * nodes[column] as usize;
                let to = 3 * nodes[row] as usize;
                for i in 0..3 {
                    out.r[3 * row + i] += c * entry * y[from + i];
                    energy += 0.5 * entry * y[to + i] * y[from + i];
                    if want == Want::Tangent && column <= row {
                        out.k[(3 * row + i) * 3 * n + 3 * column + i] += rate * c * entry;
                    }
                }
            }
        }
        energy
    }
}

/// \[n × n\] ∫ ρ N_a N_b dV of a cell \[kg\].
fn consistent(mesh: &TetMesh, c: usize, rho: f64) -> Vec<f64> {
    let n = mesh.order.cell_nodes();
    let rule = quadrature::tet(if mesh.order == Order::Linear { 2 } else { 4 });
    let mut m = vec![0.0; n * n];
    for (&xi, w) in rule.points.iter().zip(&rule.weights) {
        let shape = element::cell_shape(mesh.order, xi);
        let factor = rho * w * mesh.jacobian(c, xi).determinant();
        for a in 0..n {
            for b in 0..n {
                m[a * n + b] += factor * shape[a] * shape[b];
            }
        }
    }
    m
}
