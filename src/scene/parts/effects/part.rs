//! The interface of a kind of effect to the scene.

use crate::math::tensor::Vec3;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// Specification of an effect, with its construction and description.
pub(in crate::scene) trait EffectPart {
    /// Builds the effect on the mesh of the scene; results that other parts need are gathered in the builder.
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError>;

    /// The keys of the effect in words: `region body, law rubber, formulation mixed`.
    fn words(&self) -> String;

    /// The name of the law that the effect uses.
    fn law(&self) -> Option<&str> {
        None
    }

    /// The region whose cells the effect makes elastic, and whether it adds to another effect there.
    fn resists(&self) -> Option<(&str, bool)> {
        None
    }

    /// The ball on which the effect acts, as its centre and its radius \[m\].
    fn ball(&self) -> Option<(Vec3, f64)> {
        None
    }

    /// Whether the effect acts on velocities or accelerations, so that it vanishes in static stages.
    fn needs_rates(&self) -> bool {
        false
    }

    /// Whether the effect is built after the other kinds, because it acts through them.
    fn needs_others(&self) -> bool {
        false
    }

    /// Refuses the effect if it contradicts other effects, all of which have been built; `number` counts from 1 in the file.
    fn check(&self, _number: usize, _builder: &mut Builder) -> Result<(), SceneError> {
        Ok(())
    }

    /// Adds notes on the meaning of the effect in the stages of the scene and under its constraints.
    fn note(&self, _builder: &mut Builder) {}

    /// The reason why the solution has no limit as h → 0, if there is one.
    fn no_limit(&self) -> Option<&'static str> {
        None
    }
}

/// Treatment of the stiffness of an effect in cells in which another effect is elastic too.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum OverlapSpec {
    /// Adds it to that of the other effect
    Add,
}
