//! The regions of a scene as a table: what each holds, and how large it is.

use super::shown_regions::shown;
use durometer::mesh::Region;
use durometer::scene::Scene;
use durometer::wording::few;

/// Returns a line for each region that is shown, with its nodes, facets, cells, area and volume. Regions of the file come last, followed by one line for
/// the numbered faces that are left out.
pub fn table(scene: &Scene) -> String {
    let mesh = &scene.body.mesh;
    let row = |name: &str, region: &Region| {
        let size = |count: usize, value: &dyn Fn() -> f64| match count {
            0 => "–".into(),
            _ => format!("{:.4}", value()),
        };
        let count = |count: usize| if count == 0 { "–".to_string() } else { count.to_string() };
        let area = size(region.facets.len(), &|| mesh.region_area(&region.facets) * 1e6);
        let volume = size(region.cells.len(), &|| mesh.region_volume(&region.cells) * 1e9);
        let (facets, cells) = (count(region.facets.len()), count(region.cells.len()));
        format!("{name:20} {:>8} {facets:>8} {cells:>8} {area:>14} {volume:>14}", mesh.nodes_of(region).len())
    };
    let head =
        format!("{:20} {:>8} {:>8} {:>8} {:>14} {:>14}", "", "nodes", "facets", "cells", "area mm^2", "volume mm^3");
    let [shown, faces] = shown(scene);
    let (own, given): (Vec<_>, Vec<_>) =
        shown.into_iter().partition(|(name, _)| scene.spec.mesh.regions.contains_key(*name));
    let rows = given.into_iter().chain(own).map(|(name, region)| row(name, region));
    let names: Vec<&str> = faces.iter().map(|(name, _)| name.as_str()).collect();
    let rest = (!names.is_empty()).then(|| {
        format!(
            "{} numbered faces that the scene does not name: {} (`durometer import` on the file lists all)",
            names.len(),
            few(&names)
        )
    });
    std::iter::once(head).chain(rows).chain(rest).collect::<Vec<_>>().join("\n             ")
}
