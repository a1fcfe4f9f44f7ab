//! The interface of a kind of constraint to the scene.

use crate::scene::build::builder::Builder;
use crate::scene::record::recorder::Headline;

/// The motion of a node in one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::scene) enum Motion {
    /// By the equations
    Free,
    /// None
    Held,
    /// Prescribed by the constraint of this number
    Prescribed(usize),
    /// With the rigid part that the constraint of this number makes
    Rigid(usize),
}

/// Nodes whose motion a constraint determines.
pub(in crate::scene) struct Moved<'a> {
    pub region: &'a str,
    /// Such as `"xy"`
    pub components: &'a str,
    pub motion: Motion,
}

/// Specification of a constraint, with what the scene asks of it.
pub(in crate::scene) trait ConstraintPart {
    /// The quantity by which runs are compared, if it has one.
    fn headline(&self) -> Option<Headline> {
        None
    }

    /// The part in words, if it is kept exactly, so that an undamped integrator rings: `a cable driven by length`.
    fn exact(&self) -> Option<&'static str> {
        None
    }

    /// The nodes whose motion it determines, if there are any; `number` is its place among all.
    fn moves(&self, _number: usize) -> Option<Moved<'_>> {
        None
    }

    /// Whether it has friction, so that its forces depend on the path.
    fn has_friction(&self) -> bool {
        false
    }

    /// Notes its sizes next to h; returns the reason why the answer has no limit as h → 0, if there is one.
    fn note(&self, _builder: &mut Builder) -> Option<String> {
        None
    }
}
