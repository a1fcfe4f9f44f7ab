//! Effect `elastic`: a law in the cells of a region, in one of the formulations.

use super::part::{EffectPart, OverlapSpec};
use crate::effect::{Elastic, MeanDilatation, MixedElastic, PressureHosts};
use crate::material::Law;
use crate::mesh::Order;
use crate::scene::build::builder::{Builder, ElasticLaw};
use crate::scene::error::SceneError;
use crate::scene::notes::implausible::implausible_modulus;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// Elasticity of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticSpec {
    /// Region of cells
    pub region: String,
    /// Name of a law in `laws`
    pub law: String,
    /// Formulation of the law in the elements
    #[serde(default)]
    pub formulation: FormulationSpec,
    /// Permission to act in cells of another elastic effect, which is refused if absent
    pub overlap: Option<OverlapSpec>,
}

/// Formulation of a law in the elements.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Default)]
#[serde(rename_all = "snake_case")]
pub enum FormulationSpec {
    /// Displacements only; locks as ν → ½, tet4 before tet10
    #[default]
    Displacement,
    /// Displacement and continuous pressure: stabilised on tet4, Taylor–Hood on tet10
    Mixed,
    /// tet10 with one pressure per cell, statically condensed
    MeanDilatation,
}

impl FormulationSpec {
    /// Name as in scene files.
    fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Mixed => "mixed",
            Self::MeanDilatation => "mean_dilatation",
        }
    }

    /// Suffix of the name of an element with this formulation, such as `_up` in `tet10_up`.
    pub(in crate::scene) fn suffix(self) -> &'static str {
        match self {
            Self::Displacement => "",
            Self::Mixed => "_up",
            Self::MeanDilatation => "_p0",
        }
    }

    /// Whether pressures are unknowns in addition to the displacements.
    pub(in crate::scene) fn is_mixed(self) -> bool {
        self == Self::Mixed
    }
}

impl ElasticSpec {
    /// Makes pressures unknowns in addition to the displacements.
    pub(in crate::scene) fn take_pressure_field(&mut self) {
        self.formulation = FormulationSpec::Mixed;
    }
}

impl EffectPart for ElasticSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let Self { region, law, formulation, .. } = self;
        let (mesh, cells) = (&builder.body.mesh, builder.cells(place, region)?);
        let (name, built) = ("elastic".to_string(), builder.law(place, law)?);
        let info = built.info().name;
        let shared = ElasticLaw { name: law.clone(), region: region.clone(), law: builder.law(place, law)? };
        let effect = match formulation {
            FormulationSpec::Displacement => {
                let effect = Elastic::new(name, mesh, cells, built);
                builder.gathered.solid(region, effect)
            }
            FormulationSpec::Mixed => {
                check_volumetric(builder, place, &*built)?;
                let first = (3 * builder.nodes + builder.gathered.hosts.len()) as u32;
                let hosts = PressureHosts::new(mesh, cells, &builder.gathered.cell_groups);
                let effect = MixedElastic::new(name, mesh, cells, &*built, &hosts, first);
                let effect = effect.ok_or_else(|| no_split(builder, place, info))?;
                builder.gathered.hosts.extend(hosts.nodes());
                builder.gathered.solid(region, effect)
            }
            FormulationSpec::MeanDilatation if mesh.order == Order::Linear => {
                let fact = "mean_dilatation on tet4 is the displacement formulation";
                let remedy = "take formulation = \"mixed\", or mesh.element = \"tet10\"";
                return Err(builder.content(place, fact, remedy));
            }
            FormulationSpec::MeanDilatation => {
                let effect = MeanDilatation::new(name, mesh, cells, &*built);
                let effect = effect.ok_or_else(|| no_split(builder, place, info))?;
                builder.gathered.solid(region, effect)
            }
        };
        let doubt = implausible_modulus(&shared.name, shared.law.as_ref());
        builder.notes.extend(doubt.filter(|doubt| !builder.notes.contains(doubt)));
        builder.gathered.laws.push(shared);
        Ok(effect)
    }

    fn law(&self) -> Option<&str> {
        Some(&self.law)
    }

    fn words(&self) -> String {
        let added = if self.overlap.is_some() { ", added" } else { "" };
        format!("region {}, law {}, formulation {}{added}", self.region, self.law, self.formulation.name())
    }

    fn resists(&self) -> Option<(&str, bool)> {
        Some((&self.region, self.overlap.is_some()))
    }
}

/// Refuses a law whose volumetric part is zero at every J, so that every pressure is zero too.
fn check_volumetric(builder: &Builder, place: &str, law: &dyn Law) -> Result<(), SceneError> {
    if law.split().is_none_or(|(_, volumetric)| volumetric.kappa != 0.0) {
        return Ok(());
    }
    let fact = format!(
        "the volumetric part of the law {} vanishes, as ½λ(ln J)² does at nu = 0, so that there is no pressure to solve for",
        law.info().name
    );
    Err(builder.content(place, fact, "take formulation = \"displacement\", which does not lock there"))
}

fn no_split(builder: &Builder, place: &str, law: &str) -> SceneError {
    let fact = format!("the law {law} has no volumetric part of its own");
    builder.content(place, fact, "take a law with a split such as neo_hookean, or formulation = \"displacement\"")
}
