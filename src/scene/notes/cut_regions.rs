//! Regions that a scene picks by position and whose border cuts through cells: they cause an O(h) error of everything that acts on them or is recorded on
//! them.

use crate::mesh::Region;
use crate::scene::Scene;
use crate::wording::distinct;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// The cut regions on which columns depend. The regions of contacts do not count, because they only hold candidates for contact.
#[derive(Clone, Debug, Default)]
pub struct CutRegions {
    /// Regions that constraints and effects name, on which all columns depend
    pub of_all: Vec<String>,
    /// Column → regions that its probe names
    pub of_columns: BTreeMap<String, Vec<String>>,
}

impl CutRegions {
    /// The cut regions of a scene.
    pub fn new(scene: &Scene) -> Self {
        let text: Table = scene.text.parse().unwrap_or_default();
        let parts = ["constraint", "effect"].map(|key| text.get(key));
        let is_used = |name: &&String| parts.iter().flatten().any(|part| mentions(part, name));
        let cut: Vec<&String> =
            scene.regions.iter().filter(|(_, region)| region.depends_on_mesh).map(|(name, _)| name).collect();
        let of_all = cut.iter().copied().filter(is_used).cloned().collect();
        let mut of_columns = BTreeMap::new();
        // Recorders of probes come first, in the order of the file
        for (probe, recorder) in scene.spec.probes.iter().zip(&scene.probes) {
            let named = probe.regions();
            let own: Vec<String> = cut.iter().copied().filter(|cut| named.contains(&cut.as_str())).cloned().collect();
            if !own.is_empty() {
                of_columns.extend(recorder.columns().into_iter().map(|column| (column, own.clone())));
            }
        }
        Self { of_all, of_columns }
    }

    /// The cut regions on which a column depends.
    pub fn of(&self, column: &str) -> Vec<String> {
        distinct(self.of_all.iter().chain(self.of_columns.get(column).into_iter().flatten()).cloned())
    }

    /// The cut regions that consist of nodes, and the others.
    pub fn of_nodes_and_others(&self, regions: &BTreeMap<String, Region>) -> (Vec<String>, Vec<String>) {
        let is_of_nodes = |name: &String| regions[name].facets.is_empty() && regions[name].cells.is_empty();
        let all = distinct(self.of_all.iter().chain(self.of_columns.values().flatten()).cloned());
        all.into_iter().partition(is_of_nodes)
    }
}

/// Whether a value of a scene names this region.
fn mentions(value: &Value, region: &str) -> bool {
    match value {
        Value::String(text) => text == region,
        Value::Array(list) => list.iter().any(|value| mentions(value, region)),
        Value::Table(table) => table.values().any(|value| mentions(value, region)),
        _ => false,
    }
}
