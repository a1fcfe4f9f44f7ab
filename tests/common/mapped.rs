//! Nodes of curved meshes by their place.

use durometer::math::tensor::Vec3;
use durometer::mesh::TetMesh;

/// Nodes on the surface at which `on` holds.
pub fn surface_nodes(mesh: &TetMesh, on: impl Fn(Vec3) -> bool) -> Vec<u32> {
    super::surface(mesh).into_iter().filter(|&k| on(mesh.points[k as usize])).collect()
}
