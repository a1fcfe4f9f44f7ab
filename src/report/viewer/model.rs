//! Content of a page: one case with its motion, fields and curves.

use super::modes::Modes;
use super::shape::Shape;

/// A scalar, vector (3) or symmetric tensor (6: xx, yy, zz, xy, yz, xz) at the nodes or in the cells.
#[derive(Clone, Debug)]
pub struct Field {
    /// Displayed name: `stretch`, `stress`
    pub name: String,
    /// Unit of its values; empty for ratios
    pub unit: String,
    pub at_nodes: bool,
    pub modes: Modes,
}

/// Vectors at some points, state by state.
#[derive(Clone, Debug)]
pub struct Arrows {
    pub name: String,
    pub unit: String,
    /// Points of the shape with their vectors \[states\]; vectors below a thousandth of the largest are left out
    pub states: Vec<Vec<(u32, [f32; 3])>>,
}

/// Recorded columns over time; the first is the time \[s\].
#[derive(Clone, Debug, Default)]
pub struct Curves {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<f64>>,
}

/// One case of a page.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub title: String,
    /// Name and value of the facts that a reader wants first
    pub facts: Vec<(String, String)>,
    /// Limits of what is shown
    pub notes: Vec<String>,
    pub shape: Shape,
    /// Times of the states \[s\]
    pub times: Vec<f64>,
    /// Displacement of the points \[m\]
    pub motion: Modes,
    pub fields: Vec<Field>,
    pub arrows: Vec<Arrows>,
    pub curves: Curves,
    /// Fields that are missing, and how to get them
    pub absent: Vec<(String, String)>,
    /// Reason why there is only one state, shown in place of the slider; empty if nobody would expect more
    pub still: String,
}
