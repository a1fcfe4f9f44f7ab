//! Stress of effects at the quadrature points of their cells.

use super::cell::CellPoints;
use super::constitution::Constitution;
use crate::material::{Law, LawError, Moduli};
use crate::math::tensor::Mat3;
use crate::mesh::TetMesh;
use crate::system::Effect;
use std::sync::Arc;

/// An effect with stress at the points of cells.
pub trait PointStress: Send + Sync {
    fn points(&self) -> &Arc<CellPoints>;
    /// P \[Pa\] at the points of block `b`, as in the residual.
    fn stress(&self, x: &[f64], b: usize) -> Result<Vec<Mat3>, LawError>;
    /// Whether the law is one of small strains, by which P is the stress of the place as well.
    fn has_small_strains(&self) -> bool {
        false
    }
}

/// An elastic effect of a law, with its derivatives by the constants.
pub trait Stressed: PointStress + Effect {
    /// Whether the volume change is penalised point by point, without a pressure field; only such elements can lock.
    fn displacement_only(&self) -> bool;
    /// Hooke's constants at F = I
    fn moduli(&self) -> Moduli;
    /// J and G(J) − p/κ at the points of block `b`; none for a formulation without pressures, and where the law is not defined.
    fn volume_gaps(&self, x: &[f64], b: usize) -> Option<Vec<(f64, f64)>> {
        let _ = (x, b);
        None
    }
    /// ∂/∂θ of this effect, on its blocks, from ∂/∂θ of its law ([`Law::along`]): its residual is ∂r/∂θ at fixed x.
    fn along(&self, mesh: &TetMesh, law: Box<dyn Law>) -> Box<dyn Effect>;
    /// The parts from which its forces at a point follow; none where these depend on more than that point.
    fn constitution(&self) -> Option<Constitution<'_>> {
        None
    }
}

/// An effect whose stress at the points of cells depends on what it remembers: it relaxes, or softens.
pub trait HistoryStress: Effect {
    fn points(&self) -> &Arc<CellPoints>;
    /// P \[Pa\] at the points of block `b` of an accepted state, as in the residual; `history` is that of the effect at the state.
    fn stress(&self, x: &[f64], history: &[f64], b: usize) -> Result<Vec<Mat3>, LawError>;
}

/// The stress of such an effect at a state.
pub struct StressAtState<'a> {
    pub effect: &'a dyn HistoryStress,
    /// History of the effect there
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
