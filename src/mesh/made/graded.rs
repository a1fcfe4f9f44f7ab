//! Quarters of bodies whose cells grow away from one point of the surface, for contact and other concentrated loads.
//!
//! The cubes max(s, t, w) = k/n of a block of n³ boxes are mapped to spheres about the point, of radius ρ = `fine` k for k ≤ `inner`, then growing by
//! a constant ratio up to `radius` at k = n = inner + outer. The faces of Kuhn cells lie in the planes s = t, t = w, w = s, where this map has kinks.
//!
//! The sphere is obtained by inversion of the half-space: y ↦ N + 4R² (y − N)/|y − N|² with N = 2R e_z maps z ≤ 0 to the ball of radius R about R
//! e_z, and the half ball of radius 2R to its lower half. The map is conformal: cells keep their shape. Limits: the outer layers are n boxes wide and
//! only a few deep, for fields that decay.

use super::curved::mapped_block;
use crate::math::tensor::Vec3;
use crate::mesh::{Order, Region, TetMesh};

/// Growth of the cells: edges of `fine` \[m\] in the inner layers, then growing in the outer ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    pub fine: f64,
    pub inner: usize,
    pub outer: usize,
}

impl Growth {
    /// Returns ρ at a fraction of the layers \[m\].
    fn radius(&self, share: f64, last: f64) -> f64 {
        let (k, inner) = (share * (self.inner + self.outer) as f64, self.inner as f64);
        let near = self.fine * k.min(inner);
        near * (last / (self.fine * inner)).powf((k - inner).max(0.0) / self.outer as f64)
    }
}

/// Builds a quarter, x ≥ 0 and y ≥ 0, of the half ball z ≤ 0 of the given radius \[m\], fine at the origin. Regions `top`, `far`, `xmin`, `ymin`.
pub fn half_space(radius: f64, growth: Growth, order: Order) -> TetMesh {
    quarter(growth, order, ["top", "far"], |p, share| p * growth.radius(share, radius))
}

/// Builds a quarter, x ≥ 0 and y ≥ 0, of the lower half of a sphere of the given radius that rests on the origin \[m\], fine there. Regions `round`,
/// `middle`, `xmin`, `ymin`.
pub fn half_sphere(radius: f64, growth: Growth, order: Order) -> TetMesh {
    let pole = Vec3::new(0.0, 0.0, 2.0 * radius);
    let inverse = |y: Vec3| pole + (y - pole) * (4.0 * radius * radius / (y - pole).norm_squared());
    let flat = |p: Vec3, share: f64| p * growth.radius(share, 2.0 * radius);
    // The inversion reverses the orientation of cells, and so does the exchange of two axes.
    quarter(growth, order, ["round", "middle"], |p, share| inverse(flat(Vec3::new(p.y, p.x, p.z), share)))
}

/// Builds a block under a map of (direction, fraction of the layers), with the names of its side w = 0 and of the sides opposite the point.
fn quarter(growth: Growth, order: Order, names: [&str; 2], map: impl Fn(Vec3, f64) -> Vec3) -> TetMesh {
    let n = growth.inner + growth.outer;
    let mut mesh = mapped_block([n; 3], order, |p| {
        let down = Vec3::new(p.y, p.x, -p.z);
        map(down.try_normalize(0.0).unwrap_or(Vec3::zeros()), p.amax())
    });
    let mut take = |name: &str| mesh.regions.remove(name).expect("a block has it").facets;
    let (flat, mut far) = (take("zmin"), [take("xmax"), take("ymax"), take("zmax")].concat());
    far.sort_unstable();
    for (name, facets) in names.into_iter().zip([flat, far]) {
        mesh.regions.insert(name.into(), Region { facets, ..Region::default() });
    }
    // The sides of the block, found by their present position
    for (name, axis) in [("xmin", 0), ("ymin", 1)] {
        let on = |f: &u32| mesh.facet(*f as usize).iter().all(|&k| mesh.points[k as usize][axis] == 0.0);
        let facets = (0..mesh.facet_count() as u32).filter(on).collect();
        mesh.regions.insert(name.into(), Region { facets, ..Region::default() });
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::smaller;
    use crate::mesh::file::validate::min_det;
    use std::f64::consts::PI;

    /// Volumes and areas of the pieces: with curved tet10 facets the error is of the fourth power of an angle of π/8 per cell; no cell is folded.
    #[test]
    fn quarters_have_the_volume_and_the_sides_of_their_bodies() {
        let growth = Growth { fine: 0.05, inner: 4, outer: 4 };
        let cases = [
            (
                half_space(3.0, growth, Order::Quadratic),
                [("top", 9.0 * PI / 4.0), ("far", 9.0 * PI / 2.0)],
                9.0 * PI / 2.0,
                3.0,
            ),
            (
                half_sphere(3.0, growth, Order::Quadratic),
                [("round", 9.0 * PI / 2.0), ("middle", 9.0 * PI / 4.0)],
                9.0 * PI / 2.0,
                3.0,
            ),
        ];
        for (mesh, areas, volume, radius) in cases {
            assert!((0..mesh.cell_count()).all(|c| min_det(&mesh, c) > 0.0));
            assert!((mesh.volume() / volume - 1.0).abs() < 1e-2, "{} {volume}", mesh.volume());
            for (name, area) in areas {
                let found = mesh.region_area(&mesh.regions[name].facets);
                assert!((found / area - 1.0).abs() < 1e-2, "{name}: {found} {area}");
            }
            for name in ["xmin", "ymin"] {
                let (found, area) = (mesh.region_area(&mesh.regions[name].facets), PI * radius * radius / 4.0);
                assert!((found / area - 1.0).abs() < 1e-2, "{name}: {found} {area}");
            }
            let nearest = mesh.points.iter().map(|p| p.norm()).filter(|d| *d > 0.0).fold(f64::INFINITY, smaller);
            // Half of an edge to the mid-node; the inversion changes lengths by at most 2R/|y − N|.
            assert!((nearest / 0.025 - 1.0).abs() < 0.02, "{nearest}");
        }
    }
}
