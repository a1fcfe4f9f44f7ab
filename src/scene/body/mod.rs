//! The mesh of a scene: read from a volume mesh file, or found or made by the mesher.

mod bodies;
pub(super) mod cut_edges;
pub(super) mod deform;
pub(super) mod grid;
pub(super) mod mesh_file;
pub(super) mod mesh_spec;
pub(super) mod refine;
pub(super) mod request;
pub(super) mod source_volume;
pub(super) mod stored;
pub(super) mod surface_unit;

use super::build::patches::Patches;
use super::error::{SceneError, part};
use crate::mesh::element::CELL_EDGES;
use crate::mesh::enrich::Enriched;
use crate::mesh::format::{Reader, recognise};
use crate::mesh::generate::referred::digest;
use crate::mesh::generate::{
    CablePath, GenerateError, Generated, Manifest, MeshRequest, MeshStore, Size, SizeField, Source,
};
use crate::mesh::{self, TetMesh};
use cut_edges::cut_edges;
use deform::{Undeformed, deform, formulas_of, is_made_here};
use grid::{disturb, mesh_hash, mesh_of_grid, round_volume};
use mesh_file::{content, doubtful_unit, own_skin, reading, taken_over, volume_mesh};
use mesh_spec::{DeformSpec, ElementSpec, MeshSpec};
use request::{check_levels, check_source, given_or_found, request_from};
use source_volume::SourceVolume;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Share of the target number of cells by which an adapted mesh may miss it: the target is a prediction.
const ADAPTED_TOLERANCE: f64 = 0.1;
/// A mesh with the facts known about its source.
#[derive(Debug)]
pub struct Body {
    pub mesh: TetMesh,
    /// Cable paths by name
    pub paths: BTreeMap<String, CablePath>,
    /// File name, for provenance
    pub source: String,
    /// SHA-256 of the file and of the files that it refers to
    pub sha256: String,
    /// Notes on changes to the content of the file
    pub notes: Vec<String>,
    /// Warnings about a doubtful size, a volume that the mesh misses, and edges that it cuts off
    pub warnings: Vec<String>,
    /// Volumes of the surfaces and CAD bodies that were meshed, and of round grids
    pub volumes: Vec<SourceVolume>,
    /// How often each cell of a volume mesh from a file was split; `None` for other meshes and for deformed ones
    pub levels: Option<u32>,
    /// Nodes and cable paths before `[mesh.deform]`; `None` without it
    pub undeformed: Option<Arc<Undeformed>>,
    /// Weights of the balls that scenes on this body have used so far
    pub patches: Patches,
}

impl Body {
    /// Reads, finds or makes the mesh of a scene. `file` is the scene file, for messages and relative paths; `progress` receives the output lines of the
    /// mesher.
    ///
    /// # Errors
    ///
    /// Where a file cannot be read, the mesher fails, or the mesh is not sound: file, place, fact and remedy.
    pub fn load(file: &Path, spec: &MeshSpec, progress: &mut dyn FnMut(&str)) -> Result<Self, SceneError> {
        Self::load_from(file, spec, None, progress)
    }

    /// Reads, finds or makes the mesh of a scene with the bodies and the cache of a mesh store; without one, the store is looked up when it is needed
    /// ([`MeshStore::find`]).
    ///
    /// # Errors
    ///
    /// Fails as [`Body::load`] does.
    pub fn load_from(
        file: &Path,
        spec: &MeshSpec,
        store: Option<&MeshStore>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, SceneError> {
        let mut body = match spec.parts[..] {
            [] => Self::sound(file, spec, store, progress)?,
            _ => Self::of_parts(file, spec, store, progress)?,
        };
        if let Some(worse) = &spec.disturb {
            disturb(file, worse, &mut body.mesh)?;
            body.sha256 = mesh_hash(&body.mesh);
        }
        if let Some(formulas) = &spec.deform {
            body.deform(file, formulas)?;
        }
        check_places(file, &body.mesh)?;
        Ok(body)
    }

    /// Deforms the body, which keeps its original shape in `undeformed`.
    fn deform(&mut self, file: &Path, formulas: &DeformSpec) -> Result<(), SceneError> {
        // Flat facets become curved ones, which other levels would divide differently
        self.levels = None;
        self.undeformed = Some(Arc::new(deform(file, formulas, &mut self.mesh, &mut self.paths)?));
        self.sha256 = mesh_hash(&self.mesh);
        Ok(())
    }

    /// The body of another mesh table with the same connectivity, without a mesher: a grid, a volume mesh, or this body deformed from its original shape.
    ///
    /// # Errors
    ///
    /// Where the other mesh cannot be read or made.
    pub fn varied(&self, file: &Path, spec: &MeshSpec) -> Result<Self, SceneError> {
        if is_made_here(file, spec) {
            return Self::load(file, spec, &mut |_| {});
        }
        let formulas = formulas_of(file, spec)?;
        let before = self.undeformed.as_deref().map(|u| (u.points.clone(), u.paths.clone()));
        let (points, paths) = before.unwrap_or_else(|| (self.mesh.points.clone(), self.paths.clone()));
        let mut anew = Self {
            paths,
            notes: self.notes.clone(),
            warnings: self.warnings.clone(),
            // The volumes before the deformation, as for a body that is deformed when it is loaded
            volumes: self.volumes.clone(),
            ..Self::new(TetMesh { points, ..self.mesh.clone() }, self.source.clone(), String::new())
        };
        anew.deform(file, formulas)?;
        Ok(anew)
    }

    /// A body with the given mesh.
    pub fn of_mesh(mesh: TetMesh) -> Self {
        let sha256 = mesh_hash(&mesh);
        Self::new(mesh, "mesh", sha256)
    }

    /// A body of which only the mesh and its source are known.
    pub(super) fn new(mesh: TetMesh, source: impl Into<String>, sha256: String) -> Self {
        Self {
            mesh,
            paths: BTreeMap::new(),
            source: source.into(),
            sha256,
            notes: vec![],
            warnings: vec![],
            volumes: vec![],
            levels: None,
            undeformed: None,
            patches: Patches::default(),
        }
    }

    pub(super) fn sound(
        file: &Path,
        spec: &MeshSpec,
        store: Option<&MeshStore>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, SceneError> {
        let fail = |e: Box<dyn std::error::Error + Send + Sync>| part(file, "mesh", e);
        check_source(file, spec)?;
        if let Some(boxes) = &spec.grid {
            let mesh = mesh_of_grid(file, boxes, spec.element)?;
            let sha256 = mesh_hash(&mesh);
            let volumes = SourceVolume::of_grid(round_volume(boxes), &mesh);
            return Ok(Self { volumes, ..Self::new(mesh, "grid", sha256) });
        }
        if let Some((path, format)) = volume_mesh(file, spec)? {
            let how = reading(file, spec)?;
            let readable = match format.reader {
                Reader::Mesher(name) => {
                    let store = given_or_found(store).map_err(|e| fail(e.into()))?;
                    store.converted(&path, name, progress).map_err(|e| fail(e.into()))?
                }
                _ => path.clone(),
            };
            let (mesh, changes) = mesh::read_as(&path, &readable, format.reader, &how).map_err(|e| fail(e.into()))?;
            check_element(file, spec, &mesh)?;
            let mut body = Self::of_file(file, mesh, (&path, format.reader))?;
            body.notes = taken_over(&changes);
            body.notes.extend(own_skin(&body.mesh));
            body.warnings.extend(doubtful_unit(&body.mesh, format.reader, how.unit_m));
            body.split(file, spec.levels)?;
            return Ok(body);
        }
        let request = request_from(file, spec, store)?;
        let store = given_or_found(store).map_err(|e| fail(e.into()))?;
        let made = store.mesh(&request, progress).map_err(|e| fail(e.into()))?;
        let mut body = Self::generated(file, made, request.levels)?;
        if let Source::File { path, unit_m } = &request.source {
            let reader = recognise(path).map_err(|e| fail(e.into()))?.reader;
            body.warnings.extend(doubtful_unit(&body.mesh, reader, *unit_m));
        }
        Ok(body)
    }

    /// Splits each cell of a given mesh into eight, `levels` times. The shape of its boundary does not change.
    fn split(&mut self, file: &Path, levels: u32) -> Result<(), SceneError> {
        self.levels = Some(levels);
        if levels == 0 {
            return Ok(());
        }
        check_levels(file, levels, self.mesh.cell_count())?;
        let cells = self.mesh.cell_count();
        for _ in 0..levels {
            self.mesh = Enriched::by_splitting(&self.mesh).mesh;
        }
        self.sha256 = mesh_hash(&self.mesh);
        self.notes.push(format!(
            "each of the {cells} cells of the file is split into {}; the boundary stays the one of the file, also where the body is round",
            1 << (3 * levels)
        ));
        Ok(())
    }

    /// The mesh of the same table with the given number of cells, whose edge lengths are proportional to a size field instead of the size in the table.
    pub(super) fn sized(
        file: &Path,
        spec: &MeshSpec,
        (field, count): (SizeField, u64),
        store: Option<&MeshStore>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, SceneError> {
        let fail = |e: GenerateError| part(file, "mesh.refine", e);
        let of = request_from(file, spec, store)?;
        let size = Size::Cells { count, tolerance: ADAPTED_TOLERANCE };
        let request = MeshRequest { size: Some(size), levels: 0, field: Some(field), ..of };
        let made = given_or_found(store).and_then(|store| store.mesh(&request, progress)).map_err(fail)?;
        Self::generated(file, made, 0)
    }

    /// A body with a mesh of the mesher, with its notes and warnings.
    fn generated(file: &Path, made: Generated, levels: u32) -> Result<Self, SceneError> {
        if let Some(name) = made.manifest.volumes_cad_m3.keys().find(|name| !made.mesh.regions.contains_key(*name)) {
            let fact = format!("the mesh has no cells of {name}, which the CAD has");
            return Err(content(file, fact, "use more cells or a smaller size"));
        }
        let (volumes, off) = (SourceVolume::all(&made.manifest, &made.mesh), straightened(levels, &made.manifest));
        let mut body = Self::of_file(file, made.mesh, (&made.path, Reader::Msh))?;
        body.paths = made.manifest.paths;
        body.warnings.extend(off);
        body.notes = made.manifest.dropped;
        body.warnings.extend(volumes.iter().filter_map(SourceVolume::warning));
        body.warnings.extend(made.manifest.edge_error_m.and_then(|off| cut_edges(&body.mesh, off)));
        body.volumes = volumes;
        Ok(body)
    }

    /// A body with the mesh of a file.
    fn of_file(file: &Path, mesh: TetMesh, (source, reader): (&Path, Reader)) -> Result<Self, SceneError> {
        let sha256 = digest("", source, reader.shape().1).map_err(|e| part(file, "mesh", e))?;
        let source = source.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        Ok(Self::new(mesh, source, sha256))
    }
}

/// Accepted diagonals of a body \[m\]; outside of them the unit is surely wrong.
const ACROSS: std::ops::RangeInclusive<f64> = 1e-12..=1e12;
/// Smallest accepted edge length of a cell relative to its distance from the origin: a coordinate has sixteen digits, and strains need some of them.
const RESOLVED: f64 = 1e-11;

/// Refuses a mesh whose coordinates cannot tell its nodes apart, because its size or distance is due to a mistyped exponent.
fn check_places(file: &Path, mesh: &TetMesh) -> Result<(), SceneError> {
    let across = mesh.diagonal();
    if !ACROSS.contains(&across) {
        let fact = format!("the mesh is {across:e} m across");
        return Err(content(file, fact, "give it a size from 1e-12 to 1e12 m (check units and exponents)"));
    }
    let is_lost = |cell: &[u32]| {
        let corners: [_; 4] = std::array::from_fn(|k| mesh.points[cell[k] as usize]);
        let away = corners.iter().map(|p| p.amax()).fold(0.0, f64::max);
        let edge = |&[a, b]: &[usize; 2]| (corners[a] - corners[b]).norm();
        CELL_EDGES.iter().any(|ends| edge(ends) < RESOLVED * away)
    };
    match mesh.cells.chunks_exact(mesh.order.cell_nodes()).position(is_lost) {
        Some(cell) => {
            let fact = format!("cell {cell} is too far from the origin for its size: its edges are lost in rounding");
            Err(content(file, fact, "shift the body towards the origin, or take larger cells there"))
        }
        None => Ok(()),
    }
}

/// Refuses a file whose cells do not have the element type of the table.
fn check_element(file: &Path, spec: &MeshSpec, mesh: &TetMesh) -> Result<(), SceneError> {
    let (wanted, found) = (spec.element, ElementSpec::of(mesh.order));
    if wanted == found {
        return Ok(());
    }
    let (wanted, found) = (wanted.name(), found.name());
    let fact = format!("element = \"{wanted}\", but the file holds {found} cells");
    let remedy = format!("write element = \"{found}\", or give a file with {wanted} cells");
    Err(content(file, fact, &remedy))
}

/// The warning about a mesh whose curved edges left the CAD. Meshes of earlier versions, for which the distance is not known, get the warning if they are
/// nested.
fn straightened(levels: u32, manifest: &Manifest) -> Option<String> {
    let edges = manifest.straightened_edges.filter(|edges| *edges > 0)?;
    let distance = manifest.straightened_m.map_or_else(String::new, |off| format!(" by up to {:.4} mm", off * 1e3));
    let left = format!(
        "{edges} edges on the surface of the body or of a solid left the CAD{distance}, because cells on it would be folded"
    );
    match manifest.straightened_m {
        _ if levels > 0 => Some(format!(
            "{left}: their nodes stay off it on all finer levels, which approach another shape; begin with a finer mesh"
        )),
        Some(_) => Some(format!("{left}: the shape is another one there; use more cells, or a smaller size")),
        None => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A solid of the CAD without cells is refused before its mesh is used.
    #[test]
    fn a_mesh_that_lacks_a_solid_is_refused() {
        let mesh = crate::mesh::structured::block(1, 1, 1, 1e-3, 1e-3, 1e-3, crate::mesh::Order::Linear);
        let text = r#"{"request":{},"cells":6,"nodes":8,"facets":12,"order":1,"h_m":5e-4,"regions":{},"volume_m3":1e-9,"volume_cad_m3":2e-9,
            "volume_error":-0.5,"volumes_cad_m3":{"volume_2":1e-9}}"#;
        let manifest = serde_json::from_str(text).expect("a manifest");
        let made = Generated { mesh, manifest, name: String::new(), path: "m.msh.gz".into(), made: true };
        let error = Body::generated(Path::new("scene.toml"), made, 0).expect_err("volume_2 has no cells").to_string();
        assert!(error.contains("the mesh has no cells of volume_2, which the CAD has"), "{error}");
    }

    /// Edges that left the CAD cause a warning; for a mesh of an earlier version, only on nested levels.
    #[test]
    fn a_boundary_that_left_the_cad_is_a_warning() {
        let manifest = |edges: u32, more: &str| -> Manifest {
            let text = format!(
                r#"{{"request":{{}},"cells":1,"nodes":4,"facets":4,"order":1,"h_m":0.5,"regions":{{}},"volume_m3":0.2,"volume_cad_m3":null,"volume_error":null,"straightened_edges":{edges}{more}}}"#
            );
            serde_json::from_str(&text).expect("a manifest")
        };
        let (earlier, now) = (manifest(12, ""), manifest(12, r#","straightened_m":0.0014"#));
        let on_levels = straightened(2, &earlier).expect("a warning");
        assert!(on_levels.starts_with("12 edges on the surface of the body or of a solid left the CAD, because"));
        assert!(on_levels.ends_with("begin with a finer mesh"));
        let far = "12 edges on the surface of the body or of a solid left the CAD by up to 1.4000 mm, because";
        for levels in [0, 2] {
            assert!(straightened(levels, &now).is_some_and(|text| text.starts_with(far)));
        }
        assert_eq!(
            [
                straightened(0, &earlier),
                straightened(2, &manifest(0, "")),
                straightened(0, &manifest(0, r#","straightened_m":0.0"#))
            ],
            [None, None, None]
        );
    }
}
