//! Regions by position instead of by name. Their content depends on the mesh, and they are marked accordingly.

use super::boundary::{boundary_facets, facet_cells};
use super::error::{MeshError, point};
use super::{Region, TetMesh};
use crate::math::tensor::Vec3;

/// Picks nodes, facets or cells by position. Lengths in metres, angles in radians.
#[derive(Clone, PartialEq, Debug)]
pub enum Selector {
    /// Inside an axis-parallel box, its sides included
    Box { min: Vec3, max: Vec3 },
    /// Inside a ball
    Sphere { center: Vec3, radius: f64 },
    /// Within `tolerance` of a plane
    Plane { point: Vec3, normal: Vec3, tolerance: f64 },
    /// Boundary facets whose outward normal is within `angle` of `direction`
    Normal { direction: Vec3, angle: f64 },
}

/// Entities picked by a selector. A facet or cell is picked when all its corners are.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Pick {
    Nodes,
    Facets,
    Cells,
}

impl Selector {
    /// The region of all `pick` that the selector holds; `depends_on_mesh` is set. Empty is an error.
    pub fn select(&self, mesh: &TetMesh, pick: Pick) -> Result<Region, MeshError> {
        let mut region = Region { depends_on_mesh: true, ..Region::default() };
        // A relative margin against rounding: a node on the side of a box is inside.
        let margin = 1e-9 * mesh.diagonal();
        if let Self::Normal { direction, angle } = self {
            let facets = self.facing(mesh, direction, *angle);
            match pick {
                Pick::Facets => region.facets = facets,
                Pick::Nodes => region.nodes = mesh.nodes_of(&Region { facets, ..Region::default() }),
                Pick::Cells => {
                    let cells = facet_cells(mesh);
                    region.cells = facets.iter().map(|&f| cells[f as usize].0).collect();
                    region.cells.sort_unstable();
                    region.cells.dedup();
                }
            }
        } else {
            let held = |i: &u32| self.holds(&mesh.points[*i as usize], margin);
            match pick {
                Pick::Nodes => region.nodes = (0..mesh.points.len() as u32).filter(held).collect(),
                Pick::Facets => {
                    let all = |f: &u32| mesh.facet(*f as usize)[..3].iter().all(held);
                    region.facets = boundary_facets(mesh).into_iter().filter(all).collect();
                }
                Pick::Cells => {
                    let all = |c: &u32| mesh.cell(*c as usize)[..4].iter().all(held);
                    region.cells = (0..mesh.cell_count() as u32).filter(all).collect();
                }
            }
        }
        if region.nodes.is_empty() && region.facets.is_empty() && region.cells.is_empty() {
            let (low, high) = mesh.bounding_box();
            return Err(MeshError::EmptySelection { selector: self.describe(), low, high });
        }
        Ok(region)
    }

    fn holds(&self, x: &Vec3, margin: f64) -> bool {
        match self {
            Self::Box { min, max } => (0..3).all(|d| x[d] >= min[d] - margin && x[d] <= max[d] + margin),
            Self::Sphere { center, radius } => (x - center).norm() <= radius + margin,
            Self::Plane { point, normal, tolerance } => {
                (x - point).dot(&normal.normalize()).abs() <= tolerance + margin
            }
            Self::Normal { .. } => unreachable!("a normal selects facets"),
        }
    }

    fn facing(&self, mesh: &TetMesh, direction: &Vec3, angle: f64) -> Vec<u32> {
        let least = angle.cos() - 1e-12;
        let facing =
            |f: &u32| mesh.facet_normal(*f as usize, [1.0 / 3.0; 2]).normalize().dot(&direction.normalize()) >= least;
        boundary_facets(mesh).into_iter().filter(facing).collect()
    }

    fn describe(&self) -> String {
        match self {
            Self::Box { min, max } => format!("the box {} to {}", point(min), point(max)),
            Self::Sphere { center, radius } => format!("the sphere of radius {} mm at {}", radius * 1e3, point(center)),
            Self::Plane { point: at, tolerance, .. } => {
                format!("the plane through {} with tolerance {} mm", point(at), tolerance * 1e3)
            }
            Self::Normal { direction: d, angle } => {
                format!("the normal [{}, {}, {}] within {} deg", d.x, d.y, d.z, angle.to_degrees())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Order, structured::block};

    #[test]
    fn selectors_find_the_faces_of_a_block() {
        let mesh = block(4, 2, 2, 0.4, 0.2, 0.2, Order::Quadratic);
        let xmin = mesh.regions["xmin"].clone();
        let selectors = [
            Selector::Box { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(0.0, 0.2, 0.2) },
            Selector::Plane { point: Vec3::zeros(), normal: Vec3::new(2.0, 0.0, 0.0), tolerance: 0.0 },
            Selector::Normal { direction: Vec3::new(-3.0, 0.0, 0.0), angle: 0.1 },
        ];
        for selector in selectors {
            let facets = selector.select(&mesh, Pick::Facets).expect("the face x = 0");
            assert_eq!(facets.facets, xmin.facets, "{selector:?}");
            assert!(facets.depends_on_mesh);
            let nodes = selector.select(&mesh, Pick::Nodes).expect("the face x = 0");
            assert_eq!(nodes.nodes, mesh.nodes_of(&xmin), "{selector:?}");
        }
        let ball = Selector::Sphere { center: Vec3::zeros(), radius: 0.1 };
        assert_eq!(ball.select(&mesh, Pick::Nodes).expect("the corner").nodes.len(), 1 + 7 + 3);
        let error = Selector::Sphere { center: Vec3::new(1.0, 0.0, 0.0), radius: 0.1 }.select(&mesh, Pick::Nodes);
        assert_eq!(
            error.expect_err("nothing there").to_string(),
            "the sphere of radius 100 mm at (1000, 0, 0) mm selects nothing; the mesh fills (0, 0, 0) mm to (400, 200, 200) mm"
        );
    }
}
