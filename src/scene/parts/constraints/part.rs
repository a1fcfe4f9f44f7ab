//! The interface of a kind of constraint to the scene.

use crate::scene::build::builder::Builder;
use crate::scene::record::recorder::Headline;

/// The motion of a node in one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::scene) enum Motion {
    /// Determined by the equations
    Free,
    /// Held at zero
    Held,
    /// Prescribed by the constraint of this number
    Prescribed(usize),
    /// With the rigid part that the constraint of this number makes
    Rigid(usize),
}

/// Nodes whose motion a constraint determines.
pub(in crate::scene) struct Moved<'a> {
    pub region: &'a str,
    /// Components, such as `"xy"`
    pub components: &'a str,
    pub motion: Motion,
}

/// Specification of a constraint, with the facts that the scene needs to know about it.
pub(in crate::scene) trait ConstraintPart {
    /// The quantity by which runs are compared, if the constraint has one.
    fn headline(&self) -> Option<Headline> {
        None
    }

    /// A name for the constraint if it is enforced exactly, so that an undamped integrator rings: `a cable driven by length`.
    fn exact(&self) -> Option<&'static str> {
        None
    }

    /// The nodes whose motion the constraint determines, if there are any; `number` is its index among all constraints.
    fn moves(&self, _number: usize) -> Option<Moved<'_>> {
        None
    }

    /// Whether the constraint has friction, so that its forces depend on the path.
    fn has_friction(&self) -> bool {
        false
    }

    /// Adds notes on sizes that do not suit h; returns the reason why the solution has no limit as h → 0, if there is one.
    fn note(&self, _builder: &mut Builder) -> Option<String> {
        None
    }
}
