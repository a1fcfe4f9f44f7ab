//! Planes at the ends of a body in which it is held along the normal, as in a model of one half.

use super::builder::Builder;
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Decimals;

/// Largest distance of points of a plane from it, relative to the size of the body \[–\]: files in single precision round by 6e-8.
const ROUNDING: f64 = 1e-6;

/// A plane x, y or z = const at an end of the body. The normal component of all of its nodes is held there.
pub(in crate::scene) struct HeldPlane {
    axis: usize,
    /// Coordinate of the plane \[m\]
    level: f64,
    /// Tolerance of the coordinate \[m\]
    slack: f64,
    /// Whether some node has no other component prescribed, as in a plane of symmetry
    pub(in crate::scene) slides: bool,
}

impl HeldPlane {
    /// All held planes of a body; to be called when everything that is held is known.
    pub(in crate::scene) fn all(builder: &Builder) -> Vec<Self> {
        let mesh = &builder.body.mesh;
        let (low, high) = mesh.bounding_box();
        let slack = ROUNDING * mesh.diagonal();
        let plane = |axis: usize, level: f64| {
            let is_on = |node: &u32| (mesh.points[*node as usize][axis] - level).abs() <= slack;
            let motion = |node: u32, d: usize| builder.motion(3 * node + d as u32);
            let nodes: Vec<u32> = (0..mesh.points.len() as u32).filter(is_on).collect();
            let is_held = nodes.iter().all(|&node| motion(node, axis) == Some(&Signal::Constant(0.0)));
            let is_free = |node: &u32| (0..3).all(|d| d == axis || motion(*node, d).is_none());
            is_held.then(|| Self { axis, level, slack, slides: nodes.iter().any(is_free) })
        };
        (0..3).flat_map(|axis| [low[axis], high[axis]].map(|level| plane(axis, level))).flatten().collect()
    }

    /// Whether all of these points lie in the plane.
    pub(in crate::scene) fn has(&self, places: &[Vec3]) -> bool {
        places.iter().all(|at| (at[self.axis] - self.level).abs() <= self.slack)
    }

    /// The equation of the plane, such as `y = 5.0000 mm`.
    pub(in crate::scene) fn words(&self) -> String {
        format!("{} = {:.4} mm", ["x", "y", "z"][self.axis], Decimals(1e3 * self.level))
    }
}

/// Adds a note about the parts of an effect that lie in planes of symmetry, where one half of the body has half of their `stiffness`; `parts`: the points of
/// each part, `which`: the word for the parts.
pub(in crate::scene) fn note_halved(
    builder: &mut Builder,
    name: &str,
    (parts, which): (&[Vec<Vec3>], &str),
    stiffness: &str,
) {
    let planes = HeldPlane::all(builder);
    for plane in planes.iter().filter(|plane| plane.slides) {
        let count = parts.iter().filter(|places| plane.has(places)).count();
        if count > 0 {
            builder.notes.push(format!(
                "{name}: {count} of {} {which} lie in the plane {}, in which one component is held: where this is a plane of symmetry, one half of the body has half \
                 of their {stiffness}; give these half of it, in an entry of their own",
                parts.len(),
                plane.words()
            ));
        }
    }
}
