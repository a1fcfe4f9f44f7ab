//! Rotation of the neighbourhood of each node between two states: R_a is the rotation in Σ_e∋a Σ_n∈e (x_n − x̄_e)(x⁰_n − x̄⁰_e)ᵀ, over the blocks e
//! with few nodes and the nodes n in them.
//!
//! A soft body rotates much more than it strains, and its tangent rotates with it: K ≈ R K₀ Rᵀ. Therefore R K₀⁻¹ Rᵀ remains an approximation of K⁻¹
//! much longer than K₀⁻¹ does (Hecht, Lee, Shewchuk & O'Brien, ACM Trans. Graph. 31, 2012, use the same for corotational bodies).
//!
//! Limits: a node with a prescribed component does not rotate. Rotations are extracted by the iteration of Müller et al. (MIG 2016), which also works
//! for flat and inverted neighbourhoods.

use crate::math::tensor::{Mat3, Vec3};
use crate::math::threads;
use crate::system::{Dofs, System};

/// Largest number of nodes of a block that is included; blocks with more nodes than a cell couple distant places.
const MOST_NODES: usize = 10;
/// Number of blocks whose sums, and of nodes whose rotations, one thread computes at a time.
const BLOCKS: usize = 2048;
const NODES: usize = 512;
/// Accuracy of an angle \[rad\], and the largest number of iterations for it.
const ANGLE: f64 = 1e-4;
const ITERATIONS: usize = 20;

/// Rotations of nodes; empty if nothing has rotated.
#[derive(Clone, Debug, Default)]
pub(super) struct NodalRotations {
    /// First of the three equations of a node, and its R
    of_nodes: Vec<(usize, Mat3)>,
}

impl NodalRotations {
    /// Computes the rotations from displacements `old` to `new` \[unknowns\] of nodes at `points`; empty if no points are known.
    pub fn new(system: &System, points: &[Vec3], old: &[f64], new: &[f64]) -> Self {
        let at = |x: &[f64], n: u32| points[n as usize] + Vec3::from_column_slice(&x[3 * n as usize..][..3]);
        let small = |nodes: &&[u32]| (2..=MOST_NODES).contains(&nodes.len());
        let lists = system.effects.iter().filter(|e| e.capabilities().means.is_none()).map(|e| e.blocks());
        let blocks = lists.flat_map(|list| (0..list.len()).map(move |b| list.nodes(b)));
        let blocks: Vec<&[u32]> = blocks.filter(|_| !points.is_empty()).filter(small).collect();
        let of_block = |nodes: &&[u32]| -> Mat3 {
            let mean = |x: &[f64]| nodes.iter().map(|&n| at(x, n)).sum::<Vec3>() / nodes.len() as f64;
            let (then, now) = (mean(old), mean(new));
            nodes.iter().map(|&n| (at(new, n) - now) * (at(old, n) - then).transpose()).sum()
        };
        let of_blocks =
            threads::map(blocks.chunks(BLOCKS).collect(), |blocks| blocks.iter().map(of_block).collect::<Vec<_>>());
        let mut sums = vec![Mat3::zeros(); points.len()];
        for (nodes, sum) in blocks.iter().zip(of_blocks.iter().flatten()) {
            nodes.iter().for_each(|&n| sums[n as usize] += sum);
        }
        let turned = |(piece, sums): (usize, &[Mat3])| {
            let of_node = |(n, sum): (usize, &Mat3)| {
                let equations = &system.dofs.equation[3 * n..3 * n + 3];
                (!equations.contains(&Dofs::FIXED)).then(|| (equations[0] as usize, rotation(sum)))
            };
            (NODES * piece..).zip(sums).filter_map(of_node).collect::<Vec<_>>()
        };
        let pieces = sums.chunks(NODES).enumerate().collect();
        Self { of_nodes: threads::map(pieces, turned).concat() }
    }

    /// v ← R v
    pub fn rotate(&self, v: &mut [f64]) {
        for (first, r) in &self.of_nodes {
            let turned = r * Vec3::from_column_slice(&v[*first..first + 3]);
            v[*first..first + 3].copy_from_slice(turned.as_slice());
        }
    }

    /// v ← Rᵀ v
    pub fn rotate_back(&self, v: &mut [f64]) {
        for (first, r) in &self.of_nodes {
            let turned = r.tr_mul(&Vec3::from_column_slice(&v[*first..first + 3]));
            v[*first..first + 3].copy_from_slice(turned.as_slice());
        }
    }
}

fn rotation(sum: &Mat3) -> Mat3 {
    let size = sum.norm();
    if size == 0.0 || !size.is_finite() {
        return Mat3::identity();
    }
    let start = nalgebra::Rotation3::identity();
    nalgebra::Rotation3::from_matrix_eps(&(sum / size), ANGLE, ITERATIONS, start).into_inner()
}
