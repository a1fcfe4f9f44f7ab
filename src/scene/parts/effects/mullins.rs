//! Effect `mullins`: softening of a region by the largest energy density reached so far, in addition to an elastic effect with the same law.

use super::of_law::check_elastic_with;
use super::part::EffectPart;
use crate::effect::Mullins;
use crate::material::Softening;
use crate::math::units::shown;
use crate::scene::build::builder::Builder;
use crate::scene::error::{SceneError, part};
use crate::scene::text::quantity::Modulus;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Softening of a region.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MullinsSpec {
    /// Region of cells that soften
    pub region: String,
    /// Law of the elastic effect there
    pub law: String,
    /// Constants of the softening, or the file of a fit
    pub softening: SofteningSpec,
}

/// Constants of softening. A file may also have `{ include = "mullins.toml" }`, which is replaced by the constants of that file before the scene is built;
/// constants next to it take precedence.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SofteningSpec {
    /// Path of the included file, relative to the scene
    pub include: Option<String>,
    /// Constant r; 1/r is the largest share of the stress that is lost
    pub r: Option<f64>,
    /// Constant m, an energy density
    pub m: Option<Modulus>,
    /// Constant β, a share of the largest energy density
    pub beta: Option<f64>,
}

impl SofteningSpec {
    /// The constants r, m and β, or otherwise the names of those that are missing.
    fn constants(&self) -> Result<(f64, f64, f64), String> {
        let Self { r, m, beta, .. } = self;
        if let (Some(r), Some(m), Some(beta)) = (r, m, beta) {
            return Ok((*r, m.0, *beta));
        }
        let given = [("r", r.is_some()), ("m", m.is_some()), ("beta", beta.is_some())];
        let missing: Vec<&str> = given.iter().filter(|g| !g.1).map(|g| g.0).collect();
        Err(format!("`softening` has no {}", missing.join(", ")))
    }
}

impl EffectPart for MullinsSpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let remedy = "write softening = { r = 1.6, m = \"2 kPa\", beta = 0.1 }, or { include = \"mullins.toml\" }";
        let constants = self.softening.constants().map_err(|fact| builder.content(place, fact, remedy));
        let (r, m, beta) = constants?;
        let softening = Softening::new(r, m, beta).map_err(|e| part(builder.file, place, e))?;
        let (cells, law) = (builder.cells(place, &self.region)?, builder.law(place, &self.law)?);
        let effect = Mullins::new(&builder.body.mesh, cells, &*law, softening);
        let shared = Arc::new(effect.map_err(|e| part(builder.file, place, e))?);
        builder.gathered.softening.push(shared.clone());
        Ok(Box::new(shared))
    }

    fn law(&self) -> Option<&str> {
        Some(&self.law)
    }

    fn words(&self) -> String {
        let constants =
            self.softening.constants().map_or_else(|e| e, |(r, m, b)| format!("r {r}, m {} Pa, beta {b}", shown(m)));
        format!("region {}, law {}, {constants}", self.region, self.law)
    }

    /// Checks that each cell is elastic with the same law, softens by one effect only, and keeps a part of its stress if it relaxes too.
    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        let Self { region, law, .. } = self;
        let place = format!("effect {number} (mullins)");
        let lost = self.softening.constants().map_or(0.0, |(r, ..)| 1.0 / r);
        let relaxing = builder.gathered.relaxing.iter();
        let relaxed: BTreeMap<u32, f64> =
            relaxing.flat_map(|e| e.cells().iter().map(|c| (*c, e.relaxed_share()))).collect();
        for c in check_elastic_with(builder, &place, region, law)? {
            if let Some(other) = builder.gathered.softened.insert(c, number) {
                let fact = format!("cell {c} of region \"{region}\" softens by effect {other} already");
                return Err(builder.content(&place, fact, "keep one of the two"));
            }
            let relaxed = relaxed.get(&c).copied().unwrap_or(0.0);
            if lost + relaxed >= 1.0 {
                let fact = format!(
                    "cell {c} of region \"{region}\" softens by up to {lost:.3} of the stress of its law and relaxes by {relaxed:.3} of it: nothing is left"
                );
                return Err(builder.content(
                    &place,
                    fact,
                    "take moduli = \"long_term\" of the viscoelastic effect, or a larger r",
                ));
            }
        }
        Ok(())
    }

    /// Adds the note that the result depends on the path.
    fn note(&self, builder: &mut Builder) {
        let note = format!(
            "mullins: the law {} is that of the first loading; each point remembers the largest energy, in static stages too",
            self.law
        );
        builder.notes.push(note);
    }
}
