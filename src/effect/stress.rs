//! Stress of effects at the quadrature points of their cells.

use super::cell::CellPoints;
use super::constitution::Constitution;
use crate::material::{Law, LawError, Moduli};
use crate::math::tensor::Mat3;
use crate::mesh::TetMesh;
use crate::system::Effect;
use std::sync::Arc;

/// An effect that has stress at the quadrature points of cells.
pub trait PointStress: Send + Sync {
    fn points(&self) -> &Arc<CellPoints>;
    /// Returns P \[Pa\] at the points of block `b`, as in the residual.
    fn stress(&self, x: &[f64], b: usize) -> Result<Vec<Mat3>, LawError>;
    /// Whether the law is a small-strain law, for which P also serves as the Cauchy stress.
    fn has_small_strains(&self) -> bool {
        false
    }
}

/// An elastic effect of a law, with its derivatives with respect to the constants.
pub trait Stressed: PointStress + Effect {
    /// Whether changes of volume are penalised pointwise, without a pressure field; only such elements can lock.
    fn displacement_only(&self) -> bool;
    /// Hooke's constants at F = I
    fn moduli(&self) -> Moduli;
    /// Returns J and G(J) − p/κ at the points of block `b`; `None` for a formulation without pressures, and if the law is undefined.
    fn volume_gaps(&self, x: &[f64], b: usize) -> Option<Vec<(f64, f64)>> {
        let _ = (x, b);
        None
    }
    /// Returns ∂/∂θ of this effect, on its blocks, from ∂/∂θ of its law ([`Law::along`]): its residual is ∂r/∂θ at fixed x.
    fn along(&self, mesh: &TetMesh, law: Box<dyn Law>) -> Box<dyn Effect>;
    /// Returns the parts that determine its forces at a point; `None` if these depend on more than that point.
    fn constitution(&self) -> Option<Constitution<'_>> {
        None
    }
}

/// An effect whose stress at the quadrature points depends on a history: it relaxes or softens.
pub trait HistoryStress: Effect {
    fn points(&self) -> &Arc<CellPoints>;
    /// Returns P \[Pa\] at the points of block `b` of an accepted state, as in the residual; `history` is the history of the effect in that state.
    fn stress(&self, x: &[f64], history: &[f64], b: usize) -> Result<Vec<Mat3>, LawError>;
}

/// The stress of an effect with a history, in a given state.
pub struct StressAtState<'a> {
    pub effect: &'a dyn HistoryStress,
    /// History of the effect in that state
    pub history: &'a [f64],
}

impl PointStress for StressAtState<'_> {
    fn points(&self) -> &Arc<CellPoints> {
        self.effect.points()
    }

    fn stress(&self, x: &[f64], b: usize) -> Result<Vec<Mat3>, LawError> {
        self.effect.stress(x, self.history, b)
    }
}
