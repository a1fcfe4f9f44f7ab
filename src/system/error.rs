//! Errors of evaluations.

use crate::material::LawError;

/// An effect is not defined at this state; a shorter step may avoid that.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EvalError {
    /// det F ≤ 0 at a quadrature point of a law that needs J > 0
    #[error("{effect}: cell {cell} is inverted (J = {j:.3e})")]
    Inverted { effect: String, cell: usize, j: f64 },
    /// The cell is stretched beyond the range of the law (fully stretched chains): Ī₁ − 3 = i ≥ limit \[–\]
    #[error("{effect}: cell {cell} is stretched beyond the range of its law (Ī₁ − 3 = {i:.3e}, limit {limit:.3e})")]
    Locked { effect: String, cell: usize, i: f64, limit: f64 },
    /// The deformation is outside the domain of a law
    #[error("{effect}: cell {cell} is deformed beyond the domain of its law")]
    Undefined { effect: String, cell: usize },
    /// Two consecutive guides coincide, so that the direction of the cable is undefined
    #[error("{effect}: the ends of segment {segment} coincide")]
    Degenerate { effect: String, segment: usize },
    /// No deformed normal of a membrane balances its stress
    #[error("{effect}: no thickness on cell {cell} balances its stress")]
    NoThickness { effect: String, cell: usize },
    /// The two nodes of an edge coincide, so that its direction is undefined
    #[error("{effect}: nodes {} and {} coincide", .nodes[0], .nodes[1])]
    Coincident { effect: String, nodes: [u32; 2] },
    /// det A = j ≤ 0 of a rigid body: its mirror image has no strain, but no motion leads there
    #[error("{effect}: the rigid body is turned inside out (J = {j:.3e})")]
    InsideOut { effect: String, j: f64 },
    /// A point of the surface is inside an obstacle, by −gap \[m\], or, if the gap is not negative, has passed through it
    #[error("{effect}: the surface {} at node {node}", place_of_crossing(*.gap))]
    Crossed { effect: String, node: u32, gap: f64 },
}

fn place_of_crossing(gap: f64) -> String {
    if gap < 0.0 {
        format!("is {:.3e} m inside the obstacle", -gap)
    } else {
        "passes through the obstacle within one step".into()
    }
}

impl EvalError {
    /// Effect, cell and node at which the error occurred.
    pub fn place(&self) -> (&str, Option<usize>, Option<u32>) {
        match self {
            Self::Inverted { effect, cell, .. }
            | Self::Locked { effect, cell, .. }
            | Self::Undefined { effect, cell }
            | Self::NoThickness { effect, cell } => (effect, Some(*cell), None),
            Self::Degenerate { effect, .. } | Self::InsideOut { effect, .. } => (effect, None, None),
            Self::Coincident { effect, nodes } => (effect, None, Some(nodes[0])),
            Self::Crossed { effect, node, .. } => (effect, None, Some(*node)),
        }
    }

    /// Converts the error of a law at a quadrature point of a cell.
    pub fn of_law(effect: &str, cell: usize, error: LawError) -> Self {
        let effect = effect.to_string();
        match error {
            LawError::Inverted { j } => Self::Inverted { effect, cell, j },
            LawError::Locked { i, limit } => Self::Locked { effect, cell, i, limit },
            LawError::Undefined => Self::Undefined { effect, cell },
        }
    }
}
