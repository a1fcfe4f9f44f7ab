//! Boxes along the axes, hierarchies of them, and vectors as parry3d has them.

use super::tensor::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

/// A box \[least, most\].
pub type Span = (Vec3, Vec3);

/// A vector for parry3d.
pub fn to_parry(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// A vector of parry3d.
pub fn from_parry(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

/// A box that is wider by `margin` on every side.
pub fn widened((low, high): Span, margin: f64) -> Span {
    (low.add_scalar(-margin), high.add_scalar(margin))
}

/// A box for parry3d.
pub fn aabb((low, high): Span) -> Aabb {
    Aabb::new(to_parry(&low), to_parry(&high))
}

/// A hierarchy of boxes.
pub fn hierarchy(boxes: impl Iterator<Item = Span>) -> Bvh {
    let boxes: Vec<Aabb> = boxes.map(aabb).collect();
    Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes)
}

/// The boxes of a hierarchy that share a place with a box, in ascending order.
pub fn overlapping(tree: &Bvh, span: Span) -> Vec<u32> {
    let mut found: Vec<u32> = tree.intersect_aabb(&aabb(span)).collect();
    found.sort_unstable();
    found
}
