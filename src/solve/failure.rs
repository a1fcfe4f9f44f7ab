//! Reasons for the failure of one nonlinear solve, in a sentence.

use crate::math::linear::LinearError;
use crate::system::EvalError;
use std::fmt;

/// Reason why a nonlinear solve did not converge.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// The effect is not defined at the state reached
    Eval(EvalError),
    Linear(LinearError),
    /// Too many iterations or no decrease: the residual relative to its scale, and the node where it is largest
    NotConverged {
        residual: f64,
        node: u32,
    },
    /// No multiplier satisfies the one-sided constraints
    Complementarity,
    /// An effect lets the body move no further: how far the node is from what it must not pass \[m\]
    Jammed {
        effect: String,
        node: u32,
        gap: f64,
    },
    /// Arc length: the loads do not change where the stage starts
    Unloaded,
    /// The time is over, or the run is to stop
    LimitReached,
    /// Arc length: the end of the stage is not reached in the steps that were allowed
    MaxSteps,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Eval(e) => e.fmt(f),
            Self::Linear(e) => e.fmt(f),
            Self::NotConverged { residual, node } => {
                write!(f, "the residual stays at {residual:.1e} of the internal forces, largest at node {node}")
            }
            Self::Complementarity => write!(f, "no forces satisfy all one-sided constraints together"),
            Self::Jammed { effect, node, gap } => {
                write!(f, "{effect}: node {node} is {gap:.3e} m from the obstacle and is pressed on")
            }
            Self::LimitReached => write!(f, "the time is over, or the run was stopped"),
            Self::MaxSteps => {
                write!(f, "the path of equilibria does not reach the end of the stage in max_steps steps")
            }
            Self::Unloaded => write!(f, "the loads do not change where the stage starts"),
        }
    }
}
