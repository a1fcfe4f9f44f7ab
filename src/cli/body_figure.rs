//! The picture of a scene at rest as a file: its regions, what is held, and its cables.

use super::shown_regions::{is_whole, number_of_face, shown};
use durometer::mesh::Region;
use durometer::mesh::boundary::{boundary_facets, facet_cells};
use durometer::report::body::{BodyPicture, draw};
use durometer::report::{ReportError, export, files};
use durometer::scene::Scene;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Writes the picture as SVG, PNG or PDF, according to the file extension.
pub fn write(path: &Path, scene: &Scene) -> Result<(), Box<dyn std::error::Error>> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let encode: fn(&str, &str) -> Result<Vec<u8>, ReportError> = match ending.as_str() {
        "svg" => |_, svg| Ok(svg.as_bytes().to_vec()),
        "png" => export::png,
        "pdf" => export::pdf,
        _ => return Err(format!("{}: a figure ends in .svg, .png or .pdf; give one of them", path.display()).into()),
    };
    let figure = draw("regions", &picture(scene));
    files::write(path, &encode(&figure.name, &figure.svg)?)?;
    Ok(())
}

fn picture(scene: &Scene) -> BodyPicture {
    let mesh = &scene.body.mesh;
    let facets = boundary_facets(mesh);
    let cells = facet_cells(mesh);
    let number: BTreeMap<u32, usize> = facets.iter().enumerate().map(|(t, &f)| (f, t)).collect();
    let on_surface = |region: &Region| -> Vec<usize> {
        let of_cells: BTreeSet<u32> = region.cells.iter().copied().collect();
        let is_own = |f: &u32| region.facets.binary_search(f).is_ok() || of_cells.contains(&cells[*f as usize].0);
        facets.iter().filter(|f| is_own(f)).map(|f| number[f]).collect()
    };
    let is_own = |name: &str| scene.spec.mesh.regions.contains_key(name);
    let [mut shown, _] = shown(scene);
    shown.retain(|(name, _)| !is_whole(name));
    // Regions of the file are drawn over those of the mesh, small regions over large ones
    let size = |region: &Region| std::cmp::Reverse(region.facets.len() + region.cells.len());
    shown.sort_by_key(|(name, region)| (is_own(name), size(region), number_of_face(name)));
    let (of_nodes, of_facets): (Vec<_>, Vec<_>) = shown.into_iter().partition(|(_, region)| !region.nodes.is_empty());
    let held = scene.system.prescribed.iter().map(|p| p.dof / 3).filter(|&k| (k as usize) < mesh.points.len());
    let path = |x: &[f64], k: usize| scene.cables[k].cable.polyline(x).into_iter().map(Into::into).collect();
    let rest = scene.system.rest();
    BodyPicture {
        points: mesh.points.iter().map(|p| (*p).into()).collect(),
        facets: facets.iter().map(|&f| mesh.facet(f as usize).to_vec()).collect(),
        regions: of_facets.into_iter().map(|(name, region)| (name.clone(), on_surface(region))).collect(),
        nodes: of_nodes.into_iter().map(|(name, region)| (name.clone(), region.nodes.clone())).collect(),
        held: held.collect(),
        cables: (0..scene.cables.len()).map(|k| (scene.cables[k].name.clone(), path(&rest.x, k))).collect(),
    }
}
