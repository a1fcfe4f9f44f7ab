//! Regions that a scene picks by place and whose border runs through cells: an O(h) error of what acts on them.

use crate::scene::Scene;
use toml::{Table, Value};

/// Those that constraints and effects name. The candidates of contact may be any.
pub fn cut_regions(scene: &Scene) -> Vec<String> {
    let text: Table = scene.text.parse().unwrap_or_default();
    let parts = ["constraint", "effect"].map(|key| text.get(key));
    let is_used = |name: &str| parts.iter().flatten().any(|part| mentions(part, name));
    let cut = scene.regions.iter().filter(|(_, region)| region.depends_on_mesh);
    cut.map(|(name, _)| name.clone()).filter(|name| is_used(name)).collect()
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
