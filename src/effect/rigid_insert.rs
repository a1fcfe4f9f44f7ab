//! Rigid part of a body: its nodes follow four nodes p_a by x = Σ_a w_a(X) p_a, which six multipliers keep rigid.
//!
//! ```text
//! g_ij = −½ ℓ (a_i·a_j − δ_ij) = 0, i ≤ j        a_i = (p_i − p_0)/ℓ, the columns of A = ∂x/∂X
//! ```
//!
//! AᵀA = I then holds to the tolerance of constraints: the part translates and rotates without deforming. The multipliers are its mean stress times
//! areas of the order ℓ².

use super::contact::placement::AffineFrame;
use crate::math::signal::Clock;
use crate::math::tensor::Vec3;
use crate::system::{BlockValues, Blocks, Constraint, ConstraintKind, EvalError, Want};

/// One of the six conditions under which four nodes are rigid.
pub struct Rigid {
    name: String,
    frame: AffineFrame,
    blocks: Blocks,
    /// i, j
    pair: [usize; 2],
}

impl Rigid {
    /// Returns all six conditions of a frame.
    pub fn all(name: &str, frame: &AffineFrame) -> Vec<Box<dyn Constraint>> {
        let pairs = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]];
        let one = |pair| {
            let blocks = Blocks::new(std::iter::once(&frame.nodes[..]));
            Box::new(Self { name: name.into(), frame: frame.clone(), blocks, pair }) as Box<dyn Constraint>
        };
        pairs.map(one).into()
    }
}

impl Constraint for Rigid {
    fn name(&self) -> &str {
        &self.name
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::Equality
    }

    fn scale(&self) -> f64 {
        self.frame.length
    }

    fn target(&self, _: Clock) -> f64 {
        0.0
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, x: &[f64], _: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let ([i, j], length) = (self.pair, self.frame.length);
        let a = self.frame.gradient(&self.frame.positions(x));
        let column = |i: usize| -> Vec3 { a.column(i).into() };
        out.energy = 0.5 * length * (column(i).dot(&column(j)) - f64::from(u8::from(i == j)));
        if want == Want::Energy {
            return Ok(());
        }
        // ∂(p_i − p_0)/∂p_k
        let sign = |i: usize, k: usize| f64::from(i8::from(k == i + 1) - i8::from(k == 0));
        for k in 0..4 {
            let gradient = (column(j) * sign(i, k) + column(i) * sign(j, k)) * 0.5;
            out.r[3 * k..3 * k + 3].copy_from_slice(gradient.as_slice());
            if want < Want::Tangent {
                continue;
            }
            for l in 0..=k {
                let second = 0.5 / length * (sign(i, k) * sign(j, l) + sign(j, k) * sign(i, l));
                (0..3).for_each(|d| out.k[(3 * k + d) * 12 + 3 * l + d] = second);
            }
        }
        Ok(())
    }
}
