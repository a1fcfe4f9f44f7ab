//! Notes on the positions of a cable: a pull point inside the body, and guides whose patches reach across a gap or are cut by a plane of symmetry.

use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::embed::embed;
use crate::mesh::error::point;
use crate::scene::build::builder::Builder;
use crate::scene::parts::constraints::cable::record::NamedCable;
use crate::scene::parts::patch::note_cut;
use crate::wording::few;
use std::collections::BTreeSet;

/// Share of a patch across a gap below which there is no note \[–\].
const LITTLE: f64 = 0.01;

/// Adds notes on doubtful positions of cables.
pub(in crate::scene) fn note_places(builder: &mut Builder, cables: &[NamedCable]) {
    let notes: Vec<String> =
        cables.iter().flat_map(|cable| inside(builder, cable).into_iter().chain(across(builder, cable))).collect();
    builder.notes.extend(notes);
    for cable in cables {
        let ball = |(k, at, _): (usize, &Vec3, _)| (format!("guide {}", k + 1), *at);
        let balls: Vec<(String, Vec3)> = guides(cable).map(ball).collect();
        cable.guide_radius.iter().for_each(|radius| note_cut(builder, &cable.name, "guide_radius", *radius, &balls));
    }
}

/// Guides of a cable: number from 0, position and weights. Rings have no weights and are not counted.
fn guides(NamedCable { cable, .. }: &NamedCable) -> impl Iterator<Item = (usize, &Vec3, &Vec<(u32, f64)>)> {
    let all = cable.path().1.iter().zip(cable.means().lists());
    all.filter(|(_, list)| !list.is_empty()).enumerate().map(|(k, (at, list))| (k, at, list))
}

/// The note on a pull point that the body surrounds but does not carry.
fn inside(builder: &Builder, NamedCable { name, cable, .. }: &NamedCable) -> Option<String> {
    let at = cable.path().0?;
    let found = embed(&builder.body.mesh, at).ok()?;
    let is_held = |(node, weight): &(u32, f64)| weight.abs() < 1e-9 || builder.is_held(*node);
    if found.weights.iter().all(is_held) {
        return None;
    }
    Some(format!(
        "{name}: the pull point at {} lies in the body, which moves through it: it is fixed in space; move it out of the body, or let it move with the body \
         (pull_point = \"moving\")",
        point(&at)
    ))
}

/// The note on guides whose patches cover parts of the body on both sides of a gap.
fn across(builder: &Builder, named: &NamedCable) -> Option<String> {
    let (mesh, name) = (&builder.body.mesh, &named.name);
    let shares = guides(named).filter_map(|(k, at, list)| {
        let share = beyond(mesh, embed(mesh, *at).ok()?.cell, list);
        (share > LITTLE).then(|| format!("guide {} at {} ({:.0} %)", k + 1, point(at), 100.0 * share))
    });
    let shares: Vec<String> = shares.collect();
    (!shares.is_empty()).then(|| {
        format!(
            "{name}: guides whose patches reach across a gap: {}, each with the share of the patch there; nothing within it joins both sides, and the cable holds them together; \
             take a smaller guide_radius unless the gap is closed",
            few(&shares)
        )
    })
}

/// Share of the weights of a patch on nodes that no cells of the patch connect to the cell of its centre.
fn beyond(mesh: &TetMesh, home: u32, list: &[(u32, f64)]) -> f64 {
    let patch: BTreeSet<u32> = list.iter().map(|(node, _)| *node).collect();
    let is_within = |cell: &&[u32]| cell.iter().all(|node| patch.contains(node));
    let cells: Vec<&[u32]> = (0..mesh.cell_count()).map(|c| mesh.cell(c)).filter(is_within).collect();
    let mut joined: BTreeSet<u32> = mesh.cell(home as usize).iter().copied().collect();
    let mut before = 0;
    while joined.len() > before {
        before = joined.len();
        for cell in &cells {
            if cell.iter().any(|node| joined.contains(node)) {
                joined.extend(*cell);
            }
        }
    }
    let size = |other: bool| -> f64 {
        list.iter().filter(|(node, _)| !(other && joined.contains(node))).map(|(_, weight)| weight.abs()).sum()
    };
    size(true) / size(false)
}
