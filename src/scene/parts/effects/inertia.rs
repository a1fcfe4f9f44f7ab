//! Effect `inertia`: the mass of a region.

use super::part::EffectPart;
use super::repeated::check_repeated;
use crate::effect::{Inertia, Lumping, Mass};
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::text::quantity::Density;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeSet;

/// Inertia of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InertiaSpec {
    /// Region of cells that have a mass
    pub region: String,
    /// Mass density at rest
    pub density: Density,
    /// Form of the mass matrix
    pub mass: LumpingSpec,
}

/// Form of a mass matrix.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum LumpingSpec {
    /// From the shape functions
    Consistent,
    /// The mass of each cell lumped at its nodes; diagonal
    Lumped,
    /// Equal mass at every node, as in mass–spring models
    Uniform,
}

impl LumpingSpec {
    /// Name as in scene files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Consistent => "consistent",
            Self::Lumped => "lumped",
            Self::Uniform => "uniform",
        }
    }
}

impl From<LumpingSpec> for Lumping {
    fn from(spec: LumpingSpec) -> Self {
        match spec {
            LumpingSpec::Consistent => Self::Consistent,
            LumpingSpec::Lumped => Self::Lumped,
            LumpingSpec::Uniform => Self::Uniform,
        }
    }
}

/// The mass matrix of the cells of a region.
pub(super) fn mass(
    builder: &mut Builder,
    place: &str,
    region: &str,
    density: Density,
    lumping: LumpingSpec,
) -> Result<Mass, SceneError> {
    let density = builder.positive_density(place, density.0)?;
    let cells = builder.cells(place, region)?;
    Ok(Mass::new(&builder.body.mesh, cells, density, lumping.into()))
}

impl EffectPart for InertiaSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let mass = mass(builder, place, &self.region, self.density, self.mass)?;
        Ok(Box::new(Inertia { mass }))
    }

    fn words(&self) -> String {
        format!("region {}, {} kg/m^3, mass {}", self.region, self.density, self.mass.name())
    }

    fn needs_rates(&self) -> bool {
        true
    }

    fn note(&self, builder: &mut Builder) {
        let cells: BTreeSet<u32> = builder
            .regions
            .get(&self.region)
            .map_or_else(BTreeSet::new, |region| region.cells.iter().copied().collect());
        if self.mass != LumpingSpec::Consistent && builder.rigid_cells.iter().any(|c| cells.contains(c)) {
            builder.notes.push(format!(
                "inertia of {}: mass = \"{}\" makes the moments of inertia of rigid parts too large, the more the fewer cells lie across them; \
                 give these cells an inertia with mass = \"consistent\", which is exact there",
                self.region,
                self.mass.name()
            ));
        }
    }

    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        check_repeated(builder, number, "inertia", String::new(), &self.region)
    }
}
