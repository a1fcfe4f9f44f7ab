//! The parts of an elastic effect that determine its forces at a point.

use super::cell::CellPoints;
use crate::material::LawCard;
use crate::system::Blocks;

/// Law, points and blocks of an elastic effect whose forces at a point depend on the deformation gradient there, and on a pressure field if it
/// has one.
pub struct Constitution<'a> {
    /// The whole law
    pub law: LawCard,
    pub points: &'a CellPoints,
    /// Blocks of the effect
    pub blocks: &'a Blocks,
    pub pressure: Option<PressureField<'a>>,
}

/// The pressure field of a mixed formulation, Π = ∫ ψ̃(F) + p G(J) dV − ½ πᵀ C π.
#[derive(Clone, Copy)]
pub struct PressureField<'a> {
    /// s in p = s π \[Pa/m\]
    pub scale: f64,
    /// \[points × 4\] shape functions of the corners
    pub shape: &'a [[f64; 4]],
    /// \[blocks\] C \[N/m\]
    pub compliance: &'a [[[f64; 4]; 4]],
}
