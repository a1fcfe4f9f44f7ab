//! Kinds of volume cells in files, and the division of hexahedra, wedges and pyramids into tetrahedra.
//!
//! A cell is divided from the node with the smallest number: its faces that do not contain this node are cut into triangles, quadrilaterals along the
//! diagonal through their smallest node, and each triangle is joined with it. Cells that share a quadrilateral thus cut it along the same diagonal
//! (Dompierre, Labbé, Vallet & Camarero, "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 1999).

/// A kind of volume cell that a file may contain.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Solid {
    Tet4,
    Tet10,
    Pyramid,
    Wedge,
    Hexahedron,
}

impl Solid {
    /// Name of the kind in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet4 => "4-node tetrahedra",
            Self::Tet10 => "10-node tetrahedra",
            Self::Pyramid => "5-node pyramids",
            Self::Wedge => "6-node prisms",
            Self::Hexahedron => "8-node hexahedra",
        }
    }

    /// Number of nodes.
    pub fn nodes(self) -> usize {
        match self {
            Self::Tet4 => 4,
            Self::Tet10 => 10,
            Self::Pyramid => 5,
            Self::Wedge => 6,
            Self::Hexahedron => 8,
        }
    }

    /// Faces by their corners, in the node order shared by VTK, gmsh and Abaqus.
    pub fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tet4 | Self::Tet10 => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]],
            Self::Pyramid => &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
            Self::Wedge => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
            Self::Hexahedron => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
        }
    }

    /// Divides a cell with these nodes into tetrahedra: two for a pyramid, three for a wedge, six for a hexahedron. Their orientation is that of the
    /// cell.
    pub fn divide(self, nodes: &[u32]) -> Vec<[u32; 4]> {
        let first = *nodes.iter().min().expect("a cell has nodes");
        let corners = self.faces().iter().map(|face| face.iter().map(|&k| nodes[k]).collect::<Vec<_>>());
        let opposite = corners.filter(|face| !face.contains(&first));
        // Faces are oriented outward: seen from the first node their corners run clockwise
        opposite.flat_map(|face| triangles(&face)).map(|[a, b, c]| [a, c, b, first]).collect()
    }
}

/// Returns a triangle itself, or the two triangles of a quadrilateral, cut along the diagonal through its smallest node; the orientation is
/// preserved.
pub fn triangles(face: &[u32]) -> Vec<[u32; 3]> {
    let [a, b, c, ..] = *face else { return vec![] };
    let Some(&d) = face.get(3) else { return vec![[a, b, c]] };
    if a.min(c) < b.min(d) { vec![[a, b, c], [a, c, d]] } else { vec![[b, c, d], [b, d, a]] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tensor::Vec3;
    use std::collections::HashMap;

    const WEDGE: [[f64; 3]; 6] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [0., 1., 1.]];
    const PYRAMID: [[f64; 3]; 5] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 0.5, 1.]];
    const CUBE: [[f64; 3]; 8] = [
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 1., 0.],
        [0., 1., 0.],
        [0., 0., 1.],
        [1., 0., 1.],
        [1., 1., 1.],
        [0., 1., 1.],
    ];

    /// Any numbering of the nodes gives tetrahedra of positive volume that fill the cell, with no face twice on one side.
    #[test]
    fn every_numbering_fills_the_cell_with_positive_tetrahedra() {
        for (solid, points, volume, count) in [
            (Solid::Wedge, &WEDGE[..], 0.5, 3),
            (Solid::Pyramid, &PYRAMID[..], 1.0 / 3.0, 2),
            (Solid::Hexahedron, &CUBE[..], 1.0, 6),
        ] {
            let n = solid.nodes();
            let mut numbers: Vec<u32> = (0..n as u32).collect();
            // Heap's algorithm
            let mut c = vec![0; n];
            let mut i = 0;
            loop {
                let at = |k: u32| Vec3::from(points[numbers.iter().position(|&m| m == k).expect("a number")]);
                let tets = solid.divide(&numbers);
                assert_eq!(tets.len(), count);
                let mut sum = 0.0;
                let mut faces: HashMap<Vec<u32>, u32> = HashMap::new();
                for t in tets {
                    let [p, q, r, s] = t.map(at);
                    let v = (q - p).cross(&(r - p)).dot(&(s - p)) / 6.0;
                    assert!(v > 0.01, "{solid:?} {numbers:?}: {t:?} has volume {v}");
                    sum += v;
                    for skip in 0..4 {
                        let mut face: Vec<u32> = (0..4).filter(|k| *k != skip).map(|k| t[k]).collect();
                        face.sort_unstable();
                        *faces.entry(face).or_default() += 1;
                    }
                }
                assert!((sum - volume).abs() < 1e-12);
                // The outer faces are those of the rule for quadrilaterals, which depends on the face alone.
                let mut outer: Vec<Vec<u32>> = faces.into_iter().filter(|f| f.1 == 1).map(|f| f.0).collect();
                let cut = |face: &&[usize]| triangles(&face.iter().map(|&k| numbers[k]).collect::<Vec<_>>());
                let mut wanted: Vec<Vec<u32>> = solid.faces().iter().flat_map(cut).map(|t| t.to_vec()).collect();
                wanted.iter_mut().for_each(|t| t.sort_unstable());
                outer.sort();
                wanted.sort();
                assert_eq!(outer, wanted, "{solid:?} {numbers:?}");
                while i < n && c[i] >= i {
                    c[i] = 0;
                    i += 1;
                }
                if i == n {
                    break;
                }
                numbers.swap(if i % 2 == 0 { 0 } else { c[i] }, i);
                c[i] += 1;
                i = 0;
            }
        }
    }
}
