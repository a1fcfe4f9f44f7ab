//! The interface of a kind of constraint to the scene.

use crate::scene::build::builder::Builder;
use crate::scene::record::recorder::Headline;

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

    /// Whether it has friction, so that its forces depend on the path.
    fn has_friction(&self) -> bool {
        false
    }

    /// The region whose displacements it prescribes, and the components of them.
    fn held(&self) -> Option<(&str, &str)> {
        None
    }

    /// Notes its sizes next to h; returns the reason why the answer has no limit as h → 0, if there is one.
    fn note(&self, _builder: &mut Builder) -> Option<String> {
        None
    }
}
