//! Axis-aligned boxes, hierarchies of them, and conversions to and from parry3d.

use super::tensor::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

/// An axis-aligned box, (lowest, highest) corner.
pub type Span = (Vec3, Vec3);

/// Converts a vector to parry3d.
pub fn to_parry(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// Converts a vector from parry3d.
pub fn from_parry(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

/// Returns a box that is larger by `margin` on every side.
pub fn widened((low, high): Span, margin: f64) -> Span {
    (low.add_scalar(-margin), high.add_scalar(margin))
}

/// Converts a box to parry3d.
pub fn aabb((low, high): Span) -> Aabb {
    Aabb::new(to_parry(&low), to_parry(&high))
}

/// Builds a bounding volume hierarchy of boxes.
pub fn hierarchy(boxes: impl Iterator<Item = Span>) -> Bvh {
    let boxes: Vec<Aabb> = boxes.map(aabb).collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes)
}

/// Returns the indices of the boxes of a hierarchy that intersect a box, in ascending order.
pub fn overlapping(tree: &Bvh, span: Span) -> Vec<u32> {
    let mut found: Vec<u32> = tree.intersect_aabb(&aabb(span)).collect();
    found.sort_unstable();
    found
}
