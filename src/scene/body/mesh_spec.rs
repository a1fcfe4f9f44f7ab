//! `[mesh]` of a scene.

use crate::math::units::{self, Dimension};
use crate::mesh::Order;
use crate::scene::build::shape::TurnSpec;
use crate::scene::parts::selectors::SelectorSpec;
use crate::scene::text::quantity::{Angle, Length, Quantity, Time};
use crate::schema::{AnyTable, Share};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// `body` with its sizing (a mesh made by Durometer's mesher), or `file` with its unit, or `grid`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    /// Name of a parametric body, which the mesher meshes
    pub body: Option<String>,
    /// Dimensions of the body that differ from its defaults, by name
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Number of cells, reached within 2 %, or within 10 % where the number jumps with the size
    pub cells: Option<usize>,
    /// Edge length
    pub size: Option<Length>,
    /// How often each cell is split into eight, also the cells of a volume mesh
    #[serde(default)]
    pub levels: u32,
    /// Places where the cells are smaller
    #[serde(default)]
    pub grading: Vec<GradingSpec>,
    /// Makes the mesh the first of several, which are refined until one quantity is accurate
    pub refine: Option<RefineSpec>,
    /// Program that meshes a body
    #[serde(default)]
    pub generator: GeneratorSpec,
    /// Seed that yields a different mesh of the same size (gmsh)
    #[serde(default)]
    pub seed: u64,
    /// Criteria of CGAL, by CGAL's names
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub cgal: BTreeMap<String, toml::Value>,
    /// Time after which the mesher is stopped
    pub time_limit: Option<Time>,
    /// Mesh, surface or CAD file, relative to the scene
    pub file: Option<PathBuf>,
    /// Unit of length of the file
    pub unit: Option<String>,
    /// Cuts hexahedra, wedges and pyramids of the file into tetrahedra
    #[serde(default)]
    pub split: bool,
    /// Distance within which nodes of the file are merged
    pub merge: Option<Length>,
    /// Boxes cut into tetrahedra, made without a mesher
    pub grid: Option<GridSpec>,
    /// Element type of the tetrahedra
    #[serde(default)]
    pub element: ElementSpec,
    /// The bodies of the scene, if it has several
    #[serde(rename = "part", default)]
    pub parts: Vec<PartSpec>,
    /// Makes the mesh worse on purpose
    pub disturb: Option<DisturbSpec>,
    /// Moves the nodes by formulas
    pub deform: Option<DeformSpec>,
    /// Regions by position, by connection, or made of other regions
    #[serde(default)]
    pub regions: BTreeMap<String, SelectorSpec>,
}

/// A place around which the cells are smaller: a feature of the body, points, or a box
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GradingSpec {
    /// Named feature of the body: `notches`, `guides`, `tip`
    pub feature: Option<String>,
    /// Points around which the cells are smaller, each as three lengths
    pub points: Option<Vec<[Length; 3]>>,
    /// A box within which the cells are smaller
    #[serde(rename = "box")]
    pub corners: Option<CornersSpec>,
    /// Edge length there
    pub length: Length,
    /// Distance over which the edges grow to their usual length
    pub distance: Length,
}

/// A box along the axes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CornersSpec {
    /// Corner with the smallest coordinates
    pub min: [Length; 3],
    /// Corner with the largest coordinates
    pub max: [Length; 3],
}

/// The accuracy that adaptive meshing is to reach.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefineSpec {
    /// Recorded column, such as `cable_tension_N`
    pub quantity: String,
    /// Largest error bar relative to the largest departure from the start, such as `"1 %"`
    #[serde(default, deserialize_with = "share")]
    #[schemars(with = "Option<Share>")]
    pub tolerance: Option<f64>,
    /// Largest error bar in the unit of the column, for a quantity near zero
    pub absolute_tolerance: Option<f64>,
    /// Largest number of meshes, including the first one
    #[serde(default = "most_meshes")]
    pub meshes: usize,
}

fn most_meshes() -> usize {
    8
}

/// Deserializes a fraction or a percentage.
fn share<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let value = toml::Value::deserialize(deserializer)?;
    let text = value.as_str().map_or_else(|| value.to_string(), str::to_string);
    units::parse(&text, Dimension::NONE).map(Some).map_err(serde::de::Error::custom)
}

/// Program that makes meshes
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Default)]
#[serde(rename_all = "lowercase")]
pub enum GeneratorSpec {
    /// Gmsh: Delaunay's method within a given surface mesh
    #[default]
    Gmsh,
    /// CGAL: Delaunay refinement with criteria
    Cgal,
}

/// Tetrahedral element
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Default)]
#[serde(rename_all = "lowercase")]
pub enum ElementSpec {
    /// Linear, with four nodes
    #[default]
    Tet4,
    /// Quadratic, with ten nodes
    Tet10,
}

impl ElementSpec {
    /// Name as in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet4 => "tet4",
            Self::Tet10 => "tet10",
        }
    }

    /// The element with shape functions of this order.
    pub fn of(order: Order) -> Self {
        match order {
            Order::Linear => Self::Tet4,
            Order::Quadratic => Self::Tet10,
        }
    }

    /// Order of the shape functions.
    pub fn order(self) -> Order {
        match self {
            Self::Tet4 => Order::Linear,
            Self::Tet10 => Order::Quadratic,
        }
    }
}

/// A body made of boxes that are cut into six tetrahedra each; its regions have fixed names.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum GridSpec {
    /// The box from 0 to `size`: `xmin`, `xmax`, …, `zmax`
    Box {
        /// Lengths of the edges
        size: [Length; 3],
        /// Number of boxes along each axis
        divisions: [usize; 3],
    },
    /// A quadrilateral with a thickness in z; the corners in the plane are counter-clockwise; regions as for a box
    Plate {
        /// Corners in the plane, counter-clockwise
        corners: [[Length; 2]; 4],
        /// Thickness in z
        thickness: Length,
        /// Number of boxes along both sides and through the thickness
        divisions: [usize; 3],
    },
    /// An octant of a hollow sphere: `inner`, `outer`, `xmin`, `ymin`, `zmin`; divisions of an edge and through the wall
    Octant {
        /// Inner radius
        inner: Length,
        /// Outer radius
        outer: Length,
        /// Number of boxes along an edge and through the wall
        divisions: [usize; 2],
    },
    /// A cylinder along z: `zmin`, `zmax`, `side`; divisions of the radius and of the length
    Cylinder {
        /// Radius
        radius: Length,
        /// Length along z
        length: Length,
        /// Number of boxes along the radius and the length
        divisions: [usize; 2],
    },
    /// A round bar whose centre line is an arc that starts at the origin along z and bends towards x: `start`, `end`, `side`; divisions of the radius and of
    /// the arc
    Bow {
        /// Radius of the cross-section
        radius: Length,
        /// Radius of the centre line
        bend: Length,
        /// Angle of the arc
        angle: Angle,
        /// Number of boxes along the radius and the arc
        divisions: [usize; 2],
    },
    /// A quarter of a square plate with a hole: `hole`, `xmin`, `ymin` (planes of symmetry), `xmax`, `ymax`, `zmin`, `zmax`; divisions of the radius, around
    /// the quarter, and through the thickness
    Hole {
        /// Radius of the hole
        radius: Length,
        /// Half the edge length of the plate
        half_edge: Length,
        /// Thickness in z
        thickness: Length,
        /// Number of boxes along the radius, around the quarter and through the thickness
        divisions: [usize; 3],
    },
    /// A square plate with one quadrant missing: `xmin`, `xmax`, …, `zmax`; divisions across an arm and through the thickness
    Bracket {
        /// Edge length of the whole square
        edge: Length,
        /// Thickness in z
        thickness: Length,
        /// Number of boxes across an arm and through the thickness
        divisions: [usize; 2],
    },
    /// A tube about the z-axis: `inner`, `outer`, `zmin`, `zmax`; divisions through the wall, around it and along it
    Tube {
        /// Inner radius
        inner: Length,
        /// Outer radius
        outer: Length,
        /// Length along z
        length: Length,
        /// Number of boxes through the wall, around it and along it
        divisions: [usize; 3],
    },
    /// A quarter of a half ball below z = 0: `top`, `far`, `xmin`, `ymin`; layers of cells of size `fine` at the origin, then layers of growing cells
    HalfSpace {
        /// Radius of the half ball
        radius: Length,
        /// Edge length at the origin
        fine: Length,
        /// Number of layers of fine cells, and of growing cells
        divisions: [usize; 2],
    },
    /// A quarter of the lower half of a sphere that rests on the origin: `round`, `middle`, `xmin`, `ymin`
    HalfSphere {
        /// Radius of the sphere
        radius: Length,
        /// Edge length at the origin
        fine: Length,
        /// Number of layers of fine cells, and of growing cells
        divisions: [usize; 2],
    },
}

/// One body of several: from its own source or the mesh of `[mesh]`, first mirrored, then rotated, then shifted.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartSpec {
    /// Name of the part; its regions are called `name.region`
    pub name: String,
    /// Name of a parametric body, with its size as in `[mesh]`
    pub body: Option<String>,
    /// Dimensions of the body that differ from its defaults, by name, with their unit
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Number of cells
    pub cells: Option<usize>,
    /// Edge length
    pub size: Option<Length>,
    /// How often each cell is split into eight
    #[serde(default)]
    pub levels: u32,
    /// Mesh, surface or CAD file, relative to the scene
    pub file: Option<PathBuf>,
    /// Unit of length of the file
    pub unit: Option<String>,
    /// Cuts hexahedra, wedges and pyramids of the file into tetrahedra
    #[serde(default)]
    pub split: bool,
    /// Distance within which nodes of the file are merged
    pub merge: Option<Length>,
    /// Boxes cut into tetrahedra, made without a mesher
    pub grid: Option<GridSpec>,
    /// Normal of the mirror plane, which passes through the origin
    pub mirror: Option<[f64; 3]>,
    /// Rotation about the origin
    pub turn: Option<TurnSpec>,
    /// Displacement of the body after its rotation
    pub shift: Option<[Length; 3]>,
}

impl PartSpec {
    /// The table `[mesh]` of this body alone; the element is the one of the whole mesh.
    pub(in crate::scene) fn mesh(&self, whole: &MeshSpec) -> MeshSpec {
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

/// Positions of the nodes \[m\] as formulas in their original positions `X`, `Y`, `Z` \[m\] and in parameters.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeformSpec {
    /// Formula of x \[m\]; a component without a formula does not change
    pub x: Option<String>,
    /// Formula of y \[m\]
    pub y: Option<String>,
    /// Formula of z \[m\]
    pub z: Option<String>,
    /// Parameters of the formulas by name, with their unit
    #[serde(default)]
    pub parameters: BTreeMap<String, Quantity>,
}

/// How a mesh is made worse, for robustness studies.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DisturbSpec {
    /// Largest displacement of inner nodes in each direction, as a share of h
    #[serde(default)]
    pub nodes: f64,
    /// Share of the cells into which a sliver is inserted
    #[serde(default)]
    pub slivers: f64,
    /// Smallest dihedral angle of the slivers
    pub angle: Option<Angle>,
    /// Seed of the random numbers
    #[serde(default)]
    pub seed: u64,
}
