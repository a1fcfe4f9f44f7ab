//! The boundary of a mesh: faces that belong to only one cell.

use crate::mesh::TetMesh;
use crate::mesh::element::CELL_FACES;
use rustc_hash::{FxBuildHasher, FxHashMap};

/// Faces of all cells by their sorted corners: (first cell, its local face, number of cells).
pub(in crate::mesh) struct Faces(pub(in crate::mesh) FxHashMap<[u32; 3], (u32, u8, u8)>);

impl Faces {
    /// Collects the faces; returns a cell as an error if one of its faces belongs to three cells.
    pub(in crate::mesh) fn of(mesh: &TetMesh) -> Result<Self, usize> {
        let mut faces = FxHashMap::with_capacity_and_hasher(mesh.cell_count() * 5 / 2, FxBuildHasher);
        for c in 0..mesh.cell_count() {
            for (f, face) in CELL_FACES.iter().enumerate() {
                let key = sorted([0, 1, 2].map(|k| mesh.cell(c)[face[k]]));
                let entry = faces.entry(key).or_insert((c as u32, f as u8, 0u8));
                entry.2 += 1;
                if entry.2 > 2 {
                    return Err(c);
                }
            }
        }
        Ok(Self(faces))
    }

    /// Returns two cells that share a face and lie on the same side of it, so that they overlap; all volumes are positive.
    pub(in crate::mesh) fn overlap(&self, mesh: &TetMesh) -> Option<[usize; 2]> {
        let corners = |c: usize, face: usize| [0, 1, 2].map(|k| mesh.cell(c)[CELL_FACES[face][k]]);
        let mut faces = (0..mesh.cell_count()).flat_map(|c| (0..CELL_FACES.len()).map(move |face| (c, face)));
        faces.find_map(|(c, face)| {
            let [i, j, k] = corners(c, face);
            let &(first, other, _) = self.0.get(&sorted([i, j, k]))?;
            let outward = corners(first as usize, other as usize);
            let is_same = [[i, j, k], [j, k, i], [k, i, j]].contains(&outward);
            (first as usize != c && is_same).then_some([first as usize, c])
        })
    }
}

/// Appends local face `face` of `cell`, oriented outward from that cell.
pub(in crate::mesh) fn push_facet(mesh: &mut TetMesh, cell: u32, face: u8) -> u32 {
    let count = mesh.order.facet_nodes();
    let nodes: Vec<u32> = CELL_FACES[face as usize][..count].iter().map(|&k| mesh.cell(cell as usize)[k]).collect();
    mesh.facets.extend(nodes);
    (mesh.facet_count() - 1) as u32
}

/// Appends the boundary faces that are not `known`, in the order of cells.
pub(in crate::mesh) fn push_boundary(mesh: &mut TetMesh, faces: &Faces, known: impl Fn(&[u32; 3]) -> bool) {
    let mut rest: Vec<(u32, u8)> =
        faces.0.iter().filter(|(key, v)| v.2 == 1 && !known(key)).map(|(_, v)| (v.0, v.1)).collect();
    rest.sort_unstable();
    rest.into_iter().for_each(|(cell, face)| {
        push_facet(mesh, cell, face);
    });
}

/// The corners of a face in ascending order, its key.
pub(in crate::mesh) fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// Sets the facets to the whole boundary, in the order of cells. Existing facets are dropped.
pub(crate) fn add_boundary(mesh: &mut TetMesh) {
    mesh.facets.clear();
    let faces = Faces::of(mesh).expect("a mesh made here has at most two cells at a face");
    push_boundary(mesh, &faces, |_| false);
}

/// Returns, for each facet, the cell from which it is oriented outward, and whether it is inside the body (between two regions).
pub fn facet_cells(mesh: &TetMesh) -> Vec<(u32, bool)> {
    let faces = Faces::of(mesh).expect("a checked mesh has at most two cells at a face");
    let cell = |f: usize| {
        let key = sorted([0, 1, 2].map(|k| mesh.facet(f)[k]));
        let &(cell, _, count) = faces.0.get(&key).expect("a facet is a face of a cell");
        (cell, count == 2)
    };
    (0..mesh.facet_count()).map(cell).collect()
}

/// Returns the facets on the surface of the body, without those between two regions.
pub fn boundary_facets(mesh: &TetMesh) -> Vec<u32> {
    let inside = facet_cells(mesh);
    (0..mesh.facet_count() as u32).filter(|&f| !inside[f as usize].1).collect()
}
