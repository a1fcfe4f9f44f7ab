//! Sharp edges of a body that its mesh cuts off.

use crate::mesh::TetMesh;
use crate::mesh::wall::thinnest;

/// Distance between the sharp edges of a body and its mesh, relative to the thinnest wall, above which the walls of the mesh are not those of the body \[–\]
const CUT: f64 = 0.1;

/// The warning about a mesh that is up to `off` \[m\] away from the sharp edges of its body.
pub(in crate::scene) fn cut_edges(mesh: &TetMesh, off: f64) -> Option<String> {
    let wall = thinnest(mesh, |_, _| false).filter(|wall| off > CUT * wall.thickness)?;
    Some(format!(
        "sharp edges of the body are cut by up to {:.4} mm, {:.0} % of the thinnest wall of {:.4} mm: walls and hollows have other shapes, also where the volume agrees; \
         take generator = \"gmsh\" if it can mesh the body, or more cells",
        off * 1e3,
        100.0 * off / wall.thickness,
        wall.thickness * 1e3
    ))
}
