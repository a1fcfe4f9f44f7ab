//! Meshes of several bodies: images of one mesh, several meshes side by side, and which cells hang together.

use super::{Region, TetMesh};
use crate::math::tensor::{Mat3, Vec3};
use std::collections::BTreeMap;

impl TetMesh {
    /// The image under X ↦ A X + b, A orthogonal. A mirror image gets the other order of nodes, so that volumes stay positive.
    pub fn image(&self, a: &Mat3, b: &Vec3) -> Self {
        let mut image = self.clone();
        image.points.iter_mut().for_each(|p| *p = a * *p + b);
        if a.determinant() < 0.0 {
            let cells = image.cells.chunks_exact_mut(self.order.cell_nodes());
            cells.for_each(|cell| swap(cell, &[(1, 2), (4, 6), (8, 9)]));
            let facets = image.facets.chunks_exact_mut(self.order.facet_nodes());
            facets.for_each(|facet| swap(facet, &[(1, 2), (3, 5)]));
        }
        image
    }

    /// Meshes of one order as one mesh. A region R of the mesh named N becomes `N.R`; R itself holds those of all.
    pub fn side_by_side(named: &[(String, Self)]) -> Option<Self> {
        let mut whole = Self { regions: BTreeMap::new(), ..named.first()?.1.clone() };
        (whole.points, whole.cells, whole.facets) = (Vec::new(), Vec::new(), Vec::new());
        for (name, part) in named {
            let (cells, facets) = (whole.cell_count() as u32, whole.facet_count() as u32);
            let nodes = whole.points.len() as u32;
            for (region, list) in &part.regions {
                let moved = Region {
                    cells: list.cells.iter().map(|c| c + cells).collect(),
                    facets: list.facets.iter().map(|f| f + facets).collect(),
                    nodes: list.nodes.iter().map(|n| n + nodes).collect(),
                    depends_on_mesh: list.depends_on_mesh,
                };
                let all = whole.regions.entry(region.clone()).or_default();
                all.cells.extend(&moved.cells);
                all.facets.extend(&moved.facets);
                all.nodes.extend(&moved.nodes);
                all.depends_on_mesh |= moved.depends_on_mesh;
                whole.regions.insert(format!("{name}.{region}"), moved);
            }
            whole.points.extend(&part.points);
            whole.cells.extend(part.cells.iter().map(|n| n + nodes));
            whole.facets.extend(part.facets.iter().map(|n| n + nodes));
        }
        Some(whole)
    }

    /// [cells] the part that each belongs to, as a node of it: cells of one part are joined by common nodes.
    pub fn parts(&self) -> Vec<u32> {
        fn root(parent: &mut [u32], mut k: u32) -> u32 {
            while parent[k as usize] != k {
                parent[k as usize] = parent[parent[k as usize] as usize];
                k = parent[k as usize];
            }
            k
        }
        let mut parent: Vec<u32> = (0..self.points.len() as u32).collect();
        for cell in self.cells.chunks_exact(self.order.cell_nodes()) {
            for &node in &cell[1..] {
                let (a, b) = (root(&mut parent, cell[0]), root(&mut parent, node));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
        self.cells.chunks_exact(self.order.cell_nodes()).map(|cell| root(&mut parent, cell[0])).collect()
    }
}

/// Exchanges the pairs of places that the list has.
fn swap(list: &mut [u32], pairs: &[(usize, usize)]) {
    let n = list.len();
    pairs.iter().filter(|(_, b)| *b < n).for_each(|&(a, b)| list.swap(a, b));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::structured::block;
    use crate::mesh::validate::min_det;

    /// Volumes, outward normals and facets of cells survive a mirror and a turn; two images are two parts.
    #[test]
    fn images_are_sound() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(2, 2, 2, 0.2, 0.1, 0.1, order);
            mesh.distort(5, 0.1);
            let turn = nalgebra::Rotation3::from_euler_angles(0.4, 0.2, -0.7).into_inner();
            let mirror = Mat3::from_diagonal(&Vec3::new(-1.0, 1.0, 1.0));
            let away = Vec3::new(-0.3, 0.0, 0.0);
            let other = mesh.image(&(turn * mirror), &away);
            let named = [("a".to_string(), mesh.clone()), ("b".to_string(), other)];
            let whole = TetMesh::side_by_side(&named).expect("two meshes");
            assert!((0..whole.cell_count()).all(|c| min_det(&whole, c) > 0.0));
            assert!((whole.volume() / mesh.volume() - 2.0).abs() < 1e-13);
            let flux = |m: &TetMesh| -> f64 {
                let at = |f: usize| m.facet(f)[..3].iter().map(|&i| m.points[i as usize]).sum::<Vec3>() / 3.0;
                (0..m.facet_count()).map(|f| 0.5 * m.facet_normal(f, [1.0 / 3.0; 2]).dot(&at(f))).sum()
            };
            // Gauss: ∮ x·n dA = 3 V on flat facets.
            assert!((flux(&whole) / (3.0 * whole.volume()) - 1.0).abs() < 1e-12);
            assert_eq!(whole.boundary_facets().len(), 2 * mesh.boundary_facets().len());
            let area = |r: &str| whole.region_area(&whole.regions[r].facets);
            assert!((area("b.xmin") - area("a.xmin")).abs() < 1e-15);
            assert!((area("xmin") - 2.0 * area("a.xmin")).abs() < 1e-15);
            let parts = whole.parts();
            let half = mesh.cell_count();
            assert!(parts[..half].iter().all(|p| *p == 0));
            assert!(parts[half..].iter().all(|p| *p == mesh.points.len() as u32));
        }
    }
}
