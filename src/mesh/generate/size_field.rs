//! Size fields: the edge length as a function of position, given on a mesh of the body.

use crate::mesh::TetMesh;
use crate::mesh::element::CELL_EDGES;
use serde::{Deserialize, Serialize};

/// Multiples of the edge length of a request at points of the body, interpolated linearly in the tetrahedra between them.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SizeField {
    /// \[m\]
    pub points: Vec<[f64; 3]>,
    pub cells: Vec<[u32; 4]>,
    /// \[points\]
    pub sizes: Vec<f64>,
}

impl SizeField {
    /// Builds the size field of edge lengths \[cells of the mesh\] in units of `length`, both \[m\]. A corner gets the volume-weighted geometric mean
    /// over the cells around it, limited to `growth` times the distance above any other corner.
    pub fn new(mesh: &TetMesh, lengths: &[f64], length: f64, growth: f64) -> Self {
        let mut sums = vec![(0.0, 0.0); mesh.points.len()];
        for (c, own) in lengths.iter().enumerate() {
            let volume = mesh.cell_volume(c);
            for &node in &mesh.cell(c)[..4] {
                let sum: &mut (f64, f64) = &mut sums[node as usize];
                *sum = (sum.0 + volume * own.ln(), sum.1 + volume);
            }
        }
        let mut number = vec![u32::MAX; mesh.points.len()];
        let (mut points, mut sizes) = (Vec::new(), Vec::new());
        for (node, (sum, weight)) in sums.iter().enumerate().filter(|(_, (_, weight))| *weight > 0.0) {
            number[node] = points.len() as u32;
            points.push(mesh.points[node].into());
            sizes.push((sum / weight).exp());
        }
        let cells = (0..mesh.cell_count()).map(|c| std::array::from_fn(|k| number[mesh.cell(c)[k] as usize])).collect();
        let mut field = Self { points, cells, sizes };
        field.limit_growth(growth);
        field.sizes.iter_mut().for_each(|size| *size /= length);
        field
    }

    /// Lowers sizes until none exceeds that of a neighbour by more than `growth` times the edge between them.
    fn limit_growth(&mut self, growth: f64) {
        let mut edges: Vec<[u32; 2]> = (self.cells.iter())
            .flat_map(|cell| CELL_EDGES.map(|[i, j]| [cell[i].min(cell[j]), cell[i].max(cell[j])]))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let distance = |[a, b]: [u32; 2]| {
            let (a, b) = (self.points[a as usize], self.points[b as usize]);
            (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
        };
        let steps: Vec<f64> = edges.iter().map(|edge| growth * distance(*edge)).collect();
        // Each pass propagates a small size by at least one more edge.
        let mut lowered = true;
        while lowered {
            lowered = false;
            for ([a, b], step) in edges.iter().zip(&steps) {
                for (low, high) in [(*a as usize, *b as usize), (*b as usize, *a as usize)] {
                    let most = self.sizes[low] + step;
                    if self.sizes[high] > most * (1.0 + 1e-12) {
                        self.sizes[high] = most;
                        lowered = true;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::smaller;
    use crate::mesh::Order;
    use crate::mesh::made::structured::block;

    /// A constant size is unchanged; one small cell spreads by the growth and no faster, and no size is raised.
    #[test]
    fn sizes_grow_no_faster_than_allowed() {
        let mesh = block(4, 4, 4, 1.0, 1.0, 1.0, Order::Quadratic);
        let constant = SizeField::new(&mesh, &vec![0.25; mesh.cell_count()], 0.5, 0.3);
        assert!(constant.sizes.iter().all(|size| (size - 0.5).abs() < 1e-12));
        let mut lengths = vec![0.25; mesh.cell_count()];
        lengths[0] = 1e-6;
        let field = SizeField::new(&mesh, &lengths, 1.0, 0.3);
        assert_eq!(field.points.len(), 125);
        for cell in &field.cells {
            for [i, j] in CELL_EDGES {
                let (a, b) = (cell[i] as usize, cell[j] as usize);
                let apart: f64 = (0..3).map(|d| (field.points[a][d] - field.points[b][d]).powi(2)).sum::<f64>().sqrt();
                assert!((field.sizes[a] - field.sizes[b]).abs() <= 0.3 * apart * (1.0 + 1e-9));
            }
        }
        let least = field.sizes.iter().copied().fold(f64::INFINITY, smaller);
        assert!(least < 0.1 && field.sizes.iter().all(|size| *size <= 0.25 + 1e-12));
    }
}
