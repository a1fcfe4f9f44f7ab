//! Columns that are the displacement of a place that its cell does not resolve: next to a singular edge, or at a patch smaller than the cell through which a
//! force acts.
//!
//! Under a force on a patch of radius R a displacement varies as 1/R, but as 1/h if the cell size h is larger: a smaller cell reveals only a small part of the
//! difference.

use super::enrichment::EnrichedScene;
use super::indicators::gradients;
use super::singular_edge::singular_corners;
use crate::scene::Scene;
use crate::scene::spec::EffectSpec;
use crate::system::Dofs;
use std::collections::BTreeSet;

/// Whether each column is the displacement of a place in such a cell, as far as it is not prescribed \[columns\]; `memory`: the memory of the recorders.
pub(super) fn unresolved_columns(scene: &Scene, enriched: &EnrichedScene, memory: &[f64]) -> Vec<bool> {
    let mesh = &scene.body.mesh;
    let corners = singular_corners(enriched.raised().unwrap_or(scene));
    let patches = patches(scene);
    let is_coarse = |&c: &usize| {
        let (cell, size) = (mesh.cell(c), mesh.cell_volume(c).cbrt());
        let is_around =
            |(radius, nodes): &(f64, BTreeSet<u32>)| *radius < size && cell.iter().all(|k| nodes.contains(k));
        cell[..4].iter().any(|node| corners.contains(node)) || patches.iter().any(is_around)
    };
    let near: Vec<&[u32]> = (0..mesh.cell_count()).filter(is_coarse).map(|c| mesh.cell(c)).collect();
    let is_free = |dof: u32| scene.system.dofs.equation[dof as usize] != Dofs::FIXED;
    let is_near = |x: &[(u32, f64)]| {
        let nodes: BTreeSet<u32> =
            x.iter().filter(|(dof, w)| *w != 0.0 && is_free(*dof)).map(|(dof, _)| dof / 3).collect();
        !nodes.is_empty() && near.iter().any(|cell| nodes.iter().all(|node| cell.contains(node)))
    };
    let all = gradients(scene, &scene.system.rest(), memory);
    all.iter().map(|own| own.as_ref().is_some_and(|own| own.reaction.is_empty() && is_near(&own.x))).collect()
}

/// The patches through which forces and cables act: their radii \[m\], and the nodes of the cells that they overlap.
fn patches(scene: &Scene) -> Vec<(f64, BTreeSet<u32>)> {
    let Scene { body, spec, cables, .. } = scene;
    let of_force = |(at, radius)| Some((radius, body.patches.weights(&body.mesh, at, radius).ok()?));
    let forces = spec.effects.iter().filter_map(EffectSpec::ball).filter_map(of_force);
    let balls = cables.iter().filter_map(|of| of.guide_radius.map(|radius| (radius, of.cable.means().lists())));
    let guides = balls.flat_map(|(radius, lists)| lists.iter().map(move |list| (radius, list.clone())));
    forces.chain(guides).map(|(radius, list)| (radius, list.into_iter().map(|(node, _)| node).collect())).collect()
}
