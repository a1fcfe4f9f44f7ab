//! Facts about the mesh of a scene that limit its numbers, as commands print them: nearly flat cells, thin walls of few cells, overlapping parts, narrow gaps
//! between parts, and parts that are joined only by edges or nodes.

use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::error::point;
use crate::mesh::gap::{Gap, gap};
use crate::mesh::hinge::{Hinge, hinge};
use crate::mesh::notch::{Notch, thinnest_below_notches};
use crate::mesh::overlap::overlap_of_parts;
use crate::mesh::quality::Quality;
use crate::mesh::wall::{ABOUT, LEAST_CELLS, SHARE, Wall, shows_bending, thinnest};
use crate::scene::body::mesh_spec::MeshSpec;
use crate::scene::build::Scene;
use crate::scene::build::shape::ShapeSpec;
use std::collections::BTreeSet;

/// The limits of the mesh of a scene in words, each with its kind: `warning` or `note`. Gaps between parts that contact keeps apart do not count.
pub fn limits_of_scene(scene: &Scene) -> Vec<(&'static str, String)> {
    let mesh = &scene.body.mesh;
    let is_kept_apart = scene.spec.contacts.iter().any(|c| matches!(c.obstacle, ShapeSpec::Region { .. }));
    let gap = if is_kept_apart { None } else { gap(mesh) };
    let held = held(scene);
    let notch = thinnest_below_notches(mesh, |node, axis| held.contains(&(3 * node + axis as u32)));
    limits(mesh, (wall(scene), notch), gap, &scene.spec.mesh)
}

/// The limits of a mesh without constraints in words, each with its kind: `warning` or `note`; `spec` is its `[mesh]` table.
pub fn limits_of_mesh(mesh: &TetMesh, spec: &MeshSpec) -> Vec<(&'static str, String)> {
    limits(mesh, (thinnest(mesh, |_, _| false), thinnest_below_notches(mesh, |_, _| false)), gap(mesh), spec)
}

/// The thinnest wall of the body. Planes of symmetry and clamped faces do not count as sides of a wall.
pub(crate) fn wall(scene: &Scene) -> Option<Wall> {
    *scene.wall.get_or_init(|| {
        let held = held(scene);
        thinnest(&scene.body.mesh, |node, axis| held.contains(&(3 * node + axis as u32)))
    })
}

/// Dofs that are prescribed.
fn held(scene: &Scene) -> BTreeSet<u32> {
    scene.system.prescribed.iter().map(|p| p.dof).collect()
}

fn limits(
    mesh: &TetMesh,
    (wall, notch): (Option<Wall>, Option<Notch>),
    gap: Option<Gap>,
    spec: &MeshSpec,
) -> Vec<(&'static str, String)> {
    // A volume mesh that is used as it is: nodes from other sources are not merged
    let is_volume_mesh = spec.file.is_some() && spec.cells.is_none() && spec.size.is_none();
    let is_thinner = |notch: &Notch| wall.is_none_or(|wall| ABOUT * notch.wall.thickness < wall.thickness);
    let notches =
        notch.filter(|notch| is_thinner(notch) && !shows_bending(notch.wall.cells)).map(|notch| of_notch(&notch));
    let walls = wall.filter(|wall| !shows_bending(wall.cells)).map(|wall| of_wall(wall, is_volume_mesh));
    let overlaps = overlap_of_parts(mesh).map(|at| of_overlap(&at));
    let warnings = of_cells(mesh).into_iter().chain(walls).chain(notches).chain(overlaps).map(|text| ("warning", text));
    let notes = gap.map(|gap| of_gap(&gap, is_volume_mesh)).into_iter().chain(hinge(mesh).map(of_hinge));
    warnings.chain(notes.map(|text| ("note", text))).collect()
}

fn of_cells(mesh: &TetMesh) -> Option<String> {
    let Quality { flat_cells, worst_cell, dihedral_min_deg, dihedral_max_deg, .. } = Quality::of(mesh);
    let cells = if flat_cells == 1 { "cell is" } else { "cells are" };
    let at = point(&mesh.position(worst_cell, [0.25; 3]));
    (flat_cells > 0).then(|| {
        format!(
            "{flat_cells} of {} {cells} nearly flat, with dihedral angles from {dihedral_min_deg:.2} to {dihedral_max_deg:.2} degrees, the worst at \
             {at}: stresses there say little, and equations are harder to solve; mesh the body anew, or with another size",
            mesh.cell_count()
        )
    })
}

fn of_wall(wall: Wall, is_volume_mesh: bool) -> String {
    let how = if is_volume_mesh { ": `levels = 1` splits each cell into eight" } else { "" };
    format!(
        "{:.1} cells across the thinnest wall, which is {:.4} mm thick, are too few to show how it bends (at least {LEAST_CELLS:.0}); refine the \
         walls{how}",
        wall.cells,
        wall.thickness * 1e3
    )
}

fn of_notch(notch: &Notch) -> String {
    format!(
        "{:.1} cells across the body below a notch at {}, where it is {:.4} mm thick and thinner than the thinnest wall over {:.0} % of its surface, are too few to show \
         how it bends (at least {LEAST_CELLS:.0}); refine the notches",
        notch.wall.cells,
        point(&notch.at),
        notch.wall.thickness * 1e3,
        100.0 * SHARE
    )
}

/// The overlap in words: facets of a pin and its hole that do not match overlap by the height of an arc.
fn of_overlap(at: &Vec3) -> String {
    format!(
        "two parts of the body both fill {}: their stiffness and mass count twice there, and no common facet joins them; unite them where the mesh \
         comes from, or move one of them",
        point(at)
    )
}

fn of_gap(gap: &Gap, is_volume_mesh: bool) -> String {
    // With four digits
    let mm = |length: f64| format!("{:.3e}", length * 1e3).parse().unwrap_or(length * 1e3);
    let how = match gap.distance > 1e-6 * gap.area.sqrt() {
        true => format!("face each other across a gap of up to {} mm", mm(gap.distance)),
        false => "touch".into(),
    };
    let sides = match (gap.pairs, gap.is_within_parts) {
        (1, true) => "two sides of one part of the body".into(),
        (1, false) => "two parts of the body".into(),
        (parts, true) => format!("sides of {parts} parts"),
        (pairs, false) => format!("{pairs} pairs of parts"),
    };
    let remedy = match gap.between_nodes.filter(|_| is_volume_mesh) {
        Some(between) => format!("merge = \"{} mm\" in [mesh] makes them one", mm(1.1 * between)),
        None => "make them one where the mesh comes from".into(),
    };
    format!(
        "{sides} {how} over {:.4} mm^2, at {}, and have no common facet there: nothing joins them; {remedy}, or declare a contact between them",
        gap.area * 1e6,
        point(&gap.at)
    )
}

fn of_hinge(hinge: Hinge) -> String {
    let nodes = if hinge.nodes == 1 { "one node".into() } else { format!("{} nodes", hinge.nodes) };
    format!(
        "{} parts of the body have {nodes} in common, as at {}, and no face: they turn about such places as about a hinge; give them \
         common faces where the mesh comes from, or move them apart",
        hinge.parts,
        point(&hinge.at)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hinge_is_told_with_its_place() {
        let told = |nodes| of_hinge(Hinge { parts: 2, nodes, at: Vec3::new(0.01, 0.01, 0.0) });
        assert!(
            told(1).starts_with("2 parts of the body have one node in common, as at (10, 10, 0) mm, and no face: ")
        );
        assert!(told(6).starts_with("2 parts of the body have 6 nodes in common, as at (10, 10, 0) mm"));
    }

    #[test]
    fn a_gap_is_told_with_its_sides() {
        let gap = |pairs, is_within_parts| Gap {
            pairs,
            is_within_parts,
            distance: 0.0,
            at: Vec3::new(0.03, 0.0, 0.0),
            area: 3.45e-4,
            between_nodes: None,
        };
        let told = |pairs, is_within_parts| of_gap(&gap(pairs, is_within_parts), true);
        let rest = " touch over 345.0000 mm^2, at (30, 0, 0) mm, and have no common facet there: nothing joins them; make them one where the mesh \
                    comes from, or declare a contact between them";
        for (pairs, is_within_parts, sides) in [
            (1, false, "two parts of the body"),
            (3, false, "3 pairs of parts"),
            (1, true, "two sides of one part of the body"),
            (2, true, "sides of 2 parts"),
        ] {
            assert_eq!(told(pairs, is_within_parts), format!("{sides}{rest}"));
        }
    }
}
