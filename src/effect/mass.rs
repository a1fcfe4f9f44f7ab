//! Mass matrices M_ab = ∫ ρ N_a N_b dV and their lumped forms.

use super::cell::MOST_NODES;
use crate::math::lanes::{Kernel, LANES, Lanes, Real, widest};
use crate::mesh::{Order, TetMesh, element, quadrature};
use crate::system::{Batch, BlockValues, Blocks, Want};

/// Distribution of the mass of a region among its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lumping {
    /// ∫ ρ N_a N_b dV, degree-4 rule on tet10
    Consistent,
    /// Diagonal of the consistent matrix scaled to the mass of the cell (Hinton, Rock & Zienkiewicz 1976)
    Lumped,
    /// The same mass for each node, for comparison: it shifts the centre of mass towards refined regions
    Uniform,
}

/// Scalar mass matrix in blocks: cells, or single nodes if lumped.
pub struct Mass {
    pub blocks: Blocks,
    /// \[groups of blocks × n × n\] row by row, [`LANES`] blocks side by side \[kg\]
    entries: Vec<Lanes>,
    /// \[kg\]
    pub total: f64,
}

impl Mass {
    /// The mass of the cells of a region with density ρ \[kg/m³\].
    pub fn new(mesh: &TetMesh, cells: &[u32], rho: f64, lumping: Lumping) -> Self {
        let n = mesh.order.cell_nodes();
        let matrices: Vec<Vec<f64>> = cells.iter().map(|&c| consistent(mesh, c as usize, rho)).collect();
        let total = matrices.iter().flatten().sum();
        if lumping == Lumping::Consistent {
            let blocks = Blocks::new(cells.iter().map(|&c| mesh.cell(c as usize)));
            return Self { blocks, entries: side_by_side(&matrices), total };
        }
        let mut nodal = vec![0.0; mesh.points.len()];
        for (&c, m) in cells.iter().zip(&matrices) {
            let (mass, trace): (f64, f64) = (m.iter().sum(), (0..n).map(|a| m[a * n + a]).sum());
            for (a, &node) in mesh.cell(c as usize).iter().enumerate() {
                nodal[node as usize] += m[a * n + a] * mass / trace;
            }
        }
        let nodes: Vec<u32> = (0..nodal.len() as u32).filter(|&k| nodal[k as usize] > 0.0).collect();
        let mass = |k: u32| match lumping {
            Lumping::Uniform => total / nodes.len() as f64,
            _ => nodal[k as usize],
        };
        let entries: Vec<Vec<f64>> = nodes.iter().map(|&k| vec![mass(k)]).collect();
        Self { blocks: Blocks::new(nodes.chunks(1)), entries: side_by_side(&entries), total }
    }

    /// Adds r_e += c M y and K_e += rate · c M on block `b`.
    pub fn apply(&self, y: &[f64], b: usize, c: f64, rate: f64, want: Want, out: &mut BlockValues) {
        let (m, y) = (self.matrix(b), self.of_block(y, b));
        apply(&m, &y, [c, rate * c], want, &mut out.r, &mut out.k);
    }

    /// Returns ½ y·My of block `b`.
    pub fn energy(&self, y: &[f64], b: usize) -> f64 {
        energy(&self.matrix(b), &self.of_block(y, b))
    }

    /// Adds r_e += c M y and K_e += rate · c M on the [`LANES`] blocks from `first` on, as [`Mass::apply`] does on one.
    pub fn apply_batch(&self, y: &[f64], first: usize, c: f64, rate: f64, want: Want, out: &mut Batch) {
        let y = self.of_batch(y, first);
        let y = &y[..self.blocks.nodes(first).len()];
        widest(Apply { m: self.matrices(first), y, factors: [c, rate * c], want, out });
    }

    /// Returns ½ y·My of each of the [`LANES`] blocks from `first` on, as [`Mass::energy`] does for one.
    pub fn energy_of_batch(&self, y: &[f64], first: usize) -> Lanes {
        let y = self.of_batch(y, first);
        energy(self.matrices(first), &y[..self.blocks.nodes(first).len()])
    }

    /// M of the [`LANES`] blocks from `first` on, a multiple of [`LANES`].
    fn matrices(&self, first: usize) -> &[Lanes] {
        let size = self.blocks.nodes(first).len().pow(2);
        &self.entries[first / LANES * size..][..size]
    }

    /// M of block `b`.
    fn matrix(&self, b: usize) -> Vec<f64> {
        self.matrices(b).iter().map(|m| m.0[b % LANES]).collect()
    }

    fn of_block(&self, y: &[f64], b: usize) -> Vec<[f64; 3]> {
        self.blocks.nodes(b).iter().map(|&node| std::array::from_fn(|i| y[3 * node as usize + i])).collect()
    }

    fn of_batch(&self, y: &[f64], first: usize) -> [[Lanes; 3]; MOST_NODES] {
        let mut out = [[Lanes::ZERO; 3]; MOST_NODES];
        for lane in 0..LANES {
            for (to, &node) in out.iter_mut().zip(self.blocks.nodes(first + lane)) {
                (0..3).for_each(|i| to[i].0[lane] = y[3 * node as usize + i]);
            }
        }
        out
    }
}

/// Arranges matrices of one size in groups of [`LANES`] side by side.
fn side_by_side(matrices: &[Vec<f64>]) -> Vec<Lanes> {
    let size = matrices.first().map_or(0, Vec::len);
    let groups = matrices.chunks(LANES).flat_map(|group| {
        (0..size).map(move |i| Lanes(std::array::from_fn(|lane| group.get(lane).map_or(0.0, |m| m[i]))))
    });
    groups.collect()
}

struct Apply<'a> {
    m: &'a [Lanes],
    y: &'a [[Lanes; 3]],
    factors: [f64; 2],
    want: Want,
    out: &'a mut Batch,
}

impl Kernel for Apply<'_> {
    #[inline(always)]
    fn run(self) {
        apply(self.m, self.y, self.factors, self.want, &mut self.out.r, &mut self.out.k);
    }
}

/// Adds r += c M y and K += d M with the factors c and d.
#[inline(always)]
fn apply<S: Real>(m: &[S], y: &[[S; 3]], factors: [f64; 2], want: Want, r: &mut [S], k: &mut [S]) {
    let (n, [c, d]) = (y.len(), factors.map(S::of));
    for (row, m) in m.chunks_exact(n).enumerate() {
        for (column, (&entry, y)) in m.iter().zip(y).enumerate() {
            for i in 0..3 {
                r[3 * row + i] += c * entry * y[i];
                if want == Want::Tangent && column <= row {
                    k[(3 * row + i) * 3 * n + 3 * column + i] += d * entry;
                }
            }
        }
    }
}

/// Returns ½ y·My.
#[inline(always)]
fn energy<S: Real>(m: &[S], y: &[[S; 3]]) -> S {
    let mut sum = S::of(0.0);
    for (m, to) in m.chunks_exact(y.len()).zip(y) {
        for (&entry, from) in m.iter().zip(y) {
            for i in 0..3 {
                sum += S::of(0.5) * entry * to[i] * from[i];
            }
        }
    }
    sum
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
