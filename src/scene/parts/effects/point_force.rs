//! Effect `point_force`: a force of fixed direction on an embedded point, or on the patch around it.

use super::part::EffectPart;
use crate::effect::dead_load::DeadLoad;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::embed::embed;
use crate::mesh::error::point;
use crate::scene::build::builder::Builder;
use crate::scene::error::{SceneError, part};
use crate::scene::parts::patch::{check_radius, note_cut, note_radius};
use crate::scene::signal::SignalSpec;
use crate::scene::text::quantity::{GuideRadius, Length};
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// A force of fixed direction on an embedded point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointForceSpec {
    /// Prefix of the columns; `point_force` if absent
    #[serde(default = "point_force")]
    pub name: String,
    /// Point inside the body at rest
    pub point: [Length; 3],
    /// Radius of the patch to which the force is applied
    pub radius: GuideRadius,
    /// Direction of the force, fixed in space; its length does not matter
    pub direction: [f64; 3],
    /// Force \[N\]
    pub force: SignalSpec,
}

fn point_force() -> String {
    "point_force".into()
}

impl PointForceSpec {
    fn at(&self) -> Vec3 {
        Vec3::from(self.point.map(|x| x.0))
    }
}

impl EffectPart for PointForceSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let (at, body) = (self.at(), builder.body.clone());
        let embedded = embed(&body.mesh, at).map_err(|e| part(builder.file, place, e))?;
        let weights = match self.radius {
            GuideRadius::Point => {
                builder.no_limits.push("a force on a point moves it further the finer the mesh".into());
                embedded.weights
            }
            GuideRadius::Ball(radius) => {
                check_radius(builder, place, "radius", radius)?;
                note_radius(builder, &self.name, "the radius", radius);
                body.patches.weights(&body.mesh, at, radius).map_err(|e| part(builder.file, place, e))?
            }
        };
        let column = format!("{}_imposed_N", self.name);
        let (direction, signal) = builder.dead(place, self.direction, &self.force, Dimension::FORCE, column)?;
        Ok(Box::new(DeadLoad::new(self.name.clone(), &weights, direction, signal)))
    }

    fn words(&self) -> String {
        let patch = match self.radius {
            GuideRadius::Point => "on a point".to_string(),
            GuideRadius::Ball(radius) => format!("on a ball of {:.4} mm", radius * 1e3),
        };
        format!("at {}, {patch}, towards {:?}", point(&self.at()), self.direction)
    }

    fn ball(&self) -> Option<(Vec3, f64)> {
        match self.radius {
            GuideRadius::Point => None,
            GuideRadius::Ball(radius) => Some((self.at(), radius)),
        }
    }

    fn note(&self, builder: &mut Builder) {
        if let GuideRadius::Ball(radius) = self.radius {
            let ball = (format!("the one at {}", point(&self.at())), self.at());
            note_cut(builder, &self.name, "radius", radius, &[ball]);
        }
    }
}
