//! The rim of an open cavity: planes of symmetry in which it slides, and caps across the parts of it that are held.

use crate::effect::{VolumeField, flux_through_cones, middle_of_edges};
use crate::math::disjoint_sets::DisjointSets;
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::scene::build::builder::Builder;
use std::collections::BTreeMap;

/// Coordinates of the planes x, y, z = const in which a rim slides \[m\].
pub(super) type Planes = [Vec<f64>; 3];

/// Rounding of positions relative to the size of the body \[–\].
const ROUNDING: f64 = 1e-9;
/// Rounding of a volume relative to that of the sphere with the area of the wall \[–\].
const NO_VOLUME: f64 = 1e-12;

/// The planes in which the parts of a rim slide that are not held. As an error, a point at which the rim is free, or is moved although it slides in several
/// planes, so that its volume is not defined. Like a plane of symmetry, each plane has all of its piece of the body on one side.
pub(super) fn rim_planes(builder: &Builder, mesh: &TetMesh, rim: &[Vec<u32>]) -> Result<Planes, Vec3> {
    let held = |node: u32, k: u32| builder.motion(3 * node + k);
    let is_moved = |node: u32| (0..3).any(|k| held(node, k).is_some_and(|motion| *motion != Signal::Constant(0.0)));
    let moved = rim.iter().flatten().find(|node| is_moved(**node)).map(|node| mesh.points[*node as usize]);
    let rounding = ROUNDING * mesh.diagonal();
    let mut ends_at = ends(mesh, rounding);
    let mut planes = Planes::default();
    for edge in rim {
        if edge.iter().all(|&node| builder.is_held(node)) {
            continue;
        }
        let at = mesh.points[edge[0] as usize];
        let mut in_plane = |k: &usize| {
            let flat = edge.iter().all(|&n| (mesh.points[n as usize][*k] - at[*k]).abs() <= rounding);
            let slides = || edge.iter().all(|&n| held(n, *k as u32) == Some(&Signal::Constant(0.0)));
            flat && slides() && ends_at(edge[0], *k)
        };
        let is_known = |k: usize| planes[k].iter().any(|level| (level - at[k]).abs() <= rounding);
        // An edge along two planes needs only one of them: a known one, or one that adds no parallel plane.
        let plane = (0..3).filter(&mut in_plane).min_by_key(|&k| if is_known(k) { 0 } else { 1 + planes[k].len() });
        let k = plane.ok_or(at)?;
        if !is_known(k) {
            planes[k].push(at[k]);
        }
    }
    match moved {
        Some(at) if planes.iter().map(Vec::len).sum::<usize>() > 1 => Err(at),
        _ => Ok(planes),
    }
}

/// Whether the piece of the body that contains a node ends at the position of this node along x, y or z.
fn ends(mesh: &TetMesh, rounding: f64) -> impl FnMut(u32, usize) -> bool + '_ {
    let mut pieces = DisjointSets::new(mesh.points.len());
    (0..mesh.cell_count()).for_each(|c| pieces.join(mesh.cell(c)));
    let mut extents = BTreeMap::<u32, [Vec3; 2]>::new();
    for (node, at) in (0..).zip(&mesh.points) {
        let [low, high] = extents.entry(pieces.first(node)).or_insert([*at; 2]);
        (*low, *high) = (low.inf(at), high.sup(at));
    }
    move |node, k| {
        let (at, extent) = (mesh.points[node as usize][k], &extents[&pieces.first(node)]);
        extent.iter().any(|end| (end[k] - at).abs() <= rounding)
    }
}

/// The components in which a point lies in one of these planes, with the coordinates of the planes.
fn levels_at(planes: &Planes, at: Vec3, rounding: f64) -> impl Iterator<Item = (usize, f64)> {
    let of =
        move |k: usize| planes[k].iter().find(|level| (**level - at[k]).abs() <= rounding).map(|level| (k, *level));
    (0..3).filter_map(of)
}

/// Whether all of the rim lies in these planes; true for a closed wall, which has no rim.
pub(super) fn is_in_planes(mesh: &TetMesh, rim: &[Vec<u32>], planes: &Planes) -> bool {
    let rounding = ROUNDING * mesh.diagonal();
    rim.iter().flatten().all(|&node| levels_at(planes, mesh.points[node as usize], rounding).next().is_some())
}

/// The volume \[m³\] that the cones of a field over caps add to the volume that the field measures at a wall of this `area` \[m²\]. The cap across a held part
/// of the rim consists of the cones from the centroid of the part. A part that ends in planes is closed by them, and its cap extends to them.
pub(super) fn caps(
    builder: &Builder,
    mesh: &TetMesh,
    rim: &[Vec<u32>],
    (planes, field, area): (&Planes, &VolumeField, f64),
) -> f64 {
    let rounding = ROUNDING * mesh.diagonal();
    let in_plane = |edge: &[u32], k: usize| {
        let is_on = |&n: &u32| levels_at(planes, mesh.points[n as usize], rounding).any(|(other, _)| other == k);
        edge.iter().all(is_on)
    };
    let needs_cap = |edge: &&Vec<u32>| edge.iter().all(|&n| builder.is_held(n)) && !(0..3).any(|k| in_plane(edge, k));
    let held: Vec<&Vec<u32>> = rim.iter().filter(needs_cap).collect();
    let mut sets = DisjointSets::new(mesh.points.len());
    held.iter().for_each(|edge| sets.join(edge));
    let mut parts = BTreeMap::<u32, Vec<&Vec<u32>>>::new();
    for edge in held {
        parts.entry(sets.first(edge[0])).or_default().push(edge);
    }
    let of_part = |part: &Vec<&Vec<u32>>| {
        let mut middle = middle_of_edges(mesh, part)?;
        let ends = part.iter().flat_map(|edge| &edge[..2]);
        let is_end = |node: &&u32| part.iter().filter(|edge| edge[..2].contains(node)).count() == 1;
        for &node in ends.filter(is_end) {
            levels_at(planes, mesh.points[node as usize], rounding).for_each(|(k, level)| middle[k] = level);
        }
        Some(flux_through_cones(mesh, part, middle, field))
    };
    let volume: f64 = parts.values().filter_map(of_part).sum();
    if volume.abs() > NO_VOLUME * area.powf(1.5) { volume } else { 0.0 }
}
