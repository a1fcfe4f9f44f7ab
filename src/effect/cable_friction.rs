//! Cable with friction at its guides by the capstan equation (Euler 1769, Eytelwein 1808): T_{k−1}/T_k = e^{±μβ_k} where the cable slips, and any
//! value in between where it sticks.
//!
//! Each segment s has a tension T_s, the multiplier of its constraint g_s = l₀_s + T_s l₀_s/EA − l_s(x). The length of cable that has passed guide k
//! towards the pull point since the start is a_k = Σ_{s≥k} g_s, and the length taken in at the pull point is a_0 = d(t) + Σ_s g_s, since g_0 also
//! contains −d(t). With the slip Δa_k over the step, the laws of the n constraints are
//!
//! pull point: Σ_s g_s = 0 while 0 ≤ T_0 ≤ T_max, or T_0 = T(t);
//! guide k: Δa_k = 0 while e^{−μβ_k} ≤ T_{k−1}/T_k ≤ e^{μβ_k}; T_{k−1} = e^{μβ_k} T_k while Δa_k ≥ 0; T_k = e^{μβ_k} T_{k−1} while Δa_k ≤ 0.
//!
//! The wrap angle β_k between segments k−1 and k is a separate constraint that exerts no force, so that its change enters the Newton step. The slip
//! is a function of x and T: the state needs no further history. Energy: the drive does the work T_0 Δa_0, and Σ (T_{k−1} − T_k) Δa_k ≥ 0 is
//! dissipated. Limits: β_k has a kink where the cable is straight; its gradient is taken as zero there.

use super::cable::Cable;
use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::system::{
    BlockValues, Blocks, Constraint, ConstraintKind, ConstraintValues, EvalError, LawPiece, LinearFunction, Means,
    Want, bounded_multiplier,
};
use std::sync::Arc;

/// Tension relative to the largest Σ_e ‖r_e‖ of an effect, below which tensions are judged by their size and not by their ratio \[–\].
const FAINT: f64 = 1e-3;

/// The drive of a cable with friction.
#[derive(Clone, Debug)]
pub enum Pull {
    /// d(t) \[m\], and T_max \[N\] at which the drive yields, infinite if it does not yield
    Length { shortening: Signal, most: f64 },
    /// T(t) \[N\]
    Tension(Signal),
}

/// Data shared by the constraints of one cable.
struct Rope {
    cable: Arc<Cable>,
    pull: Pull,
    /// μ \[–\]
    friction: f64,
    /// 1/EA \[1/N\]
    softness: f64,
    /// l₀ of the segments \[m\]
    rest: Vec<f64>,
}

/// Returns the constraints of a cable with friction, in this order: the n segments, then the wrap angles of the n − 1 guides between them. `softness`
/// is 1/EA \[1/N\].
pub fn constraints(cable: Arc<Cable>, pull: Pull, friction: f64, softness: f64) -> Vec<Box<dyn Constraint>> {
    let rest = cable.lengths_at_rest();
    let n = rest.len();
    let rope = Arc::new(Rope { cable, pull, friction, softness, rest });
    let segments = (0..n).map(|s| Box::new(Segment::new(rope.clone(), s)) as Box<dyn Constraint>);
    segments.chain((1..n).map(|k| Box::new(WrapAngle::new(rope.clone(), k)) as Box<dyn Constraint>)).collect()
}

impl Rope {
    fn total(&self) -> f64 {
        self.rest.iter().sum()
    }
}

/// The constraint of one segment: its length, and the law that relates its tension to that of the previous segment.
struct Segment {
    rope: Arc<Rope>,
    s: usize,
    blocks: Blocks,
}

impl Segment {
    fn new(rope: Arc<Rope>, s: usize) -> Self {
        let blocks = Blocks::new(std::iter::once(rope.cable.ends(s)));
        Self { rope, s, blocks }
    }

    /// Returns the index of the constraint of the first segment and the range of the segments from this one on, given the index `c` of this one.
    fn places(&self, c: usize) -> (usize, std::ops::Range<usize>) {
        let first = c - self.s;
        (first, c..first + self.rope.rest.len())
    }

    /// The friction law of the guide at the start of this segment.
    fn guide(&self, c: usize, all: &ConstraintValues) -> Vec<LawPiece> {
        let (first, rest) = self.places(c);
        let slip = LinearFunction::gap(all, rest.clone(), self.rope.total()).less(all.old[rest].iter().sum());
        // The constraint of the angle has the value g = −β.
        let angle = first + self.rope.rest.len() + self.s - 1;
        let ratio = (-self.rope.friction * all.g[angle]).exp();
        // e^{μβ} T_a − T_b
        let spare = |a: usize, b: usize| LinearFunction {
            value: ratio * all.lambda[a] - all.lambda[b],
            scale: ratio * all.lambda[a].abs() + all.lambda[b].abs() + FAINT * all.force,
            g: vec![(angle, -self.rope.friction * ratio * all.lambda[a])],
            lambda: vec![(a, ratio), (b, -1.0)],
        };
        let (towards, away) = (spare(c, c - 1), spare(c - 1, c));
        vec![
            LawPiece { equation: slip.clone(), inequalities: vec![(towards.clone(), 1), (away.clone(), 2)] },
            LawPiece { equation: towards, inequalities: vec![(slip.clone(), 0)] },
            LawPiece { equation: away, inequalities: vec![(slip.negative(), 0)] },
        ]
    }
}

impl Constraint for Segment {
    fn name(&self) -> &str {
        &self.rope.cable.name
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::Linked
    }

    fn scale(&self) -> f64 {
        self.rope.total()
    }

    fn target(&self, now: Clock) -> f64 {
        match &self.rope.pull {
            Pull::Length { shortening, .. } if self.s == 0 => self.rope.rest[0] - shortening.at(now),
            _ => self.rope.rest[self.s],
        }
    }

    fn compliance(&self) -> f64 {
        self.rope.softness * self.rope.rest[self.s]
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn means(&self) -> Option<&Arc<Means>> {
        Some(&self.rope.cable.means)
    }

    fn eval(&self, w: &[f64], _b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.rope.cable.segment(w, self.s, 1.0, want, out)
    }

    fn linked_law(&self, c: usize, all: &ConstraintValues) -> Vec<LawPiece> {
        match &self.rope.pull {
            _ if self.s > 0 => self.guide(c, all),
            Pull::Length { most, .. } => {
                bounded_multiplier(all, c, LinearFunction::gap(all, self.places(c).1, self.rope.total()), *most)
            }
            Pull::Tension(tension) => {
                let mut equation = LinearFunction::multiplier(all, c, tension.at(all.now).max(0.0));
                // A tension of the size of rounding, as at the end of a cosine, counts as zero.
                equation.scale += FAINT * all.force;
                vec![LawPiece { equation, inequalities: Vec::new() }]
            }
        }
    }

    fn dissipated(&self, c: usize, g: [&[f64]; 2], lambda: [&[f64]; 2]) -> f64 {
        if self.s == 0 {
            return 0.0;
        }
        let slip = self.places(c).1.map(|s| g[1][s] - g[0][s]).sum::<f64>();
        let drop = |lambda: &[f64]| lambda[c - 1] - lambda[c];
        0.5 * (drop(lambda[0]) + drop(lambda[1])) * slip
    }
}

/// The wrap angle β_k of the guide between segments k − 1 and k. Its single block contains the guides at the ends of both segments.
struct WrapAngle {
    rope: Arc<Rope>,
    k: usize,
    blocks: Blocks,
}

impl WrapAngle {
    fn new(rope: Arc<Rope>, k: usize) -> Self {
        let (before, after) = (rope.cable.ends(k - 1), rope.cable.ends(k));
        let guides: Vec<u32> = (before[0]..=after[after.len() - 1]).collect();
        Self { rope, k, blocks: Blocks::new(std::iter::once(&guides[..])) }
    }
}

impl Constraint for WrapAngle {
    fn name(&self) -> &str {
        &self.rope.cable.name
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::Monitored
    }

    fn scale(&self) -> f64 {
        1.0
    }

    fn target(&self, _now: Clock) -> f64 {
        0.0
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn means(&self) -> Option<&Arc<Means>> {
        Some(&self.rope.cable.means)
    }

    /// β = ∠(d_{k−1}, d_k) and ∂β/∂d_a = −e_a/‖d_a‖, where the unit vector e_a is perpendicular to d_a and points towards the other direction.
    fn eval(&self, w: &[f64], _b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let cable = &self.rope.cable;
        let d = [self.k - 1, self.k].map(|s| cable.direction(w, s));
        if let Some(a) = (0..2).find(|&a| d[a].norm() == 0.0) {
            return Err(EvalError::Degenerate { effect: cable.name.clone(), segment: self.k - 1 + a });
        }
        let tau = d.map(|d| d.normalize());
        out.energy = angle(&tau);
        if want == Want::Energy {
            return Ok(());
        }
        let gradient = |a: usize| {
            let across = tau[1 - a] - tau[a] * tau[a].dot(&tau[1 - a]);
            across.try_normalize(0.0).map_or(Vec3::zeros(), |e| -e / d[a].norm())
        };
        // d_{k−1} ends at the guide, d_k starts there; the point before the first guide may be the pull point.
        let (before, after) = (gradient(0), gradient(1));
        let of_guides = [-before, before - after, after];
        for (r, gradient) in out.r.chunks_exact_mut(3).zip(&of_guides[3 - self.blocks.nodes(0).len()..]) {
            r.copy_from_slice(gradient.as_slice());
        }
        Ok(())
    }
}

/// Angle between two unit vectors \[rad\].
fn angle(tau: &[Vec3; 2]) -> f64 {
    tau[0].cross(&tau[1]).norm().atan2(tau[0].dot(&tau[1]))
}
