//! Picking by place: the entities inside of it, by a rule at its border.

use super::part::{Found, Ground, PickSpec, Refusal};
use crate::math::tensor::Vec3;
use crate::mesh::select::{Pick, Rule};
use crate::scene::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// Which facets or cells at the border of a place belong to it.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum RuleSpec {
    /// With a corner inside
    Any,
    /// With the mean of the corners inside
    Centroid,
    /// With all corners inside
    All,
}

impl RuleSpec {
    fn rule(self) -> Rule {
        match self {
            Self::Any => Rule::Any,
            Self::Centroid => Rule::Centroid,
            Self::All => Rule::All,
        }
    }
}

/// The entities at a place. `holds` gets a margin against rounding \[m\]: a node on the side of a box is inside.
pub(super) fn at_place(
    ground: &Ground,
    place: &str,
    (pick, rule): (PickSpec, Option<RuleSpec>),
    holds: &dyn Fn(&Vec3, f64) -> bool,
) -> Result<Found, Refusal> {
    let (mesh, pick) = (ground.mesh, pick.pick());
    let margin = 1e-9 * mesh.diagonal();
    let entities = |rule| pick.at(mesh, rule, &|x| holds(x, margin));
    let rule = match (pick, rule) {
        (Pick::Nodes, None) => Rule::All,
        (Pick::Nodes, Some(_)) => {
            let remedy = "remove `rule`, or add pick = \"facets\" or \"cells\"";
            return Err(Refusal::new("`rule` has no effect on nodes, which are inside or not", remedy));
        }
        (_, Some(rule)) => rule.rule(),
        (_, None) => {
            let [any, centroid, all] = Rule::EVERY.map(|rule| entities(rule).len());
            let what = pick.words();
            let fact = format!("no `rule` says which {what} at the border of {place} belong to it");
            let remedy = format!(
                "add rule = \"any\" (with a corner inside: {any} {what}), \"centroid\" (with the mean of the corners inside: \
                 {centroid}) or \"all\" (with all corners inside: {all})"
            );
            return Err(Refusal::new(fact, remedy));
        }
    };
    Ok(Found { pick, entities: entities(rule), depends_on_mesh: true })
}

/// A position from a file.
pub(super) fn vector(p: &[Length; 3]) -> Vec3 {
    Vec3::new(p[0].0, p[1].0, p[2].0)
}

/// Refuses a direction without a length.
pub(super) fn direction(key: &str, v: &[f64; 3]) -> Result<Vec3, Refusal> {
    let v = Vec3::from(*v);
    if v.norm() > 0.0 && v.norm().is_finite() {
        return Ok(v.normalize());
    }
    Err(Refusal::new(format!("`{key}` has no length"), "write for example [1, 0, 0]"))
}
