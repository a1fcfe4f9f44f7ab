//! Volumes, areas, normals and sizes of a mesh in its reference configuration.

use super::element::{CELL_EDGES, cell_gradients, cell_shape, facet_gradients, facet_shape};
use super::{Order, Region, TetMesh, quadrature};
use crate::math::sparse::SymPattern;
use crate::math::tensor::{Mat3, Vec3};

impl TetMesh {
    /// Returns the position X(ξ) in cell `c` \[m\].
    pub fn position(&self, c: usize, xi: [f64; 3]) -> Vec3 {
        let n = cell_shape(self.order, xi);
        self.cell(c).iter().zip(n).map(|(&i, n)| self.points[i as usize] * n).sum()
    }

    /// Returns ∂X/∂ξ in cell `c` \[m\]; column j is the derivative with respect to ξ_j.
    pub fn jacobian(&self, c: usize, xi: [f64; 3]) -> Mat3 {
        let g = cell_gradients(self.order, xi);
        let mut jacobian = Mat3::zeros();
        for (&i, g) in self.cell(c).iter().zip(g) {
            jacobian += self.points[i as usize] * nalgebra::RowVector3::from(g);
        }
        jacobian
    }

    /// Returns the volume of cell `c` \[m³\]; det ∂X/∂ξ has degree 3 on tet10, so that the rule is exact.
    pub fn cell_volume(&self, c: usize) -> f64 {
        match self.order {
            Order::Linear => self.jacobian(c, [0.0; 3]).determinant() / 6.0,
            Order::Quadratic => {
                let rule = quadrature::tet(3);
                rule.points.iter().zip(&rule.weights).map(|(&p, w)| w * self.jacobian(c, p).determinant()).sum()
            }
        }
    }

    /// Volume of the body \[m³\].
    pub fn volume(&self) -> f64 {
        (0..self.cell_count()).map(|c| self.cell_volume(c)).sum()
    }

    /// Volume of the cells of a region \[m³\].
    pub fn region_volume(&self, cells: &[u32]) -> f64 {
        cells.iter().map(|&c| self.cell_volume(c as usize)).sum()
    }

    /// Volume of the cells of a region, or without cells that which its facets enclose \[m³\]: ⅓ |∫ (X − X₀)·n dA| over a closed surface, with X₀ on it so that
    /// no digits are lost far from the origin. The rule is exact on curved facets, whose integrand has degree 4.
    pub fn volume_of(&self, region: &Region) -> f64 {
        let Some(&first) = region.facets.first().filter(|_| region.cells.is_empty()) else {
            return self.region_volume(&region.cells);
        };
        let rule = quadrature::tri(4);
        let origin = self.points[self.facet(first as usize)[0] as usize];
        let at = |f: usize, xi: [f64; 2]| -> Vec3 {
            let n = facet_shape(self.order, xi);
            self.facet(f).iter().zip(n).map(|(&i, n)| self.points[i as usize] * n).sum()
        };
        let of = |f: &u32| -> f64 {
            let f = *f as usize;
            rule.points
                .iter()
                .zip(&rule.weights)
                .map(|(&p, w)| w * (at(f, p) - origin).dot(&self.facet_normal(f, p)))
                .sum()
        };
        (region.facets.iter().map(of).sum::<f64>() / 3.0).abs()
    }

    /// Returns the normal times the surface element, ∂X/∂ξ × ∂X/∂η, of facet `f` at `xi` \[m²\]; the integral is the weighted sum over a triangle
    /// rule.
    pub fn facet_normal(&self, f: usize, xi: [f64; 2]) -> Vec3 {
        let g = facet_gradients(self.order, xi);
        let (mut a, mut b) = (Vec3::zeros(), Vec3::zeros());
        for (&i, g) in self.facet(f).iter().zip(g) {
            a += self.points[i as usize] * g[0];
            b += self.points[i as usize] * g[1];
        }
        a.cross(&b)
    }

    /// Returns the area of facet `f` \[m²\]; curved facets use the degree-4 rule.
    pub fn facet_area(&self, f: usize) -> f64 {
        let rule = quadrature::tri(if self.order == Order::Linear { 1 } else { 4 });
        rule.points.iter().zip(&rule.weights).map(|(&p, w)| w * self.facet_normal(f, p).norm()).sum()
    }

    /// Area of the facets of a region \[m²\].
    pub fn region_area(&self, facets: &[u32]) -> f64 {
        facets.iter().map(|&f| self.facet_area(f as usize)).sum()
    }

    /// Returns (node, ∫ N_i dA \[m²\]) over facets; the degree-4 rule is exact on straight facets and has the error of the area on curved ones.
    pub fn nodal_areas(&self, facets: &[u32]) -> Vec<(u32, f64)> {
        let rule = quadrature::tri(4);
        let mut nodal = vec![0.0; self.points.len()];
        for &f in facets {
            for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                let area = w * self.facet_normal(f as usize, xi).norm();
                for (&node, n) in self.facet(f as usize).iter().zip(facet_shape(self.order, xi)) {
                    nodal[node as usize] += area * n;
                }
            }
        }
        (0..).zip(nodal).filter(|(_, w)| *w != 0.0).collect()
    }

    /// Returns the mean cell size h = (V/N)^{1/3} \[m\].
    pub fn h(&self) -> f64 {
        (self.volume() / self.cell_count() as f64).cbrt()
    }

    /// Returns the graph of the corners, whose pairs are the edges of the cells.
    pub fn edges(&self) -> SymPattern {
        let of_cell = |c| CELL_EDGES.map(|[i, j]| (self.cell(c)[i], self.cell(c)[j]));
        SymPattern::from_pairs(self.points.len(), (0..self.cell_count()).flat_map(of_cell))
    }

    /// Mean length of the edges between corners \[m\].
    pub fn mean_edge(&self) -> f64 {
        let graph = self.edges();
        let edges = || graph.entries().filter(|(i, j)| i != j);
        edges().map(|(i, j)| (self.points[j] - self.points[i]).norm()).sum::<f64>() / edges().count() as f64
    }

    /// Returns the mean extents of the cells along x, y and z, and their mean longest edge \[m\], from their corners. Axes that are not `counted` are
    /// ignored in both.
    pub fn mean_extents(&self, counted: [bool; 3]) -> [f64; 4] {
        let mut sums = [0.0; 4];
        for c in 0..self.cell_count() {
            let corner = |k: usize| self.points[self.cell(c)[k] as usize];
            let corners = [0, 1, 2, 3].map(|k| Vec3::from_fn(|d, _| if counted[d] { corner(k)[d] } else { 0.0 }));
            let (low, high) = bounds(corners.iter().copied());
            (0..3).for_each(|d| sums[d] += high[d] - low[d]);
            sums[3] += CELL_EDGES.iter().map(|[i, j]| (corners[*j] - corners[*i]).norm()).fold(0.0, f64::max);
        }
        sums.map(|sum| sum / self.cell_count() as f64)
    }

    /// Returns the smallest and the largest coordinates of the nodes \[m\].
    pub fn bounding_box(&self) -> (Vec3, Vec3) {
        bounds(self.points.iter().copied())
    }

    /// Length of the bounding box's diagonal \[m\].
    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounding_box();
        (high - low).norm()
    }
}

/// Bounding box of points: (smallest, largest) coordinates.
pub(super) fn bounds(points: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    points.fold(start, |(low, high), p| (low.inf(&p), high.sup(&p)))
}
