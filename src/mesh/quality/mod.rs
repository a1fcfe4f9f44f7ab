//! Quality of the corner tetrahedra of a mesh.

pub mod gap;
pub mod hinge;
pub mod notch;
pub mod overlap;
pub mod wall;

use super::TetMesh;
use super::element::CELL_EDGES;
use crate::math::tensor::Vec3;
use crate::math::threads;
use std::ops::Range;

/// Largest cosine between the outward normals of two facets that face each other across a wall or a gap \[–\].
const OPPOSITE: f64 = -std::f64::consts::FRAC_1_SQRT_2;
/// Number of cells that one thread handles at a time.
const CELLS: usize = 1024;

/// Dihedral angle below which, or within which of 180°, a cell is nearly flat \[deg\].
const FLAT_DEG: f64 = 5.0;

/// Radius ratio 3 r_in/r_circ (1 regular, 0 flat) and dihedral angles \[deg\] over all cells.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Quality {
    pub radius_ratio_min: f64,
    pub radius_ratio_mean: f64,
    pub dihedral_min_deg: f64,
    pub dihedral_max_deg: f64,
    /// Number of nearly flat cells: with a dihedral angle below 5° or above 175°
    pub flat_cells: usize,
    /// Index of the cell with the smallest radius ratio
    pub worst_cell: usize,
}

impl Quality {
    /// Computes the quality of the cells of a mesh; curved edges count as straight.
    pub fn of(mesh: &TetMesh) -> Self {
        let count = mesh.cell_count();
        let of_cell = |c: usize| {
            let corners: [Vec3; 4] = std::array::from_fn(|k| mesh.points[mesh.cell(c)[k] as usize]);
            (radius_ratio(&corners), dihedral_cosines(&corners))
        };
        let pieces = (0..count).step_by(CELLS).map(|first| first..count.min(first + CELLS)).collect();
        let all = threads::map(pieces, |cells: Range<usize>| cells.map(of_cell).collect::<Vec<_>>());
        let (mut least, mut sum, mut low, mut high) = (f64::INFINITY, 0.0, 1.0_f64, -1.0_f64);
        let (mut flat_cells, mut worst_cell) = (0, 0);
        let most = FLAT_DEG.to_radians().cos();
        for (c, (ratio, cosines)) in all.into_iter().flatten().enumerate() {
            if ratio < least {
                (least, worst_cell) = (ratio, c);
            }
            flat_cells += usize::from(cosines.iter().any(|cosine| cosine.abs() > most));
            sum += ratio;
            low = cosines.into_iter().fold(low, f64::min);
            high = cosines.into_iter().fold(high, f64::max);
        }
        // The largest cosine belongs to the smallest angle.
        let [dihedral_min_deg, dihedral_max_deg] = [high, low].map(|cosine| cosine.acos().to_degrees());
        Self {
            radius_ratio_min: least,
            radius_ratio_mean: sum / count as f64,
            dihedral_min_deg,
            dihedral_max_deg,
            flat_cells,
            worst_cell,
        }
    }
}

/// Returns 3 r_in/r_circ with r_in = 3V/A and r_circ = |a²(b×c) + b²(c×a) + c²(a×b)|/12V, for edges a, b, c from one corner.
pub fn radius_ratio(x: &[Vec3; 4]) -> f64 {
    let (a, b, c) = (x[1] - x[0], x[2] - x[0], x[3] - x[0]);
    let volume = a.dot(&b.cross(&c)) / 6.0;
    let area = 0.5 * (a.cross(&b).norm() + b.cross(&c).norm() + c.cross(&a).norm() + (b - a).cross(&(c - a)).norm());
    let center = b.cross(&c) * a.norm_squared() + c.cross(&a) * b.norm_squared() + a.cross(&b) * c.norm_squared();
    // 3 · (3V/A) · 12V / |…|
    108.0 * volume * volume / (area * center.norm())
}

/// The six dihedral angles \[rad\].
pub fn dihedral_angles(x: &[Vec3; 4]) -> [f64; 6] {
    dihedral_cosines(x).map(f64::acos)
}

/// Returns the cosines of the dihedral angles; 1 if a face has zero height over the edge.
fn dihedral_cosines(x: &[Vec3; 4]) -> [f64; 6] {
    CELL_EDGES.map(|[i, j]| {
        let edge = (x[j] - x[i]).normalize();
        let away = |k: usize| (x[k] - x[i]) - edge * edge.dot(&(x[k] - x[i]));
        // The other two corners
        let mut rest = (0..4).filter(|k| *k != i && *k != j).map(away);
        let (a, b) = (rest.next().unwrap_or_default(), rest.next().unwrap_or_default());
        let size = a.norm() * b.norm();
        if size > 0.0 { (a.dot(&b) / size).clamp(-1.0, 1.0) } else { 1.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_regular_and_the_corner_tetrahedron() {
        let regular = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]].map(Vec3::from);
        assert!((radius_ratio(&regular) - 1.0).abs() < 1e-14);
        let third = (1.0_f64 / 3.0).acos();
        assert!(dihedral_angles(&regular).iter().all(|a| (a - third).abs() < 1e-14));
        // Corner of a cube: r_in = 1/(3 + √3), r_circ = √3/2.
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
        let ratio = 3.0 / (3.0 + 3.0_f64.sqrt()) / (3.0_f64.sqrt() / 2.0);
        assert!((radius_ratio(&corner) - ratio).abs() < 1e-14);
    }
}
