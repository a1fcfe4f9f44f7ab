//! `[mesh]` of a scene.

use super::kind::by_kind;
use super::parts::selectors::SelectorSpec;
use super::quantity::{Angle, Length, Quantity, Time};
use super::shape::TurnSpec;
use crate::math::units::{self, Dimension};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

by_kind!(GridSpec);

/// `body` with its sizing (a mesh made by our mesher), or `file` with its unit, or `grid`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    pub body: Option<String>,
    /// Dimensions of the body that differ from its defaults, by name
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Number of cells, met within 2 %, or within 10 % where the count jumps
    pub cells: Option<usize>,
    /// Edge length
    pub size: Option<Length>,
    /// Each cell into eight, this often
    #[serde(default)]
    pub levels: u32,
    #[serde(default)]
    pub grading: Vec<GradingSpec>,
    /// The first of several meshes, refined until one quantity is accurate
    pub refine: Option<RefineSpec>,
    #[serde(default)]
    pub generator: GeneratorSpec,
    /// Another mesh of the same size (gmsh)
    #[serde(default)]
    pub seed: u64,
    /// CGAL's criteria by its names
    #[serde(default)]
    pub cgal: BTreeMap<String, toml::Value>,
    /// After which the mesher is ended
    pub time_limit: Option<Time>,
    pub file: Option<PathBuf>,
    /// Unit of length of the file
    pub unit: Option<String>,
    /// Hexahedra, wedges and pyramids of the file become tetrahedra
    #[serde(default)]
    pub split: bool,
    /// Nodes of the file within this distance become one
    pub merge: Option<Length>,
    /// Boxes cut into tetrahedra, made without a mesher
    pub grid: Option<GridSpec>,
    #[serde(default)]
    pub element: ElementSpec,
    /// The bodies of the scene, if it has several
    #[serde(rename = "part", default)]
    pub parts: Vec<PartSpec>,
    /// Made worse on purpose
    pub disturb: Option<DisturbSpec>,
    /// Nodes moved by formulas
    pub deform: Option<DeformSpec>,
    /// Regions by place, by connection, or made of others
    #[serde(default)]
    pub regions: BTreeMap<String, SelectorSpec>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradingSpec {
    /// Named feature of the body: `notches`, `guides`, `tip`
    pub feature: Option<String>,
    pub points: Option<Vec<[Length; 3]>>,
    #[serde(rename = "box")]
    pub corners: Option<CornersSpec>,
    pub length: Length,
    pub distance: Length,
}

/// A box along the axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CornersSpec {
    pub min: [Length; 3],
    pub max: [Length; 3],
}

/// The accuracy that an adaptive mesh is to have.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RefineSpec {
    /// Recorded column, `cable_tension_N`
    pub quantity: String,
    /// Largest error bar as a share of the value, `"1 %"`
    #[serde(default, deserialize_with = "share")]
    pub tolerance: Option<f64>,
    /// Largest error bar in the unit of the column, for a quantity near zero
    pub absolute_tolerance: Option<f64>,
    /// Most meshes, the first one included
    #[serde(default = "most_meshes")]
    pub meshes: usize,
}

fn most_meshes() -> usize {
    8
}

/// A fraction or a percentage.
fn share<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let value = toml::Value::deserialize(deserializer)?;
    let text = value.as_str().map_or_else(|| value.to_string(), str::to_string);
    units::parse(&text, Dimension::NONE).map(Some).map_err(serde::de::Error::custom)
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Default)]
#[serde(rename_all = "lowercase")]
pub enum GeneratorSpec {
    #[default]
    Gmsh,
    Cgal,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Default)]
#[serde(rename_all = "lowercase")]
pub enum ElementSpec {
    #[default]
    Tet4,
    Tet10,
}

/// A body of boxes that are cut into six tetrahedra each; its regions have fixed names.
#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields, rename_all = "snake_case")]
pub enum GridSpec {
    /// \[0, size\]: `xmin`, `xmax`, …, `zmax`
    Box { size: [Length; 3], divisions: [usize; 3] },
    /// A quadrilateral of this thickness in z, corners counter-clockwise in the plane; regions as of a box
    Plate { corners: [[Length; 2]; 4], thickness: Length, divisions: [usize; 3] },
    /// An octant of a hollow sphere: `inner`, `outer`, `xmin`, `ymin`, `zmin`; divisions of an edge and of the wall
    Octant { inner: Length, outer: Length, divisions: [usize; 2] },
    /// Along z: `zmin`, `zmax`, `side`; divisions of the radius and of the length
    Cylinder { radius: Length, length: Length, divisions: [usize; 2] },
    /// A round bar whose centre line is an arc, from z at the origin towards x: `start`, `end`, `side`; divisions of the radius and of the arc
    Bow { radius: Length, bend: Length, angle: Angle, divisions: [usize; 2] },
    /// A quarter of a square plate of this half edge with a hole: `hole`, `xmin`, `ymin` (planes of symmetry), `xmax`, `ymax`, `zmin`, `zmax`;
    /// divisions of the radius, round the quarter, of the thickness
    Hole { radius: Length, half_edge: Length, thickness: Length, divisions: [usize; 3] },
    /// A square plate without a quadrant: `xmin`, `xmax`, …, `zmax`; divisions across an arm, of the thickness
    Bracket { edge: Length, thickness: Length, divisions: [usize; 2] },
    /// A tube about the z-axis: `inner`, `outer`, `zmin`, `zmax`; divisions of the wall, round it, along it
    Tube { inner: Length, outer: Length, length: Length, divisions: [usize; 3] },
    /// A quarter of a half ball below z = 0: `top`, `far`, `xmin`, `ymin`; cells of `fine` at the origin in so many layers, then
    /// growing in so many
    HalfSpace { radius: Length, fine: Length, divisions: [usize; 2] },
    /// A quarter of the lower half of a sphere that rests on the origin: `round`, `middle`, `xmin`, `ymin`
    HalfSphere { radius: Length, fine: Length, divisions: [usize; 2] },
}

/// One body of several: from its own source or the mesh of `[mesh]`, mirrored, then turned, then shifted.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartSpec {
    /// Its regions are `name.region`
    pub name: String,
    /// Source and size as in `[mesh]`
    pub body: Option<String>,
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    pub cells: Option<usize>,
    pub size: Option<Length>,
    #[serde(default)]
    pub levels: u32,
    pub file: Option<PathBuf>,
    pub unit: Option<String>,
    #[serde(default)]
    pub split: bool,
    pub merge: Option<Length>,
    pub grid: Option<GridSpec>,
    /// Normal of the plane of the mirror, through the origin
    pub mirror: Option<[f64; 3]>,
    /// About the origin
    pub turn: Option<TurnSpec>,
    pub shift: Option<[Length; 3]>,
}

impl PartSpec {
    /// The table `[mesh]` of this body alone; the element is that of the whole mesh.
    pub(super) fn mesh(&self, whole: &MeshSpec) -> MeshSpec {
        MeshSpec {
            body: self.body.clone(),
            parameters: self.parameters.clone(),
            cells: self.cells,
            size: self.size,
            levels: self.levels,
            file: self.file.clone(),
            unit: self.unit.clone(),
            split: self.split,
            merge: self.merge,
            grid: self.grid.clone(),
            element: whole.element,
            ..MeshSpec::default()
        }
    }
}

/// Places of the nodes \[m\] as formulas of those that the mesh has, `X`, `Y`, `Z` \[m\], and of parameters.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeformSpec {
    /// Formula of x; a component without a formula stays
    pub x: Option<String>,
    pub y: Option<String>,
    pub z: Option<String>,
    /// Numbers by the names that the formulas take, with their unit
    #[serde(default)]
    pub parameters: BTreeMap<String, Quantity>,
}

/// How a mesh is made worse, for robustness studies.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisturbSpec {
    /// Inner nodes move by up to this share of h in each direction
    #[serde(default)]
    pub nodes: f64,
    /// Share of the cells into which a sliver is put
    #[serde(default)]
    pub slivers: f64,
    /// Smallest dihedral angle of the slivers
    pub angle: Option<Angle>,
    #[serde(default)]
    pub seed: u64,
}
