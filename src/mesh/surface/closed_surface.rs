//! Closed surfaces from files: seams are joined, triangles are oriented outward, and surfaces are matched with facets of a mesh.

use super::boundary::{boundary_facets, sorted};
use super::distance::Nearest;
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::file::surface_file::Surface;
use crate::mesh::{Order, TetMesh};
use std::collections::{BTreeMap, HashMap};

/// Distance within which vertices of a surface are merged, relative to its diagonal \[–\]: files in single precision round by 6e-8.
const SEAM: f64 = 1e-6;

/// Error for a surface that encloses no volume, with a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotClosed {
    /// Edges that belong to an odd number of triangles
    pub edges: usize,
    /// Middle of one of these edges, or of an edge at which the triangles cannot be oriented consistently \[m\]
    pub at: Vec3,
}

/// Returns the triangles of a closed surface, with the vertices of the given one; each piece is oriented outward from the volume that it encloses.
pub fn closed(surface: &Surface) -> Result<Vec<[u32; 3]>, NotClosed> {
    let joined = joined(surface);
    let mut triangles: Vec<[u32; 3]> = surface.triangles.iter().map(|t| t.map(|k| joined[k as usize])).collect();
    // A degenerate triangle connects nothing
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let mut edges: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (t, corners) in triangles.iter().enumerate() {
        sides(corners).for_each(|[a, b]| edges.entry([a.min(b), a.max(b)]).or_default().push(t));
    }
    let middle = |[a, b]: [u32; 2]| (surface.points[a as usize] + surface.points[b as usize]) * 0.5;
    let odd: Vec<[u32; 2]> = edges.iter().filter(|(_, of)| of.len() % 2 == 1).map(|(edge, _)| *edge).collect();
    if let Some(&first) = odd.first() {
        return Err(NotClosed { edges: odd.len(), at: middle(first) });
    }
    for piece in turned(&mut triangles, &edges) {
        let origin = surface.points[triangles[piece[0]][0] as usize];
        let cone = |&t: &usize| {
            let [a, b, c] = triangles[t].map(|k| surface.points[k as usize] - origin);
            a.dot(&b.cross(&c))
        };
        if piece.iter().map(cone).sum::<f64>() < 0.0 {
            piece.iter().for_each(|&t| triangles[t].swap(1, 2));
        }
    }
    let mut balance: HashMap<[u32; 2], i32> = HashMap::new();
    for [a, b] in triangles.iter().flat_map(sides) {
        *balance.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
    }
    match edges.keys().find(|edge| balance[*edge] != 0) {
        Some(&edge) => Err(NotClosed { edges: 0, at: middle(edge) }),
        None => Ok(triangles),
    }
}

/// Returns the volume within triangles that are oriented outward \[m³\].
pub fn enclosed(points: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    VolumeMoments::within(points, triangles).volume
}

/// Integrals over the volume that a closed surface encloses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeMoments {
    /// \[m³\]
    pub volume: f64,
    /// Centroid of the volume \[m\]
    pub center: Vec3,
    /// ∫ (X − c)(X − c)ᵀ dV about the centroid \[m⁵\]
    pub second: Mat3,
}

impl VolumeMoments {
    /// Computes the integrals over the volume within triangles that are oriented outward. Each triangle forms a tetrahedron with one of the vertices;
    /// with its sides a, b, c from that vertex and s = a + b + c, ∫ X dV = V s/4 and ∫ X Xᵀ dV = V (aaᵀ + bbᵀ + ccᵀ + ssᵀ)/20.
    pub fn within(points: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let origin = triangles.first().map_or(Vec3::zeros(), |t| points[t[0] as usize]);
        let (mut volume, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
        for t in triangles {
            let [a, b, c] = t.map(|k| points[k as usize] - origin);
            let (part, sum) = (a.dot(&b.cross(&c)) / 6.0, a + b + c);
            volume += part;
            first += sum * (part / 4.0);
            second += [a, b, c, sum].iter().map(|v| v * v.transpose()).sum::<Mat3>() * (part / 20.0);
        }
        let center = if volume == 0.0 { Vec3::zeros() } else { first / volume };
        Self { volume, center: origin + center, second: second - center * center.transpose() * volume }
    }
}

fn sides(&[a, b, c]: &[u32; 3]) -> impl Iterator<Item = [u32; 2]> + use<> {
    [[a, b], [b, c], [c, a]].into_iter()
}

/// \[vertices\] the vertex that represents all vertices at its position.
fn joined(surface: &Surface) -> Vec<u32> {
    let (low, high) = crate::mesh::geometry::bounds(surface.points.iter().copied());
    let width = (SEAM * (high - low).norm()).max(f64::MIN_POSITIVE);
    let cell = |p: &Vec3, d: usize| ((p[d] - low[d]) / width).floor() as i64;
    let mut known: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut of = Vec::with_capacity(surface.points.len());
    for (k, p) in (0u32..).zip(&surface.points) {
        let home = [0, 1, 2].map(|d| cell(p, d));
        let around = (0..27).map(|n| [home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1]);
        let near = |other: &u32| (surface.points[*other as usize] - p).norm() <= width;
        let same = around.filter_map(|at| known.get(&at)?.iter().copied().find(near)).min();
        of.push(same.unwrap_or_else(|| {
            known.entry(home).or_default().push(k);
            k
        }));
    }
    of
}

/// Orients the triangles of each piece consistently across edges of two triangles, and returns the pieces.
fn turned(triangles: &mut [[u32; 3]], edges: &BTreeMap<[u32; 2], Vec<usize>>) -> Vec<Vec<usize>> {
    let (mut seen, mut pieces) = (vec![false; triangles.len()], Vec::new());
    for first in 0..triangles.len() {
        if seen[first] {
            continue;
        }
        let (mut front, mut piece) = (vec![first], Vec::new());
        seen[first] = true;
        while let Some(t) = front.pop() {
            piece.push(t);
            let own = triangles[t];
            for [a, b] in sides(&own) {
                let [one, two] = edges[&[a.min(b), a.max(b)]][..] else { continue };
                let other = if one == t { two } else { one };
                if std::mem::replace(&mut seen[other], true) {
                    continue;
                }
                if sides(&triangles[other]).any(|side| side == [a, b]) {
                    triangles[other].swap(1, 2);
                }
                front.push(other);
            }
        }
        pieces.push(piece);
    }
    pieces
}

/// Returns, for each triangle of a surface, the boundary facet on which it lies, with all nodes within `reach` \[m\] of the triangle; `None` for a
/// triangle without a matching facet.
pub fn matched(mesh: &TetMesh, surface: &Surface, reach: f64) -> Vec<Option<u32>> {
    let facets = boundary_facets(mesh);
    let corners: Vec<[u32; 3]> = facets.iter().map(|&f| [0, 1, 2].map(|k| mesh.facet(f as usize)[k])).collect();
    let boundary = Surface { points: mesh.points.clone(), triangles: corners.clone() };
    let Some(nearest) = Nearest::new(&boundary) else { return vec![None; surface.triangles.len()] };
    let node = |at: &Vec3| {
        let away = |k: &u32| (mesh.points[*k as usize] - at).norm();
        let of = corners[nearest.of(at).triangle as usize];
        of.into_iter().min_by(|a, b| away(a).total_cmp(&away(b))).filter(|k| away(k) <= reach)
    };
    let nodes: Vec<Option<u32>> = surface.points.iter().map(node).collect();
    let by_corners: HashMap<[u32; 3], u32> = corners.into_iter().map(sorted).zip(facets).collect();
    let mut taken = HashMap::new();
    let found = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| nodes[k as usize]);
        let facet = *by_corners.get(&sorted([a?, b?, c?]))?;
        is_flat(mesh, facet, reach).then_some(facet)
    };
    let list: Vec<Option<u32>> = surface.triangles.iter().map(found).collect();
    list.iter().flatten().for_each(|f| *taken.entry(*f).or_insert(0) += 1);
    list.into_iter().map(|f| f.filter(|f| taken[f] == 1)).collect()
}

/// Whether the mid-edge nodes of a facet are within `reach` of the midpoints of its edges.
fn is_flat(mesh: &TetMesh, facet: u32, reach: f64) -> bool {
    let nodes = mesh.facet(facet as usize);
    let p = |k: usize| mesh.points[nodes[k] as usize];
    let off = |e: usize| (p(3 + e) - (p(e) + p((e + 1) % 3)) * 0.5).norm();
    mesh.order == Order::Linear || (0..3).all(|e| off(e) <= reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::made::structured::block;

    fn skin_of(mesh: &TetMesh) -> Surface {
        let triangles = boundary_facets(mesh).iter().map(|&f| [0, 1, 2].map(|k| mesh.facet(f as usize)[k])).collect();
        Surface { points: mesh.points.clone(), triangles }
    }

    /// A box whose triangles are oriented at random and whose vertices are not joined.
    #[test]
    fn seams_are_joined_and_triangles_turned_outward() {
        let whole = skin_of(&block(3, 2, 2, 0.3, 0.2, 0.2, Order::Linear));
        let mut loose = Surface::default();
        for (k, t) in whole.triangles.iter().enumerate() {
            let first = loose.points.len() as u32;
            let away = Vec3::repeat(1e-9 * (k % 5) as f64);
            loose.points.extend(t.map(|n| whole.points[n as usize] + away));
            loose.triangles.push(if k % 3 == 0 {
                [first, first + 2, first + 1]
            } else {
                [first, first + 1, first + 2]
            });
        }
        let triangles = closed(&loose).expect("closed");
        assert!((enclosed(&loose.points, &triangles) - 0.012).abs() < 1e-9);
        loose.triangles.remove(0);
        let open = closed(&loose).expect_err("without a triangle");
        assert_eq!(open.edges, 3);
    }

    #[test]
    fn facets_are_matched_within_the_reach() {
        let mut mesh = block(3, 2, 2, 0.3, 0.2, 0.2, Order::Quadratic);
        let surface = skin_of(&mesh);
        mesh.points.iter_mut().for_each(|p| p.x += 1e-4);
        assert!(matched(&mesh, &surface, 2e-4).iter().all(Option::is_some));
        assert!(matched(&mesh, &surface, 0.5e-4).iter().all(Option::is_none));
        let mut twice = surface.clone();
        twice.triangles.push(surface.triangles[4]);
        let found = matched(&mesh, &twice, 2e-4);
        assert_eq!(found.iter().filter(|f| f.is_none()).count(), 2);
    }
}
