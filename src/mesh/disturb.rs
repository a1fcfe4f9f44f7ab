//! Meshes made worse on purpose: inner nodes moved at random, cells flattened to slivers. For robustness studies.

use super::element::CELL_EDGES;
use super::quality::dihedral_angles;
use super::validate::min_det;
use super::{Order, TetMesh};
use crate::math::random::SplitMix;
use crate::math::tensor::Vec3;

impl TetMesh {
    /// Moves every inner corner node by up to `amount`·h in each direction (0.1 is safe on blocks); mid-nodes of quadratic
    /// cells follow their corners, so straight edges stay straight. The same seed gives the same mesh.
    pub fn distort(&mut self, seed: u64, amount: f64) {
        let (reach, mut random) = (amount * self.h(), SplitMix(seed));
        let inner = self.inner_corners();
        let shifts: Vec<Vec3> = (inner.iter())
            .map(|&inner| {
                let shift = Vec3::from_fn(|_, _| reach * (2.0 * random.unit() - 1.0));
                if inner { shift } else { Vec3::zeros() }
            })
            .collect();
        self.shift(&shifts);
    }

    /// Flattens cells until the share `share` of them is slivers: an inner corner node goes towards the opposite face of one of its
    /// cells until the smallest dihedral angle there is `angle` [rad]; no other cell may fold. Returns the number of slivers,
    /// less than asked for where the mesh has no room.
    pub fn flatten(&mut self, seed: u64, share: f64, angle: f64) -> usize {
        let mut random = SplitMix(seed);
        let inner = self.inner_corners();
        let mut around = vec![vec![]; self.points.len()];
        (0..self.cell_count()).for_each(|c| self.cell(c)[..4].iter().for_each(|&k| around[k as usize].push(c)));
        let mut candidates: Vec<usize> = (0..self.points.len()).filter(|&k| inner[k]).collect();
        for k in (1..candidates.len()).rev() {
            candidates.swap(k, random.below(k + 1));
        }
        let wanted = (share * self.cell_count() as f64).ceil() as usize;
        // Corners of a sliver stay where they are
        let mut kept = vec![false; self.points.len()];
        let mut made = 0;
        for node in candidates {
            if made == wanted {
                break;
            }
            let first = random.below(around[node].len());
            let cells = around[node].iter().cycle().skip(first).take(around[node].len());
            if let Some(c) = cells.copied().find(|&c| !kept[node] && self.push_flat(node, c, &around[node], angle)) {
                self.cell(c)[..4].to_vec().iter().for_each(|&k| kept[k as usize] = true);
                made += 1;
            }
        }
        made
    }

    /// Moves a corner towards the opposite face of a cell; false, and nothing moved, if that folds a cell.
    fn push_flat(&mut self, node: usize, c: usize, around: &[usize], angle: f64) -> bool {
        let corners: Vec<usize> = self.cell(c)[..4].iter().map(|&k| k as usize).collect();
        let opposite: Vec3 = corners.iter().filter(|&&k| k != node).map(|&k| self.points[k]).sum::<Vec3>() / 3.0;
        let away = opposite - self.points[node];
        let smallest = |share: f64| {
            let at = |k: usize| self.points[corners[k]] + if corners[k] == node { share * away } else { Vec3::zeros() };
            dihedral_angles(&std::array::from_fn(at)).into_iter().fold(f64::INFINITY, f64::min)
        };
        if smallest(0.0) <= angle {
            return false;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if smallest(middle) > angle { low = middle } else { high = middle }
        }
        let mut shifts = vec![Vec3::zeros(); self.points.len()];
        shifts[node] = low * away;
        self.shift(&shifts);
        let sound = around.iter().all(|&c| min_det(self, c) > 0.0);
        if !sound {
            shifts[node] = -shifts[node];
            self.shift(&shifts);
        }
        sound
    }

    fn inner_corners(&self) -> Vec<bool> {
        let mut inner = vec![false; self.points.len()];
        (0..self.cell_count()).for_each(|c| self.cell(c)[..4].iter().for_each(|&k| inner[k as usize] = true));
        self.facets.iter().for_each(|&k| inner[k as usize] = false);
        inner
    }

    /// Moves corners; a mid-node moves by the mean of its two.
    fn shift(&mut self, shifts: &[Vec3]) {
        let mut all = shifts.to_vec();
        if self.order == Order::Quadratic {
            for c in 0..self.cell_count() {
                let nodes = self.cell(c);
                for (e, [a, b]) in CELL_EDGES.into_iter().enumerate() {
                    all[nodes[4 + e] as usize] = (shifts[nodes[a] as usize] + shifts[nodes[b] as usize]) / 2.0;
                }
            }
        }
        self.points.iter_mut().zip(all).for_each(|(p, shift)| *p += shift);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structured::block;

    /// The angle is met by bisection to 1e-12 of it, and worse cells than these there are none.
    #[test]
    fn slivers_are_as_flat_as_asked_for() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(5, 5, 5, 1.0, 1.0, 1.0, order);
            let angle = 0.5_f64.to_radians();
            let made = mesh.flatten(3, 0.01, angle);
            assert_eq!(made, 8, "1 % of 750 cells");
            let flat = |c: &usize| {
                let corners = std::array::from_fn(|k| mesh.points[mesh.cell(*c)[k] as usize]);
                dihedral_angles(&corners).into_iter().fold(f64::INFINITY, f64::min) < 1.001 * angle
            };
            assert!((0..mesh.cell_count()).filter(flat).count() >= made);
            assert!((0..mesh.cell_count()).all(|c| min_det(&mesh, c) > 0.0));
            assert!((mesh.quality().dihedral_min_deg - 0.5).abs() < 1e-3);
            assert!((mesh.volume() - 1.0).abs() < 1e-12);
        }
    }
}
