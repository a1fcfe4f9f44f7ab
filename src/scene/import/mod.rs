//! Import of a mesh, surface or CAD file: its content, and the keys with which a scene can use it.

pub(super) mod fixture;
pub(super) mod starter;

use super::body::Body;
use super::body::mesh_file::{content, plausible_unit};
use super::body::mesh_spec::{ElementSpec, MeshSpec};
use super::error::{SceneError, part};
use super::text::quantity::Length;
use crate::math::units::{self, Dimension};
use crate::mesh::census::{Census, census};
use crate::mesh::error::MeshError;
use crate::mesh::format::{Format, Reader, recognise};
use crate::mesh::generate::{GenerateError, MeshStore};
use crate::mesh::parts::parts;
use crate::mesh::surface_file::read_surface;
use fixture::{Fixture, fixture};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Number of cells of the first mesh of a shape that has not been meshed yet.
const FIRST_CELLS: usize = 2000;

/// Content of a file, and the keys of `[mesh]` with which it can be used.
#[derive(Clone)]
pub struct Import {
    pub file: PathBuf,
    pub format: Format,
    /// Counts and sizes of the file; `None` for CAD, which has no nodes
    pub census: Option<Census>,
    /// Unit of length: given, stated by the file, or guessed from its size
    pub unit: String,
    /// Reason for this unit
    pub unit_reason: String,
    pub spec: MeshSpec,
}

/// A file that can be used, on its mesh.
pub struct Imported {
    pub body: Body,
    /// Number of parts of the mesh that share no node
    pub components: usize,
    pub fixture: Fixture,
}

impl Import {
    /// Examines a file; `unit` overrides the guess.
    ///
    /// # Errors
    ///
    /// Where the file cannot be read, is of no known format, or is damaged.
    pub fn of(file: &Path, unit: Option<&str>, progress: &mut dyn FnMut(&str)) -> Result<Self, SceneError> {
        let fail = |e: Box<dyn std::error::Error + Send + Sync>| part(file, "file", e);
        let format = recognise(file).map_err(SceneError::Mesh)?;
        let census = match format.reader {
            Reader::Cad(_) => None,
            Reader::Surface(_) => surface_census(file),
            Reader::Mesher(name) => {
                let store = MeshStore::find().map_err(|e| fail(e.into()))?;
                let path = store.converted(file, name, progress).map_err(|e| fail(e.into()))?;
                Some(census(file, &path, format.reader).map_err(SceneError::Mesh)?)
            }
            _ => Some(census(file, file, format.reader).map_err(SceneError::Mesh)?),
        };
        let (unit, unit_reason) = match unit {
            Some(unit) => (unit.to_string(), "as given".to_string()),
            None => guessed_unit(&format, census.as_ref()),
        };
        let mut spec = MeshSpec { file: Some(file.into()), unit: Some(unit.clone()), ..MeshSpec::default() };
        match &census {
            Some(found) if format.reader.is_volume() && !found.cells.is_empty() => {
                spec.split = found.divisible;
                spec.element = if found.quadratic { ElementSpec::Tet10 } else { ElementSpec::Tet4 };
                let metre = units::parse(&format!("1 {unit}"), Dimension::LENGTH).map_err(|e| part(file, "unit", e))?;
                let size = (found.bounds.1 - found.bounds.0).norm() * metre;
                spec.merge = (found.doubled_nodes > 0).then(|| Length(rounded_up(2e-9 * size)));
            }
            // The mesh of the starter scene, so that it is made only once
            _ => (spec.cells, spec.element) = (Some(FIRST_CELLS), ElementSpec::Tet10),
        }
        Ok(Self { file: file.into(), format, census, unit, unit_reason, spec })
    }

    /// Sets the number of cells, in place of the usual number.
    ///
    /// # Errors
    ///
    /// Where the file is a volume mesh, which is used as it is.
    pub fn with_cells(mut self, cells: usize) -> Result<Self, SceneError> {
        if self.spec.cells.is_none() {
            let remedy = "leave the number of cells out; `levels = 1` in [mesh] splits each of its cells into eight";
            return Err(content(&self.file, "it is a volume mesh, which is taken over", remedy));
        }
        self.spec.cells = Some(cells);
        Ok(self)
    }

    /// Reads or makes the mesh, and chooses the nodes to hold. If the shape has no mesh with the requested number of cells, the number is adjusted up to
    /// twice: to the nearest one, or, if the shape needs more cells, to somewhat more than the smallest number.
    ///
    /// # Errors
    ///
    /// Where the mesh cannot be read or made.
    pub fn load(&mut self, progress: &mut dyn FnMut(&str)) -> Result<Imported, SceneError> {
        let file = std::path::absolute(&self.file).unwrap_or(self.file.clone());
        let mut made =
            |spec: &MeshSpec| Body::load(&self.file, &MeshSpec { file: Some(file.clone()), ..spec.clone() }, progress);
        let mut body = made(&self.spec);
        // The second number may again lie between two that the shape can have
        for _ in 0..2 {
            let Some(nearest) = body.as_ref().err().and_then(nearest_cells) else { break };
            let is_bound = self.spec.cells.is_some_and(|asked| nearest > asked);
            self.spec.cells = Some(if is_bound { above_bound(nearest) } else { nearest });
            body = made(&self.spec);
        }
        let body = body.map_err(without_place)?;
        let of_cells = parts(&body.mesh);
        let fixture = fixture(&body.mesh, &of_cells);
        let mut components = of_cells;
        components.sort_unstable();
        components.dedup();
        Ok(Imported { body, components: components.len(), fixture })
    }
}

/// Number of cells of the nearest mesh, if the mesher failed only because it missed the requested number.
pub(crate) fn nearest_cells(error: &SceneError) -> Option<usize> {
    let SceneError::Part { source, .. } = error else { return None };
    match source.downcast_ref()? {
        GenerateError::Failed { nearest, .. } => *nearest,
        _ => None,
    }
}

/// A number of cells with which most shapes can be meshed, 1.2 times the smallest one with two significant digits: near the smallest one, numbers scatter.
fn above_bound(least: usize) -> usize {
    let least = (12 * least).div_ceil(10);
    least.next_multiple_of(10_usize.pow(least.ilog10().saturating_sub(1)))
}

/// An error of a mesh file without the place of a scene that names it, since the file is given directly.
fn without_place(error: SceneError) -> SceneError {
    match error {
        SceneError::Part { file, place, source } => match source.downcast::<MeshError>() {
            Ok(of_mesh) => SceneError::Mesh(*of_mesh),
            Err(source) => SceneError::Part { file, place, source },
        },
        other => other,
    }
}

/// The census of a surface file, if its format is one that is read without the mesher.
fn surface_census(file: &Path) -> Option<Census> {
    let surface = read_surface(file, 1.0).ok()?;
    Some(Census {
        nodes: surface.points.len(),
        cells: BTreeMap::new(),
        others: BTreeMap::from([("triangles", surface.triangles.len())]),
        bounds: surface.bounds(),
        unused_nodes: 0,
        doubled_nodes: 0,
        inverted_cells: 0,
        divisible: false,
        quadratic: false,
    })
}

/// The unit that gives the body the size of a soft robot, and the reason for it.
fn guessed_unit(format: &Format, census: Option<&Census>) -> (String, String) {
    let Some(census) = census else {
        let reason = match format.reader {
            reader if reader.states_its_unit() => "the file states its own unit",
            Reader::Cad(_) => "usual for CAD",
            _ => "usual for CAD, the file states none; check it",
        };
        return ("mm".into(), reason.into());
    };
    let diagonal = (census.bounds.1 - census.bounds.0).norm();
    match plausible_unit(diagonal) {
        Some(unit) => {
            let metre = units::parse(&format!("1 {unit}"), Dimension::LENGTH).unwrap_or(1.0);
            (unit.into(), format!("guessed: the body is then {:.3} mm across; check it", diagonal * metre * 1e3))
        }
        None => ("mm".into(), "no usual unit gives the size of a soft robot; check it".into()),
    }
}

/// The next power of ten.
fn rounded_up(length: f64) -> f64 {
    10f64.powf(length.max(1e-15).log10().ceil())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_the_least_number_of_cells_is_asked_for() {
        assert_eq!([2, 7, 24, 96, 2732, 10_000].map(above_bound), [3, 9, 29, 120, 3300, 12_000]);
    }
}
