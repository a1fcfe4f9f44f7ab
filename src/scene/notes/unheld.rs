//! Motions of the body that no prescribed displacement prevents.

use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::parts::parts;
use crate::scene::build::builder::Builder;
use nalgebra::{Matrix6, Vector6};
use std::collections::{BTreeMap, BTreeSet};

/// Ratio to the largest eigenvalue below which a motion is free \[–\]: about the square of the relative accuracy of positions with seven digits in a file.
const FREE: f64 = 1e-12;

/// Adds a note on how the body, or a part of it that shares no node with the others, can move in a static stage although some of the body is prescribed and
/// nothing else holds it. The free motions belong to the smallest eigenvalues of Σ mᵀm over the prescribed components, where m holds the six rigid motions
/// there.
pub(in crate::scene) fn note_free_motions(builder: &mut Builder) {
    let mesh = &builder.body.mesh;
    let is_static = builder.spans.iter().any(|span| span.integrator.is_static());
    let held: Vec<usize> = builder.held_dofs().filter(|&dof| (dof / 3) < mesh.points.len()).collect();
    if !is_static || held.is_empty() {
        return;
    }
    let mut nodes: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for (part, cell) in parts(mesh).into_iter().zip(mesh.cells.chunks_exact(mesh.order.cell_nodes())) {
        nodes.entry(part).or_default().extend(cell);
    }
    let is_one = nodes.len() == 1;
    let notes: Vec<String> = nodes.values().filter_map(|part| free_motions(mesh, part, &held, is_one)).collect();
    builder.notes.extend(notes);
}

/// The note on a part of the body, if it can move.
fn free_motions(mesh: &TetMesh, part: &BTreeSet<u32>, held: &[usize], is_one: bool) -> Option<String> {
    let middle = part.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>() / part.len() as f64;
    let size = mesh.diagonal();
    let motion = |&dof: &usize| {
        let arm = (mesh.points[dof / 3] - middle) / size;
        let turn = |axis: usize| Vec3::ith(axis, 1.0).cross(&arm)[dof % 3];
        Vector6::from_fn(|k, _| if k < 3 { f64::from(u8::from(k == dof % 3)) } else { turn(k - 3) })
    };
    let own = held.iter().filter(|dof| part.contains(&((**dof / 3) as u32)));
    let sum = own.map(motion).fold(Matrix6::zeros(), |sum: Matrix6<f64>, m| sum + m * m.transpose());
    let rounded = |v: &Vec3, factor: f64| [0, 1, 2].map(|k| (v[k] * factor * 1e3).round() / 1e3 + 0.0);
    let whole = sum.symmetric_eigen();
    let most = whole.eigenvalues.max();
    let free: Vec<usize> = (0..6).filter(|&k| whole.eigenvalues[k] <= FREE * most).collect();
    let [x, y, z] = rounded(&middle, 1e3);
    if most <= 0.0 {
        return Some(format!(
            "no constraint holds the part of the body around ({x}, {y}, {z}) mm, which shares no node with the others: unless springs do, its place is arbitrary in a static \
             stage; hold it, or join it to the others by `merge` of the mesh"
        ));
    }
    let vector = whole.eigenvectors.column(*free.first()?);
    let (along, about) = (vector.fixed_rows::<3>(0), vector.fixed_rows::<3>(3));
    let (words, direction) = if along.norm() > about.norm() { ("moves along", along) } else { ("turns about", about) };
    let [a, b, c] = rounded(&(direction / direction.norm()), 1.0);
    let (held, subject) = match is_one {
        true => ("what is held".to_string(), "the body"),
        false => (format!("what is held of the part around ({x}, {y}, {z}) mm"), "it"),
    };
    Some(format!(
        "{held} leaves {} of the six rigid motions free; in one {subject} {words} ({a}, {b}, {c}): in a static stage its place is arbitrary",
        free.len()
    ))
}
