//! Constraints with multipliers, the kinds of constraints, and the laws of their multipliers.
//!
//! A law ([`constraint_law`]) is a complementarity condition that consists of linear pieces ([`LawPiece`]). A piece is an equation in the values g
//! and multipliers λ of the constraints, with the inequalities under which it is active: 0 ≤ g ⟂ λ ≥ 0 is g = 0 while λ ≥ 0, or λ = 0 while g ≥ 0. A
//! curved law is linearised at a state.

use super::{BlockValues, Blocks, EvalError, Means};
use crate::material::Want;
use crate::math::signal::Clock;
use crate::math::statistics::larger;
use std::sync::Arc;

/// One exact condition g(x, t, λ) = target(t) + compliance·λ − Σ_b c_b(x), whose multiplier λ is an unknown (for a cable, its tension).
///
/// It adds λ ∂c/∂x to the residual and λ ∂²c/∂x² to the tangent; the Lagrangian is `Π + λ (c − target) − ½ compliance λ²`.
pub trait Constraint: Send + Sync {
    fn name(&self) -> &str;
    /// The kind of the constraint, which decides which multipliers are admissible.
    fn kind(&self) -> ConstraintKind;
    /// Length or volume with which |g| is compared.
    fn scale(&self) -> f64;
    fn target(&self, now: Clock) -> f64;
    /// ∂g/∂λ ≥ 0: for a cable, the elongation per newton \[m/N\]. The constraint stores ½ compliance λ² \[J\].
    fn compliance(&self) -> f64 {
        0.0
    }
    fn blocks(&self) -> &Blocks;
    /// Weighted means through which alone the constraint depends on the body, as in [`Capabilities::means`](super::Capabilities::means).
    fn means(&self) -> Option<&Arc<Means>> {
        None
    }
    /// Evaluates c_b, ∂c_b/∂x and ∂²c_b/∂x² of block `b` into `energy`, `r` and `k`. A [`ConstraintKind::Monitored`] constraint needs no second
    /// derivative.
    fn eval(&self, x: &[f64], b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError>;
    /// The law of a [`ConstraintKind::Linked`] constraint, which is constraint `c` of the system.
    fn linked_law(&self, _c: usize, _all: &ConstraintValues) -> Vec<LawPiece> {
        Vec::new()
    }
    /// Dissipation of constraint `c` \[J\] between two states by the trapezoidal rule, from g and λ of all constraints at the earlier and at the
    /// present state.
    fn dissipated(&self, _c: usize, _g: [&[f64]; 2], _lambda: [&[f64]; 2]) -> f64 {
        0.0
    }
}

/// The kinds of constraints, by the multipliers that they admit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConstraintKind {
    /// An equality: g = 0, λ is free
    Equality,
    /// A unilateral constraint: g ≥ 0 ⟂ λ ≥ 0
    Unilateral,
    /// A unilateral constraint with an upper bound λ_max of the multiplier, 0 ≤ λ ≤ λ_max: g = 0 between the bounds, g ≥ 0 at λ = 0, g ≤ 0 at λ =
    /// λ_max
    Bounded(f64),
    /// λ ≥ 0, with a law that involves other constraints, [`Constraint::linked_law`]
    Linked,
    /// A function g without force, λ = 0, on which the laws of other constraints depend
    Monitored,
}

impl ConstraintKind {
    /// The admissible multiplier that is nearest to λ.
    pub fn admit(self, lambda: f64) -> f64 {
        match self {
            Self::Equality => lambda,
            Self::Unilateral | Self::Linked => lambda.max(0.0),
            Self::Bounded(most) => lambda.clamp(0.0, most),
            Self::Monitored => 0.0,
        }
    }

    /// Whether the constraint is active with this multiplier, so that g stays zero under small changes.
    pub fn holds(self, lambda: f64) -> bool {
        match self {
            Self::Equality => true,
            Self::Unilateral | Self::Linked => lambda > 0.0,
            Self::Bounded(most) => lambda > 0.0 && lambda < most,
            Self::Monitored => false,
        }
    }
}

/// Values of all constraints at one state.
#[derive(Clone, Copy)]
pub struct ConstraintValues<'a> {
    pub now: Clock<'a>,
    /// \[constraints\] g = target + compliance λ − c
    pub g: &'a [f64],
    pub lambda: &'a [f64],
    /// \[constraints\] g at the start of the step
    pub old: &'a [f64],
    /// Largest Σ_e ‖r_e‖ of any effect \[N\], the scale of forces
    pub force: f64,
}

/// A linear function of the values g and multipliers λ of the constraints near a state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinearFunction {
    pub value: f64,
    /// Magnitude with which |value| is compared
    pub scale: f64,
    /// Pairs (constraint, derivative with respect to its g)
    pub g: Vec<(usize, f64)>,
    /// Pairs (constraint, derivative with respect to its λ)
    pub lambda: Vec<(usize, f64)>,
}

impl LinearFunction {
    /// Σ g over `which`, compared with `scale`.
    pub fn gap(all: &ConstraintValues, which: std::ops::Range<usize>, scale: f64) -> Self {
        Self {
            value: all.g[which.clone()].iter().sum(),
            scale,
            g: which.map(|c| (c, 1.0)).collect(),
            ..Self::default()
        }
    }

    /// The function λ_c − of.
    pub fn multiplier(all: &ConstraintValues, c: usize, of: f64) -> Self {
        let value = all.lambda[c] - of;
        Self { value, scale: all.lambda[c].abs() + of.abs(), g: Vec::new(), lambda: vec![(c, 1.0)] }
    }

    /// The function −f.
    pub fn negative(&self) -> Self {
        let negated = |list: &[(usize, f64)]| list.iter().map(|&(c, d)| (c, -d)).collect();
        Self { value: -self.value, scale: self.scale, g: negated(&self.g), lambda: negated(&self.lambda) }
    }

    /// The function f − constant.
    pub fn less(mut self, constant: f64) -> Self {
        self.value -= constant;
        self
    }

    /// |value| relative to its scale.
    fn error(&self) -> f64 {
        if self.value == 0.0 { 0.0 } else { self.value.abs() / self.scale }
    }
}

/// One piece of a law: `equation` = 0 holds while each function in `inequalities` is ≥ 0. If one of them is negative, the piece with the index given
/// with it is active instead.
#[derive(Clone, Debug, PartialEq)]
pub struct LawPiece {
    pub equation: LinearFunction,
    pub inequalities: Vec<(LinearFunction, usize)>,
}

impl LawPiece {
    /// Residual of this piece, relative to the scales.
    pub fn error(&self) -> f64 {
        let violated = self.inequalities.iter().filter(|(f, _)| f.value < 0.0);
        violated.map(|(f, _)| f.error()).fold(self.equation.error(), larger)
    }
}

/// The law 0 ≤ λ_c ≤ most: `gap` = 0 between the bounds, ≥ 0 at λ_c = 0, ≤ 0 at λ_c = `most`.
pub fn bounded_multiplier(all: &ConstraintValues, c: usize, gap: LinearFunction, most: f64) -> Vec<LawPiece> {
    let lambda = LinearFunction::multiplier(all, c, 0.0);
    let mut held = LawPiece { equation: gap.clone(), inequalities: vec![(lambda.clone(), 1)] };
    let open = LawPiece { equation: lambda, inequalities: vec![(gap.clone(), 0)] };
    if most == f64::INFINITY {
        return vec![held, open];
    }
    let limit = LinearFunction::multiplier(all, c, most);
    held.inequalities.push((limit.negative(), 2));
    vec![held, open, LawPiece { equation: limit, inequalities: vec![(gap.negative(), 0)] }]
}

/// The law of constraint `c` at this state; in its first piece the constraint is active.
pub fn constraint_law(constraint: &dyn Constraint, c: usize, all: &ConstraintValues) -> Vec<LawPiece> {
    let gap = || LinearFunction::gap(all, c..c + 1, constraint.scale());
    match constraint.kind() {
        ConstraintKind::Equality => vec![LawPiece { equation: gap(), inequalities: Vec::new() }],
        ConstraintKind::Unilateral => bounded_multiplier(all, c, gap(), f64::INFINITY),
        ConstraintKind::Bounded(most) => bounded_multiplier(all, c, gap(), most),
        ConstraintKind::Linked => constraint.linked_law(c, all),
        ConstraintKind::Monitored => {
            vec![LawPiece { equation: LinearFunction::multiplier(all, c, 0.0), inequalities: Vec::new() }]
        }
    }
}
