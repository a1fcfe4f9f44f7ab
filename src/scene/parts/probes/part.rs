//! The interface of a kind of probe to the scene.

use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Headline, Recorder};

/// Specification of a probe.
pub(in crate::scene) trait Probe {
    /// The recorder on the mesh of the scene.
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError>;

    /// A note on a column that it leaves out there.
    fn note(&self, _place: &str, _builder: &Builder) -> Option<String> {
        None
    }

    /// The regions on which it is recorded.
    fn regions(&self) -> Vec<&str> {
        vec![]
    }

    /// The quantity that represents the probe, if it has one.
    fn headline(&self) -> Option<Headline> {
        None
    }
}
