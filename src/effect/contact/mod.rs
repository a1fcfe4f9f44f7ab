//! Contact of points of a surface with a rigid obstacle: search for near points, their distances, and the longest admissible motion.
//!
//! A point of the surface is x_q = X_q + Σ_a N_a u_a with an area W_q; its distance d_q from the obstacle is computed by [`shape`] in the frame of
//! [`placement`]. The law of pressure against distance is a response: [`barrier`], [`penalty`], [`multiplier`]; the resistance to sliding is
//! [`friction`].
//!
//! For each point, the last computed distance and its position are stored: d changes no faster than the point moves, so that most points need no
//! query. These bounds determine how much is computed, never the result.
//!
//! The longest step is found by additive continuous collision detection (Li, Kaufman & Jiang, Codimensional incremental potential
//! contact, ACM TOG 40, 2021, §4): it needs only lower bounds of distances, and no root finding.
//! Contact of deformable surfaces is in [`surfaces`].
//!
//! Limits: only the points feel the obstacle, not the surface between them: an edge or a sphere of radius R penetrates a facet of size h by up to
//! h²/8R.

pub mod barrier;
mod facets;
pub mod friction;
pub mod multiplier;
pub mod penalty;
pub mod placement;
mod points;
pub mod pressed;
pub mod shape;
mod sheet_numbers;
mod sheets;
pub mod surfaces;
mod witness;

pub use points::{Sampling, SurfacePoint, points};

use crate::math::tensor::Vec3;
use crate::system::{Blocks, CacheKey, Caches, MotionLimit};
use placement::{Obstacle, Pair, Placed, displacement};
use std::time::{Duration, Instant};

/// Share of a gap that must remain after a step \[–\].
const LEFT: f64 = 0.1;
/// Largest number of advances of one point in one step.
const ADVANCES: usize = 200;
/// Cosine of the angle between the normals of a point before and after a step below which the point may have passed through the obstacle \[–\].
const OPPOSITE: f64 = -0.1;
/// Depth, relative to its motion, by which a point that passes through the obstacle is deeper inside than at the start and at the end \[–\].
const DEEPER: f64 = 1e-6;
/// Smallest such depth relative to the rounding of kinks; below it, a point slides around an edge from one side to the other \[–\].
const AT_AN_EDGE: f64 = 4.0;

/// Counts and times of the search for contact over a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Counts {
    /// Number of points, summed over the searches
    pub points: usize,
    /// Number of distances computed
    pub tested: usize,
    /// Number of points within reach, summed over the searches
    pub active: usize,
    /// Time spent finding the points within reach
    pub search: Duration,
    /// Time spent finding the longest admissible steps
    pub detection: Duration,
}

/// A normal force on a point.
pub struct NormalForce {
    /// N \[N\]
    pub force: f64,
    /// Unit vector, pointing away from the obstacle
    pub normal: Vec3,
    /// s of the nodes of the block
    pub shares: Vec<f64>,
    /// s of the material in contact, where friction acts; differs from the shares of the point if the point is the centre of a ball
    pub spot: Vec<f64>,
    /// s of the material in contact, by which its sliding over the step is computed
    pub sliding: Vec<f64>,
    /// −∂N/∂d, where d is the distance along the normal \[N/m\]
    pub stiffness: f64,
    /// Index of the elastic slip of the point by which friction resists
    pub slip: usize,
}

impl NormalForce {
    /// Builds the force of a pair whose potential decreases with the distance at the rate `first` \[N\], which itself decreases at the rate `second`
    /// \[N/m\]; `slip` is the index of its elastic slip.
    fn new(pair: &Pair, own: &[f64], (first, second): (f64, f64), slip: usize) -> Self {
        let size = pair.normal.norm();
        let (normal, shares) = (pair.normal / size, pair.shares(own));
        let (spot, sliding) = (shares.clone(), shares.clone());
        Self { force: first * size, normal, spot, sliding, shares, stiffness: second * size * size, slip }
    }

    /// The component of a vector perpendicular to the normal.
    fn across(&self, v: &Vec3) -> Vec3 {
        v - self.normal * self.normal.dot(v)
    }
}

/// A response that exerts normal forces on points.
pub trait NormalForces: Send + Sync {
    fn contact(&self) -> &Contact;
    /// Distance beyond which there is no force \[m\]
    fn reach(&self) -> f64;
    /// Number of elastic slips of a point: more than one if it can have several contacts, each with separate friction
    fn slips(&self) -> usize;
    /// Returns the forces on point `b` in this state.
    fn normal_forces(&self, x: &[f64], b: usize) -> Vec<NormalForce>;
}

/// Contact of points with one obstacle.
pub struct Contact {
    pub name: String,
    pub points: Vec<SurfacePoint>,
    pub obstacle: Obstacle,
    /// One block per point: its nodes, then the four nodes of the obstacle
    blocks: Blocks,
    /// Number of nodes of a point
    own: usize,
    key: CacheKey,
}

/// Search of one contact during a run: the last computed distances, and the counts.
#[derive(Default)]
struct PointSearch {
    /// \[points\] position in the frame of the shape, and distance there
    last: Vec<(Vec3, f64)>,
    counts: Counts,
}

impl PointSearch {
    fn count(&mut self, [points, tested, active]: [usize; 3]) {
        self.counts.points += points;
        self.counts.tested += tested;
        self.counts.active += active;
    }
}

impl Contact {
    /// Builds a contact of points that all have the same number of nodes.
    pub fn new(name: String, points: Vec<SurfacePoint>, obstacle: Obstacle) -> Self {
        Self::with_scalars(name, points, obstacle, None)
    }

    /// Builds a contact with a scalar for each [contact](shape::Shape::contacts) of each point; the indices of the scalars in `State::x` start at
    /// `first`.
    pub fn with_scalars(name: String, points: Vec<SurfacePoint>, obstacle: Obstacle, first: Option<u32>) -> Self {
        let of_obstacle: &[u32] = obstacle.body.as_ref().map_or(&[], |b| &b.nodes);
        let lists: Vec<Vec<u32>> = points.iter().map(|p| [&p.nodes, of_obstacle].concat()).collect();
        let each = first.map_or(0, |_| obstacle.shape.sheets() as u32);
        let scalar = |k: u32| first.unwrap_or(0) + k;
        let scalars: Vec<Vec<u32>> =
            (0..points.len() as u32).map(|k| (each * k..each * (k + 1)).map(scalar).collect()).collect();
        let blocks = Blocks::with_scalars(lists.iter().zip(&scalars).map(|(l, s)| (l.as_slice(), s.as_slice())));
        let own = points.first().map_or(0, |p| p.nodes.len());
        Self { name, points, obstacle, blocks, own, key: CacheKey::default() }
    }

    /// Counts of the run to which these caches belong.
    pub fn counts(&self, caches: &Caches) -> Counts {
        caches.get::<PointSearch>(&self.key).map_or(Counts::default(), |search| search.counts)
    }

    fn search<'c>(&self, caches: &'c mut Caches) -> &'c mut PointSearch {
        let search: &mut PointSearch = caches.entry(&self.key);
        search.last.resize(self.points.len(), (Vec3::zeros(), f64::NAN));
        search
    }

    /// Number of nodes of one point.
    pub fn own(&self) -> usize {
        self.own
    }

    /// Position of point `b` at displacement x \[m\].
    pub fn position(&self, x: &[f64], b: usize) -> Vec3 {
        let p = &self.points[b];
        p.nodes.iter().zip(&p.weights).fold(p.at, |at, (&node, w)| at + displacement(x, node) * *w)
    }

    /// Displacement of point `b` due to the motion dx \[m\].
    fn motion(&self, dx: &[f64], b: usize) -> Vec3 {
        let p = &self.points[b];
        p.nodes.iter().zip(&p.weights).map(|(&node, w)| displacement(dx, node) * *w).sum()
    }

    /// Returns s of the material in contact at point `b` along the `normal`, which points away from the obstacle: the shares by which friction acts
    /// at x, and those by which the material slides over the step from `old`. For a ball these are the spot −r n on it and the material of the
    /// obstacle there at x; sliding uses the mean rotation over the step, so that the spot neither rises nor sinks. For a point of a surface both are
    /// the `shares` of the point.
    fn contact_shares(&self, [x, old]: [&[f64]; 2], b: usize, normal: &Vec3, shares: &[f64]) -> [Vec<f64>; 2] {
        let point = &self.points[b];
        if point.carrier.is_none() {
            return [shares.to_vec(), shares.to_vec()];
        }
        let arm = -normal.normalize() * point.radius;
        let spot = self.obstacle.at(x).place(&(self.position(x, b) + arm));
        let of_obstacle: Vec<f64> =
            self.obstacle.body.iter().flat_map(|body| body.weights(&spot)).map(|w| -w).collect();
        [[x, x], [x, old]].map(|states| [&point.weights_at(states, &arm)[..], &of_obstacle].concat())
    }

    /// Distance of point `b` at displacement x \[m\], negative inside.
    pub fn gap(&self, x: &[f64], b: usize) -> f64 {
        self.gap_from(&self.obstacle.at(x), x, b)
    }

    fn gap_from(&self, placed: &Placed, x: &[f64], b: usize) -> f64 {
        self.obstacle.shape.gap(&placed.local(&self.position(x, b))) - self.points[b].radius
    }

    /// Returns a function for the distance of a position in space from the obstacle at displacement x \[m\], negative inside.
    pub fn distance(&self, x: &[f64]) -> impl Fn(&Vec3) -> f64 {
        let placed = self.obstacle.at(x);
        move |at| self.obstacle.shape.gap(&placed.local(at))
    }

    /// Returns the deepest point at displacement x and its distance \[m\].
    pub fn deepest(&self, x: &[f64]) -> Option<(usize, f64)> {
        let placed = self.obstacle.at(x);
        (0..self.points.len()).map(|b| (b, self.gap_from(&placed, x, b))).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Returns the points nearer than `reach`, in ascending order.
    pub fn near(&self, x: &[f64], reach: f64, caches: &mut Caches) -> Vec<u32> {
        let start = Instant::now();
        let placed = self.obstacle.at(x);
        let search = self.search(caches);
        let mut tested = 0;
        let near: Vec<u32> = (0..self.points.len())
            .filter(|&b| {
                let local = placed.local(&self.position(x, b));
                self.bound(&mut search.last[b], &local, reach + self.points[b].radius, &mut tested)
                    < reach + self.points[b].radius
            })
            .map(|b| b as u32)
            .collect();
        search.count([self.points.len(), tested, near.len()]);
        search.counts.search += start.elapsed();
        near
    }

    /// Returns a lower bound of the distance at `local`: the bound from the last known distance, if it is at least `reach`, or the computed distance.
    fn bound(&self, known: &mut (Vec3, f64), local: &Vec3, reach: f64, tested: &mut usize) -> f64 {
        let least = known.1 - (local - known.0).norm();
        if least >= reach {
            return least;
        }
        *tested += 1;
        *known = (*local, self.obstacle.shape.gap(local));
        known.1
    }

    /// Returns the largest share of the motion dx from x during which no point comes nearer than a tenth of its initial distance.
    pub fn max_step(&self, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<MotionLimit> {
        let start = Instant::now();
        let placed = self.obstacle.at(x);
        let carried = self.obstacle.speed(dx);
        let search = self.search(caches);
        let mut limit: Option<MotionLimit> = None;
        let mut tested = 0;
        for (b, last) in search.last.iter_mut().enumerate() {
            let (at, motion, radius) = (self.position(x, b), self.motion(dx, b), self.points[b].radius);
            let speed = motion.norm() + carried;
            if speed == 0.0 {
                continue;
            }
            let local = placed.local(&at);
            let gap = self.bound(last, &local, speed / ((1.0 - LEFT) * placed.shrink()) + radius, &mut tested) - radius;
            if (1.0 - LEFT) * gap * placed.shrink() >= speed {
                continue;
            }
            let end = limit.map_or(1.0, |l| l.share);
            let left = LEFT * gap * placed.shrink();
            // The bound is approached by a geometric sequence, whose remainder does not matter.
            let share = self.advance((x, dx), b, [left, 1e-3 * left], speed, end, &mut tested);
            if share < end {
                limit = Some(MotionLimit { share, node: self.points[b].nodes[0], gap });
            }
        }
        search.count([self.points.len(), tested, 0]);
        search.counts.detection += start.elapsed();
        limit
    }

    /// Returns a node of a point that the straight motion from `old` to `x` takes through the obstacle, and the distance of the point at the end
    /// \[m\]: its normal at the end points to a different side, and in between the point is deeper inside than at the start and at the end.
    ///
    /// `rounding` \[m\] is the depth over which kinks between sides of the obstacle are rounded.
    pub fn passed(&self, [old, x]: [&[f64]; 2], rounding: f64, caches: &mut Caches) -> Option<(u32, f64)> {
        let start = Instant::now();
        let dx: Vec<f64> = x.iter().zip(old).map(|(x, old)| x - old).collect();
        let (before, after) = (self.obstacle.at(old), self.obstacle.at(x));
        let carried = self.obstacle.speed(&dx);
        let search = self.search(caches);
        let mut tested = 0;
        let passes = |(b, last): (usize, &mut (Vec3, f64))| {
            let (point, speed) = (&self.points[b], self.motion(&dx, b).norm() + carried);
            let reach = speed / before.shrink() + point.radius;
            let local = before.local(&self.position(old, b));
            if speed == 0.0 || self.bound(last, &local, reach, &mut tested) >= reach {
                return None;
            }
            let local = [local, after.local(&self.position(x, b))];
            let [from, to] = local.map(|y| self.obstacle.shape.nearest(&y));
            if from.normal.dot(&to.normal) > OPPOSITE {
                return None;
            }
            let margin = (DEEPER * speed).max(AT_AN_EDGE * rounding);
            let least = (from.gap.min(to.gap) - point.radius).min(0.0) - margin;
            let share = self.advance((old, &dx), b, [least, 1e-3 * margin], speed, 1.0, &mut tested);
            (share < 1.0).then_some((point.nodes[0], to.gap - point.radius))
        };
        let passed = search.last.iter_mut().enumerate().find_map(passes);
        search.count([0, tested, 0]);
        search.counts.detection += start.elapsed();
        passed
    }

    /// Returns the share of the motion of point `b`, at most `end`, during which its distance exceeds `least`, to within `close` \[m\].
    fn advance(
        &self,
        (x, dx): (&[f64], &[f64]),
        b: usize,
        [least, close]: [f64; 2],
        speed: f64,
        end: f64,
        tested: &mut usize,
    ) -> f64 {
        let distance = |share: f64| {
            let placed = self.obstacle.along(x, dx, share);
            let at = self.position(x, b) + self.motion(dx, b) * share;
            (self.obstacle.shape.gap(&placed.local(&at)) - self.points[b].radius) * placed.shrink()
        };
        let mut share = 0.0;
        for _ in 0..ADVANCES {
            *tested += 1;
            let free = distance(share) - least;
            if free <= close {
                break;
            }
            share += free / speed;
            if share >= end {
                return end;
            }
        }
        share
    }

    pub fn blocks(&self) -> &Blocks {
        &self.blocks
    }
}
