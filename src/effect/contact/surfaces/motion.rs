//! The longest motion during which two surfaces do not cross: additive continuous collision detection (Li, Kaufman & Jiang, ACM TOG 40,
//! 2021, §4), pair by pair.
//!
//! The distance of a pair decreases no faster than its parts move relative to each other, so that d/speed is a safe share of the motion; this is
//! repeated until a tenth of the distance is left. The common motion of all nodes of a pair does not count.

use super::candidates::{Candidates, candidates};
use super::pair::Surfaces;
use super::search::{SurfaceSearch, farthest};
use crate::effect::contact::placement::displacement;
use crate::effect::contact::{ADVANCES, LEFT, SurfacePoint};
use crate::math::nearest::{between, to_triangle};
use crate::math::tensor::Vec3;
use crate::system::{Caches, MotionLimit};
use std::sync::Arc;
use std::time::Instant;

/// A point and a triangle, or two edges: four positions and their motions.
struct Flight {
    at: [Vec3; 4],
    motion: [Vec3; 4],
    edges: bool,
}

impl Flight {
    fn distance(&self, share: f64) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.at[k] + self.motion[k] * share);
        if self.edges { between(&[a, b], &[c, d]) } else { to_triangle(&a, &[b, c, d]) }
    }

    /// Upper bound of the decrease of the distance over the motion \[m\].
    fn speed(&self) -> f64 {
        let mean = self.motion.iter().sum::<Vec3>() / 4.0;
        let most = |list: &[Vec3]| list.iter().map(|m| (m - mean).norm()).fold(0.0, f64::max);
        let first = if self.edges { 2 } else { 1 };
        most(&self.motion[..first]) + most(&self.motion[first..])
    }

    /// Returns the admissible share of the motion, at most `end`, and the distance at the start. Pairs that stay farther apart than a tenth of
    /// `reach` are not limited.
    fn longest(&self, reach: f64, end: f64, tested: &mut usize) -> (f64, f64) {
        *tested += 1;
        let (gap, speed) = (self.distance(0.0), self.speed());
        let left = LEFT * gap.min(reach);
        let (mut share, mut free) = (0.0, gap - left);
        for _ in 0..ADVANCES {
            // The bound is approached by a geometric sequence, whose remainder does not matter.
            if free <= 1e-3 * left {
                break;
            }
            share += free / speed;
            if share >= end {
                return (end, gap);
            }
            *tested += 1;
            free = self.distance(share) - left;
        }
        (share, gap)
    }
}

/// Returns the largest share of the motion dx from x during which no pair comes nearer than a tenth of its distance, or of the reach.
pub fn max_step(surfaces: &Surfaces, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<MotionLimit> {
    let start = Instant::now();
    let search: &mut SurfaceSearch = caches.entry(&surfaces.key);
    let pairs = in_reach_of(surfaces, x, dx, search);
    let passes = surfaces.passes();
    let mut limit: Option<MotionLimit> = None;
    let mut tested = 0;
    let mut look = |flight: Flight, node: u32| {
        let end = limit.map_or(1.0, |l| l.share);
        let (share, gap) = flight.longest(surfaces.reach, end, &mut tested);
        if share < end {
            limit = Some(MotionLimit { share, node, gap });
        }
    };
    for (pass, pairs) in passes.iter().zip(&pairs.points) {
        for &[p, t] in pairs {
            let point = &pass.points.points[p as usize];
            let [a, b, c] = pass.triangles.triangles[t as usize];
            let nodes = [a, b, c];
            let own: Vec3 = point.nodes.iter().zip(&point.weights).map(|(&k, w)| displacement(dx, k) * *w).sum();
            let [q, r, s] = nodes.map(|k| surfaces.node(x, k));
            let [dq, dr, ds] = nodes.map(|k| displacement(dx, k));
            let flight = Flight { at: [surfaces.place(x, point), q, r, s], motion: [own, dq, dr, ds], edges: false };
            look(flight, point.nodes[0]);
        }
    }
    let (first, second) = (&passes[0].points.edges, &passes[0].triangles.edges);
    for &[a, b] in &pairs.edges {
        let ([i, j], [k, l]) = (first[a as usize].nodes, second[b as usize].nodes);
        let nodes = [i, j, k, l];
        let flight =
            Flight { at: nodes.map(|k| surfaces.node(x, k)), motion: nodes.map(|k| displacement(dx, k)), edges: true };
        look(flight, i);
    }
    search.counts.points += surfaces.point_count();
    search.counts.tested += tested;
    search.counts.detection += start.elapsed();
    limit
}

/// Returns the pairs that may come nearer than the reach during the motion: the known candidates, if their margin covers it.
fn in_reach_of(surfaces: &Surfaces, x: &[f64], dx: &[f64], search: &mut SurfaceSearch) -> Arc<Candidates> {
    let here = surfaces.displacements(x);
    let there: Vec<Vec3> = here.iter().zip(surfaces.displacements(dx)).map(|(a, d)| a + d).collect();
    if farthest(&here, &there) <= surfaces.margin {
        if search.at.is_empty() || farthest(&search.at, &here).max(farthest(&search.at, &there)) > surfaces.margin {
            search.at.clear();
            surfaces.refresh(search, x, &here);
        }
        return search.candidates.clone();
    }
    let along = |from: Vec3, motion: Vec3| (from.inf(&(from + motion)), from.sup(&(from + motion)));
    let of_point = |p: &SurfacePoint| {
        let motion = p.nodes.iter().zip(&p.weights).map(|(&k, w)| displacement(dx, k) * *w).sum();
        along(surfaces.place(x, p), motion)
    };
    let of_node = |k: u32| along(surfaces.node(x, k), displacement(dx, k));
    Arc::new(candidates(&surfaces.passes(), surfaces.reach, &of_point, &of_node))
}
