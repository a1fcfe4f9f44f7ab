//! Selection by position: the entities inside a place, by a rule at its border.

use super::part::{Ground, PickSpec, Refusal, SelectedEntities};
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::boundary::boundary_facets;
use crate::mesh::select::{Pick, Rule};
use crate::scene::text::quantity::Length;
use schemars::JsonSchema;
use serde::Deserialize;

/// Rule that decides which facets or cells at the border of a place belong to it.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum RuleSpec {
    /// Facets or cells with a corner inside
    Any,
    /// Facets or cells with the mean of their corners inside
    Centroid,
    /// Facets or cells with all corners inside
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

/// The entities at a place. `holds` takes a margin against rounding \[m\]: a node on the side of a box counts as inside.
pub(super) fn at_place(
    ground: &Ground,
    place: &str,
    (pick, rule): (PickSpec, Option<RuleSpec>),
    holds: &dyn Fn(&Vec3, f64) -> bool,
) -> Result<SelectedEntities, Refusal> {
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
    let depends_on_mesh = is_cut(mesh, (pick, rule), &|x| holds(x, margin));
    Ok(SelectedEntities { pick, entities: entities(rule), depends_on_mesh, note: None })
}

/// The entities within a tolerance of a surface, by [`at_place`]. If the same entities lie on the surface itself, its border is theirs, however large the
/// tolerance is compared with an edge. If fewer entities lie on the surface, and its border runs along cells, the note says so.
pub(super) fn at_surface(
    ground: &Ground,
    (place, tolerance): (&str, f64),
    chosen: (PickSpec, Option<RuleSpec>),
    holds: &dyn Fn(&Vec3, f64) -> bool,
) -> Result<SelectedEntities, Refusal> {
    let mut found = at_place(ground, place, chosen, holds)?;
    let thin = SURFACE * ground.mesh.diagonal();
    if !found.depends_on_mesh || tolerance <= thin {
        return Ok(found);
    }
    let at = at_place(ground, place, chosen, &|x, margin| holds(x, margin + thin - tolerance))?;
    if at.entities == found.entities {
        found.depends_on_mesh = at.depends_on_mesh;
    } else if !at.entities.is_empty() && !at.depends_on_mesh {
        let mm = format!("{:.0e}", thin * 1e3).parse().unwrap_or(thin * 1e3);
        let what = found.pick.words();
        found.note = Some(format!(
            "with tolerance = \"{mm} mm\" it would hold the {} {what} at the surface itself, and not {}, and its border would not run through cells",
            at.entities.len(),
            found.entities.len()
        ));
    }
    Ok(found)
}

/// Distance, relative to the diagonal of the body, within which entities lie on a surface itself.
const SURFACE: f64 = 1e-6;

/// Distance from the inner end of an edge, relative to its length, within which a border that crosses the edge counts as running along the cells.
const ALONG: f64 = 0.05;

/// Whether the border of a place cuts through cells, or facets of the boundary, so that the extent differs on another mesh. With [`Rule::Any`] those next to
/// the border belong to the region too.
fn is_cut(mesh: &TetMesh, (pick, rule): (Pick, Rule), holds: &dyn Fn(&Vec3) -> bool) -> bool {
    let inside: Vec<bool> = mesh.points.iter().map(holds).collect();
    let leaves = |a: u32, b: u32| {
        let is_leaving = inside[a as usize] && !inside[b as usize];
        let [from, to] = [a, b].map(|k| mesh.points[k as usize]);
        is_leaving && (rule == Rule::Any || holds(&(from + (to - from) * ALONG)))
    };
    let cuts = |corners: &[u32]| corners.iter().any(|&a| corners.iter().any(|&b| leaves(a, b)));
    match pick {
        Pick::Facets => boundary_facets(mesh).iter().any(|&f| cuts(&mesh.facet(f as usize)[..3])),
        Pick::Nodes | Pick::Cells => (0..mesh.cell_count()).any(|c| cuts(&mesh.cell(c)[..4])),
    }
}

/// A position from a file.
pub(super) fn vector(p: &[Length; 3]) -> Vec3 {
    Vec3::new(p[0].0, p[1].0, p[2].0)
}

/// A direction as a vector; refuses one of zero length.
pub(super) fn direction(key: &str, v: &[f64; 3]) -> Result<Vec3, Refusal> {
    let v = Vec3::from(*v);
    if v.norm() > 0.0 && v.norm().is_finite() {
        return Ok(v.normalize());
    }
    Err(Refusal::new(format!("`{key}` has no length"), "write for example [1, 0, 0]"))
}
