//! The file of a `[mesh]` table: its path, format and unit, and what is done to its cells and nodes.

use super::mesh_spec::MeshSpec;
use crate::math::units::{self, Dimension};
use crate::mesh::boundary::boundary_facets;
use crate::mesh::format::{Format, Reader, recognise};
use crate::mesh::{Changes, Reading, TetMesh};
use crate::scene::error::{SceneError, part};
use crate::wording::nearest;
use std::path::{Path, PathBuf};

/// Diagonals of bodies for which the unit is not in doubt \[m\]: from a micro-gripper to an arm.
const PLAUSIBLE: std::ops::Range<f64> = 1e-3..5.0;
/// Diagonals of bodies from which a unit is guessed \[m\].
const USUAL: std::ops::Range<f64> = 5e-3..2.0;

/// The file of the table and its format, if it is a volume mesh that is used as it is; with a size or a number of cells its surface is meshed instead.
pub(super) fn volume_mesh(file: &Path, spec: &MeshSpec) -> Result<Option<(PathBuf, Format)>, SceneError> {
    let Some(name) = spec.file.as_ref().filter(|_| spec.cells.is_none() && spec.size.is_none()) else {
        return Ok(None);
    };
    let path = file.parent().unwrap_or(Path::new("")).join(name);
    let format = recognise(&path).map_err(|e| match absent(name, &path) {
        Some((fact, remedy)) => content(file, fact, &remedy),
        None => part(file, "mesh", e),
    })?;
    Ok(format.reader.is_volume().then_some((path, format)))
}

/// Fact and remedy about a file that does not exist; `None` if it exists.
fn absent(name: &Path, path: &Path) -> Option<(String, String)> {
    if path.exists() {
        return None;
    }
    let text = name.to_string_lossy();
    let fact = format!("there is no file {text}");
    if text.contains('\\') || text.chars().any(char::is_control) {
        return Some((fact, "write the path with /, as in \"meshes/finger.vtk\"".into()));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Some((fact, "its folder does not exist either; paths start from the folder of the scene".into()));
    };
    // Names with the same ending are similar because of it: only the stems are compared
    let stem = |name: &Path| name.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let wanted = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let names = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned());
    let alike: Vec<String> = names.filter(|n| nearest(&stem(path), &[stem(Path::new(n))]).is_some()).collect();
    let remedy = match nearest(&wanted, &alike) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "check the path, which starts from the folder of the scene".into(),
    };
    Some((fact, remedy))
}

/// The options of the table for reading the cells and nodes of its file.
pub(super) fn reading(file: &Path, spec: &MeshSpec) -> Result<Reading, SceneError> {
    let merge = spec.merge.map(|length| length.0);
    if let Some(length) = merge.filter(|l| *l < 0.0 || !l.is_finite()) {
        return Err(content(file, format!("merge = {length} m"), "the distance must not be negative"));
    }
    Ok(Reading { unit_m: unit_m(file, spec)?, split: spec.split, merge })
}

/// Notes on changes that were made to the content of a file.
pub(super) fn taken_over(changes: &Changes) -> Vec<String> {
    let counts = [
        (changes.dropped_nodes, "nodes of the file belong to no cell and were dropped"),
        (changes.merged_nodes, "nodes of the file were merged with another one at their place"),
        (changes.split_cells, "cells of the file were split into tetrahedra"),
    ];
    let counted = counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}"));
    changes.notes.iter().cloned().chain(counted).collect()
}

/// The note on a region `skin` of the file, which replaces the whole surface under this name.
pub(super) fn own_skin(mesh: &TetMesh) -> Option<String> {
    let (skin, surface) = (mesh.regions.get("skin")?, boundary_facets(mesh));
    (skin.facets != surface).then(|| {
        format!(
            "region skin is that of the file, with {} facets, and not the whole surface of {}; rename it in the file to have both",
            skin.facets.len(),
            surface.len()
        )
    })
}

/// A warning about a body of an implausible size for a soft robot, with the unit that would make it plausible, unless its file states a different unit.
pub(super) fn doubtful_unit(mesh: &TetMesh, reader: Reader, unit_m: f64) -> Option<String> {
    let (low, high) = mesh.bounding_box();
    let size = (high - low).norm();
    if PLAUSIBLE.contains(&size) {
        return None;
    }
    let length = if size < 1.0 { format!("{:.3} mm", size * 1e3) } else { format!("{size:.3} m") };
    let hint = match plausible_unit(size / unit_m) {
        _ if reader.states_its_unit() => "; the unit that its file states is probably wrong: export it again".into(),
        Some(unit) => format!("; unit = \"{unit}\" would be plausible"),
        None => String::new(),
    };
    Some(format!("the body is {length} across, which is unusual for a soft robot{hint}"))
}

/// The first of the usual units in which a diagonal of this length has the size of a soft robot.
pub fn plausible_unit(diagonal: f64) -> Option<&'static str> {
    usual_units().find(|(_, metre)| USUAL.contains(&(diagonal * metre))).map(|(unit, _)| unit)
}

/// The usual units of length with their lengths \[m\], the most frequent first.
pub(super) fn usual_units() -> impl Iterator<Item = (&'static str, f64)> {
    let metres = |unit: &str| units::parse(&format!("1 {unit}"), Dimension::LENGTH).expect("a unit of length");
    ["mm", "m", "cm", "in", "um"].into_iter().map(move |unit| (unit, metres(unit)))
}

/// A refusal of the table `[mesh]`.
pub(in crate::scene) fn content(file: &Path, fact: impl Into<String>, remedy: &str) -> SceneError {
    SceneError::Content { file: file.into(), place: "mesh".into(), fact: fact.into(), remedy: remedy.into() }
}

pub(in crate::scene) fn unit_m(file: &Path, spec: &MeshSpec) -> Result<f64, SceneError> {
    let Some(unit) = &spec.unit else {
        return Err(content(file, "the file has no unit of length", "add for example unit = \"mm\""));
    };
    units::parse(&format!("1 {unit}"), Dimension::LENGTH).map_err(|e| part(file, "mesh.unit", e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structured::block;
    use crate::mesh::{Order, Region};

    /// A file may give this name to another region; the whole surface under its own name needs no note.
    #[test]
    fn a_region_in_the_place_of_the_whole_surface_is_told() {
        let mut mesh = block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear);
        assert_eq!(own_skin(&mesh), None);
        let facets = boundary_facets(&mesh);
        mesh.regions.insert("skin".into(), Region { facets: facets.clone(), ..Region::default() });
        assert_eq!(own_skin(&mesh), None);
        mesh.regions.insert("skin".into(), Region { facets: facets[..3].to_vec(), ..Region::default() });
        let fact = "region skin is that of the file, with 3 facets, and not the whole surface of 12; ";
        assert!(own_skin(&mesh).is_some_and(|note| note.starts_with(fact)));
    }

    /// No other unit is suggested for a file that states its own, since the mesher refuses it.
    #[test]
    fn a_body_of_an_unusual_size_is_warned_of_with_its_remedy() {
        let warning = |metres: f64, reader| {
            let side = metres / 3.0_f64.sqrt();
            doubtful_unit(&block(1, 1, 1, side, side, side, Order::Linear), reader, 1e-3)
        };
        let fact = "the body is 57.000 m across, which is unusual for a soft robot; ";
        for reader in [Reader::Surface("stl"), Reader::Cad("brep")] {
            assert_eq!(warning(57.0, reader), Some(format!("{fact}unit = \"um\" would be plausible")));
        }
        for reader in [Reader::Cad("step"), Reader::Cad("iges")] {
            let remedy = "the unit that its file states is probably wrong: export it again";
            assert_eq!(warning(57.0, reader), Some(format!("{fact}{remedy}")));
            assert_eq!(warning(0.1, reader), None);
        }
    }
}
