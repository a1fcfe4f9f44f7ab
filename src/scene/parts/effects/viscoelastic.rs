//! Effect `viscoelastic`: relaxation of a region by a Prony series, in addition to an elastic effect with the same law.

use super::of_law::check_elastic_with;
use super::part::EffectPart;
use crate::effect::Viscoelastic;
use crate::material::{Arm, Constants, Prony};
use crate::scene::build::builder::Builder;
use crate::scene::error::{SceneError, part};
use crate::scene::text::quantity::Time;
use crate::schema::any_of;
use crate::system::Effect;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

/// Relaxation of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscoelasticSpec {
    /// Region of cells that relax
    pub region: String,
    /// Law of the elastic effect there
    pub law: String,
    /// Modulus to which the constants of the law refer
    pub moduli: ModuliSpec,
    /// Terms of the Prony series, or the file of a fit
    pub prony: SeriesSpec,
}

/// The terms of a Prony series. A file may also have `{ include = "prony.toml" }`, which is replaced by the terms of that file before the scene is built.
#[derive(Clone, Debug, Default)]
pub struct SeriesSpec(pub Vec<ArmSpec>);

impl From<Vec<ArmSpec>> for SeriesSpec {
    fn from(terms: Vec<ArmSpec>) -> Self {
        Self(terms)
    }
}

impl<'de> Deserialize<'de> for SeriesSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Terms)
    }
}

impl JsonSchema for SeriesSpec {
    fn schema_name() -> Cow<'static, str> {
        "SeriesSpec".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        any_of(&[generator.subschema_for::<Vec<ArmSpec>>(), generator.subschema_for::<IncludeSpec>()])
    }
}

/// Reads a list of terms, or the name of a file that contains one.
struct Terms;

impl<'de> Visitor<'de> for Terms {
    type Value = SeriesSpec;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of terms such as [{ g = 0.2, tau = \"0.1 s\" }], or { include = \"prony.toml\" }")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<SeriesSpec, A::Error> {
        let mut terms = Vec::new();
        while let Some(term) = list.next_element()? {
            terms.push(term);
        }
        Ok(SeriesSpec(terms))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SeriesSpec, A::Error> {
        IncludeSpec::deserialize(MapAccessDeserializer::new(map)).map(|_| SeriesSpec::default())
    }
}

/// A file whose value of the same key replaces this table.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct IncludeSpec {
    /// Path of the included file, relative to the scene
    #[serde(rename = "include")]
    _include: String,
}

/// Modulus to which the constants of a law refer.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ModuliSpec {
    /// The long-term modulus
    LongTerm,
    /// The instantaneous modulus
    Instantaneous,
}

/// One term of a Prony series.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmSpec {
    /// Share of the instantaneous modulus
    pub g: f64,
    /// Relaxation time
    pub tau: Time,
}

impl EffectPart for ViscoelasticSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let constants = match self.moduli {
            ModuliSpec::LongTerm => Constants::LongTerm,
            ModuliSpec::Instantaneous => Constants::Instantaneous,
        };
        let arms: Vec<Arm> = self.prony.0.iter().map(|arm| Arm { g: arm.g, tau: arm.tau.0 }).collect();
        let prony = Prony::new(&arms, constants).map_err(|e| part(builder.file, place, e))?;
        let (cells, law) = (builder.cells(place, &self.region)?, builder.law(place, &self.law)?);
        let effect = Viscoelastic::new(&builder.body.mesh, cells, &*law, prony);
        let shared = Arc::new(effect.map_err(|e| part(builder.file, place, e))?);
        builder.gathered.relaxing.push(shared.clone());
        Ok(Box::new(shared))
    }

    fn law(&self) -> Option<&str> {
        Some(&self.law)
    }

    fn words(&self) -> String {
        let moduli = match self.moduli {
            ModuliSpec::LongTerm => "long_term",
            ModuliSpec::Instantaneous => "instantaneous",
        };
        format!("region {}, law {}, moduli {moduli}, {} Prony terms", self.region, self.law, self.prony.0.len())
    }

    /// Checks that each cell is elastic with the same law, and relaxes by one effect only.
    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        let Self { region, law, .. } = self;
        let place = format!("effect {number} (viscoelastic)");
        for c in check_elastic_with(builder, &place, region, law)? {
            if let Some(other) = builder.gathered.relaxed.insert(c, number) {
                let fact = format!("cell {c} of region \"{region}\" relaxes by effect {other} already");
                let remedy =
                    "put all terms into the `prony` of one effect; of two laws on the same cells, one can relax";
                return Err(builder.content(&place, fact, remedy));
            }
        }
        Ok(())
    }

    /// Adds notes on the meaning of the constants, and on stages in which the effect does not act.
    fn note(&self, builder: &mut Builder) {
        let Self { law, moduli, prony, .. } = self;
        let kept = 1.0 - prony.0.iter().map(|arm| arm.g).sum::<f64>();
        let given = match moduli {
            ModuliSpec::LongTerm => format!("of the long term, {:.4} of them act at once", 1.0 / kept),
            ModuliSpec::Instantaneous => format!("of the instant, {kept:.4} of them are left in the long run"),
        };
        builder.notes.push(format!("viscoelastic: the constants of {law} are those {given}"));
        if builder.spans.iter().any(|s| s.integrator.is_static()) {
            builder.notes.push("viscoelastic: static stages see the long-term response".into());
        }
        let shortest = prony.0.iter().map(|arm| arm.tau.0).fold(f64::INFINITY, f64::min);
        for (k, span) in builder.spans.iter().enumerate().filter(|(_, s)| !s.integrator.is_static() && s.dt > shortest)
        {
            let dt = span.dt;
            builder.notes.push(format!("viscoelastic: dt = {dt} s of stage {} is above tau = {shortest} s", k + 1));
        }
    }
}
