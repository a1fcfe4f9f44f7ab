//! Constraint `prescribed`: components of the displacement of a region that follow a signal.

use super::part::ConstraintPart;
use crate::math::units::Dimension;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::signal::SignalSpec;
use serde::Deserialize;

/// A region with a prescribed displacement.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrescribedSpec {
    pub region: String,
    pub components: String,
    pub displacement: SignalSpec,
}

impl PrescribedSpec {
    /// Prescribes the motion of the nodes of the region.
    pub(super) fn build(&self, builder: &mut Builder, place: &str) -> Result<(), SceneError> {
        let Self { region, components, displacement } = self;
        let name = format!("{region}_{components}_displacement_m");
        let signal = builder.signal(place, name, displacement, Dimension::LENGTH)?;
        builder.prescribe(place, region, components, &signal)
    }
}

impl ConstraintPart for PrescribedSpec {}
