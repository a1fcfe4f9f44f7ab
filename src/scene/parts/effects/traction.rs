//! Effect `traction`: a load of fixed direction on a part of the surface, per reference area.

use super::part::EffectPart;
use crate::effect::dead_load::DeadLoad;
use crate::math::units::Dimension;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::signal::SignalSpec;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// A load of fixed direction per reference area; exactly one of `region` and `skin`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TractionSpec {
    /// Prefix of the columns; `traction` if absent
    #[serde(default = "traction")]
    pub name: String,
    /// Facets of the mesh
    pub region: Option<String>,
    /// Name of a skin that carries the load, in place of a region
    pub skin: Option<String>,
    /// Direction of the load, fixed in space; its length does not matter
    pub direction: [f64; 3],
    /// Force per area at rest \[Pa\]
    pub traction: SignalSpec,
}

fn traction() -> String {
    "traction".into()
}

impl EffectPart for TractionSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let weights = match (&self.region, &self.skin) {
            (Some(region), None) => {
                let facets = &builder.region(place, region)?.facets;
                if facets.is_empty() {
                    let fact = format!("region \"{region}\" holds no facets");
                    let remedy = "a traction acts on a part of the surface: take a facet region";
                    return Err(builder.content(place, fact, remedy));
                }
                builder.body.mesh.nodal_areas(facets)
            }
            (None, Some(skin)) => {
                let (areas, no_limit) = builder.skin(place, skin)?.nodal_areas(&builder.body.mesh);
                builder.no_limits.extend(no_limit);
                areas
            }
            _ => {
                let fact = "a traction acts on one surface";
                return Err(builder.content(place, fact, "give either `region` (facets of the mesh) or `skin`"));
            }
        };
        let column = format!("{}_imposed_Pa", self.name);
        let (direction, signal) = builder.dead(place, self.direction, &self.traction, Dimension::PRESSURE, column)?;
        Ok(Box::new(DeadLoad::new(self.name.clone(), &weights, direction, signal)))
    }

    fn words(&self) -> String {
        let direction = self.direction;
        match (&self.region, &self.skin) {
            (Some(region), _) => format!("region {region}, towards {direction:?}"),
            (None, skin) => format!("skin {}, towards {direction:?}", skin.as_deref().unwrap_or_default()),
        }
    }
}
