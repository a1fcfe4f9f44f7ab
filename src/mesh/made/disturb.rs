//! Meshes degraded on purpose, for robustness studies: inner nodes moved at random, slivers inserted.

use crate::math::random::SplitMix;
use crate::math::tensor::Vec3;
use crate::mesh::element::CELL_EDGES;
use crate::mesh::quality::dihedral_angles;
use crate::mesh::{Order, TetMesh};

/// Moves every inner corner node by up to `amount`·h in each direction (0.1 is safe on blocks); mid-nodes of quadratic cells follow their corners, so
/// that straight edges stay straight. The same seed gives the same mesh.
pub fn distort(mesh: &mut TetMesh, seed: u64, amount: f64) {
    let (reach, mut random) = (amount * mesh.h(), SplitMix(seed));
    let inner = inner_corners(mesh);
    let shifts: Vec<Vec3> = (inner.iter())
        .map(|&inner| {
            let shift = Vec3::from_fn(|_, _| reach * (2.0 * random.unit() - 1.0));
            if inner { shift } else { Vec3::zeros() }
        })
        .collect();
    shift(mesh, &shifts);
}

/// Inserts slivers into the fraction `share` of the cells: a node slightly above the centre of one face cuts a cell into four, the lowest of which
/// has the smallest dihedral angle `angle` \[rad\]. The functions that the mesh can represent are preserved.
pub fn add_slivers(mesh: &mut TetMesh, seed: u64, share: f64, angle: f64) {
    let mut random = SplitMix(seed);
    let count = mesh.cell_count();
    let wanted = ((share * count as f64).ceil() as usize).min(count);
    let mut cells: Vec<usize> = (0..count).collect();
    for k in 0..wanted {
        cells.swap(k, k + random.below(count - k));
        cut_flat(mesh, cells[k], random.below(4), angle);
    }
}

/// Cuts a cell by a node above the face opposite its corner `apex`.
fn cut_flat(mesh: &mut TetMesh, c: usize, apex: usize, angle: f64) {
    let nodes = mesh.cell(c).to_vec();
    let corners: [Vec3; 4] = std::array::from_fn(|k| mesh.points[nodes[k] as usize]);
    let face = (0..4).filter(|k| *k != apex).map(|k| corners[k]).sum::<Vec3>() / 3.0;
    let above = |height: f64| face + height * (corners[apex] - face);
    let with = |k: usize, p: Vec3| std::array::from_fn(|i| if i == k { p } else { corners[i] });
    let smallest = |height: f64| dihedral_angles(&with(apex, above(height))).into_iter().fold(f64::INFINITY, f64::min);
    let (mut low, mut high) = (0.0, 0.25);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if smallest(middle) < angle { low = middle } else { high = middle }
    }
    let node = mesh.points.len() as u32;
    mesh.points.push(above(high));
    // Mid-nodes of the edges to the four corners
    let first_mid = mesh.points.len() as u32;
    if mesh.order == Order::Quadratic {
        mesh.points.extend(corners.map(|p| (p + above(high)) / 2.0));
    }
    let part = |k: usize| {
        let mut cell = nodes.clone();
        cell[k] = node;
        for (e, [a, b]) in CELL_EDGES.into_iter().enumerate().take(nodes.len() - 4) {
            if a == k || b == k {
                cell[4 + e] = first_mid + (a + b - k) as u32;
            }
        }
        cell
    };
    let width = nodes.len();
    mesh.cells[width * c..width * (c + 1)].copy_from_slice(&part(apex));
    let next = mesh.cell_count() as u32;
    (0..4).filter(|k| *k != apex).for_each(|k| mesh.cells.extend(part(k)));
    for region in mesh.regions.values_mut().filter(|r| r.cells.contains(&(c as u32))) {
        region.cells.extend(next..next + 3);
    }
}

fn inner_corners(mesh: &TetMesh) -> Vec<bool> {
    let mut inner = vec![false; mesh.points.len()];
    (0..mesh.cell_count()).for_each(|c| mesh.cell(c)[..4].iter().for_each(|&k| inner[k as usize] = true));
    mesh.facets.iter().for_each(|&k| inner[k as usize] = false);
    inner
}

/// Moves corners; a mid-node moves by the mean of the motions of its two corners.
fn shift(mesh: &mut TetMesh, shifts: &[Vec3]) {
    let mut all = shifts.to_vec();
    if mesh.order == Order::Quadratic {
        for c in 0..mesh.cell_count() {
            let nodes = mesh.cell(c);
            for (e, [a, b]) in CELL_EDGES.into_iter().enumerate() {
                all[nodes[4 + e] as usize] = (shifts[nodes[a] as usize] + shifts[nodes[b] as usize]) / 2.0;
            }
        }
    }
    mesh.points.iter_mut().zip(all).for_each(|(p, shift)| *p += shift);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::smaller;
    use crate::mesh::file::validate::min_det;
    use crate::mesh::made::structured::block;
    use crate::mesh::quality::Quality;

    /// The angle is found by bisection; no cell is worse than intended, none is folded, and the body is unchanged.
    #[test]
    fn slivers_are_as_flat_as_asked_for() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(5, 5, 5, 1.0, 1.0, 1.0, order);
            let angle = 0.5_f64.to_radians();
            add_slivers(&mut mesh, 3, 0.01, angle);
            let smallest = |c: usize| {
                let corners = std::array::from_fn(|k| mesh.points[mesh.cell(c)[k] as usize]);
                dihedral_angles(&corners).into_iter().fold(f64::INFINITY, smaller)
            };
            let flat = (0..mesh.cell_count()).filter(|&c| smallest(c) < 1.0001 * angle).count();
            assert_eq!((mesh.cell_count(), flat), (750 + 3 * 8, 8), "1 % of 750 cells, each into four");
            assert!((Quality::of(&mesh).dihedral_min_deg - 0.5).abs() < 1e-6);
            assert!((0..mesh.cell_count()).all(|c| min_det(&mesh, c) > 0.0));
            assert!((mesh.volume() - 1.0).abs() < 1e-12);
            assert_eq!(mesh.regions["body"].cells.len(), mesh.cell_count());
        }
    }
}
