//! Errors of evaluations.

use crate::material::LawError;
use std::fmt;

/// An effect is not defined at this state; a shorter step may avoid it.
#[derive(Clone, Debug, PartialEq)]
pub enum EvalError {
    /// det F ≤ 0 at a quadrature point of a law that needs J > 0
    Inverted { effect: String, cell: usize, j: f64 },
    /// Stretched beyond the range of the law (fully stretched chains): Ī₁ − 3 = i ≥ limit \[–\]
    Locked { effect: String, cell: usize, i: f64, limit: f64 },
    /// Outside of the domain of a law that is defined elsewhere
    Undefined { effect: String, cell: usize },
    /// Two consecutive guides coincide: the direction of the cable is undefined
    Degenerate { effect: String, segment: usize },
    /// No image of the normal of a membrane balances its stress
    NoThickness { effect: String, cell: usize },
    /// The two nodes of an edge coincide: its direction is undefined
    Coincident { effect: String, nodes: [u32; 2] },
    /// A point of the surface is on the wrong side of an obstacle \[m\]
    Crossed { effect: String, node: u32, gap: f64 },
}

impl fmt::Display for EvalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inverted { effect, cell, j } => write!(f, "{effect}: cell {cell} is inverted (J = {j:.3e})"),
            Self::Locked { effect, cell, i, limit } => {
                write!(
                    f,
                    "{effect}: cell {cell} is stretched beyond the range of its law (Ī₁ − 3 = {i:.3e}, limit {limit:.3e})"
                )
            }
            Self::Undefined { effect, cell } => {
                write!(f, "{effect}: cell {cell} is deformed beyond the domain of its law")
            }
            Self::Degenerate { effect, segment } => {
                write!(f, "{effect}: the ends of segment {segment} coincide")
            }
            Self::NoThickness { effect, cell } => {
                write!(f, "{effect}: no thickness on cell {cell} balances its stress")
            }
            Self::Coincident { effect, nodes: [i, j] } => write!(f, "{effect}: nodes {i} and {j} coincide"),
            Self::Crossed { effect, node, gap } => {
                write!(f, "{effect}: the surface is {:.3e} m inside of the obstacle at node {node}", -gap)
            }
        }
    }
}

impl std::error::Error for EvalError {}

impl EvalError {
    /// Effect, cell and node at which the error occurred.
    pub fn place(&self) -> (&str, Option<usize>, Option<u32>) {
        match self {
            Self::Inverted { effect, cell, .. }
            | Self::Locked { effect, cell, .. }
            | Self::Undefined { effect, cell }
            | Self::NoThickness { effect, cell } => (effect, Some(*cell), None),
            Self::Degenerate { effect, .. } => (effect, None, None),
            Self::Coincident { effect, nodes } => (effect, None, Some(nodes[0])),
            Self::Crossed { effect, node, .. } => (effect, None, Some(*node)),
        }
    }

    /// Of a law at a quadrature point of a cell.
    pub fn of_law(effect: &str, cell: usize, error: LawError) -> Self {
        let effect = effect.to_string();
        match error {
            LawError::Inverted { j } => Self::Inverted { effect, cell, j },
            LawError::Locked { i, limit } => Self::Locked { effect, cell, i, limit },
            LawError::Undefined => Self::Undefined { effect, cell },
        }
    }
}
