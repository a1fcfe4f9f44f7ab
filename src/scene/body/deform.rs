//! `[mesh.deform]`: formulas x(X, Y, Z; parameters) move the nodes of a mesh before anything is built on it. A shape thus has parameters where a mesher would
//! make a different mesh for each value.

use super::mesh_file::volume_mesh;
use super::mesh_spec::{DeformSpec, MeshSpec};
use crate::math::formula::Formula;
use crate::math::tensor::Vec3;
use crate::math::units;
use crate::mesh::TetMesh;
use crate::mesh::generate::CablePath;
use crate::mesh::validate::min_det;
use crate::scene::error::{SceneError, hint, part};
use crate::scene::text::quantity::Quantity;
use std::collections::BTreeMap;
use std::path::Path;

const PLACE: &str = "mesh.deform";
/// Names of the coordinates in formulas.
const COORDINATES: [&str; 3] = ["X", "Y", "Z"];

/// Nodes and cable paths of a body before its deformation.
#[derive(Clone, Debug)]
pub struct Undeformed {
    pub(in crate::scene) points: Vec<Vec3>,
    pub(in crate::scene) paths: BTreeMap<String, CablePath>,
}

/// Deforms the nodes and the cable paths of a body, and returns their original positions.
pub(in crate::scene) fn deform(
    file: &Path,
    spec: &DeformSpec,
    mesh: &mut TetMesh,
    paths: &mut BTreeMap<String, CablePath>,
) -> Result<Undeformed, SceneError> {
    let map = Map::new(file, spec)?;
    let undeformed = Undeformed { points: std::mem::take(&mut mesh.points), paths: std::mem::take(paths) };
    mesh.points = undeformed.points.iter().map(|p| map.at(*p)).collect();
    *paths = undeformed.paths.iter().map(|(name, path)| (name.clone(), map.path(path))).collect();
    check(file, mesh)?;
    Ok(undeformed)
}

/// The formulas of `[mesh.deform]` in a changed `[mesh]` table of a body that the mesher made. Such a body can only be deformed anew: without formulas the
/// change is refused.
pub(super) fn formulas_of<'a>(file: &Path, spec: &'a MeshSpec) -> Result<&'a DeformSpec, SceneError> {
    let fact = "the mesher would make another mesh";
    let remedy = "declare the change of shape in [mesh.deform], or take a grid";
    spec.deform.as_ref().ok_or_else(|| content(file, fact.into(), remedy))
}

/// Whether the meshes of all bodies are made or read without a mesher.
pub(in crate::scene) fn is_made_here(file: &Path, spec: &MeshSpec) -> bool {
    let is_made = |mesh: &MeshSpec| mesh.grid.is_some() || volume_mesh(file, mesh).is_ok_and(|found| found.is_some());
    match &spec.parts[..] {
        [] => is_made(spec),
        parts => parts.iter().all(|part| is_made(&part.mesh(spec))),
    }
}

fn check(file: &Path, mesh: &TetMesh) -> Result<(), SceneError> {
    if let Some(k) = mesh.points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        let fact = format!("it moves node {k} to a place that is no number");
        return Err(content(file, fact, "check the formulas at the nodes of the mesh, in metres"));
    }
    match (0..mesh.cell_count()).find(|&c| min_det(mesh, c) <= 0.0) {
        None => Ok(()),
        Some(c) => Err(content(file, format!("it folds cell {c}"), "deform less: cells must not be turned inside out")),
    }
}

fn content(file: &Path, fact: String, remedy: &str) -> SceneError {
    SceneError::Content { file: file.into(), place: PLACE.into(), fact, remedy: remedy.into() }
}

/// The formulas with the values of their parameters.
struct Map {
    /// The formula of each component, with the coordinate or the value for each of its variables; `None` if the component does not change
    formulas: [Option<(Formula, Vec<Variable>)>; 3],
}

enum Variable {
    Coordinate(usize),
    Value(f64),
}

impl Map {
    fn new(file: &Path, spec: &DeformSpec) -> Result<Self, SceneError> {
        let mut values = BTreeMap::new();
        for (name, value) in &spec.parameters {
            let place = format!("{PLACE}.parameters.{name}");
            let value = match value {
                Quantity::Text(text) => units::quantity(text).map_err(|e| part(file, place, e))?.0,
                Quantity::Si(value) => *value,
            };
            values.insert(name.as_str(), value);
        }
        if let Some(name) = COORDINATES.iter().find(|name| values.contains_key(*name)) {
            return Err(content(
                file,
                format!("a parameter is called {name}"),
                "X, Y, Z are the coordinates: rename it",
            ));
        }
        let texts = [&spec.x, &spec.y, &spec.z];
        if texts.iter().all(|text| text.is_none()) {
            return Err(content(file, "it has no formula".into(), "give at least one of `x`, `y`, `z`"));
        }
        let used = |name: &str, formulas: &[Option<(Formula, Vec<Variable>)>]| {
            formulas.iter().flatten().any(|(formula, _)| formula.variables().iter().any(|v| v == name))
        };
        let mut formulas = [None, None, None];
        for (k, text) in texts.into_iter().enumerate() {
            let Some(text) = text else { continue };
            let component = ["x", "y", "z"][k];
            let formula = Formula::new(text, 1.0)
                .map_err(|e| content(file, format!("{component}: {e}"), "write for example x = \"X * scale\""))?;
            let variable = |name: &String| match COORDINATES.iter().position(|c| c == name) {
                Some(k) => Ok(Variable::Coordinate(k)),
                None => values.get(name.as_str()).map(|v| Variable::Value(*v)).ok_or_else(|| {
                    let known: Vec<&str> = COORDINATES.into_iter().chain(values.keys().copied()).collect();
                    content(file, format!("{component}: {name} is not known"), &hint(name, &known))
                }),
            };
            let variables = formula.variables().iter().map(variable).collect::<Result<_, _>>()?;
            formulas[k] = Some((formula, variables));
        }
        match values.keys().find(|name| !used(name, &formulas)) {
            Some(name) => Err(content(file, format!("no formula takes the parameter {name}"), "remove it")),
            None => Ok(Self { formulas }),
        }
    }

    fn at(&self, p: Vec3) -> Vec3 {
        Vec3::from_fn(|k, _| match &self.formulas[k] {
            None => p[k],
            Some((formula, variables)) => {
                let value = |v: &Variable| match v {
                    Variable::Coordinate(k) => p[*k],
                    Variable::Value(value) => *value,
                };
                formula.value(&variables.iter().map(value).collect::<Vec<_>>())
            }
        })
    }

    fn path(&self, path: &CablePath) -> CablePath {
        let moved = |p: &[f64; 3]| self.at(Vec3::from(*p)).into();
        CablePath {
            guides: path.guides.iter().map(moved).collect(),
            pull_point: moved(&path.pull_point),
            ..path.clone()
        }
    }
}
