//! The manifest that the mesher writes for a mesh. Lengths are in metres.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The manifest stored next to every generated mesh.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// Request as the mesher read it
    pub request: serde_json::Value,
    pub cells: usize,
    pub nodes: usize,
    pub facets: usize,
    pub order: u8,
    /// (V/N)^{1/3} \[m\]
    pub h_m: f64,
    pub regions: BTreeMap<String, RegionCount>,
    /// `sicn_min`, `radius_ratio_min`, `dihedral_min_deg`, …
    #[serde(default)]
    pub quality: BTreeMap<String, Option<f64>>,
    pub volume_m3: f64,
    /// `None` if the input was already a mesh
    pub volume_cad_m3: Option<f64>,
    /// Mesh volume / CAD volume − 1
    pub volume_error: Option<f64>,
    /// Volumes in the CAD of those regions of cells that are only a part of it, and of the cavities of a surface \[m³\]
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub volumes_cad_m3: BTreeMap<String, f64>,
    /// Largest distance of the CAD's sharp edges from the mesh \[m\]
    #[serde(default)]
    pub edge_error_m: Option<f64>,
    /// Number of edges of curved cells, on the boundary and between solids, that deviate from the CAD because cells would be folded; `None` if the
    /// mesher does not record them
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub straightened_edges: Option<usize>,
    /// Largest distance of these edges from the CAD \[m\]; `None` in meshes of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub straightened_m: Option<f64>,
    /// Cables of the geometry by name: `cable`, …
    #[serde(default)]
    pub paths: BTreeMap<String, CablePath>,
    /// Repairs of a surface file, in sentences
    #[serde(default)]
    pub repairs: Vec<String>,
    /// Faces of the CAD that bound no solid, or have no facet, in sentences
    #[serde(default)]
    pub dropped: Vec<String>,
    /// Versions of the packages with which it was made
    #[serde(default)]
    pub versions: BTreeMap<String, Option<String>>,
    #[serde(default)]
    pub wall_s: Option<f64>,
    /// SHA-256 of the files from which the CAD of a body is made; `None` for a file, and for meshes of earlier versions, which are made again
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry_sha256: Option<String>,
    /// Other entries written by the mesher
    #[serde(flatten)]
    pub notes: BTreeMap<String, serde_json::Value>,
}

/// Dimension (2, 3) and number of elements of a region.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct RegionCount {
    pub dim: u8,
    pub count: usize,
}

/// A cable as part of the geometry \[m\]: guide points from the fixed end on, and the outer point from which it is pulled.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct CablePath {
    pub guides: Vec<[f64; 3]>,
    pub pull_point: [f64; 3],
    pub guide_radius: f64,
}
