//! Contact of two deformable surfaces, or of one with itself: points with triangles, and edges with edges, all of them moving.
//!
//! ```text
//! Π = ½ Σ_q W_q Σ_f c_qf b(d_qf) + Σ_ee′ w_ee′ m(|u × v|²) b(d_ee′)
//! ```
//!
//! The points of either surface meet the features f of the other: c = 1 on triangles, −1 on edges between two, 1 on corners that
//! triangles surround, so that a point over a flat or convex surface feels one distance, not one of each triangle. Terms of the same
//! nearest feature are added before anything else. Both surfaces carry half of the pressure.
//!
//! Edges are guards: w is a hundredth of their area where a surface is flat, and all of it where both are sharp;
//! m(c) = 2c/ε − c²/ε² for c < ε makes parallel ones vanish smoothly (Li et al., Incremental potential contact, ACM TOG 39, 2020,
//! §5.2, ε a thousandth of |u|²|v|² at rest). Weights by area and the sum over features are those of Li et al., Convergent
//! incremental potential contact (2023). Detection along the step is additive (Li, Kaufman & Jiang 2021, §4).
//!
//! Candidates are kept until the motion has used up their margin; what they are never decides what comes out.
//! Limits: parts that share a node do not meet. A curved facet is four flat triangles to the points of the other surface.

mod candidates;
pub mod friction;
mod motion;
pub mod nearest;
pub mod pressed;
pub mod surface;
mod terms;
pub mod touch;

use super::placement::moved;
use super::{Counts, Point};
use crate::math::tensor::Vec3;
use crate::mesh::overlap::pierces;
use crate::system::{CacheKey, Caches};
use candidates::{Candidates, Pass, Span, candidates, least, pierced_by_edges};
use std::sync::Arc;
use std::time::Instant;
use surface::{Edge, Surface};
pub use terms::Term;
use terms::{between, to_triangle};

/// Part of the mean edge that nodes may move before pairs are looked for again \[–\].
const MARGIN: f64 = 0.1;
/// Distance below which pairs are in the sparsity pattern of the tangent, in reaches \[–\].
const PATTERN_REACH: f64 = 3.0;

/// Two surfaces, or one.
pub struct Surfaces {
    pub name: String,
    first: Surface,
    /// None where the first meets itself
    second: Option<Surface>,
    /// \[nodes of the mesh\] X \[m\]
    rest: Vec<Vec3>,
    /// Nothing is felt beyond this distance \[m\]
    reach: f64,
    /// Motion of a node that the candidates allow \[m\]
    margin: f64,
    nodes: Vec<u32>,
    key: CacheKey,
}

/// Search of two surfaces over a run: the candidates and terms that were found last, and the counts.
#[derive(Default)]
struct SurfaceSearch {
    /// \[nodes\] displacements at which the candidates were found \[m\]
    at: Vec<Vec3>,
    candidates: Arc<Candidates>,
    /// Displacements of the last evaluation, and its terms
    last: (Vec<Vec3>, Arc<Vec<Term>>),
    counts: Counts,
}

impl Surfaces {
    pub fn new(name: String, first: Surface, second: Option<Surface>, rest: Vec<Vec3>, reach: f64) -> Self {
        let size = second.as_ref().map_or(f64::INFINITY, |s| s.size(&rest)).min(first.size(&rest));
        let mut nodes: Vec<u32> = first.nodes().chain(second.iter().flat_map(Surface::nodes)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        Self { name, first, second, rest, reach, margin: MARGIN * size, nodes, key: CacheKey::default() }
    }

    /// Counts of the run that these caches belong to.
    pub fn counts(&self, caches: &Caches) -> Counts {
        caches.get::<SurfaceSearch>(&self.key).map_or(Counts::default(), |search| search.counts)
    }

    /// The surface whose forces are recorded.
    pub fn first(&self) -> &Surface {
        &self.first
    }

    /// Points of both.
    pub fn point_count(&self) -> usize {
        self.first.points.len() + self.second.as_ref().map_or(0, |s| s.points.len())
    }

    /// Has it one surface?
    pub fn meets_itself(&self) -> bool {
        self.second.is_none()
    }

    /// Are both of one body, and next to each other?
    pub fn is_joined(&self) -> bool {
        let Some(second) = &self.second else { return true };
        let own: Vec<u32> = self.first.nodes().collect();
        second.nodes().any(|k| own.binary_search(&k).is_ok())
    }

    fn passes(&self) -> Vec<Pass<'_>> {
        let pass = |points, triangles| Pass { points, triangles };
        match &self.second {
            None => vec![pass(&self.first, &self.first)],
            Some(second) => vec![pass(&self.first, second), pass(second, &self.first)],
        }
    }

    /// Place of a node at displacement x \[m\].
    fn node(&self, x: &[f64], k: u32) -> Vec3 {
        self.rest[k as usize] + moved(x, k)
    }

    /// Place of a point at displacement x \[m\].
    fn place(&self, x: &[f64], p: &Point) -> Vec3 {
        p.nodes.iter().zip(&p.weights).fold(p.at, |at, (&k, w)| at + moved(x, k) * *w)
    }

    fn displacements(&self, x: &[f64]) -> Vec<Vec3> {
        self.nodes.iter().map(|&k| moved(x, k)).collect()
    }

    /// Terms nearer than the reach at displacement x, point by point, then edge by edge.
    pub fn terms(&self, x: &[f64], caches: &mut Caches) -> Arc<Vec<Term>> {
        let start = Instant::now();
        let here = self.displacements(x);
        let search: &mut SurfaceSearch = caches.entry(&self.key);
        if search.last.0 != here {
            self.refresh(search, x, &here);
            let mut tested = 0;
            let terms = self.near(x, &search.candidates, self.reach, &mut tested);
            search.counts.points += self.point_count();
            search.counts.tested += tested;
            search.counts.active += terms.len();
            search.counts.search += start.elapsed();
            search.last = (here, Arc::new(terms));
        }
        search.last.1.clone()
    }

    /// Nodes of the pairs that the sparsity pattern of the tangent includes.
    pub fn coupled_nodes(&self, x: &[f64], caches: &mut Caches) -> Vec<Vec<u32>> {
        let here = self.displacements(x);
        let search: &mut SurfaceSearch = caches.entry(&self.key);
        self.refresh(search, x, &here);
        self.nodes_within(x, &search.candidates, PATTERN_REACH * self.reach)
    }

    /// Least distance \[m\] between parts that share no node, at displacement x; infinite where there is none.
    pub fn gap(&self, x: &[f64]) -> f64 {
        let corners = |pass: &Pass, t: u32| pass.triangles.triangles[t as usize].map(|k| self.node(x, k));
        let ends = |e: &Edge| e.nodes.map(|k| self.node(x, k));
        let of_point = |pass: &Pass, p: &Point, t: u32| to_triangle(&self.place(x, p), &corners(pass, t));
        let of_edges = |a: &Edge, b: &Edge| between(&ends(a), &ends(b));
        least(&self.passes(), &|p| self.place(x, p), &|k| self.node(x, k), &of_point, &of_edges)
    }

    /// A place where an edge goes through a triangle at displacement x \[m\].
    pub fn crossing(&self, x: &[f64]) -> Option<Vec3> {
        let passes = self.passes();
        let spot = |at: Vec3| -> Span { (at, at) };
        let node = |k: u32| self.node(x, k);
        let found = pierced_by_edges(&passes, &|k| spot(node(k)));
        found.into_iter().find_map(|(edge, triangle)| {
            let [a, b] = edge.map(node);
            Some(a + (b - a) * pierces(&a, &b, &triangle.map(node))?)
        })
    }

    /// Candidates that hold all pairs nearer than the room as long as no node moves further than the margin from x.
    fn refresh(&self, search: &mut SurfaceSearch, x: &[f64], here: &[Vec3]) {
        if search.at.is_empty() || farthest(&search.at, here) > self.margin {
            search.candidates = Arc::new(self.around(x, PATTERN_REACH * self.reach + 2.0 * self.margin));
            search.at = here.to_vec();
        }
    }

    fn around(&self, x: &[f64], radius: f64) -> Candidates {
        let spot = |at: Vec3| -> Span { (at, at) };
        candidates(&self.passes(), radius, &|p| spot(self.place(x, p)), &|k| spot(self.node(x, k)))
    }
}

fn farthest(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}
