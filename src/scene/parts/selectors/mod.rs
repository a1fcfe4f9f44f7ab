//! Selectors of a scene: regions by position, by connection and by operations on sets. Each kind has one file, and a line in each of the lists below.

mod axis_box;
mod component;
mod near;
mod normal;
mod part;
mod place;
mod plane;
mod sets;
mod sphere;

pub use axis_box::BoxSelector;
pub use component::{ComponentSelector, Which};
pub use near::NearSelector;
pub use normal::NormalSelector;
pub use part::PickSpec;
pub(in crate::scene) use part::{Ground, Refusal, region_of};
pub use place::RuleSpec;
pub use plane::PlaneSelector;
pub use sets::{ComplementSelector, DifferenceSelector, IntersectionSelector, UnionSelector};
pub use sphere::SphereSelector;

use crate::scene::text::kind::registry;
use part::SelectorPart;

registry! {
SelectorPart;
/// A region of a scene: the rule by which its nodes, facets or cells are found on the mesh.
pub enum SelectorSpec {
    Box(BoxSelector) = "box",
    Sphere(SphereSelector) = "sphere",
    Plane(PlaneSelector) = "plane",
    Normal(NormalSelector) = "normal",
    Near(NearSelector) = "near",
    Component(ComponentSelector) = "component",
    Union(UnionSelector) = "union",
    Intersection(IntersectionSelector) = "intersection",
    Difference(DifferenceSelector) = "difference",
    Complement(ComplementSelector) = "complement",
}
}
