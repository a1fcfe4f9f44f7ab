//! Selector `component`: a connected piece of the surface, or a connected part of the body.

use super::part::{Ground, PickSpec, Refusal, SelectedEntities, SelectorPart};
use crate::math::units::Decimals;
use crate::mesh::TetMesh;
use crate::mesh::parts::parts;
use crate::mesh::pieces::{Piece, pieces};
use crate::mesh::select::Pick;
use crate::schema::any_of;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// A connected piece of the surface, or a connected part of the body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComponentSelector {
    /// Component that is selected: `"inner"`, `"outer"`, or a number from 1 by size
    pub which: Which,
    /// Pieces of the surface (facets) or parts of the body (cells)
    pub pick: PickSpec,
}

/// Choice of the component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// All surfaces around hollows together
    Inner,
    /// Surfaces around the body
    Outer,
    /// Number by size, from 1: the largest area, or the largest volume, comes first
    Number(usize),
}

impl JsonSchema for Which {
    fn schema_name() -> Cow<'static, str> {
        "Which".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = json_schema!({ "type": "integer", "minimum": 1, "description": "By size, from 1: the largest area, or the largest volume." });
        any_of(&[json_schema!({ "enum": ["inner", "outer"] }), number])
    }
}

impl<'de> Deserialize<'de> for Which {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Word;
        impl Visitor<'_> for Word {
            type Value = Which;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "\"inner\", \"outer\" or a number from 1")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Which, E> {
                match text {
                    "inner" => Ok(Which::Inner),
                    "outer" => Ok(Which::Outer),
                    _ => Err(E::custom(format!("which = \"{text}\"; write \"inner\", \"outer\" or a number from 1"))),
                }
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Which, E> {
                match usize::try_from(number) {
                    Ok(number) if number > 0 => Ok(Which::Number(number)),
                    _ => Err(E::custom(format!("which = {number}; components are numbered from 1"))),
                }
            }
        }
        deserializer.deserialize_any(Word)
    }
}

/// A component with its description.
struct Component {
    entities: Vec<u32>,
    is_outer: bool,
    words: String,
}

impl SelectorPart for ComponentSelector {
    fn find(&self, ground: &Ground) -> Result<SelectedEntities, Refusal> {
        let pick = self.pick.pick();
        let all = match pick {
            Pick::Facets => surfaces(ground.mesh),
            Pick::Cells => volumes(ground.mesh),
            Pick::Nodes => {
                let remedy = "take pick = \"facets\" (pieces of the surface) or \"cells\" (parts of the body)";
                return Err(Refusal::new("nodes do not hang together", remedy));
            }
        };
        let listed = || {
            let lines: Vec<String> = (1..).zip(&all).map(|(k, c)| format!("{k}: {}", c.words)).collect();
            format!("there are {}", lines.join("; "))
        };
        let is_of_surface = pick == Pick::Facets;
        let chosen: Vec<&Component> = match self.which {
            Which::Number(k) => all.get(k - 1).into_iter().collect(),
            Which::Inner | Which::Outer if !is_of_surface => {
                return Err(Refusal::new("parts of the body are neither inner nor outer", listed()));
            }
            Which::Inner => all.iter().filter(|c| !c.is_outer).collect(),
            Which::Outer => all.iter().filter(|c| c.is_outer).collect(),
        };
        if chosen.is_empty() {
            return Err(Refusal::new(format!("{} is not there", self.words()), listed()));
        }
        let mut entities: Vec<u32> = chosen.iter().flat_map(|c| &c.entities).copied().collect();
        entities.sort_unstable();
        Ok(SelectedEntities { pick, entities, depends_on_mesh: false, note: None })
    }

    fn words(&self) -> String {
        let what = if self.pick == PickSpec::Facets { "surface" } else { "part" };
        match self.which {
            Which::Inner => format!("an inner {what}"),
            Which::Outer => format!("the outer {what}"),
            Which::Number(k) => format!("{what} {k}"),
        }
    }

    fn may_be_everything(&self) -> bool {
        true
    }
}

fn surfaces(mesh: &TetMesh) -> Vec<Component> {
    let component = |piece: Piece| {
        let is_outer = !piece.is_inner();
        let side = if is_outer { "outer" } else { "inner" };
        let (count, area, volume) = (piece.facets.len(), piece.area * 1e6, piece.volume.abs() * 1e9);
        let words = format!("{side}, {count} facets, {:.4} mm^2 around {:.4} mm^3", Decimals(area), Decimals(volume));
        Component { entities: piece.facets, is_outer, words }
    };
    pieces(mesh).into_iter().map(component).collect()
}

fn volumes(mesh: &TetMesh) -> Vec<Component> {
    let mut by_root: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (cell, root) in (0..).zip(parts(mesh)) {
        by_root.entry(root).or_default().push(cell);
    }
    let mut sized: Vec<(f64, Vec<u32>)> = by_root.into_values().map(|c| (mesh.region_volume(&c), c)).collect();
    // Equal volumes keep the order of their first nodes
    sized.sort_by(|a, b| b.0.total_cmp(&a.0));
    let component = |(volume, cells): (f64, Vec<u32>)| {
        let words = format!("{} cells, {:.4} mm^3", cells.len(), Decimals(volume * 1e9));
        Component { entities: cells, is_outer: true, words }
    };
    sized.into_iter().map(component).collect()
}
