//! Motions of the body that nothing prescribed holds.

use super::builder::Builder;
use crate::math::tensor::Vec3;
use crate::mesh::parts::parts;
use nalgebra::{Matrix6, Vector6};

/// Share of the largest eigenvalue below which a motion is free \[–\]: the square of the seven digits that positions in a file have.
const FREE: f64 = 1e-12;

/// Notes that the body, in one part and with nothing else to hold it, may move in a static stage although some of it is prescribed: the least eigenvalues of
/// Σ mᵀm over the prescribed components, m the six rigid motions there.
pub(super) fn note_free_motions(builder: &mut Builder) {
    let mesh = &builder.body.mesh;
    let is_static = builder.spans.iter().any(|span| span.integrator.is_static());
    let held = builder.held_dofs().filter(|&dof| (dof / 3) < mesh.points.len());
    let (middle, size) = (mesh.points.iter().sum::<Vec3>() / mesh.points.len() as f64, mesh.diagonal());
    let motion = |dof: usize| {
        let arm = (mesh.points[dof / 3] - middle) / size;
        let turn = |axis: usize| Vec3::ith(axis, 1.0).cross(&arm)[dof % 3];
        Vector6::from_fn(|k, _| if k < 3 { f64::from(u8::from(k == dof % 3)) } else { turn(k - 3) })
    };
    let sum = held.map(motion).fold(Matrix6::zeros(), |sum: Matrix6<f64>, m| sum + m * m.transpose());
    let whole = sum.symmetric_eigen();
    let most = whole.eigenvalues.max();
    let free: Vec<usize> = (0..6).filter(|&k| whole.eigenvalues[k] <= FREE * most).collect();
    let (Some(&first), true) = (free.first(), is_static && most > 0.0) else { return };
    if parts(mesh).iter().any(|part| *part != 0) {
        return;
    }
    let vector = whole.eigenvectors.column(first);
    let (along, about) = (vector.fixed_rows::<3>(0), vector.fixed_rows::<3>(3));
    let (words, direction) = if along.norm() > about.norm() { ("moves along", along) } else { ("turns about", about) };
    let direction = direction / direction.norm();
    let [x, y, z] = [0, 1, 2].map(|k| (direction[k] * 1e3).round() / 1e3 + 0.0);
    builder.notes.push(format!(
        "what is held leaves {} of the six rigid motions free; in one the body {words} ({x}, {y}, {z}): in a static stage its place is arbitrary, and instability may be \
         reported that is none",
        free.len()
    ));
}
