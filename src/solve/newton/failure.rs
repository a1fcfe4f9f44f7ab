//! Reasons why a nonlinear solve failed, with a sentence for each.

use crate::math::linear::LinearError;
use crate::system::EvalError;
use std::fmt;

/// Reason why a nonlinear solve did not converge.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// An effect is not defined at the state that was reached
    Eval(EvalError),
    Linear(LinearError),
    /// Too many iterations, or the residual does not decrease: the residual relative to its scale, and the node where it is largest
    NotConverged {
        residual: f64,
        node: u32,
    },
    /// The first step did not converge, with loads or motions that act in full from the start: a shorter step does not reduce them
    InFull {
        residual: f64,
        node: u32,
    },
    /// The forces balance, but within the allowed iterations the displacement still changed or had not reached its prescribed value; the node where
    /// this is worst
    Inaccurate {
        node: u32,
    },
    /// No multipliers satisfy the unilateral constraints
    Complementarity,
    /// An effect does not let the body move further: the distance of the node from the obstacle \[m\]
    Jammed {
        effect: String,
        node: u32,
        gap: f64,
    },
    /// Arc length: the loads do not change at a point of the path
    Unloaded,
    /// Arc length: the linearised equations have no solution at the required distance
    NoArc,
    /// An input at the end of the step is not finite: a displacement, a load or a constraint
    NotFinite {
        input: String,
    },
    /// The time limit is reached, or the run is to stop
    LimitReached,
    /// Arc length: the end of the stage is not reached in the allowed number of steps
    MaxSteps,
    /// Sensitivities: points land in the step, where their velocities jump
    Landing,
}

impl Failure {
    /// Whether the factor of the tangent is larger than allowed and no other method is suited for the scene, so that smaller steps do not help.
    pub(in crate::solve) fn is_of_memory(&self) -> bool {
        matches!(self, Self::Linear(LinearError::TooLarge { .. }))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Eval(e) => e.fmt(f),
            Self::Linear(e) => e.fmt(f),
            Self::NotConverged { residual, node } | Self::InFull { residual, node } => {
                write!(f, "the residual stays at {residual:.1e} of the internal forces, largest at node {node}")
            }
            Self::Inaccurate { node } => write!(
                f,
                "the forces balance, but the displacement still changes or has not reached its prescribed value, worst at node {node}"
            ),
            Self::Complementarity => write!(f, "no forces satisfy all one-sided constraints together"),
            Self::Jammed { effect, node, gap } => {
                write!(f, "{effect}: node {node} is {gap:.3e} m from the obstacle and is pressed on")
            }
            Self::LimitReached => write!(f, "the time is over, or the run was stopped"),
            Self::MaxSteps => {
                write!(f, "the path of equilibria does not reach the end of the stage in max_steps steps")
            }
            Self::Landing => {
                write!(f, "points hit their obstacle, and the jump of their velocities cannot be differentiated")
            }
            Self::NoArc => {
                write!(f, "Newton's method finds no point of the path of equilibria within one step")
            }
            Self::Unloaded => write!(f, "the loads do not change there, so that the path cannot be continued"),
            Self::NotFinite { input } => write!(f, "{input} is not a finite number"),
        }
    }
}
