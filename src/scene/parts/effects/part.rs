//! The interface of a kind of effect to the scene.

use crate::math::tensor::Vec3;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// Specification of an effect, with its construction and description.
pub(in crate::scene) trait EffectPart {
    /// The effect on the mesh of the scene; what other parts need of it is gathered in the builder.
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError>;

    /// Its keys in words: `region body, law rubber, formulation mixed`.
    fn words(&self) -> String;

    /// The table of the law that it takes.
    fn law(&self) -> Option<&str> {
        None
    }

    /// The region whose cells it makes elastic, and whether it adds to another effect there.
    fn resists(&self) -> Option<(&str, bool)> {
        None
    }

    /// The ball on which it acts, by its centre and its radius \[m\].
    fn ball(&self) -> Option<(Vec3, f64)> {
        None
    }

    /// Whether it acts on velocities or accelerations, so that it is at rest in static stages.
    fn needs_rates(&self) -> bool {
        false
    }

    /// Whether it is built after the other kinds, because it acts through them.
    fn needs_others(&self) -> bool {
        false
    }

    /// Refuses it where it contradicts the other effects, all of which are built; `number` counts from 1 in the file.
    fn check(&self, _number: usize, _builder: &mut Builder) -> Result<(), SceneError> {
        Ok(())
    }

    /// Notes its meaning in the stages of the scene, and under its constraints.
    fn note(&self, _builder: &mut Builder) {}

    /// Reason why the answer has no limit as h → 0.
    fn no_limit(&self) -> Option<&'static str> {
        None
    }
}

/// Stiffness of an effect in cells where another one is elastic too.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum OverlapSpec {
    /// It is added to that of the other effect
    Add,
}
