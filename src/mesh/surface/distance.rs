//! Distances of points from a triangulated surface.

use crate::math::boxes::to_parry;
use crate::math::tensor::Vec3;
use crate::mesh::file::surface_file::Surface;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::TriMesh;

/// A surface in a bounding volume hierarchy, which finds the nearest triangle quickly.
pub struct Nearest(TriMesh);

/// The triangle of a surface that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    pub triangle: u32,
    /// \[m\]
    pub distance: f64,
}

impl Nearest {
    /// Builds the hierarchy; `None` for a surface without triangles.
    pub fn new(surface: &Surface) -> Option<Self> {
        let points = surface.points.iter().map(to_parry).collect();
        TriMesh::new(points, surface.triangles.clone()).ok().map(Self)
    }

    /// Returns the triangle nearest to a point, and its distance.
    pub fn of(&self, at: &Vec3) -> Near {
        let at = to_parry(at);
        let (on, (triangle, _)) = self.0.project_local_point_and_get_location(at, false);
        Near { triangle, distance: (on.point - at).length() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::nearest::to_triangle;
    use crate::math::statistics::smaller;

    /// Compares with the smallest distance to all triangles of a random surface.
    #[test]
    fn the_nearest_triangle_is_the_nearest_of_all() {
        let mut random = crate::math::random::SplitMix(7);
        let mut at = || Vec3::from_fn(|_, _| random.unit());
        let points: Vec<Vec3> = (0..300).map(|_| at()).collect();
        let triangles: Vec<[u32; 3]> = (0..100).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let tree = Nearest::new(&Surface { points: points.clone(), triangles: triangles.clone() }).expect("triangles");
        for _ in 0..200 {
            let p = at() * 2.0;
            let [off, least] =
                [tree.of(&p).triangle as usize..tree.of(&p).triangle as usize + 1, 0..100].map(|range| {
                    let away = |k: usize| to_triangle(&p, &triangles[k].map(|n| points[n as usize]));
                    range.map(away).fold(f64::INFINITY, smaller)
                });
            assert!((off - least).abs() < 1e-12 && (tree.of(&p).distance - least).abs() < 1e-12);
        }
    }
}
