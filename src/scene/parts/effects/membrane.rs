//! Effect `membrane`: a thin sheet with a law on facets, in plane stress.

use super::part::EffectPart;
use crate::effect::Membrane;
use crate::math::tensor::Vec3;
use crate::math::units::Decimals;
use crate::scene::build::builder::Builder;
use crate::scene::build::held_planes::note_halved;
use crate::scene::error::SceneError;
use crate::scene::notes::stable::stability_note;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::scene::text::quantity::Length;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::Arc;

/// A thin sheet on the facets of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MembraneSpec {
    /// Prefix of the columns; `membrane` if absent
    #[serde(default = "membrane")]
    pub name: String,
    /// Facets of the mesh
    pub region: String,
    /// Name of a law in `laws`
    pub law: String,
    /// Thickness at rest
    pub thickness: Length,
}

fn membrane() -> String {
    "membrane".into()
}

impl EffectPart for MembraneSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        builder.check_name(place, &self.name)?;
        let facets = builder.region(place, &self.region)?.facets.clone();
        if facets.is_empty() {
            let fact = format!("region \"{}\" holds no facets", self.region);
            return Err(builder.content(place, fact, "a membrane is on a part of the surface: take a facet region"));
        }
        if self.thickness.0 <= 0.0 {
            let fact = format!("thickness is {} mm", self.thickness.0 * 1e3);
            return Err(builder.content(place, fact, "give a positive one"));
        }
        let (mesh, law) = (&builder.body.mesh, builder.law(place, &self.law)?);
        // A sheet is in plane stress, in which some laws lose their stiffness or their thickness in tension.
        let unstable = stability_note(&self.law, law.as_ref());
        let sheet = Arc::new(Membrane::new(self.name.clone(), mesh, &facets, law, self.thickness.0));
        let area = mesh.region_area(&facets);
        builder.notes.push(format!("{}: {:.4} mm^2 of {} facets", self.name, Decimals(area * 1e6), facets.len()));
        builder.notes.extend(unstable.filter(|note| !builder.notes.contains(note)));
        builder.gathered.membranes.push(sheet.clone());
        builder.gathered.recorders.push(Box::new(Recorded { name: self.name.clone(), sheet: sheet.clone() }));
        Ok(Box::new(sheet))
    }

    fn note(&self, builder: &mut Builder) {
        let (mesh, facets) = (&builder.body.mesh, &builder.regions[&self.region].facets);
        let places = |&f: &u32| mesh.facet(f as usize).iter().map(|&node| mesh.points[node as usize]).collect();
        let places: Vec<Vec<Vec3>> = facets.iter().map(places).collect();
        note_halved(builder, &self.name, (&places, "facets"), "thickness");
    }

    fn law(&self) -> Option<&str> {
        Some(&self.law)
    }

    fn words(&self) -> String {
        let Self { name, region, law, thickness } = self;
        format!("{name}, region {region}, law {law}, {:.4} mm thick", Decimals(thickness.0 * 1e3))
    }
}

/// Columns of a sheet: `<name>_stretch_{min,max}` in its plane, `<name>_thickness_min_m`, `<name>_stress_max_Pa`.
struct Recorded {
    name: String,
    sheet: Arc<Membrane>,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        ["stretch_min", "stretch_max", "thickness_min_m", "stress_max_Pa"].map(|c| format!("{}_{c}", self.name)).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        match self.sheet.extremes(&now.state.x) {
            Some(e) => vec![e.stretch[0], e.stretch[1], e.thickness, e.stress],
            None => vec![f64::NAN; 4],
        }
    }
}
