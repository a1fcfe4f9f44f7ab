//! The request to the mesher that a `[mesh]` table describes, and the keys that have no effect with its source of the mesh.

use super::mesh_file::{content, unit_m, volume_mesh};
use super::mesh_spec::{ElementSpec, GeneratorSpec, GradingSpec, MeshSpec};
use crate::mesh::generate::body::ParametricBody;
use crate::mesh::generate::{
    GenerateError, Generator, GradedPlace, Grading, MeshRequest, MeshStore, Size, Source, TIME_LIMIT_S,
};
use crate::scene::error::{SceneError, part};
use crate::scene::text::quantity::Length;
use std::collections::BTreeMap;
use std::path::Path;

/// Share of the target number of cells by which a mesh may miss it.
const CELL_TOLERANCE: f64 = 0.02;
/// Largest number of cells that may be requested for a mesh.
const MOST_CELLS: usize = 100_000_000;
/// Largest number of times that each cell is split into eight.
const MOST_LEVELS: u32 = 8;

/// The request to the mesher that a `[mesh]` table describes.
///
/// # Errors
///
/// Where the table names no body or file, or sizes that no mesh can have.
pub fn request(file: &Path, spec: &MeshSpec) -> Result<MeshRequest, SceneError> {
    request_from(file, spec, None)
}

/// The request to the mesher, with the bodies of a mesh store; without one, the store is looked up when it is needed.
pub(super) fn request_from(file: &Path, spec: &MeshSpec, store: Option<&MeshStore>) -> Result<MeshRequest, SceneError> {
    check_source(file, spec)?;
    let base = file.parent().unwrap_or(Path::new(""));
    let source = match (&spec.body, &spec.file) {
        (Some(name), None) => Source::Body { name: name.clone(), parameters: parameters(file, name, spec, store)? },
        (None, Some(path)) => Source::File { path: base.join(path), unit_m: unit_m(file, spec)? },
        _ => return Err(content(file, "the mesh is a grid, which takes no mesher", "run the scene as it is")),
    };
    let size = match (spec.cells, spec.size) {
        (Some(0), None) => return Err(content(file, "cells = 0", "ask for at least one cell")),
        (Some(count), None) if count > MOST_CELLS => {
            let fact = format!("cells = {count}");
            return Err(content(file, fact, &format!("ask for at most {MOST_CELLS}; no solver here holds more")));
        }
        (Some(count), None) => Some(Size::Cells { count: count as u64, tolerance: CELL_TOLERANCE }),
        (None, Some(length)) if length.0 > 0.0 => Some(Size::Length(length.0)),
        (None, Some(length)) => return Err(content(file, format!("size = {} m", length.0), "it must be positive")),
        (None, None) if !spec.cgal.is_empty() => None,
        _ => return Err(content(file, "neither `cells` nor `size` is given, or both are", "give one of them")),
    };
    if let Some(limit) = spec.time_limit.filter(|limit| limit.0 <= 0.0) {
        return Err(content(file, format!("time_limit = {} s", limit.0), "it must be positive"));
    }
    let grading = spec.grading.iter().map(|g| grading(file, g)).collect::<Result<_, _>>()?;
    let json = |v: &toml::Value| serde_json::to_value(v).expect("TOML values are JSON values");
    Ok(MeshRequest {
        source,
        generator: match spec.generator {
            GeneratorSpec::Gmsh => Generator::Gmsh,
            GeneratorSpec::Cgal => Generator::Cgal,
        },
        size,
        levels: spec.levels,
        grading,
        order: if spec.element == ElementSpec::Tet4 { 1 } else { 2 },
        seed: spec.seed,
        optimise: true,
        cgal: spec.cgal.iter().map(|(k, v)| (k.clone(), json(v))).collect(),
        field: None,
        time_limit_s: spec.time_limit.map_or(TIME_LIMIT_S, |limit| limit.0),
    })
}

/// An entry of `grading`, which names exactly one kind of place.
fn grading(file: &Path, spec: &GradingSpec) -> Result<Grading, SceneError> {
    let metres = |p: &[Length; 3]| p.map(|x| x.0);
    let near = match (&spec.feature, &spec.points, &spec.corners) {
        (Some(name), None, None) => GradedPlace::Feature(name.clone()),
        (None, Some(points), None) if !points.is_empty() => GradedPlace::Points(points.iter().map(metres).collect()),
        (None, None, Some(corners)) if (0..3).all(|d| corners.min[d].0 <= corners.max[d].0) => {
            GradedPlace::Box([metres(&corners.min), metres(&corners.max)])
        }
        (None, None, Some(_)) => {
            return Err(content(
                file,
                "the box of `grading` has a `min` beyond its `max`",
                "give the lower corner as `min`",
            ));
        }
        _ => {
            let remedy = "give exactly one of them, and points that are not empty";
            return Err(content(file, "an entry of `grading` needs one place: `feature`, `points` or `box`", remedy));
        }
    };
    Ok(Grading { near, length: spec.length.0, distance: spec.distance.0 })
}

fn parameters(
    file: &Path,
    name: &str,
    spec: &MeshSpec,
    store: Option<&MeshStore>,
) -> Result<BTreeMap<String, f64>, SceneError> {
    let fail = |e| part(file, "mesh.parameters", e);
    let store = given_or_found(store).map_err(fail)?;
    let declared = ParametricBody::load(&store.home.path, name).map_err(|e| part(file, "mesh.body", e))?;
    let value = |(key, text): (&String, &String)| Ok((key.clone(), declared.parse(key, text).map_err(fail)?));
    spec.parameters.iter().map(value).collect()
}

/// The given mesh store, or otherwise the one that [`MeshStore::find`] finds.
pub(super) fn given_or_found(store: Option<&MeshStore>) -> Result<MeshStore, GenerateError> {
    store.map_or_else(MeshStore::find, |store| Ok(store.clone()))
}

/// Whether the table has a source of its own.
pub(super) fn has_source(spec: &MeshSpec) -> bool {
    spec.grid.is_some() || spec.body.is_some() || spec.file.is_some()
}

/// Refuses keys that have no effect with the source of the mesh: nothing is ignored silently.
pub(super) fn check_source(file: &Path, spec: &MeshSpec) -> Result<(), SceneError> {
    check_refine(file, spec)?;
    check_levels(file, spec.levels, 1)?;
    if spec.grid.is_some() {
        let others = [("body", spec.body.is_some()), ("file", spec.file.is_some())];
        return match idle(&others).or(of_source(spec)) {
            Some(key) => Err(content(file, format!("`{key}` has no effect next to `grid`"), "remove one of the two")),
            None => Ok(()),
        };
    }
    match (&spec.body, &spec.file) {
        (Some(body), Some(path)) => {
            let fact = format!("both body = \"{body}\" and file = \"{}\" are given", path.display());
            Err(content(file, fact, "remove one of the two"))
        }
        (None, None) => {
            let remedy = "give `body` with `cells` or `size`, `file` with `unit`, or `grid`";
            Err(content(file, "neither `body` nor `file` nor `grid` is given", remedy))
        }
        (Some(_), None) => match idle(&[("unit", spec.unit.is_some())]).or(idle(&taken(spec))) {
            Some(key) => Err(content(file, format!("`{key}` belongs to `file`, not to `body`"), "remove it")),
            None => Ok(()),
        },
        (None, Some(_)) => {
            let as_it_is = volume_mesh(file, spec)?.is_some();
            let parameters = [("parameters", !spec.parameters.is_empty())];
            let other = if as_it_is { idle(&made(spec)) } else { idle(&taken(spec)) };
            match idle(&parameters).or(other) {
                Some(key) => Err(content(file, format!("`{key}` has no effect on this `file`"), "remove it")),
                None => Ok(()),
            }
        }
    }
}

/// Refuses keys of a source in a table whose parts all have a source of their own.
pub(super) fn check_without_source(file: &Path, spec: &MeshSpec) -> Result<(), SceneError> {
    check_refine(file, spec)?;
    match of_source(spec) {
        Some(key) => {
            let fact = format!("`{key}` has no effect in [mesh] where every part has a source of its own");
            Err(content(file, fact, "remove it, or leave the source of one of the parts to [mesh]"))
        }
        None => Ok(()),
    }
}

/// The first key that is present.
fn idle(keys: &[(&str, bool)]) -> Option<String> {
    keys.iter().find(|(_, given)| *given).map(|(key, _)| key.to_string())
}

/// The first key that is present among those that need a body or a file.
fn of_source(spec: &MeshSpec) -> Option<String> {
    let sized = [
        ("unit", spec.unit.is_some()),
        ("cells", spec.cells.is_some()),
        ("size", spec.size.is_some()),
        ("parameters", !spec.parameters.is_empty()),
        ("levels", spec.levels > 0),
    ];
    idle(&sized).or(idle(&made(spec))).or(idle(&taken(spec)))
}

/// Refuses more levels, or more cells after splitting, than any solver here can handle.
pub(super) fn check_levels(file: &Path, levels: u32, cells: usize) -> Result<(), SceneError> {
    let fact = format!("levels = {levels}");
    if levels > MOST_LEVELS {
        return Err(content(file, fact, &format!("each makes eight cells of one: take at most {MOST_LEVELS}")));
    }
    if cells > MOST_CELLS >> (3 * levels) {
        return Err(content(
            file,
            fact,
            &format!("each makes eight cells of one, of {cells} here: at most {MOST_CELLS} fit"),
        ));
    }
    Ok(())
}

/// Refuses a refinement without a tolerance, and one of a mesh that the mesher cannot make from a size field.
fn check_refine(file: &Path, spec: &MeshSpec) -> Result<(), SceneError> {
    let Some(refine) = &spec.refine else { return Ok(()) };
    let positive = |t: Option<f64>| t.is_none_or(|t| t > 0.0 && t.is_finite());
    let reasons = [
        (
            refine.tolerance.is_some() == refine.absolute_tolerance.is_some(),
            "give either tolerance = \"1 %\" or absolute_tolerance",
        ),
        (!positive(refine.tolerance) || !positive(refine.absolute_tolerance), "a tolerance must be positive"),
        (refine.meshes == 0, "`meshes` must be at least 1"),
        (spec.generator == GeneratorSpec::Cgal, "CGAL takes no size field; use generator = \"gmsh\""),
        (
            !spec.parts.is_empty(),
            "remove it: several bodies are not refined; a scene of one of them alone finds its number of cells",
        ),
        (spec.disturb.is_some(), "a disturbed mesh is not refined; remove `disturb`"),
        (spec.deform.is_some(), "a deformed mesh is not refined; remove `deform`"),
        (spec.grid.is_some(), "a grid is not refined; take `body`, or `file` with CAD or a surface"),
        (
            volume_mesh(file, spec)?.is_some(),
            "a volume mesh is not meshed anew; give `file` with CAD or a surface, or split its cells by `levels`",
        ),
    ];
    match reasons.iter().find(|(fault, _)| *fault) {
        Some((_, remedy)) => Err(content(file, "`refine` cannot be followed", remedy)),
        None => Ok(()),
    }
}

/// Keys that only a mesher uses, and whether they are present.
fn made(spec: &MeshSpec) -> [(&'static str, bool); 5] {
    [
        ("grading", !spec.grading.is_empty()),
        ("seed", spec.seed > 0),
        ("cgal", !spec.cgal.is_empty()),
        ("generator", spec.generator != GeneratorSpec::default()),
        ("time_limit", spec.time_limit.is_some()),
    ]
}

/// Keys of volume meshes that are used as they are, and whether they are present.
fn taken(spec: &MeshSpec) -> [(&'static str, bool); 2] {
    [("split", spec.split), ("merge", spec.merge.is_some())]
}
