//! Constraint `prescribed`: components of the displacement of a region that follow a signal, or those of a rotation by a signal.

use super::part::ConstraintPart;
use crate::math::units::Dimension;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::signal::SignalSpec;
use crate::scene::turning::TurningSpec;
use serde::Deserialize;

/// A region with a prescribed motion: a displacement, or a rotation.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrescribedSpec {
    pub region: String,
    /// Components prescribed: "x", "yz", …; all of a rotation if absent
    #[serde(default)]
    pub components: String,
    /// The same for each of the components
    pub displacement: Option<SignalSpec>,
    /// A finite rotation: every node is on its circle at every time
    pub rotation: Option<TurningSpec>,
}

impl PrescribedSpec {
    /// Prescribes the motion of the nodes of the region.
    pub(super) fn build(&self, builder: &mut Builder, place: &str) -> Result<(), SceneError> {
        let Self { region, components, displacement, rotation } = self;
        match (displacement, rotation) {
            (Some(displacement), None) => {
                let name = format!("{region}_{components}_displacement_m");
                let signal = builder.signal(place, name, displacement, Dimension::LENGTH)?;
                builder.prescribe(place, region, components, |_, _| signal.clone())
            }
            (None, Some(rotation)) => {
                let components = if components.is_empty() { "xyz" } else { components };
                let turning = rotation.build(builder, place, format!("{region}_rotation_rad"))?;
                builder.prescribe(place, region, components, |at, i| turning.displacement(at, i))
            }
            (None, None) => Err(builder.content(place, "it has no motion", "give `displacement` or `rotation`")),
            (Some(_), Some(_)) => {
                let fact = "it has a `displacement` and a `rotation`";
                let remedy =
                    "give the rotation some `components`, and the displacement the others in a constraint of its own";
                Err(builder.content(place, fact, remedy))
            }
        }
    }
}

impl ConstraintPart for PrescribedSpec {}
