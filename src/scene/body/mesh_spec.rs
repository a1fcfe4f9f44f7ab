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

/// `body` with its sizing (a mesh made by our mesher), or `file` with its unit, or `grid`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    /// Name of a parametric body, which the mesher meshes
    pub body: Option<String>,
    /// Dimensions of the body that differ from its defaults, by name
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Number of cells, met within 2 %, or within 10 % where the count jumps
    pub cells: Option<usize>,
    /// Edge length
    pub size: Option<Length>,
    /// Each cell into eight, this often, also those of a volume mesh
    #[serde(default)]
    pub levels: u32,
    /// Places where the cells are smaller
    #[serde(default)]
    pub grading: Vec<GradingSpec>,
    /// The first of several meshes, refined until one quantity is accurate
    pub refine: Option<RefineSpec>,
    /// Program that makes the mesh of a body
    #[serde(default)]
    pub generator: GeneratorSpec,
    /// Another mesh of the same size (gmsh)
    #[serde(default)]
    pub seed: u64,
    /// CGAL's criteria by its names
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub cgal: BTreeMap<String, toml::Value>,
    /// After which the mesher is ended
    pub time_limit: Option<Time>,
    /// Mesh, surface or CAD file, relative to the scene
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
    /// Element that the tetrahedra become
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
    /// Edge length at the place
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

/// The accuracy that an adaptive mesh is to have.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefineSpec {
    /// Recorded column, `cable_tension_N`
    pub quantity: String,
    /// Largest error bar as a share of the largest departure from the start, `"1 %"`
    #[serde(default, deserialize_with = "share")]
    #[schemars(with = "Option<Share>")]
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

/// Program that makes meshes
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Default)]
#[serde(rename_all = "lowercase")]
pub enum GeneratorSpec {
    /// Gmsh, by Delaunay's method with the surface given
    #[default]
    Gmsh,
    /// CGAL, by refinement with criteria
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
    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet4 => "tet4",
            Self::Tet10 => "tet10",
        }
    }

    /// The element of this order.
    pub fn of(order: Order) -> Self {
        match order {
            Order::Linear => Self::Tet4,
            Order::Quadratic => Self::Tet10,
        }
    }

    /// Order of its shape functions.
    pub fn order(self) -> Order {
        match self {
            Self::Tet4 => Order::Linear,
            Self::Tet10 => Order::Quadratic,
        }
    }
}

/// A body of boxes that are cut into six tetrahedra each; its regions have fixed names.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum GridSpec {
    /// \[0, size\]: `xmin`, `xmax`, …, `zmax`
    Box {
        /// Lengths of its edges
        size: [Length; 3],
        /// Number of boxes along each axis
        divisions: [usize; 3],
    },
    /// A quadrilateral of this thickness in z, corners counter-clockwise in the plane; regions as of a box
    Plate {
        /// Corners in the plane, counter-clockwise
        corners: [[Length; 2]; 4],
        /// Thickness in z
        thickness: Length,
        /// Number of boxes along both sides and in the thickness
        divisions: [usize; 3],
    },
    /// An octant of a hollow sphere: `inner`, `outer`, `xmin`, `ymin`, `zmin`; divisions of an edge and of the wall
    Octant {
        /// Inner radius
        inner: Length,
        /// Outer radius
        outer: Length,
        /// Number of boxes along an edge and in the wall
        divisions: [usize; 2],
    },
    /// Along z: `zmin`, `zmax`, `side`; divisions of the radius and of the length
    Cylinder {
        /// Radius
        radius: Length,
        /// Length along z
        length: Length,
        /// Number of boxes along the radius and the length
        divisions: [usize; 2],
    },
    /// A round bar whose centre line is an arc, from z at the origin towards x: `start`, `end`, `side`; divisions of the radius and of the arc
    Bow {
        /// Radius of the section
        radius: Length,
        /// Radius of the centre line
        bend: Length,
        /// Angle of the arc
        angle: Angle,
        /// Number of boxes along the radius and the arc
        divisions: [usize; 2],
    },
    /// A quarter of a square plate of this half edge with a hole: `hole`, `xmin`, `ymin` (planes of symmetry), `xmax`, `ymax`, `zmin`, `zmax`;
    /// divisions of the radius, round the quarter, of the thickness
    Hole {
        /// Radius of the hole
        radius: Length,
        /// Half the edge of the plate
        half_edge: Length,
        /// Thickness in z
        thickness: Length,
        /// Number of boxes along the radius, round the quarter and in the thickness
        divisions: [usize; 3],
    },
    /// A square plate without a quadrant: `xmin`, `xmax`, …, `zmax`; divisions across an arm, of the thickness
    Bracket {
        /// Edge of the whole square
        edge: Length,
        /// Thickness in z
        thickness: Length,
        /// Number of boxes across an arm and in the thickness
        divisions: [usize; 2],
    },
    /// A tube about the z-axis: `inner`, `outer`, `zmin`, `zmax`; divisions of the wall, round it, along it
    Tube {
        /// Inner radius
        inner: Length,
        /// Outer radius
        outer: Length,
        /// Length along z
        length: Length,
        /// Number of boxes in the wall, round it and along it
        divisions: [usize; 3],
    },
    /// A quarter of a half ball below z = 0: `top`, `far`, `xmin`, `ymin`; cells of `fine` at the origin in so many layers, then
    /// growing in so many
    HalfSpace {
        /// Radius of the half ball
        radius: Length,
        /// Edge length at the origin
        fine: Length,
        /// Number of layers of fine cells, and of growing ones
        divisions: [usize; 2],
    },
    /// A quarter of the lower half of a sphere that rests on the origin: `round`, `middle`, `xmin`, `ymin`
    HalfSphere {
        /// Radius of the sphere
        radius: Length,
        /// Edge length at the origin
        fine: Length,
        /// Number of layers of fine cells, and of growing ones
        divisions: [usize; 2],
    },
}

/// One body of several: from its own source or the mesh of `[mesh]`, mirrored, then turned, then shifted.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartSpec {
    /// Its regions are `name.region`
    pub name: String,
    /// Source and size as in `[mesh]`
    pub body: Option<String>,
    /// Dimensions of the body that differ from its defaults, by name, with their unit
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Number of cells
    pub cells: Option<usize>,
    /// Edge length
    pub size: Option<Length>,
    /// How often each cell is cut into eight
    #[serde(default)]
    pub levels: u32,
    /// Mesh, surface or CAD file, relative to the scene
    pub file: Option<PathBuf>,
    /// Unit of length of the file
    pub unit: Option<String>,
    /// Cuts hexahedra, wedges and pyramids of the file into tetrahedra
    #[serde(default)]
    pub split: bool,
    /// Distance within which nodes of the file become one
    pub merge: Option<Length>,
    /// Boxes cut into tetrahedra, made without a mesher
    pub grid: Option<GridSpec>,
    /// Normal of the plane of the mirror, through the origin
    pub mirror: Option<[f64; 3]>,
    /// About the origin
    pub turn: Option<TurnSpec>,
    /// Displacement of the body, after its turn
    pub shift: Option<[Length; 3]>,
}

impl PartSpec {
    /// The table `[mesh]` of this body alone; the element is that of the whole mesh.
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

/// Places of the nodes \[m\] as formulas of those that the mesh has, `X`, `Y`, `Z` \[m\], and of parameters.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeformSpec {
    /// Formula of x; a component without a formula stays
    pub x: Option<String>,
    /// Formula of y \[m\]
    pub y: Option<String>,
    /// Formula of z \[m\]
    pub z: Option<String>,
    /// Numbers by the names that the formulas take, with their unit
    #[serde(default)]
    pub parameters: BTreeMap<String, Quantity>,
}

/// How a mesh is made worse, for robustness studies.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
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
    /// Seed of the random numbers
    #[serde(default)]
    pub seed: u64,
}
