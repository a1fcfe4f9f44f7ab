//! The thinnest section below notches of a body, such as the hinges of a finger.
//!
//! Where two facets meet at a concave edge, a ray is cast inward from the middle of the edge along the mean of their normals to the opposite side.
//! The sides of a notch face that side too little, and are too small a share of the surface, to count as a wall. A section counts if the edges with a
//! thickness within a quarter of its own have a total length of at least its thickness.

use super::wall::{ABOUT, Side, Skin, Wall, mean_layers};
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use std::collections::HashMap;

/// Angle between facets above which the edge between them can be that of a notch \[rad\].
const TURN: f64 = 0.35;

/// The thinnest section below notches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notch {
    pub wall: Wall,
    /// Middle of the edge below which the section is thinnest \[m\]
    pub at: Vec3,
}

/// Returns the thinnest section below concave edges; `held` says whether the displacement of a node is prescribed along an axis.
pub fn thinnest_below_notches(mesh: &TetMesh, held: impl Fn(u32, usize) -> bool) -> Option<Notch> {
    let skin = Skin::new(mesh, held)?;
    let mut sides: Vec<Side> = concave_edges(mesh, &skin).into_iter().filter_map(|e| side(mesh, &skin, e)).collect();
    sides.sort_by(|a, b| a.thickness.total_cmp(&b.thickness));
    let as_thick = |thickness: f64| sides.partition_point(|s| s.thickness <= ABOUT * thickness);
    let is_long = |k: &usize| {
        let thickness = sides[*k].thickness;
        sides[*k..as_thick(thickness)].iter().map(|s| s.share).sum::<f64>() >= thickness
    };
    let first = (0..sides.len()).find(is_long)?;
    let (thickness, at) = (sides[first].thickness, sides[first].middle);
    let cells = mean_layers(mesh, &skin, &sides[first..as_thick(thickness)])?;
    Some(Notch { wall: Wall { thickness, cells }, at })
}

/// The ends of a concave edge between two facets, and the sum of their unit normals.
type Edge = ([u32; 2], Vec3);

/// Returns the concave edges in the order of the facets.
fn concave_edges(mesh: &TetMesh, skin: &Skin) -> Vec<Edge> {
    let (mut open, mut found): (HashMap<[u32; 2], usize>, Vec<Edge>) = (HashMap::new(), Vec::new());
    let normal = |k: usize| skin.normals[k].normalize();
    for (k, &[a, b, c]) in skin.facets.iter().enumerate() {
        for [from, to, opposite] in [[a, b, c], [b, c, a], [c, a, b]] {
            let ends = [from.min(to), from.max(to)];
            let Some(other) = open.remove(&ends) else {
                open.insert(ends, k);
                continue;
            };
            let above = (mesh.points[opposite as usize] - mesh.points[from as usize]).dot(&normal(other));
            let is_notch = above > 0.0 && normal(k).dot(&normal(other)) < TURN.cos();
            if is_notch && skin.free[k] && skin.free[other] {
                found.push((ends, normal(k) + normal(other)));
            }
        }
    }
    found
}

fn side(mesh: &TetMesh, skin: &Skin, ([a, b], sum): Edge) -> Option<Side> {
    let [p, q] = [a, b].map(|node| mesh.points[node as usize]);
    let (middle, share, normal) = ((p + q) * 0.5, (q - p).norm(), sum.try_normalize(1e-6)?);
    let thickness = skin.thickness(&middle, &normal, share)?;
    Some(Side { corners: [a, b, b], normal, middle, share, thickness })
}
