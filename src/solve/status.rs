//! The end of a run, with the last good time, the fact, the culprit and the remedy.

use super::{Failure, Motion};
use crate::math::linear::LinearError;
use crate::math::units::Decimals;
use crate::system::EvalError;
use std::fmt;

/// The end of a run. t \[s\] is the time of the last good state.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    Converged,
    /// Arc length: the path of equilibria turned back at `limit` and did not reach the end of the stage
    LimitPoint {
        t: f64,
        /// Time at which the loads were largest \[s\]
        limit: f64,
    },
    /// The loads exceed the largest ones that this path of equilibria can carry, which are those of time `limit` \[s\]
    NoEquilibrium {
        t: f64,
        limit: f64,
        /// Node that moves most where the path turns
        node: u32,
        /// Whether there is contact, with which no path can be followed
        in_contact: bool,
        /// Whether a prescribed force, pressure or tension increases
        by_force: bool,
    },
    /// A cell would invert, where its law is not defined
    Inverted {
        t: f64,
        why: Failure,
        /// Whether prescribed displacements act in full before the first step
        in_full: bool,
    },
    /// Nothing resists some motion of the body, or of a part of it
    Singular {
        t: f64,
        /// The motions; empty if the tangent has no factorisation and no motion dominates
        motions: Vec<Motion>,
    },
    /// The allowed wall time is used up
    TimeBudget {
        t: f64,
    },
    /// Contact does not let the body move further
    ContactJammed {
        t: f64,
        why: Failure,
    },
    /// The factor of the tangent is larger than `factor_memory`, and no other method solves for it
    FactorTooLarge {
        t: f64,
        why: Failure,
    },
    /// No step, however small, converges
    StepTooSmall {
        t: f64,
        why: Failure,
        /// Whether a prescribed force, pressure or tension changes in the step
        by_force: bool,
    },
    /// A recorded column, a signal, or an input at the end of a step is not finite
    NotFinite {
        t: f64,
        column: String,
    },
    /// Stopped by the caller
    Interrupted {
        t: f64,
    },
}

/// The location of a failure.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Culprit {
    pub effect: Option<String>,
    /// Index in the mesh
    pub cell: Option<usize>,
    /// Index in the mesh
    pub node: Option<u32>,
}

/// The remedy if forces drive the body where motions could.
macro_rules! by_motion {
    () => {
        "prescribe a length, volume or displacement instead of a force, pressure or tension"
    };
}

/// The remedy if a load drives the body.
macro_rules! too_large {
    () => {
        concat!(
            "the load may exceed what the body can carry: reduce it, or ",
            by_motion!(),
            "; or the mesh is too coarse there"
        )
    };
}

/// The remedy if a motion drives the body.
macro_rules! folds {
    () => {
        "the body may buckle or fold under the prescribed motion, or hit something too fast: try a shorter dt, numerics.projection = true, a dynamic stage, or a finer mesh there"
    };
}

impl Status {
    /// The status of a step that no cut could save.
    pub(super) fn stopped(t: f64, why: Failure, by_force: bool) -> Self {
        match why {
            Failure::Eval(EvalError::Inverted { .. }) => Self::Inverted { t, why, in_full: false },
            Failure::Jammed { .. } => Self::ContactJammed { t, why },
            Failure::Linear(LinearError::Singular) => Self::Singular { t, motions: Vec::new() },
            Failure::NotFinite { input } => Self::NotFinite { t, column: input },
            Failure::Linear(
                LinearError::Indefinite { .. } | LinearError::Slow { .. } | LinearError::TooLarge { .. },
            ) => Self::FactorTooLarge { t, why },
            _ => Self::StepTooSmall { t, why, by_force },
        }
    }

    /// Name of the status in `summary.json`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Converged => "Converged",
            Self::LimitPoint { .. } => "LimitPoint",
            Self::NoEquilibrium { .. } => "NoEquilibrium",
            Self::Inverted { .. } => "Inverted",
            Self::Singular { .. } => "Singular",
            Self::TimeBudget { .. } => "TimeBudget",
            Self::ContactJammed { .. } => "ContactJammed",
            Self::FactorTooLarge { .. } => "FactorTooLarge",
            Self::StepTooSmall { .. } => "StepTooSmall",
            Self::NotFinite { .. } => "NotFinite",
            Self::Interrupted { .. } => "Interrupted",
        }
    }

    /// Time of the last good state \[s\]; `None` if the run was completed.
    pub fn t(&self) -> Option<f64> {
        match self {
            Self::Converged => None,
            Self::LimitPoint { t, .. }
            | Self::NoEquilibrium { t, .. }
            | Self::Inverted { t, .. }
            | Self::Singular { t, .. }
            | Self::TimeBudget { t }
            | Self::ContactJammed { t, .. }
            | Self::FactorTooLarge { t, .. }
            | Self::StepTooSmall { t, .. }
            | Self::NotFinite { t, .. }
            | Self::Interrupted { t } => Some(*t),
        }
    }

    /// Time of the largest loads that the path can carry \[s\], if it was found.
    pub fn limit(&self) -> Option<f64> {
        match self {
            Self::LimitPoint { limit, .. } | Self::NoEquilibrium { limit, .. } => Some(*limit),
            _ => None,
        }
    }

    /// The effect, cell or node at which the run failed.
    pub fn culprit(&self) -> Culprit {
        let node = |node| Culprit { node: Some(node), ..Culprit::default() };
        match self {
            Self::NoEquilibrium { node: k, .. } => node(*k),
            Self::Singular { motions, .. } => motions.first().map(|m| node(m.node)).unwrap_or_default(),
            Self::Inverted { why, .. } | Self::ContactJammed { why, .. } | Self::StepTooSmall { why, .. } => {
                match why {
                    Failure::Eval(e) => {
                        let (effect, cell, node) = e.place();
                        Culprit { effect: Some(effect.into()), cell, node }
                    }
                    Failure::NotConverged { node: k, .. }
                    | Failure::Inaccurate { node: k }
                    | Failure::InFull { node: k, .. } => node(*k),
                    Failure::Jammed { effect, node: k, .. } => Culprit { effect: Some(effect.clone()), ..node(*k) },
                    Failure::Linear(_)
                    | Failure::Complementarity
                    | Failure::Unloaded
                    | Failure::NoArc
                    | Failure::NotFinite { .. }
                    | Failure::LimitReached
                    | Failure::Landing
                    | Failure::MaxSteps => Culprit::default(),
                }
            }
            _ => Culprit::default(),
        }
    }

    /// The fact in a sentence, without the time.
    pub fn fact(&self) -> String {
        match self {
            Self::Converged => "converged".into(),
            Self::LimitPoint { limit, .. } => {
                format!(
                    "the path of equilibria turns back at the loads of t = {:.6} s and had not reached larger loads where it ended",
                    Decimals(*limit)
                )
            }
            Self::NoEquilibrium { limit, .. } => {
                format!(
                    "the path of equilibria ends at a limit point: the body cannot carry larger loads than those of t = {:.6} s",
                    Decimals(*limit)
                )
            }
            Self::Inverted { why, .. } => format!("no step however small avoids inversion: {why}"),
            Self::ContactJammed { why, .. } => format!("contact lets the body move no further: {why}"),
            Self::Singular { motions, .. } if motions.is_empty() => {
                "the tangent is singular: some part can move freely".into()
            }
            Self::Singular { motions, .. } => super::diagnosis::free_motions::sentence(motions),
            Self::TimeBudget { .. } => "the allowed wall time is used up".into(),
            Self::FactorTooLarge { why, .. }
            | Self::StepTooSmall { why: why @ (Failure::MaxSteps | Failure::Unloaded | Failure::Landing), .. } => {
                why.to_string()
            }
            Self::StepTooSmall { why, .. } => format!("no step however small converges: {why}"),
            Self::NotFinite { column, .. } => format!("the next value of {column} is not a finite number"),
            Self::Interrupted { .. } => "stopped".into(),
        }
    }

    /// The remedy; empty if the run converged.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Converged => "",
            Self::LimitPoint { .. } => "raise max_steps to follow it further, or drive by volume or displacement",
            Self::NoEquilibrium { in_contact: true, by_force: true, .. } => {
                concat!("stay below these loads, use a dynamic stage, or ", by_motion!())
            }
            Self::NoEquilibrium { in_contact: true, .. } => "stay below these loads, or use a dynamic stage",
            Self::NoEquilibrium { by_force: true, .. } => {
                concat!("stay below these loads, use continuation = \"arc_length\", or ", by_motion!())
            }
            Self::NoEquilibrium { .. } => {
                "stay below these loads, or use continuation = \"arc_length\" or a dynamic stage: beyond them the mesh has no \
                 equilibrium under the prescribed motion"
            }
            Self::Inverted { in_full: true, .. } => {
                "prescribed displacements that act in full from the start cannot be divided into smaller steps, and before a dynamic stage they deform only one \
                 layer of cells: let them begin at 0, such as by displacement = { kind = \"ramp\", from = \"0 mm\", to = \"10 mm\", end = \"1 s\" }, in this stage or in a static one before it"
            }
            Self::Inverted { .. } => {
                "refine the mesh there, reduce the load, or take a law that survives inversion (stable_neo_hookean)"
            }
            Self::ContactJammed { .. } => {
                "reduce the load or the motion of the obstacle, or refine the mesh where the body is squeezed"
            }
            Self::Singular { .. } => {
                "fix a region (a facet region with three nodes not on a line holds a body), or take a dynamic stage"
            }
            Self::TimeBudget { .. } => "raise time_budget, take a coarser mesh or larger steps",
            Self::StepTooSmall {
                why: Failure::Eval(EvalError::Locked { .. } | EvalError::Undefined { .. }), ..
            } => "reduce the load, or use a law without a limiting stretch",
            Self::StepTooSmall { why: Failure::Eval(EvalError::InsideOut { .. }), .. } => {
                "use a shorter dt, and let the forces on the body begin small: with a barrier, leave a gap of at least `distance` to the obstacle"
            }
            Self::StepTooSmall { why: Failure::Complementarity, .. } => {
                "let the drives of cables begin at zero and change in several steps, release one of several cables, or drive it by tension"
            }
            Self::FactorTooLarge { .. } => "raise numerics.factor_memory if the machine has it, or take a coarser mesh",
            Self::StepTooSmall { why: Failure::Linear(_), .. } => {
                "bring the stiffnesses of the parts closer to each other, or mesh without slivers"
            }
            Self::StepTooSmall { why: Failure::MaxSteps, .. } => {
                "raise max_steps, or take a larger dt: it is the length of the first step"
            }
            Self::StepTooSmall { why: Failure::Unloaded, .. } => {
                "let the signals of the loads change monotonically over the whole stage, or remove `continuation`"
            }
            Self::StepTooSmall { why: Failure::Landing, .. } => {
                "end the data before the impact, or take bdf2 or implicit_euler"
            }
            Self::StepTooSmall { why: Failure::InFull { .. }, .. } => concat!(
                "loads that act in full from the start cannot be divided into smaller steps: let them grow, such as by acceleration = { kind = \"ramp\", \
                 from = \"0 m/s^2\", to = \"9.81 m/s^2\", end = \"1 s\" }; or ",
                too_large!()
            ),
            Self::StepTooSmall { by_force: true, .. } => too_large!(),
            Self::StepTooSmall { .. } => folds!(),
            Self::NotFinite { .. } => "check the units and exponents of what it depends on",
            Self::Interrupted { .. } => "run it again",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.t() {
            None => write!(f, "converged"),
            Some(t) if matches!(self, Self::Interrupted { .. }) => write!(f, "stopped at t = {:.6} s", Decimals(t)),
            Some(t) => write!(f, "after t = {:.6} s: {}; {}", Decimals(t), self.fact(), self.remedy()),
        }
    }
}
