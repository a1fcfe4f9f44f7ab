//! Assigns the triangles of a closed surface to sheets: two triangles that meet at a sharp concave edge are on different sheets.
//!
//! Triangles are joined over all other edges, the flattest first, unless this would join both sides of a sharp concave edge: a sheet that has to end
//! elsewhere thus ends at the sharpest of the possible edges. A side at which a concave edge ends, such as the front of a block with a groove, has
//! edges with both sides of the concave edge and is joined to neither: otherwise one sheet would border both sides of the groove, and a point would
//! be in contact only with the nearer one.
//!
//! The joined groups are numbered one by one, the group with the most concave edges first: each gets the lowest number not used by a group from which
//! it must be separate. As long as there are few sheets, opposite walls of a slot are also on different sheets, because a ball may be in contact with
//! both.

use crate::math::boxes::from_parry;
use crate::math::tensor::Vec3;
use parry3d_f64::shape::TriMesh;
use std::collections::{BTreeMap, BTreeSet};

/// Smallest angle between the sides of a concave edge that is not a facet edge of a smooth hollow \[rad\].
const HOLLOW: f64 = 0.35;

/// Number of sheets up to which two sides that adjoin the same side, such as the walls of a slot, are on different sheets \[–\].
const FEW: usize = 4;
/// Difference between angles that counts as rounding \[rad\].
const SAME: f64 = 1e-6;

/// The triangle to the left of each directed edge.
pub(super) type Neighbours = BTreeMap<(u32, u32), u32>;

/// An edge between two triangles.
struct Edge {
    triangles: [usize; 2],
    angle: f64,
    /// Whether it is sharp and concave
    is_cut: bool,
}

impl Edge {
    fn is_smooth(&self) -> bool {
        self.angle <= HOLLOW
    }
}

/// Groups of triangles, each named after one of them.
struct Groups {
    /// \[triangles\] another triangle of the same group; the triangle itself if the group is named after it
    of: Vec<usize>,
    /// \[names\] groups that it meets at a sharp concave edge
    met: Vec<BTreeSet<usize>>,
    /// \[names\] groups that adjoin it over an edge that is not smooth
    next: Vec<BTreeSet<usize>>,
    /// \[names\] groups that must be on other sheets
    apart: Vec<BTreeSet<usize>>,
}

impl Groups {
    /// Each triangle as a separate group.
    fn new(n: usize, cuts: &[Edge], joints: &[Edge]) -> Self {
        let links = |edges: &mut dyn Iterator<Item = &Edge>| {
            let mut of = vec![BTreeSet::new(); n];
            for [one, other] in edges.map(|edge| edge.triangles) {
                of[one].insert(other);
                of[other].insert(one);
            }
            of
        };
        let met = links(&mut cuts.iter());
        let next = links(&mut joints.iter().filter(|edge| !edge.is_smooth()));
        Self { of: (0..n).collect(), apart: met.clone(), met, next }
    }

    fn name(&mut self, mut t: usize) -> usize {
        while self.of[t] != t {
            self.of[t] = self.of[self.of[t]];
            t = self.of[t];
        }
        t
    }

    /// Merges the groups on both sides of an edge, unless they are or have to be separate.
    fn join(&mut self, edge: &Edge) {
        let [mut one, mut other] = edge.triangles.map(|t| self.name(t));
        if one == other || self.apart[one].contains(&other) {
            return;
        }
        let is_between = !self.met[one].is_disjoint(&self.next[other]) || !self.met[other].is_disjoint(&self.next[one]);
        if is_between && !edge.is_smooth() {
            self.apart[one].insert(other);
            self.apart[other].insert(one);
            return;
        }
        // The group with fewer links is merged into the other.
        let others = |name: usize| self.met[name].len() + self.next[name].len() + self.apart[name].len();
        if (others(one), other) > (others(other), one) {
            std::mem::swap(&mut one, &mut other);
        }
        self.of[one] = other;
        for links in [&mut self.met, &mut self.next, &mut self.apart] {
            for third in std::mem::take(&mut links[one]) {
                links[third].remove(&one);
                if third != other {
                    links[third].insert(other);
                    links[other].insert(third);
                }
            }
        }
    }
}

/// Groups and sheets of all triangles.
pub(super) struct SheetNumbers {
    /// \[triangles\] name of its group
    pub groups: Vec<usize>,
    /// \[triangles\] whether its group has a sharp concave edge
    pub concave: Vec<bool>,
    /// \[triangles\] index of its sheet
    pub sheets: Vec<usize>,
    pub count: usize,
}

impl SheetNumbers {
    pub fn of(mesh: &TriMesh, normals: &[Vec3], neighbours: &Neighbours) -> Self {
        let (cuts, mut joints): (Vec<Edge>, Vec<Edge>) =
            edges(mesh, normals, neighbours).into_iter().partition(|edge| edge.is_cut);
        joints.sort_by(|a, b| (a.angle / SAME).round().total_cmp(&(b.angle / SAME).round()));
        let mut groups = Groups::new(normals.len(), &cuts, &joints);
        joints.iter().for_each(|edge| groups.join(edge));
        let names: Vec<usize> = (0..normals.len()).map(|t| groups.name(t)).collect();
        let mut order: Vec<usize> = (0..names.len()).filter(|&t| names[t] == t).collect();
        order.sort_by_key(|&name| (std::cmp::Reverse(groups.met[name].len()), name));
        let mut numbers = BTreeMap::<usize, usize>::new();
        for name in order {
            let of = |others: &mut dyn Iterator<Item = &usize>| -> BTreeSet<usize> {
                others.filter_map(|other| numbers.get(other)).copied().collect()
            };
            let taken = of(&mut groups.apart[name].iter());
            let opposite = of(&mut groups.met[name].iter().flat_map(|met| &groups.met[*met]));
            let is_free = |k: &usize| !taken.contains(k);
            let best = (0..FEW).find(|k| is_free(k) && !opposite.contains(k));
            numbers.insert(name, best.or_else(|| (0..).find(is_free)).expect("one is left"));
        }
        let sheets: Vec<usize> = names.iter().map(|name| numbers[name]).collect();
        let concave = names.iter().map(|&name| !groups.met[name].is_empty()).collect();
        let count = numbers.values().max().map_or(1, |most| most + 1);
        Self { groups: names, concave, sheets, count }
    }
}

fn edges(mesh: &TriMesh, normals: &[Vec3], neighbours: &Neighbours) -> Vec<Edge> {
    let edge = |(&(i, j), &one): (&(u32, u32), &u32)| {
        let other = *neighbours.get(&(j, i)).filter(|_| i < j)?;
        let triangles = [one, other].map(|t| t as usize);
        let angle = normals[triangles[0]].angle(&normals[triangles[1]]);
        Some(Edge { triangles, angle, is_cut: is_sharp_and_concave(mesh, normals, triangles, i) })
    };
    neighbours.iter().filter_map(edge).collect()
}

/// Whether the edge between two triangles, of which `on` is a vertex, is sharp and concave.
pub(super) fn is_sharp_and_concave(mesh: &TriMesh, normals: &[Vec3], [one, other]: [usize; 2], on: u32) -> bool {
    let vertex = |k: u32| from_parry(mesh.vertices()[k as usize]);
    let beyond: Vec3 = mesh.indices()[other].iter().map(|&k| vertex(k) - vertex(on)).sum();
    normals[one].angle(&normals[other]) > HOLLOW && beyond.dot(&normals[one]) > 0.0
}
