//! The mesh of a scene: read from a volume mesh file, or found or made by the mesher.

mod bodies;
pub(super) mod cut_edges;
pub(super) mod deform;
pub(super) mod grid;
pub(super) mod mesh_file;
pub(super) mod mesh_spec;
pub(super) mod refine;
pub(super) mod source_volume;
pub(super) mod stored;
pub(super) mod surface_unit;

use super::build::patches::Patches;
use super::error::{SceneError, part};
use super::text::quantity::Length;
use crate::mesh::element::CELL_EDGES;
use crate::mesh::format::{Reader, recognise};
use crate::mesh::generate::body::Body as Declared;
use crate::mesh::generate::referred::digest;
use crate::mesh::generate::{
    CablePath, GenerateError, Generated, Generator, GradedPlace, Grading, Manifest, MeshRequest, MeshStore, Size,
    SizeField, Source, TIME_LIMIT_S,
};
use crate::mesh::{self, Order, TetMesh};
use cut_edges::cut_edges;
use deform::{Undeformed, deform, formulas_of, is_made_here};
use grid::{disturb, grid, mesh_hash};
use mesh_file::{content, doubtful_unit, reading, taken_over, unit_m, volume_mesh};
use mesh_spec::{DeformSpec, ElementSpec, GeneratorSpec, GradingSpec, MeshSpec};
use source_volume::SourceVolume;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Share of the target number of cells by which a mesh may miss it.
const CELL_TOLERANCE: f64 = 0.02;
/// The same of an adapted mesh, whose number is a prediction.
const ADAPTED_TOLERANCE: f64 = 0.1;
/// Most cells that a mesh may be asked for.
const MOST_CELLS: usize = 100_000_000;
/// Most levels of splitting each cell into eight.
const MOST_LEVELS: u32 = 8;

/// A mesh and what its maker says of it.
#[derive(Debug)]
pub struct Body {
    pub mesh: TetMesh,
    /// Cable paths by name
    pub paths: BTreeMap<String, CablePath>,
    /// File name, for provenance
    pub source: String,
    /// SHA-256 of the file, with those that it refers to
    pub sha256: String,
    /// Notes on changes to the content of the file
    pub notes: Vec<String>,
    /// Warnings of a doubtful size, of a volume that the mesh misses, and of edges that it cuts
    pub warnings: Vec<String>,
    /// Volumes of the surfaces and CAD that were meshed
    pub volumes: Vec<SourceVolume>,
    /// Of a body with `[mesh.deform]`: what it was before
    pub undeformed: Option<Arc<Undeformed>>,
    /// Balls of the scenes so far
    pub patches: Patches,
}

impl Body {
    /// Reads, finds or makes the mesh of a scene. `file` is the scene file, for messages and relative paths; `progress`
    /// gets the lines of the mesher.
    ///
    /// # Errors
    ///
    /// Where a file cannot be read, the mesher fails, or the mesh is not sound: file, place, fact and remedy.
    pub fn load(file: &Path, spec: &MeshSpec, progress: &mut dyn FnMut(&str)) -> Result<Self, SceneError> {
        Self::load_from(file, spec, None, progress)
    }

    /// The same with the bodies and the cache of a mesh store; without one it is looked for when it is needed
    /// ([`MeshStore::find`]).
    ///
    /// # Errors
    ///
    /// Those of [`Body::load`].
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

    /// Deforms the body, which keeps what it was.
    fn deform(&mut self, file: &Path, formulas: &DeformSpec) -> Result<(), SceneError> {
        self.undeformed = Some(Arc::new(deform(file, formulas, &mut self.mesh, &mut self.paths)?));
        self.sha256 = mesh_hash(&self.mesh);
        Ok(())
    }

    /// The body of another mesh table with the same connectivity, without a mesher: a grid or a volume mesh, or this body deformed from where it was.
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
            mesh: TetMesh { points, ..self.mesh.clone() },
            paths,
            source: self.source.clone(),
            sha256: String::new(),
            notes: self.notes.clone(),
            warnings: self.warnings.clone(),
            // Those of the shape before, as of a body that is deformed where it is loaded
            volumes: self.volumes.clone(),
            undeformed: None,
            patches: Patches::default(),
        };
        anew.deform(file, formulas)?;
        Ok(anew)
    }

    /// A mesh that is given directly.
    pub fn of_mesh(mesh: TetMesh) -> Self {
        let sha256 = mesh_hash(&mesh);
        let (paths, source) = (BTreeMap::new(), "mesh".into());
        Self {
            mesh,
            paths,
            source,
            sha256,
            notes: vec![],
            warnings: vec![],
            volumes: vec![],
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
            let mesh = grid(file, boxes, spec.element)?;
            let sha256 = mesh_hash(&mesh);
            return Ok(Self {
                mesh,
                paths: BTreeMap::new(),
                source: "grid".into(),
                sha256,
                notes: vec![],
                warnings: vec![],
                volumes: vec![],
                undeformed: None,
                patches: Patches::default(),
            });
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
            let mut body = Self::new(file, mesh, BTreeMap::new(), (&path, format.reader))?;
            body.notes = taken_over(&changes);
            body.warnings.extend(doubtful_unit(&body.mesh, format.reader, how.unit_m));
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

    /// The mesh of the same table with so many cells, whose edge lengths are proportional to a size field, in place of its size.
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

    /// A mesh of the mesher, with what is to be said of it.
    fn generated(file: &Path, made: Generated, levels: u32) -> Result<Self, SceneError> {
        let (volumes, off) = (SourceVolume::all(&made.manifest, &made.mesh), straightened(levels, &made.manifest));
        let mut body = Self::new(file, made.mesh, made.manifest.paths, (&made.path, Reader::Msh))?;
        body.warnings.extend(off);
        body.notes = made.manifest.dropped;
        body.warnings.extend(volumes.iter().filter_map(SourceVolume::warning));
        body.warnings.extend(made.manifest.edge_error_m.and_then(|off| cut_edges(&body.mesh, off)));
        body.volumes = volumes;
        Ok(body)
    }

    fn new(
        file: &Path,
        mesh: TetMesh,
        paths: BTreeMap<String, CablePath>,
        (source, reader): (&Path, Reader),
    ) -> Result<Self, SceneError> {
        let sha256 = digest("", source, reader.shape().1).map_err(|e| part(file, "mesh", e))?;
        let source = source.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        Ok(Self {
            mesh,
            paths,
            source,
            sha256,
            notes: vec![],
            warnings: vec![],
            volumes: vec![],
            undeformed: None,
            patches: Patches::default(),
        })
    }
}

/// Bodies across which lengths lose their meaning \[m\].
const ACROSS: std::ops::RangeInclusive<f64> = 1e-12..=1e12;
/// A cell needs edges above this share of its distance from the origin: a coordinate has sixteen digits, and strains need some of them.
const RESOLVED: f64 = 1e-11;

/// Refuses a mesh whose coordinates cannot tell its nodes apart: of a size or at a distance that is a slip of an exponent.
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

/// Whether the table has a source of its own.
pub(super) fn has_source(spec: &MeshSpec) -> bool {
    spec.grid.is_some() || spec.body.is_some() || spec.file.is_some()
}

/// Keys that the source of the mesh leaves without effect are refused: nothing is ignored silently.
fn check_source(file: &Path, spec: &MeshSpec) -> Result<(), SceneError> {
    check_refine(file, spec)?;
    let idle = |keys: &[(&str, bool)]| keys.iter().find(|(_, given)| *given).map(|(key, _)| key.to_string());
    if spec.grid.is_some() {
        let others = [
            ("body", spec.body.is_some()),
            ("file", spec.file.is_some()),
            ("unit", spec.unit.is_some()),
            ("cells", spec.cells.is_some()),
            ("size", spec.size.is_some()),
            ("parameters", !spec.parameters.is_empty()),
        ];
        return match idle(&others).or(idle(&made(spec))).or(idle(&taken(spec))) {
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

/// Refuses a refinement without a tolerance, and of what the mesher cannot make by a size field.
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
        (!spec.parts.is_empty(), "several bodies are not refined; refine the mesh of one"),
        (spec.disturb.is_some(), "a disturbed mesh is not refined; remove `disturb`"),
        (spec.deform.is_some(), "a deformed mesh is not refined; remove `deform`"),
        (spec.grid.is_some(), "a grid is not refined; take `body`, or `file` with CAD or a surface"),
        (volume_mesh(file, spec)?.is_some(), "a volume mesh is taken as it is; give `file` with CAD or a surface"),
    ];
    match reasons.iter().find(|(fault, _)| *fault) {
        Some((_, remedy)) => Err(content(file, "`refine` cannot be followed", remedy)),
        None => Ok(()),
    }
}

/// Keys of meshes that a mesher makes, and whether they are given.
fn made(spec: &MeshSpec) -> [(&'static str, bool); 6] {
    [
        ("levels", spec.levels > 0),
        ("grading", !spec.grading.is_empty()),
        ("seed", spec.seed > 0),
        ("cgal", !spec.cgal.is_empty()),
        ("generator", spec.generator != GeneratorSpec::default()),
        ("time_limit", spec.time_limit.is_some()),
    ]
}

/// Keys of volume meshes that are taken over, and whether they are given.
fn taken(spec: &MeshSpec) -> [(&'static str, bool); 2] {
    [("split", spec.split), ("merge", spec.merge.is_some())]
}

fn check_element(file: &Path, spec: &MeshSpec, mesh: &TetMesh) -> Result<(), SceneError> {
    let (wanted, found) = (spec.element.order(), mesh.order);
    if wanted == found {
        return Ok(());
    }
    let name = |o| if o == Order::Linear { "tet4" } else { "tet10" };
    let fact = format!("element = \"{}\", but the file holds {} cells", name(wanted), name(found));
    let remedy = format!("write element = \"{}\", or give a file with {} cells", name(found), name(wanted));
    Err(content(file, fact, &remedy))
}

fn given_or_found(store: Option<&MeshStore>) -> Result<MeshStore, GenerateError> {
    store.map_or_else(MeshStore::find, |store| Ok(store.clone()))
}

/// The request to the mesher that a `[mesh]` table describes.
///
/// # Errors
///
/// Where the table names no body or file, or sizes that no mesh can have.
pub fn request(file: &Path, spec: &MeshSpec) -> Result<MeshRequest, SceneError> {
    request_from(file, spec, None)
}

/// The warning of a mesh whose curved edges left the CAD. Meshes of earlier versions, whose distance is not known, are warned of where they are nested.
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
    if spec.levels > MOST_LEVELS {
        let fact = format!("levels = {}", spec.levels);
        return Err(content(file, fact, &format!("each makes eight cells of one: take at most {MOST_LEVELS}")));
    }
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

/// An entry of `grading`, by exactly one kind of place.
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
    let declared = Declared::load(&store.home.path, name).map_err(|e| part(file, "mesh.body", e))?;
    let value = |(key, text): (&String, &String)| Ok((key.clone(), declared.parse(key, text).map_err(fail)?));
    spec.parameters.iter().map(value).collect()
}

impl ElementSpec {
    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet4 => "tet4",
            Self::Tet10 => "tet10",
        }
    }

    pub fn order(self) -> Order {
        match self {
            Self::Tet4 => Order::Linear,
            Self::Tet10 => Order::Quadratic,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges that left the CAD are a warning; where an earlier version made the mesh, on nested levels alone.
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
