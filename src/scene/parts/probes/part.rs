//! The interface of a kind of probe to the scene.

use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Headline, Recorder};

/// Specification of a probe.
pub(in crate::scene) trait Probe {
    /// Builds the recorder on the mesh of the scene.
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError>;

    /// A note on a column that the probe leaves out on this mesh.
    fn note(&self, _place: &str, _builder: &Builder) -> Option<String> {
        None
    }

    /// The regions on which the probe depends.
    fn regions(&self) -> Vec<&str> {
        vec![]
    }

    /// The quantity that represents the probe, if it has one.
    fn headline(&self) -> Option<Headline> {
        None
    }
}
