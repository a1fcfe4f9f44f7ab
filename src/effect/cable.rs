//! Cable (tendon): a polyline from a fixed pull point through guides to its end, or between guides alone, of length
//! L(x) = Σ_s ‖p_{s+1} − p_s‖ with p_k = X_k + w_k, w_k = Σ_i w_ki u_i. It depends on the body only through the w_k ([`Means`]).
//!
//! A guide is a patch: the weighted mean of the body's motion over a ball, because a point force in 3-D has infinite
//! compliance. A ring is a guide without a body: it is fixed in space. Driven by tension, the cable is a load T(t) with the potential T·L; driven by
//! length, it is the exact constraint g = L₀ − d(t) + T L₀/EA − L(x) ≥ 0 ⟂ T ≥ 0, whose multiplier is the tension, with T ≤ T_max if the drive
//! yields. Limits: without friction T is the same along the cable (for friction see [`super::cable_friction`]); the elastic cable is linear, with a
//! small strain T/EA.

use crate::math::signal::{Clock, Signal};
use crate::math::tensor::{Mat3, Vec3};
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Constraint, ConstraintKind, Effect, EnergyRole, EvalError, Means, Want,
};
use std::sync::Arc;

/// A point at which the cable is in contact with the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    /// X_k \[m\]
    pub point: Vec3,
    /// (node, weight), Σ w = 1, Σ w X_i = X_k; empty for a ring, which is fixed in space
    pub weights: Vec<(u32, f64)>,
}

/// Geometry of a cable; its blocks are its segments, its means are the mean displacements of its guides.
pub struct Cable {
    pub name: String,
    /// Fixed in space \[m\]; `None` for a cable that is pulled at its first guide, which moves with the body
    pull_point: Option<Vec3>,
    /// X_k of the guides \[m\]
    points: Vec<Vec3>,
    /// w_k of the guides as weighted means of nodal displacements
    pub(super) means: Arc<Means>,
    blocks: Blocks,
}

impl Cable {
    /// Builds a cable from a pull point that is fixed in space through the guides.
    pub fn new(name: String, pull_point: Vec3, guides: Vec<Guide>) -> Self {
        Self::through(name, Some(pull_point), guides)
    }

    /// Builds a cable through the guides, from the pull point or, without one, from the first guide: then the drive moves with the body, and the
    /// forces of the cable sum to zero.
    pub fn through(name: String, pull_point: Option<Vec3>, guides: Vec<Guide>) -> Self {
        let means = Means::new(guides.iter().map(|g| &g.weights[..]));
        let first = u32::from(pull_point.is_none());
        let ends: Vec<Vec<u32>> = (first..guides.len() as u32).map(|k| (k.saturating_sub(1)..=k).collect()).collect();
        let blocks = Blocks::new(ends.iter().map(Vec::as_slice));
        let points = guides.into_iter().map(|g| g.point).collect();
        Self { name, pull_point, points, means: means.into(), blocks }
    }

    /// Returns the polyline at displacement x: the pull point, if it is fixed, then the guides \[m\].
    pub fn polyline(&self, x: &[f64]) -> Vec<Vec3> {
        let w = self.means.of(x);
        self.pull_point.into_iter().chain((0..self.points.len()).map(|k| self.guide(&w, k))).collect()
    }

    /// Returns the pull point if it is fixed in space, and the positions of the guides at rest \[m\].
    pub fn path(&self) -> (Option<Vec3>, &[Vec3]) {
        (self.pull_point, &self.points)
    }

    /// The weighted means of the displacements with which the guides move.
    pub fn means(&self) -> &Means {
        &self.means
    }

    /// Lengths of the segments \[m\], from the pull point on. L(x) is their sum.
    pub fn lengths(&self, x: &[f64]) -> Vec<f64> {
        self.segment_lengths(&self.means.of(x))
    }

    /// Lengths of the segments at rest \[m\], from the pull point on.
    pub fn lengths_at_rest(&self) -> Vec<f64> {
        self.segment_lengths(&vec![0.0; 3 * self.points.len()])
    }

    /// Lengths of the segments \[m\], with w \[3 × guides\].
    fn segment_lengths(&self, w: &[f64]) -> Vec<f64> {
        (0..self.segments()).map(|s| self.direction(w, s).norm()).collect()
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.blocks.len()
    }

    /// The guides at the ends of segment `s`.
    pub fn ends(&self, s: usize) -> &[u32] {
        self.blocks.nodes(s)
    }

    /// Returns the derivatives with respect to the unknowns of the total length of the segments from index `from` on, at displacement x; the length
    /// changes by Σ_s τ_s·(dp_{s+1} − dp_s).
    pub fn length_gradient(&self, x: &[f64], from: usize) -> Vec<(u32, f64)> {
        let w = self.means.of(x);
        let mut of_guides = vec![0.0; w.len()];
        for s in from..self.segments() {
            let along = self.direction(&w, s).normalize();
            for (guide, sign) in self.ends(s).iter().zip(self.signs(s)) {
                (0..3).for_each(|i| of_guides[3 * *guide as usize + i] += sign * along[i]);
            }
        }
        let mut out = Vec::new();
        self.means.spread(&of_guides, |dof, weight| out.push((dof, weight)));
        out
    }

    /// Position p of guide `k` \[m\], with w \[3 × guides\].
    fn guide(&self, w: &[f64], k: usize) -> Vec3 {
        self.points[k] + Vec3::from_column_slice(&w[3 * k..3 * k + 3])
    }

    /// Segment `s` as a vector \[m\], with w \[3 × guides\].
    pub(super) fn direction(&self, w: &[f64], s: usize) -> Vec3 {
        match (self.ends(s), self.pull_point) {
            (&[from, to], _) => self.guide(w, to as usize) - self.guide(w, from as usize),
            (_, pull_point) => {
                self.guide(w, s) - pull_point.expect("a segment with one guide begins at the pull point")
            }
        }
    }

    /// Signs with which the guides of segment `s` enter its vector; a fixed pull point does not move and has none.
    fn signs(&self, s: usize) -> &'static [f64] {
        if self.ends(s).len() == 1 { &[1.0] } else { &[-1.0, 1.0] }
    }

    /// Writes the length of segment `s`, its gradient ∓τ and its Hessian ±(I − ττᵀ)/l with respect to w; gradient and Hessian are multiplied by
    /// `factor`.
    ///
    /// # Errors
    ///
    /// [`EvalError::Degenerate`] for a segment of zero length, which has no direction.
    pub fn segment(
        &self,
        w: &[f64],
        s: usize,
        factor: f64,
        want: Want,
        out: &mut BlockValues,
    ) -> Result<(), EvalError> {
        let d = self.direction(w, s);
        let l = d.norm();
        out.energy = l;
        if want == Want::Energy {
            return Ok(());
        }
        if l == 0.0 {
            return Err(EvalError::Degenerate { effect: self.name.clone(), segment: s });
        }
        let tau = d / l;
        let signs = self.signs(s);
        let n = 3 * signs.len();
        let hessian = (Mat3::identity() - tau * tau.transpose()) * (factor / l);
        for (a, sa) in signs.iter().enumerate() {
            for i in 0..3 {
                out.r[3 * a + i] = factor * sa * tau[i];
            }
            if want == Want::Tangent {
                for (b, sb) in signs[..=a].iter().enumerate() {
                    for i in 0..3 {
                        for j in 0..3 {
                            out.k[(3 * a + i) * n + 3 * b + j] = sa * sb * hessian[(i, j)];
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// Cable under a prescribed tension T(t) ≥ 0 \[N\].
pub struct CableTension {
    pub cable: Arc<Cable>,
    pub tension: Signal,
}

impl Effect for CableTension {
    fn name(&self) -> &str {
        &self.cable.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Load
    }

    fn intensity(&self, now: Clock) -> f64 {
        self.tension.at(now).max(0.0)
    }

    fn blocks(&self) -> &Blocks {
        &self.cable.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.cable.segment(at.x, b, self.intensity(at.clock()), want, out)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { means: Some(&self.cable.means), ..Capabilities::default() }
    }
}

/// Cable whose free length is shortened by d(t) \[m\] at the pull point; it cannot push.
pub struct CableLength {
    pub cable: Arc<Cable>,
    pub shortening: Signal,
    /// L₀ \[m\]
    pub rest: f64,
    /// L₀/EA \[m/N\], 0 for an inextensible cable
    pub compliance: f64,
    /// T_max \[N\] at which the drive yields, infinite if it does not yield
    pub most: f64,
}

impl Constraint for CableLength {
    fn name(&self) -> &str {
        &self.cable.name
    }

    fn kind(&self) -> ConstraintKind {
        if self.most < f64::INFINITY { ConstraintKind::Bounded(self.most) } else { ConstraintKind::Unilateral }
    }

    fn compliance(&self) -> f64 {
        self.compliance
    }

    fn scale(&self) -> f64 {
        self.rest
    }

    fn target(&self, now: Clock) -> f64 {
        self.rest - self.shortening.at(now)
    }

    fn blocks(&self) -> &Blocks {
        &self.cable.blocks
    }

    fn means(&self) -> Option<&Arc<Means>> {
        Some(&self.cable.means)
    }

    fn eval(&self, w: &[f64], b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.cable.segment(w, b, 1.0, want, out)
    }
}
