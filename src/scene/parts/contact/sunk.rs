//! Facets that lie inside an obstacle between their contact points, at which alone contact acts.

use crate::effect::contact::Contact;
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::mesh::element::facet_shape;

/// Depth to which a facet may lie in an obstacle beyond the contact points, relative to the smallest width of the obstacle: the depth between three points of
/// a ball as wide as their distance is smaller.
const MOST: f64 = 0.125;
/// Accuracy of the deepest point, relative to that depth.
const RESOLVED: f64 = 0.125;
/// Largest number of times that a facet is halved: a facet on a thin obstacle is close to it everywhere, so that its distances do not limit the search. The
/// deepest point is then found to the size of a part.
const HALVINGS: usize = 6;

/// Facets that press on an obstacle, and the depth to which they may lie in it beyond the contact points.
pub(in crate::scene) struct PressingFacets {
    facets: Vec<u32>,
    /// Allowed depth beyond the contact points \[m\]
    most: f64,
}

/// A part of a facet, given by its corners in the coordinates ξ of the facet.
type Part = [[f64; 2]; 3];

impl PressingFacets {
    /// The facets, with the allowed depth. `cell` is the size of the cells \[m\]: a sharp edge of an obstacle enters a facet by about as much.
    pub(super) fn new(facets: Vec<u32>, cell: f64, contact: &Contact) -> Self {
        let widths = contact.obstacle.shape.bounds().map(|[low, high]| high - low);
        Self { facets, most: widths.map_or(cell, |widths| cell.min(MOST * widths.min())) }
    }

    /// No facets, for a rigid body, which has only points.
    pub(super) fn none() -> Self {
        Self { facets: vec![], most: 0.0 }
    }

    /// Depth to which a facet may lie in the obstacle beyond the contact points \[m\].
    pub(super) fn most(&self) -> f64 {
        self.most
    }

    /// Whether there are no facets, as for a rigid body.
    pub(super) fn is_none(&self) -> bool {
        self.facets.is_empty()
    }

    /// The position in space of the deepest point of the facets at displacement x, and its depth \[m\]; `None` if it is not too deep. A distance changes no
    /// faster than the position: parts of a facet that are too far from the obstacle for their size are not split, nor are those that have been halved
    /// [`HALVINGS`] times.
    pub(in crate::scene) fn deepest(&self, mesh: &TetMesh, contact: &Contact, x: &[f64]) -> Option<(Vec3, f64)> {
        let (_, seen) = contact.deepest(x).filter(|_| !self.is_none())?;
        self.search(mesh, x, seen, contact.distance(x))
    }

    /// Searches for the deepest point, given the `distance` of a point from the obstacle; `seen` is the distance of the deepest contact point \[m\].
    fn search(&self, mesh: &TetMesh, x: &[f64], seen: f64, distance: impl Fn(&Vec3) -> f64) -> Option<(Vec3, f64)> {
        let enough = RESOLVED * self.most;
        let (mut least, mut found) = (seen.min(0.0) - self.most, None);
        for &f in &self.facets {
            let nodes = mesh.facet(f as usize);
            let place = |xi: [f64; 2]| -> Vec3 {
                let shape = facet_shape(mesh.order, xi);
                let node = |k: u32| mesh.points[k as usize] + Vec3::from_column_slice(&x[3 * k as usize..][..3]);
                nodes.iter().zip(shape).map(|(&k, n)| node(k) * n).sum()
            };
            let mut open: Vec<(Part, usize)> = vec![([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0)];
            while let Some((part, halved)) = open.pop() {
                let middle = place([0, 1].map(|d| part.iter().map(|xi| xi[d]).sum::<f64>() / 3.0));
                let reach = part.iter().map(|&xi| (place(xi) - middle).norm()).fold(0.0, f64::max);
                let gap = if reach.is_finite() { distance(&middle) } else { f64::INFINITY };
                if gap < least {
                    (least, found) = (gap, Some((middle, -gap)));
                }
                if halved < HALVINGS && reach > enough && gap - reach < least - enough {
                    open.extend(quarters(&part).map(|quarter| (quarter, halved + 1)));
                }
            }
        }
        found
    }
}

/// The four parts of a part between its corners and the centres of its edges.
fn quarters(part: &Part) -> [Part; 4] {
    let [a, b, c] = *part;
    let middle = |p: [f64; 2], q: [f64; 2]| [0, 1].map(|d| (p[d] + q[d]) / 2.0);
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::contact::shape::Shape;
    use crate::mesh::Order;
    use crate::mesh::structured::block;
    use std::cell::Cell;

    /// The depth that is found for the two facets of 5 mm under a cube and a plate with its centre at the height `z` \[m\], and how many distances were
    /// computed.
    fn on_plate(half: Vec3, z: f64) -> (Option<f64>, usize) {
        let mesh = block(1, 1, 1, 5e-3, 5e-3, 5e-3, Order::Linear);
        let facets = PressingFacets { facets: mesh.regions["zmin"].facets.clone(), most: MOST * 2.0 * half.min() };
        let (plate, count) = (Shape::cuboid(half), Cell::new(0));
        let distance = |at: &Vec3| {
            count.set(count.get() + 1);
            plate.gap(&(at - Vec3::new(2.5e-3, 2.5e-3, z)))
        };
        let found = facets.search(&mesh, &vec![0.0; 3 * mesh.points.len()], 0.0, distance);
        (found.map(|f| f.1), count.get())
    }

    #[test]
    fn a_facet_that_lies_on_a_thin_obstacle_is_searched_within_a_bound() {
        for thickness in [1e-3, 1e-4, 2e-5] {
            let (found, count) = on_plate(Vec3::new(0.05, 0.05, thickness / 2.0), -thickness / 2.0);
            assert_eq!(found, None, "{thickness}");
            assert!(count <= 2 * 5461, "{thickness}: {count}");
        }
    }

    #[test]
    fn the_edge_of_a_thin_obstacle_is_found_within_a_facet() {
        let (found, _) = on_plate(Vec3::new(5e-5, 0.05, 0.05), 0.0);
        assert!(found.is_some_and(|depth| (2e-5..=5e-5).contains(&depth)), "{found:?}");
    }
}
